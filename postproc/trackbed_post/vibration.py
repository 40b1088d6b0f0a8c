"""Vibrations: a history as signal, spectrum and third octaves, beside a measured signal.

Of a run in stages the last passage is used. What is computed: docs/postproc.md.
"""
import collections.abc
import dataclasses
import pathlib

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import axles, curves, measured, panels, read, signals, track_figures, write

LEAST_ROWS = 32
OF_SLEEPERS = ("sleeper/", "seat/", "rail/")
STYLES = tuple({"color": f"C{k}", "ls": line} for k, line in enumerate(panels.LINES[:2]))


def rows_of_passage(every: read.Quantities, folder: pathlib.Path | str) -> slice:
    """Rows of the histories that belong to the last passage; all rows of a track alone."""
    if "history/stage" not in every:
        return slice(None)
    return read.results(folder).passage()


def between_run_ins(x: np.ndarray, folder: pathlib.Path | str) -> np.ndarray:
    """Whether each wheel is where the track has its given properties, [time, wheel]."""
    deck = read.origin(folder)[1]
    run_in = track_figures.run_in_of(deck)
    return (x >= run_in) & (x <= deck["track"]["length"] - run_in)


def computed(folder: pathlib.Path | str, quantity: str, place: int) -> measured.Signal:
    """The history; of wheels of a track alone, only between its run-ins. `place` -1: of sleepers on
    a bed the middle one, since those at the ends are not judged, otherwise the one with the largest
    standard deviation."""
    every = read.datasets(folder)
    quantity = quantity.removeprefix("history/")
    name = f"history/{quantity}"
    if name not in every or name == "history/time":
        known = sorted(one.removeprefix("history/") for one, item in every.items()
                       if one.startswith("history/") and item.unit in signals.REFERENCES)
        raise read.Unreadable(f"{folder} has no history {quantity}; it has {', '.join(known)}")
    unit = every[name].unit
    if unit not in signals.REFERENCES:
        raise read.Unreadable(f"{quantity} is in {unit}; levels are defined for "
                              f"{', '.join(signals.REFERENCES)}")
    rows = rows_of_passage(every, folder)
    values = every[name].values[rows]
    values = values.reshape(len(values), -1)
    kept = np.isfinite(values).all(axis=1)  # no train: not a number
    time, values = every["history/time"].values.ravel()[rows][kept], values[kept]
    if not -1 <= place < values.shape[1]:
        raise read.Unreadable(f"--place {place}: {quantity} has the places 0 to "
                              f"{values.shape[1] - 1}")
    on = np.ones(values.shape, dtype=bool)
    if quantity.startswith("wheel/") and "history/stage" not in every:
        on = between_run_ins(every["history/wheel/x"].values.reshape(len(kept), -1)[kept], folder)
    if place < 0 and "history/stage" in every and quantity.startswith(OF_SLEEPERS):
        place = values.shape[1] // 2
    elif place < 0:
        place = int(np.argmax([np.std(column[there]) if there.any() else -1
                               for column, there in zip(values.T, on.T)]))
    # Trains begin in static equilibrium, also where their wheels are not on the track yet.
    static = float(values[0, place]) if quantity == "wheel/force" else None
    time, values = time[on[:, place]], values[on[:, place]]
    if len(time) < LEAST_ROWS:
        raise read.Unreadable(f"{quantity} has {len(time)} usable rows; at least {LEAST_ROWS} are "
                              "needed; shorten output.history_interval")
    if signals.step_of(time) is None:
        raise read.Unreadable(f"the {len(time)} rows of {quantity} are unevenly spaced; give an "
                              "output.history_interval that is a multiple of the time step or "
                              "window")
    alone = values.shape[1] == 1
    where = curves.labels_of(folder, name)[place] or ("" if alone else f"place {place}")
    if quantity.startswith("wheel/"):
        x = every["history/wheel/x"].values
        where = panels.axle(place, axles.on_two_rails(x.reshape(len(x), -1)))
    label = ", ".join(filter(None, (pathlib.Path(folder).name, quantity, where)))
    return measured.Signal(label, time, values[:, place], unit, (), static=static)


def numbers(signal: measured.Signal) -> dict[str, tuple[float, str]]:
    """Name -> (value, unit)."""
    middle, bands = signals.third_octaves(signal.time, signal.values)
    moving = signal.values - signal.values.mean()
    found = {"mean": (signal.values.mean(), signal.unit),
             "largest magnitude of the difference from the mean": (np.abs(moving).max(),
                                                                   signal.unit),
             "root mean square of the difference from the mean": (moving.std(), signal.unit)}
    if len(middle):
        strongest = int(np.argmax(bands))
        found["strongest third octave"] = (middle[strongest], "Hz")
        found["its root mean square"] = (bands[strongest], signal.unit)
    if signal.unit == "m/s2":
        found["root mean square weighted by Wk (ISO 2631-1)"] = (
            signals.weighted_rms(signal.time, signal.values), "m/s2")
        found["root mean square weighted by Wb (EN 12299)"] = (
            signals.weighted_rms(signal.time, signal.values, signals.weighting_wb), "m/s2")
        if signals.resolves_comfort(signal.time):
            largest, dose = signals.transient(signal.time, signal.values)
            found["largest weighted (Wk) root mean square in 1 s, MTVV"] = (largest, "m/s2")
            found["vibration dose value (Wk), VDV"] = (dose, "m/s1.75")
        comfort = signals.continuous_comfort(signal.time, signal.values)
        if len(comfort):
            found[f"largest CC_z of {len(comfort)} intervals of 5 s (EN 12299)"] = (
                comfort.max(), "m/s2")
        mean = signals.mean_comfort(comfort)
        if len(mean):
            found[f"largest vertical part of N_MV of {5 * len(mean)} minutes (EN 12299)"] = (
                mean.max(), "-")
    return found


def load_factor(signal: measured.Signal) -> dict[str, tuple[float, str]]:
    """Of a history of forces: the largest one over the static load of the wheel or, of other
    forces, over the mean. A measured force without its trend has neither."""
    if signal.unit != "N":
        return {}
    mean = abs(signal.values.mean())
    load, what = (signal.static, "static wheel load") if signal.static else (mean, "mean force")
    if not load:
        return {}
    return {f"dynamic load factor, largest force over the {what} of {load / 1e3:.4g} kN": (
        np.abs(signal.values).max() / load, "-")}


def draw(shown: collections.abc.Sequence[measured.Signal],
         low_pass: signals.LowPass) -> plt.Figure:
    """Three panels; the name of the filter is on the axis of what it filters."""
    figure, (history, lines, bands) = plt.subplots(3, 1, figsize=(9, 10), layout="constrained")
    unit = shown[0].unit
    names = {low_pass.name_for(signal.time) for signal in shown}
    for signal, style in zip(shown, STYLES):
        moving = dataclasses.replace(signal, values=signal.values - signal.values.mean())
        history.plot(signal.time, low_pass(signal.time, moving.values), lw=0.8, label=signal.name,
                     **style)
        frequency, amplitude = signals.spectrum(signal.time, moving.values)
        resolved = frequency * len(signal.time) >= signal.rate * (1 - signals.EVEN_STEP)
        lines.semilogx(frequency[resolved],
                       signals.levels(amplitude[resolved] / np.sqrt(2), unit), lw=0.8,
                       label=signal.name, **style)
        middle, band = signals.third_octaves(signal.time, signal.values)
        if len(middle):
            bands.step(middle, signals.levels(band, unit), where="mid", label=signal.name, **style)
    history.set(xlabel="time, s", ylabel=f"difference from the mean, {unit}\n{'; '.join(names)}")
    lines.set(xlabel="frequency, Hz",
              ylabel=f"root mean square of a line,\ndB re {signals.REFERENCES[unit]:g} {unit}")
    bands.set(xlabel="midband frequency, Hz", xscale="log",
              ylabel=f"third octaves, dB re {signals.REFERENCES[unit]:g} {unit}")
    panels.plain_ticks(lines)
    panels.plain_ticks(bands)
    for panel in (history, lines, bands):
        panel.grid(alpha=0.3)
        panels.legend_above(panel, columns=2)
    return figure


def aligned(signal: measured.Signal, beside: measured.Signal,
            shift: float | None) -> measured.Signal:
    """A measured signal over the computed one: its time moved by `shift`, s, or without one to the
    largest correlation of both envelopes. Its name, and with it the legend, states which."""
    how, remarks = "--shift", signal.remarks
    if shift is None:
        how = "largest correlation of the envelopes"
        shift, likeness = signals.shift_between(beside.time, beside.values, signal.time,
                                                signal.values)
        remarks = (*remarks, f"{how}: {likeness:.2f} (1: of the same shape)")
    return dataclasses.replace(signal, time=signal.time + shift, remarks=remarks,
                               name=f"{signal.name}, shifted by {shift:.4g} s ({how})")


def table_of(shown: collections.abc.Sequence[measured.Signal]) -> str:
    """CSV: midband frequency; root mean square and level of each signal where its record resolves
    the band."""
    of = [dict(zip(*signals.third_octaves(one.time, one.values))) for one in shown]
    rows = ["midband_Hz," + ",".join(f"rms_{i},level_{i}_dB" for i in range(len(shown)))]
    for middle in sorted(set().union(*of)):
        cells = [f"{middle:.6g}"]
        for bands in of:
            cells += [f"{bands[middle]:.6g}", f"{signals.levels(bands[middle], shown[0].unit):.2f}"
                      ] if middle in bands else ["", ""]
        rows.append(",".join(cells))
    return "\n".join(rows) + "\n"


def draw_into(results: pathlib.Path | str, folder: write.Folder, quantity: str, place: int = -1,
              other: str = "", cut_off: float = 100.0, shift: float | None = None) -> None:
    """Picture and tables of a history such as sleeper/acceleration of one run (its folder);
    `place`: number of its column, -1 as for computed(); `other`: FILE[:COLUMN] of a measured signal
    (measured.py), whose time is moved by `shift`, s, as aligned() describes; `cut_off`, Hz, of the
    low pass."""
    if not cut_off > 0:
        raise read.Unreadable(f"--cut-off {cut_off:g}: must be above 0 Hz")
    shown = [computed(results, quantity, place)]
    if other:
        shown.append(measured.detrended(measured.load(other)))
        if shown[1].unit != shown[0].unit:
            raise read.Unreadable(f"{other} is in {shown[1].unit}, {quantity} in {shown[0].unit}")
        shown[1] = aligned(shown[1], shown[0], shift)
    elif shift is not None:
        raise read.Unreadable("--shift: moves the signal of --measured, which is not given")
    text = ""
    for signal in shown:
        text += f"{signal.name}\n" + "".join(f"  remark: {one}\n" for one in signal.remarks)
        found = numbers(signal) | (load_factor(signal) if signal is shown[0] else {})
        wide = max(map(len, found)) + 1
        text += "".join(f"  {name:{wide}} {value:10.4g} {unit}\n"
                        for name, (value, unit) in found.items())
    folder.picture("vibration", draw(shown, signals.LowPass(cut_off)))
    folder.file("vibration.csv", table_of(shown))
    folder.table("vibration.txt", text)
