"""The train above histories, and histories of all stages."""
import dataclasses

import conftest
import h5py
import made
import matplotlib.pyplot as plt
import numpy as np
import pytest
from trackbed_post import (axles, bed_histories, measures, read, sleeper_histories,
                           stage_histories, track_figures, train_strip)

TIME = np.arange(0, 1, 1e-3)


def train(count=4, vehicles=("wagon", "wagon"), speed=20.0):
    """Axles 2 m apart from x = -1 m on at `speed`, nan before the track begins at x = 0."""
    x = speed * TIME[:, None] - 1 - 2.0 * np.arange(count)
    return train_strip.Train(TIME, np.where(x < 0, np.nan, x), vehicles)


def test_axles_pass_a_place_at_their_times():
    times = train_strip.times_at(train(), 3.0)
    assert times.shape == (1, 4) and times[0] == pytest.approx([0.2, 0.3, 0.4, 0.5], abs=1e-6)
    assert train_strip.times_at(train(), 19.5).shape == (0, 4)
    some = train_strip.times_at(train(), 15.5)[0]  # the last axle is still before it
    assert np.isfinite(some).tolist() == [True, True, False, False]


def test_a_second_train_has_a_row_of_times_of_its_own():
    one = train(2)
    twice = train_strip.Train(np.concatenate([TIME, TIME + 1]), np.concatenate([one.x, one.x]))
    assert train_strip.times_at(twice, 3.0) == pytest.approx(np.array([[0.2, 0.3], [1.2, 1.3]]))


def test_wheels_of_two_rails_are_one_axle():
    x = np.array([[1.0, 1.0, -1.0, -1.0], [2.0, 2.0, np.nan, np.nan]])
    assert axles.of_wheels(x).shape == (2, 2)
    assert axles.of_wheels(x[:, [0, 2]]).shape == (2, 2)


def test_bodies_are_above_the_wheels_of_each_vehicle():
    figure, panel = plt.subplots()
    train_strip.draw(panel, train(), [train_strip.Place(3.0, "x = 3 m", "C0")])
    bodies = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in panel.patches]
    beyond = train_strip.OVERHANG / 20  # s, at 20 m/s
    assert np.allclose(bodies, [(0.2 - beyond, 0.3 + beyond), (0.4 - beyond, 0.5 + beyond)],
                       atol=1e-6)
    assert [text.get_text() for text in panel.texts] == ["wagon", "wagon", "x = 3 m"]
    plt.close(figure)


@pytest.mark.parametrize("behind, vehicles, drawn", [
    ([0, 2, 4, 7, 9, 11, 12, 14], ("engine", "wagon"), []),  # six axles and two
    ([0, 2, 7, 8], ("engine", "wagon"), []),
    ([0, 2, 7, 9], ("engine", "wagon"), ["engine", "wagon"]),
    ([0, 2, 7, 8], ("engine",), ["engine"])])
def test_bodies_are_drawn_only_if_the_axles_of_each_vehicle_are_known(behind, vehicles, drawn):
    figure, panel = plt.subplots()
    x = 20.0 * TIME[:, None] - 1 - np.array(behind)
    train_strip.draw(panel, train_strip.Train(TIME, x, vehicles),
                     [train_strip.Place(3.0, "x = 3 m", "C0")])
    assert [text.get_text() for text in panel.texts[:-1]] == drawn
    plt.close(figure)


def with_train(folder):
    """The bed of made.py with two axles that pass at 20 m/s in its last stage."""
    made.write(folder)
    with h5py.File(folder / "results.h5", "r+") as file:
        time = file["history/time"][()]
        x = 20 * (time[:, None] - 0.2) - np.array([0.0, 2.0])
        file["history/wheel/x"] = np.where((x >= 0) & (time[:, None] >= 0.1), x, np.nan)
        file["history/wheel/force"] = 5e4 * np.ones_like(x)
        for name, unit in (("x", "m"), ("force", "N")):
            item = file[f"history/wheel/{name}"]
            item.attrs["units"], item.attrs["long_name"] = unit, "made for a test"
    return read.results(folder)


def test_the_train_is_above_the_histories_of_sleepers(tmp_path):
    run = with_train(tmp_path / "one")
    figure = sleeper_histories.draw([run])
    strip, first = figure.axes[:2]
    assert len(figure.axes) == 5 and strip.get_ylabel() == "train as\nit passes,\nfront first"
    at = run.sleepers_x[measures.chosen_sleepers(run)[0]]
    # 0.1 s after the passage began the first axle is at x = 0.
    marks = [line.get_xdata()[0] for line in first.lines if line.get_linestyle() == ":"]
    assert marks[:2] == pytest.approx([0.1 + at / 20, 0.2 + at / 20], abs=2e-3)
    assert len(marks) == 6  # two axles past each of three sleepers
    plt.close(figure)


def test_a_bed_without_train_has_its_four_panels(runs):
    figure = sleeper_histories.draw(runs)
    assert len(figure.axes) == 4
    plt.close(figure)


def test_the_train_is_above_the_histories_of_a_track():
    x = train(2).x
    run = {"history/wheel/x": x, "history/wheel/force": 5e4 * np.ones_like(x),
           "history/time": TIME, "sleepers/x": np.array([3.0, 3.6]),
           "rail/x": np.array([3.0]), "history/rail/displacement": np.ones((len(TIME), 1)),
           **{f"history/sleeper/{name}": np.ones((len(TIME), 2)) for name in
              ("displacement", "seat_force", "acceleration")}}
    run = {name: read.Quantity(values, "", "") for name, values in run.items()}
    figure = track_figures.draw(run, 20, {"train": {"vehicles": ["wagon"]}})
    wheels, strip, *histories = figure.axes
    assert wheels.get_xlabel() == "x of the wheel from the start of the track, m"
    assert len(strip.texts) == 4
    for panel in histories:
        assert panel.get_xlim() == strip.get_xlim() == (TIME[0], TIME[-1])
        assert sum(line.get_linestyle() == ":" for line in panel.lines) == 4
    plt.close(figure)


def test_stages_are_beside_each_other(runs, tmp_path):
    figure = stage_histories.stages(runs)
    panels = np.reshape(figure.axes, (3, 2))
    assert [panel.get_title() for panel in panels[0]] == ["stage load", "stage passage"]
    run = runs[0]
    rows = run.stage == 4
    line, shown = panels[0, 1].lines[0], measures.chosen_sleepers(run)[0]
    assert line.get_xdata()[0] == 0 and line.get_xdata()[-1] == pytest.approx(1.999)
    assert np.allclose(line.get_ydata(), 1e3 * run.sleeper["displacement"].values[rows, shown])
    assert np.allclose(panels[1, 1].lines[0].get_ydata(),
                       -run.sleeper["seat_force"].values[rows, shown] / 1e3)
    assert len(panels[0, 0].lines) == 6  # three sleepers of two runs
    plt.close(figure)
    ran = conftest.call("figures", made.write(tmp_path / "one"), "-o", tmp_path / "out")
    assert ran.returncode == 0 and (tmp_path / "out/stages.png").is_file()


def test_the_platen_is_shown_where_it_applies_a_load(runs):
    """Stage 1 compacts, stage 2 places the sleepers; nothing is drawn for stage 0."""
    run = runs[0]
    number = np.repeat([0, 1, 2], [500, 600, 1000])
    pressure = np.where(number == 1, 2e5, 0.0)
    run = dataclasses.replace(run, stage=number,
                              platen={"pressure": read.Quantity(pressure, "Pa", "")})
    figure = stage_histories.stages([run])
    panels = np.reshape(figure.axes, (4, 2))
    assert panels[0, 0].get_title() == "stage compact" and panels[0, 0].axison
    assert np.allclose(panels[0, 0].lines[0].get_ydata(), 200)
    assert panels[1, 1].get_title() == "stage sleepers"
    assert not panels[0, 1].axison and not panels[1, 0].axison
    assert panels[1, 1].get_ylabel().startswith("displacement")
    plt.close(figure)


def test_the_train_is_above_the_sensors(tmp_path):
    run = with_train(tmp_path / "one")
    deck = run.deck | {"sensor": [{"name": "stone", "at": [2.0, 0.0, 0.1]}]}
    figure = bed_histories.sensors([dataclasses.replace(run, deck=deck)])
    strip, first = figure.axes[:2]
    assert [text.get_text() for text in strip.texts] == ["stone, x = 2 m"]
    assert len(figure.axes) == 4 and len(first.lines) == 3  # a history and two axles
    plt.close(figure)
