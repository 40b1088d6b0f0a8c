#!/usr/bin/env python3
"""A track on a ground of elements, with one rail or two: refusals, effect of every parameter of the
footing, bitwise identity on any number of ranks and after a stop, balances.

    track_on_ground.py PROGRAM DECK NETIRAIL_DECK FOLDER
"""
import json
import pathlib
import shutil
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
sys.path.insert(0, str(HERE.parent / "knobs"))
from ground_knobs import KNOBS  # noqa: E402
from part import part, some  # noqa: E402
from program import Program, summary  # noqa: E402
from results import datasets, same_bits  # noqa: E402

REFUSED = {
    "footing.first=0.2":
        "footing.first = 0.2: the first footprint begins at x = -0.05 m, beyond the ground",
    "footing.count=8": "the last footprint ends at x = 5.35 m, beyond the ground",
    "footing.length=2.2": "puts footprints from y = -0.2 to 2 m, beyond the ground",
    "footing.before=3": "at 1.8 m from the start of the track, within the run-in of 2.4 m",
    "track.length=9": "the last sleeper on the ground is at 7.2 m from",
    "ground.present=false": "must be true for model = \"track_on_ground\"; without a ground",
    "ground.integrator=hht": 'must be "explicit" or "newmark" with model = "track_on_ground"',
    "ground.integrator=newmark ground.newmark_gamma=0.6 ground.newmark_beta=0.3025":
        "ground.newmark_beta = 0.3025: must be 0.25, and ground.newmark_gamma 0.5, with model = ",
    "ground.integrator=newmark ground.newmark_beta=0.3":
        'model = "track_on_ground": the track is integrated with average acceleration',
    "ground.layer.soil.yield=mohr_coulomb": "must not yield below a track without stones",
    "track.support=continuous": 'must be "sleepers": the ground carries the ballast',
    "track.dimension=space":
        'footing.rails = 1.0 (default): must be 2 if track.dimension = "space"',
    "track.dimension=space footing.rails=1.5":
        'footing.rails = 1.5: must be 2 if track.dimension = "space"',
    "track.dimension=space footing.rails=2":
        "footing.length = 1.4: must be at least the length of a sleeper (track.sleeper_length = "
        "2.6 m)",
    "track.dimension=space footing.rails=2 dimension=plane footing.length=1.3 footing.y=0":
        'must be "plane" on a plane ground: two rails need a three-dimensional ground (dimension)',
    "train.start=1": "the train comes from the rigid rail before the track",
    "pad.uplift=true": "pad.uplift = true: must be false on a ground",
    "dimension=plane": "footing.length and footing.y have no effect in a plane model",
    "bed.height=0.3": "bed is not a section",
    "seat.before=5": "seat is not a section",
    "model=track": "ground is not a section",
    "sensor=[{name='out',kind='ground',at=[0,0,0.5]}]": "sensor[0].at",
    "sensor=[{name='stone',at=[1,1,0.5]}]": 'must be "ground": the model has no stones',
}
# What `check` says of decks that it takes.
WARNED = {"footing.width=0.7":
          "is more than the spacing of sleepers (0.6 m): footprints of neighbouring sleepers "
          "overlap",
          "ballast.damping=4e6":
          "limited by ballast dampers on the ground's top (the ground alone is limited by "
          "elements of layer",
          "ground.integrator=newmark":
          "step: 0.0002 s (passage.step), implicit ground: two solves of the ground in each step, "
          "and 6 solves before"}
# The ground divides the step: what is reported is of the step taken.
STEPS = [
    (["passage.step=1e-2"], [], ["in a step", "history_interval"]),
    (["passage.step=1e-2", "output.history_interval=1e-4"],
     ["output.history_interval = 0.0001: is less than a time step of 0.0003448 s"], []),
    (["passage.step=1e-2", "irregularity.kind=joint", "irregularity.at=6",
      "irregularity.length=0.2"],
     ["irregularity.length = 0.2: is only 7.2 times the travel of wheels in a step (0.0276 m"], []),
    (["passage.step=1e-4", "irregularity.kind=joint", "irregularity.at=6",
      "irregularity.length=0.2"], [], ["irregularity.length"]),
    (["passage.step=1e-2", "force=[{at=6,kind='impact',length=2e-3,size=1e3}]"],
     ["force[0].length = 0.002: gives an impact of 0.002 s: steps of 0.0003448 s resolve it"],
     []),
    (["passage.step=1e-2", "force=[{at=6,kind='impact',length=3e-3,size=1e3}]"], [], ["force[0]"]),
]
# Relative. Weights and sums of a few hundred nodes in double precision; terms of work are rounded
# to 1e-20 J.
BALANCE = 1e-9
# Relative. Wheel contacts are solved to 1e-12 m, which is 1 mN, of 20 kN on the ground.
ALIKE = 1e-7
# Relative. An implicit ground is solved to a residual of 1e-8 of its forces in each of 90 steps.
SOLVED = 1e-6


# Below the third sleeper, at the top and in depth.
SENSORS = ("sensor=[{name='top',kind='ground',at=[1.2,0.9,0]},"
           "{name='deep',kind='ground',at=[1.2,0.9,-0.6]}]")
FIELDS = ["output.fields=true", "output.fields_interval=0.03"]


def facts(of):
    return of["track"], of["ground"]["state_hash"], of["ground"]["steps"], of["energy"]


def check_balance(place, what, most=BALANCE):
    for name, value in summary(place)["coupling"].items():
        if not 0 <= value <= most:
            raise SystemExit(f"{what}: imbalance of {name} is {value}")


def check_refusals(program, deck):
    for change, words in part(REFUSED.items()):
        ran = program(1, "check", deck, *change.split())
        if ran.returncode != 2 or words not in ran.stderr:
            raise SystemExit(f"{change} must be refused with {words}:\n{ran.stdout}{ran.stderr}")
    if WARNED["footing.width=0.7"] in program.done(1, "check", deck).stdout:
        raise SystemExit("separate footprints must not give a warning")
    for change, words in part(WARNED.items()):
        ran = program.done(1, "check", deck, change)
        if words not in ran.stdout:
            raise SystemExit(f"{change}: {words} is required:\n{ran.stdout}{ran.stderr}")
    for changes, wanted, silent in part(STEPS):
        reported = [line for line in program.done(1, "check", deck, *changes).stdout.splitlines()
                    if line.startswith("warning: ")]
        if any(words not in "".join(reported) for words in wanted) or any(
                words in "".join(reported) for words in silent):
            raise SystemExit(f"{changes}: {wanted} is required, {silent} is not: {reported}")


def check_ranks(program, deck, folder):
    for ranks in some((1, 3), (1, 2, 3, 4)):
        place = folder / f"ranks_{ranks}"
        program.done(ranks, "run", deck, SENSORS, "-o", place)
        check_balance(place, f"{ranks} ranks")
        same_bits(folder / "ranks_1", place, f"{ranks} ranks", facts)
    found = datasets(folder / "ranks_1")
    down, force = -found["history/ground/displacement"], found["history/ground/force"]
    if down.max() < 1e-4 or force.max() < 1e4:
        raise SystemExit(f"displacement of the ground {down.max()} m under {force.max()} N")
    energy = summary(folder / "ranks_1")["energy"]
    held = energy["ground_kinetic_j"] + energy["ground_elastic_j"]
    if not 0 < held < energy["given_to_ground_j"]:
        raise SystemExit("the energy of a damped ground must be less than the supplied work: "
                         f"{energy}")


def check_histories(folder):
    """Energies end with those of the summary and follow the work; sensors see the ground move
    below a sleeper, less in depth."""
    found = datasets(folder / "ranks_1")
    stated = summary(folder / "ranks_1")["energy"]
    for name in ("track", "given_to_ground", "ground_kinetic", "ground_elastic"):
        if found[f"history/energy/{name}"][-1] != stated[f"{name}_j"]:
            raise SystemExit(f"energy {name} ends with {found[f'history/energy/{name}'][-1]}, "
                             f"the summary has {stated[f'{name}_j']}")
    held = found["history/energy/ground_kinetic"] + found["history/energy/ground_elastic"]
    if np.any(held > found["history/energy/given_to_ground"] * (1 + BALANCE) + BALANCE):
        raise SystemExit("the ground has more energy than the track has given to it")
    top, deep = (-found[f"history/sensor/{name}/displacement"][:, 2].min()
                 for name in ("top", "deep"))
    below = -found["history/ground/displacement"].min()
    if not 0.1 * below < deep < top < 1.5 * below:
        raise SystemExit(f"sensors: {top} m at the top, {deep} m in depth, {below} m on average "
                         "below a sleeper")
    if found["history/sensor/top/stress"][:, 2].min() > -1e3:
        raise SystemExit("the stress below a sleeper must be compression")


def check_fields(program, deck, folder):
    """Rails, sleepers, wheels and ground at each instant; the shapes contain the displacements.
    On two ranks the root writes the track."""
    for ranks, words in some([(2, TWO_RAILS)], [(1, []), (2, TWO_RAILS)]):
        place = folder / f"fields_{ranks}"
        program.done(ranks, "run", deck, *FIELDS, *words, "-o", place)
        for kind in ("ground", "surfaces", "train"):
            series = json.loads((place / f"fields/{kind}.hdf.series").read_text("utf-8"))
            times = [entry["time"] for entry in series["files"]]
            if not np.allclose(times, [0.03, 0.06, 0.09]):
                raise SystemExit(f"{kind}: fields at {times} s")
        train, sleepers = (datasets(place / f"fields/passage_000150_{kind}.hdf")
                           for kind in ("train", "surfaces"))
        force = train["VTKHDF/CellData/wheel_force"][train["VTKHDF/CellData/wheel"] >= 0]
        found = datasets(place)
        row = np.flatnonzero(np.isclose(found["history/time"], 0.03))
        # Fields are 32-bit floats.
        if not np.array_equal(found["history/wheel/force"][row].ravel().astype(np.float32), force):
            raise SystemExit(f"the wheels' forces are {force} N in their field")
        lowest = sleepers["VTKHDF/PointData/displacement"][:, 2].min()
        z = sleepers["VTKHDF/Points"][:, 2]
        if not (lowest < -1e-5 and np.isclose(z.min(), lowest, rtol=1e-6)):
            raise SystemExit(f"the lowest sleeper is {z.min()} m, displaced by {lowest} m")
        if len(z) != 8 * 21 or len(sleepers["VTKHDF/CellData/surface"]) != 6 * 21:
            raise SystemExit("a sleeper has 8 corners and 6 faces")


def check_resume(program, deck, folder):
    steps = summary(folder / "ranks_1")["windows"]
    middle = (steps // 2 + 3, 3, 1)
    for stop, before, after in some([middle], [(1, 2, 3), middle, (steps - 1, 1, 2)]):
        place = folder / f"stopped_{stop}"
        program.done(before, "run", deck, SENSORS, f"output.stop_after={stop}", "-o", place, code=3)
        program.done(after, "resume", place)
        same_bits(folder / "ranks_1", place, f"stopped after {stop} steps", facts)
    ran = program(1, "resume", place, "ground.layer.soil.young=70e6", "-o", folder / "other")
    if ran.returncode != 2 or "young" not in ran.stderr:
        raise SystemExit(f"another ground must be refused: {ran.stdout}{ran.stderr}")


def check_implicit(program, deck, folder):
    """With steps of three times the explicit one: results agree on any number of ranks to the
    solver's tolerance and are bitwise identical after a stop on the same number, for one rail and
    two, with unsupported sleepers and bilinear pads."""
    path = folder / "implicit.toml"
    path.write_text(deck.read_text(encoding="utf-8") + ONE_END.replace("5e-3", "1e-4"),
                    encoding="utf-8")
    step = ["ground.integrator=newmark", "passage.step=1e-3", "pad.bilinear_at=1e-4",
            "pad.bilinear_stiffness=400e6"]
    for name, words in (("one", ["pad.damping=50e3"]), ("both", TWO_RAILS)):
        here = path if name == "both" else deck
        for ranks in some((1, 2), (1, 2, 4)):
            place = folder / f"implicit_{name}_{ranks}"
            program.done(ranks, "run", here, *step, *words, "-o", place)
            check_balance(place, f"implicit, {ranks} ranks", SOLVED)
            found, other = (datasets(folder / f"implicit_{name}_{n}")
                            for n in (ranks, 1))
            for quantity, values in other.items():
                off = np.abs(found[quantity] - values).max()
                if not off <= SOLVED * np.abs(values).max():
                    raise SystemExit(f"implicit, {name}: {quantity} on {ranks} ranks is off by "
                                     f"{off}")
        stopped = folder / f"implicit_{name}_stopped"
        program.done(2, "run", here, *step, *words, "output.stop_after=37", "-o", stopped, code=3)
        program.done(2, "resume", stopped)
        same_bits(folder / f"implicit_{name}_2", stopped, "implicit, stopped after 37 steps", facts)
    if summary(stopped)["ground"]["steps"] != 90:
        raise SystemExit(f"{summary(stopped)['ground']['steps']} steps of 1 ms in 0.09 s")


def check_unused_options(program, deck, folder):
    """No solver of PETSc is used here: unused options are reported as for a bed."""
    run = ["run", deck, "passage.duration=0.01", "-o", folder / "options"]
    for command in (run, ["check", deck]):
        ran = program.done(1, *command, "--", "-ground_ksp_type", "cg")
        if "warning: the PETSc option -ground_ksp_type was set but never used" not in ran.stdout:
            raise SystemExit(f"{command[0]} must name an option without use:\n{ran.stdout}")
    # With implicit steps `check` solves, and names only what nothing reads.
    ran = program.done(1, "check", deck, "ground.integrator=newmark", "--", "-ground_ksp_max_it",
                       "500", "-ground_mistyped", "1")
    if "-ground_ksp_max_it" in ran.stdout or "-ground_mistyped was set but never" not in ran.stdout:
        raise SystemExit(f"check of an implicit ground names the wrong options:\n{ran.stdout}")
    # An invalid option is found before --force removes results.
    implicit = "ground.integrator=newmark"
    program.done(1, "run", deck, implicit, "output.stop_after=2", "-o", folder / "begun", code=3)
    for command in ([*run, implicit], ["resume", folder / "begun", "-o", folder / "options"]):
        program.done(1, *command, "--force", "--", "-ground_ksp_type", "nosuch", code=2)
        if not (folder / "options/results.h5").exists():
            raise SystemExit(f"{command[0]} with an invalid option must remove nothing")


def check_knobs(program, deck, folder):
    def seen(words):
        place = folder / "knob"
        program.done(1, "run", deck, *words, "--force", "-o", place)
        return summary(place)["track"]["state_hash"]

    for name, (change, around) in part(KNOBS.items()):
        if seen([*around, change]) == seen(around):
            raise SystemExit(f"{name}: {change} has no effect")


def check_hanging(program, deck, folder):
    """Without ballast force below an unsupported sleeper, its neighbours transfer more."""
    text = deck.read_text(encoding="utf-8")
    path = folder / "hanging.toml"
    path.write_text(text + "\n[[track.zone]]\nfrom = 5.9\nto = 6.1\ngap = 5e-3\n",
                    encoding="utf-8")
    ran = program(1, "check", path, "track.sleeper.model=beam")
    if ran.returncode != 2 or 'must be "rigid" on a ground with hanging sleepers' not in ran.stderr:
        raise SystemExit(f"flexible unsupported sleepers on a ground: {ran.stdout}{ran.stderr}")
    program.done(2, "run", path, "-o", folder / "hanging")
    even, hangs = (datasets(folder / name)["history/ground/force"].max(axis=0)
                   for name in ("ranks_1", "hanging"))
    if hangs[0] != 0 or hangs[1] < 1.1 * even[1]:
        raise SystemExit(f"largest forces on the ground {even} N, with the first sleeper "
                         f"unsupported {hangs} N")


def check_bending_sleepers(program, deck, folder):
    """The sum of ballast forces of a sleeper equals the force on the ground; bitwise identical on
    any number of ranks and after a stop."""
    words = ["track.sleeper.model=beam", "track.sleeper.unsupported=0.4"]
    for ranks in some((1, 2), (1, 2, 4)):
        place = folder / f"bending_{ranks}"
        program.done(ranks, "run", deck, *words, "-o", place)
        same_bits(folder / "bending_1", place, f"bending sleepers on {ranks} ranks", facts)
        check_balance(place, "bending sleepers")
    place = folder / "bending_stopped"
    program.done(1, "run", deck, *words, "output.stop_after=333", "-o", place, code=3)
    program.done(3, "resume", place)
    same_bits(folder / "bending_1", place, "bending sleepers, stopped", facts)
    rigid, bending = (datasets(folder / name) for name in ("ranks_1", "bending_1"))
    forces = [found["history/ground/force"].max() for found in (rigid, bending)]
    if "history/sleeper/moment" not in bending or not 0.8 < forces[1] / forces[0] < 1.2:
        raise SystemExit(f"largest forces on the ground, rigid and bending: {forces} N")


def check_seat_loads(program, deck, folder):
    """Without rail and train the ground carries the loads of the seats, and recovers."""
    words = ["passage.loaded_by=seats", "train.vehicles=[]", "load.speed=80", "load.axles=[0]"]
    for ranks in (1, 3):
        place = folder / f"seats_{ranks}"
        program.done(ranks, "run", deck, *words, "-o", place)
        same_bits(folder / "seats_1", place, f"seat loads on {ranks} ranks", facts)
        check_balance(place, "seat loads")
    place = folder / "seats_stopped"
    program.done(2, "run", deck, *words, "output.stop_after=222", "-o", place, code=3)
    program.done(1, "resume", place)
    same_bits(folder / "seats_1", place, "seat loads, stopped", facts)
    found = datasets(place)
    largest = [found[f"history/{name}"].max() for name in ("sleeper/seat_force", "ground/force")]
    if not np.allclose(largest, 71.1e3, rtol=0.3):
        raise SystemExit(f"seats are loaded with {largest[0]} N, the ground gets {largest[1]} N")


# Whole sleepers off the middle of a wider ground, unsupported ends, an eccentric load to the left.
TWO_RAILS = ["track.dimension=space", "footing.rails=2", "footing.length=2.8", "footing.y=1.7",
             "ground.y=[0,3.6]"]
ONE_END = """
[[track.zone]]
from = 5.9
to = 6.1
gap = 5e-3
side = "left"
"""


def check_two_rails(program, deck, folder):
    """Rows of both ends, left before right; bitwise identical on any number of ranks and after a
    stop; no force below unsupported ends, larger forces below a larger load, equal results of equal
    rails; also for flexible sleepers."""
    path = folder / "two_rails.toml"
    path.write_text(deck.read_text(encoding="utf-8") + ONE_END, encoding="utf-8")
    words = [*TWO_RAILS, "vehicle.own.body_offset=0.2"]
    for ranks in some((1, 3), (1, 2, 3, 4)):
        place = folder / f"two_rails_{ranks}"
        program.done(ranks, "run", path, *words, "-o", place)
        same_bits(folder / "two_rails_1", place, f"two rails on {ranks} ranks", facts)
        check_balance(place, "two rails")
        if "roll_moment" not in summary(place)["coupling"]:
            raise SystemExit("no balance of moments about the track")
    for stop, before, after in some([(217, 3, 2)], [(1, 2, 1), (217, 3, 2)]):
        place = folder / f"two_rails_stopped_{stop}"
        program.done(before, "run", path, *words, f"output.stop_after={stop}", "-o", place, code=3)
        program.done(after, "resume", place)
        same_bits(folder / "two_rails_1", place, f"two rails, stopped after {stop} steps", facts)
        check_balance(place, "two rails, stopped")
    found = datasets(folder / "two_rails_1")
    most = found["history/ground/force"].max(axis=0)
    if len(most) != 4 or found["history/ground/displacement"].shape[1] != 4:
        raise SystemExit(f"two sleepers have {len(most)} ends")
    if most[0] != 0 or most[1] < 1e4 or most[2] < 1.05 * most[3]:
        raise SystemExit(f"largest forces on the ground below an unsupported left end, its right "
                         f"one, and both of the next sleeper under a load to the left: {most} N")
    words += ["track.sleeper.model=beam", "track.sleeper.unsupported=0.4"]
    for ranks in (1, 3):
        place = folder / f"two_rails_bending_{ranks}"
        program.done(ranks, "run", deck, *words, "-o", place)
        same_bits(folder / "two_rails_bending_1", place, f"bending, {ranks} ranks", facts)
        check_balance(place, "two rails, sleepers that bend")
    place = folder / "two_rails_bending_stopped"
    program.done(2, "run", deck, *words, "output.stop_after=217", "-o", place, code=3)
    program.done(1, "resume", place)
    same_bits(folder / "two_rails_bending_1", place, "two rails, bending, stopped", facts)
    program.done(2, "run", deck, *TWO_RAILS, "footing.y=1.8", "-o", folder / "alike")
    program.done(2, "run", deck, *TWO_RAILS, "footing.y=1.8", "track.dimension=plane", "-o",
                 folder / "as_one")
    for name in ("displacement", "force"):
        ends, one = (datasets(folder / place)[f"history/ground/{name}"]
                     for place in ("alike", "as_one"))
        off = np.abs(ends - np.repeat(one, 2, axis=1)).max() / np.abs(one).max()
        if not off < ALIKE:
            raise SystemExit(f"ground/{name} of two equal rails differs by {off} from that of one")


PLAIN = [f"ground.block.{name}.present=false" for name in ("ugm", "cbm", "abutment")]


def check_netirail(program, deck, folder):
    """The first bogie on plain track, 20.4 m behind the begin of the ground; within a quarter of
    the values of the report: rail 0.8, rail to sleeper 0.2, ground 0.6 mm."""
    words = [*PLAIN, 'train.vehicles=["alfa_pendular"]']
    place = folder / "netirail"
    program.done(2, "run", deck, *words, "passage.duration=0.62", "-o", place)
    found = datasets(place)
    rail, sleeper, ground = (found[f"history/{name}/displacement"][:, 0]
                             for name in ("rail", "sleeper", "ground"))
    check_balance(place, "the deck")
    measured = [-rail.min(), (sleeper - rail).max(), -ground.min()]
    if not np.allclose(measured, [0.8e-3, 0.2e-3, 0.6e-3], rtol=0.25):
        raise SystemExit(f"rail, rail to sleeper, ground: {measured} m")
    words.append("passage.duration=0.02")
    program.done(2, "run", deck, *words, "-o", folder / "begin")
    check_balance(folder / "begin", "the deck's begin", 1e-6)  # relative to a very small work
    place = folder / "begin_stopped"
    program.done(1, "run", deck, *words, "output.stop_after=151", "-o", place, code=3)
    program.done(2, "resume", place)
    same_bits(folder / "begin", place, "the deck, stopped", facts)


def main():
    program, deck, netirail, folder = Program(sys.argv[1]), *map(pathlib.Path, sys.argv[2:5])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_refusals(program, deck)
    check_ranks(program, deck, folder)
    check_histories(folder)
    check_fields(program, deck, folder)
    check_resume(program, deck, folder)
    check_implicit(program, deck, folder)
    check_unused_options(program, deck, folder)
    check_knobs(program, deck, folder)
    check_hanging(program, deck, folder)
    check_bending_sleepers(program, deck, folder)
    check_seat_loads(program, deck, folder)
    check_two_rails(program, deck, folder)
    check_netirail(program, netirail, folder)


if __name__ == "__main__":
    main()
