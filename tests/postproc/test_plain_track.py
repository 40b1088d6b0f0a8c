"""Tests that tables name plain track by its place, and a wedge only where a run has one."""
import copy
import dataclasses

import numpy as np
import pytest
import test_transition
import test_words
from trackbed_post import ground_transition, read, transition, transition_verdict


def without_wedge(run):
    """The run on a ground with a structure only."""
    deck = copy.deepcopy(run.deck)
    deck["ground"]["block"] = deck["ground"]["block"][:1]
    return dataclasses.replace(run, deck=deck)


def test_no_wedge_is_named_without_one(runs):
    plain = without_wedge(runs[1])
    for text in (ground_transition.table([plain]), ground_transition.table([plain, plain])):
        assert "wedge" not in text.replace(plain.name, "").partition("no verdict")[0]
    # 90 % is reached 0.6 m behind the edge: at that node, since the ground is averaged.
    assert "on plain track (x = 3.80 to 9.00 m): +0%" in ground_transition.table([plain, plain])
    rows = {line[:48].strip(): line.split()[-1] for line in
            ground_transition.table([plain]).splitlines() if line}
    assert (rows["which begins at x ="], rows["and ends at x ="]) == ("3.8", "9")


def test_a_wedge_that_is_not_present_is_not_named(runs):
    text = ground_transition.table([runs[1]]).replace(runs[1].name, "")
    assert "wedge" not in text  # its place is left out of plain track all the same
    assert ground_transition.transition(runs[1]).plain_begin == pytest.approx(7.2)
    short = copy.deepcopy(runs[1].deck)
    short["ground"]["block"][1]["outline"] = [2.0, 0.0, 8.0, 0.0, 2.0, -2.0]
    text = ground_transition.table([dataclasses.replace(runs[1], deck=short)])
    assert "this model has no plain track: the width of the transition is not defined" in text


def test_differences_have_other_causes_than_what_the_decks_differ_by(runs):
    moved = runs[0].sleeper["displacement"].values.copy()
    moved[-1, 4] -= 5e-3
    bad = dataclasses.replace(without_wedge(runs[0]), sleeper={
        **runs[0].sleeper, "displacement": read.Quantity(moved, "m", "-")})
    assert "other causes than what the decks differ by:" in ground_transition.table(
        [bad, without_wedge(runs[1])])


def test_a_second_run_is_asked_for_by_what_the_first_one_has():
    table = transition.table([test_transition.train(7.8)],
                             transition.changes_of([test_transition.train(7.8)]))
    assert "lowest level of the rail, median on plain track, mm down" in table
    assert "wedge" not in table
    one = test_transition.train(5.4, wedge_present=False)
    assert transition_verdict.why_no_verdict([one], None).startswith("this run has no wedge: give")
    assert transition_verdict.why_no_verdict([test_transition.train(7.8)], None) \
        == "give a second run, without the wedge"


def test_the_table_has_no_residual_displacement_before_the_train_has_left(runs):
    early = dataclasses.replace(test_words.until(runs[0], 0.9),
                                ground_envelope=runs[0].ground_envelope)
    assert np.isnan(ground_transition.transition(early).sleeper_residual_most)
    assert np.isfinite(ground_transition.transition(runs[0]).sleeper_residual_most)
