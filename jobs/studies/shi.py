"""Runs, numbers and targets of the study shi: a locomotive from a rigid structure to an embankment,
with and without a wedge of stiffer backfill. Its document: shi_document.py.

The transition is modelled with stones (inputs/shi/transition.toml) and, for comparisons of grounds,
boundaries and speeds, as its ground alone under the same seat loads (inputs/shi/ground.toml). The
short form has the shorter transition of inputs/shi/short.toml.
"""
import re

import h5py
import numpy as np
import scipy.optimize

from .shi_decks import (ALONE, DECK, DESIGNS, EDGE, FILTER, GRAVITY, GROUND, LOAD, NO_WEDGE, SHORT,
                        SPACING, STONES, TITLES, filtered_acceleration)
from .study import Lines, Run, Target, as_file, deck_of, summary

from trackbed_post import measures, read, signals  # noqa: I001 (found by .study)

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
OPEN = {
    "ground 1 m thick instead of 1.3 m": ("thickness=1",),
    "ground 1 m thick, viscous sides": ("thickness=1", "ground.sides=viscous"),
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
    del ranks  # runs side by side use them better than one run on all of them
    found = []
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
    return found + [ground(name, "wedge", *words) for name, words in WEDGES.items()]


def measure(form, folder, numbers, lines):
    """Displacements downwards in mm, compressions in kPa, accelerations in g."""
    surfaces = {}
    for run in runs(form, 1):
        place = folder / run.name
        if run.deck == GROUND:
            surfaces[run.name] = measure_ground(run.name, place, numbers, lines)
        elif run.name.startswith("maps"):
            measure_maps(run.name, place, numbers, lines)
        else:
            surfaces[run.name] = measure_stones(run.name, place, numbers, lines)
        numbers.put(run.name, "wall_time", float(summary(place, "wall_time_s")), "s")
    for name, (x, down) in surfaces.items():
        numbers.put(name, "ground, 90 % of the rise",
                    rise(x, down, numbers(name, "ground, structure"), plain_of(name, numbers)), "m")


def plain_of(name, numbers):
    """Displacement of plain track, which is the same in all designs, mm: that of the run without
    wedge, from 6 m behind the edge to where the end of the ground acts."""
    other = name.replace("_wedge", "_none")
    if not numbers.has(other):  # another wedge
        other = f"ground_none_{as_file(FIXED)}"
    for where in ("ground, 6 to 11 m", "ground, far"):  # the latter of a short bed
        if (other, where) in numbers.rows:
            return numbers(other, where)
    raise KeyError(other)


def rise(x, down, structure, far):
    """Distance behind the edge, m, at which 90 % of the change of a displacement from `structure`
    to `far` is reached, by a curve 1 - exp(-(s/l)^p) of least squares: single places, which stones
    load unequally, do not decide."""
    s, reached = x[x > EDGE] - EDGE, (down[x > EDGE] - structure) / (far - structure)

    def curve(s, length, power):
        return 1 - np.exp(-(s / length)**power)
    try:
        (length, power), _ = scipy.optimize.curve_fit(curve, s, reached, p0=(1, 1),
                                                      bounds=((0.05, 0.3), (60, 10)))
    except (RuntimeError, ValueError):  # no least squares found, or no change
        return np.nan
    return length * np.log(10)**(1 / power)


def put_surface(name, x, down, length, numbers, lines):
    """Of the largest downward displacement of the ground's surface; `length`: of the bed, m."""
    # The nodes nearest to the edge belong to both sides.
    structure = down[x <= EDGE - SPACING / 2].max()
    numbers.put(name, "ground, structure", structure, "mm")
    numbers.put(name, "ground, far", np.median(down[(x >= length - 2) & (x <= length)]), "mm")
    plateau = (x >= EDGE + 6) & (x <= EDGE + 11)
    if plateau.any():
        numbers.put(name, "ground, 6 to 11 m", np.median(down[plateau]), "mm")
    numbers.put(name, "ground, most", down.max(), "mm")
    slope = np.gradient(measures.smoothed(x, down, SPACING), x)
    inside = x <= length - 1.5  # the end of the ground acts behind it
    numbers.put(name, "ground, steepest", slope[inside].max(), "mm/m")
    numbers.put(name, "ground, x of the steepest", x[inside][np.argmax(slope[inside])], "m")
    lines.put("ground", name, x, down)


def measure_ground(name, place, numbers, lines):
    with h5py.File(place / "results.h5") as file:
        of = {what: file[f"history/{what}/displacement"][()] for what in ("ground", "sleeper")}
        force, time = file["history/ground/force"][()], file["history/time"][()]
        acceleration = file["history/sleeper/acceleration"][()]
    x = np.array(seats(DECK))
    down = {what: -1e3 * values.min(axis=0) for what, values in of.items()}
    put_surface(name, x, down["ground"], DECK["ground"]["x"][1], numbers, lines)
    numbers.put(name, "sleeper, structure", down["sleeper"][x < EDGE].mean(), "mm")
    put_acceleration(name, np.abs(FILTER(time, acceleration)).max(axis=0) / GRAVITY, numbers)
    largest = 1e-3 * force.max(axis=0)
    numbers.put(name, "ballast force, structure", largest[x < EDGE].mean(), "kN")
    numbers.put(name, "ballast force, most", largest.max(), "kN")
    numbers.put(name, "ballast force, far", np.median(largest[x >= 15]), "kN")
    return x, down["ground"]


def put_stress(name, run, numbers, lines):
    """Of the largest vertical stress of each node of the surface, which counts from the begin of
    the passage, in the sleeper spacings before and behind the edge: the largest before less the
    least behind it, and the difference of their means. For comparison both, with spacings that lie
    in the same way, at all sleepers beyond. The node nearest to the edge belongs to neither side.
    """
    order = np.argsort(run.ground_x)
    x, compression = run.ground_x[order], -1e-3 * run.ground_envelope["sigma_z_min"].values[order]
    mesh = np.diff(x).mean()

    def sides(at):
        return (compression[(x > at - SPACING) & (x < at - 0.51 * mesh)],
                compression[(x > at + 0.51 * mesh) & (x < at + SPACING)])
    offset = EDGE - run.sleepers_x[run.sleepers_x < EDGE][-1]
    places = [EDGE, *(run.sleepers_x[run.sleepers_x > EDGE][1:-2] + offset)]
    before, behind = zip(*map(sides, places))
    numbers.put(name, "stress, most before the edge", before[0].max(), "kPa")
    numbers.put(name, "stress, least behind the edge", behind[0].min(), "kPa")
    numbers.put(name, "stress, mean before the edge", before[0].mean(), "kPa")
    numbers.put(name, "stress, mean behind the edge", behind[0].mean(), "kPa")
    for what, first, second in (("nodes", np.max, np.min), ("means", np.mean, np.mean)):
        steps = [first(one) - second(other) for one, other in zip(before, behind)]
        numbers.put(name, f"difference of {what} beyond, mean", np.mean(steps[1:]), "kPa")
        numbers.put(name, f"difference of {what} beyond, standard deviation",
                    np.std(steps[1:], ddof=1), "kPa")
    lines.put("stress", name, x, compression)


def fluctuation(values):
    """Mean difference between neighbours over the mean."""
    return np.abs(np.diff(values)).mean() / values.mean()


def put_spectra(name, time, run, rows, stones_velocity, numbers, lines):
    """Peaks of the spectra of the accelerations of sleepers and of the ballast below them, and of
    the quasi-static one, that of the seat forces times the frequency squared. Root mean square over
    all sleepers."""
    frequency, acceleration = signals.spectrum(
        time, filtered_acceleration(time, run.sleeper["velocity"].values[rows]))
    _, stones = signals.spectrum(time, filtered_acceleration(time, stones_velocity))
    _, force = signals.spectrum(time, run.sleeper["seat_force"].values[rows])
    amplitudes = {"acceleration": acceleration, "ballast acceleration": stones,
                  "seat force": force * frequency[:, None]**2}
    means = {what: np.sqrt((of**2).mean(axis=1)) for what, of in amplitudes.items()}
    for mark, line in measures.loading_frequencies(run).items():
        for what, mean in means.items():
            peak = signals.peak_near(frequency, mean, line)
            if peak is not None:
                numbers.put(name, f"{mark}, {what}", peak, "Hz")
    shown = (frequency > 0.2) & (frequency < 15)
    for what, mean in means.items():
        lines.put("spectra", f"{name}, {what}", frequency[shown], (mean / mean[shown].max())[shown])


def ahead(x, velocity, time, run):
    """How many sleepers ahead of the first axle move downwards faster than a tenth of the fastest
    of the five nearest, without a gap: mean over the instants at which it is above a sleeper. None
    with another kind of load."""
    load = run.deck["load"]
    if load.get("kind", "winkler") != "winkler" or not load.get("axles", [0]):
        return None
    counts = []
    for k in range(3, len(x) - 8):
        row = np.searchsorted(time - time[0], (x[k] - load["start"]) / load["speed"])
        down = -velocity[row]
        moving = down[k + 1:] > 0.1 * down[k:k + 5].max()
        counts.append(len(moving) if moving.all() else int(np.argmin(moving)))
    return float(np.mean(counts)) if counts else None


def put_acceleration(name, largest, numbers):
    """Of the largest acceleration of each sleeper."""
    for what, of in (("least", np.min), ("median", np.median), ("most", np.max)):
        numbers.put(name, f"acceleration, {what}", of(largest), "g")


def measure_stones(name, place, numbers, lines):
    if not re.fullmatch(r"stones_\w+_\d+|short_\w+", name):
        lines = Lines()  # of variants nothing is drawn
    run = read.results(place)
    rows = run.passage()
    time, x, count = run.time[rows], run.sleepers_x, len(run.sleepers_x)
    order = np.argsort(run.ground_x)
    nodes = run.ground_x[order]
    surface = -1e3 * run.ground_envelope["displacement_min"].values[order]
    put_surface(name, nodes, surface, nodes[-1], numbers, lines)
    put_stress(name, run, numbers, lines)
    sleeper = -1e3 * run.sleeper_envelope["displacement_min"].values
    kept = np.abs(1e3 * measures.residual_displacement(run))
    plain = x > EDGE + 1.5
    seat = -1e-3 * run.sleeper["seat_force"].values[rows].min(axis=0)
    numbers.put(name, "seat force, structure", seat[x < EDGE].mean(), "kN")
    numbers.put(name, "seat force, most", seat.max(), "kN")
    numbers.put(name, "seat force, far", np.median(seat[x >= nodes[-1] - 2]), "kN")
    numbers.put(name, "sleeper, structure", sleeper[x < EDGE].mean(), "mm")
    numbers.put(name, "sleeper, nearest to the edge", sleeper[x < EDGE][-1], "mm")
    numbers.put(name, "sleeper, median beyond", np.median(sleeper[plain]), "mm")
    numbers.put(name, "sleeper, most", sleeper.max(), "mm")
    for seat, what in ((S1, "S1"), (S2, "S2")):
        if seat <= x[-1]:
            numbers.put(name, f"sleeper {what}", sleeper[np.abs(x - seat).argmin()], "mm")
    numbers.put(name, "kept, most", kept.max(), "mm")
    numbers.put(name, "kept, median", np.median(kept), "mm")
    numbers.put(name, "kept, sleepers above 1 mm", np.count_nonzero(kept > KEPT), "-")
    lines.put("sleeper", name, x, sleeper)
    height = 1e3 * next(stage["height"] for stage in run.deck["stage"]
                        if stage["kind"] == "sleepers")
    ballast = height + 1e3 * run.sleeper["displacement"].values[rows.start]
    numbers.put(name, "ballast below sleepers, median", np.median(ballast), "mm")
    numbers.put(name, "ballast below sleepers, least", ballast.min(), "mm")
    below = [run.sensors[f"below_{k}"] for k in range(count)]
    path = np.array([of["displacement"].values[rows, 2] for of in below]).T
    stone = 1e3 * (path[0] - path).max(axis=0)
    numbers.put(name, "ballast, structure", stone[x < EDGE].mean(), "mm")
    numbers.put(name, "ballast, median beyond", np.median(stone[plain]), "mm")
    lines.put("ballast", name, x, stone)
    along = 1e3 * run.ground["displacement_x"].values[rows][:, order]
    soil = (along - along[0])[:, (nodes > EDGE + 0.1) & (nodes < EDGE + 2)]
    numbers.put(name, "soil away from the structure, largest", soil.max(), "mm")
    numbers.put(name, "soil towards the structure, largest", -soil.min(), "mm")
    for stage in summary(place, "stages"):
        if stage["name"] == "compact":
            numbers.put(name, "bulk density", stage["bulk_density_kg_m3"], "kg/m3")
        if stage["name"] == "trains":
            numbers.put(name, "settlement in the last train of the preparation",
                        1e3 * stage["settlement_m"], "mm")
    if as_file(TRAINED) in name:
        put_trains(name, run, numbers)
    put_histories(name, time, x, run, rows, lines)
    if kept.max() <= KEPT:  # a support that fails shakes its neighbours
        velocity = np.array([of["velocity"].values[rows, 2] for of in below]).T
        put_vibration(name, time, run, rows, velocity, numbers, lines)
    return nodes, surface


def put_trains(name, run, numbers):
    """Settlement of sleepers in each train of the preparation, where it is part of the run."""
    number = [stage["name"] for stage in run.deck["stage"]].index("trains")
    rows = np.flatnonzero(run.stage == number)
    if not len(rows):
        return
    ends = np.linspace(rows[0], rows[-1], MANY_TRAINS + 1).round().astype(int)
    down = -1e3 * np.diff(run.sleeper["displacement"].values[ends], axis=0)
    for train in SHOWN_TRAINS:
        numbers.put(name, f"settlement, most, train {train}", down[train - 1].max(), "mm")
        numbers.put(name, f"settlement, median, train {train}", np.median(down[train - 1]), "mm")


def put_vibration(name, time, run, rows, stones_velocity, numbers, lines):
    x, velocity = run.sleepers_x, run.sleeper["velocity"].values[rows]
    acceleration = np.abs(filtered_acceleration(time, velocity)).max(axis=0)
    put_acceleration(name, acceleration, numbers)
    for seat, what in ((S1, "S1"), (S2, "S2")):
        if seat <= x[-1]:
            numbers.put(name, f"acceleration at {what}",
                        acceleration[np.abs(x - seat).argmin()], "g")
    lines.put("sleeper acceleration", name, x, acceleration)
    shaken = np.abs(filtered_acceleration(time, stones_velocity)).max(axis=0)
    numbers.put(name, "ballast acceleration, median", np.median(shaken), "g")
    numbers.put(name, "ballast acceleration, fluctuation", fluctuation(shaken), "-")
    lines.put("ballast acceleration", name, x, shaken)
    put_spectra(name, time, run, rows, stones_velocity, numbers, lines)
    moving = ahead(x, velocity, time, run)
    if moving is not None:
        numbers.put(name, "sleepers moving down ahead", moving, "-")


def put_histories(name, time, x, run, rows, lines):
    if name not in ("stones_wedge_1", "stones_none_1"):
        return
    for seat in S1, S2:
        k = int(np.abs(x - seat).argmin())
        moved = run.sleeper["displacement"].values[rows][:, k]
        lines.put(f"history, {seat:g} m", name, (time - time[0])[::8],
                  1e3 * (moved[0] - moved)[::8])


def cells(points, velocity, width, height):
    """Mean velocity in cells of a plane: centres and means, [cell, x z]."""
    key = np.floor(points / (width, height)).astype(int)
    found, cell = np.unique(key, axis=0, return_inverse=True)
    cell = np.ravel(cell)
    total = np.array([np.bincount(cell, velocity[:, k]) for k in range(2)]).T
    return (found + 0.5) * (width, height), total / np.bincount(cell)[:, None]


def places(data, part):
    """x and z, m, of what a field file has velocities of: the middle of a stone's points, or the
    nodes of the ground, of which those of the surface belong to the cells below it."""
    points = data["Points"][()][:, [0, 2]]
    if part == "ground":
        return points - 1e-6
    first = data["Offsets"][()]
    return np.add.reduceat(points[data["Connectivity"][()]], first[:-1]) / np.diff(first)[:, None]


def measure_maps(name, place, numbers, lines):
    """Velocity, mm/s, and acceleration, g, of stones and ground in cells, and the largest."""
    run = read.results(place)
    begin = run.time[run.passage().start]
    for at in AXLE_AT:
        instant = begin + (at - LOAD["start"]) / LOAD["speed"]
        for part, values, size in (("stones", "CellData", (0.6, 0.2)),
                                   ("ground", "PointData", (1, 0.8))):
            file = min(read.series(place, part), key=lambda each: abs(each[0] - instant))[1]
            with h5py.File(file) as data:
                where = places(data["VTKHDF"], part)
                moving = {what: factor * data[f"VTKHDF/{values}/{what}"][()][:, [0, 2]]
                          for what, (factor, _) in MAPPED.items()}
            for what, vectors in moving.items():
                centre, means = cells(where, vectors, *size)
                lines.put(f"map {at} m", f"{name}, {part} {what}", *means.T)
                most = np.linalg.norm(means, axis=1)
                numbers.put(name, f"largest {what} of cells of {part}, axle at {at} m", most.max(),
                            MAPPED[what][1])
                numbers.put(name, f"x of the largest {what}, {part}, axle at {at} m",
                            centre[np.argmax(most), 0], "m")
            lines.put(f"map {at} m", f"{name}, {part} at", *centre.T)


def change(numbers, run, other, quantity):
    """Of a quantity, from `run` to `other`, relative."""
    return numbers(other, quantity) / numbers(run, quantity) - 1


def cases(numbers, design):
    """Names of the runs with stones of a design, one per packing."""
    full = [f"stones_{design}_{packing}" for packing in PACKINGS]
    return full if numbers.has(full[0]) else [f"short_{design}"]


def values(numbers, design, quantity):
    """Of all packings that have it: those in which a support failed have no accelerations."""
    return [numbers(run, quantity) for run in cases(numbers, design)
            if (run, quantity) in numbers.rows]


def mean(numbers, design, quantity):
    return float(np.mean(values(numbers, design, quantity)))


def known(numbers, quantity, designs=tuple(DESIGNS)):
    """Whether each design has a packing with this quantity."""
    return all(values(numbers, design, quantity) for design in designs)


def jump(numbers, run):
    """kPa, from the largest stress of a node within a spacing before the edge to the least behind
    it."""
    return (numbers(run, "stress, most before the edge")
            - numbers(run, "stress, least behind the edge"))


def jump_of_means(numbers, run):
    return (numbers(run, "stress, mean before the edge")
            - numbers(run, "stress, mean behind the edge"))


def reduction(numbers, of):
    """Relative change of a jump by the wedge: of its mean over the packings."""
    none, wedge = (np.mean([of(numbers, run) for run in cases(numbers, design)])
                   for design in DESIGNS)
    return float(wedge / none - 1)


def load_of_seats():
    """N, the largest seat load of the four axles together: each lifts the seats of others."""
    time = np.linspace(0, 2, 20001)
    s = LOAD["speed"] * time[:, None] + LOAD["start"] - np.array(LOAD["axles"])
    decay = DECAY * np.abs(s)
    return float((LOAD["peak"] * np.exp(-decay) * (np.cos(decay) + np.sin(decay))).sum(
        axis=1).max())


MEAN_STRESS = 1e-3 * load_of_seats() / (SPACING * DECK["thickness"])  # kPa, on a sleeper spacing
PUBLISHED_STONES = 2600  # kg/m3
ROUNDED = 0.25  # relative, of values given with one digit
CLOSE = 0.15    # relative, of values with two or three digits that are shown as curves
SPECTRA = 0.03  # relative, of frequencies
SPECTRAL_LINES = {"v/L_c": ("9.0 m", "2.0 Hz"), "v/L_w": ("2.8 m", "6.5 Hz")}


def targets(n):
    first = cases(n, "wedge")[0]
    far = {"none": "ground, 6 to 11 m", "wedge": "ground, far"}
    if (first, far["none"]) not in n.rows:
        far["none"] = far["wedge"]  # a shorter ground
    return [*spectra_targets(n), *surface_targets(n, far), *stress_targets(n),
            *sleeper_targets(n), *ballast_targets(n)]


SURFACE_SECTION, AT_EDGE, SLEEPERS_SECTION = (
    "Displacement of the surface", "Stress at the edge", "Sleepers and ballast")


def compare(n, what, design, quantity, kind, published, unit, value, close, sign=None, see=""):
    found = tuple(values(n, design, quantity))
    return Target(f"{what}, {TITLES[design]}", kind, published, float(np.mean(found)), unit, value,
                  close, sign=sign, each=found, see=see)


def spectra_targets(n):
    found = []
    for mark, (what, published) in SPECTRAL_LINES.items():
        if not all(known(n, f"{mark}, {of}") for of in ("acceleration", "seat force")):
            continue
        for design in DESIGNS:
            load = mean(n, design, f"{mark}, seat force")
            peak = tuple(values(n, design, f"{mark}, acceleration"))
            found.append(Target(
                f"spectral peak near v/({what}), relative to that of the load ({load:.2f} Hz), "
                f"{TITLES[design]}", "hard", published, float(np.mean(peak)), "Hz", load, SPECTRA,
                # The record of one bogie is too short for a sign.
                sign=abs(np.mean(peak) / load - 1) <= SPECTRA if known(n, "v/L_c, acceleration")
                else None, each=peak))
    return found


def surface_targets(n, far):
    less = {design: mean(n, design, "ground, structure") < 0.2 * mean(n, design, far[design])
            for design in DESIGNS}
    widths = {design: mean(n, design, "ground, 90 % of the rise") for design in DESIGNS}
    return [
        *(compare(n, "surface of the structure", design, "ground, structure", "main", "0.02 mm",
                  "mm", 0.02, ROUNDED, less[design], SURFACE_SECTION) for design in DESIGNS),
        compare(n, "surface 6 to 11 m behind the structure" if "6 to 11" in far["none"] else
                "surface in the last 2 m of the bed", "none", far["none"], "main", "1.8 mm",
                "mm", 1.8, CLOSE, less["none"], SURFACE_SECTION),
        compare(n, "surface in the last 2 m of the bed", "wedge", far["wedge"], "main", "1.64 mm",
                "mm", 1.64, CLOSE, less["wedge"], SURFACE_SECTION),
        Target("distance behind the structure with 90 % of the displacement of plain track, "
               "without wedge", "main", "all within 4 m", widths["none"], "m",
               holds=widths["none"] <= 4,
               sign=widths["none"] < widths["wedge"]),
        Target("this distance with wedge", "main", "gradual, no number", widths["wedge"], "m",
               holds=widths["wedge"] > 2 * widths["none"],
               sign=widths["wedge"] > widths["none"])]


def stress_targets(n):
    return [
        compare(n, "largest stress of a node of the surface before the edge", "none",
                "stress, most before the edge", "main", "165 kPa", "kPa", 165, CLOSE, see=AT_EDGE),
        compare(n, "least stress of a node of the surface behind the edge", "none",
                "stress, least behind the edge", "main", "27 kPa", "kPa", 27, CLOSE, see=AT_EDGE),
        Target("change of the difference of these two by the wedge", "main", "-54 %",
               100 * reduction(n, jump), "%", -54, CLOSE, sign=reduction(n, jump) < 0, see=AT_EDGE)]


def sleeper_targets(n):
    found = [compare(n, "sleeper nearest to the edge", "none", "sleeper, nearest to the edge",
                     "soft", "0.75 mm, hardly legible", "mm", 0.75, CLOSE, see=SLEEPERS_SECTION)]
    if known(n, "sleeper S1"):
        found.append(compare(n, "sleeper S1", "wedge", "sleeper S1", "soft", "1.7 mm", "mm", 1.7,
                             CLOSE, see=SLEEPERS_SECTION))
    for design, low, high in (("none", 0.62, 1.34), ("wedge", 0.61, 1.57)):
        if known(n, "acceleration, least", (design,)):
            found += [compare(n, f"{which} of the sleepers' largest accelerations", design,
                              f"acceleration, {quantity}", "soft", f"{value} g", "g", value, CLOSE,
                              see=SLEEPERS_SECTION)
                      for which, quantity, value in (("smallest", "least", low),
                                                     ("largest", "most", high))]
    if known(n, "acceleration at S2", ("wedge",)):
        ratio = [b / a for a, b in zip(values(n, "wedge", "acceleration at S1"),
                                       values(n, "wedge", "acceleration at S2"))]
        found.append(Target("largest acceleration of sleeper S2 over that of S1, with wedge",
                            "soft", "slightly above 1 (ours: below 1.5)",
                            float(np.mean(ratio)), "",
                            holds=min(ratio) > 1 and max(ratio) < 1.5, each=tuple(ratio),
                            see=SLEEPERS_SECTION))
    return found


def ballast_targets(n):
    found = []
    rough = "ballast acceleration, fluctuation"
    both = [(none, wedge) for none, wedge in zip(cases(n, "none"), cases(n, "wedge"))
            if (none, rough) in n.rows and (wedge, rough) in n.rows]
    if both:
        change_of = tuple(100 * change(n, none, wedge, rough) for none, wedge in both)
        found.append(Target(
            "change by the wedge of the ballast's fluctuation of acceleration along the track",
            "soft", "decrease", float(np.mean(change_of)), "%", holds=max(change_of) < 0,
            each=change_of, see=SLEEPERS_SECTION))
    if n.has("maps_none"):
        speeds = [n("maps_none", f"largest velocity of cells of ground, axle at {at} m")
                  for at in AXLE_AT]
        found.append(Target(
            f"largest velocity of the ground, first axle at {AXLE_AT[-1]} m over at {AXLE_AT[0]} "
            "m, without wedge", "soft", "increases", speeds[-1] / speeds[0], "",
            holds=speeds[0] < min(speeds[1:]), see=SLEEPERS_SECTION))
    ratio = PUBLISHED_STONES / DECK["material"][0]["density"]
    dense = tuple(ratio * each for each in values(n, "wedge", "bulk density"))
    ways = {way: mean(n, "none", f"soil {way} the structure, largest")
            for way in ("away from", "towards")}
    return found + [
        Target("bulk density, if stones had the published 2600 kg/m3", "soft", "about 1800 kg/m3",
               float(np.mean(dense)), "kg/m3", 1800, CLOSE, each=dense, see="Set-up"),
        Target("largest motion of the soil away from the structure over that towards it, without "
               "wedge", "soft", "away", ways["away from"] / ways["towards"], "",
               holds=ways["away from"] > ways["towards"])]
