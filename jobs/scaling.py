#!/usr/bin/env python3
"""Measured and predicted cost of a run on several ranks (docs/scaling.md).

    scaling.py PROGRAM DECK [--ranks N,N,...] [--windows W] [key=value...]

Runs some windows of the deck, a bed of copies of a cell, on one rank and on two (strong scaling),
on half of the bed's length, an even number of cells, on one rank (weak scaling), and prints tables
with what `trackbed check --ranks` predicts for more. Needs two idle cores.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import tomllib

import launch  # noqa: F401  # sets what Open MPI needs

RANKS = "1,2,4,8,16,32,64,128,256,512,1024"


def run(program, ranks, *words):
    """summary.json of a run."""
    with tempfile.TemporaryDirectory(prefix="trackbed-") as folder:
        command = ["mpirun", "-n", ranks, "--oversubscribe", program, "run", *words, "-o", folder,
                   "--force"]
        ran = subprocess.run(list(map(str, command)), check=False, capture_output=True, text=True,
                             stdin=subprocess.DEVNULL)
        if ran.returncode not in (0, 3):
            sys.exit(ran.stderr or ran.stdout)
        return json.loads((pathlib.Path(folder) / "summary.json").read_text(encoding="utf-8"))


def short_words(deck, windows, halves):
    """Overrides for some windows, and for `halves` halves of the bed with its ground and sleepers,
    of a deck without a train."""
    words = [f"output.stop_after={windows}", "output.history_interval=1",
             "output.checkpoint_wall_interval=0"]
    if halves == 1:
        middle = 0.5 * (deck["bed"]["x"][0] + deck["bed"]["x"][1])
        words.append(f"bed.x=[{deck['bed']['x'][0]},{middle}]")
        if deck.get("ground", {}).get("present", True):
            words += [f"ground.x=[{deck['ground']['x'][0]},{middle}]",
                      f"ground.elements_x={deck['ground']['elements_x'] // 2}"]
        if "sleepers" in deck:
            words.append(f"sleepers.count={deck['sleepers']['count'] // 2}")
    return words


def measured(program, deck_path, windows, given):
    """Rows of seconds of sub-steps: between runs of all windows and of a tenth of them, the least
    of three of each."""
    with open(deck_path, "rb") as file:
        deck = tomllib.load(file)
    for word in given:  # those that are halved
        key, _, value = word.partition("=")
        section, _, name = key.partition(".")
        if section in ("bed", "ground", "sleepers") and name in ("x", "count", "elements_x"):
            deck[section][name] = tomllib.loads(f"value = {value}")["value"]
    rows = []
    for name, ranks, halves in (("whole bed", 1, 2), ("whole bed", 2, 2), ("half of it", 1, 1)):
        least = []
        for count in (windows // 10, windows):
            words = [*given, *short_words(deck, count, halves)]
            found = [run(program, ranks, deck_path, *words) for _ in range(3)]
            least.append((min(one["wall_time_s"] for one in found), found[0]["dem"]))
        (begin, before), (end, dem) = least
        rows.append((name, ranks, dem["particles"], dem["steps"] - before["steps"], end - begin))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("deck", type=pathlib.Path)
    parser.add_argument("overrides", nargs="*")
    parser.add_argument("--ranks", default=RANKS)
    parser.add_argument("--windows", type=int, default=3000)
    given = parser.parse_args()
    rows = measured(given.program.resolve(), given.deck, given.windows, given.overrides)
    print("| | ranks | stones | sub-steps | s | ns per stone and sub-step of a core |\n"
          "|---|---|---|---|---|---|")
    for name, ranks, stones, steps, seconds in rows:
        print(f"| {name} | {ranks} | {stones} | {steps} | {seconds:.1f} | "
              f"{1e9 * seconds * ranks / stones / steps:.0f} |")
    (_, _, _, _, alone), (_, _, _, _, two), (_, _, _, _, half) = rows
    print(f"\n2 ranks: speed-up {alone / two:.2f}; with twice the bed they take {two / half:.2f} "
          "times as long as one rank with one\n")
    predicted = subprocess.run(["mpirun", "-n", "1", given.program, "check", given.deck, "--ranks",
                                given.ranks, *given.overrides], check=False, capture_output=True,
                               text=True, stdin=subprocess.DEVNULL)
    print(predicted.stdout)
    if predicted.returncode:
        print(predicted.stderr, file=sys.stderr)
    return predicted.returncode


if __name__ == "__main__":
    sys.exit(main())
