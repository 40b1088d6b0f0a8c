#!/usr/bin/env python3
"""The benchmark scripts read checkpoints: their input files for LAMMPS have the number, mass and
position of the stones. LAMMPS itself is not needed.

    bench_scripts.py PROGRAM FOLDER
"""
import pathlib
import subprocess
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "jobs"), str(ROOT / "tests/support")]
import bench_spheres  # noqa: E402
import bench_stones  # noqa: E402
from results import checkpoint  # noqa: E402

SHORT = ["bed.height=0.08", "bed.shapes=6", "stage.fill.duration=0.02",
         "stage.settle.duration=0.002", "stage.rest.duration=0.002", "--force"]


def made(program, name, folder):
    place = folder / name
    subprocess.run([program, "run", ROOT / f"inputs/bench/{name}.toml", *SHORT, "-o", place],
                   check=True, stdout=subprocess.DEVNULL)
    return place / "stage_settle.h5"


def rows(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    first = lines.index("Atoms") + 2
    return np.array([[float(word) for word in line.split()] for line in lines[first:]])


def expect(holds, what):
    if not holds:
        raise SystemExit(what)


def check_refusals(program, folder):
    """One message and a code that is not 0, before anything is written."""
    empty = {"PATH": str(folder)}
    for script, *words, sentence in (
            ("bench_spheres.py", "two arguments are needed: bench_spheres.py TRACKBED"),
            ("bench_stones.py", program, "two arguments are needed: bench_stones.py TRACKBED"),
            ("bench_stones.py", folder / "none", folder, "none is not an executable program"),
            ("bench_spheres.py", program, folder / "bench", "lmp was not found: install")):
        ran = subprocess.run([sys.executable, ROOT / "jobs" / script, *words], env=empty,
                             capture_output=True, text=True, check=False)
        expect(ran.returncode != 0 and sentence in ran.stderr and ran.stderr.count("\n") == 1,
               f"{script} {words}: {ran.returncode}, {ran.stderr}")
    expect(not (folder / "bench").exists(), "a refused script must not leave a folder")


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    check_refusals(program, folder)
    state = made(program, "spheres", folder)
    bench_spheres.write_lammps(state, folder)
    spheres = rows(folder / "spheres.data")
    stones = checkpoint(state)
    radius = stones["particles/scale"].ravel() * stones["particles/template/radius"][0]
    expect(np.allclose(spheres[:, 2], 2 * radius), "diameters of the spheres")
    expect("timestep" in (folder / "spheres.in").read_text(), "input of the spheres")

    state = made(program, "clumps", folder)
    count = bench_stones.Clumps(state).write(folder)
    bodies = np.loadtxt(folder / "clumps.bodies", skiprows=1)
    balls = rows(folder / "clumps.data")
    expect(len(bodies) == count and np.array_equal(np.unique(balls[:, -4]), bodies[:, 0]),
           "the number of spheres of every clump")
    mass = np.bincount(balls[:, -4].astype(int),
                       balls[:, -5] * np.pi / 6 * balls[:, 5]**3)[1:]
    expect(np.allclose(mass, bodies[:, 1]), "the mass of a clump is that of its spheres")
    print(f"{len(spheres)} spheres and {count} clumps of {len(balls)} spheres written for LAMMPS")


if __name__ == "__main__":
    main()
