"""Support of sleepers in a passage: stiffness of the bed alone and with the ground, gaps."""
import collections.abc
import dataclasses

import numpy as np

from trackbed_post import measures, read

SECANT = 0.2  # of the increase of the reaction, where the secant of the support begins
HANGS = 1e-4  # m, a larger gap means that a sleeper hangs


@dataclasses.dataclass(frozen=True)
class Support:
    """What stones and ground below each sleeper do in the passage."""
    lowered: np.ndarray    # [time, sleeper], m, downwards relative to the ground
    reaction: np.ndarray   # [time, sleeper], N
    bed: np.ndarray        # N/m, secant of the reaction over `lowered`
    whole: np.ndarray      # N/m, the same over the displacement itself: with the ground
    # m, where the secant of the bed has the first reaction, at least 0; of a sleeper that was not
    # loaded more than at first its largest displacement, which its gap exceeds.
    gap: np.ndarray

    @property
    def hanging(self) -> int:
        """Number of sleepers that hang."""
        return int(np.count_nonzero(self.gap > HANGS))

    def words(self) -> str:
        if np.isnan(self.gap).all():
            return "gaps are not known without the histories of the ground"
        return f"{self.hanging} of {len(self.gap)} have a gap above {1e3 * HANGS:g} mm"


def of(results: read.Results) -> Support:
    """The load of a sleeper is followed backwards from its largest reaction to SECANT of the
    increase since the first row, which must be before the load of the train. Numbers of the bed
    alone are not known (NOWHERE) if the ground's histories were left out."""
    rows = results.passage()
    height = results.sleeper["displacement"].values[rows]
    reaction = results.sleeper["reaction"].values[rows]
    whole = height[0] - height
    lowered = whole - measures.ground_lowered(results)
    if "displacement" not in results.ground and results.deck.get("ground", {}).get("present"):
        lowered = np.full_like(whole, measures.NOWHERE)
    count = lowered.shape[1]
    found = Support(lowered, reaction, np.full(count, measures.NOWHERE),
                    np.full(count, measures.NOWHERE), np.max(lowered, axis=0, initial=0.0))
    for k in range(count):
        most = int(np.argmax(reaction[:, k]))
        level = reaction[0, k] + SECANT * (reaction[most, k] - reaction[0, k])
        below = np.flatnonzero(reaction[:most, k] <= level)
        if not len(below):
            continue
        last = below[-1]   # the secant begins between this row and the next one
        part = (level - reaction[last, k]) / (reaction[last + 1, k] - reaction[last, k])

        def way(values: np.ndarray) -> tuple[float, float]:
            begin = values[last, k] + part * (values[last + 1, k] - values[last, k])
            return begin, values[most, k] - begin

        rise = reaction[most, k] - level
        begin, pressed = way(lowered)
        if pressed > 0:
            found.bed[k] = rise / pressed
            found.gap[k] = max(begin - (level - reaction[0, k]) / found.bed[k], 0.0)
        if (sunk := way(whole)[1]) > 0:
            found.whole[k] = rise / sunk
    return found


def summary(run: read.Results) -> str:
    """A line of text: how many sleepers hang."""
    return f"support of sleepers in the {run.passage_name()}, {run.name}: {of(run).words()}"


def table(runs: collections.abc.Iterable[read.Results]) -> str:
    """CSV, a row for each sleeper of each run."""
    lines = ["run,x_m,bed_N_m,bed_and_ground_N_m,gap_m"]
    for run in runs:
        found = of(run)
        lines += [f"{run.name},{x:.9g},{bed:.6g},{whole:.6g},{gap:.6g}" for x, bed, whole, gap in
                  zip(run.sleepers_x, found.bed, found.whole, found.gap)]
    return "\n".join(lines) + "\n"
