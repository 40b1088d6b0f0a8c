#!/usr/bin/env python3
"""`check` accepts and draws every deck under inputs, and the two decks of transition zones, which
are too long for tests, run through all their stages in a short form: the bed is loose and the train
passes at 900 m/s, with smaller loads than the deck's, under which loose stones overlap too far.

    all_decks.py PROGRAM INPUTS FOLDER
"""
import concurrent.futures
import pathlib
import shutil
import sys
import xml.etree.ElementTree as ET

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from program import Program, cell_of, expect, summary  # noqa: E402

SHORT = ["stage.fill.duration=0.06", "stage.compact.duration=0.01", "stage.release.duration=0.005",
         "stage.sleepers.duration=0.01", "stage.bed_in.duration=0.02", "stage.bed_in.cycles=1",
         "stage.bed_in.load=40e3", "stage.trains.cycles=1", "load.speed=900", "load.peak=40e3",
         "output.fields=false", "output.checkpoint_interval=0"]
STAGES = ["fill", "compact", "release", "sleepers", "bed_in", "trains", "passage"]


def check(program, deck, folder):
    """The report of a deck that is not accepted or not drawn, or nothing. One that repeats a cell
    which another deck makes is refused in its absence, but drawn without it."""
    drawing = folder / f"{deck.parent.name}_{deck.stem}.svg"
    ran = program(1, "check", deck, "--draw", drawing)
    lines = ran.stderr.strip().splitlines()
    if (cell_of(deck) and ran.returncode == 2 and len(lines) == 1
            and "bed.cell" in lines[0] and "does not exist" in lines[0]):
        ran = program(1, "check", deck, "bed.cell=", "--draw", drawing)
    if ran.returncode == 0:
        parts = {part.tag.split("}")[1] for part in ET.parse(drawing).getroot().iter()}
        return "" if parts & {"polygon", "circle", "polyline"} else f"{deck}: an empty drawing"
    return f"{deck}: {ran.returncode}\n{ran.stdout}{ran.stderr}"


def run_short(program, deck, folder):
    ran = program.done(1, "run", deck, *SHORT, "-o", folder)
    stages = [stage["name"] for stage in summary(folder)["stages"]]
    expect(stages == STAGES, f"{deck} has the stages {stages}", ran)


def main():
    program, inputs, folder = (Program(sys.argv[1]), pathlib.Path(sys.argv[2]),
                               pathlib.Path(sys.argv[3]))
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    decks = sorted(inputs.rglob("*.toml"))
    if len(decks) < 40:
        raise SystemExit(f"only {len(decks)} decks below {inputs}")
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        runs = [pool.submit(run_short, program, inputs / name, folder / name)
                for name in ("shi/transition.toml", "shi/short.toml")]
        refused = list(filter(None, pool.map(lambda deck: check(program, deck, folder), decks)))
        for run in runs:
            run.result()
    if refused:
        raise SystemExit("\n".join(refused))
    print(f"{len(decks)} decks are valid")


if __name__ == "__main__":
    main()
