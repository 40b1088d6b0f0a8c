"""Tests of judgement.py, and that both tables of a comparison use it."""
import dataclasses
import math

import numpy as np
import pytest
import test_transition
from trackbed_post import bed_on_ground, ground_transition, judgement, read, transition, write
from trackbed_post import transition_verdict as verdicts


@pytest.mark.parametrize("value, text", [
    (999.4, "999"), (999.6, "1000"), (-999.6, "-1000"), (99.96, "100"), (9.996, "10.0"),
    (0.9996, "1.00"), (123456.7, "123457"), (1.5e6, "1500000"), (1.234e-4, "0.000123"),
    (-0.00035, "-0.000350"), (0.00999999, "0.0100"), (0.0, "0.00"), (math.nan, "-")])
def test_numbers_of_tables_have_three_digits_and_no_exponent(value, text):
    assert judgement.shown(value) == text
    assert judgement.shown(0.99996e-4) == "0.000100" and judgement.shown(1e-5) == "1.00e-05"


def of(first, second, scatter, wanted=-1, **more):
    return judgement.Difference(first, second, scatter, "mm/m", 1e3, wanted, **more)


@pytest.mark.parametrize("first, second, scatter, words", [
    (0.95e-3, 1e-3, 0.0, "no clear effect (within 10%)"),
    (0.7e-3, 1e-3, 0.4e-3, "no clear effect (the difference, 0.30 mm/m, is not larger "
     "than the scatter on plain track, 0.40 mm/m)"),
    (0.7e-3, 1e-3, 0.2e-3, "as expected of a wedge (the difference, 0.30 mm/m, is "
     "larger than the scatter on plain track, 0.20 mm/m)"),
    (1.3e-3, 1e-3, 0.2e-3, "NOT as expected of a wedge (the difference, 0.30 mm/m, is larger than"),
    (0.7e-3, 1e-3, math.nan, "no verdict: there is no plain track"),
    (math.nan, 1e-3, 0.0, "no verdict: the change is not known"),
    (1e-3, 0.0, 0.0, "NOT as expected of a wedge (the difference, 1.0 mm/m, is larger than"),
    (1e-3, 0.0, 2e-3, "no clear effect (the difference, 1.0 mm/m, is not larger than"),
    (0.0, 0.0, 0.0, "no clear effect (within 10%)")])
def test_words(first, second, scatter, words):
    assert of(first, second, scatter).words("a wedge").startswith(words)


@pytest.mark.parametrize("value, unit, text", [
    (0.276, "mm/m", "0.28 mm/m"), (0.4, "mm/m", "0.40 mm/m"), (50.4, "kPa", "50 kPa"),
    (99.6, "kN", "100 kN"), (0.04, "m", "less than 0.1 m"), (12.34, "m", "12.3 m")])
def test_numbers_of_sentences_have_one_format(value, unit, text):
    assert judgement.stated(value, unit) == text


def test_a_change_from_zero_has_no_percentage():
    width = judgement.Difference(1.5, 0.0, 0.6, "m", 1, 1, "one sleeper spacing")
    assert width.relative == "1.5 m instead of less than 0.1 m" and width.clear
    assert width.words("a wedge").startswith("as expected of a wedge (the difference, 1.5 m")
    assert math.isnan(of(math.nan, 0.0, 0.0).change)


def test_runs_that_do_not_differ_by_a_wedge():
    assert of(0.5, 1.0, 0.1).words("") == "change relative to the second run"
    assert of(0.5, 1.0, 0.6).words("").startswith("no clear effect")


def test_the_reason_against_a_verdict_is_stated_once_in_the_table(runs):
    text = ground_transition.table(runs[::-1])
    assert text.count(judgement.NO_PAIR) == 1
    assert "equal within 10%\n" in text and "comparable" not in text
    assert text.index("no verdict: the first run") < text.index("change relative to the second run")


def test_change_is_relative_to_the_reference():
    assert of(0.5, 1.0, 0, reference=5.0).change == pytest.approx(-0.1)
    assert not of(0.5, 1.0, 0, reference=5.0).clear and of(0.5, 1.0, 0).clear


def with_scatter(run, dip, stress):
    """The run with a dip of the ground and a step of its stress 6 m behind the edge."""
    x, down = run.ground_x, run.ground_envelope["displacement_min"].values
    down = down + dip * np.interp(x, [7.9, 8.1, 8.3], [0, 1, 0])
    compression = run.ground_envelope["sigma_z_min"].values + stress * (x > 8.0)
    return dataclasses.replace(run, ground_envelope={
        **run.ground_envelope, "displacement_min": read.Quantity(down, "m", "-"),
        "sigma_z_min": read.Quantity(compression, "Pa", "-")})


def test_the_table_judges_slopes_and_stresses_beside_their_scatter(runs):
    assert "no clear effect" not in ground_transition.table(runs)
    rough = [with_scatter(run, -12e-3, -60e3) for run in runs]
    found = ground_transition.transition(rough[0])
    assert found.stress_scatter == pytest.approx(60e3)
    # The mean over seven nodes gains 6 mm and 12 mm, a seventh of each, within two nodes of 0.1 m.
    assert found.slope_scatter == pytest.approx(1.5 / 2 * 12e-3 / 7 / 0.1, rel=0.02)
    text = ground_transition.table(rough)
    assert ("relative to the mean stress at the edge: -77%: no clear effect (the difference, 50 "
            "kPa, is not larger") in text
    assert text.count("not larger than the scatter on plain track") == 2  # the other: slope at edge
    assert "width of the transition: " in text and "larger than one sleeper spacing" in text


def test_the_verdict_on_the_rail_uses_the_same_test():
    first = test_transition.train(7.8)
    second = test_transition.train(5.4, wedge_present=False)
    for one in (first, second):
        one.passing.rail[1, 20] -= 0.54e-3  # 0.9 mm/m to its neighbours
    text = test_transition.stated(first, second)
    assert "the steepest part of the change is 80% less steep: no clear effect. " in text
    assert "2.7 m behind the structure instead of 0.5 m: as expected of a wedge; " in text
    assert ("This difference, 0.80 mm/m, does not exceed the steepest change on plain track, 0.90 "
            "mm/m, where only the stones vary. The change of the sleepers'") in text
    assert "the structure: no clear effect (within 10%)" in text


def hanging(run):
    """The run with one sleeper that hangs by 0.5 mm, the others on 30 kN/mm."""
    way = 2e-3 * np.sin(np.pi * np.clip(run.time - run.time[run.passage()][0], 0, None) / 2)
    way = np.repeat(way[:, None], len(run.sleepers_x), axis=1)
    reaction = 2e3 + 30e6 * way
    reaction[:, 3] = 40e6 * np.maximum(way[:, 3] - 0.5e-3, 0)
    return dataclasses.replace(run, sleeper={
        **run.sleeper, "displacement": read.Quantity(-way, "m", "-"),
        "reaction": read.Quantity(reaction, "N", "-")})


def test_a_bed_that_is_warned_of_has_no_verdict_in_the_table(runs, tmp_path):
    made = write.Folder(tmp_path)
    bed_on_ground.draw_all([hanging(runs[0]), runs[1]], made)
    text = made.tables[0]
    why = "no verdict, since 1 of 15 sleepers hang (run wedge)"
    assert text.count(why) == text.count("no verdict") == 1 and "clear effect" not in text
    assert "expected of a wedge" not in text and "comparable" not in text
    assert "change of the stress jump (-71% of" in text and "edge: -77%\n" in text
    assert "warning: wedge: 1 of 15 sleepers hang in the passage" in text


def test_a_bed_that_is_warned_of_has_no_verdict_on_the_rail():
    pair = transition.named([test_transition.train(7.8),
                             test_transition.train(5.4, wedge_present=False)])
    why = "1 of 15 sleepers hang (run with wedge)"
    text = verdicts.verdict(pair, transition.changes_of(pair), why)
    assert text.startswith(f"No verdict, since {why}: this can change")
    assert ("2.7 m behind the structure instead of 0.5 m, and the steepest part of the change is "
            "80% less steep. ") in text
    assert "instead of 1.0 mm/m, 0.3 m behind the structure. The largest" in text
    assert "expected" not in text and "clear" not in text and "ripple" not in text


def test_runs_in_the_wrong_order_are_to_be_exchanged(runs):
    words = "has the wedge: exchange the two runs in the command"
    assert f"here the second one, wedge, {words}" in ground_transition.table(runs[::-1])
    assert words not in ground_transition.table(runs)
    assert judgement.why_no_pair(runs[0], runs[0]) == \
        f"{judgement.NO_PAIR}; here both have the same blocks: structure, wedge"
    rail = test_transition.stated(test_transition.train(5.4, wedge_present=False),
                                  test_transition.train(7.8))
    assert "No verdict: the first run must have all blocks" in rail and words in rail


def test_both_percentages_of_a_stress_jump_are_named(runs):
    text = ground_transition.table(runs)
    line = next(line for line in text.splitlines() if line.startswith("stress jump at the edge"))
    assert line.endswith("+250%"), "from the first run to the second, 20 to 70 kPa"
    assert text.splitlines()[0].endswith("  change from wedge to no_wedge")
    assert ("change of the stress jump (-71% of the jump itself) relative to the mean stress at "
            "the edge: -77%: as expected") in text
    assert text.index("differences of wedge from no_wedge, relative to no_wedge:\n") \
        < text.index("change of the stress jump")


@pytest.mark.parametrize("rail, scatter, differs", [
    (0.9e-3, 0.0, False), (1.2e-3, 0.0, True), (1.05e-3, 0.0, True), (1.05e-3, 2e-3, True)])
def test_rail_and_ground_that_change_in_opposite_ways_are_stated(rail, scatter, differs):
    ground = {ground_transition.WIDTH: of(1.0, 1.0, 0.1), ground_transition.STEEPEST: of(
        0.5e-3, 1e-3, 0.1e-3)}
    text = verdicts.beside_ground({"width": of(1.0, 1.0, 0.1), "steepest": of(
        rail, 1e-3, scatter)}, ground)
    assert bool(text) == differs
    assert not differs or ("the steepest change by -50%, that of the rail by "
                           f"{rail / 1e-3 - 1:+.0%}") in text


def test_the_ground_of_two_runs_is_that_of_the_table(runs):
    found = verdicts.of_ground(runs)
    assert found[ground_transition.STEEPEST].change < -0.5
    bare = [dataclasses.replace(run, ground_envelope={}) for run in runs]
    assert verdicts.of_ground(bare) == {}


def test_the_table_of_a_run_with_a_train_names_what_it_judges(runs):
    stages = [dict(stage, train=stage["kind"] == "passage") for stage in runs[0].deck["stage"]]
    below = [dataclasses.replace(run, deck={**run.deck, "stage": stages}) for run in runs]
    assert ground_transition.ON_GROUND in ground_transition.table(below)
    assert ground_transition.ON_GROUND not in ground_transition.table(runs)


def test_the_table_of_runs_that_differ_in_more_than_the_measure_has_no_verdict(runs):
    """As transition.txt: it names the parameters of the decks."""
    faster = {**runs[1].deck, "load": {**runs[1].deck["load"], "speed": 30.0}}
    text = ground_transition.table([runs[0], dataclasses.replace(runs[1], deck=faster)])
    assert "no verdict: the decks differ in load.speed, not only in the wedge\n" in text
    assert "expected" not in text and "comparable" not in text
    assert "as expected of a wedge" in ground_transition.table(runs)
