#!/usr/bin/env python3
"""A ground alone under pressures: waves and settlement of a column against closed forms, a moving
strip against itself one element later, equilibrium under a dead load and the ultimate load, and
bitwise identity on any number of ranks and after a stop.

    ground_alone.py PROGRAM DECK CLAY FOLDER
"""
import math
import pathlib
import shutil
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import datasets, same_bits  # noqa: E402

# As in the deck.
HEIGHT, YOUNG, POISSON, DENSITY = 4.0, 50e6, 0.3, 2000.0
OEDOMETRIC = YOUNG * (1 - POISSON) / (1 + POISSON) / (1 - 2 * POISSON)
SPEED = math.sqrt(OEDOMETRIC / DENSITY)
PRESSURE = 20e3
ALL = ["pressure.strip.x=[-4,4]"]


class Bench:
    def __init__(self, program, deck, folder):
        self.program, self.deck, self.folder = program, deck, folder

    def run(self, name, *overrides, ranks=1, code=0):
        self.program.done(ranks, "run", self.deck, *overrides, "-o", self.folder / name, code=code)
        return self.folder / name

    def history(self, name, *overrides):
        found = datasets(self.run(name, *overrides))
        return found["history/time"], found

    def require(self, holds, words):
        if not holds:
            raise SystemExit(words)


def pulse_of(bench, zones):
    """Relative error of the largest velocity of the top before the reflection from the base
    arrives: p / (rho c) of a wave in one dimension."""
    time, found = bench.history(f"pulse_{zones}", *ALL, "pressure.strip.course=pulse",
                                "pressure.strip.duration=0.02", "stage.load.duration=0.05",
                                f"ground.layer.soil.elements={zones}")
    out = time < 2 * HEIGHT / SPEED * 0.95
    top = found["history/ground/velocity"]
    spread = np.abs(top - top[:, :1]).max()
    peak = PRESSURE / DENSITY / SPEED
    bench.require(spread < 1e-9 * peak, f"a uniform load moves the top non-uniformly: {spread}")
    now = np.where(time < 0.02, (1 - np.cos(2 * math.pi * time / 0.02)) / 2, 0)
    return np.abs(top[out, 0] + peak * now[out]).max() / peak


def check_pulse(bench):
    coarse, fine = pulse_of(bench, 20), pulse_of(bench, 40)
    # 18 and 37 elements in the length of the pulse.
    bench.require(fine < 0.002 and coarse / fine > 3,
                  f"pulse: errors {coarse} and {fine}, second order requires a quarter")


def late(bench, name, *scheme):
    """Time lag of the top's displacement behind the ramp of a suddenly applied load, s."""
    time, found = bench.history(name, *ALL, "pressure.strip.duration=0",
                                "stage.load.duration=0.02", *scheme)
    out = (time > 0.01) & (time < HEIGHT / SPEED)
    exact = -PRESSURE / DENSITY / SPEED
    return np.mean(time[out] - found["history/ground/displacement"][out, 0] / exact)


def check_at_once(bench):
    coarse, fine = (late(bench, f"once_{zones}", f"ground.layer.soil.elements={zones}",
                         f"ground.elements_x={zones}") for zones in (20, 40))
    bench.require(abs(fine) < 2e-6 and abs(coarse) < 2e-5,
                  f"a suddenly applied load is {coarse} and {fine} s late")
    implicit = late(bench, "once_newmark", "ground.integrator=newmark", "time.window=1e-4")
    bench.require(abs(implicit) < 2e-5, f"in implicit steps it is {implicit} s late")


def check_changes(bench):
    """Pressures and their tables cannot be changed at a resume."""
    table = bench.folder / "table.csv"
    for name, course, changed in (
            ("dead", ["pressure.strip.course=dead", "pressure.strip.duration=0"],
             ["pressure.strip.pressure=60e3"]),
            ("table", ["pressure.strip.course=table", "pressure.strip.duration=0",
                       f"pressure.strip.file={table}"], [])):
        table.write_text("time_s,factor\n0,0\n0.05,1\n", encoding="utf-8")
        place = bench.run(f"changed_{name}", *course, "output.stop_after=9", code=3)
        table.write_text("time_s,factor\n0,0\n0.05,9\n", encoding="utf-8")
        ran = bench.program.done(1, "resume", place, *changed, "output.stop_after=0", code=2)
        bench.require("pressure" in ran.stderr, ran.stderr)


def check_settlement(bench):
    """A slow rise, in implicit steps: the response is quasi-static."""
    _, found = bench.history("settled", *ALL, "pressure.strip.duration=2",
                             "stage.load.duration=2.2", "time.window=0.01",
                             "ground.integrator=newmark")
    exact = -PRESSURE * HEIGHT / OEDOMETRIC
    off = np.abs(found["history/ground/displacement"][-1] / exact - 1).max()
    # Inertia: (T / rise)^2.
    bench.require(off < 1e-3, f"settlement: relative error {off} of {exact} m")
    stress = found["history/ground/sigma_z"][-1] / -PRESSURE - 1
    bench.require(np.abs(stress).max() < 1e-3, f"stress at the top: relative error {stress}")


def check_along(bench):
    """The same strip started one element behind, on a periodic ground."""
    around = ["ground.side_x_low=periodic", "ground.side_x_high=periodic",
              "stage.load.duration=0.03", "pressure.strip.speed=50",
              "pressure.strip.course=rise", "pressure.strip.duration=0.01"]
    _, first = bench.history("along", *around, "pressure.strip.x=[-2.6,-1.1]")
    _, later = bench.history("later", *around, "pressure.strip.x=[-2.4,-0.9]")
    a, b = (found["history/ground/displacement"] for found in (first, later))
    off = np.abs(a[:, :-1] - b[:, 1:]).max() / np.abs(a).max()
    bench.require(off < 1e-10, f"one element behind, the motion differs by {off}")
    moved = np.abs(a[-1] - np.roll(a[-1], 1)).max() / np.abs(a).max()
    bench.require(moved > 1e-3, "nothing moves")


def check_rest(bench):
    for name, scheme in (("implicit", ["ground.integrator=newmark", "time.window=1e-3"]),
                         ("explicit", [])):
        _, found = bench.history(f"dead_{name}", "pressure.strip.course=dead",
                                 "pressure.strip.duration=0", *scheme)
        most = max(np.abs(found[f"history/ground/displacement{end}"]).max() for end in ("", "_x"))
        bench.require(most < 1e-9, f"{name}: in equilibrium under a dead load it moves by {most} m")


def check_strength(bench, clay):
    """Bearing capacity of a strip on undrained clay under a dead load, (2 + pi) c (Prandtl 1920):
    with elements of an eighth of its width between 0.97 and 1.02 of it."""
    most = (2 + math.pi) * 20e3
    for fraction, code in ((0.97, 0), (1.02, 4)):
        ran = bench.program.done(1, "run", clay, "pressure.strip.course=dead",
                                 "pressure.strip.duration=0", "stage.load.duration=0.01",
                                 f"pressure.strip.pressure={fraction * most}",
                                 "-o", bench.folder / f"clay_{fraction}", code=code)
        bench.require(code == 0 or "static solve of the ground did not converge" in ran.stderr,
                      ran.stderr)


def check_bits(bench):
    """Results of implicit steps depend on the number of ranks by the sums of the solver."""
    for name, scheme, ranks in (("explicit", [], (1, 2, 3)),
                                ("implicit", ["ground.integrator=bossak", "time.window=1e-3"],
                                 (2, 2, 2))):
        change = [*scheme, "pressure.strip.speed=20", "stage.load.duration=0.03"]
        whole = bench.run(f"{name}_whole", *change, ranks=ranks[0])
        stopped = bench.run(f"{name}_stopped", *change, "output.stop_after=11", ranks=ranks[1],
                            code=3)
        bench.program.done(ranks[2], "resume", stopped, "output.stop_after=0")
        same_bits(whole, stopped, f"{name}, stopped and resumed on {ranks} ranks",
                  lambda figures: (figures["ground"]["kinetic_j"], figures["simulated_time_s"]))
        bench.require(summary(whole)["ground"]["kinetic_j"] > 0, f"{name}: nothing moves")


def check_words(bench, strip):
    """Messages on dead pressures; a run reports the static solve before its stage begins."""
    program, moves = bench.program, "nothing moves the ground: "
    dead = program.done(1, "check", strip, "pressure.strip.course=dead",
                        "pressure.strip.duration=0").stdout
    bench.require(moves + 'all pressures have course = "dead", under which the ground '
                  "is initially in static equilibrium, and there is no incoming wave" in dead,
                  f"words: {dead}")
    none = program.done(1, "check", strip, "pressure=[]").stdout
    bench.require(moves + "there are no pressures, and there is no incoming wave" in none,
                  f"words: {none}")
    bench.require(moves not in program.done(1, "check", strip).stdout, "the strip moves it")
    ran = program.done(1, "run", strip, "stage.load.duration=0.01", "-o", bench.folder / "words")
    lines = ran.stdout.splitlines()
    at = [k for k, line in enumerate(lines)
          if line == "  static equilibrium of the ground, 3072 unknowns"]
    stage = [k for k, line in enumerate(lines) if line.startswith("stage load")]
    bench.require(len(at) == 1 and at[0] < stage[0], f"lines: {ran.stdout}")


def main():
    folder = pathlib.Path(sys.argv[4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    bench = Bench(Program(sys.argv[1]), sys.argv[2], folder)
    for check in (check_pulse, check_at_once, check_changes, check_settlement, check_along,
                  check_rest, check_bits):
        check(bench)
    check_strength(bench, sys.argv[3])
    check_words(bench, sys.argv[3])


if __name__ == "__main__":
    main()
