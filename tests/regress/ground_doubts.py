#!/usr/bin/env python3
"""A ground whose numbers can hardly be meant: said by `check`, or refused.

    ground_doubts.py PROGRAM DECK FOLDER
"""
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program  # noqa: E402

REFUSED = {"ground.tolerance=1e-17": "must be at least 1e-14"}
# Of the deck of solid sleepers.
REFUSED_OF_SOLIDS = {"solid.seats=[0.1,0.1]": "at 0.1 and 0.1 m: they overlap",
                     "solid.seats=[0.05,-0.02]": "at -0.02 and 0.05 m: they overlap"}
WARNED = {"time.window=2e-5 stage.release.duration=1e-5":
          "time.window = 2e-05: is longer than stage \"release\""}
# Rows of a file of Young's modulus, and words of the warning.
YOUNG = {"0,80\n2,90\n": "80 Pa is outside the usual values (100000 to 1e+12 Pa)",
         "20,8e7\n30,9e7\n": "lie beside the ground (0 to 1.2 m)",
         "-3,8e7\n0,9e7\n": "lie beside the ground (0 to 1.2 m)",
         "0,8e7\n0.3,9e7\n": None}


def want(ran, words, what):
    if words not in ran.stdout + ran.stderr:
        raise SystemExit(f"{what}: wanted {words}: {ran.stdout}{ran.stderr}")


def main():
    program, deck, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2]), pathlib.Path(
        sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for path, refused in ((deck, REFUSED), (deck.with_name("tiny_solids.toml"), REFUSED_OF_SOLIDS)):
        for words, sentence in refused.items():
            want(program.done(1, "check", path, *words.split(), code=2), sentence, words)
    for words, sentence in WARNED.items():
        want(program.done(1, "check", deck, *words.split()), sentence, words)
    table = (folder / "young.csv").resolve()
    for rows, sentence in YOUNG.items():
        table.write_text(f"x_m,young_Pa\n{rows}", encoding="utf-8")
        ran = program.done(1, "check", deck, f"ground.layer.0.young_file={table}")
        if sentence:
            want(ran, sentence, rows)
        elif "young_file" in ran.stdout:
            raise SystemExit(f"a sound table is warned of: {ran.stdout}")


if __name__ == "__main__":
    main()
