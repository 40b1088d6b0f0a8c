"""Types of the values of options: each turns its text into a value, or states what is wrong."""
import argparse
import math
import re
import typing

from trackbed_post import instants
from trackbed_post.settlement import laws

FORMATS = ("png", "pdf", "svg", "csv")  # csv: the lines of each figure


def formats(text: str) -> tuple[str, ...]:
    chosen = tuple(text.split(","))
    if unknown := set(chosen) - set(FORMATS):
        raise argparse.ArgumentTypeError(f"{', '.join(sorted(unknown))}: the formats are "
                                         f"{', '.join(FORMATS)}")
    return chosen


def _number(text: str) -> float:
    """Not a number for other words."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def noise(text: str) -> float:
    value = _number(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text}: must be 0 or more, m/s2")
    return value


def subgrade(text: str) -> tuple[str, float, float]:
    """Soil, stress over strength, thickness in m."""
    soil, *rest = text.split(":")
    try:
        ratio, thickness = map(float, rest)
        fits = soil in laws.SOILS and 0 < ratio <= 1 and 0 < thickness < math.inf
    except ValueError:
        fits = False
    if not fits:
        raise argparse.ArgumentTypeError(f"{text}: give SOIL:RATIO:THICKNESS, soil "
                                         f"{', '.join(laws.SOILS)}, ratio of stress to strength "
                                         "up to 1, thickness in m")
    return soil, ratio, thickness


def parts(text: str) -> tuple[str, ...]:
    """Parts of the model, each once."""
    chosen = tuple(dict.fromkeys(text.split(",")))
    known = instants.PARTS + instants.LINES
    if unknown := [part for part in chosen if part not in known]:
        raise argparse.ArgumentTypeError(f"{', '.join(unknown)}: the parts are "
                                         f"{', '.join(known)}")
    return chosen


class Rising(argparse.Action):
    """Two numbers, the first below the second."""

    def __call__(self, whole: argparse.ArgumentParser, given: argparse.Namespace,
                 values: typing.Any, option_string: str | None = None) -> None:
        if values[0] >= values[1]:
            whole.error(f"argument {option_string}: {values[0]:g} must be below {values[1]:g}")
        setattr(given, self.dest, values)


def count(text: str) -> int:
    if not text.isdigit() or not int(text):
        raise argparse.ArgumentTypeError(f"{text}: must be a whole number above 0")
    return int(text)


def positive(text: str) -> float:
    value = _number(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text}: must be a number above 0")
    return value


def finite(text: str) -> float:
    value = _number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text}: must be a number")
    return value


def of_wheel(text: str) -> float:
    value = positive(text)
    if not 0.1 <= value <= 1:
        raise argparse.ArgumentTypeError(f"{text}: wheels have a radius of 0.1 to 1 m")
    return value


# Also with an exponent, which argparse would take for an option.
NEGATIVE = re.compile(r"^-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")
