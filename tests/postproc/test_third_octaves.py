"""Levels in third octaves in the figures of beds and tracks, and long bands of a track's level."""
import conftest
import made
import matplotlib.pyplot as plt
import numpy as np
import pytest
from trackbed_post import bed_on_ground, track_measures

TIME = np.arange(0, 4, 1e-3)


def level(amplitude, reference):
    """dB, of a sine."""
    return 20 * np.log10(amplitude / np.sqrt(2) / reference)


def shown(panel):
    """Midband frequency -> level, of the first line."""
    line = panel.lines[0]
    return dict(zip(np.round(line.get_xdata(), 2), line.get_ydata()))


def test_a_bed_shows_the_levels_of_its_sleepers(runs):
    """3 m/s2 at 10 Hz, and 50 m/s2 at 300 Hz, which the filter of other figures takes away."""
    figure = bed_on_ground.levels(runs)
    acceleration, displacement, seat = figure.axes
    assert "dB re 1e-06 m/s2" in acceleration.get_ylabel()
    assert "dB re 1e-12 m" in displacement.get_ylabel() and "1e-06 N" in seat.get_ylabel()
    found = shown(acceleration)
    # The window of a record of 2 s spreads a line: 3 % of its energy is beside the band of 2.3 Hz.
    assert found[10.0] == pytest.approx(level(3, 1e-6), abs=0.2)
    assert found[316.23] == pytest.approx(level(50, 1e-6), abs=0.1)
    assert [line.get_label() for line in acceleration.lines[:2]] == ["wedge", "no_wedge"]
    marks = [text.get_text() for text in acceleration.texts]
    assert "v/L_w = 8 Hz" in marks and not any("v/L_c" in one for one in marks)  # below 5 Hz
    assert "mean over 2 s" in figure.texts[0].get_text()
    plt.close(figure)


def track(folder):
    """Wheels of 60 kN that vary by 5 kN at 20 Hz between the run-ins, and by 50 kN in them."""
    x = 25 * TIME[:, None] - np.array([0.0, 2.5])
    size = np.where((x >= 8) & (x <= 82), 5e3, 50e3)
    made.store(folder / "results.h5", {
        "history/time": (TIME, "s"), "history/wheel/x": (x, "m"), "sleepers/x": ([30.0], "m"),
        "rail/x": ([30.0], "m"),
        "history/wheel/force": (60e3 + size * np.sin(2 * np.pi * 20 * TIME[:, None]), "N"),
        "history/sleeper/displacement": (1e-3 * np.sin(2 * np.pi * 40 * TIME), "m"),
        "history/sleeper/seat_force": (20e3 + 0 * TIME, "N"),
        "history/sleeper/acceleration": (2 * np.sin(2 * np.pi * 40 * TIME), "m/s2")},
        deck='model = "track"\n[track]\nlength = 90.0\nrun_in = 8.0\n', version="0.1.0", ranks=1)
    return folder


def test_a_track_shows_the_levels_of_wheels_and_sleepers(tmp_path):
    ran = conftest.call("figures", track(tmp_path), "-o", tmp_path / "out", "--format", "png,csv")
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "out/third_octaves.png").is_file()
    rows = [row.split(",") for row in
            (tmp_path / "out/third_octaves_lines.csv").read_text(encoding="utf-8").splitlines()]

    def at(name, frequency):
        return next(float(row[-3]) for row in rows[1:] if name in row[2]
                    and abs(float(row[-4]) - frequency) < 0.1)
    # The window of a record of 3 s spreads a line over 1 Hz: 1 % of its energy is beside the band.
    assert at("wheel force", 19.95) == pytest.approx(level(5e3, 1e-6), abs=0.1)
    assert at("acceleration", 39.81) == pytest.approx(level(2, 1e-6), abs=0.1)
    assert at("displacement", 39.81) == pytest.approx(level(1e-3, 1e-12), abs=0.1)


def test_long_bands_need_a_long_track():
    x = np.arange(0, 100, 0.1)
    found = track_measures.levels_of_rail(x, 2e-3 * np.cos(2 * np.pi * x / 50), 0, 100)
    assert len(found) == 2
    value, unit = next(one for name, one in found.items() if "D2 (25 to 70 m)" in name)
    # In the middle of D2; at both ends the record is continued by its mirror image.
    assert unit == "mm" and value == pytest.approx(2 / np.sqrt(2), rel=0.05)
    assert len(track_measures.levels_of_rail(x, 0 * x, 0, 60)) == 1
