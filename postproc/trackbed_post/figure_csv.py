"""What a figure shows, as CSV: lines, bands, points, and lines with a value such as contact forces.
"""
import collections.abc
import csv
import io
import weakref

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection, PolyCollection
from matplotlib.figure import Figure

HEAD = ("panel", "x axis", "y axis", "line", "x", "y", "value", "quantity")
Row = tuple[str, float, float, float | str, str]  # name of the line, x, y, value, quantity
Rows = collections.abc.Iterator[Row]

# What the members of a collection stand for: (quantity with its unit, a value of each).
_STATED: weakref.WeakKeyDictionary[Collection, tuple[str, np.ndarray]] = \
    weakref.WeakKeyDictionary()


# Names of artists that legends show under another name, or not.
_NAMES: weakref.WeakKeyDictionary[Artist, str] = weakref.WeakKeyDictionary()


def name(artist: Artist, words: str) -> None:
    """The name of a line or of a collection in CSV; by default it is its label in the legend."""
    _NAMES[artist] = words


def state(collection: Collection, quantity: str, values: np.ndarray) -> None:
    """Gives each member of a collection, which shows it by width or colour, its value."""
    _STATED[collection] = (quantity, np.asarray(values))


def axis_label(panel: Axes, which: str) -> str:
    """Label of the axis, or of a panel that shares it; in one line."""
    shared = panel.get_shared_x_axes() if which == "x" else panel.get_shared_y_axes()
    panels = [panel, *shared.get_siblings(panel)]
    labels = [getattr(one, f"get_{which}label")() for one in panels]
    return " ".join(next((label for label in labels if label), "").split())


def _name_of(artist: Artist, otherwise: str) -> str:
    label = _NAMES.get(artist, str(artist.get_label()))
    return otherwise if not label or label.startswith("_") else " ".join(label.split())


def _lines(panel: Axes) -> Rows:
    """Lines in the coordinates of the axes; marks and brackets over a whole side of the panel have
    others."""
    there = [line for line in panel.lines if line.get_transform() == panel.transData]
    for count, line in enumerate(there, 1):
        name = _name_of(line, f"line {count}")
        for x, y in zip(line.get_xdata(orig=False), line.get_ydata(orig=False)):
            yield name, x, y, "", ""


def _segments(name: str, drawn: LineCollection) -> Rows:
    quantity, values = _STATED[drawn]
    for number, (points, value) in enumerate(zip(drawn.get_segments(), values), 1):
        for x, y in points:
            yield f"{name} {number}", x, y, value, quantity


def _band(name: str, drawn: PolyCollection) -> Rows:
    """Lower and upper edge at each place of an area between two lines."""
    for path in drawn.get_paths():
        for edge, end in (("lower", 1), ("upper", -1)):
            # The first corner at each place in this order is the lowest, or the highest.
            corners = path.vertices[np.lexsort((end * path.vertices[:, 1], path.vertices[:, 0]))]
            for at in np.unique(corners[:, 0], return_index=True)[1]:
                yield f"{name}, {edge} edge", corners[at, 0], corners[at, 1], "", ""


def _points(name: str, drawn: Collection) -> Rows:
    places = np.ma.getdata(drawn.get_offsets())
    quantity, values = _STATED.get(drawn, ("", [""] * len(places)))
    for (x, y), value in zip(places, values):
        yield name, x, y, value, quantity


def _collections(panel: Axes) -> Rows:
    """Those with values or a name, and areas; stones behind contact forces have neither."""
    for count, drawn in enumerate(panel.collections, 1):
        name = _name_of(drawn, _STATED[drawn][0].partition(",")[0] if drawn in _STATED else "")
        placed = drawn.get_offset_transform() == panel.transData
        if isinstance(drawn, LineCollection) and drawn in _STATED:
            yield from _segments(name, drawn)
        elif placed and name:
            yield from _points(name, drawn)
        elif isinstance(drawn, PolyCollection) and not placed:
            yield from _band(name or f"band {count}", drawn)


def _text(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.9g}"


def of_figure(figure: Figure) -> str:
    """CSV with a row for each point: name of the panel, labels of its axes, name of the line, x and
    y as they are drawn, and the value of a point or line that has one. The name of a panel is its
    label as an artist (set_label), otherwise its number: titles change with the results. Empty for
    a picture that shows nothing of this kind."""
    rows = []
    for number, panel in enumerate(figure.axes):
        label = str(panel.get_label())
        if label == "<colorbar>":
            continue
        head = (f"panel {number + 1}" if not label or label.startswith("_") else label,
                axis_label(panel, "x"), axis_label(panel, "y"))
        rows += [(*head, name, _text(x), _text(y), _text(value), quantity)
                 for drawn in (_lines(panel), _collections(panel))
                 for name, x, y, value, quantity in drawn]
    if not rows:
        return ""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([HEAD, *rows])
    return text.getvalue()
