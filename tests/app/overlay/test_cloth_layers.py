"""The pyramid of a decomposed photo's layers, block by block."""

import numpy as np
import pytest

from app.render.sources import cloth_layers
from app.render.sources.cloth_layers import NEAR, full_level, half_of
from core.imaging.images import Image
from core.overlay.laying.compositing import Parts

HEIGHT, WIDTH = 23, 31


def parts() -> Parts:
    """Make cloth of two pieces, with holes."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    uv = np.stack([x / 9 + 30 * (x > y + 4), y / 7], -1)
    uv[rng.random((HEIGHT, WIDTH)) < 0.15] = np.nan
    bare = ~np.isfinite(uv[..., 0])
    shading = rng.random((HEIGHT, WIDTH)).astype(np.float32)
    detail = rng.normal(0, 0.1, (HEIGHT, WIDTH, 3)).astype(np.float32)
    shading[bare], detail[bare] = np.nan, np.nan
    photo = Image(rng.integers(0, 256, (HEIGHT, WIDTH, 3)).astype(np.uint8))
    coverage = np.where(bare, 0, rng.random((HEIGHT, WIDTH)))
    return Parts(photo, uv, shading, detail, coverage, np.eye(2), np.zeros((2, 2, 3)))


@pytest.mark.parametrize("band", [2, 256])
def test_a_coarser_level_has_the_means_of_what_is_cloth_and_keeps_pieces_apart(
    band: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cloth_layers, "BAND", band)
    cloth = parts()
    level = half_of(lambda rows: full_level(cloth, cloth.source, rows), (WIDTH, HEIGHT))
    assert level.coordinates.shape[:2] == (12, 16)
    apart = 0
    for row, column in np.ndindex(12, 16):
        # The border repeats.
        rows = np.minimum([2 * row, 2 * row, 2 * row + 1, 2 * row + 1], HEIGHT - 1)
        columns = np.minimum([2 * column, 2 * column + 1, 2 * column, 2 * column + 1], WIDTH - 1)
        uv = cloth.uv[rows, columns]
        inside = np.isfinite(uv[:, 0])
        u, v, on_cloth, coverage = level.coordinates[row, column]
        assert on_cloth == inside.any()
        assert coverage == pytest.approx(cloth.coverage[rows, columns].mean(), abs=1e-5)
        if not inside.any():
            assert (u, v) == (0, 0)
            continue
        own = uv[inside]
        is_torn = np.abs(own - own[0]).max() > NEAR
        apart += is_torn
        np.testing.assert_allclose((u, v), own[0] if is_torn else own.mean(0), atol=1e-4)
        light = cloth.shading[rows, columns][inside].mean()
        np.testing.assert_allclose(level.shading[row, column, :3], light, atol=1e-3)
        detail = cloth.detail[rows, columns][inside].mean(0)
        np.testing.assert_allclose(level.detail[row, column, :3], detail, atol=1e-3)
        seen = cloth.source.pixels[rows, columns].mean(0) / 255
        np.testing.assert_allclose(level.photo[row, column], [*seen, 1.0], atol=1e-3)
    assert apart > 3
