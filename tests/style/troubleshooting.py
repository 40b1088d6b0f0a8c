#!/usr/bin/env python3
"""Every message that docs/troubleshooting.md quotes is in a source.

    troubleshooting.py SOURCE_FOLDER

A quotation is what stands in back quotes in the first column; `...` divides it into parts. Messages
of other programs are those of rows that name mpirun there.
"""
import pathlib
import re
import sys

import tree

FOLDERS = ("src", "include", "postproc", "jobs")
SUFFIXES = (".cpp", ".hpp", ".py")
FOREIGN = "mpirun"
LEAST = 4  # letters of a part that says something
ADJACENT = re.compile(r'"\s*\n?\s*f?"')  # the parts of a text over several lines


def sources(root):
    """The texts of all sources, with one blank between words."""
    texts = ((root / name).read_text(encoding="utf-8") for name in tree.files(root)
             if name.parts[0] in FOLDERS and name.suffix in SUFFIXES)
    return re.sub(r"\s+", " ", ADJACENT.sub("", "\n".join(texts))).replace('\\"', '"')


def quoted(document):
    """(number of the line, part of a message) of each quotation."""
    for number, line in enumerate(document.splitlines(), 1):
        symptom = line.split(" | ")[0]
        if not symptom.startswith("| ") or FOREIGN in symptom:
            continue
        for message in re.findall(r"`([^`]+)`", symptom):
            parts = (part.strip('" ') for part in message.split("..."))
            yield from ((number, part) for part in parts if len(part) >= LEAST)


def check(root):
    """(problems, number of parts)."""
    name, text = "docs/troubleshooting.md", sources(root)
    parts = list(quoted((root / name).read_text(encoding="utf-8")))
    return [f"{name}:{number}: no source has \"{part}\""
            for number, part in parts if part not in text], len(parts)


def main():
    problems, count = check(pathlib.Path(sys.argv[1]))
    print("\n".join(problems) or f"the sources have all {count} parts of messages")
    return 1 if problems or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
