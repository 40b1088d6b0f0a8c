"""Tests of train_figures.py on synthetic histories with known results."""
import types

import conftest
import matplotlib.pyplot as plt
import numpy as np
import pytest
from trackbed_post import axles, ground_blocks, panels, read, train_figures


def made(trains=1):
    """Two axles 10 m apart at 10 m/s, 50 and 60 kN, over sleepers at 3, 4 and 5 m. Each displaces a
    sleeper by 1 mm downwards while within 0.1 m and leaves 0.1 mm. One row before has no train."""
    way = np.concatenate([np.linspace(0, 30, 3001)] * trains)
    x = np.stack([way, way - 10], axis=1)
    time = 0.01 * np.arange(len(way))
    sleepers = np.array([3.0, 4.0, 5.0])
    down = np.zeros((len(way), 3))
    for axle in range(2):
        off = x[:, axle, None] - sleepers
        passed = np.diff(off > 0, axis=0, prepend=off[:1] > 0) & (off > 0)
        down -= 1e-3 * (np.abs(off) < 0.1) + 1e-4 * np.cumsum(passed, axis=0)
    nan = np.full((1, 2), np.nan)
    every = {"history/wheel/x": np.vstack([nan, x]),
             "history/wheel/force": np.vstack([nan, np.full(x.shape, 1) * [50e3, 60e3]]),
             "history/rail/displacement": np.vstack([nan[:, :1].repeat(3, 1), 1.5 * down]),
             "history/sleeper/displacement": np.vstack([np.zeros((1, 3)), down])}
    run = types.SimpleNamespace(name="made", sleepers_x=sleepers,
                                time=np.concatenate([[-0.01], time]), ground_x=np.empty(0),
                                deck={"sleepers": {"spacing": 1.0}, "ground": {"present": True}})
    return run, {name: read.Quantity(values, "-", "made for a test")
                 for name, values in every.items()}


def test_settlement_of_each_axle():
    found = train_figures.numbers(train_figures.Passing(*made()))
    assert found["largest wheel force over the judged sleepers"] == (pytest.approx(60), "kN")
    assert found["least wheel force over the judged sleepers"] == (pytest.approx(50), "kN")
    # Right behind the axle the displacement is the deflection plus the settlement by this axle.
    down = "largest downward sleeper displacement"
    more = "largest downward sleeper displacement minus that of axle 1, mean of sleepers"
    assert found[f"axle 1, {down}, mean of sleepers"][0] == pytest.approx(1.1)
    assert found[f"axle 2, {down}, largest of sleepers"][0] == pytest.approx(1.2)
    assert found[f"axle 2, {more}"][0] == pytest.approx(0.1)
    left = "residual downward displacement of sleepers, ground included"
    assert found[f"{left}, largest"][0] == pytest.approx(0.2)


@pytest.mark.parametrize("move, words", [(4.0, "↑ up to\n+4 mm,\nnot judged"), (0.05, "")])
def test_sleepers_at_the_ends_do_not_set_the_scale_of_the_differences(move, words):
    run, every = made()
    passing = train_figures.Passing(run, every)
    passing.lowest[1, 2] = passing.lowest[0, 2] + 1e-3 * move
    panel = train_figures.draw(passing, []).axes[2]
    texts = [text.get_text() for text in panel.texts]
    assert words in texts or not words and not texts
    assert panel.get_ylim()[1] < 0.1
    assert not words or max(panel.lines[0].get_ydata()) == pytest.approx(move), "the whole line"
    plt.close("all")


def test_sleepers_at_the_ends_of_the_bed_are_marked_and_do_not_count():
    """The first and last of three: they go lower, and stay so, with the rail above them."""
    run, every = made()
    before = train_figures.numbers(train_figures.Passing(run, every))
    for name in ("rail", "sleeper"):
        every[f"history/{name}/displacement"].values[1:, [0, 2]] *= 3
    x = every["history/wheel/x"].values
    every["history/wheel/force"].values[np.abs(x - run.sleepers_x[1]) > 0.51] *= 2
    passing = train_figures.Passing(run, every)
    assert train_figures.numbers(passing) == before
    assert train_figures.sentence("made", "", passing, before).startswith(
        "made: wheel forces over the judged sleepers (x = 3.50 to 4.50 m) from 50 kN to 60 kN; "
        "rail lowered there by up to ")
    figure = train_figures.draw(passing, [])
    for panel in figure.axes[1:]:
        hollow = [line for line in panel.lines if line.get_markerfacecolor() == "white"]
        assert len(hollow) == 2, "of each line"
        assert all(line.get_xdata() == pytest.approx([3.0, 5.0]) for line in hollow)
        assert panels.END in [text.get_text() for text in panel.get_legend().get_texts()]
    plt.close(figure)


def test_a_sleeper_that_is_raised_has_a_negative_residual_displacement():
    run, every = made()
    every["history/sleeper/displacement"].values[-1, 1] = 0.3e-3
    found = train_figures.numbers(train_figures.Passing(run, every))
    left = "residual downward displacement of sleepers, ground included"
    assert found[f"{left}, smallest (negative: upwards)"] == (pytest.approx(-0.3), "mm")


def test_the_first_axle_is_not_compared_with_itself():
    names = list(train_figures.numbers(train_figures.Passing(*made())))
    assert [name[:6] for name in names if "minus that of axle 1" in name] == ["axle 2"]


def test_wheels_off_the_rail_are_stated():
    run, every = made()
    name = "a wheel off the rail, part of the rows with a wheel over the bed"
    assert name not in train_figures.numbers(train_figures.Passing(run, every))
    x, force = (every[f"history/wheel/{one}"].values for one in ("x", "force"))
    there = (x[:, 0] >= 3) & (x[:, 0] <= 5)
    force[np.flatnonzero(there)[:20], 0] = 0
    value, unit = train_figures.numbers(train_figures.Passing(run, every))[name]
    axles = np.count_nonzero(((x >= 3) & (x <= 5)).any(axis=1))
    assert unit == "%" and value == pytest.approx(100 * 20 / axles)


def test_axles_that_have_not_come_yet_are_left_out(recwarn):
    run, every = made()
    x = every["history/wheel/x"].values
    rows = int(np.flatnonzero(x[:, 1] > 2.5)[0])   # the second axle is near the first sleeper
    every = {name: read.Quantity(one.values[:rows], "-", "-") for name, one in every.items()}
    run.time = run.time[:rows]
    found = train_figures.numbers(train_figures.Passing(run, every))
    assert "axle 1, largest force" in found and "axle 2, largest force" not in found
    assert not [one for one in recwarn if "NaN" in str(one.message)]


def test_run_without_rows_of_a_train_is_refused():
    run, every = made()
    every["history/wheel/x"].values[:] = np.nan
    with pytest.raises(read.Unreadable, match="made: no row of the histories has a train"):
        train_figures.Passing(run, every)


def labels_of_left(passing):
    figure = train_figures.draw(passing, [])
    words = [line.get_label() for line in figure.axes[2].lines]
    plt.close(figure)
    assert words.pop() == panels.END
    return [one for one in words if one != panels.HIDDEN]


def test_axes_name_displacements_and_their_reference():
    figure = train_figures.draw(train_figures.Passing(*made()), [])
    _, down, left = (" ".join(panel.get_ylabel().split()) for panel in figure.axes)
    assert down.startswith("lowest vertical displacement of sleepers, mm")
    assert left.startswith("vertical displacement of sleepers, mm")
    title = "Train over the bed; displacements relative to the "
    assert figure._suptitle.get_text() == title + "last row before the train"
    plt.close(figure)
    run, every = made()
    run.sleepers_x = run.sleepers_x - 2  # the train begins 1 m before the bed
    figure = train_figures.draw(train_figures.Passing(run, every), [])
    assert figure._suptitle.get_text() == title + "first row with the train"
    plt.close(figure)
    assert labels_of_left(train_figures.Passing(*made())) == [
        "lowest under axle 2, less that under axle 1", "after the train"]


def test_nothing_is_residual_while_the_train_is_on_the_bed():
    run, every = made()
    rows = int(np.flatnonzero(every["history/wheel/x"].values[:, 1] > 4.5)[0])
    every = {name: read.Quantity(one.values[:rows], "-", "-") for name, one in every.items()}
    run.time = run.time[:rows]
    passing = train_figures.Passing(run, every)
    assert labels_of_left(passing)[-1] == "in the last row, train not past all sleepers"
    assert passing.state() == "train not past all sleepers in the last row, at 14.5 s"
    found = train_figures.numbers(passing)
    assert not any("residual" in name for name in found)
    last = "downward displacement of sleepers in the last row, train not past all of them"
    assert found[f"{last}, ground included, mean"][1] == "mm"


@pytest.mark.parametrize("trains, reached, words", [
    (["first", "train"], 1, "first (not the last passage, stage train: no train in its rows yet)"),
    (["first", "train"], 2, "train"), (["train"], 1, "")])
def test_the_stage_of_the_train_is_stated(trains, reached, words):
    """While a run computes, the last train of the histories is that of an earlier stage."""
    run, every = made(reached)
    run.deck["stage"] = [{"name": name, "kind": "passage", "train": True} for name in trains]
    run.stage = np.minimum((np.arange(len(run.time)) - 1).clip(0) // 3001, reached - 1)
    run.passage_stage = lambda: (len(trains) - 1, trains[-1])
    passing = train_figures.Passing(run, every)
    stage = train_figures.stage_words(run, passing)
    assert stage == (f"stage {words}" if words else "")
    figure = train_figures.draw(passing, [], stage)
    title = " ".join(figure._suptitle.get_text().split())
    assert title.startswith(f"Train over the bed{f', {stage}' if stage else ''}; displacements")
    plt.close(figure)


def test_on_a_rigid_floor_no_ground_is_included():
    run, every = made()
    run.deck["ground"]["present"] = False
    names = list(train_figures.numbers(train_figures.Passing(run, every)))
    assert "residual downward displacement of sleepers, largest" in names
    assert not any("ground" in name for name in names)


def test_two_rails_are_distinguished():
    run, every = made()
    for name in ("wheel/x", "wheel/force"):
        values = every[f"history/{name}"].values.repeat(2, axis=1)
        every[f"history/{name}"] = read.Quantity(values, "-", "left and right")
    every["history/wheel/force"].values[:, 1] -= 4e3
    seats = np.zeros((len(values), 3, 2))
    seats[5:9, 1] = [1e-3, -2e-3]
    for name in ("displacement", "force"):
        every[f"history/seat/{name}"] = read.Quantity(seats.reshape(-1, 6), "m", "made")
    passing = train_figures.Passing(run, every)
    found = train_figures.numbers(passing)
    assert found["axle 1, left and right wheel, largest difference"][0] == pytest.approx(4)
    assert found["axle 2, left and right wheel, largest difference"][0] == pytest.approx(0)
    assert found["least wheel force over the judged sleepers"][0] == pytest.approx(46)
    down = "largest downward sleeper displacement"
    assert found[f"axle 1, {down}, mean of sleepers"][0] == pytest.approx(1.1)
    assert found["left minus right seat height of a sleeper, largest"][0] == pytest.approx(3)
    figure = train_figures.draw(passing, [])
    labels = [line.get_label() for line in figure.axes[0].lines]
    assert labels == ["axle 1, left", "axle 1, right", "axle 2, left", "axle 2, right"]
    plt.close(figure)


def test_of_several_trains_the_last_counts():
    passing = train_figures.Passing(*made(trains=2))
    assert len(passing.time) == 3001
    assert passing.left == pytest.approx([-2e-4] * 3)


def test_panels():
    stiff = ground_blocks.Stretch("bridge", True, 0.0, 4.0)
    figure = train_figures.draw(train_figures.Passing(*made()), [stiff])
    assert "bridge" in [text.get_text() for text in figure.axes[1].texts]
    assert len(figure.axes) == 3
    plt.close(figure)


def test_runs_without_a_train_are_refused():
    run, every = made()
    with pytest.raises(read.Unreadable) as refused:
        train_figures.Passing(run, {})
    assert refused.value.code == 2
    every["history/wheel/x"] = read.Quantity(np.full((5, 2), np.nan), "m", "none")
    with pytest.raises(read.Unreadable) as refused:
        train_figures.Passing(run, every)
    assert refused.value.code == 2


def test_the_row_before_the_train_is_the_last_one_far_from_the_bed():
    x = np.array([-9.0, -6.0, -4.1, -2.9, 0.5, 4.0])
    assert axles.row_before_train(x, 0.0) == 2
    assert axles.row_before_train(x, -9.0) == 0       # starts on the bed
    assert axles.row_before_train(x, 50.0) == 0       # never comes


def test_documents_state_from_where_levels_count():
    x = np.arange(-5, 1, 0.1)
    first = 0.6  # m, the first sleeper of the bed, which begins at x = 0
    assert x[axles.row_before_train(x, first)] == pytest.approx(first - axles.APART)
    for name in ("postproc", "track"):
        text = " ".join((conftest.ROOT / f"docs/{name}.md").read_text(encoding="utf-8").split())
        assert f"first axle is still {axles.APART:g} m before the first sleeper of the bed" in text


def test_levels_of_a_train_count_from_the_row_before_it():
    """Sleepers and rail move while the train is far: it is no effect of the train."""
    time = np.arange(6.0)
    x = np.array([-9.0, -6.0, -3.5, 0.0, 0.6, 5.0])
    sleeper = np.array([0.0, 3e-4, 5e-4, -1e-3, -2e-3, 1e-4])[:, None] + np.zeros((6, 2))
    every = {f"history/{name}": read.Quantity(values, "m", "") for name, values in (
        ("wheel/x", x[:, None]), ("wheel/force", np.full((6, 1), 5e4)),
        ("rail/displacement", 2 * sleeper), ("sleeper/displacement", sleeper))}
    run = types.SimpleNamespace(name="made", time=time, sleepers_x=np.array([0.0, 0.6]),
                                ground_x=np.empty(0), deck={"sleepers": {"spacing": 0.6}})
    passing = train_figures.Passing(run, every)
    assert passing.first == 2
    assert passing.left == pytest.approx(-4e-4)
    assert passing.lowest[0] == pytest.approx([-2.5e-3, -2.5e-3])
    found = train_figures.numbers(passing)
    assert found["rail above the sleepers, largest downward displacement"][0] == pytest.approx(5.0)
