#!/usr/bin/env python3
"""docs/verification.md from the rows that the verification tests kept (support/verified.hpp), or
whether the page still says what they measure.

    table.py FOLDER_OF_ROWS PAGE [--write]
"""
import math
import re
import sys
from pathlib import Path

HEAD = """# Verification
Each row is a figure that a test measures and checks against a closed form, a published value or a
limit. The tests and this page are renewed by `ninja -C build/release verification`; ctest
`verification_page` compares it with what the tests have just measured. SI units.

"""
COLUMNS = "| case | quantity | measured | reference | tolerance |\n|---|---|---|---|---|\n"
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
    """Of each program the run on fewest ranks: (section, case, quantity) -> the other columns."""
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
            rows[key] = rest
    return rows


def digits(measured, tolerance):
    """Six, or as many as the tolerance can tell apart."""
    value, margin = float(measured), float(tolerance)
    told = math.log10(abs(value) / margin) if value and margin else 0
    return f"{value:.{max(6, math.ceil(told) + 1)}g}"


def page_of(rows):
    present = {key[0] for key in rows}
    text = HEAD
    for section in [*SECTIONS, *sorted(present - set(SECTIONS))]:
        if section not in present:
            continue
        text += f"## {SECTIONS.get(section, section.capitalize())}\n{COLUMNS}"
        for (where, case, quantity), (unit, measured, sign, reference, tolerance) in rows.items():
            if where != section:
                continue
            unit = "" if unit == "-" else f" {unit}"
            reference = reference if sign == "=" else f"{sign} {reference}"
            margin = f"{tolerance}{unit}" if sign == "=" else ""
            said = digits(measured, tolerance)
            text += (f"| {case} | {quantity} | {said}{unit} | {reference}{unit} | "
                     f"{margin} |\n")
        text += "\n"
    return text.rstrip() + "\n"


def measured_in(page):
    """(case, quantity) -> (measured, reference, tolerance) as the page says them."""
    found = {}
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 5 and not cells[0].startswith("---") and cells[0] != "case":
            found[cells[0], cells[1]] = cells[2:]
    return found


def differences(rows, page):
    said, wanted = measured_in(page), measured_in(page_of(rows))
    lines = [f"not on the page: {key}" for key in wanted if key not in said]
    lines += [f"on the page, but not measured: {key}" for key in said if key not in wanted]
    for key in wanted.keys() & said.keys():
        if said[key][1:] != wanted[key][1:]:
            lines.append(f"{key}: the page says {said[key][1:]}, the test {wanted[key][1:]}")
    # Digits beyond the tolerance are the machine's and the compiler's.
    for (_, case, quantity), (_, measured, sign, _, tolerance) in rows.items():
        old = float(said.get((case, quantity), ["nan"])[0].split()[0])
        if sign == "=" and abs(old - float(measured)) > float(tolerance):
            lines.append(f"{case}, {quantity}: the page says {old}, measured {measured}")
    return lines


def main():
    rows, page = rows_of(sys.argv[1]), Path(sys.argv[2])
    if not rows:
        raise SystemExit(f"no rows in {sys.argv[1]}: run ctest -L verify")
    if "--write" in sys.argv:
        page.write_text(page_of(rows), encoding="utf-8")
        return
    lines = differences(rows, page.read_text(encoding="utf-8"))
    if lines:
        raise SystemExit("\n".join(lines + ["renew it: ninja -C build/release verification"]))


if __name__ == "__main__":
    main()
