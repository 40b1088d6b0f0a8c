"""Writes files completely or not at all. An error is a read.Unreadable with code 2 if another path
helps, with code 4 if the disk cannot take the file."""
import datetime
import errno
import io
import os
import pathlib

from trackbed_post import read

DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
DPI = 130      # of pictures in pixels
MANY = 3       # runs are named up to this number
ORIGIN = 0.02  # of the height, for the line that states the origin


def reason_of(error):
    return error.strerror or str(error)


def folder(path):
    """Creates the folder if it is missing."""
    try:
        pathlib.Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        words = "is a file" if pathlib.Path(path).is_file() else reason_of(error)
        raise read.Unreadable(f"{path} cannot be created as a folder ({words}); "
                              "choose another (-o)") \
            from None


def whole(path, content):
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


def origin_of(results):
    """Program and commit, runs, and today's date, for the lower edge of pictures."""
    programs = dict.fromkeys(read.origin(path)[0].partition(";")[0] for path in results)
    folders = [read.folder_of(path).resolve() for path in results]
    names = " and ".join(folder.name for folder in folders) if len(folders) <= MANY else \
        f"{len(folders)} runs in {folders[0].parent.name}"
    return f"{'; '.join(programs)}: {names}, drawn on {datetime.date.today()}"


def state_origin(figure, origin):
    """A line at the lower edge; a dollar in a name is no formula."""
    figure.text(0.995, 0.003, origin.replace("$", r"\$"), fontsize=6, ha="right", va="bottom",
                color="0.4")


class Folder:
    """Where a command writes, and what it wrote: `pictures` (paths of the first format), `tables`
    (texts for a reader), `remarks` (why a figure is missing). `origin`, a line at the lower edge of
    every picture, states of which runs it is."""

    def __init__(self, path, origin="", formats=("png",)):
        self.path, self.origin, self.formats = pathlib.Path(path), origin, formats
        self.pictures, self.tables, self.remarks = [], [], []
        folder(self.path)

    def file(self, name, content):
        whole(self.path / name, content.encode() if isinstance(content, str) else content)

    def table(self, name, text):
        self.file(name, text)
        self.tables.append(text)

    def picture(self, name, figure, origin=""):
        """Writes NAME.png, or the formats asked for, and closes the figure. `origin`: of a picture
        of some of the runs."""
        import matplotlib.pyplot as plt  # here: not needed by those who only read results
        if figure.get_constrained_layout():
            figure.get_layout_engine().set(rect=(0, ORIGIN, 1, 1 - ORIGIN))
        state_origin(figure, origin or self.origin)
        for form in self.formats:
            content = io.BytesIO()
            figure.savefig(content, dpi=DPI, format=form)
            self.file(f"{name}.{form}", content.getvalue())
        plt.close(figure)
        self.pictures.append(self.path / f"{name}.{self.formats[0]}")
