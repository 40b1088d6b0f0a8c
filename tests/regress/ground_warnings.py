#!/usr/bin/env python3
"""A ground with implausible values: reported by `check`, or refused. Its files: changed since a
checkpoint, or missing on one rank.

    ground_warnings.py PROGRAM DECK FOLDER
"""
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, summary  # noqa: E402

REFUSED = {"ground.tolerance=1e-17": "must be at least 1e-14"}
# For the deck of solid sleepers.
REFUSED_OF_SOLIDS = {"solid.seats=[0.1,0.1]": "at y = 0.1 and 0.1 m: the seats overlap",
                     "solid.seats=[0.05,-0.02]": "at y = -0.02 and 0.05 m: the seats overlap"}
WARNED_OF_SOLIDS = {"load.start=0.3 stage.passage.ramp=0":
                    "load.start = 0.3: the first wheel, at x = 0.3 m, acts on the rails suddenly"}
WARNED = {"time.window=2e-5 stage.release.duration=1e-5":
          "time.window = 2e-05: is longer than stage \"release\"",
          "ground.elements_x=21": "inside an element (0.457143 to 0.514286 m)",
          "ground.elements_z=800": "elements are up to 0.06 m long along x, but only 0.00075 m"}
# Rows of a file of Young's modulus, and words of the warning.
YOUNG = {"0,80\n2,90\n": "80 Pa is outside the usual values (500000 to 3e+11 Pa)",
         "20,8e7\n30,9e7\n": "are outside of the ground (0 to 1.2 m)",
         "-3,8e7\n0,9e7\n": "are outside of the ground (0 to 1.2 m)",
         "0,8e7\n0.3,9e7\n": None}


def want(ran, words, what):
    if words not in ran.stdout + ran.stderr:
        raise SystemExit(f"{what}: wanted {words}: {ran.stdout}{ran.stderr}")


def check_changed_table(program, deck, table, folder):
    """The moduli of a ground that has moved cannot be changed."""
    table.write_text("x_m,young_Pa\n0,8e7\n0.3,9e7\n", encoding="utf-8")
    words = [f"ground.layer.0.young_file={table}"]
    program.done(1, "run", deck, *words, "-o", folder / "moved")
    start = f"start={folder / 'moved/stage_load.h5'}"
    program.done(1, "check", deck, *words, start)
    table.write_text("x_m,young_Pa\n0,8e7\n0.3,1e8\n", encoding="utf-8")
    want(program.done(1, "check", deck, *words, start, code=2),
         "young.csv\": the content of the file has changed since", "a table that has changed")
    program.done(1, "check", deck, *words, f"start={folder / 'moved/stage_cribs.h5'}")


def check_kept(program, deck, table, folder):
    """Warnings on a table are in the summary, also of a resumed run."""
    table.write_text("x_m,young_Pa\n20,8e7\n30,9e7\n", encoding="utf-8")
    program.done(1, "run", deck, f"ground.layer.0.young_file={table}", "output.stop_after=2", "-o",
                 folder / "kept", code=3)
    for stop in (4, 6):
        kept = summary(folder / "kept")["warnings"]
        if sum("are outside of the ground" in text for text in kept) != 1:
            raise SystemExit(f"the warning of the table must be kept, once: {kept}")
        program.done(1, "resume", folder / "kept", f"output.stop_after={stop}", code=3)


def check_one_rank_alone(path, deck, folder):
    """A table missing on the second rank, whose folder differs, is refused at once. For a file that
    is read without agreement of the ranks, the single rank with an error ends the run."""
    for place in ("first", "second"):
        (folder / place).mkdir()
    (folder / "first/young.csv").write_text("x_m,young_Pa\n0,8e7\n1,9e7\n", encoding="utf-8")
    (folder / "first/profile.csv").write_text("x_m,z_m\n0,0\n60,0\n", encoding="utf-8")
    plain = deck.parents[2] / "inputs/track/plain.toml"
    for words, sentence in ((["check", deck, "ground.layer.0.young_file=young.csv"],
                             "young.csv"),
                            (["run", plain, "irregularity.kind=file",
                              "irregularity.file=profile.csv", "-o", "out"], "only on rank 1: ")):
        ran = subprocess.run(
            ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", "1", "--wdir",
             folder / "first", path, *words, ":", "-n", "1", "--wdir", folder / "second", path,
             *words], capture_output=True, text=True, timeout=100, check=False)
        if ran.returncode != 2:
            raise SystemExit(f"{words}: ended with {ran.returncode}: {ran.stdout}{ran.stderr}")
        want(ran, sentence, words)


def main():
    program, deck, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2]), pathlib.Path(
        sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for path, refused in ((deck, REFUSED), (deck.with_name("tiny_solids.toml"), REFUSED_OF_SOLIDS)):
        for words, sentence in refused.items():
            want(program.done(1, "check", path, *words.split(), code=2), sentence, words)
    silent = program.done(1, "check", deck).stdout
    for words, sentence in part(WARNED.items()):
        if sentence in silent:
            raise SystemExit(f"check warns of the deck itself: {sentence}: {silent}")
        want(program.done(1, "check", deck, *words.split()), sentence, words)
    for words, sentence in WARNED_OF_SOLIDS.items():
        for ramp in (words, words.replace("ramp=0", "ramp=0.01")):
            ran = program.done(1, "check", deck.with_name("tiny_solids.toml"), *ramp.split())
            if (sentence in ran.stdout) != (ramp == words):
                raise SystemExit(f"{ramp}: {sentence}: {ran.stdout}")
    table = (folder / "young.csv").resolve()
    for rows, sentence in part(YOUNG.items()):
        table.write_text(f"x_m,young_Pa\n{rows}", encoding="utf-8")
        ran = program.done(1, "check", deck, f"ground.layer.0.young_file={table}")
        if sentence:
            want(ran, sentence, rows)
        elif "young_file" in ran.stdout:
            raise SystemExit(f"a valid table has a warning: {ran.stdout}")
    check_changed_table(program, deck, table, folder.resolve())
    check_kept(program, deck, table, folder.resolve())
    check_one_rank_alone(sys.argv[1], deck.resolve(), folder.resolve())


if __name__ == "__main__":
    main()
