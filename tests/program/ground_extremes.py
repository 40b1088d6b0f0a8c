#!/usr/bin/env python3
"""The extremes in field files of the ground include the values of these and earlier field files,
however rare the rows of the histories are; they are the same in a run that is stopped and resumed.

    ground_extremes.py PROGRAM DECK START FOLDER
"""
import pathlib
import shutil
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program  # noqa: E402
from results import datasets, read  # noqa: E402

RARE = ["output.fields=true", "output.ground_extremes=true", "output.history_interval=1",
        "stage.load.duration=0.03", "stage.load.cycles=1"]
STAGES = ("load", "passage")
ROUNDING = 1e-6  # of the stress


def array(cells, wanted):
    (name,) = (name for name in cells if name.endswith(f"/{wanted}"))
    return cells[name]


def pictures(folder, stage):
    """Least and largest principal stress and extremes of each ground field file in a stage."""
    found = []
    for path in read.fields(folder, stage, "ground").values():
        cells = datasets(path)
        principal = array(cells, "principal_stress")
        found.append((principal[:, 2], principal[:, 0],
                      array(cells, "extreme_least_principal_stress"),
                      array(cells, "extreme_largest_principal_stress")))
    return found


def check(folder, stage, count):
    shown = pictures(folder, stage)
    if len(shown) < count:
        raise SystemExit(f"{folder}: {len(shown)} field files of {stage}")
    lows, highs = [], []
    for low, high, least, largest in shown:
        lows.append(low), highs.append(high)
        slack = ROUNDING * np.abs(low).max()
        outside = max(np.max(least - np.min(lows, axis=0)), np.max(np.max(highs, axis=0) - largest))
        if not outside <= slack:
            raise SystemExit(f"{folder}, {stage}: {outside:.3g} Pa outside of the extremes")
    if count > 1 and not np.ptp(lows, axis=0).max() > 10 * slack:
        raise SystemExit(f"{folder}, {stage}: the ground does not move: the test is meaningless")


def without(folder, stage, windows):
    """Field files of windows that must not contain extremes."""
    shown = [path for window, path in read.fields(folder, stage, "ground").items()
             if windows(window)]
    for path in shown:
        if any("extreme" in name for name in datasets(path)):
            raise SystemExit(f"{path}: extremes without output.ground_extremes")
    if not shown:
        raise SystemExit(f"{folder}: no field files of {stage}")


def check_ends(program, words, often, folder):
    """No extremes in stages in which the ground is at rest; in a run that was resumed without them
    and then with them they count from the second resume, which is reported."""
    still = folder / "still"
    program.done(1, *words, "stage.passage.ground_moves=false", "-o", still)
    check(still, "load", 1), without(still, "passage", lambda window: True)
    gap = folder / "gap"
    program.done(1, *words, often, "output.stop_after=100", "-o", gap, code=3)
    program.done(1, "resume", gap, "output.ground_extremes=false", "output.stop_after=140", code=3)
    without(gap, "load", lambda window: window > 100)
    ran = program.done(1, "resume", gap, "output.ground_extremes=true", "output.stop_after=0")
    if ran.stdout.count("they were not recorded before") != 1:
        raise SystemExit(f"a gap in the extremes must be reported once: {ran.stdout}")
    shown = [datasets(path) for window, path in read.fields(gap, "load", "ground").items()
             if window > 140]
    least = np.min([array(cells, "principal_stress")[:, 2] for cells in shown], axis=0)
    if len(shown) < 2 or not np.array_equal(least, array(
            shown[-1], "extreme_least_principal_stress")):
        raise SystemExit(f"extremes of {len(shown)} files since the resume include earlier ones")


def check_series(folder):
    """The list of files and times is that of an uninterrupted run, and has all files."""
    straight, stopped = ([(time, file.name) for time, file in read.series(folder / name, "ground")]
                         for name in ("often", "stopped"))
    files = sorted(path.name for path in (folder / "often/fields").glob("*_ground.hdf"))
    if straight != stopped or sorted(name for _, name in straight) != files:
        raise SystemExit(f"series: {straight} and {stopped} of {files}")
    if not np.all(np.diff([time for time, _ in straight]) > 0):
        raise SystemExit(f"times of the series do not increase: {straight}")


def main(path, deck, start, folder):
    program, folder = Program(path), pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    words = ["run", deck, f"start={start}", *RARE]
    program.done(1, *words, "-o", folder / "end")
    often = "output.fields_interval=0.005"
    program.done(1, *words, often, "-o", folder / "often")
    program.done(1, *words, often, "output.stop_after=150", "-o", folder / "stopped", code=3)
    program.done(2, "resume", folder / "stopped", "output.stop_after=0")
    for stage in STAGES:
        check(folder / "end", stage, 1), check(folder / "often", stage, 4)
        straight, stopped = (pictures(folder / name, stage) for name in ("often", "stopped"))
        if not np.array_equal(np.sort(straight[-1], axis=None), np.sort(stopped[-1], axis=None)):
            raise SystemExit(f"{stage}: extremes differ after a stop")
    check_series(folder)
    check_ends(program, words, often, folder)
    print("ok")


if __name__ == "__main__":
    main(*sys.argv[1:])
