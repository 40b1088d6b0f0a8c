"""Targets of the study crossing. Where the thesis gives no number, the limit is ours (OURS)."""
from . import crossing_scanned as scanned
from . import crossing_stones as stones
from .crossing_cases import BEDS, JOINTS, PANELS, VOIDS, bed_run
from .study import Target

from trackbed_post.monitor import trains  # noqa: I001 (found by .study)

OURS = "ours:"  # begin of what stands for a published value if there is none
EXAMPLE = 1.3   # Hz, high-pass filter of an example of the thesis
HALF = 0.5      # relative deviation from it that counts as reproduced
SURFACE = 15    # %, of the depth of an irregularity, by which it may err
STEP = 0.1      # m/s, of the search of the speed


def is_ours(target):
    return target.published.startswith(OURS)


def of(n):
    """Those with something published first."""
    found = [*of_kernel(n), *of_displacement(n), *of_trains(n), *of_indicators(n), *of_joints(n),
             *of_ballast(n), *scanned.targets(n), *stones.targets(n)]
    return sorted(found, key=is_ours)


def within(n, what, run, quantity, limit, kind="main", unit="%", see=""):
    """An error that is to be below a limit of ours."""
    value = n(run, quantity)
    return Target(what, kind, f"{OURS} below {limit:g} {unit}", value, unit, holds=value < limit,
                  see=see)


def of_kernel(n):
    late = n("kernel", "largest response after 0.03 s")
    return [Target("spacing of the Green's functions at 50 m/s and 5 kHz", "input", "1 cm",
                   n("kernel", "spacing"), "cm", value=1.0, close=1e-6),
            Target("largest response after 0.03 s, of the largest", "soft", "almost none", late,
                   "%", holds=late < 10)]


def of_displacement(n):
    see = "Displacement and train"
    return [Target("frequency of the high-pass filter of the thesis", "soft",
                   f"{EXAMPLE:g} Hz in an example", n("known", "high-pass frequency"), "Hz",
                   value=EXAMPLE, close=HALF, see=see),
            within(n, "displacement of six coaches, 0.1 % noise", "known",
                   "error of displacement, smoothing, noise 0.1 %, worst", 5, see=see),
            within(n, "the same by the method of the thesis", "known",
                   "error of displacement, high_pass, noise 0.1 %, worst", 5, "soft", see=see)]


def of_trains(n):
    see = "Displacement and train"
    speed = n("other", "error of speed, worst")
    found = [Target("speed of a known train, error", "main", f"steps of {STEP:g} m/s", speed, "m/s",
                    holds=speed < STEP, sign=speed < STEP, see=see, infinite="not recognised")]
    for run, what, kind in (("other", "the known train at another speed", "main"),
                            ("single", "a single coach to six", "main"),
                            ("fewer", "five coaches to six", "soft")):
        if not n.has(run) or (run, "wall_time") in n.rows and len(quantities(n, run)) == 1:
            continue
        value = n(run, "similarity, least" if run == "other" else "similarity")
        known = run == "other"
        holds = (value > trains.ACCEPTED) == known
        found.append(Target(f"similarity of {what}", kind,
                            f"{'above' if known else 'below'} {trains.ACCEPTED:g}", value, "",
                            holds=holds, sign=holds if kind == "main" else None, see=see))
    return found


def quantities(n, run):
    return [quantity for of_run, quantity in n.rows if of_run == run]


def of_indicators(n):
    found = []
    for what, value in (("indicator and largest force over dips, rank correlation",
                         n("dips", "rank correlation")),
                        ("the same in each of six sets of pads and ballast, least",
                         min(n(panel, "rank correlation") for panel in PANELS))):
        found.append(Target(what, "main", "the indicator rises", value, "", holds=value > 0.9,
                            sign=value > 0, see="Indicators"))
    return found


def of_joints(n):
    found, see = [], "Wheel forces and irregularity"
    for name, (depth, length) in JOINTS.items():
        run = f"joint_{name}"
        if not n.has(run):
            continue
        for what, short, limits in (("the largest force", "largest force", (10, 20)),
                                    ("the irregularity", "irregularity over its depth",
                                     (SURFACE, SURFACE))):
            for noise, limit in zip(("0.1 %", "1 %"), limits):
                soft = short != "largest force" and noise == "1 %"
                found.append(within(n, f"dip of {1e3 * depth:g} mm in {length:g} m: {short}, "
                                    f"{noise} noise", run, f"error of {what}, noise {noise}, worst",
                                    limit, "soft" if soft else "main", see=see))
    return found


def of_ballast(n):
    found = [within(n, f"stiffness of the ballast at the sensor, {name}", bed_run(name),
                    "error of the stiffness, worst", 10, see="Ballast")
             for name in BEDS if n.has(bed_run(name))]
    if not n.has("voids"):
        return found
    value, count = n("voids", "found"), len(VOIDS)
    false = n("voids", "false alarms")
    return found + [
        Target(f"voids found, of {count}", "main", f"{OURS} all", value, "", holds=value == count,
               sign=value > 0, see="Ballast"),
        Target(f"voids reported where there is none, in {n('voids', 'sound passages'):.0f} "
               "passages", "main", f"{OURS} none", false, "", holds=false == 0, sign=false == 0,
               see="Ballast")]
