"""Sections of the document of the study shi: what is compared and varied."""
import numpy as np

from .shi_decks import DESIGNS, LOAD, SPACING, TITLES
from .shi_runs import (AXLE_AT, CONVERGENCE, DECAY, FIXED, FULL_FRICTION, KEPT, LOADED,
                       MANY_TRAINS, S1, S2, SAMPLED, SHOWN_TRAINS, SPEEDS, TRAINED, WEDGES, WHEEL)
from .shi_tables import (FRICTION, LOADING, QUANTITIES, TRAINS, cell, ground_rows, ground_table,
                         of_all, same)
from .shi_targets import (CLOSE, PUBLISHED_STONES, SPECTRAL_LINES, WHEEL_LOAD, jump,
                          jump_of_means, lines_of, lost, spectral_heights)
from .study import as_file, between, change, heading, percent, table


def part_sleepers(n):
    return heading("Sleepers and ballast") + f"""
![Displacement and acceleration of sleepers and of the ballast below them](sleepers.png)

![Histories of two sleepers, spectra of all](histories.png)

{places_of_sleepers(n)}
{text_of_spectra(n)}
{sleepers_ahead(n)}

{text_of_rotation(n)}
{text_of_samples(n)}
{text_of_maps(n)}"""


def places_of_sleepers(n):
    x, down = lines_of(n, "sleeper", "wedge")
    down = down.mean(axis=0)
    near = x[np.abs(down / 1.7 - 1) <= CLOSE]
    best = np.abs(down - 1.7).argmin()
    return f"""The study measures sleeper S1 on the transition and S2 on plain track; it does not
state their x, here {S1:g} and {S2:g} m. With wedge no sleeper before x = {near.min():g} m is within
15 % of the published 1.7 mm of S1, as a mean over packings; the nearest to it is that at x =
{x[best]:g} m with {down[best]:.2f} mm. Without wedge S1 moves
{of_all(n, "none", "sleeper S1")} mm. Why S1 moves less than published is not explained; neither are
the smallest accelerations, the largest with wedge, the ratio of S2 to S1 and the fluctuation of the
ballast's acceleration. For the sleeper at the edge and the largest acceleration without wedge see
"Preparation".
"""


def text_of_spectra(n):
    peaks = [(f"near v/({what})",
              *(of_all(n, design, f"{mark}, {of}") for design in DESIGNS
                for of in ("seat force", "acceleration", "ballast acceleration")))
             for mark, (what, _) in SPECTRAL_LINES.items()]
    heights, higher = map(np.concatenate, zip(*(spectral_heights(n, design) for design in DESIGNS)))
    return f"""Spectra are the root mean square over all sleepers. The spectrum of the load is that
of the seat forces times the frequency squared: the acceleration of sleepers that follow the load
without delay. Axles and bogies pass with v/2.8 m = {LOAD["speed"] / 2.8:.2f} Hz and v/9.0 m =
{LOAD["speed"] / 9:.2f} Hz; the peaks of the load lie beside these. A record of 1.8 s resolves 0.55
Hz; peaks are read from a spectrum with zeros appended. The peak of sleepers near v/9.0 m is not the
largest: its amplitude is {between(heights, ".2f")} of that near v/2.8 m, and
{between(higher)} peaks below 15 Hz are higher.

Peaks of these spectra (Hz), which the prescribed forces impose, so that they check no more than
that sleepers and stones follow them:

{table(["", *(f"{TITLES[design]}: {what}" for design in DESIGNS
             for what in ("load", "sleepers", "ballast"))], peaks)}"""


def sleepers_ahead(n):
    reach = 0.75 * np.pi / DECAY
    return f"""The study sees three sleepers ahead of an axle move down. Sleepers with more than a
tenth of the velocity of the fastest one are {of_all(n, "wedge", "sleepers moving down ahead")} with
and {of_all(n, "none", "sleepers moving down ahead")} without wedge. The assumed load of one axle
is directed downwards up to {reach:.2f} m ahead of it, {reach / SPACING:.1f} spacings, in both
designs; the ground makes the difference between them."""


def text_of_rotation(n):
    quantities = ("sleeper, structure", "sleeper, median beyond", "sleeper, most", "kept, most",
                  "acceleration, median")
    rows = [(title, *(cell(n, f"stones_{design}_{name}", quantity) for design in DESIGNS
                      for quantity in quantities))
            for title, name in (("vertical motion only", "1"), ("rotation, too", "pitch"))]
    head = ["packing 1", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                           ("structure, mm", "beyond, mm", "most, mm", "residual, mm",
                            "acceleration, g"))]
    return f"""Sleepers that may rotate, without the restraint of a rail:

{table(head, rows)}"""


def text_of_samples(n):
    shown = ("least", "median", "most")
    rows = [(title, *(cell(n, f"{kind}_{design}_{as_file(name)}", f"acceleration, {what}")
                      for design in DESIGNS for what in shown))
            for title, kind, name in (
                ("ground alone on springs, as computed", "ground", FIXED),
                ("the same, 100 values per second, linear between them", "ground", SAMPLED),
                ("stones, packing 1, as computed", "stones", "1"),
                ("the same, 100 values per second", "stones", SAMPLED))]
    least = [(TITLES[design], n(run, "acceleration, least")) for design in DESIGNS
             for run in [f"stones_{design}_{as_file(SAMPLED)}"]
             if (run, "acceleration, least") in n.rows]
    kinks = "With stones the smallest one remains far below the published ones: " + " and ".join(
        f"{value:.2g} g {title}" for title, value in least) + "." if least else ""
    return f"""Do loads with kinks explain that our smallest accelerations are too low? The study's
loads were sampled 100 times per second. Largest accelerations after the low pass, g (springs:
recorded acceleration after the low pass; stones: change of the velocity after the low pass):

{table(["loads", *(f"{TITLES[design]}: {what}" for design in DESIGNS
                   for what in ("smallest", "median", "largest"))], rows)}
{kinks}
"""


def text_of_maps(n):
    rows = [(f"first axle at {at} m", *(cell(n, f"maps_{design}", f"{what}, axle at {at} m")
                                        for design in DESIGNS for what in
                                        ("largest velocity of cells of stones",
                                         "x of the largest velocity, stones",
                                         "largest velocity of cells of ground",
                                         "x of the largest velocity, ground",
                                         "largest acceleration of cells of stones",
                                         "largest acceleration of cells of ground")))
            for at in AXLE_AT]
    without = ("" if n("stones_wedge_1", "kept, most") <= KEPT else
               ", in which with wedge a sleeper loses its support")
    return f"""
![Velocity of ballast and ground when the first axle is at three places](maps_velocity.png)

![Acceleration of ballast and ground at the same instants](maps_acceleration.png)

The arrows are means in cells of 0.6 x 0.2 m (stones) and 1 x 0.8 m (ground) of packing 1{without}.
Accelerations are those of an instant, without a low pass. Largest means of cells:

{table(["", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
              ("stones, mm/s", "at x, m", "ground, mm/s", "at x, m", "stones, g", "ground, g"))],
       rows)}"""


def part_preparation(n):
    """The bed after more trains, and after loads with full friction."""
    name = f"stones_wedge_{as_file(TRAINED)}"
    rows = [(train, *(cell(n, name, f"settlement, {which}, train {train}")
                      for which in ("most", "median"))) for train in SHOWN_TRAINS]
    quantities = ("sleeper, median beyond", "sleeper, most", "kept, most", "kept, median",
                  "acceleration, median")
    changed = [(title, *(cell(n, f"stones_{design}_{as_file(which)}", quantity)
                         for design in DESIGNS for quantity in quantities))
               for title, which in (("as above", "1"), (f"{MANY_TRAINS} trains", TRAINED),
                                    (FULL_FRICTION, FULL_FRICTION))]
    rough = f"stones_wedge_{as_file(FULL_FRICTION)}"
    last = "settlement in the last train of the preparation"
    beds, _ = lost(n)
    failed = f""" They do not do so in all beds: in packing {", ".join(map(str, beds))} a sleeper
loses its support in the measured passage.""" if beds else ""
    return heading("Preparation") + f"""
A support of a sleeper can fail under a train although it carried others before. Loads with less
friction are meant to let weak supports fail beforehand.{failed} After loads with full friction one
train after the other still moves sleepers of packing 1 down for good, the last of at most
{TRAINS["cycles"]} by {n(rough, last):.2g} mm; after loads with less friction the last one does by
{n("stones_wedge_1", last):.2g} mm. With {MANY_TRAINS} trains in their place:

{table(["train", "largest settlement of a sleeper, mm", "median, mm"], rows)}
The passage after these preparations:

{table(["packing 1", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                       ("sleepers beyond, mm", "most, mm", "residual, most, mm",
                        "residual, median, mm", "acceleration, g"))], changed)}
{targets_with_full_friction(n, n(rough, last))}"""


PUBLISHED = (  # what, design, quantity, value, unit
    ("largest acceleration of a sleeper", "none", "acceleration, most", 1.34, "g"),
    ("largest acceleration of a sleeper", "wedge", "acceleration, most", 1.57, "g"),
    ("smallest of the sleepers' largest accelerations", "none", "acceleration, least", 0.62, "g"),
    ("smallest of the sleepers' largest accelerations", "wedge", "acceleration, least", 0.61, "g"),
    ("sleeper nearest to the edge", "none", "sleeper, nearest to the edge", 0.75, "mm"),
    ("sleeper S1", "none", "sleeper S1", None, "mm"),
    ("sleeper S1", "wedge", "sleeper S1", 1.7, "mm"),
    ("largest stress of a node before the edge", "none", "stress, most before the edge", 165,
     "kPa"),
    ("least stress of a node behind the edge", "none", "stress, least behind the edge", 27, "kPa"),
    ("least stress of a node behind the edge", "wedge", "stress, least behind the edge", None,
     "kPa"))


def targets_with_full_friction(n, settled):
    """Failed targets, of a bed that is prepared with the friction of the study."""
    rows, met = [], []
    for what, design, quantity, published, unit in PUBLISHED:
        usual, rough = (n(f"stones_{design}_{as_file(name)}", quantity)
                        for name in ("1", FULL_FRICTION))
        close = published is not None and abs(rough / published - 1) <= CLOSE
        if close:
            met.append(f"{what} {TITLES[design]}")
        rows.append((f"{what}, {TITLES[design]}, {unit}", published or "", f"{usual:.3g}",
                     f"{rough:.3g}", "" if published is None else "yes" if close else "no"))
    step = [jump(n, f"stones_{design}_{as_file(FULL_FRICTION)}") for design in DESIGNS]
    found = " and ".join(f'"{each}"' for each in met) or "no values"
    return f"""The study gives a friction of {FRICTION:g}. Do loads with this friction, instead of
{LOADING["friction"]:g}, explain targets that are not reproduced?

{table(["packing 1", "published", "as above", "full friction", "within 15 %"], rows)}
With full friction {found} agree with the study. The wedge changes the difference of stresses of
nodes at the edge
by {percent(step[1] / step[0] - 1)} (published -54 %). This is one packing, whose last train of the
preparation settled a sleeper by {settled:.2g} mm: its bed still changes, and other packings were
not prepared like this.{unstable(n)}
"""


def unstable(n):
    """What follows if sub-steps were too long in the passage after loads with full friction."""
    quantity = "sub-step over the longest stable one"
    longest = max(n(f"stones_{design}_{as_file(FULL_FRICTION)}", quantity) for design in DESIGNS)
    if longest < 1.005:
        return ""
    return f""" In the measured passage its sub-steps were {longest:.2f} times as long as the
longest stable ones (docs/decisions/time_step.md). Single stones then vibrate from sub-step to
sub-step, so that its accelerations are not reliable."""


def part_speeds(n):
    names = [(f"{SPEEDS[0]}", f"{SPEEDS[0]} km/h"), ("67.2", FIXED),
             *((f"{v}", f"{v} km/h") for v in SPEEDS[1:])]
    slow, fast = (f"ground_none_{as_file(f'{v} km/h')}" for v in (SPEEDS[0], SPEEDS[-1]))
    on_stones = [(title, *(cell(n, f"stones_{design}_{1 if name == FIXED else as_file(name)}", what)
                           for design in DESIGNS for what in
                           (*QUANTITIES[1:], "sleeper, median beyond", "acceleration, median")))
                 for title, name in names]
    return heading("Speed") + f"""
Ground alone, the same loads at other speeds:

{ground_table("km/h", ground_rows(n, names))}
With stones (packing 1):

{table(["km/h", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                  ("6 to 11 m, mm", "last 2 m, mm", "90 %, m", "sleepers beyond, mm",
                   "acceleration, median, g"))], on_stones)}
Ground alone, from {SPEEDS[0]} to {SPEEDS[-1]} km/h the displacement 6 to 11 m behind the edge
changes by {percent(change(n, slow, fast, "ground, 6 to 11 m"))} without wedge, with its largest
value in
between, and that of the last 2 m by {percent(change(n, slow, fast, "ground, far"))}. What uneven
rails and moving masses add is not part of prescribed loads.
"""


def part_wedges(n):
    cases_of = [("none", "none", FIXED), ("3 m at the bottom, 13 m at the top", "wedge", FIXED),
                *((title, "wedge", name) for title, name in same(WEDGES))]
    rows = [(title, *(cell(n, f"ground_{design}_{as_file(name)}", quantity)
                      for quantity in QUANTITIES)) for title, design, name in cases_of]
    quantities = (*QUANTITIES, "sleeper, median beyond")
    runs = [("none", "stones_none_1"), ("3 m at the bottom, 13 m at the top", "stones_wedge_1"),
            *((title, f"stones_wedge_{as_file(name)}") for title, name in same(WEDGES))]
    on_stones = [(title, *(cell(n, run, quantity) for quantity in quantities),
                  f"{jump_of_means(n, run):.0f}") for title, run in runs]
    return heading("Other wedges") + f"""
![Ground alone: wedges, boundaries, speeds](ground.png)

Ground alone; the surface layer of 4000 MPa ends where the wedge does at its top:

{table(["wedge", "structure, mm", "6 to 11 m, mm", "last 2 m, mm", "90 %, m"], rows)}
The same with stones (packing 1); forces on seats are prescribed, so that what a wedge changes is
the displacement and the stress at the edge (see "Stress at the edge"):

{table(["wedge", "structure, mm", "6 to 11 m, mm", "last 2 m, mm", "90 %, m",
        "sleepers beyond, mm", "difference of means at the edge, kPa"], on_stones)}"""


def part_vehicle(n):
    quantities = ("ballast force, structure", "ballast force, most", "ballast force, far",
                  "ground, far")
    runs = [(title, name) for title, name in (("prescribed seat loads", FIXED), (LOADED, LOADED))]
    rows = [(title, *(cell(n, f"ground_{design}_{as_file(name)}", quantity)
                      for design in DESIGNS for quantity in quantities)) for title, name in runs]
    head = ["", *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                  ("structure, kN", "most, kN", "last 2 m, kN", "ground in the last 2 m, mm"))]
    ratios = [n(f"ground_none_{as_file(name)}", "ballast force, structure")
              / n(f"ground_none_{as_file(name)}", "ballast force, far") for _, name in runs]
    on_stones = [(title, *(cell(n, f"stones_{design}_{as_file(name)}", quantity)
                           for design in DESIGNS for quantity in
                           ("seat force, structure", "seat force, most", "seat force, far",
                            "ground, far")))
                 for title, name in (("prescribed seat loads", "1"), (LOADED, LOADED))]
    rough = [n(f"stones_none_{as_file(name)}", "seat force, most")
             / n(f"stones_none_{as_file(name)}", "seat force, far") for name in ("1", LOADED)]
    vehicle = f"stones_none_{as_file(LOADED)}"
    stiff = n(vehicle, "seat force, structure") / n(vehicle, "seat force, far")
    preload = 1e-3 * TRAINS["seat_force"]
    return heading("A vehicle instead of prescribed loads") + f"""
A unit of 100 t with axles at the published distances (masses of body, bogies and wheelsets and
springs are chosen here) runs over a rail CHN60 on pads of 100 MN/m. Compare ratios only: its wheels
carry {1e-3 * WHEEL:.0f} kN at rest, the formula of the published seat load belongs to a wheel load
of {1e-3 * WHEEL_LOAD:.0f} kN. Largest force between sleepers and ground:

{table(head, rows)}
Without wedge, sleepers on the structure carry {ratios[1]:.2f} times the force of those in the last
2 m below the vehicle, and {ratios[0]:.2f} times below prescribed loads, which cannot respond to the
support. On stones (packing 1), largest force on a seat:

{table(head, on_stones)}
With prescribed loads these forces contain the {preload:.0f} kN that lie on each seat before the
passage ({n("stones_none_1", "seat force, most"):.1f} kN less {preload:.0f} are
{n("stones_none_1", "seat force, most") - preload:.1f} kN). Without wedge sleepers on the structure
carry {stiff:.2f} times the median of the last 2 m below the vehicle. The largest force on a seat is
{rough[1]:.2f} times this median. Unequal supports by stones thus cause differences as large as
that, so that the effect of the structure cannot be distinguished from theirs on one packing. With
prescribed loads the largest is {rough[0]:.2f} times the median: they hide both effects.
"""


def part_convergence(n):
    quantities = ("ground, structure", "ground, 6 to 11 m", "stress, most before the edge",
                  "stress, least behind the edge", "sleeper, structure", "sleeper, median beyond",
                  "acceleration, least", "acceleration, median", "acceleration, most")
    rows = [(title, *(cell(n, f"stones_none_{as_file(name)}", quantity) for quantity in quantities))
            for title, name in (("5e8 N/m (Table 1)", "1"), ("2.5e8 N/m", "soft"),
                                ("1e9 N/m", "stiff"), ("5e8 N/m, half the step", HALVED))]
    return heading("Convergence") + f"""
Ground alone ("last 2 m": 13 to 15 m behind the edge):

{ground_table("", ground_rows(n, same((FIXED, *CONVERGENCE))))}
The stiffness of the contacts of stones changes sleepers by far more than the displacement of the
ground (packing 1 without wedge, changed after the bed was prepared). Accelerations are larger with
both other values of the stiffness, by {factors(n)}. They depend on the stiffness, or on changing it
after the preparation.

{table(["", "structure, mm", "6 to 11 m, mm", "most before the edge, kPa", "least behind it, kPa",
        "sleepers on the structure, mm", "sleepers beyond, mm", "smallest acceleration, g",
        "median, g", "largest, g"], rows)}
{half_the_step(n)}"""


def factors(n):
    """Of accelerations, from the reference to other stiffnesses of contacts."""
    found = {what: [1 + change(n, "stones_none_1", f"stones_none_{name}", f"acceleration, {what}")
                    for name in ("soft", "stiff")] for what in ("least", "median", "most")}
    names = {"least": "the smallest", "median": "the median", "most": "the largest"}
    return ", ".join(f"a factor of {between(each, '.1f')} ({names[what]})"
                     for what, each in found.items())


HALVED = "half the step"
OF_STEP = {  # group: quantities
    "displacement of the ground": {
        "structure": "ground, structure", "6 to 11 m": "ground, 6 to 11 m",
        "last 2 m": "ground, far", "largest": "ground, most", "steepest change": "ground, steepest",
        "90 % of the rise": "ground, 90 % of the rise"},
    "median": {
        "sleepers beyond the edge": "sleeper, median beyond",
        "ballast beyond the edge": "ballast, median beyond",
        "residual settlement": "kept, median",
        "acceleration of sleepers": "acceleration, median",
        "acceleration of ballast": "ballast acceleration, median"},
    "stress at the edge": {
        "largest before": "stress, most before the edge",
        "least behind": "stress, least behind the edge",
        "mean before": "stress, mean before the edge",
        "mean behind": "stress, mean behind the edge"},
    "single sleepers": {
        "on the structure, mean": "sleeper, structure",
        "nearest to the edge": "sleeper, nearest to the edge", "S1": "sleeper S1",
        "S2": "sleeper S2", "most": "sleeper, most",
        "ballast on the structure, mean": "ballast, structure"},
    "residual settlement": {"largest": "kept, most"},
    "acceleration of single sleepers": {
        "smallest": "acceleration, least", "largest": "acceleration, most",
        "S1": "acceleration at S1", "S2": "acceleration at S2",
        "fluctuation of ballast": "ballast acceleration, fluctuation"},
    "soil behind the structure": {
        "away from it": "soil away from the structure, largest",
        "towards it": "soil towards the structure, largest"},
    "sleepers that move down ahead": {"number": "sleepers moving down ahead"}}


def half_the_step(n):
    """What half the step of stones and coupling changes."""
    def changes(group):
        return [change(n, "stones_none_1", f"stones_none_{as_file(HALVED)}", quantity)
                for quantity in OF_STEP[group].values()]

    def most(group):
        return percent(max(changes(group), key=abs))
    rows = [(group, ", ".join(f"{name} {percent(off)}" for name, off in
                              zip(OF_STEP[group], changes(group)))) for group in OF_STEP]
    return f"""Half the step of stones and coupling changes displacements of the ground by at most
{most("displacement of the ground")} and medians over sleepers by at most {most("median")}: these
are converged. Single sleepers (at most {most("single sleepers")}), the largest residual settlement
({most("residual settlement")}) and largest accelerations of single sleepers (at most
{most("acceleration of single sleepers")}) are not. Stresses at the edge change by at most
{most("stress at the edge")}. Packing 1 without wedge:

{table(["of", "change with half the step"], rows)}"""


def part_missing():
    return heading("Not repeated") + f"""
- Measured curves, which the study shows beside its own, and its deviations from them: they are
  figures.
- The deviations of 2.9 and 31 % that the study states between computed and measured accelerations.
- A packing with stones of {PUBLISHED_STONES} kg/m3 as loose as the study's; sleepers of disks.
- Other packings prepared with full friction.
"""


SECTIONS = (part_sleepers, part_preparation, part_speeds, part_wedges, part_vehicle,
            part_convergence)
