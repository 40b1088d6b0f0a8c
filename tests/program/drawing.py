#!/usr/bin/env python3
"""`check --draw FILE` draws the model of a deck to scale: sleepers, blocks, wheels, stones; a file
that cannot be written is reported.

    drawing.py PROGRAM INPUTS FOLDER
"""
import pathlib
import shutil
import sys
import tomllib
import xml.etree.ElementTree as ET

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from program import Program, expect  # noqa: E402

SVG = "{http://www.w3.org/2000/svg}"
# Fills of a sleeper on stones, of the uppermost layer and of a structure.
SLEEPER, LAYER, STRUCTURE = "#5b4636", "#e8dcc0", "#9aa0a6"
PIXEL = 0.02                           # two coordinates rounded to 0.01, and the scale


class Drawing:
    def __init__(self, program, ranks, deck, file):
        self.ran = program.done(ranks, "check", deck, "--draw", file)
        self.root = ET.parse(file).getroot()
        expect(f"drawing: {file}" in self.ran.stdout, "the report names the drawing", self.ran)

    def polygons(self, fill):
        """Lowest and highest x of the polygons with this fill, pixels."""
        found = []
        for part in self.root.iter(f"{SVG}polygon"):
            if part.get("fill") == fill:
                x = [float(point.split(",")[0]) for point in part.get("points").split()]
                found.append((min(x), max(x)))
        return found

    def circles(self):
        return [(float(part.get("cx")), float(part.get("r")))
                for part in self.root.iter(f"{SVG}circle")]

    def texts(self):
        return " | ".join(part.text or "" for part in self.root.iter(f"{SVG}text"))

    def expect_near(self, found, wanted, what):
        expect(abs(found - wanted) < PIXEL, f"{what}: {found}, not {wanted} pixels", self.ran)


def check_transition(program, deck, folder):
    """On two ranks: 27 sleepers 0.6 m apart, and the structure over its 2 m of the 17 m of ground.
    """
    drawing = Drawing(program, 2, deck, folder / "transition.svg")
    given = tomllib.loads(deck.read_text(encoding="utf-8"))
    low, high = drawing.polygons(LAYER)[0]
    metre = (high - low) / (given["ground"]["x"][1] - given["ground"]["x"][0])
    sleepers = sorted(drawing.polygons(SLEEPER))
    expect(len(sleepers) == given["sleepers"]["count"], f"{len(sleepers)} sleepers", drawing.ran)
    middles = [sum(sleeper) / 2 for sleeper in sleepers]
    drawing.expect_near(middles[0] - low, given["sleepers"]["first"] * metre, "first sleeper")
    drawing.expect_near((middles[-1] - middles[0]) / (len(middles) - 1),
                        given["sleepers"]["spacing"] * metre, "distance of sleepers")
    block = next(b for b in given["ground"]["block"] if b["name"] == "structure")
    ends = drawing.polygons(STRUCTURE)[0]
    drawing.expect_near(ends[1] - ends[0],
                        (max(block["outline"][::2]) - min(block["outline"][::2])) * metre,
                        "length of the structure")
    for name in [layer["name"] for layer in given["ground"]["layer"]] + ["structure", "wedge, "]:
        expect(name in drawing.texts(), f"the drawing must name {name}", drawing.ran)


def check_roles(program, deck, folder):
    """A deck states which blocks are structures; report and drawing agree."""
    wedge, surface = "ground.block.wedge.", "ground.block.wedge_surface."
    for name, words, count, reach in (
            ("stated", [f"{surface}role=structure"], 2, 15),
            ("measure", [f"{surface}role=measure"], 1, 2),
            ("buried", [f"{wedge}young=30e9"], 1, 2),  # no part of a structure at the surface
            ("standing", [f"{wedge}young=30e9", f"{surface}young=30e9"], 3, 15),
            ("absent", [f"{surface}role=structure", f"{surface}present=false"], 1, 2)):
        file = folder / f"{name}.svg"
        ran = program.done(1, "check", deck, *words, "--draw", file)
        grey = [part for part in ET.parse(file).getroot().iter(f"{SVG}polygon")
                if part.get("fill") == STRUCTURE]
        expect(len(grey) == count and f"structure up to x = {reach} m" in ran.stdout,
               f"{words} makes {count} blocks structures, up to {reach} m", ran)
    ran = program.done(1, "check", deck, "ground.block.structure.role=measure")
    expect("no block at the surface is a structure" in ran.stdout, "no structure left", ran)


def check_train(program, deck, folder):
    """Four wheels of 0.46 m at the distances of their axles, four dark sleepers on stones. The
    rounding of the radius to 0.01 of 16 pixels is 5 mm in 16 m."""
    drawing = Drawing(program, 1, deck, folder / "train.svg")
    wheels = sorted(drawing.circles())
    metre = wheels[0][1] / 0.46
    expect(len(wheels) == 4, f"{len(wheels)} wheels", drawing.ran)
    gaps = [(b[0] - a[0]) / metre for a, b in zip(wheels, wheels[1:])]
    # Iwnicki 1998: bogies with axles 2.56 m apart, centres 19 m apart.
    for found, wanted in zip(gaps, (2.56, 19 - 2.56, 2.56)):
        expect(abs(found - wanted) < 0.01, f"axles {gaps} m apart", drawing.ran)
    expect(len(drawing.polygons(SLEEPER)) == 4, "sleepers on stones", drawing.ran)
    expect("manchester_1" in drawing.texts() and "216 km/h" in drawing.texts(), "train",
           drawing.ran)


def check_others(program, inputs, folder):
    stack = Drawing(program, 1, inputs / "verify/stack.toml", folder / "stack.svg")
    for name in ("low", "middle", "top"):
        expect(name in stack.texts(), f"the drawing must name the stone {name}", stack.ran)
    strip = Drawing(program, 1, inputs / "ground/strip.toml", folder / "strip.svg")
    expect("strip, 80 kPa" in strip.texts(), "the pressure must be named", strip.ran)
    coaches = Drawing(program, 1, inputs / "track/netirail.toml", folder / "coaches.svg")
    expect("vehicles at the end of the train are not drawn" in coaches.texts(),
           "a long train is cut", coaches.ran)


def check_refused(program, deck, folder):
    ran = program(1, "check", deck, "--draw", folder / "model.png")
    expect(ran.returncode == 2 and "ends in .svg" in ran.stderr,
           "only SVG is written", ran)
    ran = program(1, "check", deck, "--draw", folder / "none/model.svg")
    expect(ran.returncode == 4 and "none/model.svg cannot be written" in ran.stderr,
           "a missing folder is reported", ran)
    ran = program(1, "check", deck, "train.speed=-1", "--draw", folder / "bad.svg")
    expect(ran.returncode == 2 and not (folder / "bad.svg").exists(),
           "a deck that is not valid is not drawn", ran)


def main():
    program, inputs, folder = (Program(sys.argv[1]), pathlib.Path(sys.argv[2]),
                               pathlib.Path(sys.argv[3]))
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_transition(program, inputs / "shi/transition.toml", folder)
    check_roles(program, inputs / "shi/transition.toml", folder)
    check_train(program, inputs / "track/on_bed.toml", folder)
    check_others(program, inputs, folder)
    check_refused(program, inputs / "track/plain.toml", folder)


if __name__ == "__main__":
    main()
