"""Numbers of the study crossing: condition monitoring by an accelerometer on the sleeper of a
crossing, with the program's own passages as measurements. Runs: crossing_cases.py, targets:
crossing_targets.py, document: crossing_document.py.

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

from . import crossing_cases as cases
from . import crossing_jenkins as jenkins
from . import crossing_places as places
from . import crossing_scanned as scanned
from . import crossing_stones as stones
from . import crossing_targets
from .crossing_cases import (BEDS, DECAY, DECK, FORMS, FREE, JOINTS, NOISE, OTHER, PANELS, RATE,
                             SENSOR, SPEED, STIFFNESS, bed_run, panel_run)
from .study import INPUTS, deck_of, summary

from trackbed_post import read  # noqa: I001 (found by .study)
from trackbed_post.monitor import ballast, displacement, greens, indicators, inverse, passages

PROGRAM = {}  # path: of the program, for the calibration of the ballast
KERNEL = f"kernel_{SPEED:g}.h5"


def prepare(program, folder):
    """Green's functions of the deck, unless they exist."""
    PROGRAM["path"] = program
    scanned.prepare(program, folder)
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


def runs(form, _):
    return cases.runs(form)


def targets(n):
    return crossing_targets.of(n)


class Passage:
    """A run as the sensor sees it, and its truth."""

    def __init__(self, folder):
        self.run = read.results(folder)
        with h5py.File(folder / "results.h5") as file:
            self.x, force = (file[f"history/wheel/{name}"][()] for name in ("x", "force"))
        self.every = round(1 / (RATE * float(np.mean(np.diff(self.run.time)))))
        acceleration = self.run.sleeper["acceleration"].values.ravel()
        self.acceleration = self.sampled(acceleration, "constant")
        self.displacement = self.run.sleeper["displacement"].values.ravel()[::self.every]
        self.x = self.x[::self.every]
        self.force = self.sampled(force, "line")

    def sampled(self, values, padding):
        return scipy.signal.resample_poly(values, 1, self.every, axis=0, padtype=padding)

    def rms(self):
        return np.sqrt(np.mean(self.acceleration**2))

    def noisy(self, noise, seed):
        return self.acceleration + noise * self.rms() * np.random.default_rng(seed).standard_normal(
            len(self.acceleration))

    def near(self, wheel, bounds):
        return (self.x[:, wheel] > bounds[0]) & (self.x[:, wheel] < bounds[1])

    def largest_force(self):
        """N, below half of RATE, near the crossing."""
        return self.force[np.abs(self.x - SENSOR) < 3].max()


def joint(x, depth, length):
    """Height of the deck's irregularity at x: two parabolas with a kink."""
    return -depth * np.maximum(1 - np.abs(x - SENSOR) / (length / 2), 0)**2


def measure(form, folder, numbers, lines):
    chosen = FORMS[form]
    for run in cases.runs(form):
        numbers.put(run.name, "wall_time", summary(folder / run.name, "wall_time_s"), "s")
    measure_displacement(folder, chosen, numbers, lines)
    measure_trains(folder, chosen, numbers)
    measure_indicators(folder, chosen, numbers, lines)
    kernel = greens.load(folder / KERNEL)
    measure_kernel(kernel, numbers, lines)
    for name in chosen["joints"]:
        measure_forces(folder, chosen, kernel, name, numbers, lines)
        measure_methods(folder, kernel, name, numbers)
        passage = Passage(folder / f"joint_{name}")
        places.measure_sweep(passage, kernel, f"joint_{name}", lambda x, name=name: joint(
            x, *JOINTS[name]), JOINTS[name][0], numbers)
    measure_ballast(folder, chosen, numbers, lines)
    jenkins.measure(folder, deck_of(DECK), SENSOR, numbers)
    scanned.measure(folder, chosen["scanned"], chosen["seeds"], Passage, numbers, lines)
    if chosen["stones"]:
        stones.measure(folder, PROGRAM["path"], numbers, lines)


def middle_and_worst(numbers, run, quantity, values, unit):
    numbers.put(run, f"{quantity}, median", np.median(values), unit)
    numbers.put(run, f"{quantity}, worst", np.max(values), unit)


def measure_displacement(folder, chosen, numbers, lines):
    passage = Passage(folder / "known")
    numbers.put("known", "rms of the acceleration", passage.rms(), "m/s2")
    deepest = -passage.displacement.min()
    for noise in (0.0, *NOISE):
        for method in displacement.METHODS:
            errors, cuts = [], []
            for seed in range(chosen["seeds"] if noise else 1):
                found = displacement.reconstruct(passage.noisy(noise, seed), RATE, SPEED, method)
                errors.append(100 * np.abs(found.displacement
                                           - passage.displacement).max() / deepest)
                cuts.append(found.high_pass)
            middle_and_worst(numbers, "known", f"error of displacement, {method}, "
                             f"noise {100 * noise:g} %", errors, "%")
            if method == "high_pass":
                words = f", noise {100 * noise:g} %, median" if noise else ""
                numbers.put("known", f"high-pass frequency{words}", np.median(cuts), "Hz")
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
    other = Passage(folder / "other")
    numbers.put("other", "speed", OTHER, "m/s")
    errors, similar = [], []
    for seed in range(chosen["seeds"]):
        found = library.identify(other.noisy(NOISE[0], seed), RATE)
        errors.append(abs(found.speed - OTHER) if found.name == "known" else np.inf)
        similar.append(found.similarity)
    numbers.put("other", "error of speed, worst", max(errors), "m/s")
    numbers.put("other", "similarity, least", min(similar), "-")
    for run in ("fewer", "single"):
        found = library.identify(Passage(folder / run).acceleration, RATE)
        numbers.put(run, "similarity", found.similarity, "-")


def measure_indicators(folder, chosen, numbers, lines):
    def of(names):
        found = [Passage(folder / name) for name in names]
        return (np.array([1e-3 * one.largest_force() for one in found]),
                np.array([indicators.indicator(one.acceleration, RATE, SPEED) for one in found]))
    force, found = of([f"dip_{number + 1}" for number in range(chosen["dips"])])
    numbers.put("dips", "rank correlation", scipy.stats.spearmanr(force, found)[0], "-")
    numbers.put("dips", "least force", force.min(), "kN")
    numbers.put("dips", "largest force", force.max(), "kN")
    pooled = []
    for number, panel in enumerate(PANELS):
        force, found = of([panel_run(number, k) for k in range(chosen["panel_dips"])])
        order = np.argsort(found)
        lines.put("indicators", panel, found[order], force[order])
        numbers.put(panel, "rank correlation", scipy.stats.spearmanr(force, found)[0], "-")
        pooled.append((found[order], force[order]))
    numbers.put("panels", "rank correlation, pooled",
                scipy.stats.spearmanr(*np.concatenate(pooled, axis=1))[0], "-")
    # Where all panels have indicators: the same indicator means other forces in other panels.
    common = np.sqrt(max(found[0] for found, _ in pooled) * min(found[-1] for found, _ in pooled))
    numbers.put("panels", "common indicator", common, "m/s2")
    for panel, (found, force) in zip(PANELS, pooled):
        numbers.put(panel, "force at the common indicator", np.interp(common, found, force), "kN")


def measure_kernel(kernel, numbers, lines):
    """Spacing of the forces, and how soon responses have decayed."""
    numbers.put("kernel", "spacing", 100 * (kernel.x[1] - kernel.x[0]), "cm")
    responses = np.abs(kernel.fixed["left"]["displacement"])
    later = responses[:, int(DECAY * RATE):]
    numbers.put("kernel", "largest response after 0.03 s", 100 * later.max() / responses.max(), "%")
    lag = 1e3 * np.arange(kernel.samples) / RATE
    for ahead in (0.0, 0.6, 1.5, 3.0):
        row = greens.between(kernel.fixed["left"]["displacement"], kernel.x, SENSOR - ahead)
        lines.put("kernel", f"force {ahead:g} m away", lag[:300:2], 1e12 * row[:300:2])


def measure_forces(folder, chosen, kernel, name, numbers, lines):
    """Errors of the wheel forces and of the irregularity."""
    passage, run = Passage(folder / f"joint_{name}"), f"joint_{name}"
    bounds, load = (SENSOR + inverse.RANGE[0], SENSOR + inverse.RANGE[1]), kernel.wheels.load
    true = [passage.force[passage.near(wheel, bounds), wheel].max() for wheel in (0, 1)]
    numbers.put(run, "largest force", 1e-3 * true[0], "kN")
    numbers.put(run, "static force", 1e-3 * load[0], "kN")
    numbers.put(run, "rms of the acceleration", passage.rms(), "m/s2")
    for noise in NOISE:
        peaks, dynamic, heights, scores, starts = [], [], [], [], []
        for seed in range(chosen["seeds"]):
            forces, came, _ = inverse.evaluate(passage.noisy(noise, seed), kernel, SPEED)
            surface = inverse.irregularity(forces, kernel, SPEED)
            for force, one, static in zip(forces.force, true, load):
                peaks.append(100 * abs(force.max() / one - 1))
                dynamic.append(100 * abs(force.max() - one) / (one - static))
            expected = places.true_forces(passage, forces.x)
            scores.append(np.sqrt(np.mean(((forces.force - expected) / forces.deviation)**2)))
            error = surface.height - joint(surface.x, *JOINTS[name])
            heights.append(100 * np.abs(error).max() / JOINTS[name][0])
            starts.append(100 * abs(came.start - passage.x[0, 0]))
            if seed == 0 and noise == NOISE[0] and name == "middle":
                draw_forces(lines, forces, expected, surface)
                late = forces.x > SENSOR + 2  # the impact of the second wheel
                for what, one in (("found", forces.force), ("true", expected)):
                    numbers.put(run, f"second peak, {what}", 1e-3 * one[0, late].max(), "kN")
        words = f"noise {100 * noise:g} %"
        for quantity, values, unit in (("the largest force", peaks, "%"),
                                       ("the dynamic force", dynamic, "%"),
                                       ("the irregularity", heights, "%"),
                                       ("the place", starts, "cm")):
            middle_and_worst(numbers, run, f"error of {quantity}, {words}", values, unit)
        numbers.put(run, f"error over stated deviation, {words}", np.median(scores), "-")


def measure_methods(folder, kernel, name, numbers):
    """Largest force of the first wheel, in the form of the program and of the thesis."""
    passage, run = Passage(folder / f"joint_{name}"), f"joint_{name}"
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
        run = bed_run(name)
        passage, errors, outside = Passage(folder / run), [], []
        for seed in range(chosen["bed_seeds"]):
            found, _ = ballast.calibrate(passage.noisy(NOISE[0], seed), RATE, track, FREE)
            errors.append(100 * abs(found.value["inside"] / (BEDS[name] * STIFFNESS) - 1))
            outside.append((found.value["outside"] - STIFFNESS) / found.deviation["outside"])
            if seed == 0:
                lines.put("ballast", f"{name}, reconstructed, mm", found.x, 1e3 * found.measured)
                lines.put("ballast", f"{name}, model, mm", found.x, 1e3 * found.model)
        middle_and_worst(numbers, run, "error of the stiffness", errors, "%")
        numbers.put(run, "stiffness far away, error over stated deviation",
                    np.sqrt(np.mean(np.square(outside))), "-")
    if "double" in chosen["beds"]:
        measure_bias(folder, track, numbers)
    measure_voids(folder, chosen, track, numbers)


def measure_bias(folder, track, numbers):
    """Errors of the stiffness without noise if the rail is even, and if the form of the transition
    is that of the model."""
    for name in ("silent", *cases.bias_runs()):
        run = bed_run("double") + ("" if name == "silent" else f"_{name}")
        found, _ = ballast.calibrate(Passage(folder / run).acceleration, RATE, track, FREE)
        numbers.put(bed_run("double"), f"error of the stiffness, {name}",
                    100 * (found.value["inside"] / (BEDS["double"] * STIFFNESS) - 1), "%")


def measure_voids(folder, chosen, track, numbers):
    if not chosen["voids"]:
        return
    found, false = 0, 0
    for k, void in enumerate(chosen["voids"]):
        passage = Passage(folder / f"void_{k + 1}")
        calibrated, _ = ballast.calibrate(passage.noisy(NOISE[0], 0), RATE, track)
        numbers.put(f"void_{k + 1}", "void", 1e3 * calibrated.value["void"], "mm")
        numbers.put(f"void_{k + 1}", "its deviation", 1e3 * calibrated.deviation["void"], "mm")
        numbers.put(f"void_{k + 1}", "reduction of the sum of squares", calibrated.gain, "-")
        found += calibrated.has_void
    sound = [bed_run(name) for name in chosen["beds"]]
    for run in sound:
        for seed in range(chosen["sound"]):
            passage = Passage(folder / run)
            false += ballast.calibrate(passage.noisy(NOISE[0], seed), RATE, track)[0].has_void
    numbers.put("voids", "found", found, "-")
    numbers.put("voids", "false alarms", false, "-")
    numbers.put("voids", "sound passages", len(sound) * chosen["sound"], "-")
