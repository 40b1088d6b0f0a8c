"""Figures of a bed on a ground, of one run or of two side by side, and a table of their results.

A figure whose data are missing in a run is skipped with a remark. How each number is computed:
docs/postproc.md.
"""
import dataclasses

import matplotlib.collections
import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import (bed_figures, bed_histories, bed_warnings, contact_forces, figure_csv,
                           frequencies, ground_blocks, ground_transition, judgement, measures,
                           passage_warnings, passing_peaks, read, shades, signals,
                           sleeper_histories, stage_histories, stress_paths, support,
                           support_figure, third_octaves, write, zones)
from trackbed_post.bed_figures import COLOURS, Missing, needs
from trackbed_post.panels import END, HIDDEN, LINES, UP, legend_below, mark_ends, wrapped

FILTER = signals.LowPass()
SHOWN_HZ = 20         # least upper end of the spectra
BEYOND = 1.5          # of the highest passing frequency, to which they are shown
CHAIN_WIDTH = 6       # points, line of the largest force
CHAIN_STAGES = 3      # number of last stages that are shown
CHAIN_WINDOW = 3.0    # m, length of track in a picture of force chains
STRESS_COUNTS = "added by the passage; without weight of the bed and static preload"


def needs_ground(runs):
    for run in runs:
        why = measures.why_no_envelope(run)
        needs(not why, why)


def mark_blocks(axes, run):
    """Shades the blocks of the ground and writes their names at the lower edge."""
    stretches = ground_blocks.stretches(run)
    shades.shade(axes, stretches)
    shades.name(axes, stretches, z=0.02)


def envelope(runs):
    """Largest downward displacement of sleepers and ground along the track."""
    needs_ground(runs)
    figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(9, 7))
    text = []
    for run, colour, style in zip(runs, COLOURS, LINES):
        ground = run.ground_envelope["displacement_min"].values * 1e3
        order = np.argsort(run.ground_x)
        lower.plot(run.ground_x[order], ground[order], style, color=colour, lw=1.2,
                   label=f"ground surface, {run.name}")
        if "displacement_min" in run.sleeper_envelope:
            lowest = run.sleeper_envelope["displacement_min"].values * 1e3
            line, = upper.plot(run.sleepers_x, lowest, "o" + style, color=colour, lw=1, ms=4,
                               label=f"sleepers, {run.name}")
            mark_ends(upper, line, ground_blocks.ends(run),
                      END if run is runs[-1] else HIDDEN)
        inner = run.sleepers_x[~ground_blocks.ends(run)]
        judged = (run.ground_x >= inner.min()) & (run.ground_x <= inner.max()) if len(inner) \
            else np.ones(len(ground), bool)
        text.append(f"run {run.name}: {judgement.shown(-np.min(ground[judged]))} mm")
    for panel, what in ((upper, "sleepers"), (lower, "ground surface")):
        mark_blocks(panel, runs[0])
        panel.set_ylabel(f"lowest displacement of\n{what}, {UP}")
        panel.grid(alpha=0.3)
    lower.set_xlabel("x along the track (m)")
    for panel in (upper, lower):
        if panel.lines:
            legend_below(panel)
    upper.set_title(wrapped(
        f"Envelope of the {measures.passage_words(runs)}, relative to its beginning; largest "
        f"downward displacement of the ground's surface, {'; '.join(text)} (without the ends of "
        "the bed)", 9), fontsize=10)
    return figure


def stress(runs):
    """Largest compression of the ground's surface along the track."""
    needs_ground(runs)
    figure, panel = plt.subplots(figsize=(9, 4.5))
    text = []
    for run, colour, style in zip(runs, COLOURS, LINES):
        order = np.argsort(run.ground_x)
        x = run.ground_x[order]
        compression = -run.ground_envelope["sigma_z_min"].values[order] / 1e3
        nodes, = panel.plot(x, compression, color=colour, lw=0.7, alpha=0.6)
        figure_csv.name(nodes, f"{run.name}, each node")
        middles, mean = measures.means_over(x, compression, measures.spacing(run))
        panel.plot(middles, mean, style, color=colour, lw=2,
                   label=f"{run.name} (bold: mean over one sleeper spacing)")
        text.append(f"{run.name} {judgement.shown(np.max(mean))} kPa")
    mark_blocks(panel, runs[0])
    panel.set_xlabel("x along the track (m)")
    panel.set_ylabel("largest vertical compression of the\nground surface in the passage (kPa)")
    panel.set_title(wrapped(f"Compression {STRESS_COUNTS}\nlargest mean over one sleeper spacing: "
                            + ", ".join(text), 9), fontsize=10)
    legend_below(panel)
    panel.grid(alpha=0.3)
    return figure


SPECTRA = {"acceleration": ("m/s2", 1), "displacement": ("mm", 1e3), "seat_force": ("kN", 1e-3)}


def spectrum_of(run, name):
    """Frequency, Hz, and amplitude of a quantity under the last train of the passage, root mean
    square over the sleepers that are not at the ends of the bed."""
    rows = frequencies.rows_of_last_train(run)
    needs(signals.step_of(run.time[rows]) is not None, "histories are not evenly sampled")
    values = run.sleeper[name].values[rows][:, ~ground_blocks.ends(run)] * SPECTRA[name][1]
    if name == "acceleration":
        values = FILTER(run.time[rows], values)
    frequency, amplitude = signals.spectrum(run.time[rows], values)
    return frequency, np.sqrt(np.mean(amplitude**2, axis=1))


def remembered(run, name, known):
    """spectrum_of(), computed once for figure and table; `known`: those that are, of runs by id."""
    key = id(run), name
    if key not in known:
        known[key] = spectrum_of(run, name)
    return known[key]


def peaks_of(runs, name, known):
    """Of each run: name of each passing frequency -> the lobe of its spectrum there."""
    marks = [frequencies.of_passage(run) for run in runs]
    found = [passing_peaks.lobes(remembered(run, name, known), own, frequencies.beside(run, own),
                                 frequencies.resolution(run))
             for run, own in zip(runs, marks)]
    return passing_peaks.judged(found, all(
        frequencies.alike(marks[0], other) for other in marks[1:]))


def passage_of_spectra(runs):
    """Of which rows the spectra are, in words."""
    several = any(frequencies.rows_of_last_train(run) != run.passage() for run in runs)
    return measures.passage_words(runs) + (", its last train" if several else "")


def words_of(name):
    """A quantity of a sleeper in words."""
    return {"seat_force": "seat load"}.get(name, name.replace("_", " "))


def mark_peaks(panel, lobes, colour, label):
    """Rings around peaks at passing frequencies."""
    found = [lobe for lobe in lobes.values() if lobe and lobe.peak]
    panel.plot([lobe.frequency for lobe in found], [lobe.amplitude for lobe in found], "o", ms=7,
               mfc="none", color=colour, label=label)


def table_of_peaks(runs, known=None):
    """Text: peaks of the spectra near the passing frequencies, those that have rings in the figure;
    empty where there are none. `known`: of remembered()."""
    known = {} if known is None else known
    runs = [run for run in runs if frequencies.of_passage(run) and run.sleeper
            and signals.step_of(run.time[run.passage()]) is not None]
    found = {name: peaks_of(runs, name, known) for name in SPECTRA}
    lines = []
    for number, run in enumerate(runs):
        lines += ["", f"spectra of sleepers near the passing frequencies, {run.name}, "
                  f"{passage_of_spectra([run])}, resolution {frequencies.resolution(run):.2g} Hz"]
        marks = frequencies.of_passage(run)
        lines += [f"  {words_of(name):<16}{f'{mark} = {marks[mark]:.2f} Hz':<24}"
                  + (lobe.words(SPECTRA[name][0]) if lobe else "beyond the spectrum")
                  for name, of_runs in found.items() for mark, lobe in of_runs[number].items()]
    return "\n".join(lines) + "\n" if lines else ""


def shown_by_name(panels):
    """The lines of all panels that show something, those of one name once."""
    return list({line.get_label(): line for panel in panels for line in panel.lines
                 if len(line.get_xdata()) and not line.get_label().startswith("_")}.values())


def spectra(runs, known=None):
    """Amplitude spectra of the sleepers in the passage, root mean square over those that are not
    at the ends of the bed. `known`: of remembered()."""
    known = {} if known is None else known
    needs(all(run.sleeper for run in runs), "no sleepers")
    figure, panels = plt.subplots(3, 1, sharex=True, figsize=(9, 9))
    marks = frequencies.of_passage(runs[0])
    shown_hz = max(SHOWN_HZ, BEYOND * max(marks.values(), default=0))
    for panel, (name, (unit, _)) in zip(panels, SPECTRA.items()):
        for run, colour, style, lobes in zip(runs, COLOURS, LINES, peaks_of(runs, name, known)):
            frequency, mean = remembered(run, name, known)
            shown = frequency <= shown_hz
            panel.plot(frequency[shown], mean[shown], style, color=colour, lw=1, label=run.name)
            mark_peaks(panel, lobes, colour, f"{run.name}, peak near a passing frequency "
                       f"(resolution {frequencies.resolution(run):.2g} Hz)")
        panel.set_ylabel(f"{words_of(name)} ({unit})")
    for panel in panels:
        for mark, target in marks.items():
            panel.axvline(target, color="0.4", lw=0.8, ls=":",
                          label=f"{mark} = {target:.1f} Hz, {frequencies.MEANINGS[mark]}")
            panel.text(target, 0.97, f" {mark}", transform=panel.get_xaxis_transform(), va="top",
                       rotation=90, ha="right", fontsize=8)
        panel.grid(alpha=0.3)
    sampled = runs[0].time[frequencies.rows_of_last_train(runs[0])]
    panels[0].set_ylabel(f"acceleration (m/s2)\n{FILTER.name_for(sampled)}", fontsize=9)
    left_out = measures.without_ends(*runs)
    panels[-1].set_xlabel("frequency (Hz)")
    legend_below(panels[-1], handles=shown_by_name(panels))
    panels[0].set_title(wrapped(
        f"Spectra of sleepers in the {passage_of_spectra(runs)}, root mean square over them "
        f"({left_out or 'all'})", 9), fontsize=10)
    return figure


def levels(runs):
    """Third octaves of the sleepers in the passage, root mean square over those that are not at
    the ends of the bed, without a filter."""
    needs(all(run.sleeper for run in runs), "no sleepers")
    lines, lasting = [], []
    for run in runs:
        rows = frequencies.rows_of_last_train(run)
        sleeper = {name: dataclasses.replace(one, values=one.values[rows])
                   for name, one in run.sleeper.items()}
        lines += third_octaves.of_sleepers(run.time[rows], sleeper, ~ground_blocks.ends(run),
                                           run.name)
        lasting.append(f"{np.ptp(run.time[rows]):.3g} s")
    needs(lines, "histories are too short or not evenly sampled")
    return third_octaves.draw(lines, (
        f"Third octaves of sleepers in the {passage_of_spectra(runs)}, mean over "
        f"{' and '.join(dict.fromkeys(lasting))}, root mean square "
        f"{measures.without_ends(runs[0]) or 'over all'}"), frequencies.of_passage(runs[0]))


def draw_chains(panel, chains, stones, largest):
    """Disks in grey, with a red line per contact whose thickness is proportional to the force."""
    if stones is not None and len(stones.radius):
        size = 2 * stones.radius
        panel.add_collection(matplotlib.collections.EllipseCollection(
            size, size, np.zeros_like(size), units="xy", offsets=stones.centre,
            transOffset=panel.transData, facecolors="0.82", edgecolors="none", rasterized=True))
    lines = panel.add_collection(matplotlib.collections.LineCollection(
        chains.segments.reshape(-1, 2, 2), linewidths=CHAIN_WIDTH * chains.force / largest,
        colors="tab:red", capstyle="round", rasterized=True))
    figure_csv.state(lines, "contact force, N", chains.force)
    panel.set_aspect("equal")
    panel.set_ylabel("z (m)")


def force_chains(runs):
    """Force chains at the end of the last stages, as in Fig. 2 of the transition zone study: the
    whole bed in the first panel, a section of it in the following ones. First run only."""
    run = runs[0]
    stages = [name for name, chains in run.chains.items() if len(chains.force)][-CHAIN_STAGES:]
    needs(stages, "no force chains")
    edge = ground_blocks.edge_of_structure(run)
    figure, panels = plt.subplots(len(stages) + 1, 1, figsize=(11, 2.4 * (len(stages) + 1)),
                                  squeeze=False)
    strongest = {name: float(np.max(run.chains[name].force)) for name in stages}
    for number, panel in enumerate(panels[:, 0]):
        name = stages[-1] if number == 0 else stages[number - 1]
        chains, stones = run.chains[name], run.stones.get(name)
        draw_chains(panel, chains, stones, strongest[name])
        x, z = chains.segments[:, ::2], chains.segments[:, 1::2]
        if number == 0:
            panel.set_xlim(np.min(x), np.max(x))
        else:
            middle = np.mean(x) if edge is None else edge
            panel.set_xlim(middle - CHAIN_WINDOW / 2, middle + CHAIN_WINDOW / 2)
        panel.set_ylim(np.min(z) - 0.02, np.max(z) + 0.05)
        panel.set_xlabel("x along the track (m)")
        panel.set_label(f"end of stage {name}" if number else f"whole bed, end of stage {name}")
        panel.set_title(f"{run.name}, {contact_forces.words_of(run, name)}: {len(chains.force)} "
                        f"contacts, thickest line {strongest[name] / 1e3:.1f} kN", fontsize=9)
    return figure


def draw_bed(panel, run):
    """Force chains of the whole bed, with z stretched, as it is long and thin."""
    stage = contact_forces.under_load(run)
    needs(stage, "no force chains")
    chains = run.chains[stage]
    draw_chains(panel, chains, run.stones.get(stage), float(np.max(chains.force)))
    panel.set_aspect("auto")
    panel.set_ylim(0, np.max(chains.segments[:, 1::2]) + 0.05)
    panel.set_title(wrapped(
        f"Contact forces in the bed ({run.name}, {contact_forces.words_of(run, stage)}, thickest "
        f"line {np.max(chains.force) / 1e3:.1f} kN; z stretched)", 11), fontsize=10)


def overview(runs):
    """Overview: forces in the bed, displacement and stress of the ground's surface below it."""
    needs_ground(runs)
    figure, panels = plt.subplots(3, 1, sharex=True, figsize=(11, 7.5),
                                  gridspec_kw={"height_ratios": (1, 1.4, 1.4)})
    draw_bed(panels[0], runs[0])
    for run, colour, style in zip(runs, COLOURS, LINES):
        order = np.argsort(run.ground_x)
        x = run.ground_x[order]
        panels[1].plot(x, run.ground_envelope["displacement_min"].values[order] * 1e3, style,
                       color=colour, label=run.name)
        compression = -run.ground_envelope["sigma_z_min"].values[order] / 1e3
        panels[2].plot(*measures.means_over(x, compression, measures.spacing(run)), style,
                       color=colour, label=run.name)
    panels[1].set_ylabel(f"lowest displacement of\nthe ground surface, {UP}")
    panels[2].set_ylabel("largest compression (kPa),\nmean over a sleeper spacing")
    panels[1].set_title("In the passage, displacement relative to its beginning", fontsize=10)
    panels[2].set_title(f"Compression {STRESS_COUNTS}", fontsize=10)
    for panel in panels[1:]:
        mark_blocks(panel, runs[0])
        panel.grid(alpha=0.3)
    panels[2].set_xlabel("x along the track (m)")
    legend_below(panels[2])
    return figure


FIGURES = {"overview": overview, "sleepers": sleeper_histories.draw, "envelope": envelope,
           "stress": stress, "spectrum": spectra, "third_octaves": levels,
           "force_chains": force_chains, **bed_figures.FIGURES, **bed_histories.FIGURES,
           "stress_paths": stress_paths.draw, "support": support_figure.draw,
           **stage_histories.FIGURES}


# They show the rows of the passage, or of the last stage of a run without one.
OF_PASSAGE = {"sleepers", "spectrum", "third_octaves", "support", "sensors", "stress_paths"}
# They show the ends of stages.
ENDS = {"overview", "force_chains", "forces", "grading", "section"}


def draw_all(runs, folder, ends=True):
    """Draws every figure, or those that do not show the ends of stages, and the table into a
    write.Folder."""
    unlike = measures.why_not_beside(runs)
    known = {}
    for name, draw in (FIGURES | {"spectrum": lambda runs: spectra(runs, known)}).items():
        if name in ENDS and not ends:
            continue
        has = {"breakage": lambda run: run.breaks, "bonds": lambda run: run.bonds,
               "energy_split": measures.has_balance}.get(name)
        if has and not any(has(run) for run in runs):
            continue  # a remark on every bed without what is optional would not help
        try:
            figure = draw(runs)
            if unlike and name in OF_PASSAGE:
                plt.close(figure)
                raise Missing(unlike)
        except Missing as missing:
            folder.remarks.append(f"{name}.png is skipped: {missing}")
            continue
        figure.tight_layout(rect=(0, write.origin_height(figure), 1, 1))
        folder.picture(name, figure)
    unsound = passage_warnings.why_no_verdict((run.name, run) for run in runs)
    text = ground_transition.table(runs, unsound) + "".join(map(measures.region_table, runs))
    supported = [(run, changing) for run, changing in zip(runs, zones.changing_of_each(runs))
                 if len(run.sleepers_x) and run.sleeper
                 and (run.has_passage() or not run.asks_for_passage())]
    if supported:
        text += "\n" + "".join(support.summary(run) + "\n" for run, _ in supported)
        text += "".join(
            f"warning: {run.name}: {one}\n" for run, changing in supported
            for one in (*bed_warnings.of(run, changing), *passage_warnings.of_bed(run)))
        folder.file("support.csv", support.table([run for run, _ in supported]))
    folder.sentences += [*effects(runs, unsound),
                         *(f"{support.summary(run)}." for run, _ in supported)]
    text += table_of_peaks(runs, known)
    text += "".join(f"warning of {run.name}: {line}\n" for run in runs for line in run.warnings)
    folder.table("table.txt", text)


def effects(runs, unsound):
    """Sentences on the difference of two runs, those of the table; a train has others."""
    if ground_blocks.carried_by_springs(runs[0]):
        return []
    return ground_transition.effects(runs, unsound)


def draw_into(results, folder, ends=True):
    """Pictures and table of one run, or of two compared; `results`: their folders, `ends`: with
    those of the ends of stages."""
    runs = [read.results(path) for path in results]
    for run in runs:
        if run.deck.get("model") == "stones":
            raise read.Unreadable(f"{run.name}: contains single stones only; the command `list` "
                                  "lists their histories")
        if run.deck.get("model") == "ground":
            raise read.Unreadable(f"{run.name}: contains a ground alone; the command `list` lists "
                                  "its histories")
        if run.deck.get("model", "bed") != "bed":
            raise read.Unreadable(f"{run.name}: contains a track without a bed")
        if not len(run.time) or not len(run.stage):
            raise read.Unreadable(f"{run.name}: results.h5 contains no row of the histories yet")
    draw_all(runs, folder, ends)
