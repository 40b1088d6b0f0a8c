"""The command `trackbed_post forces`: wheel forces and irregularity of one passage."""
import csv
import io

import matplotlib.pyplot as plt
import numpy as np
import scipy.signal

from trackbed_post import measured, read
from trackbed_post.monitor import displacement, greens, inverse

NEAR = 0.02  # of the ratio of displacements to 1 beyond which loads or track are other ones
RATIO = 10   # largest denominator when the rate is changed


def forces(signal_name, folder, kernel_path, speed, **choices):
    """Writes tables and a picture of a passage into a write.Folder."""
    kernel, signal = greens.load(kernel_path), measured.load(signal_name)
    if signal.unit != "m/s2":
        raise read.Unreadable(f"the unit is {signal.unit}, not that of an acceleration")
    folder.remarks += signal.remarks
    values, doubtful = at_rate(signal, kernel.rate)
    found, came, moved = inverse.evaluate(values, kernel, speed, doubtful, **choices)
    folder.remarks += remarks_of(came, moved)
    wheels = range(len(found.force))
    folder.file("forces.csv", table(
        ["x_m", *(f"{what}_{wheel + 1}_kN" for wheel in wheels for what in ("force", "deviation"))],
        [found.x, *(1e-3 * part[wheel] for wheel in wheels
                    for part in (found.force, found.deviation))]))
    rows = [("arrival of the first wheel", "m", came.start, came.deviation)]
    for wheel in wheels:
        size, deviation, place = found.peak(wheel)
        rows += [(f"largest force of wheel {wheel + 1}", "kN", 1e-3 * size, 1e-3 * deviation),
                 (f"its place, wheel {wheel + 1}", "m", place, came.deviation)]
    surface = None
    if kernel.moving:
        surface = inverse.irregularity(found, kernel, speed, choices.get("first", 0))
        folder.file("irregularity.csv", table(
            ["x_m", "height_mm", "deviation_mm", "wheel_mm", "rail_mm"],
            [surface.x, *(1e3 * part for part in (surface.height, surface.deviation, surface.wheel,
                                                  surface.rail))]))
        depth, deviation = surface.depth
        rows += [("depth of the irregularity", "mm", 1e3 * depth, 1e3 * deviation)]
    lines = [f"{name:32} {value:10.4g} {unit:3} standard deviation {deviation:.2g}\n"
             for name, unit, value, deviation in rows]
    folder.table("forces.txt", "".join(lines))
    folder.picture("forces", picture(found, surface, kernel.sensor))


def at_rate(signal, rate):
    """(values, doubtful) of a signal at another rate, behind a low-pass filter."""
    doubtful = np.zeros(len(signal.values), bool) if signal.doubtful is None else signal.doubtful
    if abs(signal.rate - rate) < 1e-6 * rate:
        return signal.values, doubtful
    for down in range(1, RATIO + 1):
        up = round(down * rate / signal.rate)
        if 0 < up <= RATIO and abs(up * signal.rate - down * rate) < 1e-6 * down * rate:
            values = scipy.signal.resample_poly(signal.values, up, down, padtype="line")
            at = np.minimum(np.arange(len(values)) * down // up, len(doubtful) - 1)
            return values, doubtful[at]
    raise read.Unreadable(f"{signal.rate:g} samples per second cannot be changed to the {rate:g} of "
                          "the Green's functions: call `trackbed kernel` with --rate")


def remarks_of(came, moved):
    remarks = []
    if moved.reversed:
        remarks.append("the sensor is upside down; its signal was reversed")
    if moved.misfit > displacement.TRUSTED:
        remarks.append(f"the misfit of {moved.misfit:.3g} is above {displacement.TRUSTED:g}: the "
                       "signal has a fault, and so have the forces")
    if abs(came.ratio - 1) > max(NEAR, 2 * moved.deviation.max() / moved.peak[0]):
        remarks.append(f"the sleeper is displaced {came.ratio:.3g} times as far as under the static "
                       "forces on the track of the Green's functions: axle loads or ballast are "
                       "other ones")
    return remarks


def table(names, columns):
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(names)
    rows.writerows([f"{value:.6g}" for value in row] for row in zip(*columns))
    return text.getvalue()


def picture(found, surface, sensor):
    """Forces, irregularity and choice of the regularisation."""
    figure, panels = plt.subplots(3 if surface else 2, 1, figsize=(10, 9 if surface else 6),
                                  constrained_layout=True)
    banded(panels[0], found.x, 1e-3 * found.force, 1e-3 * found.deviation,
           [f"wheel {wheel + 1}" for wheel in range(len(found.force))])
    panels[0].set_ylabel("wheel force (kN)")
    if surface:
        banded(panels[1], surface.x, 1e3 * surface.height[None], 1e3 * surface.deviation[None],
               ["running surface"])
        panels[1].plot(surface.x, 1e3 * surface.rail, lw=0.8, color="C1", label="rail below wheel")
        panels[1].legend(fontsize=8)
        panels[1].set_ylabel("height (mm)")
    for panel in panels[:-1]:
        panel.set_xlabel("x (m)")
        panel.axvline(sensor, color="0.6", lw=0.8, ls=":")
    strengths, residuals, _, validation = found.curves
    panels[-1].loglog(strengths, residuals, label="residual")
    panels[-1].loglog(strengths, np.sqrt(validation), label="root of the cross-validation")
    panels[-1].axvline(found.strength, color="0.4", lw=0.8)
    panels[-1].set_xlabel("strength of the regularisation")
    panels[-1].legend(fontsize=8)
    panels[0].set_title("Wheel forces by Green's functions; bands: standard deviation; dotted: "
                        "sensor", fontsize=10)
    for panel in panels:
        panel.grid(alpha=0.3)
    return figure


def banded(panel, x, values, deviations, labels):
    for number, (value, deviation, label) in enumerate(zip(values, deviations, labels)):
        line, = panel.plot(x, value, lw=1, label=label, color=f"C{2 * number}")
        panel.fill_between(x, value - deviation, value + deviation, alpha=0.25,
                           color=line.get_color())
    panel.legend(fontsize=8)
