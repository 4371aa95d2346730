"""Synthesis: grow patches in order, choose a candidate for each and merge it (DPD sec. 3.4)."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np

from core.arrays import Bools, Ints, Singles
from core.progress import Job, Progress
from core.retexture.candidates import CHANCE, Pool, costs, drift
from core.retexture.canvas import CELL, Canvas
from core.retexture.layout import Correspondence, Lattice, Origins, gap_places, ordered_origins
from core.retexture.patches import Batch, Fields, Patches, PatchShape, within
from core.retexture.sampling import Kernel, read
from core.retexture.stopwatch import Stopwatch

STRIDE = 0.54
"""Distance between origins, as a share of a patch's sides: the rest is overlap."""
STEADY = 0.3
"""How much the plain deformation counts where a patch overlaps it, against synthesised texture."""
CENTRE = 0.1
"""How much a patch that covers seams must look like what it covers, against its surroundings."""
RING_PX = 4
GAP_ROUNDS = 3
REPORT_EVERY = 64


@dataclass(eq=False)
class Painter:
    """Merges patches into a canvas, one by one."""

    picture: Singles
    """(H, W, 3) the source, as it is compared."""
    usable: Bools | None
    """(H, W) where texture may be taken from; None for everywhere."""
    canvas: Canvas
    shape: PatchShape
    variety: float
    mirrored: bool
    rng: np.random.Generator
    watch: Stopwatch
    kept: tuple[Ints, Ints] | None = None
    """(H, W) of the source and of the result: the number of the curve within two pixels, else -1."""
    origins: list[Origins] = field(default_factory=list)
    labels: int = 0
    candidates: int = 0

    def cover(self, patches: Patches, *, over_seams: bool = False) -> Iterator[int]:
        """Merge `patches`; yield how many are done, after each few."""
        batches, done = iter(patches), 0
        while (batch := self._next(batches)) is not None:
            with self.watch("coordinates"):
                colours = read(self.picture, batch.source)
                usable = self._usable(batch.source, batch.origins.curve)
                variance = (colours**2).mean(axis=(1, 2)) - colours.mean(axis=(1, 2)) ** 2
                variance = variance.sum(axis=1) + 1e-4
            for i in range(len(batch.origins)):
                self._paint(batch, i, colours[i], usable[i], float(variance[i]), over_seams=over_seams)
                done += 1
                if done % REPORT_EVERY == 0:
                    yield done
            self.origins.append(batch.origins)

    def _next(self, batches: Iterator[Batch]) -> Batch | None:
        with self.watch("coordinates"):
            return next(batches, None)

    def _paint(
        self, batch: Batch, i: int, colours: Singles, usable: Bools, variance: float, *, over_seams: bool
    ) -> None:
        self.labels += 1
        window, at = self._window(batch, i)
        if window is None:
            return
        curve = batch.origins.curve[i]
        reach = np.isfinite(at[..., 0]) & self.canvas.may[window]
        if self.kept is not None:
            reach &= _free_for(curve, self.kept[1][window])
        if not reach.any():
            return
        with self.watch("search"):
            grid, start = self._best(batch, i, colours, usable, variance, over_seams=over_seams)
        with self.watch("seams"):
            place = read(grid, np.nan_to_num(at) + start)
            reach &= self._usable(place, curve)
            colour = read(self.picture, place, Kernel.CUBIC)
            self.canvas.merge(window, self.labels, colour, place, reach)

    def _best(
        self, batch: Batch, i: int, colours: Singles, usable: Bools, variance: float, *, over_seams: bool
    ) -> tuple[Singles, Singles]:
        """Return the best candidate: a source grid, and where the target grid's first node lies in it, as (j, k)."""
        shown, weight, needed = self._surroundings(batch, i, over_seams=over_seams)
        uses = read(self.canvas.uses, batch.source[i] / CELL, Kernel.NEAREST)
        off_place = drift(self.shape, float(batch.origins.offset[i]), float(batch.origins.inner[i]))
        found = []
        for sense in (1, -1) if self.mirrored else (1,):
            parts = (colours, uses, (~usable).astype(np.float32))
            turned = [np.ascontiguousarray(part[:, ::sense]) for part in parts]
            pool = Pool(turned[0], turned[1], turned[2], variance)
            cost = costs(pool, shown, weight, needed, self.variety) + off_place
            cost += CHANCE * self.rng.random(cost.shape)
            k, j = divmod(int(np.argmin(cost)), cost.shape[1])
            found.append((cost[k, j], sense, j, k))
            self.candidates += cost.size
        _, sense, j, k = min(found)
        return np.ascontiguousarray(batch.source[i][:, ::sense]), np.array([j, k], np.float32)

    def _usable(self, positions: Singles, curve: Ints) -> Bools:
        """Return where texture for patches of a `curve` may be taken at `positions` (..., 2)."""
        usable = within(positions, self.picture.shape[:2], self.usable)
        if self.kept is not None:
            limit = np.array(self.kept[0].shape[::-1]) - 1
            x, y = np.moveaxis(np.clip(np.rint(positions), 0, limit).astype(int), -1, 0)
            usable &= _free_for(np.reshape(curve, (-1, *[1] * (x.ndim - 1))), self.kept[0][y, x])
        return usable

    def _window(self, batch: Batch, i: int) -> tuple[tuple[slice, slice] | None, Singles]:
        """Return the part of the picture that a patch's window covers, and where its pixels lie in the grid."""
        height, width = self.canvas.label.shape
        x, y = batch.corners[i]
        left, top, right, bottom = batch.boxes[i]
        x0, y0, x1, y1 = max(x + left, 0), max(y + top, 0), min(x + right, width), min(y + bottom, height)
        if x1 - x0 < 2 or y1 - y0 < 2:
            return None, batch.at[i]
        return (slice(y0, y1), slice(x0, x1)), batch.at[i, y0 - y : y1 - y, x0 - x : x1 - x]

    def _surroundings(self, batch: Batch, i: int, *, over_seams: bool) -> tuple[Singles, Singles, Singles]:
        """Return for the target grid (K, J): colours shown, how much each counts, and where the patch may be used."""
        grid, canvas = batch.target[i], self.canvas
        shown = read(canvas.colour, grid)
        inside = within(grid, canvas.label.shape, None)
        x, y = np.moveaxis(np.clip(np.rint(grid), 0, np.array(canvas.label.shape[::-1]) - 1).astype(int), -1, 0)
        weight = np.where(canvas.label[y, x] > 0, 1, STEADY) * (inside & ~canvas.bare[y, x])
        if over_seams:
            weight[RING_PX:-RING_PX, RING_PX:-RING_PX] *= CENTRE
        needed = inside & canvas.may[y, x]
        return shown, weight.astype(np.float32), needed.astype(np.float32)


def _free_for(curve: Ints, kept: Ints) -> Bools:
    """Return where no other curve than `curve` runs within two pixels."""
    return np.asarray((kept < 0) | (kept == curve))


def lattice(shape: PatchShape, shift: float = 0.0, *, stride: float | None = None) -> Lattice:
    """Return where patches of a shape are grown."""
    stride = stride or STRIDE
    return Lattice(stride * (2 * shape.spine + 1), stride * (2 * shape.rib + 1), shift)


def synthesised(painter: Painter, way: Correspondence, fields: Fields, first: Patches, *, refine: float) -> Job[None]:
    """Cover the canvas with the patches `first`, then lay the share `refine` as many again over the worst seams."""
    shape, canvas = painter.shape, painter.canvas
    whole = (1 + refine) * len(first) + 1
    wanted = canvas.bare.copy()
    yield Progress(0, "choosing patches")
    for done in painter.cover(first):
        yield Progress(done / whole, "choosing patches")
    for _ in range(GAP_ROUNDS):
        gaps = way.origins(gap_places(canvas.bare, int(lattice(shape).across)))
        for _ in painter.cover(Patches(gaps, shape, fields, way)):
            yield Progress(len(first) / whole, "closing gaps")
    yield Progress(len(first) / whole, "mending seams")
    with painter.watch("coordinates"):
        again = ordered_origins(way, wanted, lattice(shape, 0.5))
        worst = _worst(again, canvas.right + canvas.below, shape, refine)
    for done in painter.cover(Patches(worst, shape, fields, way), over_seams=True):
        yield Progress(min((len(first) + done) / whole, 1.0), "mending seams")


def _worst(origins: Origins, seams: Singles, shape: PatchShape, share: float) -> Origins:
    """Return the `share` of the origins with the costliest seams around them, in their order."""
    if not len(origins):
        return origins
    side = 2 * shape.rib + 1
    around = cv2.boxFilter(seams, -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    limit = np.array(seams.shape[::-1]) - 1
    x, y = np.clip(np.rint(origins.target).astype(int), 0, limit).T
    cost = around[y, x]
    return origins.taken((cost > 0) & (cost >= np.quantile(cost, 1 - share)))
