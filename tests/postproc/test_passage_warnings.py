"""Tests of passage_warnings.py: wheels off the rail, and rail pads in tension."""
import dataclasses
import json

import conftest
import made
import numpy as np
import pytest
from test_report import Page
from trackbed_post import bed_on_ground, passage_warnings, read, write


def below_train(run, **sleeper):
    """The run with springs beside its bed and two axles of 50 kN 2 m apart at made.SPEED."""
    stages = [dict(stage, train=stage["kind"] == "passage", seat_force=1e3)
              for stage in run.deck["stage"]]
    x = made.SPEED * (run.time - run.time[run.passage()][0])[:, None] - np.array([0.0, 2.0])
    return dataclasses.replace(
        run, deck={**run.deck, "stage": stages},
        wheel={"x": read.Quantity(x, "m", "-"),
               "force": read.Quantity(np.full(x.shape, 50e3), "N", "-")},
        sleeper={**run.sleeper, **{name: read.Quantity(values, "N", "-")
                                   for name, values in sleeper.items()}})


def test_a_sound_passage_has_no_warning(runs):
    assert passage_warnings.of_bed(below_train(runs[0])) == []
    assert passage_warnings.of_bed(runs[0]) == [], "no train"


def test_a_wheel_that_is_off_the_rail_in_few_rows_is_stated(runs, tmp_path):
    run = below_train(runs[0])
    x, force = run.wheel["x"].values, run.wheel["force"].values
    force[(x[:, 0] > 5.005) & (x[:, 0] < 5.105), 0] = 0  # rows 0.02 m apart: 5 of them
    force[x[:, 0] < 0.2] = 0                             # beside the bed: does not count
    there = ((x >= 0.3) & (x <= 8.7)).any(axis=1)
    rows = np.count_nonzero(there[run.passage()])
    one, = passage_warnings.of_bed(run)
    assert one.startswith(f"a wheel is off the rail in {100 * 5 / rows:.2g} % of the rows")
    assert "at x = 5.02 m to 5.10 m" in one and "passage.step" in one
    folder = write.Folder(tmp_path)
    bed_on_ground.draw_all([run], folder)
    assert folder.tables[0].count(f"warning: wedge: {one}") == 1


def test_a_run_with_a_wheel_off_the_rail_has_no_verdict(runs):
    run = below_train(runs[0])
    assert "off the rail" not in passage_warnings.why_no_verdict([("wedge", run)])
    run.wheel["force"].values[run.wheel["x"].values > 5] = 0
    why = passage_warnings.why_no_verdict([("wedge", run), ("other", below_train(runs[1]))])
    assert why.endswith("; a wheel is off the rail (run wedge)")


def test_only_the_last_train_counts_and_a_run_may_have_no_row_yet(runs, tmp_path):
    run = below_train(runs[0])
    x, force = run.wheel["x"].values, run.wheel["force"].values
    first = np.arange(len(x)) < len(x) // 2
    x[~first] = x[first][:np.count_nonzero(~first)]  # the second one as the first one
    force[first] = 0
    assert passage_warnings.of_bed(run) == []
    force[~first] = 0
    assert passage_warnings.of_bed(run)[0].startswith("a wheel is off the rail in 100 % of")
    every = {f"history/{name}": read.Quantity(np.empty(0), "", "") for name in (
        "time", "wheel/x", "wheel/force")}
    assert passage_warnings.of_track(every, {"track": {"length": 20.0}}, {}) == []


def pulled(run, least):
    """Loads of seats up to 20 kN, of one `least`, N, down; up positive as in the file."""
    load = np.repeat(20e3 * np.sin(np.pi * np.clip(run.time, 0, 1))[:, None],
                     len(run.sleepers_x), axis=1)
    load[-1, 7] = least
    return -load


@pytest.mark.parametrize("least, words", [
    (-1.9e3, ""), (-3.0e3, "at 1 of 9 seats, most at x = 4.50 m by 3.0 kN, 15.0% of the load of a "
                           "seat below a wheel, 20.0 kN (limit 10%)")])
def test_pads_in_tension_are_warned_of_once(runs, least, words):
    run = below_train(runs[0], seat_force=pulled(runs[0], least))
    found = passage_warnings.of_bed(run)
    assert len(found) == bool(words) and all(
        words in one and one.endswith("if these are as meant, give stage load a larger load, or "
                                      "cycles instead of a single ramp") for one in found)


def test_pads_of_two_rails_carry_the_weight_of_rails_and_fastenings(runs):
    run = below_train(runs[0])
    pads = np.repeat(-pulled(run, 0.0), 2, axis=1) - 0.5e3
    for least, warned in ((-2.4e3, 0), (-2.6e3, 1)):
        pads[-1, 9] = least  # the right seat of the fifth sleeper, with 0.5 kN of weight
        found = passage_warnings.of_bed(dataclasses.replace(
            run, seat={"force": read.Quantity(pads, "N", "-")}))
        assert len(found) == warned
    assert "at 1 of 18 seats, most at x = 2.70 m by 2.1 kN" in found[0]


def track(folder, least, lost=0, uplift="false", rows_off=0, model="track"):
    """A track of 20 m between run-ins of 2 m; 400 rows of one wheel of 50 kN at 20 m/s."""
    folder.mkdir()
    time = np.arange(0.0, 1.0, 2.5e-3)[:, None]
    x, force = 20 * time, np.full_like(time, 50e3)
    force[200:200 + rows_off] = 0
    places = np.arange(1.0, 20.0, 1.0)
    low = np.where(places == 9, least, -1e3)
    low[[0, -1]] = -9e3  # in the run-ins
    made.store(folder / "results.h5", {
        "history/time": (time[:, 0], "s"), "history/wheel/x": (x, "m"),
        "history/wheel/force": (force, "N"), "envelope/x": (places, "m"),
        "envelope/rail/displacement_min": (-1e-3 + 0 * places, "m"),
        "envelope/rail/displacement_max": (0 * places, "m"),
        "envelope/sleeper/displacement_min": (-1e-3 + 0 * places, "m"),
        "envelope/sleeper/displacement_max": (0 * places, "m"),
        "envelope/sleeper/seat_force_min": (low, "N"),
        "envelope/sleeper/seat_force_max": (20e3 + 0 * places, "N")},
        deck=f'model = "{model}"\n[track]\nlength = 20.0\nrun_in = 2.0\n[pad]\nuplift = '
             f'{uplift}\n[passage]\nstep = 2.5e-4\n', version="0.1.0", build="-", ranks=1)
    (folder / "summary.json").write_text(json.dumps({
        "deck": "a.toml", "model": model, "finished": True, "ranks": 1, "simulated_time_s": 1.0,
        "wall_time_s": 1.0, "memory_mb_per_rank": 1.0,
        "track": {"wheel_steps_off_rail": lost}}), encoding="utf-8")
    return folder


def test_a_track_states_the_share_of_all_steps(tmp_path):
    few = track(tmp_path / "few", 0.0, lost=8, rows_off=2)
    ran = conftest.call("figures", few, "-o", tmp_path / "out")
    assert ran.returncode == 0, ran.stderr
    text = (tmp_path / "out/track.txt").read_text(encoding="utf-8")
    # 8 of 4000 steps on the track: table and warning state the same part of the same time.
    time = "the time of all wheels on the track, run-ins included"
    assert f"warning: few: wheels are off the rail in 0.2 % of {time}; at x = 10.00 m to" in text
    row, = (line for line in text.splitlines() if line.startswith("wheels off the rail"))
    assert row.split() == f"wheels off the rail, part of {time} 0.2 %".split()
    between, = passage_warnings.of_folder(track(tmp_path / "between", 0.0, lost=3))
    assert "0.075 %" in between and "between the rows of the histories" in between
    (few / "summary.json").unlink()
    assert "in 0.5 % of the time of all wheels" in passage_warnings.of_folder(few)[0]
    assert passage_warnings.of_folder(track(tmp_path / "never", 0.0)) == []


def test_pads_of_a_track_are_in_the_report(tmp_path):
    folder = track(tmp_path / "pulled", -4e3)
    page = tmp_path / "report.html"
    assert conftest.call("report", folder, "-o", page).returncode == 0
    found = [text for text in Page(page.read_text(encoding="utf-8")).text["p"] if "tension" in text]
    assert len(found) == 1 and "pulled: rail pads are in tension at 1 of 17 seats, most at x = " \
        "9.00 m by 4.0 kN, 20.0% of the load" in found[0] and "pad.uplift = true" in found[0]
    assert passage_warnings.of_folder(track(tmp_path / "open", -4e3, uplift="true")) == []
    one, = passage_warnings.of_folder(track(tmp_path / "ground", -4e3, model="track_on_ground"))
    assert "pad.uplift" not in one
