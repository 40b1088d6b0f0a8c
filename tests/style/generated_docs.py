#!/usr/bin/env python3
"""Checks that docs/input.md and docs/input.schema.json are what the program says of itself.

    generated_docs.py PROGRAM SOURCE_FOLDER            compares, shows the first differences
    generated_docs.py PROGRAM SOURCE_FOLDER --write    writes them (CMake target `docs`)
"""
import difflib
import json
import pathlib
import subprocess
import sys

PAGES = {"docs/input.md": "describe", "docs/input.schema.json": "schema"}
SHOWN_LINES = 40


def said_by(program, command):
    run = subprocess.run([program, command], capture_output=True, text=True, check=False)
    if run.returncode or not run.stdout:
        raise SystemExit(f"{program} {command} ended with {run.returncode}: {run.stderr}")
    return run.stdout


def differences(page, said, path):
    written = path.read_text(encoding="utf-8") if path.exists() else ""
    if written == said:
        return []
    lines = difflib.unified_diff(written.splitlines(), said.splitlines(), page, "the program",
                                 lineterm="", n=0)
    return [f"{page} is out of date; build the target `docs` and commit:",
            *list(lines)[:SHOWN_LINES]]


def main():
    program, root, write = sys.argv[1], pathlib.Path(sys.argv[2]), "--write" in sys.argv[3:]
    problems = []
    for page, command in PAGES.items():
        said = said_by(program, command)
        if page.endswith(".json"):
            json.loads(said)  # raises if it is none
        if write:
            (root / page).write_text(said, encoding="utf-8")
        problems += differences(page, said, root / page)
    print("\n".join(problems) or "the pages say what the program says")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
