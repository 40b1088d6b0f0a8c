#!/usr/bin/env python3
"""Crushes many single stones of several sizes between plates and compares their strengths with
Weibull's law and its size effect.

    crushing.py PROGRAM FOLDER [--sizes 0.02,0.03,0.04,0.05,0.06] [--stones 40] [CHANGE...]

The deck is inputs/verify/splitting.toml, with changes such as breakage.splitting.weibull=2; a run
in FOLDER/SIZE for each size (m). Finished runs are not repeated. Writes strengths.csv and
crushing.png to FOLDER and prints a line per size: stones, mean and 37 % strength F/h^2 (MPa), with
the force F and the distance h of the plates when a stone splits for the first time, and Weibull
modulus of the shear stress. One run takes half a minute of a core for 40 stones.
"""
import argparse
import csv
import json
import pathlib
import random
import subprocess
import sys
import tomllib

import numpy as np

import launch

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "postproc"))
from trackbed_post import read  # noqa: E402

DECK = ROOT / "inputs/verify/splitting.toml"
GAP, END = 2.0, 0.55  # distance of the plates at first and at the end, over the size
LEAST = 0.15  # size of the smallest parts, over that of the stone: they must fit between the plates
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")  # for colour blindness


def speed_of_plate():
    with open(DECK, "rb") as file:
        plates = {plate["name"]: plate for plate in tomllib.load(file)["plate"]}
    return -plates["upper"]["velocity"][2]


SPEED = speed_of_plate()


def changes(size, count):
    """A square of stones with random attitudes on the lower plate."""
    draw = random.Random(round(1e6 * size))
    side, step = int(np.ceil(count**0.5)), 3 * size
    stones = []
    for k in range(count):
        x, y = (step * (k % side - (side - 1) / 2), step * (k // side - (side - 1) / 2))
        axis = [draw.gauss(0, 1) for _ in range(3)]
        stones.append(f'{{name="s{k}",shape="polyhedron",seed={draw.randrange(10**6)},'
                      f"size={size},position=[{x:.4f},{y:.4f},{0.9 * size:.4f}],"
                      f"axis=[{axis[0]:.4f},{axis[1]:.4f},{axis[2]:.4f}],"
                      f"angle={draw.uniform(0, 360):.2f}}}")
    wide = step * (side + 3)
    return [f"stone=[{','.join(stones)}]", f"plate.lower.size=[{wide},{wide}]",
            f"plate.upper.size=[{wide},{wide}]", f"plate.upper.centre=[0,0,{GAP * size}]",
            f"stage.crush.duration={(GAP - END) * size / SPEED:.4f}",
            f"breakage.seed={round(1e6 * size)}", f"breakage.least_size={LEAST * size:g}"]


def finished(folder):
    try:
        return json.loads((folder / "summary.json").read_text(encoding="utf-8"))["finished"]
    except (OSError, ValueError, KeyError):
        return False


def run(program, folder, words):
    if finished(folder):
        return
    ran = launch.run([program, "run", str(DECK), *words, "-o", str(folder), "--force"],
                     "the same command continues", stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                     text=True)
    if ran.returncode:
        launch.fail(ran, folder.name)


def strengths(folder, size, count):
    """Of each whole stone that split: F/h^2 and shear stress then, Pa."""
    rows = next(reversed(read.results(folder).breaks.values()))
    column, found = read.BREAK, {}
    for row in rows[np.argsort(rows[:, column["time"]], kind="stable")]:
        stone, height = row[column["stone"]], GAP * size - SPEED * row[column["time"]]
        if row[column["kind"]] == read.SPLIT and stone < count and stone not in found:
            found[stone] = (row[column["force"]] / height**2, row[column["stress"]])
    return np.array(list(found.values()))


def survival(stress):
    """Sorted stresses, and the fraction of stones that survive each (mean rank)."""
    ordered = np.sort(stress)
    return ordered, 1 - np.arange(1, len(ordered) + 1) / (len(ordered) + 1)


def fit(stress):
    """Weibull modulus and the stress that 37 % survive: least squares of ln ln(1/P) over ln s."""
    ordered, survive = survival(stress)
    slope, offset = np.polyfit(np.log(ordered), np.log(-np.log(survive)), 1)
    return slope, np.exp(-offset / slope)


def draw(found, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    sizes, middle = np.array(list(found)), []
    for (size, values), colour in zip(found.items(), COLOURS * len(found)):
        modulus, scale = fit(values[:, 0])
        middle.append(scale)
        ordered, survive = survival(values[:, 0])
        left.plot(np.log(ordered / scale), np.log(-np.log(survive)), "o", ms=4, color=colour,
                  label=f"{1e3 * size:g} mm: m = {modulus:.2f}")
        right.plot(np.full(len(values), 1e3 * size), values[:, 0] / 1e6, ".", color=colour,
                   alpha=0.4)
    right.plot(1e3 * sizes, np.array(middle) / 1e6, "ko-", label="37 % strength")
    if len(sizes) > 1:
        slope, offset = np.polyfit(np.log(sizes), np.log(middle), 1)
        right.plot(1e3 * sizes, np.exp(offset) * sizes**slope / 1e6, "k--",
                   label=f"proportional to d^{slope:.2f}")
    left.set(xlabel="ln(stress F/h² / 37 % strength)", ylabel="ln ln(1/survival)")
    right.set(xlabel="size (mm)", ylabel="F/h² at the first split (MPa)", xscale="log",
              yscale="log")
    for panel in (left, right):
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    figure.savefig(path, dpi=110)


def sizes_of(word):
    return tuple(map(float, word.split(",")))


def summarise(found, column, name):
    """Exponent of the 37 % strength over the size, and strength and modulus of all stones scaled to
    the middle size by the exponent -1."""
    sizes = np.array(list(found))
    scales = [fit(values[:, column])[1] for values in found.values()]
    exponent = np.polyfit(np.log(sizes), np.log(scales), 1)[0]
    middle = float(np.median(sizes))
    scaled = np.concatenate([values[:, column] * size / middle for size, values in found.items()])
    modulus, scale = fit(scaled)
    print(f"{name}: proportional to size^{exponent:.2f}; {len(scaled)} stones scaled to "
          f"{1e3 * middle:g} mm: {scale / 1e6:.2f} MPa, m {modulus:.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program", type=launch.program)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--sizes", type=sizes_of, default=sizes_of("0.02,0.03,0.04,0.05,0.06"),
                        help="m, separated by commas")
    parser.add_argument("--stones", type=int, default=40)
    parser.add_argument("changes", nargs="*")
    given = parser.parse_intermixed_args()
    launch.make_folder(given.folder)
    found = {}
    for size in given.sizes:
        folder = given.folder / f"{size:g}"
        run(given.program, folder, [*changes(size, given.stones), *given.changes])
        found[size] = strengths(folder, size, given.stones)
        if len(found[size]) < 3:
            launch.refuse(f"{size:g} m: {len(found[size])} stones split, at least 3 are needed; "
                          f"give more stones or a lower breakage.splitting.strength")
        modulus, scale = fit(found[size][:, 0])
        shear_modulus, shear = fit(found[size][:, 1])
        print(f"{1e3 * size:g} mm: {len(found[size])} stones, mean "
              f"{found[size][:, 0].mean() / 1e6:.2f}, 37 % {scale / 1e6:.2f} MPa, m {modulus:.2f}; "
              f"shear stress 37 % {shear / 1e6:.2f} MPa, m {shear_modulus:.2f}", flush=True)
    with open(given.folder / "strengths.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("size_m", "platen_stress_Pa", "shear_stress_Pa"))
        for size, values in found.items():
            table.writerows((f"{size:g}", f"{a:.6g}", f"{b:.6g}") for a, b in values)
    if len(found) > 1:
        summarise(found, 0, "F/h^2")
        summarise(found, 1, "shear stress")
    draw(found, given.folder / "crushing.png")
    print(f"figure: {given.folder / 'crushing.png'}")


if __name__ == "__main__":
    main()
