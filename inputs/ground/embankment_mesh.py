#!/usr/bin/env python3
"""The mesh of embankment.toml: an embankment with side slopes on level soil, as 10-node tetrahedra.

    embankment_mesh.py FILE.msh

Gmsh makes such files too (Mesh.ElementOrder = 2, physical groups as below); this script needs
nothing but Python. Format 4.1, ASCII.
"""
import itertools
import sys

LENGTH, CELLS_X = 1.8, 3           # m along the track
ACROSS = [-2.0, -1.2, 0.0, 1.2, 2.0]  # m, at the foot: soil beside, slope's foot, axis
CREST = [None, -0.8, 0.0, 0.8, None]  # m, at the top; none beyond the foot of the slope
HEIGHT, DEPTH, CELLS_UP, CELLS_DOWN = 0.6, 1.2, 1, 2
SURFACES = ["ends", "sides", "bottom", "top", "slopes"]
EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]  # Gmsh's order
FACES = [(0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 9, 7), (1, 2, 3, 5, 8, 9), (0, 3, 2, 7, 8, 6)]


def place(i, j, k):
    """Corner of the lattice of cells; k counts from the bottom."""
    x = LENGTH * i / CELLS_X
    if k <= CELLS_DOWN:
        return x, ACROSS[j], -HEIGHT - DEPTH + DEPTH * k / CELLS_DOWN
    fraction = (k - CELLS_DOWN) / CELLS_UP
    return x, ACROSS[j] + fraction * (CREST[j] - ACROSS[j]), -HEIGHT + HEIGHT * fraction


def tetrahedra():
    """Corners in the lattice, volume: six of each cell."""
    last = len(ACROSS) - 2
    for k in range(CELLS_DOWN + CELLS_UP):
        across = range(len(ACROSS) - 1) if k < CELLS_DOWN else range(1, last)
        for i, j in itertools.product(range(CELLS_X), across):
            for order in itertools.permutations(range(3)):
                corners = [[i, j, k]]
                for axis in order:
                    corners.append(list(corners[-1]))
                    corners[-1][axis] += 1
                odd = sum(a > b for a, b in itertools.combinations(order, 2)) % 2
                if odd:
                    corners[1], corners[2] = corners[2], corners[1]
                yield [tuple(c) for c in corners], 2 if k < CELLS_DOWN else 1


def side_of(corners):
    """Which surface an outer face belongs to, by its corners in the lattice."""
    def all_at(axis, value):
        return all(c[axis] == value for c in corners)
    if all_at(0, 0) or all_at(0, CELLS_X):
        return "ends"
    if all_at(2, 0):
        return "bottom"
    if all_at(2, CELLS_DOWN + CELLS_UP):
        return "top"
    if all_at(1, 0) or all_at(1, len(ACROSS) - 1):
        return "sides"
    return "slopes"


def main():
    places, numbers, elements, outer = [], {}, [], {}

    def number(*corners):
        key = tuple(sorted(corners))
        if key not in numbers:
            ends = [place(*c) for c in corners]
            places.append([sum(x) / len(ends) for x in zip(*ends)])
            numbers[key] = len(places)
        return numbers[key]

    for corners, volume in tetrahedra():
        nodes = [number(c) for c in corners]
        nodes += [number(corners[a], corners[b]) for a, b in EDGES]
        elements.append((volume, nodes))
        for face in FACES:
            key = tuple(sorted(nodes[n] for n in face))
            side = side_of([corners[n] for n in face[:3]])
            # A face of two elements is inside.
            outer[key] = None if key in outer else (side, [nodes[n] for n in face])
    triangles = [face for face in outer.values() if face]
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", "7"]
    lines += [f'2 {s + 1} "{name}"' for s, name in enumerate(SURFACES)]
    lines += ['3 1 "embankment"', '3 2 "soil"', "$EndPhysicalNames", "$Entities", "0 0 5 2"]
    lines += [f"{s} 0 0 0 1 1 1 1 {s} 0" for s in range(1, 6)]
    lines += [f"{v} 0 0 0 1 1 1 1 {v} 0" for v in (1, 2)]
    lines += ["$EndEntities", "$Nodes", f"1 {len(places)} 1 {len(places)}",
              f"3 1 0 {len(places)}", *map(str, range(1, len(places) + 1))]
    lines += [" ".join(f"{x:.12g}" for x in at) for at in places]
    blocks = [(2, s + 1, 9, [nodes for side, nodes in triangles if side == name])
              for s, name in enumerate(SURFACES)]
    blocks += [(3, v, 11, [nodes for volume, nodes in elements if volume == v]) for v in (1, 2)]
    total = len(triangles) + len(elements)
    lines += ["$EndNodes", "$Elements", f"{len(blocks)} {total} 1 {total}"]
    count = itertools.count(1)
    for dimension, entity, kind, rows in blocks:
        lines.append(f"{dimension} {entity} {kind} {len(rows)}")
        lines += [" ".join(map(str, [next(count), *nodes])) for nodes in rows]
    lines.append("$EndElements")
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
