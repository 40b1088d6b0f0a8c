"""Trains in the order opposite to that of the kernel's deck, and towards smaller x."""
import dataclasses

import conftest
import numpy as np
import pytest
import test_inverse
from test_inverse import LOAD, MASS, RATE, SENSOR, SPEED, STEP

from trackbed_post import read
from trackbed_post.monitor import direction, forces, greens, inverse

# Two coaches, the first one heavier.
BEHIND = np.array([0.0, 2.5, 12.0, 14.5, 22.0, 24.5, 38.0, 40.5])
HEAVY = np.repeat([1.3 * LOAD, LOAD], 4)
DIP, COUNT = 20.3, 5000  # m, place of the impacts; samples


def kernel_of_two(stiffer_behind=1.0):
    """A track of formulas whose responses to forces behind the sensor are divided by this."""
    kernel = test_inverse.kernel_of_formulas()
    part = np.where(kernel.x > SENSOR, 1 / stiffer_behind, 1.0)[:, None]
    wheels = dataclasses.replace(kernel.wheels, behind=BEHIND, load=HEAVY, mass=np.full(8, MASS))
    return dataclasses.replace(kernel, wheels=wheels, fixed={"left": {
        name: part * table for name, table in kernel.fixed["left"].items()}})


def acceleration_of(kernel, turned, sign):
    """Sensor's signal of a train whose leading wheel starts 60 m before the sensor and runs towards
    larger (sign 1) or smaller x, with an impact of each wheel at DIP."""
    wheels = kernel.wheels.turned() if turned else kernel.wheels
    total = np.zeros(COUNT)
    for behind, load in zip(wheels.behind, wheels.load):
        places = SENSOR + sign * (STEP * np.arange(COUNT) - 60.0 - behind)
        impact = 60e3 * np.exp(-((places - DIP) / 0.12)**2)
        on_track = (places >= 0) & (places <= kernel.x[-1])
        total += greens.superposed(kernel.fixed["left"]["acceleration"], kernel.x, places,
                                   on_track * (load + impact), COUNT)
    size = 1e-3 * np.sqrt(np.mean(total**2))
    return total + size * np.random.default_rng(1).standard_normal(COUNT)


def errors(found, lead):
    """(relative error of the largest force of the first wheel, error of its place, m)."""
    size, _, place = found.peak()
    return abs(size / (lead + 60e3) - 1), abs(place - DIP)


@pytest.mark.parametrize("turned, order", [(False, 1), (True, -1)])
def test_order_is_recognised_and_the_forces_are_those_of_the_first_bogie(turned, order):
    kernel = kernel_of_two()
    found, came, _ = inverse.evaluate(acceleration_of(kernel, turned, 1), kernel, SPEED)
    assert came.order == order
    assert came.start == pytest.approx(SENSOR - 60.0, abs=0.05)
    off, away = errors(found, LOAD if turned else 1.3 * LOAD)
    assert off < 0.05 and away < 0.06
    surface = inverse.irregularity(found, came.kernel, SPEED, draws=0)
    assert np.all(np.isfinite(surface.height))


def test_direction_must_be_given_where_the_track_is_not_symmetric():
    kernel = kernel_of_two(1.3)
    assert direction.asymmetry(kernel) == pytest.approx(2 * 0.3 / 2.3, rel=1e-3)
    signal = acceleration_of(kernel, True, 1)
    with pytest.raises(read.Unreadable, match="differ by 26 %.*limit 5 %.*--towards larger"):
        inverse.evaluate(signal, kernel, SPEED)
    # In the order of the deck no direction is needed.
    ahead, came, _ = inverse.evaluate(acceleration_of(kernel, False, 1), kernel, SPEED)
    assert came.order == 1 and max(errors(ahead, 1.3 * LOAD)) < 0.06
    right, _, _ = inverse.evaluate(signal, kernel, SPEED, towards="larger")
    assert max(errors(right, LOAD)) < 0.06


@pytest.mark.parametrize("turned", [False, True])
def test_train_towards_smaller_x(turned):
    kernel = kernel_of_two(1.3)
    signal, lead = acceleration_of(kernel, turned, -1), LOAD if turned else 1.3 * LOAD
    found, came, moved = inverse.evaluate(signal, kernel, SPEED, towards="smaller")
    assert came.order == (-1 if turned else 1)
    assert came.start == pytest.approx(SENSOR + 60.0, abs=0.05)
    assert np.all(np.diff(found.x) > 0) and max(errors(found, lead)) < 0.06
    drawn = found.draw(np.random.default_rng(2))
    assert np.abs(drawn - found.force).max() < 10 * found.deviation.max()
    words = " ".join(forces.remarks_of(came, moved))
    assert ("towards smaller x" in words) == turned
    with pytest.raises(read.Unreadable, match="mirror image"):
        inverse.irregularity(found, came.kernel, SPEED)
    # With the other direction the largest force is at the mirror image, and wrong.
    other, _, _ = inverse.evaluate(signal, kernel, SPEED, towards="larger")
    assert min(errors(other, lead)) > 0.06


def test_train_that_looks_the_same_from_both_ends_has_no_order():
    kernel = kernel_of_two(1.3)
    alike = dataclasses.replace(kernel, wheels=dataclasses.replace(
        kernel.wheels, behind=np.array([0.0, 2.5, 19.0, 21.5]), load=np.full(4, LOAD),
        mass=np.full(4, MASS)))
    assert direction.of_passage(alike, None, None) == (alike, 0)
    # Nor has one whose loads differ less than the displacement tells.
    assert direction.of_passage(kernel, None, lambda one: 0.98 + 0.004 * (one is kernel)) == (
        kernel, 0)
    with pytest.raises(read.Unreadable, match="larger or smaller"):
        direction.of_passage(kernel, "left", None)


def test_mirror_image_twice_is_the_track():
    kernel = dataclasses.replace(kernel_of_two(1.3), sensor=19.0)
    once = kernel.mirrored()
    assert once.sensor == pytest.approx(21.0) and once.towards == "smaller"
    assert direction.asymmetry(once) == pytest.approx(direction.asymmetry(kernel))
    twice = once.mirrored()
    assert twice.sensor == pytest.approx(19.0) and twice.towards == "larger"
    for name, table in kernel.fixed["left"].items():
        assert np.array_equal(twice.fixed["left"][name], table)
    assert kernel.wheels.turned().turned().alike(kernel.wheels)
    assert not kernel.wheels.turned().alike(kernel.wheels)


def test_command(tmp_path):
    kernel = kernel_of_two(1.3)
    test_inverse.write_kernel(tmp_path / "kernel.h5", kernel)
    np.savetxt(tmp_path / "sensor.csv", np.column_stack([np.arange(COUNT) / RATE,
                                                         acceleration_of(kernel, True, -1)]),
               delimiter=",", header="time_s,sleeper_m_s2", comments="")
    words = ("forces", tmp_path / "sensor.csv", "--kernel", tmp_path / "kernel.h5", "--speed", "50",
             "-o", tmp_path / "out")
    refused = conftest.call(*words)
    assert refused.returncode == 2 and "--towards smaller" in refused.stderr
    ran = conftest.call(*words, "--towards", "smaller")
    assert ran.returncode == 0, ran.stderr
    assert "order opposite to that of the deck" in ran.stdout
    assert "no irregularity" in ran.stdout and "mirror image" in ran.stdout
    table = np.genfromtxt(tmp_path / "out" / "forces.csv", delimiter=",", names=True)
    assert table["x_m"][np.argmax(table["force_1_kN"])] == pytest.approx(DIP, abs=0.06)
