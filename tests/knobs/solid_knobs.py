#!/usr/bin/env python3
"""As knobs.py, for sleepers and rails as solids, with a short form of
tests/restart/tiny_solids.toml, and for refusals and warnings of such decks.

    solid_knobs.py PROGRAM DECK FOLDER
"""
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, summary  # noqa: E402
from results import data  # noqa: E402

SHORT = ["stage.fill.duration=0.1", "stage.compact.duration=0.02", "stage.release.duration=0.005",
         "stage.sleepers.duration=0.01", "stage.load.duration=0.01", "stage.load.cycles=1",
         "stage.passage.duration=0.025", "load.start=-0.2"]
# Parameter of the schema -> change of the deck.
KNOBS = {
    "sleepers.model": "sleepers.model=rigid",
    "solid.young": "solid.young=30e9",
    "solid.poisson": "solid.poisson=0.1",
    "solid.element": "solid.element=0.12",
    "solid.rayleigh_stiffness": "solid.rayleigh_stiffness=4e-5",
    "solid.alpha": "solid.alpha=-0.3",
    "solid.half": "solid.half=true",
    "solid.seats": "solid.seats=[-0.12, 0.12]",
    "solid.seat_size": "solid.seat_size=[0.1, 0.1]",
    "solid.rails": "solid.rails=false",
    "solid.pad_shear": "solid.pad_shear=0.5",
}
# Parameters of the beam in other decks, here of solid rails.
ALSO = ["rail.section=CHN60", "rail.young=190e9", "rail.poisson=0.2", "rail.mass=50",
        "rail.area=0.006", "rail.inertia=2e-5", "pad.stiffness=70e6", "pad.damping=10e3",
        "load.axles=[0]"]
TRAIN = ("solid.rails=false stage.passage.train=true train.start=0 track.spacing=0.4 "
         "track.length=12.4 track.sleeper_mass=732 seat.before=15 seat.rails=0.1")
REFUSED = {
    "dimension=plane bed.stone=pebbles": "solid needs dimension = \"space\"",
    "stage.passage.kind=tamp stage.passage.duration=0": 'must be "rigid" for stages of kind',
    "stage.passage.train=true train.start=0": "must be false below a train (train = true)",
    f"{TRAIN} pad.bilinear_at=1e-4 pad.bilinear_stiffness=300e6": "must be 0 on solid sleepers",
    "sleepers.bevel=0.02": "must be 0 for solid sleepers",
    "solid.seats=[0.3]": "puts a seat at y = 0.3 m, which reaches beyond the end of the sleeper",
    "solid.seats=[]": "must contain at least one seat",
    "solid.seat_size=[0.1]": "must be two lengths above 0",
    "solid.seat_size=[0.25, 0.1]": "is wider along x than the sleeper (0.2 m)",
    "solid.alpha=-0.5": "at least -0.33",
    "solid.element=0.01 sleepers.count=2 sleepers.length=2": "unknowns, which every rank solves",
    "load.kind=power": 'must be "winkler" with solid rails',
    "pad.bilinear_at=1e-3 pad.bilinear_stiffness=300e6": "must be 0 with solid.rails = true",
    "time.window=2e-3": "bodies in contact with stones allow about 6.64e-05 s",
}
# For a run that starts with placed solids: change -> part of the refusal.
PLACED = {
    "sleepers.model=rigid": 'sleepers.model = "rigid": the checkpoint',
    "solid.young=30e9": "was made with 37000000000.0",
    "solid.rails=false": "solid.rails = false: the checkpoint",
    "rail.section=CHN60": 'was made with "60E1"',
    "pad.stiffness=70e6": "was made with 120000000.0",
}
# Reports of `check`: pads of any stiffness are possible in a window.
REPORTED = {
    f"{TRAIN} passage.step=2e-5": "(determined by the coupling: passage.step)",
    f"{TRAIN} pad.stiffness=1e12 passage.step=1e-3": "load 271, passage 677\n",
}
WARNED = {
    "sleepers.model=rigid": "solid: has no effect: sleepers.model is rigid",
    'sleepers.free=["z"]': "has no effect on solid sleepers",
}


def seen(program, deck, folder, changes):
    """State after the run, or the refusal."""
    place = folder / "run"
    ran = program(1, "run", deck, *SHORT, *changes, "--force", "-o", place)
    if ran.returncode != 0:
        return {"code": ran.returncode, "refusal": ran.stderr}
    return {"code": 0, "data": data(place / "results.h5"),
            "elements": summary(place).get("solids", {}).get("elements")}


def split(changes):
    """Splits at blanks before a key, as lists also have blanks."""
    parts = []
    for part in changes.split(" "):
        if "=" in part:
            parts.append(part)
        else:
            parts[-1] += " " + part
    return parts


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    before = seen(program, deck, folder, [])
    problems = [] if before["code"] == 0 else [f"the base does not run: {before}"]
    if before != seen(program, deck, folder, []):
        problems.append("two equal runs differ: this test would be meaningless")
    for change, words in PLACED.items():
        ran = program(1, "run", deck, *SHORT, change, f"start={folder / 'run/stage_sleepers.h5'}",
                      "-o", folder / "none")
        if ran.returncode != 2 or words not in ran.stderr:
            problems.append(f"start with {change}: code {ran.returncode}, {ran.stderr}")
    for change in part([*KNOBS.values(), *ALSO]):
        after = seen(program, deck, folder, [change])
        if after["code"] != 0:
            problems.append(f"{change}: {after['refusal']}")
        if after == before:
            problems.append(f"{change} changes nothing")
    for changes, words in part(REFUSED.items()):
        for command in ("check", "run"):
            ran = program(1, command, deck, *split(changes),
                          *(["-o", folder / "none"] if command == "run" else []))
            if ran.returncode != 2 or words not in ran.stderr:
                problems.append(f"{command} {changes}: code {ran.returncode}, {ran.stderr}")
    for changes, words in part(REPORTED.items()):
        ran = program(1, "check", deck, *SHORT, *split(changes))
        if ran.returncode != 0 or words not in ran.stdout:
            problems.append(f"check {changes}: code {ran.returncode}, {ran.stdout}{ran.stderr}")
    for changes, words in part(WARNED.items()):
        ran = program(1, "check", deck, *split(changes))
        if ran.returncode != 0 or not any(line.startswith("warning: ") and words in line
                                          for line in ran.stdout.splitlines()):
            problems.append(f"check {changes}: code {ran.returncode}, {ran.stdout}{ran.stderr}")
    if (folder / "none").exists():
        problems.append("a refused run must leave nothing behind")
    print(f"{len(part(KNOBS))} parameters, {len(part(REFUSED)) + len(PLACED)} refusals")
    if problems:
        raise SystemExit("\n".join(problems))


if __name__ == "__main__":
    main()
