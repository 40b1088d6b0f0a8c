"""Targets of the study shi, and values that follow from its numbers and lines."""
import numpy as np
import scipy.stats

from .shi_decks import DECK, DESIGNS, EDGE, LOAD, SPACING, TITLES
from .shi_runs import AXLE_AT, DECAY, KEPT, PACKINGS, S1
from .study import Target, change, percent

from trackbed_post import measures  # noqa: I001 (found by .study)


def full(numbers):
    """Whether the numbers are those of the full form."""
    return numbers.has("stones_none_1")


def cases(numbers, design):
    """Names of the runs with stones of a design, one per packing."""
    full = [f"stones_{design}_{packing}" for packing in PACKINGS]
    return full if numbers.has(full[0]) else [f"short_{design}"]


def values(numbers, design, quantity):
    """Of all packings that have it: those in which a support failed have no accelerations."""
    return [numbers(run, quantity) for run in cases(numbers, design)
            if (run, quantity) in numbers.rows]


def mean(numbers, design, quantity):
    return float(np.mean(values(numbers, design, quantity)))


def known(numbers, quantity, designs=tuple(DESIGNS)):
    """Whether each design has a packing with this quantity."""
    return all(values(numbers, design, quantity) for design in designs)


def jump(numbers, run):
    """kPa, from the largest stress of a node within a spacing before the edge to the least behind
    it."""
    return (numbers(run, "stress, most before the edge")
            - numbers(run, "stress, least behind the edge"))


def jump_of_means(numbers, run):
    return (numbers(run, "stress, mean before the edge")
            - numbers(run, "stress, mean behind the edge"))


def reduction(numbers, of):
    """Relative change of a jump by the wedge: of its mean over the packings."""
    none, wedge = (np.mean([of(numbers, run) for run in cases(numbers, design)])
                   for design in DESIGNS)
    return float(wedge / none - 1)


def load_of_seats():
    """N, the largest seat load of the four axles together: each lifts the seats of others."""
    time = np.linspace(0, 2, 20001)
    s = LOAD["speed"] * time[:, None] + LOAD["start"] - np.array(LOAD["axles"])
    decay = DECAY * np.abs(s)
    return float((LOAD["peak"] * np.exp(-decay) * (np.cos(decay) + np.sin(decay))).sum(
        axis=1).max())


def line(numbers, figure, run):
    """x, m, and y of a line of a figure."""
    return map(np.array, numbers.lines.of(figure)[run])


def lines_of(numbers, figure, design):
    """x, m, and y [packing, x] of the packings that have this line."""
    found = [line(numbers, figure, run) for run in cases(numbers, design)
             if run in numbers.lines.of(figure)]
    x, y = zip(*found)
    return x[0], np.array(y)


def steepest(numbers, run, end):
    """mm/m, the steepest downward change of the surface up to x = `end`, m."""
    x, down = line(numbers, "ground", run)
    return np.gradient(measures.smoothed(x, down, SPACING), x)[x < end].max()


def at_last_node(numbers, design):
    """x, m, of the last node of the surface that belongs to the structure, and its displacement in
    each packing, mm."""
    x, down = lines_of(numbers, "ground", design)
    last = np.flatnonzero(x < EDGE)[-1]
    return x[last], tuple(down[:, last])


def at_four_metres(numbers, design):
    """Displacement of the surface 4 m behind the edge over its largest value, in each packing."""
    x, down = lines_of(numbers, "ground", design)
    return [np.interp(EDGE + 4, x, each) / each.max() for each in down]


def place_of_most(numbers, figure, design):
    """x, m, of the largest value in each packing."""
    x, found = lines_of(numbers, figure, design)
    return x[found.argmax(axis=1)]


def spectral_heights(numbers, design):
    """Of the sleepers' accelerations in each packing: their amplitude near v/(9.0 m) over the
    largest, and how many other peaks are higher."""
    heights, higher = [], []
    for run in cases(numbers, design):
        name = f"{run}, acceleration"
        if name in numbers.lines.of("spectra"):
            frequency, size = line(numbers, "spectra", name)
            at = np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])) + 1
            here = size[at[np.abs(frequency[at] - numbers(run, "v/L_c, acceleration")).argmin()]]
            heights.append(here / size.max())
            higher.append(np.count_nonzero(size[at] > here))
    return heights, higher


def lost(numbers):
    """Packings in which a sleeper loses its support in a passage, and the number of passages."""
    found = {packing: sum(numbers(f"stones_{design}_{packing}", "kept, most") > KEPT
                          for design in DESIGNS) for packing in PACKINGS}
    return [packing for packing, count in found.items() if count], sum(found.values())


MEAN_STRESS = 1e-3 * load_of_seats() / (SPACING * DECK["thickness"])  # kPa, on a sleeper spacing
WHEEL_LOAD = 2 * LOAD["peak"] / (DECAY * SPACING)  # N, to which the seat load belongs
UP_TO = EDGE - SPACING / 2  # m, where the surface of the structure is searched: see put_surface
CORRELATED = 0.38  # rank correlation of 27 places that chance exceeds in 5 % of cases
PUBLISHED_STONES = 2600  # kg/m3
ROUNDED = 0.25  # relative, of values given with one digit
CLOSE = 0.15    # relative, of values with two or three digits that are shown as curves
SPECTRA = 0.03  # relative, of frequencies
PRESCRIBED = 0.01  # relative, of what the deck prescribes
SPECTRAL_LINES = {"v/L_c": ("9.0 m", 2.0), "v/L_w": ("2.8 m", 6.5)}  # distance; published, Hz


def targets(n):
    first = cases(n, "wedge")[0]
    far = {"none": "ground, 6 to 11 m", "wedge": "ground, far"}
    if (first, far["none"]) not in n.rows:
        far["none"] = far["wedge"]  # a shorter ground
    return [*input_targets(), *spectra_targets(n), *surface_targets(n, far), *rise_targets(n),
            *stress_targets(n), *sleeper_targets(n), *acceleration_targets(n), *ballast_targets(n),
            *increase_targets(n),
            *moving_targets(n), *other_targets(n)]


SURFACE_SECTION, AT_EDGE, SLEEPERS_SECTION, PREPARATION_SECTION = (
    "Displacement of the surface", "Stress at the edge", "Sleepers and ballast", "Preparation")
BOTH_SECTIONS = f"{SLEEPERS_SECTION}, {PREPARATION_SECTION}"


def unexplained(section):
    return f"{section}: not explained"


def compare(n, what, design, quantity, kind, published, unit, value, close, sign=None, see=""):
    return compare_each(f"{what}, {TITLES[design]}", kind, published, values(n, design, quantity),
                        unit, value, close, sign=sign, see=see)


def compare_each(what, kind, published, each, unit, value, close, **more):
    each = tuple(map(float, each))
    return Target(what, kind, published, float(np.mean(each)), unit, value, close, each=each,
                  **more)


def input_targets():
    return [Target("delay from sleeper to sleeper", "input", "32.14 ms",
                   1e3 * SPACING / LOAD["speed"], "ms", 32.14, PRESCRIBED),
            Target("wheel load to which the seat load belongs", "input", "153.64 kN",
                   1e-3 * WHEEL_LOAD, "kN", 153.64, PRESCRIBED),
            Target("largest seat load of an axle over this wheel load", "input", "46.3 %",
                   100 * LOAD["peak"] / WHEEL_LOAD, "%", 46.3, PRESCRIBED)]


def spectra_targets(n):
    """Those of sleepers check that they follow the prescribed load."""
    for mark, (what, published) in SPECTRAL_LINES.items():
        for of, quantity, kind in (("sleepers", "acceleration", "input"),
                                   ("ballast", "ballast acceleration", "soft")):
            if not all(known(n, f"{mark}, {each}") for each in (quantity, "seat force")):
                continue
            for design in DESIGNS:
                load, peak = mean(n, design, f"{mark}, seat force"), values(n, design,
                                                                           f"{mark}, {quantity}")
                off = np.mean(peak) / published - 1
                # The record of one bogie is too short for a sign.
                judged = kind == "input" and known(n, "v/L_c, acceleration")
                yield compare_each(
                    f"spectral peak of {of} near v/({what}), judged by the peak of the load at "
                    f"{load:.2f} Hz (from the published value it deviates by {percent(off)}), "
                    f"{TITLES[design]}",
                    kind, f"{published} Hz", peak, "Hz", load, SPECTRA,
                    sign=abs(np.mean(peak) / load - 1) <= SPECTRA if judged else None,
                    see=SLEEPERS_SECTION)


def surface_targets(n, far):
    less = {design: mean(n, design, "ground, structure") < 0.2 * mean(n, design, far[design])
            for design in DESIGNS}
    for design in DESIGNS:
        yield compare(n, f"surface of the structure, largest up to x = {UP_TO:g} m", design,
                      "ground, structure", "main", "0.02 mm", "mm", 0.02, ROUNDED, less[design],
                      SURFACE_SECTION)
        x, last = at_last_node(n, design)
        yield compare_each(f"surface of the structure at its last node, x = {x:.2f} m, "
                           f"{TITLES[design]}", "soft", "0.02 mm", last, "mm", 0.02, ROUNDED,
                           see=SURFACE_SECTION)
    yield compare(n, "surface 6 to 11 m behind the structure" if "6 to 11" in far["none"] else
                  "surface in the last 2 m of the bed", "none", far["none"], "main", "1.8 mm",
                  "mm", 1.8, CLOSE, less["none"], unexplained(SURFACE_SECTION))
    yield compare(n, "surface in the last 2 m of the bed", "wedge", far["wedge"], "main",
                  "1.64 mm", "mm", 1.64, CLOSE, less["wedge"], unexplained(SURFACE_SECTION))


def rise_targets(n):
    widths = {design: mean(n, design, "ground, 90 % of the rise") for design in DESIGNS}
    here = {design: np.mean(at_four_metres(n, design)) for design in DESIGNS}
    return [
        Target("distance behind the structure with 90 % of the displacement of plain track, "
               f"without wedge (at 4 m the surface has {here['none']:.2f} of its largest value)",
               "main", "all within 4 m", widths["none"], "m", holds=widths["none"] <= 4,
               sign=widths["none"] < widths["wedge"]),
        Target("this distance with wedge; it follows from the assumed outline (at 4 m the surface "
               f"has {here['wedge']:.2f} of its largest value)", "main", "gradual, no number",
               widths["wedge"], "m", holds=widths["wedge"] > 2 * widths["none"],
               sign=widths["wedge"] > widths["none"])]


def stress_targets(n):
    see = unexplained(f"{AT_EDGE}, {PREPARATION_SECTION}")
    places = place_of_most(n, "stress", "none")
    return [
        compare(n, "largest stress of a node of the surface before the edge", "none",
                "stress, most before the edge", "main", "165 kPa", "kPa", 165, CLOSE, see=see),
        compare(n, "least stress of a node of the surface behind the edge", "none",
                "stress, least behind the edge", "main", "27 kPa", "kPa", 27, CLOSE, see=see),
        Target("change of the difference of these two by the wedge", "main", "-54 %",
               100 * reduction(n, jump), "%", -54, CLOSE, sign=reduction(n, jump) < 0, see=see),
        Target("x of the largest stress of a node, without wedge", "soft",
               f"2 m (ours: within {SPACING:g} m of it)", float(np.mean(places)), "m",
               holds=bool(np.all(np.abs(places - EDGE) < SPACING)), each=tuple(places),
               see=unexplained(AT_EDGE))]


def sleeper_targets(n):
    yield compare(n, "sleeper nearest to the edge", "none", "sleeper, nearest to the edge",
                  "soft", "0.75 mm, hardly legible", "mm", 0.75, CLOSE, see=PREPARATION_SECTION)
    if known(n, "sleeper S1"):
        yield compare(n, f"sleeper S1 (here at x = {S1:g} m)", "wedge", "sleeper S1", "soft",
                      "1.7 mm", "mm", 1.7, CLOSE, see=unexplained(BOTH_SECTIONS))
    for figure, what in (("sleeper", "sleepers"), ("ballast", "ballast below sleepers")):
        yield compare_each(f"distance behind the structure of the largest displacement of {what}, "
                           "without wedge", "soft", "about 2 m",
                           place_of_most(n, figure, "none") - EDGE, "m", 2, ROUNDED,
                           see=unexplained(SLEEPERS_SECTION))


def acceleration_targets(n):
    for design, low, high in (("none", 0.62, 1.34), ("wedge", 0.61, 1.57)):
        if known(n, "acceleration, least", (design,)):
            for which, quantity, value in (("smallest", "least", low), ("largest", "most", high)):
                met = which == "largest" and design == "none"
                yield compare(n, f"{which} of the sleepers' largest accelerations", design,
                              f"acceleration, {quantity}", "soft", f"{value} g", "g", value, CLOSE,
                              see=PREPARATION_SECTION if met else unexplained(BOTH_SECTIONS))
    both = in_both(n, "acceleration, most")
    if both:
        ratio = tuple(n(wedge, "acceleration, most") / n(none, "acceleration, most")
                      for none, wedge in both)
        yield Target("largest of these accelerations with wedge over that without", "soft",
                     f"more than 1 ({1.57 / 1.34:.2f})", float(np.mean(ratio)), "",
                     holds=min(ratio) > 1, each=ratio, see=unexplained(SLEEPERS_SECTION))
    if known(n, "acceleration at S2", ("wedge",)):
        ratio = [b / a for a, b in zip(values(n, "wedge", "acceleration at S1"),
                                       values(n, "wedge", "acceleration at S2"))]
        yield Target("largest acceleration of sleeper S2 over that of S1, with wedge",
                     "soft", "slightly above 1 (ours: below 1.5)",
                     float(np.mean(ratio)), "",
                     holds=min(ratio) > 1 and max(ratio) < 1.5, each=tuple(ratio),
                     see=unexplained(SLEEPERS_SECTION))


def in_both(n, quantity):
    """Pairs of runs without and with wedge on the same stones that both have a quantity."""
    return [(none, wedge) for none, wedge in zip(cases(n, "none"), cases(n, "wedge"))
            if (none, quantity) in n.rows and (wedge, quantity) in n.rows]


def ballast_targets(n):
    rough = "ballast acceleration, fluctuation"
    both = in_both(n, rough)
    if not both:
        return

    def undivided(run):
        return np.abs(np.diff(list(line(n, "ballast acceleration", run))[1])).mean()
    for how, found in (
            ("divided by its mean, which the wedge lowers, too",
             [change(n, none, wedge, rough) for none, wedge in both]),
            ("not divided", [undivided(wedge) / undivided(none) - 1 for none, wedge in both])):
        each = tuple(100 * value for value in found)
        yield Target("change by the wedge of the ballast's fluctuation of acceleration along the "
                     f"track, {how}", "soft", "decrease", float(np.mean(each)), "%",
                     holds=max(each) < 0, each=each, see=unexplained(SLEEPERS_SECTION))


def increase_targets(n):
    """Whether accelerations of the ballast increase along the track with wedge."""
    found = [line(n, "ballast acceleration", run) for run in cases(n, "wedge")
             if run in n.lines.of("ballast acceleration")]
    if not found:
        return
    each = tuple(float(scipy.stats.spearmanr(*one)[0]) for one in found)
    yield Target(f"rank correlation of the ballast's accelerations with x, with wedge (ours: above "
                 f"{CORRELATED})", "soft", "gradual increase", float(np.mean(each)), "",
                 holds=min(each) > CORRELATED, each=each, see=unexplained(SLEEPERS_SECTION))


def moving_targets(n):
    """What moves while the first axle is at a place."""
    if known(n, "sleepers moving down ahead"):
        for design in reversed(DESIGNS):
            yield compare(n, "sleepers that move down ahead of the first axle", design,
                          "sleepers moving down ahead", "soft", "3", "", 3, ROUNDED,
                          see=SLEEPERS_SECTION)
    for design in DESIGNS if n.has("maps_none") else ():
        def of(what, at, run=f"maps_{design}"):
            return n(run, f"{what} of cells of ground, axle at {at} m")
        speeds = [of("largest velocity", at) for at in AXLE_AT]
        where = n(f"maps_{design}", f"x of the largest velocity, ground, axle at {AXLE_AT[-1]} m")
        shown = " (the study shows it with wedge)" if design == "none" else ""
        yield Target(f"largest velocity of the ground, first axle at {AXLE_AT[-1]} m (found at x = "
                     f"{where:g} m, at the end of the ground) over at {AXLE_AT[0]} m, "
                     f"{TITLES[design]}{shown}", "soft", "increases", speeds[-1] / speeds[0], "",
                     holds=bool(np.all(np.diff(speeds) > 0)), see=SLEEPERS_SECTION)


def other_targets(n):
    ratio = PUBLISHED_STONES / DECK["material"][0]["density"]
    dense = [ratio * each for each in values(n, "wedge", "bulk density")]
    ways = {way: mean(n, "none", f"soil {way} the structure, largest")
            for way in ("away from", "towards")}
    return [
        compare_each("bulk density, if stones had the published 2600 kg/m3", "soft",
                     "about 1800 kg/m3", dense, "kg/m3", 1800, CLOSE, see=unexplained("Set-up")),
        Target("largest displacement of the soil away from the structure over that towards it, "
               "without wedge (the study shows directions of acceleration)", "soft", "away",
               ways["away from"] / ways["towards"], "",
               holds=ways["away from"] > ways["towards"])]
