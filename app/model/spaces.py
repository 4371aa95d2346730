"""The spaces of the canvas and the ways between them.

`image`: pixels of the source picture. `canvas`: pixels of the result, the space the warp maps to; the same as `image`
while nothing is warped. `screen`: pixels of the canvas widget, (0, 0) its top left corner; they are as
large as the artist's text size and the display make them, so that handles and their reach grow with the text.
"""

from dataclasses import dataclass, replace

import numpy as np

from core.arrays import Points

LEAST_ZOOM, MOST_ZOOM = 1 / 64, 64.0


@dataclass(frozen=True)
class View:
    """How the canvas lies on the screen: screen = zoom * canvas + pan."""

    zoom: float = 1.0
    """Screen pixels per canvas pixel."""
    pan: tuple[float, float] = (0.0, 0.0)
    """Screen position of canvas (0, 0), the centre of the first pixel."""
    size: tuple[float, float] = (1.0, 1.0)
    """Width and height of the canvas widget in screen pixels."""
    unit: float = 1.0
    """Pixels of the window per screen pixel."""

    @property
    def magnification(self) -> float:
        """Pixels of the window per canvas pixel: the zoom as the artist reads it."""
        return self.zoom * self.unit


def screen_from_canvas(view: View, points: Points) -> Points:
    """Return screen positions of canvas positions (..., 2)."""
    return np.asarray(points, float) * view.zoom + view.pan


def canvas_from_screen(view: View, points: Points) -> Points:
    """Return canvas positions of screen positions (..., 2)."""
    return (np.asarray(points, float) - view.pan) / view.zoom


def zoom_at(view: View, factor: float, screen: tuple[float, float]) -> View:
    """Return the view zoomed by `factor` with the canvas under `screen` held in place."""
    zoom = float(np.clip(view.zoom * factor, LEAST_ZOOM, MOST_ZOOM))
    ratio = zoom / view.zoom
    pan = (screen[0] + (view.pan[0] - screen[0]) * ratio, screen[1] + (view.pan[1] - screen[1]) * ratio)
    return replace(view, zoom=zoom, pan=pan)


def move(view: View, by: tuple[float, float]) -> View:
    """Return the view moved by screen pixels."""
    return replace(view, pan=(view.pan[0] + by[0], view.pan[1] + by[1]))


def fit_curve(view: View, low: Points, high: Points, *, margin_px: float = 24.0) -> View:
    """Return the view that shows canvas positions `low` to `high`, (2,) each, whole and centred."""
    extent = np.maximum(np.asarray(high, float) - low, 1e-6)
    room = np.maximum(np.asarray(view.size) - 2 * margin_px, 1.0)
    zoom = float(np.clip((room / extent).min(), LEAST_ZOOM, MOST_ZOOM))
    return centre(replace(view, zoom=zoom), (np.asarray(low, float) + high) / 2)


def centre(view: View, middle: Points) -> View:
    """Return the view with canvas position `middle`, (2,), at its centre."""
    pan = np.asarray(view.size) / 2 - np.asarray(middle) * view.zoom
    return replace(view, pan=(float(pan[0]), float(pan[1])))
