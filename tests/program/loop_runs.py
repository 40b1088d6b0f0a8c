#!/usr/bin/env python3
"""How jobs/handover.py ends when a run of its fails, and that one loop works in a folder at a
time.

    loop_runs.py PROGRAM SOURCE_FOLDER FOLDER
"""
import os
import pathlib
import shutil
import signal
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from loops import Loops  # noqa: E402


def check_failures(loops, deck):
    """The program's own sentence and code, nothing of mpirun's and of traces; a rank that was
    killed is called so."""
    place = loops.folder / "failed"
    for how, code, said in (
            ("lost", 4, ["trackbed: a stone was lost; the last good checkpoint is checkpoint_3.h5",
                         "failed: code 4; see"]),
            ("input", 2, [":3: bed.height = -1 m: must be above 0 m", "failed: code 2; see"]),
            ("kill", 137, ["failed: rank 1 was killed (signal 9, Killed); see"])):
        lines = loops.ends(code, said[-1], deck, place, fails=f"weigh:{how}").splitlines()
        if len(lines) != len(said) or not all(one in line for one, line in zip(said, lines)):
            raise SystemExit(f"a run that ends by {how} must say {said}: {lines}")
        log = (place / "round_0/weigh.log").read_text(encoding="utf-8")
        if "exited on signal" not in log and ("progress of the run" not in log or
                                              said[0] not in log):
            raise SystemExit(f"the log must have all that the run said: {log}")
    lines = loops.ends(0, "round 0: support 40.0 to 40.0", deck, place, "--rounds", "1")
    if len(lines.splitlines()) != 1:
        raise SystemExit(f"one round, one line: {lines}")


def check_lock(loops, deck):
    """A second loop is refused while the first works, and not once that one is gone, however."""
    place = loops.folder / "locked"
    with loops.begin(deck, place, "--rounds", "1", fails="weigh:wait") as first:
        end = time.monotonic() + 120
        while not (place / "round_0/weigh").is_dir():
            if first.poll() is not None or time.monotonic() > end:
                first.kill()
                raise SystemExit(f"the loop does not begin: {first.communicate()}")
            time.sleep(0.05)
        children = pathlib.Path(f"/proc/{first.pid}/task/{first.pid}/children").read_text(
            encoding="utf-8").split()
        try:
            for words in ([], ["--force"]):
                loops.ends(2, f"another loop (process {first.pid}) works in it", deck, place,
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


def main():
    program, source, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    loops, deck = Loops(program, source, folder), source / "inputs/track/on_bed.toml"
    check_failures(loops, deck)
    check_lock(loops, deck)


if __name__ == "__main__":
    main()
