"""Results of a track on a ground, made for tests."""
import json

import made
import numpy as np

LENGTH, RUN_IN, SPACING = 30.0, 3.0, 0.5
BEFORE, COUNT, FIRST = 20, 20, 0.25  # sleepers from 10 m to 19.5 m, x = 0 of the ground at 9.75 m
SPEED, ROWS = 20.0, 321              # rows 0.1 m apart
BLOCKS = """
[[ground.block]]
name = "abutment"
outline = [0.0, 0.0, 2.0, 0.0, 2.0, -2.0, 0.0, -2.0]
young = 30e9
[[ground.block]]
name = "wedge"
outline = [2.0, 0.0, 5.0, 0.0, 2.0, -2.0]
young = 200e6
"""
DECK = f"""
model = "track_on_ground"
dimension = "plane"
[track]
length = {LENGTH}
run_in = {RUN_IN}
spacing = {SPACING}
[footing]
before = {BEFORE}
count = {COUNT}
first = {FIRST}
[ground]
x = [0.0, 10.0]
[[ground.layer]]
thickness = 2.0
young = 20e6
{BLOCKS}
[train]
vehicles = ["coach"]
speed = {SPEED}
[passage]
step = 5e-4
"""


def wheels(rows=ROWS):
    """(time, x, force, height) of two axles 2 m apart, of 50 kN, with 55 kN at 15 m below the first
    one, and 60 kN at 22 m, behind the ground."""
    time = np.arange(rows) * 0.1 / SPEED
    x = SPEED * time[:, None] - np.array([0.0, 2.0])
    force = np.full(x.shape, 50e3)
    force[np.isclose(x[:, 0], 15.0), 0] = 55e3
    force[np.isclose(x[:, 0], 22.0), 0] = 60e3
    return time, x, force, -1e-3 + 1e-4 * np.sin(2 * np.pi * x / 4)


def folder(path, rows=ROWS, points=(8.0, 12.0, 18.0), deck=DECK, **seats):
    """A run of so many rows. Seats that an axle has reached carry up to 20 kN and pull by at most
    1 kN, others 20 N and 1 kN; `seats`: least load of a sleeper, at_INDEX, N."""
    path.mkdir()
    time, x, force, height = wheels(rows)
    places = SPACING * np.arange(int(LENGTH / SPACING) + 1)
    most = np.where(places <= x.max(), 20e3, 20.0)
    least = np.full(len(places), -1e3)
    for name, value in seats.items():
        least[int(name.removeprefix("at_"))] = value
    at = np.array(points)
    dent = -1e-3 * np.exp(-(x[:, :, None] - at)**2).sum(axis=1)
    made.store(path / "results.h5", {
        "history/time": (time, "s"), "history/wheel/x": (x, "m"),
        "history/wheel/force": (force, "N"), "history/wheel/height": (height, "m"),
        "rail/x": (at, "m"), "sleepers/x": (at, "m"),
        "history/rail/displacement": (dent, "m"),
        "history/sleeper/displacement": (0.5 * dent, "m"),
        "history/sleeper/acceleration": (0 * dent, "m/s2"),
        "history/sleeper/seat_force": (-20e6 * dent, "N"),
        "envelope/x": (places, "m"),
        "envelope/rail/displacement_min": (np.where(most > 1e3, -2e-3, -1e-9), "m"),
        "envelope/rail/displacement_max": (0 * places, "m"),
        "envelope/sleeper/displacement_min": (np.where(most > 1e3, -1e-3, -1e-9), "m"),
        "envelope/sleeper/displacement_max": (0 * places, "m"),
        "envelope/sleeper/seat_force_min": (least, "N"),
        "envelope/sleeper/seat_force_max": (most, "N")},
        deck=deck, version="0.1.0", build="-", ranks=1)
    (path / "summary.json").write_text(json.dumps({
        "deck": "a.toml", "model": "track_on_ground", "finished": True, "ranks": 1,
        "simulated_time_s": float(time[-1]), "wall_time_s": 1.0, "memory_mb_per_rank": 1.0,
        "track": {"wheel_steps_off_rail": 0, "wheel_force_max_n": 60.5e3,
                  "wheel_force_min_n": 49e3,
                  "rail_lowest_m": (1.01 * dent.min(axis=0)).tolist()}}), encoding="utf-8")
    return path
