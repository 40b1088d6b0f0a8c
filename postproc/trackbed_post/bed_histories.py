"""Figures of histories within the bed: sensors and energies."""
import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import measures, signals, train_strip
from trackbed_post.bed_figures import COLOURS, mark_stages, needs
from trackbed_post.panels import LINES, UP, curve, legend_below, wrapped

FILTER = signals.LowPass()
MOST = 8              # sensors below the train; a note states that there are more


def time_in_passage(run):
    """(rows, time since its first row, s, its name for an axis) of the passage or last stage."""
    rows = run.passage()
    words = f"time since the {run.passage_name()} began (s)"
    return rows, run.time[rows] - run.time[rows][0], words


def _places(deck, names, origin):
    """One for each x, m, of the sensors with these names, in the colour of the first one there."""
    found = {}
    for sensor in deck.get("sensor", []):
        if sensor["name"] in names:
            found.setdefault(sensor["at"][0] + origin, []).append(sensor["name"])
    return [train_strip.Place(x, f"{', '.join(there)}, x = {x:g} m",
                              curve(names.index(there[0]), 1)["color"])
            for x, there in found.items()]


def sensors(runs, origin=0.0):
    """Vertical motion of each sensor in the passage; displacement since the passage began. The
    sensors' x = 0 is at `origin`, m, in the coordinate of the wheels."""
    needs(all(run.sensors for run in runs), "the results contain no sensors")
    panels = {"displacement": f"displacement ({UP})", "velocity": "velocity (mm/s, up)",
              "acceleration": "acceleration (m/s2, up)"}
    names = list(dict.fromkeys(name for run in runs for name in run.sensors))
    train = train_strip.of_passage(runs[0])
    places = _places(runs[0].deck, names, origin)
    shown = places[:MOST]
    figure, axes = train_strip.panels_below(train, shown, len(panels), (10, 8))
    for run, style in zip(runs, LINES):
        rows, time, label = time_in_passage(run)
        for number, name in enumerate(names):
            for panel, quantity in zip(axes, panels):
                if quantity not in run.sensors.get(name, {}):  # of a sensor at a fixed place
                    continue
                values = run.sensors[name][quantity].values[rows, 2]
                if quantity == "displacement":
                    values = values - values[0]
                values = FILTER(time, values) if quantity == "acceleration" else 1e3 * values
                panel.plot(time, values, style, lw=1, **curve(number, len(time)),
                           label=name if run is runs[0] else f"{name}, {run.name}")
    for panel, text in zip(axes, panels.values()):
        panel.set_ylabel(text)
        panel.grid(alpha=0.3)
    axes[2].set_ylabel(f"{panels['acceleration']}\n{FILTER.name_for(time)}")
    axes[1].legend(fontsize=7, loc="center left", bbox_to_anchor=(1, 0.5))
    train_strip.mark_all(axes, train, shown)
    few = f"; below the train: the first {MOST} of {len(places)}" if len(places) > MOST else ""
    figure.axes[0].set_title("Sensors: " + ", ".join(
        f"{run.name} ({words})" for run, words in zip(runs, ("lines", "dashed"))) + few,
        fontsize=10)
    axes[-1].set_xlabel(label)
    return figure


def since_stage_began(run, values):
    """(time, s; values less those of the first row of their stage), with nan between stages."""
    begins = np.flatnonzero(np.diff(run.stage)) + 1
    time, parts = np.split(run.time, begins), np.split(values.ravel(), begins)
    gap = [np.nan]
    return (np.concatenate([np.append(one, gap) for one in time])[:-1],
            np.concatenate([np.append(one - one[0], gap) for one in parts])[:-1])


def steps_between_stages(run, values, least):
    """Words for each change from the last row of a stage to the first of the next that is larger
    than `least`, J."""
    values = values.ravel()
    names = [stage["name"] for stage in run.deck["stage"]]
    return [f"{run.name}, begin of {names[run.stage[k]]}: {step / 1e3:.3g} kJ"
            for k in np.flatnonzero(np.diff(run.stage)) + 1
            if abs(step := values[k] - values[k - 1]) > least]


def draw_potential(runs, colours, panel):
    """The change in each stage: when stones are removed between two stages, the change since the
    run began would hide all others. A remark states these steps."""
    steps = []
    for run, colour, style in zip(runs, colours, LINES):
        values = run.energy["potential"].values
        time, change = since_stage_began(run, values)
        panel.plot(time, change, style, color=colour, lw=1, label=run.name)
        steps += steps_between_stages(run, values, np.ptp(change[np.isfinite(change)]))
    panel.set_ylabel("potential, change since\nthe stage began (J)")
    if steps:
        panel.set_title(wrapped("steps between stages, not shown (for example when stones are "
                                "removed): " + "; ".join(steps), 9, 9), fontsize=9)


def energy(runs):
    """Energies of the stones over the whole run; the potential energy as its change since each
    stage began, so that a variant that started at a later stage is comparable."""
    needs(all(run.energy for run in runs), "the results contain no energies")
    shown = (("kinetic", "kinetic (J)"), ("elastic", "elastic, contacts (J)"))
    figure, panels = plt.subplots(3, 1, sharex=True, figsize=(9, 8))
    text = []
    for run, colour, style in zip(runs, COLOURS, LINES):
        for panel, (name, label) in zip(panels, shown):
            panel.plot(run.time, run.energy[name].values, style, color=colour, lw=1,
                       label=run.name)
            panel.set_ylabel(label)
        text.append(f"{run.name} {run.energy['kinetic'].values[-1]:.3g} J at {run.time[-1]:.3f} s")
    draw_potential(runs, COLOURS, panels[2])
    panels[0].set_yscale("log")  # from kJ of falling stones to below mJ at rest
    mark_stages(panels, runs)
    for panel in panels:
        panel.grid(alpha=0.3)
    panels[0].set_title(wrapped("Energies of the stones\nkinetic energy in the last row of the "
                                f"histories: {'; '.join(text)}", 9), fontsize=10)
    panels[-1].set_xlabel("simulated time (s)")
    legend_below(panels[-1], columns=4)
    return figure


def energy_split(runs):
    """What was dissipated since the last stage began, by cause, beside what surfaces supplied less
    what the stones store."""
    needs(all(measures.has_balance(run) for run in runs),
          "the results contain no balance of energy (dem.energy_balance)")
    figure, panels = plt.subplots(1, len(runs), sharey=True, squeeze=False,
                                  figsize=(6 * len(runs) + 2, 5))
    for run, panel in zip(runs, panels[0]):
        split = measures.energy_split(run)
        panel.stackplot(split.time, split.dissipated.values(), alpha=0.8,
                        labels=measures.DISSIPATED.values())
        panel.plot(split.time, split.supplied - split.stored, color="k", lw=1, ls="--",
                   label="supplied less stored")
        parts = ", ".join(f"{measures.DISSIPATED[name]} {values[-1]:.3g}"
                          for name, values in split.dissipated.items())
        panel.set_label(run.name)
        panel.set_title(f"{run.name}, last stage (J): supplied {split.supplied[-1]:.3g},\n"
                        f"{parts}; missing {split.missing[-1]:.2g}", fontsize=9)
        panel.set_xlabel("time since the last stage began (s)")
        panel.grid(alpha=0.3)
    panels[0, 0].set_ylabel("energy (J)")
    panels[0, 0].legend(fontsize=8, loc="upper left")
    return figure


FIGURES = {"energy": energy, "sensors": sensors, "energy_split": energy_split}
