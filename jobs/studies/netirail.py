"""Runs, numbers and targets of the study netirail: a train from a bridge to an embankment,
reinforced layers, mass of the sleepers (NeTIRail-INFRA D2.10). Its document: netirail_document.py.

The ground is modelled twice: in space (inputs/track/netirail.toml) and in the form of the report's
own model, a plane ground of the width of its layers (inputs/track/netirail_2d.toml).
"""
import math

import numpy as np

from .netirail_measure import (BACKFILL, BLOCKS, BRIDGE_ENDS, DECK, DEPTH, FAR, LAYERS, MIRROR,
                               NEAR, PLANE, SEEDS, SLEEPER, measure_ground, measure_stones, moved,
                               of_packing)
from .study import Run, Target, as_file, change, summary

SPACE = "track/netirail.toml"
MASSES = (0.5, 1, 2, 3)
WEDGE = ("ugm", "cbm")  # blocks, the farther one first
TOP = -0.6  # m, z of the top of the wedge
MATERIAL = ("young", "density", "rayleigh_stiffness")
BASE = ('train.vehicles=["alfa_pendular","alfa_pendular"]', "passage.duration=1.9",
        "output.history_interval=5e-4")
NO_WEDGE = tuple(f"ground.block.{name}.present=false" for name in WEDGE)


def fill(stiffer=1):
    """Embankment fill in sub-ballast and capping layer; moduli and densities `stiffer` times."""
    factors = dict(zip(MATERIAL, (stiffer, stiffer, 1)))
    return tuple(f"ground.layer.{layer}.{key}={factors[key] * LAYERS['embankment'][key]:g}"
                 for layer in ("sub_ballast", "capping") for key in MATERIAL)


FILL = fill()
EMBANKMENT = (*FILL, *NO_WEDGE)
WEDGES = {  # of other shapes, which the report shows in a drawing only
    "wedge of 16 m": ("ground.block.ugm.outline=[6,-0.6,22,-0.6,6,-9]",
                      "ground.block.cbm.outline=[6,-0.6,14,-0.6,6,-9]"),
    "wedge of 13 m": ("ground.block.ugm.outline=[6,-0.6,19,-0.6,6,-9]",
                      "ground.block.cbm.outline=[6,-0.6,12.5,-0.6,6,-9]"),
    "wedge of 13 m also at its foot": ("ground.block.ugm.outline=[6,-0.6,19,-0.6,19,-9,6,-9]",
                                       "ground.block.cbm.outline=[6,-0.6,12.5,-0.6,12.5,-9,6,-9]"),
}
ON_GROUND = "from=13,to=70"  # m, sleepers on the ground but the outermost


def zones(*more):
    """All zones of the track: those of the decks, before and behind the ground, and more."""
    return ("track.zone=[{from=-1,to=11.9,bed=0.2},{from=71.7,to=85,bed=0.2}"
            + "".join(",{" + one + "}" for one in more) + "]")


def behind(begin, end, words):
    """A zone from `begin` to `end` m behind the bridge."""
    return f"from={BRIDGE_ENDS + begin:g},to={BRIDGE_ENDS + end:g},{words}"


def reach_of(name):
    """m, of a part of the wedge at its top, from the bridge."""
    return max(BLOCKS[name]["outline"][::2]) - BACKFILL


def clip(begin, end, reach):
    """Outline of the part from x = begin to end of a triangle below the capping layer, whose top
    edge is `reach` long from the bridge and whose other edge is the abutment; none beyond it."""
    def foot(x):
        return TOP - (DEPTH + TOP) * max(0, 1 - (x - BACKFILL) / reach)
    if begin >= BACKFILL + reach - 1e-9:
        return None
    tip = min(end, BACKFILL + reach)
    points = [(begin, TOP), (tip, TOP), (tip, foot(tip)), (begin, foot(begin))]
    return [p for k, p in enumerate(points) if k != 2 or p[1] < TOP - 1e-9]


NARROWEST, NARROW_OVER = 0.5, 24.0  # of the width of the plane ground; m from the bridge


def narrow(layered, wedge, strip=3.0):
    """A plane ground whose width decreases linearly towards the bridge: strips with moduli and
    densities times their width over that of the model. `layered`: with sub-ballast and capping
    layer; `wedge`: with CBM and UGM."""
    blocks = []

    def block(name, outline, of, width):
        numbers = ",".join(f"{value:g}" for value in np.ravel(outline))
        blocks.append(f'{{name="{name}",outline=[{numbers}],young={of["young"] * width:g},'
                      f'poisson={of["poisson"]:g},density={of["density"] * width:g},'
                      f'rayleigh_stiffness={of["rayleigh_stiffness"]:g}}}')
    for k in range(round(NARROW_OVER / strip)):
        begin, top = BACKFILL + k * strip, 0
        end = begin + strip
        width = NARROWEST + (1 - NARROWEST) * (k + 0.5) * strip / NARROW_OVER
        for name, layer in LAYERS.items():
            bottom = top + layer["thickness"]
            block(f"{name}_{k}", [(begin, -top), (end, -top), (end, -bottom), (begin, -bottom)],
                  layer if layered else LAYERS["embankment"], width)
            top = bottom
        for name in WEDGE if wedge else ():
            if outline := clip(begin, end, reach_of(name)):
                block(f"{name}_{k}", outline, BLOCKS[name], width)
    block("abutment", BLOCKS["abutment"]["outline"], BLOCKS["abutment"], 1)
    return ("ground.block=[" + ",".join(blocks) + "]",)


GEOMETRIES = {  # of the report's Table 3: words of the plane model, name
    "original": (narrow(True, True), "narrow at the bridge, reinforced"),
    "same_width": ((), "13 m wide, reinforced"),
    "same_width_fill": (EMBANKMENT, "13 m wide, fill only"),
    "narrow_fill": ((*FILL, *narrow(False, False)), "narrow at the bridge, fill only"),
}


def mass(factor):
    return f"track.sleeper_mass={factor * SLEEPER:g}"


def spacing(metres):
    """Sleepers at another distance, on the ground from 0.3 m on as in the deck."""
    before, length = round(12 / metres), round(84 / metres) * metres
    count = math.floor(59.4 / metres + 1e-9) + 1
    behind_ground = (before + count - 0.5) * metres
    return (f"track.spacing={metres}", f"track.length={length:g}", f"footing.before={before}",
            f"track.zone.1.from={behind_ground:g}", f"footing.width={min(0.59, metres)}",
            f"footing.count={count}", f"passage.points=[{nearest(32.4, metres)},"
            f"{nearest(58.8, metres)}]")


def nearest(x, metres):
    """The sleeper nearest to x, m."""
    return f"{round(x / metres) * metres:g}"


# Whether anything lets three times the sleepers' mass change the displacement: words for both.
EXPERIMENTS = {
    "uneven rail, seed 1": ("irregularity.kind=spectrum", "irregularity.spectrum=erri_low"),
    "uneven rail, seed 2": ("irregularity.kind=spectrum", "irregularity.spectrum=erri_low",
                            "irregularity.seed=2"),
    "uneven rail, seed 3": ("irregularity.kind=spectrum", "irregularity.spectrum=erri_low",
                            "irregularity.seed=3"),
    "360 km/h": ("train.speed=100", "passage.duration=1.17"),
    "wheel contact ten times softer": ("wheel_rail.law=linear", "wheel_rail.stiffness=1.24e8"),
    "pads and ballast without damping": ("pad.damping=0", "ballast.damping=0"),
    "pads of 60 MN/m": ("pad.stiffness=60e6",),
    "three sleepers hang by 0.3 mm": (zones("from=31.5,to=33.3,gap=3e-4"),),
}
# Twice the mass by twice the width of 0.29 m: the foot of the ballast, wider by half of 0.3 m on
# each side, grows from 0.59 to 0.88 m, and its spring, E / integral of dz/A over it, becomes
# 1.71 times as stiff. Still wider sleepers would touch each other.
WIDE = "sleeper=2,footprint=1.49,bed=1.71"
# Measures at the bridge of the report's Appendix B, on embankment.
GLUED, PARTLY = "bed=4", "bed=2"
SECTIONS = ((-7.2, 0, "pad=0.4"), (0, 7.2, f"pad=0.4,rail=2,{GLUED}"),
            (7.2, 15, f"pad=0.4,rail=2,{PARTLY}"), (15, 27, f"rail=2,{PARTLY}"), (27, 35, PARTLY))
SLAB = ("ground.block=[{name=\"slab\",outline=[6,0,11,0,11,-0.25,6,-0.25],young=30e9,poisson=0.25,"
        "density=2500,rayleigh_stiffness=0},"
        "{name=\"abutment\",outline=[0,0,6,0,6,-9,0,-9],young=30e9,poisson=0.25,density=2500,"
        "rayleigh_stiffness=0}]")
# Two rows of elements in slab, sub-ballast and capping layer; with fill the rows end at the slab.
ROWS = tuple(f"ground.layer.{layer}.elements={n}"
             for layer, n in (("sub_ballast", 2), ("capping", 2), ("embankment", 28)))
FINE = ("ground.layer.sub_ballast.thickness=0.25", "ground.layer.capping.thickness=0.35", *ROWS)
MEASURES = {
    "none": (*EMBANKMENT, *FINE),
    "reinforced layers and wedge": ROWS,
    "approach slab, 5 m": (*FILL, *FINE, SLAB),
    "soft fastenings on the bridge": (*EMBANKMENT, *FINE, zones(behind(-17.7, 0, "pad=0.4"))),
    "stiff fastenings behind the bridge, 12 m": (*EMBANKMENT, *FINE, zones(behind(0, 12, "pad=3"))),
    "glued ballast, 7.2 m fully, 12 m partly": (
        *EMBANKMENT, *FINE, zones(behind(0, 7.2, GLUED), behind(7.2, 19.2, PARTLY))),
    "auxiliary rails, 27 m": (*EMBANKMENT, *FINE, zones(behind(0, 27, "rail=2"))),
    "under-sleeper pads on the bridge": (
        *EMBANKMENT, *FINE, "under_sleeper_pad.stiffness=60e6", "under_sleeper_pad.damping=20e3",
        f"under_sleeper_pad.to={BRIDGE_ENDS}"),
    "four sections as in Slovenia": (
        *EMBANKMENT, *FINE, zones(*(behind(*one) for one in SECTIONS))),
    "sleepers of three times the mass, 12 m": (
        *EMBANKMENT, *FINE, zones(behind(0, 12, "sleeper=3"))),
    "twice as wide sleepers, 12 m": (
        *EMBANKMENT, *FINE, zones(behind(0, 12, WIDE))),
    # From sleeper to sleeper. Footprints of 0.59 m would overlap; the last one is behind its zone.
    "sleepers every 0.5 m, 12 m": (
        *EMBANKMENT, *FINE, zones(behind(0.3, 12.3, "spacing=0.5,footprint=0.847"),
                                  behind(12.3, 12.8, "footprint=0.847")),
        f"footing.count={DECK['footing']['count'] + 4}"),
}
# What the report leaves open, on the displacements 41 m from the bridge: words in space.
OPEN = {
    "as above": (),
    "pads of 160 MN/m": ("pad.stiffness=160e6",),
    "capping layer of 0.6 m": ("ground.layer.capping.thickness=0.6",
                               "ground.layer.embankment.thickness=8.1"),
    "capping layer of 0.6 m and pads of 160 MN/m": (
        "ground.layer.capping.thickness=0.6", "ground.layer.embankment.thickness=8.1",
        "pad.stiffness=160e6"),
    "ballast spreads its load by 45 degrees": ("ballast.stiffness=330e6", "ballast.damping=132e3",
                                               "footing.width=0.6", "footing.length=1.6",
                                               "footing.y=0.8"),
    "ground of twice the width": ("ground.y=[0,13]", "ground.elements_y=20"),
    "embankment of 120 MPa": ("ground.layer.embankment.young=120e6",),
}
PLANE_OPEN = ("pads of 160 MN/m", "capping layer of 0.6 m",
              "capping layer of 0.6 m and pads of 160 MN/m")  # on the plane ground, too
# Springs before the ground as stiff as ballast on a rigid bridge.
LONG_BRIDGE = ("track.zone=[{from=71.7,to=85,bed=0.2}]",)
# 30 m more of ground and track, so that their ends are farther from the point at 41 m.
LONGER = ("ground.x=[0,90]", "ground.elements_x=150", "footing.count=150", "track.length=114",
          "track.zone.1.from=101.7", "track.zone.1.to=115")
# Too strong for explicit steps; plane ground.
DAMPING = ("ground.integrator=newmark", "passage.step=5e-4",
           "ground.layer.capping.rayleigh_stiffness=2.6e-3",
           "ground.block.ugm.rayleigh_stiffness=2.6e-3",
           "ground.block.cbm.rayleigh_stiffness=0.4e-3")
CONVERGENCE = {
    "as above": (),
    "half the step": ("passage.step=2.5e-5",),
    "half as long elements": ("ground.elements_x=200",),
    "half as wide elements": ("ground.elements_y=20",),
    "half as high elements": ("ground.elements_z=60",),
    "a rail of twice the elements": ("track.elements=8",),
}
STONES = "track/netirail_stones.toml"
CELL = "quickstart_cell.toml"
GLUED = 3  # packings
SOFT_STONES = fill(stiffer=5)  # the ground of that deck
SIX = tuple(word for word in BASE if "vehicles" not in word and "duration" not in word)


def mirrored(words=()):
    """The train comes from the embankment: the mirror image of the deck's layers."""
    def outline(name):
        points = np.reshape(BLOCKS[name]["outline"], (-1, 2))
        mirror = points * [-1, 1] + [DECK["ground"]["x"][1], 0]
        return ",".join(f"{value:g}" for value in mirror.ravel())
    points = ",".join(f"{MIRROR - x:g}" for x in DECK["passage"]["points"])
    return (*words, f"passage.points=[{points}]",
            *(f"ground.block.{name}.outline=[{outline(name)}]" for name in BLOCKS))


# Runs whose displacements along the track are drawn, and those whose displacements over time are.
DRAWN = {"space_layers", "space_no_wedge", "space_embankment", "plane_no_wedge",
         *(f"plane_{name}_1" for name in GEOMETRIES),
         *("plane_" + as_file(f"measure {name}") for name in MEASURES)}
OVER_TIME = {f"plane_{name}_{m}" for name in ("original", "narrow_fill") for m in (1, 2)}
# Histograms: runs to compare, by what differs between them.
COMPARED = {
    "reinforced layers, narrow at the bridge": ("plane_narrow_fill_1", "plane_original_1"),
    "reinforced layers, 13 m wide": ("plane_same_width_fill_1", "plane_same_width_1"),
    "2 x mass, narrow at the bridge, fill only": ("plane_narrow_fill_1", "plane_narrow_fill_2"),
    "2 x mass, 13 m wide, fill only": ("plane_same_width_fill_1", "plane_same_width_fill_2"),
}
UNLOADED = "2 x mass, 13 m wide, fill only, zero at the ground without sleepers"


def stones(seed):
    """The bed is laid and bedded in on a ground at rest, so both begin with the same stones. Runs
    side by side use cores better than one run on all of them."""
    cell, layers, fill_only, glued = (of_packing(name, seed) for name in (
        "stones_cell", "stones_layers", "stones_embankment", "stones_glued"))
    words = (f"bed.cell='{{folder}}/{cell}'",)
    soft = (*words, *SOFT_STONES, *NO_WEDGE)
    found = [Run(cell, CELL, () if seed == SEEDS[0] else (f"bed.seed={seed}",)),
             Run(layers, STONES, words),
             Run(fill_only, STONES, (*soft, f"start='{{folder}}/{layers}/stage_bed_in.h5'"))]
    if seed in SEEDS[:GLUED]:
        found.append(Run(glued, STONES, (*soft, "bond.glue.present=true",
                                         f"start='{{folder}}/{fill_only}/stage_rest.h5'")))
    return found


def runs(form, ranks):
    full = form == "full"

    def space(name, *words):
        return Run(f"space_{as_file(name)}", SPACE, (*BASE, *words), ranks)

    def plane(name, *words):
        return Run(f"plane_{as_file(name)}", PLANE, (*BASE, *words))
    found = [space("layers"), space("no wedge", *NO_WEDGE), space("embankment", *EMBANKMENT)]
    found += [space(f"{name}_{m}", *words, mass(m)) for m in (MASSES if full else (3,))
              for name, words in (("layers", ()), ("embankment", EMBANKMENT)) if m != 1]
    found += [plane(f"{name}_{m}", *words, mass(m)) for name, (words, _) in GEOMETRIES.items()
              for m in MASSES]
    found += [plane("back", *mirrored()), plane("no wedge", *NO_WEDGE)]
    if not full:
        return found
    for seed in SEEDS:
        found += stones(seed)
    found += [space("back", *mirrored()), space("back embankment", *mirrored(EMBANKMENT)),
              *(space(name, *words) for name, words in WEDGES.items()),
              Run("space_six", SPACE, SIX, ranks)]
    found += [space(f"open {name}", *words) for name, words in OPEN.items() if words]
    found += [plane(name, *words) for name, words in WEDGES.items()]
    found += [plane("narrow no wedge", *narrow(True, False)), plane("damping", *DAMPING)]
    found += [plane("long bridge", *LONG_BRIDGE),
              plane("long bridge embankment", *EMBANKMENT, *LONG_BRIDGE),
              plane("longer", *LONGER), space("longer", *LONGER)]
    found += [plane(f"open {name}", *OPEN[name]) for name in PLANE_OPEN]
    found += [space(f"finer {name}", *words) for name, words in CONVERGENCE.items() if words]
    found += [plane(f"mass {name} {m}", *EMBANKMENT, *words, mass(m))
              for name, words in EXPERIMENTS.items() for m in (1, 3)]
    found += [plane("wide", *EMBANKMENT, zones(f"{ON_GROUND},{WIDE}"))]
    found += [plane(f"near {m}", *EMBANKMENT, zones(behind(0, 20, f"sleeper={m}"))) for m in (2, 3)]
    found += [plane(f"spacing {s}", *EMBANKMENT, *spacing(s)) for s in (0.5, 0.75)]
    found += [plane(f"measure {name}", *words) for name, words in MEASURES.items()]
    return found


def measure(form, folder, numbers, lines):
    measure_runs(runs(form, 1), folder, numbers, lines)


def derive(numbers):
    """How much of a record is in other bins of the histogram, of two runs each."""
    for point in (NEAR, FAR):
        for title, (one, other) in COMPARED.items():
            numbers.put(title, f"record in other bins, {point}",
                        moved(numbers.lines, f"histogram, {point}", one, other), "%")
        numbers.put(UNLOADED, f"record in other bins, {point}",
                    moved(numbers.lines, f"histogram from the unloaded ground, {point}",
                          "plane_same_width_fill_1", "plane_same_width_fill_2"), "%")


def springs_of(run):
    """Name of the run with springs instead of the stones of this one."""
    return "plane_same_width" + ("_1" if "layers" in run.name else "_fill_1")


def beside(run):
    """Names of runs that are measured together with this one."""
    return (springs_of(run),) if run.deck == STONES else ()


def measure_runs(chosen, folder, numbers, lines):
    cases = {f"plane_{as_file(f'{name}_{m}')}" for name in GEOMETRIES for m in MASSES}
    alone = {f"plane_{as_file(f'same_width_fill_{m}')}": m for m in MASSES}
    for run in chosen:
        if run.deck == STONES:
            measure_stones(run.name, springs_of(run), folder, numbers, lines)
        elif run.deck in (SPACE, PLANE):
            figures = {figure for figure, names in (("envelope", DRAWN), ("histogram", cases),
                                                    ("history", OVER_TIME)) if run.name in names}
            measure_ground(run.name, folder / run.name, numbers, lines, figures,
                           alone.get(run.name))
        numbers.put(run.name, "wall_time", float(summary(folder / run.name, "wall_time_s")), "s")


ABOUT = 0.15  # relative, of values that the report gives as "about" and shows as curves
CALM = 0.02  # relative change of a displacement that counts as none
OPEN_SECTION = "What the report leaves open"
LAYERS_SECTION = "Effect of the reinforced layers"
MASS_SECTION = "Why the mass does not change the displacement"
MEASURED = {"rail": 0.8, "rail to sleeper": 0.2, "sleeper": 0.6}  # mm, 41 m from the bridge
THEIR_GROUND = 0.55  # mm, of the report's plane model
SHOWN = {"space_layers": "in space", "plane_same_width_1": "plane ground"}


def targets(n):
    return [*displacement_targets(n), *layer_targets(n), *mass_targets(n)]


def displacement_targets(n):
    """41 m from the bridge; the report's "ground" is rail less rail to sleeper: the sleeper."""
    def target(what, published, run, quantity, value, kind="main", sign=None):
        return Target(f"{what}, 41 m, {SHOWN[run]}", kind, published, n(run, f"{quantity}, {FAR}"),
                      "mm", value, ABOUT, sign=sign, see=OPEN_SECTION)
    found = [target("rail", "about 0.8 mm", run, "rail", MEASURED["rail"], sign=True)
             for run in SHOWN]
    found += [target("rail relative to sleeper (input: pads were chosen from it)", "about 0.2 mm",
                     run, "rail to sleeper", MEASURED["rail to sleeper"]) for run in SHOWN]
    found += [target("sleeper, against the measured \"ground\"", "about 0.8 less 0.2 mm", run,
                     "sleeper", MEASURED["sleeper"]) for run in SHOWN]
    found += [target("sleeper, against \"ground\" of the report's plane model", "about 0.55 mm",
                     "plane_same_width_1", "sleeper", THEIR_GROUND)]
    found += [target("surface of the ground below the ballast, against the measured \"ground\"",
                     "about 0.6 mm", "space_layers", "ground", MEASURED["sleeper"], "soft"),
              target("surface of the ground below the ballast, against the report's plane model",
                     "about 0.55 mm", "plane_same_width_1", "ground", THEIR_GROUND, "soft")]
    near, far = (n("plane_same_width_1", f"ground, {point}") for point in (NEAR, FAR))
    found += [Target("surface of the ground, 14.7 m (UGM) over 41 m (embankment), plane ground",
                     "main", "less than 1", near / far, "", holds=near < far, sign=near < far)]
    return found


def layer_targets(n):
    """Both readings of the track without reinforced layers; "as reported": the same geometry, whose
    width decreases towards the bridge, of embankment fill in all layers."""
    parts, alone = "only CBM and UGM differ, rail at", "all layers of fill, rail at"
    compared = [(f"{parts} 14.7 m, in space", "space_no_wedge", "space_layers"),
                (f"{parts} 14.7 m, plane 13 m wide", "plane_no_wedge", "plane_same_width_1"),
                (f"{parts} 14.7 m, plane narrow at the bridge", "plane_narrow_no_wedge",
                 "plane_original_1"),
                (f"{alone} 14.7 m, in space", "space_embankment", "space_layers"),
                (f"{alone} 14.7 m, plane 13 m wide", "plane_same_width_fill_1",
                 "plane_same_width_1"),
                (f"as reported: {alone} 14.7 m, plane narrow at the bridge",
                 "plane_narrow_fill_1", "plane_original_1")]
    found = []
    for what, run, other in compared:
        if n.has(run) and n.has(other):
            effect = change(n, run, other, f"rail, {NEAR}")
            found.append(Target(f"reinforced layers, {what}", "main", "about -20 %", 100 * effect,
                                "%", -20, ABOUT, sign=effect < 0, see=LAYERS_SECTION))
    each = tuple(100 * change(n, of_packing("stones_embankment", seed), of_packing(
        "stones_layers", seed), f"rail, {NEAR}") for seed in SEEDS
                 if n.has(of_packing("stones_embankment", seed)))
    if each:
        found.append(Target(f"reinforced layers, {alone} 14.7 m, plane 13 m wide, on stones",
                            "main", "about -20 %", float(np.mean(each)), "%", -20, ABOUT,
                            sign=max(each) < 0, each=each, see=LAYERS_SECTION))
    for what, run, other in (compared[0], compared[-1]):
        near, far = (change(n, run, other, f"rail, {point}") for point in (NEAR, FAR))
        smaller = abs(far) < abs(near)
        found.append(Target(f"reinforced layers, {what.replace('14.7 m', '41 m')}", "main",
                            "smaller than at 14.7 m", 100 * far, "%", holds=smaller, sign=smaller))
    return found


def mass_targets(n):
    """The opposite sign is required of no form on embankment: it contradicts statics, see the
    experiments."""
    found = []
    for what, one, others in (
            ("0.5, 2 and 3 x mass over reinforced layers, plane narrow at the bridge",
             "plane_original_1", [f"plane_original_{as_file(str(m))}" for m in (0.5, 2, 3)]),
            ("0.5 and 2 x mass over reinforced layers, plane 13 m wide",
             "plane_same_width_1", [f"plane_same_width_{as_file(str(m))}" for m in (0.5, 2)]),
            ("3 x mass over reinforced layers, in space", "space_layers", ["space_layers_3"])):
        most = max((change(n, one, other, f"rail, {point}") for other in others
                    for point in (NEAR, FAR)), key=abs)
        found.append(Target(f"rail at both points, largest change by {what}", "main", "none",
                            100 * most, "%", holds=abs(most) < CALM, sign=abs(most) < CALM))
    for m, published in ((2, -20), (0.5, 20)):
        for name, title in (("same_width_fill", "plane 13 m wide"),
                            ("narrow_fill", "plane narrow at the bridge")):
            value = change(n, f"plane_{name}_1", f"plane_{name}_{as_file(str(m))}",
                           f"rail, {NEAR}")
            found.append(Target(f"{m} x mass on embankment alone, rail at 14.7 m, {title}", "main",
                                f"about {published:+d} %", 100 * value, "%", published, ABOUT,
                                see=MASS_SECTION))
    return found
