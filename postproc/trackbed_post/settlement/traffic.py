"""A traffic: trains of a day, from a table, as axles and tonnes over time."""
import csv
import dataclasses
import math

from trackbed_post import read

NAMES = ("trains_per_day", "axles", "axle_load_t")
YEAR = 365.25  # days


@dataclasses.dataclass(frozen=True)
class Trains:
    """Equal trains of a day."""
    name: str
    per_day: float
    axles: float
    axle_load: float  # t


@dataclasses.dataclass(frozen=True)
class Traffic:
    trains: tuple

    def tonnes_per_day(self):
        return sum(one.per_day * one.axles * one.axle_load for one in self.trains)

    def axles_per_day(self, axle_load=None, power=None):
        """Axles of all loads; with `axle_load`, t, axles of this load that settle the track as
        much: an axle of another load counts (load/axle_load)^power times."""
        if axle_load is None:
            if len({one.axle_load for one in self.trains}) > 1:
                raise read.Unreadable("the traffic has several axle loads: state that of the run "
                                      "(--axle-load)")
            return sum(one.per_day * one.axles for one in self.trains)
        if power is None and any(one.axle_load != axle_load for one in self.trains):
            raise read.Unreadable(f"the traffic has other axle loads than {axle_load:g} t of the "
                                  "run (--axle-load): state as how many axles of the run one "
                                  "of another load counts (--load-exponent)")
        return sum(one.per_day * one.axles * (one.axle_load / axle_load) ** (power or 0)
                   for one in self.trains)


def _number(row, name, where):
    try:
        value = float(row[name])
    except (TypeError, ValueError):
        value = math.nan
    if not 0 < value < math.inf:
        raise read.Unreadable(f"{where}: {name} must be a number above 0, not {row[name]!r}")
    return value


def traffic_from(path):
    """Reads a CSV table with the columns NAMES and, if wanted, `name`."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            rows, head = list(reader), reader.fieldnames or []
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise read.Unreadable(f"{path} cannot be read ({error})") from None
    if lacking := [name for name in NAMES if name not in head]:
        raise read.Unreadable(f"{path} has no column {', '.join(lacking)}; needed are "
                              f"{', '.join(NAMES)}")
    if not rows:
        raise read.Unreadable(f"{path} has no trains")
    return Traffic(tuple(
        Trains(row.get("name") or f"train {number}",
               *(_number(row, name, f"{path}, row {number}") for name in NAMES))
        for number, row in enumerate(rows, 1)))
