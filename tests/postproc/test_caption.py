"""Tests of the texts of transition.png and model.png: short, complete, and beside what they are
about."""
import dataclasses
import re
import types

import matplotlib.pyplot as plt
import numpy as np
import pytest
import test_film
import test_transition
from trackbed_post import (model_drawing, transition, transition_caption, transition_figures,
                           transition_verdict, write)


def pair():
    trains = transition.named([test_transition.train(7.8),
                               test_transition.train(5.4, wedge_present=False)])
    return trains, transition.changes_of(trains)


def sentences(text):
    return re.split(r"(?<=\.) (?=[A-Z0-9])", text)


def test_panels_have_their_message_as_title_and_the_rest_is_below_them():
    effect, force, settlement = transition_caption.titles(*pair(), "")
    steepest, sleepers, plain, limits = sentences(transition_caption.of(*pair(), "", True))
    assert settlement == ("After this passage no judged sleeper has settled or risen by more "
                          "than 0.1 mm in either run.")
    assert effect == (
        "With the wedge the rail reaches 90% of its change from structure to plain track 2.7 m "
        "behind the structure instead of 0.5 m, and the steepest part of the change is 80% less "
        "steep: as expected of a wedge.")
    assert steepest == ("The steepest change of the rail is 0.20 mm/m, 1.5 m behind the "
                        "structure, instead of 1.0 mm/m, 0.3 m behind the structure.")
    assert sleepers == (
        "The sleepers' own levels (thin lines) change over 2.7 m instead of 0.5 m, and their "
        "steepest change is 0.20 mm/m instead of 1.0 mm/m: both as expected of a wedge.")
    assert force == ("Largest wheel force between structure and plain track: 60.0 kN (with "
                     "wedge) and 60.0 kN (without wedge): no clear effect.")
    assert plain == ("On plain track the largest wheel force is 60.0 kN (with wedge) and 60.0 kN "
                     "(without wedge).")
    assert limits.startswith(
        "Limits: in this plane model loads do not spread across the track; one packing of stones "
        "was computed; on plain track the rail changes by up to 0.0 mm/m between neighbouring "
        "sleepers; ")
    assert limits.endswith("; warnings are in transition.txt.")
    assert "other places" not in limits


@pytest.mark.parametrize("by, words", [
    (-2e-4, "-0.300 to -0.100 mm"), (3e-4, "-0.100 to +0.200 mm")])
def test_sleepers_that_move_downwards_or_upwards_are_stated(by, words):
    """All others settle by 0.1 mm."""
    trains, _ = pair()
    trains[1].passing.left[8] += by
    assert transition_caption.settlement(trains) == (
        "Sleepers after this passage, relative to the ground: -0.100 to -0.100 mm (with wedge) and "
        f"{words} (without wedge), up positive.")
    small = transition_caption.settlement(trains[:1])
    assert small == "After this passage no judged sleeper has settled or risen by more than 0.1 mm."


def test_the_title_of_settlements_is_not_about_how_far_sleepers_move_under_the_train():
    trains, _ = pair()
    trains[0].passing.displacement[len(trains[0].passing.time) // 2] -= 1e-3
    title = transition_caption.settlement(trains)
    assert title.startswith("After this passage no judged sleeper has settled")


def test_a_run_that_is_warned_of_gets_no_reassuring_title():
    trains, changes = pair()
    why = "a wheel is off the rail (run with wedge)"
    for given in (changes, None):
        title = transition_caption.titles(trains, given, why)[2]
        assert title.startswith("Sleepers after this passage, relative to the ground: -0.100 to")
    alone = transition_caption.of(trains[:1], changes[:1], why, True)
    assert alone.startswith("No verdict: give a second run, without the wedge; a wheel is off the "
                            "rail (run with wedge); warnings are in transition.txt.")


def test_a_force_that_is_larger_than_elsewhere_is_called_so():
    trains, _ = pair()
    trains[1].passing.force[np.abs(trains[1].passing.x - 6.9) < 0.05] = 80e3
    text = transition_caption.titles(trains, transition.changes_of(trains), "")[1]
    assert text.endswith(", and clearly larger than on plain track (without wedge only).")
    assert "Without wedge, it is clearly larger" in transition_verdict.verdict(
        trains, transition.changes_of(trains))
    trains[0].passing.force[np.abs(trains[0].passing.x - 6.9) < 0.05] = 80e3
    changes = transition.changes_of(trains)
    text = transition_caption.titles(trains, changes, "")[1]
    assert text.endswith(", and clearly larger than on plain track.")
    assert "With wedge and without wedge, it is clearly larger" in transition_verdict.verdict(
        trains, changes)


def test_names_keep_their_capitals():
    """A folder's whole name, and that of a block behind our first word."""
    trains = [dataclasses.replace(train, name=f"run_{name}", run=types.SimpleNamespace(
        **{**vars(train.run), "name": f"run_{name}"})) for train, name in zip(pair()[0], "AB")]
    text = transition_caption.titles(trains, transition.changes_of(trains), "not known")[0]
    assert "run_A, the change of" in text and "run_B 1.0 mm/m, 0.3 m behind" in text
    slabs = [dataclasses.replace(train, name=f"{word} Slab")
             for train, word in zip(trains, ("with", "without"))]
    text = transition_caption.titles(slabs, transition.changes_of(slabs), "not known")[0]
    assert "With Slab, the change of" in text and ", without Slab 1.0 mm/m, 0.3 m" in text


def test_parts_that_are_other_places_are_called_so():
    trains, _ = pair()
    x = trains[1].run.sleepers_x
    shifted = dataclasses.replace(trains[1], run=types.SimpleNamespace(
        **{**vars(trains[1].run), "sleepers_x": x + 0.05}))
    for second, same in ((trains[1], True), (shifted, False)):
        both = [trains[0], second]
        text = transition_caption.limits(both, transition.changes_of(both))
        assert ("other places in the second run" in text) != same


def test_a_change_that_is_never_reached_has_no_distance():
    trains, changes = pair()
    never = [dataclasses.replace(change, width=np.nan) for change in changes]
    for given, words in (
            (never[:1], "plain track is not reached; its steepest part"),
            ([never[0], changes[1]], "not reached, without wedge it extends over 0.5 m; its"),
            ([changes[0], never[1]], "over 2.7 m, without wedge the end of it is not reached;")):
        text = transition_caption.titles(trains[:len(given)], given, "")[0]
        assert words in text and "nan" not in text


def test_sleepers_have_a_verdict_for_each_number():
    trains, changes = pair()
    uneven = [dataclasses.replace(change, sleeper_scatter=1e-3) for change in changes]
    for given, words in (
            ([dataclasses.replace(change, sleeper_scatter=9e-4) for change in changes],
             "2.7 m instead of 0.5 m: as expected of a wedge; their steepest change is 0.20 mm/m "
             "instead of 1.0 mm/m: no clear effect."),
            (uneven, "1.0 mm/m, not larger than the scatter on plain track: no verdict from it."),
            ([dataclasses.replace(changes[0], sleeper_width=np.nan), changes[1]],
             "(thin lines) do not reach the end of their change in both runs; their steepest "
             "change is 0.20 mm/m instead of 1.0 mm/m: as expected of a wedge.")):
        assert words in transition_caption.own_levels(trains, given)


def test_the_caption_states_why_there_is_no_verdict_and_the_numbers():
    text = transition_caption.of(*pair(), "1 of 31 sleepers hang (run with wedge)", True)
    first, *rest = sentences(text)
    assert first == ("No verdict: 1 of 31 sleepers hang (run with wedge); warnings are in "
                     "transition.txt.")
    assert [one.split()[0] for one in rest] == ["On", "Limits:"]
    titles = " ".join(transition_caption.titles(*pair(), "1 of 31 sleepers hang"))
    assert "extends over 2.7 m" in titles and "60.0 kN (without wedge)." in titles
    assert "expected" not in titles and "clear" not in titles
    one = [test_transition.train(7.8)]
    text = transition_caption.of(one, transition.changes_of(one), "", False)
    assert len(sentences(text)) == 3 and text.startswith("No verdict: give a second run")
    assert "On plain track the largest wheel force is 60.0 kN. " in text
    assert transition_caption.of(one, None, "", False).count(".") == 1
    assert transition_caption.titles(one, None, "")[0] == (
        "Lowest level of rail and sleepers under the train.")


def test_the_file_has_the_whole_verdict_and_the_figure_the_short_one(tmp_path, monkeypatch):
    shown = []
    trains, changes = pair()
    trains[0].run.warnings, trains[1].run.warnings = ("stage bed_in ended early",), ()
    monkeypatch.setattr(transition, "train_of", lambda path: trains[path])
    monkeypatch.setattr(transition.bed_warnings, "warnings_of", lambda *_: [])
    monkeypatch.setattr(transition.passage_warnings, "warnings_of_bed", lambda *_: [])
    monkeypatch.setattr(transition.passage_warnings, "of_bed", lambda run: ["pads pull"])
    monkeypatch.setattr(transition_figures, "draw_model", lambda *_: plt.figure())
    monkeypatch.setattr(transition_figures, "compare", lambda *rest: shown.append(rest[-1]) or
                        plt.figure())
    monkeypatch.setattr(write, "origin_of", lambda paths: "made")
    folder = write.Folder(tmp_path)
    transition.draw_into([0, 1], folder)
    assert sentences(shown[0])[-1].endswith("; warnings are in transition.txt.")
    assert "pads pull" not in shown[0]
    assert folder.tables[0].endswith(
        "\nWarnings of the runs:\nwith wedge and without wedge: pads pull.\n"
        "with wedge: stage bed_in ended early.\n")
    text = " ".join(folder.tables[0].split())
    assert "a difference above one sleeper spacing, 0.6 m, counts as clear" in text
    assert changes is not None
    plt.close("all")


def test_names_of_parts_do_not_cover_their_brackets(monkeypatch):
    monkeypatch.setattr(model_drawing, "heading", lambda run: "made")
    trains, changes = pair()
    figure = transition_figures.compare(trains, changes, ("A.", "B.", "C."), "A verdict.")
    figure.canvas.draw()
    panel = figure.axes[0]
    brackets = [line for line in panel.lines if line.get_transform() != panel.transData
                and len(line.get_xdata()) == 4]
    names = [text for text in panel.texts if text.get_position()[1] < 0.1]
    assert len(names) == len(brackets) == 3
    for bracket, name in zip(brackets, names):
        line, text = bracket.get_window_extent(), name.get_window_extent()
        assert text.y0 >= line.y1 and line.x0 <= text.x0 and text.x1 <= line.x1
    assert panel.texts[-1].get_text() == "wedge", "as in the text"
    plt.close(figure)


def test_the_answer_is_in_the_first_panel_and_ends_of_the_bed_are_marked(monkeypatch):
    monkeypatch.setattr(model_drawing, "heading", lambda run: "made")
    trains, changes = pair()
    titles = transition_caption.titles(trains, changes, "")
    figure = transition_figures.compare(trains, changes, titles, "A verdict.")
    figure.canvas.draw()
    assert [" ".join(panel.get_title().split()) for panel in figure.axes] == list(titles)
    ends = test_transition.X[[0, 1, 2, -3, -2, -1]]
    for panel in figure.axes[::2]:
        hollow = [line for line in panel.lines if len(line.get_xdata()) == len(ends)
                  and line.get_markerfacecolor() == "white"]
        assert len(hollow) == 2 and hollow[0].get_xdata() == pytest.approx(ends)
        words = [text.get_text() for text in panel.get_legend().texts]
        assert words.count("not judged (hollow, light)") == 1
    rail = next(line for line in figure.axes[0].lines if line.get_label() == "rail, with wedge")
    assert rail.get_xdata()[[0, -1]] == pytest.approx(test_transition.X[[3, -4]])
    for light, part in zip(figure.axes[0].lines, (slice(4), slice(-4, None))):
        assert light.get_alpha() < 1
        assert light.get_xdata() == pytest.approx(test_transition.X[part])
    lights, before, whole = figure.axes[1].lines[:3]
    assert max(one.get_alpha() for one in (lights, before)) < 1
    assert whole.get_xdata()[[0, -1]] == pytest.approx(test_transition.X[[3, -4]], abs=0.1)
    assert "mean of all wheels on the bed, 60.0 kN (with wedge)" in [
        text.get_text() for text in figure.axes[1].get_legend().texts]
    direction, = [text for text in figure.axes[0].texts
                  if text.get_text() == model_drawing.DIRECTION]
    boxes = [figure.axes[0].title, figure.axes[0].get_legend(), figure.axes[0]]
    assert not any(direction.get_window_extent().overlaps(one.get_window_extent())
                   for one in boxes)
    assert all(panel.get_xticklabels()[0].get_visible() for panel in figure.axes)
    for panel in figure.axes:
        assert not panel.title.get_window_extent().overlaps(panel.get_legend().get_window_extent())
    plt.close(figure)


@pytest.mark.parametrize("with_files", [True, False])
def test_the_model_states_its_instant_and_hides_no_vehicle(tmp_path, with_files):
    train = test_film.train_at()
    run = train.run
    run.time, run.ground_x = train.passing.time, np.empty(0)
    outline = [9.0, 0.0, 12.0, 0.0, 12.0, -1.0, 9.0, -1.0]
    run.deck["ground"] = {"block": [{"name": "wedge", "young": 1e9, "outline": outline}]}
    train.passing.force = np.full((*train.passing.x.shape, 1), 50e3)
    train.passing.on_bed = lambda: (train.passing.x > 0.6) & (train.passing.x < 18)
    folder = test_film.written(tmp_path) if with_files else tmp_path
    figure = transition_figures.draw_model(train, folder)
    figure.canvas.draw()
    panel = figure.axes[0]
    chosen = next(time for time in test_film.TIMES[::-1]
                  if 40 * (time - 2.5) - 2.5 < 18.6 + model_drawing.BEYOND)
    words = panel.get_title()
    if with_files:
        assert words == f"Model with wedge; contact forces at {chosen:.3f} s"
    else:
        assert words.startswith("Model with wedge; train at ") and "\n" not in words
    assert [text.get_text() for text in figure.axes[1].texts if text.get_visible()][-3:] == [
        "sleeper", "ballast", "rail"]
    note = next(text for text in figure.texts if "stones and sleepers:" in text.get_text())
    assert f"sleepers: end of the run (last row: {run.time[-1]:.3f} s)" in note.get_text()
    assert len(figure.legends) == int(with_files) and panel.get_legend() is None
    direction, = [text for text in figure.texts if text.get_text() == model_drawing.DIRECTION]
    between = [*figure.legends, direction, note]
    for number, one in enumerate(between):
        box = one.get_window_extent()
        assert not any(box.overlaps(each.get_tightbbox()) for each in figure.axes)
        assert not any(box.overlaps(each.get_window_extent()) for each in between[:number])
    plt.close(figure)
