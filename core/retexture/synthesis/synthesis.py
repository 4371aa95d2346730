"""Synthesis: grow patches in order, choose a candidate for each and merge it (DPD sec. 3.4)."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.progress import Job, Progress
from core.retexture.origins import Origins
from core.retexture.sampling import Kernel, read
from core.retexture.synthesis.candidate_choice import CHANCE, Pool, costs
from core.retexture.synthesis.candidate_pool import Bounds, Candidates, Round, prefetch_candidates
from core.retexture.synthesis.graph_cut import BARE, GrownPicture
from core.retexture.synthesis.patches import Patches, PatchShape, grid_places
from core.retexture.synthesis.placement import PatchGrid, gap_places, order_origins
from core.retexture.synthesis.scene import RetextureScene
from core.stopwatch import Stopwatch

ALONG, ACROSS = 0.62, 0.54
"""Distances between origins, as shares of a patch's sides: the rest is overlap."""
CENTRE = 0.1
"""How much a patch that covers seams must look like what it covers, against its surroundings."""
RING_PX = 4
GAP_ROUNDS = 3


@dataclass(eq=False)
class Painter:
    """Merges patches into a canvas, those at once that do not touch."""

    picture: Singles
    """(H, W, 3) the source, as it is compared."""
    bounds: Bounds
    canvas: GrownPicture
    shape: PatchShape
    variety: float
    mirrored: bool
    chance: Random
    watch: Stopwatch
    origins: list[Origins] = field(default_factory=list)
    labels: int = 0
    candidates: int = 0

    def cover(self, stocks: Iterator[Candidates], *, over_seams: bool = False) -> Iterator[int]:
        """Merge the patches in `stocks`; yield how many are done, after each few."""
        done = 0
        while (stock := self._next(stocks)) is not None:
            for some in stock.rounds:
                self._lay(stock, some, over_seams=over_seams)
                done += some.patches.stop - some.patches.start
                yield done
            self.origins.append(stock.batch.origins)
            self.labels += len(stock.batch.origins)

    def _next(self, stocks: Iterator[Candidates]) -> Candidates | None:
        with self.watch.measure("coordinates"):
            return next(stocks, None)

    def _lay(self, stock: Candidates, some: Round, *, over_seams: bool) -> None:
        """Choose candidates for the patches of a round and merge them."""
        with self.watch.measure("search"):
            off, turned = self._best(stock, some, over_seams=over_seams)
        with self.watch.measure("seams"):
            patch = stock.batch.covered.patch[some.pixels]
            number = patch - some.patches.start
            # Where the patch reaches the region's edge it shows its corresponding place, whichever was chosen.
            at = stock.middle[some.pixels] + stock.held[some.pixels] * off.take(number, axis=0)
            last = np.array(stock.hidden.shape[:0:-1]) - 1
            if turned.any():
                at[:, 0] = np.where(turned.take(number), last[0] - at[:, 0], at[:, 0])
            place = grid_places(stock.batch, patch, at)
            usable = self.bounds.usable_at(place, stock.batch.origins.curve.take(patch))
            usable &= ~stock.hidden[patch, *np.rint(at).astype(np.int64).clip(0, last).T[::-1]]
            colour = read(self.picture, place, Kernel.CUBIC)
            self.canvas.merge(some.cover, self.labels + 1 + patch, colour, place, usable)

    def _best(self, stock: Candidates, some: Round, *, over_seams: bool) -> tuple[Singles, Bools]:
        """Return how far the best candidates lie from the central ones, as (j, k) (k, 2).

        And whether the source grids are turned end to end along the curve for them (k,).
        """
        these = some.patches
        shown, weight = self._surroundings(stock, these, over_seams=over_seams)
        uses = read(self.canvas.uses, stock.cells[these], Kernel.NEAREST)
        parts = stock.colours[these], uses, stock.unusable[these]
        variance = stock.variance[these]
        found = []
        for sense in (1, -1) if self.mirrored else (1,):
            colours, used, unusable = (np.ascontiguousarray(part[:, :, ::sense]) for part in parts)
            pool = Pool(colours, used, unusable, variance)
            cost = costs(pool, shown, weight, stock.needed[these], self.variety) + stock.drift[these]
            cost += _noise(self.chance, cost.shape)
            self.candidates += cost.size
            found.append(cost.reshape(len(cost), -1))
        best = np.argmin(np.concatenate(found, axis=1), axis=1)
        turned, best = best >= found[0].shape[1], best % found[0].shape[1]
        k, j = np.divmod(best, stock.drift.shape[2])
        off = np.stack([j - self.shape.search_along, k - self.shape.search_across], axis=-1)
        return off.astype(np.float32), turned

    def _surroundings(self, stock: Candidates, these: slice, *, over_seams: bool) -> tuple[Singles, Singles]:
        """Return for target grids (k, K, J): colours shown, and how much each counts."""
        target = stock.batch.target[these]
        shown, weight = read(self.canvas.colour, target), self.canvas.weigh_at(target)
        if over_seams:
            weight[:, RING_PX:-RING_PX, RING_PX:-RING_PX] *= np.float32(CENTRE)
        return shown, weight


def _noise(chance: Random, shape: tuple[int, ...]) -> Floats:
    """Return noise from 0 to `CHANCE`, to the 16 bits that are enough to decide between equals."""
    drawn = np.frombuffer(chance.randbytes(2 * math.prod(shape)), "<u2")
    return CHANCE / 2**16 * drawn.reshape(shape)


def lattice(shape: PatchShape, shift: float = 0.0, *, stride: float | None = None) -> PatchGrid:
    """Return where patches of a shape are grown."""
    along, across = (stride, stride) if stride else (ALONG, ACROSS)
    return PatchGrid(along * (2 * shape.spine + 1), across * (2 * shape.rib + 1), shift)


def synthesise(
    painter: Painter, scene: RetextureScene, first: Iterator[Candidates], count: int, *, refine: float
) -> Job[None]:
    """Cover the canvas with the patches `first`, `count` of them, then lay the share `refine` over the worst seams."""
    shape, canvas = painter.shape, painter.canvas
    whole = (1 + refine) * count + 1

    def stocks(origins: Origins) -> Iterator[Candidates]:
        return prefetch_candidates(Patches(origins, shape, scene.fields, scene.way), painter.picture, painter.bounds)

    yield Progress(0, "choosing patches")
    for done in painter.cover(first):
        yield Progress(done / whole, "choosing patches")
    for _ in range(GAP_ROUNDS):
        gaps = scene.way.origins(gap_places(canvas.state == BARE, int(lattice(shape).across)))
        gaps = gaps.taken(np.argsort(gaps.scale, kind="stable"))
        for _ in painter.cover(stocks(gaps)):
            yield Progress(count / whole, "choosing patches")
    yield Progress(count / whole, "mending seams")
    with painter.watch.measure("coordinates"):
        again = order_origins(scene.way, scene.area.must, lattice(shape, 0.5))
        worst = stocks(_worst(again, canvas.seams, shape, refine))
    for done in painter.cover(worst, over_seams=True):
        yield Progress(min((count + done) / whole, 1.0), "mending seams")


def _worst(origins: Origins, seams: Singles, shape: PatchShape, share: float) -> Origins:
    """Return the `share` of the origins with the costliest `seams` (2, H, W) around them, in their order."""
    if not len(origins):
        return origins
    side = 2 * shape.rib + 1
    total = seams[0] + seams[1]
    around = cv2.boxFilter(total, -1, (side, side), dst=total, borderType=cv2.BORDER_CONSTANT)
    limit = np.array(around.shape[::-1]) - 1
    x, y = np.clip(np.rint(origins.target).astype(int), 0, limit).T
    cost = around[y, x]
    least = np.sort(cost)[int((1 - share) * (len(cost) - 1))]
    return origins.taken((cost > 0) & (cost >= least))
