#!/usr/bin/env python3
"""How jobs/handover.py ends when one of its runs fails, that only one loop works in a folder at a
time, and which rounds of a folder are kept.

    loop_runs.py PROGRAM SOURCE_FOLDER FOLDER
"""
import csv
import os
import pathlib
import re
import shutil
import signal
import sys
import time
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import run_checks  # noqa: E402
from loops import Loops  # noqa: E402


def check_failures(loops, deck):
    """The script reports the program's own message and code, without messages of mpirun and traces;
    a killed rank is reported as killed."""
    place = loops.folder / "failed"
    for how, code, expected in (
            ("lost", 4, ["trackbed: a stone was lost; the last good checkpoint is checkpoint_3.h5",
                         "failed: exit code 4; see"]),
            ("input", 2, [":3: bed.height = -1 m: must be above 0 m", "failed: exit code 2; see"]),
            ("kill", 137, ["failed: rank 1 was killed (signal 9, Killed); see"])):
        lines = loops.ends(code, expected[-1], deck, place, fails=f"load_test:{how}").splitlines()
        if len(lines) != len(expected) or not all(
                one in line for one, line in zip(expected, lines)):
            raise SystemExit(f"a run that ends by {how} must print {expected}: {lines}")
        log = (place / "round_0/load_test.log").read_text(encoding="utf-8")
        if "exited on signal" not in log and ("progress of the run" not in log or
                                              expected[0] not in log):
            raise SystemExit(f"the log must contain the whole output of the run: {log}")
    lines = loops.ends(0, "round 0: support 40.0 to 40.0", deck, place, "--rounds", "1")
    if len(lines.splitlines()) != 1:
        raise SystemExit(f"one round, one line: {lines}")


def check_unreliable(loops, deck):
    """A load that is too small against the bed's own motion is reported with a remedy."""
    place = loops.folder / "unreliable"
    why = "the load of 3 N is too small compared with the motion of the bed itself"
    count, remedy = " of 4 sleepers is not reliable", "; use a larger handover.load (--load)"
    reported = loops.ends(4, why, deck, place, "--load", "3")
    if count not in reported or remedy not in reported or len(reported.splitlines()) != 1 or \
            not reported.startswith("round 0: ") or (place / "round_0/track").exists():
        raise SystemExit(f"a load that is too small must be reported in one line: {reported}")
    loops.ends(4, "the sleeper still settles while it is unloaded", deck, place, "--force",
               fails="load_test:sink")
    reported = loops.ends(0, "round 0: support 40.0 to 40.0 MN/m (+- ", deck, place, "--rounds",
                          "1", "--force")
    with open(place / "handover.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    errors = [float(row["stiffness_spread_N_m"]) / float(row["stiffness_N_m"]) for row in rows]
    if not 0 < min(errors) < max(errors) < 0.01 or \
            f"(+- {100 * max(errors):.1f} % at most)" not in reported:
        raise SystemExit(f"relative errors of supports: {errors}: {reported}")


def check_lock(loops, deck):
    """A second loop is refused while the first works, but not after the first has been killed."""
    place = loops.folder / "locked"
    with loops.begin(deck, place, "--rounds", "1", fails="load_test:wait") as first:
        end = time.monotonic() + 120
        while not (place / "round_0/load_test").is_dir():
            if first.poll() is not None or time.monotonic() > end:
                first.kill()
                raise SystemExit(f"the loop does not start: {first.communicate()}")
            time.sleep(0.05)
        children = pathlib.Path(f"/proc/{first.pid}/task/{first.pid}/children").read_text(
            encoding="utf-8").split()
        try:
            for words in ([], ["--force"]):
                loops.ends(2, f"another loop (process {first.pid}) is running here", deck, place,
                           *words)
            if not (place / "bed/results.h5").is_file():
                raise SystemExit("a loop that is refused must remove nothing")
        finally:
            first.kill()
            for child in children:
                os.kill(int(child), signal.SIGTERM)
    if (place / "handover.lock").read_text(encoding="utf-8") != f"{first.pid}\n":
        raise SystemExit("the lock must name the loop that was killed")
    loops.ends(0, "round 0", deck, place, "--rounds", "1")


def contents(folder):
    """Contents of all files that a loop keeps."""
    return {path: path.read_bytes() for path in folder.rglob("*")
            if path.is_file() and path.name not in ("handover.lock", "handover.png")}


def check_rounds(loops, deck):
    """Fewer rounds keep the others in the table; a refusal changes nothing in the folder."""
    place = loops.folder / "rounds"
    loops.ends(0, "round 2", deck, place)
    first = contents(place)
    for name in ("handover.csv", "round_0/geometry.csv"):
        if re.search(r"-0\.0\b", (place / name).read_text(encoding="utf-8")):
            raise SystemExit(f"{name}: the height of a rail without settlement must be 0.0")
    loops.ends(0, "keeps round 1 and later", deck, place, "--rounds", "1")
    for name, used, other in (("each", 1, 10), ("load", 30000, 20000), ("trains", 2, 3)):
        refusal = f"holds rounds with handover.{name} = {used}, not {other}: choose another folder"
        reported = loops.ends(2, refusal, deck, place, f"--{name}", str(other))
        if len(reported.splitlines()) != 1:
            raise SystemExit(f"another `{name}` must be refused at once: {reported}")
    stiffer = loops.folder / "stiffer.toml"
    stiffer.write_text(deck.read_text(encoding="utf-8").replace("young = 500e6", "young = 600e6"),
                       encoding="utf-8")
    loops.ends(2, "rounds/bed holds a run of another deck", stiffer, place)
    if changed := {path for path, _ in contents(place).items() ^ first.items()}:
        raise SystemExit(f"what the folder held has changed: {changed}")
    (place / "handover.csv").unlink()
    loops.ends(0, "round 1", deck, place, "--rounds", "2")
    if len((place / "handover.csv").read_text(encoding="utf-8").splitlines()) != 9:
        raise SystemExit("a new table must have the rounds of the command")
    loops.ends(0, "round 2", deck, place)
    if contents(place) != first:
        raise SystemExit("the table must grow to what it was")
    # Rounds of another loop are not kept as later rounds of this one.
    table = place / "handover.csv"
    text = table.read_text(encoding="utf-8")
    table.write_text(text.replace("\n0,0.6,", "\n0,0.7,"), encoding="utf-8")
    loops.ends(0, "contained further rounds of another loop", deck, place, "--rounds", "1")
    if text.splitlines()[:5] != table.read_text(encoding="utf-8").splitlines():
        raise SystemExit("the table must have the one round")


def check_start(loops, deck):
    """The loop starts from the file of an earlier run, or its folder, without running the bed. A
    link to the loop's folder, at another depth, is the same loop."""
    links = loops.folder / "links/of/folders"
    links.mkdir(parents=True)
    earlier = loops.folder / "earlier/bed"
    loops.ends(0, "round 0", deck, loops.folder / "earlier", "--rounds", "1")
    for name, start in (("file", earlier / "stage_bed_in.h5"), ("folder", earlier)):
        place = loops.folder / f"start_{name}"
        loops.ends(0, "round 0", deck, place, "--rounds", "1", "--start", start)
        deck_of_round = (place / "round_0/load_test.toml").read_text(encoding="utf-8")
        taken = place / "round_0" / tomllib.loads(deck_of_round)["start"]
        if (place / "bed").exists() or taken.resolve() != earlier / "stage_bed_in.h5":
            raise SystemExit(f"--start {start} must be what the rounds begin with, not {taken}")
        (links / name).symlink_to(place)
        first = contents(place)
        loops.ends(0, "round 0", deck, links / name, "--rounds", "1", "--start", start)
        if contents(place) != first:
            raise SystemExit("a loop reached by a link must not start again")
    loops.ends(2, "stage_bed_in.h5 does not exist", deck, loops.folder / "none", "--start",
               loops.folder)


def main():
    program, source, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    loops, deck = Loops(program, source, folder), source / "inputs/track/on_bed.toml"
    run_checks((check_failures, check_unreliable, check_lock, check_rounds, check_start), loops,
               deck)


if __name__ == "__main__":
    main()
