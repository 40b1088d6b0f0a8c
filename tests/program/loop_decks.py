#!/usr/bin/env python3
"""How jobs/handover.py reads its deck: what is refused before anything is written, and that the
decks of its rounds have the same values, however the deck is written.

    loop_decks.py PROGRAM SOURCE_FOLDER FOLDER
"""
import pathlib
import re
import shutil
import sys
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import run_checks  # noqa: E402
from loops import Loops  # noqa: E402

STAGE = '\n[[stage]]\nname = "{}"\nkind = "run"\nduration = 0.1\n'
TRAIN = '\n[[stage]]\nname = "train"\n'


def refused_decks(text):
    """(Deck, message) for decks that cannot be divided into bed and train."""
    before, behind = text.split(TRAIN)
    yield (text + TRAIN.replace("train", "again") + behind,
           "the deck has several (stages train, again): keep one of them")
    yield (before + STAGE.format("rest") + STAGE.format("wait") + TRAIN + behind,
           "the rounds would omit the stages rest, wait: after the stage from which the rounds "
           "begin, the deck may have only train (train = true); choose a later stage, or remove "
           "rest, wait")
    yield text + STAGE.format("late"), "the rounds would omit the stages late"
    yield (re.sub(r"\[handover\][^[]*", "", text),
           "[handover] must give `after`, the name of a stage")
    yield text + "duration = 0.5\n", "duration = 0.5 is not allowed in the loop"
    yield text + "cycles = 3\n", "cycles = 3 is not allowed in the loop"
    yield text + "cycles = 1\nsettlement = 1e-4\n", "settlement = 0.0001 is not allowed in the loop"
    yield text.replace("first = 0.6 ", "# first "), "[sleepers] must give first"
    yield (text.replace("history_interval = 5e-4", "history_interval = 0.01"),
           "output.history_interval = 0.01 s: must be at most 0.005 s, or support stiffnesses "
           "cannot be measured")
    yield text.replace("speed = 60 ", "speeed = 60 "), "did you mean train.speed?"


def check_refused(loops, text):
    deck, kept = loops.folder / "refused.toml", loops.folder / "kept"
    csv = kept / "handover.csv"
    kept.mkdir()
    csv.write_text("round\n", encoding="utf-8")
    for changed, words in refused_decks(text):
        deck.write_text(changed, encoding="utf-8")
        for more in ([], ["--force"]):
            loops.ends(2, words, deck, kept, *more)
        if list(kept.iterdir()) != [csv] or csv.read_text(encoding="utf-8") != "round\n":
            raise SystemExit(f"{words}: refused, but the folder has {list(kept.iterdir())}")
    deck.write_text(text, encoding="utf-8")
    loops.ends(2, "handover.csv is not a table of this loop", deck, kept)
    loops.ends(2, "there_is_no.h5 does not exist", deck, loops.folder / "new", "--start",
               loops.folder / "there_is_no.h5")
    if (loops.folder / "new").exists():
        raise SystemExit("a missing state must be reported before anything is written")


def made(folder):
    """Values of the decks that a loop has written."""
    return {name: tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))
            for name in ("bed", "round_0/load_test", "round_0/track", "round_0/trains")}


def check_written_otherwise(loops, text):
    """Dotted keys, inline tables and inline lists of tables."""
    pad = '[pad]\nstiffness = 120e6              # N/m, one rail seat\ndamping = 25e3'
    otherwise = text
    for old, new in ((r'\[rail\]\nsection = "60E1"\n', ""), (re.escape(pad), ""),
                     (r"\[platen\]\n.*\n.*\n", ""),
                     (r'title = ', 'rail.section = \'60E1\'\n"pad".stiffness = 1.2e8\n'
                      'pad.damping = 25_000.0\n'
                      "platen = { pressure = 2e5, speed = 0.4 }\ntitle = "),
                     (r"(?s)\n\[\[ground\.layer\]\].*\n# The rail", "\n# The rail"),
                     (r"\[ground\]", '[ground]\nlayer = [{ name = "surface", thickness = 0.6, '
                      "young = 500e6, poisson = 0.33, density = 1950 },\n"
                      '{ name = "subgrade", thickness = 1.4, young = 150e6, poisson = 0.35, '
                      "density = 1850 }]")):
        otherwise = re.sub(old, new, otherwise, count=1)
    if tomllib.loads(otherwise) != tomllib.loads(text):
        raise SystemExit("the test must change the notation only, not values")
    for name, one in (("plain", text), ("otherwise", otherwise)):
        (loops.folder / f"{name}.toml").write_text(one, encoding="utf-8")
        loops.ends(0, "", loops.folder / f"{name}.toml", loops.folder / name, "--rounds", "1")
    if made(loops.folder / "plain") != made(loops.folder / "otherwise"):
        raise SystemExit("another notation must give the same decks")
    bed = made(loops.folder / "plain")["bed"]
    deck = tomllib.loads(text)
    if bed["stage"] != deck["stage"][:-1] or bed["ground"] != deck["ground"] or "rail" in bed:
        raise SystemExit(f"the bed of the loop: {bed}")


def check_files(loops, text):
    """Names of files are relative to the decks of the loop, other texts are unchanged."""
    place = loops.folder / "named"
    place.mkdir()
    name = 'young "one" \\ two.csv'
    (place / name).write_text("x_m,young_Pa\n0,4e8\n3,5e8\n", encoding="utf-8")
    deck = place / "deck.toml"
    for quoted in ('"young \\"one\\" \\\\ tw\\u006F.csv"', f"'{name}'"):
        changed = text.replace("poisson = 0.33\n", f"poisson = 0.33\nyoung_file = {quoted}\n")
        changed = re.sub(r"title = .*", f"title = '{name}'", changed)
        deck.write_text(changed, encoding="utf-8")
        loops.ends(0, "", deck, place / "loop", "--rounds", "1")
        decks = made(place / "loop")
        for which in ("bed", "round_0/load_test", "round_0/trains"):
            path = pathlib.Path(decks[which]["ground"]["layer"][0]["young_file"])
            of = (place / "loop" / which).parent
            if path.is_absolute() or (of / path).resolve() != (place / name).resolve():
                raise SystemExit(f"{which} names {path}")
            if decks[which]["title"] != name:
                raise SystemExit(f"{which}: the title is not a file: {decks[which]['title']}")
    # A loop whose folder was moved as a whole continues.
    moved = loops.folder / "moved"
    place.rename(moved)
    before = (moved / "loop/round_0/load_test/results.h5").stat().st_mtime_ns
    loops.ends(0, "", moved / "deck.toml", moved / "loop", "--rounds", "1")
    if (moved / "loop/round_0/load_test/results.h5").stat().st_mtime_ns != before:
        raise SystemExit("a loop that was moved must not start again")


def check_begun(loops, text):
    """A bed that starts from a state also does so in the loop; its rounds start from the bed."""
    place = loops.folder / "begun"
    place.mkdir()
    (place / "stage_fill.h5").write_text("state", encoding="utf-8")
    deck = place / "deck.toml"
    deck.write_text('start = "stage_fill.h5"\n' + text, encoding="utf-8")
    loops.ends(0, "", deck, place / "loop", "--rounds", "1")
    starts = {name: one.get("start") for name, one in made(place / "loop").items()}
    if starts != {"bed": "../stage_fill.h5", "round_0/load_test": "../bed/stage_bed_in.h5",
                  "round_0/track": None, "round_0/trains": "load_test/stage_load_test_0.h5"}:
        raise SystemExit(f"bed and rounds start from {starts}")
    deck.write_text('start = "loop/bed/stage_bed_in.h5"\n' + text, encoding="utf-8")
    loops.ends(2, "stage_bed_in.h5 would be overwritten by the loop", deck, place / "loop")


def check_defaults(loops, text):
    """Missing keys have the defaults of the program: here of one with another default."""
    real, other = loops.program.read_text(encoding="utf-8"), loops.program.with_name("other")
    output = other.with_suffix(".sh")
    output.write_text(f'#!/bin/sh\n"{loops.program}" describe all | '
                    "sed 's/^| `before` | whole number | - | `20`/| `before` | whole number | - | "
                    "`18`/'\n", encoding="utf-8")
    other.write_text(real.replace("exec ", f'[ "$1" = describe ] && exec sh {output}\nexec '),
                     encoding="utf-8")
    other.chmod(0o755)
    deck = loops.folder / "default.toml"
    deck.write_text(text.replace("before = 16 ", "# before "), encoding="utf-8")
    for program, before in ((loops.program, 20), (other, 18)):
        kept, loops.program = loops.program, program
        place = loops.folder / f"before_{before}"
        loops.ends(0, "", deck, place, "--rounds", "1")
        loops.program = kept
        first = made(place)["round_0/track"]["passage"]["points"][0]
        if abs(first - 0.6 * before) > 1e-9:
            raise SystemExit(f"the bed begins at x = {first} m of the track with seat.before = "
                             f"{before} by default")


def check_train(loops, text):
    """The trains of the rounds keep the settings of the deck's stage."""
    own = {"seat_force": 4e3, "ground_moves": False, "friction": 0.5, "local_damping": 0.3}
    deck = loops.folder / "train.toml"
    deck.write_text(text.split(TRAIN)[0] + TRAIN + 'kind = "passage"\ntrain = true\n' + "".join(
        f"{key} = {str(value).lower()}\n" for key, value in own.items()), encoding="utf-8")
    loops.ends(0, "", deck, loops.folder / "train", "--rounds", "1", "--trains", "3")
    decks = made(loops.folder / "train")
    stage = decks["round_0/trains"]["stage"][-1]
    if stage != {"name": "trains_0", "kind": "passage", "cycles": 3, **own}:
        raise SystemExit(f"trains of the round: {stage}")
    stage = decks["round_0/load_test"]["stage"][-1]
    if {**stage, **own, "local_damping": 0.2} != stage:
        raise SystemExit(f"the load test must use ground, seat force and friction of the "
                         f"train: {stage}")


def main():
    program, source, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    loops = Loops(program, source, folder)
    text = (source / "inputs/track/on_bed.toml").read_text(encoding="utf-8")
    run_checks((check_refused, check_written_otherwise, check_files, check_begun, check_train,
                check_defaults), loops, text)


if __name__ == "__main__":
    main()
