"""What lies over the picture and bends with it: scale, mask, grid, folds, outline (marks.glsl)."""

import math

import moderngl
import numpy as np
from numpy.typing import NDArray

from app.model.session import Heat
from app.render.gpu import release
from app.render.heat import measure_heat
from app.render.scene import CanvasScene, Color, MarkOptions
from app.render.sources.mask_texture import MaskTexture
from core.arrays import Points, Singles
from core.rasters.raster import Raster

GRID_LINE_PX = 14.0
"""Grid lines are at least so far apart on the screen, at pixel ratio 1."""
MASK_UNIT, FOLDED_UNIT, GROWTH_UNIT, OWNERS_UNIT = 5, 6, 7, 9
"""Texture units, beside those of the grid's nodes (`passes.mesh`) and of the picture (`passes.picture_pass`)."""
MOST_COLORS = 16
"""As in marks.glsl."""
NO_MASK = Raster.filled(1, 1)
NO_FOLDS = np.zeros((1, 1), bool)
NO_OWNERS = np.zeros((1, 1), np.uint8)


class MarksLayer:
    """Keeps on the GPU what the marks show."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._mask: MaskTexture | None = None
        self._textures: dict[str, moderngl.Texture] = {}
        self._seen: dict[str, object] = {}
        self._heated: tuple[Points, Heat, Singles] | None = None
        """The map that was looked at last, for what, and what was found."""

    def uniforms(self, scene: CanvasScene) -> dict[str, object]:
        """Bind the textures that marks.glsl reads, and return its uniforms for `scene`."""
        self._mask_texture(scene.mask or NO_MASK).use(MASK_UNIT)
        folded = NO_FOLDS if scene.folded is None else scene.folded
        self._texture("folded", folded, folded, "u1").use(FOLDED_UNIT)
        if scene.marks.heat is not None:
            self._growth_texture(scene.rest, scene.warped, scene.marks.heat).use(GROWTH_UNIT)
        owners = NO_OWNERS if scene.owners is None else scene.owners
        self._texture("owners", owners, owners, "u1").use(OWNERS_UNIT)
        units = {"mask": MASK_UNIT, "folded": FOLDED_UNIT, "growth": GROWTH_UNIT, "owners": OWNERS_UNIT}
        return {**units, **_look(scene)}

    def _growth_texture(self, rest: Points, shown: Points, heat: Heat) -> moderngl.Texture:
        if self._heated is None or self._heated[0] is not shown or self._heated[1] != heat:
            self._heated = shown, heat, measure_heat(rest, shown, heat)
        texture = self._texture("growth", self._heated[2], self._heated[2], "f4")
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return texture

    def _texture(self, name: str, key: object, values: NDArray[np.generic], dtype: str) -> moderngl.Texture:
        """Return the texture called `name` of `values`, (h, w), made anew when `key` is another."""
        if self._seen.get(name) is not key:
            release(self._textures.get(name))
            data = np.ascontiguousarray(values, {"u1": np.uint8, "f4": np.float32}[dtype]).tobytes()
            texture = self._context.texture((values.shape[1], values.shape[0]), 1, data, dtype=dtype, alignment=1)
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            texture.repeat_x = texture.repeat_y = False
            self._textures[name], self._seen[name] = texture, key
        return self._textures[name]

    def _mask_texture(self, mask: Raster) -> moderngl.Texture:
        if self._mask is None or self._mask.size_px != (mask.width_px, mask.height_px):
            release(self._mask)
            self._mask = MaskTexture(self._context, mask)
        self._mask.update(mask)
        return self._mask.texture

    def release(self) -> None:
        """Free the GPU objects."""
        release(self._mask, *self._textures.values())
        self._mask, self._textures, self._seen, self._heated = None, {}, {}, None


def names_of(marks: MarkOptions) -> tuple[str, ...]:
    """Return what marks.glsl must have defined to show `marks`."""
    return ("SCALE",) * (marks.heat is not None) + ("GRID",) * marks.grid


def _look(scene: CanvasScene) -> dict[str, object]:
    """Return the uniforms of marks.glsl that say what is shown and how."""
    marks, palette = scene.marks, scene.palette
    step, fade = _grid_step(scene)
    return {
        "last_cell": (scene.rest.shape[1] - 1.0, scene.rest.shape[0] - 1.0),
        "grid_color": _shown(marks.grid, palette.grid),
        "outline_color": _shown(marks.outline, palette.outline),
        "fold_color": _shown(marks.folds and scene.folded is not None, palette.fold),
        "shrunk_color": _shown(marks.heat is not None, palette.shrunk),
        "grown_color": _shown(marks.heat is not None, palette.grown),
        "grid_step": step,
        "grid_fade": fade,
        "mask_colors": _table(scene),
        "before_mask": float(scene.compare == "split" and marks.mask and scene.mask is not None),
        "line_px": max(1.0, scene.pixel_ratio / scene.shrink),
    }


def _table(scene: CanvasScene) -> list[Color]:
    """Return the colours of the mask by the numbers in `Scene.owners`: first that where there is none."""
    palette, marks = scene.palette, scene.marks
    colors = [palette.mask, *(palette.features if scene.owners is not None else ())][:MOST_COLORS]
    colors += [palette.mask] * (MOST_COLORS - len(colors))
    return [_shown(marks.mask and scene.mask is not None, color) for color in colors]


def _shown(switch: bool, color: Color) -> Color:
    return color if switch else (0.0, 0.0, 0.0, 0.0)


def _grid_step(scene: CanvasScene) -> tuple[float, float]:
    """Return how many cells lie between grid lines, a power of two, and how strong the lines halfway between are.

    Zooming out, every second line fades before it goes: `fade` falls from 1 to 0 while lines close in from twice the
    least distance to it.
    """
    cell_px = float(np.linalg.norm(scene.rest[1, 1] - scene.rest[0, 0]) / math.sqrt(2)) * scene.view.zoom
    level = max(math.log2(GRID_LINE_PX / max(cell_px, 1e-6)), 0.0)
    return float(2 ** math.ceil(level)), math.ceil(level) - level
