"""Change of indicators over many passages, and alarms."""
import datetime

import numpy as np
import pytest

from trackbed_post.monitor import trends


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
