"""Tests of panels.py and of what it is used for: legends that hide no curve, names of axles, one
sign of displacements on axes."""
import csv

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest
import test_train
import test_transition
from trackbed_post import (axles, bed_histories, bed_on_ground, curves, figure_csv,
                           model_drawing, panels, stage_histories, stress_paths, support_figure,
                           train_figures, train_strip, transition, transition_figures)


@pytest.mark.parametrize("wheels, two_rails, names", [
    ([[3.0, 1.0], [4.0, 2.0]], False, ["axle 1", "axle 2"]),
    ([[3.0, 3.0, 1.0, 1.0], [np.nan, np.nan, 2.0, 2.0]], True,
     ["axle 1, left", "axle 1, right", "axle 2, left", "axle 2, right"])])
def test_axles_are_counted_from_one(tmp_path, wheels, two_rails, names):
    wheels = np.array(wheels)
    assert axles.on_two_rails(wheels) == two_rails
    (tmp_path / "run").mkdir()
    with h5py.File(tmp_path / "run/results.h5", "w") as file:
        for name, values, unit in (("time", np.arange(2.0), "s"), ("wheel/x", wheels, "m"),
                                   ("wheel/force", wheels, "N"),
                                   ("wheel/wheel", np.arange(wheels.shape[1]), "-")):
            file[f"history/{name}"] = values
            file[f"history/{name}"].attrs["units"] = unit
        file["history/time"].make_scale()
        file["history/wheel/wheel"].make_scale()
        file["history/wheel/force"].dims[0].attach_scale(file["history/time"])
        file["history/wheel/force"].dims[1].attach_scale(file["history/wheel/wheel"])
    found = [curves.of_run(tmp_path / "run", "history/wheel/force", place).name
             for place in range(wheels.shape[1])]
    assert found == [f"run, {name}" for name in names]


def pair():
    return transition.named([test_transition.train(7.8),
                             test_transition.train(5.4, wedge_present=False)])


def drawn_transition(monkeypatch):
    monkeypatch.setattr(model_drawing, "heading", lambda run: "made")
    trains = pair()
    return transition_figures.compare(trains, transition.changes_of(trains), ("A.", "B.", "C."),
                                      "A verdict.")


def test_legends_are_outside_of_the_curves(runs, monkeypatch):
    figures = [drawn_transition(monkeypatch), support_figure.draw(runs),
               *(bed_on_ground.FIGURES[name](runs)
                 for name in ("envelope", "sleepers", "stress", "spectrum")),
               train_figures.draw(train_figures.Passing(*test_train.made()), [])]
    for figure in figures:
        figure.canvas.draw()
        legends = [(panel, legend) for panel in figure.axes if (legend := panel.get_legend())]
        assert legends
        for panel, legend in legends:
            inside, box = panel.get_window_extent(), legend.get_window_extent()
            assert box.y0 >= inside.y1 - 1 or box.y1 <= inside.y0 + 1
    plt.close("all")


def test_displacements_on_axes_are_up_positive(runs, monkeypatch):
    level, _, settled = drawn_transition(monkeypatch).axes
    upper, lower = bed_on_ground.envelope(runs).axes
    for panel, what in ((upper, "sleepers"), (lower, "ground surface")):
        ends = ["end of the bed (hollow)"] * (panel is upper)
        assert [text.get_text() for text in panel.get_legend().texts] == [
            *(f"{what}, {run.name}" for run in runs), *ends]
    assert "run wedge: 2.00 mm; run no" in upper.get_title()
    moved, seats = stage_histories.stages(runs).axes[0:3:2]
    assert "with the\ndeck's seat_force" in seats.get_ylabel()
    sensor = bed_histories.sensors(runs).axes[0]
    _, down, left = train_figures.draw(train_figures.Passing(*test_train.made()), []).axes
    for panel in (level, settled, upper, lower, down, left, moved, sensor):
        assert panels.UP in panel.get_ylabel() and not panel.yaxis_inverted()
    assert level.lines[0].get_ydata().max() < 0 and lower.lines[0].get_ydata().max() < 0
    assert down.lines[0].get_ydata().max() < 0
    plt.close("all")


def test_lines_in_csv_have_the_run_and_panels_short_names(monkeypatch, runs):
    """Also those that the legend has under another name, or not at all."""
    shown, support = drawn_transition(monkeypatch), support_figure.draw([runs[0]])
    label = " ".join(shown.axes[2].get_ylabel().split())
    assert label == f"sleepers after the train, relative to the ground, {panels.UP}"
    found = names_in_csv(shown)
    assert list(found) == ["level", "wheel force", "sleepers after the train"]
    assert {"rail, with wedge", "rail, with wedge, not judged", "sleepers, without wedge",
            "sleepers, without wedge, end of the bed"} < found["level"]
    assert found["sleepers after the train"] == {
        f"{run} wedge{what}" for run in ("with", "without") for what in ("", ", end of the bed")}
    assert names_in_csv(support)["panel 3"] == {"wedge", "wedge, end of the bed", "wedge, hangs"}
    assert names_in_csv(bed_on_ground.stress(runs))["panel 1"] == {
        f"{run.name}{what}" for run in runs
        for what in (", each node", " (bold: mean over one sleeper spacing)")}
    stages = names_in_csv(stage_histories.stages(runs))
    assert list(stages) == ["stage load", "stage passage"]
    for figure in (shown, support, stress_paths.draw(runs), train_figures.draw(
            train_figures.Passing(*test_train.made()), []), bed_on_ground.envelope(runs)):
        assert not any(name.startswith("line ") for names in names_in_csv(figure).values()
                       for name in names)
    plt.close("all")


def names_in_csv(figure):
    """Panel -> the names of its lines."""
    found = {}
    for row in csv.DictReader(figure_csv.of_figure(figure).splitlines()):
        found.setdefault(row["panel"], set()).add(row["line"])
    return found


def test_marks_and_brackets_are_no_data_of_a_figure(monkeypatch):
    figure = drawn_transition(monkeypatch)
    panel = figure.axes[0]
    train = train_strip.Train(np.arange(5.0), np.arange(5.0)[:, None])
    train_strip.mark(panel, train, train_strip.Place(2.5, "x = 2.5 m", "C0"))
    assert sum(line.get_transform() != panel.transData for line in panel.lines) == 4
    rows = list(csv.DictReader(figure_csv.of_figure(figure).splitlines()))
    level = [row for row in rows if row["y axis"].startswith("lowest level")]
    drawn = [line for line in panel.lines if line.get_transform() == panel.transData]
    assert len(level) == sum(len(line.get_xdata()) for line in drawn)
    assert max(float(row["y"]) for row in level) <= 0  # brackets have 0.03 and 0.06
    plt.close("all")
