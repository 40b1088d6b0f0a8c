#!/usr/bin/env python3
"""The decks of laboratory tests with few round stones: forces on walls are in balance, the platen
keeps its pressure, heaps remain on their floor; results are bitwise identical on any number of
ranks and after a stop within the stage that moves walls.

    laboratory.py PROGRAM FOLDER_OF_DECKS FOLDER
"""
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/support"), str(ROOT / "tests/restart")]
from program import Program, summary  # noqa: E402
from restart import compare  # noqa: E402
from results import checkpoint, histories  # noqa: E402

ROUND = ["bed.stone=disk", "bed.sieve=[40, 53]", "bed.passing=[0, 100]", "dem.largest_overlap=0.5",
         "contact.0.k_n=1e6", "contact.0.k_s=8e5", "contact.1.k_n=1e6", "contact.1.k_s=8e5"]
SHEAR = [*ROUND, "bed.height=0.14", "bed.split=0.07", "stage.fill.duration=0.25",
         "stage.compact.duration=0.15", "stage.hold.duration=0.05", "stage.shear.duration=0.08",
         "stage.shear.displacement=0.006"]
HEAP = [*ROUND, "bed.x=[-0.15, 0.15]", "bed.y=[-0.15, 0.15]", "bed.height=0.15",
        "stage.fill.duration=0.3", "stage.fill.growth=0", "stage.lift.duration=0.3",
        "stage.lift.lift=0.8", "stage.heap.duration=0.05"]
TRIAXIAL = [*ROUND, "bed.height=0.3", "stage.fill.duration=0.25", "stage.fill.growth=0.15",
            "stage.compact.duration=0.15", "stage.squeeze.duration=0.15",
            "stage.triaxial.duration=0.15", "stage.triaxial.displacement=0.006"]
CLOSED = 1e-10  # relative, required of the coupling
AREA = 0.09     # m^2


def same_on_any_ranks(program, deck, overrides, packed, folder):
    """From the packed bed on: 1 rank against 2, stopped while walls move and resumed on 3."""
    run = ["run", deck, *overrides, f"start={packed}", "--force", "-o"]
    program.done(1, *run, folder / "alone")
    stage = summary(folder / "alone")["stages"][-2 if "repose" in deck.stem else -1]
    windows = round(stage["duration_s"] / stage["window_s"]) // 2
    program.done(2, *run, folder / "stopped", f"output.stop_after={windows}", code=3)
    program.done(3, "resume", folder / "stopped")
    compare(folder / "alone", folder / "stopped", f"{deck.stem} stopped after {windows} windows")


def closed(folder):
    for name, value in summary(folder)["coupling"].items():
        if not 0 <= value <= CLOSED:
            sys.exit(f"{folder.name}: imbalance of {name} is {value}")


def on_walls(found, quantity):
    """A history of every wall by the name of the wall: [row, x y z]."""
    return {name.split("/")[1]: rows.reshape(-1, 3) for name, rows in found.items()
            if name.startswith("wall/") and name.endswith(f"/{quantity}")}


def check_shear(folder):
    found = histories(folder, 3)
    force = on_walls(found, "force")
    travel = found["wall/floor/displacement"].reshape(-1, 3)[:, 0]
    plate = found["platen/force"].reshape(-1, 3)
    pressure = found["platen/pressure"].ravel()
    upper = sum(f for name, f in force.items() if name.endswith(".upper")) + plate
    lower = sum(f for name, f in force.items() if name.endswith(".lower")) + force["floor"]
    moving = travel > 0.3 * travel[-1]
    wrong = []
    if abs(travel[-1] / 0.006 - 1) > 0.01:  # the stage ends with a whole window
        wrong.append(f"the lower half has moved {travel[-1]} m")
    # Mean forces on both halves are equal, as inertia of the stones is small.
    drag, hold = lower[moving, 0].mean(), upper[moving, 0].mean()
    if not abs(drag + hold) < 0.05 * abs(hold):
        wrong.append(f"force on the upper half {hold} N, on the lower half {drag} N")
    ratio = hold / -lower[moving, 2].mean()
    if not 0.2 < ratio < 1.5:  # steel balls to rock: tangents of 11 to 56 degrees
        wrong.append(f"shear over normal force is {ratio}")
    if not 0.7 < pressure[moving].mean() / 51e3 < 1.3:
        wrong.append(f"mean pressure of the platen {pressure[moving].mean()} Pa")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"shear over normal force {ratio:.2f}, platen {pressure[moving].mean():.0f} Pa")


def check_triaxial(folder):
    """Walls keep their pressure while the platen moves down, opposite ones symmetrically, and the
    strength of the bed is in its range."""
    found = histories(folder, 3)
    force, travel = on_walls(found, "force"), on_walls(found, "displacement")
    height = found["platen/z"].ravel()
    plate = found["platen/force"].reshape(-1, 3)[:, 2]
    sides = [0.3 - 2 * travel["wall.left"][:, 0], 0.3 - 2 * travel["wall.front"][:, 1]]
    moving = height < height[0] - 0.002
    wrong = []
    if not np.array_equal(travel["wall.left"][:, 0], -travel["wall.right"][:, 0]):
        wrong.append("displacements of opposite walls differ")
    if abs(height[0] - height[-1] - 0.006) > 1e-4:
        wrong.append(f"the platen has moved {height[0] - height[-1]} m")
    for axis, (low, high) in enumerate((("wall.left", "wall.right"), ("wall.front", "wall.back"))):
        push = (force[high][:, axis] - force[low][:, axis]) / 2
        pressure = (push / (sides[1 - axis] * height))[moving].mean()
        if not 0.9 < pressure / 60e3 < 1.1:  # some 80 balls in motion
            wrong.append(f"walls across {'xy'[axis]} have a mean pressure of {pressure} Pa")
    ratio = (plate / (sides[0] * sides[1]))[moving].mean() / 60e3
    if not 1.5 < ratio < 10:  # friction angles of 12 to 55 degrees
        wrong.append(f"the ratio of stresses of platen and walls is {ratio}")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"triaxial: ratio of stresses {ratio:.2f}")


def centres_of_heap(folder):
    return checkpoint(folder, "heap")["particles/position"].reshape(-1, 3)


def check_heap(folder, program, deck):
    centres = centres_of_heap(folder)
    count = [stage["particles"] for stage in summary(folder)["stages"]]
    wrong = []
    if len(set(count)) != 1 or centres[:, 2].min() < 0:
        wrong.append(f"stones were lost: {count}, the lowest at {centres[:, 2].min()} m")
    if np.hypot(*centres[:, :2].T).max() < 0.2:
        wrong.append("the cylinder still touches the heap")
    # From a small floor the same stones fall off, are counted and removed, and the run continues.
    small = folder.with_name("small_floor")
    program.done(1, "run", deck, *HEAP, "bed.beside=0.05", "--force", "-o", small)
    left = summary(small)["dem"]["particles"]
    furthest = np.abs(centres_of_heap(small)[:, :2]).max()
    if not 0 < left < count[-1] or furthest > 0.21:
        wrong.append(f"of {count[-1]} stones {left} are left on a small floor, to {furthest} m")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"heap of {count[-1]} stones, {left} on a small floor")


def main():
    program, decks, folder = Program(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3])
    references = []
    for name, overrides, packed in (("direct_shear", SHEAR, "hold"), ("repose", HEAP, "fill"),
                                    ("triaxial", TRIAXIAL, "squeeze")):
        deck, reference = decks / f"{name}.toml", folder / name
        program.done(1, "run", deck, *overrides, "--force", "-o", reference)
        closed(reference)
        same_on_any_ranks(program, deck, overrides, reference / f"stage_{packed}.h5",
                          folder / f"{name}_again")
        references.append(reference)
    check_shear(references[0])
    check_heap(references[1], program, decks / "repose.toml")
    check_triaxial(references[2])
    pressed = folder / "uniaxial"
    program.done(1, "run", decks / "uniaxial.toml", *SHEAR[:9], "stage.fill.duration=0.25",
                 "--force", "-o", pressed)
    drawn = subprocess.run([sys.executable, ROOT / "postproc", "figures", *references, pressed,
                            "--kind", "laboratory", "-o", folder / "figures"],
                           capture_output=True, text=True, check=False)
    print(drawn.stdout, drawn.stderr)
    for picture in ("shear", "heap", "triaxial", "compression"):
        if not (folder / f"figures/{picture}.png").is_file():
            sys.exit(f"no {picture}.png")


main()
