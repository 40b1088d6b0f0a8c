"""What a reader of the figures of a train must know: wheels that were off the rail, and rail pads
in tension, which no fastening carries. Each is stated once, with its worst place. Runs with one of
them have no verdict: their forces are those of impacts, or of fastenings that do not exist. Of a
track without stones also which part of it the train has not passed."""
import collections.abc
import typing

import numpy as np

from trackbed_post import axles, bed_warnings, ground_blocks, ground_ends, read, track_stretch
from trackbed_post.bed_warnings import BedWarning

# A rail on equal springs lifts by exp(-pi) = 4 % of its largest deflection ahead of a wheel, and
# between two wheels by up to twice as much; pads that pull more have another cause.
PULLS = 0.1  # of the load of a seat below a wheel


def warnings_of_bed(run: read.Results) -> list[BedWarning]:
    """Of the last train over a bed."""
    if not (run.has_passage() and ground_blocks.carried_by_springs(run) and len(run.sleepers_x)):
        return []
    return [*(BedWarning("a wheel is off the rail", one) for one in _of_wheels_over_bed(run)),
            *(BedWarning("rail pads are in tension", one) for one in _of_pads_on_bed(run))]


def of_bed(run: read.Results) -> list[str]:
    """The same as sentences without the name of the run."""
    return [one.sentence for one in warnings_of_bed(run)]


def why_no_verdict(named: collections.abc.Iterable[tuple[str, read.Results]]) -> str:
    """The causes in bed and passage of runs with their names, each once, for a sentence; empty if
    there are none."""
    return bed_warnings.causes((name, [*bed_warnings.warnings_of(run), *warnings_of_bed(run)])
                               for name, run in named)


def warnings_of_track(every: read.Quantities, deck: read.Deck,
                      summary: dict[str, typing.Any]) -> list[BedWarning]:
    """Of a track without stones: datasets, deck and summary.json (empty before the run's end)."""
    if "history/wheel/force" not in every or not every["history/time"].values.size:
        return []
    found = (("the train has not passed the whole ground", track_stretch.warnings_of(every, deck)),
             ("wheels are off the rail", _of_wheels_on_track(every, deck, summary)),
             ("rail pads are in tension", _of_pads_of_track(every, deck)))
    return [BedWarning(cause, one) for cause, sentences in found for one in sentences]


def of_track(every: read.Quantities, deck: read.Deck,
             summary: dict[str, typing.Any]) -> list[str]:
    """The same as sentences, and the springs beside a ground."""
    return [*(one.sentence for one in warnings_of_track(every, deck, summary)),
            *ground_ends.warnings_of(every, deck)]


def of_folder(folder: typing.Any) -> list[str]:
    """Of any run; none of a run without a train, or before it has histories."""
    try:
        run = read.results(folder)
        if run.deck.get("model") in ("track", "track_on_ground"):
            return of_track(read.datasets(folder), run.deck, read.summary(folder))
        return of_bed(run)
    except read.Unreadable:
        return []


def _of_wheels_over_bed(run: read.Results) -> list[str]:
    if not {"x", "force"} <= run.wheel.keys():
        return []
    rows = run.passage()
    x, force = (run.wheel[name].values[rows] for name in ("x", "force"))
    if not (trains := axles.rows_of_trains(x)):
        return []
    x, force = x[trains[-1]], force[trains[-1]]
    there = (x >= run.sleepers_x[0]) & (x <= run.sleepers_x[-1])
    share = axles.time_off(there, force)
    if not share:
        return []
    return [f"a wheel is off the rail in {_percent(share)} % of the rows of the histories with "
            f"a wheel over the bed, {_stretch(x[there & (force == 0)])}: {MEANT}"]


MEANT = ("wheel forces there are those of impacts; if no dip, joint or flat is meant to lift "
         "wheels, check irregularity, speed and passage.step")


def _percent(share: float) -> str:
    return f"{100 * share:.0f}" if share >= 0.1 else f"{100 * share:.2g}"


def _stretch(x: np.ndarray) -> str:
    return f"at x = {x.min():.2f} m" + (f" to {x.max():.2f} m" if np.ptp(x) > 0.01 else "")


def _of_wheels_on_track(every: read.Quantities, deck: read.Deck,
                        summary: dict[str, typing.Any]) -> list[str]:
    x, force = (_columns(every[f"history/wheel/{name}"]) for name in ("x", "force"))
    there = (x >= 0) & (x <= deck["track"]["length"])
    off = there & (force == 0)
    share = share_of_wheels(every, deck, summary)
    if not share:
        return []
    where = _stretch(x[off]) if off.any() else "between the rows of the histories"
    return [f"wheels are off the rail in {_percent(share)} % of the {counted(deck)}; {where}; "
            f"{MEANT}"]


def counted(deck: read.Deck) -> str:
    """Of which time `share_of_wheels` is a part, in words."""
    track = deck["track"]
    run_ins = track.get("support") != "none" and track.get("run_in", 0) > 0
    return "time of all wheels on the track" + (", run-ins included" if run_ins else "")


def share_of_wheels(every: read.Quantities, deck: read.Deck,
                    summary: dict[str, typing.Any]) -> float:
    """Part of their time on the track that wheels are off the rail, as the warning of the program
    counts it: of all steps if summary.json states their number, otherwise of the rows."""
    if "history/wheel/force" not in every:
        return 0.0
    x, force = (_columns(every[f"history/wheel/{name}"]) for name in ("x", "force"))
    there = (x >= 0) & (x <= deck["track"]["length"])
    count = np.count_nonzero(there)
    if not count:
        return 0.0
    steps = summary.get("track", {}).get("wheel_steps_off_rail")
    step = deck.get("passage", {}).get("step", 0)
    time = every["history/time"].values.ravel()
    if steps is None or not step or len(time) < 2:
        return float(np.count_nonzero(there & (force == 0)) / count)
    return float(steps * step / (count * np.median(np.diff(time))))


def _columns(item: read.Quantity) -> np.ndarray:
    return item.values.reshape(len(item.values), -1)


def _of_pads_on_bed(run: read.Results) -> list[str]:
    """The load of a seat contains the weight of rails and fastenings, seat_force of the stage."""
    rows = run.passage()
    weight = run.deck["stage"][int(run.stage[rows][0])].get("seat_force", 0.0)
    if "force" in run.seat:  # two rails, left before right
        load = run.seat["force"].values[rows] + weight / 2
        x = np.repeat(run.sleepers_x, 2)
        inner = np.repeat(~ground_blocks.ends(run), 2)
    elif "seat_force" in run.sleeper:
        load, x = -run.sleeper["seat_force"].values[rows], run.sleepers_x
        inner = ~ground_blocks.ends(run)
    else:
        return []
    known = np.isfinite(load).all(axis=1)
    if not known.any() or load.shape[1] != len(x):
        return []
    if "x" in run.wheel:
        inner = inner & axles.reached(run.wheel["x"].values[rows], x)
    load = load[known][:, inner]
    return _of_pads(x[inner], load.min(axis=0), load.max(axis=0),
                    "check irregularity and speed; if these are as meant, "
                    f"{bed_warnings.remedies(run)}")


def _of_pads_of_track(every: read.Quantities, deck: read.Deck) -> list[str]:
    """Without the weight of the rail, which this model does not have, and without seats at the
    ends of a ground: the sleeper on springs does not go down with the ground beside it, so that the
    rail pulls the next sleeper up; ground_ends compares the stiffness of both."""
    names = [f"envelope/sleeper/seat_force_{end}" for end in ("min", "max")]
    if deck.get("pad", {}).get("uplift") or not {"envelope/x", *names} <= every.keys():
        return []
    x = every["envelope/x"].values.ravel()
    there = track_stretch.between_run_ins(deck).holds(x) & axles.reached(
        track_stretch.history(every, "wheel/x"), x)
    left_out = ""
    if ground := track_stretch.ground_of(deck):
        there &= np.array([not ground.at_end(one) for one in x])
        left_out = " (those at the ends of the ground are left out)"
    least, most = (every[name].values.ravel()[there] for name in names)
    return _of_pads(x[there], least, most, _remedy(deck), left_out)


def _remedy(deck: read.Deck) -> str:
    remedy = "set pad.uplift = true with the clamping force as pad.preload" \
        if deck.get("model") == "track" else "look for sleepers without support there"
    return f"{remedy}, or check irregularity and speed"


def _of_pads(x: np.ndarray, least: np.ndarray, most: np.ndarray,
             remedy: str, left_out: str = "") -> list[str]:
    """Of the least and largest load of each seat over which a wheel has run, N, down; `left_out`:
    which other seats there are."""
    if not len(x):
        return []
    usual = float(np.median(most))
    pulls = least < -PULLS * usual
    if usual <= 0 or not pulls.any():
        return []
    k = int(np.argmin(least))
    return [f"rail pads are in tension at {np.count_nonzero(pulls)} of {len(x)} "
            f"seats{left_out}, most at x = {x[k]:.2f} m by {-1e-3 * least[k]:.1f} kN, "
            f"{-least[k] / usual:.1%} of the load of a seat below a wheel, {1e-3 * usual:.1f} kN "
            f"(limit {PULLS:.0%}): pads of the model transmit tension, fastenings only up to their "
            f"clamping force, so that rail and sleepers would move apart; {remedy}"]
