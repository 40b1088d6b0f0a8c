"""Quantities and curves of the runs of netirail: displacements downwards in mm, forces in kN."""
import dataclasses
import math

import h5py
import numpy as np

from .study import deck_of

from trackbed_post import transition  # noqa: I001 (found by .study)

PLANE = "track/netirail_2d.toml"
DECK = deck_of(PLANE)
LAYERS, BLOCKS = ({one["name"]: one for one in DECK["ground"][kind]} for kind in ("layer", "block"))
DEPTH = sum(layer["thickness"] for layer in LAYERS.values())  # m, of the ground
MIRROR = 83.4  # m, x of the track plus that of its mirror image
BRIDGE_ENDS, BACKFILL = 17.7, 6.0  # m, x of the track and of the ground where the bridge ends
NEAR, FAR = "14.7 m", "41 m"  # distances of the points from the bridge
SLEEPER, SPEED = DECK["track"]["sleeper_mass"], DECK["train"]["speed"]  # kg, m/s
WHEELBASE = 2.7  # m
BESIDE = (-4.5, 36)  # m, distances from the bridge at which measures are judged
BEHIND = (0, 36)  # m, of wheels: what the begin of the bridge does to their force has decayed
LATE = (36, 45)  # m, where the rail's largest displacement is uneven
ON_BRIDGE = (-3, 0)  # m
SEEDS = (deck_of("quickstart_cell.toml")["bed"]["seed"], 1, 2, 3, 4)  # packings of the stones
ZONES = {"bridge": (-6, 0), "0 to 7.2 m": (0, 7.2), "7.2 to 14 m": (7.2, 14),
         "14 to 25 m": (14, 25)}  # of sleepers; the second is glued in one variant
BINS = np.arange(-1, 0.1501, 0.05)  # mm, of histograms, upwards positive
THINNED = 5  # rows of the histories per point of a curve over time


@dataclasses.dataclass(frozen=True)
class Passage:
    """Histories and extremes of a run with a ground: displacements upwards in m, forces in N."""
    time: np.ndarray
    points: np.ndarray
    rail: np.ndarray
    sleeper: np.ndarray
    ground: np.ndarray
    seat: np.ndarray
    x: np.ndarray  # of `lowest`
    lowest: np.ndarray  # level of the rail
    wheel_x: np.ndarray
    force: np.ndarray

    @staticmethod
    def read(place):
        with h5py.File(place / "results.h5") as file:
            def history(path):
                return file[f"history/{path}"][()]
            order = np.argsort(np.argsort(history("rail/x")))  # sleepers ascend in x
            return Passage(
                history("rail/time"), history("rail/x"), history("rail/displacement"),
                history("sleeper/displacement")[:, order], history("ground/displacement")[:, order],
                history("sleeper/seat_force")[:, order], file["envelope/rail/x"][()],
                file["envelope/rail/displacement_min"][()], history("wheel/x"),
                history("wheel/force"))


def measure_ground(name, place, numbers, lines, figures, factor=None):
    """`figures`: kinds of curves that the document draws of this run. `factor`: mass of sleepers on
    embankment, for histograms whose zero is the ground without sleepers."""
    found = Passage.read(place)
    put_points(name, found, numbers)
    mirror = name.split("_")[1] == "back"
    distance, wheels = ((MIRROR - of if mirror else of) - BRIDGE_ENDS
                        for of in (found.x, found.wheel_x))
    behind = (wheels > BEHIND[0]) & (wheels < BEHIND[1])
    numbers.put(name, "range of wheel forces behind the bridge",
                1e-3 * np.ptp(found.force[behind]), "kN")
    down = -1e3 * found.lowest
    late = down[(distance > LATE[0]) & (distance < LATE[1])]
    numbers.put(name, "rail, mean of 36 to 45 m", late.mean(), "mm")
    numbers.put(name, "rail, range in 36 to 45 m", np.ptp(late), "mm")
    put_envelope(name, distance, down, BESIDE, numbers, lines if "envelope" in figures else None)
    for k, point in enumerate((NEAR, FAR)):
        rail = 1e3 * found.rail[:, k]
        if "histogram" in figures:
            put_histogram(f"histogram, {point}", name, rail, lines)
            numbers.put(name, f"rail, power up to the frequency of the axles, {point}",
                        100 * power_below(rail, found.time, SPEED / WHEELBASE), "%")
        if factor:
            put_histogram(f"histogram from the unloaded ground, {point}", name,
                          rail - own_weight(factor), lines)
        if "history" in figures:
            part = slice(None, None, THINNED)
            passed = found.time - found.points[k] / SPEED
            shown = (passed > -0.15) & (passed < 0.9)
            lines.put(f"rail over time, {point}", name, passed[shown][part], rail[shown][part])


def put_points(name, found, numbers):
    """Largest values at both points, rms and mean over the record."""
    for k, point in enumerate((NEAR, FAR)):
        for what, value in (("rail", -found.rail[:, k].min()),
                            ("rail to sleeper", (found.sleeper - found.rail)[:, k].max()),
                            ("sleeper", -found.sleeper[:, k].min()),
                            ("ground", -found.ground[:, k].min()),
                            ("rail rms", np.sqrt((found.rail[:, k]**2).mean())),
                            ("rail mean", -found.rail[:, k].mean())):
            numbers.put(name, f"{what}, {point}", 1e3 * value, "mm")
        numbers.put(name, f"seat force, {point}", 1e-3 * found.seat[:, k].max(), "kN")


def put_histogram(figure, name, values, lines):
    """Fraction of the record in each bin, %."""
    count, edges = np.histogram(values, BINS)
    lines.put(figure, name, (edges[:-1] + edges[1:]) / 2, 100 * count / len(values))


def moved(lines, figure, one, other):
    """%, of the record, that is in other bins of the histogram in run `other` than in run `one`."""
    found = lines.of(figure)
    return np.abs(np.subtract(found[one][1], found[other][1])).sum() / 2


def power_below(values, time, frequency):
    """Fraction of the power of the variation of a record up to a frequency, Hz."""
    power = np.abs(np.fft.rfft(values - values.mean()))**2
    return power[np.fft.rfftfreq(len(values), time[1] - time[0]) <= frequency].sum() / power.sum()


def of_packing(name, seed):
    """Name of a run on stones."""
    return name if seed == SEEDS[0] else f"{name}_{seed}"


def measure_stones(name, springs, folder, numbers, lines):
    """Of the last train, relative to the levels before it. `springs`: run with the same ground and
    springs instead of stones."""
    train = transition.train_of(folder / name)
    distance = train.run.sleepers_x - BACKFILL
    here = np.abs(distance - 14.7).argmin()
    rail, sleeper = 1e3 * train.rail_down(), 1e3 * train.sleeper_down()
    numbers.put(name, f"rail, {NEAR}", rail[here], "mm")
    numbers.put(name, f"sleeper, {NEAR}", sleeper[here], "mm")
    around = np.abs(distance - 14.7) < 3.1
    numbers.put(name, "sleeper, mean of 11 about 14.7 m", sleeper[around].mean(), "mm")
    numbers.put(name, "sleeper, least of them", sleeper[around].min(), "mm")
    numbers.put(name, "sleeper, most of them", sleeper[around].max(), "mm")
    ends = (-3, distance[slice(transition.ENDS, -transition.ENDS)][-1])
    put_envelope(name, distance, rail, ends, numbers, lines)
    put_on_bridge(name, "rail", distance, rail, numbers)
    put_on_bridge(name, "sleeper", distance, sleeper, numbers)
    lines.put("sleepers on stones", name, distance, sleeper)
    kept = 1e3 * train.settlement()
    for zone, (low, high) in ZONES.items():
        part = (distance > low) & (distance < high)
        numbers.put(name, f"sleeper, mean, {zone}", sleeper[part].mean(), "mm")
        numbers.put(name, f"settlement in the train, mean, {zone}", kept[part].mean(), "mm")
    measure_springs(name, springs, folder, ends, numbers, lines)


def measure_springs(name, springs, folder, window, numbers, lines):
    with h5py.File(folder / springs / "results.h5") as file:
        (x, rail), (sleepers_x, sleeper) = (
            (file[f"envelope/{of}/x"][()] - BRIDGE_ENDS,
             -1e3 * file[f"envelope/{of}/displacement_min"][()]) for of in ("rail", "sleeper"))
    numbers.put(name, "steepest change on springs", steepest(x, rail, window), "mm/m")
    put_on_bridge(name, "rail on springs", x, rail, numbers)
    put_on_bridge(name, "sleeper on springs", sleepers_x, sleeper, numbers)
    shown = (sleepers_x > -BACKFILL) & (sleepers_x < 26)
    lines.put("sleepers on springs", springs, sleepers_x[shown], sleeper[shown])


def put_on_bridge(name, what, distance, down, numbers):
    part = (distance > ON_BRIDGE[0]) & (distance < ON_BRIDGE[1])
    numbers.put(name, f"{what}, mean on the bridge", down[part].mean(), "mm")


def steepest(distance, down, window):
    """Steepest change of a displacement from place to place in a window of the distance, mm/m."""
    part = (distance > window[0]) & (distance < window[1])
    return np.abs(np.diff(down[part]) / np.diff(distance[part])).max()


def put_envelope(name, distance, down, window, numbers, lines=None):
    """The largest downward displacement of the rail over the distance from the bridge, m."""
    order = np.argsort(distance)
    distance, down = distance[order], down[order]
    numbers.put(name, "steepest change along the rail", steepest(distance, down, window), "mm/m")
    if lines:
        part = (distance > -10) & (distance < 45)
        lines.put("envelope", name, distance[part], down[part])


def own_weight(factor):
    """mm, by which sleepers of `factor` times the mass sink into a plane ground of embankment under
    their own weight: a uniform pressure on a layer that cannot expand along the track."""
    fill_of = LAYERS["embankment"]
    pressure = factor * SLEEPER / 2 * 9.81 / (DECK["track"]["spacing"] * DECK["thickness"])
    return 1e3 * pressure * DEPTH * (1 - fill_of["poisson"]**2) / fill_of["young"]


def resonance(numbers, factor):
    """Hz, of half a sleeper of `factor` times the mass between pad and ballast in series with a
    plane ground of embankment, whose stiffness is seat force over displacement."""
    run = "plane_same_width_fill_1"
    ground = 1e6 * numbers(run, f"seat force, {FAR}") / numbers(run, f"ground, {FAR}")  # kN, mm
    below = 1 / (1 / DECK["ballast"]["stiffness"] + 1 / ground)
    return math.sqrt((DECK["pad"]["stiffness"] + below) / (factor * SLEEPER / 2)) / (2 * math.pi)


def dynamic(numbers, factor):
    """Relative difference of a displacement at the frequency of the axles to a static one."""
    ratio = SPEED / WHEELBASE / resonance(numbers, factor)
    return 1 / (1 - ratio**2) - 1
