"""Lattice vectors from keypoints that look alike."""

import numpy as np

from core.overlay.detection.keypoints import alike_keypoints, propose_from_keypoints
from core.overlay.detection.seeding import flat_canvas
from tests.core.overlay.overlay_scenes import make_scene, motif


def test_proposals_come_from_the_largest_groups_first() -> None:
    scene = make_scene(motif(), noise=0.002)
    valid = np.ones(scene.shading.shape, bool)
    groups = alike_keypoints(flat_canvas(scene.photo, valid).image, valid, np.random.default_rng(0))
    sizes = [len(group) for group in groups]
    assert sizes == sorted(sizes, reverse=True)
    first = propose_from_keypoints(groups)[0]
    assert np.linalg.norm(groups[0] - first.point, axis=1).min() == 0
    steps = np.linalg.solve(scene.basis, first.basis)
    assert np.abs(steps - np.rint(steps)).max() < 0.2
