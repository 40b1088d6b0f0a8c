"""Tests of heap.py on stones of known shape and heaps of known angle."""
import types

import numpy as np
import pytest
from trackbed_post import heap

SIZE = 0.036    # m, width of the made stones
ROUND = 0.002   # m, their rounding
BOX = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


def dice(centre, rng):
    """A rounded cube at a random attitude."""
    attitude = rng.normal(size=4)
    turned = heap.rotation(attitude / np.linalg.norm(attitude))
    half = 0.8 * SIZE / 2 - ROUND  # a cube at random attitude is wider than its side
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    return centre, half * BOX @ turned.T, np.c_[normals @ turned.T, np.full(6, half)], ROUND


def made_heap(angle, height, level, seed):
    """Cubes about the places of a face-centred lattice at random attitudes, jittered by a fifth of
    their size, below a cone with a level top of radius `level`; the cut is up to a quarter of a
    stone too high or too low, so that the flank is as rough as one of stones."""
    rng = np.random.default_rng(seed)
    far = level + height / np.tan(np.radians(angle)) + 3 * SIZE
    apart = np.sqrt(2) * 1.12 * SIZE
    count = int(1.2 * far / apart) + 2
    corner = np.stack(np.meshgrid(*3 * [np.arange(-count, count + 1)]), axis=-1).reshape(-1, 3)
    places = apart * np.concatenate([corner + np.array(add) for add in
                                     ((0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5))])
    attitude = rng.normal(size=4)
    places = places @ heap.rotation(attitude / np.linalg.norm(attitude)).T
    places += 0.2 * SIZE * rng.normal(size=places.shape)
    out = np.hypot(places[:, 0], places[:, 1])
    cut = np.minimum(height, height - np.tan(np.radians(angle)) * (out - level))
    cut += 0.25 * SIZE * rng.uniform(-1, 1, len(places))
    inside = (places[:, 2] > 0.45 * SIZE) & (places[:, 2] < cut)
    return [dice(place + np.array([0.3, -0.2, 0]), rng) for place in places[inside]]


@pytest.mark.parametrize("angle", [22.0, 30.0, 38.0])
@pytest.mark.parametrize("height, level", [(0.22, 0.0), (0.17, 0.10)])
def test_the_flank_of_a_rough_heap_has_its_angle(angle, height, level):
    """Four to six stones high, pointed or with a level top, as after lifting a cylinder."""
    found = [heap.flank(made_heap(angle, height, level, seed), SIZE)[0] for seed in range(3)]
    assert np.mean(found) == pytest.approx(angle, abs=2.5)


def test_loose_stones_before_the_foot_change_nothing():
    rng = np.random.default_rng(5)
    pieces = made_heap(30, 0.2, 0.05, 1)
    turns = 2 * np.pi * rng.uniform(size=60)
    away = rng.uniform(0.55, 0.9, 60)
    loose = [dice(np.array([r * np.cos(t), r * np.sin(t), 0.45 * SIZE]), rng)
             for r, t in zip(away, turns)]
    alone, with_loose = heap.flank(pieces, SIZE), heap.flank(pieces + loose, SIZE)
    assert with_loose[0] == pytest.approx(alone[0], abs=1.0)
    assert with_loose[1] == pytest.approx(alone[1], abs=1.5)


def test_a_layer_of_stones_has_no_flank():
    rng = np.random.default_rng(2)
    layer = [dice(np.array([x, y, SIZE / 2]), rng) for x in SIZE * np.arange(8)
             for y in SIZE * np.arange(8)]
    angle, scatter, points = heap.flank(layer, SIZE)
    assert np.isnan(angle) and np.isnan(scatter) and len(points) == 0


def saved_stones():
    """A cube of 2 m scaled by 0.1, turned by 45 degrees about x, and a clump of two balls."""
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    made = {"template/corners": np.concatenate([BOX, [[0, 0, 0.5], [0, 1, 0]]]),
            "template/faces": np.concatenate([[len(f), *f] for f in faces]),
            "template/pieces": [1, 2], "template/sizes": [[8, 6], [1, 0], [1, 0]],
            "template/radius": [0.2, 0.5, 0.25],
            "position": [[1, 2, 3], [5, 5, 5]], "scale": [0.1, 1.0], "shape": [0, 1],
            "attitude": [[np.sin(np.pi / 8), 0, 0, np.cos(np.pi / 8)], [0, 0, 0, 1]]}
    return {f"particles/{name}": types.SimpleNamespace(values=np.asarray(values))
            for name, values in made.items()}


def test_pieces_of_a_checkpoint_have_their_pose():
    cube, upper, beside = heap.placed(saved_stones())
    top = heap.tops(*cube[1:], np.array([0.0, 0.0]), np.array([0.0, 0.2]))
    # On its edge: the core reaches up by sqrt(2) of 0.1 m, plus the rounding of 0.02 m.
    assert top[0] == pytest.approx(0.1 * np.sqrt(2) + 0.02)
    assert top[1] == -np.inf
    assert cube[0] == pytest.approx([1, 2, 3])
    assert heap.tops(*upper[1:], np.array([0.0]), np.array([0.0])) == pytest.approx([1.0])
    assert heap.tops(*beside[1:], np.array([0.0]), np.array([1.0])) == pytest.approx([0.25])


def test_the_map_shows_the_highest_stone():
    pieces = list(heap.placed(saved_stones()))
    x, y, height = heap.surface(pieces, 0.01)
    near = np.hypot(x - 5, y - 5) < 0.02
    assert height[near].max() == pytest.approx(6.0, abs=1e-3)
    assert height[np.hypot(x - 3, y - 3) < 0.5].max() == 0
