"""Draw the pictures of the user's guide from the running program: `make pictures`. Needs a display, or xvfb-run."""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from imgui_bundle import hello_imgui, imgui

from app.actions import overlay
from app.editor.editor import Editor
from app.marking.applying import select as select_area
from app.marking.feature_list import merge
from app.marking.keying import select_keys
from app.model.jobs import Jobs
from app.model.orbit import Orbit
from app.model.session import Brush
from app.model.spaces import screen_from_canvas
from app.tools.all import TOOLS
from app.tours.samples import overlay_sample, retexture_sample, warp_sample
from assets import asset
from core.document.document import Document, Pin
from core.document.keys import KeyFrame
from core.imaging.images import Image, load, save
from core.selection.shapes import ellipse_outline, fill_polygon
from docs.make_pictures import THUMBNAIL_FRAMES, shrunk
from tests.gui.window_driver import WindowDriver, drive

PICTURES = Path(__file__).parent / "guide" / "pictures"
WIDTH_PX, QUALITY = 960, 82
SIZE = 1280, 800
Deed = Callable[[WindowDriver], None]


def main() -> None:
    """Draw them all."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    plain = Document.of(warp_sample().image)
    arched = warp_sample().with_warp(preset="arch", bend=50.0)
    show("warp", arched, settle)
    show("brush", arched, paint)
    show("selecting", plain, select)
    show("features", warp_sample(), list_features)
    show("resize", plain, resize)
    show("space", warp_sample(), lay_on_sphere)
    show("pins", warp_sample().changed(pins=(Pin((0.32, 0.42), (0.32, 0.42)), Pin((0.75, 0.4), (0.8, 0.3)))), pin)
    show("animate", warp_sample(), animate)
    show("seeing", warp_sample().with_warp(preset="twist", bend=40.0), heat)
    show("split", arched, split)
    show("retexture", retexture_sample(), regrow)
    show("overlay", overlay_sample(), dress)


def show(name: str, document: Document, deed: Deed) -> None:
    """Open a document in the window, do something there, and keep a picture of the window."""
    editor = Editor(document, TOOLS, jobs=Jobs())

    def script(window: WindowDriver) -> None:
        window.wait(THUMBNAIL_FRAMES // 3)
        deed(window)
        with tempfile.TemporaryDirectory() as folder:
            pixels = window.screenshot(Path(folder) / "window.png")
        save(shrunk(Image(pixels.copy()), WIDTH_PX), PICTURES / f"{name}.jpg", quality=QUALITY)

    drive(editor, script, size=SIZE)


def settle(window: WindowDriver) -> None:
    """Wait for the answer at rest."""
    window.wait(3).wait_until(lambda: window.editor.live.is_settled).wait(5)


def place(window: WindowDriver, x: float, y: float) -> tuple[float, float]:
    """Return where a place of the picture, as shares of its sides, is on the canvas while nothing is warped."""
    pixel = np.multiply((x, y), window.editor.document.size_px)
    there = screen_from_canvas(window.editor.session.view, pixel)
    return float(there[0]), float(there[1])


def animate(window: WindowDriver) -> None:
    """Show a flag in the wind, and a balloon that rises, between two of their keys."""
    editor = window.editor
    ways = {"bend": [(1, -30.0), (50, 45.0), (100, -30.0)], "waves": [(1, 1.0), (100, 1.6)]}
    tracks = {name: tuple(KeyFrame(frame, (value,), "ease") for frame, value in way) for name, way in ways.items()}
    rising = Pin(
        (0.51, 0.46), (0.52, 0.5), keys=(KeyFrame(10, (0.52, 0.5), "ease-in"), KeyFrame(80, (0.62, 0.2), "hold"))
    )
    still = Pin((0.5, 0.9), (0.5, 0.9))
    flag = editor.document.with_warp(preset="flag").changed(pins=(rising, still), tracks=tracks)
    editor.show(timeline=True)
    editor.choose_tool("pins")
    editor.animation.edit("Flag", flag)
    editor.animation.go_to(64)
    select_keys(editor, [("bend", 50)])
    settle(window)
    window.shell.workspace.table.run("view.fit", editor)
    settle(window)


def paint(window: WindowDriver) -> None:
    """Show a cloud that is painted, on the picture as it was."""
    editor = window.editor
    window.key(imgui.Key.h).key(imgui.Key.b).wait(3)
    editor.show(brush=Brush(diameter_px=70.0))
    size = editor.document.size_px
    cloud = ellipse_outline(np.multiply((0.42, 0.07), size), np.multiply((0.52, 0.155), size))
    select_area(editor, "cloud", fill_polygon(size, cloud), "add")
    settle(window)
    window.move(*place(window, 0.5, 0.12)).wait(4)


def select(window: WindowDriver) -> None:
    """Select a balloon by the lasso along edges, and the sun by the wand."""
    editor = window.editor
    window.key(imgui.Key.w).wait(2).click(*place(window, 0.45, 0.63))
    window.wait_until(lambda: editor.jobs.is_idle).key(imgui.Key.a).wait(2)
    for x, y in ((0.25, 0.175), (0.305, 0.2), (0.338, 0.27), (0.345, 0.34), (0.31, 0.46), (0.27, 0.555)):
        window.click(*place(window, x, y)).wait(40)
    window.move(*place(window, 0.235, 0.55)).wait(4)


def list_features(window: WindowDriver) -> None:
    """Name two features, and light one up."""
    editor = window.editor
    hello_imgui.get_runner_params().docking_params.focus_dockable_window("Features")
    window.wait(4)
    merge(editor, "Name feature", frozenset({1}), name="Red balloon")
    window.wait(4)
    merge(editor, "Name feature", frozenset({256}), name="Green balloon")
    window.wait(4).context.mouse_move("//Features/**/feature 2/##row")
    window.wait(5)


def resize(window: WindowDriver) -> None:
    """Make the picture square, and let it be proposed what to keep."""
    window.item("//Warp/Resize##page").wait(2).item("//Warp/1:1").wait(3)
    window.wait_until(lambda: window.editor.jobs.is_idle)
    settle(window)
    window.shell.workspace.table.run("view.fit", window.editor)


def lay_on_sphere(window: WindowDriver) -> None:
    """Lay the picture on a sphere."""
    editor = window.editor
    window.item("//Warp/In space##page").wait(2).item("//Warp/Sphere##shapes0")
    window.wait_until(lambda: editor.document.surface is not None)
    settle(window)
    editor.show(orbit=Orbit(turn_deg=10.0, tilt_deg=25.0))
    window.shell.workspace.table.run("view.fit", editor)


def pin(window: WindowDriver) -> None:
    """Show pins."""
    window.key(imgui.Key.p)
    window.editor.show(selected=frozenset({1}))
    settle(window)


def heat(window: WindowDriver) -> None:
    """Show the heat map of scale."""
    window.key(imgui.Key.h)
    window.shell.workspace.table.run("view.overlay.mask", window.editor)
    window.shell.workspace.table.run("view.overlay.scale", window.editor)
    settle(window)


def split(window: WindowDriver) -> None:
    """Show before and after side by side."""
    window.shell.workspace.table.run("view.split", window.editor)
    settle(window)


def regrow(window: WindowDriver) -> None:
    """Move the curves of the tail and wait until the fur is regrown."""
    editor = window.editor
    editor.choose_tool("feature-curves")
    moved = [pair for pair in editor.document.feature_curves if not pair.passive]
    target = moved[0].source + np.linspace(0, 1, len(moved[0].source))[:, None] * (0.05, -0.08)
    curves = tuple(
        pair.__class__(pair.source, target, pair.closed, pair.passive) if pair is moved[0] else pair
        for pair in editor.document.feature_curves
    )
    editor.edit("Move curve", editor.document.changed(feature_curves=curves))
    editor.show(look="retextured")
    window.wait(5).wait_until(lambda: editor.regrowth.is_final, frames=20000).wait(10)


def dress(window: WindowDriver) -> None:
    """Find the pattern and lay a picture on the cloth."""
    editor = window.editor
    overlay.find(editor)
    window.wait(5).wait_until(lambda: editor.overlay.is_final, frames=20000)
    editor.edit("Texture", editor.document.with_cloth(texture=load(asset("balloons.png")), texture_name="balloons.png"))
    overlay.show(editor, "result")
    window.wait(20)


if __name__ == "__main__":
    main()
