#!/usr/bin/env python3
"""The longest sub-step with which compacted stones stay at rest, in units of sqrt(m/k_n).

    steady_step.py PROGRAM FOLDER [--stones polyhedra clump disk] [--vertices 12]

For each kind of stone the bed of inputs/bed/steady.toml is compacted once; its last stage is then
run with other k_s over k_n, damping ratios, friction and `dem.safety`. The limit is found by
bisection between stable and unstable steps (unstable: the kinetic energy triples within 8 ms, or
the run stops with code 4). Prints a table and writes FOLDER/steady_step.csv.
"""
import argparse
import csv
import subprocess
from pathlib import Path

import h5py

import launch

DECK = Path(__file__).resolve().parent.parent / "inputs/bed/steady.toml"
K_N = 2e6                      # N/m, as in the deck
SHEAR = (0.3, 0.8, 1.0)        # k_s over k_n
DAMPING = (0, 0.2, 0.4, 0.7)   # zeta_n and zeta_s
FRICTION = (0.7, 2.0)          # of stones; at 2 nearly all contacts stick
LEAST, MOST, NEAR = 0.08, 1.0, 1.06   # bounds of dem.safety, ratio at which bisection ends
SETTLED = 4                    # rows of 1 ms, until the transient of the new springs has decayed
STOPPED = 4                    # exit code of a run that becomes unstable


def run(program, folder, changes):
    done = launch.run([program, "run", str(DECK), *changes, "-o", str(folder), "--force"],
                      stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, STOPPED):
        raise SystemExit(done.stderr)
    return done.returncode == 0


def is_stable(program, folder, changes):
    if not run(program, folder, changes):
        return False
    with h5py.File(folder / "results.h5") as file:
        stage = file["history/stage"][:]
        kinetic = file["history/energy/kinetic"][:][stage == stage[-1]]
    return kinetic[-1] < 3 * kinetic[SETTLED]


def longest(program, folder, changes):
    low, high = LEAST, MOST
    while high / low > NEAR:
        middle = (low * high) ** 0.5
        if is_stable(program, folder, [*changes, f"dem.safety={middle}"]):
            low = middle
        else:
            high = middle
    return low


def of_kind(program, folder, kind, shape):
    compacted = folder / kind
    if not run(program, compacted, shape):
        raise SystemExit(f"the bed of {kind} could not be compacted")
    for friction in FRICTION:
        for shear in SHEAR:
            for zeta in DAMPING:
                changes = [*shape, f"start='{compacted / 'stage_compact.h5'}'",
                           f"contact[0].k_s={shear * K_N}", f"contact[0].zeta_n={zeta}",
                           f"contact[0].zeta_s={zeta}", f"stage.held.friction={friction}"]
                yield kind, friction, shear, zeta, longest(program, folder / "held", changes)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--stones", nargs="+", default=["polyhedra", "clump", "disk"])
    parser.add_argument("--vertices", type=int, default=12)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    with open(given.folder / "steady_step.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["stones", "friction", "k_s over k_n", "zeta", "largest safety"])
        for kind in given.stones:
            # The overlap of balls is limited by their own radius, not by a rounding radius.
            limit = "5" if kind in ("polyhedra", "compound") else "1"
            shape = [f"bed.stone={kind}", f"dem.largest_overlap={limit}"]
            if kind != "disk":
                shape.append(f"bed.polyhedron.vertices={given.vertices}")
            for row in of_kind(given.program, given.folder, kind, shape):
                table.writerow(row)
                file.flush()
                print("{} friction {} k_s/k_n {} zeta {}: largest stable dem.safety {:.2f}".format(
                    *row), flush=True)


if __name__ == "__main__":
    main()
