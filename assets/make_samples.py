"""Make the sample pictures, one for each mode. Everything in them is drawn here; the same seed gives the same bytes.

    python assets/make_samples.py [FOLDER]

- `balloons.png`, `balloons_mask.png`: balloons and a banner before a sunburst and ploughed fields, for Warp
- `fox_tail.png`, `fox_tail_curves.json`: fur along a curved spine, for Retexture
- `folded_print.png`: printed cotton in soft folds, for Overlay
"""

import json
import sys
from pathlib import Path
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

Canvas: TypeAlias = NDArray[np.floating]
"""(H, W, 3) or (H, W), 0 to 1, red first."""
Colour: TypeAlias = tuple[float, float, float]

SUPERSAMPLING = 3


def blank(width: int, height: int, channels: int = 3) -> Canvas:
    """Return a black canvas at the supersampled size."""
    return np.zeros((height * SUPERSAMPLING, width * SUPERSAMPLING, channels), np.float32).squeeze()


def finished(canvas: Canvas, rng: np.random.Generator | None = None, grain: float = 0.012) -> NDArray[np.uint8]:
    """Return `canvas` at its final size in 8 bit, with a little film grain."""
    size = (canvas.shape[1] // SUPERSAMPLING, canvas.shape[0] // SUPERSAMPLING)
    small = cv2.resize(canvas, size, interpolation=cv2.INTER_AREA)
    if rng is not None:
        small = small + rng.normal(0, grain, small.shape[:2])[..., None]
    return np.rint(np.clip(small, 0, 1) * 255).astype(np.uint8)


def colour(code: str) -> Colour:
    """Return the colour written as six hexadecimal digits."""
    return int(code[:2], 16) / 255, int(code[2:4], 16) / 255, int(code[4:], 16) / 255


def over(canvas: Canvas, cover: Canvas, paint: Canvas | Colour) -> None:
    """Lay `paint` over `canvas` where `cover`, (H, W), says how much."""
    canvas += cover[..., None] * (np.asarray(paint, np.float32) - canvas)


def polygon(canvas: Canvas, points: NDArray[np.float64]) -> Canvas:
    """Return the cover of a polygon given in final pixels."""
    cover = np.zeros(canvas.shape[:2], np.float32)
    cv2.fillPoly(cover, [np.rint(points * SUPERSAMPLING * 16).astype(np.int32)], 1.0, cv2.LINE_AA, 4)
    return cover


def smooth_noise(rng: np.random.Generator, shape: tuple[int, int], scale_px: float) -> Canvas:
    """Return noise of zero mean and unit deviation, smooth over `scale_px`."""
    small = max(int(shape[0] / scale_px), 2) + 3, max(int(shape[1] / scale_px), 2) + 3
    noise = cv2.resize(rng.normal(size=small).astype(np.float32), shape[::-1], interpolation=cv2.INTER_CUBIC)
    return np.asarray((noise - noise.mean()) / noise.std(), np.float32)


# --- Warp: balloons before a sunburst ------------------------------------------------------------------------------


def sky(width: int, height: int) -> Canvas:
    """Return a sunburst over a graded sky: every ray shows what a warp does to the background."""
    canvas = blank(width, height)
    y, x = np.mgrid[: canvas.shape[0], : canvas.shape[1]].astype(np.float32) / SUPERSAMPLING
    depth = (y / height)[..., None]
    canvas[:] = (1 - depth) * colour("2b4a7a") + depth * np.asarray(colour("f6c98a"))
    angle = np.arctan2(y - 0.66 * height, x - 0.5 * width)
    rays = np.clip(np.sin(angle * 24) * 30, 0, 1)
    distance = np.hypot(x - 0.5 * width, y - 0.66 * height)
    over(canvas, (0.16 * rays * np.exp(-distance / 900)).astype(np.float32), colour("fff3d6"))
    over(canvas, np.clip(92 - distance, 0, 1), colour("ffe9b0"))
    return canvas


def fields(canvas: Canvas, width: int, height: int) -> None:
    """Plough rows of hills that run to the horizon."""
    palette = ("5c7f63", "3f6b57", "7b8b4a", "2f5549")
    x = np.linspace(0, width, 200)
    for number, code in enumerate(palette):
        base = height * (0.66 + 0.085 * number)
        ridge = base + (16 + 6 * number) * np.sin(x / (150 + 25 * number) + 2.1 * number)
        shape = np.concatenate([np.c_[x, ridge], [[width, height], [0, height]]])
        cover = polygon(canvas, shape)
        over(canvas, cover, colour(code))
        yy, xx = np.mgrid[: canvas.shape[0], : canvas.shape[1]].astype(np.float32) / SUPERSAMPLING
        row = np.arctan2(yy - (base - 60), xx - width * (0.2 + 0.22 * number))
        over(canvas, cover * np.clip(np.sin(row * (70 - 9 * number)) * 3, 0, 1) * 0.22, colour("f3e3b5"))


def balloon(canvas: Canvas, mask: Canvas, centre: tuple[float, float], radius: float, stripes: tuple[str, str]) -> None:
    """Draw a hot-air balloon with gores, basket and ropes, and mark it in `mask`."""
    cx, cy = centre
    t = np.linspace(0, 2 * np.pi, 160)
    body = np.c_[cx + radius * np.sin(t), cy - radius * np.cos(t)]
    low = body[:, 1] > cy
    drop = (body[low, 1] - cy) / radius
    body[low, 1] = cy + radius * (drop + 0.34 * drop**2.2)
    body[low, 0] = cx + (body[low, 0] - cx) * (1 - 0.28 * drop**2)
    cover = polygon(canvas, body)
    y, x = np.mgrid[: canvas.shape[0], : canvas.shape[1]].astype(np.float32) / SUPERSAMPLING
    height = np.clip((y - cy) / (1.34 * radius), -0.999, 0.999)
    across = np.clip((x - cx) / (radius * np.sqrt(1 - height**2 * 0.86) + 1e-6), -1, 1)
    gore = np.clip(np.sin(np.arcsin(across) * 8) * 6, -1, 1) * 0.5 + 0.5
    paint = gore[..., None] * np.asarray(colour(stripes[0])) + (1 - gore[..., None]) * np.asarray(colour(stripes[1]))
    band = np.clip(6 * (0.16 - np.abs((y - cy) / radius - 0.12)) * radius / 10, 0, 1)
    paint = paint + band[..., None] * (np.asarray(colour("fbf2dc")) - paint)
    light = 0.62 + 0.5 * np.clip(np.sqrt(np.clip(1 - across**2, 0, 1)) * 0.75 - 0.3 * across - 0.25 * height, 0, 1)
    over(canvas, cover, (paint * light[..., None]).astype(np.float32))
    foot = cy + 1.34 * radius
    rope = colour("3a2b22")
    for side in (-1.0, 1.0):
        line = np.array([[cx + side * 0.2 * radius, foot - 3], [cx + side * 0.13 * radius, foot + 0.36 * radius]])
        over(canvas, polygon(canvas, np.concatenate([line - [0.8, 0], line[::-1] + [0.8, 0]])), rope)
    low_y, wide = foot + 0.34 * radius, 0.16 * radius
    basket = np.array([[-1, 0], [1, 0], [0.82, 1.5], [-0.82, 1.5]]) * wide + [cx, low_y]
    cover_basket = polygon(canvas, basket)
    weave = 0.75 + 0.25 * np.sign(np.sin(x * 1.7) * np.sin(y * 1.7))
    over(canvas, cover_basket, (weave[..., None] * np.asarray(colour("a8743f"))).astype(np.float32))
    hull = np.concatenate([body[~low], body[low], basket])
    outline = cv2.convexHull(hull.astype(np.float32)).squeeze().astype(np.float64)
    grown = cv2.dilate(polygon(canvas, outline), np.ones((5 * SUPERSAMPLING,) * 2))
    np.maximum(mask, grown, out=mask)


def banner(canvas: Canvas, mask: Canvas, corner: tuple[float, float], size: tuple[float, float]) -> None:
    """Draw a ribbon with lettering, and mark it in `mask`."""
    (x, y), (w, h) = corner, size
    tail = 0.5 * h
    for shift, code in ((6.0, "1d2c47"), (0.0, "c8452f")):
        shape = np.array(
            [[-tail, 0], [w + tail, 0], [w + 0.35 * tail, h / 2], [w + tail, h], [-tail, h], [-0.35 * tail, h / 2]]
        )
        over(canvas, polygon(canvas, shape + [x + shift * 0.5, y + shift]) * (0.45 if shift else 1.0), colour(code))
    for edge in (0.12, 0.88):
        line = np.array([[0, edge * h - 1], [w, edge * h - 1], [w, edge * h + 1], [0, edge * h + 1]]) + [x, y]
        over(canvas, polygon(canvas, line), colour("fbe3b8"))
    letters = np.zeros(canvas.shape[:2], np.uint8)
    font, scale, thick = cv2.FONT_HERSHEY_TRIPLEX, h / 15.5, round(h / 12)
    (text_w, text_h), _ = cv2.getTextSize("W E F T", font, scale, thick)
    place = (round((x + w / 2) * SUPERSAMPLING - text_w / 2), round((y + h / 2) * SUPERSAMPLING + text_h / 2))
    cv2.putText(letters, "W E F T", place, font, scale, 255, thick, cv2.LINE_AA)
    over(canvas, letters.astype(np.float32) / 255, colour("fff6e0"))
    frame = np.array([[-tail, -4], [w + tail, -4], [w + tail, h + 10], [-tail, h + 10]]) + [x, y]
    np.maximum(mask, polygon(canvas, frame), out=mask)


def make_balloons(folder: Path) -> None:
    """Write the sample of Warp and its mask."""
    rng = np.random.default_rng(1)
    width, height = 1200, 800
    canvas, mask = sky(width, height), blank(width, height, 1)
    for x, y, s in ((170, 130, 1.0), (560, 90, 0.7), (1010, 210, 1.2), (90, 380, 0.8), (760, 330, 0.6)):
        for dx, dy, r in ((-46, 6, 22), (-18, -8, 30), (20, -4, 26), (50, 8, 18)):
            t = np.linspace(0, 2 * np.pi, 60)
            puff = np.c_[x + s * (dx + 1.5 * r * np.cos(t)), y + s * (dy + 0.62 * r * np.sin(t))]
            over(canvas, polygon(canvas, puff) * 0.5, colour("fdf1e2"))
    fields(canvas, width, height)
    balloon(canvas, mask, (300, 255), 112, ("d8483a", "f2b84b"))
    balloon(canvas, mask, (900, 240), 86, ("23668f", "7cc0c4"))
    balloon(canvas, mask, (612, 385), 52, ("5b3a7d", "e08aa0"))
    banner(canvas, mask, (395, 665), (410, 84))
    write(folder / "balloons.png", finished(canvas, rng))
    write(folder / "balloons_mask.png", (finished(mask) > 127).astype(np.uint8) * 255)


# --- Retexture: a fox's tail ----------------------------------------------------------------------------------------


def bezier(points: NDArray[np.float64], t: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return positions and unit tangents of a cubic Bezier at `t`."""
    a, b, c, d = points
    t = t[:, None]
    place = a * (1 - t) ** 3 + 3 * b * (1 - t) ** 2 * t + 3 * c * (1 - t) * t**2 + d * t**3
    tangent = 3 * ((b - a) * (1 - t) ** 2 + 2 * (c - b) * (1 - t) * t + (d - c) * t**2)
    return place, tangent / np.linalg.norm(tangent, axis=1, keepdims=True)


def tail_girth(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return half the tail's width at `t`, in pixels."""
    width: NDArray[np.float64] = 92 * np.sin(np.pi * np.clip(0.12 + 0.88 * t, 0, 1)) ** 0.6 * (0.55 + 0.6 * t)
    return width


def edge(spine: NDArray[np.float64], side: float) -> NDArray[np.float64]:
    """Return the cubic Bezier nearest to one edge of the tail along `spine`, in whole pixels."""
    t = np.linspace(0.02, 0.9, 60)
    place, along = bezier(spine, t)
    outline = place + np.c_[-along[:, 1], along[:, 0]] * (side * tail_girth(t) + side * 14)[:, None]
    u = np.linspace(0, 1, len(t))[:, None]
    bernstein = np.hstack([(1 - u) ** 3, 3 * (1 - u) ** 2 * u, 3 * (1 - u) * u**2, u**3])
    return np.asarray(np.rint(np.linalg.lstsq(bernstein, outline)[0]))


def make_fox_tail(folder: Path) -> None:
    """Write the sample of Retexture: fur that leans away from a bent spine, and curves that swing the tail."""
    rng = np.random.default_rng(2)
    width, height = 960, 640
    canvas = blank(width, height)
    depth = np.linspace(0, 1, canvas.shape[0], dtype=np.float32)[:, None, None]
    canvas[:] = (1 - depth) * colour("c9d6cf") + depth * np.asarray(colour("7f9a8c"))
    canvas += 0.025 * smooth_noise(rng, canvas.shape[:2], 260)[..., None]
    spine = np.array([[110.0, 470], [330, 610], [600, 520], [850, 150]])
    count = 26000
    t = rng.beta(1.1, 1.0, count)
    across = rng.uniform(-1, 1, count)
    place, along = bezier(spine, t)
    normal = np.c_[-along[:, 1], along[:, 0]]
    girth = tail_girth(t)
    root = place + normal * (across * girth)[:, None]
    lean = along + normal * (across * 0.55 + rng.normal(0, 0.13, count))[:, None]
    length = rng.uniform(22, 46, count) * (0.7 + 0.5 * t)
    order = np.argsort(np.abs(across) * -1.0 + rng.normal(0, 0.25, count))
    dark, warm, pale = (np.asarray(colour(c)) for c in ("5a2a12", "c76a24", "f7ead6"))
    for i in order:
        bend = normal[i] * rng.normal(0, 2.5)
        tip = root[i] + lean[i] * length[i]
        stroke = np.stack([root[i], root[i] + lean[i] * length[i] * 0.55 + bend, tip])
        white = 1 / (1 + np.exp(-(t[i] - 0.8) * 26))
        shade = np.clip(0.72 - 0.36 * across[i] + rng.normal(0, 0.16), 0, 1)
        paint = (1 - shade) * dark + shade * warm
        paint = (1 - white) * paint + white * pale * (0.72 + 0.28 * shade)
        thick = max(1, round(SUPERSAMPLING * rng.uniform(0.35, 0.8)))
        points = np.rint(stroke * SUPERSAMPLING * 16).astype(np.int32)
        cv2.polylines(
            canvas, [points], isClosed=False, color=paint.tolist(), thickness=thick, lineType=cv2.LINE_AA, shift=4
        )
    write(folder / "fox_tail.png", finished(canvas, rng, 0.006))
    swung = np.array([[110.0, 470], [420, 420], [720, 600], [850, 150]])
    edges = [(edge(spine, side), edge(swung, side)) for side in (-1.0, 1.0)]
    pairs = [{"source": a.tolist(), "target": b.tolist(), "closed": False, "passive": False} for a, b in edges]
    curves = {"curves": pairs}
    (folder / "fox_tail_curves.json").write_text(json.dumps(curves, indent=1) + "\n", encoding="utf-8")


# --- Overlay: printed cotton in folds -------------------------------------------------------------------------------


def printed_texel(size: int) -> Canvas:
    """Return one repeat of the print: a daisy with two leaves, and a dot at the corners."""
    scale = size / 120
    texel = np.empty((size, size, 3), np.float32)
    texel[:] = colour("2e4a62")
    y, x = (np.mgrid[:size, :size].astype(np.float32) + 0.5) / scale

    def blot(cx: float, cy: float, rx: float, ry: float, turn: float, code: str) -> None:
        c, s = np.cos(turn), np.sin(turn)
        u, v = (x - cx) * c + (y - cy) * s, -(x - cx) * s + (y - cy) * c
        over(texel, np.clip((1 - np.hypot(u / rx, v / ry)) * min(rx, ry) * scale, 0, 1), colour(code))

    for side in (-1, 1):
        blot(60 + side * 24, 84, 17, 7, side * -0.7, "7fa66a")
    for petal in range(8):
        turn = petal * np.pi / 4
        blot(60 + 19 * np.cos(turn), 52 + 19 * np.sin(turn), 15, 8.5, turn, "f3ece0")
    blot(60, 52, 9.5, 9.5, 0, "e3a33b")
    for cx in (0, 120):
        for cy in (0, 120):
            blot(cx, cy, 8, 8, 0, "d9694f")
    return texel


def make_folded_print(folder: Path) -> None:
    """Write the sample of Overlay: the print repeated over a cloth with soft folds under a light from the left."""
    rng = np.random.default_rng(3)
    width, height, repeat = 900, 700, 62.0
    h, w = height * SUPERSAMPLING, width * SUPERSAMPLING
    y, x = np.mgrid[:h, :w].astype(np.float32) / SUPERSAMPLING
    relief = np.zeros((h, w), np.float32)
    for angle, period, depth, phase in (
        (0.25, 330, 34, 0.4),
        (-0.35, 215, 15, 2.0),
        (1.2, 420, 17, 4.0),
        (0.55, 128, 4.5, 1.0),
    ):
        across = x * np.cos(angle) + y * np.sin(angle) + 24 * np.sin((y * np.cos(angle) - x * np.sin(angle)) / 170)
        relief += depth * np.sin(2 * np.pi * across / period + phase)
    slope_y, slope_x = (g * SUPERSAMPLING for g in np.gradient(relief))
    u = (x + 0.42 * relief + 30 * np.sin(y / 260)) / repeat
    v = (y * 1.03 + 0.3 * relief + 0.08 * x) / repeat
    texel = printed_texel(256)
    tiled = np.tile(texel, (3, 3, 1))
    place = (u % 1 * 256 + 255.5, v % 1 * 256 + 255.5)
    cloth = np.asarray(
        cv2.remap(tiled, place[0].astype(np.float32), place[1].astype(np.float32), cv2.INTER_LINEAR), np.float32
    )
    facing = 0.34 + 0.66 * np.clip(
        (1 - 0.5 * slope_x - 0.2 * slope_y) / np.sqrt(1 + slope_x**2 + slope_y**2) / 1.1, 0, 1.5
    )
    vignette = 1.06 - 0.2 * (((x / width - 0.45) ** 2 + (y / height - 0.45) ** 2) * 2)
    yarn = 1 + 0.035 * np.sin(2 * np.pi * u * 24) + 0.035 * np.sin(2 * np.pi * v * 24)
    cloth *= (facing * vignette * yarn)[..., None]
    write(folder / "folded_print.png", finished(cloth, rng, 0.008))


def write(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write 8-bit pixels as PNG."""
    picture = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    if not cv2.imwrite(str(path), picture, [cv2.IMWRITE_PNG_COMPRESSION, 9]):
        raise OSError(f"{path}: cannot be written")


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    make_balloons(target)
    make_fox_tail(target)
    make_folded_print(target)
