#!/usr/bin/env python3
"""The command `shapes`: stones written to a library and read back, their mesh, refusals.

    shapes.py PROGRAM FOLDER
"""
import json
import math
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program  # noqa: E402

BENCH = pathlib.Path(__file__).resolve().parents[2] / "inputs/bench/stones12.toml"

TETRAHEDRON = """v 0 0 0
v 30 0 0
v 0 30 0
v 0 0 30
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


def shapes(program, *words, code=0):
    ran = Program(program)(1, "shapes", *words)
    if ran.returncode != code:
        raise SystemExit(f"{words}: code {ran.returncode}, not {code}\n{ran.stdout}{ran.stderr}")
    return ran.stdout if code == 0 else ran.stderr


def rows(table):
    """{name: numbers of its row} without head and notes."""
    lines = [line.split() for line in table.splitlines()[1:] if not line.startswith(" ")]
    return {words[0]: [float(word) for word in words[1:]] for words in lines}


def near(found, wanted, relative, what):
    if abs(found - wanted) > relative * abs(wanted):
        raise SystemExit(f"{what}: {found}, not {wanted}")


def bed_of_library(program, library, folder, made):
    """A bed of stones of a library; the deck has the library's shapes; a text file is refused."""
    shown = rows(shapes(program, write_deck(folder, library)))
    if list(shown.values()) != list(rows(made).values()):
        raise SystemExit("the shapes of the deck differ from those of its library")
    short = [f"stage.{name}.duration=0.002" for name in ("fill", "settle", "rest")]
    done = subprocess.run([program, "run", folder / "deck.toml", "bed.height=0.06", *short, "-o",
                           folder / "results", "--force"], capture_output=True, text=True,
                          check=False)
    stones = json.loads((folder / "results/summary.json").read_text())["dem"]["particles"]
    if done.returncode != 0 or stones < 100:
        raise SystemExit(f"{stones} stones\n{done.stdout}{done.stderr}")
    wrong = subprocess.run([program, "run", write_deck(folder, folder / "deck.toml"), "-o",
                            folder / "none"], capture_output=True, text=True, check=False)
    if wrong.returncode != 2 or "is not a library" not in wrong.stderr:
        raise SystemExit(f"a deck must be refused as a library: {wrong.stdout}{wrong.stderr}")
    for change, reason in ((("radius", 1, 0), "shape stone_6 has edges without rounding"),
                           (("radius", 1, math.nan), "shape stone_6 has an impossible size"),
                           (("solid", (2, 0), -1), "shape stone_7 has an impossible size"),
                           (("solid", (0, 0), 100), "shape stone_5 has an impossible size"),
                           (("solid", (0, 4), 0), "shape stone_5 has an impossible size"),
                           (("faces", 1, 2**32 + 1), "faces of the stored shapes do not agree"),
                           (("pieces", 0, -1), "faces of the stored shapes do not agree"),
                           ("kind", 'is not a library of shapes (its kind is "others")'),
                           ("version", "of version 2, but this program reads version 1")):
        changed = folder / "changed.h5"
        shutil.copy(library, changed)
        with h5py.File(changed, "r+") as file:
            if isinstance(change, str):
                file.attrs[change] = np.bytes_("others") if change == "kind" else 2
            else:
                name, place, value = change
                file[f"shapes/{name}"][place] = value
        refused(program, write_deck(folder, changed), [], "bed.library",
                [f'"{changed.resolve()}" ', reason])
    refused(program, BENCH, ["bed.x=[0.0,0.2]"], "command line: bed.x",
            ["is 0.2 m and must be", "3 times"])


def refused(program, deck, changes, key, words):
    """The same message with its place from `check` and from `run`."""
    for command in ("check", "run"):
        done = Program(program)(1, command, deck, *changes)
        lines = done.stderr.splitlines()
        if done.returncode != 2 or len(lines) != 1 or key not in lines[0].split("=")[0] or \
                not all(word in lines[0] for word in words):
            raise SystemExit(f"{command} {deck} {changes} must report {words}: {done.stderr}")


def write_deck(folder, library):
    """The benchmark of stones with those of a library instead of parametric ones."""
    text = BENCH.read_text(encoding="utf-8")
    folder.mkdir(parents=True, exist_ok=True)
    deck = folder / "deck.toml"
    deck.write_text(text.replace('stone = "polyhedra"',
                                 f'stone = "library"\nlibrary = "{library.resolve()}"'),
                    encoding="utf-8")
    return deck


def proportions(program, folder, picture):
    """Table and mesh have S, I and L in the prescribed proportions; `check` reports long stones."""
    asked = ("--stones", 3, "--elongation", 0.6, "--flatness", 0.5)
    for name, row in rows(shapes(program, *asked, "--picture", picture)).items():
        thickness, width, length, greatest = row[-4:]
        near(width / length, 0.6, 1e-5, f"I/L of {name}")
        near(thickness / width, 0.5, 1e-5, f"S/I of {name}")
        if not thickness <= row[8] <= width or not length <= greatest < 1.3 * length:
            raise SystemExit(f"{name}: sieve {row[8]}, S I L and greatest extent {row[-4:]}")
    for line in picture.read_text().splitlines():
        if line.startswith("# S"):
            s, i, l = (float(word) for word in line.split()[2:7:2])
            near(i / l, 0.6, 1e-7, line)
            near(s / i, 0.5, 1e-7, line)
    scattered = {row[-3] / row[-2] for row in rows(shapes(program, *asked, "--spread",
                                                          0.2)).values()}
    if len(scattered) != 3 or max(abs(ratio - 0.6) for ratio in scattered) > 0.2:
        raise SystemExit(f"a spread of 0.2 around 0.6 makes {scattered}")
    for changes, warned in (((), False), (("bed.height=0.05", "bed.polyhedron.elongation=0.4",
                                           "bed.polyhedron.flatness=0.6"), True)):
        done = Program(program).done(1, "check", BENCH, *changes)
        if ("warning: bed: the longest stone is" in done.stdout) != warned:
            raise SystemExit(f"check {changes}: {done.stdout}")


def foreign_files(program, folder, library, picture):
    """Files that are neither a library nor a mesh of the program are kept; its own are replaced."""
    for name, option, content in (("notes.h5", "--library", b"notes"),
                                  ("empty.h5", "--library", b""),
                                  ("scan.obj", "--picture", TETRAHEDRON.encode()),
                                  ("picture.h5", "--library", picture.read_bytes()),
                                  ("library.obj", "--picture", library.read_bytes())):
        place = folder / name
        place.write_bytes(content)
        reported = shapes(program, "--stones", 1, option, place, code=2)
        if f"{place}: exists, but is not a" not in reported or place.read_bytes() != content:
            raise SystemExit(f"{option} {name}: {reported}")
    for option, place in (("--library", library), ("--picture", picture)):
        before = place.read_bytes()
        shapes(program, "--stones", 2, option, place)
        if place.read_bytes() == before:
            raise SystemExit(f"{place} was not replaced")


def full_disk(program, folder, option, place):
    """A limited file size simulates a full disk. The mesh is read through a pipe, on which the
    program waits meanwhile, as MPI itself starts with larger files."""
    pipe, before = folder / "pipe.obj", place.read_bytes()
    pipe.unlink(missing_ok=True)
    os.mkfifo(pipe)
    with subprocess.Popen([program, "shapes", pipe, "--unit", "0.001", option, place],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          preexec_fn=lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN)) as run:
        with open(pipe, "w", encoding="utf-8") as mesh:
            resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (1000, 1000))
            mesh.write(TETRAHEDRON)
        out, err = run.communicate(timeout=60)
    if run.returncode != 4 or f"{place}.part: " not in err or "File too large" not in err:
        raise SystemExit(f"{option}: a full disk must end with 4: {run.returncode}\n{out}{err}")
    if place.read_bytes() != before or list(folder.glob("*.part")):
        raise SystemExit(f"{option}: the old file must be kept on a full disk: {err}")


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    library, picture, mesh = folder / "stones.h5", folder / "stones.obj", folder / "tetra.obj"
    for file in (library, picture):
        file.unlink(missing_ok=True)
    made = shapes(program, "--stones", 3, "--vertices", 12, "--seed", 5, "--library", library)
    if shapes(program, library) != made:
        raise SystemExit("a library differs from what was written into it")
    if list(rows(made)) != ["stone_5", "stone_6", "stone_7"]:
        raise SystemExit(f"names: {list(rows(made))}")
    if any(row[:3] != [1, 12, 20] for row in rows(made).values()):
        raise SystemExit(f"12 corners must give 20 triangles\n{made}")

    bed_of_library(program, library, folder / "bed", made)

    # The mesh of one stone is closed: read again it has the same volume, except for the
    # approximation of the rounding by triangles.
    one = rows(shapes(program, "--stones", 1, "--rounding", 0.02, "--picture",
                      picture))["stone_1"]
    again = rows(shapes(program, picture, "--rounding", 0, "--vertices", 200))["stones"]
    near(again[3], one[3], 0.005, "volume of the mesh")
    near(again[8], one[8], 0.01, "sieve size of the mesh")

    # Layers of a deck are listed with their names.
    section = pathlib.Path(__file__).resolve().parents[2] / "inputs/bed/section.toml"
    layered = folder / "layered.toml"
    layered.write_text(section.read_text() + '\n[[bed.layer]]\nname = "sub"\nstone = "polyhedra"\n'
                       'height = 0.1\nshapes = 3\nporosity = 0.4\n')
    names = rows(shapes(program, layered))
    if sum(name.startswith("layered_sub_") for name in names) != 3 or "layered_0" not in names:
        raise SystemExit(f"shapes of layers: {list(names)}")

    proportions(program, folder, picture)
    foreign_files(program, folder, library, picture)
    for option, place in (("--library", library), ("--picture", picture)):
        full_disk(program, folder, option, place)

    mesh.write_text(TETRAHEDRON)
    tetrahedron = rows(shapes(program, mesh, "--unit", 0.001, "--rounding", 0))["tetra"]
    near(tetrahedron[3], 4.5, 1e-3, "cm3 of a corner of a cube of 30 mm")
    near(rows(shapes(program, mesh, "--unit", 0.001))["tetra"][3], 4.5, 1e-3, "cm3, rounded")
    if "is --unit right" not in shapes(program, mesh):
        raise SystemExit("a stone of 30 m must give a warning")
    clump = shapes(program, mesh, "--unit", 0.001, "--spheres", 20)
    if rows(clump)["tetra"][0] != 20 or " %, their surface by " not in clump:
        raise SystemExit(clump)
    mesh.write_text(TETRAHEDRON.replace("f 2 3 4\n", ""))
    empty = folder / "empty.obj"
    empty.write_bytes(b"")
    (folder / "folder.obj").mkdir(exist_ok=True)
    for words, reason in (([mesh], "not closed"),
                          ([folder / "none.stl"], "none.stl: does not exist"),
                          ([empty], "empty.obj: is empty"),
                          ([folder / "folder.obj"], "folder.obj: is a folder"),
                          ([mesh, "--unit", 0], "--unit = 0 must be above 0"),
                          ([mesh, "--unit", "nan"], "must be above 0"),
                          (["--stones", 2, "--spheres", 10], "--spheres is for meshes"),
                          (["--stones", 2, "--unit", 1], "--unit is for meshes"),
                          ([mesh, "--seed", 2], "--seed is for parametric stones"),
                          ([mesh, "--spheres", 9, "--parts", 2], "give only one of these options"),
                          ([mesh, "--spheres", 9, "--rounding", 0],
                           "--rounding is for parametric stones"),
                          ([folder / "none.h5"], "library"), ([mesh.with_suffix(".txt")], ".stl"),
                          ([], "no shapes"),
                          (["--stones", 1, "--picture", "stones.gif"], ".obj"),
                          (["--stones", 1, "--library", "stones.txt"], "end in .h5"),
                          (["--stones", 1, "--library", "s.h5", "--rounding", 0],
                           "stones without rounding"),
                          (["--stones", 1, "--seed", -4], "--seed")):
        reported = shapes(program, *words, code=2)
        if reason not in reported:
            raise SystemExit(f"{words}: '{reason}' is not in '{reported}'")
    print("shapes: library, picture, meshes and refusals as expected")


if __name__ == "__main__":
    main()
