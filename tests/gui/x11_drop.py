"""Drops files on a window of an X11 display as a file manager does: the source's side of XDND, by libX11 alone."""

import ctypes
from collections.abc import Sequence
from ctypes import POINTER, Structure, byref, c_char_p, c_int, c_long, c_ulong, c_void_p
from pathlib import Path

CLIENT_MESSAGE, SELECTION_REQUEST, SELECTION_NOTIFY = 33, 30, 31
VERSION = 5


class ClientMessage(Structure):
    """XClientMessageEvent."""

    _fields_ = (
        ("type", c_int),
        ("serial", c_ulong),
        ("send_event", c_int),
        ("display", c_void_p),
        ("window", c_ulong),
        ("message_type", c_ulong),
        ("format", c_int),
        ("data", c_long * 5),
    )


class SelectionRequest(Structure):
    """XSelectionRequestEvent; the answer, XSelectionEvent, has the same without `owner`."""

    _fields_ = (
        ("type", c_int),
        ("serial", c_ulong),
        ("send_event", c_int),
        ("display", c_void_p),
        ("owner", c_ulong),
        ("requestor", c_ulong),
        ("selection", c_ulong),
        ("target", c_ulong),
        ("property", c_ulong),
        ("time", c_ulong),
    )


class Selection(Structure):
    """XSelectionEvent."""

    _fields_ = (
        ("type", c_int),
        ("serial", c_ulong),
        ("send_event", c_int),
        ("display", c_void_p),
        ("requestor", c_ulong),
        ("selection", c_ulong),
        ("target", c_ulong),
        ("property", c_ulong),
        ("time", c_ulong),
    )


class Event(ctypes.Union):
    """XEvent."""

    _fields_ = (
        ("type", c_int),
        ("message", ClientMessage),
        ("request", SelectionRequest),
        ("selection", Selection),
        ("pad", c_long * 24),
    )


class Source:
    """A client of its own that offers files; for one thread at a time."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self.text = "".join(f"{path.resolve().as_uri()}\r\n" for path in paths).encode()
        self.x = x = ctypes.CDLL("libX11.so.6")
        x.XOpenDisplay.restype, x.XOpenDisplay.argtypes = c_void_p, [c_char_p]
        x.XDefaultRootWindow.restype, x.XDefaultRootWindow.argtypes = c_ulong, [c_void_p]
        x.XCreateSimpleWindow.restype = c_ulong
        x.XCreateSimpleWindow.argtypes = [c_void_p, c_ulong, *[c_int] * 4, *[c_ulong] * 3]
        x.XInternAtom.restype, x.XInternAtom.argtypes = c_ulong, [c_void_p, c_char_p, c_int]
        x.XSetSelectionOwner.argtypes = [c_void_p, c_ulong, c_ulong, c_ulong]
        x.XSendEvent.argtypes = [c_void_p, c_ulong, c_int, c_long, POINTER(Event)]
        x.XNextEvent.argtypes = [c_void_p, POINTER(Event)]
        x.XChangeProperty.argtypes = [c_void_p, c_ulong, c_ulong, c_ulong, c_int, c_int, c_char_p, c_int]
        x.XFlush.argtypes = x.XCloseDisplay.argtypes = [c_void_p]
        self.display = x.XOpenDisplay(None)
        self.window = x.XCreateSimpleWindow(self.display, x.XDefaultRootWindow(self.display), 0, 0, 1, 1, 0, 0, 0)

    def atom(self, name: str) -> int:
        return int(self.x.XInternAtom(self.display, name.encode(), 0))

    def tell(self, target: int, name: str, *data: int) -> None:
        """Send a message of the protocol to the window `target`."""
        event = Event()
        event.message.type, event.message.window, event.message.format = CLIENT_MESSAGE, target, 32
        event.message.message_type = self.atom(name)
        event.message.data = (c_long * 5)(self.window, *data)
        self.x.XSendEvent(self.display, target, 0, 0, byref(event))
        self.x.XFlush(self.display)

    def heard(self, name: str) -> list[int]:
        """Wait for a message of the protocol, and hand over the files if they are asked for; return its data."""
        event = Event()
        while True:
            self.x.XNextEvent(self.display, byref(event))
            if event.type == SELECTION_REQUEST:
                self._hand_over(event.request)
            elif event.type == CLIENT_MESSAGE and event.message.message_type == self.atom(name):
                return list(event.message.data)

    def _hand_over(self, request: SelectionRequest) -> None:
        self.x.XChangeProperty(
            self.display, request.requestor, request.property, request.target, 8, 0, self.text, len(self.text)
        )
        answer = Event()
        answer.selection.type = SELECTION_NOTIFY
        for name in ("requestor", "selection", "target", "property", "time"):
            setattr(answer.selection, name, getattr(request, name))
        self.x.XSendEvent(self.display, request.requestor, 0, 0, byref(answer))
        self.x.XFlush(self.display)

    def drop(self, target: int, x: int, y: int) -> bool:
        """Drag the files over the window `target` to a place of the screen and let go; return whether it took them."""
        selection, uris, copy = (self.atom(name) for name in ("XdndSelection", "text/uri-list", "XdndActionCopy"))
        self.x.XSetSelectionOwner(self.display, selection, self.window, 0)
        self.tell(target, "XdndEnter", VERSION << 24, uris, 0, 0)
        self.tell(target, "XdndPosition", 0, x << 16 | y, 0, copy)
        accepted = bool(self.heard("XdndStatus")[1] & 1)
        self.tell(target, "XdndDrop", 0, 0, 0, 0)
        return accepted and self.heard("XdndFinished")[1] != 0

    def close(self) -> None:
        self.x.XCloseDisplay(self.display)
