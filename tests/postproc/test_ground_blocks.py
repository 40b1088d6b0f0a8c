"""Tests of ground_blocks.py: roles of blocks follow from their moduli, not from their names."""
import dataclasses

import made
import numpy as np
import pytest
from trackbed_post import bed_on_ground, ground_blocks, ground_transition, judgement, read


def with_blocks(run, *blocks):
    """The run with blocks (name, modulus, corners)."""
    ground = {"block": [{"name": name, "young": young, "outline": outline}
                        for name, young, outline in blocks]}
    return dataclasses.replace(run, deck={**run.deck, "ground": ground})


def box(low, high, top=0.0):
    return [low, top, high, top, high, -2.0, low, -2.0]


def test_names_are_labels_only(runs):
    renamed = []
    for run in runs:
        blocks = [dict(block) for block in run.deck["ground"]["block"]]
        blocks[0]["name"], blocks[1]["name"] = "bridge", "wedge_structure"
        renamed.append(dataclasses.replace(run, deck={**run.deck, "ground": {"block": blocks}}))
    assert ground_transition.table(renamed) == ground_transition.table(runs)
    stiff, soft = ground_blocks.stretches(renamed[0])
    assert (stiff.label, stiff.structure, stiff.high) == ("bridge", True, made.EDGE)
    assert (soft.label, soft.structure, soft.high) == ("wedge", False, 6.0)
    panel = bed_on_ground.stress(renamed).axes[0]
    assert [text.get_text() for text in panel.texts] == ["bridge", "wedge"]
    bed_on_ground.plt.close("all")


def on_layers(run, *blocks):
    """The same on layers of 200, 80 and 50 MPa, behind a structure."""
    made_of = with_blocks(run, ("structure", 3e10, box(0, 2)), *blocks)
    ground = {**made_of.deck["ground"], "layer": [
        {"name": name, "thickness": thick, "young": young}
        for name, thick, young in (("top", 0.6, 2e8), ("bottom", 1.0, 8e7), ("low", 1.4, 5e7))]}
    return dataclasses.replace(made_of, deck={**made_of.deck, "ground": ground})


SLAB = ("approach_slab", 3e10, [2, -0.2, 5, -0.2, 5, -0.4, 2, -0.4])


@pytest.mark.parametrize("blocks, words", [
    ([("wedge_surface", 6e8, box(2, 5)), ("wedge", 3e8, box(2, 4))], "wedge"),
    ([SLAB, ("joint", 5e7, box(5, 5.2))], "approach slab"),
    ([("joint", 5e7, [2, 0, 2.2, 0, 2.2, -1, 2, -1]), ("wedge", 3e8, box(2.2, 5))], "wedge"),
    ([("joint", 5e7, box(5, 5.2))], "joint"),
    ([("improved_ground", 3e8, box(2, 5))], "improved ground"),
    ([("wedge", 3e10, [2, -0.2, 5, -0.2, 5, -0.4, 2, -0.4]), ("wedge_low", 3e8, box(2, 4, -0.4))],
     "wedge"),
    ([("wedge", 3e8, box(2, 4)), SLAB], "approach slab and wedge")])
def test_a_design_is_called_by_what_stiffens_the_ground(runs, blocks, words):
    run = on_layers(runs[0], *blocks)
    assert ground_blocks.listed(ground_blocks.measures_of(run)) == words
    assert ground_blocks.stretches(run)[1].label == words
    bare = on_layers(runs[0])
    assert judgement.measure_words(run, bare) == ("a wedge" if words == "wedge" else f"the {words}")


@pytest.mark.parametrize("young, edge", [(10e9, made.EDGE), (9.99e9, None)])
def test_a_structure_is_as_stiff_as_concrete(runs, young, edge):
    run = with_blocks(runs[0], ("wedge", young, box(0, made.EDGE)))
    assert ground_blocks.edge_of_structure(run) == edge


@pytest.mark.parametrize("young, role, edge", [
    (1e9, "structure", made.EDGE), (3e10, "measure", None), (3e10, "auto", made.EDGE)])
def test_a_deck_may_state_the_role_of_a_block(runs, young, role, edge):
    run = with_blocks(runs[0], ("bridge", young, box(0, made.EDGE)))
    run.deck["ground"]["block"][0]["role"] = role
    assert ground_blocks.edge_of_structure(run) == edge
    assert [block.name for block in ground_blocks.measures_of(run)] == ([] if edge else ["bridge"])


def test_soft_blocks_are_one_stretch_and_touching_structures_one(runs):
    run = with_blocks(runs[0], ("wedge_surface", 6e8, box(2, 5)), ("deck", 3e10, box(0.0, 1.5)),
                      ("abutment", 2e10, box(1.5, 2)), ("wedge", 3e8, box(2, 4, -0.6)),
                      ("foundation", 3e10, box(0, 3, -1.0)))
    stiff, soft = ground_blocks.stretches(run)
    assert (stiff.low, stiff.high) == (0, 2) and stiff.label == "deck, abutment, foundation"
    assert (soft.low, soft.high, soft.label) == (2, 5, "wedge")
    assert ground_blocks.edge_of_structure(run) == 2
    assert ground_blocks.wedge_length(run) == pytest.approx(3)


def test_plain_track_ends_before_the_next_structure(runs):
    run = with_blocks(runs[0], ("wedge", 3e8, box(2, 3)), ("near", 3e10, box(0, 2)),
                      ("far", 3e10, box(8, 9)))
    assert ground_blocks.edge_of_structure(run) == 2
    assert ground_blocks.plain_track(run, 2.0, 1.0, 0.6) == pytest.approx((2.2, 4.8))
    assert ground_blocks.plain_track(runs[0], 2.0, 4.0, 0.6) == pytest.approx((5.2, 7.0))


def test_sleepers_beside_springs_are_not_plain_track(runs):
    stages = [{**stage, "train": stage["kind"] == "passage"} for stage in runs[0].deck["stage"]]
    run = dataclasses.replace(runs[0], deck={**runs[0].deck, "stage": stages})
    last = np.sort(run.sleepers_x)[-1 - ground_blocks.ENDS]
    assert ground_blocks.plain_track(run, 2.0, 4.0, 0.6)[1] == pytest.approx(last - 2.0)


def test_a_structure_in_the_first_run_only_is_no_wedge(runs):
    wedge = ("wedge", 3e8, box(2, 6))
    stiff = ("structure", 3e10, box(0, 2))
    both, bare = with_blocks(runs[0], stiff, wedge), with_blocks(runs[0], stiff)
    assert ground_blocks.differ_by_wedge(both, bare)
    assert not ground_blocks.differ_by_wedge(both, with_blocks(runs[0], wedge))
    assert not ground_blocks.differ_by_wedge(bare, bare)


@pytest.mark.parametrize("low, high, edge, turn", [
    (0, 2, 2, 1), (6, 9, 6, -1), (6, 7, 7, 1), (1, 3, 3, 1), (0, 7, 7, 1), (2, 9, 2, -1)])
def test_distances_are_measured_away_from_the_structure(runs, low, high, edge, turn):
    run = with_blocks(runs[0], ("structure", 3e10, box(low, high)))
    assert ground_blocks.edge_of_structure(run) == edge
    assert ground_blocks.direction(run, edge) == turn


def test_a_structure_in_the_middle_is_measured_behind_its_upper_end(runs):
    run = with_blocks(runs[0], ("structure", 3e10, box(3, 4)))
    x = run.ground_x
    down = np.select([x < 3, x <= 4], [5e-3, 0.1e-3], 2e-3)  # the side before is softer
    envelope = {**run.ground_envelope, "displacement_min": read.Quantity(-down, "m", "-")}
    found = ground_transition.transition(dataclasses.replace(run, ground_envelope=envelope))
    assert found.structure_displacement == pytest.approx(0.1e-3)
    assert found.far_displacement == pytest.approx(2e-3)
    assert 0 < found.width < 0.5  # averaged over a spacing
    assert abs(found.steepest_x - 4.0) < 0.4
    begin, end = ground_blocks.plain_track(run, 4.0, 0.0, 0.6)
    assert (begin, end) == pytest.approx((1.2, 5.0))
