"""Sweeps over chains of decks, with a program that only notes what it is asked for."""
import json
import pathlib
import shutil

import conftest
import pytest
from test_report import made as track_alone
from trackbed_post import read, sweep

# Finishes each run with the results of TEMPLATE unless its words contain `fails`.
PROGRAM = """#!/bin/sh
echo "$*" >> {folder}/asked.txt
[ $1 = check ] && case "$*" in
  *misspelt*) echo "misspelt is not a parameter" >&2; echo "no cell" >&2; exit 2;;
  *bed.cell=*) echo "no cell" >&2; exit 2;;
esac
[ $1 = check ] && exit 0
case "$*" in *fails*) exit 4;; esac
for last; do :; done
cp {folder}/template/results.h5 {folder}/template/summary.json $last
"""


@pytest.fixture(name="place")
def folder_with_decks(tmp_path):
    track_alone(tmp_path / "template")
    program = tmp_path / "trackbed"
    program.write_text(PROGRAM.format(folder=tmp_path), encoding="utf-8")
    program.chmod(0o755)
    for name in ("cell", "base", "deck"):
        (tmp_path / f"{name}.toml").write_text(f"title = '{name}'\n", encoding="utf-8")
    return tmp_path


def call(place, *words):
    return conftest.call("sweep", place / "deck.toml", *words, "--program", place / "trackbed",
                         "-o", place / "out")


def runs(place):
    """Words of the runs that the program was asked for, without its folder."""
    lines = (place / "asked.txt").read_text(encoding="utf-8").replace(f"{place}/", "")
    (place / "asked.txt").unlink()
    return [line.split() for line in lines.splitlines() if line.startswith("run ")]


def test_each_variant_has_its_chain_and_equal_runs_before_are_shared(place):
    words = ("--before", place / "cell.toml", "bed.cell", "--before", place / "base.toml",
             "start=bed_in", "--vary", "cell:bed.seed", "1", "2", "--vary", "speed", "30", "40")
    ran = call(place, *words, "--quantity", "envelope/rail/displacement_min")
    assert ran.returncode == 0, ran.stderr
    asked = runs(place)
    assert [(one[1], one[2:-3]) for one in asked[:4]] == [
        ("cell.toml", ["bed.seed=1"]),
        ("base.toml", ["bed.cell='out/before/cell_seed_1'"]),
        ("deck.toml", ["speed=30", "start='out/before/base_seed_1/stage_bed_in.h5'"]),
        ("deck.toml", ["speed=40", "start='out/before/base_seed_1/stage_bed_in.h5'"])]
    assert [one[-1] for one in asked] == [
        "out/before/cell_seed_1", "out/before/base_seed_1", "out/seed_1_speed_30",
        "out/seed_1_speed_40", "out/before/cell_seed_2", "out/before/base_seed_2",
        "out/seed_2_speed_30", "out/seed_2_speed_40"]
    assert "speed = 30: 2 runs" in (place / "out/sweep.txt").read_text(encoding="utf-8")
    assert (place / "out/sweep.png").is_file()
    assert (place / "out/sweep.csv").read_text().startswith('"cell:bed.seed","speed",')
    assert call(place, *words).returncode == 0 and not (place / "asked.txt").exists()


def test_a_run_before_is_not_repeated_for_a_finished_variant(place):
    words = ("--before", place / "cell.toml", "bed.cell", "--vary", "speed", "30")
    assert call(place, *words).returncode == 0 and len(runs(place)) == 2
    for path in (place / "out/before/cell").iterdir():
        path.unlink()
    (place / "out/before/cell").rmdir()
    assert call(place, *words).returncode == 0 and not (place / "asked.txt").exists()


def test_a_run_before_that_fails_is_tried_once(place):
    words = ("--before", place / "cell.toml", "bed.cell", "--vary", "cell:fails", "1",
             "--vary", "speed", "30", "40")
    ran = call(place, *words)
    assert ran.returncode == 2 and "not all runs have finished" in ran.stderr
    assert [one[1].rpartition("/")[2] for one in runs(place)] == ["cell.toml"]


def test_a_stopped_chain_ends_the_sweep_and_is_continued(place):
    program = place / "trackbed"
    text = program.read_text(encoding="utf-8")
    program.write_text(text.replace("exit 4", "exit 3").replace("*fails*", "*deck.toml*"))
    words = ("--before", place / "cell.toml", "bed.cell", "--vary", "speed", "30")
    assert call(place, *words).returncode == 3 and len(runs(place)) == 2
    program.write_text(text)
    (place / "out/speed_30/latest").write_text("checkpoint_1.h5\n")
    ran = call(place, *words)
    asked = (place / "asked.txt").read_text(encoding="utf-8").split()
    assert ran.returncode == 0 and asked[0] == "resume"
    assert pathlib.Path(asked[1]).name == "speed_30"


def test_a_wrong_parameter_is_found_before_anything_runs(place):
    words = ("--before", place / "cell.toml", "bed.cell")
    ran = call(place, *words, "--vary", "misspelt", "1")
    assert ran.returncode == 2 and not runs(place)
    assert ran.stderr.strip().endswith("misspelt is not a parameter")  # not the missing cell
    assert call(place, *words, "--vary", "speed", "1").returncode == 0


@pytest.mark.parametrize("words, expected", [
    (("--vary", "cell:bed.seed", "1"), "no deck cell comes before"),
    (("--before", "none.toml", "start", "--vary", "a", "1"), "none.toml does not exist"),
    (("--before", "cell.toml", "=bed_in", "--vary", "a", "1"), "give PARAMETER or"),
    (("--before", "cell.toml", "start", "--before", "cell.toml", "start", "--vary", "a", "1"),
     "two decks before have the same name")])
def test_chains_that_cannot_be_are_refused(place, monkeypatch, words, expected):
    monkeypatch.chdir(place)
    ran = call(place, *words)
    assert ran.returncode == 2 and expected in ran.stderr


def test_folder_of_another_chain_is_refused(place):
    words = ("--before", place / "cell.toml", "bed.cell", "--vary", "speed", "30")
    assert call(place, *words).returncode == 0
    (place / "cell.toml").write_text("title = 'other'\n", encoding="utf-8")
    ran = call(place, *words)
    assert ran.returncode == 2 and "before/cell holds a run of another deck" in ran.stderr
    with pytest.raises(read.Unreadable):
        sweep.require_owners({"base:x": ["1"]}, [sweep.Link(place / "cell.toml", "start")])


CELL, BASE = ("--before", "cell.toml", "bed.cell"), ("--before", "base.toml", "start=bed_in")
OTHER_STAGE = ("--before", "base.toml", "start=other")


@pytest.mark.parametrize("first, second", [
    ((), BASE), (BASE, ()), (BASE, (*CELL, *BASE)), ((*CELL, *BASE), BASE), (BASE, OTHER_STAGE),
    (CELL, ("--before", "cell.toml", "start"))])
def test_a_finished_run_after_other_runs_before_is_no_result(place, monkeypatch, first, second):
    monkeypatch.chdir(place)
    words = ("--vary", "speed", "30")
    assert call(place, *first, *words).returncode == 0
    ran = call(place, *second, *words)
    assert ran.returncode == 2 and "after other runs before it" in ran.stderr
    assert call(place, *first, *words).returncode == 0


def test_a_changed_deck_before_is_found_when_its_run_was_deleted(place, monkeypatch):
    monkeypatch.chdir(place)
    words = (*CELL, "--vary", "speed", "30")
    assert call(place, *words).returncode == 0
    shutil.rmtree(place / "out/before")
    assert call(place, *words).returncode == 0
    (place / "cell.toml").write_text("title = 'other'\n", encoding="utf-8")
    ran = call(place, *words)
    assert ran.returncode == 2 and "out/speed_30 holds a run of another deck" in ran.stderr


def test_results_of_a_deck_alone_that_have_no_list_of_runs_before_are_kept(place):
    assert call(place, "--vary", "speed", "30").returncode == 0
    stored = place / "out/speed_30/sweep.json"
    older = json.loads(stored.read_text(encoding="utf-8"))
    assert older.pop("before") == []
    stored.write_text(json.dumps(older), encoding="utf-8")
    assert call(place, "--vary", "speed", "30").returncode == 0 and len(runs(place)) == 1


@pytest.mark.parametrize("words, expected", [
    ((), "the figure sweep is drawn with --quantity only"),
    (("--quantity", "envelope/rail/displacement_min", "--measured", "curve=track.csv"),
     "the only figure of a sweep is sweep")])
def test_curves_over_a_figure_that_will_not_be_drawn_are_refused(place, monkeypatch, words,
                                                                 expected):
    monkeypatch.chdir(place)
    (place / "track.csv").write_text("x_m,z_mm\n4.2,-0.9\n4.8,1.5\n", encoding="utf-8")
    ran = call(place, "--vary", "speed", "30", "--measured", "sweep=track.csv", *words)
    assert ran.returncode == 2 and expected in ran.stderr
    assert not (place / "asked.txt").exists()
