"""Lattice vectors from keypoints that look alike."""

import numpy as np

from core.overlay.keypoints import FIRST_SUPPORT, alike_keypoints, propose_from_keypoints
from core.overlay.seeding import flat_canvas
from tests.core.overlay_scenes import make_scene, motif


def test_smaller_groups_of_keypoints_have_less_support() -> None:
    scene = make_scene(motif(), noise=0.002)
    valid = np.ones(scene.shading.shape, bool)
    groups = alike_keypoints(flat_canvas(scene.photo, valid).image, valid, np.random.default_rng(0))
    assert [len(group) for group in groups] == sorted((len(group) for group in groups), reverse=True)
    found = propose_from_keypoints(groups)
    supports = [proposal.support for proposal in found]
    assert supports[0] == FIRST_SUPPORT
    assert supports == sorted(supports, reverse=True)
    assert 0.3 < supports[-1] < FIRST_SUPPORT
