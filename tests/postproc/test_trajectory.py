"""Paths of wheels over scanned rails, where they are known."""
import importlib.util
import pathlib
import struct

import numpy as np
import pytest

import conftest
from trackbed_post import read
from trackbed_post.trajectory import command, contact, profiles, scan

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


def cloud(height, seed=1, length=0.3):
    """Points about 1 mm apart on 60 mm of width."""
    chance = np.random.default_rng(seed)
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(0, length, 1e-3),
                                                 np.arange(-0.03, 0.03, 1e-3)))
    x, y = x + chance.uniform(0, 3e-4, x.shape), y + chance.uniform(0, 3e-4, y.shape)
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


def test_a_wheel_rolls_over_a_short_hole_and_not_over_a_long_one():
    def rail(half):
        return surface(lambda x, y: np.where(np.abs(x - 0.5) < half, np.nan, 0.0) + 0 * y)
    path = contact.roll(rail(9e-3), CONE, radius=0.46)
    assert -np.min(path.z - path.z[0]) == pytest.approx(
        0.46 - np.sqrt(0.46**2 - 0.009**2), rel=0.2)
    with pytest.raises(read.Unreadable, match="nothing was scanned below the wheel .* 0.48 to"):
        contact.roll(rail(0.02), CONE, radius=0.46)


def test_no_section_further_away_than_the_radius_carries_the_wheel():
    grid = surface(lambda x, y: np.where(x < 0.01, 1.0, 0.0) + 0 * y)
    path = contact.roll(grid, CONE, radius=0.2)
    assert np.allclose(path.z[path.x > 0.22], path.z[-1])


def test_both_sides_of_a_track_give_mirrored_paths():
    def wing(x, y):
        return np.where(y >= x / 40, 0.0, np.nan)
    right = contact.roll(surface(wing), CONE)
    mirrored = scan.Grid(X, -Y[::-1], surface(wing).z[:, ::-1])
    left = contact.roll(mirrored, CONE, side=-1)
    assert np.allclose(left.z, right.z) and np.allclose(left.contact, -right.contact)


@pytest.mark.parametrize("slope, lateral, what", [
    (0.0, 0.0, None), (0.2, 0.0, "the end of the profile"), (0.2, 0.02, "the edge of the scan"),
    (0.0, 0.05, "its flange")])
def test_contacts_at_an_edge_are_reported(slope, lateral, what):
    grid = surface(lambda x, y: slope * y - 5 * (slope == 0) * y**2 + 0 * x)
    path = contact.roll(grid, CONE, lateral)
    found = contact.warnings(path, grid, scan.missing(grid), CONE, lateral)
    assert (found == []) if what is None else any(what in one for one in found), found


@pytest.mark.parametrize("end", [0.006, 0.1])
def test_a_hole_beside_the_contact_is_reported(end):
    """Also one that is open to the side of the rail; a surface that ends is no hole."""
    def rail(x, y):
        return np.where((np.abs(x - 0.5) < 0.03) & (y > -0.002) & (y < end), np.nan,
                        -5 * (y - 0.002)**2)
    grid = surface(rail)
    path = contact.roll(grid, CONE)
    found, = contact.warnings(path, grid, scan.missing(grid), CONE, 0.0)
    assert "beside a place that was not scanned between x = 0.47" in found
    oblique = surface(lambda x, y: np.where(np.abs(y - 0.02 - 0.05 * (x - 0.5)) < 0.015, np.nan, 0))
    assert not scan.missing(oblique)[:, 40:].any() and not scan.missing(grid)[:400].any()


def test_two_stretches_are_two_warnings():
    x = np.arange(100) * 1e-2
    wrong = np.zeros(100, bool)
    wrong[[10, 11, 12, 80, 81]] = True
    assert np.allclose(contact.stretches(x, wrong), [(0.1, 0.12), (0.8, 0.81)])
    assert contact.stretches(x, np.zeros(100, bool)) == []


def test_noise_on_a_plain_rail_is_no_transition():
    chance = np.random.default_rng(1)
    grid = surface(lambda x, y: -y**2 / 0.6 + chance.normal(0, 35e-6, x.shape))
    smooth = scan.smoothed(grid, across=2e-3)
    path = contact.roll(smooth, CONE)
    assert np.abs(np.diff(path.contact)).max() > 3e-3 and np.isnan(path.transition())


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
    found, remains, down = scan.turned(points @ turn.T + shift, marks @ turn.T + shift, marks)
    assert np.allclose(found, points, atol=1e-9) and remains < 1e-9 and not down
    mirrored = marks * [1, 1, -1]
    assert scan.turned(points, mirrored * [1, -1, 1], marks)[2]
    for d in (0.029, 0.031):  # two thirds of it from the line that is closest to all
        line = np.array([[0, 0, 0], [1, 0, 0], [0.5, d, 0]])
        if d > 0.03:
            scan.turned(points, line, line)
    line[2, 1] = 0.029
    for bad, why in ((marks[:2], "three or more"), (line, "furthest is at 19.3 mm")):
        with pytest.raises(read.Unreadable, match=why):
            scan.turned(points, bad, bad)
    with pytest.raises(read.Unreadable, match="are units and axes right"):
        scan.turned(points, 1e3 * marks, marks)


def test_a_plane_keeps_its_heights_on_the_grid():
    grid = scan.gridded(cloud(lambda x, y: 0 * x + 0.004), along=2e-3, across=1e-3)
    smooth = scan.smoothed(grid)
    assert np.allclose(smooth.z[np.isfinite(smooth.z)], 0.004) and np.isfinite(smooth.z).all()


@pytest.fixture(name="crossing", scope="module")
def scanned_crossing(tmp_path_factory):
    """(scan of the crossing, its true path)."""
    module = made_scan()
    x, y = np.arange(0, 2.0001, 1e-3), np.arange(-0.045, 0.0741, 2e-4)
    truth = 1e-3 * module.height(1e3 * x[:, None], 1e3 * y[None, :])
    file = tmp_path_factory.mktemp("scan") / "scan.csv"
    module.write(file)
    return file, contact.roll(scan.Grid(x, y, truth), profiles.of("s1002"))


def test_the_path_over_a_noisy_scan_is_that_over_the_crossing(crossing, tmp_path):
    file, exact = crossing
    ran = conftest.call("trajectory", file, "--wheel", "s1002", "s1002:hollow:2", "--origin", "17",
                        "-o", tmp_path / "facing")
    assert ran.returncode == 0, ran.stderr
    found = np.loadtxt(tmp_path / "facing/irregularity_s1002.csv", delimiter=",", skiprows=1)
    truth = np.interp(found[:, 0] - 17, exact.x, exact.z)
    truth -= np.interp(found[:, 0], found[[0, -1], 0], truth[[0, -1]])
    assert np.abs(found[:, 1] - truth).max() < 0.1e-3
    assert found[0, 1] == found[-1, 1] == 0
    assert "beside a place that was not scanned between x = 0.692 and 0.708 m" in ran.stdout
    assert (tmp_path / "facing/trajectory.png").is_file()
    table = (tmp_path / "facing/trajectory.txt").read_text().splitlines()
    lowest, angle, at, jump = map(float, table[1].split()[1:])
    assert lowest == pytest.approx(1e3 * exact.irregularity().min(), abs=0.1)
    assert angle == pytest.approx(1e3 * exact.dip()[0], abs=0.7)
    assert at == pytest.approx(17 + exact.dip()[1], abs=0.01) == jump
    sections = np.loadtxt(tmp_path / "facing/sections.csv", delimiter=",", skiprows=1)
    assert np.allclose(np.diff(np.unique(sections[:, 0])), 0.01)

    conftest.call("trajectory", file, "--origin", "19", "--trailing", "-o", tmp_path / "trailing")
    back = np.loadtxt(tmp_path / "trailing/irregularity_s1002.csv", delimiter=",", skiprows=1)
    assert np.allclose(back[::-1, 1], found[:, 1], atol=1e-8)
    assert np.allclose(19 - back[::-1, 0], found[:, 0] - 17, atol=1e-6)


def test_the_outliers_of_the_crossing_are_left_out(crossing):
    points = scan.load(crossing[0])
    height = 1e-3 * made_scan().height(1e3 * points[:, 0], 1e3 * points[:, 1])
    kept = {tuple(one) for one in scan.cleaned(points)}
    high = points[points[:, 2] > height + 4e-3]
    assert len(high) > 50 and not any(tuple(one) in kept for one in high)
    assert len(kept) > 0.99 * len(points)


def test_the_order_of_columns_does_not_matter(crossing, tmp_path):
    rows = np.loadtxt(crossing[0], delimiter=",", skiprows=1)
    np.savetxt(tmp_path / "other.csv", rows[:, [1, 2, 0]], delimiter=",", header="y_mm,z_mm,x_mm",
               comments="")
    assert np.array_equal(scan.load(tmp_path / "other.csv"), scan.load(crossing[0]))
    marks = [[0, 1, 2, 3, 4, 5], [10, 11, 12, 13, 14, 15]]
    np.savetxt(tmp_path / "marks.csv", marks, delimiter=",", comments="",
               header="true_x_m,x_m,true_y_m,y_m,true_z_m,z_m")
    scanned, true = scan.marks(tmp_path / "marks.csv")
    assert scanned.tolist() == [[1, 3, 5], [11, 13, 15]] and true[0].tolist() == [0, 2, 4]


@pytest.mark.parametrize("lines", [2e-3, 2.5e-3])
def test_a_scan_may_consist_of_lines(lines):
    x, y = np.meshgrid(np.arange(0.0005, 0.3, lines), np.arange(-0.04, 0.05, 1e-4), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), -y.ravel()**2 / 0.6], axis=1)
    grid = scan.gridded(points)
    assert np.isfinite(grid.z[3:-3, 20:-20]).all()
    path = contact.roll(scan.smoothed(grid), CONE)
    assert len(path.x) > 270 and np.ptp(path.z) < 1e-6


def test_averages_do_not_depend_on_the_origin():
    points = cloud(lambda x, y: 0.01 * np.sin(20 * x))
    ends = [scan.smoothed(scan.gridded(points + [shift, 0, 0])).x[[0, -1]] - shift
            for shift in (0, 0.1, 1, 17)]
    assert np.allclose(ends, ends[0], atol=1e-9) and ends[0][0] == pytest.approx(0.011, abs=1.1e-3)


def test_a_tilted_scan_is_turned_before_it_is_cleaned(crossing, tmp_path):
    file, _ = crossing
    points = np.loadtxt(file, delimiter=",", skiprows=1)
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # by 90 degrees about x
    marks = 1e3 * np.array([[0, 0, 0], [2, 0, 0], [1, 0.1, 0.02]])
    np.savetxt(tmp_path / "tilted.csv", points @ turn.T, delimiter=",", header="x_mm,y_mm,z_mm",
               comments="")
    np.savetxt(tmp_path / "marks.csv", np.hstack([marks @ turn.T, marks / 1e3]), delimiter=",",
               header="x_mm,y_mm,z_mm,true_x_m,true_y_m,true_z_m", comments="")
    for name, words in (("straight", (file,)),
                        ("tilted", (tmp_path / "tilted.csv", "--marks", tmp_path / "marks.csv"))):
        ran = conftest.call("trajectory", *words, "-o", tmp_path / name)
        assert ran.returncode == 0, ran.stderr
    one, two = (np.loadtxt(tmp_path / name / "irregularity_s1002.csv", delimiter=",", skiprows=1)
                for name in ("straight", "tilted"))
    assert np.allclose(one, two, atol=2e-6)


def test_wheels_beside_each_other_have_files_of_their_own(tmp_path):
    file = write(tmp_path / "scan.csv", cloud(lambda x, y: (x < 0.15) * 1e-3 - 5 * y**2,
                                              length=0.323))
    ran = conftest.call("trajectory", file, "--lateral", "-3", "3", "--radius", "0.5", "-o",
                        tmp_path / "out")
    assert ran.returncode == 0, ran.stderr
    assert command.name_of_file(contact.Path("worn-wheel at -3 mm", X, X, X)) == \
        "irregularity_worn-wheel_at_minus_3_mm.csv"
    for name in ("minus_3", "3"):
        rows = np.loadtxt(tmp_path / f"out/irregularity_s1002_at_{name}_mm.csv", delimiter=",",
                          skiprows=1)
        assert rows[[0, -1], 1].tolist() == [0, 0]
        assert np.allclose(np.diff(rows[:, 0]), 5e-3, rtol=0.02)


def test_densities_may_differ_within_a_scan():
    fine = cloud(lambda x, y: 0 * x, length=0.05)[::1]
    fine[:, :2] *= 0.3
    coarse = cloud(lambda x, y: 0 * x, length=0.3)[::3] + [0.02, 0, 0]
    both = np.concatenate([fine, coarse])
    assert len(scan.cleaned(both)) > 0.97 * len(both)


def test_a_scan_from_the_side_is_refused():
    chance = np.random.default_rng(1)
    points = cloud(lambda x, y: chance.uniform(0, 0.04, x.shape))
    with pytest.raises(read.Unreadable, match="is z upwards"):
        scan.cleaned(points)


def test_stl_files_are_read_in_their_unit(tmp_path):
    """A square of 8 mm by two triangles has points between its corners."""
    corners = np.array([[[0, 0, 1], [8, 0, 1], [0, 8, 1]], [[8, 8, 1], [8, 0, 1], [0, 8, 1]]])
    content = bytes(80) + struct.pack("<I", 2) + b"".join(
        bytes(12) + one.astype("<f4").tobytes() + bytes(2) for one in corners)
    path = tmp_path / "scan.stl"
    path.write_bytes(content)
    points = scan.load(path, 1e-3)
    assert len(points) > 81 and np.allclose(points[:, 2], 1e-3)
    assert points[:, :2].max() == pytest.approx(8e-3)
    near = np.abs(points[:, None, :2] - points[None, :, :2]).max(axis=2)
    np.fill_diagonal(near, 1)
    assert near.min(axis=1).max() <= 1e-3
    for wrong, why in ((content[:-1], "no binary STL file"),
                       (content[:84] + struct.pack("<f", np.nan) * 12 + content[132:],
                        "not numbers")):
        path.write_bytes(wrong)
        with pytest.raises(read.Unreadable, match=why):
            scan.load(path)
    path.write_bytes(content)
    with pytest.raises(read.Unreadable, match="is the unit right"):
        scan.load(path, 1e6)


@pytest.mark.parametrize("words, message", [
    (("--wheel", "s1002:hollow:x"), "give s1002, s1002:hollow:MM"),
    (("--wheel", "nothing.csv"), "nothing.csv cannot be read"),
    (("--lateral", "500"), "the wheel at y = 0.5 m is beside the scan"),
    (("--wheel", "s1002", "s1002"), "two wheels have the same name"),
    (("--radius", "460"), "wheels have a radius of 0.1 to 1 m"),
    (("--origin", "nan"), "nan: must be a number")])
def test_bad_choices_are_refused(tmp_path, words, message):
    file = write(tmp_path / "scan.csv", cloud(lambda x, y: 0 * x))
    ran = conftest.call("trajectory", file, *words, "-o", tmp_path / "out")
    assert ran.returncode == 2 and message in ran.stderr, ran.stderr


def test_short_scans_are_refused(tmp_path):
    for length, why in ((0.0005, "possible are at least 2 each"), (0.015, "must be longer than")):
        file = write(tmp_path / "scan.csv", cloud(lambda x, y: 0 * x, length=length)
                     * [1, 1, 1])
        ran = conftest.call("trajectory", file, "-o", tmp_path / "out")
        assert ran.returncode == 2 and why in ran.stderr, ran.stderr


@pytest.mark.parametrize("head, message", [
    ("x_mm,y_mm,height_mm", "has no column z with a unit"),
    ("x_m,y_m,z_m", "is the unit right?"),
    ("x_mm,y_mm,z", "has no column z with a unit"),
    ("x_mm,x_m,z_mm", "has two columns of x"),
    ("x_mm,y_mm,z_kN", "column z_kN must be a length")])
def test_bad_scans_are_refused(tmp_path, head, message):
    file = write(tmp_path / "scan.csv", cloud(lambda x, y: 0 * x), head)
    ran = conftest.call("trajectory", file, "-o", tmp_path / "out")
    assert ran.returncode == 2 and message in ran.stderr, ran.stderr


def test_measured_profiles_need_their_columns(tmp_path):
    file = tmp_path / "worn.csv"
    file.write_text("s_mm,growth_mm\n-30,1\n0,0\n60,-2\n")
    assert profiles.of(str(file)).growth(0.03) == pytest.approx(-1e-3)
    file.write_text("s_mm,radius_mm\n-30,1\n0,0\n")
    with pytest.raises(read.Unreadable, match="has no column growth with a unit"):
        profiles.of(str(file))
    file.write_text("s_mm,growth_mm\n0,1\n-1,0\n")
    with pytest.raises(read.Unreadable, match="ascending s"):
        profiles.of(str(file))
