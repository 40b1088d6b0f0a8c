"""Tests of transition.py on synthetic levels with known results."""
import types

import numpy as np
import pytest
import transition


def train(end_of_wedge, plain=-1e-3, force=60e3, wedge_present=True):
    """A rail that sinks by 0.4 mm on a structure up to x = 3 m and by `plain` beyond
    `end_of_wedge`, linear between the two; two axles of constant force."""
    x = 0.6 * np.arange(1, 23)
    level = np.interp(x, [3.0, end_of_wedge], [-0.4e-3, plain])
    outline = [3.0, 0.0, 7.2, 0.0, 7.2, -0.6, 3.0, -0.6]
    deck = {"sleepers": {"spacing": 0.6}, "ground": {"block": [
        {"name": "structure", "outline": [0.0, 0.0, 3.0, 0.0, 3.0, -3.0, 0.0, -3.0]},
        {"name": "wedge", "outline": outline, "present": wedge_present}]}}
    run = types.SimpleNamespace(name="made", deck=deck, sleepers_x=x,
                                ground_x=np.linspace(0, 13.8, 140))
    way = np.linspace(-3, 16, 400)
    wheels = np.stack([way, way - 2], axis=1)
    passing = types.SimpleNamespace(
        rail=np.stack([np.zeros_like(x), level]), x=wheels, lowest=np.stack([level, level]),
        force=np.full((400, 2, 1), force), left=np.zeros_like(x))
    return transition.Train(run, passing)


def stated(*trains):
    wedge = max(transition.measures.wedge_length(one.run) for one in trains)
    return transition.verdict(trains, [transition.change_of(one, wedge) for one in trains])


def test_levels_and_length():
    found = transition.change_of(train(6.0), 4.2)
    assert found.structure == pytest.approx(-0.4e-3)
    assert found.plain == pytest.approx(-1e-3)
    assert found.width == pytest.approx(0.9 * 3.0, abs=0.01)
    assert found.steepest == pytest.approx(0.2e-3)
    assert found.force == pytest.approx(60e3)


def test_verdict_names_what_changes_clearly():
    text = stated(train(6.0), train(3.6, wedge_present=False))
    assert "train changes is 2.7 instead of 0.54 m (+400%)" in text
    assert "its steepest change is 0.2 instead of 1 mm/m (-80%)" in text
    assert "the largest wheel force does not change clearly (60 instead of 60 kN)" in text


def test_no_verdict():
    assert "differ by more than 10%" in stated(train(6.0), train(3.6, -1.2e-3, wedge_present=False))
    assert "must have all blocks" in stated(train(6.0), train(3.6))
    assert "give a second run" in stated(train(6.0))
    without = train(6.0)
    without.run.deck["ground"]["block"][0]["name"] = "bridge"
    assert transition.change_of(without, 4.2) is None
    other = train(3.6, wedge_present=False)
    other.run.deck["ground"]["block"][0]["name"] = "bridge"
    assert "no structure" in stated(without, other)


def test_force_is_nan_where_no_wheel_was():
    one = train(6.0)
    one.passing.x[:] = np.nan
    assert np.isnan(one.largest_force()[1]).all()
