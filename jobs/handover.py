#!/usr/bin/env python3
"""The hand-over loop of long-term studies: what the bed is like goes to the train over a track
alone, what this does to each sleeper goes back to the bed, round after round.

    handover.py PROGRAM DECK FOLDER [--start CHECKPOINT]
                [--rounds N] [--trains N] [--each N] [--load N] [--force]

DECK: a bed with the sections of rail and train, and [handover] (inputs/track/on_bed.toml): a stage
`after` which the rounds begin, with sleepers that are bedded in, and numbers that words of the
command line may replace. The bed is run up to that stage in FOLDER/bed; CHECKPOINT, a stage_NAME.h5
of an earlier run of the deck, saves that. One round, in FOLDER/round_K:

1. weigh: all seats are loaded and unloaded slowly; the slope of force over displacement while the
   load goes (the median of its parts) is the support stiffness of each sleeper.
2. track: the train runs over a track alone whose springs have these stiffnesses, on a rail that
   lies as the sleepers have settled so far.
3. trains: the seat forces of this run pass N times over the bed (load.kind = "seats").
4. What each sleeper has lost, times EACH (trains that one computed train stands for), is added to
   the geometry of the rail for the next round.

The same command again goes on where the last one was stopped (SIGTERM, SIGHUP or Ctrl-C: code 3,
after a checkpoint): what FOLDER holds of the same decks is taken as it is, what was stopped is
resumed. --force begins anew: what a loop writes in FOLDER is removed first (bed, bed.toml,
bed.log, round_0 and on, handover.csv, handover.png). A deck, a file that it names or a --start
among these is refused.

A rail that follows its sleepers and seats that are weighed all at once are simplifications: a real
rail bridges a sunk sleeper, and a seat alone finds a stiffer ground. Writes FOLDER/handover.csv
(all figures of each sleeper and round) and handover.png. RANKS=N sets the ranks (2).
"""
import argparse
import csv
import hashlib
import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import h5py
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import launch  # noqa: E402

OF_THE_TRAIN = ("rail", "pad", "under_sleeper_pad", "ballast", "seat", "track", "train",
                "wheel_rail", "irregularity", "irregularity_right", "passage", "vehicle")
OPTIONS = {"rounds": 3, "trains": 2, "each": 1, "load": 30e3}
# What a loop writes in its folder, and nothing else there is removed or mistaken for its own.
OF_THE_LOOP = re.compile(r"bed|bed\.toml|bed\.log|round_\d+|handover\.csv|handover\.png")
PARTS = 11  # of that fall, each with a slope: stones that slip spoil few of them
WEIGHING, RAMP = 0.3, 0.12  # s, of the stage and of its load's rise and fall


def chunks(text):
    """(name of the section, its text) in the order of the deck; the head is called ""."""
    parts = re.split(r"(?m)^(?=\[)", text)
    return [(re.match(r"\[*([^\]]*)", part).group(1) if part.startswith("[") else "", part)
            for part in parts]


def toml(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else repr(value)


def table(name, values):
    lines = [name, *(f"{key} = {toml(value)}" for key, value in values.items()
                     if not isinstance(value, dict) and
                     not (isinstance(value, list) and value and isinstance(value[0], dict)))]
    return "\n".join(lines) + "\n\n"


def absolute(text, folder):
    """The text of a deck of `folder`, with the files it names, by a dot or slash, under their whole
    path."""
    return re.sub(r'"([^"\n]*[./][^"\n]*)"', lambda found: f'"{(folder / found[1]).resolve()}"'
                  if (folder / found[1]).is_file() else found[0], text)


class Loop:
    def __init__(self, given):
        self.given, self.ranks = given, launch.ranks_told()
        words = " without --force" if given.force else ""
        self.then = f"the same command{words} goes on in {given.folder}"
        self.check()
        text = given.deck.read_text(encoding="utf-8")
        self.deck = tomllib.loads(text)
        loop = self.deck.get("handover", {})
        for name, default in OPTIONS.items():
            if getattr(given, name) is None:
                setattr(given, name, loop.get(name, default))
        numbers = [getattr(given, name) for name in OPTIONS]
        if not (np.isfinite(numbers).all() and min(numbers) > 0):
            sys.exit("rounds, trains, each and load must be above 0")
        done, names = self.last_stage(loop)
        trains = [stage for stage in self.deck["stage"] if stage.get("train")]
        if not trains:
            sys.exit(f"{given.deck} has no stage with train = true")
        if self.deck.get("irregularity", {}).get("kind", "none") != "none":
            sys.exit(f"{given.deck}: the loop has its own irregularity, leave out [irregularity]")
        if self.deck.get("track", {}).get("dimension", "plane") != "plane":
            sys.exit(f"{given.deck}: the loop has one rail: track.dimension must be \"plane\"")
        self.preload = trains[0].get("seat_force", 0)
        parts = chunks(absolute(text, given.deck.parent))
        parts[0] = ("", re.sub(r"(?m)^start\s*=.*\n", "", parts[0][1]))  # rounds have their own
        kept = [part for name, part in parts
                if name.split(".")[0] not in (*OF_THE_TRAIN, "stage", "load", "handover")]
        stages = [part for name, part in parts if name == "stage"]
        self.bed = "".join(kept) + "".join(stages[:names.index(done) + 1])
        sleepers = self.deck.get("sleepers", {})
        if missing := [key for key in ("first", "spacing", "count") if key not in sleepers]:
            sys.exit(f"{given.deck}: [sleepers] must say {' and '.join(missing)}")
        self.spare_inputs()
        launch.make_folder(given.folder)
        if given.force:  # or a stop would leave later rounds to the command that goes on
            for old in given.folder.iterdir():
                if OF_THE_LOOP.fullmatch(old.name):
                    shutil.rmtree(old) if old.is_dir() and not old.is_symlink() else old.unlink()
        self.start = given.start.resolve() if given.start else self.make_bed(done)
        self.x = sleepers["first"] + sleepers["spacing"] * np.arange(sleepers["count"])
        seat = self.deck.get("seat", {})
        self.rails = seat.get("rails", 1)
        self.on_track = sleepers["spacing"] * (seat.get("before", 20) + np.arange(len(self.x)))
        self.settled = np.zeros(len(self.x))  # m, what the rail's geometry has
        self.rows = []

    def spare_inputs(self):
        """Refuses what it would write over, or remove, of its own inputs."""
        given, folder = self.given, self.given.folder.resolve()

        def place(path):
            """Of the loop in its folder, by the first name below it."""
            inside = path.resolve().is_relative_to(folder) and path.resolve() != folder
            name = path.resolve().relative_to(folder).parts[0] if inside else ""
            return OF_THE_LOOP.fullmatch(name)
        named = re.findall(r'"([^"\n]*[./][^"\n]*)"', given.deck.read_text(encoding="utf-8"))
        files = [file for name in named if (file := given.deck.parent / name).is_file()]
        for path in (given.deck, *files):
            if place(path):
                sys.exit(f"{path} is where the loop writes its own: take another folder")
        if given.force and given.start and place(given.start):
            sys.exit(f"--force would remove {given.start}: copy it to another place, or take "
                     "another folder")

    def check(self):
        """Ends with the program's own sentences if the deck is not valid."""
        ran = launch.run([self.given.program, "check", self.given.deck], self.then,
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if ran.returncode:
            sys.exit(ran.stderr.rstrip())

    def last_stage(self, loop):
        """The stage after which the rounds begin, and the names of all."""
        given = self.given
        names = [stage["name"] for stage in self.deck.get("stage", [])]
        done = loop.get("after")
        if given.start:
            done = given.start.name.removeprefix("stage_").removesuffix(".h5")
            if not given.start.is_file():
                sys.exit(f"{given.start} is not there")
        if done not in names:
            sys.exit(f"{given.start} is no stage_NAME.h5 of {given.deck}" if given.start else
                     f"{given.deck}: [handover] with `after`, the name of a stage, is needed")
        made = self.deck["stage"][:names.index(done) + 1]
        of = str(given.start or f'{given.deck}: handover.after = "{done}"')
        if not any(stage["kind"] == "sleepers" for stage in made):
            sys.exit(f"{of}: the rounds weigh sleepers, which a later stage places")
        if any(stage.get("train") for stage in made):
            sys.exit(f"{of}: the rounds bring their own trains, the bed must end before one")
        return done, names

    def program(self, deck, text, folder, ranks, made_of=()):
        """Runs what `text` says, or what is still to do of it; it becomes the file `deck`, with a
        line on what the files it is made of hold."""
        for path in made_of:
            with path.open("rb") as file:
                text += f"# {path.name}: {hashlib.file_digest(file, 'sha256').hexdigest()}\n"
        summary, words = folder / "summary.json", ["run", deck, "-o", folder]
        if folder.exists():
            if not deck.is_file() or deck.read_text(encoding="utf-8") != text:
                sys.exit(f"{folder} holds a run of another deck: take another folder, or --force")
            if summary.is_file() and json.loads(summary.read_text(encoding="utf-8"))["finished"]:
                return
            if (folder / "latest").is_file():
                words = ["resume", folder]
            else:  # it ended before its first checkpoint
                words.append("--force")
        deck.write_text(text, encoding="utf-8")
        with open(f"{folder}.log", "w", encoding="utf-8") as log:
            ran = launch.run(launch.on_ranks(ranks, self.given.program, *words), self.then,
                             stdout=log, stderr=subprocess.STDOUT)
        if ran.returncode == launch.STOPPED:  # by its own deck
            launch.stop(self.then)
        if ran.returncode:
            last = Path(f"{folder}.log").read_text(encoding="utf-8").splitlines()[-5:]
            sys.exit("\n".join([*last, f"{folder} failed: see {folder}.log"]))

    def make_bed(self, last):
        """Checkpoint of the bed after stage `last`."""
        folder = self.given.folder / "bed"
        self.program(folder.with_suffix(".toml"), self.bed, folder, self.ranks)
        return (folder / f"stage_{last}.h5").resolve()

    def run_bed(self, stage, folder, load=None):
        """One stage more of the bed; histories of it."""
        self.bed += "\n" + table("[[stage]]", stage)
        text = f"start = {toml(str(self.start))}\n" + self.bed
        files = [self.start, *([Path(load["file"])] if load else [])]
        self.program(folder.with_suffix(".toml"), text + (table("[load]", load) if load else ""),
                     folder, self.ranks, files)
        self.start = (folder / f"stage_{stage['name']}.h5").resolve()
        with h5py.File(folder / "results.h5") as file:
            last = len(tomllib.loads(self.bed)["stage"]) - 1
            rows = file["history/stage"][()].ravel() == last
            found = {name: file[f"history/sleeper/{name}"][()][rows]
                     for name in ("displacement", "seat_force")}
            return file["history/time"][()].ravel()[rows], found

    def weigh(self, number, folder):
        """N/m, of the support of each sleeper and rail."""
        stage = {"name": f"weigh_{number}", "kind": "load", "duration": WEIGHING,
                 "load": self.given.load, "ramp": RAMP, "seat_force": self.preload,
                 "ground_moves": True, "local_damping": 0.2}
        time, sleeper = self.run_bed(stage, folder / "weigh")
        parts = np.array_split(np.flatnonzero(time >= time[-1] - RAMP), PARTS)
        return np.array([np.median([np.polyfit(z[part], force[part], 1)[0] for part in parts])
                         for z, force in zip(sleeper["displacement"].T,
                                             sleeper["seat_force"].T)]) / self.rails

    def track_deck(self, folder, stiffness):
        """Text of the track alone: the bed's stiffness, rail as the sleepers have settled."""
        parts = {name: dict(self.deck.get(name, {})) for name in OF_THE_TRAIN[:-1]}
        springs = parts["ballast"].get("stiffness", 60e6)
        if parts["ballast"].get("mass", 0) > 0:  # the factor of a zone acts on both springs
            springs = 1 / (1 / springs + 1 / parts["ballast"].get("below_stiffness", 80e6))
        spacing = self.deck["sleepers"]["spacing"]
        length = parts["track"].get("length", 60.0)
        z = folder / "geometry.csv"
        points = {0.0: 0.0, length: 0.0, self.on_track[0] - spacing: 0.0,
                  self.on_track[-1] + spacing: 0.0, **dict(zip(self.on_track, -self.settled))}
        z.write_text("x_m,z_m\n" + "".join(
            f"{float(x)!r},{float(points[x])!r}\n" for x in sorted(points) if 0 <= x <= length),
            encoding="utf-8")
        parts["irregularity"] = {"kind": "file", "file": z.name, "fade": spacing}
        parts["passage"].pop("duration", None)
        parts["passage"] |= {"points": [float(x) for x in self.on_track], "history_interval": 5e-4}
        del parts["seat"]
        text = 'model = "track"\n\n' + "".join(
            table(f"[{name}]", values) for name, values in parts.items() if values)
        zones = [*self.zones_of_deck(spacing),
                 *({"from": float(x - 0.45 * spacing), "to": float(x + 0.45 * spacing),
                    "bed": float(k / springs)} for x, k in zip(self.on_track, stiffness))]
        text += "".join(table("[[track.zone]]", zone) for zone in zones)
        text += "".join(table("[[vehicle]]", one) for one in self.deck.get("vehicle", []))
        return text

    def zones_of_deck(self, spacing):
        """Over the bed only what they do to the rail: the bed itself is weighed."""
        low, high = self.on_track[0] - 0.45 * spacing, self.on_track[-1] + 0.45 * spacing
        zones = []
        for zone in self.deck.get("track", {}).get("zone", []):
            begin, end = zone.get("from", 0), zone.get("to", 0)
            rail = {key: value for key, value in zone.items() if key not in ("bed", "gap")}
            for start, stop, kept in ((begin, min(end, low), zone),
                                      (max(begin, low), min(end, high), rail),
                                      (max(begin, high), end, zone)):
                if start < stop:
                    zones.append({**kept, "from": float(start), "to": float(stop)})
        return zones

    def pass_track(self, folder, stiffness):
        """Seat forces, N of one rail, [time, sleeper]; largest wheel force, N."""
        text = self.track_deck(folder, stiffness)
        self.program(folder / "track.toml", text, folder / "track", 1, [folder / "geometry.csv"])
        with h5py.File(folder / "track/results.h5") as file:
            time, force = file["history/time"][()].ravel(), file["history/sleeper/seat_force"][()]
            wheel = file["history/wheel/force"][()].max()
        force = force.reshape(len(time), -1)
        seats = folder / "seats.csv"
        with open(seats, "w", newline="", encoding="utf-8") as out:
            rows = csv.writer(out)
            rows.writerow(["time_s", *(f"sleeper_{i}" for i in range(len(self.x)))])
            rows.writerows([t, *(self.rails * row)] for t, row in zip(time, force))
        return seats, force, wheel

    def pass_bed(self, number, folder, seats):
        """m, what each sleeper loses under one train."""
        stage = {"name": f"trains_{number}", "kind": "passage", "cycles": self.given.trains,
                 "seat_force": self.preload, "ground_moves": True}
        _, sleeper = self.run_bed(stage, folder / "trains",
                                  {"kind": "seats", "file": str(seats.resolve())})
        lost = sleeper["displacement"][0] - sleeper["displacement"][-1]
        return lost / self.given.trains

    def round(self, number):
        folder = self.given.folder / f"round_{number}"
        launch.make_folder(folder)
        stiffness = self.weigh(number, folder)
        if not (stiffness > 0).all():
            sys.exit(f"round {number}: a sleeper has no support: {stiffness} N/m")
        seats, force, wheel = self.pass_track(folder, stiffness)
        lost = self.pass_bed(number, folder, seats)
        for i, x in enumerate(self.x):
            self.rows.append({"round": number, "x_m": x, "stiffness_N_m": stiffness[i],
                              "largest_seat_force_N": force[:, i].max(),
                              "largest_wheel_force_N": wheel, "settlement_per_train_m": lost[i],
                              "geometry_before_m": -self.settled[i]})
        self.settled = self.settled + lost * self.given.trains * self.given.each
        print(f"round {number}: support {stiffness.min() / 1e6:.1f} to {stiffness.max() / 1e6:.1f} "
              f"MN/m, seats up to {force.max() / 1e3:.1f} kN, wheels up to {wheel / 1e3:.1f} kN, "
              f"settlement per train {1e3 * lost.mean():.4f} mm (mean), {1e3 * lost.max():.4f} mm "
              "(most)", flush=True)

    def write(self):
        path = self.given.folder / "handover.csv"
        with open(path, "w", newline="", encoding="utf-8") as out:
            rows = csv.DictWriter(out, self.rows[0])
            rows.writeheader()
            rows.writerows(self.rows)
        shown = {"stiffness_N_m": ("support, MN/m", 1e-6),
                 "largest_seat_force_N": ("largest seat load, kN", 1e-3),
                 "settlement_per_train_m": ("settlement per train, mm", 1e3),
                 "geometry_before_m": ("geometry of the rail, mm", 1e3)}
        figure, panels = plt.subplots(len(shown), 1, figsize=(8, 10), sharex=True,
                                      layout="constrained")
        for panel, (name, (words, scale)) in zip(panels, shown.items()):
            for number in sorted({row["round"] for row in self.rows}):
                values = [scale * row[name] for row in self.rows if row["round"] == number]
                panel.plot(self.x, values, "o-", ms=4, lw=0.9, label=f"round {number}")
            panel.set(ylabel=words)
            panel.grid(alpha=0.3)
        panels[0].legend(fontsize=7)
        panels[-1].set(xlabel="x, m")
        figure.savefig(self.given.folder / "handover.png", dpi=130)
        plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("program", type=launch.program)
    parser.add_argument("deck", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--start", type=Path, help="checkpoint of an earlier run of the deck")
    parser.add_argument("--rounds", type=int)
    parser.add_argument("--trains", type=int, help="computed in a round")
    parser.add_argument("--each", type=float, help="trains that one stands for")
    parser.add_argument("--load", type=float, help="N on each seat while weighing")
    parser.add_argument("--force", action="store_true", help="do what FOLDER holds anew")
    loop = Loop(parser.parse_args())
    for number in range(loop.given.rounds):
        loop.round(number)
        loop.write()


if __name__ == "__main__":
    main()
