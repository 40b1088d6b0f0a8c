"""What all studies share: runs, numbers, targets and the parts of a document.

A study NAME is a module NAME with
    prepare(program, folder)     (optional) makes files that the Runs need
    runs(form, ranks)            the Runs of the form "short" or "full"
    measure(form, folder, numbers, lines)   fills in Numbers and Lines of the runs in `folder`
    derive(numbers)              (optional) adds Numbers that `numbers.lines` give
    targets(numbers)             Targets, with values that the numbers give
and a module NAME_document with
    TITLE, SOURCE, CRITERION     of the document; when a target counts as reproduced (a text, or
                                 a function of numbers)
    summary(numbers)             (optional) what was found, in a few items
    document(numbers)            its text after the targets
    figures(numbers, lines, folder)   draws what it shows
It is made of numbers and lines alone, so that it can be made again from the two files.
"""
import csv
import dataclasses
import io
import json
import pathlib
import re
import sys
import textwrap
import tomllib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
INPUTS = ROOT / "inputs"
sys.path.insert(0, str(ROOT / "postproc"))
from trackbed_post import read  # noqa: E402, F401 (of all studies)

def deck_of(name):
    """The deck `name` below inputs/."""
    with open(INPUTS / name, "rb") as file:
        return tomllib.load(file)


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
    """A published value beside ours; of kind input: a prescribed value, which shows that the run is
    the intended one. `close`: relative deviation that counts as reproduced; without a published
    number `holds` decides. `sign`: whether our value has the published sign or order, which the
    short form requires of main targets; None: it is not required. `each`: the value of
    each packing, of which `ours` is the mean. `error`: standard error of `ours`. `see`: section
    with experiments if it is not reproduced. `infinite`: what an infinite value stands for."""
    what: str
    kind: str  # hard, main or soft, see the document; or input
    published: str
    ours: float
    unit: str
    value: float | None = None
    close: float | None = None
    holds: bool | None = None
    sign: bool | None = None
    each: tuple = ()
    error: float = 0.0
    see: str = ""
    infinite: str = ""

    def deviation(self):
        return None if self.value is None else self.ours / self.value - 1

    def close_to(self, ours):
        return abs(ours / self.value - 1) <= self.close

    def reproduced(self):
        """True, False, or the number of packings that reproduce it if it is only some."""
        if self.holds is not None:
            return bool(self.holds)
        count = sum(map(self.close_to, self.each or (self.ours,)))
        return {0: False, max(len(self.each), 1): True}.get(count, count)

    def verdict(self):
        found = self.reproduced()
        if isinstance(found, bool):
            return "yes" if found else "**no**"
        return f"in {found} of {len(self.each)} packings"


class Numbers:
    """Values by run and quantity, with units. A quantity is missing if its run is not part of the
    form. `lines`: the Lines of the same runs."""

    def __init__(self, about):
        self.about = dict(about)  # version, machine, command
        self.rows = {}
        self.lines = Lines()

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


def three_digits(value):
    """A value with three digits, or more before the point."""
    return f"{value:.0f}" if 1000 <= abs(value) < 1e5 else f"{value:.3g}"


def cell(numbers, run, quantity, form=".3g", missing=""):
    """A value in a table, or `missing` if the numbers have none."""
    return f"{numbers(run, quantity):{form}}" if (run, quantity) in numbers.rows else missing


def between(values, form=".0f"):
    """'1 to 3', or the one if they read the same."""
    low, high = (f"{value:{form}}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def span(values, form=None):
    """Mean (least to most) of several values, or the one; by default with three digits."""
    def text(value):
        return f"{value:{form}}" if form else three_digits(value)
    if not len(values):
        return "none"
    mean = text(float(np.mean(values)))
    return mean if len(values) == 1 else f"{mean} ({text(min(values))} to {text(max(values))})"


def of_packings(count):
    """What span() gives of so many packings."""
    return f"{count} packings: mean (least to most)" if count > 1 else "one packing"


def listed(values, form=".0f"):
    """'1, 2 and 3'"""
    texts = [f"{value:{form}}" for value in values]
    return " and ".join((", ".join(texts[:-1]), texts[-1])) if len(texts) > 1 else texts[0]


def change(numbers, run, other, quantity):
    """Of a quantity, from `run` to `other`, relative."""
    return numbers(other, quantity) / numbers(run, quantity) - 1


def percent(ratio):
    """A relative change, with its sign."""
    text = f"{100 * ratio:+.1f} %"
    return "0.0 %" if text in ("-0.0 %", "+0.0 %") else text


def figure_of(target):
    """Our value, with the range over packings or the standard error, or what it stands for."""
    if target.infinite and np.isinf(target.ours):
        return target.infinite
    found = span(target.each or (target.ours,))
    if target.error:
        found += f" +- {target.error:.2g}"
    return f"{found} {target.unit}".rstrip()


def targets_table(targets):
    """Target by target: theirs, ours, deviation, verdict."""
    def row(target):
        off = target.deviation() if target.unit != "%" else None  # of a percentage: no figure
        return (target.what, target.kind, target.published, figure_of(target),
                "" if off is None else percent(off), target.verdict(),
                "" if target.reproduced() is True else target.see)
    head = ("target", "kind", "published", "ours", "deviation", "reproduced", "experiments")
    return table(head, map(row, targets))


def counted(targets):
    """'Of 20 targets 12 are reproduced ...'; inputs are counted apart."""
    kept = [target.reproduced() is True for target in targets if target.kind == "input"]
    found = [target.reproduced() for target in targets if target.kind != "input"]
    some = sum(not isinstance(each, bool) for each in found)
    yes, no = (sum(each is verdict for each in found) for verdict in (True, False))
    if len(found) == 1:
        text = (f"The one target is {'not ' if no else ''}reproduced"
                f"{' in some packings only' if some else ''}.")
    else:
        text = (f"Of {len(found)} targets {are(yes)} reproduced"
                + (f", {some} in some packings only" if some else "") + f", {are(no)} not.")
    if len(kept) == 1:
        return f"{text} The one check of the input {'holds' if kept[0] else 'does not hold'}."
    holds = "holds" if sum(kept) == 1 else "hold"
    return text + (f" Of {len(kept)} checks of the input {sum(kept)} {holds}." if kept else "")


def are(count):
    """'1 is', '2 are'"""
    return f"{count} {'is' if count == 1 else 'are'}"


def reflowed(text, width=100):
    """Markdown whose paragraphs and items fill its lines, whatever the length of numbers in them.
    """
    out, prose = [], []

    def flush():
        if prose:
            indent = "  " if prose[0].startswith("- ") else ""
            out.append(textwrap.fill(" ".join(prose), width, subsequent_indent=indent,
                                     break_long_words=False, break_on_hyphens=False))
            prose.clear()
    for line in text.splitlines():
        if not line or line.startswith(("#", "|", "!", "<", "- ")):
            flush()
        if line.startswith("- ") or (line and not line.startswith(("#", "|", "!", "<"))):
            prose.append(line.strip())
        else:
            out.append(line)
    flush()
    return re.sub("\n{3,}", "\n\n", "\n".join(out) + "\n")


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
