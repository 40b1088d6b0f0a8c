#!/usr/bin/env python3
"""Sleepers of 0.5, 1, 2 and 3 times the mass on four transitions to a bridge.

    sleeper_mass.py PROGRAM FOLDER [--ground] [--masses 0.5 3]

After the parametric study of "NeTIRail-INFRA D2.10, cost-effective transition zone design": its
original geometry (cement bound mixture, then unbound granular material, tapered with depth), the
same over one width at all depths, and both with embankment soil throughout. Two of its coaches at
220 km/h leave the bridge; rail displacements at 14.7 and 41 m from it are compared. The rail is
even: over a profile mass moves wheels elsewhere, by as much as another seed does. Writes
FOLDER/sleeper_mass.csv and sleeper_mass.png.

With --ground: one coach on the ground of elements of inputs/track/netirail.toml, on two ranks. With
embankment soil throughout all layers are equal and no taper is left, so that both geometries are
identical.

Otherwise on a track alone: the springs below the sleepers are columns of that report's Table 2:
each layer's modulus over an area whose sides grow by its depth (load spread 2:1), scaled so that
embankment has the 42 MN/m of inputs/track/netirail_plain.toml. The thicknesses of sub-ballast and
capping layer, and the extent of the wedge's parts (6.5 m each, tapered to nothing at 9 m), are
assumed, as the report gives them only in drawings. Columns neglect the continuity of the soil, so
both geometries of embankment are identical here, and effects of sleeper mass through waves in the
ground are not included.
"""
import argparse
import csv
import subprocess
from pathlib import Path

import h5py
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import launch  # noqa: E402

DECK = Path(__file__).resolve().parent.parent / "inputs/track/netirail_plain.toml"
EMBANKMENT, UGM, CBM, ABUTMENT = 80e6, 1030e6, 10e9, 30e9         # Pa
ABOVE = ((0.3, 130e6), (0.3, 200e6), (0.3, 3020e6))  # m, Pa: ballast, sub-ballast, capping layer
SEAT = (0.29, 0.95)            # m, loaded area below half a sleeper
DEPTH, PART = 9.0, 6.5         # m, height of the backfill, length of each of its two parts
BRIDGE_ENDS, LENGTH, SPACING = 21.0, 84.0, 0.6  # m, x of the bridge's end; track
POINTS = (14.7, 41.0)          # m from the bridge
MASSES = (0.5, 1, 2, 3)
SLEEPER = 315                  # kg
GEOMETRIES = {"original": (True, True), "same width": (False, True),
              "same width, embankment": (False, False), "tapered, embankment": (True, False)}


def modulus(distance, depth, tapered, reinforced):
    """Pa, of the backfill `distance` m behind the bridge, `depth` m below the capping layer."""
    if distance < 0:
        return ABUTMENT
    reach = PART * (1 - depth / DEPTH) if tapered else PART
    if not reinforced or distance > 2 * reach:
        return EMBANKMENT
    return CBM if distance <= reach else UGM


def column(distance, tapered, reinforced):
    """Spring below one rail seat, N/m: 1/k = integral of dz/(E A)."""
    compliance, top, step = 0.0, 0.0, 0.01
    layers = [*ABOVE, (DEPTH, None)]
    for thickness, young in layers:
        for z in np.arange(step / 2, thickness, step):
            here = young or modulus(distance, z, tapered, reinforced)
            compliance += step / (here * (SEAT[0] + top + z) * (SEAT[1] + top + z))
        top += thickness
    return 1 / compliance


def zones(tapered, reinforced):
    """Factors of the plain track's spring, one for each sleeper, as TOML."""
    plain = column(1e3, False, False)
    text = ""
    for x in SPACING * np.arange(round(LENGTH / SPACING) + 1):
        factor = column(x - BRIDGE_ENDS, tapered, reinforced) / plain
        text += (f"\n[[track.zone]]\nfrom = {x - 0.45 * SPACING:.3f}\n"
                 f"to = {x + 0.45 * SPACING:.3f}\nbed = {factor:.4f}\n")
    return text


def measured(place):
    """At the points, m: largest downward displacement of the rail, and its rms over the run."""
    with h5py.File(place / "results.h5") as file:
        rail = file["history/rail/displacement"][()]
    return np.array([-rail.min(axis=0), np.sqrt((rail**2).mean(axis=0))])


def run_program(command, what):
    ran = launch.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if ran.returncode:
        launch.fail(ran, what)


def run(program, folder, name, mass, text):
    place = folder / f"{name.replace(', ', '_').replace(' ', '_')}_{mass}"
    deck = folder / f"{place.name}.toml"
    deck.write_text(text, encoding="utf-8")
    points = [round((BRIDGE_ENDS + point) / 0.15) * 0.15 for point in POINTS]  # nodes
    run_program([program, "run", deck, f"track.length={LENGTH}",
                 f"track.sleeper_mass={mass * SLEEPER}",
                 'train.vehicles=["alfa_pendular", "alfa_pendular"]', f"passage.points={points}",
                 "irregularity.kind=none",
                 "--force", "-o", place], f"{name}, {mass}")
    return measured(place)


EMBANKED = [f"ground.layer.{layer}.{word}" for layer in ("sub_ballast", "capping")
            for word in ("young=80e6", "density=2040", "rayleigh_stiffness=2.9e-3")]
STRAIGHT = {"ugm": "[6,-0.6,19,-0.6,19,-9,6,-9]", "cbm": "[6,-0.6,12.5,-0.6,12.5,-9,6,-9]"}


def run_on_ground(program, folder, name, mass):
    tapered, reinforced = GEOMETRIES[name]
    words = []
    if not reinforced:
        words = [*EMBANKED, "ground.block.ugm.present=false", "ground.block.cbm.present=false"]
    elif not tapered:
        words = [f"ground.block.{block}.outline={outline}" for block, outline in STRAIGHT.items()]
    place = folder / f"ground_{name.replace(', ', '_').replace(' ', '_')}_{mass}"
    run_program(launch.on_ranks(2, program, "run", DECK.parent / "netirail.toml", *words,
                                f"track.sleeper_mass={mass * SLEEPER}", "passage.duration=1.1",
                                'train.vehicles=["alfa_pendular"]', "--force", "-o", place),
                f"{name}, {mass}")
    return measured(place)


def draw(found, path):
    masses = sorted({mass for _, mass in found})
    figure, panels = plt.subplots(1, len(POINTS), figsize=(10, 4.5), sharey=True,
                                  layout="constrained")
    for k, panel in enumerate(panels):
        for number, name in enumerate(GEOMETRIES):
            panel.bar(np.arange(len(masses)) + 0.2 * number,
                      [1e3 * found[name, mass][0, k] for mass in masses], 0.2, label=name)
        panel.set_xticks(np.arange(len(masses)) + 0.3, [f"{mass} x" for mass in masses])
        panel.set(title=f"{POINTS[k]} m from the bridge", xlabel="mass of sleepers")
        panel.grid(alpha=0.3, axis="y")
    panels[0].set(ylabel="downward displacement of the rail, mm")
    panels[0].set_ylim(top=1.25 * panels[0].get_ylim()[1])  # space for the legend
    panels[0].legend(fontsize=8, loc="upper center", ncols=2)
    figure.savefig(path, dpi=130)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("program", type=launch.program)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--ground", action="store_true")
    parser.add_argument("--masses", type=float, nargs="+", default=MASSES)
    given = parser.parse_args()
    if min(given.masses) <= 0:
        parser.error(f"--masses: {min(given.masses):g}: factors must be above 0")
    launch.make_folder(given.folder)
    plain = DECK.read_text(encoding="utf-8")
    head, rest = plain.split("[train]")
    found = {}
    for name, kind in GEOMETRIES.items():
        text = head + zones(*kind) + "\n[train]" + rest
        for mass in given.masses:
            if not given.ground:
                found[name, mass] = run(given.program, given.folder, name, mass, text)
            elif kind == (True, False):
                found[name, mass] = found["same width, embankment", mass]
            else:
                found[name, mass] = run_on_ground(given.program, given.folder, name, mass)
            change = found[name, mass] / found[name, given.masses[0]] - 1
            print(f"{name:24} mass {mass:3} x: largest downward displacement of the rail "
                  "(in brackets: root mean square) " + ", ".join(
                f"{1e3 * down:.4f} ({1e3 * rms:.4f}) mm at {point} m, "
                f"{100 * more:+.1f} ({100 * more_rms:+.1f}) % relative to its value "
                f"with {given.masses[0]} times the mass"
                for point, (down, rms), (more, more_rms)
                in zip(POINTS, found[name, mass].T, change.T)), flush=True)
    with open(given.folder / "sleeper_mass.csv", "w", newline="", encoding="utf-8") as out:
        rows = csv.writer(out)
        rows.writerow(["geometry", "mass_factor", *(f"{what}_{point}_m" for what in ("down", "rms")
                                                    for point in POINTS)])
        rows.writerows([name, mass, *both.flat] for (name, mass), both in found.items())
    draw(found, given.folder / "sleeper_mass.png")


if __name__ == "__main__":
    main()
