#!/usr/bin/env python3
"""A bed of copies of one periodic cell, on the decks inputs/bed/cell and inputs/bed/tile, smaller.

    tile.py PROGRAM FOLDER_OF_DECKS FOLDER

The copies are at rest as the cell is, joints are like any other place, results do not depend on
ranks or stops, and a checkpoint that cannot be a cell is refused before anything runs.
"""
import re
import shutil
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import checkpoint  # noqa: E402

LENGTH, COPIES = 0.6, 3  # m
SMALL = ["bed.y=[0, 0.3]", "bed.height=0.09", "region.slabs.y=[0, 0.3]",
         "region.slabs.z=[0.02, 0.07]"]
CELL = [*SMALL, "stage.fill.duration=0.25", "platen.pressure=20e3", "stage.release.duration=0.02",
        "stage.rest.duration=0.05"]
# Slabs of 0.1 m, every sixth on a joint; all within the bed.
TILE = [*SMALL, f"bed.x=[0, {COPIES * LENGTH}]", "region.slabs.x=[0.15, 1.65]",
        "region.slabs.cells=[15, 1, 1]", "stage.lay.duration=0.01"]
JOINTS, RING = [4, 10], 'periodic=["x"]'


class Bench:
    def __init__(self, program, decks, folder):
        self.program, self.decks, self.folder = program, decks, folder
        self.cell = folder / "cell"

    def tile(self, name, ranks, *changes, code=0):
        self.program.done(ranks, "run", self.decks / "tile.toml", f"bed.cell={self.cell}", *TILE,
                          *changes, "-o", self.folder / name, code=code)
        return self.folder / name


def places(folder, stage):
    """Positions at the end of a stage, of stones by id."""
    stones = checkpoint(folder, stage)
    return stones["particles/position"][np.argsort(stones["particles/id"])]


def furthest(bed, cell, copies):
    """Largest displacement of a stone relative to the cell, m."""
    moved = places(bed, "lay") - np.tile(places(cell, "rest"), (copies, 1))
    moved[:, 0] -= LENGTH * np.round(moved[:, 0] / LENGTH)
    return np.abs(moved).max()


def check_rest(bench):
    """On 1 and 3 ranks: bitwise identical, and at rest as a single copy is. Other numbers of copies
    are tested by tile_test and `check_open`."""
    rings = [bench.tile(f"ring_{ranks}", ranks, RING) for ranks in (1, 3)]
    one = bench.tile("one", 1, RING, f"bed.x=[0, {LENGTH}]")
    figures = [summary(ring) for ring in rings]
    if len({found["dem"]["state_hash"] for found in figures}) != 1:
        raise SystemExit("the bed depends on the number of ranks")
    alone, many = summary(one), figures[1]
    for what, values in (("particles", [f["dem"]["particles"] for f in (alone, many)]),
                         ("elastic energy", [f["energy"]["elastic"] for f in (alone, many)])):
        if abs(values[1] / (COPIES * values[0]) - 1) > 1e-3:
            raise SystemExit(f"{what}: {values[1]} in {COPIES} copies, {values[0]} in one")
    moved = [furthest(rings[1], bench.cell, COPIES), furthest(one, bench.cell, 1)]
    print(f"largest displacement of a stone: {moved[0]:.3g} m in the ring, "
          f"{moved[1]:.3g} m in one copy")
    if moved[0] > 1.01 * moved[1] + 1e-6:
        raise SystemExit("the copies are not at rest as a single one is")
    return rings[1]


def check_joints(ring):
    """Density and coordination in slabs on joints against those of all other slabs."""
    slabs = summary(ring)["regions"][0]["cells"]
    for name in ("bulk_density_kg_m3", "coordination"):
        values = np.array([slab[name] for slab in slabs])
        elsewhere = np.delete(values, JOINTS)
        print(f"{name}: joints {values[JOINTS]}, elsewhere {elsewhere.mean():.4g} "
              f"+- {elsewhere.std():.2g}, {elsewhere.min():.4g} to {elsewhere.max():.4g}")
        # Tolerance: three standard deviations of a slab.
        if np.abs(values[JOINTS] - elsewhere.mean()).max() > 3 * elsewhere.std():
            raise SystemExit(f"{name} at the joints: {values[JOINTS]}, elsewhere {elsewhere}")


def check_open(bench, ring):
    """Between walls: no stone crosses them; stopped and resumed without the cell."""
    whole = bench.tile("open", 1)
    if not 0 < summary(ring)["dem"]["particles"] - summary(whole)["dem"]["particles"] < 200:
        raise SystemExit("some stones, but not many, must cross the ends of a bed")
    stopped = bench.tile("stopped", 2, "output.stop_after=200", code=3)
    bench.cell.rename(bench.folder / "moved")
    bench.program.done(3, "resume", stopped)
    (bench.folder / "moved").rename(bench.cell)
    hashes = [summary(folder)["dem"]["state_hash"] for folder in (whole, stopped)]
    if hashes[0] != hashes[1]:
        raise SystemExit(f"stopped and resumed: {hashes}")


def check_sentences(bench):
    """Every problem of a deck with its cell is reported with its line or the command line."""
    made = {"walls": ["periodic=[]"], "ring_y": ['periodic=["x", "y"]', "bed.y=[0, 0.6]"]}
    for name, changes in made.items():
        bench.program.done(2, "run", bench.decks / "cell.toml", *CELL, *changes,
                           "output.stop_after=20", "-o", bench.folder / name, code=3)
    text = (bench.decks / "tile.toml").read_text(encoding="utf-8")
    twice = bench.folder / "twice.toml"
    twice.write_text(text.replace('cell = "../../results/cell"', "") +
                     '\n[[stage]]\nname = "again"\nkind = "fill"\nduration = 0.1\n',
                     encoding="utf-8")
    granite = bench.folder / "granite.toml"
    granite.write_text(text.replace('"ballast"', '"granite"').replace(
        "[bed]", '[bed]\nmaterial = "granite"').replace(
        'dimension = "space"', 'dimension = "space"\nwall_material = "granite"\n'
        'ground_material = "granite"').replace(
            'cell = "../../results/cell"', ""), encoding="utf-8")
    # The deck's own stones have a contact law with the floor, those of the cell have none.
    floor = bench.folder / "floor.toml"
    contact = text[text.index("[[contact]]"):text.index("[dem]")]
    floor.write_text(text.replace('cell = "../../results/cell"', 'material = "granite"').replace(
        'dimension = "space"', 'dimension = "space"\nground_material = "lead"').replace(
            contact, contact + "".join(
                contact.replace('first = "ballast"', f'first = "{first}"').replace(
                    'second = "ballast"', f'second = "{second}"')
                for first, second in (("granite", "granite"), ("granite", "lead"),
                                      ("granite", "ballast")))).replace(
                "[[contact]]", "".join(f'[[material]]\nname = "{name}"\ndensity = 2650\n\n'
                                       for name in ("granite", "lead")) + "[[contact]]", 1),
                     encoding="utf-8")
    deck = bench.decks / "tile.toml"
    for changes, words, of in (
            (["bed.x=[0, 1.7]"], ["bed.x is 1.7 m long, which is 2.833 cells of 0.6 m",
                                  "lengths are 1.2 and 1.8 m"], deck),
            (["bed.x=[0, 0.3]"], ["lengths are 0.6 and 1.2 m"], deck),
            (["bed.y=[0, 0.4]"], ["bed.y", "reaches from 0 to 0.3 m"], deck),
            (['periodic=["x", "y"]'],
             ['periodic contains "y", but the cell was made without it'], deck),
            (["dimension=plane", "bed.stone=disk"],
             ["bed.cell", 'made with dimension = "space"'], deck),
            ([f"bed.cell={bench.folder / 'walls'}"], ["within stage", "stage_*.h5",
                                                      "not made with periodic"], deck),
            ([f"bed.cell={bench.folder / 'ring_y'}"],
             ['periodic is without "y", but the cell was made with it'], deck),
            ([f"bed.cell={bench.cell / 'stage_compact.h5'}"], ["platen", "release"], deck),
            ([f"bed.cell={bench.cell / 'results.h5'}"], ["bed.cell = ", "not a trackbed"], deck),
            (["time.step=2e-5"], ["time.step = 2e-05 s is above the stable"], deck),
            (["bed.cell=nowhere.h5"], ["bed.cell", "does not exist"], deck),
            ([], ["needs exactly one stage of kind fill, which places the copies of the "
                  "cell; the deck has 2 such stages"], twice),
            ([], ['stones of "ballast"', "no [[material]]"], granite),
            ([], ['stones of "ballast" that touch "lead"'], floor)):
        # Of two overrides of one parameter the last one counts.
        ran = bench.program(1, "check", of, f"bed.cell={bench.cell}", *TILE, *changes)
        if ran.returncode != 2 or any(word not in ran.stderr for word in words):
            raise SystemExit(f"{changes} must be refused with {words}:\n{ran.stdout}{ran.stderr}")
    # Stones are copied: what describes them in this deck has no effect, and is warned of.
    ran = bench.program.done(1, "check", deck, f"bed.cell={bench.cell}", *TILE, "bed.height=0.1",
                             "bed.sieve=[20, 30, 40, 50]", "bed.passing=[0, 30, 60, 100]")
    for key in ("height = 0.1 (0.09 in ", "sieve = [", "passing = ["):
        if not re.search(rf"warning: .*bed\.{re.escape(key)}.*has no effect on them",
                         ran.stdout + ran.stderr):
            raise SystemExit(f"bed.{key} must be warned of:\n{ran.stdout}{ran.stderr}")
    ran = bench.program(1, "run", deck, f"bed.cell={bench.cell}", *TILE, "bed.x=[0, 1.7]", "-o",
                        bench.folder / "nowhere")
    if ran.returncode != 2 or (bench.folder / "nowhere").exists():
        raise SystemExit("a refused run must leave nothing behind")
    # Also if it starts from another checkpoint.
    more = bench.folder / "more.toml"
    more.write_text(text + '\n[[stage]]\nname = "rest"\nkind = "settle"\nduration = 0.1\n',
                    encoding="utf-8")
    for of, start in ((deck, []),
                      (more, [f"start={bench.folder / 'ring_1' / 'stage_lay.h5'}", RING])):
        ran = bench.program(1, "run", of, f"bed.cell={bench.cell}", *TILE, *start, "--force",
                            "-o", bench.cell)
        if ran.returncode != 2 or "from which this run starts: results" not in ran.stderr:
            raise SystemExit(f"a run must not replace its own cell:\n{ran.stdout}{ran.stderr}")


def main():
    folder = Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    bench = Bench(Program(sys.argv[1]), Path(sys.argv[2]), folder)
    bench.program.done(2, "run", bench.decks / "cell.toml", *CELL, "-o", bench.cell)
    ring = check_rest(bench)
    check_joints(ring)
    check_open(bench, ring)
    check_sentences(bench)


main()
