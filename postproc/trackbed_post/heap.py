"""Angle of repose of a heap of stones from a checkpoint.

The surface is the top of the stones' shapes seen from above, in cells of a fraction of a stone. For
each height z between LEVELS of the heap's height, A is the area where the surface is higher; a
straight line through z against the radius sqrt(A/pi) is the flank, and its slope the tangent of the
angle. Areas require neither a choice of surface stones nor an exact axis; stones that protrude from
a flank or lie loose before its foot do not affect the slope. Comparison with other measures on
heaps of known angle: docs/decisions/heap_and_strength.md.
"""
import numpy as np

SECTORS = 8           # for the scatter of the angle
LEVELS = (0.2, 0.8)   # of the heap's height, between which the flank is fitted
LAYER = 1.0           # median stones: lower, single stones before the foot would count as heap
CELLS = 6             # per median stone, of the map of heights
STEPS = 25            # heights at which areas are taken


def rotation(attitude):
    """Rotation matrix of the quaternion x, y, z, w."""
    x, y, z, w = attitude
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def templates(saved):
    """Pieces of each template: corners of the core, planes of its faces (normal, distance) and
    rounding radius. `saved`: read.checkpoint."""
    def numbers(name):
        return saved[f"particles/template/{name}"].values

    corners, sizes = numbers("corners").reshape(-1, 3), numbers("sizes").reshape(-1, 2)
    faces, radii = numbers("faces").ravel(), numbers("radius").ravel()
    found, piece, corner, face = [], 0, 0, 0
    for count in numbers("pieces").ravel():
        pieces = []
        for _ in range(int(count)):
            points = corners[corner:corner + int(sizes[piece, 0])]
            corner += len(points)
            planes = []
            for _ in range(int(sizes[piece, 1])):
                on = faces[face + 1:face + 1 + int(faces[face])].astype(int)
                face += 1 + len(on)
                normal = np.cross(points[on[1]] - points[on[0]], points[on[2]] - points[on[0]])
                normal /= np.linalg.norm(normal)
                planes.append([*normal, normal @ points[on[0]]])
            pieces.append((points, np.reshape(planes, (-1, 4)), radii[piece]))
            piece += 1
        found.append(pieces)
    return found


def placed(saved):
    """Each piece of each stone in its pose: centre of the stone, corners and planes relative to it,
    rounding radius; m."""
    shapes = templates(saved)
    fields = (saved[f"particles/{name}"].values for name in
              ("position", "attitude", "scale", "shape"))
    for centre, attitude, scale, shape in zip(*fields):
        turned, size = rotation(attitude), float(np.ravel(scale)[0])
        for corners, planes, radius in shapes[int(np.ravel(shape)[0])]:
            yield (centre, size * corners @ turned.T,
                   np.c_[planes[:, :3] @ turned.T, size * planes[:, 3]], size * radius)


def tops(corners, planes, radius, x, y):
    """Height of a piece above its stone's centre at x, y (m, from the centre), minus infinity
    beside it. Rounded edges are approximated by sharp edges of the faces moved out by the radius,
    but not higher than the highest point of the piece. A piece without faces is a ball."""
    if len(planes) == 0:
        left = radius**2 - (x - corners[0, 0])**2 - (y - corners[0, 1])**2
        return np.where(left > 0, corners[0, 2] + np.sqrt(np.maximum(left, 0)), -np.inf)
    high, low = np.full(x.shape, np.inf), np.full(x.shape, -np.inf)
    beside = np.zeros(x.shape, dtype=bool)
    for nx, ny, nz, distance in planes:
        left = distance + radius - nx * x - ny * y
        if nz > 1e-9:
            high = np.minimum(high, left / nz)
        elif nz < -1e-9:
            low = np.maximum(low, left / nz)
        else:
            beside |= left < 0
    highest = corners[:, 2].max() + radius
    return np.where(beside | (high < low), -np.inf, np.minimum(high, highest))


def surface(pieces, cell):
    """Map of heights above the floor (z = 0) in squares of side `cell`: x, y of their centres and
    height, m; zero where there is no stone."""
    pieces = list(pieces)
    bounds = [(centre[:2] + corners[:, :2].min(axis=0) - radius,
               centre[:2] + corners[:, :2].max(axis=0) + radius)
              for centre, corners, _, radius in pieces]
    first = np.floor(np.min([low for low, _ in bounds], axis=0) / cell).astype(int)
    last = np.ceil(np.max([high for _, high in bounds], axis=0) / cell).astype(int)
    height = np.zeros(last - first)
    axes = [(np.arange(first[k], last[k]) + 0.5) * cell for k in range(2)]
    for (centre, corners, planes, radius), (low, high) in zip(pieces, bounds):
        span = tuple(slice(int(np.floor(low[k] / cell)) - first[k],
                           int(np.ceil(high[k] / cell)) - first[k]) for k in range(2))
        x, y = np.meshgrid(axes[0][span[0]] - centre[0], axes[1][span[1]] - centre[1],
                           indexing="ij")
        top = centre[2] + tops(corners, planes, radius, x, y)
        height[span] = np.maximum(height[span], top)
    return (*np.meshgrid(*axes, indexing="ij"), height)


def slope(levels, heights, cell, turn=2 * np.pi):
    """Angle in degrees, and the radii of the areas above the levels; `turn`: angle about the axis
    (rad) covered by the heights."""
    areas = [np.count_nonzero(heights > level) * cell**2 for level in levels]
    radii = np.sqrt(2 * np.array(areas) / turn)
    if np.ptp(radii) < cell:  # vertical, or no stones there
        return np.nan, radii
    return np.degrees(np.arctan(-np.polyfit(radii, levels, 1)[0])), radii


def flank(pieces, size):
    """Angle of a heap's flank, degrees, its scatter between SECTORS, and the flank: radii and
    heights, m. `size`: of the median stone, m. The height of the heap is the level above which an
    area of one stone squared remains."""
    cell = size / CELLS
    x, y, height = surface(pieces, cell)
    top = np.sort(height, axis=None)[-CELLS**2]
    levels = np.linspace(max(LEVELS[0] * top, LAYER * size), LEVELS[1] * top, STEPS)
    if levels[-1] < levels[0] + size:
        return np.nan, np.nan, np.zeros((0, 2))
    angle, radii = slope(levels, height, cell)
    heap = np.where(height > levels[0], height, 0)  # without the loose stones before the heap
    axis = [np.average(at, weights=heap) for at in (x, y)]
    sector = (np.arctan2(y - axis[1], x - axis[0]) + np.pi) // (2 * np.pi / SECTORS) % SECTORS
    parts = [slope(levels, height[sector == k], cell, 2 * np.pi / SECTORS)[0]
             for k in range(SECTORS)]
    return angle, np.nanstd(parts, ddof=1), np.c_[radii, levels]
