#!/usr/bin/env python3
"""Checks that the table in docs/checkpoint.md lists the contents of checkpoints of the program.

    checkpoint_page.py SOURCE_FOLDER CHECKPOINT ... [--write]     compares, or writes the table

CHECKPOINT: a file, or a folder for all of its checkpoints. No single one has every part of a model:
the platen exists during compaction, the settlement during load cycles, walls where no side is
periodic. Numbered names (sleeper_0, sleeper_1 ...) are one row with N, those of sensors one with
NAME. Every dataset needs unit and meaning.
"""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "postproc"))
from trackbed_post import read  # noqa: E402

BEGIN, END = "<!-- table -->\n", "<!-- end of table -->\n"


def rows_of(checkpoints):
    """Table rows of all {path: read.Quantity}; problems: paths without unit or meaning, and paths
    that two checkpoints describe differently. The number of columns may depend on the dimension of
    the model."""
    described, columns, odd = {}, {}, []
    for datasets in checkpoints:
        for path, item in datasets.items():
            shape = item.values.shape
            name = re.sub(r"\d+", "N", re.sub("^sensors/[^/]+/", "sensors/NAME/", path))
            columns.setdefault(name, set()).add(shape[1] if len(shape) > 1 else 1)
            label = (str(item.values.dtype), item.unit, item.meaning)
            if described.setdefault(name, label) != label:
                odd.append(f"{path} is described as {described[name]} and as {label}")
            if not item.unit or not item.meaning:
                odd.append(f"{path} has no unit or no meaning")
    rows = []
    for name, (dtype, unit, meaning) in sorted(described.items()):
        wide = " or ".join(str(number) for number in sorted(columns[name]))
        rows.append(f"| {name} | {dtype} | {wide} | {unit} | {meaning} |")
    return rows, odd


def files_of(path):
    path = pathlib.Path(path)
    return [path] if path.is_file() else sorted(path.glob("checkpoint_*.h5")) + sorted(
        path.glob("stage_*.h5"))


def table(rows):
    return "\n".join(["| dataset | type | columns | unit | meaning |", "|---|---|---|---|---|",
                      *rows]) + "\n"


def main():
    writes = "--write" in sys.argv
    root, *places = [word for word in sys.argv[1:] if word != "--write"]
    root = pathlib.Path(root)
    for place in places:
        if not files_of(place):
            sys.exit(f"{place} contains no checkpoint")
    rows, problems = rows_of([read.checkpoint(file) for place in places
                              for file in files_of(place)])
    page = root / "docs/checkpoint.md"
    text = page.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    written, after = rest.split(END)
    if writes:
        page.write_text(before + BEGIN + table(rows) + END + after, encoding="utf-8")
    elif written != table(rows):
        listed = set(written.splitlines())
        problems.append("docs/checkpoint.md is out of date (checkpoint_page.py --write updates it)")
        problems += [f"  new: {row}" for row in rows if row not in listed]
        problems += [f"  gone: {row}" for row in listed - set(table(rows).splitlines())]
    print("\n".join(problems) or f"{len(rows)} rows agree with the program")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
