"""Figures of the study demfem, from its numbers and lines alone."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from .demfem_model import GROUND_RUN, GROUNDS, PACKINGS, SHAPES, TITLES, ground_run  # noqa: E402
from .demfem_targets import of  # noqa: E402
from .study import COLOURS, save  # noqa: E402

NAMES = {"as in the deck": "reference: rise of the modulus over 0.5 m"}  # in tables and figures
STYLES = {"convex": {"color": COLOURS[1]}, "non_convex": {"color": COLOURS[0]}}


def figures(n, lines, folder):
    draw_stones(n, lines, folder)
    draw_track(n, lines, folder)
    figure, panels = plt.subplots(2, 1, figsize=(9, 6), sharex=True, layout="constrained")
    styles = dict(zip(GROUNDS, ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)))))
    for panel, what in zip(panels, ("tension", "compression")):
        for name, style in styles.items():
            panel.plot(*lines.of(what)[ground_run(name)], ls=style, label=NAMES.get(name, name),
                       lw=1.8 if ground_run(name) == GROUND_RUN else 1)
        panel.set_ylabel(f"largest {what}, MPa")
        panel.grid(alpha=0.3)
    panels[0].axhline(0.1, color="k", lw=0.8, label="published peak of tension")
    panels[0].legend(fontsize=8)
    panels[1].set_xlabel("x, m")
    save(figure, folder / "ground.png")


def draw_track(n, lines, folder):
    if not of(n, "convex", "simulated", "track"):
        return
    figure, panels = plt.subplots(2, 2, figsize=(11, 7), layout="constrained")
    shown = (("track_sleepers", "x, m", "sleepers, last axle spacing, mm down"),
             ("track_rail_middle", "time, s", "rail in the middle, mm down"),
             ("track_tension", "x, m", "largest tension in the ground, MPa"),
             ("track_compression", "x, m", "largest compression in the ground, MPa"))
    for panel, (name, x_label, y_label) in zip(panels.flat, shown):
        for shape in SHAPES:
            curves = [curve for run, curve in lines.of(name).items()
                      if run.startswith(f"track_{shape}_")]
            x = np.array(curves[0][0])
            y = np.array([np.interp(x, *curve) for curve in curves])
            panel.fill_between(x, y.min(axis=0), y.max(axis=0), alpha=0.25, lw=0, **STYLES[shape])
            panel.plot(x, y.mean(axis=0), label=TITLES[shape], **STYLES[shape])
        panel.set(xlabel=x_label, ylabel=y_label)
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    for panel in panels[0]:
        panel.invert_yaxis()
    save(figure, folder / "track.png")


def draw_stones(n, lines, folder):
    figure, (settled, loop, force) = plt.subplots(3, 1, figsize=(9, 10), layout="constrained")
    for shape in SHAPES:
        runs = [f"bed_{shape}_{packing}" for packing in PACKINGS if n.has(f"bed_{shape}_{packing}")]
        curves = [lines.of("settlement")[run] for run in runs]
        x = np.array(curves[0][0])
        y = np.array([np.interp(x, *curve) for curve in curves])
        settled.fill_between(x, y.min(axis=0), y.max(axis=0), alpha=0.25, lw=0, **STYLES[shape])
        settled.plot(x, y.mean(axis=0), label=TITLES[shape], **STYLES[shape])
        loop.plot(*lines.of("loop")[runs[0]], lw=0.8, label=TITLES[shape], **STYLES[shape])
        parts = np.mean([lines.of("forces")[run][1] for run in runs], axis=0)
        force.step(lines.of("forces")[runs[0]][0], np.where(parts > 0, parts, np.nan), where="mid",
                   label=TITLES[shape], **STYLES[shape])
    settled.invert_yaxis()
    settled.set(xlabel="time, s", ylabel="displacement of the sleepers, mm, down")
    loop.set(xlabel="strain, 1e-3", ylabel="stress below a sleeper, kPa")
    force.set(xlabel="contact force, kN", ylabel="contacts, %", xscale="log", yscale="log")
    for panel in (settled, loop, force):
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    save(figure, folder / "stones.png")
