"""Text and figure of the part of the study shi in space, from its numbers and lines alone."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from .shi_decks import DESIGNS, EDGE, SHORT, SPACE, TITLES, deck_of  # noqa: E402
from .shi_runs import FIXED  # noqa: E402
from .shi_space import END, MODELS, PACKINGS, name_of  # noqa: E402
from .study import COLOURS, as_file, heading, of_packings, percent, save, span, table  # noqa: E402

COLUMNS = [(where, design) for where in MODELS for design in DESIGNS]
ROWS = (("surface of the structure, mm", "ground, structure"),
        ("surface, median from 4 to 5 m, mm", "ground, far"),
        ("steepest change of the surface along the track, mm/m", "ground, steepest"),
        ("x of this steepest change, m", "ground, x of the steepest"),
        ("difference of the mean stresses before and behind the edge, kPa",
         "difference of means at the edge"),
        ("sleepers on the structure, mean, mm", "sleeper, structure"),
        ("sleepers from 3 to 5 m, median, mm", "sleeper, median beyond"),
        ("compression of the bed: these less the surface below, median, mm", "bed, median beyond"),
        ("sleeper that moves most up to 5 m, mm", "sleeper, most"),
        ("residual settlement: median, mm", "kept, median"),
        ("residual settlement: largest, mm", "kept, most"),
        ("smallest of the sleepers' largest accelerations, g", "acceleration, least"),
        ("median of them, g", "acceleration, median"),
        ("largest of them, g", "acceleration, most"))


def values(n, where, design, quantity):
    return [n(name, quantity) for name in
            (name_of(where, design, packing) for packing in PACKINGS) if (name, quantity) in n.rows]


def part(n):
    deck = deck_of(SPACE)
    rows = [(title, *(span(values(n, *column, quantity)) for column in COLUMNS))
            for title, quantity in ROWS]
    stones, density = (values(n, "space", "wedge", of)[0] for of in ("stones", "bulk density"))
    count = of_packings(len(values(n, "space", "none", "stones")))
    falls = {where: np.mean(values(n, where, "wedge", "ground, steepest"))
             / np.mean(values(n, where, "none", "ground, steepest")) - 1 for where in MODELS}
    longest = max(n(name_of("space", design, packing), "sub-step over the longest stable one")
                  for design in DESIGNS for packing in PACKINGS
                  if n.has(name_of("space", design, packing)))
    plane = deck_of(SHORT)
    far = {where: np.mean(values(n, where, "none", "ground, far")) for where in MODELS}
    moved = {where: np.mean(values(n, where, "wedge", "ground, far")) / far[where] - 1
             for where in MODELS}
    strain = n("ground_none_plane_strain", "ground, 6 to 11 m") / n(
        f"ground_none_{as_file(FIXED)}", "ground, 6 to 11 m")
    reach = next(max(block["outline"][::2]) for block in deck["ground"]["block"]
                 if block["name"] == "wedge")
    width = deck["bed"]["y"][1]
    sieves = deck["bed"]["sieve"]
    return heading("In space") + f"""
![Largest displacement of the surface and of sleepers, in the plane and in space](space.png)

The study, too, is plane. `{"inputs/" + SPACE}` is a shortened transition in space: 6 m long and
{width:g} m wide between smooth walls, {stones:.0f} angular stones of {sieves[0]:g} to
{sieves[-1]:g} mm below nine sleepers, 3 m of ground, a structure of 2 m, a steeper wedge that ends
at x = {reach:g} m, one bogie. The model has {width:g} m of the
{plane["thickness"]:g} m of a half sleeper, and this part of its load. The bed has {density:.0f}
kg/m3 with stones of
{deck["material"][0]["density"]} kg/m3; contacts of {deck["contact"][0]["k_n"] / 1e6:g} MN/m are
those of the compression test in docs/laboratory.md. `inputs/shi/short.toml` has the same lengths,
ground and loads in the plane, but other stones (from {plane["bed"]["sieve"][0]:g} mm), contacts of
{plane["contact"][0]["k_n"] / 1e6:g} MN/m that are as stiff along as across, a bed poured without
friction and bedded in by trains, and a ground that may expand across the track. So differences are
those of all of this together. Of {count}:

{table(["", *(f"{where}, {TITLES[design]}" for where, design in COLUMNS)], rows)}
The wedge changes the displacement of the surface at 4 to 5 m by {percent(moved["plane"])} in the
plane and by {percent(moved["space"])} in space. The displacement of the surface
behind the edge without wedge is {far["space"] / far["plane"]:.2f} times that in the plane; plane
strain instead of plane stress alone changes that of the ground by a factor of {strain:.2f}. The
wedge changes the steepest change of the surface, smoothed over a sleeper spacing, by
{percent(falls["plane"])} in the plane and by {percent(falls["space"])} in space. What one packing
shows may be chance. Sub-steps in space are {longest:.2f} times as
long as stable ones in the passage, so that accelerations of single stones there are not reliable.
"""


def draw(lines, folder):
    figure, panels = plt.subplots(2, 1, figsize=(9, 6), sharex=True, layout="constrained")
    found = lines.of("space")
    for panel, part_of, label in zip(panels, ("ground", "sleepers"), (
            "largest displacement of the\nsurface, mm, down", "of the sleepers, mm, down")):
        for where, design in COLUMNS:
            runs = [found[name] for name in (f"{name_of(where, design, packing)}, {part_of}"
                                             for packing in PACKINGS) if name in found]
            if not runs:
                continue
            panel.plot(runs[0][0], np.mean([run[1] for run in runs], axis=0),
                       "-" if where == "space" else "--", lw=1.6,
                       marker="o" if part_of == "sleepers" else "", ms=3,
                       color=COLOURS[1 if design == "none" else 0],
                       label=f"{where}, {TITLES[design]}")
        panel.axvspan(0, EDGE, color="0.9", lw=0)
        panel.grid(alpha=0.3)
        panel.invert_yaxis()
        panel.set_ylabel(label)
        panel.legend(fontsize=8)
    panels[-1].set_xlabel(f"x, m (grey: structure); beyond {END:g} m the end of the ground acts")
    save(figure, folder / "space.png")
