"""The part of the study crossing that compares wheel forces over a V with formulas: an independent
check of the simulated forces, which are the truth of all other parts.
"""
import h5py
import numpy as np
import scipy.signal

from .study import Run, deck_of, summary

VEES = (27.8, 44.4)  # m/s
ANGLE = 20e-3  # rad, of the V in all
DAMPINGS = {"deck": 1.0, "tenth": 0.1}  # of the ballast
LOW = 150.0  # Hz
EFFECTIVE = 0.4  # m, of rail that moves with the contact in Jenkins' P1


def name_of(speed, damping):
    return f"vee_{speed:g}_{damping}"


def runs(deck):
    damping = deck_of(deck)["ballast"]["damping"]
    return [Run(name_of(speed, name), deck,
                (f"train.speed={speed}", "irregularity.kind=vee", "irregularity.length=1",
                 f"irregularity.depth={ANGLE / 4}", "track.zone=[]",
                 f"ballast.damping={factor * damping}"))
            for speed in VEES for name, factor in DAMPINGS.items()]


def measure(folder, deck, sensor, numbers):
    """Largest forces of the first wheel over a V and those below 150 Hz, beside Jenkins' P1 and
    P2."""
    for speed in VEES:
        for name, factor in DAMPINGS.items():
            run = name_of(speed, name)
            with h5py.File(folder / run / "results.h5") as file:
                x, force = (file[f"history/wheel/{what}"][:, 0] for what in ("x", "force"))
                step = float(np.mean(np.diff(file["history/time"][()])))
            low = scipy.signal.butter(2, LOW, fs=1 / step, output="sos")
            near = (x > sensor - 1) & (x < sensor + 3)
            contact = summary(folder / run, "track", "wheel_rail_constant")
            first, second = formulas(deck, speed, force[0], contact, factor)
            for quantity, value in (
                    ("static force", force[0]), ("largest force", force[near].max()),
                    ("P1", first), ("P2", second),
                    ("largest force below 150 Hz",
                     scipy.signal.sosfiltfilt(low, force)[near].max())):
                numbers.put(run, quantity, 1e-3 * value, "kN")


def formulas(deck, speed, load, contact, damping):
    """(P1, P2), N, of Jenkins, Stephenson, Clayton, Morland and Lyon 1974 (Railway Engineering
    Journal 3(1), 2-16), as later authors give them: the wheel strikes the rail with the angle times
    the speed. `damping`: factor of that of the ballast."""
    bed_of, pad = deck["ballast"], deck["pad"]["stiffness"]
    wheel = deck["vehicle"][0]["wheelset_mass"] / 2
    bending, rail = 210e9 * 3038.3e-8, 60.21  # of 60E1, N m2, kg/m
    spacing = deck["track"]["spacing"]
    bed = 1 / (1 / bed_of["stiffness"] + 1 / pad) / spacing
    length = (4 * bending / bed)**0.25  # m, of a beam on a Winkler bed
    mass = 1.5 * length * (rail + deck["track"]["sleeper_mass"] / 2 / spacing)
    stiffness, damper = 2 * bed * length, 1.5 * length * damping * bed_of["damping"] / spacing
    impact = ANGLE * speed
    hertz = 1.5 * contact**(2 / 3) * load**(1 / 3)
    light = EFFECTIVE * rail
    first = load + impact * np.sqrt(hertz * light / (1 + light / wheel))
    second = load + impact * np.sqrt(wheel / (wheel + mass)) * np.sqrt(stiffness * wheel) * (
        1 - damper * np.pi / (4 * np.sqrt(stiffness * (wheel + mass))))
    return first, second
