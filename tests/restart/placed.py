#!/usr/bin/env python3
"""Placed stones, some of them bonded: histories are bitwise identical on 1, 2 and 3 ranks, and
after a run was stopped and resumed on another number of ranks; a resume with another plate is
refused.

    placed.py PROGRAM DECK FOLDER
"""
import pathlib
import shutil
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, expect, summary  # noqa: E402
from restart import compare, stops  # noqa: E402
from results import datasets  # noqa: E402


def require_moves(folder):
    """Requires contacts among stones, with driven bodies and walls, so that they are tested."""
    found = datasets(folder)
    for path in ("surface/walls", "surface/driven", "stone/arm", "stone/rock", "stone/ball",
                 "stone/clump"):
        if not found[f"history/{path}/peak_force"][-1] > 0:
            raise SystemExit(f"nothing touches {path}")
    spin = found["history/stone/arm/spin"]
    if not np.abs(spin - [0, 0, 3]).max() < 1e-10:
        raise SystemExit("the spin of the driven stone is not constant")
    if found["history/energy/supplied"][-1] == 0:
        raise SystemExit("driven bodies do no work")
    bonds = summary(folder)["bonds"]
    if min(bonds["whole"], bonds["made"] - bonds["whole"]) < 1:
        raise SystemExit(f"of the bonds some must break and some must not: {bonds}")


def main():
    program, deck, root = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(root, ignore_errors=True)
    reference = root / "1"
    program.done(1, "run", deck, "-o", reference)
    require_moves(reference)
    for ranks in (2, 3):
        program.done(ranks, "run", deck, "-o", root / str(ranks))
        compare(reference, root / str(ranks), f"{ranks} ranks")
    if summary(root / "3")["load_balance"]["imbalance_now"] > 2.9:
        raise SystemExit("all stones are on one rank: the comparison is meaningless")
    for ranks, windows in enumerate(part(stops(reference))):
        folder = root / f"stopped_{windows}"
        program.done(1 + ranks % 3, "run", deck, f"output.stop_after={windows}", "-o", folder,
                     code=3)
        ran = program.done(1, "resume", folder, "plate.driven.velocity=[0,0,0]", code=2)
        expect("plate[0].velocity" in ran.stderr, "another plate is accepted", ran)
        program.done(1 + (ranks + 1) % 3, "resume", folder)
        compare(reference, folder, f"stopped after {windows} windows")


if __name__ == "__main__":
    main()
