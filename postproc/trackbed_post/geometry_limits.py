"""Limits of a track geometry at a speed, and the sections beyond them: those of a file of the
owner of the line, or the immediate action limits below.

These are of EN 13848-5:2008+A1:2010 for the longitudinal level, mean to peak, and of the decision
2011/275/EU for twist, from memory: not verified against these texts. The standard leaves alert and
intervention limits to the owner.
"""
import collections.abc
import dataclasses
import difflib
import itertools
import pathlib
import re
import typing

import numpy as np
from matplotlib.axes import Axes

from trackbed_post import read

Value = typing.TypeVar("Value")
Section = tuple[float, float, float]  # first x, last x, largest value
# km/h, above the first and up to the second -> band -> mm.
LEVEL = {(0, 80): {"D1": 28.0}, (80, 120): {"D1": 26.0}, (120, 160): {"D1": 23.0},
         (160, 230): {"D1": 20.0, "D2": 33.0}, (230, 300): {"D1": 16.0, "D2": 28.0}}
TWIST = {(0, 200): 7.0, (200, 300): 5.0}  # mm/m, the most over any base
TWIST_BASES = (1.3, 20.0)                 # m
LISTED = 10  # sections
SOURCE = ("immediate action limits: level EN 13848-5:2008, twist 2011/275/EU, from memory, not "
          "verified against the texts; those of the owner of the line are given by --limits")

LEVELS = {"alert": "alert", "intervention": "intervention", "immediate": "immediate action"}
MARKS: dict[str, dict[str, typing.Any]] = {
    "alert": {"color": "0.5", "ls": ":"}, "intervention": {"color": "0.3", "ls": "-."},
    "immediate": {"color": "tab:red", "ls": "--"}}
NEAR = 3.0  # times the largest value of a panel: a farther limit would make its curves flat
COLUMNS = ("quantity", "above_km_h", "to_km_h", "level", "limit", "unit")
QUANTITIES = ("D1", "D2", "D3", "D1 sd", "D2 sd", "D3 sd", "twist 3 m")
TWIST_NAME = re.compile(r"twist (\d+(?:\.\d+)?) m")


@dataclasses.dataclass(frozen=True)
class Row:
    """A limit above one speed and up to another one, km/h; mm, of twist mm/m."""
    quantity: str
    above: float
    to: float
    level: str
    limit: float
    line: int = 0


@dataclasses.dataclass(frozen=True)
class Limits:
    """Those at one speed: quantity -> level -> limit, mm or mm/m; `source`: a line of the table;
    `unknown`: why the twist over a base may have none."""
    of: dict[str, dict[str, float]]
    source: str
    unknown: str = ""


def twist_name(base: float) -> str:
    return f"twist {base:g} m"


def base_of(quantity: str) -> float | None:
    """Base of a twist, m; None of other quantities."""
    found = TWIST_NAME.fullmatch(quantity)
    return float(found[1]) if found else None


def unit_of(quantity: str) -> str:
    return "mm/m" if quantity.startswith("twist") else "mm"


def at(table: dict[tuple[int, int], Value], speed: float) -> Value:
    """The value at a speed, km/h."""
    for (above, most), value in table.items():
        if above < speed <= most:
            return value
    raise read.Unreadable(f"--speed {speed:g}: limits are known above 0 and up to 300 km/h; give "
                          "others by --limits, or leave the option out")


def twist_limit(base: float, speed: float) -> float | None:
    """mm/m over `base` m: 20/base + 3, but not more than the table; None for other bases."""
    low, high = TWIST_BASES
    return min(20 / base + 3, at(TWIST, speed)) if low <= base <= high else None


def known_rows(bases: collections.abc.Iterable[float]) -> list[Row]:
    """The limits of this module as rows of a file."""
    rows = [Row(band, above, to, "immediate", limit)
            for (above, to), bands in LEVEL.items() for band, limit in bands.items()]
    return rows + [Row(twist_name(base), above, to, "immediate", limit)
                   for base in bases for (above, to) in TWIST
                   if (limit := twist_limit(base, to)) is not None]


def template(bases: collections.abc.Iterable[float]) -> str:
    """A file of limits: the known ones, and comments for those that the owner adds."""
    rows = known_rows(bases)
    lines = ["# Limits of a line for `postproc geometry --speed KMH --limits FILE`: valid above",
             "# one speed and up to another one. Lines that begin with # do not count. Check each",
             "# number: those below are from memory, not verified against EN 13848-5 and",
             "# 2011/275/EU.",
             ",".join(COLUMNS)]
    lines += [f"{one.quantity},{one.above:g},{one.to:g},{one.level},{one.limit:.4g},"
              f"{unit_of(one.quantity)}" for one in rows]
    lines += ["# Of the owner; D1 sd is the standard deviation in the window of --window:"]
    lines += [f"# {quantity},0,80,{level},,{unit_of(quantity)}"
              for quantity in ("D1", "D1 sd", "twist 3 m") for level in ("alert", "intervention")]
    return "\n".join(lines) + "\n"


def known(speed: float, bases: collections.abc.Iterable[float]) -> Limits:
    """Those of this module."""
    at(LEVEL, speed)
    low, high = TWIST_BASES
    return Limits(_at_speed(known_rows(bases), speed), SOURCE, f" ({low:g} to {high:g} m)")


def of_file(path: pathlib.Path, speed: float) -> Limits:
    """Those of a file at a speed, km/h; all its problems are stated at once."""
    found = _at_speed(rows_of(path), speed)
    if not found:
        raise read.Unreadable(f"{path} has no limit at {speed:g} km/h")
    return Limits(found, f"limits at {speed:g} km/h: {path.name}", f" in {path.name}")


def _at_speed(rows: collections.abc.Iterable[Row], speed: float) -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for one in rows:
        if one.above < speed <= one.to:
            found.setdefault(one.quantity, {})[one.level] = one.limit
    return {quantity: {level: levels[level] for level in LEVELS if level in levels}
            for quantity, levels in found.items()}


def rows_of(path: pathlib.Path) -> list[Row]:
    """Of a CSV file with COLUMNS in any order; commas between them, or semicolons, then also
    decimal commas."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, ValueError) as error:
        raise read.Unreadable(f"{path} cannot be read: {error}") from None
    numbered = [(k, line) for k, line in enumerate(lines, 1)
                if line.strip() and not line.lstrip().startswith("#")]
    number, head = numbered[0] if numbered else (1, "")
    between = ";" if ";" in head else ","
    names = [name.strip() for name in head.split(between)]
    if sorted(names) != sorted(COLUMNS):
        raise read.Unreadable(f"{path}, line {number}: the columns must be {', '.join(COLUMNS)}, "
                              f"not {', '.join(names)}; a template is written without --limits")
    problems: list[str] = []
    rows = [_row(number, dict(zip(names, cells)), problems)
            for number, line in numbered[1:]
            if (cells := _cells(number, line, between, problems))]
    whole = [one for one in rows if one]
    problems += _contradictions(whole)
    if not rows and not problems:
        problems.append("there is no row with a limit")
    if problems:
        raise read.Unreadable("\n".join([f"{path} cannot be used; its problems are:",
                                         *(f"  {one}" for one in problems)]))
    return whole


def _cells(number: int, line: str, between: str, problems: list[str]) -> list[str]:
    """Those of a line; none, with a problem, of a line with too few or too many."""
    cells = [cell.strip() for cell in line.split(between)]
    if len(cells) != len(COLUMNS):
        problems.append(f"line {number}: has {len(cells)} columns, not {len(COLUMNS)}")
        return []
    return [cell.replace(",", ".") for cell in cells] if between == ";" else cells


def _row(number: int, cells: dict[str, str], problems: list[str]) -> Row | None:
    """The Row of a line, or None and its problems."""
    mine: list[str] = []

    def value(column: str, least: float) -> float:
        try:
            found = float(cells[column])
        except ValueError:
            found = np.nan
        if not least <= found < np.inf or (column == "limit" and not found):
            mine.append(f"{column}: {cells[column] or 'nothing'}: must be a number "
                        + ("above 0" if column == "limit" else "of at least 0"))
        return found

    def one_of(column: str, choices: collections.abc.Iterable[str], what: str) -> str:
        text = cells[column]
        if text not in choices:
            near = difflib.get_close_matches(text, list(choices), 1)
            mine.append(f"{column}: {text or 'nothing'}: must be {what}"
                        + (f"; did you mean {near[0]}?" if near else ""))
        return text
    quantity = cells["quantity"]
    if base := base_of(quantity):
        quantity = twist_name(base)
    else:
        one_of("quantity", QUANTITIES, f"one of {', '.join(QUANTITIES)} or a twist over another "
               "base")
    above, to = value("above_km_h", 0), value("to_km_h", 0)
    if above >= to:
        mine.append(f"to_km_h: {to:g}: must be larger than above_km_h, {above:g}")
    level = one_of("level", LEVELS, f"one of {', '.join(LEVELS)}")
    limit = value("limit", 0)
    one_of("unit", (unit_of(quantity),), unit_of(quantity))
    problems += [f"line {number}, column {one}" for one in mine]
    return None if mine else Row(quantity, above, to, level, limit, number)


def _contradictions(rows: list[Row]) -> list[str]:
    """Two limits of the same kind at the same speeds, and a level that does not come after the one
    before it."""
    order, found = list(LEVELS), []
    for one, other in itertools.combinations(rows, 2):
        if one.quantity != other.quantity or max(one.above, other.above) >= min(one.to, other.to):
            continue
        low, high = sorted((one, other), key=lambda row: order.index(row.level))
        if low.level == high.level:
            found.append(f"line {other.line}, column above_km_h: overlaps the speeds of line "
                         f"{one.line}, which is the {one.level} limit of {one.quantity} as well")
        elif low.limit > high.limit:
            found.append(f"line {low.line}, column limit: {low.limit:g}: the {low.level} limit "
                         f"must not be above the {high.level} limit of {high.limit:g} in line "
                         f"{high.line}")
    return found


def sections(x: np.ndarray, values: np.ndarray, limit: float) -> list[Section]:
    """The runs of neighbouring places where |values| is above the limit; x in m, values in the
    unit of the limit."""
    size = np.abs(values)
    beyond = np.concatenate([[0], (size > limit).astype(int), [0]])
    starts, ends = np.flatnonzero(np.diff(beyond) == 1), np.flatnonzero(np.diff(beyond) == -1)
    return [(x[a], x[b - 1], size[a:b].max()) for a, b in zip(starts, ends)]


@dataclasses.dataclass(frozen=True)
class Judged:
    """A quantity of a record, its limit of a level in `unit`, and the sections beyond it."""
    name: str
    level: str
    limit: float
    unit: str
    beyond: list[Section]

    def words(self) -> list[str]:
        """Lines of the table; the worst sections in the order of x."""
        kind = f"{LEVELS[self.level]} limit"
        lines = [f"  {f'{self.name}: {kind}':<62}{self.limit:12.5g} {self.unit}",
                 f"  {f'{self.name}: sections above the {kind}':<62}{len(self.beyond):12d}"]
        worst = sorted(sorted(self.beyond, key=lambda section: -section[2])[:LISTED])
        if len(worst) < len(self.beyond):
            lines.append(f"    the {LISTED} worst of them:")
        return lines + [f"    {first:.4g} to {last:.4g} m: {largest:.4g} {self.unit}"
                        for first, last, largest in worst]

    def rows(self, record: str) -> list[str]:
        """All sections as rows of EXCEEDANCES."""
        return [f"{record.replace(',', ';')},{self.name.replace(',', '')},{self.level},"
                f"{self.limit:g},{self.unit},{first:.6g},{last:.6g},{largest:.4g}"
                for first, last, largest in self.beyond]


EXCEEDANCES = "record,quantity,level,limit,unit,from_m,to_m,largest"


def mark(panel: Axes, levels: dict[str, float], unit: str, most: float, what: str = "") -> None:
    """Lines at both signs of the limits, of which the legend states the values. The picture keeps
    the range of the curves, with values up to `most`, unless a limit is within NEAR times it."""
    for level, limit in levels.items():
        near = limit <= NEAR * most
        label = f"{what}{LEVELS[level]} limit: {limit:g} {unit}"
        style = MARKS[level] | {"lw": 1.0}
        if near:
            panel.axhline(-limit, **style)
            panel.axhline(limit, **style, label=label)
        else:
            panel.plot([], [], **style, label=f"{label} (beyond the picture)")
