"""A track alone (model = "track", or on a ground): figures and a table of its results. Extremes are
those of every step if the run has them, otherwise those of the rows of its histories. Wheel forces
are those between the run-ins, where the track has its given properties.

Of several runs also a table and a picture of their envelopes beside each other (compare).
Pictures: track (wheel forces, rail and sleepers, seat loads, sleeper acceleration, as far as the
run has them), envelope (extremes along the track), third_octaves of a train, and for a run whose
only force is one impact receptance, also as CSV, of each point of the rail. The figures are
explained in docs/track.md.
"""
import json

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import (bed_histories, panels, passage_warnings, read, receptance_figure,
                           signals, stress_paths, third_octaves, track_along, track_measures,
                           track_stretch, track_transition, train_strip)
from trackbed_post.track_stretch import history, run_in_of, two_rails

FILTER = signals.LowPass()
SHOWN_AXLES = 4  # axles of the first rolling vehicle
SHOWN_PLACES = 3  # sleepers below the train
WIDEST = 3.5  # points, line of the first axle


def at_rest_before(run):
    """A run under forces on the rail begins at rest, one with wheels in static equilibrium."""
    return "history/wheel/force" not in run


def places(run, name):
    """Labels of places in x; with two rails each is listed twice, left before right."""
    x = run[name].values.ravel() if name in run else []
    twice = two_rails(run)
    return [f"{at:g} m" + ((", left", ", right")[i % 2] if twice else "") for i, at in enumerate(x)]


def loaded(run):
    """Datasets of a run of a track alone, by path."""
    run = read.datasets(run)
    if "history/energy/kinetic" in run and "history/wheel/force" in run:
        raise read.Unreadable("this is a train over a bed: use --kind train")
    if not any(name in run for name in ("history/wheel/force", "history/rail/force",
                                        "envelope/x")):
        raise read.Unreadable("this is not a run of a track alone: it has neither wheels nor "
                              "forces on the rail; use --kind bed")
    return run


def without_rail(run):
    """Datasets of a run with loaded seats, without those of the rail, which are zero."""
    return {name: one for name, one in run.items()
            if not name.startswith(("rail/", "history/rail/", "envelope/rail/", "extreme/rail/"))}


def on_track(run, length):
    """Whether each wheel is on the track, [time, wheel]."""
    x = history(run, "wheel/x")
    return (x >= 0) & (x <= length)


def between_run_ins(run, length, run_in):
    """Whether each wheel is between the run-ins, [time, wheel]."""
    x = history(run, "wheel/x")
    return (x >= run_in) & (x <= length - run_in)


def rolling(run):
    """Numbers of the rolling wheels: axles of constant force have no height and the program writes
    zeros. All wheels for older results without heights."""
    if "history/wheel/height" not in run:
        return list(range(history(run, "wheel/x").shape[1]))
    return list(np.flatnonzero(history(run, "wheel/height").any(axis=0)))


def extremes_of(folder):
    """Extremes over every step of the run, from its summary.json; empty without one."""
    path = folder / "summary.json" if folder.is_dir() else folder.parent / "summary.json"
    try:
        return json.loads(path.read_text(encoding="utf-8")).get("track", {})
    except (OSError, ValueError):
        return {}


def of_sleepers(run, what, end):
    """Least ("min") or largest ("max") value at each sleeper of the histories."""
    path, at = f"envelope/sleeper/{what}_{end}", run["sleepers/x"].values.ravel()
    if path in run:
        x = run["envelope/x"].values.ravel()
        place = np.searchsorted(x, at)
        place += np.arange(len(at)) % 2 if two_rails(run) else 0
        return run[path].values.ravel()[place]
    return getattr(history(run, f"sleeper/{what}"), end)(axis=0)  # results of an older version


def wheel_forces(run, length, run_in, extremes):
    """Results of wheels between the run-ins; empty if there were none."""
    force = history(run, "wheel/force")[between_run_ins(run, length, run_in)]
    if not len(force):
        return {}
    most = extremes.get("wheel_force_max_n", force.max())
    least = extremes.get("wheel_force_min_n", force.min())
    where = " between the run-ins" if run_in > 0 else ""
    return {f"largest wheel force{where}": (most / 1e3, "kN"),
            f"least wheel force{where}": (least / 1e3, "kN"),
            f"scatter of wheel forces{where}": (force.std() / 1e3, "kN")}


def largest_force(run, there):
    """(N, x in m) of the largest wheel force where wheels are `there`, [time, wheel], in the rows
    of the histories."""
    x, force = history(run, "wheel/x")[there], history(run, "wheel/force")[there]
    most = int(np.argmax(force))
    return float(force[most]), float(x[most])


def forces_over(run, over):
    """Results of wheels in a track_stretch.Stretch; empty if there were none."""
    there = over.holds(history(run, "wheel/x"))
    if not there.any():
        return {}
    force = history(run, "wheel/force")[there]
    most, x = largest_force(run, there)
    return {f"largest wheel force{over.words}": (most / 1e3, "kN"),
            f"x of the largest wheel force{over.words}": (x, "m"),
            f"least wheel force{over.words}": (force.min() / 1e3, "kN"),
            f"scatter of wheel forces{over.words}": (force.std() / 1e3, "kN")}


def wheel_numbers(run, length, run_in, extremes, over):
    if not on_track(run, length).any():
        raise read.Unreadable("no wheel was on the track while histories were written")
    between = wheel_forces(run, length, run_in, extremes)
    found = between
    if over:
        found = forces_over(run, over) | {
            name: value for name, value in between.items() if "scatter" not in name}
    wheels = rolling(run)
    if "history/wheel/height" in run and wheels:
        where = over or track_stretch.Stretch(run_in, length - run_in, (
            " between the run-ins" if run_in > 0 else ""))
        found |= track_measures.levels_of_rail(
            history(run, "wheel/x")[:, wheels[0]], history(run, "wheel/height")[:, wheels[0]],
            where.begin, where.end, where.words)
    return found


def numbers(run, length, extremes=None, run_in=0, over=None):
    """Name -> (value, unit). Wheels count only while they are on the track, their forces between
    its run-ins and `over` a track_stretch.Stretch. `extremes`: those of the summary."""
    extremes, found = extremes or {}, {}
    if "history/wheel/force" in run:
        found = wheel_numbers(run, length, run_in, extremes, over)
    time = run["history/time"].values
    if "history/rail/displacement" in run:
        lowest = extremes.get("rail_lowest_m", history(run, "rail/displacement").min(axis=0))
        if "extreme/rail/displacement" in run:
            lowest = run["extreme/rail/displacement"].values.ravel()
        for x, down in zip(places(run, "rail/x"), -np.asarray(lowest)):
            # + 0.0 avoids minus zero.
            found[f"rail at {x}, largest downward displacement"] = (1e3 * down + 0.0, "mm")
    if "sleepers/x" not in run:
        return found
    acceleration = FILTER(time, history(run, "sleeper/acceleration"), at_rest_before(run))
    lowest, most = of_sleepers(run, "displacement", "min"), of_sleepers(run, "seat_force", "max")
    for i, x in enumerate(places(run, "sleepers/x")):
        found[f"sleeper at {x}, largest downward displacement"] = (-1e3 * lowest[i], "mm")
        found[f"seat at {x}, largest load"] = (most[i] / 1e3, "kN")
        found[f"sleeper at {x}, acceleration, {FILTER.name_for(time)}"] = (
            np.abs(acceleration[:, i]).max(), "m/s2")
    return found


def draw_wheels(run, length, panel, deck):
    """The first axles are drawn wider, as others may have the same forces at the same places."""
    x, force = history(run, "wheel/x"), history(run, "wheel/force")
    shown = np.where(on_track(run, length), force / 1e3, np.nan)
    twice = two_rails(run)  # the wheels of an axle are then listed left before right
    drawn = (rolling(run) or range(shown.shape[1]))[:SHOWN_AXLES * (1 + twice)]
    widths = np.linspace(WIDEST, 0.8, len(drawn)) if len(drawn) > 1 else [0.8]
    for number, (i, width) in enumerate(zip(drawn, widths)):
        panel.plot(x[:, i], shown[:, i], lw=width, label=panels.axle(i, twice),
                   **panels.curve(number, np.isfinite(shown[:, i]).sum()))
    panel.set(xlabel=track_along.x_of("x of the wheel", deck), ylabel="wheel force, kN")
    if (axles_of_run := shown.shape[1] // (1 + twice)) > SHOWN_AXLES:
        panel.set_title(f"{len(drawn) // (1 + twice)} of {axles_of_run} axles", fontsize=9,
                        loc="right")


def receptances(run):
    """(Hz, {name: m/N complex}) of the points under the only force of the run; None if there are
    wheels or other forces."""
    if "history/wheel/force" in run or not {"history/rail/force",
                                            "history/rail/displacement"} <= set(run):
        return None
    if history(run, "rail/force").shape[1] != 1:
        return None
    time, force = run["history/time"].values, history(run, "rail/force")[:, 0]
    if signals.step_of(time) is None or force[-1] or not np.any(force):
        return None
    found = {}
    for x, up in zip(places(run, "rail/x"), history(run, "rail/displacement").T):
        frequency, found[x] = track_measures.receptance(time, force, -up)
    return frequency, found


def draw_forces(run, _, panel):
    for i, force in enumerate(history(run, "rail/force").T):
        panel.plot(run["history/time"].values, force / 1e3, lw=0.8, label=f"force {i + 1}",
                   **panels.curve(i, len(force)))
    panel.set(xlabel="time, s", ylabel="force on the rail, kN")


def draw_displacements(run, _, panel):
    time, number = run["history/time"].values, 0
    for what, name, style in (("rail", "rail/x", "-"), ("sleeper", "sleepers/x", "--")):
        if f"history/{what}/displacement" in run:
            for place, values in zip(places(run, name), history(run, f"{what}/displacement").T):
                panel.plot(time, 1e3 * values, style, lw=0.9, label=f"{what} at {place}",
                           **panels.curve(number, len(time)))
                number += 1
    panel.set(ylabel=f"displacement,\n{panels.UP}", xlabel="time, s")


def draw_seats(run, _, panel):
    for number, (place, force) in enumerate(zip(places(run, "sleepers/x"),
                                                history(run, "sleeper/seat_force").T)):
        panel.plot(run["history/time"].values, force / 1e3, lw=0.9, label=f"sleeper at {place}",
                   **panels.curve(number, len(force)))
    panel.set(ylabel="seat load, kN", xlabel="time, s")


def draw_acceleration(run, _, panel):
    time = run["history/time"].values
    filtered = FILTER(time, history(run, "sleeper/acceleration"), at_rest_before(run))
    for number, (place, values) in enumerate(zip(places(run, "sleepers/x"), filtered.T)):
        panel.plot(time, values, lw=0.8, label=f"sleeper at {place}",
                   **panels.curve(number, len(time)))
    panel.set(ylabel=f"acceleration, m/s2\n{FILTER.name_for(time)}", xlabel="time, s")


ENERGIES = {"track": "rail, sleepers and springs", "given_to_ground": "work on the ground",
            "ground_kinetic": "ground, kinetic", "ground_elastic": "ground, elastic",
            "ground_plastic": "ground, dissipated"}


def draw_energy(run, _, panel):
    for number, (name, label) in enumerate(ENERGIES.items()):
        if f"history/energy/{name}" in run:
            values = history(run, f"energy/{name}")
            panel.plot(run["history/time"].values, values, lw=0.9, label=label,
                       **panels.curve(number, len(values)))
    panel.set(ylabel="energy, J", xlabel="time, s")


def train_above(run, deck):
    """(Train, Places): the train above the first sleepers with histories, of two rails each once;
    None without a train or without sleepers."""
    if "history/wheel/x" not in run or "sleepers/x" not in run:
        return None
    train = train_strip.of_run(deck, run["history/time"].values, history(run, "wheel/x"))
    twice = 1 + two_rails(run)
    at = run["sleepers/x"].values.ravel()[::twice][:SHOWN_PLACES]
    found = [train_strip.Place(x, f"x = {x:g} m", f"C{twice * k}") for k, x in enumerate(at)]
    return (train, found) if train and any(train_strip.times_at(train, x).size for x in at) \
        else None


def draw_train_above(above, strip, panels):
    """The train in the panel `strip`, and its axles in the panels over time."""
    train_strip.draw(strip, *above)
    for panel in panels:
        panel.set_xlim(strip.get_xlim())
        for place in above[1]:
            train_strip.mark(panel, above[0], place)


def draw(run, length, deck):
    """A panel for each quantity of the run; None for a run without wheels, forces and points. The
    train is above those over time."""
    drawn = []
    if "history/wheel/force" in run:
        drawn.append(draw_wheels)
    elif "history/rail/force" in run:
        drawn.append(draw_forces)
    if {"history/rail/displacement", "history/sleeper/displacement"} & set(run):
        drawn.append(draw_displacements)
    if "sleepers/x" in run:
        drawn += [draw_seats, draw_acceleration]
    if not drawn:
        return None
    if "history/energy/track" in run:
        drawn.append(draw_energy)
    above = train_above(run, deck)
    heights = [2.0] * len(drawn)
    if above:
        heights.insert(1, train_strip.HEIGHT * len(above[1]))
    figure, grid = plt.subplots(len(heights), 1, figsize=(8, 2 + sum(heights)), squeeze=False,
                                layout="constrained", gridspec_kw={"height_ratios": heights})
    places = list(grid[:, 0])
    strip = places.pop(1) if above else None
    for draw_one, panel in zip(drawn, places):
        if draw_one is not draw_wheels:
            draw_one(run, length, panel)
        else:
            draw_wheels(run, length, panel, deck)
            track_along.shade_run_ins(panel, [deck])
            track_along.mark_ground(panel, deck, named=True)
        panel.grid(alpha=0.3)
        if panel.lines:
            panels.legend_above(panel, size=7)
    if above:
        draw_train_above(above, strip, places[1:])
    title = "; ".join(filter(None, (title_of(deck), track_stretch.state(run, deck))))
    figure.suptitle(panels.wrapped(title, 8, 11), fontsize=11)
    return figure


def title_of(deck):
    """What runs over what."""
    words = "Track on a ground" if deck.get("model") == "track_on_ground" else "Track without a bed"
    train = deck.get("train", {})
    names = ", ".join(train.get("vehicles", []))
    return f"{words}: {names}, {3.6 * train.get('speed', 0):.0f} km/h" if names else words


def draw_levels(run, over):
    """Third octaves of the wheel forces in a track_stretch.Stretch and of the sleepers; None
    without wheels."""
    if "history/wheel/force" not in run:
        return None
    time, between = run["history/time"].values, over.holds(history(run, "wheel/x"))
    wheels = rolling(run)
    force = history(run, "wheel/force")
    lines = [third_octaves.of("wheel force", "N", (
        f"root mean square over {len(wheels)} wheels{over.words}"),
                              [(time[on], values[on]) for on, values in
                               zip(between.T[wheels], force.T[wheels])])]
    sleeper = {name: read.Quantity(history(run, f"sleeper/{name}"), unit, "")
               for name, (_, unit) in third_octaves.OF_SLEEPERS.items()
               if f"history/sleeper/{name}" in run}
    lines += third_octaves.of_sleepers(time, sleeper, slice(None), (
        f"root mean square over the sleepers, mean over {np.ptp(time):.3g} s"))
    lines = [one for one in lines if one]
    return third_octaves.draw(lines, "Third octaves of wheel forces and sleepers") \
        if lines else None


def deck_of(run):
    """The effective input stored in the results."""
    return read.results(run).deck


def opened(folder):
    """Datasets of a run without points over which no axle has run, its deck, and the numbers of its
    table."""
    run, deck = loaded(folder), deck_of(folder)
    if deck.get("passage", {}).get("loaded_by") == "seats":
        run = without_rail(run)
    return track_stretch.without_unreached(run, {})[0], deck, numbers_of(folder, run, deck)


def numbers_of(folder, run, deck):
    """As `numbers`, and the part of their time on the track that wheels are off the rail: the one
    that the warning states."""
    extremes = extremes_of(folder)
    reached, of_points = track_stretch.without_unreached(run, extremes)
    over = track_stretch.counted(deck) if track_stretch.ground_of(deck) else None
    found = numbers(reached, deck["track"]["length"], of_points, run_in_of(deck), over)
    if off := passage_warnings.share_of_wheels(run, deck, {"track": extremes}):
        time = passage_warnings.counted(deck)
        found[f"wheels off the rail, part of the {time}"] = (100 * off, "%")
    return found


def below(results, names, notes):
    """What follows a table: notes, and the warnings of each run."""
    return "".join(f"{one}\n" for one in notes) + "".join(
        f"warning: {name}: {one}\n" for folder, name in zip(results, names)
        for one in passage_warnings.of_folder(folder))


def compare_into(results, folder):
    """Table and picture of several runs beside each other."""
    names, runs = track_along.names_of(results), [opened(one) for one in results]
    if picture := track_along.draw_beside(names, *([one[k] for one in runs] for k in (0, 1))):
        folder.picture("compare", picture)
    if len(results) == 2:
        track_transition.draw_into(results, folder)
    text = track_along.table_beside(names, [found for _, _, found in runs])
    notes = {tuple(track_stretch.notes(deck, found)) for _, deck, found in runs}
    folder.table("compare.txt", text + below(results, names,
                                             notes.pop() if len(notes) == 1 else ()))


def sentences(name, run, deck, found):
    """The largest wheel force in short, for a report."""
    over, state = track_stretch.counted(deck), track_stretch.state(run, deck)
    ends = f" ({state})." if state else "."
    if track_stretch.ground_of(deck) is None:
        return [f"{name}: {what}: {value:.4g} {unit}{ends}"
                for what, (value, unit) in found.items() if "largest wheel force" in what]
    if f"largest wheel force{over.words}" not in found:
        return []
    most, x = (found[f"{of}argest wheel force{over.words}"][0] for of in ("l", "x of the l"))
    text = f"{name}: largest wheel force{over.words}: {most:.4g} kN, at x = {x:.2f} m"
    between = track_stretch.between_run_ins(deck)
    beside, there = largest_force(run, between.holds(history(run, "wheel/x")))
    if beside > 1e3 * most:
        largest = found.get(f"largest wheel force{between.words}", (beside / 1e3,))[0]
        text += f"; beside it a larger one{between.words}: {largest:.4g} kN, near x = " \
            f"{there:.2f} m"
    return [f"{text} from the start of the track{ends}"]


def sensors_in_ground(folder, deck):
    """Name and figure of the motion of sensors in the ground, and of stress paths there."""
    ground = track_stretch.ground_of(deck)
    if ground is None or "sensor" not in deck:
        return
    run = read.results(folder)
    if run.sensors:
        yield "sensors", bed_histories.sensors([run], ground.origin)
    if stress_paths.of_ground(run):
        yield "stress_paths", stress_paths.draw([run])


def draw_into(results, folder):
    """Pictures and table of one run; `results`: its folder, in a list."""
    run, deck, found = opened(results[0])
    if histories := draw(run, deck["track"]["length"], deck):
        folder.picture("track", histories)
    if along := track_along.draw_envelope(run, deck):
        folder.picture("envelope", along)
    if levels := draw_levels(run, track_stretch.counted(deck)):
        folder.picture("third_octaves", levels)
    if of_points := receptances(run):
        folder.picture("receptance", receptance_figure.draw(*of_points))
        folder.file("receptance.csv", receptance_figure.table(*of_points))
    for name, figure in sensors_in_ground(results[0], deck):
        folder.picture(name, figure)
    track_transition.draw_into(results, folder)
    wide = max(map(len, found), default=0)
    text = "".join(f"{name:{wide}} {value:10.4g} {unit}\n" for name, (value, unit) in found.items())
    name = results[0].resolve().name
    folder.sentences += sentences(name, run, deck, found)
    folder.table("track.txt", text + below(results, [name], track_stretch.notes(deck, found)))
