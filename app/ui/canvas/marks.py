"""Draws what tools leave over the picture: every line on a darker, wider one, so that it shows on any picture."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from imgui_bundle import ImVec2, ImVec2Like, imgui

from app.model.shapes import Bezier, Circle, Polyline, Role, Shape, Square
from app.ui.canvas.input import Area
from app.ui.widgets import theme
from core.arrays import Points


@dataclass(frozen=True)
class Pen:
    """How a role is drawn; widths in pixels of a display at scale 1."""

    code: int
    width: float = 1.6
    alpha: float = 1.0
    fill: float = 0.0
    """Alpha of the inside of shapes that are not filled."""


HALO = 0x101113
WHITE = 0xF7F8F9
RIM_PX = 1.7
"""Width of the dark rim of filled shapes."""

PENS: dict[Role, Pen] = {
    "pin": Pen(theme.TARGET, 2.0),
    "pin-selected": Pen(theme.ACCENT, 2.4),
    "pin-rest": Pen(WHITE, 1.4, alpha=0.75),
    "source": Pen(WHITE, 1.8),
    "target": Pen(theme.TARGET, 2.2),
    "faulty": Pen(theme.FAULT, 2.6),
    "passive": Pen(theme.GOOD, 1.8),
    "edge": Pen(theme.GOOD, 1.0, alpha=0.8),
    "suggestion": Pen(theme.GOOD, 2.0, alpha=0.9),
    "patch": Pen(theme.ACCENT, 1.0, alpha=0.7),
    "spine": Pen(theme.TARGET, 1.0, alpha=0.7),
    "tick": Pen(theme.TARGET, 1.2, alpha=0.7),
    "outline": Pen(WHITE, 1.5),
    "corner": Pen(WHITE, 1.6, fill=0.25),
    "knot": Pen(WHITE, 1.6, fill=0.2),
    "knot-selected": Pen(theme.ACCENT, 2.0),
    "handle": Pen(theme.TARGET, 1.6),
    "link": Pen(WHITE, 1.1, alpha=0.6),
    "hover": Pen(theme.ACCENT, 2.6),
    "rubber-band": Pen(theme.ACCENT, 1.4),
    "box": Pen(theme.ACCENT, 1.2),
    "brush": Pen(WHITE, 1.4),
    "brush-core": Pen(WHITE, 1.0, alpha=0.55),
    "brush-erase": Pen(theme.FAULT, 1.4),
    "lattice": Pen(theme.GOOD, 1.2, alpha=0.8),
    "lattice-weak": Pen(theme.FAULT, 1.4, alpha=0.9),
    "vertex": Pen(WHITE, 1.4),
}

DASH_EM, GAP_EM = 0.38, 0.28
MOST_DASHES = 2000


class MarkPainter:
    """Draws shapes, in screen pixels of the canvas, on a draw list of the window, in which the canvas is `area`."""

    def __init__(self, sheet: imgui.ImDrawList, area: Area) -> None:
        self._sheet = sheet
        self._area = area
        self._scale = area.unit

    def draw(self, shapes: Iterable[Shape]) -> None:
        """Draw `shapes`, the first lowest."""
        for shape in shapes:
            match shape:
                case Circle():
                    self._circle(shape)
                case Square():
                    self._square(shape)
                case Polyline():
                    self._polyline(shape)
                case Bezier():
                    self._bezier(shape)

    def _place(self, point: Sequence[float] | Points) -> ImVec2:
        return ImVec2(*self._area.in_window(float(point[0]), float(point[1])))

    def _strokes(self, pen: Pen) -> tuple[tuple[int, float], tuple[int, float]]:
        """Return colour and width of the halo and of the line upon it."""
        halo = theme.color(HALO, 0.6 * pen.alpha), (pen.width + 2.2) * self._scale
        return halo, (theme.color(pen.code, pen.alpha), pen.width * self._scale)

    def _circle(self, shape: Circle) -> None:
        pen, centre, radius = PENS[shape.role], self._place(shape.centre), max(shape.radius_px, 0.5) * self._scale
        if shape.filled:
            self._sheet.add_circle_filled(centre, radius + RIM_PX * self._scale, theme.color(HALO, 0.85 * pen.alpha))
            self._sheet.add_circle_filled(centre, radius, theme.color(pen.code, pen.alpha))
            return
        if pen.fill:
            self._sheet.add_circle_filled(centre, radius, theme.color(pen.code, pen.fill))
        dashes = _arcs(radius, self._scale) if shape.dashed else []
        for code, width in self._strokes(pen):
            if not dashes:
                self._sheet.add_circle(centre, radius, code, 0, width)
            for start, end in dashes:
                self._sheet.path_arc_to(centre, radius, start, end)
                self._sheet.path_stroke(code, width)

    def _square(self, shape: Square) -> None:
        pen, half = PENS[shape.role], shape.half_px
        low, high = (self._place(np.add(shape.centre, by)) for by in (-half, half))
        if shape.filled:
            rim = RIM_PX * self._scale
            outer = ImVec2(low.x - rim, low.y - rim), ImVec2(high.x + rim, high.y + rim)
            self._sheet.add_rect_filled(*outer, theme.color(HALO, 0.85 * pen.alpha), rim)
            self._sheet.add_rect_filled(low, high, theme.color(pen.code, pen.alpha))
            return
        if pen.fill:
            self._sheet.add_rect_filled(low, high, theme.color(pen.code, pen.fill))
        for code, width in self._strokes(pen):
            self._sheet.add_rect(low, high, code, 0.0, width)

    def _polyline(self, shape: Polyline) -> None:
        points = np.asarray(shape.points, float)
        if len(points) < 2:
            return
        if shape.closed:
            points = np.concatenate([points, points[:1]])
        points = self._scale * points + (self._area.x, self._area.y)
        pieces: list[list[ImVec2Like]] = _dashes(points, self._scale) if shape.dashed else [points.tolist()]
        for code, width in self._strokes(PENS[shape.role]):
            for piece in pieces:
                self._sheet.add_polyline(piece, code, width, 0)

    def _bezier(self, shape: Bezier) -> None:
        points = np.asarray(shape.points, float)
        if shape.dashed:
            self._polyline(Polyline(_sampled(points), shape.role, dashed=True))
            return
        corners = [self._place(p) for p in points]
        for code, width in self._strokes(PENS[shape.role]):
            for first in range(0, len(corners) - 3, 3):
                a, b, c, d = corners[first : first + 4]
                self._sheet.add_bezier_cubic(a, b, c, d, code, width)


@lru_cache(maxsize=8)
def _arcs(radius: float, scale: float) -> list[tuple[float, float]]:
    """Return from where to where the dashes of a circle are, in radians; none of them is cut short."""
    step = scale * theme.TEXT_PX * (DASH_EM + GAP_EM)
    starts = np.linspace(0, 2 * np.pi, max(round(2 * np.pi * radius / step), 1), endpoint=False)
    length = 2 * np.pi / len(starts) * DASH_EM / (DASH_EM + GAP_EM)
    return [(start, start + length) for start in starts.tolist()]


def _dashes(points: Points, scale: float) -> list[list[ImVec2Like]]:
    """Cut a polyline (n, 2) into dashes, so many times longer than usual, with the corners that they go around."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    dash, step = scale * theme.TEXT_PX * DASH_EM, scale * theme.TEXT_PX * (DASH_EM + GAP_EM)
    starts = step * np.arange(min(math.ceil(along[-1] / step), MOST_DASHES))
    ends = np.minimum(starts + dash, along[-1])
    first, last = (
        np.stack([np.interp(lengths, along, points[:, axis]) for axis in (0, 1)], axis=1).tolist()
        for lengths in (starts, ends)
    )
    after, before = np.searchsorted(along, starts, "right").tolist(), np.searchsorted(along, ends).tolist()
    corners = points.tolist()
    return [[a, *corners[i:j], b] for a, i, j, b in zip(first, after, before, last, strict=True)]


def _sampled(points: Points, *, per_segment: int = 24) -> Points:
    """Return points along a piecewise cubic Bezier curve (3k + 1, 2)."""
    t = np.linspace(0, 1, per_segment)[:, None]
    weights = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    return np.concatenate([np.einsum("kns,kd->nd", weights, points[i : i + 4]) for i in range(0, len(points) - 3, 3)])
