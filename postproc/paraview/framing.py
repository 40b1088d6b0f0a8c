"""Which instant, which part of the model is in a picture of view.py, and from where it is seen."""
import numpy as np

WIDE, LOWEST, HIGHEST = 1600, 400, 1200  # pixels, of the picture
LEFT, RIGHT, BELOW, ABOVE = 170, 120, 90, 140  # pixels around the model: labels, colour bars above
LONG = 4.2              # m, of the bed in the picture: seven sleepers
SHAPE = 1.2             # least length over height
DEEP = 1.6              # m, of the ground in the picture
CORNER, SIDE, UP = (-0.15, -1.0, 0.35), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)  # from model to eye


def nearest_to_middle(wheels, low, high):
    """(distance from the middle, x) of that of the wheels, x in m, over the bed between low and
    high that is nearest to its middle; None if no wheel is over the bed."""
    middle = (low + high) / 2
    return min(((abs(x - middle), x) for x in wheels if low <= x <= high), default=None)


def joined(boxes):
    """[lowest, highest] corners of boxes as one."""
    return np.array([np.min([low for low, _ in boxes], axis=0),
                     np.max([high for _, high in boxes], axis=0)])


def depth_limited(bed, ground):
    """The box of bed and ground, with DEEP or as much of the ground as is above it."""
    both = joined([bed, ground])
    top = ground[1][2]
    both[0][2] = min(bed[0][2], max(ground[0][2], top - max(DEEP, bed[1][2] - top)))
    return both


def window(box, wheel, eye):
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


def axes_of(eye):
    """Unit vectors to the right and upwards in the picture, and to the eye."""
    back = np.array(eye) / np.linalg.norm(eye)
    right = np.cross(UP, back)
    right /= np.linalg.norm(right)
    return right, np.cross(back, right), back


def extents(box, eye):
    """Width and height of a box in the picture, m."""
    corners = np.array([[box[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    return [float(np.ptp(corners @ axis)) for axis in axes_of(eye)[:2]]


def camera(box, eye):
    """(focal point, position, half of the height in m, size in pixels) of a picture that a box
    fills, with space around it for labels and colour bars."""
    right, up, back = axes_of(eye)
    wide, tall = extents(box, eye)
    metres = wide / (WIDE - LEFT - RIGHT)  # of a pixel
    pixels = int(np.clip(tall / metres + BELOW + ABOVE, LOWEST, HIGHEST)) // 2 * 2
    metres = max(metres, tall / (pixels - BELOW - ABOVE))
    focus = box.mean(axis=0) + metres / 2 * ((RIGHT - LEFT) * right + (ABOVE - BELOW) * up)
    return (focus, focus + back * 4 * np.linalg.norm(box[1] - box[0]), metres * pixels / 2,
            [WIDE, pixels])
