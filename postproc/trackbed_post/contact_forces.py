"""At which instant the contact forces of a run are drawn, and its words for titles.

With field files of contacts it is that with a wheel nearest to the middle of the bed. Without them
forces are known at the ends of stages only: after a passage those of the load stage before it are
shown, if it ends under a larger load.
"""
import dataclasses
import pathlib

import numpy as np

from trackbed_post import field_files, measures, passage_instant, read


@dataclasses.dataclass(frozen=True)
class Forces:
    """Contact forces at one instant, N, and which instant it is, in words."""
    values: np.ndarray
    words: str


def seat_load(run: read.Results, stage: str) -> float:
    """Largest downward seat load at the last row of a stage, N; 0 before sleepers are placed."""
    names = [each.get("name") for each in run.deck.get("stage", [])]
    rows = np.flatnonzero(run.stage == names.index(stage)) if stage in names else np.empty(0, int)
    if not len(rows) or "seat_force" not in run.sleeper:
        return 0.0
    return float(np.max(-run.sleeper["seat_force"].values[rows[-1]]))


def under_load(run: read.Results) -> str:
    """Stage at whose end forces are shown; empty without any. At the end of the passage the train
    has left, so it is the preceding load stage if that ends under a larger load, otherwise the last
    stage."""
    stages = [name for name, chains in run.chains.items() if len(chains.force)]
    if not stages:
        return ""
    kinds = {each.get("name"): each.get("kind") for each in run.deck.get("stage", [])}
    before = stages[-2] if len(stages) > 1 else stages[-1]
    loaded = kinds.get(before) == "load" and seat_load(run, before) > seat_load(run, stages[-1])
    return before if loaded else stages[-1]


def words_of(run: read.Results, stage: str) -> str:
    """The end of a stage in words: its seat load, and whether a train or load has passed."""
    load = seat_load(run, stage)
    kinds = {each.get("name"): each.get("kind") for each in run.deck.get("stage", [])}
    passed = kinds.get(stage) == "passage" and (stage != measures.stage_shown(run)
                                                or measures.train_has_left(run))
    return (f"end of stage {stage}" + (f", largest seat load {load / 1e3:.1f} kN" if load else "")
            + ", after the passage" * passed)


def _of_fields(folder: pathlib.Path) -> Forces | None:
    """Of the field file with a wheel nearest to the middle of the bed; None without it."""
    files = read.series(folder, "contacts")
    wanted = passage_instant.time_of(folder) if files else None
    if wanted is None:
        return None
    time, file = field_files.nearest(files, wanted)
    found = read.datasets(file)
    if time != wanted or "VTKHDF/CellData/force_size" not in found:
        return None
    return Forces(found["VTKHDF/CellData/force_size"].values.ravel(),
                  f"at {time:.4f} s, a wheel nearest to the middle of the bed")


def of_run(run: read.Results) -> Forces | None:
    """Under load; None without contact forces."""
    if run.folder and (found := _of_fields(run.folder)):
        return found
    stage = under_load(run)
    return Forces(run.chains[stage].force, words_of(run, stage)) if stage else None
