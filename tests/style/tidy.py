#!/usr/bin/env python3
"""Checks the sources of the program with clang-tidy and the profile in .clang-tidy.

    tidy.py SOURCE_FOLDER BUILD_FOLDER [PART_OF_A_FILE_NAME...]

BUILD_FOLDER is configured for it and holds no objects. Files of a module are checked as one, as
they are compiled.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys

CONFIGURE = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON",
             "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON", "-DBUILD_TESTING=OFF"]


def problems_of(unit, root, build):
    """Messages on one unit, without the code they quote."""
    profile = f"--config-file={root}/.clang-tidy"
    run = subprocess.run(["clang-tidy", "--quiet", profile, "-p", build, unit,
                          "--extra-arg=-Wno-unknown-warning-option"],
                         capture_output=True, text=True, check=False)
    found = re.findall(r"^\S+:\d+:\d+: (?:error|warning): .*", run.stdout, re.MULTILINE)
    if run.returncode and not found:
        found = [f"{unit}: clang-tidy ended with {run.returncode}: {run.stdout}{run.stderr}"]
    return found


def main():
    root, build = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    subprocess.run(["cmake", "-S", root, "-B", build, *CONFIGURE], check=True,
                   stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", build, "--target", "trackbed_commit"], check=True,
                   stdout=subprocess.DEVNULL)  # a header that one file includes
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    units = [command["file"] for command in commands
             if not sys.argv[3:] or any(part in command["file"] for part in sys.argv[3:])]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = sorted({one for many in pool.map(lambda unit: problems_of(unit, root, build), units)
                        for one in many})
    print("\n".join(line.replace(f"{root}/", "") for line in found)
          or f"clang-tidy has no objection to {len(units)} units")
    return 1 if found or not units else 0


if __name__ == "__main__":
    sys.exit(main())
