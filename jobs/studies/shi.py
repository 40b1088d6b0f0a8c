"""Numbers of the study shi: a locomotive from a rigid structure to an embankment, with and without
a wedge of stiffer backfill. Its runs: shi_runs.py; its targets: shi_targets.py; its document:
shi_document.py.

The transition is modelled with stones (inputs/shi/transition.toml) and, for comparisons of grounds,
boundaries and speeds, as its ground alone under the same seat loads (inputs/shi/ground.toml). The
short form has the shorter transition of inputs/shi/short.toml.
"""
import re

import h5py
import numpy as np
import scipy.optimize

from . import shi_runs, shi_space, shi_targets
from .shi_decks import (DECK, EDGE, FILTER, GRAVITY, GROUND, LOAD, SPACING, filtered_acceleration)
from .shi_runs import (AXLE_AT, FIXED, KEPT, MANY_TRAINS, MAPPED, S1, S2, SHOWN_TRAINS, TRAINED,
                       seats)
from .study import Lines, as_file, summary

from trackbed_post import measures, read, signals  # noqa: I001 (found by .study)

runs, targets = shi_runs.runs, shi_targets.targets


def measure(form, folder, numbers, lines):
    """Displacements downwards in mm, compressions in kPa, accelerations in g."""
    surfaces = {}
    for run in runs(form, 1):
        place = folder / run.name
        if run.deck == GROUND:
            surfaces[run.name] = measure_ground(run.name, place, numbers, lines)
        elif run.name.startswith("maps"):
            measure_maps(run.name, place, numbers, lines)
        elif run.name in shi_space.names():
            shi_space.measure(run.name, place, numbers, lines)
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
        if stage["name"] == "passage":
            numbers.put(name, "sub-step over the longest stable one",
                        stage["window_s"] / stage["substeps"] / stage["stable_step_s"], "-")
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
