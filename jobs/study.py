#!/usr/bin/env python3
"""Repeats a published study and compares it with the publication, target by target.

    study.py PROGRAM NAME short|full FOLDER    runs, then numbers, figures and document in FOLDER
    study.py PROGRAM NAME full FOLDER --others PLACE --only PREFIX ...
                                               the same, but only runs with these prefixes and
                                               those they need are repeated: the numbers of the
                                               others are those in PLACE
    study.py --document NAME FOLDER            the document again, from numbers.csv and lines.csv

Finished runs in FOLDER are kept, a stopped run is resumed; a run of another program, deck or list
of changes, or after another such run, is replaced. The exit code is 1 if a hard or main
target has the wrong sign, otherwise that of trackbed.
"""
import argparse
import functools
import hashlib
import importlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time
import tomllib

import launch
from studies.study import INPUTS, Lines, Numbers, counted, read, reflowed, targets_table

STUDIES = ("netirail", "shi", "demfem", "chen", "crossing")
WRONG_SIGN = 1
VERSION_OF = "version of "  # a run or PREFIX*, in the head of numbers.csv
HEAD = """# {title}
<!-- made by jobs/study.py from numbers.csv -->
{source}
{summary}
`{command}` repeats it: {runs} runs, whose wall times add up to {minutes:.0f} minutes, on {cores}.
Numbers are those of [numbers.csv](numbers.csv) ({version}).

## Targets
{counted} Hard targets are those that must hold, main ones the message of the study, soft ones
values to compare. {criterion}

{targets}"""


def state_of(place):
    """finished, stopped (it can be resumed) or new."""
    try:
        if json.loads((place / "summary.json").read_text(encoding="utf-8"))["finished"]:
            return "finished"
    except (OSError, ValueError, KeyError):
        pass
    return "stopped" if (place / "latest").is_file() else "new"


class Key:
    """What the results of a Run depend on, as text: program, deck, changes, runs it starts from."""

    def __init__(self, program, runs, folder):
        self.program = hashlib.sha256(pathlib.Path(program).read_bytes()).hexdigest()
        self.runs = {run.name: run for run in runs}
        self.folder = folder.resolve()

    def changes(self, run):
        return [word.replace("{folder}", str(self.folder)).replace("{inputs}", str(INPUTS))
                for word in run.words]

    def before(self, run):
        """Names of the runs it starts from."""
        return sorted({name for word in run.words
                       for name in re.findall(r"\{folder\}/(\w+)", word)} & self.runs.keys())

    def files(self, run, deck):
        """Hashes of the files that its words and its deck name."""
        found = {(self.folder if place == "{folder}" else INPUTS) / name for word in run.words
                 for place, name in re.findall(r"(\{folder\}|\{inputs\})/([\w/.]+)", word)
                 if name.split("/")[0] not in self.runs}
        found |= {(INPUTS / run.deck).parent / name
                  for name in re.findall(r'"([\w/.]+\.csv)"', deck)}
        return [hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(found)
                if path.is_file()]

    def of(self, run):
        with open(INPUTS / run.deck, "rb") as file:
            deck = json.dumps(tomllib.load(file))  # whatever its comments
        return "\n".join([self.program, *run.words, deck, *self.files(run, deck),
                          *(self.of(self.runs[name]) for name in self.before(run))])


def do(program, key, run, folder):
    """Runs, resumes or keeps a Run."""
    place, kept = folder / run.name, folder / f"{run.name}.key"
    same = kept.is_file() and kept.read_text(encoding="utf-8") == key.of(run)
    state = state_of(place) if same else "new"
    if state == "finished":
        print(f"{run.name}: kept", flush=True)
        return
    command = ["resume", place]
    if state == "new":
        for old in (kept, place / "summary.json", place / "latest"):
            old.unlink(missing_ok=True)  # or a run that is refused would leave old results
        kept.write_text(key.of(run), encoding="utf-8")
        command = ["run", INPUTS / run.deck, *key.changes(run), "--force", "-o", place]
    begin = time.monotonic()
    ran = launch.run(launch.on_ranks(run.ranks, program, *command),
                     "the same command continues the study", stdout=subprocess.PIPE,
                     stderr=subprocess.PIPE, text=True)
    if ran.returncode:
        launch.fail(ran, run.name)
    print(f"{run.name}: {time.monotonic() - begin:.1f} s", flush=True)


def version_of(program):
    """First two lines of trackbed --version."""
    try:
        lines = subprocess.run([program, "--version"], capture_output=True, text=True,
                               check=True).stdout.splitlines()
        return f"{lines[0]}, {lines[1].partition(';')[0]}"
    except OSError as error:
        launch.refuse(f"{error.filename}: {error.strerror}")
    except (subprocess.CalledProcessError, IndexError):
        launch.refuse(f"{program} does not state a version: it is not trackbed")


def document_of(name, numbers):
    """The document as Markdown."""
    study, text = study_of(name), importlib.import_module(f"studies.{name}_document")
    times = [value for (_, quantity), (value, _) in numbers.rows.items()
             if quantity == "wall_time"]
    summary = text.summary(numbers) if hasattr(text, "summary") else ""
    targets, criterion = study.targets(numbers), text.CRITERION
    head = HEAD.format(title=text.TITLE, source=text.SOURCE, summary=summary,
                       criterion=criterion(numbers) if callable(criterion) else criterion,
                       command=numbers.about["command"], runs=len(times), minutes=sum(times) / 60,
                       cores=numbers.about["machine"], version=versions(numbers.about),
                       counted=counted(targets),
                       targets=targets_table(targets))
    return reflowed(head + text.document(numbers))


def derive(name, numbers):
    """Adds the numbers that a study computes from its lines."""
    study = study_of(name)
    if hasattr(study, "derive"):
        study.derive(numbers)


def write_document(name, folder):
    study_of(name)
    try:
        numbers, lines = Numbers.read(folder / "numbers.csv"), Lines.read(folder / "lines.csv")
        numbers.lines = lines
        derive(name, numbers)
        text = document_of(name, numbers)
    except OSError as error:
        launch.refuse(f"{error.filename}: {error.strerror}")
    except (KeyError, ValueError) as error:
        launch.refuse(f"{folder}: numbers.csv and lines.csv are not those of {name} "
                      f"({type(error).__name__}: {error})")
    (folder / "README.md").write_text(text, encoding="utf-8")
    importlib.import_module(f"studies.{name}_document").figures(numbers, lines, folder)


def study_of(name):
    if name not in STUDIES:
        launch.refuse(f'"{name}" is no study; these are: {", ".join(STUDIES)}')
    return importlib.import_module(f"studies.{name}")


def machine():
    """Processor and number of cores."""
    names = [line.partition(":")[2].strip()
             for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
             if line.startswith("model name")]
    return f"{len(names)} cores of {names[0]}" if names else "an unknown processor"


def versions(about):
    """Of the program of all runs, and of those that were repeated later."""
    later = {}
    for key, version in about.items():
        if key.startswith(VERSION_OF):
            later.setdefault(version, []).append(f"`{key.removeprefix(VERSION_OF)}`")
    return "; ".join([about["version"], *(f"runs {', '.join(prefixes)}: {version}"
                                          for version, prefixes in later.items())])


class Selection:
    """Runs whose names begin with one of the prefixes, and those they need; the numbers of all
    other runs are those in the folder `others`."""

    def __init__(self, prefixes=("",), others=None):
        self.prefixes, self.others = tuple(prefixes), others
        self.kept = Numbers({}), Lines()

    def check(self, study, form, runs):
        """Refuses what cannot be done, before anything runs."""
        if self.others is None:
            return
        if not hasattr(study, "measure_runs"):
            launch.refuse("this study measures all of its runs together: leave out --only and "
                          "--others")
        if form != "full":
            launch.refuse("--only and --others are for the full form")
        for prefix in self.prefixes:
            if not any(run.name.startswith(prefix) for run in runs):
                launch.refuse(f'no run has a name that begins with "{prefix}"; the runs are: '
                              f'{", ".join(run.name for run in runs)}')
        try:
            self.kept = (Numbers.read(self.others / "numbers.csv"),
                         Lines.read(self.others / "lines.csv"))
        except OSError as error:
            launch.refuse(f"{error.filename}: {error.strerror}")
        except (KeyError, ValueError) as error:
            launch.refuse(f"{self.others}: numbers.csv and lines.csv cannot be read "
                          f"({type(error).__name__}: {error})")

    def runs(self, runs, needed):
        """Those of the runs that take place; `needed`: names of earlier ones that a run needs."""
        names = {run.name for run in runs if run.name.startswith(self.prefixes)}
        for run in reversed(runs):
            if run.name in names:
                names |= set(needed(run))
        return [run for run in runs if run.name in names]

    def begin(self, about, runs):
        """Numbers and lines without those of these runs, which are measured again."""
        if self.others is None:
            return Numbers(about), Lines()
        numbers, lines = self.kept
        names = {run.name for run in runs}
        for kept, name in ((numbers, 0), (lines, 1)):
            kept.rows = {key: row for key, row in kept.rows.items() if key[name] not in names
                         and not key[name].startswith(self.prefixes)}
        more = (run.name for run in runs if not run.name.startswith(self.prefixes))
        numbers.about |= {f"{VERSION_OF}{name}": about["version"]
                          for name in (*(f"{prefix}*" for prefix in self.prefixes), *more)}
        return numbers, lines


def repeat(program, name, form, folder, selection):
    """Runs a study and writes numbers, figures and document; the targets with a wrong sign."""
    study, version = study_of(name), version_of(program)
    ranks = launch.requested_ranks()
    runs = study.runs(form, ranks)
    selection.check(study, form, runs)
    launch.make_folder(folder)
    if not os.access(folder, os.W_OK):
        launch.refuse(f"{folder}: permission denied")
    if hasattr(study, "prepare"):
        study.prepare(program, folder)
    key = Key(program, runs, folder)
    beside = getattr(study, "beside", lambda run: ())
    runs = selection.runs(runs, lambda run: [*key.before(run), *beside(run)])
    launch.together([(run.name, key.before(run), run.ranks,
                      functools.partial(do, program, key, run, folder)) for run in runs], ranks)
    numbers, lines = selection.begin({"version": version, "machine": machine(),
                                      "command": f"jobs/study.sh {name} {form}"}, runs)
    numbers.lines = lines
    try:
        if selection.others:
            study.measure_runs(runs, folder, numbers, lines)
        else:
            study.measure(form, folder, numbers, lines)
        derive(name, numbers)
    except (read.Unreadable, OSError, KeyError, ValueError) as error:
        print(f"the results in {folder} cannot be measured ({type(error).__name__}: {error})",
              file=sys.stderr)
        sys.exit(launch.FAILED)
    (folder / "numbers.csv").write_text(numbers.text(), encoding="utf-8")
    (folder / "lines.csv").write_text(lines.text(), encoding="utf-8")
    write_document(name, folder)
    targets = study.targets(numbers)
    print(targets_table(targets), end="")
    print(f"document: {folder / 'README.md'}")
    return wrong(targets)


def wrong(targets):
    """Hard and main targets whose value has not the published sign."""
    return [target.what for target in targets
            if target.kind in ("hard", "main") and target.sign is not None and not target.sign]


def main():
    if sys.argv[1:2] == ["--document"] and len(sys.argv) == 4:
        write_document(sys.argv[2], pathlib.Path(sys.argv[3]))
        return 0
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0],
                                     epilog="--document NAME FOLDER makes the document again.")
    parser.add_argument("program", type=launch.program)
    parser.add_argument("name", help=", ".join(STUDIES))
    parser.add_argument("form", choices=("short", "full"))
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--others", metavar="PLACE", type=pathlib.Path,
                        help="folder with numbers.csv and lines.csv of all runs")
    parser.add_argument("--only", metavar="PREFIX", nargs="+",
                        help="begin of the names of runs to repeat; the others keep their numbers")
    given = parser.parse_args()
    if bool(given.only) != bool(given.others):
        parser.error("--only and --others belong together")
    selection = Selection(given.only, given.others) if given.only else Selection()
    found = repeat(given.program, given.name, given.form, given.folder, selection)
    for what in found:
        print(f"wrong sign: {what}", file=sys.stderr)
    return WRONG_SIGN if found else 0


if __name__ == "__main__":
    sys.exit(main())
