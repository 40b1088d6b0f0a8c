"""The part of a test's cases that its short form runs: every nth, n being TRACKBED_EVERY (1: all),
from TRACKBED_FIRST (0) on; or a choice of its own (`some`). The long tier runs all
(`trackbed_sweep` in cmake/Modules.cmake)."""
import os
import time


def part(cases):
    every, first = (int(os.environ.get(f"TRACKBED_{name}", default))
                    for name, default in (("EVERY", 1), ("FIRST", 0)))
    return list(cases)[first::every]


def some(short, every):
    """`short` in the short form of a test, `every` in the long tier; for numbers of ranks, say."""
    return every if os.environ.get("TRACKBED_EVERY", "1") == "1" else short


def run_checks(checks, *arguments):
    """Runs the part of the functions and prints how long each takes."""
    for check in part(checks):
        begin = time.monotonic()
        check(*arguments)
        print(f"{check.__name__}: {time.monotonic() - begin:.1f} s", flush=True)
