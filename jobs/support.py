"""The support stiffness of a sleeper, from its displacement while a slow load is removed.

A bed rings when its load changes, and a stone that slips causes a step in the displacement. Ringing
spoils slopes of parts of the record, a slip spoils the slope of the whole. Therefore all effects
are fitted at once by least squares: displacement = linear term in the load + curvature + ringing of
one frequency whose amplitude changes linearly + one slip. Frequency and time of the slip are
searched. The slip is included only if it is clear; otherwise it would fit other deviations from the
line.

Uncertainty of the stiffness: its standard error by a jackknife over blocks of the unloading
(Kuensch 1989, doi:10.1214/aos/1176347265; the residual is not white noise, so omitting single rows
would underestimate it), or, if larger, half of the change that an unclear slip would cause."""
from dataclasses import dataclass

import numpy as np

LEAST_ROWS = 24  # of the unloading: six per period for four periods
PERIODS = (2, 8)  # of ringing in the unloading; fewer is curvature, more hardly affects the slope
STEP = 0.25  # of the frequency search, periods: the error at the end is at most an eighth
SLIPS, MARGIN = 600, 0.05  # times tried; fraction of rows at either end where no slip is tried
CLEAR = 0.4  # a slip is included if it reduces the sum of squared residuals below this fraction
BLOCKS = 8


@dataclass
class Support:
    """Downward displacement and force on the seat are negative."""
    stiffness: float  # N/m
    spread: float  # N/m
    ringing: float  # largest amplitude over the displacement
    slip: float  # over the displacement, 0: none

    def keeps_settling(self):
        """Whether the sleeper clearly continues to settle during unloading."""
        return self.stiffness < -2 * self.spread

    def is_unreliable(self):
        """Whether the spread exceeds half the stiffness or is not a number."""
        return not (self.stiffness > 0 and self.spread <= self.stiffness / 2)


def columns(load, periods):
    """Columns of the fit without slip; the second is the linear term."""
    along = 2 * (load - load.mean()) / np.ptp(load)
    turn = 2 * np.pi * periods * np.linspace(0, 1, len(load))
    fade = np.linspace(1, -1, len(load))
    waves = np.stack([np.cos(turn), np.sin(turn)])
    return np.stack([np.ones_like(load), along, along**2, *waves, *(fade * waves)], axis=1)


def slipped(rows):
    """Step functions [row, slip]: 1 after the slip."""
    edge = max(2, int(MARGIN * rows))
    places = np.unique(np.linspace(edge, rows - edge, SLIPS).astype(int))
    return (np.arange(rows)[:, None] >= places).astype(float)


def best(load, displacement):
    """Sum of squared residuals and columns of the best fits without and with a slip."""
    slips, plain, with_slip = slipped(len(load)), (np.inf, None), (np.inf, None)
    for periods in np.arange(PERIODS[0], min(PERIODS[1], len(load) / 6) + STEP / 2, STEP):
        own = columns(load, periods)
        basis = np.linalg.qr(own)[0]
        left = displacement - basis @ (basis.T @ displacement)
        apart = slips - basis @ (basis.T @ slips)
        gain = (apart.T @ left)**2 / (apart**2).sum(axis=0)
        most = int(np.argmax(gain))
        if left @ left < plain[0]:
            plain = left @ left, own
        if left @ left - gain[most] < with_slip[0]:
            with_slip = left @ left - gain[most], np.column_stack([own, slips[:, most]])
    return plain, with_slip


def line(terms, displacement):
    """Coefficient of each column."""
    return np.linalg.lstsq(terms, displacement, rcond=None)[0]


def jackknife(terms, displacement):
    """Standard error of the coefficient of the linear term."""
    rows = np.arange(len(displacement))
    without = [line(np.delete(terms, block, axis=0), np.delete(displacement, block))[1]
               for block in np.array_split(rows, BLOCKS)]
    return np.sqrt((BLOCKS - 1) * np.var(without))


def support(load, displacement):
    """From equally spaced rows of the unloading: force on the sleeper, N, and displacement, m."""
    scale = max(np.ptp(displacement), np.finfo(float).tiny)
    displacement = (displacement - displacement.mean()) / scale
    plain, with_slip = best(load, displacement)
    clear = with_slip[0] < CLEAR * plain[0]
    terms = (with_slip if clear else plain)[1]
    coefficients = line(terms, displacement)
    tilt, off = coefficients[1], jackknife(terms, displacement)
    if not clear:
        off = max(off, abs(line(with_slip[1], displacement)[1] - tilt) / 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = np.ptp(load) / (2 * tilt * scale)
        waves = terms[:, 3:7] @ coefficients[3:7]
        return Support(stiffness, abs(stiffness) * off / abs(tilt),
                       np.abs(waves).max() / abs(2 * tilt),
                       abs(coefficients[7] / (2 * tilt)) if clear else 0.0)
