#!/usr/bin/env python3
"""Condition monitoring of the program's own passages over a crossing, whose truth is known.

    monitor.py PROGRAM DECK FOLDER

Sleeper accelerations are those of every time step, resampled to 5 kHz behind a low-pass filter as a
sensor does, with white noise.
"""
import pathlib
import shutil
import sys

import numpy as np
import scipy.signal

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "postproc")]
from program import Program  # noqa: E402
from trackbed_post import read  # noqa: E402
from trackbed_post.monitor import displacement, passages  # noqa: E402

RATE = 5000.0  # Hz
SEEDS = range(10)
NOISE = 1e-3  # of the root mean square of the acceleration


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


def noisy(signal, seed):
    size = NOISE * np.sqrt(np.mean(signal**2))
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


SIX = 'train.vehicles=["coach", "coach", "coach", "coach", "coach", "coach"]'


def main():
    program, deck, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    crossing = Crossing(program, deck, folder)
    check_displacement(crossing.run("known", SIX))
    check_train(crossing, folder / "known")


if __name__ == "__main__":
    main()
