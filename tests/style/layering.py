#!/usr/bin/env python3
"""Checks every #include of src/ and include/ against the table of rooms in docs/architecture.md.

    layering.py [SOURCE_FOLDER]

Three rules: a room includes only the rooms its row lists; a room's private headers (src/<room>)
are seen by that room alone; a library that a row keeps inside is included by no other room, except
that MPI's type is shown by one door. Prints each breach as file:line and ends with 1 if any.
"""
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
LIBRARIES = {  # name in the table -> how its headers are named
    "mpi": re.compile(r"^mpi\.h$"),
    "metis": re.compile(r"^metis\.h$"),
    "toml++": re.compile(r"^toml"),
    "hdf5": re.compile(r"^(hdf5|H5)"),
    "cgal": re.compile(r"^CGAL/"),
    "petsc": re.compile(r"^petsc"),
}


def read_table(architecture):
    """{room: (rooms it may include, libraries it keeps)} from the rows of the first table."""
    rooms = {}
    for line in architecture.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if line.startswith("| room |"):
            rooms = {}
        elif line.startswith("|") and len(cells) == 4 and re.fullmatch(r"[a-z]+", cells[0]):
            rooms[cells[0]] = (set(cells[1].split()), set(cells[2].split()))
        elif rooms and not line.startswith("|"):
            break
    return rooms


def sources(root):
    for base in ("src", "include/trackbed"):
        for path in sorted((root / base).rglob("*")):
            if path.suffix in (".hpp", ".cpp"):
                yield path.relative_to(root / base).parts[0], path


def room_of(header, path, root, rooms):
    """(room the header belongs to, whether it is private), or (None, False) for others."""
    parts = pathlib.PurePosixPath(header).parts
    if parts[0] == "trackbed" and len(parts) > 2:
        return parts[1], False
    if parts[0] in rooms and len(parts) > 1:
        return parts[0], True
    neighbour = (path.parent / header).resolve()
    if neighbour.exists() and (root / "src") in neighbour.parents:
        return neighbour.relative_to(root / "src").parts[0], True
    return None, False


def breaches_of_line(room, path, header, root, rooms):
    target, private = room_of(header, path, root, rooms)
    if target is not None and target != room:
        if private:
            yield f"{room} includes {header}, a private header of {target}"
        elif target not in rooms:
            yield f"{room} includes {header}, but {target} is not in the table"
        elif target not in rooms[room][0]:
            yield f"{room} includes {header}, but may include only: {sorted(rooms[room][0])}"
    for library, pattern in LIBRARIES.items():
        owners = [name for name, (_, kept) in rooms.items() if library in kept]
        if pattern.search(header) and room not in owners:
            yield f"{room} includes {header}, which only {owners} may"


def breaches_of_table(rooms):
    """The table itself: arrows go down it only, and every library is one the check knows."""
    if len(rooms) < 2:
        yield "no table of rooms found"
    above = set()
    for room, (may_include, kept) in rooms.items():
        for other in sorted(may_include - above):
            yield f"{room} may include {other}, which is not above it in the table"
        for library in sorted(kept - set(LIBRARIES)):
            yield f"library {library} is unknown to the check"
        above.add(room)


def check(root):
    rooms = read_table(root / "docs/architecture.md")
    problems = [f"docs/architecture.md: {problem}" for problem in breaches_of_table(rooms)]
    includes = 0
    for room, path in sources(root):
        if room not in rooms:
            problems.append(f"{path.relative_to(root)}: room {room} is not in the table")
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if match:
                includes += 1
                for problem in breaches_of_line(room, path, match[2], root, rooms):
                    problems.append(f"{path.relative_to(root)}:{number}: {problem}")
    return problems, includes


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    problems, includes = check(root)
    print("\n".join(problems) if problems else f"{includes} includes keep to the table")
    if includes == 0:
        print("nothing was checked")
    return 1 if problems or includes == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
