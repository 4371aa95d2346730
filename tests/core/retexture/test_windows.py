"""A large picture is worked on in windows and bands: the pixels are those of the whole."""

import numpy as np
import pytest

from app.bench.retexture import arch, fur
from core.arrays import Pixels
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.progress import run
from core.retexture import job, region, result
from core.retexture.job import retexture
from core.retexture.sampling import Kernel, read
from core.retexture.windows import mirrored_span, place_in, window_around

SIZE = 420, 300


def third() -> FeatureCurve:
    """Return a curve that is a third as long as the picture is wide and becomes an arch."""
    curve = arch(SIZE[0] // 3, SIZE[1], 0.15)
    assert curve.target is not None
    source, target = (Curve(side.points + [SIZE[0] // 3, 0]) for side in (curve.source, curve.target))
    return FeatureCurve(source, target)


def retextured(pixels: Pixels) -> tuple[Pixels, Pixels]:
    found = run(retexture(pixels, [third()], previews=False))
    assert found.patches
    return found.place, found.apply(pixels)


@pytest.mark.parametrize("alpha", [False, True])
def test_windows_and_bands_change_no_pixel(monkeypatch: pytest.MonkeyPatch, *, alpha: bool) -> None:
    pixels = fur(*SIZE)
    if alpha:
        pixels = np.dstack([pixels, np.random.default_rng(1).integers(0, 256, pixels.shape[:2], np.uint8)])
    place, shown = retextured(pixels)
    monkeypatch.setattr(region, "ROOM_PX", 10_000)
    monkeypatch.setattr(job, "window_around", lambda *_: (slice(0, SIZE[1]), slice(0, SIZE[0])))
    monkeypatch.setattr(result, "BAND", 10_000)
    whole = retextured(pixels)
    np.testing.assert_array_equal(place, whole[0])
    np.testing.assert_array_equal(shown, whole[1])
    monkeypatch.setattr(result, "BAND", 7)
    np.testing.assert_array_equal(retextured(pixels)[1], shown)


@pytest.mark.parametrize(("low", "high"), [(3, 20), (-7, 4), (-30, 60), (40, 55), (30, 75), (-130, 5)])
def test_a_window_of_a_mirrored_picture_shows_what_the_picture_does(low: int, high: int) -> None:
    row = np.random.default_rng(0).random((1, 50)).astype(np.float32)
    at = np.stack([np.linspace(low, high, 90), np.zeros(90)], axis=-1).astype(np.float32)
    span = mirrored_span(low, high + 1, 50)
    part = read(row[:, span], at - np.array([span.start, 0], np.float32), Kernel.NEAREST, mirror=True)
    np.testing.assert_array_equal(part, read(row, at, Kernel.NEAREST, mirror=True))


def test_what_lies_in_a_window_is_placed_there_and_the_rest_is_nothing() -> None:
    mask = np.zeros((9, 12), bool)
    mask[3:5, 6:11] = True
    assert window_around(mask, 2) == (slice(1, 7), slice(4, 13))
    whole = place_in(window_around(mask), mask[3:5, 6:11].astype(np.float32), mask.shape)
    np.testing.assert_array_equal(whole > 0, mask)
    assert window_around(np.zeros((4, 5), bool), 3) == (slice(0), slice(0))
