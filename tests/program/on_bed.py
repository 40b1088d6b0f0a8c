#!/usr/bin/env python3
"""The vehicle of inputs/track/on_bed.toml over stones that had less time to come to rest: forces
between rail and sleepers, the figures of the run, and the rounds of the hand-over loop.

    on_bed.py PROGRAM SOURCE_FOLDER FOLDER
"""
import csv
import pathlib
import shutil
import subprocess
import sys
import tomllib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import datasets  # noqa: E402

SHORT = ["stage.fill.duration=0.5", "stage.compact.duration=0.4", "stage.release.duration=0.05",
         "stage.sleepers.duration=0.1",
         # After one cycle, in which they settle by 3 mm, a sleeper still hangs.
         "stage.bed_in.duration=0.3", "stage.bed_in.cycles=3"]
STATIC = 54545  # N, of a wheel: a quarter of an axle load of 109.09 kN in each of two rails
GRAVITY = 9.81


def check_histories(folder, deck):
    mass = 2441 * 0.29 * 0.22 * deck["thickness"]
    found = datasets(folder)
    train = found["history/stage"].ravel() == len(deck["stage"]) - 1
    wheel, x = found["history/wheel/force"], found["history/wheel/x"]
    sleeper = {name: found[f"history/sleeper/{name}"][train]
               for name in ("acceleration", "seat_force", "reaction")}
    rail = found["history/rail/displacement"][train]
    if np.isfinite(wheel[~train]).any() or not np.isfinite(wheel[train]).all():
        raise SystemExit("wheels have forces while the train runs, and only then")
    # Before the first wheel comes near, the whole track is at rest.
    if not np.allclose(wheel[train][0], STATIC, rtol=1e-3) or abs(x[train][0, 0] + 9) > 0.05:
        raise SystemExit(f"the train starts differently: {wheel[train][0]} N, {x[train][0]} m")
    over = wheel[train][(x[train] > 0) & (x[train] < 3)]
    if over.min() < 0.5 * STATIC or over.max() > 2 * STATIC:
        raise SystemExit(f"wheels over the bed: {over.min()} to {over.max()} N")
    # The summary includes all windows, for wheels within half a spacing of the bed's sleepers.
    bed, extremes = deck["sleepers"], summary(folder)["track"]
    low, high = (bed["first"] + bed["spacing"] * i for i in (-0.5, bed["count"] - 0.5))
    seen = wheel[train][(x[train] >= low) & (x[train] <= high)]
    if extremes["wheel_force_max_n"] < seen.max() or extremes["wheel_force_min_n"] > seen.min():
        raise SystemExit(f"wheels over the bed: {extremes} in the summary")
    # Equation of motion of each sleeper in each row, with the force of the rail.
    off = sleeper["reaction"] + sleeper["seat_force"] - mass * (GRAVITY + sleeper["acceleration"])
    if np.abs(off).max() > 1e-6 * STATIC:
        raise SystemExit(f"forces on sleepers do not balance: {np.abs(off).max()} N")
    seats = -sleeper["seat_force"].min(axis=0) - 5e3
    if seats.min() < 0.15 * STATIC or seats.max() > STATIC or rail.min() > -1e-4:
        raise SystemExit(f"largest seat loads {seats} N, rail down to {rail.min()} m")


def check_resume(program, folder):
    """The track of a running train cannot be changed at a resume."""
    running = sorted(folder.glob("checkpoint_*.h5"))[-1]
    ran = program(1, "resume", running, "pad.stiffness=100e6", "-o", folder / "other")
    if ran.returncode != 2 or "pad.stiffness" not in ran.stderr or "made with" not in ran.stderr:
        raise SystemExit(f"other pads below a train must be refused: {ran.stdout}{ran.stderr}")


def check_figures(source, folder):
    ran = subprocess.run([sys.executable, source / "postproc", "figures", folder, "-o",
                          folder / "figures"], capture_output=True, text=True, check=False)
    row = "axle 4, largest downward sleeper displacement minus that of axle 1, mean of sleepers"
    if ran.returncode or row not in ran.stdout:
        raise SystemExit(f"figures: {ran.stdout}{ran.stderr}")
    ran = subprocess.run([sys.executable, source / "postproc", "figures", folder, "--kind",
                          "track", "-o", folder / "figures"], capture_output=True, text=True,
                         check=False)
    if ran.returncode != 2 or "use --kind train" not in ran.stderr:
        raise SystemExit(f"--kind track must refuse it: {ran.stdout}{ran.stderr}")


def deck_of_loop(source, folder):
    """A deck with two rounds of one train each."""
    text = (source / "inputs/track/on_bed.toml").read_text(encoding="utf-8")
    path = folder / "loop.toml"
    path.write_text(text.replace("rounds = 3 ", "rounds = 2 ").replace("trains = 2 ",
                                                                     "trains = 1 "),
                    encoding="utf-8")
    return path


def check_loop(source, program, folder):
    place = folder / "loop"
    ran = subprocess.run([sys.executable, source / "jobs/handover.py", program,
                          deck_of_loop(source, folder), place, "--start",
                          folder / "stage_bed_in.h5"], capture_output=True, text=True, check=False)
    if ran.returncode:
        raise SystemExit(f"handover.py: {ran.stdout}{ran.stderr}")
    with open(place / "handover.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    stiffness = [float(row["stiffness_N_m"]) for row in rows]
    geometry = [float(row["geometry_before_m"]) for row in rows]
    lost = [float(row["settlement_per_train_m"]) for row in rows]
    if len(rows) != 8 or min(stiffness) < 5e6 or max(stiffness) > 1e9:
        raise SystemExit(f"supports: {stiffness} N/m")
    worth = [float(row["stiffness_spread_N_m"]) for row in rows] / np.array(stiffness)
    # Slips of stones during the load test of a bed with little time to come to rest reduce the
    # accuracy of one sleeper; the loop itself ends if the result is unreliable (support.py).
    if not 0 < worth.min() or np.median(worth) > 0.03 or worth.max() > 0.5:
        raise SystemExit(f"relative errors of the supports: {worth}")
    if any(geometry[:4]) or not np.allclose(geometry[4:], -np.array(lost[:4]), atol=1e-15):
        raise SystemExit(f"the second round begins with {geometry}, the first left {lost}")
    check_geometry(program, place / "round_1", lost[:4])
    check_loop_again(source, program, folder, place)
    check_other_bed(source, program, folder)


def check_loop_again(source, program, folder, place):
    """The same command keeps existing runs and completes missing ones; another load belongs to
    another loop; a deck that is not valid is refused by the program."""
    def again(deck, *words):
        return subprocess.run([sys.executable, source / "jobs/handover.py", program, deck, place,
                               "--start", folder / "stage_bed_in.h5", *words],
                              capture_output=True, text=True, check=False)
    table = place / "handover.csv"
    kept, lost = place / "round_0/load_test/results.h5", place / "round_1/track"
    first, written = table.read_bytes(), kept.stat().st_mtime_ns
    table.unlink()
    shutil.rmtree(lost)
    ran = again(deck_of_loop(source, folder))
    if ran.returncode or table.read_bytes() != first or kept.stat().st_mtime_ns != written:
        raise SystemExit(f"handover.py again: {ran.stdout}{ran.stderr}")
    ran = again(deck_of_loop(source, folder), "--load", "20e3")
    other = "holds rounds with handover.load = 30000, not 20000"
    if ran.returncode != 2 or other not in ran.stderr:
        raise SystemExit(f"another load must be refused: {ran.stdout}{ran.stderr}")
    # EACH only changes the geometry, and so the second round.
    ran = again(deck_of_loop(source, folder), "--each", "10")
    if ran.returncode != 2 or "holds rounds with handover.each = 1, not 10" not in ran.stderr:
        raise SystemExit(f"another geometry must be refused: {ran.stdout}{ran.stderr}")
    deck = folder / "misspelt.toml"
    deck.write_text(deck_of_loop(source, folder).read_text(encoding="utf-8").replace(
        "rounds = 2", "round = 2"), encoding="utf-8")
    ran = again(deck)
    if ran.returncode != 2 or "did you mean handover.rounds?" not in ran.stderr or \
            "Traceback" in ran.stderr:
        raise SystemExit(f"a wrong deck: {ran.stdout}{ran.stderr}")


def check_other_bed(source, program, folder):
    """A state that does not fit the deck is refused before the loop writes anything."""
    deck, place = folder / "zones.toml", folder / "elsewhere"
    deck.write_text(deck_of_loop(source, folder).read_text(encoding="utf-8").replace(
        "elements_x = 30", "elements_x = 31"), encoding="utf-8")
    ran = subprocess.run([sys.executable, source / "jobs/handover.py", program, deck, place,
                          "--start", folder / "stage_bed_in.h5"], capture_output=True, text=True,
                         check=False)
    if ran.returncode != 2 or "elements_x" not in ran.stderr or place.exists():
        raise SystemExit(f"a bed on another ground: {ran.returncode}, {ran.stdout}{ran.stderr}")


def check_geometry(program, place, lost):
    """The rail of a round follows the settlement of the round before, and a single lower sleeper
    changes the wheel forces."""
    table = np.loadtxt(place / "geometry.csv", delimiter=",", skiprows=1)
    if not np.allclose(table[2:6, 1], -np.array(lost), atol=1e-15):
        raise SystemExit(f"geometry of the second round: {table}, the first left {lost}")
    table[3, 1] -= 1e-3
    np.savetxt(place / "lower.csv", table, delimiter=",", header="x_m,z_m", comments="")
    forces = []
    for name in ("geometry", "lower"):
        subprocess.run([program, "run", place / "track.toml", "--force", "-o", place / name,
                        f"irregularity.file={place / name}.csv"], check=True, capture_output=True)
        forces.append(datasets(place / name)["history/wheel/force"])
    if not np.abs(forces[1] - forces[0]).max() > 0.1 * STATIC:
        raise SystemExit("a sleeper 1 mm lower changes wheel forces by "
                         f"{np.abs(forces[1] - forces[0]).max()} N")


def main():
    program, source, folder = Program(sys.argv[1]), *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    deck = source / "inputs/track/on_bed.toml"
    program.done(2, "run", deck, *SHORT, "-o", folder)
    stated = program.done(1, "check", deck).stdout
    if "natural frequencies 1.074" not in stated or (
            f"largest static wheel load {STATIC / 1e3:.2f} kN") not in stated:
        raise SystemExit(f"vehicle and static wheel load must be stated: {stated}")
    check_histories(folder, tomllib.loads(deck.read_text(encoding="utf-8")))
    if summary(folder)["warnings"]:
        print("\n".join(summary(folder)["warnings"]))
    check_resume(program, folder)
    check_figures(source, folder)
    check_loop(source, sys.argv[1], folder)


if __name__ == "__main__":
    main()
