"""Tests of the step of stiffness from springs to the ground of a track."""
import dataclasses

import numpy as np
import pytest
import track_on_ground
from trackbed_post import ground_ends, passage_warnings, read


def run(path, rows=track_on_ground.ROWS, **lowest):
    """Datasets and deck; `lowest`: displacement of the rail over the whole track and on the springs
    before or behind the ground, mm."""
    folder = track_on_ground.folder(path / "w", rows)
    found = read.datasets(folder)
    item = found["envelope/rail/displacement_min"]
    x = found["envelope/x"].values
    low = np.full(len(x), lowest.get("ground", 2.0))
    low[x < 9.75] = lowest.get("before", 2.0)
    low[x > 19.75] = lowest.get("behind", 2.0)
    found["envelope/rail/displacement_min"] = dataclasses.replace(item, values=-1e-3 * low)
    return found, read.results(folder).deck


def test_equal_supports_have_no_step(tmp_path):
    assert not ground_ends.warnings_of(*run(tmp_path))


def test_a_step_below_the_limit_is_not_stated(tmp_path):
    assert not ground_ends.warnings_of(*run(tmp_path, before=2.5, behind=1.6))


@pytest.mark.parametrize("side, which, x", [("before", "first", 10.0), ("behind", "last", 19.5)])
def test_the_remedy_makes_the_springs_as_stiff_as_the_ground(tmp_path, side, which, x):
    """Twice the displacement needs springs of 2^(4/3) = 2.52 times the stiffness."""
    one, = ground_ends.warnings_of(*run(tmp_path, **{side: 4.0}))
    assert f"by 4.00 mm on the springs {side} the ground and by 2.00 mm on its {which} " \
        f"sleepers, at x = {x:.2f} m" in one
    assert f"[[track.zone]] {side} the ground by about 2.5" in one


def test_an_end_that_no_axle_has_reached_is_not_compared(tmp_path):
    """After 161 rows the first axle is at 16 m: it has not run over the springs behind."""
    found = ground_ends.warnings_of(*run(tmp_path, 161, before=1.0, behind=1.0))
    assert len(found) == 1 and "before the ground" in found[0]


def test_the_warning_is_one_of_the_passage(tmp_path):
    found, deck = run(tmp_path, before=4.0)
    assert any("springs before the ground" in one
               for one in passage_warnings.of_track(found, deck, {}))
