#!/usr/bin/env python3
"""As knobs.py, for the sections of an embankment, with a short form of inputs/ground/sections.toml,
and for refusals and reports of such decks.

    section_knobs.py PROGRAM DECK FOLDER
"""
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, summary  # noqa: E402
from results import data  # noqa: E402

SHORT = ["ground.elements_x=9", "ground.layer.1.elements=1", "ground.layer.2.elements=1",
         "passage.duration=0.05"]
# Parameter of the schema -> change of the deck.
KNOBS = {
    "ground.embankment_layers": "ground.embankment_layers=1 ground.section.2.height=0.5",
    "ground.section.[].x": "ground.section.1.x=6",
    "ground.section.[].crest": "ground.section.1.crest=3",
    "ground.section.[].height": "ground.section.0.height=3.5",
    "ground.section.[].slope": "ground.section.1.slope=2",
    # Of all grounds: a wave also enters below sections.
    "ground.base_motion": "ground.base=viscous ground.base_motion={folder}/wave.csv",
}
# Change of the deck -> part of the refusal.
REFUSED = {
    "ground.section.1.x=-1": "must be beyond that of the previous section (0 m)",
    "ground.section.1.x=0": "must be beyond that of the previous section",
    "ground.section.1.crest=-1": "crest",
    "ground.y=[0,9]": "its foot is 9.5 m from the axis",
    "ground.y=[-9,16]": "ends within the embankment",
    "ground.y=[0,9.5] ground.section.2.height=2.5":
        "ends at the foot of some sections and beyond the foot of others",
    "ground.y=[0,16] ground.elements_y=1": "must be at least 2",
    "ground.section.2.height=0.6":
        '"fill", is reduced by this difference and would be 0 m thick; increase the height to '
        "more than 0.6 m",
    "ground.section.2.height=9.5":
        '"soil", is reduced by this difference and would be -0.5 m thick; reduce the height to '
        "less than 9 m",
    "ground.embankment_layers=0": "must be at least 1 and below the number of layers, 3",
    "ground.embankment_layers=3": "must be at least 1 and below the number of layers, 3",
    "ground.layer.1.elements=0": "must all have `elements`",
    "ground.elements_x=100000": "at most 2e+06",
    "ground.elements_x=18 ground.y=[0,16000]": "is flat: its shape quality",
    "ground.sides=free_field":
        "cannot be free_field or periodic with ground.section, whose tetrahedra",
    "ground.side_x_low=periodic ground.side_x_high=periodic":
        "cannot be free_field or periodic with ground.section, whose tetrahedra",
    "ground.side_y_low=viscous": "the axis of the embankment is a plane of symmetry",
    "ground.plane=strain": "an embankment is for three-dimensional models",
    "ground.layer.1.yield=mohr_coulomb": "must not yield below a track without stones",
    "dimension=plane": 'must be "space": a ground of tetrahedra is',
    "footing.length=8 footing.y=4": "beyond the crest of ground.section (3.5 m on either side)",
    "ground.base=viscous ground.base_motion={folder}/along.csv":
        "ground.sides = \"roller\": holds the ends of the ground, which base_motion moves along",
    # It would contain the centre of a cell of level rows, but not of inclined rows.
    "ground.block.0.outline=[17.1,-1.8,18,-1.8,18,-1.95,17.1,-1.95]":
        "its outline contains the centre of no cell of the embankment",
    "ground.mesh={mesh}": "has no effect with ground.mesh; the file of the mesh defines the shape",
}
# Half an embankment without slopes, which ends with y.
UPRIGHT = ("ground.section.0.slope=0 ground.section.1.slope=0 ground.section.2.slope=0 "
           "ground.section.2.crest=3.5")
# Change of the deck -> texts that `check` prints, or (after "-") must not print.
REPORTED = {
    "title=same": ["x = 0 to 18, y = 0 to 16, z = -9 to 0 m, {volume:.6g} m^3", "-warning"],
    "ground.section.1.x=8.7": ["section[1].x", "is not at an element boundary"],
    "ground.section.2.x=17.7": ["section[2].x", "is not at an element boundary", "-section[1]"],
    "ground.section.0.x=0.3 ground.section.0.crest=3.6":
        ["section[0].x", "is not at an element boundary", "-section[1]", "-section[2]"],
    # Nothing bends at these: all is as at the second, or changes evenly, or is beyond the ground.
    "ground.section.0.x=0.3": ["-warning"],
    "ground.section.1.x=4.5 ground.section.1.crest=3.875 ground.section.1.height=3.75":
        ["-warning"],
    "ground.section.2.x=18.3": ["-warning"],
    "ground.base=viscous ground.base_motion={folder}/wave.csv": ["-warning"],
    "ground.base=viscous ground.side_x_low=viscous ground.base_motion={folder}/wave.csv":
        ["side_x_low", "impedes the wave of base_motion", "-use free_field"],
    # The reverse.
    "ground.block.0.outline=[17.1,-1.45,18,-1.45,18,-1.58,17.1,-1.58]": ["-warning"],
    "ground.y=[0,9.5]": ["y = 0 to 9.5, z", "-warning"],  # ends at the foot of all
    UPRIGHT + " ground.y=[0,3.5]": ["vertical side faces", "(x = 0 to 18 m)"],
    UPRIGHT + " ground.y=[0,3.5] ground.side_y_high=free": ["-warning"],
    UPRIGHT: ["-warning"],
    # Slopes begin in a row of elements, and there they are free.
    "ground.section.0.slope=0 ground.section.1.slope=0 ground.section.0.crest=9.5 "
    "ground.section.1.crest=9.5 ground.y=[0,9.5]": ["vertical side faces", "(x = 0 to 9 m)"],
}


# Volume of half the deck's embankment, m^3: level to x = 9 m, then lower and wider.
def volume():
    def area(crest, height):
        return height * (crest + 0.75 * height) + 16 * (9 - height)
    level, middle, end = area(3.5, 4), area(4.25, 3.5), area(5, 3)
    return 9 * level + 9 / 6 * (level + 4 * middle + end)


# Stones on an embankment of sections with a yielding fill, in place of the mesh of a deck.
GROUND = """[ground]
x = [0, 1.8]
y = [-2, 2]
elements_x = 3
elements_y = 8
embankment_layers = 1
base_stiffness = 40e6
[[ground.layer]]
name = "fill"
thickness = 0.6
elements = 2
young = 20e6
density = 1900
[[ground.layer]]
name = "soil"
thickness = 1.2
elements = 2
young = 30e6
[[ground.section]]
crest = 0.8
slope = 0.6667
"""
WEAK = ["ground.layer.0.yield=mohr_coulomb", "ground.layer.0.cohesion=2e3",
        "ground.layer.0.friction_angle=15"]
BED_SHORT = ["bed.x=[0.7, 1.1]", "bed.y=[-0.2, 0.2]", "bed.height=0.06",
             "stage.fill.duration=0.02", "stage.compact.duration=0.01", "output.fields=false"]
BED_REFUSED = {"bed.y=[-0.9,0.9]": "reaches beyond the crest of ground.section (0.8 m",
               "time.window=0": "must be given with ground.section",
               "dimension=plane": "needs dimension = \"space\""}


def stones(program, deck, folder):
    """Problems of runs of stones on an embankment."""
    text = pathlib.Path(deck).with_name("embankment.toml").read_text(encoding="utf-8")
    begin, end = text.index("[ground]"), text.index("[time]")
    own = folder / "stones.toml"
    own.write_text(text[:begin] + GROUND + text[end:], encoding="utf-8")
    problems, found = [], []
    for changes in ([], WEAK, [*WEAK, "ground.integrator=newmark"]):
        ran = program(1, "run", own, *BED_SHORT, *changes, "--force", "-o", folder / "stones")
        if ran.returncode != 0:
            return [f"stones {changes}: code {ran.returncode}, {ran.stderr}"]
        found.append(summary(folder / "stones"))
    if [run["ground"]["elements"] for run in found] != [found[0]["ground"]["elements"]] * 3:
        problems.append("the mesh depends on yielding")
    lost = [run["ground"]["plastic_j"] for run in found]
    if lost[0] != 0 or min(lost[1:]) <= 0:
        problems.append(f"plastic_j of one elastic and two yielding grounds: {lost}")
    for change, words in part(BED_REFUSED.items()):
        ran = program(1, "check", own, change)
        if ran.returncode != 2 or words not in ran.stderr:
            problems.append(f"check stones {change}: code {ran.returncode}, {ran.stderr}")
    return problems


def split(changes):
    """Splits at blanks before a key."""
    return changes.split(" ")


def seen(program, deck, folder, changes):
    """State after the run, or the refusal."""
    place = folder / "run"
    ran = program(1, "run", deck, *SHORT, *changes, "--force", "-o", place)
    if ran.returncode != 0:
        return {"code": ran.returncode, "refusal": ran.stderr}
    return {"code": 0, "data": data(place / "results.h5"),
            "ground": summary(place)["ground"]["elements"]}


def missing_reports(program, deck, place):
    """Problems of reports of `check` on changes."""
    problems = []
    for changes, words in part(REPORTED.items()):
        ran = program(1, "check", deck, *split(changes.format(**place)))
        lines = [line for line in ran.stdout.splitlines() if line.startswith("warning")]
        if len(set(lines)) < len(lines):
            problems.append(f"check {changes}: the same warning twice: {lines}")
        for word in words:
            word = word.format(volume=volume())
            if ran.returncode != 0 or (word.lstrip("-") in ran.stdout) == word.startswith("-"):
                problems.append(f"check {changes}: {word}? code {ran.returncode}, {ran.stdout} "
                                f"{ran.stderr}")
    return problems


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    place = {"mesh": pathlib.Path(deck).parent / "embankment.msh", "folder": folder}
    (folder / "wave.csv").write_text("time_s,vx_m_s,vz_m_s\n0,0,0\n0.01,0,0.01\n0.02,0,0\n")
    (folder / "along.csv").write_text("time_s,vx_m_s,vz_m_s\n0,0,0\n0.01,0.01,0\n0.02,0,0\n")
    before = seen(program, deck, folder, [])
    problems = [] if before["code"] == 0 else [f"the base does not run: {before}"]
    if before != seen(program, deck, folder, []):
        problems.append("two equal runs differ: this test would be meaningless")
    for name, change in part(KNOBS.items()):
        after = seen(program, deck, folder, split(change.format(**place)))
        if after["code"] != 0 or after == before:
            problems.append(f"{name}: {change} changes nothing, or: {after}")
    for changes, words in part(REFUSED.items()):
        for command in ("check", "run"):
            ran = program(1, command, deck, *split(changes.format(**place)),
                          *(["-o", folder / "none"] if command == "run" else []))
            if ran.returncode != 2 or words not in ran.stderr:
                problems.append(f"{command} {changes}: code {ran.returncode}, {ran.stderr}")
    problems += missing_reports(program, deck, place) + stones(program, deck, folder)
    if (folder / "none").exists():
        problems.append("a refused run must leave nothing behind")
    print(f"{len(part(KNOBS))} parameters, {len(part(REFUSED))} refusals")
    if problems:
        raise SystemExit("\n".join(problems))


if __name__ == "__main__":
    main()
