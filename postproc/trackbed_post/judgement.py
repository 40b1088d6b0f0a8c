"""The judgement of a difference between two runs, the same for all quantities: is it clear beside
the scatter of plain track, and is it as expected of a wedge?

A bed of stones differs from sleeper to sleeper, also where nothing changes along the track. What a
quantity varies by there is its scatter. Definitions: docs/postproc.md.
"""
import collections.abc
import dataclasses
import math
import pathlib

from trackbed_post import deck_differences, ground_blocks, read

SMALL = 0.9995e-4  # a number that rounds to less than 1e-4 has an exponent
CLEAR = 0.10  # a smaller relative difference is no clear effect
NO_PAIR = "the first run must have all blocks of the second and at least one more (the wedge)"
# Parts of decks in which two designs may differ: the bed of each that `start` names, and what only
# records.
NOT_COMPARED = ("title", "start", "output", "sensor", "region", "passage.points")
CELL = "bed.cell"
PLAIN = "the scatter on plain track"


def shown(value: float, place: bool = False) -> str:
    """A number of a table: three digits, since levels depend on the row from which they count; of a
    place, m, to the millimetre. A dash if it is not known."""
    if not math.isfinite(value):
        return "-"
    if place:
        return f"{round(value, 3) + 0.0:.6g}"
    if abs(value) < SMALL:
        return f"{value:#.3g}"
    digits = 2 - int(f"{abs(value):.2e}".partition("e")[2])  # of the rounded value
    return f"{value:.{max(digits, 0)}f}"


def stated(value: float, unit: str) -> str:
    """A number of a sentence with its unit, the same format in all texts: a distance to 0.1 m,
    others with two digits, or three if there are as many before the point."""
    if unit == "m":
        return f"{value:.1f} m" if abs(value) >= 0.05 else "less than 0.1 m"
    digits = f"{value:.0f}" if abs(value) >= 99.5 else f"{value:#.2g}".rstrip(".")
    return f"{digits} {unit}"


def why_no_comparison(first: read.Results, second: read.Results) -> str:
    """Why places of two runs cannot be compared; empty if they have the same edge."""
    if ground_blocks.same_edge(first, second):
        return ""
    edges = [ground_blocks.edge_of_structure(run) for run in (first, second)]
    ends = [f"{'no structure' if edge is None else f'the structure up to x = {edge:.2f} m'} in "
            f"{run.name}" for run, edge in zip((first, second), edges)]
    return (f"the transitions of both runs are not at the same place: {' and '.join(ends)} (a "
            f"structure is a block of {ground_blocks.RULE})")


def _different_keys(first: read.Results, second: read.Results) -> list[str]:
    """The parameters, besides those of the wedge, in which two decks differ. A cell is compared by
    its name, since the path of its folder changes if results are moved."""
    def flat(deck: read.Deck, path: str = "") -> collections.abc.Iterator[tuple[str, object]]:
        for key, value in deck.items():
            if isinstance(value, dict):
                yield from flat(value, f"{path}{key}.")
            elif not (path + key).startswith(NOT_COMPARED) and path + key != "ground.block":
                yield path + key, pathlib.PurePath(value).name if path + key == CELL else value
    one, other = dict(flat(first.deck)), dict(flat(second.deck))
    differing = [key for key in {**one, **other}
                 if not deck_differences.equal(one.get(key), other.get(key))]
    shared = [block.name for block in ground_blocks.present(second)]
    # A role does not change a run.
    blocks = [{each["name"]: {**each, "role": ""} for each in run.deck["ground"].get("block", [])}
              for run in (first, second)]
    differing += [f"ground.block.{name}" for name in shared if blocks[0][name] != blocks[1][name]]
    return differing


def why_no_pair(first: read.Results, second: read.Results) -> str:
    """Why two runs cannot be judged; empty if the first has the wedge that the second lacks, and
    the decks are equal otherwise."""
    if ground_blocks.differ_by_wedge(first, second):
        keys = _different_keys(first, second)
        more = ground_blocks.more_blocks(first, second)
        what = ground_blocks.listed(more)
        if keys:
            return f"the decks differ in {', '.join(keys)}, not only in the {what}"
        edge = ground_blocks.edge_of_structure(first)  # none: the measurement states it
        if edge is not None and all(ground_blocks.at_other_end(first, block) for block in more):
            return (f"the {what} is at the other end of the structure, which is judged at x = "
                    f"{edge:.2f} m")
        return ""
    if ground_blocks.differ_by_wedge(second, first):
        what = ground_blocks.listed(ground_blocks.more_blocks(second, first))
        return (f"{NO_PAIR}; here the second one, {second.name}, has the {what}: exchange the two "
                "runs in the command")
    if why := why_no_comparison(first, second):
        return why
    more, fewer = (ground_blocks.more_blocks(*pair) for pair in ((first, second), (second, first)))
    if stiff := [block for block in more if block.structure]:
        return (f"{NO_PAIR}; here {ground_blocks.listed(stiff)}, which only the first one has, is "
                f"a structure ({ground_blocks.RULE})")
    if fewer:
        return (f"{NO_PAIR}; here {ground_blocks.listed(fewer)} is in the second one, "
                f"{second.name}, only")
    blocks = ", ".join(block.label for block in ground_blocks.present(first)) or "none"
    return f"{NO_PAIR}; here both have the same blocks: {blocks}"


def measure_words(first: read.Results, second: read.Results) -> str:
    """What only the first run has, behind "expected of"; empty if the runs differ in another way. A
    slab is not called a wedge, although the same is expected of it."""
    if not ground_blocks.differ_by_wedge(first, second):
        return ""
    what = ground_blocks.listed(ground_blocks.more_blocks(first, second))
    return "a wedge" if what == "wedge" else f"the {what}"


@dataclasses.dataclass(frozen=True)
class Difference:
    """Of a quantity of the first run from that of the second; `scatter` is the larger of both runs,
    nan if they have no plain track."""
    first: float
    second: float
    scatter: float
    unit: str                  # of the texts
    factor: float = 1.0        # from the quantity's unit to this one
    wanted: int = 0            # sign of the difference that is expected of a wedge
    beside: str = PLAIN        # what `scatter` is
    reference: float = math.nan  # what the difference is relative to; by default the second value

    @property
    def change(self) -> float:
        """Relative difference; nan if a value is missing, and infinite from a reference of zero to
        another value."""
        reference = self.second if math.isnan(self.reference) else self.reference
        difference = self.first - self.second
        if reference or not difference:
            return difference / abs(reference) if reference else difference
        return math.nan if math.isnan(difference) else math.copysign(math.inf, difference)

    @property
    def relative(self) -> str:
        """The change in words; of one from zero both values, since it has no percentage."""
        if math.isinf(self.change):
            return f"{self.of_text(self.first)} instead of {self.of_text(self.second)}"
        return f"{self.change:+.0%}"

    @property
    def of_itself(self) -> float:
        """Difference relative to the second value; nan if that is zero or missing."""
        return (self.first - self.second) / abs(self.second) if self.second else math.nan

    @property
    def larger_than_scatter(self) -> bool:
        return abs(self.first - self.second) > self.scatter

    @property
    def clear(self) -> bool:
        return abs(self.change) > CLEAR and self.larger_than_scatter

    def of_text(self, value: float) -> str:
        """A value with its unit."""
        return stated(self.factor * value, self.unit)

    @property
    def limit(self) -> str:
        """The scatter with its unit; a sleeper spacing, which is given, as it is."""
        return f"{self.scatter:.3g} m" if self.unit == "m" else self.of_text(self.scatter)

    @property
    def expected(self) -> bool:
        """Whether it has the sign that is expected of a wedge."""
        return (self.first - self.second) * self.wanted > 0

    def words(self, measure: str) -> str:
        """The verdict and the numbers from which it follows; `measure`: what only the first run
        has, from measure_words(), empty if the runs differ in another way."""
        verdict, numbers = self.judged(measure)
        return f"{verdict} ({numbers})" if numbers else verdict

    def judged(self, measure: str) -> tuple[str, str]:
        """(verdict, the numbers from which it follows, or nothing)."""
        limit = f"{self.beside}, {self.limit}"
        difference = f"the difference, {self.of_text(abs(self.first - self.second))}, is"
        if math.isnan(self.change):
            return "no verdict: the change is not known", ""
        if abs(self.change) <= CLEAR:
            return "no clear effect", f"within {CLEAR:.0%}"
        if math.isnan(self.scatter):
            return ("no verdict: there is no plain track with whose scatter it could be compared",
                    "")
        if not self.larger_than_scatter:
            return "no clear effect", f"{difference} not larger than {limit}"
        if not measure:
            return "change relative to the second run", ""
        return (f"{'as' if self.expected else 'NOT as'} expected of {measure}",
                f"{difference} larger than {limit}")
