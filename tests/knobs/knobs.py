#!/usr/bin/env python3
"""Every parameter of the program has an effect: a change of it changes an observable result.

    knobs.py PROGRAM DECK FOLDER

Observable are stones, histories and snapshots, values of the summary, files, the report on screen
without times, the exit code and the message of a refusal. The deck stored in the results is
excluded, as it differs for any parameter. The list of parameters comes from the program's own
schema, so that a new parameter without an entry in KNOBS fails the test.
"""
import concurrent.futures
import json
import pathlib
import re
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import ground_knobs  # noqa: E402
import mesh_knobs  # noqa: E402
import placed_knobs  # noqa: E402
import pressure_knobs  # noqa: E402
import section_knobs  # noqa: E402
import solid_knobs  # noqa: E402
import track_knobs  # noqa: E402
from part import part  # noqa: E402
from program import Program  # noqa: E402
from results import data  # noqa: E402

# Contexts in which some parameters have an effect: overrides before and after the change.
SPACE = ["dimension=space", "bed.stone=disk", "sleepers.length=0.3"]
CLUMP = [*SPACE[:1], SPACE[2], "bed.stone=clump", "bed.clump=[-0.5,0,0,0.5, 0.5,0,0,0.4]"]
SOLID = [*SPACE[:1], SPACE[2], "bed.stone=polyhedra", "bed.height=0.06",
         "dem.largest_overlap=20"]
SLICED = [*SOLID, "bed.stone=compound"]
FILLED = [*SOLID, "bed.stone=clump", "bed.shapes=2"]
LIBRARY = [*SOLID, "bed.stone=library", "bed.library={folder}/round.h5"]
HERTZ = ["contact.0.law=hertz", "contact.1.law=hertz", "material.0.young=3e9",
         "material.1.young=3e9"]
NEWMARK = ["ground.integrator=newmark"]
POWER = ["load.kind=power"]
WHEEL = ["load.wheel_load=20e3"]
TABLE = ["load.kind=table", "load.file={folder}/weak.csv"]
SIDES = [*SPACE, "load.kind=seats", "load.file={folder}/sides.csv", "load.gauge=0.1",
         'sleepers.free=["z", "rx"]']
ROLLING = ["contact.0.rolling_friction=0.2"]
FIELDS = ["output.fields=true"]
YIELDS = {part: ["ground.plane=strain", f"ground.{part}.0.yield=mohr_coulomb",
                 f"ground.{part}.0.cohesion=2e3"] for part in ("layer", "block")}
BALL = ["region.0.kind=sphere"]
CUT = [*SPACE, "stage.sleepers.profile=0.1", "bed.crest=[-0.05, 0.05]"]
REPEATED = ['periodic=["x"]', "bed.x=[0.0, 0.6]", "ground.x=[0.0, 0.6]"]
TWO_TRAINS = ["stage.load.kind=passage", "stage.load.train=true", "stage.load.duration=0",
              "stage.passage.train=true", "train.start=0", "seat.before=10"]
ON_BED = ["stage.passage.train=true", "train.start=0", "seat.before=10"]
# Tines cause larger overlaps of stones than other stages.
TAMPED = ["stage.passage.kind=tamp", "stage.passage.duration=0", "dem.largest_overlap=1",
          *(f"tamping.{name}={value}" for name, value in
            {"gap": 0.07, "closing": 0.03, "thickness": 0.02, "depth": 0.06, "insertion": 0.01,
             "squeeze": 0.01, "withdrawal": 0.01}.items())]
JUMPED = ["stage.load.settlement=0", "stage.load.cycles=8", "stage.passage.kind=jump",
          "stage.passage.cycles=12", "stage.passage.duration=0.6", "stage.passage.load=2e3",
          "jump.from=load", "jump.cycles=4", "jump.period=0.02", "jump.exponent=1"]
BREAKS = [*SPACE[:1], SPACE[2], "bed.stone=clump",
          "bed.clump=[-0.5,0,0,0.5, 0.5,0,0,0.4, 0,0.4,0,0.3]", "breakage.strength=1e4",
          "breakage.threshold=1", "breakage.from=load", "breakage.least_size=0.005"]
CRUSHES = [*SPACE[:1], SPACE[2], "bed.stone=polyhedra", "dem.largest_overlap=2",
           "breakage.from=load", "breakage.least_size=0.02", "breakage.check_steps=5",
           "breakage.splitting.strength=2e4", "breakage.cutting.strength=1e6"]
WEARS = [*CRUSHES[:3], "dem.largest_overlap=2", "breakage.from=load", "breakage.least_size=0.005",
         "breakage.check_steps=5", "breakage.wear.coefficient=1", "breakage.wear.hardness=1e4"]
PRESSED = ["platen.speed=1", "stage.compact.duration=0.2"]

# Parameter of the schema -> (change, context). List elements are given by name or number.
KNOBS = {
    "title": ("title=Other", []),
    "dimension": ("dimension=space", SPACE[1:]),
    "thickness": ("thickness=0.9", []),
    "periodic": ('periodic=["x"]', []),
    "start": ("start={folder}/started_from/stage_compact.h5", []),
    "wall_material": ("wall_material=sleeper", ["contact.1.friction=0.1"]),
    "ground_material": ("ground_material=sleeper", ["contact.1.friction=0.1"]),
    "settle_average": ("settle_average=0.05", []),
    "material.[].name": ("material.0.name=granite", []),
    "material.[].density": ("material.0.density=2700", []),
    "material.[].local_damping": ("material.0.local_damping=0.3", []),
    "material.[].young": ("material.0.young=3.3e9", HERTZ),
    "material.[].poisson": ("material.0.poisson=0.4", HERTZ),
    "contact.[].first": ("contact.1.first=sleeper", []),
    "contact.[].second": ("contact.0.second=sleeper", []),
    "contact.[].law": ("contact.0.law=hertz", HERTZ[2:]),
    "contact.[].k_n": ("contact.0.k_n=9e6", []),
    "contact.[].k_s": ("contact.0.k_s=9e6", []),
    "contact.[].friction": ("contact.0.friction=0.3", []),
    "contact.[].zeta_n": ("contact.0.zeta_n=0.1", []),
    "contact.[].zeta_s": ("contact.0.zeta_s=0.1", []),
    "contact.[].restitution": ("contact.0.restitution=0.5", HERTZ),
    "contact.[].attraction": ("contact.0.attraction=true", []),
    "contact.[].rolling_friction": (ROLLING[0], []),
    "contact.[].rolling_stiffness": ("contact.0.rolling_stiffness=0.5", ROLLING),
    "contact.[].zeta_r": ("contact.0.zeta_r=0.5", ROLLING),
    "dem.safety": ("dem.safety=0.15", []),
    "dem.largest_overlap": ("dem.largest_overlap=1e-6", []),
    "dem.gravity": ("dem.gravity=9", []),
    "dem.energy_balance": ("dem.energy_balance=true", []),
    "jump.from": ("jump.from=passage", JUMPED),
    "jump.cycles": ("jump.cycles=3", JUMPED),
    "jump.exponent": ("jump.exponent=0", JUMPED),
    "jump.period": ("jump.period=0.03", JUMPED),
    "jump.least_friction": ("jump.least_friction=0.9", [*JUMPED, "stage.passage.cycles=2000"]),
    "bed.stone": ("bed.stone=disk", []),
    "bed.material": ("bed.material=sleeper", ["material.1.density=2000"]),
    "bed.x": ("bed.x=[0.0, 0.45]", []),
    "bed.y": ("bed.y=[-0.15, 0.1]", SPACE),
    "bed.crest": ("bed.crest=[-0.1, 0.1]", CUT),
    "bed.slope": ("bed.slope=3", CUT),
    "bed.layer.[].name": ("bed.layer.0.name=sand", ["stage.fill.layer=lower"]),
    "bed.height": ("bed.height=0.1", []),
    "bed.porosity": ("bed.porosity=0.5", []),
    "bed.container": ("bed.container=cylinder", []),
    "bed.split": ("bed.split=0.05", ["ground.present=false"]),
    "bed.beside": ("bed.beside=0.1", []),
    "bed.seed": ("bed.seed=2", []),
    "bed.grading": ("bed.grading=china_first", ["bed.pebble_radius=0.005"]),
    "bed.sieve": ("bed.sieve=[45, 63]", []),
    "bed.passing": ("bed.passing=[0, 50, 100]", ["bed.sieve=[45, 50, 63]",
                                                 "bed.passing=[0, 20, 100]"]),
    "bed.pebble_radius": ("bed.pebble_radius=0.015", []),
    "bed.pebble_spacing": ("bed.pebble_spacing=1.2", []),
    "bed.shapes": ("bed.shapes=4", []),
    "bed.elongation": ("bed.elongation=0.9", []),
    "bed.angularity": ("bed.angularity=0.6", []),
    "bed.clump": ("bed.clump=[-0.5,0,0,0.5, 0.5,0,0,0.5]", CLUMP),
    "bed.library": ("bed.library={folder}/flat.h5", LIBRARY),
    "bed.cell": ("bed.cell={folder}/cell/stage_fill.h5", REPEATED),
    "bed.polyhedron.vertices": ("bed.polyhedron.vertices=12", SOLID),
    "bed.polyhedron.elongation": ("bed.polyhedron.elongation=0.8", SOLID),
    "bed.polyhedron.flatness": ("bed.polyhedron.flatness=0.7", SOLID),
    "bed.polyhedron.spread": ("bed.polyhedron.spread=0.1", SOLID),
    "bed.polyhedron.angularity": ("bed.polyhedron.angularity=0.5", SOLID),
    "bed.polyhedron.rounding": ("bed.polyhedron.rounding=0.08", SOLID),
    "bed.polyhedron.pieces": ("bed.polyhedron.pieces=2", SLICED),
    "bed.polyhedron.spheres": ("bed.polyhedron.spheres=[3, 4]", FILLED),
    "breakage.strength": ("breakage.strength=2e4", BREAKS),
    "breakage.material": ("breakage.material=sleeper", BREAKS),
    "breakage.from": ("breakage.from=passage", BREAKS),
    "breakage.diameter": ("breakage.diameter=0.03", BREAKS),
    "breakage.size_exponent": ("breakage.size_exponent=-0.5", BREAKS),
    "breakage.weibull": ("breakage.weibull=6", BREAKS),
    "breakage.threshold": ("breakage.threshold=0.7", BREAKS),
    "breakage.birth_size": ("breakage.birth_size=0.4", BREAKS),
    "breakage.growth_steps": ("breakage.growth_steps=20", BREAKS),
    "breakage.growth_overlap": ("breakage.growth_overlap=1e-2", BREAKS),
    "breakage.least_size": ("breakage.least_size=0.012", BREAKS),
    "breakage.seed": ("breakage.seed=2", BREAKS),
    "breakage.check_steps": ("breakage.check_steps=7", CRUSHES),
    "breakage.splitting.strength": ("breakage.splitting.strength=4e4", CRUSHES),
    "breakage.splitting.diameter": ("breakage.splitting.diameter=0.03", CRUSHES),
    "breakage.splitting.weibull": ("breakage.splitting.weibull=6", CRUSHES),
    "breakage.cutting.strength": ("breakage.cutting.strength=2e6", CRUSHES),
    "breakage.cutting.weibull": ("breakage.cutting.weibull=6", CRUSHES),
    "breakage.cutting.least_depth": ("breakage.cutting.least_depth=0.02", CRUSHES),
    "breakage.cutting.largest_depth": ("breakage.cutting.largest_depth=0.02", CRUSHES),
    "breakage.wear.coefficient": ("breakage.wear.coefficient=0.5", WEARS),
    "breakage.wear.hardness": ("breakage.wear.hardness=2e4", WEARS),
    "breakage.wear.step": ("breakage.wear.step=1e-3", WEARS),
    "ground.present": ("ground.present=false", []),
    "ground.x": ("ground.x=[-0.1, 0.6]", []),
    "ground.y": ("ground.y=[-0.2, 0.2]", SPACE),
    "ground.elements_x": ("ground.elements_x=7", []),
    "ground.elements_y": ("ground.elements_y=3", SPACE),
    "ground.elements_z": ("ground.elements_z=5", []),
    "ground.ratio_x": ("ground.ratio_x=1.1", []),
    "ground.fine_x": ("ground.fine_x=0.3", ["ground.ratio_x=1.1"]),
    "ground.ratio_y": ("ground.ratio_y=1.2", [*SPACE, "ground.elements_y=3"]),
    "ground.fine_y": ("ground.fine_y=0.1", [*SPACE, "ground.elements_y=3", "ground.ratio_y=1.2"]),
    "ground.layer.[].elements": ("ground.layer.0.elements=3", []),
    "ground.layer.[].name": ("ground.layer.0.name=clay", ["ground.block.0.present=false"]),
    "ground.layer.[].thickness": ("ground.layer.0.thickness=0.5", []),
    "ground.layer.[].young": ("ground.layer.0.young=60e6", []),
    "ground.layer.[].poisson": ("ground.layer.0.poisson=0.2", []),
    "ground.layer.[].density": ("ground.layer.0.density=1800", []),
    "ground.block.[].name": ("ground.block.0.name=bridge", []),
    "ground.block.[].present": ("ground.block.0.present=false", []),
    "ground.block.[].outline": ("ground.block.0.outline=[0,0, 0.4,0, 0.4,-0.2, 0,-0.2]", []),
    "ground.block.[].y": ("ground.block.0.y=[-0.2, 0]", [*SPACE, "ground.elements_y=2"]),
    "ground.block.[].young": ("ground.block.0.young=200e6", []),
    "ground.block.[].poisson": ("ground.block.0.poisson=0.3", []),
    "ground.block.[].density": ("ground.block.0.density=2000", []),
    "ground.plane": ("ground.plane=strain", []),
    "ground.base": ("ground.base=fixed", []),
    "ground.base_stiffness": ("ground.base_stiffness=50e6", []),
    "ground.sides": ("ground.sides=viscous", []),
    "ground.side_x_low": ("ground.side_x_low=fixed", []),
    "ground.side_x_high": ("ground.side_x_high=viscous", []),
    "ground.side_y_low": ("ground.side_y_low=free", SPACE),
    "ground.side_y_high": ("ground.side_y_high=fixed", SPACE),
    "ground.rayleigh_mass": ("ground.rayleigh_mass=10", []),
    "ground.rayleigh_stiffness": ("ground.rayleigh_stiffness=2e-5", []),
    "ground.integrator": ("ground.integrator=newmark", []),
    "ground.safety": ("ground.safety=0.2", []),
    "ground.newmark_beta": ("ground.newmark_beta=0.3", NEWMARK),
    "ground.newmark_gamma": ("ground.newmark_gamma=0.6", [*NEWMARK, "ground.newmark_beta=0.3025"]),
    "ground.base_motion": ("ground.base_motion={folder}/wave.csv", []),
    "ground.layer.[].young_file": ("ground.layer.0.young_file={folder}/young.csv", []),
    "ground.layer.[].rayleigh_mass": ("ground.layer.0.rayleigh_mass=10", []),
    "ground.layer.[].rayleigh_stiffness": ("ground.layer.0.rayleigh_stiffness=2e-5", []),
    "ground.block.[].rayleigh_mass": ("ground.block.0.rayleigh_mass=10", []),
    "ground.block.[].rayleigh_stiffness": ("ground.block.0.rayleigh_stiffness=2e-5", []),
    "ground.layer.[].yield": (YIELDS["layer"][1], ["ground.plane=strain"]),
    "ground.layer.[].cohesion": ("ground.layer.0.cohesion=3e3", YIELDS["layer"]),
    "ground.layer.[].friction_angle": ("ground.layer.0.friction_angle=25", YIELDS["layer"]),
    "ground.layer.[].dilation_angle": ("ground.layer.0.dilation_angle=10", YIELDS["layer"]),
    "ground.layer.[].tensile_strength": ("ground.layer.0.tensile_strength=1e3", YIELDS["layer"]),
    "ground.block.[].yield": (YIELDS["block"][1], ["ground.plane=strain"]),
    "ground.block.[].cohesion": ("ground.block.0.cohesion=3e3", YIELDS["block"]),
    "ground.block.[].friction_angle": ("ground.block.0.friction_angle=25", YIELDS["block"]),
    "ground.block.[].dilation_angle": ("ground.block.0.dilation_angle=10", YIELDS["block"]),
    "ground.block.[].tensile_strength": ("ground.block.0.tensile_strength=1e3", YIELDS["block"]),
    "ground.alpha": ("ground.alpha=-0.3", ["ground.integrator=hht"]),
    "ground.rho_inf": ("ground.rho_inf=0.5", ["ground.integrator=generalized_alpha"]),
    "ground.tolerance": ("ground.tolerance=1e-3", NEWMARK),
    "ground.static_iterations": ("ground.static_iterations=1",
                           [*YIELDS["layer"], "ground.layer.0.cohesion=100"]),
    "sleepers.count": ("sleepers.count=2", ["sleepers.width=0.15", "sleepers.spacing=0.2"]),
    "sleepers.first": ("sleepers.first=0.2", []),
    "sleepers.spacing": ("sleepers.spacing=0.22", ["sleepers.width=0.15", "sleepers.count=2",
                                                   "sleepers.spacing=0.2"]),
    "sleepers.y": ("sleepers.y=0.05", SPACE),
    "sleepers.width": ("sleepers.width=0.25", []),
    "sleepers.height": ("sleepers.height=0.2", []),
    "sleepers.length": ("sleepers.length=0.25", SPACE[:2]),
    "sleepers.material": ("sleepers.material=ballast", ["contact.1.friction=0.1"]),
    "sleepers.free": ('sleepers.free=["z"]', []),
    "sleepers.bevel": ("sleepers.bevel=0.03", []),
    "load.kind": ("load.kind=power", []),
    "load.peak": ("load.peak=2.5e3", []),
    "load.speed": ("load.speed=50", []),
    "load.axles": ("load.axles=[0, 0.5]", []),
    "load.start": ("load.start=0.1", []),
    "load.decay": ("load.decay=2", []),
    "load.ratio": ("load.ratio=0.7", POWER),
    "load.wheel_load": ("load.wheel_load=20e3", []),
    "load.wheel_diameter": ("load.wheel_diameter=0.9", WHEEL),
    "load.seat_share": ("load.seat_share=0.5", WHEEL),
    "load.slice": ("load.slice=0.5", WHEEL),
    "load.gauge": ("load.gauge=0.2", SIDES),
    "load.file": ("load.file={folder}/strong.csv", TABLE),
    "seat.before": ("seat.before=11", ON_BED),
    "seat.rails": ("seat.rails=0.9", ON_BED),
    "platen.pressure": ("platen.pressure=5e3", []),
    "platen.speed": ("platen.speed=0.3", []),
    "platen.acceleration": ("platen.acceleration=20", []),
    "platen.average": ("platen.average=0.02", []),
    "platen.tolerance": ("platen.tolerance=0.5", PRESSED),
    "platen.hold": ("platen.hold=0.01", [*PRESSED, "platen.tolerance=0.5"]),
    "platen.vibration": ("platen.vibration=1e-3", ["platen.average=0.05"]),
    "platen.frequency": ("platen.frequency=40", ["platen.average=0.05", "platen.vibration=1e-3"]),
    **{f"tamping.{name}": (f"tamping.{name}={value}", TAMPED) for name, value in
       {"lift": 0.01, "depth": 0.05, "gap": 0.05, "closing": 0.02, "amplitude": 3e-3,
        "frequency": 60, "insertion": 0.012, "squeeze": 0.012, "withdrawal": 0.012,
        "force": 2e3}.items()},
    # Deep in a bed twice as high and closing by a stone's width; 0.03 m had no effect on three
    # of five beds, 0.05 m had an effect on all.
    "tamping.thickness": ("tamping.thickness=0.05",
                          [*TAMPED, "tamping.gap=0.065", "tamping.depth=0.15",
                           "tamping.insertion=0.03", "tamping.squeeze=0.03",
                           "tamping.closing=0.05", "bed.height=0.3"]),
    "tamping.width": ("tamping.width=0.1", [*SPACE, *TAMPED, "tamping.y=[0]"]),
    "tamping.y": ("tamping.y=[0.05]", [*SPACE, *TAMPED, "tamping.y=[0]"]),
    "output.history_interval": ("output.history_interval=1e-3", []),
    "output.fields": ("output.fields=true", []),
    "output.fields_interval": ("output.fields_interval=0.01", FIELDS),
    "output.histories": ('output.histories=["energy"]', []),
    "output.fields_stages": ('output.fields_stages=["load"]', FIELDS),
    "output.fields_parts": ('output.fields_parts=["contacts"]', FIELDS),
    "output.ground_extremes": ("output.ground_extremes=true", FIELDS),
    "output.surface_cell": ("output.surface_cell=0.1", []),
    "output.checkpoint_interval": ("output.checkpoint_interval=0.01", []),
    "output.checkpoint_wall_interval": ("output.checkpoint_wall_interval=1e-3", []),
    "output.wall_time": ("output.wall_time=1e-3", []),
    "output.stop_after": ("output.stop_after=20", []),
    "sensor.[].name": ("sensor.0.name=other", []),
    "sensor.[].kind": ("sensor.0.kind=place", ["sensor.0.radius=0.1"]),
    "sensor.[].at": ("sensor.0.at=[0.15, 0, 0.05]", []),
    "sensor.[].radius": ("sensor.0.radius=0.1", []),
    "sensor.[].stage": ("sensor.0.stage=compact", []),
    "region.[].name": ("region.0.name=other", []),
    "region.[].kind": ("region.0.kind=sphere", []),
    "region.[].x": ("region.0.x=[0.1, 0.3]", []),
    "region.[].y": ("region.0.y=[-0.1, 0.05]", SPACE),
    "region.[].z": ("region.0.z=[0, 0.05]", []),
    "region.[].cells": ("region.0.cells=[2, 1, 1]", []),
    "region.[].centre": ("region.0.centre=[0.2, 0, 0.05]", BALL),
    "region.[].radius": ("region.0.radius=0.05", BALL),
    "stage.[].name": ("stage.load.name=vertical", []),
    "stage.[].kind": ("stage.load.kind=run", []),
    "stage.[].layer": ("stage.fill.layer=lower", ["bed.layer.0.porosity=0.4"]),
    "stage.[].duration": ("stage.fill.duration=0.14", []),
    "stage.[].friction": ("stage.load.friction=0.1", []),
    "stage.[].stiffness": ("stage.fill.stiffness=0.1", []),
    "stage.[].growth": ("stage.fill.growth=0.05", []),
    "stage.[].growth_height": ("stage.fill.growth_height=1.3", ["stage.fill.growth=0.05"]),
    "stage.[].local_damping": ("stage.load.local_damping=0.5", []),
    # Stones are on the floor by then, so that any bed has contact forces.
    "stage.[].until_ratio": ("stage.release.until_ratio=1e3", []),
    "stage.[].ground_moves": ("stage.load.ground_moves=false", []),
    "stage.[].lift": ("stage.release.lift=0.02", []),
    "stage.[].pressure": ("stage.compact.pressure=5e3", []),
    "stage.[].confinement": ("stage.compact.confinement=3e3", []),
    "stage.[].displacement": ("stage.load.displacement=0.01", []),
    "stage.[].height": ("stage.sleepers.height=0.12", []),
    "stage.[].profile": ("stage.sleepers.profile=0.06", []),
    "stage.[].seat_force": ("stage.load.seat_force=1e3", []),
    "stage.[].load": ("stage.load.load=2.5e3", []),
    "stage.[].ramp": ("stage.load.ramp=0.002", []),
    "stage.[].cycles": ("stage.load.cycles=1", []),
    "stage.[].train": ("stage.passage.train=false", ON_BED[:2]),
    "stage.[].rail": ("stage.passage.rail=kept", TWO_TRAINS),
    "stage.[].settlement": ("stage.load.settlement=1", ["stage.load.cycles=4"]),
    "time.window": ("time.window=1e-4", []),
    "time.step": ("time.step=1e-4", []),
    "time.substeps": ("time.substeps=2", []),
}

# A layer has all parameters of the bed except its place; the bed of these runs is the layer.
OF_THE_BED = {"x", "y", "crest", "slope", "cell", "layer", "container", "split", "beside"}
KNOBS |= {name.replace("bed.", "bed.layer.[].", 1):
          (change.replace("bed.", "bed.layer.0.", 1),
           [*(["bed.stone=disk"] if "dimension=space" in around else []),
            *(other.replace("bed.", "bed.layer.0.", 1) for other in around),
            "stage.fill.layer=lower"])
          for name, (change, around) in KNOBS.items()
          if name.startswith("bed.") and name.split(".")[1] not in OF_THE_BED}

# Parameters that must not change anything here, with the reason.
EXCEPTIONS = {
    "dem.skin": "speed only, a change of results would be an error; skin_test counts rebuilds",
    "ground.block.[].role": "only comparisons depend on it; drawing.py, test_ground_blocks.py",
    "bond.[].name": "only the report on screen has it; placed.py reads it there",
    "output.compress": "storage only; labels.py compares results with and without",
    "dem.rebalance": "speed only, as dem.skin; balance_test counts new splits",
    **dict.fromkeys((f"handover.{name}" for name in ("after", "rounds", "trains", "each", "load")),
                    "jobs/handover.py reads it; the test of on_bed.toml verifies its effect"),
}
SPEED_ONLY = {"dem.skin": "dem.skin=0.01", "dem.rebalance": "dem.rebalance=0"}

# Values that differ from run to run.
TIMES = re.compile(r"wall|timers|dem_time|cpu_time|seconds|per_core|memory|share|imbalance|deck")


def figures(value, name=""):
    """The summary without times and speeds."""
    if isinstance(value, dict):
        return {k: figures(v, k) for k, v in value.items() if not TIMES.search(k)}
    if isinstance(value, list):
        return [figures(item) for item in value]
    return value


def report(text):
    """Report on screen on model and stages, without memory and wall time."""
    lines = [line for line in text.splitlines()
             if re.match(r"trackbed:|  (ground|sleepers):|stage ", line)]
    return [re.sub(r"; memory [\d.e+-]+ MB per rank", "", line) for line in lines]


class Bench:
    def __init__(self, program, deck, folder):
        self.program, self.deck, self.folder, self.known = program, deck, folder, {}

    def seen(self, name, overrides):
        """All observables of one run."""
        place = self.folder / re.sub(r"\W+", "_", name)
        overrides = [o.replace("{folder}", str(self.folder)) for o in overrides]
        ran = self.program(1, "run", self.deck, *overrides, "-o", place)
        found = {"code": ran.returncode, "report": report(ran.stdout)}
        if ran.returncode == 2:
            found["refused"] = ran.stderr
        for path in place.glob("**/*"):
            found.setdefault("files", []).append(str(path.relative_to(place)))
        found.get("files", []).sort()
        found["fields"] = [data(path) for path in sorted(place.glob("fields/*.hdf"))]
        if (place / "results.h5").exists():
            found["data"] = data(place / "results.h5")
        if (place / "summary.json").exists():
            found["summary"] = figures(json.loads((place / "summary.json").read_text()))
        shutil.rmtree(place, ignore_errors=True)
        return found

    def verdict(self, parameter):
        """Empty if the parameter has an effect."""
        change, around = KNOBS[parameter]
        before, after = self.known[tuple(around)], self.seen(parameter, [*around, change])
        words = [word for word in parameter.split(".") if word != "[]"]
        if after["code"] == 2 and not any(word in after["refused"] for word in words):
            return f"{parameter}: refused, but the message does not name it: {after['refused']}"
        return f"{parameter}: {change} changes nothing" if after == before else ""


def parameters(schema, path=()):
    """Paths of all scalars and lists of scalars."""
    if "properties" in schema:
        for name, inner in schema["properties"].items():
            yield from parameters(inner, (*path, name))
    elif schema.get("type") == "array" and "properties" in schema["items"]:
        yield from parameters(schema["items"], (*path, "[]"))
    else:
        yield ".".join(path)


def main():
    program, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, force in (("weak", 2000), ("strong", 4000)):
        (folder / f"{name}.csv").write_text(f"time_s,force_N\n0,{force}\n1,{force}\n")
    (folder / "sides.csv").write_text("time_s,sleeper_0_left,sleeper_0_right\n0,2000,1000\n"
                                      "1,2000,1000\n")
    (folder / "wave.csv").write_text("time_s,vx_m_s,vz_m_s\n0,0,0\n0.01,0,0.01\n0.02,0,0\n")
    (folder / "young.csv").write_text("x_m,young_Pa\n0,50e6\n0.5,90e6\n")
    for name, flatness in (("round", 0.9), ("flat", 0.6)):
        program.done(1, "shapes", "--stones", 4, "--flatness", flatness, "--library",
                     folder / f"{name}.h5")
    declared = set(parameters(json.loads(program.done(1, "schema").stdout)))
    listed = (set(KNOBS) | set(EXCEPTIONS) | set(track_knobs.KNOBS) | set(ground_knobs.KNOBS)
              | set(mesh_knobs.KNOBS) | set(section_knobs.KNOBS) | set(solid_knobs.KNOBS)
              | set(pressure_knobs.KNOBS) | set(placed_knobs.KNOBS))
    problems = [f"{name}: no entry in this test" for name in sorted(declared - listed)]
    problems += [f"{name}: not a parameter" for name in sorted(listed - declared)]
    bench = Bench(program, sys.argv[2], folder)
    program.done(1, "run", sys.argv[2], "-o", folder / "started_from")
    program.done(1, "run", sys.argv[2], *REPEATED, "-o", folder / "cell")
    tried = part(sorted(declared & set(KNOBS)))
    contexts = sorted({(), *(tuple(KNOBS[name][1]) for name in tried)})
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        bases = pool.map(lambda k: bench.seen(f"base_{k}", contexts[k]),
                         range(len(contexts)))
        bench.known = dict(zip(contexts, bases))
        problems += [f"{list(around)}: the base does not run: {found}"
                     for around, found in bench.known.items() if found["code"] != 0]
        if bench.seen("again", []) != bench.known[()]:
            problems.append("two equal runs differ: this test would be meaningless")
        for name, change in SPEED_ONLY.items():
            if bench.seen(name, [change]) != bench.known[()]:
                problems.append(f"{name} changes results: {EXCEPTIONS[name]}")
        problems += filter(None, pool.map(bench.verdict, tried))
    print(f"{len(tried)} of {len(declared)} parameters")
    if problems:
        raise SystemExit("\n".join(problems))


if __name__ == "__main__":
    main()
