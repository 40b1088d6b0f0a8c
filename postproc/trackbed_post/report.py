"""One HTML file of a run, or of several side by side: the results in short, what the decks differ
by, warnings, models, figures, numbers, stages, balances and cost. It needs no other file and can be
sent as it is.

The drawing of the model is that which the program leaves beside its results; figures and numbers
are those of the command `figures`. While a run goes on, the report shows how far it is and what its
histories hold up to now; stages, balances and cost follow when summary.json exists. A report can be
written again and again until its runs have ended.
"""
import base64
import dataclasses
import functools
import html
import math
import pathlib
import tempfile
import time

from trackbed_post import (bed_warnings, curves, deck_differences, kinds, overlays,
                           passage_warnings, program, progress, read, write)


STYLE = """
body { font-family: sans-serif; margin: 2em auto; max-width: 70em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; }
td, th { border-bottom: 1px solid #bbb; padding: 0.2em 0.8em; text-align: right; }
td:first-child, th:first-child { text-align: left; }
img { max-width: 100%; border: 1px solid #ddd; }
pre { background: #f4f4f4; padding: 0.8em; overflow-x: auto; }
.warning { border-left: 0.4em solid #b00; padding-left: 0.8em; }
"""


@dataclasses.dataclass(frozen=True)
class Choices:
    """`over`: (quantity, file) of measured or published curves, as in curves.draw_into();
    `measured`: texts of overlays.of_text(); `program`: which draws the model."""
    over: tuple = ()
    measured: tuple = ()
    program: pathlib.Path | None = None


class Run:
    """What the report needs of one result folder, which may be given by its results.h5."""

    def __init__(self, folder):
        self.folder = read.folder_of(folder)
        self.origin, self.deck, self.text = read.origin(self.folder)
        self.summary = read.summary(self.folder)

    @property
    def name(self):
        return self.folder.resolve().name

    def warnings(self):
        """Up to now; a run that computes has none in its summary, or those before it continued."""
        return progress.warnings_of(self.folder) or self.summary.get("warnings", [])

    def state(self):
        if progress.computes(self.folder):
            return "still running"
        if not self.summary:
            return progress.facts_of(self.folder).get(
                "run", "still running, or failed (no summary.json)")
        return "finished" if self.summary["finished"] else "stopped early"


def element(tag, text, **attributes):
    words = "".join(f' {name}="{html.escape(value)}"' for name, value in attributes.items())
    return f"<{tag}{words}>{html.escape(text)}</{tag}>"


def image(name, kind, content):
    data = base64.b64encode(content).decode()
    return f'<img alt="{html.escape(name)}" src="data:image/{kind};base64,{data}">'


def embedded(path):
    return image(path.stem, "png", path.read_bytes())


def table(head, rows):
    lines = ["<tr>" + "".join(element("th", one) for one in head) + "</tr>"]
    lines += ["<tr>" + "".join(element("td", str(one)) for one in row) + "</tr>" for row in rows]
    return "<table>" + "\n".join(lines) + "</table>"


def number(value):
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def side_by_side(runs, of):
    """Rows of a table: the names that `of` gives of each run, and the values of all runs."""
    values = [of(run) for run in runs]
    names = dict.fromkeys(name for one in values for name in one)
    return [[name, *(number(one.get(name, "")) for one in values)] for name in names]


def facts_of(run):
    summary = run.summary
    found = {"state": run.state(), "written by": run.origin,
             "title of the deck": run.deck.get("title", "")}
    if run.deck.get("start"):
        found["started from, with the stages before"] = \
            deck_differences.end_of_path(run.deck["start"])
    if summary:
        found |= {"deck": summary["deck"], "model": summary["model"], "ranks": summary["ranks"],
                  "simulated time, s": summary["simulated_time_s"],
                  "wall time, s": summary.get("wall_time_of_all_parts_s",
                                              summary["wall_time_s"]),
                  "memory of a rank, MB": summary["memory_mb_per_rank"]}
    for key, name in (("particles", "stones"), ("pieces", "pieces of stones")):
        if key in summary.get("dem", {}):
            found[name] = summary["dem"][key]
    ground = summary.get("ground", {})
    if ground.get("elements"):  # 0 without a ground
        found |= {f"{key} of the ground": ground[key] for key in ("elements", "unknowns")
                  if key in ground}
    return found


def balances_of(run):
    found = {f"coupling, relative imbalance of {name}": value
             for name, value in run.summary.get("coupling", {}).items()
             if isinstance(value, float)}
    found |= {f"energy, {name}, J": value
              for name, value in run.summary.get("energy", {}).items()
              if isinstance(value, float)}
    return found


def cost_of(run):
    return {f"{name}, s": phase["mean_s"]
            for name, phase in run.summary.get("timers", {}).items()}


def stages_of(run):
    """Heading and rows of the stages of a run."""
    columns = {"name": "stage", "time_s": "end, s", "duration_s": "duration, s",
               "particles": "stones", "bulk_density_kg_m3": "bulk density, kg/m3",
               "settlement_m": "largest settlement of a sleeper in the last cycle, m",
               "wall_time_s": "wall time, s"}
    stages = run.summary.get("stages", [])
    shown = [key for key in columns if any(key in stage for stage in stages)]
    return [columns[key] for key in shown], [[number(stage.get(key, "")) for key in shown]
                                             for stage in stages]


def of_bed(folder):
    """Sentences on the bed of a run; none of another model, or before it has histories."""
    try:
        return bed_warnings.of(read.results(folder))
    except read.Unreadable:
        return []


def warnings_of(runs):
    lines = [element("p", f"{run.name}: {one}", **{"class": "warning"})
             for run in runs for one in (*run.warnings(), *of_bed(run.folder),
                                         *passage_warnings.of_folder(run.folder))]
    return "\n".join(lines) or element("p", "None." if all(run.summary for run in runs)
                                       else "None up to now.")


def compared_with(results, over):
    """A Part for each (quantity, file): the runs' curve beside a measured or published one."""
    return [kinds.Part(f"{quantity} and {pathlib.Path(file).name}", results,
                       functools.partial(curves.draw_into, results, quantity=quantity, over=[file]))
            for quantity, file in over]


def model_of(run, given):
    """The drawing of a run's model: that beside its results, or, if a program is `given` or there
    is none, one that the program makes."""
    drawing = run.folder / "model.svg"
    if given is None and drawing.is_file():
        return drawing.read_text(encoding="utf-8")
    return program.drawing(run.text, given)


def models_of(runs, given):
    """The model of each deck, seen from the side; `given`: the program. Equal drawings once."""
    drawn = {}
    for run in runs:
        try:
            drawn.setdefault(model_of(run, given), []).append(run.name)
        except read.Unreadable as why:
            drawn[element("p", f"{run.name}: {why}")] = []
    return "\n".join(element("h3", " and ".join(names)) + image("model", "svg+xml", text.encode())
                     if names else text for text, names in drawn.items())


def differences_of(runs):
    """A table of what the decks of several runs differ by; nothing of one run."""
    if len(runs) < 2:
        return []
    rows = deck_differences.rows([run.deck for run in runs])
    heading = element("h2", "Differences of the decks")
    if not rows:
        return [heading, element("p", "None, apart from names and titles.")]
    return [heading, table(["key", *(run.name for run in runs)], rows)]


def figures_of(runs, folder, choices, curves_over):
    """(what the tables say in short, pictures and numbers of each kind of figure, with measured
    curves over them, and of each comparison with others). A figure that curves need may come
    later."""
    parts, sentences = [], []
    results = [run.folder for run in runs]
    every = [*kinds.parts_of(results, kinds.of_deck(runs[0].deck)),
             *compared_with(results, choices.over)]
    for i, part in enumerate(every):
        made = write.Folder(folder / str(i), write.origin_of(part.results),
                            over=curves_over)
        names = ", ".join(path.resolve().name for path in part.results)
        parts.append(element("h3", f"{part.kind}: {names}"))
        try:
            part.draw(made)
        except read.Unreadable as why:
            made.remarks.append(f"No further figures: {why}")
        sentences += made.sentences
        parts += [embedded(path) for path in made.pictures]
        parts += [element("pre", text) for text in made.tables]
        parts += [element("p", one) for one in made.remarks]
    curves_over.require_drawn(missing=False)
    parts += [element("p", f"Not drawn: {why}") for why in curves_over.missing()]
    return list(dict.fromkeys(sentences)), "\n".join(parts)


def progress_of(runs, folder):
    """Table and figures of the events of the runs; nothing without events."""
    rows = side_by_side(runs, lambda run: progress.facts_of(run.folder))
    if not rows:
        return []
    parts = [element("h2", "Progress"), table(["", *(run.name for run in runs)], rows)]
    for i, run in enumerate(runs):
        made = write.Folder(folder / f"progress_{i}", write.origin_of([run.folder]))
        progress.draw_into(run.folder, made)
        parts += [embedded(path) for path in made.pictures]
        parts += [element("p", f"{run.name}: {one}") for one in made.remarks]
    return parts


def page(runs, folder, choices, curves_over, every=0):
    """`every`: seconds after which a browser loads the document again; 0: never. The progress is at
    the end unless a run computes."""
    sentences, figures = figures_of(runs, folder, choices, curves_over)
    how_far, computing = progress_of(runs, folder), any(progress.computes(run.folder)
                                                        for run in runs)
    parts = [element("h1", " and ".join(run.name for run in runs)),
             *([element("h2", "In short"), *(element("p", one) for one in sentences)]
               if sentences else []),
             table(["", *(run.name for run in runs)], side_by_side(runs, facts_of)),
             *(how_far if computing else []), *differences_of(runs),
             element("h2", "Warnings"), warnings_of(runs),
             element("h2", "Models"), models_of(runs, choices.program),
             element("h2", "Figures and numbers"), figures,
             *numbers_of(runs), *([] if computing else how_far)]
    parts.append(element("h2", "Effective input"))
    for run in runs:
        parts.append(f"<details>{element('summary', run.name)}{element('pre', run.text)}</details>")
    title = element("title", "trackbed: " + " and ".join(run.name for run in runs))
    again = f'<meta http-equiv="refresh" content="{math.ceil(every)}">' if every else ""
    return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">{again}{title}'
            f"<style>{STYLE}</style></head>\n<body>\n" + "\n".join(parts) + "\n</body></html>\n")


def numbers_of(runs):
    """Stages, balances and cost."""
    parts = []
    for run in runs:
        heading, rows = stages_of(run)
        if rows:
            parts += [element("h2", f"Stages of {run.name}"), table(heading, rows)]
    for title, of in (("Balances at the end of the run", balances_of),
                      ("Cost, mean over the ranks", cost_of)):
        rows = side_by_side(runs, of)
        if rows:
            parts += [element("h2", title), table(["", *(run.name for run in runs)], rows)]
    return parts


def write_report(results, file, choices=Choices(), every=0):
    """Writes the report of one run or of several, given by their folders. `every`: seconds after
    which a browser loads it again; 0: never, as it is the last report."""
    runs = [Run(folder) for folder in results]
    kinds.require_comparable([run.deck for run in runs])
    if choices.program:
        program.find(choices.program)
    for quantity, other in choices.over:  # before anything is drawn
        curves.of_file(other)
        curves.of_run(runs[0].folder, quantity)
    write.folder(file.resolve().parent)
    with tempfile.TemporaryDirectory() as folder:
        curves_over = overlays.Overlays(choices.measured)
        text = page(runs, pathlib.Path(folder), choices, curves_over, every)
        write.whole(file, text.encode())
    curves_over.require_drawn(missing=not every)  # once the report is written


def follow(results, file, choices, every):
    """Writes the report every so many seconds while one of the runs computes, and once more when
    none does. Results that cannot be read, as in the moment in which they are written, leave the
    report as it was."""
    folders = [read.folder_of(one) for one in results]
    write_report(results, file, choices, every)  # with all that is wrong in the command
    while any(progress.computes(one) for one in folders):
        time.sleep(every)
        try:
            write_report(results, file, choices, every)
        except read.Unreadable as why:
            print(f"the report stays as it was: {why}", flush=True)
    write_report(results, file, choices)
