#!/usr/bin/env python3
"""jobs/support.py on synthetic load tests: a sleeper on a spring during unloading, with ringing, a
slip, curvature and noise. The stiffness is recovered, its reported error is realistic, and simpler
slopes are less accurate, which justifies the method.

    loop_support.py SOURCE_FOLDER
"""
import pathlib
import sys

import numpy as np

STIFFNESS, LOAD = 55e6, 30e3  # N/m, N
FALL = 0.12  # s
SEEDS = 30
# Fractions of the displacement, and the largest relative error of the stiffness over all seeds.
# Measured: 0.2, 0.3, 0.6, 0.6, 0.7, 1.4 %.
CASES = (({"curvature": 0.05}, 0.005),
         ({"ringing": 0.05}, 0.01),
         ({"ringing": 0.1}, 0.01),
         ({"slip": 0.1, "curvature": 0.05}, 0.01),
         ({"ringing": 0.03, "slip": 0.05, "curvature": 0.05}, 0.01),
         ({"ringing": 0.1, "slip": 0.1}, 0.02))


def load_test(seed, rows=241, ringing=0.0, slip=0.0, curvature=0.0, noise=0.003):
    """Force on the sleeper and its displacement during the fall of a haversine, from 90 % on."""
    random = np.random.default_rng(seed)
    time = np.linspace(0, FALL, rows)
    load = -LOAD / 2 * (1 + np.cos(np.pi * (0.2 + 0.8 * time / FALL)))
    part = 2 * (load - load.mean()) / LOAD
    turn = 2 * np.pi * random.uniform(25, 38) * time
    wave = np.exp(-random.uniform(0, 0.1) * turn) * np.cos(turn + random.uniform(0, 2 * np.pi))
    late = time > random.uniform(0.05, 0.95) * FALL
    return load, LOAD / STIFFNESS * (load / LOAD + curvature * part**2 + ringing * wave
                                     - slip * late + noise * random.standard_normal(rows))


def parts(load, displacement):
    """Median of eleven slopes."""
    return np.median([np.polyfit(displacement[part], load[part], 1)[0]
                      for part in np.array_split(np.arange(len(load)), 11)])


def regression(load, displacement):
    return 1 / np.polyfit(load, displacement, 1)[0]


def far_pairs(load, displacement):
    """Median of the slopes of pairs half the fall apart or more (Theil, Sen)."""
    i, j = np.triu_indices(len(load), len(load) // 2)
    return 1 / np.median((displacement[j] - displacement[i]) / (load[j] - load[i]))


def worst(slope, **made):
    """Largest relative error of the slope."""
    return max(abs(slope(*load_test(seed, **made)) / STIFFNESS - 1) for seed in range(SEEDS))


def check_found(support):
    for made, most in CASES:
        found = [support.support(*load_test(seed, **made)) for seed in range(SEEDS)]
        off = np.array([one.stiffness / STIFFNESS - 1 for one in found])
        spread = np.array([one.spread / STIFFNESS for one in found])
        slips = sum(one.slip > 0 for one in found)
        print(made, f"off by {100 * np.abs(off).max():.2f} %, root mean square "
              f"{100 * np.sqrt(np.mean(off**2)):.2f}, spread {100 * spread.mean():.2f}, "
              f"slips {slips}")
        if np.abs(off).max() > most or any(one.is_unreliable() for one in found):
            raise SystemExit(f"{made}: stiffness off by {100 * off} %")
        # The standard error must be as large as the errors that it estimates, and not much larger.
        if not 0.7 < np.sqrt(np.mean(spread**2) / np.mean(off**2)) < 5 or (
                np.abs(off) > 4 * spread + 1e-3).any():
            raise SystemExit(f"{made}: off by {100 * off} %, with a reported error of "
                             f"{100 * spread}")
        if slips != (SEEDS if "slip" in made else 0):
            raise SystemExit(f"{made}: {slips} slips found in {SEEDS} load tests")


def check_other_methods():
    for name, slope, made in (("median of parts", parts, {"ringing": 0.05}),
                              ("regression", regression, {"slip": 0.1}),
                              ("pairs far apart", far_pairs, {"slip": 0.1})):
        off = worst(slope, **made)
        print(f"{name} with {made}: off by {100 * off:.0f} %")
        if off < 0.1:
            raise SystemExit(f"{name} would suffice: off by {100 * off} % with {made}")


def check_few_rows(support):
    load, displacement = load_test(1, rows=support.LEAST_ROWS, ringing=0.02)
    one = support.support(load, displacement)
    if abs(one.stiffness / STIFFNESS - 1) > 0.02:
        raise SystemExit(f"few rows: {one}")


def check_unreliable(support):
    """Motion that exceeds the response, no motion, and a sleeper that rises under load."""
    load, displacement = load_test(1)
    walk = np.cumsum(np.random.default_rng(2).standard_normal(len(displacement)))
    for what, other in (("walk", 1e-4 * displacement + 1e-5 * walk), ("rest", 0 * displacement),
                        ("rise", -displacement)):
        if not support.support(load, other).is_unreliable():
            raise SystemExit(f"{what}: {support.support(load, other)}")


def main():
    sys.path.insert(0, str(pathlib.Path(sys.argv[1]) / "jobs"))
    import support  # pylint: disable=import-outside-toplevel
    check_found(support)
    check_other_methods()
    check_few_rows(support)
    check_unreliable(support)


if __name__ == "__main__":
    main()
