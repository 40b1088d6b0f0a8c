#!/usr/bin/env python3
"""A run that starts from the checkpoint of another run with a deck without a stage of kind fill: it
can be stopped and resumed like any other, and its results name the start.

    starts.py PROGRAM DECK FOLDER
"""
import pathlib
import shutil
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from program import Program, summary  # noqa: E402
from results import read  # noqa: E402

FIRST = "sleepers"             # stage of the deck at whose end the others start


def later(deck):
    """The deck from its stage FIRST on."""
    text = pathlib.Path(deck).read_text()
    stages = text.index("[[stage]]")
    return text[:stages] + text[text.index(f'[[stage]]\nname = "{FIRST}"'):]


def main(program, deck, folder):
    program, folder = Program(program), pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    program.done(1, "run", deck, "-o", folder / "made")
    short = folder / "later.toml"
    short.write_text(later(deck))
    start = f"start={folder / 'made' / f'stage_{FIRST}.h5'}"
    program.done(1, "run", short, start, "-o", folder / "whole")
    program.done(1, "run", short, start, "output.stop_after=100", "-o", folder / "stopped", code=3)
    softer = program.done(1, "check", short, start, "contact[0].k_n=1e7")
    if "let the stones settle" not in softer.stdout:
        raise SystemExit("other springs than those the stones lie with must be warned of")
    program.done(1, "run", short, start, "contact[0].k_n=1e7", "output.stop_after=2", "-o",
                 folder / "softer", code=3)
    (folder / "made").rename(folder / "gone")  # the state contains all that is needed
    program.done(2, "resume", folder / "stopped", "output.stop_after=0")
    for stop in (4, 6):
        program.done(1, "resume", folder / "softer", f"output.stop_after={stop}", code=3)
        kept = summary(folder / "softer")["warnings"]
        if sum("let the stones settle" in text for text in kept) != 1:
            raise SystemExit("what was odd about a start must outlive resumes, once: "
                             f"{kept}")
    whole, stopped = summary(folder / "whole"), summary(folder / "stopped")
    if whole["dem"]["state_hash"] != stopped["dem"]["state_hash"]:
        raise SystemExit("a stopped and resumed start is not bitwise identical")
    for run in ("whole", "stopped"):
        stored = read.results(folder / run).deck
        if stored["start"] != start.removeprefix("start="):
            raise SystemExit(f"{run}: the results have start = {stored['start']!r}")
    print("ok")


if __name__ == "__main__":
    main(*sys.argv[1:])
