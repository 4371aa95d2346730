"""Frames in which nothing moves cost no work on arrays."""

from collections.abc import Callable
from typing import Any

import pytest

from app.editor.editor import Editor
from app.render.passes.mesh import MeshBuffers as DrawnMesh
from app.render.scene import CanvasScene
from app.ui.canvas.scene import Motion
from core.mesh import Mesh
from core.rasters.raster import Raster
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui
WORK: tuple[tuple[type, str], ...] = (
    (Mesh, "image_from_canvas"),
    (DrawnMesh, "place"),
    (CanvasScene, "in_framebuffer"),
    (CanvasScene, "bounds"),
    (Motion, "_take"),
    (Raster, "_distinct"),
)


def test_a_window_at_rest_does_none(editor: Editor, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[str] = []

    def count(owner: type, name: str) -> None:
        work: Callable[..., Any] = getattr(owner, name)

        def counting(*arguments: Any, **named: Any) -> Any:
            calls.append(name)
            return work(*arguments, **named)

        monkeypatch.setattr(owner, name, counting)

    def script(window: WindowDriver) -> None:
        for owner, name in WORK:
            count(owner, name)
        editor.choose_tool("brush")
        window.drag((400, 200), (440, 200))
        editor.choose_tool("pins")
        window.drag((300, 300), (340, 300))
        window.wait_until(lambda: editor.live.is_settled and editor.jobs.is_idle and window.shell.is_drawn)
        window.wait(30)  # the small pictures are drawn when nothing else is
        assert set(calls) >= {name for _, name in WORK}
        calls.clear()
        window.wait(20)
        assert calls == []
        window.move(320, 310).wait(2)
        assert calls == ["image_from_canvas"]

    drive(editor, script)
