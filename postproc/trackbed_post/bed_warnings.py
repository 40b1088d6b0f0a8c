"""What a reader of the figures of a bed must know: sleepers that hang, and a bed that was bedded in
too little. Both make neighbouring sleepers differ by more than any design does."""
import numpy as np

from trackbed_post import measures, read, support


def of(run: read.Results) -> list[str]:
    """Sentences without the name of the run; none without a passage over sleepers on stones."""
    if not run.has_passage() or not len(run.sleepers_x) or "reaction" not in run.sleeper:
        return []
    return [*_of_hanging(run), *_of_bedding_in(run)]


def _of_hanging(run: read.Results) -> list[str]:
    found = support.of(run)
    if not found.hanging:
        return []
    places = ", ".join(f"{x:.2f}" for x in run.sleepers_x[found.hangs])
    return [f"{found.hanging} of {len(found.gap)} sleepers hang in the {run.passage_name()} (gap "
            f"above {1e3 * support.HANGS:g} mm, at x = {places} m): levels and forces near them "
            "are those of a track with voids; give more cycles to the stage before the passage, or "
            "a smaller stage.settlement"]


def _of_bedding_in(run: read.Results) -> list[str]:
    """Cycles of load before a passage have an aim, a settlement in a cycle: what the train adds
    should be less; and its load should be less than theirs."""
    before = run.deck.get("stage", [])[:int(run.stage[run.passage()][0])]
    cycles = [stage for stage in before if stage["kind"] == "load"]
    if not cycles:
        return []
    last, lines = cycles[-1], []
    aim = last.get("settlement", 0)
    kept = measures.residual_displacement(run) - measures.residual_ground(run)
    worst = int(np.argmax(kept))
    if 0 < aim < kept[worst]:
        lines.append(
            f"the sleeper at x = {run.sleepers_x[worst]:.2f} m settles by {1e3 * kept[worst]:.2g} "
            f"mm in the {run.passage_name()}, more than the aim of stage {last['name']}, "
            f"{1e3 * aim:g} mm in a cycle: the bed is not bedded in; give this stage a larger "
            "load, more cycles, or a smaller settlement")
    load = max(stage.get("load", 0) + stage.get("seat_force", 0) for stage in cycles)
    most = float(np.max(run.sleeper["reaction"].values[run.passage()]))
    if most > load > 0:
        lines.append(
            f"the stones carry up to {1e-3 * most:.1f} kN below a sleeper in the "
            f"{run.passage_name()}, more than the {1e-3 * load:g} kN with which it was bedded in "
            "before: settlement is that of a first loading; give the stage of load a larger load")
    return lines
