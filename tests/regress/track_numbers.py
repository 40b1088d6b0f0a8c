#!/usr/bin/env python3
"""A track alone: the numbers of its summary are those of the run, not of what was written of it.

    track_numbers.py PROGRAM DECKS FOLDER
"""
import pathlib
import shutil
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from track import SHORT, same_bits  # noqa: E402


def check_extremes(program, decks, folder):
    """They are of every step, however few rows the histories have, also across a stop."""
    found = []
    for name, words in (("each", ["passage.history_interval=2e-4"]),
                        ("few", ["passage.history_interval=0.03"])):
        program.done(1, "run", decks / "plain.toml", *SHORT, *words, "-o", folder / name)
        found.append(summary(folder / name)["track"])
    with h5py.File(folder / "each/results.h5") as file:
        rail, force = file["history/rail/displacement"][()], file["history/wheel/force"][()]
        on = (file["history/wheel/x"][()] >= 0) & (file["history/wheel/x"][()] <= 60)
    if found[0]["rail_lowest_m"] != list(rail.min(axis=0)):
        raise SystemExit(f"lowest rail: {found[0]['rail_lowest_m']}, rows {rail.min(axis=0)}")
    if [found[0][f"wheel_force_{name}_n"] for name in ("min", "max")] != [force[on].min(),
                                                                        force[on].max()]:
        raise SystemExit(f"wheel forces: {found[0]}, rows {force[on].min()} {force[on].max()}")
    if found[0] != found[1]:
        raise SystemExit(f"extremes depend on the interval of the histories: {found}")
    stopped = folder / "few_stopped"
    program.done(2, "run", decks / "plain.toml", *SHORT, "passage.history_interval=0.03",
                 "passage.stop_after=149", "-o", stopped, code=3)
    program.done(1, "resume", stopped)
    same_bits(folder / "few", stopped, "extremes after a stop")


def main():
    program, decks, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2]), pathlib.Path(
        sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_extremes(program, decks, folder)


if __name__ == "__main__":
    main()
