"""The figure support.png: what carries each sleeper."""
import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import figure_csv, ground_blocks, measures, panels, support
from trackbed_post.bed_figures import needs

COLUMN = 14 / 3  # inches, of a panel with its labels
APART = 0.12     # of a panel's diagonal, between two marks of a loop


def mark_hanging(runs, stiff, gaps):
    """Rings around the values of sleepers that hang."""
    label = f"hangs: gap above {1e3 * support.HANGS:g} mm"
    for run in runs:
        found = support.of(run)
        x, hangs = run.sleepers_x, found.hangs
        if not hangs.any():
            continue
        for panel, values in ((stiff, found.bed / 1e6), (stiff, found.whole / 1e6),
                              (gaps, found.gap * 1e3)):
            rings, = panel.plot(x[hangs], values[hangs], "o", ms=9, mfc="none", mec="k", mew=1,
                                label=label)
            figure_csv.name(rings, f"{run.name}, hangs")
            label = "_"  # in one legend, once


def explain_secants(runs, panel):
    """Title of the panel of stiffnesses."""
    train = all(run.has_passage() and ground_blocks.carried_by_springs(run) for run in runs)
    ground = any(measures.has_ground(run) for run in runs)
    unclear = sum(np.count_nonzero(support.of(run).unclear) for run in runs)
    panel.set_title(f"Secants from the {'row before the train' if train else 'first row'} to the "
                    "largest\nreaction; bed alone: without gap" + (" and ground" if ground else "")
                    + ("; left out where a\nsleeper is then down by less than 2/3 of its "
                       f"maximum: {unclear}" if unclear else ""), fontsize=10)


def draw(runs):
    """Reaction of the stones over the displacement of three sleepers relative to the ground in the
    passage; stiffness of the support and gap of all sleepers; those that hang have a ring."""
    needs(all(len(run.sleepers_x) and run.sleeper for run in runs), "no sleepers")
    figure, (loops, stiff, gaps) = plt.subplots(1, 3, figsize=(3 * COLUMN, 4.6))
    text = []
    for run, style in zip(runs, panels.LINES):
        found = support.of(run)
        for number, k in enumerate(measures.chosen_sleepers(run)):
            # At rest there are many points in one place: marks are along the loop.
            look = panels.curve(number, 1) | {"markevery": (APART * number / 3, APART)}
            loops.plot(found.lowered[:, k] * 1e3, found.reaction[:, k] / 1e3, style, lw=0.8,
                       **look, label=f"{run.name}, x = {run.sleepers_x[k]:.2f} m")
        both = "with gap and ground" if measures.has_ground(run) else "with gap"
        for number, (of, what) in enumerate(((found.bed, "bed alone"), (found.whole, both))):
            stiff.plot(run.sleepers_x, of / 1e6, style, marker=panels.MARKERS[number], ms=3, lw=1,
                       color=f"C{number}", label=f"{run.name}, {what}")
        gaps.plot(run.sleepers_x, found.gap * 1e3, style, marker="o", ms=3, lw=1, label=run.name)
        name = panels.END if run is runs[-1] else panels.HIDDEN
        bed, whole = stiff.lines[-2:]
        panels.mark_ends(stiff, bed, found.ends, panels.HIDDEN)
        panels.mark_ends(stiff, whole, found.ends, name)
        panels.mark_ends(gaps, gaps.lines[-1], found.ends, name)
        text.append(panels.wrapped(f"{run.name}: {found.words()}", COLUMN))
    beside = " relative to the ground" if any(map(measures.has_ground, runs)) else ""
    loops.set_xlabel(f"sleeper lowered{beside} (mm)")
    loops.set_ylabel("reaction of the stones (kN)")
    loops.set_title(panels.wrapped(f"Loops in the {measures.passage_words(runs)}", COLUMN),
                    fontsize=10)
    stiff.set_ylabel("stiffness of the support (kN/mm)")
    stiff.set_ylim(bottom=0)
    explain_secants(runs, stiff)
    gaps.set_ylabel("gap below the sleeper (mm)")
    gaps.set_title("\n".join(text), fontsize=10)
    for panel in (stiff, gaps):
        panel.set_xlabel("x along the track (m)")
    for panel in (loops, stiff, gaps):
        panel.grid(alpha=0.3)
    mark_hanging(runs, stiff, gaps)
    for panel in (loops, stiff, gaps):
        panels.legend_below(panel, wide=COLUMN)
    return figure
