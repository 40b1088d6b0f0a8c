"""Green's functions of a track, as `trackbed kernel` writes them, and their superposition along the
paths of wheels (section 5.7 of the thesis).

Forces of wheels are downward, responses upward positive.
"""
import dataclasses
import pathlib

import h5py
import numpy as np

from trackbed_post import read

KIND = "trackbed Green's functions"
SAME_SPEED = 2e-3  # relative, of a moving response
QUANTITIES = ("displacement", "acceleration")
LARGER, SMALLER = TOWARDS = ("larger", "smaller")  # x, towards which a train runs


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

    def turned(self):
        """Last to first, as they pass in the opposite order."""
        return dataclasses.replace(self, behind=self.behind[-1] - self.behind[::-1],
                                   load=self.load[::-1], mass=self.mass[::-1])

    def alike(self, other):
        """Whether these are the same wheels at the same distances, but for rounding."""
        return (np.allclose(self.behind, other.behind, atol=1e-3)
                and np.allclose(self.load, other.load, rtol=1e-3)
                and np.allclose(self.mass, other.mass, rtol=1e-3))


@dataclasses.dataclass(frozen=True)
class Kernel:
    """Responses to a force of one sample: `fixed`, of the sensor, by rail and quantity, [position,
    lag], m/N or m/s2/N; `moving`, of the rail below the first wheel, by rail, a table for each of
    the axles that are `behind` m behind this wheel. x, moving_x, sensor in m; rate in Hz; speed of
    the moving response, m/s, or 0; `wheels` of the deck's train, or None, in the order in which
    they pass; `towards`: larger x, or smaller x of the deck, whose mirror image x is then."""
    rate: float
    sensor: float
    side: str
    speed: float
    x: np.ndarray
    fixed: dict
    wheels: Wheels
    moving_x: np.ndarray
    moving: dict
    behind: np.ndarray
    towards: str = LARGER

    @property
    def samples(self):
        return next(iter(self.fixed.values()))["displacement"].shape[1]

    def turned(self):
        """With the wheels in the opposite order."""
        return dataclasses.replace(self, wheels=self.wheels.turned())

    def mirror(self, x):
        """m, of positions in the mirror image of the track."""
        return self.x[0] + self.x[-1] - x

    def mirrored(self):
        """Of the mirror image of the track, on which a train runs towards larger x that runs
        towards smaller x of the deck. Responses of the sensor do not depend on where the force goes
        next; the moving response does, and is left out."""
        return dataclasses.replace(
            self, sensor=self.mirror(self.sensor), x=self.mirror(self.x)[::-1], moving={},
            fixed={rail: {name: table[::-1] for name, table in tables.items()}
                   for rail, tables in self.fixed.items()},
            towards=SMALLER if self.towards == LARGER else LARGER)


def load(path):
    """A Kernel from a file of `trackbed kernel`."""
    if not pathlib.Path(path).is_file():
        raise read.Unreadable(f"{path} is no file: give one that `trackbed kernel` wrote")
    found = read.datasets(path)
    try:
        with h5py.File(path) as file:
            if read.as_text(file.attrs.get("kind", "")) != KIND:
                raise read.Unreadable(f"{path} was not written by `trackbed kernel`")
            return kernel_of(file.attrs, file["train"].attrs if "train" in file else {}, found)
    except (KeyError, IndexError, AttributeError) as error:
        raise read.Unreadable(f"{path} is no complete file of `trackbed kernel` ({error})") \
            from None


def kernel_of(given, contact, found):
    """A Kernel from the attributes of the file and of its train, and from its datasets."""
    def values(name):
        return found[name].values
    rails = [rail for rail in ("left", "right") if f"fixed/{rail}/displacement" in found]
    behind = values("axles")
    moves = "moving/x" in found
    return Kernel(
        rate=float(given["rate"]), sensor=float(given["sensor_x"]),
        side=read.as_text(given["side"]), speed=float(given["speed"]), x=values("fixed/x"),
        fixed={rail: {name: values(f"fixed/{rail}/{name}") for name in QUANTITIES}
               for rail in rails},
        wheels=Wheels(*(values(f"train/{name}") for name in ("behind", "load", "mass")),
                      *(float(contact[f"contact_{name}"]) for name in ("constant", "exponent")))
        if contact else None,
        moving={rail: [values(f"moving/{rail}/axle_{axle + 1}") for axle in range(len(behind))]
                for rail in rails if moves},
        moving_x=values("moving/x") if moves else np.empty(0), behind=behind)


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
