"""postproc on results made of known functions: the known values are recovered."""
import dataclasses
import resource
import subprocess
import sys

import conftest
import h5py
import made
import numpy as np
import pytest
from trackbed_post import (bed_on_ground, frequencies, ground_blocks, measures, read, signals,
                           sleeper_histories)
from trackbed_post.ground_transition import table, transition

LOW_PASS_RIPPLE = 1e-3    # allowed loss of a 10 Hz sine below 100 Hz: (10/100)^8 is far less
LOW_PASS_LEAK = 1e-3      # allowed remainder of 300 Hz: 1/(1 + 3^8) = 1.5e-4, without ends
LINE = 0.05               # Hz between the lines of a spectrum, its default
SCALLOP = 0.05            # relative, height of a peak of a 2 s record: lobe of the negative
                          # frequency 3.4 % at 2 Hz, lines 0.05 Hz apart 1.6 %


def test_read_gives_arrays_units_and_deck(runs):
    run = runs[0]
    assert run.name == "wedge" and run.ranks == 2 and run.version == "0.0.0"
    assert run.sleeper["displacement"].unit == "m"
    assert run.sleeper["displacement"].values.shape == (len(run.time), len(run.sleepers_x))
    assert run.deck["load"]["speed"] == made.SPEED
    assert run.chains["load"].segments.shape == (2, 4)
    assert run.stones["load"].centre.shape == (2, 2)
    deck = {"stage": [{"name": name} for name in ("fill", "compact", "load")]}
    assert read.in_order(["compact", "fill", "load", "new"], deck) == ["fill", "compact", "load",
                                                                        "new"]
    # Stage 4 of the deck is the passage: 2 s that begin at 0.1 s. Without one it is the last stage.
    for deck in (run.deck, {}, {"stage": 3 * [{"kind": "fill"}] + 2 * [{"kind": "passage"}]}):
        rows = dataclasses.replace(run, deck=deck).passage()
        assert run.time[rows][0] == pytest.approx(0.1) and len(run.time[rows]) == 2000
    first = [{"kind": "fill"}] * 3 + [{"kind": "passage"}]
    assert len(run.time[dataclasses.replace(run, deck={"stage": first}).passage()]) == 100


def test_read_reports_what_is_missing(tmp_path):
    with pytest.raises(read.Unreadable, match="results.h5 does not exist"):
        read.results(tmp_path)


def foreign_files(folder):
    """Files and folders given by mistake, and a part of the message on each."""
    (folder / "empty").mkdir()
    (folder / "text.h5").write_text("time displacement\n0 0\n")
    with h5py.File(folder / "foreign.h5", "w") as file:
        file["velocity"] = np.arange(3.0)
    with h5py.File(folder / "checkpoint.h5", "w") as file:
        file.attrs["kind"] = "trackbed checkpoint"
    whole = made.write(folder / "cut") / "results.h5"
    whole.write_bytes(whole.read_bytes()[:2000])
    no_rows = made.write(folder / "no_rows") / "results.h5"
    with h5py.File(no_rows, "r+") as file:
        del file["history"]
    return {"empty": "does not exist", "nowhere": "does not exist",
            "text.h5": "is not an HDF5 file", "cut": "damaged",
            "foreign.h5": "is not a results.h5 of trackbed",
            "checkpoint.h5": "but a trackbed checkpoint", "no_rows": "contains no row"}


def test_commands_refuse_foreign_files_with_one_message(tmp_path):
    for name, words in foreign_files(tmp_path).items():
        for command in ("figures", "list"):
            if command == "list" and name in ("foreign.h5", "checkpoint.h5", "no_rows"):
                continue  # it lists any HDF5 file
            output = ["-o", tmp_path / "figures"] if command == "figures" else []
            ran = conftest.call(command, tmp_path / name, *output)
            assert ran.returncode == 2, (command, name, ran.stderr)
            assert len(ran.stderr.splitlines()) == 1 and words in ran.stderr, (name, ran.stderr)
    assert not list((tmp_path / "figures").glob("*"))


def drawn(folder, place, **how):
    return subprocess.run([sys.executable, conftest.ROOT / "postproc", "figures", folder,
                           "-o", place], capture_output=True, text=True, check=False, **how)


def test_figures_that_cannot_be_written_end_with_one_message(tmp_path):
    run, text = made.write(tmp_path / "run"), tmp_path / "text"
    text.write_text("kept")
    for place, words in ((text, "is a file"), ("/proc/figures", "cannot be created")):
        ran = drawn(run, place)
        assert ran.returncode == 2 and words in ran.stderr, ran.stderr
        assert len(ran.stderr.splitlines()) == 1, ran.stderr
    # A limited file size simulates a full disk.
    ran = drawn(run, tmp_path / "full",
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)))
    assert ran.returncode == 4, ran.stderr
    assert ran.stderr.splitlines()[-1].endswith("cannot be written (File too large)")
    assert "Traceback" not in ran.stderr and not list((tmp_path / "full").iterdir())
    # An older file is kept.
    words = "import resource; from trackbed_post import write; " \
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)); " \
        f"write.whole({str(text)!r}, 2000 * b'x')"
    ran = subprocess.run([sys.executable, "-c", words], cwd=conftest.ROOT / "postproc",
                         capture_output=True, text=True, check=False)
    assert ran.stderr.endswith(f"{text} cannot be written (File too large)\n")
    assert text.read_text() == "kept" and not list(tmp_path.glob("*.part"))


def test_run_stopped_before_its_passage_is_reported(tmp_path):
    folder = made.write(tmp_path / "stopped")
    with h5py.File(folder / "results.h5", "r+") as file:
        file["history/stage"][...] = 3  # the stage load, before the passage
        del file["envelope"]
    ran = drawn(folder, tmp_path / "figures")
    assert ran.returncode == 0, ran.stderr
    reason = "stopped contains no passage: the run was stopped before it"
    for name in ("overview", "envelope", "stress"):
        assert f"{name}.png is skipped: {reason}\n" in ran.stdout, ran.stdout
    assert f"no transition to measure: {reason}" in ran.stdout
    assert "residual displacement" not in ran.stdout and "have a gap" not in ran.stdout
    assert "Sleepers during the last stage (load)" in sleeper_histories.draw(
        [read.results(folder)]).axes[0].get_title()
    bed_on_ground.plt.close("all")


def test_model_without_ground_or_structure_is_reported(runs, tmp_path):
    bare = read.results(made.write(tmp_path / "bare", ground=False))
    assert "no transition to measure: bare has no ground" in table([bare])
    plain = dataclasses.replace(runs[0], deck={**runs[0].deck, "ground": {}})
    assert ("wedge: the ground needs a structure, a block of at least 10 GPa, from the surface "
            "over at least half of the depth of the ground" in table([plain]))
    idle = dataclasses.replace(runs[0], deck={"stage": [{"name": "load", "kind": "load"}]})
    assert "contains no passage: the deck has no stage of kind passage" in table([idle])


def test_read_checkpoint_through_latest(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["dem/mass"] = np.arange(3.0)
        file["dem/mass"].attrs["units"] = "kg"
    (tmp_path / "latest").write_text("a.h5\n")
    mass = read.checkpoint(tmp_path)["dem/mass"]
    assert mass.unit == "kg" and np.array_equal(mass.values, [0, 1, 2])
    (tmp_path / "a.h5").rename(tmp_path / "stage_load.h5")
    assert np.array_equal(read.checkpoint(tmp_path, "load")["dem/mass"].values, [0, 1, 2])
    for stage in ("", "fill"):
        with pytest.raises(read.Unreadable, match="does not exist"):
            read.checkpoint(tmp_path, stage)


def test_field_files_are_listed_by_their_window(tmp_path):
    assert read.fields(tmp_path, "load", "ground") == {}
    (tmp_path / "fields").mkdir()
    names = ("load_1000000_ground", "load_000900_ground", "load_000900_stones",
             "load_2_000007_ground", "fill_000001_ground")
    for name in names:
        (tmp_path / f"fields/{name}.hdf").touch()
    assert [(window, file.stem) for window, file in read.fields(tmp_path, "load", "ground").items()
            ] == [(900, names[1]), (1000000, names[0])]
    assert list(read.fields(tmp_path, "load_2", "ground")) == [7]


def test_low_pass_keeps_10_hz_and_removes_300_hz():
    time = np.arange(0, 2, 1e-3)
    low, high = np.sin(2 * np.pi * 10 * time), np.sin(2 * np.pi * 300 * time)
    inner = slice(200, -200)
    low_pass = signals.LowPass()
    assert np.max(np.abs(low_pass(time, low) - low)[inner]) < LOW_PASS_RIPPLE
    assert np.max(np.abs(low_pass(time, high))[inner]) < LOW_PASS_LEAK
    # At the cut-off two passes leave exactly one half.
    cut = low_pass(time, np.sin(2 * np.pi * 100 * time))
    assert np.sqrt(2 * np.mean(cut[inner]**2)) == pytest.approx(0.5, rel=1e-3)


def test_low_pass_reports_when_it_does_not_apply():
    coarse, uneven = np.arange(0, 2, 0.01), np.cumsum(np.r_[np.full(50, 1e-3), np.full(50, 2e-3)])
    short = coarse[:24] / 10
    for time, why in ((coarse, "rows are 10 ms apart, but must be less than 5 ms apart"),
                      (uneven, "rows unevenly spaced"), (short, "24 rows, 25 needed")):
        assert signals.LowPass().name_for(time) == f"not filtered: {why}"
        assert np.array_equal(signals.LowPass()(time, time), time)
    assert "Butterworth" in signals.LowPass().name_for(np.arange(0, 2, 1e-3))


@pytest.mark.parametrize("frequency", [2.0, 6.67, 13.33])
def test_spectrum_peaks_where_the_sine_is(frequency):
    time = np.arange(0, 2, 1e-3)
    hertz, amplitude = signals.spectrum(time, 5 + 0.7 * np.sin(2 * np.pi * frequency * time))
    peak = np.argmax(amplitude)
    assert abs(hertz[peak] - frequency) <= LINE
    assert amplitude[peak] == pytest.approx(0.7, rel=SCALLOP)
    assert signals.peak_near(hertz, amplitude, 1.1 * frequency) == hertz[peak]
    assert signals.peak_near(hertz, amplitude, 3 * frequency, reach=0.001) is None


def test_a_train_has_no_marks_of_the_load_section(runs):
    deck = dict(runs[0].deck, stage=[dict(stage, train=stage["kind"] == "passage")
                                     for stage in runs[0].deck["stage"]])
    assert measures.loading_frequencies(dataclasses.replace(runs[0], deck=deck)) == {}


WAGONS = np.array([0, 1.8, 9, 10.8, 14, 15.8, 23, 24.8])  # two of two bogies, m behind the first


def with_train(run, axles, vehicles, rails=1, **train):
    """The run with axles at made.SPEED, nan before x = -5 m and beyond 20 m."""
    stages = [dict(stage, train=stage["kind"] == "passage") for stage in run.deck["stage"]]
    x = made.SPEED * run.time[:, None] - np.repeat(axles, rails)
    train = {"speed": made.SPEED, "vehicles": vehicles * ["wagon"]} | train
    return dataclasses.replace(run, deck={**run.deck, "stage": stages, "train": train},
                               wheel={"x": read.Quantity(
                                   np.where((x > -5) & (x < 20), x, np.nan), "m", "-")})


@pytest.mark.parametrize("rails", [1, 2])
def test_passing_frequencies_of_a_train(runs, rails):
    found = frequencies.of_passage(with_train(runs[0], WAGONS, 2, rails))
    assert found == pytest.approx({"v/L_v": 20 / 14, "v/L_c": 20 / 9, "v/L_w": 20 / 1.8,
                                   "v/s": 20 / 0.6})
    found = frequencies.of_passage(with_train(runs[0], WAGONS[:4], 1, rails))
    assert set(found) == {"v/L_c", "v/L_w", "v/s"}
    two_axles = frequencies.of_passage(with_train(runs[0], np.array([0, 9.0]), 1, rails))
    assert two_axles == pytest.approx({"v/L_w": 20 / 9, "v/s": 20 / 0.6})
    assert frequencies.of_passage(with_train(runs[0], WAGONS, 2, speeds=[20, 10])) == {}


@pytest.mark.parametrize("rails", [1, 2])
@pytest.mark.parametrize("axles, vehicles", [
    ([0, 1.8, 3.6, 10, 11.8, 13.6, 17, 22], 2),     # six axles and two: four each on average
    ([0, 1.8, 9, 10.8, 14, 16.2, 24, 26.2], 2),     # bogies of unlike wheelbases
    ([0, 1.8, 9, 10.8, 14, 15.8, 50, 51.8], 2),     # the last bogie is not known: half the axles
    ([0, 1.8, 9, 10.8, 14], 2)])
def test_vehicles_that_are_not_equal_have_no_common_frequencies(runs, axles, vehicles, rails):
    found = frequencies.of_passage(with_train(runs[0], np.array(axles), vehicles, rails))
    assert found == pytest.approx({"v/s": 20 / 0.6})


def test_the_axis_of_spectra_reaches_beyond_the_highest_passing_frequency(runs):
    for run in (with_train(runs[0], WAGONS, 2), runs[0]):
        panel = bed_on_ground.spectra([run]).axes[0]
        assert panel.lines[0].get_xdata()[-1] == pytest.approx(1.5 * 20 / 0.6, abs=2 * LINE)
        assert " v/s" in [text.get_text() for text in panel.texts]
    assert "v/s = 33.33 Hz" in bed_on_ground.table_of_peaks(runs[:1])
    bed_on_ground.plt.close("all")


def test_seat_load_spectrum_shows_bogies_and_wheels(runs):
    marks = measures.loading_frequencies(runs[0])
    assert marks == pytest.approx({"v/L_c": 2.5, "v/L_w": 8.0})
    rows = runs[0].passage()
    hertz, amplitude = signals.spectrum(runs[0].time[rows],
                                        runs[0].sleeper["seat_force"].values[rows])
    mean = np.sqrt(np.mean(amplitude**2, axis=1))
    # Two bogies of two pulses: |S| |cos(pi f L_c/v) cos(pi f L_w/v)|. The slope of one cosine
    # shifts the maximum of the other, so the peaks are near v/L_c and v/L_w, not exactly there.
    length = {name: made.SPEED / target for name, target in marks.items()}
    pulse = np.exp(-(np.pi * hertz * 0.5 / made.SPEED)**2)
    exact = pulse * np.abs(np.prod([np.cos(np.pi * hertz * each / made.SPEED)
                                    for each in length.values()], axis=0))
    for target in marks.values():
        peak = signals.peak_near(hertz, mean, target)
        assert abs(peak - signals.peak_near(hertz, exact, target)) <= 2 * LINE
        assert peak == pytest.approx(target, rel=0.2)


def test_transition_recovers_the_known_values(runs):
    wedge, none = (transition(run) for run in runs)
    assert wedge.edge == made.EDGE
    for found in (wedge, none):
        assert found.structure_displacement == pytest.approx(0.02e-3)
        assert found.far_displacement == pytest.approx(2e-3, rel=0.01)
    # 90 % of an exponential of length L is reached at 2.303 L; smoothing over 0.6 m and the median
    # of the far quarter shift it by less than two nodes.
    assert wedge.width == pytest.approx(2.303, abs=0.2)
    assert none.width == pytest.approx(0.2 * 2.303, abs=0.2)
    assert wedge.stress_jump == pytest.approx(20e3) and none.stress_jump == pytest.approx(70e3)
    assert wedge.steepest < none.steepest and wedge.edge_slope < none.edge_slope
    assert wedge.steepest_x == pytest.approx(made.EDGE, abs=0.45)  # smoothing 0.3 m, a node 0.1 m
    first, last = np.sin(4 * np.pi * np.array([0.1, 2.099]))  # 1 mm at 2 Hz, rows each 1 ms
    for found in (wedge, none):
        assert found.sleeper_displacement == pytest.approx(1e-3)
        assert found.sleeper_residual_most == pytest.approx(1e-3 * (first - last))
        assert found.sleeper_residual_least == pytest.approx(1e-3 * (first - last))


def with_ground(run, **values):
    """The run with these envelopes of the ground."""
    return dataclasses.replace(run, ground_envelope={
        **run.ground_envelope,
        **{name: read.Quantity(value, "-", "-") for name, value in values.items()}})


def test_steepest_slope_is_found_at_the_wedges_end(runs):
    x = runs[0].ground_x
    steep = -1e-3 * np.clip((x - 5.8) / 0.4, 0, 1)  # the whole 1 mm around x = 6
    found = transition(with_ground(runs[0], displacement_min=steep))
    assert found.steepest_x == pytest.approx(6.0, abs=0.3)
    # Smoothing over 0.6 m spreads 1 mm in 0.4 m over 1 m: 1/0.6 to 1/0.7 mm/m.
    assert 1.3e-3 < found.steepest < 1.7e-3 and found.edge_slope == 0


def test_far_displacement_is_that_of_plain_track_only(runs):
    # Right behind the wedge (6 m) the ground settles by 5 mm; plain track begins at 7.2 m.
    x, deep = runs[0].ground_x, made.ground_displacement(runs[0].ground_x, True)
    deep = np.where((x > 5.9) & (x < 6.55), -5e-3, deep)
    for run in runs:  # a wedge that is not present has the same extent
        assert ground_blocks.wedge_length(run) == pytest.approx(4.0)
        found = transition(with_ground(run, displacement_min=deep))
        assert found.far_displacement == pytest.approx(2e-3, rel=0.02)


@pytest.mark.parametrize("end, plain", [(7.15, True), (7.25, False)])  # 9 - 1.8 = 7.2
def test_missing_plain_track_is_reported(runs, end, plain):
    blocks = [dict(block) for block in runs[0].deck["ground"]["block"]]
    blocks[1]["outline"] = [made.EDGE, 0.0, end, 0.0, made.EDGE, -2.0]
    short = [dataclasses.replace(run, deck={**run.deck, "ground": {"block": blocks}})
             for run in runs]
    assert np.isfinite(transition(short[0]).far_displacement) == plain
    text = table(short)
    assert ("this model has no plain track beyond the wedge" in text) != plain
    assert ("width of the transition: " in text) == plain
    # The wedge of one run determines where both are measured.
    assert np.isfinite(transition(runs[0], end - made.EDGE).far_displacement) == plain


def test_stress_jump_is_of_means_not_of_single_nodes(runs):
    stress = made.ground_stress(runs[0].ground_x, True)
    edge = np.argmin(np.abs(runs[0].ground_x - made.EDGE))
    stress[edge] -= 1e6  # a stone at the node of the edge, which belongs to neither side
    stress[edge - 1] -= 70e3
    found = transition(with_ground(runs[0], sigma_z_min=stress))
    assert found.stress_jump == pytest.approx(20e3 + 70e3 / 6)  # 6 nodes in 0.6 m


def test_histories_of_one_place_have_two_dimensions(tmp_path):
    """The file stores those of a single sleeper in one dimension."""
    made.store(tmp_path / "one.h5", {f"history/sleeper/{name}": (np.zeros(shape), "m")
                                     for name, shape in (("one", (5,)), ("two", (5, 2)))})
    with h5py.File(tmp_path / "one.h5") as file:
        found = read._of_places(file, "history/sleeper")
    assert found["one"].values.shape == (5, 1) and found["two"].values.shape == (5, 2)


def test_residual_displacement_of_sleepers_is_reported(runs):
    sunk = runs[0].sleeper["displacement"].values.copy()
    sunk[-1, 4] = sunk[runs[0].passage()][0, 4] - 2e-3
    sunk[-1, 5] = sunk[runs[0].passage()][0, 5] + 0.9e-3
    bad = dataclasses.replace(runs[0], sleeper={
        **runs[0].sleeper, "displacement": read.Quantity(sunk, "m", "-")})
    assert transition(bad).sleeper_residual_most == pytest.approx(2e-3)
    assert transition(bad).sleeper_residual_least == pytest.approx(-0.9e-3)
    rows = dict(line.rsplit("mm", 1) for line in table([bad]).splitlines() if " mm " in line)
    found = [float(rows[name]) for name in rows if name.startswith("residual displacement")]
    assert found == [2.0, -0.9], "downwards positive, as the head of the table states"
    lines = measures.warnings(bad)
    assert len(lines) == 1 and "x = 2.70 m has a residual displacement of 2.00 mm" in lines[0]
    assert lines[0] in table([bad]) and "warning" not in table(runs)
    for both in ([bad, runs[1]], [runs[1], bad]):
        text = table(both)
        assert text.index(lines[0]) < text.index("may have other causes than the wedge") \
            < text.index("expected of a wedge" if both[0] is bad else "relative to the second")


def test_settlement_of_ground_is_not_attributed_to_stones(runs):
    run = runs[0]
    rows, nodes = len(run.time), len(run.ground_x)
    for way, word in ((-5e-3, "downwards"), (5e-3, "upwards")):
        check_moved_ground(run, np.linspace(0, way, rows), nodes, word)


def check_moved_ground(run, down, nodes, word):
    sinking = dataclasses.replace(
        run, ground={"displacement": read.Quantity(np.tile(down[:, None], (1, nodes)), "m", "-")},
        sleeper={**run.sleeper, "displacement": read.Quantity(
            run.sleeper["displacement"].values + down[:, None], "m", "-")})
    lines = measures.warnings(sinking)
    assert len(lines) == 1 and "the ground has a residual displacement of 4." in lines[0] \
        and word in lines[0]


def test_different_stages_are_reported(runs):
    stages = [{**stage, "duration": 7} for stage in runs[1].deck["stage"]]
    other = dataclasses.replace(runs[1], deck={**runs[1].deck, "stage": stages})
    assert "the two decks differ in their stages" in table([runs[0], other])
    assert "differ in their stages" not in table(runs)


def test_structure_at_the_right_end_gives_the_same(runs):
    run = runs[0]
    last = run.ground_x[-1]
    blocks = [dict(block) for block in run.deck["ground"]["block"]]
    for block in blocks:
        block["outline"] = [last - value if i % 2 == 0 else value
                            for i, value in enumerate(block["outline"])]
    mirrored = dataclasses.replace(run, ground_x=last - run.ground_x,
                                   deck={**run.deck, "ground": {"block": blocks}})
    left, right = transition(run), transition(mirrored)
    assert right.edge == pytest.approx(last - made.EDGE)
    assert right.steepest_x == pytest.approx(last - left.steepest_x)
    assert (right.plain_begin, right.plain_end) == pytest.approx(
        (last - left.plain_end, last - left.plain_begin))
    for field in {each.name for each in dataclasses.fields(left)} - {
            "edge", "steepest_x", "plain_begin", "plain_end"}:
        assert getattr(right, field) == pytest.approx(getattr(left, field), rel=1e-9), field


def test_table_distinguishes_the_wedge_from_its_opposite(runs):
    text = table(runs)
    assert "NOT" not in text and text.count("as expected of a wedge") == 4
    assert ("ground displacement on plain track beyond the wedge (x = 7.20 to 9.00 m): -0%: "
            "equal within 10%, so the runs are comparable") in text
    assert "-71%" in text  # jump 20 against 70 kPa
    x = runs[0].ground_x
    worse = [with_ground(run, displacement_min=made.ground_displacement(x, wedge),
                         sigma_z_min=made.ground_stress(x, wedge))
             for run, wedge in zip(runs, (False, True))]
    assert table(worse).count("NOT as expected of a wedge") == 4
    # The run without wedge first: a wedge cannot be judged.
    assert "expected of a wedge" not in table(runs[::-1])
    assert "expected of a wedge" not in table([runs[0], with_ground(
        runs[0], displacement_min=2 * made.ground_displacement(runs[0].ground_x, True))])


def test_small_changes_have_no_verdict(runs):
    x = runs[0].ground_x
    near = with_ground(runs[0], displacement_min=1.05 * made.ground_displacement(x, True),
                       sigma_z_min=made.ground_stress(x, True) * 1.05)
    text = table([near, runs[0]])
    assert text.count("no clear effect (within 10%)") == 4 and "expected of a wedge" not in text
    far = with_ground(runs[0], displacement_min=1.2 * made.ground_displacement(x, True))
    text = table([far, runs[0]])
    assert "although neither run has a wedge there: the runs are not comparable" in text
    assert "no verdict, since the plain tracks differ" in text
    assert "no verdict" not in table(runs)


def test_absent_wedge_is_not_marked(runs):
    assert [one.label for one in ground_blocks.stretches(runs[0])] == ["structure", "wedge"]
    assert [one.label for one in ground_blocks.stretches(runs[1])] == ["structure"]
