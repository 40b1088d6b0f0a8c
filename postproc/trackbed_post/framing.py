"""Which instant and which part of the model a picture of field files shows, from where it is seen,
and which speeds its colours distinguish.

view.py, which ParaView's Python runs, reads this file by itself: it needs numpy only.
"""
import collections.abc
import dataclasses

import numpy as np

Box = np.ndarray        # [lowest, highest] corner, m
Direction = collections.abc.Sequence[float]  # from the model to the eye, or upwards


@dataclasses.dataclass(frozen=True)
class Frame:
    """Least and largest size of a picture, and the space around the model in it, pixels."""
    narrowest: int
    widest: int
    lowest: int
    highest: int
    left: int
    right: int
    below: int
    above: int


PARAVIEW = Frame(1600, 1600, 400, 1200, 170, 120, 90, 140)  # labels of axes; colour bars above
MOST = 99               # per cent of the stones whose speed is within the colours
LONG = 4.2              # m, of the bed in the picture: seven sleepers
SHAPE = 1.2             # least length over height
DEEP = 1.6              # m, of the ground in the picture
CORNER, SIDE, UP = (-0.15, -1.0, 0.35), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)  # from model to eye


def nearest_to_middle(wheels: collections.abc.Iterable[float], low: float,
                      high: float) -> tuple[float, float] | None:
    """(distance from the middle, x) of that of the wheels, x in m, over the bed between low and
    high that is nearest to its middle; None if no wheel is over the bed."""
    middle = (low + high) / 2
    return min(((abs(x - middle), x) for x in wheels if low <= x <= high), default=None)


def passing(wheels: collections.abc.Iterable[tuple[float, collections.abc.Iterable[float]]],
            low: float, high: float) -> tuple[float, float] | None:
    """(time, x) of the instant, of those given with the x of their wheels, at which a wheel is
    nearest to the middle of the bed; None if no wheel is ever over the bed."""
    found = [(*near, time) for time, x in wheels if (near := nearest_to_middle(x, low, high))]
    return (min(found)[2], min(found)[1]) if found else None


def highest_speed(velocity: np.ndarray, stone: np.ndarray) -> float:
    """Speed of all but the fastest stones, m/s, of the velocity of each cell, [cell, 3], and the
    number of its stone, which may have many cells; 0 without a cell."""
    _, first = np.unique(stone, return_index=True)
    speed = np.linalg.norm(velocity[first], axis=1)
    return float(np.percentile(speed, MOST)) if len(speed) else 0.0


def joined(boxes: collections.abc.Sequence[Box]) -> Box:
    """[lowest, highest] corners of boxes as one."""
    return np.array([np.min([low for low, _ in boxes], axis=0),
                     np.max([high for _, high in boxes], axis=0)])


def depth_limited(bed: Box, ground: Box) -> Box:
    """The box of bed and ground, with DEEP or as much of the ground as is above it."""
    both = joined([bed, ground])
    top = ground[1][2]
    both[0][2] = min(bed[0][2], max(ground[0][2], top - max(DEEP, bed[1][2] - top)))
    return both


def window(box: Box, wheel: float | None, eye: Direction) -> Box:
    """The part of a box, along x around the wheel (m, or None: the middle), that is shown."""
    low, high = box[0][0], box[1][0]
    length = max(LONG, SHAPE * extents(box, eye)[1])
    if length >= high - low:
        return box
    middle = (low + high) / 2 if wheel is None else wheel
    begin = min(max(middle - length / 2, low), high - length)
    found = box.copy()
    found[:, 0] = begin, begin + length
    return found


def axes_of(eye: Direction, up: Direction = UP) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors to the right and upwards in the picture, and to the eye."""
    back = np.array(eye) / np.linalg.norm(eye)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    return right, np.cross(back, right), back


def extents(box: Box, eye: Direction, up: Direction = UP) -> list[float]:
    """Width and height of a box in the picture, m."""
    corners = np.array([[box[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    return [float(np.ptp(corners @ axis)) for axis in axes_of(eye, up)[:2]]


def camera(box: Box, eye: Direction, up: Direction = UP, frame: Frame = PARAVIEW
           ) -> tuple[np.ndarray, np.ndarray, float, list[int]]:
    """(focal point, position, half of the height in m, size in pixels) of a picture that a box
    fills, with space around it for labels and colour bars."""
    right, above, back = axes_of(eye, up)
    wide, tall = extents(box, eye, up)
    across, along = frame.left + frame.right, frame.below + frame.above
    metres = max(wide, 1e-9) / (frame.widest - across)  # of a pixel
    high = int(np.clip(tall / metres + along, frame.lowest, frame.highest)) // 2 * 2
    metres = max(metres, tall / (high - along))
    long = int(np.clip(np.ceil(wide / metres) + across, frame.narrowest, frame.widest)) // 2 * 2
    focus = box.mean(axis=0) + metres / 2 * ((frame.right - frame.left) * right
                                             + (frame.above - frame.below) * above)
    return (focus, focus + back * 4 * np.linalg.norm(box[1] - box[0]), metres * high / 2,
            [long, high])
