"""Numbers of the study demfem that its lines give, of a new run as of stored files."""
import numpy as np
import scipy.signal

from .demfem_model import CYCLES, FORCES, PEAK, PERIOD, RAIL, RAMP

LIMIT = 1.0  # kN, below which the study finds equal fractions of both shapes
RAISED = {"rail": {place: f"track_rail_{place}" for place in RAIL},
          "lowest sleeper": {"": "track_lowest"}}  # figures of displacements over time


def derive(numbers):
    """Adds numbers to those of the runs."""
    lines = numbers.lines
    for figure, add in (("settlement", add_rebound), ("loop", add_stress),
                        ("forces", add_fractions), ("tension", add_peaks),
                        ("track_compression", add_compression)):
        for run, curve in lines.of(figure).items():
            add(numbers, run, *map(np.array, curve))
    for what, figures in RAISED.items():
        add_growth(numbers, what, [lines.of(figure) for figure in figures.values()])


def add_rebound(numbers, run, time, settled):
    """How far the sleepers rise in the first cycle, mm."""
    numbers.put(run, "rebound at the start", -settled[time <= PERIOD].min(), "mm")


def add_stress(numbers, run, _, stress):
    """Range of the stress below a sleeper in the last cycle, kPa. Points of all cycles are equally
    many; the run with granite has one cycle only."""
    if run == "bed_granite":
        return
    last = stress[-(len(stress) // CYCLES["cycles"]):]
    numbers.put(run, "least stress of the last cycle", last.min(), "kPa")
    numbers.put(run, "largest stress of the last cycle", last.max(), "kPa")


def add_fractions(numbers, run, middle, fraction):
    """Contacts below the limit and in each of its bins, %; the first has all smaller forces too."""
    below = middle < LIMIT
    numbers.put(run, "contacts below the limit", fraction[below].sum(), "%")
    for k in np.flatnonzero(below):
        numbers.put(run, f"contacts, bin {k + 1}", fraction[k], "%")


def bins():
    """Numbers of the bins below the limit."""
    return range(1, 1 + int(np.sum(FORCES[1:] < LIMIT * 1.001)))


def add_peaks(numbers, run, x, tension):
    """Places of the peaks of the tension along the track, m."""
    for k, peak in enumerate(scipy.signal.find_peaks(tension, prominence=PEAK)[0]):
        numbers.put(run, f"tension, x of peak {k + 1}", x[peak], "m")


def add_compression(numbers, run, x, compression):
    """Peaks of the compression below stones; its largest value in the middle third, MPa."""
    peaks = scipy.signal.find_peaks(compression, prominence=PEAK)[0]
    numbers.put(run, "compression, median of peaks", np.median(compression[peaks]), "MPa")
    numbers.put(run, "compression, median distance of peaks", np.median(np.diff(x[peaks])), "m")
    middle = compression[(x > 2) & (x < 4)].max()
    numbers.put(run, "compression, middle over the median of peaks",
                middle / np.median(compression[peaks]), "-")
    numbers.put(run, "compression, stiff end over soft end",
                compression[x > 4.8].mean() / compression[x < 1.2].mean(), "-")


def add_growth(numbers, what, curves):
    """Displacement, mean over places, mm: in the first axle spacing after the ramp, in the last one
    and in the last but one, and the growth to the last one."""
    for run in curves[0]:
        first, before, last = [], [], []
        for curve in curves:
            time, down = map(np.array, curve[run])
            for found, begin in ((first, RAMP), (before, time[-1] - 2 * PERIOD),
                                 (last, time[-1] - PERIOD)):
                found.append(down[(time > begin) & (time <= begin + PERIOD)].mean())
        numbers.put(run, f"{what}, displacement in the first axle spacing", np.mean(first), "mm")
        numbers.put(run, f"{what}, displacement in the last axle spacing", np.mean(last), "mm")
        numbers.put(run, f"{what}, growth", np.mean(last) - np.mean(first), "mm")
        numbers.put(run, f"{what}, growth in one axle spacing", np.mean(last) - np.mean(before),
                    "mm")
        if len(curves) > 1:
            for k, place in enumerate(RAIL):
                numbers.put(run, f"{what}, {place}, first", first[k], "mm")
                numbers.put(run, f"{what}, {place}, growth", last[k] - first[k], "mm")
                numbers.put(run, f"{what}, {place}, growth in one axle spacing",
                            last[k] - before[k], "mm")
