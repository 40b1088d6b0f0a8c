"""Figures of a track alone along the track: extremes of all steps of one run (envelope) and of
several beside each other (compare), with run-ins, ends of the ground and its blocks.
"""
import dataclasses

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import figure_csv, panels, shades, track_stretch
from trackbed_post.track_stretch import run_in_of, two_rails

HEAD = 0.16  # of the height of a panel, above curves, for names of blocks


def shade_run_ins(panel, decks):
    """Shades the run-ins of these tracks over x, which numbers leave out; one entry of the legend.
    """
    spans = {(run_in_of(deck), deck["track"]["length"]) for deck in decks
             if deck.get("model") in ("track", "track_on_ground")}
    label = "run-in, not counted"
    for run_in, length in sorted(span for span in spans if span[0] > 0):
        for low, high in ((0, run_in), (length - run_in, length)):
            panel.axvspan(low, high, lw=0, zorder=0, label=label, **shades.RUN_IN)
            label = panels.HIDDEN


def x_of(what, deck):
    """Label of the axis x of a figure along the track."""
    ground = track_stretch.ground_of(deck)
    shift = f" (of the ground: less {ground.origin:g} m)" if ground else ""
    return f"{what} from the start of the track{shift}, m"


def mark_ground(panel, deck, named=False, only="", common=()):
    """Shades the blocks of the ground and marks its ends, with one entry of the legend; `named`:
    with the names of the blocks, above the curves; `only`: words behind names that are not those
    of `common` blocks."""
    ground = track_stretch.ground_of(deck)
    if ground is None:
        return
    label = "end of the ground"
    for x in ground.extent:
        panel.axvline(x, color="0.35", lw=0.9, ls=(0, (6, 3)), label=label)
        label = panels.HIDDEN
    blocks = [dataclasses.replace(one, label=one.label + only * (one not in common))
              for one in track_stretch.blocks_of(deck)]
    shades.shade(panel, blocks)
    if named and blocks:
        low, high = panel.get_ylim()
        panel.set_ylim(low, high + HEAD * (high - low))
        shades.name(panel, blocks)


def sides(run, name, twice):
    """Label -> values of the places of each rail, left before right."""
    values = run[name].values.ravel()
    return {", left": values[::2], ", right": values[1::2]} if twice else {"": values}


def draw_extremes(run, x, panel):
    """Least and largest displacement of rail and sleepers."""
    number, twice = 0, two_rails(run)
    for what, style in (("rail", "-"), ("sleeper", "--")):
        if f"envelope/{what}/displacement_min" not in run:
            continue
        most = sides(run, f"envelope/{what}/displacement_max", twice)
        for side, least in sides(run, f"envelope/{what}/displacement_min", twice).items():
            look = panels.curve(number, len(x))
            below, = panel.plot(x, 1e3 * least, style, lw=0.9, label=f"{what}{side}", **look)
            above, = panel.plot(x, 1e3 * most[side], style, lw=0.9, **look)
            for one, end in ((below, "least"), (above, "largest")):
                figure_csv.name(one, f"{what}{side}, {end}")
            number += 1
    panel.set(ylabel=f"least and largest\ndisplacement, {panels.UP}")


def draw_envelope(run, deck):
    """Extremes of all steps along the track; None for results without them."""
    if "envelope/x" not in run:
        return None
    twice = two_rails(run)
    x = run["envelope/x"].values.ravel()[::1 + twice]
    seats = "envelope/sleeper/seat_force_max" in run
    figure, grid = plt.subplots(1 + seats, 1, figsize=(8, 3.6 + 2.5 * seats), sharex=True,
                                squeeze=False, layout="constrained")
    draw_extremes(run, x, grid[0, 0])
    if seats:
        for number, (side, most) in enumerate(
                sides(run, "envelope/sleeper/seat_force_max", twice).items()):
            grid[1, 0].plot(x, most / 1e3, lw=0.9, label=f"largest{side}",
                            **panels.curve(number, len(x)))
        grid[1, 0].set(ylabel="seat load, kN")
    grid[-1, 0].set(xlabel=x_of("x", deck))
    for row, panel in enumerate(grid[:, 0]):
        shade_run_ins(panel, [deck])
        mark_ground(panel, deck, row == 0)
        panel.grid(alpha=0.3)
        panels.legend_above(panel)
    what = f"Displacement{' and seat loads' if seats else ''}, extremes of all steps"
    figure.suptitle(panels.wrapped("; ".join(filter(None, (
        what, words_of([""], [run], [deck]), track_stretch.state(run, deck)))), 8, 11), fontsize=11)
    return figure


def envelopes(run):
    """(label, x, values, axis) of the envelopes that runs are compared by: the lowest rail and the
    largest seat load, of two rails those of the left one."""
    if "envelope/x" not in run:
        return
    twice = two_rails(run)
    x = run["envelope/x"].values.ravel()[::1 + twice]
    for name, factor, axis in (("envelope/rail/displacement_min", 1e3, f"lowest rail, {panels.UP}"),
                               ("envelope/sleeper/seat_force_max", 1e-3,
                                "largest seat load, kN")):
        if name in run:
            side = " (left rail)" if twice else ""
            yield x, factor * run[name].values.ravel()[::1 + twice], axis + side


def words_of(names, runs, decks):
    """How far the rail goes down in each run, in the part that counts, and the largest seat load;
    empty without envelopes there. One run needs no name."""
    if any("track" not in deck for deck in decks):
        return ""
    found, over = [], dict.fromkeys(track_stretch.counted(deck).words for deck in decks)
    for what, path, pick, factor, unit in (
            ("rail lowered by up to", "envelope/rail/displacement_min", np.min, -1e3, "mm"),
            ("seat load up to", "envelope/sleeper/seat_force_max", np.max, 1e-3, "kN")):
        values = []
        for name, run, deck in zip(names, runs, decks):
            if path not in run or "envelope/x" not in run:
                break
            there = track_stretch.shown(run, deck)
            if not there.any():
                break
            most = factor * float(pick(run[path].values.ravel()[there]))
            values.append(f"{most:.3g} {unit}" + (f" ({name})" if name else ""))
        if values and len(values) == len(runs):
            found.append(f"{what} {' and '.join(values)}")
    where = next(iter(over)).strip() if len(over) == 1 else ""
    grounds = [track_stretch.ground_of(deck) for deck in decks]
    if where and all(one and len(one.judged) < len(one.sleepers) for one in grounds):
        where += " without its ends"
    return f"{where} ".lstrip() + ", ".join(found) if found else ""


def draw_beside(names, runs, decks):
    """Envelopes of several runs in one picture; None if they have none in common."""
    found = [{axis: (x, values) for x, values, axis in envelopes(run)} for run in runs]
    axes = [axis for axis in found[0] if all(axis in one for one in found)]
    if not axes:
        return None
    figure, grid = plt.subplots(len(axes), 1, figsize=(8, 1.6 + 2.5 * len(axes)), sharex=True,
                                squeeze=False, layout="constrained")
    grounds = [track_stretch.ground_of(deck) for deck in decks]
    alike = all(one and grounds[0] and one.origin == grounds[0].origin
                and one.extent == grounds[0].extent for one in grounds)
    blocks = [track_stretch.blocks_of(deck) for deck in decks]
    common = [block for block in blocks[0] if all(block in one for one in blocks)]
    for row, (axis, panel) in enumerate(zip(axes, grid[:, 0])):
        for number, (name, one) in enumerate(zip(names, found)):
            panel.plot(*one[axis], ("-", "--", "-.", ":")[number % 4], lw=1, label=name)
        panel.set(ylabel=axis)
        panel.grid(alpha=0.3)
        shade_run_ins(panel, decks)
        if alike:
            mark_ground(panel, decks[0], row == 0, f" ({names[0]})", common)
    panels.legend_above(grid[0, 0])
    grid[-1, 0].set(xlabel=x_of("x", decks[0] if alike else {}))
    states = [f"{name}: {one}" for name, run, deck in zip(names, runs, decks)
              if (one := track_stretch.state(run, deck))]
    figure.suptitle(panels.wrapped("; ".join(filter(None, (
        "Lowest rail and largest seat loads", words_of(names, runs, decks),
        *states))), 8, 11), fontsize=11)
    return figure


def names_of(folders):
    """Different names for result folders: the last one, or if they are equal the last two."""
    names = [folder.resolve().name for folder in folders]
    if len(set(names)) < len(names):
        names = ["/".join(folder.resolve().parts[-2:]) for folder in folders]
    return names


def table_beside(names, columns):
    """One line per number that any run has, one column per run; of two runs also the change from
    the first to the second, without that of places."""
    rows = list(dict.fromkeys((name, one[name][1]) for one in columns for name in one))
    width = max(12, *(len(name) + 2 for name in names))
    first = max((len(name) for name, _ in rows), default=0)
    head = f"  change from {names[0]} to {names[-1]}" if len(names) == 2 else ""
    lines = [f"{'':{first}} {'unit':6}" + "".join(f"{name:>{width}}" for name in names) + head]
    for name, unit in rows:
        values = [one.get(name, (np.nan, unit))[0] for one in columns]
        line = f"{name:{first}} {unit:6}" + "".join(
            f"{value:{width}.4g}" if np.isfinite(value) else f"{'-':>{width}}" for value in values)
        if head and unit != "m" and np.isfinite(values).all() and values[0]:
            line += f"{f'{(values[1] - values[0]) / abs(values[0]):+.1%}':>{len(head)}}"
        lines.append(line)
    return "\n".join(lines) + "\n"
