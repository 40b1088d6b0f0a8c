"""What postproc/paraview/view.py shows: numbers that need no ParaView. tests/program/paraview.py
draws with it, where it is installed."""
import importlib.util
import sys
import types

import conftest
import numpy as np
import pytest
from trackbed_post import framing

BED = np.array([[0.0, -0.65, 0.0], [19.2, 0.65, 1.6]])  # the quickstart with its wheels, m


@pytest.fixture(name="view", scope="module")
def view_without_paraview():
    absent = types.ModuleType("paraview")
    absent.simple = absent.servermanager = None
    path = conftest.ROOT / "postproc/paraview/view.py"
    spec = importlib.util.spec_from_file_location("view_of_fields", path)
    module = importlib.util.module_from_spec(spec)
    before = sys.modules.get("paraview")
    sys.modules["paraview"] = absent
    try:
        spec.loader.exec_module(module)
    finally:
        sys.modules.pop("paraview") if before is None else sys.modules.update(paraview=before)
    return module


def pixels_of(view, box, eye):
    """Of a picture: its size, and the pixels of the corners of a box from its lower left corner."""
    focus, position, half, size = view.camera(box, eye)
    assert np.allclose(np.cross(position - focus, eye), 0), "it looks along another direction"
    right, up, _ = framing.axes_of(eye)
    corners = np.array([[box[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    metres = 2 * half / size[1]
    return size, np.column_stack([(corners - focus) @ axis / metres + pixels / 2
                                  for axis, pixels in zip((right, up), size)])


@pytest.mark.parametrize("wheel, low", [(None, 7.5), (9.6, 7.5), (0.3, 0.0), (18.9, 15.0)])
def test_a_long_bed_is_shown_around_the_wheel(view, wheel, low):
    seen = view.window(BED, wheel, view.SIDE)
    assert seen[:, 0] == pytest.approx([low, low + 4.2])
    assert np.array_equal(seen[:, 1:], BED[:, 1:])


def test_a_short_bed_is_shown_as_a_whole(view):
    short = BED.copy()
    short[1][0] = 3.6
    assert np.array_equal(view.window(short, 0.5, view.SIDE), short)


@pytest.mark.parametrize("eye", ["SIDE", "CORNER"])
@pytest.mark.parametrize("length", [4.2, 19.2, 0.8])
def test_the_bed_fills_the_picture(view, eye, length):
    """It touches the margins for labels and colour bars in one direction and none is exceeded."""
    box = BED.copy()
    box[1][0] = length
    (wide, tall), corners = pixels_of(view, box, getattr(view, eye))
    frame = framing.PARAVIEW
    left, below = corners.min(axis=0) - [frame.left, frame.below]
    right, above = [wide - frame.right, tall - frame.above] - corners.max(axis=0)
    assert min(left, below, right, above) > -1
    assert max(left, right) < 1 or max(below, above) < 1
    assert wide == frame.widest and frame.lowest <= tall <= frame.highest
    if length == 4.2 and eye == "SIDE":
        used = np.ptp(corners, axis=0).prod() / (wide * tall)
        assert used > 0.5, "a narrow strip"


def test_the_ground_is_shown_as_deep_as_what_is_above_it(view):
    deep = np.array([[0.0, -0.65, -20.0], [19.2, 0.65, 0.0]])
    assert view.depth_limited(BED, deep)[0][2] == -1.6
    tall = BED.copy()
    tall[1][2] = 5.0
    assert view.depth_limited(tall, deep)[0][2] == -5.0
    shallow = deep.copy()
    shallow[0][2] = -0.4
    assert view.depth_limited(BED, shallow)[0][2] == -0.4


def test_the_wheel_nearest_to_the_middle_of_the_bed():
    assert framing.nearest_to_middle([-5.0, 2.0, 9.0, 30.0], 0, 20) == (1.0, 9.0)
    assert framing.nearest_to_middle([-5.0, 30.0], 0, 20) is None


def test_instant_is_that_with_a_wheel_over_the_middle_of_the_bed(view, monkeypatch):
    places = {2.0: [-4.0], 2.5: [8.0, 5.5], 3.0: [19.0], 3.5: [40.0]}
    monkeypatch.setattr(view, "wheels_at", lambda _, time: places[time])
    sources = {"train": types.SimpleNamespace(TimestepValues=list(places)),
               "stones": types.SimpleNamespace(TimestepValues=[1.0, *places])}
    train = sources["train"]
    assert view.instant(sources, train, None, (0, 19.2)) == ([1.0, *places], 2.5, 8.0)
    assert view.instant(sources, train, 3.1, (0, 19.2))[1:] == (3.0, 19.0)
    assert view.instant(sources, train, 3.4, (0, 19.2))[1:] == (3.5, None)
    assert view.instant(sources, train, 0.5, (0, 19.2))[1:] == (1.0, None)
    del sources["train"]  # not drawn: the instant is the same
    assert view.instant(sources, train, None, (0, 19.2))[1:] == (2.5, 8.0)
    assert view.instant(sources, None, None, (0, 19.2))[1:] == (3.5, None)
    for beyond in (-0.1, 4.6):
        with pytest.raises(SystemExit, match="no fields near .*, but from 1 to 3.5 s"):
            view.instant(sources, train, beyond, (0, 19.2))


def test_options(view):
    given = view.options(["run", "view.pvsm", "view.png", "3.44", "--x", "-1", "4"])
    assert (given.picture, given.time, given.x, given.whole) == ("view.png", 3.44, [-1, 4], False)
    assert view.options(["run", "view.pvsm", "--whole"]).whole


def test_speeds_are_those_of_stones_not_of_their_cells(view):
    """A hundred stones with one cell and one, the fastest but one, with as many as all others."""
    stone = np.append(np.arange(101), np.full(100, 99))
    velocity = np.zeros((201, 3))
    velocity[:, 2] = -0.01 * np.where(stone == 100, 900, stone)
    assert view.highest_speed(velocity, stone) == pytest.approx(0.99)
    still = np.where(stone[:, None] == 100, velocity, 0)
    assert view.highest_speed(still, stone) == 0 == view.highest_speed(velocity[:0], stone[:0])


@pytest.mark.parametrize("moving, title", [
    (3, "speed (m/s), fastest 1 % beyond the bar"), (0, "speed (m/s)")])
def test_the_bar_says_which_stones_are_beyond_it(view, monkeypatch, moving, title):
    velocity = np.zeros((5, 3))
    velocity[:moving, 0] = 1.0
    arrays, ends = {"velocity": velocity, "stone": np.arange(5)}, []
    data = types.SimpleNamespace(GetCellData=lambda: types.SimpleNamespace(GetArray=arrays.get))
    util = types.ModuleType("vtkmodules.util.numpy_support")
    util.vtk_to_numpy = np.asarray
    for name in ("vtkmodules", "vtkmodules.util"):
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    monkeypatch.setitem(sys.modules, util.__name__, util)
    monkeypatch.setattr(view, "servermanager", types.SimpleNamespace(Fetch=lambda _: data))
    monkeypatch.setattr(view, "simple", types.SimpleNamespace(
        GetColorTransferFunction=lambda _: types.SimpleNamespace(
            RescaleTransferFunction=lambda *limits: ends.append(limits))))
    bar = types.SimpleNamespace(Title=view.COLOURED_BY["stones"][2])
    view.limit_speeds(None, bar)
    assert bar.Title == title and len(ends) == bool(moving)
