"""The figure support.png: what carries each sleeper."""
import matplotlib.pyplot as plt

from trackbed_post import measures, panels, support
from trackbed_post.bed_figures import needs


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
            panel.plot(x[hangs], values[hangs], "o", ms=9, mfc="none", mec="k", mew=1, label=label)
            label = "_"  # in one legend, once


def draw(runs):
    """Reaction of the stones over the displacement of three sleepers relative to the ground in the
    passage; stiffness of the support and gap of all sleepers; those that hang have a ring."""
    needs(all(len(run.sleepers_x) and run.sleeper for run in runs), "no sleepers")
    figure, (loops, stiff, gaps) = plt.subplots(1, 3, figsize=(14, 4.6))
    text = []
    for run, style in zip(runs, panels.LINES):
        found = support.of(run)
        for number, k in enumerate(measures.chosen_sleepers(run)):
            loops.plot(found.lowered[:, k] * 1e3, found.reaction[:, k] / 1e3, style, lw=0.8,
                       color=f"C{number}", label=f"{run.name}, x = {run.sleepers_x[k]:.2f} m")
        for number, (of, what) in enumerate(((found.bed, "bed alone"),
                                             (found.whole, "with ground"))):
            stiff.plot(run.sleepers_x, of / 1e6, style, marker="o", ms=3, lw=1, color=f"C{number}",
                       label=f"{run.name}, {what}")
        line, = gaps.plot(run.sleepers_x, found.gap * 1e3, style, marker="o", ms=3, lw=1,
                          label=run.name)
        last = run is runs[-1]
        for panel, values, colour in ((stiff, found.bed / 1e6, "C0"),
                                      (stiff, found.whole / 1e6, "C1"),
                                      (gaps, found.gap * 1e3, line.get_color())):
            panels.mark_ends(panel, run.sleepers_x, values, found.ends, colour,
                             last and colour != "C0")
        text.append(f"{run.name}: {found.words()}")
    loops.set_xlabel("sleeper lowered relative to the ground (mm)")
    loops.set_ylabel("reaction of the stones (kN)")
    loops.set_title(f"Loops in the {runs[0].passage_name()}", fontsize=10)
    stiff.set_ylabel("stiffness of the support (kN/mm)")
    stiff.set_ylim(bottom=0)
    stiff.set_title("Secants from the row before the train to the largest\nreaction; bed alone: "
                    "without gap and ground", fontsize=10)
    gaps.set_ylabel("gap below the sleeper (mm)")
    gaps.set_title("\n".join(text), fontsize=10)
    for panel in (stiff, gaps):
        panel.set_xlabel("x along the track (m)")
    for panel in (loops, stiff, gaps):
        panel.grid(alpha=0.3)
    mark_hanging(runs, stiff, gaps)
    for panel in (loops, stiff, gaps):
        panels.legend_below(panel)
    return figure
