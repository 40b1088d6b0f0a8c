"""Set-up of the study crossing and its own limits as Markdown, from decks, numbers and targets."""
import math

from . import crossing_scanned as scanned
from . import crossing_stones as stones
from . import crossing_targets as targets
from .crossing_cases import DECK, FORMS, JOINTS, RATE, SPEED
from .study import deck_of, heading, table

from trackbed_post.monitor import trends  # noqa: I001 (found by .study)

ALARM = 100 * trends.CHANGED  # %


def own_limits(n):
    """(what, limit, reason, words that its targets contain)."""
    shallow, deep = (10 * targets.SURFACE * depth for depth in
                     (min(one for one, _ in JOINTS.values()),
                      max(one for one, _ in JOINTS.values())))
    change = f"of a change of {ALARM:g} %, which `monitor` reports as an alarm"
    return (("displacement", "5 %", f"a quarter {change}",
             ("displacement of six", "method of the thesis", ": displacement")),
            ("largest force", "10 %, with 1 % noise 20 %", f"half {change}; with 1 % noise all of "
             "it", (": largest force",)),
            ("irregularity over its depth", f"{targets.SURFACE:g} %",
             f"{shallow:.1f} to {deep:.2g} mm of the dips below", (": irregularity",)),
            ("stiffness", "10 %", f"half {change}", (": stiffness", "stiffness of")),
            ("voids", "all and none", "a false alarm or a missed void costs a visit to the track",
             ("voids ",)))


def part_limits(n):
    found = [target for target in targets.of(n) if targets.is_ours(target)]
    rows = []
    for what, limit, reason, words in own_limits(n):
        of = [target for target in found if any(word in target.what for word in words)]
        rows.append((what, limit, reason,
                     f"{sum(target.reproduced() is True for target in of)} of {len(of)}"))
    return heading("Our own limits") + f"""
Most targets compare with the known truth of a simulation, for which the thesis gives no number.
Their limits are ours; they are not results of the thesis:

{table(["quantity", "largest error", "reason", "kept"], rows)}"""


def criterion(n):
    found = targets.of(n)
    own = [target.reproduced() is True for target in found if targets.is_ours(target)]
    published = [target.reproduced() is True for target in found
                 if not targets.is_ours(target) and target.kind != "input"]
    return f"""For {len(published)} targets the thesis gives a number or states a result:
{sum(published)} of these are reproduced. The other {len(own)} are compared with limits of our own
("ours" in the column "published"), of which {sum(own)} are kept; the reasons are given in the
section "Our own limits". Errors are the worst of all seeds of the noise, over scans the worst of
all designs and directions of travel as well, on stones the worse of two trains with one seed each.
The size of the noise is relative to the root mean square of the acceleration. "Refused" means that
the chain gives no result for at least one seed."""


def part_setup(n):
    deck, alone, bed = (deck_of(name) for name in (DECK, stones.ALONE, stones.DECK))
    track, pad, ballast, car = deck["track"], deck["pad"], deck["ballast"], deck["vehicle"][0]
    zone, spacing = track["zone"][0], track["spacing"]
    pads = [pad["stiffness"], *scanned.PADS.values()]
    angles = ", ".join(f"{8e3 * depth / length:.0f}" for depth, length in JOINTS.values())
    rows = [("stiffness of a pad: nominal, 60E, UIC60, MN/m",
             ", ".join(f"{1e-6 * one:.0f}" for one in pads), "120, 60, 1200"),
            ("damping of a pad, kN s/m", f"{1e-3 * pad['damping']:g}", "25"),
            ("stiffness of the ballast, MN/m per m of rail",
             f"{1e-6 * ballast['stiffness'] / spacing:g} ({1e-6 * ballast['stiffness']:g} MN/m of "
             "one rail seat)", "30"),
            ("damping of the ballast, kN s/m per m of rail",
             f"{1e-3 * ballast['damping'] / spacing:g}", "125"),
            ("crossing rail: bending stiffness and mass over those of the rail",
             f"{zone['rail']:g}, on {zone['to'] - zone['from']:g} m", "3"),
            ("sleepers", f"masses of {track['sleeper_mass']:g} kg, {spacing:g} m apart",
             "Timoshenko beams"),
            ("length of the track, m", f"{track['length']:g}", "21.6, 37 sleepers"),
            ("vehicle", "coach of two bogies", "one bogie"),
            ("mass of a wheelset, kg", f"{car['wheelset_mass']:g}", "1340"),
            ("distance of the axles of a bogie, m", f"{car['wheelbase']:g}", "2.9"),
            ("static force of a wheel, kN", f"{n('vee_27.8_deck', 'static force'):.0f}",
             "76 (15.5 t of an axle)"),
            ("speed, m/s", f"{SPEED:g}", "50 in its example"),
            ("time step of the simulation, ms", f"{1e3 * deck['passage']['step']:g}", "")]
    return heading("Set-up") + f"""
{table(["", "here", "thesis"], rows)}
The running surface has dips of two parabolas with a kink between, unless it is scanned:
{joints()}, with angles of {angles} mrad. The sensor is on the sleeper at the kink. Its acceleration
is taken in every time step, low-passed and resampled to {1e-3 * RATE:g} kHz, before white noise is
added ({seeds(n)}).{sizes(n)} On stones the axles carry less, {stone_load(n)}, and the speed is
{bed["train"]["speed"]:g} m/s; the springs of the chain's track have
{1e-6 * alone["ballast"]["stiffness"]:g} MN/m of one rail seat.
"""


def joints():
    return ", ".join(f"{1e3 * depth:g} mm in {length:g} m" for depth, length in JOINTS.values())


def seeds(n):
    form = FORMS[n.about["command"].split()[-1]]
    return (f"{form['seeds']} seeds for displacement, trains and forces, {form['bed_seeds']} for "
            f"the stiffness of the ballast, 1 for voids and on stones")


def stone_load(n):
    run = stones.name_of("sound")
    if (run, "static force") not in n.rows:
        return "those of the Manchester benchmark"
    return f"{n(run, 'static force'):.1f} kN of a wheel"


def sizes(n):
    """What 0.1 % noise is, if the numbers have it."""
    found = [n(run, "rms of the acceleration")
             for run in ("known", *(f"joint_{name}" for name in JOINTS))
             if (run, "rms of the acceleration") in n.rows]
    if not found:
        return ""
    low, high = min(found), max(found)
    return (f" The root mean square of the acceleration of the whole record is {low:.3g} to "
            f"{high:.3g} m/s2, so that 0.1 % noise is {1e-3 * low:.2g} to {1e-3 * high:.2g} m/s2 "
            f"in a sample, or {1e3 * low / math.sqrt(RATE / 2):.0f} to "
            f"{1e3 * high / math.sqrt(RATE / 2):.0f} um/s2 per root Hz.")
