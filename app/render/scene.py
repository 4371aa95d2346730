"""What the renderer draws: plain data, compared by identity where it is large."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from app.model.session import Heat
from app.model.spaces import View
from app.render.nodes import Scaling
from app.render.sources.overlay_parameters import OverlayParameters
from app.render.sources.source import Box
from core.arrays import Bools, Bytes, Points
from core.imaging.images import Image
from core.mesh import find_bounds
from core.rasters.raster import Raster

EDGE_PX = 3.0
"""So far outside the picture its edge is blended and its outline drawn, in framebuffer pixels."""
Color: TypeAlias = tuple[float, float, float, float]
"""Red, green, blue and alpha, 0 to 1, encoded as on the screen."""
Compare: TypeAlias = Literal["result", "before", "split"]


@dataclass(frozen=True)
class MarkOptions:
    """What is drawn over the picture and bends with it."""

    grid: bool = False
    mask: bool = False
    outline: bool = False
    folds: bool = False
    heat: Heat | None = None
    """What the map does to small things: blue where it makes them smaller, orange where larger, or changes angles."""

    @property
    def any(self) -> bool:
        """Whether anything is drawn at all."""
        return self.grid or self.mask or self.outline or self.folds or self.heat is not None


@dataclass(frozen=True)
class MarkColours:
    """Colours of what is not the picture."""

    desk: Color = (0.11, 0.115, 0.125, 1.0)
    """Around the frame."""
    checks: tuple[Color, Color] = ((0.26, 0.26, 0.27, 1.0), (0.33, 0.33, 0.34, 1.0))
    """Inside the frame, behind the picture."""
    mask: Color = (0.96, 0.23, 0.34, 0.5)
    grid: Color = (1.0, 1.0, 1.0, 0.45)
    outline: Color = (1.0, 1.0, 1.0, 0.8)
    fold: Color = (1.0, 0.12, 0.78, 0.75)
    shrunk: Color = (0.15, 0.45, 1.0, 0.7)
    grown: Color = (1.0, 0.55, 0.08, 0.7)
    features: tuple[Color, ...] = ()
    """Of the mask where `Scene.owners` says so, by number."""


@dataclass(frozen=True, eq=False)
class Beneath:
    """What a regrown picture was regrown from: a picture, and where its places are without that."""

    image: Image
    rest: Points
    """Nodes (R, C, 2) in pixels of the picture."""


@dataclass(frozen=True, eq=False)
class CanvasScene:
    """One frame of the canvas."""

    image: Image
    rest: Points
    """Nodes (R, C, 2) in pixels of the picture."""
    warped: Points
    """Where they are, in pixels of the canvas."""
    view: View
    pixel_ratio: float = 1.0
    """Framebuffer pixels per screen pixel."""
    frame: tuple[float, float, float, float] | None = None
    """Left, top, right and bottom edge of the result, in canvas pixels."""
    mask: Raster | None = None
    owners: Bytes | None = None
    """Which colour of `Palette.features` the mask has at each node (R, C), from 1; 0 for `Palette.mask`."""
    folded: Bools | None = None
    """Which quads (R - 1, C - 1) are folded."""
    marks: MarkOptions = MarkOptions()
    compare: Compare = "result"
    split: float = 0.5
    """Place of the divider, as a share of the width: the picture as it was is left of it."""
    draft: bool = False
    """Draw faster and a little less sharp: while a gesture moves something."""
    palette: MarkColours = MarkColours()
    overlay: OverlayParameters | None = None
    """A texture laid on the cloth in `image`."""
    before: Image | None = None
    """The picture as it was, of the size of `image`; None where that is `image`."""
    before_rest: Points | None = None
    """Nodes (R, C, 2) of `before` that lie where those of the result do; None where it lies as it was."""
    beneath: Beneath | None = None
    """None where nothing is regrown."""
    shrink: int = 1
    """It is drawn so many times smaller than the framebuffer."""

    @property
    def plain(self) -> Beneath:
        """The picture and its nodes, without what was regrown."""
        return self.beneath or Beneath(self.image, self.rest)

    @cached_property
    def scaling(self) -> Scaling:
        """How canvas positions become framebuffer pixels, centres at integers.

        Where a canvas pixel is a whole number of framebuffer pixels, their borders are made to coincide, which moves
        the picture by half a pixel at most: at 100 % the pixels of the file are those of the screen. What is drawn
        smaller lies in the same place.
        """
        zoom = self.view.zoom * self.pixel_ratio
        corner = np.asarray(self.view.pan) * self.pixel_ratio - zoom / 2
        if abs(zoom - round(zoom)) < 1e-6 and zoom > 0.5:
            corner = np.round(corner)
        across, down = ((corner + zoom / 2) / self.shrink - 0.5).tolist()
        return Scaling(zoom / self.shrink, (across, down))

    def in_framebuffer(self, points: Points) -> Points:
        """Return canvas positions (..., 2) in framebuffer pixels."""
        return self.scaling.place(points)

    def divider(self, width: int) -> int:
        """Return the framebuffer column, of `width`, from which on the result is shown."""
        return {"result": 0, "before": width}.get(self.compare, round(self.split * width))

    def parts(self, size: tuple[int, int]) -> list[tuple[str, Points, Box]]:
        """Return what a canvas of `size`, (w, h), shows: a name, positions of the nodes, the framebuffer pixels."""
        width, height = size
        divider = self.divider(width)
        parts = [
            ("before", self.rest if self.before_rest is None else self.warped, (0, 0, divider, height)),
            ("result", self.warped, (divider, 0, width, height)),
        ]
        return [part for part in parts if part[2][0] < part[2][2]]

    def bounds(self, size: tuple[int, int]) -> Box:
        """Return the framebuffer pixels of a canvas of `size`, (w, h), outside which there is nothing but desk."""
        shown = [self.warped] * (self.compare != "before") + [self.rest] * (self.compare != "result")
        corners = [np.stack(find_bounds(nodes)) for nodes in shown]
        corners += [] if self.frame is None else [np.reshape(self.frame, (2, 2))]
        places = self.in_framebuffer(np.concatenate(corners))
        low = np.clip(np.floor(places.min(axis=0) - EDGE_PX), 0, size).astype(int).tolist()
        high = np.clip(np.ceil(places.max(axis=0) + EDGE_PX), 0, size).astype(int).tolist()
        return low[0], low[1], high[0], high[1]

    def fills_same_place(self, other: "CanvasScene | None") -> bool:
        """Return whether the picture in `other` may stay on the screen till this one is drawn."""
        return (
            other is not None
            and self.image is other.image
            and self.before is other.before
            and (self.view, self.pixel_ratio, self.compare, self.split)
            == (other.view, other.pixel_ratio, other.compare, other.split)
        )

    def shows_same_picture(self, other: "CanvasScene | None") -> bool:
        """Return whether the picture without marks looks as in `other`."""
        return (
            other is not None
            and self.image is other.image
            and self.before is other.before
            and self.before_rest is other.before_rest
            and self.rest is other.rest
            and self.warped is other.warped
            and (self.draft, self.shrink) == (other.draft, other.shrink)
            and (self.overlay is other.overlay or (self.overlay is not None and self.overlay.looks_like(other.overlay)))
            and (self.view, self.pixel_ratio, self.compare, self.split)
            == (other.view, other.pixel_ratio, other.compare, other.split)
        )

    def shows_same_marks(self, other: "CanvasScene | None") -> bool:
        """Return whether all else looks as in `other` too."""
        return (
            other is not None
            and self.mask is other.mask
            and self.folded is other.folded
            and self.owners is other.owners
            and (self.marks, self.frame, self.palette) == (other.marks, other.frame, other.palette)
        )
