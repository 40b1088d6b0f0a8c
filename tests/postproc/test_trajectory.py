"""Paths of wheels over scanned rails, where they are known."""
import importlib.util
import pathlib
import struct

import numpy as np
import pytest

import conftest
from trackbed_post import read
from trackbed_post.trajectory import contact, profiles, scan

SCAN = pathlib.Path(__file__).resolve().parents[2] / "inputs/track/crossing_scan.py"
CONE = profiles.Profile("cone", np.array([-0.05, 0.06]), np.array([0.05, -0.06]) / 20)
X, Y = np.arange(0, 1.0001, 1e-3), np.arange(-0.04, 0.0701, 1e-3)


def surface(height):
    """A grid whose height is a function of x and y."""
    x, y = np.meshgrid(X, Y, indexing="ij")
    return scan.Grid(X, Y, height(x, y))


def made_scan():
    """The script that makes the scan of the crossing."""
    spec = importlib.util.spec_from_file_location("crossing_scan", SCAN)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def write(path, points, head="x_mm,y_mm,z_mm"):
    np.savetxt(path, 1e3 * points, delimiter=",", header=head, comments="")
    return path


def cloud(height, seed=1):
    chance = np.random.default_rng(seed)
    x, y = chance.uniform(0, 0.3, 8000), chance.uniform(-0.03, 0.03, 8000)
    return np.stack([x, y, height(x, y)], axis=1)


def test_the_profile_s1002_has_its_dimensions():
    s = np.arange(-70, 60.01, 0.05)
    growth = profiles.s1002(s)
    assert np.isfinite(growth).all()
    assert np.abs(np.diff(growth[s > -69.5])).max() < 0.25  # steep, but without a jump
    assert growth[np.argmin(np.abs(s))] == pytest.approx(0, abs=1e-9)
    assert growth.max() == pytest.approx(28) and s[np.argmax(growth)] == pytest.approx(-55)
    assert growth[-1] == pytest.approx(-2.635676, abs=1e-6)
    for border in (32.15796, -26, -35, -38.426669071, -39.764473993, -49.662510381, -62.764705882):
        assert np.diff(profiles.s1002([border - 1e-7, border + 1e-7]))[0] == pytest.approx(
            0, abs=2e-4)


def test_a_hollow_tread_lacks_its_depth():
    worn, new = profiles.of("s1002:hollow:2"), profiles.of("s1002")
    assert new.growth(0.0) - worn.growth(0.0) == pytest.approx(2e-3)
    assert new.growth(0.04) == worn.growth(0.04)


def test_a_cone_sinks_as_the_rail_diverges():
    grid = surface(lambda x, y: np.where(y >= x / 40, 0.0, np.nan))
    path = contact.roll(grid, CONE, radius=0.46)
    # Its radius is smaller by a twentieth of the place of the rail's edge, rounded up to the grid.
    edge = Y[np.searchsorted(Y, X / 40 - 1e-12)]
    assert np.allclose(path.z, -edge / 20, atol=1.1e-3 / 20)
    assert np.allclose(path.contact, edge, atol=1.1e-3)


def test_a_wheel_rolls_over_a_step_on_its_edge():
    grid = surface(lambda x, y: np.where(x < 0.5, 0.0, -0.01) + 0 * y)
    path = contact.roll(grid, CONE, radius=0.46)
    top = path.z[0]  # the field side of the cone is above its datum
    d = path.x - X[X < 0.5][-1]
    circle = np.where(d > 0, -(0.46 - np.sqrt(0.46**2 - np.clip(d, 0, 0.4)**2)), 0.0)
    assert np.allclose(path.z - top, np.maximum(circle, -0.01), atol=1e-9)


def test_a_wheel_does_not_fall_into_a_hole_that_is_shorter_than_its_contact():
    grid = surface(lambda x, y: np.where(np.abs(x - 0.5) < 0.02, np.nan, 0.0) + 0 * y)
    path = contact.roll(grid, CONE, radius=0.46)
    assert -np.min(path.z - path.z[0]) == pytest.approx(0.46 - np.sqrt(0.46**2 - 0.02**2), rel=0.1)


def test_dip_and_transition_of_two_ramps():
    x = np.arange(0, 2.0001, 1e-3)
    path = contact.Path("made", x, np.where(x < 1.2, -2e-3 * x, -2.4e-3 + 6e-3 * (x - 1.2)),
                        np.where(x < 1.2, 0.04, -0.02))
    assert path.dip() == pytest.approx((8e-3, 1.2), abs=1e-5)
    assert path.transition() == pytest.approx(1.2, abs=1e-3)
    assert path.irregularity()[[0, -1]] == pytest.approx([0, 0])


def test_outliers_are_left_out_and_nothing_else():
    points = cloud(lambda x, y: 0.01 * np.sin(10 * x) - y**2 / 0.6)
    spoilt = points.copy()
    spoilt[::400, 2] += 0.003
    kept = scan.cleaned(spoilt)
    assert len(scan.cleaned(points)) > 0.995 * len(points)
    truth = 0.01 * np.sin(10 * kept[:, 0]) - kept[:, 1]**2 / 0.6
    assert np.abs(kept[:, 2] - truth).max() < 1e-9 and len(kept) > 0.98 * len(points)


def test_marks_turn_a_scan_into_the_frame_of_the_track():
    points = cloud(lambda x, y: 0 * x)
    a = 0.3
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    marks = np.array([[0, 0, 0], [1, 0, 0], [0, 0.2, 0.1]])
    shift = np.array([3.0, -2.0, 0.5])
    found, remains = scan.turned(points @ turn.T + shift, marks @ turn.T + shift, marks)
    assert np.allclose(found, points, atol=1e-9) and remains < 1e-9
    with pytest.raises(read.Unreadable, match="do not lie on a line"):
        scan.turned(points, marks[:2], marks[:2])


def test_a_plane_keeps_its_heights_on_the_grid():
    grid = scan.gridded(cloud(lambda x, y: 0 * x + 0.004), along=2e-3, across=1e-3)
    smooth = scan.smoothed(grid)
    assert np.allclose(smooth.z[np.isfinite(smooth.z)], 0.004) and np.isfinite(smooth.z).all()


def test_the_path_over_a_noisy_scan_is_that_over_the_crossing(tmp_path):
    module = made_scan()
    x, y = np.arange(0, 2.0001, 1e-3), np.arange(-0.045, 0.0741, 2e-4)
    truth = 1e-3 * module.height(1e3 * x[:, None], 1e3 * y[None, :])
    exact = contact.roll(scan.Grid(x, y, truth), profiles.of("s1002"))
    file = tmp_path / "scan.csv"
    module.write(file)
    ran = conftest.call("trajectory", file, "--wheel", "s1002", "s1002:hollow:2", "--origin", "17",
                        "-o", tmp_path / "facing")
    assert ran.returncode == 0, ran.stderr
    found = np.loadtxt(tmp_path / "facing/irregularity_s1002.csv", delimiter=",", skiprows=1)
    truth = np.interp(found[:, 0] - 17, exact.x, exact.irregularity())
    assert np.abs(found[:, 1] - truth).max() < 0.1e-3
    assert "391 were left out" in ran.stdout and (tmp_path / "facing/trajectory.png").is_file()
    table = (tmp_path / "facing/trajectory.txt").read_text().splitlines()
    lowest, angle, at, jump = map(float, table[1].split()[1:])
    assert lowest == pytest.approx(1e3 * exact.irregularity().min(), abs=0.1)
    assert angle == pytest.approx(1e3 * exact.dip()[0], abs=0.7)
    assert at == pytest.approx(17 + exact.dip()[1], abs=0.01) == jump
    sections = np.loadtxt(tmp_path / "facing/sections.csv", delimiter=",", skiprows=1)
    assert np.allclose(np.diff(np.unique(sections[:, 0])), 0.01)

    ran = conftest.call("trajectory", file, "--origin", "19", "--trailing", "-o",
                        tmp_path / "trailing")
    back = np.loadtxt(tmp_path / "trailing/irregularity_s1002.csv", delimiter=",", skiprows=1)
    assert np.allclose(back[::-1, 1], found[:, 1], atol=1e-9)
    assert np.allclose(19 - back[::-1, 0], found[:, 0] - 17, atol=1e-6)


def test_stl_files_are_read_in_their_unit(tmp_path):
    corners = np.array([[[0, 0, 1], [1, 0, 1], [0, 1, 1]]] * 2, dtype="<f4")
    corners[1] += 2
    content = bytes(80) + struct.pack("<I", 2) + b"".join(
        bytes(12) + one.tobytes() + bytes(2) for one in corners)
    path = tmp_path / "scan.stl"
    path.write_bytes(content * 1)
    with pytest.raises(read.Unreadable, match="more than 8 points"):
        scan.load(path)
    many = np.concatenate([corners + 4 * k for k in range(4)])
    path.write_bytes(bytes(80) + struct.pack("<I", len(many)) + b"".join(
        bytes(12) + one.tobytes() + bytes(2) for one in many.astype("<f4")))
    assert scan.load(path, 1e-3).max() == pytest.approx(0.015)
    path.write_bytes(content[:-1])
    with pytest.raises(read.Unreadable, match="no binary STL file"):
        scan.load(path)


@pytest.mark.parametrize("words, message", [
    (("--wheel", "s1002:hollow:x"), "give s1002, s1002:hollow:MM"),
    (("--wheel", "nothing.csv"), "nothing.csv cannot be read"),
    (("--lateral", "500"), "the wheel at y = 0.5 m is beside the scan"),
    (("--wheel", "s1002", "s1002"), "two wheels have the same name"),
    (("--radius", "0"), "must be a number above 0")])
def test_bad_choices_are_refused(tmp_path, words, message):
    file = write(tmp_path / "scan.csv", cloud(lambda x, y: 0 * x))
    ran = conftest.call("trajectory", file, *words, "-o", tmp_path / "out")
    assert ran.returncode == 2 and message in ran.stderr, ran.stderr


@pytest.mark.parametrize("head, message", [
    ("x_mm,y_mm,height_mm", "has no column z with a unit"),
    ("x_m,y_mm,z_mm", "is the unit right?"),
    ("x_mm,y_mm,z", "the unit of column z is unknown")])
def test_bad_scans_are_refused(tmp_path, head, message):
    file = write(tmp_path / "scan.csv", cloud(lambda x, y: 0 * x), head)
    ran = conftest.call("trajectory", file, "-o", tmp_path / "out")
    assert ran.returncode == 2 and message in ran.stderr, ran.stderr


def test_measured_profiles_need_their_columns(tmp_path):
    file = tmp_path / "worn.csv"
    file.write_text("s_mm,growth_mm\n-30,1\n0,0\n60,-2\n")
    assert profiles.of(str(file)).growth(0.03) == pytest.approx(-1e-3)
    file.write_text("s_mm,radius_mm\n-30,1\n0,0\n")
    with pytest.raises(read.Unreadable, match="must have the columns s and growth"):
        profiles.of(str(file))
    file.write_text("s_mm,growth_mm\n0,1\n-1,0\n")
    with pytest.raises(read.Unreadable, match="ascending s"):
        profiles.of(str(file))
