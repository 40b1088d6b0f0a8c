"""Settlement of the sleepers of a run from cycle to cycle, and under each axle of its trains."""
import dataclasses

import numpy as np

from trackbed_post import axles, read, train_figures
from trackbed_post.settlement import laws


@dataclasses.dataclass(frozen=True)
class Course:
    """Complete cycles (counted as by the program, jumps included), and the settlement of each
    sleeper since the count began, m, [row, sleeper]. `stage`: number of the stage in which a row
    lies; `jump`: whether that stage is a jump; `ground`: how far the ground's top is lowered, m,
    [row], mean over the sleepers, None without its histories."""
    cycles: np.ndarray
    settled: np.ndarray
    time: np.ndarray
    stage: np.ndarray
    jump: np.ndarray
    ground: np.ndarray | None = None

    def mean(self):
        return self.settled.mean(axis=1)

    def ground_rises(self, use):
        """How far the ground is above its lowest level before, in rows `use`, m, at most: it
        vibrates, since what has yielded stays low."""
        if self.ground is None or not use.any():
            return 0.0
        lowered = self.ground[use]
        return float(np.max(np.maximum.accumulate(lowered) - lowered))


def course_of(path):
    """A row at the begin, and one where a cycle has become complete: the first history row of the
    next one, in which sleepers are unloaded."""
    every, run = read.datasets(path), read.results(path)
    if "history/traffic/cycles" not in every or "displacement" not in run.sleeper:
        raise read.Unreadable(f"{path} has no cycles of load and no trains, or its histories have "
                              "no sleepers (output.histories)")
    count = every["history/traffic/cycles"].values.ravel()
    stages = run.deck["stage"]
    rows = list(np.flatnonzero(np.diff(count) > 0) + 1)
    cycles = [float(count[row]) for row in rows]
    if read.summary(path).get("finished") and (more := last_cycles(run, count)):
        rows.append(len(count) - 1)
        cycles.append(float(count[-1]) + more)
    if not rows:
        raise read.Unreadable(f"{path}: no cycle is complete")
    # A row after the last window of a stage lies in the next one.
    of_stage = run.stage[np.array(rows) - 1]
    begin = int(np.argmax(run.stage == of_stage[0]))
    rows = np.array([begin, *rows])
    of_stage = np.array([of_stage[0], *of_stage])
    level = run.sleeper["displacement"].values
    return Course(np.array([float(count[begin]), *cycles]), level[begin] - level[rows],
                  run.time[rows], of_stage,
                  np.array([stages[k]["kind"] == "jump" for k in of_stage]),
                  ground_below(run, rows))


def ground_below(run, rows):
    """Course.ground of these rows of the histories."""
    if "displacement" not in run.ground or not len(run.ground_x):
        return None
    height = run.ground["displacement"].values[rows]
    level = np.array([np.interp(run.sleepers_x, run.ground_x, row).mean() for row in height])
    return level[0] - level


def last_cycles(run, count):
    """Cycles that are complete with the end of a run, after its last row."""
    stage = run.deck["stage"][run.stage[-1]]
    if stage["kind"] == "jump":
        return stage["cycles"]
    whole = max(stage.get("cycles", 0), 1 if stage["kind"] == "passage" else 0)
    counted = count[-1] - count[np.argmax(run.stage == run.stage[-1])]
    return 1 if stage["kind"] in ("load", "passage") and counted < whole else 0


WINDOW = 10  # cycles, of an increment of settlement; the first ones are left out: bedding in


@dataclasses.dataclass(frozen=True)
class Aim:
    """A jump from cycle `begin` to `end`: the mean settlement that the law and the cycles before it
    state, its standard error because settlement is intermittent (not a number if fewer than three
    increments are known), and that of the run, m."""
    begin: float
    end: float
    aimed: float
    error: float
    settled: float


def scatter(course, row, exponent):
    """m2 per unit of the law: variance of the settlement of a sleeper about its own mean rate, of
    computed increments of WINDOW cycles up to `row`. A sleeper rests for many cycles and then
    moves, so that the variance of an increment grows in proportion to the law. Not a number if
    fewer than three increments are known."""
    ends = np.arange(WINDOW, course.cycles[row] + 0.5, WINDOW)
    at = np.searchsorted(course.cycles[:row + 1], ends)
    grown, law = [], []
    for first, last in zip(at, at[1:]):
        if last > row or course.cycles[last] != course.cycles[first] + WINDOW or \
                course.jump[first + 1:last + 1].any():
            continue
        grown.append(course.settled[last] - course.settled[first])
        law.append(growth(course, exponent, first, last))
    if len(grown) < 3:
        return np.nan
    grown, law = np.array(grown), np.array(law)[:, None]
    rates = grown.sum(axis=0) / law.sum()
    return float(np.mean(np.sum((grown - rates * law)**2 / law, axis=0)) / (len(law) - 1))


@dataclasses.dataclass(frozen=True)
class Measured:
    """Cycles before a jump in row `row`: the exponent of the law, its growth in them, and mean
    settlement per unit of the law, m."""
    row: int
    exponent: float
    grown: float
    rate: float


def growth(course, exponent, first, last):
    """Of the law from row to row."""
    return laws.law(course.cycles[last], exponent) - laws.law(course.cycles[first], exponent)


def measured_before(course, deck):
    """A Measured of each jump with computed cycles before it."""
    jump, mean, found = deck.get("jump", {}), course.mean(), []
    for row in np.flatnonzero(course.jump):
        if row < 2 or course.jump[row - 1]:
            continue
        first = int(np.flatnonzero(course.cycles >= course.cycles[row - 1]
                                   - jump.get("cycles", 20))[0])
        exponent = jump.get("exponent", 0.0)
        grown = growth(course, exponent, first, row - 1)
        found.append(Measured(int(row), exponent, grown, (mean[row - 1] - mean[first]) / grown))
    return found


def aims(course, deck):
    """An Aim of each jump with computed cycles before it."""
    mean, found = course.mean(), []
    for one in measured_before(course, deck):
        before, ahead = one.row - 1, growth(course, one.exponent, one.row - 1, one.row)
        error = np.sqrt(scatter(course, before, one.exponent) / course.settled.shape[1]
                        * ahead * (1 + ahead / one.grown))
        found.append(Aim(course.cycles[before], course.cycles[one.row],
                         max(ahead * one.rate, 0.0), float(error), mean[one.row] - mean[before]))
    return found


@dataclasses.dataclass(frozen=True)
class JumpCheck:
    """A jump, and whether the settlement after it goes on by the law with which it was made:
    settlements of the mean sleeper, m. `lack` is an estimate of what `settled` lacks: the law's
    rate is right at the begin, wrong by `found/expected` at the end, and in between in proportion
    to the law."""
    begin: float     # cycles
    end: float
    settled: float
    after: float     # cycles after it
    expected: float  # settlement in these by the law
    found: float

    @property
    def lack(self):
        if not self.expected > 0:
            return np.nan
        return 0.5 * (self.found / self.expected - 1) * self.settled


def checks(course, deck):
    """A JumpCheck of each jump with computed cycles before and after it."""
    mean, found = course.mean(), []
    for one in measured_before(course, deck):
        row = one.row
        later = np.flatnonzero(course.stage == course.stage[row] + 1)
        if not len(later) or course.jump[later].any():
            continue
        last = later[-1]
        found.append(JumpCheck(course.cycles[row - 1], course.cycles[row],
                               mean[row] - mean[row - 1], course.cycles[last] - course.cycles[row],
                               one.rate * growth(course, one.exponent, row, last),
                               mean[last] - mean[row]))
    return found


def axles_of(path):
    """[(number of the train, lowest displacement of each sleeper under each axle [axle, sleeper],
    m, relative to the row before the train)] of all trains with wheels in the histories."""
    every, run = read.datasets(path), read.results(path)
    if "history/wheel/x" not in every:
        return []
    x = axles.of_wheels(every["history/wheel/x"].values)
    spacing = run.deck["sleepers"]["spacing"]
    level = run.sleeper["displacement"].values
    found = []
    for number, rows in enumerate(axles.rows_of_trains(x)):
        first = axles.row_before_train(x[rows][:, 0], run.sleepers_x[0])
        moved = level[rows] - level[rows][first]
        found.append((number + 1, train_figures.under_axles(x[rows], run.sleepers_x, moved,
                                                           spacing)))
    return found
