"""Parts of a track over a transition: structure, transition, plain track.

One definition for the rail (transition.txt), the ground's surface (table.txt) and sleepers
(warnings): plain track begins behind the places where both rail and ground have changed by most of
the difference. It needs the level of plain track, which in turn depends on where that begins: both
are found by repetition. Definitions: docs/postproc.md.
"""
import collections.abc
import dataclasses

import numpy as np

from trackbed_post import axles, ground_blocks, measures, read
from trackbed_post.measures import NOWHERE, TINY

Runs = collections.abc.Sequence[read.Results]
Levels = collections.abc.Sequence[np.ndarray]  # of each run, lowest level of the rail, m down
REACHED = 0.9    # the transition ends where this fraction of the change is reached


@dataclasses.dataclass(frozen=True)
class Zone:
    """Which sleepers are judged, [sleeper]: on the structure, on plain track, and from the last of
    the former to the first of the latter, both included, so that each space between two sleepers
    belongs to one part; `distance`, m, from the edge into the soft ground."""
    distance: np.ndarray
    structure: np.ndarray
    transition: np.ndarray
    plain: np.ndarray

    @property
    def last(self) -> float:
        """Distance of the last sleeper that is judged, m."""
        return float(self.distance[self.plain].max())

    @property
    def parts(self) -> dict[str, np.ndarray]:
        """The same with each sleeper in one part only."""
        return {"on the structure": self.structure,
                "in the transition": self.transition & ~self.structure & ~self.plain,
                "on plain track": self.plain}


def zone_of(run: read.Results, changing: float) -> Zone | None:
    """The Zone of a run; `changing`: distance from the edge, m, over which the track changes. None
    without a structure, or without sleepers in one of its parts."""
    edge, ends = ground_blocks.edge_of_structure(run), ground_blocks.structure(run)
    if edge is None or ends is None:
        return None
    x, spacing = run.sleepers_x, measures.spacing(run)
    distance = ground_blocks.direction(run, edge) * (x - edge)
    begin, end = ground_blocks.plain_track(run, edge, changing, spacing)
    judged = ~ground_blocks.ends(run)
    structure = judged & (x >= ends[0] - TINY) & (x <= ends[1] + TINY) & (
        distance <= -spacing + TINY)
    plain = judged & (distance >= begin - TINY) & (distance <= end + TINY)
    if min(np.count_nonzero(structure), np.count_nonzero(plain)) < 2:
        return None
    between = (distance >= distance[structure].max() - TINY) & (
        distance <= distance[plain].min() + TINY)
    return Zone(distance, structure, between, plain)


def rail_down(run: read.Results) -> np.ndarray:
    """Lowest level of the rail above each sleeper under the last train, m down, relative to the row
    before it; of two rails the mean. Empty without a train on a rail."""
    if "displacement" not in run.rail or not run.has_passage():
        return np.empty(0)
    level = run.rail["displacement"].values[run.passage()]
    if "x" in run.wheel:
        x = axles.of_wheels(run.wheel["x"].values[run.passage()])
        if not (trains := axles.rows_of_trains(x)):
            return np.empty(0)
        level = level[trains[-1]][axles.row_before_train(x[trains[-1], 0], run.sleepers_x[0]):]
    down = level[0] - level.min(axis=0)
    return down.reshape(len(run.sleepers_x), -1).mean(axis=1)


def rail_width(zone: Zone, level: np.ndarray) -> float:
    """Distance behind the edge at which the level, linear between sleepers, first reaches
    REACHED of the change from the structure to the plain track of this run; nan if it does not up
    to the last sleeper that is judged, as those behind it stand beside springs."""
    structure, plain = float(np.mean(level[zone.structure])), float(np.median(level[zone.plain]))
    order = np.argsort(zone.distance)
    distance, level = zone.distance[order], level[order]
    goal = structure + REACHED * (plain - structure)
    at = np.concatenate([[0], distance[(distance > TINY) & (distance <= zone.last + TINY)]])
    there = (np.interp(at, distance, level) - goal) * np.sign(plain - structure)
    reached = np.flatnonzero(there >= 0)
    if not len(reached):
        return NOWHERE
    k = reached[0]
    return float(np.interp(0, there[k - 1:k + 1], at[k - 1:k + 1])) if k else 0.0


def rail_widths(runs: Runs, levels: Levels, changing: float) -> list[float]:
    """That of each run with a rail."""
    return [rail_width(zone, level) for run, level in zip(runs, levels)
            if len(level) and (zone := zone_of(run, changing))]


@dataclasses.dataclass(frozen=True)
class Surface:
    """The ground's surface in the passage, by the distance from the edge into the soft ground, m;
    displacements downwards, m, also smoothed over one spacing, and compression, Pa."""
    distance: np.ndarray
    down: np.ndarray
    smooth: np.ndarray
    compression: np.ndarray
    on_structure: float  # m, largest displacement on the structure


def surface_of(run: read.Results) -> Surface | None:
    """None without a structure, or without envelopes of the ground."""
    edge, ends = ground_blocks.edge_of_structure(run), ground_blocks.structure(run)
    if edge is None or ends is None or measures.why_no_envelope(run):
        return None
    distance = ground_blocks.direction(run, edge) * (run.ground_x - edge)
    order = np.argsort(distance)
    distance = distance[order]
    down, compression = (-run.ground_envelope[name].values[order]
                         for name in ("displacement_min", "sigma_z_min"))
    there = (distance <= TINY) & (distance >= ends[0] - ends[1] - TINY)
    return Surface(distance, down, measures.smoothed(distance, down, measures.spacing(run)),
                   compression, float(np.max(down[there])))


def plain_nodes(run: read.Results, surface: Surface, changing: float) -> np.ndarray:
    """Which nodes are on plain track: none if it is shorter than a sleeper spacing."""
    edge, reach = ground_blocks.edge_of_structure(run), measures.spacing(run)
    begin, end = (NOWHERE, NOWHERE) if edge is None else \
        ground_blocks.plain_track(run, edge, changing, reach)
    if not end - begin >= reach - TINY:
        return np.zeros(len(surface.distance), dtype=bool)
    return (surface.distance >= begin - TINY) & (surface.distance <= end + TINY)


def ground_width(surface: Surface, plain: np.ndarray) -> float:
    """Distance from the edge to the node where the smooth displacement first reaches REACHED of the
    change from the structure to plain track; nan if never, or without plain track."""
    if not plain.any():
        return NOWHERE
    start, end = surface.on_structure, float(np.median(surface.down[plain]))
    reached = np.flatnonzero((surface.distance > TINY) & (
        (surface.smooth - start) * np.sign(end - start) >= REACHED * abs(end - start)))
    return float(surface.distance[reached[0]]) if len(reached) else NOWHERE


def ground_widths(runs: Runs, changing: float) -> list[float]:
    """That of each run with a ground."""
    return [ground_width(surface, plain_nodes(run, surface, changing))
            for run in runs if (surface := surface_of(run))]


def changing(runs: Runs, levels: Levels = ()) -> float:
    """Distance from the edge, m, over which the track of these runs changes, which have the same
    edge: to the end of the longest measure, and to where rail and ground of each run reach REACHED
    of the change. `levels`: by default those of `rail_down`."""
    levels = levels or [rail_down(run) for run in runs]
    found = max(ground_blocks.wedge_length(run) for run in runs)
    while True:
        widths = [*rail_widths(runs, levels, found), *ground_widths(runs, found)]
        farthest = max(filter(np.isfinite, widths), default=0.0)
        if farthest <= found + TINY:
            return found
        found = farthest


def changing_of_each(runs: Runs, levels: Levels = ()) -> list[float]:
    """The same for each run: common to all if their edges are at the same place."""
    levels = levels or [rail_down(run) for run in runs]
    if all(ground_blocks.same_edge(runs[0], run) for run in runs[1:]):
        return [changing(runs, levels)] * len(runs)
    return [changing([run], [level]) for run, level in zip(runs, levels)]
