#!/usr/bin/env python3
"""Substitute for the program in tests of jobs/handover.py, which test the loop and not stones:

    quick_loop.py check DECK | describe | run DECK -o FOLDER

`run` writes results of the correct form that depend on the deck only; rank 0 does. The environment
variable FAILS is FOLDER:HOW: the run whose result folder has this name ends with a killed rank
(kill), a lost stone (lost) or a wrong input (input), or does not end (wait); with `sink`, sleepers
settle further while their load decreases. REAL is the program that checks and describes; it would
refuse the checkpoints written here, so decks that start from one pass the check.
"""
import json
import os
import pathlib
import signal
import sys
import time
import tomllib

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
    import numpy as np  # here: a check and the other ranks do without, in a third of the time
    time_s = np.linspace(0, 0.3, ROWS)
    stage = deck.get("stage", [{}])[-1]
    push = stage.get("load", 30e3) / 2 * (1 - np.cos(2 * np.pi * time_s / 0.3))
    loss = 1e-5 * (1 + np.arange(SLEEPERS)) * time_s[:, None] / 0.3
    down = -push[:, None] / STIFFNESS - loss * ("load" in deck)
    if stage.get("name", "").startswith("load_test"):  # stones that have not come to rest
        down += 1e-6 * np.random.default_rng(1).standard_normal(down.shape)
        if os.environ.get("FAILS") == "load_test:sink":
            down -= 2 * time_s[:, None] * 30e3 / STIFFNESS / 0.1
    sign = 1 if deck.get("model") == "track" else -1  # sign of the force on a seat
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
    import h5py
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
