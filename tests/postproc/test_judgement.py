"""Tests of judgement.py, and that both tables of a comparison use it."""
import dataclasses
import math

import numpy as np
import pytest
import test_transition
from trackbed_post import ground_transition, judgement, read


def of(first, second, scatter, wanted=-1, **more):
    return judgement.Difference(first, second, scatter, "mm/m", 1e3, wanted, **more)


@pytest.mark.parametrize("first, second, scatter, words", [
    (0.95e-3, 1e-3, 0.0, "no clear effect (within 10%)"),
    (0.7e-3, 1e-3, 0.4e-3, "no clear effect (the difference, 0.3 mm/m, is not larger "
     "than the scatter on plain track, 0.4 mm/m)"),
    (0.7e-3, 1e-3, 0.2e-3, "as expected of a wedge (the difference, 0.3 mm/m, is "
     "larger than the scatter on plain track, 0.2 mm/m)"),
    (1.3e-3, 1e-3, 0.2e-3, "NOT as expected of a wedge (the difference, 0.3 mm/m, is larger than"),
    (0.7e-3, 1e-3, math.nan, "no verdict: there is no plain track"),
    (math.nan, 1e-3, 0.0, "no verdict: the change is not known"),
    (1e-3, 0.0, 0.0, "no verdict: the change is not known")])
def test_words(first, second, scatter, words):
    assert of(first, second, scatter).words(True).startswith(words)


def test_runs_that_do_not_differ_by_a_wedge():
    assert judgement.NO_PAIR in of(0.5, 1.0, 0.1).words(False)
    assert of(0.5, 1.0, 0.6).words(False).startswith("no clear effect")


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
        one.passing.rail[1, 20] -= 0.6e-3  # 1 mm/m to its neighbours
    text = test_transition.stated(first, second)
    assert "behind the structure (-80%): no clear effect (the difference," in text
    assert "is reached 2.7 m behind the structure instead of 0.54 m: as expected of a wedge" in text
    assert "behind the structure: no clear effect (within 10%)" in text
