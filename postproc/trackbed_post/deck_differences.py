"""What the effective decks of several runs differ by: keys, and the value of each run.

Tables of a list have their name in the key (ground.block.wedge.present), or their number from 1. Of
a table that a run does not have at all there is one row, which lists its values. A list with tables
in another order has a row with the order: later blocks overrule earlier ones. An effective deck
holds default values of sections that nobody gave: those that the stages do not use count as absent.

Effective decks hold absolute paths, which differ in another copy of the project. Files are compared
by their contents, and the states of other runs by the last parts of their paths.
"""
import collections.abc
import filecmp
import os
import pathlib
import typing

from trackbed_post import read

ABSENT = "-"
LEFT_OUT = ("title", "name")  # stated elsewhere
LONGEST = 100                 # letters of a value
BEFORE = 30                   # of these before the first letter that differs
PARTS = 3                     # of a path: .../results/quickstart/cell
STATE = ".h5"                 # of a run: its file also holds how long it took


def _has_stage(**wanted: object) -> collections.abc.Callable[[read.Deck], bool]:
    """Whether a deck has a stage with these values."""
    return lambda deck: any(all(stage.get(key) == value for key, value in wanted.items())
                            for stage in deck["stage"])


# What makes a deck with stages use a section; sections that are not listed count always.
USED = dict.fromkeys(("train", "vehicle", "track", "seat", "ballast", "under_sleeper_pad",
                      "wheel_rail", "irregularity", "irregularity_right", "passage"),
                     _has_stage(train=True)) | {
    "load": _has_stage(kind="passage", train=False), "tamping": _has_stage(kind="tamp"),
    "jump": _has_stage(kind="jump"), "footing": lambda deck: False,
    "handover": lambda deck: bool(deck["handover"].get("after"))}


def used(deck: read.Deck) -> read.Deck:
    """The deck without the sections that its stages do not use."""
    return deck if not deck.get("stage") else {
        key: value for key, value in deck.items() if key not in USED or USED[key](deck)}


def rows(decks: collections.abc.Sequence[read.Deck]) -> list[list[str]]:
    """[key, value of each deck] of all keys that are used and whose values are not the same in all
    decks."""
    return list(_differing("", [used(deck) for deck in decks]))


def is_path(value: typing.Any) -> bool:
    return isinstance(value, str) and os.path.isabs(value)


def end_of_path(path: str) -> str:
    """The last parts of an absolute path, as texts state it."""
    parts = pathlib.PurePath(path).parts[1:]
    return "/".join(parts if len(parts) <= PARTS else ("...", *parts[-PARTS:]))


def equal(first: typing.Any, second: typing.Any) -> bool:
    """Whether two values of a parameter are the same; paths are if their files have the same
    contents or, of states and folders of runs and of files that are gone, the same end."""
    if first == second or not (is_path(first) and is_path(second)):
        return bool(first == second)
    files = os.path.isfile(first) and os.path.isfile(second)
    same_end = end_of_path(first) == end_of_path(second)
    if same_end and (not files or first.endswith(STATE)):
        return True
    return files and filecmp.cmp(first, second, shallow=False)


def _differing(before: str, tables: list[typing.Any]) -> collections.abc.Iterator[list[str]]:
    for key in dict.fromkeys(key for table in tables for key in table if key not in LEFT_OUT):
        values = [table.get(key) for table in tables]
        there = [value for value in values if value is not None]
        if len(there) == len(values) and all(equal(value, there[0]) for value in there):
            continue
        tabular = [_as_table(value) for value in there]
        if all(table is not None for table in tabular) and \
                (len(there) == len(values) or all(isinstance(one, list) for one in there)):
            named = [_as_table(value) or {} for value in values]
            if any(isinstance(one, list) for one in there) and _reordered(named):
                yield [f"{before}{key} (order)", *_texts([list(one) for one in named])]
            yield from _differing(f"{before}{key}.", named)
        else:
            yield [before + key, *_texts(values)]


def _reordered(tables: list[dict[str, typing.Any]]) -> bool:
    """Whether the tables that all lists have are not in the same order in all of them."""
    common = set.intersection(*(set(one) for one in tables))
    orders = [[name for name in one if name in common] for one in tables]
    return any(order != orders[0] for order in orders)


def _as_table(value: typing.Any) -> dict[str, typing.Any] | None:
    """A table, or a list of tables by their names; None of other values."""
    if isinstance(value, dict):
        return value
    if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
        return None
    found: dict[str, typing.Any] = {}
    for number, one in enumerate(value, 1):
        name = str(one.get("name") or "-".join(str(one[key]) for key in ("first", "second")
                                               if isinstance(one.get(key), str)) or number)
        found[f"{name} ({number})" if name in found else name] = one
    return found


def _texts(values: list[typing.Any]) -> list[str]:
    """A cell for each value; long ones are cut around the first letter that differs."""
    texts = [ABSENT if value is None else _in_full(value) for value in values]
    texts[1:] = [f"{text} (other contents)" if is_path(value) and text == texts[0]
                 and not equal(value, values[0]) else text
                 for text, value in zip(texts[1:], values[1:])]
    there = [text for text, value in zip(texts, values) if value is not None]
    same = len(os.path.commonprefix(there)) if len(there) > 1 else 0
    begin = max(same - BEFORE, 0) if same >= LONGEST else 0
    return [text if len(text) <= LONGEST else
            f"{'...' if begin else ''}{text[begin:begin + LONGEST]}"
            f"{'...' if len(text) > begin + LONGEST else ''}" for text in texts]


def _in_full(value: typing.Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.9g}"
    if isinstance(value, list):
        return f"[{', '.join(map(_in_full, value))}]"
    if isinstance(value, dict):
        return ", ".join(f"{key} = {_in_full(one)}" for key, one in value.items()
                         if key not in LEFT_OUT)
    text = str(value)
    return end_of_path(text) if is_path(text) else text
