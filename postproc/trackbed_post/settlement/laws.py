"""Laws of settlement, and their fit to settlements that a run has computed.

N counts axles, or cycles of load. All return metres unless they state otherwise.
"""
import dataclasses

import numpy as np

# Li and Selig 1996 (doi:10.1061/(ASCE)0733-9410(1996)122:12(1006)): a, b and m of their law by the
# soil of the subgrade (unified soil classification).
SOILS = {"ML": (0.64, 0.10, 1.7), "MH": (0.84, 0.13, 2.0), "CL": (1.1, 0.16, 2.0),
         "CH": (1.2, 0.18, 2.4)}
LIMITS = (-1.0, 1.0)  # of the exponent in a fit: below 0 settlement ends, 1 is a constant rate
STEPS = 400  # of the exponent in a fit


def shenton(axles, axle_load, lift):
    """Settlement after tamping (Shenton 1985). `axle_load`: t, `lift`: m, by which the track was
    raised."""
    count = np.asarray(axles, dtype=float)
    return 1e-3 * 1.1 * axle_load / 20 * ((0.69 + 0.028 * 1e3 * lift) * count ** 0.2
                                          + 2.7e-6 * count)


def sum_of_powers(count, exponent):
    """Sum of n^-exponent for n from 1 to `count`, rounded: the first terms one by one, the rest by
    Euler and Maclaurin's formula, whose next term is below 1e-13 of it."""
    first, count = 1000, round(count)
    if count <= first:
        return float(np.sum(np.arange(1.0, count + 1) ** -exponent))

    def rest(n):
        integral = np.log(n) if exponent == 1 else n ** (1 - exponent) / (1 - exponent)
        return integral + 0.5 * n ** -exponent - exponent / 12 * n ** (-exponent - 1)
    return float(np.sum(np.arange(1.0, first + 1) ** -exponent) + rest(float(count))
                 - rest(float(first)))


@dataclasses.dataclass(frozen=True)
class Varandas:
    """Settlement of a sleeper by the forces below it (Varandas, Hoelscher, Silva 2014,
    doi:10.1177/0954409712471610): each force settles it the less, the more forces above it have
    come before. `reference` is the settlement by `count` equal forces `force`."""
    alpha: float = 0.6
    beta: float = 0.82
    reference: float = 10e-3  # m
    count: float = 1e6
    force: float = 50e3       # N

    def settlement(self, peaks, passages):
        """m, after `passages` trains of which each brings the forces `peaks`, N. Forces below a
        level F are exceeded k times in a train: the integral over F of F^alpha times the sum of
        n^-beta over k passages."""
        levels = np.concatenate([[0.0], np.sort(np.maximum(peaks, 0))])
        above = len(peaks) - np.arange(len(peaks))  # forces of a train above each interval
        power = self.alpha + 1
        parts = np.diff(levels ** power) / power
        done = sum(part * sum_of_powers(k * passages, self.beta)
                   for part, k in zip(parts, above) if part > 0)
        whole = self.force ** power / power * sum_of_powers(self.count, self.beta)
        return self.reference * done / whole


def li_selig(cycles, ratio, soil):
    """Plastic strain of a cohesive subgrade, -. `ratio`: deviatoric stress under the axle over the
    static strength of the soil."""
    factor, exponent, power = SOILS[soil]
    return 1e-2 * factor * ratio ** power * np.asarray(cycles, dtype=float) ** exponent


def law(count, exponent):
    """((1 + N)^b - 1)/b, for b = 0 ln(1 + N): the law of the program (jump.exponent)."""
    log = np.log1p(np.asarray(count, dtype=float))
    return np.expm1(exponent * log) / exponent if exponent else log


@dataclasses.dataclass(frozen=True)
class Fit:
    """settlement = begin + rate law(N, exponent); `scatter`: root mean square of the residuals."""
    name: str
    exponent: float
    begin: float
    rate: float
    scatter: float

    @property
    def at_limit(self):
        """Whether an exponent beyond LIMITS may fit better: then the counts were too few."""
        return self.exponent in LIMITS

    def at(self, count):
        return self.begin + self.rate * law(count, self.exponent)


def _fit_with(count, settled, exponent, name):
    design = np.column_stack([np.ones(len(count)), law(count, exponent)])
    found, *_ = np.linalg.lstsq(design, settled, rcond=None)
    residual = settled - design @ found
    return Fit(name, float(exponent), float(found[0]), float(found[1]),
               float(np.sqrt(np.mean(residual ** 2))))


def fit(count, settled):
    """The logarithmic law, and the one with the exponent within LIMITS that fits best."""
    exponents = np.linspace(*LIMITS, STEPS + 1)
    best = min((_fit_with(count, settled, b, "power") for b in exponents),
               key=lambda one: one.scatter)
    return [_fit_with(count, settled, 0.0, "logarithm"), best]
