"""Laboratory tests of ballast compared with published values: shear, triaxial, compression, heaps.

A laboratory test is a run with a stage of kind `shear`, `triaxial`, `lift_walls`, or several of
kind `compact`; runs of one kind share a figure (shear, triaxial, heap, compression). Definition of
the numbers, sources of the published values, and reasons for differences: docs/laboratory.md.
"""

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import figure_csv, heap, panels, read

GRAVITY = 9.81   # m/s^2
SMOOTH = 1e-3    # m of displacement over which stresses are averaged; a row is a mean over a window

# Values in degrees and MPa. Those not checked are from memory (docs/laboratory.md).
ONSET = 0.25  # pressure over the strength of stones above which the compression line is fitted
PUBLISHED_FRICTION = {"clean ballast, 15-75 kPa, range not checked in a source": (45, 65),
                      "coarse soil, critical (Dolzyk-Szypcio 2019)": (41.2, 41.2)}
PUBLISHED_TRIAXIAL = {"clean ballast, 15-120 kPa, range not checked in a source": (45, 65)}
PUBLISHED_MODULUS = {"ballast, first loading, range not checked in a source": (20, 100)}
PUBLISHED_REPOSE = {"crushed stone, range not checked in a source": (35, 45)}


def kinds(run):
    return [stage.get("kind") for stage in run.deck.get("stage", [])]


def splits_in_compaction(run):
    """Whether stones split in the last stage, one of compaction, with enough of them to fit."""
    return (kinds(run)[-1] == "compact" and any(len(rows) > 10 for rows in run.breaks.values())
            and run.deck["breakage"]["splitting"]["strength"] > 0)


def area(run):
    """Area of the floor between the walls, m^2, as used for the pressure of the platen."""
    bed = run.deck["bed"]
    length, width = np.diff(bed["x"])[0], np.diff(bed["y"])[0]
    if run.deck["dimension"] == "plane":
        width = run.deck["thickness"]
    if bed.get("container") != "cylinder":
        return length * width
    corners = 64
    return corners / 2 * (length / 2)**2 * np.sin(2 * np.pi / corners)


def smoothed(displacement, values):
    """Mean of `values` over SMOOTH of the displacement about each row."""
    return np.array([values[np.abs(displacement - at) <= SMOOTH / 2].mean() for at in displacement])


def shear(run):
    """Histories of a shear stage: shear displacement and rise of the platen, m, stresses, Pa."""
    rows = run.stage == kinds(run).index("shear")
    force = {name: wall["force"].values[rows] for name, wall in run.walls.items()}
    displacement = np.abs(run.walls["floor"]["displacement"].values[rows, 0])
    upper = sum(f for name, f in force.items() if name.endswith(".upper"))
    lower = sum(f for name, f in force.items() if name.endswith(".lower")) + force["floor"]
    plate = run.platen["force"].values[rows]
    # The weight of the stones below the shear plane does not load it.
    stones = next(reversed(run.stones.values())).sieved[:, 1].sum() * GRAVITY
    height = run.platen["z"].values[rows]
    below = stones * run.deck["bed"]["split"] / height
    sign = np.sign(np.sum(upper[:, 0]))
    return {"displacement": displacement, "rise": height - height[0],
            "tau": smoothed(displacement, sign * (upper + plate)[:, 0]) / area(run),
            "sigma": smoothed(displacement, plate[:, 2]) / area(run),
            "plane": smoothed(displacement, -lower[:, 2] - below) / area(run)}


def triaxial(run):
    """Histories of a triaxial stage: axial strain, volumetric strain (compression positive) and
    stresses, Pa. sigma_1 is the mean of platen and floor, which holds at half the height with the
    stones' weight and the friction of the walls; sigma_3 the mean of the walls over their current
    sides."""
    rows = run.stage == kinds(run).index("triaxial")
    bed, height = run.deck["bed"], run.platen["z"].values[rows]
    force = (run.platen["force"].values[rows, 2] - run.walls["floor"]["force"].values[rows, 2]) / 2
    sides, pushes = [], []
    for axis, (low, high) in enumerate((("left", "right"), ("front", "back"))):
        width = np.full(len(height), np.diff(bed["xy"[axis]])[0] if axis == 0
                        or run.deck["dimension"] == "space" else run.deck["thickness"])
        if f"wall.{low}" in run.walls:
            walls = [run.walls[f"wall.{name}"] for name in (low, high)]
            ways = [wall["displacement"].values[rows, axis] for wall in walls]
            width = width - ways[0] + ways[1]
            pushes.append((axis, (walls[1]["force"].values[rows, axis]
                                  - walls[0]["force"].values[rows, axis]) / 2))
        sides.append(width)
    volume = sides[0] * sides[1] * height
    axial = 1 - height / height[0]
    lateral = np.mean([push / (sides[1 - axis] * height) for axis, push in pushes], axis=0)
    return {"axial": axial, "volumetric": 1 - volume / volume[0],
            "sigma_1": smoothed(axial * height[0], force / (sides[0] * sides[1])),
            "sigma_3": smoothed(axial * height[0], lateral)}


def compression(run):
    """At the end of each compacting stage: its name, strain since the first, pressure, Pa."""
    ends = []
    for number, stage in enumerate(run.deck["stage"]):
        rows = np.flatnonzero(run.stage == number)
        if stage.get("kind") == "compact" and len(rows):
            ends.append((stage["name"], run.platen["z"].values[rows[-1]],
                         run.platen["pressure"].values[rows[-1]]))
    height = ends[0][1]
    return [(name, 1 - z / height, pressure) for name, z, pressure in ends]


def moduli(steps):
    """Constrained modulus between the ends of consecutive stages, Pa."""
    return [(name, (pressure - steps[k][2]) / (strain - steps[k][1]))
            for k, (name, strain, pressure) in enumerate(steps[1:]) if strain != steps[k][1]]


def crushing(run):
    """While a layer that breaks is compressed: pressure, Pa; void ratio of all solids, fines
    included, and of the stones that are left, which bear the pressure; mass of the fines over that
    of all solids."""
    names = [stage["name"] for stage in run.deck["stage"]]
    number = names.index(next(reversed(run.breaks)))
    rows, breaks = run.stage == number, next(reversed(run.breaks.values()))
    mass = run.stones[names[number - 1]].sieved[:, 1].sum()
    density = next(material["density"] for material in run.deck["material"]
                   if material["name"] == run.deck["bed"]["material"])
    here = breaks[:, read.BREAK["time"]] > run.time[rows][0]
    fines = breaks[here & (breaks[:, read.BREAK["fragment"]] < 0)]
    lost = np.array([fines[fines[:, read.BREAK["time"]] <= at, read.BREAK["mass"]].sum()
                     for at in run.time[rows]]) / mass
    volume = area(run) * run.platen["z"].values[rows]
    solids = mass / density
    return {"pressure": run.platen["pressure"].values[rows], "all": volume / solids - 1,
            "left": volume / (solids * (1 - lost)) - 1, "fines": lost}


def slope_of_compression(got, which, least):
    """d log e/d log p of a void ratio above the pressure `least`, Pa."""
    above = (got["pressure"] > least) & (got[which] > 0)
    return np.polyfit(np.log(got["pressure"][above]), np.log(got[which][above]), 1)[0]


def dilation_angle(axial, volumetric):
    """Dilation angle of a triaxial test, degrees: sin psi = -de_v/(2 de_1 - de_v), compression
    positive (e.g. Bolton 1986, doi:10.1680/geot.1986.36.1.65)."""
    slope = np.polyfit(axial, volumetric, 1)[0]
    return np.degrees(np.arcsin(-slope / (2 - slope)))


def draw_shear(runs, folder):
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(7, 8), sharex=True, layout="constrained")
    lines = ["direct shear: values where the ratio of shear stress tau to normal stress, both on"
             " the shear plane, is largest; dilation angle of the last two thirds of the"
             " displacement\n"
             "                 sigma, kPa       tau  sigma, kPa  friction angle, deg   dilation  at"
             "\n                  of platen       kPa  on plane   platen    plane      angle, deg"
             "  mm"]
    for number, run in enumerate(runs):
        got = shear(run)
        peak = int(np.argmax(got["tau"] / got["plane"]))
        name = f"{got['sigma'].mean() / 1e3:.0f} kPa"
        look = panels.curve(number, len(got["tau"]))
        top.plot(1e3 * got["displacement"], got["tau"] / got["plane"], label=name, **look)
        bottom.plot(1e3 * got["displacement"], 1e3 * got["rise"], label=name, **look)
        angles = [np.degrees(np.arctan(got["tau"][peak] / got[by][peak]))
                  for by in ("sigma", "plane")]
        # From a third of the displacement on, where the rise of single stones averages out.
        later = got["displacement"] > got["displacement"][-1] / 3
        slope = np.polyfit(got["displacement"][later], got["rise"][later], 1)[0]
        lines.append(f"{run.name:18} {got['sigma'][peak] / 1e3:6.1f} "
                     f"{got['tau'][peak] / 1e3:9.1f} {got['plane'][peak] / 1e3:12.1f} "
                     f"{angles[0]:8.1f} {angles[1]:8.1f} "
                     f"{np.degrees(np.arctan(slope)):15.1f} {1e3 * got['displacement'][peak]:4.0f}")
    for k, (name, (low, high)) in enumerate(PUBLISHED_FRICTION.items()):
        low, high = np.tan(np.radians([low, high]))
        top.axhspan(low, high, color=f"C{7 + k}", alpha=0.3, lw=1, label=name)
    top.set_ylabel("shear stress / normal stress on the plane")
    bottom.set_ylabel("rise of the platen, mm")
    bottom.set_xlabel("displacement of the lower half, mm")
    top.set_ylim(bottom=0)
    top.legend(fontsize=8)
    folder.picture("shear", figure)
    return lines


def strength(got):
    """From the histories of `triaxial`: friction angle at its peak and mean of the last tenth,
    degrees, and the number of the peak's row."""
    axial = got["axial"]
    angle = np.degrees(np.arcsin((got["sigma_1"] - got["sigma_3"])
                                 / (got["sigma_1"] + got["sigma_3"])))
    later = axial > axial[-1] / 10   # walls and platen have reached their pressures
    peak = int(np.argmax(np.where(later, angle, -90)))
    return angle[peak], angle[axial > 0.9 * axial[-1]].mean(), peak


def draw_triaxial(runs, folder):
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(7, 8), sharex=True, layout="constrained")
    lines = ["triaxial            sigma_3  peak q  friction angle, deg  at axial     dilation  "
             "secant E to 0.5 %"
             "\n                        kPa     kPa      peak     last    strain, %"
             "  angle, deg         MPa"]
    for number, run in enumerate(runs):
        got = triaxial(run)
        q, axial = got["sigma_1"] - got["sigma_3"], got["axial"]
        most, last, peak = strength(got)
        name = f"{got['sigma_3'].mean() / 1e3:.0f} kPa"
        look = panels.curve(number, len(axial))
        top.plot(100 * axial, q / got["sigma_3"], label=name, **look)
        bottom.plot(100 * axial, 100 * got["volumetric"], label=name, **look)
        near = np.abs(axial - axial[peak]) < axial[-1] / 6   # a third of the test
        first = int(np.argmax(axial >= 0.005))
        lines.append(f"{run.name:19} {got['sigma_3'].mean() / 1e3:7.1f} {q[peak] / 1e3:7.1f} "
                     f"{most:9.1f} {last:8.1f} {100 * axial[peak]:12.1f} "
                     f"{dilation_angle(axial[near], got['volumetric'][near]):11.1f} "
                     f"{(q[first] - q[0]) / (axial[first] - axial[0]) / 1e6:11.1f}")
    for k, (name, angles) in enumerate(PUBLISHED_TRIAXIAL.items()):
        sines = np.sin(np.radians(angles))
        top.axhspan(*(2 * sines / (1 - sines)), color=f"C{7 + k}", alpha=0.3, lw=1, label=name)
        lines.append(f"published           {name}: peak {angles[0]:g} to {angles[1]:g} deg")
    top.set_ylabel("deviatoric stress / confining pressure")
    bottom.set_ylabel("volumetric strain, % (compression positive)")
    bottom.set_xlabel("axial strain, %")
    top.set_ylim(bottom=0)
    top.legend(fontsize=8)
    folder.picture("triaxial", figure)
    return lines


def draw_compression(runs, folder):
    figure, axes = plt.subplots(figsize=(7, 5), layout="constrained")
    lines = ["compression         stage            strain, %   stress, kPa   modulus, MPa"]
    for run in runs:
        steps = compression(run)
        found = dict(moduli(steps))
        _, strains, pressures = zip(*steps)
        axes.plot(100 * np.array(strains), 1e-3 * np.array(pressures), "o-", label=run.name)
        for name, strain, pressure in steps:
            modulus = f"{found[name] / 1e6:14.1f}" if name in found else ""
            lines.append(f"{run.name:19} {name:16} {100 * strain:9.3f} {pressure / 1e3:13.1f} "
                         f"{modulus}")
    for name, ends in PUBLISHED_MODULUS.items():
        lines.append(f"published           {name}: {ends[0]:g} to {ends[1]:g} MPa")
        most = axes.get_ylim()[1] * 1e3
        for modulus in ends:
            line, = axes.plot([0, 100 * most / (1e6 * modulus)], [0, most / 1e3], "--",
                              color="0.5", lw=1)
            figure_csv.name(line, f"{modulus:g} MPa: {name}")
        axes.plot([], [], "--", color="0.5", label=f"{ends[0]:g} and {ends[1]:g} MPa: {name}")
    axes.set_xlabel("strain, %")
    axes.set_ylabel("pressure of the platen, kPa")
    axes.set_xlim(0, 130 * max(strain for run in runs for _, strain, _ in compression(run)))
    axes.legend(fontsize=8)
    folder.picture("compression", figure)
    return lines


def draw_crushing(runs, folder):
    """Compression lines beside the published slope -1/(2 b) of log e over log p, with the size
    effect d^-b of the strength (McDowell and de Bono 2013, doi:10.1680/geot.12.P.041)."""
    figure, axes = plt.subplots(figsize=(7, 5), layout="constrained")
    lines = ["crushing            fines, % of mass   slope of log e: all solids   stones left   "
             "published"]
    for k, run in enumerate(runs):
        got = crushing(run)
        splitting = run.deck["breakage"]["splitting"]
        published = -splitting["weibull"] / 6  # b = 3/weibull
        onset = splitting["strength"] * ONSET
        slopes = [slope_of_compression(got, which, onset) for which in ("all", "left")]
        for which, words, slope, style in zip(("all", "left"), ("all solids", "stones left"),
                                              slopes, ("-", ":")):
            axes.plot(1e-6 * got["pressure"], got[which], style, color=f"C{k}",
                      label=f"{run.name}, {words}: {slope:.2f}")
        at = np.argmax(got["pressure"] > onset)
        ends = np.array([got["pressure"][at], got["pressure"].max()])
        axes.plot(1e-6 * ends, got["all"][at] * (ends / ends[0])**published, "--", color="0.5",
                  label=f"slope {published:.2f} (McDowell and de Bono 2013)")
        lines.append(f"{run.name:19} {100 * got['fines'][-1]:16.1f} {slopes[0]:28.2f} "
                     f"{slopes[1]:13.2f} {published:11.2f}")
    axes.set(xscale="log", yscale="log", xlabel="pressure of the platen, MPa",
             ylabel="void ratio")
    axes.legend(fontsize=8)
    folder.picture("crushing", figure)
    return lines


def draw_heaps(runs, folder):
    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    lines = ["heap                angle of repose, deg   standard deviation of "
             f"{heap.SECTORS} sectors, deg   stones"]
    reach = np.zeros(2)
    for k, (run, path) in enumerate(runs):
        saved = read.checkpoint(path)
        stones = len(saved["particles/position"].values)
        size = np.median(next(reversed(run.stones.values())).sieved[:, 0])
        angle, scatter, points = heap.flank(heap.placed(saved), size)
        axes.plot(points[:, 0], points[:, 1], ".", color=f"C{k}",
                  label=f"{run.name}: {angle:.1f} deg")
        if len(points):
            slope, foot = np.polyfit(points[:, 0], points[:, 1], 1)
            reach = np.array([0, -foot / slope])
            line, = axes.plot(reach, foot + slope * reach, color=f"C{k}", lw=1)
            figure_csv.name(line, f"{run.name}: fitted flank")
        lines.append(f"{run.name:19} {angle:20.1f} {scatter:34.1f} {stones:8}")
    for name, (low, high) in PUBLISHED_REPOSE.items():
        lines.append(f"published           {name}: {low:g} to {high:g} deg")
        for angle in (low, high):
            line, = axes.plot(reach, reach[-1] * np.tan(np.radians(angle))
                              - np.tan(np.radians(angle)) * reach, "--", color="0.5", lw=1)
            figure_csv.name(line, f"{angle:g} deg: {name}")
        axes.plot([], [], "--", color="0.5", label=f"{low:g} and {high:g} deg: {name}")
    axes.set_aspect("equal")
    axes.set_xlabel("radius of a circle with the area of the heap at this height, m")
    axes.set_ylabel("height, m")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.legend(fontsize=8)
    folder.picture("heap", figure)
    return lines


def draw_into(results, folder):
    """Pictures and table of any number of runs, given by their folders."""
    runs = [(read.results(path), path) for path in results]
    sheared = [run for run, _ in runs if "shear" in kinds(run)]
    heaps = [(run, path) for run, path in runs if "lift_walls" in kinds(run)]
    squeezed = [run for run, _ in runs if "triaxial" in kinds(run)]
    pressed = [run for run, _ in runs if kinds(run).count("compact") > 1
               and not {"shear", "triaxial"} & set(kinds(run))]
    crushed = [run for run in pressed if splits_in_compaction(run)]
    known = [*sheared, *squeezed, *pressed, *(run for run, _ in heaps)]
    if others := [run.name for run, _ in runs if not any(run is one for one in known)]:
        raise read.Unreadable(f"not a laboratory test: {', '.join(others)}; such a test has a "
                              "stage of kind shear, triaxial or lift_walls, or several of kind "
                              "compact")
    lines = []
    for draw, those in ((draw_shear, sheared), (draw_triaxial, squeezed),
                        (draw_compression, pressed), (draw_crushing, crushed),
                        (draw_heaps, heaps)):
        lines += draw(those, folder) if those else []
    folder.table("laboratory.txt", "\n".join(lines) + "\n")
