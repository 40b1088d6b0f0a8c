#!/usr/bin/env python3
"""Waves that open zones in tension: implicit steps come to their end, with heave and plastic work
as explicit ones, whatever the scheme and the window.

    drawn_apart.py PROGRAM DECK FOLDER
"""
import math
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import datasets  # noqa: E402

SCHEMES = {"newmark": 1e-3, "bossak": 1e-3, "hht": 1e-3, "generalized_alpha": 2e-3}


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    table = (folder / "waves.csv").resolve()
    rows = [f"{k / 1000},0,{0.3 * math.sin(0.02 * math.pi * k) if 0 < k < 200 else 0}\n"
            for k in range(201)]
    table.write_text("time_s,vx_m_s,vz_m_s\n" + "".join(rows), encoding="utf-8")

    def run(scheme, window):
        place = folder / scheme
        program.done(1, "run", deck, f"ground.base_motion={table}", f"time.window={window}",
                     f"ground.integrator={scheme}", "-o", place)
        top = datasets(place / "results.h5")["history/ground/displacement"].mean(axis=1)
        return top.max(), top[-1], summary(place)["ground"]["plastic_j"]

    exact = run("explicit", 1e-3)
    if not (exact[0] > 0.03 and exact[2] > 1000):
        raise SystemExit(f"the waves do not draw the column apart: {exact}")
    for scheme, window in SCHEMES.items():
        found = run(scheme, window)
        # Windows are a hundredth or a fiftieth of a wave's period.
        if any(abs(a - b) > 0.01 * b for a, b in zip(found, exact)):
            raise SystemExit(f"{scheme}: heave, heave kept, plastic work {found}, not {exact}")


if __name__ == "__main__":
    main()
