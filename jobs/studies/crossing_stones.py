"""The part of the study crossing on stones: the accelerometer is on a sleeper of a bed of stones
(inputs/track/sensor.toml), whose support, settlement and wheel forces are known. The chain assumes
a track on springs (inputs/track/sensor_alone.toml).
"""
import copy
import dataclasses

import h5py
import numpy as np
import scipy.signal

from .study import INPUTS, Run, Target, deck_of

from trackbed_post import read  # noqa: I001 (found by .study)
from trackbed_post.monitor import ballast, greens, inverse

DECK, ALONE = "track/sensor.toml", "track/sensor_alone.toml"
SENSOR = 1              # number of the sleeper
RATE, FINE = 5000.0, 20000.0  # Hz, of the sensor; of the samples before its low-pass filter
MARGIN = 0.35           # s, of rest before and after a train that belong to its record
TRAINS = (2, 3)         # of the stage that is recorded, from 0: all stages begin with a jolt
NOISE = (1e-3, 1e-2)
LAST = "start='{folder}/stones_sound/stage_traffic_2.h5'"
VOID = "track.zone=[{{from=21.9, to=22.5, gap={gap}}}]"
# What differs from the deck in the recorded stage; the ground is another one from the start.
CASES = {"sound": (), "void of 0.3 mm": (LAST, VOID.format(gap=3e-4)),
         "void of 0.6 mm": (LAST, VOID.format(gap=6e-4)),
         "void of 1 mm": (LAST, VOID.format(gap=1e-3)),
         "fouled": (LAST, "stage.record.friction=0.35"),
         "soft subgrade": ("ground.layer.subgrade.young=75e6",)}
EVERY_WINDOW = ("output.history_interval=0",)
FREE = ("inside", "length", "dip")
SMALLEST = 1e-7         # m, of a gap: the springs do not pull, but differ in nothing else
OWN = 0.2               # m, length of a transition that leaves the next sleepers as they are


def name_of(case):
    return "stones_" + case.split()[0] + ("_" + case.split()[2].replace(".", "")
                                          if case.startswith("void") else "")


def runs():
    return [Run(name_of(case), DECK, (*words, *EVERY_WINDOW)) for case, words in CASES.items()]


class Record:
    """One train as the sensor sees it, and the truth: displacement, m, from rest; reaction of the
    stones, N, upwards; position, m, in the track, and force, N, of the first two wheels."""

    def __init__(self, folder, train, number=SENSOR):
        run, deck = read.results(folder), deck_of(DECK)
        rows = np.flatnonzero(run.stage == max(run.stage))
        self.time = run.time[rows]
        each = (self.time[-1] - self.time[0]) / deck["stage"][-1]["cycles"]
        begin = self.time[0] + train * each
        end = min(begin + each + MARGIN, self.time[-1])
        self.even = np.arange(begin - MARGIN, end, 1 / FINE)
        sleeper = {name: self.sampled(run.sleeper[name].values[rows, number])
                   for name in ("displacement", "acceleration", "reaction")}
        self.acceleration, self.reaction = sleeper["acceleration"], sleeper["reaction"]
        rest = slice(0, int(MARGIN * RATE / 2))
        self.displacement = sleeper["displacement"] - np.median(sleeper["displacement"][rest])
        self.settlement = -np.median(self.displacement[-rest.stop:])
        with h5py.File(folder / "results.h5") as file:
            x, force = (file[f"history/wheel/{name}"][rows[0]:rows[-1] + 1, :2]
                        for name in ("x", "force"))
        own = (self.time >= begin + each / 100) & (self.time < begin + each * 0.99)
        first = deck["seat"]["before"] * deck["sleepers"]["spacing"] - deck["sleepers"]["first"]
        self.x, self.force = x[own] + first, force[own]

    def sampled(self, values):
        return scipy.signal.resample_poly(np.interp(self.even, self.time, values), 1,
                                          round(FINE / RATE), padtype="line")

    def stiffness(self):
        """N/m, of the stones below the sleeper."""
        return secant(self.displacement, self.reaction, deck_of(DECK)["train"]["speed"] / RATE,
                      int(MARGIN * RATE / 2))

    def largest_force(self, bounds):
        near = (self.x[:, 0] > bounds[0]) & (self.x[:, 0] < bounds[1])
        return self.force[near, 0].max()


def secant(displacement, reaction, step, rest):
    """N/m: change of the reaction, upwards, at the largest displacement, of wavelengths that the
    calibration compares. `step`: m between samples; `rest`: number of the first ones, at rest."""
    down, up = (ballast.slow(one, step) for one in (-displacement, reaction))
    return (up[np.argmax(down)] - np.median(up[:rest])) / down.max()


def measure(folder, program, numbers, lines):
    speed = deck_of(DECK)["train"]["speed"]
    track = ballast.Track(program, INPUTS / ALONE, deck_of(ALONE)["passage"]["points"][0], speed)
    for case in CASES:
        run = name_of(case)
        if not (folder / run / "results.h5").is_file():
            continue
        records = [Record(folder / run, train) for train in TRAINS]
        for noise in NOISE:
            put(numbers, run, noise, [measured(folder, track, record, noise, seed)
                                      for seed, record in enumerate(records)])
        record = records[-1]
        acceleration, size = noisy(record, NOISE[0], 0)
        found, moved = ballast.calibrate(acceleration, RATE, track, (*FREE, "void"), noise=size)
        numbers.put(run, "void", 1e3 * found.value["void"], "mm")
        numbers.put(run, "reduction of the sum of squares", found.gain, "-")
        numbers.put(run, "rms of the acceleration", size / NOISE[0], "m/s2")
        numbers.put(run, "deviation of the displacement", 1e3 * moved.peak[1], "mm")
        measure_causes(track, record, softer_of(folder, program, track), run, folder / run, numbers)
        thin = slice(0, None, 20)
        when = np.arange(len(record.displacement))[thin] / RATE
        lines.put("stones", f"{case}, true, mm", when, 1e3 * record.displacement[thin])
        lines.put("stones", f"{case}, reconstructed, mm", when, 1e3 * moved.displacement[thin])


def softer_of(folder, program, track):
    """The track with the damping that the deck of the stones gives to its springs."""
    path, deck = folder / "sensor_alone_damping.toml", deck_of(ALONE)
    own, other = (f"{one['ballast']['damping'] / 1e3:g}e3" for one in (deck, deck_of(DECK)))
    text = (INPUTS / ALONE).read_text("utf-8")
    if text.count(f"damping = {own}") != 1:
        raise ValueError(f"{ALONE} does not state damping = {own} once")
    path.write_text(text.replace(f"damping = {own}", f"damping = {other}"), "utf-8")
    return ballast.Track(program, path, track.sensor, track.speed)


def fit_alone(track, moved):
    """N/m, if only this sleeper differs from the deck of `track`: the better one of two begins."""
    fit = ballast.Fit(track, moved, RATE, ["inside", "dip"])
    fit.start["length"] = OWN
    begins = track.stiffness, track.stiffness / 6
    best = min((fit.solved(fit.start | {"inside": begin}) for begin in begins),
               key=lambda done: done.cost)
    return fit.values(best.x)["inside"]


def with_neighbours(track, folder):
    """The track with the true stiffness of the other sleepers on stones, of the last train."""
    spacing, found = deck_of(DECK)["sleepers"]["spacing"], copy.copy(track)
    found.zones = list(track.zones)
    for number in range(deck_of(DECK)["sleepers"]["count"]):
        x = track.sensor + (number - SENSOR) * spacing
        factor = Record(folder, TRAINS[-1], number).stiffness() / track.stiffness
        if number != SENSOR:
            found.zones.append({"from": x - spacing / 2, "to": x + spacing / 2, "bed": factor})
    return found


def measure_causes(track, record, softer, run, folder, numbers):
    """Stiffness, MN/m, if parts of the chain are exact or other ones, of one train; `folder`: of
    this run."""
    acceleration, size = noisy(record, NOISE[0], 0)
    found, moved = ballast.calibrate(acceleration, RATE, track, FREE, noise=size)
    x, model = track.displacement(found.value)
    step = float(np.mean(np.diff(x)))
    spring = -found.value["inside"] * model - deck_of(ALONE)["ballast"]["damping"] \
        * np.gradient(model, step / track.speed)
    exact = ballast.Fit(track, dataclasses.replace(moved, displacement=record.displacement), RATE,
                        list(FREE))
    done = exact.solved(exact.start)
    gap = ballast.Fit(track, moved, RATE, [*FREE, "void"])
    for what, void in (("no gap", 0.0), ("smallest gap", SMALLEST)):
        left = gap.residuals(gap.unknown(found.value | {"void": void}))
        numbers.put(run, f"sum of squares, {what}", np.sum(left**2), "-")
    less, _ = ballast.calibrate(acceleration, RATE, softer, FREE, noise=size)
    own, given = (fit_alone(each, moved) for each in (track, with_neighbours(track, folder)))
    for what, value in (("true", record.stiffness()), ("found", found.value["inside"]),
                        ("secant of the fitted model",
                         secant(model, spring, step, int(MARGIN * track.speed / step / 2))),
                        ("from the true displacement", exact.values(done.x)["inside"]),
                        ("with the damping of the springs", less.value["inside"]),
                        ("of this sleeper alone", own),
                        ("and true stiffness of the others", given)):
        numbers.put(run, f"stiffness, one train, {what}", 1e-6 * value, "MN/m")


def noisy(record, noise, seed):
    """(acceleration, standard deviation of the noise)."""
    size = noise * np.sqrt(np.mean(record.acceleration**2))
    random = np.random.default_rng(seed)
    return record.acceleration + size * random.standard_normal(len(record.acceleration)), size


def measured(folder, track, record, noise, seed):
    """{quantity: (found, true)} of a record; of the displacement the largest one plus the error, so
    that the ratio to the true largest one is 1 plus the relative error."""
    acceleration, size = noisy(record, noise, seed)
    found, moved = ballast.calibrate(acceleration, RATE, track, FREE, noise=size)
    deepest = -record.displacement.min()
    kernel = kernel_of(folder, track, found)
    forces, *_ = inverse.evaluate(acceleration, kernel, track.speed, known_noise=size,
                                  refined=False, likeness=0.0)
    bounds = (track.sensor + inverse.RANGE[0], track.sensor + inverse.RANGE[1])
    load, largest = kernel.wheels.load[0], record.largest_force(bounds)
    return {"displacement": (np.abs(moved.displacement - record.displacement).max() + deepest,
                             deepest),
            "settlement": (moved.settlement[0], record.settlement),
            "stiffness": (found.value["inside"], record.stiffness()),
            "largest force": (forces.force[0].max(), largest),
            "dynamic force": (forces.force[0].max() - load, largest - load)}


def kernel_of(folder, track, found):
    """Green's functions of the calibrated track."""
    path = folder / "kernel_stones.h5"
    track.kernel(found.value, path)
    return greens.load(path)


UNITS = {"settlement": ("mm", 1e3), "stiffness": ("MN/m", 1e-6), "largest force": ("kN", 1e-3),
         "dynamic force": ("kN", 1e-3)}


def put(numbers, run, noise, found):
    words = f"noise {100 * noise:g} %"
    for quantity, (unit, factor) in UNITS.items():
        for place, name in enumerate(("found", "true")):
            numbers.put(run, f"{quantity}, {name}, {words}",
                        factor * np.mean([one[quantity][place] for one in found]), unit)
            for train, one in enumerate(found):
                numbers.put(run, f"{quantity}, {name}, {words}, train {train + 1}",
                            factor * one[quantity][place], unit)
    largest, dynamic = (found[0][name][1] for name in ("largest force", "dynamic force"))
    numbers.put(run, "static force", 1e-3 * (largest - dynamic), "kN")
    for quantity in ("displacement", "stiffness", "largest force", "dynamic force"):
        errors = [100 * abs(one[quantity][0] / one[quantity][1] - 1) for one in found]
        numbers.put(run, f"error of {quantity}, {words}, worst", max(errors), "%")


def targets(n):
    """Of the worse of two trains."""
    limits = (("displacement", 5), ("stiffness", 10), ("largest force", 10))
    found = []
    for case in CASES:
        run = name_of(case)
        if not n.has(run):
            continue
        for quantity, limit in limits:
            value = n(run, f"error of {quantity}, noise 0.1 %, worst")
            found.append(Target(f"on stones, {case}: {quantity}, 0.1 % noise", "main",
                                f"ours: below {limit} %", value, "%", holds=value < limit,
                                see="On stones"))
    return found
