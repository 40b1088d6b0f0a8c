"""Document of the study demfem, from its numbers and lines alone: what was found, set-up, stones on
the slice. Its other parts: demfem_sections.py."""
import numpy as np

from .demfem_figures import figures
from .demfem_model import (BAR, BARRED, BLOCKS, CYCLES, DECK, ELEMENTS, FORCES, GRANITE, GROUND_RUN,
                           HEIGHT, LAST, LEFT, LONG, LONG_CYCLES, NEXT_TO_LAST, PACKINGS, PARTS,
                           ROCKS, SETTLED, SHAPES, STONES, TEN_RATES, TITLES, TRACK_DECK, TRACKS,
                           TWO_RATES, WITHOUT, ZETA, at_edge, ground_run)
from .demfem_sections import (part_cost, part_ground, part_missing, part_stresses, part_track,
                              part_unexamined)
from .demfem_targets import (CLOSE, END, LOWEST, START, STIFFNESS, SURE, TEN, UNEXAMINED,
                             apart_from_start, error_of_difference, less, mean, of, of_both,
                             predicted_total, ratio, slower, student, tracked)
from .study import between, heading, of_packings, percent, span, table

THEIRS = 5  # mm, published difference of the lowest sleepers
__all__ = ("CRITERION", "SOURCE", "TITLE", "document", "figures", "summary")  # of the study

TITLE = "demfem: convex and non-convex stones below sleepers, and what they cost"
SOURCE = """The study *A DEM-FEM coupling framework applied to railroad infrastructure
simulations* has ten solid sleepers with rails on 3.3e5 rounded stones on a ground whose stiffness
rises along the track, under axles that pass. A model of half of this track has fewer, larger
stones. Three smaller models are a slice with two sleepers, the ground alone, and two solid sleepers
for the cost."""
CRITERION = f"""The study gives its values as "around". A value or a ratio counts as
reproduced within {100 * CLOSE:.0f} %, a difference of two values, also if it is given in %, within
{200 * CLOSE:.0f} %. For "sinks less", "settles less" and "displaced less" only the sign is
judged; the difference of the means must
exceed {student(len(PACKINGS)):.1f} standard errors with {len(PACKINGS)} packings of each shape,
{student(len(BARRED)):.1f} with {len(BARRED)} and {student(len(TRACKS)):.1f} with {len(TRACKS)}
(Student's t, two-sided, {100 * SURE:.0f} %, the same
scatter in both shapes). Where the table has a range, each packing is judged: "yes" means that all
of them reproduce the value, "no" that none does. Values after +- are standard errors. Largest
forces are the largest of all packings. Where no experiment examines a deviation, the table names
the section "{UNEXAMINED}"."""


def document(n):
    return "".join((part_setup(n), part_bed(n), part_track(n), part_stresses(n), part_ground(n),
                    part_cost(n), part_unexamined(n), part_missing()))


def full(n):
    return n.has("cost_convex")


def summary(n):
    if not full(n):
        return ""
    tracks = len(TRACKS) if tracked(n) else 0
    return "\n".join((
        "", found_stiffness(n), found_track(n), found_slice(n), found_forces(n),
        found_ground(n), found_cost(n),
        f"{thrown_up(n)}- {too_low(n)}", "",
        "+- is the standard error: from "
        f"{len(PACKINGS)} packings for the two-sleeper model"
        + (f", from {tracks} for the ten-sleeper track"
           f"{', too few for a reliable error' if tracks < 3 else ''}" if tracks else "")
        + ". Growth, compression "
        "peaks, fractions of forces and the range of the cycles are computed from "
        "[lines.csv](lines.csv), which has every fourth stored instant of displacements and every "
        "second one of the cycles.", ""))


def found_stiffness(n):
    stiff = f"stiffness, {LAST}"
    by, certain = less(n, stiff)
    times, uncertain = ratio(n, stiff)
    barred, sure = less(n, stiff, "bars")
    convex, non_convex = (mean(n, shape, stiff) for shape in SHAPES)
    theirs = tuple(STIFFNESS.values())
    confirms = "confirms" if barred < 0 and sure else "does not confirm"
    return f"""- Non-convex stones make the bed {"softer" if by > 0 else "stiffer"} by
  {size(n, stiff, "bed")} MPa, that is, {times:.2f} +- {uncertain:.2f} times as stiff
  ({clause(certain)}published {theirs[1] / theirs[0]:.2f}). The bed has {convex:.1f} MPa with convex
  and {non_convex:.1f} MPa with non-convex stones (published {theirs[0]} and {theirs[1]} MPa): with
  Hertz contacts of {1e-9 * STONES:g} GPa, an upper bound of about
  {mean(n, "convex", "upper bound of the stiffness"):.0f} MPa is estimated for convex stones.
- With contacts as stiff as bars of the same modulus, the bed of convex stones has
  {span(of(n, "convex", stiff, "bars"))} MPa, that of non-convex stones
  {span(of(n, "non_convex", stiff, "bars"))} MPa. Their ratio of {ratio(n, stiff, "bars")[0]:.2f} is
  {"below" if barred > 0 else "above"} 1{"" if sure else ", but undecided"}: this contact law
  {confirms} the published order of the shapes."""


def size(n, quantity, model="track", form=".1f"):
    """'3.5 +- 0.5', the difference between both shapes without its sign."""
    return (f"{abs(less(n, quantity, model)[0]):{form}} +- "
            f"{error_of_difference(n, quantity, model):{form}}")


def less_or_more(by):
    """On non-convex stones, if the mean of convex ones exceeds theirs by this."""
    return "less" if by > 0 else "more"


def found_track(n):
    if not tracked(n):
        return ("- The track with ten sleepers is not judged: results of an earlier version are "
                f'withdrawn, see "{TEN}".')
    end, certain = less(n, END, "track")
    early, _ = less(n, START, "track")
    grown, sure = less(n, "rail, growth", "track")
    lowest, decided = less(n, LOWEST, "track")
    return f"""- After {mean(n, "convex", "simulated", "track"):.2f} s of wheels, the rail, mean of
  three positions, is displaced on non-convex stones by {size(n, END)} mm {less_or_more(end)}
  ({clause(certain)}published: 7 to 9 mm less after 8 s), and the lowest sleeper by
  {size(n, LOWEST)} mm {less_or_more(lowest)} ({clause(decided)}published: 5 mm less). In the study
  both shapes start alike and diverge. Here the rail is displaced on non-convex stones by
  {abs(early):.2f} mm {less_or_more(early)} in the first axle spacing after the ramp, and this
  difference then {"grows" if grown * end > 0 else "falls"} by
  {size(n, "rail, growth", form=".2f")} mm ({clause(sure)}published: to 7 to 9 mm).
  {unlike_start(n)}"""


def unlike_start(n):
    """If the shapes differ from the start."""
    return ("This is not the published observation: the difference arises in the first axle "
            "spacing." if apart_from_start(n) else "")


def clause(certain):
    return "" if certain else "not significant; "


def found_slice(n):
    level = f"lowest level, {LAST}"
    (settled, certain), (lower, sure) = less(n, SETTLED), less(n, level)
    return f"""- After the first cycle, two sleepers of the slice settle by
  {size(n, SETTLED, "bed", ".2f")} mm {less_or_more(settled)} on non-convex stones in
  {CYCLES["cycles"] - 1} cycles{"" if certain else ", which decides nothing"}. Their lowest position
  since the start of the cycles has the {"opposite" if settled * lower < 0 else "same"} sign: on
  non-convex stones it is {"higher" if lower > 0 else "lower"} by {size(n, level, "bed", ".2f")}
  mm{"" if sure else ", undecided" if certain else ", also undecided"}."""


def found_forces(n):
    average, largest = (mean(n, "non_convex", f"{what} contact force")
                        / mean(n, "convex", f"{what} contact force")
                        for what in ("mean", "largest"))
    return f"""- The mean contact force of non-convex stones is {average:.2f} times that of convex
  ones, the largest, mean over the packings, {largest:.2f} times. The study finds much larger forces
  on non-convex stones (a total force on a stone, which it does not define)."""


def found_ground(n):
    tension, coarse, free, both, sharp, smooth = (n(run, "tension, largest") for run in (
        GROUND_RUN, *map(ground_run, ("elements of 0.2 m", "free ends",
                                      "elements of 0.2 m, free ends",
                                      "rise of the modulus over 0.25 m",
                                      "rise of the modulus over 1 m"))))
    where = n(GROUND_RUN, "tension, x of the largest")
    edge = ", at the edge of a loaded area" if at_edge(where) else ""
    return f"""- The ground alone has its largest tension at x = {where:.2f} m (published: 3
  m){edge}. With elements of 0.2 m and free ends, as in the study, it is {both:.2f} MPa (published
  0.1), with elements of 0.1 m and rollers {tension:.2f} ({coarse:.2f} with rollers and 0.2 m,
  {free:.2f} with free ends and 0.1 m).
  The assumed width of the rise of the modulus changes it from {smooth:.3f} (1 m) to {sharp:.3f} MPa
  (0.25 m).{below_stones(n)}"""


def below_stones(n):
    if not tracked(n):
        return ""
    weight, wheels, blocks = (mean(n, "convex", f"{quantity}, largest", "track") for quantity in (
        "tension", *(f"tension by the wheels, {how}" for how in (ELEMENTS, BLOCKS))))
    return f""" Below convex stones the tension is {weight:.2f} MPa with the weight, {wheels:.2f} by
  the wheels alone and {blocks:.2f} by them in means over blocks as large as the study's elements,
  and the compression there is largest at
  x = {span(of(n, "convex", "compression, x of the largest", "track"))} m (published: in the
  middle)."""


def found_cost(n):
    totals = {shape: [predicted_total(n, shape, model) for model in (TWO_RATES, TEN_RATES)]
              for shape in SHAPES}
    text = {shape: between(both) for shape, both in totals.items()}
    return f"""- By the rates of two and of ten sleepers, the predicted run time of the study's
  benchmark on 8 cores is {text["convex"]} min with convex stones (published, with a graphics
  processor: 303) and {text["non_convex"]} min with non-convex ones (published 495). A non-convex
  stone takes {slower(n):.2f} times the time of a convex one per step (published 3.0)."""


def thrown_up(n):
    """If the beds of the slice are of runs whose platen was removed too early."""
    if all((f"bed_{shape}_{packing}", LEFT) in n.rows for shape in SHAPES for packing in PACKINGS):
        return ""
    return """- The slice is of an earlier version. Its platen was removed while it still bore a
  large part of its load, which threw the stones up and loosened the bed ([measured for a
  cell](../../decisions/stages_and_windows.md)). Its deck is mended, but not run again: all its
  numbers may change.
"""


def bars_released(n):
    """If the beds with bars are of runs with a shorter release, by how much they rebound."""
    if (f"bars_convex_{BARRED[0]}", LEFT) in n.rows:
        return ""
    rebound = (1e3 * DECK["bed"]["height"] * DECK["platen"]["pressure"]
               / (1e6 * mean(n, "convex", f"stiffness, {LAST}", "bars")))
    return f""" These runs lifted the platen by 1.5 mm only, and the load left was not stored. By
  the stiffness of the last cycle the bed rebounds by about {rebound:.2f} mm."""


def too_low(n):
    """Where wall times lack the part of a run before it was resumed."""
    missing, names = 0.0, []
    for shape in SHAPES:
        for packing in TRACKS:
            run = f"track_{shape}_{packing}"
            if not n.has(run):
                continue
            needed = n(run, "time of one core for 0.5 s") * n(run, "simulated") / 0.5
            lost = needed - n(run, "wall_time") / 60
            if lost > 0.02 * needed:
                missing += lost
                names.append(f"`{run}`")
    return (f"The sum of wall times below is too low by at least {missing:.0f} minutes: a run that "
            f"was stopped and resumed stores the wall time of its last part only "
            f"({', '.join(names)}, whose wheels need more processor time than that)."
            if names else "Wall times count only the last part of a run that was resumed.")


def part_setup(n):
    left_out = (f"on the slice, stones below 31.5 mm are left out, {100 * WITHOUT[0]:.0f} % of the "
                "mass of the middle of category A. On the track with ten sleepers, stones below "
                f"40 mm are left out, {100 * WITHOUT[1]:.0f} % of the mass "
                "(`inputs/demfem/cell.toml`); this is the largest reduction"
                if full(n) else "only stones of 45 to 63 mm, as this is the short form: compare "
                                "signs only")
    hollow = (n("shapes_non_convex", "volume over sieve cubed")
              / n("shapes_convex", "volume over sieve cubed") - 1)
    volume = f"{percent(abs(hollow))[1:]} {'less' if hollow < 0 else 'more'}"
    low, high = (np.mean(of_both(n, f"{what} stress of the last cycle"))
                 for what in ("least", "largest"))
    least, largest = (pick(of_both(n, f"{what} stress"))
                      for what, pick in (("least", min), ("largest", max)))
    return heading("Set-up") + f"""
For their stiffness the shapes are compared on a slice of the track
(`inputs/demfem/sleeper.toml`): two rigid sleepers on {HEIGHT} m of ballast,
0.3 m of the length of the sleepers between smooth walls,
{n("bed_convex_1", "stones"):.0f} convex or {n("bed_non_convex_1", "stones"):.0f} non-convex stones,
on a rigid, rough floor. Given by the study: density, modulus of 1 GPa (its stones are fifty times
softer than granite to save time), Poisson's ratio, friction, restitution, axles of 250 kN 1.6 m
apart, one each 0.16 s, convex stones of 20 triangles, non-convex ones of three convex pieces, with
60 triangles in total.

Our assumptions and reductions:

- Shapes: {ROCKS} rocks with dents, generated (`jobs/studies/rocks.py`) in place of six scans. A
  convex stone is the hull of a rock. A non-convex one has {PARTS["non_convex"]} pieces; it has
  {volume} volume than a convex stone of the same sieve size. Edges have a radius of 5 % of a
  stone's diameter; that of the study is not known.
- Grading: {left_out}.
- Cross-section: the ballast of the ten sleepers ends at y = {TRACK_DECK["bed"]["y"][1]:g} m from
  the middle of the track at a smooth wall; it has no shoulder.
- Loads: {CYCLES["cycles"]} cycles between {low:.1f} and {high:.0f} kPa, with the weight of the
  sleepers, below both at once, as a rail spreads the axles over neighbouring sleepers; the study
  has 8 s with a solid rail. In
  the first cycle, while the sleepers still move, the stress is between {least:.0f} and
  {largest:.0f} kPa.
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
            ("stiffness in the last but one, MPa", f"stiffness, {NEXT_TO_LAST}"),
            ("stiffness in the last, MPa", f"stiffness, {LAST}"),
            ("lowest position in the first cycle, mm down", "lowest level, cycle 1"),
            ("lowest position in the last cycle, mm down", f"lowest level, {LAST}"),
            ("position at the end of the first cycle, mm down", "settlement, cycle 1"),
            ("settlement from the end of the first to that of the last cycle, mm", SETTLED),
            ("porosity up to 0.25 m", "porosity"),
            ("neighbours in contact per stone", "coordination"),
            ("mean contact force, kN", "mean contact force"),
            ("contact force that 0.1 % exceed, kN", "contact force of 99.9 % of all"),
            ("contacts with less than 1 kN, %", "contacts below the limit"),
            ("largest contact force, kN", "largest contact force"),
            ("largest resultant of a stone, kN", "largest resultant on a stone")):
        rows.append((title, *(span(of(n, shape, quantity)) for shape in SHAPES)))
    count = len(of(n, "convex", "stones"))
    return heading("Convex and non-convex stones") + f"""
![Settlement, stress over strain in the first packing, contact forces](stones.png)

In the upper figure a curve is the mean over the packings and its band reaches from the least to the
most of them. Fractions of forces are means over the packings. Contacts with less than
{1e3 * FORCES[1]:.1f} N are not drawn: {mean(n, "convex", "contacts, bin 1"):.0f} % of those of
convex and {mean(n, "non_convex", "contacts, bin 1"):.0f} % of those of non-convex stones. Vertical
lines are the largest published forces on a stone.

Zero is the start of cycling. The sleepers then still rebound by up to
{max(of_both(n, "rebound at the start")):.1f} mm, so settlement is counted from the end of cycle 1.
{of_packings(count).capitalize()}:

{table(["", *TITLES.values()], rows)}
{certainty(n)}The study has the distribution of the "total force" of its stones and does not define
it. The resultant of the contact forces of a stone balances no more than its weight and inertia
(last row), so contact forces are compared instead, at eight instants of each cycle.
{long_cycles(n)}{contact_laws(n)}"""


def long_cycles(n):
    """As many cycles as in the study."""
    if not of(n, "convex", SETTLED, "long"):
        return ""
    rows = [(title, *(span(of(n, shape, quantity, "long")) for shape in SHAPES))
            for title, quantity in ((f"settlement from the end of the first cycle to that of cycle "
                                     f"{LONG_CYCLES}, mm", SETTLED),
                                    ("of it in the last ten cycles, mm",
                                     "settlement in the last ten cycles"),
                                    ("stiffness in the last cycle, MPa", "stiffness, last cycle"))]
    by, certain = less(n, SETTLED, "long")
    packings = "one packing" if len(LONG) == 1 else f"{len(LONG)} packings"
    most = max(of_both(n, SETTLED, "long"))
    small = (" Both settlements are smaller than this difference, so the slice cannot show it."
             if most < THEIRS else "")
    return f"""
The slice also carried the {LONG_CYCLES} cycles of the study ({packings} of each shape). After the
first cycle, the sleepers settled by {abs(by):.2g} mm {less_or_more(by)} on non-convex stones
(published: {THEIRS} mm less){"" if certain else ", which so few packings do not decide"}.{small}

{table(["", *TITLES.values()], rows)}"""


def certainty(n):
    if len(of(n, "convex", "stones")) < 2:
        return ""
    texts = []
    for what, quantity, unit in (("stiffness", f"stiffness, {LAST}", "MPa"),
                                 ("settlement after the first cycle", SETTLED, "mm"),
                                 ("lowest position in the last cycle", f"lowest level, {LAST}",
                                  "mm down")):
        by, certain = less(n, quantity)
        texts.append(f"in {what} {-by:+.3g} +- {error_of_difference(n, quantity):.2g} {unit}"
                     + ("" if certain else " (undecided)"))
    return (f"Non-convex stones less convex ones, with the standard error over {len(PACKINGS)} "
            f"packings: {', '.join(texts)}. {first_cycle(n)}")


def first_cycle(n):
    """Why settlement and lowest position differ in sign, if they do."""
    settled, level, first = (less(n, quantity)[0] for quantity in (
        SETTLED, f"lowest level, {LAST}", "settlement, cycle 1"))
    if settled * level > 0 or first * level < 0:
        return ""
    shape = TITLES["convex" if first > 0 else "non_convex"]
    return f"The last two differ in sign, as {shape} stones yield more in the first cycle. "


def contact_laws(n):
    """Experiments on the stiffness of the contacts."""
    if not full(n):
        return ""
    soft, hard = (n(run, "stiffness, cycle 1") for run in ("bed_convex_1", "bed_granite"))
    bound = "upper bound of the stiffness"
    first, last = (n(f"bars_convex_{BARRED[0]}", f"stiffness, {cycle}")
                   for cycle in ("cycle 1", LAST))
    changes = [100 * abs(end / before - 1) for end, before in zip(
        of_both(n, f"stiffness, {LAST}", "bars"), of_both(n, f"stiffness, {NEXT_TO_LAST}", "bars"))]
    missed = all(mean(n, shape, f"stiffness, {LAST}") < (1 - CLOSE) * value
                 for shape, value in STIFFNESS.items())
    granite, theirs = n("bed_granite", bound), STIFFNESS["convex"]
    later = ("" if abs(last / first - 1) <= CLOSE else
             ": a first cycle does not show the stiffness of later ones")
    stress = np.mean(of_both(n, "largest stress of the last cycle"))
    restitution = np.exp(-ZETA / (1 - ZETA**2)**0.5 * (np.pi - np.arctan(
        2 * ZETA * (1 - ZETA**2)**0.5 / (1 - 2 * ZETA**2))))
    return f"""
{"The published moduli are not reached. " if missed else ""}A modulus of {theirs} MPa means that
{stress:.0f} kPa compress {HEIGHT} m by {stress / theirs * HEIGHT:.2f} mm. Two experiments examine
the contacts:

- A bed of the same poured stones, but with {1e-9 * GRANITE:.0f} instead of {1e-9 * STONES:g} GPa,
  was compacted and loaded by one cycle: {hard:.0f} instead of {soft:.0f} MPa. With bars, the
  bed of the same seed has {first:.0f} MPa in the first cycle and {last:.0f} in the last{later}. The
  estimate of the upper bound for {1e-9 * GRANITE:.0f} GPa, of one packing after one cycle, is
  {granite:.0f} MPa, {"below" if granite < theirs else "above"} {theirs} MPa.
- Contacts as stiff as a bar of {1e-9 * STONES:g} GPa between the centres of two stones, with the
  square of their distance as its section: k = E d = {STONES * BAR:.0e} N/m with d =
  {1e3 * BAR:.0f} mm, one constant for all contacts, also those of sleepers and walls, and half of
  it along the contact. The law is linear, and its restitution is {restitution:.2f} instead of
  {DECK["contact"][0]["restitution"]:g}, which is a second change. {len(BARRED)} packings of each
  shape were run. From the last but one to the last cycle their stiffness still changes by
  {between(changes, ".1f")} %.{bars_released(n)}

Upper bound: every stone of the layer moves with a uniform vertical strain and does not rotate. It
is an estimate, from all contacts between 0.05 and 0.2 m at the one stored instant with the largest
forces, with the strain below the sleepers also beside them (Walton 1987,
doi:10.1016/0022-5096(87)90036-6). It is not given for non-convex stones: the stored lines of their
contacts end at the centres of pieces, not of stones. {bound_words(n)}

{table(["stones, contacts", "stiffness in the last cycle, MPa", "upper bound of the stiffness, MPa",
        "settlement after the first cycle, mm", "largest contact force, kN"], law_rows(n))}
{bars_decide(n)}"""


def bound_words(n):
    """What the upper bound says of the study's contacts."""
    theirs = STIFFNESS["convex"]
    hertz, bars = (mean(n, "convex", "upper bound of the stiffness", model)
                   for model in ("bed", "bars"))
    sides = ["below" if bound < theirs else "above" for bound in (hertz, bars)]
    reached = 100 * mean(n, "convex", f"stiffness, {LAST}", "bars") / theirs
    stiff = (": if its strain is that of the height, its contacts must have been much stiffer than "
             f"ours of Hertz; with bars the bed reaches {reached:.0f} % of it"
             if sides == ["below", "above"] else "")
    return (f"With Hertz contacts of {1e-9 * STONES:g} GPa it lies {sides[0]} the published "
            f"{theirs} MPa, with bars {sides[1]} them. The study states neither its contact law "
            f"nor its strain{stiff}.")


def law_rows(n):
    rows = []
    for model, title in (("bed", "Hertz"), ("bars", "bars")):
        for shape in SHAPES:
            bound = (span(of(n, shape, "upper bound of the stiffness", model))
                     if shape == "convex" else "")
            rows.append((f"{TITLES[shape]}, {title}",
                         span(of(n, shape, f"stiffness, {LAST}", model)), bound,
                         *(span(of(n, shape, quantity, model))
                           for quantity in (SETTLED, "largest contact force"))))
    return rows


def bars_decide(n):
    stiff = f"stiffness, {LAST}"
    by, certain = less(n, stiff, "bars")
    times, uncertain = ratio(n, stiff, "bars")
    return (f"With bars, non-convex stones are {times:.2f} +- {uncertain:.2f} times as stiff as "
            f"convex ones, with Hertz contacts {ratio(n, stiff)[0]:.2f} times. The difference of "
            f"{-by:+.0f} +- {error_of_difference(n, stiff, 'bars'):.0f} MPa with bars "
            + ("is significant" if certain else f"is undecided with {len(BARRED)} packings")
            + ".\n")
