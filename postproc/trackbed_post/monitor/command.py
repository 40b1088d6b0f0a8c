"""The command `trackbed_post monitor`."""
import contextlib
import csv
import fcntl
import io
import json
import math

import numpy as np

from trackbed_post import measured, read
from trackbed_post.monitor import figures, passages, trends

TABLE, SETTINGS, LOCK = "monitor.csv", "monitor.json", ".lock"


@contextlib.contextmanager
def alone(path):
    """Refuses a folder into which another command writes its rows. The lock is this process's own:
    workers that outlive it do not hold it."""
    with open(path / LOCK, "w", encoding="utf-8") as lock:
        try:
            fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise read.Unreadable(f"{path}: another monitor command is writing there; wait for its "
                                  "end or choose another folder (-o)") from None
        yield


def monitor(source, folder, runs, choices, workers):
    """As `evaluate`, while no other command writes into the folder."""
    if folder.path.resolve() == source.resolve():
        raise read.Unreadable(f"{source} has the signals: choose another folder for the results")
    with alone(folder.path):
        evaluate(source, folder, runs, choices, workers)


def evaluate(source, folder, runs, choices, workers):
    """Continues the table of passages in a write.Folder and draws its trends and the first passage
    that could be evaluated."""
    if workers < 1:
        raise read.Unreadable(f"--workers {workers}: must be at least 1")
    wavelengths = choices.wavelengths
    if not (0 < min(wavelengths) < 0.9 * max(wavelengths) < math.inf):
        raise read.Unreadable(f"--wavelengths {wavelengths[0]:g} {wavelengths[1]:g}: must be two "
                              "different lengths above 0, m")
    lines = passages.listed(source)
    keep_settings(folder, source, runs, choices, {
        line["file"]: [line["reference"], line.get("speed_m_s", "")]
        for line in lines if line.get("reference")})
    references = passages.references_of(source, lines, choices)
    library = passages.library_of(runs, references) if runs or references else None
    path = folder.path / TABLE
    count = passages.batch(source, path, library, choices, workers)
    table = figures.table_of(path)
    files = table.get("file", [])
    failed = np.flatnonzero(~np.isfinite(table["peak_mm"])) if table else []
    reasons = [f"{files[row]}: {table['remarks'][row]}" for row in failed[:5]]
    if len(failed) == len(files):
        raise read.Unreadable("\n".join([f"{path}: no passage could be evaluated", *reasons]))
    folder.remarks += [f"{path}: {count} passages are new, {len(failed)} of {len(files)} could not "
                       "be evaluated", *reasons]
    folder.picture("trends", figures.trends(table, wavelengths))
    found = trends.trends(table)
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([trends.NAMES, *map(passages.texts, found)])
    folder.file("trends.csv", text.getvalue())
    folder.remarks += [f"alarm: {one.quantity} of {one.train or 'all trains'} has changed by "
                       f"{100 * one.change:+.0f} %" for one in found if one.alarm]
    first = int(np.flatnonzero(np.isfinite(table["peak_mm"]))[0])
    folder.picture("passage", figures.passage(measured.load(source / str(files[first])),
                                              float(table["speed_m_s"][first]),
                                              str(files[first]), choices.noise))


def keep_settings(folder, source, runs, choices, references):
    """Refuses to continue a table of other passages, bands or trains."""
    now = {"passages": str(source.resolve()), "wavelengths_m": sorted(choices.wavelengths),
           "library": [str(run.resolve()) for run in runs], "noise_m_s2": choices.noise,
           "references": references,
           "columns": passages.NAMES}
    path = folder.path / SETTINGS
    if path.is_file() and (folder.path / TABLE).is_file():
        then = json.loads(path.read_text(encoding="utf-8"))
        for name, value in now.items():
            if then.get(name, {} if name == "references" else None) != value:
                raise read.Unreadable(f"{folder.path} has the table of {name} = {then.get(name)}, "
                                      f"not {value}: choose another folder")
    folder.file(SETTINGS, json.dumps(now, indent=1) + "\n")
