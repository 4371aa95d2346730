"""Offers unsaved work of earlier runs to the artist, and opens what is chosen."""

from app.editor.editor import Editor
from app.files.document_io import guard
from app.model.requests import AskRecover, Offer
from app.state.rescues import Rescue, discard
from core.document.document import Document
from core.document.project import load_project
from core.files.text import legible
from core.progress import in_one_step


def offer_rescues(editor: Editor) -> None:
    """Offer what earlier runs left unsaved; at the start."""
    rescues = [] if editor.recovery is None else editor.recovery.found()
    if not rescues:
        return

    def answered(chosen: int | None) -> None:
        if chosen is not None:
            guard(editor, lambda: _recover(editor, rescues[chosen]))
        else:
            for drawer in {rescue.drawer for rescue in rescues}:
                discard(drawer)

    editor.requests.append(AskRecover(tuple(_offer(rescue) for rescue in rescues), answered))


def _offer(rescue: Rescue) -> Offer:
    """Return what the artist is to know of a rescue."""
    near = rescue.project or rescue.source
    folder = "" if near is None else legible(str(near.parent))
    return Offer(
        legible(rescue.name),
        folder,
        rescue.kept_at,
        earlier=rescue.generation > 0,
        picture=rescue.drawer.picture if rescue.drawer.picture.exists() else None,
    )


def _recover(editor: Editor, rescue: Rescue) -> None:
    """Open rescued work as work that is not saved; its files stay until it is."""

    def deliver(document: Document) -> None:
        editor.replace_document(document, project=rescue.project, source=rescue.source, saved=False)
        editor.choose_mode(document.mode)
        if rescue.project is not None:
            editor.on_disk.note(rescue.project)
        if editor.recovery is not None:
            editor.recovery.adopt(rescue, document)

    steps = lambda: in_one_step("reading", load_project, rescue.file)  # noqa: E731
    editor.background(f"Recover {legible(rescue.name)}", steps, deliver)
