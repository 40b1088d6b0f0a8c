#!/usr/bin/env python3
"""As knobs.py, for the parameters of a track alone (model = "track"), with a separate deck.

    track_knobs.py PROGRAM DECK FOLDER
"""
import concurrent.futures
import pathlib
import re
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, summary  # noqa: E402
from results import datasets  # noqa: E402

# Contexts in which some parameters have an effect.
EVEN = ["track.support=continuous"]
MASS = ["ballast.mass=500"]
UNDER = ["under_sleeper_pad.stiffness=80e6"]
CUSTOM = ["train.vehicles=[\"own\"]"]
COACH = [*CUSTOM, "vehicle.own.like=manchester_1", "vehicle.own.kind=coach"]
AXLES = [*CUSTOM, "vehicle.own.kind=forces", "vehicle.own.axles=[1, 3]",
         "vehicle.own.loads=[1e5, 1e5]"]
BRAKES = ["train.times=[1]", "train.speeds=[48]"]
LINEAR = ["wheel_rail.law=linear"]
FLAT = ["wheel_rail.flat_axle=1", "wheel_rail.flat_at=8.5"]
DIP = ["irregularity.kind=versine"]
WAVES = ["irregularity.kind=waves"]
RANDOM = ["irregularity.kind=spectrum"]
FILE = ["irregularity.kind=file", "irregularity.file={folder}/one.csv"]

# Parameter of the schema -> (change, context).
KNOBS = {
    "model": ("model=bed", []),
    "rail.section": ("rail.section=CHN60", []),
    "rail.theory": ("rail.theory=euler", []),
    "rail.young": ("rail.young=200e9", []),
    "rail.poisson": ("rail.poisson=0.25", []),
    "rail.shear_factor": ("rail.shear_factor=0.34", []),
    "rail.area": ("rail.area=7e-3", []),
    "rail.inertia": ("rail.inertia=2.5e-5", []),
    "rail.mass": ("rail.mass=55", []),
    "pad.stiffness": ("pad.stiffness=60e6", []),
    "pad.damping": ("pad.damping=10e3", []),
    "pad.bilinear_at": ("pad.bilinear_at=2e-4", ["pad.bilinear_stiffness=500e6"]),
    "pad.bilinear_stiffness": ("pad.bilinear_stiffness=300e6",
                               ["pad.bilinear_stiffness=500e6", "pad.bilinear_at=1e-4"]),
    "pad.uplift": ("pad.uplift=true", []),
    "pad.preload": ("pad.preload=50", ["pad.uplift=true"]),
    "ballast.stiffness": ("ballast.stiffness=30e6", []),
    "ballast.damping": ("ballast.damping=30e3", []),
    "ballast.mass": ("ballast.mass=500", []),
    "ballast.below_stiffness": ("ballast.below_stiffness=60e6", MASS),
    "ballast.below_damping": ("ballast.below_damping=10e3", MASS),
    "under_sleeper_pad.stiffness": ("under_sleeper_pad.stiffness=80e6", []),
    "under_sleeper_pad.damping": ("under_sleeper_pad.damping=30e3", UNDER),
    "under_sleeper_pad.from": ("under_sleeper_pad.from=6.5", UNDER),
    "under_sleeper_pad.to": ("under_sleeper_pad.to=6.5", UNDER),
    "track.support": ("track.support=continuous", []),
    "track.ends": ("track.ends=free", []),
    "track.rails": ("track.rails=1", []),
    "track.length": ("track.length=13.2", []),
    "track.spacing": ("track.spacing=0.75", []),
    "track.elements": ("track.elements=3", []),
    "track.sleeper_mass": ("track.sleeper_mass=250", []),
    "track.bed_stiffness": ("track.bed_stiffness=60e6", EVEN),
    "track.bed_damping": ("track.bed_damping=20e3", EVEN),
    "track.run_in": ("track.run_in=3", []),
    "track.run_in_factor": ("track.run_in_factor=10", []),
    "track.zone.[].from": ("track.zone.0.from=5.5", []),
    "track.zone.[].to": ("track.zone.0.to=6.7", []),
    "track.zone.[].rail": ("track.zone.0.rail=2", []),
    "track.zone.[].bed": ("track.zone.0.bed=2", []),
    "track.zone.[].pad": ("track.zone.0.pad=2", []),
    "track.zone.[].sleeper": ("track.zone.0.sleeper=2", []),
    "track.zone.[].under_sleeper_pad": ("track.zone.0.under_sleeper_pad=2", UNDER),
    "track.zone.[].spacing": ("track.zone.0.spacing=0.3",
                              ["track.zone.0.from=5.4", "track.zone.0.to=6.6"]),
    "track.zone.[].gap": ("track.zone.0.gap=1e-3", []),
    "vehicle.[].name": ("vehicle.0.name=manchester_1", []),
    "vehicle.[].like": ("vehicle.own.like=alfa_pendular", COACH),
    "vehicle.[].kind": ("vehicle.own.kind=wheel", CUSTOM),
    "vehicle.[].length": ("vehicle.own.length=1.5", ["train.vehicles=[\"own\", \"own\"]"]),
    "vehicle.[].body_mass": ("vehicle.own.body_mass=30e3", COACH),
    "vehicle.[].bogie_mass": ("vehicle.own.bogie_mass=3e3", COACH),
    "vehicle.[].wheelset_mass": ("vehicle.own.wheelset_mass=1500", COACH),
    "vehicle.[].body_inertia": ("vehicle.own.body_inertia=1e6", COACH),
    "vehicle.[].bogie_inertia": ("vehicle.own.bogie_inertia=2e3", COACH),
    "vehicle.[].primary_stiffness": ("vehicle.own.primary_stiffness=3e6", COACH),
    "vehicle.[].primary_damping": ("vehicle.own.primary_damping=9e3", COACH),
    "vehicle.[].secondary_stiffness": ("vehicle.own.secondary_stiffness=1e6", COACH),
    "vehicle.[].secondary_damping": ("vehicle.own.secondary_damping=30e3", COACH),
    "vehicle.[].bogie_distance": ("vehicle.own.bogie_distance=18", COACH),
    "vehicle.[].wheelbase": ("vehicle.own.wheelbase=2.5", COACH),
    "vehicle.[].axles": ("vehicle.own.axles=[1, 4]", AXLES),
    "vehicle.[].loads": ("vehicle.own.loads=[1e5, 2e5]", AXLES),
    "train.vehicles": ("train.vehicles=[\"freight_wagon\"]", []),
    "train.speed": ("train.speed=60", []),
    "train.start": ("train.start=7", []),
    "train.times": ("train.times=[0.5]", BRAKES),
    "train.speeds": ("train.speeds=[49]", BRAKES),
    "wheel_rail.law": ("wheel_rail.law=linear", []),
    "wheel_rail.wheel_radius": ("wheel_rail.wheel_radius=0.5", []),
    "wheel_rail.rail_radius": ("wheel_rail.rail_radius=0.2", []),
    "wheel_rail.young": ("wheel_rail.young=200e9", []),
    "wheel_rail.poisson": ("wheel_rail.poisson=0.25", []),
    "wheel_rail.constant": ("wheel_rail.constant=8e10", []),
    "wheel_rail.stiffness": ("wheel_rail.stiffness=1e9", LINEAR),
    "wheel_rail.flat_axle": ("wheel_rail.flat_axle=1", FLAT[1:]),
    "wheel_rail.flat_length": ("wheel_rail.flat_length=0.04", FLAT),
    "wheel_rail.flat_at": ("wheel_rail.flat_at=8.7", FLAT),
    "irregularity.kind": ("irregularity.kind=vee", []),
    "irregularity.at": ("irregularity.at=7", DIP),
    "irregularity.depth": ("irregularity.depth=2e-4", DIP),
    "irregularity.length": ("irregularity.length=0.8", DIP),
    "irregularity.waves": ("irregularity.waves=2", WAVES),
    "irregularity.spectrum": ("irregularity.spectrum=china", RANDOM),
    "irregularity.shortest": ("irregularity.shortest=2", RANDOM),
    "irregularity.longest": ("irregularity.longest=60", RANDOM),
    "irregularity.seed": ("irregularity.seed=2", RANDOM),
    "irregularity.fade": ("irregularity.fade=5", RANDOM),
    "irregularity.file": ("irregularity.file={folder}/other.csv", FILE),
    "passage.step": ("passage.step=4e-4", []),
    "passage.duration": ("passage.duration=0.08", []),
    "passage.tolerance": ("passage.tolerance=1e-5", []),
    "output.history_interval": ("output.history_interval=2e-3", []),
    "passage.points": ("passage.points=[6.6]", []),
    "output.checkpoint_interval": ("output.checkpoint_interval=0.02", []),
    "output.checkpoint_wall_interval": ("output.checkpoint_wall_interval=1e-9", []),
    "output.wall_time": ("output.wall_time=1e-9", []),
    "output.stop_after": ("output.stop_after=100", []),
    "passage.loaded_by": ("passage.loaded_by=seats", []),
    "force.[].kind": ("force.0.kind=impact", []),
    "force.[].at": ("force.0.at=7", []),
    "force.[].size": ("force.0.size=2e3", []),
    "force.[].frequency": ("force.0.frequency=120", []),
    "force.[].begin": ("force.0.begin=0.01", []),
    "force.[].rise": ("force.0.rise=0.01", []),
    "force.[].length": ("force.0.length=5e-3", ["force.0.kind=impact"]),
}

# With two rails; the force of the deck acts on the left one, so that the track rolls.
SPACE = ["track.dimension=space"]
KNOBS |= {
    "track.dimension": (SPACE[0], []),
    "track.gauge": ("track.gauge=1", SPACE),
    "track.sleeper_length": ("track.sleeper_length=2.2", SPACE),
    "track.sleeper_inertia": ("track.sleeper_inertia=50", SPACE),
    "track.zone.[].side": ("track.zone.0.side=left", SPACE),
    "force.[].side": ("force.0.side=right", SPACE),
    "vehicle.[].body_roll": ("vehicle.own.body_roll=40e3", [*COACH, *SPACE]),
    "vehicle.[].bogie_roll": ("vehicle.own.bogie_roll=1500", [*COACH, *SPACE]),
    "vehicle.[].wheelset_roll": ("vehicle.own.wheelset_roll=900", [*COACH, *SPACE]),
    "vehicle.[].primary_base": ("vehicle.own.primary_base=1.8", [*COACH, *SPACE]),
    "vehicle.[].secondary_base": ("vehicle.own.secondary_base=1.8", [*COACH, *SPACE]),
    "vehicle.[].body_offset": ("vehicle.own.body_offset=0.05", [*COACH, *SPACE]),
}
BENDING = ["track.sleeper.model=beam"]
KNOBS |= {
    "track.sleeper.model": (BENDING[0], []),
    "track.sleeper.theory": ("track.sleeper.theory=euler", BENDING),
    "track.sleeper.young": ("track.sleeper.young=50e9", BENDING),
    "track.sleeper.poisson": ("track.sleeper.poisson=0.3", BENDING),
    "track.sleeper.width": ("track.sleeper.width=0.3", BENDING),
    "track.sleeper.height": ("track.sleeper.height=0.18", BENDING),
    "track.sleeper.elements": ("track.sleeper.elements=4", BENDING),
    "track.sleeper.unsupported": ("track.sleeper.unsupported=0.5", SPACE),
}


def to_the_right(words):
    return words.replace("irregularity.", "irregularity_right.")


KNOBS |= {to_the_right(name): (to_the_right(change), [*SPACE, *map(to_the_right, around)])
          for name, (change, around) in KNOBS.items() if name.startswith("irregularity.")}
# The deck's dip has a place, a depth and a length; the right rail has none by default.
for _name in ("at", "depth", "length", "kind", "waves"):
    KNOBS[f"irregularity_right.{_name}"][1].extend(
        word for word in ("irregularity_right.at=8.5", "irregularity_right.length=1.2",
                          "irregularity_right.depth=1e-4") if f".{_name}=" not in word)


class Bench:
    def __init__(self, program, deck, folder):
        self.program, self.deck, self.folder, self.known = program, deck, folder, {}

    def seen(self, overrides):
        """State after the run and its output."""
        place = self.folder / (re.sub(r"\W+", "_", "".join(overrides)) or "base")
        overrides = [o.replace("{folder}", str(self.folder)) for o in overrides]
        ran = self.program(1, "run", self.deck, *overrides, "--force", "-o", place)
        if ran.returncode not in (0, 3):
            return {"code": ran.returncode, "refused": ran.stderr}
        track = summary(place)["track"]
        rows = len(datasets(place)["history/time"])
        written = sorted(file.name for file in place.glob("checkpoint_*.h5"))
        return {"code": ran.returncode, "track": track, "rows": rows, "written": written}


def verdict(bench, parameter):
    """Empty if the parameter has an effect."""
    change, around = KNOBS[parameter]
    before = bench.known[tuple(around)]
    if before["code"] != 0:
        return f"{around}: the base does not run: {before}"
    after = bench.seen([*around, change])
    if after["code"] == 2 and parameter.rpartition(".")[2] not in after["refused"]:
        return f"{parameter}: refused, but not by name: {after['refused']}"
    return f"{parameter}: {change} changes nothing" if after == before else ""


def main():
    program, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, depth in (("one", -1e-4), ("other", -2e-4)):
        (folder / f"{name}.csv").write_text(f"x_m,z_m\n0,0\n6,{depth}\n7,{depth}\n12,0\n")
    bench = Bench(program, sys.argv[2], folder)
    again = bench.seen([])
    if again != bench.seen([]):
        raise SystemExit("two equal runs differ: this test would be meaningless")
    tried = part(KNOBS)
    surroundings = sorted({tuple(KNOBS[name][1]) for name in tried})
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        bench.known = dict(zip(surroundings, pool.map(bench.seen, surroundings)))
        problems = list(pool.map(lambda parameter: verdict(bench, parameter), tried))
    print(f"{len(tried)} parameters")
    if any(problems):
        raise SystemExit("\n".join(filter(None, problems)))


if __name__ == "__main__":
    main()
