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
    assert head == ["from_N", "to_N", "count of one", "count of two"]
    assert rows.tolist() == [[100, 300, 1, 1], [300, 500, 0, 0], [500, 700, 0, 0],
                             [700, 900, 1, 1]]
    assert "one end of stage load, largest seat load 0.0 kN: 2 values, mean 500, standard " \
        "deviation 400" in ran.stdout
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
    assert "1 values are left out" in ran.stdout
    rows = counts(tmp_path)[1]
    assert len(rows) == histogram.BINS and np.count_nonzero(rows[:, 2]) == 1
    (low, high, count), = rows[rows[:, 2] > 0]
    assert count == 2 and (low + high) / 2 == pytest.approx(5)


@pytest.mark.parametrize("value", [0.0, -1e-3, 5.0, 3e9])
@pytest.mark.parametrize("bins", [1, 4, 5, 40])
def test_equal_values_are_in_the_middle_of_a_bin(value, bins):
    edges = histogram.edges_of([histogram.Sample("one", np.full(3, value), "N")], bins)
    there = np.flatnonzero(np.histogram(np.full(3, value), edges)[0])
    assert len(edges) == bins + 1 and len(there) == 1
    assert edges[there[0]:there[0] + 2].mean() == pytest.approx(value, abs=1e-12)


def test_changes_count_from_the_first_number_of_each_place(tmp_path):
    (tmp_path / "one").mkdir()
    force = np.array([[5.0, np.nan], [6.0, 20.0], [7.0, 23.0], [np.nan, np.nan]])
    made.store(tmp_path / "one/results.h5", {"history/wheel/force": (force, "N")},
               deck="", version="0", ranks=1)
    ran = conftest.call("histogram", "history/wheel/force", tmp_path / "one", "-o", tmp_path,
                        "--change", "--bins", "3")
    assert ran.returncode == 0 and "3 values are left out" in ran.stdout, ran.stderr
    assert counts(tmp_path)[1].tolist() == [[0, 1, 2], [1, 2, 1], [2, 3, 2]]


def test_wheels_beyond_the_run_ins_of_a_track_alone_do_not_count(tmp_path):
    (tmp_path / "one").mkdir()
    x = np.array([[-1.0, -3.0], [5.0, 3.0], [9.0, 7.0], [19.0, 17.0]])
    made.store(tmp_path / "one/results.h5", {
        "history/wheel/x": (x, "m"), "history/wheel/force": (np.arange(8.0).reshape(4, 2), "N")},
        deck='model = "track"\n[track]\nlength = 20\nrun_in = 4\n', version="0", ranks=1)
    ran = conftest.call("histogram", "history/wheel/force", tmp_path / "one", "-o", tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert "one: 3 values, mean 3.667" in ran.stdout and "5 values are left out" in ran.stdout


def test_stages_without_the_body_do_not_count(tmp_path):
    """A platen that is there in the second stage only, zero in its first row."""
    (tmp_path / "one").mkdir()
    stage = np.repeat([0, 1, 2], 3)
    z = np.array([0, 0, 0, 0, 0.3, 0.2, 0, 0, 0])
    made.store(tmp_path / "one/results.h5", {
        "history/time": (np.arange(9.0), "s"), "history/stage": (stage, "-"),
        "history/platen/z": (z, "m"), "history/platen/pressure": (5 * z, "Pa"),
        "history/traffic/cycles": (np.where(stage == 2, 1.0, 0.0), "-")},
        deck="".join(f"[[stage]]\nname = '{name}'\n" for name in ("fill", "compact", "rest")),
        version="0", ranks=1)
    words = ("histogram", "history/platen/z", tmp_path / "one", "-o", tmp_path)
    ran = conftest.call(*words)
    assert ran.returncode == 0, ran.stderr
    assert "one: 3 values, mean 0.1667" in ran.stdout
    assert "without fill, rest, where all histories of this group are zero" in ran.stdout
    assert "one: 3 values, mean 0," in conftest.call(*words, "--stage", "rest").stdout
    words = ("histogram", "history/traffic/cycles", tmp_path / "one", "-o", tmp_path)
    assert "one: 9 values" in conftest.call(*words).stdout  # zero is a number of cycles


def test_a_column_of_a_table_has_its_own_unit(run, tmp_path):
    words = ("histogram", "stones/load/sieved", run, "-o", tmp_path, "--place", "1")
    assert conftest.call(*words).returncode == 0
    assert counts(tmp_path)[0][0] == "from_kg"
    words = ("histogram", "bed/grading", run, "-o", tmp_path, "--place", "3")
    assert conftest.call(*words).returncode == 0
    assert counts(tmp_path)[0][0] == "from_%"


@pytest.mark.parametrize("words, problem", [
    (("stones/load/sieved",), "has 2 columns (made for a test; m, kg): choose one with --place"),
    (("history/none",), "has no dataset history/none; it has contact_force and "),
    (("contact_force", "--stage", "lay"), "no contact forces of a stage lay; there are chains"),
    (("history/sleeper/velocity", "--stage", "lay"), "there is no stage lay; the stages are fill"),
    (("history/sleeper/velocity", "--place", "15"), "has the places 0 to 14"),
    (("envelope/ground/sigma_z_min", "--stage", "passage"),
     "envelope/ground/sigma_z_min is no history: it has no rows of a stage passage"),
    (("chains/load/force", "--stage", "nonsense"), "is no history: it has no rows of a stage"),
    (("contact_force", "--change"), "contact_force is no history: it has no change"),
    (("envelope/ground/sigma_z_min", "--change"), "is no history: it has no change")])
def test_what_is_not_there_is_said(run, tmp_path, words, problem):
    ran = conftest.call("histogram", *words, run, "-o", tmp_path)
    assert ran.returncode == 2 and problem in ran.stderr
