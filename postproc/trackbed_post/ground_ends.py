"""Whether the springs before and behind the ground of a track are about as stiff as the ground.

Where they are not, the support changes in a step which is one of the model, and which acts on the
train and on the levels beside it.
"""
import collections.abc

import numpy as np

from trackbed_post import axles, read, track_stretch

# A step of 1.4 raised the largest wheel force by 2 % (a freight wagon at 100 km/h from clay to
# springs of 0.2 of the default, in place of 0.14, for which there was none).
SAME = 1.3
BESIDE = 6  # sleepers on either side whose mean displacement is compared, without ENDS
# The displacement of a beam on springs below a wheel varies with their stiffness to the power -3/4
# (Winkler).
POWER = 4 / 3


def warnings_of(run: read.Quantities, deck: read.Deck) -> list[str]:
    """One for each end of the ground that the train has passed."""
    ground = track_stretch.ground_of(deck)
    if ground is None or len(ground.sleepers) < 2 or "envelope/rail/displacement_min" not in run:
        return []
    x = run["envelope/x"].values.ravel()
    low = -run["envelope/rail/displacement_min"].values.ravel()
    counts = track_stretch.between_run_ins(deck).holds(x)
    if "history/wheel/x" in run:
        counts &= axles.reached(track_stretch.history(run, "wheel/x"), x)
    spacing = float(np.median(np.diff(ground.sleepers)))
    found: list[str] = []
    for end, outwards, side in ((ground.sleepers[0], -1, ("before", "first")),
                                (ground.sleepers[-1], 1, ("behind", "last"))):
        aside = outwards * (x - end) / spacing
        near, far = track_stretch.ENDS - 0.5, track_stretch.ENDS + BESIDE - 0.5
        springs = low[counts & (aside > near) & (aside < far)]
        inside = low[counts & (-aside > near) & (-aside < far)]
        if len(springs) and len(inside):
            found += _step(float(springs.mean()), float(inside.mean()), float(end), *side)
    return found


def _step(springs: float, inside: float, end: float, where: str,
          which: str) -> collections.abc.Iterator[str]:
    if not min(springs, inside) > 0 or max(springs / inside, inside / springs) < SAME:
        return
    yield (f"a passing axle lowers the rail by {1e3 * springs:.2f} mm on the springs {where} the "
           f"ground and by {1e3 * inside:.2f} mm on its {which} sleepers, at x = {end:.2f} m: "
           "this step acts on the train and on the levels beside it; multiply `bed` of the "
           f"[[track.zone]] {where} the ground by about {(springs / inside) ** POWER:.2g}")
