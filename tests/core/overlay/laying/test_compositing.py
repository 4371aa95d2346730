"""Laying a composition over its photo, whatever kind of picture both are."""

import numpy as np
import pytest

from core.imaging.color import quantise
from core.imaging.image import Image
from core.overlay.composition import Placement, compose
from core.overlay.filters import bands
from core.overlay.laying.compositing import Parts, encode, lay_over, searchable, texture_colours
from core.overlay.registration.region import feather
from tests.core.overlay.overlay_scenes import grid

RNG = np.random.default_rng(0)
SCALE = np.array([[20.0, 2.0], [0.0, 18.0]])


def parts(source: Image) -> Parts:
    """Return a cloth on the right of a picture (40, 50)."""
    bent = grid() + np.stack([np.sin(grid()[..., 1] * 9), np.cos(grid()[..., 1] * 7)], -1)
    uv, shading, detail = bent, 0.5 + grid()[..., 0] / 5, RNG.normal(0, 0.05, (40, 50, 3))
    coverage = np.clip((np.indices((40, 50))[1] - 11.0) / 4, 0, 1)
    for layer in (uv, shading, detail):
        layer[:, :12] = np.nan
    layers = [layer.astype(np.float32) for layer in (uv, shading, detail, coverage)]
    return Parts(source, layers[0], layers[1], layers[2], layers[3], SCALE, RNG.random((9, 11, 3)))


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_beside_the_cloth_every_bit_is_the_photo(dtype: type) -> None:
    values = RNG.random((40, 50, 4))
    source = Image(
        (values if dtype is np.float32 else values * np.iinfo(dtype).max).astype(dtype), linear=dtype is np.float32
    )
    out = lay_over(parts(source), RNG.random((8, 8, 3)), Placement(), alpha=1.0, strength=1.0).pixels
    assert np.array_equal(out[:, :12], source.pixels[:, :12])
    assert np.array_equal(out[..., 3], source.pixels[..., 3])
    assert (out[:, 15:, :3] != source.pixels[:, 15:, :3]).any(-1).mean() > 0.9


KINDS = [(channels, dtype) for channels in (1, 2, 3, 4) for dtype in (np.uint8, np.uint16, np.float32)]


def of_kind(size: tuple[int, int], channels: int, dtype: type) -> Image:
    """Return a picture of random colours, opaque where it has alpha."""
    values = RNG.random((*size, channels), np.float32)
    values[..., 1 if channels == 2 else 3 :] = 1.0
    return Image(quantise(values, dtype), linear=dtype is np.float32)


@pytest.mark.parametrize("photo_kind", KINDS)
@pytest.mark.parametrize("texture_kind", KINDS)
def test_any_kind_of_texture_goes_on_any_kind_of_photo(
    photo_kind: tuple[int, type], texture_kind: tuple[int, type]
) -> None:
    source, new = of_kind((40, 50), *photo_kind), of_kind((8, 8), *texture_kind)
    cloth, texture = parts(source), texture_colours(new)
    image = lay_over(cloth, texture, Placement(), alpha=0.0, strength=0.0)
    is_grey = max(source.channels, new.channels) <= 2
    assert image.channels == (1 if is_grey else 3) + source.has_alpha
    assert image.pixels.dtype == source.pixels.dtype
    assert np.allclose(encode(image)[:, :12], encode(source)[:, :12], atol=1e-6)
    if source.has_alpha:
        assert np.array_equal(image.pixels[..., -1], source.pixels[..., -1])
    uv, shading, detail = (layer.astype(np.float64) for layer in (cloth.uv, cloth.shading, cloth.detail))
    expected = compose(texture, uv, shading, detail, SCALE, alpha=0.0, strength=0.0)[0]
    assert np.allclose(encode(image)[:, 16:], np.clip(expected, 0, 1)[:, 16:], atol=1 / 255)


def test_bands_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    cloth = parts(Image(RNG.integers(0, 65535, (40, 50, 3)).astype(np.uint16)))
    texture, placement = RNG.random((30, 30, 3)), Placement((3.0, 0.7), 20.0)
    whole = lay_over(cloth, texture, placement, alpha=0.7, strength=1.4).pixels
    monkeypatch.setattr(bands, "ROWS", 7)
    assert np.array_equal(lay_over(cloth, texture, placement, alpha=0.7, strength=1.4).pixels, whole)


def test_a_photo_takes_as_much_detail_and_shading_as_is_asked_for() -> None:
    cloth, white = parts(Image(np.zeros((40, 50, 3), np.uint16))), np.ones((4, 4, 3))
    flat = lay_over(cloth, white, Placement(), alpha=0.0, strength=0.0).pixels[:, 16:] / 65535
    assert np.allclose(flat, np.nanmedian(cloth.shading), atol=1e-4)
    rough = lay_over(cloth, 0.5 * white, Placement(), alpha=0.5, strength=0.0).pixels[:, 16:] / 65535
    assert np.allclose(rough, 0.5 * np.nanmedian(cloth.shading) + 0.5 * cloth.detail[:, 16:], atol=1e-4)


def test_a_texture_that_is_half_transparent_lets_half_of_the_photo_through() -> None:
    veil = np.dstack([np.full((6, 6, 3), 0.8), np.full((6, 6), 0.5)])
    cloth = parts(Image(np.zeros((40, 50, 3), np.uint16)))
    out = lay_over(cloth, veil, Placement(), alpha=0.0, strength=0.0).pixels[:, 16:] / 65535
    assert np.allclose(out, 0.5 * 0.8 * np.nanmedian(cloth.shading), atol=1e-4)


def test_the_edge_of_the_cloth_is_as_soft_as_its_coverage() -> None:
    photo, white = Image(np.full((40, 50, 3), 30000, np.uint16)), np.ones((4, 4, 3))
    cloth = parts(photo)
    out = lay_over(cloth, white, Placement(), alpha=0.0, strength=0.0).pixels[:, 12:15] / 65535
    share = cloth.coverage[:, 12:15, None]
    assert 0.1 < share.min() < share.max() < 0.9
    expected = share * np.nanmedian(cloth.shading) + (1 - share) * 30000 / 65535
    assert np.allclose(out, expected, atol=1e-4)


def test_coverage_falls_over_the_last_pixel_before_the_border() -> None:
    inside = np.zeros((9, 20), bool)
    inside[:, 8:] = True
    row = feather(inside)[4]
    assert np.allclose(row[7:12], [0.0, 1 / 2, 1.0, 1.0, 1.0], atol=0.05)
    assert row[-1] == 1.0


@pytest.mark.parametrize(("dtype", "most"), [(np.uint8, 255), (np.uint16, 65535), (np.float32, 1)])
def test_of_a_photo_with_alpha_what_is_opaque_is_searched_and_all_of_it_is_no_region(dtype: type, most: int) -> None:
    alpha = np.ones((4, 5, 4), np.bool_)
    assert searchable(Image((most * alpha).astype(dtype), linear=most == 1), None) is None
    alpha[1, 2:, 3] = False
    opaque = searchable(Image((most * alpha).astype(dtype), linear=most == 1), None)
    assert opaque is not None
    assert np.array_equal(opaque, alpha[..., 3])
