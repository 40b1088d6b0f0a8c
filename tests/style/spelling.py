#!/usr/bin/env python3
"""Searches the tree for common misspellings with codespell.

    spelling.py [SOURCE_FOLDER]
"""
import pathlib
import subprocess
import sys

import tree

SUFFIXES = {".md", ".cpp", ".hpp", ".py", ".sh", ".toml", ".txt", ".cmake", ".cff"}
# Names, terms of mechanics, and misspelt keys that tests of messages need.
KNOWN = ["cleary", "strack", "yau", "precice", "statics", "tread", "hertzs", "nam", "safty",
         "titel", "laod"]


def check(root):
    names = [str(name) for name in tree.files(root) if name.suffix in SUFFIXES]
    ran = subprocess.run(["codespell", "--ignore-words-list", ",".join(KNOWN), *names], cwd=root,
                         capture_output=True, text=True, check=False)
    if ran.returncode not in (0, 65):
        return [f"codespell ended with {ran.returncode}: {ran.stderr}"], len(names)
    return ran.stdout.splitlines(), len(names)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    problems, count = check(root)
    print("\n".join(problems) if problems else f"no misspelling in {count} files")
    return 1 if problems or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
