"""Field files open in VTK and give a picture with more than one colour."""
import subprocess
import sys

import conftest
import h5py
import matplotlib.image
import numpy as np
import pytest


def write_bricks(path, bricks, values):
    """VTKHDF file of a row of unit hexahedra with one value per cell."""
    points = np.array([[x, y, z] for x in range(bricks + 1) for z in (0, 1) for y in (0, 1)], float)
    # Corners of a hexahedron in VTK's order, as offsets into the row of points.
    cells = np.array([0, 4, 5, 1, 2, 6, 7, 3]) + 4 * np.arange(bricks)[:, None]
    with h5py.File(path, "w") as file:
        group = file.create_group("VTKHDF")
        group.attrs["Version"], group.attrs["Type"] = [1, 0], np.bytes_("UnstructuredGrid")
        group["NumberOfPoints"], group["NumberOfCells"] = [len(points)], [bricks]
        group["NumberOfConnectivityIds"] = [cells.size]
        group["Points"], group["Connectivity"] = points, cells.ravel()
        group["Offsets"] = np.arange(0, cells.size + 1, 8)
        group["Types"] = np.full(bricks, 12, np.uint8)
        group.create_group("PointData")
        group.create_group("CellData")["stress (Pa)"] = np.asarray(values, float)


def render(path, *arguments):
    return subprocess.run([sys.executable, conftest.ROOT / "postproc", "still", path, "-o",
                           path.with_suffix(".png"), *arguments], capture_output=True, text=True,
                          check=False)


def test_bricks_of_three_values_show_three_colours(tmp_path):
    path = tmp_path / "bricks.hdf"
    write_bricks(path, 3, [1, 2, 3])
    run = render(path)
    assert run.returncode == 0, run.stderr
    assert "3 cells; the picture has 3 different colours" in run.stdout
    high, wide = matplotlib.image.imread(path.with_suffix(".png")).shape[:2]
    assert 1590 <= wide <= 1600 and 500 < high < 600  # of bricks of 3 m x 1 m


def test_one_colour_is_refused(tmp_path):
    path = tmp_path / "bricks.hdf"
    write_bricks(path, 3, [2, 2, 2])
    run = render(path)
    assert run.returncode == 1 and "choose another --array" in run.stderr


@pytest.mark.parametrize("content, expected", [(b"", "not a VTKHDF"), (None, "does not exist")])
def test_other_files_are_refused(tmp_path, content, expected):
    path = tmp_path / "other.hdf"
    if content is not None:
        path.write_bytes(content)
    run = render(path)
    assert run.returncode == 2 and expected in run.stderr and len(run.stderr.splitlines()) == 1


def test_missing_array_is_named(tmp_path):
    path = tmp_path / "bricks.hdf"
    write_bricks(path, 1, [1])
    run = render(path, "--array", "velocity")
    assert run.returncode == 2 and "no array velocity; its arrays: stress (Pa)" in run.stderr


def test_picture_is_written_or_its_failure_reported(tmp_path):
    path, other = tmp_path / "bricks.hdf", tmp_path / "made" / "for" / "picture.png"
    write_bricks(path, 3, [1, 2, 3])
    assert render(path, "-o", other).returncode == 0 and other.stat().st_size > 1000
    (tmp_path / "file").write_text("kept")
    for place, words in ((tmp_path / "picture.gif", "must end in .png"),
                         (tmp_path / "file" / "picture.png", "is a file"),
                         ("/proc/picture/picture.png", "cannot be created"),
                         ("/proc/picture.png", "cannot be written")):
        run = render(path, "-o", place)
        assert run.returncode == 2 and words in run.stderr, (place, run.stderr)
        assert len(run.stderr.splitlines()) == 1, run.stderr
