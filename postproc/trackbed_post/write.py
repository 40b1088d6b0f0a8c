"""Writes files completely or not at all. An error is a read.Unreadable with code 2 if another path
helps, with code 4 if the disk cannot take the file."""
import collections.abc
import datetime
import errno
import functools
import importlib.metadata
import io
import os
import pathlib

import matplotlib
from matplotlib.figure import Figure

from trackbed_post import figure_csv, read

DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
DPI = 130      # of pictures in pixels
FINE_DPI = 300  # of thousands of stones and contact forces, pixels also in PDF and SVG files
MANY = 3       # runs are named up to this number
ORIGIN = 0.25  # inches at the lower edge, for the two lines that state the origin
# Distinct with colour blindness and, the first three, in grey print: Wong 2011,
# doi:10.1038/nmeth.1618.
matplotlib.rcParams["axes.prop_cycle"] = matplotlib.cycler(color=[
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7", "#F0E442", "#000000"])


def reason_of(error: OSError) -> str:
    return error.strerror or str(error)


def size(count: int) -> str:
    """A number of bytes in words."""
    if count < 1_000_000:
        return f"{count / 1e3:.{0 if count >= 10_000 else 1}f} kB"
    return f"{count / 1e6:.1f} MB"


def folder(path: pathlib.Path | str) -> None:
    """Creates the folder if it is missing."""
    try:
        pathlib.Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        words = "is a file" if pathlib.Path(path).is_file() else reason_of(error)
        raise read.Unreadable(f"{path} cannot be created as a folder ({words}); "
                              "choose another (-o)") \
            from None


def whole(path: pathlib.Path | str, content: bytes) -> None:
    """Writes bytes under another name first, so that an older file is kept if the disk is full."""
    path = pathlib.Path(path)
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as error:
        try:
            part.unlink(missing_ok=True)
        except OSError:
            pass  # the first reason is reported
        ending = read.Unreadable(f"{path} cannot be written ({reason_of(error)})")
        ending.code = 4 if error.errno in DISK else 2
        raise ending from None


def commit_of(root: pathlib.Path) -> str:
    """First eight digits of the commit of a clone, from its files, as git may be missing; empty if
    there is none, as in a package that pip has installed."""
    try:
        head = (root / ".git/HEAD").read_text(encoding="utf-8").strip()
        name = head.removeprefix("ref: ")
        if name != head:
            place = root / ".git" / name
            packed = root / ".git/packed-refs"
            head = place.read_text(encoding="utf-8") if place.is_file() else next(
                line for line in packed.read_text(encoding="utf-8").splitlines()
                if line.endswith(f" {name}"))
    except (OSError, UnicodeError, StopIteration):
        return ""
    return head[:8]


@functools.cache
def drawn_by() -> str:
    """By which commit of these modules a picture is drawn, without what is not committed, or by
    which version of the package."""
    folder = pathlib.Path(__file__).resolve().parent
    if folder.parent.name == "postproc" and (commit := commit_of(folder.parents[1])):
        return f"commit {commit}"
    try:
        return f"trackbed_post {importlib.metadata.version('trackbed_post')}"
    except importlib.metadata.PackageNotFoundError:
        return ""


def drawn_words(programs: str = "") -> str:
    """When a picture is drawn, and by what, unless that is in `programs`, which computed it."""
    by = drawn_by()
    return f"drawn on {datetime.date.today()}" + (
        f" by {by}" if by and by.split()[-1] not in programs else "")


def origin_of(results: collections.abc.Sequence[pathlib.Path | str]) -> str:
    """Titles of the decks, program and commit, runs, and today's date, for the lower edge of
    pictures."""
    origins = [read.origin(path) for path in results]
    programs = dict.fromkeys(program.partition(";")[0] for program, *_ in origins)
    titles = dict.fromkeys(title for _, deck, _ in origins if (title := deck.get("title")))
    folders = [read.folder_of(path).resolve() for path in results]
    names = " and ".join(folder.name for folder in folders) if len(folders) <= MANY else \
        f"{len(folders)} runs in {folders[0].parent.name}"
    modelled = "; ".join(titles) + "\n" if 0 < len(titles) <= MANY else ""
    computed = "; ".join(programs)
    return f"{modelled}{computed}: {names}, {drawn_words(computed)}"


def origin_or_name(path: pathlib.Path | str) -> str:
    """The origin of a result folder, or of that of a field file; without a results.h5, which a run
    that goes on or has failed may lack, the name and today's date."""
    path = pathlib.Path(path)
    try:
        return origin_of([path.resolve().parent.parent if path.suffix == ".hdf" else path])
    except read.Unreadable:
        return f"{path.name}, {drawn_words()}"


def origin_height(figure: Figure) -> float:
    """Part of the height of a figure that state_origin() needs at its lower edge."""
    return ORIGIN / figure.get_figheight()


def state_origin(figure: Figure, origin: str) -> None:
    """Lines at the lower edge; a dollar in a name is no formula."""
    figure.text(0.995, 0.003, origin.replace("$", r"\$"), fontsize=6, ha="right", va="bottom",
                color="0.4")


class Folder:
    """Where a command writes, and what it wrote: `pictures` (of the first format), `tables`
    (texts for a reader), `remarks` (why a figure is missing), `sentences` (what the tables say in
    short, with the names of runs; a report begins with them). `origin`, a line at the lower edge of
    every picture, states of which runs it is. `over` draws over each figure, given its name,
    before it is written."""

    def __init__(self, path: pathlib.Path | str, origin: str = "",
                 formats: collections.abc.Sequence[str] = ("png",),
                 over: collections.abc.Callable[[str, Figure], None] | None = None) -> None:
        self.path, self.origin, self.formats = pathlib.Path(path), origin, formats
        self.over = over
        self.pictures: list[pathlib.Path] = []
        self.tables: list[str] = []
        self.remarks: list[str] = []
        self.sentences: list[str] = []
        folder(self.path)

    def file(self, name: str, content: str | bytes) -> None:
        whole(self.path / name, content.encode() if isinstance(content, str) else content)

    def table(self, name: str, text: str) -> None:
        self.file(name, text)
        self.tables.append(text)

    def picture(self, name: str, figure: Figure, origin: str = "") -> None:
        """Writes NAME.png, or the formats asked for, and closes the figure; csv: what it
        shows as NAME_lines.csv. `origin`: of a picture of some of the runs."""
        import matplotlib.pyplot as plt  # here: not needed by those who only read results
        if self.over:
            self.over(name, figure)
        if figure.get_constrained_layout():
            below = origin_height(figure)
            figure.get_layout_engine().set(rect=(0, below, 1, 1 - below))
        state_origin(figure, origin or self.origin)
        drawn = [form for form in self.formats if form != "csv"]
        lines = figure_csv.of_figure(figure) if len(drawn) < len(self.formats) else ""
        if lines:
            self.file(f"{name}_lines.csv", lines)
        for form in drawn:
            content = io.BytesIO()
            figure.savefig(content, dpi=DPI if form == "png" else FINE_DPI, format=form)
            self.file(f"{name}.{form}", content.getvalue())
        plt.close(figure)
        if drawn or lines:
            self.pictures.append(self.path / (f"{name}.{drawn[0]}" if drawn else
                                              f"{name}_lines.csv"))
