"""Tests of figures of two runs that differ in kind: what holds for one is not stated of both."""
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest
import test_ends
import test_words
from trackbed_post import (bed_figures, bed_histories, bed_on_ground, kinds, measures, read,
                           sleeper_histories, stage_histories)


def test_an_unfinished_passage_is_that_of_one_run(runs):
    early = test_words.until(runs[1], 0.9)
    assert measures.passage_words(runs) == "passage"
    assert measures.passage_words([early, early]) == "unfinished passage"
    title = sleeper_histories.draw([runs[0], early]).axes[0].get_title()
    assert "Sleepers during the passage, unfinished in no_wedge; lowest" in " ".join(title.split())
    plt.close("all")


def test_ends_of_the_bed_are_left_out_of_each_run(runs):
    """Springs are beside the first bed, walls at the ends of the second."""
    pair = [test_ends.below_train(runs[0]), runs[1]]
    words = ("wedge: without the three at each end of the bed; "
             "no_wedge: without the one at each end of the bed")
    assert measures.without_ends(*pair) == words
    assert measures.without_ends(*runs) == "without the one at each end of the bed"
    figure = sleeper_histories.draw(pair)
    assert figure.axes[-1].get_legend().get_title().get_text() == words
    assert words in " ".join(figure.axes[0].get_title().split())
    assert f"({words})" in " ".join(bed_on_ground.spectra(pair).axes[0].get_title().split())
    plt.close("all")


def with_stages(run, *names):
    """The run with other names of the stages whose rows it has."""
    stages = [dict(stage) for stage in run.deck["stage"]]
    for number, name in zip((3, 4), names):
        stages[number]["name"] = name
    return dataclasses.replace(run, deck={**run.deck, "stage": stages})


def test_stages_of_one_run_only_are_shown_and_named(runs):
    pair = [runs[0], with_stages(runs[1], "bed_in", "passage")]
    assert stage_histories.shown_in_any(pair) == ["bed_in", "load", "passage"]
    figure = stage_histories.stages(pair)
    panels = np.reshape(figure.axes, (3, 3))
    assert [len(panel.lines) for panel in panels[0]] == [3, 3, 6]
    title = " ".join(figure._suptitle.get_text().split())
    assert title.endswith("; bed_in not in wedge; load not in no_wedge")
    legend, = (panel.get_legend() for panel in figure.axes if panel.get_legend())
    words = [text.get_text().partition(",")[0] for text in legend.get_texts()]
    assert words.count("wedge") == words.count("no_wedge") == 3
    assert "not in" not in stage_histories.stages(runs)._suptitle.get_text()
    plt.close("all")


def test_lines_where_stages_begin_are_those_of_each_run(runs):
    later = dataclasses.replace(runs[1], stage=np.where(runs[1].time < 0.5, 3, 4))
    for draw in (bed_histories.energy, bed_figures.regions):
        for second, expected in ((runs[1], {":": "a stage begins"}),
                                 (later, {"--": "a stage of wedge begins",
                                          "-.": "a stage of no_wedge begins"})):
            panels = draw([runs[0], second]).axes
            panel = panels[0]
            lines = [line for line in panel.lines if len(line.get_xdata()) == 2]
            assert {line.get_linestyle(): line.get_label() for line in lines} == expected
            legend, = (one.get_legend() for one in panels if one.get_legend())
            assert set(expected.values()) <= {text.get_text() for text in legend.get_texts()}
    plt.close("all")


def test_the_first_stage_of_a_run_that_starts_later_has_a_line(runs):
    """As a variant that starts from a checkpoint of the first run, at which this begins a stage."""
    start = int(np.flatnonzero(np.diff(runs[0].stage))[0]) + 1
    later = dataclasses.replace(runs[1], time=runs[1].time[start:], stage=runs[1].stage[start:])
    figure, panel = plt.subplots()
    bed_figures.mark_stages([panel], [runs[0], later])
    lines = {line.get_linestyle(): line.get_xdata()[0] for line in panel.lines}
    assert lines[":"] == later.time[0] and "-." not in lines
    plt.close(figure)


def test_a_kind_that_a_run_has_not_leaves_no_empty_folder(runs, tmp_path, monkeypatch):
    def draw(results, folder):
        if results[0].name == "no_wedge":
            raise read.Unreadable("this run has no train over a bed")
        folder.file("train.txt", "made")
    monkeypatch.setitem(kinds.ALONE, "train", draw)
    monkeypatch.setattr(kinds, "of_deck", lambda deck: ["train"])
    with pytest.raises(read.Unreadable):  # no picture at all
        kinds.draw_figures([run.folder for run in runs], tmp_path / "out")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["1_wedge"]
