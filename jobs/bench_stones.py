#!/usr/bin/env python3
"""Speed of the stones at rest under inputs/bench, on one rank and on two, and of clumps beside
LAMMPS.

    bench_stones.py TRACKBED FOLDER [RUNS]

TRACKBED: the program. FOLDER: where the settled beds are prepared (kept for the next call) and the
results go. `contacts` counts those of pieces, `touched` the stones (and the floor) that a stone
touches. All cases take turns, RUNS times (3), and of each the best run counts: other work on the
machine only slows down. Two ranks have twice the box along x, so as many stones each. The
processor time shows what a busy machine hides from the wall time. LAMMPS (Debian's) moves the same
clumps with fix rigid/small and the same law between spheres; it is left out where there is no
`lmp`.
"""
import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np

import launch

DECKS = Path(__file__).resolve().parent.parent / "inputs" / "bench"
NAMES = ("stones12", "stones24", "compound", "clumps")
RANKS = (1, 2)
STEPS = 1000  # of LAMMPS

LAMMPS_INPUT = """units si
atom_style hybrid sphere molecular
boundary p p f
comm_modify vel yes cutoff {reach}
newton off
read_data clumps.data
pair_style gran/hooke/history {kn} {kt} {gn} {gt} {mu} 1
pair_coeff * *
neighbor {skin} bin
neigh_modify delay 0 every 1 exclude molecule/intra all
fix 1 all rigid/small molecule infile clumps.bodies
fix 2 all gravity 9.81 vector 0 0 -1
fix 3 all wall/gran hooke/history {kn} {kt} {gn} {gt} {mu} 1 zplane 0 NULL
timestep {dt}
thermo_style custom step
thermo 1000000
run 100
run {steps}
"""


def length_for(deck, ranks):
    low, high = tomllib.loads(deck.read_text())["bed"]["x"]
    return f"bed.x=[{low}, {low + ranks * (high - low)}]"


class Case:
    """One deck on a number of ranks."""

    def __init__(self, program, folder, name, ranks):
        self.name, self.ranks = name, ranks
        self.deck = DECKS / f"{name}.toml"
        self.folder = folder / f"{name}_{ranks}"
        self.start = self.folder / "stage_settle.h5"
        ranked = launch.on_ranks(ranks) if ranks > 1 else []
        self.command = [*ranked, program, "run", self.deck, length_for(self.deck, ranks)]
        self.runs = []

    def call(self, folder, *more):
        command = [*self.command, *more, "--force", "-o", folder]
        launch.run(command, stdout=subprocess.DEVNULL).check_returncode()

    def prepare(self):
        if not self.start.exists():
            self.call(self.folder)

    def run(self):
        out = self.folder / "run"
        self.call(out, f"start={self.start}")
        self.runs.append(json.loads((out / "summary.json").read_text())["dem"])

    def best(self, figure, largest=True):
        return (max if largest else min)(run[figure] for run in self.runs)

    def speed(self):
        return self.best("particle_steps_per_second_per_core")

    def speed_by_cpu(self):
        dem = self.runs[0]
        done = dem["particles"] * dem["measured_steps"]
        return done / self.ranks / self.best("measured_cpu_time_s", largest=False)


class Clumps:
    """The bed of a checkpoint as LAMMPS reads it: spheres, and the mass properties of bodies."""

    def __init__(self, state):
        with h5py.File(state) as file:
            self.deck = tomllib.loads(bytes(file.attrs["deck"]).decode())
            bed = file["particles"]
            self.x, self.q = bed["position"][:], bed["attitude"][:]
            self.scale, self.shape = bed["scale"][:], bed["shape"][:].ravel()
            solid = bed["template/solid"][:]
            self.count = bed["template/pieces"][:].ravel()
            self.radius = bed["template/radius"][:].ravel()
            self.corner = bed["template/corners"][:]  # one of each sphere
        self.scale = self.scale.ravel()
        density = self.deck["material"][0]["density"]
        self.mass = density * solid[self.shape, 0] * self.scale**3
        self.moments = (self.mass * self.scale**2)[:, None] * solid[self.shape, 1:4]
        self.box = (self.deck["bed"]["x"], self.deck["bed"]["y"])  # m, the periodic sides

    def turned(self, body, vectors):
        """From the body's principal axes to space."""
        return vectors @ self.axes(body).T

    def axes(self, body):
        x, y, z, w = self.q[body]
        return np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])

    def wrapped(self, points):
        """Points in the box, and across how many periods along x, y, z they came."""
        points, turns = points.copy(), np.zeros(points.shape, int)
        for axis, (low, high) in enumerate(self.box):
            turns[:, axis] = np.floor((points[:, axis] - low) / (high - low))
            points[:, axis] -= turns[:, axis] * (high - low)
        return points, turns

    def spheres(self):
        """Body, centre and radius of each sphere; a body's spheres follow each other."""
        first = np.concatenate(([0], np.cumsum(self.count)))
        bodies, centres, radii = [], [], []
        for body, (shape, scale) in enumerate(zip(self.shape, self.scale)):
            own = slice(first[shape], first[shape + 1])
            centres.append(self.x[body] + scale * self.turned(body, self.corner[own]))
            radii.append(scale * self.radius[own])
            bodies.append(np.full(self.count[shape], body))
        return np.concatenate(bodies), np.concatenate(centres), np.concatenate(radii)

    def write(self, folder):
        bodies, centres, radii = self.spheres()
        at, turns = self.wrapped(centres)
        head = ["clumps", "", f"{len(at)} atoms", "1 atom types", ""]
        head += [f"{low} {high} {a}lo {a}hi" for a, (low, high) in zip("xy", self.box)]
        head += [f"-0.1 {at[:, 2].max() + 0.2} zlo zhi", "", "Atoms", ""]
        # The density of a sphere only counts in the damping: the body's mass, spread evenly.
        mass = (self.mass / self.count[self.shape])[bodies]
        density = mass / (4 / 3 * np.pi * radii**3)
        rows = [f"{k + 1} 1 {p[0]} {p[1]} {p[2]} {2 * r} {d} {b + 1} {t[0]} {t[1]} {t[2]}"
                for k, (b, p, r, d, t) in enumerate(zip(bodies, at, radii, density, turns))]
        (folder / "clumps.data").write_text("\n".join(head + rows) + "\n")
        centre, turns = self.wrapped(self.x)
        lines = [str(len(self.x))]
        for b in range(len(self.x)):
            a = self.axes(b)
            i = a @ np.diag(self.moments[b]) @ a.T
            numbers = [self.mass[b], *centre[b], i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2],
                       i[1, 2], 0, 0, 0, 0, 0, 0, *turns[b]]
            lines.append(f"{b + 1} " + " ".join(f"{n:.15g}" for n in numbers))
        (folder / "clumps.bodies").write_text("\n".join(lines) + "\n")
        law = self.deck["contact"][0]
        pair = self.mass.mean() / 2  # kg, effective: the mean of a pair
        gamma = [2 * law[zeta] * np.sqrt(law[k] / pair)
                 for zeta, k in (("zeta_n", "k_n"), ("zeta_s", "k_s"))]
        safety = self.deck.get("dem", {}).get("safety", 0.2)
        (folder / "clumps.in").write_text(LAMMPS_INPUT.format(
            kn=law["k_n"], kt=law["k_s"], gn=gamma[0], gt=gamma[1], mu=law["friction"],
            skin=0.3 * radii.min(), reach=4 * radii.max(),
            dt=safety * np.sqrt(self.mass.min() / law["k_n"]), steps=STEPS))
        return len(self.x)


def run_lammps(folder, bodies):
    command = ["lmp", "-in", "clumps.in", "-log", "none"]
    ran = launch.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                     text=True)
    loops = re.findall(r"Loop time of (\S+) on \d+ procs for (\d+) steps", ran.stdout)
    if ran.returncode != 0 or len(loops) < 2:
        raise SystemExit("LAMMPS stopped:\n" + ran.stdout[-2000:])
    seconds, steps = loops[-1]
    return int(steps) * bodies / float(seconds)


def table(cases):
    alone = {case.name: case for case in cases if case.ranks == 1}
    print("deck      ranks  stones  contacts  touched  steps/s/core  by CPU time  of stones12"
          "  neighbours  B/stone  without contacts  of one rank")
    for case in cases:
        dem = case.runs[-1]
        print(f"{case.name:9} {case.ranks:5} {dem['particles']:7} "
              f"{dem['contacts_per_particle']:9.2f} {dem['neighbours_per_particle']:8.2f} "
              f"{case.speed():13.3e} "
              f"{case.speed_by_cpu():12.3e} {case.speed() / alone['stones12'].speed():12.2f} "
              f"{100 * case.best('neighbour_share', largest=False):9.1f} % "
              f"{dem['memory_per_particle_b']:8.0f} "
              f"{dem['memory_per_particle_without_contacts_b']:17.0f} "
              f"{case.speed() / alone[case.name].speed():12.2f}")


def main():
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    folder.mkdir(parents=True, exist_ok=True)
    cases = [Case(program, folder, name, ranks) for name in NAMES for ranks in RANKS]
    for case in cases:
        case.prepare()
    clumps = next(case for case in cases if case.name == "clumps" and case.ranks == 1)
    lammps = shutil.which("lmp") is not None
    bodies = Clumps(clumps.start).write(clumps.folder) if lammps else 0
    theirs = []
    for _ in range(runs):
        for case in cases:
            case.run()
        if lammps:
            theirs.append(run_lammps(clumps.folder, bodies))
    table(cases)
    if lammps:
        print(f"clumps in LAMMPS rigid/small: {max(theirs):.3e} clump-steps/s on one core, "
              f"trackbed over it {clumps.speed() / max(theirs):.2f}")


if __name__ == "__main__":
    main()
