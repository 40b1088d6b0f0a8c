"""The part of the study shi in space: angular stones between smooth walls (inputs/shi/space.toml),
beside the same transition in the plane (inputs/shi/short.toml).
"""
import numpy as np

from .shi_decks import (DESIGNS, EDGE, NO_WEDGE, SHORT, SPACE, SPACING,
                        filtered_acceleration)
from .study import Run, summary

from trackbed_post import measures, read  # noqa: I001 (found by .study)

MODELS = {"plane": SHORT, "space": SPACE}
PREPARED = {"plane": "trains", "space": "rest"}  # stage behind which both designs are one model
PACKINGS = (1,)     # seeds
END = 5.0           # m, x up to which the end of the ground does not decide


def name_of(where, design, packing):
    return f"{where}_{design}_{packing}"


def names():
    return {name_of(where, design, packing)
            for where in MODELS for design in DESIGNS for packing in PACKINGS}


def runs(ranks):
    """Both designs on the stones of each packing: the bed is loaded on a ground at rest."""
    found = []
    for packing in PACKINGS:
        for where, deck in MODELS.items():
            wedge = name_of(where, "wedge", packing)
            words, of = (f"bed.seed={packing}",), ranks if where == "space" else 1
            start = f"start='{{folder}}/{wedge}/stage_{PREPARED[where]}.h5'"
            found += [Run(wedge, deck, words, of),
                      Run(name_of(where, "none", packing), deck, (*words, *NO_WEDGE, start), of)]
    return found


def along(x, values):
    """Places x and the mean of all values there: of nodes side by side."""
    found, at = np.unique(x.round(6), return_inverse=True)
    return found, np.bincount(np.ravel(at), values) / np.bincount(np.ravel(at))


def measure(name, place, numbers, lines):
    """Displacements downwards in mm, compressions in kPa, accelerations in g."""
    run = read.results(place)
    rows, x = run.passage(), run.sleepers_x
    nodes, down = along(run.ground_x, -1e3 * run.ground_envelope["displacement_min"].values)
    numbers.put(name, "ground, structure", down[nodes <= EDGE - SPACING / 2].max(), "mm")
    numbers.put(name, "ground, far", np.median(down[(nodes >= END - 1) & (nodes <= END)]), "mm")
    slope = np.gradient(measures.smoothed(nodes, down, SPACING), nodes)
    inside = nodes <= END
    numbers.put(name, "ground, steepest", slope[inside].max(), "mm/m")
    numbers.put(name, "ground, x of the steepest", nodes[inside][np.argmax(slope[inside])], "m")
    _, compression = along(run.ground_x, -1e-3 * run.ground_envelope["sigma_z_min"].values)
    before = compression[(nodes > EDGE - SPACING) & (nodes < EDGE - 0.01)].mean()
    behind = compression[(nodes > EDGE + 0.01) & (nodes < EDGE + SPACING)].mean()
    numbers.put(name, "difference of means at the edge", before - behind, "kPa")
    sleeper = -1e3 * run.sleeper_envelope["displacement_min"].values
    numbers.put(name, "sleeper, structure", sleeper[x < EDGE].mean(), "mm")
    beyond = (x > EDGE + 1) & (x < END)
    numbers.put(name, "sleeper, median beyond", np.median(sleeper[beyond]), "mm")
    numbers.put(name, "sleeper, most", sleeper[x < END].max(), "mm")
    bed = sleeper - np.interp(x, nodes, down)
    numbers.put(name, "bed, median beyond", np.median(bed[beyond]), "mm")
    kept = np.abs(1e3 * measures.residual_displacement(run))
    numbers.put(name, "kept, most", kept.max(), "mm")
    numbers.put(name, "kept, median", np.median(kept), "mm")
    shaken = np.abs(filtered_acceleration(run.time[rows],
                                          run.sleeper["velocity"].values[rows])).max(axis=0)
    for what, of in (("least", np.min), ("median", np.median), ("most", np.max)):
        numbers.put(name, f"acceleration, {what}", of(shaken), "g")
    stages = summary(place, "stages")
    for stage in stages:
        if stage["name"] == "compact":
            numbers.put(name, "bulk density", stage["bulk_density_kg_m3"], "kg/m3")
        if stage["name"] == "passage":
            numbers.put(name, "sub-step over the longest stable one",
                        stage["window_s"] / stage["substeps"] / stage["stable_step_s"], "-")
            numbers.put(name, "stones", stage["particles"], "-")
            numbers.put(name, "wall time of the passage", stage["wall_time_s"], "s")
    lines.put("space", f"{name}, ground", nodes, down)
    lines.put("space", f"{name}, sleepers", x, sleeper)
