"""Order in which the wheels of a train pass a sensor, and direction in which the train runs.

The displacement of a sleeper states in which order wheels pass (section 5.6 of the thesis), unless
the train looks the same from both ends. A train in the order opposite to that of the deck has been
turned, or returns: then it runs towards smaller x. The displacement cannot tell these apart where
the track is symmetric about the sensor, and need not. Elsewhere (a crossing in facing and in
trailing moves) forces at x and at its mirror image have other responses, but the displacement
hardly changes (docs/decisions/inverse_forces.md), so that the direction must be given.
"""
import numpy as np
import scipy.signal

from trackbed_post import read
from trackbed_post.monitor import greens

APART = 0.01      # least difference of the coefficients of both orders that tells them apart
NEAR = 4.0        # m, from the sensor, where forces are found
SYMMETRIC = 0.05  # largest asymmetry of a track that is symmetric: as far as forces may be wrong


def of_passage(kernel, towards, similarity):
    """(Kernel with the wheels in the order in which they pass and in the direction of the train;
    this order, of order_of). `towards`: x, of greens.TOWARDS, or None if it is not known: larger
    x, unless the order is the opposite one and the track not symmetric, which is refused.
    `similarity(kernel)`: coefficient of correlation of the displacement, as in order_of."""
    if towards not in (None, *greens.TOWARDS):
        raise read.Unreadable(f'a train does not run towards "{towards}" x, but towards '
                              f'{" or ".join(greens.TOWARDS)} x')
    seen = kernel.mirrored() if towards == greens.SMALLER else kernel
    order = order_of(seen, similarity)
    if order >= 0:
        return seen, order
    if towards is None and (found := asymmetry(kernel)) > SYMMETRIC:
        raise read.Unreadable(
            "the wheels pass in the order opposite to that of the deck, and the track is not "
            f"symmetric about the sensor: its responses to forces before and behind it differ by "
            f"{100 * found:.2g} % (limit {100 * SYMMETRIC:g} %); give --towards larger if the "
            "train was turned, --towards smaller if it runs towards smaller x")
    return seen.turned(), order


def order_of(kernel, similarity):
    """1: as the kernel's wheels are listed, -1: the opposite one, 0: not known, as the train looks
    the same from both ends. `similarity(kernel)`: coefficient of correlation of the displacement
    with that under the static forces of the kernel's wheels."""
    turned = kernel.turned()
    if kernel.wheels.alike(turned.wheels):
        return 0
    return order_by(similarity(kernel), similarity(turned))


def order_by(forth, back):
    """The order by the coefficients of the order of the deck and of the opposite one."""
    return 0 if abs(forth - back) < APART else (1 if forth > back else -1)


def similarity(measured, expected):
    """Largest coefficient of correlation of two displacements over all shifts."""
    size = np.linalg.norm(measured) * np.linalg.norm(expected)
    return float(scipy.signal.correlate(measured, expected, "full").max() / size)


def asymmetry(kernel):
    """Difference of the sensor's accelerations under forces as far before it as behind it, relative
    to their mean: 0 if the track is symmetric about the sensor, up to 2."""
    table, step = kernel.fixed[kernel.side]["acceleration"], kernel.x[1] - kernel.x[0]
    reach = min(kernel.sensor - kernel.x[0], kernel.x[-1] - kernel.sensor, NEAR)
    away = np.arange(step, reach, step)
    before, behind = (np.array([greens.between(table, kernel.x, kernel.sensor + sign * one)
                                for one in away]) for sign in (-1, 1))
    return float(2 * np.linalg.norm(before - behind)
                 / (np.linalg.norm(before) + np.linalg.norm(behind)))
