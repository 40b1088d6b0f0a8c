"""Starts runs for the Python scripts in jobs/, as common.sh does for the shell scripts."""
import concurrent.futures
import os
import re
import shutil
import signal
import subprocess
import sys
import threading

BAD_INPUT = 2  # exit codes, those of the program
STOPPED = 3  # a run that can be resumed, or a script that received a signal to stop
FAILED = 4
TO_STOP = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
# Exit codes of a run after a stop signal: finished, stopped, or killed before its handler was set.
STOP_CODES = (0, STOPPED, -signal.SIGUSR1, 128 + signal.SIGUSR1)

if os.geteuid() == 0:
    os.environ |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
os.environ.setdefault("OMPI_MCA_mpi_yield_when_idle", "1")


class Runs:
    """The current runs, and whether the script has received a signal to stop."""

    def __init__(self):
        self.stop_requested, self.stop_reported, self.processes = False, False, []

    def listen(self):
        """Signals stop the runs; only the main thread can receive them."""
        if threading.current_thread() is not threading.main_thread():
            return
        for number in (*TO_STOP, signal.SIGALRM):
            if signal.getsignal(number) is not signal.SIG_IGN:  # nohup
                signal.signal(number, self.request_stop)

    def stop_listening(self):
        """Signals end the script at once again, as there are no runs."""
        if threading.current_thread() is not threading.main_thread():
            return
        for number in TO_STOP:
            if signal.getsignal(number) == self.request_stop:
                signal.signal(number, signal.default_int_handler if number == signal.SIGINT
                              else signal.SIG_DFL)

    def request_stop(self, *_):
        self.stop_requested = True
        for process in tuple(self.processes):
            process.send_signal(signal.SIGUSR1)
        if self.processes:
            signal.setitimer(signal.ITIMER_REAL, 1)  # repeat: mpirun loses it while it has no ranks

    def begin(self, command, how):
        # In a session of its own the run does not receive Ctrl-C from the terminal.
        process = subprocess.Popen(command, start_new_session=True, stdin=subprocess.DEVNULL,
                                   **how)
        self.processes.append(process)
        if self.stop_requested:  # since the check in run()
            self.request_stop()
        return process

    def end(self, process):
        self.processes.remove(process)
        if not self.processes:
            signal.setitimer(signal.ITIMER_REAL, 0)
        if self.processes and self.stop_requested:  # another has begun in the meantime
            signal.setitimer(signal.ITIMER_REAL, 1)


RUNS = Runs()


def refuse(sentence):
    """Ends the script because of an invalid input; nothing has been run or written."""
    print(sentence, file=sys.stderr)
    sys.exit(BAD_INPUT)


def program(word):
    """Path of a program as a shell resolves it: by PATH if it has no slash, else as a file."""
    found = shutil.which(word) if os.sep not in word else None
    return found or os.path.abspath(word)


def requested_ranks():
    """The environment variable RANKS, 2 if it is not set."""
    text = os.environ.get("RANKS") or "2"
    if not text.isdecimal() or int(text) < 1:
        refuse(f'RANKS = "{text}": must be a whole number, 1 or more')
    return int(text)


def make_folder(path):
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if path.is_file() else error.strerror
        refuse(f"{path} cannot be created as a folder ({reason}): choose another")


def on_ranks(ranks, *words):
    """The mpirun command as a list."""
    return ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", *map(str, words)]


def stop(then):
    try:
        if not RUNS.stop_reported:
            RUNS.stop_reported = True
            print(f"stopped; {then}", file=sys.stderr)
    except OSError:
        pass  # the terminal is gone
    sys.exit(STOPPED)


def together(works, slots):
    """Does `works`, each a tuple (name, names of those that must be done before, slots it takes,
    function without arguments), side by side in at most `slots` slots, or alone if it takes more,
    and starts them in their order. If one ends the script, the others are stopped first."""
    RUNS.listen()
    waiting, running, done = list(works), {}, set()
    with concurrent.futures.ThreadPoolExecutor(max_workers=max(slots, 1)) as pool:
        try:
            while waiting or running:
                for work in [each for each in waiting if done.issuperset(each[1])]:
                    if running and sum(each[2] for each in running.values()) + work[2] > slots:
                        break
                    waiting.remove(work)
                    running[pool.submit(work[3])] = work
                if not running:
                    raise ValueError("works that wait for each other or for one that is not given: "
                                     + ", ".join(each[0] for each in waiting))
                for future in concurrent.futures.wait(
                        running, return_when=concurrent.futures.FIRST_COMPLETED)[0]:
                    done.add(running.pop(future)[0])
                    future.result()
        except BaseException:
            RUNS.stop_reported = True  # the reason of the end is known
            RUNS.request_stop()
            raise
    RUNS.stop_listening()


def run(command, then="the same command runs it again", **how):
    """Runs `command` and returns what subprocess.run returns; `how` are arguments of Popen.
    SIGTERM, SIGHUP and Ctrl-C, now or since an earlier run, are sent to it as SIGUSR1: on the
    others mpirun kills the ranks a second later, SIGUSR1 it passes on and then waits for the
    checkpoint. The script then ends with STOPPED and reports what `then` the same command does."""
    RUNS.listen()
    if RUNS.stop_requested:
        stop(then)
    try:
        process = RUNS.begin(command, how)
    except OSError as error:
        refuse(f"{error.filename}: {error.strerror}")
    try:
        out, err = process.communicate()
    finally:
        RUNS.end(process)
    if RUNS.stop_requested and process.returncode in STOP_CODES:
        stop(then)
    return subprocess.CompletedProcess(command, process.returncode, out, err)


# Messages of mpirun itself on a failed run, between two lines of dashes.
BANNER = re.compile(r"^-{60,}\n(.*?)^-{60,}\n", re.MULTILINE | re.DOTALL)
KILLED = re.compile(r"process rank (\d+) .* exited on signal (\d+) \(([^)]*)\)")
# Messages of PETSc, and of Open MPI without dashes.
TRACE = re.compile(r"\[\d+\]PETSC ERROR|\[[^\]\s]+:\d+\] |\d+ total process|mpirun: Forwarding")
MOST_LINES = 20


def messages(stderr):
    """The last messages of the program itself on stderr. Without any, those of mpirun, which then
    could not start it."""
    own = [line for line in dict.fromkeys(BANNER.sub("", stderr).splitlines())
           if line and not TRACE.match(line)]
    first = [number for number, line in enumerate(own) if line.startswith("trackbed: ")]
    if not own and not KILLED.search(stderr):
        own = [line for part in BANNER.findall(stderr)
               for line in part.splitlines() if line.strip()]
    return own[first[0] if first else 0:][-MOST_LINES:]


def describe_end(code, stderr):
    """How a run ended, from its code and its stderr: a rank that was killed, or the code."""
    if found := KILLED.search(stderr):
        return f"rank {found[1]} was killed (signal {found[2]}, {found[3]})"
    if code < 0:
        return f"it was killed (signal {-code}, {signal.strsignal(-code)})"
    return f"exit code {code}"


def fail(ran, what, see=""):
    """Ends the script after the failed run `ran` of `what`: prints the program's own messages and
    how it ended; exits with the code of the run, or 128 and the signal number as shells do."""
    ending = f"{what} failed: {describe_end(ran.returncode, ran.stderr)}"
    print("\n".join([*messages(ran.stderr), ending + see]), file=sys.stderr)
    sys.exit(ran.returncode if ran.returncode > 0 else 128 - ran.returncode)
