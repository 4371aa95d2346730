"""Small pictures with a texture that knows its curve, for the tests of retexturing."""

import numpy as np

from core.arrays import Bytes, Points
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.curves.fitting import fit

WIDTH, HEIGHT, PERIOD, MIDDLE = 220, 200, 8, 100


def straight(y: float = MIDDLE, *, left: float = 0.0, right: float = WIDTH - 1.0) -> Curve:
    return Curve(np.column_stack([np.linspace(left, right, 7), np.full(7, y)]))


def arched(height: float = 90.0, y: float = 145.0) -> Curve:
    x = np.linspace(0, WIDTH - 1, 300)
    return fit(np.column_stack([x, y - height * (1 - np.cos(2 * np.pi * x / (WIDTH - 1))) / 2]), tolerance=0.2)


def data_of(curves: list[FeatureCurve]) -> dict[str, object]:
    """Return what a file of curves holds, all of which have a target."""
    pairs = [(curve.source, curve.target) for curve in curves if curve.target is not None]
    return {"curves": [{"source": a.points.tolist(), "target": b.points.tolist()} for a, b in pairs]}


def bent() -> list[FeatureCurve]:
    return [FeatureCurve(straight(), arched())]


def stripes(*, seed: int = 0) -> Bytes:
    """Blue above the middle row, red below it, with upright stripes of `PERIOD` px and some grain."""
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    light = 150 + 60 * np.sin(2 * np.pi * x / PERIOD) + np.random.default_rng(seed).normal(0, 6, x.shape)
    above = (y < MIDDLE)[..., None]
    colours = np.where(above, [0.3, 0.5, 1.0], [1.0, 0.4, 0.3]) * light[..., None]
    return np.clip(np.rint(colours), 0, 255).astype(np.uint8)


def strip(picture: Bytes, curve: Curve, offset: float) -> Points:
    """Return the brightness every half pixel of arc length, at `offset` px from `curve`, straightened."""
    length = np.arange(30, curve.length - 30, 0.5)
    t = curve.parameter_at(length)
    x, y = np.rint(curve.at(t) + offset * curve.normal(t)).astype(int).T
    return np.asarray(picture[y, x].sum(axis=1), np.float64)


def period(line: Points) -> float:
    """Return the strongest period of a line sampled every half pixel, px."""
    power = np.abs(np.fft.rfft((line - line.mean()) * np.hanning(len(line)), 8 * len(line))) ** 2
    low = 8 * len(line) // 60
    return float(8 * len(line) / (low + power[low:].argmax()) / 2)
