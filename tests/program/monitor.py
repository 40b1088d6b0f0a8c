#!/usr/bin/env python3
"""Condition monitoring of the program's own passages over a crossing, whose truth is known.

    monitor.py PROGRAM DECK FOLDER [known|dips|forces|speeds] [NUMBER]

Sleeper accelerations are those of every time step, resampled to 5 kHz behind a low-pass filter as a
sensor does, with white noise.
"""
import pathlib
import shutil
import sys

import h5py
import numpy as np
import scipy.signal
import scipy.stats

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "postproc")]
from program import Program  # noqa: E402
from trackbed_post import read  # noqa: E402
from trackbed_post.monitor import (displacement, greens, indicators, inverse,  # noqa: E402
                                   passages)

RATE = 5000.0  # Hz
SEEDS = range(10)
NOISE = 1e-3  # of the root mean square of the acceleration
# Noise: largest error of the force's peak, of the irregularity over its depth.
ALLOWED = {1e-3: (0.10, 0.15), 1e-2: (0.20, None)}


def require(condition, message):
    if not condition:
        raise SystemExit(message)


class Crossing:
    def __init__(self, program, deck, folder):
        self.program, self.deck, self.folder = Program(program), deck, folder

    def run(self, name, *changes):
        self.program.done(1, "run", self.deck, *changes, "-o", self.folder / name)
        return read.results(self.folder / name)


def sensor(run):
    """(acceleration at RATE, true displacement at the same times)."""
    every = round(1 / (RATE * float(np.mean(np.diff(run.time)))))
    acceleration = scipy.signal.resample_poly(run.sleeper["acceleration"].values.ravel(), 1, every)
    truth = run.sleeper["displacement"].values.ravel()[::every]
    return acceleration[:len(truth)], truth[:len(acceleration)]


def noisy(signal, seed, noise=NOISE):
    size = noise * np.sqrt(np.mean(signal**2))
    return signal + size * np.random.default_rng(seed).standard_normal(len(signal))


def check_displacement(run):
    """Within 5 % for six wagons at 50 m/s."""
    signal, truth = sensor(run)
    errors, widths = [], []
    for seed in SEEDS:
        found = displacement.reconstruct(noisy(signal, seed), RATE, 50.0)
        errors.append(np.abs(found.displacement - truth).max() / -truth.min())
        widths.append(found.deviation.max() / -truth.min())
    print(f"displacement of six wagons: largest error {np.median(errors):.3f} (median), "
          f"{max(errors):.3f} (worst of {len(errors)}), stated deviation {max(widths):.3f}")
    require(max(errors) < 0.05, f"displacement: {max(errors):.3f} of the largest")
    require(max(errors) < 6 * max(widths), "the stated deviation is too small")


def check_train(crossing, known):
    """Speed within 0.1 m/s, by a library of a run at another speed."""
    library = passages.library_of([known])
    speed = 56.7
    run = crossing.run("other", SIX, f"train.speed={speed}")
    signal, _ = sensor(run)
    errors = []
    for seed in SEEDS:
        found = library.identify(noisy(signal, seed), RATE)
        require(found.name == "known", f"{found.name or 'no train'} instead of known is recognised")
        errors.append(abs(found.speed - speed))
    print(f"speed: largest error {max(errors):.3f} m/s, similarity {found.similarity:.3f}")
    require(max(errors) < 0.1 + 1e-9, f"speed: {max(errors):.3g} m/s off")
    single = crossing.run("single")
    require(library.identify(sensor(single)[0], RATE).name == "",
            "one coach is taken for six")


def check_indicator(crossing, dips):
    """Rises with the largest wheel force over dips of different depth and length."""
    random = np.random.default_rng(1)
    forces, found = [], []
    for number in range(dips):
        run = crossing.run(f"dip_{number}", f"irregularity.depth={random.uniform(2e-4, 4e-3):.4g}",
                           f"irregularity.length={random.uniform(0.6, 2.0):.4g}")
        with h5py.File(crossing.folder / run.name / "results.h5") as file:
            near = np.abs(file["history/wheel/x"][()] - 18) < 3
            forces.append(file["history/wheel/force"][()][near].max())
        found.append(indicators.indicator(sensor(run)[0], RATE, 50.0))
    rank = scipy.stats.spearmanr(forces, found)[0]
    print(f"indicator over {dips} dips, {min(forces) / 1e3:.0f} to {max(forces) / 1e3:.0f} kN: "
          f"rank correlation {rank:.3f}")
    require(rank > 0.9, f"rank correlation {rank:.3f}")


def kernel_of(crossing, name, speed, *changes):
    path = crossing.folder / f"{name}.h5"
    crossing.program.done(1, "kernel", crossing.deck, *changes, "-o", path, "--sensor", "18",
                          "--speed", f"{speed:g}", "--from", "4", "--to", "32")
    return greens.load(path)


class Truth:
    """Force of the first wheels and height of the running surface at places of a passage."""

    def __init__(self, folder):
        with h5py.File(folder / "results.h5") as file:
            self.x, force = (file[f"history/wheel/{name}"][()] for name in ("x", "force"))
            step = float(np.mean(np.diff(file["history/time"][()])))
        every = round(1 / (RATE * step))
        low = scipy.signal.resample_poly(force, 1, every, axis=0, padtype="line")
        self.x, self.force = self.x[::every][:len(low)], low[:len(self.x[::every])]

    def peak(self, wheel, bounds):
        near = (self.x[:, wheel] > bounds[0]) & (self.x[:, wheel] < bounds[1])
        return self.force[near, wheel].max()


def joint(x, depth, length):
    """Height of `irregularity.kind = "joint"` at x: two parabolas with a kink at 18 m."""
    return -depth * np.maximum(1 - np.abs(x - 18) / (length / 2), 0)**2


def check_forces(crossing, seeds, speed):
    """Peaks of the wheel forces and irregularity of three dips, over seeds of noise."""
    kernel = kernel_of(crossing, f"kernel_{speed:g}", speed)
    for depth, length in ((1.5e-3, 1.2), (3e-3, 2.0), (0.7e-3, 0.8)):
        name = f"joint_{1e3 * depth:g}_{speed:g}"
        run = crossing.run(name, f"irregularity.depth={depth:g}", f"irregularity.length={length:g}",
                           f"train.speed={speed:g}")
        truth, (signal, _) = Truth(crossing.folder / name), sensor(run)
        for noise, (of_force, of_height) in ALLOWED.items():
            peaks, heights, scores = [], [], []
            for seed in range(seeds):
                forces, *_ = inverse.evaluate(noisy(signal, seed, noise), kernel, speed)
                found = inverse.irregularity(forces, kernel, speed)
                for wheel, force in enumerate(forces.force):
                    expected = truth.peak(wheel, (forces.x[0], forces.x[-1]))
                    peaks.append(force.max() / expected - 1)
                    true = np.interp(forces.x, truth.x[:, wheel], truth.force[:, wheel])
                    scores.append(np.sqrt(np.mean(((force - true) / forces.deviation[wheel])**2)))
                error = np.abs(found.height - joint(found.x, depth, length)).max()
                heights.append(error / depth)
            print(f"{1e3 * depth:g} mm in {length:g} m, {speed:g} m/s, noise {100 * noise:g} %: "
                  f"peak {expected / 1e3:.0f} kN, error {np.median(np.abs(peaks)):.3f} (median), "
                  f"{np.abs(peaks).max():.3f} (worst of {len(peaks)}), over its deviation "
                  f"{np.median(scores):.2f}; irregularity {np.median(heights):.3f}, "
                  f"{max(heights):.3f}")
            require(np.abs(peaks).max() < of_force, f"peak force: {np.abs(peaks).max():.3f}")
            require(of_height is None or max(heights) < of_height,
                    f"irregularity: {max(heights):.3f}")


SIX = 'train.vehicles=["coach", "coach", "coach", "coach", "coach", "coach"]'


def main():
    program, deck, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    what = sys.argv[4] if len(sys.argv) > 4 else "known"
    number = int(sys.argv[5]) if len(sys.argv) > 5 else 1
    shutil.rmtree(folder, ignore_errors=True)
    crossing = Crossing(program, deck, folder)
    if what == "dips":
        check_indicator(crossing, number)
    elif what == "forces":
        check_forces(crossing, number, 50.0)
    else:
        check_displacement(crossing.run("known", SIX))
        check_train(crossing, folder / "known")


if __name__ == "__main__":
    main()
