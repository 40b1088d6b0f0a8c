#!/usr/bin/env python3
"""The fields of a run in ParaView: every part opens with the times of the run, and a picture shows
them. Debian's python3-paraview excludes python3-vtk9, which other tests need, so that it is not
installed by them; without it the test is skipped (code 77).

    paraview.py PROGRAM SOURCE_FOLDER FOLDER
"""
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys

import matplotlib.image
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402

SKIPPED = 77
PARTS = {"contacts", "ground", "stones", "surfaces", "train"}
LEAST = 0.3  # of the pixels are not white: 0.38 in this model, which is as long as it is high
TRAIN = ("stage.passage.train=true", "train.start=0", "seat.before=10")


def main():
    program, source, folder = Program(sys.argv[1]), *map(pathlib.Path, sys.argv[2:4])
    if not shutil.which("pvbatch") or not importlib.util.find_spec("paraview"):
        print("pvbatch or python3-paraview is not installed")
        sys.exit(SKIPPED)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    program.done(1, "run", source / "tests/restart/tiny.toml", "output.fields=true", *TRAIN, "-o",
                 folder / "run")
    state, picture = folder / "view.pvsm", folder / "view.png"
    words = ["xvfb-run", "-a", "pvbatch", source / "postproc/paraview/view.py", folder / "run",
             state, picture]
    ran = subprocess.run([str(word) for word in words], capture_output=True, text=True,
                         check=False, timeout=250, env=dict(os.environ))
    stated = ran.stdout + ran.stderr
    found = re.search(r"view.pvsm: (.*); (\d+) times from (\S+) to (\S+) s", stated)
    if ran.returncode != 0 or not found or "ERR|" in stated:
        sys.exit(f"pvbatch ended with {ran.returncode}:\n{stated}")
    if set(found[1].split(", ")) != PARTS or int(found[2]) != 7:
        sys.exit(f"not all parts or times: {found[0]}")
    end = summary(folder / "run")["simulated_time_s"]
    if abs(float(found[4]) - end) > 1e-4:
        sys.exit(f"the last time is {found[4]}, not {end}: {stated}")
    pixels = (255 * matplotlib.image.imread(picture)[..., :3]).astype(int)
    colours = len(np.unique(pixels.reshape(-1, 3), axis=0))
    if colours < 1000:
        sys.exit(f"{picture} has {colours} colours only")
    drawn = np.mean(pixels.min(axis=2) < 250)
    if drawn < LEAST:
        sys.exit(f"the model fills {drawn:.0%} of the picture only")
    words = state.read_text(encoding="utf-8")
    for expected in ("spheres", "contact forces", "contact force (N)", "x along the track (m)",
                     "displacement of the ground (m)"):
        if expected not in words:
            sys.exit(f"the state has no {expected}")
    print(f"{found[0]}; {colours} colours")


if __name__ == "__main__":
    main()
