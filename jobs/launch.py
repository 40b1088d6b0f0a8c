"""Starts runs for the scripts in jobs/ that are Python, as common.sh does for those in shell."""
import os
import shutil
import signal
import subprocess
import sys

STOPPED = 3  # exit code of a run that can be resumed, and of a script that was told to stop
TO_STOP = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
# Ends of a run that was told: at its end, in time, or before it could listen, alone or of a rank.
TOLD_ENDS = (0, STOPPED, -signal.SIGUSR1, 128 + signal.SIGUSR1)

if os.geteuid() == 0:
    os.environ |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
os.environ.setdefault("OMPI_MCA_mpi_yield_when_idle", "1")


class Runs:
    """The one that is under way, and whether the script was told to stop."""
    told, process = False, None

    def listen(self):
        for number in (*TO_STOP, signal.SIGALRM):
            if signal.getsignal(number) is not signal.SIG_IGN:  # nohup
                signal.signal(number, self.tell)

    def tell(self, *_):
        self.told = True
        if self.process:
            self.process.send_signal(signal.SIGUSR1)
            signal.setitimer(signal.ITIMER_REAL, 1)  # again: mpirun that has no ranks yet loses it

    def begin(self, command, how):
        # A session of its own keeps the terminal's Ctrl-C from it.
        self.process = subprocess.Popen(command, start_new_session=True, stdin=subprocess.DEVNULL,
                                        **how)
        if self.told:  # between the look before and now
            self.tell()
        return self.process

    def end(self):
        self.process = None
        signal.setitimer(signal.ITIMER_REAL, 0)


RUNS = Runs()


def program(word):
    """As a shell finds it: what PATH has by this name, or else the file."""
    found = shutil.which(word) if os.sep not in word else None
    return found or os.path.abspath(word)


def ranks_told():
    """RANKS, 2 without it."""
    text = os.environ.get("RANKS") or "2"
    if not text.isdecimal() or int(text) < 1:
        sys.exit(f'RANKS = "{text}": must be a whole number, 1 or more')
    return int(text)


def make_folder(path):
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if path.is_file() else error.strerror
        sys.exit(f"{path} cannot be made as a folder ({reason}): choose another")


def on_ranks(ranks, *words):
    """The command as a list."""
    return ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", *map(str, words)]


def stop(then):
    try:
        print(f"stopped; {then}", file=sys.stderr)
    except OSError:
        pass  # the terminal is gone
    sys.exit(STOPPED)


def run(command, then="the same command begins anew", **how):
    """What subprocess.run gives of `command`, with the words of Popen. SIGTERM, SIGHUP and Ctrl-C,
    now or since an earlier run, reach it as SIGUSR1: told to end, mpirun kills the ranks a second
    later; SIGUSR1 it passes on, and waits for their checkpoint. The script then ends with STOPPED
    and says what `then` the same command does."""
    RUNS.listen()
    if RUNS.told:
        stop(then)
    try:
        process = RUNS.begin(command, how)
    except OSError as error:
        sys.exit(f"{error.filename}: {error.strerror}")
    out, err = process.communicate()
    RUNS.end()
    if RUNS.told and process.returncode in TOLD_ENDS:
        stop(then)
    return subprocess.CompletedProcess(command, process.returncode, out, err)
