#!/usr/bin/env python3
"""Each document docs/studies/NAME/README.md is the one that its numbers give, shows pictures that
exist, and states which version of the program made the numbers.

    study_documents.py SOURCE_FOLDER FOLDER
"""
import importlib
import pathlib
import re
import shutil
import subprocess
import sys


def check(source, name, folder):
    kept, made = source / "docs/studies" / name, folder / name
    made.mkdir()
    for file in ("numbers.csv", "lines.csv"):
        shutil.copy(kept / file, made)
    subprocess.run([sys.executable, source / "jobs/study.py", "--document", name, made], check=True)
    text = (made / "README.md").read_text(encoding="utf-8")
    if text != (kept / "README.md").read_text(encoding="utf-8"):
        raise SystemExit(f"docs/studies/{name}/README.md is not what its numbers give; write it "
                         f"with jobs/study.py --document {name} docs/studies/{name}")
    shown = set(re.findall(r"!\[.*?\]\((.*?)\)", text))
    drawn = {path.name for path in made.glob("*.png")}
    stored = {path.name for path in kept.glob("*.png")}
    if not shown == drawn == stored:
        raise SystemExit(f"{name}: shown {shown}, drawn {drawn}, stored {stored}")
    version = re.search(r"\((trackbed\s[^()]*)\)", text)
    commits = re.findall(r"commit\s([^;\s]+)", version[1]) if version else []
    if not commits or not all(re.fullmatch("[0-9a-f]{7,}", commit) for commit in commits):
        raise SystemExit(f"{name}: no version of an unchanged commit in {text[:2000]}")


def main():
    source, folder = map(pathlib.Path, sys.argv[1:3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    sys.path.insert(0, str(source / "jobs"))
    names = importlib.import_module("study").STUDIES
    if {path.name for path in (source / "docs/studies").iterdir()} != set(names):
        raise SystemExit(f"docs/studies must have a folder for each of {names}, and no others")
    for name in names:
        check(source, name, folder)


if __name__ == "__main__":
    main()
