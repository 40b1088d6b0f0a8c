"""Runs, numbers and targets of the study chen: five sleepers on ballast that breaks and sub-ballast
(inputs/chen/slice.toml), loaded by carriages of several axle loads and speeds. Its document:
chen_document.py.
"""
import numpy as np

from .study import Run, deck_of

SLICE = "chen/slice.toml"
DECK = deck_of(SLICE)
GRAVITY = 9.81
LOADS, SPEEDS = (17, 20, 25), (60, 90, 120, 150)  # t per axle, km/h
PACKINGS = (1, 2, 3)  # seeds
CARRIAGE = 25.5  # m
AXLES = DECK["load"]["axles"]
EXTREMES = ((17, 120), (25, 120))  # of which there are three packings
# Corners that break off become fines: fragments of 20 mm are the largest that pass for sub-ballast,
# and smaller ones would make the sub-step shorter.
FINES = ("breakage.least_size=0.0198",)
# The bed alone: sleepers are loaded by nothing for as short a time as a passage may last.
ALONE = ("load.wheel_load=1", "load.axles=[0]", "load.start=-0.3", "stage.train.duration=0.02")
RIG = (17, 300)  # the test rig's load and speed
SINE = 16.6  # Hz, of the loads that verify the stress path
SINE_STRESS, SINE_SPEED = 250e3, 160 / 3.6  # Pa, m/s


def train(tonnes, kmh, carriages=2):
    """A train of carriages."""
    axles = ",".join(f"{x:g}" for x in AXLES if x < carriages * CARRIAGE)
    return (f"load.wheel_load={tonnes / 2 * 1e3 * GRAVITY:.6g}", f"load.speed={kmh / 3.6:.6g}",
            f"load.axles=[{axles}]")


def name_of(tonnes, kmh, packing):
    return f"t{tonnes}_v{kmh}_{packing}"


def bed(packing):
    return Run(f"bed_{packing}", SLICE, (f"bed.seed={packing}", *FINES, *ALONE))


def on_bed(name, packing, *words):
    """A run that begins with a prepared bed."""
    return Run(name, SLICE, (f"bed.seed={packing}", f"breakage.seed={packing}", *FINES, *words,
                             f"start='{{folder}}/bed_{packing}/stage_sleepers.h5'"))


def passage(tonnes, kmh, packing):
    return on_bed(name_of(tonnes, kmh, packing), packing, *train(tonnes, kmh))


def runs(form, ranks):
    del ranks  # runs side by side use them better than one run on all of them
    found = [bed(packing) for packing in PACKINGS]
    found += [passage(*case, packing) for packing in PACKINGS for case in EXTREMES]
    if form == "full":
        found += [passage(tonnes, kmh, 1) for tonnes in LOADS for kmh in SPEEDS
                  if (tonnes, kmh) not in EXTREMES]
        found.append(passage(*RIG, 1))
        found.append(on_bed("five_carriages", 1, *train(20, 120, carriages=5)))
        found.append(on_bed("sine", 1, "load.kind=table", "load.file='{folder}/sine.csv'",
                            "load.wheel_load=0", f"load.speed={SINE_SPEED:.6g}"))
    return found


def prepare(program, folder):
    """The load of one sleeper whose stress is a single haversine."""
    del program
    force = SINE_STRESS * DECK["sleepers"]["width"] * DECK["sleepers"]["length"]
    time = np.linspace(0, 1 / SINE, 61)
    rows = "".join(f"{t:.6g},{force * np.sin(np.pi * SINE * t)**2:.6g}\n" for t in time)
    (folder / "sine.csv").write_text("time_s,force_N\n" + rows, encoding="utf-8")
