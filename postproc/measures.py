"""Numbers of a transition zone: what lies on the structure, beyond it, and what changes between.

Everything is computed from the envelopes of the passage (relative to its begin) and from the deck
stored in the result file; nothing is typed in.
"""
import dataclasses

import numpy as np

REACHED = 0.9  # the transition ends where this part of the way to the far value is behind


@dataclasses.dataclass(frozen=True)
class Transition:
    edge: float                     # m, end of the structure
    structure_displacement: float   # m, downwards, largest on the structure
    far_displacement: float         # m, downwards, median over the last quarter of the way
    width: float                    # m, from the edge to REACHED of the way
    stress_structure: float         # Pa, compression, mean over one sleeper spacing before the edge
    stress_beyond: float            # Pa, and the same behind it
    stress_jump: float              # Pa, highest before minus lowest behind, same two stretches
    sleeper_displacement: float     # m, downwards, largest of all sleepers
    steepest: float                 # m/m, smoothed ground displacement, two spacings from the edge


def spacing(results):
    """m between sleepers."""
    return float(np.median(np.diff(results.sleepers_x))) if len(results.sleepers_x) > 1 else 0.6


def blocks(results):
    """{name: (smallest x, largest x) at the top} of the ground's blocks that are present."""
    found = {}
    for block in results.deck.get("ground", {}).get("block", []):
        outline = np.reshape(block["outline"], (-1, 2))
        top = outline[outline[:, 1] >= np.max(outline[:, 1]) - 1e-9]
        if block.get("present", True):
            found[block["name"]] = (float(np.min(top[:, 0])), float(np.max(top[:, 0])))
    return found


def edge_of_structure(results):
    """x of the end of the block named structure that lies inside the ground; None without one."""
    ends = blocks(results).get("structure")
    if ends is None or not len(results.ground_x):
        return None
    low, high = np.min(results.ground_x), np.max(results.ground_x)
    inside = [x for x in ends[::-1] if low < x < high]
    return inside[0] if inside else None


def smoothed(x, values, width):
    """Mean of the values within +-width/2 of each x: stones press on single nodes."""
    return np.array([np.mean(values[np.abs(x - place) <= width / 2 + 1e-9]) for place in x])


def _orderly(results):
    """x from the edge on into the soft ground, and downward displacement and compression there.

    The soft side is the longer one, so that a structure may stand at either end.
    """
    edge = edge_of_structure(results)
    if edge is None or "displacement_min" not in results.ground_envelope:
        return None
    way = results.ground_x - edge
    if -np.min(way) > np.max(way):
        way = -way
    order = np.argsort(way)
    down = -results.ground_envelope["displacement_min"].values
    compression = -results.ground_envelope["sigma_z_min"].values
    return edge, way[order], down[order], compression[order]


def _width(way, down, start, end):
    """Where `down` first has come REACHED of the way from start to end; nan if never."""
    reached = np.flatnonzero((way > 0) & ((down - start) * np.sign(end - start)
                                          >= REACHED * abs(end - start)))
    return float(way[reached[0]]) if len(reached) else float("nan")


def transition(results):
    """The Transition of a run, or None if it has no structure or no ground."""
    parts = _orderly(results)
    if parts is None:
        return None
    edge, way, down, compression = parts
    reach = spacing(results)
    smooth = smoothed(way, down, reach)
    start, end = np.max(down[way <= 0]), np.median(down[way >= 0.75 * way[-1]])
    before, behind = (way <= 0) & (way >= -reach), (way > 0) & (way <= reach)
    sleeper = results.sleeper_envelope.get("displacement_min")
    return Transition(
        edge=edge, structure_displacement=float(start), far_displacement=float(end),
        width=_width(way, smooth, start, end),
        stress_structure=float(np.mean(compression[before])),
        stress_beyond=float(np.mean(compression[behind])),
        stress_jump=float(np.max(compression[before]) - np.min(compression[behind])),
        sleeper_displacement=float(np.max(-sleeper.values)) if sleeper else float("nan"),
        steepest=float(np.max(np.abs(np.gradient(smooth, way))[(way >= 0) & (way <= 2 * reach)])))


def loading_frequencies(results):
    """{name: Hz}: v over bogie centres and v over wheelbase, from the deck's [load]."""
    load = results.deck.get("load", {})
    axles, speed = np.asarray(load.get("axles", [])), load.get("speed", 0.0)
    found = {}
    if len(axles) >= 4:
        found["v/L_c"] = speed / (np.mean(axles[2:4]) - np.mean(axles[:2]))
    if len(axles) >= 2:
        found["v/L_w"] = speed / (axles[1] - axles[0])
    return found


ROWS = (  # label, unit, field, factor
    ("ground surface displacement on the structure", "mm", "structure_displacement", 1e3),
    ("ground surface displacement far beyond it", "mm", "far_displacement", 1e3),
    (f"width of the transition ({REACHED:.0%} of the way)", "m", "width", 1),
    ("steepest slope, two spacings from the edge", "mm/m", "steepest", 1e3),
    ("stress before the edge, mean of one spacing", "kPa", "stress_structure", 1e-3),
    ("stress behind the edge, mean of one spacing", "kPa", "stress_beyond", 1e-3),
    ("stress jump at the edge, highest - lowest", "kPa", "stress_jump", 1e-3),
    ("largest sleeper displacement", "mm", "sleeper_displacement", 1e3),
)


def table(runs):
    """Text of the numbers of one or two runs; with two also the change from the second to the
    first, which is the wedge's effect if the first has one and the second has none."""
    found = [transition(run) for run in runs]
    if any(numbers is None for numbers in found):
        return "no structure or no ground in the model: no transition to measure\n"
    head = f"{'downwards and compression positive':<48}{'':>6}"
    lines = [head + "".join(f"{run.name:>12}" for run in runs)
             + (f"{'change':>10}" if len(runs) == 2 else "")]
    for label, unit, field, factor in ROWS:
        values = [getattr(numbers, field) * factor for numbers in found]
        line = f"{label:<48}{unit:>6}" + "".join(f"{value:12.4g}" for value in values)
        if len(values) == 2 and values[1]:
            line += f"{values[0] / values[1] - 1:+10.1%}"
        lines.append(line)
    if len(found) == 2:
        lines += ["", *effect(*found)]
    return "\n".join(lines) + "\n"


def effect(first, second):
    """Sentences on the sign of what distinguishes the first run from the second."""
    def sentence(what, field, good):
        a, b = getattr(first, field), getattr(second, field)
        return f"{what}: {a:.4g} against {b:.4g}: {'as' if good(a, b) else 'NOT as'} a wedge should"
    return [
        sentence("displacement far beyond is not larger (m)", "far_displacement",
                 lambda a, b: a <= b),
        sentence("transition is wider (m)", "width", lambda a, b: a > b),
        sentence("slope is gentler (m/m)", "steepest", lambda a, b: a < b),
        sentence("stress jump is smaller (Pa)", "stress_jump", lambda a, b: a < b)]
