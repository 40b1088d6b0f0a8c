#!/usr/bin/env python3
"""A track alone: values of the summary are those of the run, not of its output rows.

    track_numbers.py PROGRAM DECKS FOLDER
"""
import pathlib
import re
import shutil
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, summary  # noqa: E402
from results import datasets  # noqa: E402
from track import SHORT, same_bits  # noqa: E402
from track_warnings import COACH, TWO_RAILS, VEHICLE, deck_with  # noqa: E402


def check_extremes(program, decks, folder):
    """Extremes include every step for any number of rows of the histories, also across a stop."""
    found = []
    for name, words in (("each", ["output.history_interval=0"]),
                        ("few", ["output.history_interval=0.03"])):
        program.done(1, "run", decks / "plain.toml", *SHORT, *words, "-o", folder / name)
        found.append(summary(folder / name)["track"])
    rows = datasets(folder / "each")
    rail, force = rows["history/rail/displacement"], rows["history/wheel/force"]
    on = (rows["history/wheel/x"] >= 0) & (rows["history/wheel/x"] <= 60)
    if found[0]["rail_lowest_m"] != list(rail.min(axis=0)):
        raise SystemExit(f"lowest rail: {found[0]['rail_lowest_m']}, rows {rail.min(axis=0)}")
    if [found[0][f"wheel_force_{name}_n"] for name in ("min", "max")] != [force[on].min(),
                                                                        force[on].max()]:
        raise SystemExit(f"wheel forces: {found[0]}, rows {force[on].min()} {force[on].max()}")
    if found[0] != found[1]:
        raise SystemExit(f"extremes depend on the interval of the histories: {found}")
    check_envelope(folder / "each")
    stopped = folder / "few_stopped"
    program.done(2, "run", decks / "plain.toml", *SHORT, "output.history_interval=0.03",
                 "output.stop_after=149", "-o", stopped, code=3)
    program.done(1, "resume", stopped)
    same_bits(folder / "few", stopped, "extremes after a stop")


def check_envelope(place):
    """Extremes along the track equal those of the rows if every step has a row, and include the
    history points."""
    written = datasets(place)
    x = written["envelope/x"].ravel()
    for what, at in (("rail", "rail/x"), ("sleeper", "sleepers/x")):
        watched = written[at].ravel()
        shared = [i for i, one in enumerate(watched) if np.abs(x - one).min() < 1e-9]
        near = [int(np.abs(x - watched[i]).argmin()) for i in shared]
        if not near:
            raise SystemExit(f"{at}: {watched} are not in {x}")
        for name in ["displacement", "seat_force"] if what == "sleeper" else ["displacement"]:
            rows = written[f"history/{what}/{name}"].reshape(-1, len(watched))[:, shared]
            for end, wanted in (("min", rows.min(axis=0)), ("max", rows.max(axis=0))):
                found = written[f"envelope/{what}/{name}_{end}"].ravel()
                if len(found) != len(x) or list(found[near]) != list(wanted):
                    raise SystemExit(f"envelope of {what} {name}, {end}: {found[near]}, rows "
                                     f"have {wanted}")


def check_raised(program, decks, folder):
    """A rail uplifted at all times, before a train at rest, has no downward displacement."""
    ran = program.done(1, "run", decks / "plain.toml", "train.speed=0", "train.start=20",
                       "irregularity.kind=none", "irregularity.fade=10", "passage.duration=4e-3",
                       "passage.points=[22.2]", "output.history_interval=2e-4", "-o",
                       folder / "raised")
    least = datasets(folder / "raised")["history/rail/displacement"].min()
    found = summary(folder / "raised")["track"]["rail_lowest_m"]
    words = f"rail at 22.2 m: lowest position {1e3 * least:.4f} mm above its unloaded level"
    if not least > 1e-6 or found != [least] or words not in ran.stdout:
        raise SystemExit(f"lowest rail {found}, rows have {least}; wanted '{words}':\n{ran.stdout}")


def check_run_ins(program, decks, folder):
    """A flat on the nearly rigid rail of the run-in has several times the impact force of that on
    the track, whose forces are reported; a bridge has no run-in."""
    words = ["irregularity.kind=none", "irregularity.fade=10", "wheel_rail.flat_axle=1",
             "output.history_interval=2e-4"]
    for name, support, span, text in (("flat", [], (6, 54), ", between the run-ins (6 to 54 m)"),
                                      ("bridge", ["track.support=none", "rail.inertia=1"],
                                       (0, 60), " kN\n")):
        ran = program.done(1, "run", decks / "plain.toml", *words, *support, "-o", folder / name)
        rows = datasets(folder / name)
        force, x = rows["history/wheel/force"], rows["history/wheel/x"]
        most = force[(x >= span[0]) & (x <= span[1])].max()
        found = summary(folder / name)["track"]["wheel_force_max_n"]
        print(f"{name}: {found:.0f} N, anywhere {force[(x >= 0) & (x <= 60)].max():.0f} N")
        if found != most or f"to {most / 1e3:.2f} kN{text.removeprefix(' kN')}" not in ran.stdout:
            raise SystemExit(f"{name}: {found} N, rows have {most} N:\n{ran.stdout}")
        if name == "flat" and force.max() < 3 * most:
            raise SystemExit(f"force in the run-in {force.max()} N: the test is meaningless")


def check_d1(program, decks, folder):
    """D1 of sampled or read profiles of each rail; that of the spectrum is equal for all seeds."""
    left, right = 3e-3 * np.sqrt(0.5), 1e-3 * np.sqrt(0.5)  # m, of waves of 8 m
    x = np.arange(0, 400.05, 0.1)
    for name, height in (("left", 3e-3), ("right", 1e-3)):
        rows = np.stack([x, height * np.sin(2 * np.pi * x / 8)], axis=1)
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header="x_m,z_m", comments="")
    words = [f"{section}.{key}" for section, name in (("irregularity", "left"),
                                                      ("irregularity_right", "right"))
             for key in ("kind=file", f"file={(folder / name).resolve()}.csv")]
    program.done(1, "run", decks / "plain.toml", *SHORT, *words, "track.dimension=space",
                 "track.length=396", "-o", folder / "waves")
    found = summary(folder / "waves")["track"]
    for name, wanted in (("irregularity", left), ("irregularity_right", right)):
        if abs(found[f"{name}_d1_rms_m"] - wanted) > 0.02 * wanted:
            raise SystemExit(f"D1 of {name}: {found}, waves have {wanted} m")
    drawn = []
    for seed in (1, 2):
        program.done(1, "run", decks / "plain.toml", *SHORT, "irregularity.kind=spectrum",
                     f"irregularity.seed={seed}", "-o", folder / f"seed_{seed}")
        drawn.append(summary(folder / f"seed_{seed}")["track"])
    if drawn[0]["irregularity_spectrum_d1_rms_m"] != drawn[1]["irregularity_spectrum_d1_rms_m"]:
        raise SystemExit(f"one spectrum has one D1: {drawn}")
    if drawn[0]["irregularity_d1_rms_m"] == drawn[1]["irregularity_d1_rms_m"]:
        raise SystemExit(f"two profiles have the same D1: {drawn}")


def check_crossing(program, decks, folder):
    """A deeper dip causes larger wheel forces and sleeper accelerations."""
    forces, accelerations = [], []
    for depth in (0.75e-3, 1.5e-3):
        place = folder / f"dip_{depth}"
        program.done(1, "run", decks / "crossing.toml", f"irregularity.depth={depth}",
                     "train.start=15", "passage.duration=0.1", "-o", place)
        forces.append(summary(place)["track"]["wheel_force_max_n"])
        accelerations.append(np.abs(datasets(place)["history/sleeper/acceleration"]).max())
    if forces[1] < 1.2 * forces[0] or accelerations[1] < 1.2 * accelerations[0]:
        raise SystemExit(f"dips of 0.75 and 1.5 mm: {forces} N, {accelerations} m/s2")


def check_panels(program, decks, folder):
    """Largest wheel forces over the scanned crossing are those of docs/postproc.md."""
    table = (decks.parents[1] / "docs/postproc.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (facing|trailing) \| (\d+) \| (\d+) \|$", table, re.MULTILINE)
    if len(rows) != 4:
        raise SystemExit(f"docs/postproc.md has the rows {rows} of crossing panels")
    for move, pads, force in part(rows):
        place = folder / f"panel_{move}_{pads}"
        program.done(1, "run", decks / "crossing_panel.toml", f"pad.stiffness={pads}e6",
                     f"irregularity.file={decks.resolve()}/crossing_{move}.csv", "-o", place)
        found = summary(place)["track"]["wheel_force_max_n"] / 1e3
        if abs(found - float(force)) > 0.01 * float(force):
            raise SystemExit(f"crossing panel, {move}, pads of {pads} MN/m: {found} kN, "
                             f"docs/postproc.md has {force}")


def check_lost(program, decks, folder):
    """Loss of contact counts while wheels are on the track, not beyond it."""
    place = folder / "flies"
    program.done(1, "run", decks / "plain.toml", "irregularity.kind=vee", "irregularity.at=59.7",
                 "irregularity.length=0.6", "irregularity.depth=-6e-3", "train.start=55",
                 "passage.duration=0.12", "output.history_interval=2e-4", "-o", place)
    rows = datasets(place)
    off, on = rows["history/wheel/force"] == 0, rows["history/wheel/x"] <= 60
    counted = summary(place)["track"]["wheel_steps_off_rail"]
    if not (off & ~on).any() or not 0 < counted == (off & on).sum():
        raise SystemExit(f"{counted} steps of wheels off the rail: rows have {(off & on).sum()}, "
                         f"and {(off & ~on).sum()} beyond the track")


def check_energy(program, decks, folder):
    """Without dampers the track keeps the energy of an impact, also with open pads, pads compressed
    beyond their change of stiffness, and unsupported sleepers that hit the ballast. The first time
    is within the impact, at later ones the rail lifts off or lands."""
    blow = """
[[force]]
kind = "impact"
at = 3
size = {}
length = 4e-3
"""
    hang = "\n[[track.zone]]\nfrom = 1.7\nto = 3.1\ngap = 1e-4\n"
    kinds = (("linear", -100e3, "", []), ("uplift", -100e3, "", ["pad.uplift=true"]),
             ("knees_gaps", 150e3, hang, ["pad.bilinear_at=5e-5", "pad.bilinear_stiffness=400e6"]))
    for name, size, zone, words in kinds:
        deck = folder / f"{name}.toml"
        deck.write_text((decks / "plain.toml").read_text(encoding="utf-8") + blow.format(size) +
                        zone, encoding="utf-8")
        for until in (2e-3, 5e-3, 7e-3, 0.01, 0.014, 0.02):
            place = folder / f"blow_{name}_{until}"
            program.done(1, "run", deck, "train.vehicles=[]", "irregularity.kind=none",
                         *words, "pad.damping=0", "ballast.damping=0",
                         "track.length=6", "track.run_in=0", "passage.points=[3]",
                         "passage.step=5e-6", "output.history_interval=5e-6",
                         f"passage.duration={until}", "-o", place)
            rows = datasets(place)
            force = -rows["history/rail/force"].ravel()  # upwards
            height = rows["history/rail/displacement"].ravel()
            given = np.sum((force[1:] + force[:-1]) / 2 * np.diff(height))
            held = summary(place)["energy"]["track_j"]
            if not given > 50 or abs(held - given) > 1e-5 * given:
                raise SystemExit(f"{name}, {until} s: energy of the track {held} J, of the impact "
                                 f"{given} J")


def check_order(program, decks, folder):
    """Order in the step, for wheels that roll over an even rail after 60 ms: second order on an
    Euler-Bernoulli rail. A Timoshenko rail has a kink under each wheel: first order
    (docs/track.md)."""
    steps, off = (2e-4, 1e-4, 5e-5), {}
    for theory in ("euler", "timoshenko"):
        rail = []
        for step in steps:
            place = folder / f"{theory}_{step}"
            program.done(1, "run", decks / "plain.toml", "irregularity.kind=none",
                         "train.start=20", "passage.duration=0.12", f"rail.theory={theory}",
                         "passage.points=[24]", "output.history_interval=8e-4",
                         f"passage.step={step}", "-o", place)
            rows = datasets(place)
            late = rows["history/time"].ravel() > 0.0595
            rail.append(rows["history/rail/displacement"].ravel()[late])
        off[theory] = [np.abs(a - b).max() for a, b in zip(rail, rail[1:])]
    order = {theory: np.log2(two[0] / two[1]) for theory, two in off.items()}
    if abs(order["euler"] - 2) > 0.2 or off["euler"][0] > 1e-8:
        raise SystemExit(f"Euler-Bernoulli rail: order {order}, changes {off} m")
    if not 0.5 < order["timoshenko"] < 1.5 or off["timoshenko"][0] > 5e-7:
        raise SystemExit(f"Timoshenko rail: order {order}, changes {off} m: "
                         "does docs/track.md still hold?")
    print(f"order in the step {order}, changes {off} m")


def check_standing(program, decks, folder):
    """A wheel at rest in the middle of a bridge, which has no run-in: P L^3/(48 E I), to the
    tolerance of the contact."""
    deck, place = folder / "standing.toml", folder / "standing"
    deck.write_text((decks / "plain.toml").read_text(encoding="utf-8") + "[[vehicle]]\n"
                    'name = "own"\nkind = "wheel"\nlength = 2\nwheelset_mass = 22e3\n',
                    encoding="utf-8")
    program.done(1, "run", deck, 'train.vehicles=["own"]', "train.speed=0", "train.start=30",
                 "track.support=none", "track.rails=1", "rail.theory=euler",
                 "rail.young=210e9", "rail.inertia=0.3", "irregularity.kind=none",
                 "passage.duration=0.1", "passage.points=[30]", "-o", place)
    found, weight = summary(place)["track"], 22e3 * 9.81
    down, wanted = -found["rail_lowest_m"][0], weight * 60**3 / (48 * 210e9 * 0.3)
    forces = [found["wheel_force_min_n"], found["wheel_force_max_n"]]
    print(f"a wheel that stands: {1e3 * down:.7f} mm, {1e3 * wanted:.7f} mm by theory")
    if not np.allclose(down, wanted, rtol=1e-6) or not np.allclose(forces, weight, rtol=1e-6):
        raise SystemExit(f"{down} m and {forces} N, {wanted} m and {weight} N are required")


def check_tipping(program, decks, folder):
    """Accepted vehicles stand on rigid rails with a positive force on every wheel, however small;
    on a track that deflects more below some axles they need a larger one."""
    more, changes = VEHICLE.format(COACH.replace("= 20", "= 21")), ["irregularity.kind=none",
                                                                    "irregularity.fade=10"]
    deck = deck_with(decks, folder, more + "body_offset = 0.949\n")
    changes += [*TWO_RAILS, "passage.duration=2e-4", "--force", "-o", folder / "tips"]
    program.done(1, "run", deck, *changes, "train.start=-1")
    least = datasets(folder / "tips")["history/wheel/force"][0].min()
    wanted = 9.81 * (38e3 * 1.5 / 2 - 30e3 * 0.949) / 1.5 / 4  # N, of each of four right wheels
    if abs(least - wanted) > 1e-3 * wanted:
        raise SystemExit(f"a vehicle about to tip over: {least} N, {wanted} N are required")
    ran = program(1, "run", deck, *changes, "train.start=25")
    if ran.returncode != 4 or "reduce body_offset of own" not in ran.stderr:
        raise SystemExit(f"a vehicle that tips over on the track:\n{ran.stderr}")


def main():
    program, decks, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2]), pathlib.Path(
        sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_extremes(program, decks, folder)
    check_raised(program, decks, folder)
    check_run_ins(program, decks, folder)
    check_d1(program, decks, folder)
    check_crossing(program, decks, folder)
    check_panels(program, decks, folder)
    check_lost(program, decks, folder)
    check_energy(program, decks, folder)
    check_order(program, decks, folder)
    check_standing(program, decks, folder)
    check_tipping(program, decks, folder)


if __name__ == "__main__":
    main()
