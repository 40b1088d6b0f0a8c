"""Tests that a stiff block is a structure only if it is deep, that other ones are measures like a
wedge, and that reasons against a comparison are the true ones."""

import numpy as np
import pytest
import test_transition
from test_ground_blocks import with_blocks
from trackbed_post import (ground_blocks, ground_transition, judgement, measures, model_drawing,
                           transition, transition_figures, transition_verdict)


def box(low, high, top=0.0, bottom=-2.0):
    return [low, top, high, top, high, bottom, low, bottom]


ABUTMENT = ("abutment", 3e10, box(0, 2))
SLAB = ("approach_slab", 3e10, box(2, 6, 0.0, -0.3))


def test_a_slab_beside_an_abutment_is_a_measure(runs):
    slab, bare = with_blocks(runs[0], SLAB, ABUTMENT), with_blocks(runs[1], ABUTMENT)
    for run in (slab, bare):
        assert ground_blocks.edge_of_structure(run) == 2
        assert measures.chosen_sleepers(run) == measures.chosen_sleepers(bare)
    stiff, measure = ground_blocks.stretches(slab)
    assert (stiff.label, stiff.low, stiff.high) == ("abutment", 0, 2)
    assert (measure.label, measure.structure, measure.high) == ("approach slab", False, 6)
    assert ground_blocks.wedge_length(slab) == pytest.approx(4)
    assert ground_blocks.differ_by_wedge(slab, bare) and judgement.why_no_pair(slab, bare) == ""
    found, other = (ground_transition.transition(run, 4.0) for run in (slab, bare))
    assert found.structure_displacement == pytest.approx(0.02e-3)
    assert found.edge == other.edge and found.plain_begin == other.plain_begin
    text = ground_transition.table([slab, bare])
    assert "on plain track beyond the approach slab (x = " in text
    assert "as expected of the approach slab" in text and "of a wedge" not in text


def test_a_slab_is_drawn_as_a_measure(runs):
    run = with_blocks(runs[0], SLAB, ABUTMENT)
    figure, panel = transition_figures.plt.subplots()
    scene = model_drawing.Scene.__new__(model_drawing.Scene)
    scene.panel, scene.run = panel, run
    run.deck["bed"] = {"x": [0, 9]}
    scene._draw_ground()
    drawn = [patch.get_hatch() for patch in panel.patches]
    assert drawn == [model_drawing.SOFT["hatch"], model_drawing.STRUCTURE["hatch"]]
    assert panel.texts[0].get_text() == "approach slab, 30 GPa"
    transition_figures.plt.close(figure)


@pytest.mark.parametrize("blocks, structure", [
    ([("wall", 1e10, box(0, 2, 0.0, -1.0))], ["wall"]),
    ([("wall", 1e10, box(0, 2, 0.0, -0.9))], []),
    ([("wall", 1e10, box(0, 2, -0.1, -2.0))], []),          # does not reach the surface
    ([("wall", 9e9, box(0, 2))], []),
    ([("deck", 3e10, box(0, 2, 0, -0.5)), ("pier", 3e10, box(0.5, 2, -0.5, -2))],
     ["deck", "pier"]),
    ([ABUTMENT, ("slab", 3e10, box(2, 6, 0, -0.3)), ("ledge", 3e10, box(2, 2.5, -0.3, -2))],
     ["abutment"])])                                         # rests on a ledge with its end
def test_a_structure_is_deep_or_stands_on_deep_blocks(runs, blocks, structure):
    run = with_blocks(runs[0], *blocks, ("soil", 1e8, box(6, 7)))
    assert [block.name for block in ground_blocks.every(run) if block.structure] == structure


def test_the_depth_of_the_ground_is_that_of_its_layers(runs):
    run = with_blocks(runs[0], ABUTMENT)
    run.deck["ground"]["layer"] = [{"thickness": 1.5}, {"thickness": 3.0}]
    assert ground_blocks.depth(run) == 4.5 and ground_blocks.edge_of_structure(run) is None
    text = ground_transition.why_no_transition(run)
    assert ground_blocks.RULE in text and "; abutment is stiff enough, but not deep enough" in text
    run = with_blocks(runs[0], SLAB, ("beam", 3e10, box(0, 2, 0, -0.2)))
    run.deck["ground"]["layer"] = [{"thickness": 4.5}]
    assert "; approach slab and beam are stiff enough, but" in ground_blocks.shallow(run)


WEDGE = ("wedge", 3e8, box(2, 4))


@pytest.mark.parametrize("first, second, words", [
    ([ABUTMENT, SLAB], [ABUTMENT, SLAB], "both have the same blocks: abutment, approach slab"),
    ([ABUTMENT], [ABUTMENT, SLAB], "has the approach slab: exchange the two runs"),
    ([ABUTMENT, SLAB], [ABUTMENT, WEDGE], "here wedge is in the second one, no_wedge, only"),
    ([ABUTMENT, ("pier", 3e10, box(5, 6))], [ABUTMENT], "here pier, which only the first one has, "
     "is a structure (at least 10 GPa, from the surface over at least half of the depth"),
    ([ABUTMENT, ("next", 3e10, box(2, 3))], [ABUTMENT],
     "not at the same place: the structure up to x = 3.00 m in wedge and the structure up to x = "
     "2.00 m in no_wedge (a structure is a block of at least 10 GPa"),
    ([ABUTMENT, WEDGE], [WEDGE], "the structure up to x = 2.00 m in wedge and no structure in")])
def test_the_reason_against_a_pair_is_the_true_one(runs, first, second, words):
    assert words in judgement.why_no_pair(with_blocks(runs[0], *first),
                                          with_blocks(runs[1], *second))


def test_runs_with_other_edges_are_not_compared(runs):
    longer = with_blocks(runs[0], ABUTMENT, ("next", 3e10, box(2, 3)))
    text = ground_transition.table([longer, with_blocks(runs[1], ABUTMENT)])
    assert "no comparison: the transitions of both runs are not at the same place" in text
    assert "change" not in text.splitlines()[0] and "%:" not in text and "%\n" not in text
    assert "clear effect" not in text


def with_block(train, young, outline):
    """The train over a ground with this block in place of the wedge, named slab."""
    train.run.deck["ground"]["block"][1] |= {"name": "slab", "young": young, "outline": outline}
    return train


@pytest.mark.parametrize("bottom, words", [
    (-0.3, "With the slab the rail reaches 90% of its change from structure to plain track 2.7 m "
           "behind the structure instead of 0.5 m, and the steepest part of the change is 80% less "
           "steep: as expected of the slab."),
    (-1.5, "No verdict: the transitions of both runs are not at the same place: the structure up "
           "to x = 9.00 m in made and the structure up to x = 4.80 m in made")])
def test_the_rail_is_compared_over_a_slab_and_not_over_another_structure(bottom, words):
    pair = [with_block(test_transition.train(end, wedge_present=present), 3e10,
                       box(4.8, 9, 0, bottom)) for end, present in ((7.8, True), (5.4, False))]
    text = test_transition.stated(*pair)
    assert words in text and "of a wedge" not in text
    names = ["with slab", "without slab"] if bottom == -0.3 else ["made 1", "made 2"]
    assert [train.name for train in transition.named(pair)] == names


def test_a_run_with_a_measure_is_not_asked_for_a_wedge():
    one = with_block(test_transition.train(7.8), 3e10, box(4.8, 9, 0, -0.3))
    assert transition_verdict.why_no_verdict([one], None) == "give a second run, without the slab"
    before = with_block(test_transition.train(7.8), 3e8, box(0.0, 1.0, 0, -0.3))
    assert "no wedge" not in transition_verdict.why_no_verdict([before], None)


def test_too_few_sleepers_and_no_structure_are_told_apart():
    pair = [test_transition.train(7.8), test_transition.train(5.4, wedge_present=False)]
    assert "too few sleepers" in transition_verdict.why_no_verdict(pair, None)
    for one in pair:
        one.run.deck["ground"]["block"][0]["outline"] = box(0, 4.8, 0, -0.5)
        one.run.deck["ground"]["layer"] = [{"thickness": 3.0}]
    pair[1].run.deck["ground"]["block"][0]["young"] = 1e10
    why = transition_verdict.why_no_verdict(pair, None)
    assert "the ground has no structure (a block of at least 10 GPa" in why
    assert "; structure is stiff enough, but not deep enough" in why


def test_a_place_of_a_row_is_the_row_itself():
    """The curve has bins of 0.1 m; the largest force is stated at its row, not at the bin."""
    one = test_transition.train(7.8)
    way = one.passing.x[:, 0]
    row = int(np.argmin(np.abs(way - 4.803)))
    one.passing.x[row, 0] = 4.803
    one.passing.force[row, 0] = 70e3
    found, = transition.changes_of([one])
    assert (found.force, found.force_x) == (70e3, 4.803)
    assert found.force_behind == pytest.approx(0.003)
    text = transition.table([one], [found])
    row = next(line for line in text.splitlines() if line.startswith("x of the largest wheel"))
    assert row.endswith(" 4.803")


@pytest.mark.parametrize("value, place, text", [
    (1.0384, False, "1.04"), (59.017, False, "59.0"), (117.07, False, "117"), (0.0, False, "0.00"),
    (5377.0, False, "5377"), (4.79732, True, "4.797"), (-0.00268, True, "-0.003"),
    (16.8, True, "16.8"), (-1e-9, True, "0"), (float("nan"), False, "-")])
def test_tables_have_three_digits_and_places_millimetres(value, place, text):
    assert judgement.shown(value, place) == text


def test_a_table_of_the_ground_has_three_digits(runs):
    lines = ground_transition.table(runs[:1]).splitlines()
    rows = [line.split()[-1] for line in lines[1:lines.index("")]]
    assert len(rows) == len(ground_transition.ROWS)
    assert all(len(row.replace(".", "").lstrip("0")) <= 3 for row in rows), rows
