#!/usr/bin/env python3
"""Bitwise identical states on 1 and 3 ranks, in the long tier also on 2 and 4; coupling balances
up to rounding.

    ranks.py PROGRAM DECK FOLDER [key=value ...]

A ground with a yield criterion must have yielded.
"""
import json
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import some  # noqa: E402
from program import Program, summary  # noqa: E402

# Relative. Forces are summed as integers of 2^-60 of the largest force: rounding is far below this.
BALANCE = 1e-10


def main():
    program, deck, root = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    changes = sys.argv[4:]
    shutil.rmtree(root, ignore_errors=True)
    hashes, broken = {}, {}
    for ranks in some((1, 3), (1, 2, 3, 4)):
        folder = root / str(ranks)
        program.done(ranks, "run", deck, *changes, "-o", folder)
        found = summary(folder)
        hashes[ranks] = found["dem"]["state_hash"]
        broken[ranks] = json.dumps([found.get("breakage"), found.get("bonds")])
        for name, value in found["coupling"].items():
            if not 0 <= value <= BALANCE:
                raise SystemExit(f"{ranks} ranks: imbalance of {name} is {value}")
        if found["ranks"] != ranks or found["dem"]["particles"] < 10:
            raise SystemExit(f"{ranks} ranks: not the requested run: {found}")
        if any("yield=" in change for change in changes) and found["ground"]["plastic_j"] <= 0:
            raise SystemExit("the ground does not yield: the comparison is meaningless")
    print(hashes)
    if len(set(hashes.values())) != 1:
        raise SystemExit(f"state depends on the number of ranks: {hashes}")
    if len(set(broken.values())) != 1:
        raise SystemExit(f"breakage depends on the number of ranks: {broken}")
    if found.get("breakage", {"fragments": 10})["fragments"] < 10:
        raise SystemExit(f"hardly anything breaks: the comparison is meaningless: {broken}")
    for kind, parameter in (("splits", "breakage.splitting.strength"),
                            ("cuts", "breakage.cutting.strength"),
                            ("wears", "breakage.wear.coefficient")):
        if any(change.startswith(parameter) for change in changes) and \
                found["breakage"][kind] == 0:
            raise SystemExit(f"no {kind}: the comparison is meaningless: {broken}")
    bonds = found.get("bonds", {"made": 20, "whole": 10})
    if min(bonds["whole"], bonds["made"] - bonds["whole"]) < 10:
        raise SystemExit(f"too few bonds break or stay: the comparison is meaningless: {bonds}")


if __name__ == "__main__":
    main()
