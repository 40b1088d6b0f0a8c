"""Stiffness of the ballast, and a void below the sleeper with the sensor, from its displacement.

The program's own track, with the train of the deck on an even rail, is fitted to the reconstructed
displacement. Three parameters state the stiffness of the ballast springs, after Paper E of the
thesis: far from the sensor (`outside`), at the sensor (`inside`), and the length of the transition
between, a Gaussian in the logarithm. A void is the gap of that sleeper to its ballast. A dip of the
running surface at the sensor, of unknown depth, is fitted with them, as its dynamic forces change
the displacement, too.
"""
import dataclasses
import json
import math
import os
import pathlib
import subprocess
import tempfile
import tomllib

import numpy as np
import scipy.optimize
import scipy.signal

from trackbed_post import read
from trackbed_post.monitor import direction, displacement, inverse

NAMES = ("outside", "inside", "length", "void", "dip")
LINEAR = ("void", "dip")  # the others are fitted by their logarithms
LOWEST = {"outside": 1e6, "inside": 1e6, "length": 0.6, "void": 0.0, "dip": 0.0}
HIGHEST = {"outside": 1e9, "inside": 1e9, "length": 6.0, "void": 5e-3, "dip": 1e-2}
TYPICAL = {"length": 1.5, "void": 2e-4, "dip": 1e-3}  # the length within a factor of e
STEP = 4e-4         # s, longest of the passage: wavelengths of a metre and more matter
FITTED = 3.0        # m, shorter wavelengths are those of dips
DIP = 1.5           # m, length of a dip
EVERY = 0.25        # m, of the samples that are compared
ALIKE = 5.0         # m, over which errors of the displacement are alike
FLOOR = 0.005       # of the largest displacement: what the model leaves out
SIGNIFICANT = 3.0   # standard deviations by which a void must improve the fit
PERTURBED = 0.05    # of unknowns, for derivatives
VOIDS = 2e-4, 1e-3  # m, from which the fit begins
MARGIN = 8          # residuals, by which their number may grow from the first run on
MOST_TRIALS = 20    # of unknowns, from one begin
# Open MPI then starts no process of its own beside one rank, a quarter of the time of such a run.
ALONE = {"OMPI_MCA_ess_singleton_isolated": "1"}


@dataclasses.dataclass(frozen=True)
class Ballast:
    """Values and standard deviations by NAMES (N/m of one rail seat; m), those that were fitted;
    root mean square of the weighted residuals: 1 and less if the model explains the signal; by how
    much a void has reduced the sum of their squares; displacement that was fitted and that of the
    model, m, over the position of the first wheel. The reduction may be negative, as springs
    without a gap also pull, but those with the smallest gap do not; then the void is 0, and the
    other values are those of the fit without one."""
    value: dict
    deviation: dict
    misfit: float
    gain: float
    x: np.ndarray
    measured: np.ndarray
    model: np.ndarray

    @property
    def has_void(self):
        """Whether a void was fitted that is not 0 by chance: a likelihood ratio. Its deviation does
        not decide, as it is that of a void whatever the stiffness, which is fitted with it."""
        return self.gain > SIGNIFICANT**2


class Track:
    """Displacement of a sleeper of the deck's track during the passage of its train."""

    def __init__(self, program, deck, sensor, speed):
        self.program, self.deck, self.speed = pathlib.Path(program), pathlib.Path(deck), speed
        try:
            with self.deck.open("rb") as file:
                self.zones = tomllib.load(file).get("track", {}).get("zone", [])
        except (tomllib.TOMLDecodeError, UnicodeDecodeError, AttributeError) as error:
            raise read.Unreadable(f"{deck}: {error}") from None
        # Values that the deck does not give are those of the program.
        self.sensor = sensor
        given, _ = self.ran(["passage.duration=1e-3"])
        track = given["track"]
        self.stiffness, self.spacing = given["ballast"]["stiffness"], track["spacing"]
        self.sleepers = np.arange(0, track["length"] + self.spacing / 2, self.spacing)
        self.require_plane(given)
        self.sensor = float(self.sleepers[np.argmin(np.abs(self.sleepers - sensor))])

    def require_plane(self, given):
        problem = ""
        if given["track"].get("dimension") == "space":
            problem = 'two rails (track.dimension = "space") are not available here'
        elif any(zone.get("spacing") for zone in given["track"].get("zone", [])):
            problem = "sleepers of other spacing (track.zone.spacing) are not available here"
        if problem:
            raise read.Unreadable(f"{self.deck}: {problem}")

    def zones_of(self, value):
        """Zones of the deck, and one for each sleeper whose ballast differs from `outside`."""
        more = []
        ratio = math.log(value["inside"] / value["outside"])
        for x in self.sleepers:
            factor = math.exp(ratio * math.exp(-((x - self.sensor) / value["length"])**2 / 2))
            zone = {"from": max(x - self.spacing / 2, 0.0), "to": x + self.spacing / 2}
            if abs(factor - 1) > 1e-3:
                zone["bed"] = factor
            if x == self.sensor and value["void"] > 0:
                zone["gap"] = value["void"]
            if len(zone) > 2:
                more.append(zone)
        return [*self.zones, *more]

    def displacement(self, value):
        """(position of the first wheel, m; displacement, m, up)."""
        _, run = self.ran([*dip_of(value["dip"], self.sensor), *self.words_of(value)])
        return (run["history/wheel/x"].values[:, 0],
                run["history/sleeper/displacement"].values.ravel())

    def words_of(self, value):
        """Overrides of the deck for the ballast."""
        zones = ", ".join("{" + ", ".join(f"{key} = {json.dumps(one)}" for key, one in zone.items())
                          + "}" for zone in self.zones_of(value))
        return [f"track.zone=[{zones}]", f"ballast.stiffness={value['outside']!r}"]

    def kernel(self, value, path):
        """Writes Green's functions of the sleeper with the sensor on this ballast, without a void,
        into a file."""
        self.call("kernel", self.deck, "-o", path, "--sensor", repr(self.sensor),
                  *self.words_of(value | {"void": 0.0}))

    def ran(self, words):
        """(deck with all values, datasets) of a run."""
        with tempfile.TemporaryDirectory() as folder:
            self.call("run", self.deck, f"train.speed={self.speed!r}", f"passage.step={STEP}",
                      f"output.history_interval={STEP}", f"passage.points=[{self.sensor}]", *words,
                      "-o", folder, "--force")
            return read.origin(folder)[1], read.datasets(folder)

    def call(self, command, *words):
        """Runs the program on one rank."""
        ran = subprocess.run([self.program, command, *words], capture_output=True, text=True,
                             check=False, env=os.environ | ALONE)
        if ran.returncode:
            raise read.Unreadable(f"trackbed {command} ended with {ran.returncode}:\n{ran.stderr}")


def dip_of(depth, at):
    """Overrides for a smooth dip, or an even rail."""
    if not depth > 0:
        return ["irregularity.kind=none"]
    return ["irregularity.kind=versine", f"irregularity.at={at!r}", f"irregularity.length={DIP}",
            f"irregularity.depth={depth!r}"]


class Fit:
    """Weighted residuals of the model for parameters in units of about their uncertainty."""

    def __init__(self, track, found, rate, free):
        self.track, self.free = track, free
        self.count = None  # of residuals, of the first run
        self.step = track.speed / rate
        self.measured = slow(found.displacement, self.step)
        self.error = np.hypot(found.deviation, FLOOR * found.peak[0])
        self.start = {"outside": track.stiffness, "inside": track.stiffness,
                      "length": TYPICAL["length"], "void": 0.0, "dip": 0.0}

    def values(self, unknown):
        value = dict(self.start)
        for name, one in zip(self.free, unknown):
            value[name] = float(one * TYPICAL[name] if name in LINEAR else math.exp(one))
        if "inside" not in self.free:
            value["inside"] = value["outside"]
        return value

    def unknown(self, value):
        return np.array([value[name] / TYPICAL[name] if name in LINEAR else
                         math.log(value[name]) for name in self.free])

    def modelled(self, value):
        """(position of the first wheel, displacement of the model without short wavelengths)."""
        x, model = self.track.displacement(value)
        even = np.arange(x[0], x[-1], self.step)
        return even, slow(np.interp(even, x, model), self.step)

    def refuse_opposite_order(self):
        """Raises read.Unreadable if the train, or the track, is that of the deck from behind."""
        _, model = self.modelled(self.start)
        forth, back = (direction.similarity(self.measured, one) for one in (model, model[::-1]))
        if direction.order_by(forth, back) < 0:
            raise read.Unreadable(
                "the displacement is that of the deck's train in the opposite order: the "
                f"coefficient of correlation is {back:.3f}, in the order of the deck {forth:.3f}; "
                "give a deck with train.vehicles in the opposite order, and for a train towards "
                "smaller x with the mirror image of the track (length - x of zones and --sensor)")

    def compared(self, unknown):
        """(position of the first wheel, measured, model, weight) every EVERY m."""
        even, model = self.modelled(self.values(unknown))
        shift, _ = inverse.most_similar(self.measured, model)
        place = np.arange(len(model)) + shift
        inside = (place >= 0) & (place <= len(self.measured) - 1)
        rows = np.flatnonzero(inside)[::max(int(EVERY / self.step), 1)]
        samples = np.arange(len(self.measured))
        measured = np.interp(place[rows], samples, self.measured)
        error = np.interp(place[rows], samples, self.error)
        return even[rows], measured, model[rows], np.sqrt(EVERY / ALIKE) / error

    def jacobian(self, unknown):
        here = self.residuals(unknown)
        columns = []
        for number, end in enumerate(self.unknown({name: HIGHEST[name] for name in self.free})):
            step = PERTURBED if unknown[number] + PERTURBED < end else -PERTURBED
            columns.append((self.residuals(unknown + step * np.eye(len(unknown))[number]) - here)
                           / step)
        return np.transpose(columns)

    def solved(self, start):
        """Result of scipy's least squares from these values."""
        ends = [self.unknown({name: end[name] for name in self.free}) for end in (LOWEST, HIGHEST)]
        begin = np.clip(self.unknown(start), ends[0] + 1e-6, ends[1] - 1e-6)
        return scipy.optimize.least_squares(self.residuals, begin, self.jacobian, bounds=ends,
                                            xtol=1e-3, ftol=1e-3, max_nfev=MOST_TRIALS)

    def ballast(self, done, gain=0.0):
        """Of a result; gain: by which a void has reduced the sum of squares."""
        value = self.values(done.x)
        x, measured, model, weight = self.compared(done.x)
        independent = max(len(x) * EVERY / ALIKE - len(self.free), 1.0)
        misfit = float(np.sqrt(np.sum(((measured - model) * weight)**2) / independent))
        covariance = np.linalg.pinv(done.jac.T @ done.jac) * max(misfit, 1.0)**2
        scale = {name: TYPICAL[name] if name in LINEAR else value[name] for name in self.free}
        deviation = {name: float(one * scale[name])
                     for name, one in zip(self.free, np.sqrt(np.diag(covariance)))}
        return Ballast(value=value, deviation=deviation, misfit=misfit, x=x, measured=measured,
                       model=model, gain=gain / max(misfit, 1.0)**2)

    def residuals(self, unknown):
        _, measured, model, weight = self.compared(unknown)
        expected = [math.log(self.values(unknown)["length"] / TYPICAL["length"])] \
            if "length" in self.free else []
        if self.count is None:
            self.count = len(model) + MARGIN
        found = np.zeros(self.count + len(expected))
        used = min(self.count, len(model))
        found[:used] = ((measured - model) * weight)[:used]
        found[self.count:] = expected
        return found


def slow(values, step):
    sections = scipy.signal.butter(2, step / FITTED, fs=1.0, output="sos")
    return scipy.signal.sosfiltfilt(sections, values)


def calibrate(acceleration, rate, track, free=NAMES, doubtful=None, noise=None):
    """(Ballast below a sensor, Reconstruction). `free`: parameters that are fitted; the others are
    those of the deck, without a void and a dip. `noise`: as for displacement.reconstruct."""
    if unknown := set(free) - set(NAMES):
        raise read.Unreadable(f"{', '.join(sorted(unknown))}: the parameters are "
                              f"{', '.join(NAMES)}")
    found = displacement.reconstruct(acceleration, rate, track.speed, doubtful=doubtful,
                                     noise=noise)
    sound = Fit(track, found, rate, [name for name in free if name != "void"])
    sound.refuse_opposite_order()
    done = sound.solved(sound.start)
    if "void" not in free:
        return sound.ballast(done), found
    fit = Fit(track, found, rate, list(free))
    best = min((fit.solved(sound.values(done.x) | {"void": void}) for void in VOIDS),
               key=lambda one: one.cost)
    hanging = fit.ballast(best, gain=2 * (done.cost - best.cost))
    if hanging.gain >= 0:
        return hanging, found
    sound = sound.ballast(done)
    deviation = {name: sound.deviation.get(name, hanging.deviation[name]) for name in free}
    return dataclasses.replace(sound, deviation=deviation, gain=hanging.gain), found
