"""What the renderer is to draw, from the editor's state."""

from app.editor import Editor
from app.render.scene import Marks, Palette, Scene
from app.ui import theme


def _shade(code: int, alpha: float = 1.0) -> tuple[float, float, float, float]:
    tone = theme.rgb(code, alpha)
    return tone.x, tone.y, tone.z, tone.w


PALETTE = Palette(
    desk=_shade(theme.DESK),
    mask=_shade(theme.MASK, 0.4),
    grid=_shade(theme.TEXT, 0.45),
    outline=_shade(theme.TEXT, 0.8),
    fold=_shade(theme.FOLD, 0.8),
)


def scene_of(editor: Editor, pixel_ratio: float) -> Scene:
    """Return one frame of the canvas."""
    answer, document, session = editor.answer, editor.document, editor.session
    overlays = session.overlays
    width, height = document.canvas_px
    return Scene(
        image=answer.document.image,
        rest=answer.rest,
        warped=answer.warped,
        view=session.view,
        pixel_ratio=pixel_ratio,
        frame=(-0.5, -0.5, width - 0.5, height - 0.5),
        mask=document.mask,
        folded=answer.folded,
        marks=Marks(
            grid=overlays.grid,
            mask=overlays.mask,
            outline=overlays.outline,
            folds=overlays.folds,
            scale=overlays.scale,
        ),
        compare=session.compare,
        split=session.split,
        draft=editor.is_busy,
        palette=PALETTE,
    )
