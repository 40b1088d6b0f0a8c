"""The figure support.png: that of bed_histories.py with marks on sleepers that hang."""
from trackbed_post import bed_histories, panels, support


def draw(runs):
    """Stiffness and gap of all sleepers; those that hang have a ring."""
    figure = bed_histories.draw_support(runs)
    loops, stiff, gaps = figure.axes
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
    stiff.set_title("Secants to the largest reaction;\nwith ground: gap included", fontsize=10)
    for panel in (loops, stiff, gaps):
        panels.legend_below(panel)
    return figure
