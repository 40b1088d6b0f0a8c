"""Curves of CSV files over the figures of runs."""
import csv

import conftest
import matplotlib.pyplot as plt
import numpy as np
import pytest
from test_report import made as track_alone
from trackbed_post import overlays, panels, read, write


def two_panels():
    """Panels of mm and kN over time, which share its axis."""
    figure, (upper, lower) = plt.subplots(2, 1, sharex=True)
    for panel, label in ((upper, "displacement\n(mm, up)"), (lower, "seat load, kN")):
        panel.plot([0, 1], [1, 2], label="run")
        panel.set_ylabel(label)
    lower.set_xlabel("time since the passage began (s)")
    upper.legend()
    return figure


def file_of(folder, text, name="track.csv"):
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


@pytest.mark.parametrize("label, found", [
    ("displacement (mm, up)", (1e-3, "m")), ("level under the train, mm down", (1e-3, "m")),
    ("stiffness of the support (kN/mm)", (1e6, "N/m")), ("passing (% of mass)", (0.01, "1")),
    ("acceleration (m/s2) 100 Hz Butterworth, zero phase", (1.0, "m/s2")),
    ("acceleration, m/s^2", (1.0, "m/s2")), ("s = (s1 + s3)/2 (kPa)", (1e3, "Pa")),
    ("receptance, m/N", (1.0, "m/N")), ("level, dB re 1e-06 m/s2", (1.0, "dB re 1e-06 m/s2")),
    ("bulk density (kg/m3)", (1.0, "kg/m3")), ("porosity (-)", (1.0, "1")),
    ("void ratio", (1.0, "1")), ("time, s", (1.0, "s")), ("acceleration (g)", (9.80665, "m/s2"))])
def test_units_are_those_that_axes_state(label, found):
    assert overlays.unit_of_label(label) == found


def test_columns_are_drawn_over_the_panels_with_their_units(tmp_path):
    path = file_of(tmp_path, "time_ms,up_m,load_N\n0,1e-3,1000\n500,2e-3,3000\n2000,9,9\n")
    over = overlays.Overlays([f"sleepers={path}"])
    figure = two_panels()
    over("sleepers", figure)
    over.require_drawn()
    upper, lower = figure.axes
    for panel, values, name in ((upper, [1, 2], "up_m"), (lower, [1, 3], "load_N")):
        line = panel.lines[1]
        assert line.get_label() == f"track, {name}"
        assert np.allclose(line.get_xdata()[:2], [0, 0.5])
        assert np.allclose(line.get_ydata()[:2], values)
        assert np.isnan(line.get_ydata()[2])  # beyond the figure's time
    assert [text.get_text() for text in upper.get_legend().get_texts()] == ["run", "track, up_m"]
    assert [text.get_text() for text in lower.get_legend().get_texts()] == ["track, load_N"]
    plt.close(figure)


def problem_of(name, figure, text):
    over = overlays.Overlays([text])
    over(name, figure)
    plt.close(figure)
    with pytest.raises(read.Unreadable) as why:
        over.require_drawn()
    return str(why.value)


def test_what_cannot_be_drawn_is_said(tmp_path):
    path = file_of(tmp_path, "time_s,up_mm\n0,1\n1,2\n")
    assert "no figure sleper with lines, did you mean sleepers? The figures with lines are " \
        "sleepers" in problem_of("sleepers", two_panels(), f"sleper={path}")
    other = file_of(tmp_path, "x_m,up_mm\n0,1\n1,2\n", "place.csv")
    assert "no panel of sleepers has these units: panel 1, displacement (mm, up) over time" in \
        problem_of("sleepers", two_panels(), f"sleepers={other}")
    assert "panel 2 of sleepers has other units" in \
        problem_of("sleepers", two_panels(), f"sleepers:2={path}")
    later = file_of(tmp_path, "time_s,up_mm\n5,1\n6,2\n", "later.csv")
    assert "beyond the figure" in problem_of("sleepers", two_panels(), f"sleepers={later}")
    twice = two_panels()
    twice.axes[1].set_ylabel("settlement, mm")
    assert "Choose one with sleepers:NUMBER=" in problem_of("sleepers", twice, f"sleepers={path}")
    for text in ("sleepers", f"={path}", f"sleepers:0={path}", f"sleepers:a={path}"):
        with pytest.raises(read.Unreadable, match="give FIGURE=FILE.csv"):
            overlays.of_text(text)


def test_an_axis_with_an_unknown_unit_takes_no_curve_without_unit(tmp_path):
    path = file_of(tmp_path, "frequency_Hz,level_1\n0,1\n1,2\n")
    figure, panel = plt.subplots()
    panel.plot([0, 1], [1, 2])
    panel.set(xlabel="frequency, Hz", ylabel="third octaves, dB re 1e-06 m/s2")
    assert "no panel of octaves has these units" in problem_of("octaves", figure,
                                                               f"octaves={path}")


def test_a_panel_is_chosen_by_its_number(tmp_path):
    path = file_of(tmp_path, "time_s,up_mm\n0,1\n1,2\n")
    over, figure = overlays.Overlays([f"sleepers:2={path}"]), two_panels()
    figure.axes[1].set_ylabel("settlement, mm")
    over("sleepers", figure)
    over.require_drawn()
    assert [len(panel.lines) for panel in figure.axes] == [1, 2]
    plt.close(figure)


def test_figures_and_report_lay_curves_over_a_figure(tmp_path):
    run = track_alone(tmp_path / "one")
    path = file_of(tmp_path, "time_s,load_kN\n0.05,4.9\n0.1,5.1\n")
    ran = conftest.call("figures", run, "-o", tmp_path / "f", "--measured", f"track={path}",
                        "--format", "png,csv")
    assert ran.returncode == 0, ran.stderr
    with (tmp_path / "f/track_lines.csv").open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["line"] == "track"]
    assert [(row["y axis"], row["x"], row["y"]) for row in rows] == [
        ("seat load, kN", "0.05", "4.9"), ("seat load, kN", "0.1", "5.1")]
    page = tmp_path / "report.html"
    assert conftest.call("report", run, "-o", page, "--measured",
                         f"track={path}").returncode == 0
    page.unlink()
    ran = conftest.call("report", run, "-o", page, "--measured", f"trak={path}")
    assert ran.returncode == 2 and "did you mean track?" in ran.stderr
    assert "Not drawn: trak=" in page.read_text(encoding="utf-8"), "the rest is not lost"


def test_a_folder_draws_over_each_figure_before_it_is_written(tmp_path):
    seen = []
    folder = write.Folder(tmp_path, over=lambda name, figure: seen.append((name, len(figure.axes))))
    folder.picture("two", two_panels())
    assert seen == [("two", 2)] and (tmp_path / "two.png").is_file()


def test_other_commands_lay_curves_over_their_figures_too(tmp_path):
    run = track_alone(tmp_path / "one")
    path = file_of(tmp_path, "x_m,z_mm\n4.2,-0.9\n4.8,1.5\n")
    words = ("curve", "envelope/rail/displacement_min", run, "-o", tmp_path / "c", "--format",
             "csv", "--measured")
    ran = conftest.call(*words, f"curve={path}")
    assert ran.returncode == 0, ran.stderr
    assert ",track,4.2,-0.9," in (tmp_path / "c/curve_lines.csv").read_text(encoding="utf-8")
    ran = conftest.call(*words, f"curves={path}")
    assert ran.returncode == 2 and "did you mean curve?" in ran.stderr


@pytest.mark.parametrize("place", [panels.legend_above, panels.legend_below, None])
def test_the_legend_stays_where_it_was(tmp_path, place):
    """`place` None: to the right of the panel, and of what another panel shows."""
    figure = two_panels()
    upper, lower = figure.axes
    lower.plot([0, 1], [2, 3], label="other")
    if place:
        place(upper, columns=3)
    else:
        upper.legend(*lower.get_legend_handles_labels(), loc="center left", bbox_to_anchor=(1, 0.5))
    words = [text.get_text() for text in upper.get_legend().get_texts()]
    path = file_of(tmp_path, "time_s,up_mm\n0,1\n1,2\n")
    overlays.Overlays([f"sleepers={path}"])("sleepers", figure)
    figure.canvas.draw()
    legend, inside = upper.get_legend(), upper.get_window_extent()
    box = legend.get_window_extent()
    assert [text.get_text() for text in legend.get_texts()] == [*words, "track"]
    assert box.y0 >= inside.y1 - 1 or box.y1 <= inside.y0 + 1 or box.x0 >= inside.x1 - 1
    assert legend.get_frame_on() == (place is None)
    plt.close(figure)
