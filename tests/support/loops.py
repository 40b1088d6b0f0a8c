"""Runs jobs/handover.py for tests, with a substitute for the program (quick_loop.py)."""
import os
import pathlib
import subprocess
import sys

import program  # noqa: F401 (its environment of programs of one rank)


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
        """Runs a loop that must end with `code` and print `says` on stderr, or on stdout if the
        code is 0; returns that output."""
        with self.begin(*words, fails=fails) as running:
            out, err = running.communicate(timeout=250)
        printed = err if code else out
        if running.returncode != code or says not in printed or "Traceback" in err:
            raise SystemExit(f"{words} must end with {code} and print {says}, not "
                             f"{running.returncode}:\n{out}{err}")
        return printed
