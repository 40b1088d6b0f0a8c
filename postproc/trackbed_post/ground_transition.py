"""Measures of the ground in a transition zone: response on the structure, on plain track, and the
change between, of one run or of two compared, as text.

Everything is computed from the envelopes of the passage (relative to its begin) and from the deck
stored in the result file.
"""
import collections.abc
import dataclasses

import numpy as np

from trackbed_post import ground_blocks, judgement, measures, read, zones
from trackbed_post.ground_blocks import TINY
from trackbed_post.judgement import CLEAR, Difference
from trackbed_post.measures import NOWHERE
from trackbed_post.zones import REACHED

Runs = collections.abc.Sequence[read.Results]


@dataclasses.dataclass(frozen=True)
class Transition:
    """Displacements are downwards, stresses are compression. nan: the model has no such place."""
    edge: float                     # m, end of the structure
    structure_displacement: float   # m, largest on the structure
    far_displacement: float         # m, median over plain track
    plain_begin: float              # m, x of the ends of plain track, the lower one first
    plain_end: float
    wedge: str                      # the measures behind the edge in words; empty without one
    width: float                    # m, from the edge to REACHED of the change
    steepest: float                 # m/m, ground displacement smoothed over one spacing, whole line
    steepest_x: float               # m, its x
    edge_slope: float               # m/m, the same within one spacing of the edge
    slope_scatter: float            # m/m, the same on plain track
    stress_structure: float         # Pa, mean over one sleeper spacing before the edge
    stress_beyond: float            # Pa, the same behind the edge
    stress_scatter: float           # Pa, largest difference of these means on plain track
    sleeper_displacement: float     # m, largest of those that are not at the ends of the bed
    sleeper_residual_most: float    # m, after the passage: of these the lowest,
    sleeper_residual_least: float   # and the highest; negative if it is raised

    @property
    def stress_jump(self) -> float:
        """Magnitude of the change of stress from before to behind the edge, Pa."""
        return abs(self.stress_structure - self.stress_beyond)

    @property
    def stress_level(self) -> float:
        """Mean stress around the edge, Pa: the reference of a jump."""
        return (self.stress_structure + self.stress_beyond) / 2


def _slopes(distance: np.ndarray, smooth: np.ndarray, plain: np.ndarray, reach: float,
            length: float) -> tuple[float, float, float, float]:
    """Steepest slope and its position, then the steepest within one spacing of the edge and that on
    plain track. `length` of the structure, m: the ground before it is not of this transition. The
    ends, where the mean over a spacing is truncated, are omitted."""
    slope = np.abs(np.gradient(smooth, distance))
    begin = distance[0] + reach / 2
    if distance[0] < -length - TINY:  # soft ground before the structure
        begin = reach - length
    whole = (distance >= begin - TINY) & (distance <= distance[-1] - reach / 2 + TINY)
    where = np.flatnonzero(whole)[np.argmax(slope[whole])]
    at_edge = np.max(slope[np.abs(distance) <= reach + TINY])
    return (float(slope[where]), float(distance[where]), float(at_edge),
            float(np.max(slope[plain & whole])) if plain.any() else NOWHERE)


def _beside(distance: np.ndarray, values: np.ndarray, at: float,
            reach: float) -> tuple[float, float]:
    """Means of the values over a sleeper spacing before and behind a place: the same number of
    nodes on both sides; the node at the place belongs to neither."""
    away = distance - at
    before = (away < -TINY) & (away >= -reach - TINY)
    behind = (away > TINY) & (away <= reach + TINY)
    return float(np.mean(values[before])), float(np.mean(values[behind]))


def _jumps(distance: np.ndarray, values: np.ndarray, plain: np.ndarray, reach: float) -> float:
    """Largest difference of these means at any place of plain track; nan where it is too short."""
    there = distance[plain]
    jumps = [abs(before - behind) for at in there
             if there[0] + reach <= at + TINY and at - TINY <= there[-1] - reach
             for before, behind in [_beside(distance, values, at, reach)]]
    return max(jumps, default=NOWHERE)


def why_no_transition(results: read.Results) -> str:
    """Why a run has no transition; empty if it has one."""
    return measures.why_no_envelope(results) or (
        "" if ground_blocks.edge_of_structure(results) is not None else
        f"{results.name}: the ground needs a structure, a block of {ground_blocks.RULE} (present = "
        "true); at least one of its ends along x must lie inside the ground"
        f"{ground_blocks.shallow(results)}")


def transition(results: read.Results, changing: float | None = None) -> Transition | None:
    """None without a transition (`why_no_transition`). `changing`: distance from the edge over
    which the track changes, m, beyond which plain track begins; by default that of this run."""
    edge, surface = ground_blocks.edge_of_structure(results), zones.surface_of(results)
    if edge is None or surface is None:
        return None
    distance, compression = surface.distance, surface.compression
    reach = measures.spacing(results)
    low, high = ground_blocks.structure(results) or (edge, edge)
    plain = zones.plain_nodes(results, surface,
                              zones.changing([results]) if changing is None else changing)
    steepest, where, at_edge, on_plain = _slopes(distance, surface.smooth, plain, reach, high - low)
    before, behind = _beside(distance, compression, 0.0, reach)
    turn = ground_blocks.direction(results, edge)
    places = edge + turn * distance[plain] if plain.any() else np.array([NOWHERE])
    residual = measures.residual_displacement(results)
    residual = residual[~ground_blocks.ends(results)[:len(residual)]]
    if not (len(residual) and measures.train_has_left(results)):
        residual = np.array([NOWHERE])
    return Transition(
        edge=edge, structure_displacement=surface.on_structure,
        far_displacement=float(np.median(surface.down[plain])) if plain.any() else NOWHERE,
        plain_begin=float(places.min()), plain_end=float(places.max()),
        wedge=ground_blocks.wedge_words(results),
        width=zones.ground_width(surface, plain),
        steepest=steepest, steepest_x=edge + turn * where,
        edge_slope=at_edge, slope_scatter=on_plain, stress_structure=before, stress_beyond=behind,
        stress_scatter=_jumps(distance, compression, plain, reach),
        sleeper_displacement=measures.largest_sleeper_displacement(results),
        sleeper_residual_most=float(np.max(residual)),
        sleeper_residual_least=float(np.min(residual)))


def transitions(runs: Runs) -> list[Transition]:
    """That of each run which has one, all to plain track from the same place."""
    return [one for run, changing in zip(runs, zones.changing_of_each(runs))
            if (one := transition(run, changing))]


ROWS = (  # label, unit, field, factor
    ("largest ground displacement on the structure", "mm", "structure_displacement", 1e3),
    ("median ground displacement on plain track", "mm", "far_displacement", 1e3),
    ("  which begins at x =", "m", "plain_begin", 1),
    ("  and ends at x =", "m", "plain_end", 1),
    (f"width of the transition ({REACHED:.0%} of the change)", "m", "width", 1),
    ("steepest slope of the ground displacement", "mm/m", "steepest", 1e3),
    ("  which is at x =", "m", "steepest_x", 1),
    ("steepest slope within a spacing of the edge", "mm/m", "edge_slope", 1e3),
    ("steepest slope on plain track (scatter)", "mm/m", "slope_scatter", 1e3),
    ("mean stress, last sleeper spacing on structure", "kPa", "stress_structure", 1e-3),
    ("mean stress, first sleeper spacing beyond it", "kPa", "stress_beyond", 1e-3),
    ("stress jump at the edge, difference of these means", "kPa", "stress_jump", 1e-3),
    ("largest such difference on plain track (scatter)", "kPa", "stress_scatter", 1e-3),
    ("largest sleeper displacement in the passage", "mm", "sleeper_displacement", 1e3),
    ("residual displacement of sleeper and ground, largest", "mm", "sleeper_residual_most", 1e3),
    ("residual displacement of sleeper and ground, smallest", "mm", "sleeper_residual_least", 1e3),
)
WIDE = max(len(label) for label, *_ in ROWS) + 1
NOTES = (
    "stresses: added by the passage; without weight of the bed and static preload",
    "residual displacement of sleeper and ground: of a sleeper in the last row, the ground below "
    "it included, negative if it is raised; the largest may be smaller than the largest settlement "
    "into the bed (transition.txt), which is relative to the ground: this still vibrates and may "
    "be above its level at rest")


PLACES = ("plain_begin", "plain_end", "steepest_x")
# Rows without a relative change.
NO_CHANGE = (*PLACES, "slope_scatter", "stress_scatter", "sleeper_residual_most",
             "sleeper_residual_least")


def plain_track(found: collections.abc.Sequence[Transition]) -> str:
    """Plain track in words, of one run or of two: with its ends along x, and the wedge if there is
    one."""
    beyond = next((f" beyond the {one.wedge}" for one in found if one.wedge), "")
    ends = {f"{one.plain_begin:.2f} to {one.plain_end:.2f} m" for one in found}
    known = len(ends) == 1 and np.isfinite(found[0].plain_end)
    return f"plain track{beyond}" + (f" (x = {ends.pop()})" if known else "")


def table(runs: Runs, unsound: str = "") -> str:
    """Text of the results of one or two runs; with two also the change from the second to the
    first, which is the effect of the wedge if only the first has one. `unsound`: why these beds
    have no verdict."""
    found = transitions(runs)
    if len(found) < len(runs):
        reasons = "; ".join(filter(None, map(why_no_transition, runs)))
        return f"no transition to measure: {reasons}\n" + "".join(
            line + "\n" for run in runs for line in measures.warnings(run))
    lines = [*_rows(runs, found), "", *NOTES]
    if left_out := measures.without_ends(*runs):
        lines.append(f"sleepers: {left_out}")
    if not np.isfinite(found[0].far_displacement):
        lines.append(f"this model has no {plain_track(found)}: the width of the transition is not "
                     "defined")
    moved_stones = [line for run in runs for line in measures.warnings(run)]
    lines += moved_stones
    if len(found) == 2:
        lines += _comparison(runs, unsound, bool(moved_stones))
    return "\n".join(lines) + "\n"


def _rows(runs: Runs, found: list[Transition]) -> list[str]:
    """The head and a line for each of ROWS, with the change from the first run to the second."""
    compared = len(runs) == 2 and not judgement.why_no_comparison(*runs)
    head = f"{'downwards and compression positive':<{WIDE}}{'':>6}"
    change_of = f"  change from {runs[0].name} to {runs[-1].name}" if compared else ""
    lines = [head + "".join(f" {run.name:>11}" for run in runs) + change_of]
    for label, unit, field, factor in ROWS:
        values = [getattr(numbers, field) * factor for numbers in found]
        line = f"{label:<{WIDE}}{unit:>6}" + "".join(
            f"{judgement.shown(value, field in PLACES):>12}" for value in values)
        change = Difference(values[-1], values[0], 0, unit).change
        if compared and field not in NO_CHANGE and np.isfinite(change):
            line += f"{f'{change:+.0%}':>{len(change_of)}}"
        lines.append(line)
    return lines


def _comparison(runs: Runs, unsound: str, moved: bool) -> list[str]:
    """What differs between two runs; `moved`: whether stones of one have moved."""
    lines = []
    if runs[0].deck.get("stage") != runs[1].deck.get("stage"):
        lines.append("warning: the two decks differ in their stages")
    if judgement.why_no_comparison(*runs):
        return lines + effects(runs, unsound)
    if moved:
        causes = [f"the {ground_blocks.listed(ground_blocks.more_blocks(*pair))}"
                  for pair in (runs, runs[::-1]) if ground_blocks.differ_by_wedge(*pair)]
        lines.append("warning: differences in the comparison below may have other causes than "
                     f"{(causes or ['what the decks differ by'])[0]}: see the warnings above")
    if ground_blocks.carried_by_springs(runs[0]) and \
            runs[0].deck.get("dimension", "plane") == "plane":
        lines.append(ON_GROUND)
    return lines + effects(runs, unsound)


def effects(runs: Runs, unsound: str = "") -> list[str]:
    """Messages on the differences between two runs, those of table.txt and of the report, or why
    their places cannot be compared; none if a run has no transition."""
    found = transitions(runs)
    if len(runs) != 2 or len(found) != 2:
        return []
    if why := judgement.why_no_comparison(*runs):
        return [f"no comparison: {why}"]
    no_pair = judgement.why_no_pair(*runs)
    reasons = [f"no verdict, since {unsound}"] if unsound else \
        [f"no verdict: {no_pair}"] if no_pair else []
    lines = effect(found[0], found[1], measures.spacing(runs[0]),
                   "" if no_pair else judgement.measure_words(*runs), not unsound)
    base = [f"differences of {runs[0].name} from {runs[1].name}, relative to {runs[1].name}:"]
    return reasons + (base + lines if lines else [])


def differences(first: Transition, second: Transition, spacing: float) -> dict[str, Difference]:
    """Name -> Difference of the quantities in which a wedge should show."""
    def most(field: str) -> float:
        return float(np.maximum(getattr(first, field), getattr(second, field)))

    def of(field: str, scatter: float, unit: str, factor: float, wanted: int,
           beside: str = judgement.PLAIN, reference: float = NOWHERE) -> Difference:
        return Difference(getattr(first, field), getattr(second, field), scatter, unit, factor,
                          wanted, beside, reference)
    slopes = most("slope_scatter")
    return {
        WIDTH: of("width", spacing, "m", 1, 1, "one sleeper spacing"),
        STEEPEST: of("steepest", slopes, "mm/m", 1e3, -1),
        "steepest slope of the ground at the edge": of("edge_slope", slopes, "mm/m", 1e3, -1),
        # A jump may be near zero, so its change is relative to the stress itself.
        JUMP: of("stress_jump", most("stress_scatter"), "kPa", 1e-3, -1,
                 reference=second.stress_level)}


def _named(what: str, found: Difference) -> str:
    """The name of a difference; of one that is relative to something else than its second value,
    with both."""
    if np.isnan(found.reference) or not np.isfinite(found.of_itself):
        return what
    name, relative, to = what.partition(" relative")
    return f"{name} ({found.of_itself:+.0%} of the jump itself){relative}{to}"


ON_GROUND = ("the lines below are about the ground's surface; those about the level of the rail, "
             "over which the train runs, are in transition.txt and may differ, since stones and "
             "rail are between both")
WIDTH = "width of the transition"
STEEPEST = "steepest slope of the ground, whole line"
JUMP = "change of the stress jump relative to the mean stress at the edge"


def effect(first: Transition, second: Transition, spacing: float, measure: str,
           sound: bool) -> list[str]:
    """Messages on the differences between two runs; `measure`: what only the first one has
    (judgement.py), `sound`: whether these beds have a verdict."""
    lines = []
    far = Difference(first.far_displacement, second.far_displacement, 0, "mm", 1e3).change
    differs = abs(far) > CLEAR
    if np.isfinite(far):
        wedge = first.wedge or second.wedge
        nothing = f"neither run has a {wedge} there" if wedge else \
            "it is beyond the transition"
        lines.append(f"ground displacement on {plain_track((first, second))}: {far:+.0%}: " + (
            f"differs by more than {CLEAR:.0%}, although {nothing}: the runs are not comparable"
            if differs else
            f"equal within {CLEAR:.0%}" + (
                ", so the runs are comparable" if sound and measure else "")))
    for what, found in differences(first, second, spacing).items():
        if not np.isnan(found.change):
            # The width refers to the plain track and is meaningless if that differs.
            unclear = differs and found.beside != judgement.PLAIN
            lines.append(f"{_named(what, found)}: {found.relative}" + (
                "" if not sound else ": no verdict, since the plain tracks differ" if unclear else
                f": {found.words(measure)}"))
    return lines
