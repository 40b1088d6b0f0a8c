"""The report of one run and of two: complete, well formed and without other files."""
import base64
import fcntl
import html.parser
import json
import threading
import time

import conftest
import h5py
import numpy as np
import pytest
from made import store
from trackbed_post import kinds, progress, read, report
from trackbed_post import program as trackbed_program

VOID = {"meta", "img"}


class Page(html.parser.HTMLParser):
    """Text of each element, sources of images; fails if elements are not closed in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.text, self.sources = [], {}, []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.sources += [value for name, value in attrs if name in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        for tag in self.open[-1:]:
            self.text.setdefault(tag, []).append(data)


def made(folder, ended=True, deck='title = "5 < 6"\nmodel = "track"\n[track]\nlength = 20\n',
         scale=1.0):
    """A track under seat loads, as track_figures draws it; `scale`: of its envelopes."""
    folder.mkdir()
    time = np.arange(0, 0.2, 1e-3)
    ones = np.ones((len(time), 1))
    store(folder / "results.h5",
          {"history/time": (time, "s"), "sleepers/x": (np.array([4.2]), "m"),
           "rail/x": (np.array([4.2]), "m"),
           "history/sleeper/displacement": (-1e-3 * ones, "m"),
           "history/sleeper/acceleration": (0 * ones, "m/s2"),
           "history/sleeper/seat_force": (5e3 * ones, "N"),
           "envelope/x": (np.array([4.2, 4.8]), "m"),
           **{f"envelope/{name}": (scale * np.array([-1e-3, 2e-3]), "m") for name in (
               "rail/displacement_min", "rail/displacement_max", "sleeper/displacement_min",
               "sleeper/displacement_max", "sleeper/seat_force_max")}},
          deck=deck, version="0.1.0", build="commit abc", ranks=1)
    with h5py.File(folder / "results.h5", "r+") as file:
        file["envelope/x"].make_scale()
        file["envelope/rail/displacement_min"].dims[0].attach_scale(file["envelope/x"])
    if ended:
        (folder / "summary.json").write_text(json.dumps(
            {"deck": "a.toml", "model": "track", "finished": True, "ranks": 1,
             "simulated_time_s": 0.2, "wall_time_s": 1.5, "memory_mb_per_rank": 20.0,
             "warnings": ["wheels lost contact in 3 % & more"],
             "stages": [{"name": "passage", "time_s": 0.2, "wall_time_s": 1.25}],
             "timers": {"track": {"min_s": 1, "mean_s": 1.125, "max_s": 2}}}), encoding="utf-8")
    return folder


def program(folder, words):
    """A program that takes the place of trackbed."""
    path = folder / "trackbed"
    path.write_text(f"#!/bin/sh\n{words}\n", encoding="utf-8")
    path.chmod(0o755)
    return path


def write_report(folder, *runs):
    path = folder / "out/report.html"
    drawer = program(folder, 'echo "<svg>$1</svg>" > model.svg')
    return conftest.call("report", *runs, "-o", path, "--program", drawer), path


def test_report_of_two_runs_needs_no_other_file(tmp_path):
    ran, path = write_report(tmp_path, made(tmp_path / "one"), made(tmp_path / "two", ended=False))
    assert ran.returncode == 0, ran.stderr
    page = Page(path.read_text(encoding="utf-8"))
    cells = page.text["td"]
    for cell in ("finished", "still running, or failed (no summary.json)", "5 < 6",
                 "trackbed 0.1.0, commit abc", "1.5", "passage", "1.25", "track, s", "1.125"):
        assert cell in cells, cell
    assert any("one: wheels lost contact in 3 % & more" in text for text in page.text["p"])
    assert page.sources and all(source.startswith("data:image/") for source in page.sources)
    assert {"track: one", "track: two"} <= set(page.text["h3"])
    row = "sleeper at 4.2 m, largest downward displacement"
    assert any(row in text for text in page.text["pre"])


def test_a_report_begins_with_what_matters(tmp_path):
    """Results in short, then what the decks differ by; the progress is at the end unless a run
    computes."""
    other = 'title = "5 < 6"\nmodel = "track"\n[track]\nlength = 24\n'
    runs = [made(tmp_path / "one"), made(tmp_path / "two", deck=other)]
    events(runs[0])

    def headings():
        ran, path = write_report(tmp_path, *runs)
        assert ran.returncode == 0, ran.stderr
        page = Page(path.read_text(encoding="utf-8"))
        cells = page.text["td"]
        assert cells[cells.index("track.length"):][:3] == ["track.length", "20", "24"]
        return page.text["h2"]
    first = ["Differences of the decks", "Warnings", "Models", "Figures and numbers"]
    last = ["Stages of one", "Stages of two", "Cost, mean over the ranks"]
    assert headings() == [*first, *last, "Progress", "Effective input"]
    with open(runs[0] / ".lock") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert headings() == ["Progress", *first, *last, "Effective input"]


def test_sentences_of_the_figures_come_first(tmp_path, monkeypatch):
    run = made(tmp_path / "one")
    part = kinds.Part("track", [run], lambda folder: folder.sentences.extend(["A verdict."] * 2))
    monkeypatch.setattr(kinds, "parts_of", lambda *_: [part])
    ran, path = write_report(tmp_path, run)
    assert ran.returncode == 0, ran.stderr
    page = Page(path.read_text(encoding="utf-8"))
    assert page.text["h2"][0] == "In short" and page.text["p"].count("A verdict.") == 1
    assert page.text["p"][0] == "A verdict." and "Differences of the decks" not in page.text["h2"]


def test_equal_models_are_drawn_once(tmp_path):
    other = 'title = "other"\nmodel = "track"\n[track]\nlength = 20\n'
    ran, path = write_report(tmp_path, made(tmp_path / "one"), made(tmp_path / "two"),
                             made(tmp_path / "three", deck=other))
    assert ran.returncode == 0, ran.stderr
    page = Page(path.read_text(encoding="utf-8"))
    drawn = [source for source in page.sources if source.startswith("data:image/svg+xml;base64,")]
    # The fake program draws the same for both decks.
    assert len(drawn) == 1 and "one and two and three" in page.text["h3"]
    assert base64.b64decode(drawn[0].partition(",")[2]) == b"<svg>check</svg>\n"


def test_the_drawing_beside_the_results_needs_no_program(tmp_path):
    run = made(tmp_path / "one")
    (run / "model.svg").write_text("<svg>made by the run</svg>", encoding="utf-8")
    path = tmp_path / "report.html"
    ran = conftest.call("report", run, "-o", path)
    assert ran.returncode == 0, ran.stderr
    drawn = [source for source in Page(path.read_text(encoding="utf-8")).sources
             if source.startswith("data:image/svg+xml;base64,")]
    assert base64.b64decode(drawn[0].partition(",")[2]) == b"<svg>made by the run</svg>"


def test_a_model_whose_cell_is_gone_is_drawn_without_it(tmp_path):
    drawer = program(tmp_path, 'case "$*" in\n*bed.cell=*) echo "<svg/>" > model.svg;;\n'
                     '*) echo "bed.cell does not exist" >&2; exit 2;;\nesac')
    assert trackbed_program.drawing("a = 1", drawer) == "<svg/>\n"


def test_a_report_without_the_program_says_so(tmp_path):
    drawer = program(tmp_path, 'echo "no such key" >&2; exit 2')
    path = tmp_path / "report.html"
    ran = conftest.call("report", made(tmp_path / "one"), "-o", path, "--program", drawer)
    assert ran.returncode == 0 and any("the model was not drawn" in text and "no such key" in text
                                       for text in Page(path.read_text()).text["p"])
    ran = conftest.call("report", tmp_path / "one", "-o", path, "--program", tmp_path / "none")
    assert ran.returncode == 2 and "is not a program" in ran.stderr


def test_a_folder_far_from_any_program_has_a_report(tmp_path, monkeypatch):
    """A copy of a run, and of the package, on a computer without the program."""
    monkeypatch.setattr(trackbed_program, "__file__", str(tmp_path / "a/b/c/program.py"))
    monkeypatch.setenv("PATH", "")
    path = tmp_path / "report.html"
    assert conftest.call("report", made(tmp_path / "one"), "-o", path).returncode == 0
    stated = [text for text in Page(path.read_text()).text["p"] if "program" in text]
    assert stated == ["one: the model was not drawn: trackbed was not found (build/release, PATH): "
                    "give --program"]


def test_of_several_beds_the_first_is_beside_each_other(tmp_path):
    paths = [tmp_path / name for name in "abc"]
    parts = list(kinds.parts_of(paths, ["bed", "train", "laboratory"]))
    assert [(part.kind, [path.name for path in part.results]) for part in parts] == [
        ("bed", ["a", "b"]), ("bed", ["a", "c"]), ("train", ["a"]), ("train", ["b"]),
        ("train", ["c"]), ("laboratory", ["a", "b", "c"])]
    assert [part.results for part in kinds.parts_of(paths[:2], ["bed"])] == [paths[:2]]


def test_report_with_a_published_curve(tmp_path):
    published = tmp_path / "paper.csv"
    published.write_text("x_m,down_mm\n4.2,-1.0\n4.8,1.0\n")
    ran, path = write_report(tmp_path, made(tmp_path / "one"), "--over",
                             "envelope/rail/displacement_min", published)
    assert ran.returncode == 0, ran.stderr
    page = Page(path.read_text(encoding="utf-8"))
    assert any(text.startswith("envelope/rail/displacement_min and paper.csv") for text in
               page.text["h3"])


def test_curves_that_cannot_be_drawn_end_the_report(tmp_path):
    one = made(tmp_path / "one")
    for quantity, file, words in (("envelope/rail/displacement_min", "none.csv", "does not exist"),
                                  ("envelope/none", "paper.csv", "has no curve")):
        (tmp_path / "paper.csv").write_text("x_m,z_mm\n4.2,-1.0\n", encoding="utf-8")
        ran, path = write_report(tmp_path, one, "--over", quantity, tmp_path / file)
        assert ran.returncode == 2 and words in ran.stderr and not path.exists()


def test_a_run_without_ground_has_a_report(tmp_path):
    one = made(tmp_path / "one")
    path = one / "summary.json"
    whole = json.loads(path.read_text(encoding="utf-8")) | {"ground": {"elements": 0}}
    path.write_text(json.dumps(whole), encoding="utf-8")
    ran, report_of = write_report(tmp_path, one / "results.h5")
    assert ran.returncode == 0, ran.stderr
    cells = Page(report_of.read_text(encoding="utf-8")).text["td"]
    assert "finished" in cells and "elements of the ground" not in cells


def test_the_same_run_twice_has_two_folders(tmp_path):
    one = made(tmp_path / "one")
    assert conftest.call("compare", one, one, "-o", tmp_path / "c").returncode == 0
    assert all((tmp_path / "c" / name / "track.png").is_file() for name in ("1_one", "2_one"))


def test_figures_that_cannot_be_drawn_are_named(tmp_path):
    bed = 'dimension = "plane"\n[[stage]]\nname = "train"\ntrain = true\n'
    run = report.Run(made(tmp_path / "one", deck=bed))
    assert kinds.of_deck(run.deck) == ["transition", "train", "bed_below_train"]
    ran, path = write_report(tmp_path, run.folder)
    assert ran.returncode == 0 and "No further figures: " in path.read_text(encoding="utf-8")


@pytest.mark.parametrize("deck, found", [({"model": "ground"}, "bed"),
                                         ({"dimension": "space"}, "bed"),
                                         ({"model": "track_on_ground"}, "track"),
                                         ({"stage": [{"kind": "shear"}]}, "laboratory"),
                                         ({"stage": [{"train": True}]}, "train bed_below_train")])
def test_figures_follow_from_the_deck(deck, found):
    assert kinds.of_deck(deck) == found.split()


def test_runs_that_share_no_picture_have_folders_of_their_own(tmp_path):
    ran = conftest.call("compare", made(tmp_path / "a"), made(tmp_path / "b"), "-o", tmp_path / "c")
    assert ran.returncode == 0, ran.stderr
    for name in ("1_a", "2_b"):
        assert (tmp_path / "c" / name / "track.png").is_file()


def test_tracks_share_a_table_and_a_picture(tmp_path):
    """Numbers in columns, with the change of the second run; a third run has no change."""
    runs = [made(tmp_path / "soft"), made(tmp_path / "stiff", scale=0.5), made(tmp_path / "c")]
    ran = conftest.call("compare", *runs[:2], "-o", tmp_path / "two")
    assert ran.returncode == 0 and (tmp_path / "two/compare.png").is_file(), ran.stderr
    lines = (tmp_path / "two/compare.txt").read_text(encoding="utf-8").splitlines()
    assert lines[0].split() == "unit soft stiff change from soft to stiff".split()
    lowered = next(line for line in lines
                   if line.startswith("sleeper at 4.2 m, largest downward displacement"))
    assert lowered.split()[-4:] == ["mm", "1", "0.5", "-50.0%"]
    ran = conftest.call("compare", *runs, "-o", tmp_path / "three")
    heading = (tmp_path / "three/compare.txt").read_text(encoding="utf-8").splitlines()[0]
    assert ran.returncode == 0 and heading.split() == ["unit", "soft", "stiff", "c"]


def test_unlike_runs_and_other_files_are_refused(tmp_path):
    one, bed = made(tmp_path / "one"), made(tmp_path / "bed", deck='dimension = "plane"\n')
    ran, _ = write_report(tmp_path, one, bed)
    assert ran.returncode == 2 and "cannot be compared" in ran.stderr
    store(bed / "results.h5", {}, version="0")
    with pytest.raises(read.Unreadable, match="not a results.h5"):
        report.Run(bed)


def events(folder, *last):
    """A run that began 100 s ago, made progress and wrote a checkpoint."""
    now = time.time()
    common = {"stage": "fill", "stage_number": 1, "stages": 2, "windows_at_most": 200}
    lines = [{"event": "begin", "unix_time_s": now - 100, "window": 0, "time_s": 0, **common},
             *({"event": "progress", "unix_time_s": now - 100 + k, "window": k, "time_s": 0.01 * k,
                "speed": 0.01, "remaining_s": 3725, "kinetic_j": 10.0**-k, **common}
               for k in range(1, 6)),
             {"event": "checkpoint", "unix_time_s": now - 65, "window": 50, "time_s": 0.5,
              "file": "stage_fill.h5", **common}, *last]
    (folder / progress.FILE).write_text("".join(json.dumps(one) + "\n" for one in lines)
                                        + '{"event": "prog')
    (folder / ".lock").touch()


def test_progress_of_runs_that_ended(tmp_path):
    one = made(tmp_path / "one", ended=False)
    assert progress.facts_of(one) == {}
    events(one)
    facts = progress.facts_of(one)
    assert facts["run"] == "was killed" and "remaining" not in " ".join(facts)
    assert facts["stage"] == "1 of 2, fill (25 % of its windows)"
    assert facts["last checkpoint"].startswith("stage_fill.h5 at 0.5 s, 0:01:0")
    end = {"event": "end", "unix_time_s": time.time(), "outcome": "failed", "message": "lost",
           "stage": "fill", "stage_number": 1, "stages": 2, "time_s": 0.5}
    events(one, end)
    assert progress.facts_of(one)["run"] == "failed: lost"
    ran, path = write_report(tmp_path, one)
    assert ran.returncode == 0, ran.stderr
    page = Page(path.read_text(encoding="utf-8"))
    assert "Progress" in page.text["h2"] and "failed: lost" in page.text["td"]
    assert "http-equiv" not in path.read_text(encoding="utf-8")


def test_a_curve_over_a_figure_that_comes_later_is_a_remark(tmp_path):
    """The run computes at first; when it has ended, the figure is required."""
    one = made(tmp_path / "one", ended=False)
    events(one)
    (tmp_path / "a.csv").write_text("time_s,up_mm\n0,1\n1,2\n", encoding="utf-8")
    path = tmp_path / "report.html"
    choices = report.Choices(measured=(f"later={tmp_path / 'a.csv'}",))
    report.write_report([one], path, choices, every=1)
    text = path.read_text(encoding="utf-8")
    assert "Not drawn: later=" in text and "there is no figure later with lines" in text
    with pytest.raises(read.Unreadable, match="there is no figure later"):
        report.write_report([one], path, choices)
    assert "http-equiv" not in path.read_text(encoding="utf-8"), "the last report is written"


def test_the_report_follows_a_run_until_it_ends(tmp_path):
    one = made(tmp_path / "one", ended=False)
    events(one)
    path = tmp_path / "out/report.html"
    with open(one / ".lock") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        facts = progress.facts_of(one)
        assert facts["run"] == "computes" and "1:02:05" in facts.values()
        follower = threading.Thread(target=conftest.call, args=(
            "report", one, "-o", path, "--every", "0.2"))
        follower.start()
        for _ in range(200):
            if path.is_file():
                break
            time.sleep(0.1)
        text = path.read_text(encoding="utf-8")
        assert '<meta http-equiv="refresh" content="1">' in text and "still running" in text
        assert follower.is_alive()
    follower.join(30)
    assert not follower.is_alive()
    text = path.read_text(encoding="utf-8")
    assert "http-equiv" not in text and "was killed" in text
