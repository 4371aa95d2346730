import numpy as np
import pytest

from core.linalg import patches
from core.linalg.laplacian import divergence
from core.linalg.patches import cover


@pytest.mark.parametrize("size", [1, 30, 1000])
def test_patches_cover_what_is_marked_with_all_that_lies_beside_it(size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(patches, "_NODES", size)
    rng = np.random.default_rng(1)
    marked = rng.random((17, 13)) < 0.1
    marked[0, 0] = marked[-1, -1] = True
    across, down, quads = rng.random((17, 12)), rng.random((16, 13)), rng.random((16, 12))
    found = np.full(marked.shape, np.nan)
    for patch in cover(marked):
        rows, columns = quads[patch.quads].shape
        assert across[patch.across].shape == (rows + 1, columns)
        assert down[patch.down].shape == (rows, columns + 1)
        assert np.isnan(found[patch.write]).all()
        found[patch.write] = divergence(across[patch.across], down[patch.down])[patch.inner]
    np.testing.assert_array_equal(found[marked], divergence(across, down)[marked])


def test_nothing_is_covered_where_nothing_is_marked() -> None:
    assert not list(cover(np.zeros((5, 6), bool)))
