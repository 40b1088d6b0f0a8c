"""Peaks of spectra at the passing frequencies of a train, of one run or of two judged together.

A single vehicle has a spectrum of lobes about v/L_c apart, each of which is the highest one
somewhere: a lobe is a peak only if it is clearly higher than what is beside it. Of two runs a lobe
near this limit counts as in the other run, so that no difference is stated that is none.
"""
from __future__ import annotations

import dataclasses

import numpy as np
import scipy.signal

from trackbed_post import frequencies

STANDS_OUT = 1.5   # times the largest amplitude beside it, a lobe is a peak
NEARLY = 1.25      # times the same, if it is a peak in the other run
LEAST = 0.02       # of the highest lobe; lower ones may be side lobes
MANY = 10          # times; a larger ratio is not stated

Spectrum = tuple[np.ndarray, np.ndarray]  # frequency, Hz, and amplitude


@dataclasses.dataclass(frozen=True)
class Lobe:
    """The highest lobe near a passing frequency. `ratio`: of its amplitude to the largest one
    beside it; zero if only the flank of a lobe further away is there."""
    frequency: float
    amplitude: float
    ratio: float
    high: bool         # at least LEAST of the highest lobe
    reach: float       # Hz, that was searched on both sides
    peak: bool = False

    def words(self, unit: str) -> str:
        """What a table says of it."""
        times = f"{self.ratio:.1f}" if self.ratio < MANY else f"more than {MANY}"
        beside = f"{times} times the largest amplitude beside it"
        if self.peak:
            return f"peak at {self.frequency:.2f} Hz, {self.amplitude:.3g} {unit}, {beside}"
        if not self.ratio:
            beside = "on the flank of a lobe further away"
        if not self.high:
            beside = f"below {LEAST:.0%} of the largest amplitude"
        most = "highest lobe" if self.ratio else "at most"
        return (f"no peak: {most} {self.amplitude:.3g} {unit} within {self.reach:.2g} Hz (at "
                f"{self.frequency:.2f} Hz), {beside}")


def lobe_near(spectrum: Spectrum, target: float, reach: float, beside: float) -> Lobe | None:
    """That within `reach` of a target, compared with what is within `beside` of it, Hz; None beyond
    the spectrum."""
    frequency, amplitude = spectrum
    near = np.flatnonzero(np.abs(frequency - target) <= reach)
    if not len(near):
        return None
    tops = np.intersect1d(near, scipy.signal.find_peaks(amplitude)[0])
    among = tops if len(tops) else near
    k = int(among[np.argmax(amplitude[among])])
    ratio = float(amplitude[k]) / _beside(spectrum, k, beside) if len(tops) else 0.0
    return Lobe(float(frequency[k]), float(amplitude[k]), ratio,
                bool(amplitude[k] >= LEAST * amplitude.max()), reach)


def _beside(spectrum: Spectrum, k: int, beside: float) -> float:
    """Largest amplitude within `beside`, Hz, of the maximum k, without its own lobe, which ends
    where the amplitude is lowest."""
    frequency, amplitude = spectrum
    falls = np.diff(amplitude) < 0
    before, behind = np.flatnonzero(falls[:k]), np.flatnonzero(~falls[k:])
    there = np.abs(frequency - frequency[k]) <= beside
    there[before[-1] + 1 if len(before) else 0:k + behind[0] + 1 if len(behind) else None] = False
    return float(np.max(amplitude[there], initial=np.finfo(float).tiny))


def lobes(spectrum: Spectrum, marks: dict[str, float], beside: float) -> dict[str, Lobe | None]:
    """Of each passing frequency."""
    return {name: lobe_near(spectrum, target, frequencies.reach(marks, name), beside)
            for name, target in marks.items()}


def judged(found: list[dict[str, Lobe | None]]) -> list[dict[str, Lobe | None]]:
    """The lobes of all runs, of which is known then whether they are peaks."""
    clear = {name for run in found for name, lobe in run.items()
             if lobe and lobe.high and lobe.ratio >= STANDS_OUT}
    return [{name: lobe and dataclasses.replace(
        lobe, peak=lobe.high and name in clear and lobe.ratio >= NEARLY)
             for name, lobe in run.items()} for run in found]
