#!/usr/bin/env python3
"""What jobs/handover.py reads from its deck: what it refuses of it before anything is written, and
that the decks of its rounds say what it says, however it is written.

    loop_decks.py PROGRAM SOURCE_FOLDER FOLDER
"""
import pathlib
import re
import shutil
import sys
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from loops import Loops  # noqa: E402

STAGE = '\n[[stage]]\nname = "{}"\nkind = "run"\nduration = 0.1\n'
TRAIN = '\n[[stage]]\nname = "train"\n'


def refused_decks(text):
    """(Deck, sentence) of what cannot be divided into bed and train."""
    before, behind = text.split(TRAIN)
    yield (text + TRAIN.replace("train", "again") + behind,
           "the deck sends several (stages train, again): leave one")
    yield (before + STAGE.format("rest") + STAGE.format("wait") + TRAIN + behind,
           "the rounds would leave out rest, wait: behind the bed's last stage only train may")
    yield text + STAGE.format("late"), "the rounds would leave out late"
    yield (re.sub(r"\[handover\][^[]*", "", text),
           "[handover] with `after`, the name of a stage, is needed")
    yield text + "duration = 0.5\n", "duration = 0.5 is not for the loop"
    yield text + "cycles = 3\n", "cycles = 3 is not for the loop"
    yield text + "cycles = 1\nsettlement = 1e-4\n", "settlement = 0.0001 is not for the loop"
    yield text.replace("first = 0.6 ", "# first "), "[sleepers] must say first"
    yield (text.replace("history_interval = 5e-4", "history_interval = 0.01"),
           "output.history_interval = 0.01 s: at most 0.005 s, or supports cannot be weighed")
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
            raise SystemExit(f"{words}: refused, but {list(kept.iterdir())}")
    deck.write_text(text, encoding="utf-8")
    loops.ends(2, "handover.csv is no table of the loop", deck, kept)
    loops.ends(2, "there_is_no.h5 is not there", deck, loops.folder / "new", "--start",
               loops.folder / "there_is_no.h5")
    if (loops.folder / "new").exists():
        raise SystemExit("a state that is not there must be missed before anything is written")


def made(folder):
    """Values of the decks that a loop has left."""
    return {name: tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))
            for name in ("bed", "round_0/weigh", "round_0/track", "round_0/trains")}


def check_written_otherwise(loops, text):
    """Dotted keys, tables and lists of tables written inline."""
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
        raise SystemExit("the test has changed values, not their writing")
    for name, one in (("plain", text), ("otherwise", otherwise)):
        (loops.folder / f"{name}.toml").write_text(one, encoding="utf-8")
        loops.ends(0, "", loops.folder / f"{name}.toml", loops.folder / name, "--rounds", "1")
    if made(loops.folder / "plain") != made(loops.folder / "otherwise"):
        raise SystemExit("a deck written otherwise must give the same decks")
    bed = made(loops.folder / "plain")["bed"]
    deck = tomllib.loads(text)
    if bed["stage"] != deck["stage"][:-1] or bed["ground"] != deck["ground"] or "rail" in bed:
        raise SystemExit(f"the bed of the loop: {bed}")


def check_files(loops, text):
    """Names of files hold from where the loop's decks lie, other texts stay as they are."""
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
        for which in ("bed", "round_0/weigh", "round_0/trains"):
            path = pathlib.Path(decks[which]["ground"]["layer"][0]["young_file"])
            of = (place / "loop" / which).parent
            if path.is_absolute() or (of / path).resolve() != (place / name).resolve():
                raise SystemExit(f"{which} names {path}")
            if decks[which]["title"] != name:
                raise SystemExit(f"{which}: the title is no file: {decks[which]['title']}")
    # So a loop goes on where all of it has moved.
    moved = loops.folder / "moved"
    place.rename(moved)
    before = (moved / "loop/round_0/weigh/results.h5").stat().st_mtime_ns
    loops.ends(0, "", moved / "deck.toml", moved / "loop", "--rounds", "1")
    if (moved / "loop/round_0/weigh/results.h5").stat().st_mtime_ns != before:
        raise SystemExit("a loop that has moved is begun anew")


def check_begun(loops, text):
    """A bed that starts from a state does so in the loop; its rounds start from the bed."""
    place = loops.folder / "begun"
    place.mkdir()
    (place / "stage_fill.h5").write_text("state", encoding="utf-8")
    deck = place / "deck.toml"
    deck.write_text('start = "stage_fill.h5"\n' + text, encoding="utf-8")
    loops.ends(0, "", deck, place / "loop", "--rounds", "1")
    starts = {name: one.get("start") for name, one in made(place / "loop").items()}
    if starts != {"bed": "../stage_fill.h5", "round_0/weigh": "../bed/stage_bed_in.h5",
                  "round_0/track": None, "round_0/trains": "weigh/stage_weigh_0.h5"}:
        raise SystemExit(f"bed and rounds start from {starts}")
    deck.write_text('start = "loop/bed/stage_bed_in.h5"\n' + text, encoding="utf-8")
    loops.ends(2, "stage_bed_in.h5 is where the loop writes its own", deck, place / "loop")


def check_defaults(loops, text):
    """What the deck leaves out is as the program has it: here one that says another default."""
    real, asked = loops.program.read_text(encoding="utf-8"), loops.program.with_name("asked")
    page = asked.with_suffix(".sh")
    page.write_text(f'#!/bin/sh\n"{loops.program}" describe | '
                    "sed 's/^| `before` | whole number | - | `20`/| `before` | whole number | - | "
                    "`18`/'\n", encoding="utf-8")
    asked.write_text(real.replace("exec ", f'[ "$1" = describe ] && exec sh {page}\nexec '),
                     encoding="utf-8")
    asked.chmod(0o755)
    deck = loops.folder / "default.toml"
    deck.write_text(text.replace("before = 16 ", "# before "), encoding="utf-8")
    for program, before in ((loops.program, 20), (asked, 18)):
        kept, loops.program = loops.program, program
        place = loops.folder / f"before_{before}"
        loops.ends(0, "", deck, place, "--rounds", "1")
        loops.program = kept
        first = made(place)["round_0/track"]["passage"]["points"][0]
        if abs(first - 0.6 * before) > 1e-9:
            raise SystemExit(f"the bed begins at {first} m of the track with seat.before = "
                             f"{before} by default")


def check_train(loops, text):
    """The rounds' trains are the deck's, whatever its stage says of ground, stones and contacts."""
    own = {"seat_force": 4e3, "ground_moves": False, "friction": 0.5, "local_damping": 0.3}
    deck = loops.folder / "train.toml"
    deck.write_text(text.split(TRAIN)[0] + TRAIN + 'kind = "passage"\ntrain = true\n' + "".join(
        f"{key} = {str(value).lower()}\n" for key, value in own.items()), encoding="utf-8")
    loops.ends(0, "", deck, loops.folder / "train", "--rounds", "1", "--trains", "3")
    decks = made(loops.folder / "train")
    stage = decks["round_0/trains"]["stage"][-1]
    if stage != {"name": "trains_0", "kind": "passage", "cycles": 3, **own}:
        raise SystemExit(f"trains of the round: {stage}")
    stage = decks["round_0/weigh"]["stage"][-1]
    if {**stage, **own, "local_damping": 0.2} != stage:
        raise SystemExit(f"weighing takes ground, seat force and friction of the train: {stage}")


def main():
    program, source, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    loops = Loops(program, source, folder)
    text = (source / "inputs/track/on_bed.toml").read_text(encoding="utf-8")
    check_refused(loops, text)
    check_written_otherwise(loops, text)
    check_files(loops, text)
    check_begun(loops, text)
    check_train(loops, text)
    check_defaults(loops, text)


if __name__ == "__main__":
    main()
