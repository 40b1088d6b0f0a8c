#!/usr/bin/env python3
"""Compares designs of a transition zone: inputs/track/bridge.toml and its variants.

    bridge.py PROGRAM FOLDER [--ranks N]

Runs the deck and its variants, each from the last stage that it shares with the deck, and draws
FOLDER/bridge.png with the table bridge.md (docs/bridge.md). The signal of the accelerometer on a
sleeper is evaluated like one from a track, in FOLDER/monitor. Finished runs are kept.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys

import launch  # noqa: F401  # sets what Open MPI needs

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "postproc"))
import matplotlib  # noqa: E402

matplotlib.use("Agg")
import h5py  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from trackbed_post import ground_blocks, panels, read, shades, transition, write  # noqa: E402

DECK = ROOT / "inputs" / "track" / "bridge.toml"
BASE, SENSOR = "wedge", 5  # of the sleepers: above the wedge
END = 2  # last sleepers of the bed, which rise towards the springs behind it: not judged
BEHIND = 7.5  # m behind the last sleeper of the bed, where the last axle ends the evaluation
# Rest before and after the train, which the evaluation of the accelerometer needs.
LONG = ("train.start=-33", "track.length=33.6")
SEATED, BEDDED = "stage_release.h5", "stage_bed_in.h5"
# Name -> (checkpoint of the deck from which it starts, what is different).
VARIANTS = {
    BASE: (None, LONG),
    "no wedge": (BEDDED, ("ground.block.wedge.present=false",)),
    "under-sleeper pads": (BEDDED, ("contact.1.k_n=1.5e6", "contact.1.k_s=0.9e6")),
    "wide, heavy sleepers": (SEATED, ("sleepers.width=0.35", "material.1.density=3000")),
    # Bonds and stones that split exclude each other.
    "glued ballast": (BEDDED, ("bond.glue.present=true", "breakage.splitting.strength=0"))}


def run_all(program, folder, ranks):
    """The Passage of each variant, in turn."""
    for name, (start, words) in VARIANTS.items():
        place = folder / name.replace(", ", "_").replace(" ", "_")
        words = list(words)
        if start:
            words.append(f"start='{folder / BASE / start}'")
        print(f"{name}:", flush=True)
        command = ["mpirun", "-n", str(ranks), "--oversubscribe", program, "run", DECK, "-o", place,
                   "--or-resume", *words]
        code = subprocess.run(list(map(str, command)), check=False, stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL).returncode
        if code:
            sys.exit(code)
        yield Passage(name, place)


class Passage:
    """The train of a run: motion of the sleepers from its begin, m, forces of the wheels, N."""

    def __init__(self, name, place):
        self.name, self.place, run = name, place, read.results(place)
        self.stretches = ground_blocks.stretches(run)
        self.edge = ground_blocks.edge_of_structure(run)
        rows = np.arange(*run.passage().indices(len(run.time))[:2])
        with h5py.File(place / "results.h5") as file:
            wheel, force = (file[f"history/wheel/{quantity}"][rows[0]:rows[-1] + 1]
                            for quantity in ("x", "force"))
        self.x = run.sleepers_x
        self.record = (run.time[rows] - run.time[rows[0]],
                       *(run.sleeper[quantity].values[rows, SENSOR]
                         for quantity in ("displacement", "acceleration")))
        # All runs up to the same place of the train, since tracks differ in length.
        rows = rows[:np.argmax(wheel[:, -1] > self.x[-1] + BEHIND)]
        wheel, force = wheel[:len(rows)], force[:len(rows)]
        level = run.sleeper["displacement"].values[rows]
        self.motion = level - level[0]
        near = (wheel >= self.x[0]) & (wheel <= self.x[-1])
        self.forces = force[near]
        summary = json.loads((place / "summary.json").read_text(encoding="utf-8"))
        self.splits = summary.get("breakage", {}).get("splits", "-")

    def lowest(self):
        return -1e3 * self.motion.min(axis=0)

    def settled(self):
        return -1e3 * self.motion[-1]

    def judged(self):
        """Whether each sleeper is behind the bridge and not at the end of the bed."""
        return (self.x >= self.edge - ground_blocks.TINY) & (self.x < self.x[-END])

    def steepest(self):
        """(mm/m, "x to x") of the steepest change of the deflection between judged sleepers."""
        value, x = transition.steepest_within(self.lowest(), self.x, self.judged())
        half = (self.x[1] - self.x[0]) / 2
        return value, f"{x - half:.1f} to {x + half:.1f}"

    def numbers(self):
        """Name -> value; mm, kN, mm/m."""
        steepest, where = self.steepest()
        return {"largest deflection, mm": self.lowest().max(),
                "steepest change of it behind the bridge, mm/m": steepest,
                "at x, m": where,
                "settlement by the train, mean, mm": self.settled().mean(),
                "largest, mm": self.settled().max(),
                "largest difference of neighbours, mm": np.abs(np.diff(self.settled())).max(),
                "wheel force, least, kN": 1e-3 * self.forces.min(),
                "largest, kN": 1e-3 * self.forces.max(),
                "stones that split": self.splits}


def in_words(value):
    if isinstance(value, float):
        return f"{value:.2f}" if value < 50 else f"{value:.1f}"
    return str(value)


def table(passages):
    """Markdown."""
    columns = [one.numbers() for one in passages]
    lines = [f"| | {' | '.join(one.name for one in passages)} |",
             "|---" * (len(columns) + 1) + "|"]
    for name in columns[0]:
        lines.append(f"| {name} | " + " | ".join(in_words(one[name]) for one in columns) + " |")
    return "\n".join(lines) + "\n"


def draw(passages):
    figure, (down, left) = plt.subplots(2, 1, figsize=(8, 7), sharex=True, layout="constrained")
    for one in passages:
        down.plot(one.x, -one.lowest(), "o-", ms=4, label=one.name)
        left.plot(one.x, -one.settled(), "o-", ms=4, label=one.name)
    figure.suptitle("Sleepers under three wagons: bridge (grey), wedge (green), embankment")
    down.set(ylabel=f"largest deflection,\n{panels.UP}")
    left.set(ylabel=f"settlement by the train,\n{panels.UP}", xlabel="x, m")
    end = passages[0].x[-END] - (passages[0].x[1] - passages[0].x[0]) / 2
    for panel in (down, left):
        shades.shade(panel, passages[0].stretches)
        panel.axvline(end, color="0.2", lw=1, ls=":")
        panel.grid(alpha=0.3)
    down.text(end, 0.03, " end of the bed, not judged", fontsize=8,
              transform=down.get_xaxis_transform())
    panels.legend_above(down, columns=5)
    return figure


def monitor(passage, folder):
    """Evaluates the acceleration of the sensor's sleeper; returns (largest displacement found and
    true, settlement found and true), mm. The train's begin, when its rail is laid, is left out."""
    signals = folder / "signals"
    write.folder(signals)
    time, displacement, acceleration = passage.record
    laid = time > 0.1
    motion = 1e3 * displacement[laid]
    even = np.arange(0.1, time[-1], 1 / 5000)
    acceleration = np.interp(even, time, acceleration)
    with open(signals / "train.csv", "w", encoding="utf-8") as file:
        file.write("time_s,a_m_s2\n")
        file.writelines(f"{t - even[0]:.6f},{a:.9g}\n" for t, a in zip(even, acceleration))
    speed = read.results(passage.place).deck["train"]["speed"]
    (signals / "passages.csv").write_text(f"file,speed_m_s\ntrain.csv,{speed}\n", encoding="utf-8")
    subprocess.run([sys.executable, ROOT / "postproc", "monitor", signals, "-o",
                    folder / "monitor", "--noise", "1e-3"], check=True, stdout=subprocess.DEVNULL)
    with open(folder / "monitor" / "monitor.csv", encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    return (float(row["peak_mm"]), motion[0] - motion.min(), float(row["settlement_mm"]),
            motion[0] - motion[-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("folder", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--ranks", type=int, default=2)
    given = parser.parse_args()
    passages = list(run_all(given.program.resolve(), given.folder, given.ranks))
    folder = write.Folder(given.folder, write.origin_of([one.place for one in passages]))
    folder.picture("bridge", draw(passages))
    found = monitor(passages[0], given.folder)
    folder.table("bridge.md", table(passages) + "\nAccelerometer on sleeper {} of \"{}\": largest "
                 "displacement {:.2f} mm, true {:.2f} mm; settlement {:.2f} mm, true {:.2f} mm.\n"
                 .format(SENSOR, BASE, *found))
    for path in folder.pictures:
        print(path)
    print(folder.tables[0])


if __name__ == "__main__":
    main()
