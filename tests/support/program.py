"""Runs the program for tests: `Program(path).run(ranks, "run", deck, ...)`."""
import atexit
import contextlib
import json
import os
import pathlib
import subprocess
import tempfile
import tomllib


@contextlib.contextmanager
def alone():
    """Environment of a program of one rank without Open MPI's daemon, which takes more than half of
    its start (0.14 s instead of 0.33 s). The session folder is its own: programs that start at the
    same time otherwise remove each other's (3 of 640 starts failed; none of 640 with folders of
    their own)."""
    with tempfile.TemporaryDirectory(prefix="trackbed-") as session:
        yield {**os.environ, "OMPI_MCA_ess_singleton_isolated": "1",
               "OMPI_MCA_orte_tmpdir_base": session}


# The same for programs that a script starts, one after the other, up to the end of the test.
EVERYWHERE = contextlib.ExitStack()
os.environ |= EVERYWHERE.enter_context(alone())
atexit.register(EVERYWHERE.close)


class Program:
    def __init__(self, path):
        self.path = path

    def command(self, ranks, *arguments):
        command = [self.path, *map(str, arguments)]
        if ranks == 1:
            return command
        return ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", *command]

    def __call__(self, ranks, *arguments, timeout=3600):
        command = self.command(ranks, *arguments)
        if ranks != 1:
            return subprocess.run(command, capture_output=True, text=True, timeout=timeout,
                                  check=False)
        with alone() as environment:
            return subprocess.run(command, capture_output=True, text=True, timeout=timeout,
                                  check=False, env=environment)

    def done(self, ranks, *arguments, code=0):
        """Runs and requires the exit code `code`."""
        ran = self(ranks, *arguments)
        if ran.returncode != code:
            raise SystemExit(f"{arguments} on {ranks} ranks ended with {ran.returncode}, "
                             f"not {code}:\n{ran.stdout[-3000:]}\n{ran.stderr[-3000:]}")
        return ran


def expect(holds, what, ran):
    """Fails with `what` and the output of the run `ran` unless `holds`."""
    if not holds:
        raise SystemExit(f"{what}\ncode {ran.returncode}\n{ran.stdout[-2000:]}\n{ran.stderr}")


def cell_of(deck):
    """What a deck names as the run whose stones it copies, or nothing."""
    with open(deck, "rb") as file:
        return tomllib.load(file).get("bed", {}).get("cell", "")


def summary(folder):
    return json.loads((pathlib.Path(folder) / "summary.json").read_text(encoding="utf-8"))
