"""Tests of the warnings of settlement: their limit is not the deck's aim, their remedies act."""
import copy
import dataclasses
import types

import numpy as np
import pytest
import test_zones
from trackbed_post import (bed_on_ground, bed_warnings, measures, read, transition, write,
                           zones)

INNER = range(3, 12)  # sleepers that are not at the ends of the bed


def settled(run, by, aim=0.2e-3, reached=None, sleepers=INNER, load=100e3):
    """The run with a rail of test_zones.py, whose sleepers settle in the passage by so much, m; the
    stage of load before it has this aim, m, and a passage follows it."""
    run = test_zones.with_rail(run)
    deck = copy.deepcopy(run.deck)
    stage = deck["stage"][3]
    stage.update(kind="load", load=load, settlement=aim, cycles=20, duration=2.0)
    deck["stage"].insert(4, {"name": "first_train", "kind": "passage", "train": True})
    height = np.zeros((len(run.time), len(run.sleepers_x)))
    height[-1, list(sleepers)] = -by
    reaction = np.full(height.shape, 5e3)
    reaction[-60:] = 30e3
    return dataclasses.replace(
        run, deck=deck, stage=np.where(run.stage == 4, 5, run.stage), ground={},
        aim_reached={} if reached is None else {"load": reached}, lasted={"load": 1.4}, sleeper={
            **run.sleeper, "displacement": read.Quantity(height, "m", "-"),
            "reaction": read.Quantity(reaction, "N", "-")})


def of_settling(run, **more):
    return [one for one in bed_warnings.of(run, **more) if "settle into the bed" in one]


@pytest.mark.parametrize("by, warned", [(0.098e-3, 0), (0.102e-3, 1)])
@pytest.mark.parametrize("aim", [1e-6, 0.2e-3, 5e-3, 0.0])
def test_the_limit_does_not_follow_the_aim_of_the_deck(runs, by, aim, warned):
    run = settled(runs[1], by, aim)
    assert len(of_settling(run)) == warned
    causes = [one.cause for one in bed_warnings.warnings_of(run)]
    assert ("the bed is not bedded in" in causes) == bool(warned)


@pytest.mark.parametrize("aim, reached, words, absent", [
    (0.2e-3, True, "a larger load, or a smaller settlement than 0.2 mm, with which it ended early",
     "more cycles"),
    (0.2e-3, False, "a larger load, or more cycles and a longer duration", "smaller"),
    (0.0, None, "a larger load, or more cycles and a longer duration", "smaller"),
    (0.2e-3, None, "a smaller settlement than 0.2 mm, if it ended with this, or more cycles",
     "larger load")])
def test_remedies_act_and_name_the_stage_of_load(runs, aim, reached, words, absent):
    one, = of_settling(settled(runs[1], 0.3e-3, aim, reached))
    assert f"give stage load {words}" in one and absent not in one
    assert "first_train" not in one and "the stage before" not in one
    assert one.partition("; ")[2].count(", or ") == 1, "at most two remedies"


def test_an_aim_reached_in_the_last_cycle_has_not_ended_the_stage_early(runs):
    run = settled(runs[1], 0.3e-3, 0.2e-3, True)
    for lasted, words in (({"load": 2.00002}, "which it reached in its last cycle, with more "
                           "cycles and a longer duration"), ({}, "0.2 mm, which it reached")):
        one, = of_settling(dataclasses.replace(run, lasted=lasted))
        assert one.endswith(words) and "early" not in one


def test_a_single_ramp_is_given_cycles(runs):
    run = settled(runs[1], 0.3e-3, 0.0)
    run.deck["stage"][3]["cycles"] = 0
    one, = of_settling(run)
    assert one.endswith("give stage load a larger load, or cycles instead of a single ramp")


@pytest.mark.parametrize("carried, warned", [(29e3, True), (31e3, False)])
def test_axle_loads_before_the_train_bed_the_stones_in(runs, carried, warned):
    """Stage 4 is a passage of [load]; the stones carry 30 kN under the train."""
    run = settled(runs[1], 0.3e-3, load=10e3)
    run.deck["stage"][4].update(train=False)
    reaction = run.sleeper["reaction"].values.copy()
    stage = run.stage.copy()
    stage[-70:-60] = 4
    reaction[-70:-60] = carried
    run = dataclasses.replace(run, stage=stage, sleeper={
        **run.sleeper, "reaction": read.Quantity(reaction, "N", "-")})
    found = [one for one in bed_warnings.of(run) if "settlement is that of a first loading" in one]
    assert len(found) == warned
    assert not warned or "more than the 29 kN with which stage first_train bedded it in" in found[0]
    assert "give the axles of stage first_train a larger load ([load]), or the stage more" in \
        of_settling(run)[0]


@pytest.mark.parametrize("speeds, standing, stops", [
    ([20, 0], True, True), ([20, 0], False, False), ([20, 10], True, False)])
def test_a_train_that_stops_on_the_bed_need_not_be_awaited(runs, speeds, standing, stops):
    run = settled(runs[1], 0.3e-3, load=10e3)
    run.deck["train"] = {"speed": 20.0, "speeds": speeds, "times": [1, 2]}
    x = np.minimum(20 * (run.time - run.time[run.passage()][0]), 5.0) if standing else \
        5.0 * run.time / run.time[-1]
    run = dataclasses.replace(run, wheel={"x": read.Quantity(x[:, None], "m", "-")})
    assert not measures.train_has_left(run)
    first, *more = bed_warnings.warnings_of(run)
    assert first.cause == ("the train stops on the bed" if stops else
                           "the train has not left the bed")
    assert ("wait for the end" in first.sentence) == (not stops)
    assert [one.cause for one in more] == stops * [
        "the bed was bedded in with less than the load of the passage"]
    with pytest.raises(read.Unreadable, match="let it run on" if stops else "resume the run"):
        transition.require_whole(run, types.SimpleNamespace(time=run.time[run.passage()]))


def test_a_run_without_a_stage_of_load_is_told_to_add_one(runs):
    run = settled(runs[1], 0.3e-3)
    run.deck["stage"][3]["kind"] = "run"
    assert "add a stage of kind load with cycles before the passage" in of_settling(run)[0]


def test_the_warning_counts_sleepers_in_each_part(runs, tmp_path):
    """2.1 to 3.3 m are on the structure, 3.9 to 5.7 m in the transition, 6.3 and 6.9 m beyond."""
    run = settled(runs[1], 0.3e-3, sleepers=(4, 6, 7, 8, 11))
    one, = of_settling(run)
    assert one.startswith("5 of 9 sleepers settle into the bed by more than 0.1 mm in the passage, "
                          "most by 0.3 mm at x = 2.70 m: 1 of 3 on the structure, 3 of 4 in the "
                          "transition, 1 of 2 on plain track: the bed is not bedded in; ")
    longer, = of_settling(run, changing=0.1)  # of the parts of a comparison
    assert "3 of 3 in the transition, 1 of 3 on plain track" in longer
    made = write.Folder(tmp_path)
    bed_on_ground.draw_all([run], made)
    assert one in made.tables[0]
    bed_on_ground.plt.close("all")
    run.deck["ground"]["block"][0]["outline"] = [2.5, 0.0, 4.0, 0.0, 4.0, -2.0, 2.5, -2.0]
    before, = of_settling(run)  # 2.1 m is before the structure now
    assert "0 of 2 on the structure" not in before and "0 of 1 elsewhere: the bed" in before
    bare = dataclasses.replace(run, deck={**run.deck, "ground": {}})
    assert "on the structure" not in of_settling(bare)[0]
    assert zones.changing([run]) > 0.1


@pytest.mark.parametrize("by, raised", [(0.9e-3, False), (1.1e-3, True)])
def test_sleepers_that_a_passage_raises_are_warned_of(runs, by, raised):
    run = settled(runs[1], -by, sleepers=(5, 6))
    found = [one for one in bed_warnings.warnings_of(run) if "raised" in one.cause]
    assert len(found) == raised
    assert not raised or found[0].sentence.startswith(
        "2 of 9 sleepers are raised by more than 1 mm relative to the ground in the passage, most "
        "by 1.1 mm at x = 3.30 m: ")
    ends = settled(runs[1], -by, sleepers=(0, 14))
    assert not any("raised" in one.cause for one in bed_warnings.warnings_of(ends))


def test_each_reason_is_stated_once_with_its_runs():
    hang = [bed_warnings.BedWarning("sleepers hang", "", f"{count} of 31") for count in (3, 5)]
    loose = bed_warnings.BedWarning("the bed is not bedded in", "")
    assert bed_warnings.causes([("with slab", [loose]), ("without slab", [loose])]) == \
        "the bed is not bedded in (runs with slab and without slab)"
    assert bed_warnings.causes([("a", [hang[0], loose]), ("b", [hang[1]])]) == \
        "3 of 31 sleepers hang (run a), 5 of 31 (run b); the bed is not bedded in (run a)"
    assert bed_warnings.causes([("a", [hang[0]]), ("b", [hang[0]])]) == \
        "3 of 31 sleepers hang (runs a and b)"
    assert bed_warnings.causes([("a", []), ("b", [])]) == ""


def test_each_sentence_is_stated_once_with_its_runs():
    assert bed_warnings.once([("a", ["one", "two", "one"]), ("b", ["two"])]) == [
        "a: one", "a and b: two"]


def test_the_end_of_a_stage_is_read_from_the_summary(tmp_path):
    import made
    folder = made.write(tmp_path / "run")
    assert read.results(folder).aim_reached == {}
    (folder / "summary.json").write_text(
        '{"warnings": ["a"], "stages": [{"name": "fill"}, {"name": "load", "aim_reached": true, '
        '"duration_s": 1.4}]}')
    run = read.results(folder)
    assert run.aim_reached == {"load": True} and run.warnings == ("a",)
    assert run.lasted == {"load": 1.4}


def test_hanging_sleepers_have_the_same_remedies(runs):
    run = settled(runs[1], 0.0, reached=True)
    way = np.zeros((len(run.time), len(run.sleepers_x)))
    way[-300:-100] = 2e-3 * np.sin(np.linspace(0, np.pi, 200))[:, None]
    reaction = 2e3 + 30e6 * way
    reaction[:, 5] = 40e6 * np.maximum(way[:, 5] - 0.5e-3, 0)
    one, = bed_warnings.of(dataclasses.replace(run, sleeper={
        **run.sleeper, "displacement": read.Quantity(-way, "m", "-"),
        "reaction": read.Quantity(reaction, "N", "-")}))
    assert "1 of 15 sleepers hang" in one and "give stage load a larger load, or" in one
