"""Lines of figures differ by more than their colour, and none hides another one."""
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest
import test_track
import test_train

from trackbed_post import (bed_figures, bed_histories, bed_on_ground, panels, read,
                           stage_histories, stress_paths, support_figure, track_figures,
                           train_figures)


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def looks_of(panel):
    """Without vertical lines, which have a text beside them."""
    return [(line.get_linestyle(), str(line.get_marker())) for line in panel.lines
            if not line.get_label().startswith("_") and len(set(line.get_xdata())) > 1]


def require_distinct(shown, least):
    """The panels, of which one has as many lines as `least`, have lines of different looks."""
    found = [looks_of(panel) for panel in shown]
    for looks in found:
        assert len(set(looks)) == len(looks), looks
    assert max(map(len, found)) >= least


@pytest.mark.parametrize("draw, least", [
    (stage_histories.stages, 6), (support_figure.draw, 6), (bed_on_ground.envelope, 2),
    (bed_on_ground.spectra, 2), (bed_histories.energy, 2), (bed_figures.grading, 2),
    (bed_figures.forces, 2), (bed_figures.section, 2), (stress_paths.draw, 2),
    (bed_figures.regions, 2)])
def test_lines_of_two_runs(runs, draw, least):
    require_distinct(draw(runs).axes, least)


def test_axles_over_a_bed():
    figure = train_figures.draw(train_figures.Passing(*test_train.made()), [])
    require_distinct(figure.axes, 2)


def test_places_of_a_track():
    """Three sleepers and a point of the rail."""
    run = test_track.made()
    run["sleepers/x"] = read.Quantity(np.array([4.2, 4.8, 5.4]), "m", "made")
    for name in ("displacement", "acceleration", "seat_force"):
        one = run[f"history/sleeper/{name}"].values
        run[f"history/sleeper/{name}"] = read.Quantity(np.stack([one, one, one], 1), "-", "made")
    figure = track_figures.draw(run, 20, {})
    require_distinct([panel for panel in figure.axes if panel.get_yticks().size], 4)


def five_sensors(run):
    """The second moves as the first one does, the fifth as the fourth."""
    one = run.sensors["stone"]
    names = {"a": 1.0, "b": 1.0, "c": 2.0, "d": 3.0, "e": 3.0}
    sensors = {name: {quantity: dataclasses.replace(values, values=factor * values.values)
                      for quantity, values in one.items()} for name, factor in names.items()}
    deck = {**run.deck, "sensor": [{"name": name, "at": [k + 1.0, 0.0, 0.2]}
                                   for k, name in enumerate(names)]}
    rows = len(run.time)
    wheel = {"x": read.Quantity(np.linspace(-1, 30, rows)[:, None], "m", "made")}
    return dataclasses.replace(run, sensors=sensors, deck=deck, wheel=wheel)


def test_every_sensor_is_seen_and_is_below_the_train(runs):
    figure = bed_histories.sensors([five_sensors(runs[0])])
    strip, *shown = figure.axes
    assert [text.get_text()[:1] for text in strip.texts if "x = " in text.get_text()] == [*"abcde"]
    require_distinct(shown, 5)
    lines = {line.get_label(): line for line in shown[0].lines if line.get_label() in "abcde"}
    for below, above in (("a", "b"), ("d", "e")):
        assert lines[below].get_markevery()[0] != lines[above].get_markevery()[0]
        assert lines[below].get_marker() != lines[above].get_marker()
    assert lines["a"].get_color() == strip.texts[0].get_color()


def test_more_sensors_than_fit_are_stated(runs, monkeypatch):
    monkeypatch.setattr(bed_histories, "MOST", 3)
    figure = bed_histories.sensors([five_sensors(runs[0])])
    assert figure.axes[0].get_title().endswith("below the train: the first 3 of 5")


def test_curves_differ_in_colour_marker_and_place_of_the_marks():
    looks = [panels.curve(number, 1200) for number in range(27)]
    assert len({(look["color"], look["marker"]) for look in looks}) == 27
    assert len({look["markevery"] for look in looks[:8]}) == 8
    assert {look["markevery"][1] for look in looks} == {100}
    assert panels.curve(3, 5)["markevery"] == (0, 1)
