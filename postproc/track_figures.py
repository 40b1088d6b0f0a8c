#!/usr/bin/env python3
"""Draws a run of a track alone (model = "track") and prints the table of its numbers.

    track_figures.py RESULT_DIR -o DIR

RESULT_DIR holds results.h5. Writes track.png (wheel forces, rail and sleepers, seat loads, sleeper
acceleration) and track.txt into DIR. What is drawn is explained in docs/track.md.
"""
import argparse
import io
import pathlib

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import read  # noqa: E402
import signals  # noqa: E402
import write  # noqa: E402

FILTER = signals.LowPass()
SHOWN_WHEELS = 4  # those of the first vehicle


def history(run, name):
    """[time, place]."""
    values = run[f"history/{name}"].values
    return values.reshape(len(values), -1)


def loaded(run):
    """Datasets of a run of a track alone by their path."""
    run = read.datasets(run)
    if "history/energy/kinetic" in run and "history/wheel/force" in run:
        raise read.Unreadable("this is a train over a bed: use train_figures.py")
    if "history/wheel/force" not in run:
        raise read.Unreadable("this is no run of a track alone: it has no wheels; use figures.py")
    return run


def on_track(run, length):
    """Whether each wheel is on the track, [time, wheel]."""
    x = history(run, "wheel/x")
    return (x >= 0) & (x <= length)


def numbers(run, length):
    """Name -> (value, unit). Of wheels only while they are on the track."""
    force = history(run, "wheel/force")[on_track(run, length)]
    if not len(force):
        raise read.Unreadable("no wheel was on the track while histories were written")
    found = {"largest wheel force": (force.max() / 1e3, "kN"),
             "least wheel force": (force.min() / 1e3, "kN"),
             "scatter of wheel forces": (force.std() / 1e3, "kN")}
    time, rail = run["history/time"].values, history(run, "rail/displacement")
    for x, down in zip(run["rail/x"].values, -rail.min(axis=0)):
        found[f"rail at {x:g} m, down"] = (1e3 * down, "mm")
    if "sleepers/x" not in run:
        return found
    acceleration = FILTER(time, history(run, "sleeper/acceleration"))
    for i, x in enumerate(run["sleepers/x"].values):
        found[f"sleeper at {x:g} m, down"] = (
            -1e3 * history(run, "sleeper/displacement")[:, i].min(), "mm")
        found[f"seat at {x:g} m, largest load"] = (
            history(run, "sleeper/seat_force")[:, i].max() / 1e3, "kN")
        found[f"sleeper at {x:g} m, acceleration, {FILTER.name_for(time)}"] = (
            np.abs(acceleration[:, i]).max(), "m/s2")
    return found


def draw(run, length):
    """The four panels; those about sleepers stay away if there are none."""
    time = run["history/time"].values
    sleepers = run["sleepers/x"].values if "sleepers/x" in run else []
    figure, panels = plt.subplots(4 if len(sleepers) else 2, 1, figsize=(8, 10), squeeze=False,
                                  layout="constrained")
    wheels, rail, *others = panels[:, 0]
    x, force = history(run, "wheel/x"), history(run, "wheel/force")
    shown = np.where(on_track(run, length), force / 1e3, np.nan)
    for i in range(min(SHOWN_WHEELS, shown.shape[1])):
        wheels.plot(x[:, i], shown[:, i], lw=0.8, label=f"wheel {i + 1}")
    wheels.set(xlabel="x of the wheel, m", ylabel="wheel force, kN")
    for place, values in zip(run["rail/x"].values, history(run, "rail/displacement").T):
        rail.plot(time, 1e3 * values, lw=0.9, label=f"rail at {place:g} m")
    rail.set(ylabel="displacement, mm", xlabel="time, s")
    if others:
        acceleration = FILTER(time, history(run, "sleeper/acceleration"))
        for i, place in enumerate(sleepers):
            words = f"sleeper at {place:g} m"
            rail.plot(time, 1e3 * history(run, "sleeper/displacement")[:, i], "--", lw=0.9,
                      label=words)
            others[0].plot(time, history(run, "sleeper/seat_force")[:, i] / 1e3, lw=0.9,
                           label=words)
            others[1].plot(time, acceleration[:, i], lw=0.8, label=words)
        others[0].set(ylabel="seat load, kN", xlabel="time, s")
        others[1].set(ylabel=f"acceleration, m/s2\n{FILTER.name_for(time)}", xlabel="time, s")
    for panel in panels[:, 0]:
        panel.grid(alpha=0.3)
        panel.legend(fontsize=7, ncols=2)
    return figure


def length_of(run):
    """m, of the track, from the effective input in the results."""
    return read.results(run).deck["track"]["length"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("results", type=pathlib.Path)
    parser.add_argument("-o", dest="folder", required=True, type=pathlib.Path)
    given = parser.parse_args()
    run, length = loaded(given.results), length_of(given.results)
    write.folder(given.folder)
    picture = io.BytesIO()
    draw(run, length).savefig(picture, dpi=130, format="png")
    write.whole(given.folder / "track.png", picture.getvalue())
    text = "".join(f"{name:60} {value:10.4g} {unit}\n"
                   for name, (value, unit) in numbers(run, length).items())
    write.whole(given.folder / "track.txt", text.encode())
    print(text, end="")


if __name__ == "__main__":
    main()
