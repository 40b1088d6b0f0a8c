#!/usr/bin/env python3
"""Messages on the boundary conditions of a ground: refused sides, and unusual ones with a warning.

    borders.py PROGRAM DECK FOLDER
"""
import pathlib
import re
import shutil
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from part import part  # noqa: E402
from program import Program, expect, summary  # noqa: E402

PERIODIC = "ground.side_x_low=periodic ground.side_x_high=periodic"
YIELDS = "ground.layer.soil.yield=mohr_coulomb ground.plane=strain"
PAIR = 'side_x_low = side_x_high = "periodic"'
SOFT = "ground.layer.soil.young=1e6"
# Changes of the tiny deck and a part of the refusal or warning.
# The springs of the deck would oppose a wave.
WAVE = "ground.base_stiffness=0 ground.base_motion={folder}"
REFUSED = {"ground.side_x_low=open": "\"fixed\", \"as_sides\" or \"periodic\"",
           f"{YIELDS} ground.side_x_high=free_field": "has elastic columns beside the model",
           "ground.side_x_low=periodic": 'needs side_x_high = "periodic": both ends of the ground',
           "ground.side_x_high=periodic": 'needs side_x_low = "periodic": both ends of the ground',
           "ground.side_y_low=periodic": 'needs side_y_high = "periodic"',
           f"{PERIODIC} ground.ratio_x=1.1":
               "use ratio_x = 1 or fine_x at the middle of the ground",
           f'{PERIODIC} periodic=["x"] ground.x=[-0.2,1.4]':
               "gives the ground a period of 1.6 m, but that of the stones is 1.2 m",
           f"{WAVE}/wave.csv":
               'ground.sides = "roller": holds the ends of the ground, which base_motion moves',
           f"ground.sides=free_field ground.side_x_high=fixed {WAVE}/wave.csv":
               'ground.side_x_high = "fixed": holds the ends of the ground',
           f"{YIELDS} ground.sides=free_field {WAVE}/wave.csv":
               f"which do not match yielding layers; use {PAIR}",
           f"{YIELDS} {WAVE}/wave.csv":
               f"which base_motion moves along the track (vx_m_s is not 0); use {PAIR}",
           f"{WAVE}/bare.csv": "vz_m_s"}
WARNED = {"ground.side_x_low=free_field": "side_x_low = \"free_field\": acts as a viscous side",
          f"ground.side_x_low=viscous {WAVE}/upwards.csv":
              f"side_x_low = \"viscous\": impedes the wave of base_motion; use free_field or "
              f"{PAIR}",
          f"{YIELDS} ground.sides=viscous {WAVE}/wave.csv":
              f"sides = \"viscous\": impedes the wave of base_motion; use {PAIR}",
          f"ground.side_x_high=fixed {WAVE}/upwards.csv":
              "side_x_high = \"fixed\": impedes the wave of base_motion",
          f"ground.sides=free {WAVE}/wave.csv":
              "sides = \"free\": has no ground beside it that moves with base_motion",
          "ground.sides=free ground.side_x_low=viscous ground.side_x_high=roller":
              "sides = \"free\": has no effect: the kind of each side is given",
          f"{WAVE}/under_way.csv":
              "under_way.csv: the ground starts from rest at 0 s, but the wave already has "
              "vx_m_s = 0 m/s, vz_m_s = 0.01 m/s",
          f"{WAVE}/over.csv":
              "over.csv: the wave ends at -0.01 s, before the ground starts to move at 0 s",
          f"{WAVE}/late.csv":
              "late.csv: the wave begins at 0.3 s, but the ground moves for at most 0.3 s",
          f"{WAVE}/last.csv":
              "last.csv: the ground moves for at most 0.3 s; by then only 8.3 % of the wave's "
              "energy has",
          f"{WAVE}/near.csv ground.layer.soil.young=1e5":
              "near.csv: the ground moves for at most 0.3 s; the wave has entered at the base "
              "after 0.277 s",
          f"{SOFT} ground.elements_z=3 {WAVE}/upwards.csv":
              "ground.elements_z: elements 0.2 m high in layer \"soil\" do not resolve the wave of "
              "base_motion (vz_m_s): 95 % of",
          f"{SOFT} ground.layer.soil.elements=8 ground.sides=free_field "
          f"{WAVE}/wave.csv":
              "ground.layer[0].elements: elements 0.075 m high in layer \"soil\" do not resolve "
              "the wave of base_motion (vx_m_s)",
          f"{WAVE}/fast.csv":
              "fast.csv: the largest speed, 50 m/s, is outside the usual values (at most 5 m/s); "
              "is its unit right?",
          f"{WAVE}/still.csv": "has no motion: all its velocities are 0",
          "ground.side_y_low=viscous": "side_y_low = \"viscous\": has no effect in a plane model"}
TAKEN = ["ground.side_x_low=fixed ground.side_x_high=viscous", PERIODIC,
         f"{PERIODIC} ground.ratio_x=1.1 ground.fine_x=0.6 ground.elements_x=8",
         f"{YIELDS} {PERIODIC}", f"{YIELDS} {PERIODIC} {WAVE}/wave.csv",
         f"{WAVE}/upwards.csv",
         f"ground.sides=free_field {WAVE}/wave.csv",
         PERIODIC + f" {WAVE}/wave.csv",
         f"{WAVE}/near.csv",
         f"{SOFT} {WAVE}/upwards.csv"]
# Tables of upward waves, in rows of time_s and vz_m_s.
UPWARDS = {"upwards": "0,0 0.01,0.01 0.02,0", "under_way": "-0.01,0 0,0.01 0.01,0",
           "over": "-0.03,0 -0.02,0.01 -0.01,0 0.2,0", "late": "0,0 0.3,0 0.31,0.01 0.32,0",
           "fast": "0,0 0.01,50 0.02,0", "near": "0,0 0.26,0 0.27,0.01 0.28,0",
           "last": "-0.1,0 0.29,0 0.31,0.01 0.32,0", "still": "0,0 0.02,0"}


# A run of another deck: stones between walls on a periodic ground.
RUN = [*PERIODIC.split(), "ground.layer.soil.rayleigh_stiffness=1e-5"]


def check_runs(program, deck, folder):
    """The whole model on periodic ground: bitwise identical on two ranks, and after a stop."""
    for ranks in (1, 2):
        program.done(ranks, "run", deck, *RUN, "-o", folder / f"on_{ranks}")
    program.done(2, "run", deck, *RUN, "output.stop_after=150", "-o", folder / "stopped", code=3)
    program.done(1, "resume", folder / "stopped", "output.stop_after=0")
    whole = summary(folder / "on_1")
    for other in ("on_2", "stopped"):
        if summary(folder / other)["dem"]["state_hash"] != whole["dem"]["state_hash"]:
            raise SystemExit(f"{other}: not bitwise identical to one rank")
    if summary(folder / "made")["dem"]["state_hash"] == whole["dem"]["state_hash"]:
        raise SystemExit("periodic ends have no effect")


def main(program, deck, folder):
    program, folder = Program(program), pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "wave.csv").write_text("time_s,vx_m_s,vz_m_s\n0,0,0\n0.01,0.01,0.01\n0.02,0,0\n")
    for name, rows in UPWARDS.items():
        (folder / f"{name}.csv").write_text(
            "time_s,vz_m_s,vx_m_s\n" + "".join(f"{row},0\n" for row in rows.split()))
    (folder / "bare.csv").write_text("time_s,vx_m_s\n0,0\n0.01,0.01\n0.02,0\n")

    def check(changes):
        return program(1, "check", deck,
                       *re.split(r" (?=[a-z])", changes.format(folder=folder)))

    for changes, words in part(REFUSED.items()):
        ran = check(changes)
        expect(ran.returncode == 2 and words in ran.stderr, f"{changes} must report {words}", ran)
        expect(len(ran.stderr.splitlines()) == 1, f"{changes} must give one message", ran)
    for changes, words in part(WARNED.items()):
        ran = check(changes)
        expect(ran.returncode == 0, f"{changes} must not be an error", ran)
        expect(any(line.startswith("warning: ") and words in line
                   for line in ran.stdout.splitlines()), f"{changes} must warn: {words}", ran)
    for changes in part(TAKEN):
        ran = check(changes)
        expect(ran.returncode == 0 and not any(word in ran.stdout
                                               for word in ("side_", ".csv", "blur")),
               f"{changes} is sound", ran)
    # A plane model has only these sides.
    own = "ground.side_x_low=viscous ground.side_x_high=viscous"
    ran = check(f"{YIELDS} ground.sides=free_field {own}")
    expect(ran.returncode == 0 and "acts as" not in ran.stdout, "no side takes this kind", ran)
    # Boundary conditions of a ground that has moved cannot be changed.
    program.done(1, "run", deck, "-o", folder / "made")
    start = f"start={folder / 'made' / 'stage_load.h5'}"
    for change in ("ground.side_x_low=viscous", "ground.side_y_high=free"):
        ran = program(1, "check", deck, start, change)
        expect(ran.returncode == 2 and "was made with" in ran.stderr, f"{change}: refused", ran)
    check_runs(program, deck, folder)
    print("ok")


if __name__ == "__main__":
    main(*sys.argv[1:])
