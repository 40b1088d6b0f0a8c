#!/usr/bin/env python3
"""The commands of docs/tutorial.md, in order, but those of the section on transition zones, which
the test `quickstart` covers, and the bed of stones, which is stopped early. They draw the figures
that jobs/first_hour.py makes the tutorial's pictures of.

    tutorial.py PROGRAM SOURCE_FOLDER FOLDER
"""
import os
import pathlib
import subprocess
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[levels] / folder)
                for levels, folder in ((1, "support"), (2, "jobs"))]
import first_hour  # noqa: E402
import program  # noqa: E402, F401  # sets the environment of programs of one rank

SLOW = "inputs/track/on_bed.toml"  # stopped early: its figures cannot be drawn
LARGEST = 150e3  # bytes of a picture


def check_pictures(source, text, first):
    """The pictures that are shown are those that the script draws, small, and of these runs."""
    if first_hour.shown(text) != set(first_hour.PICTURES):
        raise SystemExit(f"shown: {first_hour.shown(text)}; drawn: {set(first_hour.PICTURES)}")
    for name, (figure, _) in first_hour.PICTURES.items():
        picture = source / f"docs/images/{name}.png"
        if picture.stat().st_size > LARGEST:
            raise SystemExit(f"{picture} has {picture.stat().st_size} bytes, at most {LARGEST:g}")
        if not figure.startswith("bed/") and not (first / figure).is_file():
            raise SystemExit(f"the tutorial does not draw {figure}")


def main():
    path, source, folder = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    first_hour.prepared(folder, path)
    text = (source / "docs/tutorial.md").read_text(encoding="utf-8")
    count = 0
    for words, refused in first_hour.commands(text):
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
    check_pictures(source, text, folder / "results/first")
    print(f"{count} commands")


if __name__ == "__main__":
    main()
