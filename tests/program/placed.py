#!/usr/bin/env python3
"""Decks with placed stones, against closed forms: free flight, rebound, free rotation, sliding and
rolling on a slope, a collision of two, a stack at rest; driven bodies; a plane model and its line
contact; tangential load.

    placed.py PROGRAM INPUTS_VERIFY FOLDER
"""
import math
import pathlib
import shutil
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
sys.path.insert(0, str(HERE.parents[1] / "postproc"))
from trackbed_post import read  # noqa: E402
from program import Program, expect  # noqa: E402

GRAVITY = 9.81


class Bench:
    def __init__(self, program, decks, folder):
        self.program, self.decks, self.folder, self.report = program, decks, folder, ""

    def run(self, deck, *overrides, name=None, ranks=1):
        """Results of a deck by its name under inputs/verify, or by its path."""
        path = deck if isinstance(deck, pathlib.Path) else self.decks / f"{deck}.toml"
        place = self.folder / (name or path.stem)
        self.report = self.program.done(ranks, "run", path, *overrides, "-o", place).stdout
        return read.results(place)


def require(holds, words):
    if not holds:
        raise SystemExit(words)


def near(found, wanted, tolerance, what):
    difference = np.abs(np.asarray(found) - np.asarray(wanted))
    worst = np.unravel_index(np.nanargmax(difference), difference.shape)
    require(np.all(difference <= tolerance),
            f"{what}: {np.asarray(found)[worst]} is off by {difference[worst]:.3g}, at {worst}")


def column(results, stone, name):
    return results.placed[stone][name].values


def mass_of_ball(radius, density):
    return density * 4 / 3 * math.pi * radius**3


def check_decks(bench):
    """Every deck is valid without a warning, and runs."""
    decks = sorted(bench.decks.glob("*.toml"))
    require(len(decks) >= 6, f"decks are missing: {decks}")
    for deck in decks:
        ran = bench.program.done(1, "check", deck)
        expect("is valid" in ran.stdout and "warning" not in ran.stdout, f"{deck}: warnings", ran)
        expect("estimated wall time" in ran.stdout, f"{deck}: no estimate", ran)


def check_flight(bench):
    """Without forces positions and attitude are functions of time only; under gravity parabolas,
    for which velocity Verlet is exact."""
    for gravity in (0, GRAVITY):
        found = bench.run("impact", "plate.glass.centre=[0,0,-1]", "stage.impact.duration=1e-3",
                          "output.history_interval=1e-5", f"dem.gravity={gravity}",
                          name=f"flight_{gravity}")
        t = found.time
        start, speed = np.array([0, 0, 2.51e-3]), np.array([1.95, 0, -3.377])
        fall = np.array([0, 0, -gravity])
        near(column(found, "ball", "position"),
             start + np.outer(t, speed) + np.outer(t**2 / 2, fall), 1e-12, "place in free flight")
        near(column(found, "ball", "velocity"), speed + np.outer(t, fall), 1e-11, "its speed")
        near(column(found, "ball", "peak_force"), 0, 0, "force in free flight")
        total = found.energy["kinetic"].values + found.energy["potential"].values
        near(total, total[0], 1e-10 * total[0], "energy in free flight")


def check_impact(bench):
    """Central impact with e = 1: equal rebound speed; impulses equal the change of momentum."""
    # Velocity Verlet: second order in the step, of which there are 100 in a contact.
    found = bench.run("impact", "contact.0.restitution=1", "stone.ball.velocity=[0,0,-3]",
                      name="rebound")
    velocity = column(found, "ball", "velocity")
    near(velocity[-1], [0, 0, 3], 1e-3 * 3, "rebound with restitution 1")
    found = bench.run("impact")
    momentum, impulse = column(found, "ball", "momentum"), column(found, "ball", "impulse")
    force = column(found, "ball", "force")
    mass = mass_of_ball(2.5e-3, 4000)
    near(momentum[-1] - mass * np.array([1.95, 0, -3.377]), impulse[-1], 1e-12 * 1e-3, "impulse")
    plate = found.surfaces["glass"]
    near(plate["impulse"].values, -impulse, 1e-11 * np.abs(impulse).max(), "impulse on the plate")
    near(plate["force"].values, -force, 1e-11 * np.abs(force).max(), "force on the plate")
    sizes = np.linalg.norm(force, axis=1)
    require(len(found.time) > 200 and (sizes > 0).sum() > 50, "the impact is not resolved")
    near(column(found, "ball", "peak_force").ravel(), np.maximum.accumulate(sizes), 0, "peak")
    # A damper without tension has no force at the end of a contact.
    contacts = found.total["contacts"].values.ravel()
    require(np.all(contacts[sizes > 0] == 1) and contacts[0] == contacts[-1] == 0
            and contacts.sum() < (sizes > 0).sum() + 20, f"number of contacts: {contacts}")


def check_bounce(bench):
    """The normal force does not depend on slip: between impacts the normal speed is constant,
    except for the error of velocity Verlet in ten impacts. Without damping the energy between
    impacts never rises; friction has dissipated some of it."""
    found = bench.run("bounce")
    free = found.total["contacts"].values.ravel() == 0
    speed = np.abs(column(found, "ball", "velocity")[free, 2])
    near(speed, 0.2, 10 * 1e-4 * 0.2, "speed between the plates")
    turns = np.count_nonzero(np.diff(np.sign(column(found, "ball", "velocity")[free, 2])))
    near(turns, 10, 0, "number of impacts")
    energy = found.energy
    total = sum(energy[name].values.ravel()[free] for name in ("translational", "rotational"))
    rise = np.max(total - np.minimum.accumulate(total)) / total[0]
    require(rise < 1e-6, f"the energy rises by {rise:.3g} of its initial value")
    require(0.98 < total[-1] / total[0] < 0.999, f"{total[-1] / total[0]} of the energy is left")


def check_splitting(bench):
    """Two stones between plates split; what is left, and fines, have the mass of both."""
    found = bench.run("splitting")
    rows = next(reversed(found.breaks.values()))
    kinds, first = rows[:, read.BREAK["kind"]], rows[:, read.BREAK["stone"]] < 2
    require((first & (kinds == read.SPLIT)).any() and (kinds == read.CORNER).any(),
            "no stone has split, or no corner was crushed")
    fines = rows[rows[:, read.BREAK["fragment"]] < 0, read.BREAK["mass"]].sum()
    left = next(reversed(found.stones.values())).sieved[:, 1].sum()
    whole = bench.run("splitting", "breakage.splitting.strength=0", "breakage.cutting.strength=0",
                      "stage.crush.duration=1e-3", name="whole")
    mass = next(reversed(whole.stones.values())).sieved[:, 1].sum()
    near(left + fines, mass, 1e-12 * mass, "mass of stones and fines")


def check_agglomerate(bench):
    """Until the first bond breaks, an agglomerate between plates is linear: with twice the strength
    this happens at twice the compression. Bonds that soften break later, after a larger force."""
    def crushed(name, *changes):
        found = bench.run("agglomerate", *changes, name=name)
        bonds = next(iter(found.bonds.values()))
        first = bonds.broken[:, read.BROKEN["time"]].min()
        peak = found.surfaces["upper"]["force"].values[:, 2].max()
        require(len(bonds.whole) + len(bonds.broken) == 156, "bonds are lost")
        require('bonds: 156 of "cement"' in bench.report, f"no report of bonds: {bench.report}")
        return first, peak
    first, peak = crushed("agglomerate")
    later, larger = crushed("stronger", "bond.cement.tension=2e6", "bond.cement.shear=2e6")
    near(later, 2 * first, 0.02 * first, "first break with twice the strength")
    require(larger > 1.9 * peak, f"peak of {larger} N with twice the strength: {peak} N before")
    # Polyhedra are bonded where they touch; a gap is for balls.
    ran = bench.program.done(1, "check", bench.decks.parent / "bed/glued.toml",
                             "bond.glue.gap=1e-3")
    require("there are no balls" in ran.stdout, f"no warning of an idle gap: {ran.stdout}")
    tough, tougher = crushed("tough", "bond.cement.softening=4")
    require(tough > 1.5 * first and tougher > 1.5 * peak, "softening has no effect")


def check_rotation(bench):
    found = bench.run("rotation")
    momentum = column(found, "block", "angular_momentum")
    near(momentum, momentum[0], 1e-13 * np.abs(momentum).max(), "angular momentum")
    energy = found.energy["rotational"].values.ravel()
    near(energy, energy[0], 1e-4 * energy[0], "energy of free rotation")
    q = column(found, "block", "attitude")
    up = 1 - 2 * (q[:, 0]**2 + q[:, 2]**2)  # cosine between its middle axis and y
    require(up.min() < -0.99 and up.max() > 0.99, "the block does not tumble")
    # About a principal axis the attitude follows from the angle.
    found = bench.run("rotation", "stone.block.spin=[0,0,3]", "stone.block.axis=[0,0,1]",
                      "stone.block.angle=20", name="steady")
    angle = (math.radians(20) + 3 * found.time) / 2
    wanted = np.stack([0 * angle, 0 * angle, np.sin(angle), np.cos(angle)], axis=1)
    near(column(found, "block", "attitude"), wanted, 1e-9, "attitude about one axis")


def check_slope(bench):
    found = bench.run("slope")
    tilt, mu = math.radians(20), 0.2
    down = np.array([math.cos(tilt), 0, -math.sin(tilt)])
    t = found.time
    late = t > 0.1  # once both rest on the plate
    for stone, wanted in (("block", GRAVITY * (math.sin(tilt) - mu * math.cos(tilt))),
                          ("ball", 5 / 7 * GRAVITY * math.sin(tilt))):
        along = column(found, stone, "velocity") @ down
        slope = np.polyfit(t[late], along[late], 1)[0]
        near(slope, wanted, 1e-3 * wanted, f"acceleration of the {stone}")
    # Rolling: spin times radius is speed.
    near(column(found, "ball", "spin")[late, 1] * 0.02,
         (column(found, "ball", "velocity") @ down)[late], 2e-3, "rolling of the ball")
    heat = found.energy["dissipated"].values.ravel()
    require(np.all(np.diff(heat[late]) > 0), "friction increases the energy")


def check_pair(bench):
    found = bench.run("pair", ranks=2)
    for name in ("momentum", "angular_momentum"):
        sums = found.total[name].values
        near(sums, sums[0], 1e-13 * np.abs(sums).max(), f"{name} of both")
    near(column(found, "large", "impulse"), -column(found, "small", "impulse"), 1e-16,
         "impulses of both")
    require(np.linalg.norm(column(found, "large", "impulse")[-1]) > 1e-3, "they do not collide")


def check_stack(bench):
    found = bench.run("stack")
    weight = {name: GRAVITY * 2650 * volume for name, volume in (
        ("low", block(0.06, 0.06, 0.04)), ("middle", block(0.05, 0.05, 0.04)),
        ("top", block(0.04, 0.04, 0.03)))}
    for name, own in weight.items():
        near(column(found, name, "force")[-1], [0, 0, own], 1e-6 * own, f"force on {name}")
    total = sum(weight.values())
    near(found.surfaces["floor"]["force"].values[-1], [0, 0, -total], 1e-6 * total, "floor")
    near([column(found, name, "contacts")[-1].item() for name in weight], [2, 2, 1], 0, "contacts")
    require(found.energy["kinetic"].values[-1] < 1e-12, "the stack does not come to rest")


def block(a, b, c, r=2e-3):
    """Volume of a block with rounded edges: core, slabs, edges, corners."""
    x, y, z = a - 2 * r, b - 2 * r, c - 2 * r
    return (x * y * z + 2 * r * (x * y + y * z + z * x) + math.pi * r**2 * (x + y + z)
            + 4 / 3 * math.pi * r**3)


def check_driven(bench):
    """A ball between a moving plate and a fixed stone: driven bodies keep their velocity, and the
    supplied work equals the energy of the ball plus the dissipation."""
    changes = ["stone.block.motion=driven", "stone.block.velocity=[0.1,0,0]",
               "stone.block.spin=[1,2,3]"]
    found = bench.run("rotation", *changes, "time.step=1e-4", name="driven")
    t = found.time
    near(column(found, "block", "spin"), [[1, 2, 3]] * len(t), 1e-11, "spin of a driven stone")
    near(column(found, "block", "position"), np.outer(t, [0.1, 0, 0]), 1e-12, "its place")
    found = bench.run("pair", "stone.small.motion=driven", "stone.large.spin=[0,0,0]",
                      name="bat")
    velocity = column(found, "small", "velocity")
    near(velocity, [[-1, 0.3, -0.2]] * len(velocity), 0, "velocity of a driven stone")
    supplied = found.energy["supplied"].values.ravel()[-1]
    gained = found.energy["kinetic"].values.ravel()
    lost = found.energy["dissipated"].values.ravel()[-1]
    near(supplied, gained[-1] - gained[0] + lost, 1e-12, "work of the bat")
    require(supplied > 1e-4 and lost > 0, "the bat does no work")
    found = bench.run("impact", "plate.glass.velocity=[0,0,2]", "stone.ball.velocity=[0,0,-1]",
                      "contact.0.restitution=1", name="racket")
    near(column(found, "ball", "velocity")[-1], [0, 0, 5], 5e-3, "rebound off a moving plate")
    near(found.surfaces["glass"]["displacement"].values, np.outer(found.time, [0, 0, 2]), 1e-18,
         "displacement of the plate")
    # Change of momentum times the plate's speed; by the trapezoid rule.
    near(found.energy["supplied"].values[-1].item(), mass_of_ball(2.5e-3, 4000) * 6 * 2,
         2e-3 * 0.003, "work of the plate")


PLANE = """title = "Disk and clump in a box"
model = "stones"
dimension = "plane"
thickness = 0.5

[[material]]
name = "stone"
density = 2000

[[contact]]
first = "stone"
second = "stone"
k_n = 1e6
k_s = 1e6
friction = 0

[[stone]]
name = "disk"
radius = 0.02
material = "stone"
position = [0.1, 0, 0.1]
velocity = [1, 0, 0.4]

[[stone]]
name = "pair"
shape = "clump"
spheres = [-0.01, 0, 0, 0.01, 0.01, 0, 0, 0.01]
material = "stone"
position = [-0.1, 0, 0.1]
angle = 90
spin = [0, 5, 0]

[[box]]
name = "walls"
material = "stone"
low = [-0.2, 0, 0]
high = [0.2, 1, 0.3]

[dem]
gravity = 0
safety = 0.05

[[stage]]
name = "fly"
duration = 0.5
"""


def check_plane(bench):
    deck = bench.folder / "plane.toml"
    deck.write_text(PLANE, encoding="utf-8")
    bench.program.done(1, "check", deck)
    found = bench.run(deck, ranks=2)
    mass = 2000 * 0.5 * math.pi * 0.02**2
    near(column(found, "disk", "momentum")[0], [mass, 0, 0.4 * mass], 1e-12, "mass of a disk")
    near(column(found, "pair", "attitude")[0] * math.sqrt(2), [0, 1, 0, 1], 5e-3, "attitude")
    energy = found.energy["kinetic"].values + found.energy["elastic"].values
    # Steps of s sqrt(m/k) have a relative energy error of s^2/4 in a contact.
    near(energy, energy[0], 0.05**2 / 4 * energy[0], "energy without friction and dampers")
    require(column(found, "disk", "peak_force")[-1] > 0, "the disk does not touch the walls")


def compliance(young, poisson):
    """1/E* and 1/G* of two bodies of one material."""
    return (2 * (1 - poisson**2) / young, 4 * (2 - poisson) * (1 + poisson) / young)


def check_disk(bench):
    """Parallel cylinders: half a period on a spring of pi/4 E* times the thickness; sliding
    throughout with friction."""
    radius, speed, mu = 0.01, 0.3, 0.3
    for thickness in (0.5, 0.25):
        found = bench.run("disk", f"thickness={thickness}", name=f"disk_{thickness}")
        mass = 2700 * thickness * math.pi * radius**2
        stiffness = math.pi / 4 / compliance(70e9, 0.33)[0] * thickness
        pace = math.sqrt(stiffness / mass)
        step = 4e-8 * pace  # phase angle per step, rad
        z = column(found, "disk", "position")[:, 2]
        force = column(found, "disk", "force")
        inside = np.flatnonzero(z < radius)
        require(400 < len(inside) < 420, f"{len(inside)} steps in contact")
        # In the steps of closing and opening the force differs.
        whole = inside[1:-1]
        near(force[whole, 2] / (radius - z[whole]), stiffness, 1e-12 * stiffness, "stiffness")
        # Rounded twice.
        near(force[whole, 0], -mu * force[whole, 2], 2**-52 * abs(force[whole, 0]).max(),
             "friction")
        # Sampled between two steps; velocity Verlet changes the amplitude by step^2/8.
        depth = speed / pace
        near(radius - z.min(), depth, step**2 / 4 * depth, "overlap")
        begin = (0.01001 - radius) / speed
        end = found.time[-1] - (z[-1] - radius) / speed
        near(end - begin, math.pi / pace, step**2 / 12 * math.pi / pace, "contact time")
        momentum = column(found, "disk", "momentum")
        change = momentum[-1] - momentum[0]
        # Overlaps of a micrometre are differences of positions of a centimetre.
        near(change[2], 2 * mass * speed, 2e-11 * mass * speed, "rebound with restitution 1")
        near(-change[0] / change[2], mu, 1e-9, "tangential over normal impulse")
        # The lever arm is the radius less the overlap.
        turned = -change[0] * radius / (mass * radius**2 / 2)
        near(column(found, "disk", "spin")[-1, 1], turned, depth / radius * turned, "spin")
        found = bench.run("disk", f"thickness={thickness}", "contact.0.friction=0",
                          name=f"smooth_{thickness}")
        energy = found.energy["kinetic"].values
        near(energy[-1], energy[0], 2e-11 * energy[0], "energy without friction")


def check_shear(bench):
    """Mindlin's stiffness and Coulomb's limit of a sphere driven along a plate."""
    found = bench.run("shear")
    soft, yielding = compliance(70e9, 0.25)
    size = math.sqrt(0.01 * 1e-5)
    normal, shear = 4 / 3 / soft * size * 1e-5, 8 / yielding * size
    force = column(found, "ball", "force")[1:]
    travel = 0.01 * found.time[1:]
    near(force[:, 2], normal, 1e-12 * normal, "normal force")
    near(force[:, 0], -np.minimum(shear * travel, 0.3 * normal), 1e-12 * normal, "tangential force")
    require(shear * travel[0] < 0.01 * normal < 0.3 * normal < shear * travel[-1], "no slip")
    # By the trapezoid rule, with an error at the kink.
    work = found.energy["supplied"].values.ravel()[-1]
    limit = 0.3 * normal / shear
    near(work, 0.3 * normal * (travel[-1] - limit / 2), 1e-6 * work, "work of the ball")


def main():
    folder = pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    bench = Bench(Program(sys.argv[1]), pathlib.Path(sys.argv[2]), folder)
    for check in (check_decks, check_flight, check_impact, check_bounce, check_splitting,
                  check_agglomerate, check_rotation, check_slope, check_pair, check_stack,
                  check_driven, check_plane, check_disk, check_shear):
        check(bench)
        print(check.__name__, "done")


if __name__ == "__main__":
    main()
