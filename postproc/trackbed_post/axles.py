"""Axles of a train, from the histories of the places of its wheels, [time, wheel], front first,
which are nan beside the track; on two rails each axle has its left wheel before its right one."""
import numpy as np

APART = 3.0  # m; a train that is further from the first sleeper of a bed does not deflect the bed
SAME = 0.01  # m; axles of equal vehicles are at equal distances up to this


def on_two_rails(wheel_x: np.ndarray) -> bool:
    """Whether both wheels of each axle are listed."""
    count = wheel_x.shape[1]
    return count % 2 == 0 and count > 0 and np.array_equal(wheel_x[:, ::2], wheel_x[:, 1::2],
                                                           equal_nan=True)


def of_wheels(wheel_x: np.ndarray) -> np.ndarray:
    """x of the axles, [time, axle]."""
    x = wheel_x.reshape(len(wheel_x), -1)
    return x[:, ::2] if on_two_rails(x) else x


def behind(x: np.ndarray) -> np.ndarray:
    """Distance of each axle behind the first one, m, of x of axles; ends before an axle that is
    never on the track together with the one before it."""
    found = [0.0]
    for ahead, axle in zip(x.T, x.T[1:]):
        both = np.isfinite(ahead) & np.isfinite(axle)
        if not both.any():
            break
        found.append(found[-1] + float(np.median(np.abs(ahead - axle)[both])))
    return np.array(found)


def by_vehicle(x: np.ndarray, count: int) -> np.ndarray | None:
    """The distances behind the first axle, m, [vehicle, axle], of a train of so many vehicles; None
    if they are not known, or not the same in all vehicles: numbers of axles alone do not tell to
    which vehicle an axle belongs."""
    known = behind(x)
    if not count or len(known) < x.shape[1] or len(known) % count:
        return None
    found = known.reshape(count, -1)
    return found if np.allclose(found - found[:, :1], found[0], rtol=0, atol=SAME) else None


def rows_of_trains(wheel_x: np.ndarray) -> list[np.ndarray]:
    """Rows of each train, which have wheels on the track; the next one begins where the first wheel
    jumps back (a stage may send several trains), or after rows without wheels."""
    there = np.flatnonzero(np.isfinite(wheel_x[:, 0]))
    ends = np.flatnonzero((np.diff(wheel_x[there, 0]) < 0) | (np.diff(there) > 1)) + 1
    return [rows for rows in np.split(there, ends) if len(rows)]


def row_before_train(first_axle_x: np.ndarray, first_sleeper: float) -> int:
    """The last row before the first axle is within APART of the first sleeper of the bed, x in m;
    the first row if there is none. At first the pads carry no force, and until the train comes rail
    and sleepers move to their common equilibrium."""
    near = np.flatnonzero(first_axle_x > first_sleeper - APART)
    return max(int(near[0]) - 1, 0) if len(near) else 0


def have_passed(x: np.ndarray, place: float) -> bool:
    """Whether every axle, [time, axle], was beyond a place at least once."""
    return bool((np.where(np.isfinite(x), x, -np.inf) >= place).any(axis=0).all())


def reached(x: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Over which places at least one axle, [time, axle], has run."""
    low, high = (end(np.where(np.isfinite(x), x, none), axis=0, initial=none)
                 for end, none in ((np.min, np.inf), (np.max, -np.inf)))
    at = np.asarray(places)[:, None]
    return ((low <= at) & (high >= at)).any(axis=1)


def time_off(there: np.ndarray, force: np.ndarray) -> float:
    """Part of the rows with a wheel at a place of interest (`there`, [time, wheel]) in which one of
    these wheels has no force."""
    off = (there & (force == 0)).any(axis=1)
    return float(np.count_nonzero(off) / max(1, np.count_nonzero(there.any(axis=1))))
