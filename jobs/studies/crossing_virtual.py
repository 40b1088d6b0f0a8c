"""Parts of the document of the study crossing: scanned crossings, and the sleeper on stones."""
import numpy as np

from . import crossing_places as places
from . import crossing_scanned as scanned
from . import crossing_stones as stones
from .crossing_chain import has, pair, without_empty
from .study import between, cell, deck_of, heading, table

from trackbed_post.monitor import ballast  # noqa: I001 (found by .study)

SEEN = ballast.SIGNIFICANT**2  # reduction of the sum of squares with which a void is recognised


def refused_seeds(n, run):
    if not has(n, run, "refused seeds"):
        return "some seeds"
    return f"{n(run, 'refused seeds'):.0f} of {n(run, 'seeds'):.0f} seeds"


def cases_of(n):
    """(design, move, wheel, its title, run)."""
    return [(*case, wheel, title, scanned.name_of(*case, wheel)) for case in scanned.CASES
            for wheel, title in scanned.WHEELS.items() if n.has(scanned.name_of(*case, wheel))]


def part_scanned(n):
    if not cases_of(n):
        return ""
    rows = []
    for design, move, wheel, title, run in cases_of(n):
        path = f"path_{move}_{wheel}"
        rows.append((design, move, title, f"{n(path, 'depth'):.2f}", f"{n(path, 'kink'):.1f}",
                     f"{n(run, 'largest force'):.0f}", f"{n(run, 'indicator'):.1f}",
                     *(pair(n, run, what) for what in ("the largest force", "the dynamic force",
                                                       "the irregularity", "the place"))))
    head = ["design", "move", "wheel", "depth, mm", "kink, mrad", "largest force, kN",
            "indicator, m/s2", "force, %", "its dynamic part, %", "irregularity, %", "place, cm"]
    return heading("Scanned crossings") + f"""
![Paths of the wheels; running surface, identified and true](scanned.png)

The thesis rolls wheels over scans of six crossings. These are not published: here
`inputs/track/crossing_scan.py` makes a scan of a crossing of 1:18.5 with noise, outliers and a
hole, and `trajectory` lets wheels of profile S1002, as they are and with a hollow tread, roll over
it. Its paths are the irregularities of `inputs/track/crossing_panel.toml` at 50 m/s: pads of
{scanned.PADS["60E"] / 1e6:.0f} MN/m (60E) and {scanned.PADS["UIC60"] / 1e6:.0f} MN/m (UIC60),
facing and trailing. The six panels of the thesis (its Table 1) are among the four rows of profile
S1002, since they differ in design and direction of travel, and in scans that are not available.
Errors with 0.1 % noise, median / worst, over seeds; the irregularity over its depth, the place of
the train in the record in cm. A passage is refused if its place is not found:

{without_empty(head, rows)}{part_causes(n)}"""


def part_causes(n):
    """Which part of the chain causes the errors of the irregularity."""
    found = [case for case in cases_of(n) if has(n, case[-1], "way without contact")]
    if not found:
        return "\nThe causes of these errors are not examined in these numbers.\n"
    rows = []
    for design, move, _, title, run in found:
        cells = []
        for placing in places.PLACINGS:
            errors = [n(run, f"error of the irregularity, {placing}{part}")
                      for part in ("", ", touching")]
            cells.append("refused" if np.isinf(errors[0]) else
                         " / ".join(f"{one:.0f}" for one in errors))
        late = n(run, "place, chain")
        rows.append((design, move, title, f"{n(run, 'way without contact'):.0f}",
                     "refused" if np.isinf(late) else f"{late:+.1f}",
                     f"{n(run, 'place, displacement'):+.1f}", *cells))
    head = ["design", "move", "wheel", "without contact, cm", "place, chain, cm",
            "place, displacement, cm", *places.PLACINGS.values()]
    return f"""
Parts of the chain were made exact to find the causes, one seed. Errors of the irregularity, % of
its depth: everywhere / only where the force of the wheel is more than
{100 * places.LIFTED:g} % of its static force:

{table(head, rows)}
{causes(n, found)}"""


def causes(n, found):
    def errors(placing, runs, part=""):
        return [n(run, f"error of the irregularity, {placing}{part}") for run in runs]
    runs = [case[-1] for case in found]
    lost = [run for run in runs if n(run, "way without contact") > 10
            and errors("force", [run])[0] > 20]
    astray = [run for run in runs if not abs(n(run, "place, chain")) < 2]
    change = max(abs(one - other) for one, other in zip(errors("silent", runs),
                                                        errors("place", runs)))
    text = (f"With the exact place, noise changes the error by at most {change:.0f} points, from "
            f"{between(errors('silent', runs))} to {between(errors('place', runs))} %. ")
    if lost:
        def free(of):
            return between([n(run, "way without contact") for run in of])
        other = [run for run in runs if run not in lost]
        beside = f" (in the others for {free(other)} cm)" if other else ""
        text += f"""In {len(lost)} of {len(runs)} rows the error with exact forces and place is
still {between(errors("force", lost))} %. In these rows the surface falls faster than the wheel,
which leaves the rail for {free(lost)} cm{beside}. There no force depends on the running surface, so
that no method that uses forces can find it: the identified surface is the path of the wheel in the
air, and its minimum is where the wheel lands, beside the true one. Where the wheel touches, the
error with exact forces is {between(errors("force", lost, ", touching"))} %. """
    if astray:
        text += f"""With the one seed of this table the chain finds a place that is wrong by more
than 2 cm, or refuses the passage, in {len(astray)} of {len(found)} rows. With the exact place the
error is {between(errors("place", astray))} %. The likelihood of the acceleration decides the place;
it assumes forces that are white noise near the dip, whereas the real ones have several kinks and a
loss of contact. That this is the cause was not tested. The displacement alone gives
{between([n(run, "place, displacement") for run in astray], "+.1f")} cm
there and an error of {between(errors("displacement", astray))} %. """
    return text + "\n"


def both(n, run, quantity, words, form):
    """Found / true of both trains, or of their mean."""
    cells = []
    for part in ("found", "true"):
        each = [f"{quantity}, {part}, {words}, train {train}" for train in (1, 2)]
        each = each if has(n, run, each[0]) else [f"{quantity}, {part}, {words}"]
        cells.append(", ".join(f"{n(run, one):{form}}" for one in each))
    return " / ".join(cells)


def part_stones(n):
    cases = [case for case in stones.CASES if n.has(stones.name_of(case))]
    if not cases:
        return ""
    rows = []
    for case in cases:
        run = stones.name_of(case)
        for noise in stones.NOISE:
            words = f"noise {100 * noise:g} %"

            def error(quantity, form=".0f", run=run, words=words):
                name = f"error of {quantity}, {words}, worst"
                return cell(n, run, name, form)
            rows.append((case, f"{100 * noise:g} %", error("displacement", ".1f"),
                         both(n, run, "settlement", words, ".3f"),
                         both(n, run, "stiffness", words, ".0f"), error("stiffness"),
                         both(n, run, "largest force", words, ".0f"), error("largest force"),
                         error("dynamic force")))
    each = has(n, stones.name_of(cases[0]), "stiffness, found, noise 0.1 %, train 1")
    shown = "values of both trains" if each else "means of two trains"
    head = ["case", "noise", "error of displacement, %", "settlement, mm", "stiffness, MN/m",
            "error, %", "largest force, kN", "error, %", "error of its dynamic part, %"]
    return heading("On stones") + f"""
![Displacement on stones, true and reconstructed, and their difference, 0.1 % noise](stones.png)

The accelerometer is on a sleeper of a plane bed of stones on a ground (`inputs/track/sensor.toml`),
after ten trains. The rail has a dip of
{1e3 * deck_of(stones.DECK)["irregularity"]["depth"]:g} mm above it. The chain assumes a track on
springs (`inputs/track/sensor_alone.toml`) and knows the noise of the sensor. {damping()} In the
void cases the straight rail is laid 0.3, 0.6 and 1 mm above the place of this sleeper; its pads
lift
the sleeper as far as the rail does not bend, so that gaps are smaller. In the fouled case only the
friction in the recorded trains is halved. The soft subgrade has half the modulus. The table has
{shown}, found / true; each train has one seed of noise, and errors are those of the worse train:

{without_empty(head, rows)}
{settlements(n, cases)}

The true stiffness is the secant of the reaction of the stones over the
displacement, both of wavelengths above 3 m. Both wheels are assumed to have the same force. A
linear track does not explain the motion of stones between impacts, so that forces that differ
from wheel to wheel fit it without being true.
{part_stiffness(n, cases)}{part_voids(n, cases)}"""


def damping():
    own, other = (1e-3 * deck_of(name)["ballast"]["damping"] for name in (stones.ALONE,
                                                                          stones.DECK))
    return (f"The damping of its ballast was chosen by hand, {own:g} kN s/m instead of the "
            f"{other:g} kN s/m of the springs beside the bed, as the stones damp more; "
            "it is not identified.")


def settlements(n, cases):
    """Which settlements are found at all."""
    each = [f", train {k + 1}" for k in range(len(stones.TRAINS))]
    first = stones.name_of(cases[0]), f"settlement, found, noise {100 * stones.NOISE[0]:g} %"
    pairs = [[n(stones.name_of(case), f"settlement, {part}, noise {100 * noise:g} %{train}")
              for part in ("found", "true")] for case in cases for noise in stones.NOISE
             for train in (each if has(n, first[0], first[1] + each[0]) else [""])]
    missed = [true for found, true in pairs if found == 0]
    others = [f"{found:.3f} / {true:.3f}" for found, true in pairs if found > 0]
    text = ""
    if missed:
        text = (f"No settlement is found in {len(missed)} of {len(pairs)} records, although the "
                f"true one is {between(missed, '.3f')} mm: so little cannot be distinguished from "
                "the drift of the sensor. ")
    if others:
        text += f"In the others it is {', '.join(others)} mm (found / true). "
    quantity = "deviation of the displacement"
    size = [n(run, quantity) for run in map(stones.name_of, cases) if has(n, run, quantity)]
    return text + (f"The stated standard deviation of the largest displacement is "
                   f"{between(size, '.3f')} mm with 0.1 % noise." if size else "")


PULL = """A negative reduction is no failure of the search: the model with a void does not contain
the one without. Without a gap the springs also pull the sleeper down when the rail lifts it; with
the smallest gap they do not. The weight of rail and sleeper, which holds a real sleeper down, is
not part of the model, so that a void makes the fit of a sleeper that is hardly lifted worse. """
STIFFNESSES = ("true", "found", "secant of the fitted model", "from the true displacement",
               "with the damping of the springs", "of this sleeper alone",
               "and true stiffness of the others")


def part_stiffness(n, cases):
    """Stiffness if parts of the chain are exact or others."""
    runs = [(case, stones.name_of(case)) for case in cases
            if has(n, stones.name_of(case), "stiffness, one train, found")]
    if not runs:
        return "\nThe causes of the errors of the stiffness are not examined in these numbers.\n"
    rows = [(case, *(f"{n(run, f'stiffness, one train, {which}'):.0f}" for which in STIFFNESSES))
            for case, run in runs]
    values = {which: np.array([n(run, f"stiffness, one train, {which}") for _, run in runs])
              for which in STIFFNESSES}
    same = np.abs(values["secant of the fitted model"] / values["found"] - 1).max()
    moved = np.abs(values["from the true displacement"] / values["found"] - 1).max()
    less = np.abs(values["with the damping of the springs"] / values["found"] - 1).max()
    return f"""
Experiments on the stiffness, MN/m, second train, 0.1 % noise:

{table(["case", *STIFFNESSES], rows)}
The secant of the fitted model by the definition of the true stiffness differs from its parameter by
at most {100 * same:.0f} %, as it must for springs. The true displacement in place of the
reconstructed one changes the stiffness by at most {100 * moved:.0f} %, the damping of the springs
in place of that chosen by hand by at most {100 * less:.0f} %.

{part_neighbours(values)}
"""


def part_neighbours(values):
    """What follows from the fits of one sleeper alone."""
    error = {which: 100 * np.abs(values[which] / values["true"] - 1)
             for which in ("found", *STIFFNESSES[-2:])}
    own, given = (error[which] for which in STIFFNESSES[-2:])
    soft = values["true"] < 0.5 * values["true"].max()  # hangs, or is on stones that slide
    if not soft.any():
        return "No sleeper is less than half as stiff as the sound one."
    words = (f"Where the sleeper with the sensor is less than half as stiff as the sound one, the "
             f"largest error is {error['found'][soft].max():.0f} % as found, "
             f"{own[soft].max():.0f} % if only this sleeper differs from the springs of the deck, "
             f"and {given[soft].max():.0f} % if the others have their true stiffness as well; in "
             f"the other cases it is {error['found'][~soft].max():.0f}, {own[~soft].max():.0f} and "
             f"{given[~soft].max():.0f} %. ")
    if given[soft].max() < 0.5 * error["found"][soft].max():
        words += ("Most of the error is therefore that of the model, which changes the stiffness "
                  "over several sleepers, whereas single ones hang, and takes all others as those "
                  "of the deck. One accelerometer does not tell them apart. ")
    return words + ("The remaining error contains the free travel: a spring carries from the "
                    "start, a sleeper above a void only when it touches the stones.")


def part_voids(n, cases):
    rows = [(case, f"{n(run, 'void'):.2f}", f"{n(run, 'reduction of the sum of squares'):.1f}",
             *(cell(n, run, one, ".0f")
               for one in ("sum of squares, no gap", "sum of squares, smallest gap")))
            for case, run in ((case, stones.name_of(case)) for case in cases)]
    soft = n(stones.name_of("void of 1 mm"), "stiffness, found, noise 0.1 %")
    sound = n(stones.name_of("sound"), "stiffness, found, noise 0.1 %")
    head = ["case", "fitted void, mm", "reduction of the sum of squares",
            "sum of squares of the fit without a gap", "with the smallest gap"]
    gains = [n(stones.name_of(case), "reduction of the sum of squares") for case in cases]
    return f"""
A void reduces the sum of squares by more than {SEEN:g} if it is recognised:

{without_empty(head, rows)}
{PULL if min(gains) < 0 else ""}A void is only seen as a loss of stiffness: with 1 mm, {soft:.0f}
instead of {sound:.0f} MN/m.
"""
