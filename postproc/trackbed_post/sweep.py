"""Runs a deck with every combination of values of some parameters, and draws mean and band of a
curve over the random seeds.

A combination has a folder of its own. A second call leaves finished runs alone and resumes those
that were stopped.
"""
import dataclasses
import itertools
import json
import pathlib
import re
import signal
import subprocess

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import curves, read, track_figures, train_figures, transition, write
from trackbed_post.kinds import of_deck

STOPPED = 3  # exit code of a run that a signal or a limit has ended early
RESULTS = ("energy.", "coupling.")  # what of summary.json is one: the rest is size and cost


@dataclasses.dataclass(frozen=True)
class Case:
    """One combination: values by parameter, and the folder of its run."""
    values: dict
    folder: pathlib.Path

    def words(self):
        return [f"{key}={value}" for key, value in self.values.items()]

    def group(self):
        """The values that are no seeds; runs that differ in seeds only are averaged."""
        return tuple((key, value) for key, value in self.values.items() if not is_seed(key))


def is_seed(key):
    return key.endswith("seed")


def as_name(key, value):
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", f"{key.rpartition('.')[2]}_{value}").strip("_")


def cases(varied, folder):
    """Every combination of {parameter: values}."""
    found = []
    for combination in itertools.product(*varied.values()):
        values = dict(zip(varied, combination))
        name = "_".join(as_name(key, value) for key, value in values.items()) or "run"
        found.append(Case(values, pathlib.Path(folder) / name))
    names = [case.folder.name for case in found]
    if len(set(names)) < len(names):
        raise read.Unreadable("two combinations have the same folder "
                              f"{max(names, key=names.count)}: is a value given twice?")
    return found


def state_of(case):
    """finished, stopped (it can be resumed) or new."""
    if read.summary(case.folder).get("finished"):
        return "finished"
    return "stopped" if (case.folder / "latest").is_file() else "new"


def require_same_deck(deck, case):
    """A finished run of another deck would be taken for a result of this sweep."""
    stored = case.folder / "sweep.json"
    now = {"deck": pathlib.Path(deck).read_text(encoding="utf-8"), "values": case.words()}
    if case.folder.is_dir() and state_of(case) != "new":
        before = json.loads(stored.read_text(encoding="utf-8")) if stored.is_file() else None
        if before != now:
            raise read.Unreadable(f"{case.folder} holds a run of another deck, or of other values: "
                                  "choose another folder (-o), or remove it")
    write.folder(case.folder)
    write.whole(stored, json.dumps(now).encode())


def begin(words, log):
    """Starts a process; (process, whether Ctrl-C came meanwhile), which would otherwise leave a
    process that nobody waits for."""
    asked = []
    before = signal.signal(signal.SIGINT, lambda *_: asked.append(True))
    try:
        child = subprocess.Popen(words, stdout=log, stderr=log, start_new_session=True)
    finally:
        signal.signal(signal.SIGINT, before)
    return child, bool(asked)


def run(case, deck, program, ranks):
    """Runs or resumes a case; exit code. Ctrl-C lets the run write its checkpoint first."""
    start = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 \
        else []
    words = ["resume", str(case.folder)] if state_of(case) == "stopped" else \
        ["run", str(deck), *case.words(), "--force", "-o", str(case.folder)]
    with open(case.folder / "log.txt", "ab") as log:
        child, asked = begin([*start, str(program), *words], log)
        try:
            if asked:
                raise KeyboardInterrupt
            return child.wait()
        except KeyboardInterrupt:
            # mpirun passes SIGUSR1 on to the ranks and waits for their checkpoint.
            child.send_signal(signal.SIGUSR1)
            child.wait()
            return STOPPED


def flat(tree, path=""):
    """Numbers of a nested dictionary by their path."""
    found = {}
    for key, value in tree.items():
        name = f"{path}{key}"
        if isinstance(value, dict):
            found |= flat(value, f"{name}.")
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            found[name] = float(value)
    return found


def numbers_of(folder):
    """Name -> number of a run: those of its figures, and balances and energies of summary.json."""
    found = {}
    every, deck = read.datasets(folder), read.origin(folder)[1]
    kinds = of_deck(deck)
    if "track" in kinds:
        rows = track_figures.numbers(every, deck["track"]["length"],
                                     track_figures.extremes_of(folder),
                                     track_figures.run_in_of(deck))
        found |= {f"{name} ({unit})": float(value) for name, (value, unit) in rows.items()}
    if "transition" in kinds:
        found |= transition.numbers(folder)
    if "train" in kinds:
        rows = train_figures.numbers(train_figures.Passing(read.results(folder), every))
        found |= {f"{name} ({unit})": float(value) for name, (value, unit) in rows.items()}
    summary = flat(read.summary(folder))
    return found | {name: value for name, value in summary.items() if name.startswith(RESULTS)}


def grouped(done):
    """Lists of the Cases that differ in seeds only, by their other values."""
    groups = {}
    for case in done:
        groups.setdefault(case.group(), []).append(case)
    return groups


def label(group):
    return ", ".join(f"{key} = {value}" for key, value in group) or "all seeds"


def table_csv(done, numbers):
    keys = list(done[0].values)
    names = list(dict.fromkeys(name for one in numbers for name in one))
    rows = [",".join(f'"{name}"' for name in (*keys, *names))]
    for case, one in zip(done, numbers):
        cells = [f'"{case.values[key]}"' for key in keys]
        rows.append(",".join(cells + [f"{one[name]:.9g}" if name in one else "" for name in names]))
    return "\n".join(rows) + "\n"


def table_text(done, numbers):
    """Mean and standard deviation (of a sample) over the seeds of each number that varies."""
    of = dict(zip((case.folder for case in done), numbers))
    names = [name for name in numbers[0] if all(name in one for one in numbers)
             and (len(done) == 1 or np.ptp([one[name] for one in numbers]) > 0)]
    lines = ["mean +- standard deviation (of a sample) over the seeds"]
    for group, members in grouped(done).items():
        lines.append(f"{label(group)}: {len(members)} run{'s' if len(members) > 1 else ''}")
        for name in names:
            values = [of[case.folder][name] for case in members]
            spread = f"{np.std(values, ddof=1):.3g}" if len(values) > 1 else "-"
            lines.append(f"  {name:70} {np.mean(values):12.5g} +- {spread}")
    return "\n".join(lines) + "\n"


def draw(done, quantity, place):
    """Mean (line) and range (band) of a curve over the seeds, for each group."""
    figure, panel = plt.subplots(figsize=(9, 5), layout="constrained")
    every = curves.of_runs([case.folder for case in done], quantity, place)
    found = {case.folder: curve for case, curve in zip(done, every)}
    where = every[0].name.partition(", ")[2]
    factor, unit = curves.scale_of(list(found.values()))
    for number, (group, members) in enumerate(grouped(done).items()):
        x = found[members[0].folder].x
        y = factor * np.array([np.interp(x, one.x, one.y)
                               for one in (found[case.folder] for case in members)])
        style = curves.STYLES[number % len(curves.STYLES)]
        words = f"{label(group)} ({len(members)} runs)"
        line = panel.plot(x, y.mean(axis=0), style, label=words)[0]
        panel.fill_between(x, y.min(axis=0), y.max(axis=0), color=line.get_color(), alpha=0.2, lw=0)
    panel.set(xlabel="time, s" if every[0].x_unit == "s" else f"x, {every[0].x_unit}",
              ylabel=f"{quantity}, {unit}",
              title=f"{where}; line: mean, band: range over the seeds".removeprefix("; "))
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8)
    return figure


def require_valid(deck, case, program):
    """`check` finds an unknown parameter in seconds."""
    ran = subprocess.run([str(program), "check", str(deck), *case.words()], capture_output=True,
                         text=True, check=False)
    if ran.returncode:
        raise read.Unreadable(f"{program} check {deck} {' '.join(case.words())}: "
                              f"{ran.stderr.strip() or ran.stdout.strip()}")


def run_all(deck, every, program, ranks):
    """Runs the Cases in turn and prints how each ends; (those that are finished, exit code)."""
    done = []
    try:
        return done, run_in_turn(deck, every, program, ranks, done)
    except KeyboardInterrupt:  # between two runs
        print("stopped; run the same command again to continue")
        return done, STOPPED


def run_in_turn(deck, every, program, ranks, done):
    """As run_all; appends finished Cases to `done` and returns the exit code."""
    ending = 0
    if any(state_of(case) == "new" for case in every):
        require_valid(deck, every[0], program)
    for number, case in enumerate(every, 1):
        words = f"{number} of {len(every)}: {case.folder}"
        require_same_deck(deck, case)
        if state_of(case) == "finished":
            print(f"{words}: already finished, skipped")
            done.append(case)
            continue
        print(words, flush=True)
        code = run(case, deck, program, ranks)
        if code == 0:
            done.append(case)
            continue
        if code == STOPPED:
            print(f"{case.folder}: stopped; run the same command again to continue")
            return STOPPED
        ending = read.Unreadable.code
        print(f"{case.folder}: ended with code {code}; the reason is in "
              f"{case.folder / 'log.txt'}")
    return ending


def write_results(done, folder, quantity="", place=-1):
    numbers = [numbers_of(case.folder) for case in done]
    folder.file("sweep.csv", table_csv(done, numbers))
    if quantity:
        folder.picture("sweep", draw(done, quantity, place))
    folder.table("sweep.txt", table_text(done, numbers))
