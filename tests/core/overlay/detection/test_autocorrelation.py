"""The correlation of cloth with itself, and the vectors that it proposes."""

import numpy as np

from core.overlay.detection.autocorrelation import OVERLAP, autocorrelate, propose_bases
from tests.core.overlay.overlay_scenes import make_scene, marked_checks
from tests.core.overlay.prints import painted


def test_it_is_the_correlation_of_what_is_valid_in_both() -> None:
    rng = np.random.default_rng(0)
    image, valid = rng.random((20, 26, 3)).astype(np.float32), np.zeros((20, 26), np.bool_)
    valid[3:17, 4:21], valid[6:9, 8:12] = True, False
    found = autocorrelate(np.where(valid[..., None], image, 7), valid)
    assert found.shape == (40, 52)
    for x, y in ((0, 0), (3, 0), (-5, 2), (4, 7), (-6, -3)):
        here = np.array(
            [(r, c) for r, c in np.argwhere(valid) if 0 <= r + y < 20 and 0 <= c + x < 26 and valid[r + y, c + x]]
        )
        a, b = (image[tuple(places.T)].astype(float) for places in (here, here + [y, x]))
        a, b = a - a.mean(0), b - b.mean(0)
        assert np.isclose(found[20 + y, 26 + x], (a * b).sum() / np.sqrt((a * a).sum() * (b * b).sum()), atol=1e-5)
    assert not found[0].any()
    enough = round(OVERLAP * valid.sum())
    assert all(found[20, 26 + x] == 0 for x in range(26) if (valid[:, : 26 - x] & valid[:, x:]).sum() < enough)


def test_vectors_of_bent_cloth_are_proposed_and_those_of_other_sizes_are_not() -> None:
    basis = np.array([[22.0, 3.0], [-2.0, 20.0]])
    for scale, is_proposed in ((1.0, True), (0.5, False), (2.2, False)):
        scene = make_scene(marked_checks(), size=(150, 160), basis=scale * basis, bend=2.0)
        canvas = painted(scene.photo)
        steps = [np.linalg.solve(scene.basis, found) for found in propose_bases(canvas.image, canvas.valid[..., 0] > 0)]
        hits = [np.abs(one - np.rint(one)).max() < 0.1 and abs(round(np.linalg.det(one))) == 1 for one in steps]
        assert any(hits[:3]) == is_proposed
