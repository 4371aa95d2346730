"""Joint registration of geometry and shading (NRT sec. 3.2).

Unknown at each node of the mesh: the place m = S uv of the cloth, in pixels of the undeformed texture, and the shading
ρ. With T the regular texture, the residual of a pixel in one channel and its derivatives (NRT eqs. 2 and 9) are

    r = ρ T(uv) - I,    ∂r/∂m = ρ ∇T(uv) S⁻¹,    ∂r/∂ρ = T(uv).

S⁻¹ is the same everywhere, so that it is applied to sums over pixels.

Minimised is Σ ψ(r) + λ² (|L m|² + λp² |L ρ|²) with Huber's ψ and L the second differences of the mesh, by Gauss-Newton
with reweighting (`normal_equations`).
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.mesh import Box, ClothMesh, areas, around, nodes_in
from core.overlay.registration.normal_equations import SYMMETRIC, USUAL, Smoothness, System
from core.overlay.texel import Texel
from core.tracing import span

LEAST_SHADING = 0.02
BAND = 32_768
"""Pixels that are looked at together: what is known of them stays in the processor's cache."""


@dataclass(frozen=True)
class ClothState:
    """Values at the nodes of a mesh, θ of NRT eq. 3, and the cells in which they count."""

    uv: Floats
    """(R, C, 2), texels."""
    rho: Floats
    """(R, C), shading."""
    cells: Bools
    """(rows, columns)."""

    @property
    def values(self) -> Floats:
        """Coordinates and shading together, (R, C, 3)."""
        return np.concatenate([self.uv, self.rho[..., None]], -1)

    def part(self, box: Box) -> "ClothState":
        """Return the state of the cells in a box."""
        nodes = nodes_in(box)
        return ClothState(self.uv[nodes], self.rho[nodes], self.cells[box])

    def with_part(self, box: Box, part: "ClothState") -> "ClothState":
        """Return the state with the values at the nodes of a box taken from a part."""
        uv, rho, nodes = self.uv.copy(), self.rho.copy(), nodes_in(box)
        uv[nodes], rho[nodes] = part.uv, part.rho
        return replace(self, uv=uv, rho=rho)


class Registration:
    """Registers the regular texture with a photo over the cells in use.

    Parameters
    ----------
    mesh
        The mesh over the photo.
    photo
        (H, W, 3), 0 to 1.
    weight
        (H, W), 0 where a pixel says nothing: outside the region, transparent.
    scale
        S (2, 2), pixels of the undeformed texture from texels.
    smoothness
        Weights of the second differences.
    """

    def __init__(
        self, mesh: ClothMesh, photo: Floats, weight: Floats, scale: Floats, smoothness: Smoothness = USUAL
    ) -> None:
        self.mesh, self.photo, self.scale, self.smoothness = mesh, photo, scale, smoothness
        self._weight = mesh.in_cells(weight[..., None].astype(np.float32))[..., 0]
        self._blurred: dict[float, Singles] = {}
        self._room: dict[str, Singles] = {}
        self._system: tuple[Bools, Bools, System] | None = None

    def run(
        self,
        state: ClothState,
        texel: Texel,
        *,
        rounds: int,
        blur_px: float = 0.0,
        free: Bools | None = None,
        firm: float = 1.0,
    ) -> ClothState:
        """Return the state after up to `rounds` Gauss-Newton steps on pictures blurred by `blur_px`  [NRT eqs. 6, 7].

        Only the nodes `free` (R, C) move, all if it is not given. It is `firm` times as smooth as usual.
        """
        box = around(state.cells)
        near, part, nodes = self._cropped(box), state.part(box), nodes_in(box)
        texel = texel.blurred(blur_px, self.scale)
        photo = planes_of(self._photo(blur_px)[box][part.cells])
        system = self._system_of(near.mesh, part.cells, np.ones(near.mesh.nodes, bool) if free is None else free[nodes])
        turn = float(np.sign(np.median(near.mesh.areas(part.uv, part.cells))))
        smoothness = self.smoothness.times(firm)
        for _ in range(rounds):
            with span("registration step", unknowns=3 * system.count):
                part, moved = near._step(system, part, texel, photo, smoothness, turn)
            if moved < 0.02:
                break
        return state.with_part(box, part)

    def _cropped(self, box: Box) -> "Registration":
        """Return the registration of the cells in a box, without the photo."""
        other = copy(self)
        other._weight = self._weight[box]
        other.mesh = self.mesh.part(box)
        return other

    def weighted(self, weight: Floats) -> "Registration":
        """Return the registration with another weight (H, W)."""
        other = copy(self)
        other._weight, other._system = self.mesh.in_cells(weight[..., None].astype(np.float32))[..., 0], None
        return other

    def by_cells(self) -> tuple[Singles, Singles]:
        """Return the photo (rows, columns, cell², 3) and the weight (rows, columns, cell²) by cells."""
        return self._photo(0.0), self._weight

    def _photo(self, blur_px: float) -> Singles:
        """Return the photo blurred, by cells (rows, columns, cell², 3)."""
        if blur_px not in self._blurred:
            image = self.photo.astype(np.float32)
            image = np.asarray(cv2.GaussianBlur(image, (0, 0), blur_px), np.float32) if blur_px > 0 else image
            self._blurred[blur_px] = self.mesh.in_cells(image)
        return self._blurred[blur_px]

    def _system_of(self, mesh: ClothMesh, cells: Bools, free: Bools) -> System:
        known = self._system
        if known is None or not (np.array_equal(known[0], cells) and np.array_equal(known[1], free)):
            known = self._system = (cells, free, System(mesh, cells, free))
        return known[2]

    def _step(
        self, system: System, state: ClothState, texel: Texel, photo: Singles, smoothness: Smoothness, turn: float
    ) -> tuple[ClothState, float]:
        """Return the state after one Gauss-Newton step and how far it went, pixels; areas have the sign `turn`."""
        residual, slopes, rho = self.linearised(state, texel, photo)
        weight = self._weight[state.cells]
        squares = np.einsum("ckp,ckp->kp", residual, residual)
        weight = weight * huber(np.sqrt(squares / np.float32(len(residual))), weight)
        moments = self._kept("moments", (len(SYMMETRIC), *weight.shape))
        gradient = self._kept("gradient", (len(slopes), *weight.shape))

        def gather(band: slice) -> None:
            # ∂r/∂uv is ρ ∇T.
            light = [rho[band], rho[band], np.ones_like(rho[band])]
            for out, (i, j) in zip(moments, SYMMETRIC, strict=True):
                np.einsum("ckp,ckp->kp", slopes[i][:, band], slopes[j][:, band], out=out[band])
                out[band] *= weight[band] * light[i] * light[j]
            for out, slope, factor in zip(gradient, slopes, light, strict=True):
                np.einsum("ckp,ckp->kp", residual[:, band], slope[:, band], out=out[band])
                out[band] *= weight[band] * factor

        in_bands(weight.shape, gather)
        m = state.uv.reshape(-1, 2)[system.around] @ self.scale.T
        theta = np.concatenate([m.T, state.rho.ravel()[None, system.around]])
        return self._moved(system, state, system.solve(moments, gradient, theta, smoothness, self._by_uv), turn)

    @property
    def _by_uv(self) -> Floats:
        """∂(uv, ρ)/∂(m, ρ) (3, 3)."""
        change = np.eye(3)
        change[:2, :2] = np.linalg.inv(self.scale)
        return change

    def _kept(self, name: str, shape: tuple[int, ...]) -> Singles:
        """Return an array of that shape in the memory that a step before has used, without values."""
        size = int(np.prod(shape))
        if name not in self._room or self._room[name].size < size:
            self._room[name] = np.empty(size, np.float32)
        return self._room[name][:size].reshape(shape)

    def linearised(
        self, state: ClothState, texel: Texel, photo: Singles
    ) -> tuple[Singles, tuple[Singles, Singles, Singles], Singles]:
        """Return the residuals (3, K, cell²) of NRT eq. 2 in K cells, and of what their slopes are made (NRT eq. 9).

        That is ∇T by u and v, and T, (3, K, cell²) each, and ρ (K, cell²). They hold until the next step.
        """
        corners, weights = self.mesh.corners[state.cells], self.mesh.weights.T
        nodes = np.ascontiguousarray(state.values.reshape(-1, 3).T)
        residual, by_u, by_v, by_rho = (self._kept(name, photo.shape) for name in ("r", "u", "v", "T"))
        rho = self._kept("rho", photo.shape[1:])

        def look_up(band: slice) -> None:
            # What goes through the texture is fine enough in single precision; coordinates are not.
            at = nodes[:, corners[band]] @ weights
            rho[band] = at[2]
            by_rho[:, band], by_u[:, band], by_v[:, band] = texel.planes(np.moveaxis(at[:2], 0, -1), 3)
            np.multiply(rho[band], by_rho[:, band], out=residual[:, band])
            residual[:, band] -= photo[:, band]

        in_bands(rho.shape, look_up)
        return residual, (by_u, by_v, by_rho), rho

    def _moved(self, system: System, state: ClothState, step: Floats, turn: float) -> tuple[ClothState, float]:
        """Return the state moved by as much of the step as folds no triangle, and the 95th percentile of the move."""
        length = float(np.percentile(np.abs(step[:2]), 95))
        # Far from the answer a step may point anywhere: none goes further than a few pixels.
        limit = min(1.0, 3.0 / max(float(np.abs(step[:2]).max()), 1e-9)) if length > 1.5 else 1.0
        uv = state.uv.reshape(-1, 2).copy()
        uv[system.nodes] += (step[:2] * limit).T @ np.linalg.inv(self.scale).T
        rho = state.rho.ravel().copy()
        rho[system.nodes] = np.maximum(rho[system.nodes] + step[2], LEAST_SHADING)
        uv = unfold(self.mesh, state, uv.reshape(state.uv.shape), turn)
        return replace(state, uv=uv, rho=rho.reshape(state.rho.shape)), length


def in_bands(shape: tuple[int, ...], work: Callable[[slice], None]) -> None:
    """Do the work on bands of the K cells (K, cell², ...), two at a time where there are many."""
    step = max(1, BAND // shape[1])
    bands = [slice(k, min(k + step, shape[0])) for k in range(0, shape[0], step)]
    if len(bands) < 4:
        for band in bands:
            work(band)
        return
    with ThreadPoolExecutor(2) as workers:
        list(workers.map(work, bands))


def unfold(mesh: ClothMesh, before: ClothState, uv: Floats, turn: float) -> Floats:
    """Return the new coordinates, taken back where an area would not have the sign `turn` any more."""
    corners = mesh.corners[before.cells]
    for attempt in range(8):
        first, second = turn * areas(uv, corners).T
        wrong = np.minimum(first, second) <= 0
        if not wrong.any():
            break
        folded = np.zeros(mesh.cells, bool)
        folded[before.cells] = wrong
        kernel = np.ones((3 + 2 * attempt, 3 + 2 * attempt), np.uint8)
        back = cv2.dilate(mesh.nodes_of(folded).astype(np.uint8), kernel) > 0
        uv = np.where(back[..., None], before.uv if attempt > 4 else (uv + before.uv) / 2, uv)
    return uv


def planes_of(pixels: Singles) -> Singles:
    """Return pixels (K, n, 3) channel by channel (3, K, n)."""
    return np.ascontiguousarray(pixels.reshape(-1, 3).T).reshape(3, *pixels.shape[:2])


def huber(size: Singles, weight: Singles) -> Singles:
    """Return Huber's weights (ψ of NRT eq. 7) for residuals of that size; the bend is at 1.345 robust deviations.

    Those of `weight` 0 do not tell what is usual.
    """
    told = size[weight > 0]
    spread = 1.4826 * float(np.median(told)) if len(told) else 1.0
    bend = 1.345 * max(spread, 0.01)
    return np.asarray(np.minimum(1, np.float32(bend) / np.maximum(size, np.float32(1e-9))), np.float32)
