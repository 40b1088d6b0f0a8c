"""Models and runs of the study demfem: what its runs, targets and document share."""
import numpy as np

from .study import Run, as_file, deck_of

SLEEPER, GROUND, SOLIDS = "demfem/sleeper.toml", "demfem/ground.toml", "demfem/solids.toml"
CELL, TRACK = "demfem/cell.toml", "demfem/track.toml"
DECK, GROUND_DECK, TRACK_DECK = deck_of(SLEEPER), deck_of(GROUND), deck_of(TRACK)
TITLES = {"convex": "convex", "non_convex": "non-convex"}
SHAPES = tuple(TITLES)
ROCKS, SIZE = 6, 0.02  # their number; m, length unit of their meshes
PARTS = {"convex": 1, "non_convex": 3}  # convex pieces of a stone
CORNERS = 12  # of a piece: 20 triangles
PACKINGS = (1, 2, 3, 4, 5)  # seeds
BARRED = (1, 2, 3)  # those with contacts as stiff as bars
LONG, LONG_CYCLES = (1,), 50  # those with as many cycles as the study, after the same placing
TRACKS = (1, 2)  # those of the ten sleepers
STAGES = {stage["name"]: stage for stage in DECK["stage"]}
CYCLES = STAGES["cycles"]
PERIOD = CYCLES["duration"] / CYCLES["cycles"]  # s
AREA = DECK["sleepers"]["width"] * DECK["sleepers"]["length"]  # m2, of a sleeper
HEIGHT = STAGES["sleepers"]["height"]  # m, of the bed below the sleepers when they are placed
STONES = DECK["material"][0]["young"]  # Pa
GRANITE = 50e9  # Pa, which the study calls realistic
# Contacts as stiff as a bar of this modulus between the centres of two stones, whose section is the
# square of their distance: k = modulus times distance. Less stiff along the contact, as in a bar.
BAR, ZETA = 0.04, 0.3  # m, mean distance; damping ratio
BARS = tuple(f"contact.{k}.{word}" for k in range(3) for word in (
    "law=linear", f"k_n={STONES * BAR:g}", f"k_s={STONES * BAR / 2:g}", f"zeta_n={ZETA:g}",
    f"zeta_s={ZETA:g}"))
# Contact forces at eight instants of each cycle.
FIELDS = ("output.fields=true", f"output.fields_interval={PERIOD / 8:g}",
          'output.fields_parts=["contacts"]')
LAYER = (0.05, 0.2)  # m, whose contacts bound the modulus: without those of floor and sleepers
RAIL = {"soft end": 0.9, "middle": 2.7, "stiff end": 5.1}  # m, x of a sleeper below the rail
# Coarser stones for the short form: half of their number, and longer steps.
COARSE = ("bed.sieve=[45,63]", "bed.passing=[0,100]")
FORCES = np.geomspace(1e-3, 10, 25)  # kN, edges of the histogram
WIDTHS = {"0.25 m": "young_025.csv", "1 m": "young_100.csv"}  # of the rise of the modulus
FREE_ENDS = ("ground.side_x_low=free", "ground.side_x_high=free")
COARSE_GROUND = ("ground.elements_x=30", "ground.elements_y=12", "ground.elements_z=5")
GROUNDS = {
    "as in the deck": (),
    "free ends": FREE_ENDS,
    "elements of 0.2 m": COARSE_GROUND,
    "elements of 0.2 m, free ends": (*COARSE_GROUND, *FREE_ENDS),
    **{f"rise of the modulus over {width}":
       (f"ground.layer.subground.young_file='{{folder}}/{file}'",)
       for width, file in WIDTHS.items()},
}
NAMES = {"as in the deck": "reference: rise of the modulus over 0.5 m"}  # in tables and figures
SOFT, HARD, MIDDLE = 80e6, 30e9, 3.0  # Pa, Pa, m
# The study's benchmark: stones, hexahedra of the ground, steps of both in 0.5 s; minutes in total,
# of stones, of elements and of coupling with 3.5e4 elements, most of them in rails and sleepers.
BENCHMARK = {"stones": {"convex": 3.3e5, "non_convex": 3.4e5}, "elements": 3750,
             "stone_step": 1e-6, "element_step": 1e-5, "duration": 0.5,
             "minutes": {"convex": (303, 85, 122, 96), "non_convex": (495, 256, 144, 95)}}
LAST_OF_REST = 0.01  # s, in which the motion of the rail is measured
RAMP = next(stage["ramp"] for stage in TRACK_DECK["stage"] if stage["kind"] == "passage")  # s
COARSER = 2  # size of the study's elements of the ground over that of the track's
ELEMENTS, BLOCKS = "elements", f"blocks of {COARSER**3}"  # whose stresses are compared
PEAK = 0.005  # MPa, least prominence of a peak of compression along the track
CORES = 8  # of the study's computer, besides its graphics processor

def of_stones(shape):
    return ("bed.stone=library", f"bed.library='{{folder}}/{shape}.h5'")


def bed(shape, packing, words=()):
    return Run(f"bed_{shape}_{packing}", SLEEPER,
               (f"bed.seed={packing}", *of_stones(shape), *FIELDS, *words))


def track_of(shape, packing):
    """Ten sleepers on a bed of copies of one cell."""
    cell = f"cell_{shape}_{packing}"
    return [Run(cell, CELL, (f"bed.seed={packing}", *of_stones(shape))),
            Run(f"track_{shape}_{packing}", TRACK,
                (*of_stones(shape), f"bed.cell='{{folder}}/{cell}'", "output.fields=true",
                 f"output.fields_interval={PERIOD / 8:g}", 'output.fields_parts=["ground"]',
                 "output.ground_extremes=true"))]


def runs(form, ranks):
    full = form == "full"
    found = [run for packing in (TRACKS if full else ()) for shape in reversed(SHAPES)
             for run in track_of(shape, packing)]
    found += [bed(shape, packing, () if full else COARSE)
              for packing in (PACKINGS if full else PACKINGS[:1]) for shape in reversed(SHAPES)]
    found += [Run(ground_run(name), GROUND, words) for name, words in GROUNDS.items()]
    if full:
        # The same stones as poured: in a loaded bed their overlaps would have 50 times the energy.
        found.append(Run("bed_granite", SLEEPER, (
            "bed.seed=1", *of_stones("convex"), f"material.ballast.young={GRANITE:g}",
            "stage.cycles.cycles=1", f"stage.cycles.duration={PERIOD:g}", *FIELDS,
            "start='{folder}/bed_convex_1/stage_fill.h5'")))
        found += [Run(f"bars_{shape}_{packing}", SLEEPER, (
            f"bed.seed={packing}", *of_stones(shape), *BARS, "dem.safety=0.2", *FIELDS))
            for packing in BARRED for shape in reversed(SHAPES)]
        found += [Run(f"long_{shape}_{packing}", SLEEPER, (
            f"bed.seed={packing}", *of_stones(shape), f"stage.cycles.cycles={LONG_CYCLES}",
            f"stage.cycles.duration={LONG_CYCLES * PERIOD:g}",
            f"start='{{folder}}/bed_{shape}_{packing}/stage_sleepers.h5'"))
            for packing in LONG for shape in reversed(SHAPES)]
        for shape in SHAPES:
            words = of_stones(shape)
            found += [Run(f"bedded_{shape}", SOLIDS, words, ranks),
                      # The wheels again, so that times are those of the wheels alone.
                      Run(f"cost_{shape}", SOLIDS,
                          (*words, f"start='{{folder}}/bedded_{shape}/stage_preload.h5'"), ranks)]
    return found


def ground_run(name):
    return f"ground_{as_file(name)}"


LAST = f"cycle {CYCLES['cycles']}"
NEXT_TO_LAST = f"cycle {CYCLES['cycles'] - 1}"
SETTLED = "settlement after the first cycle"
LEFT = "load left when the platen is removed"
TWO_RATES, TEN_RATES = "two solid sleepers", "ten sleepers"  # models whose cost is measured
GROUND_RUN = ground_run("as in the deck")
# Mass of the stones that decks leave out: those below the least sieve of the slice (middle of
# category A) and, from its grading, those below the least sieve of the cell.
WITHOUT = [0.13]
WITHOUT.append(WITHOUT[0] + (1 - WITHOUT[0]) * 0.01 * float(np.interp(
    deck_of(CELL)["bed"]["sieve"][0], DECK["bed"]["sieve"], DECK["bed"]["passing"])))


def stage_of(deck, kind):
    return next(stage for stage in deck["stage"] if stage.get("kind") == kind)


EDGES = [x for area in GROUND_DECK["pressure"] for x in area["x"]]  # m, of loaded areas
COLUMN = np.ptp(GROUND_DECK["ground"]["x"]) / GROUND_DECK["ground"]["elements_x"]  # m


def edge_near(x):
    return min(EDGES, key=lambda edge: abs(edge - x))


def at_edge(x):
    """Whether an edge of a loaded area is in the column of elements whose middle is x, m."""
    return abs(edge_near(x) - x) <= COLUMN / 2
