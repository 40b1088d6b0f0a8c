"""Maps of field files: points in the plane, arrows, contours, and what is refused."""
import json

import conftest
import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest
import scipy.spatial
from trackbed_post import field_files, field_sections, maps, read

EXACT = {"rel": 1e-9, "abs": 1e-9}  # rounding


def write_file(path, pieces, kind, units):
    """A VTKHDF file of pieces {"Points", "cells", "PointData/...", "CellData/..."}."""
    path.parent.mkdir(parents=True, exist_ok=True)
    cells = [np.asarray(piece["cells"]) for piece in pieces]
    with h5py.File(path, "w") as file:
        group = file.create_group("VTKHDF")
        group.attrs["Version"], group.attrs["Type"] = [1, 0], np.bytes_("UnstructuredGrid")
        group["NumberOfPoints"] = [len(piece["Points"]) for piece in pieces]
        group["NumberOfCells"] = [len(one) for one in cells]
        group["NumberOfConnectivityIds"] = [one.size for one in cells]
        group["Connectivity"] = np.concatenate([one.ravel() for one in cells])
        group["Offsets"] = np.concatenate([one.shape[1] * np.arange(len(one) + 1)
                                           for one in cells])
        group["Types"] = np.full(sum(map(len, cells)), kind, np.uint8)
        for name in pieces[0]:
            if name != "cells":
                group[name] = np.concatenate([piece[name] for piece in pieces])
                group[name].attrs["units"] = units.get(name.rpartition("/")[2], "m")


def bricks(columns, rows, left=0.0, depth=1.0):
    """A piece of the ground: bricks of 0.5 x 1 x 0.1 m below z = 0, across y = -0.5 to 0.5, with
    displacement (x + z, 0, -z) and stress zz = 3 x - 2 z + 1, the other components 0."""
    x = left + 0.5 * np.arange(columns + 1)
    place = np.stack(np.meshgrid(x, depth * np.array([-0.5, 0.5]), -0.1 * np.arange(rows, -1, -1),
                                 indexing="ij"), -1).reshape(-1, 3)
    number = np.arange(len(place)).reshape(columns + 1, 2, rows + 1)
    low, high = number[..., :-1], number[..., 1:]
    cells = np.stack([each[a:columns + a, y] for each in (low, high)
                      for a, y in ((0, 0), (1, 0), (1, 1), (0, 1))], -1).reshape(-1, 8)
    centre = place[cells].mean(axis=1)
    stress = np.zeros((len(cells), 6))
    stress[:, 2] = 3 * centre[:, 0] - 2 * centre[:, 2] + 1
    moved = np.stack([place[:, 0] + place[:, 2], 0 * place[:, 0], -place[:, 2]], 1)
    return {"Points": place, "cells": cells, "PointData/displacement": moved,
            "CellData/stress_change": stress}


def clumps(shift=(0, 0, 0), left_out=()):
    """A piece of stones at x = 0, 1, ..., 9, y = 0 and 0.2, z = 0.2, each of two balls above each
    other; the velocity of a stone is (its number, 0, 1)."""
    middle = np.array([[x, y, 0.2] for x in range(10) for y in (0.0, 0.2)]) + shift
    kept = [k for k in range(len(middle)) if k not in left_out]
    number = np.repeat(kept, 2)
    balls = middle[number] + np.tile([[0, 0, 0.1], [0, 0, -0.1]], (len(kept), 1))
    return {"Points": balls, "cells": np.arange(len(balls))[:, None], "CellData/stone":
            number.astype(float), "CellData/velocity":
            np.stack([number, 0 * number, 0 * number + 1.0], 1),
            "PointData/radius": np.full(len(balls), 0.1)}


UNITS = {"stress_change": "Pa", "velocity": "m/s", "stone": "1"}


@pytest.fixture(name="run")
def made_run(tmp_path):
    """Fields at 1 s and 2 s; until then stones have moved by (0.03, 0, -0.01), one has gone."""
    folder = tmp_path / "run"
    for part, kind, instants in (
            ("ground", 12, [[bricks(8, 6)], [bricks(4, 6), bricks(4, 6, 2.0)]]),  # one rank, two
            ("stones", 1, [[clumps()], [clumps((0.03, 0, -0.01), left_out=[2])]])):
        files = []
        for time, pieces in enumerate(instants, 1):
            name = f"load_{time}_{part}.hdf"
            write_file(folder / "fields" / name, pieces, kind, UNITS)
            files.append({"name": name, "time": float(time)})
        (folder / f"fields/{part}.hdf.series").write_text(json.dumps({"files": files}))
    return folder


def layers(run, **choices):
    chosen = field_sections.Choices(**choices)
    name, fields = field_files.fields_at(run, chosen.parts, chosen.array, chosen.time,
                                         chosen.since)
    return [field_sections.layer_of(field, name, chosen) for field in fields]


def test_nodes_that_two_ranks_wrote_are_one_point(run):
    one, two = (layers(run, array="displacement", time=time)[0] for time in (1, 2))
    assert len(one.at) == len(two.at) == 9 * 7  # of one side of the plane model
    assert two.at == pytest.approx(one.at) and two.values == pytest.approx(one.values)
    assert one.values[:, 0] == pytest.approx(one.at.sum(axis=1), **EXACT)
    assert one.values[:, 2] == pytest.approx(-one.at[:, 1], **EXACT)


def test_stones_are_one_point_each_in_the_nearest_layer(run):
    stones, = layers(run, array="velocity")
    assert stones.at == pytest.approx(np.array([[x + 0.03, 0.19] for x in range(10) if x != 1]))
    assert stones.values[:, 0] == pytest.approx([2 * x for x in range(10) if x != 1])
    behind, = layers(run, array="velocity", at=0.15)
    assert behind.values[:, 0] == pytest.approx(np.arange(1, 20, 2))
    both, = layers(run, array="velocity", at=0.15, depth=0.2)
    assert len(both.at) == 19
    across, = layers(run, array="velocity", plane="yz", at=4, component="x")
    assert across.at == pytest.approx(np.array([[0, 0.19], [0.2, 0.19]]))
    assert across.values == pytest.approx([8, 9])


def test_scattered_stones_near_the_plane():
    rng = np.random.default_rng(1)
    place = rng.random((4000, 3)) * [4, 1, 1]  # 0.1 m apart
    kept = field_sections.in_slice(place[:, 1] - 0.5, place, None)
    assert kept == pytest.approx(np.abs(place[:, 1] - 0.5) <= 0.05)
    copies = np.concatenate([place + [4 * k, 0, 0] for k in range(9)])  # no layers either
    assert field_sections.in_slice(copies[:, 1] - 0.5, copies, None).sum() > 1000


def test_displacement_of_stones_between_two_instants(run):
    assert "needs --relative-to" in conftest.call("map", run, "--part", "stones", "--array",
                                                  "displacement", "-o", run / "out").stderr
    stones, ground = layers(run, since=1)
    assert stones.values == pytest.approx(np.tile([0.03, 0, -0.01], (9, 1)))
    assert np.abs(ground.values).max() == 0


@pytest.mark.parametrize("count", [600, 3000])  # all points, and the nearest of each place
def test_linear_field_is_reproduced(count):
    rng = np.random.default_rng(2)
    at = rng.random((count, 2)) * [20, 0.5]  # flat
    layer = field_sections.Layer("ground", at, at @ [2.0, -30.0] + 5, None)
    places = np.array([[1.0, 0.1], [19.0, 0.4], [10.0, 0.55]])
    assert field_sections.spline(layer, places) == pytest.approx(places @ [2, -30] + 5, rel=1e-7)


def test_spline_goes_through_the_points_and_is_smooth_between():
    x = np.linspace(0, 1, 25)
    at = np.stack(np.meshgrid(x, 0.1 * x), -1).reshape(-1, 2)
    layer = field_sections.Layer("ground", at, np.sin(4 * at[:, 0]) * at[:, 1], None)
    assert field_sections.spline(layer, at) == pytest.approx(layer.values, abs=1e-9)
    middle = (at[26:-26] + [0.5 / 24, 0.05 / 24])[:-24]
    inner = middle[(middle[:, 0] > 0.1) & (middle[:, 0] < 0.9)]
    wanted = np.sin(4 * inner[:, 0]) * inner[:, 1]
    assert field_sections.spline(layer, inner) == pytest.approx(wanted, abs=1e-4)


def area(path):
    """Enclosed by the loops of a path."""
    total = 0.0
    for loop in path.to_polygons(closed_only=True):
        x, z = np.asarray(loop).T
        total += 0.5 * np.sum(x[:-1] * z[1:] - x[1:] * z[:-1])
    return total


def test_contours_end_at_the_edge_of_the_elements(run):
    ground, = layers(run, array="stress_change", component="zz")
    assert area(ground.outline) == pytest.approx(4 * 0.6)
    assert ground.outline.contains_points([[0.01, -0.01], [3.99, -0.59]]).all()
    assert not ground.outline.contains_points([[-0.01, -0.3], [2, 0.01], [4.01, -0.3]]).any()
    assert len(ground.outline.vertices) < 8 * 6 * 4  # without the edges between elements


def winding(path, point):
    """How often the loops of a path run around a point: a clip path shows where it is not 0."""
    total = 0.0
    for loop in path.to_polygons(closed_only=True):
        ray = (np.asarray(loop) - point) @ [1, 1j]
        total += np.angle(ray[1:] / ray[:-1]).sum()
    return round(total / (2 * np.pi))


def test_stresses_have_a_spline_for_each_solid(tmp_path):
    """A layer, a block in it and a thin layer of one row below, each with a stress of its own."""
    piece = bricks(8, 6)
    centre = piece["Points"][piece["cells"]].mean(axis=1)
    solid = np.where(centre[:, 2] < -0.5, 2, (centre[:, 0] < 2) * 1)
    value = np.array([10.0, 500.0, -30.0])[solid]
    piece |= {"CellData/solid": solid.astype(float), "CellData/stress": value}
    write_file(tmp_path / "load_1_ground.hdf", [piece], 12, {"stress": "Pa", "solid": "1"})
    ground, = layers(tmp_path / "load_1_ground.hdf", array="stress")
    assert len(ground.at) == 48 and len(ground.solids) == 3
    assert [area(one.outline) for one in ground.solids] == pytest.approx([1.0, 1.0, 0.4])
    for one, wanted in zip(ground.solids, (10, 500, -30)):
        places = np.stack(np.meshgrid(np.linspace(0, 4, 41), np.linspace(-0.6, 0, 13)), -1)
        assert field_sections.values_at(one, places.reshape(-1, 2)) == pytest.approx(
            np.full(41 * 13, wanted))
    values = field_sections.spline(ground, np.array([[2.3, -0.3]]))
    assert values[0] < 9, "one spline through all would have been right here"
    figure = maps.draw([ground], "", field_sections.Choices(array="stress"), "Pa")
    plt.close(figure)
    moved, = layers(tmp_path / "load_1_ground.hdf", array="displacement", component="z")
    assert not moved.solids  # it does not jump


def test_outline_of_tetrahedra_in_space():
    rng = np.random.default_rng(3)
    box = np.array([[x, y, z] for x in (0, 3) for y in (0, 1) for z in (-1, 0)], float)
    place = np.concatenate([box, rng.random((60, 3)) * [3, 1, -1]])
    corners = place[scipy.spatial.Delaunay(place).simplices]
    path = field_sections.elements_of((corners,), [0, 2], 1, 0.5)
    inside = rng.random((100, 2)) * [3, -1]
    assert min(winding(path, point) for point in inside) >= 1
    assert {winding(path, point) for point in inside + [3, 0]} == {0}
    assert field_sections.elements_of((corners,), [0, 2], 1, 2.0) is None


def test_contours_of_stones_leave_gaps_out():
    x, z = np.meshgrid(np.arange(11.0), np.arange(4.0))
    at = np.stack([x.ravel(), z.ravel()], 1)
    at = at[(at[:, 1] < 2) | (at[:, 0] < 1) | (at[:, 0] > 9)]  # a crib of 9 m x 2 m
    edge = field_sections.edge_of(field_sections.Layer("stones", at, at[:, 0], None))
    assert 10 <= area(edge) <= 14 and not edge.contains_point((5, 2.5))
    assert edge.contains_points([[0.1, 0.1], [5, 0.5], [9.9, 0.9]]).all()


def drawn(run, **choices):
    chosen = field_sections.Choices(**choices)
    found = layers(run, **choices)
    return maps.draw(found, "title", chosen, "m"), found


def test_arrows_are_the_data(run):
    figure, found = drawn(run, array="displacement")
    arrows, = (one for one in figure.axes[0].collections if hasattr(one, "U"))
    x, z = arrows.XY.T
    assert len(x) == len(found[0].at)
    assert arrows.U == pytest.approx(x + z) and arrows.V == pytest.approx(-z)
    assert np.asarray(arrows.get_array()) == pytest.approx(np.hypot(x + z, z))
    assert [maps.scale_arrow(limit) for limit in (0.99, 5.0, 44.0)] == pytest.approx([0.5, 5, 20])
    plt.close(figure)


@pytest.mark.parametrize("array, component, label", [
    ("stress_change", "zz", "m, tension positive"),  # any unit
    ("displacement", "z", "m")])
def test_the_sign_of_stresses_is_stated(run, array, component, label):
    figure, _ = drawn(run, array=array, component=component)
    assert figure.axes[1].get_ylabel() == label
    plt.close(figure)


def test_arrows_end_where_few_are_longer():
    at = np.stack([np.arange(200.0), np.zeros(200)], 1)
    values = np.ones((200, 3)) * [0, 0, 3]
    values[7] = [0, 0, 300]
    figure = maps.draw([field_sections.Layer("stones", at, values, None)], "",
                       field_sections.Choices(), "N")
    arrows, = (one for one in figure.axes[0].collections if hasattr(one, "U"))
    assert arrows.V.max() == pytest.approx(3) and len(arrows.V) <= 81
    assert "arrows end at 3" in figure.axes[1].get_ylabel()
    plt.close(figure)


def test_command_writes_table_picture_and_points(run):
    ran = conftest.call("map", run, "--array", "stress_change", "--component", "zz", "--window",
                        "1", "3", "-0.4", "-0.1", "--time", "1.2", "-o", run / "out", "--format",
                        "png,svg,pdf,csv")
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout == (f"{run / 'out/map.png'}\nstress_change zz at 1 s, plane xz at y = 0 m\n"
                          "ground, 12 points: largest 9.95 Pa at x = 2.75 m, z = -0.35 m; least "
                          "5.05 Pa at x = 1.25 m, z = -0.15 m; mean 7.5 Pa\n")
    for form in ("png", "svg", "pdf"):
        assert (run / f"out/map.{form}").stat().st_size > 3000
    rows = (run / "out/map.csv").read_text().splitlines()
    assert rows[0] == "part,x_m,z_m,stress_change_zz_Pa" and len(rows) == 13
    numbers = np.array([[float(one) for one in row.split(",")[1:]] for row in rows[1:]])
    assert numbers[:, 2] == pytest.approx(3 * numbers[:, 0] - 2 * numbers[:, 1] + 1)


def test_field_file_by_itself(run):
    file = run / "fields/load_2_stones.hdf"
    ran = conftest.call("map", file, "-o", run / "out", "--format", "csv")
    assert ran.returncode == 0 and "velocity at 2 s, plane xz" in ran.stdout, ran.stderr
    assert "magnitude" in (run / "out/map_lines.csv").read_text()
    rows = (run / "out/map.csv").read_text().splitlines()
    assert rows[:2] == ["part,x_m,z_m,velocity_x_m_s,velocity_y_m_s,velocity_z_m_s",
                        "stones,0.03,0.19,0,0,1"]


@pytest.mark.parametrize("words, expected", [
    (["--array", "none"], "stones, ground: there is no array none; the arrays are displacement, "
     "radius, stone, stress_change, velocity"),
    (["--array", "stress_change"], "components xx, yy, zz, xy, yz, zx: choose one with --comp"),
    (["--array", "stress_change", "--component", "x"], "has the components xx"),
    (["--array", "radius", "--component", "x"], "one number at each point: leave out --component"),
    (["--part", "train"], "no fields of train, but of ground, stones: choose with --part"),
    (["--window", "20", "30", "0", "1"], "the points have x = 0 to 4 m, y = -0.5 to 0.5 m"),
    (["--window", "3", "1", "0", "1"], "the smaller number of each axis first"),
    (["--relative-to", "2"], "the nearest instant, 2 s, is not before the one that is drawn"),
    (["--array", "velocity", "--component", "z"], "three points or more that are not on one line"),
])
def test_refused(run, words, expected):
    ran = conftest.call("map", run, *words, "-o", run / "out")
    assert ran.returncode == 2 and expected in ran.stderr, ran.stderr
    assert len(ran.stderr.splitlines()) == 1


def test_other_sources_are_refused(run, tmp_path):
    empty = tmp_path / "empty"
    empty.mkdir()
    with h5py.File(tmp_path / "other.hdf", "w") as file:
        file["a"] = 1.0
    for source, expected in ((empty, "run its deck with output.fields=true"),
                             (tmp_path / "none", "does not exist"),
                             (tmp_path / "other.hdf", "is not a field file")):
        ran = conftest.call("map", source, "-o", tmp_path / "out")
        assert ran.returncode == 2 and expected in ran.stderr, ran.stderr
    ran = conftest.call("map", run / "fields/load_1_ground.hdf", "--time", "1", "-o",
                        tmp_path / "out")
    assert ran.returncode == 2 and "one part at one instant" in ran.stderr
    with pytest.raises(read.Unreadable, match="does not exist"):
        field_files.fields_at(tmp_path / "gone_stones.hdf", ("stones",))
