"""The part of the study crossing on scanned rails: the six panels of the thesis, by the design of
their pads and the direction of travel, with wheels of several profiles on a made-up scan
(inputs/track/crossing_scan.py, crossing_panel.toml).
"""
import hashlib
import importlib.util
import pathlib
import subprocess

import numpy as np

import launch

from . import crossing_places as places
from .study import INPUTS, Run, Target

from trackbed_post import measured, read  # noqa: I001 (found by .study)
from trackbed_post.monitor import greens, indicators, inverse
from trackbed_post.trajectory import command, contact, profiles, scan

DECK, SCAN = "track/crossing_panel.toml", "track/crossing_scan.py"
PADS = {"60E": 60e6, "UIC60": 1200e6}  # N/m
ORIGINS = {"facing": 17.0, "trailing": 19.0}  # m, x of the scan's origin in the track
WHEELS = {"s1002": "S1002", "s1002:hollow:1": "hollow, 1 mm", "s1002:hollow:2": "hollow, 2 mm"}
CASES = tuple((design, move) for design in PADS for move in ORIGINS)


def name_of(design, move, wheel="s1002"):
    return f"scanned_{design}_{move}_{wheel.replace(':', '_')}"


def file_of(move, wheel):
    return f"path_{move}_{wheel.replace(':', '_')}.csv"


def kernel_of(design):
    return f"kernel_scanned_{design}.h5"


def prepare(program, folder):
    """Paths of the wheels over the scan, and Green's functions of the panels, unless they exist."""
    kept = folder / "scanned.key"
    sources = [pathlib.Path(program), INPUTS / DECK, INPUTS / SCAN,
               pathlib.Path(__file__), *(pathlib.Path(module.__file__)
                                         for module in (command, contact, measured, profiles,
                                                        scan))]
    key = "\n".join(hashlib.sha256(path.read_bytes()).hexdigest() for path in sources)
    if kept.is_file() and kept.read_text(encoding="utf-8") == key:
        return
    write_paths(folder)
    for design in PADS:
        ran = subprocess.run([program, "kernel", INPUTS / DECK, f"pad.stiffness={PADS[design]}",
                              "-o", folder / kernel_of(design), "--sensor", "18", "--speed", "50",
                              "--from", "4", "--to", "32"], capture_output=True, text=True,
                             check=False)
        if ran.returncode:
            launch.fail(ran, kernel_of(design))
    kept.write_text(key, encoding="utf-8")


def write_paths(folder):
    spec = importlib.util.spec_from_file_location("crossing_scan", INPUTS / SCAN)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    made.write(folder / "scan.csv")
    grid, _, _ = command.prepared(folder / "scan.csv", command.Choices())
    for wheel in WHEELS:
        path = contact.roll(grid, profiles.of(wheel))
        for move, origin in ORIGINS.items():
            np.savetxt(folder / file_of(move, wheel),
                       np.stack(path.rows(origin, move == "trailing"), axis=1), fmt="%.8f",
                       delimiter=",", header="x_m,z_m", comments="")


def runs(chosen):
    return [Run(name_of(design, move, wheel), DECK,
                (f"pad.stiffness={PADS[design]}",
                 f"irregularity.file='{{folder}}/{file_of(move, wheel)}'"))
            for design, move in chosen for wheel in WHEELS]


def surface_of(folder, move, wheel):
    """(x, z), m, of a path."""
    return np.loadtxt(folder / file_of(move, wheel), delimiter=",", skiprows=1).T


def measure(folder, chosen, seeds, passage_of, numbers, lines):
    """`passage_of`: the Passage of a folder. Errors of force and irregularity with 0.1 % noise."""
    for move in dict.fromkeys(move for _, move in chosen):
        for wheel, title in WHEELS.items():
            x, z = surface_of(folder, move, wheel)
            lines.put("scanned_paths", f"{move}, {title}", x, 1e3 * z)
            path = contact.Path(wheel, x, z, np.zeros(len(x)))
            numbers.put(f"path_{move}_{wheel}", "depth", -1e3 * z.min(), "mm")
            numbers.put(f"path_{move}_{wheel}", "kink", 1e3 * path.dip()[0], "mrad")
    for design, move in chosen:
        kernel = greens.load(folder / kernel_of(design))
        for wheel in WHEELS:
            run = name_of(design, move, wheel)
            passage = passage_of(folder / run)
            numbers.put(run, "largest force", 1e-3 * passage.largest_force(), "kN")
            numbers.put(run, "static force", 1e-3 * kernel.wheels.load[0], "kN")
            numbers.put(run, "indicator", indicators.indicator(passage.acceleration, 5000.0, 50.0),
                        "m/s2")
            x, z = surface_of(folder, move, wheel)
            drawn = f"{design}, {move}" if wheel == "s1002" else ""
            measure_errors(passage, kernel, run, (x, z), seeds, drawn, numbers, lines)
            places.measure_causes(passage, kernel, run,
                                  lambda at, x=x, z=z: np.interp(at, x, z), -z.min(), numbers)


def measure_errors(passage, kernel, run, path, seeds, drawn, numbers, lines):
    """Of all seeds; a passage that is refused counts as an infinite error. `drawn`: name of the
    lines of the first seed."""
    peaks, dynamic, heights, starts, refused = [], [], [], [], 0
    for seed in range(seeds):
        try:
            forces, came, _ = inverse.evaluate(passage.noisy(1e-3, seed), kernel, 50.0)
        except read.Unreadable:  # the place of the train is not found
            refused += 1
            for of, count in ((peaks, 2), (dynamic, 2), (heights, 1), (starts, 1)):
                of += count * [np.inf]
            continue
        surface = inverse.irregularity(forces, kernel, 50.0)
        for wheel, (force, load) in enumerate(zip(forces.force, kernel.wheels.load)):
            true = passage.force[passage.near(wheel, (forces.x[0], forces.x[-1])), wheel].max()
            peaks.append(100 * abs(force.max() / true - 1))
            dynamic.append(100 * abs(force.max() - true) / (true - load))
        true = np.interp(surface.x, *path)
        heights.append(100 * np.abs(surface.height - true).max() / -path[1].min())
        starts.append(100 * abs(came.start - passage.x[0, 0]))
        if seed == 0 and drawn:
            lines.put("scanned_surface", f"{drawn}, identified", surface.x, 1e3 * surface.height)
            lines.put("scanned_surface", f"{drawn}, true", surface.x, 1e3 * true)
    numbers.put(run, "refused seeds", refused, "-")
    numbers.put(run, "seeds", seeds, "-")
    for what, values, unit in (("the largest force", peaks, "%"),
                               ("the dynamic force", dynamic, "%"),
                               ("the irregularity", heights, "%"), ("the place", starts, "cm")):
        numbers.put(run, f"error of {what}, median", np.median(values), unit)
        numbers.put(run, f"error of {what}, worst", max(values), unit)


def targets(n):
    """Of each wheel the worst of all designs and directions."""
    limits = (("the largest force", "largest force", 10), ("the irregularity",
                                                           "irregularity over its depth", 15))
    targets_found = []
    for wheel, name in WHEELS.items():
        runs_found = [run for run in (name_of(*case, wheel) for case in CASES) if n.has(run)]
        for what, title, limit in limits if runs_found else ():
            value = max(n(run, f"error of {what}, worst") for run in runs_found)
            targets_found.append(Target(f"scanned crossing, {name}: {title}, 0.1 % noise", "main",
                                        f"ours: below {limit} %", value, "%", holds=value < limit,
                                        see="Scanned crossings", infinite="refused"))
    return targets_found
