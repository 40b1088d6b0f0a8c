#!/usr/bin/env python3
"""Every deck under inputs names the JSON schema of decks in its first line, as editors expect it
(taplo, Even Better TOML), and is valid by it; changes that the program refuses are not.

    schema.py ROOT
"""
import copy
import json
import pathlib
import sys
import tomllib

import jsonschema

SCHEMA = "docs/input.schema.json"
DIRECTIVE = "#:schema "
# Changes of a valid deck that must be reported: a misspelled key, a wrong type, a wrong choice, a
# value out of range.
WRONG = ({"dem": {"safty": 0.1}}, {"train": {"speed": "fast"}}, {"dimension": "plain"},
         {"dem": {"safety": -1}})


def named_schema(deck):
    """The file that the first line names, or nothing."""
    first = deck.read_text(encoding="utf-8").splitlines()[0]
    return (deck.parent / first[len(DIRECTIVE):]).resolve() if first.startswith(DIRECTIVE) else None


def objections(root):
    schema = root / SCHEMA
    validator = jsonschema.Draft202012Validator(json.loads(schema.read_text(encoding="utf-8")))
    decks = sorted((root / "inputs").rglob("*.toml"))
    if not decks:
        yield f"there are no decks below {root / 'inputs'}"
    for deck in decks:
        if named_schema(deck) != schema.resolve():
            yield f"{deck.relative_to(root)}:1: must be `{DIRECTIVE}` and the path of {SCHEMA}"
        content = tomllib.loads(deck.read_text(encoding="utf-8"))
        for error in validator.iter_errors(content):
            yield f"{deck.relative_to(root)}: {'.'.join(map(str, error.path))}: {error.message}"
        for change in WRONG:
            changed = copy.deepcopy(content)
            for key, value in change.items():
                inner = isinstance(value, dict)
                changed[key] = {**changed.get(key, {}), **value} if inner else value
            if validator.is_valid(changed):
                yield f"{SCHEMA} accepts {deck.relative_to(root)} with {change}"


def main():
    found = list(objections(pathlib.Path(sys.argv[1])))
    print(*found, sep="\n")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
