#!/usr/bin/env python3
"""A made-up scan of a crossing of 1:18.5, as a laser scanner would give it: points with noise,
outliers and a hole. The files crossing_facing.csv and crossing_trailing.csv follow from it.

    crossing_scan.py SCAN.csv
    python3 postproc trajectory SCAN.csv --origin 17 -o facing
    python3 postproc trajectory SCAN.csv --origin 19 --trailing -o trailing

x: along the track from the throat towards the nose; y: from the tread datum of a wheel towards its
field side; mm. The wing rail, on which the wheel comes, diverges to the field side, while the nose
rises below the tread. Dimensions are chosen: published scans are not available.
"""
import sys

import numpy as np

LENGTH, WIDTH = 2000.0, (-45.0, 75.0)
STEP_X, STEP_Y = 2.0, 1.0
ANGLE = 18.5
GAUGE = -33.0             # y of the gauge face of running rail and nose
BEND = 100.0              # x at which the wing rail begins to diverge
FLANGEWAY = 44.0          # between nose and wing rail
TIP_DEPTH, RISE = 6.0, 500.0  # of the nose: depth of its tip, length over which it rises
HEAD = 72.0               # width of a rail's head
# Radii of the head of 60E1 (EN 13674-1) and the distance from its middle up to which they reach.
ARCS = ((300.0, 10.3), (80.0, 26.05), (13.0, 36.0))
INCLINATION = 40.0        # of the rails, towards the middle of the track
NOISE, OUTLIERS = 0.035, 1e-3  # standard deviation; part of all points
HOLE = (700.0, 20.0, 12.0)     # x, y, radius of a place that was not scanned


def head(across, width):
    """Height of a rail's running surface at a distance from its gauge face; nan beside it."""
    outwards = across - HEAD / 2
    distance, sine, z = np.minimum(np.abs(outwards), HEAD / 2), 0.0, 0.0
    begin = 0.0
    for radius, end in ARCS:
        on = np.clip(distance - begin, 0, end - begin)
        z = z - radius * (np.sqrt(1 - sine**2) - np.sqrt(1 - (sine + on / radius)**2))
        sine, begin = sine + (end - begin) / radius, end
    return np.where((across >= 0) & (across <= width), z + outwards / INCLINATION, np.nan)


def height(x, y):
    """Of the running surface: the higher one of wing rail and nose; nan in the flangeway."""
    diverged = np.maximum(x - BEND, 0) / ANGLE
    wing = head(y - GAUGE - diverged, HEAD)
    width = diverged - FLANGEWAY  # of the nose
    rise = np.clip(width * ANGLE / RISE, 0, 1)
    nose = head(y - GAUGE, np.minimum(width, HEAD)) - TIP_DEPTH * (1 - rise)
    return np.fmax(wing, np.where(width > 0, nose, np.nan))


def write(path):
    chance = np.random.default_rng(1)
    x, y = (axis.ravel() for axis in np.meshgrid(
        np.arange(0, LENGTH + 1, STEP_X), np.arange(*WIDTH, STEP_Y), indexing="ij"))
    x, y = x + chance.uniform(-0.3, 0.3, x.shape), y + chance.uniform(-0.3, 0.3, y.shape)
    z = height(x, y)
    seen = np.isfinite(z) & ((x - HOLE[0])**2 + (y - HOLE[1])**2 > HOLE[2]**2)
    x, y, z = x[seen], y[seen], z[seen] + chance.normal(0, NOISE, np.count_nonzero(seen))
    out = chance.choice(len(z), int(OUTLIERS * len(z)), replace=False)
    z[out] += chance.uniform(5, 40, len(out))
    np.savetxt(path, np.stack([x, y, z], axis=1), fmt="%.3f", delimiter=",",
               header="x_mm,y_mm,z_mm", comments="")


if __name__ == "__main__":
    write(sys.argv[1])
