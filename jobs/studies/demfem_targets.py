"""Targets of the study demfem, and the statistics of packings that they are judged by."""
import numpy as np

from .demfem_model import BENCHMARK, CORES, GROUND_RUN, LAST, PACKINGS, RAIL, SETTLED, SHAPES
from .study import Target

BED, TEN, COST = "Convex and non-convex stones", "Ten sleepers and a rail", "Cost"
CLOSE = 0.15  # relative, of values given as "around"; twice that of the difference of two


def of(numbers, shape, quantity, model="bed"):
    """Of all packings; models are bed and bars (two sleepers) and track (ten)."""
    return [numbers(f"{model}_{shape}_{packing}", quantity) for packing in PACKINGS
            if numbers.has(f"{model}_{shape}_{packing}")]


def mean(numbers, shape, quantity, model="bed"):
    return float(np.mean(of(numbers, shape, quantity, model)))


def error(numbers, shape, quantity, model="bed"):
    """Standard error of the mean over the packings; 0 of one packing."""
    found = of(numbers, shape, quantity, model)
    return float(np.std(found, ddof=1) / len(found)**0.5) if len(found) > 1 else 0.0


def error_of_difference(numbers, quantity, model="bed"):
    """Standard error of the difference of the means of both shapes."""
    return float(np.hypot(*(error(numbers, shape, quantity, model) for shape in SHAPES)))


def less(numbers, quantity, model="bed"):
    """By how much the mean of convex stones exceeds that of non-convex ones, and whether it differs
    from 0 by twice the standard error of the difference."""
    by = mean(numbers, "convex", quantity, model) - mean(numbers, "non_convex", quantity, model)
    many = len(of(numbers, "convex", quantity, model)) > 1
    return by, many and abs(by) > 2 * error_of_difference(numbers, quantity, model)


def predicted(numbers, shape, cores=CORES):
    """Minutes of stones and of the ground's hexahedra for the study's benchmark, from the measured
    rates."""
    run, bench = f"cost_{shape}", BENCHMARK
    steps = bench["duration"] / bench["stone_step"], bench["duration"] / bench["element_step"]
    return (bench["stones"][shape] * steps[0]
            / numbers(run, "stone steps per second and core") / cores / 60,
            bench["elements"] * steps[1]
            / numbers(run, "element steps per second and core") / cores / 60)


def targets(n):
    stiff = f"stiffness, {LAST}"
    stiffness = {shape: mean(n, shape, stiff) for shape in SHAPES}
    ratio = stiffness["non_convex"] / stiffness["convex"]
    by, certain = less(n, SETTLED)
    ratios = tuple(b / a for a, b in zip(of(n, "convex", stiff), of(n, "non_convex", stiff)))
    found = [
        Target("stiffness of the bed, convex stones", "main", "around 430 MPa",
               stiffness["convex"], "MPa", 430, CLOSE, each=tuple(of(n, "convex", stiff)), see=BED),
        Target("stiffness of the bed, non-convex stones", "main", "around 540 MPa",
               stiffness["non_convex"], "MPa", 540, CLOSE, each=tuple(of(n, "non_convex", stiff)),
               see=BED),
        Target("non-convex stones make the bed stiffer by", "main", "26 %", 100 * (ratio - 1), "%",
               26, 2 * CLOSE, sign=ratio > 1, each=tuple(100 * (each - 1) for each in ratios),
               see=BED),
        Target("sleepers settle less with non-convex stones after the first cycle, by", "main",
               "5 mm in 50 cycles", by, "mm", holds=certain and by > 0, see=BED)]
    if len(of(n, "convex", "stones")) > 1:
        scatter = {shape: float(np.std(of(n, shape, SETTLED), ddof=1)) for shape in SHAPES}
        found.append(Target(
            "scatter of this settlement between packings, non-convex over convex", "soft",
            "smaller", scatter["non_convex"] / scatter["convex"], "",
            holds=scatter["non_convex"] < scatter["convex"], see=BED))
    force = {shape: max(of(n, shape, "largest contact force")) for shape in SHAPES}
    tension, ends = (n(GROUND_RUN, f"tension, {what}")
                     for what in ("largest", "largest near the ends"))
    where = n(GROUND_RUN, "tension, x of the largest")
    levels = [n(GROUND_RUN, f"compression, mean {part}") for part in ("up to 1.2 m", "from 4.8 m")]
    rise = n(GROUND_RUN, "compression, largest") / n(GROUND_RUN, "compression, median of peaks")
    peak = n(GROUND_RUN, "compression, x of the largest")
    found += [
        Target("largest contact force, convex stones", "soft", "1.5 kN on a stone",
               force["convex"], "kN", 1.5, CLOSE, see=BED),
        Target("largest contact force, non-convex stones", "soft", "12 kN on a stone",
               force["non_convex"], "kN", 12, CLOSE, see=BED),
        Target("largest tension in the ground", "main", "0.1 MPa", tension, "MPa", 0.1, CLOSE,
               sign=tension > 1.5 * ends),
        Target("x of the largest tension", "main", "3 m, steepest stiffness", where, "m", 3, CLOSE,
               sign=2 < where < 4),
        Target("largest compression, in the middle, over the median of the peaks below sleepers",
               "main", "sudden increase", rise, "", holds=2 < peak < 4 and rise > 1,
               sign=rise > 1),
        Target("mean compression at the stiff end over that at the soft end", "soft",
               "similar", levels[1] / levels[0], "", 1, CLOSE)]
    found += track_targets(n)
    if n.has("cost_convex"):
        slower = (n("cost_convex", "stone steps per second and core")
                  / n("cost_non_convex", "stone steps per second and core"))
        found.append(Target("time per stone and step, non-convex over convex", "soft", "3.0",
                            slower, "", 3, CLOSE, see=COST))
    return found


def track_targets(n):
    """Of ten sleepers and a rail; none in the short form."""
    if not of(n, "convex", "simulated", "track"):
        return []
    found = []
    for what, quantity, published in (
            ("the lowest of ten sleepers is", "mean displacement of the lowest sleeper", 5),
            *((f"the rail at the {place} is", f"rail, {place}, mean displacement", mm)
              for place, mm in zip(RAIL, (7, 9, 7)))):
        by, certain = less(n, quantity, "track")
        found.append(Target(f"{what} less displaced with non-convex stones, by", "main",
                            f"{published} mm in 50 cycles", by, "mm", holds=certain and by > 0,
                            see=TEN))
    for what in ("tension", "compression"):
        both = [mean(n, shape, f"{what}, largest", "track") for shape in SHAPES]
        found.append(Target(f"largest {what} in the ground below stones, non-convex over convex",
                            "soft", "similar", both[1] / both[0], "", 1, CLOSE, see=TEN))
    tension = mean(n, "convex", "tension, largest", "track")
    where = mean(n, "convex", "tension, x of the largest", "track")
    return found + [
        Target("largest tension in the ground below convex stones", "main", "0.1 MPa", tension,
               "MPa", 0.1, CLOSE, each=tuple(of(n, "convex", "tension, largest", "track")),
               see=TEN),
        Target("x of this tension", "main", "3 m, steepest stiffness", where, "m", 3, CLOSE,
               each=tuple(of(n, "convex", "tension, x of the largest", "track")), see=TEN)]
