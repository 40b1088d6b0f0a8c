"""Filters and spectra. The name of a filter is part of the label of every filtered quantity."""
import dataclasses

import numpy as np
import scipy.signal

EVEN_STEP = 1e-6  # relative: smaller differences of time steps are due to rounding


def step_of(time):
    """Length of the even time step, s; None if there are too few samples or they are uneven."""
    steps = np.diff(time)
    if len(steps) < 2 or np.ptp(steps) > EVEN_STEP * np.max(steps) + 4 * np.spacing(time[-1]):
        return None
    return float(np.mean(steps))


@dataclasses.dataclass(frozen=True)
class LowPass:
    """Butterworth filter applied forwards and backwards: no phase shift, twice the order, and an
    amplitude of 1/2 (not 1/sqrt 2) at the cut-off."""
    cut_off: float = 100.0  # Hz
    order: int = 4

    @property
    def name(self):
        return f"{self.cut_off:g} Hz Butterworth, zero phase"

    def applies_to(self, time):
        """Whether the sampling rate exceeds twice the cut-off and there are enough samples."""
        dt = step_of(time)
        return dt is not None and 2 * self.cut_off * dt < 1 and len(time) > 6 * self.order

    def name_for(self, time):
        return self.name if self.applies_to(time) else (
            f"unfiltered: rows uneven, fewer than {6 * self.order + 1}, or "
            f"{500 / self.cut_off:g} ms or more apart")

    def __call__(self, time, values):
        """Filters along the first axis; returns the values unchanged if it does not apply."""
        if not self.applies_to(time):
            return np.asarray(values)
        sections = scipy.signal.butter(self.order, self.cut_off, fs=1 / step_of(time), output="sos")
        # Mirrored at the ends, as the usual point reflection would turn noise there into a step.
        return scipy.signal.sosfiltfilt(sections, values, axis=0, padtype="even")


def spectrum(time, values, resolution=0.05):
    """Amplitude spectrum along the first axis: (frequency Hz, |amplitude| in the values' unit).

    The mean is removed, a Tukey window tapers a twentieth of the record at each end, and zeros are
    appended until lines are at most `resolution` Hz apart. A sine of amplitude A over the whole
    record has a peak of A. The window is flat in between because a passage is a transient: a
    bell-shaped window would give axles different weights depending on when they pass.
    """
    dt = step_of(time)
    if dt is None:
        raise ValueError("a spectrum needs evenly spaced samples")
    window = scipy.signal.windows.tukey(len(time), 0.1, sym=False)
    shape = (-1,) + (1,) * (np.ndim(values) - 1)
    centred = values - np.mean(values, axis=0)
    lines = max(len(time), int(np.ceil(1 / (resolution * dt))))
    amplitude = np.abs(np.fft.rfft(centred * window.reshape(shape), n=lines, axis=0))
    return np.fft.rfftfreq(lines, dt), amplitude * 2 / np.sum(window)


def peak_near(frequency, amplitude, target, reach=0.3):
    """Frequency of the *inner* maximum nearest to target within `reach` (relative), among those at
    least half as high as the highest of them; None without any."""
    peaks, _ = scipy.signal.find_peaks(amplitude)
    near = [k for k in peaks if abs(frequency[k] - target) <= reach * target]
    if not near:
        return None
    high = [k for k in near if amplitude[k] >= 0.5 * max(amplitude[near])]
    return float(frequency[min(high, key=lambda k: abs(frequency[k] - target))])
