"""What the scripts of studies compute themselves: numbers, targets, outlines."""
import pathlib
import sys
import threading
import time
import tomllib

import types

import h5py
import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "jobs"))
import launch  # noqa: E402
import study  # noqa: E402
from studies import (chen, chen_runs, chen_targets, demfem, demfem_model,  # noqa: E402
                     demfem_targets, netirail, netirail_document, netirail_measure, shi, shi_runs)
from studies.study import (Lines, Numbers, Run, Target, between, cell, counted,  # noqa: E402
                           of_packings, reflowed, span, targets_table)


def test_numbers_and_lines_are_read_as_written(tmp_path):
    numbers = Numbers({"version": "trackbed 1, commit abc", "command": "a: b"})
    numbers.put("run", "rail, 41 m", 0.123456789, "mm")
    numbers.put("other", "force", -1e5, "N")
    (tmp_path / "numbers.csv").write_text(numbers.text(), encoding="utf-8")
    found = Numbers.read(tmp_path / "numbers.csv")
    assert found.about == numbers.about
    assert found("run", "rail, 41 m") == 0.123457 and found("other", "force") == -1e5
    assert found.rows == numbers.rows and found.has("run") and not found.has("none")
    lines = Lines()
    lines.put("figure", "one, two", [0.5, 1.25], [3, -4])
    (tmp_path / "lines.csv").write_text(lines.text(), encoding="utf-8")
    assert Lines.read(tmp_path / "lines.csv").of("figure") == {"one, two": ((0.5, 1.25), (3, -4))}


@pytest.mark.parametrize("ours, yes", [(1.0, True), (1.25, True), (1.26, False), (-1.0, False)])
def test_a_target_is_reproduced_within_its_deviation(ours, yes):
    target = Target("rail", "main", "about 1 mm", ours, "mm", 1.0, 0.25)
    assert target.reproduced() == yes
    assert ("| yes |" in targets_table([target])) == yes


def test_a_target_counts_the_packings_that_reproduce_it():
    def verdict(*each):
        return Target("stress", "main", "10 kPa", float(np.mean(each)), "kPa", 10, 0.15,
                      each=each).verdict()
    assert verdict(9, 10, 11) == "yes" and verdict(5, 20, 30) == "**no**"
    assert verdict(5, 10, 20) == "in 1 of 3 packings"
    assert counted([Target("a", "main", "", 1.0, "", 1, 0.1, each=(1, 2)),
                    Target("b", "main", "", 1.0, "", 1, 0.1),
                    Target("c", "main", "", 2.0, "", 1, 0.1)]) == (
        "Of 3 targets 1 is reproduced, 1 in some packings only, 1 is not.")
    inputs = [Target(name, "input", "", ours, "", 1, 0.1) for name, ours in (("d", 1), ("e", 2))]
    yes, no, some = (Target("a", "main", "", 1.0, "", 1, 0.1, each=each)
                     for each in ((1,), (2,), (1, 2)))
    assert counted([*inputs, yes]) == (
        "The one target is reproduced. Of 2 checks of the input 1 holds.")
    assert counted([inputs[0], no]) == (
        "The one target is not reproduced. The one check of the input holds.")
    assert counted([inputs[1], some]) == (
        "The one target is reproduced in some packings only. "
        "The one check of the input does not hold.")
    assert "| 10 (9 to 11) kPa | 0.0 % | yes |" in targets_table(
        [Target("stress", "main", "10 kPa", 10.0, "kPa", 10, 0.15, each=(9, 11))])


def test_several_values_are_shown_with_their_range():
    assert span([1, 3]) == "2 (1 to 3)" and span([12345.6]) == "12346" and span([]) == "none"
    assert span([0.12, 0.14], ".1f") == "0.1 (0.1 to 0.1)"
    assert between([2.2, 1.6], ".1f") == "1.6 to 2.2" and between([1.2, 1.4]) == "1"
    numbers = Numbers({})
    numbers.put("run", "rail", 0.123456, "mm")
    assert cell(numbers, "run", "rail") == "0.123" and cell(numbers, "run", "pad") == ""
    assert of_packings(1) == "one packing"


def test_an_infinite_value_is_called_refused_only_by_its_target():
    def row(**more):
        return targets_table([Target("force", "main", "", float("inf"), "kN", holds=False, **more)])
    assert "| refused |" in row(infinite="refused") and "| inf kN |" in row()


@pytest.mark.parametrize("form", ["short", "full"])
@pytest.mark.parametrize("name", study.STUDIES)
def test_each_run_has_a_folder_of_its_own_and_a_deck(name, form):
    runs = study.study_of(name).runs(form, 2)
    assert len({run.name for run in runs}) == len(runs) > 2
    inputs = pathlib.Path(__file__).resolve().parents[2] / "inputs"
    assert all((inputs / run.deck).is_file() for run in runs)


def area(outline):
    x, z = np.transpose(outline)
    return abs(np.dot(x, np.roll(z, 1)) - np.dot(z, np.roll(x, 1))) / 2


def test_strips_of_the_wedge_add_up_to_it():
    for reach in map(netirail.reach_of, netirail.WEDGE):
        parts = [netirail.clip(6 + 3 * k, 9 + 3 * k, reach) for k in range(8)]
        assert sum(area(part) for part in parts if part) == pytest.approx(reach * 8.4 / 2)


def test_mirrored_layers_and_points_are_those_of_the_deck_seen_from_the_other_end():
    words = dict(word.split("=") for word in netirail.mirrored())
    deck = (pathlib.Path(__file__).resolve().parents[2]
            / "inputs/track/netirail_2d.toml").read_text(encoding="utf-8")
    blocks = {block["name"]: np.reshape(block["outline"], (-1, 2))
              for block in tomllib.loads(deck)["ground"]["block"]}
    for name, outline in blocks.items():
        mirror = np.reshape(np.fromstring(words[f"ground.block.{name}.outline"].strip("[]"),
                                          sep=","), (-1, 2))
        assert np.allclose(mirror, outline * [-1, 1] + [60, 0])
    assert np.allclose(np.fromstring(words["passage.points"].strip("[]"), sep=","),
                       [83.4 - 32.4, 83.4 - 58.8])


def test_wide_sleepers_have_the_spring_of_the_deck_formula():
    z = (np.arange(1000) + 0.5) * 0.3e-3  # m, half of the depth spreads on each free side

    def spring(width):
        return 1 / np.sum(0.3e-3 / ((width + z) * (1.3 + z / 2)))
    assert f"bed={spring(0.58) / spring(0.29):.2f}" in netirail.WIDE
    assert f"footprint={(0.58 + 0.3) / (0.29 + 0.3):.2f}" in netirail.WIDE


def test_the_steepest_change_is_that_within_the_window():
    x = np.arange(0, 10, 0.5)
    down = np.where(x < 3, 0, 1) + np.where(x < 8, 0, 5)
    assert netirail_measure.steepest(x, down, (-1, 7)) == 2
    assert netirail_measure.steepest(x, down, (-1, 11)) == 10


def test_the_document_states_what_the_numbers_say():
    """With the numbers of docs/studies, of which one is changed."""
    folder = pathlib.Path(__file__).resolve().parents[2] / "docs/studies/netirail"
    numbers = Numbers.read(folder / "numbers.csv")
    before = netirail_document.document(numbers)
    one, three = ("plane_same_width_fill_1", "rail, 14.7 m"), ("plane_same_width_fill_3",
                                                              "rail, 14.7 m")
    numbers.rows[three] = (0.5 * numbers.rows[one][0], "mm")
    after = netirail_document.document(numbers)
    words = "largest reduction by mass alone in these experiments is -50.0 %"
    assert words in " ".join(after.split()) and words not in " ".join(before.split())


def changed_document(name, run_of, value_of=lambda run, quantity, value: value, own=""):
    """The document of a study with the numbers of docs/studies, if each run is that of another
    name, but for the quantity `own`, and has other values."""
    folder = study.INPUTS.parent / "docs/studies" / name
    numbers = Numbers.read(folder / "numbers.csv")
    numbers.rows = {(run if quantity == own else run_of(run), quantity):
                    (value_of(run, quantity, value), unit)
                    for (run, quantity), (value, unit) in numbers.rows.items()}
    numbers.lines = Lines.read(folder / "lines.csv")
    numbers.lines.rows = {(figure, run_of(line)): points
                          for (figure, line), points in numbers.lines.rows.items()}
    study.derive(name, numbers)
    return " ".join(study.document_of(name, numbers).split())


def exchanged(one, other):
    return lambda run: run.replace(one, "?").replace(other, one).replace("?", other)


def test_verdicts_on_shapes_follow_from_the_numbers():
    def bounded(run, quantity, value):
        return 1000 if quantity == "upper bound of the stiffness" else value
    words = ("Non-convex stones make the bed stiffer",
             "non-convex stones it is lower", "as non-convex stones yield more in the first",
             "it lies below the published")
    usual = changed_document("demfem", str)
    other = changed_document("demfem", exchanged("_non_convex", "_convex"), bounded,
                             "upper bound of the stiffness")
    assert all(each in usual for each in words) and not any(each in other for each in words)
    assert all(each in other for each in (
        "Non-convex stones make the bed softer",
        "non-convex stones it is higher", "as convex stones yield more in the first",
        "it lies above the published"))


def test_verdicts_on_loads_follow_from_the_numbers():
    def outer(run, quantity, value):
        return value * (0.5 if quantity in ("settlement, sleeper 1", "settlement, sleeper 5")
                        else 1)
    usual = changed_document("chen", str)
    other = changed_document("chen", exchanged("t17_v120", "t25_v120"), outer)
    for words in ("- As published: more fragments under", "The probable cause of the larger",
                  "and the first bogie alone does not"):
        assert words in usual and words not in other
    assert ("at least in one packing: more fragments under the heavier axles; more settlement of "
            "sleepers 1 and 5" in other)


def test_the_part_of_a_record_in_other_bins_and_its_power_below_a_frequency():
    lines = Lines()
    for name, values in (("one", [0.01] * 3 + [-0.52]), ("other", [0.01, -0.52, -0.52, -0.52])):
        netirail_measure.put_histogram("histogram", name, np.array(values), lines)
    assert netirail_measure.moved(lines, "histogram", "one", "one") == 0
    assert netirail_measure.moved(lines, "histogram", "one", "other") == pytest.approx(50)
    time = np.arange(1000) * 1e-3
    record = 5 + 3 * np.sin(2 * np.pi * 10 * time) + np.sin(2 * np.pi * 50 * time)
    assert netirail_measure.power_below(record, time, 20) == pytest.approx(0.9)


def test_own_weight_on_a_plane_layer():
    # 157.5 kg on 0.6 x 6.5 m: 396 Pa on 9 m of 80 MPa / (1 - 0.09).
    assert netirail_measure.own_weight(1) == pytest.approx(0.0405, abs=1e-4)


def test_works_are_done_after_those_before_them_and_never_in_more_slots_than_given():
    lock, state, most, order = threading.Lock(), {"used": 0}, [], []
    both = threading.Barrier(2, timeout=60)  # of the first two, which must run side by side

    def work(name, slots):
        def do():
            with lock:
                state["used"] += slots
                most.append(state["used"])
            if name in ("a", "c"):
                both.wait()
            time.sleep(0.02)
            with lock:
                state["used"] -= slots
                order.append(name)
        return do
    before = {"a": (), "b": ("a",), "c": (), "wide": ("c",), "too wide": (), "last": ("wide",)}
    slots = {"wide": 2, "too wide": 5}
    launch.together([(name, after, slots.get(name, 1), work(name, slots.get(name, 1)))
                     for name, after in before.items()], 2)
    assert sorted(order) == sorted(before)
    assert all(order.index(first) < order.index(name)
               for name, after in before.items() for first in after)
    assert sorted(set(most)) == [1, 2, 5]


def test_works_that_wait_for_each_other_are_refused():
    with pytest.raises(ValueError, match="a, b"):
        launch.together([("a", ("b",), 1, int), ("b", ("a",), 1, int), ("c", (), 1, int)], 2)


def test_a_work_that_ends_the_script_stops_the_others(monkeypatch):
    runs, done = launch.Runs(), []
    monkeypatch.setattr(launch, "RUNS", runs)

    def fails():
        sys.exit(4)

    def waits():
        end = time.monotonic() + 10
        while not runs.stop_requested and time.monotonic() < end:
            time.sleep(0.01)
        done.append(runs.stop_requested)
    with pytest.raises(SystemExit) as ended:
        launch.together([("waits", (), 1, waits), ("fails", (), 1, fails),
                         ("never", ("fails",), 1, lambda: done.append("never"))], 2)
    assert ended.value.code == 4 and done == [True]


def test_the_rise_of_a_surface_is_found_among_loads_of_single_stones():
    x = np.linspace(0, 17, 301)
    s = np.maximum(x - shi.EDGE, 0)
    rough = 1 + 0.1 * np.sin(40 * x)
    for length, power in ((1.0, 1.0), (3.0, 2.0)):
        down = 0.02 + 1.1 * (1 - np.exp(-(s / length)**power)) * rough
        assert shi.rise(x, down, 0.02, 1.12) == pytest.approx(
            length * np.log(10)**(1 / power), rel=0.05)


def test_cells_have_the_mean_velocity_of_their_points():
    points = np.array([[0.1, 0.1], [0.5, 0.1], [0.7, 0.1], [0.1, -0.1]])
    centres, means = shi.cells(points, np.array([[1, 2], [3, 4], [5, 6], [7, 8]]), 0.6, 0.2)
    found = {tuple(np.round(at, 6)): tuple(of) for at, of in zip(centres, means)}
    assert found == {(0.3, 0.1): (2, 3), (0.9, 0.1): (5, 6), (0.3, -0.1): (7, 8)}


def test_sampled_loads_are_those_of_the_formula():
    rows = np.loadtxt(study.INPUTS / "shi/seat_load_100hz.csv", delimiter=",", skiprows=1)
    s = shi.LOAD["speed"] * (rows[:, 0] - 0.25)
    b = shi_runs.DECAY
    force = sum(np.exp(-b * np.abs(s - at)) * (np.cos(b * np.abs(s - at))
                + np.sin(b * np.abs(s - at))) for at in shi.LOAD["axles"]) * shi.LOAD["peak"]
    assert np.allclose(rows[1:-1, 1], force[1:-1], atol=0.6) and np.all(np.diff(rows[:, 0]) > 0)


def test_stiffness_is_the_slope_of_each_loading():
    time = np.arange(0, demfem_model.CYCLES["duration"], 1e-3)
    phase = time / demfem_model.PERIOD
    stress = 1e5 * (1 - np.cos(2 * np.pi * phase)) / 2
    strain = stress / 20e6 + 1e-3 * phase.astype(int)  # keeps more in each cycle
    assert np.allclose(demfem.slopes(stress, strain, time, 5), 20e6, rtol=1e-6)


def test_the_benchmark_is_predicted_from_rates():
    numbers = Numbers({})
    numbers.put("cost_convex", "stone steps per second and core", 1e6, "1/s")
    numbers.put("cost_convex", "element steps per second and core", 1e7, "1/s")
    stones, ground = demfem.predicted(numbers, "convex", 16)
    assert stones == pytest.approx(3.3e5 * 5e5 / 1e6 / 16 / 60)
    assert ground == pytest.approx(3750 * 5e4 / 1e7 / 16 / 60)


def test_a_difference_between_few_packings_must_exceed_more_standard_errors():
    assert demfem_targets.student(5) == pytest.approx(2.306, abs=1e-3)
    numbers = Numbers({})
    for shape, values in (("convex", (2.0, 2.2)), ("non_convex", (1.6, 1.8))):
        for packing, value in enumerate(values, 1):
            numbers.put(f"track_{shape}_{packing}", "sunk", value, "mm")
    by, certain = demfem_targets.less(numbers, "sunk", "track")
    assert by == pytest.approx(0.4) and not certain  # 2.8 standard errors, and 4.3 are needed


def test_the_ground_has_the_largest_principal_stresses_along_the_track(tmp_path):
    fields = tmp_path / "fields"
    fields.mkdir()
    cube = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    places = [(0, 0, 0), (0, 1, 0), (5, 0, 0)]
    stress = [(2e6, 0, -1e6, 0, 0, 0), (0, 0, 0, 3e6, 0, 0), (-4e6, 0, 0, 0, 0, 0)]
    with h5py.File(fields / "load_000010_ground.hdf", "w") as file:
        file["VTKHDF/Points"] = np.concatenate([cube + place for place in places])
        file["VTKHDF/Connectivity"] = np.arange(24)
        file["VTKHDF/Offsets"] = np.arange(0, 25, 8)
        file["VTKHDF/CellData/stress_change"] = np.array(stress)
    numbers, lines = Numbers({}), Lines()
    demfem.measure_ground("ground", tmp_path, numbers, lines)
    assert lines.of("tension")["ground"] == ((0.5, 5.5), (3, 0))
    assert lines.of("compression")["ground"] == ((0.5, 5.5), (3, 4))
    assert numbers("ground", "tension, x of the largest") == 0.5


def test_stresses_at_the_edge_are_compared_with_those_beyond():
    x = np.arange(0, 17.01, 0.05)
    stress = 1e5 + 1e4 * np.sin(2 * np.pi * (x - 1.9) / 0.6) + 4e4 * (x < shi.EDGE)
    run = types.SimpleNamespace(
        ground_x=x, ground_envelope={"sigma_z_min": types.SimpleNamespace(values=-stress)},
        sleepers_x=np.array(shi.seats(shi.DECK)))
    numbers, lines = Numbers({}), Lines()
    shi.put_stress("run", run, numbers, lines)
    assert numbers("run", "stress, mean before the edge") == pytest.approx(140, abs=2)
    assert numbers("run", "stress, mean behind the edge") == pytest.approx(100, abs=2)
    assert numbers("run", "stress, most before the edge") == pytest.approx(150, abs=0.5)
    assert numbers("run", "stress, least behind the edge") == pytest.approx(90, abs=0.5)
    assert numbers("run", "difference of nodes beyond, mean") == pytest.approx(20, abs=1)
    assert numbers("run", "difference of means beyond, mean") == pytest.approx(0, abs=2)


def test_sleepers_that_move_down_ahead_of_an_axle_are_counted():
    x, time = np.arange(0.7, 17, 0.6), np.linspace(0, 1.8, 3601)
    load = {"start": -3, "speed": 20}
    ahead = x[None, :] - (load["start"] + load["speed"] * time[:, None])
    velocity = -1.0 * ((ahead > -0.1) & (ahead < 1.9))  # the one below and three ahead
    run = types.SimpleNamespace(deck={"load": load})
    assert shi.ahead(x, velocity, time, run) == 3


def test_a_key_depends_on_files_and_earlier_runs_but_not_on_comments(tmp_path, monkeypatch):
    inputs, folder = tmp_path / "inputs", tmp_path / "runs"
    for path in (inputs, folder):
        path.mkdir()
    monkeypatch.setattr(study, "INPUTS", inputs)
    deck = inputs / "deck.toml"
    deck.write_text('file = "curve.csv"\n', encoding="utf-8")
    runs = [Run("first", "deck.toml", ("a='{folder}/stones.h5'", "b='{inputs}/more.csv'")),
            Run("second", "deck.toml", ("start='{folder}/first/stage_a.h5'",))]
    files = [inputs / "curve.csv", inputs / "more.csv", folder / "stones.h5"]
    for file in files:
        file.write_text("1", encoding="utf-8")

    def keys():
        made = study.Key(sys.executable, runs, folder)
        return [made.of(run) for run in runs]
    assert study.Key(sys.executable, runs, folder).before(runs[1]) == ["first"]
    assert study.Key(sys.executable, runs, folder).changes(runs[0]) == [
        f"a='{folder}/stones.h5'", f"b='{inputs}/more.csv'"]
    before = keys()
    deck.write_text('# new\nfile = "curve.csv"\n', encoding="utf-8")
    assert keys() == before
    for file in files:
        file.write_text("2", encoding="utf-8")
        after = keys()
        assert all(a != b for a, b in zip(after, before))
        before = after


def test_paragraphs_and_items_fill_their_lines_and_tables_remain():
    text = ("# Head\none two\nthree\n\n\n\n- first item\n  goes on\n- second\n"
            "| a | b |\n![x](y z.png)\n")
    assert reflowed(text, 12) == ("# Head\none two\nthree\n\n- first item\n  goes on\n- second\n"
                                  "| a | b |\n![x](y z.png)\n")


def test_signs_of_hard_and_main_targets_are_required():
    def of(kind, sign):
        return Target(f"{kind} {sign}", kind, "", 1.0, "", 1, 0.1, sign=sign)
    targets = [of(kind, sign) for kind in ("hard", "main", "soft")
               for sign in (True, False, None, np.bool_(False), np.float64(1) > 2)]
    assert study.wrong(targets) == [f"{kind} False" for kind in ("hard", "main") for _ in range(3)]


class LinearSlice(chen.Passage):
    """A slice whose stresses are known: vertical stress of 1 kPa per m of depth and s, and shear
    that depends on the distance from sleeper 3."""

    def __init__(self, shear):
        self.load = {"start": -2.5, "speed": 10.0, "axles": [0, 2.5, 17.5, 20]}
        self.time = np.linspace(0, 3, 301)
        self.x, self.z = np.linspace(0.05, 2.95, 30), np.linspace(0.025, 0.575, 12)
        self.sleepers = 0.3 + 0.6 * np.arange(5)
        self.stress = np.zeros((301, 12, 30, 6))
        self.stress[..., 2] = 1e3 * (0.45 - self.z)[:, None] * self.time[:, None, None]
        self.stress[..., 4] = shear(self.x - 1.5)


def test_stresses_of_a_slice_are_found_at_depths_and_times():
    found = LinearSlice(np.sin)
    assert found.when(1.5, 2.5) == pytest.approx(0.65)  # 6.5 m at 10 m/s
    assert np.allclose(found.wheels(1.5), (0.4, 2.15))
    assert np.allclose(found.unloaded(1.5), (1.5 + 10 + 2.5) / 10)
    for depth in chen.DEPTHS:
        history = found.below(1.5, depth, 2)
        assert np.allclose(history, 1e3 * depth * found.time)
        assert found.at([0.123], history) == pytest.approx(123 * depth)


def test_an_axle_is_found_at_the_peak_of_its_pulse():
    found = LinearSlice(np.sin)
    pulses = sum(0.6**((10 * found.time - 4 - axle) / 0.6)**2 for axle in (0, 2.5))
    delay = found.peak(pulses, 1.5, 2.5) - found.peak(pulses, 1.5, 0)
    assert delay == pytest.approx(0.25, rel=5e-3)


@pytest.mark.parametrize("shear, part", [(np.sin, 1), (np.cos, 0),
                                         (lambda x: np.sign(x) + 1, 0.5)])
def test_antisymmetric_part_of_shear(shear, part):
    found = LinearSlice(shear)
    fields = found.at(found.wheels(1.5), found.stress)
    assert chen.antisymmetric(found, fields) == pytest.approx(part)


def test_the_shear_after_the_largest_deviator_is_strictly_later():
    lines = Lines()
    time = 0.1 * np.arange(6)
    lines.put("sine, time", "vertical - horizontal", time, [0, 1, 30, 40, 20, 0])
    lines.put("sine, time", "shear", time, [0, 5, -12, 9, -7, 1])
    assert chen_targets.path_of(lines) == chen_targets.Path(40, 9, -12, -7, 29, 0.2)


def test_stones_of_ballast_are_those_above_the_sub_ballast():
    found = LinearSlice(np.sin)
    layers = np.ones((301, 12, 30)) * (found.z < chen.SUB_BALLAST)[:, None]
    found.cells = {"stones": 1 + 9 * layers, "speed": 0.002 - 0.001 * layers,
                   "contacts": layers, "contact_force": layers}
    numbers = Numbers({})
    chen.measure_stones("run", found, numbers)
    assert numbers("run", "mean speed of ballast") == pytest.approx(2)
    assert numbers("run", "mean speed") == pytest.approx(4 / 3, rel=1e-5)
    assert numbers("run", "stones of ballast") == 300
    assert numbers("run", "spheres of sub-ballast") == 600


def test_the_rotation_is_measured_while_the_whole_bogie_passes():
    found = LinearSlice(np.sin)
    found.time = np.linspace(0, 3, 301)
    found.stress[..., 4] = 100 * found.time[:, None, None]
    found.stress[..., 2] = 200.0
    numbers, lines = Numbers({}), Lines()
    chen.measure_rotation("run", found, numbers, lines)
    begin, end = ((1.5 + axle + 2.5) / 10 for axle in (17.5 - chen.AROUND, 20 + chen.AROUND))
    angles = np.degrees(np.arctan([begin, end])) / 2
    assert numbers("run", "rotation, centre, 0.1 m") == pytest.approx(np.ptp(angles), rel=0.02)
    assert numbers("run", "rotation, length before and behind the bogie") == 2.5


def test_growth_compares_loads_packing_by_packing():
    numbers = Numbers({})
    for packing, light, heavy in ((1, 100, 150), (2, 200, 500)):
        numbers.put(chen_runs.name_of(17, 120, packing), "corners broken", light, "-")
        numbers.put(chen_runs.name_of(25, 120, packing), "corners broken", heavy, "-")
    assert np.allclose(chen_targets.growth(numbers, "corners broken"), (50, 150))
