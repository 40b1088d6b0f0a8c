#!/usr/bin/env python3
"""Sleepers beyond the ground of a track: the refusal names the parameter that is out of range.

    footings.py PROGRAM DECK
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program  # noqa: E402

# A ground of 4.8 m times 2 m with six sleepers 0.6 m apart, the first at 0.9 m, the last at 3.9 m.
ENDS = "footing.first=0.3 ground.x=[0,3.6]"  # equal lengths before the first and behind the last
REFUSED = {
    "footing.y=1.5": "footing.y = 1.5: puts footprints from y = 0.8 to 2.2 m, beyond the ground "
                     "(ground.y: 0 to 2 m); see also footing.length",
    "footing.y=-4": "footing.y = -4: puts footprints from y = -4.7 to -3.3 m, beyond the ground",
    "footing.length=2.2": "footing.length = 2.2: puts footprints from y = -0.2 to 2 m, beyond the "
                          "ground (ground.y: 0 to 2 m); see also footing.y",
    f"{ENDS} footing.width=0.7":
        "footing.width = 0.7: puts footprints from x = -0.05 to 3.65 m, beyond the ground "
        "(ground.x: 0 to 3.6 m); half the width must be at most 0.3 m, the distance from the "
        "centre of the first or last sleeper to the end of the ground (see also footing.first)",
    "track.zone=[{from=4.7,to=4.9,footprint=8}]":
        "track.zone: `footprint` puts that of the sleeper at x = 1.5 m of the ground from -0.5 to "
        "3.5 m, beyond the ground (0 to 4.8 m)",
    "footing.width=2": "footing.width = 2: puts footprints from x = -0.1 to 4.9 m",
    "footing.first=0.2":
        "footing.first = 0.2: the first footprint begins at x = -0.05 m, beyond the ground",
    "footing.first=5 footing.width=0.7":
        "footing.count = 6: the last footprint ends at x = 8.35 m",
    "footing.count=8": "footing.count = 8: the last footprint ends at x = 5.35 m"}
SOUND = [ENDS, f"{ENDS} footing.width=0.6", "footing.length=2 footing.y=1"]


def main():
    program, deck = Program(sys.argv[1]), sys.argv[2]
    for change, words in REFUSED.items():
        ran = program(1, "check", deck, *change.split())
        reported = [line for line in ran.stderr.splitlines() if "beyond the ground" in line]
        if ran.returncode != 2 or len(reported) != 1 or words not in reported[0]:
            raise SystemExit(f"{change} must be refused with {words}:\n{ran.stdout}{ran.stderr}")
    for change in SOUND:
        program.done(1, "check", deck, *change.split())
    wider = program.done(1, "check", deck, "track.zone=[{from=5.3,to=5.5,footprint=2}]").stdout
    if "overlap, first at x = 1.5 m of the ground" not in wider:
        raise SystemExit(f"overlapping footprints must be reported: {wider}")


if __name__ == "__main__":
    main()
