"""Runs jobs/handover.py for tests, on a program that only acts as if it ran (quick_loop.py)."""
import os
import pathlib
import subprocess
import sys


class Loops:
    def __init__(self, program, source, folder):
        self.folder, self.script = folder, source / "jobs/handover.py"
        self.program = folder / "quick"
        self.program.write_text(
            f'#!/bin/sh\nexport REAL={program}\nexec {sys.executable} '
            f'{pathlib.Path(__file__).with_name("quick_loop.py")} "$@"\n', encoding="utf-8")
        self.program.chmod(0o755)

    def begin(self, deck, place, *words, fails=""):
        return subprocess.Popen(
            [sys.executable, self.script, self.program, deck, place, *words],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "FAILS": fails})

    def ends(self, code, says, *words, fails=""):
        """Runs a loop, which is to end with `code` and say so on stderr, or on stdout if all is
        well; what it said there."""
        with self.begin(*words, fails=fails) as running:
            out, err = running.communicate(timeout=250)
        said = err if code else out
        if running.returncode != code or says not in said or "Traceback" in err:
            raise SystemExit(f"{words} must end with {code} and say {says}, not "
                             f"{running.returncode}:\n{out}{err}")
        return said
