#!/usr/bin/env python3
"""Killed runs: whatever is killed, and when, the same command continues to the undisturbed result.

    kills.py PROGRAM SOURCE FOLDER [--kills N] [--seed S]

Each trial starts a run with `--or-resume` on 1 to 4 ranks, kills one rank, mpirun or all of them
with SIGKILL after a random time, or ends mpirun with SIGTERM as a queue does, and starts it again
on another number of ranks, until it has been killed five times; then it may finish. The first kill
comes while the run creates its file of results, which takes a few milliseconds. Histories and
state must be bitwise those of an undisturbed run, but for SOLVED of support/results.py. With
implicit steps of the ground the bits depend on the number of ranks: these runs have two.
Checkpoints are written all the time, so that many kills hit one that is being written. The exit
code is 1 if there are findings, whose folders and messages are kept.
"""
import argparse
import collections
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from damaged import RUNS, difference  # noqa: E402
from program import Program  # noqa: E402

# Name, deck, overrides, and the least and largest number of ranks.
KILLED = [(name, deck, words, (1, 4)) for name, deck, words, _ in RUNS]
KILLED += [("implicit", "tests/restart/tiny.toml", ("ground.integrator=newmark",), (2, 2))]
OFTEN = ("output.checkpoint_wall_interval=0.05",)
KILLS_OF_A_RUN = 5
LONGEST = 4.0  # s, from the start of a run to its kill, but not longer than an undisturbed run
CREATION = 0.004  # s, which a file of results takes from its creation until it is complete
PATIENCE = 300  # s
QUEUE_WAITS = 30  # s, from SIGTERM to SIGKILL, as is usual


def ranks_of(process, program):
    """Processes of the program below mpirun, or the process itself on one rank."""
    found, waiting = [], [process.pid]
    while waiting:
        pid = waiting.pop()
        try:
            children = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
            command = pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")[0].decode()
        except OSError:
            continue
        waiting += map(int, children)
        if os.path.abspath(command) == program:
            found.append(pid)
    return found


def kill(process, program, chance, targets=("rank", "mpirun", "all", "queue")):
    """What was killed."""
    ranks = ranks_of(process, program)
    target = chance.choice(targets)
    if target != "queue" and (not ranks or ranks == [process.pid]):
        target = "all"
    if target == "queue":
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(QUEUE_WAITS)
        except subprocess.TimeoutExpired:
            # mpirun may hang if it is ended while it starts ranks (Open MPI 4.1).
            process.kill()
            process.wait(PATIENCE)
        return target
    victims = {"rank": ranks and [chance.choice(ranks)], "mpirun": [process.pid],
               "all": [*ranks, process.pid]}[target]
    for pid in victims:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    process.wait(PATIENCE)
    # Ranks whose mpirun is killed end by themselves; the lock of the folder is theirs until then.
    end = time.monotonic() + 30
    while any(os.path.exists(f"/proc/{pid}") for pid in ranks) and time.monotonic() < end:
        time.sleep(0.02)
    return target


def chosen(names):
    """The runs with these names; without names all."""
    return [run for run in KILLED if not names or run[0] in names]


class Trial:
    """`lasts`: s, of an undisturbed run, by its name."""

    def __init__(self, given, number, lasts):
        self.program, self.chance = Program(given.program), random.Random(f"{given.seed} {number}")
        source, folder = given.source, given.folder
        self.name, deck, words, self.ranks = self.chance.choice(chosen(given.runs))
        self.place, self.whole = folder / f"trial_{number}", folder / "whole" / self.name
        self.longest = min(LONGEST, lasts[self.name])
        self.messages = folder / f"trial_{number}.txt"
        self.command = ["run", source / deck, *words, *OFTEN, "--or-resume", "-o", self.place]
        self.killed = collections.Counter()

    def start(self):
        ranks = self.chance.randint(*self.ranks)
        with open(self.messages, "a", encoding="utf-8") as file:
            print(f"--- {ranks} ranks, after {dict(self.killed)}", file=file, flush=True)
            return subprocess.Popen(self.program.command(ranks, *self.command), stdout=file,
                                    stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                    start_new_session=True)

    def forget(self):
        shutil.rmtree(self.place, ignore_errors=True)
        self.messages.unlink(missing_ok=True)

    def kill_at_creation(self):
        """Kills all ranks when the first file of results appears, or a little later."""
        process, end = self.start(), time.monotonic() + self.longest
        names = ("results.h5", "results.h5.part")
        while process.poll() is None and time.monotonic() < end:
            if any(os.path.exists(self.place / name) for name in names):
                time.sleep(self.chance.uniform(0, CREATION))
                break
        if process.poll() is None:
            kill(process, self.program.path, self.chance, ("all",))
            self.killed["all at creation"] += 1

    def finding(self):
        """What is wrong, or nothing."""
        self.kill_at_creation()
        while sum(self.killed.values()) < KILLS_OF_A_RUN:
            process = self.start()
            try:
                code = process.wait(self.chance.uniform(0, self.longest))
            except subprocess.TimeoutExpired:
                self.killed[kill(process, self.program.path, self.chance)] += 1
                continue
            if code:
                printed = self.messages.read_text("utf-8", errors="replace")
                return f"a run ends with {code}: {printed[printed.rindex('--- '):][-1000:]}"
            break
        ran = self.program(self.chance.randint(*self.ranks), *self.command, timeout=PATIENCE)
        if ran.returncode:
            return f"the last run ends with {ran.returncode}: {ran.stderr[-500:]}"
        return difference(self.whole, self.place)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--runs", nargs="+", default=[], choices=[run[0] for run in KILLED])
    given = parser.parse_args()
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    lasts = {}
    for name, deck, words, ranks in chosen(given.runs):
        begin = time.monotonic()
        Program(given.program).done(ranks[0], "run", given.source / deck, *words, "-o",
                                    given.folder / "whole" / name)
        lasts[name] = time.monotonic() - begin
    killed, runs, findings, number = collections.Counter(), collections.Counter(), 0, 0
    most = given.kills + 5  # trials: a run may end before it is killed
    while sum(killed.values()) < given.kills and number < most and findings < 10:
        trial = Trial(given, number, lasts)
        finding = trial.finding()
        killed.update(trial.killed)
        runs[trial.name] += 1
        number += 1
        print(f"trial {number}, {trial.name}: {sum(killed.values())} kills", flush=True)
        if finding:
            findings += 1
            print(f"{trial.place}: {finding}", flush=True)
        else:
            trial.forget()
    print("\n| killed | times |\n|---|---|")
    for what, count in sorted(killed.items()):
        print(f"| {what} | {count} |")
    print("\n| run | trials |\n|---|---|")
    for name, count in sorted(runs.items()):
        print(f"| {name} | {count} |")
    print(f"| findings | {findings} |")
    few = sum(killed.values()) < given.kills
    if few:
        print(f"only {sum(killed.values())} kills in {number} trials")
    return 1 if findings or few else 0


if __name__ == "__main__":
    sys.exit(main())
