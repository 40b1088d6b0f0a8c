"""Constants and runs of the study chen (inputs/chen/slice.toml)."""
import numpy as np

from .study import Run, deck_of

SLICE = "chen/slice.toml"
DECK = deck_of(SLICE)
GRAVITY = 9.81
PACKINGS = (1, 2, 3)  # seeds
CARRIAGES = 2
CARRIAGE, GAP = 25.5, 5.5  # m, its length and the distance of neighbouring axles of two
AXLES = DECK["load"]["axles"]
EXTREMES = ((17, 120), (25, 120))  # of which there are several packings
# The other axle loads, t, and speeds, km/h, of the full form; on one packing.
LOADS, SPEEDS = (17, 20, 25), (60, 90, 120, 150)
SERIES = tuple((tonnes, kmh) for tonnes in (20, 25, 17) for kmh in (120, 150, 60, 90)
               if (tonnes, kmh) not in EXTREMES)
RIG = (17, 300)  # load and speed of the test rig
LIGHT = "light_sleepers"  # run whose sleepers have a tenth of the mass, nearly the study's walls
SINE, SINE_STRESS, SINE_SPEED = 16.6, 250e3, 160 / 3.6  # Hz, Pa, m/s, of the load of one sleeper
CYCLES = 5  # of it, the last of which counts: the first ones rearrange the bed
# Corners that break off become fines: fragments smaller than the sub-ballast would make the
# sub-step shorter. The short form has fewer, larger stones and spheres.
FORMS = {"full": ("breakage.least_size=0.0198",),
         "short": ("breakage.least_size=0.0297", "bed.sieve=[37.5,53,63]", "bed.passing=[0,80,100]",
                   "bed.layer.sub_ballast.sieve=[29.7,30.3]")}
# The bed alone: sleepers are loaded by nothing for as short a time as a passage may last.
ALONE = ("load.wheel_load=1", "load.axles=[0]", "load.start=-0.3", "stage.train.duration=0.02")
SLEEPERS = range(1, DECK["sleepers"]["count"] + 1)
MIDDLE = DECK["sleepers"]["count"] // 2  # sleeper 3
AREA = DECK["sleepers"]["width"] * DECK["sleepers"]["length"]  # m2
HEIGHT = next(stage["height"] for stage in DECK["stage"] if stage["name"] == "sleepers")  # m
TOTAL, SUB_BALLAST = 0.45, DECK["bed"]["layer"][0]["height"]  # m, below sleepers
DEPTHS = (0.10, 0.23, 0.35)  # m, below the sleepers
CELL = np.ptp(DECK["region"][0]["x"]) / DECK["region"][0]["cells"][0]  # m, along the track
EDGE = DECK["sleepers"]["width"] / 2  # m
LEAD = 1.0  # m, before and behind an axle or a bogie that is near
AROUND = 2.5  # m, before and behind a bogie, where the seat load has fallen to almost 0
COMPONENTS = {"vertical": 2, "horizontal": 0, "shear": 4}


def train(tonnes, kmh):
    """A train of CARRIAGES."""
    axles = ",".join(f"{x:g}" for x in AXLES if x < CARRIAGES * CARRIAGE)
    return (f"load.wheel_load={tonnes / 2 * 1e3 * GRAVITY:.6g}", f"load.speed={kmh / 3.6:.6g}",
            f"load.axles=[{axles}]")


def name_of(tonnes, kmh, packing):
    return f"t{tonnes}_v{kmh}_{packing}"


DRAWN = tuple(name_of(*case, 1) for case in EXTREMES)  # runs whose histories are drawn


def seat_share(distance):
    """Seat load at a distance from an axle, m, relative to its peak."""
    return DECK["load"]["ratio"]**(distance / DECK["sleepers"]["spacing"])**2


def bed(form, packing):
    return Run(f"bed_{packing}", SLICE, (f"bed.seed={packing}", *FORMS[form], *ALONE))


def on_bed(name, form, packing, *words):
    """On a prepared bed."""
    return Run(name, SLICE, (f"bed.seed={packing}", f"breakage.seed={packing}", *FORMS[form],
                             *words, f"start='{{folder}}/bed_{packing}/stage_sleepers.h5'"))


def passage(form, tonnes, kmh, packing):
    return on_bed(name_of(tonnes, kmh, packing), form, packing, *train(tonnes, kmh))


def runs(form, ranks):
    del ranks  # runs side by side use them better than one run on all of them
    found = [bed(form, packing) for packing in PACKINGS]
    found += [passage(form, *case, packing) for packing in PACKINGS for case in EXTREMES]
    if form == "full":
        found += [passage(form, *case, PACKINGS[0]) for case in (RIG, *SERIES)]
        found.append(on_bed(LIGHT, form, PACKINGS[0],
                            f"material.2.density={DECK['material'][2]['density'] / 10:g}",
                            *train(25, 120)))
        found.append(on_bed("haversine", form, PACKINGS[0], "load.kind=table",
                            "load.file='{folder}/sine.csv'", "load.wheel_load=0",
                            f"load.speed={SINE_SPEED:.6g}"))
    return found


def prepare(program, folder):
    """The load of a sleeper whose stress is a row of haversines."""
    del program
    time = np.linspace(0, CYCLES / SINE, 60 * CYCLES + 1)
    rows = "".join(f"{t:.6g},{SINE_STRESS * AREA * np.sin(np.pi * SINE * t)**2:.6g}\n"
                   for t in time)
    (folder / "sine.csv").write_text("time_s,force_N\n" + rows, encoding="utf-8")
