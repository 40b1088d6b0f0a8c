#!/usr/bin/env python3
"""Stress measured in a bed under a platen against the platen's force and against the forces on the
stones of the checkpoint, on the deck inputs/bed/press with fewer and rounder stones.

    press.py PROGRAM DECK FOLDER
"""
import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402

SMALL = ["bed.height=0.1", "bed.stone=disk", "dem.largest_overlap=0.5", "platen.speed=3",
         "stage.fill.duration=0.2", "region.slab.z=[0.03, 0.07]", "region.layers.z=[0, 0.08]",
        "contact.0.zeta_n=0", "contact.0.zeta_s=0",  # the measured stress is that of springs only
        # So quiet that no contact opens or closes in the last step, in which its force is not
        # that of its overlap alone (contact.hpp, spring_force).
        "stage.compact.local_damping=0.6"]
LAYER = 0.02  # m
# Relative. A sum over ranks has 1e3 terms here, each off by 2^-61 of the largest times all 1e6
# terms of the region (core/exact_sum.hpp), and is 20 times the largest: 2e-11 at most.
ROUNDING = 1e-10


def steps_by_force(checkpoint, area, layers):
    """Pa by which the mean compression of each layer is above that of the next. Between two heights
    the force through a section changes by the contact forces f on the stones between them, so the
    means over neighbouring layers differ by the sum of f, each weighted by a triangle that is 1 at
    their border and 0 a layer away."""
    with h5py.File(checkpoint) as file:
        z, f = file["particles/position"][:, 2], file["particles/force"][:, 2]
    weights = [np.clip(1 - np.abs(z / LAYER - border), 0, None) for border in range(1, layers)]
    return np.array([weight @ f for weight in weights]) / area


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    program.done(2, "run", deck, *SMALL, "--force", "-o", folder)
    stage = summary(folder)["stages"][-1]
    regions = {r["name"]: r["cells"] for r in summary(folder)["regions"]}
    pressed = stage["platen_pressure_pa"]
    with h5py.File(folder / "results.h5") as file:
        last = {name: group["stress"][-1].reshape(-1, 6)[:, 2]
                for name, group in file["history/region"].items()}
        width = file["history/region/layers/porosity"].shape[1]
        # Stones touch before the platen comes: no row, not even a stage's first, may say otherwise.
        number = file["history/stage"][()].ravel()
        later = file["history/energy/elastic"][()].ravel()[number == number[-1]]
    deck = tomllib.loads(Path(deck).read_text(encoding="utf-8"))
    wrong = []
    if not np.all(later > 0):
        wrong.append(f"elastic energy {later[:3]} J when the platen comes")
    if not stage["aim_reached"] or abs(pressed / deck["platen"]["pressure"] - 1) > 0.02:
        wrong.append(f"the platen presses by {pressed} Pa")
    # Weight of what lies above: below a per cent of the pressure, and known.
    slab = regions["slab"][0]
    weight = slab["bulk_density_kg_m3"] * 9.81 * 0.05
    if abs(-slab["stress_pa"][2] / (pressed + weight) - 1) > 0.02:
        wrong.append(f"{-slab['stress_pa'][2]} Pa below a platen of {pressed} Pa")
    layers = -np.array([cell["stress_pa"][2] for cell in regions["layers"]])
    bed = deck["bed"]
    area = (bed["x"][1] - bed["x"][0]) * (bed["y"][1] - bed["y"][0])
    steps = steps_by_force(folder / "stage_compact.h5", area, len(layers))
    if np.max(np.abs(layers[:-1] - layers[1:] - steps)) > ROUNDING * pressed:
        wrong.append(f"layers differ by {layers[:-1] - layers[1:]} Pa, their stones by {steps} Pa")
    if width != deck["region"][1]["cells"][2]:
        wrong.append(f"{width} cells in the histories")
    if abs(last["slab"][0] / slab["stress_pa"][2] - 1) > 0.02:
        wrong.append("the last row is not the end of the run")
    if not 0.3 < slab["porosity"] < 0.5 or not 2 < slab["coordination"] < 8:
        wrong.append(f"porosity {slab['porosity']}, coordination {slab['coordination']}")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"platen {pressed:.0f} Pa, layers {[f'{p:.0f}' for p in layers]} Pa")


main()
