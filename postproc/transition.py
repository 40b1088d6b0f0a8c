#!/usr/bin/env python3
"""Draws a train over a transition zone, and compares two designs of it, with and without a wedge.

    transition.py RESULT_DIR [OTHER_DIR] -o DIR [--film]

RESULT_DIR holds results.h5 of a run whose last passage has a train, in a plane model. Writes
model.png (what is modelled, with the contact forces when the stones carry most), transition.png
(wheel force, level of rail and sleepers, settlement), transition.txt (numbers, and a verdict if the
runs differ by the wedge), and with --film film.gif (the train over the bed). Contact forces need
field files within the passage (`output.fields_interval`). Definition of the numbers:
docs/postproc.md.
"""
import argparse
import dataclasses
import io
import pathlib
import textwrap

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402

import measures  # noqa: E402
import model_drawing  # noqa: E402
import read  # noqa: E402
import train_figures  # noqa: E402
import write  # noqa: E402

# Blue and orange differ for colour-blind readers; lines differ by style, too, for grey prints.
STYLES = ({"color": "#0b559f", "ls": "-"}, {"color": "#d95f02", "ls": "--"})
BIN = 0.10           # m, of the largest wheel force along the track
FRAME_MS = 120       # ms, each picture of the film is shown


@dataclasses.dataclass(frozen=True)
class Train:
    """The last train of a run and what it does to the track; levels are relative to the first row,
    upwards, m."""
    run: read.Results
    passing: train_figures.Passing

    def rail_level(self):
        """Lowest level of the rail above each sleeper, m."""
        return self.passing.rail.min(axis=0) - self.passing.rail[0]

    def sleeper_level(self):
        return np.nanmin(self.passing.lowest, axis=0)

    def settlement(self):
        return -self.passing.left

    def largest_force(self):
        """x, m, and the largest force of any wheel there, N, along the bed."""
        low, high = self.run.sleepers_x[[0, -1]]
        edges = np.arange(low, high + BIN, BIN)
        x = np.repeat(self.passing.x[..., None], self.passing.force.shape[2], axis=2).ravel()
        force = self.passing.force.ravel()
        known = np.isfinite(x) & np.isfinite(force)
        number = np.digitize(x[known], edges) - 1
        found = np.full(len(edges) - 1, np.nan)
        for k in np.intersect1d(number, np.arange(len(found))):
            found[k] = force[known][number == k].max()
        return (edges[:-1] + edges[1:]) / 2, found


def train_of(folder):
    run = read.results(folder)
    if run.deck.get("dimension") != "plane":
        raise read.Unreadable(f"{run.name}: transition.py draws plane models only; use "
                              "train_figures.py")
    return Train(run, train_figures.Passing(run, read.datasets(folder)))


@dataclasses.dataclass(frozen=True)
class Change:
    """How the level of the rail under a train changes from the structure to the plain track."""
    structure: float  # m, lowest level of the rail on the structure, mean of its sleepers
    plain: float      # m, the same beyond the wedge, median; nan without plain track
    width: float      # m, from the edge to measures.REACHED of the change; nan without
    steepest: float   # m/m, between neighbouring sleepers
    force: float      # N, largest wheel force over the bed


def change_of(train, wedge):
    """`wedge`: length of the longer wedge of the runs, m. None without a structure."""
    edge = measures.edge_of_structure(train.run)
    if edge is None:
        return None
    x, level = train.run.sleepers_x, train.rail_level()
    turn = measures.direction(train.run, edge)
    order = np.argsort(turn * (x - edge))
    distance, level = (turn * (x - edge))[order], level[order]
    spacing = measures.spacing(train.run)
    beyond = distance >= wedge + spacing - measures.TINY
    before = distance <= measures.TINY
    if not before.any():
        return None
    structure = float(np.mean(level[before]))
    plain = float(np.median(level[beyond])) if np.count_nonzero(beyond) > 1 else measures.NOWHERE
    return Change(structure, plain, width_of(distance, level, structure, plain),
                  float(np.abs(np.diff(level) / np.diff(distance)).max()),
                  float(np.nanmax(train.largest_force()[1])))


def width_of(distance, level, structure, plain):
    """Distance behind the edge at which the level, linear between sleepers, first reaches
    measures.REACHED of the change; nan if never."""
    goal = structure + measures.REACHED * (plain - structure)
    at = np.concatenate([[0], distance[distance > measures.TINY]])
    there = (np.interp(at, distance, level) - goal) * np.sign(plain - structure)
    reached = np.flatnonzero(there >= 0)
    if not len(reached):
        return measures.NOWHERE
    k = reached[0]
    return float(np.interp(0, there[k - 1:k + 1], at[k - 1:k + 1])) if k else 0.0


ROWS = (("rail on the structure, lowest level", "mm", "structure", 1e3),
        ("rail on plain track beyond the wedge", "mm", "plain", 1e3),
        (f"length of the transition ({measures.REACHED:.0%} of the change)", "m", "width", 1),
        ("steepest change between two sleepers", "mm/m", "steepest", 1e3),
        ("largest wheel force over the bed", "kN", "force", 1e-3))


def compared(now, other, what, unit, factor, field):
    """'x instead of y unit (-n %)', or that there is no clear effect."""
    a, b = getattr(now, field) * factor, getattr(other, field) * factor
    if abs(a / b - 1) <= measures.CLEAR:
        return f"{what} does not change clearly ({a:.3g} instead of {b:.3g} {unit})"
    return f"{what} is {a:.3g} instead of {b:.3g} {unit} ({a / b - 1:+.0%})"


def verdict(trains, changes):
    """A sentence on the effect of the wedge, or why there is none."""
    if len(trains) < 2:
        return "No verdict: give a second run, without the wedge."
    if not measures.differ_by_wedge(*(train.run for train in trains)):
        return ("No verdict: the first run must have all blocks of the second and at least one "
                "more (the wedge).")
    if None in changes or not all(np.isfinite(change.width) for change in changes):
        return "No verdict: the bed has no structure, or no plain track beyond the wedge."
    now, other = changes
    if abs(now.plain / other.plain - 1) > measures.CLEAR:
        return (f"No verdict: the plain tracks beyond the wedge differ by more than "
                f"{measures.CLEAR:.0%}.")
    return "With the wedge, " + "; ".join(
        compared(now, other, what, unit, factor, field) for what, unit, factor, field in (
            ("the length over which the level of the rail under the train changes", "m", 1,
             "width"),
            ("its steepest change", "mm/m", 1e3, "steepest"),
            ("the largest wheel force", "kN", 1e-3, "force"))) + "."


def table(trains, changes):
    lines = [f"{'level upwards, relative to the track before the train':<52}"
             + "".join(f"{train.run.name:>14}" for train in trains)]
    for label, unit, field, factor in ROWS:
        values = [getattr(change, field) * factor if change else np.nan for change in changes]
        lines.append(f"{label + ', ' + unit:<52}" + "".join(
            f"{value:14.4g}" if np.isfinite(value) else f"{'-':>14}" for value in values))
    axles = max(len(train.passing.lowest) for train in trains)
    for axle in range(axles):
        values = [-1e3 * np.nanmean(train.passing.lowest[axle]) for train in trains
                  if axle < len(train.passing.lowest)]
        lines.append(f"{f'sleepers under axle {axle + 1}, down, mean, mm':<52}"
                     + "".join(f"{value:14.4g}" for value in values))
    lines.append(f"{'settlement of sleepers by the train, mean, mm':<52}"
                 + "".join(f"{1e3 * train.settlement().mean():14.4g}" for train in trains))
    lines.append(f"{'settlement of sleepers by the train, largest, mm':<52}"
                 + "".join(f"{1e3 * train.settlement().max():14.4g}" for train in trains))
    return "\n".join(lines) + "\n"


def compare(trains, sentence):
    """Three panels along the track, all designs in each."""
    figure, (force, level, settled) = plt.subplots(
        3, 1, figsize=(10, 9.4), sharex=True, gridspec_kw={"height_ratios": (1, 1.3, 0.8)})
    for train, style in zip(trains, STYLES):
        name, x = train.run.name, train.run.sleepers_x
        force.plot(*(value * factor for value, factor in zip(train.largest_force(), (1, 1e-3))),
                   lw=1.3, label=name, **style)
        level.plot(x, 1e3 * train.rail_level(), lw=2, label=f"rail, {name}", **style)
        level.plot(x, 1e3 * train.sleeper_level(), lw=1, marker="o", ms=3,
                   label=f"sleepers, {name}", **style)
        settled.plot(x, 1e3 * train.settlement(), lw=1.2, marker="s", ms=3, label=name, **style)
    force.set_ylabel("largest wheel force\nof all axles, kN")
    level.set_ylabel("lowest level under the train, mm")
    settled.set_ylabel("settlement by\nthe train, mm")
    settled.set_xlabel("x along the track, m")
    force.set_title(model_drawing.heading(trains[0].run), fontsize=11)
    for panel in (force, level, settled):
        model_drawing.shade_blocks(panel, trains[0].run, names=panel is level)
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8, ncols=2)
    figure.text(0.02, 0.015, textwrap.fill(sentence, 125), fontsize=10, va="bottom")
    figure.tight_layout(rect=(0, 0.02 + 0.022 * len(textwrap.wrap(sentence, 125)), 1, 1))
    model_drawing.stamp(figure, trains[0].run)
    return figure


def instants(train, folder):
    """(row of the passage, file of contacts) of each field file while a wheel is on the bed."""
    found = []
    for time, file in read.series(folder, "contacts"):
        row = int(np.argmin(np.abs(train.passing.time - time)))
        near = abs(train.passing.time[row] - time) <= 2 * np.median(np.diff(train.passing.time))
        if near and train.passing.on_bed()[row].any():
            found.append((row, file))
    return found


def draw_model(train, folder):
    """The model at the instant of the field files when the largest contact force is greatest."""
    figure, panel = plt.subplots(figsize=(13, 5.6))
    scene = model_drawing.Scene(panel, train.run)
    forces = [(model_drawing.contacts(file), row) for row, file in instants(train, folder)]
    if forces:
        chains, row = max(forces, key=lambda each: each[0].force.max(initial=0))
        scene.set_chains(chains, chains.force.max())
        words = f"largest contact force {chains.force.max() / 1e3:.1f} kN"
    else:
        row = int(np.nanargmax(np.nanmax(train.passing.force, axis=(1, 2))))
        words = "without contact forces: no field files within the passage"
    scene.set_train(train.passing.x[row])
    panel.set_title(f"{model_drawing.heading(train.run)}; {words}", fontsize=11)
    figure.tight_layout()
    model_drawing.stamp(figure, train.run)
    return figure


def film(trains, folder):
    """Frames of the first run, with the level of the rail of all designs below."""
    first = trains[0]
    # The upper panel has the shape of its contents, so that both have the same axis along x.
    long, high, left = 11.2, 11.2 * model_drawing.shape_of(first.run), 0.7  # inches
    figure = plt.figure(figsize=(long + 0.9, high + 3.2))
    size = np.array([figure.get_figwidth(), figure.get_figheight()] * 2)
    panel = figure.add_axes(np.array([left, 2.8, long, high]) / size)
    level = figure.add_axes(np.array([left, 0.6, long, 1.9]) / size, sharex=panel)
    scene = model_drawing.Scene(panel, first.run)
    panel.set(title=model_drawing.heading(first.run), xlabel="")
    model_drawing.shade_blocks(level, first.run, names=False)
    lowest = min(train.rail_level().min() for train in trains)
    level.set(ylabel="level of the rail, mm", xlabel="x along the track, m",
              ylim=(1.15e3 * lowest, -0.2e3 * lowest))
    level.grid(alpha=0.3)
    lines = [level.plot([], [], lw=2, label=train.run.name, **style)[0]
             for train, style in zip(trains, STYLES)]
    level.legend(fontsize=8, loc="lower right")
    model_drawing.stamp(figure, first.run)
    figure.canvas.draw()
    still = figure.canvas.copy_from_bbox(figure.bbox)
    shots = [(row, model_drawing.contacts(file)) for row, file in instants(first, folder)]
    if not shots:
        raise read.Unreadable(f"{first.run.name}: no field files within the passage: set "
                              "output.fields and output.fields_interval")
    largest = max(chains.force.max(initial=0) for _, chains in shots)
    frames = []
    for row, chains in shots:
        figure.canvas.restore_region(still)
        moving = [scene.set_chains(chains, largest), *scene.set_train(first.passing.x[row])]
        for train, line in zip(trains, lines):
            at = int(np.argmin(np.abs(train.passing.time - first.passing.time[row])))
            line.set_data(train.run.sleepers_x, 1e3 * (train.passing.rail[at]
                                                       - train.passing.rail[0]))
        for artist in (*moving, *lines):
            artist.axes.draw_artist(artist)
        frames.append(Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert(
            "P", palette=Image.Palette.ADAPTIVE, colors=128))
    plt.close(figure)
    file = io.BytesIO()
    frames[0].save(file, format="GIF", save_all=True, append_images=frames[1:], loop=0,
                   duration=FRAME_MS)
    return file.getvalue()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("results", type=pathlib.Path, help="folder with results.h5")
    parser.add_argument("other", type=pathlib.Path, nargs="?", help="a second run to compare with")
    parser.add_argument("-o", dest="folder", required=True, type=pathlib.Path)
    parser.add_argument("--film", action="store_true", help="also write film.gif")
    arguments = parser.parse_args()
    trains = [train_of(path) for path in (arguments.results, arguments.other) if path]
    wedge = max(measures.wedge_length(train.run) for train in trains)
    changes = [change_of(train, wedge) for train in trains]
    sentence = verdict(trains, changes)
    text = table(trains, changes) + "\n" + sentence + "\n"
    write.folder(arguments.folder)
    written = []
    for name, figure in (("transition.png", compare(trains, sentence)),
                         ("model.png", draw_model(trains[0], arguments.results))):
        picture = io.BytesIO()
        figure.savefig(picture, dpi=130)
        plt.close(figure)
        written.append((name, picture.getvalue()))
    if arguments.film:
        written.append(("film.gif", film(trains, arguments.results)))
    for name, contents in (*written, ("transition.txt", text.encode())):
        write.whole(arguments.folder / name, contents)
    for name, _ in written:
        print(arguments.folder / name)
    print(text, end="")


if __name__ == "__main__":
    main()
