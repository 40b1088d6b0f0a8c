"""Figures of the study crossing, from its lines alone."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from . import crossing_stones as stones  # noqa: E402
from .crossing_cases import BEDS, STIFFNESS  # noqa: E402
from .study import COLOURS, save  # noqa: E402


def draw(lines, folder):
    plain(lines, folder, "displacement", "time (s)", "displacement (mm)")
    plain(lines, folder, "kernel", "time (ms)", "response (1e-12 m per N and sample)")
    plain(lines, folder, "indicators", "indicator (m/s2)", "largest wheel force (kN)", "o-")
    draw_forces(lines, folder)
    draw_ballast(lines, folder)
    if lines.of("scanned_paths"):
        draw_scanned(lines, folder)
    if lines.of("stones"):
        draw_stones(lines, folder)


def plain(lines, folder, name, x, y, style="-"):
    figure, panel = plt.subplots(figsize=(8, 4), constrained_layout=True)
    for label, (across, up) in lines.of(name).items():
        panel.plot(across, up, style, lw=1, ms=3, label=label)
    panel.set_xlabel(x)
    panel.set_ylabel(y)
    panel.legend(fontsize=8)
    panel.grid(alpha=0.3)
    save(figure, folder / f"{name}.png")


def draw_forces(lines, folder):
    figure, panels = plt.subplots(2, 1, sharex=True, figsize=(8, 6), constrained_layout=True)
    for panel, name, unit, label in zip(panels, ("forces", "surface"), ("kN", "mm"),
                                        ("wheel force (kN)", "running surface (mm)")):
        curves = lines.of(name)
        x, found = map(np.array, curves[f"identified, {unit}"])
        deviation = np.array(curves[f"standard deviation, {unit}"][1])
        panel.plot(x, found, lw=1, color=COLOURS[0], label="identified, standard deviation")
        panel.fill_between(x, found - deviation, found + deviation, alpha=0.25, color=COLOURS[0])
        panel.plot(*curves[f"true, {unit}"], "--", lw=0.8, color=COLOURS[1], label="true")
        panel.set_ylabel(label)
        panel.legend(fontsize=8)
        panel.grid(alpha=0.3)
    panels[0].set_title("Dip of 1.5 mm in 1.2 m, first wheel, 0.1 % noise, first seed", fontsize=10)
    panels[-1].set_xlabel("x (m); sensor at 18 m")
    save(figure, folder / "forces.png")


def draw_ballast(lines, folder):
    figure, panel = plt.subplots(figsize=(8, 4), constrained_layout=True)
    for number, name in enumerate(name for name in BEDS
                                  if f"{name}, model, mm" in lines.of("ballast")):
        curves = lines.of("ballast")
        panel.plot(*curves[f"{name}, reconstructed, mm"], ".", ms=3, color=COLOURS[number])
        panel.plot(*curves[f"{name}, model, mm"], lw=1, color=COLOURS[number],
                   label=f"{name}: {1e-6 * BEDS[name] * STIFFNESS:g} MN/m")
    panel.set_xlabel("position of the first wheel (m); points: reconstructed, lines: model")
    panel.set_ylabel("displacement of the sleeper (mm)")
    panel.legend(fontsize=8)
    panel.grid(alpha=0.3)
    save(figure, folder / "ballast.png")


def draw_scanned(lines, folder):
    figure, (paths, surface) = plt.subplots(2, 1, sharex=True, figsize=(8, 7),
                                            constrained_layout=True)
    for number, (label, curve) in enumerate(lines.of("scanned_paths").items()):
        facing = label.startswith("facing")
        paths.plot(*curve, "-" if facing else "--", lw=1, color=COLOURS[number % 3], label=label)
    drawn = {}
    for label, curve in lines.of("scanned_surface").items():
        design, move, what = label.split(", ")
        facing = move == "facing"
        if what == "true":
            drawn.setdefault(move, curve)  # that of all designs
            continue
        surface.plot(*curve, "-" if facing else "--", lw=1,
                     color=COLOURS[0 if design == "60E" else 1],
                     label=f"{design}, {move}, identified")
    for move, curve in drawn.items():
        surface.plot(*curve, "-" if move == "facing" else "--", lw=2.5, alpha=0.4, zorder=0,
                     color="black" if move == "facing" else COLOURS[3], label=f"{move}, true")
    paths.set_ylabel("path of the wheel (mm)")
    surface.set_ylabel("running surface, S1002 (mm)")
    surface.set_xlabel("x (m); sensor at 18 m")
    for panel in (paths, surface):
        panel.legend(fontsize=7)
        panel.grid(alpha=0.3)
    save(figure, folder / "scanned.png")


def draw_stones(lines, folder):
    """Displacement by case, and the error of the reconstructed one."""
    curves = lines.of("stones")
    cases = [case for case in stones.CASES if f"{case}, true, mm" in curves]
    figure, panels = plt.subplots(len(cases), 2, sharex=True, figsize=(10, 1.7 * len(cases)),
                                  constrained_layout=True, squeeze=False)
    for (left, right), case in zip(panels, cases):
        time, true = map(np.array, curves[f"{case}, true, mm"])
        found = np.array(curves[f"{case}, reconstructed, mm"][1])
        left.plot(time, true, lw=1, color=COLOURS[1], label="true")
        left.plot(time, found, "--", lw=1, color=COLOURS[0], label="reconstructed")
        right.plot(time, 1e3 * (found - true), lw=1, color=COLOURS[2])
        left.set_title(f"{case}: displacement of the sleeper", fontsize=9)
        right.set_title("reconstructed minus true", fontsize=9)
        left.set_ylabel("displacement (mm)", fontsize=8)
        right.set_ylabel("difference (um)", fontsize=8)
        for panel in (left, right):
            panel.grid(alpha=0.3)
    panels[0, 0].legend(fontsize=8)
    for panel in panels[-1]:
        panel.set_xlabel("time (s)")
    save(figure, folder / "stones.png")
