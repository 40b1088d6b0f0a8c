"""Scanned rails: points are turned into the frame of the track, cleaned, put on a grid and
smoothed.

    points = scan.load("crossing.csv")                  # or .stl; m, [point, x y z]
    grid = scan.gridded(scan.cleaned(points))
    grid = scan.smoothed(grid)
"""
import dataclasses
import math
import pathlib

import numpy as np
import scipy.ndimage
import scipy.spatial

from trackbed_post import measured, read

NEIGHBOURS = 8        # of a point, with which it is compared
FAR = 4.0             # an outlier's distance from them, over the median of theirs
# m; and median deviations of the neighbours from their median: an outlier's height above or below
# this median exceeds the sum. Slopes have large median deviations.
HIGH, SPREADS = 0.5e-3, 3.0
# m; steps of the grid and lengths of the moving averages, of the thesis "Model-based condition
# monitoring of railway switches and crossings", 4.1.1.
ALONG, ACROSS = 1e-3, 1e-4
MEAN_ALONG, MEAN_ACROSS = 20e-3, 2e-3
# To the nearest point: further away nothing is known. In spacings of the points, m at most.
HOLE, LONGEST_HOLE = 3.0, 3e-3
LARGEST = 50_000_000  # cells of a grid
OUT = 0.05            # part of the points: if more are outliers, the scan is another thing
SAME = 1e-6           # m, in plan: of points that are closer the first one counts
SIDES = 1e-3          # m, of the triangles of an STL file between points
OFF = 1e-3            # m, root mean square of what marks may differ by
FLAT = 0.02           # m, of the mark that is furthest from the line closest to all
LEAST_HOLE = 3e-3     # m, length and width of a missing place
STRETCH = 0.1         # m, within which a surface known before and behind is missing between


@dataclasses.dataclass(frozen=True)
class Grid:
    """Heights z[x, y], m, at evenly spaced x and y, m; nan where nothing was scanned."""
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray


def lengths_of(path, wanted):
    """{name: column, m} in the order wanted, of a CSV with these columns of lengths in any order;
    others are left out."""
    names, table = measured.table_of(path)
    columns = {}
    for name, column in zip(names, table.T):
        stem = name.rpartition("_")[0]
        if stem not in wanted:
            continue
        factor, unit = measured.unit_of(name)
        if unit != "m":
            raise read.Unreadable(f"{path}: column {name} must be a length ({stem}_mm, {stem}_m)")
        if stem in columns:
            raise read.Unreadable(f"{path} has two columns of {stem}")
        columns[stem] = factor * column
    if missing := [stem for stem in wanted if stem not in columns]:
        raise read.Unreadable(f"{path} has no column {', '.join(missing)} with a unit of length "
                              f"({missing[0]}_mm); it has {', '.join(names)}")
    if not np.isfinite(list(columns.values())).all():
        raise read.Unreadable(f"{path}: some values are not numbers")
    return {stem: columns[stem] for stem in wanted}


def _of_csv(path):
    return np.stack(list(lengths_of(path, ("x", "y", "z")).values()), axis=1)


def _of_stl(path, unit):
    """Points of the triangles of a binary STL file, which has no unit: corners, and others between
    them if they are more than SIDES apart."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    if len(data) != 84 + 50 * count:
        raise read.Unreadable(f"{path} is no binary STL file; an ASCII one can be converted, or "
                              "give points as CSV (x_mm, y_mm, z_mm)")
    triangle = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    corners = unit * np.frombuffer(data, triangle, count, 84)["corners"].astype(float)
    if not np.isfinite(corners).all():
        raise read.Unreadable(f"{path}: some values are not numbers")
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0)
    parts = np.maximum(np.ceil(sides / SIDES), 1)
    if parts @ parts > LARGEST:
        raise read.Unreadable(f"{path} has triangles with sides of up to {sides.max():.3g} m: is "
                              "the unit right (--unit)?")
    points = []
    for part in np.unique(parts).astype(int):
        of = corners[parts == part]
        for i in range(part + 1):
            for j in range(part + 1 - i):
                points.append((i * of[:, 0] + j * of[:, 1] + (part - i - j) * of[:, 2]) / part)
    return np.unique(np.concatenate(points), axis=0) if points else np.empty((0, 3))


def load(path, unit=1e-3):
    """Points of a CSV or STL file, m; `unit`: that of an STL file, m."""
    path = pathlib.Path(path)
    points = _of_stl(path, unit) if path.suffix.lower() == ".stl" else _of_csv(path)
    _, once = np.unique(np.round(points[:, :2] / SAME), axis=0, return_index=True)
    if len(once) <= 2 * NEIGHBOURS:
        raise read.Unreadable(f"{path}: a scan needs more than {2 * NEIGHBOURS} points that do not "
                              "lie above each other")
    return points[np.sort(once)]


def cleaned(points):
    """Without points that are much further from their neighbours than these are from theirs, or
    much higher or lower than their neighbours in plan."""
    distance, near = scipy.spatial.cKDTree(points).query(points, NEIGHBOURS + 1)
    distance = distance[:, -1]
    kept = points[distance <= FAR * np.median(distance[near[:, 1:]], axis=1)]
    if len(kept) > NEIGHBOURS:
        around = scipy.spatial.cKDTree(kept[:, :2]).query(kept[:, :2], NEIGHBOURS + 1)[1][:, 1:]
        heights = kept[around, 2]
        middle = np.median(heights, axis=1)
        spread = np.median(np.abs(heights - middle[:, None]), axis=1)
        kept = kept[np.abs(kept[:, 2] - middle) <= HIGH + SPREADS * spread]
    if len(kept) < (1 - OUT) * len(points):
        raise read.Unreadable(f"{len(points) - len(kept)} of {len(points)} points are outliers: is "
                              "z upwards, seen from above, and is the unit right?")
    return kept


def beside_a_line(places):
    """m, of the place that is furthest from the line through the origin closest to all."""
    along = np.linalg.svd(places)[2][0]
    return float(np.linalg.norm(places - np.outer(places @ along, along), axis=1).max())


def turned(points, scanned, true):
    """Points in the frame of the track by the rotation and shift that bring the `scanned` places of
    three marks or more to the `true` ones with the least squares; root mean square of what remains,
    m; whether the scan's z then points downwards."""
    scanned, true = np.asarray(scanned, float), np.asarray(true, float)
    middle, wanted = scanned.mean(axis=0), true.mean(axis=0)
    beside = min(beside_a_line(of - of.mean(axis=0)) for of in (scanned, true))
    if len(scanned) < 3 or beside < FLAT:
        raise read.Unreadable(f"marks: three or more are needed; one must be at least "
                              f"{1e3 * FLAT:g} mm from the line that is closest to all, the "
                              f"furthest is at {1e3 * beside:.3g} mm")
    rotation, _ = scipy.spatial.transform.Rotation.align_vectors(true - wanted, scanned - middle)
    remains = rotation.apply(scanned - middle) + wanted - true
    off = float(np.sqrt(np.mean(np.sum(remains**2, axis=1))))
    if off > OFF:
        raise read.Unreadable(f"marks: the scanned places differ from the true ones by "
                              f"{1e3 * off:.3g} mm (root mean square, at most {1e3 * OFF:g}) after "
                              "the best turn; are units and axes right?")
    return rotation.apply(points - middle) + wanted, off, bool(rotation.apply([0, 0, 1])[2] < 0)


def marks(path):
    """(scanned places, true places), m, of a CSV with the columns x y z and true_x true_y true_z.
    """
    columns = lengths_of(pathlib.Path(path),
                         [f"{which}{axis}" for which in ("", "true_") for axis in "xyz"])
    places = np.stack(list(columns.values()), axis=1)
    return places[:, :3], places[:, 3:]


def hole_of(points):
    """m, distance from all points beyond which nothing is known: in spacings of the points, of the
    area that they cover, so that they may lie on lines."""
    covered = len(np.unique(np.floor(points[:, :2] / LONGEST_HOLE), axis=0)) * LONGEST_HOLE**2
    return min(max(HOLE * (covered / len(points))**0.5, ACROSS), LONGEST_HOLE)


def gridded(points, along=ALONG, across=ACROSS):
    """Heights of the nearest points in plan."""
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    first, last = np.ceil(low / (along, across)), np.floor(high / (along, across))
    counts = last - first + 1
    if not 2 <= min(counts) or not math.prod(counts) <= LARGEST:
        raise read.Unreadable(
            f"the scan of {high[0] - low[0]:.4g} m by {high[1] - low[1]:.4g} m would have "
            f"{counts[0]:.4g} x {counts[1]:.4g} cells of {1e3 * along:g} x {1e3 * across:g} mm; "
            f"possible are at least 2 each and {LARGEST:.3g} in all; is the unit right?")
    x, y = ((first[k] + np.arange(int(counts[k]))) * step for k, step in enumerate((along, across)))
    hole, tree = hole_of(points), scipy.spatial.cKDTree(points[:, :2])
    z = np.empty((len(x), len(y)))
    for row, place in zip(z, x):  # the whole grid at once would fill the memory
        distance, nearest = tree.query(np.stack([np.full(len(y), place), y], axis=1))
        row[:] = np.where(distance <= hole, points[nearest, 2], np.nan)
    return Grid(x, y, z)


def missing(grid):
    """Of each place of the grid, whether nothing is known there, but at the same y within STRETCH
    before and behind: a flangeway, which is oblique, and what lies beside the rail are not."""
    known, count = np.isfinite(grid.z), 2 * int(round(STRETCH / (grid.x[1] - grid.x[0]))) + 1
    # A maximum and then a minimum over twice STRETCH; the ends are known to be nothing.
    wide = np.pad(known, ((count, count), (0, 0)))
    closed = scipy.ndimage.minimum_filter1d(
        scipy.ndimage.maximum_filter1d(wide, count, axis=0), count, axis=0)
    holes = closed[count:-count] & ~known
    # Edges of rails are oblique and frayed by the spacing of the points.
    least = [int(round(LEAST_HOLE / (axis[1] - axis[0]))) + 1 for axis in (grid.x, grid.y)]
    return scipy.ndimage.maximum_filter(scipy.ndimage.minimum_filter(holes, least), least,
                                        origin=[-1 if count % 2 == 0 else 0 for count in least])


def smoothed(grid, along=MEAN_ALONG, across=MEAN_ACROSS):
    """Moving averages along x and y, m, of what is known; holes remain. Without half an average at
    both ends of x, where it would be one-sided."""
    known = np.isfinite(grid.z)
    values, weights = np.where(known, grid.z, 0.0), known.astype(float)
    counts = [2 * int(round(length / (coordinates[1] - coordinates[0]) / 2)) + 1
              for length, coordinates in ((along, grid.x), (across, grid.y))]
    if len(grid.x) <= counts[0] + 1:
        raise read.Unreadable(f"the scan is {grid.x[-1] - grid.x[0]:.3g} m long; it must be longer "
                              f"than {along:g} m, over which heights are averaged")
    for axis, count in enumerate(counts):
        values, weights = (scipy.ndimage.uniform_filter1d(of, count, axis=axis, mode="constant")
                           for of in (values, weights))
    with np.errstate(invalid="ignore", divide="ignore"):
        z = np.where(known, values / weights, np.nan)
    inner = slice(counts[0] // 2, len(grid.x) - counts[0] // 2)
    return Grid(grid.x[inner], grid.y, z[inner])
