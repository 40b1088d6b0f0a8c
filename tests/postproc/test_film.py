"""Films state the time of their files, their pace, and what the width of a contact force is."""
import json
import pathlib
import types

import matplotlib.patches
import matplotlib.pyplot as plt
import numpy as np
import pytest
from test_fields import LINE, call, field_run, write_grid, write_surfaces  # noqa: F401

from trackbed_post import field_files, film_files, instants, read, transition, transition_figures
from trackbed_post import write

X = 0.6 * np.arange(1, 31)
TIMES = 2.5 + 0.03 * np.arange(20)  # s, of the files; those of the histories begin before
LARGEST = 33e3                      # N, contact force of the last file
SPEED = 40.0                        # m/s


def written(folder):
    """Field files of contacts, of which the last ones have the largest force."""
    (folder / "fields").mkdir()
    files = []
    for k, time in enumerate(TIMES):
        name = f"train_{k:06d}_contacts.hdf"
        write_grid(folder / "fields" / name, [[9, 0, 0.1], [9, 0, 0.2]], [[0, 1]], LINE,
                   cell_data={"force_size": ([LARGEST * (k + 1) / len(TIMES)], "N")})
        files.append({"name": name, "time": time})
    (folder / "fields/contacts.hdf.series").write_text(json.dumps({"files": files}))
    return folder


def train_at(speed=SPEED):
    """Two axles that enter the bed at 2.5 s."""
    time = 2 + 0.01 * np.arange(111)
    front = speed * (time - 2.5)
    rail = np.zeros((len(time), len(X)))
    rail[60:] = -1e-3
    deck = {"bed": {"x": [0, 18.6]}, "thickness": 1.3, "train": {"speed": speed},
            "sleepers": {"spacing": 0.6, "width": 0.25, "height": 0.2}}
    run = types.SimpleNamespace(name="made", deck=deck, sleepers_x=X, stones={}, sleeper={},
                                wheel={}, rail={"displacement": types.SimpleNamespace(values=rail)},
                                has_passage=lambda: True, passage=lambda: slice(None))
    passing = types.SimpleNamespace(time=time, x=np.stack([front, front - 2.5], axis=1), rail=rail,
                                    first=0)
    return transition.Train(run, passing, "made")


def test_clock_of_a_film_is_that_of_its_files(tmp_path):
    pictures = transition_figures.film([train_at()], written(tmp_path), "made")
    stated = []
    for picture in pictures:
        panel = plt.gcf().axes[0]
        stated.append(next(text.get_text() for text in panel.texts if "time" in text.get_text()))
        assert picture.ndim == 3
    seen = [time for time in TIMES if SPEED * (time - 2.5) - 2.5 < X[-1] + 3]
    assert len(stated) == len(seen) and len(seen) > 10
    for words, time in zip(stated, seen):
        assert f"time {time:.3f} s" in words and "4 times slower than in reality" in words, words
        assert "after the train began" not in words


def test_the_lowest_level_of_a_film_counts_from_the_row_of_level_zero(tmp_path):
    """Before it, rail and sleepers move to their equilibrium."""
    train = train_at()
    train.passing.first = 56
    train.passing.rail = train.passing.rail.copy()
    train.passing.rail[:55] = -5e-3
    pictures = transition_figures.film([train], written(tmp_path), "made")
    lowest = []
    for _ in pictures:
        level = plt.gcf().axes[1]
        line, = (one for one in level.lines if one.get_label().startswith("lowest up to then"))
        lowest.append(np.asarray(line.get_ydata())[0])
    assert np.isnan(lowest[0]) and np.isnan(lowest[1]) and lowest[2] == 0
    assert lowest[-1] == pytest.approx(-1)


def test_no_vehicle_hides_the_direction_of_travel(tmp_path):
    pictures = transition_figures.film([train_at()], written(tmp_path), "made")
    for _ in pictures:
        figure = plt.gcf()
        panel = figure.axes[0]
        clock = next(text for text in panel.texts if "direction" in text.get_text())
        place = clock.get_window_extent(figure.canvas.get_renderer())
        assert place.y0 > panel.get_window_extent().y1
        assert not place.overlaps(panel.title.get_window_extent())


def test_width_of_a_contact_force_is_explained(tmp_path):
    pictures = transition_figures.film([train_at()], written(tmp_path), "made")
    next(pictures)
    figure = plt.gcf()
    key, = figure.legends
    lines = key.get_lines()
    scale = transition_figures.model_drawing.CHAIN_WIDTH / LARGEST
    assert "this line: 33 kN in a model 1.3 m thick" in key.get_texts()[0].get_text()
    drawn, = [one for one in figure.axes[0].collections if one.get_zorder() == 2.5]
    assert drawn.get_linewidths()[0] == pytest.approx(scale * LARGEST / len(TIMES))
    assert lines[0].get_linewidth() == pytest.approx(scale * LARGEST)
    figure.canvas.draw()
    place = key.get_window_extent()
    for panel in figure.axes:  # between both panels, and not over the labels of their axes
        assert not place.overlaps(panel.get_tightbbox()), "the key hides a panel"
    pictures.close()


def test_settled_sleepers_are_drawn_packed_up_below_an_even_rail():
    train = train_at()
    settled = np.where(np.arange(len(X)) % 4 == 2, -0.02, -0.005)
    train.run.sleeper["displacement"] = types.SimpleNamespace(
        values=np.stack([np.zeros(len(X)), settled]))
    train.run.deck["seat"], train.run.deck["track"] = {"before": 4}, {"length": 30}
    figure, panel = plt.subplots()
    scene = transition_figures.model_drawing.Scene(panel, train.run, 2.6)
    scene.set_train([5.0])
    boxes = [(patch.get_x(), patch.get_y(), patch.get_width(), patch.get_height())
             for patch in panel.patches if isinstance(patch, matplotlib.patches.Rectangle)]
    tops = {round(x + width / 2, 6): y + height for x, y, width, height in boxes
            if width == 0.25 and height == 0.2}
    foot = 0.3 + 0.2 - 0.005  # m, of the rail on the sleepers that have settled least
    for x, down in zip(X, settled):
        assert tops[round(x, 6)] == pytest.approx(0.5 + down)
        packing, = [box for box in boxes if box[2] == 0.125 and
                    box[0] + 0.0625 == pytest.approx(x)]
        assert packing[1:] == pytest.approx((0.5 + down, 0.125, foot - 0.5 - down))
    beside = [top for x, top in tops.items() if not X[0] - 0.1 < x < X[-1] + 0.1]
    assert len(beside) > 3 and beside == pytest.approx([foot] * len(beside))
    rail, = [box for box in boxes if box[3] == transition_figures.model_drawing.RAIL_HEIGHT]
    assert rail[1] == pytest.approx(foot)
    wheel, = [patch for patch in panel.patches if isinstance(patch, matplotlib.patches.Circle)]
    assert wheel.center[1] - wheel.radius == pytest.approx(rail[1] + rail[3])
    plt.close(figure)


@pytest.mark.parametrize("times, words", [
    ([1.0], ""),
    (3 + 0.03 * np.arange(9), "4 times slower than in reality"),
    (3 + 0.12 * np.arange(9), "as fast as in reality"),
    (3 + 0.6 * np.arange(9), "5 times faster than in reality"),
    ([*(0.002 * np.arange(30)), 0.059], "60 times slower than in reality"),  # the end of a stage
    ([0.1, 0.2, 0.5], "a picture every 120 ms, at uneven times")])
def test_pace_of_a_film(times, words):
    assert film_files.pace(times) == words


@pytest.mark.parametrize("count, words", [
    (740, "0.7 kB"), (9_940, "9.9 kB"), (38_200, "38 kB"), (999_000, "999 kB"),
    (1_000_000, "1.0 MB"), (2_640_000, "2.6 MB")])
def test_sizes_of_small_files_are_in_kilobytes(count, words):
    assert write.size(count) == words


def test_size_of_a_small_film_is_not_nothing(run, tmp_path):  # noqa: F811
    done = call("film", run, "-o", tmp_path / "film.gif", "--parts", "stones,ground")
    size = (tmp_path / "film.gif").stat().st_size
    assert f"film.gif: {write.size(size)}" in done.stdout and "kB" in done.stdout, done


def test_picture_of_one_file_states_its_time(run, tmp_path):  # noqa: F811
    done = call("still", run / "fields/load_000002_stones.hdf", "-o", tmp_path / "alone.png")
    assert "alone.png: load, 0.2 s, stones: 3 cells" in done.stdout, done
    moved = tmp_path / "load_000002_surfaces.hdf"
    write_surfaces(moved)
    assert instants.label_of(moved) == "", "no list of its series is beside it"


def test_time_that_a_file_states_itself(tmp_path):
    path = tmp_path / "load_000002_surfaces.hdf"
    write_surfaces(path)
    with field_files.read.h5py.File(path, "r+") as file:
        file["VTKHDF/FieldData/TimeValue"] = np.array([1.25])
    assert instants.label_of(path) == "load, 1.25 s" and read.time_in(path) == 1.25
    assert field_files.files_of(path, ("surfaces",)) == {"surfaces": [(1.25, path)]}
    assert set(field_files.arrays_of(path)) == {"", "part"}, "the time is no array of cells"
    assert np.isnan(field_files.files_of(pathlib.Path("gone.hdf"), ("gone",))["gone"][0][0])
