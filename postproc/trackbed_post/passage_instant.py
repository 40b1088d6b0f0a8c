"""The instant of the field files of a run that pictures show unless a time is given: that at which
a wheel is nearest to the middle of the bed, as at the end of a run the train has usually left.
"""
import collections.abc
import pathlib

import numpy as np

from trackbed_post import field_files, framing, instants, measures, read

BED = ("stones", "solids", "surfaces", "ground")  # the first of them shows where the bed is
Wheels = list[tuple[float, collections.abc.Sequence[float]]]  # time, s, and x of wheels, m


def wheels_in(path: pathlib.Path) -> list[float]:
    """x of the wheels in a field file of the part train, m: the middle of each disk."""
    arrays = field_files.arrays_of(path)
    if "wheel" not in arrays:
        return []
    cells = field_files.cells_of(arrays[""])
    disks = [cells.points[cells.nodes[first:first + size], 0] for first, size, wheel in
             zip(cells.first, cells.size, arrays["wheel"].values.ravel()) if wheel >= 0]
    return [float(x.min() + x.max()) / 2 for x in disks]


def _axles_of_load(folder: pathlib.Path, files: field_files.Files) -> Wheels:
    """Of the axles of [load], which field files do not show, at the times of files."""
    try:
        run = read.results(folder)
    except read.Unreadable:
        return []  # a run that has written no results.h5 yet
    names = [stage.get("name") for stage in run.deck.get("stage", [])]
    found: Wheels = []
    for time, file in files:
        stage = instants.Instant(time, instants.part_of(file)[0], {}).stage
        if stage in names:
            found.append((time, measures.axles_of_load(run, names.index(stage),
                                                       np.array([time]))[0].tolist()))
    return found


def _ends_of_bed(files: field_files.Files) -> tuple[float, float] | None:
    """Lowest and highest x of the first file with points, m."""
    for _, file in files:
        x = read.datasets(file)["VTKHDF/Points"].values[:, 0]
        if len(x):
            return float(x.min()), float(x.max())
    return None


def time_of(folder: pathlib.Path | str, after: float = -np.inf) -> float | None:
    """s, later than `after`; None for a run without wheels over the bed in its field files."""
    folder = read.folder_of(folder)
    parts = instants.available(folder)
    if "train" in parts:
        wheels: Wheels = [(time, wheels_in(file)) for time, file in parts["train"]]
    else:
        wheels = _axles_of_load(folder, max(parts.values(), key=len, default=[]))
    wheels = [(time, x) for time, x in wheels if time > after and len(x)]
    bed: field_files.Files = next((parts[part] for part in BED if part in parts), [])
    ends = _ends_of_bed(bed) if wheels else None
    found = framing.passing(wheels, *ends) if ends else None
    return found[0] if found else None
