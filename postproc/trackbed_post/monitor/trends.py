"""Change of peak and indicators over many passages: per month and per degree, and alarms.

Indicators grow with the speed: of each train only passages at similar speeds count, and what their
speed may explain is taken out. If they are enough, a line is fitted over time and temperature,
robustly, as single passages may be far off (soft L1 loss of scipy.optimize.least_squares). An alarm
needs that the latest passages differ from the first ones by more than a part of these and by more
than the scatter explains; temperature is taken out before.
"""
import dataclasses
import datetime
import math

import numpy as np
import scipy.optimize

from trackbed_post.monitor import displacement

QUANTITIES = {"peak_mm": "largest displacement (mm)",
              "displacement_mm": "indicator of displacement (mm)",
              "acceleration_m_s2": "indicator of acceleration (m/s2)"}
AVERAGED = 7      # passages in a mean or median, as in the thesis
LEAST = 2 * AVERAGED
SIMILAR = 0.1     # largest difference of a speed from the usual one, relative to it
FASTER = 0.01     # relative, of the slowest and the fastest tenth, or speed is left out
STEEPEST = 3.0    # largest power of the speed with which a quantity grows
WARMER = 5.0      # degrees between the coldest and the warmest tenth, or temperature is left out
CHANGED = 0.2     # least change of the latest median, relative to the first
ERRORS = 4.0      # least change over its standard error
MONTH = 365.25 / 12  # days


@dataclasses.dataclass(frozen=True)
class Trend:
    """Of a quantity of a train: number of passages, mean, change in a month and in a degree (not a
    number if dates or temperatures are not known), standard deviation of a passage, relative change
    of the latest median to the first, and whether it is an alarm."""
    train: str
    quantity: str
    passages: int
    mean: float
    per_month: float
    per_degree: float
    scatter: float
    change: float
    alarm: bool


NAMES = [field.name for field in dataclasses.fields(Trend)]


def days_of(begins):
    """Days since the first date; not numbers where they are no dates of ISO 8601."""
    found = np.full(len(begins), math.nan)
    first = None
    for row, text in enumerate(begins):
        try:
            time = datetime.datetime.fromisoformat(text)
            first = first or time
            found[row] = (time - first).total_seconds() / 86400
        except (ValueError, TypeError):
            pass  # of another zone than the first, or no date
    return found


def usual_speed(speeds):
    """The one with the most others within SIMILAR of it."""
    return max(speeds, key=lambda one: np.sum(np.abs(speeds - one) <= SIMILAR * one))


def trends(table):
    """Trends of a table of passages (figures.table_of), sorted by their begin. Passages without a
    number are left out, those without date or temperature if enough others are left."""
    found = []
    for train in sorted(set(table["train"]) - {"unknown"}):
        rows = ((table["train"] == train) & (table["misfit"] <= displacement.TRUSTED)
                & np.isfinite([table[name] for name in ("speed_m_s", *QUANTITIES)]).all(axis=0))
        if rows.any():
            usual = usual_speed(table["speed_m_s"][rows])
            rows &= np.abs(table["speed_m_s"] - usual) <= SIMILAR * usual
        for known in (np.isfinite(days_of(table["begin"])), np.isfinite(table["temperature_C"])):
            if (rows & known).sum() >= max(LEAST, rows.sum() / 2):
                rows &= known
        if rows.sum() < LEAST:
            continue
        days, warmth = days_of(table["begin"][rows]), table["temperature_C"][rows]
        found += [trend(train, quantity, table[quantity][rows], days, warmth,
                        table["speed_m_s"][rows]) for quantity in QUANTITIES]
    return found


def fitted(columns, values):
    """Factors of the columns by a robust fit."""
    system = np.column_stack(columns)
    scale = np.median(np.abs(values - np.median(values))) or 1.0
    start = np.zeros(len(columns))
    start[0] = np.median(values)
    return scipy.optimize.least_squares(lambda x: (system @ x - values) / scale, start,
                                        loss="soft_l1").x


def without_speed(values, speeds):
    """Values at the mean speed. They grow with a power of the speed, at most STEEPEST, which takes
    all that it can explain, also where the speed changes together with the time: a drift of the
    speed is no change of the track."""
    if np.ptp(np.quantile(speeds, (0.1, 0.9))) < FASTER * speeds.mean():
        return values
    ratio, usual = speeds / speeds.mean(), np.median(values)
    scale = np.median(np.abs(values - usual)) or 1.0
    power = scipy.optimize.least_squares(
        lambda x: (x[0] * ratio**x[1] - values) / scale, [usual, STEEPEST / 2], loss="soft_l1",
        bounds=([-np.inf, 0], [np.inf, STEEPEST]), x_scale=[abs(usual) or 1.0, 1.0]).x[1]
    return values / ratio**power


def trend(train, quantity, values, days, warmth, speeds):
    values = without_speed(values, speeds)
    dated = bool(np.all(np.isfinite(days)) and np.ptp(days) > 0)
    time = days / MONTH if dated else np.arange(len(values))
    columns = [np.ones(len(values)), time - time.mean()]
    known = bool(np.all(np.isfinite(warmth)) and
                 np.ptp(np.quantile(warmth, (0.1, 0.9))) >= WARMER)
    if known:
        columns.append(warmth - warmth.mean())
    fit = fitted(columns, values)
    residual = values - np.column_stack(columns) @ fit
    scatter = 1.4826 * float(np.median(np.abs(residual)))  # of a normal distribution
    level = values - (fit[-1] * columns[-1] if known else 0)
    first, latest = np.median(level[:AVERAGED]), np.median(level[-AVERAGED:])
    error = 1.25 * scatter * np.sqrt(2 / AVERAGED)  # of a difference of medians
    change = float(latest / first - 1) if first > 0 else math.nan
    return Trend(train, quantity, len(values), float(fit[0]),
                 float(fit[1]) if dated else math.nan, float(fit[-1]) if known else math.nan,
                 scatter, change,
                 bool(abs(change) > CHANGED and abs(latest - first) > ERRORS * error))
