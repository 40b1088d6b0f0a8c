#!/usr/bin/env python3
"""Checks contents and line widths of text files.

    words.py [SOURCE_FOLDER]

- no path of a particular machine (a home, a work or a scratch folder) in any file;
- no line beyond 100 columns in sources, scripts and decks (prose is wrapped by its viewer);
- no blanks at line ends, and a line feed at the end of each file;
- each deck below inputs/ begins with a comment that states purpose, source, ranks and run time.
Prints each breach as file:line and ends with 1 if there is any.
"""
import pathlib
import re
import sys

import tree

COLUMNS = 100
# Written such that this line does not match itself.
MACHINE_PATH = re.compile(r"(?<![\w.$}>])/(work|root|home|farm|tmp|Users|scratch)/\w")
CHECKED_WIDTH = {".cpp", ".hpp", ".py", ".sh", ".toml", ".cmake", ".txt", ".cff"}
FOREIGN = {"LICENSE"}  # a text that may not be changed
DECK_WORDS = ("purpose", "source", "ranks", "run time")


def breaches_of_text(name, text):
    for number, line in enumerate(text.splitlines(), 1):
        if MACHINE_PATH.search(line):
            yield number, "a path of a particular machine"
        if name.suffix in CHECKED_WIDTH:
            if len(line) > COLUMNS:
                yield number, f"{len(line)} columns, at most {COLUMNS}"
            if line != line.rstrip():
                yield number, "blanks at the line's end"
    if text and not text.endswith("\n"):
        yield len(text.splitlines()), "no line feed at the end of the file"


def head_of_deck(text):
    """The comment lines before the first line that is neither comment nor empty, in lower case."""
    head = []
    for line in text.splitlines():
        if line.strip() and not line.lstrip().startswith("#"):
            break
        head.append(line.lower())
    return "\n".join(head)


def breaches_of_deck(text):
    head = head_of_deck(text)
    for word in DECK_WORDS:
        if not re.search(rf"\b{word}\b[^\n]*:", head):
            yield 1, f"the head comment has no line '{word}: ...'"


def check(root):
    problems, decks = [], 0
    for name in tree.files(root):
        try:
            text = (root / name).read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue  # a picture
        found = [] if name.name in FOREIGN else list(breaches_of_text(name, text))
        if name.parts[0] == "inputs" and name.suffix == ".toml":
            decks += 1
            found += breaches_of_deck(text)
        problems += [f"{name}:{number}: {problem}" for number, problem in found]
    return problems, decks


def main():
    problems, decks = check(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve())
    print("\n".join(problems) if problems else f"no breach; {decks} decks have a head")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
