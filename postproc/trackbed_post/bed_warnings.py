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
    """The aim of cycles of load before a passage is a settlement in a cycle: what the train adds
    should be less."""
    before = run.deck.get("stage", [])[:int(run.stage[run.passage()][0])]
    aims = [(stage["settlement"], stage["name"]) for stage in before
            if stage["kind"] == "load" and stage.get("settlement", 0) > 0]
    if not aims:
        return []
    aim, name = aims[-1]
    kept = measures.residual_displacement(run) - measures.residual_ground(run)
    worst = int(np.argmax(kept))
    if kept[worst] <= aim:
        return []
    return [f"the sleeper at x = {run.sleepers_x[worst]:.2f} m settles by {1e3 * kept[worst]:.2g} "
            f"mm in the {run.passage_name()}, more than the {1e3 * aim:g} mm in a cycle with which "
            f"stage {name} ended: the bed is not bedded in; give more cycles, or a smaller "
            "stage.settlement"]
