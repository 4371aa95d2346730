"""Actions on the surface in space that the picture is laid on."""

from app.actions import Action, ActionGroup, in_warp
from app.editor.editor import Editor
from app.files import surface_files
from core.surfaces.shapes import SHAPES

_SURFACE = ActionGroup("surface", "Warp/Surface in space", in_warp)


def _shape(name: str) -> Action:
    return _SURFACE.action(
        name,
        name.capitalize(),
        lambda editor: surface_files.choose_shape(editor, name),
        "cube",
        f"Lay the picture on a {name}: features come out undistorted on it",
        checked=lambda editor: editor.document.surface is not None and editor.document.surface.name == name,
    )


def _has_surface(editor: Editor) -> bool:
    return in_warp(editor) and editor.document.surface is not None


SURFACES = (
    *(_shape(name) for name in SHAPES),
    _SURFACE.action(
        "open",
        "Mesh…",
        surface_files.ask_open_mesh,
        "folder-open",
        "Lay the picture on a mesh with texture coordinates: OBJ or glTF",
    ),
    _SURFACE.action(
        "export_view",
        "Export view…",
        surface_files.ask_export_view,
        "camera",
        "Write a picture of the surface as it is seen; Export writes its texture",
        enabled=_has_surface,
        separated=True,
    ),
    _SURFACE.removal("remove", "Lay flat", "trash-can", "Take the picture off the surface", {"surface": None}),
)
