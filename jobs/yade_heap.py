#!/usr/bin/env python3
"""The heap of a run repeated with the polyhedra of Yade, for comparison.

    yade -j1 -f1 -n -x jobs/yade_heap.py RESULTS [CHECKPOINT]

RESULTS: a run of inputs/bed/repose.toml with bed.container=box, whose deck gives friction, walls
and local damping. CHECKPOINT: the stones before the walls are lifted (default:
RESULTS/stage_fill.h5).
Prints time, angle and top of the heap, mean height and median speed of the stones. With Debian's
package `yade` (2023.02a) 110 stones take 8 min of a core. Its law keeps one shear force for all
contacts; `Scene.friction` replaces it (docs/decisions/heap_and_strength.md).
"""
import pathlib
import sys

import numpy as np
import scipy.spatial
from yade import polyhedra_utils, utils
from yade.wrapper import (
    Bo1_Polyhedra_Aabb, Bo1_Wall_Aabb, ForceResetter, Ig2_Polyhedra_Polyhedra_PolyhedraGeom,
    Ig2_Wall_Polyhedra_PolyhedraGeom, InsertionSortCollider, InteractionLoop,
    Ip2_PolyhedraMat_PolyhedraMat_PolyhedraPhys, Law2_PolyhedraGeom_PolyhedraPhys_Volumetric,
    NewtonIntegrator, O, PolyhedraMat, PyRunner)

# Yade executes the text of this file, so that __file__ is Yade's own.
sys.path.insert(0, str(pathlib.Path(sys.argv[0]).resolve().parent.parent / "postproc"))
from trackbed_post import heap, read  # noqa: E402

K_N, K_S = 2.5e9, 1e5     # N/m3 of overlap, N/m: a column of 0.24 m settles by 10 mm
STEP = 1.25e-4            # s; a face of 2 cm2 has 5e5 N/m, the lightest stone then 2.3e-4 s
SETTLE, REST = 0.08, 0.5  # s under this law before the walls are lifted, and afterwards
DAMPING, THICK = 0.3, 0.03  # local while the column settles; m, of the walls
FREE, HELD, NOT_EACH_OTHER = 1, 3, 2  # masks: bodies with a common bit collide, except the last


def body(corners, material, mask, fixed=False):
    made = polyhedra_utils.polyhedra(material, v=[tuple(at) for at in corners], fixed=fixed)
    made.mask = mask
    return made


def stone(piece, volume, material):
    """The core scaled to the volume of the rounded stone: moved faces would split corners."""
    centre, corners, _, _ = piece
    core = body(corners, material, FREE).shape.GetVolume()
    return body(centre + (volume / core)**(1 / 3) * corners, material, FREE)


def lying(made):
    """The stone in the form that heap.placed returns."""
    turn = made.state.ori.toRotationMatrix()
    corners = np.array([turn * corner for corner in made.shape.v])
    planes = scipy.spatial.ConvexHull(corners).equations * [1, 1, 1, -1]
    return np.array(made.state.pos), corners, planes, 0.0


class Scene:
    """Stones, floor and walls; phases: settle, lift, rest."""

    def __init__(self, results, checkpoint=None):
        deck = read.results(results).deck
        saved = read.checkpoint(checkpoint or results / "stage_fill.h5")
        self.lift = next(stage for stage in deck["stage"] if stage["kind"] == "lift_walls")
        self.rough, self.smooth = (pair["friction"] for pair in deck["contact"][:2])
        self.size = 1e-3 * np.median(deck["bed"]["sieve"])
        self.history = {}
        # Two materials act as springs in series.
        material = PolyhedraMat(young=2 * K_N, poisson=K_S / K_N, density=2650, frictionAngle=0)
        solids = saved["particles/template/solid"].values[:, 0]
        shapes = saved["particles/shape"].values.ravel().astype(int)
        volumes = solids[shapes] * saved["particles/scale"].values.ravel()**3
        self.stones = [stone(piece, volume, material)
                       for piece, volume in zip(heap.placed(saved), volumes)]
        self.walls = [body(at, material, HELD, True) for at in self.sides(deck["bed"])]
        floor = utils.wall(0, axis=2, sense=1, material=material)
        floor.mask = HELD
        O.bodies.append([*self.stones, *self.walls, floor])
        self.sides = {wall.id for wall in self.walls}
        self.newton = NewtonIntegrator(damping=DAMPING, gravity=(0, 0, -9.81))

    @staticmethod
    def sides(bed):
        """Corners of four walls that touch at their edges, from just above the floor."""
        (west, east), (south, north) = bed["x"], bed["y"]
        for x, y in (((west - THICK, west), (south - THICK, north + THICK)),
                     ((east, east + THICK), (south - THICK, north + THICK)),
                     ((west, east), (south - THICK, south)),
                     ((west, east), (north, north + THICK))):
            yield [(a, b, c) for a in x for b in y for c in (1e-4, 1.4 * bed["height"])]

    def friction(self):
        """Coulomb friction on a linear spring with a history per contact, for that of Yade."""
        forces = {}
        for contact in O.interactions:
            if not (contact.isReal and (size := contact.phys.normalForce.norm())):
                continue
            pair, normal = (contact.id1, contact.id2), contact.geom.normal
            force = -K_S * contact.geom.shearInc
            if pair in self.history:
                old = self.history[pair]
                flat = old - normal * normal.dot(old)
                force += flat * (old.norm() / max(flat.norm(), 1e-30))
            most = size * (self.smooth if self.sides.intersection(pair) else self.rough)
            forces[pair] = force * min(1, most / max(force.norm(), 1e-30))
            for number, on in zip(pair, (-forces[pair], forces[pair])):
                O.forces.addF(number, on)
                arm = contact.geom.contactPoint - O.bodies[number].state.pos
                O.forces.addT(number, arm.cross(on))
        self.history = forces

    def advance(self):
        risen = SETTLE + self.lift["duration"]
        if self.walls and O.time >= risen:
            for wall in self.walls:
                O.bodies.erase(wall.id)
            self.walls = []
        elif self.walls and O.time >= SETTLE and self.walls[0].state.vel[2] == 0:
            self.newton.damping = max(0.0, self.lift["local_damping"])
            for wall in self.walls:
                wall.state.vel = (0, 0, self.lift["lift"])
        elif O.time >= risen + REST:
            O.pause()

    def report(self):
        """The angle between heap.LEVELS of the height: heap.flank needs more than two stones."""
        cell = self.size / heap.CELLS
        surface = heap.surface(map(lying, self.stones), cell)[2]
        top = np.sort(surface, axis=None)[-heap.CELLS**2]
        angle, _ = heap.slope(top * np.linspace(*heap.LEVELS, heap.STEPS), surface, cell)
        mean = np.mean([made.state.pos[2] for made in self.stones])
        speed = np.median([made.state.vel.norm() for made in self.stones])
        print(f"{O.time:.3f} s: angle {angle:.1f} degrees, top {1e3 * top:.0f} mm, mean height "
              f"{1e3 * mean:.1f} mm, median speed {speed:.1e} m/s", flush=True)


if len(sys.argv) not in (2, 3):
    sys.exit(__doc__)
SCENE = Scene(*map(pathlib.Path, sys.argv[1:]))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Polyhedra_Aabb(), Bo1_Wall_Aabb()], verletDist=5e-4,
                          avoidSelfInteractionMask=NOT_EACH_OTHER),
    InteractionLoop(
        [Ig2_Wall_Polyhedra_PolyhedraGeom(), Ig2_Polyhedra_Polyhedra_PolyhedraGeom()],
        [Ip2_PolyhedraMat_PolyhedraMat_PolyhedraPhys()],
        [Law2_PolyhedraGeom_PolyhedraPhys_Volumetric()]),
    PyRunner(command="SCENE.friction()", iterPeriod=1), SCENE.newton,
    PyRunner(command="SCENE.advance()", iterPeriod=10),
    PyRunner(command="SCENE.report()", virtPeriod=0.05)]
O.dt = STEP
O.run(-1, True)
SCENE.report()
