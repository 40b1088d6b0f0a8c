"""Files and measurements of the study demfem: convex and non-convex stones below sleepers, a ground
whose stiffness rises along the track, cost. Its runs: demfem_model.py; targets: demfem_targets.py;
what lines give: demfem_lines.py; document: demfem_document.py and demfem_figures.py.

Stones are compared on a slice of the track (inputs/demfem/sleeper.toml), and on ten sleepers with a
rail on the ground (inputs/demfem/track.toml); the ground is also loaded alone
(inputs/demfem/ground.toml); the cost is that of two solid sleepers and a rail
(inputs/demfem/solids.toml).
"""
import hashlib
import pathlib
import subprocess

import h5py
import numpy as np
import scipy.signal

import launch

from . import rocks
from .demfem_model import (AREA, BENCHMARK, BLOCKS, CELL, COARSER, CORNERS, ELEMENTS, FORCES,
                           GROUND, HARD, HEIGHT, LAST_OF_REST, LAYER, LEFT, MIDDLE, PARTS, PEAK,
                           PERIOD, RAIL, ROCKS, SETTLED, SHAPES, SIZE, SLEEPER, SOFT, TRACK, WIDTHS,
                           runs)
from .demfem_lines import derive
from .demfem_targets import predicted, targets
from .study import summary

from trackbed_post import read  # noqa: I001 (found by .study)

# Of the study.
__all__ = ("derive", "measure", "measure_runs", "predicted", "prepare", "runs", "targets")


def prepare(program, folder):
    """Curves of the modulus, and libraries of stones unless they exist."""
    meshes, hulls = [], []
    for seed in range(1, ROCKS + 1):
        vertices, triangles = rocks.rock(seed)
        for found, name, mesh in ((meshes, f"rock_{seed}", (vertices, triangles)),
                                  (hulls, f"rock_{seed}_hull", rocks.hull(vertices))):
            found.append(folder / f"{name}.obj")
            found[-1].write_text(rocks.obj(*mesh), encoding="utf-8")
    for shape, files in (("convex", hulls), ("non_convex", meshes)):
        library, kept = folder / f"{shape}.h5", folder / f"{shape}.key"
        key = "\n".join([hashlib.sha256(pathlib.Path(program).read_bytes()).hexdigest(),
                         f"{SIZE} {PARTS[shape]} {CORNERS}",
                         *(file.read_text(encoding="utf-8") for file in files)])
        if library.is_file() and kept.is_file() and kept.read_text(encoding="utf-8") == key:
            continue
        ran = launch.run([program, "shapes", *files, "--unit", f"{SIZE}", "--parts",
                          f"{PARTS[shape]}", "--vertices", f"{CORNERS}", "--library", library],
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if ran.returncode:
            launch.fail(ran, f"{shape} stones")
        kept.write_text(key, encoding="utf-8")
    x = np.linspace(0, 6, 61)
    for width, file in WIDTHS.items():
        young = SOFT + (HARD - SOFT) * (1 + np.tanh((x - MIDDLE) / float(width.split()[0]))) / 2
        rows = "".join(f"{a:.1f},{b:.5g}\n" for a, b in zip(x, young))
        (folder / file).write_text("x_m,young_Pa\n" + rows, encoding="utf-8")


def measure(form, folder, numbers, lines):
    for shape in SHAPES:
        measure_shapes(shape, folder / f"{shape}.h5", numbers)
    measure_runs(runs(form, 1), folder, numbers, lines)


def measure_runs(chosen, folder, numbers, lines):
    for run in chosen:
        place = folder / run.name
        if run.name.startswith("long"):
            measure_long(run.name, place, numbers, lines)
        elif run.deck == SLEEPER:
            measure_bed(run.name, place, numbers, lines)
        elif run.deck == TRACK:
            measure_track(run.name, place, numbers, lines)
        elif run.deck == GROUND:
            measure_ground(run.name, place, numbers, lines)
        elif run.deck == CELL:
            numbers.put(run.name, LEFT, load_left(place), "kPa")
        elif run.name.startswith("cost"):
            measure_cost(run.name, place, numbers)
        numbers.put(run.name, "wall_time", float(summary(place, "wall_time_s")), "s")


def measure_shapes(shape, library, numbers):
    """Mean volume of stones that pass the same sieve, over that of the sieve's cube."""
    with h5py.File(library) as file:
        solid = file["shapes/solid"][()].reshape(-1, 5)
        pieces = file["shapes/pieces"][()]
    numbers.put(f"shapes_{shape}", "volume over sieve cubed",
                float(np.mean(solid[:, 0] / solid[:, 4]**3)), "-")
    numbers.put(f"shapes_{shape}", "pieces", float(np.mean(pieces)), "-")


def slopes(stress, strain, time, cycles):
    """Slope of stress over strain, Pa, of the loading half of each cycle, by least squares; not a
    number where the largest stress is at the begin, as of sleepers that are not yet at rest."""
    found = []
    for k in range(cycles):
        rows = np.flatnonzero((time >= k * PERIOD) & (time <= (k + 1) * PERIOD))
        rise = rows[:int(np.argmax(stress[rows])) + 1]
        found.append(np.polyfit(strain[rise], stress[rise], 1)[0]
                     if len(rise) >= 0.2 * len(rows) else np.nan)
    return np.array(found)


def measure_bed(name, place, numbers, lines):
    """Of the repeated loads: settlements in mm, stiffness in MPa, forces in kN."""
    run = read.results(place)
    names = [stage["name"] for stage in run.deck["stage"]]
    z = run.sleeper["displacement"].values
    placed = z[np.flatnonzero(run.stage == names.index("sleepers"))[0]]
    rows = np.flatnonzero(run.stage == names.index("cycles"))
    time, cycles = run.time[rows] - run.time[rows[0]], run.deck["stage"][-1]["cycles"]
    down, height = z[rows[0]] - z[rows], HEIGHT + z[rows[0]] - placed
    stress = run.sleeper["reaction"].values[rows] / AREA
    stiffness = np.mean([slopes(stress[:, k], down[:, k] / height[k], time, cycles)
                         for k in range(down.shape[1])], axis=0)
    numbers.put(name, "sinkage before the cycles", 1e3 * (placed - z[rows[0]]).mean(), "mm")
    settled = 1e3 * down.mean(axis=1)
    for k, value in enumerate(stiffness):
        inside = (time >= k * PERIOD) & (time <= (k + 1) * PERIOD)
        if np.isfinite(value):
            numbers.put(name, f"stiffness, cycle {k + 1}", 1e-6 * value, "MPa")
        numbers.put(name, f"lowest level, cycle {k + 1}", settled[inside].max(), "mm")
        numbers.put(name, f"settlement, cycle {k + 1}", settled[inside][-1], "mm")
    ends = [settled[(time >= k * PERIOD) & (time <= (k + 1) * PERIOD)][-1] for k in range(cycles)]
    numbers.put(name, SETTLED, ends[-1] - ends[0], "mm")
    numbers.put(name, LEFT, load_left(place), "kPa")
    numbers.put(name, "largest stress", 1e-3 * stress.max(), "kPa")
    numbers.put(name, "least stress", 1e-3 * stress.min(), "kPa")
    for what in ("porosity", "coordination"):
        values = np.ravel(run.regions["bed"][what].values[rows[0]])
        numbers.put(name, what, float(values[0]), "-")
    numbers.put(name, "stones", float(summary(place, "dem", "particles")), "-")
    numbers.put(name, "stone steps per second and core",
                float(summary(place, "dem", "particle_steps_per_second_per_core")), "1/s")
    resultant = run.regions["bed"]["largest_stone_force"].values[rows]
    numbers.put(name, "largest resultant on a stone", 1e-3 * float(resultant.max()), "kN")
    if "non_convex" not in name:  # of stones of one piece
        numbers.put(name, "upper bound of the stiffness", 1e-6 * affine_stiffness(place, run.deck),
                    "MPa")
    forces = 1e-3 * contact_forces(place)
    numbers.put(name, "largest contact force", forces.max(), "kN")
    numbers.put(name, "mean contact force", forces.mean(), "kN")
    numbers.put(name, "contact force of 99.9 % of all", np.quantile(forces, 0.999), "kN")
    count, edges = np.histogram(np.clip(forces, FORCES[0], None), FORCES)
    lines.put("forces", name, np.sqrt(edges[1:] * edges[:-1]), 100 * count / len(forces))
    lines.put("settlement", name, time[::4], settled[::4])
    lines.put("loop", name, 1e3 * down[::2, 0] / height[0], 1e-3 * stress[::2, 0])


def measure_long(name, place, numbers, lines):
    """Settlements at the ends of the cycles in mm, stiffness in the last one in MPa."""
    run = read.results(place)
    time, z = run.time - run.time[0], run.sleeper["displacement"].values
    cycles, down = run.deck["stage"][-1]["cycles"], z[0] - z
    ends = [int(np.flatnonzero(time <= (k + 1) * PERIOD * (1 + 1e-9))[-1]) for k in range(cycles)]
    settled = 1e3 * down.mean(axis=1)[ends]
    lines.put("settlement over cycles", name, np.arange(1, cycles + 1), settled)
    numbers.put(name, SETTLED, settled[-1] - settled[0], "mm")
    numbers.put(name, "settlement in the last ten cycles", settled[-1] - settled[-11], "mm")
    stress = run.sleeper["reaction"].values / AREA
    numbers.put(name, "stiffness, last cycle", 1e-6 * np.mean(
        [slopes(stress[:, k], down[:, k] / (HEIGHT + z[0, k]), time, cycles)[-1]
         for k in range(down.shape[1])]), "MPa")


def load_left(place):
    """kPa, below the platen in the last row of the stage of release."""
    run = read.results(place)
    names = [stage["name"] for stage in run.deck["stage"]]
    rows = np.flatnonzero(run.stage == names.index("release"))
    force = read.datasets(place)["history/platen/force"].values[rows, 2]
    return 1e-3 * force[-1] / (np.ptp(run.deck["bed"]["x"]) * np.ptp(run.deck["bed"]["y"]))


def contact_forces(place):
    """N, of all contacts in the field files of the cycles."""
    found = []
    for file in read.fields(place, "cycles", "contacts").values():
        with h5py.File(file) as data:
            found.append(data["VTKHDF/CellData/force_size"][()])
    return np.concatenate(found)


def affine_stiffness(place, deck):
    """Pa, upper bound of the stiffness below the sleepers in the field file of the largest forces:
    that of stones which follow the strain of the height without rotation, also beside the sleepers,
    so that each contact is compressed by the strain times the height l of the line between its
    stones. Any other motion under the same displacement of the sleepers has less energy, so that
    their stiffness is at most (sum of k l^2) / volume, with the area of the bed over that of the
    sleepers (Walton 1987, doi:10.1016/0022-5096(87)90036-6). k is that across the contact, from the
    whole contact force, and is also taken along the contact: both are on the safe side. Valid for
    stones of one piece, whose centres are the ends of the lines."""
    low, high = LAYER
    area = np.ptp(deck["bed"]["x"]) * np.ptp(deck["bed"]["y"])
    exponent = 1.5 if deck["contact"][0]["law"] == "hertz" else 1  # of the overlap in the force
    largest = (0.0, 0.0)
    for file in read.fields(place, "cycles", "contacts").values():
        with h5py.File(file) as data:
            ends = data["VTKHDF/Points"][()][data["VTKHDF/Connectivity"][()].reshape(-1, 2)]
            force = data["VTKHDF/CellData/force_size"][()]
            stiffness = exponent * force / data["VTKHDF/CellData/overlap"][()]
        height, middle = ends[:, 1, 2] - ends[:, 0, 2], ends[:, :, 2].mean(axis=1)
        inside = (middle > low) & (middle < high)
        modulus = np.sum((stiffness * height**2)[inside]) / (area * (high - low))
        largest = max(largest, (force.sum(), modulus))
    return float(largest[1] * area / (deck["sleepers"]["count"] * AREA))


def measure_track(name, place, numbers, lines):
    """Of the wheels on ten sleepers: displacements in mm down since the begin of their stage,
    stresses in the ground in MPa."""
    run = read.results(place)
    names = [stage["name"] for stage in run.deck["stage"]]
    z = run.sleeper["displacement"].values
    placed = z[np.flatnonzero(run.stage == names.index("sleepers"))[0]]
    rows = np.flatnonzero(run.stage == names.index("wheels"))
    time, down = run.time[rows] - run.time[rows[0]], 1e3 * (z[rows[0]] - z[rows])
    last = time > time[-1] - PERIOD  # while one axle takes the place of the one before
    numbers.put(name, "sinkage before the wheels", 1e3 * (placed - z[rows[0]]).mean(), "mm")
    numbers.put(name, "lowest position of a sleeper", down.max(), "mm")
    numbers.put(name, "mean displacement of the sleepers", down[last].mean(), "mm")
    numbers.put(name, "mean displacement of the lowest sleeper", down[last].mean(axis=0).max(),
                "mm")
    lines.put("track_sleepers", name, run.sleepers_x, down[last].mean(axis=0))
    lines.put("track_lowest", name, time[::4], down[::4].max(axis=1))
    rail = read.datasets(place)["history/solid/rail_displacement"].values
    resting = np.flatnonzero(run.stage == names.index("rest"))
    numbers.put(name, "rail, rise in the rest", 1e3 * (rail[rows[0]] - rail[resting[0]]).max(),
                "mm")
    late = resting[run.time[resting] > run.time[resting[-1]] - LAST_OF_REST]
    numbers.put(name, "rail, motion at the end of the rest",
                1e3 * np.ptp(rail[late], axis=0).max(), "mm")
    lowered = 1e3 * (rail[rows[0]] - rail[rows])
    for what, x in RAIL.items():
        at = int(np.argmin(np.abs(run.sleepers_x - x)))
        numbers.put(name, f"rail, {what}, mean displacement", lowered[last, at].mean(), "mm")
        numbers.put(name, f"rail, {what}, lowest position", lowered[:, at].max(), "mm")
        lines.put(f"track_rail_{what}", name, time[::4], lowered[::4, at])
    x, largest = along_track(list(read.fields(place, "wheels", "ground").values())[-1],
                             "extreme_largest_principal_stress", "extreme_least_principal_stress")
    for what, values in largest.items():
        lines.put(f"track_{what}", name, x, values)
        numbers.put(name, f"{what}, largest", values.max(), "MPa")
        numbers.put(name, f"{what}, mean", values.mean(), "MPa")
        numbers.put(name, f"{what}, mean up to 1.2 m", values[x < 1.2].mean(), "MPa")
        numbers.put(name, f"{what}, mean from 4.8 m", values[x > 4.8].mean(), "MPa")
        numbers.put(name, f"{what}, x of the largest", x[np.argmax(values)], "m")
    measure_wheels(name, place, run.deck["ground"], numbers, lines)
    numbers.put(name, "simulated", float(time[-1]), "s")
    measure_cost(name, place, numbers)


def measure_wheels(name, place, ground, numbers, lines):
    """Of the change of stress by the wheels, since the end of the rest: the largest at all stored
    instants, in elements and in the means of blocks as large as an element of the study."""
    before = field_of(list(read.fields(place, "rest", "ground").values())[-1], "stress")[1]
    size = np.ptp(ground["x"]) / ground["elements_x"]
    largest = {}
    for file in read.fields(place, "wheels", "ground").values():
        middle, stress = field_of(file, "stress")
        for how, (x, change) in {ELEMENTS: (middle[:, 0], stress - before),
                                 BLOCKS: blocks(middle, stress - before, size)}.items():
            found = along(x, *principal(change)[:, (2, 0)].T)
            for what, values in found[1].items():
                earlier = largest.get((what, how), (found[0], values))[1]
                largest[what, how] = found[0], np.maximum(earlier, values)
    for (what, how), (x, values) in largest.items():
        numbers.put(name, f"{what} by the wheels, {how}, largest", values.max(), "MPa")
        numbers.put(name, f"{what} by the wheels, {how}, x of the largest", x[np.argmax(values)],
                    "m")
        lines.put(f"track_{what}_{how}", name, x, values)


def blocks(middle, values, size):
    """x of the blocks of COARSER^3 elements of this size, and the means of the values in them."""
    low = middle.min(axis=0) - size / 2
    of = np.floor((middle - low) / (COARSER * size) + 1e-6).astype(int)
    places, block_of, count = np.unique(of, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(places), values.shape[1]))
    np.add.at(sums, np.ravel(block_of), values)
    return low[0] + COARSER * size * (places[:, 0] + 0.5), sums / count[:, None]


def principal(stress):
    """Principal stresses of rows xx yy zz xy yz zx, ascending."""
    xx, yy, zz, xy, yz, zx = stress.T
    return np.linalg.eigvalsh(np.stack([xx, xy, zx, xy, yy, yz, zx, yz, zz], axis=1).reshape(
        -1, 3, 3))


def along_track(file, *names):
    """x of the columns of elements, and the largest tension and compression in each, in MPa: of one
    tensor `stress...` or of the arrays with the largest and the least principal stress."""
    middle, *arrays = field_of(file, *names)
    if len(arrays) == 1:
        arrays = principal(arrays[0])[:, (2, 0)].T
    return along(middle[:, 0], *arrays)


def field_of(file, *names):
    """Centres of the elements, and arrays of their values."""
    with h5py.File(file) as data:
        points, cells = data["VTKHDF/Points"][()], data["VTKHDF/Connectivity"][()]
        elements = len(data["VTKHDF/Offsets"]) - 1
        return (points[cells.reshape(elements, -1)].mean(axis=1),
                *(data[f"VTKHDF/CellData/{name}"][()] for name in names))


def along(x, largest_stress, least_stress):
    """The different x, and the largest tension and compression at each, in MPa."""
    x, place_of = np.unique(np.round(x, 4), return_inverse=True)
    largest = {what: np.full(len(x), -np.inf) for what in ("tension", "compression")}
    for values, sign, stress in zip(largest.values(), (1e-6, -1e-6),
                                    (largest_stress, least_stress)):
        np.maximum.at(values, np.ravel(place_of), sign * np.ravel(stress))
    return x, largest


def measure_ground(name, place, numbers, lines):
    """Largest tension and compression due to the load, over depth and width, along the track."""
    x, largest = along_track(list(read.fields(place, "load", "ground").values())[-1],
                             "stress_change")
    for what, values in largest.items():
        lines.put(what, name, x, values)
    tension, compression = largest["tension"], largest["compression"]
    ends = (x < 1) | (x > 5)
    numbers.put(name, "tension, largest", tension.max(), "MPa")
    numbers.put(name, "tension, x of the largest", x[np.argmax(tension)], "m")
    numbers.put(name, "tension, largest near the ends", tension[ends].max(), "MPa")
    numbers.put(name, "compression, mean up to 1.2 m", compression[x < 1.2].mean(), "MPa")
    numbers.put(name, "compression, mean from 4.8 m", compression[x > 4.8].mean(), "MPa")
    numbers.put(name, "compression, largest", compression.max(), "MPa")
    numbers.put(name, "compression, x of the largest", x[np.argmax(compression)], "m")
    peaks = scipy.signal.find_peaks(compression, prominence=PEAK)[0]
    if len(peaks) > 1:
        numbers.put(name, "compression, median of peaks", np.median(compression[peaks]), "MPa")
        numbers.put(name, "compression, median distance of peaks",
                    np.median(np.diff(x[peaks])), "m")


def measure_cost(name, place, numbers):
    """Of the wheels alone."""
    numbers.put(name, "stones", float(summary(place, "dem", "particles")), "-")
    numbers.put(name, "ranks", float(summary(place, "ranks")), "-")
    numbers.put(name, "elements", float(summary(place, "ground", "elements")), "-")
    numbers.put(name, "stone steps per second and core",
                float(summary(place, "dem", "particle_steps_per_second_per_core")), "1/s")
    numbers.put(name, "element steps per second and core",
                float(summary(place, "ground", "element_steps_per_second_per_core")), "1/s")
    each = (float(summary(place, "dem", "measured_cpu_time_s"))
            / float(summary(place, "dem", "measured_steps")))
    steps = float(summary(place, "dem", "steps")) / float(summary(place, "simulated_time_s"))
    numbers.put(name, "time of one core for 0.5 s", each * steps * BENCHMARK["duration"] / 60,
                "min")
    for what in ("dem", "ground", "track", "coupling"):
        numbers.put(name, f"time, {what}", 100 * float(summary(place, "share", what)), "%")
