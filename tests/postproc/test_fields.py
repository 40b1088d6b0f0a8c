"""Pictures and films of the parts of a run, of field files with known places, sizes and speeds."""
import os
import subprocess
import sys

import conftest
import h5py
import matplotlib.colors
import matplotlib.image
import numpy as np
import pytest
from model_files import (FACES, HEXAHEDRON, LINE, OTHERS, RADIUS, SLEEPER, PLATEN, SPEEDS, STAGES,
                         TIMES, TRIANGLE, VERTICES, brick, write_grid, write_ground, write_series,
                         write_stones, write_surfaces)
from PIL import Image

from trackbed_post import actors, framing, grids, instants, read, scene, transition

@pytest.fixture(name="run", scope="module")
def field_run(tmp_path_factory):
    """A folder of three instants in two stages; the train runs at the last one only."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "fields").mkdir()
    series = {}
    for k, (stage, time) in enumerate(zip(STAGES, TIMES)):
        for part in ("stones", "surfaces", "ground", "train"):
            if part == "train" and k < 2:
                continue
            name = f"{stage}_{k + 1:06d}_{part}.hdf"
            if part == "stones":
                write_stones(folder / "fields" / name, [speed[k] for speed in SPEEDS])
            else:
                OTHERS[part](folder / "fields" / name)
            series.setdefault(part, []).append((name, time))
    write_series(folder, series)
    return folder


def call(*words, **more):
    """In a process of its own, since a command without a display starts itself again."""
    return subprocess.run([sys.executable, conftest.ROOT / "postproc", *map(str, words)],
                          capture_output=True, text=True, check=False, **more)


def pixels(path):
    return np.round(255 * matplotlib.image.imread(path)[..., :3]).astype(int)


def count(picture, name):
    """Pixels of a part's colour, as a face towards the eye has it."""
    colour = np.round(255 * np.array(matplotlib.colors.to_rgb(actors.PLAIN[name])))
    return int(np.count_nonzero(np.abs(picture - colour).max(axis=2) <= 1))


def size_of(low, high):
    """(pixels per metre, [width, height] in pixels) of a picture of this box from the side."""
    _, _, half, size = framing.camera(np.array([low, high]), *scene.VIEWS["side"], scene.FRAME)
    return size[1] / (2 * half), size


def per_metre(low, high):
    return size_of(low, high)[0]


def test_all_parts_of_an_instant_are_in_one_picture_with_one_camera(run, tmp_path):
    done = call("still", run, "-o", tmp_path / "all.png")
    assert done.returncode == 0, done.stderr
    assert "load, 0.5 s, stones surfaces train ground: 57 cells" in done.stdout
    picture, scale = pixels(tmp_path / "all.png"), per_metre((0, 0, -1), (3, 0, 1.8))
    areas = {"ground": 3.0, "sleepers": 0.2, "bodies": 0.06, "rail": 3 * 0.172,
             "wheels": np.pi * 0.4**2}
    for name, area in areas.items():
        assert count(picture, name) == pytest.approx(area * scale**2, rel=0.06), name
    assert 0 < count(picture, "walls") < 5 * 3.6 * scale  # its edges only
    # The fastest and the slowest stone at the ends of the colours: balls, which are shaded.
    for colour, stones in (((253, 231, 37), 1), ((68, 1, 84), 2)):
        found = np.abs(picture[:, :-scene.BAR] - colour).max(axis=2) <= 12
        assert found.sum() > 0.07 * stones * np.pi * (RADIUS * scale)**2, colour


def test_files_are_drawn_together_and_the_first_is_coloured(run, tmp_path):
    files = [run / "fields" / f"load_000003_{part}.hdf" for part in ("ground", "surfaces")]
    done = call("still", *files, "-o", tmp_path / "two.png")
    assert done.returncode == 0 and "27 cells" in done.stdout, done.stderr
    picture = pixels(tmp_path / "two.png")
    assert count(picture, "ground") == 0 and count(picture, "sleepers") > 1000


def test_faces_of_solid_sleepers_are_drawn_once(tmp_path):
    files = [tmp_path / f"load_000003_{part}.hdf" for part in ("ground", "solids", "surfaces")]
    write_ground(files[0])
    write_surfaces(files[2])
    write_grid(files[1], brick(*SLEEPER), [np.arange(8)], HEXAHEDRON,
               {"displacement": (np.zeros((8, 3)), "m")})
    for given, drawn in ((files, "solids"), (files[::2], "sleepers")):
        done = call("still", *given, "-o", tmp_path / "sleeper.png")
        assert done.returncode == 0, done.stderr
        picture, scale = pixels(tmp_path / "sleeper.png"), per_metre((0, 0, -1), (3, 0, 0.8))
        other, = {"solids", "sleepers"} - {drawn}
        assert count(picture, drawn) == pytest.approx(0.2 * scale**2, rel=0.06)
        assert count(picture, other) == 0, "the sleeper is striped"


def test_contacts_are_coloured_by_their_force(tmp_path):
    path = tmp_path / "load_000003_contacts.hdf"
    write_grid(path, [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [[0, 1], [2, 3]], LINE,
               {"number": ([0, 1, 2, 3], "1")}, {"alpha": ([1, 2], "m"), "force": ([5, 8], "N")})
    survey = grids.Survey("contacts")
    survey.add({"contacts": path})
    assert survey.colouring().words() == "force from 5 to 8 N"
    assert survey.colouring("alpha").words() == "alpha from 1 to 2 m"


def test_surfaces_are_coloured_by_how_sleepers_moved(tmp_path):
    """Not by their number, which comes first in the file."""
    path = tmp_path / "load_000003_surfaces.hdf"
    moved = np.zeros((24, 3))
    moved[:12, 2] = -2e-3
    write_grid(path, np.concatenate([brick(*SLEEPER), brick(*PLATEN)]),
               np.concatenate([FACES, 8 + FACES]), TRIANGLE,
               cell_data={"number": ([1] * 12 + [2] * 12, "1"), "part": ([2] * 12 + [3] * 12, "1"),
                          "sleeper_displacement": (moved, "m")})
    survey = grids.Survey("surfaces")
    survey.add({"surfaces": path})
    assert survey.colouring().words() == "sleeper_displacement from 0 to 0.002 m"


def test_all_balls_of_a_stone_have_its_colour(tmp_path):
    """Stones are cells of several points, their arrays those of cells."""
    path = tmp_path / "load_000003_stones.hdf"
    write_grid(path, [[x, 0, 0.3] for x in (0, 1, 2)], [[0, 1], [2]], VERTICES,
               {"radius": ([0.3] * 3, "m")}, {"velocity": ([[0, 0, 1], [0, 0, 3]], "m/s")})
    done = call("still", path, "-o", tmp_path / "stones.png")
    assert done.returncode == 0 and "2 cells" in done.stdout, done.stderr
    picture, scale = pixels(tmp_path / "stones.png"), per_metre((-0.3, 0, 0), (2.3, 0, 0.6))
    for colour, balls in (((68, 1, 84), 2), ((253, 231, 37), 1)):
        found = np.abs(picture[:, :-scene.BAR] - colour).max(axis=2) <= 12
        area = np.pi * (0.3 * scale)**2
        assert 0.05 * balls * area < found.sum() < balls * area, colour  # balls are shaded


def test_parts_and_time_choose(run, tmp_path):
    done = call("still", run, "--time", 0.21, "--parts", "ground,stones,train", "-o",
                tmp_path / "chosen.png")
    assert done.returncode == 0 and "load, 0.2 s, ground stones: 4 cells" in done.stdout, done
    picture = pixels(tmp_path / "chosen.png")
    assert count(picture, "stones") > 500 and count(picture, "ground") == 0  # now coloured
    assert count(picture, "sleepers") == count(picture, "wheels") == 0


def test_section_along_the_track_is_cut_and_larger(run, tmp_path):
    done = call("still", run, "--x", 0, 1.5, "--parts", "stones,surfaces,ground", "-o",
                tmp_path / "section.png")
    assert done.returncode == 0, done.stderr
    picture, scale = pixels(tmp_path / "section.png"), per_metre((0, 0, -1), (1.5, 0, 0.8))
    assert scale > 200
    assert count(picture, "ground") == pytest.approx(1.5 * scale**2, rel=0.02)
    assert count(picture, "sleepers") == pytest.approx(0.5 * 0.2 * scale**2, rel=0.05)
    assert count(picture, "bodies") == 0  # the platen is beyond
    done = call("still", run, "--x", 5, 6, "-o", tmp_path / "section.png")
    assert done.returncode == 2 and "the parts are from 0 to 3 m" in done.stderr


def test_film_has_the_same_camera_and_colours_in_all_pictures(run, tmp_path):
    done = call("film", run, "-o", tmp_path / "film.gif", "--parts", "stones,ground")
    assert done.returncode == 0, done.stderr
    assert "3 instants from 0.1 to 0.5 s: stones, ground; stones coloured by velocity from 0 to " \
        "3.96 m/s, the fastest 1 % of the stones are beyond the colours, up to 4 m/s" in done.stdout
    scale, size = size_of((0, 0, -1), (3, 0, 0.55))
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 3 and film.size == tuple(size)
        frames = []
        for k in range(3):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB"), int))
    middle = (size[0] + scene.FRAME.left - scene.FRAME.right) / 2
    row = int((size[1] + scene.FRAME.above - scene.FRAME.below) / 2 - (0.3 - -0.225) * scale)
    stone = [[frame[row, int(middle + (x - 1.5) * scale)] for frame in frames]
             for x in (0.5, 1.5, 2.5)]
    # The same speed, the same colour, at all instants and of other stones; the ends of the colours
    # are those of the whole film.
    speeds = np.array(SPEEDS) / 3.96
    expected = 255 * matplotlib.colormaps["viridis"](speeds)[..., :3]
    assert np.abs(stone - expected).max() <= 12, stone
    bars = [frame[:-scene.ORIGIN_HIGH, -scene.BAR + 20:] for frame in frames]
    assert all(np.abs(bar - bars[0]).mean() < 3 for bar in bars)
    # Only the label and the stones differ.
    label = [frame[-scene.FRAME.below:, :200] for frame in frames]
    assert np.abs(label[0] - label[2]).max() > 100


def test_film_is_of_a_stage_or_of_times_and_has_so_many_pictures(run):
    found = instants.of_run(run)
    assert [each.time for each in found] == list(TIMES)
    assert [sorted(each.files) for each in found][0] == ["ground", "stones", "surfaces"]
    assert [each.time for each in instants.within(found, "load")] == [0.2, 0.5]
    assert [each.time for each in instants.within(found, None, (0.0, 0.2))] == [0.1, 0.2]
    assert instants.nearest(found, 0.16).time == 0.2 and instants.nearest(found).time == 0.5
    assert instants.thinned(list(range(9)), 3) == [0, 4, 8]
    assert instants.thinned(list(range(3)), 9) == [0, 1, 2]
    for stage, times, words in (("fil", None, "there are those of fill, load"),
                                ("load", (2, 3), "their times go from 0.2 to 0.5 s")):
        with pytest.raises(read.Unreadable, match=words):
            instants.within(found, stage, times)


@pytest.mark.parametrize("still", (True, False))
def test_runs_without_what_is_asked_for_are_refused(run, tmp_path, still):
    empty, command = tmp_path / "empty", ("still",) if still else ("film",)
    empty.mkdir()
    output = ("-o", tmp_path / ("p.png" if still else "p.gif"))
    for words, sentence in (((empty, ), "output.fields=true"),
                            ((tmp_path / "none", ), "does not exist"),
                            ((run, "--parts", "stones,bonds"), "no field files of bonds; it has"),
                            ((run, "--parts", "stone"), "the parts are stones, surfaces"),
                            ((run, "--limits", 2, -1), "2 must be below -1")):
        done = conftest.call(*command, *words, *output)
        assert done.returncode == 2 and sentence in done.stderr, (words, done)
    contacts = tmp_path / "contacts" / "fields"
    contacts.mkdir(parents=True)
    (contacts / "contacts.hdf.series").write_text('{"files": [{"name": "a", "time": 1}]}')
    done = conftest.call(*command, contacts.parent, *output)
    assert done.returncode == 2 and "--parts contacts" in done.stderr
    (contacts / "contacts.hdf.series").write_text("{")
    done = conftest.call(*command, contacts.parent, *output)
    assert done.returncode == 2 and "is damaged" in done.stderr


def test_files_that_do_not_belong_together_are_refused(run, tmp_path):
    fields, output = run / "fields", ("-o", tmp_path / "p.png")
    for words, sentence in (
            ((fields / "fill_000001_stones.hdf", fields / "load_000002_ground.hdf"),
             "different instants"),
            ((fields / "fill_000001_stones.hdf", "--time", 1), "give its folder"),
            ((run, fields / "fill_000001_stones.hdf"), "give one folder"),
            ((fields / "fill_000001_stones.hdf",) * 2, "twice")):
        done = conftest.call("still", *words, *output)
        assert done.returncode == 2 and sentence in done.stderr, (words, done)


def test_speed_colours_stones_only_if_it_varies():
    survey = grids.Survey("stones")
    survey.file = conftest.ROOT / "README.md"
    survey.ranges = {("radius", True): (1, 2), ("velocity", False): (0, 0)}
    choose, grids.unit_of = grids.unit_of, lambda *_: "m"
    try:
        assert survey.colouring().name == "radius"
        survey.ranges["velocity", False] = (0, 3)
        assert survey.colouring().limits == (0, 3) and survey.colouring().title() == "speed, m"
        assert survey.colouring("radius", (1, 5)).limits == (1, 5)
        survey.part = "ground"
        assert survey.colouring().name == "radius"
    finally:
        grids.unit_of = choose


def test_mp4_needs_ffmpeg_which_gets_every_picture(run, tmp_path):
    film, tools = tmp_path / "film.mp4", tmp_path / "tools"
    tools.mkdir()
    done = call("film", run, "-o", film, env={**os.environ, "PATH": str(tools)})
    assert done.returncode == 2 and "install it" in done.stderr and ".gif" in done.stderr
    encoder = tools / "ffmpeg"
    encoder.write_text('#!/bin/sh\nfor last; do :; done\nwc -c > "$last"\n')
    encoder.chmod(0o755)
    path = f"{tools}{os.pathsep}{os.environ['PATH']}"
    done = call("film", run, "-o", film, "--stage", "load", env={**os.environ, "PATH": path})
    assert done.returncode == 0, done.stderr
    wide, high = size_of((0, 0, -1), (3, 0, 1.8))[1]
    assert int(film.read_text()) == 2 * 3 * wide * high
    encoder.write_text("#!/bin/sh\necho no such encoder >&2; exit 1\n")
    done = call("film", run, "-o", film, "--frames", 1, env={**os.environ, "PATH": path})
    assert done.returncode == 2 and "no such encoder" in done.stderr


def write_results(folder, deck):
    with h5py.File(folder / "results.h5", "w") as file:
        file.attrs["deck"], file.attrs["version"] = deck, "0"


def test_transition_zones_keep_their_film(tmp_path, monkeypatch):
    write_results(tmp_path, 'dimension = "plane"\n[[stage]]\nname = "a"\ntrain = true\n')
    pictures = [np.full((5, 7, 3), grey, dtype=np.uint8) for grey in (0, 255)]
    monkeypatch.setattr(transition, "film_of", lambda *_: iter(pictures))
    film = tmp_path / "film.gif"
    assert conftest.call("film", tmp_path, "-o", film).returncode == 0
    with Image.open(film) as made:
        assert made.n_frames == 2 and made.size == (7, 5)
    for option in (("--fields",), ("--view", "top"), ("--stage", "a")):
        done = conftest.call("film", tmp_path, "-o", film, *option)
        assert done.returncode == 2 and "has no field files" in done.stderr
    done = conftest.call("film", tmp_path, tmp_path, "-o", film, "--fields")
    assert done.returncode == 2 and "shows one run" in done.stderr
    write_results(tmp_path, 'dimension = "space"\n[[stage]]\nname = "a"\ntrain = true\n')
    done = conftest.call("film", tmp_path, "-o", film)
    assert done.returncode == 2 and "has no field files" in done.stderr


def test_zone_without_its_own_film_has_that_of_its_fields(run, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "fields").symlink_to(run / "fields")
    write_results(folder, 'dimension = "plane"\n[[stage]]\nname = "a"\ntrain = true\n')
    done = call("film", folder, "-o", tmp_path / "film.gif")
    assert done.returncode == 0 and "since the transition zone has none" in done.stdout, done
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 3
