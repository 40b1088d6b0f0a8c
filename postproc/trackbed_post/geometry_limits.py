"""Limits of single deviations of a track geometry at a speed, and the sections beyond them.

Immediate action limits of EN 13848-5:2008+A1:2010 for the longitudinal level, mean to peak, and of
the decision 2011/275/EU for twist, from memory: not verified against these texts.
"""
import collections.abc
import typing

import numpy as np

from trackbed_post import read

Value = typing.TypeVar("Value")
Section = tuple[float, float, float]  # first x, last x, largest value
# km/h, above the first and up to the second -> band -> mm.
LEVEL = {(0, 80): {"D1": 28.0}, (80, 120): {"D1": 26.0}, (120, 160): {"D1": 23.0},
         (160, 230): {"D1": 20.0, "D2": 33.0}, (230, 300): {"D1": 16.0, "D2": 28.0}}
TWIST = {(0, 200): 7.0, (200, 300): 5.0}  # mm/m, the most over any base
TWIST_BASES = (1.3, 20.0)                 # m
LISTED = 10  # sections
SOURCE = ("limits: level EN 13848-5:2008, twist 2011/275/EU, from memory, not verified against the "
          "texts")


def at(table: dict[tuple[int, int], Value], speed: float) -> Value:
    """The value at a speed, km/h."""
    for (above, most), value in table.items():
        if above < speed <= most:
            return value
    raise read.Unreadable(f"--speed {speed:g}: limits are known above 0 and up to 300 km/h; leave "
                          "the option out")


def twist_limit(base: float, speed: float) -> float | None:
    """mm/m over `base` m: 20/base + 3, but not more than the table; None for other bases."""
    low, high = TWIST_BASES
    return min(20 / base + 3, at(TWIST, speed)) if low <= base <= high else None


def sections(x: np.ndarray, values: np.ndarray, limit: float) -> list[Section]:
    """The runs of neighbouring places where |values| is above the limit; x in m, values in the
    unit of the limit."""
    size = np.abs(values)
    beyond = np.concatenate([[0], (size > limit).astype(int), [0]])
    starts, ends = np.flatnonzero(np.diff(beyond) == 1), np.flatnonzero(np.diff(beyond) == -1)
    return [(x[a], x[b - 1], size[a:b].max()) for a, b in zip(starts, ends)]


def words(name: str, limit: float, unit: str,
          found: collections.abc.Sequence[Section]) -> list[str]:
    """Lines of the table; the worst sections in the order of x."""
    lines = [f"  {f'{name}: immediate action limit':<62}{limit:12.5g} {unit}",
             f"  {f'{name}: sections above it':<62}{len(found):12d}"]
    worst = sorted(sorted(found, key=lambda section: -section[2])[:LISTED])
    if len(worst) < len(found):
        lines.append(f"    the {LISTED} worst of them:")
    return lines + [f"    {first:.4g} to {last:.4g} m: {largest:.4g} {unit}"
                    for first, last, largest in worst]
