#!/usr/bin/env python3
"""Errors while a run computes: a stone that leaves the domain, one that overlaps too far, and a
coordinate that becomes not a number. All ranks end together, the message names stone, time and
stage, and the state is written, whatever else happened.

    post_mortem.py PROGRAM SOURCE FOLDER [--ranks N ...]

The last case writes NaN into the memory of the running program, over the coordinate of one stone.
"""
import argparse
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import time

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from kills import ranks_of  # noqa: E402
from program import Program, expect  # noqa: E402

PATIENCE = 60  # s
LARGEST_MAPPING = 1 << 30  # bytes; the address sanitizer reserves terabytes that hold no stone
X = 0.2718281828459045  # m, of the stone that is hit; besides only the deck has this number
OLD, NEW = struct.pack("<d", X), struct.pack("<d", float("nan"))
# Two stones at rest on a plate, one on each side of x = 0, for ever.
RESTING = f"""
title = "Two stones at rest"
model = "stones"
dimension = "space"
material = [{{name = "rock", density = 2600}}]
contact = [{{first = "rock", second = "rock", k_n = 1e6, k_s = 8e5, zeta_n = 0.2}}]
stone = [{{name = "left", radius = 0.01, material = "rock", position = [-0.3, 0, 0.0099]}},
         {{name = "right", radius = 0.01, material = "rock", position = [{X}, 0, 0.0099]}}]
plate = [{{name = "floor", material = "rock", size = [1, 1]}}]
output = {{history_interval = 0.1, checkpoint_interval = 0, checkpoint_wall_interval = 0}}
stage = [{{name = "rest", kind = "run", duration = 1e5}}]
"""


def stones_of(folder, stage):
    """Number of the stone and place of each point in the state that was written. Each rank wrote a
    part, in which points and cells begin at 0."""
    found = list(pathlib.Path(folder, "fields").glob(f"failed_{stage}_*_stones.hdf"))
    if len(found) != 1:
        raise SystemExit(f"{folder}: one state must have been written, not {found}")
    with h5py.File(found[0]) as file:
        grid = {name: file["VTKHDF"][name][()] for name in
                ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds", "Offsets",
                 "Connectivity", "Points", "CellData/stone")}
    begins = [np.cumsum([0, *grid[f"NumberOf{what}"]]) for what in
              ("Points", "Cells", "ConnectivityIds")]
    numbers, places = [], []
    for part, cells in enumerate(grid["NumberOfCells"]):
        points, first_cell, ids = (begin[part] for begin in begins)
        offsets = grid["Offsets"][first_cell + part:][:cells + 1]
        nodes = grid["Connectivity"][ids:ids + offsets[-1]]
        numbers.append(np.repeat(grid["CellData/stone"][first_cell:][:cells], np.diff(offsets)))
        places.append(grid["Points"][points + nodes])
    return np.concatenate(numbers).astype(int), np.concatenate(places)


def check_message(ran, folder, stage, words):
    expect(ran.returncode == 4, "the exit code must be 4", ran)
    lines = [line for line in ran.stderr.splitlines() if line.startswith("trackbed: rank")]
    expect(len(lines) == 1 and re.search(words, lines[0]), f"one message must have {words}", ran)
    expect(re.search(rf'\(at [\d.e-]+ s, stage "{stage}"\)', lines[0]), "where and when", ran)
    expect(f"{folder}/fields/failed_{stage}_" in lines[0], "where its state is", ran)
    return lines[0]


def place_in(message):
    number = r"(-?[\d.]+(?:e[-+]?\d+)?)"
    return np.array([float(x) for x in
                     re.search(rf"\({number}, {number}, {number}\) m", message).groups()])


def check_lost(program, source, folder, ranks):
    ran = program(ranks, "run", source / "inputs/verify/impact.toml", "--force", "-o", folder,
                  "domain.low=[-0.1, -0.1, -0.1]", "domain.high=[0.1, 0.1, 4e-3]",
                  "stage.impact.duration=0.02")
    message = check_message(ran, folder, "impact", 'stone "ball" left the domain at')
    _, place = stones_of(folder, "impact")
    # Rounded to 6 digits in the message, and to single precision in the file.
    expect(np.allclose(place, [place_in(message)], rtol=2e-6, atol=1e-8), f"{place}", ran)


def check_overlap(program, source, folder, ranks):
    """The message names a stone of pebbles and the place of one of them."""
    ran = program(ranks, "run", source / "tests/restart/tiny.toml", "dem.gravity=1e4", "--force",
                  "-o", folder)
    message = check_message(ran, folder, "fill", r"particle \d+ at .* overlaps the surface")
    number, places = stones_of(folder, "fill")
    own = places[number == int(re.search(r"particle (\d+)", message)[1])]
    # Later by a part of the window, in which stones move by some millimetres.
    away = np.linalg.norm(own - place_in(message), axis=1).min()
    expect(len(set(number)) == 47 and away < 0.02, f"{len(own)} pebbles, nearest at {away} m", ran)


def overwrite(pid):
    """Replaces X by NaN in the writable memory of a process, which is stopped meanwhile. Returns
    the number of places."""
    count = 0
    try:
        os.kill(pid, signal.SIGSTOP)
    except ProcessLookupError:
        return 0  # it has ended
    try:
        with open(f"/proc/{pid}/mem", "r+b", buffering=0) as memory:
            for line in pathlib.Path(f"/proc/{pid}/maps").read_text().splitlines():
                span, rights, *_ = line.split()
                if not rights.startswith("rw") or "/dev/" in line or "[v" in line:
                    continue
                begin, end = (int(number, 16) for number in span.split("-"))
                if end - begin > LARGEST_MAPPING:
                    continue
                try:
                    memory.seek(begin)
                    data = memory.read(end - begin)
                except OSError:
                    continue  # not memory
                for match in re.finditer(re.escape(OLD), data):
                    memory.seek(begin + match.start())
                    memory.write(NEW)
                    count += 1
    except OSError:
        pass  # it has ended
    finally:
        try:
            os.kill(pid, signal.SIGCONT)
        except ProcessLookupError:
            pass
    return count


def check_not_a_number(program, folder, ranks):
    shutil.rmtree(folder, ignore_errors=True)  # of an earlier test
    deck = folder.with_suffix(".toml")
    deck.write_text(RESTING, encoding="utf-8")
    command = program.command(ranks, "run", deck, "--force", "-o", folder)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as run:
        end = time.monotonic() + PATIENCE
        progress = folder / "progress.jsonl"
        while not (progress.exists() and '"stage"' in progress.read_text(encoding="utf-8")):
            if time.monotonic() > end:
                run.kill()
                raise SystemExit("the run does not begin")
            time.sleep(0.05)
        pids = ranks_of(run, os.path.abspath(program.path))
        hits = 0
        # A coordinate that is in a register at that moment is restored: then once more.
        while run.poll() is None and time.monotonic() < end:
            hits += sum(overwrite(pid) for pid in pids)
            time.sleep(0.3)
        if run.poll() is None:
            run.kill()
        out, err = run.communicate()
    ran = subprocess.CompletedProcess(command, run.returncode, out, err)
    expect(len(pids) == ranks and hits > 0, f"{hits} coordinates overwritten", ran)
    check_message(ran, folder, "rest", 'attitude of stone "right" is not a number')
    number, place = stones_of(folder, "rest")
    expect(np.isnan(place[number == 1, 0]).all() and np.isfinite(place[number == 0]).all(),
           f"{number} {place}", ran)
    expect(abs(place[number == 0][0][0] + 0.3) < 1e-6, f"{place}", ran)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    program = Program(given.program)
    for ranks in given.ranks:
        check_lost(program, given.source, given.folder / f"lost_{ranks}", ranks)
        check_overlap(program, given.source, given.folder / f"overlap_{ranks}", ranks)
        check_not_a_number(program, given.folder / f"nan_{ranks}", ranks)
        print(f"{ranks} ranks: lost stone, overlap and NaN are reported, with the state")


if __name__ == "__main__":
    main()
