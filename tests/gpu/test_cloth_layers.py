"""The pyramid of a decomposed photo's layers, block by block."""

import numpy as np
import pytest

from app.render import gpu
from app.render.sources import cloth_layers
from app.render.sources.cloth_layers import ClothLayers
from core.arrays import Singles
from core.imaging.images import Image
from core.overlay.laying.compositing import Parts

pytestmark = pytest.mark.gpu
HEIGHT, WIDTH = 23, 31
NEAR = 0.5
"""As in halve_cloth.frag."""


def parts() -> Parts:
    """Make cloth of two pieces, with holes."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    uv = np.stack([x / 9 + 30 * (x > y + 4), y / 7], -1).astype(np.float32)
    uv[rng.random((HEIGHT, WIDTH)) < 0.15] = np.nan
    bare = ~np.isfinite(uv[..., 0])
    shading = rng.random((HEIGHT, WIDTH)).astype(np.float32)
    detail = rng.normal(0, 0.1, (HEIGHT, WIDTH, 3)).astype(np.float32)
    shading[bare], detail[bare] = np.nan, np.nan
    photo = Image(rng.integers(0, 256, (HEIGHT, WIDTH, 3)).astype(np.uint8))
    coverage = np.where(bare, 0, rng.random((HEIGHT, WIDTH))).astype(np.float32)
    return Parts(photo, uv, shading, detail, coverage, np.eye(2), np.zeros((2, 2, 3)))


def averaged(cloth: Parts, level: int) -> list[Singles]:
    """Return coordinates and coverage, shading, detail and photo of a level, (h, w, 4) each."""
    layers = ClothLayers(gpu.standalone(), cloth, cloth.source)
    layers.use((0, 0, 32, 24), level)
    dtypes = (np.float32, np.float16, np.float16, np.float16)
    read = [
        np.frombuffer(texture.read(), dtype).reshape(texture.height, texture.width, 4).astype(np.float32)
        for texture, dtype in zip(layers.textures, dtypes, strict=True)
    ]
    layers.release()
    return read


@pytest.mark.parametrize("band", [2 * WIDTH, 1 << 20])
def test_a_coarser_level_has_the_means_of_what_is_cloth_and_keeps_pieces_apart(
    band: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cloth_layers, "BAND_PIXELS", band)
    cloth = parts()
    coordinates, shading, details, photo = averaged(cloth, 1)
    assert coordinates.shape[:2] == (12, 16)
    apart = 0
    for row, column in np.ndindex(12, 16):
        # The border repeats.
        rows = np.minimum([2 * row, 2 * row, 2 * row + 1, 2 * row + 1], HEIGHT - 1)
        columns = np.minimum([2 * column, 2 * column + 1, 2 * column, 2 * column + 1], WIDTH - 1)
        uv = cloth.uv[rows, columns]
        inside = np.isfinite(uv[:, 0])
        u, v, on_cloth, coverage = coordinates[row, column]
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
        np.testing.assert_allclose(shading[row, column, :3], light, atol=1e-3)
        detail = cloth.detail[rows, columns][inside].mean(0)
        np.testing.assert_allclose(details[row, column, :3], detail, atol=1e-3)
        seen = cloth.source.pixels[rows, columns].mean(0) / 255
        np.testing.assert_allclose(photo[row, column], [*seen, 1.0], atol=1e-3)
    assert apart > 3


def test_the_next_level_goes_on_from_the_last_one() -> None:
    cloth = parts()
    coordinates, _, details, photo = averaged(cloth, 1)
    coarser = averaged(cloth, 2)
    assert coarser[0].shape[:2] == (6, 8)
    blocks = photo.reshape(6, 2, 8, 2, 4).mean((1, 3))
    np.testing.assert_allclose(coarser[3], blocks, atol=1e-3)
    on_cloth = coordinates[..., 2:3].reshape(6, 2, 8, 2, 1)
    means = (on_cloth * details.reshape(6, 2, 8, 2, 4)).sum((1, 3)) / np.maximum(on_cloth.sum((1, 3)), 1)
    np.testing.assert_allclose(coarser[2][..., :3], means[..., :3], atol=1e-3)
