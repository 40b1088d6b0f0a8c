#!/usr/bin/env python3
"""Two rails over sleepers on stones, one of them with a dip: bitwise identical on any number of
ranks and after a stop, both rails in histories and figures.

    two_rails_on_bed.py PROGRAM SOURCE_FOLDER FOLDER
"""
import pathlib
import shutil
import subprocess
import sys
import tomllib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import datasets, histories, same_bits  # noqa: E402

STATIC = 550 * 9.80665 / 2  # N, of a wheel
GRAVITY = 9.81
BALANCE = 1e-10  # relative, required of the coupling


SOLID = ["sleepers.model=solid", "solid.seats=[-0.15,0.15]", "solid.seat_size=[0.15,0.1]"]
# On a bed as short as a sleeper whole sleepers also tilt, which must not exceed 0.05 rad. The run
# ends before: a sleeper supported at one edge only rotates by 3 g/(4 width) t^2 = 0.03 rad in these
# 35 ms. The dip is flatter in proportion to the higher speed.
BRIEF = ["solid.alpha=0", "stage.sleepers.duration=0.014", "stage.load.duration=1e-3",
         "stage.load.cycles=1", "stage.load.load=500", "stage.sleepers.seat_force=0",
         "stage.load.seat_force=0", "stage.train.seat_force=0", "stage.train.duration=0.02",
         "train.speed=120", "irregularity.depth=1e-4", "track.run_in=1", "seat.before=3",
         "irregularity.at=1.4", "irregularity.length=0.8", "output.history_interval=1e-4"]
REFUSED = {
    "seat.rails=1": 'seat.rails = 1: must be 2 if track.dimension = "space"',
    "track.gauge=0.6": "must be below the length of the bed's sleepers, which is 0.5 m",
    "track.sleeper_length=0.2": "track.gauge = 0.3 m: rails rest on the sleepers",
    "sleepers.model=solid": "solid.seats = [0.0] (default): must be [0.15, -0.15] below two rails",
    "sleepers.model=solid solid.seats=[-0.1,0.15] solid.seat_size=[0.15,0.1]":
        "must be [0.15, -0.15] below two rails",
    f"{' '.join(SOLID)} track.gauge=0.32": "must be [0.16, -0.16] below two rails",
    f"{' '.join(SOLID)} solid.half=true": "solid.half = true: must be false below two rails",
    f"{' '.join(SOLID)} seat.rails=1": 'seat.rails = 1: must be 2 if track.dimension = "space"',
    "handover.after=sleepers irregularity.kind=none irregularity_right.kind=vee":
        "irregularity_right.kind = \"vee\": must be \"none\" or \"same\" in a deck "
        "with [handover]",
    f"{' '.join(SOLID)} handover.after=sleepers irregularity.kind=none":
        "must be \"rigid\" in a deck with [handover] and two rails",
    "handover.after=sleepers irregularity.kind=none sleepers.free=[\"z\"]":
        "must contain \"rx\" in a deck with [handover] and two rails",
    "load.gauge=0.3": "load.gauge = 0.3: needs kind = \"seats\"",
    "track.dimension=plane":
        "irregularity_right.kind = \"none\": needs two rails (track.dimension",
}
# Words of check: a pad on a seat turns 12 kg where the gauge is 0.45 m, and bears half a sleeper.
REPORTED = {"sleepers.free=[\"z\"]": "does not contain rx: the sleepers of the bed",
        "track.gauge=0.45 pad.stiffness=120e6": "of a sleeper on its pads, m = 12.3 kg per rail",
        "track.gauge=0.45 pad.stiffness=120e6 pad.damping=25e3 sleepers.free=[\"z\"]":
            "of a sleeper on its pads, m = 27.5 kg per rail",
        'track.gauge=0.45 pad.stiffness=120e6 '
        'track.zone=[{from=0,to=60,pad=2,side="right"}]':
            "of a sleeper on its pads (the stiffest ones, by track.zone), m = 12.3 kg per rail, "
            "k = 2.4e+08 N/m"}


def check_sentences(program, deck):
    for changes, words in REFUSED.items():
        ran = program(1, "check", deck, *changes.split(" "))
        if ran.returncode != 2 or words not in ran.stderr:
            raise SystemExit(f"{changes} must be refused with {words}:\n{ran.stdout}{ran.stderr}")
    for changes, words in REPORTED.items():
        ran = program.done(1, "check", deck, *changes.split(" "))
        if words not in ran.stdout:
            raise SystemExit(f"{changes}: check does not report {words}:\n{ran.stdout}")


def facts(of):
    return of["dem"]["state_hash"], of["track"]


def check_runs(program, deck, folder, words, numbers):
    for ranks in numbers:
        place = folder / f"ranks_{ranks}"
        program.done(ranks, "run", deck, *words, "-o", place)
        for name, value in summary(place)["coupling"].items():
            if not 0 <= value <= BALANCE:
                raise SystemExit(f"{ranks} ranks: imbalance of {name} is {value}")
        same_bits(folder / "ranks_1", place, f"{ranks} ranks", facts, "history/")
    stages = summary(folder / "ranks_1")["stages"]
    done = [round(stage["duration_s"] / stage["window_s"]) for stage in stages]
    for part in (0.5, 0.9):
        place = folder / f"stopped_{part}"
        windows = sum(done[:-1]) + round(part * done[-1])
        program.done(2, "run", deck, *words, f"output.stop_after={windows}", "-o", place, code=3)
        program.done(3, "resume", place)
        same_bits(folder / "ranks_1", place, f"stopped after {windows} windows", facts, "history/")


def passage(folder, stages):
    """Histories of the stage with the train, on two seats of two sleepers below two wheels."""
    of = histories(folder, stages - 1)
    shapes = {name: of[name].shape[1:] for name in ("wheel/force", "rail/displacement",
                                                    "seat/displacement", "seat/force")}
    if list(shapes.values()) != [(2,), (4,), (4,), (4,)]:
        raise SystemExit(f"histories of two rails: {shapes}")
    if not np.allclose(of["wheel/force"][0], STATIC, rtol=2e-3):
        raise SystemExit(f"the axle starts with {of['wheel/force'][0]} N, not {STATIC} N")
    # Equation of motion of each sleeper in each row, with the force of the rails.
    mass = 2441 * 0.3 * 0.15 * 0.5
    off = (of["sleeper/reaction"] + of["sleeper/seat_force"]
           - mass * (GRAVITY + of["sleeper/acceleration"]))
    if np.abs(off).max() > 1e-6 * STATIC:
        raise SystemExit(f"forces on sleepers do not balance: {np.abs(off).max()} N")
    if np.abs(of["body/roll"]).max() < 1e-5:
        raise SystemExit("the body does not roll")
    return of


def check_dip(program, deck, folder, words, begins):
    """Compared with a run from the same state without the dip: wheel forces are bitwise identical
    before the dip, which begins at x = `begins`; then the left wheel changes, and the right one by
    no more than half of that, by transfer through the axle (a quarter at most on beds of six
    seeds). Left and right wheel of one run differ on any bed, as its sleepers settle unevenly."""
    program.done(1, "run", deck, *words, f"start={folder / 'ranks_1/stage_load.h5'}",
                 "irregularity.kind=none", "-o", folder / "even")
    wheels = []
    for name in ("ranks_1", "even"):
        rows = datasets(folder / name)
        x = rows["history/wheel/x"][:, 0]
        wheels.append(rows["history/wheel/force"][np.isfinite(x)])
        x = x[np.isfinite(x)]
    off, before = np.abs(wheels[0] - wheels[1]), x < begins
    if not before.any() or off[before].any():
        raise SystemExit(f"wheel forces before the dip change by {off[before].max()} N")
    if off[:, 0].max() < 0.1 * STATIC or off[:, 1].max() > 0.5 * off[:, 0].max():
        raise SystemExit(f"a dip in the left rail changes wheel forces by {off.max(axis=0)} N")


def check_rigid(of, deck):
    x = of["wheel/x"][:, 0]
    # The centre is midway between the seats, except for displacements before the rail was placed.
    centre = of["sleeper/displacement"].reshape(len(x), 2)
    seats = of["seat/displacement"].reshape(len(x), 2, 2)
    lower = seats.mean(axis=2) - centre
    if np.ptp(lower, axis=0).max() > 1e-8 or np.ptp(seats[..., 0] - seats[..., 1]) < 1e-6:
        raise SystemExit(f"seats: {np.ptp(lower, axis=0)} m relative to their sleepers, "
                         f"{np.ptp(seats[..., 0] - seats[..., 1])} m between both")
    # The seat forces of a row move the sleepers in the following window, with their supported load.
    # The rail is placed on moving sleepers: its first rows have an impact.
    force = -of["sleeper/seat_force"].reshape(len(x), 2) - deck["stage"][-1]["seat_force"]
    late = np.abs(of["seat/force"].reshape(len(x), 2, 2).sum(axis=2) - force)[5:].max()
    if late > 0.05 * np.ptp(force[5:]) or np.ptp(force[5:]) < 0.2 * STATIC:
        raise SystemExit(f"change of seat forces {np.ptp(force[5:])} N, {late} N of it not from "
                         "their pads")


def check_solid(of):
    """Forces and seats of a row are simultaneous; sleepers bend slightly and roll."""
    force = -of["sleeper/seat_force"]
    off = np.abs(of["seat/force"].reshape(-1, 2, 2).sum(axis=2) - force.reshape(-1, 2)).max()
    if off > 1e-9 * STATIC or np.ptp(of["seat/force"]) < 0.1 * STATIC:
        raise SystemExit(f"{off} N of the seat forces are not from their pads")
    # Seats of the deck are listed right before left; displacements count from different times, and
    # one of them integrates velocities by the trapezoidal rule.
    written = of["solid/seat_displacement"].reshape(-1, 2, 2)[..., ::-1]
    apart = np.ptp(of["seat/displacement"].reshape(-1, 2, 2) - written, axis=0).max()
    turned = np.ptp(written[..., 0] - written[..., 1])
    if apart > 1e-3 * turned or turned < 1e-6:
        raise SystemExit(f"seats of train and solids differ by {apart} m, in roll by {turned} m")


def check_figures(source, folder):
    ran = subprocess.run([sys.executable, source / "postproc", "figures", folder, "-o",
                          folder / "figures"], capture_output=True, text=True, check=False)
    if ran.returncode or "axle 1, left and right wheel, largest difference" not in ran.stdout:
        raise SystemExit(f"figures: {ran.stdout}{ran.stderr}")
    print(ran.stdout)


def main():
    program, source, folder = Program(sys.argv[1]), *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    deck = source / "tests/restart/tiny_two_rails.toml"
    check_sentences(program, deck)
    read = tomllib.loads(deck.read_text(encoding="utf-8"))
    check_runs(program, deck, folder, [], (1, 4))
    check_rigid(passage(folder / "ranks_1", len(read["stage"])), read)
    check_dip(program, deck, folder, [], -0.1)
    check_runs(program, deck, folder / "solid", [*SOLID, *BRIEF], (1, 2))
    check_solid(passage(folder / "solid/ranks_1", len(read["stage"])))
    check_dip(program, deck, folder / "solid", [*SOLID, *BRIEF], 0)
    check_figures(source, folder / "ranks_1")


if __name__ == "__main__":
    main()
