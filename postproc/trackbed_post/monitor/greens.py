"""Green's functions of a track, as `trackbed kernel` writes them, and their superposition along the
paths of wheels (section 5.7 of the thesis).

Forces of wheels are downward, responses upward positive.
"""
import dataclasses

import h5py
import numpy as np

from trackbed_post import read

KIND = "trackbed Green's functions"
SAME_SPEED = 2e-3  # relative, of a moving response
QUANTITIES = ("displacement", "acceleration")


@dataclasses.dataclass(frozen=True)
class Wheels:
    """Wheels of a train on one rail, first to last: distance behind the first, m; static force, N;
    mass, kg, with half the axle; force (N) on the rail: constant * (approach in m)^exponent."""
    behind: np.ndarray
    load: np.ndarray
    mass: np.ndarray
    constant: float
    exponent: float

    def approach(self, force):
        """m, of wheel and rail; 0 without contact."""
        return (np.maximum(force, 0.0) / self.constant)**(1 / self.exponent)


@dataclasses.dataclass(frozen=True)
class Kernel:
    """Responses to a force of one sample: `fixed`, of the sensor, by rail and quantity, [position,
    lag], m/N or m/s2/N; `moving`, of the rail below the first wheel, by rail, a table for each of
    the first axles. x, moving_x, sensor in m; rate in Hz; speed of the moving response, m/s, or 0;
    `wheels` of the deck's train, or None."""
    rate: float
    sensor: float
    side: str
    speed: float
    x: np.ndarray
    fixed: dict
    wheels: Wheels
    moving_x: np.ndarray
    moving: dict

    @property
    def samples(self):
        return next(iter(self.fixed.values()))["displacement"].shape[1]


def load(path):
    """A Kernel from a file of `trackbed kernel`."""
    found = read.datasets(path)
    with h5py.File(path) as file:
        if file.attrs.get("kind", b"").decode() != KIND:
            raise read.Unreadable(f"{path} was not written by `trackbed kernel`")
        given = {name: file.attrs[name] for name in ("rate", "sensor_x", "side", "speed")}
        contact = [float(file["train"].attrs[f"contact_{name}"])
                   for name in ("constant", "exponent")] if "train" in file else None
    rails = [rail for rail in ("left", "right") if f"fixed/{rail}/displacement" in found]
    moving = {rail: [found[f"moving/{rail}/axle_{axle + 1}"].values
                     for axle in range(len(found["axles"].values))]
              for rail in rails if "moving/x" in found}
    return Kernel(
        rate=float(given["rate"]), sensor=float(given["sensor_x"]), side=given["side"].decode(),
        speed=float(given["speed"]), x=found["fixed/x"].values,
        fixed={rail: {name: found[f"fixed/{rail}/{name}"].values for name in QUANTITIES}
               for rail in rails},
        wheels=Wheels(*(found[f"train/{name}"].values for name in ("behind", "load", "mass")),
                      *contact) if contact else None,
        moving=moving, moving_x=found["moving/x"].values if moving else np.empty(0))


def between(table, x, at):
    """The row of a table at position `at` between its positions x, evenly spaced; zeros beyond."""
    place = (at - x[0]) / (x[1] - x[0])
    row = int(np.floor(place + 1e-9))
    part = max(place - row, 0.0)
    if row < 0 or row + (part > 1e-6) > len(x) - 1:
        return np.zeros(table.shape[1])
    return table[row] if part <= 1e-6 else (1 - part) * table[row] + part * table[row + 1]


def superposed(table, x, places, forces, count):
    """Response, `count` samples, to downward forces, N, that act at `places`, m, one per sample."""
    lags = table.shape[1]
    total = np.zeros(len(places) + lags)
    for sample in np.flatnonzero(forces):
        total[sample:sample + lags] -= forces[sample] * between(table, x, places[sample])
    return total[:count]
