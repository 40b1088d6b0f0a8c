"""Tests of transition.py on synthetic levels with known results."""
import copy
import dataclasses
import types

import matplotlib.pyplot as plt
import numpy as np
import pytest
from trackbed_post import (model_drawing, read, transition, transition_caption,
                           transition_figures, transition_verdict, zones)

X = 0.6 * np.arange(1, 31)


def train(end_of_wedge, plain=1e-3, force=60e3, wedge_present=True):
    """A rail that sinks by 0.4 mm on a structure up to x = 4.8 m and by `plain` beyond
    `end_of_wedge`, linear between the two; the levels of the first and last sleeper are off by a
    millimetre. Two axles of constant force."""
    down = np.interp(X, [4.8, end_of_wedge], [0.4e-3, plain])
    down[[0, -1]] += 1e-3
    outline = [4.8, 0.0, 9.0, 0.0, 9.0, -0.6, 4.8, -0.6]
    deck = {"sleepers": {"spacing": 0.6}, "train": {"speed": 40.0}, "stage": [
        {"name": "train", "kind": "passage", "train": True}], "ground": {"block": [
        {"name": "structure", "outline": [0.0, 0.0, 4.8, 0.0, 4.8, -3.0, 0.0, -3.0], "young": 1e10},
        {"name": "wedge", "outline": outline, "present": wedge_present, "young": 1e9}]}}
    level = -np.stack([np.zeros_like(X), down, np.zeros_like(X)])
    displacement, ground_x = level - [[0], [0], [1e-4]], np.linspace(0, 18.6, 190)
    run = types.SimpleNamespace(
        name="made", deck=deck, sleepers_x=X, ground_x=ground_x, passage=lambda: slice(0, 3),
        has_passage=lambda: True, asks_for_passage=lambda: False, time=np.arange(3.0),
        rail={"displacement": types.SimpleNamespace(values=level)}, wheel={}, ground_envelope={},
        sleeper={"displacement": types.SimpleNamespace(values=displacement)},
        ground={"displacement": types.SimpleNamespace(values=np.zeros((3, len(ground_x))))})
    way = np.linspace(-3, 22, 400)
    wheels = np.stack([way, way - 2], axis=1)
    passing = types.SimpleNamespace(
        rail=level, displacement=displacement, x=wheels, force=np.full((400, 2, 1), force),
        first=0, time=np.arange(3.0), left=displacement[-1] - displacement[0],
        on_bed=lambda: (wheels >= X[0]) & (wheels <= X[-1]))
    return transition.Train(run, passing, "made")


def stated(*trains):
    return transition_verdict.verdict(transition.named(trains), transition.changes_of(trains))


def test_levels_and_length():
    found = transition.changes_of([train(7.8)])[0]
    assert found.structure == pytest.approx(0.4e-3)
    assert found.plain == pytest.approx(1e-3)
    assert found.width == pytest.approx(0.9 * 3.0)
    assert found.steepest == pytest.approx(0.2e-3)
    assert found.scatter == pytest.approx(0, abs=1e-12), "sleepers at the end are not judged"
    assert found.force == pytest.approx(60e3)


def test_the_sleepers_have_a_distance_of_their_own():
    one = train(7.8)
    one.passing.displacement[1, (X > 4.8) & (X < 17)] = -1e-3
    found = transition.changes_of([one])[0]
    assert found.width == pytest.approx(0.9 * 3.0)
    assert found.sleeper_width == pytest.approx(0.9 * 0.6)
    assert "the same distance for the level of the sleepers, m" in transition.table([one], [found])


def test_places_are_stated():
    first, second = train(7.8), train(5.4, wedge_present=False)
    near = np.abs(second.passing.x - 6.9) < 0.05
    second.passing.force[near] = 62e3
    now, other = transition.changes_of([first, second])
    assert other.steepest_x == pytest.approx(5.1) and other.steepest_behind == pytest.approx(0.3)
    assert other.force_x == pytest.approx(6.9, abs=0.1)
    assert other.force_behind == pytest.approx(2.1, abs=0.1)
    assert (now.plain_begin, now.plain_end) == pytest.approx((10.2, 16.2))
    text = stated(first, second)
    assert "instead of 1.0 mm/m, 0.3 m behind the structure" in text
    there = second.passing.force[..., 0] == 62e3
    assert other.force_x in second.passing.x[there], "no row has the largest force there"
    assert f"instead of 62.0 kN, {other.force_behind:.1f} m behind the structure" in text
    assert "x = " not in text, "only distances"
    assert "up to 60.0 and 60.0 kN; on the structure they reach 60.0 and 60.0 kN" in text


@pytest.mark.parametrize("force, words", [
    (62e3, "It is not clearly larger than forces on plain track"),
    (80e3, "Without wedge, it is clearly larger than forces on plain track")])
def test_wheel_forces_are_judged_beside_those_of_plain_track(force, words):
    first, second = train(7.8), train(5.4, wedge_present=False)
    second.passing.force[np.abs(second.passing.x - 6.9) < 0.05] = force
    assert words in stated(first, second)


def test_a_ripple_all_over_the_bed_is_no_effect_of_the_transition():
    first, second = train(7.8), train(5.4, wedge_present=False)
    for one, place, force in ((first, 14.0, 82e3), (second, 6.9, 80e3)):
        one.passing.force[np.abs(one.passing.x - place) < 0.05] = force
    second.passing.force[np.abs(second.passing.x - 13.0) < 0.05] = 72e3
    text = stated(first, second)
    assert "is not larger than the scatter on plain track, 22 kN)" in text
    assert "such forces occur along the whole bed" in text


def test_sleepers_of_each_part_are_in_brackets():
    pair = transition.named([train(7.8), train(5.4, wedge_present=False)])
    changes = transition.changes_of(pair)
    figure, (force, level) = plt.subplots(2)
    transition_figures.bracket_zones(level, pair[0], changes[0].zone)
    transition_figures.mark_places(force, level, pair, changes)
    assert [text.get_text() for text in level.texts] == ["structure", "transition", "plain track"]
    assert level.lines[2].get_xdata()[[0, -1]] == pytest.approx([10.2 + 0.06, 16.2 - 0.06])
    assert level.lines[4].get_xdata() == pytest.approx([4.8, 5.4])
    plt.close(figure)


def test_the_model_is_enlarged_around_the_transition():
    """Not at the end of the bed, where a contact force may be larger."""
    one = train(7.8)
    span = transition_figures.span_of_interest(one.run)
    assert span == pytest.approx((4.8 - 2, 9.0 + 2))
    x = np.array([3.0, 9.0, 17.0])
    lines = np.stack([np.stack([x, x + 0.04], axis=1), np.zeros((3, 2))], axis=2)
    chains = model_drawing.Chains(lines, np.array([10e3, 20e3, 30e3]))
    assert transition_figures.largest_contact(chains, span) == pytest.approx((20e3, 9.02))
    none = model_drawing.Chains(lines[:0], np.zeros(0))
    assert transition_figures.largest_contact(none, span)[0] == 0


def test_force_is_that_of_the_transition():
    one = train(7.8)
    one.passing.force[one.passing.x[:, 0] < 4] = 90e3
    one.passing.force[:, 1] = 60e3
    found = transition.changes_of([one])[0]
    assert found.force == pytest.approx(60e3) and 4.2 < found.force_x < 10.2


def test_each_space_between_sleepers_belongs_to_one_part():
    one = train(7.8)
    # The largest force and the steepest change are just before the edge of the structure: a wheel
    # there is on the structure, the space up to the first sleeper behind it in the transition.
    one.passing.force[np.abs(one.passing.x - 4.5) < 0.05] = 70e3
    one.passing.rail[1, X < 4.5] = 0
    found = transition.changes_of([one])[0]
    assert found.force == pytest.approx(60e3) and found.force_behind >= 0
    assert found.force_structure == pytest.approx(70e3)
    assert found.steepest_x == pytest.approx(4.5)
    zone = found.zone
    assert [X[part][[0, -1]].round(1).tolist() for part in (
        zone.structure, zone.transition, zone.plain)] == [[2.4, 4.2], [4.2, 10.2], [10.2, 16.2]]


def test_plain_track_begins_where_the_change_is_reached():
    """A slope that ends 3 m behind the wedge is no scatter of plain track."""
    found = transition.changes_of([train(12.0)])[0]
    assert found.width == pytest.approx(0.9 * 7.2)
    assert found.plain_begin == pytest.approx(12.6) and found.scatter == pytest.approx(0, abs=1e-9)


def test_a_part_of_the_wedge_that_stays_is_named():
    first, second = train(7.8), train(5.4, wedge_present=False)
    for one in (first, second):
        one.run.deck["ground"]["block"].append(
            {"name": "top", "outline": [4.8, 0.0, 9.0, 0.0, 9.0, -0.2, 4.8, -0.2], "young": 1e9})
    text = transition_verdict.beside_structure(second.run)
    assert "Both runs have top beside the structure: if that belongs to the wedge" in text
    assert transition_verdict.beside_structure(train(5.4, wedge_present=False).run) == ""


def test_a_cell_that_was_moved_is_the_same():
    first, second = train(7.8), train(5.4, wedge_present=False)
    for one, cell in ((first, "/one/cell"), (second, "/other/cell")):
        one.run.deck["bed"] = {"cell": cell, "height": 0.3}
    assert "No verdict" not in stated(first, second)
    second.run.deck["bed"] = {"cell": "/other/cell_2", "height": 0.4}
    assert "differ in bed.cell, bed.height, not only in the wedge" in stated(first, second)


def test_a_profile_of_another_copy_of_the_project_is_the_same(tmp_path):
    first, second = train(7.8), train(5.4, wedge_present=False)
    paths = [tmp_path / name / "profile.csv" for name in ("one", "other")]
    for one, path in zip((first, second), paths):
        path.parent.mkdir()
        path.write_text("x_m,z_m", encoding="utf-8")
        one.run.deck["irregularity"] = {"file": str(path)}
    assert "No verdict" not in stated(first, second)
    paths[1].write_text("x_m,z_mm", encoding="utf-8")
    assert "differ in irregularity.file, not only in the wedge" in stated(first, second)


def test_verdict_names_what_changes_clearly():
    text = stated(train(7.8), train(5.4, wedge_present=False))
    assert text.startswith(
        "With the wedge the rail reaches 90% of its change from structure to plain track 2.7 m "
        "behind the structure instead of 0.5 m, and the steepest part of the change is 80% less "
        "steep: as expected of a wedge. ")
    assert text.count("expected") == 2
    assert ("90% of it is reached. The distances differ by 2.2 m; a difference above one sleeper "
            "spacing, 0.6 m, counts as clear. The steepest change") in text
    assert ("This difference, 0.80 mm/m, exceeds the steepest change on plain track, 0.0 mm/m, "
            "where only the stones vary.") in text
    assert "between two sleepers is 0.20 mm/m, 1.5 m behind the structure, instead of 1.0" in text
    assert "the structure: no clear effect (within 10%)" in text


def with_scatter(train, scatter):
    """The train over a bed with one sleeper of plain track that is lower than its neighbours by
    this much per metre."""
    train.passing.rail[1, 20] -= 0.6 * scatter
    return train


def test_two_measures_that_differ_have_verdicts_of_their_own():
    text = stated(*(with_scatter(one, 0.9e-3) for one in (
        train(7.8), train(5.4, wedge_present=False))))
    assert text.startswith(
        "With the wedge the rail reaches 90% of its change from structure to plain track 2.7 m "
        "behind the structure instead of 0.5 m: as expected of a wedge; the steepest part of the "
        "change is 80% less steep: no clear effect. ")
    assert "0.20 mm/m, not larger than the scatter, instead of 1.0 mm/m, 0.3 m behind" in text


def test_no_verdict_follows_from_a_change_within_the_scatter():
    pair = [with_scatter(one, 2e-3) for one in (train(7.8), train(5.4, wedge_present=False))]
    for one in pair:
        one.passing.displacement[1] = one.passing.rail[1]
    text = stated(*pair)
    assert ("the longer distance is as expected of a wedge, the slope is not larger than the "
            "scatter on plain track, so that no verdict follows from it. ") in text
    assert "m: as expected of a wedge; the steepest part is in neither run larger than the " \
        "scatter on plain track: no verdict from it. " in text
    assert "0.20 mm/m, not larger than the scatter, instead of 1.0 mm/m, not larger than" in text
    for given in (pair, pair[:1]):
        changes = transition.changes_of(given)
        caption = " ".join((*transition_caption.titles(given, changes, ""),
                            transition_caption.of(given, changes, "", False)))
        assert "0.20 mm/m, not larger than the scatter" in caption
        assert "0.20 mm/m, 1.5 m" not in caption


@pytest.mark.parametrize("sleepers, words", [
    ((7.8, 5.4), "both are as expected of a wedge"), ((7.8, 7.8), "neither is a clear effect"),
    ((5.4, 7.8), "both are NOT as expected of a wedge")])
def test_the_sleepers_are_judged_by_the_same_rule(sleepers, words):
    pair = [train(7.8), train(5.4, wedge_present=False)]
    for one, end in zip(pair, sleepers):
        one.passing.displacement[1] = -np.interp(X, [4.8, end], [0.4e-3, 1e-3])
    assert f": {words}. The largest wheel force" in stated(*pair)


def test_the_sleepers_distance_and_slope_may_differ():
    pair = [train(7.8), train(5.4, wedge_present=False)]
    pair[0].passing.displacement[1] = -np.interp(X, [4.8, 7.2, 7.8], [0.4e-3, 0.5e-3, 1e-3])
    pair[1].passing.displacement[1] = -np.interp(X, [4.8, 6.6], [0.4e-3, 1e-3])
    text = stated(*pair)
    assert "its steepest part is 0.83 mm/m, 2.7 m behind the structure, instead of 0.33" in text
    assert ("m behind the structure: the longer distance is as expected of a wedge, the larger "
            "slope is NOT as expected of a wedge. ") in text


def test_a_quantity_of_the_sleepers_that_is_not_known_is_no_verdict():
    pair = transition.named([train(7.8), train(5.4, wedge_present=False)])
    changes = transition.changes_of(pair)
    unknown = [dataclasses.replace(changes[0], sleeper_width=np.nan), changes[1]]
    text = transition_verdict.of_sleepers(pair, unknown, True)
    assert "since its end is not reached" in text and "nan" not in text
    assert text.endswith(": the distance is not known, the smaller slope is as expected of a "
                         "wedge.")


def test_a_change_that_is_reached_at_the_edge_has_a_verdict():
    pair = transition.named([train(7.8), train(5.4, wedge_present=False)])
    now, other = transition.changes_of(pair)
    text = transition_verdict.verdict(pair, [now, dataclasses.replace(
        other, width=0.0, sleeper_width=0.0)])
    assert ("2.7 m behind the structure instead of less than 0.1 m, and the steepest part of the "
            "change is 80% less steep: as expected of a wedge. ") in text
    assert "both are as expected of a wedge" in text and "not known" not in text


def test_each_run_is_measured_to_its_own_plain_track():
    """The second one is flat 0.06 mm above the first; only the end of its bed, beside springs, is
    lower."""
    found = transition.changes_of([train(7.8, 0.71e-3), train(5.4, 0.65e-3, wedge_present=False)])
    assert [one.width for one in found] == pytest.approx([0.9 * 3.0, 0.9 * 0.6])
    assert [one.sleeper_width for one in found] == pytest.approx([0.9 * 3.0, 0.9 * 0.6])


def test_ends_of_the_bed_are_not_searched():
    one = train(7.8)
    zone = transition.changes_of([one])[0].zone
    level = np.full(len(X), 0.4e-3)
    level[zone.plain], level[-3:] = np.nan, 5e-3
    assert np.isnan(zones.rail_width(zone, level))


def test_the_scatter_is_the_larger_one_of_both_runs():
    """The first run's steepest change exceeds its own scatter only: the text has no place of it,
    and neither has the figure."""
    first, second = train(7.8), with_scatter(train(5.4, wedge_present=False), 0.5e-3)
    pair = transition.named([first, second])
    changes = transition.changes_of(pair)
    assert transition_verdict.in_scatter(changes) == [True, False]
    figure, (force, level) = plt.subplots(2)
    transition_figures.mark_places(force, level, pair, changes)
    assert [line.get_label() for line in level.lines] == ["steepest change, without wedge"]
    plt.close(figure)
    assert "0.20 mm/m, not larger than the scatter, instead of 1.0 mm/m, 0.3 m" in stated(*pair)


def test_a_wheel_before_the_edge_is_on_the_structure():
    """Also over its end, where sleepers are neither on the structure nor behind it."""
    one = train(7.8)
    one.passing.force[np.abs(one.passing.x - 4.75) < 0.04] = 70e3
    found = transition.changes_of([one])[0]
    assert found.force == pytest.approx(60e3) and found.force_behind >= 0
    assert found.force_structure == pytest.approx(70e3)


@pytest.mark.parametrize("behind, words", [
    (-0.35, "0.3 m before the end of the structure"), (-0.003, "at the end of the structure"),
    (0.09, "at the end of the structure"), (0.11, "0.1 m behind the structure"),
    (5.7, "5.7 m behind the structure")])
def test_places_are_distances_from_the_end_of_the_structure(behind, words):
    assert transition_verdict.place(behind) == words


def test_levels_count_from_the_row_before_the_train():
    """What rail and sleepers do until then is no effect of the train."""
    one = train(7.8)
    rail, sleeper = one.rail_down(), one.sleeper_down()
    for values in (one.passing.rail, one.passing.displacement):
        values[0] += 0.3e-3   # the pads take their forces
    assert one.rail_down() == pytest.approx(rail + 0.3e-3)
    one.passing.first = 1
    one.run.wheel = {"x": types.SimpleNamespace(values=np.array([[-10.0], [-9.0], [20.0]]))}
    assert (one.rail_down() < rail + 0.2e-3).all() and (one.sleeper_down() <= sleeper).all()


def test_settlement_is_relative_to_the_ground():
    one = train(7.8)
    assert one.settlement() == pytest.approx(1e-4)
    one.run.ground["displacement"].values[-1] = -3e-5
    assert one.settlement() == pytest.approx(0.7e-4)


def test_no_verdict():
    second = train(5.4, wedge_present=False)
    assert "differ by more than 10%" in stated(train(7.8), train(5.4, 1.2e-3, wedge_present=False))
    assert "must have all blocks" in stated(train(7.8), train(5.4))
    assert "give a second run" in stated(train(7.8))
    assert "differ by less than 10%" in stated(train(7.8, 0.42e-3),
                                               train(5.4, 0.42e-3, wedge_present=False))
    faster = copy.deepcopy(second.run.deck)
    faster["train"]["speed"] = 50.0
    second.run.deck = faster
    assert "differ in train.speed" in stated(train(7.8), second)
    without = train(7.8), train(5.4, wedge_present=False)
    for one in without:
        one.run.deck["ground"]["block"][0]["young"] = 9e9
    assert "no structure" in stated(*without)


def test_a_run_that_was_stopped_is_refused():
    for begin, axle, words in ((0.2, 20.0, "has not reached the train of its last passage"),
                               (0.5, 10.0, "the train has not left the bed in the last row")):
        run = types.SimpleNamespace(
            name="made", time=np.linspace(0, 1, 11), sleepers_x=X, passage=lambda: slice(5, 11),
            deck={"stage": [{"kind": "passage", "train": True}]}, has_passage=lambda: True,
            asks_for_passage=lambda: True,
            wheel={"x": types.SimpleNamespace(values=np.full((11, 2), axle))})
        passing = types.SimpleNamespace(time=np.linspace(begin, 1, 6))
        with pytest.raises(read.Unreadable, match=words):
            transition.require_whole(run, passing)


def test_runs_of_one_name_have_files_of_their_own():
    names = [one.name for one in transition.named([train(7.8), train(7.8)])]
    assert names == ["made 1", "made 2"]
    pair = transition.named([train(7.8), train(5.4, wedge_present=False)])
    assert [one.name for one in pair] == ["with wedge", "without wedge"]
    assert set(transition.curves(pair)) == {
        f"{what}_{which}_wedge.csv" for what in ("levels", "wheel_force")
        for which in ("with", "without")}


def test_curves_are_written():
    found = transition.curves([train(7.8)])
    rows = found["levels_made.csv"].splitlines()
    assert rows[0] == "x_m,rail_down_mm,sleeper_down_mm,settlement_down_mm" and len(rows) == 31
    assert rows[8] == "4.8,0.4,0.4,0.1"
    assert found["wheel_force_made.csv"].splitlines()[1].endswith(",60")


def test_the_table_has_the_smallest_settlement_too():
    one = train(7.8)
    one.passing.left[8] = 0.2e-3
    rows = [line for line in transition.table([one], None).splitlines() if "into the bed" in line]
    assert [row.split()[-1] for row in rows] == ["0.0875", "0.100", "-0.200"]


def test_force_is_nan_where_no_wheel_was():
    one = train(7.8)
    one.passing.x[:] = np.nan
    assert np.isnan(one.largest_force()[1]).all()
