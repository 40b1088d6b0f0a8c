"""What pictures of field files state, and how much of them the model fills."""
import json
import types

import h5py
import numpy as np
import pytest
from model_files import write_grid, write_stones

from trackbed_post import framing, grids, instants, scene, still, write

LONG_BED = np.array([[0.0, -0.65, 0.0], [19.2, 0.65, 0.5]])


@pytest.mark.parametrize("box, wide, high", [
    (LONG_BED, 1600, 300),                                        # as low as its texts allow
    (np.array([[0, 0, 0], [3.0, 1, 2.0]]), (800, 1600), 800),     # as high as a screen
    (np.array([[0, 0, 0], [0.3, 0.3, 0.6]]), 800, 800)])
def test_a_picture_has_the_shape_of_the_model(box, wide, high):
    _, _, half, size = framing.camera(box, *scene.VIEWS["side"], scene.FRAME)
    metres = 2 * half / size[1]
    assert size[1] == high and (size[0] == wide or wide[0] < size[0] < wide[1])
    across, along = (np.ptp(box[:, axis]) / metres for axis in (0, 2))
    frame = scene.FRAME
    assert across == pytest.approx(size[0] - frame.left - frame.right, abs=2) or \
        along == pytest.approx(size[1] - frame.above - frame.below, abs=2)


@pytest.mark.parametrize("view", scene.VIEWS)
def test_no_view_cuts_the_model(view):
    focus, _, half, size = framing.camera(LONG_BED, *scene.VIEWS[view], scene.FRAME)
    right, up, _ = framing.axes_of(*scene.VIEWS[view])
    corners = np.array([[LONG_BED[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    scale = size[1] / (2 * half)
    x = (corners - focus) @ right * scale + size[0] / 2
    y = (corners - focus) @ up * scale + size[1] / 2
    frame = scene.FRAME
    assert frame.left - 1 <= x.min() and x.max() <= size[0] - frame.right + 1
    assert frame.below - 1 <= y.min() and y.max() <= size[1] - frame.above + 1


def survey_of(tmp_path, speeds):
    count = len(speeds)
    velocity = np.zeros((count, 3))
    velocity[:, 2] = speeds
    write_grid(tmp_path / "stones.hdf", np.arange(3.0 * count).reshape(-1, 3),
               [[k] for k in range(count)], 2, {"radius": (np.full(count, 0.1), "m")},
               {"velocity": (velocity, "m/s"), "stone": (np.arange(count), "1")})
    survey = grids.Survey("stones")
    survey.add({"stones": tmp_path / "stones.hdf"})
    return survey


def test_colours_leave_out_the_fastest_stones_and_say_so(tmp_path):
    speeds = np.append(np.linspace(0.1, 1.0, 300), [50.0])
    survey = survey_of(tmp_path, speeds)
    found = survey.colouring()
    assert found.limits == pytest.approx((0, np.percentile(speeds, 99)))
    assert found.beyond == "the fastest 1 % of the stones are beyond the colours, up to 50 m/s"
    for given in (survey.colouring("velocity", (0.0, 2.0)), survey.colouring("stone"),
                  survey_of(tmp_path, np.zeros(300) + speeds[:300]).colouring("radius")):
        assert not given.beyond
    assert survey_of(tmp_path, np.append(np.zeros(300), [50.0])).colouring().limits == (0, 50)


def drawn_texts(monkeypatch, sources, tmp_path):
    """Label and origin of the picture that `still` draws."""
    texts = []

    class Scene:
        def __init__(self, *given):
            texts.append(given[-1])

        show = staticmethod(lambda _: None)
        colours = staticmethod(lambda: 9)

        @staticmethod
        def picture(label):
            texts.append(label)
            return np.zeros((2, 2, 3), np.uint8)

    monkeypatch.setattr(scene, "Scene", Scene)
    monkeypatch.setattr(scene, "with_screen", lambda: None)
    still.render([str(one) for one in sources], str(tmp_path / "p.png"), types.SimpleNamespace(
        array=None, view=None, parts=None, time=None, limits=None, x=None))
    origin, label = texts
    return label, origin


def test_pictures_state_the_deck_the_program_and_the_run(monkeypatch, tmp_path):
    fields = tmp_path / "my_run/fields"
    fields.mkdir(parents=True)
    write_stones(fields / "rest_000001_stones.hdf", (1, 2, 3))
    (fields / "stones.hdf.series").write_text(json.dumps(
        {"files": [{"name": "rest_000001_stones.hdf", "time": 0.25}]}))
    for source in (tmp_path / "my_run", fields / "rest_000001_stones.hdf"):
        label, origin = drawn_texts(monkeypatch, [source], tmp_path)
        assert label == "rest, 0.25 s" and origin.startswith(f"{source.name}, drawn on 20")
    with h5py.File(tmp_path / "my_run/results.h5", "w") as file:
        file.attrs["deck"], file.attrs["version"] = 'title = "A short bed"', "1.2"
        file.attrs["build"] = "commit abc; compiler"
    for source in (tmp_path / "my_run", fields / "rest_000001_stones.hdf"):
        _, origin = drawn_texts(monkeypatch, [source], tmp_path)
        assert origin == write.origin_of([tmp_path / "my_run"])
        assert origin.startswith("A short bed\ntrackbed 1.2, commit abc: my_run, drawn on 20")


def test_a_file_whose_name_has_no_stage_has_its_time_as_label(tmp_path):
    path = tmp_path / "stones.hdf"
    write_stones(path, (1, 2, 3))
    with h5py.File(path, "a") as file:
        file["VTKHDF/FieldData/TimeValue"] = [3.57441]
    assert instants.label_of(path) == "3.57441 s"
    assert instants.Instant(2.0, "load_000001", {}).label() == "load, 2 s"
