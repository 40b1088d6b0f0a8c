#!/usr/bin/env python3
"""jobs/gallery.sh draws the pictures that docs/gallery.md shows, but those of other scripts.

    gallery.py SOURCE_FOLDER FOLDER
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys


def main():
    source, folder = map(pathlib.Path, sys.argv[1:3])
    shutil.rmtree(folder, ignore_errors=True)
    shown = re.findall(r"^!\[.*?\]\(images/(.*?)\.png\)", (source / "docs/gallery.md").read_text(
        encoding="utf-8"), re.M)
    ran = subprocess.run([source / "jobs/gallery.sh", folder], capture_output=True, text=True,
                         check=False, env={**os.environ, "RANKS": "2"})
    if ran.returncode:
        raise SystemExit(f"code {ran.returncode}\n{ran.stdout[-3000:]}\n{ran.stderr[-3000:]}")
    drawn = {path.stem for path in (folder / "pictures").glob("*.png")}
    wanted = set(shown) - {"quickstart_model", "quickstart", "train_on_bed", "bridge"}
    if drawn != wanted or len(drawn) < 5:
        raise SystemExit(f"drawn: {sorted(drawn)}; shown: {sorted(wanted)}")


main()
