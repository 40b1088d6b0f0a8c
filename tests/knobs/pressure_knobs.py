#!/usr/bin/env python3
"""As knobs.py, for the pressures on a ground alone, and for refusals of such decks.

    pressure_knobs.py PROGRAM DECK FOLDER
"""
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, expect  # noqa: E402
from results import data  # noqa: E402

# Parameter of the schema -> change of the deck.
KNOBS = {
    "pressure.[].name": "pressure.plate.name=foot",
    "pressure.[].x": "pressure.plate.x=[1,2.5]",
    "pressure.[].y": "pressure.plate.y=[-0.5,0.75]",
    "pressure.[].pressure": "pressure.plate.pressure=60e3",
    "pressure.[].along": "pressure.plate.along=5e3",
    "pressure.[].across": "pressure.plate.across=5e3",
    "pressure.[].course": "pressure.plate.course=rise",
    "pressure.[].begin": "pressure.plate.begin=0.004",
    "pressure.[].duration": "pressure.plate.duration=0.01",
    "pressure.[].frequency": "pressure.plate.frequency=40",
    "pressure.[].file": "pressure.plate.file={folder}/double.csv",
    "pressure.[].speed": "pressure.plate.speed=20",
}
AROUND = {
    "pressure.[].frequency": ["pressure.plate.course=harmonic", "pressure.plate.duration=0",
                              "pressure.plate.frequency=30"],
    "pressure.[].file": ["pressure.plate.course=table", "pressure.plate.begin=0",
                         "pressure.plate.duration=0", "pressure.plate.file={folder}/single.csv"],
}
HALF = ("ground.block=[{name='half',outline=[1,0,3,0,3,-1,1,-1],young=1e7,poisson=0.3,"
        "density=1700,y=[-1,0]}]")
# Change of the deck -> part of the refusal.
REFUSED = {
    f"{HALF} ground.block.half.y=[0]": "must be two increasing numbers",
    f"{HALF} ground.block.half.y=[0.01,0.02]": "the centre of any element of the ground (y = ",
    f"{HALF} dimension=plane": "ground.block[0].y = [-1, 0]: must not be given in a plane model",
    f"{HALF} ground.sides=free_field": "cannot be given with free-field sides",
    "pressure.plate.x=[2,1]": "must be two increasing numbers",
    "pressure.plate.x=[3,5]": "reaches beyond the top of the ground (0 to 4 m)",
    "pressure.plate.y=[0,3]": "beyond the top of the ground (-1 to 1 m)",
    "pressure.plate.y=[0]": "must be two increasing numbers",
    "pressure.plate.speed=-100 pressure.plate.x=[-3,-2]": "is never on the ground",
    "pressure.plate.pressure=0": "the load is zero",
    "pressure.plate.duration=0": "must be above 0 s for a pulse",
    "pressure.plate.course=harmonic": "must be above 0 Hz",
    "pressure.plate.course=table": "must be given for course",
    "pressure.plate.course=table pressure.plate.file={folder}/bad.csv": "bad.csv:3",
    "pressure.plate.course=dead pressure.plate.speed=1": "must be 0 m/s for a dead load",
    "pressure.plate.nam=x": "did you mean pressure[0].name?",
    "pressure.surcharge.name=plate": "pressures need different names",
    "pressure.surcharge.name='a b'": "must be a word",
    "pressure.plate.thickness=1": "did you mean thickness at the top of the deck or ground",
    "stage.blow.kind=settle": 'must be "run": a ground alone has no other kind of stage',
    "stage.blow.ground_moves=false": "must be true: nothing else moves",
    "ground.present=false": "must be true for model = \"ground\"",
    "ground.integrator=newmark": "must be given for an implicit ground",
    "dimension=plane": "has no effect in a plane model",
    "bed.height=0.3": "bed",
}
# Change of the deck -> part of the warning.
WARNED = {
    f"{HALF} ground.block.half.y=[-3,0]": "is cut off where it extends beyond the ground (y",
    "pressure.surcharge.duration=1": 'has no effect with course = "dead"',
    "pressure.plate.begin=1": "is after the end of the last stage at 0.04 s",
    "time.substeps=2": "has no effect without stones",
    "stage.blow.lift=0.5": "has no effect: it is for stages of kind release",
    "stage.blow.friction=0.5": "has no effect without stones",
    "output.surface_cell=0.1": "has no effect without stones",
    "time.window=0.02": "is longer than stage \"rest\"",
    "time.window=0.001 output.history_interval=0.0001": "is less than a time window",
    "pressure.plate.course=dead pressure.plate.duration=0 pressure.plate.begin=0":
        "nothing moves the ground",
    "ground.integrator=newmark time.window=0.01": "is less than 4 windows; give a shorter",
    "ground.integrator=newmark time.window=0.01 pressure.plate.course=harmonic"
    " pressure.plate.frequency=50": "gives cycles of 0.02 s",
    "ground.integrator=newmark time.window=0.005 pressure.plate.speed=-210":
        "moves the pressure in a window by 1.05 m",
}


def seen(program, deck, overrides, place):
    ran = program(1, "run", deck, *overrides, "-o", place)
    found = (ran.returncode, ran.stderr if ran.returncode == 2 else
             [line for line in ran.stdout.splitlines() if "wall" not in line and "MB" not in line
              and "time in" not in line and "%" not in line],
             data(place / "results.h5") if (place / "results.h5").exists() else None)
    effective = (place / "results.h5").exists()
    shutil.rmtree(place, ignore_errors=True)
    return found, effective


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, factor in (("single", 1), ("double", 2)):
        (folder / f"{name}.csv").write_text(f"time_s,factor\n0,0\n0.01,{factor}\n0.02,0\n")
    (folder / "bad.csv").write_text("time_s,factor\n0,0\n0.01,much\n")

    def with_folder(changes):
        return [change.replace("{folder}", str(folder)) for change in changes]

    problems = []
    for name, change in part(KNOBS.items()):
        if name.endswith(".name"):
            continue  # a name appears only in messages, below
        around = with_folder(AROUND.get(name, []))
        before, ran = seen(program, deck, around, folder / "before")
        after, _ = seen(program, deck, [*around, *with_folder([change])], folder / "after")
        if before[0] != 0 or after[0] != 0 or not ran:
            problems.append(f"{name}: ends with {before[:2]}, {after[:2]}")
        if before == after:
            problems.append(f"{name}: {change} changes nothing")
    for changes, words in part(REFUSED.items()):
        ran = program(1, "run", deck, *with_folder(changes.split()), "-o", folder / "refused")
        if ran.returncode != 2 or words not in ran.stderr or (folder / "refused").exists():
            problems.append(f"{changes}: code {ran.returncode}, without \"{words}\": {ran.stderr}")
    for changes, words in part(WARNED.items()):
        ran = program(1, "check", deck, *changes.split())
        if ran.returncode != 0 or words not in ran.stdout:
            problems.append(f"{changes}: no warning \"{words}\": {ran.stdout}{ran.stderr}")
    ran = program.done(1, "check", deck)
    expect("warning" not in ran.stdout, "a valid deck has a warning", ran)
    expect("windows of" in ran.stdout and "of wall time" in ran.stdout, "no estimate", ran)
    if problems:
        raise SystemExit("\n".join(problems))


if __name__ == "__main__":
    main()
