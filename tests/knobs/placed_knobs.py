#!/usr/bin/env python3
"""As knobs.py, for the parameters of placed stones, plates and boxes, and for refusals and
warnings of such decks.

    placed_knobs.py PROGRAM DECK FOLDER
"""
import concurrent.futures
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, expect  # noqa: E402
from results import data  # noqa: E402

OTHER = "stone.odd.sides=[]"  # for a stone that is no longer a block
DRAWN = [OTHER, "stone.odd.shape=polyhedron", "stone.odd.size=0.012", "stone.odd.rounding=1e-3"]
HULL = [OTHER, "stone.odd.shape=hull",
        "stone.odd.corners=[0,0,0, 0.03,0,0, 0,0.02,0, 0,0,0.01]"]
CLUMP = [OTHER, "stone.odd.shape=clump",
         "stone.odd.spheres=[-0.005,0,0,0.006, 0.005,0,0,0.005]"]
LIBRARY = [OTHER, "stone.odd.shape=library", "stone.odd.file={folder}/one.h5",
           "stone.odd.size=0.012", "stone.odd.entry=stone_1"]
MESH = [OTHER, "stone.odd.shape=mesh", "stone.odd.file={folder}/one.obj", "stone.odd.unit=1e-3"]
TURNED = ["stone.odd.angle=30"]
SMALL = ["plate.floor.size=[0.2,0.02]", "plate.floor.edge=[1,0,0]"]
TILTED = ["box.walls.angle=10"]
BOX = ["bond.glue.low=[-0.01,0,0]", "bond.glue.high=[0,0.1,0.1]"]
WEAK = ["bond.glue.tension=2e4", "bond.glue.shear=2e4"]
DOMAIN = ["domain.low=[-1,-1,-1]", "domain.high=[1,1,1]"]
# Parameter of the schema -> (change, context).
KNOBS = {
    "domain.low": ("domain.low=[-1,-1,0.009]", DOMAIN),
    "domain.high": ("domain.high=[0.025,1,1]", DOMAIN),
    "stone.[].name": ("stone.odd.name=other", []),
    "stone.[].shape": ("stone.odd.shape=compound", DRAWN),
    "stone.[].radius": ("stone.ball.radius=0.009", []),
    "stone.[].sides": ("stone.odd.sides=[0.03,0.02,0.011]", []),
    "stone.[].corners": ("stone.odd.corners=[0,0,0, 0.03,0,0, 0,0.02,0, 0,0,0.012]", HULL),
    "stone.[].rounding": ("stone.odd.rounding=2e-3", []),
    "stone.[].spheres": ("stone.odd.spheres=[-0.005,0,0,0.006, 0.005,0,0,0.006]", CLUMP),
    **{f"stone.[].polyhedron.{name}": (f"stone.odd.polyhedron.{name}={value}", DRAWN) for
       name, value in {"vertices": 12, "elongation": 0.7, "flatness": 0.6, "spread": 0.2,
                       "angularity": 0.4, "rounding": 0.08}.items()},
    "stone.[].polyhedron.pieces": ("stone.odd.polyhedron.pieces=2",
                                   [*DRAWN, "stone.odd.shape=compound"]),
    "stone.[].polyhedron.spheres": ("stone.odd.polyhedron.spheres=[3,3]",
                                    [*DRAWN, "stone.odd.shape=clump"]),
    "stone.[].seed": ("stone.odd.seed=2", DRAWN),
    "stone.[].file": ("stone.odd.file={folder}/two.h5", LIBRARY),
    "stone.[].entry": ("stone.odd.entry=stone_2", LIBRARY),
    "stone.[].unit": ("stone.odd.unit=1.1e-3", MESH),
    "stone.[].size": ("stone.odd.size=0.013", DRAWN),
    "stone.[].material": ("stone.odd.material=wood", []),
    "stone.[].motion": ("stone.odd.motion=driven", ["stone.odd.velocity=[0,0,0.1]"]),
    "stone.[].position": ("stone.odd.position=[-0.02,0,0.016]", []),
    "stone.[].axis": ("stone.odd.axis=[1,1,0]", TURNED),
    "stone.[].angle": ("stone.odd.angle=30", []),
    "stone.[].velocity": ("stone.odd.velocity=[-0.5,0.3,-0.9]", []),
    "stone.[].spin": ("stone.odd.spin=[10,20,6]", []),
    "plate.[].name": ("plate.floor.name=ground", []),
    "plate.[].material": ("plate.floor.material=wood", []),
    "plate.[].centre": ("plate.floor.centre=[0,0,-1e-3]", []),
    "plate.[].normal": ("plate.floor.normal=[0.1,0,1]", []),
    "plate.[].size": ("plate.floor.size=[0.02,0.02]", []),
    "plate.[].edge": ("plate.floor.edge=[0,1,0]", SMALL),
    "plate.[].velocity": ("plate.floor.velocity=[0,0,0.1]", []),
    "box.[].name": ("box.walls.name=chest", []),
    "box.[].material": ("box.walls.material=wood", []),
    "box.[].low": ("box.walls.low=[-0.05,-0.035,-0.02]", []),
    "box.[].high": ("box.walls.high=[0.036,0.04,0.1]", []),
    "box.[].side": ("box.walls.side=outside", []),
    "box.[].axis": ("box.walls.axis=[0,0,1]", TILTED),
    "box.[].angle": ("box.walls.angle=10", []),
    "box.[].velocity": ("box.walls.velocity=[-0.2,0,0]", []),
    "bond.[].present": ("bond.glue.present=false", []),
    "bond.[].from": ("bond.glue.from=later", []),
    "bond.[].low": ("bond.glue.low=[-0.001,0,0]", BOX),
    "bond.[].high": ("bond.glue.high=[-0.005,0.1,0.1]", BOX),
    "bond.[].material": ("bond.glue.material=wood", []),
    "bond.[].gap": ("bond.glue.gap=5e-5", []),
    "bond.[].young": ("bond.glue.young=6e6", []),
    "bond.[].shear_ratio": ("bond.glue.shear_ratio=0.3", []),
    "bond.[].radius": ("bond.glue.radius=0.4", []),
    "bond.[].tension": ("bond.glue.tension=1e4", WEAK),
    "bond.[].shear": ("bond.glue.shear=1e4", WEAK),
    "bond.[].moment": ("bond.glue.moment=0.5", WEAK),
    "bond.[].softening": ("bond.glue.softening=2", WEAK),
    "bond.[].damping": ("bond.glue.damping=0.1", []),
}
# A stone that leaves the domain ends the run; one that starts within a box is refused.
ENDS = {"domain.low": 4, "domain.high": 4, "box.[].side": 2}
# Change of the deck -> part of the refusal.
REFUSED = {
    "stone.ball.shape=bal": "did you mean ball?",
    "stone.ball.radius=-1": "must be above 0 m",
    "stone.ball.material=stne": "did you mean stone?",
    "plate.floor.material=steel": "there are stone, wood",
    "stone.ball.nam=x": "did you mean stone[0].name?",
    "stone.odd.name=ball": "stones need different names",
    "stone.odd.name='a b'": "must be a word",
    "box.walls.name=floor": "is also the name of a [[plate]]",
    "stone.odd.sides=[0.03,0.02,0.001]": "must each be above 0.002 m, twice the rounding",
    "stone.odd.shape=hull": "must list x, y, z of at least four corners",
    f"{OTHER} stone.odd.shape=hull stone.odd.corners=[0,0,0,1,0,0,0,1,0,1,1,0]":
        "stone[1].corners: they enclose no volume",
    "stone.odd.shape=clump stone.odd.spheres=[0,0,0,0]": "a radius above 0",
    "stone.odd.shape=polyhedron": "must be above 0 m for a randomly generated stone",
    "stone.odd.size=1": "is only for generated stones, libraries and meshes",
    "stone.odd.shape=mesh": "must name a mesh",
    "stone.odd.shape=mesh stone.odd.file={folder}/none.obj": "does not exist",
    f"{OTHER} stone.odd.shape=library stone.odd.file={{folder}}/one.obj":
        "is not a library of shapes",
    f"{' '.join(LIBRARY)} stone.odd.entry=stone_11": "did you mean stone_1?",
    "stone.odd.motion=fixed": "needs velocity and spin of zero; use driven",
    "stone.odd.axis=[0,0,0]": "must not be zero",
    "stone.odd.position=[0,0,0.02]":
        "placed.toml:44: stone[0].position: stone \"ball\" initially overlaps stone \"odd\" by "
        "0.003789 m",
    "stone.odd.position=[0.02,0,0.012]": "times the smaller radius",
    "stone.odd.position=[-0.03,0,0]": "initially overlaps surface \"floor\" by",
    "domain.low=[0,0,0] domain.high=[1,1,1]": "is outside of the domain ([0, 0, 0] to [1, 1, 1]",
    "domain.low=[0,0,0]": "must both be three numbers",
    "domain.low=[1,1,1] domain.high=[0,0,0]": "must be above `low`",
    "plate.floor.normal=[0,0,0]": "must not be zero",
    "plate.floor.edge=[0,0,1]": "must not be along the normal",
    "box.walls.low=[1,1,1]": "must be above `low` in x, y and z",
    "contact.1.first=wood": "given twice",
    "stage.fall.kind=fill": 'must be "run" or "settle"',
    "stage.fall.ground_moves=true": "there is no ground",
    "stone.odd.motion=driven stone.ball.motion=driven stone.left.motion=driven "
    "stone.right.motion=driven": "no stone is free",
    "time.step=1": "is above the stable sub-step",
    "dimension=plane": "gives three-dimensional stones: a plane model allows ball, and clump",
    "bond.glue.low=[0,0,0]": "needs both corners of the box, low and high",
    "bond.glue.low=[0,0,0] bond.glue.high=[1,-1,1]": "must be above `low` along y",
    "bond.glue.from=fill": "there is no stage \"fill\"",
    "bond.glue.material=woood": "did you mean wood?",
    "bond.glue.young=0": "must be above 0 Pa",
    "breakage.wear.coefficient=1 breakage.material=stone": "is not possible with stones that break",
    "bed.height=0.3": "bed",
    "model=bed": "is only for model = \"stones\"",
}
WEARS = "bond.glue.present=false breakage.material=stone breakage.wear.coefficient=1"
# Change of the deck -> part of the warning.
WARNED = {
    f"{WEARS} breakage.seed=3": "breakage.seed = 3: has no effect: wear has no strengths",
    f"{WEARS} breakage.weibull=5": "no pebbles break off, and the parameters of pebbles",
    f"{WEARS} breakage.cutting.weibull=5": "no corner is cut, and the other parameters",
    f"{WEARS} breakage.splitting.weibull=5": "no stone splits, and the other parameters",
    "bond.glue.present=false breakage.material=stone breakage.strength=1e6 breakage.check_steps=5 "
    "stone.odd.sides=[] stone.odd.shape=clump "
    "stone.odd.spheres=[-0.005,0,0,0.006,0.005,0,0,0.005]":
        "breakage.check_steps = 5: has no effect: only splitting",
    "stone.ball.position=[0.02,0,9.5e-3]": "initially overlaps surface \"floor\" by 0.0005 m",
    "stage.fall.lift=0.5": "has no effect: it is for stages of kind release",
}


def cuboid(x, y, z):
    """A mesh in mm, as Wavefront OBJ."""
    corners = [(i * x, j * y, k * z) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    faces = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
    return "".join([f"v {a} {b} {c}\n" for a, b, c in corners]
                   + [f"f {a} {b} {c}\nf {a} {c} {d}\n" for a, b, c, d in faces])


class Bench:
    def __init__(self, program, deck, folder):
        self.program, self.deck, self.folder = program, deck, folder

    def changes(self, words):
        return [word.replace("{folder}", str(self.folder)) for word in words]

    def seen(self, overrides, place):
        ran = self.program(1, "run", self.deck, *self.changes(overrides), "-o", self.folder / place)
        results = self.folder / place / "results.h5"
        found = (ran.returncode, data(results) if results.exists() else None)
        shutil.rmtree(self.folder / place, ignore_errors=True)
        return found, ran.stderr

    def knob(self, name, before):
        change, around = KNOBS[name]
        after, stderr = self.seen([*around, change], f"after_{name.replace('[]', '')}")
        if after[0] != ENDS.get(name, 0):
            return f"{name}: ends with {after[0]}: {stderr}"
        return f"{name}: {change} changes nothing" if before[tuple(around)] == after else None

    def refused(self, changes):
        place = self.folder / f"refused_{abs(hash(changes))}"
        ran = self.program(1, "run", self.deck, *self.changes(changes.split()), "-o", place)
        if ran.returncode != 2 or REFUSED[changes] not in ran.stderr or place.exists():
            return f"{changes}: code {ran.returncode}, without \"{REFUSED[changes]}\": {ran.stderr}"
        return None

    def warned(self, changes):
        ran = self.program(1, "check", self.deck, *changes.split())
        if ran.returncode != 0 or WARNED[changes] not in ran.stdout:
            return f"{changes}: no warning \"{WARNED[changes]}\": {ran.stdout}{ran.stderr}"
        return None


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "one.obj").write_text(cuboid(20, 12, 10), encoding="utf-8")
    for name, flatness in (("one", 0.9), ("two", 0.6)):
        program.done(1, "shapes", "--stones", 3, "--flatness", flatness, "--library",
                     folder / f"{name}.h5")
    bench = Bench(program, deck, folder)
    tried = part(KNOBS)
    surroundings = sorted({tuple(KNOBS[name][1]) for name in tried})
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        bases = list(pool.map(lambda k: bench.seen(surroundings[k], f"base_{k}"),
                              range(len(surroundings))))
        before = {around: found for around, (found, _) in zip(surroundings, bases)}
        problems = [f"{around}: the base ends with {found[0]}: {stderr}" for around, (found, stderr)
                    in zip(surroundings, bases) if found[0] != 0]
        for judge, cases in ((lambda name: bench.knob(name, before), tried),
                             (bench.refused, part(REFUSED)), (bench.warned, part(WARNED))):
            problems += filter(None, pool.map(judge, cases))
    ran = program.done(1, "check", deck)
    expect("warning" not in ran.stdout, "a valid deck has a warning", ran)
    if problems:
        raise SystemExit("\n".join(problems))


if __name__ == "__main__":
    main()
