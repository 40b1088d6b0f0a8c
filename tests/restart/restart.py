#!/usr/bin/env python3
"""A run that is stopped and resumed is bitwise identical to an uninterrupted one.

    restart.py PROGRAM DECK FOLDER [--from STAGE] [key=value ...]

The deck runs through once; then it is stopped after several numbers of time windows, in different
stages from STAGE on, and resumed on another number of ranks. Stages before STAGE are covered by
another test. The state hash of the stones, histories, envelopes and snapshots must be bitwise
identical. A run started from the end of a stage, and a run with another output interval, must also
give the same stones.
"""
import pathlib
import shutil
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, summary  # noqa: E402
from results import datasets, same_datasets  # noqa: E402
from trackbed_post import read  # noqa: E402

RANKS_OF_STOPPED, RANKS_OF_RESUMED = 2, (3, 1)  # in turn


def canonical(name, values):
    """Rows of stones and contacts, whose order depends on the ranks, sorted."""
    if name.startswith(("chains/", "stones/", "breaks/", "bonds/")) and len(values):
        rows = values.reshape(len(values), -1)
        return rows[numpy.lexsort(rows.T)]
    return values


def compare(reference, other, what):
    first, second = ({name: canonical(name, values) for name, values in datasets(place).items()}
                     for place in (reference, other))
    same_datasets(first, second, what, nan=True)  # of cells of the surface without stones
    hashes = [summary(folder)["dem"]["state_hash"] for folder in (reference, other)]
    if hashes[0] != hashes[1]:
        raise SystemExit(f"{what}: state hash {hashes[1]} instead of {hashes[0]}")
    for part, means in (("track", "forces of wheels"), ("breakage", "breakage"),
                        ("bonds", "bonds")):
        found = [summary(folder).get(part) for folder in (reference, other)]
        if found[0] != found[1]:
            raise SystemExit(f"{what}: {means} {found}")
    records = [stage_records(folder) for folder in (reference, other)]
    if records[0] != records[1]:
        raise SystemExit(f"{what}: stages ended differently: {records}")
    print(f"{what}: bitwise identical")


def stage_records(folder):
    """How each stage ended, without its wall time."""
    return [{key: value for key, value in stage.items() if key != "wall_time_s"}
            for stage in summary(folder)["stages"]]


def require_time_of_all_parts(folder, first):
    """The wall time of a resumed run contains that of the first part, up to its checkpoint."""
    second, both = (summary(folder)[f"wall_time{of}_s"] for of in ("", "_of_all_parts"))
    if not second + 0.3 * first <= both <= second + first:
        raise SystemExit(f"wall time {both} s of parts of {first} and {second} s")


def require_ends_by_target(folder):
    """Every stage with a target must end by reaching it before its duration: only then do the stops
    within it test that the state of the criterion is restored."""
    longest = {stage["name"]: stage["duration"] for stage in read.origin(folder)[1]["stage"]}
    targets = [stage for stage in stage_records(folder) if "aim_reached" in stage]
    if not targets:
        raise SystemExit("no stage has a target")
    for stage in targets:
        if not stage["aim_reached"] or stage["duration_s"] > 0.95 * longest[stage["name"]]:
            raise SystemExit(f"ended by time, not by its target: {stage}")


def stops(reference, first=""):
    """Stop after these windows: the first, within each stage from `first` on, the last of a stage,
    and the last but one of all."""
    names = [stage["name"] for stage in summary(reference)["stages"]]
    skipped = names.index(first) if first else 0
    total, begin, chosen, ends = 0, 0, [], []
    for stage in summary(reference)["stages"]:
        windows = round(stage["duration_s"] / stage["window_s"])
        begin, total = total, total + windows
        chosen.append(begin + (2 * windows) // 3)
        ends.append(total)
    end = min(max(skipped, len(ends) - 3), len(ends) - 2)  # not of the last stage, with the run's
    return [*([] if first else [1]), *chosen[skipped:], ends[end], total - 1]


def main():
    program, deck, root = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    overrides, first = sys.argv[4:], ""
    if overrides[:1] == ["--from"]:
        first, overrides = overrides[1], overrides[2:]
    shutil.rmtree(root, ignore_errors=True)
    reference = root / "reference"
    program.done(1, "run", deck, *overrides, "-o", reference)
    require_ends_by_target(reference)
    for number, windows in enumerate(part(stops(reference, first))):
        folder = root / f"stopped_{windows}"
        program.done(RANKS_OF_STOPPED, "run", deck, *overrides, f"output.stop_after={windows}",
                     "-o", folder, code=3)
        first_part = summary(folder)["wall_time_s"]
        program.done(RANKS_OF_RESUMED[number % 2], "resume", folder)
        compare(reference, folder, f"stopped after {windows} windows")
        require_time_of_all_parts(folder, first_part)
    folder = root / "started"
    program.done(2, "run", deck, *overrides, f"start={reference / 'stage_sleepers.h5'}", "-o",
                 folder)
    hashes = [summary(place)["dem"]["state_hash"] for place in (reference, folder)]
    if hashes[0] != hashes[1]:
        raise SystemExit(f"started from a stage: {hashes}")
    require_time_of_all_parts(folder, 0)
    folder = root / "observed"
    program.done(2, "run", deck, *overrides, "output.history_interval=1.7e-4",
                 "output.fields=true", "output.checkpoint_interval=0.011", "-o", folder)
    if summary(folder)["dem"]["state_hash"] != hashes[0]:
        raise SystemExit("observation changed the state")


if __name__ == "__main__":
    main()
