"""Tests that captions and tables state nothing that a run does not have: a ground, run-ins, a
passage that has ended."""
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest
import test_postproc
from trackbed_post import (bed_on_ground, bed_warnings, measures, passage_warnings, read, support,
                           support_figure, write)


def until(run, time):
    """The run, stopped at a time after its passage began, with what is written up to then."""
    rows = slice(0, int(np.searchsorted(run.time, run.time[run.passage()][0] + time)))

    def cut(group):
        return {name: dataclasses.replace(one, values=one.values[rows])
                for name, one in group.items()}
    return dataclasses.replace(run, time=run.time[rows], stage=run.stage[rows],
                               sleeper=cut(run.sleeper), wheel=cut(run.wheel),
                               energy=cut(run.energy), sleeper_envelope={}, ground_envelope={},
                               regions={name: cut(one) for name, one in run.regions.items()},
                               sensors={name: cut(one) for name, one in run.sensors.items()})


def test_a_bed_on_a_rigid_floor_has_no_ground_in_its_texts(runs):
    moved = runs[0].sleeper["displacement"].values.copy()
    moved[-1, 4] -= 5e-3
    bare = dataclasses.replace(
        runs[0], ground_x=np.empty(0), ground={}, ground_envelope={},
        deck={**runs[0].deck, "ground": {"present": False}},
        sleeper={**runs[0].sleeper, "displacement": read.Quantity(moved, "m", "-")})
    assert measures.why_no_envelope(bare) == "wedge has no ground"
    line, = measures.warnings(bare)
    assert "upwards (limit" in line.replace("downwards", "upwards") and "ground" not in line
    for run, there in ((bare, False), (runs[0], True)):
        loops, stiff, _ = support_figure.draw([run]).axes
        words = [loops.get_xlabel(), stiff.get_title(),
                 *(text.get_text() for text in stiff.get_legend().texts)]
        assert any("ground" in one for one in words) == there
    assert "Secants from the first row" in stiff.get_title()  # no train on a rail
    plt.close("all")


def test_a_passage_that_has_not_ended_has_no_residual_displacement(runs, tmp_path):
    # The last of four axles, 10.5 m behind the first, passes the last sleeper, 8.7 m, at 0.96 s.
    assert measures.train_has_left(runs[0]) and measures.train_has_left(until(runs[0], 1.0))
    early = until(runs[0], 0.9)
    assert not measures.train_has_left(early) and measures.warnings(runs[0]) == []
    assert measures.why_no_envelope(early) == \
        "wedge has no envelopes yet, as its passage has not ended"
    assert early.sleeper["displacement"].values[-1] == pytest.approx(
        1e-3 * np.sin(4 * np.pi * early.time[-1]))
    low = early.sleeper["displacement"].values - 5e-3 * (early.stage == 4)[:, None] * (
        np.arange(len(early.time)) == len(early.time) - 1)[:, None]
    early = dataclasses.replace(early, sleeper={
        **early.sleeper, "displacement": read.Quantity(low, "m", "-")})
    assert not measures.warnings(early)
    one, = bed_warnings.of(early)
    assert "the train has not left the bed in the last row of the histories, at 0.999 s" in one
    assert "in the unfinished passage, wedge:" in support.summary(early)
    made = write.Folder(tmp_path)
    bed_on_ground.draw_all([early], made)
    assert "wedge: the train has not left the bed" in made.tables[0]
    assert "sleepers hang" not in made.tables[0] and "stones were rearranged" not in made.tables[0]
    plt.close("all")


@pytest.mark.parametrize("time, left", [(0.1, False), (1.5, False), (1.9, True)])
def test_a_train_on_a_rail_has_left_when_its_last_axle_has_passed(runs, time, left):
    # 24.8 m behind the first axle, which is at x = 2 m when the passage begins: 1.58 s.
    run = until(test_postproc.with_train(runs[0], test_postproc.WAGONS, 2), time)
    assert measures.train_has_left(run) == left


def test_loads_from_a_table_and_other_stages_are_over(runs):
    early = until(runs[0], 0.1)
    assert not measures.train_has_left(early)
    for change in ({"load": {**early.deck["load"], "kind": "table"}},
                   {"stage": [{**one, "cycles": 3} for one in early.deck["stage"]]},
                   {"stage": [{**one, "kind": "load"} for one in early.deck["stage"]]}):
        assert measures.train_has_left(dataclasses.replace(early, deck=early.deck | change))


@pytest.mark.parametrize("track, named", [({"run_in": 5.0}, True), ({"run_in": 0.0}, False),
                                          ({"run_in": 5.0, "support": "none"}, False)])
def test_run_ins_are_named_where_a_track_has_them(track, named):
    x = np.linspace(0, 20, 101)[:, None]
    every = {"history/wheel/x": x, "history/wheel/force": np.where(x > 10, 0, 5e4),
             "history/time": np.arange(101.0)}
    every = {name: read.Quantity(values, "", "") for name, values in every.items()}
    text, = passage_warnings.of_track(every, {"track": {"length": 20.0, **track}}, {})
    assert ("run-ins included" in text) == named
    assert "of the time of all wheels on the track" in text
