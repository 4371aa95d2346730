"""Questions: what is to become of changes, of a project that somebody else wrote, of files that are being written."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from imgui_bundle import ImVec2, imgui

from app.model.requests import AskChanged, AskUnsaved, AskWriting
from app.ui.dialogs.modal import is_confirmed, within
from app.ui.widgets.controls import faint, move_right, plain_button, primary_button, tip
from app.ui.widgets.theme import em


@dataclass(frozen=True)
class Choice:
    """A button, and what it answers."""

    label: str
    answer: str
    width_em: float
    hint: str = ""


@dataclass(eq=False)
class QuestionDialog:
    """Draws the question and its answers: some at the left; at the right "Cancel" and the one that Enter gives."""

    title: str
    draw_text: Callable[[], None]
    width_em: float
    choices: Sequence[Choice]
    usual: Choice
    then: Callable[[Any], None]

    def draw(self) -> bool:
        """Draw the inside; return whether it stays open."""
        self.draw_text()
        imgui.dummy(ImVec2(within(self.width_em), em(0.4)))
        answer = self._draw_choices()
        if answer is not None:
            self.then(answer)
        return answer is None

    def _draw_choices(self) -> str | None:
        """Return what was answered."""
        for number, choice in enumerate(self.choices):
            if number:
                imgui.same_line()
            if plain_button(choice.label, choice.width_em):
                return choice.answer
            tip(choice.hint)
        move_right(7, self.usual.width_em)
        if plain_button("Cancel", 7) or imgui.is_key_pressed(imgui.Key.escape):
            return "cancel"
        imgui.same_line()
        pressed = primary_button(self.usual.label, self.usual.width_em) or is_confirmed()
        imgui.set_item_default_focus()  # Tab goes on from here
        return self.usual.answer if pressed else None


def question_about(request: AskUnsaved | AskChanged | AskWriting) -> QuestionDialog:
    """Return the dialog that asks."""

    def draw_text() -> None:
        match request:
            case AskUnsaved(name):
                imgui.text(f"{name} has changes that are not saved.")
                faint("They are lost unless you save them.")
            case AskChanged(name):
                imgui.text(f"{name} was written by another program, or another window.")
                faint("Nothing is saved yet. What is yours stays open here.")
            case AskWriting(names):
                imgui.text("Still being written:")
                for name in names:
                    imgui.bullet_text(name)

    overwrite = "Write over the other version; it is kept as a backup where that is switched on"
    reload = "Take in the other version and give up what is open here"
    match request:
        case AskUnsaved():
            choices, usual = [Choice("Don't save", "discard", 8)], Choice("Save", "save", 7)
            return QuestionDialog("Save changes?", draw_text, 26, choices, usual, request.then)
        case AskChanged():
            choices = [Choice("Overwrite", "overwrite", 7, overwrite), Choice("Reload", "reload", 7, reload)]
            usual = Choice("Save as …", "save_as", 7)
            return QuestionDialog("Changed on disk", draw_text, 34, choices, usual, request.then)
        case AskWriting():
            choices, usual = [Choice("Stop and quit", "stop", 8)], Choice("Finish and quit", "wait", 9)
            return QuestionDialog("Finish writing first?", draw_text, 30, choices, usual, request.then)
