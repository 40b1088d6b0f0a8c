"""Vertical path of a wheel that rolls over a running surface without deforming it.

    path = contact.roll(grid, profile, lateral=0.0, radius=0.46)
    path.x, path.z, path.contact        # m; contact: y of the contact
"""
import dataclasses

import numpy as np

from trackbed_post import read

SPAN = 0.1    # m, over which the slopes before and behind a kink are averaged
BESIDE = 0.03  # m, over which the contact before and behind a jump is averaged
# m, by which the contact jumps from the wing rail to the nose, at least: on one rail it wanders by
# less.
MOVED = 15e-3
ROWS = 5e-3   # m, between rows of an irregularity
GAP = 0.02    # m, longest stretch of x without any scanned surface below the wheel
NEAR = 5e-3   # m, from the contact: a hole there may hide a higher surface
EDGE = 1e-3   # m, from the edge of the scan or of the profile


@dataclasses.dataclass(frozen=True)
class Path:
    """Of a wheel: x, height z of the lowest point of its circle at the tread datum, and y of the
    contact, m."""
    name: str
    x: np.ndarray
    z: np.ndarray
    contact: np.ndarray

    def irregularity(self):
        """m, heights above the straight line through both ends."""
        line = np.interp(self.x, self.x[[0, -1]], self.z[[0, -1]])
        return self.z - line

    def rows(self, origin=0.0, trailing=False):
        """(x in the track, ascending; irregularity), m, about every ROWS from end to end; `origin`:
        x of the scan's origin; `trailing`: trains run to smaller x of the scan."""
        count = max(int(round((self.x[-1] - self.x[0]) / ROWS)), 1) + 1
        x = np.linspace(self.x[0], self.x[-1], count)
        z = np.interp(x, self.x, self.irregularity())
        return (origin - x[::-1], z[::-1]) if trailing else (origin + x, z)

    def transition(self):
        """x at which the contact jumps most, m; nan if it stays on one rail."""
        count = int(round(BESIDE / (self.x[1] - self.x[0])))
        if len(self.x) <= 2 * count:
            return np.nan
        medians = np.median(np.lib.stride_tricks.sliding_window_view(self.contact, count), axis=1)
        jump = np.abs(medians[count:] - medians[:-count])
        at = int(np.argmax(jump))
        if not jump[at] > MOVED:
            return np.nan
        near = self.contact[at:at + 2 * count]  # the step is the largest one there
        return float(self.x[at + int(np.argmax(np.abs(np.diff(near))))] + self.x[1] / 2
                     - self.x[0] / 2)

    def dip(self):
        """(largest angle by which the path kinks upwards, rad; its x, m): difference of the mean
        slopes over SPAN behind and before."""
        count = int(round(SPAN / (self.x[1] - self.x[0])))
        if len(self.x) < 2 * count + 1:
            return np.nan, np.nan
        z = self.z
        kink = (z[2 * count:] - 2 * z[count:-count] + z[:-2 * count]) / (
            count * (self.x[1] - self.x[0]))
        at = int(np.argmax(kink))
        return float(kink[at]), float(self.x[count + at])


def sections(grid, profile, lateral, side=1):
    """Of each section at x: height at which the wheel would rest on it alone, and y of the contact,
    m; nan where the scan has a hole below the whole wheel. `lateral`: y of the tread datum; `side`:
    1 if the field side of the wheel is at larger y, -1 otherwise."""
    growth = profile.growth(side * (grid.y - lateral))
    below = np.isfinite(growth)
    if not below.any():
        raise read.Unreadable(f"the wheel at y = {lateral:g} m is beside the scan, which reaches "
                              f"from y = {grid.y[0]:.4g} to {grid.y[-1]:.4g} m")
    heights = np.where(np.isfinite(grid.z[:, below]), grid.z[:, below], -np.inf) + growth[below]
    at = np.argmax(heights, axis=1)
    height = heights[np.arange(len(at)), at]
    known = np.isfinite(height)
    return np.where(known, height, np.nan), np.where(known, grid.y[below][at], np.nan)


def roll(grid, profile, lateral=0.0, radius=0.46, side=1, name=""):
    """Path of a wheel that touches the highest of all sections below it: at x the section at x + d
    lifts it to its own height less the height of the wheel's circle there. Raises read.Unreadable
    if nothing is known below the wheel over more than GAP."""
    height, y = sections(grid, profile, lateral, side)
    known = np.flatnonzero(np.isfinite(height))
    if len(known) < 2:
        raise read.Unreadable(f"the wheel at y = {lateral:g} m has no scanned surface below it")
    x, height, y = (of[known[0]:known[-1] + 1] for of in (grid.x, height, y))
    step = x[1] - x[0]
    known -= known[0]
    longest = int(np.argmax(np.diff(known)))
    begin, end = x[known[longest]], x[known[longest + 1]]
    if end - begin > GAP + step:
        raise read.Unreadable(f"nothing was scanned below the wheel at y = {lateral:g} m from x = "
                              f"{begin:.4g} to {end:.4g} m; at most {GAP:g} m may be missing")
    height = np.where(np.isfinite(height), height, -np.inf)
    drop = np.ptp(height[known])
    # Sections further away would need a larger difference in height to touch, unless nothing is
    # known between; none further away than the radius touches.
    reach = radius if drop > radius else np.sqrt(drop * (2 * radius - drop))
    reach = min(int(max(reach, end - begin) / step) + 1, int(radius / step), len(x) - 1)
    z, contact = height.copy(), y.copy()
    for k in range(1, reach + 1):
        lowered = radius - np.sqrt(radius**2 - (k * step)**2)
        for here, there in ((slice(k, None), slice(None, -k)), (slice(None, -k), slice(k, None))):
            lifted = height[there] - lowered
            higher = lifted > z[here]
            z[here] = np.where(higher, lifted, z[here])
            contact[here] = np.where(higher, y[there], contact[here])
    return Path(name or profile.name, x, z, contact)


def stretches(x, wrong):
    """(first, last) x, m, of each run of wrong places, that may have gaps of up to GAP."""
    at = x[wrong]
    ends = np.flatnonzero(np.diff(at) > GAP) if len(at) else []
    return list(zip(at[[0, *(ends + 1)]], at[[*ends, -1]])) if len(at) else []


def warnings(path, grid, missing, profile, lateral, side=1):
    """Sentences on what may make the path wrong: contacts near `missing` places of the grid
    (scan.missing), at the edge of the scan, at the end of the profile or on the tip of the flange.
    """
    s = side * (path.contact - lateral)
    rows = np.searchsorted(grid.x, path.x - 1e-9)
    columns = np.clip(np.searchsorted(grid.y, path.contact), 0, len(grid.y) - 1)
    reach = int(round(NEAR / (grid.y[1] - grid.y[0])))
    holes = np.array([missing[row, max(column - reach, 0):column + reach + 1].any()
                      for row, column in zip(rows, columns)])
    kinds = ((holes, "the contact is beside a place that was not scanned"),
             ((path.contact < grid.y[0] + EDGE) | (path.contact > grid.y[-1] - EDGE),
              "the contact is at the edge of the scan"),
             ((s < profile.s[0] + EDGE) | (s > profile.s[-1] - EDGE),
              "the contact is at the end of the profile"),
             (np.abs(s - profile.s[np.argmax(profile.grown)]) < NEAR,
              "the wheel stands on its flange"))
    return [f"{path.name}: {what} between x = {first:.4g} and {last:.4g} m of the scan: its path "
            "may be wrong there"
            for wrong, what in kinds for first, last in stretches(path.x, wrong)]
