"""The verdict on two designs of a transition zone, with and without a wedge, under a train:
sentences on the level of the rail and on wheel forces, or why there is no verdict.

Of `trains` and `changes`, transition.LoadedTrack and transition.Change of each run. Definition of
the numbers: docs/postproc.md.
"""
from __future__ import annotations

import collections.abc
import typing

import numpy as np

from trackbed_post import ground_blocks, ground_transition, measures, read
from trackbed_post.judgement import (CLEAR, Difference, measure_words, shown, stated,
                                     why_no_pair)
from trackbed_post.zones import REACHED

if typing.TYPE_CHECKING:
    from trackbed_post.transition import Change, LoadedTrack
    Tracks = collections.abc.Sequence[LoadedTrack]

Differences = dict[str, Difference]  # by names of fields, or of rows
NO_EFFECT = "no clear effect"
AT_END = 0.1  # m, nearer to the end of the structure a place is at the end: it is stated to 0.1 m


def differences(trains: Tracks, changes: list[Change]) -> Differences:
    """Field of Change -> Difference of the first run from the second."""
    now, other = changes
    ripple = max(change.force_plain - train.mean_force() for train, change in zip(trains, changes))

    def of(field: str, *rest: typing.Any) -> Difference:
        return Difference(getattr(now, field), getattr(other, field), *rest)

    def width(field: str) -> Difference:
        return of(field, measures.spacing(trains[0].run), "m", 1, 1, "one sleeper spacing")

    plain = f"the {trains[0].spread} on plain track"

    def steepest(field: str, scatter: str) -> Difference:
        return of(field, max(getattr(change, scatter) for change in changes), "mm/m", 1e3, -1,
                  plain)
    return {"width": width("width"), "steepest": steepest("steepest", "scatter"),
            "sleeper_width": width("sleeper_width"),
            "sleeper_steepest": steepest("sleeper_steepest", "sleeper_scatter"),
            "force": of("force", ripple, "kN", 1e-3, -1, plain)}


def what_differs(trains: Tracks) -> str:
    """What the first run has and the second has not."""
    return ground_blocks.listed(ground_blocks.more_blocks(*(train.run for train in trains)))


def why_no_verdict(trains: Tracks, changes: list[Change] | None) -> str:
    runs = [train.run for train in trains]
    if len(runs) < 2:
        measure = ground_blocks.listed(ground_blocks.measures_of(runs[0]))
        return f"give a second run, without the {measure}" if measure else \
            "this run has no wedge: give one with a wedge, and this one as the second"
    if no_pair := why_no_pair(*runs):
        return no_pair
    if changes is None and ground_blocks.edge_of_structure(runs[0]) is None:
        return (f"the ground has no structure (a block of {ground_blocks.RULE})"
                f"{ground_blocks.shallow(runs[0])}")
    if changes is None:
        return "there are too few sleepers on the structure, behind it or on plain track"
    now, other = changes
    if min(abs(1 - change.structure / change.plain) for change in changes) <= CLEAR:
        return ("the lowest levels of the rail on the structure and on plain track differ by less "
                f"than {CLEAR:.0%}")
    if abs(now.plain / other.plain - 1) > CLEAR:
        return ("the lowest levels of the rail on the plain tracks of the two runs differ by more "
                f"than {CLEAR:.0%}")
    if not all(np.isfinite(change.width) for change in changes):
        return "the level of plain track is not reached behind the structure"
    return ""


def reasons(trains: Tracks, changes: list[Change] | None, unsound: str) -> str:
    """Why there is no verdict, in the choice of the runs and in their beds; empty if there is
    one."""
    return "; ".join(filter(None, (why_no_verdict(trains, changes), unsound)))


def length(value: float) -> str:
    """Distance behind the structure over which a level changes."""
    return stated(value, "m")


def extends(what: str, width: float) -> str:
    """Over which distance behind the structure a level changes; `what`: this change in words."""
    return f"{what} extends over {length(width)}" if np.isfinite(width) else \
        f"the end of {what} is not reached"


def slope(value: float) -> str:
    return stated(1e3 * value, "mm/m")


def place(behind: float) -> str:
    """Of a distance from the end of the structure, m."""
    if abs(behind) < AT_END:
        return "at the end of the structure"
    side = "behind" if behind > 0 else "before the end of"
    return f"{abs(behind):.1f} m {side} the structure"


def in_scatter(changes: list[Change], of: str = "") -> list[bool]:
    """Of each run, whether its steepest change in the transition is not larger than what the beds
    of stones have where nothing changes along the track: the larger scatter of all runs. `of`:
    "sleeper_" of the sleepers' own levels, otherwise the rail's."""
    scatter = max(getattr(change, f"{of}scatter") for change in changes)
    return [getattr(change, f"{of}steepest") <= scatter for change in changes]


def steepest(changes: list[Change], spread: str, of: str = "") -> list[str]:
    """The steepest change of each run, with its place if it stands for the transition; `spread` of
    LoadedTrack."""
    found = []
    for change, unclear in zip(changes, in_scatter(changes, of)):
        where = f"not larger than the {spread}" if unclear else \
            place(getattr(change, f"{of}steepest_behind"))
        found.append(f"{slope(getattr(change, f'{of}steepest'))}, {where}")
    return found


def less_steep(found: Difference) -> str:
    """How steep the steepest change of the first run is beside that of the second."""
    change = found.change
    if np.isinf(change):
        return "steeper"
    if not abs(change) >= 0.005:  # would be 0 %
        return "as steep" if change == change else "not comparable"
    return f"{abs(change):.0%} {'less steep' if change < 0 else 'steeper'}"


def effect(trains: Tracks, changes: list[Change], sound: bool) -> str:
    """What the measure does to the level of the rail, in one sentence. `sound`: whether these beds
    have a verdict."""
    found, measure = differences(trains, changes), measure_of(trains)
    judged = [found[field].judged(measure)[0] for field in ("width", "steepest")]
    over = (f"With the {what_differs(trains)} the rail reaches {REACHED:.0%} of its change from "
            f"structure to plain track {length(changes[0].width)} behind the structure instead of "
            f"{length(changes[1].width)}")
    part = f"the steepest part of the change is {less_steep(found['steepest'])}"
    if all(in_scatter(changes)):
        part = (f"the steepest part is in neither run larger than the {trains[0].spread} on plain "
                "track")
        judged[1] = "no verdict from it"
    if not sound:
        return f"{over}, and {part}."
    if judged[0] == judged[1]:
        return f"{over}, and {part}: {judged[0]}."
    return f"{over}: {judged[0]}; {part}: {judged[1]}."


def of_sleepers(trains: Tracks, changes: list[Change], sound: bool) -> str:
    """The same of the sleepers' own levels, each quantity with a verdict of its own."""
    now, other = changes
    widths, spread = (now.sleeper_width, other.sleeper_width), trains[0].spread
    over = f"extends over {length(widths[0])} instead of {length(widths[1])}"
    if not np.isfinite(widths).all():
        over = "has no distance in both runs, since its end is not reached"
    numbers = (f"The change of the sleepers' own levels {over}; its steepest part is "
               f"{', instead of '.join(steepest(changes, spread, 'sleeper_'))}")
    return f"{numbers}: {of_both(trains, changes)}." if sound else f"{numbers}."


def of_both(trains: Tracks, changes: list[Change]) -> str:
    """The verdicts on distance and slope of the sleepers' own levels."""
    differ, measure = differences(trains, changes), measure_of(trains)
    width, slopes = differ["sleeper_width"], differ["sleeper_steepest"]
    found = [(compared(width, "distance", "longer", "shorter"), judged_of(width, measure)),
             (compared(slopes, "slope", "larger", "smaller"), judged_of(slopes, measure))]
    if all(in_scatter(changes, "sleeper_")):
        found[1] = ("the slope", f"not larger than the {trains[0].spread} on plain track, so that "
                    "no verdict follows from it")
    if found[0][1] != found[1][1]:
        return ", ".join(f"{name} is {verdict}" for name, verdict in found)
    if found[0][1] == NO_EFFECT:
        return "neither is a clear effect"
    return f"both are {found[0][1]}"


def judged_of(found: Difference, measure: str) -> str:
    """What a quantity is, behind "is"."""
    if np.isnan(found.change):
        return "not known"
    return found.judged(measure)[0].replace("no verdict: ", "not judged: ")


def compared(found: Difference, name: str, more: str, less: str) -> str:
    """A quantity by its difference: the longer distance."""
    difference = found.first - found.second
    word = f"{more} " if difference > 0 else f"{less} " if difference < 0 else ""
    return f"the {word}{name}"


def measure_of(trains: Tracks) -> str:
    """What only the first run has, as verdicts name it."""
    return measure_words(*(train.run for train in trains))


def of_distances(found: Difference) -> str:
    """A sentence: by how much distances differ, and how much is clear."""
    if np.isnan(found.change):
        return ""
    if abs(found.change) <= CLEAR:
        return f" The distances differ by at most {CLEAR:.0%}, which is no clear effect."
    return (f" The distances differ by {found.of_text(abs(found.first - found.second))}; a "
            f"difference above {found.beside}, {found.limit}, counts as clear.")


def of_slopes(found: Difference, stones: bool) -> str:
    """A sentence: by how much the steepest changes differ, beside the scatter."""
    if np.isnan(found.change) or np.isnan(found.scatter):
        return ""
    if abs(found.change) <= CLEAR:
        return f" They differ by at most {CLEAR:.0%}, which is no clear effect."
    exceeds = "exceeds" if found.larger_than_scatter else "does not exceed"
    return (f" This difference, {found.of_text(abs(found.first - found.second))}, {exceeds} the "
            f"steepest change on plain track, {found.limit}"
            f"{', where only the stones vary' if stones else ''}.")


def evidence(trains: Tracks, changes: list[Change], sound: bool) -> str:
    """The numbers behind the effect, and the limits with which they are compared."""
    now, other = changes
    found = differences(trains, changes)
    widths, slopes = (of_distances(found["width"]),
                      of_slopes(found["steepest"], trains[0].stones)) if sound else ("", "")
    force = f": {found['force'].words(measure_of(trains))}" if sound else ""
    steep = ", instead of ".join(steepest(changes, trains[0].spread))
    return (
        "The change is that of the lowest level of the rail under the train; it extends from the "
        f"end of the structure to where {REACHED:.0%} of it is reached.{widths} The steepest "
        f"change between two sleepers is {steep}.{slopes} "
        f"{of_sleepers(trains, changes, sound)} The largest wheel force in the transition is "
        f"{shown(1e-3 * now.force)} kN, {place(now.force_behind)}, instead of "
        f"{shown(1e-3 * other.force)} kN, {place(other.force_behind)}{force}.")


def verdict(trains: Tracks, changes: list[Change] | None, unsound: str = "") -> str:
    """Sentences on the effect of the wedge, or why there is none. `unsound`: why these beds have no
    verdict (bed_warnings.py); the numbers are stated all the same."""
    if why_no_verdict(trains, changes) or changes is None:
        return f"No verdict: {reasons(trains, changes, unsound)}."
    numbers = f"{effect(trains, changes, not unsound)} {evidence(trains, changes, not unsound)}"
    packing = " One packing of stones was computed." if trains[0].stones else ""
    if unsound:
        return (f"No verdict, since {unsound}: this can change the following numbers more "
                f"than the {what_differs(trains)} does. {numbers}{packing} The remedies are in "
                "the warnings.")
    return f"{numbers} {cause_of_forces(trains, changes)}{packing}"


def clearly_larger(trains: Tracks, changes: list[Change]) -> list[LoadedTrack]:
    """Those whose largest wheel force in the transition is clearly larger than on plain track."""
    return [train for train, change in zip(trains, changes)
            if change.force > change.force_plain and Difference(
                change.force, change.force_plain, change.force_plain - train.mean_force(),
                "kN").clear]


def cause_of_forces(trains: Tracks, changes: list[Change]) -> str:
    """A sentence: whether wheel forces in the transition are clearly larger than elsewhere."""
    larger = clearly_larger(trains, changes)

    def both(field: str) -> str:
        return " and ".join(shown(1e-3 * getattr(change, field)) for change in changes)
    elsewhere = (f"forces on plain track, up to {both('force_plain')} kN; on the structure they "
                 f"reach {both('force_structure')} kN")
    if larger:
        names = " and ".join([larger[0].name_first, *(train.name for train in larger[1:])])
        return f"{names}, it is clearly larger than {elsewhere}."
    return ("It is not clearly larger than " + elsewhere +
            f": such forces occur along the whole {'bed' if trains[0].stones else 'track'}.")


SAME = (("width", ground_transition.WIDTH, "distance at which the change is reached"),
        ("steepest", ground_transition.STEEPEST, "steepest change"))  # of rail, of ground, words


def beside_ground(rail: Differences, ground: Differences) -> str:
    """A sentence where the ground's surface, which table.txt judges, changes the other way than the
    rail and one of both changes clearly; otherwise empty. {name: Difference} of both."""
    found = [f"the {words} {by(ground[below])}, that of the rail {by(rail[above])}"
             for above, below, words in SAME
             if rail[above].change * ground[below].change < 0
             and (rail[above].clear or ground[below].clear)]
    if not found:
        return ""
    return (f"At the ground's surface (table.txt) the numbers change the other way: "
            f"{', and '.join(found)}. Stones and rail are between both; the train runs on the "
            "rail.")


def by(found: Difference) -> str:
    return found.relative if np.isinf(found.change) else f"by {found.relative}"


def of_ground(runs: list[read.Results]) -> Differences:
    """Of two runs, at the ground's surface; empty where it cannot be measured."""
    found = ground_transition.transitions(runs)
    if len(found) < len(runs):
        return {}
    return ground_transition.differences(found[0], found[1], measures.spacing(runs[0]))


def beside_structure(run: read.Results) -> str:
    """A sentence on blocks of the run without wedge that touch the structure; empty without one."""
    edge = ground_blocks.edge_of_structure(run)
    names = [block.name for block in ground_blocks.present(run)
             if not block.structure and edge is not None
             and np.abs(block.x - edge).min() < measures.TINY]
    if not names:
        return ""
    return (f"Both runs have {' and '.join(names)} beside the structure: if that belongs to the "
            "wedge, the second run is not without one (present = false).")


def sentences(trains: Tracks, changes: list[Change] | None, unsound: str) -> str:
    """The verdict, and how it differs from that on the ground."""
    found = verdict(trains, changes, unsound)
    if unsound or changes is None or why_no_verdict(trains, changes):
        return found
    ground = of_ground([train.run for train in trains])
    other = beside_ground(differences(trains, changes), ground) if ground else ""
    return " ".join(filter(None, (found, other, beside_structure(trains[1].run))))
