#!/usr/bin/env python3
"""A track alone: refusals, bitwise identity on any number of ranks, files, resume.

    track.py PROGRAM DECKS FOLDER
"""
import pathlib
import shutil
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import some  # noqa: E402
from program import Program, summary  # noqa: E402
from results import datasets, same_datasets  # noqa: E402

SEATS = "train.vehicles=[] passage.loaded_by=seats load.axles=[0,2.8,9.0,11.8]"
SHORT = ["passage.duration=0.05", "train.start=25"]
# Changes of the plain deck and a part of the refusal.
REFUSED = {
    "model=bed": 'need a stage with train = ',
    "bed.height=0.3": "bed is not a section",
    "rail.section=60E2": "must be \"46E3\", \"54E1\", \"60E1\", \"UIC54\", \"UIC60\" or \"CHN60\"",
    'train.vehicles=["manchester"]': "did you mean manchester_1?",
    "train.vehicles=[]": "must name at least one vehicle",
    "train.start=61": "train.start = 61: is beyond the track, which is 60 m long",
    "train.times=[9,8] train.speeds=[40,30]": "train.times = [9, 8]: must increase from each",
    "train.times=[9,20] train.speeds=[40]": "as many as train.times: 1 speeds, 2 times",
    "train.times=[9] train.speeds=[-5]": "train.speeds[0] = -5 must be at least 0 m/s",
    "train.times=[5] train.speeds=[0] train.speed=10": "stops with its first axle at 25 m and",
    "track.length=60.1": "must be a multiple of track.spacing",
    "track.run_in=31": "must be at most 30 m, half of track.length",
    "irregularity.kind=file": "is needed for kind",
    "irregularity.longest=0.5": "must be longer than `shortest`",
    "wheel_rail.flat_axle=5": "must be at most the number of axles of the train, 4",
    "wheel_rail.flat_length=0.5 wheel_rail.flat_axle=1": "must be at most the radius",
    "passage.points=[70]": "70 m is beyond the track",
    "output.stop_after=-1": "at least 0",
    "track.dimension=space track.rails=1": 'must be 2 with dimension = "space"',
    "track.sleeper.model=beam track.sleeper.elements=7": "must be even, so that there",
    "track.sleeper.model=beam track.support=continuous": 'must be "rigid": the track has no',
    "track.sleeper.model=beam track.sleeper_length=1.5": "track.gauge = 1.5 m: the seats are on",
    "track.sleeper.model=beam track.rails=1": "must be 2 with bending sleepers",
    "track.sleeper.model=beam track.sleeper_inertia=100": "must be 0 with bending sleepers",
    "track.sleeper.model=beam ballast.mass=500": 'must be 0 with track.sleeper.model = "beam"',
    "track.sleeper.unsupported=0.5": "has no effect on a plane track with rigid sleepers",
    "track.dimension=space track.sleeper.unsupported=2.6": "must be shorter than the sleeper",
    "passage.loaded_by=seats": "must be [] with passage.loaded_by",
    "pad.uplift=true track.support=continuous": "pad.uplift = true: needs pads: there are none",
    "under_sleeper_pad.stiffness=8e7 track.support=none": "needs sleepers: there are none",
    "under_sleeper_pad.stiffness=8e7 track.sleeper.model=beam":
        'must be 0 with track.sleeper.model = "beam"',
    "under_sleeper_pad.from=9 under_sleeper_pad.to=9": "must be above `from`, or 0",
    f"{SEATS} pad.uplift=true": "pad.uplift = true: needs a rail, but seat loads act in place of",
    f"{SEATS} track.ends=free": 'must be "pinned" if seat loads are applied',
    f"{SEATS} track.support=continuous": 'must be "sleepers" if seat loads are applied',
    f"{SEATS} load.kind=table": "load.file",
    "load.peak=50e3": "has no effect: it acts only with passage.loaded_by",
    "irregularity.kind=same": '"same" is only for the right rail',
    "irregularity_right.kind=versine": "needs two rails",
}
TOGETHER = ["passage.step=0", "pad.stiffness=-1", "train.speed=0"]  # all reported at once
VEHICLE = """
[[vehicle]]
name = "{name}"
kind = "{kind}"
length = 20
wheelset_mass = 1000

[[track.zone]]
from = 30
to = {to}
"""


def refuse(program, deck, changes, words):
    ran = program(1, "check", deck, *changes)
    if ran.returncode != 2 or words not in ran.stderr:
        raise SystemExit(f"{changes} must be refused with {words}:\n{ran.stdout}{ran.stderr}")
    return ran.stderr.splitlines()


def check_refusals(program, decks, folder):
    for change, words in REFUSED.items():
        refuse(program, decks / "plain.toml", change.split(" "), words)
    refuse(program, decks / "plain.toml", ["track.support=none", "track.ends=free"],
           'track.ends = "free": must be "pinned": the rail has no other support')
    lines = refuse(program, decks / "plain.toml", TOGETHER, "must be above 0")
    if len(lines) != len(TOGETHER):
        raise SystemExit(f"one message for each of {TOGETHER} is required: {lines}")
    text = (decks / "plain.toml").read_text(encoding="utf-8")
    for name, kind, to, words in (("own", "sprung", 31, "also needs body_mass, primary_stiffness"),
                                  ("manchester_1", "wheel", 31, "is already the name of another"),
                                  ("own", "wheel", 30, "must be above `from`")):
        path = folder / "changed.toml"
        path.write_text(text + VEHICLE.format(name=name, kind=kind, to=to), encoding="utf-8")
        refuse(program, path, [], words)
    for changes, words in ((["output.history_interval=1e-6"], "a row is then written after"),
                           (["train.times=[1]", "train.speeds=[20]"],
                            "of up to 30 m/s2 in magnitude")):
        ran = program.done(1, "check", decks / "plain.toml", *changes)
        if words not in ran.stdout:
            raise SystemExit(f"{changes} must warn:\n{ran.stdout}")


def check_files(program, decks, folder):
    """An invalid profile is refused with its line, and older results are kept."""
    place, bad = folder / "kept", folder / "bad.csv"
    program.done(1, "run", decks / "plain.toml", *SHORT, "-o", place)
    bad.write_text("x_m,z_m\n0,0\n1,high\n", encoding="utf-8")
    ran = program(1, "run", decks / "plain.toml", *SHORT, "irregularity.kind=file",
                  f"irregularity.file={bad.resolve()}", "--force", "-o", place)
    if ran.returncode != 2 or "bad.csv:3" not in ran.stderr:
        raise SystemExit("an invalid profile must be refused with its line:\n"
                         f"{ran.stdout}{ran.stderr}")
    if not (place / "summary.json").exists():
        raise SystemExit("a refused run has removed results")


def check_runs(program, decks, folder):
    hashes = set()
    for ranks in some((1, 3), (1, 2, 3)):
        program.done(ranks, "run", decks / "plain.toml", *SHORT, "--force", "-o", folder / "run")
        hashes.add(summary(folder / "run")["track"]["state_hash"])
    if len(hashes) != 1:
        raise SystemExit(f"the state depends on the number of ranks: {hashes}")
    found = datasets(folder / "run")
    force, time = found["history/wheel/force"], found["history/time"]
    seats = found["history/sleeper/seat_force"]
    if force.shape != (51, 4) or abs(time[-1] - 0.05) > 1e-12 or seats.shape != (51, 2):
        raise SystemExit(f"histories have other shapes: {force.shape}, {seats.shape}")
    # 109.09 kN on an axle.
    if not np.allclose(force[0], 54545, atol=10):
        raise SystemExit(f"forces at rest: {force[0]}")
    ran = program(1, "resume", folder / "run")
    if ran.returncode != 2 or "(alone or on a ground) without a checkpoint" not in ran.stderr:
        raise SystemExit(f"no checkpoint to resume: {ran.stderr}")
    ran = program(1, "run", decks / "plain.toml", *SHORT, "-o", folder / "run")
    if ran.returncode != 2 or "--force" not in ran.stderr:
        raise SystemExit(f"older results must not be replaced: {ran.stderr}")


HANGING = """
[[track.zone]]
from = 26.9
to = 28.3
gap = 3e-4

[[force]]
kind = "impact"
at = 27
begin = 0.02
length = 5e-3
size = 20e3
"""


def same_bits(one, other, what):
    same_datasets(datasets(one), datasets(other), what)
    tracks = [summary(place)["track"] for place in (one, other)]
    if tracks[0] != tracks[1] or not summary(other)["finished"]:
        raise SystemExit(f"{what}: {tracks}")


def check_resume(program, decks, folder):
    """Stopped on two ranks after any step and resumed on one: bitwise identical. Sleepers are
    unsupported, pads are bilinear, with an impact on the rail."""
    deck = folder / "hanging.toml"
    deck.write_text((decks / "plain.toml").read_text(encoding="utf-8") + HANGING, encoding="utf-8")
    words = [*SHORT, "pad.bilinear_at=1e-4", "pad.bilinear_stiffness=300e6"]
    program.done(1, "run", deck, *words, "-o", folder / "through")
    for steps in some((203,), (1, 100, 203, 249)):
        place = folder / f"stopped_{steps}"
        program.done(2, "run", deck, *words, f"output.stop_after={steps}", "-o", place, code=3)
        if summary(place)["finished"] or summary(place)["windows"] != steps:
            raise SystemExit(f"stopped after {steps} steps: {summary(place)}")
        program.done(1, "resume", place)
        same_bits(folder / "through", place, f"stopped after {steps} steps")
    lifts, even = [*SHORT, "pad.uplift=true"], decks / "plain.toml"
    refuse(program, deck, lifts, "pad.uplift = true: must be false with hanging sleepers")
    program.done(2, "run", even, *lifts, "-o", folder / "lifts")
    program.done(1, "run", even, *lifts, "output.stop_after=203", "-o", folder / "lifted", code=3)
    program.done(2, "resume", folder / "lifted")
    same_bits(folder / "lifts", folder / "lifted", "pads that lift off, stopped after 203 steps")
    written = folder / "written"
    program.done(1, "run", deck, *words, "output.checkpoint_interval=0.01", "-o", written)
    left = sorted(file.name for file in written.glob("checkpoint_*.h5"))
    if left != [f"checkpoint_{steps:010d}.h5" for steps in (200, 250)]:
        raise SystemExit(f"the last two checkpoints must be kept: {left}")
    ran = program.done(1, "resume", written)
    if "the run is already finished" not in ran.stdout:
        raise SystemExit(f"a finished run: {ran.stdout}")
    program.done(1, "resume", written / left[0], "-o", folder / "again")
    same_bits(folder / "through", folder / "again", "from a checkpoint in between")
    program.done(1, "resume", written, "passage.duration=0.06", "-o", folder / "longer")
    if summary(folder / "longer")["windows"] != 300:
        raise SystemExit("the extension of a finished run must be accepted")
    for change, words in (("pad.stiffness=1e8", "was made with 120000000.0"),
                          ("output.stop_after=200", "the run has already computed"),
                          ("passage.points=[31]", "was made with [30.0, 30.3]")):
        ran = program(1, "resume", written, change, "-o", folder / "refused")
        if ran.returncode != 2 or words not in ran.stderr:
            raise SystemExit(f"resume with {change}: {ran.stdout}{ran.stderr}")
    ran = program.done(1, "info", written)
    if "train" not in ran.stdout:
        raise SystemExit(f"info of a checkpoint: {ran.stdout}")


def check_braking(program, decks, folder):
    """A braking train: bitwise identical on any number of ranks and after a stop, between two of
    its times and beyond the last. Its travel is the integral of its speeds, and its duration
    follows."""
    words = ["train.times=[0.1, 0.4]", "train.speeds=[50, 49.5]", "train.start=25"]
    place = folder / "brakes_1"
    for ranks in some((1, 3), (1, 2, 3, 4)):
        program.done(ranks, "run", decks / "plain.toml", *words, "passage.duration=0.5", "-o",
                     folder / f"brakes_{ranks}")
        same_bits(place, folder / f"brakes_{ranks}", f"braking on {ranks} ranks")
    x = datasets(place)["history/wheel/x"][-1, 0]
    if abs(x - (25 + 50 * 0.1 + 49.75 * 0.3 + 49.5 * 0.1)) > 1e-9:
        raise SystemExit(f"the first axle is at {x} m")
    for steps in some((700,), (700, 2100)):
        stopped = folder / f"brakes_stopped_{steps}"
        program.done(2, "run", decks / "plain.toml", *words, "passage.duration=0.5",
                     f"output.stop_after={steps}", "-o", stopped, code=3)
        program.done(1, "resume", stopped)
        same_bits(place, stopped, f"braking, stopped after {steps} steps")
    # 60 m plus 21.56 m to the last axle: 50 m at 50 m/s, then 31.56 m at 25 m/s on average.
    program.done(1, "run", decks / "plain.toml", "train.start=0", "train.times=[1, 21]",
                 "train.speeds=[50, 0]", "passage.step=1e-3", "-o", folder / "brakes_whole")
    time = summary(folder / "brakes_whole")["simulated_time_s"]
    wanted = 1 + 20 * (1 - np.sqrt(1 - 31.56 / 500))
    if not wanted <= time < wanted + 1.1e-3:
        raise SystemExit(f"the last axle leaves after {wanted} s, not {time} s")


def check_two_rails(program, decks, folder):
    """Stopped and resumed on another number of ranks: bitwise identical. The body rolls towards the
    unsupported rail."""
    words = [*SHORT, "track.dimension=space", "irregularity_right.kind=spectrum",
             "irregularity_right.seed=2", "track.zone.0.side=left",
             "under_sleeper_pad.stiffness=80e6", "under_sleeper_pad.damping=20e3",
             "under_sleeper_pad.to=28"]
    deck = folder / "hanging.toml"
    program.done(2, "run", deck, *words, "-o", folder / "space")
    place = folder / "space_stopped"
    program.done(1, "run", deck, *words, "output.stop_after=111", "-o", place, code=3)
    program.done(3, "resume", place)
    same_bits(folder / "space", place, "two rails")
    found = datasets(place)
    force, x = found["history/wheel/force"], found["history/wheel/x"]
    shapes = [found[f"history/{name}"].shape[1:] for name in (
        "wheel/force", "rail/displacement", "sleeper/seat_force", "body/roll")]
    roll = found["history/body/roll"].ravel()
    if shapes != [(8,), (4,), (4,), ()] or np.any(x[:, ::2] != x[:, 1::2]):
        raise SystemExit(f"histories of two rails: {shapes}")
    if not np.abs(force[:, ::2] - force[:, 1::2]).max() > 1e3 or not np.abs(roll).max() > 1e-6:
        raise SystemExit("forces of left and right wheels are equal")
    for change, words in (("irregularity_right.seed=3", "was made with 2"),):
        ran = program(1, "resume", place, change, "-o", folder / "refused")
        if ran.returncode != 2 or words not in ran.stderr:
            raise SystemExit(f"resume with {change}: {ran.stdout}{ran.stderr}")


def check_bending_sleepers(program, decks, folder):
    """Some sleepers are unsupported on the left: bitwise identical on any number of ranks and after
    a stop. Without ballast in the middle sagging moments below the rails increase, and hogging
    moments in the middle decrease."""
    words = [*SHORT, "track.dimension=space", "track.zone.0.side=left", "track.sleeper.model=beam",
             "track.sleeper.elements=4"]
    deck, place = folder / "hanging.toml", folder / "bending"
    program.done(1, "run", deck, *words, "-o", place)
    for ranks in some((3,), (2, 3, 4)):
        program.done(ranks, "run", deck, *words, "-o", folder / f"bending_{ranks}")
        same_bits(place, folder / f"bending_{ranks}", f"bending sleepers on {ranks} ranks")
    stopped = folder / "bending_stopped"
    program.done(2, "run", deck, *words, "output.stop_after=111", "-o", stopped, code=3)
    program.done(1, "resume", stopped)
    same_bits(place, stopped, "bending sleepers, stopped")
    moments = []
    for unsupported in (0, 0.6):
        place = folder / f"unsupported_{unsupported}"
        program.done(1, "run", decks / "plain.toml", *SHORT, "track.sleeper.model=beam",
                     "passage.points=[27]", f"track.sleeper.unsupported={unsupported}", "-o", place)
        moment = datasets(place)["history/sleeper/moment"]
        moments.append(moment[np.abs(moment[:, 0]).argmax()])
    (seat, middle), (seat_without, middle_without) = moments
    if not (1e3 < seat < seat_without < 1e4 and middle < middle_without):
        raise SystemExit(f"moments below a rail and in the middle: {moments} N m")


def check_seat_loads(program, decks, folder):
    """Loads of a locomotive on seats: each sleeper gets them at its time and in full; bitwise
    identical on any number of ranks and after a stop. A table of seats must have a column for
    each."""
    words = [*SEATS.split(" "), "load.speed=50", "load.start=-3", "passage.points=[30, 42]",
             "passage.step=5e-4"]
    place = folder / "seats_1"
    for ranks in some((1, 3), (1, 2, 3, 4)):
        program.done(ranks, "run", decks / "plain.toml", *words, "-o", folder / f"seats_{ranks}")
        same_bits(place, folder / f"seats_{ranks}", f"seat loads on {ranks} ranks")
    stopped = folder / "seats_stopped"
    program.done(2, "run", decks / "plain.toml", *words, "output.stop_after=1003", "-o", stopped,
                 code=3)
    program.done(3, "resume", stopped)
    same_bits(place, stopped, "seat loads, stopped")
    found = datasets(place)
    time, load = found["history/time"].ravel(), found["history/sleeper/seat_force"]
    rail = found["history/rail/displacement"]
    later = [time[one.argmax()] for one in load.T]
    # 12 m at 50 m/s; axles at 0, 2.8, 9 and 11.8 m: the last one is 3 m beyond the end.
    if abs(later[1] - later[0] - 0.24) > 1.1e-3 or np.abs(rail).max() > 1e-15:
        raise SystemExit(f"largest seat loads at {later} s, rail up to {np.abs(rail).max()} m")
    if not np.allclose(load.max(axis=0), 71.1e3, rtol=0.03) or abs(time[-1] - 77.8 / 50) > 1e-3:
        raise SystemExit(f"seat loads up to {load.max(axis=0)} N until {time[-1]} s")
    # As in the deck: 80.664 kN, a quarter of it at mid-bogie, 15 m after and 3 m before the start.
    program.done(1, "run", decks / "seats.toml", "passage.duration=0.65", "-o", folder / "carriage")
    found = datasets(folder / "carriage")
    time, load = (found[f"history/{name}"].ravel() for name in ("time", "sleeper/seat_force"))
    seat, middle = found["history/sleeper/moment"].T
    between = (time > 18 / 33.333) & (time < 20.5 / 33.333)
    ratios = [load.max() / 80.664e3, load[between].min() / 20.166e3]
    if not np.allclose(ratios, 1, atol=2e-3) or seat.max() < 5e3 or middle.min() > -1e3:
        raise SystemExit(f"ratio to the prescribed loads {ratios}; moments {seat.max()}, "
                         f"{middle.min()} N m")
    table = folder / "seats.csv"
    table.write_text("time_s,sleeper_0\n0,0\n1,5\n", encoding="utf-8")
    ran = program(1, "run", decks / "plain.toml", *words, "load.kind=seats",
                  f"load.file={table.resolve()}", "-o", folder / "refused")
    if ran.returncode != 2 or "there is no column sleeper_1" not in ran.stderr:
        raise SystemExit(f"a table that lacks sleepers: {ran.stdout}{ran.stderr}")


def check_forces(program, decks, folder):
    """An impact without a train: the rail below deflects and returns."""
    words = ["train.vehicles=[]", "passage.duration=0.5", "passage.points=[27]"]
    program.done(1, "run", folder / "hanging.toml", *words, "-o", folder / "hammer")
    found = datasets(folder / "hammer")
    rail, force = (found[f"history/rail/{name}"].ravel() for name in ("displacement", "force"))
    if abs(force.max() - 20e3) > 1e3 or rail.min() > -1e-5 or abs(rail[-1]) > 0.05 * -rail.min():
        raise SystemExit(f"an impact of {force.max()} N: rail {rail.min()} m, {rail[-1]} m")
    refuse(program, folder / "hanging.toml", words[:1], "must be above 0 s without vehicles")
    refuse(program, folder / "hanging.toml", ["force.0.at=61"], "beyond the track")
    refuse(program, folder / "hanging.toml", ["force.0.side=right"], "needs two rails")
    refuse(program, folder / "hanging.toml", ["track.zone.0.side=left"],
           'needs dimension = "space"')


def check_targets(program, decks, folder):
    """Targets in the deck's head: rail 0.8, rail to sleeper 0.2, ground 0.6 mm, within a tenth."""
    program.done(1, "run", decks / "netirail_plain.toml", "passage.duration=0.8",
                 "train.vehicles=[\"alfa_pendular\"]", "-o", folder / "train")
    found = datasets(folder / "train")
    rail, sleeper = (found[f"history/{of}/displacement"].ravel() for of in ("rail", "sleeper"))
    found = [-rail.min(), (sleeper - rail).max(), -sleeper.min()]
    if not np.allclose(found, [0.8e-3, 0.2e-3, 0.6e-3], rtol=0.1):
        raise SystemExit(f"displacements of the train: {found} m")


def main():
    program, decks, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2]), pathlib.Path(
        sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_refusals(program, decks, folder)
    check_files(program, decks, folder)
    check_runs(program, decks, folder)
    check_resume(program, decks, folder)
    check_braking(program, decks, folder)
    check_two_rails(program, decks, folder)
    check_bending_sleepers(program, decks, folder)
    check_seat_loads(program, decks, folder)
    check_forces(program, decks, folder)
    check_targets(program, decks, folder)


if __name__ == "__main__":
    main()
