"""Decks of the study shi and what all its parts share."""
import numpy as np

from .study import deck_of

from trackbed_post import signals  # noqa: I001 (found by .study)

STONES, SHORT, GROUND = "shi/transition.toml", "shi/short.toml", "shi/ground.toml"
SPACE = "shi/space.toml"
DECK, ALONE = deck_of(STONES), deck_of(GROUND)
LOAD = DECK["load"]
EDGE = 2.0  # m, x where the structure ends
SPACING = DECK["sleepers"]["spacing"]  # m
NO_WEDGE = tuple(f"ground.block.{name}.present=false" for name in ("wedge", "wedge_surface"))
DESIGNS = {"none": NO_WEDGE, "wedge": ()}
TITLES = {"none": "without wedge", "wedge": "with wedge"}
FILTER = signals.LowPass(100)  # Hz, as in the study
GRAVITY = 9.81


def filtered_acceleration(time, velocity):
    """g, from the velocity after the low pass, as accelerations at single instants contain the
    vibration of contacts at higher frequencies than the rows resolve."""
    return np.gradient(FILTER(time, velocity), time, axis=0) / GRAVITY
