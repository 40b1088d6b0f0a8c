"""Tests of the figure sleepers.png: few colours, and what they stand for."""
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import test_words
from trackbed_post import figure_csv, measures, panels, sleeper_histories


def histories(panel):
    return [line for line in panel.lines if not line.get_label().startswith("_")]


def test_a_colour_and_a_marker_stand_for_a_sleeper_and_a_line_for_a_run(runs):
    figure = sleeper_histories.draw(runs)
    lines = histories(figure.axes[0])
    looks = [(line.get_color(), line.get_marker()) for line in lines]
    assert looks[:3] == looks[3:] == [("C0", "o"), ("C1", "s"), ("C2", "v")]
    assert [line.get_linestyle() for line in lines] == 3 * ["-"] + 3 * ["--"]
    run, rows = runs[1], runs[1].passage()
    shown = measures.chosen_sleepers(run)[2]
    moved = run.sleeper["displacement"].values[rows, shown]
    assert np.allclose(lines[5].get_ydata(), 1e3 * (moved - moved[0]))
    starts = {line.get_markevery()[0] for line in lines}
    assert len(starts) == 3  # markers do not hide each other
    plt.close(figure)


def test_the_legend_names_each_sleeper_and_each_run_once(runs):
    def words(*shown):
        figure = sleeper_histories.draw(shown)
        found = [text.get_text() for text in figure.axes[-1].get_legend().texts]
        plt.close(figure)
        return found
    places = [f"sleeper at x = {runs[0].sleepers_x[k]:.2f} m"
              for k in measures.chosen_sleepers(runs[0])]
    assert words(runs[0]) == places
    assert words(*runs) == [*places, "run wedge", "run no_wedge"]
    moved = dataclasses.replace(runs[1], sleepers_x=runs[1].sleepers_x + 0.01)
    first = measures.chosen_sleepers(runs[0])[0]
    assert words(runs[0], moved)[0] == (f"sleeper at x = {runs[0].sleepers_x[first]:.2f} m or "
                                        f"{moved.sleepers_x[first]:.2f} m")


def test_the_csv_names_run_and_sleeper_of_each_history(runs):
    figure = sleeper_histories.draw(runs)
    text = figure_csv.of_figure(figure)
    for run in runs:
        for k in measures.chosen_sleepers(run):
            assert f'"{run.name}, x = {run.sleepers_x[k]:.2f} m"' in text
    label = " ".join(figure.axes[0].get_ylabel().split())
    assert label == f"displacement since the passage began, {panels.UP}"
    plt.close(figure)


def test_the_title_states_an_unfinished_passage(runs):
    early = test_words.until(runs[0], 0.9)
    for run, words in ((runs[0], "passage"), (early, "unfinished passage")):
        figure = sleeper_histories.draw([run])
        assert figure.axes[0].get_title().startswith(f"Sleepers during the {words}; lowest of all")
        plt.close(figure)
