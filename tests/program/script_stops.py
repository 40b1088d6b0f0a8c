#!/usr/bin/env python3
"""Scripts of jobs/ that are told to stop: each run of theirs writes its checkpoint and ends before
they do, with code 3; the hand-over loop goes on to the same figures.

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
from program import Program  # noqa: E402

# A bed on which each sleeper can be weighed: four of four seeds; with less work two of three.
SHORT = ["stage.fill.duration=0.3", "stage.compact.duration=0.6", "stage.release.duration=0.02",
         "stage.sleepers.duration=0.05", "stage.bed_in.duration=0.15", "stage.bed_in.cycles=3"]


def left(folder):
    """(Command line, signals it catches) of processes that name what is in the folder."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            status = (process / "status").read_text(encoding="utf-8")
        except OSError:
            continue  # ended meanwhile
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
    """Runs `command`, sends the signals as soon as `begun()`, and wants the script to end with 3
    and its sentence, all that it has started before it. What it said."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env=environment, start_new_session=True, preexec_fn=lambda:
                          signal.signal(signal.SIGINT, signal.SIG_DFL)) as running:
        try:
            wait_for(begun, running, f"{command} before it was told")
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
    """Whether all ranks of the run in `place` can be told to stop."""
    def holds():
        caught = [caught for words, caught in left(place.parent)
                  if words.startswith(f"{program} ") and f"{place}" in words]
        return len(caught) == ranks and all(one & 1 << (signal.SIGUSR1 - 1) for one in caught)
    return holds


def last_checkpoint(place):
    latest = place / "latest"
    return latest.read_text(encoding="utf-8") if latest.is_file() else ""


def check_loop(program, source, folder):
    """Stopped while it weighs, by a train over the bed, and before its run has begun."""
    deck = source / "inputs/track/on_bed.toml"
    Program(program).done(2, "run", deck, *SHORT, "-o", folder / "bed")

    def command(place):
        return [sys.executable, source / "jobs/handover.py", program, deck, place, "--start",
                folder / "bed/stage_bed_in.h5", "--rounds", "1", "--trains", "1"]
    whole, parts = folder / "whole", folder / "parts"
    subprocess.run(command(whole), check=True)
    weigh, trains = parts / "round_0/weigh", parts / "round_0/trains"
    for place, numbers in ((weigh, [signal.SIGTERM]), (weigh, [signal.SIGHUP]),
                           (trains, [signal.SIGINT, signal.SIGINT])):
        before = last_checkpoint(place)
        stopped(command(parts), folder, numbers, listen(program, 2, place))
        if last_checkpoint(place) in ("", before):
            raise SystemExit(f"{numbers}: {place} has no new checkpoint: {list(place.glob('*'))}")
    ran = subprocess.run(command(parts), capture_output=True, text=True, check=False)
    if ran.returncode or (parts / "handover.csv").read_bytes() != \
            (whole / "handover.csv").read_bytes():
        raise SystemExit(f"the loop goes on to other figures: {ran.stdout}{ran.stderr}")


def check_early(program, source, folder):
    """A run that is told before it listens has no checkpoint, but ends; so does its script."""
    command = [sys.executable, source / "jobs/handover.py", program,
               source / "inputs/track/on_bed.toml", folder / "early"]
    log = folder / "early/bed.log"
    stopped(command, folder, [signal.SIGTERM], log.is_file)
    if (folder / "early/bed/stage_fill.h5").exists():
        raise SystemExit("a run that was told before its first stage has made it all the same")
    log.unlink()
    later = folder / "early/round_0/weigh/summary.json"  # of a loop that --force is to begin anew
    later.parent.mkdir(parents=True)
    later.write_text("{}", encoding="utf-8")
    err = stopped([*command, "--force"], folder, [signal.SIGTERM], log.is_file)
    if "without --force" not in err:
        raise SystemExit(f"with --force the same command begins anew: {err}")
    if later.exists():
        raise SystemExit("rounds of the old loop would stop the command that goes on")


def check_shell(program, source, folder):
    """run_model of the shell scripts, also before its run can listen."""
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
        time.sleep(1.5)  # what tells it again each second ends by itself
        if code == 0 or (place / "stage_fill.h5").exists() or left(folder):
            raise SystemExit(f"run_model told to stop: code {code}, {left(folder)}")
    if code != 3 or not last_checkpoint(place):
        raise SystemExit(f"run_model must end with 3 and a checkpoint, not with {code}")


def check_alone(program, source, folder):
    """A run without mpirun."""
    place = folder / "masses"
    command = [sys.executable, source / "jobs/sleeper_mass.py", program, place, "--masses", "1"]
    result = place / "original_1.0"
    stopped(command, folder, [signal.SIGTERM], listen(program, 1, result))
    if not last_checkpoint(result):
        raise SystemExit(f"{result} has no checkpoint: {list(result.glob('*'))}")


def main():
    program, source, folder = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_early(program, source, folder)
    check_shell(program, source, folder)
    check_alone(program, source, folder)
    check_loop(program, source, folder)


if __name__ == "__main__":
    main()
