"""Field files of a small model with known places, sizes and speeds: stones, a sleeper, a platen, a
wall, a rail with wheels and an element of the ground."""
import json

import h5py
import numpy as np

VERTICES, LINE, TRIANGLE, POLYGON, HEXAHEDRON = 2, 3, 5, 7, 12  # types of VTK
RADIUS = 0.25       # m, of the three stones at x = 0.5, 1.5, 2.5, z = 0.3
SPEEDS = ((2, 2, 2), (2, 4, 0), (2, 1, 0))  # m/s, of each stone at the instants
TIMES = (0.1, 0.2, 0.5)
STAGES = ("fill", "load", "load")
# Brick of a surface or element: its corners from its lowest and highest, in VTK's order.
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1],
                    [0, 1, 1]])
FACES = np.array([[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [2, 3, 7],
                  [2, 7, 6], [1, 2, 6], [1, 6, 5], [3, 0, 4], [3, 4, 7]])
SIDE = np.array([[0, 1, 5], [0, 5, 4]])  # the one at the lowest y
GROUND = ((0, -0.5, -1), (3, 0.5, 0))
SLEEPER, PLATEN, WALL = ((1, -0.4, 0.6), (2, 0.4, 0.8)), ((2.2, -0.4, 0.6), (2.8, 0.4, 0.7)), \
    ((0, -0.5, 0), (3, 0.5, 0.6))


def brick(low, high):
    return np.array(low) + CORNERS * (np.array(high) - low)


def write_grid(path, points, cells, kinds, point_data=None, cell_data=None):
    """VTKHDF file of cells given by lists of points."""
    with h5py.File(path, "w") as file:
        group = file.create_group("VTKHDF")
        group.attrs["Version"], group.attrs["Type"] = [1, 0], np.bytes_("UnstructuredGrid")
        group["NumberOfPoints"], group["NumberOfCells"] = [len(points)], [len(cells)]
        group["NumberOfConnectivityIds"] = [sum(map(len, cells))]
        group["Points"] = np.asarray(points, float)
        group["Connectivity"] = np.concatenate([np.asarray(cell) for cell in cells])
        group["Offsets"] = np.cumsum([0, *map(len, cells)])
        group["Types"] = np.broadcast_to(np.asarray(kinds, np.uint8), len(cells)).copy()
        for place, data in (("PointData", point_data), ("CellData", cell_data)):
            of_place = group.create_group(place)
            for name, (values, unit) in (data or {}).items():
                of_place[name] = np.asarray(values, float)
                of_place[name].attrs["units"], of_place[name].attrs["long_name"] = unit, "made"


def write_stones(path, speeds, x=(0.5, 1.5, 2.5)):
    velocity = np.zeros((3, 3))
    velocity[:, 2] = -np.array(speeds)
    write_grid(path, [[place, 0, 0.3] for place in x], [[0], [1], [2]], VERTICES,
               {"radius": ([RADIUS, RADIUS, 0.9 * RADIUS], "m")},
               {"velocity": (velocity, "m/s"), "stone": ([0, 1, 2], "1")})


def write_surfaces(path):
    """A sleeper, a platen, and a wall that hides all stones from the side."""
    points = np.concatenate([brick(*each) for each in (SLEEPER, PLATEN, WALL)])
    cells = np.concatenate([FACES, 8 + FACES, 16 + SIDE])
    write_grid(path, points, cells, TRIANGLE,
               cell_data={"part": ([2] * 12 + [3] * 12 + [0] * 2, "1")})


def write_train(path, wheels=(1.5, 9.0)):
    """A rail with its top at z = 1 in pieces of 0.5 m, also beside the bed, a wheel on it and one
    beyond the bed."""
    angle = 2 * np.pi * np.arange(64) / 64
    x = np.arange(-3, 10, 0.5)
    rail = np.column_stack([x, 0 * x, 1 + 0 * x]).repeat(2, axis=0)[1:-1]
    pieces = np.arange(len(rail)).reshape(-1, 2)
    rims = [np.column_stack([x + 0.4 * np.cos(angle), 0 * angle, 1.4 + 0.4 * np.sin(angle)])
            for x in wheels]
    write_grid(path, np.concatenate([rail, *rims]),
               [*pieces, *(len(rail) + 64 * k + np.arange(64) for k in range(len(wheels)))],
               [LINE] * len(pieces) + [POLYGON] * len(wheels),
               cell_data={"wheel": ([-1] * len(pieces) + [*range(len(wheels))], "1")})


def write_ground(path):
    write_grid(path, brick(*GROUND), [np.arange(8)], HEXAHEDRON,
               cell_data={"stress": ([1.0], "Pa")})


OTHERS = {"surfaces": write_surfaces, "ground": write_ground, "train": write_train}


def write_series(folder, series):
    """The lists of the files of each part: {part: [(name, time)]}."""
    for part, files in series.items():
        (folder / "fields" / f"{part}.hdf.series").write_text(json.dumps(
            {"file-series-version": "1.0",
             "files": [{"name": name, "time": time} for name, time in files]}), encoding="utf-8")
