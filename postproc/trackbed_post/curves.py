"""Curves of any quantity of results.h5 over its axis, of several runs, beside a measured or
published curve.

A history is a curve over time, an envelope one over x. What is computed: docs/postproc.md.
"""
import collections.abc
import dataclasses
import pathlib

import h5py
import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import axles, measured, panels, read, write

AXES = ("history/time", "history/stage", "envelope/x", "envelope/place")
# Components in the columns of a history, by the name of its axis (docs/postproc.md).
TENSOR = ("xx", "yy", "zz", "xy", "xz", "yz")
COMPONENTS = {"component": ("x", "y", "z"), "quaternion": ("x", "y", "z", "w"),
              "stress_component": TENSOR, "cell_component": TENSOR}
# SI unit, below which largest value (for factors below 1: from which on) another unit is drawn.
SHORT = (("m", 0.1, 1e3, "mm"), ("m/s", 0.1, 1e3, "mm/s"), ("N", 1e3, 1e-3, "kN"),
         ("Pa", 1e6, 1e-6, "MPa"), ("Pa", 1e3, 1e-3, "kPa"))


@dataclasses.dataclass(frozen=True)
class Curve:
    """y over x, both in SI units, [point]; x never decreases."""
    name: str
    x: np.ndarray
    x_unit: str
    y: np.ndarray
    unit: str
    place: int = 0  # number of the column


Curves = collections.abc.Sequence[Curve]


def known(path: pathlib.Path | str) -> list[str]:
    """Names of the datasets that can be drawn: those of histories and envelopes."""
    return [name for name, item in read.datasets(path).items()
            if name.startswith(("history/", "envelope/")) and item.values.ndim in (1, 2)
            and name not in AXES]


def _text(value: object) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def _sides(x: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(x, values) with a column for each rail, of rows that list left before right."""
    if len(x) > 1 and len(x) % 2 == 0 and (x[::2] == x[1::2]).all():
        return x[::2], values.reshape(len(x) // 2, 2)
    return x, values.reshape(len(x), -1)


def _columns(item: h5py.Dataset, count: int) -> list[str]:
    """A label for each column of a history: its place, axle or component, or its axis and number,
    from 0 as --place counts."""
    if count == 1 or item.ndim < 2 or not item.dims[1].values():
        return [""] * count
    scale = item.dims[1].values()[0]
    name = scale.name.rpartition("/")[2]
    if name == "x":
        return [f"x = {x:g} m" for x in scale[()]]
    if name == "place" and "x" in item.parent:
        return [f"x = {x:g} m, {('left', 'right')[k % 2]}"
                for k, x in enumerate(item.parent["x"][()])]
    if name == "wheel" and "x" in item.parent:
        twice = axles.on_two_rails(item.parent["x"][()].reshape(-1, count))
        return [panels.axle(k, twice) for k in range(count)]
    if parts := COMPONENTS.get(name):
        cell = "cell {}, " if name == "cell_component" else ""
        return [cell.format(k // len(parts)) + parts[k % len(parts)] for k in range(count)]
    return [f"{name} {k}" for k in range(count)]


def labels_of(path: pathlib.Path | str, name: str) -> list[str]:
    """A label for each column of a history; empty where a history has one column, or no axis."""
    path = pathlib.Path(path)
    with h5py.File(path / "results.h5" if path.is_dir() else path, "r") as file:
        item = file[name]
        return _columns(item, item.size // max(len(item), 1))


def _read(path: pathlib.Path, name: str) -> tuple[np.ndarray, str, np.ndarray, str, list[str]]:
    """(x, unit of x, values [x, column], unit, labels of the columns) of a dataset."""
    with h5py.File(path, "r") as file:
        item = file[name]
        scales = item.dims[0].values()
        if not scales:
            raise read.Unreadable(f"{name} of {path} has no axis: results of an older "
                                  "version; run the deck again")
        along = item.parent["x"] if scales[0].name.endswith("/place") and "x" in item.parent \
            else scales[0]
        x, values = along[()], np.asarray(item[()], dtype=float)
        labels = _columns(item, values.size // len(x))
        if values.ndim == 1:
            x, values = _sides(x, values)
            labels = ["left", "right"] if values.shape[1] == 2 else [""]
        return (x, _text(along.attrs.get("units", "")), values.reshape(len(x), -1),
                _text(item.attrs.get("units", "")), labels)


def _in_stage(path: pathlib.Path, name: str, stage: str) -> np.ndarray:
    """Which rows of a history are those of a stage."""
    read.require_history(name, f"rows of a stage {stage}")
    rows = read.rows_of_stage(read.datasets(path), read.origin(path)[1], stage)
    if not rows.any():
        raise read.Unreadable(f"{path.parent.name} has no row of the histories in stage {stage}")
    return rows


def of_run(path: pathlib.Path | str, name: str, place: int = -1, stage: str = "") -> Curve:
    """The Curve of a dataset such as history/rail/displacement. `place`: number of its column (of
    an envelope on two rails 0 left, 1 right); -1 for the one with the largest range. `stage`: its
    rows only, with the time since the first of them; without it, all but read.rows_without_body.
    """
    path = pathlib.Path(path)
    path = path / "results.h5" if path.is_dir() else path
    run = path.resolve().parent.name
    if name not in (names := known(path)):
        raise read.Unreadable(f"{run} has no curve {name}; it has {', '.join(names)}")
    x, x_unit, values, unit, labels = _read(path, name)
    if not -1 <= place < values.shape[1]:
        raise read.Unreadable(f"--place {place}: {name} has the places 0 to {values.shape[1] - 1}")
    if stage:
        rows = _in_stage(path, name, stage)
        x, values = x[rows] - x[rows][0], values[rows]
    elif name.startswith("history/"):
        rows = ~read.rows_without_body(read.datasets(path), name)
        x, values = x[rows], values[rows]
    kept = np.isfinite(values).all(axis=1)
    if not kept.any():
        raise read.Unreadable(f"{run}: {name} has no row with numbers")
    x, values = x[kept], values[kept]
    if place < 0:
        place = int(np.argmax(np.ptp(values, axis=0)))
    label = f"{run}, {labels[place]}" if labels[place] else run
    return Curve(label, x, x_unit, values[:, place], unit, place)


def of_runs(paths: collections.abc.Sequence[pathlib.Path | str], name: str,
            place: int = -1, stage: str = "") -> Curves:
    """Curves at one place: without `place` that of the largest range in the first run."""
    first = of_run(paths[0], name, place, stage)
    return [first, *(of_run(path, name, first.place, stage) for path in paths[1:])]


def _chosen(text: pathlib.Path | str) -> tuple[pathlib.Path, list[str]]:
    """(file, columns) of FILE.csv, FILE.csv:X or FILE.csv:X:Y."""
    path = pathlib.Path(text)
    wanted: list[str] = []
    while not path.is_file() and ":" in path.name and len(wanted) < 2:
        place, _, column = str(path).rpartition(":")
        path, wanted = pathlib.Path(place), [column, *wanted]
    if not path.is_file():
        raise read.Unreadable(f"{path} does not exist; a curve is FILE.csv or FILE.csv:X:Y")
    return path, wanted


def _of_columns(path: pathlib.Path, names: list[str], table: np.ndarray, wanted: list[str],
                name: str) -> Curve:
    """The Curve of two columns of a table that was read from `path`."""
    units = [measured.unit_of(one) for one in wanted]
    x, y = (table[:, names.index(one)] * factor for one, (factor, _) in zip(wanted, units))
    if bad := int(np.sum(~(np.isfinite(x) & np.isfinite(y)))):
        raise read.Unreadable(f"{path}: {bad} of {len(x)} rows have no number in {wanted[0]} or "
                              f"{wanted[1]}; remove them")
    order = np.argsort(x, kind="stable")
    return Curve(name, x[order], units[0][1], y[order], units[1][1])


def of_file(text: pathlib.Path | str) -> Curves:
    """The Curve of FILE.csv:X:Y, two columns of a file with a line of names that end with their
    units (x_m, time_s, z_mm); of a file with two columns, FILE.csv is enough. All curves of a
    curve.csv of this command."""
    path, wanted = _chosen(text)
    found = []
    for name, (names, table) in measured.tables_of(path).items():
        two = wanted or names
        if len(two) != 2 or set(two) - set(names):
            raise read.Unreadable(f"{path} has the columns {', '.join(names)}: choose two with "
                                  f"{path}:X:Y")
        found.append(_of_columns(path, names, table, two, name))
    return found


def columns_of(text: pathlib.Path | str) -> Curves:
    """As of_file; of a file with more than two columns, each over the first."""
    path, wanted = _chosen(text)
    names, table = next(iter(measured.tables_of(path).values()))
    if wanted or len(names) <= 2:
        return of_file(text)
    return [_of_columns(path, names, table, [names[0], name], f"{path.stem}, {name}")
            for name in names[1:]]


def deviation(curve: Curve, other: Curve) -> tuple[float, float, int] | None:
    """(root mean square, largest) difference of a curve from another one at the points of the
    latter, and the number of these points; None if they have no common range."""
    inside = (other.x >= curve.x[0]) & (other.x <= curve.x[-1])
    if not inside.any():
        return None
    difference = np.interp(other.x[inside], curve.x, curve.y) - other.y[inside]
    return (float(np.sqrt(np.mean(difference**2))), float(np.abs(difference).max()),
            int(inside.sum()))


def as_csv(curves: Curves, quantity: str) -> str:
    """A row for each point: name of the curve, time or x, quantity, in SI units."""
    along = "time" if curves[0].x_unit == "s" else "x"
    rows = [",".join(["curve", measured.column_of(along, curves[0].x_unit),
                      measured.column_of(quantity.rpartition("/")[2], curves[0].unit)])]
    rows += [f"{curve.name.replace(',', ';')},{x:.9g},{y:.9g}" for curve in curves
             for x, y in zip(curve.x, curve.y)]
    return "\n".join(rows) + "\n"


def table_of(curves: Curves, others: Curves) -> str:
    lines = []
    for curve in (*curves, *others):
        low, high = int(np.argmin(curve.y)), int(np.argmax(curve.y))
        lines += [f"{curve.name}: smallest {curve.y[low]:.4g} {curve.unit} at {curve.x[low]:.4g} "
                  f"{curve.x_unit}, largest {curve.y[high]:.4g} {curve.unit} at "
                  f"{curve.x[high]:.4g} {curve.x_unit}"]
    for other in others:
        span = float(np.ptp(other.y))
        for curve in curves:
            found = deviation(curve, other)
            if not found:
                lines.append(f"{curve.name} and {other.name} have no common range")
                continue
            rms, most, points = found
            share = f" ({100 * rms / span:.1f} % of the range of {other.name})" if span else ""
            lines.append(f"{curve.name} minus {other.name}: root mean square {rms:.4g} "
                         f"{curve.unit}{share}, largest magnitude {most:.4g} {curve.unit} "
                         f"({points} of {len(other.x)} points are in the common range)")
    return "\n".join(lines) + "\n"


def scale_of(curves: Curves) -> tuple[float, str]:
    """(factor, unit) of the axis of values: units that keep the numbers short."""
    return short_unit(max(np.abs(curve.y).max(initial=0) for curve in curves), curves[0].unit)


def short_unit(largest: float, unit: str) -> tuple[float, str]:
    """(factor, unit) for values up to the largest."""
    for si, limit, factor, name in SHORT:
        if unit == si and (largest < limit if factor > 1 else largest >= limit):
            return factor, name
    return 1.0, unit


def draw(curves: Curves, others: Curves, quantity: str) -> plt.Figure:
    figure, panel = plt.subplots(figsize=(9, 5), layout="constrained")
    factor, unit = scale_of((*curves, *others))
    for number, curve in enumerate(curves):
        panel.plot(curve.x, factor * curve.y, panels.LINES[number % len(panels.LINES)], lw=1,
                   label=curve.name)
    for number, other in enumerate(others):
        panel.plot(other.x, factor * other.y, color="k", label=other.name,
                   **panels.measured_look(len(other.x), number))
    panel.set(xlabel="time, s" if curves[0].x_unit == "s" else f"x, {curves[0].x_unit}",
              ylabel=f"{quantity}, {unit}")
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8)
    return figure


def draw_into(results: collections.abc.Sequence[pathlib.Path | str], folder: write.Folder,
              quantity: str, place: int = -1, over: collections.abc.Sequence[str] = (),
              shift: float = 0.0) -> None:
    """Picture, table and CSV of a quantity of runs (their folders); `over`: texts for of_file();
    `shift` is added to x of those, m or s."""
    curves = of_runs(results, quantity, place)
    others = [dataclasses.replace(other, x=other.x + shift)
              for text in over for other in of_file(text)]
    for one in (*curves[1:], *others):
        if (one.x_unit, one.unit) != (curves[0].x_unit, curves[0].unit):
            raise read.Unreadable(
                "curves of different units cannot be drawn together: "
                + "; ".join(f"{each.name} has values in {each.unit} and x in {each.x_unit}"
                            for each in (one, curves[0])))
    folder.picture("curve", draw(curves, others, quantity))
    folder.file("curve.csv", as_csv((*curves, *others), quantity))
    folder.table("curve.txt", table_of(curves, others))
