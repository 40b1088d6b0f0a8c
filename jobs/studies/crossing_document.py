"""Document and figures of the study crossing, from its numbers and lines alone."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from . import crossing_scanned as scanned  # noqa: E402
from . import crossing_stones as stones  # noqa: E402
from .crossing import (BEDS, DAMPINGS, JOINTS, NOISE, PANELS, STIFFNESS, VARIANTS,  # noqa: E402
                       VEES, VOIDS, variant)
from .study import COLOURS, heading, save, table  # noqa: E402

from trackbed_post.monitor import ballast  # noqa: E402, I001 (found by .study)

TITLE = "crossing: from one accelerometer to forces, irregularity and ballast"
SOURCE = """The thesis *Model-based condition monitoring of railway switches and crossings* derives
displacement, indicators, train and speed, wheel forces, the irregularity of the running surface and
the stiffness of the ballast from the acceleration of one sleeper. Its measurements are not
published. Here the program's own passages over a crossing (`inputs/track/crossing.toml`) are the
measurements, so that the truth is known; the chain is that of [monitoring.md](../../monitoring.md).
"""
CRITERION = """Where the thesis gives no number, the limit is ours. Errors are the worst over all
seeds of the noise, whose size is relative to the root mean square of the acceleration."""


def names(n):
    return [name for name in JOINTS if n.has(f"joint_{name}")]


def document(n):
    return "".join((part_passages(n), part_indicators(n), part_forces(n),
                    part_scanned(n), part_ballast(n), part_stones(n), part_jenkins(n),
                    part_missing()))


def summary(n):
    worst = max(n(f"joint_{name}", "error of the largest force, noise 0.1 %, worst")
                for name in names(n))
    surface = max(n(f"joint_{name}", "error of the irregularity, noise 0.1 %, worst")
                  for name in names(n))
    bed = max(n(f"bed_{name.split()[0]}", "error of the stiffness, worst") for name in BEDS
              if n.has(f"bed_{name.split()[0]}"))
    return f"""
- With 0.1 % noise, the largest wheel force errs by at most {worst:.1f} %, the irregularity by
  {surface:.1f} % of its depth, the stiffness of the ballast at the sensor by {bed:.1f} %.
- Forces are identified from the acceleration. From the displacement, as in the thesis, the largest
  force is {100 * (1 - n("joint_middle", thesis()) / n("joint_middle", "largest force")):.0f} % too
  small, since the displacement hardly contains the impact.
- The place of the wheels in the record must be known to a centimetre for the irregularity.
{summary_of_scans(n)}{summary_of_stones(n)}"""


SEEN = ballast.SIGNIFICANT**2  # reduction of the sum of squares with which a void is recognised


def summary_of_scans(n):
    """The worst of all designs and directions of travel, by wheel."""
    texts = []
    for wheel, title in scanned.WHEELS.items():
        runs = [run for run in (scanned.name_of(*case, wheel) for case in scanned.CASES)
                if n.has(run)]
        if runs:
            errors = [[n(run, f"error of {what}, worst")
                       for what in ("the largest force", "the irregularity")] for run in runs]
            found = [one for one in errors if np.isfinite(one).all()]
            lost = f"; train not found in {len(errors) - len(found)} of {len(errors)} runs" \
                if len(found) < len(errors) else ""
            force, surface = np.max(found, axis=0) if found else (np.inf, np.inf)
            texts.append(f"{force:.0f} and {surface:.0f} % ({title}{lost})")
    return (f"- On a made-up scan of a crossing, the largest force and the irregularity err by at "
            f"most {'; '.join(texts)}.\n") if texts else ""


def summary_of_stones(n):
    cases = [case for case in stones.CASES if n.has(stones.name_of(case))]
    runs = [stones.name_of(case) for case in cases]
    if not runs:
        return ""
    moved, force = (max(n(run, f"error of {quantity}, noise 0.1 %, worst") for run in runs)
                    for quantity in ("displacement", "largest force"))
    stiffness = [f"{n(run, 'error of stiffness, noise 0.1 %, worst'):.0f} % ({case})"
                 for run, case in zip(runs, cases)]
    voids = [n(run, "reduction of the sum of squares") > SEEN for run in runs if "void" in run]
    return f"""- On stones, the displacement errs by at most {moved:.1f} %, the largest force by
  {force:.0f} %, the stiffness by {', '.join(stiffness)}. Voids that are recognised: {sum(voids)} of
  {len(voids)}.
"""


def thesis():
    return f"largest force, {variant(*VARIANTS[-1])}"


def part_passages(n):
    rows = []
    for noise in (0.0, *NOISE):
        cells = []
        for method in ("smoothing", "high_pass"):
            quantity = f"error of displacement, {method}, noise {100 * noise:g} %"
            cells += [f"{n('known', f'{quantity}, {part}'):.1f}" for part in ("median", "worst")]
        rows.append((f"{100 * noise:g} %", *cells))
    return heading("Displacement and train") + f"""
![Reconstructed and true displacement of the first coaches, 0.1 % noise](displacement.png)

Error of the displacement of six coaches at 50 m/s, % of the largest displacement:

{table(["noise", "smoothing, median", "worst", "high-pass (thesis), median", "worst"], rows)}
A minute of one core is enough for {n("known", "passages of 10 s in a minute"):.0f} passages of 10 s
at 5 kHz. A train of six coaches is recognised at another speed with a similarity of
{n("other", "similarity, least"):.3f}; a single coach has {n("single", "similarity"):.2f} and is
unknown.
"""


def part_indicators(n):
    rows = [(panel, f"{n(panel, 'rank correlation'):.3f}") for panel in PANELS]
    return heading("Indicators") + f"""
![Largest wheel force over the indicator, six panels](indicators.png)

Dips of 0.2 to 4 mm in 0.6 to 2 m cause wheel forces of {n("dips", "least force"):.0f} to
{n("dips", "largest force"):.0f} kN at 50 m/s. The rank correlation of the indicator of 1 to 0.2 m
with the largest force is {n("dips", "rank correlation"):.3f}. The six panels of the thesis are not
published; these differ in their pads (values of the thesis) and in their ballast:

{table(["panel", "rank correlation"], rows)}"""


def part_forces(n):
    rows, chosen = [], []
    for name in names(n):
        run, (depth, length) = f"joint_{name}", JOINTS[name]
        for noise in NOISE:
            words = f"noise {100 * noise:g} %"

            def pair(quantity, run=run, words=words):
                return " / ".join(f"{n(run, f'error of {quantity}, {words}, {part}'):.1f}"
                                  for part in ("median", "worst"))
            rows.append((f"{1e3 * depth:g} mm in {length:g} m, "
                         f"{n(run, 'largest force'):.0f} kN", f"{100 * noise:g} %",
                         pair("the largest force"), pair("the irregularity"), pair("the place"),
                         f"{n(run, f'error over stated deviation, {words}'):.1f}"))
    for one in VARIANTS:
        chosen.append((variant(*one), *(
            f"{n(f'joint_{name}', f'largest force, {variant(*one)}'):.0f}" for name in names(n))))
    true = ("truth", *(f"{n(f'joint_{name}', 'largest force'):.0f}" for name in names(n)))
    head = ["", *(f"{1e3 * JOINTS[name][0]:g} mm" for name in names(n))]
    return heading("Wheel forces and irregularity") + f"""
![Green's functions of the sleeper](kernel.png)

![Identified and true force and running surface, 0.1 % noise](forces.png)

Errors, median / worst, over seeds and both wheels; the last column is the root mean square of the
errors over their stated deviations:

{table(["dip, largest force", "noise", "largest force, %", "irregularity, % of its depth",
        "place, cm", "over deviation"], rows)}
Largest force of the first wheel, kN, 0.1 % noise, one seed, by method (docs/monitoring.md). The
last row is that of the thesis:

{table(head, [*chosen, true])}
The thesis says that responses have almost decayed after 0.03 s; here
{n("kernel", "largest response after 0.03 s"):.0f} % of the largest are left.
"""


def part_scanned(n):
    cases = [case for case in scanned.CASES if n.has(scanned.name_of(*case))]
    if not cases:
        return ""
    rows = []
    for design, move in cases:
        for wheel, title in scanned.WHEELS.items():
            run, path = scanned.name_of(design, move, wheel), f"path_{move}_{wheel}"
            rows.append((design, move, title, f"{n(path, 'depth'):.2f}", f"{n(path, 'kink'):.1f}",
                         f"{n(run, 'largest force'):.0f}", f"{n(run, 'indicator'):.1f}",
                         *(f"{n(run, f'error of {what}, median'):.1f} / "
                           f"{n(run, f'error of {what}, worst'):.1f}"
                           for what in ("the largest force", "the irregularity",
                                        "the place"))))
    panels = [(place, name, design, move,
               f"{n(scanned.name_of(design, move), 'largest force'):.0f}"
               if (design, move) in cases else "")
              for place, name, design, move in scanned.PANELS]
    return heading("Scanned crossings") + f"""
![Paths of the wheels; running surface, identified and true](scanned.png)

The thesis rolls wheels over scans of six crossings. These are not published: here
`inputs/track/crossing_scan.py` makes a scan of a crossing of 1:18.5 with noise, outliers and a
hole, and `trajectory` lets wheels of profile S1002, as they are and with a hollow tread, roll over
it. Its paths are the irregularities of `inputs/track/crossing_panel.toml` at 50 m/s: pads of
{scanned.PADS["60E"] / 1e6:.0f} MN/m (60E) and {scanned.PADS["UIC60"] / 1e6:.0f} MN/m (UIC60),
facing and trailing. Errors with 0.1 % noise, median / worst, over seeds; the irregularity over its
depth, the place of the train in the record in cm. Where the place is wrong by centimetres, the
running surface is found beside its true place; inf: the passage is refused, as its place is not
found:

{table(["design", "move", "wheel", "depth, mm", "kink, mrad", "largest force, kN",
        "indicator, m/s2", "force, %", "irregularity, %", "place, cm"], rows)}
The six panels of the thesis (its Table 1) with this scan and wheels of profile S1002:

{table(["location", "crossing", "design", "move", "largest force, kN"], panels)}"""


def part_ballast(n):
    rows = []
    for name in BEDS:
        run = f"bed_{name.split()[0]}"
        if n.has(run):
            far = n(run, "stiffness far away, error over stated deviation")
            rows.append((f"{1e-6 * BEDS[name] * STIFFNESS:g}",
                         *(f"{n(run, f'error of the stiffness, {part}'):.1f}"
                           for part in ("median", "worst")), f"{far:.1f}"))
    text = heading("Ballast") + f"""
![Displacement and that of the calibrated model, wavelengths above 3 m](ballast.png)

The three sleepers at the sensor have another stiffness than the rest
({1e-6 * STIFFNESS:g} MN/m of one rail seat). The dip of the running surface is not known to the
calibration, which fits a smooth one of 1.5 m. Errors of the stiffness at the sensor with 0.1 %
noise; far from the sensor the stiffness is uncertain, and its error is given over the stated
deviation:

{table(["MN/m", "error, median, %", "worst, %", "far away, over deviation"], rows)}"""
    if not n.has("voids"):
        return text
    found = [(f"{1e3 * void:g}", f"{n(f'void_{k + 1}', 'void'):.2f} +- "
              f"{n(f'void_{k + 1}', 'its deviation'):.2f}",
              f"{n(f'void_{k + 1}', 'reduction of the sum of squares'):.0f}")
             for k, void in enumerate(VOIDS)]
    return text + f"""
A void below the sleeper with the sensor is found by the closing of the gap:

{table(["void, mm", "found, mm", "reduction of the sum of squares"], found)}
{n("voids", "found"):.0f} of {len(VOIDS)} are reported as voids, and
{n("voids", "false alarms"):.0f} in the passages without one.
"""


def part_stones(n):
    cases = [case for case in stones.CASES if n.has(stones.name_of(case))]
    if not cases:
        return ""
    rows, voids = [], []
    for case in cases:
        run = stones.name_of(case)
        for noise in stones.NOISE:
            words = f"noise {100 * noise:g} %"

            def pair(quantity, form, run=run, words=words):
                return " / ".join(f"{n(run, f'{quantity}, {part}, {words}'):{form}}"
                                  for part in ("found", "true"))
            rows.append((case, f"{100 * noise:g} %",
                         f"{n(run, f'error of displacement, {words}, worst'):.1f}",
                         pair("settlement", ".3f"), pair("stiffness", ".0f"),
                         f"{n(run, f'error of stiffness, {words}, worst'):.0f}",
                         pair("largest force", ".0f"),
                         f"{n(run, f'error of largest force, {words}, worst'):.0f}"))
        voids.append(f"{n(run, 'reduction of the sum of squares'):.1f} ({case})")
    soft = n(stones.name_of("void of 1 mm"), "stiffness, found, noise 0.1 %")
    sound = n(stones.name_of("sound"), "stiffness, found, noise 0.1 %")
    return heading("On stones") + f"""
![Reconstructed and true displacement on stones, 0.1 % noise](stones.png)

The accelerometer is on a sleeper of a plane bed of 521 stones on a ground
(`inputs/track/sensor.toml`), after ten trains. The rail has a dip of 0.3 mm above it. The chain
assumes a track on springs (`inputs/track/sensor_alone.toml`) and knows the noise of the sensor.
Voids are gaps to which the straight rail lifts the sleeper, fouled ballast has half of the
friction in the recorded trains, the soft subgrade half of the stiffness. Mean of two trains, found
/ true; errors of the worse one:

{table(["case", "noise", "error of displacement, %", "settlement, mm", "stiffness, MN/m",
        "error, %", "largest force, kN", "error, %"], rows)}
The true stiffness is the secant of the reaction of the stones over the displacement, both of
wavelengths above 3 m. Forces are those of equal wheels, from the acceleration: a linear track does
not explain the motion of stones between impacts, so that forces that differ from wheel to wheel
fit it without being true.

A void reduces the sum of squares by more than {SEEN:g} if it is recognised; here it is reduced by
{", ".join(voids)}. A void is only seen as a loss of stiffness: with 1 mm, {soft:.0f} instead of
{sound:.0f} MN/m.
"""


def part_jenkins(n):
    rows = []
    for speed in VEES:
        for name, factor in DAMPINGS.items():
            run = f"vee_{speed:g}_{name}"
            rows.append((f"{speed:g}", f"{factor:g}", *(f"{n(run, quantity):.0f}" for quantity in (
                "largest force", "P1", "largest force below 150 Hz", "P2"))))
    return heading("Jenkins' formulas") + f"""
A V of 20 mrad in all, without the stiffer rail; forces in kN. P1 and P2 are the formulas of Jenkins
and others (1974) with the values of the deck; the rail that moves with the contact in P1 is taken
as 0.4 m.

{table(["speed, m/s", "ballast damping over that of the deck", "largest force", "P1",
        "below 150 Hz", "P2"], rows)}
P2 treats damping as small: its dynamic part decreases in proportion to the damper, here to
{100 * left(n):.0f} % of that with a tenth of the damping. A strong damper carries load itself. With
a tenth of the damping P2 differs from the computed force below 150 Hz by at most {off_p2(n):.0f} %.
P1 is {min(off_p1(n)):.0f} to {max(off_p1(n)):.0f} % smaller than the largest computed force; it
depends on the assumed 0.4 m.
"""


def off_p1(n):
    runs = [f"vee_{speed:g}_{name}" for speed in VEES for name in DAMPINGS]
    return [100 * (1 - n(run, "P1") / n(run, "largest force")) for run in runs]


def off_p2(n):
    runs = [f"vee_{speed:g}_tenth" for speed in VEES]
    return max(100 * abs(n(run, "P2") / n(run, "largest force below 150 Hz") - 1) for run in runs)


def left(n):
    strong, weak = (n(f"vee_{VEES[0]:g}_{name}", "P2")
                    - n(f"vee_{VEES[0]:g}_{name}", "static force") for name in DAMPINGS)
    return strong / weak


def part_missing():
    return heading("What is left out") + """
- Measured accelerations and scanned rails are not published: nothing here shows that the chain
  works with the faults of real sensors, other than those tested in docs/monitoring.md, or with the
  wear of real crossings.
- The path of a wheel does not depend on its lateral motion, and all wheels of a run have the same
  profile.
- Two rails with an asymmetric panel: Green's functions are available for both rails, but the study
  uses one.
- Green's functions of the coupled model; there the chain uses those of a track on springs.
- Months of passages: trends are tested on made-up tables only.
"""


def figures(n, lines, folder):
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
    for label, curve in lines.of("scanned_surface").items():
        found = label.endswith("identified")
        if not found and "60E" not in label.split(",")[0].split():
            continue  # the truth is that of the other design
        surface.plot(*curve, "-" if found else "k:", lw=1, label=label)
    paths.set_ylabel("path of the wheel (mm)")
    surface.set_ylabel("running surface, S1002 (mm)")
    surface.set_xlabel("x (m); sensor at 18 m")
    for panel in (paths, surface):
        panel.legend(fontsize=7)
        panel.grid(alpha=0.3)
    save(figure, folder / "scanned.png")


def draw_stones(lines, folder):
    curves = lines.of("stones")
    cases = [case for case in stones.CASES if f"{case}, true, mm" in curves]
    figure, panels = plt.subplots(len(cases), 1, sharex=True, figsize=(8, 1.6 * len(cases)),
                                  constrained_layout=True)
    for panel, case in zip(np.atleast_1d(panels), cases):
        panel.plot(*curves[f"{case}, true, mm"], lw=1, color=COLOURS[1], label="true")
        panel.plot(*curves[f"{case}, reconstructed, mm"], "--", lw=1, color=COLOURS[0],
                   label="reconstructed")
        panel.set_title(case, fontsize=9)
        panel.set_ylabel("mm")
        panel.grid(alpha=0.3)
    np.atleast_1d(panels)[0].legend(fontsize=8)
    np.atleast_1d(panels)[-1].set_xlabel("time (s)")
    save(figure, folder / "stones.png")
