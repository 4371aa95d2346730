"""What bodies that nothing holds, or one point, may do, and how that moves points of theirs."""

import numpy as np

from core.mapping.handles.motions import Motions, Poses

STEP = 1e-6


def test_unknown_motions_are_what_bodies_do_at_first() -> None:
    """The first body is free, the second turns about a pin, the third stays as it is."""
    random = np.random.default_rng(0)
    arms = [random.normal(size=n) + 1j * random.normal(size=n) for n in (3, 2, 4)]
    about = np.array([0, 0.4 - 0.7j, 0])
    motions = Motions.of([4, 1, 2], arms, 2, about, np.array([1, 1, 0], bool), np.array([1, 0, 0], bool))
    alpha, t = random.normal(size=(2, 5)) + 1j * random.normal(size=(2, 5))
    pivots = np.full(5, np.nan, np.complex128)
    pivots[1] = t[1] + alpha[1] * about[1]
    along = motions.directions(alpha)
    assert len(along) == 4
    for number in range(4):
        poses = Poses(alpha.copy(), t.copy(), pivots)
        motions.move(poses, STEP * np.eye(4)[number])
        moved = motions.displace(poses, alpha, t) / STEP
        assert np.abs(moved).max() > 0.1
        assert np.abs(moved - motions.unknown.toarray()[:, number] * along[number]).max() < 1e-5
