"""Profiles of wheels: S1002, with a hollow tread on request, and measured ones.

    profile = profiles.of("s1002")              # or "s1002:hollow:2", 2 mm, or a file
    profile.growth(s)                           # m, of the radius beyond that at s = 0

s is the distance from the tread datum, 70 mm from the back of the flange, towards the field side;
the flange has negative s.
"""
import dataclasses
import pathlib

import numpy as np

from trackbed_post import read
from trackbed_post.trajectory import scan

# Zones of S1002 with a flange of 28 mm (EN 13715, UIC 510-2), of the field side first: s from which
# a zone begins and its curve, mm. A polynomial has its coefficients from the constant on; an arc
# has the height of its centre, its radius and its centre's -s, and lies above (+1) or below it.
_S1002 = (
    (32.15796, (1.364323640, -0.066666667)),
    (-26.0, (0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8,
             -1.562379023e-8, 5.309217349e-15, -5.957839843e-12, 2.646656573e-13)),
    (-35.0, (-4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875, -2.054332446e-1,
             -4.169739389e-3, -4.687195829e-5, -2.252755540e-7)),
    (-38.426669071, {"centre": 16.446, "radius": 13.0, "at": 26.210665, "side": -1}),
    (-39.764473993, (-93.576667419, -2.747477419)),
    (-49.662510381, {"centre": 8.834924130, "radius": 20.0, "at": 58.558326413, "side": 1}),
    (-62.764705882, {"centre": 16.0, "radius": 12.0, "at": 55.0, "side": 1}),
    (-70.0, {"centre": 9.519259302, "radius": 20.5, "at": 49.5, "side": 1}))
FIELD_SIDE = 60.0  # mm, where S1002 ends
STEP = 0.1         # mm, between samples of a profile
HOLLOW_WIDTH = 60.0  # mm, of a hollow around the tread datum


@dataclasses.dataclass(frozen=True)
class Profile:
    """A wheel: `s` ascending, m, and the growth of its radius there, m; straight lines between."""
    name: str
    s: np.ndarray
    grown: np.ndarray

    def growth(self, s):
        """m; minus infinity beside the wheel."""
        return np.interp(s, self.s, self.grown, left=-np.inf, right=-np.inf)


def s1002(s):
    """Growth of the radius in mm at s in mm, from -70 to 60."""
    s = np.asarray(s, float)
    found = np.full(s.shape, np.nan)
    above = FIELD_SIDE
    for low, curve in _S1002:
        inside = (s >= low) & (s <= above) & np.isnan(found)
        at = s[inside]
        if isinstance(curve, dict):
            found[inside] = curve["centre"] + curve["side"] * np.sqrt(
                curve["radius"]**2 - (at + curve["at"])**2)
        else:
            found[inside] = np.polynomial.polynomial.polyval(at, curve)
        above = low
    return found


def _hollow(name, depth):
    """S1002 whose tread is worn by a squared cosine of this depth, mm."""
    s = np.arange(-700, 10 * FIELD_SIDE + 1) * STEP
    worn = np.where(np.abs(s) < HOLLOW_WIDTH / 2,
                    depth * np.cos(np.pi * s / HOLLOW_WIDTH)**2, 0.0)
    return Profile(name, 1e-3 * s, 1e-3 * (s1002(s) - worn))


def _of_file(path):
    columns = scan.lengths_of(path, ("s", "growth"))
    if len(columns["s"]) < 2 or np.any(np.diff(columns["s"]) <= 0):
        raise read.Unreadable(f"{path}: a profile needs two rows or more in ascending s")
    return Profile(path.stem, columns["s"], columns["growth"])


def of(text):
    """The profile that a word of the command line names."""
    kind, *rest = text.split(":")
    if kind != "s1002":
        return _of_file(pathlib.Path(text))
    if not rest:
        return _hollow("s1002", 0.0)
    try:
        word, depth = rest[0], float(rest[1])
        fits = word == "hollow" and len(rest) == 2 and 0 <= depth <= 10
    except (IndexError, ValueError):
        fits = False
    if not fits:
        raise read.Unreadable(f"{text}: give s1002, s1002:hollow:MM with a depth up to 10 mm, or a "
                              "file of a profile")
    return _hollow(f"s1002 hollow {depth:g} mm", depth)
