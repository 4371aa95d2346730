"""Actions of Retexture mode: what is shown, the work itself and the masks."""

from app.actions import Action, ActionGroup
from app.editor.editor import Editor
from app.model.session import Before, Look, Painted
from core.document.retexture import moves


def in_mode(editor: Editor) -> bool:
    """Return whether the editor is in Retexture mode."""
    return editor.session.mode == "retexture"


def start(editor: Editor) -> None:
    """Regrow the texture, anew where it is there already."""
    editor.finish()
    editor.show(look="retextured")
    editor.regrowth.start(editor.document)


def toggle_edges(editor: Editor) -> None:
    """Switch whether long edges near moved curves are kept, all of them."""
    kept = not editor.document.retexture.long_edges
    changed = editor.document.with_retexture(long_edges=kept, left_out=())
    editor.edit("Keep long edges" if kept else "Keep no long edges", changed)


def paint(editor: Editor, name: Painted) -> None:
    """Take the brush for one of the masks; where texture is taken from is painted on the picture as it is."""
    editor.choose_tool("brush")
    editor.show(painted=name, look="original" if name == "source_mask" else "retextured")


def show_look(editor: Editor, look: Look) -> None:
    """Show the result in one of its looks, right of the divider where there is one."""
    compare = editor.session.compare
    editor.show(look=look, compare="split" if compare == "split" else "result")


_LOOK, _RETEXTURE = ActionGroup("look", "View/Retexture", in_mode), ActionGroup("retexture", "Retexture", in_mode)

_LOOKS: tuple[tuple[Look, str, str, str, str], ...] = (
    ("original", "Original", "1", "image", "The picture as it was"),
    ("deformed", "Deformed", "2", "water", "The picture stretched along with the curves"),
    ("retextured", "Retextured", "3", "brush", "The picture with its texture regrown"),
)


def _beside(look: Before, label: str, chord: str, icon: str) -> Action:
    def is_beside(editor: Editor) -> bool:
        return editor.session.compare == "split" and editor.session.look_before == look

    return _LOOK.action(
        f"beside.{look}",
        f"{label} at the left",
        lambda editor: editor.show(look_before=look, compare="result" if is_beside(editor) else "split"),
        icon,
        f"Show {label.lower()} at the left of a line, and what is looked at at the right; drag the line",
        chord,
        checked=is_beside,
    )


_PAINTED: tuple[tuple[Painted, str, str, str], ...] = (
    ("regrow", "more or less", "seedling", "Paint what is regrown, and with X what is not, whatever is found"),
    ("matte", "matte", "draw-polygon", "Paint where the result may differ from the plain deformation"),
    ("source_mask", "source mask", "eye-dropper", "Paint where texture may be taken from"),
)


def _mask(name: Painted, label: str, icon: str, tooltip: str) -> tuple[Action, ...]:
    return (
        _RETEXTURE.action(
            f"paint_{name}",
            f"Paint {label}",
            lambda editor: paint(editor, name),
            icon,
            tooltip,
            checked=lambda editor: editor.session.tool == "brush" and editor.session.painted == name,
            separated=name == "regrow",
        ),
        _RETEXTURE.removal(
            f"clear_{name}", f"Clear {label}", "eraser", "Nothing painted means everywhere", {name: None}
        ),
    )


RETEXTURE = (
    *(
        _LOOK.choice(look, label, show_look, lambda editor: editor.session.look, icon, tooltip, chord)
        for look, label, chord, icon, tooltip in _LOOKS
    ),
    _beside("original", "Original", "Shift+1", "image"),
    _beside("deformed", "Deformed", "Shift+2", "water"),
    _RETEXTURE.action(
        "start",
        "Retexture",
        start,
        "play",
        "Regrow the texture along the moved curves",
        "Ctrl+R",
        enabled=lambda editor: in_mode(editor) and moves(editor.document),
    ),
    _RETEXTURE.switch(
        "auto", "Retexture by itself", "auto_retexture", "bolt", "Regrow the texture as soon as a curve is let go"
    ),
    _RETEXTURE.action(
        "edges",
        "Keep long edges",
        toggle_edges,
        "grip-lines",
        "Rails and the like near the curve stay whole; Alt+click with the curve tool drops one of them",
        checked=lambda editor: editor.document.retexture.long_edges,
    ),
    *(action for row in _PAINTED for action in _mask(*row)),
)
