"""Which figures a run has: that follows from its deck."""
import collections.abc
import contextlib
import dataclasses
import functools
import pathlib

from trackbed_post import (bed_on_ground, laboratory, overlays, read, track_figures,
                           train_figures, transition, write)

# Runs side by side. The bed below a train: without what shows the end of a stage, when it has left.
TOGETHER: dict[str, collections.abc.Callable[..., None]] = {
    "transition": transition.draw_into, "bed": bed_on_ground.draw_into,
    "bed_below_train": functools.partial(bed_on_ground.draw_into, ends=False),
    "laboratory": laboratory.draw_into}
ALONE = {"train": train_figures.draw_into, "track": track_figures.draw_into}  # one run only
BESIDE = {"track": track_figures.compare_into}  # several runs of a kind in ALONE
KINDS = (*TOGETHER, *ALONE)
PAIRS = {"transition", "bed", "bed_below_train"}  # of at most two runs
LABORATORY = {"shear", "triaxial", "lift_walls"}  # kinds of stages, besides several to compact


def has_no_stones(deck: read.Deck) -> bool:
    return deck.get("model") in ("track", "track_on_ground")


def of_deck(deck: read.Deck) -> list[str]:
    """Kinds of figures of a run."""
    stages = deck.get("stage", [])
    if has_no_stones(deck):
        return ["track"]
    if any(stage.get("train") for stage in stages):
        plane = deck.get("dimension") == "plane"
        return [*(["transition"] if plane else []), "train", "bed_below_train"]
    kinds = [stage.get("kind") for stage in stages]
    if LABORATORY & set(kinds) or kinds.count("compact") > 1:
        return ["laboratory"]
    return ["bed"]


def require_comparable(decks: collections.abc.Iterable[read.Deck]) -> None:
    if len({has_no_stones(deck) for deck in decks}) > 1:
        raise read.Unreadable("a track without stones and a bed of stones cannot be compared")


def require_stones(runs: collections.abc.Sequence[pathlib.Path],
                   decks: collections.abc.Sequence[read.Deck], kind: str) -> None:
    """A track without stones has sleepers too, those nearest to its points, but no bed."""
    for run, deck in zip(runs, decks):
        if kind and kind not in BESIDE and has_no_stones(deck):
            raise read.Unreadable(
                f"{run.resolve().name}: figures of kind {kind} need a bed of stones; this run "
                f'(model = "{deck["model"]}") has figures of kind {", ".join(of_deck(deck))}')


@dataclasses.dataclass(frozen=True)
class Part:
    """Figures of one kind of one run or several."""
    kind: str
    results: list[pathlib.Path]
    draw: collections.abc.Callable[[write.Folder], None]
    number: int = 0  # of the run, for figures of one run only


def parts_of(results: collections.abc.Sequence[pathlib.Path],
             kinds: collections.abc.Iterable[str]) -> collections.abc.Iterator[Part]:
    """Parts of runs: kinds that cannot be drawn in one picture once for each run, those of two runs
    for the first run with each of the others."""
    for kind in kinds:
        if kind in BESIDE and len(results) > 1:
            yield Part(kind, list(results), functools.partial(BESIDE[kind], list(results)))
        groups = [(0, list(results))]
        if kind in ALONE:
            groups = list(enumerate([path] for path in results))
        elif kind in PAIRS and len(results) > 2:
            groups = [(k, [results[0], other]) for k, other in enumerate(results[1:], 1)]
        draw = ALONE.get(kind) or TOGETHER[kind]
        yield from (Part(kind, group, functools.partial(draw, group), number)
                    for number, group in groups)


def draw_figures(results: collections.abc.Sequence[pathlib.Path | str], path: pathlib.Path | str,
                 kind: str = "", formats: collections.abc.Sequence[str] = ("png",),
                 over: overlays.Overlays | None = None) -> list[write.Folder]:
    """Draws all figures of runs (given by their folders), or those of one kind, into a folder;
    the folders that were written. Runs that cannot be compared in one picture have a folder each,
    with number and name, below it. `over`: curves over the figures."""
    runs = [read.folder_of(one) for one in results]
    decks = [read.origin(one)[1] for one in runs]
    require_comparable(decks)
    require_stones(runs, decks, kind)
    kinds = [kind] if kind else of_deck(decks[0])
    folders: list[write.Folder] = []
    problem = None
    for part in parts_of(runs, kinds):
        below = pathlib.Path(path)
        if len(runs) > len(part.results):
            below = below / f"{part.number + 1}_{part.results[-1].resolve().name}"
        folder = write.Folder(below, write.origin_of(part.results), formats, over)
        try:
            part.draw(folder)
        except read.Unreadable as why:
            if why.code != read.Unreadable.code or kind:
                raise
            problem = why
            folder.remarks.append(f"{part.kind}: {why}")
            with contextlib.suppress(OSError):  # not empty
                folder.path.rmdir()
        folders.append(folder)
    if problem and not any(folder.pictures for folder in folders):
        raise problem
    return folders
