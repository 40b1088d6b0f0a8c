"""Displacement of a sleeper from its acceleration during the passage of a train.

Both methods integrate twice in the frequency domain and use that the sleeper rests between bogies.
`high_pass` is that of the thesis (its section 5.5): a high-pass filter, whose frequency a search
chooses, and a baseline through the positions at rest. `smoothing` (default) instead estimates the
drift: that of white noise of the sensor, integrated twice, and of a slowly changing offset, such
that the sleeper is at its position of rest wherever it is quiet; this position sinks if the sleeper
settles. This is a least-squares problem (a smoothing spline, Wahba 1990,
doi:10.1137/1.9781611970128), which also gives the standard deviation of the displacement. Where
both differ from the thesis: docs/monitoring.md.
"""
import dataclasses

import numpy as np
import scipy.fft
import scipy.interpolate
import scipy.linalg
import scipy.signal

from trackbed_post import read

WINDOW = 2.0          # m, of the moving mean of squares
THRESHOLD = 0.02      # of its largest value: below, the sleeper rests
BAND = (20.0, 1.5)    # m, wavelengths of the signal that counts: neither drift nor impacts
BASELINE = 10.0       # m, cut-off of the baseline of `high_pass`
HIGHEST = 2.0         # Hz, of the high-pass filter
STEPS = (0.2, 0.04)   # Hz, of its search
CELL = 2.0            # m of train over which the drift is resolved
DEFLECTION = 6.0      # m, wavelength of the deflection below an axle: acceleration to displacement
UPLIFT = 0.1          # of that, which a sleeper that seems to rest may be lifted
FLOOR = 0.003         # of the largest deflection: uncertainty of a position at rest
LEAST_REST = 0.05     # of the record must be at rest
OFFSET = 2            # order of the polynomial of the sensor's offset
SLOW = 1.0            # m, wavelength: longer ones choose the high-pass filter
NOISE_BAND = (3.0, 1.5)  # m, shorter than what distant axles cause
QUIETEST = 0.05       # of what is at rest, whose loudness is taken for noise
QUIET_NOISE = 0.10    # loudness of that part of white noise over its mean, measured
SETTLES = 0.5         # of the largest deflection: settlement that is expected, if any
SIGNIFICANT = 3.0     # standard deviations by which settlement must improve the fit
MOST_CELLS = 1500     # of a record: 3 km of train
TRUSTED = 4.0         # largest misfit that noise explains: 2.7 in passages without a fault
METHODS = ("smoothing", "high_pass")


@dataclasses.dataclass(frozen=True)
class Reconstruction:
    """Displacement, m, upwards positive, zero at rest, and its standard deviation; where the
    sleeper rests; high-pass frequency, Hz, or 0; noise of a sample, m/s2 (noise_of); largest
    residual of the equations over its standard deviation: above TRUSTED something other than noise
    moves the signal; settlement during the passage, m, downwards, and its standard deviation, or
    0 if none is noticed (only by smoothing); whether the sensor is mounted upside down, so that its
    signal was reversed."""
    displacement: np.ndarray
    deviation: np.ndarray
    at_rest: np.ndarray
    high_pass: float
    noise: float
    misfit: float
    settlement: tuple
    reversed: bool

    @property
    def peak(self):
        """Largest downward displacement, m, and its standard deviation."""
        at = int(np.argmin(self.displacement))
        return -float(self.displacement[at]), float(self.deviation[at])


def reconstruct(acceleration, rate, speed, method="smoothing", doubtful=None, noise=None):
    """A Reconstruction. `doubtful`: samples that were clipped or interpolated, which count less.
    `noise`: standard deviation of the sensor's noise in a sample, m/s2, if it is known; otherwise
    that of the quietest part, which contains what the sleeper still moves. Raises read.Unreadable
    if the record is too short or the sleeper does not rest."""
    acceleration = np.asarray(acceleration, float)
    refuse_useless(acceleration, rate, speed, method)
    loudness = loudness_of(acceleration, rate, speed)
    at_rest = rests(loudness, loudness.max())
    cells = Cells(acceleration, rate, speed, loudness, doubtful)
    if at_rest.mean() < LEAST_REST or np.sum(cells.at_rest) < OFFSET + 3:
        raise read.Unreadable(f"the sleeper rests for {100 * at_rest.mean():.2g} % of the record, "
                              f"but {100 * LEAST_REST:g} % are needed: record before and after the "
                              "train, too")
    if noise is None:
        noise = noise_of(acceleration, rate, speed, at_rest)
    high_pass, deviation, misfit = 0.0, np.full(len(acceleration), np.nan), np.nan
    settlement, sign = (0.0, 0.0), 1
    if method == "high_pass":
        displacement, high_pass = by_high_pass(acceleration, rate, speed, at_rest)
        sign = -1 if is_upside_down(displacement) else 1
        displacement = sign * displacement
    else:
        smoothing = Smoothing(acceleration, rate, cells, noise)
        if is_upside_down(smoothing.displacement(smoothing.still)):
            sign, smoothing = -1, Smoothing(-acceleration, rate, cells, noise)
        solution = smoothing.best()
        displacement, deviation = smoothing.displacement(solution), smoothing.deviation(solution)
        misfit, settlement = solution.misfit, solution.settlement
    return Reconstruction(displacement, deviation, at_rest, high_pass, noise, misfit, settlement,
                          sign < 0)


def is_upside_down(displacement):
    """Of a sensor, by the displacement from its signal."""
    return bool(displacement.max() > 2 * -displacement.min())


def refuse_useless(acceleration, rate, speed, method):
    if method not in METHODS:
        raise read.Unreadable(f'"{method}" is no method; these are {", ".join(METHODS)}')
    if not np.all(np.isfinite(acceleration)):
        raise read.Unreadable("the acceleration has samples that are not numbers")
    if not speed > 0:
        raise read.Unreadable(f"the speed is {speed:g} m/s: it must be above 0")
    if rate * BAND[1] < 2.5 * speed:
        raise read.Unreadable(f"{rate:g} samples per second are too few for {speed:g} m/s: "
                              f"{2.5 * speed / BAND[1]:.3g} are needed")
    length = len(acceleration) * speed / rate  # m
    if not 2 * BAND[0] < length < MOST_CELLS * CELL:
        raise read.Unreadable(f"{length:.3g} m of train pass in the record of "
                              f"{len(acceleration) / rate:.3g} s: it must be more than "
                              f"{2 * BAND[0]:g} m and less than {MOST_CELLS * CELL:g} m")
    if not np.ptp(acceleration) > 0:
        raise read.Unreadable("the acceleration is constant: no train is recorded")


def rests(loudness, largest):
    return loudness < THRESHOLD * largest


def noise_of(acceleration, rate, speed, at_rest):
    """Standard deviation of a sample, m/s2, of white noise that is as strong in NOISE_BAND as the
    quietest part of the signal at rest. Not of the whole signal: sensors sample faster than they
    measure, so that their noise is not white up to half the rate."""
    low, high = speed / NOISE_BAND[0], speed / NOISE_BAND[1]
    loudness = loudness_of(acceleration, rate, speed, NOISE_BAND)[at_rest]
    quiet = max(np.quantile(loudness, QUIETEST), 0) / QUIET_NOISE
    return float(np.sqrt(quiet * rate / 2 / (high - low)))


def loudness_of(acceleration, rate, speed, band=BAND):
    """Moving mean square of the acceleration in a band of wavelengths, m, in m2/s4. The thesis
    squares the whole signal; impacts at a crossing, a hundred times as large as what axles cause,
    would hide these."""
    edges = (speed / band[0], speed / band[1])
    sections = scipy.signal.butter(2, edges, "bandpass", fs=rate, output="sos")
    square = scipy.signal.sosfiltfilt(sections, acceleration)**2
    return moving_mean(square, WINDOW / speed * rate)


def moving_mean(values, samples):
    half = max(int(samples) // 2, 1)
    total = np.cumsum(np.pad(values, (half + 1, half), mode="edge"))
    return (total[2 * half + 1:] - total[:-2 * half - 1]) / (2 * half + 1)


def integrated(acceleration, rate, above=0.0):
    """Twice, without lines up to `above` Hz. Zeros are appended until lines are 0.04 Hz apart."""
    count = scipy.fft.next_fast_len(max(2 * len(acceleration), int(rate / STEPS[1])), real=True)
    lines = scipy.fft.rfft(acceleration, count)
    frequency = scipy.fft.rfftfreq(count, 1 / rate)
    kept = (frequency > above) & (frequency > 0)
    lines[kept] /= -(2 * np.pi * frequency[kept])**2
    lines[~kept] = 0
    return scipy.fft.irfft(lines, count)[:len(acceleration)]


def by_high_pass(acceleration, rate, speed, at_rest):
    """(displacement, frequency of the filter). The search minimises the sum of upward displacement
    times the standard deviation, first in coarse, then in fine steps; wavelengths below SLOW do not
    matter to it, so it uses fewer samples."""
    time = np.arange(len(acceleration)) / rate
    fit = np.polynomial.Polynomial.fit(time, acceleration, 2)
    level = acceleration - fit(time)
    every = max(int(rate * SLOW / (4 * speed)), 1)
    slow = scipy.signal.resample_poly(level, 1, every)
    slow_at_rest = at_rest[::every][:len(slow)]

    def based(signal, step, rest, above):
        found = integrated(signal, 1 / step, above)
        at = np.flatnonzero(rest)
        line = np.interp(np.arange(len(found)), at, found[at])
        sections = scipy.signal.butter(2, speed / BASELINE, fs=1 / step, output="sos")
        return found - scipy.signal.sosfiltfilt(sections, line)

    def cost(above):
        found = based(slow, every / rate, slow_at_rest, above)
        return np.sum(np.maximum(found, 0)) * found.std()

    coarse = np.arange(STEPS[0], HIGHEST + STEPS[1] / 2, STEPS[0])
    middle = min(coarse, key=cost)
    fine = middle + STEPS[1] * np.arange(-4, 5)
    best = min(fine[(fine > 0) & (fine <= HIGHEST)], key=cost)
    return based(level, 1 / rate, at_rest, best), float(best)


class Cells:
    """Means over stretches of CELL: time, s; loudness, m2/s4; fraction of doubtful samples."""

    def __init__(self, acceleration, rate, speed, loudness, doubtful):
        self.samples = max(int(round(CELL / speed * rate)), 1)
        self.speed, self.step = speed, self.samples / rate  # s
        self.count = len(acceleration) // self.samples
        self.time = self.mean(np.arange(len(acceleration)) / rate)
        self.loudness = self.mean(loudness)
        self.doubtful = np.zeros(self.count)
        if doubtful is not None:
            # An unknown impulse in a cell bends the drift of both neighbours, too.
            share = np.pad(self.mean(np.asarray(doubtful, float)), 1)
            self.doubtful = np.maximum.reduce([share[:-2], share[1:-1], share[2:]])
        self.largest = np.sqrt(self.mean(acceleration**2).max())  # m/s2
        self.at_rest = rests(self.loudness, loudness.max())

    def mean(self, values):
        return values[:self.count * self.samples].reshape(self.count, -1).mean(axis=1)


class Smoothing:
    """Least squares for the drift of each cell, the polynomial of the sensor's offset and, if the
    sleeper may settle, its settlement in each part of the train. Equations, each divided by its
    standard deviation: a cell at rest is as low as the sleeper has settled until then; the second
    difference of the drift is the offset."""

    def __init__(self, acceleration, rate, cells, noise):
        self.cells, self.time = cells, np.arange(len(acceleration)) / rate
        place = 2 * (np.arange(len(acceleration)) / max(len(acceleration) - 1, 1)) - 1
        self.powers = np.vander(cells.mean(place), OFFSET + 1)
        self.rest = np.flatnonzero(cells.at_rest)
        level, *_ = np.linalg.lstsq(self.powers[self.rest], cells.mean(acceleration)[self.rest],
                                    rcond=None)
        self.whole = integrated(acceleration - np.vander(place, OFFSET + 1) @ level, rate)
        deflection = (DEFLECTION / (2 * np.pi * cells.speed))**2  # m per m/s2
        # Within WINDOW positions err together, so that each of its cells counts less.
        self.unsure = np.sqrt(cells.loudness * (UPLIFT * deflection)**2 +
                              cells.loudness.max() * (FLOOR * deflection)**2
                              ) * np.sqrt(WINDOW / CELL)
        of_mean = np.hypot(noise / np.sqrt(cells.samples), cells.doubtful * cells.largest)
        self.of_mean = np.maximum(of_mean, 1e-4 * np.sqrt(cells.loudness.max()))[1:-1]
        self.settles = SETTLES * np.sqrt(cells.loudness.max()) * deflection  # m
        self.still = self.solve(0)

    def solve(self, steps):
        """A Solution. `steps`: number of settlements, 0 or one for each time that the sleeper
        comes to rest."""
        n, cells, rest, parts = self.cells.count, self.cells, self.rest, self.parts()
        drift, offset = np.zeros((n, n + OFFSET + 1 + steps)), slice(n, n + OFFSET + 1)
        drift[:, :n] = np.eye(n)
        at_rest = drift[rest]
        for step in range(steps):
            at_rest[parts > step, offset.stop + step] = -1
        bent = np.diff(drift, 2, axis=0) / cells.step**2
        bent[:, offset] += self.powers[1:-1]
        settled = np.eye(steps, drift.shape[1], offset.stop)
        system = np.vstack([at_rest / self.unsure[rest, None], bent / self.of_mean[:, None],
                            settled / self.settles])
        right = np.zeros(len(system))
        right[:len(rest)] = -cells.mean(self.whole)[rest] / self.unsure[rest]
        return Solution(system, right, n, steps)

    def parts(self):
        """Of each cell at rest: how often the sleeper has moved before."""
        return np.cumsum(np.r_[0, np.diff(self.rest) > 1])

    def best(self):
        """Without settlement, unless one explains the signal better than chance."""
        still, steps = self.still, int(self.parts().max())
        if steps == 0:
            return still
        moved = self.solve(steps)
        better = still.squares - moved.squares > SIGNIFICANT**2 + steps
        return moved if better and moved.settlement[0] > 0 else still

    def displacement(self, solution):
        drift = scipy.interpolate.CubicSpline(self.cells.time, solution.drift)
        return self.whole + drift(self.time)

    def deviation(self, solution):
        return np.interp(self.time, self.cells.time, solution.deviation)


class Solution:
    """Drift of each cell and its standard deviation, m; settlement, m, downwards, and its standard
    deviation; sum of squares and largest residual over its deviation."""

    def __init__(self, system, right, cells, steps):
        scale = np.sqrt((system**2).sum(axis=0))
        orthogonal, upper = scipy.linalg.qr(system / scale, mode="economic", check_finite=False)
        found = scipy.linalg.solve_triangular(upper, orthogonal.T @ right) / scale
        inverse = scipy.linalg.solve_triangular(upper, np.eye(len(upper))) / scale[:, None]
        residuals = system @ found - right
        self.drift = found[:cells]
        self.deviation = np.sqrt((inverse[:cells]**2).sum(axis=1))
        self.squares, self.misfit = float(residuals @ residuals), float(np.abs(residuals).max())
        last = slice(len(found) - steps, None)
        self.settlement = (-float(found[last].sum()),
                           float(np.sqrt((inverse[last].sum(axis=0)**2).sum()))
                           ) if steps else (0.0, 0.0)
