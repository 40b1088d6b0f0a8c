"""The texts of transition.png: a sentence above each panel, what it shows, and below them why there
is no verdict, or places of steepest changes, levels of sleepers, and limits. transition.txt has the
whole verdict with all places and differences, and the warnings. Of `trains` and `changes` as in
transition_verdict.py."""
from __future__ import annotations

import collections.abc
import typing

import numpy as np

from trackbed_post import bed_warnings, transition_verdict
from trackbed_post.judgement import shown
from trackbed_post.measures import TINY
from trackbed_post.transition_verdict import extends, length, slope, steepest

OWN = "The sleepers' own levels (thin lines)"

if typing.TYPE_CHECKING:
    from trackbed_post.transition import Change, LoadedTrack, Train
    Tracks = collections.abc.Sequence[LoadedTrack]


def level(trains: Tracks, changes: list[Change]) -> str:
    """Over which length the rail's level changes and how steeply, of one run or two, without a
    verdict."""
    first, *second = changes
    what = extends("the change of the rail's lowest level from structure to plain track",
                   first.width)
    words = f"{trains[0].name_first}, {what}" if second else what[:1].upper() + what[1:]
    for train, change in zip(trains[1:], second):
        both = np.isfinite([first.width, change.width]).all()
        words += f", {train.name} {length(change.width) if both else extends('it', change.width)}"
    begin, *others = steepest(changes, trains[0].spread)
    steep = begin + "".join(f", {train.name} {one}" for train, one in zip(trains[1:], others))
    return f"{words}; its steepest part is {steep}."


def named(trains: Tracks, values: typing.Iterable[float], unit: str) -> str:
    """A value of one run, or of two with their names."""
    return with_names(trains, [f"{shown(value)} {unit}" for value in values])


def with_names(trains: Tracks, texts: list[str]) -> str:
    """A text of one run, or those of two with their names."""
    return texts[0] if len(texts) == 1 else " and ".join(
        f"{text} ({train.name})" for text, train in zip(texts, trains))


def forces(trains: Tracks, changes: list[Change], unsound: str) -> str:
    """The largest wheel forces; beside those on plain track, if they are clearly larger."""
    largest = named(trains, (1e-3 * change.force for change in changes), "kN")
    words = f"Largest wheel force between structure and plain track: {largest}"
    if len(changes) < 2 or unsound:
        return f"{words}."
    found = transition_verdict.differences(trains, changes)["force"]
    words += f": {found.judged(transition_verdict.measure_of(trains))[0]}"
    larger = transition_verdict.clearly_larger(trains, changes)
    only = f" ({larger[0].name} only)" if len(larger) == 1 else ""
    return f"{words}, and clearly larger than on plain track{only}." if larger else f"{words}."


def on_plain_track(trains: Tracks, changes: list[Change]) -> str:
    """The largest wheel forces there."""
    plain = named(trains, (1e-3 * change.force_plain for change in changes), "kN")
    return f"On plain track the largest wheel force is {plain}."


def same_places(trains: Tracks, changes: list[Change]) -> bool:
    """Whether the parts of the track have the same sleepers in all runs."""
    places = [[train.run.sleepers_x[part] for part in (
        change.zone.structure, change.zone.transition, change.zone.plain)]
              for train, change in zip(trains, changes)]
    return all(len(one) == len(other) and np.allclose(one, other, rtol=0, atol=TINY)
               for parts in places[1:] for one, other in zip(places[0], parts))


def limits(trains: Tracks, changes: list[Change]) -> str:
    """What the numbers depend on, as far as the runs tell it, and with what they are to be
    compared."""
    scatter = slope(max(change.scatter for change in changes))
    other = "; structure, transition and plain track are other places in the second run" \
        if len(changes) > 1 and not same_places(trains, changes) else ""
    found = ["in this plane model loads do not spread across the track"] \
        if trains[0].run.deck.get("dimension", "plane") == "plane" else []
    if trains[0].stones:
        found.append("one packing of stones was computed")
    found.append(f"on plain track the rail changes by up to {scatter} between neighbouring "
                 f"sleepers{other}.")
    return "; ".join(found)


def settlement(trains: list[Train], unsound: str = "") -> str:
    """How far the sleepers that are not at the ends of the bed have settled or risen when the train
    has left, which says nothing on how far they move under it; of sound runs in which all of this
    is small that it is."""
    moved = [train.settlement_judged() for train in trains]
    if not unsound and max(np.abs(one).max() for one in moved) <= bed_warnings.SETTLES:
        run = " in either run" if len(trains) > 1 else ""
        return ("After this passage no judged sleeper has settled or risen by more than "
                f"{1e3 * bed_warnings.SETTLES:g} mm{run}.")  # the axis: relative to the ground
    ranges = [f"{signed(-one.max())} to {signed(-one.min())} mm" for one in moved]
    found = with_names(trains, ranges)
    return f"Sleepers after this passage, relative to the ground: {found}, up positive."


def signed(value: float) -> str:
    """A displacement in m as mm, up positive."""
    return f"{'+' if value > 0 else ''}{shown(1e3 * value)}"


def titles(trains: Tracks, changes: list[Change] | None, unsound: str) -> list[str]:
    """What the panels show: level, wheel force and, on stones, settlement. Without a verdict as
    numbers alone."""
    if changes is None:
        found = ["Lowest level of rail and sleepers under the train.",
                 "Largest wheel force along the track."]
    else:
        why = transition_verdict.why_no_verdict(trains, changes) or unsound
        found = [level(trains, changes) if why else
                 transition_verdict.effect(trains, changes, True), forces(trains, changes, why)]
    if trains[0].stones:
        found.append(settlement(typing.cast("list[Train]", trains), unsound))
    return found


def own_levels(trains: Tracks, changes: list[Change]) -> str:
    """How the sleepers' own levels change, each number with its verdict."""
    found, measure = transition_verdict.differences(trains, changes), \
        transition_verdict.measure_of(trains)
    both = found["sleeper_width"], found["sleeper_steepest"]
    (over, other), (steep, than) = [[one.of_text(one.first), one.of_text(one.second)]
                                    for one in both]
    known = np.isfinite([both[0].first, both[0].second]).all()
    words = [f"{OWN} change over {over} instead of {other}" if known else
             f"{OWN} do not reach the end of their change in both runs",
             f"their steepest change is {steep} instead of {than}"]
    verdicts = [transition_verdict.judged_of(one, measure) for one in both]
    if all(transition_verdict.in_scatter(changes, "sleeper_")):
        words[1] += f", not larger than the {trains[0].spread} on plain track"
        verdicts[1] = "no verdict from it"
    if not known:
        return f"{words[0]}; {words[1]}: {verdicts[1]}."
    if verdicts[0] == verdicts[1]:
        both_are = "neither is a clear effect" if verdicts[0] == transition_verdict.NO_EFFECT else \
            f"both {verdicts[0]}"
        return f"{words[0]}, and {words[1]}: {both_are}."
    return f"{words[0]}: {verdicts[0]}; {words[1]}: {verdicts[1]}."


def judged(trains: Tracks, changes: list[Change]) -> list[str]:
    """Of two runs with a verdict: places on the rail, effect on sleepers, forces, limits."""
    both = ", instead of ".join(steepest(changes, trains[0].spread))
    return [f"The steepest change of the rail is {both}.", own_levels(trains, changes),
            on_plain_track(trains, changes), f"Limits: {limits(trains, changes)}"]


def of(trains: Tracks, changes: list[Change] | None, unsound: str, warned: bool) -> str:
    """The text below the panels; `unsound`: why these beds have no verdict, `warned`: whether
    transition.txt has warnings."""
    why = transition_verdict.reasons(trains, changes, unsound)
    lines = [f"No verdict: {why}."] if why else []
    if changes is not None:
        lines += judged(trains, changes) if not why else [
            on_plain_track(trains, changes), f"Limits: {limits(trains, changes)}"]
    if warned:
        behind = 0 if why else -1  # the reason against a verdict may be one of them
        lines[behind] = f"{lines[behind][:-1]}; warnings are in transition.txt."
    return " ".join(lines)
