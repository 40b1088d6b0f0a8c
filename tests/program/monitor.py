#!/usr/bin/env python3
"""Condition monitoring of the program's own passages over a crossing, whose truth is known.

    monitor.py PROGRAM DECK FOLDER

Sleeper accelerations are those of every time step, resampled to 5 kHz behind a low-pass filter as a
sensor does, with white noise.
"""
import pathlib
import shutil
import sys

import h5py
import numpy as np
import scipy.signal

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "postproc")]
from program import Program  # noqa: E402
from trackbed_post import read  # noqa: E402
from trackbed_post.monitor import ballast, displacement, greens, inverse, passages  # noqa: E402

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


def check_kernel(crossing):
    """Files are the same on any number of ranks; what has no Green's functions is refused with all
    reasons, and without a file."""
    folder, words = crossing.folder, ("--sensor", "18", "--duration", "0.05", "--apart", "0.2")
    range_of = ("--speed", "40", "--from", "17", "--to", "19")
    for ranks in (1, 2):
        crossing.program.done(ranks, "kernel", crossing.deck, "-o", folder / f"kernel_{ranks}.h5",
                              *words, *range_of)
    one, two = (read.datasets(folder / f"kernel_{ranks}.h5") for ranks in (1, 2))
    require(list(one) == list(two) and all(
        np.array_equal(one[name].values, two[name].values) for name in one), "kernels of 2 ranks")
    require(one["moving/left/axle_2"].values.shape == (11, 251), "shape of the moving response")
    # The first bogie has the axles within 4 m of the first one: at 0, 1.8 and 2.4 m, not at 4.2 m.
    crossing.program.done(1, "kernel", crossing.deck, "-o", folder / "bogie.h5", *words, *range_of,
                          "vehicle.coach.wheelbase=1.8", "vehicle.coach.bogie_distance=2.4")
    axles = [name for name in read.datasets(folder / "bogie.h5") if "moving/left/axle" in name]
    require(len(axles) == 3, f"axles of the first bogie: {axles}")
    kernel = greens.load(folder / "kernel_1.h5")
    require(kernel.sensor == 18 and np.allclose(kernel.wheels.mass, 670)
            and np.allclose(kernel.wheels.load.sum(), 4 * 15500 / 2 * 9.81, rtol=1e-3),
            "wheels of the kernel")
    space = folder / "space.h5"
    crossing.program.done(1, "kernel", crossing.deck, "track.dimension=space", "-o", space, *words,
                          "--side", "right")
    both = greens.load(space).fixed
    near, far = (np.abs(both[rail]["displacement"]).max() for rail in ("right", "left"))
    require(near > 1.5 * far > 0, f"rails: {near:.3g} and {far:.3g} m/N")
    for changes, why in (
            (("--sensor", "99", "--side", "right"), ("--sensor 99", "track.dimension")),
            (("--sensor", "18", "--speed", "50", "--from", "9", "--to", "8"), ("above --from",)),
            (("--sensor", "18", "--speed", "50", "--from", "40"), ("the end of the track",)),
            (("--sensor", "18", "--axles", "4"), ("--speed",)),
            (("--sensor", "18", "track.support=continuous"), ("track.support",)),
            (("--sensor", "18", "pad.uplift=true"), ("linear track",)),
            (("--sensor", "18", "--apart", "1e-3", "--duration", "10", "--rate", "1e5"),
             ("too many",))):
        path = folder / "refused.h5"
        ran = crossing.program.done(1, "kernel", crossing.deck, "-o", path, *changes, code=2)
        require(all(reason in ran.stderr for reason in why) and not path.exists(), ran.stderr)
    ran = crossing.program.done(1, "kernel", crossing.deck.parents[1] / "ground" / "strip.toml",
                                "-o", folder / "refused.h5", "--sensor", "1", code=2)
    require("track alone" in ran.stderr, ran.stderr)


def check_chain(crossing, folder):
    """Green's functions of the program give its own passage of a coach; the inversion gives its
    wheel forces, and the calibration the stiffness of its ballast."""
    crossing.program.done(1, "kernel", crossing.deck, "-o", folder.parent / "chain.h5", "--sensor",
                          "18")
    kernel, run = greens.load(folder.parent / "chain.h5"), read.results(folder)
    signal, truth = sensor(run)
    with h5py.File(folder / "results.h5") as file:
        x, fast = (file[f"history/wheel/{name}"][()] for name in ("x", "force"))
    every = round(1 / (RATE * float(np.mean(np.diff(run.time)))))
    force = scipy.signal.resample_poly(fast, 1, every, axis=0, padtype="line")
    x = x[::every]
    for name, true, most in (("displacement", truth, 1e-3), ("acceleration", signal, 2e-2)):
        found = sum(greens.superposed(kernel.fixed["left"][name], kernel.x, x[:, wheel],
                                      force[:len(x), wheel], len(true)) for wheel in range(4))
        error = np.sqrt(np.mean((found - true)**2) / np.mean(true**2))
        print(f"superposed {name}: error {error:.2g} of its root mean square")
        require(error < most, f"superposed {name}: {error:.2g}")
    forces, came, _ = inverse.evaluate(noisy(signal, 1), kernel, 50.0)
    error = forces.force[0].max() / force[np.abs(x - 18) < 3].max() - 1
    print(f"largest force: error {error:.3f}; arrival: {came.start - x[0, 0]:.4f} m")
    require(abs(error) < 0.06 and abs(came.start - x[0, 0]) < 0.01, "forces of the chain")
    track = ballast.Track(crossing.program.path, crossing.deck, 18.0, 50.0)
    found, _ = ballast.calibrate(noisy(signal, 1), RATE, track, ("inside", "outside", "dip"))
    print(f"ballast: {found.value['inside']:.4g} N/m")
    require(abs(found.value["inside"] / 18e6 - 1) < 0.1, "stiffness of the ballast")


SIX = 'train.vehicles=["coach", "coach", "coach", "coach", "coach", "coach"]'


def main():
    program, deck, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    crossing = Crossing(program, deck, folder)
    check_kernel(crossing)
    check_displacement(crossing.run("known", SIX))
    check_train(crossing, folder / "known")
    check_chain(crossing, folder / "single")


if __name__ == "__main__":
    main()
