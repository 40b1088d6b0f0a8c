"""Results of runs as arrays, for tests, by the names of datasets (trackbed_post)."""
import hashlib
import pathlib
import re
import sys

import numpy as np
from program import summary

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "postproc"))
from trackbed_post import read  # noqa: E402


def values(found):
    """The arrays of {name: read.Quantity}."""
    return {name: one.values for name, one in found.items()}


def datasets(path):
    """All datasets of an HDF5 file, or of the results in a folder, by name."""
    return values(read.datasets(path))


def checkpoint(path, stage=""):
    """All datasets of a checkpoint, by name; which one: read.checkpoint."""
    return values(read.checkpoint(path, stage))


def histories(folder, stage=None):
    """Histories by their name below history/, in the rows of the stage with this number; without
    one, of the last stage that has rows."""
    found = {name.removeprefix("history/"): rows for name, rows in datasets(folder).items()
             if name.startswith("history/")}
    number = found["stage"].ravel()
    chosen = number == (number.max() if stage is None else stage)
    return {name: rows[chosen] for name, rows in found.items()}


def data(path):
    """One digest for all datasets."""
    digest = hashlib.sha256()
    for name, rows in sorted(datasets(path).items()):
        digest.update(name.encode() + rows.tobytes())
    return digest.hexdigest()


# The static equilibrium of an elastic ground is solved iteratively on each number of ranks, to a
# relative residual of 1e-8 (ground.tolerance); nothing else depends on it. Its stress differed by
# 7e-10 of the largest component.
SOLVED, TOLERANCE = re.compile("history/sensor/.*/stress_static"), 1e-6


def equal(name, first, second, nan):
    """Whether two datasets of this name are bitwise the same, or as near as they can be."""
    equal_nan = nan and first.dtype.kind == "f"
    if SOLVED.fullmatch(name) and first.shape == second.shape:
        return np.allclose(first, second, rtol=0, equal_nan=equal_nan,
                           atol=TOLERANCE * np.nanmax(np.abs(first), initial=0))
    return np.array_equal(first, second, equal_nan=equal_nan)


def same_datasets(first, second, what, below="", nan=False):
    """Requires the same names in {name: array}, and bitwise identical arrays below a group, but for
    SOLVED; with `nan`, not-a-number equals itself."""
    if set(first) != set(second):
        raise SystemExit(f"{what}: other datasets: {sorted(set(first) ^ set(second))}")
    for name, rows in first.items():
        if name.startswith(below) and not equal(name, rows, second[name], nan):
            raise SystemExit(f"{what}: {name} differs")


def same_bits(one, other, what, facts, below=""):
    """Compares results below a group, and `facts` of the summary, with those of another folder."""
    same_datasets(datasets(one), datasets(other), what, below, nan=True)
    found = [facts(summary(place)) for place in (one, other)]
    if found[0] != found[1]:
        raise SystemExit(f"{what}: {found}")
