"""Figures of the bed: quantities in regions, contact forces, grading and surface of the stones."""
import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import contact_forces, measures, read
from trackbed_post.panels import LINES, MARKERS, curve, plain_ticks, wrapped

COLOURS = ("C0", "C1")
STAGE_LINES = (":", "--", "-.")  # where stages of all runs begin, of the first, of the second


class Missing(Exception):
    """The run does not have the data that the figure needs."""


def needs(holds, what):
    if not holds:
        raise Missing(what)


def mark_stages(panels, runs):
    """Thin lines where stages of all runs begin, with other dashes where those of one run do. A run
    that starts after another one begins with a stage, too."""
    first = min(run.time[0] for run in runs)
    begins = [{float(time) for time in run.time[1:][np.diff(run.stage) != 0]}
              | ({float(run.time[0])} - {float(first)}) for run in runs]
    common = set.intersection(*begins)
    parts = [("a stage begins", common)] + [(f"a stage of {run.name} begins", own - common)
                                            for run, own in zip(runs, begins)]
    for (words, instants), line in zip(parts, STAGE_LINES):
        for panel in panels:
            for number, begin in enumerate(sorted(instants)):
                panel.axvline(begin, color="0.4", lw=0.8, ls=line, label="_" if number else words)


def regions(runs):
    """Quantities in the deck's regions over the run; the mean over the cells of a region."""
    needs(all(run.regions for run in runs), "the results contain no regions")
    shown = [("porosity", "porosity", 1.0), ("coordination", "coordination number", 1.0),
             ("stress", "vertical\ncompression (kPa)", -1e-3),
             ("largest_stone_force", "largest sum of forces\non a stone (kN)", 1e-3),
             ("speed", "mean speed\nof stones (mm/s)", 1e3)]
    shown = [one for one in shown if all(one[0] in region for run in runs
                                         for region in run.regions.values())]
    figure, panels = plt.subplots(len(shown), 1, sharex=True, figsize=(9, 2 + 2 * len(shown)))
    for run, style in zip(runs, ("-", "--")):
        for number, (name, region) in enumerate(run.regions.items()):
            for panel, (quantity, label, factor) in zip(panels, shown):
                values = region[quantity].values
                values = values[:, :, 2] if values.ndim == 3 else values
                panel.plot(run.time, factor * values.mean(axis=1), style, lw=1,
                           label=f"{run.name}: {name}", **curve(number, len(run.time)))
                panel.set_ylabel(label)
    mark_stages(panels, runs)
    for panel in panels:
        panel.grid(alpha=0.3)
    panels[0].legend(fontsize=8)
    panels[0].set_title("Stones in the regions of the deck", fontsize=10)
    panels[-1].set_xlabel("simulated time (s)")
    return figure


def forces(runs):
    """Distribution of contact forces divided by their mean, at the instant of contact_forces."""
    found = [contact_forces.of_run(run) for run in runs]
    needs(all(found), "the results contain no contact forces")
    figure, panel = plt.subplots(figsize=(7, 5))
    for run, forces_of, colour, marker in zip(runs, found, COLOURS, MARKERS):
        force = forces_of.values
        shares, density = measures.force_distribution(force)
        panel.plot(shares, density, marker + "-", ms=3, lw=1, color=colour,
                   label=f"{run.name}: {len(force)} contacts, mean {force.mean():.3g} N")
    panel.set_title(wrapped("Contact forces: " + "; ".join(
        f"{run.name}, {one.words}" for run, one in zip(runs, found)), 7), fontsize=10)
    panel.set_yscale("log")
    panel.set_xlabel("contact force / mean contact force")
    panel.set_ylabel("probability density")
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8)
    return figure


def grading(runs):
    """Sieve curve of the stones at the end of the last stage, with prescription and limits."""
    needs(all(run.stones for run in runs), "the results contain no stones")
    figure, panel = plt.subplots(figsize=(7, 5))
    for run, colour, style in zip(runs, COLOURS, LINES):
        stage, stones = list(run.stones.items())[-1]
        sizes = np.sort(stones.sieved[:, 0])
        panel.plot(sizes * 1e3, measures.passing(stones.sieved, sizes), style, color=colour, lw=1.5,
                   label=f"{run.name}, {len(sizes)} stones at the end of {stage}")
    panel.set_xscale("log")
    plain_ticks(panel)
    if len(runs[0].grading):   # absent for stones of another run or of several layers
        opening, asked, least, most = runs[0].grading.T
        panel.plot(opening * 1e3, asked, "ko", ms=4, label="prescribed")
        if np.any(least < most):
            panel.fill_between(opening * 1e3, least, most, color="0.8", zorder=0,
                               label=f"limits of {runs[0].deck['bed']['grading']}")
        panel.set_xticks(opening * 1e3, [f"{mm:g}" for mm in opening * 1e3])
    prescribed = "" if len(runs[0].grading) else \
        "\nno curve is prescribed for stones of another run or of several layers"
    panel.set_title(f"Sieve curves of the stones by mass{prescribed}", fontsize=10)
    panel.set_xlabel("sieve (mm)")
    panel.set_ylabel("passing (% of mass)")
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8)
    return figure


def outline(run, y):
    """z of the outline prescribed by the deck above each y: the cut of the last stage with a
    profile, at most the height to which the bed is compacted (unless a stage fills cribs, or with
    layers, which have heights of their own); None without a profile."""
    bed = run.deck["bed"]
    shaping = [stage for stage in run.deck.get("stage", []) if stage.get("profile", 0) > 0]
    if not shaping:
        return None
    crest = bed.get("crest") or [-np.inf, np.inf]
    cut = shaping[-1]["profile"] - np.maximum.reduce([
        np.zeros_like(y), crest[0] - y, y - crest[1]]) / bed["slope"]
    filled = bed.get("layer") or any(stage.get("kind") == "cribs" for stage in shaping)
    return cut if filled else np.minimum(cut, bed.get("height", np.inf))


def profile(rows):
    """Axis (0 along, 1 across the track), places on it, and lowest, mean and highest top of the
    stones there; a plane model is shown along the track. Places without stones are omitted."""
    axis = 1 if len(np.unique(rows[:, 1])) > 1 else 0
    rows = rows[np.isfinite(rows[:, 2])]
    places = np.unique(rows[:, axis])
    tops = [rows[rows[:, axis] == place, 2] for place in places]
    return axis, places, *(np.array([of(z) for z in tops]) for of in (np.min, np.mean, np.max))


def section(runs):
    """The bed's surface at the end of the last stage, across the track; a plane bed's along it."""
    needs(all(run.surface for run in runs), "the results contain no surface of the bed")
    figure, panel = plt.subplots(figsize=(8, 4))
    for run, colour, style in zip(runs, COLOURS, LINES):
        stage, rows = list(run.surface.items())[-1]
        axis, places, low, mean, high = profile(rows)
        if axis == 1:
            panel.fill_between(places, low, high, color=colour, alpha=0.25, lw=0,
                               label="lowest to highest along the track")
        panel.plot(places, mean, style, color=colour, label=f"{run.name}, end of {stage}"
                   + (", mean along the track" if axis == 1 else ""))
        asked = outline(run, places if axis == 1 else np.zeros_like(places))
        if asked is not None:
            panel.plot(places, np.maximum(asked, 0), "k--", lw=1,
                       label="outline given in the input (bed.height, profile of a stage)")
        panel.set_xlabel(("x along", "y across")[axis] + " the track (m)")
    where = "across the track; mean, lowest and highest along it" if axis == 1 else \
        "along the track"
    panel.set_title(f"Top of the stones {where}", fontsize=10)
    panel.set_ylabel("top of the stones (m)")
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8)
    return figure


def breakage(runs):
    """Parts that broke off: their number over time, their places, how many below each sleeper, and
    the grading before and after, with the ballast breakage index."""
    needs(all(run.breaks for run in runs), "nothing can break in these runs")
    column = read.BREAK
    figure, (counts, places, sieves) = plt.subplots(3, 1, figsize=(8, 10))
    shown = []
    for run, colour, mark in zip(runs, COLOURS, "ox"):
        last = list(run.breaks)[-1]
        rows = measures.parts_broken(run, last)
        rows = rows[np.argsort(rows[:, column["time"]])]
        fragments = np.cumsum(rows[:, column["fragment"]] >= 0)
        time = rows[:, column["time"]]
        counts.step(time, fragments, where="post", color=colour, label=f"{run.name}: fragments")
        counts.step(time, np.arange(1, len(rows) + 1) - fragments, "--", where="post",
                    color=colour, label=f"{run.name}: fines")
        places.scatter(rows[:, column["x"]], rows[:, column["z"]], marker=mark, color=colour,
                       s=(2e3 * rows[:, column["diameter"]])**2 / 8, alpha=0.6,
                       label=f"{run.name}: {len(rows)} parts")
        if run.deck.get("sleepers", {}).get("count", 0) > 0:
            near, below, _ = measures.breaks_by_sleeper(run, last)
            shown.append(f"{run.name}, near each sleeper (below it): "
                         + ", ".join(f"{a} ({b})" for a, b in zip(near, below)))
        stages = measures.stages_of_breakage(run)
        if stages is None:
            continue
        curves = [measures.sieved_with_fines(run, stage) for stage in stages]
        sizes = np.unique(np.concatenate([of[:, 0] for of in curves]))
        before, after = (measures.passing(of, sizes) for of in curves)
        index = measures.breakage_index(sizes, before, after)
        sieves.plot(1e3 * sizes, before, "--", color=colour, lw=1, label=f"{run.name}, {stages[0]}")
        sieves.plot(1e3 * sizes, after, color=colour, lw=1.5,
                    label=f"{run.name}, {stages[1]}: BBI {index:.4f}")
    counts.set(xlabel="simulated time (s)", ylabel="parts that broke off")
    places.set_title("\n".join(shown), fontsize=8)
    places.set(xlabel="x along the track (m)", ylabel="z (m)", aspect="equal")
    sieves.set(xlabel="sieve (mm)", ylabel="passing (% of mass)")
    for panel in (counts, places, sieves):
        panel.grid(alpha=0.3)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(fontsize=8)
    return figure


def bonds(runs):
    """Whole bonds, from the first stage with bonds on, without those of removed stones; places of
    whole and broken ones at the end."""
    needs(all(any(len(b.whole) + len(b.broken) for b in run.bonds.values()) for run in runs),
          "these runs have no bonds")
    figure, panels = plt.subplots(1 + len(runs), 1, figsize=(8, 4 + 3 * len(runs)))
    for run, colour, places in zip(runs, COLOURS, panels[1:]):
        last = list(run.bonds.values())[-1]
        first = next(name for name, b in run.bonds.items() if len(b.whole) + len(b.broken))
        number = [stage["name"] for stage in run.deck["stage"]].index(first)
        times = np.sort(last.broken[:, read.BROKEN["time"]])
        begin = min([*run.time[run.stage == number], *times, run.time[-1]])
        left = len(last.whole) + np.arange(len(times), -1, -1)
        panels[0].step([begin, *times, run.time[-1]], [*left, left[-1]], where="post",
                       color=colour, label=f"{run.name}: {len(times)} of {left[0]} broke")
        for rows, column, words, look in (
                (last.whole, read.WHOLE, "whole", {"marker": ".", "color": "0.6"}),
                (last.broken, read.BROKEN, "broken", {"marker": "x", "color": colour})):
            places.scatter(rows[:, column["x"]], rows[:, column["z"]], s=16,
                           label=f"{len(rows)} {words}", **look)
        places.set(xlabel="x along the track (m)", ylabel="z (m)", aspect="equal", title=run.name,
                   label=run.name)
    panels[0].set(xlabel="simulated time (s)", ylabel="whole bonds")
    for panel in panels:
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    return figure


FIGURES = {"regions": regions, "forces": forces, "grading": grading, "section": section,
           "breakage": breakage, "bonds": bonds}
