"""What retexturing finds: for every pixel of the result its place in the source, to resample any layer once."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from dataclasses import field as default

import numpy as np

from core.arrays import Bools, Floats, InputError, Ints, Pixels, Singles
from core.curves.bezier import Curve
from core.imaging import color
from core.retexture.deformation.diffusion import Diffusion
from core.retexture.origins import Origins
from core.retexture.picture.area_filter import Boxes, average, boxes
from core.retexture.picture.overshoot import ColourLimits
from core.retexture.picture.poisson_blend import correction
from core.retexture.picture.seam_antialiasing import SHARE, Mixture, across_seams
from core.retexture.prefetch import prefetch
from core.retexture.sampling import Kernel, read, read_stored
from core.retexture.windows import Window, mirrored_span

BAND = 128
"""Rows resampled at a time."""
STILL_PX = 1e-4
"""What moves less is copied as it is."""
AROUND_PX = 4
"""What is read between pixels lies this far around them."""
MARGIN_PX = 40
"""Corrections have faded this far from a seam."""


@dataclass(frozen=True, eq=False)
class Retexture:
    """Source coordinates of a picture whose curves were moved; a preview while the job runs, or its result."""

    grid: Diffusion
    field: Floats
    """(R, C, 2) D of the plain deformation at the grid's nodes."""
    place: Singles
    """(H, W, 2) where each pixel comes from, (x, y) in the source."""
    label: Ints
    """(H, W) number of the patch that each pixel shows; 0 is the plain deformation."""
    origins: tuple[Origins, ...] = ()
    """Where the patches were grown."""
    compression: Floats = default(default_factory=lambda: np.empty((0, 0)))
    """(R, C) at the nodes, from 1 to 3."""
    edges: tuple[Curve, ...] = ()
    """Long edges of the source that were kept as passive curves."""
    candidates: int = 0
    """How many were compared."""
    seconds: dict[str, float] = default(default_factory=dict)
    final: bool = False

    @property
    def patches(self) -> int:
        """The number of patches synthesised."""
        return sum(len(origins) for origins in self.origins)

    @property
    def seams(self) -> Bools:
        """(H, W) pixels whose right or lower neighbour shows another patch."""
        mask = np.zeros(self.label.shape, bool)
        mask[:, :-1] |= self.label[:, 1:] != self.label[:, :-1]
        mask[:-1] |= self.label[1:] != self.label[:-1]
        return mask

    def apply(self, layer: Pixels, *, linear: bool = False, blend: bool = True) -> Pixels:
        """Return a layer (H, W, C) of the source's size, retextured, at its own depth.

        `linear` says that its numbers are linear light, or no light at all. With `blend` visible seams are corrected;
        without, the picture is a quick one, by a smaller kernel and of values as they are stored.
        Raises `InputError` for another size.
        """
        if not blend:
            return self._quickly(layer)
        mixture, box = across_seams(self.place, self.label), self._box()
        with ThreadPoolExecutor(1) as helper:
            change = helper.submit(self._correction, layer, box) if box else None
            result = self._resampled(layer, lambda rows: self.place[rows], mixture, linear=linear)
        if box and change and (steps := change.result()) is not None:
            encoded = color.premultiply(color.unit(result[box]))
            shown = self.label[box] > 0
            low, high = (color.unit(np.asarray(limit)) for limit in (layer.min(), layer.max()))
            corrected = color.unpremultiply(np.clip(encoded + steps, low, high))
            result[box][shown] = color.quantise(corrected, layer.dtype)[shown]
        return result

    def deformed(self, layer: Pixels, *, linear: bool = False) -> Pixels:
        """Return a layer (H, W, C) under the plain deformation, at its own depth."""
        return self._resampled(layer, self._plain, None, linear=linear)

    def _quickly(self, layer: Pixels) -> Pixels:
        self._check(layer)
        if color.color_channels(layer.shape[2]) == layer.shape[2]:
            return read_stored(layer, self.place)
        light = read(color.premultiply(color.unit(layer)), self.place, Kernel.CUBIC, mirror=True)
        return color.quantise(color.unpremultiply(light), layer.dtype)

    def _check(self, layer: Pixels) -> None:
        if layer.shape[:2] != self.label.shape:
            (height, width), (h, w) = self.label.shape, layer.shape[:2]
            raise InputError(f"a layer of {w}x{h} pixels does not fit a picture of {width}x{height}")

    def _plain(self, rows: slice) -> Singles:
        return plain_place(self.grid, self.field, (rows, slice(0, self.label.shape[1])))

    def _resampled(
        self, layer: Pixels, place: Callable[[slice], Singles], mixture: Mixture | None, *, linear: bool
    ) -> Pixels:
        self._check(layer)
        low, high = _extremes(layer, linear=linear)
        result = layer.copy()

        def resample(start: int) -> None:
            rows = slice(start, min(start + BAND, layer.shape[0]))
            at = place(rows)
            way = np.abs(at - _pixels(rows, layer.shape[1]))
            moved = np.maximum(way[..., 0], way[..., 1]) > STILL_PX
            if not moved.any():
                return
            across = None if mixture is None else mixture.rows(rows.start, rows.stop, layer.shape[1])
            pressed = None if mixture is None else self._pressed(rows)
            # Of a large picture, the light of what these rows show is little beside that of all.
            further = [] if across is None or pressed is None else [across.place, pressed.corners(at)]
            window = _window_of([at, *further], layer)
            origin = np.array([window[1].start, window[0].start], np.float32)
            source = color.premultiply(color.linear_light(layer[window], linear=linear))
            light = read(source, at - origin, Kernel.LANCZOS, mirror=True)
            ColourLimits(source, linear=linear).hold(light, at - origin)
            if across is not None and pressed is not None:
                average(light, source, at, pressed, origin)
                _mix(light, source, Mixture(across.pixel, across.place - origin))
            # The kernel overshoots beside edges; nothing becomes brighter or darker than the whole layer.
            light = np.clip(light, low, high)
            stored = color.store(color.unpremultiply(light), depth=layer.dtype, linear=linear)
            np.copyto(result[rows], stored, where=moved[..., None])

        for _ in prefetch(resample, range(0, layer.shape[0], BAND)):
            pass
        return result

    def _pressed(self, rows: slice) -> Boxes:
        """Return which pixels of patches, in some rows, show several of the source."""
        around = slice(max(rows.start - 1, 0), min(rows.stop + 1, len(self.label)))
        found = boxes(self.place[around], self.label[around])
        return found.rows(rows.start - around.start, rows.stop - around.start, self.label.shape[1])

    def _correction(self, layer: Pixels, box: tuple[slice, slice]) -> Singles | None:
        """Return what to add to a `box` of the result, premultiplied, to hide seams; None where none is visible."""
        place = self.place[box]
        low = np.maximum(np.floor(place.min(axis=(0, 1))).astype(int) - AROUND_PX, 0)
        high = np.maximum(np.ceil(place.max(axis=(0, 1))).astype(int) + AROUND_PX, low + 1)
        source = color.premultiply(color.unit(layer[low[1] : high[1], low[0] : high[0]]))
        return correction(source, place - low.astype(np.float32), self.label[box])

    def _box(self) -> tuple[slice, slice] | None:
        """Return rows and columns around all patches, with room for corrections to fade."""
        rows, columns = (np.flatnonzero((self.label > 0).any(axis=axis)) for axis in (1, 0))
        if not len(rows):
            return None
        first = max(rows[0] - MARGIN_PX, 0), max(columns[0] - MARGIN_PX, 0)
        return slice(first[0], rows[-1] + MARGIN_PX), slice(first[1], columns[-1] + MARGIN_PX)


def _extremes(layer: Pixels, *, linear: bool) -> tuple[float, float]:
    """Return the least and the greatest of a layer's numbers (H, W, C) as premultiplied linear light."""
    bands = (layer[top : top + BAND] for top in range(0, len(layer), BAND))
    light = (color.premultiply(color.linear_light(band, linear=linear)) for band in bands)
    low, high = zip(*((float(band.min()), float(band.max())) for band in light), strict=True)
    return min(low), max(high)


def _window_of(places: list[Singles], layer: Pixels) -> Window:
    """Return which part of a layer (H, W, C) is read at `places` (..., 2), the border being a mirror."""
    some = [at.reshape(-1, 2) for at in places if at.size]
    low = np.floor(np.min([at.min(axis=0) for at in some], axis=0)).astype(int) - AROUND_PX
    high = np.ceil(np.max([at.max(axis=0) for at in some], axis=0)).astype(int) + AROUND_PX
    columns, rows = (mirrored_span(int(low[i]), int(high[i]), layer.shape[1 - i]) for i in (0, 1))
    return rows, columns


def _mix(light: Singles, source: Singles, mixture: Mixture) -> None:
    """Mix into pixels of `light` (h, w, C) what they show of the patches across their seams."""
    flat = light.reshape(-1, light.shape[2])
    other = read(source, mixture.place, Kernel.LANCZOS, mirror=True)
    np.add.at(flat, mixture.pixel, np.float32(SHARE) * (other - flat[mixture.pixel]))


def plain_place(grid: Diffusion, field: Floats, window: tuple[slice, slice]) -> Singles:
    """Return where the pixels (h, w, 2) of a window of the plain deformation come from."""
    rows, columns = window
    return _pixels(rows, columns.stop, columns.start) + grid.at_pixels(field, window)


def _pixels(rows: slice, stop: int, start: int = 0) -> Singles:
    """Return the positions (h, w, 2) of the pixels of some rows, columns `start` to `stop`."""
    x, y = np.meshgrid(np.arange(start, stop, dtype=np.float32), np.arange(rows.start, rows.stop, dtype=np.float32))
    return np.stack([x, y], axis=-1)
