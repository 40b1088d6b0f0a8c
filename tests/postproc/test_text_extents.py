"""No text of a figure is cut off at its edges or lies over that of another panel."""
import dataclasses

import matplotlib.pyplot as plt
import matplotlib.quiver
import numpy as np
import pytest
import test_ends
import test_train
from trackbed_post import (bed_on_ground, field_sections, maps, panels, read, support_figure,
                           train_figures, write)

LONG = "a_wedge_of_7_m_on_20_MPa"


def texts_of(figure):
    """Titles, labels and texts with words, without numbers on axes, and legends."""
    numbers = {text for panel in figure.axes for axis in (panel.xaxis, panel.yaxis)
               for text in (*axis.get_majorticklabels(), *axis.get_minorticklabels())}
    found = [one for one in figure.findobj(plt.Text)
             if one not in numbers and one.get_visible() and one.get_text().strip()]
    return [*found, *(legend for panel in figure.axes if (legend := panel.get_legend()))]


def cut_off(figure):
    """The texts that reach beyond the figure, and titles that overlap."""
    figure.canvas.draw()
    whole = figure.bbox
    wrong = []
    for one in texts_of(figure):
        box = one.get_window_extent()
        clipped = one.get_clip_on() and one.get_clip_box() is not None
        if box.width and not clipped and (
                box.x0 < whole.x0 - 1 or box.x1 > whole.x1 + 1 or box.y0 < whole.y0 - 1
                or box.y1 > whole.y1 + 1):
            wrong.append(getattr(one, "get_text", lambda: "legend")())
    titles = [panel.title for panel in figure.axes if panel.get_title()]
    boxes = [title.get_window_extent() for title in titles]
    wrong += [f"{titles[k].get_text()} over {titles[j].get_text()}" for k in range(len(boxes))
              for j in range(k) if boxes[k].overlaps(boxes[j])]
    return wrong


@pytest.fixture(name="cut")
def texts_cut_off(monkeypatch):
    """Name of each picture that is written -> its texts that are cut off."""
    found = {}

    def see(self, name, figure, origin=""):
        with monkeypatch.context() as inner:
            inner.setattr(plt, "close", lambda _: None)
            written(self, name, figure, origin)
        found[name] = cut_off(figure)
        plt.close(figure)
    written = write.Folder.picture
    monkeypatch.setattr(write.Folder, "picture", see)
    return found


def named(runs):
    """With long names, and gaps below sleepers, also at the ends of the bed."""
    found = []
    for run, name in zip(runs, (LONG, LONG + "_none")):
        run = test_ends.below_train(run)
        stages = [dict(one, kind="passage") if one["name"] in ("load", "passage") else one
                  for one in run.deck["stage"]]
        reaction = run.sleeper["reaction"].values.copy()
        moved = run.sleeper["displacement"].values.copy()
        rows = run.passage()
        time = run.time[rows] - run.time[rows][0]
        pulse = np.exp(-((time - 1) / 0.1)**2)[:, None] * np.ones(moved.shape[1])
        moved[rows] = -3e-3 * pulse**0.5
        reaction[rows] = 5e3 + 50e3 * pulse**4
        potential = run.energy["potential"].values - 21e3 * (run.stage == 4)
        found.append(dataclasses.replace(
            run, name=name, deck={**run.deck, "stage": stages},
            energy={**run.energy, "potential": read.Quantity(potential, "J", "-")},
            sleeper={**run.sleeper, "displacement": read.Quantity(moved, "m", "-"),
                     "reaction": read.Quantity(reaction, "N", "-")}))
    return found


def test_texts_of_a_bed_are_whole(runs, tmp_path, cut):
    both = named(runs)
    assert "at the ends of the bed" in support_figure.draw(both[:1]).axes[2].get_title()
    for shown in (both, both[:1]):
        bed_on_ground.draw_all(shown, write.Folder(tmp_path))
        assert set(cut) == set(bed_on_ground.FIGURES)
        assert not {name: texts for name, texts in cut.items() if texts}


@pytest.mark.parametrize("rails", [1, 2])
def test_texts_of_a_train_with_many_axles_are_whole(tmp_path, cut, rails):
    """Four axles; the stage is not the last passage, and the train has not passed all sleepers."""
    run, every = test_train.made()
    x = every["history/wheel/x"].values
    every = {name: read.Quantity(one.values[:1200], "-", "-") for name, one in every.items()}
    run.time = run.time[:1200]
    x = np.repeat(np.concatenate([x, x - 2], axis=1)[:1200], rails, axis=1)
    every["history/wheel/x"] = read.Quantity(x, "m", "-")
    every["history/wheel/force"] = read.Quantity(np.where(np.isfinite(x), 5e4, np.nan), "N", "-")
    every["history/seat/displacement"] = read.Quantity(np.zeros((1200, 6)), "m", "-")
    figure = train_figures.draw(train_figures.Passing(run, every), [], (
        "stage first_train_over_the_bed (not the last passage, stage train_over_the_bed: no train "
        "in its rows yet)"))
    write.Folder(tmp_path).picture("train", figure)
    assert cut == {"train": []}


def test_the_key_of_arrows_is_above_a_flat_panel():
    """Of a plane model of 20 m by 0.5 m."""
    x, z = (one.ravel() for one in np.meshgrid(np.linspace(0, 20, 81), np.linspace(0, 0.5, 6)))
    layer = field_sections.Layer("stones", np.stack([x, z], 1),
                                 np.stack([x, 0 * x, z], 1), outline=None)
    choices = field_sections.Choices(array="velocity")
    figure = maps.draw([layer], "velocity at 1 s, plane xz at y = 0 m", choices, "m/s")
    assert not cut_off(figure)
    panel = figure.axes[0]
    key, = panel.findobj(matplotlib.quiver.QuiverKey)
    assert key.text.get_window_extent().y0 > panel.get_window_extent().y1
    plt.close(figure)


def test_long_titles_are_wrapped():
    text = panels.wrapped("word " * 60 + "\nnext", 9, 10)
    assert text.endswith("\nnext") and max(map(len, text.split("\n"))) < 9 * 72 / 5
    figure = plt.figure(figsize=(9, 3))
    figure.suptitle(text, fontsize=10)
    assert not cut_off(figure)
    plt.close(figure)


def test_what_is_cut_off_is_noticed():
    figure, panel = plt.subplots(figsize=(4, 3))
    panel.set_title("a title that is longer than the figure is wide " * 2)
    assert cut_off(figure)
    plt.close(figure)
