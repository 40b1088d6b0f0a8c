#!/usr/bin/env python3
"""A track alone: parameters without effect and implausible values are reported by `check`; decks
that cannot be computed are refused before anything runs.

    track_warnings.py PROGRAM DECKS FOLDER
"""
import math
import os
import pathlib
import shutil
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, summary  # noqa: E402

FORCE = """
[[force]]
at = 5
"""
ZONE = """
[[track.zone]]
from = {}
to = {}
{}
"""
VEHICLE = """
[[vehicle]]
name = "own"
{}
"""
COACH = """kind = "coach"
length = 20
body_mass = 30e3
bogie_mass = 2e3
wheelset_mass = 1e3
primary_stiffness = 1e6
secondary_stiffness = 1e6
bogie_distance = 18
wheelbase = 2.5
"""
SEATS = ["train.vehicles=[]", "passage.loaded_by=seats", "load.axles=[0, 2.8, 9.0, 11.8]",
         "irregularity.kind=none", "irregularity.fade=10", "train.start=10"]
OWN = ['train.vehicles=["own"]']
TWO_RAILS = ["track.dimension=space", *OWN]
NO_TRAIN = ["train.vehicles=[]", "passage.duration=0.1"]
# Changes of the plain deck, text added to it, part of the refusal.
REFUSED = [
    (["track.ends=free"], ZONE.format(0, 60, "bed = 0"), "leaves 0 supports of the rail"),
    (["track.ends=free"], ZONE.format(0, 59.9, "gap = 1e-3"), "leaves 1 support of the rail"),
    (["track.ends=free", "track.dimension=space"],
     ZONE.format(0, 60, 'gap = 1e-3\nside = "right"'), "leaves 0 supports of the rail"),
    (["track.ends=free", "track.support=continuous"], ZONE.format(0, 60, "bed = 0"),
     "leaves 0 supports of the rail"),
    (["track.dimension=space"], ZONE.format(20, 30, 'sleeper = 2\nside = "left"'),
     'track.zone[0].side = "left": must be "both" with `sleeper`, `footprint` or `spacing`'),
    (SEATS, ZONE.format(10, 10.7, "gap = 1e-3"),
     "track.zone[0].gap = 0.001: must be 0 with seat loads"),
    (SEATS, ZONE.format(10, 10.7, "bed = 0.0"),
     "track.zone[0].bed = 0.0: must be above 0 with seat loads"),
    ([*SEATS, "track.sleeper.model=beam"], ZONE.format(10, 10.7, "bed = 0.0"),
     "track.zone[0].bed = 0.0: must be above 0 with seat loads"),
    (["ballast.mass=500"], ZONE.format(10, 10.7, "bed = 0.0"),
     "track.zone[0].bed = 0.0: must be above 0 with a mass of the ballast"),
    (["track.spacing=1e-5"], "", "gives 2.4e+07 elements for 60 m of rail"),
    (["track.spacing=1e-17"], ZONE.format(0, 60, "bed = 2"), "elements for 60 m of rail"),
    (["track.run_in_factor=1e7"], "", "must be at least 1 and at most 1000000"),
    ([], VEHICLE.format('kind = "forces"\nlength = 20\naxles = [15, 3]\nloads = [1e5, 1e5]'),
     "must increase: the first axle is the foremost one"),
    (["passage.duration=0.1"], '[[force]]\nat = 5\nsize = 1e3\nkind = "impact"\nlength = 1e-5\n',
     "force[0].length = 1e-05: gives an impact of 1e-05 s"),
    (["passage.duration=0.1"], "[[force]]\nat = 5\nsize = 1e3\nfrequency = 4e3\n",
     "force[0].frequency = 4000.0: gives periods of 0.00025 s"),
    (["irregularity.shortest=1e-5"], "", "irregularity.shortest = 1e-05: gives 1.2e+08 samples"),
    ([], VEHICLE.format('like = "hxd1_unit"\nbody_mass = 30e3'),
     "vehicle[0].body_mass = 30000.0: has no effect: it is for vehicles of kind coach or sprung"),
    ([], VEHICLE.format('like = "manchester"'), 'must be "", "manchester_1", "alfa_pendular"'),
    ([], VEHICLE.format('like = "manchester_1"\nkind = "wheel"'),
     'must be "coach", that of the library vehicle manchester_1 (`like`)'),
    ([], VEHICLE.format('like = "hxd1_unit"\nkind = "coach"'),
     'must be "forces", that of the library vehicle hxd1_unit (`like`)'),
    ([], VEHICLE.format('like = "manchester_1"\naxles = [1]\nloads = [1e5]'),
     "is only for vehicles of constant forces"),
    (["train.speed=0"], "", "train.speed = 0: the train does not move: train.speed or one of "
     "train.speeds must be above 0 m/s, or passage.duration above 0 s"),
    ([], VEHICLE.format('like = "manchester_1"\nbogie_distance = 2'),
     "vehicle[0].bogie_distance = 2: must exceed the wheelbase of 2.56 m"),
    ([], VEHICLE.format(COACH.replace("= 18", "= 2.5")),
     "vehicle[0].bogie_distance = 2.5: must exceed the wheelbase of 2.5 m"),
    (["track.dimension=space", "track.gauge=1.9", "track.sleeper_length=1.6"], "",
     "track.sleeper_length = 1.6: must be above the distance of the rail centrelines, track.gauge "
     "= 1.9 m: rails rest on the sleepers"),
    # 30 t of body on 8 t of bogies and wheelsets tip over with 38/30 of half the gauge.
    (TWO_RAILS, VEHICLE.format(COACH.replace("= 20", "= 21") + "body_offset = -0.951\n"),
     "vehicle[0].body_offset = -0.951: tips the vehicle over: on rails 1.5 m apart (track.gauge) "
     "its magnitude must be below 0.95 m"),
    (TWO_RAILS, VEHICLE.format('like = "manchester_1"\nbody_offset = 2'),
     "vehicle[0].body_offset = 2: tips the vehicle over"),
]
WARNED = [
    (["passage.duration=0.1"], '[[force]]\nat = 5\nsize = 1e3\nkind = "impact"\nlength = 1e-3\n',
     "resolve it poorly"),
    (["passage.duration=0.1"], FORCE.replace("5", "60"), "the force has no effect"),
    (["passage.duration=0.1"], FORCE.replace("5", "0"), "which is pinned (track.ends)"),
    (["track.dimension=space", "irregularity_right.kind=spectrum"], "",
     "irregularity_right.seed = 1 (default): is that of the left rail (1): both profiles"),
    (['train.vehicles=["hxd1_unit"]', "wheel_rail.flat_axle=1", "wheel_rail.flat_length=0.05"], "",
     "is an axle of constant force, which does not roll"),
    ([], VEHICLE.format('like = "manchester_1"'),
     'vehicle[0].name = "own": is no vehicle of the train (train.vehicles)'),
    ([], ZONE.format(70, 80, "bed = 2"), "begins a zone outside of the track"),
    ([], ZONE.format(20, 30, "bed = 1.0"), "begins a zone without effect"),
    ([], ZONE.format(20.5, 20.9, "pad = 2"), "begins a zone without a sleeper"),
    (SEATS, ZONE.format(20, 30, "pad = 2"), "track.zone[0].pad = 2: has no effect: there are no "
     "pads with seat loads"),
    (["track.support=continuous"], ZONE.format(20, 30, "sleeper = 2"),
     "track.zone[0].sleeper = 2: has no effect: there are no sleepers"),
    ([], ZONE.format(20, 30, "under_sleeper_pad = 2"),
     "track.zone[0].under_sleeper_pad = 2: has no effect: no sleeper of the zone has an"),
    (["under_sleeper_pad.stiffness=8e7", "under_sleeper_pad.from=31"],
     ZONE.format(20, 30, "under_sleeper_pad = 2"), "no sleeper of the zone has an under-sleeper"),
    ([], ZONE.format(20, 30, "footprint = 2"),
     "track.zone[0].footprint = 2: has no effect: there are no footprints"),
    (["passage.duration=0.1"], FORCE + "begin = 0.1\n", "is after the end of the run at 0.1 s"),
    ([], FORCE + "begin = 2\n", "is after the end of the run at 1.631 s"),
    (NO_TRAIN, FORCE, "train.start = 0: has no effect: there are no vehicles"),
    (NO_TRAIN, FORCE, 'irregularity.kind = "spectrum": has no effect: there are no vehicles'),
    ([*NO_TRAIN, "train.speed=40"], FORCE,
     "train.speed = 40: has no effect: there are no vehicles"),
    ([*NO_TRAIN, "train.times=[0.1]", "train.speeds=[49.9]"], FORCE,
     "train.times = [0.1]: has no effect: there are no vehicles"),
    ([*NO_TRAIN, "wheel_rail.wheel_radius=0.5"], FORCE, "has no effect: there are no vehicles"),
    (["passage.duration=1e-4"], "", "is shorter than a time step (passage.step)"),
    (["irregularity.kind=vee", "irregularity.at=5", "train.start=40"], "",
     "irregularity.at = 5: puts the irregularity where no wheel rolls: wheels roll from 18.44 m "
     "on"),
    (["irregularity.kind=joint", "irregularity.at=3"], "",
     "irregularity.at = 3: puts all of the irregularity into a run-in or run-out (track.run_in: up "
     "to 6 m and from 54 m on)"),
    (["irregularity.kind=versine", "irregularity.at=5.9", "irregularity.length=2"], "",
     "irregularity.at = 5.9: puts most of the irregularity into a run-in"),
    (["irregularity.kind=vee", "irregularity.at=60"], "",
     "puts all of the irregularity into a run-in"),
    (["irregularity.kind=waves", "irregularity.at=50", "irregularity.waves=10",
      "irregularity.length=1"], "",
     "irregularity.at = 50: puts most of the irregularity into a run-in"),
    (["irregularity.kind=waves", "irregularity.at=20", "passage.duration=0.3"], "",
     "irregularity.at = 20: puts the irregularity where no wheel rolls: wheels roll up to 15 m"),
    ([], ZONE.format(30.1, 30.5, "bed = 2"),
     "without a sleeper or another support of the rail: only `rail` has an effect"),
    ([], ZONE.format(30.1, 30.2, "rail = 2"), "does not contain the middle of any rail element"),
    ([], ZONE.format(0, 60, "bed = 0"), "leaves no support of the rail between its pinned ends"),
    (["irregularity.kind=none", "irregularity.depth=1e-3", "irregularity.at=20"], "",
     'irregularity.at = 20: has no effect with irregularity.kind = "none"'),
    (["irregularity.kind=versine", "irregularity.at=70"], "",
     "puts the irregularity outside of the track"),
    (["irregularity.fade=0"], "", "the random profile begins with a step at x = 0"),
    (["passage.step=4e-3"], "", "lets wheels travel 0.2 m in a step, more than an element"),
    (["irregularity.kind=waves", "irregularity.at=20", "irregularity.length=0.01",
      "irregularity.waves=100"], "", "irregularity.length = 0.01: is only 1 times the travel of "
     "wheels in a step (0.01 m at 50 m/s in 0.0002 s)"),
    (["irregularity.kind=joint", "irregularity.length=0.008"], "",
     "irregularity.length = 0.008: is only 0.8 times the travel of wheels in a step"),
    (["irregularity.kind=vee", "irregularity.length=0.11", "train.times=[1]", "train.speeds=[56]"],
     "", "in a step (0.0112 m at 56 m/s in"),
    (["irregularity.shortest=0.09"], "",
     "irregularity.shortest = 0.09: is only 9 times the travel"),
    (["track.dimension=space", "irregularity_right.kind=versine", "irregularity_right.length=0.05"],
     "", "irregularity_right.length = 0.05: is only 5 times the travel"),
    (["wheel_rail.flat_axle=2", "wheel_rail.flat_length=0.04"], "",
     "wheel_rail.flat_length = 0.04: is only 4 times the travel"),
    (["wheel_rail.stiffness=1e9"], "", 'has no effect with law = "hertz"'),
    (["wheel_rail.law=linear", "wheel_rail.constant=1e11"], "", 'effect with law = "linear"'),
    (["ballast.below_stiffness=70e6"], "", "has no effect without a mass of the ballast"),
    (["ballast.below_damping=7e3"], "", "has no effect without a mass of the ballast"),
    (["pad.bilinear_stiffness=3e8"], "", "has no effect with bilinear_at = 0"),
    (["pad.bilinear_at=1e-4", "pad.bilinear_stiffness=3e8", "pad.damping=0"], "",
     "pad.damping = 0: leaves bilinear pads undamped: energy may increase in steps"),
    (["under_sleeper_pad.damping=1e4"], "", "has no effect without a stiffness of the pad"),
    (["under_sleeper_pad.to=9"], "", "has no effect without a stiffness of the pad"),
    (["under_sleeper_pad.stiffness=8e7", "under_sleeper_pad.from=60.1"], "",
     "no sleeper has a pad: no sleeper of the track (0 to 60 m) lies"),
    (['train.vehicles=["own"]', "vehicle.own.length=15"], VEHICLE.format(COACH),
     "is less than the 20.5 m that its axles need"),
    # In t, MN/m, kN s/m, kN, mm.
    ([], VEHICLE.format('like = "manchester_1"\nbody_mass = 81'),
     "vehicle[0].body_mass = 81 is outside the usual values (100 to 200000 kg)"),
    ([], VEHICLE.format('like = "manchester_1"\nprimary_stiffness = 2.44'),
     "vehicle[0].primary_stiffness = 2.44 is outside the usual values (50000 to 1e+09 N/m)"),
    ([], VEHICLE.format('like = "manchester_1"\nsecondary_damping = 130'),
     "vehicle[0].secondary_damping = 130 is outside the usual values (500 to 1e+07 N s/m)"),
    ([], VEHICLE.format('like = "hxd1_unit"\nloads = [245, 245, 245, 245]'),
     "vehicle[0].loads[0] = 245 is outside the usual values (500 to 1e+06 N)"),
    (["wheel_rail.rail_radius=3e-4"], "",
     "wheel_rail.rail_radius = 0.0003 is outside the usual values (0.01 to 1 m)"),
    *(([f"{key}={value}", "track.sleeper.model=beam"], "", f"{key} = {value} is outside the usual")
      for key, value in (("rail.mass", 1e-09), ("rail.area", 1e-05), ("rail.inertia", 1e-09),
                         ("track.sleeper_mass", 0.3), ("track.sleeper.width", 0.001),
                         ("track.sleeper.height", 0.001))),
    (["track.dimension=space", "track.sleeper_length=0.26", "track.gauge=0.2"], "",
     "track.sleeper_length = 0.26 is outside the usual"),
    (["train.start=-400", "passage.duration=0.2"], "",
     "train.start = -400: the train does not reach the track: its first axle is at -390 m at the "
     "end of the run (0.2 s"),
    (["train.start=-1e6"], "", "train.start = -1000000 is outside the usual values (-500 to"),
    ([], VEHICLE.format('kind = "wheel"\nlength = 2\nwheelset_mass = 1e3\nbody_mass = 1e3'),
     "vehicle[0].body_mass = 1000.0: has no effect: it is for vehicles of kind coach or sprung or"),
]
# Parameters with a value, and words of the command line that leave them without effect; and those
# that give them one.
IDLE = [
    ("there is one rail", [], ["track.dimension=space"],
     {**{f"vehicle[0].{key}": f"vehicle.own.{key}={value}" for key, value in (
         ("body_offset", 0.05), ("body_roll", 50e3), ("bogie_roll", 1500), ("primary_base", 1.9),
         ("wheelset_roll", 900), ("secondary_base", 1.9))},
      **{f"track.{key}": f"track.{key}={value}" for key, value in (
          ("gauge", 1.6), ("sleeper_length", 2.5), ("sleeper_inertia", 150))}}),
    ("there is one rail", [], ["track.sleeper.model=beam"],
     {f"track.{key}": f"track.{key}={value}" for key, value in (
         ("gauge", 1.6), ("sleeper_length", 2.5))}),
    ("sleepers are rigid", [], ["track.sleeper.model=beam"],
     {f"track.sleeper.{key}": f"track.sleeper.{key}={value}" for key, value in (
         ("theory", "euler"), ("young", 30e9), ("poisson", 0.25), ("width", 0.3), ("height", 0.22),
         ("elements", 6))}),
    ("the rail has no continuous support", [], ["track.support=continuous"],
     {f"track.{key}": f"track.{key}={value}" for key, value in (
         ("bed_stiffness", 40e6), ("bed_damping", 40e3))}),
    ("there are no sleepers", ["track.support=continuous"], ["track.support=sleepers"],
     {"pad": "pad.stiffness=80e6", "ballast": "ballast.damping=50e3",
      "track.sleeper_mass": "track.sleeper_mass=250"}),
    ("there are no sleepers", ["track.support=continuous", "track.dimension=space"],
     ["track.support=sleepers"], {"track.sleeper_length": "track.sleeper_length=2.5"}),
    ("no axle has a flat", [], ["wheel_rail.flat_axle=1"],
     {"wheel_rail.flat_length": "wheel_rail.flat_length=0.12",
      "wheel_rail.flat_at": "wheel_rail.flat_at=8"}),
    ("there is no run-in", ["track.run_in=0"], ["track.run_in=6"],
     {"track.run_in_factor": "track.run_in_factor=50"}),
    ("a rail that is supported only at its ends has no run-in", ["track.support=none"],
     ["track.support=sleepers"],
     {"track.run_in": "track.run_in=5", "track.run_in_factor": "track.run_in_factor=50"}),
    ("the rail is rigid in shear", ["rail.theory=euler"], ["rail.theory=timoshenko"],
     {"rail.poisson": "rail.poisson=0.27", "rail.shear_factor": "rail.shear_factor=0.34"}),
    ("seat loads replace rail and train", SEATS,
     ['train.vehicles=["manchester_1"]', "passage.loaded_by=train", "load.axles=[]"],
     {"pad": "pad.damping=20e3", "rail": "rail.section=54E1", "train.speed": "train.speed=40",
      "train.start": "train.start=0", "wheel_rail": "wheel_rail.wheel_radius=0.5",
      "irregularity.kind": "irregularity.kind=vee"}),
    ("axles of constant force do not roll",
     ['train.vehicles=["hxd1_unit"]', "irregularity.kind=none", "irregularity.fade=10",
      "track.dimension=space"], ['train.vehicles=["hxd1_unit","manchester_1"]'],
     {"wheel_rail": "wheel_rail.wheel_radius=0.5", "irregularity.kind": "irregularity.kind=vee",
      "irregularity_right.kind": "irregularity_right.kind=joint"}),
]
# Decks that must not give a warning.
SOUND = [
    ([], ""), (["track.ends=free"], ZONE.format(1, 59, "bed = 0")),
    (["track.ends=free", "track.support=continuous"], ZONE.format(0.3, 60, "bed = 0")),
    (["under_sleeper_pad.stiffness=8e7", "under_sleeper_pad.from=30"], ""),
    ([], ZONE.format(-1, 11.9, "bed = 2")), ([], ZONE.format(59.9, 60, "bed = 2")),
    (["track.ends=free", "passage.duration=0.1"], FORCE.replace("5", "60")),
    (OWN, VEHICLE.format('like = "manchester_1"\nbody_mass = 40e3')),
    (OWN, VEHICLE.format('like = "manchester_1"\nkind = "coach"')),
    (OWN, VEHICLE.format(COACH.replace('kind = "coach"\n', "").replace("20", "21"))),
    (OWN, VEHICLE.format('like = "x2_bogie"\nbogie_mass = 3e3\nsecondary_damping = 30e3\n'
                        'wheelbase = 2.5')),
    (["irregularity.kind=waves", "irregularity.at=20", "irregularity.fade=10"], ""),
    (["track.dimension=space", "track.support=continuous", "track.gauge=1.9"], ""),
    # Without a vehicle its start does not matter.
    (["train.vehicles=[]", "train.start=10", "irregularity.kind=none", "irregularity.fade=10",
      "track.length=6", "track.run_in=2", "passage.duration=0.01", "passage.points=[3]"], FORCE),
    (['train.vehicles=["hxd1_unit"]', "irregularity.kind=none", "irregularity.fade=10"], ""),
    (["irregularity.kind=vee", "train.start=35"], ""),
    (["train.start=-8", "passage.duration=0.2"], ""),
    (["train.speed=0", "train.start=30", "passage.duration=0.1"], ""),
    (OWN, VEHICLE.format('like = "manchester_1"\nbogie_distance = 2.6')),
    (["rail.mass=5", "rail.area=1e-3", "track.sleeper_mass=20"], ""),
    (["irregularity.kind=joint", "irregularity.fade=10", "irregularity.length=0.1"], ""),
    (["irregularity.shortest=0.1", "wheel_rail.flat_axle=1", "wheel_rail.flat_length=0.1"], ""),
    (["irregularity.kind=joint", "irregularity.length=0.05", "passage.step=1e-4"], ""),
]


def deck_with(decks, folder, more):
    path = folder / "changed.toml"
    path.write_text((decks / "plain.toml").read_text(encoding="utf-8") + more, encoding="utf-8")
    return path


def check_sentences(program, decks, folder):
    for changes, more, words in part(REFUSED):
        ran = program(1, "check", deck_with(decks, folder, more), *changes)
        if ran.returncode != 2 or words not in ran.stderr:
            raise SystemExit(f"{changes} {more} must be refused with {words}:\n"
                             f"{ran.stdout}{ran.stderr}")
    for changes, more, words in part(WARNED):
        ran = program.done(1, "check", deck_with(decks, folder, more), *changes)
        if not any(line.startswith("warning: ") and words in line
                   for line in ran.stdout.splitlines()):
            raise SystemExit(f"{changes} {more} must warn of {words}:\n{ran.stdout}")
    for changes, more in part(SOUND):
        ran = program.done(1, "check", deck_with(decks, folder, more), *changes)
        if "warning: " in ran.stdout:
            raise SystemExit(f"{changes} {more} must not warn:\n{ran.stdout}")


def check_windows(program, decks):
    """On a bed the step of the train is a window, which is shorter than passage.step."""
    words = ["irregularity.kind=joint", "irregularity.at=18"]
    for length, wanted in (("1e-3", True), ("2e-2", False)):
        ran = program.done(1, "check", decks / "transition_train.toml", *words,
                           f"irregularity.length={length}")
        if ("times the travel of wheels in a step" in ran.stdout) != wanted:
            raise SystemExit(f"a joint of {length} m on a bed:\n{ran.stdout}")


def check_idle(program, decks, folder):
    """Parameters without effect because of another one give a warning, otherwise none."""
    deck = deck_with(decks, folder, VEHICLE.format('like = "manchester_1"'))
    for why, around, remedy, parameters in part(IDLE):
        words = list(parameters.values())
        for changes, given, wanted in ((around, words, parameters), (around, [], ()),
                                       ([*around, *remedy], words, ())):
            ran = program.done(1, "check", deck, *changes, *given)
            reported = [line.partition(": ")[2] for line in ran.stdout.splitlines()
                        if line.startswith("warning: ") and f"has no effect: {why}" in line]
            if len(reported) != len(wanted) or not all(
                    any(f"{key}: " in one or f"{key} = " in one for one in reported)
                    for key in wanted):
                raise SystemExit(f"{changes} {given} must warn of {list(wanted)}, not {reported}")


def check_files(program, decks, folder):
    """Heights in millimetres and rows that end early: reported by check, and kept by the run."""
    table = folder / "profile.csv"
    words = ["irregularity.kind=file", f"irregularity.file={table.resolve()}",
             "passage.duration=0.01"]
    for rows, sentences in (("0,0\n30,0.4\n60,0\n",
                             ["are up to 0.4 m (usual: at most 0.1 m); are they"]),
                            ("0,0\n30,-1e-3\n", ["has rows from 0 to 30 m, but the track"]),
                            ("20,1e-3\n60,-1e-3\n", ["has rows from 20 to 60 m"]),
                            ("20,0\n25,-1e-3\n30,0\n", []),
                            ("0,0\n60,-1e-3\n", [])):
        table.write_text("x_m,z_m\n" + rows, encoding="utf-8")
        ran = program.done(1, "check", decks / "plain.toml", *words)
        reported = [line for line in ran.stdout.splitlines() if line.startswith("warning: ")]
        program.done(1, "run", decks / "plain.toml", *words, "--force", "-o", folder / "run")
        kept = summary(folder / "run")["warnings"]
        for lines in (reported, kept):
            if len(lines) != len(sentences) or not all(
                    sentence in line for sentence, line in zip(sentences, lines)):
                raise SystemExit(f"{rows}: {sentences} is wanted, not {lines}")


def check_steps(program, decks, folder):
    """Wheels start on an even rail: a file that begins higher is a step, unless it fades in."""
    table = folder / "step.csv"
    words = ["irregularity.kind=file", f"irregularity.file={table.resolve()}",
             "irregularity.fade=0"]
    high, right = "0,0.01\n60,0.01\n", [word.replace("irregularity.", "irregularity_right.")
                                        for word in [*words, "track.dimension=space"]]
    for rows, changes, step in (
            (high, [], "a step of 10 mm at x = 0"), ("0,0\n60,-1e-3\n", [], ""),
            ("-5,0\n0,-2e-3\n60,0\n", [], "a step of -2 mm"),
            ("-5,0\n5,4e-3\n60,0\n", ["train.start=20"], "a step of 2 mm"),
            (high, ["irregularity.fade=10"], ""), (high, ["train.start=25"], ""),
            (high, ['train.vehicles=["hxd1_unit"]'], ""),
            (high, ["irregularity.kind=none", *right], "irregularity_right.file: ")):
        table.write_text("x_m,z_m\n" + rows, encoding="utf-8")
        ran = program.done(1, "check", decks / "plain.toml", *words, *changes)
        reported = [line for line in ran.stdout.splitlines()
                    if line.startswith("warning: irregularity") and "a step of" in line]
        if len(reported) != (step != "") or not all(step in line for line in reported):
            raise SystemExit(f"{rows} {changes}: '{step}' is wanted, not {reported}")


def check_profiles(program, decks, folder):
    """Profiles that wheels cannot follow: jumps between rows and changes of slope, but no slope by
    itself, however steep and long, and nothing beyond the path of the wheels."""
    table = folder / "struck.csv"
    words = ["irregularity.kind=file", f"irregularity.file={table.resolve()}",
             "passage.duration=0.6", "irregularity.fade=0"]
    fine = "".join(f"{i / 1000:.3f},{{}}\n" for i in range(60001))
    smooth = [1e-3 * (1 - math.cos(2 * math.pi * i / 1000)) for i in range(60001)]
    jumped = [z + (3e-4 if i > 20000 else 0) for i, z in enumerate(smooth)]
    jump, kink = "jumps by {} mm at x = {} m", "changes its slope by {} mrad at x = {} m"
    for rows, changes, wanted in (
            ("0,0\n20,0\n20.001,1e-3\n60,1e-3\n", [], jump.format(1, 20)),
            # Wheels lose contact at a step downwards.
            ("0,0\n20,0\n20.002,-3e-4\n60,0\n", [], ""),
            ("0,0\n20,-3e-4\n20.002,0\n60,0\n", [], jump.format(0.3, 20)),
            ("0,0\n20,0\n20.001,1e-3\n20.002,0\n60,0\n", [], jump.format(1, 20.001)),
            ("0,0\n25,0\n60,0\n", [], ""),
            ("0,0\n10,0.05\n20,0\n60,0\n", [], ""),
            ("0,0\n19.9,0\n20,-5e-3\n20.12,0\n60,0\n", [], kink.format(91.7, 20)),
            ("0,0\n19.9,0\n20,-5e-3\n20.12,0\n60,0\n", ["train.speed=15"], ""),
            ("0,0\n19.9,0\n20,-5e-3\n20.12,0\n60,0\n", ["train.start=45"], ""),
            ("0,0\n19.9,0\n20,-5e-3\n20.12,0\n60,0\n", ["passage.duration=0.3"], ""),
            ("0,0\n19.9,0\n20,-5e-3\n20.12,0\n60,0\n", ['train.vehicles=["hxd1_unit"]'], ""),
            # Equidistant rows: wheels roll on a cubic spline without kinks.
            ("".join(f"{i / 4},{-4e-3 * (i == 80)}\n" for i in range(241)), [], ""),
            (fine.format(*smooth), [], ""),
            # Between 20 and 20.001 m, located to some mm; the cubic overshoots.
            (fine.format(*jumped), [], "jumps by 0.307 mm at x = 19.998 m")):
        table.write_text("x_m,z_m\n" + rows, encoding="utf-8")
        ran = program.done(1, "check", decks / "plain.toml", *words, *changes)
        reported = [line for line in ran.stdout.splitlines() if line.startswith("warning: ") and
                    "no effect" not in line]
        if len(reported) != (wanted != "") or not all(wanted in line for line in reported):
            raise SystemExit(f"{rows[:80]} {changes}: '{wanted}' is wanted, not {reported}")


def check_strikes(program, decks, folder):
    """The reported force at a place is that of a run over it, within 30 %."""
    table, place = folder / "struck.csv", folder / "struck"
    words = ["irregularity.kind=file", f"irregularity.file={table.resolve()}",
             "irregularity.fade=0", "train.start=12"]
    vee = "0,0\n19.9,0\n20,-5e-3\n20.12,0\n60,0\n"
    for rows, changes in ((vee, ["passage.duration=0.2"]),
                          (vee, ["passage.duration=0.12", "train.speed=80"]),
                          (vee, ["passage.duration=0.2", "wheel_rail.law=linear"]),
                          ("0,0\n15,-0.05\n17,0\n60,0\n",
                           ["passage.duration=0.12", "train.speed=80"]),
                          ("0,0\n20,0\n20.001,1e-3\n60,1e-3\n", ["passage.duration=0.2"]),
                          ("0,0\n20,0\n20.001,1e-3\n60,1e-3\n",
                           ["passage.duration=0.2", "passage.step=5e-5"]),
                          ("0,0\n20,-3e-4\n20.002,0\n60,0\n",
                           ["passage.duration=0.2", "wheel_rail.law=linear",
                            "wheel_rail.stiffness=6e8"])):
        table.write_text("x_m,z_m\n" + rows, encoding="utf-8")
        program.done(1, "run", decks / "plain.toml", *words, *changes, "--force", "-o", place)
        ran = summary(place)
        reported = [float(text.partition("reaches about ")[2].split()[0])
                    for text in ran["warnings"] if "reaches about " in text]
        force = ran["track"]["wheel_force_max_n"] / 1e3
        print(f"{rows.splitlines()[1:3]} {changes}: reported {reported}, a run has {force:.0f} kN")
        if len(reported) != 1 or not 0.7 < reported[0] / force < 1.3:
            raise SystemExit(f"{rows} {changes}: {reported} kN reported, a run has {force:.0f} kN")


def check_places(program, decks, folder):
    """Jumps 20 mm apart are counted as separate places."""
    table = folder / "stairs.csv"
    for count, words in ((1, "x = 20 m (limit "), (2, "x = 20 m and at 1 other place (limit "),
                         (40, "x = 20 m and at 39 other places (limit ")):
        steps = "".join(f"{20 + 0.02 * i:.4f},{3e-4 * i:.4g}\n{20.0005 + 0.02 * i:.4f},"
                        f"{3e-4 * (i + 1):.4g}\n" for i in range(count))
        table.write_text(f"x_m,z_m\n0,0\n{steps}60,{3e-4 * count:.4g}\n", encoding="utf-8")
        ran = program.done(1, "check", decks / "plain.toml", "irregularity.kind=file",
                           f"irregularity.file={table.resolve()}", "irregularity.fade=0")
        if f"jumps by 0.3 mm at {words}" not in ran.stdout:
            raise SystemExit(f"{count} jumps 20 mm apart: '{words}' is wanted:\n{ran.stdout}")


def check_long_profile(program, decks, folder):
    """Two kilometres in rows of 1 mm add at most four times the processor time that Python takes
    to read them on the same machine (measured beside other work: 2.3 times)."""
    table = folder / "long.csv"
    rows = (f"{i / 1000:.3f},{1e-3 * math.sin(i / 500):.9f}\n" for i in range(2000001))
    table.write_text("x_m,z_m\n" + "".join(rows), encoding="utf-8")
    spent = []
    for words in (["irregularity.kind=none", "irregularity.fade=10"],
                  ["irregularity.kind=file", f"irregularity.file={table.resolve()}"]):
        begin = os.times().children_user + os.times().children_system
        program.done(1, "check", decks / "plain.toml", "track.length=1999.8", *words)
        spent.append(os.times().children_user + os.times().children_system - begin)
    begin = time.process_time()
    with open(table, encoding="utf-8") as lines:
        next(lines)
        total = sum(float(x) + float(z) for x, z in (line.split(",") for line in lines))
    reading = time.process_time() - begin
    if not math.isfinite(total) or spent[1] - spent[0] > 4 * reading:
        raise SystemExit(f"check took {spent} s of processor time without and with a profile that "
                         f"Python reads in {reading} s")
    print(f"a profile of two million rows: {spent[1] - spent[0]:.2f} s of processor time")


def check_loads(program, decks, folder):
    """A table of seat loads is 0 before its first row and after its last: jumps are reported."""
    table = folder / "loads.csv"
    words = [*SEATS, "irregularity.fade=0", "train.start=0", "load.kind=table", "load.speed=60",
             f"load.file={table.resolve()}", "passage.duration=2"]
    for rows, changes, wanted in (
            ("0,0\n0.2,5e4\n0.5,5e4\n", [], "drops from 50000 N (last row) to 0"),
            ("0,0\n0.2,5e4\n0.5,5e4\n", ["passage.duration=0.4"], ""),
            ("0.5,5e4\n0.6,0\n", [], "jumps from 0 to 50000 N (first row)"),
            ("0,0\n0.2,5e4\n0.3,500\n", [], ""), ("0,0\n0.2,5e4\n0.5,0\n", [], "")):
        table.write_text("time_s,force_N\n" + rows, encoding="utf-8")
        ran = program.done(1, "check", decks / "plain.toml", *words, *changes)
        reported = [line for line in ran.stdout.splitlines()
                    if line.startswith("warning: load.file")]
        if len(reported) != (wanted != "") or not all(wanted in line for line in reported):
            raise SystemExit(f"{rows} {changes}: '{wanted}' is wanted, not {reported}")


def check_ends(program, decks, folder):
    """Impossible states of a track are reported at the end of a run, but not if they are brief."""
    off, force = "wheels were off the rail in", "the largest wheel force is"
    down = "the rail at 30 m"
    short = ["irregularity.fade=10", "train.start=25", "passage.duration=0.4"]
    deck = deck_with(decks, folder, VEHICLE.format(
        'kind = "sprung"\nlength = 2\nwheelset_mass = 1200\nbody_mass = 10e3\n'
        'primary_stiffness = 2e6\nprimary_damping = 2e4'))
    for changes, wanted in (
            ([*short, "irregularity.kind=waves", "irregularity.waves=100",
              "irregularity.length=0.5", "irregularity.at=26", "irregularity.depth=2e-3"], [off]),
            ([*short, "irregularity.kind=versine", "irregularity.depth=-0.08",
              "irregularity.length=0.2"], [off, force]),
            (["track.support=none", "passage.duration=0.8"], [off, down]),
            # One wheel on a nearly rigid track: no contact in 29 % of its steps, by its flat alone.
            ([*short, "irregularity.kind=none", 'train.vehicles=["own"]', "train.speed=30",
              "wheel_rail.flat_axle=1", "wheel_rail.flat_length=0.06", "track.support=continuous",
              "track.bed_stiffness=1e10", "track.bed_damping=0", "rail.inertia=1", "rail.mass=1e4",
              "rail.theory=euler"], []),
            ([*short, "irregularity.kind=joint", "irregularity.depth=1e-2", "train.speed=80"], [])):
        place = folder / "ends"
        ran = program.done(1, "run", deck, *changes, "--force", "-o", place)
        reported = [line[len("warning: "):] for line in ran.stdout.splitlines()
                    if line.startswith("warning: ")]
        kept = [one for one in summary(place)["warnings"]
                if any(words in one for words in (off, force, down))]
        print(changes[-3:], kept)
        if len(kept) != len(wanted) or not all(
                words in one and one in reported for words, one in zip(wanted, kept)):
            raise SystemExit(f"{changes}: {wanted} is wanted, not {kept}; on the screen {reported}")


def check_kept(program, decks, folder):
    """Warnings of check are in the summary of the run, also of one that was stopped."""
    place = folder / "kept"
    words = ["ballast.below_stiffness=70e6", "irregularity.depth=2e-3"]
    ran = program.done(1, "check", decks / "plain.toml", *words)
    reported = [line[len("warning: "):] for line in ran.stdout.splitlines()
                if line.startswith("warning: ")]
    program.done(1, "run", decks / "plain.toml", *words, "passage.duration=0.01",
                 "output.stop_after=20", "-o", place, code=3)
    if len(reported) != 2 or summary(place)["warnings"] != reported:
        raise SystemExit(f"check warns of {reported}, the run has {summary(place)['warnings']}")
    program.done(1, "resume", place)
    kept = [text.partition(": ballast")[2] for text in summary(place)["warnings"]]
    if len(kept) != 2 or ".below_stiffness = " not in "".join(kept):
        raise SystemExit(f"a resumed run has {summary(place)['warnings']}, not {reported}")


def main():
    program, decks, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2]), pathlib.Path(
        sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_sentences(program, decks, folder)
    check_windows(program, decks)
    check_idle(program, decks, folder)
    check_files(program, decks, folder)
    check_steps(program, decks, folder)
    check_profiles(program, decks, folder)
    check_strikes(program, decks, folder)
    check_places(program, decks, folder)
    check_long_profile(program, decks, folder)
    check_loads(program, decks, folder)
    check_ends(program, decks, folder)
    check_kept(program, decks, folder)


if __name__ == "__main__":
    main()
