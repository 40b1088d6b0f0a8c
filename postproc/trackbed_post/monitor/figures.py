"""Pictures of a table of passages, and of one passage."""
import csv

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import figure_csv, read
from trackbed_post.monitor import displacement
from trackbed_post.monitor.trends import AVERAGED, QUANTITIES
from trackbed_post.panels import UP


def table_of(path):
    """Columns of a table of passages as arrays, sorted by their begin."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = sorted(csv.DictReader(file), key=lambda row: row["begin"])
    texts = ("file", "begin", "train", "remarks")
    try:
        return {name: np.array([row[name] if name in texts else float(row[name]) for row in rows])
                for name in (rows[0] if rows else [])}
    except (ValueError, TypeError):
        raise read.Unreadable(f"{path} was changed by another program; choose another folder") \
            from None


def averaged(values, trusted, count=AVERAGED):
    """Mean of up to `count` values around each, of those that are trusted."""
    known = np.isfinite(values) & trusted
    kernel = np.ones(count)
    total = np.convolve(np.where(known, values, 0), kernel, "same")[:len(values)]
    number = np.convolve(known.astype(float), kernel, "same")[:len(values)]
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def trends(table, wavelengths):
    """Peak and indicators over the passages, with a moving mean for each train."""
    figure, panels = plt.subplots(len(QUANTITIES), 1, sharex=True, figsize=(10, 8))
    for number, name in enumerate(sorted(set(table["train"]))):
        rows = np.flatnonzero(table["train"] == name)
        for panel, quantity in zip(panels, QUANTITIES):
            values = table[quantity][rows]
            bars = table["deviation_mm"][rows] if quantity == "peak_mm" else None
            trusted = table["misfit"][rows] <= displacement.TRUSTED
            panel.errorbar(rows[trusted], values[trusted], None if bars is None else bars[trusted],
                           fmt=".", ms=3, lw=0.5, color=f"C{number}",
                           label=plain(name) or "no library")
            drawn = [(panel.plot(rows[~trusted], values[~trusted], "x", ms=3, color=f"C{number}"),
                      "misfit")]
            if len(rows) >= AVERAGED:
                drawn.append((panel.plot(rows, averaged(values, trusted), color=f"C{number}", lw=1),
                              f"mean of {AVERAGED} passages"))
            for (line,), what in drawn:
                figure_csv.name(line, f"{plain(name) or 'no library'}, {what}")
    for panel, label in zip(panels, QUANTITIES.values()):
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
    panels[0].legend(fontsize=8)
    panels[0].set_title(f"Passages; indicators of wavelengths of {max(wavelengths):g} to "
                        f"{min(wavelengths):g} m; lines: mean of {AVERAGED} passages of a train; "
                        "x: a misfit", fontsize=10)
    panels[-1].set_xlabel("number of the passage")
    return figure


def plain(name):
    """Without what matplotlib takes for mathematics."""
    return name.replace("$", r"\$")


def passage(signal, speed, name, noise=None):
    """Acceleration and displacement of a passage, a measured.Signal."""
    found = displacement.reconstruct(signal.values, signal.rate, speed, doubtful=signal.doubtful,
                                     noise=noise)
    time, signal = signal.time - signal.time[0], signal.values
    figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(10, 6))
    upper.plot(time, signal, lw=0.5)
    upper.set_ylabel("acceleration (m/s2)")
    lower.plot(time, 1e3 * found.displacement, lw=0.8, label="displacement")
    lower.fill_between(time, 1e3 * (found.displacement - found.deviation),
                       1e3 * (found.displacement + found.deviation), alpha=0.3,
                       label="standard deviation")
    lower.plot(time, np.where(found.at_rest, 0.0, np.nan), lw=2, color="C2", label="at rest")
    lower.set_ylabel(f"displacement ({UP})")
    lower.set_xlabel("time (s)")
    lower.legend(fontsize=8)
    peak, deviation = found.peak
    upper.set_title(f"{plain(name)}: {speed:.1f} m/s, largest displacement {1e3 * peak:.3g} mm, "
                    f"standard deviation {1e3 * deviation:.2g} mm, misfit {found.misfit:.2g}",
                    fontsize=10)
    for panel in (upper, lower):
        panel.grid(alpha=0.3)
    return figure
