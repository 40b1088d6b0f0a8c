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

from . import crossing_scanned as scanned
from . import crossing_stones as stones
from .study import INPUTS, Run, Target, deck_of, summary

from trackbed_post import read  # noqa: I001 (found by .study)
from trackbed_post.monitor import (ballast, displacement, greens, indicators, inverse, passages,
                                   trains)

DECK = "track/crossing.toml"
RATE, SPEED, SENSOR = 5000.0, 50.0, 18.0  # Hz, m/s, m
NOISE = (1e-3, 1e-2)
COACHES = 'train.vehicles=["coach", "coach", "coach", "coach", "coach", "coach"]'
OTHER = 56.7  # m/s
JOINTS = {"short": (0.7e-3, 0.8), "middle": (1.5e-3, 1.2), "long": (3e-3, 2.0)}  # m: depth, length
# Panels: stiffness of pads, N/m (the thesis: nominal, 60E1, UIC60), of ballast springs, N/m.
PANELS = {f"pad {pad:g}, ballast {bed:g} MN/m": (1e6 * pad, 1e6 * bed)
          for pad in (60, 120, 1200) for bed in (12, 24)}
BED, PAD = (deck_of(DECK)[part] for part in ("ballast", "pad"))
STIFFNESS = BED["stiffness"]
ZONE = "{from=16.5, to=19.5, rail=3}"
BEDS = {"half": 0.5, "as in the deck": 1.0, "double": 2.0}  # of the three sleepers at the sensor
VOIDS = tuple(1e-4 * gap for gap in (2, 2.5, 3, 3.5, 4, 4.5, 5, 6, 7, 8))  # m
FREE = tuple(name for name in ballast.NAMES if name != "void")
VEES = (27.8, 44.4)  # m/s
ANGLE = 20e-3  # rad, of the V in all
DAMPINGS = {"deck": 1.0, "tenth": 0.1}  # of the ballast
LOW = 150.0  # Hz
DECAY = 0.03  # s: the thesis says that responses have decayed then
EFFECTIVE = 0.4  # m, of rail that moves with the contact in Jenkins' P1

PROGRAM = {}  # path: of the program, for the calibration of the ballast
KERNEL = f"kernel_{SPEED:g}.h5"
FORMS = {"short": {"dips": 8, "panel_dips": 3, "seeds": 2, "joints": ("middle",),
                   "beds": ("half",), "bed_seeds": 1, "voids": (), "sound": 0, "stones": False,
                   "scanned": scanned.CASES[:1]},
         "full": {"dips": 20, "panel_dips": 8, "seeds": 10, "joints": tuple(JOINTS),
                  "beds": tuple(BEDS), "bed_seeds": 10, "voids": VOIDS, "sound": 7, "stones": True,
                  "scanned": scanned.CASES}}


def dips(count):
    """(depth, length), m, of dips at random."""
    random = np.random.default_rng(1)
    return [(random.uniform(2e-4, 4e-3), random.uniform(0.6, 2.0)) for _ in range(count)]


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
    found += [Run(f"vee_{speed:g}_{name}", DECK,
                  (f"train.speed={speed}", "irregularity.kind=vee", "irregularity.length=1",
                   f"irregularity.depth={ANGLE / 4}", "track.zone=[]",
                   f"ballast.damping={factor * BED['damping']}"))
              for speed in VEES for name, factor in DAMPINGS.items()]
    found += scanned.runs(chosen["scanned"])
    return found + (stones.runs() if chosen["stones"] else [])


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

    def noisy(self, noise, seed):
        size = noise * np.sqrt(np.mean(self.acceleration**2))
        return self.acceleration + size * np.random.default_rng(seed).standard_normal(
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
    scanned.measure(folder, chosen["scanned"], chosen["seeds"], Passage, numbers, lines)
    if chosen["stones"]:
        stones.measure(folder, PROGRAM["path"], numbers, lines)


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
            found, _ = ballast.calibrate(passage.noisy(NOISE[0], seed), RATE, track, FREE)
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
        passage = Passage(folder / f"void_{k + 1}")
        calibrated, _ = ballast.calibrate(passage.noisy(NOISE[0], 0), RATE, track)
        numbers.put(f"void_{k + 1}", "void", 1e3 * calibrated.value["void"], "mm")
        numbers.put(f"void_{k + 1}", "its deviation", 1e3 * calibrated.deviation["void"], "mm")
        numbers.put(f"void_{k + 1}", "reduction of the sum of squares", calibrated.gain, "-")
        found += calibrated.has_void
    sound = [f"bed_{name.split()[0]}" for name in chosen["beds"]]
    for run in sound if chosen["voids"] else ():
        for seed in range(chosen["sound"]):
            passage = Passage(folder / run)
            false += ballast.calibrate(passage.noisy(NOISE[0], seed), RATE, track)[0].has_void
    if chosen["voids"]:
        numbers.put("voids", "found", found, "-")
        numbers.put("voids", "false alarms", false, "-")
        numbers.put("voids", "sound passages", len(sound) * chosen["sound"], "-")


def measure_vees(folder, numbers):
    """Largest forces of the first wheel over a V and those below 150 Hz, beside Jenkins' P1 and
    P2."""
    for speed in VEES:
        for name, factor in DAMPINGS.items():
            run = f"vee_{speed:g}_{name}"
            with h5py.File(folder / run / "results.h5") as file:
                x, force = (file[f"history/wheel/{what}"][:, 0] for what in ("x", "force"))
                step = float(np.mean(np.diff(file["history/time"][()])))
            low = scipy.signal.butter(2, LOW, fs=1 / step, output="sos")
            near = (x > SENSOR - 1) & (x < SENSOR + 3)
            contact = summary(folder / run, "track", "wheel_rail_constant")
            first, second = jenkins(speed, force[0], contact, factor)
            for quantity, value in (
                    ("static force", force[0]), ("largest force", force[near].max()),
                    ("P1", first), ("P2", second),
                    ("largest force below 150 Hz",
                     scipy.signal.sosfiltfilt(low, force)[near].max())):
                numbers.put(run, quantity, 1e-3 * value, "kN")


def jenkins(speed, load, contact, damping):
    """(P1, P2), N, of Jenkins, Stephenson, Clayton, Morland and Lyon 1974 (Railway Engineering
    Journal 3(1), 2-16), as later authors give them: the wheel strikes the rail with the angle times
    the speed. `damping`: factor of that of the ballast."""
    deck = deck_of(DECK)
    wheel = deck["vehicle"][0]["wheelset_mass"] / 2
    bending, rail = 210e9 * 3038.3e-8, 60.21  # of 60E1, N m2, kg/m
    spacing = deck["track"]["spacing"]
    bed = 1 / (1 / BED["stiffness"] + 1 / PAD["stiffness"]) / spacing
    length = (4 * bending / bed)**0.25  # m, of a beam on a Winkler bed
    mass = 1.5 * length * (rail + deck["track"]["sleeper_mass"] / 2 / spacing)
    stiffness, damper = 2 * bed * length, 1.5 * length * damping * BED["damping"] / spacing
    impact = ANGLE * speed
    hertz = 1.5 * contact**(2 / 3) * load**(1 / 3)
    light = EFFECTIVE * rail
    first = load + impact * np.sqrt(hertz * light / (1 + light / wheel))
    second = load + impact * np.sqrt(wheel / (wheel + mass)) * np.sqrt(stiffness * wheel) * (
        1 - damper * np.pi / (4 * np.sqrt(stiffness * (wheel + mass))))
    return first, second


def targets(n):
    """Where the thesis gives no number, the limit is ours."""
    found = [
        Target("spacing of the Green's functions at 50 m/s and 5 kHz", "hard", "1 cm",
               n("kernel", "spacing"), "cm", value=1.0, close=1e-6),
        Target("largest response after 0.03 s, of the largest", "soft", "almost none",
               n("kernel", "largest response after 0.03 s"), "%",
               holds=n("kernel", "largest response after 0.03 s") < 10)]

    def within(what, run, quantity, limit, kind="main", unit="%", published=None):
        value = n(run, quantity)
        found.append(Target(what, kind, published or f"ours: below {limit:g} {unit}", value, unit,
                            holds=value < limit, sign=value < limit if kind != "soft" else None))
    smooth = "error of displacement, smoothing, noise"
    within("displacement of six coaches, 0.1 % noise, worst error", "known",
           f"{smooth} 0.1 %, worst", 5)
    within("the same by the method of the thesis", "known",
           "error of displacement, high_pass, noise 0.1 %, worst", 5, "soft")
    within("frequency of its high-pass filter", "known", "high-pass frequency", 2, "soft", "Hz",
           "1.3 Hz in an example")
    within("speed of a known train, worst error", "other", "error of speed, worst", 0.1 + 1e-9,
           unit="m/s", published="steps of 0.1 m/s")
    for run, quantity, holds in (("other", "similarity, least", lambda v: v > trains.ACCEPTED),
                                 ("single", "similarity", lambda v: v < trains.ACCEPTED)):
        value = n(run, quantity)
        what = "known" if run == "other" else "unknown"
        found.append(Target(f"similarity of the {what} train", "main",
                            f"{'above' if run == 'other' else 'below'} {trains.ACCEPTED:g}", value,
                            "", holds=holds(value), sign=holds(value)))
    value = n("dips", "rank correlation")
    found.append(Target("indicator and largest force over dips, rank correlation", "main",
                        "the indicator rises", value, "", holds=value > 0.9, sign=value > 0))
    value = min(n(panel, "rank correlation") for panel in PANELS)
    found.append(Target("the same in six panels, least", "main", "the indicator rises", value, "",
                        holds=value > 0.9, sign=value > 0))
    for name in JOINTS:
        run = f"joint_{name}"
        if not n.has(run):
            continue
        depth, length = JOINTS[name]
        words = f"dip of {1e3 * depth:g} mm in {length:g} m"
        within(f"{words}: largest force, 0.1 % noise", run,
               "error of the largest force, noise 0.1 %, worst", 10)
        within(f"{words}: largest force, 1 % noise", run,
               "error of the largest force, noise 1 %, worst", 20)
        within(f"{words}: irregularity over its depth, 0.1 % noise", run,
               "error of the irregularity, noise 0.1 %, worst", 15)
        within(f"{words}: irregularity over its depth, 1 % noise", run,
               "error of the irregularity, noise 1 %, worst", 15, "soft")
    for name in BEDS:
        run = f"bed_{name.split()[0]}"
        if n.has(run):
            within(f"stiffness of the ballast at the sensor, {name}", run,
                   "error of the stiffness, worst", 10)
    if n.has("voids"):
        value, count = n("voids", "found"), len(VOIDS)
        found.append(Target(f"voids found, of {count}", "main", "ours: all", value, "",
                            holds=value == count, sign=value > 0))
        value = n("voids", "false alarms")
        found.append(Target(f"voids reported where there is none, in "
                            f"{n('voids', 'sound passages'):.0f} passages", "main", "ours: none",
                            value, "", holds=value == 0, sign=value == 0))
    return found + scanned.targets(n) + stones.targets(n)
