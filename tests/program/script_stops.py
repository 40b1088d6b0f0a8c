#!/usr/bin/env python3
"""Scripts of jobs/ that receive a signal to stop: each of their runs writes its checkpoint and ends
before the script, with code 3; the hand-over loop continues to the same results.

    script_stops.py PROGRAM SOURCE_FOLDER FOLDER
"""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import run_checks  # noqa: E402
from program import Program  # noqa: E402

# A bed on which the support of each sleeper can be measured: four of four seeds; with less
# compaction two of three.
SHORT = ["stage.fill.duration=0.3", "stage.compact.duration=0.6", "stage.release.duration=0.02",
         "stage.sleepers.duration=0.05", "stage.bed_in.duration=0.15", "stage.bed_in.cycles=3"]


def left(folder):
    """(Command line, caught signals) of processes whose arguments are in the folder."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            status = (process / "status").read_text(encoding="utf-8")
        except OSError:
            continue  # has ended in the meantime
        if f"{folder}/" in words:
            found.append((words, int(re.search(r"SigCgt:\s*(\w+)", status)[1], 16)))
    return found


def wait_for(holds, running, what):
    end = time.monotonic() + 120
    while not holds():
        if running.poll() is not None or time.monotonic() > end:
            out, err = running.communicate(timeout=10)
            raise SystemExit(f"{what}: code {running.returncode}\n{out}{err}")
        time.sleep(0.02)


def stopped(command, folder, numbers, begun, environment=None):
    """Runs `command`, sends the signals as soon as `begun()`, and requires that the script ends
    with 3 and its message after all processes that it has started. Returns its stderr."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env=environment, start_new_session=True, preexec_fn=lambda:
                          signal.signal(signal.SIGINT, signal.SIG_DFL)) as running:
        try:
            wait_for(begun, running, f"{command} before the signal")
            for number in numbers:
                os.kill(running.pid, number)
            out, err = running.communicate(timeout=120)
        finally:
            running.kill()
    if running.returncode != 3 or not err.startswith("stopped; the same command") or \
            "Traceback" in err:
        raise SystemExit(f"signals {numbers}: code {running.returncode}\n{out}{err}")
    if processes := left(folder):
        raise SystemExit(f"signals {numbers} left {list(processes)}")
    return err


def listen(program, ranks, place):
    """Returns a test whether all ranks of the run in `place` catch the signal to stop."""
    def holds():
        caught = [caught for words, caught in left(place.parent)
                  if words.startswith(f"{program} ") and f"{place}" in words]
        return len(caught) == ranks and all(one & 1 << (signal.SIGUSR1 - 1) for one in caught)
    return holds


def last_checkpoint(place):
    """Its name, which comes first in `latest`."""
    latest = place / "latest"
    names = latest.read_text(encoding="utf-8").split() if latest.is_file() else []
    return names[0] if names else ""


def check_loop(program, source, folder):
    """The loop is stopped in the load test, during a train, and before its run has begun."""
    deck = source / "inputs/track/on_bed.toml"
    Program(program).done(2, "run", deck, *SHORT, "-o", folder / "bed")

    def command(place):
        return [sys.executable, source / "jobs/handover.py", program, deck, place, "--start",
                folder / "bed/stage_bed_in.h5", "--rounds", "1", "--trains", "1"]
    whole, parts = folder / "whole", folder / "parts"
    subprocess.run(command(whole), check=True)
    load_test, trains = parts / "round_0/load_test", parts / "round_0/trains"
    for place, numbers in ((load_test, [signal.SIGTERM]), (load_test, [signal.SIGHUP]),
                           (trains, [signal.SIGINT, signal.SIGINT])):
        before = last_checkpoint(place)
        stopped(command(parts), folder, numbers, listen(program, 2, place))
        if last_checkpoint(place) in ("", before):
            raise SystemExit(f"{numbers}: {place} has no new checkpoint: {list(place.glob('*'))}")
    ran = subprocess.run(command(parts), capture_output=True, text=True, check=False)
    if ran.returncode or (parts / "handover.csv").read_bytes() != \
            (whole / "handover.csv").read_bytes():
        raise SystemExit(f"the continued loop has other results: {ran.stdout}{ran.stderr}")


def check_early(program, source, folder):
    """A run that gets the signal before its handler is set ends without a checkpoint, as does its
    script."""
    command = [sys.executable, source / "jobs/handover.py", program,
               source / "inputs/track/on_bed.toml", folder / "early"]
    log = folder / "early/bed.log"
    stopped(command, folder, [signal.SIGTERM], log.is_file)
    if (folder / "early/bed/stage_fill.h5").exists():
        raise SystemExit("a run stopped before its first stage must not finish that stage")
    log.unlink()
    # Of an earlier loop, which --force is to remove.
    later = folder / "early/round_0/load_test/summary.json"
    later.parent.mkdir(parents=True)
    later.write_text("{}", encoding="utf-8")
    err = stopped([*command, "--force"], folder, [signal.SIGTERM], log.is_file)
    if "without --force" not in err:
        raise SystemExit(f"the message must recommend the command without --force: {err}")
    if later.exists():
        raise SystemExit("rounds of the old loop must be removed")


def check_shell(program, source, folder):
    """run_model of the shell scripts, also before its run has set the signal handler."""
    place, root = folder / "shell", folder / "project"
    (root / "jobs").mkdir(parents=True)
    (root / "build/release").mkdir(parents=True)
    shutil.copy(source / "jobs/common.sh", root / "jobs")
    (root / "build/release/trackbed").symlink_to(program)
    words = f"source {root}/jobs/common.sh; run_model {source}/inputs/track/on_bed.toml {place}"
    for begun in (lambda: any(words.startswith("mpirun ") for words, _ in left(folder)),
                  listen("build/release/trackbed", 2, place)):
        shutil.rmtree(place, ignore_errors=True)
        with subprocess.Popen(["bash", "-c", words], stdout=subprocess.DEVNULL) as running:
            wait_for(begun, running, words)
            running.terminate()
            code = running.wait(timeout=120)
        time.sleep(1.5)  # the loop that repeats the signal ends by itself
        if code == 0 or (place / "stage_fill.h5").exists() or left(folder):
            raise SystemExit(f"run_model after a signal to stop: code {code}, {left(folder)}")
    if code != 3 or not last_checkpoint(place):
        raise SystemExit(f"run_model must end with 3 and a checkpoint, not with {code}")


def check_alone(program, source, folder):
    """A run without mpirun."""
    place = folder / "heaps"
    command = [sys.executable, source / "jobs/strength.py", program, place, "heap", "--rows",
               "deck", "--seeds", "1"]
    result = place / "deck_1"
    stopped(command, folder, [signal.SIGTERM], listen(program, 1, result))
    if not last_checkpoint(result):
        raise SystemExit(f"{result} has no checkpoint: {list(result.glob('*'))}")


def check_study(program, source, folder):
    """A study is continued where it was stopped."""
    place = folder / "study"
    command = [sys.executable, source / "jobs/study.py", program, "netirail", "short", place]
    result = place / "space_layers"
    begun = listen(program, 2, result)
    steps = []
    for _ in range(2):
        stopped(command, folder, [signal.SIGTERM], begun)
        checkpoint = last_checkpoint(result)
        if not checkpoint or not (result / checkpoint).is_file():
            raise SystemExit(f"{result} has no checkpoint: {list(result.glob('*'))}")
        steps.append(int(re.search(r"\d+", checkpoint)[0]))
    # Begun again, the second run would have taken about as many steps as the first one.
    if steps[1] <= steps[0] or len(list(result.glob("checkpoint_*.h5"))) < 2:
        raise SystemExit(f"{result} was stopped at {steps}, so it was not resumed")


def main():
    program, source, folder = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    run_checks((check_shell, check_early, check_loop, check_alone, check_study), program, source,
               folder)


if __name__ == "__main__":
    main()
