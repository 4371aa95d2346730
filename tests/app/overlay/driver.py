"""An editor in Overlay mode, a photo of cloth and a texture."""

import numpy as np

from app.actions.table import ActionTable
from app.tools.all import TOOLS
from core.arrays import Bools
from core.document.document import Document
from core.document.overlay_settings import Cloth
from core.imaging import color
from core.imaging.images import Image
from tests.app.driver import EditorDriver, picture
from tests.core.overlay.overlay_scenes import make_scene, motif

TABLE = ActionTable(TOOLS)
SCENE = make_scene(motif(), size=(130, 150))
PHOTO = Image(color.quantise(SCENE.photo.astype(np.float32), np.uint8))
TEXTURE = picture(80, 60)


class OverlayDriver(EditorDriver):
    def __init__(self, start: Document) -> None:
        super().__init__(start)
        self.editor.choose_mode("overlay")
        self.frame()

    def run(self, name: str) -> "OverlayDriver":
        assert TABLE.run(name, self.editor)
        self.frame()
        return self

    @property
    def cloth(self) -> Cloth:
        return self.document.cloth


def cloth_on_a_table() -> tuple[Image, Bools]:
    """Return a photo of cloth on something plain, and where (H, W) it is."""
    inside = np.zeros((190, 220), bool)
    inside[30:160, 35:185] = True
    photo = np.random.default_rng(2).normal((60, 75, 90), 3, (190, 220, 3))
    photo[inside] = PHOTO.pixels.reshape(-1, 3)
    return Image(np.clip(photo, 0, 255).astype(np.uint8)), inside
