"""Vehicles over a bed, a stage with train = true: wheel forces along the track, displacement of
each sleeper under each axle, settlement by the axles, and a table of them. Definition of the
numbers: docs/track.md.
"""

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import (axles, ground_blocks, measures, panels, passage_warnings, read,
                           shades)

SHOWN_WHEELS = len(panels.MARKERS)  # the first wheels are shown
MARGIN = 0.25   # of the judged range of displacements, above and below it


def train_rows(wheel_x, name):
    """Rows of the last train of the histories, which may be that of an earlier stage. `name`: of
    the run, for messages."""
    trains = axles.rows_of_trains(wheel_x)
    if not trains:
        raise read.Unreadable(f"{name}: no row of the histories has a train on the track: was the "
                              "run stopped before its passage?")
    return trains[-1]


def under_axles(wheel_x, sleepers_x, moved, reach):
    """Lowest displacement of each sleeper while an axle is within `reach` of it, [axle, sleeper];
    nan where the axle never came."""
    lowest = np.full((wheel_x.shape[1], len(sleepers_x)), np.nan)
    for axle in range(wheel_x.shape[1]):
        for i, place in enumerate(sleepers_x):
            near = np.abs(wheel_x[:, axle] - place) <= reach
            if near.any():
                lowest[axle, i] = moved[near, i].min()
    return lowest


class Passing:
    """The last train of the histories: time, s; x of axles, m; force of their wheels, N, [time,
    axle, rail], left before right; motion of the sleepers, m; `ends`: which of them are at the ends
    of the bed and do not count. Levels are relative to the row `first`."""

    def __init__(self, run, every):
        if "history/wheel/x" not in every or not len(run.sleepers_x):
            raise read.Unreadable("this run has no train over a bed; use --kind bed for seat loads "
                                  "and --kind track for a track alone")
        def rows_of(name):
            values = every[f"history/{name}"].values
            return values.reshape(len(values), -1)
        wheel_x = rows_of("wheel/x")
        rows = train_rows(wheel_x, run.name)
        self.time = run.time[rows]
        wheels = wheel_x[rows]
        rails = 2 if axles.on_two_rails(wheels) else 1
        self.x = axles.of_wheels(wheels)
        self.force = rows_of("wheel/force")[rows].reshape(len(rows), -1, rails)
        self.seats = rows_of("seat/displacement")[rows].reshape(len(rows), -1, 2) \
            if rails == 2 else None
        self.rail = rows_of("rail/displacement")[rows]
        self.sleepers_x = run.sleepers_x
        self.ends = ground_blocks.at_ends(len(run.sleepers_x), True)
        self.displacement = rows_of("sleeper/displacement")[rows]
        self.spacing = run.deck["sleepers"]["spacing"]
        self.first = axles.row_before_train(self.x[:, 0], self.sleepers_x[0])
        self.lowest = under_axles(self.x, self.sleepers_x,
                                  self.displacement - self.displacement[self.first], self.spacing)
        self.left = self.displacement[-1] - self.displacement[self.first]
        self.has_left = axles.have_passed(axles.of_wheels(wheel_x[rows[0]:]), self.sleepers_x[-1])
        self.on_ground = measures.has_ground(run)

    def on_bed(self):
        """Whether each axle is over the bed's sleepers, [time, axle]."""
        return (self.x >= self.sleepers_x[0]) & (self.x <= self.sleepers_x[-1])

    def judged_span(self):
        """x from the first to the last sleeper that is not at the ends of the bed, m; around a
        single one half a spacing on either side."""
        low, high = self.sleepers_x[~self.ends][[0, -1]]
        return (low, high) if high > low else (low - self.spacing / 2, high + self.spacing / 2)

    def off_the_rail(self):
        """Part of the rows with an axle over the bed in which a wheel there has no force."""
        there = np.repeat(self.on_bed(), self.force.shape[2], axis=1)
        return axles.time_off(there, self.force.reshape(len(there), -1))

    def sunk_since_first(self):
        """[axle, sleeper], m: how much lower a sleeper is under an axle than under the first."""
        return self.lowest[0] - self.lowest

    def reference(self):
        """The row from which displacements count, in words."""
        far = self.x[self.first, 0] <= self.sleepers_x[0] - axles.APART
        return "the last row before the train" if far else "the first row with the train"

    def state(self):
        """That the train has not passed all sleepers, in words; empty if it has."""
        return "" if self.has_left else (f"train not past all sleepers in the last row, at "
                                         f"{self.time[-1]:.4g} s")


def stage_words(run, passing):
    """Of which stage the train is, if the deck has several or if it is not that of the last
    passage, of which the histories have no row yet; otherwise empty."""
    row = min(int(np.searchsorted(run.time, passing.time[0])), len(run.stage) - 1)
    name, last = run.deck["stage"][int(run.stage[row])].get("name", ""), run.passage_stage()
    if run.stage[row] != last[0]:
        return f"stage {name} (not the last passage, stage {last[1]}: no train in its rows yet)"
    return f"stage {name}" if measures.several_passages(run) else ""


def under_axle(passing, axle):
    """Name -> (value, unit) of the sleepers under an axle, counted from 0."""
    name, inner = f"axle {axle + 1}, largest downward sleeper displacement", ~passing.ends
    found = {f"{name}, mean of sleepers": (-1e3 * np.nanmean(passing.lowest[axle][inner]), "mm"),
             f"{name}, largest of sleepers": (-1e3 * np.nanmin(passing.lowest[axle][inner]), "mm")}
    if axle > 0:
        found[f"{name} minus that of axle 1, mean of sleepers"] = (
            1e3 * np.nanmean(passing.sunk_since_first()[axle][inner]), "mm")
    return found


def numbers(passing):
    """Name -> (value, unit). Sleepers at the ends of the bed, and the rail and wheels above them,
    do not count."""
    inner, (low, high) = ~passing.ends, passing.judged_span()
    force = np.where(((passing.x >= low) & (passing.x <= high))[..., None], passing.force, np.nan)
    if not np.isfinite(force).any():
        raise read.Unreadable("no wheel was over the judged sleepers of the bed while histories "
                              "were written")
    found = {"largest wheel force over the judged sleepers": (np.nanmax(force) / 1e3, "kN"),
             "least wheel force over the judged sleepers": (np.nanmin(force) / 1e3, "kN")}
    if (off := passing.off_the_rail()) > 0:
        found["a wheel off the rail, part of the rows with a wheel over the bed"] = (100 * off, "%")
    for axle in range(force.shape[1]):
        # While the run goes on, later axles are not there yet, or near the first sleeper only.
        if not (np.isfinite(passing.lowest[axle][inner]).any()
                and np.isfinite(force[:, axle]).any()):
            continue
        found[f"axle {axle + 1}, largest force"] = (np.nanmax(force[:, axle]) / 1e3, "kN")
        if force.shape[2] == 2:
            found[f"axle {axle + 1}, left and right wheel, largest difference"] = (
                np.nanmax(np.abs(force[:, axle, 0] - force[:, axle, 1])) / 1e3, "kN")
        found |= under_axle(passing, axle)
    if passing.seats is not None:
        lean = (passing.seats[..., 0] - passing.seats[..., 1])[:, inner]
        found["left minus right seat height of a sleeper, largest"] = (1e3 * lean.max(), "mm")
        found["left minus right seat height of a sleeper, smallest"] = (1e3 * lean.min(), "mm")
    found["rail above the sleepers, largest downward displacement"] = (
        1e3 * lowered_rail(passing)[:, inner].max(), "mm")
    left = -1e3 * passing.left[inner]
    last = ("residual downward displacement of sleepers" if passing.has_left else
            "downward displacement of sleepers in the last row, train not past all of them")
    last += ", ground included" if passing.on_ground else ""
    found[f"{last}, mean"] = (left.mean(), "mm")
    found[f"{last}, largest"] = (left.max(), "mm")
    found[f"{last}, smallest (negative: upwards)"] = (left.min(), "mm")
    return found


def lowered_rail(passing):
    """Downward displacement of each rail above each sleeper, m, [time, sleeper, rail]."""
    lowered = passing.rail[passing.first] - passing.rail
    return lowered.reshape(len(lowered), len(passing.sleepers_x), -1)


def sentence(name, stage, passing, found):
    """The numbers of a train in short, for a report."""
    def of(what):
        return next(f"{value:.4g} {unit}" for key, (value, unit) in found.items() if what in key)
    state = [one for one in (stage, passing.state()) if one]
    low, high = passing.judged_span()
    return (f"{', '.join([name, *state])}: wheel forces over the judged sleepers (x = "
            f"{low:.2f} to {high:.2f} m) from {of('least wheel force')} to "
            f"{of('largest wheel force')}; rail lowered there by up to "
            f"{of('rail above the sleepers')}.")


def draw_left(panel, passing):
    """What the last train leaves, and how much lower each axle finds a sleeper than the first."""
    for axle in range(1, min(SHOWN_WHEELS, passing.x.shape[1])):
        line, = panel.plot(passing.sleepers_x, -1e3 * passing.sunk_since_first()[axle], lw=0.9,
                           marker=panels.MARKERS[axle], ms=3.5, color=f"C{axle}",
                           label=f"lowest under {panels.axle(axle, False)}, less that under axle 1")
        panels.mark_ends(panel, line, passing.ends, panels.HIDDEN)
    line, = panel.plot(passing.sleepers_x, 1e3 * passing.left, "k^--", ms=4, lw=0.9,
                       label="after the train" if passing.has_left else
                       "in the last row, train not past all sleepers")
    panels.mark_ends(panel, line, passing.ends, panels.END)
    panel.set(ylabel=f"vertical displacement\nof sleepers, {panels.UP}", xlabel="x, m")
    show_judged(panel, passing.sleepers_x, passing.ends, 1e3 * np.vstack(
        [passing.left, -passing.sunk_since_first()[1:SHOWN_WHEELS]]))


def show_judged(panel, x, ends, values):
    """Scales the panel to what is judged of `values`, mm, [line, sleeper]. Sleepers at the ends of
    the bed may move several times as far: an arrow with their largest value is at the edge."""
    with np.errstate(invalid="ignore"):
        judged = values[:, ~ends][np.isfinite(values[:, ~ends])]
    low, high = min(judged.min(initial=0), 0), max(judged.max(initial=0), 0)
    margin = MARGIN * (high - low)
    for side in (x < x.mean(), x >= x.mean()):
        there = values[:, ends & side]
        there = there[np.isfinite(there)]
        place = x[side].min() if side[0] else x[side].max()
        for beyond, value, arrow, at in (
                (there.max(initial=0) - high > margin, there.max(initial=0), "↑", 0.98),
                (low - there.min(initial=0) > margin, there.min(initial=0), "↓", 0.02)):
            if beyond and margin:
                panel.set_ylim(low - margin, high + margin)
                panel.annotate(  # beside the bed, where no line is
                    f"{arrow} up to\n{value:+.2g} mm,\nnot judged", (place, at),
                    (-6 if side[0] else 6, 0), xycoords=panel.get_xaxis_transform(),
                    textcoords="offset points", fontsize=8, ha="right" if side[0] else "left",
                    va="top" if at > 0.5 else "bottom")


def draw(passing, stretches, stage=""):
    """Three panels over x; `stretches` with blocks of the ground are shaded; `stage`: of the train,
    in words."""
    figure, (wheels, down, left) = plt.subplots(3, 1, figsize=(9, 10), sharex=True,
                                                layout="constrained")
    for axle in range(min(SHOWN_WHEELS, passing.x.shape[1])):
        words = panels.axle(axle, False)
        for rail, force in enumerate(passing.force[:, axle].T):
            side = ", right" if rail else ", left" if passing.force.shape[2] == 2 else ""
            wheels.plot(passing.x[:, axle], force / 1e3, "--" if rail else "-", lw=0.8,
                        label=words + side, **panels.curve(axle, passing.on_bed()[:, axle].sum()))
        line, = down.plot(passing.sleepers_x, 1e3 * passing.lowest[axle], label=words, lw=0.9,
                          marker=panels.MARKERS[axle], ms=3.5, color=f"C{axle}")
        panels.mark_ends(down, line, passing.ends, panels.HIDDEN if axle else panels.END)
    draw_left(left, passing)
    state = "".join(f", {one}" for one in (stage, passing.state()) if one)
    figure.suptitle(panels.wrapped(
        f"Train over the bed{state}; displacements relative to {passing.reference()}", 9, 11),
        fontsize=11)
    wheels.set(ylabel="wheel force, kN")
    down.set(ylabel=f"lowest vertical displacement\nof sleepers, {panels.UP}")
    low, high = passing.sleepers_x[0], passing.sleepers_x[-1]
    wheels.set_xlim(low - 4 * passing.spacing, high + 4 * passing.spacing)
    for panel, columns in ((wheels, 4), (down, 4), (left, 2)):
        shades.shade(panel, stretches)
        panel.grid(alpha=0.3)
        panels.legend_above(panel, columns, size=7)
    shades.name(down, stretches, z=0.03)
    return figure


def draw_into(results, folder):
    """Picture and table of one run; `results`: its folder, in a list."""
    every = read.datasets(results[0])
    if "history/energy/kinetic" not in every:
        raise read.Unreadable(f"{results[0]}: contains a track alone, without a bed")
    run = read.results(results[0])
    passing = Passing(run, every)
    found = numbers(passing)
    wide = max(map(len, found)) + 1
    stage = stage_words(run, passing)
    folder.sentences.append(sentence(run.name, stage, passing, found))
    state = [one for one in (stage, passing.state()) if one]
    text = f"{', '.join([run.name, *state])}\n" if state else ""
    text += "".join(f"{name:{wide}} {value:10.4g} {unit}\n"
                    for name, (value, unit) in found.items())
    if left_out := measures.left_out(passing.ends):
        text += f"sleepers, and rail and wheels above them: {left_out}\n"
    text += "".join(f"warning: {run.name}: {one}\n" for one in passage_warnings.of_bed(run))
    folder.picture("train", draw(passing, ground_blocks.stretches(run), stage))
    folder.table("train.txt", text)
