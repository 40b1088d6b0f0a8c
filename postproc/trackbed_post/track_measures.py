"""Quantities of a track alone that are derived from its histories."""
import numpy as np

from trackbed_post import signals

BANDS = {"D1": (3.0, 25.0), "D2": (25.0, 70.0), "D3": (70.0, 150.0)}  # m, EN 13848-1
D1 = BANDS["D1"]
ENDS = 3          # longest wavelengths: a longer record is judged without one of them at each end
ORDER = 4         # of the Butterworth prototype; -3 dB at both limits


def band(values, step, wavelengths=D1):
    """The part of `values`, sampled every `step` m, between two wavelengths. The filter has the
    magnitude of a Butterworth band pass and no phase shift:
        |H|^2 = 1/(1 + W^(2n)),  W = (k^2 - k1 k2)/(k (k2 - k1)),  k = 1/wavelength.
    The linear trend is removed first; the ends are continued by their mirror image."""
    x = np.arange(len(values)) * step
    even = values - np.polyval(np.polyfit(x, values, 1), x)
    mirrored = np.concatenate([even[::-1], even, even[::-1]])
    k = np.fft.rfftfreq(len(mirrored), step)
    low, high = 1 / max(wavelengths), 1 / min(wavelengths)
    gain = np.zeros_like(k)
    w = (k[1:]**2 - low * high) / (k[1:] * (high - low))
    gain[1:] = 1 / np.sqrt(1 + w**(2 * ORDER))
    passed = np.fft.irfft(np.fft.rfft(mirrored) * gain, len(mirrored))
    return passed[len(values):2 * len(values)]


def even_places(x: np.ndarray) -> np.ndarray:
    """Places, m, from the first to the last of these, evenly spaced at their median distance."""
    return np.linspace(x[0], x[-1], int(round((x[-1] - x[0]) / np.median(np.diff(x)))) + 1)


def inner(x: np.ndarray, longest: float = D1[1]) -> slice:
    """Those of even places, m, that the continuation of the ends by the filter of a band does not
    reach, whose longest wavelength is given, m; all of a short record."""
    rows = int(round(longest / (x[1] - x[0]))) if x[-1] - x[0] >= ENDS * longest else 0
    return slice(rows, len(x) - rows)


def loaded_rail(x, height, begin, end, wavelengths=D1):
    """(x, m; part of these wavelengths, m, of the path of a wheel, m) between two places, as
    measured by a loaded axle. The height of a wheel is that of the loaded rail except for the
    approach of wheel and rail, a few um."""
    on = (x >= begin) & (x <= end)
    # Rows are equidistant in time, but not in x while the train brakes; at a stop x is repeated.
    there, first = np.unique(x[on], return_index=True)
    if len(there) < 8:
        return np.array([]), np.array([])
    even = even_places(there)
    return even, band(np.interp(even, there, height[on][first]), even[1] - even[0], wavelengths)


def levels_of_rail(x, height, begin, end, where=""):
    """Name -> (value, unit): level of the loaded rail under a wheel between two places in D1, and
    in the longer bands that fit between them. `where`: words that state the places."""
    found = {}
    for name, (low, high) in BANDS.items():
        places, path = loaded_rail(x, height, begin, end, (low, high))
        if len(path) and (name == "D1" or high <= end - begin):
            found[f"level of the loaded rail under the first wheel{where}, {name} ({low:g} to "
                  f"{high:g} m), standard deviation"] = \
                (1e3 * path[inner(places, high)].std(), "mm")
    return found


def receptance(time, force, rail, least=0.02):
    """(Hz, m/N complex) of `rail` (m, downwards) under one impact (N): the ratio of both transforms
    where the force exceeds `least` of its largest value. Both start at rest; a rail that still
    moves at the end of the histories falsifies low frequencies."""
    step = signals.step_of(time)
    frequency = np.fft.rfftfreq(len(time), step)
    of_force, of_rail = np.fft.rfft(force), np.fft.rfft(rail)
    reliable = (np.abs(of_force) > least * np.abs(of_force).max()) & (frequency > 0)
    # Beyond the first zero of a half sine the transform is only rounding noise of the rows.
    first_gap = np.argmax(~reliable[1:]) + 1 if not reliable[1:].all() else len(reliable)
    use = np.arange(1, first_gap)
    return frequency[use], of_rail[use] / of_force[use]
