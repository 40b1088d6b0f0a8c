"""Bands of wavelength and twist of known profiles."""
import conftest
import made
import numpy as np
import pytest
import scipy.io
from trackbed_post import geometry, geometry_limits, read

STEP = 0.25
X = np.arange(0, 900.1, STEP)


def write_csv(path, **columns):
    rows = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    return path


def waves(amplitudes):
    """Sum of cosines: wavelength, m -> amplitude, m. Whole periods have no kink where the ends are
    continued by their mirror image."""
    return sum(a * np.cos(2 * np.pi * X / length) for length, a in amplitudes.items())


def test_each_band_holds_its_wavelength():
    level = geometry.Level("made", X, waves({9: 1e-3, 45: 4e-3, 100: 10e-3})[:, None])
    found = geometry.numbers(level)
    for name, (shortest, longest) in geometry.BANDS.items():
        low, high = 1 / longest, 1 / shortest
        # Gain of a Butterworth band pass of order 4; neighbouring bands overlap.
        mean_square = 0
        for length, amplitude in ((9, 1), (45, 4), (100, 10)):
            k = 1 / length
            damped = 1 + ((k**2 - low * high) / (k * (high - low)))**8
            mean_square += amplitude**2 / 2 / damped
        # The mirror image repeats the last sample: an error of half a step in 900 m.
        assert found[f"{name}, rail: standard deviation"][0] == pytest.approx(
            np.sqrt(mean_square), rel=5e-3)


def test_worst_window_is_where_the_track_is_rough():
    rough = 1e-3 * np.sin(2 * np.pi * X / 10) * np.where(np.abs(X - 600) < 100, 3, 1)
    spread, where, length = geometry.worst_window(X, rough, 200)
    assert spread == pytest.approx(3e-3 / np.sqrt(2), rel=0.01)
    assert where == pytest.approx(600, abs=1) and length == pytest.approx(200)
    spread, _, length = geometry.worst_window(X, rough, 1e4)
    assert spread == pytest.approx(rough.std()) and length == pytest.approx(900)


def test_ends_of_a_long_record_are_not_judged():
    # A step at the very end, which the filter turns into a wave of its own.
    level = geometry.Level("made", X, (1e-3 * np.cos(2 * np.pi * X / 10)
                                       + 5e-3 * (X > 895))[:, None])
    assert geometry.numbers(level)["D1, rail: largest deviation"][0] < 1.5
    assert 1e3 * np.abs(geometry.bands_of(level)["D1"]).max() > 3


def test_twist_of_a_ramp_and_of_a_wave():
    left = 2e-3 * X     # 2 mm/m
    level = geometry.Level("made", X, np.stack([left, 0 * X], axis=1))
    x, slope = geometry.twist(level, 3.0)
    assert slope == pytest.approx(2e-3)
    assert x[0] == pytest.approx(1.5)
    # Over a base b the wave a sin(k x) has the twist 2 a sin(k b/2)/b cos(k x) at its middle x; the
    # base of 3.1 m is no multiple of the step.
    k = 2 * np.pi / 12
    wave = geometry.Level("made", X, np.stack([1e-3 * np.sin(k * X), 0 * X], axis=1))
    for base in (3.0, 3.1):
        x, slope = geometry.twist(wave, base)
        # Straight lines between samples err by (k step)^2/8 = 0.2 % of the amplitude.
        assert slope == pytest.approx(2e-3 * np.sin(k * base / 2) / base * np.cos(k * x), abs=2e-6)
    with pytest.raises(read.Unreadable, match="must be at least the step"):
        geometry.twist(wave, 1000.0)


def test_rails_are_found_by_name_and_gaps_are_stated(tmp_path):
    x = np.delete(X[:400], slice(200, 240))
    one = geometry.load(write_csv(tmp_path / "a.csv", x_m=x, right_mm=np.sin(x), left_mm=0 * x))
    assert np.abs(one.height[:, 0]).max() == 0 and np.abs(one.height[:, 1]).max() > 0
    assert "1 gaps, the longest of 10.25 m at 49.75 m" in one.remarks[0]
    assert one.step == pytest.approx(STEP)
    coarse = geometry.Level("made", 5.0 * np.arange(100), np.zeros((100, 1)))
    assert "does not resolve wavelengths of 3 m" in geometry.why_not(coarse, "D1")
    assert set(geometry.bands_of(coarse)) == {"D2", "D3"}


def test_command_reads_files_and_names_bands_that_are_too_long(tmp_path):
    short = X[:200]
    one = write_csv(tmp_path / "rails.csv", x_m=short, left_mm=np.sin(short),
                    right_mm=-np.sin(short))
    ran = conftest.call("geometry", one, "-o", tmp_path / "out", "--twist-base", "3", "9")
    assert ran.returncode == 0, ran.stderr
    table = (tmp_path / "out/geometry.txt").read_text()
    assert "no D2: the record is shorter than 70 m" in table and "twist over 9 m" in table
    assert "largest standard deviation in 49.75 m" in table
    value = float(table.split("D1, left rail: standard deviation")[1].split()[0])
    assert value == pytest.approx(np.sin(short).std(), rel=0.05)   # a wave of 6.3 m
    assert (tmp_path / "out/geometry.png").is_file()


def test_a_recorded_level_becomes_an_irregularity(tmp_path):
    x = 100 + X[:400]
    wave = np.sin(0.5 * (x - 100)) + 0.02 * (x - 100) + 30
    gone = np.where((x > 120) & (x < 121), np.nan, wave)
    rows = [f"{a:.3f};{b:.6f};{-b:.6f}".replace(".", ",") for a, b in zip(x, gone)]
    path = tmp_path / "record.csv"
    path.write_text("x_m;left_mm;right_mm\n" + "\n".join(rows) + "\n", encoding="utf-8")
    ran = conftest.call("geometry", path, "-o", tmp_path / "out", "--irregularity")
    assert ran.returncode == 0, ran.stderr
    table = (tmp_path / "out/geometry.txt").read_text()
    assert "3 rows with values that are not numbers were left out" in table
    assert "1 gaps" in table
    left, right = (np.loadtxt(tmp_path / f"out/irregularity_{side}.csv", delimiter=",", skiprows=1)
                   for side in ("left", "right"))
    line = wave[0] + (wave[-1] - wave[0]) * (x - 100) / (x[-1] - 100)
    assert left[:, 0] == pytest.approx(x - 100)
    # A gap of 1 m is bridged by a line, which errs by at most (1 m)^2/8 of the curvature.
    assert left[:, 1] == pytest.approx(1e-3 * (wave - line), abs=1e-3 * 0.25 / 8 + 1e-8)
    assert right[:, 1] == pytest.approx(-left[:, 1], abs=1e-9)
    assert left[0, 1] == 0 and abs(left[-1, 1]) < 1e-9
    refused = conftest.call("geometry", path, path, "-o", tmp_path / "out", "--irregularity")
    assert refused.returncode == 2 and "give one file" in refused.stderr


def test_levels_are_read_from_mat_files(tmp_path):
    scipy.io.savemat(tmp_path / "record.mat", {"x_m": X[:400], "z_mm": np.sin(X[:400]),
                                               "note": np.arange(3.0)})
    level = geometry.load(tmp_path / "record.mat")
    assert level.height[:, 0] == pytest.approx(1e-3 * np.sin(X[:400]))
    scipy.io.savemat(tmp_path / "none.mat", {"z_mm": np.sin(X[:400])})
    with pytest.raises(read.Unreadable, match="must have a column x_m"):
        geometry.load(tmp_path / "none.mat")


@pytest.mark.parametrize("spread, speed, letter", [
    (0.74, 120, "A"), (0.76, 120, "B"), (1.09, 81, "B"), (1.7, 120, "C"), (2.6, 120, "E"),
    (0.64, 121, "A"), (0.74, 121, "B"), (1.3, 160, "C"), (1.8, 160, "D"), (1.9, 160, "E")])
def test_the_class_depends_on_spread_and_speed(tmp_path, spread, speed, letter):
    wave = waves({9: 1e-3 * spread * 2**0.5})  # in the middle of D1
    path = write_csv(tmp_path / "line.csv", x_m=X, z_m=wave)
    ran = conftest.call("geometry", path, "-o", tmp_path / "out", "--speed", speed)
    assert ran.returncode == 0, ran.stderr
    table = (tmp_path / "out/geometry.txt").read_text()
    stated = table.split(f"D1, rail: class of EN 13848-6 at {speed} km/h")[1].split()[0]
    assert stated == letter, table


@pytest.mark.parametrize("speed", [0, 301, float("nan")])
def test_limits_of_other_speeds_are_refused(tmp_path, speed):
    path = write_csv(tmp_path / "line.csv", x_m=X, z_m=waves({9: 1e-3}))
    ran = conftest.call("geometry", path, "-o", tmp_path / "out", "--speed", speed)
    assert ran.returncode == 2 and "above 0 and up to 300 km/h" in ran.stderr
    assert not (tmp_path / "out/geometry.txt").exists()


@pytest.mark.parametrize("speed", [80, 161])
def test_classes_of_other_speeds_are_left_out(tmp_path, speed):
    path = write_csv(tmp_path / "line.csv", x_m=X, z_m=waves({9: 1e-3}))
    ran = conftest.call("geometry", path, "-o", tmp_path / "out", "--speed", speed)
    assert ran.returncode == 0 and "class of" not in (tmp_path / "out/geometry.txt").read_text()


# A wave of 9 m and one of 40 m, each 1 mm above or below a limit of its band; of that of 40 m 15 %
# are in D1, where the last case needs 4 mm less.
@pytest.mark.parametrize("speed, size, beyond", [
    (80, {9: 29e-3}, {"D1": True}), (80, {9: 27e-3}, {"D1": False}),
    (81, {9: 27e-3}, {"D1": True}), (160, {9: 22e-3}, {"D1": False}),
    (161, {9: 21e-3, 40: 32e-3}, {"D1": True, "D2": False}),
    (300, {9: 11e-3, 40: 29e-3}, {"D1": False, "D2": True})])
def test_sections_beyond_the_limit_are_listed(tmp_path, speed, size, beyond):
    path = write_csv(tmp_path / "line.csv", x_m=X, z_m=waves(size))
    ran = conftest.call("geometry", path, "-o", tmp_path / "out", "--speed", speed)
    assert ran.returncode == 0, ran.stderr
    table = (tmp_path / "out/geometry.txt").read_text()
    for band, found in beyond.items():
        name = f"{band}, rail: sections above the immediate action limit"
        count = int(table.split(name)[1].split()[0])
        assert (count > 0) == found, table


def test_what_is_not_judged_is_stated(tmp_path):
    path = write_csv(tmp_path / "line.csv", x_m=X, left_mm=np.sin(X), right_mm=-np.sin(X))
    ran = conftest.call("geometry", path, "-o", tmp_path / "out", "--speed", 120, "--twist-base",
                        3, 30)
    assert ran.returncode == 0, ran.stderr
    table = (tmp_path / "out/geometry.txt").read_text()
    assert "judged from 25 to 875 m" in table
    assert "twist over 30 m: no limit is known (1.3 to 20 m)" in table
    assert "not verified against" in table and "given by --limits" in table
    assert "D2: no limit is known at this speed" in table


HEAD = "quantity,above_km_h,to_km_h,level,limit,unit\n"
OWN = HEAD + """# of line 1
D1,80,160,alert,3,mm
D1,80,160,intervention,4,mm
D1,80,160,immediate,30,mm
D1,0,80,alert,9,mm
D1 sd,80,160,alert,2,mm
twist 3 m,0,200,alert,1,mm/m
twist 5.0 m,0,200,immediate,0.5,mm/m
"""


def with_limits(folder, text, *words, speed=120):
    """`geometry` of a wave of 9 m and 3.5 mm of the left rail alone."""
    write_csv(folder / "line.csv", x_m=X, left_mm=1e3 * waves({9: 3.5e-3}), right_mm=0 * X)
    (folder / "limits.csv").write_text(text, encoding="utf-8")
    return conftest.call("geometry", folder / "line.csv", "-o", folder / "out", "--speed", speed,
                         "--limits", folder / "limits.csv", *words)


def rows_of(path):
    return [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()[1:]]


def test_limits_of_the_owner_take_the_place_of_the_known_ones(tmp_path):
    ran = with_limits(tmp_path, OWN)
    assert ran.returncode == 0, ran.stderr
    table = (tmp_path / "out/geometry.txt").read_text()

    def count(name):
        return int(table.split(f"{name}: sections above the ")[1].split("limit")[1].split()[0])
    assert table.count("sections above the alert limit") == 5  # two rails twice, and the twist
    # 850 m are judged; a wave of 9 m is above both limits once in each half.
    assert count("D1, left rail") == pytest.approx(2 * 850 / 9, abs=1)
    assert count("D1, right rail") == 0 and "limits at 120 km/h: limits.csv" in table
    assert "not verified" not in table and "D2: no limit is known" in table
    assert count("D1, left rail, sd in 200 m") == 1  # 3.5/sqrt 2 = 2.5 mm everywhere
    # Over a base of 5 m: 2 * 3.5 mm sin(5 pi/9)/5 m = 1.4 mm/m.
    assert count("twist over 5 m") == pytest.approx(2 * 895 / 9, abs=2)
    beyond = rows_of(tmp_path / "out/exceedances.csv")
    kinds = {(row[1], row[2]) for row in beyond}
    assert kinds == {("D1 left rail", "alert"), ("D1 left rail sd in 200 m", "alert"),
                     ("twist over 3 m", "alert"), ("twist over 5 m", "immediate")}
    assert all(float(row[7]) > float(row[3]) for row in beyond) and len(beyond) > 500
    assert not (tmp_path / "out/limits_template.csv").exists()


def test_the_figure_marks_limits_near_the_curves(tmp_path):
    with_limits(tmp_path, OWN)
    level = geometry.load(tmp_path / "line.csv")
    figure = geometry.draw([level], limits=geometry_limits.of_file(tmp_path / "limits.csv", 120))
    first, last = figure.axes[0], figure.axes[-1]
    marks = {tuple(line.get_ydata()) for line in first.lines if len(line.get_ydata()) == 2}
    assert marks == {(3, 3), (-3, -3), (4, 4), (-4, -4)}
    words = [text.get_text() for text in first.get_legend().get_texts()]
    assert "intervention limit: 4 mm" in words and first.get_ylim()[1] < 5
    assert "immediate action limit: 30 mm (beyond the picture)" in words
    assert "alert limit: 1 mm/m" in [text.get_text() for text in last.get_legend().get_texts()]
    assert first.get_title() == "Longitudinal level; limits at 120 km/h: limits.csv"
    geometry.plt.close(figure)


def test_the_template_gives_the_known_limits(tmp_path):
    path = write_csv(tmp_path / "line.csv", x_m=X, z_m=waves({9: 29e-3}))
    command = ["geometry", path, "-o", tmp_path / "out", "--speed", 81]
    assert conftest.call(*command).returncode == 0
    first = rows_of(tmp_path / "out/exceedances.csv")
    template = tmp_path / "out/limits_template.csv"
    assert "# D1,0,80,alert,,mm" in template.read_text(encoding="utf-8")
    ran = conftest.call(*command, "--limits", template)
    assert ran.returncode == 0, ran.stderr
    assert first and rows_of(tmp_path / "out/exceedances.csv") == first


def test_all_problems_of_a_file_of_limits_are_stated_at_once(tmp_path):
    ran = with_limits(tmp_path, HEAD + """D4,80,160,alert,3,mm
D1,160,80,alert,3,mm
D1,80,160,alarm,x,mm/m
D1,80,160,alert
twist 3 m,-1,160,alert,0,mm
D1,80,160,alert,5,mm
D1,100,200,alert,6,mm
D1,80,160,immediate,4,mm
""")
    assert ran.returncode == 2
    for words in ("line 2, column quantity: D4: must be one of D1, D2",
                  "line 3, column to_km_h: 80: must be larger than above_km_h, 160",
                  "line 4, column level: alarm: must be one of alert, intervention, immediate",
                  "line 4, column limit: x: must be a number above 0",
                  "line 4, column unit: mm/m: must be mm", "line 5: has 4 columns, not 6",
                  "line 6, column above_km_h: -1: must be a number of at least 0",
                  "line 6, column limit: 0: must be", "line 6, column unit: mm: must be mm/m",
                  "line 8, column above_km_h: overlaps the speeds of line 7",
                  "line 7, column limit: 5: the alert limit must not be above the immediate"):
        assert words in ran.stderr, words
    assert not (tmp_path / "out/geometry.txt").exists()


@pytest.mark.parametrize("text, speed, words", [
    (OWN, 250, "has no limit at 250 km/h"), (HEAD, 120, "no row with a limit"),
    ("quantity,limit\nD1,3\n", 120, "line 1: the columns must be quantity, above_km_h"),
    ("", 120, "the columns must be")])
def test_files_without_a_limit_are_refused(tmp_path, text, speed, words):
    ran = with_limits(tmp_path, text, speed=speed)
    assert ran.returncode == 2 and words in ran.stderr
    ran = conftest.call("geometry", tmp_path / "line.csv", "-o", tmp_path / "out", "--limits",
                        tmp_path / "limits.csv")
    assert ran.returncode == 2 and "give --speed" in ran.stderr


def test_limits_may_have_semicolons_and_decimal_commas(tmp_path):
    text = OWN.replace(",", ";").replace(";3;mm", ";3,4;mm")
    assert with_limits(tmp_path, text).returncode == 0
    assert geometry_limits.of_file(tmp_path / "limits.csv", 120).of["D1"] == {
        "alert": 3.4, "intervention": 4, "immediate": 30}


def test_a_section_has_its_ends_and_its_largest_value():
    x, values = np.arange(8.0), np.array([0, 2, -3, 1, 0, 4, 1, -2])
    assert geometry_limits.sections(x, values, 1.0) == [(1, 2, 3), (5, 5, 4), (7, 7, 2)]
    assert geometry_limits.sections(x, values, 5.0) == []


@pytest.mark.parametrize("base, speed, limit", [
    (3.0, 200, 7.0), (3.0, 201, 5.0), (20.0, 120, 4.0), (1.0, 120, None), (21.0, 120, None)])
def test_the_limit_of_twist_depends_on_base_and_speed(base, speed, limit):
    assert geometry_limits.twist_limit(base, speed) == limit


@pytest.mark.parametrize("columns, words", [
    ({"x_m": X[:50]}, "one or two of heights"),
    ({"x_m": X[:50], "z_g": X[:50]}, "must be lengths"),
    ({"x_m": X[:50], "z": X[:50]}, "its name must end with"),
    ({"x_m": X[:50][::-1], "z_mm": X[:50]}, "x ascending"),
    ({"x_m": X[:50], "z_mm": np.full(50, np.nan)}, "rows of numbers, x"),
    ({"x_m": X[:50], "a_mm": X[:50], "b_mm": X[:50]}, "must begin with left and right"),
    ({"x_m": X[:50], "z_mm": X[:50]}, "shorter than 25 m")])
def test_bad_files_are_refused(tmp_path, columns, words):
    path = write_csv(tmp_path / "bad.csv", **columns)
    ran = conftest.call("geometry", path, "-o", tmp_path / "out")
    assert ran.returncode == 2 and words in ran.stderr


def test_bed_has_no_path_of_a_wheel(tmp_path):
    with pytest.raises(read.Unreadable, match="no path of a rolling wheel"):
        geometry.load(made.write(tmp_path / "bed"))
