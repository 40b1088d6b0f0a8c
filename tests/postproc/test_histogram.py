"""Histograms of datasets of runs."""
import csv

import conftest
import made
import numpy as np
import pytest
from trackbed_post import histogram


@pytest.fixture(name="run", scope="module")
def one_run(tmp_path_factory):
    return made.write(tmp_path_factory.mktemp("histogram") / "one")


def counts(folder):
    with (folder / "histogram.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    return rows[0], np.array(rows[1:], float)


def test_contact_forces_of_two_runs_in_the_same_bins(run, tmp_path):
    other = made.write(tmp_path / "two")
    ran = conftest.call("histogram", "contact_force", run, other, "-o", tmp_path, "--bins", "4",
                        "--format", "png,csv", "--log")
    assert ran.returncode == 0, ran.stderr
    head, rows = counts(tmp_path)
    assert head == ["from_N", "to_N", "count of one; load", "count of two; load"]
    assert rows.tolist() == [[100, 300, 1, 1], [300, 500, 0, 0], [500, 700, 0, 0],
                             [700, 900, 1, 1]]
    assert "one, load: 2 values, mean 500, standard deviation 400" in ran.stdout
    assert (tmp_path / "histogram_lines.csv").is_file()


def test_a_history_counts_the_rows_of_a_stage(run, tmp_path):
    words = ("histogram", "history/sleeper/displacement", run, "-o", tmp_path, "--bins", "2")
    assert conftest.call(*words).returncode == 0
    assert counts(tmp_path)[1][:, 2].sum() == 2100 * 15
    assert conftest.call(*words, "--stage", "passage", "--place", "3").returncode == 0
    rows = counts(tmp_path)[1]
    # A sine of 1 mm at 2 Hz over 2 s, four whole periods.
    assert rows[:, 2].tolist() == pytest.approx([1000, 1000], abs=4)
    assert rows[0, 0] == pytest.approx(-1e-3) and rows[-1, 1] == pytest.approx(1e-3)
    assert conftest.call(*words, "--stage", "passage", "--change").returncode == 0
    # The passage begins at 0.1 s, where the sine is sin(0.4 pi).
    assert counts(tmp_path)[1][0, 0] == pytest.approx(-1e-3 * (1 + np.sin(0.4 * np.pi)), rel=1e-6)


def test_equal_values_have_a_bin_and_missing_ones_are_named(tmp_path):
    (tmp_path / "one").mkdir()
    made.store(tmp_path / "one/results.h5",
               {"history/wheel/force": (np.array([np.nan, 5.0, 5.0]), "N")},
               deck="", version="0", ranks=1)
    ran = conftest.call("histogram", "history/wheel/force", tmp_path / "one", "-o", tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert "1 values that are no numbers are left out" in ran.stdout
    rows = counts(tmp_path)[1]
    assert rows[:, 2].sum() == 2 and len(rows) == histogram.BINS


@pytest.mark.parametrize("words, problem", [
    (("history/none",), "has no dataset history/none; it has contact_force and "),
    (("contact_force", "--stage", "lay"), "no contact forces of a stage lay; there are chains"),
    (("history/sleeper/velocity", "--stage", "lay"), "there is no stage lay; the stages are fill"),
    (("history/sleeper/velocity", "--place", "15"), "has the places 0 to 14")])
def test_what_is_not_there_is_said(run, tmp_path, words, problem):
    ran = conftest.call("histogram", *words, run, "-o", tmp_path)
    assert ran.returncode == 2 and problem in ran.stderr
