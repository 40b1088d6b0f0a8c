"""Stress paths and rotation of the principal stress: regions of stones, points of a ground."""
import collections.abc

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from trackbed_post import figure_csv, measures, read, write
from trackbed_post.bed_figures import needs
from trackbed_post.bed_histories import time_in_passage
from trackbed_post.panels import LINES, curve

# Of the largest t = (s1 - s3)/2: below it the direction of an almost isotropic stress follows from
# small disturbances.
FAINT = 0.1
STARTS = (9, 6, 3.5)  # points, of the marks of starts, which may be at one place


def of_regions(run: read.Results) -> dict[str, np.ndarray]:
    """Name of each region -> mean over its cells of the stress, Pa, [time, xx yy zz xy xz yz]."""
    return {name: region["stress"].values.mean(axis=1) for name, region in run.regions.items()}


def of_ground(run: read.Results) -> dict[str, np.ndarray]:
    """Name of each sensor in the ground -> static stress and its change, as of `of_regions`; of a
    track on a ground, which has no weight, the change alone. Earlier results of beds have no static
    stress: no path can be drawn from them."""
    words = "ground, change only" if run.deck.get("model") == "track_on_ground" else "ground"
    return {f"{name} ({words})": sensor["stress_static"].values + sensor["stress"].values
            for name, sensor in run.sensors.items() if "stress_static" in sensor}


def of_run(run: read.Results) -> dict[str, np.ndarray]:
    return of_regions(run) | of_ground(run)


def unbroken(angle: np.ndarray) -> np.ndarray:
    """Angles between -90 and 90 degrees without the jumps from one end to the other."""
    jumps = np.abs(np.diff(angle, prepend=angle[:1])) > 90
    return np.where(jumps, np.nan, angle)


def direction(stress: np.ndarray) -> np.ndarray:
    """Inclination, degrees, of the largest compression in the plane of x and z; nan where t in this
    plane is less than FAINT of its largest value."""
    shear = measures.invariants(stress, plane=True)[1]
    angle = unbroken(np.degrees(measures.principal_direction(stress)))
    return np.where(shear < FAINT * np.nanmax(shear, initial=0), np.nan, angle)


def draw(runs: collections.abc.Sequence[read.Results]) -> Figure:
    """In the passage: deviatoric over mean stress, and the direction of the largest compression."""
    found = [of_run(run) for run in runs]
    needs(all(found), "the results contain neither regions nor sensors in the ground")
    plane = runs[0].deck.get("dimension") == "plane"
    figure, (path, turn) = plt.subplots(1, 2, figsize=(11, 5.4))
    for run, stresses, style in zip(runs, found, LINES):
        rows, time, label = time_in_passage(run)
        for number, (name, stress) in enumerate(stresses.items()):
            mean, deviator = measures.invariants(stress[rows], plane)
            text = f"{run.name}: {name}"
            look = curve(number, len(time))
            path.plot(mean / 1e3, deviator / 1e3, style, lw=0.8, label=text, **look)
            start, = path.plot(mean[0] / 1e3, deviator[0] / 1e3, look["marker"],
                               color=look["color"], ms=STARTS[number % len(STARTS)])
            figure_csv.name(start, f"{text}, start")
            turn.plot(time, direction(stress[rows]), style, lw=0.8, label=text, **look)
    path.set_xlabel("s = (s1 + s3)/2 (kPa)" if plane else "mean compression p (kPa)")
    path.set_ylabel("t = (s1 - s3)/2 (kPa)" if plane else "deviatoric stress q (kPa)")
    path.set_title("Stress paths (filled: start)", fontsize=10)
    turn.set_xlabel(label)
    turn.set_ylabel("major principal stress in the plane of x and z:\ninclination from the "
                    "vertical, positive towards +x (degrees)")
    turn.set_xlim(left=0)
    turn.set_ylim(-90, 90)
    turn.set_title("Rotation of the principal stress (not shown where t in this\nplane is below "
                   f"{100 * FAINT:g} % of its largest value in the passage)", fontsize=10)
    for panel in (path, turn):
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    figure.tight_layout(rect=(0, write.origin_height(figure), 1, 1))
    return figure
