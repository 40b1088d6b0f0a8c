#!/usr/bin/env python3
"""The commands of docs/tutorial.md, in order, but those of the section on transition zones, which
the test `quickstart` covers, and the bed of stones, which is stopped early.

    tutorial.py PROGRAM SOURCE_FOLDER FOLDER
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

SLOW = "inputs/track/on_bed.toml"  # stopped early: its figures cannot be drawn


def commands(text):
    """Lines of the blocks up to the section on transition zones, without comments."""
    for block in re.findall(r"^```\n(.*?)^```", text.partition("## 5.")[0], re.M | re.S):
        for line in block.splitlines():
            words = shlex.split(line, comments=True)
            if words and words[0] != "alias":
                yield words, "ends with code 2" in line


def main():
    path, source, folder = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in ("inputs", "postproc"):
        (folder / name).symlink_to(source / name)
    (folder / "build/release").mkdir(parents=True)
    (folder / "build/release/trackbed").symlink_to(path)
    count = 0
    for words, refused in commands((source / "docs/tutorial.md").read_text(encoding="utf-8")):
        code = 2 if refused else 0
        if SLOW in words:
            words, code = [*words, "output.stop_after=50"], 3
        elif "results/first/bed" in words:
            continue
        words = [{"trackbed": path, "python3": sys.executable}.get(word, word) for word in words]
        ran = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False,
                             env=os.environ)
        if ran.returncode != code:
            raise SystemExit(f"{words}: {ran.returncode}, not {code}\n{ran.stdout}{ran.stderr}")
        count += 1
    if count < 10:
        raise SystemExit(f"only {count} commands were found")
    print(f"{count} commands")


if __name__ == "__main__":
    main()
