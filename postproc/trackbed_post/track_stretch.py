"""Which part of a track alone counts, where its ground is, and what a train has run over.

On a ground the forces that count are those over it: springs before and behind it represent ballast
and ground together, and where they begin the support changes in a step, which is one of the model.
All x are from the start of the track, m.
"""
import collections.abc
import dataclasses
import typing

import numpy as np

from trackbed_post import axles, ground_blocks, measures, read

MANY = 7  # places that are not listed one by one
ENDS = 2  # sleepers at each end of the ground over which the step to the springs acts


@dataclasses.dataclass(frozen=True)
class Stretch:
    """A part of the track, m, and what it is, behind a noun, or nothing if it is all."""
    begin: float
    end: float
    words: str

    def holds(self, x: np.ndarray) -> np.ndarray:
        return (x >= self.begin) & (x <= self.end)


@dataclasses.dataclass(frozen=True)
class Ground:
    """x of the sleepers on the ground, and of its own x = 0, from the start of the track, m."""
    sleepers: np.ndarray
    origin: float
    extent: tuple[float, float]

    @property
    def judged(self) -> np.ndarray:
        """Its sleepers without ENDS at each end; of a short ground all."""
        return self.sleepers[ENDS:-ENDS] if len(self.sleepers) > 2 * ENDS + 1 else self.sleepers

    def at_end(self, x: float) -> bool:
        """Whether the step from springs to ground acts at a sleeper, on either side of it."""
        reach = ENDS * float(np.median(np.diff(self.sleepers))) if len(self.sleepers) > 1 else 0.0
        return bool(np.abs(self.sleepers[[0, -1]] - x).min() < reach - ground_blocks.TINY)


def history(run: read.Quantities, name: str) -> np.ndarray:
    """[time, place]."""
    values = run[f"history/{name}"].values
    return values.reshape(len(values), -1)


def two_rails(run: read.Quantities) -> bool:
    """Whether each place of the envelope, or without envelope of the rail, is listed twice."""
    named = [name for name in ("envelope/x", "rail/x", "sleepers/x") if name in run]
    x = run[named[0]].values.ravel() if named else np.empty(0)
    return len(x) > 1 and len(x) % 2 == 0 and np.array_equal(x[::2], x[1::2])


def run_in_of(deck: read.Deck) -> float:
    """Length of the run-in, m; 0 for a bridge."""
    track = deck["track"]
    return 0 if track.get("support") == "none" else track.get("run_in", 0)


def ground_of(deck: read.Deck) -> Ground | None:
    """That below the sleepers of a track; None of another model."""
    footing, track = deck.get("footing", {}), deck.get("track", {})
    if deck.get("model") != "track_on_ground" or not {"count", "first"} <= footing.keys():
        return None
    before = footing.get("before", 0)
    places = measures.sleepers_of_track(track, track["spacing"])
    sleepers = places[before:before + footing["count"]]
    if not len(sleepers):
        return None
    origin = float(sleepers[0]) - footing["first"]
    ends = [end + origin for end in deck.get("ground", {}).get("x", [])] or list(sleepers)
    return Ground(sleepers, origin, (float(ends[0]), float(ends[-1])))


def between_run_ins(deck: read.Deck) -> Stretch:
    run_in, length = run_in_of(deck), deck["track"]["length"]
    return Stretch(run_in, length - run_in, " between the run-ins" if run_in > 0 else "")


def counted(deck: read.Deck) -> Stretch:
    """Where forces and levels count."""
    ground = ground_of(deck)
    if ground is None:
        return between_run_ins(deck)
    return Stretch(float(ground.judged[0]), float(ground.judged[-1]), " over the ground")


def blocks_of(deck: read.Deck) -> list[ground_blocks.Stretch]:
    """Those of the ground, along the track."""
    ground = ground_of(deck)
    if ground is None:
        return []
    return [dataclasses.replace(one, low=one.low + ground.origin, high=one.high + ground.origin)
            for one in ground_blocks.stretches(WithDeck(deck))]


@dataclasses.dataclass(frozen=True)
class WithDeck:
    """What ground_blocks needs of a run."""
    deck: read.Deck


def notes(deck: read.Deck, names: collections.abc.Iterable[str]) -> list[str]:
    """What a table of numbers with these names must explain."""
    ground = ground_of(deck)
    if ground is None:
        return []
    over = counted(deck)
    without = f", without {ENDS} sleepers at each end, where the support changes from the " \
        "springs to the ground in a step" if len(ground.judged) < len(ground.sleepers) else ""
    found = [f"x counts from the start of the track; x = 0 of the ground is at {ground.origin:g} m"]
    if any(over.words in name for name in names):
        found.append(f"over the ground: from x = {over.begin:g} to {over.end:g} m{without}; wheel "
                     "forces there are those of the rows of the histories, between the run-ins "
                     "of every step")
    return found


def unpassed(run: read.Quantities, deck: read.Deck) -> list[float]:
    """Points of the histories, and the end of the part that counts, over which the train has not
    run as a whole, m; none without wheels."""
    if "history/wheel/x" not in run or "track" not in deck:
        return []
    points = [run[name].values.ravel() for name in ("rail/x", "sleepers/x") if name in run]
    places = np.unique(np.concatenate([*points, [counted(deck).end]]))
    x = history(run, "wheel/x")
    there = axles.reached(x, places)
    return [float(one) for one, reached in zip(places, there)
            if not reached or not axles.have_passed(x, one)]


def shown(run: read.Quantities, deck: read.Deck) -> np.ndarray:
    """Which places of the envelope count, and have had an axle above them if there are wheels."""
    x = run["envelope/x"].values.ravel()
    there = counted(deck).holds(x)
    return there & axles.reached(history(run, "wheel/x"), x) if "history/wheel/x" in run else there


def state(run: read.Quantities, deck: read.Deck) -> str:
    """That the train has not run over the whole track that counts, for a title."""
    left = unpassed(run, deck)
    if not left:
        return ""
    return (f"train not past x = {left[-1]:g} m, last axle at "
            f"{np.nanmin(history(run, 'wheel/x')[-1]):.2f} m")


def warnings_of(run: read.Quantities, deck: read.Deck) -> list[str]:
    """The same as a sentence."""
    left = unpassed(run, deck)
    if not left:
        return []
    x = history(run, "wheel/x")[-1]
    places = f"x = {ground_blocks.joined([f'{one:g}' for one in left])} m" if len(left) < MANY \
        else f"{len(left)} places from x = {left[0]:g} to {left[-1]:g} m"
    return [f"the train has not passed {places} (points of the "
            f"histories, and the end of the part that counts); in the last row its first axle is "
            f"at x = {np.nanmax(x):.2f} m and its last one at {np.nanmin(x):.2f} m: largest values "
            "do not contain what follows, and a point over which no axle has run has none; let "
            "the run go on (resume it, or give a longer passage.duration)"]


def without_unreached(run: read.Quantities, extremes: dict[str, typing.Any]) \
        -> tuple[read.Quantities, dict[str, typing.Any]]:
    """Datasets, and extremes of the summary, without points over which no axle has run: their
    motion is noise or the begin of a wave. All without wheels."""
    if "history/wheel/x" not in run:
        return run, extremes
    found, x = dict(run), history(run, "wheel/x")
    for name, groups in (("rail/x", ("history/rail/", "extreme/rail/")),
                         ("sleepers/x", ("history/sleeper/", "history/ground/"))):
        if name not in run:
            continue
        there = axles.reached(x, run[name].values.ravel())
        if there.all():
            continue
        for path in [name, *(path for path in run if path.startswith(groups))]:
            found.pop(path)
            if there.any() and (kept := _columns(run[path], there)):
                found[path] = kept
        if name == "rail/x" and len(extremes.get("rail_lowest_m", [])) == len(there):
            lowest = np.asarray(extremes["rail_lowest_m"])[there].tolist()
            extremes = {**extremes, "rail_lowest_m": lowest}
    return found, extremes


def _columns(item: read.Quantity, kept: np.ndarray) -> read.Quantity | None:
    """Those of some places, [place] or [time, place]; None of values at other places."""
    values = item.values.reshape(len(item.values), -1) if item.values.shape != kept.shape \
        else item.values
    if values.shape[-1] != len(kept):
        return None
    return dataclasses.replace(item, values=values[..., kept])
