"""Wheel forces and irregularity by Green's functions of a track whose responses are formulas."""
import dataclasses

import conftest
import h5py
import numpy as np
import pytest

from trackbed_post import read
from trackbed_post.monitor import displacement, forces, greens, inverse, regularised

RATE, SPEED, LENGTH, SENSOR = 2000.0, 50.0, 40.0, 20.0
LOAD, MASS, CONSTANT = 75e3, 600.0, 9e10
STEP = SPEED / RATE


def vibration(lag, frequency, damping, mass):
    """Displacement after an impulse of one sample of 1 N, and its second difference."""
    omega = 2 * np.pi * frequency
    root = omega * np.sqrt(1 - damping**2)
    moved = np.exp(-damping * omega * lag) * np.sin(root * lag) / (root * mass) / RATE
    padded = np.pad(moved, 1)
    return moved, (padded[2:] - 2 * moved + padded[:-2]) * RATE**2


def kernel_of_formulas():
    """A sleeper that responds to forces within about 1.5 m; a rail that springs back at 80 Hz."""
    x = np.arange(0, LENGTH + 1e-9, STEP)
    lag = np.arange(300) / RATE
    near = np.exp(-np.abs((x - SENSOR) / 0.9)**1.5)[:, None]
    moved, second = vibration(lag, 50.0, 0.4, 500.0)
    of_rail = vibration(lag, 80.0, 0.3, 300.0)[0]
    moving = []
    for behind in (0.0, 2.5):
        apart = behind + SPEED * lag
        moving.append(np.tile(np.exp(-(apart / 1.5)**2) * of_rail, (len(x), 1)))
    return greens.Kernel(
        rate=RATE, sensor=SENSOR, side="left", speed=SPEED, x=x,
        fixed={"left": {"displacement": near * moved, "acceleration": near * second}},
        wheels=greens.Wheels(np.array([0.0, 2.5, 19.0, 21.5]), np.full(4, LOAD), np.full(4, MASS),
                             CONSTANT, 1.5),
        moving={"left": moving}, moving_x=x, behind=np.array([0.0, 2.5]))


@dataclasses.dataclass
class Passage:
    kernel: greens.Kernel
    start: float
    acceleration: np.ndarray
    displacement: np.ndarray
    x: np.ndarray       # m
    force: np.ndarray   # N, of both wheels of the first bogie at x


@pytest.fixture(scope="module", name="passage")
def passage_over_a_dip():
    """Each wheel has an impact at 20.3 m of about 60 kN, which differs by 5 % between them."""
    kernel, start, count = kernel_of_formulas(), -60.0, 5000
    passing = inverse.Passing(kernel, start, count, SPEED)
    x = np.arange(SENSOR - 3, SENSOR + 4 + 1e-9, STEP)
    impact = 60e3 * np.exp(-((x - 20.3) / 0.12)**2) - 20e3 * np.exp(-((x - 20.0) / 0.2)**2)
    response = {}
    for quantity in greens.QUANTITIES:
        response[quantity] = passing.of_static(quantity)
        for wheel in range(4):
            response[quantity] = response[quantity] + passing.matrix(
                quantity, wheel, x, np.arange(count)) @ (impact * (1 + 0.05 * (wheel % 2)))
    force = LOAD + np.array([impact, 1.05 * impact])
    return Passage(kernel, start, response["acceleration"], response["displacement"], x, force)


def noisy(passage, part, seed=1):
    size = part * np.sqrt(np.mean(passage.acceleration**2))
    return passage.acceleration + size * np.random.default_rng(seed).standard_normal(
        len(passage.acceleration))


def identified(passage, part=1e-3, **choices):
    problem = inverse.Problem(noisy(passage, part), passage.kernel, SPEED, passage.start)
    return inverse.identify(problem, **choices)


@pytest.mark.parametrize("part", [1e-3, 1e-2])
def test_forces_are_found(passage, part):
    found = identified(passage, part)
    for wheel in (0, 1):
        size, deviation, place = found.peak(wheel)
        assert size == pytest.approx(passage.force[wheel].max(), rel=0.05)
        assert place == pytest.approx(20.3, abs=0.06) and deviation < 0.05 * size
        assert np.abs(found.force[wheel] - passage.force[wheel]).max() < 0.1 * size


def test_deviation_is_that_of_the_errors(passage):
    errors = []
    for seed in range(5):
        problem = inverse.Problem(noisy(passage, 3e-3, seed), passage.kernel, SPEED, passage.start)
        found = inverse.identify(problem)
        errors.append((found.force - passage.force) / found.deviation)
    assert 0.3 < np.sqrt(np.mean(np.square(errors))) < 2


def test_draws_scatter_by_the_deviation(passage):
    found = identified(passage, 1e-2)
    random = np.random.default_rng(2)
    drawn = np.array([found.draw(random) for _ in range(200)])
    assert np.mean(drawn.std(axis=0) / found.deviation) == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize("choices", [
    {"method": "truncated"}, {"criterion": "l_curve"}, {"criterion": "residual", "noise": 0.05},
    {"likeness": 0.0}])
def test_other_choices_find_similar_forces(passage, choices):
    found = identified(passage, 3e-3, **choices)
    assert found.force[0].max() == pytest.approx(passage.force[0].max(), rel=0.15)


def test_unknown_choices_are_refused(passage):
    for choices in ({"method": "ridge"}, {"criterion": "aic"}):
        with pytest.raises(read.Unreadable, match="these are"):
            identified(passage, **choices)
    with pytest.raises(read.Unreadable, match="the least residual of any strength"):
        identified(passage, 3e-3, criterion="residual", noise=1e-6)
    with pytest.raises(read.Unreadable, match="needs the noise"):
        identified(passage, 3e-3, criterion="residual")
    with pytest.raises(read.Unreadable, match="begins or ends while"):
        inverse.Problem(passage.acceleration[:2800], passage.kernel, SPEED, passage.start)
    alone = dataclasses.replace(passage.kernel, wheels=None)
    with pytest.raises(read.Unreadable, match="without a train"):
        inverse.evaluate(passage.acceleration, alone, SPEED)
    with pytest.raises(read.Unreadable, match="no quantity"):
        inverse.Problem(passage.acceleration, passage.kernel, SPEED, passage.start, "velocity")


def test_train_is_placed(passage):
    moved = displacement.reconstruct(passage.acceleration, RATE, SPEED)
    came = inverse.arrival(moved, passage.kernel, SPEED)
    assert came.start == pytest.approx(passage.start, abs=0.1)
    static = inverse.Passing(passage.kernel, passage.start, 5000, SPEED)
    alone = displacement.reconstruct(static.of_static("acceleration"), RATE, SPEED)
    assert inverse.arrival(alone, passage.kernel, SPEED).ratio == pytest.approx(1, abs=0.02)
    for off in (-0.05, 0.04):
        problem = inverse.Problem(passage.acceleration, passage.kernel, SPEED, passage.start + off)
        shift, _ = inverse.placed(problem, 0.1)
        assert shift == pytest.approx(off, abs=0.6 * STEP)
    with pytest.raises(read.Unreadable, match="cannot be found"):
        inverse.placed(inverse.Problem(passage.acceleration, passage.kernel, SPEED,
                                       passage.start + 1.0), 0.1)


def test_whole_chain_also_with_a_reversed_sensor(passage):
    for sign in (1, -1):
        found, came, moved = inverse.evaluate(sign * noisy(passage, 1e-3), passage.kernel, SPEED)
        assert moved.reversed == (sign < 0)
        assert found.force[0].max() == pytest.approx(passage.force[0].max(), rel=0.1)
        assert any("upside down" in one for one in forces.faults_of(moved)) == moved.reversed
    heavy = dataclasses.replace(passage.kernel, wheels=dataclasses.replace(
        passage.kernel.wheels, load=1.5 * passage.kernel.wheels.load))
    assert "other ones" in forces.remarks_of(inverse.arrival(moved, heavy, SPEED), moved)[0]


def test_irregularity_follows_from_true_forces(passage):
    """The wheel is a free mass on a rail that yields: the irregularity that would cause the forces
    is integrated here from rest."""
    kernel = passage.kernel
    true = inverse.Forces(passage.x, passage.force, 0 * passage.force, 0, (),
                          lambda random: passage.force)
    found = inverse.irregularity(true, kernel, SPEED, draws=2)
    change = passage.force - LOAD
    lift = np.cumsum(np.cumsum(change[0])) / MASS / RATE**2
    rail = np.zeros(len(passage.x))
    for wheel, behind in enumerate((0, 100)):
        table = kernel.moving["left"][wheel][0]
        for sample, force in enumerate(change[wheel]):
            lags = np.arange(len(table)) + sample + behind
            inside = lags < len(rail)
            rail[lags[inside]] -= force * table[:np.sum(inside)]
    expected = lift - rail + (passage.force[0] / CONSTANT)**(2 / 3)
    difference = found.height - expected
    drift = np.polyval(np.polyfit(found.x - 20, difference, inverse.DRIFT), found.x - 20)
    assert np.abs(difference - drift).max() < 1e-3 * np.ptp(found.height)
    assert found.depth[0] > 0 and found.deviation.max() == 0


@pytest.mark.parametrize("change, why", [
    ({"moving": {}}, "--speed 50"), ({"speed": 40.0}, "that of 40 m/s"),
    ({"behind": np.array([0.0])}, "--axles 2"), ({"behind": np.array([0.0, 3.0])}, "0, 3 m behind"),
    ({"moving_x": np.arange(14, 40, STEP)}, "--from 9.5 or less")])
def test_irregularity_needs_the_moving_response(passage, change, why):
    true = inverse.Forces(passage.x, passage.force, 0 * passage.force, 0, (), None)
    with pytest.raises(read.Unreadable, match=why):
        inverse.irregularity(true, dataclasses.replace(passage.kernel, **change), SPEED)


def test_remedy_for_a_bogie_that_is_not_the_first_of_the_train(passage):
    """A coach before a locomotive with three axles in a bogie: --axles 3 alone, of this train,
    would be axles 0, 2.5 and 19 m behind the first."""
    kernel = dataclasses.replace(passage.kernel, wheels=greens.Wheels(
        np.array([0.0, 2.5, 19.0, 21.5, 26.0, 27.8, 29.6]), np.full(7, LOAD), np.full(7, MASS),
        CONSTANT, 1.5))
    true = inverse.Forces(passage.x, passage.force, 0 * passage.force, 0, (), None)
    why = r"0, 2.5 m .* 0, 1.8, 3.6 m .*--axles 3 and a deck whose train begins with this bogie"
    with pytest.raises(read.Unreadable, match=why):
        inverse.irregularity(true, kernel, SPEED, first=4)


def test_solutions_by_formula():
    """Of a diagonal matrix the regularised solution is known."""
    values = np.array([4.0, 1.0, 0.01])
    right = np.array([8.0, 3.0, 0.5])
    found = regularised.Solution(np.linalg.svd(np.diag(values)), right)
    limit = found.strength * values[0]
    assert found.unknown == pytest.approx(values * right / (values**2 + limit**2))
    cut = regularised.Solution(np.linalg.svd(np.diag(values)), right, "truncated", "residual", 0.5)
    assert cut.unknown == pytest.approx([2, 3, 0], abs=1e-12)
    assert cut.residual == pytest.approx(0.5 / np.sqrt(3))


def write_kernel(path, kernel):
    with h5py.File(path, "w") as file:
        file.attrs.update({"kind": np.bytes_(greens.KIND), "rate": RATE, "sensor_x": SENSOR,
                           "side": np.bytes_("left"), "speed": SPEED})
        names = {"fixed/x": kernel.x, "moving/x": kernel.moving_x, "axles": np.array([0.0, 2.5]),
                 "train/behind": kernel.wheels.behind, "train/load": kernel.wheels.load,
                 "train/mass": kernel.wheels.mass}
        names |= {f"fixed/left/{name}": one for name, one in kernel.fixed["left"].items()}
        names |= {f"moving/left/axle_{axle + 1}": one
                  for axle, one in enumerate(kernel.moving["left"])}
        for name, values in names.items():
            file[name] = values
        file["train"].attrs.update({"contact_constant": CONSTANT, "contact_exponent": 1.5})


def test_command(passage, tmp_path):
    write_kernel(tmp_path / "kernel.h5", passage.kernel)
    time = np.arange(len(passage.acceleration)) / RATE
    np.savetxt(tmp_path / "sensor.csv", np.column_stack([time, noisy(passage, 1e-3)]),
               delimiter=",", header="time_s,sleeper_m_s2", comments="")
    words = (tmp_path / "sensor.csv", "--kernel", tmp_path / "kernel.h5", "-o", tmp_path / "out")
    ran = conftest.call("forces", *words, "--speed", "50")
    assert ran.returncode == 0, ran.stderr
    assert "largest force of wheel 2" in ran.stdout and "depth of the irregularity" in ran.stdout
    table = np.genfromtxt(tmp_path / "out" / "forces.csv", delimiter=",", names=True)
    assert table["force_1_kN"].max() == pytest.approx(1e-3 * passage.force[0].max(), rel=0.1)
    for name in ("forces.png", "irregularity.csv", "forces.txt"):
        assert (tmp_path / "out" / name).stat().st_size > 60
    other = conftest.call("forces", *words, "--speed", "50.2")
    assert other.returncode == 0 and "with --speed 50.2" in other.stdout, other.stderr
    for axle, why in ((0, "axles 1 to 4"), (2, "follows axle 1"), (9, "axles 1 to 4")):
        failed = conftest.call("forces", *words, "--speed", "50", "--axle", str(axle))
        assert failed.returncode == 2 and why in failed.stderr
    failed = conftest.call("forces", *words, "--speed", "50", "--quantity", "displacement",
                           "--criterion", "residual")
    assert failed.returncode == 2 and "white noise" in failed.stderr
    write_kernel(tmp_path / "coarse.h5", dataclasses.replace(passage.kernel,
                                                             x=4 * passage.kernel.x))
    failed = conftest.call("forces", tmp_path / "sensor.csv", "--kernel", tmp_path / "coarse.h5",
                           "--speed", "50", "-o", tmp_path / "out")
    assert failed.returncode == 2 and "smaller --apart" in failed.stderr
    with h5py.File(tmp_path / "coarse.h5", "a") as file:
        del file["fixed/left/acceleration"]
    for file, why in (("coarse.h5", "no complete file"), (".", "is no file")):
        failed = conftest.call("forces", tmp_path / "sensor.csv", "--kernel", tmp_path / file,
                               "--speed", "50", "-o", tmp_path / "out")
        assert failed.returncode == 2 and why in failed.stderr
    wrong = conftest.call("forces", tmp_path / "sensor.csv", "--kernel", tmp_path / "sensor.csv",
                          "--speed", "50", "-o", tmp_path / "out")
    assert wrong.returncode == 2 and "HDF5" in wrong.stderr


def test_rates_are_changed_or_refused():
    time = np.arange(2000) / 4000.0
    signal = forces.measured.Signal("a", time, np.sin(2 * np.pi * 30 * time), "m/s2", ())
    values, doubtful = forces.at_rate(signal, 2000.0)
    assert len(values) == len(doubtful) == 1000
    assert values[100:-100] == pytest.approx(signal.values[::2][100:-100], abs=1e-3)
    with pytest.raises(read.Unreadable, match="--rate"):
        forces.at_rate(signal, 1999.9)
