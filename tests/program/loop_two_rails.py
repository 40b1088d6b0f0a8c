#!/usr/bin/env python3
"""jobs/handover.py on two rails, with the real program on the tiny deck: an eccentric load of the
vehicle loads the left seats more, loads on left seats roll sleepers to the left, the settlement of
each seat is the geometry of its rail in the next round, and results do not depend on the ranks.

    loop_two_rails.py PROGRAM SOURCE_FOLDER FOLDER
"""
import csv
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program  # noqa: E402
from results import checkpoint, histories  # noqa: E402

EACH = 5
HANDOVER = f"""
[handover]
after = "load"
rounds = 2
trains = 1
each = {EACH}
load = 2e3
"""
SIDES = ("left", "right")


def deck_of(source):
    text = (source / "tests/restart/tiny_two_rails.toml").read_text(encoding="utf-8")
    text = re.sub(r"\[irregularity(_right)?\][^[]*", "", text)
    text = text.replace('kind = "sprung"\n', 'kind = "sprung"\nbody_offset = 0.03\n')
    # Balls that neither slide nor roll, bedded in with more than the load of the test: with those
    # of the deck two beds of four were so loose that sleepers kept settling and the loop ended.
    text = text.replace("friction = 0.6\n", "friction = 5\nrolling_friction = 1\n")
    text = text.replace("duration = 0.12\nload = 2e3\n", "duration = 1.0\nload = 30e3\n")
    return text.replace("\n[output]", HANDOVER + "\n[output]")


def loop(words, ranks, code=0):
    ran = subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True,
                         check=False, env={**os.environ, "RANKS": str(ranks)})
    if ran.returncode != code:
        raise SystemExit(f"{words} ends with {ran.returncode}: {ran.stdout}{ran.stderr}")
    return ran.stderr if code else ran.stdout


def table(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def column(rows, number, name):
    """Values of a round, [sleeper, side]."""
    of = [[float(row[name]) for row in rows if row["round"] == str(number) and row["side"] == side]
          for side in SIDES]
    return np.array(of).T


def check_geometry(folder, deck, rows):
    """The settlement of each seat, times each, is the height of its rail in the next round."""
    lost = column(rows, 0, "settlement_per_train_m")
    if lost.shape != (2, 2) or not np.abs(lost).min() > 0 or np.ptp(lost[:, 0] - lost[:, 1]) == 0:
        raise SystemExit(f"settlements of two seats on two sleepers: {lost}")
    if not np.allclose(column(rows, 1, "geometry_before_m"), -EACH * lost, rtol=1e-12):
        raise SystemExit("the geometry differs from the settlement of the seats")
    at = deck["sleepers"]["spacing"] * (deck["seat"]["before"] + np.arange(2))
    track = tomllib.loads((folder / "round_1/track.toml").read_text(encoding="utf-8"))
    for k, section in enumerate(("irregularity", "irregularity_right")):
        file = folder / "round_1" / track[section]["file"]
        heights = {float(row["x_m"]): float(row["z_m"]) for row in table(file)}
        if file.name != f"geometry_{SIDES[k]}.csv" or not np.allclose(
                [heights[x] for x in at], -EACH * lost[:, k], rtol=1e-12):
            raise SystemExit(f"[{section}] is {file}: {heights}")


def rolls_of(folder, stage=""):
    """Rotation of each sleeper about the track, rad, in a checkpoint."""
    return 2 * checkpoint(folder, stage)["sleepers/attitude"].reshape(-1, 4)[:, 0]


def check_forces(folder, deck, rows):
    """The seat forces of the track, and their sum and moment on the bed."""
    seats = table(folder / "round_0/seats.csv")
    names = [f"sleeper_{i}_{side}" for i in range(2) for side in SIDES]
    if list(seats[0]) != ["time_s", *names]:
        raise SystemExit(f"columns of the seats: {list(seats[0])}")
    force = np.array([[float(row[name]) for name in names] for row in seats]).reshape(-1, 2, 2)
    most = column(rows, 0, "largest_seat_force_N")
    if not np.allclose(most, force.max(axis=0)) or not (most[:, 0] > 1.2 * most[:, 1]).all():
        raise SystemExit(f"the load is left of the middle, largest seat forces {most} N")
    on_bed = -histories(folder / "round_0/trains")["sleeper/seat_force"]
    most = on_bed.max(axis=0) - deck["stage"][-1]["seat_force"]
    if not np.allclose(most, force.sum(axis=2).max(axis=0), rtol=0.02):
        raise SystemExit(f"largest forces on sleepers {most} N, sums of seat forces "
                         f"{force.sum(axis=2).max(axis=0)}")
    # The roll of the sleepers by the moment equals the difference of settlement of their seats.
    before, after = (rolls_of(folder / "round_0" / run, f"{run}_0")
                     for run in ("load_test", "trains"))
    roll = after - before
    lost = column(rows, 0, "settlement_per_train_m")
    if not np.allclose(lost[:, 1] - lost[:, 0], deck["track"]["gauge"] * roll, rtol=1e-3):
        raise SystemExit(f"roll of sleepers {roll} rad, settlement of seats {lost} m")


def check_sides(program, folder):
    """The left seats of a table are those whose settlement the loop calls left. Under one train
    loose stones settle as chance has it, on either side. Of two loads on one state, 3.7 ms on the
    left or on the right, the left one rolls every sleeper further to the left on any bed: the time
    is so short that inertia decides: free sleepers would roll 3.3e-3 rad apart."""
    rolls = []
    for side in SIDES:
        forces = [f"{2000 * (other == side)}" for _ in range(2) for other in SIDES]
        header = [f"sleeper_{i}_{other}" for i in range(2) for other in SIDES]
        place = folder / f"only_{side}"
        place.with_suffix(".csv").write_text(
            "\n".join(",".join(row) for row in (["time_s", *header], ["0", *forces],
                                                ["1", *forces])), encoding="utf-8")
        Program(program).done(1, "run", folder / "trains.toml", "output.stop_after=100",
                              f"load.file={place}.csv", "-o", place, code=3)
        rolls.append(rolls_of(place))
    # Positive: the left seat higher (seat_heights of the script).
    if not (rolls[0] < rolls[1]).all():
        raise SystemExit(f"loads on the left seats roll sleepers by {rolls[0] - rolls[1]}")


def check_sentences(program, source, folder):
    """Messages on load.gauge where a table of two seats per sleeper is impossible."""
    bed, table_of = folder / "trains.toml", f"load.kind=seats load.file={folder / 'seats.csv'}"
    tiny, seats = source / "tests/restart/tiny_two_rails.toml", source / "inputs/track/seats.toml"
    for code, words, deck, changes in (
            (2, "must be 0 in a plane model", bed, "dimension=plane"),
            (2, "must be 0 on solid sleepers", bed, "sleepers.model=solid"),
            (2, "must be below the length of the bed's sleepers", bed, "load.gauge=0.6"),
            (0, "has no effect: sleepers do not roll", bed, 'sleepers.free=["z"]'),
            (2, "needs kind = \"seats\", whose table has columns of both", bed, "load.kind=table"),
            (2, "must be 0 in a deck with a train", tiny, f"load.gauge=0.3 {table_of}"),
            (2, "must be 0 except on a bed", seats, f"load.gauge=0.3 {table_of}")):
        ran = subprocess.run([program, "check", deck, *changes.split(" ")], capture_output=True,
                             text=True, check=False)
        reported = ran.stdout + ran.stderr
        if ran.returncode != code or \
                not re.search(rf"load\.gauge = .*{re.escape(words)}", reported):
            raise SystemExit(f"{changes} must end with {code} and print {words}: {reported}")


def main():
    program, source, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    path = folder / "deck.toml"
    path.write_text(deck_of(source), encoding="utf-8")
    deck = tomllib.loads(path.read_text(encoding="utf-8"))
    words = [source / "jobs/handover.py", program, path]
    print(loop([*words, folder / "loop"], 2))
    rows = table(folder / "loop/handover.csv")
    check_geometry(folder / "loop", deck, rows)
    check_forces(folder / "loop", deck, rows)
    check_sides(program, folder / "loop/round_0")
    check_sentences(program, source, folder / "loop/round_0")
    # All results exist: nothing is run again, and another `each` is refused.
    before = (folder / "loop/round_1/trains/results.h5").stat().st_mtime_ns
    loop([*words, folder / "loop"], 2)
    if (folder / "loop/round_1/trains/results.h5").stat().st_mtime_ns != before:
        raise SystemExit("a finished loop must not start again")
    held = f"holds rounds with handover.each = {EACH}"
    if held not in loop([*words, folder / "loop", "--each", "7"], 2, code=2):
        raise SystemExit("another `each` must be refused")
    loop([*words, folder / "alone", "--rounds", "1"], 1)
    if table(folder / "alone/handover.csv") != rows[:4]:
        raise SystemExit("the results depend on the number of ranks")


if __name__ == "__main__":
    main()
