#!/usr/bin/env python3
"""Searches the tree for terms that docs/glossary.md does not use.

    glossary.py [SOURCE_FOLDER] [PATH_PREFIX...]

Reads the last table of the glossary: pattern, term to use, scope. Prints each breach as file:line
with the term to use, and ends with 1 if there is any. With prefixes only files below them count.
"""
import io
import pathlib
import re
import sys
import tokenize

import tree

SEARCHED = {".cpp", ".hpp", ".py", ".sh", ".toml", ".md", ".cmake", ".txt"}
# The table itself, decision records, and documents that are generated from other files.
LEFT_OUT = ("docs/glossary.md", "docs/decisions/", "docs/input.", "docs/verification.md",
            "CHANGELOG.md", "tests/style/glossary.py", "tests/style/test_checks.py")
OF_THE_GROUND = ("src/fem", "include/trackbed/fem", "tests/unit/fem", "tests/verify/ground",
                 "docs/ground.md")
COMMENT = re.compile(r"//.*|/\*.*?\*/")
STRING = re.compile(r'"(?:[^"\\]|\\.)*"')
ROW = re.compile(r"^\| `(.+)` \| (.+) \| ([a-z ]+) \|$")


class Term:
    def __init__(self, pattern, instead, scope):
        self.instead, self.scope = instead, set(scope.split())
        pattern = pattern.replace("\\|", "|")  # escaped in tables of Markdown
        self.found = re.compile(rf"(?<![\w`:])(?:{pattern})(?![\w`])", re.IGNORECASE)


def terms_of(glossary):
    rows = (ROW.match(line) for line in glossary.read_text(encoding="utf-8").splitlines())
    return [Term(*row.groups()) for row in rows if row]


def split_cpp(line):
    """(code, text) of a line: comments and strings are text."""
    text = " ".join(STRING.findall(line))
    code = STRING.sub('""', line)
    text += " " + " ".join(COMMENT.findall(code))
    return COMMENT.sub("", code), text


def split_python(source):
    """(code, text) of each line."""
    lines = source.splitlines()
    code, text = [""] * (len(lines) + 1), [""] * (len(lines) + 1)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        to = text if token.type in (tokenize.COMMENT, tokenize.STRING) else code
        for k, part in enumerate(token.string.split("\n")):
            to[min(token.start[0] - 1 + k, len(lines))] += " " + part
    return list(zip(code, text))


def split(name, source):
    if name.suffix in (".cpp", ".hpp"):
        return [split_cpp(line) for line in source.splitlines()]
    if name.suffix == ".py":
        return split_python(source)
    return [("", line) for line in source.splitlines()]


def breaches(terms, name, source):
    ground = str(name).startswith(OF_THE_GROUND)
    for number, (code, text) in enumerate(split(name, source), 1):
        for term in terms:
            searched = [code] if "code" in term.scope else []
            searched += [text] if "text" in term.scope else []
            if "fem" in term.scope and ground:
                searched = [code, text]
            for part in searched:
                for found in term.found.finditer(part):
                    yield number, f'"{found[0]}": {term.instead}'


def check(root, prefixes=()):
    terms, problems = terms_of(root / "docs/glossary.md"), []
    for name in tree.files(root):
        if name.suffix not in SEARCHED or str(name).startswith(LEFT_OUT):
            continue
        if prefixes and not str(name).startswith(tuple(prefixes)):
            continue
        source = (root / name).read_text(encoding="utf-8")
        problems += [f"{name}:{number}: {what}" for number, what in breaches(terms, name, source)]
    return problems, len(terms)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    problems, terms = check(root, sys.argv[2:])
    print("\n".join(problems) if problems else f"none of {terms} terms is used")
    return 1 if problems or terms == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
