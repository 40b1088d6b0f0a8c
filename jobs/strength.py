#!/usr/bin/env python3
"""Heaps and triaxial tests of one kind of stone with one thing changed at a time.

    strength.py PROGRAM FOLDER heap|triaxial [--rows NAME...] [--seeds 1 2 3]

Runs inputs/bed/repose.toml or triaxial.toml on one rank for each row and seed, in FOLDER/ROW_SEED;
finished runs are not repeated, so the same command continues where it was stopped. Prints a
line per row: mean and standard deviation over the seeds. The tables made with it are those of
docs/decisions/heap_and_strength.md; a row takes 10 s to 2 min of a core per seed.
"""
import argparse
import json
import pathlib
import subprocess
import sys

import numpy as np

import launch

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "postproc"))
from trackbed_post import heap, laboratory, read  # noqa: E402


def contacts(**values):
    """The same value for stones and walls."""
    return [f"contact.{k}.{name}={value}" for k in (0, 1) for name, value in values.items()]


def stiff(k_n):
    return contacts(k_n=k_n, k_s=0.8 * k_n)


def column(radius, height):
    """Other sizes of the heap's cylinder; lifted until the column is free."""
    return [f"bed.x=[{-radius},{radius}]", f"bed.y=[{-radius},{radius}]", f"bed.height={height}",
            f"stage.lift.duration={1.04 * height / 0.1}", f"bed.beside={max(0.45, 3 * radius)}"]


QUICK = ["stage.lift.lift=0.1", "stage.lift.duration=3"]  # of all rows except "deck"
HEAPS = {
    "deck": [],
    "lift 0.1": [],
    "corners 8": ["bed.polyhedron.vertices=8"],
    "corners 16": ["bed.polyhedron.vertices=16"],
    "corners 24": ["bed.polyhedron.vertices=24"],
    "rounding 0.01": ["bed.polyhedron.rounding=0.01"],
    "rounding 0.05": ["bed.polyhedron.rounding=0.05"],
    "rounding 0.1": ["bed.polyhedron.rounding=0.1"],
    "ellipsoids": ["bed.polyhedron.angularity=0"],
    "proportions 0.9 0.85": ["bed.polyhedron.elongation=0.9", "bed.polyhedron.flatness=0.85"],
    "proportions 0.7 0.5": ["bed.polyhedron.elongation=0.7", "bed.polyhedron.flatness=0.5"],
    "friction 0.5": ["contact.0.friction=0.5"],
    "friction 1.0": ["contact.0.friction=1.0"],
    "rolling 0.1": ["contact.0.rolling_friction=0.1"],
    "k_n / 4": stiff(1e5),
    "k_n x 4": stiff(16e5),
    "zeta 0.1": contacts(zeta_n=0.1, zeta_s=0.1),
    "zeta 0.7": contacts(zeta_n=0.7, zeta_s=0.7),
    "local damping 0.3": ["stage.lift.local_damping=0.3", "stage.heap.local_damping=0.3"],
    "lift 0.4": ["stage.lift.lift=0.4", "stage.lift.duration=0.8"],
    "lift 0.03": ["stage.lift.lift=0.03", "stage.lift.duration=10"],
    "small": column(0.1, 0.24),
    "large": column(0.18, 0.42),
}

# A specimen six stones wide, packed as in the deck and compacted at 60 kPa. One bed for a row of
# pressures: the strain rate makes the inertial number rate d sqrt(rho / sigma_3) 1e-3.
SPECIMEN = ["bed.x=[0,0.24]", "bed.y=[0,0.24]", "bed.height=0.48", "bed.sieve=[31.5,40,50]",
            "bed.passing=[0,50,100]", "bed.polyhedron.vertices=12", "bed.polyhedron.rounding=0.02"]
STRAIN, SIZE, DENSITY, HEIGHT = 0.06, 0.04, 2650.0, 0.48
PRESSURES = (10e3, 30e3, 60e3)   # Pa
PACKED = 60e3                    # Pa
SQUEEZED = "stage_compact.h5"    # the checkpoint that tests of one bed start from


def test(pressure, inertial=1e-3, changes=()):
    """Changes of the deck for one pressure."""
    rate = inertial / (SIZE * (DENSITY / pressure)**0.5)
    return [*SPECIMEN, f"stage.squeeze.pressure={pressure}",
            f"stage.squeeze.confinement={pressure}", f"stage.triaxial.confinement={pressure}",
            f"stage.triaxial.duration={STRAIN / rate}",
            f"stage.triaxial.displacement={STRAIN * HEIGHT}", *changes]


# Row: the row whose bed at PACKED its tests start from (itself; None: each test packs its own),
# inertial number, changes.
TRIAXIAL = {
    "base": ("base", 1e-3, ()),
    # At 10 kPa the same stiffness relative to the pressure as base at 60 kPa; and the reverse.
    "k_n / 6": ("base", 1e-3, tuple(stiff(5e6 / 6))),
    "k_n x 6": ("base", 1e-3, tuple(stiff(30e6))),
    "compacted at 10 kPa": (None, 1e-3, ("stage.compact.pressure=10e3",)),
    "fast": ("base", 5e-3, ()),
    "slow": ("base", 3e-4, ()),
    "no gravity": ("base", 1e-3, ("dem.gravity=0",)),
    "wall friction 0": ("base", 1e-3, ("contact.1.friction=0",)),
    "wall friction 0.3": ("base", 1e-3, ("contact.1.friction=0.3",)),
    "friction 1.0": ("base", 1e-3, ("contact.0.friction=1.0",)),
    "damping 0": ("base", 1e-3, ("stage.triaxial.local_damping=0",)),
    "rounding 0.05": ("rounding 0.05", 1e-3, ("bed.polyhedron.rounding=0.05",)),
    "corners 24": ("corners 24", 1e-3, ("bed.polyhedron.vertices=24",)),
}


def summary(folder):
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def as_file(row):
    """Name of the row in names of folders."""
    return row.replace(" ", "_").replace("/", "over")


def run(program, deck, folder, changes):
    """Runs the deck in `folder` unless a finished run is there."""
    if (folder / "summary.json").exists() and summary(folder)["finished"]:
        return
    ran = launch.run([program, "run", str(ROOT / "inputs/bed" / deck), *changes, "-o", str(folder),
                      "--force"], "the same command continues", stdout=subprocess.PIPE,
                     stderr=subprocess.PIPE, text=True)
    if ran.returncode:
        launch.fail(ran, folder.name)


def line(name, columns):
    """Mean and standard deviation over the seeds of each column."""
    rows = np.array(columns, dtype=float)
    spread = rows.std(axis=0, ddof=1) if len(rows) > 1 else np.full(rows.shape[1], np.nan)
    text = "  ".join(f"{mean:8.1f} +-{off:5.1f}" for mean, off in zip(rows.mean(axis=0), spread))
    print(f"{name:26} {len(rows):2} {text}", flush=True)


def heap_figures(folder):
    """Angle, degrees, height, mm, stones, and core overlaps per thousand steps."""
    saved, results = read.checkpoint(folder), read.results(folder)
    size = np.median(next(reversed(results.stones.values())).sieved[:, 0])
    angle, _, flank = heap.flank(heap.placed(saved), size)
    top = flank[-1, 1] / heap.LEVELS[1]
    counts = summary(folder)["dem"]
    return angle, 1e3 * top, counts["particles"], 1e3 * counts["core_overlaps"] / counts["steps"]


def heaps(given):
    print("row, seeds, angle (deg), height (mm), stones, core overlaps per 1000 steps")
    for name in given.rows or HEAPS:
        found = []
        for seed in given.seeds:
            folder = given.folder / f"{as_file(name)}_{seed}"
            quick = [] if name == "deck" else QUICK
            run(given.program, "repose.toml", folder,
                [f"bed.seed={seed}", *quick, *HEAPS[name]])
            found.append(heap_figures(folder))
        line(name, found)


def triaxial_figures(folder):
    """Friction angle at the peak and in the last tenth, strain at the peak (%), dilation angle
    about it, degrees, and density before the test, kg/m3."""
    results = read.results(folder)
    got = laboratory.triaxial(results)
    most, last, peak = laboratory.strength(got)
    axial = got["axial"]
    near = np.abs(axial - axial[peak]) < axial[-1] / 6
    density = next(stage["bulk_density_kg_m3"] for stage in summary(folder)["stages"]
                   if stage["name"] == "squeeze")
    return (most, last, 100 * axial[peak],
            laboratory.dilation_angle(axial[near], got["volumetric"][near]), density)


def place(given, row, pressure, seed):
    """Folder of a triaxial test."""
    return given.folder / f"{as_file(row)}_{pressure / 1e3:.0f}_{seed}"


def triaxial_test(given, row, pressure, seed):
    """Folder of the test, which is run if missing, after the test whose bed it starts from."""
    bed, inertial, changes = TRIAXIAL[row]
    here, start = place(given, row, pressure, seed), []
    if bed and (bed, PACKED) != (row, pressure):
        start = [f"start='{triaxial_test(given, bed, PACKED, seed) / SQUEEZED}'"]
    run(given.program, "triaxial.toml", here,
        [f"bed.seed={seed}", *start, *test(pressure, inertial, changes)])
    return here


def triaxial(given):
    print("row, seeds, peak (deg), last tenth (deg), strain at the peak (%), dilation (deg), kg/m3")
    for row in given.rows or TRIAXIAL:
        for pressure in given.pressures:
            line(f"{row}, {pressure / 1e3:.0f} kPa",
                 [triaxial_figures(triaxial_test(given, row, pressure, seed))
                  for seed in given.seeds])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program", type=launch.program)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("test", choices=("heap", "triaxial"))
    parser.add_argument("--rows", nargs="+")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--pressures", nargs="+", type=float, default=PRESSURES)
    given = parser.parse_args()
    known = HEAPS if given.test == "heap" else TRIAXIAL
    for row in given.rows or ():
        if row not in known:
            launch.refuse(f"--rows {row}: must be one of {', '.join(known)}")
    launch.make_folder(given.folder)
    (heaps if given.test == "heap" else triaxial)(given)


if __name__ == "__main__":
    main()
