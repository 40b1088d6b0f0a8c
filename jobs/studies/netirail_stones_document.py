"""Part of the document of netirail on stones below the sleepers, with its figure."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from .netirail_measure import BACKFILL, DECK, NEAR, SEEDS, ZONES, of_packing  # noqa: E402
from .study import (COLOURS, change, deck_of, heading, of_packings, percent, save,  # noqa: E402
                    span, table)

STONES = deck_of("track/netirail_stones.toml")
GLUE = STONES["bond"][0]
CASES = (("reinforced layers and wedge", "stones_layers", "plane_same_width_1"),
         ("embankment fill only", "stones_embankment", "plane_same_width_fill_1"))
MEAN = "sleeper, mean of 11 about 14.7 m"
LEVELS = ((f"rail, {NEAR}", "rail"), (f"sleeper, {NEAR}", "sleeper"),
          (MEAN, "mean of 11 sleepers"))


def values(n, name, quantity):
    """In all packings."""
    return np.array([n(run, quantity) for run in (of_packing(name, seed) for seed in SEEDS)
                     if n.has(run)])


def over(n, name, quantity):
    """Mean (least to most) of all packings."""
    return span(values(n, name, quantity), ".3f")


def changes(n, name, other, quantity):
    """Mean relative change in the same packing, and its least and most."""
    found = values(n, other, quantity) / values(n, name, quantity) - 1
    return span_of_changes(found)


def span_of_changes(found):
    return percent(found.mean()) + (f" ({percent(found.min())} to {percent(found.max())})"
                                    if len(found) > 1 else "")


def rows_of(n):
    return [(title, *(over(n, stones, quantity) for quantity, _ in LEVELS),
             f"{n(springs, f'rail, {NEAR}'):.3f}", f"{n(springs, f'sleeper, {NEAR}'):.3f}",
             over(n, stones, "steepest change along the rail"),
             f"{n(stones, 'steepest change on springs'):.3f}") for title, stones, springs in CASES]


def part_stones(n):
    head = ("largest downward displacement, mm", *(f"{what}, stones" for _, what in LEVELS),
            "rail, springs", "sleeper, springs", "steepest change of the rail, stones, mm/m",
            "steepest change of the rail, springs, mm/m")
    effect = {quantity: changes(n, "stones_embankment", "stones_layers", quantity)
              for quantity, _ in LEVELS}
    springs = percent(change(n, CASES[1][2], CASES[0][2], f"rail, {NEAR}"))
    length = STONES["bed"]["x"][1] - STONES["bed"]["x"][0]
    stiffer = DECK["thickness"] / STONES["thickness"]
    packings = of_packings(len(values(n, "stones_layers", MEAN)))
    return heading("Stones below the sleepers") + f"""
![Largest displacement of rail and sleepers on stones and on springs, plane ground](stones.png)

The plane ground with ballast of stones instead of springs below {STONES["sleepers"]["count"]}
sleepers, {length:.1f} m long (`inputs/track/netirail_stones.toml`). The slice is
{STONES["thickness"]:g} m wide. The plane ground carries one rail on {DECK["thickness"]:g} m, so
moduli and densities are multiplied by {stiffer:g}. Two trains pass, one after the other. Values are
those of the second train, relative to the levels after the first, at 14.7 m from the bridge. Of
{packings}.

{table(head, rows_of(n))}
Reinforced layers instead of fill only change, on stones, the rail at 14.7 m by
{effect[f"rail, {NEAR}"]}, the sleeper below it by {effect[f"sleeper, {NEAR}"]} and the mean of 11
sleepers by {effect[MEAN]}, each on the same packing; on springs they change the rail by {springs}.
On stones, the steepest change is one between single sleepers, whose support
scatters.{compared(n)}
{part_glue(n)}"""


def compared(n):
    """Stones beside springs, behind the bridge and on it."""
    rail = [span_of_changes(values(n, stones, f"rail, {NEAR}") / n(springs, f"rail, {NEAR}") - 1)
            for _, stones, springs in CASES]
    text = (" On stones the displacement of the rail at 14.7 m differs from that on springs by "
            f"{rail[0]} (reinforced layers) and {rail[1]} (fill only).")
    run = CASES[0][1]
    rails, sleepers = (values(n, run, f"{what}, mean on the bridge") for what in
                       ("rail", "sleeper"))
    springs, below = (n(run, f"{what} on springs, mean on the bridge") for what in
                      ("rail", "sleeper"))
    softer = ("softer" if sleepers.min() > below else "stiffer" if sleepers.max() < below else
              "in some packings softer, in others stiffer")
    return text + (f" On the bridge, where the ground hardly deforms, the mean of the rail is "
                   f"{rails.mean():.3f} mm on stones and {springs:.3f} mm on springs, that of the "
                   f"sleepers {over(n, run, 'sleeper, mean on the bridge')} and {below:.3f} mm. So "
                   f"the bed of stones is {softer} than the springs; no cause of this is known.")


def part_glue(n):
    """Glued ballast as bonds between stones."""
    if not n.has("stones_glued"):
        return ""
    seeds = [seed for seed in SEEDS if n.has(of_packing("stones_glued", seed))]

    def in_both(name, quantity):
        """Of the packings that are glued, too."""
        return span([n(of_packing(name, seed), quantity) for seed in seeds], ".3f")
    both = ("stones_embankment", "stones_glued")
    rows = [(zone, *(in_both(name, f"{what}, mean, {zone}")
                     for what in ("sleeper", "settlement in the train") for name in both))
            for zone in ZONES]
    steepest = [in_both(name, "steepest change along the rail") for name in both]
    reach = GLUE["high"][0] - BACKFILL
    return f"""
Glued ballast on fill only: bonds of {GLUE["young"] / 1e9:g} GPa and {GLUE["tension"] / 1e6:g} MPa
between the stones of the first {reach:.1f} m behind the bridge, made before the first train
(`bond.glue.present=true`, docs/bonds.md). The report gives neither number. Means over the sleepers
at these distances from the bridge, second train. Of {of_packings(len(seeds))}.

{table(("mm", "displacement", "displacement, glued", "settlement", "settlement, glued"), rows)}
The steepest change of the rail is {steepest[0]} mm/m without and {steepest[1]} mm/m with glue.
"""


def draw_stones(lines, folder):
    rail, sleepers = lines.of("envelope"), lines.of("sleepers on stones")
    on_springs = lines.of("sleepers on springs")
    figure, panels = plt.subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
    for panel, (title, stones, springs) in zip(panels, CASES):
        panel.plot(*rail[springs], color=COLOURS[0], label="rail, springs")
        runs = [run for run in (of_packing(stones, seed) for seed in SEEDS) if run in rail]
        levels = [rail[run][1] for run in runs]
        if len(runs) > 1:
            panel.fill_between(rail[stones][0], np.min(levels, axis=0), np.max(levels, axis=0),
                               alpha=0.25, lw=0, color=COLOURS[1])
        panel.plot(rail[stones][0], np.mean(levels, axis=0), color=COLOURS[1],
                   label="rail, stones, mean and range")
        if springs in on_springs:
            panel.plot(*on_springs[springs], "x", markersize=4, color=COLOURS[0],
                       label="sleepers, springs")
        for run in runs:
            panel.plot(*sleepers[run], ".", markersize=3, color=COLOURS[1],
                       label="sleepers, stones, each packing" if run == stones else None)
        panel.axvspan(-BACKFILL, 0, color="0.9", label="bridge")
        panel.set(title=title, xlabel="distance from the bridge (m)", xlim=(-BACKFILL, 25))
        panel.legend(fontsize=8)
    panels[0].set_ylabel("largest displacement, downwards (mm)")
    panels[0].invert_yaxis()
    save(figure, folder / "stones.png")
