#!/usr/bin/env python3
"""Datasets of results, checkpoints and field files have units; only numbers without unit have "1".

    units.py RESULT_FOLDER ...
"""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "postproc"))
from trackbed_post import read  # noqa: E402

# All of them, as the end of a path: counts, names, identifiers, ratios, unit vectors.
PLAIN = {
    # field files
    "CellData/body", "CellData/equivalent plastic strain", "CellData/solid", "Connectivity",
    "NumberOfCells", "NumberOfConnectivityIds", "NumberOfPoints", "Offsets", "CellData/stone",
    "PointData/stone",
    "CellData/surface", "CellData/part", "CellData/wheel", "Types",
    # results
    "/contacts", "/coordination", "/fabric", "/porosity", "/stones", "history/stage",
    # checkpoints
    "/attitude", "/axes", "/held", "/history/keys", "/id", "/material", "/node", "quanta",
    "/plastic/opened", "/plastic/static", "/plastic/strain", "/scale", "/shape", "/template/faces",
    "/template/pieces", "/template/sizes", "/part", "/breakage/labels",
    "/breakage/single", "/bonds/stones", "CellData/kind", "CellData/damage",
    "CellData/utilisation",
    "/element", "/quaternion", "train/steps", "train/ramp_steps", "train/ramped_steps",
    "train/iterations", "train/lost", "/gain", "walls/removed", "sleepers/placed", "solid/moved",
    "run/stage", "run/stage_has_begun",
    "run/substeps", "run/windows", "run/windows_of_stage", "run/windows_in_stage", "run/warnings",
    "run/history_rows", "run/ground_settled", "/balance/force", "/balance/moment",
    "/balance/roll_moment", "/balance/impulse", "/balance/work", "run/stages/name",
    "run/stages/substeps", "run/stages/particles", "run/stages/aim",
    "traffic/cycles", "run/jump/counted", "run/jump/friction", "run/jump/in_stage",
    "run/jump/noted"}
# Words in the meaning of a dataset that imply a unit.
WITH_UNIT = re.compile(r"\((m|s|N|J|Pa|kg|m/s|m/s\^?2|rad)[;:)]")


def problems_of(path):
    found = []
    for name, item in read.datasets(path).items():
        unit, meaning = item.unit, item.meaning
        if not unit or not meaning:
            found.append(f"{name} has no unit or no meaning")
        elif unit == "1" and not any(name.endswith(end) for end in PLAIN):
            found.append(f"{name} ({meaning}) has the unit 1")
        elif unit == "1" and WITH_UNIT.search(name + meaning):
            found.append(f"{name} ({meaning}) has the unit 1, but its meaning implies another")
        # VTK shows only names, which therefore end with the unit; / is not allowed in them.
        named = re.search(r"\(([^()]*)\)$", name.replace("∕", "/"))
        if name.startswith("VTKHDF/") and named and named.group(1) != unit:
            found.append(f"{name} has the unit {unit}")
    return [f"{path}: {problem}" for problem in found]


def main():
    files = [path for folder in sys.argv[1:] for end in ("h5", "hdf")
             for path in sorted(pathlib.Path(folder).rglob(f"*.{end}"))]
    kinds = {"results.h5": 0, ".hdf": 0, "stage_": 0}
    problems = []
    for path in files:
        for kind in kinds:
            kinds[kind] += kind in path.name
        problems += problems_of(path)
    if not all(kinds.values()):
        problems.append(f"files read: {kinds}")
    if problems:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
