"""Document of the study crossing, from its numbers alone. Its parts: crossing_setup.py,
crossing_chain.py, crossing_virtual.py; figures: crossing_figures.py.
"""
import numpy as np

from . import crossing_chain as chain
from . import crossing_figures, crossing_setup
from . import crossing_scanned as scanned
from . import crossing_stones as stones
from . import crossing_virtual as virtual
from .crossing_cases import BEDS, bed_run
from .study import heading

from trackbed_post.monitor import displacement, indicators, trains  # noqa: I001 (found by .study)

TITLE = "crossing: from one accelerometer to forces, irregularity and ballast"
SOURCE = """The thesis *Model-based condition monitoring of railway switches and crossings* derives
displacement, indicators, train and speed, wheel forces, the irregularity of the running surface and
the stiffness of the ballast from the acceleration of one sleeper. Its measurements are not
published. Here the program's own passages over a crossing (`inputs/track/crossing.toml`) are the
measurements, so that the truth is known; the chain is that of [monitoring.md](../../monitoring.md).
"""
CRITERION = crossing_setup.criterion


def document(n):
    return "".join((crossing_setup.part_limits(n), crossing_setup.part_setup(n),
                    chain.part_passages(n), chain.part_indicators(n), chain.part_forces(n),
                    virtual.part_scanned(n), chain.part_ballast(n), virtual.part_stones(n),
                    chain.part_jenkins(n), part_missing()))


def figures(_, lines, folder):
    crossing_figures.draw(lines, folder)


def summary(n):
    runs = chain.joint_runs(n)
    worst, surface = (max(n(run, f"error of the {what}, noise 0.1 %, worst") for run in runs)
                      for what in ("largest force", "irregularity"))
    bed = max(n(bed_run(name), "error of the stiffness, worst") for name in BEDS
              if n.has(bed_run(name)))
    return f"""
- Over dips of a track on springs, with 0.1 % noise, the largest wheel force errs by at most
  {worst:.1f} %, the irregularity by
  {surface:.1f} % of its depth, the stiffness of the ballast at the sensor by {bed:.1f} %.
- Forces are identified from the acceleration. From the displacement, as in the thesis, the largest
  force is {chain.too_small(n)} % too small, since the displacement hardly contains the impact.
{summary_of_places(n)}{summary_of_scans(n)}{summary_of_stones(n)}"""


def summary_of_places(n):
    text = chain.effect_of_place(n)
    return f"- {text}\n" if text else ""


def summary_of_scans(n):
    """The worst of all designs and directions of travel, by wheel, and the runs with refusals."""
    texts, refused = [], []
    for wheel, title in scanned.WHEELS.items():
        cases = [case for case in scanned.CASES if n.has(scanned.name_of(*case, wheel))]
        errors = []
        for case in cases:
            run = scanned.name_of(*case, wheel)
            found = [n(run, f"error of {what}, worst")
                     for what in ("the largest force", "the irregularity")]
            if np.isfinite(found).all():
                errors.append(found)
                continue
            median = n(run, "error of the irregularity, median")
            amount = "is not found in the median" if np.isinf(median) else \
                f"errs by {median:.0f} % in the median"
            refused.append(f"{case[0]}, {case[1]}, {title}: the irregularity {amount}, and the "
                           f"passage is refused for {virtual.refused_seeds(n, run)}")
        if errors:
            force, surface = np.max(errors, axis=0)
            texts.append(f"{force:.0f} and {surface:.0f} % ({title})")
    if not texts and not refused:
        return ""
    return ("- On a made-up scan of a crossing, the largest force and the irregularity err by at "
            f"most {'; '.join(texts)}"
            + (f". Runs with refused passages are not part of this ({'; '.join(refused)})"
               if refused else "") + ".\n")


def summary_of_stones(n):
    cases = [case for case in stones.CASES if n.has(stones.name_of(case))]
    runs = [stones.name_of(case) for case in cases]
    if not runs:
        return ""
    moved, force = (max(n(run, f"error of {quantity}, noise 0.1 %, worst") for run in runs)
                    for quantity in ("displacement", "largest force"))
    quantity = "error of dynamic force, noise 0.1 %, worst"
    dynamic = [n(run, quantity) for run in runs if (run, quantity) in n.rows]
    part = f" (its part above the static force by {max(dynamic):.0f} %)" if dynamic else ""
    stiffness = [f"{n(run, 'error of stiffness, noise 0.1 %, worst'):.0f} % ({case})"
                 for run, case in zip(runs, cases)]
    voids = [n(run, "reduction of the sum of squares") > virtual.SEEN
             for run in runs if "void" in run]
    return f"""- On stones, with 0.1 % noise, the displacement errs by at most {moved:.1f} %, the
  largest force by {force:.0f} %{part}, the stiffness by {', '.join(stiffness)}. Voids that
  are recognised:
  {sum(voids)} of {len(voids)}.
"""


def part_missing():
    longest, shortest = indicators.WAVELENGTHS
    coarse, fine = displacement.STEPS
    return heading("What is left out") + f"""
- Settings of the thesis are those of the chain and are no results; they are not listed as targets:
  the band of the indicator, v/{longest:g} m to v/{shortest:g} m ({50 / longest:g} to
  {50 / shortest:g} Hz at 50 m/s); rest where the mean square over {displacement.WINDOW:g} m is
  below {displacement.THRESHOLD:g} of its largest value (different from the thesis, only wavelengths
  of {displacement.BAND[1]:g} to {displacement.BAND[0]:g} m count); speeds of {trains.SPEEDS[0]:g}
  to {trains.SPEEDS[-1]:g} m/s in steps of {trains.SPEEDS[1] - trains.SPEEDS[0]:.1f} m/s;
  acceptance above {trains.ACCEPTED:g}; a high-pass frequency below {displacement.HIGHEST:g} Hz in
  steps of {coarse:g}, then {fine:g} Hz.
- Measured accelerations and scanned rails are not published: nothing here shows that the chain
  works with the faults of real sensors, other than those tested in docs/monitoring.md, or with the
  wear of real crossings. The six crossings of the thesis differ here only in pads and direction.
- The path of a wheel does not depend on its lateral motion, and all wheels of a run have the same
  profile.
- Sleepers as beams of several lengths below four rails (docs/track.md has two rails), and the
  forces of the other rail: the study uses one rail.
- Green's functions of the coupled model; there the chain uses those of a track on springs.
- Drift with temperature, moving averages over months and batches of passages are tested on made-up
  tables only; the quality checks of signals are described in docs/monitoring.md.
"""
