"""Masks by how far pixels lie from them."""

import numpy as np

from core.overlay.filters.distances import open_by_disc


def test_what_discs_cover_of_a_mask_is_kept() -> None:
    mask = np.zeros((30, 40), bool)
    mask[10:21, 4:20] = mask[14:17, 20:36] = True
    kept = open_by_disc(mask, 3.0)
    assert kept[14:17, 6:18].all()
    assert not kept[:, 22:].any()
    assert not (kept & ~mask).any()
    assert open_by_disc(np.ones((9, 9), bool), 20.0).all()
    assert not open_by_disc(np.zeros((9, 9), bool), 2.0).any()
