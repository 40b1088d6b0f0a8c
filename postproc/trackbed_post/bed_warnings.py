"""What a reader of the figures of a bed must know: sleepers that hang, and a bed that was bedded in
too little. Both make neighbouring sleepers differ by more than any design does, so that runs of
such a bed have no verdict. Sleepers at the ends of the bed do not count."""
import collections.abc
import dataclasses

import numpy as np

from trackbed_post import ground_blocks, measures, read, support


@dataclasses.dataclass(frozen=True)
class BedWarning:
    """Why a difference between two runs may have other causes than what they differ by: the cause
    in a few words, and a sentence with quantity, value, limit and remedy."""
    cause: str
    sentence: str


def warnings_of(run: read.Results) -> list[BedWarning]:
    """Those of a run; none without a passage over sleepers on stones. While the train is on the bed
    neither gaps nor settlement are known."""
    if not run.has_passage() or not len(run.sleepers_x) or "reaction" not in run.sleeper:
        return []
    if not measures.train_has_left(run):
        return [BedWarning("the train has not left the bed", (
            f"the train has not left the bed in the last row of the histories, at "
            f"{run.time[-1]:.4g} s: numbers and figures of the passage are those up to then, and "
            "no residual displacement is known; wait for the end of the run or, if it was stopped, "
            "resume it; if the stage has ended, give it a longer duration"))]
    return [*_of_hanging(run), *_of_bedding_in(run)]


def of(run: read.Results) -> list[str]:
    """The sentences, without the name of the run."""
    return [one.sentence for one in warnings_of(run)]


def why_no_verdict(named: collections.abc.Iterable[tuple[str, read.Results]]) -> str:
    """The causes in runs with their names, for a sentence; empty if there are none."""
    found = [(name, [one.cause for one in warnings_of(run)]) for name, run in named]
    return "; ".join(f"{', '.join(causes)} (run {name})" for name, causes in found if causes)


def _of_hanging(run: read.Results) -> list[BedWarning]:
    found = support.of(run)
    hangs = found.hangs & ~found.ends
    if not hangs.any():
        return []
    places = ", ".join(f"{x:.2f}" for x in run.sleepers_x[hangs])
    cause = f"{np.count_nonzero(hangs)} of {len(hangs)} sleepers hang"
    return [BedWarning(cause, (
        f"{cause} in the {run.passage_name()} (gap above {1e3 * support.HANGS:g} mm, at x = "
        f"{places} m): levels and forces near them are those of a track with voids; give more "
        "cycles to the stage before the passage, or a smaller stage.settlement"))]


def _of_bedding_in(run: read.Results) -> list[BedWarning]:
    """Cycles of load before a passage have an aim, a settlement in a cycle: what the train adds
    should be less; and its load should be less than theirs."""
    before = run.deck.get("stage", [])[:int(run.stage[run.passage()][0])]
    cycles = [stage for stage in before if stage["kind"] == "load"]
    inner = np.flatnonzero(~ground_blocks.ends(run))
    if not cycles:
        return []
    last, found = cycles[-1], []
    aim = last.get("settlement", 0)
    kept = (measures.residual_displacement(run) - measures.residual_ground(run))[inner]
    worst = int(np.argmax(kept))
    if 0 < aim < kept[worst]:
        found.append(BedWarning("the bed is not bedded in", (
            f"the sleeper at x = {run.sleepers_x[inner[worst]]:.2f} m settles by "
            f"{1e3 * kept[worst]:.2g} mm in the {run.passage_name()}, more than the aim of stage "
            f"{last['name']}, {1e3 * aim:g} mm in a cycle: the bed is not bedded in; give this "
            "stage a larger load, more cycles, or a smaller settlement")))
    load = max(stage.get("load", 0) + stage.get("seat_force", 0) for stage in cycles)
    most = float(np.max(run.sleeper["reaction"].values[run.passage()][:, inner]))
    if most > load > 0:
        found.append(BedWarning("the bed was bedded in with less than the load of the passage", (
            f"the stones carry up to {1e-3 * most:.1f} kN below a sleeper in the "
            f"{run.passage_name()}, more than the {1e-3 * load:g} kN with which it was bedded in "
            "before: settlement is that of a first loading; give the stage of load a larger load")))
    return found
