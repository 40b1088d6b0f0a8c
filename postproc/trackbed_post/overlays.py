"""Measured or published curves over any figure that has lines: FIGURE=FILE.csv, whose columns are
drawn over the panel with their units. How to name them: docs/postproc.md.
"""
import collections.abc
import dataclasses
import difflib
import re

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from trackbed_post import curves, figure_csv, measured, panels, read

# Factor to SI and SI unit of a unit as axes state it: those of columns' names, "m/s2" for "_m_s2".
UNITS = {ending[1:].replace("_", "/"): si for ending, si in measured.UNITS.items()}
STATED = re.compile(r"[,(]\s*(" + "|".join(map(re.escape, sorted(UNITS, key=len, reverse=True)))
                    + r")(?![\w/])")
ANY = re.compile(r"[,(]([^,()]*)")  # where a label states a unit


@dataclasses.dataclass(frozen=True)
class Overlay:
    """The curves of one file, over the figure of this name; `panel` counts from 1, 0: the only one
    with their units."""
    text: str
    figure: str
    panel: int
    curves: curves.Curves


def of_text(text: str) -> Overlay:
    """The Overlay of FIGURE=FILE.csv[:X:Y] or FIGURE:PANEL=FILE.csv[:X:Y]."""
    place, equals, file = text.partition("=")
    figure, colon, number = place.partition(":")
    if not (equals and figure and file) or (colon and not (number.isdigit() and int(number))):
        raise read.Unreadable(f"{text}: give FIGURE=FILE.csv, the name of a figure without its "
                              "ending and the file, or FIGURE:PANEL=FILE.csv with the number of "
                              "a panel, from 1 at the top")
    return Overlay(text, figure, int(number or 0), curves.columns_of(file))


def unit_of_label(label: str) -> tuple[float, str]:
    """(factor to SI, SI unit) of an axis; (1, "1") of one without a unit, (1, what it states) of
    one with an unknown unit."""
    label = label.replace("^", "")
    if found := STATED.search(label):
        return UNITS[found[1]]
    unknown = [text for one in ANY.findall(label) if (text := one.strip()) not in ("", "-")]
    return 1.0, unknown[-1] if unknown else "1"


def name_of(number: int, panel: Axes) -> str:
    return (f"panel {number}, {figure_csv.axis_label(panel, 'y') or 'without a label'} over "
            f"{figure_csv.axis_label(panel, 'x') or 'an axis without a label'}")


def panels_of(figure: Figure) -> dict[int, Axes]:
    """The panels with lines, by their number among all."""
    return {number: panel for number, panel in enumerate(figure.axes, 1) if panel.lines}


def scales_of(panel: Axes) -> dict[str, tuple[float, str]]:
    return {which: unit_of_label(figure_csv.axis_label(panel, which)) for which in "xy"}


def fits(panel: Axes, curve: curves.Curve) -> bool:
    return [unit for _, unit in scales_of(panel).values()] == [curve.x_unit, curve.unit]


def panel_for(overlay: Overlay, curve: curves.Curve, figure: Figure) -> Axes:
    """The panel that is asked for, or the only one with the units of the curve."""
    panels = panels_of(figure)
    found = {number: panel for number, panel in panels.items() if fits(panel, curve)}
    if overlay.panel:
        found = {k: panel for k, panel in found.items() if k == overlay.panel}
    if len(found) == 1:
        return next(iter(found.values()))
    units = f"{overlay.text}: {curve.name} has {curve.unit} over {curve.x_unit}; "
    if found:
        raise read.Unreadable(
            f"{units}several panels have these units. Choose one with {overlay.figure}:NUMBER="
            f"{overlay.text.partition('=')[2]}: "
            + "; ".join(name_of(k, panel) for k, panel in found.items()))
    wanted = f"panel {overlay.panel}" if overlay.panel else "no panel"
    raise read.Unreadable(
        f"{units}{wanted} of {overlay.figure} has {'other' if overlay.panel else 'these'} units: "
        + "; ".join(name_of(k, panel) for k, panel in panels.items()))


def draw_curve(curve: curves.Curve, panel: Axes, number: int) -> Line2D:
    """Draws a curve in black over a panel, whose range of x remains."""
    (x_factor, _), (y_factor, _) = scales_of(panel).values()
    x, y = curve.x / x_factor, curve.y / y_factor
    low, high = sorted(panel.get_xlim())
    if not ((x >= low) & (x <= high)).any():
        raise read.Unreadable(f"{curve.name} has x from {x.min():.4g} to {x.max():.4g}, beyond the "
                              f"figure, {low:.4g} to {high:.4g}: "
                              f"{figure_csv.axis_label(panel, 'x')}")
    limits, outside = panel.get_xlim(), (x < low) | (x > high)
    line, = panel.plot(x, np.where(outside, np.nan, y), color="k", zorder=4, label=curve.name,
                       **panels.measured_look(len(x), number))
    panel.set_xlim(limits)
    return line


def add_to_legend(panel: Axes, lines: collections.abc.Sequence[Line2D]) -> None:
    """Adds lines to the legend of a panel, or makes one of them alone."""
    if panel.get_legend():
        panels.extend_legend(panel, lines)
    else:
        panel.legend(handles=list(lines), fontsize=7, framealpha=0.6)


class Overlays:
    """Curves of a command's figures. Call it with each figure before it is written, and
    `require_drawn` at the end: the names of figures are known only then."""

    def __init__(self, texts: collections.abc.Iterable[str] = ()) -> None:
        self.overlays = [of_text(text) for text in texts]
        self.figures: dict[str, bool] = {}  # name -> whether it has lines
        self.problems: list[str] = []

    def __call__(self, name: str, figure: Figure) -> None:
        self.figures[name] = self.figures.get(name, False) or bool(panels_of(figure))
        mine = [overlay for overlay in self.overlays if overlay.figure == name]
        drawn: dict[Axes, list[Line2D]] = {}
        for overlay in mine if panels_of(figure) else ():
            try:
                for curve in overlay.curves:
                    panel = panel_for(overlay, curve, figure)
                    lines = drawn.setdefault(panel, [])
                    lines.append(draw_curve(curve, panel, len(lines)))
            except read.Unreadable as why:
                self.problems.append(str(why))
        for panel, lines in drawn.items():
            if lines:
                add_to_legend(panel, lines)

    def missing(self) -> list[str]:
        """Curves whose figure was not drawn. A run that computes may still get it."""
        known = [name for name, has_lines in self.figures.items() if has_lines]
        found = []
        for overlay in self.overlays:
            if not self.figures.get(overlay.figure):
                near = difflib.get_close_matches(overlay.figure, known, 1)
                found.append(
                    f"{overlay.text}: there is no figure {overlay.figure} with lines"
                    f"{f', did you mean {near[0]}?' if near else '.'} The figures with lines are "
                    f"{', '.join(known) or 'none'}")
        return found

    def require_drawn(self, missing: bool = True) -> None:
        """Ends the command if a curve could not be drawn; `missing`: also for want of a figure."""
        problems = [*self.problems, *(self.missing() if missing else ())]
        if problems:
            raise read.Unreadable("\n".join(dict.fromkeys(problems)))
