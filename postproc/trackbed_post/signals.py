"""Filters and spectra. The name of a filter is part of the label of every filtered quantity."""
import collections.abc
import dataclasses
import typing

import numpy as np
import scipy.ndimage
import scipy.signal

Values = typing.TypeVar("Values", float, np.ndarray)
Pole = tuple[float, float]  # frequency, Hz, and quality
EVEN_STEP = 1e-6  # relative: smaller differences of time steps are due to rounding


def are_even(steps: np.ndarray, time: np.ndarray) -> bool:
    """Whether some or all steps between these times are the same but for rounding."""
    return bool(np.ptp(steps) <= EVEN_STEP * np.max(steps) + 4 * np.spacing(np.abs(time[-1])))


def step_of(time: np.ndarray) -> float | None:
    """Length of the even time step, s; None if there are too few samples or they are uneven."""
    steps = np.diff(time)
    return float(np.mean(steps)) if len(steps) >= 2 and are_even(steps, time) else None


@dataclasses.dataclass(frozen=True)
class LowPass:
    """Butterworth filter applied forwards and backwards: no phase shift, twice the order, and an
    amplitude of 1/2 (not 1/sqrt 2) at the cut-off."""
    cut_off: float = 100.0  # Hz
    order: int = 4

    @property
    def name(self) -> str:
        return f"{self.cut_off:g} Hz Butterworth, zero phase"

    def obstacle(self, time: np.ndarray) -> str:
        """Why rows at these times cannot be filtered, or empty: the sampling rate must exceed twice
        the cut-off, and there must be enough rows."""
        dt, least = step_of(time), 6 * self.order + 1
        if dt is None:
            return "rows unevenly spaced"
        if 2 * self.cut_off * dt >= 1:
            return (f"rows are {1e3 * dt:.3g} ms apart, but must be less than "
                    f"{500 / self.cut_off:g} ms apart")
        return "" if len(time) >= least else f"{len(time)} rows, {least} needed"

    def name_for(self, time: np.ndarray) -> str:
        why = self.obstacle(time)
        return f"not filtered: {why}" if why else self.name

    def __call__(self, time: np.ndarray, values: np.ndarray, at_rest: bool = False) -> np.ndarray:
        """Filters along the first axis; returns the values unchanged if it does not apply.
        `at_rest`: they were zero before the first one."""
        values, dt = np.asarray(values), step_of(time)
        if dt is None or self.obstacle(time):
            return values
        before = int(np.ceil(10 / (self.cut_off * dt))) if at_rest else 0
        sections = scipy.signal.butter(self.order, self.cut_off, fs=1 / dt, output="sos")
        # Mirrored at the ends, as the usual point reflection would turn noise there into a step.
        whole = np.concatenate([np.zeros((before, *values.shape[1:])), values])
        return scipy.signal.sosfiltfilt(sections, whole, axis=0, padtype="even")[before:]


def _window(count: int) -> np.ndarray:
    """Tapers a twentieth of the record at each end."""
    return scipy.signal.windows.tukey(count, 0.1, sym=False)


def spectrum(time: np.ndarray, values: np.ndarray,
             resolution: float = 0.05) -> tuple[np.ndarray, np.ndarray]:
    """Amplitude spectrum along the first axis: (frequency Hz, |amplitude| in the values' unit).

    The mean is removed, a Tukey window tapers a twentieth of the record at each end, and zeros are
    appended until lines are at most `resolution` Hz apart. A sine of amplitude A over the whole
    record has a peak of A. The window is flat in between because a passage is a transient: a
    bell-shaped window would give axles different weights depending on when they pass.
    """
    dt = step_of(time)
    if dt is None:
        raise ValueError("a spectrum needs evenly spaced samples")
    window = _window(len(time))
    shape = (-1,) + (1,) * (np.ndim(values) - 1)
    centred = values - np.mean(values, axis=0)
    lines = max(len(time), int(np.ceil(1 / (resolution * dt))))
    amplitude = np.abs(np.fft.rfft(centred * window.reshape(shape), n=lines, axis=0))
    return np.fft.rfftfreq(lines, dt), amplitude * 2 / np.sum(window)


def peak_near(frequency: np.ndarray, amplitude: np.ndarray, target: float,
              reach: float = 0.3) -> float | None:
    """Frequency of the *inner* maximum nearest to target within `reach` (relative), among those at
    least half as high as the highest of them; None without any."""
    peaks, _ = scipy.signal.find_peaks(amplitude)
    near: list[int] = [k for k in peaks if abs(frequency[k] - target) <= reach * target]
    if not near:
        return None
    high = [k for k in near if amplitude[k] >= 0.5 * max(amplitude[near])]
    return float(frequency[min(high, key=lambda k: abs(frequency[k] - target))])


ENVELOPE = 0.05  # s, over which an envelope is a root mean square: some axles apart, not one wave


def envelope(time: np.ndarray, values: np.ndarray, step: float) -> np.ndarray:
    """Sliding root mean square of the difference from the mean, every `step` s from the first
    sample."""
    count = max(1, round(ENVELOPE / _even_step(time)))
    squares = scipy.ndimage.uniform_filter1d((values - np.mean(values))**2, count, mode="constant")
    places = np.arange(time[0], time[-1] + step / 2, step)
    return np.interp(places, time, np.sqrt(np.maximum(squares, 0)))


def shift_between(time: np.ndarray, values: np.ndarray, other_time: np.ndarray,
                  other_values: np.ndarray) -> tuple[float, float]:
    """(time, s, that has to be added to the other signal so that its envelope has the largest
    correlation with that of the first; this correlation, 1 for envelopes of the same shape)."""
    step = max(_even_step(time), _even_step(other_time))
    one, other = envelope(time, values, step), envelope(other_time, other_values, step)
    found = scipy.signal.correlate(one, other, method="fft")
    best = int(np.argmax(found))
    lag = int(scipy.signal.correlation_lags(len(one), len(other))[best])
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(time[0] - other_time[0]) + lag * step, float(found[best]) / max(size, 1e-300)


# Midband frequencies of third octaves and their edges, as ratios to 1000 Hz and to the midband
# frequency (IEC 61260-1:2014, system of base 10).
THIRD = 10 ** 0.1
EDGE = 10 ** 0.05
LEAST_LINES = 2  # of the spectrum in a band: a narrower band is not resolved by the record
NEAR_NYQUIST = 0.9  # of half the sampling rate, above which an anti-aliasing filter acts

COMFORT_INTERVAL = 5.0   # s, EN 12299:2009
COMFORT_STEP = 1 / 200   # s, largest of samples
MEAN_COMFORT_ROWS = 60   # intervals for the mean comfort: five minutes

# Reference values of levels, ISO 1683:2015, by the unit of the quantity.
REFERENCES = {"m/s2": 1e-6, "m/s": 1e-9, "m": 1e-12, "N": 1e-6}


def energies(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(Hz, mean square of each line) of a signal without its mean, one-sided: their sum is the mean
    square of the signal. The window is that of `spectrum`; its loss of energy is compensated."""
    dt = step_of(time)
    if dt is None:
        raise ValueError("a spectrum needs evenly spaced samples")
    window = _window(len(time))
    lines = np.fft.rfft((values - np.mean(values)) * window)
    energy = 2 * np.abs(lines)**2 / (len(time)**2 * np.mean(window**2))
    energy[0] /= 2
    if len(time) % 2 == 0:
        energy[-1] /= 2
    return np.fft.rfftfreq(len(time), dt), energy


def third_octaves(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(midband frequencies, Hz; root mean square in each band) of the bands that the record
    resolves. A line of the spectrum counts in each band by the fraction of its width there."""
    frequency, energy = energies(time, values)
    width = frequency[1]
    below = np.concatenate([[0.0], np.cumsum(energy)])  # energy below each edge of a line
    edges = np.concatenate([[0.0], frequency + width / 2])
    first = np.ceil(10 * np.log10(LEAST_LINES * width / (EDGE - 1 / EDGE) / 1000))
    last = np.floor(10 * np.log10(NEAR_NYQUIST * frequency[-1] / EDGE / 1000))
    middle = 1000 * THIRD ** np.arange(first, last + 1)
    inside = np.interp(middle * EDGE, edges, below) - np.interp(middle / EDGE, edges, below)
    return middle, np.sqrt(np.maximum(inside, 0))


def levels(amplitude: Values, unit: str) -> Values:
    """Levels, dB, of root mean squares or amplitudes in `unit` (REFERENCES)."""
    return 20 * np.log10(np.maximum(amplitude, 1e-300) / REFERENCES[unit])


def _weighting(frequency: np.ndarray, transition: Pole, step: tuple[Pole, Pole],
               gain: float) -> np.ndarray:
    """Band limits of 0.4 and 100 Hz, transition from acceleration to velocity, step up from one
    to another with this gain below it."""
    s = 2j * np.pi * np.asarray(frequency, dtype=float)

    def order_two(f: float, q: float) -> np.ndarray:
        w = 2 * np.pi * f
        return 1 + s / (q * w) + (s / w)**2

    low, high = order_two(0.4, np.sqrt(0.5)), order_two(100, np.sqrt(0.5))
    limits = (s / (2 * np.pi * 0.4))**2 / low / high
    to_velocity = (1 + s / (2 * np.pi * transition[0])) / order_two(*transition)
    return np.abs(limits * to_velocity * gain * order_two(*step[0]) / order_two(*step[1]))


def weighting_wk(frequency: np.ndarray) -> np.ndarray:
    """Magnitude of the weighting Wk of ISO 2631-1:1997, table A.1 (vertical acceleration of seated
    and standing persons)."""
    return _weighting(frequency, (12.5, 0.63), ((2.37, 0.91), (3.35, 0.91)), (2.37 / 3.35)**2)


def weighting_wb(frequency: np.ndarray) -> np.ndarray:
    """Magnitude of the weighting Wb of EN 12299:2009 (vertical acceleration of passengers)."""
    return _weighting(frequency, (16, 0.63), ((2.5, 0.8), (4, 0.8)), 0.4)


def _even_step(time: np.ndarray) -> float:
    dt = step_of(time)
    if dt is None:
        raise ValueError("the samples must be evenly spaced")
    return dt


def resolves_comfort(time: np.ndarray) -> bool:
    """Whether samples contain the band of the weightings Wk and Wb."""
    return _even_step(time) <= COMFORT_STEP * (1 + EVEN_STEP)


def weighted(time: np.ndarray, acceleration: np.ndarray,
             weighting: collections.abc.Callable = weighting_wk) -> np.ndarray:
    """The weighted acceleration, m/s2, of evenly spaced samples. The weighting is applied in the
    frequency domain without a phase, to the record continued by its mean, so that its end has no
    effect on its begin."""
    dt = _even_step(time)
    moving = np.concatenate([acceleration - np.mean(acceleration), np.zeros(len(time))])
    lines = np.fft.rfft(moving) * weighting(np.fft.rfftfreq(len(moving), dt))
    return np.fft.irfft(lines, len(moving))[:len(time)]


def weighted_rms(time: np.ndarray, acceleration: np.ndarray,
                 weighting: collections.abc.Callable[[np.ndarray], np.ndarray] = weighting_wk
                 ) -> float:
    """Root mean square of the weighted acceleration, m/s2, over the record."""
    return float(np.sqrt(np.mean(weighted(time, acceleration, weighting)**2)))


def transient(time: np.ndarray, acceleration: np.ndarray) -> tuple[float, float]:
    """(maximum transient vibration value, m/s2: largest root mean square in 1 s; vibration dose
    value, m/s^1.75) of ISO 2631-1:1997, 6.3, of the acceleration weighted by Wk. Of a record
    shorter than 1 s the first is the root mean square of the whole."""
    dt = _even_step(time)
    values = weighted(time, acceleration)
    count = min(len(values), max(1, round(1 / dt)))
    sums = np.concatenate([[0.0], np.cumsum(values**2)])
    running = (sums[count:] - sums[:-count]) / count
    return float(np.sqrt(running.max())), float((np.sum(values**4) * dt)**0.25)


def continuous_comfort(time: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """CC_z of EN 12299:2009, m/s2: root mean square, weighted by Wb, of each whole interval of 5 s;
    none of a record with fewer than 200 samples in a second, which does not contain the band of
    Wb."""
    if not resolves_comfort(time):
        return np.empty(0)
    dt = _even_step(time)
    squares = weighted(time, acceleration, weighting_wb)**2
    count = int(len(time) * dt / COMFORT_INTERVAL * (1 + 1e-9))
    ends = np.round(np.arange(count + 1) * COMFORT_INTERVAL / dt).astype(int)
    return np.sqrt([np.mean(squares[begin:end]) for begin, end in zip(ends, ends[1:])])


def mean_comfort(comfort: np.ndarray) -> np.ndarray:
    """Vertical part of the mean comfort N_MV of EN 12299:2009 of each five minutes of CC_z."""
    blocks = comfort[:len(comfort) // MEAN_COMFORT_ROWS * MEAN_COMFORT_ROWS]
    return 6 * np.percentile(blocks.reshape(-1, MEAN_COMFORT_ROWS), 95, axis=1)
