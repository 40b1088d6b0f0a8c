"""The command `trajectory`: paths of wheels over a scanned rail, as irregularities of decks."""
import dataclasses
import re

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import figure_csv, panels, read
from trackbed_post.settlement.command import rows_as_csv
from trackbed_post.trajectory import contact, profiles, scan

SECTIONS = 10e-3, 1e-3  # m along and across, of the sections written
SHOWN = 7               # sections drawn


@dataclasses.dataclass(frozen=True)
class Choices:
    """Wheels (words of profiles.of), y of their tread data, m; `side`: 1 if their field side is at
    larger y, -1 otherwise; `radius`, m; `unit` of an STL file, m; `marks`: a file, or None;
    `origin`: x of the scan's origin in the deck, m; `trailing`: trains run to smaller x of the
    scan."""
    wheels: tuple = ("s1002",)
    laterals: tuple = (0.0,)
    side: int = 1
    radius: float = 0.46
    unit: float = 1e-3
    marks: object = None
    origin: float = 0.0
    trailing: bool = False


def prepared(path, choices):
    """(grid of the scan, its missing places, remarks on what was done)."""
    points, remarks = scan.load(path, choices.unit), []
    if choices.marks:
        points, remains, overturned = scan.turned(points, *scan.marks(choices.marks))
        remarks.append(f"turned into the frame of the track; the marks differ by "
                       f"{1e3 * remains:.3g} mm (root mean square)")
        if overturned:
            remarks.append("the marks turn z of the scan downwards: do the sections show the heads "
                           "of rails, or is the scan mirrored?")
    kept = scan.cleaned(points)
    remarks.append(f"{path.name}: {len(points)} points, of which {len(points) - len(kept)} were "
                   "left out as outliers")
    grid = scan.gridded(kept)
    remarks.append(f"grid of {len(grid.x)} x {len(grid.y)} places; nothing is known further than "
                   f"{1e3 * scan.hole_of(kept):.2g} mm from the next point")
    even = scan.smoothed(grid)
    return even, scan.missing(even), remarks


def table_of(paths, choices):
    """Values of each path, as text; x in the deck."""
    sign = -1 if choices.trailing else 1
    lines = [f"{'wheel':32} {'lowest, mm':>12} {'dip, mrad':>12} {'at x, m':>12} "
             f"{'contact jumps at x, m':>22}"]
    for path in paths:
        angle, x = path.dip()
        lines.append(f"{path.name:32} {1e3 * path.irregularity().min():12.3f} {1e3 * angle:12.2f} "
                     f"{choices.origin + sign * x:12.3f} "
                     f"{choices.origin + sign * path.transition():22.3f}")
    return "\n".join(lines) + "\n"


def draw(grid, paths, choices):
    figure, (section, height, place) = plt.subplots(3, 1, figsize=(9, 10), layout="constrained")
    rows = np.linspace(0, len(grid.x) - 1, SHOWN).astype(int)
    for row, shade in zip(rows, np.linspace(0.1, 0.9, SHOWN)):
        section.plot(1e3 * grid.y, 1e3 * grid.z[row], lw=1, color=plt.cm.viridis(shade),
                     label=f"x = {1e3 * grid.x[row]:.0f} mm")
    for number, path in enumerate(paths):
        sign = -1 if choices.trailing else 1
        x = choices.origin + sign * path.x
        look = panels.curve(number, len(x))
        height.plot(x, 1e3 * path.irregularity(), label=path.name, **look)
        line, = place.plot(x, 1e3 * path.contact, **look)
        figure_csv.name(line, path.name)
    section.set(xlabel="y across the scan (mm)", ylabel="height (mm)")
    height.set(ylabel="path of the wheel (mm)", xlabel="x along the track, trains run to larger x "
               "(m)")
    place.set(xlabel="x along the track (m)", ylabel="y of the contact (mm)")
    for panel in (section, height, place):
        panel.grid(alpha=0.3)
    for panel in (section, height):
        panel.legend(fontsize=7)
    return figure


def sections_as_csv(grid):
    steps = [max(int(round(wanted / (axis[1] - axis[0]))), 1)
             for wanted, axis in zip(SECTIONS, (grid.x, grid.y))]
    x, y, z = grid.x[::steps[0]], grid.y[::steps[1]], grid.z[::steps[0], ::steps[1]]
    places = np.argwhere(np.isfinite(z))
    return rows_as_csv(("x_m", "y_m", "z_m"), [(float(x[i]), float(y[j]), float(z[i, j]))
                                               for i, j in places])


def name_of_file(path):
    """Of a path, without signs: -3 mm is minus_3_mm."""
    return "irregularity_" + re.sub(
        r"[^\w-]+", "_", re.sub(r"-(?=\d)", "minus_", path.name)) + ".csv"


def trajectory(path, folder, choices):
    """Irregularities, sections, a table and a picture of a scan into a write.Folder."""
    wheels = [profiles.of(word) for word in choices.wheels]
    grid, missing, remarks = prepared(path, choices)
    several, paths = len(choices.laterals) > 1, []
    for wheel in wheels:
        for y in choices.laterals:
            one = contact.roll(grid, wheel, y, choices.radius, choices.side,
                               f"{wheel.name} at {1e3 * y:g} mm" if several else wheel.name)
            paths.append(one)
            remarks += contact.warnings(one, grid, missing, wheel, y, choices.side)
    if len(set(map(name_of_file, paths))) < len(paths):
        raise read.Unreadable("two wheels have the same name and lateral position: give each once")
    for one in paths:
        rows = zip(*one.rows(choices.origin, choices.trailing))
        folder.file(name_of_file(one), rows_as_csv(
            ("x_m", "z_m"), [(round(float(x), 6), round(float(z), 8) + 0.0) for x, z in rows]))
    folder.file("sections.csv", sections_as_csv(grid))
    folder.remarks += remarks
    folder.table("trajectory.txt", table_of(paths, choices))
    folder.picture("trajectory", draw(grid, paths, choices))
