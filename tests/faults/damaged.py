#!/usr/bin/env python3
"""Damaged files of runs: a resume either continues to the undisturbed result or is refused with
sentences.

    damaged.py PROGRAM SOURCE FOLDER [--count N] [--seed S] [--workers W]

Runs of every model are stopped half-way. In each case files of such a run are changed at random
(bits, blocks, length, exchanged with those of another run, see DAMAGES); then `info` must end with
0 or 2, `resume` with 0 or 2 within 60 s, and after 0 the state must be that of the undisturbed
run. The table at the end counts the outcomes. The exit code is 1 if there are findings, whose
folders are kept.
"""
import argparse
import json
import os
import pathlib
import random
import shutil
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "support"), str(HERE.parent / "restart")]
from mutations import ROUGH, attack, called  # noqa: E402
from restart import canonical  # noqa: E402
from results import datasets, same_datasets  # noqa: E402

# (name, deck below SOURCE, overrides, windows after which it is stopped)
RUNS = (
    ("bed", "tests/restart/tiny.toml", (), 7000),
    ("filling", "tests/restart/tiny.toml", ("stage.fill.duration=0.1",), 500),
    ("breaking", "tests/restart/tiny_breaking.toml", ("stage.passage.duration=0.01",), 9700),
    ("track", "inputs/track/plain.toml", ("passage.duration=0.2",), 300),
    ("on_ground", "tests/knobs/on_ground.toml", (), 20),
    ("ground", "tests/regress/ground_alone.toml", (), 5),
    ("placed", "inputs/verify/stack.toml", (), 50))
PATIENCE = 60  # s


def state_of(folder):
    """What identifies the state at the end of a run."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    found = []

    def collect(part):
        for key, value in part.items():
            if key == "state_hash":
                found.append(value)
            elif isinstance(value, dict):
                collect(value)
    collect(summary)
    return summary["finished"], summary["windows"], found


def difference(one, other):
    """What differs in state or results of two runs, or nothing."""
    if state_of(one) != state_of(other):
        return f"state {state_of(one)} and {state_of(other)}"
    found = ({name: canonical(name, values) for name, values in datasets(place).items()}
             for place in (one, other))
    try:
        same_datasets(*found, other.name, nan=True)
    except SystemExit as error:
        return str(error)
    return ""


def bits(data, chance, _):
    for _ in range(chance.choice((1, 1, 1, 8, 100))):
        if data:
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    return data


def block(data, chance, _):
    if data:
        at, size = chance.randrange(len(data)), chance.choice((1, 8, 512, 4096))
        fill = chance.choice((b"\0", b"\xff", bytes([chance.randrange(256)])))
        data[at:at + size] = fill * len(data[at:at + size])
    return data


def shorter(data, chance, _):
    return data[:chance.randrange(len(data) + 1)]


def longer(data, chance, _):
    return data + bytes(chance.randrange(256) for _ in range(chance.choice((1, 100, 5000))))


def empty(*_):
    return b""


def exchanged(data, chance, others):
    """Of the same name in another run, or another file."""
    return chance.choice(others).read_bytes() if others else data


DAMAGES = (bits, bits, bits, block, block, shorter, shorter, longer, empty, exchanged)


class Case:
    """A copy of a stopped run with damaged files."""

    def __init__(self, number, seed, runs, folder):
        self.chance = random.Random(f"{seed} {number}")
        self.run = self.chance.choice(runs)[0]
        self.place, self.folder = folder / f"case_{number}", folder
        self.words = []

    def make(self):
        shutil.copytree(self.folder / "stopped" / self.run, self.place)
        files = sorted(path for path in self.place.iterdir()
                       if path.is_file() and path.name != ".lock")
        # The newest checkpoint is what most of the program reads.
        newest = self.place / (self.place / "latest").read_text(
            encoding="utf-8").splitlines()[0]
        for _ in range(self.chance.choice((1, 1, 1, 2, 3))):
            path = self.chance.choice([*files, newest, newest, newest])
            damage = self.chance.choice(DAMAGES)
            others = sorted((self.folder / "stopped").glob(f"*/{path.name}")) + files
            path.write_bytes(damage(bytearray(path.read_bytes()), self.chance, others))
            self.words.append(f"{damage.__name__} of {path.name}")


def judged(program, case):
    case.make()
    for command in ("info", "resume"):
        code, out = called([program, command, case.place], PATIENCE)
        # Another valid checkpoint in the place of the newest is earlier than the limit of the run.
        if code == 3 and "exchanged" in " ".join(case.words):
            code, out = called([program, command, case.place], PATIENCE)
        if code not in (0, 2):
            return f"{command} {code}", f"{command} ends with {code}"
        if rough := ROUGH.search(out):
            return f"{command} {code}", f"{command} prints {rough[0]}"
        if code == 2 and not out.strip():
            return f"{command} {code}", f"{command} is refused without a sentence"
    if code == 2:
        return "refused", ""
    if state_of(case.place) != state_of(case.folder / "whole" / case.run):
        return "other result", "the result is another one"
    return "continued", ""


def work(program, case):
    outcome, finding = judged(program, case)
    if not finding:
        shutil.rmtree(case.place, ignore_errors=True)
    return outcome, finding, case.place, [case.run, *case.words]


def chosen(names):
    """The RUNS with these names; without names all."""
    return [run for run in RUNS if not names or run[0] in names]


def prepare(program, source, runs, folder):
    for name, deck, words, windows in runs:
        for kind, more in (("whole", ()), ("stopped", (f"output.stop_after={windows}",))):
            code, out = called([program, "run", source / deck, *words, *more, "-o",
                                folder / kind / name], 300)
            if code != (0 if kind == "whole" else 3):
                raise SystemExit(f"{name}, {kind}: code {code}\n{out[-2000:]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--runs", nargs="+", default=[], choices=[run[0] for run in RUNS])
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    runs = chosen(given.runs)
    prepare(given.program, given.source, runs, given.folder)
    cases = [Case(number, given.seed, runs, given.folder)
             for number in range(given.first, given.first + given.count)]
    counts, findings = attack(lambda case: work(given.program, case), cases, given.workers)
    # Of 1000 cases 62 % continue, since an older checkpoint or the file itself still serves.
    few = counts["continued"] < 0.3 * given.count
    if few:
        print("too few runs continue: is every damage refused?")
    return 1 if findings or few else 0


if __name__ == "__main__":
    sys.exit(main())
