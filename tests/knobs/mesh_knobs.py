#!/usr/bin/env python3
"""As knobs.py, for the parameters of a ground from a mesh file, in place of layers: with
a short form of inputs/ground/embankment.toml. And the refusals of such decks.

    mesh_knobs.py PROGRAM DECK FOLDER
"""
import hashlib
import pathlib
import shutil
import sys

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402

SHORT = ["bed.x=[0.7, 1.1]", "bed.y=[-0.2, 0.2]", "bed.height=0.06", "stage.fill.duration=0.02",
         "stage.compact.duration=0.01", "output.fields=false"]
# Parameter of the schema -> change of the deck.
KNOBS = {
    "ground.mesh": "ground.mesh={folder}/other.msh",
    "ground.mesh_top": "ground.mesh_top=crest",
    "ground.solid.[].name": "ground.solid.0.name=dam",
    "ground.solid.[].young": "ground.solid.0.young=90e6",
    "ground.solid.[].poisson": "ground.solid.0.poisson=0.2",
    "ground.solid.[].density": "ground.solid.0.density=1950",
    "ground.solid.[].rayleigh_mass": "ground.solid.0.rayleigh_mass=5",
    "ground.solid.[].rayleigh_stiffness": "ground.solid.0.rayleigh_stiffness=2e-4",
    "ground.border.[].name": "ground.border.0.name=base",
    "ground.border.[].holds": "ground.border.0.holds=fixed",
}
# Change of the deck -> words of the refusal.
REFUSED = {
    "ground.mesh=no_such_file.msh": "does not exist",
    "ground.mesh={deck}": "is this a mesh file of Gmsh?",
    "ground.mesh={folder}/cut.msh": "is it whole?",
    "ground.mesh_top=crest": "has no physical surface \"crest\", which the deck names",
    "ground.solid.0.name=embankement": "did you mean",
    "ground.solid.1.name=embankment": "is the name of an earlier one",
    "ground.border.1.name=top": "is the name of an earlier one",
    "ground.border.3.holds=roller": "is not normal to x, y or z",
    "ground.border.0.holds=free ground.border.1.holds=free": "holds the ground nowhere",
    "ground.sides=quiet": "its surfaces are [[ground.border]]",
    "ground.zones_x=3": "the file has the shape",
    "dimension=plane": "needs dimension = \"space\"",
    "time.window=0": "must be given with ground.mesh",
    "bed.y=[-0.9, 0.9]": "reaches beyond the top of the mesh (-0.8 to 0.8 m)",
}


def seen(program, deck, folder, changes):
    """State after the run, or the refusal."""
    place = folder / "run"
    ran = program(1, "run", deck, *SHORT, *changes, "--force", "-o", place)
    if ran.returncode != 0:
        return {"code": ran.returncode, "said": ran.stderr}
    digest = hashlib.sha256()
    with h5py.File(place / "results.h5") as file:
        file.visititems(lambda name, item: digest.update(item[()].tobytes())
                        if isinstance(item, h5py.Dataset) else None)
    return {"code": 0, "data": digest.hexdigest(), "ground": summary(place)["ground"]["elements"]}


def split(changes):
    """At blanks before a key; lists have blanks too."""
    return [("ground." if k else "") + part for k, part in enumerate(changes.split(" ground."))]


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    text = (pathlib.Path(deck).parent / "embankment.msh").read_text(encoding="utf-8")
    (folder / "cut.msh").write_text(text[:len(text) // 2], encoding="utf-8")
    # The deepest nodes lower.
    (folder / "other.msh").write_text(text.replace(" -1.8\n", " -2\n"), encoding="utf-8")
    place = {"folder": folder, "deck": deck}
    before = seen(program, deck, folder, [])
    problems = [] if before["code"] == 0 else [f"the base does not run: {before}"]
    if before != seen(program, deck, folder, []):
        problems.append("the same run twice differs: this test would prove nothing")
    for name, change in KNOBS.items():
        after = seen(program, deck, folder, [change.format(**place)])
        if after == before:
            problems.append(f"{name}: {change} changes nothing")
    for changes, words in REFUSED.items():
        for command in ("check", "run"):
            ran = program(1, command, deck, *split(changes.format(**place)),
                          *(["-o", folder / "none"] if command == "run" else []))
            if ran.returncode != 2 or words not in ran.stderr:
                problems.append(f"{command} {changes}: code {ran.returncode}, {ran.stderr}")
    if (folder / "none").exists():
        problems.append("a refused run must leave nothing behind")
    print(f"{len(KNOBS)} parameters, {len(REFUSED)} refusals")
    if problems:
        raise SystemExit("\n".join(problems))


if __name__ == "__main__":
    main()
