"""Support of sleepers in a passage: stiffness of the bed alone and with the ground, gaps."""
import collections.abc
import dataclasses

import numpy as np

from trackbed_post import ground_blocks, measures, read

SECANT = 0.2  # of the increase of the reaction, where the secant of the bed begins
HANGS = 1e-4  # m, a larger gap means that a sleeper hangs
# Of its largest displacement without gap, how far a sleeper must be down at its largest reaction:
# otherwise the loop is too wide for one stiffness, and a secant is steeper than the loop anywhere.
DOWN = 2 / 3


@dataclasses.dataclass(frozen=True)
class Support:
    """What stones and ground below each sleeper do in the passage."""
    lowered: np.ndarray    # [time, sleeper], m, downwards relative to the ground
    reaction: np.ndarray   # [time, sleeper], N
    # N/m, increase of the reaction over `lowered`, without the gap; not known of a sleeper that is
    # down by less than DOWN of its largest displacement when its reaction is largest.
    bed: np.ndarray
    whole: np.ndarray      # N/m, the same increase over the displacement: all of it
    # m, where the secant of the bed has the first reaction, at least 0; of a sleeper that was not
    # loaded more than at first its largest displacement, which its gap exceeds. Not known of one
    # that is not lower at its largest reaction than where the secant begins.
    gap: np.ndarray
    ends: np.ndarray       # whether each sleeper is at an end of the bed

    @property
    def hangs(self) -> np.ndarray:
        """Whether each sleeper hangs."""
        return self.gap > HANGS

    @property
    def unclear(self) -> np.ndarray:
        """Whether the loop of each sleeper is too wide for a stiffness of the bed alone."""
        return np.isnan(self.bed) & np.isfinite(self.whole) & np.isfinite(self.gap)

    @property
    def hanging(self) -> int:
        """Number of sleepers that hang."""
        return int(np.count_nonzero(self.hangs))

    def words(self) -> str:
        unknown = int(np.count_nonzero(np.isnan(self.gap)))
        if np.isnan(self.lowered).all():
            return "gaps are not known without the histories of the ground"
        outer = int(np.count_nonzero(self.hangs & self.ends))
        return (f"{self.hanging} of {len(self.gap)} have a gap above {1e3 * HANGS:g} mm"
                + (f", {outer} of them at the ends of the bed" if outer else "")
                + (f", of {unknown} it is not known" if unknown else ""))


def of(results: read.Results) -> Support:
    """Both stiffnesses belong to the same increase of the reaction, from the first row, that before
    the train comes to the bed, to its largest value, as those of springs in series: they differ by
    ground and gap. The gap is where the secant from the place at which the reaction first exceeds
    SECANT of its increase has the first reaction: neither the ground, which the axles on both sides
    of a sleeper keep low, nor stones that settle under the first axles enter twice. Numbers of the
    bed alone are not known (NOWHERE) if the ground's histories were left out."""
    rows, first = results.passage(), measures.row_before_train(results)
    height = results.sleeper["displacement"].values[rows][first:]
    reaction = results.sleeper["reaction"].values[rows][first:]
    whole = height[0] - height
    ground = measures.ground_lowered(results)
    lowered = whole - (ground[first:] - ground[first] if len(ground) > 1 else ground)
    if "displacement" not in results.ground and results.deck.get("ground", {}).get("present"):
        lowered = np.full_like(whole, measures.NOWHERE)
    count = lowered.shape[1]
    found = Support(lowered, reaction, np.full(count, measures.NOWHERE),
                    np.full(count, measures.NOWHERE), np.max(lowered, axis=0, initial=0.0),
                    ground_blocks.ends(results))
    for k in range(count):
        most = int(np.argmax(reaction[:, k]))
        increase = reaction[most, k] - reaction[0, k]
        if increase <= 0:
            continue
        if whole[most, k] > 0:
            found.whole[k] = increase / whole[most, k]
        level = reaction[0, k] + SECANT * increase
        begin = _where_reached(reaction[:, k], level, lowered[:, k])
        if (pressed := lowered[most, k] - begin) > 0:
            found.gap[k] = max(begin - SECANT / (1 - SECANT) * pressed, 0.0)
            down, farthest = lowered[most, k] - found.gap[k], lowered[:, k].max() - found.gap[k]
            if down > 0 and down >= DOWN * farthest:
                found.bed[k] = increase / (lowered[most, k] - found.gap[k])
        else:
            found.gap[k] = measures.NOWHERE
    return found


def _where_reached(reaction: np.ndarray, level: float, values: np.ndarray) -> float:
    """Value, linear between rows, at which the reaction first exceeds a level above the first."""
    after = int(np.argmax(reaction > level))
    return float(np.interp(level, reaction[after - 1:after + 1], values[after - 1:after + 1]))


def summary(run: read.Results) -> str:
    """A line of text: how many sleepers hang."""
    return (f"support of sleepers in the {measures.passage_words([run])}, {run.name}: "
            f"{of(run).words()}")


def table(runs: collections.abc.Iterable[read.Results]) -> str:
    """CSV, a row for each sleeper of each run; hangs: 1 or 0, empty if the gap is not known; end: 1
    at the ends of the bed, where the support is that of the model's end."""
    lines = ["run,x_m,bed_N_m,bed_and_ground_N_m,gap_m,hangs,end"]
    for run in runs:
        found = of(run)
        lines += [f"{run.name},{x:.9g},{bed:.6g},{whole:.6g},{gap:.6g},"
                  f"{'' if np.isnan(gap) else int(hangs)},{int(end)}"
                  for x, bed, whole, gap, hangs, end in zip(
                      run.sleepers_x, found.bed, found.whole, found.gap, found.hangs, found.ends)]
    return "\n".join(lines) + "\n"
