"""The program's emblem: three weft threads through three warp threads."""

import numpy as np

from app.ui.widgets import theme
from core.arrays import Bools, Bytes, Floats


def emblem(side_px: int) -> Bytes:
    """Return the emblem as (side, side, 4) uint8 with straight alpha, drawn at four times its size and averaged."""
    fine = 4 * side_px
    y, x = np.mgrid[0:fine, 0:fine] / fine
    picture = np.zeros((fine, fine, 4))
    corner = np.maximum(np.abs(np.stack([x, y]) - 0.5) - 0.32, 0)
    _paint(picture, np.hypot(*corner) < 0.18, theme.PANEL)
    for column in range(3):
        at = (column + 1) / 4 + 0.0 * x
        _paint(picture, _thread(x - at, y), theme.EDGE)
    for row in range(3):
        wave = (row + 1) / 4 + 0.03 * np.sin(4 * np.pi * x + np.pi * row)
        over = np.sin(4 * np.pi * x + np.pi * row + np.pi / 2) > -0.55
        _paint(picture, _thread(y - wave, x) & over, theme.ACCENT if row != 1 else theme.TARGET)
    averaged = picture.reshape(side_px, 4, side_px, 4, 4).mean(axis=(1, 3))
    averaged[..., :3] /= np.maximum(averaged[..., 3:], 1e-6)
    return np.asarray(np.round(averaged * 255), np.uint8)


def _thread(across: Floats, along: Floats) -> Bools:
    return (np.abs(across) < 0.055) & (np.abs(along - 0.5) < 0.4)


def _paint(picture: Floats, where: Bools, code: int) -> None:
    """Set premultiplied colour and alpha where told."""
    tone = theme.rgb(code)
    picture[where] = (tone.x, tone.y, tone.z, 1.0)
