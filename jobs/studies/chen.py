"""Study chen: five sleepers on ballast that breaks and sub-ballast (inputs/chen/slice.toml), loaded
by carriages of several axle loads and speeds. What is measured in its runs; the runs are in
chen_runs.py, the targets in chen_targets.py, the document in chen_document.py.
"""
import numpy as np

from . import chen_runs, chen_targets
from .chen_runs import (AREA, AROUND, CARRIAGE, CELL, COMPONENTS, DECK, DEPTHS, DRAWN, EDGE,
                        GAP, HEIGHT, LEAD, MIDDLE, SINE, SUB_BALLAST, TOTAL)
from .study import summary

from trackbed_post import measures, read  # noqa: I001 (found by .study)

runs, prepare, targets = chen_runs.runs, chen_runs.prepare, chen_targets.targets


def measure(form, folder, numbers, lines):
    for run in runs(form, 1):
        place = folder / run.name
        if run.name == "haversine":
            measure_path(run.name, Passage(read.results(place)), numbers, lines)
        elif not run.name.startswith("bed"):
            found = Passage(read.results(place))
            measure_passage(run.name, found, numbers, lines)
            bed_of = read.results(folder / f"bed_{found.run.deck['bed']['seed']}")
            measure_breakage(run.name, found, bed_of, numbers, lines)
        numbers.put(run.name, "wall_time", float(summary(place, "wall_time_s")), "s")


class Passage:
    """Histories of the train's stage: time from its begin, s; stress, compression positive, of
    cells as [time, z, x], Pa; levels of the sleepers, positive down from the begin, mm."""

    def __init__(self, run):
        rows = run.passage()
        self.run, self.load = run, run.deck["load"]
        self.time = run.time[rows] - run.time[rows][0]
        section = run.deck["region"][0]
        nx, _, nz = map(int, section["cells"])
        self.cells = {name: of.values[rows].reshape((-1, nz, nx) + of.values.shape[2:])
                      for name, of in run.regions["section"].items()}
        self.stress = -self.cells["stress"]
        self.x, self.z = (np.linspace(*section[axis], 2 * n + 1)[1::2]
                          for axis, n in (("x", nx), ("z", nz)))
        self.sleepers = run.sleepers_x
        z = run.sleeper["displacement"].values[rows]
        self.down = 1e3 * (z[0] - z)
        load = -run.sleeper["seat_force"].values[rows]  # stored up positive
        self.seat = load - load.min()
        self.floor = -run.walls["floor"]["force"].values[rows][:, 2]

    def when(self, x, axle):
        """Time at which the place `axle` of the train, m behind its first axle, is at x."""
        return (x + axle - self.load["start"]) / self.load["speed"]

    def at(self, times, values):
        """Values of histories at times, linear between rows."""
        flat = values.reshape(len(values), -1)
        found = [np.interp(times, self.time, column) for column in flat.T]
        return np.array(found).T.reshape((len(times), *values.shape[1:]))

    def wheels(self, x):
        """Times at which the front wheel of each bogie is at x."""
        return self.when(x, np.array(self.load["axles"][::2]))

    def unloaded(self, x):
        """Times at which x is between the bogies of a carriage, for each carriage."""
        carriages = len(self.load["axles"]) // 4
        return self.when(x, CARRIAGE * np.arange(carriages) + (CARRIAGE - GAP) / 2)

    def peak(self, values, x, axle):
        """Time of the peak of a history as the axle passes x: that of the parabola through its top,
        as the flanks of the two peaks of a bogie differ."""
        time = self.time - self.when(x, axle)
        near = np.abs(time) * self.load["speed"] < LEAD
        top = near & (values > 0.8 * values[near].max())
        curve, slope, _ = np.polyfit(time[top], values[top], 2)
        return self.when(x, axle) - slope / (2 * curve)

    def below(self, x, depth, component):
        """History of a component of stress at a depth below the sleepers, in cells that contain x
        or touch it."""
        near = np.abs(self.x - x) < CELL / 2 + 1e-9
        column = self.stress[:, :, near, component].mean(axis=2)
        return self.at_height(column, HEIGHT - depth)

    def at_height(self, columns, z):
        """Values of [time, z] at a height, linear between the centres of cells."""
        return np.array([np.interp(z, self.z, row) for row in columns])


def measure_passage(name, found, numbers, lines):
    """Settlements, mm; breakage; stresses, kPa; rotation, degrees; speeds, mm/s."""
    for k, value in enumerate(found.down[-1]):
        numbers.put(name, f"settlement, sleeper {k + 1}", value, "mm")
    middle = found.sleepers[MIDDLE]
    # "carriage k": between its bogies, after 2 k - 1 bogies of the train.
    for k, down in enumerate(found.at(found.unloaded(middle), found.down)):
        numbers.put(name, f"settlement, sleeper 3, carriage {k + 1}", down[MIDDLE], "mm")
    if name in DRAWN:
        for k, down in enumerate(found.down.T):
            lines.put(f"settlement {name}", f"sleeper {k + 1}", found.time[::2], down[::2])
    measure_loads(name, found, numbers)
    measure_stresses(name, found, numbers, lines)
    measure_rotation(name, found, numbers, lines)
    measure_stones(name, found, numbers)


def ballast(run, stage):
    """Rows of opening and mass of stones and fines without sub-ballast."""
    rows = measures.sieved_with_fines(run, stage)
    low, high = (1e-3 * size for size in run.deck["bed"]["layer"][0]["sieve"])
    return rows[(rows[:, 0] < low) | (rows[:, 0] > high)]


def measure_breakage(name, found, bed_of, numbers, lines):
    """Corners that broke off in a run on a bed."""
    run = found.run
    rows = run.breaks["train"]
    place, size = rows[:, read.BREAK["x"]], rows[:, read.BREAK["diameter"]]
    _, below, edges = measures.breaks_by_sleeper(run, "train")
    numbers.put(name, "corners broken", len(rows), "-")
    numbers.put(name, "corners broken below sleepers", below.sum(), "-")
    numbers.put(name, "corners broken nearer to edges", edges.sum(), "-")
    for k, count in enumerate(below):
        numbers.put(name, f"corners broken, sleeper {k + 1}", count, "-")
    time = rows[:, read.BREAK["time"]] - run.time[run.passage()][0]
    end = found.when(found.sleepers[-1], found.load["axles"][1] + LEAD)
    numbers.put(name, "corners broken by the first bogie", (time < end).sum(), "-")
    counts = np.arange(1, len(time) + 1)
    if run.deck["load"]["speed"] == DECK["load"]["speed"]:
        lines.put("breakage", name, time[::5], counts[::5])
    numbers.put(name, "mass broken", rows[:, read.BREAK["mass"]].sum(), "kg")
    numbers.put(name, "smallest fragment", 1e3 * size.min(), "mm")
    numbers.put(name, "largest fragment", 1e3 * size.max(), "mm")
    openings = np.linspace(measures.FINEST, 1e-3 * max(DECK["bed"]["sieve"]), 100)
    index = measures.breakage_index(openings, *(measures.passing(ballast(of, stage), openings)
                                                for of, stage in ((bed_of, "sleepers"),
                                                                  (run, "train"))))
    numbers.put(name, "BBI", index, "-")
    if name in DRAWN:
        lines.put("breaks", name, place, rows[:, read.BREAK["z"]])


def measure_loads(name, found, numbers):
    """Largest pressure below sleeper 3, kPa, and delay from sleeper to sleeper, ms."""
    numbers.put(name, "largest load", 1e-3 * found.seat[:, MIDDLE].max() / AREA, "kPa")
    at = [found.peak(load, x, 0) for load, x in zip(found.seat.T, found.sleepers)]
    numbers.put(name, "delay between sleepers", 1e3 * np.polyfit(range(len(at)), at, 1)[0], "ms")


def measure_stresses(name, found, numbers, lines):
    middle = found.sleepers[MIDDLE]
    wheels = found.wheels(middle)
    for depth in DEPTHS:
        for title, component in COMPONENTS.items():
            history = found.below(middle, depth, component)
            if name == DRAWN[-1]:
                lines.put(title, f"z/h = {depth / TOTAL:.3f}", found.time, 1e-3 * history)
            if title != "shear":
                peak = np.mean(found.at(wheels, history))
                numbers.put(name, f"{title} at {depth} m", 1e-3 * peak, "kPa")
    shear = [[np.ptp(found.below(middle + side * EDGE, depth, COMPONENTS["shear"]))
              for side in (-1, 1)] for depth in DEPTHS]
    for depth, values in zip(DEPTHS, shear):
        numbers.put(name, f"range of shear at {depth} m", 1e-3 * np.mean(values), "kPa")
    # Two axles of a bogie: the time between their peaks gives the frequency.
    shallow = found.below(middle, DEPTHS[0], COMPONENTS["vertical"])
    peaks = np.array([found.peak(shallow, middle, axle) for axle in found.load["axles"]])
    numbers.put(name, "frequency of the M", 1 / np.mean(peaks[1::2] - peaks[::2]), "Hz")
    # At the moments at which a front wheel is above sleeper 3.
    fields = found.at(wheels, found.stress)
    low = np.argsort(np.abs(found.z - SUB_BALLAST))[:2]  # the rows of cells beside the interface
    numbers.put(name, "ballast on sub-ballast",
                1e-3 * fields[:, low, :, COMPONENTS["vertical"]].mean(), "kPa")
    area = np.ptp(DECK["bed"]["x"]) * np.ptp(DECK["bed"]["y"])
    numbers.put(name, "sub-ballast on the base", 1e-3 * found.at(wheels, found.floor).mean() / area,
                "kPa")
    numbers.put(name, "shear antisymmetric", antisymmetric(found, fields), "-")


def antisymmetric(found, fields):
    """Part of the square of shear that changes its sign about the middle of sleeper 3, within a
    sleeper spacing and between the deepest and the shallowest of DEPTHS."""
    near = np.abs(found.x - found.sleepers[MIDDLE]) < DECK["sleepers"]["spacing"] / 2
    deep = (found.z > HEIGHT - DEPTHS[-1]) & (found.z < HEIGHT - DEPTHS[0])
    shear = fields[..., COMPONENTS["shear"]][:, deep][:, :, near]
    odd, even = (shear - shear[..., ::-1]) / 2, (shear + shear[..., ::-1]) / 2
    return (odd**2).sum() / ((odd**2).sum() + (even**2).sum())


def measure_rotation(name, found, numbers, lines):
    """Rotation of the principal stress, degrees, while the last bogie passes sleeper 3 and the
    deviator exceeds a fifth of its largest value."""
    middle = found.sleepers[MIDDLE]
    begin, end = (found.when(middle, axle) for axle in
                  (found.load["axles"][-2] - AROUND, found.load["axles"][-1] + AROUND))
    numbers.put(name, "rotation, length before and behind the bogie", AROUND, "m")
    rows = (found.time >= begin) & (found.time <= end)
    for depth in DEPTHS:
        for title, x in (("centre", middle), ("left edge", middle - EDGE),
                         ("right edge", middle + EDGE)):
            parts = [found.below(x, depth, COMPONENTS[of])[rows]
                     for of in ("vertical", "horizontal", "shear")]
            deviator, shear = parts[0] - parts[1], 2 * parts[2]
            angle = np.degrees(np.arctan2(shear, deviator) / 2)
            loaded = deviator > 0.2 * deviator.max()
            numbers.put(name, f"rotation, {title}, {depth} m", np.ptp(angle[loaded]), "degrees")
            numbers.put(name, f"angle, {title}, {depth} m", angle[np.argmax(deviator)], "degrees")
            if name == DRAWN[-1]:
                lines.put(f"path, {depth} m", title, 1e-3 * deviator, 1e-3 * shear)


def measure_path(name, found, numbers, lines):
    """Changes of stress, kPa, below sleeper 3 in the last of the haversines that pass from sleeper
    to sleeper: half a cycle before and behind the last peak of its load."""
    middle, load = found.sleepers[MIDDLE], found.seat[:, MIDDLE]
    peak = found.time[np.flatnonzero(load > 0.98 * load.max())[-1]]
    rows = np.abs(found.time - peak) < 0.5 / SINE
    vertical, horizontal, shear = (1e-3 * found.below(middle, DEPTHS[0], COMPONENTS[of])[rows]
                                   for of in ("vertical", "horizontal", "shear"))
    deviator, shear = vertical - horizontal, shear - shear[0]
    deviator = deviator - deviator[0]
    time = found.time[rows] - found.time[rows][0]
    lines.put("sine, time", "vertical - horizontal", time, deviator)
    lines.put("sine, time", "shear", time, shear)
    lines.put("sine, path", "below sleeper 3", deviator, 2 * shear)
    path = chen_targets.path_of(lines)
    for title, value in (("largest deviator", path.deviator), ("shear then", path.then),
                         ("largest shear before", path.before),
                         ("largest shear after", path.after)):
        numbers.put(name, title, value, "kPa")


def measure_stones(name, found, numbers):
    """Speeds at the moments at which a front wheel is above sleeper 3; contacts while the first
    wheel is above sleepers 1, 3 and 5."""
    wheels = found.wheels(found.sleepers[MIDDLE])
    counts = found.at(wheels, found.cells["stones"])
    speed = found.at(wheels, found.cells["speed"])
    numbers.put(name, "mean speed", 1e3 * (speed * counts).sum() / counts.sum(), "mm/s")
    above = found.z > SUB_BALLAST
    stones, speed = counts[:, above], speed[:, above]
    numbers.put(name, "mean speed of ballast", 1e3 * (speed * stones).sum() / stones.sum(), "mm/s")
    numbers.put(name, "stones of ballast", stones.sum() / len(wheels), "-")
    numbers.put(name, "spheres of sub-ballast", (counts.sum() - stones.sum()) / len(wheels), "-")
    moments = found.when(found.sleepers[::2], 0)
    contacts = found.at(moments, found.cells["contacts"])
    force = found.at(moments, found.cells["contact_force"])
    for k, (count, mean) in enumerate(zip(contacts, force)):
        numbers.put(name, f"contacts, wheel at sleeper {2 * k + 1}", count.sum(), "-")
        numbers.put(name, f"mean contact force, wheel at sleeper {2 * k + 1}",
                    (mean * count).sum() / count.sum(), "N")
