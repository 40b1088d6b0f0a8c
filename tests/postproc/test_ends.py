"""Tests of one rule for the sleepers at the ends of a bed, whose support is that of its end."""
import csv
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest
import test_transition
from trackbed_post import (bed_on_ground, ground_blocks, ground_transition, measures, read,
                           sleeper_histories, stage_histories, support, support_figure, transition)


def below_train(run):
    """The run with springs beside its bed, over which a train runs."""
    stages = [dict(stage, train=stage["kind"] == "passage") for stage in run.deck["stage"]]
    return dataclasses.replace(run, deck={**run.deck, "stage": stages})


@pytest.mark.parametrize("count, springs, inner", [
    (31, True, range(3, 28)), (7, True, [3]), (6, True, range(1, 5)), (3, False, [1]),
    (31, False, range(1, 30)), (2, True, [0, 1]), (1, False, [0]), (0, True, [])])
def test_which_sleepers_are_at_the_ends(count, springs, inner):
    assert list(np.flatnonzero(~ground_blocks.at_ends(count, springs))) == list(inner)


def test_histories_are_of_sleepers_within_the_bed(runs):
    run, sprung = runs[0], below_train(runs[0])
    assert measures.chosen_sleepers(run) == [1, 3, 13]     # the edge at 2 m is nearest to 2.1 m
    assert measures.chosen_sleepers(sprung) == [3, 7, 11]  # the first is the nearest one, too
    shown = sleeper_histories.draw([sprung]).axes[-1].get_legend()
    assert shown.get_title().get_text() == "without the three at each end of the bed"
    stages = stage_histories.stages([run]).axes
    assert any(panel.get_legend() and panel.get_legend().get_title().get_text()
               == "without the one at each end of the bed" for panel in stages)
    plt.close("all")


def test_supports_at_the_ends_are_hollow(runs):
    _, stiff, gaps = support_figure.draw([below_train(run) for run in runs]).axes
    for panel, curves in ((stiff, 4), (gaps, 2)):
        hollow = [line for line in panel.lines if line.get_markerfacecolor() == "white"]
        assert len(hollow) == curves
        assert hollow[0].get_xdata() == pytest.approx(runs[0].sleepers_x[[0, 1, 2, -3, -2, -1]])
        words = [text.get_text() for text in panel.get_legend().texts]
        assert words.count("end of the bed (hollow)") == 1
    rows = list(csv.DictReader(support.table([runs[0]]).splitlines()))
    assert [row["end"] for row in rows] == ["1", *["0"] * (len(rows) - 2), "1"]
    plt.close("all")


def test_title_and_table_leave_out_the_same_sleepers(runs):
    """The lowest of all is stated of the same sleepers in sleepers.png and in table.txt, which say
    which ones they leave out; envelope.png marks those."""
    run = below_train(runs[0])
    rows = run.passage()
    moved, height = run.sleeper_envelope["displacement_min"].values.copy(), \
        run.sleeper["displacement"].values.copy()
    height[rows] = height[rows][0]
    height[rows.start + 9, :] -= 4e-3
    height[rows.start + 9, [0, 2, -1]] -= 1e-3
    height[rows.stop - 1, 1] -= 3e-3
    moved[:] = (height[rows] - height[rows][0]).min(axis=0)
    run = dataclasses.replace(
        run, sleeper={**run.sleeper, "displacement": read.Quantity(height, "m", "-")},
        sleeper_envelope={**run.sleeper_envelope,
                          "displacement_min": read.Quantity(moved, "m", "-")})
    left_out = "without the three at each end of the bed"
    title = " ".join(sleeper_histories.draw([run]).axes[0].get_title().split())
    assert f"lowest of all sleepers: wedge -4.000 mm ({left_out})" in title
    found = ground_transition.transition(run)
    assert found.sleeper_displacement == pytest.approx(4e-3)
    assert found.sleeper_residual_most == pytest.approx(0, abs=1e-9)
    assert f"sleepers: {left_out}\n" in ground_transition.table([run])
    hollow, = (line for line in bed_on_ground.envelope([run]).axes[0].lines
               if line.get_markerfacecolor() == "white")
    assert hollow.get_xdata() == pytest.approx(run.sleepers_x[[0, 1, 2, -3, -2, -1]])
    plt.close("all")


def test_spectra_are_without_the_ends(runs):
    run = runs[0]
    loud = run.sleeper["seat_force"].values.copy()
    loud[:, [0, -1]] *= 100
    other = dataclasses.replace(run, sleeper={**run.sleeper, "seat_force": read.Quantity(
        loud, "N", "-")})
    assert np.array_equal(bed_on_ground.spectrum_of(run, "seat_force"),
                          bed_on_ground.spectrum_of(other, "seat_force"))


def test_settlements_at_the_ends_are_not_in_their_mean():
    one = test_transition.train(7.8)
    one.passing.left[[0, 2, -1]] -= 5e-3
    mean, largest = (of(one) for _, of in transition.OF_TRAINS[1:3])
    assert (mean, largest) == pytest.approx((0.1, 0.1))


def test_levels_before_the_train_are_those_of_the_highest_and_the_lowest_sleeper():
    one = test_transition.train(7.8)
    of = dict(transition.OF_TRAINS)["difference of the levels of all sleepers of the bed before "
                                    "the train, largest, mm"]
    even = of(one)
    one.passing.displacement[:, 1] -= 5e-3
    one.passing.displacement[:, 4] += 16e-3
    assert (even, of(one)) == pytest.approx((0, 21))
