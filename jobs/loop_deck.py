"""The deck of a hand-over loop (handover.py): its checks, and the decks made from it.

Decks are processed as parsed values, not as text, so that dotted keys, inline tables and all kinds
of quotes have the same meaning as in the program. Names of files are recognised by the kinds of
parameters that `describe` prints (which also gives the defaults of missing keys), and are rewritten
relative to the location of each deck of the loop, so that a folder can be moved as a whole.
"""
import csv
import io
import json
import os
import re
import subprocess
import tomllib

import numpy as np

import launch
import support

OF_THE_TRAIN = ("rail", "pad", "under_sleeper_pad", "ballast", "track", "train", "wheel_rail",
                "irregularity", "irregularity_right", "passage")
# Keys of the train's stage that would end it before the last axle has left, or that the loop
# sets. All other keys also hold for the trains of the rounds.
INSTEAD = {"duration": "the loop's trains run until their last axle has left",
           "settlement": "it could end the stage before all trains of a round (handover.trains) "
                         "have passed",
           "cycles": "handover.trains is the number of trains in a round"}
LOAD_TEST = 0.3  # s, duration of the stage: its load rises in one half and falls in the other
FALL = 0.12  # s, its evaluated end, after a tenth of the unloading: before, the bed still settles


def is_section(value):
    """Whether the value has its own heading: a table, or a list of tables."""
    return isinstance(value, dict) or (
        isinstance(value, list) and bool(value) and all(isinstance(one, dict) for one in value))


def inline(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    if isinstance(value, str):  # escapes of JSON equal those of TOML except for one character
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(float(value) if isinstance(value, float) else value)


def toml(values, path=""):
    """Text of the values of a deck, or of the section at `path`."""
    text = "".join(f"{name} = {inline(value)}\n" for name, value in values.items()
                   if not is_section(value))
    for name, value in values.items():
        if is_section(value):
            head = f"[{path}{name}]" if isinstance(value, dict) else f"[[{path}{name}]]"
            for one in [value] if isinstance(value, dict) else value:
                text += f"\n{head}\n" + toml(one, f"{path}{name}.")
    return text


def parameters_of(program):
    """Kind and default (None: must be given) of each parameter, by section.name, from the output of
    `describe`."""
    ran = launch.run([program, "describe", "all"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                     text=True)
    if ran.returncode:
        launch.fail(ran, f"{program} describe all")
    found, section = {}, ""
    for line in ran.stdout.splitlines():
        if head := re.match(r"## `(.*)`", line):
            place = re.fullmatch(r"\[+([^\]]*)\]+", head[1])
            section = f"{place[1]}." if place else ""
        elif row := re.match(r"\| `(\w+)` \| ([^|]*) \| [^|]* \| `(.*?)` \|", line):
            default = None if row[3] == "must be given" else tomllib.loads(f"_ = {row[3]}")["_"]
            found[section + row[1]] = row[2], default
    return found


def with_files(values, parameters, change, path=""):
    """The values, with `change` applied to each name of a file."""
    def changed(name, value):
        if isinstance(value, dict):
            return with_files(value, parameters, change, f"{path}{name}.")
        if is_section(value):
            return [changed(name, one) for one in value]
        kind, _ = parameters.get(f"{path}{name}", ("", None))
        return change(value) if value and kind == "file" else value
    return {name: changed(name, value) for name, value in values.items()}


class LoopDeck:
    """The parts of the deck at `path` that the loop uses; the program has checked the deck."""

    def __init__(self, path, program):
        self.path, self.files = path, []
        self.parameters = parameters_of(program)
        try:
            values = tomllib.loads(path.read_text(encoding="utf-8-sig"))
        except tomllib.TOMLDecodeError as error:
            launch.refuse(f"{path}: {error}")
        self.values = with_files(values, self.parameters, self.whole)
        if not self.value("handover.after"):
            launch.refuse(f"{path}: [handover] must give `after`, the name of a stage")
        self.sleepers = self.section("sleepers")
        two = self.value("track.dimension") == "space"
        self.sides = ("left", "right") if two else ("",)  # rails that the track alone computes
        self.train = {}  # the stage

    def whole(self, name):
        """Path of a file relative to the folder of the deck, as in the program."""
        self.files.append(os.path.abspath(self.path.parent / name))
        return self.files[-1]

    def section(self, name):
        return self.values.get(name, {})

    def value(self, name):
        """Value of section.key, or the program's default."""
        section, key = name.split(".")
        return self.section(section).get(key, self.parameters[name][1])

    def text(self, values, folder):
        """Text of a deck that will be stored in `folder`. Links to folders are resolved, as names
        of files are relative to the location of the deck."""
        def named(name):
            place, last = os.path.split(name)
            return os.path.relpath(os.path.join(os.path.realpath(place), last),
                                   os.path.realpath(folder))
        return toml(with_files(values, self.parameters, named))

    def begin_after(self, done, of):
        """Refuses a stage `done` after which rounds cannot begin; `of` names the source of `done`
        in messages. Returns the values of the bed up to that stage."""
        stages = self.values["stage"]
        names = [stage["name"] for stage in stages]
        end = names.index(done) + 1
        if not any(stage.get("kind") == "sleepers" for stage in stages[:end]):
            launch.refuse(f"{of}: the rounds load the sleepers, which only a later stage places: "
                          "choose a later stage")
        if any(stage.get("train") for stage in stages[:end]):
            launch.refuse(f"{of}: the rounds add their own trains: choose a stage before the "
                          "first train")
        trains = [name for name, stage in zip(names, stages) if stage.get("train")]
        if not trains:
            launch.refuse(f"{self.path} has no stage with train = true")
        if len(trains) > 1:
            launch.refuse(f"{self.path}: the rounds use one kind of train, but the deck has "
                          f"several (stages {', '.join(trains)}): keep one of them")
        if left_out := [name for name in names[end:] if name != trains[0]]:
            launch.refuse(f"{of}: the rounds would omit the stages {', '.join(left_out)}: after "
                          "the stage from which the rounds begin, the deck may have only "
                          f"{trains[0]} (train = true); choose a later stage, or remove "
                          f"{', '.join(left_out)}")
        self.take_train(stages[names.index(trains[0])])
        self.refuse_others()
        kept = {name: value for name, value in self.values.items()
                if name not in (*OF_THE_TRAIN, "vehicle", "seat", "stage", "handover")}
        return {**kept, "stage": stages[:end]}

    def take_train(self, stage):
        for key, instead in INSTEAD.items():
            if stage.get(key, 0) > (1 if key == "cycles" else 0):
                launch.refuse(f"{self.path}: stage \"{stage['name']}\": {key} = {stage[key]} is "
                              f"not allowed in the loop: {instead}")
        self.train = {key: value for key, value in stage.items()
                      if key not in (*INSTEAD, "train", "name")}

    def refuse_others(self):
        if any(zone.get("spacing", 0) > 0 for zone in self.section("track").get("zone", [])):
            launch.refuse(f"{self.path}: track.zone: a zone with its own `spacing` is not possible "
                          "here, as the profiles of the rails have one value per sleeper at equal "
                          "distances: remove it")
        if self.value("irregularity.kind") != "none":
            launch.refuse(f"{self.path}: the loop sets its own irregularity: remove "
                          "[irregularity]")
        if self.value("irregularity_right.kind") not in ("none", "same"):
            launch.refuse(f"{self.path}: the loop sets its own irregularity: remove "
                          "[irregularity_right]")
        if missing := [key for key in ("first", "spacing", "count") if key not in self.sleepers]:
            launch.refuse(f"{self.path}: [sleepers] must give {' and '.join(missing)}")

        interval, rows = self.value("output.history_interval"), support.LEAST_ROWS
        if interval * rows > FALL:
            launch.refuse(f"{self.path}: output.history_interval = {interval:g} s: must be at most "
                          f"{FALL / rows:g} s, or support stiffnesses cannot be measured")

    def load_test(self, number, load):
        """Stage of a slow load, a haversine: a ramp has corners that excite ringing of the bed.
        Contacts and ground are those of the train's stage, stones have local damping."""
        own = {key: value for key, value in self.train.items()
               if key in ("seat_force", "ground_moves", "friction")}
        return {"name": f"load_test_{number}", "kind": "load", "duration": LOAD_TEST, "load": load,
                "cycles": 1, "local_damping": 0.2, **own}

    def trains(self, number, count):
        return {"name": f"trains_{number}", **self.train, "cycles": count}

    def seats_on_track(self):
        """x of the bed's sleepers from the begin of the track, m. Zones with a spacing of their own
        are refused: profile and stiffness of the loop's track have one value per sleeper."""
        return self.sleepers["spacing"] * (self.value("seat.before")
                                           + np.arange(self.sleepers["count"]))

    def springs(self):
        """Stiffness below a sleeper of the track alone outside of zones, N/m."""
        springs = self.value("ballast.stiffness")
        if self.value("ballast.mass") > 0:  # the factor of a zone applies to both springs
            springs = 1 / (1 / springs + 1 / self.value("ballast.below_stiffness"))
        return springs

    def geometry(self, settled):
        """Text of a rail's profile, which follows the settlement of its seats, m."""
        spacing, length = self.sleepers["spacing"], self.value("track.length")
        at = self.seats_on_track()
        points = {0.0: 0.0, length: 0.0, at[0] - spacing: 0.0, at[-1] + spacing: 0.0,
                  **dict(zip(at, 0.0 - settled))}  # avoids -0.0
        return "x_m,z_m\n" + "".join(f"{float(x)!r},{float(points[x])!r}\n"
                                     for x in sorted(points) if 0 <= x <= length)

    def track_alone(self, stiffness, geometry):
        """Values of a track alone on springs of the bed's stiffness, N/m; `geometry`: a file for
        each rail."""
        deck = {"model": "track", **{name: dict(self.section(name)) for name in OF_THE_TRAIN},
                "vehicle": self.values.get("vehicle", [])}
        at, spacing = self.seats_on_track(), self.sleepers["spacing"]
        deck["passage"].pop("duration", None)
        deck["passage"]["points"] = [float(x) for x in at]
        deck["output"] = {"history_interval": 5e-4}
        for section, file in zip(("irregularity", "irregularity_right"), geometry):
            deck[section] = {"kind": "file", "file": str(file), "fade": spacing}
        own = [{"from": float(x - 0.45 * spacing), "to": float(x + 0.45 * spacing),
                "bed": float(k / self.springs())} for x, k in zip(at, stiffness)]
        deck["track"]["zone"] = self.zones() + own
        return {name: value for name, value in deck.items() if value}

    def zones(self):
        """Zones of the deck; over the bed only what acts there, as the load test gives the springs
        and the bed the masses."""
        at, spacing = self.seats_on_track(), self.sleepers["spacing"]
        low, high = at[0] - 0.45 * spacing, at[-1] + 0.45 * spacing
        zones = []
        for zone in self.section("track").get("zone", []):
            begin, end = zone["from"], zone["to"]
            rail = {key: value for key, value in zone.items()
                    if key in ("from", "to", "rail", "pad", "side")}
            for start, stop, kept in ((begin, min(end, low), zone),
                                      (max(begin, low), min(end, high), rail),
                                      (max(begin, high), end, zone)):
                if start < stop:
                    zones.append({**kept, "from": float(start), "to": float(stop)})
        return zones


def table_of_seats(time, force, sides):
    """Text of a history of seat forces, N, [time, sleeper, side]."""
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(["time_s", *(f"sleeper_{i}{side and '_' + side}" for i in range(force.shape[1])
                               for side in sides)])
    rows.writerows([t, *row.ravel()] for t, row in zip(time, force))
    return out.getvalue()
