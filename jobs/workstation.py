#!/usr/bin/env python3
"""A queue for one machine: runs of a list, as many side by side as there are cores.

    workstation.py PROGRAM LIST [--cores N]

Each line of LIST is a run: RANKS DECK DIR [key=value...]; # begins a comment. Files are relative
to the current folder. The same command continues what was stopped, by SIGTERM, SIGHUP or Ctrl-C or
because the machine failed, and leaves finished runs alone. A run that fails does not stop the
others. The exit code is 0 if all are finished, the largest one of the failures, or 3 after a stop.
"""
import argparse
import dataclasses
import functools
import os
import pathlib
import shlex
import subprocess
import sys
import time

import launch


@dataclasses.dataclass(frozen=True)
class Entry:
    """A line of the list."""
    line: int
    ranks: int
    deck: str
    folder: str
    words: tuple


def entries_of(path):
    """Entries of the list; every problem of it is reported at once."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        launch.refuse(f"{path}: {error}")
    found, problems, folders = [], [], {}
    for number, line in enumerate(lines, start=1):
        try:
            words = shlex.split(line, comments=True)
        except ValueError as error:
            problems.append(f"{path}:{number}: {error}")
            continue
        if not words:
            continue
        if len(words) < 3 or not words[0].isdecimal() or int(words[0]) < 1:
            problems.append(f"{path}:{number}: must be RANKS DECK DIR [key=value...]")
            continue
        entry = Entry(number, int(words[0]), words[1], words[2], tuple(words[3:]))
        place = os.path.abspath(entry.folder)
        if place in folders:
            problems.append(f"{path}:{number}: {entry.folder} is also that of line "
                            f"{folders[place]}: give each run a folder of its own")
        folders[place] = number
        found.append(entry)
    if problems:
        launch.refuse("\n".join(problems))
    return found


def do(program, entry, failed):
    """Runs or continues an entry; a failure is reported and kept."""
    begin = time.monotonic()
    ran = launch.run(launch.on_ranks(entry.ranks, program, "run", entry.deck, "-o", entry.folder,
                                     "--or-resume", *entry.words),
                     "the same command continues the list", stdout=subprocess.PIPE,
                     stderr=subprocess.PIPE, text=True)
    minutes = (time.monotonic() - begin) / 60
    if ran.returncode == 0:
        print(f"{entry.folder}: finished, {minutes:.1f} min", flush=True)
        return
    failed.append(ran.returncode)
    where = f"{entry.folder} (line {entry.line})"
    if ran.returncode == launch.STOPPED:
        print(f"{where}: stopped; the same command continues it", flush=True)
        return
    print("\n".join([*launch.messages(ran.stderr), f"{where}: "
                     + launch.describe_end(ran.returncode, ran.stderr)]),
          file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program", type=launch.program)
    parser.add_argument("list", type=pathlib.Path, help="RANKS DECK DIR [key=value...] in a line")
    parser.add_argument("--cores", type=int, default=len(os.sched_getaffinity(0)))
    given = parser.parse_args()
    if given.cores < 1:
        launch.refuse(f"--cores {given.cores}: must be at least 1")
    failed, entries = [], entries_of(given.list)
    launch.together([(f"line {entry.line}", (), min(entry.ranks, given.cores),
                      functools.partial(do, given.program, entry, failed)) for entry in entries],
                    given.cores)
    print(f"{len(entries) - len(failed)} of {len(entries)} runs are finished")
    codes = [code if code >= 0 else 128 - code for code in failed]
    return max((code for code in codes if code != launch.STOPPED),
               default=launch.STOPPED if codes else 0)


if __name__ == "__main__":
    sys.exit(main())
