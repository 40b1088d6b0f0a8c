"""The instant that pictures of field files show unless a time is given."""
import conftest
import made
import numpy as np
import pytest
from model_files import LINE, write_grid, write_series, write_stones, write_train

from trackbed_post import bed_figures, contact_forces, passage_instant, read, still

# Time -> x of the wheels; the bed is from 0.5 to 2.5 m, its middle at 1.5 m.
WHEELS = {0.1: (-2.0, -1.0), 0.2: (0.6, 1.8), 0.3: (2.4, 3.6), 0.4: (8.0, 9.2)}


@pytest.fixture(name="run", scope="module")
def passed_run(tmp_path_factory):
    """The train has left at the last instants; there are stones at rest before and after it."""
    folder = tmp_path_factory.mktemp("passed")
    (folder / "fields").mkdir()
    series = {"stones": [], "train": []}
    for k, time in enumerate((0.0, *WHEELS, 0.5)):
        for part in ("stones", "train"):
            name = f"pass_{k:06d}_{part}.hdf"
            if part == "stones":
                write_stones(folder / "fields" / name, (1, 2, 3))
            elif time in WHEELS:
                write_train(folder / "fields" / name, WHEELS[time])
            else:
                continue
            series[part].append((name, time))
    write_series(folder, series)
    return folder


def test_wheels_are_the_disks_not_the_rail(run):
    for k, x in enumerate(WHEELS.values(), 1):
        file = run / f"fields/pass_{k:06d}_train.hdf"
        assert passage_instant.wheels_in(file) == pytest.approx(x)
    assert passage_instant.wheels_in(run / "fields/pass_000001_stones.hdf") == []


def test_it_is_the_one_with_a_wheel_nearest_to_the_middle_of_the_bed(run):
    assert passage_instant.time_of(run) == 0.2
    assert passage_instant.time_of(run, after=0.2) == 0.3
    assert passage_instant.time_of(run, after=0.3) is None


def test_maps_show_it_and_state_it(run, tmp_path):
    for words, stated in (((), "velocity at 0.2 s"), (("--time", 9), "velocity at 0.5 s"),
                          (("--relative-to", 0.3), "displacement at 0.5 s, change since 0.3 s")):
        ran = conftest.call("map", run, "--part", "stones", *words, "-o", tmp_path)
        assert stated in ran.stdout, ran


def test_stills_show_it(run):
    files, label = still.chosen_files([str(run)], None, None)
    assert label.startswith("pass, 0.2 s") and set(files) == {"stones", "train"}
    assert still.chosen_files([str(run)], ("stones",), None)[1].startswith("pass, 0.2 s")
    assert still.chosen_files([str(run)], None, 0.5)[1].startswith("pass, 0.5 s")


@pytest.mark.parametrize("stage, found", [("passage", 0.35), ("load", None)])
def test_axles_of_a_load_have_the_places_of_their_speed(tmp_path, stage, found):
    """At SPEED = 20 m/s from 0.1 s on; the first axle is over the middle of the bed, 4.5 m, at
    0.325 s, the next one, 2.5 m behind it, 0.125 s later."""
    run = made.write(tmp_path / "run")
    (run / "fields").mkdir()
    times = (0.25, 0.35, 0.55, 2.0)
    names = [f"{stage}_{k:06d}_stones.hdf" for k in range(len(times))]
    for name in names:
        write_stones(run / "fields" / name, (1, 2, 3), np.array([0.0, 4.0, 9.0]))
    write_series(run, {"stones": zip(names, times)})
    assert passage_instant.time_of(run) == found


def test_a_run_without_a_passage_shows_its_end(tmp_path):
    (tmp_path / "fields").mkdir()
    write_stones(tmp_path / "fields/rest_000001_stones.hdf", (1, 2, 3))
    write_series(tmp_path, {"stones": [("rest_000001_stones.hdf", 1.0)]})
    assert passage_instant.time_of(tmp_path) is None


def test_contact_forces_are_those_of_the_passage_if_field_files_have_them(tmp_path):
    """At its end, in results.h5, the load has passed."""
    run = made.write(tmp_path / "run")
    (run / "fields").mkdir()
    series = {"stones": [], "contacts": []}
    for k, (time, force) in enumerate([(0.25, 1.0), (0.35, 700.0), (0.55, 3.0)]):
        for part in series:
            series[part].append((f"passage_{k:06d}_{part}.hdf", time))
        write_stones(run / "fields" / series["stones"][-1][0], (1, 2, 3), (0.0, 4.0, 9.0))
        write_grid(run / "fields" / series["contacts"][-1][0], np.eye(3)[[0, 1, 1, 2]],
                   [[0, 1], [2, 3]], LINE, cell_data={"force_size": ([force, 2 * force], "N")})
    write_series(run, series)
    found = contact_forces.of_run(read.results(run))
    assert found.values.tolist() == [700, 1400]
    assert found.words == "at 0.3500 s, a wheel nearest to the middle of the bed"
    title = bed_figures.forces([read.results(run)]).axes[0].get_title()
    assert "at 0.3500 s" in title.replace("\n", " ")
    ran = conftest.call("histogram", "contact_force", run, "-o", tmp_path)
    assert f"run {found.words}: 2 values, mean 1050" in ran.stdout
