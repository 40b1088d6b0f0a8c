#!/usr/bin/env python3
"""Checks the layout of all C++ files with clang-format and the rules in .clang-format.

    format.py [SOURCE_FOLDER]

`clang-format -i FILE` corrects what it reports.
"""
import pathlib
import re
import subprocess
import sys

import tree


def check(root):
    names = [str(name) for name in tree.files(root) if name.suffix in (".cpp", ".hpp")]
    if not names:
        return 1, "no C++ file found"
    run = subprocess.run(["clang-format", "--dry-run", "-Werror", *names], cwd=root,
                         capture_output=True, text=True, check=False)
    wrong = {}  # file -> line of its first breach
    for file, line in re.findall(r"^(\S+?):(\d+):\d+: error", run.stderr, re.MULTILINE):
        wrong.setdefault(file, line)
    report = [f"{file}:{line}: differs from the layout of clang-format"
              for file, line in wrong.items()]
    if run.returncode and not report:
        report = [run.stderr]
    sound = f"{len(names)} files have the layout of .clang-format"
    return run.returncode, "\n".join(report) or sound


def main():
    code, report = check(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve())
    print(report)
    return 1 if code else 0


if __name__ == "__main__":
    sys.exit(main())
