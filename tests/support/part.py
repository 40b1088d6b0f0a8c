"""The part of a test's cases that its short form runs: every nth, n being TRACKBED_EVERY (1: all),
from TRACKBED_FIRST (0) on. The long tier runs all (`trackbed_sweep` in cmake/Modules.cmake)."""
import os


def part(cases):
    every, first = (int(os.environ.get(f"TRACKBED_{name}", default))
                    for name, default in (("EVERY", 1), ("FIRST", 0)))
    return list(cases)[first::every]
