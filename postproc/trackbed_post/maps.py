"""Maps of fields in a plane through the model: arrows of vectors, filled contours of numbers.

What is in the plane, and how values between points are found: field_sections.py.
"""
import matplotlib.pyplot as plt
import matplotlib.ticker
import numpy as np

from trackbed_post import (curves, field_files, field_sections, figure_csv, passage_instant, read,
                           write)

COLUMNS = 80      # arrows along the longer side at most
MARGIN = 0.02     # of it, around arrows
USUAL = 0.99      # quantile where arrows end, if the largest is more than OUTLIER times as long
OUTLIER = 2.0
GRID = 50000      # places in the window at which contours are computed
LEAST = 20        # of them, along each axis of a solid
LEVELS = 16       # of contours, about
PANEL = 7         # inches, usual width of a panel
KEY_ABOVE = 0.17  # inches, from a panel to the middle of the key of its arrows


def bounds_of(layers, window):
    if window:
        return window
    corners = np.concatenate([part for layer in layers for part in (
        layer.at, layer.outline.vertices if layer.outline is not None else layer.at)])
    return np.stack([corners.min(axis=0), corners.max(axis=0)], 1).ravel()


def shown_arrows(layer, window):
    """Numbers of the points whose arrows are drawn: one for each square."""
    x0, x1, z0, z1 = window
    square = max(x1 - x0, z1 - z0, 1e-9) / COLUMNS
    return np.sort(np.unique(np.floor(layer.at / square), axis=0, return_index=True)[1])


def draw_arrows(panel, layers, window, choices, scale):
    """The arrows; their colours are the magnitudes with the part across the plane."""
    factor, unit = scale
    size = factor * np.concatenate([layer.size() for layer in layers])
    limit = float(np.quantile(size, USUAL))
    if size.max() <= OUTLIER * limit:
        limit = float(size.max())
    limit = limit or 1.0
    x0, x1, z0, z1 = window
    crowd = sum(len(shown_arrows(layer, window)) for layer in layers)
    length = np.clip(1.5 * np.sqrt((x1 - x0) * (z1 - z0) / crowd) / (x1 - x0), 0.012, 0.08)
    for layer in layers:
        kept = shown_arrows(layer, window)
        arrows = factor * layer.values[kept][:, choices.axes()[0]]
        colours = factor * layer.size()[kept]
        arrows *= limit / np.maximum(np.linalg.norm(arrows, axis=1), limit)[:, None]
        drawn = panel.quiver(*layer.at[kept].T, *arrows.T, colours, cmap="viridis_r",
                             clim=(0, limit), angles="xy", scale_units="width",
                             scale=limit / length, width=0.0015)
        figure_csv.state(drawn, f"magnitude, {unit}", colours)
    key = scale_arrow(limit)
    wide, high = x1 - x0, z1 - z0 + (0 if choices.window else 2 * MARGIN * (x1 - x0))
    above = max(0.04, KEY_ABOVE / (PANEL * high / max(wide, 1e-9) + 1e-9))
    panel.quiverkey(drawn, 0.85, 1 + min(above, 1.0), key, f"{key:g} {unit}", labelpos="E",
                    fontproperties={"size": 9})
    return drawn, f"{unit} (arrows end at {limit:.3g})" if size.max() > limit else unit, \
        {"extend": "max"} if size.max() > limit else {}


def scale_arrow(limit):
    """The largest of 1, 2, 5 times a power of ten that is not above the limit."""
    power = 10.0**np.floor(np.log10(limit))
    return float(max(one * power for one in (1, 2, 5) if one * power <= limit * (1 + 1e-9)))


def grid_of(layer, window):
    """(x, z): coordinates of a grid over the part of the window that the layer may fill; None if
    there is none."""
    own = bounds_of([layer], None)
    x0, z0 = (max(window[k], own[k]) for k in (0, 2))
    x1, z1 = (min(window[k], own[k]) for k in (1, 3))
    if x0 > x1 or z0 > z1:
        return None
    wide, high = max(x1 - x0, 1e-9), max(z1 - z0, 1e-9)
    part = wide * high / (max(window[1] - window[0], 1e-9) * max(window[3] - window[2], 1e-9))
    count = max(LEAST**2, GRID * part)
    columns = int(np.clip(np.sqrt(count * wide / high), LEAST, count / LEAST))
    return np.linspace(x0, x1, columns), np.linspace(z0, z1, int(count / columns))


def draw_contours(panel, layers, window, scale):
    """The filled contours of each part, between the least and the largest value at the points."""
    factor, unit = scale
    values = factor * np.concatenate([layer.within(window).values for layer in layers])
    levels = matplotlib.ticker.MaxNLocator(LEVELS).tick_values(values.min(), values.max())
    for layer in [solid for layer in layers for solid in layer.solids or (layer,)]:
        if not (grid := grid_of(layer, window)):
            continue
        x, z = grid
        places = np.stack([one.ravel() for one in np.meshgrid(x, z)], 1)
        found = factor * field_sections.values_at(layer, places).reshape(len(z), len(x))
        drawn = panel.contourf(x, z, found, levels, cmap="viridis", extend="both")
        for one in [drawn] if hasattr(drawn, "set_clip_path") else drawn.collections:
            one.set_clip_path(field_sections.edge_of(layer), panel.transData)
    return drawn, unit, {}


def draw(layers, title, choices, unit):
    """The figure of layers with points in the window."""
    window = bounds_of(layers, choices.window)
    inside = [layer.within(window) for layer in layers]
    scale = curves.short_unit(max(np.abs(one.size()).max() for one in inside), unit)
    wide, high = window[1] - window[0], window[3] - window[2]
    figure, panel = plt.subplots(layout="constrained", figsize=(
        9, np.clip(PANEL * high / max(wide, 1e-9) + 1.3, 2.5, 9)))
    margin = 0.0
    if layers[0].values.ndim > 1:
        drawn, words, style = draw_arrows(panel, inside, window, choices, scale)
        margin = 0.0 if choices.window else MARGIN * max(wide, high)
    else:
        drawn, words, style = draw_contours(panel, layers, window, scale)
    panel.set(aspect="equal", xlabel=f"{choices.plane[0]}, m", ylabel=f"{choices.plane[1]}, m",
              xlim=(window[0] - margin, window[1] + margin),
              ylim=(window[2] - margin, window[3] + margin))
    panel.set_title(title, loc="left", fontsize=9)
    if "stress" in (choices.array or "") and "shear" not in f"{choices.array}":
        words += ", tension positive"
    figure.colorbar(drawn, ax=panel, label=words, **style)
    return figure


def as_csv(layers, name, plane, unit):
    """All points in the plane and the window with their values, in SI units."""
    unit = unit.replace("/", "_")
    parts = [f"{name}_{one}_{unit}" for one in "xyz"] if layers[0].values.ndim > 1 else \
        [f"{name}_{unit}"]
    rows = [",".join(["part", f"{plane[0]}_m", f"{plane[1]}_m", *parts])]
    rows += [",".join([layer.part, *(f"{one:.9g}" for one in (*at, *np.ravel(value)))])
             for layer in layers for at, value in zip(layer.at, layer.values)]
    return "\n".join(rows) + "\n"


def table_of(layers, title, choices, unit):
    factor, short = curves.short_unit(max(np.abs(one.size()).max() for one in layers), unit)
    lines = [title]
    for layer in layers:
        size = factor * layer.size()
        ends = [f"{word} {size[k]:.4g} {short} at {choices.plane[0]} = {layer.at[k, 0]:.4g} m, "
                f"{choices.plane[1]} = {layer.at[k, 1]:.4g} m" for word, k in
                (("largest", np.argmax(size)), ("least", np.argmin(size)))]
        lines.append(f"{layer.part}, {len(size)} points: {'; '.join(ends)}; mean "
                     f"{size.mean():.4g} {short}")
    return "\n".join(lines) + "\n"


def title_of(fields, name, choices):
    words = f"{name} {choices.component or ''}".strip()
    time, since = fields[0].time, fields[0].since
    words += f" at {time:.5g} s" if np.isfinite(time) else ""
    words += f", change since {since:.5g} s" if np.isfinite(since) else ""
    return f"{words}, plane {choices.plane} at {'xyz'[choices.axes()[1]]} = {choices.at:g} m"


def draw_into(path, folder, choices):
    """Picture, table and CSV of an array of a result folder or of one field file."""
    if path.suffix == ".hdf" and (choices.time is not None
                                     or choices.parts != field_sections.PARTS):
        raise read.Unreadable(f"{path.name} is one part at one instant: --part and --time choose "
                              "among the files of a result folder")
    if choices.window and not np.all(np.diff(np.reshape(choices.window, (2, 2))) > 0):
        raise read.Unreadable("--window: give the smaller number of each axis first")
    time = choices.time
    if time is None and path.suffix != ".hdf":
        time = passage_instant.time_of(path, -np.inf if choices.since is None else choices.since)
    name, fields = field_files.fields_at(path, choices.parts, choices.array, time, choices.since)
    layers = [field_sections.layer_of(field, name, choices) for field in fields]
    within = [layer.within(choices.window) for layer in layers] if choices.window else layers
    if not any(len(layer.at) for layer in within):
        place = np.concatenate([field.place for field in fields])
        ranges = [f"{axis} = {low:.4g} to {high:.4g} m" for axis, low, high in
                  zip("xyz", place.min(axis=0), place.max(axis=0))]
        raise read.Unreadable(f"no point lies in the plane {choices.plane} and the window; the "
                              f"points have {', '.join(ranges)}: choose others with --at, --slice "
                              "and --window")
    full = [k for k, layer in enumerate(within) if len(layer.at)]
    layers, within, unit = [layers[k] for k in full], [within[k] for k in full], fields[0].unit
    title = title_of(fields, name, choices)
    name = f"{name}_{choices.component}" if choices.component else name
    folder.picture("map", draw(layers, title, choices, unit))
    folder.file("map.csv", as_csv(within, name, choices.plane, unit))
    folder.table("map.txt", table_of(within, title, choices, unit))
