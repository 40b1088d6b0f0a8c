"""Document of the study demfem, from its numbers and lines alone."""
import numpy as np

from .demfem_figures import NAMES, figures
from .demfem_model import (BAR, BARRED, BENCHMARK, CORES, CYCLES, GRANITE, GROUND_RUN, GROUNDS,
                           HEIGHT, LAST, PACKINGS, PARTS, PERIOD, RAIL, ROCKS, SETTLED, SHAPES,
                           STONES, TITLES, TRACKS, ground_run)
from .demfem_targets import TEN, error_of_difference, less, mean, of, predicted
from .study import heading, percent, table

__all__ = ("CRITERION", "SOURCE", "TITLE", "document", "figures", "summary")  # of the study

TITLE = "demfem: convex and non-convex stones below sleepers, and what they cost"
SOURCE = """The study *A DEM-FEM coupling framework applied to railroad infrastructure
simulations* has ten solid sleepers with rails on 3.3e5 rounded stones on a ground whose stiffness
rises along the track, under axles that pass. Here half of this track carries fewer, larger stones
for a shorter time. Three smaller models stand beside it: a slice with two sleepers, the ground
alone, and two solid sleepers for the cost."""
CRITERION = """The study gives its values as "around"; they count as reproduced within 15 %, the
difference of two of them within 30 %, less settlement if it is less by twice the standard error.
Ours of stones are means over all packings, largest forces the largest of all."""


def document(n):
    return "".join((part_setup(n), part_bed(n), part_track(n), part_ground(n), part_cost(n),
                    part_missing()))


def full(n):
    return n.has("cost_convex")


def summary(n):
    if not full(n):
        return ""
    stiff = f"stiffness, {LAST}"
    by = mean(n, "non_convex", stiff) - mean(n, "convex", stiff)
    settled, certain = less(n, SETTLED)
    slower = (n("cost_convex", "stone steps per second and core")
              / n("cost_non_convex", "stone steps per second and core"))
    coarse = n(ground_run("elements of 0.2 m"), "tension, largest")
    return f"""
- Non-convex stones make the bed stiffer by {by:.1f} +- {error_of_difference(n, stiff):.1f} MPa,
  that is, {mean(n, "non_convex", stiff) / mean(n, "convex", stiff):.2f} times as stiff (published
  1.26). Both beds are far softer than published: with these contacts, a bed of convex stones cannot
  be stiffer than {mean(n, "convex", "upper bound of the stiffness"):.0f} MPa. With contacts as
  stiff as bars of the same modulus it has {mean(n, "convex", stiff, "bars"):.0f} MPa (published
  430), with non-convex stones {mean(n, "non_convex", stiff, "bars"):.0f} (published 540).
- {settles(n)}
- After the first cycle, two sleepers settle by {settled:.2f}
  +- {error_of_difference(n, SETTLED):.2f} mm less on non-convex stones in {CYCLES["cycles"] - 1}
  cycles{"" if certain else ", which decides nothing"}. +- is the standard error over the packings,
  {len(PACKINGS)} of two sleepers, {len(of(n, "convex", "simulated", "track"))} of ten, where it is
  itself uncertain.
- The ground of rising stiffness has its largest tension where its stiffness rises most, as
  published: {n(GROUND_RUN, "tension, largest"):.2f} MPa (published 0.1), or {coarse:.2f} with
  elements as long as those of the study. It depends on the curve of the stiffness, which is assumed
  here.
- A non-convex stone takes {slower:.1f} times the time of a convex one (published 3.0).
"""


def settles(n):
    """How sleepers and rail of the ten sleepers differ."""
    texts = []
    for what, quantity in (
            ("the lowest of ten sleepers", "mean displacement of the lowest sleeper"),
            *((f"the rail at the {place}", f"rail, {place}, mean displacement")
              for place in RAIL)):
        by, certain = less(n, quantity, "track")
        error = error_of_difference(n, quantity, "track")
        texts.append(f"{what} by {by:.1f}" + (f" +- {error:.1f}" if error else "") + " mm"
                     + ("" if certain or not error else " (decides nothing)"))
    return (f"After {mean(n, 'convex', 'simulated', 'track'):.2f} s of wheels, displacements on "
            f"non-convex stones are smaller: {', '.join(texts)}. Published: 5 mm for sleepers and "
            "7 to 9 mm for the rail after 8 s.")


def part_setup(n):
    left_out = ("stones below 31.5 mm, 13 % of the mass of the middle of category A, are left out"
                if full(n) else "only stones of 45 to 63 mm, as this is the short form: compare "
                                "signs only")
    hollow = (n("shapes_non_convex", "volume over sieve cubed")
              / n("shapes_convex", "volume over sieve cubed") - 1)
    low, high = (mean(n, "convex", f"{what} stress") for what in ("least", "largest"))
    return heading("Set-up") + f"""
For their stiffness the shapes are compared on a slice of the track
(`inputs/demfem/sleeper.toml`): two rigid sleepers on {HEIGHT} m of ballast,
0.3 m of the length of the sleepers between smooth walls,
{n("bed_convex_1", "stones"):.0f} convex or {n("bed_non_convex_1", "stones"):.0f} non-convex stones,
on a rigid, rough floor. Given by the study: density, modulus of 1 GPa (its stones are fifty times
softer than granite to save time), Poisson's ratio, friction, restitution, axles of 250 kN 1.6 m
apart, one each 0.16 s, convex stones of 20 triangles, non-convex ones of three convex pieces with
20 triangles each.

Assumed, as it is not available here or cannot be computed in this time:

- Shapes: {ROCKS} rocks with dents, generated (`jobs/studies/rocks.py`) in place of six scans. A
  convex stone is the hull of a rock, a non-convex one has {PARTS["non_convex"]} pieces; of the same
  sieve size it has {percent(hollow)} of volume. Edges have a radius of 5 % of a stone's diameter;
  that of the study is not known.
- Grading: {left_out}.
- Loads: {CYCLES["cycles"]} cycles between {low:.0f} and {high:.0f} kPa below both sleepers at once,
  as a rail spreads the axles over neighbouring sleepers; the study has 8 s with a solid rail.
- Preparation: stones are poured with friction 0.1, compacted by 100 kPa, and sleepers are set into
  the bed, while the study fills its track with copies of a cell and places the sleepers on it.

The modulus of the bed is the slope of stress over strain below a sleeper while its load rises;
strain is displacement over the height of the bed. The study calls it the slope of the sleeper's
stress-strain curve.
"""


def part_bed(n):
    rows = []
    for title, quantity in (
            ("penetration of the sleepers while they come to rest in the bed, mm",
             "sinkage before the cycles"),
            ("stiffness in the first cycle, MPa", "stiffness, cycle 1"),
            ("stiffness in the last but one, MPa", f"stiffness, cycle {CYCLES['cycles'] - 1}"),
            ("stiffness in the last, MPa", f"stiffness, {LAST}"),
            ("lowest position in the first cycle, mm down", "lowest level, cycle 1"),
            ("lowest position in the last cycle, mm down", f"lowest level, {LAST}"),
            ("position at the end of the first cycle, mm down", "settlement, cycle 1"),
            ("settlement from the end of the first to that of the last cycle, mm", SETTLED),
            ("porosity up to 0.25 m", "porosity"),
            ("neighbours in contact per stone", "coordination"),
            ("mean contact force, kN", "mean contact force"),
            ("contact force that 0.1 % exceed, kN", "contact force of 99.9 % of all"),
            ("largest contact force, kN", "largest contact force"),
            ("largest resultant of a stone, kN", "largest resultant on a stone")):
        cells = []
        for shape in SHAPES:
            found = of(n, shape, quantity)
            cells.append(f"{np.mean(found):.3g}" + (
                f" ({min(found):.3g} to {max(found):.3g})" if len(found) > 1 else ""))
        rows.append((title, *cells))
    count = len(of(n, "convex", "stones"))
    what = f"{count} packings: mean (least to most)" if count > 1 else "One packing"
    return heading("Convex and non-convex stones") + f"""
![Settlement, stress over strain in the first packing, contact forces](stones.png)

{what}. Positions count from the begin of the cycles, when the
sleepers are not yet quite at rest; so the settlement counts from the end of the first cycle.

{table(["", *TITLES.values()], rows)}
{certainty(n)}The study has the distribution of the "total force" of its stones and does not define
it. The resultant of the contact forces of a stone is small in a bed that hardly moves (last row),
so contact forces are compared instead, at eight instants of each cycle.
{granite(n)}"""


def certainty(n):
    if len(of(n, "convex", "stones")) < 2:
        return ""
    texts = []
    for what, quantity, unit in (("stiffness", f"stiffness, {LAST}", "MPa"),
                                 ("settlement after the first cycle", SETTLED, "mm")):
        by = mean(n, "non_convex", quantity) - mean(n, "convex", quantity)
        uncertain = error_of_difference(n, quantity)
        texts.append(f"in {what} {by:+.3g} +- {uncertain:.2g} {unit}")
    return (f"Non-convex stones less convex ones, with the standard error over {len(PACKINGS)} "
            f"packings:\n{' and '.join(texts)}. ")


def granite(n):
    if not full(n):
        return ""
    soft, hard = (n(run, "stiffness, cycle 1") for run in ("bed_convex_1", "bed_granite"))
    stress, stiff = mean(n, "convex", "largest stress"), f"stiffness, {LAST}"
    rows = []
    for model, title in (("bed", "Hertz"), ("bars", "bars")):
        for shape in SHAPES:
            bound = mean(n, shape, "upper bound of the stiffness", model)
            rows.append((f"{TITLES[shape]}, {title}", f"{mean(n, shape, stiff, model):.3g}",
                         f"{bound:.3g}" if shape == "convex" else "",
                         *(f"{mean(n, shape, quantity, model):.3g}"
                           for quantity in (SETTLED, "largest contact force"))))
    return f"""
The published moduli are not reached. A modulus of 430 MPa means that {stress:.0f} kPa compress
{HEIGHT} m by {stress / 430 * HEIGHT:.2f} mm. Two experiments:

- A bed of the same poured stones, but with {1e-9 * GRANITE:.0f} instead of {1e-9 * STONES:g} GPa,
  was compacted and loaded: {hard:.0f} instead of {soft:.0f} MPa in the first cycle. So the modulus
  of the stones does not explain the difference.
- Contacts as stiff as a bar of {1e-9 * STONES:g} GPa between the centres of two stones, with the
  square of their distance as its section: k = E d = {STONES * BAR:.0e} N/m for stones
  {1e3 * BAR:.0f} mm apart, half of it along the contact (linear law, restitution 0.45,
  {len(BARRED)} packings). The Hertz law is softer, as rounded edges touch in small areas.

The upper bound of the stiffness is that of convex stones which follow the strain of the height
without rotation, also beside the sleepers, computed from all contacts between 0.05 and 0.2 m at the
largest load (Walton 1987, doi:10.1016/0022-5096(87)90036-6). With Hertz contacts of
{1e-9 * STONES:g} GPa it lies far below the published moduli, with bars above. The study states
neither its contact law nor its strain: if its strain is that of the height, its contacts must have
been about as stiff as bars. MPa, MPa, mm, kN:

{table(["stones, contacts", "stiffness in the last cycle", "upper bound of the stiffness",
        "settlement after the first cycle", "largest contact force"], rows)}"""


def part_track(n):
    count = len(of(n, "convex", "simulated", "track"))
    if not count:
        return ""
    rows = []
    for title, quantity in (
            ("penetration of the sleepers while they are placed, mm", "sinkage before the wheels"),
            ("lowest position of a sleeper under the wheels, mm down",
             "lowest position of a sleeper"),
            ("displacement of the lowest sleeper, mm", "mean displacement of the lowest sleeper"),
            ("mean of all sleepers, mm", "mean displacement of the sleepers"),
            *((f"displacement of the rail at x = {x:g} m ({place}), mm",
               f"rail, {place}, mean displacement") for place, x in RAIL.items()),
            *((f"lowest position of the rail there, {place}, mm down",
               f"rail, {place}, lowest position") for place in RAIL),
            ("largest tension in the ground, MPa", "tension, largest"),
            ("its x, m", "tension, x of the largest"),
            ("largest compression in the ground, MPa", "compression, largest"),
            ("its mean over columns of elements up to 1.2 m, MPa",
             "compression, mean up to 1.2 m"),
            ("from 4.8 m, MPa", "compression, mean from 4.8 m"),
            ("stone-steps per second and core", "stone steps per second and core"),
            ("run time, % for stones", "time, dem"), ("for the ground", "time, ground"),
            ("for rail and sleepers", "time, track"), ("for the coupling", "time, coupling"),
            ("time of one core for 0.5 s, min", "time of one core for 0.5 s")):
        cells = []
        for shape in SHAPES:
            found = of(n, shape, quantity, "track")
            cells.append(f"{np.mean(found):.3g}" + (
                f" ({min(found):.3g} to {max(found):.3g})" if len(found) > 1 else ""))
        rows.append((title, *cells))
    run = f"track_convex_{TRACKS[0]}"
    return heading(TEN) + f"""
![Settlement of sleepers and rail, largest stresses in the ground](track.png)

Half of the study's track (`inputs/demfem/track.toml`): ten half sleepers and a rail as solids on
6 m of stones, {n(run, "stones"):.0f} of the convex ones, copied from a cell of 1 m
(`inputs/demfem/cell.toml`), on a ground of {n(run, "elements"):.0f} elements whose modulus rises
from 80 MPa to 30 GPa at x = 3 m. Wheels of 125 kN, 1.6 m apart, roll in from x = 0 at 10 m/s for
{n(run, "simulated"):.2f} s, until the first one has passed all sleepers. In the study they stand on
the whole rail from the beginning, for 8 s. Stones are of 40 to 63 mm, with the contact law of the
slice; sleepers are placed with 5 kN on each and settle under the first wheels as they do in the
study. Displacements count from the begin of the wheels and are means over the last
{PERIOD:g} s, while each axle takes the place of the one before; the largest stresses are those of
any time, of weight and wheels. The wall times in the head of this document count only the last
part of a run that was stopped and resumed.
{f"{count} packings: mean (least to most)" if count > 1 else "One packing"}:

{table(["", *TITLES.values()], rows)}"""


def part_ground(n):
    quantities = ("tension, largest", "tension, x of the largest", "tension, largest near the ends",
                  "compression, mean up to 1.2 m", "compression, mean from 4.8 m",
                  "compression, largest", "compression, x of the largest")
    rows = [(NAMES.get(name, name), *(f"{n(ground_run(name), quantity):.3g}"
                                      for quantity in quantities)) for name in GROUNDS]
    return heading("Ground of rising stiffness") + f"""
![Largest tension and compression in the ground along the track](ground.png)

The ground alone (`inputs/demfem/ground.toml`) carries the mean load of all sleepers at once, spread
over 0.45 m x 1.45 m below each half of a sleeper. Stresses are those due to this load. Assumed: the
curve of the modulus, which is a figure (a hyperbolic tangent of 0.5 m in the middle), and rollers
at the ends; the study clamps the bottom only. Most peaks of the
compression are {n(GROUND_RUN, "compression, median distance of peaks"):.2f} m apart, as sleepers
are. The tension depends on how fast the
modulus rises and on the size of the elements, which the study has as 0.2 m. MPa and m:

{table(["", "largest tension", "its x", "largest tension within 1 m of the ends",
        "compression, mean up to 1.2 m", "compression, mean from 4.8 m", "largest compression",
        "its x"], rows)}"""


def part_cost(n):
    if not full(n):
        return ""
    rows = []
    for shape in SHAPES:
        run = f"cost_{shape}"
        total, dem, fem, coupling = BENCHMARK["minutes"][shape]
        ours = predicted(n, shape)
        rows.append((TITLES[shape], f"{total} ({dem}, {fem}, {coupling})",
                     f"{ours[0]:.0f}, {ours[1]:.2g}",
                     f"{n(run, 'stone steps per second and core'):.3g}",
                     f"{n(run, 'element steps per second and core'):.3g}",
                     *(f"{n(run, f'time, {what}'):.1f}"
                       for what in ("dem", "ground", "track", "coupling"))))
    head = ["", "theirs, minutes: total (stones, elements, coupling)",
            f"ours predicted on {CORES} cores, minutes: stones, ground", "stone-steps/s/core",
            "element-steps/s/core", *(f"ours measured, % of run time: {what}" for what in
                                      ("stones", "ground", "rail and sleepers", "coupling"))]
    run = "cost_convex"
    return heading("Cost") + f"""
The study reports the run time of 0.5 s of 3.3e5 stones and 3.5e4 elements, mostly tetrahedra of
rails and sleepers, on one graphics processor and eight cores. Ours is that of wheels on a solid
rail and two sleepers (`inputs/demfem/solids.toml`: {n(run, "stones"):.0f} stones of 53 to 63 mm,
linear contacts, {n(run, "elements"):.0f} elements of the ground, {n(run, "ranks"):.0f} ranks). The
prediction multiplies these rates by the study's 3.3e5 (non-convex: 3.4e5) stones and steps of 1e-6
s, and by the
{BENCHMARK["elements"]} hexahedra of its ground and steps of 1e-5 s. It contains neither rails and
sleepers nor losses of parallel work, and a larger bed has other rates:

{table(head, rows)}
The fractions cannot be compared with the study's: its elements are mostly those of ten sleepers and
two rails, ours of two sleepers and one rail; here "coupling" is the exchange of surfaces and forces
between ranks; the search for stones at surfaces is part of "stones". Those of ten sleepers are in
"{TEN}".
"""


def part_missing():
    return heading("Not repeated") + """
- 8 s of wheels, 50 cycles, on ten sleepers.
- The six scanned rocks, and the small stones: from 22.4 to 31.5 mm below two sleepers, to 40 mm
  below ten.
- The benchmark with 1.2e5 elements.
"""
