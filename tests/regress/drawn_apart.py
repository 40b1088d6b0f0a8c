#!/usr/bin/env python3
"""Waves that cause tensile failure: implicit steps converge and give the heave and plastic work of
explicit ones, for all schemes with windows short against the wave period; also in a loose soil
under tension and shear, where some steps are repeated with another tangent and counted.

    drawn_apart.py PROGRAM DECK FOLDER
"""
import math
import pathlib
import shutil
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import datasets  # noqa: E402

SCHEMES = {"newmark": 1e-3, "bossak": 1e-3, "hht": 1e-3, "generalized_alpha": 2e-3}
# Almost no cohesion, no tension, dilation far below friction: strongly non-associated flow.
LOOSE = ["cohesion=700", "tensile_strength=0", "friction_angle=32", "young=14e6"]
# Name -> velocity of the waves along x and z (m/s), changes of the soil, windows (s).
CASES = {"weak": ((0, 0.3), [], SCHEMES),
         "loose": ((0.1, 0.3), LOOSE, dict.fromkeys(SCHEMES, 1e-3))}


def write_waves(table, along, up):
    waves = [math.sin(0.02 * math.pi * k) if 0 < k < 200 else 0 for k in range(201)]
    rows = [f"{k / 1000},{along * wave},{up * wave}\n" for k, wave in enumerate(waves)]
    table.write_text("time_s,vx_m_s,vz_m_s\n" + "".join(rows), encoding="utf-8")


def check_motion(found, scheme, window):
    """Rows are windows: the motion of the top by Newmark's scheme satisfies the trapezoidal rule,
    also along x."""
    if scheme != "newmark":
        return
    moving = found["history/stage"] == found["history/stage"].max()
    for end in ("", "_x"):
        u, v, a = (found[f"history/ground/{name}{end}"][moving][1:]
                   for name in ("displacement", "velocity", "acceleration"))
        for rate, of in ((v, u), (a, v)):
            off = np.abs(np.diff(of, axis=0) - window / 2 * (rate[1:] + rate[:-1])).max()
            if np.abs(of).max() < 1e-5 or off > 1e-9 * np.abs(of).max():
                raise SystemExit(f"{end}: deviation {off} from the trapezoidal rule, of "
                                 f"{np.abs(of).max()}")


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)

    repeated = {}

    def run(name, soil, scheme, window):
        place = folder / f"{name}_{scheme}"
        program.done(1, "run", deck, f"ground.base_motion={folder.resolve() / name}.csv",
                     f"time.window={window}", f"ground.integrator={scheme}",
                     *(f"ground.layer.soil.{change}" for change in soil), "-o", place)
        found = datasets(place)
        if name == "loose":
            check_motion(found, scheme, window)
        top = found["history/ground/displacement"].mean(axis=1)
        ground = summary(place)["ground"]
        lagging, most = ground["newton_steps_lagging"], ground["newton_iterations_max"]
        # Repeated after 20 iterations, whose count continues; earlier if no iteration reduces what
        # is left, which depends on the positions of the stones.
        if (most > 20 and lagging == 0) or (name == "weak" and lagging > 0):
            raise SystemExit(f"{name}, {scheme}: {lagging} steps lag, at most {most} iterations")
        if lagging:
            repeated.setdefault(name, []).append(most)
        return top.max(), top[-1], ground["plastic_j"]

    for name, (speeds, soil, schemes) in CASES.items():
        write_waves(folder / f"{name}.csv", *speeds)
        exact = run(name, soil, "explicit", 1e-3)
        if not (exact[0] > 0.03 and exact[2] > 1000):
            raise SystemExit(f"{name}: the waves do not cause tensile failure: {exact}")
        for scheme, window in schemes.items():
            found = run(name, soil, scheme, window)
            # Windows are a hundredth or a fiftieth of a wave's period.
            if any(abs(a - b) > 0.01 * b for a, b in zip(found, exact)):
                raise SystemExit(f"{name}, {scheme}: heave, residual heave, plastic work {found}, "
                                 f"not {exact}")
    if max(repeated.get("loose", [0])) <= 20:
        raise SystemExit(f"no step of the loose soil is repeated after 20 iterations: {repeated}")
    print(f"rounds of schemes with steps that lag: {repeated}")


if __name__ == "__main__":
    main()
