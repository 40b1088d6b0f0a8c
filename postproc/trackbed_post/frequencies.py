"""Frequencies at which a passing train loads a place of the track: its speed over the distances of
its axles, bogies and vehicles, and over the sleeper spacing."""
import numpy as np

from trackbed_post import ground_blocks, measures, read

AXLE_GAP = 4.0  # m; axles that are closer form a bogie


def bogies_of(axles: np.ndarray) -> list[np.ndarray]:
    """Places of the axles of each bogie, m, from the smallest; a wagon without bogies has groups of
    one axle."""
    there = np.sort(axles)
    return np.split(there, np.flatnonzero(np.diff(there) > AXLE_GAP) + 1)


def axles_behind(wheel_x: np.ndarray) -> np.ndarray:
    """Distance of each axle behind the first one, m, of histories [time, wheel] that are nan beside
    the track; ends before an axle that is never on the track together with the one before it. On
    two rails the wheels of an axle are at the same place."""
    found = [0.0]
    for ahead, axle in zip(wheel_x.T, wheel_x.T[1:]):
        both = np.isfinite(ahead) & np.isfinite(axle)
        if not both.any():
            break
        if (way := float(np.median(np.abs(ahead - axle)[both]))) > measures.TINY:
            found.append(found[-1] + way)
    return np.array(found)


def of_train(results: read.Results) -> dict[str, float]:
    """{name: Hz} of a train on a rail, from the places of its first vehicle's axles; L_v is the
    distance of equal axles of the first two vehicles. Empty if its speed changes."""
    train = results.deck.get("train", {})
    speed, count = train.get("speed", 0.0), len(train.get("vehicles", []))
    if not results.wheel_x.size or not count or not speed or train.get("speeds"):
        return {}
    rows = results.wheel_x[results.passage()]
    axles = axles_behind(rows.reshape(len(rows), -1))
    found = {}
    if len(axles) % count == 0:
        size = len(axles) // count
        bogies = bogies_of(axles[:size])
        single = all(len(bogie) == 1 for bogie in bogies)
        if count > 1:
            found["v/L_v"] = speed / axles[size]
        if len(bogies) > 1:
            found["v/L_w" if single else "v/L_c"] = speed / (bogies[1].mean() - bogies[0].mean())
        if len(bogies[0]) > 1:
            found["v/L_w"] = speed / (bogies[0][1] - bogies[0][0])
    return found | {"v/s": speed / measures.spacing(results)}


def of_passage(results: read.Results) -> dict[str, float]:
    """{name: Hz} of the last passage: of its train, or of the axles of [load]."""
    if ground_blocks.carried_by_springs(results):
        return of_train(results)
    found = measures.loading_frequencies(results)
    if found:
        found["v/s"] = results.deck["load"]["speed"] / measures.spacing(results)
    return found
