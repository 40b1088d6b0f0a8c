"""Runs, numbers and targets of the study chen: five sleepers on ballast that breaks and sub-ballast
(inputs/chen/track.toml), loaded by carriages of several axle loads and speeds. Its document:
chen_document.py.
"""
from .study import Run, deck_of

TRACK = "chen/track.toml"
DECK = deck_of(TRACK)
GRAVITY = 9.81
LOADS, SPEEDS = (17, 20, 25), (60, 90, 120, 150)  # t per axle, km/h
PACKINGS = (1, 2, 3)  # seeds
CARRIAGE = 25.5  # m
CARRIAGES = {"short": 2, "full": 5}
AXLES = DECK["load"]["axles"]
EXTREMES = ((17, 120), (25, 120))  # of which there are three packings


def train(tonnes, kmh, form):
    """A train of the form's number of carriages."""
    axles = ",".join(f"{x:g}" for x in AXLES if x < CARRIAGES[form] * CARRIAGE)
    return (f"load.wheel_load={tonnes / 2 * 1e3 * GRAVITY:.6g}", f"load.speed={kmh / 3.6:.6g}",
            f"load.axles=[{axles}]")


def name_of(tonnes, kmh, packing):
    return f"t{tonnes}_v{kmh}_{packing}"


FIRST = (25, 120)  # the run that prepares the bed of its packing


def runs_of(form, cases):
    """Trains by axle load, speed and packing; all of a packing have the same bed."""
    found = []
    for tonnes, kmh, packing in cases:
        words = (f"bed.seed={packing}", f"breakage.seed={packing}", *train(tonnes, kmh, form))
        if (tonnes, kmh) != FIRST:
            bed = name_of(*FIRST, packing)
            words += (f"start='{{folder}}/{bed}/stage_sleepers.h5'",)
        found.append(Run(name_of(tonnes, kmh, packing), TRACK, words))
    return found


def runs(form, ranks):
    del ranks  # runs side by side use them better than one run on all of them
    cases = [(*case, packing) for packing in PACKINGS for case in (FIRST, (17, 120))]
    if form == "full":
        cases += [(tonnes, kmh, 1) for kmh in SPEEDS for tonnes in LOADS if (tonnes, kmh, 1) not in
                  cases]
    return runs_of(form, cases)
