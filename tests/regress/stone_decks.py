#!/usr/bin/env python3
"""Messages on decks with placed stones: initial overlaps, keys without effect, steps and windows,
names in messages of a run; the last row of a stage.

    stone_decks.py PROGRAM FOLDER [CHECK]
"""
import concurrent.futures
import pathlib
import re
import shutil
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from program import Program, expect  # noqa: E402
from results import datasets, same_datasets  # noqa: E402

HEAD = """title = "Stones"
model = "stones"
dimension = "space"

[[material]]
name = "rock"
density = 2600
young = 70e9

[[contact]]
first = "rock"
second = "rock"
"""
LINEAR = "k_n = 1e6\nk_s = 8e5\nfriction = 0.5\n"
HERTZ = 'law = "hertz"\n'
TAIL = """
[output]
history_interval = 0
checkpoint_interval = 0

[[stage]]
name = "go"
duration = 0.01
"""


def table(kind, name, **keys):
    rows = [f"[[{kind}]]", f'name = "{name}"', 'material = "rock"']
    rows += [f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value}"
             for key, value in keys.items()]
    return "\n".join(rows) + "\n"


def ball(name, position, **keys):
    return table("stone", name, **{"radius": 0.01, "position": position, **keys})


def block(name, position, **keys):
    return table("stone", name, **{"shape": "block", "sides": [0.04, 0.03, 0.02],
                                   "position": position, **keys})


def clump(name, position, *heights):
    spheres = [number for z in heights for number in (0, 0, z, 0.01)]
    return table("stone", name, shape="clump", spheres=spheres, position=position)


FLOOR = table("plate", "floor", size=[2, 2])
CHEST = table("box", "chest", low=[-0.1, -0.1, 0], high=[0.1, 0.1, 0.2])
BODY = table("box", "body", low=[-0.1, -0.1, -0.2], high=[0.1, 0.1, 0], side="outside")


class Bench:
    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def deck(self, text, law=LINEAR):
        path = self.folder / "deck.toml"
        path.write_text(HEAD + law + text + TAIL, encoding="utf-8")
        return path

    def refused(self, text, *words, changes=(), law=LINEAR):
        ran = self.program.done(1, "check", self.deck(text, law), *changes, code=2)
        for word in words:
            expect(word in ran.stderr, f"no \"{word}\"", ran)

    def accepted(self, text, changes=(), warning="", law=LINEAR):
        """Accepted without any other warning."""
        ran = self.program.done(1, "check", self.deck(text, law), *changes)
        expect(warning in ran.stdout and ran.stdout.count("warning") == (warning != ""),
               f"{text}: warnings", ran)
        return ran

    def run(self, text, changes=(), law=LINEAR, code=0, ranks=1):
        place = self.folder / "run"
        ran = self.program.done(ranks, "run", self.deck(text, law), *changes, "--force", "-o",
                                place, code=code)
        return place, ran


def require(holds, words):
    if not holds:
        raise SystemExit(words)


def check_depths(bench):
    """The first seven are not detected as contacts."""
    tall = {"sides": [0.04, 0.04, 0.4]}
    limit = "the limit is dem.largest_overlap = 0.2: place the stone further away"
    for text, depth, surface in (
            (block("a", [0, 0, 0], **tall) + FLOOR, 0.2, "floor"),
            (block("a", [0, 0, 0.05], **tall) + FLOOR, 0.15, "floor"),
            (block("a", [0, 0, 0.1], **tall) + CHEST, None, "chest"),
            (ball("a", [0, 0, -0.05]) + BODY, 0.06, "body"),
            (block("a", [0, 0, -0.05]) + BODY, 0.06, "body"),
            (clump("a", [0, 0, -0.05], -0.01, 0.01) + BODY, 0.07, "body"),
            (block("a", [0, 0, -0.1], sides=[0.3, 0.3, 0.3]) + BODY, 0.25, "body"),
            (ball("a", [0, 0, -0.001]) + FLOOR, 0.011, "floor"),
            (block("a", [0, 0, 0]) + BODY, None, "body")):
        words = f'initially overlaps surface "{surface}" by {depth} m' if depth else surface
        bench.refused(text, "deck.toml:", "stone[0].position", words, limit)
    place = bench.folder / "refused"
    ran = bench.program.done(1, "run", bench.folder / "deck.toml", "-o", place, code=2)
    expect(limit in ran.stderr and not place.exists(), "a refused run leaves a folder", ran)
    # Positions beside a plate, behind one or beside a box are valid, as is exact touch.
    for text in (block("a", [2, 0, 0], **tall) + FLOOR, block("a", [0, 0, -0.5], **tall) + FLOOR,
                 block("a", [0, 0, 0.1]) + CHEST, block("a", [0.2, 0, 0.1]) + CHEST,
                 block("a", [0, 0, 0.01]) + BODY):
        bench.accepted(text)


def check_behind(bench):
    """Stones behind plates and walls, up to the first collision; messages of `check` and run."""
    upside = FLOOR.replace("size", "normal = [0, 0, -1]\nsize")
    longer = "stage.go.duration=0.05"
    # The surface arrives 10 mm before the centre; corners of a block half its radius before.
    for text, time in (
            (ball("a", [0, 0, -0.03], velocity=[0, 0, 3.1]) + FLOOR, "0.00652"),
            (ball("a", [0.2, 0, 0.1], velocity=[-10, 0, 0]) + CHEST, "0.009"),
            (ball("a", [0, 0, -0.05]) + FLOOR.replace("size", "velocity = [0, 0, -5]\nsize"),
             "0.00806"),
            (ball("a", [0, 0, 0.011]) + upside, "0.0143"),
            (block("a", [0, 0, -0.1], sides=[0.02, 0.02, 0.1], velocity=[0, 0, 5.1]) + FLOOR,
             "0.00496")):
        bench.accepted(text, [longer], warning=f"from behind after about {time}")
        _, ran = bench.run(text, [longer], code=4)
        expect('stone "a" at (' in ran.stderr and "this stone came from behind" in ran.stderr,
               text, ran)
        ended = float(re.search(r"\(at (\S+) s, stage", ran.stderr)[1])
        expect(abs(ended - float(time)) < 2e-4, f"ends at {ended} s, check says {time} s", ran)
    # Plates that it does not reach, or that another plate shields.
    beside = FLOOR.replace("size", "centre = [1.5, 0, 0]\nsize")
    for text in (ball("a", [0, 0, -0.03], velocity=[0, 0, 3]) + beside,
                 ball("a", [0, 0, -0.03], velocity=[0, 0, 3]) + FLOOR
                 + table("plate", "lid", size=[2, 2], centre=[0, 0, -0.01], normal=[0, 0, -1]),
                 ball("a", [0, 0, -0.05], velocity=[0, 0, 0.3]) + FLOOR,
                 ball("a", [0, 0, 0.1], velocity=[0, 0, -3]) + FLOOR):
        bench.accepted(text, [longer])
    # It would fall through the box, if it did not rest on it.
    bench.accepted(ball("a", [0, 0, 0.01]) + BODY, ["stage.go.duration=0.5"])


def check_idle(bench):
    """Keys that have no effect for a shape or a contact law."""
    effect = "has no effect with shape = "
    for changes, key in ((dict(sides=[1, 1, 1]), "sides"), (dict(seed=7), "seed"),
                         (dict(corners=[1, 2, 3]), "corners"), (dict(rounding=2e-3), "rounding"),
                         (dict(unit=1e-3), "unit"), (dict(entry="x"), "entry"),
                         (dict(spheres=[0, 0, 0, 1]), "spheres")):
        bench.refused(ball("a", [0, 0, 0.5], **changes), f"stone[0].{key} = ", f'{effect}"ball"')
    bench.refused(block("a", [0, 0, 0.5], radius=0.03), f'stone[0].radius = 0.03: {effect}"block"')
    bench.refused(block("a", [0, 0, 0.5]), f'stone[0].polyhedron.vertices = 9: {effect}"block"',
                  changes=["stone.a.polyhedron.vertices=9"])
    drawn = table("stone", "a", shape="polyhedron", size=0.04, seed=3, position=[0, 0, 0.5])
    bench.accepted(drawn, ["stone.a.polyhedron.vertices=9"])
    bench.refused(drawn, f'stone[0].polyhedron.pieces = 4: {effect}"polyhedron"',
                  changes=["stone.a.polyhedron.pieces=4"])
    lone = ball("a", [0, 0, 0.5])
    for key in ("k_n = 1e6", "k_s = 1e6", "zeta_n = 0.1", "zeta_s = 0.1"):
        bench.refused(lone, f"contact[0].{key.split()[0]} = ", 'no effect with law = "hertz"',
                      law=HERTZ + key + "\n")
    bench.refused(lone, 'contact[0].restitution = 0.5: has no effect with law = "linear"',
                  law=LINEAR + "restitution = 0.5\n")
    bench.accepted(lone, law=HERTZ + "restitution = 0.5\n")


def check_laws(bench):
    """Stones of one material need a law with each other; its lack is reported once."""
    steel = '[[material]]\nname = "steel"\ndensity = 7850\n'
    balls = "".join(ball(name, [0, 0.1 * k, 0.5]) for k, name in enumerate("abc"))
    ran = bench.program.done(1, "check", bench.deck(steel + balls), "contact.0.first=steel",
                             "contact.0.second=steel", code=2)
    expect(ran.stderr.count('may be in contact with stones of "rock"') == 1
           and "stone[1].material" in ran.stderr, "the law of a material with itself", ran)


def check_steps(bench):
    lone = ball("a", [0, 0, 0.5])
    # sqrt(m/k) / 5 = 20.9 microseconds
    bench.refused(lone, "time.substeps: a window of 0.2087 s (10000 sub-steps",
                  'longer than stage "go" (0.01 s); give at most 479 sub-steps',
                  changes=["time.substeps=10000"])
    bench.accepted(lone, ["time.substeps=479"],
                   warning="and a contact needs at least four samples; give at most 3")
    bench.accepted(lone, ["time.substeps=3"])
    bench.refused(lone, "time.window: a window of 0.02 s", changes=["time.window=0.02"])
    bench.accepted(lone, ["time.window=0.01"])
    # The step given by the message is sufficient.
    long = "time.step=4e-6"
    bench.refused(lone, "this step would be allowed with dem.largest_overlap = 0.0018 (the run "
                  "then stops at larger overlaps) or dem.safety = 0.652", changes=[long], law=HERTZ)
    bench.accepted(lone, [long, "dem.largest_overlap=0.0018"], law=HERTZ)
    bench.accepted(lone, [long, "dem.safety=0.652"], law=HERTZ,
                   warning="dem.safety = 0.652 is outside the usual values")
    # As for beds, only for stones with corners.
    bench.accepted(lone, ["dem.safety=0.45"])
    damped = ["contact.0.zeta_s=1", "contact.0.zeta_n=1"]
    bench.accepted(lone, [*damped, "dem.safety=0.29"])
    bench.accepted(lone, [*damped, "dem.safety=0.31"],
                   warning="changes its sign in each sub-step if dem.safety is above about 0.30")
    bench.accepted(block("a", [0, 0, 0.5]), ["dem.safety=0.45"],
                   warning="dem.safety = 0.45: may be too large for compacted stones")
    ran = bench.accepted(ball("a", [0, 0, 0.5], motion="driven"), ["time.step=1e-5"])
    expect("determined by time.step" in ran.stdout and "inf" not in ran.stdout,
           "limit of driven stones", ran)


def check_sentences(bench):
    """Messages name the deck's keys, and suggest no key of another model."""
    lone = ball("a", [0, 0, 0.5])
    for change, words in (("bed.x=1", "bed is not a section of a deck with this `model`"),
                          ("ground.x=1", "ground is not a section of a deck with this `model`"),
                          ("stone.a.radus=1", "did you mean stone[0].radius?"),
                          ("gravity=0", "did you mean dem.gravity?"),
                          ("stone.a.center=[0,0,1]", "did you mean plate[].centre?"),
                          ("stage.go.duration=-1", "must be above 0 s"),
                          ("stage.go.duration=0", "must be above 0 s")):
        bench.refused(lone, words, changes=[change])
    for change, other in (("stone.a.mass=3", "rail"), ("dem.dt=1", "irregularity"),
                          ("dem.damping=1", "pad")):
        ran = bench.program.done(1, "check", bench.deck(lone), change, code=2)
        expect("is not a parameter" in ran.stderr and other not in ran.stderr, change, ran)
    flat = table("stone", "a", shape="hull", corners=[0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0])
    bench.refused(flat, "stone[0].corners: they enclose no volume")
    solid = flat.replace("1, 1, 0]", "0, 0, 1]")
    bench.refused(solid, "stone[0].rounding: 0.4 m must be", "must be below 0.341 m",
                  changes=["stone.a.rounding=0.4"])
    drawn = table("stone", "a", shape="polyhedron", size=0.04)
    bench.refused(drawn, "stone[0].shape: the stone cannot be made: no stone with 24 corners",
                  changes=["stone.a.polyhedron.flatness=0.05", "stone.a.polyhedron.rounding=0.2"])
    bench.refused(drawn, "elongation = 1 must be above 0 and at most 0.995",
                  changes=["stone.a.polyhedron.elongation=1"])
    library = bench.folder / "three.h5"
    bench.program.done(1, "shapes", "--stones", 3, "--library", library)
    shape = table("stone", "a", shape="library", file=str(library))
    bench.refused(shape, "stone[0].entry: must name one of the 3 shapes of",
                  "there are stone_1, stone_2, stone_3")
    bench.refused(shape, "has no shape \"pebble\"; there are stone_1, stone_2",
                  changes=["stone.a.entry=pebble"])
    bench.refused(table("stone", "a", shape="mesh", file=str(bench.folder / "deck.toml")),
                  "stone[0].file: ", "a mesh file must end in .stl")
    bench.accepted(clump("a", [0, 0, 0.5], -0.02, 0.02),
                   warning="spheres of stone \"a\" are separated by a gap of 0.02 m")
    bench.accepted(clump("a", [0, 0, 0.5], -0.02, 0.02, 0))
    # Fixed stones have no contacts with each other at any overlap; a free one has.
    held = (ball("a", [0, 0, 0.5], motion="fixed")
            + ball("b", [0, 0, 0.505], motion="driven", velocity=[1, 0, 0]))
    bench.accepted(held + ball("c", [1, 0, 0.5]))
    results, ran = bench.run(held + ball("c", [0, 0.0199, 0.5]), ["dem.gravity=0"])
    contacts = datasets(results)["history/total/contacts"]
    expect(contacts.max() == 1, f"contacts {contacts}", ran)


def check_names(bench):
    """Errors of a run name the stones."""
    for text, changes, words in (
            (ball("top", [0, 0, 0.5], velocity=[0, 0, 1]),
             ["domain.low=[-1,-1,-1]", "domain.high=[1,1,0.505]"], 'stone "top" left the domain'),
            (ball("low", [0, 0, 0.5], velocity=[0, 0, 5]) + ball("top", [0, 0, 0.525]),
             ["contact.0.k_n=1e4", "contact.0.k_s=1e4"],
             'stone "low" and stone "top" overlap by 0.2'),
            (ball("top", [0, 0, 0.02], velocity=[0, 0, -9]) + FLOOR,
             ["contact.0.k_n=1e4", "contact.0.k_s=1e4"],
             'stone "top" at (0, 0, 0.00688) m overlaps the surface "floor"')):
        _, ran = bench.run(text, changes, code=4)
        expect(words in ran.stderr and "behind" not in ran.stderr, words, ran)


def check_domain(bench):
    """A spinning stone launches the stone it touches; a long one may protrude from a domain."""
    spinning = (ball("a", [0, 0, 0.0099], spin=[0, 3000, 0])
                + ball("b", [0, 0, 0.029], motion="free"))
    bench.run(spinning, ["dem.gravity=0", "stage.go.duration=0.1"])
    long = (block("a", [0, 0, 0.012], sides=[0.4, 0.02, 0.02], spin=[0, 1, 0]) + FLOOR
            + ball("b", [0.15, 0, 0.0325]))
    found = []
    for low, high in (([-1, -1, -1], [1, 1, 1]), ([-1e-3, -1e-3, 0], [0.16, 1e-3, 0.05])):
        results, _ = bench.run(long, ["stage.go.duration=0.05", f"domain.low={low}",
                                      f"domain.high={high}"], ranks=2)
        found.append(datasets(results))
    require(found[0]["history/stone/b/peak_force"][-1] > 0, "the long stone is not touched")
    same_datasets(*found, "another domain", "history")


def check_last_row(bench):
    """One last row per stage, also if the run was stopped right there, in contact."""
    text = ball("a", [0, 0, 0.0095]) + block("b", [0.3, 0, 0.0099]) + FLOOR
    more = '\n[[stage]]\nname = "on"\nkind = "settle"\nduration = 5e-5\n'
    rare = ["stage.go.duration=1e-4", "output.history_interval=3e-4"]
    wanted = None
    for stop in (0, 4, 5, 7, 8):
        stopped = stop not in (0, 8)  # after all 8 windows the run is finished
        results, ran = bench.run(text + more, [*rare, f"output.stop_after={stop}"],
                                 code=3 if stopped else 0)
        if stopped:
            bench.program.done(1, "resume", results)
        found = {path: values for path, values in datasets(results).items()
                 if path.startswith("history")}
        wanted = wanted or found
        for path, values in wanted.items():
            expect(np.array_equal(values, found[path]), f"stopped after {stop}: {path}", ran)
    step = wanted["history/time"][0].item()
    # The second stage of the deck comes first.
    rows = np.round(wanted["history/time"].ravel() / step)
    expect(list(rows) == [1, 3, 4, 8] and wanted["history/total/contacts"][-1] > 0,
           f"rows after windows {rows}", ran)


def main():
    folder = pathlib.Path(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    checks = [check for check in (check_depths, check_behind, check_idle, check_laws, check_steps,
                                  check_sentences, check_names, check_domain, check_last_row)
              if len(sys.argv) < 4 or sys.argv[3] == check.__name__]

    def run(check):
        own = folder / check.__name__
        own.mkdir(parents=True)
        check(Bench(Program(sys.argv[1]), own))
        print(check.__name__, "done")

    # Most of the time is start and end of programs, so that several run at once.
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        list(pool.map(run, checks))


if __name__ == "__main__":
    main()
