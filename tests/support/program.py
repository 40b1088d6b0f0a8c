"""Runs the program for tests: `Program(path).run(ranks, "run", deck, ...)`."""
import json
import pathlib
import subprocess


class Program:
    def __init__(self, path):
        self.path = path

    def __call__(self, ranks, *arguments, timeout=3600):
        command = [self.path, *map(str, arguments)]
        if ranks != 1:
            command = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", *command]
        return subprocess.run(command, capture_output=True, text=True, timeout=timeout,
                              check=False)

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


def summary(folder):
    return json.loads((pathlib.Path(folder) / "summary.json").read_text(encoding="utf-8"))
