"""The verdict on two designs of a transition zone, with and without a wedge, under a train:
sentences on the level of the rail and on wheel forces, or why there is no verdict.

Of `trains` and `changes`, transition.Train and transition.Change of each run. Definition of the
numbers: docs/postproc.md.
"""
from __future__ import annotations

import collections.abc
import pathlib
import typing

import numpy as np

from trackbed_post import ground_blocks, ground_transition, measures, read
from trackbed_post.judgement import CLEAR, Difference, shown, why_no_pair
from trackbed_post.zones import REACHED

if typing.TYPE_CHECKING:
    from trackbed_post.transition import Change, Train

Differences = dict[str, Difference]  # by names of fields, or of rows
NOT_COMPARED = ("title", "start", "output")  # parts of decks in which two designs may differ
CELL = "bed.cell"


def differences(trains: list[Train], changes: list[Change]) -> Differences:
    """Field of Change -> Difference of the first run from the second."""
    now, other = changes
    steps = max(now.scatter, other.scatter)
    ripple = max(change.force_plain - train.mean_force() for train, change in zip(trains, changes))

    def of(field: str, *rest: typing.Any) -> Difference:
        return Difference(getattr(now, field), getattr(other, field), *rest)
    return {"width": of("width", measures.spacing(trains[0].run), "m", 1, 1, "one sleeper spacing"),
            "steepest": of("steepest", steps, "mm/m", 1e3, -1),
            "force": of("force", ripple, "kN", 1e-3, -1)}


def different_keys(first: read.Results, second: read.Results) -> list[str]:
    """The parameters, besides those of the wedge, in which two decks differ. A cell is compared by
    its name, since the path of its folder changes if results are moved."""
    def flat(deck: read.Deck, path: str = "") -> collections.abc.Iterator[tuple[str, object]]:
        for key, value in deck.items():
            if isinstance(value, dict):
                yield from flat(value, f"{path}{key}.")
            elif not (path + key).startswith(NOT_COMPARED) and path + key != "ground.block":
                yield path + key, pathlib.PurePath(value).name if path + key == CELL else value
    one, other = dict(flat(first.deck)), dict(flat(second.deck))
    differing = [key for key in {**one, **other} if one.get(key) != other.get(key)]
    shared = [block.name for block in ground_blocks.present(second)]
    blocks = [{each["name"]: each for each in run.deck["ground"].get("block", [])}
              for run in (first, second)]
    differing += [f"ground.block.{name}" for name in shared if blocks[0][name] != blocks[1][name]]
    return differing


def what_differs(trains: list[Train]) -> str:
    """What the first run has and the second has not."""
    return ground_blocks.listed(ground_blocks.more_blocks(*(train.run for train in trains)))


def why_no_verdict(trains: list[Train], changes: list[Change] | None) -> str:
    runs = [train.run for train in trains]
    if len(runs) < 2:
        measure = ground_blocks.listed(ground_blocks.measures_of(runs[0]))
        return f"give a second run, without the {measure}" if measure else \
            "this run has no wedge: give one with a wedge, and this one as the second"
    if no_pair := why_no_pair(*runs):
        return no_pair
    if keys := different_keys(*runs):
        return f"the decks differ in {', '.join(keys)}, not only in the {what_differs(trains)}"
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


def verdict(trains: list[Train], changes: list[Change] | None, unsound: str = "") -> str:
    """Sentences on the effect of the wedge, or why there is none. `unsound`: why these beds have no
    verdict (bed_warnings.py); the numbers are stated all the same."""
    if (why := why_no_verdict(trains, changes)) or changes is None:
        return f"No verdict: {why}."
    (now, other), what = changes, what_differs(trains)
    judged = {field: "" if unsound else f": {found.words(True)}"
              for field, found in differences(trains, changes).items()}
    numbers = (
        "The lowest level of the rail under the train changes from structure to plain track. "
        f"With the {what}, {REACHED:.0%} of this change is reached {now.width:.2g} m behind the "
        f"structure instead of {other.width:.2g} m{judged['width']}. The steepest change of "
        f"this level between two sleepers is {1e3 * now.steepest:.2g} mm/m "
        f"{place(now.steepest_x, now.steepest_behind)}, instead of {1e3 * other.steepest:.2g} "
        f"mm/m {place(other.steepest_x, other.steepest_behind)} "
        f"({now.steepest / other.steepest - 1:+.0%}){judged['steepest']}. The largest wheel "
        f"force in the transition is {shown(1e-3 * now.force)} kN "
        f"{place(now.force_x, now.force_behind)}, instead of {shown(1e-3 * other.force)} kN "
        f"{place(other.force_x, other.force_behind)}{judged['force']}.")
    packing = "One packing of stones was computed."
    if unsound:
        return (f"No verdict, since {unsound}: such a bed can change the following numbers more "
                f"than the {what} does. {numbers} {packing} The remedies are in the warnings.")
    return f"{numbers} {cause_of_forces(trains, changes)} {packing}"


def place(x: float, behind: float) -> str:
    """Of a row of the histories with its millimetres, since it may be just before or behind the
    end of the structure."""
    side = "behind" if behind >= 0 else "before the end of"
    digits = 2 if abs(behind) >= 0.05 else 3
    return f"at x = {x:.{digits}f} m, {abs(behind):.{digits}f} m {side} the structure"


def clearly_larger(trains: list[Train], changes: list[Change]) -> list[Train]:
    """Those whose largest wheel force in the transition is clearly larger than on plain track."""
    return [train for train, change in zip(trains, changes)
            if change.force > change.force_plain and Difference(
                change.force, change.force_plain, change.force_plain - train.mean_force(),
                "kN").clear]


def cause_of_forces(trains: list[Train], changes: list[Change]) -> str:
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
            ": it belongs to the ripple over the whole bed.")


SAME = (("width", ground_transition.WIDTH, "distance at which the change is reached"),
        ("steepest", ground_transition.STEEPEST, "steepest change"))  # of rail, of ground, words


def beside_ground(rail: Differences, ground: Differences) -> str:
    """A sentence where the ground's surface, which table.txt judges, changes the other way than the
    rail and one of both changes clearly; otherwise empty. {name: Difference} of both."""
    found = [f"the {words} by {ground[below].change:+.0%}, that of the rail by "
             f"{rail[above].change:+.0%}" for above, below, words in SAME
             if rail[above].change * ground[below].change < 0
             and (rail[above].clear or ground[below].clear)]
    if not found:
        return ""
    return (f"At the ground's surface (table.txt) the numbers change the other way: "
            f"{', and '.join(found)}. Stones and rail are between both; the train runs on the "
            "rail.")


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


def sentences(trains: list[Train], changes: list[Change] | None, unsound: str) -> str:
    """The verdict, and how it differs from that on the ground."""
    found = verdict(trains, changes, unsound)
    if unsound or changes is None or why_no_verdict(trains, changes):
        return found
    ground = of_ground([train.run for train in trains])
    other = beside_ground(differences(trains, changes), ground) if ground else ""
    return " ".join(filter(None, (found, other, beside_structure(trains[1].run))))
