#!/usr/bin/env python3
"""A vehicle over solid sleepers compared with rigid ones on the same bed, on the deck
tests/restart/tiny_solids: with 1e4 times Young's modulus both are the same track.

    train_on_solids.py PROGRAM DECK FOLDER
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import histories  # noqa: E402

STATIC = 54545  # N, of a wheel: a quarter of an axle load of 109.09 kN in each of two rails
RAILS = 0.1     # number of rails on the narrow sleepers
MASS, GRAVITY = 2441 * 0.3 * 0.15 * 0.5, 9.81
# Sleepers are placed 15 ms before the train starts, whose first wheel is on them 10 ms later. Loose
# stones amplify any difference, so the models can only be compared in a run that ends before.
# Measured (seed 2): displacements of both kinds differ by 1e-6 m 20 ms after placing, by 3e-5 m
# after 45 ms and by 1e-4 m after 0.1 s.
TRAIN = ["solid.rails=false", "stage.passage.train=true", "stage.passage.duration=0.018",
         "train.start=0", "train.speed=100", "track.spacing=0.4", "track.length=12.4",
         "track.sleeper_mass=1000", "track.run_in=1", "seat.before=3", f"seat.rails={RAILS}",
         "output.history_interval=2e-4", "sleepers.width=0.3",
         "stage.sleepers.duration=0.014", "stage.sleepers.local_damping=0.8",
         "stage.load.load=500", "stage.load.local_damping=0.8", "stage.load.duration=1e-3",
         "stage.load.cycles=1"]
# Same degrees of freedom as solids, and the same bed.
RIGID = ["sleepers.model=rigid", 'sleepers.free=["x", "y", "z", "rx", "ry", "rz"]']
STIFF = ["solid.young=37e13", "solid.alpha=0", "solid.rayleigh_stiffness=0"]
BALANCE = 1e-10  # relative, required of the coupling
# Relative to the wheel's weight and to the range of displacement of the sleepers, root mean square.
# Ten times the largest values of beds of six seeds: 1e-3 of the weight, 1.2e-3 of the displacement.
# The agreement on springs is the subject of verify/solids/train_on_solids_test.
LIKE = 0.01


def apart(one, other):
    """Root mean square of the difference."""
    return np.sqrt(np.mean((one - other) ** 2))


def wrong_forces(stiff):
    """Equation of motion of each sleeper in each row, with the force of the rail."""
    wrong = []
    off = (stiff["sleeper/reaction"] + stiff["sleeper/seat_force"]
           - MASS * (GRAVITY + stiff["sleeper/acceleration"]))
    if np.abs(off).max() > 1e-6 * STATIC:
        wrong.append(f"forces on sleepers do not balance: {np.abs(off).max()} N")
    most = -stiff["sleeper/seat_force"].min()
    if not 0.1 * RAILS * STATIC < most < 2 * RAILS * STATIC:
        wrong.append(f"largest force of the pads {most} N")
    return wrong


def wrong_motion(found):
    over = found["rigid"]["wheel/x"][:, 0]
    over = (over > 0) & (over < 0.8)
    swing = np.ptp(found["rigid"]["sleeper/displacement"], axis=0).max()
    like = {}
    for name in ("stiff", "solid"):
        force = apart(found[name]["wheel/force"][over, 0], found["rigid"]["wheel/force"][over, 0])
        error = apart(found[name]["sleeper/displacement"], found["rigid"]["sleeper/displacement"])
        print(f"{name} and rigid: wheel forces {force:.3g} N, "
              f"sleepers {error:.3g} of {swing:.3g} m")
        like[name] = force < LIKE * STATIC and error < LIKE * swing
    return [] if like["stiff"] else ["stiff solid sleepers differ from rigid ones"]


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    places = {name: folder / name for name in ("solid", "stiff", "rigid")}
    program.done(2, "run", deck, *TRAIN, "--force", "-o", places["solid"])
    start = f"start={places['solid'] / 'stage_release.h5'}"
    program.done(1, "run", deck, *TRAIN, *STIFF, start, "--force", "-o", places["stiff"])
    program.done(1, "run", deck, *TRAIN, *RIGID, start, "--force", "-o", places["rigid"])
    # After a stage the solids are without a rail, so that another one may follow.
    program.done(1, "run", deck, *TRAIN, f"start={places['solid'] / 'stage_load.h5'}",
                 "pad.stiffness=100e6", "stage.passage.duration=1e-3", "--force", "-o",
                 folder / "other")
    wrong = [f"{name}: imbalance of {key} is {value}" for name, place in places.items()
             for key, value in summary(place)["coupling"].items() if not 0 <= value <= BALANCE]
    found = {name: histories(place) for name, place in places.items()}
    wrong += wrong_forces(found["stiff"]) + wrong_motion(found)
    if wrong:
        sys.exit("\n".join(wrong))


main()
