"""Running gestures: generators that get events until they return."""

from collections.abc import Generator
from typing import TypeAlias

from app.model.events import Event

Gesture: TypeAlias = Generator[None, Event, None]


def resume(gesture: Gesture | None, event: Event) -> Gesture:
    """Go on as `gesture`, which has not begun yet and gets `event` first."""
    if gesture is None:
        return
    try:
        next(gesture)
        while True:
            gesture.send(event)
            event = yield
    except StopIteration:
        return
    finally:
        gesture.close()


class Running:
    """The gesture in progress, if there is one."""

    def __init__(self) -> None:
        self._gesture: Gesture | None = None

    def __bool__(self) -> bool:
        return self._gesture is not None

    def begin(self, gesture: Gesture | None) -> None:
        """Run `gesture` to its first wait; one that ends there, or None, leaves nothing in progress."""
        self._step(gesture, None)

    def send(self, event: Event) -> None:
        """Hand `event` to the gesture."""
        self._step(self._gesture, event)

    def close(self) -> bool:
        """End the gesture where it waits, so that its groups roll back; say whether there was one."""
        gesture, self._gesture = self._gesture, None
        if gesture is None:
            return False
        gesture.close()
        return True

    def _step(self, gesture: Gesture | None, event: Event | None) -> None:
        """Let the gesture go on; it is in progress again only if it waits once more."""
        self._gesture = None
        if gesture is None:
            return
        try:
            next(gesture) if event is None else gesture.send(event)
        except StopIteration:
            return
        self._gesture = gesture
