#!/usr/bin/env python3
"""Stress measured in a bed below a platen, compared with the platen's force and with the forces on
the stones of the checkpoint, on the deck inputs/bed/platen.toml with fewer and rounder stones.

    platen.py PROGRAM DECK FOLDER
"""
import sys
import tomllib
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import checkpoint, datasets  # noqa: E402

SMALL = ["bed.height=0.1", "bed.stone=disk", "dem.largest_overlap=0.5", "platen.speed=3",
         "stage.fill.duration=0.2", "region.slab.z=[0.03, 0.07]", "region.layers.z=[0, 0.08]",
        "contact.0.zeta_n=0", "contact.0.zeta_s=0",  # the measured stress is that of springs only
        # So much damping that no contact opens or closes in the last step, in which its force is
        # not determined by the overlap only (contact.hpp, spring_force).
        "stage.compact.local_damping=0.6"]
# Without dashpots the bed comes to rest slowly: it is held with friction and local damping.
HELD = """
[[stage]]
name = "held"
kind = "compact"
duration = 0.03
friction = 2
local_damping = 0.8
"""
LAYER = 0.02  # m
# Relative. A sum over ranks has 1e3 terms here, each with an error of 2^-61 of the largest times
# all 1e6 terms of the region (core/exact_sum.hpp), and is 20 times the largest: 2e-11 at most.
ROUNDING = 1e-10


def steps_by_force(held, area, layers):
    """Difference of mean compression between each layer and the next, Pa. Between two heights the
    force through a section changes by the contact forces f on the stones between them, so the means
    over neighbouring layers differ by the sum of f, weighted by a triangle that is 1 at their
    border and 0 one layer away."""
    z, f = held["particles/position"][:, 2], held["particles/force"][:, 2]
    weights = [np.clip(1 - np.abs(z / LAYER - border), 0, None) for border in range(1, layers)]
    return np.array([weight @ f for weight in weights]) / area


def contacts(x, radius, widths, platen):
    """All pairs of stones, and all stones with the floor at 0 and with the platen: overlap, numbers
    of both stones, normal."""
    i, j = np.triu_indices(len(x), 1)
    d = x[i] - x[j]
    d[:, :2] -= widths * np.round(d[:, :2] / widths)
    apart, every, up = np.linalg.norm(d, axis=1), np.arange(len(x)), np.array([[0, 0, 1]])
    overlap = (radius[i] + radius[j] - apart, radius - x[:, 2], radius - (platen - x[:, 2]))
    return (np.concatenate(overlap), np.concatenate([i, every, every]),
            np.concatenate([j, every + len(x), every + len(x)]),
            np.concatenate([d / apart[:, None], np.repeat(up, 2 * len(x), axis=0)]))


def unsure(held, deck, widths, step):
    """Largest difference between the stones' forces and those of their overlaps, Pa. In the step in
    which a contact begins or ends, its force is not determined by its overlap only (contact.hpp,
    spring_force), but is off by at most k_n s, where s is the normal displacement in a step:
    contacts with an overlap below s count. Twice s, as local damping adds to the acceleration."""
    x, v, f, scale = (held[f"particles/{name}"] for name in
                      ("position", "velocity", "force", "scale"))
    volume, radius = held["particles/template/solid"][0, 0], held["particles/template/radius"]
    scale = scale.ravel()
    overlap, i, j, normal = contacts(x, radius.ravel()[0] * scale, widths,
                                     held["platen/z"][0])
    mass = deck["material"][0]["density"] * volume * scale**3
    still = np.zeros_like(v)  # floor and platen
    speed, change = (np.concatenate([of, still]) for of in (v, step * f / mass[:, None]))
    rate, late = (np.abs(np.einsum("ij,ij->i", of[i] - of[j], normal)) for of in (speed, change))
    travel = 2 * step * (rate + late)
    return deck["contact"][0]["k_n"] * travel[np.abs(overlap) < travel].sum() / np.prod(widths)


def wrong_layers(folder, deck, stage, regions):
    """Problems: differences between measured stress and the stones' forces."""
    layers, bed = -np.array([cell["stress_pa"][2] for cell in regions["layers"]]), deck["bed"]
    widths = np.array([bed["x"][1] - bed["x"][0], bed["y"][1] - bed["y"][0]])
    held = checkpoint(folder, "held")
    steps = steps_by_force(held, np.prod(widths), len(layers))
    off = unsure(held, deck, widths, stage["window_s"] / stage["substeps"])
    apart = np.max(np.abs(layers[:-1] - layers[1:] - steps))
    print(f"layers {[f'{p:.0f}' for p in layers]} Pa: their differences and the stones' forces "
          f"differ by {apart:.2g} Pa, allowed for beginning or ending contacts {off:.2g} Pa")
    return ([f"layers differ by {layers[:-1] - layers[1:]} Pa, their stones by {steps} Pa"]
            if apart > ROUNDING * stage["platen_pressure_pa"] + off else [])


def wrong_histories(folder, deck, slab):
    found = datasets(folder)
    last = found["history/region/slab/stress"][-1].reshape(-1, 6)[:, 2]
    width = found["history/region/layers/porosity"].shape[1]
    # Stones touch before the platen moves, which all rows must show, also the first of a stage.
    number = found["history/stage"].ravel()
    later = found["history/energy/elastic"].ravel()[number > number[0]]
    wrong = []
    if not np.all(later > 0):
        wrong.append(f"elastic energy {later[:3]} J when the platen starts")
    if width != deck["region"][1]["cells"][2]:
        wrong.append(f"{width} cells in the histories")
    if abs(last[0] / slab["stress_pa"][2] - 1) > 0.02:
        wrong.append("the last row is not the end of the run")
    return wrong


def main():
    program, folder = Program(sys.argv[1]), Path(sys.argv[3])
    text = Path(sys.argv[2]).read_text(encoding="utf-8") + HELD
    folder.mkdir(parents=True, exist_ok=True)
    path, folder, deck = folder / "held.toml", folder / "run", tomllib.loads(text)
    path.write_text(text, encoding="utf-8")
    program.done(2, "run", path, *SMALL, "--force", "-o", folder)
    compacted, stage = summary(folder)["stages"][-2:]
    regions = {r["name"]: r["cells"] for r in summary(folder)["regions"]}
    loaded, slab = stage["platen_pressure_pa"], regions["slab"][0]
    wrong = wrong_histories(folder, deck, slab)
    wrong += wrong_layers(folder, deck, stage, regions)
    if not compacted["aim_reached"] or abs(loaded / deck["platen"]["pressure"] - 1) > 0.02:
        wrong.append(f"pressure of the platen {loaded} Pa")
    # Known weight of the stones above, below one per cent of the pressure.
    weight = slab["bulk_density_kg_m3"] * 9.81 * 0.05
    if abs(-slab["stress_pa"][2] / (loaded + weight) - 1) > 0.02:
        wrong.append(f"{-slab['stress_pa'][2]} Pa below a platen of {loaded} Pa")
    if not 0.3 < slab["porosity"] < 0.5 or not 2 < slab["coordination"] < 8:
        wrong.append(f"porosity {slab['porosity']}, coordination {slab['coordination']}")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"platen {loaded:.0f} Pa")


main()
