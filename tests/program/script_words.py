#!/usr/bin/env python3
"""Inputs that the Python scripts of jobs/ refuse with one message before anything runs.

    script_words.py PROGRAM SOURCE_FOLDER FOLDER
"""
import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import program  # noqa: E402, F401 (its environment of programs of one rank)


def refused(folder, words, command, ranks="2"):
    ran = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False,
                         cwd=folder, env={**os.environ, "RANKS": ranks})
    if ran.returncode != 2 or len(ran.stderr.splitlines()) != 1 or words not in ran.stderr:
        raise SystemExit(f"{command} must print {words} and end with 2, not {ran.returncode}:\n"
                         f"{ran.stdout}{ran.stderr}")
    if (folder / "results").exists() or (folder / "study").exists():
        raise SystemExit(f"{command} must be refused before it runs anything")


def check_stages(program, source, folder):
    """Rounds begin after the sleepers and before trains, wherever the stage is named."""
    loop, given = source / "jobs/handover.py", source / "inputs/track/on_bed.toml"
    text = given.read_text(encoding="utf-8")
    for stage, words in (("fill", "the rounds load the sleepers, which only a later stage places"),
                         ("train", "choose a stage before the first train")):
        deck, start = folder / f"after_{stage}.toml", folder / f"stage_{stage}.h5"
        deck.write_text(text.replace('after = "bed_in"', f'after = "{stage}"'), encoding="utf-8")
        start.touch()
        refused(folder, f'handover.after = "{stage}": the rounds', [loop, program, deck, "results"])
        refused(folder, words, [loop, program, given, "results", "--start", start])


def check_places(program, source, folder):
    loop, deck = source / "jobs/handover.py", source / "inputs/track/on_bed.toml"
    (folder / "file").touch()
    for place, words in (("file", "it is a file"), ("file/results", "Not a directory"),
                         ("/proc/results", "No such file or directory")):
        words = f"{place} cannot be created as a folder ({words})"
        refused(folder, words, [loop, program, deck, place])
        refused(folder, words, [source / "jobs/study.py", program, "netirail", "short", place])


def check_program(program, source, folder):
    """./NAME is the file in the working directory; then the load is refused."""
    loop, deck = source / "jobs/handover.py", source / "inputs/track/on_bed.toml"
    (folder / "here").symlink_to(program)
    for load in ("0", "nan", "inf"):
        refused(folder, f"handover.load (--load) = {load} must be a finite number above 0",
                [loop, "./here", deck, "results", "--load", load])
    refused(folder, "there: No such file", [loop, "./there", deck, "results"])
    refused(folder, '"netirial" is no study; these are: netirail, shi, demfem, chen',
            [source / "jobs/study.py", "./there", "netirial", "short", "study"])
    refused(folder, "numbers.csv: No such file",
            [source / "jobs/study.py", "--document", "netirail", "study"])
    refused(folder, "there: No such file",
            [source / "jobs/study.py", "./there", "netirail", "short", "study"])
    strength = [source / "jobs/strength.py", "./there", "strength", "heap"]
    refused(folder, "there: No such file", strength)
    refused(folder, "--rows none: must be one of deck, ", [*strength, "--rows", "none"])


def check_spared(program, source, folder):
    """The loop neither overwrites nor removes its inputs, nor, with --force, files that are not its
    own."""
    loop, given = source / "jobs/handover.py", source / "inputs/track/on_bed.toml"
    place = folder / "loop"
    (place / "bed").mkdir(parents=True)
    start = place / "bed/stage_bed_in.h5"
    kept = {place / name: name for name in (
        "bed.toml", "bed/stage_bed_in.h5", "round_0/trains.toml", "bed/table.csv", "bed.csv",
        "bedding/measured.csv", "round_table/rows.csv", "round_1.csv", "bed_of_mine.toml")}
    text = given.read_text(encoding="utf-8")
    for path, name in kept.items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text if name.endswith(".toml") else name, encoding="utf-8")

    def same():
        for path, name in kept.items():
            if not path.is_file() or path.read_text(encoding="utf-8") != (
                    text if name.endswith(".toml") else name):
                raise SystemExit(f"the loop must leave {path} as it was")
    refused(folder, f"--force would remove {start}", [loop, program, given, place, "--start", start,
                                                      "--force"])
    for deck in ("bed.toml", "round_0/trains.toml"):
        for words in ([], ["--force"]):
            refused(folder, f"{place / deck} would be overwritten by the loop",
                    [loop, program, place / deck, place, *words])
    same()
    # The next loop gets a program that only checks and fails on the first run.
    checks = folder / "checks"
    checks.write_text(f'#!/bin/sh\nif [ "$1" = describe ]; then exec {program} describe all; fi\n'
                      'test "$1" = check\n', encoding="utf-8")
    checks.chmod(0o755)
    refused_later = [loop, checks, given, place, "--force"]
    subprocess.run([sys.executable, *refused_later], capture_output=True, check=False, cwd=folder)
    for name in ("bed/stage_bed_in.h5", "bed/table.csv", "round_0/trains.toml"):
        if (place / name).exists():
            raise SystemExit(f"--force must remove {place / name}, which is the loop's")
        del kept[place / name]
    del kept[place / "bed.toml"]  # is rewritten
    same()


def main():
    program, source, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_stages(program, source, folder)
    check_places(program, source, folder)
    check_program(program, source, folder)
    check_spared(program, source, folder)
    for ranks in ("abc", "0", "-1", "1.5"):
        refused(folder, f'RANKS = "{ranks}": must be a whole number', [
            source / "jobs/handover.py", program, source / "inputs/track/on_bed.toml", "results"],
                ranks)


if __name__ == "__main__":
    main()
