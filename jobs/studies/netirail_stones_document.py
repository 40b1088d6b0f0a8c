"""Part of the document of netirail on stones below the sleepers, with its figure."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from .netirail_measure import BACKFILL, DECK, NEAR  # noqa: E402
from .study import COLOURS, change, deck_of, heading, percent, save, table  # noqa: E402

STONES = deck_of("track/netirail_stones.toml")
CASES = (("reinforced layers and wedge", "stones_layers", "plane_same_width_1"),
         ("embankment fill only", "stones_embankment", "plane_same_width_fill_1"))
MEAN = "sleeper, mean of 11 about 14.7 m"


def rows_of(n):
    return [(title, f"{n(stones, f'rail, {NEAR}'):.3f}", f"{n(springs, f'rail, {NEAR}'):.3f}",
             f"{n(stones, f'sleeper, {NEAR}'):.3f}", f"{n(stones, MEAN):.3f}",
             f"{n(stones, 'sleeper, least of them'):.3f} to "
             f"{n(stones, 'sleeper, most of them'):.3f}",
             f"{n(springs, f'sleeper, {NEAR}'):.3f}",
             f"{n(stones, 'steepest change along the rail'):.3f}",
             f"{n(stones, 'steepest change on springs'):.3f}") for title, stones, springs in CASES]


def part_stones(n):
    head = ("largest downward displacement, mm", "rail, stones", "rail, springs",
            "sleeper, stones", "11 sleepers, stones, mean", "11 sleepers, stones, range",
            "sleeper, springs", "steepest change of the rail, stones, mm/m",
            "steepest change of the rail, springs, mm/m")
    effect = {quantity: percent(change(n, "stones_embankment", "stones_layers", quantity))
              for quantity in (MEAN, f"rail, {NEAR}", f"sleeper, {NEAR}")}
    springs = percent(change(n, CASES[1][2], CASES[0][2], f"rail, {NEAR}"))
    length = STONES["bed"]["x"][1] - STONES["bed"]["x"][0]
    stiffer = DECK["thickness"] / STONES["thickness"]
    return heading("Stones below the sleepers") + f"""
![Largest displacement of rail and sleepers on stones and on springs, plane ground](stones.png)

The plane ground with ballast of stones instead of springs below {STONES["sleepers"]["count"]}
sleepers, {length:.1f} m long (`inputs/track/netirail_stones.toml`). The slice is
{STONES["thickness"]:g} m wide. The plane ground carries one rail on {DECK["thickness"]:g} m, so
moduli and densities are multiplied by {stiffer:g}. There is one packing, with the stones of the
quickstart. Two trains pass, one after the other. Values are those of the second train, relative to
the levels after the first, about 14.7 m from the bridge:

{table(head, rows_of(n))}
Reinforced layers instead of fill only change, on stones, the rail at 14.7 m by
{effect[f"rail, {NEAR}"]}, the sleeper below it by {effect[f"sleeper, {NEAR}"]} and the mean of 11
sleepers by {effect[MEAN]}; on springs they change the rail by {springs}. On stones, the steepest
change is one between single sleepers, whose support scatters.{compared(n)} One packing does not
show which of these differences are due to chance.
"""


def compared(n):
    """Stones beside springs, behind the bridge and on it."""
    rail = [percent(n(stones, f"rail, {NEAR}") / n(springs, f"rail, {NEAR}") - 1)
            for _, stones, springs in CASES]
    text = (" On stones the displacement of the rail at 14.7 m differs from that on springs by "
            f"{rail[0]} (reinforced layers) and {rail[1]} (fill only).")
    run, on_bridge = CASES[0][1], [f"{what}, mean on the bridge" for what in
                                   ("rail", "rail on springs", "sleeper", "sleeper on springs")]
    if (run, on_bridge[-1]) not in n.rows:
        return text
    rail, springs, sleeper, below = (n(run, quantity) for quantity in on_bridge)
    return text + (f" On the bridge, where the ground hardly deforms, the mean of the rail is "
                   f"{rail:.3f} mm on stones and {springs:.3f} mm on springs, that of the sleepers "
                   f"{sleeper:.3f} and {below:.3f} mm. So the bed of stones is "
                   f"{'softer' if sleeper > below else 'stiffer'} than the springs; no cause of "
                   "this is known.")


def draw_stones(lines, folder):
    rail, sleepers = lines.of("envelope"), lines.of("sleepers on stones")
    on_springs = lines.of("sleepers on springs")
    figure, panels = plt.subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
    for panel, (title, stones, springs) in zip(panels, CASES):
        panel.plot(*rail[springs], color=COLOURS[0], label="rail, springs")
        panel.plot(*rail[stones], color=COLOURS[1], label="rail, stones")
        if springs in on_springs:
            panel.plot(*on_springs[springs], "x", markersize=4, color=COLOURS[0],
                       label="sleepers, springs")
        panel.plot(*sleepers[stones], ".", color=COLOURS[1], label="sleepers, stones")
        panel.axvspan(-BACKFILL, 0, color="0.9", label="bridge")
        panel.set(title=title, xlabel="distance from the bridge (m)", xlim=(-BACKFILL, 25))
        panel.legend(fontsize=8)
    panels[0].set_ylabel("largest displacement, downwards (mm)")
    panels[0].invert_yaxis()
    save(figure, folder / "stones.png")
