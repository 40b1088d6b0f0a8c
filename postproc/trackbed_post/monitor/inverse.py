"""Forces of wheels on a crossing and irregularity of its running surface from the acceleration of a
sleeper (sections 5.7 and 5.8 of the thesis).

A bogie passes a range of the track near the sensor. Everywhere else, and of all other wheels, the
forces are the static ones. Within it the force of wheel w at x is unknown,
    f_w(x) = static + common(x) + LIKENESS own_w(x),
and the acceleration is linear in it by the Green's functions of the track. Both functions are white
noise of the same strength before the measurement.

Different from the thesis: it takes both forces of a bogie as equal (likeness 0), uses the
reconstructed displacement, and truncates singular values. All three are available.
"""
import dataclasses
import typing

import numpy as np
import scipy.ndimage
import scipy.signal

from trackbed_post import read
from trackbed_post.monitor import displacement as reconstruction
from trackbed_post.monitor import direction, greens, regularised

RANGE = (-3.0, 4.0)  # m, from the sensor: where forces are not the static ones
LIKENESS = 0.15      # standard deviation of what is one wheel's own, over what both have
BOGIE = 4.0          # m, of axles that are identified together
SLOW = 4.0           # m, wavelength: longer ones state where the train is; a dip causes others
OF_DIP = 0.005       # m, standard deviation of this place because of dips
ROUNDS = 2           # in which the forces that are found improve the place
DEPENDENT = 5        # samples: wheel forces lie below a fifth of 5 kHz, so that the errors of the
                     # model in fewer samples than these are not independent
SEARCH = 6           # samples, by which it may be wrong
SPREAD = 0.5         # m, over which forces are similarly strong
LEAST = 0.1          # strength of a force anywhere over the largest
LEAD = 5.0           # m, before the range, from where forces still deflect the rail in it
EXTENT = 1.2         # m, on both sides of the largest force: beyond, the rail is even
DRIFT = 3            # degree of the polynomial that makes it so
DRAWS = 30           # forces from their distribution, for uncertainties


@dataclasses.dataclass(frozen=True)
class Arrival:
    """Position of the first wheel at the first sample, m, its standard deviation, m, and the ratio
    of the measured displacement to that of the track under static forces; order of the wheels
    (direction.order_of); Green's functions with the wheels in this order, in the direction of the
    train."""
    start: float
    deviation: float
    ratio: float
    order: int = 0
    kernel: greens.Kernel | None = None


@dataclasses.dataclass(frozen=True)
class Forces:
    """Forces, N downwards, of the wheels of a bogie at positions x, m, [wheel, position], and their
    standard deviations; strength of the regularisation and `curves` of its choice
    (regularised.Solution)."""
    x: np.ndarray
    force: np.ndarray
    deviation: np.ndarray
    strength: float
    curves: tuple
    draw: typing.Callable  # (random generator) -> force from the distribution after the measurement

    def peak(self, wheel=0, seed=1):
        """(largest force, N, its standard deviation, N, its place, m)."""
        random = np.random.default_rng(seed)
        drawn = [self.draw(random)[wheel].max() for _ in range(DRAWS)]
        at = int(np.argmax(self.force[wheel]))
        return float(self.force[wheel, at]), float(np.std(drawn)), float(self.x[at])


class Passing:
    """Wheels whose first one is at `start` (m) in the first of `count` samples, at `speed`, m/s."""

    def __init__(self, kernel, start, count, speed):
        self.kernel, self.start, self.count = kernel, start, count
        self.step = speed / kernel.rate  # m
        self.wheels = kernel.wheels

    def places(self, wheel):
        """m, of a wheel, at each sample."""
        return self.start - self.wheels.behind[wheel] + self.step * np.arange(self.count)

    def of_static(self, quantity):
        """Response of the sensor to the static forces of all wheels on all rails."""
        kernel = self.kernel
        run = int(kernel.x[-1] / self.step) + 1
        table = sum(tables[quantity] for tables in kernel.fixed.values())
        unit = greens.superposed(table, kernel.x, self.step * np.arange(run), np.ones(run),
                                 run + kernel.samples)
        at = self.step * np.arange(len(unit))  # m, of the wheel
        return sum(load * np.interp(self.places(wheel), at, unit, left=0.0, right=0.0)
                   for wheel, load in enumerate(self.wheels.load))

    def of_changes(self, quantity, forces, first):
        """Response of the sensor to what the forces of a bogie, which all bogies with as many
        wheels have, exceed the static ones."""
        behind, bogie = self.wheels.behind, bogie_of(self.kernel, first)
        rows = np.arange(self.count)
        one = sum(self.matrix(quantity, wheel, forces.x, rows) @ (force - self.wheels.load[wheel])
                  for wheel, force in zip(bogie, forces.force))
        found = np.zeros(self.count)
        for begin in range(len(behind)):
            try:
                alike = len(bogie_of(self.kernel, begin)) == len(bogie)
            except read.Unreadable:  # not the first wheel of a bogie
                continue
            if alike:
                late = (behind[begin] - behind[first]) / self.step
                found += np.interp(rows - late, rows, one, left=0.0, right=0.0)
        return found

    def matrix(self, quantity, wheel, x, rows):
        """Response in these rows to a unit force of one wheel on the sensor's rail at each position
        x, spaced by `step`; a force is linear between positions."""
        table, lags = self.kernel.fixed[self.kernel.side][quantity], self.kernel.samples
        found = np.zeros((self.count + lags, len(x)))
        places = self.places(wheel)
        for sample in np.flatnonzero((places > x[0] - self.step) & (places < x[-1] + self.step)):
            response = greens.between(table, self.kernel.x, places[sample])
            place = (places[sample] - x[0]) / self.step
            left = int(np.floor(place))
            for column, part in ((left, 1 - place + left), (left + 1, place - left)):
                if 0 <= column < len(x):
                    found[sample:sample + lags, column] -= part * response
        return found[rows]


def bogie_of(kernel, first=0):
    """Numbers of the wheels of the bogie that begins with wheel `first`."""
    if kernel.wheels is None:
        raise read.Unreadable("the Green's functions are those of a deck without a train")
    behind = kernel.wheels.behind
    if not 0 <= first < len(behind):
        raise read.Unreadable(f"axle {first + 1}: the train has the axles 1 to {len(behind)}")
    before = behind[first] - behind
    if np.any((before > 0) & (before <= BOGIE)):
        begin = int(np.argmax((before > 0) & (before <= BOGIE)))
        raise read.Unreadable(f"axle {first + 1} follows axle {begin + 1} in its bogie: give the "
                              "first axle of a bogie")
    return np.flatnonzero((before <= 0) & (before >= -BOGIE))


def arrival(found, kernel, speed, forces=None, first=0):
    """Arrival of the kernel's train: the displacement (a Reconstruction) is most similar to that
    under static forces, or under the `forces` (Forces) of the bogie that begins with wheel `first`,
    which all bogies with as many wheels have."""
    slow, expected = slow_parts(found, kernel, speed, forces, first)
    shift, similarity = most_similar(slow, expected)
    step = speed / kernel.rate  # m
    # Errors of the displacement are smooth: each flank below a bogie is one measurement.
    slope = np.sqrt(np.mean(np.gradient(slow[~found.at_rest], step)**2))
    flanks = 2 * (1 + np.sum(np.diff(kernel.wheels.behind) > BOGIE))
    error = np.sqrt(np.mean(found.deviation**2)) / np.sqrt(flanks)
    return Arrival(start=-shift * step, deviation=float(error / slope),
                   ratio=float(similarity / np.sum(expected**2)))


def slow_parts(found, kernel, speed, forces=None, first=0):
    """Displacements, m, measured and expected of a train that comes from x = 0, as for `arrival`:
    wavelengths above SLOW."""
    length = kernel.x[-1] + kernel.wheels.behind[-1]
    passing = Passing(kernel, 0.0, int(length / speed * kernel.rate) + kernel.samples, speed)
    sections = scipy.signal.butter(2, speed / SLOW, fs=kernel.rate, output="sos")
    expected = passing.of_static("displacement")
    if forces is not None:
        expected = expected + passing.of_changes("displacement", forces, first)
    return (scipy.signal.sosfiltfilt(sections, found.displacement),
            scipy.signal.sosfiltfilt(sections, expected))


def most_similar(measured, expected):
    """(samples by which `expected` is to be shifted, largest correlation of both)."""
    similar = scipy.signal.correlate(measured, expected, "full")
    at = int(np.argmax(similar))
    if not 0 < at < len(similar) - 1:
        raise read.Unreadable("the record does not contain the passage of this train")
    return at + vertex(similar[at - 1:at + 2])[0] - (len(expected) - 1), similar[at]


def vertex(three):
    """(place of the extreme of a parabola through values at -1, 0, 1; its second derivative)."""
    low, middle, high = three
    bend = low - 2 * middle + high
    return 0.5 * (low - high) / bend, bend


class Problem:
    """Linear equations for the forces of a bogie: those of the samples `rows` for forces at x."""

    def __init__(self, signal, kernel, speed, start, quantity="acceleration", first=0,
                 bounds=RANGE):
        """`signal`: of the sensor, at the rate of the kernel; `start`: position of the first wheel
        at its first sample, m."""
        if quantity not in greens.QUANTITIES:
            raise read.Unreadable(f'"{quantity}" is no quantity of the sensor; these are '
                                  f'{", ".join(greens.QUANTITIES)}')
        passing = Passing(kernel, start, len(signal), speed)
        self.signal, self.step = np.asarray(signal, float), passing.step
        bogie = bogie_of(kernel, first)
        self.load = kernel.wheels.load[bogie]
        self.x = np.arange(kernel.sensor + bounds[0], kernel.sensor + bounds[1] + self.step / 2,
                           self.step)
        self.rows = np.flatnonzero((passing.places(bogie[0]) >= self.x[0]) &
                                   (passing.places(bogie[-1]) <= self.x[-1]))
        if len(self.rows) < len(self.x) // 2 or self.rows[0] < SEARCH or \
                self.rows[-1] >= len(signal) - SEARCH:
            raise read.Unreadable("the record begins or ends while the bogie passes the sensor")
        self.each = [passing.matrix(quantity, wheel, self.x, self.rows) for wheel in bogie]
        self.static = passing.of_static(quantity)[self.rows]

    def decomposition(self, likeness, weights=1.0):
        """Of the matrix of common and own forces, in units of `weights` at each position."""
        parts = [sum(self.each), *(likeness * one for one in self.each if likeness)]
        return np.linalg.svd(np.hstack([weights * part for part in parts]), full_matrices=False)

    def right(self, shift=0):
        """What forces must explain if the signal is `shift` samples late."""
        return self.signal[self.rows + shift] - self.static

    def changes(self, unknown, likeness):
        """Changes of each wheel's force from the static one, [..., wheel, position]."""
        parts = unknown.reshape(*unknown.shape[:-1], -1, len(self.x))
        if likeness:
            return parts[..., :1, :] + likeness * parts[..., 1:, :]
        return np.repeat(parts, len(self.each), axis=-2)


def placed(problem, unsure, likeness=4 * LIKENESS):
    """(shift, m, by which the first wheel is farther back than assumed, its standard deviation, m):
    the likelihood of the signal decides, if forces are strong only near where they are found to be
    so at first. `unsure`: standard deviation, m, of the place assumed."""
    first = regularised.Solution(problem.decomposition(likeness), problem.right())
    squares = np.mean(problem.changes(first.unknown, likeness)**2, axis=0)
    strong = np.sqrt(scipy.ndimage.uniform_filter1d(squares, max(int(SPREAD / problem.step), 1)))
    decomposition = problem.decomposition(likeness, np.hypot(strong / strong.max(), LEAST))
    evidence = [regularised.Solution(decomposition, problem.right(shift)).evidence() / DEPENDENT
                + (shift * problem.step)**2 / (unsure**2 + OF_DIP**2)
                for shift in range(-SEARCH, SEARCH + 1)]
    at = int(np.argmin(evidence))
    if not 0 < at < 2 * SEARCH:
        raise read.Unreadable("the place of the train in the record cannot be found: is its speed, "
                              "or the track of the Green's functions, another one?")
    part, bend = vertex(evidence[at - 1:at + 2])
    return (at + part - SEARCH) * problem.step, np.sqrt(2 / bend + 1 / 12) * problem.step


def identify(problem, likeness=LIKENESS, method="tikhonov", criterion="gcv", noise=0.0, unsure=0.0):
    """Forces. `unsure`: standard deviation, m, of the place of the train; `noise`: of a sample,
    needed by the criterion "residual" alone."""
    for name, value, known in (("method", method, regularised.METHODS),
                               ("criterion", criterion, regularised.CRITERIA)):
        if value not in known:
            raise read.Unreadable(f'"{value}" is no {name}; these are {", ".join(known)}')
    solution = regularised.Solution(problem.decomposition(likeness), problem.right(), method,
                                    criterion, noise)
    load = problem.load[:, None]
    found = load + problem.changes(solution.unknown, likeness)
    variance = solution.variance(problem.changes(solution.vectors, likeness).reshape(
        len(solution.values), -1), 1 + likeness**2).reshape(found.shape)

    def drawn(random):
        shift = unsure * random.standard_normal()
        changed = problem.changes(solution.draw(random), likeness)
        return load + np.array([np.interp(problem.x + shift, problem.x, one) for one in changed])

    of_place = unsure * np.gradient(found, problem.step, axis=1)
    return Forces(x=problem.x, force=found, deviation=np.sqrt(variance + of_place**2),
                  strength=solution.strength, curves=solution.curves, draw=drawn)


def evaluate(acceleration, kernel, speed, doubtful=None, quantity="acceleration", first=0,
             bounds=RANGE, known_noise=None, refined=True, towards=None, **choices):
    """(Forces, Arrival, Reconstruction) of a passage of the kernel's train, from an acceleration at
    the rate of the kernel; `choices` are those of `identify`, `known_noise` is that of
    displacement.reconstruct. `refined`: whether the acceleration improves the place of the train,
    which is found by the displacement at first. `towards`: of direction.of_passage. Axles are
    counted in the order in which they pass."""
    bogie_of(kernel)
    if quantity == "displacement" and choices.get("criterion") == "residual":
        raise read.Unreadable('the criterion "residual" needs white noise, which a displacement '
                              'does not have: choose another criterion or the acceleration')
    found = reconstruction.reconstruct(acceleration, kernel.rate, speed, doubtful=doubtful,
                                       noise=known_noise)
    deck = kernel
    kernel, order = direction.of_passage(
        kernel, towards, lambda one: direction.similarity(*slow_parts(found, one, speed)))
    came = arrival(found, kernel, speed)
    upright = np.asarray(acceleration, float) * (-1 if found.reversed else 1)
    if refined:
        for _ in range(ROUNDS):
            forces = identify(Problem(upright, kernel, speed, came.start, "acceleration", first,
                                      bounds))
            came = arrival(found, kernel, speed, forces, first)
        shift, deviation = placed(Problem(upright, kernel, speed, came.start, "acceleration", first,
                                          bounds), came.deviation)
        came = dataclasses.replace(came, start=came.start - shift, deviation=deviation)
    signal = upright if quantity == "acceleration" else found.displacement
    problem = Problem(signal, kernel, speed, came.start, quantity, first, bounds)
    choices = {"noise": found.noise, "unsure": came.deviation} | choices
    forces, came = identify(problem, **choices), dataclasses.replace(came, order=order,
                                                                     kernel=kernel)
    if kernel.towards != deck.towards:
        forces, came = mirrored(forces, came, deck)
    return forces, came, found


def mirrored(forces, came, deck):
    """(Forces, Arrival) at positions of the deck, m, if found in the mirror image of its track."""
    return (dataclasses.replace(forces, x=deck.mirror(forces.x)[::-1],
                                force=forces.force[:, ::-1], deviation=forces.deviation[:, ::-1],
                                draw=lambda random: forces.draw(random)[:, ::-1]),
            dataclasses.replace(came, start=deck.mirror(came.start)))


@dataclasses.dataclass(frozen=True)
class Irregularity:
    """Height, m, of the running surface (upwards) at x, m, over that of an even rail, and its
    standard deviation; displacement of wheel and rail, m."""
    x: np.ndarray
    height: np.ndarray
    deviation: np.ndarray
    wheel: np.ndarray
    rail: np.ndarray

    @property
    def depth(self):
        """Depth of the dip, m, and its standard deviation."""
        at = int(np.argmin(self.height))
        return -float(self.height[at]), float(self.deviation[at])


def irregularity(forces, kernel, speed, first=0, extent=EXTENT, draws=DRAWS, seed=1):
    """Wheel minus rail plus compression of the contact, of the first wheel of a bogie. The wheel is
    a free mass below its static load, whose initial position and velocity, and the slow errors of
    the force, are chosen such that the rail is even beyond `extent` of the largest force."""
    refuse_irregularity(forces, kernel, speed, first)
    wheels, bogie = kernel.wheels, bogie_of(kernel, first)
    load, middle = wheels.load[bogie], float(forces.x[np.argmax(forces.force[0])])
    even = np.abs(forces.x - middle) > extent
    if min(np.sum(even & (forces.x < middle)), np.sum(even & (forces.x > middle))) < DRIFT + 2:
        raise read.Unreadable(f"the largest force, at {middle:.3g} m, is nearer than {extent:g} m "
                              f"to an end of the range, {forces.x[0]:.3g} to {forces.x[-1]:.3g} m")
    below = BelowWheel(kernel, bogie, first, forces.x, speed)

    def heights(force):
        change = force - load[:, None]
        rail = below.static + below.moved(change)
        lift = np.cumsum(np.cumsum(change[0] / wheels.mass[first])) / kernel.rate**2
        surface = lift - rail + wheels.approach(force[0])
        drift = np.polyval(np.polyfit((forces.x - middle)[even], surface[even], DRIFT),
                           forces.x - middle)
        return surface - drift, lift - drift, rail

    height, lift, rail = heights(forces.force)
    random = np.random.default_rng(seed)
    drawn = [heights(forces.draw(random))[0] for _ in range(draws)]
    deviation = np.std(drawn, axis=0) if draws else np.full(len(height), np.nan)
    return Irregularity(forces.x, height, deviation, lift, rail)


def refuse_irregularity(forces, kernel, speed, first):
    """Raises read.Unreadable if the kernel has no moving response for these forces."""
    if kernel.towards == greens.SMALLER:
        raise read.Unreadable("the moving response is that of a train towards larger x, but this "
                              "one runs towards smaller x: call `trackbed kernel` with the mirror "
                              "image of the deck's track (length - x of zones and sensor), and "
                              "`forces` with --towards larger")
    behind = kernel.wheels.behind[bogie_of(kernel, first)]
    behind = behind - behind[0]
    if not kernel.moving:
        raise read.Unreadable(f"call `trackbed kernel` with --speed {speed:g}")
    if abs(kernel.speed - speed) > greens.SAME_SPEED * speed:
        raise read.Unreadable(f"the moving response is that of {kernel.speed:g} m/s: call "
                              f"`trackbed kernel` with --speed {speed:g}")
    if len(kernel.behind) < len(behind) or \
            not np.allclose(kernel.behind[:len(behind)], behind, atol=1e-3):
        raise read.Unreadable(
            f"the moving response is that of axles {words_of(kernel.behind)} m behind the first, "
            f"those of the bogie are {words_of(behind)} m behind: call `trackbed kernel` with "
            f"--axles {len(behind)} and a deck whose train begins with this bogie")
    if not kernel.wheels.mass[first] > 0:
        raise read.Unreadable('wheels of constant force have no mass: use vehicles with wheelsets, '
                              'not of kind "forces"')
    begin = max(forces.x[0] - LEAD - behind[-1], kernel.x[0])
    if kernel.moving_x[0] > begin + 1e-6 or kernel.moving_x[-1] < forces.x[-1]:
        raise read.Unreadable(f"the moving response begins at {kernel.moving_x[0]:g} and ends at "
                              f"{kernel.moving_x[-1]:g} m: call `trackbed kernel` with --from "
                              f"{begin:.4g} or less and --to {forces.x[-1]:.4g} or more")


def words_of(places):
    return ", ".join(f"{place:g}" for place in places)


class BelowWheel:
    """Deflection of the rail below the first wheel of a bogie at positions x, m."""

    def __init__(self, kernel, bogie, first, x, speed):
        self.kernel, self.x, self.step = kernel, x, speed / kernel.rate
        behind = kernel.wheels.behind
        self.behind = [behind[wheel] - behind[first] for wheel in bogie]
        # From where forces begin to have responses, in steps that end at those of x.
        self.before = int((x[0] - kernel.moving_x[0]) / self.step)
        self.path = x[0] + self.step * np.arange(-self.before, len(x))
        self.static = sum(self.superposed(side, axle, np.full(len(self.path), load))
                          for side in kernel.moving
                          for axle, load in enumerate(kernel.wheels.load[bogie]))

    def superposed(self, side, axle, forces):
        """m, due to forces of an axle while the first wheel follows the path."""
        moved = greens.superposed(self.kernel.moving[side][axle], self.kernel.moving_x,
                                  self.path - self.behind[axle], forces, len(self.path))
        return moved[self.before:]

    def moved(self, changes):
        """m, due to changes of the forces, N, [wheel, position x]."""
        return sum(self.superposed(self.kernel.side, axle, np.interp(
            self.path - behind, self.x, changes[axle], left=0.0, right=0.0))
            for axle, behind in enumerate(self.behind))
