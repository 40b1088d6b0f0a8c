"""Parts of the document of the study crossing: the chain on a track on springs."""
import numpy as np

from . import crossing_jenkins as jenkins
from . import crossing_places as places
from . import crossing_targets
from .crossing import VARIANTS, variant
from .crossing_cases import BEDS, JOINTS, NOISE, PANELS, STIFFNESS, VOIDS, bed_run
from .study import between, heading, table


def joint_runs(n):
    return [f"joint_{name}" for name in JOINTS if n.has(f"joint_{name}")]


def dip_of(run):
    depth, length = JOINTS[run.removeprefix("joint_")]
    return f"{1e3 * depth:g} mm in {length:g} m"


def has(n, run, quantity):
    return (run, quantity) in n.rows


def too_small(n):
    """%, by which forces from the displacement are too small."""
    quantity = f"largest force, {variant(*VARIANTS[-1])}"
    return between([100 * (1 - n(run, quantity) / n(run, "largest force"))
                    for run in joint_runs(n)])


def part_passages(n):
    rows = []
    for noise in (0.0, *NOISE):
        cells = []
        for method in ("smoothing", "high_pass"):
            quantity = f"error of displacement, {method}, noise {100 * noise:g} %"
            cells += [f"{n('known', f'{quantity}, {part}'):.1f}" for part in ("median", "worst")]
        rows.append((f"{100 * noise:g} %", *cells))
    return heading("Displacement and train") + f"""
![Reconstructed and true displacement of the first coaches, 0.1 % noise](displacement.png)

Error of the displacement of six coaches at 50 m/s, % of the largest displacement:

{table(["noise", "smoothing, median", "worst", "high-pass (thesis), median", "worst"], rows)}
{compared(n)}

{cuts(n)} A minute of one core is enough for {n("known", "passages of 10 s in a minute"):.0f}
passages of 10 s at 5 kHz.

{trains_of(n)}
"""


def compared(n):
    """Which method is better with the largest noise."""
    words = f"noise {100 * NOISE[-1]:g} %"
    own, other = ([n("known", f"error of displacement, {method}, {words}, {part}")
                   for part in ("median", "worst")] for method in ("smoothing", "high_pass"))
    better = own[0] < 0.95 * other[0] and own[1] < 0.95 * other[1]
    return (f"With {100 * NOISE[-1]:g} % noise the smoothing is "
            + ("better than" if better else "no better than") + " the filter of the thesis: "
            f"{own[0]:.1f} and {own[1]:.1f} % against {other[0]:.1f} and {other[1]:.1f} %. Without "
            "noise the filter errs because it removes a part of the displacement as well.")


def cuts(n):
    text = (f"The search for the high-pass frequency gives {n('known', 'high-pass frequency'):.2f} "
            "Hz without noise")
    for noise in NOISE:
        quantity = f"high-pass frequency, noise {100 * noise:g} %, median"
        if has(n, "known", quantity):
            text += f", {n('known', quantity):.2f} Hz with {100 * noise:g} %"
    most = f"high-pass frequency, noise {100 * NOISE[-1]:g} %, median"
    if has(n, "known", most) and n("known", most) > 2 * n("known", "high-pass frequency"):
        text += ": it depends on the noise more than on the method"
    return text + (". The thesis finds 1.3 Hz in an example, a measured signal without its first "
                   "bogies, which a fault of the sensor had spoilt; the noise of this signal is "
                   "not known.")


def trains_of(n):
    """What was recognised."""
    text = (f"A train of six coaches is recognised at another speed with a similarity of "
            f"{n('other', 'similarity, least'):.3f}")
    if has(n, "other", "speed"):
        text += (f": {n('other', 'speed'):g} m/s lies between two steps of the search, the "
                 f"reference has 50 m/s, and the speed errs by at most "
                 f"{n('other', 'error of speed, worst'):.2g} m/s")
    text += (f". The unknown train is a single coach, which has a similarity of "
             f"{n('single', 'similarity'):.2f} with six.")
    if has(n, "fewer", "similarity"):
        return text + (f" This is an easy test: a train of five coaches has "
                       f"{n('fewer', 'similarity'):.2f}, so that it is taken for one of six; only "
                       "its length, which `monitor` reports, tells them apart.")
    return text + (" This is an easy test: five coaches are taken for six "
                   "([monitoring.md](../../monitoring.md), \"Trains\").")


def part_indicators(n):
    quantity = "force at the common indicator"
    more = has(n, "panels", "common indicator")
    rows = [(panel, f"{n(panel, 'rank correlation'):.3f}",
             *([f"{n(panel, quantity):.0f}"] if more else [])) for panel in PANELS]
    head = ["set", "rank correlation"]
    text = ""
    if more:
        head.append(f"force at an indicator of {n('panels', 'common indicator'):.3g} m/s2, kN")
        forces = [n(panel, quantity) for panel in PANELS]
        text = (f" Over all sets together the rank correlation is "
                f"{n('panels', 'rank correlation, pooled'):.3f}, and at the same indicator of "
                f"{n('panels', 'common indicator'):.3g} m/s2 the force is {between(forces)} kN.")
        if max(forces) > 1.1 * min(forces):
            text += (" The relation of indicator and force differs from set to set, so that an "
                     "indicator states the force only of a panel whose pads and ballast are known.")
    return heading("Indicators") + f"""
![Largest wheel force over the indicator for six sets of pads and ballast](indicators.png)

Dips of 0.2 to 4 mm in 0.6 to 2 m cause wheel forces of {n("dips", "least force"):.0f} to
{n("dips", "largest force"):.0f} kN at 50 m/s. The rank correlation of the indicator of 1 to 0.2 m
with the largest force is {n("dips", "rank correlation"):.3f}. The six panels of the thesis have
measured rails; here six sets of pads (values of the thesis) and ballast have the same dips. The
correlation of the few dips of one set says little.{text}

{table(head, rows)}"""


def pair(n, run, quantity, words=""):
    """Median and worst error, or empty if it was not measured."""
    found = [f"error of {quantity}{words}, {part}" for part in ("median", "worst")]
    if not has(n, run, found[0]):
        return ""
    return " / ".join("refused" if np.isinf(n(run, one)) else f"{n(run, one):.1f}"
                      for one in found)


def part_forces(n):
    rows, chosen = [], []
    for run in joint_runs(n):
        for noise in NOISE:
            words = f", noise {100 * noise:g} %"
            rows.append((f"{dip_of(run)}, {n(run, 'largest force'):.0f} kN", f"{100 * noise:g} %",
                         *(pair(n, run, quantity, words) for quantity in (
                             "the largest force", "the dynamic force", "the irregularity",
                             "the place")),
                         f"{n(run, f'error over stated deviation{words}'):.1f}"))
    for one in VARIANTS:
        name = variant(*one) + (" (nearest to the thesis)" if one == VARIANTS[-1] else "")
        chosen.append((name, *(f"{n(run, f'largest force, {variant(*one)}'):.0f}"
                               for run in joint_runs(n))))
    true = ("truth", *(f"{n(run, 'largest force'):.0f}" for run in joint_runs(n)))
    head = ["dip, largest force", "noise", "largest force, %", "its dynamic part, %",
            "irregularity, % of its depth", "place, cm", "over deviation"]
    return heading("Wheel forces and irregularity") + f"""
![Displacement of the sleeper after a force of one sample at four distances](kernel.png)

![Force and running surface: dip of 1.5 mm, first wheel, 0.1 % noise, first seed](forces.png)

The second peak of the true force, 3 m behind the dip, is the impact of the second wheel, which
reaches the first wheel through the rail. The chain hardly finds it{second(n)}, because forces of
one wheel alone are assumed to be small. Errors, median / worst, over seeds and both wheels; the
dynamic part is what exceeds the static force, {n('vee_27.8_deck', 'static force'):.0f} kN. Last
column: root mean square of error over stated standard deviation of the force; 1 is ideal, above 1
means that stated deviations are too small.

{without_empty(head, rows)}
Largest force of the first wheel, kN, 0.1 % noise, one seed, by method (docs/monitoring.md). The
row before the last is nearest to the thesis: displacement, truncated singular values, equal forces.
The thesis chooses its tolerance such that the identified forces reproduce the displacement (section
5.7.2); here it is chosen by cross-validation, since a displacement has no white noise.

{table(["", *(f"{1e3 * JOINTS[run.removeprefix('joint_')][0]:g} mm" for run in joint_runs(n))],
       [*chosen, true])}
The thesis says that responses have almost decayed after 0.03 s; here
{n("kernel", "largest response after 0.03 s"):.0f} % of the largest are left.
{part_sweep(n)}"""


def second(n):
    if not has(n, "joint_middle", "second peak, found"):
        return ""
    found, true = (n("joint_middle", f"second peak, {what}") for what in ("found", "true"))
    return f" ({found:.0f} instead of {true:.0f} kN)"


def without_empty(head, rows):
    """A table without the columns that no row has."""
    kept = [k for k in range(len(head)) if any(row[k] != "" for row in rows)]
    return table([head[k] for k in kept], [[row[k] for k in kept] for row in rows])


def sweep(n, run, what):
    """Errors, %, by the error of the place."""
    return [n(run, f"error of the {what}, place wrong by {offset:g} cm")
            for offset in places.OFFSETS]


def swept(n):
    return [run for run in joint_runs(n)
            if has(n, run, "error of the irregularity, place wrong by 0 cm")]


def effect_of_place(n):
    """A sentence, or nothing if it was not measured."""
    runs = swept(n)
    if not runs:
        return ""
    exact, far = ([sweep(n, run, "irregularity")[places.OFFSETS.index(at)] for run in runs]
                  for at in (0, 1))
    return (f"If the place of the wheels in the record is wrong by a centimetre, the irregularity "
            f"errs by {between(far)} % of its depth, with the exact place by {between(exact)} %.")


def part_sweep(n):
    runs = swept(n)
    if not runs:
        return "\nWhat an error of the place changes is not examined in these numbers.\n"
    rows = [(dip_of(run), what, *(f"{one:.0f}" for one in sweep(n, run, what)))
            for run in runs for what in ("irregularity", "largest force")]
    return f"""
The place of the train in the record was made wrong on purpose, 0.1 % noise, one seed. Errors, % of
the depth or of the force:

{table(["dip", "error of", *(f"{offset:+g} cm" for offset in places.OFFSETS)], rows)}
{effect_of_place(n)} The largest force depends on the place far less.{enough(n, runs)}
"""


def enough(n, runs):
    """Whether the place explains irregularities that are wrong by more than the limit."""
    exact = [sweep(n, run, "irregularity")[places.OFFSETS.index(0)] for run in runs]
    limit = crossing_targets.SURFACE
    return (f" With the exact place all are within the limit of {limit} %: it is the place that "
            "makes irregularities miss it.") if max(exact) < limit else ""


def part_ballast(n):
    rows = []
    for name in BEDS:
        run = bed_run(name)
        if n.has(run):
            far = n(run, "stiffness far away, error over stated deviation")
            rows.append((f"{1e-6 * BEDS[name] * STIFFNESS:g}",
                         *(f"{n(run, f'error of the stiffness, {part}'):.1f}"
                           for part in ("median", "worst")), f"{far:.1f}"))
    stiff = ", ".join(f"{1e-6 * BEDS[name] * STIFFNESS:g}" for name in BEDS)
    text = heading("Ballast") + f"""
![Displacement and that of the calibrated model, wavelengths above 3 m](ballast.png)

All sleepers have {1e-6 * STIFFNESS:g} MN/m per rail seat, the three at the sensor {stiff}. The dip
of the running surface is not known to the calibration, which fits a smooth one of 1.5 m. Errors of
the stiffness at the sensor with 0.1 % noise; far from the sensor the stiffness is uncertain, and
its error is given over the stated deviation:

{table(["MN/m", "error, median, %", "worst, %", "far away, over deviation"], rows)}{bias(n)}"""
    if not n.has("voids"):
        return text
    found = [(f"{1e3 * void:g}", f"{n(f'void_{k + 1}', 'void'):.2f} +- "
              f"{n(f'void_{k + 1}', 'its deviation'):.2f}",
              f"{n(f'void_{k + 1}', 'reduction of the sum of squares'):.0f}")
             for k, void in enumerate(VOIDS)]
    return text + f"""
A void is recognised because the support stiffens when the gap closes:

{table(["void, mm", "found, mm", "reduction of the sum of squares"], found)}
{n("voids", "found"):.0f} of {len(VOIDS)} are reported as voids, and
{n("voids", "false alarms"):.0f} in the passages without one.
"""


def bias(n):
    """Whether the stiffest support errs by its bias, and experiments on its cause."""
    run = bed_run("double")
    if not n.has(run):
        return ""
    half, worst = (n(run, f"error of the stiffness, {part}") for part in ("median", "worst"))
    text = (f"\nWith the double stiffness the median error, {half:.1f} %, is nearly the worst one, "
            f"{worst:.1f} %: it is a bias of the model, not noise."
            if half > 0.7 * worst else "\n")
    causes = (("silent", "without noise"), ("even", "without noise, even rail"),
              ("smooth", "without noise, even rail, transition of the form that is fitted"))
    if not has(n, run, "error of the stiffness, silent"):
        return text + "\n"
    found = ", ".join(f"{n(run, f'error of the stiffness, {key}'):+.1f} % {words}"
                      for key, words in causes)
    return (f"{text} Experiments: {found}. The support of the three sleepers changes in a step, "
            "that of the model as a Gaussian.\n")


def part_jenkins(n):
    rows = []
    for speed in jenkins.VEES:
        for name, factor in jenkins.DAMPINGS.items():
            run = jenkins.name_of(speed, name)
            rows.append((f"{speed:g}", f"{factor:g}", *(f"{n(run, quantity):.0f}" for quantity in (
                "largest force", "P1", "largest force below 150 Hz", "P2"))))
    angle, rail = 1e3 * jenkins.ANGLE, jenkins.EFFECTIVE
    return heading("Jenkins' formulas") + f"""
The simulated wheel forces are the truth of all other sections. Formulas check them independently:
P1 and P2 of Jenkins and others (1974) are the largest forces of high and of low frequency behind a
joint, with the values of the deck. The running surface is a V of {angle:g} mrad in all, without the
stiffer rail; forces in kN. The rail that moves with the contact in P1 is taken as {rail:g} m.

{table(["speed, m/s", "ballast damping over that of the deck", "largest force", "P1",
        "below 150 Hz", "P2"], rows)}
With the damping of the deck, that of the thesis, P2 is {between(off(n, "deck"))} % smaller than the
computed force below 150 Hz; with a tenth of it the difference is at most
{max(map(abs, off(n, "tenth"))):.0f} %. P2 treats damping as small: P2 less the static load falls in
proportion to the damper, here to {100 * left(n):.0f} % of that with a tenth of the damping. A
strong damper carries load itself, so that P2 does not hold for the damping of the thesis. P1 is
{between(off_p1(n))} % smaller than the largest computed force; it depends on the assumed
{rail:g} m.
"""


def off_p1(n):
    runs = [jenkins.name_of(speed, name) for speed in jenkins.VEES for name in jenkins.DAMPINGS]
    return [100 * (1 - n(run, "P1") / n(run, "largest force")) for run in runs]


def off(n, damping):
    """%, by which P2 is smaller than the computed force."""
    runs = [jenkins.name_of(speed, damping) for speed in jenkins.VEES]
    return [100 * (1 - n(run, "P2") / n(run, "largest force below 150 Hz")) for run in runs]


def left(n):
    strong, weak = (n(run, "P2") - n(run, "static force") for run in (
        jenkins.name_of(jenkins.VEES[0], name) for name in jenkins.DAMPINGS))
    return strong / weak
