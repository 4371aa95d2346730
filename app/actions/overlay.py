"""Actions of Overlay mode: finding the pattern, laying a texture, and what is shown and saved of it."""

from collections.abc import Callable
from pathlib import Path

from app.actions import Action, ActionGroup
from app.editor.editor import Editor
from app.files import document_io
from app.model.requests import PICTURES, OpenFile
from app.model.session import PaintedOnCloth, Session, Shown
from core.document.document import Document
from core.document.finding_again import find_again, find_whole_cloth
from core.document.overlay_settings import Cloth, Search
from core.document.parts import Part, picture_of
from core.files.text import legible
from core.imaging.images import Image, load, save
from core.progress import Job, in_one_step

PHOTO_TOOLS = frozenset(("lattice", "texel", "region", "brush"))
"""Tools that work on the photo, and so show it in place of the result, but for the brush where that paints on it."""
PART_FILES = ("png", "tif", "tiff", "exr")


def in_mode(editor: Editor) -> bool:
    """Return whether the artist works in Overlay mode."""
    return editor.session.mode == "overlay"


def has_layers(editor: Editor) -> bool:
    """Return whether a pattern was found."""
    return in_mode(editor) and editor.overlay.layers is not None


def show(editor: Editor, shown: Shown) -> None:
    """Show the result or a part of what was found; a tool that works on the photo is put away for the result."""
    if shown == "result" and in_mode(editor) and works_on_photo(editor.session):
        editor.choose_tool("drape")
    editor.show(shown=shown, compare="result")


def seen(editor: Editor) -> Shown:
    """Return what is on the canvas: the photo where the tool in hand works on it, though the result is chosen."""
    shown = editor.session.shown
    return "photo" if shown == "result" and has_layers(editor) and works_on_photo(editor.session) else shown


def works_on_photo(session: Session) -> bool:
    """Return whether the tool in hand works on the photo, and not on the result."""
    return session.tool in PHOTO_TOOLS and not (session.tool == "brush" and session.painted_on_cloth != "region")


def find(editor: Editor) -> None:
    """Find the pattern in the painted region, anew where it was sought before; what was mended by hand stays so."""
    editor.finish()
    document, cloth = editor.document, editor.document.cloth
    search = Search(cloth.region, seed=cloth.seed)
    show(editor, "result")
    if cloth.search is not None and cloth.search.mending is not None:
        _take_search(editor, "Find pattern", lambda: find_again(document, search))
    else:
        editor.edit("Find pattern", document.with_cloth(search=search))


def take_whole(editor: Editor) -> None:
    """Let the lattice go on over all of the cloth on which it was found, where that explains no less."""
    editor.finish()
    document = editor.document
    _take_search(editor, "Whole cloth", lambda: find_whole_cloth(document))


def can_take_whole(editor: Editor) -> bool:
    """Return whether there is a find to follow on, or nothing is found or painted and what stands out can be taken."""
    if editor.overlay.is_running:
        return False
    if has_layers(editor):
        return editor.overlay.is_final
    region = editor.document.cloth.region
    return in_mode(editor) and (region is None or region.is_empty)


def _take_search(editor: Editor, name: str, steps: Callable[[], Job[Cloth]]) -> None:
    """Make the search that a job returns the document's, and its region what is painted, unless others are by then."""
    image, cloth = editor.document.image, editor.document.cloth

    def apply(document: Document, found: Cloth) -> Document | None:
        if document.image is not image or document.cloth.search is not cloth.search:
            return None
        is_painted = document.cloth.region is not cloth.region
        return document.with_cloth(region=document.cloth.region if is_painted else found.region, search=found.search)

    editor.overlay.watch(editor.start(name, steps, apply))


def go_on(editor: Editor) -> None:
    """Look on from the lattice as it is."""
    editor.finish()
    editor.overlay.go_on()


def forget(editor: Editor) -> None:
    """Go back to the photo as it is."""
    editor.edit("Forget pattern", editor.document.with_cloth(search=None))


def ask_texture(editor: Editor) -> None:
    """Ask for a picture to lay on the cloth."""
    editor.requests.append(OpenFile("Choose a texture", PICTURES, lambda path: lay(editor, path)))


def lay(editor: Editor, path: Path) -> None:
    """Lay a picture on the cloth; it does not wait for a search that is under way."""

    def laid(document: Document, image: Image) -> Document:
        show(editor, "result")
        return document.with_cloth(texture=image, texture_name=legible(path.name))

    editor.start(f"Texture {legible(path.name)}", lambda: in_one_step("reading", load, path), laid, beside=True)


def old_pattern(editor: Editor) -> None:
    """Take the new texture off."""
    editor.edit("Old pattern", editor.document.with_cloth(texture=None, texture_name=""))


def paint(editor: Editor, name: PaintedOnCloth) -> None:
    """Take the brush for the region of cloth, or for what of it stays as it is or is covered by hand."""
    editor.show(painted_on_cloth=name)
    editor.choose_tool("brush")


def save_texel(editor: Editor) -> None:
    """Ask where to save the texel as a tile."""
    layers = editor.overlay.layers
    if layers is not None:
        pattern = layers.pattern
        _ask_save(editor, "texel", "Save texel as tile", lambda path: pattern)


def export_part(editor: Editor, part: Part) -> None:
    """Ask where to export a part of what was found; 16 bits a sample, or its values themselves as floats."""
    layers, photo = editor.overlay.layers, editor.document.image
    if layers is None:
        return
    _ask_save(
        editor,
        part,
        f"Export {part}",
        lambda path: picture_of(layers, photo, part, bits=32 if path.suffix.lower() == ".exr" else 16),
    )


def _ask_save(editor: Editor, name: str, title: str, make: Callable[[Path], Image]) -> None:
    writing = lambda path: in_one_step("writing", lambda: save(make(path), path))  # noqa: E731
    document_io.ask_save_beside(editor, title, PART_FILES, f"{name}.png", writing)


_OVERLAY = ActionGroup("overlay", "Overlay", in_mode)
_SHOWN_MENU = ActionGroup("shown", "View/Overlay", has_layers)
_PART_MENU = ActionGroup("overlay", "Overlay/Export part", has_layers)

_SHOWN: tuple[tuple[Shown, str, str, str], ...] = (
    ("result", "Result", "shirt", "The photo with the texture in its folds"),
    ("photo", "Photo", "image", "The photo with the lattice of the pattern"),
    ("pattern", "Pattern", "table-cells", "The pattern without folds and light"),
    ("mesh", "Mesh", "border-all", "Where the pattern's repeats lie"),
    ("shading", "Shading", "circle-half-stroke", "Light and shade, without the pattern; the middle is middle grey"),
    ("detail", "Detail", "magnifying-glass", "What neither pattern nor shading explain, on middle grey"),
    ("reconstruction", "Reconstruction", "layer-group", "Pattern and shading without the detail"),
    ("residual", "Residual", "triangle-exclamation", "The size of the detail, fourfold"),
)


def _show(number: int, shown: Shown, label: str, icon: str, tooltip: str) -> Action:
    return _SHOWN_MENU.action(
        shown,
        label,
        lambda editor: show(editor, shown),
        icon,
        tooltip,
        str(number),
        enabled=in_mode if shown in ("result", "photo") else has_layers,
        checked=lambda editor: seen(editor) == shown,
    )


def _paint(name: PaintedOnCloth, label: str, icon: str, tooltip: str) -> Action:
    return _OVERLAY.action(
        f"paint_{name}",
        f"Paint {label}",
        lambda editor: paint(editor, name),
        icon,
        tooltip,
        checked=lambda editor: editor.session.tool == "brush" and editor.session.painted_on_cloth == name,
        separated=name == "region",
    )


def _clear(name: PaintedOnCloth, label: str, tooltip: str) -> Action:
    return _OVERLAY.action(
        f"clear_{name}",
        f"Clear {label}",
        lambda editor: editor.edit(f"Clear {label}", editor.document.with_cloth(**{name: None})),
        "eraser",
        tooltip,
        enabled=lambda editor: in_mode(editor) and getattr(editor.document.cloth, name) is not None,
    )


def _export(part: Part) -> Action:
    return _PART_MENU.action(
        f"export_{part}",
        f"{part.capitalize()}…",
        lambda editor: export_part(editor, part),
        "file-export",
        "PNG and TIFF have 16 bits, EXR the values themselves",
    )


_PARTS: tuple[Part, ...] = ("pattern", "mesh", "shading", "detail", "reconstruction", "residual")

OVERLAY = (
    *(_show(number, *row) for number, row in enumerate(_SHOWN, start=1)),
    _OVERLAY.action(
        "find",
        "Find pattern",
        find,
        "magnifying-glass-plus",
        "Find what repeats on the cloth, in the painted region or everywhere",
        "Ctrl+R",
    ),
    _OVERLAY.action(
        "go_on",
        "Go on",
        go_on,
        "play",
        "Take up the search that was stopped, from the mended lattice or the marked texel if there is one",
        enabled=lambda editor: in_mode(editor) and editor.overlay.is_stopped,
    ),
    _OVERLAY.action(
        "whole",
        "Whole cloth",
        take_whole,
        "wand-magic-sparkles",
        "Take in all of the cloth on which the pattern was found, as far as its colours tell; "
        "where none is found and nothing painted, look for it on what stands out",
        "Ctrl+Shift+R",
        enabled=can_take_whole,
    ),
    _OVERLAY.action(
        "forget",
        "Forget pattern",
        forget,
        "trash-can",
        "Go back to the photo as it is",
        enabled=lambda editor: in_mode(editor) and editor.document.cloth.search is not None,
    ),
    _OVERLAY.action(
        "texture",
        "Choose texture…",
        ask_texture,
        "image",
        "Lay a picture into the folds; or drop a file on the window",
        separated=True,
    ),
    _OVERLAY.action(
        "old_pattern",
        "Show old pattern",
        old_pattern,
        "rotate-left",
        "Take the new texture off",
        enabled=lambda editor: in_mode(editor) and editor.document.cloth.texture is not None,
    ),
    _paint("region", "region", "draw-polygon", "Paint where the cloth is: the texture is laid there, and nowhere else"),
    _paint("protected", "protection", "shield-halved", "Paint what stays as it is: buttons, a label, a collar"),
    _paint(
        "covered", "cover", "paint-roller", "Paint what was left out: the texture goes on over it, whatever is there"
    ),
    _clear("protected", "protection", "Protect nothing"),
    _clear("covered", "cover", "Cover only what was found"),
    _clear("region", "region", "Look for the pattern everywhere"),
    _OVERLAY.action(
        "save_texel",
        "Save texel as tile…",
        save_texel,
        "floppy-disk",
        "Write one repeat of the old pattern, without folds and light, as a seamless tile",
        enabled=has_layers,
        separated=True,
    ),
    *(_export(part) for part in _PARTS),
)
