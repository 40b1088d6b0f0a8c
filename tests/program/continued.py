#!/usr/bin/env python3
"""Runs that a queue starts again (`--or-resume`), what `info` tells of a run while it computes and
after its end, checkpoints by wall time, the end of a batch job, and the list of a workstation.

    continued.py PROGRAM SOURCE_FOLDER FOLDER
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import run_checks  # noqa: E402
from program import Program, expect, summary  # noqa: E402

RARE = "output.checkpoint_interval=0"


def lines(folder):
    return [json.loads(line) for line in
            (folder / "progress.jsonl").read_text(encoding="utf-8").splitlines()]


def events(folder):
    return [line["event"] for line in lines(folder)]


def hash_of(folder):
    return summary(folder)["dem"]["state_hash"]


def check_again(program, deck, folder):
    """The same command, until the run is finished."""
    place, again = folder / "again", ["run", deck, "--or-resume"]
    program.done(1, "run", deck, "-o", folder / "whole")
    program.done(1, *again, "output.stop_after=300", "-o", place, code=3)
    stated = program.done(1, "info", place).stdout
    expect(f"{place}: {deck} on 1 rank of " in stated and ", stopped at 20" in stated
           and "last checkpoint: checkpoint_0000000300.h5" in stated, "info of a stopped run",
           program(1, "info", place))
    # Limits of time may differ; they are those of the last command.
    ran = program.done(2, *again, "output.stop_after=1500", "-o", place, code=3)
    expect("continues at" in ran.stdout, "the run must continue", ran)
    ran = program(1, *again, "output.stop_after=0", "stage.load.duration=0.25", "dem.safety=0.21",
                  "-o", place)
    expect(ran.returncode == 2 and "holds a run of another input" in ran.stderr
           and "dem.safety = 0.21" in ran.stderr and "stage[5].duration = 0.25" in ran.stderr,
           "a run of another deck must be refused", ran)
    program.done(1, *again, "-o", place)
    ran = program.done(1, "info", place)
    expect(hash_of(place) == hash_of(folder / "whole"), "the state must be that of one run", ran)
    warnings = summary(place)["warnings"]
    expect(warnings and warnings == [line.removeprefix("  warning: ") for line in
                                     ran.stdout.splitlines() if line.startswith("  warning: ")],
           "info must state all warnings", ran)
    expect(events(place).count("begin") == 3 and lines(place)[-1]["outcome"] == "finished",
           f"events {events(place)}", ran)
    ran = program.done(1, *again, "-o", place)
    expect("the run is already finished" in ran.stdout, "a finished run must be left alone", ran)
    ran = program(1, *again, "--force", "-o", place)
    expect(ran.returncode == 2, "both options at once must be refused", ran)
    # A run that was killed before its first checkpoint begins again.
    for path in place.glob("*.h5"):
        path.unlink()
    (place / "latest").unlink()
    (place / "summary.json").unlink()
    with open(place / "progress.jsonl", "a", encoding="utf-8") as file:
        file.write('{"event":"prog')
    stated = program.done(1, "info", place).stdout
    expect("finished at" in stated, "half a line must be passed over", ran)
    program.done(1, *again, "output.stop_after=20", "-o", place, code=3)
    expect(events(place)[0] == "begin", "the progress of the killed run must be removed", ran)


def check_others(program, deck, folder):
    """A folder with another run or without `latest` loses nothing."""
    place = folder / "other"
    program.done(1, "run", deck, "output.stop_after=300", "-o", place, code=3)
    (place / "latest").unlink()
    kept = sorted(path.name for path in place.glob("*.h5"))
    ran = program(1, "run", deck, "--or-resume", "dem.safety=0.15", "-o", place)
    expect(ran.returncode == 2 and "dem.safety = 0.15" in ran.stderr, "another run", ran)
    expect(sorted(path.name for path in place.glob("*.h5")) == kept, "nothing is removed", ran)
    ran = program.done(1, "run", deck, "--or-resume", "output.stop_after=400", "-o", place, code=3)
    expect("continues at" in ran.stdout, "a checkpoint without an entry is continued", ran)
    for path in place.glob("*_*.h5"):
        path.unlink()
    ran = program(1, "run", deck, "--or-resume", "dem.safety=0.15", "-o", place)
    expect(ran.returncode == 2 and "dem.safety = 0.15" in ran.stderr, "results of another run", ran)
    (place / "results.h5").write_bytes(b"damaged")
    ran = program(1, "run", deck, "--or-resume", "-o", place)
    expect(ran.returncode == 2 and "results.h5" in ran.stderr, "results that are damaged", ran)


def check_track(program, deck, folder):
    """A track has no checkpoint when it is finished."""
    place = folder / "track"
    deck = deck.parents[2] / "inputs" / "track" / "plain.toml"
    command = ["run", deck, "passage.duration=0.1", "--or-resume", "-o", place]
    program.done(1, *command)
    ran = program.done(1, *command)
    expect("the run is already finished" in ran.stdout, "a finished track must be left alone", ran)
    ran = program(1, *command, "train.speed=30")
    expect(ran.returncode == 2 and "train.speed = 30" in ran.stderr, "another track", ran)
    ran = program(1, *command, "passage.duration=0.2")
    expect(ran.returncode == 2 and "passage.duration=0.2" in ran.stderr, "no checkpoint", ran)
    often = ["output.checkpoint_interval=0.05", "--or-resume", "-o", folder / "longer"]
    program.done(1, "run", deck, "passage.duration=0.1", *often)
    ran = program.done(1, "run", deck, "passage.duration=0.2", *often)
    expect(abs(summary(folder / "longer")["simulated_time_s"] - 0.2) < 1e-3, "a longer one", ran)
    (folder / "longer" / "progress.jsonl").write_text(
        '{"event":"begin","unix_time_s":1e300,"ranks":"x"}\n{"event":"end","outcome":1}\n',
        encoding="utf-8")
    program.done(1, "info", folder / "longer")


def check_while_computing(program, deck, folder):
    """`info` of a run that computes, and after it was killed."""
    place = folder / "computing"
    with subprocess.Popen(
            program.command(1, "run", deck, "output.checkpoint_wall_interval=0.2", RARE,
                            "stage.load.duration=100", "stage.load.settlement=0", "-o", place),
            stdout=subprocess.DEVNULL) as running:
        try:
            end = time.monotonic() + 60
            while not (place / "progress.jsonl").is_file() or not any(
                    line["event"] == "progress" for line in lines(place)):
                if running.poll() is not None or time.monotonic() > end:
                    raise SystemExit("no progress is written")
                time.sleep(0.05)
            stated = program(1, "info", place)
            expect(" computing since 20" in stated.stdout and "remaining " in stated.stdout
                   and "unbalanced " in stated.stdout, "info of a run that computes", stated)
        finally:
            running.send_signal(signal.SIGKILL)
    ran = program(1, "info", place)
    expect("was killed after 20" in ran.stdout, "info of a killed run", ran)
    last = lines(place)[-1]
    kept = [line for line in lines(place) if line["event"] == "checkpoint"]
    expect(len([line for line in kept if line["file"].startswith("checkpoint")]) >= 5,
           f"a checkpoint every 0.2 s of wall time until {last}: {kept}", ran)
    expect(len(list(place.glob("checkpoint_*.h5"))) <= 3, "older ones must be removed", ran)


def check_end_of_job(program, deck, folder):
    """A run stops a minute before its batch job ends."""
    for name in ("TRACKBED_END_TIME", "SLURM_JOB_END_TIME"):
        for left, code in ((59, 3), (3600, 0)):
            os.environ[name] = str(int(time.time()) + left)
            ran = program.done(1, "run", deck, "--force", "-o", folder / "job", code=code)
            expect((folder / "job" / "latest").is_file(), "a checkpoint is needed", ran)
        # A time that is none, or is over: refused if it is our own variable, otherwise no limit.
        for wrong in ("tomorrow", "1000"):
            os.environ[name] = wrong
            ran = program(1, "run", deck, "output.stop_after=5", "--force", "-o", folder / "job")
            expect(ran.returncode == (2 if name.startswith("TRACKBED") else 3), wrong, ran)
        del os.environ[name]


def check_list(program, deck, folder):
    """jobs/workstation.py: runs side by side, a failure, and the same again."""
    script = deck.parents[2] / "jobs" / "workstation.py"
    path = folder / "list.txt"

    def call(text):
        path.write_text(text, encoding="utf-8")
        return subprocess.run([sys.executable, script, program.path, path, "--cores", "2"],
                              capture_output=True, text=True, check=False, cwd=folder)
    ran = call(f"1 {deck} list/a  # the first\n\n2 '{deck}' list/b dem.safety=0.2\n1 none c\n")
    expect(ran.returncode == 2 and "2 of 3 runs are finished" in ran.stdout
           and "c (line 4): exit code 2" in ran.stderr, "a list with a bad deck", ran)
    expect(all(summary(folder / "list" / name)["finished"] for name in "ab"), "finished runs", ran)
    when = (folder / "list" / "a" / "results.h5").stat().st_mtime_ns
    ran = call(f"1 {deck} list/a\n")
    expect(ran.returncode == 0 and when == (folder / "list/a/results.h5").stat().st_mtime_ns,
           "a finished run must be left alone", ran)
    ran = call(f"0 {deck} x\n1 {deck} a\n1 {deck} ./a\n1 'x\n")
    expect(ran.returncode == 2 and ran.stderr.count("list.txt:") == 3, "all problems at once", ran)


def main():
    program, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    deck = pathlib.Path(sys.argv[2]).resolve() / "tests" / "restart" / "tiny.toml"
    run_checks([check_again, check_track, check_others, check_while_computing, check_end_of_job,
                check_list],
               program, deck, folder)


if __name__ == "__main__":
    main()
