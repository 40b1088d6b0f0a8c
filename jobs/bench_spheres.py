#!/usr/bin/env python3
"""Speed of inputs/bench/spheres.toml beside LAMMPS on the same spheres, in one run, alternating.

    bench_spheres.py TRACKBED FOLDER [RUNS]

TRACKBED: the program. FOLDER: where the settled bed is prepared (kept for the next call) and the
results go. Needs Debian's lammps. Prints particle-steps per second and core of each run and the
medians. Both integrate the same spheres at rest (positions and radii from our checkpoint, the same
linear law with history) on one core; LAMMPS needs some steps to build its contact histories, which
are not counted.
"""
import json
import re
import statistics
import subprocess
import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np

import launch

DECK = Path(__file__).resolve().parent.parent / "inputs" / "bench" / "spheres.toml"
STEPS = 3000

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


def prepare(program, folder):
    state = folder / "stage_settle.h5"
    if not state.exists():
        launch.run([program, "run", DECK, "-o", folder, "--force"],  # what a stop has left
                   stdout=subprocess.DEVNULL).check_returncode()
    return state


def write_lammps(state, folder, copies=1):
    """The spheres of our checkpoint, copied side by side, and the law of the deck stored in it.
    Returns how many they are."""
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


def run_ours(program, folder, state):
    out = folder / "run"
    command = [program, "run", DECK, f"start={state}", "--force", "-o", out]
    launch.run(command, stdout=subprocess.DEVNULL).check_returncode()
    found = json.loads((out / "summary.json").read_text())
    dem = found["dem"]
    # Of the whole stage, as LAMMPS counts its whole loop; one core.
    speed = dem["particles"] * dem["measured_steps"] / found["stages"][-1]["wall_time_s"]
    return dem, speed


def run_lammps(folder):
    command = ["lmp", "-in", "spheres.in", "-log", "none"]
    ran = launch.run(command, cwd=folder, stdout=subprocess.PIPE, text=True)
    ran.check_returncode()
    loops = re.findall(r"Loop time of (\S+) on \d+ procs for (\d+) steps with (\d+) atoms",
                       ran.stdout)
    seconds, steps, atoms = loops[-1]
    return int(steps) * int(atoms) / float(seconds)


def main():
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    folder.mkdir(parents=True, exist_ok=True)
    state = prepare(program, folder)
    write_lammps(state, folder)
    ours, theirs = [], []
    for _ in range(runs):
        dem, speed = run_ours(program, folder, state)
        ours.append(speed)
        theirs.append(run_lammps(folder))
        ratio = ours[-1] / theirs[-1]
        print(f"trackbed {ours[-1]:.3e}  LAMMPS {theirs[-1]:.3e}  ratio {ratio:.2f}", flush=True)
    print(f"{dem['particles']} spheres, {dem['contacts_per_particle']:.2f} contacts each")
    ratio = statistics.median(a / b for a, b in zip(ours, theirs))
    print(f"medians: trackbed {statistics.median(ours):.3e}, "
          f"LAMMPS {statistics.median(theirs):.3e}, ratio {ratio:.2f}")


if __name__ == "__main__":
    main()
