"""Type, direction and speed of a train by correlation with known passages (section 5.6 of the
thesis).

A reference is the displacement of a sleeper over the length of a train. For each speed its
acceleration is resampled, low-passed and correlated with that of the unknown passage; the largest
coefficient counts, of either sign, as a sensor may be upside down, and of all references of a type.
The thesis correlates measured accelerations instead, joined in time.
"""
import dataclasses

import numpy as np
import scipy.fft
import scipy.signal

from trackbed_post import read

SPEEDS = np.round(np.arange(20.0, 60.05, 0.1), 1)  # m/s
CUT_OFF = 20.0   # Hz
ACCEPTED = 0.80  # least coefficient of a known train
RATE = 200.0     # samples per second after the low-pass filter
COARSE = 4       # steps of speed that are tried first; all are near the best of these
FINEST = 0.1     # m, step of a reference
APART = 0.01     # least difference of the coefficients of both directions that tells them apart
PART = 0.02      # of the largest displacement, by which a train begins and ends


@dataclasses.dataclass(frozen=True)
class Reference:
    """Displacement, m, of a sleeper at every `step` m that a train of this type moves on."""
    name: str
    displacement: np.ndarray
    step: float

    @classmethod
    def of_passage(cls, name, found, rate, speed):
        """From a reconstructed or computed displacement."""
        every = max(int(FINEST * rate / speed), 1)
        if not rate > 2.5 * CUT_OFF:
            raise read.Unreadable(f"{name}: a reference of {rate:g} samples per second is too "
                                  f"coarse; trains are compared up to {CUT_OFF:g} Hz")
        thin = scipy.signal.resample_poly(np.asarray(found, float), 1, every)
        return cls(name, thin, every * speed / rate)

    @property
    def length(self):
        """m, of the train with the deflection before and behind it."""
        return length_of(self.displacement, self.step)

    def acceleration(self, speed, backwards):
        """m/s2 at RATE, below CUT_OFF."""
        way = self.displacement[::-1] if backwards else self.displacement
        time = np.arange(len(way)) * self.step / speed
        even = np.arange(0, time[-1], 1 / RATE)
        slow = slow_part(way, speed / self.step)
        return np.gradient(np.gradient(np.interp(even, time, slow), 1 / RATE), 1 / RATE)


@dataclasses.dataclass(frozen=True)
class Train:
    """What was recognised: name, or "" if no reference is similar enough; speed, m/s; direction:
    1 as that of the reference, -1 opposite, 0 not known as the train looks the same from both ends;
    coefficient of correlation, 0 to 1."""
    name: str
    speed: float
    direction: int
    similarity: float


def length_of(displacement, step):
    """m, of the train that passes while a sleeper is displaced; `step`: m between two values."""
    size = np.abs(displacement)
    loaded = np.flatnonzero(size > PART * size.max())
    return float(loaded[-1] - loaded[0]) * step


def slow_part(values, rate):
    sections = scipy.signal.butter(4, CUT_OFF, fs=rate, output="sos")
    return scipy.signal.sosfiltfilt(sections, values, axis=0)


class Library:
    """References, prepared for records up to a length."""

    def __init__(self, references):
        if not references:
            raise read.Unreadable("the library of trains has no reference")
        self.references = list(references)
        self.count = 0  # samples of record and reference together
        self.spectra = {}

    def identify(self, acceleration, rate):
        """The Train of a passage."""
        if not rate > 2.5 * CUT_OFF:
            raise read.Unreadable(f"{rate:g} samples per second are too few: trains are compared "
                                  f"up to {CUT_OFF:g} Hz")
        if len(acceleration) < rate:
            raise read.Unreadable(f"the record of {len(acceleration) / rate:.3g} s is too short")
        slow = slow_part(acceleration, rate)
        even = np.arange(0, len(slow) / rate, 1 / RATE)
        signal = np.interp(even, np.arange(len(slow)) / rate, slow)
        signal -= signal.mean()
        size = np.sqrt(np.sum(signal**2))
        if not size > 0:
            raise read.Unreadable("the acceleration is constant: no train is recorded")
        self.prepare(len(signal))
        lines = scipy.fft.rfft(signal / size, self.count)
        found = {key: self.best_of(lines, spectra) for key, spectra in self.spectra.items()}
        (name, backwards), (similarity, speed) = max(found.items(), key=lambda item: item[1][0])
        if similarity < ACCEPTED:
            return Train("", speed, 0, similarity)
        other = found[name, not backwards][0]
        direction = 0 if similarity - other < APART else (-1 if backwards else 1)
        return Train(name, speed, direction, similarity)

    def best_of(self, lines, spectra):
        """Largest coefficient of correlation and its speed."""
        def at(rows):
            return np.max([peaks(scipy.fft.irfft(lines * each[rows], self.count))
                           for each in spectra], axis=0)
        middle = COARSE * int(np.argmax(at(slice(None, None, COARSE))))
        near = np.arange(max(middle - COARSE, 0), min(middle + COARSE + 1, len(SPEEDS)))
        values = at(near)
        best = int(np.argmax(values))
        return float(values[best]), float(SPEEDS[near[best]])

    def lengths_of(self, name):
        """m, of the references of a type."""
        return [one.length for one in self.references if one.name == name]

    def prepare(self, samples):
        """Conjugate spectra of the references of each type and direction at all speeds, for records
        of up to this many samples."""
        longest = max(int(len(one.displacement) * one.step / SPEEDS[0] * RATE)
                      for one in self.references)
        if samples + longest <= self.count:
            return
        self.count = 1 << int(np.ceil(np.log2(samples + longest)))
        self.spectra = {}
        for one in self.references:
            for backwards in (False, True):
                rows = [normalised(one.acceleration(speed, backwards), self.count)
                        for speed in SPEEDS]
                self.spectra.setdefault((one.name, backwards), []).append(
                    np.conj(scipy.fft.rfft(rows)))


def peaks(rows):
    """Largest magnitude of each row, of the parabola through it and its neighbours: between two
    samples a signal of 20 Hz loses 1 %."""
    rows = np.abs(rows)
    at, row = np.argmax(rows, axis=1), np.arange(len(rows))
    before, top, after = (rows[row, (at + shift) % rows.shape[1]] for shift in (-1, 0, 1))
    bend = np.maximum(2 * top - before - after, 1e-300)
    return top + (before - after)**2 / (8 * bend)


def normalised(signal, count):
    signal = signal - signal.mean()
    return np.pad(signal / np.sqrt(np.sum(signal**2)), (0, count - len(signal)))
