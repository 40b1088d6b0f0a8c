"""Tests of laboratory.py on heaps and curves with known results."""
import types

import numpy as np
import pytest
from trackbed_post import laboratory, read


def quantity(values):
    return read.Quantity(np.asarray(values, dtype=float), "-", "made for a test")


def test_dilation_angle_of_plane_and_axial_strains():
    """With s = sin psi a bed expands laterally by (1 + s)/(1 - s) of its axial strain."""
    axial = np.linspace(0, 0.05, 11)
    s = np.sin(np.radians(18.0))
    volumetric = axial * (1 - (1 + s) / (1 - s))
    assert laboratory.dilation_angle(axial, volumetric) == pytest.approx(18.0)


def test_area_of_box_and_cylinder():
    deck = {"dimension": "space", "bed": {"x": [0, 0.4], "y": [0, 0.4]}}
    assert laboratory.area(types.SimpleNamespace(deck=deck)) == pytest.approx(0.16)
    deck["bed"]["container"] = "cylinder"
    circle = np.pi * 0.2**2
    assert laboratory.area(types.SimpleNamespace(deck=deck)) == pytest.approx(circle, rel=0.002)


def test_shear_includes_both_halves_and_the_weight_below():
    way = np.linspace(0, 0.01, 21)
    ones = np.ones((21, 1))
    force = {"floor": ones * [-600, 0, -1100], "wall.left.lower": ones * [-200, 0, 0],
             "wall.right.upper": ones * [700, 0, 100]}
    stages = [{"kind": "compact"}, {"kind": "shear"}]
    run = types.SimpleNamespace(
        deck={"dimension": "space", "stage": stages,
              "bed": {"x": [0, 0.3], "y": [0, 0.3], "split": 0.1}},
        stage=np.ones(21, dtype=int),
        walls={name: {"force": quantity(f), "displacement": quantity(np.c_[way, way, way])}
               for name, f in force.items()},
        platen={"force": quantity(ones * [100, 0, 900]), "z": quantity(0.2 + way / 2)},
        stones={"shear": types.SimpleNamespace(sieved=np.array([[0.03, 20.0]]))})
    got = laboratory.shear(run)
    assert got["tau"] * 0.09 == pytest.approx(800)      # upper walls and platen
    assert got["sigma"] * 0.09 == pytest.approx(900)
    assert got["plane"][0] * 0.09 == pytest.approx(1100 - 20 * 9.81 / 2, rel=0.01)
    assert got["rise"][-1] == pytest.approx(0.005)


def test_modulus_between_stages():
    stages = [{"name": "fill", "kind": "fill"}] + [{"name": n, "kind": "compact"} for n in "abc"]
    run = types.SimpleNamespace(
        deck={"stage": stages}, stage=np.array([0, 1, 1, 2, 3]),
        platen={"z": quantity([0, 0.3, 0.2, 0.198, 0.197]),
                "pressure": quantity([0, 0, 25e3, 525e3, 425e3])})
    steps = laboratory.compression(run)
    assert [step[1] for step in steps] == pytest.approx([0, 0.01, 0.015])
    assert dict(laboratory.moduli(steps)) == {"b": pytest.approx(50e6), "c": pytest.approx(-20e6)}


def test_void_ratio_of_a_layer_that_is_crushed():
    """A layer of 10 kg (0.004 m3) on 0.1 m2 whose void ratio falls as the root of the pressure,
    and of which 1 kg becomes fines half-way."""
    pressure = np.geomspace(1e6, 4e6, 21)
    void = 0.8 * (pressure / 1e6)**-0.5
    rows = np.zeros((2, len(read.BREAK)))
    rows[:, read.BREAK["time"]] = [10.5, 12]
    rows[:, read.BREAK["fragment"]] = [-1, 7]
    rows[:, read.BREAK["mass"]] = [1, 3]
    run = types.SimpleNamespace(
        deck={"dimension": "space", "bed": {"x": [0, 0.5], "y": [0, 0.2], "material": "rock"},
              "stage": [{"name": "seat", "kind": "compact"}, {"name": "crush", "kind": "compact"}],
              "material": [{"name": "steel", "density": 1}, {"name": "rock", "density": 2500}]},
        stage=np.ones(21, dtype=int), time=np.arange(21.0),
        platen={"z": quantity(0.04 * (1 + void)), "pressure": quantity(pressure)},
        stones={"seat": types.SimpleNamespace(sieved=np.array([[0.03, 4.0], [0.04, 6.0]]))},
        breaks={"seat": rows[:0], "crush": rows})
    got = laboratory.crushing(run)
    assert got["all"] == pytest.approx(void)
    assert got["fines"] == pytest.approx([0] * 11 + [0.1] * 10)
    assert got["left"][-1] == pytest.approx((1 + void[-1]) / 0.9 - 1)
    assert laboratory.slope_of_compression(got, "all", 1.5e6) == pytest.approx(-0.5)


def test_triaxial_uses_the_current_sides():
    down = np.linspace(0, 0.06, 31)
    height, in_x, in_y = 0.6 - down, -down / 10, -down / 20
    ones = np.ones(31)
    forces = {"wall.left": (-2e3, 0), "wall.right": (2.2e3, 0), "wall.front": (0, -1e3),
              "wall.back": (0, 1.2e3), "floor": (0, 0)}
    ways = {"wall.left": (1, 0), "wall.right": (-1, 0), "wall.front": (0, 1), "wall.back": (0, -1),
            "floor": (0, 0)}
    run = types.SimpleNamespace(
        deck={"dimension": "space", "stage": [{"kind": "compact"}, {"kind": "triaxial"}],
              "bed": {"x": [0, 0.3], "y": [0, 0.4]}},
        stage=np.ones(31, dtype=int),
        walls={name: {"force": quantity(np.c_[forces[name][0] * ones, forces[name][1] * ones,
                                              0 * ones]),
                      "displacement": quantity(np.c_[ways[name][0] * in_x, ways[name][1] * in_y,
                                                     0 * ones])} for name in forces},
        platen={"force": quantity(np.c_[0 * ones, 0 * ones, 9e3 * ones]), "z": quantity(height)})
    # Half of the excess force on the floor, weight less friction of the walls, is above the middle.
    run.walls["floor"]["force"].values[:, 2] = -10e3
    got = laboratory.triaxial(run)
    long, wide = 0.3 + 0.2 * down, 0.4 + 0.1 * down
    assert got["axial"][-1] == pytest.approx(0.1)
    assert got["volumetric"] == pytest.approx(1 - long * wide * height / (0.3 * 0.4 * 0.6))
    assert got["sigma_1"][-1] == pytest.approx(9.5e3 / (long * wide)[-1], rel=1e-3)
    lateral = (2.1e3 / wide + 1.1e3 / long) / height / 2
    assert got["sigma_3"][-1] == pytest.approx(lateral[-1], rel=1e-3)
