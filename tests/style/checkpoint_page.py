#!/usr/bin/env python3
"""Checks that the table in docs/checkpoint.md lists what a checkpoint of the program holds.

    checkpoint_page.py CHECKPOINT SOURCE_FOLDER            compares; CHECKPOINT: file or its folder
    checkpoint_page.py CHECKPOINT SOURCE_FOLDER --write    writes the table

Numbered names (sleeper_0, sleeper_1 ...) are one row with N. Every dataset needs unit and meaning.
"""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "postproc"))
import read  # noqa: E402

BEGIN, END = "<!-- table -->\n", "<!-- end of table -->\n"


def rows_of(datasets):
    """Table rows of {path: read.Quantity}, and the paths of those without unit or meaning."""
    rows, unlabelled = {}, []
    for path, item in datasets.items():
        shape = item.values.shape
        columns = shape[1] if len(shape) > 1 else 1
        name = re.sub(r"\d+", "N", path)
        rows.setdefault(name, f"| {name} | {item.values.dtype} | {columns} | {item.unit} | "
                              f"{item.meaning} |")
        if not item.unit or not item.meaning:
            unlabelled.append(path)
    return [rows[name] for name in sorted(rows)], unlabelled


def table(rows):
    return "\n".join(["| dataset | type | columns | unit | meaning |", "|---|---|---|---|---|",
                      *rows]) + "\n"


def main():
    checkpoint, root = sys.argv[1], pathlib.Path(sys.argv[2])
    rows, unlabelled = rows_of(read.checkpoint(checkpoint))
    problems = [f"{path} has no unit or no meaning" for path in unlabelled]
    page = root / "docs/checkpoint.md"
    text = page.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    written, after = rest.split(END)
    if "--write" in sys.argv[3:]:
        page.write_text(before + BEGIN + table(rows) + END + after, encoding="utf-8")
    elif written != table(rows):
        listed = set(written.splitlines())
        problems.append("docs/checkpoint.md is out of date (checkpoint_page.py --write mends it)")
        problems += [f"  new: {row}" for row in rows if row not in listed]
        problems += [f"  gone: {row}" for row in listed - set(table(rows).splitlines())]
    print("\n".join(problems) or f"{len(rows)} rows are as the program writes them")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
