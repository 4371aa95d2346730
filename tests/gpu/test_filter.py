"""How the picture is resampled, against plain and slow versions of the same on the processor."""

import cv2
import numpy as np
import pytest

from app.render.export import render_mesh
from core.arrays import Floats, Pixels, Points, Singles
from core.imaging import color
from core.imaging.images import Image
from tests.gpu import scenes

pytestmark = pytest.mark.gpu
SIDE = 240


def cubic(x: Floats) -> Floats:
    """Return the kernel of Keys 1981 with a = -1/2."""
    x = np.abs(x)
    near, far = (1.5 * x - 2.5) * x * x + 1, ((2.5 - 0.5 * x) * x - 4) * x + 2
    return np.where(x < 1, near, np.where(x < 2, far, 0.0))


def interpolated(light: Singles, places: Points) -> Floats:
    """Return `light` (H, W, C) at source positions (..., 2) by cubic convolution, first across, then down.

    Each time within the range of the two nearest; the border is repeated.
    """
    whole = np.floor(places).astype(int)
    x, y = np.moveaxis(places - whole, -1, 0)[..., None]
    columns = [np.clip(whole[..., 0] + dx, 0, light.shape[1] - 1) for dx in range(-1, 3)]
    rows = []
    for dy in range(-1, 3):
        row = np.clip(whole[..., 1] + dy, 0, len(light) - 1)
        rows.append(clipped_cubic([light[row, column] for column in columns], x))
    return clipped_cubic(rows, y)


def clipped_cubic(values: list[Pixels], t: Floats) -> Floats:
    """Return the value at t in [0, 1) between the middle two of four."""
    total = sum(cubic(t - k) * value for k, value in zip(range(-1, 3), values, strict=True))
    clipped: Floats = np.clip(np.asarray(total), np.minimum(values[1], values[2]), np.maximum(values[1], values[2]))
    return clipped


def supersampled(light: Singles, jacobian: Floats, start: Floats, size: tuple[int, int], *, box: bool) -> Floats:
    """Return what pixels see of `light` at start + jacobian p, averaged over many samples by a box or the kernel."""
    reach, count = (0.5, 12) if box else (2.0, 28)
    offsets = ((np.arange(count) + 0.5) / count * 2 - 1) * reach
    weights = np.ones(count) if box else cubic(offsets)
    pixels = np.stack(np.meshgrid(np.arange(size[0]), np.arange(size[1])), axis=-1).astype(float)
    result = np.zeros((size[1], size[0], light.shape[2]))
    for dx, wx in zip(offsets, weights, strict=True):
        for dy, wy in zip(offsets, weights, strict=True):
            x, y = np.moveaxis((pixels + [dx, dy]) @ jacobian.T + start, -1, 0).astype(np.float32)
            result += wx * wy * cv2.remap(light, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    mean: Floats = result / weights.sum() ** 2
    return mean


def light_of(image: Image) -> Singles:
    return color.linear_light(image.pixels, linear=image.linear)


def psnr(a: Pixels, b: Pixels) -> float:
    return float(-10 * np.log10(np.mean((a - b) ** 2)))


def through(jacobian: Floats, size: tuple[int, int], image: Image) -> tuple[Image, Floats]:
    """Draw the middle of `image` with d(source) / d(output) = jacobian; return also where the first pixel is from."""
    start = (SIDE - 1) / 2 - jacobian @ ((np.array(size) - 1) / 2)
    rest = scenes.grid(SIDE, SIDE, cells=20)
    return render_mesh(image, rest, (rest - start) @ np.linalg.inv(jacobian).T, size=size), start


def turned(degrees: float) -> Floats:
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[cosine, -sine], [sine, cosine]])


@pytest.mark.parametrize("jacobian", [0.37 * np.eye(2), turned(25) * 0.8, turned(60), np.array([[0.9, 0.1], [0, 0.3]])])
def test_enlarging_is_cubic_convolution(jacobian: Floats) -> None:
    image = scenes.picture(SIDE, SIDE, 3, "f4")
    result, start = through(jacobian, (90, 70), image)
    pixels = np.stack(np.meshgrid(np.arange(90), np.arange(70)), axis=-1)
    expected = interpolated(light_of(image), pixels @ jacobian.T + start)
    assert np.abs(result.pixels[..., :3] - expected).max() < 2e-4


@pytest.mark.parametrize(
    ("jacobian", "size"),
    [
        (1.4 * np.eye(2), (150, 150)),
        (2.7 * np.eye(2), (80, 80)),
        (3.3 * turned(30), (45, 45)),
        (6.0 * np.eye(2), (36, 36)),
        (np.diag([6.0, 1.0]), (34, 150)),
        (np.diag([3.0, 0.5]), (60, 200)),
        (turned(30) @ np.diag([6.0, 1.0]) @ turned(-30), (20, 20)),
        (np.array([[1.0, 3.0], [0.0, 1.0]]), (50, 40)),
    ],
)
def test_shrinking_is_as_good_as_supersampling(jacobian: Floats, size: tuple[int, int]) -> None:
    rng = np.random.default_rng(3)
    noise = cv2.GaussianBlur(rng.random((SIDE, SIDE, 3)).astype(np.float32), (0, 0), 1.5)
    image = Image(np.rint(255 * np.clip(0.5 + 6 * (noise - 0.5), 0, 1)).astype(np.uint8))
    result, start = through(jacobian, size, image)
    light = light_of(image)
    shown = color.unit(result.pixels[..., :3])
    kernel, box = (
        color.encode(np.clip(supersampled(light, jacobian, start, size, box=way), 0, 1).astype(np.float32))
        for way in (False, True)
    )
    whole = (result.pixels[..., 3] == 255) if result.has_alpha else np.ones(size[::-1], bool)
    assert psnr(shown[whole], kernel[whole]) > 32
    assert psnr(shown[whole], box[whole]) > 26
    nearest = np.stack(np.meshgrid(np.arange(size[0]), np.arange(size[1])), axis=-1) @ jacobian.T + start
    unfiltered = color.encode(np.clip(interpolated(light, nearest), 0, 1).astype(np.float32))
    assert psnr(shown[whole], kernel[whole]) > psnr(unfiltered[whole], kernel[whole]) + 1.5


def test_strong_edges_do_not_ring() -> None:
    pixels = np.full((SIDE, SIDE, 3), 60, np.uint8)
    pixels[80:160, 80:160] = 250
    for scale in (0.23, 0.8, 1.7):
        result, _ = through(turned(20) * scale, (90, 90), Image(pixels))
        assert result.pixels[..., :3].min() >= 59
        assert result.pixels[..., :3].max() <= 251


def test_fine_checks_shrink_to_the_grey_of_their_light() -> None:
    checks = np.indices((SIDE, SIDE)).sum(axis=0) % 2 * 255
    image = Image(np.repeat(checks[..., None], 3, axis=2).astype(np.uint8))
    result, _ = through(np.eye(2) * 4.3, (50, 50), image)
    assert np.abs(result.pixels[4:-4, 4:-4].astype(int) - 188).max() <= 2


def test_sharpness_does_not_jump_at_scale_one() -> None:
    image = scenes.picture(SIDE, SIDE, 3, "f4")
    below, _ = through(np.eye(2) * 0.9999, (120, 120), image)
    above, _ = through(np.eye(2) * 1.0001, (120, 120), image)
    assert np.abs(below.pixels - above.pixels).max() < 0.01


def test_hidden_colours_do_not_bleed_into_the_rim() -> None:
    pixels = np.zeros((SIDE, SIDE, 4), np.uint8)
    pixels[...] = (255, 0, 255, 0)
    cv2.circle(pixels, (SIDE // 2, SIDE // 2), 20, (40, 200, 90, 255), -1)
    image = Image(pixels)
    for scale in (0.4, 1.3, 3.7):
        result, _ = through(turned(17) * scale, (110, 110), image)
        seen = result.pixels[result.pixels[..., 3] > 8].astype(int)
        assert (seen[:, 3] < 250).any()
        assert np.abs(seen[:, :3] - [40, 200, 90]).max() <= 2


def test_outline_is_antialiased_by_area() -> None:
    image = Image(np.full((SIDE, SIDE, 3), 255, np.uint8))
    rest = scenes.grid(SIDE, SIDE, cells=30)
    centre = np.array([150.0, 150.0])
    warped = (rest - (SIDE - 1) / 2) @ (turned(33) * 0.61).T + centre
    alpha = render_mesh(image, rest, warped, size=(300, 300)).pixels[..., 3] / 255
    fine = render_mesh(image, rest, warped, size=(2400, 2400), scale=8).pixels[..., 3] / 255
    area = fine.reshape(300, 8, 300, 8).mean(axis=(1, 3))
    assert np.abs(alpha - area).max() < 0.12
    assert abs(alpha.sum() - area.sum()) < 3


def test_thin_slivers_keep_their_area() -> None:
    image = Image(np.full((SIDE, SIDE, 3), 255, np.uint8))
    rest = scenes.grid(SIDE, SIDE, cells=30)
    warped = (rest + 0.5) * [0.4, 0.0013] + [20.2, 29.85]
    result = render_mesh(image, rest, warped, size=(150, 60)).pixels
    assert result[..., 3].sum() / 255 == pytest.approx(0.4 * 240 * 0.0013 * 240, rel=0.1)


def test_thin_and_slanted_cells_beside_the_outline_leave_no_holes() -> None:
    image = Image(np.full((SIDE, SIDE, 3), 180, np.uint8))
    rest = scenes.grid(SIDE, SIDE, cells=30)
    row, column = np.indices(rest.shape[:2])
    near = np.exp(-(((column - 15) / 4) ** 2))
    thin = np.minimum(0.05 * row, 0.2) + np.clip(row - 4, 0, None) * (SIDE - 0.2) / 26 - 0.5
    warped = rest.copy()
    warped[..., 0] += 10 * near * np.exp(-row / 4) * (row > 0)
    warped[..., 1] += near * (thin - rest[..., 1])
    assert render_mesh(image, rest, warped, size=(SIDE, SIDE)).pixels[..., 3].min() > 200


def test_cells_leave_no_seams() -> None:
    side = 229  # not a whole number of the pyramid's blocks
    image = Image(np.full((side, side, 3), 180, np.uint8))
    rest = scenes.grid(side, side, cells=97)
    for scale in (0.07, 0.21, 1.0, 2.3):
        warped = scenes.wavy(rest, amount=9)
        size = round(side * scale)
        result = render_mesh(image, rest, warped, size=(size, size), scale=scale).pixels
        inside = cv2.erode((result[..., 3] > 0).astype(np.uint8), np.ones((5, 5), np.uint8), borderValue=0) > 0
        assert (result[inside][:, 3] == 255).all()
        assert np.abs(result[result[..., 3] > 9][:, :3].astype(int) - 180).max() <= 1
        assert inside.any()
