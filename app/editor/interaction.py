"""What the artist's hand is doing: a tool's gesture, the view moved meanwhile, or a slider that is held.

Events come in; the tool in hand, or the gesture that it began, gets them.
"""

from collections.abc import Callable, Generator, Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

from app.editor.tool import Tool
from app.model.events import Event, Finish, Key, KeyUp, Modifiers, Move, Press, Release, Wheel
from app.model.gestures import Running
from app.model.pointer_keys import PAN, translate
from app.model.spaces import zoom_at

if TYPE_CHECKING:
    from app.editor.editor import Editor

Group: TypeAlias = Callable[[str], AbstractContextManager[None]]

WHEEL_ZOOM = 1.2
"""Zoom factor of one notch of the wheel."""
GESTURE_KEYS = frozenset(("enter", "backspace", "delete"))
"""Keys that a gesture in progress gets; the others act as ever."""


class Interaction:
    """The gesture, the navigation and the held slider in progress, of which there is one each at most."""

    def __init__(self, editor: "Editor", tools: Mapping[str, Tool]) -> None:
        self._editor = editor
        self._tools = tools
        self._gesture = Running()
        self._gesture_tool = ""
        self._navigation = Running()
        self._spring: str | None = None
        self._slide: Generator[None, None, None] | None = None
        self._slide_label = ""

    def __bool__(self) -> bool:
        return self.has_gesture or self._slide is not None

    @property
    def has_gesture(self) -> bool:
        """Whether a tool's gesture is in progress."""
        return bool(self._gesture)

    @property
    def tool(self) -> Tool:
        """The tool in hand: the spring-loaded one while its key is held, else the chosen one."""
        return self._tools[self._spring or self._editor.session.tool]

    @property
    def state(self) -> str:
        """Tool and whether a gesture is in progress: "pins.idle", "pins.busy"."""
        return f"{self._gesture_tool}.busy" if self._gesture else f"{self.tool.name}.idle"

    def hold_slider(self, label: str, group: Group) -> None:
        """Hold a group open for a slider, unless the same slider holds one already; end what else is in progress."""
        if self._slide is None or self._slide_label != label:
            self.finish()
            self._slide, self._slide_label = _hold_back(label, group), label
            next(self._slide)

    def finish(self) -> None:
        """End the gesture or the held slider and keep what it did."""
        if self._slide is not None:
            slide, self._slide = self._slide, None
            next(slide, None)
        self._gesture.send(Finish())
        self._gesture.close()

    def cancel(self) -> bool:
        """End the gesture or the held slider without a trace; say whether there was one."""
        slide, self._slide = self._slide, None
        if slide is not None:
            slide.close()
        return self._gesture.close() or slide is not None

    def handle(self, event: Event) -> bool:
        """Let the tools act on `event`; return whether they did."""
        match event:
            case Press():
                return self._press(event)
            case Move() | Release():
                return self._drag(event)
            case Wheel():
                view = self._editor.session.view
                self._editor.show(view=zoom_at(view, WHEEL_ZOOM**event.notches, event.pos))
                return True
            case Key():
                return self._key(event)
            case KeyUp():
                return self._let_go(event)
        return False

    def _let_go(self, key: KeyUp) -> bool:
        springs = self._spring is not None and key.name == self._editor.preferences.pointer_keys[PAN].lower()
        if springs:
            self._spring = None
        return springs

    def _press(self, press: Press) -> bool:
        in_hand = self._gesture_tool if self._gesture else self.tool.name
        press = replace(press, mods=translate(press.mods, in_hand, self._editor.preferences.pointer_keys))
        if press.button == "left":
            self._editor.animation.let_go()
        if press.button == "middle":
            self._navigation.begin(self._tools["hand"].press(self._editor, press))
        elif self._spring is not None and press.button == "left":
            self._navigation.begin(self._tools[self._spring].press(self._editor, press))
        elif self._gesture:
            self._gesture.send(press)
        else:
            if self._slide is not None:
                self.finish()
            if self.tool.marks and press.button == "left" and (self.tool.group or not press.mods.alt):
                self._editor.unwarped.show_at(press.pos)
            self._gesture_tool = self.tool.name
            self._gesture.begin(self.tool.press(self._editor, press))
        return True

    def _drag(self, event: Move | Release) -> bool:
        self._editor.show(pointer=event.pos)
        if self._navigation:
            self._navigation.send(event)
        elif self._gesture:
            mods = translate(event.mods, self._gesture_tool, self._editor.preferences.pointer_keys)
            self._gesture.send(replace(event, mods=mods))
        else:
            self._editor.show(hover=self.tool.hover(self._editor, event.pos))
        return True

    def _key(self, key: Key) -> bool:
        if key.name == "escape" and self.cancel():
            return True
        if key.name == self._editor.preferences.pointer_keys[PAN].lower() and key.mods == Modifiers():
            self._spring = "hand"
            return True
        if self._gesture and key.name in GESTURE_KEYS and not key.mods.ctrl:
            self._gesture.send(key)
            return True
        return self.tool.take_key(self._editor, key)


def _hold_back(label: str, group: Group) -> Generator[None, None, None]:
    with group(label):
        yield
