"""The text below transition.png: a few short sentences, on levels of rail and sleepers, wheel
forces and limits. transition.txt has the whole verdict with all places and differences, and
the warnings. Of `trains` and `changes` as in transition_verdict.py."""
from __future__ import annotations

import typing

import numpy as np

from trackbed_post import transition_verdict
from trackbed_post.judgement import shown
from trackbed_post.measures import TINY
from trackbed_post.transition_verdict import extends, length, slope, steepest

if typing.TYPE_CHECKING:
    from trackbed_post.transition import Change, Train


def level(trains: list[Train], changes: list[Change]) -> str:
    """Over which length the rail's level changes and how steeply, of one run or two, without a
    verdict."""
    first, *second = changes
    what = extends("the change of the rail's lowest level from structure to plain track",
                   first.width)
    words = f"{trains[0].name_first}, {what}" if second else what[:1].upper() + what[1:]
    for train, change in zip(trains[1:], second):
        both = np.isfinite([first.width, change.width]).all()
        words += f", {train.name} {length(change.width) if both else extends('it', change.width)}"
    begin, *others = steepest(changes)
    steep = begin + "".join(f", {train.name} {one}" for train, one in zip(trains[1:], others))
    return f"{words}; its steepest part is {steep}."


def forces(trains: list[Train], changes: list[Change], unsound: str) -> str:
    """The largest wheel forces, beside those on plain track."""
    def both(field: str) -> str:
        return " and ".join(shown(1e-3 * getattr(change, field)) for change in changes)
    judged, beside = "", ", on plain track"
    if len(changes) == 2:
        beside = beside_plain(trains, changes, unsound)
        if not unsound:
            found = transition_verdict.differences(trains, changes)["force"]
            judged = f": {found.judged(transition_verdict.measure_of(trains))[0]}"
    return (f"Largest wheel force in the transition: {both('force')} kN{judged}{beside} "
            f"{both('force_plain')} kN.")


def beside_plain(trains: list[Train], changes: list[Change], unsound: str) -> str:
    """How the wheel forces of two runs are beside those on plain track, in words."""
    if unsound:
        return ", on plain track"
    larger = transition_verdict.clearly_larger(trains, changes)
    clearly = "clearly" if larger else "not clearly"
    only = f" ({larger[0].name} only)" if len(larger) == 1 else ""
    return f", and {clearly} larger than those on plain track{only},"


def same_places(trains: list[Train], changes: list[Change]) -> bool:
    """Whether the parts of the track have the same sleepers in all runs."""
    places = [[train.run.sleepers_x[part] for part in (
        change.zone.structure, change.zone.transition, change.zone.plain)]
              for train, change in zip(trains, changes)]
    return all(len(one) == len(other) and np.allclose(one, other, rtol=0, atol=TINY)
               for parts in places[1:] for one, other in zip(places[0], parts))


def limits(trains: list[Train], changes: list[Change]) -> str:
    """What the numbers are to be compared with, and what they depend on."""
    scatter = slope(max(change.scatter for change in changes))
    shared = "; structure, transition and plain track are the same places in both runs" \
        if len(changes) > 1 and same_places(trains, changes) else ""
    return (f"the scatter between neighbouring sleepers on plain track is {scatter}; one packing "
            f"of stones was computed{shared}.")


def judged(trains: list[Train], changes: list[Change]) -> list[str]:
    """Of two runs with a verdict: effect on rail and sleepers, wheel forces, limits."""
    both = ", instead of ".join(steepest(changes))
    return [transition_verdict.effect(trains, changes, True),
            f"The steepest change of the rail is {both}.",
            transition_verdict.of_sleepers(trains, changes, True), forces(trains, changes, ""),
            f"Limits: {limits(trains, changes)}"]


def of(trains: list[Train], changes: list[Change] | None, unsound: str, warned: bool) -> str:
    """The text; `unsound`: why these beds have no verdict, `warned`: whether transition.txt has
    warnings."""
    why = transition_verdict.why_no_verdict(trains, changes) or unsound
    lines = [f"No verdict: {why}."] if why else []
    if changes is not None:
        lines += [level(trains, changes), forces(trains, changes, why),
                  f"Limits: {limits(trains, changes)}"] if why else judged(trains, changes)
    if warned:
        behind = 0 if why else -1  # the reason against a verdict may be one of them
        lines[behind] = f"{lines[behind][:-1]}; warnings are in transition.txt."
    return " ".join(lines)
