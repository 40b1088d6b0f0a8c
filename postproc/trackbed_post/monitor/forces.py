"""The command `trackbed_post forces`: wheel forces and irregularity of one passage."""
import csv
import io

import matplotlib.pyplot as plt
import numpy as np
import scipy.signal

from trackbed_post import measured, read
from trackbed_post.monitor import displacement, greens, inverse

NEAR = 0.05  # of the ratio of displacements to 1: a dip changes it by up to 3 %
APART = 2    # samples, largest distance of forces in a kernel
RATIO = 10   # largest denominator when the rate is changed


def forces(signal_name, folder, kernel_path, speed, **choices):
    """Writes tables and a picture of a passage into a write.Folder."""
    kernel, signal = greens.load(kernel_path), measured.acceleration(signal_name)
    if kernel.x[1] - kernel.x[0] > APART * speed / kernel.rate:
        raise read.Unreadable(f"forces are {100 * (kernel.x[1] - kernel.x[0]):.3g} cm apart in the "
                              f"Green's functions, but a sample is {100 * speed / kernel.rate:.3g} "
                              "cm: call `trackbed kernel` with a smaller --apart")
    values, doubtful = at_rate(signal, kernel.rate)
    found, came, moved = inverse.evaluate(values, kernel, speed, doubtful, **choices)
    folder.remarks += [*signal.remarks, *faults_of(moved), *remarks_of(came, moved)]
    surface = None
    try:
        surface = inverse.irregularity(found, came.kernel, speed, choices.get("first", 0))
    except read.Unreadable as why:
        folder.remarks.append(f"no irregularity: {why}")
    write(folder, found, came, surface, kernel.sensor)


def write(folder, found, came, surface, sensor):
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
    if surface:
        folder.file("irregularity.csv", table(
            ["x_m", "height_mm", "deviation_mm", "wheel_mm", "rail_mm"],
            [surface.x, *(1e3 * part for part in (surface.height, surface.deviation, surface.wheel,
                                                  surface.rail))]))
        depth, deviation = surface.depth
        rows += [("depth of the irregularity", "mm", 1e3 * depth, 1e3 * deviation)]
    lines = [f"{name:32} {value:10.4g} {unit:3} standard deviation {deviation:.2g}\n"
             for name, unit, value, deviation in rows]
    folder.table("forces.txt", "".join(lines))
    folder.picture("forces", picture(found, surface, sensor))


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
    even = signal.rate / np.ceil(signal.rate / rate)
    raise read.Unreadable(f"{signal.rate:g} samples per second cannot be changed to the {rate:g} "
                          f"of the Green's functions: call `trackbed kernel` with --rate {even:g}")


def faults_of(moved):
    """Remarks on a Reconstruction."""
    remarks = []
    if moved.reversed:
        remarks.append("the sensor is upside down; its signal was reversed")
    if moved.misfit > displacement.TRUSTED:
        remarks.append(f"the misfit of {moved.misfit:.3g} is above {displacement.TRUSTED:g}: the "
                       "signal has a fault, and so have the results")
    return remarks


def remarks_of(came, moved):
    """Of a train in another order, and of a displacement that is not that of the kernel's track and
    train."""
    remarks = []
    if came.order < 0:
        remarks.append("the wheels pass in the order opposite to that of the deck: axles are "
                       "counted as they pass, x is that of a train towards "
                       f"{came.kernel.towards} x")
    if abs(came.ratio - 1) <= max(NEAR, 2 * moved.deviation.max() / moved.peak[0]):
        return remarks
    return [*remarks,
            f"the sleeper is displaced {came.ratio:.3g} times as far as under the static forces on "
            "the track of the Green's functions: axle loads or ballast are other ones"]


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
