"""Peaks of spectra at the passing frequencies of a train, of one run or of two judged together.

A single vehicle has a spectrum of lobes about v/L_c apart, each of which is the highest one
somewhere: a lobe is a peak only if it is clearly higher than what is beside it. Of two runs a lobe
near this limit counts as in the other run, so that no difference is stated that is none.
"""
from __future__ import annotations

import dataclasses
import math

import numpy as np
import scipy.signal

from trackbed_post import frequencies

STANDS_OUT = 1.5   # times the largest amplitude beside it, a lobe is a peak
NEARLY = 1.25      # times the same, if it is a peak in the other run
LEAST = 0.02       # of the highest lobe; lower ones may be side lobes
MANY = 10          # times; a larger ratio is not stated
ROUNDING = 1e-9    # relative error of a product of floating-point numbers, and more

Spectrum = tuple[np.ndarray, np.ndarray]  # frequency, Hz, and amplitude


@dataclasses.dataclass(frozen=True)
class Lobe:
    """The highest lobe near a passing frequency. `ratio`: of its amplitude to the largest one
    beside it; zero if only the flank of a lobe further away is there, nan if nothing is beside it.
    `stated_at`: a nearer passing frequency that has the same maximum."""
    frequency: float
    amplitude: float
    ratio: float
    high: bool         # at least LEAST of the highest lobe
    reach: float       # Hz, that was searched on both sides
    peak: bool = False
    stated_at: str = ""
    unresolved: str = ""  # another passing frequency that the record does not distinguish from this

    def words(self, unit: str) -> str:
        """What a table says of it."""
        if self.stated_at:
            return f"no peak of its own: the same maximum as at {self.stated_at}, which is nearer"
        if self.unresolved:
            return (f"no peak: closer to {self.unresolved} than the resolution of the record "
                    f"(highest lobe {self.amplitude:.3g} {unit} at {self.frequency:.2f} Hz)")
        beside = "with nothing beside it to compare" if math.isnan(self.ratio) else \
            f"{_times(self.ratio)} times the largest amplitude beside it"
        if self.peak:
            return f"peak at {self.frequency:.2f} Hz, {self.amplitude:.3g} {unit}, {beside}"
        if not self.ratio:
            beside = "on the flank of a lobe further away"
        if not self.high:
            beside = f"below {LEAST:.0%} of the largest amplitude"
        most = "highest lobe" if self.ratio else "at most"
        return (f"no peak: {most} {self.amplitude:.3g} {unit} within {self.reach:.2g} Hz (at "
                f"{self.frequency:.2f} Hz), {beside}")


def _times(ratio: float) -> str:
    """A ratio; near the limits rounded down, so that none below a limit is stated as the limit."""
    if ratio >= MANY:
        return f"more than {MANY}"
    return f"{ratio:.1f}" if ratio >= 2 else f"{math.floor(100 * ratio + ROUNDING) / 100:.2f}"


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
    where the amplitude is lowest; nan if nothing else is there."""
    frequency, amplitude = spectrum
    falls = np.diff(amplitude) < 0
    before, behind = np.flatnonzero(falls[:k]), np.flatnonzero(~falls[k:])
    there = np.abs(frequency - frequency[k]) <= beside
    there[before[-1] + 1 if len(before) else 0:k + behind[0] + 1 if len(behind) else None] = False
    if not there.any():
        return math.nan
    return float(np.max(amplitude[there], initial=np.finfo(float).tiny))


def lobes(spectrum: Spectrum, marks: dict[str, float], beside: float,
          resolution: float = 0.0) -> dict[str, Lobe | None]:
    """Of each passing frequency. A maximum that is near two of them is that of the nearest.
    `resolution` of the record, Hz: of two passing frequencies that are closer than this neither has
    a peak, as it could be that of the other. How far a maximum may be from its own frequency does
    not follow from the resolution but from the train (frequencies.reach): the slope of one factor
    of its spectrum shifts the maximum of another, in records of any length."""
    found = {name: lobe_near(spectrum, target, frequencies.reach(marks, name), beside)
             for name, target in marks.items()}

    def nearest(lobe: Lobe) -> str:
        same = [name for name, other in found.items()
                if other and other.ratio and other.frequency == lobe.frequency]
        return min(same, key=lambda name: abs(marks[name] - lobe.frequency))

    def too_near(name: str) -> str:
        return next((one for one in marks if one != name
                     and abs(marks[one] - marks[name]) < resolution), "")
    return {name: lobe and dataclasses.replace(
        lobe, unresolved=too_near(name),
        stated_at=nearest(lobe) if lobe.ratio and nearest(lobe) != name else "")
            for name, lobe in found.items()}


def judged(found: list[dict[str, Lobe | None]],
           alike: bool = True) -> list[dict[str, Lobe | None]]:
    """The lobes of all runs, of which is known then whether they are peaks. `alike`: whether their
    trains have the same passing frequencies, so that a lobe of one is that of the other."""
    if not alike:
        return [one for run in found for one in judged([run])]
    clear = {name for run in found for name, lobe in run.items()
             if lobe and _may_be_peak(lobe) and lobe.ratio >= STANDS_OUT}
    return [{name: lobe and dataclasses.replace(
        lobe, peak=_may_be_peak(lobe) and name in clear and lobe.ratio >= NEARLY)
             for name, lobe in run.items()} for run in found]


def _may_be_peak(lobe: Lobe) -> bool:
    return lobe.high and not lobe.stated_at and not lobe.unresolved
