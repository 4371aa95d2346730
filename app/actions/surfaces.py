"""Actions on the surface in space that the picture is laid on."""

from app.actions import Action
from app.actions.removal import removal
from app.editor.editor import Editor
from app.files import surface_files
from core.surfaces.shapes import SHAPES

MENU = "Warp/Surface in space"


def _in_warp(editor: Editor) -> bool:
    return editor.session.mode == "warp"


def _shape(name: str) -> Action:
    return Action(
        f"surface.{name}",
        name.capitalize(),
        MENU,
        lambda editor: surface_files.choose_shape(editor, name),
        icon="cube",
        tooltip=f"Lay the picture on a {name}: features come out undistorted on it",
        enabled=_in_warp,
        checked=lambda editor: editor.document.surface is not None and editor.document.surface.name == name,
    )


SURFACES = (
    *(_shape(name) for name in SHAPES),
    Action(
        "surface.open",
        "Mesh…",
        MENU,
        surface_files.ask_open_mesh,
        icon="folder-open",
        tooltip="Lay the picture on a mesh with texture coordinates: OBJ or glTF",
        enabled=_in_warp,
    ),
    Action(
        "surface.export_view",
        "Export view…",
        MENU,
        surface_files.ask_export_view,
        icon="camera",
        tooltip="Write a picture of the surface as it is seen; Export writes its texture",
        enabled=lambda editor: _in_warp(editor) and editor.document.surface is not None,
        separated=True,
    ),
    removal(
        "surface.remove", "Lay flat", MENU, "warp", "trash-can", "Take the picture off the surface", {"surface": None}
    ),
)
