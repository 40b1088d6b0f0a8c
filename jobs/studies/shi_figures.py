"""Figures of the study shi, from its numbers and lines alone."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from . import shi_space_document  # noqa: E402
from .shi_decks import DESIGNS, EDGE, LOAD, TITLES  # noqa: E402
from .shi_runs import AXLE_AT, BOUNDARIES, FIXED, MAPPED, S1, S2, SPEEDS, WEDGES  # noqa: E402
from .shi_tables import NAMES  # noqa: E402
from .shi_targets import cases, full  # noqa: E402
from .study import COLOURS, as_file, save  # noqa: E402

STYLES = {"none": {"color": COLOURS[1]}, "wedge": {"color": COLOURS[0]}}


def band(panel, n, lines, figure, design, **style):
    """Mean of all packings, and the range between them."""
    runs = [lines.of(figure)[run] for run in cases(n, design) if run in lines.of(figure)]
    if not runs:
        return
    x = np.array(runs[0][0])
    y = np.array([np.interp(x, *run) for run in runs])
    if len(runs) > 1:
        panel.fill_between(x, y.min(axis=0), y.max(axis=0), alpha=0.25, lw=0, **STYLES[design])
    panel.plot(x, y.mean(axis=0), label=TITLES[design], **STYLES[design], **style)


def edge(panel):
    panel.axvspan(0, EDGE, color="0.9", lw=0, zorder=0)
    panel.grid(alpha=0.3)


def figures(n, lines, folder):
    draw_surface(n, lines, folder)
    draw_stress(n, lines, folder)
    draw_sleepers(n, lines, folder)
    draw_histories(n, lines, folder)
    if full(n):
        draw_ground(lines, folder)
        for what in MAPPED:
            draw_maps(lines, folder, what)
        shi_space_document.draw(lines, folder)


def draw_surface(n, lines, folder):
    figure, panel = plt.subplots(figsize=(9.5, 4.6), layout="constrained")
    for design in DESIGNS:
        band(panel, n, lines, "ground", design, lw=1.8)
        alone = lines.of("ground").get(f"ground_{design}_{as_file(FIXED)}")
        if alone:
            panel.plot(*alone, "--", lw=1.2, label=f"{TITLES[design]}, ground alone",
                       **STYLES[design])
    if full(n):
        for x, value, design in (((6, 17), 1.8, "none"), ((15, 17), 1.64, "wedge")):
            panel.plot(x, [value] * 2, ":", lw=2, label=f"published, {TITLES[design]}",
                       **STYLES[design])
        panel.plot((0, EDGE), [0.02] * 2, ":", lw=2, color=COLOURS[3],
                   label="published, both")
    edge(panel)
    panel.invert_yaxis()
    panel.set(xlabel="x, m (grey: structure); bands: range over packings",
              ylabel="largest displacement of the\nsurface, mm, down")
    panel.legend(fontsize=8, ncols=4, loc="lower left", bbox_to_anchor=(0, 1.01))
    save(figure, folder / "surface.png")


def smooth(x, y, width=0.6):
    x = np.asarray(x)
    return np.array([np.mean(np.asarray(y)[np.abs(x - at) <= width / 2]) for at in x])


def draw_stress(n, lines, folder):
    figure, panels = plt.subplots(2, 1, figsize=(9, 6), sharex=True, layout="constrained")
    for panel, design in zip(panels, DESIGNS):
        runs = [lines.of("stress")[run] for run in cases(n, design)]
        for run in runs:
            panel.plot(*run, lw=0.6, alpha=0.6, color="0.5")
        x = runs[0][0]
        panel.plot(x, np.mean([smooth(*run) for run in runs], axis=0), lw=2, **STYLES[design],
                   label=f"{TITLES[design]}: mean over a sleeper spacing and all packings")
        panel.plot([], [], color="0.5", lw=0.6, label="nodes, each packing")
        edge(panel)
        panel.set_ylabel("largest vertical stress, kPa")
        panel.legend(fontsize=8, loc="upper right")
    if full(n):
        panels[0].plot([EDGE - 0.1, EDGE + 0.1], [165, 27], "o", color="k", ms=7,
                       mfc=COLOURS[3], zorder=5, label="published: largest, near x = 2 m, and next")
        panels[0].legend(fontsize=8, loc="upper right")
    panels[-1].set_xlabel("x, m (grey: structure)")
    save(figure, folder / "stress.png")


def draw_sleepers(n, lines, folder):
    figure, panels = plt.subplots(4, 1, figsize=(9, 10), sharex=True, layout="constrained")
    if full(n):
        draw_published(panels)
    places = ({"loc": "upper left"}, {"loc": "upper left"},
              {"loc": "center", "bbox_to_anchor": (0.5, 0.64)}, {"loc": "upper right"})
    for panel, place, (name, label) in zip(panels, places, (
            ("sleeper", "sleepers, mm down"), ("ballast", "ballast 0.15 m\nbelow them, mm down"),
            ("sleeper acceleration", "sleepers, g"),
            ("ballast acceleration", "ballast 0.15 m\nbelow them, g"))):
        for design in DESIGNS:
            band(panel, n, lines, name, design, lw=1.4, marker="o", ms=3)
        edge(panel)
        if not lines.of(name):  # all packings have lost a support
            continue
        found = np.concatenate([line[1] for line in lines.of(name).values()])
        limit = 2 * np.quantile(found, 0.95)
        if found.max() > limit:
            panel.set_ylim(0, limit)
            panel.text(0.01, 0.93, f"largest value, not shown: {found.max():.1f}", va="top",
                       fontsize=8, transform=panel.transAxes)
        panel.set_ylabel(label)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(fontsize=8, ncols=2, **place)
    panels[-1].set_xlabel("x, m (grey: structure); bands: range over packings")
    save(figure, folder / "sleepers.png")


def draw_published(panels):
    """Of sleepers: displacements as dots, where ours are compared; accelerations as ranges."""
    for x, value, design in ((EDGE - 0.1, 0.75, "none"), (S1, 1.7, "wedge")):
        panels[0].plot(x, value, "s", mfc="none", ms=7, label=f"published, {TITLES[design]}",
                       zorder=5, **STYLES[design])
    panels[0].plot([], [], " ", label="(x of the latter assumed)")
    for design, ends in (("none", (0.62, 1.34)), ("wedge", (0.61, 1.57))):
        for value in ends:
            panels[2].axhline(value, ls=":", lw=1.2, **STYLES[design])
        panels[2].plot([], [], ":", label=f"published {ends[0]} to {ends[1]} g, {TITLES[design]}",
                       **STYLES[design])


def draw_histories(n, lines, folder):
    figure, panels = plt.subplots(3 if full(n) else 1, 1, figsize=(9, 9 if full(n) else 3.5),
                                  layout="constrained", squeeze=False)
    panels = panels[:, 0]
    for panel, seat in zip(panels[:-1], (S1, S2)):
        for design in DESIGNS:
            panel.plot(*lines.of(f"history, {seat:g} m")[f"stones_{design}_1"], lw=1,
                       label=f"{TITLES[design]}, sleeper at {seat:g} m, packing 1",
                       **STYLES[design])
        panel.set(xlabel="time since the first axle was 3 m before the ground, s",
                  ylabel="displacement of\nthe sleeper, mm, down")
        panel.invert_yaxis()
    spectra, load = lines.of("spectra"), None
    for design in DESIGNS:
        run = next((run for run in cases(n, design) if f"{run}, acceleration" in spectra), None)
        if run:
            panels[-1].plot(*spectra[f"{run}, acceleration"], lw=1.2, **STYLES[design],
                            label=f"sleepers, {TITLES[design]}, packing {run.split('_')[-1]}")
            if f"{run}, ballast acceleration" in spectra:
                panels[-1].plot(*spectra[f"{run}, ballast acceleration"], "-.", lw=1,
                                label=f"ballast, {TITLES[design]}", **STYLES[design])
            load = spectra[f"{run}, seat force"]
    if load:
        panels[-1].plot(*load, "k--", lw=0.8, label="load times frequency squared")
    panels[-1].set(xlabel="frequency, Hz",
                   ylabel="spectrum of the acceleration\nover its largest value")
    for panel in panels:
        panel.grid(alpha=0.3)
        if panel.lines:
            panel.legend(fontsize=8)
    save(figure, folder / "histories.png")


SHOWN_MAPS = {"velocity": 20, "acceleration": 0.3}  # mm/s and g, where arrows end


def draw_maps(lines, folder, what):
    figure, panels = plt.subplots(len(AXLE_AT), len(DESIGNS), figsize=(13, 9), sharex=True,
                                  sharey=True, layout="constrained")
    end, unit = SHOWN_MAPS[what], MAPPED[what][1]
    for row, at in zip(panels, AXLE_AT):
        found = lines.of(f"map {at} m")
        for panel, design in zip(row, DESIGNS):
            x, z = (np.concatenate(both) for both in zip(
                *(found[f"maps_{design}, {part} at"] for part in ("stones", "ground"))))
            along, up = (np.concatenate(both) for both in zip(
                *(found[f"maps_{design}, {part} {what}"] for part in ("stones", "ground"))))
            size = np.hypot(along, up)
            along, up = (of * np.minimum(1, end / np.maximum(size, 1e-9)) for of in (along, up))
            shown = panel.quiver(x, z, along, up, size, cmap="viridis", width=0.002,
                                 angles="xy", scale=12.5 * end, clim=(0, end))
            panel.plot([at], [0.7], "kv", ms=7)
            panel.axvspan(0, EDGE, color="0.9", lw=0, zorder=0)
            panel.set_title(f"{TITLES[design]}, first axle at {at} m", fontsize=9)
            if design == "none":
                panel.set_ylabel("z, m")
    for panel in panels[-1]:
        panel.set_xlabel("x, m (grey: structure)")
    figure.colorbar(shown, ax=panels, label=f"{what}, {unit} (arrows end at {end:g})", shrink=0.6,
                    extend="max")
    save(figure, folder / f"maps_{what}.png")


def draw_ground(lines, folder):
    figure, panels = plt.subplots(3, 1, figsize=(9, 9.6), sharex=True, layout="constrained")
    found = lines.of("ground")
    speeds = {FIXED: f"{3.6 * LOAD['speed']:.1f} km/h",
              **{f"{v} km/h": f"{v} km/h" for v in SPEEDS}}
    groups = (
        ("wedges", "wedge", {FIXED: "wedge of 13 m",
                             **{name: NAMES.get(name, name) for name in WEDGES}}),
        ("boundaries, without wedge", "none",
         {FIXED: "fixed base, rollers at the sides",
          **{name: NAMES.get(name, name) for name in list(BOUNDARIES)[1:4]}}),
        ("speeds, without wedge", "none", speeds))
    for panel, (title, design, names) in zip(panels, groups):
        panel.set_title(f"ground alone: {title}", fontsize=9)
        if design == "wedge":
            panel.plot(*found[f"ground_none_{as_file(FIXED)}"], color="k", lw=1, label="no wedge")
        for k, (name, label) in enumerate(names.items()):
            panel.plot(*found[f"ground_{design}_{as_file(name)}"], lw=1.2, label=label,
                       color=(*COLOURS, "0.4", "#E69F00")[k % 6])
        edge(panel)
        panel.invert_yaxis()
        panel.set_ylabel("surface, mm, down")
        panel.legend(fontsize=7, ncols=2)
    panels[-1].set_xlabel("x, m (grey: structure)")
    save(figure, folder / "ground.png")
