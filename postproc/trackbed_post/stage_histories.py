"""Histories of sleepers and platen over all stages of a run, a column for each stage: how the bed
came into the state in which a train or load passes over it.
"""
import collections.abc
import dataclasses
import functools

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import measures, read
from trackbed_post.bed_figures import needs
from trackbed_post.panels import LINES, UP, curve, wrapped

WIDTH = 2.6           # inches of a column
MOST = 8              # columns: of more stages the last ones are shown


@dataclasses.dataclass(frozen=True)
class Row:
    """A quantity: label, and its values of a run, [time, line]."""
    label: str
    of: collections.abc.Callable[[read.Results], np.ndarray]
    sleepers: bool = True  # a line for each sleeper shown


def names_of(run: read.Results) -> list[str]:
    return [stage.get("name", "") for stage in run.deck.get("stage", [])]


def settled(run: read.Results) -> np.ndarray:
    """Displacement of the sleepers, mm, up, since they were placed."""
    return 1e3 * run.sleeper["displacement"].values


def load(name: str, factor: float, run: read.Results) -> np.ndarray:
    return factor * run.sleeper[name].values


def pressure(run: read.Results) -> np.ndarray:
    return run.platen["pressure"].values.reshape(len(run.time), 1) / 1e3


def placed(run: read.Results) -> np.ndarray:
    """Whether the sleepers exist in each row."""
    kinds = [stage.get("kind") for stage in run.deck.get("stage", [])]
    return run.stage >= (kinds.index("sleepers") if "sleepers" in kinds else 0)


def rows_of(runs: collections.abc.Sequence[read.Results]) -> list[Row]:
    """What all runs have."""
    found = [Row("pressure of the\nplaten (kPa)", pressure, False)] if all(
        loaded(run).any() for run in runs) else []
    if all(len(run.sleepers_x) and "displacement" in run.sleeper for run in runs):
        found.append(Row(f"displacement since\nplaced ({UP})", settled))
    for name, label, factor in (
            ("seat_force", "seat load, with the\ndeck's seat_force\n(kN, down)", -1e-3),
            ("reaction", "reaction of\nstones (kN, up)", 1e-3)):
        if all(name in run.sleeper and len(run.sleepers_x) for run in runs):
            found.append(Row(label, functools.partial(load, name, factor)))
    return found


def loaded(run: read.Results) -> np.ndarray:
    """Whether the platen applies a load in each row."""
    values = run.platen.get("pressure", read.NOTHING).values.ravel()
    return values > 0 if len(values) else np.zeros(len(run.time), bool)


def shown_stages(run: read.Results) -> list[str]:
    """Names of the stages in which the platen applies a load or sleepers are there."""
    shown = loaded(run) | (placed(run) if len(run.sleepers_x) else False)
    return [name for number, name in enumerate(names_of(run))
            if np.any((run.stage == number) & shown)][-MOST:]


def shown_in_any(runs: collections.abc.Sequence[read.Results]) -> list[str]:
    """Those of all runs in their order; what only a later run has is behind the stage before it."""
    found: list[str] = []
    for run in runs:
        place = 0
        for name in shown_stages(run):
            if name not in found:
                found.insert(place, name)
            place = found.index(name) + 1
    return found[-MOST:]


def only_in(runs: collections.abc.Sequence[read.Results], shown: list[str]) -> list[str]:
    """Words for the stages that some of the runs have not, or of which they show nothing."""
    return [f"{', '.join(names)} not in {run.name}" for run in runs
            if (names := [name for name in shown if name not in shown_stages(run)])]


def draw_stage(panels: collections.abc.Sequence[plt.Axes], run: read.Results, stage: str,
               rows: list[Row], style: str) -> None:
    """One stage of one run, in a column of panels."""
    names = names_of(run)
    here = np.flatnonzero(run.stage == (names.index(stage) if stage in names else -1))
    if not len(here):
        return
    time = run.time[here] - run.time[here][0]
    for panel, row in zip(panels, rows):
        values = row.of(run)[here]
        if not row.sleepers:
            if not loaded(run)[here].any():
                continue
            panel.plot(time, values[:, 0], style, lw=1, color="k", label=run.name)
            continue
        if not placed(run)[here].any():
            continue
        for number, k in enumerate(measures.chosen_sleepers(run)):
            panel.plot(time, values[:, k], style, lw=0.9, **curve(number, len(time)),
                       label=f"{run.name}, x = {run.sleepers_x[k]:.2f} m")


def label(panels: np.ndarray, rows: list[Row], shown: list[str]) -> None:
    """Titles and labels at the outermost panels with lines; the others remain empty."""
    for panel in panels.ravel():
        panel.grid(alpha=0.3)
        if not panel.lines:
            panel.set_axis_off()
    for stage, column in zip(shown, panels.T):
        if full := [panel for panel in column if panel.lines]:
            full[0].set_title(f"stage {stage}", fontsize=10)
            full[-1].set_xlabel("time in the stage (s)")
            full[-1].tick_params(labelbottom=True)
    for row, line in zip(rows, panels):
        if full := [panel for panel in line if panel.lines]:
            full[0].set_ylabel(row.label)
            full[0].tick_params(labelleft=True)


def stages(runs: collections.abc.Sequence[read.Results]) -> plt.Figure:
    """Histories of the platen and of three sleepers in each stage."""
    rows, shown = rows_of(runs), shown_in_any(runs)
    needs(rows, "neither sleepers nor a platen")
    needs(len(shown) > 1, "only one stage has sleepers or a platen that applies a load")
    figure, panels = plt.subplots(len(rows), len(shown), sharex="col", sharey="row", squeeze=False,
                                  figsize=(2 + WIDTH * len(shown), 1.5 + 2 * len(rows)))
    for column, stage in zip(panels.T, shown):
        for panel in column:
            panel.set_label(f"stage {stage}")
        for run, style in zip(runs, LINES):
            draw_stage(column, run, stage, rows, style)
    label(panels, rows, shown)
    key = {text: line for panel in panels.ravel()
           for line, text in zip(*panel.get_legend_handles_labels())}
    panels[-1, 0].legend(key.values(), key.keys(), fontsize=7,
                         title=measures.without_ends(*runs) or None, title_fontsize=7)
    title = "From stage to stage: " + ", ".join(run.name for run in runs)
    figure.suptitle(wrapped("; ".join([title, *only_in(runs, shown)]), figure.get_figwidth()),
                    fontsize=10)
    return figure


FIGURES = {"stages": stages}
