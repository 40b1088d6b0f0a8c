"""Figures of runs that compute, or have ended before their last passage: what is stated is what
their progress.jsonl and their histories hold."""
import dataclasses
import fcntl
import json
import time

import matplotlib.pyplot as plt
import numpy as np
import pytest
from trackbed_post import bed_on_ground, measures, progress, sleeper_histories, write

AT_LOAD = {"stage": "load", "stage_number": 4, "stages": 5, "window": 50, "windows_at_most": 200}
AT_PASSAGE = {**AT_LOAD, "stage": "passage", "stage_number": 5, "window": 142}


def before_its_passage(run, folder, *events):
    """The run with histories of the stages up to load, and these events."""
    folder.mkdir(exist_ok=True)
    (folder / ".lock").touch()
    if events:
        (folder / progress.FILE).write_text("".join(
            json.dumps({"unix_time_s": time.time(), "time_s": 0.1, **one}) + "\n"
            for one in events), encoding="utf-8")
    return dataclasses.replace(run, stage=np.full_like(run.stage, 3), sleeper_envelope={},
                               ground_envelope={}, folder=folder)


@pytest.mark.parametrize("at, words", [
    (AT_LOAD, "has not come to it (stage load, 4 of 5 (25 % of its windows))"),
    (AT_PASSAGE, "it (stage passage, 5 of 5 (71 % of its windows)), and its histories are written "
     "later")])
def test_a_run_that_computes_has_not_been_stopped(runs, tmp_path, at, words):
    run = before_its_passage(runs[0], tmp_path, {"event": "progress", **at})
    with open(tmp_path / ".lock") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        why = measures.why_no_envelope(run)
    assert why.startswith("wedge contains no passage: the run is computing") and why.endswith(words)


def test_warnings_of_a_run_are_those_of_its_last_command(runs, tmp_path):
    first, again = ({"event": "warning", "message": words} for words in ("soft", "softer"))
    begin = {"event": "begin"}
    before_its_passage(runs[0], tmp_path, begin, first, begin, first, {"event": "end"}, again)
    assert progress.warnings_of(tmp_path) == ["soft", "softer"]
    assert progress.warnings_of(tmp_path / "none") == []


@pytest.mark.parametrize("events, words", [
    ([], "was stopped before it"),
    ([{"event": "progress", **AT_LOAD}], "was killed before it"),
    ([{"event": "end", "outcome": "failed", **AT_LOAD}], "failed before it"),
    ([{"event": "end", "outcome": "stopped", **AT_LOAD}], "was stopped before it"),
    ([{"event": "progress", **AT_PASSAGE}], "was killed in it, before its histories were written")])
def test_a_run_that_has_ended_before_its_passage(runs, tmp_path, events, words):
    run = before_its_passage(runs[0], tmp_path, *events)
    assert measures.why_no_envelope(run) == f"wedge contains no passage: the run {words}"


def test_an_earlier_stage_is_not_drawn_beside_the_passage_of_another_run(runs, tmp_path):
    run = before_its_passage(runs[0], tmp_path / "run")
    made = write.Folder(tmp_path)
    bed_on_ground.draw_all([run, runs[1]], made)
    assert not bed_on_ground.OF_PASSAGE & {path.stem for path in made.pictures}
    why = "wedge contains no passage: the run was stopped before it"
    assert f"spectrum.png is skipped: {why}" in made.remarks
    made = write.Folder(tmp_path)
    bed_on_ground.draw_all([run], made)
    assert bed_on_ground.OF_PASSAGE <= {path.stem for path in made.pictures}
    assert "passing frequencies, wedge, last stage (load)" in made.tables[0]


def test_of_several_passages_the_shown_one_is_named(runs):
    stages = [dict(stage) for stage in runs[0].deck["stage"]]
    stages[3]["kind"], stages[3]["name"] = "passage", "first_train"
    run = dataclasses.replace(runs[0], deck={**runs[0].deck, "stage": stages})
    early = dataclasses.replace(run, stage=np.full_like(run.stage, 3))
    for one, words in ((run, "passage (stage passage)"), (early, "last stage (first_train)")):
        title = sleeper_histories.draw([one]).axes[0].get_title()
        assert title.startswith(f"Sleepers during the {words}; lowest")
        title = " ".join(bed_on_ground.spectra([one]).axes[0].get_title().split())
        assert title.startswith(f"Spectra of sleepers in the {words}, root mean square")
    plt.close("all")
