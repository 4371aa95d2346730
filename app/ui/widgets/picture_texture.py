"""The picture that is open as a texture of the panels: small, and as it is without the warp."""

import moderngl
import numpy as np

from app.ui.panels.preset_list import Thumbnail
from core.imaging.image import Image
from core.imaging.proxy import proxy, scale_for

MOST_PIXELS = 1 << 20


class PictureTexture:
    """Keeps the texture of the picture that was asked for last."""

    def __init__(self) -> None:
        self._context: moderngl.Context | None = None
        self._image: Image | None = None
        self._texture: moderngl.Texture | None = None

    def attach(self, context: moderngl.Context) -> None:
        """Begin to make textures, in the context of the window."""
        self._context = context

    def of(self, image: Image) -> Thumbnail | None:
        """Return the texture of a picture; None before there is a context."""
        if self._context is None:
            return None
        if self._image is not image or self._texture is None:
            self.close()
            pixels = proxy(image, scale_for(image, MOST_PIXELS))
            opaque = np.full((*pixels.shape[:2], 1), 255, np.uint8)
            data = np.ascontiguousarray(np.concatenate([pixels, opaque], axis=2)).tobytes()
            self._texture = self._context.texture((pixels.shape[1], pixels.shape[0]), 4, data)
            self._texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            self._image = image
        return Thumbnail(self._texture.glo, *self._texture.size)

    def close(self) -> None:
        """Free the texture."""
        if self._texture is not None:
            self._texture.release()
        self._texture = self._image = None
