"""Displacement of a sleeper and indicators from its acceleration, of passages in closed form."""
import numpy as np
import pytest
import scipy.signal
from passing import DEEP, RATE, Passage, axles, noisy, train

from trackbed_post import measured, read
from trackbed_post.monitor import displacement, indicators


@pytest.fixture(scope="module", name="six")
def six_cars():
    return train(50.0, axles(6), impact=60.0)


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
