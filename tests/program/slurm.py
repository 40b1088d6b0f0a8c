#!/usr/bin/env python3
"""jobs/slurm.sh in a queue of Debian's Slurm, started on this machine for the test: a job that is
stopped and goes back into the queue until it is finished, one that is cancelled and submitted
again, one whose node fails, and an array over the rows of a table.

    slurm.py PROGRAM SOURCE_FOLDER FOLDER

Needs root, munge, slurmctld, slurmd and slurm-client.
"""
import contextlib
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
import results  # noqa: E402, F401  # finds trackbed_post
from trackbed_post import read  # noqa: E402

CONFIGURATION = """ClusterName=trackbed
SlurmctldHost={host}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
StateSaveLocation={place}/state
SlurmdSpoolDir={place}/spool
SlurmctldPidFile={place}/slurmctld.pid
SlurmdPidFile={place}/slurmd.pid
SlurmctldLogFile={place}/slurmctld.log
SlurmdLogFile={place}/slurmd.log
SlurmctldPort=16817
SlurmdPort=16818
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
JobRequeue=1
SchedulerParameters=batch_sched_delay=0
MpiDefault=none
NodeName={host} CPUs=4 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""
ENDED = ("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT")
SLOW = ("output.checkpoint_interval=0", "output.checkpoint_wall_interval=1")


def called(*words, **how):
    return subprocess.run(list(map(str, words)), check=True, capture_output=True, text=True,
                          **how).stdout


@contextlib.contextmanager
def slurm(place):
    """A controller and a node on this machine."""
    for name in ("state", "spool"):
        (place / name).mkdir(parents=True)
    configuration = place / "slurm.conf"
    configuration.write_text(CONFIGURATION.format(
        host=socket.gethostname().partition(".")[0], place=place), encoding="utf-8")
    os.environ["SLURM_CONF"] = str(configuration)
    own_munge = subprocess.run(["munge", "-n"], check=False, capture_output=True).returncode
    if own_munge:
        pathlib.Path("/run/munge").mkdir(exist_ok=True)
        shutil.chown("/run/munge", "munge", "munge")
        called("runuser", "-u", "munge", "munged")
    called("slurmctld", "-c")
    called("slurmd")
    try:
        wait_for(lambda: "idle" in called("sinfo", "-h", "-o", "%T"), 30, "an idle node")
        yield
    finally:
        subprocess.run(["scancel", "--user", "root"], check=False)
        for name in ("slurmd", "slurmctld"):
            with contextlib.suppress(OSError, ValueError):
                os.kill(int((place / f"{name}.pid").read_text(encoding="utf-8")), signal.SIGTERM)
        if own_munge:
            called("munged", "--stop")


def wait_for(holds, seconds, what):
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            raise SystemExit(f"{what}: not within {seconds} s\n"
                             + called("squeue", "-o", "%i %T %r"))
        time.sleep(0.2)


class Queue:
    """Submits jobs from the folder of the source."""

    def __init__(self, program, source, folder):
        self.program, self.source, self.folder = program, source, folder
        os.environ["TRACKBED"] = program.path

    def submitted(self, *words, ranks=2, options=()):
        """Number of the job; its log is FOLDER/log-NUMBER."""
        return called("sbatch", "--parsable", "-n", ranks, "-t", 30, "-o",
                      self.folder / "log-%A", *options, "jobs/slurm.sh", *words,
                      cwd=self.source).strip()

    def state(self, job):
        """Of all jobs of an array that have not ended, the states; empty: all have."""
        lines = called("squeue", "-h", "-t", "all", "-o", "%F %T").splitlines()
        return " ".join(state for number, _, state in map(lambda one: one.partition(" "), lines)
                        if number == job and state not in ENDED)

    def ended(self, job):
        """Until a job is out of the queue; one that is requeued starts after 3 s instead of
        two minutes (Slurm refuses to start it in the second in which it is requeued)."""
        since = time.monotonic()

        def out():
            if "PENDING" in self.state(job) and time.monotonic() - since > 3:
                subprocess.run(["scontrol", "update", f"jobid={job}", "StartTime=now"],
                               check=False, capture_output=True)
            return not self.state(job)
        wait_for(out, 240, f"the end of job {job}: {self.log(job)}")

    def log(self, job):
        path = self.folder / f"log-{job}"
        return path.read_text(encoding="utf-8") if path.is_file() else ""

    def has_checkpoint(self, place, job):
        def there():
            if not self.state(job):
                raise SystemExit(f"job {job} has ended: {self.log(job)}")
            return (place / "latest").is_file()
        wait_for(there, 120, f"a checkpoint of job {job}")


def hash_of(place):
    return summary(place)["dem"]["state_hash"]


def check_chain(queue, deck, whole):
    """Slurm signals that the time ends; the job goes on until it is finished, with equal bits."""
    place = queue.folder / "chain"
    job = queue.submitted(deck, place, *SLOW)
    queue.has_checkpoint(place, job)
    called("scancel", "--signal=USR1", "--batch", job)
    wait_for(lambda: "PENDING" in queue.state(job), 60, f"job {job} back in the queue")
    queue.ended(job)
    log = queue.log(job)
    if "stopped in time, with a checkpoint" not in log or "continues at" not in log \
            or hash_of(place) != whole:
        raise SystemExit(f"the chain: {log}")


def check_cancelled(queue, deck, whole):
    """A job that is cancelled does not come back; the same command continues it, on other ranks."""
    place = queue.folder / "cancelled"
    job = queue.submitted(deck, place, *SLOW)
    queue.has_checkpoint(place, job)
    called("scancel", job)
    wait_for(lambda: not queue.state(job), 60, "the end of a cancelled job")
    job = queue.submitted(deck, place, *SLOW, ranks=1)
    queue.ended(job)
    if "continues at" not in queue.log(job) or hash_of(place) != whole:
        raise SystemExit(f"a job that was cancelled: {queue.log(job)}")


def check_node_failure(queue, deck, whole):
    """All ranks are killed and Slurm starts the job again, as after the failure of a node."""
    place = queue.folder / "failed"
    job = queue.submitted(deck, place, *SLOW)
    queue.has_checkpoint(place, job)
    called("scontrol", "requeue", job)
    queue.ended(job)
    if "continues at" not in queue.log(job) or hash_of(place) != whole:
        raise SystemExit(f"a job that was requeued: {queue.log(job)}")


def check_bad_input(queue, *_):
    """Code 2 of the program is that of the job, which does not come back."""
    bad = queue.folder / "bad.csv"
    bad.write_text("train.speed,rail.section\n50\n", encoding="utf-8")
    array = ("--array=1-1",)
    for words, options, sentence in (
            (("none.toml", queue.folder / "none"), (), "none.toml: does not exist"),
            (("--table", "none.csv", "a", "b"), array, "none.csv: No such file"),
            (("--table", bad, "a", "b"), array, "row 1 has 1 values, but 2 names"),
            (("--table", bad, "a", "b"), (), "give the rows with sbatch --array")):
        job = queue.submitted(*words, options=options)
        queue.ended(job)
        ended = called("scontrol", "show", "job", job)
        if sentence not in queue.log(job) or "ExitCode=2:0" not in ended \
                or "Restarts=0" not in ended:
            raise SystemExit(f"bad input {words}: {queue.log(job)}\n{ended}")


def check_array(queue, *_):
    """A job for each row of a table."""
    table, place = queue.folder / "table.csv", queue.folder / "array"
    table.write_text("train.speed,rail.section\n50,60E1\n60,54E1\n", encoding="utf-8")
    job = queue.submitted("--table", table, queue.source / "inputs" / "track" / "plain.toml", place,
                          "passage.duration=0.1", ranks=1, options=("--array=1-2",))
    queue.ended(job)
    for row, speed, section in (("1", 50, "60E1"), ("2", 60, "54E1")):
        stated = called(queue.program.path, "info", place / row)
        deck = read.origin(place / row)[1]
        if not summary(place / row)["finished"] or ", finished at" not in stated \
                or (deck["train"]["speed"], deck["rail"]["section"]) != (speed, section):
            raise SystemExit(f"row {row} with {section}: {queue.log(job)}")


def main():
    program, source, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2]), pathlib.Path(
        sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    deck = source / "tests" / "restart" / "tiny.toml"
    program.done(2, "run", deck, "-o", folder / "whole")
    with slurm(folder / "slurm"):
        queue = Queue(program, source, folder)
        for check in (check_chain, check_cancelled, check_node_failure, check_bad_input,
                      check_array):
            begin = time.monotonic()
            check(queue, deck, hash_of(folder / "whole"))
            print(f"{check.__name__}: {time.monotonic() - begin:.1f} s", flush=True)


if __name__ == "__main__":
    main()
