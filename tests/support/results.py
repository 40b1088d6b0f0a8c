"""Results of runs, for tests that compare them bitwise."""
import hashlib

import h5py
import numpy as np
from program import summary


def datasets(path):
    """All datasets of an HDF5 file, by name."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[()]})
                        if isinstance(item, h5py.Dataset) else None)
    return found


def data(path):
    """One digest for all datasets."""
    digest = hashlib.sha256()
    for name, values in sorted(datasets(path).items()):
        digest.update(name.encode() + values.tobytes())
    return digest.hexdigest()


def same_bits(one, other, what, facts, below=""):
    """Compares results below a group, and `facts` of the summary, with those of another folder."""
    first, second = (datasets(place / "results.h5") for place in (one, other))
    if set(first) != set(second):
        raise SystemExit(f"{what}: other datasets: {set(first) ^ set(second)}")
    for name, values in first.items():
        if name.startswith(below) and not np.array_equal(values, second[name], equal_nan=True):
            raise SystemExit(f"{what}: {name} differs")
    found = [facts(summary(place)) for place in (one, other)]
    if found[0] != found[1]:
        raise SystemExit(f"{what}: {found}")
