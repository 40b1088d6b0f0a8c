#!/usr/bin/env python3
"""What is said of the borders of a ground: sides that cannot be meant, and those that are only odd.

    borders.py PROGRAM DECK FOLDER
"""
import pathlib
import re
import shutil
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from program import Program  # noqa: E402

YIELDS = "ground.layer.soil.yield=mohr_coulomb ground.plane=strain"
# Changes of the tiny deck and the words of the refusal, or of the warning.
REFUSED = {"ground.side_x_low=open": "fixed or as_sides",
           f"{YIELDS} ground.side_x_high=free_field": "has elastic columns beside the model"}
WARNED = {"ground.side_x_low=free_field": "side_x_low = \"free_field\": act as quiet ones",
          "ground.side_x_low=quiet ground.base_motion={folder}/wave.csv":
              "side_x_low = \"quiet\": hold back the wave of base_motion",
          "ground.side_x_high=fixed ground.base_motion={folder}/wave.csv":
              "side_x_high = \"fixed\": hold back the wave of base_motion",
          "ground.side_y_low=quiet": "side_y_low = \"quiet\": has no effect in a plane model"}
TAKEN = ["ground.side_x_low=fixed ground.side_x_high=quiet"]


def expect(holds, what, ran):
    if not holds:
        raise SystemExit(f"{what}\ncode {ran.returncode}\n{ran.stdout[-2000:]}\n{ran.stderr}")


def main(program, deck, folder):
    program, folder = Program(program), pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "wave.csv").write_text("time_s,vx_m_s,vz_m_s\n0,0,0\n0.01,0.01,0.01\n0.02,0,0\n")

    def check(changes):
        return program(1, "check", deck,
                       *re.split(r" (?=[a-z])", changes.format(folder=folder)))

    for changes, words in REFUSED.items():
        ran = check(changes)
        expect(ran.returncode == 2 and words in ran.stderr, f"{changes} must say {words}", ran)
        expect(len(ran.stderr.splitlines()) == 1, f"{changes} must give one sentence", ran)
    for changes, words in WARNED.items():
        ran = check(changes)
        expect(ran.returncode == 0, f"{changes} is no error", ran)
        expect(any(line.startswith("warning: ") and words in line
                   for line in ran.stdout.splitlines()), f"{changes} must warn: {words}", ran)
    for changes in TAKEN:
        ran = check(changes)
        expect(ran.returncode == 0 and "side_" not in ran.stdout, f"{changes} is sound", ran)
    # A ground that has moved keeps its borders.
    program.done(1, "run", deck, "-o", folder / "made")
    start = f"start={folder / 'made' / 'stage_load.h5'}"
    for change in ("ground.side_x_low=quiet", "ground.side_y_high=free"):
        ran = program(1, "check", deck, start, change)
        expect(ran.returncode == 2 and "was made with" in ran.stderr, f"{change}: refused", ran)
    print("ok")


if __name__ == "__main__":
    main(*sys.argv[1:])
