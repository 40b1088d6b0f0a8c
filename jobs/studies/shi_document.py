"""Document of the study shi, from its numbers and lines alone. What it varies: shi_sections.py; its
figures: shi_figures.py."""
import numpy as np

from . import shi_figures, shi_space_document
from .shi_decks import DECK, DESIGNS, EDGE, SPACING, TITLES
from .shi_runs import (BOUNDARIES, FIXED, FULL_FRICTION, KEPT, ON_SPRINGS, OPEN, PACKINGS,
                       SAMPLED, SOIL_ON_SPRINGS)
from .shi_sections import SECTIONS, part_missing, unstable
from .shi_tables import (FRICTION, LOADING, NEAR_END, QUANTITIES, THIN, TRAINS, cell, ground_rows,
                         ground_table, of_all, same, stones_rows)
from .shi_targets import (MEAN_STRESS, UP_TO, at_four_metres, at_last_node, cases, full,
                          jump, jump_of_means, line, lines_of, load_of_seats, lost, mean,
                          place_of_most, reduction, steepest, targets, values)
from .study import as_file, between, change, heading, of_packings, percent, span, table

figures = shi_figures.figures
TITLE = "shi: a locomotive from a rigid structure to an embankment"
SOURCE = """After *Macro-meso dynamic analysis of railway transition zone: hybrid DEM/FDM simulation
and experimental validation*: a plane bed of stones with 27 sleepers on a rigid structure and an
embankment, under the rail-seat loads of a locomotive at 67.2 km/h, with and without a wedge of
stiffer backfill behind the structure."""
WIDE = 3  # factor between packings


def criterion(n):
    """When a target counts as reproduced."""
    wide = [max(each.each) / min(each.each) for each in targets(n)
            if not isinstance(each.reproduced(), bool)
            and max(each.each) > WIDE * min(each.each) > 0]
    chance = f""" Where packings differ by a factor of {between(wide)}, a
verdict of only some packings is chance.""" if len(wide) > 1 else ""
    return f"""Inputs check that the deck prescribes what the study does, and that the sleepers
follow it. Values published with two digits or more count as reproduced within 15 %, those with one
digit within 25 %, frequencies within 3 %; "gradual" means more than twice the distance without
wedge. Of stones, the table gives the mean and the range over all packings; accelerations and
spectra are those of packings in which all sleepers keep their support.{chance} The last column
names the section with experiments, or says that there is no explanation."""


CRITERION = criterion


def document(n):
    text = [part_setup(n), part_packings(n), part_stresses(n)]
    if full(n):
        text += [part_displacements(n), part_boundaries(n), *(part(n) for part in SECTIONS),
                 shi_space_document.part(n)]
    return "".join(text) + part_missing()


def summary(n):
    if not full(n):
        return ""
    return f"""
- {surface_in_short(n)}
- {embankment_in_short(n)}
- {stresses_in_short(n)}
- {accelerations_in_short(n)}
- {support_of_sleepers(n)}
"""


def slopes(n):
    """mm/m, steepest change of the surface before the end of the ground acts, in each packing."""
    return {design: [steepest(n, run, NEAR_END) for run in cases(n, design)]
            for design in DESIGNS}


def surface_in_short(n):
    def of(design, quantity):
        return f"{mean(n, design, quantity):.3g}"
    middle = mean(n, "wedge", "ground, 6 to 11 m") / mean(n, "none", "ground, 6 to 11 m") - 1
    none, wedge = map(np.mean, slopes(n).values())
    x, last = at_last_node(n, "none")
    longer = n("ground_wedge_ground_8_m_longer", "ground, steepest")
    return f"""As published: the surface of the structure up to x = {UP_TO:g} m (but at its last
node,
  x = {x:.2f} m, it deviates by {percent(np.mean(last) / 0.02 - 1)} without wedge), the short rise
  behind it without wedge, and soil that moves away from the structure. A gradual rise with wedge is
  as published, too, but follows from its assumed outline. Not stated by the study: with wedge the
  displacement 6 to 11 m behind the edge changes by {percent(middle)}. The steepest change of the
  surface up to x = {NEAR_END} m
  falls from {none:.3g} mm/m (at x = {of("none", "ground, x of the steepest")} m) to {wedge:.3g}, by
  {percent(wedge / none - 1)}. Behind it the end of the ground adds to the change:
  {of("wedge", "ground, steepest")} mm/m at x = {of("wedge", "ground, x of the steepest")} m with
  wedge, but at most {longer:.3g} in a ground 8 m longer."""


def embankment_in_short(n):
    thin, soil = (f"ground_none_{as_file(name)}" for name in (THIN, SOIL_ON_SPRINGS))
    here, longer = (n(f"ground_wedge_{as_file(name)}", "ground, far")
                    for name in (FIXED, "ground 8 m longer"))
    return f"""Not as published: the embankment goes down by
  {mean(n, "none", "ground, 6 to 11 m"):.3g} mm (at 6 to 11 m) instead of 1.8. A ground alone that
  is
  1 m thick and has viscous sides moves {n(thin, "ground, 6 to 11 m"):.2f} mm there; it has
  {n(thin, "ground, most"):.2f} mm only near the end of the model, which adds to it. On springs
  below
  the soil alone, which the study does not state, it moves {n(soil, "ground, 6 to 11 m"):.2f} mm.
  With wedge the published 1.64 mm is compared with the last 2 m; with 8 m more ground they move by
  {longer:.3g} mm instead of {here:.3g} (ground alone)."""


def stresses_in_short(n):
    nodes, means = at_edge(n, "nodes", jump), at_edge(n, "means", jump_of_means)
    return f"""Not as published: stresses at the edge. Largest stress of a node before the edge
  minus the least behind it: {nodes[0]:.0f} kPa (published 165 - 27 = 138); around other sleepers
  {nodes[1]:.0f} +- {nodes[2]:.0f}. {changed_by_wedge(n)} Averaged over a sleeper spacing the stress
  {"jumps" if means[3] else "does not jump"} at the edge ({means[0]:.0f} kPa, around other sleepers
  {means[1]:.0f} +- {means[2]:.0f})."""


def accelerations_in_short(n):
    def of(design, quantity):
        return f"{mean(n, design, f'acceleration, {quantity}'):.3g}"
    reference, soft, stiff = (n(f"stones_none_{name}", "acceleration, median")
                              for name in ("1", "soft", "stiff"))
    sampled = min(n(f"ground_{design}_{as_file(SAMPLED)}", "acceleration, least")
                  for design in DESIGNS)
    rough = n(f"stones_none_{as_file(FULL_FRICTION)}", "acceleration, most")
    long = ', but with too long sub-steps, see "Preparation"' if unstable(n) else ""
    return f"""Not as published: the largest acceleration of a sleeper is between
  {of("none", "least")} and {of("none", "most")} g without wedge (published 0.62 to 1.34) and
  between {of("wedge", "least")} and {of("wedge", "most")} with wedge (0.61 to 1.57), as means over
  packings. A bed prepared with full friction reaches {rough:.2f} g without wedge{long}.
  Accelerations depend on the stiffness of contacts, or on its change after the preparation: their
  median is
  {soft / reference:.1f} times as large with half the stiffness and {stiff / reference:.1f} times as
  large with twice the stiffness. Half the step changes the largest one by
  {percent(change(n, "stones_none_1", "stones_none_half_the_step", "acceleration, most"))} (packing
  1 without wedge). Loads sampled 100 times per second, with kinks between the samples, raise the
  smallest to {sampled:.2f} g on springs, but not on stones."""


def support_of_sleepers(n):
    """Whether they keep it in the passages, in sentences."""
    beds, passages = lost(n)
    turned = [TITLES[design] for design in DESIGNS
              if n(f"stones_{design}_pitch", "kept, most") > KEPT]
    text = f"""The aim of the preparation, at most {1e3 * TRAINS["settlement"]:g} mm in the last
  train, is met in {aim_met(n)} of {len(PACKINGS)} packings."""
    if beds:
        deepest = max(values(n, "wedge", "kept, most") + values(n, "none", "kept, most"))
        text += f""" In {passages} of {2 * len(PACKINGS)} passages a sleeper lost its support
  (residual settlement up to {deepest:.1f} mm); both designs share a bed, so this is
  {len(beds)} of {len(PACKINGS)} beds (packing {", ".join(map(str, beds))}). Accelerations leave
  it out: their largest value over all packings may be higher than given."""
    if turned:
        text += f""" Sleepers that may rotate lose their support {" and ".join(turned)} (packing
  1)."""
    return text


def aim_met(n):
    """In how many packings the last train of the preparation settles no sleeper by more than it
    should."""
    return sum(value <= 1e3 * TRAINS["settlement"]
               for value in values(n, "wedge", "settlement in the last train of the preparation"))


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
    space = (f' (ours, see "In space", has {n("space_wedge_1", "bulk density"):.0f})'
             if n.has("space_wedge_1") else "")
    mesh = DECK["ground"]["x"][1] / DECK["ground"]["elements_x"]
    last = mesh * np.floor(EDGE / mesh)
    density, bulk = DECK["material"][0]["density"], mean(n, "wedge", "bulk density")
    return heading("Set-up") + f"""{short}
The bed and its ground are those of `inputs/shi/transition.toml`: x = 0 is the end of the model on
the structure, x = {EDGE:g} m the edge where the embankment begins. Given by the study: 17 m with 27
sleepers every 0.6 m, 0.35 m of ballast below them, all layers, moduli, Poisson's ratios and
densities (Table 2), plane stress in 300 x 100 elements, stiffness, friction, damping and radii of
disks and a thickness of 1.3 m (Table 1), a compaction by 200 kPa, seat loads that pass from sleeper
to sleeper at 67.2 km/h, axles and bogies 2.8 and 9.0 m apart. The edge lies between two nodes of
the ground, which are {1e3 * mesh:.0f} mm apart: x = {last:.3f} and {last + mesh:.3f} m.

Of the wedge the study gives a height of 5 m, a length of 3 m at the bottom and a slope of 1:2.
Assumed, as the study shows it only in drawings, which are not available here, or not at all:

- the slope as one vertical to two horizontal, so that the wedge is 13 m long at the top. All
  results with wedge depend on it, see "Other wedges";
- the course of the seat loads: that of a beam on a Winkler foundation with the published ratio of
  seat to wheel load, 71.1 kN from each axle. The rail lifts beside each axle. This reduces the peak
  from 71.1 kN (one axle) to {1e-3 * load_of_seats():.1f} kN (four axles);
- shapes of stones and grading; sleepers are boxes that only move vertically;
- a Rayleigh damping of the ground of 4 % at 16 Hz; a fixed base and rollers at the sides instead of
  the study's dashpots and free-field sides, see "Boundaries";
- the preparation: stones are poured without friction, which gives a dense bed. Then
  {LOADING["cycles"]} loads of {1e-3 * LOADING["load"]:.0f} kN, larger than those of a train, act on
  all sleepers at once while the friction of contacts is {LOADING["friction"]:g} instead of
  {FRICTION:g} (see "Preparation"). The study loads its bed until it is stable. Here trains pass
  until one settles no sleeper by more than {1e3 * TRAINS["settlement"]:g} mm, at most
  {TRAINS["cycles"]}. This aim is met in {aim_met(n)} of {len(cases(n, "wedge"))} packings; the last
  train settles a sleeper by
  {of_all(n, "wedge", "settlement in the last train of the preparation", ".2g")} mm. Then there are
  {of_all(n, "wedge", "ballast below sleepers, median")} mm of ballast below sleepers (median), at
  least {min(values(n, "wedge", "ballast below sleepers, least")):.0f} mm. Stresses and
  displacements count from the begin of the measured passage, with
  {1e-3 * TRAINS["seat_force"]:.0f} kN on each seat.

The study's bulk density of about 1800 kg/m3 with stones of 2600 means 69 % of solids, our plane bed
has {100 * bulk / density:.0f} %: either its packing is looser, or its density is that of a bed in
space{space}. Here the density of the stones is reduced to {density} kg/m3, which gives
{bulk:.0f}: the same mass, not the same porosity.
{alone}"""


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
        ("mean difference between neighbouring sleepers, divided by the mean",
         "ballast acceleration, fluctuation"),
        ("motion of the soil up to 2 m behind the structure, away from it, mm",
         "soil away from the structure, largest"),
        ("motion of this soil towards the structure, mm",
         "soil towards the structure, largest"))


def rows_of_lines(n):
    """Rows that follow from the lines."""
    x, _ = at_last_node(n, "none")
    rows = [(f"surface of the structure at its last node, x = {x:.2f} m, mm",
             *(span(at_last_node(n, design)[1]) for design in DESIGNS)),
            ("surface 4 m behind the edge over its largest value",
             *(span(at_four_metres(n, design)) for design in DESIGNS))]
    if full(n):
        rows.append((f"steepest change of the surface up to x = {NEAR_END} m, mm/m",
                     *map(span, slopes(n).values())))
    if all(any(run in n.lines.of("ballast acceleration") for run in cases(n, design))
           for design in DESIGNS):
        rows.append(("mean difference of the ballast's largest accelerations between neighbouring "
                     "sleepers, g",
                     *(span(np.abs(np.diff(lines_of(n, "ballast acceleration", design)[1]))
                               .mean(axis=1)) for design in DESIGNS)))
    return rows


def part_packings(n):
    rows = [(title, *(of_all(n, design, quantity) for design in DESIGNS))
            for title, quantity in ROWS if any(values(n, design, quantity) for design in DESIGNS)]
    count = len(cases(n, "none"))
    calm = {design: len(values(n, design, "acceleration, median")) for design in DESIGNS}
    excluded = "" if min(calm.values()) == count else f""" A sleeper with a residual settlement
above {KEPT:g} mm counts as one that has lost its support. Such packings are excluded from
accelerations, so that {calm["none"]} remain without and {calm["wedge"]} with wedge."""
    return heading("With stones") + f"""
Largest values in the passage of the locomotive, {of_packings(count)}. Displacements are downwards.
Accelerations have passed a low pass of 100 Hz, as in the study. Those of stones and of sleepers on
them follow from the filtered velocity; the study filters the recorded acceleration, and so do we
for a ground alone.{excluded} Plain track is the median of the surface at 6 to 11 m without wedge,
for both. The distance to 90 % of the rise is that of the curve `u_s + (u_p - u_s)(1 -
exp(-(s/l)^p))` through the surface: u_s is the displacement of the structure, u_p that of plain
track, s the distance from the edge, and l and p are those of least squares.

{table(["", *TITLES.values()], rows + rows_of_lines(n))}"""


def part_displacements(n):
    thin = {design: [cell(n, f"ground_{design}_{as_file(THIN)}", quantity)
                     for quantity in QUANTITIES] for design in DESIGNS}
    alone = {design: n(f"ground_{design}_{as_file(FIXED)}", "ground, 6 to 11 m")
             for design in DESIGNS}
    stones = [percent(mean(n, design, "ground, 6 to 11 m") / alone[design] - 1)
              for design in DESIGNS]
    stones_thin = n("stones_none_thin", "ground, structure")
    longer = [n(f"ground_{design}_ground_8_m_longer", "ground, far") for design in DESIGNS]
    return heading("Displacement of the surface") + f"""
![Largest displacement of the surface of the ground along the track](surface.png)

{edge_of_structure(n)}

{shape_of_rise(n)}

At 6 to 11 m stones change the displacement of the surface by {stones[0]} without and {stones[1]}
with wedge; on the structure it is larger and in the last 2 m smaller with them. Ground alone, with
experiments on what the study leaves open:

{ground_table("", ground_rows(n, same((FIXED, *OPEN))))}
The study gives the stones a thickness of 1.3 m; whether its ground has it, too, it does not state.
With 1 m, the usual thickness of a plane ground, and viscous sides the ground alone has
{thin["none"][0]} mm on the structure, {thin["none"][1]} mm at 6 to 11 m and {thin["none"][2]} mm in
the last 2 m without wedge, and {thin["wedge"][2]} mm in the last 2 m with it. The published 0.02,
1.8 and 1.64 mm may be the largest along the track. In the last 2 m the end of the ground adds to
the displacement: without wedge, with 8 m more ground these 2 m move no more than the rest
({longer[0]:.3g} mm). With wedge they then move {longer[1]:.3g} mm (see "Convergence").

{ground_on_springs(n)} With stones, 1 m and viscous sides the structure moves by {stones_thin:.3g}
mm without wedge:

{ground_table("", stones_rows(n, (("the same, ground 1 m thick, viscous sides", "thin"),)))}"""


def ground_on_springs(n):
    """What gives the published values, in short."""
    def of(design, name, *quantities):
        return [n(f"ground_{design}_{as_file(name)}", quantity) for quantity in quantities]
    both = ("ground, structure", "ground, 6 to 11 m")
    everywhere, soil = (of("none", name, *both) for name in (ON_SPRINGS, SOIL_ON_SPRINGS))
    most = {name: [of(design, name, "ground, most")[0] for design in DESIGNS]
            for name in (THIN, SOIL_ON_SPRINGS)}
    end, = of("none", SOIL_ON_SPRINGS, "ground, far")
    middle, wedge_end = of("wedge", SOIL_ON_SPRINGS, "ground, 6 to 11 m", "ground, far")
    return f"""Published are 0.02 mm on the structure and, within 4 m behind it, an increase to 1.8
mm. With 1 m, viscous sides and springs of 1e8 Pa/m (a value chosen here) below everything, the
ground has {everywhere[0]:.2g} and {everywhere[1]:.3g} mm: the structure settles, too. With a soft
layer on a fixed base that acts like these springs below soil and wedge, but not below the
structure, it has {soil[0]:.2g} and {soil[1]:.3g} mm, but {end:.3g} mm in the last 2 m; with wedge
{middle:.3g} mm at 6 to 11 m and {wedge_end:.3g} mm in the last 2 m (published 1.64). If the
published values are the largest along the track, this foundation gives too much
({most[SOIL_ON_SPRINGS][0]:.3g} and {most[SOIL_ON_SPRINGS][1]:.3g} mm), whereas 1 m and viscous
sides
give {most[THIN][0]:.3g} and {most[THIN][1]:.3g} mm, though near the end of the ground and not
within
4 m. The study does not show which holds."""


def edge_of_structure(n):
    """The displacement there depends on where it is read."""
    (x, none), (_, wedge) = (at_last_node(n, design) for design in DESIGNS)
    return f"""The displacement of the structure is the largest up to x = {UP_TO:g} m, half a
sleeper spacing before its edge. At its last node, x = {x:.2f} m, it is {span(none)} mm without
and {span(wedge)} mm with wedge: {percent(np.mean(none) / 0.02 - 1)}
and {percent(np.mean(wedge) / 0.02 - 1)} from the published value."""


def shape_of_rise(n):
    none, wedge = (span(at_four_metres(n, design), ".2g") for design in DESIGNS)
    first, last = (of(place_of_most(n, "ground", "none")) for of in (np.min, np.max))
    slow = slopes(n)
    longer = n("ground_wedge_ground_8_m_longer", "ground, steepest")
    return f"""At 4 m behind the edge the surface has {none} of its largest value without wedge and
{wedge} with wedge; the largest value is near the end of the ground (without wedge at x =
{first:.1f} to {last:.1f} m). The gradual rise with wedge follows from its assumed outline. Up to x
= {NEAR_END} m the steepest change along the track is {span(slow["none"])} mm/m without and
{span(slow["wedge"])} mm/m with wedge, the latter at the end of this range; a ground
alone that is 8 m longer has {longer:.3g} mm/m. Behind it the end of the ground steepens the surface
to {of_all(n, "wedge", "ground, steepest")} mm/m at x =
{of_all(n, "wedge", "ground, x of the steepest")} m
(the search ends at {DECK["ground"]["x"][1] - 1.5:g} m)."""


def part_stresses(n):
    rows = [(f"packing {k + 1}, {TITLES[design]}",
             *(f"{n(run, f'stress, {what} the edge'):.0f}"
               for what in ("most before", "least behind")), f"{jump(n, run):.0f}",
             beyond(n, run, "nodes"), f"{jump_of_means(n, run):.0f}", beyond(n, run, "means"))
            for design in DESIGNS for k, run in enumerate(cases(n, design))]
    head = ["kPa", "largest before", "least behind", "difference", "the same beyond the edge",
            "difference of means", "the same beyond the edge"]
    sentences = [verdict_at_edge(n, what, of, design) for design in DESIGNS
                 for what, of in (("nodes", jump), ("means", jump_of_means))]
    x, stresses = lines_of(n, "stress", "none")
    mesh = np.diff(x).mean()
    with_edge = stresses[:, (x > EDGE - SPACING) & (x < EDGE + mesh / 2)].max(axis=1).mean()
    return heading("Stress at the edge") + f"""
![Largest vertical stress of the surface along the track](stress.png)

Nodes of the surface are {1e3 * mesh:.0f} mm apart, about as far as a stone is long, and their
stresses differ from packing to packing. The published 165 and 27 kPa are read as the largest stress
of a node in the sleeper spacing before the edge and the least one in the spacing behind it. The
node nearest to the edge carries both parts and belongs to neither side; with it the largest stress
before the edge would be {with_edge:.0f} instead of
{mean(n, "none", "stress, most before the edge"):.0f}
kPa (mean, without wedge). "Means"
are those over the nodes of a spacing. "Beyond the edge" is the same measure at the same position
relative to the sleepers behind the edge: mean +- standard deviation along the track.

{table(head, rows)}
In what follows +- is the standard deviation along the track divided by the square root of
{len(cases(n, "none"))}, the number of packings. {" ".join(sentences)} {changed_by_wedge(n)} By
equilibrium the mean stress over the spacing of a sleeper is about {MEAN_STRESS:.0f} kPa, if its
largest load acts on it alone. Why the published 165 and 27 kPa and -54 % differ is not explained.
"""


def changed_by_wedge(n):
    """The difference of nodes at the edge, in the same packings."""
    each = np.array([jump(n, wedge) - jump(n, none)
                     for none, wedge in zip(cases(n, "none"), cases(n, "wedge"))])
    share = f"{percent(reduction(n, jump))} of its mean instead of -54 %"
    if len(each) < 2:
        return f"The wedge changes it by {each[0]:.0f} kPa, {share}."
    error = each.std(ddof=1) / len(each)**0.5
    verdict = "different from" if abs(each.mean()) > 2 * error else "not distinguishable from"
    return (f"The wedge changes the difference of nodes by {each.mean():.0f} +- {error:.0f} kPa "
            f"(standard error over packings, in pairs), which is {verdict} zero: {share}.")


def beyond(n, run, what):
    return (f"{n(run, f'difference of {what} beyond, mean'):.0f} +- "
            f"{n(run, f'difference of {what} beyond, standard deviation'):.0f}")


def at_edge(n, what, of, design="none"):
    """kPa, of the mean over packings: difference at the edge, beyond it, standard
    deviation of the latter for as many packings; whether the edge is different."""
    found = [of(n, run) for run in cases(n, design)]
    usual, spread = (mean(n, design, f"difference of {what} beyond, {each}")
                     for each in ("mean", "standard deviation"))
    spread /= len(found)**0.5
    return np.mean(found), usual, spread, abs(np.mean(found) - usual) > 2 * spread


def verdict_at_edge(n, what, of, design):
    here, usual, spread, clear = at_edge(n, what, of, design)
    return (f"{TITLES[design].capitalize()} the difference of {what} at the edge is {here:.0f} "
            f"kPa, beyond it {usual:.0f} +- {spread:.0f} kPa: the edge " +
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
The base is not shaken, so a free-field side acts like a dashpot side. With stones:

{ground_table("", stones_rows(n, (("the same, viscous base on springs of 1e8 Pa/m, viscous sides",
                                   "viscous"),)))}"""
