"""What the renderer is to draw, from the editor's state."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from app.actions.overlay import works_on_photo
from app.editor.editor import Editor
from app.live.answer import Answer
from app.marking.feature_list import feature_list
from app.render.scene import Beneath, CanvasScene, MarkColours, MarkOptions
from app.render.sources.overlay_parameters import OverlayParameters
from app.state.preferences import Preferences
from app.ui.canvas.regrown_tint import RegrownTint
from app.ui.widgets import theme
from core.arrays import Bools, Bytes, Points
from core.document.overlay_texture import is_changed, layers_under, pattern_of, placement_of
from core.document.retexture import moves
from core.rasters.raster import Raster


def _shade(code: int, alpha: float = 1.0) -> tuple[float, float, float, float]:
    tone = theme.rgb(code, alpha)
    return tone.x, tone.y, tone.z, tone.w


PALETTE = MarkColours(
    desk=_shade(theme.DESK),
    mask=_shade(theme.MASK, 0.4),
    grid=_shade(theme.TEXT, 0.45),
    outline=_shade(theme.TEXT, 0.8),
    fold=_shade(theme.FOLD, 0.8),
)


REST_S = 0.12
"""When nothing has moved for so long, the canvas is drawn at its best."""
FOLDED_S = 1.0
"""The same for a map with folds: what the drawing leaves goes to the one without, which soon takes its place."""

SAME_PX = 1e-4
SAMPLED = 16
"""One of so many rows and columns of nodes is looked at first."""


class Motion:
    """Tells frames in which the picture moves, which are drawn fast, from those that it rests in.

    A gesture that has moved the picture stays fast to its end; a stroke of the brush that moves nothing never is.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._seen: tuple[object, ...] = ()
        self._answer: Answer | None = None
        self.rest: Points = np.empty((0, 0, 2))
        self.warped: Points = np.empty((0, 0, 2))
        """The map of the frame: the arrays of the frame before where they say the same, for the renderer looks at
        identity."""
        self.folded: Bools | None = None
        """Which quads are folded, kept likewise."""
        self.regrown_tint = RegrownTint()
        self._moved_at, self._rest_s = 0.0, REST_S
        self._is_busy = False
        self.is_draft = False

    def update(self, editor: Editor) -> None:
        """Look at the editor; once a frame, when the map is that of the frame."""
        answer, session = editor.answer, editor.session
        if answer is not self._answer:
            self._take(answer)
        opened = not self._seen or self._seen[0] is not answer.document.image
        laying = editor.document.cloth.laying if session.mode == "overlay" else None
        seen = (answer.document.image, session.view, session.compare, session.split, laying, id(self.warped))
        only_settled = answer.settled and seen[:-1] == self._seen[:-1]
        moved = seen != self._seen and not opened and not only_settled
        self._seen, self._is_busy = seen, editor.is_busy
        self._rest_s = FOLDED_S if answer.folds and not answer.settled else REST_S
        if moved:
            self.is_draft, self._moved_at = editor.preferences.drafts, self._clock()
        elif opened or not (editor.is_busy or self.wait_s):
            self.is_draft = False

    def _take(self, answer: Answer) -> None:
        """Take the map of another answer, as far as it says anything else."""
        self._answer = answer
        self.rest = _kept(self.rest, answer.rest)
        self.warped = _kept(self.warped, answer.warped)
        if self.folded is None or answer.folded is None or not np.array_equal(self.folded, answer.folded):
            self.folded = answer.folded

    @property
    def wait_s(self) -> float | None:
        """Seconds until the canvas is to be drawn at its best; None when that needs an event."""
        if not self.is_draft or self._is_busy:
            return None
        return max(0.0, self._moved_at + self._rest_s - self._clock())


def _kept(before: Points, now: Points) -> Points:
    """Return `before` where `now` takes no node to a visibly different place; a few of them mostly tell."""
    if before is now or before.shape != now.shape:
        return now
    steps = (SAMPLED, 1)
    return before if all(np.abs(before[::k, ::k] - now[::k, ::k]).max() < SAME_PX for k in steps) else now


def scene_of(editor: Editor, pixel_ratio: float, motion: Motion) -> CanvasScene:
    """Return one frame of the canvas."""
    session, answer = editor.session, editor.answer
    width, height = editor.canvas_px
    scene = CanvasScene(
        image=answer.document.image,
        rest=answer.rest,
        warped=answer.warped,
        view=session.view,
        pixel_ratio=pixel_ratio,
        frame=(-0.5, -0.5, width - 0.5, height - 0.5),
        compare="result" if session.compare == "onion" else session.compare,
        split=session.split,
        draft=motion.is_draft,
        palette=PALETTE,
    )
    of_mode = {"warp": _warp_scene, "retexture": _retexture_scene, "overlay": _overlay_scene}
    return of_mode[session.mode](scene, editor, motion)


def _warp_scene(scene: CanvasScene, editor: Editor, motion: Motion) -> CanvasScene:
    """Return one frame of Warp mode: the picture as it is bent, with what is switched on over it."""
    overlays = editor.session.overlays
    return replace(
        scene,
        rest=motion.rest,
        warped=motion.warped,
        mask=editor.document.mask,
        owners=feature_owners(editor) if editor.preferences.feature_colors else None,
        palette=warp_palette(editor.preferences),
        folded=motion.folded,
        marks=MarkOptions(
            grid=overlays.grid,
            mask=overlays.mask,
            outline=overlays.outline,
            folds=overlays.folds,
            heat=overlays.heat,
        ),
    )


@lru_cache(maxsize=4)
def warp_palette(preferences: Preferences) -> MarkColours:
    """Return the colours of Warp mode."""
    opacity = preferences.mask_opacity
    features = tuple(_shade(code, opacity) for code in (*theme.FEATURES, theme.GIVEN_UP))
    return replace(PALETTE, mask=_shade(preferences.mask_color, opacity), features=features)


def feature_owners(editor: Editor) -> Bytes:
    """Return the number of the colour of each node (R, C), the same object while no feature changes."""
    return feature_list(editor).owners(editor.document, editor.map.grid, len(theme.FEATURES))


def _retexture_scene(scene: CanvasScene, editor: Editor, motion: Motion) -> CanvasScene:
    """Return one frame of Retexture mode: the picture as the artist wants to look at it."""
    document, session = editor.document, editor.session
    overlays, before = session.overlays, session.compare == "before"
    shown = editor.regrowth.choose_picture(document, "original" if before else session.look)
    mask, palette = _tinted(editor, motion.regrown_tint)
    beneath = None if shown.source is None else Beneath(document.image, shown.source)
    return replace(
        scene,
        image=shown.image,
        rest=shown.rest,
        warped=shown.warped,
        mask=mask,
        marks=MarkOptions(grid=overlays.grid, mask=mask is not None and not before, heat=overlays.heat),
        compare="result" if before else scene.compare,
        draft=editor.regrowth.is_moving and session.look != "original" and editor.preferences.drafts,
        palette=palette,
        before=document.image,
        before_rest=editor.regrowth.choose_picture(document, "deformed").rest
        if session.look_before == "deformed"
        else None,
        beneath=beneath,
    )


def _overlay_scene(scene: CanvasScene, editor: Editor, motion: Motion) -> CanvasScene:
    """Return one frame of Overlay mode: the photo with the texture laid on, or a part of what was found."""
    document, session = editor.document, editor.session
    layers, cloth = editor.overlay.layers, document.cloth
    overlay = None
    is_worn = session.shown == "result" and not works_on_photo(session) and is_changed(cloth)
    if layers is not None and is_worn:
        laying = cloth.laying
        placement = placement_of(layers, cloth.texture, laying)
        overlay = OverlayParameters(
            layers_under(cloth, layers), pattern_of(cloth, layers), placement, laying.detail, laying.shading
        )
    part = editor.overlay.part(document, session.shown)
    mask = getattr(cloth, session.painted_on_cloth) if session.tool == "brush" else cloth.region
    if session.painted_on_cloth == "covered" and editor.overlay.is_final and is_worn and not session.brush.erase:
        # What is covered shows the texture.
        mask = None
    return replace(
        scene,
        image=document.image if part is None or session.compare == "before" else part,
        mask=mask,
        marks=MarkOptions(mask=session.overlays.mask and mask is not None and session.tool in ("brush", "region")),
        overlay=overlay,
    )


def _tinted(editor: Editor, tint: RegrownTint) -> tuple[Raster | None, MarkColours]:
    """Return what is laid over the picture, and in which colours: what is regrown, seams, or what the brush paints.

    The matte lies on the result and stays where it is; where texture is taken from lies on the original only.
    """
    document, session, stage = editor.document, editor.session, editor.regrowth.stage
    overlays = session.overlays
    if stage is not None and session.look != "original":
        if overlays.seams:
            return stage.seams, replace(PALETTE, mask=_shade(theme.ACCENT, 0.8))
        if overlays.compression:
            return stage.compression, replace(PALETTE, mask=_shade(theme.FOLD, 0.8))
    if session.look != "original" and (
        overlays.regrown or (session.painted == "regrow" and editor.tool.marks and overlays.mask)
    ):
        regrown = None if stage is None else stage.regrown
        return tint.of(regrown, document.regrow), replace(PALETTE, mask=_shade(theme.TARGET, 0.45))
    if session.painted == "regrow":
        return None, PALETTE
    if session.painted == "matte":
        raster = document.matte
    else:
        raster = document.source_mask if session.look == "original" or not moves(document) else None
    return (raster if overlays.mask else None), PALETTE
