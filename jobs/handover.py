#!/usr/bin/env python3
"""The hand-over loop of long-term studies. In each round the support stiffness of the bed is passed
to a train on a track alone, and the resulting load of each sleeper is passed back to the bed.

    handover.py PROGRAM DECK FOLDER [--start STATE]
                [--rounds N] [--trains N] [--each N] [--load N] [--force]

DECK: a bed with the sections of rail and train, and [handover] (inputs/track/on_bed.toml): the
stage `after` which the rounds begin, with sleepers that are bedded in, and numbers that
command-line options may replace. The bed is run up to that stage in FOLDER/bed. With STATE, the
stage_NAME.h5 of an earlier run of the deck or the folder that contains it, this is not repeated.
One round, in FOLDER/round_K:

1. load test: all seats are loaded and unloaded slowly; the slope of force over displacement during
   unloading, without ringing and slips (support.py), is the support stiffness of each sleeper. For
   two rails half of it acts below each.
2. track: the train runs over a track alone whose springs have these stiffnesses, on a rail whose
   geometry is the accumulated settlement of the sleepers.
3. trains: the seat forces of this run are applied to the bed N times (load.kind = "seats"), in a
   stage that otherwise equals the deck's own stage with train = true.
4. The settlement of each sleeper, times EACH (trains represented by one computed train), is added
   to the geometry of the rail for the next round; with two rails (track.dimension = "space") the
   settlement of each seat is added to the geometry of its rail.

The same command again continues where the last one was stopped (SIGTERM, SIGHUP or Ctrl-C: code 3,
after a checkpoint): finished runs of the same decks in FOLDER are kept, a stopped run is resumed.
--force starts again: what a loop writes in FOLDER is removed first (bed, bed.toml, bed.log, round_0
and on, handover.csv, handover.png). A deck, a file that it names or a --start among these is
refused. Rounds in handover.csv beyond N of --rounds are kept.

Errors in options, deck or state are reported before anything is written, with code 2. A run that
fails ends the loop with its own messages and code (docs/running.md). Only one loop can work in a
folder at a time; it holds handover.lock.

Three simplifications: the rail follows its sleepers, whereas a real rail bridges a settled sleeper;
all seats are loaded at once in the load test, whereas the ground below a single loaded seat is
stiffer; and --each multiplies the settlement of one train, which usually decreases from train to
train. Writes FOLDER/handover.csv (all results of each sleeper and round) and handover.png.
RANKS=N sets the number of ranks (2).
"""
import argparse
import csv
import fcntl
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import h5py
import numpy as np

import launch
import support
from loop_deck import FALL, LoopDeck, table_of_seats

OPTIONS = ("rounds", "trains", "each", "load")
LOCK = "handover.lock"
# Names that a loop writes in its folder; nothing else there is removed or taken for its own.
OF_THE_LOOP = re.compile(r"bed|bed\.toml|bed\.log|round_\d+|handover\.(csv|csv\.part|png|lock)")
COLUMNS = ("stiffness_N_m", "stiffness_spread_N_m", "largest_seat_force_N",
           "largest_wheel_force_N", "settlement_per_train_m", "geometry_before_m")


class Loop:
    """All checks are made in the constructor, before anything in the folder is changed."""

    def __init__(self, given):
        self.given, self.ranks = given, launch.requested_ranks()
        words = " without --force" if given.force else ""
        self.then = f"the same command{words} continues in {given.folder}"
        self.check(given.deck)
        self.deck = LoopDeck(given.deck, given.program)
        for name in OPTIONS:
            if getattr(given, name) is None:
                value = self.deck.value(f"handover.{name}")  # in a deck also 1e1 is a whole number
                setattr(given, name, int(value) if name in ("rounds", "trains") else value)
        for name in OPTIONS:
            number = getattr(given, name)
            if not (np.isfinite(number) and number > 0):
                launch.refuse(f"handover.{name} (--{name}) = {number:g} must be a finite number "
                              "above 0")
        done = self.last_stage()
        self.bed = self.deck.begin_after(
            done, str(given.start or f'{given.deck}: handover.after = "{done}"'))
        self.rails = self.deck.value("seat.rails")
        self.sides = self.deck.sides
        self.columns = ("round", "x_m", *(["side"] if self.two() else []), *COLUMNS)
        self.x = self.deck.sleepers["first"] + self.deck.sleepers["spacing"] * np.arange(
            self.deck.sleepers["count"])
        self.settled = np.zeros((len(self.x), len(self.sides)))  # m, settlement in the geometry
        self.spare_inputs()
        self.table, self.rows = [] if given.force else self.old_table(), []
        if not given.force:
            self.refuse_others()
        self.try_decks(done)
        launch.make_folder(given.folder)
        self.lock = self.take_folder()
        if not given.force:
            self.table = self.old_table()  # another loop may have ended during the checks
        if given.force:  # otherwise a continued command would find old rounds
            for old in given.folder.iterdir():
                if OF_THE_LOOP.fullmatch(old.name) and old.name != LOCK:
                    shutil.rmtree(old) if old.is_dir() and not old.is_symlink() else old.unlink()
        self.start = given.start or self.make_bed(done)

    def two(self):
        """Whether there are two rails, and so two seats of each sleeper."""
        return len(self.sides) == 2

    def geometry_files(self, folder):
        return [folder / f"geometry{side and '_' + side}.csv" for side in self.sides]

    def check(self, deck, what=None):
        """Ends with the program's own messages if the deck is not valid; `what` names the purpose
        of a deck that the loop has made."""
        ran = launch.run([self.given.program, "check", deck], self.then,
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if ran.returncode and what:
            ran.stderr = re.sub(rf"{re.escape(str(deck))}:(\d+:)?",
                                lambda _: f"{self.given.deck}, {what}:", ran.stderr)
        if ran.returncode == launch.BAD_INPUT:
            launch.refuse(ran.stderr.rstrip())
        if ran.returncode:
            launch.fail(ran, f"{self.given.program} check {self.given.deck}")

    def last_stage(self):
        """The stage after which the rounds begin."""
        given, done = self.given, self.deck.value("handover.after")
        if given.start:
            if given.start.is_dir():
                given.start /= f"stage_{done}.h5"
            if not given.start.is_file():
                launch.refuse(f"{given.start} does not exist")
            done = given.start.name.removeprefix("stage_").removesuffix(".h5")
        if done not in [stage["name"] for stage in self.deck.values.get("stage", [])]:
            launch.refuse(f"{given.start}: {given.deck} has no stage \"{done}\"; give the "
                          "stage_NAME.h5 of one of its stages")
        return done

    def spare_inputs(self):
        """Refuses inputs that the loop would overwrite or remove."""
        given, folder = self.given, self.given.folder.resolve()

        def place(path):
            """Whether `path` is among the names that the loop writes in its folder."""
            inside = path.resolve().is_relative_to(folder) and path.resolve() != folder
            name = path.resolve().relative_to(folder).parts[0] if inside else ""
            return OF_THE_LOOP.fullmatch(name)
        for path in (given.deck, *map(Path, self.deck.files)):
            if place(path):
                launch.refuse(f"{path} would be overwritten by the loop: choose another folder")
        if given.force and given.start and place(given.start):
            launch.refuse(f"--force would remove {given.start}: copy it to another place, or "
                          "choose another folder")

    def old_table(self):
        """Rows of handover.csv."""
        path = self.given.folder / "handover.csv"
        if not path.is_file():
            return []
        with open(path, newline="", encoding="utf-8") as file:
            rows = csv.DictReader(file)
            if tuple(rows.fieldnames or ()) != self.columns:
                launch.refuse(f"{path} is not a table of this loop: choose another folder, or "
                              "use --force")
            return list(rows)

    def refuse_others(self):
        """Refuses an option whose value differs from that of the rounds in the folder."""
        self.refuse_other_each()
        for name, run, key in (("load", "load_test", "load"), ("trains", "trains", "cycles")):
            deck = self.given.folder / f"round_0/{run}.toml"
            if not (deck.is_file() and deck.with_suffix("").exists()):
                continue
            value = tomllib.loads(deck.read_text(encoding="utf-8"))["stage"][-1][key]
            if value != getattr(self.given, name):
                launch.refuse(f"{self.given.folder} holds rounds with handover.{name} = "
                              f"{value:.9g}, not {getattr(self.given, name):.9g}: choose another "
                              "folder, or use --force")

    def refuse_other_each(self):
        """Refuses another EACH: the geometry of a round is the settlement under one train of the
        round before, times its number of trains, times EACH."""
        paths = self.geometry_files(self.given.folder / "round_1")
        trains = self.given.folder / "round_0/trains.toml"
        lost = [float(row["settlement_per_train_m"]) for row in self.table if row["round"] == "0"]
        if (not all(path.is_file() for path in (*paths, trains))
                or len(lost) != self.settled.size):
            return
        most = int(np.argmax(np.abs(lost)))
        sleeper, side = divmod(most, len(self.sides))
        with open(paths[side], newline="", encoding="utf-8") as file:
            height = {float(row["x_m"]): float(row["z_m"]) for row in csv.DictReader(file)}
        sunk = -height.get(float(self.deck.seats_on_track()[sleeper]), 0.0)
        count = tomllib.loads(trains.read_text(encoding="utf-8"))["stage"][-1]["cycles"]
        each = sunk / lost[most] / count if lost[most] else 0.0
        if each and not np.isclose(each, self.given.each, rtol=1e-9):
            launch.refuse(f"{self.given.folder} holds rounds with handover.each = {each:.9g}, "
                          f"not {self.given.each:g}: choose another folder, or use --force")

    def try_decks(self, done):
        """Lets the program check the decks of the first round, with preliminary values."""
        start = self.given.start or self.given.folder / f"bed/stage_{done}.h5"
        stiffness = np.full(len(self.x), self.deck.springs())
        with tempfile.TemporaryDirectory() as folder:
            deck, table = Path(folder) / "deck.toml", Path(folder) / "table.csv"

            def check(values, text, what):
                table.write_text(text, encoding="utf-8")  # both rails have the same geometry here
                deck.write_text(self.deck.text(values, folder), encoding="utf-8")
                self.check(deck, what)
            check(self.deck.track_alone(stiffness, [table] * len(self.sides)),
                  self.deck.geometry(self.settled[:, 0]), "track alone of the loop")
            stages = [self.deck.load_test(0, self.given.load), self.deck.trains(0, 1)]
            values = self.bed | {"stage": self.bed["stage"] + stages,
                                 "load": self.seat_load(table)}
            if start.is_file() and not (self.given.force and not self.given.start):
                values["start"] = str(start)
            check(values, table_of_seats([0, 1], np.zeros((2, *self.settled.shape)), self.sides),
                  "bed of the loop")

    def seat_load(self, table):
        """Section [load] of the bed."""
        load = {"kind": "seats", "file": str(table)}
        return load | ({"gauge": self.deck.value("track.gauge")} if self.two() else {})

    def take_folder(self):
        """Returns an open file that stays locked until the script ends for any reason; a file left
        by an earlier loop is not locked."""
        path = self.given.folder / LOCK
        try:
            file = open(path, "a+", encoding="utf-8")
        except OSError as error:
            launch.refuse(f"{path} cannot be written ({error.strerror}): choose another folder")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            launch.refuse(f"{self.given.folder}: another loop (process {file.read().strip()}) "
                          "is running here: wait for its end, stop it, or choose another folder")
        file.truncate(0)
        file.write(f"{os.getpid()}\n")
        file.flush()
        return file

    def program(self, folder, values, ranks, made_of=()):
        """Runs the deck `values` in `folder`, or the part of the run that is missing. The deck is
        written to folder.toml, with a line for the contents of each file it depends on: `made_of`
        has paths of existing files, or (path, text) of files to be written."""
        deck, summary = folder.with_suffix(".toml"), folder / "summary.json"
        text, written = self.deck.text(values, folder.parent), {}
        for one in made_of:
            path, content = one if isinstance(one, tuple) else (one, None)
            if content is None:
                with path.open("rb") as file:
                    digest = hashlib.file_digest(file, "sha256")
            else:
                written[path], digest = content, hashlib.sha256(content.encode())
            text += f"# {path.name}: {digest.hexdigest()}\n"
        words = ["run", deck, "-o", folder]
        if folder.exists():
            if not deck.is_file() or deck.read_text(encoding="utf-8") != text:
                launch.refuse(f"{folder} holds a run of another deck: choose another folder, or "
                              "use --force")
            if summary.is_file() and json.loads(summary.read_text(encoding="utf-8"))["finished"]:
                return
            if (folder / "latest").is_file():
                words = ["resume", folder]
            else:  # the run ended before its first checkpoint
                words.append("--force")
        for path, content in {**written, deck: text}.items():
            path.write_text(content, encoding="utf-8")
        self.run_logged(folder, launch.on_ranks(ranks, self.given.program, *words))

    def run_logged(self, folder, command):
        """Writes the output of the run to folder.log, its error messages last."""
        with open(f"{folder}.log", "w", encoding="utf-8") as log, \
                tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as errors:
            try:
                ran = launch.run(command, self.then, stdout=log, stderr=errors)
            finally:
                errors.seek(0)
                errors_text = errors.read()
                log.write(errors_text)
        if ran.returncode == launch.STOPPED:  # a limit in its own deck
            launch.stop(self.then)
        if ran.returncode:
            ran.stderr = errors_text
            launch.fail(ran, str(folder), f"; see {folder}.log")

    def make_bed(self, last):
        """Checkpoint of the bed after stage `last`."""
        folder = self.given.folder / "bed"
        self.program(folder, self.bed, self.ranks)
        return folder / f"stage_{last}.h5"

    def run_bed(self, stage, folder, seats=None):
        """Runs one more stage of the bed, with a table of seat forces or none; its histories."""
        self.bed["stage"] = self.bed["stage"] + [stage]
        values, files = {**self.bed, "start": str(self.start)}, [self.start]
        if seats:
            values["load"] = self.seat_load(seats[0])
            files.append(seats)
        self.program(folder, values, self.ranks, files)
        self.start = folder / f"stage_{stage['name']}.h5"
        with h5py.File(folder / "results.h5") as file:
            last = len(self.bed["stage"]) - 1
            rows = file["history/stage"][()].ravel() == last
            found = {name: file[f"history/sleeper/{name}"][()][rows]
                     for name in ("displacement", "seat_force")}
            return file["history/time"][()].ravel()[rows], found

    def measure_supports(self, number, folder):
        """Support stiffness of each sleeper and rail, N/m, and its standard error, N/m."""
        time, sleeper = self.run_bed(self.deck.load_test(number, self.given.load),
                                     folder / "load_test")
        fall = time >= time[-1] - FALL
        found = [support.support(force, z) for force, z in zip(sleeper["seat_force"][fall].T,
                                                               sleeper["displacement"][fall].T)]
        self.refuse_unreliable(number, found)
        return np.array([(one.stiffness, one.spread) for one in found]).T / self.rails

    def refuse_unreliable(self, number, found):
        """Ends the loop if the measured stiffness of a support is not reliable."""
        without = [(x, one) for x, one in zip(self.x, found) if one.is_unreliable()]
        if not without:
            return
        x, one = without[0]
        why, remedy = (f"the load of {self.given.load:g} N is too small compared with the motion "
                       "of the bed itself",
                       "a larger handover.load (--load)")
        if one.keeps_settling():
            why, remedy = ("the sleeper still settles while it is unloaded",
                           "a longer bedding-in with a larger load before handover.after")
        print(f"round {number}: the support stiffness of {len(without)} of {len(found)} sleepers "
              "is not reliable (it is not above 0, or its uncertainty exceeds half of it); the "
              f"first is the sleeper at x = {x:g} m, with {one.stiffness / 1e6:.3g} +- "
              f"{one.spread / 1e6:.2g} MN/m: {why}; use {remedy}, with --force or in another "
              "folder",
              file=sys.stderr)
        sys.exit(launch.FAILED)

    def pass_track(self, folder, stiffness):
        """Seat forces of one rail, N, [time, sleeper, side]; their table for the bed; largest wheel
        force, N."""
        files = self.geometry_files(folder)
        self.program(folder / "track",
                     self.deck.track_alone(stiffness, [os.path.abspath(file) for file in files]), 1,
                     [(file, self.deck.geometry(settled))
                      for file, settled in zip(files, self.settled.T)])
        with h5py.File(folder / "track/results.h5") as file:
            time, force = file["history/time"][()].ravel(), file["history/sleeper/seat_force"][()]
            wheel = file["history/wheel/force"][()].max()
        force = force.reshape(len(time), *self.settled.shape)
        on_seat = force if self.two() else self.rails * force
        return force, (folder / "seats.csv", table_of_seats(time, on_seat, self.sides)), wheel

    def pass_bed(self, number, folder, seats):
        """Settlement of each seat under one train, m, [sleeper, side]."""
        begin = self.start
        _, sleeper = self.run_bed(self.deck.trains(number, self.given.trains), folder / "trains",
                                  seats)
        if self.two():
            lost = self.seat_heights(begin) - self.seat_heights(self.start)
        else:
            lost = (sleeper["displacement"][0] - sleeper["displacement"][-1])[:, None]
        return lost / self.given.trains

    def seat_heights(self, state):
        """Displacement of the seats since the sleepers were placed, m, [sleeper, side]: from a
        checkpoint, as histories have no roll. With rotation R a seat g/2 to the left is g/2 R_zy
        above the centre."""
        with h5py.File(state) as file:
            z = file["sleepers/displacement"][()].reshape(-1, 3)[:, 2]
            a, b, c, w = file["sleepers/attitude"][()].reshape(-1, 4).T
        up = self.deck.value("track.gauge") / 2 * 2 * (b * c + w * a)
        return np.stack([z + up, z - up], axis=1)

    def round(self, number):
        folder = self.given.folder / f"round_{number}"
        launch.make_folder(folder)
        stiffness, spread = self.measure_supports(number, folder)
        force, seats, wheel = self.pass_track(folder, stiffness)
        lost = self.pass_bed(number, folder, seats)
        for i, k in np.ndindex(self.settled.shape):
            self.rows.append(dict(zip(self.columns, map(str, (
                number, self.x[i], *([self.sides[k]] if self.two() else []), stiffness[i],
                spread[i], force[:, i, k].max(), wheel, lost[i, k], 0.0 - self.settled[i, k])))))
        self.settled = self.settled + lost * self.given.trains * self.given.each
        print(f"round {number}: support {stiffness.min() / 1e6:.1f} to {stiffness.max() / 1e6:.1f} "
              f"MN/m (+- {1e2 * (spread / stiffness).max():.1f} % at most), seat force up to "
              f"{force.max() / 1e3:.1f} kN, wheel force up to {wheel / 1e3:.1f} kN, settlement per "
              f"train {1e3 * lost.mean():.4f} mm (mean), {1e3 * lost.max():.4f} mm (largest)",
              flush=True)

    def later_rows(self):
        """Rows of handover.csv beyond the rounds of this command, if they are of the same loop."""
        same = self.table[:len(self.rows)] == self.rows
        return self.table[len(self.rows):] if same else []

    def write(self):
        path = self.given.folder / "handover.csv"
        rows, part = self.rows + self.later_rows(), path.with_suffix(".csv.part")
        with open(part, "w", newline="", encoding="utf-8") as out:
            table = csv.DictWriter(out, self.columns)
            table.writeheader()
            table.writerows(rows)
        part.replace(path)  # so that the table is complete at any time
        self.draw(rows)

    def draw(self, rows):
        import matplotlib  # here: it takes a second to load, and a refusal needs none
        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
        shown = {"stiffness_N_m": ("support, MN/m", 1e-6),
                 "largest_seat_force_N": ("largest seat load, kN", 1e-3),
                 "settlement_per_train_m": ("settlement per train, mm", 1e3),
                 "geometry_before_m": ("geometry of the rail, mm", 1e3)}
        figure, panels = plt.subplots(len(shown), 1, figsize=(8, 10), sharex=True,
                                      layout="constrained")
        for panel, (name, (words, scale)) in zip(panels, shown.items()):
            for number in sorted({int(row["round"]) for row in rows}):
                for side, line in zip(self.sides, ("o-", "s--")):
                    values = [scale * float(row[name]) for row in rows
                              if int(row["round"]) == number and row.get("side", "") == side]
                    panel.plot(self.x, values, line, ms=4, lw=0.9, color=f"C{number % 10}",
                               label=f"round {number} {side}".rstrip())
            panel.set(ylabel=words)
            panel.grid(alpha=0.3)
        panels[0].legend(fontsize=7)
        panels[-1].set(xlabel="x, m")
        figure.savefig(self.given.folder / "handover.png", dpi=130)
        plt.close(figure)

    def report_kept_rounds(self):
        table, more = self.given.folder / "handover.csv", len(self.table) > len(self.rows)
        if more and self.later_rows():
            print(f"{table} keeps round {self.given.rounds} and later, computed by an earlier "
                  "command for this loop")
        elif more:
            print(f"{table} contained further rounds of another loop, which were removed")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("program", type=launch.program)
    parser.add_argument("deck", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--start", type=Path, metavar="STATE", help="stage_NAME.h5 of an earlier "
                        "run of the deck, or the folder of this file; the bed is then not run")
    parser.add_argument("--rounds", type=int)
    parser.add_argument("--trains", type=int, help="trains computed in a round")
    parser.add_argument("--each", type=float, help="trains represented by one computed train")
    parser.add_argument("--load", type=float, help="peak force on each sleeper in the "
                        "load test, in newtons")
    parser.add_argument("--force", action="store_true", help="remove the results in FOLDER and "
                        "start again")
    loop = Loop(parser.parse_args())
    for number in range(loop.given.rounds):
        loop.round(number)
        loop.write()
    loop.report_kept_rounds()


if __name__ == "__main__":
    main()
