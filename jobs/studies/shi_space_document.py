"""Text and figure of the part of the study shi in space, from its numbers and lines alone."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from .shi_decks import DESIGNS, EDGE, SPACE, TITLES, deck_of  # noqa: E402
from .shi_space import END, MODELS, PACKINGS, name_of  # noqa: E402
from .study import COLOURS, heading, of_packings, percent, save, span, table  # noqa: E402

COLUMNS = [(where, design) for where in MODELS for design in DESIGNS]
ROWS = (("surface of the structure, mm", "ground, structure"),
        ("surface, median from 4 to 5 m, mm", "ground, far"),
        ("steepest change of the surface along the track, mm/m", "ground, steepest"),
        ("x of this steepest change, m", "ground, x of the steepest"),
        ("difference of the mean stresses before and behind the edge, kPa",
         "difference of means at the edge"),
        ("sleepers on the structure, mean, mm", "sleeper, structure"),
        ("sleepers more than 1 m beyond the edge, median, mm", "sleeper, median beyond"),
        ("sleeper that moves most, mm", "sleeper, most"),
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
    far = {where: [np.mean(values(n, where, design, "sleeper, median beyond"))
                   - np.mean(values(n, where, design, "ground, far")) for design in DESIGNS]
           for where in MODELS}
    falls = {where: np.mean(values(n, where, "wedge", "ground, steepest"))
             / np.mean(values(n, where, "none", "ground, steepest")) - 1 for where in MODELS}
    longest = {where: max(value for design in DESIGNS for value in values(
        n, where, design, "sub-step over the longest stable one, most")) for where in MODELS}
    reach = next(max(block["outline"][::2]) for block in deck["ground"]["block"]
                 if block["name"] == "wedge")
    width = deck["bed"]["y"][1]
    sieves = deck["bed"]["sieve"]
    return heading("In space") + f"""
![Largest displacement of the surface and of sleepers, in the plane and in space](space.png)

The study, too, is plane. `{"inputs/" + SPACE}` is a part of the transition in space: 6 m long and
{width:g} m wide between smooth walls, {stones:.0f} angular stones of {sieves[0]:g} to
{sieves[-1]:g} mm below nine sleepers, a structure of 2 m, a wedge of 2.2 m, one bogie. Loads and
sleepers are those of {width:g} m of the 1.3 m of half a sleeper. The bed has {density:.0f} kg/m3
with stones of {deck["material"][0]["density"]} kg/m3; contacts of
{deck["contact"][0]["k_n"] / 1e6:g} MN/m are those of the compression test in docs/laboratory.md.
`inputs/shi/short.toml` is the same in the plane, except that its ground may expand across the track
and its stones are prisms with contacts of 500 MN/m. Of {count}:

{table(["", *(f"{where}, {TITLES[design]}" for where, design in COLUMNS)], rows)}
The wedge changes the steepest change of the surface by {percent(falls["plane"])} in the plane and
by {percent(falls["space"])} in space.
The wedge ends at x = {reach:g} m. The bed itself, sleepers beyond the edge less the
surface, is compressed by {far["plane"][0]:.2g} mm without and {far["plane"][1]:.2g} mm with wedge
in the plane, by {far["space"][0]:.2g} and {far["space"][1]:.2g} mm in space. Sub-steps are at most
{longest["plane"]:.2f} (plane) and {longest["space"]:.2f} (space) times as long as stable ones.
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
