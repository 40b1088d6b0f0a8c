"""The support stiffness of a sleeper, read from its way while a slow load goes from it.

A bed rings when its load changes, and a stone that slips meanwhile is a step in the way: the one
spoils slopes of parts of it, the other a slope of the whole. So all of it is fitted at once, by
least squares: way = straight line of the load + its curvature + ringing of one frequency whose
amplitude changes evenly + one slip. Frequency and place of the slip are searched. The slip is taken
only if it is clear, or it would fit what else is not in the line.

What the stiffness is worth: its standard error by a jackknife over blocks of the fall (Kuensch
1989, doi:10.1214/aos/1176347265; what is left of the fit is no white noise, so single rows would
promise too much), or, if that is more, half of what a slip that is not clear would change.
"""
from dataclasses import dataclass

import numpy as np

LEAST_ROWS = 24  # of the fall: six of a period of four
PERIODS = (2, 8)  # of the ringing in the fall; fewer is curvature, more hardly tilts the line
STEP = 0.25  # between frequencies tried, periods: the nearest is off by an eighth at the end
SLIPS, MARGIN = 600, 0.05  # places tried; share of rows at either end where a slip tilts nothing
CLEAR = 0.4  # of the squares that are left, what may remain with a slip that is taken
BLOCKS = 8


@dataclass
class Support:
    """Way down is negative, as is the force on the seat."""
    stiffness: float  # N/m
    spread: float  # N/m
    ringing: float  # largest amplitude over the way
    slip: float  # over the way, 0: none

    def sinks(self):
        """Whether its sleeper clearly goes on sinking while its load goes."""
        return self.stiffness < -2 * self.spread

    def drowned(self):
        """Whether it says nothing; a spread that is no number says nothing either."""
        return not (self.stiffness > 0 and self.spread <= self.stiffness / 2)


def columns(load, periods):
    """Of the fit without slip; the second is the line."""
    along = 2 * (load - load.mean()) / np.ptp(load)
    turn = 2 * np.pi * periods * np.linspace(0, 1, len(load))
    fade = np.linspace(1, -1, len(load))
    waves = np.stack([np.cos(turn), np.sin(turn)])
    return np.stack([np.ones_like(load), along, along**2, *waves, *(fade * waves)], axis=1)


def slipped(rows):
    """[row, slip] that is 1 once it has happened."""
    edge = max(2, int(MARGIN * rows))
    places = np.unique(np.linspace(edge, rows - edge, SLIPS).astype(int))
    return (np.arange(rows)[:, None] >= places).astype(float)


def best(load, way):
    """Squares that are left and columns of the best fit without a slip, and of that with one."""
    slips, plain, with_slip = slipped(len(load)), (np.inf, None), (np.inf, None)
    for periods in np.arange(PERIODS[0], min(PERIODS[1], len(load) / 6) + STEP / 2, STEP):
        own = columns(load, periods)
        basis = np.linalg.qr(own)[0]
        left = way - basis @ (basis.T @ way)
        apart = slips - basis @ (basis.T @ slips)
        gain = (apart.T @ left)**2 / (apart**2).sum(axis=0)
        most = int(np.argmax(gain))
        if left @ left < plain[0]:
            plain = left @ left, own
        if left @ left - gain[most] < with_slip[0]:
            with_slip = left @ left - gain[most], np.column_stack([own, slips[:, most]])
    return plain, with_slip


def line(terms, way):
    """Share of each column."""
    return np.linalg.lstsq(terms, way, rcond=None)[0]


def jackknife(terms, way):
    """Standard error of the line."""
    rows = np.arange(len(way))
    without = [line(np.delete(terms, block, axis=0), np.delete(way, block))[1]
               for block in np.array_split(rows, BLOCKS)]
    return np.sqrt((BLOCKS - 1) * np.var(without))


def support(load, way):
    """From rows of the fall, at equal times: force on the sleeper (N) and its displacement (m)."""
    scale = max(np.ptp(way), np.finfo(float).tiny)
    way = (way - way.mean()) / scale
    plain, with_slip = best(load, way)
    clear = with_slip[0] < CLEAR * plain[0]
    terms = (with_slip if clear else plain)[1]
    shares = line(terms, way)
    tilt, off = shares[1], jackknife(terms, way)
    if not clear:
        off = max(off, abs(line(with_slip[1], way)[1] - tilt) / 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = np.ptp(load) / (2 * tilt * scale)
        waves = terms[:, 3:7] @ shares[3:7]
        return Support(stiffness, abs(stiffness) * off / abs(tilt),
                       np.abs(waves).max() / abs(2 * tilt),
                       abs(shares[7] / (2 * tilt)) if clear else 0.0)
