"""What panels of several figures have in common: the sign of displacements, lines and markers,
names of axles, legends that hide no curve."""
import collections.abc
import textwrap
import typing

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator
from matplotlib.transforms import IdentityTransform, ScaledTranslation

from trackbed_post import figure_csv

LINES = ("-", "--", "-.", ":")  # of runs in turn
MARKERS = "osv^DP*X"            # of curves beside each other, in turn
DENSE = 100                     # points of a measured curve; with more it is a dotted line
COLOURS = 8             # in turn, of write.py
MARKS = 12              # of a curve
UP = "mm, up positive"  # of displacements on axes; docs/postproc.md states what is down positive
LETTER = 0.55           # mean width of a letter, as a part of the size of letters
HANDLE = 4.8            # of this size: width of line and gaps of a column of a legend
END = "end of the bed (hollow)"
HIDDEN = "_"            # a label that no legend shows
TITLE_PAD = 7           # points, from a title to what is below it
BELOW_LABELS = 0.5      # inches, from a panel to what is below the labels of its x axis


def axle(wheel: int, two_rails: bool) -> str:
    """Name of the axle of a wheel, which is counted from 0; axles are counted from 1."""
    return f"axle {wheel // 2 + 1}, {('left', 'right')[wheel % 2]}" if two_rails \
        else f"axle {wheel + 1}"


def measured_look(points: int, number: int) -> dict[str, object]:
    """Markers of a measured curve, other ones for each number; of many points a dotted line."""
    return {"ls": ":", "lw": 1.6} if points > DENSE else \
        {"ls": "", "marker": MARKERS[number % len(MARKERS)], "ms": 4.5, "mfc": "none"}


def curve(number: int, points: int) -> dict[str, typing.Any]:
    """Look of the curve of this number, from 0, with so many points: a colour and a marker, so that
    grey prints can be read, too. Marks of different curves are at different points, so that one
    below another one can be seen."""
    every = max(1, points // MARKS)
    return {"color": f"C{number % COLOURS}", "ms": 4, "mfc": "none", "mew": 0.8,
            "marker": MARKERS[(number + number // COLOURS) % len(MARKERS)],
            "markevery": (number % COLOURS * every // COLOURS, every)}


def plain_ticks(panel: Axes) -> None:
    """Plain numbers along a logarithmic x axis, and enough of them over less than a decade."""
    low, high = panel.get_xlim()
    digits = (1, 2, 5) if high > 10 * low else (1, 1.5, 2, 2.5, 3, 4, 5, 6, 8)
    panel.xaxis.set_major_locator(LogLocator(subs=digits))
    panel.xaxis.set_major_formatter("{x:g}")
    panel.xaxis.set_minor_locator(NullLocator())


def mark_ends(panel: Axes, line: Line2D, ends: np.ndarray, label: str) -> None:
    """Hollow marks over those that a line has at the sleepers at the ends of a bed; `label`: END,
    or HIDDEN where the legend has it already."""
    if ends.any():
        marks, = panel.plot(np.asarray(line.get_xdata())[ends], np.asarray(line.get_ydata())[ends],
                            ls="", marker=str(line.get_marker()), color=line.get_color(), ms=3,
                            mfc="white", mew=0.8, zorder=3, label=label)
        figure_csv.name(marks, f"{line.get_label()}, end of the bed")


def wrapped(text: str, wide: float, size: float = 10) -> str:
    """A title in lines that are not longer than `wide`, inches, at a size of letters in points;
    breaks that it has are kept."""
    letters = max(20, int(0.84 * wide * 72 / (LETTER * size)))
    return "\n".join("\n".join(textwrap.wrap(line, letters)) for line in text.split("\n"))


def columns_within(labels: collections.abc.Iterable[str], most: int, wide: float,
                   size: float) -> int:
    """How many columns, at most `most`, of a legend with these labels are not wider than `wide`,
    inches."""
    longest = max(map(len, labels), default=0)
    return max(1, min(most, int(wide * 72 / (size * (LETTER * longest + HANDLE)))))


def legend_above(panel: Axes, columns: int = 4, size: float = 8) -> None:
    """A legend of at most so many columns between the panel and what is above it."""
    columns = columns_within(panel.get_legend_handles_labels()[1], columns,
                             panel.bbox.width / panel.figure.dpi, size)
    panel.legend(loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0.2, ncols=columns,
                 fontsize=size, frameon=False)


def title_above(panel: Axes, text: str, size: float = 10, weight: str = "normal") -> None:
    """A title above the legend of legend_above()."""
    legend, figure = panel.get_legend(), panel.figure
    high = 0.0
    if legend is not None:
        high = legend.get_window_extent(figure.canvas.get_renderer()).height
    panel.set_title(text, fontsize=size, fontweight=weight, pad=high * 72 / figure.dpi + TITLE_PAD)


def legend_below(panel: Axes, columns: int = 2, size: float = 8,
                 handles: collections.abc.Sequence[Artist] | None = None,
                 wide: float | None = None) -> None:
    """A legend of at most so many columns below the label of the panel's x axis, for panels with a
    title; `handles`: what it shows, by default all of the panel; `wide`: inches that it may have,
    by default those of the figure."""
    labels = panel.get_legend_handles_labels()[1] if handles is None else [
        str(one.get_label()) for one in handles]
    columns = columns_within(labels, columns, wide or panel.figure.get_figwidth(), size)
    down = ScaledTranslation(0, -BELOW_LABELS, panel.figure.dpi_scale_trans)
    panel.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0), ncols=columns,
                 fontsize=size, frameon=False, borderaxespad=0,
                 bbox_transform=panel.transAxes + down)


def extend_legend(panel: Axes, more: collections.abc.Sequence[Artist]) -> None:
    """Adds artists to the legend of a panel, at its place and with its look. The legend may name
    what another panel of the figure shows."""
    old = panel.get_legend()
    words = [text.get_text() for text in old.get_texts()]
    own, labels = panel.get_legend_handles_labels()
    drawn = getattr(old, "legend_handles", None) or getattr(old, "legendHandles")
    if labels == words:  # also where two have the same label
        handles = own
    else:
        shown: dict[str, Artist] = {}
        for one in (*panel.figure.axes, panel):
            shown |= {str(label): artist
                      for artist, label in zip(*one.get_legend_handles_labels())}
        handles = [shown.get(word, artist) for word, artist in zip(words, drawn)]
    new = panel.legend([*handles, *more], [*words, *(str(one.get_label()) for one in more)],
                       loc=getattr(old, "_loc"), ncols=getattr(old, "_ncols"),
                       prop=getattr(old, "prop"), frameon=old.get_frame_on(),
                       framealpha=old.get_frame().get_alpha(), borderaxespad=old.borderaxespad,
                       title=old.get_title().get_text() or None)
    new.set_bbox_to_anchor(old.get_bbox_to_anchor(), IdentityTransform())
