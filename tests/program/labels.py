#!/usr/bin/env python3
"""Every kind of results opens in xarray as labelled arrays, also those of a resumed run, and
compression changes nothing of them.

    labels.py PROGRAM SOURCE_FOLDER FOLDER
"""
import pathlib
import shutil
import sys
import tomllib

import h5py
import numpy as np
import xarray

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, expect  # noqa: E402

# Of solids only what is written soon.
SOLIDS = ["ground.present=false", "stage.compact.duration=0.02", "stage.load.duration=0.01",
          "stage.load.cycles=1", "stage.passage.duration=0.04"]
# Deck with changes, and dimensions of some of its arrays.
RUNS = {
    "tests/restart/tiny_two_rails.toml": ([], {
        "history/sleeper/displacement": ("time", "x"), "history/seat/force": ("time", "place"),
        "history/wheel/x": ("time", "wheel"), "history/body/roll": ("time",),
        "history/wall/wall.left/force": ("time", "component"),
        "history/ground/velocity_y": ("time", "x"),
        "envelope/ground/sigma_z_min": ("x",),
        "chains/fill/segments": ("contact", "end"), "chains/fill/force": ("contact",),
        "stones/fill/centre": ("pebble", "component"), "stones/fill/radius": ("pebble",),
        "stones/fill/sieved": ("stone", "property"),
        "surface/fill/top": ("cell", "component")}),
    "tests/restart/tiny_solids.toml": (SOLIDS, {
        "history/solid/bending_stress": ("time", "section"),
        "history/solid/seat_displacement": ("time", "solid_seat")}),
    "tests/restart/placed.toml": ([], {"history/stone/ball/attitude": ("time", "quaternion"),
                                       "history/total/momentum": ("time", "component")}),
    "tests/knobs/track.toml": ([], {"history/wheel/force": ("time", "wheel"),
                                    "history/sleeper/displacement": ("time",),
                                    "envelope/sleeper/seat_force_max": ("x",)}),
    "inputs/track/two_rails.toml": ([], {"history/sleeper/seat_force": ("time", "place"),
                                         "history/sleeper/x": ("place",),
                                         "envelope/rail/x": ("place",)}),
    "tests/knobs/on_ground.toml": ([], {"history/ground/force": ("time", "x")})}


def groups_of(path):
    """All groups of histories, envelopes and tables of stages that hold datasets."""
    found = ["history"]

    def see(group):
        if any(isinstance(item, h5py.Dataset) for item in group.values()):
            found.append(group.name)
        for item in group.values():
            if isinstance(item, h5py.Group):
                see(item)

    with h5py.File(path, "r") as file:
        for top in ("history", "envelope", "chains", "stones", "surface", "bonds"):
            for item in file.get(top, {}).values():
                if isinstance(item, h5py.Group):
                    see(item)
    return found


def read(path):
    """Every array of xarray by its path, with a coordinate for each dimension, units and a long
    name."""
    seen = {}
    for group in groups_of(path):
        with xarray.open_dataset(path, group=group, engine="h5netcdf") as data:
            for name, one in data.load().variables.items():
                seen[f"{group}/{name}".lstrip("/")] = one
                bare = [axis for axis in one.dims if axis not in data.coords]
                lacks = [word for word in ("units", "long_name") if not one.attrs.get(word)]
                if bare or lacks:
                    raise SystemExit(f"{path}: {group}/{name}: without coordinate: {bare}; without "
                                     f"attribute: {lacks}")
    return seen


def check(path, dimensions):
    arrays = read(path)
    for name, dims in dimensions.items():
        if arrays[name].dims != dims:
            raise SystemExit(f"{path}: {name} has dimensions {arrays[name].dims}, not {dims}")
    return arrays


# Changes at a resume that would need columns to begin or to end within the run.
OTHER_ROWS = {
    'region=[{name="below", x=[0.2,1.0], z=[0,0.15], cells=[3,1,2]}, {name="new"}]':
        'region[1].name = "new"',
    'sensor=[{name="stone", at=[0.5,0,0.1]}]': "must keep its regions and sensors",
    'output.histories=["energy"]': "were chosen at the start",
    "dem.energy_balance=true": "begun with or without the balance of energy"}


def check_resume(program, deck, folder):
    """Labels after a stop and a resume; axes have the values of time and positions."""
    dims = {"history/sleeper/displacement": ("time", "x"),
            "history/region/below/porosity": ("time", "cell"),
            "history/region/below/stress": ("time", "cell_component"),
            "history/region/below/fabric": ("time", "cell_component"),
            "history/sensor/stone/displacement": ("time", "component"),
            "history/sensor/stone/stones": ("time",),
            "history/sensor/soil/stress": ("time", "stress_component"),
            "history/sensor/soil/stress_static": ("time", "stress_component")}
    program.done(2, "run", deck, "output.stop_after=700", "-o", folder, code=3)
    for change, sentence in OTHER_ROWS.items():
        ran = program.done(1, "resume", folder, "-o", folder / "other", change, code=2)
        expect(sentence in ran.stderr, f"no sentence on {change}", ran)
    program.done(1, "resume", folder)
    arrays = check(folder / "results.h5", dims)
    stages = [stage["name"] for stage in tomllib.loads(deck.read_text(encoding="utf-8"))["stage"]]
    numbers = arrays["history/stage"].attrs
    if numbers["flag_meanings"].split() != stages or list(numbers["flag_values"]) != list(
            range(len(stages))):
        raise SystemExit(f"the stages {stages} are labelled {numbers}")
    with h5py.File(folder / "results.h5", "r") as file:
        for name, place in (("history/sleeper/time", "history/time"),
                            ("history/sleeper/x", "sleepers/x"),
                            ("history/ground/x", "ground/x"),
                            ("history/ground/sigma_z", "history/ground/sigma_z")):
            if not np.array_equal(arrays[name].values, file[place][()]):
                raise SystemExit(f"{name} in xarray differs from {place}")


# Kinds of models whose results are written in different ways, and by how much the size falls: rows
# of a ground that is held are zeros, vibrations are nearly random numbers.
COMPRESSED = {"tests/restart/tiny_two_rails.toml": 0.4, "inputs/track/two_rails.toml": 0.8}


def contents(path):
    """Attributes of all groups and datasets, with the numbers of the latter; references to axes
    are addresses in the file, which xarray follows."""
    found = {}

    def see(name, item):
        attributes = {key: str(value) for key, value in item.attrs.items()
                      if key not in ("deck", "REFERENCE_LIST", "DIMENSION_LIST")}
        found[name] = (attributes, item[()] if isinstance(item, h5py.Dataset) else None)

    with h5py.File(path, "r") as file:
        see("/", file)
        file.visititems(see)
    return found


def check_compression(program, deck, compressed, folder, most):
    """The same deck without compression has the same results in a larger file."""
    program.done(1, "run", deck, "output.compress=false", "-o", folder)
    plain = folder / "results.h5"
    one, other = contents(compressed), contents(plain)
    if one.keys() != other.keys():
        raise SystemExit(f"{deck}: only one file has {sorted(one.keys() ^ other.keys())}")
    for name, (attributes, numbers) in one.items():
        same = numbers is None or np.array_equal(numbers, other[name][1], equal_nan=True)
        if attributes != other[name][0] or not same:
            raise SystemExit(f"{deck}: compression changes {name}: {attributes}, {other[name][0]}")
    arrays, of_plain = read(compressed), read(plain)
    unlike = [name for name, array in arrays.items() if not array.identical(of_plain[name])]
    if unlike:
        raise SystemExit(f"{deck}: compression changes the arrays {unlike}")
    with h5py.File(compressed, "r") as file:
        largest = max((file[name] for name in one if isinstance(file[name], h5py.Dataset)),
                      key=lambda item: item.size)
        if not (largest.shuffle and largest.compression == "gzip"):
            raise SystemExit(f"{deck}: {largest.name} is not compressed")
    small, large = compressed.stat().st_size, plain.stat().st_size
    if small > most * large:
        raise SystemExit(f"{deck}: {small} bytes with compression, {large} without")


def main():
    program, source = Program(sys.argv[1]), pathlib.Path(sys.argv[2])
    folder = pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    for deck, (changes, dimensions) in RUNS.items():
        place = folder / pathlib.Path(deck).stem
        program.done(1, "run", source / deck, *changes, "-o", place)
        check(place / "results.h5", dimensions)
    for deck, most in COMPRESSED.items():
        name = pathlib.Path(deck).stem
        check_compression(program, source / deck, folder / name / "results.h5",
                          folder / f"{name}_plain", most)
    single = read(folder / "track/results.h5")["history/sleeper/x"]
    with h5py.File(folder / "track/results.h5", "r") as file:
        if not np.array_equal(single.values, file["sleepers/x"][()]):
            raise SystemExit("the group of a single sleeper must state its position")
    check_resume(program, source / "tests/restart/tiny.toml", folder / "resumed")
    print(f"{len(RUNS) + 1} results are labelled")


if __name__ == "__main__":
    main()
