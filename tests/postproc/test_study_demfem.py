"""Ten sleepers of the study demfem: displacements, stresses, and what its document says of them."""
import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "jobs"))
import study  # noqa: E402
from studies import demfem, demfem_model  # noqa: E402
from studies.study import Lines, Numbers  # noqa: E402


def with_tracks(numbers, first, grown):
    """Numbers of ten sleepers on both shapes: the rail is displaced on convex stones by 10 mm, on
    non-convex ones by `first` mm less in the first axle spacing, and by `grown` mm less later."""
    period, ramp = demfem_model.PERIOD, demfem_model.RAMP
    time, x = np.arange(2e-3, 4 * period, 4e-3), np.arange(0.05, 6, 0.1)
    for shape in demfem_model.SHAPES:
        for packing in demfem_model.TRACKS:
            run, other = f"track_{shape}_{packing}", 0.01 * packing
            less, later = (first, grown) if shape == "non_convex" else (0, 0)
            down = 10 - less - other - (later - 1) * (time > ramp + period)
            for figure in (*(f"track_rail_{place}" for place in demfem_model.RAIL),
                           "track_lowest"):
                numbers.lines.put(figure, run, time, down)
            for figure in ("track_tension", "track_compression"):
                numbers.lines.put(figure, run, x, 0.1 + 0.05 * np.sin(2 * np.pi * x / 0.6))
            numbers.lines.put("track_sleepers", run, x[::6], 10 + 0 * x[::6])
            for quantity in ("rail, rise in the rest", "rail, motion at the end of the rest",
                             "sinkage before the wheels", "lowest position of a sleeper",
                             "mean displacement of the sleepers"):
                numbers.put(run, quantity, 1, "mm")
            numbers.put(run, "mean displacement of the lowest sleeper", down[-1], "mm")
            for place in demfem_model.RAIL:
                for quantity in ("mean displacement", "lowest position"):
                    numbers.put(run, f"rail, {place}, {quantity}", down[-1], "mm")
            for what in ("tension", "compression"):
                for how in (what, *(f"{what} by the wheels, {how}" for how in (
                        demfem_model.ELEMENTS, demfem_model.BLOCKS))):
                    numbers.put(run, f"{how}, largest", 0.2, "MPa")
                    numbers.put(run, f"{how}, x of the largest", 3, "m")
                for part in ("mean", "mean up to 1.2 m", "mean from 4.8 m"):
                    numbers.put(run, f"{what}, {part}", 0.1, "MPa")


@pytest.mark.parametrize("first, grown, verdict, published", [
    (0.1, 2, "less", True), (2, 0.1, "less", False), (-0.1, -2, "more", True)])
def test_verdicts_on_ten_sleepers_follow_from_the_numbers(first, grown, verdict, published):
    folder = study.INPUTS.parent / "docs/studies/demfem"
    numbers = Numbers.read(folder / "numbers.csv")
    numbers.lines = Lines.read(folder / "lines.csv")
    with_tracks(numbers, first, grown)
    study.derive("demfem", numbers)
    text = " ".join(study.document_of("demfem", numbers).split())
    assert f"mm {verdict} (published: 7 to 9 mm less" in text and "nan" not in text
    assert ("This is not the published observation" in text) != published
    assert f"by {abs(first):.2f} mm {verdict} in the first axle spacing" in text
    assert "withdrawn" not in text


def test_growth_of_the_rail_begins_after_the_first_axle_spacing():
    numbers = Numbers({})
    period = demfem_model.PERIOD
    time = np.arange(2e-3, 4 * period, 4e-3)
    for place in demfem_model.RAIL:
        down = (3.0 * (time > demfem_model.RAMP) + 2 * (time > 2 * period)
                + 1.0 * (time > 3 * period))  # mm
        numbers.lines.put(f"track_rail_{place}", "track_convex_1", time, down)
    demfem.derive(numbers)
    for what, value in (("displacement in the first axle spacing", 3), ("growth", 3),
                        ("displacement in the last axle spacing", 6),
                        ("growth in one axle spacing", 1)):
        assert numbers("track_convex_1", f"rail, {what}") == pytest.approx(value, abs=0.05)


def test_stresses_of_blocks_are_means_of_their_elements():
    middle = np.array([(x, y, z) for x in (0.05, 0.15, 0.25, 0.35) for y in (0.05, 0.15)
                       for z in (-0.15, -0.05)])
    values = np.repeat([[1.0], [3.0], [10.0], [20.0]], 4, axis=0) * np.ones(6)
    x, means = demfem.blocks(middle, values, 0.1)
    assert np.allclose(x, (0.1, 0.3)) and np.allclose(means[:, 0], (2, 15))
