"""Tests of jobs/bridge.py: the end of the bed is not judged."""
import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "jobs"))
import bridge  # noqa: E402


def passage(down):
    """Eight sleepers whose lowest positions are these, mm down; the bridge ends at 1.5 m."""
    made = bridge.Passage.__new__(bridge.Passage)
    made.x, made.edge = 0.3 + 0.6 * np.arange(8), 1.5
    made.motion = np.array([np.zeros(8), -1e-3 * np.array(down)])
    return made


@pytest.mark.parametrize("down, steepest, where", [
    ([1, 4, 2, 2.3, 2.6, 3.2, 1, 1], 1.0, "2.7 to 3.3"),  # 5 mm/m on the bridge, 3.7 at the end
    ([1, 1, 2, 3.2, 3.2, 3.2, 9, 1], 2.0, "1.5 to 2.1")])
def test_the_steepest_change_is_that_behind_the_bridge(down, steepest, where):
    value, place = passage(down).steepest()
    assert value == pytest.approx(steepest) and place == where
