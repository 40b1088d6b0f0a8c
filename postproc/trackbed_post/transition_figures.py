"""Pictures and film of a train over a transition zone: of transition.Train objects, of one run or
of two compared.
"""
import textwrap

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import (bed_warnings, figure_csv, film_files, ground_blocks, judgement,
                           measures, model_drawing, panels, read, shades, transition_verdict,
                           write)
from trackbed_post.zones import REACHED

# Blue and orange differ for colour-blind readers; lines differ by style, too, for grey prints.
STYLES = tuple({"color": colour, "ls": line}
               for colour, line in zip(("#0b559f", "#d95f02"), panels.LINES))
WRAP = 118           # characters of a line below transition.png
LIGHT = 0.3          # opacity of the rail where it is not judged
WRAP_TITLE = 108     # of one above a panel
NEAR = 2.0           # m, shown around a transition
BETWEEN = 2.68       # inches, of the texts between both panels of the model above its lower edge


def mark_judged(panel, trains, changes):
    """The two levels, and where most of the change has occurred."""
    for train, change, style in zip(trains, changes, STYLES):
        edge = ground_blocks.edge_of_structure(train.run)
        at = edge + ground_blocks.direction(train.run, edge) * change.width
        goal = change.structure + REACHED * (change.plain - change.structure)
        panel.plot(at, -1e3 * goal, marker="D", ms=8, mfc="white", mew=1.8, color=style["color"],
                   zorder=5, ls="", label=f"{REACHED:.0%} of the change, {train.name}")


def mark_places(force, level, trains, changes):
    """Where the steepest change and the largest wheel force of the transition are."""
    hidden = transition_verdict.in_scatter(changes)  # stands for no place, as the text states
    for number, (train, change, style) in enumerate(zip(trains, changes, STYLES)):
        x, colour = train.run.sleepers_x, style["color"]
        there = np.abs(x - change.steepest_x) <= measures.spacing(train.run) / 2 + measures.TINY
        if not hidden[number]:
            level.plot(x[there], -1e3 * train.rail_down()[there], lw=8, alpha=0.35, color=colour,
                       solid_capstyle="butt", label=f"steepest change, {train.name}")
        force.plot(change.force_x, 1e-3 * change.force, ls="", marker="os"[number], ms=9, mew=1.8,
                   mfc="none", color=colour, label=f"largest of these, {train.name}")


def bracket_zones(panel, train, zone):
    """Brackets at the lower edge from the first to the last of the sleepers that are judged
    together; neighbouring parts share a sleeper."""
    panel.margins(y=0.18)
    across = panel.get_xaxis_transform()
    apart = measures.spacing(train.run) / 10
    for words, part in (("structure", zone.structure), ("transition", zone.transition),
                        ("plain track", zone.plain)):
        x = train.run.sleepers_x[part]
        low, high = x.min() + apart, x.max() - apart
        panel.plot([low, low, high, high], [0.06, 0.03, 0.03, 0.06], color="0.2", lw=1.2,
                   transform=across)
        panel.text((low + high) / 2, 0.07, words, transform=across, fontsize=8, ha="center",
                   va="bottom")


def wrapped(text):
    """Paragraphs in lines of WRAP characters."""
    return "\n".join(textwrap.fill(line, WRAP) for line in text.splitlines())


def draw_judged(panel, x, values, span, label, **style):
    """A line that is lighter beyond the span of the sleepers that are judged, m."""
    judged = (x >= span[0] - measures.TINY) & (x <= span[1] + measures.TINY)
    first, last = np.flatnonzero(judged)[[0, -1]]
    for part in (slice(first + 1), slice(last, None)):
        light, = panel.plot(x[part], values[part], alpha=LIGHT, label=panels.HIDDEN, **style)
        figure_csv.name(light, f"{label}, not judged")
    panel.plot(x[judged], values[judged], label=label, **style)


def draw_train(force, level, settled, train, style):
    """The curves of a run; `settled` None without stones. Sleepers at the ends of the bed, which
    are not judged, have hollow marks; rail and wheel forces have a lighter line there."""
    x, ends = train.run.sleepers_x, ground_blocks.at_ends(len(train.run.sleepers_x), True)
    span = x[~ends].min(), x[~ends].max()
    draw_judged(level, x, -1e3 * train.rail_down(), span,
                lw=2, label=f"rail, {train.name}", **style)
    sleepers, = level.plot(x, -1e3 * train.sleeper_down(), lw=1, marker="o", ms=3,
                           label=f"sleepers, {train.name}", **style)
    panels.mark_ends(level, sleepers, ends, panels.HIDDEN)
    if settled:
        into_bed, = settled.plot(x, -1e3 * train.settlement(), lw=1.2, marker="s", ms=3,
                                 label=train.name, **style)
        panels.mark_ends(settled, into_bed, ends, panels.HIDDEN)
    place, most = train.largest_force()
    draw_judged(force, place, 1e-3 * most, span, lw=1.3, label=train.name, **style)


def name_axes(force, level, settled, x):
    """Labels of the axes, `x` that along the track, and the entry for what is not judged, the same
    for all runs."""
    for panel, marker in ((level, "o"), (settled, "s")):
        if panel:
            panel.plot([], [], ls="", marker=marker, ms=3, color="0.2", mfc="white", mew=0.8,
                       label="not judged (hollow, light)")
    level.set_ylabel(f"lowest level of rail and\nsleepers under the train,\n{panels.UP}")
    force.set_ylabel("largest wheel force\nof all axles, kN")
    (settled or force).set_xlabel(x)
    for panel in filter(None, (level, force, settled)):
        panel.tick_params(labelbottom=True)
    if settled:
        settled.set_ylabel(f"sleepers after the\ntrain, relative to\nthe ground,\n{panels.UP}")
        # Smaller settlements, which are noise, look as small as they are.
        low, high = settled.get_ylim()
        settled.set_ylim(min(low, -1e3 * bed_warnings.SETTLES),
                         max(high, 1e3 * bed_warnings.SETTLES))
    # Above the right end of the first panel, where no legend is.
    level.annotate(model_drawing.DIRECTION, (1, 1), (0, 4), xycoords="axes fraction",
                   textcoords="offset points", ha="right", va="bottom", fontsize=9)


NAMES, HEIGHTS = ("level", "wheel force", "sleepers after the train"), (1.4, 1, 0.8)  # of panels


def compare(trains, changes, titles, sentence):
    """Panels along the track, all designs in each: that with the answer first. `titles`: what each
    shows, as sentences; two without stones, whose panel would be the third."""
    stretches = ground_blocks.stretches(trains[0].run)
    count = len(titles)
    high = 10 * sum(HEIGHTS[:count]) / sum(HEIGHTS)  # inches
    figure, drawn = plt.subplots(count, 1, figsize=(10, high), sharex=True,
                                 gridspec_kw={"height_ratios": HEIGHTS[:count]})
    level, force, settled = (*drawn, None)[:3]
    for train, style in zip(trains, STYLES):
        draw_train(force, level, settled, train, style)
    mean = 1e-3 * trains[0].mean_force()
    force.axhline(mean, color="0.3", lw=0.8,
                  label=f"mean of {trains[0].of_mean}, {judgement.shown(mean)} kN"
                  + f" ({trains[0].name})" * (len(trains) > 1))
    if changes:
        mark_judged(level, trains, changes)
        mark_places(force, level, trains, changes)
        bracket_zones(level, trains[0], changes[0].zone)
    name_axes(force, level, settled, trains[0].axis)
    figure.suptitle(trains[0].heading(), fontsize=11)
    for panel, title, name in zip(drawn, titles, NAMES):
        panel.set_label(name)
        shades.shade(panel, stretches)
        panel.grid(alpha=0.3)
        panels.legend_above(panel)
        panels.title_above(panel, textwrap.fill(title, WRAP_TITLE), weight="bold")
    shades.name(level, stretches)
    text = wrapped(sentence)
    below = 0.18 * (text.count("\n") + 1)  # inches
    figure.set_figheight(high + below)
    figure.text(0.02, 0.03, text, fontsize=10, va="bottom")
    for _ in range(2):  # the first may change the ticks, whose labels have other widths
        figure.tight_layout(rect=(0, 0.04 + below / (high + below), 1, 1))
    return figure


def instants(train, folder):
    """(row of the passage, time, s, file of contacts) of each field file within the passage, from
    the first to the last at which a wheel is shown."""
    low, high = model_drawing.ends_of(train.run)
    found = []
    for time, file in read.series(folder, "contacts"):
        row = int(np.argmin(np.abs(train.passing.time - time)))
        if abs(train.passing.time[row] - time) <= 2 * np.median(np.diff(train.passing.time)):
            found.append((row, time, file))
    shown = [k for k, (row, *_) in enumerate(found)
             if np.any((train.passing.x[row] > low) & (train.passing.x[row] < high))]
    return found[shown[0]:shown[-1] + 1] if shown else []


def largest_contact(chains, span):
    """(N, x in m) of the largest contact force whose middle is in the span; 0 without any."""
    x = chains.lines[..., 0].mean(axis=1)
    force = np.where((x >= span[0]) & (x <= span[1]), chains.force, 0.0)
    most = int(np.argmax(force)) if len(force) else None
    return (0.0, float(np.mean(span))) if most is None else (float(force[most]), float(x[most]))


def span_of_interest(run):
    """From NEAR before the structure's edge to NEAR behind the wedge, x in m; of a run without a
    structure the whole bed."""
    edge = ground_blocks.edge_of_structure(run)
    if edge is None:
        return float(run.sleepers_x[0]), float(run.sleepers_x[-1])
    turn = ground_blocks.direction(run, edge)
    ends = edge - turn * NEAR, edge + turn * (ground_blocks.wedge_length(run) + NEAR)
    return min(ends), max(ends)


def instant_shown(train, row, forces):
    """What a picture of the model shows, and at which instant, in one line."""
    words = ground_blocks.listed(ground_blocks.measures_of(train.run))
    model = f"Model with {words}" if words else "Model"
    time = f"at {train.passing.time[row]:.3f} s"
    return f"{model}; contact forces {time}" if forces else \
        f"{model}; train {time}, the instant of the largest wheel force"


def note_of_model(run):
    """What the title leaves out: the train, and that stones and sleepers are later ones."""
    train = run.deck.get("train", {})
    count = len(train.get("vehicles", []))
    return (f"{count} vehicle{'s' * (count != 1)}, {3.6 * train.get('speed', 0):.0f} km/h\n"
            f"stones and sleepers: end of the run (last row: {run.time[-1]:.3f} s)")


def show_forces(figure, scenes, forces, span):
    """(row of the passage, place, m) of the instant with the largest contact force in the span,
    whose forces the scenes then show; explained between both panels: above the bed it would hide
    the train, in the ground names of layers."""
    chains, row = max(forces, key=lambda each: largest_contact(each[0], span)[0])
    largest = chains.force.max(initial=0)
    for scene in scenes:
        scene.set_chains(chains, largest)
    figure.legend(*scenes[0].key_of_chains(largest), loc="center", frameon=False,
                  bbox_to_anchor=(0.5, BETWEEN / figure.get_figheight()), fontsize=9)
    return row, largest_contact(chains, span)[1]


def name_parts(panel, run, rail, wheels):
    """Names sleepers and ballast above the left end of an enlarged bed, where usually no wheel is,
    and the rail where it is furthest from these `wheels` (x, m); `rail`: z of its top, m."""
    low, high = panel.get_xlim()
    x, width = run.sleepers_x, run.deck["sleepers"]["width"]
    inside = x[(x > low + width) & (x < high - width)]
    if len(inside) < 4:
        return
    free = max(inside[2:], key=lambda place: np.nanmin(np.abs(wheels - place), initial=np.inf))
    low = model_drawing.underside(run)
    for words, place, z in (("sleeper", inside[0], low + run.deck["sleepers"]["height"] / 2),
                            ("ballast", inside[1:3].mean(), low / 2), ("rail", free, rail)):
        panel.annotate(words, (place, z), (place, rail + 0.25), fontsize=9, ha="center",
                       va="center", zorder=6, clip_on=True,
                       bbox={"facecolor": "white", "alpha": 0.75, "lw": 0, "pad": 1},
                       arrowprops={"arrowstyle": "-|>", "color": "0.1", "lw": 1.2})


def draw_model(train, folder):
    """The model at the instant of the field files when the largest contact force around the
    transition is greatest, and the bed there enlarged."""
    shape = model_drawing.shape_of(train.run, model_drawing.CUT)
    figure = plt.figure(figsize=(13, 12.2 * shape + 3.75))
    size = np.array([figure.get_figwidth(), figure.get_figheight()] * 2)
    panel = figure.add_axes(np.array([0.6, 3.2, 12.2, 12.2 * shape]) / size)
    close = figure.add_axes(np.array([0.6, 0.6, 12.2, 1.7]) / size)
    scenes = [model_drawing.Scene(each, train.run, model_drawing.CUT) for each in (panel, close)]
    forces = [(model_drawing.contacts(file), row) for row, _, file in instants(train, folder)]
    if forces:
        row, middle = show_forces(figure, scenes, forces, span_of_interest(train.run))
    else:
        on_bed = np.where(train.passing.on_bed()[..., None], train.passing.force, np.nan)
        row = int(np.nanargmax(np.nanmax(on_bed, axis=(1, 2), initial=-1)))
        middle = float(np.mean(train.run.sleepers_x))
        figure.text(0.5, BETWEEN / size[1], "no contact forces: no field files within the passage",
                    ha="center", va="center", fontsize=9)
    figure.text(0.6 / size[0], (BETWEEN + 0.1) / size[1], model_drawing.DIRECTION, fontsize=11,
                va="center")
    figure.text(0.6 / size[0], (BETWEEN - 0.15) / size[1],
                "frame: enlarged below; grey on sleepers: packings", fontsize=9, va="center")
    figure.text(12.8 / size[0], BETWEEN / size[1], note_of_model(train.run), fontsize=9,
                ha="right", va="center")
    for scene in scenes:
        scene.set_train(train.passing.x[row])
    low, high = model_drawing.close_up(train.run)
    close.set_ylim(low, high)
    half = 0.5 * (high - low) * 12.2 / 1.7
    close.set_xlim(middle - half, middle + half)
    name_parts(close, train.run, scenes[1].rail, train.passing.x[row].ravel())
    panel.set_xlabel("")
    panel.set_title(instant_shown(train, row, bool(forces)), fontsize=11)
    panel.indicate_inset((middle - half, low, 2 * half, high - low), edgecolor="k", lw=1)
    return figure


class Film:
    """Figure of a film: the first run above, the level of the rail of all designs below it.
    `largest`: contact force in the film, N."""

    def __init__(self, trains, largest, origin):
        run = trains[0].run
        # The upper panel has the shape of its contents, so that both have the same axis along x.
        long, left, bottom = 11.2, 0.85, 3.5  # inches
        high = long * model_drawing.shape_of(run, model_drawing.CUT)
        self.figure = plt.figure(figsize=(long + left + 0.2, bottom + high + 0.65))
        size = np.array([self.figure.get_figwidth(), self.figure.get_figheight()] * 2)
        self.panel = self.figure.add_axes(np.array([left, bottom, long, high]) / size)
        self.level = self.figure.add_axes(np.array([left, 0.6, long, 2.3]) / size,
                                          sharex=self.panel)
        self.trains, self.largest = trains, largest
        self.scene = model_drawing.Scene(self.panel, run, model_drawing.CUT)
        self.panel.set_xlabel("")
        self.panel.set_title(model_drawing.heading(run), pad=22)
        self._prepare_levels()
        # Between both panels: above the bed it would hide the train, in the ground names of layers.
        self.figure.legend(*self.scene.key_of_chains(largest), loc="center", frameon=False,
                           bbox_to_anchor=((left + long / 2) / size[0], 3.07 / size[1]), fontsize=9)
        write.state_origin(self.figure, origin)
        # Between title and panel, where no vehicle comes.
        self.clock = self.panel.annotate("", (0, 1), (0, 4), xycoords="axes fraction",
                                         textcoords="offset points", va="bottom", fontsize=10)
        self.figure.canvas.draw()
        self.still = self.figure.canvas.copy_from_bbox(self.figure.bbox)

    def _prepare_levels(self):
        shades.shade(self.level, ground_blocks.stretches(self.trains[0].run))
        lowest = max(1e3 * train.rail_down().max() for train in self.trains)
        self.level.set(xlabel="x along the track, m", ylim=(-1.1 * lowest, 0.3 * lowest))
        self.level.set_ylabel(f"level of the rail, {panels.UP}", fontsize=9)
        self.level.grid(alpha=0.3)
        self.lines = [self.level.plot([], [], lw=2, label=train.name, **style)[0]
                      for train, style in zip(self.trains, STYLES)]
        self.deepest = [self.level.plot([], [], lw=0.8, label=f"lowest up to then, {train.name}",
                                        **style)[0] for train, style in zip(self.trains, STYLES)]
        self.level.legend(fontsize=8, loc="upper center", ncols=4, frameon=False)  # above them

    def _set_levels(self, row):
        """Of all designs when their first axles are where that of the first run is at a row."""
        x = self.trains[0].passing.x[row, 0]
        for train, line, lower in zip(self.trains, self.lines, self.deepest):
            passing = train.passing
            at = int(np.nanargmin(np.abs(passing.x[:, 0] - x))) if np.isfinite(x) else \
                min(row, len(passing.time) - 1)
            up = 1e3 * (passing.rail - passing.rail[passing.first])
            line.set_data(train.run.sleepers_x, up[at])
            # Before the row from which levels count, rail and sleepers still find their places.
            since = up[min(passing.first, at):at + 1]
            lower.set_data(train.run.sleepers_x, since.min(axis=0) if at >= passing.first else
                           np.full(len(train.run.sleepers_x), np.nan))

    def picture(self, row, chains, words):
        """Pixels of an instant; `words` follow the direction of travel."""
        self.figure.canvas.restore_region(self.still)
        moving = [self.scene.set_chains(chains, self.largest),
                  *self.scene.set_train(self.trains[0].passing.x[row])]
        self.clock.set_text(f"{model_drawing.DIRECTION}     {words}")
        self._set_levels(row)
        for artist in (*moving, self.clock, *self.deepest, *self.lines):
            artist.axes.draw_artist(artist)
        return np.array(self.figure.canvas.buffer_rgba())[..., :3]


def film(trains, folder, origin):
    """Pictures of the first run, with the level of the rail of all designs below when their first
    axles are where that of the first run is; thin: the lowest level up to then. Each states the
    time of its field file."""
    shots = [(row, time, model_drawing.contacts(file))
             for row, time, file in instants(trains[0], folder)]
    pace = film_files.pace([time for _, time, _ in shots])
    drawn = Film(trains, max(chains.force.max(initial=0) for *_, chains in shots), origin)
    for row, time, chains in shots:
        yield drawn.picture(row, chains, "     ".join(filter(None, (f"time {time:.3f} s", pace))))
    plt.close(drawn.figure)
