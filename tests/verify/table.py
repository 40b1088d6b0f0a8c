#!/usr/bin/env python3
"""Writes docs/verification.md from the rows that the verification tests stored
(support/verified.hpp), or checks that the document agrees with them.

    table.py FOLDER_OF_ROWS DOCUMENT [--write]
"""
import math
import re
import sys
from pathlib import Path

HEAD = """# Verification
Each row is a value that a test computes and compares with a closed form, a published value or a
limit; "why" is the reason for the size of the tolerance or limit. `ninja -C build/release
verification` runs the tests and rewrites this document; ctest `verification_page` compares it with
the latest results of the tests. SI units.

"""
COLUMNS = ("| case | quantity | measured | reference | tolerance | why |\n"
           "|---|---|---|---|---|---|\n")
# Order of the sections; other folders follow.
SECTIONS = {"particles": "Particles", "ground": "Ground", "track": "Track and train",
            "coupling": "Coupling", "compaction": "Bed", "solids": "Solid sleepers"}


def words(test):
    """Column.FrontArrives/plane -> Column: front arrives (plane); of INSTANCE/Suite the suite."""
    suite, name = test.split(".", 1)
    name, _, parameter = name.partition("/")
    def apart(text):
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", text).lower()
    return (f"{apart(suite.split('/')[-1]).capitalize()}: {apart(name)}" +
            (f" ({parameter})" if parameter else ""))


def rows_of(folder):
    """Rows of each program's run on fewest ranks: (section, case, quantity) -> other columns."""
    runs = {}
    for path in Path(folder).glob("*.tsv"):
        program, ranks = re.fullmatch(r"(.+)_(\d+)", path.stem).groups()
        runs.setdefault(program, []).append((int(ranks), path))
    rows = {}
    for program in sorted(runs):
        for line in min(runs[program])[1].read_text(encoding="utf-8").splitlines():
            folder, test, quantity, *rest = line.split("\t")
            key = (folder, words(test), quantity)
            if key in rows:
                raise SystemExit(f"two rows are called {key}")
            if len(rest) != 6 or not rest[-1].strip():
                raise SystemExit(f"no reason for the tolerance of {key}")
            if "|" in line:
                raise SystemExit(f"a cell contains |: {key}")
            rows[key] = rest
    return rows


def digits(number, tolerance, least):
    """`least` significant digits, or as many as the tolerance resolves."""
    value, margin = float(number), float(tolerance)
    resolved = math.log10(abs(value) / margin) if value and margin else 0
    return f"{value:.{max(least, math.ceil(resolved) + 1)}g}"


def document_of(rows):
    present = {key[0] for key in rows}
    text = HEAD
    for section in [*SECTIONS, *sorted(present - set(SECTIONS))]:
        if section not in present:
            continue
        text += f"## {SECTIONS.get(section, section.capitalize())}\n{COLUMNS}"
        for (where, case, quantity), row in rows.items():
            if where != section:
                continue
            unit, measured, sign, reference, tolerance, reason = row
            unit = "" if unit == "-" else f" {unit}"
            margin = f"{tolerance}{unit}" if sign == "=" else ""
            measured, reference = digits(measured, tolerance, 6), digits(reference, tolerance, 9)
            sign = "" if sign == "=" else f"{sign} "
            text += (f"| {case} | {quantity} | {measured}{unit} | {sign}{reference}{unit} | "
                     f"{margin} | {reason} |\n")
        text += "\n"
    return text.rstrip() + "\n"


def measured_in(document):
    """(case, quantity) -> (measured, reference, tolerance, reason) in the document."""
    found = {}
    for line in document.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 6 and not cells[0].startswith("---") and cells[0] != "case":
            found[cells[0], cells[1]] = cells[2:]
    return found


def differences(rows, document):
    stated, wanted = measured_in(document), measured_in(document_of(rows))
    lines = [f"not in the document: {key}" for key in wanted if key not in stated]
    lines += [f"in the document, but not measured: {key}" for key in stated if key not in wanted]
    for key in wanted.keys() & stated.keys():
        if stated[key][1:] != wanted[key][1:]:
            lines.append(f"{key}: the document has {stated[key][1:]}, the test {wanted[key][1:]}")
    # Digits beyond the tolerance depend on machine and compiler.
    for (_, case, quantity), (_, measured, sign, _, tolerance, _) in rows.items():
        old = float(stated.get((case, quantity), ["nan"])[0].split()[0])
        if sign == "=" and abs(old - float(measured)) > float(tolerance):
            lines.append(f"{case}, {quantity}: the document has {old}, measured {measured}")
    return lines


def main():
    rows, document = rows_of(sys.argv[1]), Path(sys.argv[2])
    if not rows:
        raise SystemExit(f"no rows in {sys.argv[1]}: run ctest -L verify")
    if "--write" in sys.argv:
        document.write_text(document_of(rows), encoding="utf-8")
        return
    lines = differences(rows, document.read_text(encoding="utf-8"))
    if lines:
        raise SystemExit("\n".join(lines + ["to update it: ninja -C build/release verification"]))


if __name__ == "__main__":
    main()
