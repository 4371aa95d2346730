"""The steps of the tours: what is to be done, and how it is told that it was."""

from collections.abc import Callable
from dataclasses import dataclass

from app.editor.editor import Editor
from core.document.document import Document, Mode
from core.document.retexture import moves

Done = Callable[[Editor, Document, str | None], bool]
"""Whether a step is done: by the editor, the document when the step began, and the title of the open dialog."""


@dataclass(frozen=True)
class Step:
    """One thing to do."""

    text: str
    done: Done


def _bent_otherwise(editor: Editor, start: Document, dialog: str | None) -> bool:
    return not editor.is_busy and editor.document.warp.bend != start.warp.bend


def _exports(editor: Editor, start: Document, dialog: str | None) -> bool:
    return dialog == "Export picture"


EXPORT = Step("Press Ctrl+E: that writes the picture to a file. Esc leaves the dialog.", _exports)

TOURS: dict[Mode, tuple[Step, ...]] = {
    "warp": (
        Step(
            "The balloons are painted: they keep their shape. Press Arch, among the pictures at the right.",
            lambda editor, start, dialog: editor.document.warp.preset == "arch",
        ),
        Step(
            "Hold the key \\ to see the picture before, and let it go.",
            lambda editor, start, dialog: editor.session.compare == "before",
        ),
        Step("Drag the Bend slider: everything bends but the balloons.", _bent_otherwise),
        Step(
            "Press B and paint over something else: what is painted keeps its shape, too.",
            lambda editor, start, dialog: not editor.is_busy and editor.document.mask is not start.mask,
        ),
        Step(
            "Press P, click on the picture to set a pin, and drag it.",
            lambda editor, start, dialog: not editor.is_busy and any(p.at != p.to for p in editor.document.pins),
        ),
        EXPORT,
    ),
    "retexture": (
        Step(
            "Curves lie along the tail. Press C and click on one of them.",
            lambda editor, start, dialog: editor.session.selected_curve is not None,
        ),
        Step(
            "Drag the curve, or one of its points, to where the tail is to go, and let go.",
            lambda editor, start, dialog: not editor.is_busy and moves(editor.document),
        ),
        Step(
            "The fur is regrown along the curve. Wait a moment.",
            lambda editor, start, dialog: editor.regrowth.is_final and editor.regrowth.stage is not None,
        ),
        Step(
            "Press 2: so it would look merely stretched.", lambda editor, _, dialog: editor.session.look == "deformed"
        ),
        Step("Press 3: and so it looks regrown.", lambda editor, _, dialog: editor.session.look == "retextured"),
        EXPORT,
    ),
    "overlay": (
        Step(
            "This cloth has a pattern that repeats. Press Find pattern, at the right.",
            lambda editor, start, dialog: editor.document.cloth.search is not None,
        ),
        Step(
            "Its lattice is being found. Wait until it is there.",
            lambda editor, start, dialog: editor.overlay.layers is not None and editor.overlay.is_final,
        ),
        Step(
            "Press Choose texture, at the right, or drop a picture on the window: it is laid on the cloth.",
            lambda editor, start, dialog: editor.document.cloth.texture is not None,
        ),
        Step(
            "Drag it on the cloth to where it belongs.",
            lambda editor, start, dialog: not editor.is_busy and editor.document.cloth.laying != start.cloth.laying,
        ),
        Step("Press 5: that is the light on the cloth.", lambda editor, _, dialog: editor.session.shown == "shading"),
        Step("Press 1: and that is the result.", lambda editor, _, dialog: editor.session.shown == "result"),
    ),
}
