"""Some runs of a study are repeated, the others keep their numbers."""
import pathlib
import sys
import types

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "jobs"))
import launch  # noqa: E402
import study  # noqa: E402
from studies.study import Numbers, Run  # noqa: E402


def stored(folder):
    """Numbers and lines of two runs, in the files of a study."""
    numbers = Numbers({"version": "trackbed 1, commit a", "machine": "m", "command": "c"})
    for run, value in (("track_1", 1), ("bed_1", 2)):
        numbers.put(run, "sunk", value, "mm")
        numbers.lines.put("sinking", run, [0], [value])
    (folder / "numbers.csv").write_text(numbers.text(), encoding="utf-8")
    (folder / "lines.csv").write_text(numbers.lines.text(), encoding="utf-8")


def chain():
    """Runs of which the last starts from the second, and this from the first."""
    return [Run("cell", "a.toml", ()), Run("bed_1", "b.toml", ("bed.cell='{folder}/cell'",)),
            Run("other", "b.toml", ()),
            Run("track_1", "c.toml", ("start='{folder}/bed_1/stage_fill.h5'",))]


def test_some_runs_of_a_study_are_repeated_and_the_others_keep_their_numbers(tmp_path):
    stored(tmp_path)
    key = study.Key(__file__, chain(), tmp_path)
    chosen = study.Selection(["track_", "oth"], tmp_path)
    chosen.check(types.SimpleNamespace(measure_runs=None), "full", chain())
    runs = chosen.runs(chain(), key.before)
    assert [run.name for run in runs] == ["cell", "bed_1", "other", "track_1"]
    kept, lines = chosen.begin({"version": "trackbed 1, commit b"}, runs[2:])
    assert list(kept.rows) == [("bed_1", "sunk")]
    assert list(lines.rows) == [("sinking", "bed_1")]
    assert study.versions(kept.about) == (
        "trackbed 1, commit a; runs `track_*`, `oth*`: trackbed 1, commit b")


def test_runs_that_a_repeated_one_needs_are_measured_and_named(tmp_path):
    stored(tmp_path)
    chosen = study.Selection(["track_"], tmp_path)
    chosen.check(types.SimpleNamespace(measure_runs=None), "full", chain())
    runs = chosen.runs(chain(), study.Key(__file__, chain(), tmp_path).before)
    kept, _ = chosen.begin({"version": "trackbed 1, commit b"}, runs)
    assert not kept.rows
    assert study.versions(kept.about).endswith(
        "runs `track_*`, `cell`, `bed_1`: trackbed 1, commit b")


@pytest.mark.parametrize("prefixes, form, place, words", [
    (["trakc_"], "full", ".", 'no run has a name that begins with "trakc_"'),
    (["track_"], "short", ".", "are for the full form"),
    (["track_"], "full", "none", "No such file")])
def test_what_cannot_be_repeated_is_refused_before_it_runs(tmp_path, capsys, prefixes, form, place,
                                                           words):
    stored(tmp_path)
    with pytest.raises(SystemExit) as ended:
        study.Selection(prefixes, tmp_path / place).check(
            types.SimpleNamespace(measure_runs=None), form, chain())
    assert ended.value.code == launch.BAD_INPUT and words in capsys.readouterr().err
