#!/usr/bin/env python3
"""Opens the field files of a stage in VTK, draws them, and checks that the pictures have contents.

    render_fields.py FIELDS STAGE PICTURES

Requires a file of each kind (stones, contacts, ground) with cells, and a picture with more than one
colour. Then the whole run is drawn: a picture of all parts, and a film with a picture for each of
its instants.
"""
import pathlib
import re
import subprocess
import sys

from PIL import Image

RENDER = pathlib.Path(__file__).resolve().parents[2] / "postproc"
KINDS = {"stones", "contacts", "ground"}
TOGETHER = "stones surfaces ground"  # at the end of the run, which has no train


def colours_of(path, picture):
    run = subprocess.run([sys.executable, RENDER, "still", path, "-o", picture],
                         capture_output=True, text=True, check=False)
    found = re.search(r"(\d+) cells; the picture has (\d+) different colours", run.stdout)
    if not found or int(found[1]) == 0:
        raise SystemExit(f"{path} gives no picture: {run.stdout}{run.stderr}")
    return int(found[2])


def draw(*words):
    run = subprocess.run([sys.executable, RENDER, *words], capture_output=True, text=True,
                         check=False)
    if run.returncode:
        raise SystemExit(f"{words}: {run.returncode} {run.stdout}{run.stderr}")
    return run.stdout


def draw_whole(run, pictures):
    stated = draw("still", run, "-o", pictures / "all.png")
    if TOGETHER not in stated:
        raise SystemExit(f"a picture of all parts has not {TOGETHER}: {stated}")
    draw("film", run, "-o", pictures / "film.gif", "--view", "corner")
    instants = len(list((run / "fields").glob("*_stones.hdf")))
    with Image.open(pictures / "film.gif") as film:
        if film.n_frames != instants:
            raise SystemExit(f"the film has {film.n_frames} pictures of {instants} instants")


def main():
    fields, stage, pictures = pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    pictures.mkdir(parents=True, exist_ok=True)
    colours = {path.stem.rsplit("_", 1)[1]: colours_of(path, pictures / f"{path.stem}.png")
               for path in sorted(fields.glob(f"{stage}_*.hdf"))}
    print(colours)
    missing = KINDS - set(colours)
    flat = [kind for kind, found in colours.items() if found < 2]
    if missing or flat:
        raise SystemExit(f"no file of {sorted(missing)}, pictures of one colour {flat}")
    draw_whole(fields.parent, pictures)


if __name__ == "__main__":
    main()
