#!/usr/bin/env python3
"""A smaller and shorter benchmark deck gives the intended bed: stones at rest in their box that
support each other.

    bench_decks.py PROGRAM DECK FOLDER
"""
import pathlib
import subprocess
import sys
import tomllib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import summary  # noqa: E402
from results import checkpoint  # noqa: E402

SIDE = (-0.2, 0.2)  # m
SHORT = [f"bed.x={list(SIDE)}", f"bed.y={list(SIDE)}", "bed.height=0.08", "bed.shapes=6",
         "stage.fill.duration=0.3", "stage.settle.duration=0.1", "stage.rest.duration=0.005",
         "--force"]


def expect(holds, what):
    if not holds:
        raise SystemExit(what)


def main():
    program, deck, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    subprocess.run([program, "run", deck, *SHORT, "-o", folder], check=True)
    bed = tomllib.loads(deck.read_text(encoding="utf-8"))["bed"]
    dem, stones = summary(folder)["dem"], checkpoint(folder, "rest")
    place, velocity = stones["particles/position"], stones["particles/velocity"]
    expect(len(place) == dem["particles"] > 100, f"{len(place)} stones")
    # Stones leave periodic sides until lists are rebuilt, by less than their size.
    size = bed["sieve"][-1] * 1e-3
    for axis, (low, high) in enumerate([SIDE, SIDE, (size, np.inf)]):
        inside = (place[:, axis] > low - size) & (place[:, axis] < high + size)
        expect(inside.all(), f"{np.sum(~inside)} stones beyond side {axis}")
    speed = np.median(np.linalg.norm(velocity, axis=1))
    expect(speed < 0.05, f"stones move with {speed:g} m/s")
    # A frictional bed is stable with a coordination number of four (isostatic; walls count), less
    # some rattlers; twelve is the largest number for balls of one size.
    partners = dem["neighbours_per_particle"]
    expect(3 < partners < 12, f"{partners:g} contacts per stone")
    expect(dem["measured_stage"] == "rest" and dem["measured_steps"] > 0, "nothing was measured")


main()
