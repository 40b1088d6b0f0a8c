#!/usr/bin/env python3
"""Runs the commands of docs/tutorial.md before its transition zone and draws its pictures.

    first_hour.py PROGRAM FOLDER [PICTURES]   the runs are in FOLDER/results/first; pictures go to
                                              PICTURES (default: docs/images)

Replaces earlier results. The test of the tutorial has the same commands and pictures.
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

import PIL.Image

ROOT = pathlib.Path(__file__).resolve().parents[1]
# Pictures of the tutorial: figures in results/first, and how much of their height is shown.
PICTURES = {"tutorial_track": ("plain/figures/track.png", 0.426),
            "tutorial_ground": ("ground/figures/envelope.png", 1),
            "tutorial_impact": ("impact/figures/curve.png", 1),
            "tutorial_bed": ("bed/figures/train.png", 1)}
COLOURS = 64  # lines and letters need no more; halves the files


def commands(text):
    """(words, whether the program refuses them) of the lines before the transition zone."""
    for block in re.findall(r"^```\n(.*?)^```", text.partition("## 5.")[0], re.M | re.S):
        for line in block.splitlines():
            words = shlex.split(line, comments=True)
            if words and words[0] != "alias":
                yield words, "ends with code 2" in line


def shown(text):
    """Names of the pictures that the tutorial shows and this script draws."""
    return set(re.findall(r"^!\[.*?\]\(images/(tutorial_\w+)\.png\)$", text, re.M))


def prepared(folder, program):
    """`folder` looks like that of the project."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "build/release").mkdir(parents=True)
    for name in ("inputs", "postproc"):
        (folder / name).symlink_to(ROOT / name)
    (folder / "build/release/trackbed").symlink_to(pathlib.Path(program).resolve())


def run(words, refused, folder, program):
    words = [{"trackbed": program, "python3": sys.executable}.get(word, word) for word in words]
    ran = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False,
                         env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
    if ran.returncode != (2 if refused else 0):
        sys.exit(f"{shlex.join(map(str, words))}: {ran.returncode}\n{ran.stdout}{ran.stderr}")


def draw(first, pictures):
    """Copies the figures of the runs in the folder `first`, with fewer colours."""
    for name, (figure, part) in PICTURES.items():
        with PIL.Image.open(first / figure) as picture:
            shown_part = picture.crop((0, 0, picture.width, round(part * picture.height)))
            shown_part.convert("RGB").quantize(COLOURS, dither=PIL.Image.Dither.NONE).save(
                pictures / f"{name}.png", optimize=True)


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit("usage: first_hour.py PROGRAM FOLDER [PICTURES]")
    program, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    prepared(folder, program)
    for words, refused in commands((ROOT / "docs/tutorial.md").read_text(encoding="utf-8")):
        run(words, refused, folder, program)
    draw(folder / "results/first",
         pathlib.Path(sys.argv[3] if sys.argv[3:] else ROOT / "docs/images"))


if __name__ == "__main__":
    main()
