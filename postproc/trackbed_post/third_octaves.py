"""Third octaves of sleepers and wheels as levels: a panel for each quantity. Unlike a spectrum with
linear axes they show high and low frequencies alike. The band is that of `vibration`."""
import collections.abc
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from trackbed_post import panels, read, signals

LEAST_ROWS = 32
# Nominal midband frequencies of octaves, Hz (ISO 266).
OCTAVES = (1, 2, 4, 8, 16, 31.5, 63, 125, 250, 500, 1000, 2000, 4000, 8000, 16000)
# Quantities of sleepers in histories: words for the axis, SI unit.
OF_SLEEPERS = {"acceleration": ("acceleration of sleepers", "m/s2"),
               "displacement": ("displacement of sleepers", "m"),
               "seat_force": ("seat load", "N")}
Histories = collections.abc.Sequence[tuple[np.ndarray, np.ndarray]]  # time, s; values in SI units


@dataclasses.dataclass(frozen=True)
class Bands:
    """A line of a panel: midband frequencies, Hz, and root mean squares, in `unit`."""
    what: str
    unit: str
    label: str
    middle: np.ndarray
    rms: np.ndarray

    @property
    def axis(self) -> str:
        return f"{self.what}\ndB re {signals.REFERENCES[self.unit]:g} {self.unit}"


def of(what: str, unit: str, label: str, histories: Histories) -> Bands | None:
    """Root mean square over the places of the bands that every record resolves; None of records
    that are too short or unevenly spaced."""
    histories = [(time, values) for time, values in histories if len(time) >= LEAST_ROWS
                 and signals.step_of(time) is not None]
    found = [dict(zip(*signals.third_octaves(time, values))) for time, values in histories]
    middle = [band for band in found[0] if all(band in one for one in found)] if found else []
    if not middle:
        return None
    rms = np.sqrt(np.mean([[one[band]**2 for band in middle] for one in found], axis=0))
    return Bands(what, unit, label, np.array(middle), rms)


def of_sleepers(time: np.ndarray, sleeper: read.Quantities, kept: np.ndarray | slice,
                label: str) -> list[Bands]:
    """Of each quantity in OF_SLEEPERS that the run has; `time` and `sleeper` are those of the rows
    that count, `kept` the columns."""
    found = [of(what, unit, label, [(time, column) for column in sleeper[name].values.T[kept]])
             for name, (what, unit) in OF_SLEEPERS.items() if name in sleeper]
    return [one for one in found if one]


def mark(panel: Axes, marks: collections.abc.Mapping[str, float]) -> None:
    """Octaves on the axis, and the frequencies of `marks`, Hz, that it contains."""
    low, high = panel.get_xlim()
    octaves = [one for one in OCTAVES if low < one < high]
    panel.set_xticks(octaves, [f"{one:g}" for one in octaves])
    panel.set_xticks([], minor=True)
    for name, target in marks.items():
        if low < target < high:
            panel.axvline(target, color="0.4", lw=0.8, ls=":")
            panel.text(target, 0.97, f"{name} = {target:.3g} Hz", va="top", ha="left", fontsize=8,
                       transform=panel.get_xaxis_transform())


def draw(lines: collections.abc.Sequence[Bands], title: str,
         marks: collections.abc.Mapping[str, float] | None = None) -> plt.Figure:
    """A panel for each quantity, a line for each label in it; `marks`: frequencies, Hz, by their
    names."""
    axes = list(dict.fromkeys(one.axis for one in lines))
    figure, grid = plt.subplots(len(axes), 1, sharex=True, squeeze=False, layout="constrained",
                                figsize=(9, 1.2 + 2.5 * len(axes)))
    for panel, axis in zip(grid[:, 0], axes):
        mine = [one for one in lines if one.axis == axis]
        for number, one in enumerate(mine):
            panel.step(one.middle, signals.levels(one.rms, one.unit), where="mid", lw=1.4,
                       color=f"C{number}", ls=panels.LINES[number], label=one.label)
        panel.set(ylabel=axis, xscale="log")
        panel.margins(y=0.2)  # space for the names of marks
        mark(panel, marks or {})
        panel.grid(alpha=0.3)
        panels.legend_above(panel, columns=2)
    grid[-1, 0].set_xlabel("midband frequency of third octaves (Hz)")
    figure.suptitle(panels.wrapped(title, 9), fontsize=10)
    return figure
