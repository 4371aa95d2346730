"""OBJ meshes: a warp as a textured surface, as 3D and compositing programs read it.

The warped grid lies flat in the plane z = 0, in pixels of the output from its bottom left corner, y upwards; texture
coordinates are shares of the source's width and height from its bottom left corner. Faces are the grid's quads,
counter-clockwise.
"""

import io

import numpy as np

from core.arrays import Points
from core.canvas import Canvas


def obj_mesh(rest: Points, warped: Points, source_px: tuple[int, int], canvas: Canvas) -> str:
    """Return the text of the OBJ file of a warped grid.

    `rest` (R, C, 2) are pixels of the source of `source_px`, (width, height), `warped` those of `canvas`.
    """
    rows, columns = rest.shape[:2]
    places = warped.reshape(-1, 2) + 0.5
    places[:, 1] = canvas.height_px - places[:, 1]
    shares = (rest.reshape(-1, 2) + 0.5) / source_px
    shares[:, 1] = 1 - shares[:, 1]
    number = np.arange(1, rows * columns + 1).reshape(rows, columns)
    quads = np.stack([number[1:, :-1], number[1:, 1:], number[:-1, 1:], number[:-1, :-1]], axis=-1).reshape(-1, 4)
    text = io.StringIO()
    np.savetxt(text, places, fmt="v %.6f %.6f 0")
    np.savetxt(text, shares, fmt="vt %.9f %.9f")
    np.savetxt(text, quads.repeat(2, axis=1), fmt="f %d/%d %d/%d %d/%d %d/%d")
    return text.getvalue()
