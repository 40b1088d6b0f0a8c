"""Tests of the transition of a track on a ground of elements: places, numbers and verdict."""
import json

import conftest
import made
import matplotlib.pyplot as plt
import numpy as np
import pytest
from trackbed_post import track_transition, transition, write

LENGTH, SPACING, SPEED = 60.0, 0.5, 20.0
ORIGIN, EDGE = 9.75, 10.0  # m: x = 0 of the ground on the track, and of the structure's end on it
WEDGE, ABRUPT = 5.0, 2.0   # m, over which the level of the rail changes with and without wedge
DECK = """
title = "A bridge and its embankment"
model = "track_on_ground"
dimension = "plane"
thickness = 2.0
[track]
length = 60.0
run_in = 3.0
spacing = 0.5
[footing]
before = 20
count = 80
first = 0.25
[ground]
x = [0.0, 40.0]
[[ground.layer]]
thickness = 2.0
young = 20e6
[[ground.block]]
name = "abutment"
outline = [0.0, 0.0, 10.0, 0.0, 10.0, -2.0, 0.0, -2.0]
young = 30e9
[[ground.block]]
name = "wedge"
outline = [10.0, 0.0, 15.0, 0.0, 10.0, -2.0]
young = 200e6
present = true
[train]
vehicles = ["coach", "coach"]
speed = 20.0
[passage]
step = 5e-4
"""


MIRRORED = DECK  # the structure is at the larger x
for old, new in (("[0.0, 0.0, 10.0, 0.0, 10.0, -2.0, 0.0, -2.0]",
                  "[30.0, 0.0, 40.0, 0.0, 40.0, -2.0, 30.0, -2.0]"),
                 ("[10.0, 0.0, 15.0, 0.0, 10.0, -2.0]", "[25.0, 0.0, 30.0, 0.0, 30.0, -2.0]")):
    MIRRORED = MIRRORED.replace(old, new)


def folder(path, wedge=True, rails=1, last=1200, pulls=0.0, uneven=0.0, turned=False):
    """Rows of one axle of 50 kN, 0.05 m apart, with 60 kN half a metre behind the structure if
    there is no wedge; the rail goes down by 0.4 mm on the structure and 1 mm on plain track, the
    sleepers by half of it. Of two rails the left one goes down 0.1 mm more, the right one less.
    `uneven`: m, of each second sleeper on plain track; `turned`: the structure is at the larger x.
    """
    path.mkdir()
    x = 0.05 * np.arange(last + 1)
    force = np.full((len(x), rails), 50e3)
    if not wedge:
        force[np.isclose(x, ORIGIN + EDGE + 0.5)] = 60e3
    places = np.repeat(SPACING * np.arange(int(LENGTH / SPACING) + 1), rails)
    long = WEDGE if wedge else ABRUPT
    behind = ORIGIN + 30.0 - places if turned else places - ORIGIN - EDGE
    down = 0.4e-3 + 0.6e-3 * np.clip(behind / long, 0, 1)
    down += uneven * (behind > 8) * (np.arange(len(behind)) // rails % 2)
    if rails == 2:
        down += np.where(np.arange(len(down)) % 2, -1e-4, 1e-4)
    load, deck = np.full(len(places), 20e3), MIRRORED if turned else DECK
    made.store(path / "results.h5", {
        "history/time": (x / SPEED, "s"), "history/wheel/x": (np.stack([x] * rails, 1), "m"),
        "history/wheel/force": (force, "N"), "history/wheel/height": (0 * force - 1e-3, "m"),
        "envelope/x": (places, "m"),
        "envelope/rail/displacement_min": (-down, "m"),
        "envelope/rail/displacement_max": (0 * down, "m"),
        "envelope/sleeper/displacement_min": (-0.5 * down, "m"),
        "envelope/sleeper/displacement_max": (0 * down, "m"),
        "envelope/sleeper/seat_force_min": (-pulls * load, "N"),
        "envelope/sleeper/seat_force_max": (load, "N")},
        deck=deck if wedge else deck.replace("present = true", "present = false"),
        version="0.1.0", build="-", ranks=1)
    (path / "summary.json").write_text(json.dumps({
        "deck": "a.toml", "model": "track_on_ground", "finished": True, "ranks": 1,
        "simulated_time_s": float(x[-1] / SPEED), "wall_time_s": 1.0, "memory_mb_per_rank": 1.0}),
        encoding="utf-8")
    return path


@pytest.mark.parametrize("rails", [1, 2])
def test_numbers_are_those_of_the_lines(tmp_path, rails):
    tracks = [track_transition.of_folder(folder(tmp_path / name, name == "with", rails))
              for name in ("with", "without")]
    now, other = transition.changes_of(tracks)
    for one, long, last in ((now, WEDGE, 0.6e-3), (other, ABRUPT, 0.6e-3)):
        assert (one.structure, one.plain) == pytest.approx((0.4e-3, 1e-3))
        assert one.steepest == pytest.approx(last / long) and one.scatter == pytest.approx(0)
        assert one.sleeper_steepest == pytest.approx(last / long / 2)
    # Linear between sleepers at 0.25 m and so on behind the edge: the kink at 2 m is cut.
    assert (now.width, other.width) == pytest.approx((4.5, 1.85))
    assert now.force == 50e3 and (other.force, other.force_behind) == pytest.approx((60e3, 0.5))
    assert other.force_plain == 50e3
    # The structure ends at 10 m; plain track ends 3 sleepers before 36 m, two depths of the ground
    # before its end, and begins two spacings behind the wedge.
    assert (now.plain_begin, now.plain_end) == pytest.approx((16.25, 34.25))
    x = tracks[0].run.sleepers_x
    assert (x[0], x[-1]) == pytest.approx((1.75, 35.75))
    assert tracks[1].mean_force() == pytest.approx(50e3 + rails * 10e3 / rails / 681, rel=1e-5)
    place, most = tracks[1].largest_force()
    assert place[np.argmax(most)] == pytest.approx(10.5) and np.sum(most > 50e3) == 1


def test_the_structure_may_be_at_the_larger_x(tmp_path):
    track = track_transition.of_folder(folder(tmp_path / "run", turned=True))
    change, = transition.changes_of([track])
    assert (change.structure, change.plain) == pytest.approx((0.4e-3, 1e-3))
    assert change.width == pytest.approx(4.5)
    assert (change.plain_begin, change.plain_end) == pytest.approx((5.75, 23.75))


def test_a_wedge_at_the_other_end_of_the_structure_is_not_judged(tmp_path, monkeypatch):
    """Of a structure inside the ground the end at the larger x is judged."""
    deck = DECK.replace("[0.0, 0.0, 10.0, 0.0, 10.0, -2.0, 0.0, -2.0]",
                        "[6.0, 0.0, 10.0, 0.0, 10.0, -2.0, 6.0, -2.0]")
    monkeypatch.setattr("test_track_transition.DECK", deck.replace(
        "[10.0, 0.0, 15.0, 0.0, 10.0, -2.0]", "[4.0, 0.0, 6.0, 0.0, 6.0, -2.0]"))
    runs = [folder(tmp_path / name, name == "with") for name in ("with", "without")]
    out = write.Folder(tmp_path / "out")
    track_transition.draw_into(runs, out)
    assert out.sentences == ["No verdict: the wedge is at the other end of the structure, which is "
                             "judged at x = 10.00 m."]
    plt.close("all")


def test_a_measure_on_the_structure_is_judged(tmp_path, monkeypatch):
    """As a mat on a bridge, which ends where the structure does."""
    monkeypatch.setattr("test_track_transition.DECK", DECK.replace(
        "[10.0, 0.0, 15.0, 0.0, 10.0, -2.0]", "[8.0, 0.0, 10.0, 0.0, 10.0, -0.5]"))
    runs = [folder(tmp_path / name, name == "with") for name in ("with", "without")]
    out = write.Folder(tmp_path / "out")
    track_transition.draw_into(runs, out)
    assert out.sentences[0].startswith("With the wedge the rail reaches")
    plt.close("all")


def test_points_and_sensors_may_differ(tmp_path, monkeypatch):
    first = folder(tmp_path / "with")
    monkeypatch.setattr("test_track_transition.DECK", DECK.replace(
        "step = 5e-4", "step = 5e-4\npoints = [20.0]") + (
            '[[sensor]]\nname = "soil"\nkind = "ground"\nat = [12.0, 0.0, -1.0]\n'
            '[[region]]\nname = "all"\n'))
    out = write.Folder(tmp_path / "out")
    track_transition.draw_into([first, folder(tmp_path / "without", False)], out)
    assert out.sentences[0].startswith("With the wedge the rail reaches")
    monkeypatch.setattr("test_track_transition.DECK", DECK.replace("step = 5e-4", "step = 1e-3"))
    out = write.Folder(tmp_path / "out")
    track_transition.draw_into([first, folder(tmp_path / "coarse", False)], out)
    assert out.sentences[0].startswith("No verdict: the decks differ in passage.step")
    plt.close("all")


def test_a_difference_within_the_variation_on_plain_track_is_not_clear(tmp_path):
    runs = [folder(tmp_path / name, name == "with", uneven=2e-4) for name in ("with", "without")]
    out = write.Folder(tmp_path / "out")
    track_transition.draw_into(runs, out)
    assert "the steepest part is in neither run larger than the variation on plain track: no " \
        "verdict from it" in out.sentences[0]
    assert "scatter" not in (tmp_path / "out/transition.txt").read_text(encoding="utf-8")
    plt.close("all")


def test_two_designs_have_a_verdict_without_words_of_stones(tmp_path):
    runs = [folder(tmp_path / name, name == "with") for name in ("with", "without")]
    ran = conftest.call("compare", *runs, "-o", tmp_path / "out")
    assert ran.returncode == 0, ran.stderr
    text = (tmp_path / "out/transition.txt").read_text(encoding="utf-8")
    sentence = " ".join(text.split())
    assert ("With the wedge the rail reaches 90% of its change from structure to plain track 4.5 m "
            "behind the structure instead of 1.9 m, and the steepest part of the change is 60% "
            "less steep: as expected of a wedge.") in sentence
    assert "instead of 60.0 kN, 0.5 m behind the structure" in sentence
    for word in (" bed", "stone", "packing", "settle", "scatter"):
        assert word not in text, word
    assert {path.name for path in (tmp_path / "out").glob("*_wedge.csv")} == {
        f"{what}_{design}_wedge.csv" for what in ("levels", "wheel_force")
        for design in ("with", "without")}
    assert (tmp_path / "out/levels_with_wedge.csv").read_text(encoding="utf-8").startswith(
        "x_m,rail_down_mm,sleeper_down_mm\n1.75,0.4,0.2\n")
    rows = (tmp_path / "out/wheel_force_without_wedge.csv").read_text(encoding="utf-8").split()
    assert rows[0] == "x_m,largest_wheel_force_kN" and "10.5,60" in rows and "2,50" in rows


def test_one_run_asks_for_a_second_one(tmp_path):
    out = write.Folder(tmp_path / "out")
    track_transition.draw_into([folder(tmp_path / "with")], out)
    number, where = out.sentences[0].split("mm/m, ")  # it is as steep along the whole wedge
    assert number == ("The change of the rail's lowest level from structure to plain track extends "
                      "over 4.5 m; its steepest part is 0.12 ")
    assert where.endswith(" the structure.")
    text = (tmp_path / "out/transition.txt").read_text(encoding="utf-8")
    assert text.endswith("\n\nNo verdict: give a second run, without the wedge.\n")
    assert (tmp_path / "out/transition.png").exists()
    plt.close("all")


@pytest.mark.parametrize("what, words", [
    ({"last": 965}, "the train has not passed the whole ground"),
    ({"pulls": 0.2}, "rail pads are in tension")])
def test_unsound_runs_have_no_verdict(tmp_path, what, words):
    """Row 965 is at 48.25 m, behind the last sleeper whose level is used, at 45.5 m."""
    runs = [folder(tmp_path / name, name == "with", **what) for name in ("with", "without")]
    out = write.Folder(tmp_path / "out")
    track_transition.draw_into(runs, out)
    assert out.sentences[0].startswith(f"No verdict, since {words} (runs with wedge and "
                                       "without wedge): this can change")
    text = (tmp_path / "out/transition.txt").read_text(encoding="utf-8")
    assert out.sentences[0].endswith(" The remedies are in the warnings.")
    assert text.count("\nWarning: ") == 1 and words.removesuffix(" the whole ground") in \
        " ".join(text.partition("\nWarning: ")[2].split())
    plt.close("all")


def test_levels_under_an_axle_that_has_not_come_are_not_shown(tmp_path):
    out = write.Folder(tmp_path / "out")
    runs = [folder(tmp_path / name, last=last) for name, last in (("done", 1200), ("goes_on", 900))]
    track_transition.draw_into(runs, out)
    assert not out.sentences and not out.pictures
    remark, = out.remarks
    assert remark.startswith("goes_on: no transition is judged: the train has not yet run over it")


@pytest.mark.parametrize("old, new", [
    ("young = 30e9", "young = 1e9"), ('model = "track_on_ground"', 'model = "track"')])
def test_a_ground_without_structure_has_no_transition(tmp_path, monkeypatch, old, new):
    monkeypatch.setattr("test_track_transition.DECK", DECK.replace(old, new))
    assert track_transition.of_folder(folder(tmp_path / "run")) is None
