"""The mean texel: one period of the regular texture, estimated from the registered photo.

Sample (i, j) of an h x w texel lies at u = (j + 0.5) / w, v = (i + 0.5) / h; it repeats in both directions.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import cv2
import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Singles, readonly
from core.overlay.filters.bands import PIXELS
from core.overlay.filters.sampling import look_up, remap
from core.overlay.tolerances import TYPICAL

BORDER = 3
OBSERVED, LEAST_OBSERVED = 32, 100_000
"""Pixels for each sample of a texel, and pixels in all, that are enough to estimate it from."""


@dataclass(frozen=True)
class Texel:
    """Colours (h, w, 3), 0 to 1, of one texel."""

    pixels: Floats

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in samples."""
        return self.pixels.shape[0], self.pixels.shape[1]

    @cached_property
    def _padded(self) -> Singles:
        return np.pad(self.pixels, ((BORDER, BORDER), (BORDER, BORDER), (0, 0)), mode="wrap").astype(np.float32)

    @cached_property
    def _planes(self) -> list[Singles]:
        """Colours and derivatives, padded, with a fourth channel: OpenCV looks four up in half the time of three."""
        wide = np.zeros((3, *self._padded.shape[:2], 4), np.float32)
        wide[..., :3] = self._padded, *self._slopes
        return list(wide)

    @cached_property
    def _slopes(self) -> tuple[Singles, Singles]:
        """Derivatives by u and v, central differences, padded."""
        h, w = self.shape
        du, dv = (
            (np.roll(self.pixels, -1, axis) - np.roll(self.pixels, 1, axis)) * (n / 2) for axis, n in ((1, w), (0, h))
        )
        pad = ((BORDER, BORDER), (BORDER, BORDER), (0, 0))
        return np.pad(du, pad, mode="wrap").astype(np.float32), np.pad(dv, pad, mode="wrap").astype(np.float32)

    def places(self, uv: Floats) -> tuple[Singles, Singles]:
        """Return columns and rows in the padded texel of coordinates (..., 2)."""
        h, w = self.shape
        x, y = ((a - np.floor(a)) * n - 0.5 + BORDER for a, n in ((uv[..., 0], w), (uv[..., 1], h)))
        return x.astype(np.float32), y.astype(np.float32)

    def __call__(self, uv: Floats) -> Floats:
        """Return T(uv) (H, W, 3), bilinear, for uv (H, W, 2)."""
        return self.singles(uv).astype(np.float64)

    def singles(self, uv: Floats) -> Singles:
        """Return T(uv) (H, W, 3) in single precision."""
        x, y = self.places(uv)
        return remap(self._padded, x, y)

    def at(self, uv: Floats) -> Floats:
        """Return T(uv) (n, 3) for a list uv (n, 2)."""
        return look_up(self._padded, np.stack(self.places(uv), -1)).astype(np.float64)

    def with_gradient(self, uv: Floats) -> tuple[Floats, Floats, Floats]:
        """Return T, ∂T/∂u and ∂T/∂v (H, W, 3) at uv (H, W, 2)."""
        value, du, dv = (field.astype(np.float64) for field in self.singles_with_gradient(uv))
        return value, du, dv

    def singles_with_gradient(self, uv: Floats) -> tuple[Singles, Singles, Singles]:
        """Return what `with_gradient` does in single precision."""
        x, y = self.places(uv)
        value, du, dv = (remap(field, x, y) for field in (self._padded, *self._slopes))
        return value, du, dv

    def planes(self, uv: Floats, count: int = 1) -> list[Singles]:
        """Return the first `count` of what `with_gradient` does, plane by plane (3, H, W)."""
        x, y = self.places(uv)
        seen = (remap(field, x, y).reshape(-1, 4) for field in self._planes[:count])
        return [np.ascontiguousarray(field.T, np.float32).reshape(4, *x.shape)[:3] for field in seen]

    def blurred(self, sigma_px: float, scale: Floats) -> "Texel":
        """Return the texel under the blur that the photo gets by `sigma_px`; `scale` is pixels a texel (2, 2)."""
        if sigma_px <= 0:
            return self
        key = sigma_px, scale.tobytes()
        if key not in self._soft:
            self._soft[key] = self._blurred(sigma_px, scale)
        return self._soft[key]

    @cached_property
    def _soft(self) -> dict[tuple[float, bytes], "Texel"]:
        """Blurred texels: a fit asks for the same ones in every step of its growth."""
        return {}

    @cached_property
    def palettes(self) -> dict[int, Singles]:
        """The colours (k, 3) that stand for the texel's, by how many at most."""
        return {}

    def _blurred(self, sigma_px: float, scale: Floats) -> "Texel":
        h, w = self.shape
        # Covariance of the blur in texels: S⁻¹ S⁻ᵀ σ², in the frequency domain, where the texel's periods are exact.
        inverse = np.linalg.inv(scale)
        covariance = inverse @ inverse.T * sigma_px**2
        fv, fu = np.fft.fftfreq(h) * h, np.fft.fftfreq(w) * w
        u, v = np.meshgrid(fu, fv)
        power = covariance[0, 0] * u * u + 2 * covariance[0, 1] * u * v + covariance[1, 1] * v * v
        spectrum = np.fft.fft2(self.pixels, axes=(0, 1)) * np.exp(-2 * np.pi**2 * power)[..., None]
        return Texel(np.fft.ifft2(spectrum, axes=(0, 1)).real)

    def striped(self) -> "Texel":
        """Return the texel with those of its harmonics alone that change in one direction: the direction of most power.

        Stripes stay as they are; of any other texel a part goes.
        """
        return self._with_directions([int(self._directions[1].argmax())])

    def woven(self, scale: Floats) -> "Texel":
        """Return the texel with those of its harmonics alone that change along the warp, or along the weft.

        A thread has one colour, and what is seen of a plain weave is the mean of both threads that cross there: so a
        plaid is f(u) + g(v), and stays as it is; of any other texel a part goes. The first direction is that of most
        power, the other one that of most power times the sine of its angle to the first; `scale` is pixels a texel
        (2, 2).
        """
        directions, power, _ = self._directions
        x, y = (directions @ np.linalg.inv(scale)).T
        first = int(power.argmax())
        across = power * np.abs(x * y[first] - y * x[first]) / np.maximum(np.hypot(x, y), 1e-12)
        return self._with_directions([first, int(across.argmax())])

    @cached_property
    def _directions(self) -> tuple[Floats, Floats, Ints]:
        """Directions (k, 2) in which a harmonic changes, their power (k,), and the direction of each harmonic (h, w).

        The mean, which changes in none, has the direction 0 and no power.
        """
        directions, group = harmonics_of(self.shape)
        power = np.bincount(group.ravel(), (np.abs(self._spectrum) ** 2).sum(-1).ravel()).astype(np.float64)
        power[group[0, 0]] = 0
        return directions, power, group

    @cached_property
    def _spectrum(self) -> "np.typing.NDArray[np.complex128]":
        return np.asarray(np.fft.fft2(self.pixels, axes=(0, 1)))

    def _with_directions(self, kept: list[int]) -> "Texel":
        """Return the texel with its mean and the harmonics of some directions, by their numbers."""
        group = self._directions[2]
        spectrum = self._spectrum * np.isin(group, [group[0, 0], *kept])[..., None]
        return Texel(np.fft.ifft2(spectrum, axes=(0, 1)).real)

    def evenness(self, scale: Floats) -> float:
        """Return how much the colours change along the direction of least change over that of most, 0 to 1.

        Stripes have almost none. `scale` is pixels a texel (2, 2).
        """
        h, w = self.shape
        du, dv = (np.roll(self.pixels, -1, axis) - self.pixels for axis in (1, 0))
        g = np.stack([du.ravel() * w, dv.ravel() * h], -1) @ np.linalg.inv(scale)
        low, high = np.linalg.eigvalsh(g.T @ g)
        return float(np.sqrt(max(low, 0.0) / max(high, 1e-12)))

    def tiled(self, rows: int, columns: int) -> Floats:
        """Return the regular texture of that many texels."""
        return np.tile(self.pixels, (rows, columns, 1))


@lru_cache(maxsize=4)
def harmonics_of(shape: tuple[int, int]) -> tuple[Floats, Ints]:
    """Return the directions (k, 2) in which harmonics of a texel of `shape` (h, w) change, and that of each one (h, w).

    A search asks for the same shape again and again. The mean, which changes in none, has the direction 0.
    """
    h, w = shape
    u, v = np.meshgrid(*((np.fft.fftfreq(n) * n).astype(np.int64) for n in (w, h)))
    steps = np.maximum(np.gcd(u, v), 1) * np.where((u < 0) | ((u == 0) & (v < 0)), -1, 1)
    of_each = np.stack([u // steps, v // steps], -1).reshape(-1, 2)
    directions, group = np.unique(of_each, axis=0, return_inverse=True)
    return readonly(directions.astype(np.float64)), readonly(group.reshape(h, w).astype(np.int64))


def estimate_texel(
    photo: Floats | Singles,
    uv: Floats | Singles,
    shading: Floats | Singles,
    weight: Floats | Singles | Bools,
    shape: tuple[int, int],
    *,
    rounds: int = 6,
    is_robust: bool = True,
) -> Texel:
    """Return the mean appearance of a texel of `shape` (h, w) over the registered photo, or an even share of it.

    Minimises Σ w ψ(ρ T(uv) - I) over T. ψ is the square or, if `is_robust`, one by which what is unlike most counts
    less: of small motifs on even ground, where most pixels fit, those too that some texels show and others do not. The
    first round gathers the colours that each sample is seen with; the others gather what is still missing, which takes
    out the blur of sharing a pixel among four samples. `photo` is (H, W, 3), `uv` (H, W, 2), `shading` and `weight`
    (H, W).
    """
    use = np.flatnonzero(draw_sample(weight > 0, max(OBSERVED * shape[0] * shape[1], LEAST_OBSERVED)))
    colours, at = (plane.reshape(-1, plane.shape[-1]).take(use, 0) for plane in (photo, uv))
    light, w = (plane.ravel().take(use).astype(np.float32) for plane in (shading, weight))
    colours = colours.astype(np.float32, copy=False)
    shares = shares_of(*splat(at.astype(np.float64, copy=False), shape), shape).astype(np.float32)
    pixels = np.zeros((shares.shape[1], photo.shape[-1]), np.float32)
    robust = w
    for _ in range(rounds):
        missing = colours - light[:, None] * (shares @ pixels)
        if is_robust and pixels.any():
            error = np.abs(missing) @ np.full(missing.shape[1], 1 / missing.shape[1], np.float32)
            bend = np.float32(2.0 * np.median(error[:: max(1, len(error) // TYPICAL)]) + 1e-3)
            robust = w * np.minimum(1, (bend / np.maximum(error, np.float32(1e-9))) ** 2)
        pixels = pixels + weigh(shares, missing, light, robust, shape).reshape(pixels.shape).astype(np.float32)
    return Texel(np.clip(pixels, 0, None).astype(np.float64).reshape(*shape, -1))


def draw_sample(use: Bools, most: int) -> Bools:
    """Return about `most` of the marked places, drawn evenly."""
    count = int(use.sum())
    return use if count <= most else use & (np.random.default_rng(0).random(use.shape, np.float32) < most / count)


def splat(at: Floats, shape: tuple[int, int]) -> tuple[Ints, Floats]:
    """Return the sample numbers and shares (n, 4) of coordinates (n, 2) in a texel of `shape`."""
    h, w = shape
    index, share = np.empty((len(at), 4), np.int64), np.empty((len(at), 4), at.dtype)
    for start in range(0, len(at), PIXELS):
        some = slice(start, start + PIXELS)
        x, y = at[some, 0] * w - 0.5, at[some, 1] * h - 0.5
        left, top = np.floor(x), np.floor(y)
        fx, fy = x - left, y - top
        columns, rows = (next_to(first.astype(np.int64) % n, n) for first, n in ((left, w), (top, h)))
        for k, (b, a) in enumerate(((0, 0), (0, 1), (1, 0), (1, 1))):
            index[some, k] = rows[b] * w + columns[a]
            share[some, k] = (fx if a else 1 - fx) * (fy if b else 1 - fy)
    return index, share


def next_to(first: Ints, count: int) -> tuple[Ints, Ints]:
    """Return the numbers (n,) of samples, and those of the next ones; the first of `count` comes after the last."""
    return first, np.where(first == count - 1, 0, first + 1)


def shares_of(index: Ints, share: Floats, shape: tuple[int, int]) -> "scipy.sparse.csr_array":
    """Return the matrix (n, h * w) that looks a texel of `shape` (h, w) up, from what `splat` returns."""
    ends = np.arange(0, index.size + 1, 4)
    return scipy.sparse.csr_array((share.ravel(), index.ravel(), ends), shape=(len(index), shape[0] * shape[1]))


def gather(
    index: Ints, share: Floats, colours: Floats, light: Floats, weight: Floats, shape: tuple[int, int]
) -> Floats:
    """Return the weighted mean colours (h, w, C); samples that nothing reached take their neighbours'."""
    return weigh(shares_of(index, share, shape), colours, light, weight, shape)


def weigh(
    shares: "scipy.sparse.csr_array",
    colours: Floats | Singles,
    light: Floats | Singles,
    weight: Floats | Singles,
    shape: tuple[int, int],
) -> Floats:
    """Return what `gather` does for shares (n, h * w) of the samples."""
    share = weight * light
    seen = np.empty((len(colours), colours.shape[1] + 1), colours.dtype)
    np.multiply(colours, share[:, None], out=seen[:, :-1])
    np.multiply(light, share, out=seen[:, -1])
    sums = np.asarray(shares.T @ seen, np.float64)
    return fill(sums[:, :-1].reshape(*shape, -1), sums[:, -1].reshape(shape))


def fill(sums: Floats, mass: Floats) -> Floats:
    """Return sums over mass; where mass is small, a blurred ratio of both is mixed in."""
    little = 0.02 * max(float(np.median(mass)), float(mass.mean()) * 0.1, 1e-12)
    wide, base = (np.pad(a, [(8, 8), (8, 8)] + [(0, 0)] * (a.ndim - 2), mode="wrap") for a in (sums, mass))
    soft = [cv2.GaussianBlur(a, (0, 0), 2.0)[8:-8, 8:-8] for a in (wide, base)]
    near = soft[0] / np.maximum(soft[1], 1e-12)[..., None]
    return np.asarray((sums + little * near) / (mass + little)[..., None], np.float64)
