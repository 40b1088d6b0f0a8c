"""Measures of the ground in a transition zone: response on the structure, on plain track, and the
change between, of one run or of two compared, as text.

Everything is computed from the envelopes of the passage (relative to its begin) and from the deck
stored in the result file.
"""
import collections.abc
import dataclasses

import numpy as np

from trackbed_post import ground_blocks, measures, read
from trackbed_post.ground_blocks import TINY
from trackbed_post.measures import NOWHERE

Runs = collections.abc.Sequence[read.Results]
REACHED = 0.9    # the transition ends where this fraction of the change is reached
CLEAR = 0.10     # a smaller relative difference of two runs is no clear effect


@dataclasses.dataclass(frozen=True)
class Transition:
    """Displacements are downwards, stresses are compression. nan: the model has no such place."""
    edge: float                     # m, end of the structure
    structure_displacement: float   # m, largest on the structure
    far_displacement: float         # m, median over the plain track beyond the wedge
    width: float                    # m, from the edge to REACHED of the change
    steepest: float                 # m/m, ground displacement smoothed over one spacing, whole line
    steepest_x: float               # m, its x
    edge_slope: float               # m/m, the same within one spacing of the edge
    stress_structure: float         # Pa, mean over one sleeper spacing before the edge
    stress_beyond: float            # Pa, the same behind the edge
    sleeper_displacement: float     # m, largest of all sleepers
    sleeper_residual: float         # m, largest magnitude after the passage

    @property
    def stress_jump(self) -> float:
        """Magnitude of the change of stress from before to behind the edge, Pa."""
        return abs(self.stress_structure - self.stress_beyond)

    @property
    def stress_level(self) -> float:
        """Mean stress around the edge, Pa: the reference of a jump."""
        return (self.stress_structure + self.stress_beyond) / 2


def _orderly(results: read.Results, edge: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distance from the edge into the soft ground, m, with displacement and compression."""
    distance = ground_blocks.direction(results, edge) * (results.ground_x - edge)
    order = np.argsort(distance)
    down = -results.ground_envelope["displacement_min"].values
    compression = -results.ground_envelope["sigma_z_min"].values
    return distance[order], down[order], compression[order]


def _width(distance: np.ndarray, down: np.ndarray, start: float, end: float) -> float:
    """Where `down` first reaches REACHED of the change from start to end; nan if never."""
    reached = np.flatnonzero((distance > TINY) & ((down - start) * np.sign(end - start)
                                          >= REACHED * abs(end - start)))
    return float(distance[reached[0]]) if len(reached) and np.isfinite(end) else NOWHERE


def _plain(distance: np.ndarray, begin: float, end: float, reach: float) -> np.ndarray:
    """Which of the distances are on plain track: none if it is shorter than a sleeper spacing."""
    if end - begin < reach - TINY:
        return np.zeros(len(distance), dtype=bool)
    return (distance >= begin - TINY) & (distance <= end + TINY)


def _slopes(distance: np.ndarray, smooth: np.ndarray, reach: float) -> tuple[float, float, float]:
    """Steepest slope and its position, then the steepest within one spacing of the edge. The ends,
    where the mean over a spacing is truncated, are omitted."""
    slope = np.abs(np.gradient(smooth, distance))
    whole = ((distance >= distance[0] + reach / 2 - TINY)
             & (distance <= distance[-1] - reach / 2 + TINY))
    where = np.flatnonzero(whole)[np.argmax(slope[whole])]
    at_edge = np.max(slope[np.abs(distance) <= reach + TINY])
    return float(slope[where]), float(distance[where]), float(at_edge)


def why_no_transition(results: read.Results) -> str:
    """Why a run has no transition; empty if it has one."""
    return measures.why_no_envelope(results) or (
        "" if ground_blocks.edge_of_structure(results) is not None else
        f"{results.name}: the ground needs a structure, a block with young of at least "
        f"{ground_blocks.STRUCTURE / 1e9:g} GPa (present = true); at least one of its ends along x "
        "must lie inside the ground")


def transition(results: read.Results, wedge: float = 0.0) -> Transition | None:
    """None without a transition (`why_no_transition`). `wedge`: least distance from the edge at
    which plain track begins, m (that of another run's wedge)."""
    edge = ground_blocks.edge_of_structure(results)
    if edge is None or why_no_transition(results):
        return None
    distance, down, compression = _orderly(results, edge)
    reach = measures.spacing(results)
    smooth = measures.smoothed(distance, down, reach)
    start = float(np.max(down[distance <= TINY]))
    wedge = max(wedge, ground_blocks.wedge_length(results))
    plain = _plain(distance, *ground_blocks.plain_track(results, edge, wedge, reach), reach)
    end = float(np.median(down[plain])) if plain.any() else NOWHERE
    steepest, where, at_edge = _slopes(distance, smooth, reach)
    # The same number of nodes on both sides; the node at the edge belongs to neither.
    before = (distance < -TINY) & (distance >= -reach - TINY)
    behind = (distance > TINY) & (distance <= reach + TINY)
    sleeper, residual = results.sleeper_envelope.get("displacement_min"), \
        measures.residual_displacement(results)
    return Transition(
        edge=edge, structure_displacement=start, far_displacement=end,
        width=_width(distance, smooth, start, end),
        steepest=steepest, steepest_x=edge + ground_blocks.direction(results, edge) * where,
        edge_slope=at_edge,
        stress_structure=float(np.mean(compression[before])),
        stress_beyond=float(np.mean(compression[behind])),
        sleeper_displacement=float(np.max(-sleeper.values)) if sleeper else NOWHERE,
        sleeper_residual=float(np.max(np.abs(residual))) if len(residual) else NOWHERE)


ROWS = (  # label, unit, field, factor
    ("largest ground displacement on the structure", "mm", "structure_displacement", 1e3),
    ("median ground displacement on plain track", "mm", "far_displacement", 1e3),
    (f"width of the transition ({REACHED:.0%} of the change)", "m", "width", 1),
    ("steepest slope of the ground displacement", "mm/m", "steepest", 1e3),
    ("  which is at x =", "m", "steepest_x", 1),
    ("steepest slope within a spacing of the edge", "mm/m", "edge_slope", 1e3),
    ("mean stress, last sleeper spacing on structure", "kPa", "stress_structure", 1e-3),
    ("mean stress, first sleeper spacing beyond it", "kPa", "stress_beyond", 1e-3),
    ("stress jump at the edge, difference of these means", "kPa", "stress_jump", 1e-3),
    ("largest sleeper displacement in the passage", "mm", "sleeper_displacement", 1e3),
    ("largest residual sleeper displacement after it", "mm", "sleeper_residual", 1e3),
)


PLACES = ("steepest_x",)  # rows without a meaningful relative change


def table(runs: Runs) -> str:
    """Text of the results of one or two runs; with two also the change from the second to the
    first, which is the effect of the wedge if only the first has one."""
    wedge = max(ground_blocks.wedge_length(run) for run in runs)
    found = [one for run in runs if (one := transition(run, wedge))]
    if len(found) < len(runs):
        reasons = "; ".join(filter(None, map(why_no_transition, runs)))
        return f"no transition to measure: {reasons}\n" + "".join(
            line + "\n" for run in runs for line in measures.warnings(run))
    head = f"{'downwards and compression positive':<48}{'':>6}"
    lines = [head + "".join(f"{run.name:>12}" for run in runs)
             + (f"{'change':>10}" if len(runs) == 2 else "")]
    for label, unit, field, factor in ROWS:
        values = [getattr(numbers, field) * factor for numbers in found]
        line = f"{label:<48}{unit:>6}" + "".join(
            f"{value:12.4g}" if np.isfinite(value) else f"{'-':>12}" for value in values)
        if len(values) == 2 and values[1] and np.all(np.isfinite(values)) and field not in PLACES:
            line += f"{values[0] / values[1] - 1:+10.1%}"
        lines.append(line)
    lines += ["", "stresses: added by the passage; without weight of the bed and static "
              "preload"]
    if not np.isfinite(found[0].far_displacement):
        lines.append("this model has no plain track beyond the wedge: the width of the transition "
                     "is not defined")
    moved_stones = [line for run in runs for line in measures.warnings(run)]
    lines += moved_stones
    if len(found) == 2:
        if runs[0].deck.get("stage") != runs[1].deck.get("stage"):
            lines.append("warning: the two decks differ in their stages")
        if moved_stones:
            lines.append("warning: differences in the comparison below may have other causes than "
                         "the wedge: see the warnings above")
        lines += effect(found[0], found[1], ground_blocks.differ_by_wedge(*runs))
    return "\n".join(lines) + "\n"


def _verdict(change: float, wanted: int, by_wedge: bool) -> str:
    """`change`: relative; `wanted`: its sign under a wedge, in the first run only."""
    if abs(change) <= CLEAR:
        return f"no clear effect (within {CLEAR:.0%})"
    if not by_wedge:
        return ("change relative to the second run; no verdict: the first run must contain all "
                "blocks of the ground of the second and at least one more (the wedge)")
    return f"{'as' if change * wanted > 0 else 'NOT as'} expected of a wedge"


def _change(a: float, b: float) -> float:
    """Change relative to the second value; nan if either is missing or the second is zero."""
    return a / b - 1 if b and np.isfinite(a) and np.isfinite(b) else NOWHERE


def effect(first: Transition, second: Transition, by_wedge: bool) -> list[str]:
    """Messages on the differences between two runs; `by_wedge`: only the first has a wedge."""
    lines = []
    far = _change(first.far_displacement, second.far_displacement)
    differs = np.isfinite(far) and abs(far) > CLEAR
    if np.isfinite(far):
        lines.append(f"ground displacement on plain track beyond the wedge: {far:+.0%}: " + (
            f"equal within {CLEAR:.0%}, so the runs are comparable" if abs(far) <= CLEAR else
            f"differs by more than {CLEAR:.0%}, although neither run has a wedge there: the runs "
            "are not comparable"))
    for what, field, wanted in (("width of the transition", "width", 1),
                                ("steepest slope, whole line", "steepest", -1),
                                ("slope at the edge", "edge_slope", -1)):
        change = _change(getattr(first, field), getattr(second, field))
        if not np.isfinite(change):
            continue
        # The width refers to the plain track and is meaningless if that differs.
        unclear = differs and field == "width"
        lines.append(f"{what}: {change:+.0%}: " + (
            "no verdict, since the plain tracks differ" if unclear
            else _verdict(change, wanted, by_wedge)))
    # A jump may be near zero, so its change is relative to the stress itself.
    if second.stress_level:
        change = (first.stress_jump - second.stress_jump) / abs(second.stress_level)
        lines.append("change of the stress jump relative to the mean stress at the edge: "
                     f"{change:+.0%}: "
                     f"{_verdict(change, -1, by_wedge)}")
    return lines
