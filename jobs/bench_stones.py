#!/usr/bin/env python3
"""Speed of the beds at rest of inputs/bench compared with LAMMPS, on one rank and on two, with the
linear and with the Hertzian contact law.

    bench_stones.py TRACKBED FOLDER [RUNS]

TRACKBED: the program. FOLDER: where settled cells are prepared (kept for the next call) and the
results are written. A cell is little larger than the smallest periodic bed of these stones, a sixth
of the deck's bed. It is poured and settled to rest under each law; the measured beds are copies of
it side by side (bed.cell), on two ranks twice as many as on one, so that each rank has the same
number of stones. The time of the preparation is printed. `bodies touched` counts the stones (and
the floor) that a stone touches, `neighbour lists` is the fraction of the DEM time that they take,
`rate relative to one rank` the speed per core divided by that on one rank. All cases alternate,
RUNS times (3), and the best run of each counts, because other work on the machine can only slow it
down. The processor time shows what a busy machine hides in the wall time. Both programs are timed
over the whole loop: trackbed by the wall time of the last stage, with coupling and history output,
LAMMPS by its loop time. LAMMPS (Debian's) moves the spheres of inputs/bench/spheres.toml
(bench_spheres.py), and the same clumps with fix rigid/small and the same law between spheres; it is
left out where there is no `lmp`.
"""
import json
import shutil
import sys
import time
import tomllib
from pathlib import Path

import h5py
import numpy as np

import bench_spheres
import launch
from bench_spheres import LAWS, RANKS, Lammps, in_law, law_words, run_deck

DECKS = Path(__file__).resolve().parent.parent / "inputs" / "bench"
STEPS = 1000  # time steps of LAMMPS
NAMES = ("stones12", "stones24", "compound", "clumps")
CELL_SIDE = {"spheres": 0.125, "stones": 0.32}  # m, along x and y
# s. A bed of copies moves as its cell would have: it need not settle again.
LAY = ["stage.fill.duration=0.0005", "stage.settle.duration=0.0005"]

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


def bed_of(name, copies):
    """Command-line arguments for this number of cells in a row."""
    side = CELL_SIDE["spheres" if name == "spheres" else "stones"]
    return [f"bed.x=[0.0, {copies * side:.6g}]", f"bed.y=[{-side / 2:.6g}, {side / 2:.6g}]"]


def copies_for(name, ranks):
    """Number of cells that gives about as many stones per rank as the deck has."""
    bed = tomllib.loads((DECKS / f"{name}.toml").read_text())["bed"]
    area = (bed["x"][1] - bed["x"][0]) * (bed["y"][1] - bed["y"][0])
    side = CELL_SIDE["spheres" if name == "spheres" else "stones"]
    return ranks * round(area / side**2)


def settled_cell(program, folder, name, law):
    """Checkpoint of the deck's cell at rest under this contact law."""
    place, deck = folder / f"cell_{name}_{law}", DECKS / f"{name}.toml"
    state = place / "stage_settle.h5"
    if not state.exists():
        words = ["stage.rest.duration=0.0005", *bed_of(name, 1)]
        if law != "linear":
            words += [*law_words(deck, law), "stage.fill.duration=0.0005",
                      "stage.settle.duration=0.01",
                      f"bed.cell={settled_cell(program, folder, name, 'linear')}"]
        run_deck([program, "run", deck, *words], place)
    return state


class Case:
    """One deck on a number of ranks with a contact law."""

    def __init__(self, program, folder, name, ranks=1, law="linear"):
        self.name, self.ranks, self.law = name, ranks, law
        deck = DECKS / f"{name}.toml"
        self.folder = folder / f"{name}_{law}_{ranks}"
        ranked = launch.on_ranks(ranks) if ranks > 1 else []
        self.cell = settled_cell(program, folder, name, law)
        self.command = [*ranked, program, "run", deck, *bed_of(name, copies_for(name, ranks)),
                        *law_words(deck, law), f"bed.cell={self.cell}", *LAY]
        self.runs = []

    def laid(self):
        """Checkpoint of the bed before the first measured step."""
        start = self.folder / "stage_settle.h5"
        if not start.exists():
            run_deck([*self.command, "stage.rest.duration=0.0005"], self.folder)
        return start

    def run(self):
        out = self.folder / "run"
        run_deck(self.command, out)
        found = json.loads((out / "summary.json").read_text())
        self.runs.append({**found["dem"], "loop_s": found["stages"][-1]["wall_time_s"]})

    def best(self, figure, largest=True):
        return (max if largest else min)(run[figure] for run in self.runs)

    def speed(self):
        """Particle-steps per second and core of the whole stage; LAMMPS counts its whole loop."""
        dem = self.runs[0]
        done = dem["particles"] * dem["measured_steps"]
        return done / self.ranks / self.best("loop_s", largest=False)

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
            self.corner = bed["template/corners"][:]  # one corner per sphere
        self.scale = self.scale.ravel()
        density = self.deck["material"][0]["density"]
        self.mass = density * solid[self.shape, 0] * self.scale**3
        self.moments = (self.mass * self.scale**2)[:, None] * solid[self.shape, 1:4]
        self.box = (self.deck["bed"]["x"], self.deck["bed"]["y"])  # m, the periodic sides

    def turned(self, body, vectors):
        """Vectors rotated from the body's principal axes to the global axes."""
        return vectors @ self.axes(body).T

    def axes(self, body):
        x, y, z, w = self.q[body]
        return np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])

    def wrapped(self, points):
        """Points wrapped into the box, and the number of periods crossed along x, y, z."""
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
        # The density of a sphere only affects the damping: the body's mass is spread evenly.
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


def in_lammps(case, write, name):
    """The particles of a case in Debian's LAMMPS, with the ranks and the law of the case."""
    particles = write(case)
    given = case.folder / f"{name}_{case.law}.in"
    given.write_text(in_law((case.folder / f"{name}.in").read_text(), case.law))
    return Lammps("lmp", given, case.ranks, particles, name=name, law=case.law)


def write_spheres(case):
    case.folder.mkdir(exist_ok=True)
    return bench_spheres.write_lammps(case.cell, case.folder, copies_for(case.name, case.ranks))


def write_clumps(case):
    return Clumps(case.laid()).write(case.folder)


def beside_lammps(program, folder, cases):
    found = [in_lammps(Case(program, folder, "spheres", ranks, law), write_spheres, "spheres")
             for law in LAWS for ranks in RANKS]
    return found + [in_lammps(case, write_clumps, "clumps") for case in cases
                    if case.name == "clumps"]


def table(cases):
    print("deck      law     ranks  stones  contacts   bodies  stone-steps   by CPU time"
          "  neighbour  B/stone  without contacts   rate relative\n"
          "                                of pieces  touched  /s/core       /s/core"
          "          lists                            to one rank\n"
          "                                  /stone   /stone"
          "                                     of DEM")
    for case in cases:
        dem = case.runs[-1]
        alone = next(c for c in cases if (c.name, c.law, c.ranks) == (case.name, case.law, 1))
        print(f"{case.name:9} {case.law:6} {case.ranks:6} {dem['particles']:7} "
              f"{dem['contacts_per_particle']:9.2f} {dem['neighbours_per_particle']:8.2f} "
              f"{case.speed():13.3e} {case.speed_by_cpu():12.3e} "
              f"{100 * case.best('neighbour_share', largest=False):9.1f} % "
              f"{dem['memory_per_particle_b']:8.0f} "
              f"{dem['memory_per_particle_without_contacts_b']:17.0f} "
              f"{case.speed() / alone.speed():14.2f}")


def ratios(cases, theirs):
    print("\nratio                            law     ranks         by CPU time")

    def line(words, first, second):
        print(f"{words:32} {first.law:6} {first.ranks:6} {first.speed() / second.speed():6.2f} "
              f"{first.speed_by_cpu() / second.speed_by_cpu():12.2f}")

    def find(some, like, name):
        return next((c for c in some if (c.name, c.law, c.ranks) == (name, like.law, like.ranks)),
                    None)
    for case in cases:
        spheres, clumps = (find(theirs, case, name) for name in ("spheres", "clumps"))
        if case.name == "stones12" and spheres:
            line("stones12 over LAMMPS spheres", case, spheres)
        if case.name in ("compound", "stones24"):
            line(f"{case.name} over stones12", case, find(cases, case, "stones12"))
        if case.name == "clumps" and clumps:
            line("clumps over LAMMPS rigid/small", case, clumps)
    for other in theirs:
        print(f"LAMMPS {other.name:7} {other.law:6} on {other.ranks}: {other.speed():.3e} "
              "steps/s/core")


def main():
    program, folder = bench_spheres.arguments("bench_stones.py TRACKBED FOLDER [RUNS]")
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    folder.mkdir(parents=True, exist_ok=True)
    begin = time.monotonic()
    cases = [Case(program, folder, name, ranks, law)
             for name in NAMES for law in LAWS for ranks in RANKS]
    theirs = beside_lammps(program, folder, cases) if shutil.which("lmp") else []
    if not theirs:
        print("no `lmp` on the PATH: only the rates of trackbed are measured")
    print(f"prepared in {time.monotonic() - begin:.0f} s")
    for _ in range(runs):
        for one in (*cases, *theirs):
            one.run()
    table(cases)
    ratios(cases, theirs)


if __name__ == "__main__":
    main()
