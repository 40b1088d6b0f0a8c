"""Runs of the study shi, and the constants that its numbers and its document share."""
import json

from . import shi_space
from .shi_decks import (ALONE, DECK, DESIGNS, GRAVITY, GROUND, LOAD, NO_WEDGE, SHORT, STONES)
from .study import Run, as_file, deck_of

DECAY = 1.54257  # 1/m, of the seat loads: the default of load.decay, which the decks leave
S1, S2 = 6.1, 15.7  # m, x of a sleeper above the wedge and of one beyond it, chosen here
PACKINGS = (1, 2, 3, 4, 5)  # seeds
BELOW = 0.20  # m above the ground: sensors in the ballast, 0.15 m below the sleepers
KEPT = 1.0  # mm: a sleeper that keeps more has lost its support, and is not judged by acceleration
GONE = 3.0  # m, before and behind the ground where the first and the last axle start and stop


def seats(deck):
    of = deck["sleepers"]
    return [of["first"] + k * of["spacing"] for k in range(of["count"])]


def sensors(deck):
    """Sensors in the ballast below all sleepers."""
    return "sensor=[" + ",".join(f'{{name="below_{k}",at=[{x:g},0,{BELOW}],radius=0.04}}'
                                 for k, x in enumerate(seats(deck))) + "]"


def stiffness(value):
    """Of all contacts, N/m."""
    return tuple(f"contact.{k}.{key}={value:g}" for k in range(2) for key in ("k_n", "k_s"))


def thinner(metres):
    """A ground of another thickness below stones of that of the deck, with viscous sides: moduli
    and densities times the ratio of both."""
    ratio = metres / DECK["thickness"]
    return ("ground.sides=viscous",
            *(f"ground.{kind}.{each['name']}.{key}={ratio * each[key]:.6g}"
              for kind in ("layer", "block") for each in DECK["ground"][kind]
              for key in ("young", "density")))


def below_soil(modulus):
    """Springs of this modulus, Pa/m, below the soil, but not below the structure: a layer 0.1 m
    thick that does not expand sideways, on a fixed base."""
    thickness = 0.1
    layers = [*ALONE["ground"]["layer"], {"name": "springs", "thickness": thickness,
                                          "young": modulus * thickness, "poisson": 0,
                                          "density": 1850}]
    block = next(each for each in ALONE["ground"]["block"] if each["name"] == "structure")
    bottom = min(block["outline"])
    outline = [bottom - thickness if value == bottom else value for value in block["outline"]]
    text = ",".join("{" + ",".join(f"{key}={json.dumps(value)}" for key, value in layer.items())
                    + "}" for layer in layers)
    return (f"ground.layer=[{text}]",
            f"ground.block.structure.outline=[{','.join(f'{value:g}' for value in outline)}]",
            f"ground.elements_z={ALONE['ground']['elements_z'] + 1}")


def stones(packing):
    """The bed is laid and loaded on a ground at rest, so both designs have the same stones."""
    wedge = f"stones_wedge_{packing}"
    words = (f"bed.seed={packing}", sensors(DECK))
    return [Run(wedge, STONES, words),
            Run(f"stones_none_{packing}", STONES,
                (*words, *NO_WEDGE, f"start='{{folder}}/{wedge}/stage_trains.h5'"))]


def on_packing_1(name, design, *words, start="stones_wedge_1/stage_trains.h5"):
    return Run(f"stones_{design}_{as_file(name)}", STONES,
               ("bed.seed=1", sensors(DECK), *DESIGNS[design], *words,
                f"start='{{folder}}/{start}'"))


def variants():
    """Runs on the stones of packing 1, with changes."""
    found = [on_packing_1(name, design, *words) for name, words in STONES_BOTH.items()
             for design in DESIGNS]
    found += [on_packing_1(name, "none", *words) for name, words in STONES_NONE.items()]
    found += [on_packing_1(name, "wedge", *words) for name, words in WEDGES.items()]
    return [*found,
            *prepared(TRAINED, f"stage.trains.cycles={MANY_TRAINS}", "stage.trains.settlement=0",
                      start="stones_wedge_1/stage_bed_in.h5"),
            *prepared(FULL_FRICTION, "stage.bed_in.friction=-1",
                      start="stones_wedge_1/stage_sleepers.h5")]


def prepared(name, *words, start):
    """Both designs on the stones of packing 1 that are prepared in another way."""
    first = on_packing_1(name, "wedge", *words, start=start)
    return [first, on_packing_1(name, "none", start=f"{first.name}/stage_trains.h5")]


# Maps of the velocity when the first axle is here, m: field files at each metre of the train.
AXLE_AT = (2, 8, 15)
MAPPED = {"velocity": (1e3, "mm/s"), "acceleration": (1 / GRAVITY, "g")}  # factor and unit


def maps(design):
    """The passage of packing 1 again, with fields."""
    fields = ("output.fields=true", f"output.fields_interval={1 / LOAD['speed']:.7g}",
              'output.fields_parts=["stones","ground"]')
    return Run(f"maps_{design}", STONES,
               ("bed.seed=1", sensors(DECK), *DESIGNS[design], *fields,
                "start='{folder}/stones_wedge_1/stage_trains.h5'"))


def at_speed(kmh):
    """The same loads at another speed."""
    speed = kmh / 3.6
    duration = (ALONE["ground"]["x"][1] + 2 * GONE + LOAD["axles"][-1]) / speed
    return (f"load.speed={speed:.6g}", f"passage.duration={duration:.4g}",
            f"output.history_interval={min(1e-3, 5e-3 / speed):.4g}")


def wedge_of(outline, reach):
    """A wedge of another outline, and the surface layer above it up to x = reach."""
    points = ",".join(f"{value:g}" for value in outline)
    return (f"ground.block.wedge.outline=[{points}]",
            f"ground.block.wedge_surface.outline=[2,0,{reach:g},0,{reach:g},-0.6,2,-0.6]")


# An HXD1 unit of 100 t as a vehicle: masses, inertias and suspension are chosen here.
MASSES = {"body": 60000, "bogie": 15000, "wheelset": 2500}  # kg
WHEEL = (MASSES["body"] + 2 * MASSES["bogie"] + 4 * MASSES["wheelset"]) / 8 * GRAVITY  # N, at rest
VEHICLE = ("passage.loaded_by=train", "load={}", 'train.vehicles=["hxd1"]',
           'vehicle=[{name="hxd1",kind="coach",length=17.6,'
           + "".join(f"{part}_mass={mass}," for part, mass in MASSES.items()) +
           "primary_stiffness=4e6,primary_damping=60e3,secondary_stiffness="
           "1.2e6,secondary_damping=120e3,bogie_distance=9.0,wheelbase=2.8}]",
           f"train.speed={LOAD['speed']}", "train.start=0", "rail.section=CHN60",
           "pad.stiffness=100e6", "pad.damping=50e3", "passage.duration=2.1")
SPEEDS = (40, 120, 200, 270, 350)  # km/h, besides that of the study
MANY_TRAINS = 10  # of the preparation, in the place of those of the deck
SHOWN_TRAINS = (1, 2, 5, 10)
# Variants of the ground alone: title -> words. The first is that of the deck.
FIXED = "as in the deck: fixed base, rollers at the sides"
BOUNDARIES = {
    FIXED: (),
    "viscous sides": ("ground.sides=viscous",),
    "viscous base on springs of 1e8 Pa/m, viscous sides": (
        "ground.base=viscous", "ground.base_stiffness=1e8", "ground.sides=viscous"),
    "viscous base on springs of its shear modulus over its depth, viscous sides": (
        "ground.base=viscous", "ground.sides=viscous"),
    "viscous base without springs, viscous sides": (
        "ground.base=viscous", "ground.base_stiffness=0", "ground.sides=viscous"),
}
ON_SPRINGS = "ground 1 m thick, viscous base on springs of 1e8 Pa/m, viscous sides"
SOIL_ON_SPRINGS = "ground 1 m thick, springs of 1e8 Pa/m below the soil alone, viscous sides"
OPEN = {
    "ground 1 m thick instead of 1.3 m": ("thickness=1",),
    "ground 1 m thick, viscous sides": ("thickness=1", "ground.sides=viscous"),
    ON_SPRINGS: ("thickness=1", "ground.base=viscous", "ground.base_stiffness=1e8",
                 "ground.sides=viscous"),
    SOIL_ON_SPRINGS: ("thickness=1", "ground.sides=viscous", *below_soil(1e8)),
    "plane strain": ("ground.plane=strain",),
    "loads of a power of the distance": ("load.kind=power", "load.ratio=0.5531"),
}
CONVERGENCE = {
    "twice as many elements each way": ("ground.elements_x=340", "ground.elements_z=112"),
    "the study's 300 x 100 elements": ("ground.elements_x=300", "ground.elements_z=100"),
    "half the step": ("passage.step=6.6e-6",),
    "ground 8 m longer": ("ground.x=[0,25]", "ground.elements_x=250", "footing.count=40",
                          "track.length=37.8", "track.zone=[]"),
}
WEDGES = {
    "slope 1:1, 8 m long at the top": wedge_of((2, -0.6, 10, -0.6, 5, -5.6, 2, -5.6), 10),
    "without a bottom, 10 m long at the top": wedge_of((2, -0.6, 12, -0.6, 2, -5.6), 12),
    "upside down, 13 m long at the bottom": wedge_of((2, -0.6, 5, -0.6, 15, -5.6, 2, -5.6), 5),
    "surface layer alone, 13 m": ("ground.block.wedge.present=false",),
}
LOADED = "vehicle on a rail"
# The same loads as a table with 100 rows per second, linear between them: its first axle is above
# the first sleeper of the track after 0.25 s.
SAMPLED = "loads sampled at 100 Hz"
TABLE = (f'load={{kind="table",file="{{inputs}}/shi/seat_load_100hz.csv",speed={LOAD["speed"]}}}',
         "passage.duration=2.34")


# Changes of runs on the stones of packing 1, on both grounds or on that without wedge.
STONES_BOTH = {
    "pitch": ('sleepers.free=["z","ry"]',),
    "viscous": ("ground.base=viscous", "ground.base_stiffness=1e8", "ground.sides=viscous"),
    "thin": thinner(1.0),
    SAMPLED: TABLE[:1],
    LOADED: (*(word for word in VEHICLE if not word.startswith("passage.")),
             "stage.passage.train=true"),
    **{f"{kmh} km/h": (f"load.speed={kmh / 3.6:.6g}",) for kmh in SPEEDS},
}
STONES_NONE = {
    "soft": stiffness(2.5e8),
    "stiff": stiffness(1e9),
    "half the step": ("time.window=1.388e-5", "time.step=0.694e-5"),
}
TRAINED = "more trains"
FULL_FRICTION = "loads with full friction"  # while the bed is prepared


def ground(name, design, *words):
    return Run(f"ground_{design}_{as_file(name)}", GROUND, (*DESIGNS[design], *words))


def runs(form, ranks):
    found = []  # on one rank: runs side by side use several better than one run on all of them
    if form == "short":
        words = (f"material.ballast.density={DECK['material'][0]['density']}",
                 sensors(deck_of(SHORT)))
        found += [Run("short_wedge", SHORT, words),
                  Run("short_none", SHORT, (*words, *NO_WEDGE,
                                            "start='{folder}/short_wedge/stage_trains.h5'"))]
        return found + [ground(FIXED, design) for design in DESIGNS]
    for packing in PACKINGS:
        found += stones(packing)
    found += variants()
    found += [maps(design) for design in DESIGNS]
    for design in DESIGNS:
        found += [ground(name, design, *words)
                  for group in (BOUNDARIES, OPEN, CONVERGENCE) for name, words in group.items()]
        found += [ground(f"{kmh} km/h", design, *at_speed(kmh)) for kmh in SPEEDS]
        found += [ground(LOADED, design, *VEHICLE), ground(SAMPLED, design, *TABLE)]
    found += [ground(name, "wedge", *words) for name, words in WEDGES.items()]
    return found + shi_space.runs(ranks)
