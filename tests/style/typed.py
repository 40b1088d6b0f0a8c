#!/usr/bin/env python3
"""Checks the annotations of the package of postproc/ with mypy, as its pyproject.toml states.

    typed.py [SOURCE_FOLDER]

Ends with 77, by which CTest skips a test, if mypy is not installed.
"""
import importlib.util
import os
import pathlib
import subprocess
import sys

SKIPPED = 77


def check(root):
    run = subprocess.run([sys.executable, "-m", "mypy", f"--cache-dir={os.devnull}", "-p",
                          "trackbed_post"], cwd=root / "postproc", capture_output=True, text=True,
                         check=False)
    return run.returncode, run.stdout + run.stderr


def main():
    if not importlib.util.find_spec("mypy"):
        print("mypy is not installed")
        return SKIPPED
    code, report = check(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve())
    print(report, end="")
    return 1 if code else 0


if __name__ == "__main__":
    sys.exit(main())
