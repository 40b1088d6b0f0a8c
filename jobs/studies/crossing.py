"""Runs, numbers and targets of the study crossing: condition monitoring by an accelerometer on the
sleeper of a crossing, with the program's own passages as measurements. Its document:
crossing_document.py.

Accelerations are those of every time step, resampled to 5 kHz behind a low-pass filter as a sensor
does, with white noise of a part of their root mean square.
"""
import hashlib
import pathlib
import subprocess
import time

import h5py
import numpy as np
import scipy.signal
import scipy.stats

import launch

from .study import INPUTS, Run, Target, deck_of, summary

from trackbed_post import read  # noqa: I001 (found by .study)
from trackbed_post.monitor import (ballast, displacement, greens, indicators, inverse, passages)

DECK = "track/crossing.toml"
RATE, SPEED, SENSOR = 5000.0, 50.0, 18.0  # Hz, m/s, m
NOISE = (1e-3, 1e-2)
COACHES = 'train.vehicles=["coach", "coach", "coach", "coach", "coach", "coach"]'
OTHER = 56.7  # m/s
JOINTS = {"short": (0.7e-3, 0.8), "middle": (1.5e-3, 1.2), "long": (3e-3, 2.0)}  # m: depth, length
# Panels: stiffness of pads, N/m (the thesis: nominal, 60E1, UIC60), of ballast springs, N/m.
PANELS = {f"pad {pad:g}, ballast {bed:g} MN/m": (1e6 * pad, 1e6 * bed)
          for pad in (60, 120, 1200) for bed in (12, 24)}
STIFFNESS = deck_of(DECK)["ballast"]["stiffness"]
ZONE = "{from=16.5, to=19.5, rail=3}"
BEDS = {"half": 0.5, "as in the deck": 1.0, "double": 2.0}  # of the three sleepers at the sensor
VOIDS = (2.5e-4, 4e-4, 6e-4)  # m
FREE = tuple(name for name in ballast.NAMES if name != "void")
VEES = (27.8, 44.4)  # m/s
ANGLE = 20e-3  # rad, of the V in all
LAWS = {"Hertz": (), "linear": ("wheel_rail.law=linear",)}
LOW = 150.0  # Hz
AHEAD = 1.5  # m: the thesis says that the sensor feels little of forces farther away

PROGRAM = {}  # path: of the program, for the calibration of the ballast
KERNEL = f"kernel_{SPEED:g}.h5"
FORMS = {"short": {"dips": 8, "panel_dips": 3, "seeds": 2, "joints": ("middle",),
                   "beds": ("half",), "bed_seeds": 1, "voids": (), "sound": 0},
         "full": {"dips": 20, "panel_dips": 8, "seeds": 10, "joints": tuple(JOINTS),
                  "beds": tuple(BEDS), "bed_seeds": 10, "voids": VOIDS, "sound": 2}}


def dips(count):
    """(depth, length), m, of dips at random."""
    random = np.random.default_rng(1)
    return [(random.uniform(2e-4, 4e-3), random.uniform(0.6, 2.0)) for _ in range(count)]


def prepare(program, folder):
    """Green's functions of the deck, unless they exist."""
    PROGRAM["path"] = program
    kept = folder / "kernel.key"
    key = hashlib.sha256(pathlib.Path(program).read_bytes()
                         + (INPUTS / DECK).read_bytes()).hexdigest()
    if (folder / KERNEL).is_file() and kept.is_file() and kept.read_text("utf-8") == key:
        return
    ran = subprocess.run([program, "kernel", INPUTS / DECK, "-o", folder / KERNEL, "--sensor",
                          f"{SENSOR:g}", "--speed", f"{SPEED:g}", "--from", "4", "--to", "32"],
                         capture_output=True, text=True, check=False)
    if ran.returncode:
        launch.fail(ran, KERNEL)
    kept.write_text(key, "utf-8")


def of_dip(depth, length):
    return (f"irregularity.depth={depth:.4g}", f"irregularity.length={length:.4g}")


def panel_run(number, dip):
    return f"panel_{number + 1}_{dip + 1}"


def runs(form, _):
    chosen = FORMS[form]
    found = [Run("known", DECK, (COACHES,)), Run("other", DECK, (COACHES, f"train.speed={OTHER}")),
             Run("single", DECK)]
    found += [Run(f"dip_{number + 1}", DECK, of_dip(*dip))
              for number, dip in enumerate(dips(chosen["dips"]))]
    found += [Run(f"joint_{name}", DECK, of_dip(*JOINTS[name])) for name in chosen["joints"]]
    found += [Run(panel_run(number, k), DECK, (f"pad.stiffness={pad}", f"ballast.stiffness={bed}",
                                               *of_dip(*dip)))
              for number, (pad, bed) in enumerate(PANELS.values())
              for k, dip in enumerate(dips(chosen["panel_dips"]))]
    found += [Run(f"bed_{name.split()[0]}", DECK,
                  (f"track.zone=[{ZONE}, {{from=17.1, to=18.9, bed={BEDS[name]}}}]",))
              for name in chosen["beds"]]
    found += [Run(f"void_{k + 1}", DECK,
                  (f"track.zone=[{ZONE}, {{from=17.7, to=18.3, gap={void}}}]",))
              for k, void in enumerate(chosen["voids"])]
    found += [Run(f"vee_{speed:g}_{law}", DECK,
                  (f"train.speed={speed}", "irregularity.kind=vee", "irregularity.length=1",
                   f"irregularity.depth={ANGLE / 4}", "track.zone=[]", *words))
              for speed in VEES for law, words in LAWS.items()]
    return found


class Passage:
    """A run as the sensor sees it, and its truth."""

    def __init__(self, folder):
        self.run = read.results(folder)
        with h5py.File(folder / "results.h5") as file:
            self.x, force = (file[f"history/wheel/{name}"][()] for name in ("x", "force"))
        self.every = round(1 / (RATE * float(np.mean(np.diff(self.run.time)))))
        self.fast = force
        self.acceleration = self.sampled(self.run.sleeper["acceleration"].values.ravel(), "constant")
        self.displacement = self.run.sleeper["displacement"].values.ravel()[::self.every]
        self.x = self.x[::self.every]
        self.force = self.sampled(force, "line")

    def sampled(self, values, padding):
        return scipy.signal.resample_poly(values, 1, self.every, axis=0, padtype=padding)

    def noisy(self, noise, seed):
        size = noise * np.sqrt(np.mean(self.acceleration**2))
        return self.acceleration + size * np.random.default_rng(seed).standard_normal(
            len(self.acceleration))

    def near(self, wheel, bounds):
        return (self.x[:, wheel] > bounds[0]) & (self.x[:, wheel] < bounds[1])

    def largest_force(self):
        """N, of all time steps, near the crossing."""
        return self.force[np.abs(self.x - SENSOR) < 3].max()


def joint(x, depth, length):
    """Height of the deck's irregularity at x: two parabolas with a kink."""
    return -depth * np.maximum(1 - np.abs(x - SENSOR) / (length / 2), 0)**2


def measure(form, folder, numbers, lines):
    chosen = FORMS[form]
    for run in runs(form, 1):
        numbers.put(run.name, "wall_time", summary(folder / run.name, "wall_time_s"), "s")
    measure_displacement(folder, chosen, numbers, lines)
    measure_trains(folder, chosen, numbers)
    measure_indicators(folder, chosen, numbers, lines)
    kernel = greens.load(folder / KERNEL)
    measure_kernel(kernel, numbers, lines)
    for name in chosen["joints"]:
        measure_forces(folder, chosen, kernel, name, numbers, lines)
    measure_ballast(folder, chosen, numbers, lines)
    measure_vees(folder, numbers)


def middle_and_worst(numbers, run, quantity, values, unit):
    numbers.put(run, f"{quantity}, median", np.median(values), unit)
    numbers.put(run, f"{quantity}, worst", np.max(values), unit)


def measure_displacement(folder, chosen, numbers, lines):
    passage = Passage(folder / "known")
    deepest = -passage.displacement.min()
    for noise in (0.0, *NOISE):
        for method in displacement.METHODS:
            errors = []
            for seed in range(chosen["seeds"] if noise else 1):
                found = displacement.reconstruct(passage.noisy(noise, seed), RATE, SPEED, method)
                errors.append(100 * np.abs(found.displacement
                                           - passage.displacement).max() / deepest)
            middle_and_worst(numbers, "known", f"error of displacement, {method}, "
                             f"noise {100 * noise:g} %", errors, "%")
            if method == "high_pass" and noise == 0:
                numbers.put("known", "high-pass frequency", found.high_pass, "Hz")
    begin = time.perf_counter()
    count = 5
    for seed in range(count):
        displacement.reconstruct(passage.noisy(NOISE[0], seed), RATE, SPEED)
    each = (time.perf_counter() - begin) / count * 10 * RATE / len(passage.acceleration)
    numbers.put("known", "passages of 10 s in a minute", 60 / each, "-")
    found = displacement.reconstruct(passage.noisy(NOISE[0], 0), RATE, SPEED)
    when = np.arange(len(found.displacement)) / RATE
    thin = slice(0, int(0.9 * RATE), 10)
    lines.put("displacement", "reconstructed, mm", when[thin], 1e3 * found.displacement[thin])
    lines.put("displacement", "true, mm", when[thin], 1e3 * passage.displacement[thin])


def measure_trains(folder, chosen, numbers):
    library = passages.library_of([folder / "known"])
    other, single = Passage(folder / "other"), Passage(folder / "single")
    errors, similar = [], []
    for seed in range(chosen["seeds"]):
        found = library.identify(other.noisy(NOISE[0], seed), RATE)
        errors.append(abs(found.speed - OTHER) if found.name == "known" else np.inf)
        similar.append(found.similarity)
    numbers.put("other", "error of speed, worst", max(errors), "m/s")
    numbers.put("other", "similarity, least", min(similar), "-")
    numbers.put("single", "similarity", library.identify(single.acceleration, RATE).similarity, "-")


def measure_indicators(folder, chosen, numbers, lines):
    def of(names):
        found = [Passage(folder / name) for name in names]
        return (np.array([1e-3 * one.largest_force() for one in found]),
                np.array([indicators.indicator(one.acceleration, RATE, SPEED) for one in found]))
    force, found = of([f"dip_{number + 1}" for number in range(chosen["dips"])])
    numbers.put("dips", "rank correlation", scipy.stats.spearmanr(force, found)[0], "-")
    numbers.put("dips", "least force", force.min(), "kN")
    numbers.put("dips", "largest force", force.max(), "kN")
    for number, panel in enumerate(PANELS):
        force, found = of([panel_run(number, k) for k in range(chosen["panel_dips"])])
        order = np.argsort(found)
        lines.put("indicators", panel, found[order], force[order])
        numbers.put(panel, "rank correlation", scipy.stats.spearmanr(force, found)[0], "-")


def measure_kernel(kernel, numbers, lines):
    """How far the sensor feels."""
    largest = np.abs(kernel.fixed["left"]["displacement"]).max(axis=1)
    away = np.abs(np.abs(kernel.x - SENSOR) - AHEAD) < 1e-6
    numbers.put("kernel", "response to a force 1.5 m away over that at the sensor",
                100 * largest[away].max() / largest.max(), "%")
    lag = 1e3 * np.arange(kernel.samples) / RATE
    for ahead in (0.0, 0.6, 1.5, 3.0):
        row = greens.between(kernel.fixed["left"]["displacement"], kernel.x, SENSOR - ahead)
        lines.put("kernel", f"force {ahead:g} m away, 1e-12 m/N", lag[:300:2], 1e12 * row[:300:2])


def measure_forces(folder, chosen, kernel, name, numbers, lines):
    """Peaks of the wheel forces and irregularity, in the form of the program and of the thesis."""
    passage, run = Passage(folder / f"joint_{name}"), f"joint_{name}"
    bounds = (SENSOR + inverse.RANGE[0], SENSOR + inverse.RANGE[1])
    true = [passage.force[passage.near(wheel, bounds), wheel].max() for wheel in (0, 1)]
    numbers.put(run, "largest force", 1e-3 * true[0], "kN")
    for noise in NOISE:
        peaks, heights, scores, places = [], [], [], []
        for seed in range(chosen["seeds"]):
            forces, came, _ = inverse.evaluate(passage.noisy(noise, seed), kernel, SPEED)
            surface = inverse.irregularity(forces, kernel, SPEED)
            peaks += [100 * abs(force.max() / one - 1) for force, one in zip(forces.force, true)]
            expected = np.array([np.interp(forces.x, passage.x[:, wheel], passage.force[:, wheel])
                                 for wheel in (0, 1)])
            scores.append(np.sqrt(np.mean(((forces.force - expected) / forces.deviation)**2)))
            error = surface.height - joint(surface.x, *JOINTS[name])
            heights.append(100 * np.abs(error).max() / JOINTS[name][0])
            places.append(100 * abs(came.start - passage.x[0, 0]))
            if seed == 0 and noise == NOISE[0] and name == "middle":
                draw_forces(lines, forces, expected, surface)
        words = f"noise {100 * noise:g} %"
        middle_and_worst(numbers, run, f"error of the largest force, {words}", peaks, "%")
        middle_and_worst(numbers, run, f"error of the irregularity, {words}", heights, "%")
        middle_and_worst(numbers, run, f"error of the place, {words}", places, "cm")
        numbers.put(run, f"error over stated deviation, {words}", np.median(scores), "-")
    for method, criterion, quantity, likeness in VARIANTS:
        forces, *_ = inverse.evaluate(passage.noisy(NOISE[0], 0), kernel, SPEED, quantity=quantity,
                                      likeness=likeness, method=method, criterion=criterion)
        numbers.put(run, f"largest force, {variant(method, criterion, quantity, likeness)}",
                    1e-3 * forces.force[0].max(), "kN")


VARIANTS = (("tikhonov", "gcv", "acceleration", inverse.LIKENESS),
            ("tikhonov", "l_curve", "acceleration", inverse.LIKENESS),
            ("tikhonov", "residual", "acceleration", inverse.LIKENESS),
            ("tikhonov", "gcv", "acceleration", 0.0),
            ("truncated", "gcv", "acceleration", inverse.LIKENESS),
            ("truncated", "gcv", "displacement", 0.0))


def variant(method, criterion, quantity, likeness):
    return (f"{quantity}, {method}, {criterion}, "
            f"{'equal' if likeness == 0 else 'similar'} forces")


def draw_forces(lines, forces, expected, surface):
    lines.put("forces", "identified, kN", forces.x, 1e-3 * forces.force[0])
    lines.put("forces", "true, kN", forces.x, 1e-3 * expected[0])
    lines.put("forces", "standard deviation, kN", forces.x, 1e-3 * forces.deviation[0])
    lines.put("surface", "identified, mm", surface.x, 1e3 * surface.height)
    lines.put("surface", "true, mm", surface.x, 1e3 * joint(surface.x, *JOINTS["middle"]))
    lines.put("surface", "standard deviation, mm", surface.x, 1e3 * surface.deviation)


def measure_ballast(folder, chosen, numbers, lines):
    """Stiffness below the sensor, and voids."""
    track = ballast.Track(PROGRAM["path"], INPUTS / DECK, SENSOR, SPEED)
    for name in chosen["beds"]:
        run = f"bed_{name.split()[0]}"
        passage, errors, outside = Passage(folder / run), [], []
        for seed in range(chosen["bed_seeds"]):
            found = ballast.calibrate(passage.noisy(NOISE[0], seed), RATE, track, FREE)
            errors.append(100 * abs(found.value["inside"] / (BEDS[name] * STIFFNESS) - 1))
            outside.append((found.value["outside"] - STIFFNESS) / found.deviation["outside"])
            if seed == 0:
                lines.put("ballast", f"{name}, reconstructed, mm", found.x, 1e3 * found.measured)
                lines.put("ballast", f"{name}, model, mm", found.x, 1e3 * found.model)
        middle_and_worst(numbers, run, "error of the stiffness", errors, "%")
        numbers.put(run, "stiffness far away, error over stated deviation",
                    np.sqrt(np.mean(np.square(outside))), "-")
    found, false = 0, 0
    for k, void in enumerate(chosen["voids"]):
        calibrated = ballast.calibrate(Passage(folder / f"void_{k + 1}").noisy(NOISE[0], 0), RATE,
                                       track)
        numbers.put(f"void_{k + 1}", "void", 1e3 * calibrated.value["void"], "mm")
        numbers.put(f"void_{k + 1}", "its deviation", 1e3 * calibrated.deviation["void"], "mm")
        found += calibrated.has_void
    sound = [f"bed_{name.split()[0]}" for name in chosen["beds"]]
    for run in sound if chosen["voids"] else ():
        for seed in range(chosen["sound"]):
            false += ballast.calibrate(Passage(folder / run).noisy(NOISE[0], seed), RATE,
                                       track).has_void
    if chosen["voids"]:
        numbers.put("voids", "found", found, "-")
        numbers.put("voids", "false alarms", false, "-")


def measure_vees(folder, numbers):
    """Largest forces of the first wheel over a V, and those below 150 Hz."""
    for speed in VEES:
        for law in LAWS:
            run = f"vee_{speed:g}_{law}"
            passage = Passage(folder / run)
            with h5py.File(folder / run / "results.h5") as file:
                x, force = (file[f"history/wheel/{name}"][:, 0] for name in ("x", "force"))
            rate = RATE * passage.every
            slow = scipy.signal.sosfiltfilt(scipy.signal.butter(2, LOW, fs=rate, output="sos"),
                                            force)
            near = (x > SENSOR - 1) & (x < SENSOR + 3)
            numbers.put(run, "largest force", 1e-3 * force[near].max(), "kN")
            numbers.put(run, "largest force below 150 Hz", 1e-3 * slow[near].max(), "kN")
            numbers.put(run, "static force", 1e-3 * force[0], "kN")


def targets(n):
    return []
