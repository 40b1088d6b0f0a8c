"""What all studies share: runs, numbers, targets and the parts of a document.

A study NAME is a module NAME with
    runs(form, ranks)            the Runs of the form "short" or "full"
    measure(form, folder, numbers, lines)   fills in Numbers and Lines of the runs in `folder`
    targets(numbers)             Targets, with values that the numbers give
and a module NAME_document with
    TITLE, SOURCE, CRITERION     of the document; when a target counts as reproduced
    document(numbers)            its text after the targets
    figures(numbers, lines, folder)   draws what it shows
It is made of numbers and lines alone, so that it can be made again from the two files.
"""
import csv
import dataclasses
import io
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
INPUTS = ROOT / "inputs"
sys.path.insert(0, str(ROOT / "postproc"))
from trackbed_post import read  # noqa: E402, F401 (of all studies)

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")  # for colour blindness (Okabe, Ito)


@dataclasses.dataclass(frozen=True)
class Run:
    """A deck with changes, in a folder of its own."""
    name: str
    deck: str  # below inputs/
    words: tuple = ()  # {folder}: that of all runs
    ranks: int = 1


@dataclasses.dataclass(frozen=True)
class Target:
    """A published value beside ours. `close`: relative deviation that counts as reproduced; without
    a published number `holds` decides. `sign`: whether our value has the published sign or order,
    which the short form requires of main targets; None: it is not required."""
    what: str
    kind: str  # hard, main or soft, see the document
    published: str
    ours: float
    unit: str
    value: float | None = None
    close: float | None = None
    holds: bool | None = None
    sign: bool | None = None

    def deviation(self):
        return None if self.value is None else self.ours / self.value - 1

    def reproduced(self):
        if self.holds is not None:
            return self.holds
        return abs(self.deviation()) <= self.close


class Numbers:
    """Values by run and quantity, with units. A quantity is missing if its run is not part of the
    form."""

    def __init__(self, about):
        self.about = dict(about)  # version, machine, command
        self.rows = {}

    def put(self, run, quantity, value, unit):
        self.rows[run, quantity] = (float(f"{value:.6g}"), unit)

    def __call__(self, run, quantity):
        return self.rows[run, quantity][0]

    def has(self, run):
        return any(of == run for of, _ in self.rows)

    def text(self):
        out = io.StringIO()
        for key, value in self.about.items():
            out.write(f"# {key}: {value}\n")
        table = csv.writer(out, lineterminator="\n")
        table.writerow(("run", "quantity", "value", "unit"))
        for (run, quantity), (value, unit) in self.rows.items():
            table.writerow((run, quantity, f"{value:.6g}", unit))
        return out.getvalue()

    @staticmethod
    def read(path):
        head, body = [], []
        for line in path.read_text(encoding="utf-8").splitlines():
            (head if line.startswith("# ") else body).append(line)
        numbers = Numbers(line.removeprefix("# ").split(": ", 1) for line in head)
        for row in csv.DictReader(body):
            numbers.rows[row["run"], row["quantity"]] = (float(row["value"]), row["unit"])
        return numbers


class Lines:
    """Curves of the figures: x and y by figure and name."""

    def __init__(self):
        self.rows = {}

    def put(self, figure, name, x, y):
        self.rows[figure, name] = [(float(f"{a:.5g}"), float(f"{b:.4g}")) for a, b in zip(x, y)]

    def of(self, figure):
        return {name: tuple(zip(*points)) for (of, name), points in self.rows.items()
                if of == figure}

    def text(self):
        out = io.StringIO()
        table = csv.writer(out, lineterminator="\n")
        table.writerow(("figure", "line", "x", "y"))
        for (figure, name), points in self.rows.items():
            for x, y in points:
                table.writerow((figure, name, f"{x:.5g}", f"{y:.4g}"))
        return out.getvalue()

    @staticmethod
    def read(path):
        lines = Lines()
        with open(path, encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                lines.rows.setdefault((row["figure"], row["line"]), []).append(
                    (float(row["x"]), float(row["y"])))
        return lines


def table(head, rows):
    """A table of Markdown."""
    cells = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in cells) + "\n"


def percent(ratio):
    """A relative change, with its sign."""
    text = f"{100 * ratio:+.1f} %"
    return "0.0 %" if text in ("-0.0 %", "+0.0 %") else text


def targets_table(targets):
    """Target by target: theirs, ours, deviation, verdict."""
    def row(target):
        off = target.deviation() if target.unit != "%" else None  # of a percentage: no figure
        return (target.what, target.kind, target.published, f"{target.ours:.3g} {target.unit}",
                "" if off is None else percent(off), "yes" if target.reproduced() else "**no**")
    return table(("target", "kind", "published", "ours", "deviation", "reproduced"),
                 map(row, targets))


def heading(text):
    return f"\n## {text}\n"


def as_file(name):
    """Name of a run as that of its folder."""
    return "".join(c if c.isalnum() else "_" for c in name)


def summary(place, *keys):
    """A value of summary.json."""
    found = json.loads((place / "summary.json").read_text(encoding="utf-8"))
    for key in keys:
        found = found[key]
    return found


def save(figure, path):
    import matplotlib.pyplot as plt
    figure.savefig(path, dpi=110)
    plt.close(figure)
