"""Blocks of the ground and their roles: a block as stiff as concrete is a structure, every other
one is a wedge or another soft part. Names of blocks are labels only.

Roles, and the stretch of plain track that follows from them, are explained in docs/postproc.md.
"""
import dataclasses

import numpy as np

from trackbed_post import read

STRUCTURE = 10e9  # Pa, least Young's modulus of a structure, as in the drawing of `trackbed check`
TINY = 1e-9       # m, tolerance of coordinates
ENDS = 3          # sleepers at each end of the bed that are not judged if springs are beside them
WALLS = 1         # the same if there are none: the bed ends at walls
BEYOND = 2        # spacings behind the wedge, where plain track begins


@dataclasses.dataclass(frozen=True)
class Block:
    """A block of the ground; x in m."""
    name: str
    structure: bool
    present: bool
    z: float                  # m, of its top
    top: tuple[float, float]  # smallest and largest x there
    x: np.ndarray             # of all corners

    @property
    def label(self) -> str:
        return self.name.replace("_", " ")


def is_structure(block: read.Deck) -> bool:
    """Whether a block of a deck is as stiff as concrete."""
    return float(block.get("young", 0)) >= STRUCTURE


def every(results: read.Results) -> list[Block]:
    """All blocks of a run's ground, also those that are not present."""
    found = []
    for block in results.deck.get("ground", {}).get("block", []):
        outline = np.reshape(block["outline"], (-1, 2))
        height = float(np.max(outline[:, 1]))
        top = outline[outline[:, 1] >= height - TINY][:, 0]
        found.append(Block(block["name"], is_structure(block), block.get("present", True), height,
                           (float(np.min(top)), float(np.max(top))), outline[:, 0]))
    return found


def present(results: read.Results) -> list[Block]:
    """The blocks of a run's ground that are present."""
    return [block for block in every(results) if block.present]


def structures(results: read.Results) -> list[tuple[float, float]]:
    """Smallest and largest x, m, of each structure, along x; blocks that touch are one, and those
    that do not reach as high as the others are foundations."""
    stiff = [block for block in present(results) if block.structure]
    height = max((block.z for block in stiff), default=0.0)
    found: list[tuple[float, float]] = []
    for low, high in sorted(block.top for block in stiff if block.z >= height - TINY):
        if found and low <= found[-1][1] + TINY:
            found[-1] = (found[-1][0], max(high, found[-1][1]))
        else:
            found.append((low, high))
    return found


@dataclasses.dataclass(frozen=True)
class Stretch:
    """A part of the track with blocks below it: their labels, and the ends along x, m."""
    label: str
    structure: bool
    low: float
    high: float


def stretches(results: read.Results) -> list[Stretch]:
    """Those of each structure, and one of all other blocks together."""
    blocks = present(results)
    found = []
    for low, high in structures(results):
        inside = [block.label for block in blocks
                  if block.structure and low - TINY <= block.top[0] <= high + TINY]
        found.append(Stretch(", ".join(inside), True, low, high))
    if soft := [block for block in blocks if not block.structure]:
        found.append(Stretch(", ".join(block.label for block in soft), False,
                             min(block.top[0] for block in soft),
                             max(block.top[1] for block in soft)))
    return found


def structure(results: read.Results) -> tuple[float, float] | None:
    """Ends of the structure behind which a transition is measured: the first along x with an end
    inside the ground; None without one."""
    if not len(results.ground_x):
        return None
    low, high = np.min(results.ground_x), np.max(results.ground_x)
    return next((ends for ends in structures(results) if any(low < x < high for x in ends)), None)


def edge_of_structure(results: read.Results) -> float | None:
    """x of the end of the structure that is inside the ground, of two the upper one, m; None
    without a structure."""
    ends = structure(results)
    if ends is None:
        return None
    low, high = np.min(results.ground_x), np.max(results.ground_x)
    return next(x for x in ends[::-1] if low < x < high)


def direction(results: read.Results, edge: float) -> int:
    """+1 or -1: the direction away from the structure, of which the edge is the upper or the lower
    end along x."""
    ends = structure(results)
    return 1 if ends is None or abs(edge - ends[1]) <= abs(edge - ends[0]) else -1


def wedge_length(results: read.Results) -> float:
    """Distance from the edge to the farthest point of any block that is no structure, m; includes
    blocks that are not present, so that runs with and without wedge are measured at the same
    place."""
    edge = edge_of_structure(results)
    if edge is None:
        return 0.0
    turn = direction(results, edge)
    return float(max([0.0] + [np.max(turn * (block.x - edge)) for block in every(results)
                              if not block.structure]))


def has_wedge(results: read.Results) -> bool:
    """Whether a block that is no structure is present behind the edge of the structure."""
    edge = edge_of_structure(results)
    if edge is None:
        return False
    turn = direction(results, edge)
    return any(not block.structure and np.max(turn * (block.x - edge)) > TINY
               for block in present(results))


def differ_by_wedge(first: read.Results, second: read.Results) -> bool:
    """Whether the first run has blocks of the ground that the second is without, none of them a
    structure, and no other difference of blocks."""
    one, other = ({block.name: block.structure for block in present(run)}
                  for run in (first, second))
    more = one.keys() - other.keys()
    return bool(more) and other.keys() < one.keys() and not any(one[name] for name in more)


def carried_by_springs(results: read.Results) -> bool:
    """Whether the rail goes on over sleepers on springs beside the bed: a train ran over it."""
    passages = [stage for stage in results.deck.get("stage", []) if stage.get("kind") == "passage"]
    return bool(passages and passages[-1].get("train", False))


def at_ends(count: int, springs: bool) -> np.ndarray:
    """Which of so many sleepers are at the ends of the bed, where their support is that of the
    model's end: ENDS at each end if `springs` are beside them, otherwise WALLS. Of beds that are
    too short for this WALLS, and of one sleeper or two none, since nothing else would remain."""
    each = next((few for few in (ENDS if springs else WALLS, WALLS) if count > 2 * few), 0)
    number = np.arange(count)
    return (number < each) | (number >= count - each)


def ends(results: read.Results) -> np.ndarray:
    """Which sleepers of a run are at the ends of its bed."""
    return at_ends(len(results.sleepers_x), carried_by_springs(results))


def plain_track(results: read.Results, edge: float, wedge: float,
                spacing: float) -> tuple[float, float]:
    """Distances from the edge, m, between which the track is plain: from BEYOND spacings behind the
    wedge (of this length, m) to the end of the ground, to the last sleeper that is judged, or to
    BEYOND spacings before the next structure. Nothing is plain if the second is smaller."""
    turn = direction(results, edge)
    ends = [float(np.max(turn * (results.ground_x - edge)))]
    if carried_by_springs(results) and len(results.sleepers_x) > ENDS:
        ends.append(float(np.sort(turn * (results.sleepers_x - edge))[-ENDS - 1]))
    others = [turn * (x - edge) for span in structures(results) for x in span]
    ends += [x - BEYOND * spacing for x in others if x > TINY]
    return wedge + BEYOND * spacing, min(ends)
