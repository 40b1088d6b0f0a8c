"""A train over a transition zone, and two designs of it compared, with and without a wedge.

The runs are plane models whose last passage has a train. Pictures: model (what is modelled, with
the contact forces when the stones carry most) and transition (wheel force, level of rail and
sleepers, settlement) with its curves as CSV; transition.txt holds numbers, and a verdict if the
runs differ by the wedge. Contact forces need field files within the passage
(`output.fields_interval`). Definition of the numbers: docs/postproc.md.
"""
import abc
import dataclasses
import typing

import numpy as np

from trackbed_post import (bed_warnings, ground_blocks, judgement, measures, model_drawing,
                           passage_warnings, read, train_figures, transition_caption,
                           transition_figures, transition_verdict, write, zones)
from trackbed_post.ground_blocks import ENDS
from trackbed_post.zones import REACHED, Zone, zone_of

BIN = 0.1            # m, of the curve of the largest wheel force along the track
LONG = 20            # characters of the names of blocks in the name of a run


class LoadedTrack(abc.ABC):
    """A run and what its train does to the track, on stones or on a ground of elements. Levels are
    downwards positive, m."""
    run: read.Results
    name: str
    stones: typing.ClassVar[bool]  # below the sleepers, which then settle
    spread: typing.ClassVar[str]   # what differs from place to place on plain track
    of_mean: typing.ClassVar[str]  # of which wheels mean_force() is the mean, in words

    @property
    def name_first(self):
        """The name as the first words of a sentence; that of a folder stays as it is."""
        return self.name if self.name.startswith(self.run.name) else \
            self.name[:1].upper() + self.name[1:]

    @property
    @abc.abstractmethod
    def axis(self):
        """Label of x."""

    @property
    def bin(self):
        """m, of the curve of the largest wheel force along the track."""
        return BIN

    @abc.abstractmethod
    def heading(self):
        """What runs over what."""

    @abc.abstractmethod
    def rail_down(self):
        """Lowest level of the rail above each sleeper."""

    @abc.abstractmethod
    def sleeper_down(self):
        """Lowest level of each sleeper."""

    @abc.abstractmethod
    def wheels(self):
        """x, m, and force, N, of all wheels on the track in all rows."""

    @abc.abstractmethod
    def mean_force(self):
        """Mean of wheel forces, N, about the static load."""

    def largest_force(self):
        """x, m, and the largest force of any wheel there, N, over the sleepers: in bins, x of their
        middles."""
        low, high = self.run.sleepers_x[[0, -1]]
        edges = np.arange(low, high + self.bin, self.bin)
        x, force = self.wheels()
        number = np.digitize(x, edges) - 1
        found = np.full(len(edges) - 1, np.nan)
        for k in np.intersect1d(number, np.arange(len(found))):
            found[k] = force[number == k].max()
        return (edges[:-1] + edges[1:]) / 2, found

    def largest_force_in(self, zone, low, high):
        """(N, x in m) of the largest force of any wheel between these distances from the edge, m,
        the second one excluded, in its row of the histories."""
        x, force = self.wheels()
        distance = np.interp(x, self.run.sleepers_x, zone.distance)
        x, force = x[there := (distance >= low) & (distance < high)], force[there]
        most = int(np.argmax(force))
        return float(force[most]), float(x[most])


@dataclasses.dataclass(frozen=True)
class Train(LoadedTrack):
    """The last train of a run over a bed; levels are relative to the last row before it comes to
    the bed."""
    run: read.Results
    passing: train_figures.Passing
    name: str = ""
    stones: typing.ClassVar[bool] = True
    spread: typing.ClassVar[str] = "scatter"
    of_mean: typing.ClassVar[str] = "all wheels on the bed"

    @property
    def axis(self):
        return "x along the track, m"

    def heading(self):
        return model_drawing.heading(self.run)

    def rail_down(self):
        return zones.rail_down(self.run)

    def sleeper_down(self):
        first = self.passing.first
        return self.passing.displacement[first] - self.passing.displacement[first:].min(axis=0)

    def unevenness(self):
        """Difference between the highest and the lowest sleeper before the train."""
        return np.ptp(self.passing.displacement[self.passing.first])

    def settlement(self):
        """Of each sleeper into the bed: relative to the ground below it, which still vibrates when
        the train has left."""
        lowered = measures.ground_lowered(self.run)
        first, last = np.searchsorted(self.run.time[self.run.passage()],
                                      self.passing.time[[self.passing.first, -1]])
        return -self.passing.left - (lowered[last] - lowered[first])

    def settlement_judged(self):
        """Of the sleepers that are not at the ends of the bed."""
        return self.settlement()[~ground_blocks.at_ends(len(self.run.sleepers_x), True)]

    def wheels(self):
        x = np.repeat(self.passing.x[..., None], self.passing.force.shape[2], axis=2).ravel()
        force = self.passing.force.ravel()
        known = np.isfinite(x) & np.isfinite(force)
        return x[known], force[known]

    def mean_force(self):
        """Of a wheel over the bed, N: the static load, since the forces of a passage balance it."""
        return float(np.nanmean(np.where(self.passing.on_bed()[..., None], self.passing.force,
                                         np.nan)))


def require_whole(run, passing):
    """The train of the last passage must have left the bed, or no number has a meaning."""
    last = run.time[run.passage()]
    if not run.has_passage() or passing.time[0] < last[0]:
        raise read.Unreadable(f"{run.name}: the run has not reached the train of its last passage: "
                              "wait for its end or, if it was stopped, resume it")
    if not measures.train_has_left(run):
        remedy = "let it run on past the last sleeper (train.speeds ends with 0)" \
            if measures.train_stands(run) else "resume the run, or give a longer stage.duration"
        raise read.Unreadable(f"{run.name}: the train has not left the bed in the last row of the "
                              f"histories, at {last[-1]:.4g} s: {remedy}")


def train_of(folder):
    run = read.results(folder)
    if run.deck.get("dimension") != "plane":
        raise read.Unreadable(f"{run.name}: levels of a transition zone are drawn for plane "
                              "models only")
    if len(run.sleepers_x) <= 2 * ENDS:
        raise read.Unreadable(f"{run.name} has {len(run.sleepers_x)} sleepers: a transition zone "
                              f"needs more than {2 * ENDS}, since those at the ends are not judged")
    passing = train_figures.Passing(run, read.datasets(folder))
    require_whole(run, passing)
    return Train(run, passing, run.name)


def named(trains):
    """With names for legends and files: what the design is, or the folder."""
    runs = [train.run for train in trains]
    if len(trains) == 2 and ground_blocks.differ_by_wedge(*runs):
        what = ground_blocks.listed(ground_blocks.more_blocks(*runs))
        names = [f"{word} {what if len(what) <= LONG else 'measures'}"
                 for word in ("with", "without")]
    else:
        names = [train.run.name for train in trains]
        if len(set(names)) < len(names):
            names = [f"{name} {number + 1}" for number, name in enumerate(names)]
    return [dataclasses.replace(train, name=name) for train, name in zip(trains, names)]


@dataclasses.dataclass(frozen=True)
class Change:
    """How the lowest level of the rail changes from the structure to plain track. Places are x, and
    distances from the edge into the soft ground, m."""
    zone: Zone
    structure: float  # m, mean of the sleepers on the structure
    plain: float      # m, median of the sleepers on plain track
    width: float      # m, from the edge to REACHED of the change
    steepest: float   # m/m, between neighbouring sleepers of the transition
    steepest_x: float  # between both
    steepest_behind: float
    scatter: float    # m/m, largest between neighbouring sleepers on plain track
    sleeper_width: float     # m, from the edge to REACHED of the change of the sleepers themselves
    sleeper_steepest: float  # m/m, of the level of the sleepers themselves
    sleeper_steepest_behind: float
    sleeper_scatter: float
    force: float      # N, largest wheel force in the transition
    force_x: float
    force_behind: float
    force_structure: float  # N, largest wheel force on the structure
    force_plain: float      # N, largest wheel force on plain track
    plain_begin: float      # x of the first and last sleeper of plain track
    plain_end: float


def steepest_within(level, place, part):
    """(largest change of level per metre between neighbouring sleepers that are both in the part,
    the place between both)."""
    both = np.flatnonzero(part[1:] & part[:-1])
    k = both[np.argmax(np.abs(np.diff(level) / np.diff(place))[both])]
    return float(abs((level[k + 1] - level[k]) / (place[k + 1] - place[k]))), \
        float(place[k:k + 2].mean())


def changes_of(trains):
    """A Change of each train, or None if a run has no such zone. Plain track begins at the same
    place in all designs, unless their structures end at different places."""
    runs, levels = [train.run for train in trains], [train.rail_down() for train in trains]
    found = [zone_of(run, changing)
             for run, changing in zip(runs, zones.changing_of_each(runs, levels))]
    if None in found:
        return None
    return [change_of(train, zone) for train, zone in zip(trains, found)]


def change_of(train, zone):
    """The Change of one train."""
    level, x = train.rail_down(), train.run.sleepers_x

    def behind(place):
        return float(np.interp(place, x, zone.distance))
    steepest, steepest_x = steepest_within(level, x, zone.transition)
    sleepers, sleepers_x = steepest_within(train.sleeper_down(), x, zone.transition)
    # A wheel stands on the structure up to its edge, also between two sleepers.
    begin, end = zone.distance[zone.structure].min(), zone.distance[zone.plain].min()
    force, force_x = train.largest_force_in(zone, 0, end)
    return Change(
        zone=zone, structure=float(np.mean(level[zone.structure])),
        plain=float(np.median(level[zone.plain])), width=zones.rail_width(zone, level),
        sleeper_width=zones.rail_width(zone, train.sleeper_down()), steepest=steepest,
        steepest_x=steepest_x, steepest_behind=behind(steepest_x),
        scatter=steepest_within(level, x, zone.plain)[0],
        sleeper_steepest=sleepers, sleeper_steepest_behind=behind(sleepers_x),
        sleeper_scatter=steepest_within(train.sleeper_down(), x, zone.plain)[0],
        force=force, force_x=force_x, force_behind=behind(force_x),
        force_structure=train.largest_force_in(zone, begin, 0)[0],
        force_plain=train.largest_force_in(zone, end, zone.last)[0],
        plain_begin=float(x[zone.plain].min()), plain_end=float(x[zone.plain].max()))


ROWS = (("lowest level of the rail, mean on the structure, mm down", "structure", 1e3),
        ("lowest level of the rail, median on plain track, mm down", "plain", 1e3),
        (f"distance behind the structure where {REACHED:.0%} of the change is reached, m",
         "width", 1),
        ("the same distance for the level of the sleepers, m", "sleeper_width", 1),
        ("steepest change between two sleepers of the transition, mm/m", "steepest", 1e3),
        ("x of the steepest change of the transition, m", "steepest_x", 1),
        ("distance of the steepest change behind the structure, m", "steepest_behind", 1),
        ("steepest change between two sleepers of plain track (scatter of the bed), mm/m",
         "scatter", 1e3),
        ("the same of the sleepers in the transition, mm/m", "sleeper_steepest", 1e3),
        ("the same of the sleepers on plain track, mm/m", "sleeper_scatter", 1e3),
        ("largest wheel force in the transition, kN", "force", 1e-3),
        ("x of the largest wheel force in the transition, m", "force_x", 1),
        ("distance of the largest wheel force behind the structure, m", "force_behind", 1),
        ("largest wheel force on the structure, kN", "force_structure", 1e-3),
        ("largest wheel force on plain track, kN", "force_plain", 1e-3),
        ("first sleeper of plain track, x, m", "plain_begin", 1),
        ("last sleeper of plain track, x, m", "plain_end", 1))


PLACES = ("steepest_x", "steepest_behind", "force_x", "force_behind", "plain_begin", "plain_end")


def numbers(folder):
    """Name -> number of one run, those of its column in transition.txt."""
    train = train_of(folder)
    changes = changes_of([train])
    found = {label: getattr(changes[0], field) * factor
             for label, field, factor in (ROWS if changes else ())}
    return found | {label: of(train) for label, of in OF_TRAINS}


OF_TRAINS = (("mean wheel force over the bed, kN", lambda train: 1e-3 * train.mean_force()),
             ("settlement of sleepers into the bed, relative to the ground, mean, mm",
              lambda train: 1e3 * train.settlement_judged().mean()),
             ("settlement of sleepers into the bed, relative to the ground, largest, mm",
              lambda train: 1e3 * train.settlement_judged().max()),
             ("settlement of sleepers into the bed, relative to the ground, smallest, mm",
              lambda train: 1e3 * train.settlement_judged().min()),
             ("difference of the levels of all sleepers of the bed before the train, largest, mm",
              lambda train: 1e3 * train.unevenness()))


def table(trains, changes):
    """A column for each run; `trains`: all on stones, or all on a ground of elements, which has no
    bed, so that nothing scatters or settles there."""
    rows, of_trains = ROWS, OF_TRAINS
    if not trains[0].stones:
        rows = [(label.replace(" (scatter of the bed)", ""), *rest) for label, *rest in ROWS]
        of_trains = [(f"mean force of {trains[0].of_mean}, kN", OF_TRAINS[0][1])]
    wide = max(len(row[0]) for row in (*rows, *of_trains)) + 1
    column = max(15, *(len(train.name) + 2 for train in trains))
    lines = [" " * wide + "".join(f"{train.name:>{column}}" for train in trains)]
    for label, field, factor in rows if changes else ():
        lines.append(f"{label:<{wide}}" + "".join(
            f"{judgement.shown(getattr(change, field) * factor, field in PLACES):>{column}}"
            for change in changes))
    for label, of in of_trains:
        lines.append(f"{label:<{wide}}" + "".join(
            f"{judgement.shown(of(train)):>{column}}" for train in trains))
    return "\n".join(lines) + "\n"


def curves(trains):
    """The curves of transition.png as CSV: name of the file -> text. Runs may have other places."""
    found = {}
    for train in trains:
        x, force = train.largest_force()
        along = [train.run.sleepers_x, 1e3 * train.rail_down(), 1e3 * train.sleeper_down()]
        names = "x_m,rail_down_mm,sleeper_down_mm"
        if train.stones:
            along.append(1e3 * train.settlement())
            names += ",settlement_down_mm"
        for name, head, columns in (
                ("levels", names, along),
                ("wheel_force", "x_m,largest_wheel_force_kN", (x, 1e-3 * force))):
            rows = (",".join(f"{value:.6g}" for value in row) for row in zip(*columns))
            found[f"{name}_{train.name.replace(' ', '_')}.csv"] = "\n".join([head, *rows]) + "\n"
    return found


def draw_into(results, folder):
    """Pictures and tables of one run, or of two compared; `results`: their folders."""
    trains = named([train_of(path) for path in results])
    changes = changes_of(trains)
    unsound = passage_warnings.why_no_verdict((train.name, train.run) for train in trains)
    sentence = transition_verdict.sentences(trains, changes, unsound)
    folder.sentences.append(sentence)
    lengths = zones.changing_of_each([train.run for train in trains])
    warnings = bed_warnings.once(
        (train.name, [*bed_warnings.of(train.run, changing), *passage_warnings.of_bed(train.run),
                      *train.run.warnings]) for train, changing in zip(trains, lengths))
    caption = transition_caption.of(trains, changes, unsound, bool(warnings))
    if warnings:
        sentence = "\n".join([sentence, "Warnings of the runs:", *(f"{one}." for one in warnings)])
    titles = transition_caption.titles(trains, changes, unsound)
    folder.picture("transition", transition_figures.compare(trains, changes, titles, caption))
    folder.picture("model", transition_figures.draw_model(trains[0], results[0]),
                   write.origin_of(results[:1]))
    for name, text in curves(trains).items():
        folder.file(name, text)
    below = transition_figures.wrapped(sentence)
    folder.table("transition.txt", f"{table(trains, changes)}\n{below}\n")


def film_of(results, origin):
    """Pictures: film() of runs given by their folders."""
    trains = named([train_of(path) for path in results])
    if not transition_figures.instants(trains[0], results[0]):
        raise read.Unreadable(f"{trains[0].run.name} has no field files within the passage; set "
                              "output.fields and output.fields_interval")
    return transition_figures.film(trains, results[0], origin)
