"""The transition of a track on a ground of elements: levels of rail and sleepers and wheel forces
from the structure to plain track, of one run or of two designs, judged as those of a bed
(transition.py). All x are those of the ground.
"""
import collections
import dataclasses
import pathlib
import typing

import numpy as np

from trackbed_post import (axles, bed_warnings, ground_blocks, measures, panels, passage_warnings,
                           read, track_stretch, transition, transition_caption, transition_figures,
                           transition_verdict, write)

NEAR = 1e-6  # m, between the places of the envelope and those that follow from the deck
# Sleepers at an end of the ground that are left out, besides those that ground_blocks does not
# judge: together 3 to 4 m, over which a rail carries the step to the springs into the ground.
BESIDE_SPRINGS = 3
# Depths of the ground over which its soft end changes its displacements: rollers mirror the load.
# In inputs/track/netirail_2d.toml, 9 m deep, levels vary over the last 18 m, of 60 as of 90 m.
MIRRORED = 2.0
ENVELOPES = [f"envelope/{what}/displacement_min" for what in ("rail", "sleeper")]


@dataclasses.dataclass(frozen=True)
class TrackOnGround(transition.LoadedTrack):
    """Levels are the lowest of all steps, relative to the track without load; of two rails the
    mean. `run` has the places of the ground's sleepers."""
    run: read.Results
    every: read.Quantities
    ground: track_stretch.Ground
    name: str = ""
    stones: typing.ClassVar[bool] = False
    spread: typing.ClassVar[str] = "variation"
    of_mean: typing.ClassVar[str] = "all wheels over the ground"

    @property
    def axis(self) -> str:
        return f"x of the ground, m (from the start of the track: plus {self.ground.origin:g} m)"

    @property
    def bin(self) -> float:
        """Between two sleepers, where the force has one maximum."""
        return measures.spacing(self.run)

    def heading(self) -> str:
        deck = self.run.deck
        train, plane = deck.get("train", {}), deck.get("dimension", "plane") == "plane"
        model = f"plane model, {deck.get('thickness', 0):g} m thick" if plane else "model in space"
        names = collections.Counter(map(str, train.get("vehicles", [])))
        vehicles = ", ".join(f"{count} {name}" for name, count in names.items())
        return panels.wrapped(
            f"{deck.get('title', self.run.name)} ({vehicles}, {3.6 * train.get('speed', 0):.0f} "
            f"km/h; track on a ground, {model})", 10, 11)

    def _down(self, name: str) -> np.ndarray:
        x, low = (self.every[path].values.ravel() for path in ("envelope/x", name))
        there = [np.abs(x - place) < NEAR for place in self.ground.sleepers]
        return np.array([-low[one].mean() for one in there])

    def rail_down(self) -> np.ndarray:
        return self._down(ENVELOPES[0])

    def sleeper_down(self) -> np.ndarray:
        return self._down(ENVELOPES[1])

    def wheels(self) -> tuple[np.ndarray, np.ndarray]:
        x = track_stretch.history(self.every, "wheel/x").ravel() - self.ground.origin
        force = track_stretch.history(self.every, "wheel/force").ravel()
        known = np.isfinite(x) & np.isfinite(force)
        return x[known], force[known]

    def mean_force(self) -> float:
        x, force = self.wheels()
        low, high = self.run.sleepers_x[[0, -1]]
        return float(force[(x >= low) & (x <= high)].mean())

    def warnings(self) -> list[bed_warnings.BedWarning]:
        folder = self.run.folder
        summary = read.summary(folder) if folder else {}
        return passage_warnings.warnings_of_track(self.every, self.run.deck, summary)


def of_folder(folder: pathlib.Path) -> TrackOnGround | None:
    """None of a run without a structure in its ground, without a train, or without the envelopes,
    and of one with too few sleepers, or whose train has not reached them."""
    run, every = read.results(folder), read.datasets(folder)
    ground = track_stretch.ground_of(run.deck)
    needed = {*ENVELOPES, "envelope/x", "history/wheel/force", "history/wheel/x"}
    if ground is None or not needed <= every.keys():
        return None
    places = dataclasses.replace(run, ground_x=np.array(ground.extent) - ground.origin)
    kept = dataclasses.replace(ground, sleepers=ground.sleepers[_undisturbed(places, ground)])
    if len(kept.sleepers) <= 2 * ground_blocks.ENDS or \
            not axles.reached(track_stretch.history(every, "wheel/x"), kept.sleepers).all():
        return None
    placed = dataclasses.replace(places, sleepers_x=kept.sleepers - ground.origin)
    found = TrackOnGround(placed, every, kept, run.name)
    return found if ground_blocks.edge_of_structure(placed) is not None else None


def _undisturbed(run: read.Results, ground: track_stretch.Ground) -> np.ndarray:
    """Which sleepers are far enough from the ends of the ground not to be moved by them:
    BESIDE_SPRINGS behind an end in a structure, MIRRORED depths behind a soft one."""
    x = ground.sleepers - ground.origin
    number = np.arange(len(x))
    kept = (number >= BESIDE_SPRINGS) & (number < len(x) - BESIDE_SPRINGS)
    reach = MIRRORED * ground_blocks.depth(run)
    for end in run.ground_x:
        if not any(low - NEAR <= end <= high + NEAR for low, high in ground_blocks.structures(run)):
            kept &= np.abs(x - end) >= reach
    return kept


def why_not(folder: pathlib.Path) -> str:
    """Why a run with a structure in its ground has no transition; empty without a structure."""
    deck = read.origin(folder)[1]
    ground = track_stretch.ground_of(deck)
    if ground is None or not ground_blocks.structures(track_stretch.WithDeck(deck)):
        return ""
    return (f"{folder.resolve().name}: no transition is judged: the train has not yet run over it, "
            f"no end of the structure is inside the ground, or too few sleepers are on the "
            f"structure or on plain track, which ends {MIRRORED:g} depths of the ground before its "
            "end")


def draw_into(folders: collections.abc.Sequence[pathlib.Path], folder: write.Folder) -> None:
    """Picture, table, curves and sentences of one run or two; a remark if one of them has no
    transition."""
    found = [of_folder(one) for one in folders]
    tracks = [one for one in found if one is not None]
    changes = None
    if len(tracks) == len(found):
        tracks = transition.named(tracks)
        changes = transition.changes_of(tracks)
    if changes is None:
        alone = len(tracks) < len(found)  # what is missing is missing in some runs only
        folder.remarks += filter(None, (why_not(one) for one, track in zip(folders, found)
                                        if track is None or not alone))
        return
    unsound = bed_warnings.causes((one.name, one.warnings()) for one in tracks)
    sentences = transition_verdict.sentences(tracks, changes, unsound)
    warnings = bed_warnings.once((one.name, passage_warnings.of_folder(one.run.folder))
                                 for one in tracks)
    titles = transition_caption.titles(tracks, changes, unsound)
    # A report of two runs has that of each beside the verdict on both.
    folder.sentences.append(sentences if len(tracks) > 1 else titles[0])
    caption = transition_caption.of(tracks, changes, unsound, bool(warnings))
    folder.picture("transition", transition_figures.compare(tracks, changes, titles, caption))
    for name, text in transition.curves(tracks).items():
        folder.file(name, text)
    below = transition_figures.wrapped("\n".join(
        [sentences, *(f"Warning: {one}." for one in warnings)]))
    folder.table("transition.txt", f"{transition.table(tracks, changes)}x is that of the ground\n"
                 f"\n{below}\n")
