"""The layers of a cloth that go with a new texture: light and detail without the old pattern."""

from math import ceil

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.composition import finite
from core.overlay.detail.residual_cleanup import without_old_pattern
from core.overlay.detail.sparse_reflectance import estimate_bare_light, find_reflectance, find_shade, spread_of
from core.overlay.filters.bands import in_bands
from core.overlay.filters.shrinking import working_scale
from core.overlay.mesh import around, boxes_of
from core.overlay.palette import MANY, palette
from core.overlay.texel import Texel
from core.overlay.tolerances import MOTIF_PX

BESIDE = 2.0
"""Texels beside cloth that changed from which its light and its detail are told."""


def find_bare_layers(
    detail: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats, *, scale: int | None = None
) -> tuple[Singles, Singles]:
    """Return the shading, in its own shape, and the detail (H, W, 3) of the cloth alone, to go with another texture.

    `uv` (H, W, 2), `shading` (H, W) or (H, W, 3) and `detail` are NaN outside the cloth; `basis` (2, 2) is pixels of
    undeformed cloth a texel. What the photo has over the colours of the pattern in that light, wherever these lie, is
    detail, freed of what the texel does not tell of the pattern. Where that is a shade of the cloth's colour it is a
    fold, and light: so a shadow on red cloth is grey on a grey texture, and as deep on a bright one as on a dark one.
    What is only a part of a picture goes with the `scale` of the whole (`scale_of`).
    """
    covered = finite(uv)
    if not covered.any():
        return shading, detail
    box = around(covered)
    own_scale = scale_of(uv) if scale is None else scale
    light, kept = _find_bare(detail[box], uv[box], shading[box], texel, basis, own_scale)
    if kept.shape == detail.shape:
        return light, kept
    layers = np.full_like(shading, np.nan), np.full_like(detail, np.nan)
    layers[0][box], layers[1][box] = light, kept
    return layers


def scale_of(uv: Singles) -> int:
    """Return how much larger the cloth at uv (H, W, 2) is shown than in a photo of the working size."""
    rows, columns = around(finite(uv))
    return max(working_scale((rows.stop - rows.start, columns.stop - columns.start)), 1)


def update_bare_layers(
    before: tuple[Singles, Singles],
    detail: Singles,
    uv: Singles,
    shading: Singles,
    texel: Texel,
    basis: Floats,
    changed: Bools,
) -> tuple[Singles, Singles]:
    """Return `before`, and where cloth has `changed` (H, W) what `find_bare_layers` tells from what is around that.

    What all of the cloth would tell hardly differs.
    """
    if not changed.any():
        return before
    side_px, scale = float(np.sqrt(abs(np.linalg.det(basis)))), scale_of(uv)
    out = before[0].copy(), before[1].copy()
    for box in boxes_of(changed, ceil(BESIDE * side_px)):
        own = changed[box]
        parts = find_bare_layers(detail[box], uv[box], shading[box], texel, basis, scale=scale)
        for whole, part in zip(out, parts, strict=True):
            whole[box][own] = part[own]
    return out


def _find_bare(
    detail: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats, scale: int
) -> tuple[Singles, Singles]:
    """Do what `find_bare_layers` does for a picture that has cloth up to all of its edges."""
    colours = shading if shading.ndim == 3 else shading[..., None]
    own, rest = colours.mean(-1), np.empty_like(detail)
    light = estimate_bare_light((detail, uv, own), texel, basis, scale)
    changed = colours * (light / np.maximum(own, 1e-6))[..., None]
    known, off = palette(texel, MANY), spread_of(detail, finite(uv))

    def photo_of(rows: slice) -> tuple[Singles, Singles]:
        shown = texel.singles(np.nan_to_num(uv[rows]).astype(np.float64))
        return shown, detail[rows] + colours[rows] * shown

    def take_out_colours(_first: int, top: int, bottom: int, _last: int) -> None:
        rows = slice(top, bottom)
        shown, photo = photo_of(rows)
        rest[rows] = photo - changed[rows] * find_reflectance(photo, changed[rows], shown, known, off)

    in_bands(take_out_colours, detail.shape)
    clean = without_old_pattern(rest, uv, changed, texel, basis)
    shaded, kept = np.empty_like(changed), np.empty_like(clean)

    def turn_to_light(first: int, top: int, bottom: int, last: int) -> None:
        part, rows, own = slice(first, last), slice(top, bottom), slice(top - first, bottom - first)
        seen = np.nan_to_num(photo_of(part)[1] - rest[part])
        share = find_shade(np.nan_to_num(clean[part]), seen, off)[own]
        shaded[rows], kept[rows] = changed[rows] * (1 + share), clean[rows] - share * seen[own]

    in_bands(turn_to_light, detail.shape, margin=int(4 * MOTIF_PX))
    return shaded.reshape(shading.shape), kept
