"""Calibration of the ballast with a beam on springs in place of the program."""
import sys

import conftest
import numpy as np
import pytest

from trackbed_post import read
from trackbed_post.monitor import ballast, calibration, displacement

RATE, SPEED = 2000.0, 50.0
BEHIND, LOAD, BENDING = np.array([0.0, 2.9, 19.0, 21.9]), 75e3, 6.4e6


class Beam:
    """Winkler's beam whose bed has the stiffness at the sensor below it and that far away beyond:
    a blend of both deflection lines. A void adds what the sleeper falls below a wheel."""
    speed, stiffness, spacing, sensor = SPEED, 30e6, 0.6, 18.0
    sleepers = np.arange(0, 36.3, 0.6)
    loads = np.full(4, LOAD)

    def displacement(self, value):
        x = np.arange(0.0, 60.0, SPEED / RATE)
        found = np.zeros(len(x))
        for behind, load in zip(BEHIND, self.loads):
            apart = np.abs(x - behind - self.sensor)
            lines = []
            for name in ("inside", "outside"):
                root = (value[name] / self.spacing / (4 * BENDING))**0.25
                lines.append(load * root / (2 * value[name] / self.spacing) * np.exp(-root * apart)
                             * (np.cos(root * apart) + np.sin(root * apart)))
            near = np.exp(-(apart / (2 * value["length"]))**2)
            found -= near * lines[0] + (1 - near) * lines[1]
            found -= value["void"] * np.exp(-(apart / 0.8)**4)
            found -= 0.2 * value["dip"] * np.exp(-((x - behind - self.sensor - 1) / 0.5)**2)
        return x, found


def signal_of(value, part=1e-3, seed=1, track=Beam()):
    _, moved = track.displacement({"length": 1.5, "void": 0.0, "dip": 0.0} | value)
    moved = np.pad(moved, (3000, 3000))
    acceleration = np.gradient(np.gradient(moved, 1 / RATE), 1 / RATE)
    size = part * np.sqrt(np.mean(acceleration**2))
    return acceleration + size * np.random.default_rng(seed).standard_normal(len(acceleration))


@pytest.mark.parametrize("inside, outside", [(20e6, 20e6), (10e6, 30e6), (50e6, 25e6)])
def test_stiffness_is_found(inside, outside):
    found, _ = ballast.calibrate(signal_of({"inside": inside, "outside": outside}), RATE, Beam(),
                              ("outside", "inside", "length"))
    assert found.value["inside"] == pytest.approx(inside, rel=0.1)
    for name, true in (("inside", inside), ("outside", outside)):
        assert abs(found.value[name] - true) < 3 * found.deviation[name] + 0.1 * true
    assert found.misfit < 2 and not found.has_void


@pytest.mark.parametrize("inside, outside", [(20e6, 20e6), (10e6, 30e6)])
def test_train_in_the_opposite_order_is_refused(inside, outside):
    class Locomotive(Beam):
        loads = np.array([1.4, 1.4, 1.0, 1.0]) * LOAD
    value = {"inside": inside, "outside": outside}
    ahead, free = signal_of(value, track=Locomotive()), ("outside", "inside")
    found, _ = ballast.calibrate(ahead, RATE, Locomotive(), free)
    assert found.value["inside"] == pytest.approx(inside, rel=0.1)
    with pytest.raises(read.Unreadable, match="correlation is 0.9.*train.vehicles"):
        ballast.calibrate(ahead[::-1], RATE, Locomotive(), free)


def test_dip_does_not_change_the_stiffness():
    given = {"inside": 20e6, "outside": 25e6, "dip": 2e-3}
    found, _ = ballast.calibrate(signal_of(given), RATE, Beam(), ("outside", "inside", "dip"))
    assert found.value["inside"] == pytest.approx(20e6, rel=0.1)
    assert found.value["dip"] == pytest.approx(2e-3, abs=3 * found.deviation["dip"])


@pytest.mark.parametrize("void", [0.0, 4e-4])
def test_void_is_found_where_there_is_one(void):
    found, _ = ballast.calibrate(signal_of({"inside": 20e6, "outside": 20e6, "void": void}), RATE,
                              Beam(), ("outside", "inside", "void"))
    assert found.has_void == (void > 0)
    assert found.value["void"] == pytest.approx(void, abs=4 * found.deviation["void"])


def test_void_that_is_not_significant_does_not_spoil_the_stiffness():
    """What fits better counts for the other values: without the void the sleeper seems softer."""
    signal = signal_of({"inside": 20e6, "outside": 20e6, "void": 1e-4})
    found, _ = ballast.calibrate(signal, RATE, Beam(), ("outside", "inside", "void"))
    without, _ = ballast.calibrate(signal, RATE, Beam(), ("outside", "inside"))
    assert 0 < found.gain < ballast.SIGNIFICANT**2 and not found.has_void
    assert found.value["inside"] == pytest.approx(20e6, rel=0.02)
    assert without.value["inside"] < 0.96 * 20e6
    remark, = calibration.remarks_of(found)
    assert "void of 0.09 mm" in remark and "more than 9" in remark and "--without void" in remark
    assert calibration.remarks_of(without) == []


def test_void_that_fits_worse_does_not_change_the_other_values():
    class Lifting(Beam):
        """Springs with a gap do not pull: the sleeper is lifted farther."""
        def displacement(self, value):
            x, found = super().displacement(value)
            return x, found + (5 * np.maximum(found, 0) if value["void"] > 0 else 0)
    signal, free = signal_of({"inside": 20e6, "outside": 20e6}), ("outside", "inside", "void")
    found, _ = ballast.calibrate(signal, RATE, Lifting(), free)
    without, _ = ballast.calibrate(signal, RATE, Lifting(), free[:2])
    assert found.gain < 0 and not found.has_void
    assert found.value == without.value and found.value["void"] == 0
    assert found.misfit == without.misfit and found.deviation["void"] > 0


def test_what_cannot_be_fitted_is_refused(tmp_path):
    with pytest.raises(read.Unreadable, match="the parameters are outside"):
        ballast.calibrate(signal_of({"inside": 2e7, "outside": 2e7}), RATE, Beam(), ("density",))
    for change, why in (("zone = [{from = 1, to = 2.2, spacing = 0.4}]", "other spacing"),
                        ('dimension = "space"', "two rails"), ("zone = ", "deck.toml")):
        with pytest.raises(read.Unreadable, match=why):
            ballast.Track(program_of(tmp_path), deck_of(tmp_path, change), 2.0, SPEED)
    with pytest.raises(read.Unreadable, match="ended with 1"):
        ballast.Track("false", deck_of(tmp_path, ""), 2.0, SPEED)


def deck_of(folder, words):
    deck = folder / "deck.toml"
    deck.write_text(f"[track]\n{words}\n", encoding="utf-8")
    return deck


def program_of(folder):
    """A program that writes a result of the deck, with what it leaves out."""
    program = folder / "program.py"
    program.write_text(f"""#!{sys.executable}
import pathlib, sys
import h5py
deck = pathlib.Path(sys.argv[2]).read_text() + "length = 12\\nspacing = 0.6\\n"
with h5py.File(pathlib.Path(sys.argv[-2]) / "results.h5", "w") as file:
    file.attrs.update({{"deck": deck + "[ballast]\\nstiffness = 6e7\\n", "version": "0"}})
""", encoding="utf-8")
    program.chmod(0o755)
    return program


def test_residuals_are_those_of_the_whole_train():
    class Long(Beam):
        def displacement(self, value):
            x = np.arange(0.0, 160.0, SPEED / RATE)
            return x, np.interp(x % 60.0, *super().displacement(value))
    track, value = Long(), {"inside": 2e7, "outside": 2e7, "length": 1.5, "void": 0.0, "dip": 0.0}
    moved = np.pad(track.displacement(value)[1], (3000, 3000))
    found = displacement.reconstruct(np.gradient(np.gradient(moved, 1 / RATE), 1 / RATE), RATE,
                                     SPEED)
    fit = ballast.Fit(track, found, RATE, ["inside", "outside"])
    at = fit.unknown(value | {"inside": 1e7})
    _, measured, model, weight = fit.compared(at)
    assert len(model) > 600
    assert np.sum(fit.residuals(at)**2) == pytest.approx(np.sum(((measured - model) * weight)**2))


def test_zones_of_the_deck_are_kept(tmp_path):
    track = ballast.Track(program_of(tmp_path),
                          deck_of(tmp_path, "zone = [{from = 5, to = 7, rail = 3}]"), 6.1, SPEED)
    assert track.stiffness == 6e7
    assert track.sensor == pytest.approx(6.0)
    zones = track.zones_of({"outside": 2e7, "inside": 1e7, "length": 0.6, "void": 1e-3})
    assert zones[0] == {"from": 5, "to": 7, "rail": 3}
    at = next(zone for zone in zones[1:] if zone.get("gap"))
    assert (at["from"], at["to"]) == pytest.approx((5.7, 6.3))
    assert at["bed"] == pytest.approx(0.5) and at["gap"] == 1e-3
    beside = next(zone for zone in zones[1:] if zone["from"] == pytest.approx(6.3))
    assert beside["bed"] == pytest.approx(0.5**np.exp(-0.5))
    alike = track.zones_of({"outside": 2e7, "inside": 2e7, "length": 0.6, "void": 0.0})
    assert alike == zones[:1]


def test_command_without_a_program(tmp_path):
    deck, signal = tmp_path / "deck.toml", tmp_path / "sensor.csv"
    deck.write_text('model = "track"\n', encoding="utf-8")
    signal.write_text("time_s,a_m_s2\n0,1\n0.001,2\n", encoding="utf-8")
    ran = conftest.call("ballast", signal, deck, "--sensor", "6", "--speed", "50", "--program",
                        tmp_path / "none", "-o", tmp_path / "out")
    assert ran.returncode == 2 and "is not a program" in ran.stderr
