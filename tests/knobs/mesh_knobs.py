#!/usr/bin/env python3
"""As knobs.py, for the parameters of a ground from a mesh file instead of layers, with a short form
of inputs/ground/embankment.toml, and for the refusals of such decks.

    mesh_knobs.py PROGRAM DECK FOLDER
"""
import pathlib
import re
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import part  # noqa: E402
from program import Program, summary  # noqa: E402
from results import data  # noqa: E402

SHORT = ["bed.x=[0.7, 1.1]", "bed.y=[-0.2, 0.2]", "bed.height=0.06", "stage.fill.duration=0.02",
         "stage.compact.duration=0.01", "output.fields=false"]
YIELDS = "ground.solid.0.yield=mohr_coulomb ground.solid.0.cohesion=1e3"
# Parameter of the schema -> change of the deck, or (change, context).
KNOBS = {
    "ground.mesh": "ground.mesh={folder}/other.msh",
    "ground.mesh_top": "ground.mesh_top=crest",
    "ground.solid.[].name": "ground.solid.0.name=dam",
    "ground.solid.[].young": "ground.solid.0.young=90e6",
    "ground.solid.[].poisson": "ground.solid.0.poisson=0.2",
    "ground.solid.[].density": "ground.solid.0.density=1950",
    "ground.solid.[].rayleigh_mass": "ground.solid.0.rayleigh_mass=5",
    "ground.solid.[].rayleigh_stiffness": "ground.solid.0.rayleigh_stiffness=2e-4",
    "ground.solid.[].yield": "ground.solid.0.yield=mohr_coulomb",
    "ground.solid.[].cohesion": ("ground.solid.0.cohesion=1.5e3", YIELDS),
    "ground.solid.[].friction_angle": ("ground.solid.0.friction_angle=35", YIELDS),
    "ground.solid.[].dilation_angle": ("ground.solid.0.dilation_angle=10", YIELDS),
    "ground.solid.[].tensile_strength": ("ground.solid.0.tensile_strength=500", YIELDS),
    "ground.border.[].name": "ground.border.0.name=base",
    "ground.border.[].holds": "ground.border.0.holds=fixed",
    "ground.base_motion": "ground.base_stiffness=0 ground.base_motion={folder}/wave.csv",
}
# Change of the deck -> part of the refusal.
REFUSED = {
    "ground.mesh=no_such_file.msh": "does not exist",
    "ground.mesh={deck}": "is this a mesh file of Gmsh?",
    "ground.mesh={folder}/cut.msh": "is it complete?",
    "ground.mesh_top=crest": "has no physical surface \"crest\", which the deck names",
    "ground.solid.0.name=embankement": "did you mean",
    "ground.solid.1.name=embankment": "is already the name of another part of the mesh",
    "ground.border.1.name=top": "is already the name of another part of the mesh",
    "ground.border.3.holds=roller": "is not normal to x, y or z",
    "ground.border.0.holds=free ground.border.1.holds=free":
        "do not hold the ground in static equilibrium: it can move along y and move along z "
        "and rotate about x",
    # Viscous sides hold y and ends x; nothing holds z.
    "ground.border.0.holds=free": "static equilibrium: it can move along z; add a fixed border",
    "ground.border.0.holds=fixed ground.base_stiffness=0 ground.base_motion={folder}/wave.csv":
        "no viscous border faces down",
    "ground.base_stiffness=0 ground.base_motion={folder}/along.csv":
        "the border \"ends\" holds the ground along x",
    "ground.border.2.holds=fixed ground.base_stiffness=0 ground.base_motion={folder}/along.csv":
        "the border \"ends\" holds the ground along x",
    "ground.mesh={folder}/squashed.msh": "is flat: its shape quality",
    "ground.sides=viscous": "describe the surfaces of the mesh by [[ground.border]]",
    "ground.elements_x=3": "the file of the mesh defines the shape",
    "dimension=plane": "needs dimension = \"space\"",
    "time.window=0": "must be given with ground.mesh",
    "ground.mesh={folder}/hole.msh": "m^2 of the bed: stones would fall through (bed.x, bed.y",
    "bed.y=[-0.9, 0.9]": "reaches beyond the top of the mesh (-0.8 to 0.8 m)",
}


# Change of the deck -> texts that `check` prints, or (after "-") must not print.
REPORTED = {
    "title=same": ["mesh: x = 0 to 1.8, ", " m^3", "with springs of 4e+07 Pa/m", "-warning"],
    "ground.border.0.holds=roller": ["-with springs"],
    "ground.border.0.holds=roller ground.border.1.holds=roller": ["is valid"],
    "ground.base_stiffness=0 ground.base_motion={folder}/wave.csv":
        ["\"sides\" impedes the wave of ground.base_motion", "-\"ends\"", "-\"slopes\""],
    "ground.border.2.holds=fixed ground.base_stiffness=0 ground.base_motion={folder}/wave.csv":
        ["\"ends\" impedes the wave of ground.base_motion"],
    "ground.border.2.holds=free ground.base_stiffness=0 ground.base_motion={folder}/along.csv":
        ["\"ends\" is free and at an end of the mesh", "-\"slopes\""],
    "ground.mesh={folder}/half.msh": ["outer faces are in no physical surface and therefore free",
                                      " % of"],
    "ground.mesh={folder}/mm.msh": ["is the file in metres?"],
    "ground.mesh={folder}/thin.msh time.window=1e-5":
        ["are nearly flat: their shape quality (mean ratio, 1: equilateral) is below 0.05"],
}


def seen(program, deck, folder, changes):
    """State after the run, or the refusal."""
    place = folder / "run"
    ran = program(1, "run", deck, *SHORT, *changes, "--force", "-o", place)
    if ran.returncode != 0:
        return {"code": ran.returncode, "refusal": ran.stderr}
    return {"code": 0, "data": data(place / "results.h5"),
            "ground": summary(place)["ground"]["elements"]}


def scaled(text, sizes):
    """The mesh file with scaled coordinates."""
    rows, inside = text.splitlines(), False
    for k, row in enumerate(rows):
        inside = (inside or row == "$Nodes") and row != "$EndNodes"
        numbers = row.split()
        if inside and len(numbers) == 3:
            rows[k] = " ".join(repr(float(x) * s) for x, s in zip(numbers, sizes))
    return "\n".join(rows) + "\n"


def without(text, surface, first, count):
    """The mesh file without some triangles of a surface: 3 is the bottom, 4 the top."""
    rows = text.splitlines()
    total = rows.index("$Elements") + 1
    block = next(k for k in range(total, len(rows)) if rows[k].startswith(f"2 {surface} 9 "))
    there = int(rows[block].split()[3])
    blocks, all_there, *rest = rows[total].split()
    rows[total] = " ".join([blocks, str(int(all_there) - count), *rest])
    rows[block] = f"2 {surface} 9 {there - count}"
    return "\n".join(rows[:block + 1 + first] + rows[block + 1 + first + count:]) + "\n"


def missing_reports(program, deck, place):
    """Problems of reports of `check` on changes."""
    problems = []
    for changes, words in part(REPORTED.items()):
        ran = program(1, "check", deck, *split(changes.format(**place)))
        for word in words:
            if ran.returncode != 0 or (word.lstrip("-") in ran.stdout) == word.startswith("-"):
                problems.append(f"check {changes}: {word}? code {ran.returncode}, {ran.stdout} "
                                f"{ran.stderr}")
    return problems


def split(changes):
    """Splits at blanks before a key, as lists also have blanks."""
    return re.split(r" (?=[a-z]+\.)", changes)


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    text = (pathlib.Path(deck).parent / "embankment.msh").read_text(encoding="utf-8")
    (folder / "cut.msh").write_text(text[:len(text) // 2], encoding="utf-8")
    # The lowest nodes are moved down.
    (folder / "other.msh").write_text(text.replace(" -1.8\n", " -2\n"), encoding="utf-8")
    for name, sizes in {"squashed": (1, 1, 1e-4), "mm": (1e3, 1e3, 1e3),
                        "thin": (1, 1, 3e-3)}.items():
        (folder / f"{name}.msh").write_text(scaled(text, sizes), encoding="utf-8")
    (folder / "wave.csv").write_text("time_s,vx_m_s,vz_m_s\n0,0,0\n0.01,0,0.01\n0.02,0,0\n")
    (folder / "along.csv").write_text("time_s,vx_m_s,vz_m_s\n0,0,0\n0.01,0.01,0\n0.02,0,0\n")
    (folder / "half.msh").write_text(without(text, 3, 0, 12), encoding="utf-8")
    (folder / "hole.msh").write_text(without(text, 4, 5, 2), encoding="utf-8")
    place = {"folder": folder, "deck": deck}
    before = seen(program, deck, folder, [])
    problems = [] if before["code"] == 0 else [f"the base does not run: {before}"]
    if before != seen(program, deck, folder, []):
        problems.append("two equal runs differ: this test would be meaningless")
    within = seen(program, deck, folder, split(YIELDS))
    problems += [] if within["code"] == 0 else [f"the yielding ground does not run: {within}"]
    for name, change in part(KNOBS.items()):
        change, around = (change, "") if isinstance(change, str) else change
        after = seen(program, deck, folder,
                     [*(split(around) if around else []), change.format(**place)])
        if after == (within if around else before):
            problems.append(f"{name}: {change} changes nothing")
    for changes, words in part(REFUSED.items()):
        for command in ("check", "run"):
            ran = program(1, command, deck, *split(changes.format(**place)),
                          *(["-o", folder / "none"] if command == "run" else []))
            if ran.returncode != 2 or words not in ran.stderr:
                problems.append(f"{command} {changes}: code {ran.returncode}, {ran.stderr}")
    problems += missing_reports(program, deck, place)
    if (folder / "none").exists():
        problems.append("a refused run must leave nothing behind")
    print(f"{len(part(KNOBS))} parameters, {len(part(REFUSED))} refusals")
    if problems:
        raise SystemExit("\n".join(problems))


if __name__ == "__main__":
    main()
