"""Measured signals: CSV, WAV and MAT files as evenly sampled arrays in SI units, with remarks on
their faults.

    signal = measured.load("sensor.csv:a2_g")     # column a2_g; without :NAME the only one
    signal.time, signal.values, signal.unit       # s; SI
    signal.remarks                                # sentences: gaps, clipping, resampling
"""
import collections.abc
import dataclasses
import pathlib

import numpy as np
import scipy.io
import scipy.io.wavfile
import scipy.signal

from trackbed_post import read, signals

# Factor to SI and SI unit, by the end of a column's name.
UNITS = {"_m_s2": (1.0, "m/s2"), "_g": (9.80665, "m/s2"), "_mm_s2": (1e-3, "m/s2"),
         "_m_s": (1.0, "m/s"), "_mm_s": (1e-3, "m/s"), "_m": (1.0, "m"), "_mm": (1e-3, "m"),
         "_um": (1e-6, "m"), "_N": (1.0, "N"), "_kN": (1e3, "N"), "_s": (1.0, "s"),
         "_ms": (1e-3, "s"), "_Pa": (1.0, "Pa"), "_kPa": (1e3, "Pa"), "_MPa": (1e6, "Pa"),
         "_Hz": (1.0, "Hz"), "_J": (1.0, "J"), "_kN_mm": (1e6, "N/m"), "_MN_m": (1e6, "N/m"),
         "_m_N": (1.0, "m/N"), "_mm_m": (1e-3, "1"), "_degrees": (1.0, "degrees"),
         "_%": (0.01, "1"), "_1": (1.0, "1")}
TIMES = {"time_s": 1.0, "time_ms": 1e-3}
GAP = 1.5  # median steps: samples are missing if those behind are late as well
BESIDE = 20  # samples on each side of a long step that tell a gap from uneven sampling
CLIPPED = 3  # equal samples in a row at the largest or smallest value
JUMP = 5  # quanta, into or out of such a row: slower signals may rest at their extreme


@dataclasses.dataclass(frozen=True)
class Signal:
    """Evenly spaced times, s; values in the SI unit `unit`; `remarks` on the data; `doubtful`:
    samples that were interpolated or clipped; `static`: of a wheel force, the static load, N."""
    name: str
    time: np.ndarray
    values: np.ndarray
    unit: str
    remarks: tuple[str, ...]
    doubtful: np.ndarray | None = None
    static: float | None = None

    @property
    def rate(self) -> float:
        """Samples per second."""
        return 1 / float(np.mean(np.diff(self.time)))


def column_of(name: str, unit: str) -> str:
    """Name of a column with its SI unit: an ending of UNITS, or the unit in brackets."""
    endings = [ending for ending, one in UNITS.items() if one == (1.0, unit)]
    return name + (endings[0] if endings else f" ({unit})")


def unit_of(name: str) -> tuple[float, str]:
    """(factor to SI, SI unit) by the longest ending of the name that is known, or by brackets."""
    if name.endswith(")") and " (" in name:
        return 1.0, name.rpartition(" (")[2][:-1]
    for ending in sorted(UNITS, key=len, reverse=True):
        if name.endswith(ending):
            return UNITS[ending]
    raise read.Unreadable(f"the unit of column {name} is unknown: its name must end with one of "
                          f"{', '.join(UNITS)}")


def _chosen(columns: collections.abc.Sequence[str], wanted: str, path: pathlib.Path) -> str:
    if wanted and wanted not in columns:
        raise read.Unreadable(f"{path} has no column {wanted}; it has {', '.join(columns)}")
    if not wanted and len(columns) != 1:
        raise read.Unreadable(f"{path} has the columns {', '.join(columns)}: choose one with "
                              f"{path}:NAME")
    return wanted or columns[0]


def _time_of(names: collections.abc.Sequence[str], path: pathlib.Path) -> str:
    found = [name for name in names if name in TIMES]
    if len(found) != 1:
        raise read.Unreadable(f"{path} must have one column time_s or time_ms; it has "
                              f"{', '.join(names)}")
    return found[0]


def tables_of(path: pathlib.Path) -> dict[str, tuple[list[str], np.ndarray]]:
    """As table_of, by the names of curves: of a curve.csv, whose first column has these, a table
    for each of them; of another file a single one."""
    lines = lines_of(path)
    if not lines[0].startswith("curve,") or len(lines) == 1:
        return {path.stem: _table_in(lines, path)}
    parts: dict[str, list[str]] = {}
    for name, _, numbers in (line.partition(",") for line in lines[1:]):
        parts.setdefault(name, [lines[0].removeprefix("curve,")]).append(numbers)
    return {f"{path.stem}, {name}": _table_in(part, path) for name, part in parts.items()}


def table_of(path: pathlib.Path) -> tuple[list[str], np.ndarray]:
    """(names, rows) of a CSV file whose first line has the names of its columns; commas between the
    columns, or semicolons, with points or commas in the numbers."""
    return _table_in(lines_of(path), path)


def lines_of(path: pathlib.Path) -> list[str]:
    """At least one."""
    try:
        return path.read_text(encoding="utf-8-sig").splitlines() or [""]
    except (OSError, ValueError) as error:
        raise _no_table(path, error) from None


def _no_table(path: pathlib.Path, error: Exception) -> read.Unreadable:
    return read.Unreadable(f"{path} cannot be read: {error}; a file has a line of names and rows "
                           "of numbers, with commas or semicolons between the columns, in UTF-8")


def _table_in(rows: list[str], path: pathlib.Path) -> tuple[list[str], np.ndarray]:
    head, *lines = rows
    try:
        between = ";" if ";" in head else ","
        names = [name.strip() for name in head.split(between)]
        if not any(line.strip() for line in lines):
            raise ValueError("there is no row of numbers")
        if between == ";":
            lines = [line.replace(",", ".") for line in lines]
        table = np.loadtxt(lines, delimiter=between, ndmin=2)
    except ValueError as error:
        raise _no_table(path, error) from None
    if table.shape[1] != len(names):
        raise read.Unreadable(f"{path} has {len(names)} names and {table.shape[1]} columns")
    return names, table


def _from_csv(path: pathlib.Path, wanted: str) -> tuple[str, np.ndarray, np.ndarray]:
    names, table = table_of(path)
    clock = _time_of(names, path)
    name = _chosen([one for one in names if one != clock], wanted, path)
    return name, table[:, names.index(clock)] * TIMES[clock], table[:, names.index(name)]


def vectors_of(path: pathlib.Path) -> dict[str, np.ndarray]:
    """Of MATLAB's files up to version 7, by their names."""
    try:
        return {name: np.ravel(item) for name, item in scipy.io.loadmat(path).items()
                if isinstance(item, np.ndarray) and item.dtype.kind in "fiu"}
    except Exception as error:  # of any kind, as its parser raises them
        raise read.Unreadable(f"{path} cannot be read ({error}); save it with -v7") from None


def _from_mat(path: pathlib.Path, wanted: str) -> tuple[str, np.ndarray, np.ndarray]:
    """Vectors of equal length, one of them time_s or time_ms."""
    found = vectors_of(path)
    clock = _time_of(list(found), path)
    name = _chosen([one for one, item in found.items()
                    if one != clock and len(item) == len(found[clock])], wanted, path)
    return name, found[clock] * TIMES[clock], found[name].astype(float)


def _from_wav(path: pathlib.Path, wanted: str) -> tuple[str, np.ndarray, np.ndarray]:
    """The name gives unit and value of the full scale: FILE.wav:50_m_s2 is 50 m/s2."""
    number, _, unit = wanted.partition("_")
    try:
        scale = float(number)
    except ValueError:
        raise read.Unreadable(f"samples of {path} are fractions of the full scale: give its value "
                              f"and unit, for example {path}:50_m_s2") from None
    try:
        rate, samples = scipy.io.wavfile.read(path)
    except Exception as error:  # of any kind, as its parser raises them
        raise read.Unreadable(f"{path} is not a WAV file ({error})") from None
    if samples.ndim > 1:
        raise read.Unreadable(f"{path} has {samples.shape[1]} channels; give a file of one")
    full = -float(np.iinfo(samples.dtype).min) if samples.dtype.kind == "i" else 1.0
    return f"full_scale_{unit}", np.arange(len(samples)) / rate, scale * samples / full


def clipped(values: np.ndarray) -> np.ndarray:
    """Samples in rows of CLIPPED and more at the largest or smallest value."""
    found = np.zeros(len(values), bool)
    levels = np.unique(values)
    if len(levels) < 3 or len(values) < CLIPPED + 2:
        return found
    quantum = np.min(np.diff(levels))
    for limit in (levels[0], levels[-1]):
        ends = np.flatnonzero(np.diff(np.concatenate([[0], values == limit, [0]])))
        for begin, end in ends.reshape(-1, 2):
            outside = [values[k] for k in (begin - 1, end) if 0 <= k < len(values)]
            if end - begin >= CLIPPED and max(abs(limit - v) for v in outside) > JUMP * quantum:
                found[begin:end] = True
    return found


def gaps(time: np.ndarray) -> list[int]:
    """Steps in which samples are missing, the longest first: longer than GAP median steps, and the
    samples behind are late by half a step or more, which those behind the long steps of uneven
    sampling are not."""
    steps = np.diff(time)
    step = np.median(steps)
    late, jumps = time - step * np.arange(len(time)), np.zeros(len(time))
    long = np.flatnonzero(steps > GAP * step)
    found = []
    for k in long[np.argsort(-steps[long])]:
        around = slice(max(k + 1 - BESIDE, 0), k + 1 + BESIDE)
        local = late[around] - np.cumsum(jumps[around])  # without the gaps found before
        before, behind = np.split(local, [k + 1 - around.start])
        if np.median(behind) - np.median(before) > step / 2:
            found.append(int(k))
            jumps[k + 1] = max(1, round(steps[k] / step) - 1) * step
    return found


def _even(time: np.ndarray, values: np.ndarray
          ) -> tuple[np.ndarray, np.ndarray, list[str], np.ndarray]:
    """Evenly spaced signal, the remarks on what it was before, and its doubtful samples."""
    remarks = []
    good = np.isfinite(values) & np.isfinite(time)
    if not good.all():
        remarks.append(f"{np.sum(~good)} of {len(values)} samples were not numbers and were "
                       "interpolated")
    time, values = time[good], values[good]
    if len(time) < 3 or np.any(np.diff(time) <= 0):
        raise read.Unreadable("a signal needs at least three samples in ascending time")
    overload = clipped(values)
    if overload.any():
        remarks.append(f"{np.sum(overload)} samples are at the extreme values {values.min():.4g} "
                       f"and {values.max():.4g}, at least {CLIPPED} in a row: was the sensor "
                       "overloaded?")
    missing = gaps(time)
    steps = np.diff(time)
    if len(missing):
        remarks.append(f"{len(missing)} gaps, the longest of {steps[missing[0]]:.4g} s at "
                       f"{time[missing[0]]:.4g} s, were filled by straight lines")
    regular = np.delete(steps, missing)
    step = float(np.mean(regular))
    if not signals.are_even(regular, time):
        remarks.append(f"the sampling is uneven (jitter): steps of {regular.min():.4g} to "
                       f"{regular.max():.4g} s were resampled to {step:.4g} s")
    even = time
    if signals.step_of(time) is None:
        even = time[0] + step * np.arange(int(round((time[-1] - time[0]) / step)) + 1)
    after = np.clip(np.searchsorted(time, even), 1, len(time) - 1)
    nearest = np.minimum(np.abs(time[after] - even), np.abs(even - time[after - 1]))
    doubtful = (nearest > GAP / 2 * step) | (np.interp(even, time, overload) > 0)
    return even, np.interp(even, time, values), remarks, doubtful


def acceleration(name: pathlib.Path | str) -> Signal:
    """The Signal of `load`, which must be an acceleration."""
    signal = load(name)
    if signal.unit != "m/s2":
        raise read.Unreadable(f"the unit is {signal.unit}, not that of an acceleration")
    return signal


def load(place: pathlib.Path | str) -> Signal:
    """Reads FILE or FILE:COLUMN. Names state units: time_s, a1_m_s2, force_kN. The mean and the
    linear trend remain: see `detrended`."""
    text = str(place)
    name, colon, wanted = text.rpartition(":")
    if not colon or pathlib.Path(text).is_file():  # names may have colons
        name, wanted = text, ""
    path = pathlib.Path(name)
    readers = {".csv": _from_csv, ".mat": _from_mat, ".wav": _from_wav}
    if path.suffix.lower() not in readers:
        raise read.Unreadable(f"{path}: the name must end with {', '.join(readers)}")
    if not path.is_file():
        raise read.Unreadable(f"{path} does not exist")
    name, time, values = readers[path.suffix.lower()](path, wanted)
    factor, unit = unit_of(name)
    time, values, remarks, doubtful = _even(time, values * factor)
    return Signal(f"{path.name}, {name}", time, values, unit, tuple(remarks), doubtful)


def detrended(signal: Signal) -> Signal:
    """Without mean and linear trend, as the drift of a sensor."""
    return dataclasses.replace(signal, values=scipy.signal.detrend(signal.values),
                               remarks=(*signal.remarks, "the linear trend was removed"))
