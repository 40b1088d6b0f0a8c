#!/usr/bin/env python3
"""Every command of docs/cookbook.md that checks a deck is accepted without a warning.

    cookbook.py PROGRAM SOURCE_FOLDER FOLDER
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import program  # noqa: E402, F401  # sets the environment of programs of one rank
from part import part  # noqa: E402


def commands(text):
    """Words of the lines that check a deck and need no results of a run."""
    for block in re.findall(r"^```\n(.*?)^```", text, re.M | re.S):
        # A value in quotes may continue on the next line.
        for line in re.findall(r"(?:'[^']*'|[^'\n])+", block.replace("\\\n", "")):
            if line.startswith("trackbed check ") and not line.endswith("# run"):
                yield shlex.split(line)[1:]


def main():
    path, source, folder = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "inputs").symlink_to(source / "inputs")
    found = list(commands((source / "docs/cookbook.md").read_text(encoding="utf-8")))
    if len(found) < 40:
        raise SystemExit(f"only {len(found)} commands were found")
    for words in part(found):
        ran = subprocess.run([path, *words], cwd=folder, capture_output=True, text=True,
                             check=False, env=os.environ)
        if ran.returncode or "warning" in ran.stdout + ran.stderr:
            raise SystemExit(f"{words}: {ran.returncode}\n{ran.stdout}{ran.stderr}")
    print(f"{len(part(found))} of {len(found)} commands")


if __name__ == "__main__":
    main()
