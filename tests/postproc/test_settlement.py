"""Laws of settlement against published numbers, their fit, traffic, and the check of a jump."""
import dataclasses
import types

import numpy as np
import pytest

from trackbed_post import read
from trackbed_post.settlement import course, laws, traffic


def test_varandas_settles_by_the_reference_values():
    law = laws.Varandas()
    assert 1e3 * law.settlement([50e3], 1e5) == pytest.approx(6.3329, abs=5e-5)
    assert 1e3 * law.settlement([50e3], 1e6) == pytest.approx(10.0, abs=5e-5)


def test_varandas_equals_its_sum_force_by_force():
    law, peaks, trains = laws.Varandas(), [50e3, 30e3, 30e3, 10e3], 40
    levels = np.linspace(0, 60e3, 6001)
    middle, width = 0.5 * (levels[1:] + levels[:-1]), np.diff(levels)
    exceeded, done = np.zeros(len(middle)), 0.0
    for peak in peaks * trains:
        below = middle < peak
        done += np.sum(middle[below] ** law.alpha * (exceeded[below] + 1) ** -law.beta
                       * width[below])
        exceeded[below] += 1
    whole = law.force ** (law.alpha + 1) / (law.alpha + 1) * np.sum(
        np.arange(1.0, law.count + 1) ** -law.beta)
    assert law.settlement(peaks, trains) == pytest.approx(law.reference * done / whole, rel=1e-5)


def test_order_of_the_forces_does_not_matter():
    law = laws.Varandas()
    assert law.settlement([10e3, 50e3, 30e3], 7) == law.settlement([50e3, 30e3, 10e3], 7)


@pytest.mark.parametrize("exponent", (0.5, 0.82, 1.0, 1.3))
def test_sum_of_powers_is_exact(exponent):
    for count in (1, 999, 1001, 5000, 100000):
        terms = np.arange(1.0, count + 1) ** -exponent
        assert laws.sum_of_powers(count, exponent) == pytest.approx(terms.sum(), rel=1e-11)


def test_li_selig_strains_by_the_reference_value():
    assert 1e2 * laws.li_selig(1e6, 0.4, "CL") == pytest.approx(1.6051, abs=5e-5)


def test_shenton_by_hand():
    # 20 t, lift 10 mm, a million axles: 1.1 (0.97 10^1.2 + 2.7) mm
    assert 1e3 * laws.shenton(1e6, 20, 10e-3) == pytest.approx(1.1 * (0.97 * 10 ** 1.2 + 2.7))


@pytest.mark.parametrize("exponent", (-0.4, 0.0, 0.2, 0.7))
def test_fit_finds_the_exponent(exponent):
    count = np.arange(1.0, 200)
    settled = 1e-3 + 2e-4 * laws.law(count, exponent)
    logarithm, power = laws.fit(count, settled)
    assert power.exponent == pytest.approx(exponent, abs=5.1e-3)
    assert power.at(1e4) == pytest.approx(1e-3 + 2e-4 * laws.law(1e4, exponent), rel=2e-2)
    assert (logarithm.scatter < 1e-12) == (exponent == 0)


def test_the_standard_error_of_a_jump_is_that_of_intermittent_sleepers():
    """Sleepers settle by equal steps at times that are even in the logarithm of the cycles."""
    random, off = np.random.default_rng(1), []
    cycles = np.concatenate([np.arange(81), [160, 161]]).astype(float)
    stage = np.array([0] * 81 + [1, 2])
    for _ in range(200):
        times = random.uniform(0, np.log(200), (16, 40))  # of steps of 0.1 mm
        settled = 1e-4 * (times[None] < np.log1p(cycles)[:, None, None]).sum(axis=2)
        one, = course.aims(course.Course(cycles, settled, cycles, stage, stage == 1),
                           {"jump": {"cycles": 20, "exponent": 0.0}})
        off.append((one.settled - one.aimed) / one.error)
        assert (one.begin, one.end) == (80, 160)
    assert np.std(off) == pytest.approx(1, abs=0.25) and abs(np.mean(off)) < 0.2
    assert np.mean(np.abs(off) < 1) == pytest.approx(0.68, abs=0.1)


def test_the_standard_error_does_not_contain_what_a_jump_has_settled():
    """A jump of ten cycles, as long as an increment, settles much."""
    cycles = np.concatenate([np.arange(41), [50], np.arange(51, 91), [400]]).astype(float)
    jumped = np.isin(cycles, (50, 400))
    random = np.random.default_rng(1)
    settled = 1e-3 * np.log1p(cycles)[:, None] + 1e-5 * random.standard_normal((len(cycles), 8))
    stage = np.concatenate([np.full(41, 0), [1], np.full(40, 2), [3]])

    def error(more):
        return course.aims(course.Course(cycles, settled + more * (cycles >= 50)[:, None]
                                         * np.arange(8), cycles, stage, jumped),
                           {"jump": {"cycles": 20, "exponent": 0.0}})[1].error
    assert error(1e-2) == pytest.approx(error(0.0)) and error(0.0) > 0


def test_sleepers_that_settle_evenly_have_no_standard_error():
    cycles = np.arange(82).astype(float)
    settled = 1e-3 * np.log1p(cycles)[:, None] * np.linspace(0.5, 1.5, 8)
    stage = np.array([0] * 81 + [1])
    one, = course.aims(course.Course(cycles, settled, cycles, stage, stage == 1), {})
    assert one.error == pytest.approx(0, abs=1e-12) and one.aimed > 0
    few, = course.aims(course.Course(cycles[:32], settled[:32], cycles[:32],
                                     np.array([0] * 31 + [1]), np.arange(32) == 31), {})
    assert np.isnan(few.error)


def test_a_good_jump_has_no_error_and_one_too_far_is_found():
    """Of a settlement by the logarithm; after the second jump it goes on at twice its rate."""
    cycles = np.concatenate([np.arange(0, 41), [100], np.arange(101, 141), [400],
                             np.arange(401, 441)]).astype(float)
    settled = 1e-3 * np.log1p(cycles)
    settled[cycles > 400] = settled[cycles == 400] + 2e-3 * (np.log1p(cycles[cycles > 400])
                                                             - np.log(401))
    stage = np.concatenate([np.full(41, 1), [2], np.full(40, 3), [4], np.full(40, 5)])
    found = course.Course(cycles, settled[:, None], cycles, stage, np.isin(stage, (2, 4)))
    first, second = course.checks(found, {"jump": {"cycles": 20, "exponent": 0.0}})
    assert first.lack == pytest.approx(0, abs=1e-12)
    assert second.found == pytest.approx(2 * second.expected)
    assert second.lack == pytest.approx(0.5 * second.settled)


def test_traffic_counts_axles_and_tonnes(tmp_path):
    table = tmp_path / "traffic.csv"
    table.write_text("name,trains_per_day,axles,axle_load_t\nfreight,10,100,20\ncoach,50,32,10\n",
                     encoding="utf-8")
    found = traffic.traffic_from(table)
    assert found.tonnes_per_day() == 10 * 100 * 20 + 50 * 32 * 10
    assert found.axles_per_day(20, 2) == pytest.approx(1000 + 1600 / 4)
    with pytest.raises(read.Unreadable, match="--load-exponent"):
        found.axles_per_day(20)


def test_several_axle_loads_need_that_of_the_run():
    trains = (traffic.Trains("freight", 10, 100, 20), traffic.Trains("coach", 50, 32, 10))
    with pytest.raises(read.Unreadable, match="--axle-load"):
        traffic.Traffic(trains).axles_per_day()


@pytest.mark.parametrize("text, words", (
    ("axles,axle_load_t\n4,20\n", "no column trains_per_day"),
    ("trains_per_day,axles,axle_load_t\n", "no trains"),
    ("trains_per_day,axles,axle_load_t\n-1,4,20\n", "trains_per_day must be a number above 0"),
    ("trains_per_day,axles,axle_load_t\n1,4,x\n", "axle_load_t must be a number above 0")))
def test_bad_traffic_is_refused(tmp_path, text, words):
    table = tmp_path / "traffic.csv"
    table.write_text(text, encoding="utf-8")
    with pytest.raises(read.Unreadable, match=words):
        traffic.traffic_from(table)


def test_forecast_of_days_and_tonnes():
    from trackbed_post.settlement import command
    trains = traffic.Traffic((traffic.Trains("freight", 10, 100, 20),))
    forecast = command.Forecast(trains, 100.0, 4.0, 20.0)
    assert forecast.cycles_per_day() == 250
    assert forecast.megatonnes() == pytest.approx(2)
    fits = laws.fit(np.arange(1.0, 100), 1e-3 * laws.law(np.arange(1.0, 100), 0.0))
    given = types.SimpleNamespace(lift=10.0, force=50.0, subgrade=("CL", 0.4, 1.5))
    days, curves = command.forecast_curves(forecast, fits, given)
    assert days[-1] == 100
    assert curves["logarithm, fitted"][-1] == pytest.approx(1e-3 * np.log1p(25000))
    assert 1e3 * curves["Varandas"][-1] == pytest.approx(6.3329, abs=5e-5)
    assert curves["Shenton"][-1] == pytest.approx(laws.shenton(1e5, 20, 10e-3))
    assert curves["Li and Selig, 1.5 m of CL"][-1] == pytest.approx(1.5 * laws.li_selig(1e5, 0.4,
                                                                                       "CL"))


def course_of(settled, ground=None, cycles=12):
    count = np.arange(cycles + 1.0)
    return course.Course(count, settled(count)[:, None], count, np.zeros(cycles + 1, int),
                         np.zeros(cycles + 1, bool), None if ground is None else ground(count))


@pytest.mark.parametrize("power, limit", [(1.6, 1.0), (-2.0, -1.0), (0.5, None)])
def test_an_exponent_at_its_limit_is_no_law(power, limit):
    from trackbed_post.settlement import command
    found = course_of(lambda n: 1e-3 * laws.law(n, power))
    logarithm, fit = command.fitted(found, 1)
    text = command.table_of("made", found, [logarithm, fit], [], [])
    words = f"power: exponent at its limit, b = {limit}: no law can be read from so few passages"
    assert fit.at_limit == (limit is not None) and not logarithm.at_limit
    if limit is None:
        assert "0.000 mm + 1 mm * ((1 + N)^b - 1)/b with b = 0.5;" in text
    else:
        assert words.replace(".0:", ":") in text and text.count("((1 + N)^b") == 1


def test_no_law_on_a_ground_that_vibrates():
    from trackbed_post.settlement import command

    def settled(n):
        return 1e-3 * np.log1p(n)
    amount = np.ptp(settled(np.arange(1, 13)))
    for part, law in ((0.09, True), (0.11, False)):
        found = course_of(settled, lambda n, part=part: part * amount / 2 * np.cos(np.pi * n))
        assert bool(command.fitted(found, 1)) == law
    why = command.why_no_laws(found, 1)
    assert "the ground vibrates, and rises by up to 0.21 mm" in why and "settle by 1.9 mm" in why
    yielding = course_of(settled, lambda n: 5e-4 * np.log1p(n))
    assert command.why_no_laws(yielding, 1) == "" and len(command.fitted(yielding, 1)) == 2


def test_a_forecast_of_one_law_has_no_known_uncertainty():
    from trackbed_post.settlement import command
    forecast = command.Forecast(traffic.Traffic((traffic.Trains("one", 10, 100, 20),)), 100.0, 4.0)
    fits = laws.fit(np.arange(1.0, 10), 1e-3 * np.arange(1.0, 10)**2)
    given = types.SimpleNamespace(lift=None, force=None, subgrade=None)
    curves = command.forecast_curves(forecast, [one for one in fits if not one.at_limit], given)
    text = command.forecast_table(forecast, *curves)
    assert "its uncertainty is not known" in text and "differ by" not in text


def test_the_ground_of_a_run_is_read_at_the_ends_of_cycles(runs):
    run = runs[0]
    height = -1e-3 * np.arange(len(run.time))[:, None] * (run.ground_x / run.ground_x.max())[None]
    moved = dataclasses.replace(run, ground={"displacement": read.Quantity(height, "m", "-")})
    mean = np.mean(run.sleepers_x) / run.ground_x.max()
    assert course.ground_below(moved, np.array([5, 15])) == pytest.approx([0, 10e-3 * mean])
    assert course.ground_below(run, np.array([5, 15])) is None
