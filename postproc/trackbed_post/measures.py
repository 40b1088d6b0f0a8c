"""Measures of the results of a run: sleepers, regions, stresses, grading, breakage, energies.

Those of a transition zone are in ground_transition.py and transition.py.
"""
import collections.abc
import dataclasses
import typing

import numpy as np
from numpy.typing import ArrayLike

from trackbed_post import axles, ground_blocks, progress, read

LASTING = 1e-3   # m, a larger residual displacement of a sleeper means that stones have moved
STANDS = 1e-4    # m between two rows of the histories, below which a train stands
TINY = ground_blocks.TINY
NOWHERE = float("nan")


def spacing(results: read.Results) -> float:
    """Spacing of the sleepers, m."""
    return float(np.median(np.diff(results.sleepers_x))) if len(results.sleepers_x) > 1 else 0.6


def sleepers_of_track(track: read.Deck, usual: float) -> np.ndarray:
    """x of the sleepers of a track from its begin, m; zones may have a spacing of their own."""
    length = track.get("length", 0)
    own = sorted((zone["from"], zone["to"], zone["spacing"]) for zone in track.get("zone", [])
                 if zone.get("spacing", 0) > 0)
    parts, end = [], 0.0
    for begin, to, spacing in [*own, (length, length, 0)]:
        if begin > end + TINY:
            parts.append((end, begin, usual))
        if to > begin:
            parts.append((begin, to, spacing))
        end = to
    places = [np.linspace(begin, to, round((to - begin) / spacing) + 1)[1:]
              for begin, to, spacing in parts]
    return np.concatenate([[0.0], *places])


def smoothed(x: np.ndarray, values: np.ndarray, width: float) -> np.ndarray:
    """Mean of the values within +-width/2 of each x, as stones load single nodes."""
    return np.array([np.mean(values[np.abs(x - place) <= width / 2 + TINY]) for place in x])


def means_over(x: np.ndarray, values: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """(middles, means) of the values over each `width`, m, that ends or begins at a node, which
    belongs to none: those of table.txt beside the edge of a structure are among them. x rises. What
    extends beyond the ends is left out, unless there is nothing else."""
    parts = {(0, len(x))} if np.ptp(x) < width - TINY else {
        (int(np.searchsorted(x, low)), int(np.searchsorted(x, high)))
        for at in x for low, high in ((at - width - TINY, at - TINY),
                                      (at + TINY, at + width + TINY))
        if low >= x[0] - 2 * TINY and high <= x[-1] + 2 * TINY}
    found = sorted((float(np.mean(x[one])), float(np.mean(values[one])))
                   for one in (slice(*part) for part in parts) if len(x[one]))
    return np.array([middle for middle, _ in found]), np.array([mean for _, mean in found])


def has_ground(results: read.Results) -> bool:
    """Whether the bed is on a ground; otherwise it is on a rigid floor."""
    return bool(results.deck.get("ground", {}).get("present", len(results.ground_x) > 0))


def train_has_left(results: read.Results) -> bool:
    """Whether all axles have passed the last sleeper: those on a rail by the histories of their
    wheels, those of [load] by their speed. True without a stage of kind passage, and where it is
    not known: of loads from a table, and of several trains without a rail."""
    if not results.asks_for_passage() or not len(results.sleepers_x):
        return True
    if not results.has_passage():
        return False
    rows, end = results.passage(), results.sleepers_x[-1]
    if ground_blocks.carried_by_springs(results):
        if "x" not in results.wheel:
            return True
        x = axles.of_wheels(results.wheel["x"].values[rows])
        trains = axles.rows_of_trains(x)
        return bool(trains) and axles.have_passed(x[trains[-1][0]:], end)
    x = axles_of_load(results, int(results.stage[rows][0]), results.time[rows][-1:])
    return not x.size or bool(x.min() >= end)


def axles_of_load(results: read.Results, number: int, time: np.ndarray) -> np.ndarray:
    """x of the axles of [load] in a stage, which is counted from 0, at times in s, [time, axle];
    none where it is not known: of loads from a table, and of several trains."""
    load, stage = results.deck.get("load", {}), results.deck["stage"][number]
    rows = np.flatnonzero(results.stage == number)
    if stage.get("kind") != "passage" or stage.get("train") or stage.get("cycles", 0) > 1 \
            or load.get("kind") in ("table", "seats") or not load.get("axles") or not len(rows):
        return np.empty((len(time), 0))
    first = load.get("start", 0.0) + load["speed"] * (time - results.time[rows[0]])
    return first[:, None] - np.asarray(load["axles"])


def train_stands(results: read.Results) -> bool:
    """Whether the train of the passage has come to its end, speed 0, and stands in the last row."""
    speeds = results.deck.get("train", {}).get("speeds", [])
    if not (speeds and speeds[-1] == 0 and results.has_passage() and "x" in results.wheel
            and ground_blocks.carried_by_springs(results)):
        return False
    x = results.wheel["x"].values[results.passage()][-2:]
    moved = np.abs(np.diff(x, axis=0))
    return bool(moved.size and np.nanmax(moved, initial=0.0) < STANDS)


def stage_shown(run: read.Results) -> str:
    """Name of the stage of the rows of `passage`."""
    return str(run.deck["stage"][int(run.stage[run.passage()][0])].get("name", ""))


def several_passages(run: read.Results) -> bool:
    """Whether the deck has several stages of kind passage, so that the shown one must be named."""
    return [stage.get("kind") for stage in run.deck.get("stage", [])].count("passage") > 1


def passage_words(runs: collections.abc.Sequence[read.Results]) -> str:
    """What the rows of `passage` of these runs are, in titles, with the name of the stage if it is
    not the only passage."""
    names = ", ".join(dict.fromkeys(map(stage_shown, runs)))
    if not all(run.has_passage() for run in runs):
        return f"last stage ({names})"
    words = f"passage (stage {names})" if any(map(several_passages, runs)) else "passage"
    unfinished = [run.name for run in runs if not train_has_left(run)]
    if len(unfinished) == len(runs):
        return f"unfinished {words}"
    return f"{words}, unfinished in {', '.join(unfinished)}" if unfinished else words


def why_not_beside(runs: collections.abc.Sequence[read.Results]) -> str:
    """Why rows of `passage` of these runs cannot be drawn beside each other, as some are those of
    an earlier stage; empty if they can."""
    if len({run.has_passage() for run in runs}) == 1:
        return ""
    return "; ".join(f"{run.name} contains no passage: {_why_no_passage(run)}"
                     for run in runs if not run.has_passage())


def row_before_train(results: read.Results) -> int:
    """The row of the passage before the train comes to the bed, counted from its first one: 0
    without a train on a rail, whose pads have their forces from the first row on."""
    rows = results.passage()
    if "x" not in results.wheel or not len(results.sleepers_x):
        return 0
    x = axles.of_wheels(results.wheel["x"].values[rows])
    trains = axles.rows_of_trains(x)
    if not trains:
        return 0
    first = trains[0]
    return int(first[axles.row_before_train(x[first, 0], results.sleepers_x[0])])


def largest_sleeper_displacement(results: read.Results) -> float:
    """Largest downward displacement of a sleeper that is not at the ends of the bed, m, since the
    passage began; not known (NOWHERE) without envelopes."""
    if "displacement_min" not in results.sleeper_envelope:
        return NOWHERE
    lowest = results.sleeper_envelope["displacement_min"].values.ravel()
    return float(-lowest[~ground_blocks.ends(results)].min(initial=np.inf))


def residual_displacement(results: read.Results) -> np.ndarray:
    """Residual downward displacement of each sleeper, m: from the row of the passage before the
    train to its last one."""
    if "displacement" not in results.sleeper:
        return np.empty(0)
    height = results.sleeper["displacement"].values[results.passage()]
    return height[row_before_train(results)] - height[-1]


def _why_no_passage(results: read.Results) -> str:
    if not results.asks_for_passage():
        return "the deck has no stage of kind passage"
    if results.folder is None:
        return "the run was stopped before it"
    return progress.before_stage(results.folder, results.passage_stage()[0])


def why_no_envelope(results: read.Results) -> str:
    """Why a run has no envelope of the ground in its passage; empty if it has one."""
    if not results.has_passage():
        return f"{results.name} contains no passage: {_why_no_passage(results)}"
    if {"displacement_min", "sigma_z_min"} <= results.ground_envelope.keys():
        return ""
    if not has_ground(results):
        return f"{results.name} has no ground"
    if not train_has_left(results):
        return f"{results.name} has no envelopes yet, as its passage has not ended"
    return f"{results.name} has no history of the ground"


def loading_frequencies(results: read.Results) -> dict[str, float]:
    """{name: Hz}: speed over distance of bogie centres and over wheelbase, from [load]; empty if
    the passage was that of a train on a rail."""
    if ground_blocks.carried_by_springs(results):
        return {}
    load = results.deck.get("load", {})
    axles, speed = np.asarray(load.get("axles", [])), load.get("speed", 0.0)
    found = {}
    if len(axles) >= 4:
        found["v/L_c"] = speed / (np.mean(axles[2:4]) - np.mean(axles[:2]))
    if len(axles) >= 2:
        found["v/L_w"] = speed / (axles[1] - axles[0])
    return found


def ground_lowered(results: read.Results) -> np.ndarray:
    """Downward displacement of the ground's top below each sleeper since the passage began, m,
    [time, sleeper]; one row of zeros on a rigid floor."""
    if "displacement" not in results.ground or not len(results.ground_x):
        return np.zeros((1, len(results.sleepers_x)))
    height = results.ground["displacement"].values[results.passage()]
    return np.stack([np.interp(results.sleepers_x, results.ground_x, row)
                     for row in height[0] - height])


def residual_ground(results: read.Results) -> np.ndarray:
    """Residual downward displacement of the ground's top below each sleeper, m."""
    lowered = ground_lowered(results)
    return lowered[-1] - lowered[min(row_before_train(results), len(lowered) - 1)]


def warnings(results: read.Results) -> list[str]:
    """A message on residual displacement of the ground after the passage, and one per sleeper with
    residual displacement relative to the ground; none before the train has left."""
    kept = residual_displacement(results)
    if not len(kept) or not train_has_left(results):
        return []
    sunk = residual_ground(results)
    beside = " relative to the ground" if has_ground(results) else ""
    lines = []
    most = sunk[np.argmax(np.abs(sunk))]
    if abs(most) > LASTING:
        lines.append(
            f"warning: {results.name}: the ground has a residual displacement of "
            f"{1e3 * abs(most):.2f} mm "
            f"{'downwards' if most > 0 else 'upwards'} (limit {1e3 * LASTING:.0f} mm): it was "
            "not at rest at the end, layers have yielded, or its base does not carry a permanent "
            "load")
    return lines + [
        f"warning: {results.name}: the sleeper at x = {x:.2f} m has a residual displacement of "
        f"{1e3 * abs(left):.2f} mm {'downwards' if left > 0 else 'upwards'}{beside} "
        f"(limit {1e3 * LASTING:.0f} mm): stones were rearranged"
        for x, left in zip(results.sleepers_x, kept - sunk) if abs(left) > LASTING]


REGION_ROWS = (("void ratio", "-"), ("bulk density", "kg/m3"), ("coordination number", "-"),
               ("mean contact force", "N"), ("compression xx", "kPa"), ("compression yy", "kPa"),
               ("compression zz", "kPa"), ("fabric zz", "-"))


def region_numbers(region: read.Quantities, row: int, plane: bool = False) -> list[float]:
    """REGION_ROWS of one region at one row of the histories; mean over its cells, weighted by the
    number of stones or contacts of each."""
    def weighted(quantity: str, weight: str) -> typing.Any:
        values, counts = region[quantity].values[row], region[weight].values[row]
        total = counts.sum()
        return (counts @ values) / total if total else 0 * values[0]
    solid = 1 - region["porosity"].values[row].mean()
    stress = -region["stress"].values[row].mean(axis=0) / 1e3
    if plane:
        stress[1] = NOWHERE  # it is not computed
    return [(1 - solid) / solid if solid else NOWHERE, region["bulk_density"].values[row].mean(),
            weighted("coordination", "stones"), weighted("contact_force", "contacts"),
            *stress[:3], weighted("fabric", "contacts")[2]]


def region_table(run: read.Results) -> str:
    """Text: quantities in the deck's regions at the end of each stage; empty without regions."""
    if not run.regions:
        return ""
    ends = np.append(np.flatnonzero(np.diff(run.stage)), len(run.stage) - 1)
    names = [stage["name"] for stage in run.deck["stage"]]
    lines = ["", f"regions of {run.name} at the end of stages"]
    for name, region in run.regions.items():
        lines.append(f"{name:<32}" + "".join(f"{names[run.stage[end]]:>12}" for end in ends))
        plane = run.deck.get("dimension", "plane") == "plane"
        columns = [region_numbers(region, end, plane) for end in ends]
        for number, (label, unit) in enumerate(REGION_ROWS):
            lines.append(f"  {label:<22}{unit:>8}"
                         + "".join(f"{value:12.4g}" if np.isfinite(value := column[number])
                                   else f"{'-':>12}" for column in columns))
    return "\n".join(lines) + "\n"


def invariants(stress: ArrayLike, plane: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Mean and deviatoric stress, Pa, of rows xx yy zz xy xz yz with tension positive. In space
    p = (s1 + s2 + s3)/3 and q = sqrt(3 J2), compression positive; in a plane, where sigma_yy is not
    computed, s = (s1 + s3)/2 and t = (s1 - s3)/2."""
    xx, yy, zz, xy, xz, yz = np.moveaxis(-np.asarray(stress), -1, 0)
    if plane:
        return (xx + zz) / 2, np.hypot((xx - zz) / 2, xz)
    mean = (xx + yy + zz) / 3
    second = ((xx - mean)**2 + (yy - mean)**2 + (zz - mean)**2) / 2 + xy**2 + xz**2 + yz**2
    return mean, np.sqrt(3 * second)


def principal_direction(stress: ArrayLike) -> np.ndarray:
    """Angle, rad, between the vertical and the direction of largest compression in the plane of x
    and z; positive: its upper end leans towards +x. Rows as of `invariants`."""
    compression = -np.asarray(stress)
    xx, zz, xz = (compression[..., k] for k in (0, 2, 4))
    return np.arctan2(2 * xz, zz - xx) / 2


def chosen_sleepers(run: read.Results) -> list[int]:
    """Three sleepers to show: first, nearest to the structure's edge (or the middle one), last of
    those that are not at the ends of the bed; the middle one also if one of these is nearest."""
    edge = ground_blocks.edge_of_structure(run)
    inner = np.flatnonzero(~ground_blocks.ends(run))
    x, middle = run.sleepers_x[inner], len(inner) // 2
    near = middle if edge is None else int(np.argmin(np.abs(x - edge)))
    shown = {0, near, len(inner) - 1}
    return [int(inner[k]) for k in sorted(shown if len(shown) == 3 else shown | {middle})]


NUMBERS = {ground_blocks.WALLS: "one", ground_blocks.ENDS: "three"}


def without_ends(*runs: read.Results) -> str:
    """How many sleepers are left out, for legends; empty if none are. If this is not the same in
    all runs, with their names."""
    words = [left_out(ground_blocks.ends(run)) for run in runs]
    if len(set(words)) == 1:
        return words[0]
    return "; ".join(f"{run.name}: {one or 'all sleepers'}" for run, one in zip(runs, words))


def left_out(ends: np.ndarray) -> str:
    """The same of a bed by which of its sleepers are at the ends."""
    count = int(np.count_nonzero(ends)) // 2
    return f"without the {NUMBERS[count]} at each end of the bed" if count else ""


def passing(sieved: np.ndarray, openings: ArrayLike) -> np.ndarray:
    """Percentage of the mass of stones (rows of opening and mass) passing each opening, m."""
    below = sieved[:, 0, None] <= np.asarray(openings) * (1 + TINY)
    return 100 * sieved[:, 1] @ below / sieved[:, 1].sum()


def force_distribution(force: np.ndarray, bins: int = 24,
                       largest: float = 8) -> tuple[np.ndarray, np.ndarray]:
    """Centres of bins of force over mean force up to `largest`, and the probability density."""
    relative = force / force.mean()
    density, edges = np.histogram(relative, bins=bins, range=(0, largest))
    width = edges[1] - edges[0]
    return (edges[1:] + edges[:-1]) / 2, density / (len(relative) * width)


FINEST = 2.36e-3  # m, smallest sieve of the ballast breakage index


def breakage_index(openings: ArrayLike, before: ArrayLike, after: ArrayLike) -> float:
    """Ballast breakage index of two sieve curves (openings in m, passing in %): the area between
    them, divided by that between the first one and the straight line from 2.36 mm, 0 % to d95,
    95 %. Both reach from 2.36 mm to d95, the opening that 95 % of the first curve pass, on a linear
    axis (Indraratna, Lackenby, Christie 2005, doi:10.1680/geot.2005.55.4.325)."""
    openings, before, after = (np.asarray(of, dtype=float) for of in (openings, before, after))
    d95 = np.interp(95, before, openings)
    inside = openings[(openings > FINEST) & (openings < d95)]
    at = np.concatenate([[FINEST], inside, [d95]])
    first, second = (np.interp(at, openings, curve, left=0) for curve in (before, after))
    line = 95 * (at - FINEST) / (d95 - FINEST)
    return np.trapz(second - first, at) / np.trapz(line - first, at)


def sieved_with_fines(run: read.Results, stage: str) -> np.ndarray:
    """Rows of opening (m) and mass (kg) of stones and fragments at the end of a stage, and of the
    fines, whose opening is their diameter, that of dust the finest sieve."""
    breaks = run.breaks.get(stage)
    rows = run.stones[stage].sieved
    if breaks is None or not len(breaks):
        return rows
    fines = breaks[breaks[:, read.BREAK["fragment"]] < 0]
    sizes = np.where(fines[:, read.BREAK["kind"]] == read.DUST, FINEST,
                     fines[:, read.BREAK["diameter"]])
    return np.concatenate([rows, np.column_stack([sizes, fines[:, read.BREAK["mass"]]])])


def parts_broken(run: read.Results, stage: str) -> np.ndarray:
    """Rows of BREAK without dust, which wear takes off a little at a time."""
    rows = run.breaks[stage]
    return rows[rows[:, read.BREAK["kind"]] != read.DUST]


def breaks_by_sleeper(run: read.Results,
                      stage: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each sleeper: parts that broke off within half a sleeper spacing, those below it
    (between its sides), and those below it that are nearer to an edge than to its middle. Fragments
    and fines of an event are counted separately."""
    rows, sleepers = parts_broken(run, stage), run.deck["sleepers"]
    x = rows[:, read.BREAK["x"]]
    centres = sleepers["first"] + sleepers["spacing"] * np.arange(sleepers["count"])
    off = np.abs(x[:, None] - centres)
    below = off <= sleepers["width"] / 2
    near = off <= sleepers["spacing"] / 2
    return near.sum(axis=0), below.sum(axis=0), (below & (off > sleepers["width"] / 4)).sum(axis=0)


def stages_of_breakage(run: read.Results) -> tuple[str, str] | None:
    """The last stage before the first part breaks off, and the last stage; None without any."""
    names = list(run.breaks)
    broken = [name for name in names if len(parts_broken(run, name))]
    if not broken:
        return None
    return names[max(names.index(broken[0]) - 1, 0)], names[-1]


@dataclasses.dataclass
class EnergySplit:
    """Energies in J since the last stage began: supplied by surfaces, stored (kinetic, potential
    and elastic), dissipated by cause, and what is missing of the balance."""
    time: np.ndarray
    supplied: np.ndarray
    stored: np.ndarray
    dissipated: dict[str, np.ndarray]

    @property
    def missing(self) -> np.ndarray:
        return self.supplied - self.stored - sum(self.dissipated.values())


def has_balance(run: read.Results) -> bool:
    return "friction" in run.energy and "supplied" in run.energy


DISSIPATED = {"friction": "friction", "contact_damping": "dashpots",
              "local_damping": "local damping", "breakage": "breakage"}  # history: cause


def energy_split(run: read.Results) -> EnergySplit:
    rows = run.stage == run.stage[-1]

    def since(name: str) -> np.ndarray:
        values = run.energy[name].values[rows].ravel()
        return values - values[0]
    dissipated = {name: since(name) for name in DISSIPATED}
    stored = since("kinetic") + since("potential") + since("elastic")
    return EnergySplit(run.time[rows] - run.time[rows][0], since("supplied"), stored, dissipated)
