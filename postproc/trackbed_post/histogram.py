"""Histograms of a dataset of results.h5, of several runs over each other.

A history counts all its rows, or those of one stage. What is computed: docs/postproc.md.
"""
import collections.abc
import dataclasses
import pathlib

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import contact_forces, curves, panels, read, track_along, track_figures, write

CONTACT_FORCE = "contact_force"  # at the instant of contact_forces, or at the end of a stage
BINS = 40
QUANTILES = {"least": 0, "5 %": 5, "median": 50, "95 %": 95, "largest": 100}


@dataclasses.dataclass(frozen=True)
class Choices:
    """`stage`: its rows, or contact forces at its end, without it under load; `place`: number of
    the column, None for all; `change`: difference from the first number of each column; `log`: axis
    of the shares."""
    stage: str = ""
    place: int | None = None
    change: bool = False
    bins: int = BINS
    log: bool = False


@dataclasses.dataclass(frozen=True)
class Sample:
    """Values of a run, SI; `name` for legends, `left_out`: how many were not numbers, `without`:
    stages that do not count, as there was no such body; `instant`: of contact forces, in words."""
    name: str
    values: np.ndarray
    unit: str
    left_out: int = 0
    without: tuple[str, ...] = ()
    instant: str = ""


def _known(every: read.Quantities) -> list[str]:
    return [name for name, item in every.items() if item.values.dtype.kind in "fiu"]


def _contact_forces(path: pathlib.Path, name: str, stage: str) -> Sample:
    """At the end of the stage, or at the instant of contact_forces."""
    run = read.results(path)
    found = contact_forces.of_run(run) if not stage else None
    if stage in run.chains:
        found = contact_forces.Forces(run.chains[stage].force, contact_forces.words_of(run, stage))
    if not found or not len(found.values):
        stages = ", ".join(f"chains/{one}/force" for one in run.chains)
        raise read.Unreadable(f"there are no contact forces{f' of a stage {stage}' * bool(stage)}; "
                              f"there are {stages or 'none of any stage'}")
    return Sample(name, found.values, "N", instant=found.words)


def _of_history(values: np.ndarray, dataset: str, every: read.Quantities, deck: read.Deck,
                stage: str) -> np.ndarray:
    """The rows [time, place] of a history with its body, or those of the stage; nan for wheels of a
    track alone that are not between its run-ins, where the program writes forces, too."""
    if dataset.startswith("history/wheel/") and "history/stage" not in every and "track" in deck:
        between = track_figures.between_run_ins(every, deck["track"]["length"],
                                                track_figures.run_in_of(deck))
        values = np.where(between, values, np.nan)
    return values[read.rows_of_stage(every, deck, stage) if stage
                  else ~read.rows_without_body(every, dataset)]


def _stages_without_body(every: read.Quantities, deck: read.Deck, dataset: str) -> tuple[str, ...]:
    rows = read.rows_without_body(every, dataset)
    names = [str(one.get("name")) for one in deck.get("stage", [])]
    return tuple(names[k] for k in np.unique(every["history/stage"].values[rows])) \
        if rows.any() else ()


def _changes(values: np.ndarray) -> np.ndarray:
    """Differences of each column from its first number."""
    first = np.argmax(np.isfinite(values), axis=0)
    return values - np.take_along_axis(values, first[None, :], axis=0)


def _values_of(every: read.Quantities, deck: read.Deck, dataset: str,
               choices: Choices) -> np.ndarray:
    """The values [row, place] that count; nan for those that do not."""
    values = every[dataset].values
    values = values.reshape(len(values), -1).astype(float)
    if dataset.startswith("history/"):
        values = _of_history(values, dataset, every, deck, choices.stage)
    elif values.shape[1] > 1 and choices.place is None:
        raise read.Unreadable(f"{dataset} has {values.shape[1]} columns ({every[dataset].meaning}; "
                              f"{every[dataset].unit}): choose one with --place, from 0")
    if choices.place is not None:
        if not 0 <= choices.place < values.shape[1]:
            raise read.Unreadable(f"--place {choices.place}: {dataset} has the places 0 to "
                                  f"{values.shape[1] - 1}")
        values = values[:, [choices.place]]
    return _changes(values) if choices.change and len(values) else values


def _unit_of(units: str, place: int | None) -> str:
    """That of a column, of a dataset that lists units; the last one counts for all further ones."""
    each = units.split(", ")
    return each[min(place or 0, len(each) - 1)]


def sample_of(path: pathlib.Path, quantity: str, name: str, choices: Choices) -> Sample:
    if quantity == CONTACT_FORCE:
        if choices.change or choices.place is not None:
            read.require_history(quantity, "change from a first row, and no places")
        return _contact_forces(path, name, choices.stage)
    every, deck = read.datasets(path), read.origin(path)[1]
    if quantity not in _known(every):
        raise read.Unreadable(f"{name} has no dataset {quantity}; it has {CONTACT_FORCE} and "
                              f"{', '.join(_known(every))}")
    if choices.stage:
        read.require_history(quantity, f"rows of a stage {choices.stage}")
    if choices.change:
        read.require_history(quantity, "change from a first row")
    values = _values_of(every, deck, quantity, choices)
    kept = values[np.isfinite(values)]
    if not len(kept):
        raise read.Unreadable(f"{name}: {quantity} has no numbers here")
    without = () if choices.stage or not quantity.startswith("history/") else \
        _stages_without_body(every, deck, quantity)
    return Sample(name, kept, _unit_of(every[quantity].unit, choices.place),
                  values.size - len(kept), without)


def edges_of(samples: collections.abc.Sequence[Sample], bins: int) -> np.ndarray:
    """Common edges of the bins; if all values are equal, they are in the middle of one bin."""
    low = min(float(one.values.min()) for one in samples)
    high = max(float(one.values.max()) for one in samples)
    if low < high:
        return np.histogram_bin_edges([low, high], bins)
    wide = (abs(low) or 1.0) / bins
    return low + wide * (np.arange(bins + 1) - bins // 2 - 0.5)


def draw(samples: collections.abc.Sequence[Sample], edges: np.ndarray, label: str,
         choices: Choices) -> plt.Figure:
    """Fraction of the values in each bin, and of those up to each value."""
    factor, unit = curves.short_unit(float(np.abs(edges).max()), samples[0].unit)
    figure, (share, below) = plt.subplots(2, 1, sharex=True, figsize=(9, 7), layout="constrained")
    for number, one in enumerate(samples):
        style = panels.LINES[number % len(panels.LINES)]
        count = np.histogram(one.values, edges)[0] / len(one.values)
        line, = share.step(factor * edges, 100 * np.append(count, count[-1]), style, lw=1.4,
                           where="post", label=f"{one.name}: {len(one.values)} values, mean "
                           f"{factor * one.values.mean():.4g} {unit}")
        share.axvline(factor * one.values.mean(), color=line.get_color(), ls=style, lw=0.7,
                      label="_mean")
        below.plot(factor * edges, 100 * np.append(0, np.cumsum(count)), style, lw=1.4,
                   label=one.name)
    if choices.log:
        share.set_yscale("log")
    share.set_ylabel(f"fraction of the values in each of\n{len(edges) - 1} bins, %")
    share.set_title(panels.wrapped(f"{label} (thin: mean)" + "".join(
        f"\n{one.name}: {one.instant}" for one in samples if one.instant)
        + "\nwithout stages in which all histories of this group are zero" * any(
            one.without for one in samples), 9, 12))
    below.set(ylabel="fraction of the values up to x, %", xlabel=f"{label}, {unit}")
    for panel in (share, below):
        panel.grid(alpha=0.3)
    share.legend(fontsize=8)
    return figure


def as_csv(samples: collections.abc.Sequence[Sample], edges: np.ndarray) -> str:
    """Edges of the bins in SI units, and the number of values of each run in it."""
    unit = samples[0].unit.replace("/", "_")
    head = [f"from_{unit}", f"to_{unit}",
            *(f"count of {one.name}".replace(",", ";") for one in samples)]
    counts = [np.histogram(one.values, edges)[0] for one in samples]
    rows = [",".join([f"{low:.9g}", f"{high:.9g}", *map(str, numbers)])
            for low, high, *numbers in zip(edges, edges[1:], *counts)]
    return "\n".join([",".join(head), *rows]) + "\n"


def table_of(samples: collections.abc.Sequence[Sample], label: str) -> str:
    lines = [f"{label}, {samples[0].unit}"]
    for one in samples:
        ends = ", ".join(f"{name} {np.percentile(one.values, share):.4g}"
                         for name, share in QUANTILES.items())
        when = f" {one.instant}" if one.instant else ""
        lines.append(f"{one.name}{when}: {len(one.values)} values, mean {one.values.mean():.4g}, "
                     f"standard deviation {one.values.std():.4g}, {ends}"
                     + (f"; {one.left_out} values are left out" if one.left_out else "")
                     + (f"; without {', '.join(one.without)}, where all histories of this group "
                        "are zero" if one.without else ""))
    return "\n".join(lines) + "\n"


def draw_into(results: collections.abc.Sequence[pathlib.Path], folder: write.Folder,
              quantity: str, choices: Choices) -> None:
    """Picture, CSV and table of a dataset of runs, given by their folders."""
    folders = [read.folder_of(path) for path in results]
    samples = [sample_of(path, quantity, name, choices)
               for path, name in zip(folders, track_along.names_of(folders))]
    if len({one.unit for one in samples}) > 1:
        raise read.Unreadable("the runs have different units: "
                              + ", ".join(f"{one.name} {one.unit}" for one in samples))
    edges = edges_of(samples, choices.bins)
    label = quantity.replace("_", " ") if quantity == CONTACT_FORCE else quantity
    label += f" in stage {choices.stage}" if choices.stage and quantity != CONTACT_FORCE else ""
    label += ", change from the first number of each place" if choices.change else ""
    folder.picture("histogram", draw(samples, edges, label, choices))
    folder.file("histogram.csv", as_csv(samples, edges))
    folder.table("histogram.txt", table_of(samples, label))
