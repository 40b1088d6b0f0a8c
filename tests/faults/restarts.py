#!/usr/bin/env python3
"""Every deck, shortened, stopped and resumed: the end is bitwise that of an undisturbed run.

    restarts.py PROGRAM INPUTS FOLDER [--decks NAME...] [--seed S]

Each stage of each deck under INPUTS is shortened to a few dozen windows, however few stones have
settled by then. The run is stopped after three random windows and resumed on 1 to 6 ranks. A
shortened deck may fail (stones that have not settled, for example); then the windows before are
compared, in a checkpoint at their end. Cells that decks copy are made first, not shortened (some
minutes each). The exit code is 1 if there are findings.
"""
import argparse
import json
import os
import pathlib
import random
import re
import shutil
import sys
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from damaged import difference  # noqa: E402
from program import Program, cell_of, summary  # noqa: E402

WINDOWS = 40  # of each stage
STOPS, MOST_RANKS = 3, 6
PATIENCE = 900  # s


def windows_of(report):
    """Largest number of windows of each stage, from the report of `check`."""
    found = {}
    for line in re.findall(r"largest number of windows: (.*)", report):
        found |= {name: int(count) for name, count in re.findall(r"([\w-]+) (\d+)", line)}
    for name, count in re.findall(r"(?m)^  (?:(\S+): )?[\d.e+-]+ s in (\d+) windows", report):
        found[name] = int(count)  # without a name: of any stage
    return found


def start_of_load(deck, length):
    """The override by which the first axle comes to the first sleeper within `length` s."""
    way = deck["load"].get("speed", 0) * length / 2
    return f"load.start={deck['sleepers']['first'] - min(0.01, way or 0.01):.6g}"


def shortened(program, path, given):
    """Overrides by which the deck takes few windows."""
    with open(path, "rb") as file:
        deck = tomllib.load(file)
    ran = program.done(1, "check", path, *given)
    if deck.get("model", "bed").startswith("track"):
        steps = int(re.search(r"in (\d+) steps", ran.stdout)[1])
        length = float(re.search(r"passage: ([\d.e+-]+) s", ran.stdout)[1])
        return [f"passage.duration={length * min(1, 5 * WINDOWS / steps):.6g}"]
    count = windows_of(ran.stdout)
    words = ["output.history_interval=0", "output.checkpoint_interval=0"]
    if deck.get("model", "bed") != "ground":
        words.append("dem.largest_overlap=1000")  # stones have no time to settle
    jumps = any(stage.get("kind") == "jump" for stage in deck["stage"])
    for number, stage in enumerate(deck["stage"]):
        key = f"stage.{number}"
        windows = count.get(stage["name"], count.get("", 0))
        kind = stage.get("kind", "run")
        if windows == 0 or kind == "tamp":
            continue
        if not stage.get("duration"):  # as long as axles pass
            words += [f"{key}.cycles=0", f"{key}.duration=2e-3", f"{key}.settlement=0"]
            if "load" in deck and not stage.get("train"):
                words.append(start_of_load(deck, 2e-3))
            continue
        length = stage["duration"] * min(1.0, WINDOWS / windows)
        if kind == "passage" and "load" in deck and not stage.get("train"):
            words.append(start_of_load(deck, length))
        words.append(f"{key}.duration={length:.6g}")
        if "growth" in stage:
            words.append(f"{key}.growth=0")  # in a few windows stones would grow too fast
        if "ramp" in stage:
            words.append(f"{key}.ramp={length / 4:.6g}")
        if kind in ("load", "shear", "triaxial", "compact") and "ramp" not in stage:
            words.append(f"{key}.ramp={length / 4:.6g}")
        if kind == "jump":
            words += ["jump.cycles=2", f"jump.period={length / 4:.6g}"]
        elif stage.get("cycles", 0) > 4:
            words.append(f"{key}.cycles={3 if jumps else 2}")  # more than jump.cycles
    return words


class Cells:
    """The cells that decks copy, each made once, by the deck of its name: results/quickstart/cell
    by INPUTS/quickstart_cell.toml if there is one, else by cell.toml beside the deck."""

    def __init__(self, program, inputs, folder):
        self.program, self.inputs, self.folder = program, inputs, folder

    def maker_of(self, deck, cell):
        name = pathlib.PurePath(cell)
        candidates = (self.inputs / f"{name.parent.name}_{name.name}.toml",
                      deck.parent / f"{name.name}.toml")
        found = next((path for path in candidates if path.is_file()), None)
        if not found:
            raise SystemExit(f"{deck}: none of {[str(path) for path in candidates]} makes {cell}")
        return found

    def overrides(self, deck):
        """By which the deck finds its cell, if it copies one."""
        cell = cell_of(deck)
        if not cell:
            return []
        maker = self.maker_of(deck, cell)
        place = self.folder / ("cell_" + "_".join(maker.relative_to(self.inputs).with_suffix(
            "").parts))
        if not place.exists():
            self.program.done(2, "run", maker, "-o", place)
        return [f"bed.cell={place}"]


def total_windows(folder):
    return summary(folder)["windows"]


class Deck:
    """`given`: overrides with which the deck can be used."""

    def __init__(self, program, path, folder, chance, given):
        self.program, self.path, self.chance = program, path, chance
        self.place = folder / f"{path.parent.name}_{path.stem}"
        self.words = [*given, *shortened(program, path, given)]

    def ran(self, name, *words, resume=False):
        command = ["resume", self.place / name] if resume else \
            ["run", self.path, *self.words, "-o", self.place / name]
        return self.program(self.chance.randint(1, MOST_RANKS), *command, *words, timeout=PATIENCE)

    def outcome(self):
        """(what was compared, finding or nothing)."""
        ran = self.ran("whole")
        last, limit = 0, []
        if ran.returncode == 4:
            last = self.windows_before_failure()
            if last < 4:
                return "fails at once", ran.stderr.strip()[:150]
            shutil.rmtree(self.place / "whole")
            ran, limit = self.ran("whole", f"output.stop_after={last}"), [last]
        if ran.returncode not in (0, 3):
            return f"code {ran.returncode}", ran.stderr.strip()[:300]
        last = last or total_windows(self.place / "whole")
        stops = sorted(self.chance.sample(range(1, last), min(STOPS, last - 1)))
        for number, stop in enumerate(stops + limit):
            ran = self.ran("parts", f"output.stop_after={stop}", resume=number > 0)
            if ran.returncode != 3:
                return "stopped", (f"stop after {stop}: code {ran.returncode}: "
                                   f"{ran.stderr.strip()[:300]}")
        if not limit and (ran := self.ran("parts", "output.stop_after=0", resume=True)).returncode:
            return "resumed", f"code {ran.returncode}: {ran.stderr.strip()[:300]}"
        return f"{last} windows" + (", then it fails" if limit else ""), difference(
            self.place / "whole", self.place / "parts")

    def windows_before_failure(self):
        """By the last line of progress; the window that failed may be its last one."""
        path = self.place / "whole" / "progress.jsonl"
        if not path.is_file():
            return 0
        last = json.loads(path.read_text(encoding="utf-8").splitlines()[-1])
        return last["windows_of_run"] - 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("inputs", type=pathlib.Path)
    parser.add_argument("folder", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--decks", nargs="+", default=[], help="paths below INPUTS; default: all")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    program, findings, lines = Program(given.program), 0, []
    cells = Cells(program, given.inputs, given.folder)
    for path in [given.inputs / name for name in given.decks] or \
            sorted(given.inputs.rglob("*.toml")):
        name = path.relative_to(given.inputs)
        try:
            deck = Deck(program, path, given.folder, random.Random(f"{given.seed} {path.name}"),
                        cells.overrides(path))
            compared, finding = deck.outcome()
        except SystemExit as failure:  # the other decks are of interest, too
            compared, finding = "not run", str(failure)[:300]
        findings += bool(finding)
        print(f"{name}: {compared}{': ' + finding if finding else ''}", flush=True)
        lines.append(f"| {name} | {compared} | {finding or 'bitwise identical'} |")
        if not finding:
            shutil.rmtree(deck.place, ignore_errors=True)
    print("\n| deck | compared | result |\n|---|---|---|")
    print("\n".join(lines))
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
