"""Vertices of cloth whose coordinates come twice."""

import numpy as np

from core.arrays import Floats, Ints
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.corrections import lattices_of
from core.overlay.detection.lattice import Lattice
from core.overlay.registration.multivalued_lattice import lay_apart

BASIS = np.array([[20.0, 3.0], [-2.0, 22.0]])


def grid(first: tuple[int, int], size: tuple[int, int]) -> Ints:
    return np.stack(np.meshgrid(*(np.arange(n) + k for n, k in zip(size, first, strict=True))), -1).reshape(-1, 2)


def lattice(keys: Ints, points: Floats) -> Lattice:
    return Lattice(keys, PatchFrames(points, np.tile(BASIS, (len(keys), 1, 1)), np.ones(len(keys))))


def test_copies_of_a_vertex_at_one_place_are_one_and_keep_their_coordinates() -> None:
    keys = grid((-2, 3), (5, 4))
    found = lay_apart(lattice(np.tile(keys, (2, 1)), np.tile(keys, (2, 1)) @ BASIS.T))
    assert sorted(map(tuple, found.keys.tolist())) == sorted(map(tuple, keys.tolist()))
    assert np.allclose(found.frames.points, found.keys @ BASIS.T)


def test_a_vertex_at_two_places_is_two_vertices_of_lattices_that_do_not_meet() -> None:
    large, small = grid((0, 0), (6, 5)), grid((3, 2), (4, 4))
    points = np.concatenate([large @ BASIS.T, small @ BASIS.T + [210.0, -15.0]])
    found = lay_apart(lattice(np.concatenate([large, small]), points))
    parts = lattices_of(found.keys, found.frames.points)
    assert [len(part) for part in parts] == [30, 16]
    assert np.allclose(parts[0].frames.points, parts[0].keys @ BASIS.T)
    back = parts[1].frames.points - [210.0, -15.0]
    moved = parts[1].keys - back @ np.linalg.inv(BASIS).T
    assert np.allclose(moved, np.rint(moved[0]))
    assert moved[0].any()


def test_steps_that_disagree_with_the_vectors_are_none() -> None:
    left, right = grid((0, 0), (4, 4)), grid((4, 0), (3, 4))
    points = np.concatenate([left @ BASIS.T, right @ BASIS.T + [0.0, 60.0]])
    found = lay_apart(lattice(np.concatenate([left, right]), points))
    assert [len(part) for part in lattices_of(found.keys, found.frames.points)] == [16, 12]


def test_islands_keep_the_coordinates_that_they_share() -> None:
    keys = np.concatenate([grid((0, 0), (4, 4)), grid((7, 1), (3, 3))])
    found = lay_apart(lattice(keys, keys @ BASIS.T))
    assert np.allclose(found.frames.points, found.keys @ BASIS.T)
    assert len(found) == 25


def test_two_ways_around_that_do_not_meet_are_cut() -> None:
    across = [(i, 0) for i in range(6)]
    down = [(0, j) for j in range(1, 5)] + [(i, 4) for i in range(1, 6)]
    up = [(5, j) for j in (3, 2, 1)]
    keys = np.array(across + down + up)
    # Steps that are each a little too long lead (5, 1) to where (5, 0) is.
    at = np.array([*across, *down, *[(5, 4 - 1.3 * (4 - j)) for _, j in up]])
    found = lay_apart(lattice(keys, at @ BASIS.T))
    assert len(found) == len(keys)
    for i, j in found.keys.tolist():
        rows = [(found.keys == [i + di, j + dj]).all(1) for di, dj in ((0, 0), (0, 1))]
        here, below = (found.frames.points[row] for row in rows)
        assert not len(below) or np.linalg.norm(below - here - BASIS[:, 1]) < 12
