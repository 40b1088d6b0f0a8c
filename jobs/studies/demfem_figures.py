"""Figures of the study demfem, from its numbers and lines alone."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from .demfem_model import (GROUND_DECK, GROUND_RUN, GROUNDS, HARD, MIDDLE, NAMES,  # noqa: E402
                           PACKINGS, PERIOD, RAIL, RAMP, SHAPES, SOFT, TITLES, ground_run)
from .demfem_targets import mean, tracked  # noqa: E402
from .study import COLOURS, save  # noqa: E402

STYLES = {"convex": {"color": COLOURS[1]}, "non_convex": {"color": COLOURS[0]}}
WIDTH = 0.5  # m, of the rise of the modulus in the deck
PUBLISHED = {"convex": 1.5, "non_convex": 12}  # kN, largest force on a stone


def figures(n, lines, folder):
    draw_stones(n, lines, folder)
    draw_track(n, lines, folder)
    draw_ground(lines, folder)


def young(x, width):
    """Pa, the assumed modulus of the ground."""
    return SOFT + (HARD - SOFT) * (1 + np.tanh((x - MIDDLE) / width)) / 2


def draw_ground(lines, folder):
    figure, panels = plt.subplots(3, 1, figsize=(9, 9), sharex=True, layout="constrained",
                                  height_ratios=(1, 2, 2))
    styles = dict(zip(GROUNDS, ("-", "--", ":", "-.", (0, (1, 3)), (0, (5, 1, 1, 1, 1, 1)))))
    x = np.linspace(0, 6, 301)
    for name, style in styles.items():
        line = {"ls": style, "lw": 1.8 if ground_run(name) == GROUND_RUN else 1}
        for panel, what in zip(panels[1:], ("tension", "compression")):
            panel.plot(*lines.of(what)[ground_run(name)], label=NAMES.get(name, name), **line)
        width = float(name.split()[-2]) if name.startswith("rise") else WIDTH
        if name.startswith("rise") or ground_run(name) == GROUND_RUN:
            panels[0].plot(x, 1e-9 * young(x, width), color=f"C{list(GROUNDS).index(name)}",
                           **line)
    for panel, label in zip(panels, ("modulus, GPa", "largest tension, MPa",
                                     "largest compression, MPa")):
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
        for area in GROUND_DECK["pressure"]:
            panel.axvspan(*area["x"], color="0.9", zorder=0)
    panels[1].axhline(0.1, color="k", lw=0.8, label="published peak of tension")
    panels[1].legend(fontsize=8)
    panels[2].set_xlabel("x, m")
    save(figure, folder / "ground.png")


def draw_track(n, lines, folder):
    if not tracked(n):
        return
    figure, panels = plt.subplots(3, 2, figsize=(11, 10), layout="constrained")
    end = mean(n, "convex", "simulated", "track")
    shown = (("track_sleepers", "x, m",
              f"sleepers, mean of {end - PERIOD:.2f} to {end:.2f} s,\nmm down"),
             *((f"track_rail_{place}", "time, s", f"rail at x = {x:g} m ({place}),\nmm down")
               for place, x in RAIL.items()),
             ("track_tension", "x, m", "largest tension in the ground,\nwith the weight, MPa"),
             ("track_compression", "x, m",
              "largest compression in the ground,\nwith the weight, MPa"))
    for panel, (name, x_label, y_label) in zip(panels.flat, shown):
        for shape in SHAPES:
            band(panel, shape, [curve for run, curve in lines.of(name).items()
                                if run.startswith(f"track_{shape}_")])
        panel.set(xlabel=x_label, ylabel=y_label)
        panel.grid(alpha=0.3)
        if x_label == "time, s":
            panel.axvspan(RAMP, RAMP + PERIOD, color="0.9", zorder=0,
                          label="first axle spacing\nafter the ramp")
        panel.legend(fontsize=8)
    for panel in panels.flat[:4]:
        panel.invert_yaxis()
    save(figure, folder / "track.png")


def band(panel, shape, curves):
    """Mean over packings, and from the least to the most."""
    x = np.array(curves[0][0])
    y = np.array([np.interp(x, *curve) for curve in curves])
    panel.fill_between(x, y.min(axis=0), y.max(axis=0), alpha=0.25, lw=0, **STYLES[shape])
    panel.plot(x, y.mean(axis=0), label=TITLES[shape], **STYLES[shape])


def draw_stones(n, lines, folder):
    figure, (settled, loop, force) = plt.subplots(3, 1, figsize=(9, 10), layout="constrained")
    for shape in SHAPES:
        runs = [f"bed_{shape}_{packing}" for packing in PACKINGS if n.has(f"bed_{shape}_{packing}")]
        band(settled, shape, [lines.of("settlement")[run] for run in runs])
        loop.plot(*lines.of("loop")[runs[0]], lw=0.8, label=TITLES[shape], **STYLES[shape])
        parts = np.mean([lines.of("forces")[run][1] for run in runs], axis=0)[1:]
        force.step(lines.of("forces")[runs[0]][0][1:], np.where(parts > 0, parts, np.nan),
                   where="mid", label=TITLES[shape], **STYLES[shape])
        force.axvline(PUBLISHED[shape], ls="--", lw=1, **STYLES[shape],
                      label=f"largest published force on a stone, {TITLES[shape]}")
    settled.invert_yaxis()
    settled.set(xlabel="time, s", ylabel="displacement of the sleepers, mm down")
    loop.set(xlabel="strain, 1e-3", ylabel="stress below a sleeper, kPa")
    force.set(xlabel="contact force, kN", ylabel="contacts, %", xscale="log", yscale="log")
    for panel in (settled, loop, force):
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    save(figure, folder / "stones.png")
