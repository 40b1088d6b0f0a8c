#!/usr/bin/env python3
"""Draws the sketches of docs/theory.md: its pictures are docs/images/*.svg.

    /usr/bin/python3 jobs/sketches.py [FOLDER]    FOLDER: default docs/images

Writes coordinates.svg, contact.svg, vehicle.svg and window.svg, and needs matplotlib only. The same
version of matplotlib writes the same bytes. The pictures of docs/gallery.md come from
jobs/gallery.sh. Lengths are inches: the axes cover the sheet, which fits the width of A4 paper.
"""
import io
import math
import pathlib
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle

matplotlib.rcParams.update({"svg.hashsalt": "trackbed", "svg.fonttype": "path",
                            "font.family": "DejaVu Sans", "font.size": 9, "hatch.linewidth": 0.5})
WIDTH = 6.9
SMALL = 8.5  # pt, the smallest text
# Fills have different brightness, so that they differ in a grey print.
STEEL, SLEEPER, BODY, STONE, GROUND = "#111111", "#6b6b6b", "#9db8d9", "#d9bd8f", "#e9e6d2"
MOTION, LOAD = "#1f4e8c", "#a32020"  # full and dashed lines


class Sheet:
    def __init__(self, height):
        self.figure = plt.figure(figsize=(WIDTH, height), facecolor="white")
        self.axes = self.figure.add_axes([0, 0, 1, 1])
        self.axes.set(xlim=(0, WIDTH), ylim=(0, height))
        self.axes.axis("off")

    def save(self, path):
        text = io.StringIO()
        self.figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(self.figure)
        lines = [line.rstrip() for line in text.getvalue().splitlines()]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")

    def line(self, x, y, color=STEEL, width=1.0, **more):
        self.axes.plot(x, y, color=color, linewidth=width, solid_capstyle="butt", **more)

    def text(self, x, y, words, ha="center", va="center", size=9, color=STEEL, clear=False,
             **more):
        if clear:
            more["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 1}
        self.axes.text(x, y, words, ha=ha, va=va, fontsize=size, color=color, **more)

    def key(self, x, y, words, **more):
        """A key of the deck."""
        self.text(x, y, words, **{"size": SMALL, "family": "DejaVu Sans Mono", **more})

    def box(self, x, y, width, height, color, round_by=0.0, **more):
        style = {"facecolor": color, "edgecolor": STEEL, "linewidth": 0.8, "zorder": 2, **more}
        if round_by:
            self.axes.add_patch(FancyBboxPatch(
                (x + round_by, y + round_by), width - 2 * round_by, height - 2 * round_by,
                boxstyle=f"round,pad={round_by}", **style))
        else:
            self.axes.add_patch(Rectangle((x, y), width, height, **style))

    def circle(self, x, y, radius, color, **more):
        style = {"facecolor": color, "edgecolor": STEEL, "linewidth": 0.8, "zorder": 2, **more}
        self.axes.add_patch(Circle((x, y), radius, **style))

    def arrow(self, start, end, color=STEEL, width=1.0, style="-|>", dashed=False, curve=0.0):
        self.axes.annotate("", xy=end, xytext=start, zorder=6, arrowprops={
            "arrowstyle": f"{style},head_width=0.18,head_length=0.4", "color": color,
            "linewidth": width, "shrinkA": 0, "shrinkB": 0,
            "linestyle": (0, (4, 2)) if dashed else "solid",
            "connectionstyle": f"arc3,rad={curve}"})

    def distance(self, x, y, words, text_x=None, above=True, key=True):
        """Measures from x[0] to x[1] at the height y."""
        self.axes.annotate("", xy=(x[1], y), xytext=(x[0], y), arrowprops={
            "arrowstyle": "<|-|>,head_width=0.14,head_length=0.32", "color": STEEL,
            "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0})
        write = self.key if key else self.text
        write(sum(x) / 2 if text_x is None else text_x, y + (0.05 if above else -0.05), words,
              va="bottom" if above else "top")

    def spring(self, x, low, high, width=0.1, turns=4):
        lead = 0.15 * (high - low)
        y = [low, low + lead]
        side = [x, x]
        for k in range(2 * turns):
            y.append(low + lead + (high - low - 2 * lead) * (k + 0.5) / (2 * turns))
            side.append(x + (width / 2 if k % 2 == 0 else -width / 2))
        self.line([*side, x, x], [*y, high - lead, high], width=0.9, zorder=3)

    def dashpot(self, x, low, high, width=0.1):
        middle, half = (low + high) / 2, 0.16 * (high - low)
        self.line([x, x], [low, middle - half], width=0.9, zorder=3)
        self.line([x - width / 2, x - width / 2, x + width / 2, x + width / 2],
                  [middle + half, middle - half, middle - half, middle + half], width=0.9, zorder=3)
        self.line([x - 0.7 * width / 2, x + 0.7 * width / 2], [middle, middle], width=1.6, zorder=3)
        self.line([x, x], [middle, high], width=0.9, zorder=3)

    def kelvin(self, x, low, high, apart=0.16, width=0.09):
        self.spring(x - apart / 2, low, high, width)
        self.dashpot(x + apart / 2, low, high, width)

    def fixed(self, x, y, depth=0.07):
        self.line(x, [y, y], width=1.0)
        self.axes.add_patch(Rectangle((x[0], y - depth), x[1] - x[0], depth, facecolor="white",
                                      edgecolor="#555555", hatch="/////", linewidth=0, zorder=1))

    def stones(self, x, y, radius=0.045):
        """A layer of stones, in rows."""
        rows = max(1, int((y[1] - y[0]) / (1.8 * radius)))
        step = (y[1] - y[0] - 2 * radius) / max(1, rows - 1)
        for row in range(rows):
            count = int((x[1] - x[0]) / (2 * radius)) - row % 2
            first = (x[0] + x[1]) / 2 - (count - 1) * radius
            self.axes.plot([first + 2 * k * radius for k in range(count)],
                           [y[0] + radius + row * step] * count, "o", zorder=2,
                           markersize=2 * radius * 72 - 0.5, markerfacecolor=STONE,
                           markeredgecolor=STEEL, markeredgewidth=0.5)


def train_at(sheet, first_axle, rail, size=0.085):
    """A coach whose first axle is at `first_axle`; it travels to the right."""
    behind = (0.0, 0.22, 0.72, 0.94)
    for distance in behind:
        sheet.circle(first_axle - distance, rail + size, size, "white", linewidth=1.0)
    for pair in (0.0, 0.72):
        sheet.box(first_axle - pair - 0.27, rail + 2 * size - 0.02, 0.32, 0.05, SLEEPER)
    sheet.box(first_axle - 1.07, rail + 2 * size + 0.06, 1.2, 0.2, BODY, 0.04)
    sheet.arrow((first_axle + 0.17, rail + 2 * size + 0.16),
                (first_axle + 0.42, rail + 2 * size + 0.16), width=1.2)


START, SPACING, SLEEPERS, FIRST = 1.62, 0.36, 13, 4  # of the sketch of coordinates
SLEEPER_X = [START + k * SPACING for k in range(SLEEPERS)]
END = SLEEPER_X[-1]
CARRIED = range(FIRST, 9)  # sleepers on the ground or on the bed
LEFT, RIGHT = SLEEPER_X[FIRST] - 0.3, SLEEPER_X[8] + 0.3  # of ground and bed


def rail_and_sleepers(sheet, rail, floor, carried_on=None):
    """`carried_on`: height of the underside's support of the carried sleepers, without springs."""
    sheet.line([START, END], [rail - 0.025] * 2, width=3.2)
    for x in ((0.3, START), (END, END + 0.5)):
        sheet.line(x, [rail - 0.025] * 2, width=3.2, dashes=(0.7, 0.7), zorder=1)
    for k, x in enumerate(SLEEPER_X):
        sheet.box(x - 0.1, rail - 0.17, 0.2, 0.12, SLEEPER)
        if carried_on is None or k not in CARRIED:
            sheet.spring(x, floor, rail - 0.17, 0.08, 3)


def axis(sheet, y, zero, words, at_zero):
    sheet.arrow((zero - 0.12, y), (6.12, y), width=1.0)
    sheet.line([zero, zero], [y - 0.06, y + 0.06], width=1.4)
    sheet.text(6.17, y, words, ha="left", style="italic")
    sheet.text(zero - 0.16, y, at_zero, ha="right", size=SMALL)


def guide(sheet, x, y):
    sheet.line([x, x], y, color="#666666", width=0.6, dashes=(3, 2), zorder=0)


def coordinates():
    sheet = Sheet(7.25)
    # A track alone.
    rail, floor, axle = 6.42, 5.95, SLEEPER_X[5] + 0.18
    sheet.text(0.1, 7.13, "Track alone", ha="left", weight="bold")
    train_at(sheet, axle, rail)
    sheet.key(axle + 0.52, rail + 0.33, "x_1 = train.start  at  t = 0", ha="left")
    guide(sheet, axle, (5.56, rail + 0.08))
    rail_and_sleepers(sheet, rail, floor)
    sheet.fixed((START - 0.15, END + 0.15), floor)
    guide(sheet, START, (5.36, rail + 0.3))
    guide(sheet, END, (5.36, rail))
    sheet.text(START - 0.05, rail + 0.42, "first sleeper\nand start of the rail", size=SMALL,
               ha="right")
    sheet.text(0.3, rail - 0.22, "rigid rail", size=SMALL, ha="left")
    sheet.text(END + 0.14, rail - 0.22, "rigid rail", size=SMALL, ha="left")
    sheet.distance((START, axle), 5.62, "train.start")
    sheet.text(axle + 0.1, 5.66, "heights count from the unloaded track", size=SMALL, ha="left",
               clear=True)
    axis(sheet, 5.42, START, "x", "x = 0")
    sheet.key(END, 5.31, "track.length", va="top")
    # The axes.
    sheet.arrow((0.42, 5.3), (0.85, 5.3), width=1.3)
    sheet.arrow((0.42, 5.3), (0.42, 5.73), width=1.3)
    sheet.circle(0.42, 5.3, 0.06, "white", zorder=7)
    for side in (1, -1):
        sheet.line([0.38, 0.46], [5.3 - 0.04 * side, 5.3 + 0.04 * side], width=0.8, zorder=8)
    sheet.text(0.9, 5.2, "x", style="italic")
    sheet.text(0.33, 5.73, "z", style="italic")
    sheet.text(0.29, 5.3, "y", style="italic")
    sheet.text(1.1, 5.1, "y points away from the viewer: to the left of the travel", ha="left",
               va="top", size=SMALL)
    # A track on a ground.
    rail, floor = 4.19, 3.71
    in_a_longer_track(sheet, "Track on a ground", rail, floor, "footing")
    rail_and_sleepers(sheet, rail, floor)
    sheet.box(LEFT, floor - 0.42, RIGHT - LEFT, 0.42, GROUND, zorder=1)
    sheet.fixed((LEFT, RIGHT), floor - 0.42)
    sheet.text((LEFT + RIGHT) / 2, floor - 0.2, "ground")
    places(sheet, rail, floor - 0.42, "footing", "x_ground", "footing.first")
    # A bed in the track.
    rail, floor = 1.76, 1.16
    in_a_longer_track(sheet, "Bed in the track (train on a bed)", rail, floor, "sleepers")
    rail_and_sleepers(sheet, rail, floor, carried_on=floor)
    sheet.stones((LEFT, RIGHT), (floor, rail - 0.17))
    sheet.box(LEFT, floor - 0.25, RIGHT - LEFT, 0.25, GROUND, zorder=1)
    sheet.text((LEFT + RIGHT) / 2, floor - 0.125, "ground or floor", size=SMALL)
    places(sheet, rail, floor - 0.25, "seat", "x_bed", "sleepers.first")
    return sheet


def in_a_longer_track(sheet, title, rail, floor, section):
    sheet.text(0.1, rail + 0.58, title, ha="left", weight="bold")
    train_at(sheet, START - 0.06, rail)
    sheet.key(START + 0.42, rail + 0.36, "train.start <= 0", ha="left")
    sheet.key(SLEEPER_X[FIRST] - 0.04, rail + 0.16, f"first of {section}.count sleepers",
              ha="left")
    for x in ((START - 0.15, LEFT), (RIGHT, END + 0.15)):
        sheet.fixed(x, floor)
    sheet.text(RIGHT + 0.05, floor - 0.19, "z = 0: top of ground or floor", size=SMALL, ha="left")


def places(sheet, rail, bottom, section, own, first):
    """Two axes of x, and what ties them together."""
    x = SLEEPER_X[FIRST]
    upper, lower = bottom - 0.36, bottom - 0.64
    guide(sheet, START, (upper, rail))
    guide(sheet, x, (lower - 0.2, rail + 0.08))
    guide(sheet, LEFT, (lower - 0.2, bottom))
    sheet.distance((START, x), bottom - 0.2, "")
    sheet.key(x + 0.08, bottom - 0.2, f"{section}.before * track.spacing", ha="left", clear=True)
    axis(sheet, upper, START, "x_track", "x_track = 0")
    axis(sheet, lower, LEFT, own, f"{own} = 0")
    sheet.distance((LEFT, x), lower - 0.14, "")
    sheet.key(x + 0.08, lower - 0.14, first, ha="left")


def lens(i, j, radius):
    """The outline of what two equal circles have in common."""
    half = math.degrees(math.acos((j[0] - i[0]) / 2 / radius))
    turns = [math.radians(half * k / 20) for k in range(-20, 21)]
    return ([(i[0] + radius * math.cos(t), i[1] + radius * math.sin(t)) for t in turns] +
            [(j[0] - radius * math.cos(t), j[1] - radius * math.sin(t)) for t in turns])


def contact():
    sheet = Sheet(3.1)
    # Two stones.
    i, j, radius = (0.98, 1.62), (2.5, 1.62), 0.86
    for centre in (i, j):
        sheet.circle(*centre, radius, "#e3cda8")
        sheet.circle(*centre, 0.025, STEEL, zorder=7)
    sheet.axes.add_patch(Polygon(lens(i, j, radius), facecolor="#a88655", edgecolor=STEEL,
                                 linewidth=0.8, zorder=3))
    near, far = j[0] - radius, i[0] + radius
    middle = (near + far) / 2
    sheet.circle(middle, 1.62, 0.025, STEEL, zorder=7)
    sheet.text(i[0] - 0.1, 1.6, "i", weight="bold")
    sheet.text(j[0] + 0.1, 1.6, "j", weight="bold")
    for centre, name, side in ((i, "a_i", 1), (j, "a_j", -1)):
        sheet.arrow((centre[0], 1.62), (middle - 0.02 * side, 1.62))
        sheet.text(centre[0] + 0.36 * side, 1.52, name)
    for centre, angle, name in ((i, 130, "r_i"), (j, 50, "r_j")):
        tip = (centre[0] + radius * math.cos(math.radians(angle)),
               centre[1] + radius * math.sin(math.radians(angle)))
        sheet.arrow(centre, tip, width=0.8)
        sheet.text((centre[0] + tip[0]) / 2 + (0.12 if angle > 90 else -0.12),
                   (centre[1] + tip[1]) / 2 + 0.06, name)
    for x in (near, far):
        sheet.line([x, x], [1.62, 2.56], color="#444444", width=0.7, dashes=(3, 2), zorder=4)
    sheet.text(middle, 2.76, "overlap delta")
    sheet.arrow((near - 0.22, 2.56), (near, 2.56), width=0.9)
    sheet.arrow((far + 0.22, 2.56), (far, 2.56), width=0.9)
    sheet.arrow((middle, 1.62), (middle + 0.34, 1.62), color=MOTION, width=2.2)
    sheet.text(middle + 0.24, 1.75, "n", color=MOTION, weight="bold")
    sheet.arrow((middle, 1.62), (middle, 0.98), color=MOTION, width=1.6)
    sheet.text(middle + 0.19, 1.08, "v_t", color=MOTION)
    for x in (i[0], j[0]):
        sheet.line([x, x], [0.5, 1.62], color="#444444", width=0.6, dashes=(3, 2), zorder=4)
    sheet.distance((i[0], j[0]), 0.55, "d", key=False)
    sheet.text(middle, 0.22, "delta = r_i + r_j - d;   of pieces with corners:  M", size=SMALL)
    # Along the normal.
    low, high = 0.95, 2.35
    for x, words in ((4.35, "along n"), (5.95, "across n")):
        sheet.text(x, 2.76, words, weight="bold")
        for y, name in ((high, "i"), (low - 0.13, "j")):
            sheet.box(x - 0.4, y, 0.8, 0.13, STONE)
            sheet.text(x - 0.5, y + 0.065, name, weight="bold")
    sheet.spring(4.15, low, high, 0.16, 5)
    sheet.dashpot(4.55, low, high, 0.17)
    sheet.text(3.98, 1.65, "k_n", ha="right")
    sheet.text(4.7, 1.65, "c_n", ha="left")
    sheet.text(4.35, 0.3, "F_n = k_n delta + c_n v_n,\nat least 0", size=SMALL)
    # Across it: the slider, a block held by a fork, limits spring and dashpot together.
    join = 1.42
    sheet.line([5.7, 6.2], [join, join])
    sheet.spring(5.75, join, high, 0.16, 4)
    sheet.dashpot(6.15, join, high, 0.17)
    sheet.text(5.6, 1.88, "k_s, xi", ha="right")
    sheet.text(6.3, 1.88, "c_s", ha="left")
    sheet.line([5.95, 5.95], [join, 1.25], width=0.9)
    sheet.line([5.85, 5.85, 6.05, 6.05], [1.06, 1.25, 1.25, 1.06], width=0.9)
    sheet.box(5.86, 1.08, 0.18, 0.1, SLEEPER)
    sheet.line([5.95, 5.95], [1.08, low], width=0.9)
    sheet.text(6.14, 1.14, "mu F_n", ha="left")
    sheet.text(5.95, 0.3, "|F_t| at most mu F_n", size=SMALL)
    return sheet


def vehicle():
    sheet = Sheet(5.05)
    rail, pad, sleeper, bed = 2.1, 1.72, 1.5, 0.98
    axles = {"front": (4.62, 5.94), "rear": (1.0, 2.32)}
    centre = {name: sum(pair) / 2 for name, pair in axles.items()}
    middle = sum(centre.values()) / 2
    # Body and bogies.
    sheet.box(0.45, 4.03, 6.0, 0.62, BODY, 0.08)
    sheet.text(middle - 1.7, 4.34, "body: height z, pitch theta")
    sheet.arrow((middle, 4.34), (middle, 4.92), width=1.2)
    sheet.text(middle - 0.12, 4.87, "z", style="italic")
    sheet.circle(middle, 4.34, 0.03, STEEL)
    sheet.arrow((middle + 0.12, 4.38), (middle - 0.16, 4.38), width=1.0, curve=0.9)
    sheet.distance((middle, centre["front"]), 4.24, "d ahead of the centre", key=False)
    sheet.line([centre["front"]] * 2, [4.03, 4.3], width=0.6, dashes=(3, 2), zorder=3)
    sheet.arrow((5.75, 4.85), (6.45, 4.85), width=1.2)
    sheet.text(5.68, 4.85, "travel, x", ha="right", size=SMALL)
    for name, pair in axles.items():
        sheet.kelvin(centre[name], 3.42, 4.03, 0.22, 0.13)
        sheet.box(pair[0] - 0.2, 3.2, pair[1] - pair[0] + 0.4, 0.22, "#c8c8c8")
        sheet.text(centre[name], 3.31, "bogie: z, theta", size=SMALL)
        for axle in pair:
            sheet.kelvin(axle, 2.64, 3.2, 0.2, 0.12)
            sheet.box(axle - 0.17, 2.58, 0.34, 0.06, SLEEPER)
            sheet.circle(axle, rail + 0.22, 0.22, "white", linewidth=1.3)
            sheet.line([axle, axle], [rail + 0.22, 2.58], width=1.4, zorder=4)
            sheet.circle(axle, rail + 0.22, 0.04, STEEL, zorder=4)
    for words, y, half, end, rise in (("secondary springs k, c", 3.75, 0.82,
                                       (centre["rear"] + 0.25, centre["front"] - 0.25), 0),
                                      ("primary springs k, c", 2.92, 0.74,
                                       (axles["rear"][1] + 0.2, axles["front"][0] - 0.2), 0),
                                      ("wheelset: z", 2.45, 0.43,
                                       (axles["rear"][1] + 0.22, axles["front"][0] - 0.22), -0.08)):
        sheet.text(middle, y, words, size=SMALL)
        sheet.arrow((middle - half, y), (end[0], y + rise), width=0.7)
        sheet.arrow((middle + half, y), (end[1], y + rise), width=0.7)
    # Rail, pads, sleepers, ballast.
    sheet.line([0.45, 6.45], [rail - 0.035] * 2, width=4.5, zorder=3)
    for x in (0.75 + 0.77 * k for k in range(8)):
        sheet.kelvin(x, pad, rail - 0.06, 0.14, 0.09)
        sheet.box(x - 0.2, sleeper, 0.4, pad - sleeper, SLEEPER)
        sheet.kelvin(x, bed, sleeper, 0.18, 0.11)
        sheet.circle(x, rail - 0.035, 0.035, "white", linewidth=0.8, zorder=5)
    sheet.fixed((0.45, 6.45), bed)
    # The numbers lead to the legend.
    for number, at in ((1, (1.905, 2.2)), (2, (1.905, 1.88)), (3, (1.905, 1.61)),
                       (4, (1.905, 1.25)), (5, (6.3, 2.22))):
        sheet.circle(*at, 0.09, "white", zorder=6)
        sheet.text(*at, str(number), size=SMALL, zorder=7)
    sheet.arrow((6.21, 2.19), (5.98, 2.11), width=0.7)
    legend = ("1  rail: w and theta at nodes (circles and others); E I, kappa G A, m per length",
              "2  pad: k, c; bilinear or with uplift if the deck states it",
              "3  sleeper: mass m",
              "4  ballast springs k, c, below hanging sleepers with a gap; on a bed: stones",
              "5  contact of wheel and rail: F = C_H d^1.5 for an approach d > 0, else 0")
    for k, words in enumerate(legend):
        sheet.text(0.45, 0.78 - 0.165 * k, words, ha="left", size=SMALL)
    return sheet


ROWS = {"rail": 4.0, "sleepers": 3.28, "stones": 2.36, "ground": 1.44}  # of the sketch of a window
ROW = 0.36
INSTANTS = ("t_n", "t_n+1", "t_n+2")


def number_in(sheet, x, y, number):
    sheet.circle(x, y, 0.09, "white", zorder=6)
    sheet.text(x, y, str(number), size=SMALL, zorder=7)


def window():
    sheet = Sheet(5.0)
    width, gap = 2.3, 0.55
    begin = (1.4, 1.4 + width + gap)
    names = {"rail": "rail and\nvehicles", "sleepers": "sleepers,\nplaten, walls",
             "stones": "stones", "ground": "ground"}
    fills = {"rail": BODY, "sleepers": "#c8c8c8", "ground": GROUND, "stones": STONE}
    for name, y in ROWS.items():
        sheet.text(0.1, y + ROW / 2, names[name], ha="left")
        for x in begin:
            sheet.box(x, y, width, ROW, fills[name])
            parts = {"ground": 4, "stones": 10}.get(name, 1)
            for k in range(1, parts):
                sheet.line([x + width * k / parts] * 2, [y, y + ROW], width=0.6, zorder=3)
    for k, x in enumerate(begin):
        sheet.text(x + width / 2, 4.88, ("window", "next window")[k], weight="bold")
        sheet.distance((x, x + width), 4.58, "", key=False)
        for at in (x, x + width):
            sheet.line([at, at], [1.3, 4.62], color="#888888", width=0.6, dashes=(3, 2), zorder=0)
        exchange(sheet, x, width, *INSTANTS[k:k + 2])
    for at, name in zip((begin[0], begin[1] - gap / 2, begin[1] + width), INSTANTS):
        sheet.text(at, 4.7, name, size=SMALL)
    # From window to window.
    end = (begin[0] + width + 0.02, ROWS["stones"] + ROW / 2)
    for name in ("sleepers", "ground"):
        sheet.arrow(end, (begin[1] - 0.02, ROWS[name] + ROW / 2), color=LOAD, width=1.6,
                    dashed=True)
    number_in(sheet, end[0] + 0.36, end[1], 5)
    legend = ("full arrows: motion;   dashed arrows: forces;   numbers: the order in a window",
              "1  sleepers: one step under the pad forces at its begin, platen and walls: one step",
              "2  rail and vehicles: one implicit step above the seats at its end",
              "3  ground: explicit steps h, or one implicit step",
              "4  stones: K sub-steps, while nodes move linearly, X_0 + s U with s = k/K",
              "5  mean load S_0/K of each node in this window: the load of the next one")
    for k, words in enumerate(legend):
        sheet.text(0.1, 1.06 - 0.178 * k, words, ha="left", size=SMALL)
    return sheet


def exchange(sheet, x, width, begin, end):
    """What the parts give to each other within the window between two instants."""
    middle = x + width / 2
    for number, name, words in ((2, "rail", "one implicit step"), (1, "sleepers", "one step"),
                                (3, "ground", ""), (4, "stones", "")):
        y = ROWS[name] + ROW / 2
        number_in(sheet, x + 0.115, y, number)
        sheet.text(middle, y, words, size=SMALL)
    top, bottom = ROWS["rail"], ROWS["sleepers"] + ROW
    sheet.arrow((x + 0.2, top), (x + 0.2, bottom), color=LOAD, width=1.4, dashed=True)
    sheet.text(x + 0.28, (top + bottom) / 2, f"pad force\nat {begin}", size=SMALL, ha="left",
               color=LOAD)
    sheet.arrow((x + width - 0.12, bottom), (x + width - 0.12, top), color=MOTION, width=1.4)
    sheet.text(x + width - 0.2, (top + bottom) / 2, f"seats at\n{end}", size=SMALL, ha="right",
               color=MOTION)
    for low, high, up in ((ROWS["stones"] + ROW, ROWS["sleepers"], False),
                          (ROWS["ground"] + ROW, ROWS["stones"], True)):
        ends = ((middle - 0.5, low), (middle - 0.5, high))
        sheet.arrow(*(ends if up else ends[::-1]), color=MOTION, width=1.4)
        sheet.text(middle - 0.4, (low + high) / 2, "motion U of nodes", size=SMALL, ha="left",
                   color=MOTION)


DRAWN = {"coordinates": coordinates, "contact": contact, "vehicle": vehicle, "window": window}


def main():
    default = pathlib.Path(__file__).resolve().parents[1] / "docs/images"
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in DRAWN.items():
        draw().save(folder / f"{name}.svg")


if __name__ == "__main__":
    main()
