"""Targets of the study demfem, and the statistics of packings that they are judged by."""
import numpy as np
import scipy.stats

from .demfem_lines import bins
from .demfem_model import (BENCHMARK, CORES, GROUND_RUN, LAST, NEXT_TO_LAST, PACKINGS, RAIL,
                           SETTLED, SHAPES, TEN_RATES, TITLES, TRACKS, TWO_RATES, at_edge,
                           ground_run)
from .study import Target

BED, TEN, COST = "Convex and non-convex stones", "Ten sleepers and a rail", "Cost"
STRESSES = "Stresses in the ground below stones"
ALONE, UNEXAMINED = "Ground of rising stiffness", "Deviations without an experiment"
CLOSE = 0.15  # relative, of values given as "around" and ratios; twice that of differences of two
STEADY = 0.01  # relative change of the stiffness from one cycle to the next
SURE = 0.95  # two-sided probability by which a difference between shapes is judged
SLOWER = 3.0  # published time per stone and step, non-convex over convex
STIFFNESS = {"convex": 430, "non_convex": 540}  # MPa, published of the bed
LOWEST = "mean displacement of the lowest sleeper"
END = "rail, displacement in the last axle spacing"
RISE = "rail, rise in the rest"
START = "rail, displacement in the first axle spacing"


def of(numbers, shape, quantity, model="bed"):
    """Of all packings; models are bed and bars (two sleepers) and track (ten)."""
    return [numbers(f"{model}_{shape}_{packing}", quantity) for packing in PACKINGS
            if numbers.has(f"{model}_{shape}_{packing}")]


def of_both(numbers, quantity, model="bed"):
    return sum((of(numbers, shape, quantity, model) for shape in SHAPES), [])


def mean(numbers, shape, quantity, model="bed"):
    return float(np.mean(of(numbers, shape, quantity, model)))


def scatter(numbers, shape, quantity, model="bed"):
    """Standard deviation between packings."""
    return float(np.std(of(numbers, shape, quantity, model), ddof=1))


def error(numbers, shape, quantity, model="bed"):
    """Standard error of the mean over the packings; 0 of one packing."""
    count = len(of(numbers, shape, quantity, model))
    return scatter(numbers, shape, quantity, model) / count**0.5 if count > 1 else 0.0


def error_of_difference(numbers, quantity, model="bed"):
    """Standard error of the difference of the means of both shapes."""
    return float(np.hypot(*(error(numbers, shape, quantity, model) for shape in SHAPES)))


def ratio(numbers, quantity, model="bed"):
    """Mean of non-convex over that of convex stones, and its standard error."""
    means = {shape: mean(numbers, shape, quantity, model) for shape in SHAPES}
    found = means["non_convex"] / means["convex"]
    return found, found * float(np.hypot(*(error(numbers, shape, quantity, model) / means[shape]
                                           for shape in SHAPES)))


def student(count):
    """How many standard errors a difference of two means must exceed: Student's t for `count`
    packings of each shape, with the same scatter in both."""
    return float(scipy.stats.t.ppf((1 + SURE) / 2, 2 * count - 2))


def fisher(count):
    """Ratio of two standard deviations of `count` packings each that chance alone exceeds rarely.
    """
    return float(scipy.stats.f.ppf((1 + SURE) / 2, count - 1, count - 1)**0.5)


def less(numbers, quantity, model="bed"):
    """By how much the mean of convex stones exceeds that of non-convex ones, and whether it differs
    from 0 by Student's t."""
    by = mean(numbers, "convex", quantity, model) - mean(numbers, "non_convex", quantity, model)
    count = len(of(numbers, "convex", quantity, model))
    return by, count > 1 and abs(by) > student(count) * error_of_difference(numbers, quantity,
                                                                           model)


def tracked(numbers):
    """Whether there are results of ten sleepers that rest before the wheels, not only times."""
    return all((f"track_{shape}_{packing}", RISE) in numbers.rows
               for shape in SHAPES for packing in TRACKS)


def rate(numbers, shape, what, model=TWO_RATES):
    """Steps of stones or elements per second and core: of the two solid sleepers or of the ten."""
    quantity = f"{what} steps per second and core"
    return (numbers(f"cost_{shape}", quantity) if model == TWO_RATES
            else mean(numbers, shape, quantity, "track"))


def predicted(numbers, shape, cores=CORES, model=TWO_RATES):
    """Minutes of stones and of the ground's hexahedra for the study's benchmark, from the measured
    rates."""
    bench = BENCHMARK
    steps = bench["duration"] / bench["stone_step"], bench["duration"] / bench["element_step"]
    return (bench["stones"][shape] * steps[0] / rate(numbers, shape, "stone", model) / cores / 60,
            bench["elements"] * steps[1] / rate(numbers, shape, "element", model) / cores / 60)


def part(numbers, shape, what, model=TWO_RATES):
    """Fraction of the run time for "dem", "ground", "track" or "coupling"."""
    quantity = f"time, {what}"
    return 0.01 * (numbers(f"cost_{shape}", quantity) if model == TWO_RATES
                   else mean(numbers, shape, quantity, "track"))


def predicted_total(numbers, shape, model=TWO_RATES):
    """Minutes of the whole benchmark, if stones take the measured part of it."""
    return predicted(numbers, shape, model=model)[0] / part(numbers, shape, "dem", model)


def besides(numbers, shape, model=TWO_RATES):
    """Time of elements, solids and coupling over that of the stones."""
    return (sum(part(numbers, shape, what, model) for what in ("ground", "track", "coupling"))
            / part(numbers, shape, "dem", model))


def slower(numbers, model=TWO_RATES):
    """Time per stone and step, non-convex over convex."""
    return (rate(numbers, "convex", "stone", model) / rate(numbers, "non_convex", "stone", model))


def least_alike(numbers):
    """Bin of forces, below the limit and but for the first one, in which the fractions of contacts
    of both shapes differ most, and their ratio, non-convex over convex."""
    found = {k: ratio(numbers, f"contacts, bin {k}")[0] for k in bins() if k > 1}
    k = max(found, key=lambda k: abs(np.log(found[k])))
    return k, found[k]


def targets(n):
    return (stiffness_targets(n) + settlement_targets(n) + force_targets(n) + ground_targets(n)
            + track_targets(n) + cost_targets(n))


def stiffness_targets(n):
    stiff = f"stiffness, {LAST}"
    found = [Target(f"stiffness of the bed, {TITLES[shape]} stones", "main",
                    f"around {published} MPa", mean(n, shape, stiff), "MPa", published, CLOSE,
                    each=tuple(of(n, shape, stiff)), see=BED)
             for shape, published in STIFFNESS.items()]
    stiffer, uncertain = ratio(n, stiff)
    steady = [last / before for last, before in zip(
        of_both(n, stiff), of_both(n, f"stiffness, {NEXT_TO_LAST}"))]
    return found + [
        Target("non-convex stones make the bed stiffer by", "main", "26 %", 100 * (stiffer - 1),
               "%", 26, 2 * CLOSE, sign=stiffer > 1, error=100 * uncertain, see=BED),
        Target(f"stiffness of the last cycle over that of the last but one, both shapes "
               f"(reproduced within {100 * STEADY:.0f} %)", "soft", "converges",
               float(np.mean(steady)), "", 1, STEADY, each=tuple(steady), see=BED)]


def settlement_targets(n):
    """Of the slice with two sleepers."""
    by, certain = less(n, SETTLED)
    found = [Target("two sleepers settle less with non-convex stones after the first cycle (sign "
                    "only; published are the lowest sleeper of a track and 50 cycles), by", "main",
                    "5 mm", by, "mm", holds=certain and by > 0,
                    error=error_of_difference(n, SETTLED),
                    see=BED if of(n, "convex", SETTLED, "long") else UNEXAMINED)]
    if len(of(n, "convex", "stones")) > 1:
        found.append(scatter_target(n, "this settlement", SETTLED))
    return found


def scatter_target(n, what, quantity, model="bed"):
    wider = scatter(n, "non_convex", quantity, model) / scatter(n, "convex", quantity, model)
    return Target(f"scatter of {what} between packings, non-convex over convex", "soft", "smaller",
                  wider, "", holds=wider < 1, see=UNEXAMINED)


def force_targets(n):
    """Of contacts, where the study has a total force on a stone that it does not define."""
    force = {shape: max(of(n, shape, "largest contact force")) for shape in SHAPES}
    k, alike = least_alike(n)
    return [
        *(Target(f"largest contact force, {title} stones (not comparable: largest of all samples; "
                 "published is a force on a stone)", "soft", f"{published:g} kN on a stone",
                 force[shape], "kN", published, CLOSE, see=UNEXAMINED)
          for shape, title, published in (("convex", "convex", 1.5),
                                          ("non_convex", "non-convex", 12))),
        Target("the same, non-convex over convex (not comparable)", "soft", "8",
               force["non_convex"] / force["convex"], "", 8, CLOSE, see=UNEXAMINED),
        Target("fraction of contacts in a bin of forces below 1 kN, non-convex over convex, where "
               "it differs most", "soft", "similar", alike, "", 1, CLOSE, see=UNEXAMINED)]


def ground_targets(n):
    """Of the ground alone."""
    tension, ends = (n(ground_run("elements of 0.2 m, free ends"), f"tension, {what}")
                     for what in ("largest", "largest near the ends"))
    where = n(GROUND_RUN, "tension, x of the largest")
    levels = [n(GROUND_RUN, f"compression, mean {part}") for part in ("up to 1.2 m", "from 4.8 m")]
    rise = n(GROUND_RUN, "compression, largest") / n(GROUND_RUN, "compression, median of peaks")
    peak = n(GROUND_RUN, "compression, x of the largest")
    return [
        Target("largest tension in the ground alone, elements of 0.2 m and free ends as in the "
               "study", "main", "0.1 MPa", tension, "MPa", 0.1, CLOSE, sign=tension > 1.5 * ends,
               see=ALONE),
        Target("x of the largest tension in the ground alone"
               + (", which lies at the edge of a loaded area" if at_edge(where) else ""), "main",
               "3 m, steepest stiffness", where, "m", 3, CLOSE, sign=2 < where < 4,
               see=ALONE),
        Target("largest compression, which must lie in the middle, over the median of the peaks "
               "below sleepers, ground alone", "main", "sudden increase", rise, "",
               holds=2 < peak < 4 and rise > 1, sign=rise > 1, see=ALONE),
        Target("mean compression at the stiff end over that at the soft end, ground alone (all "
               "sleepers bear the same load)", "input", "similar", levels[1] / levels[0], "", 1,
               CLOSE, see=ALONE),
        Target("distance of the peaks of the compression, ground alone", "input", "0.6 m",
               n(GROUND_RUN, "compression, median distance of peaks"), "m", 0.6, CLOSE, see=ALONE)]


def track_targets(n):
    """Of ten sleepers and a rail; none in the short form."""
    if not tracked(n):
        return []
    return settling_targets(n) + level_targets(n) + stress_targets(n)


def settling_targets(n):
    """How sleepers and rail sink on both shapes."""
    found = []
    for what, quantity, published in (
            ("the rail sinks less with non-convex stones after the first axle spacing, mean of "
             "three positions (sign only), by", "rail, growth", "7 to 9 mm in 50 cycles"),
            ("the same of the lowest sleeper", "lowest sleeper, growth", "5 mm in 50 cycles"),
            ("the rail is displaced less at the end, mean of three positions (sign only; contains "
             "the difference in the first axle spacing), by", END, "7 to 9 mm in 50 cycles"),
            ("the lowest of ten sleepers is displaced less at the end (sign only; contains the "
             "difference in the first axle spacing), by", LOWEST, "5 mm in 50 cycles")):
        by, certain = less(n, quantity, "track")
        found.append(Target(what, "main", published, by, "mm", holds=certain and by > 0,
                            error=error_of_difference(n, quantity, "track"), see=UNEXAMINED))
    return found + [
        Target("difference of the rail between both shapes in the first axle spacing over that at "
               "the end", "main", "small: both start alike", apart_at_start(n), "",
               holds=start_alike(n), see=UNEXAMINED),
        scatter_target(n, "the displacement of the lowest of ten sleepers", LOWEST, "track")]


def apart_at_start(n):
    """Difference of the rail between both shapes in the first axle spacing over that at the end."""
    end = less(n, END, "track")[0]
    return less(n, START, "track")[0] / end if end else np.inf


def start_alike(n):
    """Whether this is small, as in the study."""
    return abs(apart_at_start(n)) <= 2 * CLOSE


def apart_from_start(n):
    """Whether the shapes differ in the first axle spacing as at the end, and this is no chance."""
    return less(n, START, "track")[1] and apart_at_start(n) > 2 * CLOSE


def level_targets(n):
    """How much lower the rail is at both ends than in the middle."""
    found = []
    soft, middle, stiff = (of_both(n, f"rail, {place}, mean displacement", "track")
                           for place in RAIL)
    for end, levels in (("soft", soft), ("stiff", stiff)):
        each = tuple(a - b for a, b in zip(levels, middle))
        found.append(Target(f"displacement of the rail at the {end} end less that in the middle, "
                            "both shapes", "soft", "2.5 mm after 50 cycles", float(np.mean(each)),
                            "mm", 2.5, 2 * CLOSE, each=each, see=UNEXAMINED))
    return found


def stress_targets(n):
    """Of the ground below stones."""
    found = []
    for what in ("tension", "compression"):
        found.append(Target(f"largest {what} in the ground below stones, non-convex over convex",
                            "soft", "similar", ratio(n, f"{what}, largest", "track")[0], "", 1,
                            CLOSE, see=STRESSES))
    for what, kind, published, quantity, unit, value in (
            ("largest tension in the ground below convex stones", "main", "0.1 MPa",
             "tension, largest", "MPa", 0.1),
            ("x of this tension", "main", "3 m, steepest stiffness", "tension, x of the largest",
             "m", 3)):
        each = of(n, "convex", quantity, "track")
        found.append(Target(what, kind, published, float(np.mean(each)), unit, value, CLOSE,
                            each=tuple(each), see=STRESSES))
    where = of_both(n, "compression, x of the largest", "track")
    middle, ends, spikes = (tuple(of_both(n, f"compression, {what}", "track")) for what in (
        "middle over the median of peaks", "stiff end over soft end", "median distance of peaks"))
    return found + [
        Target("compression below stones, both shapes: largest between 2 and 4 m over the median "
               "of the peaks; the largest of the track must lie there", "main", "sudden increase",
               float(np.mean(middle)), "", each=middle,
               holds=all(2 < x < 4 for x in where) and min(middle) > 1, see=STRESSES),
        Target("mean compression at the stiff end over that at the soft end, below stones, both "
               "shapes", "soft", "similar", float(np.mean(ends)), "", 1, CLOSE, each=ends,
               see=STRESSES),
        Target("distance of the peaks of the compression, below stones, both shapes", "soft",
               "0.6 m", float(np.mean(spikes)), "m", 0.6, CLOSE, each=spikes, see=STRESSES)]


def cost_targets(n):
    if not n.has("cost_convex"):
        return []
    found = []
    theirs = [(fem + coupling) / dem
              for _, dem, fem, coupling in (BENCHMARK["minutes"][shape] for shape in SHAPES)]
    for model in (TWO_RATES, TEN_RATES) if tracked(n) else (TWO_RATES,):
        found.append(Target(
            f"time of elements and coupling over that of the stones, {model}, convex stones "
            "(required: below 1)", "main", " and ".join(f"{each:.2g}" for each in theirs)
            + " (convex and non-convex)", besides(n, "convex", model), "",
            holds=besides(n, "convex", model) < 1, see=COST))
    return found + [
        Target("time per stone and step, non-convex over convex (below the published value: "
               "cheaper)", "soft", f"{SLOWER}", slower(n), "", SLOWER, CLOSE, see=UNEXAMINED)]
