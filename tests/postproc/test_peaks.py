"""Tests that side lobes of a train's own frequencies are not called peaks."""
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest
import test_postproc
from trackbed_post import bed_on_ground, frequencies, read, signals

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


def test_how_far_a_peak_may_be_from_its_frequency():
    marks = {"v/L_c": 2.34, "v/L_w": 17.34, "v/s": 74.0}
    assert [frequencies.reach(marks, name) for name in marks] == pytest.approx([0.468, 1.17, 1.17])


def test_the_table_and_the_figure_name_the_same_peaks(runs):
    run = test_postproc.with_train(runs[0], test_postproc.WAGONS[:4], 1)
    time = run.time - run.time[run.passage()][0]
    force = -1e3 * np.sin(2 * np.pi * 20 / 1.8 * time)[:, None] * np.ones((1, 15))
    run = dataclasses.replace(run, sleeper={**run.sleeper, "seat_force": read.Quantity(
        force, "N", "-")})
    text = bed_on_ground.table_of_peaks([run])
    lines = [line.split() for line in text.splitlines() if "seat force" in line]
    assert [line[-2:] for line in lines if line[2] == "v/L_w"] == [["11.10", "Hz"]]
    assert [line[6:12] for line in lines if line[2] != "v/L_w"] == 2 * [
        "no peak that stands out within".split()]
    figure = bed_on_ground.spectra([run])
    rings = [line for line in figure.axes[2].lines if line.get_marker() == "o"]
    assert rings[0].get_xdata() == pytest.approx([11.1]) and len(rings[1].get_xdata()) == 0
    words = [text.get_text() for text in figure.axes[2].get_legend().texts]
    assert words == ["wedge", "peak at a passing frequency"]
    assert [text.get_text() for text in figure.axes[0].texts] == [" v/L_c", " v/L_w", " v/s"]
    plt.close("all")


def test_without_histories_of_wheels_the_spacing_is_marked(runs):
    run = dataclasses.replace(test_postproc.with_train(runs[0], test_postproc.WAGONS, 2), wheel={})
    assert frequencies.of_passage(run) == pytest.approx({"v/s": 20 / 0.6})
