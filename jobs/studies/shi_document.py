"""Document and figures of the study shi, from its numbers and lines alone."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from .shi import (AXLE_AT, BOUNDARIES, CONVERGENCE, DECAY, DECK, DESIGNS, EDGE,  # noqa: E402
                  FIXED, FULL_FRICTION, KEPT, LOAD, LOADED, MANY_TRAINS, MAPPED, MEAN_STRESS, OPEN,
                  PACKINGS, PUBLISHED_STONES, S1, S2, SAMPLED, SHOWN_TRAINS, SPACING,
                  SPECTRAL_LINES, SPEEDS,
                  TITLES, TRAINED, WEDGES, WHEEL, cases, change, jump, jump_of_means,
                  load_of_seats, mean, reduction, values)
from .study import COLOURS, as_file, heading, percent, save, table  # noqa: E402

TITLE = "shi: a locomotive from a rigid structure to an embankment"
SOURCE = """After *Macro-meso dynamic analysis of railway transition zone: hybrid DEM/FDM simulation
and experimental validation*: a plane bed of stones with 27 sleepers on a rigid structure and an
embankment, under the rail-seat loads of a locomotive at 67.2 km/h, with and without a wedge of
stiffer backfill behind the structure."""
CRITERION = """Values published with two digits or more count as reproduced within 15 %, those with
one digit within 25 %, frequencies within 3 %; "gradual" means more than twice the distance without
wedge. Of stones, the table gives the mean and the range over all packings; accelerations and
spectra are those of packings in which all sleepers keep their support."""
STYLES = {"none": {"color": COLOURS[1]}, "wedge": {"color": COLOURS[0]}}
LOADING, TRAINS = (next(stage for stage in DECK["stage"] if stage["name"] == name)
                   for name in ("bed_in", "trains"))
FRICTION = DECK["contact"][0]["friction"]
REFERENCE = "reference: fixed base, rollers at the sides, 1.3 m thick"
THIN = "ground 1 m thick, viscous sides"
NAMES = {  # in tables
    FIXED: REFERENCE,
    "ground 1 m thick instead of 1.3 m": "out-of-plane thickness of the ground 1 m instead of 1.3",
    THIN: "out-of-plane thickness of the ground 1 m, viscous sides",
    "loads of a power of the distance": "seat loads X^((s/0.6 m)^2) of each axle, X = 0.5531",
    "without a bottom, 10 m long at the top": "triangle, 10 m long at the top, none at the bottom",
    "upside down, 13 m long at the bottom": "3 m long at the top, 13 m at the bottom",
    "surface layer alone, 13 m": "none, but a surface layer of 4000 MPa 13 m long",
}


def document(n):
    text = [part_setup(n), part_packings(n), part_stresses(n)]
    if full(n):
        text += [part_displacements(n), part_boundaries(n), part_sleepers(n), part_preparation(n),
                 part_speeds(n), part_wedges(n), part_vehicle(n), part_convergence(n)]
    return "".join(text) + part_missing()


def full(n):
    return n.has("stones_none_1")


def summary(n):
    if not full(n):
        return ""

    def of(design, quantity):
        return f"{mean(n, design, quantity):.3g}"
    middle = (mean(n, "wedge", "ground, 6 to 11 m") / mean(n, "none", "ground, 6 to 11 m") - 1)
    thin = {design: n(f"ground_{design}_{as_file(THIN)}", "ground, far") for design in DESIGNS}
    plain = n(f"ground_none_{as_file(THIN)}", "ground, 6 to 11 m")
    nodes, means = at_edge(n, "nodes", jump), at_edge(n, "means", jump_of_means)
    sampled = min(n(f"ground_{design}_{as_file(SAMPLED)}", "acceleration, least")
                  for design in DESIGNS)
    return f"""
- As published: the surface of the structure, the short rise behind it without wedge, a gradual rise
  with wedge, and soil that moves away from the structure. With wedge, whose outline is assumed, the
  displacement 6 to 11 m behind the edge changes by {percent(middle)}, and its steepest change along
  the track falls from {of("none", "ground, steepest")} mm/m (at x =
  {of("none", "ground, x of the steepest")} m) to {of("wedge", "ground, steepest")} (at
  {of("wedge", "ground, x of the steepest")} m, just beyond the end of the wedge at 15 m, where the
  end of the ground adds to it).
- Not as published: the embankment goes down by {of("none", "ground, 6 to 11 m")} mm (at 6 to 11 m)
  instead of 1.8. A ground alone of 1 m instead of 1.3 m thickness with viscous sides has
  {plain:.2f} mm there. Only its last 2 m reach the published values, {thin["none"]:.2f} mm without
  and {thin["wedge"]:.2f} with wedge (published 1.8 and 1.64), where the end of the ground increases
  them. The difference is not explained.
- Not as published: stresses at the edge. Those of single nodes depend on where stones lie; their
  difference at the edge, {nodes[0]:.0f} kPa, is {"" if nodes[3] else "not significantly "}larger
  than elsewhere ({nodes[1]:.0f} +- {nodes[2]:.0f}), and the wedge changes it by
  {percent(reduction(n, jump))} instead of -54 %. The difference of means over a sleeper spacing is
  {means[0]:.0f} kPa, elsewhere {means[1]:.0f} +- {means[2]:.0f}.
- Not as published: the smallest of the sleepers' largest accelerations is
  {of("none", "acceleration, least")} g instead of 0.62. The largest are
  {of("none", "acceleration, most")} g without (1.34) and {of("wedge", "acceleration, most")} g with
  wedge (1.57), of single sleepers; medians are {of("none", "acceleration, median")} and
  {of("wedge", "acceleration, median")} g. Loads sampled 100 times per second, with kinks between
  the samples, raise the smallest to {sampled:.2f} g on springs, but not on stones.
- {support_of_sleepers(n)}
"""


def support_of_sleepers(n):
    """Whether they keep it in the passages, in a sentence."""
    deepest = max(values(n, "wedge", "kept, most") + values(n, "none", "kept, most"))
    lost = sum(sum(value > 0 for value in values(n, design, "kept, sleepers above 1 mm"))
               for design in DESIGNS)
    passages = 2 * len(PACKINGS)
    if lost:
        return f"""In {lost} of {passages} passages a sleeper lost its support (residual settlement
  up to {deepest:.1f} mm); accelerations leave them out."""
    rough = max(n(f"stones_{design}_{as_file(FULL_FRICTION)}", "kept, most") for design in DESIGNS)
    return f"""The bed is stable, as the study's: in {passages} passages no sleeper goes down for
  good by more than {deepest:.2g} mm. Loads on all sleepers prepared it with a friction of
  contacts of
  {LOADING["friction"]:g}; with the full {FRICTION:g} one sleeper of packing 1 goes down by
  {rough:.2g} mm in the same passage."""


def part_setup(n):
    short = "" if full(n) else """
This short form has the transition of `inputs/shi/short.toml`: 6 m, nine sleepers, one bogie, a
wedge of 2.2 m and coarser stones. Compare signs and orders only. What follows describes the full
form.
"""
    alone = """
Comparisons of grounds, speeds and boundaries have the ground alone (`inputs/shi/ground.toml`, 170 x
56 elements): the same loads on springs of 95 MN/m instead of ballast, spread evenly below each
sleeper.
""" if full(n) else ""
    density, bulk = DECK["material"][0]["density"], mean(n, "wedge", "bulk density")
    return heading("Set-up") + f"""{short}
The bed and its ground are those of `inputs/shi/transition.toml`: x = 0 is the end of the model on
the structure, x = {EDGE:g} m the edge where the embankment begins. Given by the study: 17 m with 27
sleepers every 0.6 m, 0.35 m of ballast below them, all layers, moduli, Poisson's ratios and
densities (Table 2), plane stress in 300 x 100 elements, stiffness, friction, damping and radii of
disks and a thickness of 1.3 m (Table 1), a compaction by 200 kPa and by trains until the bed is
stable, seat loads that pass from sleeper to sleeper at 67.2 km/h, axles and bogies 2.8 and 9.0 m
apart.

Assumed, as the study shows it only in drawings, which are not available here, or not at all:

- the outline of the wedge: 5 m high, 3 m long at the bottom, one vertical to two horizontal, so 13
  m at the top. All results with wedge depend on it, see "Other wedges";
- the course of the seat loads: that of a beam on a Winkler foundation with the published ratio of
  seat to wheel load, 71.1 kN from each axle. As the rail lifts beside an axle, all four together
  load a seat by at most {1e-3 * load_of_seats():.1f} kN;
- shapes of stones and grading; sleepers are boxes that only move vertically;
- a Rayleigh damping of the ground of 4 % at 16 Hz; a fixed base and rollers at the sides instead of
  the study's dashpots and free-field sides, see "Boundaries";
- the preparation: stones are poured without friction, which gives a dense bed, then
  {LOADING["cycles"]} loads of {1e-3 * LOADING["load"]:.0f} kN act on all sleepers at once while the
  friction of contacts is {LOADING["friction"]:g} instead of {FRICTION:g}, so that the bed settles
  as under many more loads (see "Preparation"). Then at most {TRAINS["cycles"]} trains pass, until
  one moves no sleeper down for good by more than {1e3 * TRAINS["settlement"]:g} mm; the last one
  does by {span(n, "wedge", "settlement in the last train of the preparation", 2)} mm. Then there
  are {span(n, "wedge", "ballast below sleepers, median")} mm of ballast below sleepers (median),
  at least {min(values(n, "wedge", "ballast below sleepers, least")):.0f} mm.
  Stresses and displacements count from the begin of the measured passage, with
  {1e-3 * TRAINS["seat_force"]:.0f} kN on each seat.

The study's bulk density of about 1800 kg/m3 with stones of 2600 means 69 % of solids, our plane bed
has {100 * bulk / density:.0f} %: either its packing is looser, or its density is that of a bed in
space. Here the density of the
stones is reduced to {density} kg/m3, which gives {bulk:.0f}: the same mass, not the same porosity.
{alone}"""


def span(n, design, quantity, digits=3):
    """Mean, least and most of all packings."""
    found = values(n, design, quantity)
    if not found:
        return "none"
    text = f"{np.mean(found):.{digits}g}"
    if len(found) == 1:
        return text
    return f"{text} ({min(found):.{digits}g} to {max(found):.{digits}g})"


ROWS = (("surface of the structure, mm", "ground, structure"),
        ("surface 6 to 11 m behind the edge, mm", "ground, 6 to 11 m"),
        ("surface in the last 2 m, mm", "ground, far"),
        ("distance behind the edge with 90 % of the displacement of plain track, m",
         "ground, 90 % of the rise"),
        ("sleepers on the structure, mean, mm", "sleeper, structure"),
        ("sleepers beyond the edge, median, mm", "sleeper, median beyond"),
        ("sleeper that moves most, mm", "sleeper, most"),
        ("largest residual settlement of a sleeper, mm", "kept, most"),
        ("median residual settlement, mm", "kept, median"),
        (f"sleepers with a residual settlement above {KEPT:g} mm", "kept, sleepers above 1 mm"),
        ("ballast 0.15 m below sleepers on the structure, mean, mm", "ballast, structure"),
        ("ballast 0.15 m below sleepers beyond the edge, median, mm", "ballast, median beyond"),
        ("smallest of the sleepers' largest accelerations, g", "acceleration, least"),
        ("median of them, g", "acceleration, median"),
        ("largest of them, g", "acceleration, most"),
        ("median of the largest accelerations of the ballast below each sleeper, g",
         "ballast acceleration, median"),
        ("mean difference of these between neighbours over their mean",
         "ballast acceleration, fluctuation"),
        ("motion of the soil up to 2 m behind the structure, away from it, mm",
         "soil away from the structure, largest"),
        ("motion of this soil towards the structure, mm",
         "soil towards the structure, largest"))


def part_packings(n):
    rows = [(title, *(span(n, design, quantity) for design in DESIGNS))
            for title, quantity in ROWS if any(values(n, design, quantity) for design in DESIGNS)]
    count = len(cases(n, "none"))
    what = f"{count} packings: mean (least to most)" if count > 1 else "one packing"
    calm = {design: len(values(n, design, "acceleration, median")) for design in DESIGNS}
    excluded = "" if min(calm.values()) == count else f""" A sleeper with a residual settlement
above {KEPT:g} mm has lost its support, which shakes its neighbours: such packings are excluded from
accelerations, so that {calm["none"]} remain without and {calm["wedge"]} with wedge."""
    return heading("With stones") + f"""
Largest values in the passage of the locomotive, {what}. Displacements are downwards. Accelerations
follow from velocities after a low pass of 100 Hz, as in the study.{excluded} Plain track is the
median of the surface at 6 to 11 m without wedge, for both. The distance to 90 % of its displacement
is that of a smooth curve through the surface, 1 - exp(-(s/l)^p) with l and p of
least squares and the distance s from the edge.

{table(["", *TITLES.values()], rows)}"""


QUANTITIES = ("ground, structure", "ground, 6 to 11 m", "ground, far", "ground, 90 % of the rise")


def cell(n, run, quantity):
    return f"{n(run, quantity):.3g}" if (run, quantity) in n.rows else "lost support" \
        if "acceleration" in quantity else ""


def ground_rows(n, names):
    """A row per title and name of a variant of the ground alone."""
    return [(title, *(cell(n, f"ground_{design}_{as_file(name)}", quantity)
                      for design in DESIGNS for quantity in QUANTITIES))
            for title, name in names]


def same(names):
    return [(NAMES.get(name, name), name) for name in names]


def ground_table(first, rows):
    return table([first, *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                           ("structure, mm", "6 to 11 m, mm", "last 2 m, mm", "90 %, m"))], rows)


def stones_rows(n, variants):
    """Packing 1 as it is, and with changes."""
    return [(title, *(cell(n, f"stones_{design}_{as_file(name)}", quantity) for design in DESIGNS
                      for quantity in QUANTITIES))
            for title, name in (("reference, packing 1", "1"), *variants)]


def part_displacements(n):
    thin = {design: [cell(n, f"ground_{design}_{as_file(THIN)}", quantity)
                     for quantity in QUANTITIES] for design in DESIGNS}
    return heading("Displacement of the surface") + f"""
![Largest displacement of the surface of the ground along the track](surface.png)

At 6 to 11 m stones change the displacement of the surface by less than 10 %; on the structure it is
larger and in the last 2 m smaller with them. Ground alone, with experiments on what the study
leaves open:

{ground_table("", ground_rows(n, same((FIXED, *OPEN))))}
The study gives the stones a thickness of 1.3 m; whether its ground has it, too, it does not state.
With 1 m, the usual thickness of a plane ground, and viscous sides the ground alone has
{thin["none"][0]} mm on the structure, {thin["none"][1]} mm at 6 to 11 m and {thin["none"][2]} mm in
the last 2 m without wedge, and {thin["wedge"][2]} mm in the last
2 m with it. The published 0.02, 1.8 and 1.64 mm may be the largest along the track. The last 2 m go
down farther because the ground ends there: one 8 m longer does not do it (see "Convergence"). With
stones:

{ground_table("", stones_rows(n, (("the same, ground 1 m thick, viscous sides", "thin"),)))}"""


def part_stresses(n):
    rows = [(f"packing {k + 1}, {TITLES[design]}",
             *(f"{n(run, f'stress, {what} the edge'):.0f}"
               for what in ("most before", "least behind")), f"{jump(n, run):.0f}",
             beyond(n, run, "nodes"), f"{jump_of_means(n, run):.0f}", beyond(n, run, "means"))
            for design in DESIGNS for k, run in enumerate(cases(n, design))]
    head = ["kPa", "largest before", "least behind", "difference", "the same beyond the edge",
            "difference of means", "the same beyond the edge"]
    sentences = [verdict_at_edge(n, *of) for of in (("nodes", jump), ("means", jump_of_means))]
    return heading("Stress at the edge") + f"""
![Largest vertical stress of the surface along the track](stress.png)

A stone loads one or two nodes of the surface, 57 mm apart, so that stresses of single nodes depend
on where stones lie. The published 165 and 27 kPa are read as the largest stress of a node in the
sleeper spacing before the edge and the least one in the spacing behind it. "Means" are those over
the nodes of a spacing. Values beyond the edge are the same differences between spacings that lie
in the same way between other sleepers: mean +- standard deviation along the track.

{table(head, rows)}
{" ".join(sentences)} The wedge changes the difference of nodes by
{percent(reduction(n, jump))} (published -54 %) and that of means by
{percent(reduction(n, jump_of_means))}. By equilibrium the mean stress over the spacing of a sleeper
is about {MEAN_STRESS:.0f} kPa, if its largest load acts on it alone.
"""


def beyond(n, run, what):
    return (f"{n(run, f'difference of {what} beyond, mean'):.0f} +- "
            f"{n(run, f'difference of {what} beyond, standard deviation'):.0f}")


def at_edge(n, what, of):
    """kPa, of the mean over packings without wedge: difference at the edge, beyond it, standard
    deviation of the latter for as many packings; whether the edge is different."""
    found = [of(n, run) for run in cases(n, "none")]
    usual, spread = (mean(n, "none", f"difference of {what} beyond, {each}")
                     for each in ("mean", "standard deviation"))
    spread /= len(found)**0.5
    return np.mean(found), usual, spread, abs(np.mean(found) - usual) > 2 * spread


def verdict_at_edge(n, what, of):
    here, usual, spread, clear = at_edge(n, what, of)
    return (f"Without wedge the difference of {what} at the edge is {here:.0f} kPa, beyond it "
            f"{usual:.0f} +- {spread:.0f} kPa (for the mean of as many packings): the edge " +
            ("stands out." if clear else "cannot be distinguished from other places."))


def part_boundaries(n):
    free = f"ground_none_{as_file(list(BOUNDARIES)[-1])}"
    return heading("Boundaries") + f"""
The study has a base of dashpots and free-field sides. A ground on dashpots alone sinks as long as
the train loads it, here by up to {n(free, "ground, structure"):.2g} mm on the structure and
{n(free, "ground, most"):.2g} mm at the end of the ground. With springs beside the dashpots the
structure moves by far more than the published 0.02 mm, with a base that is held it does not. Ground
alone:

{ground_table("", ground_rows(n, same(BOUNDARIES)))}
Without a motion of the base, the columns beside a free-field side are at rest, so that it acts like
a viscous one. With stones:

{ground_table("", stones_rows(n, (("the same, viscous base on springs of 1e8 Pa/m, viscous sides",
                                   "viscous"),)))}"""


def part_sleepers(n):
    quantities = ("sleeper, structure", "sleeper, median beyond", "sleeper, most", "kept, most",
                  "acceleration, median")
    rows = [(title, *(cell(n, f"stones_{design}_{name}", quantity) for design in DESIGNS
                      for quantity in quantities))
            for title, name in (("vertical motion only", "1"), ("rotation, too", "pitch"))]
    head = ["packing 1", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                           ("structure, mm", "beyond, mm", "most, mm", "residual, mm",
                            "acceleration, g"))]
    sampled = [(title, *(cell(n, f"ground_{design}_{as_file(name)}", f"acceleration, {what}")
                         for design in DESIGNS for what in ("least", "median", "most")))
               for title, name in (("ground alone on springs, as computed", FIXED),
                                   ("the same, 100 values per second, linear between them",
                                    SAMPLED))]
    sampled += [(title, *(cell(n, f"stones_{design}_{as_file(name)}", f"acceleration, {what}")
                          for design in DESIGNS for what in ("least", "median", "most")))
                for title, name in (("stones, packing 1, as computed", "1"),
                                    ("the same, 100 values per second", SAMPLED))]
    moving = [(f"first axle at {at} m", *(cell(n, f"maps_{design}", f"{what}, axle at {at} m")
                                          for design in DESIGNS for what in
                                          ("largest velocity of cells of stones",
                                           "x of the largest velocity, stones",
                                           "largest velocity of cells of ground",
                                           "x of the largest velocity, ground",
                                           "largest acceleration of cells of stones",
                                           "largest acceleration of cells of ground")))
              for at in AXLE_AT]
    peaks = [(f"near v/({SPECTRAL_LINES[mark][0]})",
              *(span(n, design, f"{mark}, {what}") for design in DESIGNS
                for what in ("seat force", "acceleration", "ballast acceleration")))
             for mark in SPECTRAL_LINES]
    least = [(TITLES[design], n(run, "acceleration, least")) for design in DESIGNS
             for run in [f"stones_{design}_{as_file(SAMPLED)}"]
             if (run, "acceleration, least") in n.rows]
    kinks = "With stones the smallest one remains far below the published ones: " + " and ".join(
        f"{value:.2g} g {title}" for title, value in least) + "." if least else ""
    lost = ("" if n("stones_wedge_1", "kept, most") <= KEPT else
            ", in which with wedge a sleeper loses its support")
    return heading("Sleepers and ballast") + f"""
![Displacement and acceleration of sleepers and of the ballast below them](sleepers.png)

![Histories of two sleepers, spectra of all](histories.png)

The study measures sleeper S1 on the transition and S2 on plain track; it does not state their x,
here {S1:g} and {S2:g} m. Spectra are the root mean square over all sleepers. The spectrum of the
load is that of the seat forces times the frequency squared: the acceleration of sleepers that
follow the load without delay. Axles and bogies pass with v/2.8 m =
{LOAD["speed"] / 2.8:.2f} Hz and v/9.0 m = {LOAD["speed"] / 9:.2f} Hz; the peaks of the load lie
beside these. A record of 1.8 s resolves 0.55 Hz;
peaks are read from a spectrum with zeros appended.

Peaks of these spectra (Hz), which the prescribed forces impose, so that they check no more than
that sleepers and stones follow them:

{table(["", *(f"{TITLES[design]}: {what}" for design in DESIGNS
             for what in ("load", "sleepers", "ballast"))], peaks)}
The study sees three sleepers ahead of an axle move down. Sleepers with more than a tenth of the
velocity of the fastest one are {span(n, "wedge", "sleepers moving down ahead")} with and
{span(n, "none", "sleepers moving down ahead")} without wedge. This only follows from the assumed
load, which begins 2 m ahead of an axle.

Sleepers that may rotate, without the restraint of a rail:

{table(head, rows)}
Do loads with kinks explain that our smallest accelerations are too low? The study's loads were
sampled 100 times per second. Largest accelerations after the low pass, g:

{table(["loads", *(f"{TITLES[design]}: {what}" for design in DESIGNS
                   for what in ("smallest", "median", "largest"))], sampled)}
{kinks}

![Velocity of ballast and ground when the first axle is at three places](maps_velocity.png)

![Acceleration of ballast and ground at the same instants](maps_acceleration.png)

The arrows are means in cells of 0.6 x 0.2 m (stones) and 1 x 0.8 m (ground) of packing 1{lost}.
Accelerations are those of an instant, without a low pass: contacts of loose stones at the surface
of the bed vibrate. Largest means of cells:

{table(["", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
              ("stones, mm/s", "at x, m", "ground, mm/s", "at x, m", "stones, g", "ground, g"))],
       moving)}"""


def part_preparation(n):
    """The bed after more trains, and after loads with full friction."""
    name = f"stones_wedge_{as_file(TRAINED)}"
    rows = [(train, *(cell(n, name, f"settlement, {which}, train {train}")
                      for which in ("most", "median"))) for train in SHOWN_TRAINS]
    quantities = ("sleeper, median beyond", "sleeper, most", "kept, most", "kept, median",
                  "acceleration, median")
    changed = [(title, *(cell(n, f"stones_{design}_{as_file(which)}", quantity)
                         for design in DESIGNS for quantity in quantities))
               for title, which in (("as above", "1"), (f"{MANY_TRAINS} trains", TRAINED),
                                    (FULL_FRICTION, FULL_FRICTION))]
    rough = f"stones_wedge_{as_file(FULL_FRICTION)}"
    last = "settlement in the last train of the preparation"
    return heading("Preparation") + f"""
Plane stones support a sleeper at few points, and such a support can fail under a train although it
carried others before. Loads with less friction let weak supports fail beforehand: a bed that
carries them with a friction of {LOADING["friction"]:g} has a reserve with {FRICTION:g}. After loads
with full friction one train after the other still moves sleepers of packing 1 down for good, the
last of at
most {TRAINS["cycles"]} by {n(rough, last):.2g} mm; after loads with less friction the last one
does by {n("stones_wedge_1", last):.2g} mm. With {MANY_TRAINS} trains in their place:

{table(["train", "largest settlement of a sleeper, mm", "median, mm"], rows)}
The passage after these preparations:

{table(["packing 1", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                       ("sleepers beyond, mm", "most, mm", "residual, most, mm",
                        "residual, median, mm", "acceleration, g"))], changed)}"""


def part_speeds(n):
    names = [(f"{SPEEDS[0]}", f"{SPEEDS[0]} km/h"), ("67.2", FIXED),
             *((f"{v}", f"{v} km/h") for v in SPEEDS[1:])]
    slow, fast = (f"ground_none_{as_file(f'{v} km/h')}" for v in (SPEEDS[0], SPEEDS[-1]))
    on_stones = [(title, *(cell(n, f"stones_{design}_{1 if name == FIXED else as_file(name)}", what)
                           for design in DESIGNS for what in
                           (*QUANTITIES[1:], "sleeper, median beyond", "acceleration, median")))
                 for title, name in names]
    return heading("Speed") + f"""
Ground alone, the same loads at other speeds:

{ground_table("km/h", ground_rows(n, names))}
With stones (packing 1):

{table(["km/h", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                  ("6 to 11 m, mm", "last 2 m, mm", "90 %, m", "sleepers beyond, mm",
                   "acceleration, median, g"))], on_stones)}
Ground alone, from {SPEEDS[0]} to {SPEEDS[-1]} km/h the displacement 6 to 11 m behind the edge
changes by {percent(change(n, slow, fast, "ground, 6 to 11 m"))} without wedge, with its largest
value in
between, and that of the last 2 m by {percent(change(n, slow, fast, "ground, far"))}. What uneven
rails and moving masses add is not part of prescribed loads.
"""


def part_wedges(n):
    cases_of = [("none", "none", FIXED), ("3 m at the bottom, 13 m at the top", "wedge", FIXED),
                *((title, "wedge", name) for title, name in same(WEDGES))]
    rows = [(title, *(cell(n, f"ground_{design}_{as_file(name)}", quantity)
                      for quantity in QUANTITIES)) for title, design, name in cases_of]
    quantities = (*QUANTITIES, "sleeper, median beyond")
    runs = [("none", "stones_none_1"), ("3 m at the bottom, 13 m at the top", "stones_wedge_1"),
            *((title, f"stones_wedge_{as_file(name)}") for title, name in same(WEDGES))]
    on_stones = [(title, *(cell(n, run, quantity) for quantity in quantities),
                  f"{jump_of_means(n, run):.0f}") for title, run in runs]
    return heading("Other wedges") + f"""
![Ground alone: wedges, boundaries, speeds](ground.png)

Ground alone; the surface layer of 4000 MPa ends where the wedge does at its top:

{table(["wedge", "structure, mm", "6 to 11 m, mm", "last 2 m, mm", "90 %, m"], rows)}
The same with stones (packing 1); forces on seats are prescribed, so that what a wedge changes is
the displacement and the stress at the edge (see "Stress at the edge"):

{table(["wedge", "structure, mm", "6 to 11 m, mm", "last 2 m, mm", "90 %, m",
        "sleepers beyond, mm", "difference of means at the edge, kPa"], on_stones)}"""


def part_vehicle(n):
    quantities = ("ballast force, structure", "ballast force, most", "ballast force, far",
                  "ground, far")
    runs = [(title, name) for title, name in (("prescribed seat loads", FIXED), (LOADED, LOADED))]
    rows = [(title, *(cell(n, f"ground_{design}_{as_file(name)}", quantity)
                      for design in DESIGNS for quantity in quantities)) for title, name in runs]
    head = ["", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                  ("structure, kN", "most, kN", "last 2 m, kN", "ground in the last 2 m, mm"))]
    ratios = [n(f"ground_none_{as_file(name)}", "ballast force, structure")
              / n(f"ground_none_{as_file(name)}", "ballast force, far") for _, name in runs]
    implied = 2e-3 * LOAD["peak"] / (DECAY * SPACING)
    on_stones = [(title, *(cell(n, f"stones_{design}_{as_file(name)}", quantity)
                           for design in DESIGNS for quantity in
                           ("seat force, structure", "seat force, most", "seat force, far",
                            "ground, far")))
                 for title, name in (("prescribed seat loads", "1"), (LOADED, LOADED))]
    rough = [n(f"stones_none_{as_file(name)}", "seat force, most")
             / n(f"stones_none_{as_file(name)}", "seat force, far") for name in ("1", LOADED)]
    return heading("A vehicle instead of prescribed loads") + f"""
A unit of 100 t with axles at the published distances (masses of body, bogies and wheelsets and
springs are chosen here) runs over a rail CHN60 on pads of 100 MN/m. Compare ratios only: its wheels
carry {1e-3 * WHEEL:.0f} kN at rest, the formula of the published seat load belongs to a wheel load
of {implied:.0f} kN. Largest force between sleepers and ground:

{table(head, rows)}
Without wedge, sleepers on the structure carry {ratios[1]:.2f} times the force of those in the last
2 m below the vehicle, and {ratios[0]:.2f} times below prescribed loads, which cannot respond to the
support. On stones (packing 1), largest force on a seat:

{table(head, on_stones)}
Stones do not support all sleepers alike, and the rail loads those most that lie firmly: the largest
force on a seat is {rough[1]:.2f} times the median of the last 2 m without wedge, and {rough[0]:.2f}
times with prescribed loads, which cannot show this.
"""


def part_convergence(n):
    quantities = ("ground, structure", "ground, 6 to 11 m", "stress, most before the edge",
                  "stress, least behind the edge", "sleeper, structure", "sleeper, median beyond",
                  "acceleration, median")
    rows = [(title, *(cell(n, f"stones_none_{as_file(name)}", quantity) for quantity in quantities))
            for title, name in (("5e8 N/m (Table 1)", "1"), ("2.5e8 N/m", "soft"),
                                ("1e9 N/m", "stiff"), ("5e8 N/m, half the step", "half the step"))]

    def halved(quantity):
        return change(n, "stones_none_1", f"stones_none_{as_file('half the step')}", quantity)
    return heading("Convergence") + f"""
Ground alone ("last 2 m": 13 to 15 m behind the edge):

{ground_table("", ground_rows(n, same((FIXED, *CONVERGENCE))))}
The stiffness of the contacts of stones changes sleepers by far more than the displacement of the
ground (packing 1 without wedge, changed after the bed was prepared). Half the step of stones and
coupling changes the displacement of the ground at 6 to 11 m by
{percent(halved("ground, 6 to 11 m"))}, that of sleepers beyond the edge by
{percent(halved("sleeper, median beyond"))} and the largest stress of a node before the edge by
{percent(halved("stress, most before the edge"))}.

{table(["", "structure, mm", "6 to 11 m, mm", "most before the edge, kPa", "least behind it, kPa",
        "sleepers on the structure, mm", "sleepers beyond, mm", "acceleration, g"], rows)}"""


def part_missing():
    return heading("Not repeated") + f"""
- Measured curves, which the study shows beside its own, and its deviations from them: they are
  figures.
- A packing with stones of {PUBLISHED_STONES} kg/m3 as loose as the study's; sleepers of disks.
- Not in the study, and not done: a part in three dimensions with angular stones.
"""


def band(panel, n, lines, figure, design, **style):
    """Mean of all packings, and the range between them."""
    runs = [lines.of(figure)[run] for run in cases(n, design) if run in lines.of(figure)]
    if not runs:
        return
    x = np.array(runs[0][0])
    y = np.array([np.interp(x, *run) for run in runs])
    if len(runs) > 1:
        panel.fill_between(x, y.min(axis=0), y.max(axis=0), alpha=0.25, lw=0, **STYLES[design])
    panel.plot(x, y.mean(axis=0), label=TITLES[design], **STYLES[design], **style)


def edge(panel):
    panel.axvspan(0, EDGE, color="0.9", lw=0)
    panel.grid(alpha=0.3)


def figures(n, lines, folder):
    draw_surface(n, lines, folder)
    draw_stress(n, lines, folder)
    draw_sleepers(n, lines, folder)
    draw_histories(n, lines, folder)
    if full(n):
        draw_ground(lines, folder)
        for what in MAPPED:
            draw_maps(lines, folder, what)


def draw_surface(n, lines, folder):
    figure, panel = plt.subplots(figsize=(9, 4.2), layout="constrained")
    for design in DESIGNS:
        band(panel, n, lines, "ground", design, lw=1.8)
        alone = lines.of("ground").get(f"ground_{design}_{as_file(FIXED)}")
        if alone:
            panel.plot(*alone, "--", lw=1.2, label=f"{TITLES[design]}, ground alone",
                       **STYLES[design])
    if full(n):
        for x, value, design in (((6, 17), 1.8, "none"), ((15, 17), 1.64, "wedge")):
            panel.plot(x, [value] * 2, ":", lw=2, label=f"published, {TITLES[design]}",
                       **STYLES[design])
    edge(panel)
    panel.invert_yaxis()
    panel.set(xlabel="x, m (grey: structure)",
              ylabel="largest displacement of the\nsurface, mm, down")
    panel.legend(fontsize=8, ncols=2)
    save(figure, folder / "surface.png")


def smooth(x, y, width=0.6):
    x = np.asarray(x)
    return np.array([np.mean(np.asarray(y)[np.abs(x - at) <= width / 2]) for at in x])


def draw_stress(n, lines, folder):
    figure, panels = plt.subplots(2, 1, figsize=(9, 6), sharex=True, layout="constrained")
    for panel, design in zip(panels, DESIGNS):
        runs = [lines.of("stress")[run] for run in cases(n, design)]
        for run in runs:
            panel.plot(*run, lw=0.6, alpha=0.6, color="0.5")
        x = runs[0][0]
        panel.plot(x, np.mean([smooth(*run) for run in runs], axis=0), lw=2, **STYLES[design],
                   label=f"{TITLES[design]}: mean over a sleeper spacing and all packings")
        panel.plot([], [], color="0.5", lw=0.6, label="nodes, each packing")
        edge(panel)
        panel.set_ylabel("largest vertical stress, kPa")
        panel.legend(fontsize=8, loc="upper right")
    if full(n):
        panels[0].plot([EDGE - 0.1, EDGE + 0.1], [165, 27], "o", color=COLOURS[3],
                       label="published")
        panels[0].legend(fontsize=8, loc="upper right")
    panels[-1].set_xlabel("x, m (grey: structure)")
    save(figure, folder / "stress.png")


def draw_sleepers(n, lines, folder):
    figure, panels = plt.subplots(4, 1, figsize=(9, 10), sharex=True, layout="constrained")
    for panel, (name, label) in zip(panels, (
            ("sleeper", "sleepers, mm down"), ("ballast", "ballast 0.15 m\nbelow them, mm down"),
            ("sleeper acceleration", "sleepers, g"),
            ("ballast acceleration", "ballast 0.15 m\nbelow them, g"))):
        for design in DESIGNS:
            band(panel, n, lines, name, design, lw=1.4, marker="o", ms=3)
        edge(panel)
        if not lines.of(name):  # all packings have lost a support
            continue
        found = np.concatenate([line[1] for line in lines.of(name).values()])
        limit = 2 * np.quantile(found, 0.95)
        if found.max() > limit:
            panel.set_ylim(0, limit)
            panel.text(0.01, 0.93, f"largest value, not shown: {found.max():.1f}", va="top",
                       fontsize=8, transform=panel.transAxes)
        panel.set_ylabel(label)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(fontsize=8)
    panels[-1].set_xlabel("x, m (grey: structure); bands: range over packings")
    save(figure, folder / "sleepers.png")


def draw_histories(n, lines, folder):
    figure, panels = plt.subplots(3 if full(n) else 1, 1, figsize=(9, 9 if full(n) else 3.5),
                                  layout="constrained", squeeze=False)
    panels = panels[:, 0]
    for panel, seat in zip(panels[:-1], (S1, S2)):
        for design in DESIGNS:
            panel.plot(*lines.of(f"history, {seat:g} m")[f"stones_{design}_1"], lw=1,
                       label=f"{TITLES[design]}, sleeper at {seat:g} m, packing 1",
                       **STYLES[design])
        panel.set(xlabel="time since the first axle was 3 m before the ground, s",
                  ylabel="mm, down")
        panel.invert_yaxis()
    spectra, load = lines.of("spectra"), None
    for design in DESIGNS:
        run = next((run for run in cases(n, design) if f"{run}, acceleration" in spectra), None)
        if run:
            panels[-1].plot(*spectra[f"{run}, acceleration"], lw=1.2, **STYLES[design],
                            label=f"acceleration, {TITLES[design]}, packing {run.split('_')[-1]}")
            if f"{run}, ballast acceleration" in spectra:
                panels[-1].plot(*spectra[f"{run}, ballast acceleration"], "-.", lw=1,
                                label=f"ballast, {TITLES[design]}", **STYLES[design])
            load = spectra[f"{run}, seat force"]
    if load:
        panels[-1].plot(*load, "k--", lw=0.8, label="load")
    panels[-1].set(xlabel="frequency, Hz", ylabel="amplitude over its largest")
    for panel in panels:
        panel.grid(alpha=0.3)
        if panel.lines:
            panel.legend(fontsize=8)
    save(figure, folder / "histories.png")


SHOWN_MAPS = {"velocity": 20, "acceleration": 0.3}  # mm/s and g, where arrows end


def draw_maps(lines, folder, what):
    figure, panels = plt.subplots(len(AXLE_AT), len(DESIGNS), figsize=(13, 9), sharex=True,
                                  sharey=True, layout="constrained")
    end, unit = SHOWN_MAPS[what], MAPPED[what][1]
    for row, at in zip(panels, AXLE_AT):
        found = lines.of(f"map {at} m")
        for panel, design in zip(row, DESIGNS):
            x, z = (np.concatenate(both) for both in zip(
                *(found[f"maps_{design}, {part} at"] for part in ("stones", "ground"))))
            along, up = (np.concatenate(both) for both in zip(
                *(found[f"maps_{design}, {part} {what}"] for part in ("stones", "ground"))))
            size = np.hypot(along, up)
            along, up = (of * np.minimum(1, end / np.maximum(size, 1e-9)) for of in (along, up))
            shown = panel.quiver(x, z, along, up, size, cmap="viridis", width=0.002,
                                 angles="xy", scale=12.5 * end, clim=(0, end))
            panel.plot([at], [0.7], "kv", ms=7)
            panel.axvspan(0, EDGE, color="0.9", lw=0, zorder=0)
            panel.set_title(f"{TITLES[design]}, first axle at {at} m", fontsize=9)
            if design == "none":
                panel.set_ylabel("z, m")
    for panel in panels[-1]:
        panel.set_xlabel("x, m (grey: structure)")
    figure.colorbar(shown, ax=panels, label=f"{what}, {unit} (arrows end at {end:g})", shrink=0.6,
                    extend="max")
    save(figure, folder / f"maps_{what}.png")


def draw_ground(lines, folder):
    figure, panels = plt.subplots(3, 1, figsize=(9, 9), sharex=True, layout="constrained")
    found = lines.of("ground")
    groups = (("wedge", (FIXED, *WEDGES)), ("none", (FIXED, *list(BOUNDARIES)[1:4])),
              ("none", tuple(f"{v} km/h" for v in SPEEDS)))
    for panel, (design, names) in zip(panels, groups):
        if design == "wedge":
            panel.plot(*found[f"ground_none_{as_file(FIXED)}"], color="k", lw=1, label="no wedge")
        for k, name in enumerate(names):
            title = {FIXED: "wedge of 13 m" if design == "wedge" else "fixed base"}.get(
                name, NAMES.get(name, name))
            panel.plot(*found[f"ground_{design}_{as_file(name)}"], lw=1.2, label=title,
                       color=(*COLOURS, "0.4", "#E69F00")[k % 6])
        edge(panel)
        panel.invert_yaxis()
        panel.set_ylabel("surface, mm, down")
        panel.legend(fontsize=7, ncols=2)
    panels[-1].set_xlabel("x, m (grey: structure); the two lower ones without wedge")
    save(figure, folder / "ground.png")
