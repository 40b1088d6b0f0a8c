#!/usr/bin/env python3
"""Estimated and measured wall times of decks (docs/scaling.md).

    estimates.py PROGRAM DECK... [--ranks N] [--set DECK key=value]... [--keep FOLDER]

Each deck is checked and run. A stage that ends early is compared with the same part of its
estimate. Needs as many idle cores as ranks; --keep keeps the results, and takes those that are
there instead of running again.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import launch  # noqa: F401  # sets what Open MPI needs


def call(program, ranks, *words):
    command = ["mpirun", "-n", ranks, "--oversubscribe", program, *words]
    ran = subprocess.run(list(map(str, command)), check=False, capture_output=True, text=True,
                         stdin=subprocess.DEVNULL)
    if ran.returncode:
        sys.exit(ran.stderr or ran.stdout)
    return ran.stdout


def numbers_after(report, words):
    """Number of each stage in the lines `WORDS: NAME NUMBER, NAME NUMBER`."""
    found = {}
    for line in re.findall(rf"{words}: (.*)", report):
        for one in line.split(", "):
            name, _, number = one.rpartition(" ")
            found[name] = float(number)
    return found


def estimated(report):
    """s of wall time of a window of each stage."""
    windows = numbers_after(report, "largest number of windows")
    seconds = numbers_after(report, "largest wall time, s")
    return {name: seconds[name] / windows[name] for name in windows}


def summary_of(program, ranks, deck, words, folder):
    path = folder / "summary.json"
    if not path.is_file():
        call(program, ranks, "run", deck, *words, "-o", folder, "--force")
    return json.loads(path.read_text(encoding="utf-8"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("decks", nargs="+", type=pathlib.Path)
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--set", nargs=2, action="append", default=[],
                        metavar=("DECK", "key=value"))
    parser.add_argument("--keep", type=pathlib.Path)
    given = parser.parse_args()
    print("| deck | stones | estimated, s | measured, s | ratio | of its stages |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="trackbed-") as scratch:
        for deck in given.decks:
            words = [word for name, word in given.set if name == str(deck)]
            each = estimated(call(given.program, given.ranks, "check", deck, *words))
            folder = (given.keep or pathlib.Path(scratch)) / f"{deck.parent.name}_{deck.stem}"
            summary = summary_of(given.program, given.ranks, deck, words, folder)
            rows = [(each[stage["name"]] * stage["duration_s"] / stage["window_s"],
                     stage["wall_time_s"]) for stage in summary["stages"]]
            guess, took = map(sum, zip(*rows))
            ratios = [real / wanted for wanted, real in rows]
            print(f"| {deck} | {summary['dem']['particles']} | {guess:.0f} | {took:.0f} | "
                  f"{took / guess:.2f} | {min(ratios):.2f} to {max(ratios):.2f} |", flush=True)


if __name__ == "__main__":
    main()
