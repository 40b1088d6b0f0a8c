"""Tests that lobes of a train's own frequencies are not called peaks."""
import csv
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest
import test_postproc
from trackbed_post import bed_on_ground, figure_csv, frequencies, passing_peaks, read, write

HERTZ = np.arange(0, 100, 0.05)
SPEED = 44.4                                # m/s
VEHICLE = np.array([0, 2.56, 19.0, 21.56])  # m, its axles behind the first one
MARKS = {"v/L_c": SPEED / 19.0, "v/L_w": SPEED / 2.56, "v/s": SPEED / 0.6}


def hump(middle, wide):
    """What a track answers to a single axle, much wider than a lobe."""
    return np.exp(-((HERTZ - middle) / wide)**2)


def spectrum(axles, *humps):
    """(Hz, amplitude) of a train at a place."""
    turns = np.exp(-2j * np.pi * HERTZ[:, None] * axles / SPEED)
    return HERTZ, np.abs(turns.mean(axis=1)) * sum(hump(*one) for one in humps)


def lobes(axles, *humps, marks=None):
    beside = frequencies.RESOLVED * SPEED / np.ptp(axles)
    return passing_peaks.lobes(spectrum(axles, *humps), marks or MARKS, beside)


def peaks(*runs):
    """Of each run the names of the passing frequencies with a peak."""
    return [[name for name, lobe in run.items() if lobe.peak] for run in passing_peaks.judged(runs)]


def test_a_lobe_of_a_single_vehicle_is_no_peak():
    """The lobe at 74 Hz is the highest one in one of both runs, but all lobes are alike."""
    pair = [lobes(VEHICLE, (15, 8), (middle, 10)) for middle in (74.5, 82)]
    assert peaks(*pair) == [[], []]
    words = [run["v/s"].words("m/s2") for run in passing_peaks.judged(pair)]
    for one, run in zip(words, pair):
        assert one.startswith(f"no peak: highest lobe {run['v/s'].amplitude:.3g} m/s2 within 1.2 ")
        assert one.endswith(" times the largest amplitude beside it")


def test_the_lines_of_a_long_train_are_peaks():
    """Between two lines, which are v/L_v apart, there are side lobes of a fifth of their height."""
    train = np.concatenate([VEHICLE + 25.0 * number for number in range(10)])
    found = lobes(train, (10, 20), (75, 10), marks={"v/L_v": SPEED / 25.0} | MARKS)
    assert peaks(found) == [["v/L_v", "v/L_w", "v/s"]], "no line is near v/L_c"
    assert found["v/L_c"].ratio < 1
    line = found["v/s"].frequency * 25.0 / SPEED
    assert line == pytest.approx(round(line), abs=0.05)
    assert 3 < found["v/s"].ratio < 7


def test_a_peak_among_lobes_is_found_and_a_small_one_is_not():
    for height, found in ((0.3, ["v/s"]), (0.01, [])):
        frequency, amplitude = spectrum(VEHICLE, (20, 8))
        amplitude = amplitude + height * np.exp(-((HERTZ - 74.4) / 0.3)**2)
        lobe = passing_peaks.lobes((frequency, amplitude), {"v/s": 74.0}, 4.1)
        assert peaks(lobe) == [found]


@pytest.mark.parametrize("ratios, found", [
    ((1.4,), [False]), ((1.6,), [True]), ((1.4, 1.6), [True, True]), ((1.2, 1.6), [False, True])])
def test_two_runs_are_judged_together(ratios, found):
    """A difference is stated only where one run is clearly above the limit, the other below."""
    runs = [{"v/s": passing_peaks.Lobe(74.0, 1.0, ratio, True, 1.2)} for ratio in ratios]
    assert [run["v/s"].peak for run in passing_peaks.judged(runs)] == found


@pytest.mark.parametrize("ratio, high, words", [
    (1.24, True, "no peak: highest lobe 0.2 kN within 1.2 Hz (at 74.00 Hz), 1.24 times the"),
    (1.4999, True, "no peak: highest lobe 0.2 kN within 1.2 Hz (at 74.00 Hz), 1.49 times the"),
    (1.5, True, "peak at 74.00 Hz, 0.2 kN, 1.50 times the"),
    (np.nan, True, "no peak: highest lobe 0.2 kN within 1.2 Hz (at 74.00 Hz), with nothing beside"),
    (0.0, True, "no peak: at most 0.2 kN within 1.2 Hz (at 74.00 Hz), on the flank of a lobe"),
    (3.0, False, "(at 74.00 Hz), below 2% of the largest amplitude"),
    (3.0, True, "peak at 74.00 Hz, 0.2 kN, 3.0 times the largest amplitude beside it"),
    (np.inf, True, "peak at 74.00 Hz, 0.2 kN, more than 10 times the largest")])
def test_the_table_states_the_lobe_and_why_it_does_not_count(ratio, high, words):
    lobe, = passing_peaks.judged([{"v/s": passing_peaks.Lobe(74.0, 0.2, ratio, high, 1.2)}])
    assert words in lobe["v/s"].words("kN")


def test_the_flank_of_a_lobe_is_no_lobe():
    lobe = passing_peaks.lobe_near((HERTZ, hump(40, 3)), 44.0, 1.0, 4.1)
    assert (lobe.ratio, lobe.frequency) == (0.0, pytest.approx(43.0))
    assert passing_peaks.lobe_near((HERTZ, hump(40, 3)), 104.0, 1.0, 4.1) is None


def test_runs_of_different_speeds_are_judged_each_by_itself(runs, monkeypatch):
    found = [{"v/s": passing_peaks.Lobe(74.0, 1.0, ratio, True, 1.2)} for ratio in (1.4, 1.6)]
    assert [run["v/s"].peak for run in passing_peaks.judged(found, alike=False)] == [False, True]
    assert frequencies.alike(MARKS, dict(MARKS)) and not frequencies.alike(
        MARKS, {name: 1.1 * target for name, target in MARKS.items()})
    assert not frequencies.alike(MARKS, {"v/s": MARKS["v/s"]})
    fast = dataclasses.replace(runs[1], deck={**runs[1].deck, "load": {
        **runs[1].deck["load"], "speed": 30.0}})
    given = []
    monkeypatch.setattr(passing_peaks, "judged", lambda found, alike: given.append(alike))
    for other in (runs[1], fast):
        bed_on_ground.peaks_of([runs[0], other], "seat_force", {})
    assert given == [True, False]


def test_a_maximum_near_two_passing_frequencies_is_stated_at_the_nearest():
    found = passing_peaks.lobes((HERTZ, hump(40, 0.3) + 0.1 * hump(37, 0.3)),
                                {"v/L_c": 41.0, "v/s": 39.5, "v/L_v": 20.0}, 4.1)
    assert found["v/L_c"].stated_at == "v/s" and not found["v/s"].stated_at
    assert peaks(found) == [["v/s"]]
    text = passing_peaks.judged([found])[0]["v/L_c"].words("kN")
    assert text == "no peak of its own: the same maximum as at v/s, which is nearer"


def test_frequencies_that_the_record_does_not_distinguish_have_no_peak():
    """The highest lobe near both is clear, but may be either's."""
    spectrum, marks = (HERTZ, hump(40, 0.05) + hump(39.5, 0.05)), {"v/L_c": 40.0, "v/s": 39.5}
    for resolution, expected in ((0.4, ["v/s"]), (0.6, [])):
        found = passing_peaks.lobes(spectrum, marks, 0.4, resolution)
        given, = passing_peaks.judged([{name: dataclasses.replace(lobe, ratio=2.0)
                                        for name, lobe in found.items()}])
        assert [name for name, lobe in given.items() if lobe.peak] == expected
    assert given["v/s"].words("kN").startswith(
        "no peak: closer to v/L_c than the resolution of the record (highest lobe ")


def test_a_lobe_with_nothing_beside_it_is_no_peak():
    frequency = np.array([30.0, 40.0, 50.0])
    lobe = passing_peaks.lobe_near((frequency, np.array([0.1, 1.0, 0.1])), 40.0, 1.0, 4.1)
    assert np.isnan(lobe.ratio)
    assert peaks({"v/s": lobe}) == [[]]


def two_trains(run):
    """The run with a rail, and the same train once more in the second half of the passage."""
    run = test_postproc.with_train(run, test_postproc.WAGONS[:4], 1)
    rows = run.passage()
    count = (rows.stop - rows.start) // 2
    x = run.wheel["x"].values.copy()
    x[rows.start + count:rows.start + 2 * count] = x[rows.start:rows.start + count]
    return dataclasses.replace(run, wheel={**run.wheel, "x": read.Quantity(x, "m", "-")}), count


def test_of_several_trains_the_last_one_has_the_spectrum(runs):
    run, count = two_trains(runs[0])
    rows = run.passage()
    assert frequencies.rows_of_last_train(run) == slice(rows.start + count, rows.stop)
    assert frequencies.rows_of_last_train(runs[0]) == rows
    loud = run.sleeper["seat_force"].values.copy()
    loud[:rows.start + count] *= 100
    other = dataclasses.replace(run, sleeper={
        **run.sleeper, "seat_force": read.Quantity(loud, "N", "-")})
    for one, same in zip(bed_on_ground.spectrum_of(run, "seat_force"),
                         bed_on_ground.spectrum_of(other, "seat_force")):
        assert np.array_equal(one, same)
    title = " ".join(bed_on_ground.spectra([run]).axes[0].get_title().split())
    assert "passage, its last train, root mean square" in title
    assert "wedge, passage, its last train, resolution " in bed_on_ground.table_of_peaks([run])
    plt.close("all")


def test_spectra_are_computed_once(runs, tmp_path, monkeypatch):
    counted, original = [], bed_on_ground.spectrum_of
    monkeypatch.setattr(bed_on_ground, "spectrum_of", lambda run, name: counted.append(
        (run.name, name)) or original(run, name))
    bed_on_ground.draw_all(runs, write.Folder(tmp_path))
    assert len(counted) == len(set(counted)) == 2 * len(bed_on_ground.SPECTRA)


def test_how_far_lobes_are_compared(runs):
    """Twice the speed over the length of the train; of loads without rail that of their axles."""
    long = test_postproc.with_train(runs[0], test_postproc.WAGONS[:4], 1)
    assert frequencies.beside(long, {"v/s": 40.0}) == pytest.approx(2 * 20 / 10.8)
    assert frequencies.beside(runs[0], {"v/s": 40.0}) == pytest.approx(2 * 20 / 10.5)
    unknown = dataclasses.replace(long, wheel={})
    assert frequencies.beside(unknown, {"v/s": 40.0}) == 60.0
    assert frequencies.beside(unknown, {}) == 0.0


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
    lines = [line for line in text.splitlines() if "seat load" in line]
    assert [line.split("Hz", 1)[1].strip() for line in lines if "v/L_w" in line] == [
        "peak at 11.10 Hz, 0.999 kN, 4.6 times the largest amplitude beside it"]
    assert sum("no peak: " in line for line in lines) == 2
    moved, = (line for line in text.splitlines() if "displacement" in line and "v/L_w" in line)
    assert "peak at 11.10 Hz, 2 mm, 4.6 times" in moved
    figure = bed_on_ground.spectra([run])
    ring, = (line for line in figure.axes[2].lines if line.get_marker() == "o")
    assert ring.get_xdata() == pytest.approx([11.1])
    words = [text.get_text() for text in figure.axes[2].get_legend().texts]
    near = ("wedge, peak near a passing frequency (resolution "
            f"{1 / np.ptp(run.time[run.passage()]):.2g} Hz)")
    assert words == ["wedge", near,
                     "v/L_c = 2.2 Hz, L_c: distance of bogie centres",
                     "v/L_w = 11.1 Hz, L_w: wheelbase", "v/s = 33.3 Hz, s: sleeper spacing"]
    rows = [row for row in csv.DictReader(figure_csv.of_figure(figure).splitlines())
            if row["line"] == near]
    rings = [(row["y axis"], row["x"]) for row in rows]
    assert ("displacement (mm)", "11.1") in rings and ("seat load (kN)", "11.1") in rings
    assert len(rings) == text.count("peak at ")
    assert [text.get_text() for text in figure.axes[0].texts] == [" v/L_c", " v/L_w", " v/s"]
    plt.close("all")


def test_without_histories_of_wheels_the_spacing_is_marked(runs):
    run = dataclasses.replace(test_postproc.with_train(runs[0], test_postproc.WAGONS, 2), wheel={})
    assert frequencies.of_passage(run) == pytest.approx({"v/s": 20 / 0.6})
