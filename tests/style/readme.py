#!/usr/bin/env python3
"""The numbers of README.md are those of the stored run of the quickstart.

    readme.py FOLDER

docs/images/quickstart.dat is transition.txt as jobs/quickstart.sh has drawn it, with the run with
wedge first.
"""
import pathlib
import re
import sys
import tomllib

# Sentence of README.md; for each of its numbers the row, and 0 with wedge, 1 without.
N = r"(\d+(?:\.\d+)?)"
REACHED = "distance behind the structure where 90% of the change is reached, m"
STEEPEST = "steepest change between two sleepers of the transition, mm/m"
BEHIND = "distance of the steepest change behind the structure, m"
SCATTER = "steepest change between two sleepers of plain track (scatter of the bed), mm/m"
STRUCTURE, PLAIN = (f"lowest level of the rail, {where}, mm down" for where in (
    "mean on the structure", "median on plain track"))
FORCE, ON_PLAIN = (f"largest wheel force {where}, kN" for where in (
    "in the transition", "on plain track"))
MEAN = "mean wheel force over the bed, kN"
SLEEPERS, SLEEPERS_PLAIN = (f"the same of the sleepers {where}, mm/m" for where in (
    "in the transition", "on plain track"))
SLEEPERS_REACHED = "the same distance for the level of the sleepers, m"
SETTLEMENT = "settlement of sleepers into the bed, relative to the ground, largest, mm"
UNEVENNESS = "difference of the levels of all sleepers of the bed before the train, largest, mm"
SENTENCES = {
    f"increases from {N} mm on the structure to {N} mm on the plain track":
        ((STRUCTURE, 1), (PLAIN, 1)),
    f"Without the wedge, 90 % of this increase is reached {N} m behind the structure, with the "
    f"wedge {N} m behind it": ((REACHED, 1), (REACHED, 0)),
    f"between two sleepers is {N} mm/m without the wedge, {N} m behind the structure, and {N} mm/m "
    f"with it, .*?, {N} m behind the structure":
        ((STEEPEST, 1), (BEHIND, 1), (STEEPEST, 0), (BEHIND, 0)),
    f"changes between neighbouring sleepers of plain track, up to {N} mm/m": ((SCATTER, max),),
    f"sleepers themselves reach 90 % of their change {N} m behind the structure without the wedge "
    f"and {N} m behind it with the wedge": ((SLEEPERS_REACHED, 1), (SLEEPERS_REACHED, 0)),
    f"change of the sleepers' own levels is {N} mm/m without the wedge and {N} mm/m with it, on "
    f"plain track up to {N} mm/m": ((SLEEPERS, 1), (SLEEPERS, 0), (SLEEPERS_PLAIN, max)),
    f"no sleeper but the three at each end settles by more than {N} mm with the wedge and {N} mm "
    "without":
        ((SETTLEMENT, 0), (SETTLEMENT, 1)),
    f"sleepers whose levels differ by up to {N} mm": ((UNEVENNESS, max),),
    f"wheel force in the transition is {N} kN with the wedge and {N} kN without, on plain track "
    f"{N} and {N} kN; the mean over the bed is {N} and {N} kN":
        ((FORCE, 0), (FORCE, 1), (ON_PLAIN, 0), (ON_PLAIN, 1), (MEAN, 0), (MEAN, 1)),
}


def rows_of(text):
    """{name: (with wedge, without)} of transition.txt."""
    found = re.findall(r"^(.*?) {2,}(-?[\d.e+-]+) +(-?[\d.e+-]+)$", text, re.M)
    return {name: (float(first), float(second)) for name, first, second in found}


def check(root):
    """(problems, number of numbers compared)."""
    rows = rows_of((root / "docs/images/quickstart.dat").read_text(encoding="utf-8"))
    readme = " ".join((root / "README.md").read_text(encoding="utf-8").split())
    problems, compared = [], 0
    for sentence, numbers in SENTENCES.items():
        found = re.search(sentence, readme)
        if not found:
            problems.append(f"README.md: no sentence \"{sentence}\"")
            continue
        for text, (row, which) in zip(found.groups(), numbers):
            if row not in rows:
                problems.append(f"quickstart.dat: no row \"{row}\"")
                continue
            value = max(rows[row]) if which is max else rows[row][which]
            digits = len(text.partition(".")[2])
            compared += 1
            # Half a unit of the last digit: both are rounded.
            if abs(float(text) - value) > 0.501 * 10**-digits:
                problems.append(f"README.md: {text} instead of {value:g} ({row})")
    deck = tomllib.loads((root / "inputs/quickstart.toml").read_text(encoding="utf-8"))
    load, = (stage for stage in deck["stage"] if stage["kind"] == "load")
    stated = f"loaded {load['cycles']} times with {load['load'] / 1e3:g} kN"
    if stated not in readme:
        problems.append(f"README.md: not \"{stated}\", as the deck has it")
    return problems, compared + 2


if __name__ == "__main__":
    wrong, count = check(pathlib.Path(sys.argv[1]))
    print("\n".join(wrong) or f"{count} numbers of README.md are those of the stored run")
    sys.exit(1 if wrong else 0)
