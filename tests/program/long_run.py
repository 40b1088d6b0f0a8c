#!/usr/bin/env python3
"""A train of wagons over 60 sleepers, a million sub-steps of stones, through jobs/slurm.sh in a
queue of Debian's Slurm: interrupted five times and continued on two ranks or one. The end is
bitwise that of an undisturbed run on two ranks.

    long_run.py PROGRAM SOURCE_FOLDER FOLDER [key=value...]

Values shorten the run for a try. Needs what slurm.py needs. Prints a table. The same command again
uses the undisturbed run that is in FOLDER.
"""
import json
import pathlib
import random
import shutil
import subprocess
import sys
import time

SOURCE = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(SOURCE / "support"), str(SOURCE / "faults")]
from damaged import difference  # noqa: E402
from program import Program, summary  # noqa: E402
from slurm import Queue, called, slurm, wait_for  # noqa: E402

DECK = "inputs/track/sixty_sleepers.toml"
PATIENCE = 4 * 3600  # s
# Each interruption, and the number of ranks with which the run continues.
INTERRUPTIONS = (("the time of the job ends", 2), ("all ranks are killed", 2),
                 ("the job is cancelled", 1), ("the time of the job ends", 1),
                 ("the job is cancelled", 2))


def done_windows(place):
    """Of the run, by its last line of progress; 0 before the first."""
    path = place / "progress.jsonl"
    if not path.is_file():
        return 0
    lines = path.read_text(encoding="utf-8").splitlines()
    return json.loads(lines[-1]).get("windows_of_run", 0) if lines else 0


class Interrupted:
    """The run in the queue."""

    def __init__(self, queue, place, words):
        self.queue, self.place, self.words = queue, place, words
        self.job = self.submitted(2)

    def submitted(self, ranks):
        return self.queue.submitted(DECK, self.place, "output.checkpoint_wall_interval=60",
                                    *self.words, ranks=ranks, options=("-t", "1-0"))

    def wait_until(self, window):
        def there():
            if not self.queue.state(self.job):
                raise SystemExit(f"job {self.job} has ended early: {self.queue.log(self.job)}")
            return done_windows(self.place) >= window and (self.place / "latest").is_file()
        wait_for(there, PATIENCE, f"window {window}")

    def interrupt(self, how, ranks):
        """Only a job that is submitted again can have other ranks."""
        if how == "the job is cancelled":
            called("scancel", self.job)
            wait_for(lambda: not self.queue.state(self.job), 120, "the end of a cancelled job")
            self.job = self.submitted(ranks)
        elif how == "all ranks are killed":
            called("scontrol", "requeue", self.job)
            self.start()
        else:
            called("scancel", "--signal=USR1", "--batch", self.job)
            wait_for(lambda: "PENDING" in self.queue.state(self.job), 120,
                     f"job {self.job} back in the queue")
            self.start()

    def start(self):
        """At once instead of after two minutes."""
        def runs():
            subprocess.run(["scontrol", "update", f"jobid={self.job}", "StartTime=now"],
                           check=False, capture_output=True)
            time.sleep(2)
            return "RUNNING" in self.queue.state(self.job)
        wait_for(runs, 240, f"job {self.job} running again")


def main():
    program, source, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2]), pathlib.Path(
        sys.argv[3]).resolve()
    words = sys.argv[4:]
    for name in ("parts", "slurm"):
        shutil.rmtree(folder / name, ignore_errors=True)
    folder.mkdir(parents=True, exist_ok=True)
    program.done(2, "run", source / "inputs" / "quickstart_cell.toml", "-o", folder / "cell",
                 "--or-resume")
    words = [f"bed.cell={folder / 'cell'}", *words]
    begin = time.monotonic()
    program.done(2, "run", source / DECK, "-o", folder / "whole", "--or-resume", *words)
    whole, took = summary(folder / "whole"), time.monotonic() - begin
    print(f"undisturbed: {whole['dem']['steps']} sub-steps in {took:.0f} s", flush=True)
    chance = random.Random(1)
    windows = sorted(chance.sample(range(whole["windows"] // 20, whole["windows"] * 19 // 20),
                                   len(INTERRUPTIONS)))
    rows = []
    with slurm(folder / "slurm"):
        run = Interrupted(Queue(program, source, folder), folder / "parts", words)
        for window, (how, ranks) in zip(windows, INTERRUPTIONS):
            run.wait_until(window)
            rows.append(f"| {done_windows(folder / 'parts')} | {how} | {ranks} |")
            print(rows[-1], flush=True)
            run.interrupt(how, ranks)
        wait_for(lambda: not run.queue.state(run.job), PATIENCE, "the end of the run")
        if not (folder / "parts" / "summary.json").is_file():
            raise SystemExit(f"the run did not finish: {run.queue.log(run.job)}")
    finding = difference(folder / "whole", folder / "parts")
    print("\n| window | interruption | ranks after it |\n|---|---|---|")
    print("\n".join(rows))
    print(f"\n{whole['dem']['steps']} sub-steps of {whole['dem']['particles']} stones: "
          f"{finding or 'bitwise identical'}")
    return 1 if finding else 0


if __name__ == "__main__":
    sys.exit(main())
