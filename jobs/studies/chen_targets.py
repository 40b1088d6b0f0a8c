"""Targets of the study chen."""
import dataclasses

import numpy as np

from .chen_runs import DEPTHS, DRAWN, LOADS, PACKINGS, RIG, SLEEPERS, SPEEDS, TOTAL, name_of
from .study import Target

# Published of loads, t, and speeds, km/h: largest pressure below a sleeper, kPa; delay, ms.
CHECKS = {(25, 120): (667.57, 18.00), (17, 60): (364.99, 36.00), (20, 150): (586.38, 14.40)}
WHEELBASE = 2.5  # m
SETTLED = {17: 5.31, 25: 12.58}  # mm, published of sleeper 3 at 120 km/h by axle load, t
BROKEN = 267  # %, published growth of fragments from 17 to 25 t
FASTER = {60: 5.45, 150: 7.83}  # mm, published of sleeper 3 by speed, km/h
VELOCITY = {60: 5.01, 150: 10.12}  # mm/s, published mean of stones under 25 t by speed, km/h
PRESSURES = {"ballast on sub-ballast": 41.6, "sub-ballast on the base": 36.2}  # %, 17 to 25 t
AS_LARGE = 0.3  # relative deviation that counts as reproduced
SMALL = 0.3  # ratio that counts as small or almost 0
MOST = 0.5  # part that counts as the majority or about all


def of(numbers, tonnes, quantity, kmh=120):
    """The quantity in each packing that the numbers have."""
    names = [name_of(tonnes, kmh, packing) for packing in PACKINGS]
    return np.array([numbers(name, quantity) for name in names if numbers.has(name)])


def growth(numbers, quantity, light=17, heavy=25):
    """Relative growth with the axle load in each packing, %."""
    return 100 * (of(numbers, heavy, quantity) / of(numbers, light, quantity) - 1)


def faster(numbers, tonnes, quantity, slow=60, fast=150):
    """Relative growth with the speed, %; one packing."""
    before, after = (numbers(name_of(tonnes, kmh, PACKINGS[0]), quantity) for kmh in (slow, fast))
    return 100 * (after / before - 1)


def settled(numbers, loads, speeds, sleepers=SLEEPERS):
    """Mean settlement over loads, speeds and sleepers, mm; one packing."""
    return np.mean([numbers(name_of(tonnes, kmh, PACKINGS[0]), f"settlement, sleeper {k}")
                    for tonnes in loads for kmh in speeds for k in sleepers])


def growths_of_mean(numbers):
    """Relative growth of the mean settlement from 17 to 25 t (over all speeds) and from 60 to
    150 km/h (over all loads), %; one packing."""
    return (100 * (settled(numbers, LOADS[-1:], SPEEDS) / settled(numbers, LOADS[:1], SPEEDS) - 1),
            100 * (settled(numbers, LOADS, SPEEDS[-1:]) / settled(numbers, LOADS, SPEEDS[:1]) - 1))


def stored(numbers, quantity):
    """Whether the numbers have a quantity of the passages; those of earlier runs may not."""
    return (DRAWN[-1], quantity) in numbers.rows


def speed_of_stones(numbers):
    """The quantity that is the mean speed of stones: of ballast alone if it is stored."""
    ballast = "mean speed of ballast"
    return ballast if stored(numbers, ballast) else "mean speed"


def moving(numbers):
    """What has this speed."""
    return "ballast" if stored(numbers, "mean speed of ballast") else "stones and spheres"


def shear_range(lines, depth):
    """Range of the shear stress below the middle of sleeper 3, kPa: 25 t, one packing."""
    return np.ptp(lines.of("shear")[f"z/h = {depth / TOTAL:.3f}"][1])


@dataclasses.dataclass(frozen=True)
class Path:
    """Changes of stress, kPa: the largest deviator; the shear then, and the largest strictly before
    and after it; the largest rise of the deviator in one row, and its time, s."""
    deviator: float
    then: float
    before: float
    after: float
    jump: float
    time: float


def path_of(lines):
    """Stress path below sleeper 3 under the last haversine."""
    histories = lines.of("sine, time")
    time, deviator = map(np.array, histories["vertical - horizontal"])
    shear = np.array(histories["shear"][1])
    top, rises = int(np.argmax(deviator)), np.diff(deviator)
    before, after = (part[np.argmax(np.abs(part))] for part in (shear[:top], shear[top + 1:]))
    return Path(deviator[top], shear[top], before, after, rises.max(),
                time[int(np.argmax(rises)) + 1])


def changes_sign(numbers):
    """Whether the shear does so at the largest deviator."""
    path = path_of(numbers.lines)
    return path.after / path.before < 0


def targets(numbers):
    found = [*targets_of_load(numbers), *targets_of_settlement(numbers),
             *targets_of_breakage(numbers), *targets_of_stress(numbers),
             *targets_of_rotation(numbers), *targets_of_pressure(numbers)]
    if has_series(numbers):
        found += [*targets_of_speed(numbers), *targets_of_stones(numbers),
                  *targets_of_path(numbers)]
    return found


def has_series(numbers):
    return numbers.has("haversine")


def compared(what, kind, published, each, unit, value, close=AS_LARGE, **more):
    """A target that counts as reproduced within `close`, of which there are several packings."""
    each = tuple(map(float, np.ravel(each)))
    return Target(what, kind, published, float(np.mean(each)), unit, value, close, each=each,
                  **more)


def held(what, kind, published, each, unit, limit, larger=True, **more):
    """A target that holds if each packing is above (or below) a limit; its sign is that of the
    mean."""
    each = tuple(map(float, np.ravel(each)))
    mean = float(np.mean(each))

    def beyond(value):
        return value > limit if larger else value < limit
    return Target(what, kind, published, mean, unit, sign=beyond(mean),
                  holds=all(map(beyond, each)), each=each, **more)


def targets_of_load(numbers):
    """What the runs are given, and what follows from it."""
    cases = CHECKS if has_series(numbers) else {(25, 120): CHECKS[25, 120]}
    for (tonnes, kmh), (pressure, delay) in cases.items():
        yield compared(f"largest pressure below a sleeper, {tonnes} t, {kmh} km/h", "input",
                       f"{pressure} kPa", of(numbers, tonnes, "largest load", kmh), "kPa", pressure,
                       0.01)
        yield compared(f"delay from sleeper to sleeper, {kmh} km/h", "input", f"{delay:.2f} ms",
                       of(numbers, tonnes, "delay between sleepers", kmh), "ms", delay, 0.01)
    rig = [RIG] if has_series(numbers) else []
    for (tonnes, kmh), value, place in zip([(25, 120), *rig], (13.3, 33.3), ("", " (test rig)")):
        yield compared(f"frequency of the M-shaped stress, {tonnes} t, {kmh} km/h{place}", "input",
                       f"{value} Hz", of(numbers, tonnes, "frequency of the M", kmh), "Hz",
                       kmh / 3.6 / WHEELBASE, 0.03)
    later, sooner = (of(numbers, 25, f"mean contact force, wheel at sleeper {k}") for k in (5, 1))
    yield held("mean contact force, wheel at sleeper 5 over wheel at sleeper 1", "input",
               "more than 1", later / sooner, "", 1)


def outer_over_others(numbers, quantity):
    """Mean of sleepers 1 and 5 over that of the others, in each packing, under 17 and 25 t."""
    return [sum(of(numbers, tonnes, quantity.format(k)) for k in (1, 5)) / 2
            / (sum(of(numbers, tonnes, quantity.format(k)) for k in (2, 3, 4)) / 3)
            for tonnes in (17, 25)]


def targets_of_settlement(numbers):
    more = growth(numbers, "settlement, sleeper 3")
    yield compared("settlement of sleeper 3: growth from 17 to 25 t", "main", "+137 %", more, "%",
                   100 * (SETTLED[25] / SETTLED[17] - 1), sign=more.mean() > 0, see="Settlement")
    for tonnes, value in SETTLED.items():
        yield compared(f"settlement of sleeper 3, {tonnes} t", "soft", f"{value} mm",
                       of(numbers, tonnes, "settlement, sleeper 3"), "mm", value, see="Settlement")
    yield held("settlement of sleepers 1 and 5 over that of the others", "main", "more than 1",
               outer_over_others(numbers, "settlement, sleeper {}"), "", 1, see="Settlement")


def targets_of_breakage(numbers):
    more = growth(numbers, "corners broken")
    yield compared("fragments: growth from 17 to 25 t", "main", f"+{BROKEN} %", more, "%", BROKEN,
                   sign=more.mean() > 0, see="Breakage")
    below, edges, all_of = (np.concatenate([of(numbers, t, quantity) for t in (17, 25)])
                            for quantity in ("corners broken below sleepers",
                                             "corners broken nearer to edges", "corners broken"))
    majority = f"majority (above {MOST})"
    yield held("part of the fragments below sleepers", "main", majority, below / all_of, "", MOST,
               see="Breakage")
    yield held("part of those that is nearer to edges than to the middle", "soft", majority,
               edges / below, "", MOST, see="Breakage")
    yield held("fragments below sleepers 1 and 5 over those below the others", "soft",
               "more than 1", outer_over_others(numbers, "corners broken, sleeper {}"), "", 1,
               see="Breakage")
    yield held("correlation of fragments and settlement over the five sleepers", "soft",
               "positive", [correlation(numbers, tonnes) for tonnes in (17, 25)], "", 0,
               see="Breakage")


def correlation(numbers, tonnes):
    """Of fragments below sleepers and their settlement, in each packing."""
    down, broken = (np.array([of(numbers, tonnes, quantity.format(k)) for k in SLEEPERS]).T
                    for quantity in ("settlement, sleeper {}", "corners broken, sleeper {}"))
    return [np.corrcoef(*pair)[0, 1] for pair in zip(down, broken)]


def targets_of_stress(numbers):
    down = 100 * (1 - of(numbers, 25, f"vertical at {DEPTHS[-1]} m")
                  / of(numbers, 25, f"vertical at {DEPTHS[0]} m"))
    yield compared("reduction of vertical stress, z/h 0.222 to 0.778", "main", "about 65 %", down,
                   "%", 65, sign=down.mean() > 0, see="Stress")
    shear = [shear_range(numbers.lines, depth) for depth in DEPTHS]
    yield compared("reduction of shear stress, z/h 0.222 to 0.778, packing 1", "soft", "about 65 %",
                   100 * (1 - shear[2] / shear[0]), "%", 65, see="Stress")
    yield held("shear stress at z/h 0.222 over the larger of those below, packing 1", "soft",
               "more than 1", shear[0] / max(shear[1:]), "", 1, see="Stress")
    side = [of(numbers, 25, f"horizontal at {depth} m") for depth in DEPTHS]
    yield held("horizontal stress at z/h 0.511 over the larger of those above and below", "soft",
               "more than 1", side[1] / np.maximum(side[0], side[2]), "", 1, see="Stress")
    yield held("horizontal stress at z/h 0.778 over that at 0.222", "soft", "less than 1",
               side[2] / side[0], "", 1, larger=False, see="Stress")
    yield held("part of the squared shear stress that changes its sign about the middle of "
               "sleeper 3", "main", f"about all (above {MOST})",
               of(numbers, 25, "shear antisymmetric"), "", MOST, see="Stress")
    later, sooner = (of(numbers, 25, f"contacts, wheel at sleeper {k}") for k in (5, 1))
    yield held("number of contacts, wheel at sleeper 5 over wheel at sleeper 1", "soft",
               "more than 1", later / sooner, "", 1, see="Stress")


def targets_of_rotation(numbers):
    # No sign is required: it may differ from packing to packing.
    yield dataclasses.replace(
        held("rotation of the principal stress: edges over centre of sleeper 3", "main",
             "more than 1", rotation_ratio(numbers), "", 1), sign=None, see="Rotation")


def rotation_ratio(numbers):
    """Range of the angle at the edges over that below the middle, in each packing."""
    centre = sum(of(numbers, 25, f"rotation, centre, {depth} m") for depth in DEPTHS)
    return sum(of(numbers, 25, f"rotation, {side} edge, {depth} m") / 2 for depth in DEPTHS
               for side in ("left", "right")) / centre


def targets_of_pressure(numbers):
    upper, lower = (of(numbers, 25, quantity) for quantity in PRESSURES)
    # No sign is required: vertical forces are in equilibrium, see the document.
    yield compared("reduction of the pressure by the sub-ballast", "main", "68 to 77 %",
                   100 * (1 - lower / upper), "%", 72.5, see="Sub-ballast")
    for what, (quantity, value) in zip(("pressure of ballast on sub-ballast",
                                        "pressure below the sub-ballast"), PRESSURES.items()):
        yield compared(f"{what}: growth from 17 to 25 t", "soft", f"+{value} %",
                       growth(numbers, quantity), "%", value, see="Sub-ballast")
    if has_series(numbers):
        steps = [faster(numbers, 25, "ballast on sub-ballast", *pair)
                 for pair in ((60, 90), (90, 150))]
        yield held("pressure on the sub-ballast: growth from 90 to 150 km/h over that from 60 to "
                   "90, 25 t, packing 1", "soft", f"almost 0 (below {SMALL})", steps[1] / steps[0],
                   "", SMALL, larger=False, see="Sub-ballast")


def targets_of_speed(numbers):
    """The study does not state the load of its speeds: by its settlements under 17 and 25 t at
    120 km/h it is 20 t."""
    see = "Loads and speeds"
    down, load = (faster(numbers, 20, "settlement, sleeper 3"),
                  growth(numbers, "settlement, sleeper 3"))
    yield compared("settlement of sleeper 3: growth from 60 to 150 km/h, 20 t, packing 1", "main",
                   "+43.7 %", down, "%", 100 * (FASTER[150] / FASTER[60] - 1), sign=down > 0,
                   see=see)
    for kmh, value in FASTER.items():
        yield compared(f"settlement of sleeper 3, 20 t, {kmh} km/h, packing 1", "soft",
                       f"{value} mm", numbers(name_of(20, kmh, PACKINGS[0]),
                                              "settlement, sleeper 3"), "mm", value, see=see)
    yield held("settlement of sleeper 3: growth with the load (120 km/h, each packing) over that "
               "with the speed (20 t, packing 1)", "main", "more than 1", load / down, "", 1,
               see=see)
    load, down = growths_of_mean(numbers)
    yield held("mean settlement of five sleepers: growth with the load (all speeds) over that with "
               "the speed (all loads), packing 1", "main", "more than 1", load / down, "", 1,
               see=see)
    more = faster(numbers, 20, "corners broken")
    yield compared("fragments: growth from 60 to 150 km/h, 20 t, packing 1", "main", "+63 %", more,
                   "%", 63, sign=more > 0, see=see)
    yield held("fragments: growth with the load (120 km/h, each packing) over that with the speed "
               "(20 t, packing 1)", "main", "more than 1", growth(numbers, "corners broken") / more,
               "", 1, see=see)


def targets_of_stones(numbers):
    see, quantity = "Loads and speeds", speed_of_stones(numbers)
    what = f"mean speed of {moving(numbers)}"
    for kmh, value in VELOCITY.items():
        yield compared(f"{what}, 25 t, {kmh} km/h, packing 1", "soft",
                       f"{value} mm/s", numbers(name_of(25, kmh, PACKINGS[0]), quantity), "mm/s",
                       value, see=see)
    more = faster(numbers, 25, quantity)
    yield compared(f"{what}: growth from 60 to 150 km/h, 25 t, packing 1", "main",
                   "+102 %", more, "%", 100 * (VELOCITY[150] / VELOCITY[60] - 1), sign=more > 0,
                   see=see)
    yield held(f"{what}: growth from 17 to 25 t (each packing) over that from 60 to "
               "150 km/h (packing 1)", "soft", f"small (below {SMALL})",
               growth(numbers, quantity) / more, "", SMALL, larger=False, see=see)


def targets_of_path(numbers):
    path, see = path_of(numbers.lines), "Single load and test rig"
    yield held("stress path of a haversine: shear after its largest deviator over shear before, "
               "packing 1", "main", "negative", path.after / path.before, "", 0, larger=False,
               see=see)
    yield held("stress path: shear at the largest deviator over the largest shear, packing 1",
               "main", f"almost 0 (below {SMALL})",
               abs(path.then) / max(abs(path.before), abs(path.after), abs(path.then)), "", SMALL,
               larger=False, see=see)
