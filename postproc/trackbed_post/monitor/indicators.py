"""Indicators of the condition of a crossing: root mean squares of a signal in bands of wavelengths
(section 5.3 of the thesis)."""
import numpy as np
import scipy.fft

from trackbed_post import read
from trackbed_post.monitor import displacement

WAVELENGTHS = (1.0, 0.2)  # m, of the band
QUANTITIES = {"acceleration": 0, "velocity": 1, "displacement": 2}  # times integrated


def band(acceleration, rate, speed, wavelengths=WAVELENGTHS, quantity="acceleration"):
    """The part of the acceleration, velocity or displacement between both wavelengths, m; an ideal
    filter, as the thesis prefers."""
    low, high = speed / max(wavelengths), speed / min(wavelengths)
    if not high < rate / 2:
        raise read.Unreadable(f"the band of {wavelengths[0]:g} to {wavelengths[1]:g} m reaches "
                              f"{high:.4g} Hz at {speed:g} m/s, but {rate:g} samples per second "
                              f"contain only up to {rate / 2:g} Hz")
    count = scipy.fft.next_fast_len(len(acceleration) + int(rate / low), real=True)
    lines = scipy.fft.rfft(acceleration - np.mean(acceleration), count)
    frequency = scipy.fft.rfftfreq(count, 1 / rate)
    inside = (frequency >= low) & (frequency <= high)
    lines[~inside] = 0
    lines[inside] /= (2j * np.pi * frequency[inside])**QUANTITIES[quantity]
    return scipy.fft.irfft(lines, count)[:len(acceleration)]


def indicator(acceleration, rate, speed, wavelengths=WAVELENGTHS, quantity="acceleration",
              at_rest=None):
    """Root mean square of `band` while the train passes: from the first to the last sample at which
    the sleeper does not rest (`at_rest` of a Reconstruction, if there is one)."""
    if at_rest is None:
        loudness = displacement.loudness_of(acceleration, rate, speed)
        at_rest = displacement.rests(loudness, loudness.max())
    passing = np.flatnonzero(~at_rest)
    part = band(acceleration, rate, speed, wavelengths, quantity)[passing[0]:passing[-1] + 1]
    return float(np.sqrt(np.mean(part**2)))
