"""The command `settlement`: tables and a figure of one run or several, and a forecast."""
import csv
import dataclasses
import io

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import figure_csv, read
from trackbed_post.settlement import course, laws, traffic

POINTS = 200  # of a curve
FEWEST = 5    # cycles to which laws are fitted
VIBRATES = 0.1  # of the settlement, by which the ground may rise between the rows of a fit


@dataclasses.dataclass(frozen=True)
class Forecast:
    """The traffic over which settlements are extrapolated, for some days. A cycle of the run
    represents `axles` axles of `axle_load` t; `power`: see Traffic.axles_per_day."""
    traffic: traffic.Traffic
    days: float
    axles: float
    axle_load: float | None = None
    power: float | None = None

    def cycles_per_day(self):
        return self.traffic.axles_per_day(self.axle_load, self.power) / self.axles

    def megatonnes(self):
        return 1e-6 * self.days * self.traffic.tonnes_per_day()


def rows_as_csv(head, rows):
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(
        [head, *([f"{value:.9g}" if isinstance(value, float) else value for value in row]
                 for row in rows)])
    return text.getvalue()


def course_as_csv(found, deck):
    names = [stage["name"] for stage in deck["stage"]]
    head = ["cycles", "stage", "time_s", "mean_mm",
            *(f"sleeper_{i}_mm" for i in range(found.settled.shape[1]))]
    return rows_as_csv(head, [
        (int(count), names[stage], float(time), float(1e3 * settled.mean()),
         *(float(1e3 * one) for one in settled))
        for count, stage, time, settled in zip(found.cycles, found.stage, found.time,
                                               found.settled)])


def axles_as_csv(trains):
    """The mean over the sleepers below, since single ones may be far from all wheels."""
    rows = []
    for number, lowest in trains:
        for axle, under in enumerate(lowest):
            known = np.isfinite(under)
            if known.any():
                rows.append((number, axle + 1, float(-1e3 * under[known].mean()),
                             float(-1e3 * under[known].min()),
                             float(1e3 * (lowest[0] - under)[known].mean())))
    return rows_as_csv(("train", "axle", "mean_mm", "largest_mm", "more_than_first_axle_mm"), rows)


def used(found, begin):
    """Rows to which laws are fitted: those of computed cycles from `begin` on."""
    return (found.cycles >= begin) & ~found.jump


def why_no_laws(found, begin):
    """Why no laws are fitted; empty if they are."""
    use = used(found, begin)
    if use.sum() < FEWEST:
        return (f"fewer than {FEWEST} computed cycles from cycle {begin:g} on, too few to fit laws "
                "of settlement")
    rises, settles = found.ground_rises(use), np.ptp(found.mean()[use])
    if rises > VIBRATES * settles:
        return (f"no law of settlement is fitted: the ground vibrates, and rises by up to "
                f"{1e3 * rises:.2g} mm between the ends of cycles, in which the sleepers settle by "
                f"{1e3 * settles:.2g} mm (limit {VIBRATES:.0%} of this); give the ground more "
                "damping (ground.rayleigh_mass) or viscous sides, or compute more cycles")
    return ""


def fitted(found, begin):
    """Laws fitted to the mean of the sleepers from cycle `begin` on, computed cycles alone; none if
    they are too few, or if the ground vibrates."""
    use = used(found, begin)
    return [] if why_no_laws(found, begin) else laws.fit(found.cycles[use], found.mean()[use])


def words_of(fit):
    """A line on a fitted law."""
    if fit.at_limit:
        return (f"  {fit.name}: exponent at its limit, b = {fit.exponent:g}: no law can be read "
                "from so few passages or cycles; compute more of them")
    return (f"  {fit.name}: {1e3 * fit.begin:.3f} mm + {1e3 * fit.rate:.4g} mm * "
            f"((1 + N)^b - 1)/b with b = {fit.exponent:.3g}; scatter {1e3 * fit.scatter:.2g} mm")


def table_of(name, found, fits, aims, checks):
    mean, cycles = found.mean(), found.cycles[-1]
    lines = [f"{name}: {cycles:.0f} cycles, {np.count_nonzero(~found.jump) - 1} of them computed",
             f"  settlement of the sleepers: mean {1e3 * mean[-1]:.3f} mm, largest "
             f"{1e3 * found.settled[-1].max():.3f} mm, smallest "
             f"{1e3 * found.settled[-1].min():.3f} mm"]
    lines += map(words_of, fits)
    for one in aims:
        error = (f"{1e3 * one.error:.3f} mm" if np.isfinite(one.error)
                 else "not known (too few cycles)")
        lines.append(f"  jump from cycle {one.begin:.0f} to {one.end:.0f}: by the law "
                     f"{1e3 * one.aimed:.3f} mm in the mean, standard error {error}; in the run "
                     f"{1e3 * one.settled:.3f} mm")
    for check in checks:
        lines.append(f"  jump from cycle {check.begin:.0f} to {check.end:.0f}: "
                     f"{1e3 * check.settled:.3f} mm, true settlement minus this "
                     f"{1e3 * check.lack:+.3f} mm by estimate (in the {check.after:.0f} cycles "
                     f"after it {1e3 * check.found:.3f} mm, by the law "
                     f"{1e3 * check.expected:.3f} mm)")
    return "\n".join(lines) + "\n"


def forecast_curves(forecast, fits, given):
    """{name: settlement, m, over `days`} of the fitted laws, from the begin of the run's count on,
    and of the laws that were asked for."""
    published = {given.lift, given.force, given.subgrade} != {None}
    if published and len({one.axle_load for one in forecast.traffic.trains}) > 1:
        raise read.Unreadable("--lift, --force and --subgrade are for a traffic of one axle load: "
                              "loads act differently in each of these laws")
    days = np.concatenate([[0.0], np.geomspace(forecast.days / 1e4, forecast.days, POINTS)])
    cycles = days * forecast.cycles_per_day()
    curves = {f"{fit.name}, fitted": fit.at(cycles) - fit.at(0.0) for fit in fits}
    axles = days * forecast.traffic.axles_per_day(forecast.axle_load, forecast.power)
    if given.lift is not None:
        curves["Shenton"] = laws.shenton(axles, forecast.axle_load, 1e-3 * given.lift)
    if given.force is not None:
        curves["Varandas"] = np.array([laws.Varandas().settlement([1e3 * given.force], n)
                                       for n in axles])
    if given.subgrade is not None:
        soil, ratio, thickness = given.subgrade
        curves[f"Li and Selig, {thickness:g} m of {soil}"] = \
            thickness * laws.li_selig(axles, ratio, soil)
    return days, curves


def forecast_table(forecast, days, curves):
    unit = f"{forecast.days:g} days, {forecast.megatonnes():.3g} million tonnes"
    lines = [f"forecast for {unit}, {days[-1] * forecast.cycles_per_day():.3g} cycles of the run"]
    lines += [f"  {name}: {1e3 * settled[-1]:.2f} mm" for name, settled in curves.items()]
    of_fits = [settled[-1] for name, settled in curves.items() if name.endswith("fitted")]
    if len(of_fits) == 1:
        lines.append("  one law only could be fitted, so that its uncertainty is not known")
    elif of_fits:
        lines.append(f"  the fitted laws differ by {1e3 * np.ptp(of_fits):.2f} mm, which is the "
                     "least uncertainty beyond the computed cycles")
    return "\n".join(lines) + "\n"


def draw_course(panel, name, found, fits, colour):
    """Jumps as dotted lines; sleepers pale."""
    from_one = np.maximum(found.cycles, 0.5)
    for number, line in enumerate(panel.plot(from_one, 1e3 * found.settled, "-", color=colour,
                                             lw=0.4, alpha=0.35), 1):
        figure_csv.name(line, f"{name}, sleeper {number}")
    panel.plot(from_one, 1e3 * found.mean(), "-", color=colour, lw=1.6, label=f"{name}, mean")
    for row in np.flatnonzero(found.jump):
        jump, = panel.plot(found.cycles[row - 1:row + 1], 1e3 * found.mean()[row - 1:row + 1],
                           "o:", color=colour, ms=5, mfc="white")
        figure_csv.name(jump, f"{name}, jump")
    cycles = np.geomspace(1, found.cycles[-1], POINTS)
    for fit, style in zip(fits, ("--", "-.")):
        panel.plot(cycles, 1e3 * fit.at(cycles), style, color="0.3", lw=1,
                   label=f"{name}, {fit.name} (b = {fit.exponent:.2g})")


def settlement(results, folder, given, forecast=None):
    """Writes settlement.csv, axles.csv of runs with trains, settlement.txt and settlement.png of
    the runs `results` into `folder`; of several runs names of CSV files begin with number
    and name of the run."""
    figure, panels = plt.subplots(1, 2 if forecast else 1, figsize=(13 if forecast else 8, 5.5),
                                  layout="constrained", squeeze=False)
    left, text = panels[0][0], []
    for number, path in enumerate(results):
        run = read.results(path)
        found = course.course_of(path)
        fits = fitted(found, given.begin)
        if why := why_no_laws(found, given.begin):
            folder.remarks.append(f"{run.name}: {why}")
        prefix = "" if len(results) == 1 else f"{number + 1}_{run.name}_"
        folder.file(f"{prefix}settlement.csv", course_as_csv(found, run.deck))
        if trains := course.axles_of(path):
            folder.file(f"{prefix}axles.csv", axles_as_csv(trains))
        text.append(table_of(run.name, found, fits, course.aims(found, run.deck),
                             course.checks(found, run.deck)) + (f"  {why}\n" if why else ""))
        fits = [fit for fit in fits if not fit.at_limit]
        draw_course(left, run.name, found, fits, f"C{number}")
        if forecast:
            days, curves = forecast_curves(forecast, fits, given)
            text.append(forecast_table(forecast, days, curves))
            for style, (name, settled) in zip(("--", "-.", "-", ":", "-"), curves.items()):
                label = f"{run.name}, {name}" if name.endswith("fitted") else name
                if number == 0 or name.endswith("fitted"):
                    panels[0][1].plot(days, 1e3 * settled, style, label=label)
    left.set(xscale="log", xlabel="cycles or trains", ylabel="settlement, mm",
             title="Settlement of the sleepers (thin: each)")
    for panel in panels[0]:
        panel.invert_yaxis()
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    if forecast:
        panels[0][1].set(xlabel="days", ylabel="settlement, mm",
                         title=f"Forecast, {forecast.traffic.tonnes_per_day() * 365.25e-6:.3g} "
                               "million tonnes a year")
    folder.table("settlement.txt", "\n".join(text))
    folder.picture("settlement", figure)
