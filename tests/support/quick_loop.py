#!/usr/bin/env python3
"""Stands for the program in tests of jobs/handover.py that look at the loop, not at stones:

    quick_loop.py check DECK | describe | run DECK -o FOLDER

`run` writes results of the right shape that hang on nothing but the deck; rank 0 does. What the
environment variable FAILS names (a folder's name, as weigh) ends as its other half says:
FAILS=weigh:kill, weigh:lost, weigh:input, weigh:wait; with weigh:sink sleepers sink on while their
load goes. REAL is the program that checks and describes; what is written here as a checkpoint it
would not take for one, so decks that start from one pass.
"""
import json
import os
import pathlib
import signal
import sys
import time
import tomllib

import h5py
import numpy as np

RANK = int(os.environ.get("OMPI_COMM_WORLD_RANK", "0"))
SLEEPERS = 4
ROWS = 601
STIFFNESS = 40e6  # N/m


def fail(how, deck):
    if how == "wait":
        time.sleep(600)
    if how == "kill" and RANK == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    if how == "kill":
        time.sleep(600)
    if RANK == 0:
        print("progress of the run", flush=True)
        print("[0]PETSC ERROR: a trace", file=sys.stderr)
        print("trackbed: a stone was lost; the last good checkpoint is checkpoint_3.h5"
              if how == "lost" else f"{deck}:3: bed.height = -1 m: must be above 0 m",
              file=sys.stderr)
    sys.exit(4 if how == "lost" else 2)


def histories(deck):
    """Time, stage, displacement and seat force of each sleeper; wheels."""
    time_s = np.linspace(0, 0.3, ROWS)
    stage = deck.get("stage", [{}])[-1]
    push = stage.get("load", 30e3) / 2 * (1 - np.cos(2 * np.pi * time_s / 0.3))
    loss = 1e-5 * (1 + np.arange(SLEEPERS)) * time_s[:, None] / 0.3
    down = -push[:, None] / STIFFNESS - loss * ("load" in deck)
    if stage.get("name", "").startswith("weigh"):  # stones that have not come to rest
        down += 1e-6 * np.random.default_rng(1).standard_normal(down.shape)
        if os.environ.get("FAILS") == "weigh:sink":
            down -= 2 * time_s[:, None] * 30e3 / STIFFNESS / 0.1
    sign = 1 if deck.get("model") == "track" else -1  # which way the force on a seat counts
    return {"time": time_s, "stage": np.full(ROWS, len(deck.get("stage", [])) - 1),
            "sleeper/displacement": down,
            "sleeper/seat_force": sign * np.outer(push, np.ones(SLEEPERS)),
            "wheel/force": np.full((ROWS, 4), 55e3)}


def run(path, folder):
    deck = tomllib.loads(path.read_text(encoding="utf-8"))
    name, _, how = os.environ.get("FAILS", "").partition(":")
    if name == folder.name and how != "sink":
        folder.mkdir(parents=True, exist_ok=True)
        fail(how, path)
    if RANK:
        return
    folder.mkdir(parents=True, exist_ok=True)
    with h5py.File(folder / "results.h5", "w") as file:
        for key, values in histories(deck).items():
            file[f"history/{key}"] = values
    for stage in deck.get("stage", [])[-1:]:
        (folder / f"stage_{stage['name']}.h5").write_text(stage["name"], encoding="utf-8")
    (folder / "summary.json").write_text(json.dumps({"finished": True}), encoding="utf-8")


def main():
    if sys.argv[1] == "check" and "start" in tomllib.loads(
            pathlib.Path(sys.argv[2]).read_text(encoding="utf-8")):
        return
    if sys.argv[1] != "run":
        os.execv(os.environ["REAL"], [os.environ["REAL"], *sys.argv[1:]])
    run(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[sys.argv.index("-o") + 1]))


if __name__ == "__main__":
    main()
