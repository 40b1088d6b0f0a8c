#!/usr/bin/env python3
"""Values near the limits of floating point are refused with a message, for every parameter;
accepted ones cause neither a broken invariant nor NaN or infinity.

    magnitudes.py PROGRAM INPUTS [--each]

All numbers of the schema at once, by deck and value; with --each, also each number of a deck
separately, at both ends of its accepted range, as the messages on all at once state it (minutes).
"""
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program  # noqa: E402

DECKS = ["track/plain.toml", "shi/short.toml", "ground/strip.toml", "bed/triaxial.toml",
         "track/two_rails_on_ground.toml", "demfem/solids.toml"]
VALUES = ["1e300", "-1e300", "1e-300", "1e25"]
# Signs of internal errors of the program; none of these words occurs in a deck.
BROKEN = re.compile(r"broken invariant|Signal|terminate called|\bnan\b|-nan|\binf\b")
ACCEPTS = re.compile(r"magnitude must be at (most|least) (\S+)")


def numbers_of(schema, deck, path=()):
    """(override, name in messages, entries of a list) of every number; lists of sections as far as
    the deck has them."""
    for key, spec in schema.get("properties", {}).items():
        here, kind = (*path, key), spec.get("type")
        if kind == "object":
            yield from numbers_of(spec, deck.get(key, {}), here)
        elif kind == "array" and spec["items"].get("type") == "object":
            for index, element in enumerate(deck.get(key, [])[:2]):
                yield from numbers_of(spec["items"], element, (*here, str(index)))
        elif kind in ("number", "integer"):
            yield ".".join(here), 0
        elif kind == "array" and spec["items"].get("type") == "number":
            yield ".".join(here), spec.get("minItems", 1)


def shown(key):
    return re.sub(r"\.(\d+)", r"[\1]", key)


def override(key, entries, value):
    return f"{key}={value if not entries else '[' + ', '.join([value] * entries) + ']'}"


def check(program, deck, *overrides):
    ran = Program(program)(1, "check", deck, *overrides, timeout=300)
    text = ran.stdout + ran.stderr
    if ran.returncode not in (0, 2) or BROKEN.search(text.replace("1e+300", "")):
        sys.exit(f"check {deck} {overrides[:3]} ended with {ran.returncode}:\n{text[-2000:]}")
    return ran.returncode, text


def all_at_once(program, deck, numbers):
    for value in VALUES:
        code, text = check(program, deck, *(override(*number, value) for number in numbers))
        if code != 2:
            sys.exit(f"{deck} is valid with {value} everywhere")
        for key, entries in numbers:
            name = shown(key) + ("[0]" if entries else "")
            # Sections and keys of other models are refused whatever their value.
            others = any(f": {one} is not a" in text for one in (key, key.split(".")[0]))
            if f"{name} = " not in text and not others:
                sys.exit(f"{deck}: {key} = {value} is not refused:\n{text[:3000]}")


def accepted_ends(program, deck, numbers):
    """Overrides with the ends of the accepted ranges that the messages state."""
    for value in ("1e300", "1e-300"):
        lines = check(program, deck, *(override(*number, value) for number in numbers))[1]
        for key, entries in numbers:
            name = shown(key) + ("[0]" if entries else "")
            for line in lines.splitlines():
                end = ACCEPTS.search(line) if f" {name} = " in line else None
                if end:
                    yield override(key, entries, end.group(2))


def one_by_one(program, deck, numbers):
    """Both ends of the accepted range, on all cores."""
    ends = sorted(set(accepted_ends(program, deck, numbers)))
    if len(ends) < 50:
        sys.exit(f"{deck}: {len(ends)} ends of ranges, there are more")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda end: check(program, deck, end), ends))


def main():
    program, inputs = sys.argv[1], pathlib.Path(sys.argv[2])
    schema = json.loads(subprocess.run([program, "schema"], capture_output=True, text=True,
                                       check=True).stdout)
    for name in DECKS:
        deck = inputs / name
        numbers = list(numbers_of(schema, tomllib.loads(deck.read_text(encoding="utf-8"))))
        if len(numbers) < 150:
            sys.exit(f"{name}: {len(numbers)} numbers, the schema has more")
        all_at_once(program, deck, numbers)
        if "--each" in sys.argv:
            one_by_one(program, deck, numbers)
    # Earlier cases of a broken invariant or of wrong results without a message.
    for value in ("1e22", "1e23", "1e25"):
        code, text = check(program, inputs / "track/plain.toml", f"pad.stiffness={value}")
        if code != 2 or "at most 1e+15 N/m" not in text:
            sys.exit(f"a pad of {value} N/m: {code}, {text}")


if __name__ == "__main__":
    main()
