"""Tests that side lobes of a train's own frequencies are not called peaks."""
import csv
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest
import test_postproc
from trackbed_post import bed_on_ground, figure_csv, frequencies, read, signals

HERTZ = np.arange(0, 100, 0.05)
LOBES = np.abs(np.cos(np.pi * HERTZ / 2.4))  # 2.4 Hz apart


def test_a_lobe_beside_higher_ones_is_no_peak():
    """Lobes below a hump at 40 Hz that is 20 Hz wide: only the highest one stands out."""
    spectrum = LOBES * np.exp(-((HERTZ - 40) / 10)**2)
    found, = signals.standing_out(spectrum)
    assert HERTZ[found] == pytest.approx(40.8, abs=0.1)
    assert signals.peak_at(HERTZ, spectrum, 40.0, 1.2) == HERTZ[found]
    # 45.6 Hz is the top of a lobe, which `peak_near` would give.
    assert signals.peak_near(HERTZ, spectrum, 45.6, 0.02) == pytest.approx(45.6, abs=0.1)
    assert signals.peak_at(HERTZ, spectrum, 45.6, 1.2) is None


def test_a_peak_among_lobes_is_found_and_a_small_one_is_not():
    hump = np.exp(-((HERTZ - 20) / 8)**2)
    for height, found in ((0.3, True), (0.01, False)):
        spectrum = LOBES * (hump + height * np.exp(-((HERTZ - 74.4) / 1)**2))
        assert (signals.peak_at(HERTZ, spectrum, 74.0, 1.2) is not None) == found


@pytest.mark.parametrize("scale, why", [(1, "not above the lobes beside it"),
                                        (1e-4, "below 2 % of the highest lobe")])
def test_a_lobe_that_is_no_peak_is_not_denied(scale, why):
    """The table states the lobe near a passing frequency, and why it does not count."""
    spectrum = LOBES * (np.exp(-((HERTZ - 40) / 10)**2) * (HERTZ > 47) * scale
                        + np.exp(-((HERTZ - 40) / 10)**2) * (HERTZ <= 47))
    words = bed_on_ground.peak_text((HERTZ, spectrum), 50.0, None, 1.2, "m/s2")
    most = spectrum[np.abs(HERTZ - 50.4) < 1].max()
    assert words.startswith(f"no peak: at most {most:.3g} m/s2 within 1.2 Hz (at 50.")
    assert words.endswith(why)


def test_how_far_a_peak_may_be_from_its_frequency():
    marks = {"v/L_c": 2.34, "v/L_w": 17.34, "v/s": 74.0}
    assert [frequencies.reach(marks, name) for name in marks] == pytest.approx([0.468, 1.17, 1.17])


def test_the_table_and_the_figure_name_the_same_peaks(runs):
    run = test_postproc.with_train(runs[0], test_postproc.WAGONS[:4], 1)
    time = run.time - run.time[run.passage()][0]
    wave = np.sin(2 * np.pi * 20 / 1.8 * time)[:, None] * np.ones((1, 15))
    run = dataclasses.replace(run, sleeper={
        **run.sleeper, "seat_force": read.Quantity(-1e3 * wave, "N", "-"),
        "displacement": read.Quantity(-2e-3 * wave, "m", "-")})
    text = bed_on_ground.table_of_peaks([run])
    lines = [line for line in text.splitlines() if "seat force" in line]
    assert [line.split("Hz", 1)[1].strip() for line in lines if "v/L_w" in line] == [
        "peak at 11.10 Hz, 0.999 kN"]
    assert sum(": at most " in line for line in lines) == 2
    moved, = (line for line in text.splitlines() if "displacement" in line and "v/L_w" in line)
    assert moved.endswith("peak at 11.10 Hz, 2 mm")
    figure = bed_on_ground.spectra([run])
    ring, = (line for line in figure.axes[2].lines if line.get_marker() == "o")
    assert ring.get_xdata() == pytest.approx([11.1])
    words = [text.get_text() for text in figure.axes[2].get_legend().texts]
    assert words == ["wedge", "wedge, peak at a passing frequency",
                     "v/L_c = 2.2 Hz, L_c: distance of bogie centres",
                     "v/L_w = 11.1 Hz, L_w: wheelbase", "v/s = 33.3 Hz, s: sleeper spacing"]
    rows = [row for row in csv.DictReader(figure_csv.of_figure(figure).splitlines())
            if row["line"] == "wedge, peak at a passing frequency"]
    rings = [(row["y axis"], row["x"]) for row in rows]
    assert ("displacement (mm)", "11.1") in rings and ("seat force (kN)", "11.1") in rings
    assert len(rings) == text.count("peak at ")
    assert [text.get_text() for text in figure.axes[0].texts] == [" v/L_c", " v/L_w", " v/s"]
    plt.close("all")


def test_without_histories_of_wheels_the_spacing_is_marked(runs):
    run = dataclasses.replace(test_postproc.with_train(runs[0], test_postproc.WAGONS, 2), wheel={})
    assert frequencies.of_passage(run) == pytest.approx({"v/s": 20 / 0.6})
