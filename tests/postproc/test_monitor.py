"""Condition monitoring: trains that are recognised, and the evaluation of a folder of passages."""
import csv
import os
import signal
import subprocess
import sys
import time

import conftest
import numpy as np
import pytest
from passing import RATE, axles, noisy, train

from trackbed_post.monitor import figures, passages, trains


@pytest.fixture(scope="module", name="library")
def library_of_trains():
    def reference(name, places):
        one = train(50.0, places)
        return trains.Reference.of_passage(name, one.displacement, RATE, 50.0)
    locomotive = np.concatenate([axles(1, 9.0, 19.0), 19.0 + axles(4)])
    return trains.Library([reference("six", axles(6)), reference("locomotive", locomotive)])


@pytest.mark.parametrize("speed", [23.4, 41.0, 58.7])
@pytest.mark.parametrize("seed", [1, 2])
def test_trains_are_recognised(library, speed, seed):
    one = train(speed, axles(6), impact=40.0)
    found = library.identify(noisy(one, 0.01, seed), RATE)
    assert found.name == "six" and found.similarity > trains.ACCEPTED
    assert found.speed == pytest.approx(speed, abs=0.1)
    assert found.direction == 0  # it looks the same from both ends


def test_direction_of_a_train_with_a_locomotive(library):
    places = np.concatenate([axles(1, 9.0, 19.0), 19.0 + axles(4)])
    assert library.identify(train(45.0, places).acceleration, RATE).direction == 1
    back = train(45.0, places[-1] - places[::-1])
    found = library.identify(back.acceleration, RATE)
    assert (found.name, found.direction) == ("locomotive", -1)


def test_unknown_train_is_unknown(library):
    freight = np.cumsum(np.tile([1.8, 5.2, 1.8, 4.1], 6))
    found = library.identify(train(40.0, freight).acceleration, RATE)
    assert found.name == "" and found.similarity < trains.ACCEPTED
    noise = np.random.default_rng(3).standard_normal(20000)
    assert library.identify(noise, RATE).name == ""


@pytest.fixture(name="folder")
def folder_of_passages(tmp_path):
    """Four passages, one of which is no signal."""
    folder = tmp_path / "passages"
    folder.mkdir()
    for number, speed in enumerate((30.0, 40.0, 50.0)):
        one = train(speed, axles(2), 2000.0)
        time = np.arange(len(one.acceleration)) / 2000.0
        np.savetxt(folder / f"p{number}.csv", np.column_stack([time, one.acceleration]),
                   delimiter=",", header="time_s,sleeper_m_s2", comments="")
    (folder / "broken.csv").write_text("time_s,sleeper_m_s2\n", encoding="utf-8")
    (folder / "passages.csv").write_text(
        "file,begin,speed_m_s,temperature_C\np0.csv,2026-05-03,30,12.5\np1.csv,2026-05-01,40,\n"
        "broken.csv,2026-05-02,40,\np2.csv,2026-05-04,,\n", encoding="utf-8")
    return folder


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_batch_continues_and_reports_what_failed(folder, tmp_path):
    table = tmp_path / "monitor.csv"
    assert passages.batch(folder, table, None) == 4
    whole = table.read_text(encoding="utf-8")
    rows = rows_of(table)
    assert [row["file"] for row in rows] == ["p0.csv", "p1.csv", "broken.csv", "p2.csv"]
    assert float(rows[0]["peak_mm"]) > 0.5 and rows[0]["temperature_C"] == "12.5"
    assert "no row of numbers" in rows[2]["remarks"]
    assert rows[3]["remarks"] == "the speed is neither given nor recognised"
    # Stopped within a line, with other workers; those that failed are tried again.
    table.write_bytes(whole[:whole.index("broken") + 20].encode() + b"\xc3")
    assert passages.batch(folder, table, None, workers=2) == 2
    assert table.read_text(encoding="utf-8") == whole
    (folder / "broken.csv").write_bytes((folder / "p1.csv").read_bytes())
    assert passages.batch(folder, table, None) == 2
    assert [row["peak_mm"] != "nan" for row in rows_of(table)] == [True, True, True, False]
    shown = figures.table_of(table)
    assert list(shown["file"]) == ["p1.csv", "broken.csv", "p0.csv", "p2.csv"]


def test_remarks_on_speed_and_length(folder, library, tmp_path):
    (folder / "passages.csv").write_text("file,speed_m_s\np0.csv,\np1.csv,45\n", encoding="utf-8")
    one = train(50.0, axles(3))
    short = trains.Library([trains.Reference.of_passage("three", one.displacement, RATE, 50.0)])
    passages.batch(folder, tmp_path / "a.csv", short)
    first, second = rows_of(tmp_path / "a.csv")
    assert first["train"] == "three" and "25 m shorter than its reference" in first["remarks"]
    assert "45 m/s is not that of the recognised train, 40 m/s" in second["remarks"]
    passages.batch(folder, tmp_path / "b.csv", library)
    assert rows_of(tmp_path / "b.csv")[0]["train"] == "unknown"


def test_passages_are_recognised_by_a_measured_one(folder, tmp_path):
    rows = "file,speed_m_s,reference\np0.csv,30,pair\np1.csv,,\np2.csv,,\n"
    (folder / "passages.csv").write_text(rows, encoding="utf-8")
    words = ("monitor", folder, "-o", tmp_path / "out", "--workers", "1")
    assert conftest.call(*words).returncode == 0
    found = rows_of(tmp_path / "out/monitor.csv")
    assert [row["train"] for row in found] == ["pair"] * 3
    assert [float(row["speed_m_s"]) for row in found] == pytest.approx([30, 40, 50], abs=0.1)
    for content, place, why in ((rows.replace("pair", "two"), "out", "the table of references"),
                                (rows.replace(",30,", ",33,"), "out", "the table of references"),
                                (rows.replace(",30,", ",,"), "new", "needs its speed_m_s"),
                                (rows.replace("pair", "unknown"), "new", "give another name")):
        (folder / "passages.csv").write_text(content, encoding="utf-8")
        failed = conftest.call(*words[:3], tmp_path / place)
        assert failed.returncode == 2 and why in failed.stderr, failed.stderr


def test_two_commands_do_not_write_into_one_folder(folder, tmp_path):
    (tmp_path / "out").mkdir()
    words = ("monitor", folder, "-o", tmp_path / "out", "--workers", "1")
    hold = ("import sys; sys.path.insert(0, sys.argv[1])\n"
            "from trackbed_post.monitor import command\n"
            "with command.alone(__import__('pathlib').Path(sys.argv[2])):\n"
            "    print('held', flush=True); sys.stdin.read()")
    with subprocess.Popen([sys.executable, "-c", hold, conftest.ROOT / "postproc",
                           tmp_path / "out"], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"held\n"
        ran = conftest.call(*words)
        assert ran.returncode == 2 and "another monitor command is writing there" in ran.stderr
        other.kill()  # as by a queue's limit
    assert conftest.call(*words).returncode == 0
    assert not (folder / ".lock").exists()


def test_changed_lines_are_evaluated_again(folder, tmp_path):
    words = ("monitor", folder, "-o", tmp_path / "out", "--workers", "1")
    lines = ["file,begin,speed_m_s", "p0.csv,2026-05-03,30", "p1.csv,2026-05-01,40"]
    for changed, new in ((lines, 2), (lines, 0), ([*lines[:2], "p1.csv,2026-05-01,41"], 1),
                         ([*lines[:2], "p1.csv,2026-06-01,41"], 1)):
        (folder / "passages.csv").write_text("\n".join(changed) + "\n", encoding="utf-8")
        ran = conftest.call(*words)
        assert f"{new} passages are new" in ran.stdout, ran.stdout + ran.stderr
    assert [(row["begin"], row["speed_m_s"]) for row in rows_of(tmp_path / "out/monitor.csv")] == [
        ("2026-05-03", "30"), ("2026-06-01", "41")]


def test_ctrl_c_ends_a_batch_that_the_same_command_continues(folder, tmp_path):
    for number in range(300):
        os.link(folder / "p0.csv", folder / f"copy_{number}.csv")
    lines = [f"copy_{number}.csv,30" for number in range(300)]
    (folder / "passages.csv").write_text("file,speed_m_s\n" + "\n".join(lines) + "\n")
    table = tmp_path / "out/monitor.csv"
    words = [sys.executable, conftest.ROOT / "postproc", "monitor", folder, "-o", tmp_path / "out",
             "--workers", "2"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True, start_new_session=True) as ran:
        end = time.monotonic() + 60
        while not (table.is_file() and table.read_bytes().count(b"\n") > 5):
            assert time.monotonic() < end and ran.poll() is None
            time.sleep(0.02)
        os.killpg(ran.pid, signal.SIGINT)  # as a terminal does
        _, errors = ran.communicate(timeout=60)
    assert ran.returncode == 3
    assert errors == "stopped; the same command continues it\n"
    done = rows_of(table)
    assert 5 <= len(done) < 300
    (folder / "passages.csv").write_text("file,speed_m_s\n" + "\n".join(lines[:len(done)])
                                         + "\n")
    assert conftest.call(*words[2:]).returncode == 0
    assert rows_of(table) == done


def test_command_line(folder, tmp_path):
    ran = conftest.call("monitor", folder, "-o", tmp_path / "out", "--workers", "1")
    assert ran.returncode == 0, ran.stderr
    assert "4 passages are new, 2 of 4 could not be evaluated" in ran.stdout
    for name in ("monitor.csv", "trends.png", "passage.png", "trends.csv"):
        assert (tmp_path / "out" / name).stat().st_size > 60
    for words, why in (((tmp_path / "none", "-o", tmp_path / "new"), "is no folder"),
                       ((folder, "--workers", "0", "-o", tmp_path / "out"), "at least 1"),
                       ((folder, "--wavelengths", "1", "1", "-o", tmp_path / "out"), "different"),
                       ((folder, "--wavelengths", "2", "0.2", "-o", tmp_path / "out"),
                        "choose another folder"),
                       ((folder, "-o", folder), "choose another folder")):
        failed = conftest.call("monitor", *words)
        assert failed.returncode == 2 and why in failed.stderr, failed.stderr
    for content, why in ((b"file,spead\np0.csv,3\n", "known are file, begin"),
                         (b"file,begin\np0.csv,1,2\n", "more fields than names"),
                         (b"file\np0.csv\np0.csv\n", "lists p0.csv more than once"),
                         ("file,begin\np0.csv,März\n".encode("latin-1"), "is not in UTF-8"),
                         (b"file\nbroken.csv\n", "no passage could be evaluated")):
        (folder / "passages.csv").write_bytes(content)
        failed = conftest.call("monitor", folder, "-o", tmp_path / why[:5])
        assert failed.returncode == 2 and why in failed.stderr, failed.stderr
