"""Tests that rail and ground have one definition of plain track."""
import copy
import dataclasses

import numpy as np
import pytest
from trackbed_post import bed_on_ground, ground_blocks, ground_transition, read, zones

EDGE = 4.0


def with_rail(run, reached=5.0):
    """The run without wedge behind a structure up to EDGE, with a train on a rail whose lowest
    level changes from 0.2 mm on the structure to 1 mm at `reached`; the ground changes within less
    than a spacing."""
    deck = copy.deepcopy(run.deck)
    block = deck["ground"]["block"][0]
    block["outline"] = [0.0, 0.0, EDGE, 0.0, EDGE, -2.0, 0.0, -2.0]
    deck["ground"]["block"] = [block]
    for stage in deck["stage"]:
        stage["train"] = stage["kind"] == "passage"
    down = np.interp(run.sleepers_x, [EDGE, reached], [0.2e-3, 1e-3])
    level = np.zeros((len(run.time), len(down)))
    level[-50] = -down
    ground = -np.where(run.ground_x > EDGE + 0.01, 2e-3, 0.02e-3)
    return dataclasses.replace(
        run, deck=deck, rail={"displacement": read.Quantity(level, "m", "-")},
        ground_envelope={**run.ground_envelope,
                         "displacement_min": read.Quantity(ground, "m", "-")})


def rows_of(text):
    return {line[:52].strip(): line.split()[-1] for line in text.splitlines() if line}


def test_plain_track_of_the_ground_begins_where_that_of_the_rail_does(runs):
    run = with_rail(runs[1])
    # Between the sleepers at 4.5 and 5.1 m the level reaches 0.92 mm at 4.98 m.
    assert zones.changing([run]) == pytest.approx(0.98)
    found = ground_transition.transition(run)
    zone = zones.zone_of(run, zones.changing([run]))
    plain = run.sleepers_x[zone.plain]
    assert plain[[0, -1]] == pytest.approx([6.3, 6.9])
    assert (found.plain_begin, found.plain_end) == pytest.approx((6.3, 6.9))
    rows = rows_of(ground_transition.table([run]))
    assert (rows["which begins at x ="], rows["and ends at x ="]) == ("6.3", "6.9")
    bare = dataclasses.replace(run, rail={})
    assert ground_transition.transition(bare).plain_begin < 6


def test_a_transition_of_the_ground_is_no_scatter(runs):
    """A slope that ends 2.4 m behind the edge, without a wedge and without a rail."""
    run = dataclasses.replace(with_rail(runs[1]), rail={})
    slope = -np.interp(run.ground_x, [2.0, 4.4], [0.02e-3, 2e-3])
    run.deck["ground"]["block"][0]["outline"] = [0, 0, 2, 0, 2, -2, 0, -2]
    for stage in run.deck["stage"]:
        stage["train"] = False
    run = dataclasses.replace(run, ground_envelope={
        **run.ground_envelope, "displacement_min": read.Quantity(slope, "m", "-")})
    found = ground_transition.transition(run)
    assert found.width == pytest.approx(2.2, abs=0.11)
    assert found.plain_begin == pytest.approx(2 + found.width + 1.2, abs=0.11)
    assert found.slope_scatter == pytest.approx(0, abs=1e-9)


def test_both_runs_share_the_longer_change_if_their_edges_are_the_same(runs):
    near, far = with_rail(runs[0], 5.0), with_rail(runs[1], 5.4)
    shared = zones.changing_of_each([near, far])
    assert shared == [max(zones.changing([near]), zones.changing([far]))] * 2
    block = far.deck["ground"]["block"][0]
    block["outline"] = [0.0, 0.0, 4.6, 0.0, 4.6, -2.0, 0.0, -2.0]
    each = zones.changing_of_each([near, far])
    assert each == [zones.changing([near]), zones.changing([far])] and each[0] != each[1]


def test_a_level_that_is_never_reached_ends_the_search(runs):
    run = with_rail(runs[1], 60.0)
    assert np.isfinite(zones.changing([run]))
    assert ground_transition.transition(run) is not None


def test_a_bed_between_walls_leaves_out_one_sleeper_at_each_end(runs):
    """As the warnings do, whose numbers of sleepers in all parts add up."""
    run = dataclasses.replace(with_rail(runs[1]), rail={})
    for stage in run.deck["stage"]:
        stage["train"] = False
    zone = zones.zone_of(run, zones.changing([run]))
    counted = sum(part.astype(int) for part in zone.parts.values())
    assert counted.tolist() == (~ground_blocks.ends(run)).astype(int).tolist()
    assert counted.sum() == len(run.sleepers_x) - 2


def test_each_sleeper_is_in_one_part(runs):
    run = with_rail(runs[1])
    zone = zones.zone_of(run, zones.changing([run]))
    assert list(zone.parts) == ["on the structure", "in the transition", "on plain track"]
    counted = sum(part.astype(int) for part in zone.parts.values())
    assert counted[3:-3].tolist() == [1] * 9 and counted.sum() == 9


def in_short(pair):
    return bed_on_ground.effects(pair, "")


def test_the_report_has_the_sentences_of_the_table(runs):
    """The ground of the second run changes farther than the wedge is long."""
    pair = [dataclasses.replace(run, rail={}, ground_envelope={
        **run.ground_envelope, "displacement_min": read.Quantity(
            -np.interp(run.ground_x, [2.0, reached], [0.02e-3, 2e-3]), "m", "-")})
            for run, reached in zip(runs, (4.0, 6.5))]
    lines = in_short(pair)
    assert len(lines) == 6
    assert ground_transition.table(pair).splitlines()[-6:] == lines


def test_the_report_compares_no_places_that_differ(runs):
    far = copy.deepcopy(runs[1])
    for block in far.deck["ground"]["block"]:
        block["outline"] = [x + 1.2 if k % 2 == 0 and x > 0 else x
                            for k, x in enumerate(block["outline"])]
    line, = in_short([runs[0], far])
    assert line.startswith("no comparison: the transitions of both runs are not at the same place")
    assert line in ground_transition.table([runs[0], far])
