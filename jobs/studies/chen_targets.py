"""Targets of the study chen."""
import dataclasses

import numpy as np

from .chen_runs import DEPTHS, PACKINGS, RIG, name_of
from .study import Target

# Published for 25 t and 120 km/h: largest pressure below a sleeper, kPa; delay, ms.
LOAD, DELAY = 667.57, 18.00
AS_LARGE = 0.3  # relative deviation that counts as reproduced


def of(numbers, tonnes, quantity, kmh=120):
    """The quantity in each packing that the numbers have."""
    names = [name_of(tonnes, kmh, packing) for packing in PACKINGS]
    return np.array([numbers(name, quantity) for name in names if numbers.has(name)])


def growth(numbers, quantity, light=17, heavy=25):
    """Relative growth with the axle load in each packing, %."""
    return 100 * (of(numbers, heavy, quantity) / of(numbers, light, quantity) - 1)


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


def targets(numbers):
    found = [*targets_of_load(numbers), *targets_of_settlement(numbers),
             *targets_of_breakage(numbers), *targets_of_stress(numbers)]
    if has_series(numbers):
        found += [*targets_of_speed(numbers), *targets_of_path(numbers)]
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
    return Target(what, kind, published, mean, unit, sign=(mean > limit) == larger,
                  holds=all((value > limit) == larger for value in each), each=each, **more)


def targets_of_load(numbers):
    yield compared("largest pressure below a sleeper, 25 t, 120 km/h", "hard", f"{LOAD} kPa",
                   of(numbers, 25, "largest load"), "kPa", LOAD, 0.01)
    yield compared("delay from sleeper to sleeper, 120 km/h", "hard", f"{DELAY:.2f} ms",
                   of(numbers, 25, "delay between sleepers"), "ms", DELAY, 0.01)
    yield compared("frequency of the M-shaped stress, 25 t, 120 km/h", "hard", "13.3 Hz",
                   of(numbers, 25, "frequency of the M"), "Hz", 120 / 3.6 / 2.5, 0.03)


def targets_of_settlement(numbers):
    more = growth(numbers, "settlement, sleeper 3")
    yield compared("settlement of sleeper 3: growth from 17 to 25 t", "main", "+137 %", more, "%",
                   100 * (12.58 / 5.31 - 1), sign=more.mean() > 0)
    for tonnes, value in ((17, 5.31), (25, 12.58)):
        yield compared(f"settlement of sleeper 3, {tonnes} t", "soft", f"{value} mm",
                       of(numbers, tonnes, "settlement, sleeper 3"), "mm", value)
    outer = [sum(of(numbers, tonnes, f"settlement, sleeper {k}") for k in (1, 5)) / 2
             / (sum(of(numbers, tonnes, f"settlement, sleeper {k}") for k in (2, 3, 4)) / 3)
             for tonnes in (17, 25)]
    yield held("settlement of sleepers 1 and 5 over that of the others", "main", "more than 1",
               outer, "", 1)


def targets_of_breakage(numbers):
    more = growth(numbers, "corners broken")
    yield compared("fragments: growth from 17 to 25 t", "main", "+267 %", more, "%", 267,
                   sign=more.mean() > 0)
    below, edges, all_of = (np.concatenate([of(numbers, t, quantity) for t in (17, 25)])
                            for quantity in ("corners broken below sleepers",
                                             "corners broken nearer to edges", "corners broken"))
    yield held("part of the fragments below sleepers", "main", "majority", below / all_of, "", 0.5)
    yield held("part of those that is nearer to edges than to the middle", "soft", "majority",
               edges / below, "", 0.5)


def faster(numbers, tonnes, quantity, slow=60, fast=150):
    """Relative growth with the speed, %; one packing."""
    before, after = (numbers(name_of(tonnes, kmh, PACKINGS[0]), quantity) for kmh in (slow, fast))
    return 100 * (after / before - 1)


def targets_of_speed(numbers):
    """The study does not state the load of its speeds: by its settlements under 17 and 25 t at
    120 km/h it is 20 t."""
    down = faster(numbers, 20, "settlement, sleeper 3")
    yield compared("settlement of sleeper 3: growth from 60 to 150 km/h, 20 t", "main", "+43.7 %",
                   down, "%", 100 * (7.83 / 5.45 - 1), sign=down > 0)
    for kmh, value in ((60, 5.45), (150, 7.83)):
        yield compared(f"settlement of sleeper 3, 20 t, {kmh} km/h", "soft", f"{value} mm",
                       numbers(name_of(20, kmh, PACKINGS[0]), "settlement, sleeper 3"), "mm",
                       value)
    load = growth(numbers, "settlement, sleeper 3")[0]
    yield held("growth of settlement with the load over that with the speed", "main", "more than 1",
               load / down, "", 1)
    more = faster(numbers, 20, "corners broken")
    yield compared("fragments: growth from 60 to 150 km/h, 20 t", "main", "+63 %", more, "%", 63,
                   sign=more > 0)
    yield held("growth of fragments with the load over that with the speed", "main", "more than 1",
               growth(numbers, "corners broken")[0] / more, "", 1)
    for kmh, value in ((60, 5.01), (150, 10.12)):
        yield compared(f"mean speed of stones, 25 t, {kmh} km/h", "soft", f"{value} mm/s",
                       numbers(name_of(25, kmh, PACKINGS[0]), "mean speed"), "mm/s", value)
    yield compared("mean speed of stones: growth from 60 to 150 km/h, 25 t", "main", "+102 %",
                   faster(numbers, 25, "mean speed"), "%", 100 * (10.12 / 5.01 - 1),
                   sign=faster(numbers, 25, "mean speed") > 0)
    yield held("mean speed of stones: growth from 17 to 25 t over that from 60 to 150 km/h", "soft",
               "small", growth(numbers, "mean speed")[0] / faster(numbers, 25, "mean speed"), "",
               AS_LARGE, larger=False)
    pressure = [faster(numbers, 25, "ballast on sub-ballast", *pair)
                for pair in ((60, 90), (90, 150))]
    yield held("pressure on the sub-ballast: growth from 90 to 150 km/h over that from 60 to 90",
               "soft", "almost 0", pressure[1] / pressure[0], "", AS_LARGE, larger=False)


def targets_of_path(numbers):
    rig = name_of(*RIG, PACKINGS[0])
    yield compared("frequency of the M-shaped stress, 17 t, 300 km/h (test rig)", "hard", "33.3 Hz",
                   numbers(rig, "frequency of the M"), "Hz", RIG[1] / 3.6 / 2.5, 0.03)
    before, after = (numbers("haversine", f"largest shear {when}") for when in ("before", "after"))
    yield held("stress path of a haversine: shear after its largest deviator over shear before",
               "main", "negative", after / before, "", 0, larger=False)
    yield held("stress path: shear at the largest deviator over the largest shear", "main",
               "almost 0",
               abs(numbers("haversine", "shear then")) / max(abs(before), abs(after)), "",
               AS_LARGE, larger=False)


def targets_of_stress(numbers):
    def falls(quantity, last):
        first, last = (of(numbers, 25, name) for name in (quantity, last))
        return 100 * (1 - last / first)
    # No sign is required: vertical forces are in equilibrium, see the document.
    yield compared("reduction of the pressure by the sub-ballast", "main", "68 to 77 %",
                   falls("ballast on sub-ballast", "sub-ballast on the base"), "%", 72.5,
                   see="Stress")
    down = falls(f"vertical at {DEPTHS[0]} m", f"vertical at {DEPTHS[-1]} m")
    yield compared("reduction of vertical stress, z/h 0.222 to 0.778", "main", "about 65 %", down,
                   "%", 65, sign=down.mean() > 0)
    side = [of(numbers, 25, f"horizontal at {depth} m") for depth in DEPTHS]
    yield held("horizontal stress at z/h 0.511 over the larger of those above and below", "soft",
               "more than 1", side[1] / np.maximum(side[0], side[2]), "", 1)
    yield held("part of shear that changes its sign at the middle of a sleeper", "main",
               "about all", of(numbers, 25, "shear antisymmetric"), "", 0.5)
    centre = sum(of(numbers, 25, f"rotation, centre, {depth} m") for depth in DEPTHS)
    edges = sum(of(numbers, 25, f"rotation, {side} edge, {depth} m") / 2 for depth in DEPTHS
                for side in ("left", "right"))
    # No sign is required: it differs from packing to packing, see the document.
    yield dataclasses.replace(
        held("rotation of the principal stress: edges over centre of sleeper 3", "main",
             "more than 1", edges / centre, "", 1), sign=None, see="Stress")
    for what, quantity, value in (
            ("pressure of ballast on sub-ballast", "ballast on sub-ballast", 41.6),
            ("pressure below the sub-ballast", "sub-ballast on the base", 36.2)):
        yield compared(f"{what}: growth from 17 to 25 t", "soft", f"+{value} %",
                       growth(numbers, quantity), "%", value)
    for what, quantity in (("number of contacts", "contacts"),
                           ("mean contact force", "mean contact force")):
        later, sooner = (of(numbers, 25, f"{quantity}, wheel at sleeper {k}") for k in (5, 1))
        yield held(f"{what}, wheel at sleeper 5 over wheel at sleeper 1", "soft", "more than 1",
                   later / sooner, "", 1)
