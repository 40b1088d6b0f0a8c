#!/usr/bin/env python3
"""A run whose stones break is killed about the time when they do, again and again, and resumed: the
results are bitwise those of an undisturbed run.

    kills.py PROGRAM DECK FOLDER [OVERRIDE ...]
"""
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from restart import compare  # noqa: E402
from results import datasets  # noqa: E402

KILLS = 5  # of each event
DELAYS = 0.2  # s, up to which a run goes on: about ten windows with their checkpoints


def events(reference):
    """Windows in which something breaks: early, in the middle and late."""
    found = datasets(reference)
    last = max((path for path in found if path.startswith("breaks/") or path.endswith("/broken")),
               key=lambda path: len(found[path]))
    times, window, begin = np.sort(found[last][:, 0]), 0, 0.0
    windows = []
    for stage in summary(reference)["stages"]:
        of_stage = times[(times > begin) & (times <= begin + stage["duration_s"])] - begin
        windows += list(window + np.ceil(of_stage / stage["window_s"]).astype(int))
        window += round(stage["duration_s"] / stage["window_s"])
        begin += stage["duration_s"]
    if len(windows) < 5:
        raise SystemExit(f"hardly anything breaks: {windows}")
    windows = sorted(set(windows))
    return [int(windows[k * (len(windows) - 1) // 4]) for k in (1, 2, 3)]


def processes(folder):
    """Those whose arguments contain the folder."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode()
        except OSError:
            continue  # has ended in the meantime
        if str(folder) in words:
            found.append(int(process.name))
    return found


def window_of(folder):
    """That of the last checkpoint."""
    return int((folder / "latest").read_text(encoding="utf-8").split(".")[0].split("_")[1])


def killed(program, ranks, folder, window, delay):
    """Resumes the run, waits for a checkpoint of this window or a later one, and kills all ranks
    after this many seconds. Returns the window of the last checkpoint."""
    each_window = "output.checkpoint_interval=1e-9"
    with subprocess.Popen(program.command(ranks, "resume", folder, each_window),
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                          start_new_session=True) as running:
        end = time.monotonic() + 60
        while window_of(folder) < window and running.poll() is None and time.monotonic() < end:
            time.sleep(1e-3)
        time.sleep(delay)
        if running.poll() is not None or time.monotonic() > end:
            raise SystemExit(f"the run in {folder} could not be killed: code {running.returncode}")
        for number in processes(folder):
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                pass
        running.wait(timeout=60)
    return window_of(folder)


def main():
    program, deck, root = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    overrides, draw = sys.argv[4:], random.Random(1)
    shutil.rmtree(root, ignore_errors=True)
    reference = root / "reference"
    program.done(1, "run", deck, *overrides, "-o", reference)
    early = late = 0
    for event in events(reference):
        before, after = root / f"before_{event}", root / f"after_{event}"
        for window, folder in ((event - 4, before), (event + 40, after)):
            program.done(2, "run", deck, *overrides, f"output.stop_after={window}", "-o", folder,
                         code=3)
        wanted = summary(after)["dem"]["state_hash"]
        for k in range(KILLS):
            folder = root / f"killed_{event}_{k}"
            shutil.copytree(before, folder)
            last = killed(program, 2 - k % 2, folder, event - 3, DELAYS * draw.random())
            early, late = early + (last < event), late + (last >= event)
            if k == 0:
                program.done(1, "resume", folder, "output.checkpoint_interval=0.05")
                compare(reference, folder, f"killed at window {last}, event at {event}")
                continue
            program.done(1 + k % 2, "resume", folder, "output.checkpoint_interval=0.05",
                         f"output.stop_after={event + 40}", code=3)
            if summary(folder)["dem"]["state_hash"] != wanted:
                raise SystemExit(f"killed at window {last}, event at {event}: another state")
    print(f"{early} kills before the event was stored, {late} after it")
    if not early or not late:
        raise SystemExit("all kills were on one side of the events")


if __name__ == "__main__":
    main()
