"""The train above histories over time: a row for each place, with vehicles and wheels at the times
at which they pass it. The train looks mirrored, as its front passes first; it has no arrow, since
arrows to the right mean its direction of travel along x in other figures.
"""
import collections.abc
import dataclasses

import matplotlib.patches
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from trackbed_post import axles, read

BODY = {"facecolor": "#dfe7ef", "edgecolor": "#2f4b66", "lw": 0.8}
OVERHANG = 2.0           # m, of a body beyond its outer axles, as in the drawing of the model
FLOOR, ROOF = 0.18, 0.62  # of a row, lower and upper edge of a body
HEIGHT = 0.42            # inches of a row


@dataclasses.dataclass(frozen=True)
class Place:
    """A place of histories, x in m, its words and the colour of its lines."""
    x: float
    words: str
    colour: str


@dataclasses.dataclass(frozen=True)
class Train:
    """x of each axle over time, [time, axle], nan where it is not on the track; names of the
    vehicles, front first."""
    time: np.ndarray
    x: np.ndarray
    vehicles: tuple[str, ...] = ()


def of_run(deck: read.Deck, time: np.ndarray, wheel_x: np.ndarray) -> Train | None:
    """The Train of rows of the histories; None without an axle on the track."""
    x = axles.of_wheels(wheel_x)
    names = tuple(map(str, deck.get("train", {}).get("vehicles", [])))
    return Train(time, x, names) if np.isfinite(x).any() else None


def of_passage(run: read.Results) -> Train | None:
    """The train over the rows of the passage, its time from their first one; None without one."""
    rows = run.passage()
    return of_run(run.deck, run.time[rows] - run.time[rows][0],
                  run.wheel["x"].values[rows]) if "x" in run.wheel else None


def times_at(train: Train, place: float) -> np.ndarray:
    """Times at which axles pass a place towards larger x, [train, axle], nan of those that do not;
    a stage may send several trains."""
    passes: list[list[float]] = []
    for x in train.x.T:
        with np.errstate(invalid="ignore"):
            rows = np.flatnonzero((x[:-1] < place) & (x[1:] >= place))
        passes.append([float(np.interp(place, x[row:row + 2], train.time[row:row + 2]))
                       for row in rows])
    most = max(map(len, passes), default=0)
    return np.array([[one[k] if k < len(one) else np.nan for one in passes]
                     for k in range(most)]).reshape(most, len(passes))


def _speed_at(train: Train, place: float) -> float:
    """Mean speed of the axles that pass a place, m/s."""
    passing = [np.gradient(x, train.time)[near] for x in train.x.T
               if (near := np.abs(x - place) < OVERHANG).sum() > 1 and len(x) > 1]
    return float(np.nanmean(np.concatenate(passing))) if passing else np.inf


def _vehicles(train: Train, times: np.ndarray) -> collections.abc.Iterator[tuple[str, np.ndarray]]:
    """Name and times of the axles of each vehicle, if all have axles at the same distances."""
    count = len(train.vehicles)
    known = count == 1 or axles.by_vehicle(train.x, count) is not None
    if known and len(times) > count:
        yield from zip(train.vehicles, np.split(times, count))


def _draw_row(panel: Axes, train: Train, place: Place, level: int) -> None:
    panel.hlines(level, *panel.get_xlim(), color=place.colour, lw=1.4)
    for times in times_at(train, place.x):
        panel.scatter(times, np.full(len(times), level + 0.08), s=22, color="0.2", zorder=3,
                      label="_axles")
        for name, own in _vehicles(train, times):
            if np.isnan(own).any():
                continue
            beyond = OVERHANG / _speed_at(train, place.x)
            begin, end = own.min() - beyond, own.max() + beyond
            panel.add_patch(matplotlib.patches.Rectangle(
                (begin, level + FLOOR), end - begin, ROOF - FLOOR, **BODY))
            panel.text((begin + end) / 2, level + (FLOOR + ROOF) / 2, name, fontsize=7,
                       ha="center", va="center", clip_on=True)
    panel.text(0.005, level + 0.1, place.words, fontsize=7, color=place.colour, va="bottom",
               transform=panel.get_yaxis_transform())


def draw(panel: Axes, train: Train, places: collections.abc.Sequence[Place]) -> None:
    """Fills a panel above histories over time, with which it shares the axis."""
    panel.set_xlim(train.time[0], train.time[-1])
    for number, place in enumerate(places):
        _draw_row(panel, train, place, len(places) - 1 - number)
    panel.set_ylim(-0.15, len(places) - 0.2)
    panel.set_yticks([])
    panel.set_ylabel("train as\nit passes,\nfront first", rotation=0, ha="right", va="center",
                     fontsize=8)
    panel.tick_params(labelbottom=False)


def mark(panel: Axes, train: Train, place: Place) -> None:
    """Thin lines at the times at which axles pass a place."""
    for time in np.ravel(times_at(train, place.x)):
        if np.isfinite(time):
            panel.axvline(time, color=place.colour, lw=0.6, ls=":", zorder=0)


def panels_below(train: Train | None, places: collections.abc.Sequence[Place], count: int,
                 size: tuple[float, float]) -> tuple[plt.Figure, list[Axes]]:
    """A figure of this size, inches, and its panels, which share the axis of time; above them the
    train, if there is one, for which the figure is higher. Draw, and then `mark_all`."""
    if train is None or not places:
        figure, panels = plt.subplots(count, 1, sharex=True, figsize=size)
        return figure, list(panels)
    high = HEIGHT * len(places)
    figure, (strip, *below) = plt.subplots(
        count + 1, 1, sharex=True, figsize=(size[0], size[1] + high),
        gridspec_kw={"height_ratios": [high, *[0.88 * size[1] / count] * count]})
    draw(strip, train, places)
    return figure, below


def mark_all(panels: collections.abc.Iterable[Axes], train: Train | None,
             places: collections.abc.Iterable[Place]) -> None:
    if train is None:
        return
    for panel in panels:
        for place in places:
            mark(panel, train, place)
