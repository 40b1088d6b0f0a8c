"""Tests of track_figures.py on synthetic histories with known results."""
import matplotlib.pyplot as plt
import numpy as np
import pytest
from made import store
from trackbed_post import (geometry, read, receptance_figure, track_along, track_figures,
                           track_measures, write)


def made(sleepers=True):
    """Two wheels 10 m apart at 10 m/s, 50 and 60 kN, over a rail point at 5 m of 20 m of track; the
    force of the first one doubles after it has left."""
    time = np.linspace(0, 3, 301)
    x = np.stack([10 * time, 10 * time - 10], axis=1)
    force = np.where(x > 20, 2, 1) * [50e3, 60e3]
    dent = -1e-3 * np.exp(-(x - 5)**2).sum(axis=1)
    run = {"history/time": time, "history/wheel/x": x, "history/wheel/force": force,
           "history/rail/displacement": dent, "rail/x": np.array([5.0])}
    if sleepers:
        run |= {"sleepers/x": np.array([4.8]), "history/sleeper/displacement": 0.5 * dent,
                "history/sleeper/acceleration": np.full(301, -2.0),
                "history/sleeper/seat_force": -20e6 * dent}
    return {name: read.Quantity(values, "-", "made for a test") for name, values in run.items()}


def test_extremes_are_those_of_steps():
    extremes = {"wheel_force_max_n": 70e3, "wheel_force_min_n": 40e3, "rail_lowest_m": [-2e-3]}
    found = track_figures.numbers(made(), 20, extremes)
    assert found["largest wheel force"] == (70, "kN")
    assert found["least wheel force"] == (40, "kN")
    assert found["rail at 5 m, largest downward displacement"] == (2, "mm")


def test_wheels_count_only_on_the_track():
    found = track_figures.numbers(made(), 20)
    assert found["largest wheel force"] == (pytest.approx(60), "kN")
    assert found["least wheel force"] == (pytest.approx(50), "kN")


def test_forces_count_only_between_the_run_ins():
    """Forces on the nearly rigid rail before 4 m and beyond 16 m are omitted."""
    run = made()
    x, force = run["history/wheel/x"].values, run["history/wheel/force"].values
    force[(x < 4) | (x > 16)] = 500e3
    found = track_figures.numbers(run, 20, run_in=4)
    assert found["largest wheel force between the run-ins"] == (pytest.approx(60), "kN")
    assert found["scatter of wheel forces between the run-ins"][0] < 10
    assert track_figures.numbers(run, 20)["largest wheel force"] == (pytest.approx(500), "kN")
    deck = {"track": {"run_in": 4, "support": "none"}}
    assert track_figures.run_in_of(deck) == 0
    run["history/wheel/x"].values[:] = 2
    assert not any("wheel force" in name for name in track_figures.numbers(run, 20, run_in=4))


def test_wheels_of_two_rails_are_left_and_right():
    """Both wheels of the first four of five axles."""
    run = made(sleepers=False)
    x = 10 * run["history/time"].values[:, None] - np.repeat(2.0 * np.arange(5), 2)
    run["history/wheel/x"] = read.Quantity(x, "m", "made for a test")
    run["history/wheel/force"] = read.Quantity(50e3 + 0 * x, "N", "made for a test")
    run["rail/x"] = read.Quantity(np.array([5.0, 5.0]), "m", "made for a test")
    dent = np.repeat(run["history/rail/displacement"].values[:, None], 2, axis=1)
    run["history/rail/displacement"] = read.Quantity(dent, "m", "made for a test")
    figure = track_figures.draw(run, 20, {})
    assert [line.get_label() for line in figure.axes[0].lines] == [
        f"axle {axle}, {side}" for axle in range(1, 5) for side in ("left", "right")]
    plt.close(figure)


def test_the_first_wheel_is_one_that_rolls():
    """Axles of constant force before it are not drawn; they have no height."""
    run = made()
    height = np.stack([np.zeros(301), 1e-3 * np.sin(2 * np.pi * np.linspace(0, 3, 301))], axis=1)
    run["history/wheel/height"] = read.Quantity(height, "m", "made for a test")
    found = track_figures.numbers(run, 20)
    d1 = next(value for name, (value, _) in found.items() if "loaded rail" in name)
    x = run["history/wheel/x"].values[:, 1]
    path = track_measures.loaded_rail(x, height[:, 1], 0, 20)[1]
    assert d1 == pytest.approx(1e3 * path.std()) and d1 > 0.1
    figure = track_figures.draw(run, 20, {})
    assert [line.get_label() for line in figure.axes[0].lines] == ["axle 2"]
    plt.close(figure)
    run["history/wheel/height"] = read.Quantity(0 * height, "m", "made for a test")
    assert not any("loaded rail" in name for name in track_figures.numbers(run, 20))
    figure = track_figures.draw(run, 20, {})
    assert len(figure.axes[0].lines) == 2
    plt.close(figure)


def test_rail_sleeper_and_seat():
    found = track_figures.numbers(made(), 20)
    assert found["rail at 5 m, largest downward displacement"][0] == pytest.approx(1, rel=1e-3)
    down = found["sleeper at 4.8 m, largest downward displacement"][0]
    assert down == pytest.approx(0.5, rel=1e-3)
    assert found["seat at 4.8 m, largest load"][0] == pytest.approx(20, rel=1e-3)
    name = next(name for name in found if "acceleration" in name)
    # 100 rows per second cannot resolve 100 Hz, which the label states.
    assert "not filtered" in name and found[name][0] == pytest.approx(2)


@pytest.mark.parametrize("sleepers, panels", [(True, 5), (False, 2)])
def test_panels(sleepers, panels):
    """Four quantities below each other, with the train above those over time."""
    figure = track_figures.draw(made(sleepers), 20, {})
    assert len(figure.axes) == panels
    plt.close(figure)


def test_energies_are_in_a_panel_of_their_own():
    run = made()
    for name, values in (("track", 3.0), ("ground_elastic", 2.0)):
        run[f"history/energy/{name}"] = read.Quantity(np.full(301, values), "J", "made for a test")
    figure = track_figures.draw(run, 20, {})
    panel, = (axes for axes in figure.axes if axes.get_ylabel() == "energy, J")
    lines = {line.get_label(): line.get_ydata()[-1] for line in panel.lines
             if not line.get_label().startswith("_")}
    assert lines == {"rail, sleepers and springs": 3, "ground, elastic": 2}
    plt.close(figure)


def test_two_points_at_one_place_are_not_two_rails():
    run = made() | {"rail/x": read.Quantity(np.array([5.0, 5.0]), "m", "made for a test")}
    assert track_figures.places(run, "rail/x") == ["5 m, left", "5 m, right"]
    run["envelope/x"] = read.Quantity(np.array([4.8, 5.4]), "m", "made for a test")
    assert track_figures.places(run, "rail/x") == ["5 m", "5 m"]


def test_run_without_points_of_the_rail():
    run = made()
    del run["history/rail/displacement"], run["history/wheel/force"], run["history/wheel/x"]
    run["rail/x"] = read.Quantity(np.array([]), "m", "made for a test")
    assert not any(name.startswith("rail") for name in track_figures.numbers(run, 20))
    plt.close(track_figures.draw(run, 20, {}))
    assert track_figures.receptances(run) is None


def test_envelope():
    assert track_along.draw_envelope(made(), {}) is None  # results of an older version
    x = np.repeat([0.0, 0.6, 1.2], 2)
    along = {"x": x, "rail/displacement_min": -1e-3 - 1e-4 * np.arange(6),
             "rail/displacement_max": 1e-4 * np.arange(6)}
    along |= {"sleeper" + name[4:]: values for name, values in along.items() if name != "x"}
    along["sleeper/seat_force_max"] = 1e3 * np.arange(6)
    figure = track_along.draw_envelope(made() | {
        f"envelope/{name}": read.Quantity(values, "-", "made for a test")
        for name, values in along.items()}, {})
    rail, seat = figure.axes
    lines = {line.get_label(): line.get_ydata() for line in rail.lines + seat.lines}
    assert np.allclose(lines["rail, right"], [-1.1, -1.3, -1.5])
    assert np.allclose(lines["largest, left"], [0, 2, 4])
    plt.close(figure)


@pytest.mark.parametrize("wavelength, gain", [(3, 0.7071), (25, 0.7071), (40, 0.1110), (8, 1.0)])
def test_d1_passes_its_band(wavelength, gain):
    step, n = 0.05, 24000  # whole numbers of waves in 1200 m except for 25 m; checked in the middle
    x = step * np.arange(n)
    passed = track_measures.band(np.cos(2 * np.pi * x / wavelength), step)[n // 3:2 * n // 3]
    assert np.sqrt(2) * passed.std() == pytest.approx(gain, abs=2e-3)


def test_loaded_rail_is_that_between_the_places():
    x = np.linspace(-10, 110, 2401)
    height = -2e-3 + 1e-5 * x + 1e-3 * np.sin(2 * np.pi * x / 8)
    at, path = track_measures.loaded_rail(x, height, 0, 100)
    assert at[0] >= 0 and at[-1] <= 100
    assert path[400:-400].std() == pytest.approx(1e-3 / np.sqrt(2), rel=0.02)


def test_loaded_rail_of_a_train_that_brakes_and_stands():
    time = np.linspace(0, 8, 3001)
    x = np.where(time < 6, 40 * time - 40 / 12 * time**2, 120.0)  # to a stand at 120 m
    at, path = track_measures.loaded_rail(x, 1e-3 * np.sin(2 * np.pi * x / 8), 0, 120)
    assert np.ptp(np.diff(at)) < 1e-9 and at[-1] == 120
    assert path[600:-600].std() == pytest.approx(1e-3 / np.sqrt(2), rel=0.02)
    assert len(track_measures.loaded_rail(x[-100:], x[-100:], 0, 120)[0]) == 0


def hammered():
    """A mass on spring and damper under a half sine, by its closed form in the frequency domain."""
    step, n, mass, spring, damper = 1e-4, 20000, 100.0, 4e7, 1e4
    time = step * np.arange(n)
    force = np.where(time < 2e-3, 1e4 * np.sin(np.pi * time / 2e-3), 0.0)
    w = 2 * np.pi * np.fft.rfftfreq(n, step)
    exact = 1 / (spring + 1j * w * damper - mass * w**2)
    rail = np.fft.irfft(np.fft.rfft(force) * exact, n)
    run = {"history/time": time, "history/rail/force": force, "rail/x": np.array([5.0]),
           "history/rail/displacement": -rail}
    return {name: read.Quantity(values, "-", "made for a test") for name, values in run.items()}


def test_receptance_of_an_impact():
    run = hammered()
    frequency, found = track_figures.receptances(run)
    assert frequency[0] == pytest.approx(0.5) and 500 < frequency[-1] < 1000
    exact = 1 / (4e7 + 2j * np.pi * frequency * 1e4 - 100 * (2 * np.pi * frequency)**2)
    assert np.allclose(found["5 m"], exact, rtol=1e-6)
    assert len(receptance_figure.table(frequency, found).splitlines()) == len(frequency) + 1
    for figure in (receptance_figure.draw(frequency, found),
                   track_figures.draw(run, 20, {})):
        plt.close(figure)
    assert "rail at 5 m, largest downward displacement" in track_figures.numbers(run, 20)
    assert track_figures.receptances(made()) is None


def test_two_rails_are_distinguished():
    run = made() | {"rail/x": read.Quantity(np.array([5.0, 5.0]), "m", "both rails")}
    run["history/rail/displacement"] = read.Quantity(
        np.outer(run["history/rail/displacement"].values, [1, 2]), "m", "left, right")
    found = track_figures.numbers(run, 20)
    assert found["rail at 5 m, right, largest downward displacement"][0] == pytest.approx(
        2 * found["rail at 5 m, left, largest downward displacement"][0])


def test_runs_of_a_bed_are_refused(monkeypatch):
    monkeypatch.setattr(read, "datasets", lambda _: {"history/time": None})
    with pytest.raises(read.Unreadable) as refused:
        track_figures.loaded("somewhere")
    assert refused.value.code == 2


def test_sleepers_extremes_are_those_of_steps():
    run = made() | {name: read.Quantity(np.array(values), "-", "made for a test")
                    for name, values in {
                        "envelope/x": [4.2, 4.8, 5.4],
                        "envelope/sleeper/displacement_min": [-1e-3, -7e-4, -2e-3],
                        "envelope/sleeper/seat_force_max": [1e3, 23e3, 3e3],
                        "extreme/rail/displacement": [-1.5e-3]}.items()}
    found = track_figures.numbers(run, 20)
    assert found["sleeper at 4.8 m, largest downward displacement"] == (pytest.approx(0.7), "mm")
    assert found["seat at 4.8 m, largest load"] == (pytest.approx(23), "kN")
    assert found["rail at 5 m, largest downward displacement"] == (pytest.approx(1.5), "mm")


def test_sleepers_extremes_on_two_rails():
    run = made()
    for name in ("displacement", "acceleration", "seat_force"):
        run[f"history/sleeper/{name}"] = read.Quantity(np.zeros((301, 2)), "-", "left, right")
    for name, values in {"sleepers/x": [4.8, 4.8], "envelope/x": [4.2, 4.2, 4.8, 4.8],
                         "envelope/sleeper/displacement_min": [0, 0, -1e-3, -2e-3]}.items():
        run[name] = read.Quantity(np.array(values), "-", "made for a test")
    found = track_figures.numbers(run, 20)
    down = "largest downward displacement"
    assert found[f"sleeper at 4.8 m, left, {down}"] == (pytest.approx(1), "mm")
    assert found[f"sleeper at 4.8 m, right, {down}"] == (pytest.approx(2), "mm")


def test_seat_loads_have_no_rail_and_no_forces_on_it(tmp_path, monkeypatch):
    run = {name: one.values for name, one in made().items() if "wheel" not in name}
    run |= {"envelope/x": np.array([4.2, 4.8]), "envelope/rail/displacement_min": np.zeros(2),
            "envelope/rail/displacement_max": np.zeros(2),
            "envelope/sleeper/displacement_min": np.array([-1e-3, -2e-3]),
            "envelope/sleeper/displacement_max": np.zeros(2),
            "envelope/sleeper/seat_force_max": np.array([1e3, 2e3])}
    store(tmp_path / "results.h5", {name: (values, "-") for name, values in run.items()},
          deck='[track]\nlength = 20\n[passage]\nloaded_by = "seats"\n', version="0.0.0", ranks=1)
    drawn = {}
    folder = write.Folder(tmp_path / "figures")
    monkeypatch.setattr(folder, "picture", lambda name, figure: drawn.update({name: figure}))
    track_figures.draw_into([tmp_path], folder)
    assert [len(drawn[name].axes) for name in ("track", "envelope")] == [3, 2]
    labels = [line.get_label() for figure in drawn.values() for panel in figure.axes
              for line in panel.lines]
    printed = folder.tables[0]
    assert "sleeper at 4.8 m, largest downward displacement" in printed
    assert not any("rail" in word for word in (printed, *labels))
    assert all(panel.lines for figure in drawn.values() for panel in figure.axes)


DECK = {"model": "track", "track": {"length": 150.0, "run_in": 6.0},
        "train": {"vehicles": ["coach"], "speed": 10.0}}


def rolled():
    """A wheel whose path has waves of 10 m, with a rise of 5 mm in the last run-in."""
    x = np.linspace(0, 150, 3001)
    path = 1e-3 * np.sin(2 * np.pi * x / 10) + 5e-3 * np.clip(x - 146, 0, 1)
    columns = {"history/time": x / 10, "history/wheel/x": x[:, None], "rail/x": np.array([5.0]),
               "history/wheel/force": np.full((3001, 1), 50e3),
               "history/wheel/height": path[:, None]}
    return {name: read.Quantity(values, "m", "made for a test")
            for name, values in columns.items()}


def test_the_level_of_the_loaded_rail_is_that_of_the_command_geometry(monkeypatch):
    run = rolled()
    found = track_figures.numbers(run, 150.0, run_in=6.0)
    name = "level of the loaded rail under the first wheel between the run-ins, D1 (3 to 25 m), " \
        "standard deviation"
    monkeypatch.setattr(geometry.read, "origin", lambda folder: ("", DECK))
    monkeypatch.setattr(geometry.read, "datasets", lambda folder: run)
    level = geometry.of_run("made")
    assert found[name] == geometry.numbers(level)["D1, rail: standard deviation"]
    assert found[name][0] == pytest.approx(1 / np.sqrt(2), rel=0.01)


def shaded(figure):
    """The shaded stretches of the panels that have any, m."""
    return [sorted((one.get_extents().transformed(panel.transData.inverted()).intervalx.tolist()
                    for one in panel.patches)) for panel in figure.axes if panel.patches]


def test_run_ins_are_shaded_where_numbers_leave_them_out():
    """Over x in track.png, envelope.png and compare.png."""
    x, ends = np.linspace(0, 150, 51), [[0, 6], [144, 150]]
    along = {f"envelope/{name}": read.Quantity(values, "-", "made for a test") for name, values in (
        ("x", x), ("rail/displacement_min", -1e-3 + 0 * x), ("rail/displacement_max", 0 * x),
        ("sleeper/seat_force_max", 1e3 + 0 * x))}
    run = rolled() | along
    bridge = DECK | {"track": {**DECK["track"], "support": "none"}}
    for deck, each in ((DECK, ends), (bridge, None)):
        for figure, count in ((track_figures.draw(run, 150, deck), 1),
                              (track_along.draw_envelope(run, deck), 2),
                              (track_along.draw_beside("ab", [run, run], [deck, deck]), 2)):
            found = shaded(figure)
            assert len(found) == (count if each else 0)
            assert all(np.allclose(one, ends) for one in found)
            words = [text.get_text() for panel in figure.axes if panel.get_legend()
                     for text in panel.get_legend().get_texts()]
            assert ("run-in, not counted" in words) == bool(each)
    plt.close("all")


def test_no_axle_is_hidden_and_the_title_names_the_train():
    """All four have the same forces at the same places: the later ones are narrower."""
    run = rolled()
    for name in ("x", "force", "height"):
        values = run[f"history/wheel/{name}"].values.repeat(4, axis=1)
        run[f"history/wheel/{name}"] = read.Quantity(values, "", "")
    figure = track_figures.draw(run, 150, DECK)
    widths = [line.get_linewidth() for line in figure.axes[0].lines]
    assert len(widths) == 4 and (np.diff(widths) < -0.5).all()
    assert figure._suptitle.get_text() == "Track without a bed: coach, 36 km/h"
    plt.close(figure)
