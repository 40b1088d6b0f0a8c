"""Tests of what the decks of several runs differ by."""
import copy

import pytest
from trackbed_post import deck_differences

DECK = {"title": "a", "time": {"substeps": 2}, "sieve": [25, 35.5],
        "contact": [{"first": "ballast", "second": "ballast", "friction": 0.7},
                    {"first": "ballast", "second": "sleeper", "friction": 0.7}],
        "ground": {"block": [{"name": "wedge", "present": True, "young": 5e8}]},
        "stage": [{"name": "load", "cycles": 3}, {"name": "train"}]}


@pytest.mark.parametrize("change, expected", [
    (lambda deck: deck.update(title="b"), []),
    (lambda deck: deck["time"].update(substeps=3), [["time.substeps", "2", "3"]]),
    (lambda deck: deck.update(sieve=[25, 40.0]), [["sieve", "[25, 35.5]", "[25, 40]"]]),
    (lambda deck: deck["contact"][1].update(friction=0.5),
     [["contact.ballast-sleeper.friction", "0.7", "0.5"]]),
    (lambda deck: deck["ground"]["block"][0].update(present=False),
     [["ground.block.wedge.present", "true", "false"]]),
    (lambda deck: deck["ground"]["block"].clear(),
     [["ground.block.wedge", "present = true, young = 500000000", "-"]]),
    (lambda deck: deck["ground"].clear(),
     [["ground.block.wedge", "present = true, young = 500000000", "-"]]),
    (lambda deck: deck.pop("time"), [["time", "substeps = 2", "-"]]),
    (lambda deck: deck["stage"].insert(1, {"name": "jump"}), [["stage.jump", "-", ""]]),
    (lambda deck: deck["stage"][0].pop("cycles"), [["stage.load.cycles", "3", "-"]])])
def test_a_row_for_each_key_that_differs(change, expected):
    other = copy.deepcopy(DECK)
    change(other)
    assert deck_differences.rows([DECK, other]) == expected
    assert deck_differences.rows([DECK, DECK]) == []


def test_sections_without_use_count_as_absent():
    """Default values of what nobody computes; two decks without a train do not differ by one."""
    with_train = {"train": {"speed": 60}, "load": {"peak": 1}, "jump": {"cycles": 2},
                  "handover": {"after": "bed_in", "rounds": 3}, "footing": {"count": 1},
                  "stage": [{"name": "pass", "kind": "passage", "train": True}]}
    without = {"train": {"speed": 50}, "load": {"peak": 2}, "jump": {"cycles": 3},
               "handover": {"after": "", "rounds": 4}, "footing": {"count": 2},
               "stage": [{"name": "pass", "kind": "passage", "train": False}]}
    assert deck_differences.rows([with_train, without]) == [
        ["train", "speed = 60", "-"], ["handover", "after = bed_in, rounds = 3", "-"],
        ["stage.pass.train", "true", "false"], ["load", "-", "peak = 2"]]
    assert deck_differences.rows([without, without | {"train": {"speed": 70}}]) == []
    track = {"model": "track", "train": {"speed": 50}}
    assert deck_differences.rows([track, track | {"train": {"speed": 70}}]) == [
        ["train.speed", "50", "70"]]


def test_another_order_has_a_row():
    first = {"ground": {"block": [{"name": "wedge", "young": 1}, {"name": "slab"}]},
             "stage": [{"name": "load"}, {"name": "train"}]}
    second = copy.deepcopy(first)
    second["ground"]["block"].reverse()
    assert deck_differences.rows([first, second]) == [
        ["ground.block (order)", "[wedge, slab]", "[slab, wedge]"]]
    second["ground"]["block"][1]["young"] = 2
    second["ground"]["block"].insert(0, {"name": "new"})
    second["stage"].insert(0, {"name": "rest"})  # those of both are in the same order
    assert deck_differences.rows([first, second]) == [
        ["ground.block (order)", "[wedge, slab]", "[new, slab, wedge]"],
        ["ground.block.wedge.young", "1", "2"], ["ground.block.new", "-", ""],
        ["stage.rest", "-", ""]]


def test_long_values_are_cut_around_their_first_difference():
    lists = [[0.5 * k for k in range(100)] for _ in range(3)]
    lists[1][70], lists[2] = 7.25, lists[0][:3]
    row, = deck_differences.rows([{"times": values} for values in lists[:2]])
    assert "35, 35.5" in row[1] and "34.5, 7.25, 35.5" in row[2]
    for cell in row[1:]:
        assert cell.startswith("...") and cell.endswith("...")
        assert len(cell) == deck_differences.LONGEST + 6
    lists[1] = lists[0][:71]
    _, longer, shorter = deck_differences.rows([{"times": values} for values in lists[:2]])[0]
    assert longer != shorter and shorter.endswith("35]")
    row, = deck_differences.rows([{"times": values} for values in lists])
    assert row[3] == "[0, 0.5, 1]" and row[1].startswith("[0, 0.5, 1, ")


def test_equal_names_are_numbered_and_long_values_are_cut():
    first = {"sensor": [{"name": "a", "at": 1}, {"name": "a", "at": 2}], "x": "long " * 40}
    second = {"sensor": [{"name": "a", "at": 1}, {"name": "a", "at": 3}], "x": "short"}
    found = dict((row[0], row[1:]) for row in deck_differences.rows([first, second, second]))
    assert found["sensor.a (2).at"] == ["2", "3", "3"]
    assert found["x"][0].endswith("...") and len(found["x"][0]) == deck_differences.LONGEST + 3


def test_paths_of_another_copy_of_the_project_are_no_difference(tmp_path):
    """Files by their contents; states of runs, and files that are gone, by the end of the path."""
    for name, text in (("a", "x_m,z_m"), ("b", "x_m,z_m"), ("c", "x_m,z_mm")):
        for file, words in (("profile.csv", text), ("stage_rest.h5", name)):
            path = tmp_path / name / "project/results" / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(words, encoding="utf-8")

    def deck(name, file="profile.csv", folder="results"):
        return {"irregularity": {"file": str(tmp_path / name / "project" / folder / file)}}
    for other in (deck("b"), deck("gone")):
        assert deck_differences.rows([deck("a"), other]) == []
    assert deck_differences.rows([deck("a", "stage_rest.h5"), deck("b", "stage_rest.h5")]) == []
    profile = "/results/profile.csv"
    assert deck_differences.rows([deck("a"), deck("c"), deck("gone", folder="old")]) == [
        ["irregularity.file", f".../project{profile}",
         f".../project{profile} (other contents)", ".../project/old/profile.csv"]]
    row, = deck_differences.rows([{"start": ""}, {"start": str(tmp_path / "a/stage_rest.h5")}])
    assert row == ["start", "", f".../{tmp_path.name}/a/stage_rest.h5"]
    assert deck_differences.end_of_path("/cell") == "cell"
