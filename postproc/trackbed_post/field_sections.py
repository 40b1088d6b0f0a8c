"""Fields in a plane through the model: which points belong to it, and values between them.

Values between the points are those of a biharmonic (thin-plate) spline through all of them, or, if
they are many, through those nearest to each place (scipy's RBFInterpolator). Its coordinates are
divided by the usual distances of neighbours along both axes, since elements may be flat. It ends at
the edge of the elements, or of stones at the triangles of neighbours. Values at the centres of
elements have a spline for each solid, since stresses jump at the border of two. Cost of 50,000
places: 3 s of processor time among 50,000 elements in rows, 16 s among as many scattered stones.
"""
import collections
import dataclasses

import matplotlib.path
import numpy as np
import scipy.interpolate
import scipy.spatial

from trackbed_post import read

PARTS = ("stones", "ground", "solids")  # drawn if no part is chosen
PLANES = ("xz", "yz", "xy")
COMPONENTS = {3: ("x", "y", "z", "magnitude"), 6: ("xx", "yy", "zz", "xy", "yz", "zx")}
PRINCIPAL = ("largest", "middle", "least")  # components of arrays of principal values
TETRAHEDRA = (4, 10)  # nodes; the corners come first
ALL = 1000        # points up to which the spline is that through all
NEIGHBOURS = 40   # otherwise
CLOSE = 0.05      # of the distance of neighbours: closer points are one for the spline
LAYER = 0.1       # of the points near the plane: so many in one depth are a layer
LONG = 3.0        # of the median side: triangles with a longer one are beyond the stones


@dataclasses.dataclass(frozen=True)
class Choices:
    """What is drawn; lengths in m, times in s. `depth`: half the thickness of the slice; None: one
    layer of points."""
    array: str | None = None
    component: str | None = None
    parts: tuple[str, ...] = PARTS
    plane: str = "xz"
    at: float = 0.0
    depth: float | None = None
    window: tuple[float, ...] | None = None
    time: float | None = None
    since: float | None = None

    def axes(self):
        """Numbers of the axes in the plane, and of the one across it."""
        return ["xyz".index(one) for one in self.plane], 3 - sum(map("xyz".index, self.plane))


@dataclasses.dataclass(frozen=True)
class Layer:
    """Points in the plane, [point, 2], with their values; `outline`: path of the elements;
    `solids`: the Layer of each solid, if there are several and values jump between them."""
    part: str
    at: np.ndarray
    values: np.ndarray
    outline: matplotlib.path.Path | None
    solids: tuple["Layer", ...] = ()

    def within(self, window):
        low, high = np.reshape(window, (2, 2)).T
        kept = ((self.at >= low) & (self.at <= high)).all(axis=1)
        return dataclasses.replace(self, at=self.at[kept], values=self.values[kept])

    def size(self):
        """The values, of vectors their magnitudes."""
        return np.linalg.norm(self.values, axis=1) if self.values.ndim > 1 else self.values


def in_slice(across, place, depth):
    """Which points belong to the plane, whose distances are `across`: those within `depth`, or of
    points in layers the nearest layer, or those within half the mean distance of neighbours."""
    if depth is not None:
        return np.abs(across) <= depth
    if not len(across):
        return np.zeros(0, bool)
    extent = np.ptp(place, axis=0)
    layer = np.abs(across - across[np.argmin(np.abs(across))]) <= 1e-6 * extent.max()
    near = np.abs(across) <= 0.5 * np.cbrt(np.prod(extent) / len(place))
    return layer if layer.sum() >= LAYER * near.sum() else near


def outline_of(polygons):
    """Path around polygons, [polygon, corner, 2] each, that run around in the same sense: edges of
    two of them cancel, so that winding numbers, and what a clip path shows, remain."""
    corners = np.concatenate([one.reshape(-1, 2) for one in polygons])
    step = 1e-9 * max(np.ptp(corners, axis=0).max(initial=0), 1e-6)
    _, places, numbers = np.unique(np.round(corners / step), axis=0, return_index=True,
                                   return_inverse=True)
    edges, first = collections.Counter(), 0
    for one in polygons:
        of = numbers.ravel()[first:first + one[..., 0].size].reshape(one.shape[:2])
        edges.update(zip(of.ravel().tolist(), np.roll(of, -1, axis=1).ravel().tolist()))
        first += of.size
    following = collections.defaultdict(list)
    for (start, end), count in edges.items():
        if start != end and count > edges.get((end, start), 0):
            following[start] += [end] * (count - edges.get((end, start), 0))
    loops = []
    for start in list(following):
        while following[start]:
            loop = [start]
            while len(loop) == 1 or loop[-1] != start:
                loop.append(following[loop[-1]].pop())
            loops.append(matplotlib.path.Path(corners[places[loop]], closed=True))
    return matplotlib.path.Path.make_compound_path(*loops)


def elements_of(corners, axes, across, depth):
    """Outline of the elements that contain the depth; None if none does."""
    polygons = []
    for each in corners:
        cut = (each[..., across].min(axis=1) <= depth) & (each[..., across].max(axis=1) >= depth)
        flat = each[cut][..., axes]
        if flat.shape[1] in TETRAHEDRA:  # their faces cover what they cover, also with overlaps
            flat = flat[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3, 2)
        ray = flat - flat.mean(axis=1, keepdims=True)
        order = np.argsort(np.arctan2(ray[..., 1], ray[..., 0]), axis=1)
        polygons.append(np.take_along_axis(flat, order[..., None], axis=1))
    return outline_of(polygons) if sum(map(len, polygons)) else None


def component(name, values, wanted):
    """The values that are drawn: [point], or [point, 3] as arrows."""
    if values.ndim == 1 or values.shape[1] == 1:
        if wanted:
            raise read.Unreadable(f"{name} is one number at each point: leave out --component")
        return values.ravel()
    names = PRINCIPAL if name.startswith("principal") else COMPONENTS.get(values.shape[1], ())
    if wanted is None and names == COMPONENTS[3]:
        return values
    if wanted not in names:
        raise read.Unreadable(f"{name} has the components {', '.join(names)}: choose one with "
                              "--component")
    return np.linalg.norm(values, axis=1) if wanted == "magnitude" else \
        values[:, names.index(wanted)]


def layer_of(field, name, choices):
    axes, across = choices.axes()
    kept = in_slice(field.place[:, across] - choices.at, field.place, choices.depth)
    values = component(name, field.values, choices.component)
    kept &= np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    depth = choices.at if choices.depth is not None or not kept.any() else \
        np.median(field.place[kept, across])
    layer = Layer(field.part, field.place[kept][:, axes], values[kept],
                  elements_of(field.corners, axes, across, depth))
    if field.solid is None or len(numbers := np.unique(field.solid[kept])) < 2:
        return layer
    solids = []
    for number in numbers:
        here = kept & (field.solid == number)
        own = [each[of == number] for each, of in zip(field.corners, field.solids)]
        solids.append(Layer(field.part, field.place[here][:, axes], values[here],
                            elements_of(own, axes, across, depth)))
    return dataclasses.replace(layer, solids=tuple(one for one in solids if one.outline))


def triangles_of(layer):
    """(triangles, usual distances of neighbours along both axes)"""
    try:
        simplices = scipy.spatial.Delaunay(layer.at).simplices
    except (scipy.spatial.QhullError, ValueError):
        raise read.Unreadable(f"{layer.part}: contours need three points or more that are not on "
                              f"one line; {len(layer.at)} lie in the plane: choose a larger "
                              "--slice or another --plane") from None
    return simplices, np.median(np.ptp(layer.at[simplices], axis=1), axis=0)


def spline(layer, places):
    """Values of the biharmonic spline at places [place, 2]."""
    unit = triangles_of(layer)[1]
    which = np.unique(np.round(layer.at / (CLOSE * unit)), axis=0, return_inverse=True)[1].ravel()
    count = np.bincount(which)
    mean = [np.bincount(which, one) / count for one in (*layer.at.T, layer.values)]
    found = scipy.interpolate.RBFInterpolator(
        np.stack(mean[:2], 1) / unit, mean[2], kernel="thin_plate_spline",
        neighbors=NEIGHBOURS if len(count) > ALL else None)
    try:
        return found(places / unit)
    except np.linalg.LinAlgError:
        raise read.Unreadable(f"{layer.part}: the points in the plane are too unevenly spread for "
                              "contours: choose a --window or another --slice") from None


def values_at(layer, places):
    """Values of the spline; of elements in one row, which have none, those of the nearest one."""
    try:
        return spline(layer, places)
    except read.Unreadable:
        if layer.outline is None:
            raise
        return scipy.interpolate.NearestNDInterpolator(layer.at, layer.values)(places)


def edge_of(layer):
    """Path of the elements, or of the triangles between neighbours."""
    if layer.outline is not None:
        return layer.outline
    simplices, unit = triangles_of(layer)
    corners = layer.at[simplices]
    sides = np.linalg.norm((corners - np.roll(corners, 1, axis=1)) / unit, axis=2)
    kept = sides.max(axis=1) <= LONG * np.median(sides)
    return outline_of([corners[kept]])
