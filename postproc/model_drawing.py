"""Drawing of a plane model along the track: ground, ballast, sleepers, rail, train, contact forces.
"""
import dataclasses

import matplotlib.collections
import matplotlib.patches
import numpy as np

import measures
import read

LAYERS = ("#e8dcc0", "#d9c7a0", "#c8b184", "#b79b6c")  # from the top down
STRUCTURE = {"facecolor": "#9aa0a6", "edgecolor": "#4d4d4d", "hatch": "//"}
WEDGE = {"facecolor": "#a9c9a4", "edgecolor": "#4f7a4a", "hatch": ".."}
SHADES = {"structure": ("0.35", 0.30), "wedge": ("tab:green", 0.13)}
STONE = "#8c8c8c"
SLEEPER = "#5b4636"
FORCE = "#c1121f"
RAIL_HEIGHT, WHEEL_RADIUS, AXLE_GAP = 0.172, 0.46, 4.0  # m; axles closer than the last are a bogie
CHAIN_WIDTH = 5.0                                       # points, line of the largest force
BEYOND = 2.5                                            # m, shown before and behind the bed
ABOVE, BELOW = 5.2, 0.2                                 # m, above the ground's top, below its base


@dataclasses.dataclass(frozen=True)
class Chains:
    """Contacts at one instant: lines, m, [contact, end, x and z], and forces, N."""
    lines: np.ndarray
    force: np.ndarray


def contacts(file):
    """The Chains of a field file of contacts."""
    found = read.datasets(file)
    return Chains(found["VTKHDF/Points"].values.reshape(-1, 2, 3)[..., [0, 2]],
                  found["VTKHDF/CellData/force_size"].values.ravel())


def heading(run):
    """What runs over what."""
    train = run.deck.get("train", {})
    vehicles = ", ".join(train.get("vehicles", [])) or "no vehicle"
    return f"{run.deck.get('title', run.name)} ({vehicles}, {3.6 * train.get('speed', 0):.0f} km/h)"


def stamp(figure, run):
    figure.text(0.995, 0.004, f"trackbed {run.version}", fontsize=7, ha="right", va="bottom",
                color="0.4")


def shade_blocks(panel, run, names):
    """Shades the blocks of the ground over x."""
    for number, (name, (low, high)) in enumerate(measures.blocks(run).items()):
        colour, alpha = SHADES["structure" if name == "structure" else "wedge"]
        panel.axvspan(low, high, lw=0, zorder=0, color=colour, alpha=alpha)
        if names:
            panel.text(low, 0.03 + 0.06 * number, f" {name}", fontsize=8,
                       transform=panel.get_xaxis_transform(), va="bottom")


def depth_of(run):
    """Thickness of all layers of the ground, m."""
    return sum(layer["thickness"] for layer in run.deck.get("ground", {}).get("layer", []))


def shape_of(run):
    """Height over length of a Scene."""
    low, high = run.deck["bed"]["x"]
    return (ABOVE + BELOW + depth_of(run)) / (high - low + 2 * BEYOND)


class Scene:
    """A panel with the parts that do not move; `set_chains` and `set_train` add the others."""

    def __init__(self, panel, run):
        self.panel, self.run, self.chains, self.train = panel, run, None, []
        low, high = (float(value) for value in run.deck["bed"]["x"])
        self.ends = low - BEYOND, high + BEYOND
        self._draw_ground(low, high)
        self._draw_stones()
        self.rail = self._draw_track()
        panel.set_aspect("equal")
        panel.set_xlim(*self.ends)
        panel.set_ylim(-depth_of(run) - BELOW, ABOVE)
        panel.set_ylabel("z, m")
        panel.set_xlabel("x along the track, m")

    def _draw_ground(self, low, high):
        ground = self.run.deck.get("ground", {})
        z = 0.0
        for number, layer in enumerate(ground.get("layer", [])):
            thick = layer["thickness"]
            self.panel.add_patch(matplotlib.patches.Rectangle(
                (low, z - thick), high - low, thick, facecolor=LAYERS[number % len(LAYERS)],
                edgecolor="0.5", lw=0.5))
            self.panel.text(high - 0.1, z - thick / 2, f"{layer['name']}, "
                            f"{layer['young'] / 1e6:.0f} MPa", ha="right", va="center", fontsize=8)
            z -= thick
        for block in ground.get("block", []):
            if not block.get("present", True):
                continue
            outline = np.reshape(block["outline"], (-1, 2))
            style = STRUCTURE if block["name"] == "structure" else WEDGE
            self.panel.add_patch(matplotlib.patches.Polygon(outline, lw=0.7, **style))
            self.panel.text(*outline.mean(axis=0), f"{block['name'].replace('_', ' ')}\n"
                            f"{block['young'] / 1e6:.0f} MPa", ha="center", va="center",
                            fontsize=8, bbox={"facecolor": "white", "alpha": 0.7, "lw": 0,
                                              "pad": 1})

    def _draw_stones(self):
        if not self.run.stones:
            return
        stones = list(self.run.stones.values())[-1]
        size = 2 * stones.radius
        self.panel.add_collection(matplotlib.collections.EllipseCollection(
            size, size, np.zeros_like(size), units="xy", offsets=stones.centre,
            transOffset=self.panel.transData, facecolors=STONE, edgecolors="none", alpha=0.45))

    def _draw_track(self):
        """Returns the height of the rail's top. Sleepers outside of the bed are on springs."""
        deck, sleepers = self.run.deck, self.run.deck["sleepers"]
        placed = [stage for stage in deck["stage"] if stage.get("kind") == "sleepers"]
        low = placed[0]["height"] if placed else 0.3
        width, height, spacing = sleepers["width"], sleepers["height"], sleepers["spacing"]
        x = self.run.sleepers_x
        for place in x:
            self.panel.add_patch(matplotlib.patches.Rectangle(
                (place - width / 2, low), width, height, facecolor=SLEEPER, lw=0, zorder=3))
        outside = [*np.arange(x[0] - spacing, self.ends[0], -spacing),
                   *np.arange(x[-1] + spacing, self.ends[1], spacing)]
        for place in outside:
            self.panel.add_patch(matplotlib.patches.Rectangle(
                (place - width / 2, low), width, height, facecolor="white", edgecolor=SLEEPER,
                lw=1, zorder=3))
            zigzag = np.linspace(0, low, 8)
            self.panel.plot(place + 0.06 * np.array([0, 1, -1, 1, -1, 1, -1, 0]), zigzag, lw=0.8,
                            color="0.3")
        top = low + height + RAIL_HEIGHT
        self.panel.plot(self.ends, [top - RAIL_HEIGHT / 2] * 2, color="0.2", lw=2.5, zorder=4)
        return top

    def set_chains(self, chains, largest):
        """Red lines whose width is proportional to the force."""
        if self.chains is None:
            self.chains = self.panel.add_collection(matplotlib.collections.LineCollection(
                [], colors=FORCE, capstyle="round", zorder=2, animated=False))
        self.chains.set_segments(chains.lines)
        self.chains.set_linewidths(CHAIN_WIDTH * chains.force / largest)
        return self.chains

    def set_train(self, axles):
        """Wheels at these x (nan: not on the track), bogies and bodies: a sketch, wheels to scale.
        Every vehicle has the same number of axles."""
        for part in self.train:
            part.remove()
        self.train = []
        vehicles = max(1, len(self.run.deck.get("train", {}).get("vehicles", [])))
        z = self.rail + WHEEL_RADIUS
        for group in np.array_split(np.asarray(axles, float), vehicles):
            there = np.sort(group[np.isfinite(group)])
            if not len(there):
                continue
            for x in there:
                self._add(matplotlib.patches.Circle((x, z), WHEEL_RADIUS, facecolor="0.25",
                                                    edgecolor="k"))
            bogies = np.split(there, np.flatnonzero(np.diff(there) > AXLE_GAP) + 1)
            for bogie in bogies:
                self._add(matplotlib.patches.Rectangle(
                    (bogie[0] - 0.3, z), bogie[-1] - bogie[0] + 0.6, 0.35, facecolor="0.45"))
            if len(there) == len(group):
                self._add(matplotlib.patches.Rectangle(
                    (there[0] - 2, z + 0.5), there[-1] - there[0] + 4, 2.4, facecolor="#dfe7ef",
                    edgecolor="#2f4b66"))
        return self.train

    def _add(self, patch):
        patch.set_zorder(5)
        self.train.append(self.panel.add_patch(patch))
