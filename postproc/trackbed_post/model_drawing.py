"""Drawing of a plane model along the track: ground, ballast, sleepers, rail, train, contact forces.
"""
import dataclasses

import matplotlib.collections
import matplotlib.lines
import matplotlib.patches
import numpy as np

from trackbed_post import (figure_csv, frequencies, ground_blocks, measures, read,
                           train_strip)

LAYERS = ("#e8dcc0", "#d9c7a0", "#c8b184", "#b79b6c")  # from the top down
STRUCTURE = {"facecolor": "#9aa0a6", "edgecolor": "#4d4d4d", "hatch": "//"}
SOFT = {"facecolor": "#a9c9a4", "edgecolor": "#4f7a4a", "hatch": ".."}
STONE = "#8c8c8c"
SLEEPER = "#5b4636"
PACKING = "0.55"
DIRECTION = "direction of travel →"
FORCE = "#c1121f"
RAIL_HEIGHT = 0.172                 # m
CHAIN_WIDTH = 6.0                   # points, line of the largest force
BEYOND = 2.5                        # m, shown before and behind the bed
CUT, BELOW = 2.6, 0.2               # m, shown above the ground's top and below its base


@dataclasses.dataclass(frozen=True)
class Chains:
    """Contacts at one instant: lines, m, [contact, end, x and z], and forces, N."""
    lines: np.ndarray
    force: np.ndarray


def contacts(file):
    """The Chains of a field file of contacts, between the stones' centres of mass; of files without
    them, between the pieces in contact."""
    found = read.datasets(file)
    ends = found["VTKHDF/Points"].values
    if "VTKHDF/PointData/to_centre" in found:
        ends = ends + found["VTKHDF/PointData/to_centre"].values
    return Chains(ends.reshape(-1, 2, 3)[..., [0, 2]],
                  found["VTKHDF/CellData/force_size"].values.ravel())


def heading(run):
    """What runs over what, and that a plane model has no load spread across the track."""
    train = run.deck.get("train", {})
    vehicles = ", ".join(train.get("vehicles", [])) or "no vehicle"
    return (f"{run.deck.get('title', run.name)} ({vehicles}, "
            f"{3.6 * train.get('speed', 0):.0f} km/h; plane model, "
            f"{run.deck.get('thickness', 0):g} m thick)")


def ends_of(run):
    """x of both ends of a drawing, m."""
    low, high = (float(value) for value in run.deck["bed"]["x"])
    return low - BEYOND, high + BEYOND


def depth_of(run):
    """Thickness of all layers of the ground, m."""
    return sum(layer["thickness"] for layer in run.deck.get("ground", {}).get("layer", []))


def shape_of(run, top):
    """Height over length of a Scene up to z = `top`."""
    low, high = ends_of(run)
    return (top + BELOW + depth_of(run)) / (high - low)


def underside(run):
    """z of the undersides of the sleepers when they were placed, m."""
    placed = [stage for stage in run.deck.get("stage", []) if stage.get("kind") == "sleepers"]
    return placed[0]["height"] if placed else 0.3


def displacements(run):
    """Vertical displacement of each sleeper of the bed since it was placed, m: at the end of the
    run, as the stones of a drawing are; 0 where it was not recorded."""
    if "displacement" not in run.sleeper or not len(run.sleeper["displacement"].values):
        return np.zeros(len(run.sleepers_x))
    return np.nan_to_num(run.sleeper["displacement"].values[-1])


def close_up(run):
    """Lowest and highest z of a picture of bed, sleepers and rail, m."""
    return -0.12, underside(run) + run.deck["sleepers"]["height"] + RAIL_HEIGHT + 0.5


def modulus(pascal):
    return f"{pascal / 1e9:g} GPa" if pascal >= 1e9 else f"{pascal / 1e6:g} MPa"


class Scene:
    """A panel with the parts that do not move; `set_chains` and `set_train` add the others."""

    def __init__(self, panel, run, top):
        self.panel, self.run, self.chains, self.train = panel, run, None, []
        self.ends = ends_of(run)
        self._draw_ground()
        self._draw_stones()
        self.rail = self._draw_track()
        panel.set_aspect("equal")
        panel.set_xlim(*self.ends)
        panel.set_ylim(-depth_of(run) - BELOW, top)
        panel.set_ylabel("z, m")
        panel.set_xlabel("x along the track, m")

    def _draw_ground(self):
        ground = self.run.deck.get("ground", {})
        low, high = ground.get("x", self.run.deck["bed"]["x"])
        z = 0.0
        for number, layer in enumerate(ground.get("layer", [])):
            thick = layer["thickness"]
            self.panel.add_patch(matplotlib.patches.Rectangle(
                (low, z - thick), high - low, thick, facecolor=LAYERS[number % len(LAYERS)],
                edgecolor="0.5", lw=0.5))
            self.panel.text(high - 0.1, z - thick / 2, f"{layer['name']}, "
                            f"{modulus(layer['young'])}", ha="right", va="center", fontsize=9,
                            clip_on=True)
            z -= thick
        for given, block in zip(ground.get("block", []), ground_blocks.every(self.run)):
            if not block.present:
                continue
            outline = np.reshape(given["outline"], (-1, 2))
            style = STRUCTURE if block.structure else SOFT
            self.panel.add_patch(matplotlib.patches.Polygon(outline, lw=0.7, **style))
            self.panel.text(*outline.mean(axis=0), f"{block.label}, {modulus(block.young)}",
                            ha="center", va="center", fontsize=9,
                            clip_on=True, bbox={"facecolor": "white", "alpha": 0.75, "lw": 0,
                                                "pad": 1})
        if z < 0:
            self.panel.text((low + high) / 2, z - 0.02,
                            f"base {ground.get('base', 'fixed')}, sides "
                            f"{ground.get('sides', 'free')}", ha="center", va="top", fontsize=7,
                            clip_on=True)

    def _draw_stones(self):
        if not self.run.stones:
            return
        stones = list(self.run.stones.values())[-1]
        size = 2 * stones.radius
        self.panel.add_collection(matplotlib.collections.EllipseCollection(
            size, size, np.zeros_like(size), units="xy", offsets=stones.centre,
            transOffset=self.panel.transData, facecolors=STONE, edgecolors="none", alpha=0.45,
            rasterized=True))

    def _draw_track(self):
        """Returns the height of the rail's top. White sleepers are on springs, outside of the bed.
        The model's rail is even: seats of sleepers that have settled more are packed up."""
        deck, sleepers = self.run.deck, self.run.deck["sleepers"]
        low = underside(self.run)
        width, height, spacing = sleepers["width"], sleepers["height"], sleepers["spacing"]
        x, settled = self.run.sleepers_x, displacements(self.run)
        foot = low + height + max(settled, default=0.0)
        places = measures.sleepers_of_track(deck.get("track", {}), spacing)
        before = min(deck.get("seat", {}).get("before", 0), len(places) - 1)
        begin = x[0] - places[before]
        end = begin + deck.get("track", {}).get("length", 0)
        for place in begin + places:
            on_bed = x[0] - spacing / 2 < place < x[-1] + spacing / 2
            top = low + height + np.interp(place, x, settled) if on_bed else foot
            self._box(place - width / 2, top - height, width, height, lw=0 if on_bed else 1,
                      facecolor=SLEEPER if on_bed else "white", edgecolor=SLEEPER, zorder=3)
            self._box(place - width / 4, top, width / 2, foot - top, lw=0, facecolor=PACKING,
                      zorder=3)
            if not on_bed:
                for line in (*self.panel.plot(place + 0.06 * np.array([0, 1, -1, 1, -1, 1, -1, 0]),
                                              np.linspace(0, top - height, 8), lw=0.8, color="0.3"),
                             *self.panel.plot([place - 0.2, place + 0.2], [0, 0], lw=1.2,
                                              color="0.3")):
                    figure_csv.name(line, f"spring at x = {place:.2f} m")
        self.panel.text(self.ends[0] + 0.1, -0.08, "sleepers\non springs", fontsize=8, va="top",
                        clip_on=True)
        self._box(max(begin, self.ends[0]), foot, min(end, self.ends[1]) - max(begin, self.ends[0]),
                  RAIL_HEIGHT, facecolor="0.25", lw=0, zorder=4)
        return foot + RAIL_HEIGHT

    def _box(self, x, z, width, height, **style):
        self.panel.add_patch(matplotlib.patches.Rectangle((x, z), width, height, **style))

    def set_chains(self, chains, largest):
        """Red lines whose width is proportional to the force."""
        if self.chains is None:
            self.chains = self.panel.add_collection(matplotlib.collections.LineCollection(
                [], colors=FORCE, capstyle="round", zorder=2.5, rasterized=True))
        self.chains.set_segments(chains.lines)
        self.chains.set_linewidths(CHAIN_WIDTH * chains.force / largest)
        figure_csv.state(self.chains, "contact force, N", chains.force)
        return self.chains

    def key_of_chains(self, largest):
        """Artists and labels of a legend: what the width of a line is; `largest` force, N."""
        kilonewtons = largest / 1e3
        return ([matplotlib.lines.Line2D([], [], color=FORCE, lw=CHAIN_WIDTH)],
                [f"contact force, width proportional; this line: "
                 f"{kilonewtons:.{0 if kilonewtons >= 10 else 2}f} kN in a model "
                 f"{self.run.deck.get('thickness', 1):g} m thick"])

    def set_train(self, axles):
        """Wheels at these x (nan: not on the track), and a sketch of bogies and bodies if all
        vehicles have the same number of axles."""
        for part in self.train:
            part.remove()
        self.train = []
        axles = np.asarray(axles, float)
        vehicles = max(1, len(self.run.deck.get("train", {}).get("vehicles", [])))
        radius = self.run.deck.get("wheel_rail", {}).get("wheel_radius", 0.46)
        z = self.rail + radius
        for x in axles[np.isfinite(axles)]:
            self._add(matplotlib.patches.Circle((x, z), radius, facecolor="0.25", edgecolor="k"))
        for group in np.split(axles, vehicles) if len(axles) % vehicles == 0 else ():
            there = np.sort(group[np.isfinite(group)])
            if not len(there):
                continue
            for bogie in frequencies.bogies_of(there):
                self._add(matplotlib.patches.Rectangle(
                    (bogie[0] - 0.3, z), bogie[-1] - bogie[0] + 0.6, 0.3, facecolor="0.45"))
            if len(there) == len(group):
                beyond = train_strip.OVERHANG
                self._add(matplotlib.patches.Rectangle(
                    (there[0] - beyond, z + 0.45), there[-1] - there[0] + 2 * beyond, 2.4,
                    **train_strip.BODY))
        return self.train

    def _add(self, patch):
        patch.set_zorder(5)
        self.train.append(self.panel.add_patch(patch))
