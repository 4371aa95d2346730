"""Small pictures of the document's picture under each preset, drawn a few a frame so that nothing stalls."""

from pathlib import Path

import moderngl
import numpy as np

from app.editor.editor import Editor
from app.render.renderer import Renderer
from app.ui.panels.preset_list import Thumbnail
from core.arrays import InputError, Points
from core.grid import Grid
from core.imaging.images import Image, load
from core.imaging.proxy import proxy, scale_for
from core.warps.presets import PRESETS, make_warp

SIZE_PX = (152, 104)
CELLS = 24
MOST_PIXELS = 1 << 18
"""A file's thumbnail has so many pixels at most."""
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
        self._files: dict[Path, moderngl.Texture | None] = {}
        """By file, the thumbnails of pictures that were asked for."""
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

    def close(self) -> None:
        """Free everything."""
        self.release()
        for texture in self._files.values():
            if texture is not None:
                texture.release()
        self._files.clear()

    def of(self, name: str) -> Thumbnail | None:
        """Return the thumbnail of preset `name`, None while it is not drawn yet."""
        if name not in self._textures and self._left > 0:
            self._left -= 1
            self._draw(name)
            self.is_complete = self._left > 0
        if name not in self._textures:
            return None
        return Thumbnail(self._textures[name].glo, *SIZE_PX)

    def of_file(self, path: Path) -> Thumbnail | None:
        """Return the thumbnail in a small picture's file; None where there is none, or it cannot be read."""
        if path not in self._files:
            self._files[path] = self._loaded(path)
        texture = self._files[path]
        return None if texture is None else Thumbnail(texture.glo, *texture.size)

    def _loaded(self, path: Path) -> moderngl.Texture | None:
        try:
            image = load(path)
        except InputError:
            return None
        pixels = proxy(image, scale_for(image, MOST_PIXELS))
        alpha = np.full((*pixels.shape[:2], 1), 255, np.uint8)
        data = np.ascontiguousarray(np.concatenate([pixels, alpha], axis=2)).tobytes()
        texture = self._context.texture((pixels.shape[1], pixels.shape[0]), 4, data)
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return texture

    def _draw(self, name: str) -> None:
        if self._renderer is None or self._image is None:
            return
        width, height = self._editor.document.size_px
        grid = Grid(width, height, cell_px=max(width, height) / CELLS)
        warped = _draw_warped(name, grid)
        pixels = self._renderer.thumbnails(self._image, grid.nodes, [warped], SIZE_PX)[0]
        texture = self._context.texture(SIZE_PX, 4, np.ascontiguousarray(pixels).tobytes())
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._textures[name] = texture


def _draw_warped(name: str, grid: Grid) -> Points:
    """Return the nodes of `grid` under preset `name`, bent so that it shows."""
    bend = BEND if PRESETS[name].bends else 0.0
    warp = make_warp(name, grid.width_px, grid.height_px, bend=bend, settings=SHOWN_SETTINGS.get(name))
    return warp(grid.nodes)
