"""Meshes of angular rocks with dents in place of scans: closed, star-shaped about their centres."""
import numpy as np
import scipy.spatial

LEVELS = 3  # each divides every triangle of an icosahedron into four


def sphere():
    """Vertices on the unit sphere and triangles, from an icosahedron."""
    g = (1 + 5**0.5) / 2
    vertices = [(a, b, 0) for a in (-1, 1) for b in (-g, g)]
    vertices = np.array(vertices + [(0, a, b) for a, b, _ in vertices]
                        + [(b, 0, a) for a, b, _ in vertices], dtype=float)
    near = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    edge = np.isclose(near, 2)
    triangles = [(i, j, k) for i in range(12) for j in range(i + 1, 12) for k in range(j + 1, 12)
                 if edge[i, j] and edge[j, k] and edge[i, k]]
    triangles = [t if np.linalg.det(vertices[list(t)]) > 0 else t[::-1] for t in triangles]
    points = list(vertices / np.linalg.norm(vertices[0]))
    for _ in range(LEVELS):
        middle, finer = {}, []

        def between(i, j):
            key = min(i, j), max(i, j)
            if key not in middle:
                middle[key] = len(points)
                point = points[i] + points[j]
                points.append(point / np.linalg.norm(point))
            return middle[key]
        for i, j, k in triangles:
            a, b, c = between(i, j), between(j, k), between(k, i)
            finer += [(i, a, c), (j, b, a), (k, c, b), (a, b, c)]
        triangles = finer
    return np.array(points), np.array(triangles)


def rock(seed, dents=3, depth=0.45, width=0.75):
    """Vertices and triangles of one rock: a polyhedron of random planes around a ball, stretched,
    with dents of a relative `depth` and a `width` in radians."""
    random = np.random.default_rng(seed)
    directions, triangles = sphere()
    normals = random.normal(size=(14, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    planes = np.concatenate([normals, -normals[:4]])  # four pairs of parallel ones
    distance = random.uniform(0.75, 1.0, len(planes))
    facing = np.maximum(directions @ planes.T, 1e-9)
    radius = np.minimum((distance / facing).min(axis=1), 1.4)
    centres = random.normal(size=(dents, 3))
    centres /= np.linalg.norm(centres, axis=1)[:, None]
    angle = np.arccos(np.clip(directions @ centres.T, -1, 1))
    radius *= np.prod(1 - depth * np.exp(-(angle / width)**4), axis=1)
    return directions * radius[:, None] * (1.2, 1.0, 0.75), triangles


def hull(vertices):
    """Vertices and triangles of the convex hull, facing outwards."""
    found = scipy.spatial.ConvexHull(vertices)
    used, triangles = np.unique(found.simplices, return_inverse=True)
    points, triangles = vertices[used], triangles.reshape(-1, 3)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - points.mean(axis=0)) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return points, triangles


def obj(vertices, triangles):
    """Text of an OBJ file."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices]
    lines += [f"f {i} {j} {k}" for i, j, k in triangles + 1]
    return "\n".join(lines) + "\n"
