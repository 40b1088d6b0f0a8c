"""Scanned rails: points are cleaned, turned into the frame of the track, put on a grid and
smoothed.

    points = scan.load("crossing.csv")                  # or .stl; m, [point, x y z]
    grid = scan.gridded(scan.cleaned(points))
    grid = scan.smoothed(grid)
"""
import dataclasses
import pathlib

import numpy as np
import scipy.ndimage
import scipy.spatial

from trackbed_post import measured, read

NEIGHBOURS = 8        # of a point, with which it is compared
FAR = 4.0             # an outlier's distance from them, over the median of all points
# m; and median deviations of the neighbours from their median: an outlier's height above or below
# this median exceeds the sum. Slopes have large median deviations.
HIGH, SPREADS = 0.5e-3, 3.0
# m; steps of the grid and lengths of the moving averages, of the thesis "Model-based condition
# monitoring of railway switches and crossings", 4.1.1.
ALONG, ACROSS = 1e-3, 1e-4
MEAN_ALONG, MEAN_ACROSS = 20e-3, 2e-3
HOLE = 3e-3           # m, to the nearest point: further away nothing is known
LARGEST = 50_000_000  # cells of a grid


@dataclasses.dataclass(frozen=True)
class Grid:
    """Heights z[x, y], m, at evenly spaced x and y, m; nan where nothing was scanned."""
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray


def _of_csv(path):
    names, table = measured.table_of(path)
    columns = {}
    for name, column in zip(names, table.T):
        factor, unit = measured.unit_of(name)
        if unit != "m":
            raise read.Unreadable(f"{path}: column {name} must be a length (x_mm, y_mm, z_mm)")
        columns[name.rpartition("_")[0]] = factor * column
    if missing := [axis for axis in "xyz" if axis not in columns]:
        raise read.Unreadable(f"{path} has no column {', '.join(missing)} with a unit (x_mm, y_mm, "
                              f"z_mm); it has {', '.join(names)}")
    return np.stack([columns[axis] for axis in "xyz"], axis=1)


def _of_stl(path, unit):
    """Corners of the triangles of a binary STL file, which has no unit."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    if len(data) != 84 + 50 * count:
        raise read.Unreadable(f"{path} is no binary STL file; an ASCII one can be converted, or "
                              "give points as CSV (x_mm, y_mm, z_mm)")
    triangle = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    corners = np.frombuffer(data, triangle, count, 84)["corners"].reshape(-1, 3)
    return unit * np.unique(corners, axis=0).astype(float)


def load(path, unit=1e-3):
    """Points of a CSV or STL file, m; `unit`: that of an STL file, m."""
    path = pathlib.Path(path)
    points = _of_stl(path, unit) if path.suffix.lower() == ".stl" else _of_csv(path)
    if len(points) <= NEIGHBOURS or not np.isfinite(points).all():
        raise read.Unreadable(f"{path}: a scan needs more than {NEIGHBOURS} points, all of them "
                              "numbers")
    return points


def cleaned(points):
    """Without points that are much further from their neighbours than most, or much higher or lower
    than their neighbours in plan."""
    distance = scipy.spatial.cKDTree(points).query(points, NEIGHBOURS + 1)[0][:, -1]
    points = points[distance <= FAR * np.median(distance)]
    around = scipy.spatial.cKDTree(points[:, :2]).query(points[:, :2], NEIGHBOURS + 1)[1][:, 1:]
    heights = points[around, 2]
    middle = np.median(heights, axis=1)
    spread = np.median(np.abs(heights - middle[:, None]), axis=1)
    return points[np.abs(points[:, 2] - middle) <= HIGH + SPREADS * spread]


def turned(points, scanned, true):
    """Points in the frame of the track by the rotation and shift that bring the `scanned` places of
    three marks or more to the `true` ones with the least squares; root mean square of what remains,
    m."""
    scanned, true = np.asarray(scanned, float), np.asarray(true, float)
    middle, wanted = scanned.mean(axis=0), true.mean(axis=0)
    if len(scanned) < 3 or min(np.linalg.matrix_rank(of - of.mean(axis=0), tol=1e-6)
                               for of in (scanned, true)) < 2:
        raise read.Unreadable("marks: three or more are needed that do not lie on a line")
    rotation, _ = scipy.spatial.transform.Rotation.align_vectors(true - wanted, scanned - middle)
    remains = rotation.apply(scanned - middle) + wanted - true
    return (rotation.apply(points - middle) + wanted,
            float(np.sqrt(np.mean(np.sum(remains**2, axis=1)))))


def marks(path):
    """(scanned places, true places) of a CSV with the columns x y z and true_x true_y true_z."""
    names, table = measured.table_of(path)
    columns = {name.rpartition("_")[0]: measured.unit_of(name)[0] * column
               for name, column in zip(names, table.T)}
    wanted = [f"{which}{axis}" for which in ("", "true_") for axis in "xyz"]
    if set(columns) != set(wanted):
        raise read.Unreadable(f"{path} must have the columns {', '.join(wanted)} with their units "
                              f"(x_mm, true_x_m); it has {', '.join(names)}")
    places = np.stack([columns[name] for name in wanted], axis=1)
    return places[:, :3], places[:, 3:]


def gridded(points, along=ALONG, across=ACROSS, hole=HOLE):
    """Heights of the nearest points in plan."""
    (x_low, y_low), (x_high, y_high) = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    x = np.arange(np.ceil(x_low / along), np.floor(x_high / along) + 1) * along
    y = np.arange(np.ceil(y_low / across), np.floor(y_high / across) + 1) * across
    if len(x) * len(y) > LARGEST or len(x) < 2 or len(y) < 2:
        raise read.Unreadable(f"the scan of {x_high - x_low:.4g} m by {y_high - y_low:.4g} m would "
                              f"have {len(x)} x {len(y)} cells of {1e3 * along:g} x "
                              f"{1e3 * across:g} mm, at most {LARGEST:.3g} are possible; is the "
                              "unit right?")
    tree, z = scipy.spatial.cKDTree(points[:, :2]), np.empty((len(x), len(y)))
    for row, place in zip(z, x):  # the whole grid at once would fill the memory
        distance, nearest = tree.query(np.stack([np.full(len(y), place), y], axis=1))
        row[:] = np.where(distance <= hole, points[nearest, 2], np.nan)
    return Grid(x, y, z)


def smoothed(grid, along=MEAN_ALONG, across=MEAN_ACROSS):
    """Moving averages along x and y, m, of what is known; holes remain."""
    known = np.isfinite(grid.z)
    values, weights = np.where(known, grid.z, 0.0), known.astype(float)
    for axis, (length, coordinates) in enumerate(((along, grid.x), (across, grid.y))):
        count = 2 * int(length / (coordinates[1] - coordinates[0]) / 2) + 1
        values, weights = (scipy.ndimage.uniform_filter1d(of, count, axis=axis, mode="constant")
                           for of in (values, weights))
    with np.errstate(invalid="ignore", divide="ignore"):
        return Grid(grid.x, grid.y, np.where(known, values / weights, np.nan))
