"""An editor in Overlay mode, a photo of cloth and a texture."""

import numpy as np

from app.actions.table import ActionTable
from app.tools.all import TOOLS
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
