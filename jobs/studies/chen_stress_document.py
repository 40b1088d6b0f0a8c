"""Parts of the document of the study chen on stresses, from its numbers and lines alone."""
import numpy as np

from .chen_runs import (AROUND, AXLES, CARRIAGE, CARRIAGES, CYCLES, DECK, DEPTHS, EXTREMES, GRAVITY,
                        LEAD, MIDDLE, PACKINGS, RIG, SINE, SINE_SPEED, SINE_STRESS, TOTAL,
                        name_of, seat_share)
from .chen_targets import (PRESSURES, SMALL, WHEELBASE, changes_sign, faster, growth, has_series,
                           of, path_of, rotation_ratio, shear_range, stored)
from .study import heading, listed, span, table

SPACING = DECK["sleepers"]["spacing"]
SEATS = DECK["sleepers"]["first"] + SPACING * np.arange(DECK["sleepers"]["count"])


def part_stress(n):
    rows = [(f"{title} at z/h {depth / TOTAL:.3f}, kPa",
             *(span(of(n, tonnes, f"{title} at {depth} m"), ".0f") for tonnes, _ in EXTREMES))
            for title in ("vertical", "horizontal") for depth in DEPTHS]
    rows += [(f"range of shear below the edges at z/h {depth / TOTAL:.3f}, kPa",
              *(span(of(n, tonnes, f"range of shear at {depth} m"), ".0f")
                for tonnes, _ in EXTREMES)) for depth in DEPTHS]
    top, bottom, base = (np.mean(of(n, 25, quantity)) for quantity in (
        f"vertical at {DEPTHS[0]} m", f"vertical at {DEPTHS[-1]} m", "sub-ballast on the base"))
    even, falls = (100 * (1 - below / top) for below in (base, bottom))
    return heading("Stress") + f"""
![Stresses below sleeper 3 over time, and stress paths](stress.png)

Vertical and horizontal stresses below the middle of sleeper 3 while the front wheel of a bogie is
above it, mean over four bogies, weight included; range of the shear stress over the whole passage,
mean of both edges of sleeper 3:

{table(("", "17 t", "25 t"), rows)}
If the load were spread evenly over the slice, the stress at z/h 0.778 would be {even:.0f} % lower
than at 0.222 (published 65 %, here {falls:.0f} %). Here neighbouring sleepers are loaded at the
same time, with {100 * seat_share(SPACING):.0f} and {100 * seat_share(2 * SPACING):.0f} % of the
peak. Another pulse was not tried.

{shear_words(n)}

{largest_words("The horizontal stress is", n, "horizontal at {} m", 0.511)} Our
cells extend over the whole width of the slice, the study's measuring spheres over 0.1 m of it.

{contact_words()}
"""


def shear_words(n):
    middle = [shear_range(n.lines, depth) for depth in DEPTHS]
    edges = [of(n, 25, f"range of shear at {depth} m") for depth in DEPTHS]
    changes = 100 * (edges[-1] / edges[0] - 1)
    return f"""The targets of shear stress are those below the middle of sleeper 3, as in the study,
under 25 t in packing {PACKINGS[0]}, computed from lines.csv. There its range is
{listed(middle)} kPa at the three depths. Below the edges it changes by {span(changes, "+.0f")} %
from z/h 0.222 to 0.778. {largest_words("It is", n, "range of shear at {} m", 0.222)}"""


def largest_words(what, n, quantity, theirs):
    """At which z/h the mean over the packings is largest under 25 t, in the study at `theirs`."""
    means = [of(n, 25, quantity.format(depth)).mean() for depth in DEPTHS]
    ours = round(DEPTHS[int(np.argmax(means))] / TOTAL, 3)
    if ours == theirs:
        return f"{what} largest at z/h {ours:.3f}, as in the study."
    return f"{what} largest at z/h {ours:.3f}, in the study at {theirs:.3f}. Why was not examined."


def contact_words():
    """Seat loads of the whole slice with the first wheel at sleepers 1 and 5."""
    first, last = (sum(seat_share(x - front + axle) for x in SEATS for axle in AXLES)
                   for front in (SEATS[0], SEATS[-1]))
    return f"""While the first wheel is above sleeper 5, the second one is already above sleeper 1.
The five sleepers then carry {last / first:.2f} times the load with the first wheel above sleeper 1.
The load alone explains a larger mean contact force, whose ratio is therefore a check of the
input. The number of contacts may increase by the load or by compaction; the two were not
separated."""


def part_rotation(n):
    rows = [(f"{title}, {depth} m", *(span(of(n, 25, f"{quantity}, {place}, {depth} m"), ".0f")
                                      for place in ("left edge", "centre", "right edge")))
            for title, quantity in (("angle", "angle"), ("its range", "rotation"))
            for depth in DEPTHS]
    ratio = rotation_ratio(n)
    also = ", as here" if inclined(n) else ", which is not so here at all depths"
    clearly = "" if ratio.min() > 1 or ratio.max() < 1 else ", which is not clearly more or less"
    return heading("Rotation") + f"""
Rotation of the principal stress below sleeper 3 (the study's angle psi) by the last bogie, degrees,
25 t, 120 km/h: the angle while the deviator is largest, and the range of the angle while the
deviator exceeds a fifth of its largest value.

{table(("depth below the sleeper", "left edge", "middle", "right edge"), rows)}
In the study the stress is inclined at the edges, to both sides, and hardly below the middle{also}.
The range of the angle at the edges is {span(rotation_ratio(n), ".2f")} times that below the middle
in {len(rotation_ratio(n))} packings{clearly}. In the study the angle below the middle is "almost
unchanged".{cut_words(n)}
"""


def inclined(n):
    """Whether the mean angle differs in sign between the edges, and is small below the middle, at
    all depths."""
    left, centre, right = (np.array([of(n, 25, f"angle, {place}, {depth} m").mean()
                                     for depth in DEPTHS])
                           for place in ("left edge", "centre", "right edge"))
    small = SMALL * np.minimum(np.abs(left), np.abs(right))
    return bool(np.all(left * right < 0) and np.all(np.abs(centre) < small))


def cut_words(n):
    """What the numbers of earlier runs leave out."""
    if stored(n, "rotation, length before and behind the bogie"):
        return ""
    change = max(abs(range_below_middle(n.lines, depth, AROUND)
                     - range_below_middle(n.lines, depth, LEAD)) for depth in DEPTHS)
    return f"""

These ranges also leave out all times at which the bogie is more than {LEAD:g} m away from the
sleeper. At that distance the seat load is still {100 * seat_share(LEAD):.0f} % of its peak. Below
the middle in packing {PACKINGS[0]}, whose full histories are in lines.csv, a distance of {AROUND:g}
m changes the range by at most {change:.1f} degrees. At the edges only the shortened histories are
stored. So the verdict of this target does not prove much. `jobs/studies/chen.py` now measures up to
{AROUND:g} m; that needs new runs."""


def range_below_middle(lines, depth, around):
    """Range of the angle below the middle of sleeper 3 from `around` before the last bogie to
    `around` behind it, degrees; 25 t, packing 1."""
    label = f"z/h = {depth / TOTAL:.3f}"
    time = np.array(lines.of("vertical")[label][0])
    vertical, horizontal, shear = (np.array(lines.of(title)[label][1])
                                   for title in ("vertical", "horizontal", "shear"))
    axles = [x for x in AXLES if x < CARRIAGES * CARRIAGE]
    behind = DECK["load"]["start"] + DECK["load"]["speed"] * time - SEATS[MIDDLE]  # of first axle
    near = (behind >= axles[-2] - around) & (behind <= axles[-1] + around)
    deviator = (vertical - horizontal)[near]
    angle = np.degrees(np.arctan2(2 * shear[near], deviator) / 2)
    return np.ptp(angle[deviator > 0.2 * deviator.max()])


def part_pressure(n):
    rows = [(title, *(span(of(n, tonnes, quantity), ".0f") for tonnes, _ in EXTREMES))
            for title, quantity in zip(("ballast on sub-ballast, kPa",
                                        "sub-ballast on the base, kPa"), PRESSURES)]
    layer, ballast = DECK["bed"]["layer"][0], DECK["material"][1]
    weight = (1 - layer["porosity"]) * layer["height"] * ballast["density"] * GRAVITY
    upper, lower = (growth(n, quantity) for quantity in PRESSURES)
    return heading("Sub-ballast") + f"""
Pressures above and below the sub-ballast, mean over the base, at the moments of the table of
stresses, weight included:

{table(("", "17 t", "25 t"), rows)}
The study divides the total contact forces at the interface or at the bottom by the area of the base
(its section 4.2.1). Here the upper pressure is the mean vertical stress of the two rows of cells
beside the interface, the lower one the force on the floor divided by that area. Their vertical
forces differ by the weight of the sub-ballast ({1e-3 * weight:.1f} kPa), by inertia and by friction
at the sides, which is {DECK["contact"][5]["friction"]:g} here and in the study. A layer can spread
the pressure, but cannot reduce its mean over the base of a periodic slice. Sums of the magnitudes
of contact forces, which contain horizontal parts, were not computed.

The study stresses that the lower pressure grows less with the axle load than the upper one
({PRESSURES["sub-ballast on the base"]} against {PRESSURES["ballast on sub-ballast"]} %). Here they
change by {np.mean(lower):+.1f} and {np.mean(upper):+.1f} %; both contain the same load, which grows
by {np.mean(growth(n, "largest load")):.0f} %. The limit of 30 % does not test
this difference.
{plateau_words(n) if has_series(n) else ""}"""


def plateau_words(n):
    (slow, fast), (up, on) = ([faster(n, 25, quantity, *pair) for pair in ((60, 90), (90, 150))]
                              for quantity in ("largest load", "ballast on sub-ballast"))
    return f"""
The study finds almost constant pressures beyond 90 km/h. By its impact factor, which is linear in
the speed, the load of a seat grows by {slow:.0f} % from 60 to 90 and by {fast:.0f} % from 90 to 150
km/h. The pressure on the sub-ballast, weight included, changes by {up:+.0f} and {on:+.0f} %.
By the equilibrium of vertical forces it has to follow the load. How the study obtains a plateau is
not stated.
"""


def part_path(n):
    path = path_of(n.lines)
    sign = "" if changes_sign(n) else " Why the shear does not change its sign was not examined."
    old = "" if np.isclose(n("haversine", "largest shear after"), path.after, atol=0.05) else (
        ', as "largest shear after" of numbers.csv includes the row of the largest deviator')
    return heading("Single load and test rig") + f"""
![Stress path below sleeper 3 under a haversine that passes](path.png)

{CYCLES} haversines of {1e-3 * SINE_STRESS:.0f} kPa and {SINE} Hz act on one sleeper after the
other at {3.6 * SINE_SPEED:.0f} km/h, on packing {PACKINGS[0]}. In the last of them the largest
change of shear {DEPTHS[0]:g} m below sleeper {MIDDLE + 1} is {path.before:.1f} kPa before the
largest deviator ({path.deviator:.0f} kPa), {path.then:.1f} kPa at that moment and {path.after:.1f}
kPa later. These values are computed from the histories in lines.csv{old}. The deviator rises by
{path.jump:.0f} kPa from one row to the next at {path.time:.3f} s; the cause is not known.{sign}

The test rig's measurements (17 t, 300 km/h) are published as figures and not compared. The stress
below sleeper 3 has the M with {n(name_of(*RIG, PACKINGS[0]), "frequency of the M"):.1f} Hz
(v/{WHEELBASE:g} m: {RIG[1] / 3.6 / WHEELBASE:.1f} Hz).
"""
