"""Curves of results beside those of files, and the cases of a sweep."""
import json
import pathlib
import shutil

import conftest
import h5py
import numpy as np
import pytest
from trackbed_post import curves, measured, read, sweep

X = np.array([0.0, 0.6, 1.2, 1.8])
DOWN = np.array([-1e-3, -2e-3, -4e-3, -3e-3])


@pytest.fixture(name="run")
def made_run(tmp_path):
    """An envelope over X and a history of two places over time, with axes as in a results.h5."""
    folder = tmp_path / "run"
    folder.mkdir()
    with h5py.File(folder / "results.h5", "w") as file:
        file.attrs.update({"deck": 'model = "track"\n', "version": "0.1.0", "ranks": 1})
        for name, values, unit in (("envelope/x", X, "m"), ("envelope/rail/least", DOWN, "m"),
                                   ("history/time", X, "s"),
                                   ("history/rail/displacement", np.stack([DOWN, 2 * DOWN], 1),
                                    "m"), ("rail/x", np.array([30.0, 30.6]), "m"),
                                   ("envelope/place", np.arange(4.0), "-"),
                                   ("pairs/x", np.repeat([0.0, 0.6], 2), "m"),
                                   ("pairs/least", DOWN, "m")):
            file[name] = values
            file[name].attrs.update({"units": unit, "long_name": name})
        for axis, name in (("envelope/x", "envelope/rail/least"),
                           ("history/time", "history/rail/displacement")):
            file[axis].make_scale()
            file[name].dims[0].attach_scale(file[axis])
        file["history/rail/x"] = file["rail/x"]
        file["history/rail/x"].make_scale()
        file["history/rail/displacement"].dims[1].attach_scale(file["history/rail/x"])
        # Two rails: positions occur twice, as an array beside the numbers of places.
        for name in ("x", "least"):
            file[f"envelope/two/{name}"] = file[f"pairs/{name}"]
        file["envelope/place"].make_scale()
        file["envelope/two/least"].dims[0].attach_scale(file["envelope/place"])
    return folder


def test_rails_are_curves_of_their_own(run):
    left, right = (curves.of_run(run, "envelope/two/least", place) for place in (0, 1))
    assert (left.name, right.name) == ("run, left", "run, right")
    assert left.x == pytest.approx([0, 0.6]) and left.y == pytest.approx(DOWN[::2])
    assert right.y == pytest.approx(DOWN[1::2])


def test_runs_are_compared_at_one_place(run, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(run, other)
    with h5py.File(other / "results.h5", "r+") as file:
        file["history/rail/displacement"][:, 0] *= 10  # now of the larger range
    first, second = curves.of_runs([run, other], "history/rail/displacement")
    assert first.place == second.place == 1
    assert curves.of_run(other, "history/rail/displacement").place == 0


def csv(folder, text):
    path = folder / "published.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_history_of_the_place_with_the_largest_range(run):
    curve = curves.of_run(run, "history/rail/displacement")
    assert (curve.x_unit, curve.unit, curve.name) == ("s", "m", "run, x = 30.6 m")
    assert curve.y == pytest.approx(2 * DOWN)
    assert curves.of_run(run, "history/rail/displacement", 0).y == pytest.approx(DOWN)
    for quantity, place, words in (("history/rail/none", -1, "it has envelope/rail/least, "),
                                   ("history/rail/displacement", 2, "places 0 to 1")):
        with pytest.raises(read.Unreadable, match=words):
            curves.of_run(run, quantity, place)


def test_columns_are_named_by_their_axis_or_component(tmp_path):
    """As docs/postproc.md lists them; numbers count from 0, as --place does."""
    tensors = np.arange(48.0).reshape(4, 12)
    with h5py.File(tmp_path / "results.h5", "w") as file:
        file.attrs.update({"deck": "", "version": "0", "ranks": 1})
        file["history/time"] = X
        file["history/time"].make_scale()
        for name, axis, values in (("sensor/soil/stress", "stress_component", tensors[:, :6]),
                                   ("region/below/stress", "cell_component", tensors),
                                   ("platen/force", "component", tensors[:, :3]),
                                   ("region/below/porosity", "cell", tensors[:, :2])):
            file[f"history/{name}"] = values
            columns = f"history/{name.rpartition('/')[0]}/{axis}"
            file[columns] = np.arange(values.shape[1])
            file[columns].make_scale()
            file[f"history/{name}"].dims[0].attach_scale(file["history/time"])
            file[f"history/{name}"].dims[1].attach_scale(file[columns])
    for name, place, label in (("sensor/soil/stress", 4, "xz"), ("platen/force", 2, "z"),
                               ("region/below/stress", 0, "cell 0, xx"),
                               ("region/below/stress", 11, "cell 1, yz"),
                               ("region/below/porosity", 1, "cell 1")):
        curve = curves.of_run(tmp_path, f"history/{name}", place)
        assert curve.name.partition(", ")[2] == label


def test_a_curve_leaves_out_stages_without_its_body(tmp_path):
    with h5py.File(tmp_path / "results.h5", "w") as file:
        file.attrs.update({"deck": "", "version": "0", "ranks": 1})
        for name, values in (("history/time", X), ("history/stage", [0, 0, 1, 1]),
                             ("history/platen/z", [0, 0, 0.4, 0.3])):
            file[name] = values
            file[name].attrs.update({"units": "m", "long_name": name})
        file["history/time"].make_scale()
        file["history/platen/z"].dims[0].attach_scale(file["history/time"])
    assert curves.of_run(tmp_path, "history/platen/z").x == pytest.approx(X[2:])


def test_published_curves_are_read_in_si_and_in_order(tmp_path):
    path = csv(tmp_path, "x_m,a_mm,b_kN\n2,1,5\n1,3,6\n")
    curve, = curves.of_file(f"{path}:x_m:a_mm")
    assert curve.x == pytest.approx([1, 2]) and curve.y == pytest.approx([3e-3, 1e-3])
    bad = tmp_path / "bad.csv"
    bad.write_text("x_m,a_mm\n1,nan\n2,3\n", encoding="utf-8")
    latin = tmp_path / "latin.csv"
    latin.write_bytes("x_m,a_\u00b5m\n1,2\n".encode("latin-1"))
    empty = tmp_path / "empty.csv"
    empty.write_text("x_m,a_mm\n", encoding="utf-8")
    for text, words in ((bad, "1 of 2 rows have no number"), (latin, "in UTF-8"),
                        (empty, "no row of numbers"), (path, "choose two"),
                        (f"{path}:x_m:c", "choose two"),
                        (tmp_path / "none.csv", "does not exist")):
        with pytest.raises(read.Unreadable, match=words):
            curves.of_file(text)


def test_deviation_is_that_at_the_other_points():
    line = curves.Curve("line", np.array([0.0, 10.0]), "m", np.array([0.0, 10.0]), "m")
    other = curves.Curve("other", np.array([-1.0, 2.0, 4.0]), "m", np.array([9.0, 2.3, 3.6]), "m")
    rms, most, points = curves.deviation(line, other)
    assert (rms, most, points) == (pytest.approx(np.sqrt((0.09 + 0.16) / 2)), pytest.approx(0.4), 2)
    apart = curves.Curve("apart", np.array([20.0]), "m", np.array([1.0]), "m")
    assert curves.deviation(line, apart) is None


def test_a_curve_of_many_points_is_a_line():
    few, many = (curves.Curve("file", np.arange(float(n)), "s", np.arange(float(n)), "m")
                 for n in (4, 2000))
    lines = curves.draw([few], [few, many], "history/rail/displacement").axes[0].lines
    assert [line.get_linestyle() for line in lines[1:]] == ["None", ":"]


def test_command_states_the_deviation(run, tmp_path):
    path = csv(tmp_path, "x_m,down_mm\n10.6,-2\n11.2,-5\n")
    command = ["curve", "envelope/rail/least", run, "-o", tmp_path / "out", "--over", path]
    ran = conftest.call(*command, "--shift", "-10")
    assert ran.returncode == 0, ran.stderr
    assert "minus published: root mean square 0.0007071 m" in ran.stdout
    assert "largest magnitude 0.001 m (2 of 2 points are in the common range)" in ran.stdout
    rows = (tmp_path / "out/curve.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "curve,x_m,least_m" and len(rows) == 1 + len(X) + 2
    assert (tmp_path / "out/curve.png").stat().st_size > 5000
    ran = conftest.call(*command)
    assert "have no common range" in ran.stdout
    csv(tmp_path, "time_s,down_mm\n1,2\n")
    ran = conftest.call(*command)
    assert ran.returncode == 2 and "has values in m and x in s" in ran.stderr


def test_curves_of_the_command_can_be_given_to_it(run, tmp_path):
    out, again = tmp_path / "out", tmp_path / "again"
    command = ["curve", "history/rail/displacement", run, "-o"]
    assert conftest.call(*command, out).returncode == 0
    assert (out / "curve.csv").read_text(encoding="utf-8").startswith(
        "curve,time_s,displacement_m\nrun; x = 30.6 m,0,")
    ran = conftest.call(*command, again, "--place", "0", "--over", out / "curve.csv")
    assert ran.returncode == 0, ran.stderr
    # Half of that place.
    assert "run, x = 30 m minus curve, run; x = 30.6 m: root mean square 0.002739 m" in ran.stdout
    found = curves.columns_of(again / "curve.csv")
    assert [one.name for one in found] == ["curve, run; x = 30 m", "curve, curve; run; x = 30.6 m"]
    assert found[1].y == pytest.approx(2 * DOWN) and found[1].unit == "m"


@pytest.mark.parametrize("unit", ["m", "1", "kg/m3", "N m", "rad/s"])
def test_a_column_has_its_unit(unit):
    assert measured.unit_of(measured.column_of("torque", unit)) == (1.0, unit)


def test_mean_and_deviation_over_the_seeds(tmp_path):
    done = sweep.cases({"bed.seed": ["1", "2"], "speed": ["5", "6"]}, tmp_path)
    numbers = [{"force (kN)": value, "steps": 7.0} for value in (1.0, 10.0, 3.0, 30.0)]
    text = sweep.table_text(done, numbers)
    assert [line.split() for line in text.splitlines() if "force" in line] == [
        ["force", "(kN)", "2", "+-", "1.41"], ["force", "(kN)", "20", "+-", "14.1"]]
    assert "steps" not in text  # the same in all runs
    rows = sweep.table_csv(done, numbers).splitlines()
    assert rows[0] == '"bed.seed","speed","force (kN)","steps"' and rows[2] == '"1","6",10,7'


def test_numbers_of_the_summary_have_words_and_units(run):
    (run / "summary.json").write_text(json.dumps({
        "energy": {"track_j": 2.0}, "coupling": {"work": 1e-9}, "windows": 5}), encoding="utf-8")
    with h5py.File(run / "results.h5", "r+") as file:
        file.attrs["deck"] = ""
    assert sweep.numbers_of(run) == {
        "energy at the end of the run, track (J)": 2.0,
        "relative error of the work between the models (1)": 1e-9}


def test_a_short_bed_below_a_train_has_no_numbers_of_a_transition(run, monkeypatch):
    def refuse(_):
        raise read.Unreadable("4 sleepers")

    monkeypatch.setattr(sweep, "of_deck", lambda _: ["transition"])
    monkeypatch.setattr(sweep.transition, "numbers", refuse)
    assert sweep.numbers_of(run) == {}


def test_help_explains_the_options():
    ran = [" ".join(conftest.call(name, "--help").stdout.split()) for name in
           ("sweep", "figures", "compare", "map")]
    for word in ("MPI ranks of each run", "the program; default", "column of --quantity",
                 "input file that is run"):
        assert word in ran[0]
    assert "all figures of a run" in ran[1] and "bed_below_train: those of bed without" in ran[1]
    assert "the first beside each other one" in ran[2] and "all figures of" not in ran[2]
    assert "nearest to S, which must be before" in ran[3]


def test_band_of_a_sweep(tmp_path, monkeypatch):
    done = sweep.cases({"bed.seed": ["1", "2"]}, tmp_path)
    found = [curves.Curve(f"{k}, x = 3 m", X, "s", (k + 1) * DOWN, "m") for k in range(2)]
    monkeypatch.setattr(curves, "of_runs", lambda *_: found)
    panel = sweep.draw(done, "history/rail/displacement", -1).axes[0]
    assert panel.lines[0].get_ydata() == pytest.approx(1.5e3 * DOWN)  # mm
    band = panel.collections[0].get_paths()[0].vertices[:, 1]
    assert (band.min(), band.max()) == (pytest.approx(-8), pytest.approx(-1))
    assert panel.get_title().startswith("x = 3 m; ")


def test_run_ins_are_shaded_below_envelopes_of_a_sweep(tmp_path, monkeypatch):
    done = sweep.cases({"bed.seed": ["1", "2"]}, tmp_path)
    deck = {"model": "track", "track": {"length": 4.0, "run_in": 1.0}}
    monkeypatch.setattr(sweep.read, "origin", lambda folder: ("", deck))
    for axis, quantity, count in (("m", "envelope/rail/displacement_min", 2),
                                  ("s", "history/rail/displacement", 0)):
        monkeypatch.setattr(curves, "of_runs", lambda *_, unit=axis: [
            curves.Curve("made", X, unit, DOWN, "m")] * 2)
        panel = sweep.draw(done, quantity, -1).axes[0]
        assert len(panel.patches) == count
        words = [text.get_text() for text in panel.get_legend().get_texts()]
        assert words.count("run-in, not counted") == count // 2


def test_cases_of_a_sweep(tmp_path):
    found = sweep.cases({"bed.seed": ["1", "2"], "pad.stiffness": ["1e8"], "x.a": ["[1, 2]"]},
                        tmp_path)
    assert [case.folder.name for case in found] == ["seed_1_stiffness_1e8_a_1_2",
                                                    "seed_2_stiffness_1e8_a_1_2"]
    assert sweep.steps_of(found[0], "a.toml")[0].changes() == ["bed.seed=1", "pad.stiffness=1e8",
                                                               "x.a=[1, 2]"]
    assert len(sweep.grouped(found)) == 1
    with pytest.raises(read.Unreadable, match="same folder"):
        sweep.cases({"a.x": ["1 2", "1_2"]}, tmp_path)


@pytest.mark.parametrize("words, expected", [
    (["--vary", "a.b", "1", "--vary", "a.b", "2"], "given twice for the same parameter"),
    (["--vary", "a.b", "-1e-3", "--ranks", "0"], "must be at least 1"),
    (["--vary", "a.b", "-1e-3", "--program", "/tmp"], "is not a program")])
def test_sweeps_that_cannot_run_are_refused(tmp_path, words, expected):
    deck = tmp_path / "a.toml"
    deck.write_text("title = 'a'\n", encoding="utf-8")
    ran = conftest.call("sweep", deck, *words, "-o", tmp_path / "out")
    assert ran.returncode == 2 and expected in ran.stderr, ran.stderr


def test_folder_of_another_sweep_is_refused(tmp_path):
    deck = pathlib.Path(tmp_path / "a.toml")
    deck.write_text("title = 'a'\n", encoding="utf-8")
    step, = sweep.steps_of(sweep.cases({"bed.seed": ["1"]}, tmp_path / "out")[0], deck)
    sweep.require_same_deck(step)
    (step.folder / "summary.json").write_text(json.dumps({"finished": True}), encoding="utf-8")
    sweep.require_same_deck(step)
    deck.write_text("title = 'b'\n", encoding="utf-8")
    with pytest.raises(read.Unreadable, match="another deck"):
        sweep.require_same_deck(step)
