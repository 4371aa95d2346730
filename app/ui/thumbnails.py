"""Small pictures of the document's picture under each preset, drawn a few a frame so that nothing stalls."""

import moderngl
import numpy as np

from app.editor import Editor
from app.render.renderer import Renderer
from app.ui.preset_list import Thumbnail
from core.arrays import Points
from core.grid import Grid
from core.images import Image
from core.warps.presets import PRESETS, make_warp

SIZE_PX = (152, 104)
CELLS = 24
A_FRAME = 2
"""How many are drawn in one frame at most."""
BEND = 50.0
SHOWN_SETTINGS = {
    "perspective": {"top-left-x": 20.0, "top-right-x": -20.0},
    "stretch": {"width": 150.0},
}
"""What shows a preset that does nothing by its bend."""


class Thumbnails:
    """Textures by preset, for the picture that is open."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._renderer: Renderer | None = None
        self._image: Image | None = None
        self._textures: dict[str, moderngl.Texture] = {}
        self._left = 0
        self.is_complete = True
        """Whether this frame has drawn fewer than it may: else the next one goes on."""

    def attach(self, context: moderngl.Context, renderer: Renderer) -> None:
        """Begin to draw, in the context of the window."""
        self._context, self._renderer = context, renderer

    def begin_frame(self) -> None:
        """Allow a few more to be drawn where nothing else is; drop those of another picture."""
        waits = self._editor.is_busy or self._renderer is None or not self._renderer.is_at_rest
        self._left, self.is_complete = 0 if waits else A_FRAME, True
        if self._image is not self._editor.document.image:
            self._image = self._editor.document.image
            self.release()

    def release(self) -> None:
        """Free the textures."""
        for texture in self._textures.values():
            texture.release()
        self._textures.clear()

    def of(self, name: str) -> Thumbnail | None:
        """Return the thumbnail of preset `name`, None while it is not drawn yet."""
        if name not in self._textures and self._left > 0:
            self._left -= 1
            self._draw(name)
            self.is_complete = self._left > 0
        if name not in self._textures:
            return None
        return Thumbnail(self._textures[name].glo, *SIZE_PX)

    def _draw(self, name: str) -> None:
        if self._renderer is None or self._image is None:
            return
        width, height = self._editor.document.size_px
        grid = Grid(width, height, cell_px=max(width, height) / CELLS)
        warped = _warped(name, grid)
        pixels = self._renderer.thumbnails(self._image, grid.nodes, [warped], SIZE_PX)[0]
        texture = self._context.texture(SIZE_PX, 4, np.ascontiguousarray(pixels).tobytes())
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._textures[name] = texture


def _warped(name: str, grid: Grid) -> Points:
    """Return the nodes of `grid` under preset `name`, bent so that it shows."""
    bend = BEND if PRESETS[name].bends else 0.0
    warp = make_warp(name, grid.width_px, grid.height_px, bend=bend, settings=SHOWN_SETTINGS.get(name))
    return warp(grid.nodes)
