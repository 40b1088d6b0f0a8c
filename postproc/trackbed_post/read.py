"""Result files and checkpoints as arrays with units.

    results = read.results("results/quickstart/wedge")     # folder or results.h5
    results.sleeper["displacement"].values                 # [time, sleeper], m, up positive
    state = read.checkpoint("results/quickstart/wedge")         # the one named in `latest`
    state["run/window"].unit
    for window, file in read.fields("results/quickstart/wedge", "load", "ground").items():
        read.datasets(file)["VTKHDF/Points"].values

A file that cannot be read raises Unreadable, which ends a command with one message and code 2.
"""
import collections.abc
import contextlib
import dataclasses
import json
import pathlib
import re
import tomllib
import typing

import h5py
import numpy as np

Deck = dict[str, typing.Any]


@dataclasses.dataclass(frozen=True)
class Quantity:
    """An array with the attributes `units` and `long_name` of its dataset."""
    values: np.ndarray
    unit: str
    meaning: str


Quantities = dict[str, Quantity]  # by their names
NOTHING = Quantity(np.empty(0), "", "")


@dataclasses.dataclass(frozen=True)
class Chains:
    """Contact forces at the end of a stage: a line (x0, z0, x1, z1) in m and a force in N each."""
    segments: np.ndarray
    force: np.ndarray


@dataclasses.dataclass(frozen=True)
class Bonds:
    """Bonds at the end of a stage: rows of WHOLE, and of BROKEN for those that broke before."""
    whole: np.ndarray
    broken: np.ndarray


@dataclasses.dataclass(frozen=True)
class Stones:
    """Pieces of stones at the end of a stage: centres (x, z) and radii, m; for each stone the
    smallest opening it passes, m, and its mass, kg."""
    centre: np.ndarray
    radius: np.ndarray
    sieved: np.ndarray


@dataclasses.dataclass(frozen=True)
class Results:
    """One run. Histories are [time, place]; x of the places is in `sleepers_x` and `ground_x`."""
    name: str
    deck: Deck
    version: str
    ranks: int
    sleepers_x: np.ndarray
    ground_x: np.ndarray
    time: np.ndarray
    stage: np.ndarray
    sleeper: Quantities
    ground: Quantities
    energy: Quantities
    grading: np.ndarray  # per sieve: opening, m; passing prescribed, least and most, %
    walls: dict[str, Quantities]  # per wall `force`, N, and `displacement`, m: [time, x y z]
    platen: Quantities  # `z`, m, and `pressure`, Pa: [time]; `force`, N: [time, x y z]
    regions: dict[str, Quantities]  # per region; [time, cell], tensors [time, cell, 6]
    seat: Quantities   # of a train on two rails: [time, seat], left before right
    wheel: Quantities  # of a train: `x`, m, nan beside the track, and `force`, N: [time, wheel]
    rail: Quantities   # of a train: `displacement`, m, above each sleeper or seat: [time, place]
    sensors: dict[str, Quantities]  # per sensor: [time], [time, x y z]; stresses [time, 6]
    placed: dict[str, Quantities]  # per stone placed by the deck: [time], [time, x y z]
    surfaces: dict[str, Quantities]  # per plate and box force, impulse, peak_force, displacement
    total: Quantities  # all stones placed by the deck: momentum, angular momentum, contacts
    sleeper_envelope: Quantities
    ground_envelope: Quantities
    chains: dict[str, Chains]
    stones: dict[str, Stones]
    warnings: tuple[str, ...]       # messages of the run, from summary.json
    aim_reached: dict[str, bool]    # stage -> whether its aim was reached, from the same file
    surface: dict[str, np.ndarray]  # stage -> rows x, y, z of the bed's top, m; z nan: no stone
    breaks: dict[str, np.ndarray]   # stage -> rows of BREAK, pebbles that broke off up to its end
    bonds: dict[str, Bonds]         # stage -> those at its end
    lasted: dict[str, float] = dataclasses.field(default_factory=dict)  # stage -> s, the same file
    folder: pathlib.Path | None = None  # with the files of the run beside results.h5

    def _last_passage(self) -> int:
        """Number of the last passage stage, or -1; earlier passages bed the sleepers in."""
        kinds = [stage.get("kind") for stage in self.deck.get("stage", [])]
        return max((i for i, kind in enumerate(kinds) if kind == "passage"), default=-1)

    def asks_for_passage(self) -> bool:
        return self._last_passage() >= 0

    def passage_stage(self) -> tuple[int, str]:
        """Number, from 0, and name of the last passage stage; (-1, nothing) without one."""
        number = self._last_passage()
        return number, str(self.deck["stage"][number].get("name", "")) if number >= 0 else ""

    def has_passage(self) -> bool:
        """Whether the passage has rows: a run may have been stopped before."""
        return bool(np.any(self.stage == self._last_passage()))

    def passage_name(self) -> str:
        """What the rows of `passage` are, in titles and on axes."""
        if not len(self.stage):
            return "run"
        return "passage" if self.has_passage() else "last stage"

    def passage(self) -> slice:
        """Rows of the histories during the train's passage; of the last stage if there is none; all
        of a model without stages."""
        if not len(self.stage):
            return slice(0, len(self.time))
        rows = np.flatnonzero(self.stage == self._last_passage())
        if not len(rows):
            rows = np.flatnonzero(self.stage == self.stage[-1])
        return slice(rows[0], rows[-1] + 1)


class Unreadable(Exception):
    """What was given cannot be read, drawn or written; `code`: exit code of a command."""
    code = 2


@contextlib.contextmanager
def _opened(path: pathlib.Path) -> collections.abc.Iterator[h5py.File]:
    """The opened file. Any error in its contents means that it is not a file of trackbed."""
    try:
        with h5py.File(path, "r") as file:
            yield file
    except (OSError, RuntimeError) as error:  # h5py gives the reason in brackets
        reason = str(error).partition("(")[2].removesuffix(")") or error
        raise Unreadable(f"{path} is not an HDF5 file, or is damaged ({reason})") from None


def as_text(value: object) -> str:
    """An attribute that is text, as HDF5 stores it."""
    return value.decode() if isinstance(value, bytes) else str(value)


def _quantity(dataset: h5py.Dataset) -> Quantity:
    return Quantity(dataset[()], as_text(dataset.attrs["units"]),
                    as_text(dataset.attrs["long_name"]))


def _is_axis(path: str, dataset: h5py.Dataset) -> bool:
    """Whether it only labels the rows or columns of others in its group, as netCDF's readers
    expect: an axis, or positions that occur twice and therefore are none."""
    return h5py.h5ds.is_scale(dataset.id) or (path.endswith("/x") and "/wheel/" not in path)


def _quantities(file: h5py.File, group: str) -> Quantities:
    """The datasets of a group without their axes."""
    return {name: _quantity(dataset) for name, dataset in file[group].items()
            if not _is_axis(f"{group}/{name}", dataset)} if group in file else {}


def _of_places(file: h5py.File, group: str) -> Quantities:
    """Histories as [time, place], also for a single place, which the file stores as [time]."""
    return {name: dataclasses.replace(one, values=one.values.reshape(len(one.values), -1))
            if one.values.ndim == 1 else one for name, one in _quantities(file, group).items()}


def _regions(file: h5py.File) -> dict[str, Quantities]:
    """Histories of each region as [time, cell], of tensors [time, cell, 6]."""
    found: dict[str, Quantities] = {}
    for name, group in (file["history/region"].items() if "history/region" in file else ()):
        found[name] = {}
        for figure, flat in _quantities(file, group.name).items():
            parts = (6,) if figure in ("stress", "fabric") else ()
            found[name][figure] = dataclasses.replace(
                flat, values=flat.values.reshape(len(flat.values), -1, *parts))
    return found


def _named(file: h5py.File, place: str) -> dict[str, Quantities]:
    """Histories of each named part."""
    return {name: _quantities(file, group.name)
            for name, group in (file[place].items() if place in file else ())}


def _platen(file: h5py.File) -> Quantities:
    """z and pressure as [time], force as [time, x y z]."""
    return {name: dataclasses.replace(one, values=one.values.reshape(len(one.values), -1).squeeze())
            for name, one in _quantities(file, "history/platen").items()}


def in_order(names: collections.abc.Iterable[str], deck: Deck) -> list[str]:
    """Names of stages in the order of the deck; HDF5 lists them alphabetically."""
    order = [stage.get("name") for stage in deck.get("stage", [])]
    return sorted(names, key=lambda name: order.index(name) if name in order else len(order))


def _array(file: h5py.File, path: str) -> np.ndarray:
    return file[path][()] if path in file else np.empty(0)


def _place(path: pathlib.Path | str, name: str) -> pathlib.Path:
    path = pathlib.Path(path)
    found = path / name if path.is_dir() else path
    if not found.is_file():
        raise Unreadable(f"{found} does not exist; was the run completed?")
    return found


def results(path: pathlib.Path | str) -> Results:
    """Reads results.h5 (the file or its folder); parts that a run did not have are empty."""
    file_path = _place(path, "results.h5")
    with _opened(file_path) as file:
        try:
            return _results(file_path, file)
        except (KeyError, ValueError, AttributeError, TypeError) as error:
            raise Unreadable(f"{_foreign(file_path, file)} ({error.args[0]})") from None


# Columns of the rows of breakage: s, -, - (fragment -1: fines), m, m, m, m, kg, N, J, J, Pa, -.
BREAK = {name: k for k, name in enumerate((
    "time", "stone", "fragment", "x", "y", "z", "diameter", "mass", "force", "released", "lost",
    "stress", "kind"))}
# Columns of bonds: -, -, -, m, m, m, N, -, -; and of those that broke: s, -, -, -, - (1 by shear, 0
# by tension), m, m, m, Pa, Pa, J.
WHOLE = {name: k for k, name in enumerate((
    "first", "second", "kind", "x", "y", "z", "force", "utilisation", "damage"))}
BROKEN = {name: k for k, name in enumerate((
    "time", "first", "second", "kind", "by_shear", "x", "y", "z", "normal", "shear", "energy"))}
PEBBLE, CORNER, SPLIT, DUST = range(4)  # kinds of a break; older results have pebbles alone


def _breaks(rows: np.ndarray) -> np.ndarray:
    """Rows of BREAK; zeros where an older file has no such column."""
    rows = rows.reshape(-1, rows.shape[-1])  # also without a row
    return np.pad(rows, ((0, 0), (0, len(BREAK) - rows.shape[1])))


def _foreign(file_path: pathlib.Path, file: h5py.File) -> str:
    kind = as_text(file.attrs.get("kind", ""))
    return (f"{file_path} is not a results.h5 of trackbed"
            f"{f' but a {kind}' if kind else ''}")


def _results(file_path: pathlib.Path, file: h5py.File) -> Results:
    deck = tomllib.loads(as_text(file.attrs["deck"]))
    stages = file["chains"] if "chains" in file else {}
    stone_stages = file["stones"] if "stones" in file else {}
    surfaces = file["surface"] if "surface" in file else {}
    breaks = file["breaks"] if "breaks" in file else {}
    bonds = file["bonds"] if "bonds" in file else {}
    return Results(
        name=file_path.parent.name,
        deck=deck,
        version=as_text(file.attrs["version"]),
        ranks=int(np.ravel(file.attrs["ranks"])[0]),
        sleepers_x=_array(file, "sleepers/x"),
        ground_x=_array(file, "ground/x"),
        time=_array(file, "history/time"),
        stage=_array(file, "history/stage"),
        sleeper=_of_places(file, "history/sleeper"),
        ground=_of_places(file, "history/ground"),
        energy=_quantities(file, "history/energy"),
        grading=_array(file, "bed/grading").reshape(-1, 4),
        walls=_named(file, "history/wall"),
        seat=_of_places(file, "history/seat"),
        wheel=_of_places(file, "history/wheel"),
        rail=_of_places(file, "history/rail"),
        sensors=_named(file, "history/sensor"),
        placed=_named(file, "history/stone"),
        surfaces=_named(file, "history/surface"),
        total=_quantities(file, "history/total"),
        warnings=tuple(summary(file_path.parent).get("warnings", ())),
        aim_reached={stage["name"]: stage["aim_reached"]
                     for stage in summary(file_path.parent).get("stages", ())
                     if "aim_reached" in stage},
        lasted={stage["name"]: stage["duration_s"]
                for stage in summary(file_path.parent).get("stages", ()) if "duration_s" in stage},
        platen=_platen(file),
        regions=_regions(file),
        sleeper_envelope=_quantities(file, "envelope/sleeper"),
        ground_envelope=_quantities(file, "envelope/ground"),
        chains={name: Chains(stages[name]["segments"][()].reshape(-1, 4),
                             stages[name]["force"][()])
                for name in in_order(stages, deck)},
        stones={name: Stones(stone_stages[name]["centre"][()].reshape(-1, 2),
                             stone_stages[name]["radius"][()],
                             stone_stages[name]["sieved"][()].reshape(-1, 2))
                for name in in_order(stone_stages, deck)},
        surface={name: surfaces[name]["top"][()].reshape(-1, 3)
                 for name in in_order(surfaces, deck)},
        breaks={name: _breaks(breaks[name][()]) for name in in_order(breaks, deck)},
        bonds={name: Bonds(*(bonds[name][part][()].reshape(-1, len(columns))
                             for part, columns in (("whole", WHOLE), ("broken", BROKEN))))
               for name in in_order(bonds, deck)},
        folder=file_path.parent)


def folder_of(path: pathlib.Path | str) -> pathlib.Path:
    """The folder of a run, given by itself or by its results.h5."""
    path = pathlib.Path(path)
    return path.parent if path.name == "results.h5" and path.is_file() else path


def summary(folder: pathlib.Path | str) -> dict[str, typing.Any]:
    """The contents of summary.json; empty while a run goes on, or after it was killed."""
    path = folder_of(folder) / "summary.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def origin(path: pathlib.Path | str) -> tuple[str, Deck, str]:
    """(what wrote a results.h5, its deck, the deck's text)."""
    file_path = _place(path, "results.h5")
    with _opened(file_path) as file:
        kind = as_text(file.attrs.get("kind", "trackbed results"))
        if "deck" not in file.attrs or kind != "trackbed results":  # a checkpoint has a deck, too
            raise Unreadable(_foreign(file_path, file))
        text = as_text(file.attrs["deck"])
        words = f"trackbed {as_text(file.attrs['version'])}"
        if "build" in file.attrs:
            words += f", {as_text(file.attrs['build'])}"
        return words, tomllib.loads(text), text


def datasets(path: pathlib.Path | str) -> Quantities:
    """Every dataset of an HDF5 file, or of results.h5 in a folder, by its path;
    missing labels are empty. The axes within groups of histories and envelopes (history/sleeper/x)
    are left out, since they repeat history/time, sleepers/x, ground/x, rail/x and envelope/x, or
    are numbers."""
    found: Quantities = {}

    # visititems would give a dataset with several names only once.
    def see(group: h5py.Group) -> None:
        for item in group.values():
            if isinstance(item, h5py.Group):
                see(item)
            elif isinstance(item, h5py.Dataset):
                path = item.name.lstrip("/")
                if path.count("/") > 1 and _is_axis(path, item):
                    continue
                label = (as_text(item.attrs.get(key, "")) for key in ("units", "long_name"))
                found[path] = Quantity(item[()], *label)

    with _opened(_place(path, "results.h5")) as file:
        see(file)
    return found


def require_history(name: str, words: str) -> None:
    """Datasets other than histories have no rows over time; `words`: what is asked of them."""
    if not name.startswith("history/"):
        raise Unreadable(f"{name} is no history: it has no {words}")


def rows_of_stage(every: Quantities, deck: Deck, stage: str) -> np.ndarray:
    """Which rows of the histories of `datasets` are those of a stage of the deck."""
    names = [str(one.get("name")) for one in deck.get("stage", [])]
    if stage not in names or "history/stage" not in every:
        raise Unreadable(f"there is no stage {stage}; the stages are "
                         f"{', '.join(names) or 'not named in this run'}")
    return every["history/stage"].values == names.index(stage)


# Groups of histories that are zero while there is no such body or, of the ground, while it is held.
# Others are not numbers then.
ZERO_WITHOUT_BODY = ("sleeper", "seat", "solid", "platen", "ground", "sensor")


def rows_without_body(every: Quantities, name: str) -> np.ndarray:
    """Which rows of a history are of stages in which all of its group is zero; none if these are
    all stages."""
    group = name.rpartition("/")[0] + "/"
    if "history/stage" not in every or not group.startswith(
            tuple(f"history/{body}/" for body in ZERO_WITHOUT_BODY)):
        return np.zeros(len(every[name].values), dtype=bool)
    stage = every["history/stage"].values
    moved = np.any([(one.values.reshape(len(stage), -1) != 0).any(axis=1)
                    for other, one in every.items() if other.startswith(group)], axis=0)
    there = np.isin(stage, stage[moved])
    return ~there & there.any()


def checkpoint(path: pathlib.Path | str, stage: str = "") -> Quantities:
    """Every dataset of a checkpoint; of a folder, that at the end of the stage of this name, or the
    file named in its text file `latest`."""
    path = pathlib.Path(path)
    if stage:
        path = path / f"stage_{stage}.h5"
    elif path.is_dir():
        names = _place(path, "latest").read_text(encoding="utf-8").splitlines()
        if not names:
            raise Unreadable(f"{path / 'latest'} is empty: it names no checkpoint; give a file "
                             "stage_*.h5 or checkpoint_*.h5")
        path = path / names[0]
    return datasets(path)


def fields(folder: pathlib.Path | str, stage: str, part: str) -> dict[int, pathlib.Path]:
    """Field files of a stage in a result folder, by the number of their window in the stage. Parts
    are stones, contacts, ground, solids, surfaces and train."""
    name = re.compile(rf"{re.escape(stage)}_(\d+)_{part}\.hdf")
    files = sorted((pathlib.Path(folder) / "fields").glob("*.hdf"))
    numbered = {int(found[1]): file for file in files if (found := name.fullmatch(file.name))}
    return dict(sorted(numbered.items()))


def time_in(path: pathlib.Path | str) -> float | None:
    """s: the time that a field file states itself, if it does."""
    with _opened(pathlib.Path(path)) as file:
        found = file.get("VTKHDF/FieldData/TimeValue")
        return None if found is None else float(np.ravel(found[()])[0])


def series(folder: pathlib.Path | str, part: str) -> list[tuple[float, pathlib.Path]]:
    """(time, s, file) of each field file of a part over the whole run, in order of time."""
    path = pathlib.Path(folder) / "fields" / f"{part}.hdf.series"
    if not path.is_file():
        return []
    try:
        files = json.loads(path.read_text(encoding="utf-8"))["files"]
        return [(float(file["time"]), path.parent / file["name"]) for file in files]
    except (ValueError, KeyError, TypeError):
        raise Unreadable(f"{path} is not a list of field files with their times, or is "
                         "damaged") from None
