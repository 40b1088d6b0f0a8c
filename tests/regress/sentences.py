#!/usr/bin/env python3
"""Invalid input: all problems at once, one message each with file and line, exit code 2; and the
warnings of a run.

    sentences.py PROGRAM DECK FOLDER
"""
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from part import part  # noqa: E402
from program import Program, expect, summary  # noqa: E402

INPUTS = HERE.parents[1] / "inputs"
PROBLEMS = HERE / "problems.toml"
# Texts that the message of each problem must contain besides file and line.
WANTED = {"window = 0.5": ["time.window", "unstable"],
          "k_n = -2e7": ["k_n", "-2", "above 0"],
          "safty = 0.2": ["safty", "safety"],
          'height = "high"': ["bed.height", "number"],
          'file = "no_such_table.csv"': ["load.file", "no_such_table.csv", "exist"]}

# Values that are in range but implausible together: line of the tiny deck -> (its replacement,
# texts of the message). All are in one deck.
NONSENSE = {'second = "sleeper"': ('second = "sleper"', ["contact[1].second", "sleeper?"]),
            "sieve = [50, 63]": ("sieve = [0.05, 0.063]", ["bed.sieve", "looks like metres", "63"]),
            "spacing = 0.6": ('material = "slepper"', ["sleepers.material", "sleeper?"]),
            "start = -1.0": ("start = 9.0", ["load.start", "no axle passes", "start before"]),
            "outline = [0.0, 0.0, 0.5, 0.0, 0.5, -0.6, 0.0, -0.6]":
                ("outline = [5.0, 0.0, 6.0, 0.0, 6.0, -0.6]", ["ground.block[0].outline",
                                                               "any element", "x = 0 to 1.2 m"])}
YIELDS = "ground.layer.soil.yield=mohr_coulomb ground.plane=strain"
# Single changes of the tiny deck and a part of the refusal or warning.
TRAIN = "stage.passage.train=true train.start=0"
TAMP = "stage.passage.kind=tamp stage.passage.duration=0"
JUMP = ("stage.passage.kind=jump stage.passage.cycles=9 stage.passage.load=2e3 jump.from=load "
        "jump.cycles=4 stage.load.settlement=0 stage.passage.duration=0.2")
REFUSED = {"bed.material=ballst": "did you mean ballast?",
           "stage.compact.stiffness=0.1": "must be 1: softer contacts are for stages of kind fill",
           "stage.cribs.stiffness=0.1": "must be 1: softer contacts are for stages of kind fill",
           "wall_material=wood": "there are ballast, sleeper",
           "ground_material=wood": "there are ballast, sleeper",
           "contact.1.first=sleeper": "no [[contact]] gives a law",
           "contact.1.second=ballast": "given twice",
           "contact.1.law=hertz": "young above 0",
           "material.1.name=ballast": "earlier [[material]]",
           "ground.block.0.outline=[0,0.5, 0.5,0.5, 0.5,-0.6, 0,-0.6]": "above the ground",
           "ground.block.0.outline=[0.001,0, 0.002,0, 0.002,-0.6]": "any element",
           "ground.block.0.outline=[0,0, 0.5,-0.6, 0.5,0, 0,-0.6]": "crosses itself",
           "bed.grading=china_first": "bed.sieve = [50, 63]: differs from the sieves of the",
           "bed.container=cylinder": 'a cylinder needs dimension = "space"',
           f"{TRAIN} ballast.mass=500 track.zone=[{{{{from=0,to=11.9,bed=0.0}}}}]":
               "track.zone[0].bed = 0.0: must be above 0 with a mass of the ballast",
           f"{TRAIN} ballast.mass=500 track.zone=[{{{{from=13,to=60,bed=0.0}}}}]":
               "track.zone[0].bed = 0.0: must be above 0 with a mass of the ballast",
           "bed.split=0.3": "is not within the bed (bed.height = 0.2 m)",
           "bed.split=0.1": "needs a floor that moves with the lower half of the walls",
           "bed.beside=0.1": "needs a floor instead of a ground",
           "stage.passage.kind=shear": "needs divided walls: give bed.split",
           "stage.passage.kind=lift_walls": "needs floor around the walls: give bed.beside",
           "stage.load.displacement=0.1": "is for stages of kind shear and triaxial only",
           "stage.load.confinement=1e3": "is for stages of kind compact and triaxial only",
           'stage.compact.confinement=1e3 periodic=["x"]': "needs walls, but all sides are",
           "stage.passage.kind=triaxial":
               "needs the platen: the preceding stage must be of kind compact",
           "stage.release.kind=triaxial stage.release.displacement=0.01":
               "must be above 0 Pa for a stage of kind triaxial",
           "stage.release.kind=triaxial stage.release.displacement=0.3":
               "must be below the height of the bed (0.2 m)",
           "stage.load.pressure=1e3": "is for stages of kind compact and shear only",
           "platen.vibration=1e-3": "must be at least a period of the vibration (0.0333 s)",
           "ground.base_motion={deck} ground.base_stiffness=1e6":
               "must be 0 or left out with base_motion: springs would oppose",
           "ground.base=fixed ground.base_motion={deck}": "needs base = \"viscous\"",
           "ground.integrator=hht ground.alpha=-0.5": "must be at least -1/3 for hht",
           "ground.layer.soil.yield=mohr_coulomb": 'must be "strain" with layers that yield',
           f"{YIELDS} ground.sides=free_field": "has elastic columns beside the model",
           f"{YIELDS} ground.layer.soil.dilation_angle=31":
               "must be at most friction_angle (30 degrees), or yielding",
           f"{YIELDS} ground.layer.soil.tensile_strength=2e4":
               "must be at most cohesion / tan(friction_angle) = 17320.5 Pa",
           f"{YIELDS} ground.layer.soil.cohesion=0 ground.layer.soil.friction_angle=0":
               "must be above 0 if cohesion is 0: otherwise the solid has no shear strength",
           "bed.seed=-1": "must be at least 0",
           "stage.fill.cycles=1000000000": "stage[0].cycles = 1000000000 must be at least 0 and",
           "stage.fill.cycles=3": "for stages of kind load, passage, tamp and jump only",
           "stage.load.cycles=1000000": "does not resolve; give fewer",
           "stage.passage.cycles=1000000000": "at most",
           "ground.x=[0.1,1.2]": "beside the ground",
           "bed.stone=polyhedra": "bed.stone = \"polyhedra\": gives three-dimensional stones",
           "dimension=space": 'bed.stone = "pebbles" (default): gives plane stones',
           "bed.crest=[-0.1,0.1]": "has no meaning in a plane model, which has no width",
           "stage.fill.layer=sand": 'there is no [[bed.layer]] "sand"; the deck has none',
           "stage.load.layer=sand": "is for stages of kind fill only",
           "stage.passage.rail=kept": "has an effect only with train = true",
           "stage.passage.rail=kept stage.passage.train=true train.start=0 seat.before=10":
               'must be "laid": no stage with train = true comes before this one',
           'output.fields=true output.fields_stages=["laod"]':
               '"laod" is none of the stages: fill,',
           "stage.fill.profile=0.3": "has no effect while stones still fall",
           "sleepers.first=7": "puts the first sleeper outside the bed (bed.x: 0 to 1.2 m)",
           "stage.fill.name=a/b": 'stage[0].name = "a/b": must be a word of letters',
           "stage.fill.name=": "must be a word of letters",
           "stage.passage.cycles=3": "no axle passes a sleeper: the first axle moves from x = -1",
           "stage.cribs.profile=400": "is far above the bed, which is 0.2 m high",
           "stage.sleepers.height=350": "is far above the bed, which is 0.2 m high",
           "bed.sieve=[50000,63000]":
               "bed.x: the bed is 1.2 m long in this direction, less than the diameter of the "
               "bounding",
           "stage.compact.kind=release": "no stage of kind compact comes before it",
           "stage.cribs.kind=sleepers": 'places sleepers, which stage "sleepers" has already',
           "stage.cribs.kind=fill": 'pours stones onto sleepers, which stage "sleepers" has placed',
           "region.below.z=[1,2]": "region[0].z = [1, 2]: is below or above the bed",
           "sleepers.count=4": "puts the last sleeper at x = 2.1 m",
           "sleepers.count=0": "must be at least 1",
           "stage.passage.duration=0.001": "give more time",
           "ground.elements_x=100000 ground.elements_z=100000": "at most 1e+08 are supported",
           "ground.ratio_x=1.1 ground.fine_x=-5": "fine_x = -5: must be within the ground",
           "stage.fill.growth=20": "is longer than the stage",
           "stage.fill.growth=1e-6": "so that stones would overlap deeply; give at least",
           "stage.sleepers.kind=run": "no stage of kind sleepers",
           "region.below.x=[3,4]": "is beside the bed (bed.x: 0 to 1.2 m)",
           "seat.rails=0.5": "seat: has no effect: no stage has train = true",
           "footing.count=3": "footing: has no effect: it is for model = \"track_on_ground\";",
           "stage.load.train=true": "is for stages of kind passage only",
           TRAIN.replace("start=0", "start=1"):
               "train.start = 1: must be given and be at most 0 m on a bed",
           f"{TRAIN} stage.passage.duration=0 train.times=[60] train.speeds=[0] train.speed=1":
               "must be above 0 s: the train stops with its first axle at 30 m from the",
           f"{TRAIN} seat.before=5": "at 3 m from the start of the track, within its run-in of 6 m",
           f"{TRAIN} track.spacing=0.5": "(sleepers.spacing = 0.6 m)",
           "stage.passage.train=true": "train.start: must be given and be at most 0 m on a bed",
           f"{TRAIN} track.length=18": "must be at least 18.6 m: 12.6 m up to the last sleeper",
           f"{TRAIN} track.support=continuous": 'must be "sleepers", since the bed has',
           f"{TRAIN} handover.after=lode": "there is no stage \"lode\"",
           "handover.after=load": "needs a stage with train = true",
           f"{TRAIN} handover.after=load irregularity.kind=vee": 'must be "none" in a deck with',
           f"{TRAIN} track.dimension=space": 'must be "plane" in a plane model, whose',
           f"{TRAIN} pad.uplift=true": "pad.uplift = true: must be false on a bed",
           f"{TRAIN} under_sleeper_pad.stiffness=8e7":
               "under_sleeper_pad.stiffness = 80000000.0: must be 0 on a bed, where the contact",
           f"{TRAIN} passage.loaded_by=seats": 'must be "train" in a model with a bed',
           f"{TRAIN} track.sleeper.model=beam": 'must be "rigid" on a bed, whose sleepers',
           f"{TRAIN} stage.passage.cycles=2":
               "each train starts when the last axle of the train before has left",
           f"{TRAIN} train.vehicles=[\"manchester\"]": "did you mean manchester_1?",
           f"{JUMP} stage.passage.cycles=0": "must be at least 1: the cycles that a jump",
           f"{JUMP} stage.passage.load=0": "must be above 0 N: the load of the cycles of a jump",
           f"{JUMP} jump.period=1e-6": "is less than 4 time windows of about",
           f"{JUMP} stage.passage.seat_force=9e3": "elastic deflection would count as settlement",
           f"{JUMP} stage.passage.load=3e3": "must be that of the cycles before, 2000 N",
           f"{JUMP} stage.passage.friction=0.1": "must be -1 for a jump, in which the friction",
           f"{JUMP} stage.passage.duration=0.05": "is less than a cycle of the jump",
           f"{JUMP} stage.passage.settlement=1e-4": "is for stages of kind load and passage",
           f"{JUMP} jump.from=lode": "there is no stage \"lode\"",
           f"{JUMP} jump.from=passage": "jumps over cycles that are not counted yet (jump.from)",
           f"{JUMP} jump.cycles=9": "needs a stage of more than 9 cycles before it (jump.cycles)",
           f"{JUMP} stage.load.settlement=1e-4": "must not follow a stage that may end early",
           f"{JUMP} stage.load.kind=run stage.load.cycles=0 stage.load.load=0":
               "jumps over cycles, but the stage before is not of kind load or passage",
           f"{JUMP} bond=[{{{{name=\"a\"}}}}]": "is not possible with breakage or bonds",
           "tamping.lift=0.01": "has no effect: no stage is of kind tamp",
           f"{TAMP} tamping.closing=0.09": "tines would hit the sleeper",
           f"{TAMP} tamping.gap=0.15": "more than the space between sleepers (0.31 m)",
           f"{TAMP} bed.x=[0.1,1.2]": "reach from x = 0.03 to 1.17 m, beyond the ends",
           f"{TAMP} stage.sleepers.height=0.1 tamping.lift=0.01":
               "puts the tips of the tines below the",
           "stage.passage.kind=tamp stage.passage.duration=1": "times are those of [tamping]",
           'periodic=["x"] region.below.x=[0,100]': "over more than 10 periods of the bed along x",
           "region.below.z=[0.1,0.1]": "must be two increasing numbers",
           "region.below.cells=[1.5,1,1]": "must be whole numbers",
           "region.below.cells=[1000,1,11]": "must be at most 10000 cells in total",
           "region.below.name=a/b": "must be a word of letters"}
WARNED = {"stage.passage.ground_moves=false":
              "holds the ground, which moves in a stage before: it keeps its deformation",
          "stage.load.settlement=0.2": "usual values (at most 0.002 m)",
          f"{TRAIN} train.speed=120": "usual values (1 to 100 m/s)",
          "stage.load.ground_moves=false":
              "begins in equilibrium with a mean load of the bed that still contains 0.52 kN",
          f"{TRAIN} stage.load.load=20e3": "less than 0.6 times the largest static load",
          f"{TRAIN} stage.load.load=4e6": "more than 5 times the largest static load",
          f"{TRAIN} output.fields=true output.fields_interval=60":
              "hardly any file shows the train",
          f"{TRAIN} stage.load.load=4e3": "loads each sleeper by 4 kN together with seat_force",
          f"{TRAIN} bed.x=[0,2.4] ground.x=[0,2.4]":
              "leaves 1.5 m of the bed (x = 0 to 2.4 m) behind the last sleeper bare",
          f"{TRAIN} stage.load.kind=settle stage.load.cycles=0 stage.load.load=0 "
          "stage.load.settlement=0": "no stage of kind load loads the sleepers downwards",
          f"{TRAIN} stage.passage.duration=0.4 train.speed=30":
              "ends the stage before the train has left the bed",
          f"{TRAIN} stage.passage.ground_moves=false stage.load.ground_moves=false":
              "is false in every stage: the ground stays rigid",
          f"{TRAIN} stage.passage.local_damping=0.8": "is large in a stage with a train",
          "stage.load.cycles=100": "gives cycles of 0.0024 s, in which inertia carries a part",
          'ground.block=[{name="first",outline=[0,0,0.3,0,0.3,-0.3,0,-0.3],young=1e9,poisson=0.2,'
          'density=2400},{name="second",outline=[0,0,0.6,0,0.6,-0.6,0,-0.6],young=1e9,'
          'poisson=0.2,density=2400}]': 'block "first" has no element: later blocks',
          "ground.layer.soil.young=200e3": "usual values",
          "ground.block.structure.young=9.9e12": "usual values",
          f"{TRAIN} pad.damping=25": "is small: usually at least 100 N s/m; is it meant in kN s/m?",
          f"{TRAIN} output.history_interval=0.05 train.speed=40":
              "lets the train move 2 m between two rows of the histories",
          "jump.cycles=9": "has no effect: no stage is of kind jump",
          "jump.exponent=0.2": "has no effect: no stage is of kind jump",
          "jump.period=0.2": "has no effect: no stage is of kind jump",
          "jump.least_friction=0.2": "has no effect: no stage is of kind jump",
          "ground.layer.soil.young=5": "usual values (500000 to 3e+11 Pa)",
          "material.0.density=2.65": "is its unit right?",
          "load.peak=60e6": "usual values (1000 to 1e+06 N)",
          "sleepers.height=450": "usual values (at most 1 m)",
          "ground.base_stiffness=0": "under any load the ground sinks without end",
          "ground.sides=free_field": "acts as a viscous side",
          "ground.rayleigh_stiffness=0": "is below 9.9e-07 s (estimate): forces of the stones",
          "stage.load.seat_force=1e3": "of an earlier stage is removed in this stage",
          "sleepers.first=0.1": "reaches beyond the end",
          'periodic=["x"]': "past the periodic end of the bed",
          "handover.load=30": "usual values (100 to 1e+06 N)",
          "load.start=-0.5": "begins with a jump of 0.36 times the peak",
          "load.start=0.5": "beyond the first sleeper, which is therefore loaded suddenly",
          "ground.block.0.outline=[-1,0, 0.5,0, 0.5,-0.6, -1,-0.6]": "is cut",
          "output.history_interval=1e-9": "output.history_interval = 1e-09: is less than a time",
          "output.checkpoint_interval=1e-9": "less than a time window",
          "output.fields_interval=1e-9": "less than a time window",
          "sleepers.material=ballast": "is the name of a material that no part",
          "load.speed=100": "usual values (0.1 to 98 m/s)",
          "stage.load.load=2": "is negligible for a rail seat (below 100 N); is it in N?",
          "ground.base_stiffness=40": "is it in Pa/m?",
          "ground.rayleigh_mass=1e9": "usual values (at most 100 1/s)",
          "ground.layer.soil.cohesion=5e3": 'must be "mohr_coulomb" for cohesion, angles',
          "ground.rayleigh_stiffness=0.05": "usual values (at most 0.01 s); is its unit right?",
          "ground.layer.soil.rayleigh_stiffness=0.05":
              "ground.layer[0].rayleigh_stiffness = 0.05 is outside the usual values (at most",
          f"{YIELDS} ground.layer.soil.cohesion=20": "usual values (100 to 1e+07 Pa)",
          f"{YIELDS} ground.layer.soil.tensile_strength=5": "usual values (100 to 1e+07 Pa)",
          f"{YIELDS} ground.layer.soil.friction_angle=0.5": "usual values (at least 5 degrees)",
          f"{YIELDS} ground.layer.soil.dilation_angle=0.1": "usual values (at least 1 degrees)",
          f"{YIELDS} ground.layer.soil.cohesion=0":
              "where the top is not loaded, the ground would have no",
          "ground.layer.soil.elements=2": "elements_z = 8: has no effect",
          "ground.fine_y=0.1": "has no effect: all elements are equal",
          "ground.alpha=-0.2":
              'ground.alpha = -0.2: has no effect: it is for integrator = "hht" and "bossak"',
          "ground.integrator=hht ground.rho_inf=0.5":
              'has no effect: it is for integrator = "generalized_alpha"',
          "ground.integrator=bossak ground.newmark_beta=0.3":
              'ground.newmark_beta = 0.3: has no effect: it is for integrator = "newmark"',
          "ground.newmark_beta=0.4 ground.newmark_gamma=0.6":
              'ground.newmark_gamma = 0.6: has no effect: it is for integrator = "newmark"',
          "ground.integrator=newmark ground.safety=0.5":
              'has no effect: it is for integrator = "explicit"',
          "output.ground_extremes=true": "has no effect without fields = true",
          'output.fields_stages=["load"]': "has no effect without fields = true",
          "time.step=1e-9": "less than a thousandth of the stable step",
          "stage.sleepers.height=0.15 stage.sleepers.profile=0.1 stage.cribs.kind=run "
          "stage.cribs.profile=0":
              "is below the lower faces of the sleepers",
          "stage.sleepers.height=0.15 stage.sleepers.profile=0.16 stage.cribs.kind=run "
          "stage.cribs.profile=0":
              "is hardly above the lower faces of the sleepers (height = 0.15 m)",
          "stage.load.load=-5e3": "lifts the sleepers: forces are positive downwards",
          "stage.load.seat_force=-5e3": "lifts the sleepers: forces are positive downwards",
          f"{TRAIN}": "load: has no effect: no stage of kind passage is without a train",
          f"{TRAIN} ballast.damping=60":
              "ballast.damping = 60: is small: usually at least 100 N s/m",
          "ground.rayleigh_mass=0.04": "0.00032 at f = 10 Hz; is it meant as a ratio?",
          "ground.block.0.outline=[0,0, 0.5,0, 0.5,-0.56, 0,-0.56]":
              "has a side at z = -0.56 m, inside an element",
          "stage.passage.friction=0": "stones without friction do not carry sleepers",
          "contact.0.friction=0": "stones without friction do not carry sleepers",
          "material.ballast.density=1600": "is it the bulk density of the ballast?",
          "dem.gravity=0": "is not that of the earth, 9.81 m/s2",
          'sleepers.free=["x"]': "their loads do not reach the bed",
          "stage.sleepers.height=0.25": "puts the sleepers above the bed",
          "region.below.x=[-0.5,0.5]": "reaches beyond the bed: the volume",
          "stage.load.growth=0.01": "has no effect: it is for stages of kind fill",
          "stage.fill.growth_height=1.2": "has no effect: the stage has no growth",
          "stage.fill.lift=0.3":
              "stage[0].lift = 0.3: has no effect: it is for stages of kind release",
          "settle_average=5": "is a time constant of which at least three must pass",
          "time.window=1e-4 time.substeps=3": "has no effect: time.window is given",
          "time.window=1e-5 time.step=2e-5": "is longer than the window",
          f"{TRAIN} seat.rails=0.2": "check the number of rails",
          f"{TRAIN} track.zone=[{{from=0,to=60,bed=2}}]":
              "track.zone[0].from = 0: begins a zone that contains 2 sleepers of the bed: these",
          f"{TRAIN} track.zone=[{{from=12.1,to=13,sleeper=2}}]":
              "track.zone[0].from = 12.1: begins a zone that contains 1 sleeper of the bed: this",
          f"{TRAIN} track.zone=[{{from=12.1,to=13,bed=0.5}}]":
              "track.zone[0].from = 12.1: begins a zone that contains 1 sleeper of the bed: this",
          f"{TRAIN} ballast.mass=500 track.zone=[{{from=12.1,to=13,bed=0.0}}]":
              "track.zone[0].from = 12.1: begins a zone that contains 1 sleeper of the bed: this",
          f"{TRAIN} stage.passage.duration=0.2 train.speed=10":
              "ends the stage before the train is on the bed: the first axle reaches 2 m from",
          f"{TRAIN} passage.points=[1]": "has no effect on a bed: the histories contain the rail",
          f"{TRAIN} passage.duration=1": "has no effect on a bed: use the duration",
          "stage.fill.stiffness=0.1 time.step=1e-5": "makes no sub-step longer",
          "dem.gravity=9810": "usual values (at most 100 m/s2)",
          "contact.0.friction=60": "usual values (at most 2)",
          "stage.sleepers.height=0.01": "less than the size of the largest stone (0.063 m)"}
# What must not be reported of zones: beside the bed's sleepers, or of the rail alone.
SILENT = [f"{TRAIN} track.zone=[{{from=0,to=11.9,gap=2e-3}},{{from=13,to=60,bed=0.5}}]",
          f"{TRAIN} track.zone=[{{from=0,to=60,rail=2}}]",
          f"{TRAIN} track.zone=[{{from=11.9,to=13,gap=2e-3}}]"]
# One error gives one message, without messages on its consequences.
SINGLE = ["bed.x=[1.2,0]", "ground.x=[0,0]", "time.window=1", "stage.sleepers.kind=settle"]
COMMANDS = "(commands: run, resume, check, describe, schema, info, shapes, kernel)"


def check_problems(program, ranks):
    ran = program(ranks, "run", PROBLEMS, "-o", "nowhere")
    expect(ran.returncode == 2, "bad input must end with 2", ran)
    lines = PROBLEMS.read_text(encoding="utf-8").splitlines()
    for text, words in WANTED.items():
        start = f"problems.toml:{lines.index(text) + 1}:"
        sentences = [line for line in ran.stderr.splitlines() if start in line]
        expect(len(sentences) == 1, f"one message on line {start} is required", ran)
        for word in words:
            expect(word in sentences[0], f"the message on {start} must contain {word}", ran)
    expect(not pathlib.Path("nowhere").exists(), "an invalid deck must not leave files", ran)


def check_nonsense(program, deck, folder):
    """All implausible values at once; single ones; and unusual values with a warning."""
    text = pathlib.Path(deck).read_text(encoding="utf-8")
    for line, (other, _) in NONSENSE.items():
        if text.count(f"\n{line}\n") != 1:
            raise SystemExit(f"{deck} must contain the line {line} once")
        text = text.replace(f"\n{line}\n", f"\n{other}\n")
    path = folder / "nonsense.toml"
    path.write_text(text, encoding="utf-8")
    ran = program(1, "check", path)
    expect(ran.returncode == 2, "implausible values must end with 2", ran)
    sentences = ran.stderr.splitlines()
    expect(len(sentences) == len(NONSENSE), "one message for each is required", ran)
    for other, words in NONSENSE.values():
        start = f"nonsense.toml:{text.splitlines().index(other) + 1}: "
        found = [sentence for sentence in sentences if start in sentence]
        expect(len(found) == 1 and all(word in found[0] for word in words),
               f"the message on {start} must contain {words}", ran)
    for change, words in part(REFUSED.items()):
        ran = program(1, "check", deck, *re.split(r" (?=[a-z])", change.format(deck=deck)))
        expect(ran.returncode == 2, f"{change} must be refused", ran)
        expect(words in ran.stderr, f"{change} must report {words}", ran)
    for change in part(SINGLE):
        ran = program(1, "check", deck, change)
        expect(ran.returncode == 2 and len(ran.stderr.splitlines()) == 1,
               f"{change} must give one message", ran)
    for change, words in part(WARNED.items()):
        ran = program(1, "check", deck, *re.split(r" (?=[a-z])", change))
        expect(ran.returncode == 0, f"{change} must not be an error", ran)
        expect(any(line.startswith("warning: ") and words in line
                   for line in ran.stdout.splitlines()), f"{change} must warn: {words}", ran)
    for change in part(SILENT):
        ran = program.done(1, "check", deck, *re.split(r" (?=[a-z])", change))
        expect("of the bed: th" not in ran.stdout, f"{change} is sound", ran)


def check_profile(program, deck, folder):
    """Warnings on a file of the rail's profile are also given for a train on a bed."""
    table = folder / "profile.csv"
    words = [*TRAIN.split(), "irregularity.kind=file", f"irregularity.file={table.resolve()}"]
    for rows, fade, warnings in (("0,0.01\n60,0.01\n", 0, ["begins with a step of 10 mm"]),
                               ("0,0.01\n60,0.01\n", 10, []),
                               ("0,0\n30,0.4\n60,0\n", 10, ["are they given in mm instead of m?"])):
        table.write_text("x_m,z_m\n" + rows, encoding="utf-8")
        ran = program.done(1, "check", deck, *words, f"irregularity.fade={fade}")
        reported = [line for line in ran.stdout.splitlines()
                    if line.startswith("warning: irregularity.file: ")]
        expect(len(reported) == len(warnings) and all(map(str.__contains__, reported, warnings)),
               f"{rows} with fade = {fade}: {warnings} is required", ran)


def check_loads(program, deck, folder):
    """A table of loads that ends before the passage, with a load in the last row."""
    table = folder / "loads.csv"
    for rows, warned in (("0,0\n0.01,4e3\n0.02,4e3\n", True), ("0,0\n0.01,4e3\n0.02,0\n", False),
                       ("0,0\n0.01,4e3\n1,4e3\n", False)):
        table.write_text("time_s,force_N\n" + rows, encoding="utf-8")
        ran = program.done(1, "check", deck, "load.kind=table", f"load.file={table.resolve()}")
        words = ('stage "passage": the load of a sleeper drops from 4000 N (last row) '
                 'to 0')
        expect((words in ran.stdout) == warned, f"{rows}: warned or not", ran)


def check_single_cases(program, deck):
    cases = [(["run", "no_such_deck.toml"], 2, "no_such_deck.toml"),
             (["run", deck, "time.step=1.265e-4", "-o", "nowhere"], 2,
              "0.2 sqrt(m/k), where 0.2 is dem.safety, m = 7.994"),
             (["run", deck, "load.speeed=3"], 2, "speed"),
             (["describe", "grund"], 2, "ground"),
             (["resume", "no_such_checkpoint.h5"], 2, "does not exist"),
             (["resume", HERE], 2, "contains no checkpoint"),
             (["resume", PROBLEMS], 2, "not a trackbed checkpoint"),
             (["info", "no_such_file.h5"], 2, "does not exist"),
             (["fly"], 2, f'"fly" is not a command {COMMANDS}'),
             (["rnu", deck], 2, f'"rnu" is not a command {COMMANDS}; did you mean run?'),
             ([], 2, f"no command is given {COMMANDS}"), (["run"], 2, "deck"),
             (["--help"], 0, "resume"),
             (["--version"], 0, "trackbed"), (["check", deck], 0, "valid"),
             (["check", deck, "ground.integrator=newmark"], 0, "one implicit step per window"),
             (["check", deck], 0,
              "sleeper: mass 156 kg, n = 6 contacts with stones, k = 2e+07 N/m each"),
             (["check", deck, "load.axles=[]"], 2,
              'load.axles = []: must be given for the stage "passage" of kind passage'),
             (["check", INPUTS / "ground/sections.toml",
               "ground.block.abutment.outline=[0,0,0.01,0,0.01,-0.01,0,-0.01]"], 2,
              'sections.toml:103: ground.block[1] ("abutment"): its outline contains the centre'),
             (["check", INPUTS / "bench/spheres.toml", "bed.x=[0,60]"], 0,
              "stones: 3600103, not placed here since they are more than 2000000"),
             (["check", deck, "sleepers.count=1000000000"], 2, "at most 1000000"),
             (["check", INPUTS / "bed/platen.toml", "bed.y=[-0.3,1e6]"], 2,
              "platen.toml:28: bed has 2.82e+09 stones"),
             (["describe", "stage"], 0, "passage"), (["describe"], 0, "[[stage]]"),
             (["schema"], 0, "2020-12"),
             (["run", deck, "-o", "/proc/nowhere"], 2, "result folder"),
             (["run", deck, "-o", PROBLEMS], 2, "is not a folder")]
    for arguments, code, words in cases:
        ran = program(1, *arguments)
        expect(ran.returncode == code, f"{arguments} must end with {code}", ran)
        expect(words in ran.stdout + ran.stderr, f"{arguments} must report {words}", ran)
    expect(not pathlib.Path("nowhere").exists(), "an unstable step must not leave files", ran)


def check_library(program, deck, folder):
    """A file that is not a library of shapes is reported with the line of the deck."""
    for name, text in (("text.h5", "no shapes\n"), ("empty.h5", "")):
        (folder / name).write_text(text, encoding="utf-8")
        lines = pathlib.Path(deck).read_text(encoding="utf-8").replace(
            'dimension = "plane"', 'dimension = "space"').replace(
            "[bed]", f'[bed]\nstone = "library"\nlibrary = "{name}"').splitlines()
        (folder / "library.toml").write_text("\n".join(lines), encoding="utf-8")
        number = lines.index(f'library = "{name}"') + 1
        start = f"library.toml:{number}: bed.library = "
        for command in ("check", "run"):
            ran = subprocess.run([program.path, command, "library.toml"], cwd=folder, text=True,
                                 capture_output=True, timeout=60, check=False)
            expect(ran.returncode == 2, f"{command}: {name} is not a library", ran)
            expect(len(ran.stderr.splitlines()) == 1 and ran.stderr.startswith(start) and
                   f'{name}" is not a library of shapes (cannot be opened' in ran.stderr,
                   f"{command}: the sentence must begin with {start}", ran)


def falling_deck(deck, folder):
    """The deck up to its first stage, followed by stones in free fall under ten times gravity: some
    are fast on any bed."""
    path = folder / "falling.toml"
    text = pathlib.Path(deck).read_text(encoding="utf-8")
    fill = text[:text.index('[[stage]]\nname = "compact"')]
    path.write_text(fill + '[[stage]]\nname = "fall"\nkind = "run"\nduration = 0.03\n',
                    encoding="utf-8")
    return path, ("dem.gravity=100", "stage.fill.duration=1e-3", "dem.largest_overlap=3")


def check_warnings(program, deck, folder):
    """Warnings on a bed that differs from the prescribed one and on a failed track, on screen and
    in the summary, which are kept after a resume. A valid run has none."""
    falling, fast = falling_deck(deck, folder)
    # Sleepers placed 0.4 m above the bed fall on it.
    dropped = ("stage.sleepers.height=0.6", "stage.sleepers.duration=0.3",
               "stage.load.settlement=1")
    cases = [(deck, (), []),
             (deck, ("bed.porosity=0.1", "stage.release.lift=0.12"),
              ["stage compact: the compacted bed has"]),
             (deck, ("bed.porosity=0.6",), ["stage compact: the compacted bed has"]),
             (deck, ("stage.compact.duration=0.01",),
              ["without reaching its aim", "the compacted bed has"]),
             (deck, ("stage.fill.stiffness=0.01", "stage.fill.duration=0.2",
                     "dem.largest_overlap=9"),
              ["stage fill: contacts become 100 times as stiff at its end while they overlap"]),
             (deck, ("stage.release.lift=0.01",),
              ["without reaching its aim: the platen bears "]),
             (deck, ("dem.safety=0.4", "stage.release.lift=0.12"),
              ["the end of these stages allow: fill ("]),
             (falling, fast, ["faster than 3 m/s or above the walls at the end"]),
             (deck, dropped, ["ballast: the ballast below this sleeper has failed"])]
    for number, (of, changes, wanted) in enumerate(cases):
        place = folder / f"warnings_{number}"
        ran = program.done(1 + number % 2, "run", of, *changes, "-o", place)
        reported = [line[len("warning: "):] for line in ran.stdout.splitlines()
                    if line.startswith("warning: ")]
        expect(reported == summary(place)["warnings"],
               "the summary must contain the reported warnings", ran)
        of_deck = [text for text in reported if re.match(r"\S*\.toml:\d+: |command line: ", text)]
        expect(reported[:len(of_deck)] == of_deck, "warnings on the deck must come first", ran)
        reported = reported[len(of_deck):]
        expect(len(reported) == len(wanted) and all(map(str.__contains__, reported, wanted)),
               f"{changes} must give {wanted}", ran)
    program.done(1, "resume", place / "stage_load.h5", "--force")
    kept = summary(place)["warnings"]
    expect([text for text in kept if not text.startswith("input stored in ")] == reported,
           f"warnings must be kept after a resume, not {kept}", ran)
    place = folder / "odd"
    ran = program.done(2, "run", deck, "output.stop_after=2", "-o", place, code=3)
    for stop in (4, 6):
        kept = summary(place)["warnings"]
        expect(sum("load.start = -1.0: " in text for text in kept) == 1,
               f"warnings on a deck must be in its results, not {kept}", ran)
        ran = program.done(1, "resume", place, f"output.stop_after={stop}", code=3)


def check_beds(program):
    """In space: sleepers beside the bed; and compacted stones with corners, which gain energy with
    steps that are stable for one contact, while balls do not."""
    beds = INPUTS / "bed"
    ran = program(1, "check", beds / "section.toml", "sleepers.y=9")
    expect(ran.returncode == 2 and "puts the sleepers beside the bed" in ran.stderr,
           "sleepers beside the bed must be refused", ran)
    pressed = beds / "steady.toml"
    for change, warns in ((("dem.safety=0.3",), True), (("dem.safety=0.25",), False),
                          (("contact[0].zeta_n=0.4",), True),
                          (("dem.safety=0.5", "bed.stone=disk"), False)):
        ran = program.done(1, "check", pressed, "bed.x=[0, 0.25]", "bed.y=[0, 0.25]", *change)
        expect(("energy increased in tests with a safety" in ran.stdout) == warns,
               f"{change}: warned or not", ran)


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for ranks in (1, 2):
        check_problems(program, ranks)
    check_nonsense(program, deck, folder)
    check_profile(program, deck, folder)
    check_loads(program, deck, folder)
    check_single_cases(program, deck)
    check_beds(program)
    check_library(program, deck, folder)
    check_warnings(program, deck, folder)


if __name__ == "__main__":
    main()
