"""Tests of the figures of a track on a ground: kinds, parts that count, unfinished passages."""
import math

import conftest
import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest
import track_on_ground
from trackbed_post import (passage_warnings, stress_paths, track_along, track_figures,
                           track_stretch, train_strip, write)


@pytest.mark.parametrize("kind", ["transition", "train", "bed"])
@pytest.mark.parametrize("points", [(8.0, 12.0), tuple(range(5, 22))])
def test_kinds_of_a_bed_are_refused_in_one_sentence(tmp_path, kind, points):
    """Sleepers with histories are those nearest to the points, and no bed."""
    run = track_on_ground.folder(tmp_path / "w", points=points)
    ran = conftest.call("figures", run, "--kind", kind, "-o", tmp_path / "out")
    assert ran.returncode == 2
    assert ran.stderr.strip() == (
        f"w: figures of kind {kind} need a bed of stones; this run (model = \"track_on_ground\") "
        "has figures of kind track")
    assert not (tmp_path / "out").exists()


def test_two_tracks_have_no_film_of_a_transition(tmp_path):
    runs = [track_on_ground.folder(tmp_path / name) for name in "wn"]
    ran = conftest.call("film", *runs, "-o", tmp_path / "film.gif")
    assert ran.returncode == 2 and "need a bed of stones" in ran.stderr


SHORT = 81  # rows; the first axle is at 8 m then


def tension(folder):
    return [one for one in passage_warnings.of_folder(folder) if "tension" in one]


def test_seats_over_which_no_axle_has_run_do_not_count(tmp_path):
    """They have 1 kN of tension beside 20 N of load."""
    assert not tension(track_on_ground.folder(tmp_path / "whole"))
    assert not tension(track_on_ground.folder(tmp_path / "short", SHORT))
    assert not tension(track_on_ground.folder(tmp_path / "before", 41)), "in the run-in only"
    one, = tension(track_on_ground.folder(tmp_path / "pulled", SHORT, at_12=-3e3, at_30=-9e3))
    assert "at 1 of 11 seats (those at the ends of the ground are left out), most at x = 6.00 m " \
        "by 3.0 kN, 15.0% of the load of a seat below a wheel, 20.0 kN" in one


@pytest.mark.parametrize("sleeper, at_end", [(17, False), (19, True), (20, True), (21, True),
                                             (22, False), (38, True), (40, True), (42, False)])
def test_tension_at_an_end_of_the_ground_is_one_of_the_model(tmp_path, sleeper, at_end):
    """Sleepers 20 to 39 are on the ground."""
    found = tension(track_on_ground.folder(tmp_path / "w", **{f"at_{sleeper}": -4e3}))
    assert len(found) == (0 if at_end else 1)
    assert all("sleepers without support" in one for one in found)


def table(folder, out):
    """(name -> number, the whole table, sentences of a report)."""
    made = write.Folder(out)
    track_figures.draw_into([folder], made)
    plt.close("all")
    return track_figures.opened(folder)[2], made.tables[0], made.sentences


def test_forces_are_those_over_the_ground_without_its_ends(tmp_path):
    found, text, sentences = table(track_on_ground.folder(tmp_path / "w"), tmp_path / "out")
    assert found["largest wheel force over the ground"] == (pytest.approx(55), "kN")
    assert found["x of the largest wheel force over the ground"] == (pytest.approx(15), "m")
    assert found["largest wheel force between the run-ins"] == (pytest.approx(60.5), "kN")
    assert "under the first wheel over the ground, D1 (3 to 25 m)" in text
    assert "x = 0 of the ground is at 9.75 m" in text
    assert "over the ground: from x = 11 to 18.5 m, without 2 sleepers at each end" in text
    assert sentences == [
        "w: largest wheel force over the ground: 55 kN, at x = 15.00 m; beside it a larger one "
        "between the run-ins: 60.5 kN, near x = 22.00 m from the start of the track."]


def test_a_train_that_has_not_passed_is_warned_of_and_has_no_values_ahead(tmp_path):
    whole = track_on_ground.folder(tmp_path / "whole")
    assert not any("has not passed" in one for one in passage_warnings.of_folder(whole))
    found, text, sentences = table(track_on_ground.folder(tmp_path / "short", SHORT + 50),
                                   tmp_path / "out")
    assert "rail at 8 m, largest downward displacement" in found
    assert found["rail at 12 m, largest downward displacement"][0] == pytest.approx(
        1.01 * (1 + math.exp(-4)), 1e-6)
    assert not any("18 m" in name for name in found)
    assert "warning: short: the train has not passed x = 12, 18 and 18.5 m" in text
    assert "first axle is at x = 13.00 m and its last one at 11.00 m" in text
    assert sentences[0].endswith(" (train not past x = 18.5 m, last axle at 11.00 m).")
    early, text, sentences = table(track_on_ground.folder(tmp_path / "early", SHORT - 10),
                                   tmp_path / "early_out")
    assert not sentences and not any(name.startswith(("rail", "sleeper", "seat")) or
                                     "over the ground" in name for name in early)
    many = track_on_ground.folder(tmp_path / "many", SHORT - 10, points=tuple(range(8, 20)))
    assert "not passed 13 places from x = 8 to 19 m" in passage_warnings.of_folder(many)[0]


def test_an_unfinished_passage_is_in_the_titles_and_the_report(tmp_path):
    folder = track_on_ground.folder(tmp_path / "short", SHORT)
    run, deck, _ = track_figures.opened(folder)
    words = "train not past x = 18.5 m, last axle at 6.00 m"
    for figure in (track_figures.draw(run, 30.0, deck), track_along.draw_envelope(run, deck),
                   track_along.draw_beside("ab", [run, run], [deck, deck])):
        assert words in " ".join(figure._suptitle.get_text().split())
    plt.close("all")
    assert not track_stretch.warnings_of({}, deck), "no wheels"
    page = tmp_path / "report.html"
    assert conftest.call("report", folder, "-o", page).returncode == 0
    assert "the train has not passed x = 8, 12, 18 and 18.5 m" in page.read_text(encoding="utf-8")


def test_figures_show_the_ground_its_blocks_and_both_origins(tmp_path):
    run, deck, _ = track_figures.opened(track_on_ground.folder(tmp_path / "w"))
    figures = [track_figures.draw(run, 30.0, deck), track_along.draw_envelope(run, deck),
               track_along.draw_beside("ab", [run, run], [deck, deck])]
    for figure, label in zip(figures, ("x of the wheel", "x", "x")):
        panel = figure.axes[0]
        assert {text.get_text() for text in panel.texts} == {"abutment", "wedge"}
        assert [line.get_xdata()[0] for line in panel.lines if line.get_linestyle() == "--"
                and len(line.get_xdata()) == 2] == [9.75, 19.75]
        assert f"{label} from the start of the track (of the ground: less 9.75 m), m" in [
            one.get_xlabel() for one in figure.axes]
        spans = sorted(one.get_extents().transformed(panel.transData.inverted()).intervalx.tolist()
                       for one in panel.patches)
        assert [[round(x, 6) for x in one] for one in spans] == [
            [0, 3], [9.75, 11.75], [11.75, 14.75], [27, 30]]
    titles = [" ".join(figure._suptitle.get_text().split()) for figure in figures]
    assert titles[1].endswith("; over the ground without its ends rail lowered by up to 2 mm, "
                              "seat load up to 20 kN")
    assert "rail lowered by up to 2 mm (a) and 2 mm (b)" in titles[2]
    plt.close("all")


def test_sensors_in_the_ground_are_below_the_train(monkeypatch, tmp_path):
    """At x = 3.25 m of the ground, 13 m from the start of the track, over which the second axle is
    one tenth of a second after the first one. The ground has no weight; a stress that turns."""
    sensor = '[[sensor]]\nname = "soil"\nkind = "ground"\nat = [3.25, 0.0, -1.0]\n'
    folder = track_on_ground.folder(tmp_path / "w", deck=track_on_ground.DECK + sensor)
    with h5py.File(folder / "results.h5", "r+") as file:
        turn = np.pi * file["history/time"][()].ravel() / file["history/time"][-1].item()
        none = np.zeros_like(turn)
        for name, columns in {
                "displacement": [none] * 3, "velocity": [none] * 3, "acceleration": [none] * 3,
                "stress": [-5e3 - 2e3 * np.cos(turn), none - 5e3, -5e3 + 2e3 * np.cos(turn), none,
                           -2e3 * np.sin(turn), none], "stress_static": [none] * 6}.items():
            one = file.create_dataset(f"history/sensor/soil/{name}", data=np.stack(columns, 1))
            one.attrs["units"], one.attrs["long_name"] = "-", "made for a test"
    marked = []
    monkeypatch.setattr(train_strip, "mark", lambda panel, train, place: marked.append(
        (place.words, train_strip.times_at(train, place.x).ravel())))
    figures = dict(track_figures.sensors_in_ground(folder, track_figures.deck_of(folder)))
    words, times = marked[0]
    assert words == "soil, x = 13 m" and times == pytest.approx([13 / 20, 15 / 20])
    label = "w: soil (ground, change only)"
    angle, = [one.get_ydata() for one in figures["stress_paths"].axes[1].lines
              if one.get_label() == label]
    assert angle[2:-1] == pytest.approx(np.degrees(np.pi - turn[2:-1]) / 2)  # 90 is also -90
    out = write.Folder(tmp_path / "out")
    track_figures.draw_into([folder], out)
    assert {"sensors", "stress_paths"} <= {path.stem for path in out.pictures}
    with h5py.File(folder / "results.h5", "r+") as file:
        del file["history/sensor/soil/stress_static"]  # as of earlier results
    assert list(dict(track_figures.sensors_in_ground(folder, track_figures.deck_of(folder)))) == [
        "sensors"]
    plt.close("all")


def test_direction_of_a_faint_stress_is_not_shown():
    stress = np.zeros((4, 6))
    stress[:, 2] = -10e3, -1.1e3, -0.9e3, 0
    assert np.isfinite(stress_paths.direction(stress)).tolist() == [True, True, False, False]


def test_blocks_of_one_run_only_are_named_as_its_own(tmp_path):
    bare = track_on_ground.DECK.replace(track_on_ground.BLOCKS, "")
    runs = [track_figures.opened(track_on_ground.folder(tmp_path / name, deck=deck))
            for name, deck in (("w", track_on_ground.DECK), ("n", bare))]
    figure = track_along.draw_beside("wn", *([run[k] for run in runs] for k in (0, 1)))
    assert {text.get_text() for text in figure.axes[0].texts} == {"abutment (w)", "wedge (w)"}
    plt.close(figure)


def test_another_model_has_no_ground():
    deck = {"model": "track", "track": {"length": 20.0, "run_in": 2.0}}
    assert track_stretch.ground_of(deck) is None and track_stretch.notes(deck, []) == []
    assert track_stretch.counted(deck) == track_stretch.Stretch(2.0, 18.0, " between the run-ins")
    assert track_stretch.blocks_of(deck) == []
