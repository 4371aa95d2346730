"""How well a texel that repeats in two directions explains the photo: by this alone, several finds are compared.

What is explained is what is predicted: every second row of texels is compared with the texel that the other rows show,
and every second column with that of the other columns, whichever is predicted worse. A texel that is seen once, or that
repeats in one direction only, fits itself and predicts nothing, however large it is. What the others do not show takes
the colours of what is around it in them, and is predicted badly: of three columns or less not much is believed.

The prediction is compared with what is left of the texel if only one of its directions may change its colours: stripes,
of which one even colour is a special case. The light is fitted to that anew, under the same smoothness (NRT eq. 6).
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
import scipy

from core.arrays import Floats, Ints
from core.linalg.factor import Factor
from core.overlay.registration.cloth import Fit, FittedCloth, estimate_from, measure
from core.overlay.registration.normal_equations import USUAL
from core.overlay.registration.region import LEAST_NOISE, SeenCells, look_at
from core.overlay.registration.registration import LEAST_SHADING, ClothState, huber
from core.overlay.texel import Texel

CLEAR, CREDIBLE = 0.5, 0.05
"""Share of the error that is predicted away from which a find is not to be doubted, and from which it is one at all."""
LEAST_WOVEN = 0.25
"""Share of a texel's variance along warp and weft from which it may be a plaid's with folds in it: large prints have
less than 0.2, plaids 0.3 to 0.99. Plain motifs lie between: which of both explains more tells them."""
PARTS = 3
"""Parts of a texel's side in which it is looked at whether they are seen again."""
ROUNDS = 3
"""Times that the light over stripes is fitted: the problem is linear but for Huber's weights."""


@dataclass(frozen=True)
class Evidence:
    """What speaks for a fit."""

    explained: float
    """Log-likelihood ratio of the photo under the texel and under stripes, in nats, if every pixel spoke for itself."""
    share: float
    """Share of the squared error over stripes that the texel takes away: 1 is all of it."""

    @property
    def is_related(self) -> bool:
        """Whether more is predicted than by colours that have nothing to do with those seen, but are as various.

        Their difference has twice the variance: they would take away -1.
        """
        return self.share > -1

    @property
    def is_credible(self) -> bool:
        """Whether the pattern repeats at all."""
        return self.share > CREDIBLE

    @property
    def is_clear(self) -> bool:
        """Whether no doubt is left that this is how it repeats."""
        return self.share > CLEAR


def weigh(cloth: FittedCloth, found: Fit) -> Evidence:
    """Return what speaks for a fit on its cells; what is seen only once explains itself and says nothing."""
    stripes = found.texel.striped()
    striped = tuple(relight(cloth, piece, stripes) for piece in found.pieces)
    sums, seen = look_at(cloth.registration, striped).sums(stripes), look_at(cloth.registration, found.pieces)
    before, count = sums[:, 0], sums[:, 1]
    with ThreadPoolExecutor(2) as workers:
        ways = list(workers.map(lambda axis: along(cloth, found, seen, axis, before, count), (0, 1)))
    return Evidence(min(way.explained for way in ways), min(way.share for way in ways))


def choose_weave(
    cloth: FittedCloth, start: Fit, register: Callable[[FittedCloth, Fit], Fit]
) -> tuple[FittedCloth, Fit, Evidence]:
    """Return a fit registered with any texel or, where that leaves doubts, with a plaid's, if it is better.

    Of few texels of a plaid, folds that lie alike are else taken for a part of the pattern.
    """
    first = _, found, weight = register_as(cloth, start, register)
    if weight.is_clear or not may_be_plaid(cloth, found.texel):
        return first
    woven = replace(cloth, is_woven=True)
    second = register_as(woven, measure(woven, woven.as_woven(start.texel), start.pieces), register)
    return max(first, second, key=lambda end: end[2].explained)


def register_as(
    cloth: FittedCloth, start: Fit, register: Callable[[FittedCloth, Fit], Fit]
) -> tuple[FittedCloth, Fit, Evidence]:
    """Return a cloth, a fit registered as that, and what speaks for it."""
    found = register(cloth, start)
    return cloth, found, weigh(cloth, found)


def may_be_plaid(cloth: FittedCloth, texel: Texel) -> bool:
    """Return whether enough of a texel changes along warp and weft alone."""
    woven, whole = (one.pixels.var(axis=(0, 1)).sum() for one in (texel.woven(cloth.basis), texel))
    return bool(woven > LEAST_WOVEN * whole)


def along(cloth: FittedCloth, found: Fit, seen: SeenCells, axis: int, before: Floats, count: Floats) -> Evidence:
    """Return what speaks for a fit along an axis, where stripes leave an error `before` (K,) in `count` (K,) pixels.

    `seen` is what its pieces show.
    """
    seen_again, after = count_repeated(piece_parts(found), axis), foretold(cloth, seen, axis)
    # Cells wholly outside the region have no pixels.
    noise = LEAST_NOISE * np.maximum(count, 1)
    ratios = np.log((before + noise) / (after + noise))
    share = 1 - float(after.sum()) / max(float(before.sum()), 1e-9)
    return Evidence(seen_again * 0.5 * float(count @ ratios), seen_again * share)


def foretold(cloth: FittedCloth, seen: SeenCells, axis: int) -> Floats:
    """Return the squared error (K,) in each of the cells, each texel shown as those of other parity along `axis`.

    It is summed over channels.
    """
    odd = np.floor(seen.at[..., axis]) % 2 == 1
    # The texel that even ones are compared with is that of the odd ones.
    even, other = (seen.show(estimate_from(cloth, seen, seen.weight * (odd == rest))) for rest in (True, False))
    missing = np.where(odd[..., None], other, even) - seen.photo
    return np.asarray((np.einsum("kpc,kpc->kp", missing, missing) * seen.weight).sum(1), np.float64)


def piece_parts(found: Fit) -> Ints:
    """Return the parts of texels (n, 3) that are covered: column and row, `PARTS` to a texel, and number of piece."""
    return np.concatenate(
        [
            np.pad(
                np.unique(np.floor(PARTS * piece.uv[:-1, :-1][piece.cells]).astype(np.int64), axis=0),
                ((0, 0), (0, 1)),
                constant_values=number,
            )
            for number, piece in enumerate(found.pieces)
        ]
    )


def count_repeated(parts: Ints, axis: int) -> float:
    """Return the share of the parts of texels (n, 3) that are seen elsewhere in the same row of texels along `axis`.

    A border repeats along one axis only.
    """
    place = parts.copy()
    place[:, axis] %= PARTS
    _, times = np.unique(place, axis=0, return_counts=True)
    return float(times[times > 1].sum()) / max(len(parts), 1)


def relight(cloth: FittedCloth, piece: ClothState, texel: Texel) -> ClothState:
    """Return a piece, its geometry as it is, with the light that suits a texel best (NRT eq. 6, its terms in rho)."""
    mesh, used = cloth.mesh, cloth.mesh.nodes_of(piece.cells).ravel()
    number = np.cumsum(used) - 1
    corners = number[mesh.corners[piece.cells]]
    photo, weight = (plane[piece.cells] for plane in cloth.registration.by_cells())
    colours = texel.singles(mesh.weights @ piece.uv.reshape(-1, 2)[mesh.corners[piece.cells]])
    squares, products = (np.einsum("kpc,kpc->kp", colours, other) for other in (colours, photo))
    shares = (mesh.weights[:, :, None] * mesh.weights[:, None]).reshape(-1, 16)
    bending = mesh.bending(used.reshape(mesh.nodes))[:, used]
    rows, columns = np.repeat(corners, 4, axis=1).ravel(), np.tile(corners, 4).ravel()
    rho = piece.rho.ravel()[used]
    for _ in range(ROUNDS):
        light = (rho[corners] @ mesh.weights.T).astype(np.float32)
        residual = np.sqrt(((light[..., None] * colours - photo) ** 2).mean(-1))
        robust = weight * huber(residual, weight)
        blocks = (robust * squares) @ shares
        data = scipy.sparse.csr_array((blocks.ravel(), (rows, columns)), shape=(len(rho), len(rho)))
        pull = np.bincount(corners.ravel(), ((robust * products) @ mesh.weights).ravel(), len(rho))
        stiffness = USUAL.shading * float(np.median(data.diagonal())) + 1e-9
        system = data + stiffness * (bending.T @ bending + 1e-6 * scipy.sparse.eye_array(len(rho)))
        rho = np.maximum(np.asarray(Factor(system).solve(pull), np.float64), LEAST_SHADING)
    whole = piece.rho.ravel().copy()
    whole[used] = rho
    return replace(piece, rho=whole.reshape(piece.rho.shape))
