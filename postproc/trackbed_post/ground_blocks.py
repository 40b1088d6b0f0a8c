"""Blocks of the ground and their roles: unless the deck states a role, a deep block as stiff as
concrete is a structure, every other one is a measure: a wedge, an approach slab, another part of
the ground. Names of blocks decide on the words for a measure, not on its role.

Roles, and the stretch of plain track that follows from them, are explained in docs/postproc.md.
"""
import collections.abc
import dataclasses
import typing

import numpy as np

from trackbed_post import read

STRUCTURE = 10e9  # Pa, least Young's modulus of a structure; concrete has about 30 GPa
DEEP = 0.5        # of the depth of the ground, over which a structure reaches at least
# In words, for messages; a slab on the ground is as stiff, but goes down with the ground below it.
RULE = (f"at least {STRUCTURE / 1e9:g} GPa, from the surface over at least half of the depth of "
        'the ground, or role = "structure"')
TINY = 1e-9       # m, tolerance of coordinates
ENDS = 3          # sleepers at each end of the bed that are not judged if springs are beside them
WALLS = 1         # the same if there are none: the bed ends at walls
BEYOND = 2        # spacings behind the change, where plain track begins


class HasDeck(typing.Protocol):
    """A run, or anything else with a deck."""
    @property
    def deck(self) -> read.Deck: ...


@dataclasses.dataclass(frozen=True)
class Block:
    """A block of the ground; x and z in m."""
    name: str
    young: float              # Pa
    present: bool
    z: float                  # of its top
    bottom: float             # z of its lowest corner
    top: tuple[float, float]  # smallest and largest x there
    x: np.ndarray             # of all corners
    role: str = "auto"        # stated by the deck
    structure: bool = False
    softer: bool = False      # than the layers that it replaces

    @property
    def label(self) -> str:
        return self.name.replace("_", " ")

    @property
    def stiff(self) -> bool:
        return self.young >= STRUCTURE


def _block(given: read.Deck) -> Block:
    """A block of a deck, whose role is not known yet."""
    outline = np.reshape(given["outline"], (-1, 2))
    height = float(np.max(outline[:, 1]))
    top = outline[outline[:, 1] >= height - TINY][:, 0]
    return Block(given["name"], float(given.get("young", 0)), given.get("present", True), height,
                 float(np.min(outline[:, 1])), (float(np.min(top)), float(np.max(top))),
                 outline[:, 0], given.get("role", "auto"))


def _carries(lower: Block, upper: Block) -> bool:
    """Whether a block stands on another one: with half of its length at least, so that a slab whose
    end rests on a ledge of an abutment is no part of it."""
    if not upper.bottom - TINY <= lower.z < upper.z - TINY:
        return False
    low, high = float(np.min(upper.x)), float(np.max(upper.x))
    return min(high, float(np.max(lower.x))) - max(low, float(np.min(lower.x))) \
        >= (high - low) / 2 - TINY


def _structures(stiff: list[Block], depth: float) -> set[str]:
    """Names of the structures among stiff blocks: those at the surface that reach over DEEP of the
    depth, m, together with the stiff blocks below on which they stand, and these."""
    found: set[str] = set()
    for top in (block for block in stiff if block.z >= -TINY):
        column = [top]
        for upper in column:  # grows
            column += [lower for lower in stiff if lower not in column and _carries(lower, upper)]
        if -min(block.bottom for block in column) >= DEEP * depth - TINY:
            found |= {block.name for block in column}
    return found


def depth(results: HasDeck) -> float:
    """Depth of the ground, m: of its layers; of a deck without layers that of the lowest block."""
    ground = results.deck.get("ground", {})
    layers = sum(float(layer["thickness"]) for layer in ground.get("layer", []))
    return layers or -min((_block(block).bottom for block in ground.get("block", [])), default=0.0)


def every(results: HasDeck) -> list[Block]:
    """All blocks of a run's ground in the order of the deck. Those that are present have no other
    ones below them; those that are not have the role that they would have."""
    found = [_block(block) for block in results.deck.get("ground", {}).get("block", [])]
    stiff = [block for block in found if block.stiff and block.role == "auto"]
    there = _structures([block for block in stiff if block.present], depth(results))
    all_present = _structures(stiff, depth(results))
    return [dataclasses.replace(
        block, softer=block.young < _replaced(block, results),
        structure=block.role == "structure" or (
            block.role == "auto" and block.name in (there if block.present else all_present)))
        for block in found]


def _replaced(block: Block, results: HasDeck) -> float:
    """Mean Young's modulus, Pa, of the layers from top to bottom of a block, by their thickness; 0
    if they are not known."""
    top, thick, product = 0.0, 0.0, 0.0
    for layer in results.deck.get("ground", {}).get("layer", []):
        base = top - float(layer["thickness"])
        shared = max(0.0, min(top, block.z) - max(base, block.bottom))
        thick, product = thick + shared, product + shared * float(layer.get("young", 0))
        top = base
    return product / thick if thick else 0.0


def present(results: HasDeck) -> list[Block]:
    """The blocks of a run's ground that are present."""
    return [block for block in every(results) if block.present]


def structures(results: HasDeck) -> list[tuple[float, float]]:
    """Smallest and largest x, m, of each structure at the surface, along x; blocks that touch are
    one."""
    found: list[tuple[float, float]] = []
    for low, high in sorted(block.top for block in present(results)
                            if block.structure and block.z >= -TINY):
        if found and low <= found[-1][1] + TINY:
            found[-1] = (found[-1][0], max(high, found[-1][1]))
        else:
            found.append((low, high))
    return found


@dataclasses.dataclass(frozen=True)
class Stretch:
    """A part of the track with blocks below it: what they are, and the ends along x, m."""
    label: str
    structure: bool
    low: float
    high: float


def stretches(results: HasDeck) -> list[Stretch]:
    """Those of each structure, and one of all measures together."""
    blocks = present(results)
    found = []
    for low, high in structures(results):
        inside = [block.label for block in blocks
                  if block.structure and low - TINY <= block.top[0] <= high + TINY]
        found.append(Stretch(", ".join(inside), True, low, high))
    if soft := measures_of(results):
        found.append(Stretch(listed(soft), False,
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
    """Distance from the edge to the farthest point of any measure, m; includes blocks that are not
    present, so that runs with and without wedge are measured at the same place."""
    edge = edge_of_structure(results)
    if edge is None:
        return 0.0
    turn = direction(results, edge)
    return float(max([0.0] + [np.max(turn * (block.x - edge)) for block in every(results)
                              if not block.structure]))


def measures_of(results: HasDeck) -> list[Block]:
    """The blocks that are present and no structure."""
    return [block for block in present(results) if not block.structure]


def shallow(results: read.Results) -> str:
    """What follows a message that there is no structure: which stiff blocks count as measures."""
    found = [block.label for block in measures_of(results)
             if block.stiff and block.role == "auto"]
    if not found:
        return ""
    verb = "is" if len(found) == 1 else "are"
    return f"; {joined(found)} {verb} stiff enough, but not deep enough"


def is_behind(results: read.Results, block: Block) -> bool:
    """Whether a part of a block is behind the edge of the structure, where changes are measured."""
    edge = edge_of_structure(results)
    return edge is not None and \
        bool(np.max(direction(results, edge) * (block.x - edge)) > TINY)


def at_other_end(results: read.Results, block: Block) -> bool:
    """Whether no part of a block is on the structure or behind its edge."""
    ends, edge = structure(results), edge_of_structure(results)
    if ends is None or edge is None:
        return False
    beyond = np.max(direction(results, edge) * (block.x - edge))
    return bool(beyond <= ends[0] - ends[1] + TINY)


def wedge_words(results: read.Results) -> str:
    """The measures that are present behind the edge of the structure in words; empty if none is."""
    return listed(block for block in measures_of(results) if is_behind(results, block))


def listed(blocks: collections.abc.Iterable[Block]) -> str:
    """What they are in words, each label once, the stiff ones first: parts of a wedge, whose names
    begin with this word, are together a wedge. Softer ones than the ground, as a joint beside a
    slab, are named only if there are no others: they are not what a design is called by."""
    blocks = list(blocks)
    named = [block for block in blocks if not block.softer] or blocks
    return joined(list(dict.fromkeys(
        "wedge" if not block.stiff and block.label.startswith("wedge") else block.label
        for block in sorted(named, key=lambda block: not block.stiff))))


def joined(labels: list[str]) -> str:
    """a, b and c."""
    return " and ".join(filter(None, (", ".join(labels[:-1]), *labels[-1:])))


def more_blocks(first: read.Results, second: read.Results) -> list[Block]:
    """The blocks that are present in the first run only."""
    names = {block.name for block in present(second)}
    return [block for block in present(first) if block.name not in names]


def same_edge(first: read.Results, second: read.Results) -> bool:
    """Whether two runs have their transition at the same place, in the same direction."""
    edges = [edge_of_structure(run) for run in (first, second)]
    if edges[0] is None or edges[1] is None:
        return edges[0] is edges[1]
    return abs(edges[0] - edges[1]) <= TINY and \
        direction(first, edges[0]) == direction(second, edges[1])


def differ_by_wedge(first: read.Results, second: read.Results) -> bool:
    """Whether the first run has measures that the second is without, and no other difference of
    blocks; both have the same edge of the structure."""
    more = more_blocks(first, second)
    return bool(more) and not more_blocks(second, first) and same_edge(first, second) and \
        not any(block.structure for block in more)


def carried_by_springs(results: read.Results) -> bool:
    """Whether the rail goes on over sleepers on springs beside the bed: a train ran over it."""
    passages = [stage for stage in results.deck.get("stage", []) if stage.get("kind") == "passage"]
    return bool(passages and passages[-1].get("train", False))


def ends_at_springs(results: read.Results) -> bool:
    """The same, also of a track on a ground of elements."""
    return results.deck.get("model") == "track_on_ground" or carried_by_springs(results)


def at_ends(count: int, springs: bool) -> np.ndarray:
    """Which of so many sleepers are at the ends of the bed, where their support is that of the
    model's end: ENDS at each end if `springs` are beside them, otherwise WALLS. Of beds that are
    too short for this WALLS, and of one sleeper or two none, since nothing else would remain."""
    each = next((few for few in (ENDS if springs else WALLS, WALLS) if count > 2 * few), 0)
    number = np.arange(count)
    return (number < each) | (number >= count - each)


def ends(results: read.Results) -> np.ndarray:
    """Which sleepers of a run are at the ends of its bed."""
    return at_ends(len(results.sleepers_x), ends_at_springs(results))


def plain_track(results: read.Results, edge: float, changing: float,
                spacing: float) -> tuple[float, float]:
    """Distances from the edge, m, between which the track is plain: from BEYOND spacings behind
    `changing`, the distance over which it changes, m, to the end of the ground, or to BEYOND
    spacings before the next structure; of a run with a train from the first sleeper there to the
    last one that is judged. Nothing is plain if the second is smaller."""
    turn, begin = direction(results, edge), changing + BEYOND * spacing
    ends = [float(np.max(turn * (results.ground_x - edge)))]
    if ends_at_springs(results) and len(results.sleepers_x) > ENDS:
        sleepers = np.sort(turn * (results.sleepers_x - edge))
        ends.append(float(sleepers[-ENDS - 1]))
        begin = float(min(sleepers[sleepers >= begin - TINY], default=begin))
    others = [turn * (x - edge) for span in structures(results) for x in span]
    ends += [x - BEYOND * spacing for x in others if x > TINY]
    return begin, min(ends)
