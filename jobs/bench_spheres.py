#!/usr/bin/env python3
"""Speed of inputs/bench/spheres.toml compared with LAMMPS on the same spheres, with the linear and
with the Hertzian contact law, on one rank and on two, alternating within one session.

    bench_spheres.py TRACKBED FOLDER [RUNS] [LAMMPS...]

TRACKBED: the program. FOLDER: where the settled beds are prepared (kept for the next call) and the
results are written. LAMMPS: programs to compare with; default is Debian's `lmp`, another may be one
built for this machine. Prints the particle-steps per second and core of each of RUNS (3)
repetitions and the medians of the ratios. Both programs integrate the same spheres at rest
(positions and radii from the checkpoint of trackbed, same law with tangential history); LAMMPS
needs some steps to build its contact histories, which are not counted.
"""
import json
import re
import shutil
import statistics
import subprocess
import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np

import launch

DECK = Path(__file__).resolve().parent.parent / "inputs" / "bench" / "spheres.toml"
STEPS = 3000  # time steps of LAMMPS
RANKS = (1, 2)
LAWS = ("linear", "hertz")
# For the Hertzian law; with this Young's modulus (Pa) over the deck's k_n (N/m) contacts at rest
# are somewhat softer than with the linear law, so that LAMMPS can use the same time step.
YOUNG_PER_STIFFNESS, POISSON, RESTITUTION = 300, 0.25, 0.5  # 1/m

LAMMPS_INPUT = """units si
atom_style sphere
boundary p p f
comm_modify vel yes
newton off
read_data spheres.data
pair_style gran/hooke/history {kn} {kt} {gn} {gt} {mu} 1
pair_coeff * *
fix 1 all nve/sphere
fix 2 all gravity 9.81 vector 0 0 -1
fix 3 all wall/gran hooke/history {kn} {kt} {gn} {gt} {mu} 1 zplane 0 NULL
neighbor {skin} bin
neigh_modify delay 0 every 1
timestep {dt}
thermo 1000000
run 200
run {steps}
"""


def law_words(deck, law):
    """Command-line arguments that select the contact law."""
    if law == "linear":
        return []
    stiffness = tomllib.loads(deck.read_text())["contact"][0]["k_n"]
    return ["contact.0.law=hertz", f"contact.0.restitution={RESTITUTION}",
            f"material.0.young={YOUNG_PER_STIFFNESS * stiffness}",
            f"material.0.poisson={POISSON}"]


def in_law(lammps_input, law):
    """The LAMMPS input for this law; `lammps_input` is written for the linear one."""
    def hertzian(found):
        k_n, g_n, g_t, friction = (float(found[part]) for part in (2, 4, 5, 6))
        young = YOUNG_PER_STIFFNESS * k_n
        shear = young / (2 * (1 + POISSON))
        normal = 4 / 3 * young / (2 * (1 - POISSON**2))
        tangential = 8 * shear / (2 * (2 - POISSON))
        # Same damping ratio where the stiffness equals that of the linear law.
        return (f"{found[1]}hertz/history {normal} {tangential} {g_n * normal / k_n} "
                f"{g_t * normal / k_n} {friction}")
    if law == "linear":
        return lammps_input
    number = r"(\S+)"
    return re.sub(rf"(gran(?:/| ))hooke/history {number} {number} {number} {number} {number}",
                  hertzian, lammps_input)


def run_deck(command, folder):
    launch.run([*map(str, command), "--force", "-o", folder],
               stdout=subprocess.DEVNULL).check_returncode()


def settled(program, folder, law):
    """Checkpoint of the bed at rest; under Hertz's law it settles again after pouring."""
    place = folder / f"settled_{law}"
    state = place / "stage_settle.h5"
    if not state.exists():
        words = ["stage.rest.duration=0.0005", *law_words(DECK, law)]
        if law != "linear":
            settled(program, folder, "linear")
            words.append(f"start={folder / 'settled_linear' / 'stage_fill.h5'}")
        run_deck([program, "run", DECK, *words], place)
    return state


def write_lammps(state, folder, copies=1):
    """Writes the spheres of the checkpoint, copied side by side, with the contact law of the deck
    stored in it. Returns the number of spheres."""
    with h5py.File(state) as file:
        deck = tomllib.loads(bytes(file.attrs["deck"]).decode())
        bed = file["particles"]
        x, radius = bed["position"][:], bed["scale"][:].ravel() * bed["template/radius"][0].item()
    law, density = deck["contact"][0], deck["material"][0]["density"]
    box = [list(deck["bed"][axis]) for axis in "xy"]  # m, the periodic sides
    for axis, (low, high) in enumerate(box):
        x[:, axis] = low + np.mod(x[:, axis] - low, high - low)
    length = box[0][1] - box[0][0]
    x = np.concatenate([x + [k * length, 0, 0] for k in range(copies)])
    radius, box[0][1] = np.tile(radius, copies), box[0][0] + copies * length
    lightest = density * 4 / 3 * np.pi * radius.min() ** 3
    pair_mass = density * 4 / 3 * np.pi * (radius**3).mean() / 2  # effective
    gamma = [2 * law[zeta] * np.sqrt(law[k] / pair_mass)
             for zeta, k in (("zeta_n", "k_n"), ("zeta_s", "k_s"))]
    head = ["spheres", "", f"{len(x)} atoms", "1 atom types", ""]
    head += [f"{low} {high} {a}lo {a}hi" for a, (low, high) in zip("xy", box)]
    head += [f"0 {x[:, 2].max() + 0.1} zlo zhi", "", "Atoms", ""]
    rows = [f"{i + 1} 1 {2 * r} {density} {p[0]} {p[1]} {p[2]}"
            for i, (p, r) in enumerate(zip(x, radius))]
    (folder / "spheres.data").write_text("\n".join(head + rows) + "\n")
    safety = deck.get("dem", {}).get("safety", 0.2)
    (folder / "spheres.in").write_text(
        LAMMPS_INPUT.format(
            kn=law["k_n"], kt=law["k_s"], gn=gamma[0], gt=gamma[1], mu=law["friction"],
            skin=0.15 * radius.min(), dt=safety * np.sqrt(lightest / law["k_n"]), steps=STEPS,
        )
    )
    return len(x)


class Ours:
    """The bed at rest in trackbed, on a number of ranks with a contact law."""

    def __init__(self, program, folder, law, ranks):
        self.law, self.ranks = law, ranks
        self.state, self.out = settled(program, folder, law), folder / f"{law}_{ranks}"
        ranked = launch.on_ranks(ranks) if ranks > 1 else []
        self.command = [*ranked, program, "run", DECK, f"start={self.state}", *law_words(DECK, law)]

    def run(self):
        """Particle-steps per second and core of the whole stage; LAMMPS counts its whole loop."""
        run_deck(self.command, self.out)
        found = json.loads((self.out / "summary.json").read_text())
        dem = found["dem"]
        done = dem["particles"] * dem["measured_steps"]
        return done / found["stages"][-1]["wall_time_s"] / self.ranks


class Lammps:
    """The same particles in LAMMPS on a number of ranks."""

    def __init__(self, program, given, ranks, particles, name="spheres", law="linear"):
        self.program, self.given, self.ranks, self.particles = program, given, ranks, particles
        self.name, self.law = name, law
        self.speeds, self.speeds_by_cpu = [], []

    def run(self):
        ranked = launch.on_ranks(self.ranks) if self.ranks > 1 else []
        ran = launch.run([*ranked, self.program, "-in", self.given.name, "-log", "none"],
                         cwd=self.given.parent, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                         text=True)
        loops = re.findall(r"Loop time of (\S+) on \d+ procs for (\d+) steps.*?(\S+)% CPU use",
                           ran.stdout, re.DOTALL)
        if ran.returncode != 0 or len(loops) < 2:
            raise SystemExit("LAMMPS stopped:\n" + ran.stdout[-2000:])
        seconds, steps, busy = map(float, loops[-1])
        self.speeds.append(steps * self.particles / seconds / self.ranks)
        self.speeds_by_cpu.append(self.speeds[-1] / (busy / 100))
        return self.speeds[-1]

    def speed(self):
        return max(self.speeds)

    def speed_by_cpu(self):
        return max(self.speeds_by_cpu)


def in_lammps(programs, ours, folder):
    """The same spheres, law and number of ranks in each of the LAMMPS programs."""
    particles = write_lammps(ours.state, folder)
    data = folder / f"spheres_{ours.law}.data"
    (folder / "spheres.data").replace(data)
    given = folder / f"spheres_{ours.law}.in"
    text = (folder / "spheres.in").read_text().replace("spheres.data", data.name)
    given.write_text(in_law(text, ours.law))
    return [Lammps(program, given, ours.ranks, particles) for program in programs]


def arguments(usage):
    """Absolute paths of program and folder."""
    if len(sys.argv) < 3:
        raise SystemExit(f"two arguments are needed: {usage}")
    program = Path(sys.argv[1]).resolve()
    if not program.is_file():
        raise SystemExit(f"{sys.argv[1]} is not an executable program: {usage}")
    return program, Path(sys.argv[2]).resolve()


def main():
    program, folder = arguments("bench_spheres.py TRACKBED FOLDER [RUNS] [LAMMPS...]")
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    programs = [str(Path(p).resolve()) if "/" in p else p for p in sys.argv[4:]] or ["lmp"]
    for lammps in programs:
        if not shutil.which(lammps):
            raise SystemExit(f"{lammps} was not found: install Debian's package lammps, or give "
                             "the path of another LAMMPS after RUNS")
    folder.mkdir(parents=True, exist_ok=True)
    cases = [Ours(program, folder, law, ranks) for law in LAWS for ranks in RANKS]
    theirs = [in_lammps(programs, ours, folder) for ours in cases]
    found = [[[] for _ in programs] for _ in cases]
    print("particle-steps per second and core")
    print("law     ranks   trackbed" + "".join(f"  {Path(p).name:>9}  ratio" for p in programs))
    for _ in range(runs):
        for ours, others, kept in zip(cases, theirs, found):
            speed, line = ours.run(), ""
            for other, ratios in zip(others, kept):
                ratios.append(speed / other.run())
                line += f"  {other.speeds[-1]:9.3e}  {ratios[-1]:5.2f}"
            print(f"{ours.law:6} {ours.ranks:6}  {speed:9.3e}{line}", flush=True)
    for ours, kept in zip(cases, found):
        medians = "  ".join(f"{statistics.median(ratios):.2f} ({name})"
                            for name, ratios in zip(programs, kept))
        print(f"median ratio, {ours.law} on {ours.ranks}: {medians}")


if __name__ == "__main__":
    main()
