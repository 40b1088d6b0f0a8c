#!/usr/bin/env python3
"""Checks every #include of src/ and include/ against the table of modules in docs/architecture.md.

    layering.py [SOURCE_FOLDER]

Five rules: a module includes only the modules of its row; private headers (src/<module>) are
included by their module only; a library assigned to a row is included by no other module, except
MPI, whose communicator type appears in one public header; a sub-module, which is a folder of
src/<module>, includes only the sub-modules of its row in the second table, whose rows are in an
order without cycles; no folder of src holds more than 25 files. Prints each breach as file:line and
ends with 1 if any.
"""
import pathlib
import re
import sys

MOST_FILES = 25  # of a folder of src
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
LIBRARIES = {  # name in the table -> pattern of its headers
    "mpi": re.compile(r"^mpi\.h$"),
    "metis": re.compile(r"^metis\.h$"),
    "xxhash": re.compile(r"^xxhash\.h$"),
    "toml++": re.compile(r"^toml"),
    "hdf5": re.compile(r"^(hdf5|H5)"),
    "cgal": re.compile(r"^CGAL/"),
    "petsc": re.compile(r"^petsc"),
}


def cells_of(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def read_table(architecture):
    """{module: (modules it may include, its own libraries)} from the rows of the first table."""
    modules = {}
    for line in architecture.read_text().splitlines():
        cells = cells_of(line)
        if line.startswith("| module |"):
            modules = {}
        elif line.startswith("|") and len(cells) == 4 and re.fullmatch(r"[a-z]+", cells[0]):
            modules[cells[0]] = (set(cells[1].split()), set(cells[2].split()))
        elif modules and not line.startswith("|"):
            break
    return modules


def read_submodules(architecture):
    """{module/folder: folders of the module it may include} from the rows of the second table, in
    their order."""
    rows = {}
    for line in architecture.read_text().splitlines():
        cells = cells_of(line)
        if line.startswith("|") and len(cells) == 3 and re.fullmatch(r"[a-z]+/[a-z_]+", cells[0]):
            rows[cells[0]] = cells[1].split()
    return rows


def breaches_of_order(rows):
    earlier = set()
    for row, may_include in rows.items():
        for other in may_include:
            if f"{row.split('/')[0]}/{other}" not in earlier:
                yield f"docs/architecture.md: {row} may include {other}, which is no row above it"
        earlier.add(row)


def breaches_of_submodules(root, rows):
    for path in sorted((root / "src").rglob("*.?pp")):
        module, folder, *rest = path.relative_to(root / "src").parts
        if not rest:
            continue
        row, place = f"{module}/{folder}", path.relative_to(root)
        if row not in rows:
            yield f"{place}: sub-module {row} is not in the table"
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            header = match[2].split("/") if match else []
            if len(header) != 3 or header[0] != module or header[1] in (folder, *rows[row]):
                continue
            yield f"{place}:{number}: {row} includes {match[2]}, but may include only: {rows[row]}"


def crowded_folders(root):
    for folder in sorted(path for path in (root / "src").rglob("*") if path.is_dir()):
        count = sum(path.is_file() for path in folder.iterdir())
        if count > MOST_FILES:
            yield f"{folder.relative_to(root)}: {count} files, at most {MOST_FILES}"


def sources(root):
    for base in ("src", "include/trackbed"):
        for path in sorted((root / base).rglob("*")):
            if path.suffix in (".hpp", ".cpp"):
                yield path.relative_to(root / base).parts[0], path


def module_of(header, path, root, modules):
    """(module the header belongs to, whether it is private), or (None, False) for others."""
    parts = pathlib.PurePosixPath(header).parts
    if parts[0] == "trackbed" and len(parts) > 2:
        return parts[1], False
    if parts[0] in modules and len(parts) > 1:
        return parts[0], True
    neighbour = (path.parent / header).resolve()
    if neighbour.exists() and (root / "src") in neighbour.parents:
        return neighbour.relative_to(root / "src").parts[0], True
    return None, False


def breaches_of_line(module, path, header, root, modules):
    target, private = module_of(header, path, root, modules)
    if target is not None and target != module:
        if private:
            yield f"{module} includes {header}, a private header of {target}"
        elif target not in modules:
            yield f"{module} includes {header}, but {target} is not in the table"
        elif target not in modules[module][0]:
            yield f"{module} includes {header}, but may include only: {sorted(modules[module][0])}"
    for library, pattern in LIBRARIES.items():
        owners = [name for name, (_, kept) in modules.items() if library in kept]
        if pattern.search(header) and module not in owners:
            yield f"{module} includes {header}, which only {owners} may"


def breaches_of_table(modules):
    """The table itself: a module may only include modules above it, and libraries must be known."""
    if len(modules) < 2:
        yield "no table of modules found"
    above = set()
    for module, (may_include, kept) in modules.items():
        for other in sorted(may_include - above):
            yield f"{module} may include {other}, which is not above it in the table"
        for library in sorted(kept - set(LIBRARIES)):
            yield f"library {library} is unknown to the check"
        above.add(module)


def check(root):
    modules = read_table(root / "docs/architecture.md")
    problems = [f"docs/architecture.md: {problem}" for problem in breaches_of_table(modules)]
    rows = read_submodules(root / "docs/architecture.md")
    problems += [*breaches_of_order(rows), *breaches_of_submodules(root, rows),
                 *crowded_folders(root)]
    includes = 0
    for module, path in sources(root):
        if module not in modules:
            problems.append(f"{path.relative_to(root)}: module {module} is not in the table")
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if match:
                includes += 1
                for problem in breaches_of_line(module, path, match[2], root, modules):
                    problems.append(f"{path.relative_to(root)}:{number}: {problem}")
    return problems, includes


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    problems, includes = check(root)
    print("\n".join(problems) if problems else f"{includes} includes agree with the table")
    if includes == 0:
        print("nothing was checked")
    return 1 if problems or includes == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
