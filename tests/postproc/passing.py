"""Passages over a sleeper whose displacement and acceleration are known in closed form."""
import dataclasses

import numpy as np

RATE = 5000.0
BOGIE, CENTRES, LENGTH = 2.9, 17.0, 25.0  # m
STIFF = 1.2  # 1/m, of Winkler's deflection line
DEEP = 0.8e-3  # m, below a single axle


@dataclasses.dataclass
class Passage:
    speed: float
    displacement: np.ndarray
    acceleration: np.ndarray


def axles(cars, centres=CENTRES, length=LENGTH):
    return np.concatenate([[start + place + k * BOGIE for place in (0.0, centres) for k in (0, 1)]
                           for start in length * np.arange(cars)])


def train(speed, places, rate=RATE, impact=0.0):
    """Winkler's line exp(-|s|)(cos s + sin |s|) of each axle, rounded over 0.1 m as by a sleeper's
    width, and its second derivative; `impact`: m/s2, a burst of 150 Hz at each axle whose double
    integral is known, too."""
    time = np.arange(-45.0, places[-1] + 45.0, speed / rate) / speed
    down, slow = np.zeros(len(time)), np.zeros(len(time))
    for place in places:
        for shift in (-0.1, 0.1):
            s = STIFF * (speed * time - place + shift)
            decay = np.exp(-np.abs(s))
            down -= DEEP / 2 * decay * (np.cos(s) + np.sin(np.abs(s)))
            slow -= DEEP / 2 * 2 * (STIFF * speed)**2 * decay * (np.sin(np.abs(s)) - np.cos(s))
        since = time - place / speed
        width, w = 0.004, 2 * np.pi * 150
        bell = np.exp(-(since / width)**2 / 2)
        down += impact / w**2 * bell * np.sin(w * since)
        first, second = -since / width**2, (since / width**2)**2 - 1 / width**2
        slow += impact / w**2 * bell * ((second - w**2) * np.sin(w * since)
                                        + 2 * first * w * np.cos(w * since))
    return Passage(speed, down, slow)


def noisy(passage, part, seed):
    """White noise of this part of the signal's root mean square."""
    size = part * np.sqrt(np.mean(passage.acceleration**2))
    return passage.acceleration + size * np.random.default_rng(seed).standard_normal(
        len(passage.acceleration))
