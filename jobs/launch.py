"""Starts runs for the scripts in jobs/ that are Python, as common.sh does for those in shell."""
import os
import re
import shutil
import signal
import subprocess
import sys

BAD_INPUT = 2  # exit codes, as the program's
STOPPED = 3  # of a run that can be resumed, and of a script that was told to stop
FAILED = 4
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


def refuse(sentence):
    """Ends the script: what it was given is wrong, nothing has been done."""
    print(sentence, file=sys.stderr)
    sys.exit(BAD_INPUT)


def program(word):
    """As a shell finds it: what PATH has by this name, or else the file."""
    found = shutil.which(word) if os.sep not in word else None
    return found or os.path.abspath(word)


def ranks_told():
    """RANKS, 2 without it."""
    text = os.environ.get("RANKS") or "2"
    if not text.isdecimal() or int(text) < 1:
        refuse(f'RANKS = "{text}": must be a whole number, 1 or more')
    return int(text)


def make_folder(path):
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if path.is_file() else error.strerror
        refuse(f"{path} cannot be made as a folder ({reason}): choose another")


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
        refuse(f"{error.filename}: {error.strerror}")
    out, err = process.communicate()
    RUNS.end()
    if RUNS.told and process.returncode in TOLD_ENDS:
        stop(then)
    return subprocess.CompletedProcess(command, process.returncode, out, err)


# Between two lines of dashes: what mpirun itself says of a run that failed.
BANNER = re.compile(r"^-{60,}\n(.*?)^-{60,}\n", re.MULTILINE | re.DOTALL)
KILLED = re.compile(r"process rank (\d+) .* exited on signal (\d+) \(([^)]*)\)")
# Of PETSc, and of Open MPI without dashes.
TRACE = re.compile(r"\[\d+\]PETSC ERROR|\[[^\]\s]+:\d+\] |\d+ total process|mpirun: Forwarding")
MOST_LINES = 20


def sentences(said):
    """Lines of the program itself in what a run said on stderr: its last words. Without any, those
    of mpirun, which then could not begin."""
    own = [line for line in dict.fromkeys(BANNER.sub("", said).splitlines())
           if line and not TRACE.match(line)]
    first = [number for number, line in enumerate(own) if line.startswith("trackbed: ")]
    if not own and not KILLED.search(said):
        own = [line for part in BANNER.findall(said) for line in part.splitlines() if line.strip()]
    return own[first[0] if first else 0:][-MOST_LINES:]


def end_in_words(code, said):
    """How a run ended, of its code and what it said on stderr: a rank that was killed, or the
    code."""
    if found := KILLED.search(said):
        return f"rank {found[1]} was killed (signal {found[2]}, {found[3]})"
    if code < 0:
        return f"was killed (signal {-code}, {signal.strsignal(-code)})"
    return f"code {code}"


def fail(ran, what, see=""):
    """Ends the script as the run `ran` of `what` has ended: the program's own sentences, then how;
    code of the run, or 128 and the signal, as shells tell it."""
    ending = f"{what} failed: {end_in_words(ran.returncode, ran.stderr)}"
    print("\n".join([*sentences(ran.stderr), ending + see]), file=sys.stderr)
    sys.exit(ran.returncode if ran.returncode > 0 else 128 - ran.returncode)
