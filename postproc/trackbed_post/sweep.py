"""Runs a deck with every combination of values of some parameters, and draws mean and band of a
curve over the random seeds.

A combination has a folder of its own. A second call leaves finished runs alone and resumes those
that were stopped. A combination can be a chain: runs of other decks come before, each of which
hands its state to the next one; combinations with the same values of an earlier run share it.
"""
import contextlib
import dataclasses
import itertools
import json
import pathlib
import re
import signal
import subprocess

import matplotlib.pyplot as plt
import numpy as np

from trackbed_post import (curves, overlays, panels, program, read, track_along, track_figures,
                           train_figures, transition, write)
from trackbed_post.kinds import of_deck

FIGURE = "sweep"  # name of the figure of --quantity
STOPPED = 3  # exit code of a run that a signal or a limit has ended early
RESULTS = ("energy.", "coupling.")  # what of summary.json is one: the rest is size and cost


@dataclasses.dataclass(frozen=True)
class Case:
    """One combination: values by parameter, and the folder of its run."""
    values: dict
    folder: pathlib.Path

    def group(self):
        """The values that are no seeds; runs that differ in seeds only are averaged."""
        return tuple((key, value) for key, value in self.values.items() if not is_seed(key))


@dataclasses.dataclass(frozen=True)
class Link:
    """A deck that is run before, whose folder, or the end of one of its stages, becomes the value
    of a parameter of the next deck (bed.cell, start)."""
    deck: pathlib.Path
    parameter: str
    stage: str = ""

    def word(self, folder):
        place = folder / f"stage_{self.stage}.h5" if self.stage else folder
        return f"{self.parameter}='{place.resolve()}'"


@dataclasses.dataclass(frozen=True)
class Step:
    """One run of a Case: its deck, values by parameter, folder, the word that gives it the state of
    the run before it, and what identifies each run before it."""
    deck: pathlib.Path
    values: dict
    folder: pathlib.Path
    state: str = ""
    before: tuple = ()

    def words(self):
        return [f"{key}={value}" for key, value in self.values.items()]

    def changes(self):
        return [*self.words(), *([self.state] if self.state else [])]

    def own(self):
        """Deck and values, without those of the runs before."""
        return {"deck": self.deck.read_text(encoding="utf-8"), "values": self.words()}

    def identity(self):
        """What must be the same for a run to be this one; stored in sweep.json."""
        return self.own() | {"before": list(self.before)}


def link_of(deck, text):
    """The Link of PARAMETER or PARAMETER=STAGE."""
    parameter, _, stage = text.partition("=")
    if not parameter or not deck.is_file():
        raise read.Unreadable(f"--before {deck} {text}: " + (
            "give PARAMETER or PARAMETER=STAGE" if deck.is_file() else f"{deck} does not exist"))
    return Link(deck, parameter, stage)


def require_owners(varied, chain):
    """Each parameter NAME:PARAMETER must be one of a deck before, all of which have their own name.
    """
    stems = [link.deck.stem for link in chain]
    if len(set(stems)) < len(stems):
        raise read.Unreadable("two decks before have the same name "
                              f"{max(stems, key=stems.count)}: copy one to another name")
    for key in varied:
        owner, colon, _ = key.partition(":")
        if colon and owner not in stems:
            raise read.Unreadable(f"--vary {key}: no deck {owner} comes before; "
                                  f"{'there are ' + ', '.join(stems) if stems else 'see --before'}")


def require_figure(given):
    """The only figure is drawn of --quantity; a curve over any other could not be drawn when all
    runs have finished."""
    others = [one.text for one in overlays.Overlays(given.laid).overlays if one.figure != FIGURE]
    if others:
        raise read.Unreadable(f"--measured {others[0]}: the only figure of a sweep is {FIGURE}")
    if given.laid and not given.quantity:
        raise read.Unreadable(f"--measured {given.laid[0]}: the figure {FIGURE} is drawn with "
                              "--quantity only")


def of_options(given):
    """(deck, Cases, trackbed, ranks, Links) of the options of the command."""
    require_figure(given)
    varied = varied_of(given.vary)
    chain = [link_of(pathlib.Path(deck), text) for deck, text in given.before]
    require_owners(varied, chain)
    if given.ranks < 1:
        raise read.Unreadable(f"--ranks {given.ranks}: must be at least 1")
    if not given.deck.is_file():
        raise read.Unreadable(f"{given.deck} does not exist")
    return given.deck, cases(varied, given.output), program.find(given.program), given.ranks, chain


def steps_of(case, deck, chain=()):
    """The Steps of a Case, the last of which is that of the deck. Runs before are named by all
    values up to them."""
    steps, names, state, before = [], [], "", ()
    for link in chain:
        owner = f"{link.deck.stem}:"
        own = {key.removeprefix(owner): value for key, value in case.values.items()
               if key.startswith(owner)}
        names += [as_name(key, value) for key, value in own.items()]
        folder = case.folder.parent / "before" / "_".join([link.deck.stem, *names])
        steps.append(Step(link.deck, own, folder, state, before))
        state = link.word(folder)
        before += (steps[-1].own() | {"parameter": link.parameter, "stage": link.stage},)
    own = {key: value for key, value in case.values.items() if ":" not in key}
    return [*steps, Step(pathlib.Path(deck), own, case.folder, state, before)]


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


def state_of(step):
    """finished, stopped (it can be resumed) or new."""
    if read.summary(step.folder).get("finished"):
        return "finished"
    return "stopped" if (step.folder / "latest").is_file() else "new"


def require_same_deck(step):
    """A finished run of another deck, or after other runs before it, would be taken for a result of
    this sweep."""
    stored, now = step.folder / "sweep.json", step.identity()
    if step.folder.is_dir() and state_of(step) != "new":
        found = json.loads(stored.read_text(encoding="utf-8")) if stored.is_file() else {}
        if {"before": [], **found} != now:  # older files do not have the runs before
            raise read.Unreadable(f"{step.folder} holds a run of another deck, of other values or "
                                  "after other runs before it (or does not state them): choose "
                                  "another folder (-o), or remove it")
    write.folder(step.folder)
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


def run(step, trackbed, ranks):
    """Runs or resumes a step; exit code. Ctrl-C lets the run write its checkpoint first."""
    start = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 \
        else []
    words = ["resume", str(step.folder)] if state_of(step) == "stopped" else \
        ["run", str(step.deck), *step.changes(), "--force", "-o", str(step.folder)]
    with open(step.folder / "log.txt", "ab") as log:
        child, asked = begin([*start, str(trackbed), *words], log)
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


def words_of(path):
    """Meaning and unit of a number of summary.json in energy or coupling."""
    group, _, name = path.partition(".")
    words = name.removesuffix("_j").replace("_", " ")
    return f"energy at the end of the run, {words} (J)" if group == "energy" else \
        f"relative error of the {words} between the models (1)"


def numbers_of(folder):
    """Name -> number of a run: those of its figures, and balances and energies of summary.json."""
    found = {}
    every, deck = read.datasets(folder), read.origin(folder)[1]
    kinds = of_deck(deck)
    if "track" in kinds:
        rows = track_figures.numbers_of(folder, every, deck)
        found |= {f"{name} ({unit})": float(value) for name, (value, unit) in rows.items()}
    if "transition" in kinds:
        with contextlib.suppress(read.Unreadable):  # as a bed without a structure, or a short one
            found |= transition.numbers(folder)
    if "train" in kinds:
        rows = train_figures.numbers(train_figures.Passing(read.results(folder), every))
        found |= {f"{name} ({unit})": float(value) for name, (value, unit) in rows.items()}
    summary = flat(read.summary(folder))
    return found | {words_of(name): value for name, value in summary.items()
                    if name.startswith(RESULTS)}


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


def draw(done, quantity, place, stage=""):
    """Mean (line) and range (band) of a curve over the seeds, for each group."""
    figure, panel = plt.subplots(figsize=(9, 5), layout="constrained")
    every = curves.of_runs([case.folder for case in done], quantity, place, stage)
    found = {case.folder: curve for case, curve in zip(done, every)}
    where = every[0].name.partition(", ")[2]
    factor, unit = curves.scale_of(list(found.values()))
    for number, (group, members) in enumerate(grouped(done).items()):
        x = found[members[0].folder].x
        y = factor * np.array([np.interp(x, one.x, one.y)
                               for one in (found[case.folder] for case in members)])
        style = panels.LINES[number % len(panels.LINES)]
        words = f"{label(group)} ({len(members)} runs)"
        line = panel.plot(x, y.mean(axis=0), style, label=words)[0]
        panel.fill_between(x, y.min(axis=0), y.max(axis=0), color=line.get_color(), alpha=0.2, lw=0)
    if quantity.startswith("envelope/"):
        track_along.shade_run_ins(panel, [read.origin(case.folder)[1] for case in done])
    clock = f"time since stage {stage} began, s" if stage else "time, s"
    panel.set(xlabel=clock if every[0].x_unit == "s" else f"x, {every[0].x_unit}",
              ylabel=f"{quantity}, {unit}",
              title=f"{where}; line: mean, band: range over the seeds".removeprefix("; "))
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8)
    return figure


def problems_of(step, words, trackbed):
    """What `check` says about a deck that is not valid, line by line."""
    ran = subprocess.run([str(trackbed), "check", str(step.deck), *words], capture_output=True,
                         text=True, check=False)
    return (ran.stderr.strip() or ran.stdout.strip()).splitlines() if ran.returncode else []


def require_valid(step, trackbed):
    """`check` finds an unknown parameter in seconds. That the run before has not left its state
    yet, which `check` says without the values as well, is no problem."""
    known = problems_of(step, [step.state], trackbed) if step.state else []
    if found := [line for line in problems_of(step, step.changes(), trackbed) if line not in known]:
        raise read.Unreadable(f"{trackbed} check {step.deck} {' '.join(step.words())}: "
                              + "\n".join(found))


def run_all(deck, every, trackbed, ranks, chain=()):
    """Runs the Cases in turn and prints how each ends; (those that are finished, exit code).
    `chain`: Links to the decks before."""
    done = []
    try:
        return done, run_in_turn(deck, every, trackbed, ranks, done, chain)
    except KeyboardInterrupt:  # between two runs
        print("stopped; run the same command again to continue")
        return done, STOPPED


def run_step(step, trackbed, ranks, words, failed):
    """Runs a step unless it is finished and prints how it ends; exit code. `failed`: folders of
    those that did, which are not tried again."""
    require_same_deck(step)
    if state_of(step) == "finished":
        print(f"{words}: already finished, skipped")
        return 0
    if step.folder in failed:
        print(f"{words}: has failed before")
        return read.Unreadable.code
    print(words, flush=True)
    code = run(step, trackbed, ranks)
    if code == STOPPED:
        print(f"{step.folder}: stopped; run the same command again to continue")
    elif code:
        failed.add(step.folder)
        print(f"{step.folder}: ended with code {code}; the reason is in "
              f"{step.folder / 'log.txt'}")
    return code


def needed(case, deck, chain):
    """The Steps of a Case to be run or checked. If the Case is finished, its runs before may have
    been deleted: only those whose folders exist are then returned."""
    steps = steps_of(case, deck, chain)
    return [step for step in steps if step.folder.is_dir()] if state_of(case) == "finished" \
        else steps


def run_in_turn(deck, every, trackbed, ranks, done, chain=()):
    """As run_all; appends finished Cases to `done` and returns the exit code."""
    ending, failed = 0, set()
    for step in steps_of(every[0], deck, chain) if any(
            state_of(case) == "new" for case in every) else ():
        require_valid(step, trackbed)
    for number, case in enumerate(every, 1):
        for step in needed(case, deck, chain):
            code = run_step(step, trackbed, ranks, f"{number} of {len(every)}: {step.folder}",
                            failed)
            if code == STOPPED:
                return STOPPED
            if code:
                ending = read.Unreadable.code
                break
        else:
            done.append(case)
    return ending


def varied_of(vary):
    """{parameter: values} of the options --vary."""
    varied = {key: values for key, *values in vary}
    if len(varied) < len(vary):
        raise read.Unreadable("--vary is given twice for the same parameter; list all its values "
                              "after one --vary")
    if empty := [key for key, values in varied.items() if not values]:
        raise read.Unreadable(f"--vary {empty[0]}: state one value or more after the parameter")
    return varied


def write_results(done, folder, quantity="", place=-1, stage=""):
    numbers = [numbers_of(case.folder) for case in done]
    folder.file("sweep.csv", table_csv(done, numbers))
    if quantity:
        folder.picture(FIGURE, draw(done, quantity, place, stage))
    folder.table("sweep.txt", table_text(done, numbers))
