"""What a reader of the figures of a bed must know: sleepers that hang, and a bed that was bedded in
too little. Both make neighbouring sleepers differ by more than any design does, so that runs of
such a bed have no verdict. Sleepers at the ends of the bed do not count."""
import collections.abc
import dataclasses

import numpy as np

from trackbed_post import ground_blocks, measures, read, support, zones

# m, of a sleeper in one passage: as much as the gap of a sleeper that hangs, since a sleeper that
# settles by more than its neighbours hangs below the rail for the next train. The deck's own aim,
# a settlement in a cycle, is no limit: a lax aim would silence the warning.
SETTLES = support.HANGS


@dataclasses.dataclass(frozen=True)
class BedWarning:
    """Why a difference between two runs may have other causes than what they differ by: the cause
    in a few words, and a sentence with quantity, value, limit and remedy."""
    cause: str
    sentence: str


def warnings_of(run: read.Results, changing: float | None = None) -> list[BedWarning]:
    """Those of a run; none without a passage over sleepers on stones. While the train is on the bed
    neither gaps nor settlement are known. `changing`: distance over which the track changes, m
    (zones.py), by default that of this run alone."""
    if not run.has_passage() or not len(run.sleepers_x) or "reaction" not in run.sleeper:
        return []
    if not measures.train_has_left(run):
        return [BedWarning("the train has not left the bed", (
            f"the train has not left the bed in the last row of the histories, at "
            f"{run.time[-1]:.4g} s: numbers and figures of the passage are those up to then, and "
            "no residual displacement is known; wait for the end of the run or, if it was stopped, "
            "resume it; if the stage has ended, give it a longer duration"))]
    return [*_of_hanging(run), *_of_settling(run, changing), *_of_load(run)]


def of(run: read.Results, changing: float | None = None) -> list[str]:
    """The sentences, without the name of the run."""
    return [one.sentence for one in warnings_of(run, changing)]


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
        f"{places} m): levels and forces near them are those of a track with voids; "
        f"{remedies(run)}"))]


def _loads_before(run: read.Results) -> list[read.Deck]:
    """The stages of load before the passage."""
    before = run.deck.get("stage", [])[:int(run.stage[run.passage()][0])]
    return [stage for stage in before if stage["kind"] == "load"]


def remedies(run: read.Results) -> str:
    """What beds sleepers in further. A stage that has reached its aim ends early, so that more
    cycles would change nothing; whether it has is not known while the run goes on."""
    stages = _loads_before(run)
    if not stages:
        return "add a stage of kind load with cycles before the passage"
    name, aim = stages[-1]["name"], stages[-1].get("settlement", 0)
    reached = run.aim_reached.get(name)
    if aim > 0 and reached:
        more = (f"a smaller settlement than {1e3 * aim:g} mm, with which it ended before all of "
                "its cycles")
    elif aim > 0 and reached is None:
        more = (f"a smaller settlement than {1e3 * aim:g} mm, if it ended with this, or more "
                "cycles and a longer duration, if not")
    else:
        more = "more cycles and a longer duration"
    return f"give stage {name} a larger load, or {more}; or add a passage before this one"


def _in_parts(run: read.Results, which: np.ndarray, changing: float | None) -> str:
    """How many of these sleepers are in each part of a transition; empty without one."""
    if ground_blocks.edge_of_structure(run) is None:
        return ""
    zone = zones.zone_of(run, zones.changing([run]) if changing is None else changing)
    if zone is None:
        return ""
    return ": " + ", ".join(
        f"{np.count_nonzero(which & part)} of {np.count_nonzero(part)} {words}"
        for words, part in zone.parts.items())


def _of_settling(run: read.Results, changing: float | None) -> list[BedWarning]:
    inner = ~ground_blocks.ends(run)
    kept = np.where(inner, measures.residual_displacement(run) - measures.residual_ground(run), 0.0)
    settles = kept > SETTLES
    if not settles.any():
        return []
    worst = int(np.argmax(kept))
    return [BedWarning("the bed is not bedded in", (
        f"{np.count_nonzero(settles)} of {np.count_nonzero(inner)} sleepers settle into the bed by "
        f"more than {1e3 * SETTLES:g} mm in the {run.passage_name()}, most by "
        f"{1e3 * kept[worst]:.2g} mm at x = {run.sleepers_x[worst]:.2f} m"
        f"{_in_parts(run, settles, changing)}: the bed is not bedded in; {remedies(run)}"))]


def _of_load(run: read.Results) -> list[BedWarning]:
    """The load before a passage should be larger than that of the train."""
    stages = _loads_before(run)
    if not stages:
        return []
    most = max(stages, key=_load)
    load = _load(most)
    inner = ~ground_blocks.ends(run)
    carried = float(np.max(run.sleeper["reaction"].values[run.passage()][:, inner]))
    if not carried > load > 0:
        return []
    return [BedWarning("the bed was bedded in with less than the load of the passage", (
        f"the stones carry up to {1e-3 * carried:.3g} kN below a sleeper in the "
        f"{run.passage_name()}, more than the {1e-3 * load:g} kN with which stage {most['name']} "
        "bedded it in: settlement is that of a first loading; give this stage a larger load"))]


def _load(stage: read.Deck) -> float:
    """Of a stage on each sleeper, N."""
    return float(stage.get("load", 0) + stage.get("seat_force", 0))
