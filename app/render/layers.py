"""What the canvas keeps from frame to frame, and how far it has come with what it is to show next."""

from collections.abc import Iterator

import moderngl

from app.render import gpu
from app.render.passes.picture_pass import PicturePass
from app.render.scene import CanvasScene
from app.render.sources.source import Box

LEAST_SHRINK, MOST_SHRINK = 2, 3
EASE = 0.7
"""A draft gets finer again where it would take at most this share of what it may: else it would come and go."""


class CanvasLayers:
    """The picture in linear light, and the canvas as it is shown."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self.picture = PicturePass(context, size, with_cells=True)
        self.shown, self.coming = (gpu.Offscreen(context, size, "f1") for _ in range(2))
        """The canvas, and the one that takes its place when it is whole."""
        for canvas in (self.shown, self.coming):
            canvas.texture.repeat_x = canvas.texture.repeat_y = False
        self.drawn: CanvasScene | None = None
        """What `shown` shows."""
        self.bounds: Box = (0, 0, 0, 0)
        """The pixels outside which that is nothing but desk."""
        self.goal: CanvasScene | None = None
        """What `picture` holds, or what is being drawn there."""
        self.loads: Iterator[None] = iter(())
        """Loads what it is drawn from."""
        self.steps: Iterator[None] | None = None
        """Draws what is missing of it; None when nothing is."""
        self.spent_s = 0.0
        """What drawing it has taken so far."""

    @property
    def cells(self) -> gpu.Offscreen:
        """Grid coordinates of every pixel."""
        assert self.picture.cells is not None
        return self.picture.cells

    def shows(self, scene: CanvasScene) -> bool:
        """Return whether `shown` shows `scene`, marks included."""
        return scene.shows_same_picture(self.drawn) and scene.shows_same_marks(self.drawn)

    def begin(self, goal: CanvasScene, loads: Iterator[None], steps: Iterator[None]) -> None:
        """Take another scene to draw; what was begun is given up."""
        self.goal, self.loads, self.steps, self.spent_s = goal, loads, steps, 0.0

    def turn(self) -> None:
        """Show what has come."""
        self.shown, self.coming = self.coming, self.shown

    def has_picture(self, scene: CanvasScene) -> bool:
        """Return whether the picture of `scene` is there, under whatever marks."""
        return self.shows(scene) or (self.steps is None and scene.shows_same_picture(self.goal))

    def give_up(self) -> None:
        """Leave what is not finished; what is shown stays."""
        if self.steps is not None:
            self.goal = self.steps = None

    def release(self) -> None:
        """Free the GPU objects."""
        gpu.release(self.picture, self.shown, self.coming)


class Costs:
    """What drawing the whole canvas takes, in seconds, as it was seen; decides what is drawn while things move."""

    def __init__(self, frame_s: float) -> None:
        self.frame_s = frame_s
        """What drawing may take of a frame."""
        self.shrink = LEAST_SHRINK
        """By how much a draft is drawn smaller, so that it keeps up with the mouse."""
        self._full_s = 0.0
        self._draft_s = 0.0

    @property
    def full_fits(self) -> bool | None:
        """Whether the canvas can be drawn at its best in one frame; None while that is not known."""
        return None if self._full_s == 0.0 else self._full_s <= self.frame_s

    def learn_full(self, seconds: float, *, finished: bool) -> None:
        """Take note of what the best took, or has taken so far."""
        if finished:
            self._full_s = _smooth(self._full_s, seconds)
        else:
            self._full_s = max(self._full_s, seconds)

    def learn_draft(self, seconds: float, shrink: int) -> None:
        """Take note of what a draft took."""
        self._draft_s = _smooth(self._draft_s, seconds * shrink**2)
        fitting = (shrink for shrink in range(LEAST_SHRINK, MOST_SHRINK) if self._fits(shrink))
        self.shrink = next(fitting, MOST_SHRINK)

    def _fits(self, shrink: int) -> bool:
        """Return whether a draft drawn so much smaller would take no longer than it may."""
        share = EASE if shrink < self.shrink else 1.0
        return self._draft_s <= share * self.frame_s * shrink**2


def _smooth(before: float, now: float) -> float:
    """Return the running mean; a single late frame does not count much."""
    return now if before == 0.0 else 0.7 * before + 0.3 * now
