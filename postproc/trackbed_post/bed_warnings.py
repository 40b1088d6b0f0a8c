"""What a reader of the figures of a bed must know: sleepers that hang or are raised, and a bed that
was bedded in too little. They make neighbouring sleepers differ by more than any design does, so
that runs of such a bed have no verdict (passage_warnings.py adds the causes that lie in the train).
Sleepers at the ends of the bed do not count."""
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
    in a few words, and a sentence with quantity, value, limit and remedy. `count`: of the sleepers
    that the cause is about, the words before it."""
    cause: str
    sentence: str
    count: str = ""


def warnings_of(run: read.Results, changing: float | None = None) -> list[BedWarning]:
    """Those of a run; none without a passage over sleepers on stones. Before the train has left the
    bed no settlement is known, and while it moves on no gaps either. `changing`: distance over
    which the track changes, m (zones.py), by default that of this run alone."""
    if not run.has_passage() or not len(run.sleepers_x) or "reaction" not in run.sleeper:
        return []
    if measures.train_has_left(run):
        return [*_of_hanging(run), *_of_settling(run, changing), *_of_raised(run), *_of_load(run)]
    numbers = (f"at {run.time[-1]:.4g} s: numbers and figures of the passage are those up to then, "
               "and no residual displacement is known; ")
    if measures.train_stands(run):
        return [BedWarning("the train stops on the bed", (
            f"the train stops on the bed (train.speeds ends with 0) and stands there in the last "
            f"row of the histories, {numbers}let it run on past the last sleeper to know it")),
            *_of_hanging(run), *_of_load(run)]
    return [BedWarning("the train has not left the bed", (
        f"the train has not left the bed in the last row of the histories, {numbers}wait for the "
        "end of the run or, if it was stopped, resume it; if the stage has ended, give it a longer "
        "duration"))]


def of(run: read.Results, changing: float | None = None) -> list[str]:
    """The sentences, without the name of the run."""
    return [one.sentence for one in warnings_of(run, changing)]


def causes(named: collections.abc.Iterable[tuple[str, list[BedWarning]]]) -> str:
    """The causes in runs with their names, each once, for a sentence; empty if there are none."""
    found: dict[str, dict[str, list[str]]] = {}  # cause -> count -> names
    for name, warnings in named:
        for one in warnings:
            found.setdefault(one.cause, {}).setdefault(one.count, []).append(name)
    return "; ".join(_cause_in_runs(cause, names) for cause, names in found.items())


def runs_of(names: list[str]) -> str:
    """run a; runs a and b."""
    return f"run{'s' if len(names) > 1 else ''} {ground_blocks.joined(names)}"


def _cause_in_runs(cause: str, names: dict[str, list[str]]) -> str:
    """3 of 31 sleepers hang (run a), 5 of 31 (run b)."""
    first, *others = [(count, runs_of(same)) for count, same in names.items()]
    return ", ".join([f"{' '.join(filter(None, (first[0], cause)))} ({first[1]})",
                      *(f"{count} ({runs})" for count, runs in others)])


def once(named: collections.abc.Iterable[tuple[str, collections.abc.Iterable[str]]]) -> list[str]:
    """Sentences of runs with their names, each once, behind the runs for which it holds."""
    found: dict[str, list[str]] = {}
    for name, lines in named:
        for line in dict.fromkeys(lines):
            found.setdefault(line, []).append(name)
    return [f"{ground_blocks.joined(names)}: {line}" for line, names in found.items()]


def _of_hanging(run: read.Results) -> list[BedWarning]:
    found = support.of(run)
    hangs = found.hangs & ~found.ends
    if not hangs.any():
        return []
    places = ", ".join(f"{x:.2f}" for x in run.sleepers_x[hangs])
    count, cause = f"{np.count_nonzero(hangs)} of {len(hangs)}", "sleepers hang"
    return [BedWarning(cause, (
        f"{count} {cause} in the {run.passage_name()} (gap above {1e3 * support.HANGS:g} mm, at x "
        f"= {places} m): levels and forces near them are those of a track with voids; "
        f"{remedies(run)}"), count)]


def _loads_before(run: read.Results) -> list[read.Deck]:
    """The stages before the passage that load the bed: those of kind load and, before a train, the
    passages of axle loads ([load])."""
    before = run.deck.get("stage", [])[:int(run.stage[run.passage()][0])]
    train = ground_blocks.carried_by_springs(run)
    return [stage for stage in before if stage["kind"] == "load"
            or train and stage["kind"] == "passage" and not stage.get("train", False)]


def remedies(run: read.Results) -> str:
    """What beds sleepers in further: two remedies at most."""
    stages = _loads_before(run)
    if not stages:
        return "add a stage of kind load with cycles before the passage"
    stage = stages[-1]
    name = stage["name"]
    if stage["kind"] == "passage":
        return f"give the axles of stage {name} a larger load ([load]), or the stage more cycles"
    if not stage.get("cycles", 0):
        return f"give stage {name} a larger load, or cycles instead of a single ramp"
    return f"give stage {name} {_of_cycles(run, stage)}"


def _of_cycles(run: read.Results, stage: read.Deck) -> str:
    """The same for a stage of load with cycles. One that has reached its aim ends early, so that
    more cycles would change nothing; whether it has is not known while the run goes on. Its last
    cycle may reach the aim too: then it has not ended early."""
    more, aim = "more cycles and a longer duration", stage.get("settlement", 0)
    smaller = f"a smaller settlement than {1e3 * aim:g} mm"
    reached, lasted = run.aim_reached.get(stage["name"]), run.lasted.get(stage["name"])
    if aim > 0 and reached is None:
        return f"{smaller}, if it ended with this, or {more}, if not"
    if not (aim > 0 and reached):
        return f"a larger load, or {more}"
    if lasted is None:
        return f"a larger load, or {smaller}, which it reached"
    if lasted < stage["duration"] * (1 - 0.5 / stage["cycles"]):
        return f"a larger load, or {smaller}, with which it ended early"
    return f"a larger load, or {smaller}, which it reached in its last cycle, with {more}"


def _in_parts(run: read.Results, which: np.ndarray, changing: float | None) -> str:
    """How many of these sleepers are in each part of a transition, or in none, as those before the
    structure; empty without a transition."""
    if ground_blocks.edge_of_structure(run) is None:
        return ""
    zone = zones.zone_of(run, zones.changing([run]) if changing is None else changing)
    if zone is None:
        return ""
    parts = zone.parts
    other = ~ground_blocks.ends(run) & ~np.any(list(parts.values()), axis=0)
    if other.any():
        parts["elsewhere"] = other
    return ": " + ", ".join(
        f"{np.count_nonzero(which & part)} of {np.count_nonzero(part)} {words}"
        for words, part in parts.items())


def _settled(run: read.Results) -> tuple[np.ndarray, np.ndarray]:
    """(sleepers that are not at the ends of the bed; how far each of them has settled into it, m,
    downwards, 0 at the ends)."""
    inner = ~ground_blocks.ends(run)
    into = measures.residual_displacement(run) - measures.residual_ground(run)
    return inner, np.where(inner, into, 0.0)


def _of_settling(run: read.Results, changing: float | None) -> list[BedWarning]:
    inner, kept = _settled(run)
    settles = kept > SETTLES
    if not settles.any():
        return []
    worst = int(np.argmax(kept))
    return [BedWarning("the bed is not bedded in", (
        f"{np.count_nonzero(settles)} of {np.count_nonzero(inner)} sleepers settle into the bed by "
        f"more than {1e3 * SETTLES:g} mm in the {run.passage_name()}, most by "
        f"{1e3 * kept[worst]:.2g} mm at x = {run.sleepers_x[worst]:.2f} m"
        f"{_in_parts(run, settles, changing)}: the bed is not bedded in; {remedies(run)}"))]


def _of_raised(run: read.Results) -> list[BedWarning]:
    """Sleepers that a passage leaves so much higher do not lie as they were bedded in."""
    inner, kept = _settled(run)
    rise = -kept
    raised = rise > measures.LASTING
    if not raised.any():
        return []
    worst = int(np.argmax(rise))
    return [BedWarning("sleepers are raised by the passage", (
        f"{np.count_nonzero(raised)} of {np.count_nonzero(inner)} sleepers are raised by more than "
        f"{1e3 * measures.LASTING:g} mm relative to the ground in the {run.passage_name()}, most "
        f"by {1e3 * rise[worst]:.3g} mm at x = {run.sleepers_x[worst]:.2f} m: they do not lie on "
        "the bed as before; check irregularity, speed, and the weight of rails and fastenings "
        "(seat_force)"))]


def _of_load(run: read.Results) -> list[BedWarning]:
    """The load before a passage should be larger than that of the train."""
    stages = _loads_before(run)
    if not stages:
        return []
    loads = [_load(run, stage) for stage in stages]
    load, most = max(loads), stages[int(np.argmax(loads))]
    carried = _carried(run, run.passage())
    if not carried > load > 0:
        return []
    return [BedWarning("the bed was bedded in with less than the load of the passage", (
        f"the stones carry up to {1e-3 * carried:.3g} kN below a sleeper in the "
        f"{run.passage_name()}, more than the {1e-3 * load:g} kN with which stage {most['name']} "
        "bedded it in: settlement is that of a first loading; give this stage a larger load"))]


def _carried(run: read.Results, rows: slice | np.ndarray) -> float:
    """Largest force of the stones on a sleeper in these rows, N; 0 without a row."""
    inner = ~ground_blocks.ends(run)
    return float(np.max(run.sleeper["reaction"].values[rows][:, inner], initial=0.0))


def _load(run: read.Results, stage: read.Deck) -> float:
    """Of a stage on each sleeper, N; in a passage what the stones carry."""
    if stage["kind"] == "passage":
        return _carried(run, run.stage == run.deck["stage"].index(stage))
    return float(stage.get("load", 0) + stage.get("seat_force", 0))
