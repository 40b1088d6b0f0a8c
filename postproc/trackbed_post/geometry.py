"""Geometry of a track: longitudinal level in bands of wavelength and twist, of measured files or
under the first wheel of runs. What is computed: docs/postproc.md.

A file (CSV or MAT) has a column x_m and one of heights for one rail, or two, whose names begin with
left and right and end with the unit (z_m, left_mm). The file of `irregularity.file` of a deck is
one.
"""
import collections.abc
import dataclasses
import pathlib

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from trackbed_post import (geometry_limits, measured, read, track_figures, track_measures,
                           write)
from trackbed_post.panels import LINES, legend_above, title_above, wrapped

Bases = collections.abc.Sequence[float]  # of twist, m
BANDS = track_measures.BANDS
WINDOW = 200.0     # m, of sliding standard deviations
BASES = (3.0,)     # m, of twist
# km/h, above the first and up to the second -> largest standard deviation of the level in D1 over
# 200 m, mm, of the classes A to D; above is E. EN 13848-6:2014 as quoted by G. A. Krug, Analysis of
# EN 13848-6 recommendations (undated), which has these two ranges only.
CLASSES = {(80, 120): (0.75, 1.10, 1.80, 2.50), (120, 160): (0.65, 0.85, 1.40, 1.85)}
GAP = 1.5          # median steps of x: rows are missing
LEAST = 10         # samples of a window
TEMPLATE = "limits_template.csv"


@dataclasses.dataclass(frozen=True)
class Choices:
    """Of the command: `bases` of twist and the `window` of standard deviations, m; `speed` of the
    line, km/h, for classes and limits; `limits_file` of the owner; `deck`: writes the files of
    `irregularities` of the one source."""
    bases: Bases = BASES
    window: float = WINDOW
    speed: float | None = None
    limits_file: pathlib.Path | None = None
    deck: bool = False

    def limits(self) -> geometry_limits.Limits | None:
        """Those at the speed, if it is given."""
        if self.speed is None:
            if self.limits_file:
                raise read.Unreadable("--limits: needs the speed of the line; give --speed")
            return None
        return geometry_limits.of_file(self.limits_file, self.speed) if self.limits_file else \
            geometry_limits.known(self.speed, self.bases)


@dataclasses.dataclass(frozen=True)
class Level:
    """Heights of one rail or two, [place, rail], m, at evenly spaced x, m."""
    name: str
    x: np.ndarray
    height: np.ndarray
    remarks: tuple[str, ...] = ()

    @property
    def step(self) -> float:
        return self.x[1] - self.x[0]

    @property
    def length(self) -> float:
        return self.x[-1] - self.x[0]


def even(name: str, x: np.ndarray, height: np.ndarray) -> Level:
    """A Level of rows in ascending x; uneven ones are interpolated at their median distance."""
    whole = np.isfinite(x) & np.isfinite(height).all(axis=1)
    without = len(x) - np.count_nonzero(whole)
    x, height = x[whole], height[whole]
    if len(x) < 8 or np.any(np.diff(x) <= 0):
        raise read.Unreadable(f"{name}: a level needs at least eight rows of numbers, x ascending")
    steps = np.diff(x)
    step = float(np.median(steps))
    missing = np.flatnonzero(steps > GAP * step)
    remarks = []
    if without:
        remarks.append(f"{without} rows with values that are not numbers were left out")
    if len(missing):
        remarks.append(f"{len(missing)} gaps, the longest of {steps.max():.4g} m at "
                       f"{x[np.argmax(steps)]:.4g} m, were filled by straight lines")
    places = track_measures.even_places(x)
    return Level(name, places, np.stack([np.interp(places, x, rail) for rail in height.T], axis=1),
                 tuple(remarks))


def in_order(rails: list[str], path: pathlib.Path) -> list[str]:
    """Names of two columns, that of the left rail first."""
    if len(rails) == 1:
        return rails
    sides = {side: [one for one in rails if one.startswith(side)] for side in ("left", "right")}
    if any(len(found) != 1 for found in sides.values()):
        raise read.Unreadable(f"{path}: the names of two columns of heights must begin with left "
                              f"and right (left_mm, right_mm), not {', '.join(rails)}")
    return sides["left"] + sides["right"]


def table_of(path: pathlib.Path) -> tuple[list[str], np.ndarray]:
    """(names, rows) of a CSV or a MAT file, of the latter the vectors as long as x_m."""
    if path.suffix.lower() != ".mat":
        return measured.table_of(path)
    found = measured.vectors_of(path)
    names = [name for name, item in found.items() if len(item) == len(found.get("x_m", ()))]
    rows = [found[name] for name in names]
    return names, np.stack(rows, axis=1).astype(float) if rows else np.empty((0, 0))


def of_file(path: pathlib.Path) -> Level:
    names, table = table_of(path)
    rails = [one for one in names if one != "x_m"]
    if "x_m" not in names or len(rails) not in (1, 2):
        raise read.Unreadable(f"{path} must have a column x_m and one or two of heights; it has "
                              f"{', '.join(names)}")
    rails = in_order(rails, path)
    factors = [measured.unit_of(one) for one in rails]
    if any(unit != "m" for _, unit in factors):
        raise read.Unreadable(f"{path}: heights must be lengths, such as z_m or left_mm, not "
                              f"{', '.join(rails)}")
    return even(path.name, table[:, names.index("x_m")], np.stack(
        [factor * table[:, names.index(one)] for one, (factor, _) in zip(rails, factors)], axis=1))


def of_run(folder: pathlib.Path | str) -> Level:
    """The loaded rails under the first rolling wheel of a track alone, between its run-ins."""
    deck = read.origin(folder)[1]
    run = read.datasets(folder)
    wheels = track_figures.rolling(run) if "history/wheel/height" in run else []
    if not wheels or "track" not in deck:
        raise read.Unreadable(f"{folder}: has no path of a rolling wheel (history/wheel/height); "
                              "only runs of a track without a bed have one")
    run_in, length = track_figures.run_in_of(deck), deck["track"]["length"]
    sides = wheels[:2] if track_figures.two_rails(run) else wheels[:1]
    x = track_figures.history(run, "wheel/x")[:, sides[0]]
    on = (x >= run_in) & (x <= length - run_in)
    there, first = np.unique(x[on], return_index=True)   # at a stop x is repeated
    heights = [track_figures.history(run, "wheel/height")[:, side][on][first] for side in sides]
    return even(pathlib.Path(folder).name, there, np.stack(heights, axis=1))


def load(path: pathlib.Path | str) -> Level:
    """The Level of a CSV or MAT file, or of the folder of a run."""
    path = pathlib.Path(path)
    return of_run(path) if path.is_dir() else of_file(path)


def irregularities(level: Level) -> dict[str, str]:
    """Name of a file -> its text, for `irregularity.file` of a deck: x from 0 and height above the
    straight line through both ends, for each rail."""
    x = level.x - level.x[0]
    found = {}
    for side, height in zip(("_left", "_right") if level.height.shape[1] == 2 else ("",),
                            level.height.T):
        z = height - height[0] - (height[-1] - height[0]) * x / x[-1]
        rows = "".join(f"{a:.9g},{b:.9g}\n" for a, b in zip(x, z))
        found[f"irregularity{side}.csv"] = "x_m,z_m\n" + rows
    return found


def why_not(level: Level, band: str) -> str:
    """Why a record has not the band, or nothing."""
    shortest, longest = BANDS[band]
    if level.length < longest:
        return f"the record is shorter than {longest:g} m"
    return f"the record's step of {level.step:g} m does not resolve wavelengths of {shortest:g} m" \
        if 2 * level.step > shortest else ""


def bands_of(level: Level) -> dict[str, np.ndarray]:
    """Band -> [place, rail], m."""
    return {name: np.stack([track_measures.band(rail, level.step, limits)
                            for rail in level.height.T], axis=1)
            for name, limits in BANDS.items() if not why_not(level, name)}


def inner(level: Level, band: str) -> slice:
    """Rows of a band that its filter's continuation of the ends does not reach; all of a short
    record."""
    longest = BANDS[band][1]
    return track_measures.inner(level.x, longest)


def twist(level: Level, base: float) -> tuple[np.ndarray, np.ndarray]:
    """(middle of the base, m; change of the difference in height of both rails, left minus right,
    over `base` m divided by it, m/m)."""
    across = level.height[:, 0] - level.height[:, 1]
    if not level.step <= base < level.length:
        raise read.Unreadable(f"--twist-base {base:g}: must be at least the step of "
                              f"{level.name}, {level.step:g} m, and below its length of "
                              f"{level.length:g} m")
    x = level.x[level.x <= level.x[-1] - base]
    ahead = np.interp(x + base, level.x, across)
    return x + base / 2, (ahead - across[:len(x)]) / base


def sliding(x: np.ndarray, values: np.ndarray, window: float
            ) -> tuple[np.ndarray, np.ndarray, float]:
    """(middles of all windows of `window` m, the standard deviations in them, their length, m); of
    a shorter record that of the whole."""
    step = x[1] - x[0]
    count = min(int(round(window / step)) + 1, len(values))
    sums = np.concatenate([[0], np.cumsum(values)])
    squares = np.concatenate([[0], np.cumsum(values**2)])
    mean = (sums[count:] - sums[:-count]) / count
    spread = np.sqrt(np.maximum((squares[count:] - squares[:-count]) / count - mean**2, 0))
    return (x[:len(spread)] + x[count - 1:]) / 2, spread, (count - 1) * step


def worst_window(x: np.ndarray, values: np.ndarray, window: float) -> tuple[float, float, float]:
    """(largest standard deviation within `window` m, middle of this window, its length, m)."""
    middle, spread, length = sliding(x, values, window)
    worst = int(np.argmax(spread))
    return spread[worst], middle[worst], length


def numbers(level: Level, bases: Bases = BASES,
            window: float = WINDOW) -> dict[str, tuple[float, str]]:
    """Name -> (value, unit)."""
    found = {"length": (level.length, "m")}
    rails = rails_of(level)
    for name, values in bands_of(level).items():
        rows = inner(level, name)
        for rail, one in zip(rails, values[rows].T):
            spread, where, length = worst_window(level.x[rows], one, window)
            found |= {f"{name}, {rail}: standard deviation": (1e3 * one.std(), "mm"),
                      f"{name}, {rail}: largest standard deviation in {length:.4g} m": (
                          1e3 * spread, "mm"),
                      f"{name}, {rail}: middle of this window": (where, "m"),
                      f"{name}, {rail}: largest deviation": (1e3 * np.abs(one).max(), "mm")}
    for base in bases if len(rails) == 2 else ():
        x, slope = twist(level, base)
        found[f"twist over {base:g} m: largest"] = (1e3 * np.abs(slope).max(), "mm/m")
        found[f"twist over {base:g} m: location of the largest"] = (x[np.argmax(np.abs(slope))],
                                                                    "m")
    return found


def classes(level: Level, speed: float, window: float = WINDOW) -> dict[str, str]:
    """Rail -> its class of EN 13848-6, A to E, by the largest standard deviation in D1 within
    `window` m; none at speeds, km/h, for which the limits are not known."""
    name = "D1"
    known = [limits for (above, most), limits in CLASSES.items() if above < speed <= most]
    if name not in (bands := bands_of(level)) or not known:
        return {}
    rows, limits = inner(level, name), known[0]
    spreads = [1e3 * worst_window(level.x[rows], one, window)[0] for one in bands[name][rows].T]
    return {rail: "ABCDE"[int(np.searchsorted(limits, spread))]
            for rail, spread in zip(rails_of(level), spreads)}


def limited(level: Level, quantity: str, window: float = WINDOW
            ) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """What limits of a quantity apply to: name, x, values in the unit of the limit; nothing if the
    record does not have it."""
    if base := geometry_limits.base_of(quantity):
        if level.height.shape[1] != 2 or not level.step <= base < level.length:
            return []
        x, slope = twist(level, base)
        return [(f"twist over {base:g} m", x, 1e3 * slope)]
    band = quantity.removesuffix(" sd")
    if band not in (bands := bands_of(level)):
        return []
    rows, found = inner(level, band), []
    for rail, values in zip(rails_of(level), 1e3 * bands[band][rows].T):
        name, x = f"{band}, {rail}", level.x[rows]
        if quantity != band:
            x, values, length = sliding(x, values, window)
            name += f", sd in {length:.4g} m"
        found.append((name, x, values))
    return found


def judged(level: Level, limits: geometry_limits.Limits,
           window: float = WINDOW) -> list[geometry_limits.Judged]:
    """The sections beyond each limit."""
    return [geometry_limits.Judged(name, kind, limit, geometry_limits.unit_of(quantity),
                                   geometry_limits.sections(x, values, limit))
            for quantity, levels in limits.of.items()
            for name, x, values in limited(level, quantity, window)
            for kind, limit in levels.items()]


def beyond_limits(level: Level, limits: geometry_limits.Limits, bases: Bases = BASES,
                  window: float = WINDOW) -> list[str]:
    """Lines of the table: limits and the sections beyond them, and what is not judged."""
    lines = [line for one in judged(level, limits, window) for line in one.words()]
    for name in bands_of(level):
        rows = inner(level, name)
        if not {name, f"{name} sd"} & limits.of.keys():
            lines.append(f"  {name}: no limit is known at this speed")
        elif (rows.start, rows.stop) != (0, len(level.x)):
            lines.append(f"    {name} judged from {level.x[rows][0]:.4g} to "
                         f"{level.x[rows][-1]:.4g} m: beyond, the filter reaches the ends of the "
                         "record")
    lines += [f"  twist over {base:g} m: no limit is known{limits.unknown}"
              for base in (bases if level.height.shape[1] == 2 else ())
              if geometry_limits.twist_name(base) not in limits.of]
    return [*lines, f"  {limits.source}"]


def rails_of(level: Level) -> tuple[str, ...]:
    return ("left rail", "right rail") if level.height.shape[1] == 2 else ("rail",)


def mark_limits(panels: dict[str, Axes], limits: geometry_limits.Limits, bases: Bases) -> None:
    """Limits in the panels of the bands, and of the twist over `bases`."""
    for name, panel in panels.items():
        most = max((float(np.abs(line.get_ydata()).max()) for line in panel.lines), default=0.0)
        names = list(map(geometry_limits.twist_name, bases)) if name == "twist" else [name]
        for one in names:
            geometry_limits.mark(panel, limits.of.get(one, {}), geometry_limits.unit_of(one), most,
                                 f"{one}, " if len(names) > 1 else "")


def draw(levels: collections.abc.Sequence[Level], bases: Bases = BASES,
         limits: geometry_limits.Limits | None = None) -> plt.Figure:
    shown = [name for name in BANDS if any(name in bands_of(one) for one in levels)]
    both = any(one.height.shape[1] == 2 for one in levels)
    if not shown and not both:
        raise read.Unreadable("no band can be computed: " + "; ".join(
            f"{one.name}: {why_not(one, 'D1')} (D1)" for one in levels))
    figure, panels = plt.subplots(len(shown) + both, 1, sharex=True, squeeze=False,
                                  figsize=(10, 2.6 * (len(shown) + both)))
    for level, style in zip(levels, LINES):
        bands = bands_of(level)
        for panel, name in zip(panels[:, 0], shown):
            for side, rail in enumerate(bands.get(name, np.empty((0, 0))).T):
                of = ("", ", left", ", right")[side + (level.height.shape[1] == 2)]
                panel.plot(level.x, 1e3 * rail, style, lw=0.8, color=f"C{side}",
                           label=f"{level.name}{of}")
        for number, base in enumerate(bases if level.height.shape[1] == 2 else ()):
            x, slope = twist(level, base)
            panels[-1, 0].plot(x, 1e3 * slope, style, lw=0.8, color=f"C{number}",
                               label=f"{level.name}, base of {base:g} m")
    for panel, name in zip(panels[:, 0], shown):
        low, high = BANDS[name]
        panel.set_ylabel(f"{name}, {low:g} to {high:g} m,\nzero phase: level (mm)")
    if both:
        panels[-1, 0].set_ylabel("twist (mm/m)")
    if limits:
        mark_limits(dict(zip([*shown, *(["twist"] if both else [])], panels[:, 0])), limits, bases)
    for panel in panels[:, 0]:
        panel.grid(alpha=0.3)
        legend_above(panel)
    title = "Longitudinal level" if shown else "Twist"
    title_above(panels[0, 0], wrapped(f"{title}; {limits.source}" if limits else title, 10))
    panels[-1, 0].set_xlabel("x along the track (m)")
    return figure


def write_exceedances(levels: collections.abc.Sequence[Level], limits: geometry_limits.Limits,
                      folder: write.Folder, window: float) -> None:
    """exceedances.csv: all sections of all records."""
    rows = [row for level in levels for one in judged(level, limits, window)
            for row in one.rows(level.name)]
    folder.file("exceedances.csv", "\n".join([geometry_limits.EXCEEDANCES, *rows]) + "\n")


def draw_into(sources: collections.abc.Sequence[pathlib.Path | str], folder: write.Folder,
              choices: Choices = Choices()) -> None:
    """Picture geometry and table geometry.txt of files or runs."""
    bases, window, limits = choices.bases, choices.window, choices.limits()
    if len(sources) > len(LINES):
        raise read.Unreadable(f"give at most {len(LINES)} files or runs")
    if choices.deck and len(sources) > 1:
        raise read.Unreadable("--irregularity: give one file")
    levels = [load(one) for one in sources]
    for level in levels:
        if not LEAST * level.step <= window < np.inf:
            raise read.Unreadable(f"--window {window:g}: must be at least {LEAST} steps of "
                                  f"{level.name}, {LEAST * level.step:g} m")
    for name, text in irregularities(levels[0]).items() if choices.deck else ():
        folder.file(name, text)
    figure = draw(levels, bases, limits)
    figure.tight_layout()
    folder.picture("geometry", figure)
    if limits:
        write_exceedances(levels, limits, folder, window)
    if limits and not choices.limits_file:
        folder.file(TEMPLATE, geometry_limits.template(bases))
    folder.table("geometry.txt", "".join(f"{line}\n" for level in levels
                                         for line in lines_of(level, choices, limits)))


def lines_of(level: Level, choices: Choices,
             limits: geometry_limits.Limits | None) -> list[str]:
    """Those of the table for one record."""
    lines = [f"{level.name}, {level.x[0]:g} to {level.x[-1]:g} m"]
    lines += [f"  {name:<62}{value:12.5g} {unit}"
              for name, (value, unit) in numbers(level, choices.bases, choices.window).items()]
    speed = choices.speed
    for rail, letter in classes(level, speed, choices.window).items() if speed is not None else ():
        lines.append(f"  {f'D1, {rail}: class of EN 13848-6 at {speed:g} km/h':<62}{letter:>12}")
    lines += beyond_limits(level, limits, choices.bases, choices.window) if limits else []
    lines += [f"  no {name}: {why}" for name in BANDS if (why := why_not(level, name))]
    return lines + [f"  {remark}" for remark in level.remarks]
