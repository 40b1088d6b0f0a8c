"""The part of the study crossing that looks for the causes of errors of the irregularity: the place
of the train in the record, the identified force, noise, and wheels that leave the rail.
"""
import dataclasses

import numpy as np

from trackbed_post import read
from trackbed_post.monitor import inverse

OFFSETS = (-2, -1, -0.5, 0, 0.5, 1, 2)  # cm, of the assumed from the true place of the train
NOISE = 1e-3
SPEED = 50.0   # m/s
LIFTED = 0.1   # of the static force: a wheel with less hardly touches the rail
NEAR = 1.5     # m, from the sensor: where the wheel may lift
# How the place of the train is found, and what else is exact: key of numbers.csv, words.
PLACINGS = {"chain": "the chain as it is", "displacement": "place from the displacement alone",
            "place": "place exact", "silent": "place exact, no noise",
            "force": "place and forces exact"}


def true_forces(passage, x):
    """N, of both wheels of the first bogie at positions x."""
    return np.array([np.interp(x, passage.x[:, wheel], passage.force[:, wheel])
                     for wheel in (0, 1)])


def at_place(passage, kernel, offset, noise=NOISE):
    """Forces for a train that is assumed `offset` m ahead of its true place."""
    return inverse.identify(inverse.Problem(passage.noisy(noise, 0), kernel, SPEED,
                                            passage.x[0, 0] + offset))


def measure_sweep(passage, kernel, run, true, depth, numbers):
    """Errors by the error of the place. `true`: height, m, of the running surface at x."""
    bounds = (kernel.sensor + inverse.RANGE[0], kernel.sensor + inverse.RANGE[1])
    largest = passage.force[passage.near(0, bounds), 0].max()
    for offset in OFFSETS:
        forces = at_place(passage, kernel, offset / 100)
        surface = inverse.irregularity(forces, kernel, SPEED, draws=0)
        error = np.abs(surface.height - true(surface.x)).max()
        for what, value in (("irregularity", error / depth),
                            ("largest force", abs(forces.force[0].max() / largest - 1))):
            numbers.put(run, f"error of the {what}, place wrong by {offset:g} cm", 100 * value, "%")


def found_by(placing, passage, kernel):
    """(forces, error of the place, m), or None if the passage is refused."""
    if placing in ("chain", "displacement"):
        try:
            forces, came, _ = inverse.evaluate(passage.noisy(NOISE, 0), kernel, SPEED,
                                               refined=placing == "chain")
        except read.Unreadable:
            return None
        return forces, came.start - passage.x[0, 0]
    forces = at_place(passage, kernel, 0.0, 0.0 if placing == "silent" else NOISE)
    if placing == "force":
        forces = dataclasses.replace(forces, force=true_forces(passage, forces.x))
    return forces, 0.0


def measure_causes(passage, kernel, run, true, depth, numbers):
    """Errors of the irregularity if parts of the chain are exact, everywhere and where the wheel
    touches the rail; one seed."""
    x, force = passage.x[:, 0], passage.force[:, 0]
    near = np.abs(x - kernel.sensor) < NEAR
    lifted = force < LIFTED * kernel.wheels.load[0]
    numbers.put(run, "way without contact", 100 * np.mean(np.diff(x)) * np.sum(lifted & near), "cm")
    for placing in PLACINGS:
        found = found_by(placing, passage, kernel)
        if found is None:
            every = touching = place = np.inf
        else:
            forces, place = found
            surface = inverse.irregularity(forces, kernel, SPEED, draws=0)
            error = np.abs(surface.height - true(surface.x)) / depth
            free = np.interp(surface.x, x, lifted) > 0
            every, touching, place = error.max(), error[~free].max(), 100 * place
        numbers.put(run, f"error of the irregularity, {placing}", 100 * every, "%")
        numbers.put(run, f"error of the irregularity, {placing}, touching", 100 * touching, "%")
        numbers.put(run, f"place, {placing}", place, "cm")
