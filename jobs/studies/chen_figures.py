"""Figures of the study chen, from its numbers and lines alone."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from .chen_runs import (CARRIAGE, DECK, DEPTHS, EXTREMES, HEIGHT, LOADS, MIDDLE,  # noqa: E402
                        PACKINGS, SLEEPERS, SPEEDS, name_of)
from .chen_targets import (FASTER, SETTLED, VELOCITY, has_series,  # noqa: E402
                           moving, speed_of_stones)
from .study import COLOURS, save  # noqa: E402

PLACES = ("0.2", "#E69F00", "#56B4E9")  # colours of places below a sleeper
# Published points of a quantity, (axle load, t; speed, km/h): value. The load of the series of
# speeds is inferred, see chen_targets.targets_of_speed.
PUBLISHED = {"settlement, sleeper 3": {**{(tonnes, 120): down for tonnes, down in SETTLED.items()},
                                       **{(20, kmh): down for kmh, down in FASTER.items()}},
             "mean speed": {(25, kmh): speed for kmh, speed in VELOCITY.items()}}


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
        panel.plot(1.03 * np.max(time) * kmh / 3.6 / CARRIAGE, SETTLED[tonnes], "*", ms=12,
                   color=COLOURS[MIDDLE], mec="black", clip_on=False,
                   label=f"sleeper {MIDDLE + 1}, published,\nafter five carriages")
        panel.set(title=f"{tonnes} t, {kmh} km/h, packing 1", xlabel="v t / length of a carriage")
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    panels[0].set_ylabel("displacement of sleepers, downwards (mm)")
    panels[0].invert_yaxis()
    save(figure, folder / "settlement.png")


def draw_breaks(numbers, lines, folder):
    figure = plt.figure(figsize=(11, 5.5), layout="constrained")
    sides = figure.subplot_mosaic([["17", "17", "time"], ["25", "25", "time"]])
    x = DECK["sleepers"]["first"] + DECK["sleepers"]["spacing"] * np.arange(len(SLEEPERS))
    width, height = DECK["sleepers"]["width"], DECK["sleepers"]["height"]
    for tonnes, kmh in EXTREMES:
        panel, name = sides[str(tonnes)], name_of(tonnes, kmh, 1)
        panel.plot(*lines.of("breaks")[name], ".", ms=3, color=COLOURS[1])
        for k, centre in zip(SLEEPERS, x):
            panel.add_patch(plt.Rectangle((centre - width / 2, HEIGHT), width, height, color="0.7"))
            count = numbers(name, f"corners broken, sleeper {k}")
            panel.text(centre, HEIGHT + height / 3, f"{count:.0f}", ha="center", fontsize=8)
        panel.set(title=f"corners broken off, {tonnes} t, {kmh} km/h, packing 1 (number below each "
                        "sleeper written on it)",
                  xlim=(0, 3), ylim=(0, 0.72), ylabel="z (m)", aspect="equal")
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
    panels[0][2].legend(fontsize=8, loc="upper right")
    for panel, depth in zip(panels[1], DEPTHS):
        for colour, (label, line) in zip(PLACES, lines.of(f"path, {depth} m").items()):
            panel.plot(*line, lw=0.9, color=colour, label=label)
        panel.set(title=f"last bogie, {depth} m below the sleeper",
                  xlabel="vertical - horizontal (kPa)")
        panel.grid(alpha=0.3)
    panels[1][0].set_ylabel("2 shear (kPa)")
    panels[1][2].legend(fontsize=8, loc="lower left")
    figure.suptitle("{} t, {} km/h, packing 1".format(*EXTREMES[-1]))
    save(figure, folder / "stress.png")


def draw_speeds(numbers, folder):
    figure, panels = plt.subplots(1, 4, figsize=(14, 3.8), layout="constrained")
    for panel, (quantity, label) in zip(panels, (
            ("settlement, sleeper 3", "settlement of sleeper 3 (mm)"),
            ("corners broken", "corners broken off"),
            ("ballast on sub-ballast", "ballast on sub-ballast (kPa)"),
            (speed_of_stones(numbers), f"mean speed of {moving(numbers)} (mm/s)"))):
        for colour, tonnes in zip(COLOURS, LOADS):
            panel.plot(SPEEDS, [numbers(name_of(tonnes, kmh, PACKINGS[0]), quantity)
                                for kmh in SPEEDS], "o-", color=colour, label=f"{tonnes} t")
            points = [(kmh, value) for (of, kmh), value in published(quantity).items()
                      if of == tonnes]
            if points:
                panel.plot(*zip(*points), "*", ms=12, color=colour, mec="black", zorder=4,
                           label=f"{tonnes} t{' (inferred)' if tonnes == 20 else ''}, published")
        panel.set(xlabel="speed (km/h)", xticks=SPEEDS)
        panel.set_title(label, fontsize=10)
        panel.set_ylim(bottom=0)
        panel.grid(alpha=0.3)
    for panel in (panels[0], panels[-1]):
        panel.legend(fontsize=8)
    figure.suptitle(f"packing {PACKINGS[0]}")
    save(figure, folder / "speeds.png")


def published(quantity):
    return PUBLISHED.get(quantity.removesuffix(" of ballast"), {})


def draw_path(lines, folder):
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for colour, (label, line) in zip(COLOURS, lines.of("sine, time").items()):
        left.plot(*line, color=colour, label=label)
    left.set(xlabel="time (s)", ylabel="change of stress (kPa)")
    left.legend()
    for line in lines.of("sine, path").values():
        right.plot(*line, color=COLOURS[0])
        right.plot(*np.transpose(line)[0], "o", color=COLOURS[0], label="begin")
        for k in range(2, len(line[0]) - 4, 4):
            right.annotate("", *np.transpose(line)[[k + 1, k]],
                           arrowprops={"arrowstyle": "->", "color": COLOURS[0],
                                       "mutation_scale": 18})
    right.legend()
    right.set(xlabel="vertical - horizontal (kPa)", ylabel="2 shear (kPa)")
    for panel in (left, right):
        panel.grid(alpha=0.3)
    save(figure, folder / "path.png")
