"""Frequencies at which a passing train loads a place of the track: its speed over the distances of
its axles, bogies and vehicles, and over the sleeper spacing."""
import numpy as np

from trackbed_post import axles, ground_blocks, measures, read

AXLE_GAP = 4.0  # m; axles that are closer form a bogie
SAME = 0.01     # relative; passing frequencies of two runs that differ by more are not the same


# What the speed v is divided by.
MEANINGS = {"v/L_v": "L_v: length of a vehicle", "v/L_c": "L_c: distance of bogie centres",
            "v/L_w": "L_w: wheelbase", "v/s": "s: sleeper spacing"}


def bogies_of(places: np.ndarray) -> list[np.ndarray]:
    """Places of the axles of each bogie, m, from the smallest; a wagon without bogies has groups of
    one axle."""
    there = np.sort(places)
    return np.split(there, np.flatnonzero(np.diff(there) > AXLE_GAP) + 1)


def of_train(results: read.Results) -> dict[str, float]:
    """{name: Hz} of a train on a rail, from the places of its first vehicle's axles; L_v is the
    distance of equal axles of the first two vehicles. Of vehicles that differ, or without histories
    of wheels, v/s only; empty if the speed changes."""
    train = results.deck.get("train", {})
    speed, count = train.get("speed", 0.0), len(train.get("vehicles", []))
    x = results.wheel.get("x", read.NOTHING).values
    if not count or not speed or train.get("speeds"):
        return {}
    vehicles = axles.by_vehicle(axles.of_wheels(x[results.passage()]), count) if x.size else None
    found = {}
    if vehicles is not None:
        bogies = bogies_of(vehicles[0])
        single = all(len(bogie) == 1 for bogie in bogies)
        if count > 1:
            found["v/L_v"] = speed / vehicles[1, 0]
        if len(bogies) > 1:
            found["v/L_w" if single else "v/L_c"] = speed / (bogies[1].mean() - bogies[0].mean())
        if len(bogies[0]) > 1:
            found["v/L_w"] = speed / (bogies[0][1] - bogies[0][0])
    return found | {"v/s": speed / measures.spacing(results)}


NEAR = 0.2  # of a passing frequency: a peak that is further away is not its own


def reach(marks: dict[str, float], name: str) -> float:
    """How far from a passing frequency its peak may be, Hz: half the distance of the lobes, which
    is the lowest passing frequency, as the slope of one factor shifts the maximum of another."""
    return min(NEAR * marks[name], min(marks.values()) / 2)


RESOLVED = 2.0  # over the time in which a train passes a place, Hz: closer lobes are not resolved


def beside(results: read.Results, marks: dict[str, float]) -> float:
    """How far from a peak the lobes are that it is compared with, Hz: RESOLVED over the time from
    the first to the last axle at a place, in which closer frequencies cannot be distinguished. The
    lobes of a vehicle or two are closer than that, the lines of a longer train are not. If the
    axles are not known, one and a half times the lowest passing frequency."""
    if not marks:
        return 0.0
    if ground_blocks.carried_by_springs(results):
        x = results.wheel.get("x", read.NOTHING).values
        speed = results.deck["train"]["speed"]
        long = float(axles.behind(axles.of_wheels(x[results.passage()]))[-1]) if x.size else 0.0
    else:
        speed, long = results.deck["load"]["speed"], float(np.ptp(results.deck["load"]["axles"]))
    return RESOLVED * speed / long if long else 1.5 * min(marks.values())


def alike(marks: dict[str, float], others: dict[str, float]) -> bool:
    """Whether two trains have the same passing frequencies: not if their speeds differ."""
    return marks.keys() == others.keys() and all(
        abs(others[name] - target) <= SAME * target for name, target in marks.items())


def rows_of_last_train(results: read.Results) -> slice:
    """Rows of the last train of the passage, up to its end; all of it with one train, or if the
    places of wheels are not known. The spectrum of several trains together has lines for the time
    between them, a comb over the lobes of a train."""
    rows, x = results.passage(), results.wheel.get("x", read.NOTHING).values
    if not x.size or not ground_blocks.carried_by_springs(results):
        return rows
    trains = axles.rows_of_trains(axles.of_wheels(x[rows]))
    return slice(rows.start + int(trains[-1][0]), rows.stop) if len(trains) > 1 else rows


def resolution(results: read.Results) -> float:
    """Of spectra of the passage, Hz: one over the length of their record; what is closer cannot be
    distinguished, also where zeros are appended so that lines are closer."""
    time = results.time[rows_of_last_train(results)]
    return 1 / float(np.ptp(time)) if len(time) > 1 else 0.0


def of_passage(results: read.Results) -> dict[str, float]:
    """{name: Hz} of the last passage: of its train, or of the axles of [load]."""
    if ground_blocks.carried_by_springs(results):
        return of_train(results)
    found = measures.loading_frequencies(results)
    if found:
        found["v/s"] = results.deck["load"]["speed"] / measures.spacing(results)
    return found
