"""Figures of the study chen, from its numbers and lines alone."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from .chen_runs import (CARRIAGE, DECK, DEPTHS, EXTREMES, HEIGHT, LOADS, MIDDLE,  # noqa: E402
                        PACKINGS, SLEEPERS, SPEEDS, name_of)
from .chen_targets import has_series  # noqa: E402
from .study import COLOURS, save  # noqa: E402


def figures(numbers, lines, folder):
    draw_settlement(lines, folder)
    draw_breaks(numbers, lines, folder)
    draw_stress(lines, folder)
    if has_series(numbers):
        draw_speeds(numbers, folder)
        draw_path(lines, folder)


def draw_settlement(lines, folder):
    figure, panels = plt.subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
    for panel, (tonnes, kmh) in zip(panels, EXTREMES):
        for k, (name, (time, down)) in enumerate(
                lines.of(f"settlement {name_of(tonnes, kmh, 1)}").items()):
            panel.plot(np.array(time) * kmh / 3.6 / CARRIAGE, down, lw=0.9, label=name,
                       color=(*COLOURS, "0.4")[k])
        panel.set(title=f"{tonnes} t, {kmh} km/h, packing 1", xlabel="v t / length of a carriage")
        panel.grid(alpha=0.3)
    panels[0].set_ylabel("displacement of sleepers, downwards (mm)")
    panels[0].invert_yaxis()
    panels[1].legend(fontsize=8)
    save(figure, folder / "settlement.png")


def draw_breaks(numbers, lines, folder):
    figure = plt.figure(figsize=(11, 5.5), layout="constrained")
    sides = figure.subplot_mosaic([["17", "17", "time"], ["25", "25", "time"]])
    x = DECK["sleepers"]["first"] + DECK["sleepers"]["spacing"] * np.arange(len(SLEEPERS))
    width = DECK["sleepers"]["width"]
    for tonnes, kmh in EXTREMES:
        panel, name = sides[str(tonnes)], name_of(tonnes, kmh, 1)
        panel.plot(*lines.of("breaks")[name], ".", ms=3, color=COLOURS[1])
        for k, centre in zip(SLEEPERS, x):
            panel.add_patch(plt.Rectangle((centre - width / 2, HEIGHT), width, 0.08, color="0.7"))
            panel.text(centre, HEIGHT + 0.1, f"{numbers(name, f'corners broken, sleeper {k}'):.0f}",
                       ha="center", fontsize=8)
        panel.set(title=f"corners broken off, {tonnes} t, {kmh} km/h, packing 1 (number below each "
                        "sleeper)", xlim=(0, 3), ylim=(0, 0.65), ylabel="z (m)", aspect="equal")
        panel.title.set_fontsize(9)
    sides["25"].set_xlabel("x (m)")
    panel = sides["time"]
    for colour, (tonnes, kmh) in zip(COLOURS, EXTREMES):
        for packing in PACKINGS:
            line = lines.of("breakage").get(name_of(tonnes, kmh, packing))
            if line:
                panel.plot(*line, color=colour, label=f"{tonnes} t" if packing == 1 else None)
    panel.set(xlabel="time (s)", ylabel="corners broken off, each packing")
    panel.legend()
    panel.grid(alpha=0.3)
    save(figure, folder / "breaks.png")


def draw_stress(lines, folder):
    figure, panels = plt.subplots(2, 3, figsize=(12, 6.5), layout="constrained")
    for panel, title in zip(panels[0], ("vertical", "horizontal", "shear")):
        for colour, (label, line) in zip(COLOURS, lines.of(title).items()):
            panel.plot(*line, lw=0.8, color=colour, label=label)
        panel.set(title=f"{title} stress below sleeper {MIDDLE + 1}", xlabel="time (s)")
        panel.grid(alpha=0.3)
    panels[0][0].set_ylabel("kPa")
    panels[0][0].legend(fontsize=8)
    for panel, depth in zip(panels[1], DEPTHS):
        for colour, (label, line) in zip(COLOURS, lines.of(f"path, {depth} m").items()):
            panel.plot(*line, lw=0.9, color=colour, label=label)
        panel.set(title=f"last bogie, {depth} m below the sleeper",
                  xlabel="vertical - horizontal (kPa)")
        panel.grid(alpha=0.3)
    panels[1][0].set_ylabel("2 shear (kPa)")
    panels[1][0].legend(fontsize=8)
    save(figure, folder / "stress.png")


def draw_speeds(numbers, folder):
    figure, panels = plt.subplots(1, 4, figsize=(14, 3.8), layout="constrained")
    for panel, (quantity, label) in zip(panels, (
            ("settlement, sleeper 3", "settlement of sleeper 3 (mm)"),
            ("corners broken", "corners broken off"),
            ("ballast on sub-ballast", "ballast on sub-ballast (kPa)"),
            ("mean speed", "mean speed of stones (mm/s)"))):
        for colour, tonnes in zip(COLOURS, LOADS):
            panel.plot(SPEEDS, [numbers(name_of(tonnes, kmh, PACKINGS[0]), quantity)
                                for kmh in SPEEDS], "o-", color=colour, label=f"{tonnes} t")
        panel.set(xlabel="speed (km/h)", title=label, xticks=SPEEDS)
        panel.set_ylim(bottom=0)
        panel.grid(alpha=0.3)
    panels[0].legend()
    save(figure, folder / "speeds.png")


def draw_path(lines, folder):
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for colour, (label, line) in zip(COLOURS, lines.of("sine, time").items()):
        left.plot(*line, color=colour, label=label)
    left.set(xlabel="time (s)", ylabel="change of stress (kPa)")
    left.legend()
    for line in lines.of("sine, path").values():
        right.plot(*line, color=COLOURS[0])
    right.set(xlabel="vertical - horizontal (kPa)", ylabel="2 shear (kPa)")
    for panel in (left, right):
        panel.grid(alpha=0.3)
    save(figure, folder / "path.png")
