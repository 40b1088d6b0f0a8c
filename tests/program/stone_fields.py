#!/usr/bin/env python3
"""Field files show stones in their shapes: the faces of a stone enclose its volume. Balls are
points with their radius; plates and boxes are surfaces.

    stone_fields.py PROGRAM SOURCE_FOLDER FOLDER
"""
import pathlib
import shutil
import sys
import tomllib

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program  # noqa: E402
from results import checkpoint  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "postproc"))
from trackbed_post import read  # noqa: E402

SHORT = ["output.fields=true", "stage[0].duration=2e-3"]
# Corners are on the rounded surface: with a rounding of 2 mm each face is 0.85 mm within the stone,
# whose least side is 30 mm, hence at most three times 5.6 % of the volume are missing.
SHORT_OF = 0.17


def cells_of(file):
    """(points, [nodes of each cell], kinds, other arrays) of a field file of one rank."""
    found = {name.removeprefix("VTKHDF/"): item.values
             for name, item in read.datasets(file).items()}
    ends = found["Offsets"]
    nodes = [found["Connectivity"][a:b] for a, b in zip(ends[:-1], ends[1:])]
    return found["Points"], nodes, found["Types"], found


def enclosed(points, faces):
    """Volume within closed faces, m^3, by the divergence theorem."""
    total = 0.0
    for face in faces:
        a = points[face[0]]
        for b, c in zip(points[face[1:-1]], points[face[2:]]):
            total += np.dot(a, np.cross(b, c)) / 6
    return total


def check_space(program, source, folder):
    """Three blocks of a deck under inputs, and the box and plate below them."""
    made = folder / "stack"
    program.done(1, "run", source / "inputs/verify/stack.toml", *SHORT, "-o", made)
    file, = (made / "fields").glob("*_stones.hdf")
    with h5py.File(file, "r") as fields, h5py.File(made / "results.h5", "r") as results:
        if fields.attrs["build"] != results.attrs["build"] or not fields.attrs["title"]:
            raise SystemExit(f"{file} does not state its origin: {dict(fields.attrs)}")
    points, nodes, kinds, found = cells_of(file)
    if set(kinds) != {7}:
        raise SystemExit(f"blocks must be polygons (7), not {set(kinds)}")
    saved = checkpoint(made)
    for number in np.unique(found["CellData/stone"]):
        volume = enclosed(points, [nodes[k] for k in
                                   np.flatnonzero(found["CellData/stone"] == number)])
        at = list(saved["particles/id"].ravel()).index(number)
        shape = int(saved["particles/shape"].ravel()[at])
        whole = (saved["particles/template/solid"][shape, 0]
                 * saved["particles/scale"].ravel()[at]**3)
        print(f"stone {number:.0f}: {volume / whole:.3f} of its volume within its faces")
        if not 1 - SHORT_OF < volume / whole < 1:
            raise SystemExit(f"stone {number}: {volume} of {whole} m^3 within its faces")
    check_acceleration(source / "inputs/verify/stack.toml", saved, found)
    check_contacts(made, saved)
    surfaces, = (made / "fields").glob("*_surfaces.hdf")
    _, nodes, kinds, found = cells_of(surfaces)
    if set(kinds) != {5} or not set(found["CellData/part"]) <= {0, 1}:
        raise SystemExit(f"surfaces: kinds {set(kinds)}, parts {set(found['CellData/part'])}")


def check_acceleration(deck, saved, found):
    """That of contact forces and weight, for the masses of the checkpoint.

    Fields are 32-bit floats: forces and accelerations up to twice gravity are off by 6e-8 of it.
    """
    given = tomllib.loads(deck.read_text(encoding="utf-8"))
    mass = (saved["particles/template/solid"][saved["particles/shape"].ravel(), 0]
            * saved["particles/scale"].ravel()**3 * given["material"][0]["density"])
    of_stone = dict(zip(saved["particles/id"].ravel(), mass))
    masses = np.array([of_stone[number] for number in found["CellData/stone"].ravel()])
    force = found["CellData/force"].reshape(-1, 3)
    wanted = force / masses[:, None] - [0, 0, 9.81]
    if not np.abs(force).max() > 0 or not np.allclose(
            found["CellData/acceleration"].reshape(-1, 3), wanted, rtol=0, atol=4 * 9.81 * 6e-8):
        raise SystemExit(f"accelerations {found['CellData/acceleration']}, wanted {wanted} m/s2")


def check_motion(deck, saved, found):
    """Masses, and angular velocities of balls: angular momentum over moment of inertia."""
    given = tomllib.loads(deck.read_text(encoding="utf-8"))
    radius = found["PointData/radius"].ravel()
    mass = given["material"][0]["density"] * 4 / 3 * np.pi * radius**3
    if not np.allclose(found["CellData/mass"].ravel(), mass, rtol=1e-6):
        raise SystemExit(f"masses {found['CellData/mass']}, wanted {mass} kg")
    order = np.argsort(saved["particles/id"].ravel())
    at = order[np.searchsorted(saved["particles/id"].ravel()[order],
                               found["CellData/stone"].ravel())]
    spin = saved["particles/angular_momentum"][at] / (0.4 * mass * radius**2)[:, None]
    shown = found["CellData/angular_velocity"].reshape(-1, 3)
    if not np.abs(spin).max() > 0 or not np.allclose(shown, spin, rtol=1e-6, atol=1e-9):
        raise SystemExit(f"angular velocities {shown}, wanted {spin} rad/s")


def check_contacts(made, saved):
    """`to_centre` leads from each end of a contact to its stone, and files state their time."""
    file, = (made / "fields").glob("*_contacts.hdf")
    points, nodes, _, found = cells_of(file)
    numbers = found["PointData/stone"].ravel()
    reached = points + found["PointData/to_centre"].reshape(-1, 3)
    centres = dict(zip(saved["particles/id"].ravel(), saved["particles/position"]))
    ends = np.flatnonzero(numbers >= 0)
    wanted = np.array([centres[number] for number in numbers[ends]])
    if len(nodes) < 3 or not np.allclose(reached[ends], wanted, rtol=0, atol=1e-6):
        raise SystemExit(f"contacts lead to {reached[ends]}, not to the stones at {wanted} m")
    on_surface = numbers < 0
    if not on_surface.any() or found["PointData/to_centre"].reshape(-1, 3)[on_surface].any():
        raise SystemExit(f"ends on surfaces must stay where they are: {found}")
    times = found["FieldData/TimeValue"]
    with h5py.File(made / "results.h5", "r") as results:
        last = results["history/time"][-1]
    if times.shape != (1,) or not 0 <= times[0] - last < 1e-3:
        raise SystemExit(f"{file} is of {times} s, the last row of {last} s")


def check_balls(program, source, folder):
    made = folder / "impact"
    program.done(1, "run", source / "inputs/verify/impact.toml", *SHORT, "-o", made)
    file, = (made / "fields").glob("*_stones.hdf")
    _, _, kinds, found = cells_of(file)
    if set(kinds) != {2} or not (found["PointData/radius"] > 0).all():
        raise SystemExit(f"a ball is a point with its radius: {found}")
    check_motion(source / "inputs/verify/impact.toml", checkpoint(made), found)


def main():
    program, source, folder = Program(sys.argv[1]), *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_space(program, source, folder)
    check_balls(program, source, folder)


if __name__ == "__main__":
    main()
