#!/usr/bin/env python3
"""A sweep with the program: it finishes, does nothing twice, and goes on after an interruption.

    sweep.py PROGRAM SOURCE_FOLDER FOLDER
"""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import program  # noqa: E402, F401  # sets the environment of programs of one rank


def main():
    path, source, folder = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    words = [sys.executable, source / "postproc", "sweep", source / "inputs/track/plain.toml",
             "--vary", "irregularity.seed", "1", "2", "--vary", "train.speed", "50", "80",
             "--quantity", "envelope/rail/displacement_min", "--program", path, "-o", folder]
    # Interrupted when the second run has begun.
    started = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=os.environ)
    for line in started.stdout:
        if line.startswith("2 of 4"):
            time.sleep(0.3)
            started.send_signal(signal.SIGINT)
            break
    rest, _ = started.communicate(timeout=60)
    # The third run may have begun before the signal: a run takes about 0.3 s.
    if started.returncode != 3 or "4 of 4" in rest:
        raise SystemExit(f"the interrupted sweep ended with {started.returncode}: {rest}")
    ran = subprocess.run(words, capture_output=True, text=True, check=False, env=os.environ)
    print(ran.stdout, ran.stderr)
    if ran.returncode or "train.speed = 80: 2 runs" not in ran.stdout or \
            "1 of 4: " not in ran.stdout or "already finished, skipped" not in ran.stdout:
        raise SystemExit("the sweep did not finish")
    rows = (folder / "sweep.csv").read_text(encoding="utf-8").splitlines()
    if len(rows) != 5 or not rows[0].startswith('"irregularity.seed","train.speed","largest'):
        raise SystemExit(f"sweep.csv: {rows[:2]}")
    if not (folder / "sweep.png").is_file():
        raise SystemExit("sweep.png is missing")
    again = subprocess.run([*words, "--vary", "pad.stiffness", "0"], capture_output=True, text=True,
                           check=False, env=os.environ)
    if again.returncode != 2 or "must be" not in again.stderr:
        raise SystemExit(f"an invalid value must be refused: {again.stdout}{again.stderr}")


if __name__ == "__main__":
    main()
