"""Condition monitoring: passages whose displacement and acceleration are known in closed form."""
import csv
import dataclasses
import datetime
import os
import signal
import subprocess
import sys
import time

import conftest
import numpy as np
import pytest
import scipy.signal

from trackbed_post import measured, read
from trackbed_post.monitor import displacement, figures, indicators, passages, trains, trends

RATE = 5000.0
BOGIE, CENTRES, LENGTH = 2.9, 17.0, 25.0  # m
STIFF = 1.2  # 1/m, of Winkler's deflection line
DEEP = 0.8e-3  # m, below a single axle


@dataclasses.dataclass
class Passage:
    speed: float
    displacement: np.ndarray
    acceleration: np.ndarray


def axles(cars, centres=CENTRES, length=LENGTH):
    return np.concatenate([[start + place + k * BOGIE for place in (0.0, centres) for k in (0, 1)]
                           for start in length * np.arange(cars)])


def train(speed, places, rate=RATE, impact=0.0):
    """Winkler's line exp(-|s|)(cos s + sin |s|) of each axle, rounded over 0.1 m as by a sleeper's
    width, and its second derivative; `impact`: m/s2, a burst of 150 Hz at each axle whose double
    integral is known, too."""
    time = np.arange(-45.0, places[-1] + 45.0, speed / rate) / speed
    down, slow = np.zeros(len(time)), np.zeros(len(time))
    for place in places:
        for shift in (-0.1, 0.1):
            s = STIFF * (speed * time - place + shift)
            decay = np.exp(-np.abs(s))
            down -= DEEP / 2 * decay * (np.cos(s) + np.sin(np.abs(s)))
            slow -= DEEP / 2 * 2 * (STIFF * speed)**2 * decay * (np.sin(np.abs(s)) - np.cos(s))
        since = time - place / speed
        width, w = 0.004, 2 * np.pi * 150
        bell = np.exp(-(since / width)**2 / 2)
        down += impact / w**2 * bell * np.sin(w * since)
        first, second = -since / width**2, (since / width**2)**2 - 1 / width**2
        slow += impact / w**2 * bell * ((second - w**2) * np.sin(w * since)
                                        + 2 * first * w * np.cos(w * since))
    return Passage(speed, down, slow)


@pytest.fixture(scope="module", name="six")
def six_cars():
    return train(50.0, axles(6), impact=60.0)


def noisy(passage, part, seed):
    """White noise of this part of the signal's root mean square."""
    size = part * np.sqrt(np.mean(passage.acceleration**2))
    return passage.acceleration + size * np.random.default_rng(seed).standard_normal(
        len(passage.acceleration))


def worst(found, passage):
    """Largest error over the largest displacement."""
    return np.abs(found.displacement - passage.displacement).max() / -passage.displacement.min()


def test_displacement_of_six_cars_is_within_one_per_cent(six):
    found = displacement.reconstruct(six.acceleration, RATE, six.speed)
    assert worst(found, six) < 0.01
    assert found.deviation.max() < 0.01 * found.peak[0]
    # What seems to rest is lifted by up to 4 %.
    assert np.abs(six.displacement[found.at_rest]).max() < 0.05 * found.peak[0]
    assert 0.1 < found.at_rest.mean() < 0.8 and not found.reversed


def test_high_pass_of_the_thesis_is_within_ten_per_cent(six):
    found = displacement.reconstruct(six.acceleration, RATE, six.speed, "high_pass")
    assert worst(found, six) < 0.10
    assert 0.04 <= found.high_pass <= 2


@pytest.mark.parametrize("speed", [22.0, 35.5, 60.0])
@pytest.mark.parametrize("rate", [1000.0, 20000.0])
def test_other_speeds_and_rates(speed, rate):
    one = train(speed, axles(3), rate)
    assert worst(displacement.reconstruct(one.acceleration, rate, speed), one) < 0.02


def test_trains_of_different_cars():
    places = np.concatenate([axles(1, 9.0, 19.0), 19.0 + 4.0 + axles(2, 14.0, 20.0),
                             70.0 + axles(1, 19.0, 26.0)])
    one = train(40.0, places)
    assert worst(displacement.reconstruct(one.acceleration, RATE, 40.0), one) < 0.02


@pytest.mark.parametrize("part, most", [(1e-3, 0.05), (1e-2, 0.15)])
def test_errors_are_those_that_the_deviation_states(six, part, most):
    errors = []
    for seed in range(10):
        found = displacement.reconstruct(noisy(six, part, seed), RATE, six.speed)
        errors.append((found.displacement - six.displacement) / found.deviation)
        assert worst(found, six) < most
    # Of a standard normal variable 95 % are within 2; smooth errors make few independent ones.
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 1.5


def test_offset_and_drift_of_the_sensor_do_not_matter(six):
    time = np.arange(len(six.acceleration)) / RATE
    drifting = six.acceleration + 3 - 0.5 * time
    assert worst(displacement.reconstruct(drifting, RATE, six.speed), six) < 0.02


def test_sensor_upside_down_is_noticed(six):
    found = displacement.reconstruct(-six.acceleration, RATE, six.speed)
    assert found.reversed and worst(found, six) < 0.01


def settling(passage, size, at):
    """The same passage in which the sleeper settles by `size`, m, when the first wheel is at
    these positions, m."""
    count = len(passage.displacement)
    time = np.arange(count) / RATE - 45.0 / passage.speed
    down, slow = passage.displacement.copy(), passage.acceleration.copy()
    for place in at:
        step = np.tanh((time - place / passage.speed) / 0.02)
        down -= size / len(at) * (1 + step) / 2
        slow += size / len(at) * step * (1 - step**2) / 0.02**2
    return Passage(passage.speed, down, slow)


def test_settlement_is_found_if_the_noise_is_known():
    one = train(50.0, axles(1), impact=60.0)
    settled = settling(one, 0.15 * DEEP, [1.5, 18.5])
    size = 1e-3 * np.sqrt(np.mean(settled.acceleration**2))
    for seed in range(5):
        signal = settled.acceleration + size * np.random.default_rng(seed).standard_normal(
            len(settled.acceleration))
        found = displacement.reconstruct(signal, RATE, 50.0, noise=size)
        assert abs(found.settlement[0] / (0.15 * DEEP) - 1) < 0.25
        assert found.settlement[1] < 0.25 * 0.15 * DEEP
        assert worst(found, settled) < 0.05
        reversed_sensor = displacement.reconstruct(-signal, RATE, 50.0, noise=size)
        assert reversed_sensor.reversed and worst(reversed_sensor, settled) < 0.05
        assert abs(reversed_sensor.settlement[0] - found.settlement[0]) < 1e-9
        still = displacement.reconstruct(noisy(one, 1e-3, seed), RATE, 50.0, noise=size)
        assert still.settlement == (0.0, 0.0)


def faulty(acceleration, doubtful, six):
    """What is found of a signal of which samples are lost."""
    found = displacement.reconstruct(acceleration, RATE, six.speed, doubtful=doubtful)
    wrong = np.abs(found.displacement - six.displacement).max()
    # Reported as wrong by the misfit, or by a deviation of the size of the error.
    reported = found.misfit > displacement.TRUSTED or wrong < 4 * found.deviation.max()
    assert reported or wrong < 0.02 * found.peak[0]
    return wrong


def test_overloaded_sensor_is_not_trusted(six):
    limited = np.clip(six.acceleration, -30, 30)
    clipped = measured.clipped(limited)
    assert clipped.sum() > 50 and not measured.clipped(six.acceleration).any()
    faulty(limited, clipped, six)
    # Weaker upwards than downwards, so that what is cut off changes the velocity.
    uneven = six.acceleration - 40 * (six.acceleration > 20)
    faulty(np.clip(uneven, -30, 30), measured.clipped(np.clip(uneven, -30, 30)), six)
    assert faulty(uneven, None, six) > 0.1 * -six.displacement.min()


def test_missing_samples_are_not_trusted(six, tmp_path):
    lost = slice(np.argmax(np.abs(six.acceleration)) - 10, np.argmax(np.abs(six.acceleration)) + 10)
    time = np.delete(np.arange(len(six.acceleration)) / RATE, lost)
    np.savetxt(tmp_path / "gap.csv", np.column_stack([time, np.delete(six.acceleration, lost)]),
               delimiter=",", header="time_s,sleeper_m_s2", comments="")
    signal = measured.load(tmp_path / "gap.csv")
    assert 15 <= signal.doubtful.sum() <= 25
    faulty(signal.values, signal.doubtful, six)
    # Filled by a straight line from a peak, without a word.
    broken = six.acceleration.copy()
    broken[lost] = np.abs(six.acceleration).max()
    assert faulty(broken, None, six) > 0.1 * -six.displacement.min()


def test_slow_signal_at_its_extreme_is_not_clipped():
    smooth = np.round(np.cos(np.linspace(0, 20, 5000)) * 100)
    assert (smooth == 100).sum() > 20 and not measured.clipped(smooth).any()


@pytest.mark.parametrize("fault", ["step", "start", "spike", "hum"])
def test_faults_of_the_sensor_are_noticed(six, fault):
    time = np.arange(len(six.acceleration)) / RATE
    added = {"step": 0.5 * (time > time[-1] / 2), "start": 2 * np.exp(-time / 0.5),
             "spike": 200.0 * (np.arange(len(time)) == len(time) // 2),
             "hum": 0.05 * np.sin(2 * np.pi * 2 * time)}[fault]
    found = displacement.reconstruct(six.acceleration + added, RATE, six.speed)
    assert found.misfit > 2 * displacement.TRUSTED
    assert displacement.reconstruct(six.acceleration, RATE, six.speed).misfit < displacement.TRUSTED


def test_noise_need_not_be_white_up_to_half_the_rate(six):
    fast = train(six.speed, axles(6), 20000.0, impact=60.0)
    sections = scipy.signal.butter(4, 2000, fs=20000.0, output="sos")
    noise = scipy.signal.sosfiltfilt(sections, np.random.default_rng(4).standard_normal(
        len(fast.acceleration)))
    size = 3e-3 * np.sqrt(np.mean(fast.acceleration**2)) / noise.std()
    found = displacement.reconstruct(fast.acceleration + size * noise, 20000.0, fast.speed)
    errors = (found.displacement - fast.displacement) / found.deviation
    assert 0.3 < np.sqrt(np.mean(errors**2)) < 2


@pytest.mark.parametrize("words, why", [
    ({"speed": 0.0}, "must be above 0"), ({"speed": 4000.0}, "too few"),
    ({"acceleration": np.zeros(100)}, "more than 40 m"),
    ({"acceleration": np.zeros(10**6)}, "less than 3000 m"),
    ({"acceleration": np.full(20000, 9.81)}, "constant"), ({"method": "highpass"}, "no method"),
    ({"acceleration": np.full(20000, np.nan)}, "not numbers")])
def test_what_cannot_be_reconstructed_is_refused(six, words, why):
    given = {"acceleration": six.acceleration, "rate": RATE, "speed": six.speed} | words
    with pytest.raises(read.Unreadable, match=why):
        displacement.reconstruct(**given)


def test_train_that_fills_the_record_is_refused(six):
    middle = six.acceleration[(np.abs(six.displacement) > 0.3e-3)]
    with pytest.raises(read.Unreadable, match="rests for"):
        displacement.reconstruct(np.tile(middle, 3), RATE, six.speed)


def test_indicator_is_the_root_mean_square_of_its_band(six):
    time = np.arange(len(six.acceleration)) / RATE
    tones = 2 * np.sin(2 * np.pi * 100 * time) + 7 * np.sin(2 * np.pi * 400 * time)
    part = indicators.band(tones, RATE, 50.0)
    middle = slice(2000, -2000)
    assert np.sqrt(np.mean(part[middle]**2)) == pytest.approx(np.sqrt(2), rel=0.01)
    moved = indicators.band(tones, RATE, 50.0, quantity="displacement")
    assert np.sqrt(np.mean(moved[middle]**2)) == pytest.approx(
        np.sqrt(2) / (2 * np.pi * 100)**2, rel=0.01)
    weak, strong = (indicators.indicator(train(50.0, axles(2), impact=impact).acceleration, RATE,
                                         50.0) for impact in (20.0, 60.0))
    assert strong == pytest.approx(3 * weak, rel=0.1)
    with pytest.raises(read.Unreadable, match="contain only up to"):
        indicators.band(tones, 400.0, 50.0)


@pytest.fixture(scope="module", name="library")
def library_of_trains():
    def reference(name, places):
        one = train(50.0, places)
        return trains.Reference.of_passage(name, one.displacement, RATE, 50.0)
    locomotive = np.concatenate([axles(1, 9.0, 19.0), 19.0 + axles(4)])
    return trains.Library([reference("six", axles(6)), reference("locomotive", locomotive)])


@pytest.mark.parametrize("speed", [23.4, 41.0, 58.7])
@pytest.mark.parametrize("seed", [1, 2])
def test_trains_are_recognised(library, speed, seed):
    one = train(speed, axles(6), impact=40.0)
    found = library.identify(noisy(one, 0.01, seed), RATE)
    assert found.name == "six" and found.similarity > trains.ACCEPTED
    assert found.speed == pytest.approx(speed, abs=0.1)
    assert found.direction == 0  # it looks the same from both ends


def test_direction_of_a_train_with_a_locomotive(library):
    places = np.concatenate([axles(1, 9.0, 19.0), 19.0 + axles(4)])
    assert library.identify(train(45.0, places).acceleration, RATE).direction == 1
    back = train(45.0, places[-1] - places[::-1])
    found = library.identify(back.acceleration, RATE)
    assert (found.name, found.direction) == ("locomotive", -1)


def test_unknown_train_is_unknown(library):
    freight = np.cumsum(np.tile([1.8, 5.2, 1.8, 4.1], 6))
    found = library.identify(train(40.0, freight).acceleration, RATE)
    assert found.name == "" and found.similarity < trains.ACCEPTED
    noise = np.random.default_rng(3).standard_normal(20000)
    assert library.identify(noise, RATE).name == ""


@pytest.fixture(name="folder")
def folder_of_passages(tmp_path):
    """Four passages, one of which is no signal."""
    folder = tmp_path / "passages"
    folder.mkdir()
    for number, speed in enumerate((30.0, 40.0, 50.0)):
        one = train(speed, axles(2), 2000.0)
        time = np.arange(len(one.acceleration)) / 2000.0
        np.savetxt(folder / f"p{number}.csv", np.column_stack([time, one.acceleration]),
                   delimiter=",", header="time_s,sleeper_m_s2", comments="")
    (folder / "broken.csv").write_text("time_s,sleeper_m_s2\n", encoding="utf-8")
    (folder / "passages.csv").write_text(
        "file,begin,speed_m_s,temperature_C\np0.csv,2026-05-03,30,12.5\np1.csv,2026-05-01,40,\n"
        "broken.csv,2026-05-02,40,\np2.csv,2026-05-04,,\n", encoding="utf-8")
    return folder


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_batch_continues_and_reports_what_failed(folder, tmp_path):
    table = tmp_path / "monitor.csv"
    assert passages.batch(folder, table, None) == 4
    whole = table.read_text(encoding="utf-8")
    rows = rows_of(table)
    assert [row["file"] for row in rows] == ["p0.csv", "p1.csv", "broken.csv", "p2.csv"]
    assert float(rows[0]["peak_mm"]) > 0.5 and rows[0]["temperature_C"] == "12.5"
    assert "no row of numbers" in rows[2]["remarks"]
    assert rows[3]["remarks"] == "the speed is neither given nor recognised"
    # Stopped within a line, with other workers; those that failed are tried again.
    table.write_bytes(whole[:whole.index("broken") + 20].encode() + b"\xc3")
    assert passages.batch(folder, table, None, workers=2) == 2
    assert table.read_text(encoding="utf-8") == whole
    (folder / "broken.csv").write_bytes((folder / "p1.csv").read_bytes())
    assert passages.batch(folder, table, None) == 2
    assert [row["peak_mm"] != "nan" for row in rows_of(table)] == [True, True, True, False]
    shown = figures.table_of(table)
    assert list(shown["file"]) == ["p1.csv", "broken.csv", "p0.csv", "p2.csv"]


def history(seed, growth, count=200):
    """A table of passages in a year, whose indicator grows and depends on temperature."""
    random = np.random.default_rng(seed)
    days = np.sort(random.uniform(0, 365, count))
    warmth = 10 - 12 * np.cos(2 * np.pi * days / 365) + random.normal(0, 2, count)
    value = (10 * (1 + growth * days / 365) + 0.1 * (warmth - 10)
             + random.normal(0, 0.5, count) + 20 * (random.uniform(size=count) < 0.05))
    first = datetime.datetime(2026, 1, 1)
    begins = [(first + datetime.timedelta(days=day)).isoformat() for day in days]
    order = {name: value for name in trends.QUANTITIES}
    return order | {"train": np.array(["six"] * count), "begin": np.array(begins),
                    "temperature_C": warmth, "misfit": np.ones(count),
                    "speed_m_s": 50 + random.normal(0, 1, count)}


@pytest.mark.parametrize("seed", range(20))
def test_trends_without_growth_raise_no_alarm(seed):
    for one in trends.trends(history(seed, 0.0)):
        assert not one.alarm
        assert one.per_degree == pytest.approx(0.1, abs=0.03)
        assert one.scatter == pytest.approx(0.5, rel=0.3)


@pytest.mark.parametrize("seed", range(10))
def test_growth_raises_an_alarm(seed):
    for one in trends.trends(history(seed, 0.5)):
        assert one.alarm and one.change == pytest.approx(0.5, abs=0.15)
        assert one.per_month == pytest.approx(5 / 12, rel=0.2)


def test_trends_are_those_of_similar_speeds():
    """Passages at twice the speed, with larger indicators, in the second half of the year."""
    table = history(1, 0.0)
    fast = np.arange(200) % 3 == 0
    fast[:100] = False
    table["speed_m_s"] = np.where(fast, 100.0, table["speed_m_s"])
    spoilt = table | {name: np.where(fast, 4 * table[name], table[name])
                      for name in trends.QUANTITIES}
    found = trends.trends(spoilt)
    assert [one.passages for one in found] == [200 - fast.sum()] * 3
    assert not any(one.alarm for one in found)
    mixed = spoilt | {"speed_m_s": np.full(200, 50.0)}
    assert all(abs(one.mean) > abs(other.mean)
               for one, other in zip(trends.trends(mixed), found))


@pytest.mark.parametrize("power", [2, 2.5])
def test_a_drift_of_the_speed_is_no_alarm(power):
    table = history(1, 0.0)
    speeds = np.linspace(46, 54, 200)
    grown = (speeds / 50)**power
    for one in trends.trends(table | {"speed_m_s": speeds} | {
            name: grown * table[name] for name in trends.QUANTITIES}):
        assert one.passages == 200 and not one.alarm and abs(one.change) < 0.1


@pytest.mark.parametrize("drift", [1, 2])
def test_growth_is_found_beside_a_drift_of_the_speed(drift):
    table = history(2, 0.5)
    for one in trends.trends(table | {"speed_m_s": 50 + drift * np.linspace(-0.5, 0.5, 200)}):
        assert one.alarm


def test_of_several_usual_speeds_the_most_frequent_one_counts():
    table = history(1, 0.0)
    speeds = np.array([40.0, 40.0, 50.0, 60.0, 60.0, 60.0] * 34)[:200]  # the median is 50 or 60
    speeds[[1, 7]] = 50, np.nan
    found = trends.trends(table | {"speed_m_s": speeds})
    assert [one.passages for one in found] == [np.sum(speeds == 60.0)] * 3


def test_passages_without_a_number_a_date_or_a_temperature_are_left_out():
    table = history(3, 0.0)
    table["temperature_C"][5] = np.nan
    table["begin"][6] = ""
    table["acceleration_m_s2"] = table["acceleration_m_s2"].copy()
    table["acceleration_m_s2"][7] = np.nan
    for one in trends.trends(table):
        assert one.passages == 197 and one.per_degree == pytest.approx(0.1, abs=0.03)
        assert not one.alarm and np.isfinite(one.per_month)


def test_trends_need_passages_and_dates():
    few = {name: values[:10] for name, values in history(1, 0.0).items()}
    assert trends.trends(few) == []
    undated = history(1, 0.0) | {"begin": np.array(["monday"] * 200),
                                 "temperature_C": np.full(200, np.nan)}
    for one in trends.trends(undated):
        assert np.isnan(one.per_month) and np.isnan(one.per_degree) and not one.alarm


def test_remarks_on_speed_and_length(folder, library, tmp_path):
    (folder / "passages.csv").write_text("file,speed_m_s\np0.csv,\np1.csv,45\n", encoding="utf-8")
    one = train(50.0, axles(3))
    short = trains.Library([trains.Reference.of_passage("three", one.displacement, RATE, 50.0)])
    passages.batch(folder, tmp_path / "a.csv", short)
    first, second = rows_of(tmp_path / "a.csv")
    assert first["train"] == "three" and "25 m shorter than its reference" in first["remarks"]
    assert "45 m/s is not that of the recognised train, 40 m/s" in second["remarks"]
    passages.batch(folder, tmp_path / "b.csv", library)
    assert rows_of(tmp_path / "b.csv")[0]["train"] == "unknown"


def test_passages_are_recognised_by_a_measured_one(folder, tmp_path):
    rows = "file,speed_m_s,reference\np0.csv,30,pair\np1.csv,,\np2.csv,,\n"
    (folder / "passages.csv").write_text(rows, encoding="utf-8")
    words = ("monitor", folder, "-o", tmp_path / "out", "--workers", "1")
    assert conftest.call(*words).returncode == 0
    found = rows_of(tmp_path / "out/monitor.csv")
    assert [row["train"] for row in found] == ["pair"] * 3
    assert [float(row["speed_m_s"]) for row in found] == pytest.approx([30, 40, 50], abs=0.1)
    for content, place, why in ((rows.replace("pair", "two"), "out", "the table of references"),
                                (rows.replace(",30,", ",33,"), "out", "the table of references"),
                                (rows.replace(",30,", ",,"), "new", "needs its speed_m_s"),
                                (rows.replace("pair", "unknown"), "new", "give another name")):
        (folder / "passages.csv").write_text(content, encoding="utf-8")
        failed = conftest.call(*words[:3], tmp_path / place)
        assert failed.returncode == 2 and why in failed.stderr, failed.stderr


def test_two_commands_do_not_write_into_one_folder(folder, tmp_path):
    (tmp_path / "out").mkdir()
    words = ("monitor", folder, "-o", tmp_path / "out", "--workers", "1")
    hold = ("import sys; sys.path.insert(0, sys.argv[1])\n"
            "from trackbed_post.monitor import command\n"
            "with command.alone(__import__('pathlib').Path(sys.argv[2])):\n"
            "    print('held', flush=True); sys.stdin.read()")
    with subprocess.Popen([sys.executable, "-c", hold, conftest.ROOT / "postproc",
                           tmp_path / "out"], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"held\n"
        ran = conftest.call(*words)
        assert ran.returncode == 2 and "another monitor command is writing there" in ran.stderr
        other.kill()  # as by a queue's limit
    assert conftest.call(*words).returncode == 0
    assert not (folder / ".lock").exists()


def test_changed_lines_are_evaluated_again(folder, tmp_path):
    words = ("monitor", folder, "-o", tmp_path / "out", "--workers", "1")
    lines = ["file,begin,speed_m_s", "p0.csv,2026-05-03,30", "p1.csv,2026-05-01,40"]
    for changed, new in ((lines, 2), (lines, 0), ([*lines[:2], "p1.csv,2026-05-01,41"], 1),
                         ([*lines[:2], "p1.csv,2026-06-01,41"], 1)):
        (folder / "passages.csv").write_text("\n".join(changed) + "\n", encoding="utf-8")
        ran = conftest.call(*words)
        assert f"{new} passages are new" in ran.stdout, ran.stdout + ran.stderr
    assert [(row["begin"], row["speed_m_s"]) for row in rows_of(tmp_path / "out/monitor.csv")] == [
        ("2026-05-03", "30"), ("2026-06-01", "41")]


def test_ctrl_c_ends_a_batch_that_the_same_command_continues(folder, tmp_path):
    for number in range(300):
        os.link(folder / "p0.csv", folder / f"copy_{number}.csv")
    lines = [f"copy_{number}.csv,30" for number in range(300)]
    (folder / "passages.csv").write_text("file,speed_m_s\n" + "\n".join(lines) + "\n")
    table = tmp_path / "out/monitor.csv"
    words = [sys.executable, conftest.ROOT / "postproc", "monitor", folder, "-o", tmp_path / "out",
             "--workers", "2"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True, start_new_session=True) as ran:
        end = time.monotonic() + 60
        while not (table.is_file() and table.read_bytes().count(b"\n") > 5):
            assert time.monotonic() < end and ran.poll() is None
            time.sleep(0.02)
        os.killpg(ran.pid, signal.SIGINT)  # as a terminal does
        _, errors = ran.communicate(timeout=60)
    assert ran.returncode == 3
    assert errors == "stopped; the same command continues it\n"
    done = rows_of(table)
    assert 5 <= len(done) < 300
    (folder / "passages.csv").write_text("file,speed_m_s\n" + "\n".join(lines[:len(done)])
                                         + "\n")
    assert conftest.call(*words[2:]).returncode == 0
    assert rows_of(table) == done


def test_command_line(folder, tmp_path):
    ran = conftest.call("monitor", folder, "-o", tmp_path / "out", "--workers", "1")
    assert ran.returncode == 0, ran.stderr
    assert "4 passages are new, 2 of 4 could not be evaluated" in ran.stdout
    for name in ("monitor.csv", "trends.png", "passage.png", "trends.csv"):
        assert (tmp_path / "out" / name).stat().st_size > 60
    for words, why in (((tmp_path / "none", "-o", tmp_path / "new"), "is no folder"),
                       ((folder, "--workers", "0", "-o", tmp_path / "out"), "at least 1"),
                       ((folder, "--wavelengths", "1", "1", "-o", tmp_path / "out"), "different"),
                       ((folder, "--wavelengths", "2", "0.2", "-o", tmp_path / "out"),
                        "choose another folder"),
                       ((folder, "-o", folder), "choose another folder")):
        failed = conftest.call("monitor", *words)
        assert failed.returncode == 2 and why in failed.stderr, failed.stderr
    for content, why in ((b"file,spead\np0.csv,3\n", "known are file, begin"),
                         (b"file,begin\np0.csv,1,2\n", "more fields than names"),
                         (b"file\np0.csv\np0.csv\n", "lists p0.csv more than once"),
                         ("file,begin\np0.csv,März\n".encode("latin-1"), "is not in UTF-8"),
                         (b"file\nbroken.csv\n", "no passage could be evaluated")):
        (folder / "passages.csv").write_bytes(content)
        failed = conftest.call("monitor", folder, "-o", tmp_path / why[:5])
        assert failed.returncode == 2 and why in failed.stderr, failed.stderr
