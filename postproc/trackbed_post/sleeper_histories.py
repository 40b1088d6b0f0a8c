"""The figure sleepers.png: histories of three sleepers in the passage, below the train.

A colour and a marker stand for a sleeper, a line for a run, so that grey prints can be read, too.
"""
import collections.abc
import itertools

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from trackbed_post import ground_blocks, measures, panels, read, signals, train_strip
from trackbed_post.bed_figures import needs

GRAVITY = 9.81  # m/s^2
FILTER = signals.LowPass()
WIDE = 9        # inches

Runs = collections.abc.Sequence[read.Results]


def _since_begin(run: read.Results) -> np.ndarray:
    """Displacement of each sleeper since the passage began, mm, up, [time, sleeper]."""
    moved = run.sleeper["displacement"].values[run.passage()]
    return 1e3 * (moved - moved[0])


def _lowest_words(runs: Runs) -> str:
    """The lowest displacement of the sleepers that are not at the ends of the bed, in words."""
    left_out = measures.without_ends(*runs)
    lowest = (f"{run.name} {_since_begin(run)[:, ~ground_blocks.ends(run)].min():.3f} mm"
              for run in runs)
    return f"lowest of all sleepers: {', '.join(lowest)}{f' ({left_out})' if left_out else ''}"


def _values(run: read.Results, time: np.ndarray) -> list[np.ndarray]:
    """What the panels show, [time, sleeper]."""
    rows = run.passage()
    return [_since_begin(run), -run.sleeper["seat_force"].values[rows] / 1e3,
            run.sleeper["reaction"].values[rows] / 1e3,
            FILTER(time, run.sleeper["acceleration"].values[rows]) / GRAVITY]


def _plot(below: collections.abc.Iterable[Axes], run: read.Results, time: np.ndarray,
          line: str) -> None:
    for panel, values in zip(below, _values(run, time)):
        for number, k in enumerate(measures.chosen_sleepers(run)):
            panel.plot(time, values[:, k], line, lw=1, **panels.curve(number, len(time)),
                       label=f"{run.name}, x = {run.sleepers_x[k]:.2f} m")


def _key(runs: Runs) -> list[Line2D]:
    """What the legend shows: each sleeper, and of several runs the line of each."""
    found = []
    for number, same in enumerate(itertools.zip_longest(
            *([f"{run.sleepers_x[k]:.2f} m" for k in measures.chosen_sleepers(run)]
              for run in runs))):
        places = list(dict.fromkeys(filter(None, same)))
        found.append(Line2D([], [], lw=1, label=f"sleeper at x = {' or '.join(places)}",
                            **panels.curve(number, 1)))
    if len(runs) > 1:
        found += [Line2D([], [], color="0.2", lw=1.2, ls=line, label=f"run {run.name}")
                  for run, line in zip(runs, panels.LINES)]
    return found


def draw(runs: Runs) -> plt.Figure:
    """Displacement, seat load, reaction and filtered acceleration in the passage."""
    needs(all(len(run.sleepers_x) and run.sleeper for run in runs), "no sleepers")
    train = train_strip.of_passage(runs[0])
    places = [train_strip.Place(runs[0].sleepers_x[k], f"x = {runs[0].sleepers_x[k]:.2f} m",
                                f"C{number}")
              for number, k in enumerate(measures.chosen_sleepers(runs[0]))]
    figure, below = train_strip.panels_below(train, places, 4, (WIDE, 10))
    for run, line in zip(runs, panels.LINES):
        time = run.time[run.passage()] - run.time[run.passage()][0]
        _plot(below, run, time, line)
    stage = "passage" if all(run.has_passage() for run in runs) else "last stage"
    labels = (f"displacement since the\n{stage} began,\n{panels.UP}", "seat load (kN, down)",
              "reaction of stones (kN, up)", f"acceleration (g)\n{FILTER.name_for(time)}")
    for panel, label in zip(below, labels):
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
    train_strip.mark_all(below, train, places)
    below[-1].set_xlabel(f"time since the {stage} began (s)")
    key = _key(runs)
    panels.legend_below(below[-1], len(key), handles=key)
    below[-1].get_legend().set_title(measures.without_ends(*runs) or None, {"size": 8})
    figure.axes[0].set_title(panels.wrapped(
        f"Sleepers during the {measures.passage_words(runs)}; {_lowest_words(runs)}", WIDE, 11),
        fontsize=11)
    return figure
