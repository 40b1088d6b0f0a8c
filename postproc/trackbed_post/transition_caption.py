"""The text below transition.png: at most five short sentences on levels, steepest change, wheel
forces and limits. transition.txt has the whole verdict with all places and differences, and the
warnings. Of `trains` and `changes` as in transition_verdict.py."""
from __future__ import annotations

import typing

import numpy as np

from trackbed_post import transition_verdict
from trackbed_post.judgement import Difference, shown
from trackbed_post.measures import TINY
from trackbed_post.zones import REACHED

if typing.TYPE_CHECKING:
    from trackbed_post.transition import Change, Train


def short(found: Difference, unsound: str) -> str:
    """A verdict without its numbers, which transition.txt states."""
    return "" if unsound else f": {found.judged(True)[0]}"


def reached(width: float) -> str:
    return f"reached {width:.2g} m behind the structure" if np.isfinite(width) else "not reached"


def of_one(change: Change) -> list[str]:
    """Levels, steepest change and wheel force of a run."""
    return [
        f"{REACHED:.0%} of the change of the rail's lowest level from structure to plain track is "
        f"{reached(change.width)}.",
        f"Steepest change in the transition: {1e3 * change.steepest:.2g} mm/m "
        f"{transition_verdict.place(change.steepest_x, change.steepest_behind)}.",
        f"Largest wheel force there: {shown(1e-3 * change.force)} kN, on plain track "
        f"{shown(1e-3 * change.force_plain)} kN."]


def beside_plain(trains: list[Train], changes: list[Change], unsound: str) -> str:
    """How the wheel forces of two runs are beside those on plain track, in words."""
    if unsound:
        return ", beside those on plain track"
    larger = transition_verdict.clearly_larger(trains, changes)
    clearly = "clearly" if larger else "not clearly"
    only = f" ({larger[0].name} only)" if len(larger) == 1 else ""
    return f", and {clearly} larger than those on plain track{only}"


def of_two(trains: list[Train], changes: list[Change], unsound: str) -> list[str]:
    """The same of two runs, with what is judged of the first one beside the second."""
    now, other = changes
    differ = transition_verdict.differences(trains, changes)
    second = trains[1].name
    both = np.isfinite([now.width, other.width]).all()
    width = f"{other.width:.2g} m" if both else reached(other.width)
    return [
        f"{trains[0].name_first}, {REACHED:.0%} of the change of the rail's lowest level from "
        f"structure to plain track is {reached(now.width)}, {second} {width}"
        f"{short(differ['width'], unsound)}.",
        f"Steepest change in the transition: {1e3 * now.steepest:.2g} mm/m at x = "
        f"{now.steepest_x:.2f} m, {second} {1e3 * other.steepest:.2g} mm/m at x = "
        f"{other.steepest_x:.2f} m{short(differ['steepest'], unsound)}.",
        f"Largest wheel force there: {shown(1e-3 * now.force)} and {shown(1e-3 * other.force)} kN"
        f"{short(differ['force'], unsound)}{beside_plain(trains, changes, unsound)}, "
        f"{shown(1e-3 * now.force_plain)} and {shown(1e-3 * other.force_plain)} kN."]


def same_places(trains: list[Train], changes: list[Change]) -> bool:
    """Whether the parts of the track have the same sleepers in all runs."""
    places = [[train.run.sleepers_x[part] for part in (
        change.zone.structure, change.zone.transition, change.zone.plain)]
              for train, change in zip(trains, changes)]
    return all(len(one) == len(other) and np.allclose(one, other, rtol=0, atol=TINY)
               for parts in places[1:] for one, other in zip(places[0], parts))


def limits(trains: list[Train], changes: list[Change]) -> str:
    """What the numbers are to be compared with, and what they depend on."""
    scatter = 1e3 * max(change.scatter for change in changes)
    shared = "; structure, transition and plain track are the same places in both runs" \
        if len(changes) > 1 and same_places(trains, changes) else ""
    return (f"Limits: the scatter of neighbouring sleepers on plain track is {scatter:.2g} mm/m; "
            f"one packing of stones was computed{shared}.")


def of(trains: list[Train], changes: list[Change] | None, unsound: str, warned: bool) -> str:
    """The text; `unsound`: why these beds have no verdict, `warned`: whether transition.txt has
    warnings."""
    why = transition_verdict.why_no_verdict(trains, changes)
    lines = [f"No verdict: {why or unsound}."] if why or unsound else []
    if changes is not None:
        lines += of_two(trains, changes, why or unsound) if len(changes) == 2 else \
            of_one(changes[0])
        lines.append(limits(trains, changes))
    if warned:
        lines[0] = f"{lines[0][:-1]}; warnings are in transition.txt."
    return " ".join(lines)
