"""Third octaves, levels, weighting, measured files and the figure of vibrations."""
import types

import conftest
import h5py
import numpy as np
import pytest
import scipy.io
import scipy.io.wavfile
from made import store
from trackbed_post import measured, read, signals, vibration

STEP = 1e-3
TIME = np.arange(0, 4, STEP)
# ISO 2631-1:1997, table 3: weighting Wk at nominal midband frequencies.
WK = {0.5: 0.418, 1: 0.482, 2: 0.531, 4: 0.967, 8: 1.036, 16: 0.768, 31.5: 0.405, 63: 0.186}


def test_bands_of_a_sine_and_of_noise_hold_their_energy():
    middle, bands = signals.third_octaves(TIME, 5 + 3 * np.sin(2 * np.pi * 40 * TIME))
    assert middle[np.argmax(bands)] == pytest.approx(1000 * 10**-1.4)
    # The window spreads the line: 1e-4 of its energy lies in other bands.
    assert bands.max() == pytest.approx(3 / np.sqrt(2), rel=1e-4)
    noise = np.random.default_rng(1).normal(size=len(TIME))
    middle, bands = signals.third_octaves(TIME, noise)
    # White noise: the energy of a band is its width, of which 500 Hz have the mean square 1. Bands
    # of hundreds of lines scatter by a few per cent.
    wide = middle > 50
    expected = np.sqrt(middle[wide] * (signals.EDGE - 1 / signals.EDGE) / 500)
    assert bands[wide] == pytest.approx(expected, rel=0.15)
    assert middle[-1] * signals.EDGE <= 0.9 * 500
    assert middle[0] * (signals.EDGE - 1 / signals.EDGE) >= 2 / 4.0 - 1e-12


def test_levels_refer_to_the_values_of_iso_1683():
    assert signals.levels(1.0, "m/s2") == pytest.approx(120)
    assert signals.levels(1.0, "m/s") == pytest.approx(180)


def test_weighting_agrees_with_the_table_of_the_standard():
    for nominal, factor in WK.items():
        exact = 10 ** (round(10 * np.log10(nominal)) / 10)
        # The table is rounded and its frequencies are nominal ones: up to 1 %.
        assert signals.weighting_wk([exact])[0] == pytest.approx(factor, rel=0.01)
    found = signals.weighted_rms(TIME, 2 * np.sin(2 * np.pi * 8 * TIME))
    assert found == pytest.approx(np.sqrt(2) * signals.weighting_wk([8.0])[0], rel=2e-3)


def test_weighting_of_passengers_of_trains():
    low, flat, high = (signals.weighting_wb(np.array(f))
                       for f in ([1.0, 1.5], [6.3, 12.5], [50, 63]))
    assert low == pytest.approx(0.4, rel=0.03)       # gain below the step, above 0.4 Hz
    assert flat == pytest.approx(1.02, rel=0.02)     # acceleration counts fully
    assert high[0] / high[1] == pytest.approx(63 / 50, rel=0.05)  # as velocity


def test_comfort_of_a_long_record():
    time = np.arange(0, 320, 1 / 400)
    shaking = np.where(time < 300, 0.3, 0.6) * np.sin(2 * np.pi * 8 * time)
    comfort = signals.continuous_comfort(time, shaking)
    one = signals.weighting_wb([8.0])[0] / np.sqrt(2)
    assert len(comfort) == 64
    assert comfort[5:55] == pytest.approx(0.3 * one, rel=1e-3)
    assert comfort[61:63] == pytest.approx(0.6 * one, rel=1e-3)
    # Of sixty intervals seven are twice as bad; of two, the 95th percentile is between both.
    assert signals.mean_comfort(np.r_[np.ones(53), 2 * np.ones(7)]) == pytest.approx([12])
    assert signals.mean_comfort(np.r_[np.ones(57), 2 * np.ones(3)]) == pytest.approx([6.3])
    assert len(signals.mean_comfort(comfort[:59])) == 0
    assert len(signals.continuous_comfort(time[::4], shaking[::4])) == 0
    found = vibration.numbers(measured.Signal("car", time, shaking, "m/s2", ()))
    assert found["largest CC_z of 64 intervals of 5 s (EN 12299)"][0] == comfort.max()
    assert "largest vertical part of N_MV of 5 minutes (EN 12299)" in found
    # 200 samples in a second are enough, also where rounding makes the mean step a little longer.
    slow = 100 + 0.005 * np.arange(2000)
    assert len(signals.continuous_comfort(slow, np.sin(slow))) == 2
    rare = vibration.numbers(measured.Signal("car", time[::4], shaking[::4], "m/s2", ()))
    assert not any("VDV" in name or "MTVV" in name for name in rare)
    short = vibration.numbers(measured.Signal("car", time[:1500], shaking[:1500], "m/s2", ()))
    assert not any("CC_z" in name for name in short)


def test_transient_vibration_and_dose():
    time = np.arange(0, 10, 1 / 500)
    shaking = np.where((time >= 4) & (time < 7), 1.0, 0.1) * np.sin(2 * np.pi * 8 * time)
    factor = signals.weighting_wk([8.0])[0]
    largest, dose = signals.transient(time, shaking)
    # A burst of 3 s: the weighting spreads its ends by about 0.1 s.
    assert largest == pytest.approx(factor / np.sqrt(2), rel=0.01)
    # The mean of the fourth power of a sine is 3/8.
    assert dose == pytest.approx(factor * (3 * 3 / 8)**0.25, rel=0.01)
    short = signals.transient(time[:250], shaking[:250])[0]
    assert short == pytest.approx(0.1 * factor / np.sqrt(2), rel=0.05)
    # Of a passage that ends within a second: the same acceleration, not tapered, over all of it.
    bump = time[:250], np.sin(2 * np.pi * 8 * time[:250]) * np.linspace(0, 1, 250)
    assert signals.transient(*bump)[0] == pytest.approx(signals.weighted_rms(*bump), rel=1e-9)
    found = vibration.numbers(measured.Signal("car", time, shaking, "m/s2", ()))
    assert found["largest weighted (Wk) root mean square in 1 s, MTVV"] == (largest, "m/s2")
    assert found["vibration dose value (Wk), VDV"] == (dose, "m/s1.75")


def write_csv(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def test_units_are_those_in_the_names(tmp_path):
    rows = "".join(f"{i},{i % 5},{i % 7}\n" for i in range(40))
    path = write_csv(tmp_path / "a.csv", "time_ms,a1_g,v_mm_s\n" + rows)
    one = measured.load(f"{path}:a1_g")
    assert one.unit == "m/s2" and one.values[3] == pytest.approx(3 * 9.80665)
    assert one.time[-1] == pytest.approx(0.039) and not one.remarks[1:]
    assert measured.load(f"{path}:v_mm_s").values[6] == pytest.approx(6e-3)
    with pytest.raises(read.Unreadable, match="a1_g, v_mm_s: choose one"):
        measured.load(path)
    with pytest.raises(read.Unreadable, match="has no column b"):
        measured.load(f"{path}:b")
    odd = write_csv(tmp_path / "b.csv", "time_s,level\n" + "".join(f"{i},1\n" for i in range(9)))
    with pytest.raises(read.Unreadable, match="unit of column level is unknown"):
        measured.load(odd)


def test_faults_of_a_measurement_are_stated_and_mended(tmp_path):
    time = [0.01 * i for i in range(200) if not 50 <= i < 60]
    values = [np.sin(0.3 * i) for i in range(len(time))]
    values[20] = float("nan")
    values[100:105] = [2.5] * 5
    rows = "".join(f"{t},{v}\n" for t, v in zip(time, values))
    found = measured.load(write_csv(tmp_path / "a.csv", "time_s,a_m_s2\n" + rows))
    text = " ".join(found.remarks)
    for words in ("1 of 190 samples were not numbers",
                  "5 samples are at the extreme values -0.997 and 2.5",
                  "gaps, the longest of 0.11 s at 0.49 s"):
        assert words in text
    assert np.isfinite(found.values).all() and signals.step_of(found.time) == pytest.approx(0.01)
    assert len(found.time) == 200
    with pytest.raises(read.Unreadable, match="ascending time"):
        measured.load(write_csv(tmp_path / "c.csv", "time_s,a_g\n0,1\n1,2\n1,3\n2,4\n"))


@pytest.mark.parametrize("missing", [0, 1, 30])
def test_uneven_sampling_is_no_gap(tmp_path, missing):
    """2 kHz with a jitter of 0.1 ms: one step in a dozen is longer than 1.5 steps."""
    time = 5e-4 * np.arange(4000) + 1e-4 * np.random.default_rng(3).uniform(-1.7, 1.7, 4000)
    time = np.delete(time, slice(1000, 1000 + missing))
    assert np.count_nonzero(np.diff(time) > 0.75e-3) > 100
    values = np.sin(2 * np.pi * 20 * time)
    found = measured.load(write_csv(tmp_path / "a.csv", "time_s,a_m_s2\n" + "".join(
        f"{t:.7f},{v:.6f}\n" for t, v in zip(time, values))))
    text = " ".join(found.remarks)
    assert "the sampling is uneven (jitter): steps of 0.00016" in text
    assert ("1 gaps, the longest of 0.0" in text) == bool(missing)
    assert ("gaps" in text) == bool(missing)
    assert found.rate == pytest.approx(2000, rel=2e-4)
    inside = (np.abs(found.time - 0.5075) > 0.01) & (found.time < time[-1])
    assert found.values[inside] == pytest.approx(np.sin(2 * np.pi * 20 * found.time[inside]),
                                                 abs=1e-2)


def test_files_of_matlab_and_sound(tmp_path):
    scipy.io.savemat(tmp_path / "a.mat", {"time_s": TIME, "force_kN": np.sin(TIME)})
    assert measured.load(tmp_path / "a.mat").values[500] == pytest.approx(1e3 * np.sin(0.5))
    scipy.io.wavfile.write(tmp_path / "a.wav", 1000, np.full(100, 16384, dtype=np.int16))
    found = measured.load(f"{tmp_path / 'a.wav'}:50_m_s2")
    assert found.unit == "m/s2" and found.values[5] == pytest.approx(25)
    with pytest.raises(read.Unreadable, match="give its value and unit"):
        measured.load(tmp_path / "a.wav")


@pytest.fixture(name="run")
def run_of_a_track(tmp_path):
    """Two places; the second moves three times as much."""
    values = np.sin(2 * np.pi * 20 * TIME)[:, None] * [1.0, 3.0]
    store(tmp_path / "results.h5", {"history/time": (TIME, "s"),
                                    "history/sleeper/acceleration": (values, "m/s2"),
                                    "history/body/roll": (TIME, "rad")},
          version="0", ranks=1, deck="")
    return tmp_path


def test_figure_and_table_show_the_strongest_place_beside_a_measurement(run):
    other = write_csv(run / "m.csv", "time_s,a_m_s2\n" + "".join(
        f"{t:.6f},{2 * np.cos(2 * np.pi * 20 * t):.8f}\n" for t in TIME))
    command = ["vibration", run, "sleeper/acceleration", "-o", run / "out"]
    ran = conftest.call(*command, "--measured", other)
    assert ran.returncode == 0, ran.stderr
    assert "place 1" in ran.stdout and "the linear trend was removed" in ran.stdout
    assert (run / "out/vibration.png").stat().st_size > 10000
    rows = (run / "out/vibration.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "midband_Hz,rms_0,level_0_dB,rms_1,level_1_dB"
    at_20 = next(row for row in rows if row.startswith("19.95")).split(",")
    # The window spreads a line over 5 Hz: the band, 4.6 Hz wide, lacks 0.5 % of its energy.
    assert float(at_20[1]) == pytest.approx(3 / np.sqrt(2), rel=4e-3)
    assert float(at_20[3]) == pytest.approx(2 / np.sqrt(2), rel=4e-3)
    assert float(at_20[2]) == pytest.approx(20 * np.log10(float(at_20[1]) / 1e-6), abs=0.01)
    for words, message in ((["--place", "2"], "has the places 0 to 1"),
                           (["--cut-off", "-1"], "must be above 0 Hz"),
                           (["--measured", str(run / "none.csv")], "does not exist")):
        ran = conftest.call(*command, *words)
        assert ran.returncode == 2 and message in ran.stderr
    command[2] = "body/roll"
    ran = conftest.call(*command)
    assert ran.returncode == 2 and "is in rad" in ran.stderr


def test_the_middle_sleeper_of_a_bed_is_the_default(tmp_path):
    """Also if one at the end of the bed moves more; the label is that of `curve`."""
    values = np.sin(2 * np.pi * 20 * TIME)[:, None] * [9.0, 1.0, 2.0]
    path = tmp_path / "results.h5"
    store(path, {"history/time": (TIME, "s"), "history/stage": (0 * TIME, "-"),
                 "history/sleeper/acceleration": (values, "m/s2"),
                 "history/body/acceleration": (values[:, 0], "m/s2"),
                 "history/sleeper/x": ([0.6, 1.2, 1.8], "m")},
          version="0", ranks=1, deck="[[stage]]\nname = 'train'\nkind = 'passage'\n")
    with h5py.File(path, "r+") as file:
        file["history/sleeper/x"].make_scale()
        file["history/sleeper/acceleration"].dims[1].attach_scale(file["history/sleeper/x"])
    signal = vibration.computed(tmp_path, "sleeper/acceleration", -1)
    assert signal.name.endswith("sleeper/acceleration, x = 1.2 m")
    assert signal.values.max() == pytest.approx(1, rel=0.01)
    assert vibration.computed(tmp_path, "sleeper/acceleration", 0).name.endswith("x = 0.6 m")
    assert vibration.computed(tmp_path, "body/acceleration", -1).name.endswith("body/acceleration")


def test_axes_begin_at_the_length_of_the_record_and_have_plain_numbers():
    signal = measured.Signal("short", TIME[:700], np.sin(300 * TIME[:700]), "m/s2", ())
    _, lines, bands = vibration.draw([signal], signals.LowPass()).axes
    assert lines.lines[0].get_xdata()[0] == pytest.approx(1 / 0.7, abs=0.05)
    for panel in (lines, bands):
        panel.figure.canvas.draw()
        inside = [tick.get_text() for tick in panel.get_xticklabels()
                  if panel.get_xlim()[0] <= tick.get_position()[0] <= panel.get_xlim()[1]]
        assert {"20", "50", "100", "200"} <= set(inside)


def test_only_the_last_passage_counts(run, monkeypatch):
    assert vibration.rows_of_passage(read.datasets(run), run) == slice(None)  # without stages
    passage = types.SimpleNamespace(passage=lambda: slice(3, 9))
    monkeypatch.setattr(read, "results", lambda _: passage)
    assert vibration.rows_of_passage({"history/stage": None}, run) == slice(3, 9)


def test_wheels_count_between_the_run_ins(tmp_path):
    x = 25 * TIME
    force = np.where((x >= 8) & (x <= 52), 60e3 + 5e3 * np.sin(2 * np.pi * 20 * TIME), 90e3)
    store(tmp_path / "results.h5", {"history/time": (TIME, "s"),
                                    "history/wheel/x": (x[:, None], "m"),
                                    "history/wheel/force": (force[:, None], "N")},
          deck="[track]\nlength = 60\nrun_in = 8\n", version="0.1.0", ranks=1)
    signal = vibration.computed(tmp_path, "history/wheel/force", -1)
    assert signal.values.max() == pytest.approx(65e3, rel=1e-3)
    assert 25 * signal.time[0] == pytest.approx(8, abs=0.03)


def test_the_load_factor_refers_to_the_static_load_of_the_wheel(tmp_path):
    """A wheel of 50 kN that the histories show with 60 kN in the mean, and a seat without it."""
    force = np.where(TIME == 0, 50e3, 60e3 + 15e3 * np.sin(2 * np.pi * 20 * TIME))
    store(tmp_path / "results.h5", {"history/time": (TIME, "s"),
                                    "history/wheel/x": ((25 * TIME)[:, None], "m"),
                                    "history/wheel/force": (force[:, None], "N"),
                                    "history/sleeper/seat_force": (force[:, None], "N")},
          deck="[track]\nlength = 100\nrun_in = 0\n", version="0.1.0", ranks=1)
    other = write_csv(tmp_path / "m.csv", "time_s,force_kN\n" + "".join(
        f"{t:.6f},{one / 1e3:.8f}\n" for t, one in zip(TIME, force)))
    for quantity, words, load in (("wheel/force", "static wheel load of 50 kN", 50),
                                  ("sleeper/seat_force", "mean force of 60 kN", 60)):
        ran = conftest.call("vibration", tmp_path, quantity, "-o", tmp_path / "out", "--measured",
                            other)
        assert ran.returncode == 0, ran.stderr
        row, = (line for line in ran.stdout.splitlines() if "dynamic load factor" in line)
        assert f"largest force over the {words}" in row
        assert float(row.split()[-2]) == pytest.approx(75 / load, rel=1e-3)


def passage(time):
    """Two bogies, 0.3 s apart, of which the first passes at 3.2 s."""
    return sum(np.exp(-((time - at) / 0.05)**2) * np.sin(2 * np.pi * 30 * time)
               for at in (3.2, 3.5))


def test_a_measured_passage_lies_over_the_computed_one(tmp_path, monkeypatch):
    """A record whose time begins at 0, noisy and of another phase."""
    time = np.arange(2.8, 4.2, STEP)
    store(tmp_path / "results.h5", {
        "history/time": (time, "s"), "history/sleeper/acceleration": (passage(time), "m/s2")},
          version="0", ranks=1, deck="")
    own = np.arange(0, 6, 5e-4)
    values = 0.7 * passage(own + 0.9 + 2e-3) + np.random.default_rng(1).normal(0, 0.02, len(own))
    other = write_csv(tmp_path / "m.csv", "time_s,a_m_s2\n" + "".join(
        f"{t:.6f},{v:.6f}\n" for t, v in zip(own, values)))
    drawn, draw = [], vibration.draw
    monkeypatch.setattr(vibration, "draw", lambda shown, low_pass: drawn.append(shown)
                        or draw(shown, low_pass))
    command = ["vibration", tmp_path, "sleeper/acceleration", "-o", tmp_path / "out", "--measured",
               other]
    for words, shift, how in (((), 0.902, "largest correlation of the envelopes"),
                              (("--shift", "-1.5"), -1.5, "--shift")):
        ran = conftest.call(*command, *words)
        assert ran.returncode == 0, ran.stderr
        assert drawn[-1][1].time[0] == pytest.approx(shift, abs=2e-3)
        assert drawn[-1][1].name.endswith(f" s ({how})") and drawn[-1][1].name in ran.stdout
    ran = conftest.call(*command[:-2], "--shift", "1")
    assert ran.returncode == 2 and "--measured, which is not given" in ran.stderr


def test_a_blow_at_the_begin_is_not_mirrored():
    """The record of a blow equals that of the same blow after a time at rest."""
    low_pass = signals.LowPass()
    blow = np.where(TIME < 5e-3, np.cos(np.pi * TIME / 1e-2), 0.0)
    later = np.concatenate([np.zeros(500), blow])
    wanted = low_pass(np.arange(len(later)) * STEP, later)[500:]
    assert low_pass(TIME, blow, at_rest=True) == pytest.approx(wanted, abs=1e-9)
    assert np.abs(low_pass(TIME, blow) - wanted).max() > 0.2
