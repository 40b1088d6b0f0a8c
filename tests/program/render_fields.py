#!/usr/bin/env python3
"""Opens every field file of a run in VTK, draws it, and wants to see something in the pictures.

    render_fields.py FIELDS PICTURES

Every file must open with cells in it. Of each kind (stones, contacts, ground) at least one picture
must have more than one colour: at rest a field may well be the same everywhere.
"""
import collections
import pathlib
import re
import subprocess
import sys

RENDER = pathlib.Path(__file__).resolve().parents[2] / "postproc/render.py"
KINDS = {"stones", "contacts", "ground"}


def colours_of(path, picture):
    run = subprocess.run([sys.executable, RENDER, path, "-o", picture], capture_output=True,
                         text=True, check=False)
    found = re.search(r"(\d+) cells, (\d+) colours", run.stdout)
    if not found or int(found[1]) == 0:
        raise SystemExit(f"{path} gives no picture: {run.stdout}{run.stderr}")
    return int(found[2])


def main():
    fields, pictures = (pathlib.Path(name) for name in sys.argv[1:3])
    pictures.mkdir(parents=True, exist_ok=True)
    most = collections.Counter()
    for path in sorted(fields.glob("*.vtkhdf")):
        kind = path.stem.rsplit("_", 1)[1]
        most[kind] = max(most[kind], colours_of(path, pictures / f"{path.stem}.png"))
    print(dict(most))
    missing = KINDS - set(most)
    flat = [kind for kind, colours in most.items() if colours < 2]
    if missing or flat:
        raise SystemExit(f"no file of {sorted(missing)}, nothing to see in {flat}")


if __name__ == "__main__":
    main()
