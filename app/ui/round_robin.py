"""While the hand moves the picture, the panels around it are laid out in turn, one a frame.

To lay them all out takes longer than to solve the map of a frame, and little in them changes while a button is held.
Dear ImGui can keep a window as it was drawn ("skip refresh"), but fails where it is docked. So what is in a panel or
a bar is a child window, and that is kept.
"""

from collections import defaultdict
from collections.abc import Callable

from imgui_bundle import imgui

from app.editor.editor import Editor
from core.imaging.image import Image

BARE = imgui.WindowFlags_.no_scrollbar | imgui.WindowFlags_.no_scroll_with_mouse


class RoundRobin:
    """Decides frame by frame which panels and bars are laid out, and which are shown as they were."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._frame = 0
        self._laid_out: defaultdict[str, int] = defaultdict(int)
        """By name, the frame in which a part was laid out last."""
        self._present: list[str] = []
        """Parts of this frame."""
        self._due: str | None = None
        """The part whose turn it is; None in frames in which all are laid out."""
        self._is_held = False
        self._textures: tuple[Image | None, int] = None, 0
        """What is drawn with: the picture, whose textures are freed when another is opened, and the one of the text."""

    @property
    def keeps_any(self) -> bool:
        """Whether parts of this frame are shown as they were."""
        return self._due is not None

    def begin_frame(self) -> None:
        """Choose whose turn it is: all parts' at once unless a button was held in the last frame too."""
        self._frame += 1
        textures = self._editor.document.image, imgui.get_io().fonts.tex_data.unique_id
        is_held = self._editor.is_busy and imgui.is_any_mouse_down()
        keeps = is_held and self._is_held and textures[0] is self._textures[0] and textures[1] == self._textures[1]
        self._due = min(self._present, key=self._laid_out.__getitem__, default=None) if keeps else None
        self._is_held, self._textures, self._present = is_held, textures, []

    def drawing(self, name: str, draw: Callable[[], None], *, is_bar: bool = False) -> Callable[[], None]:
        """Return what draws a part, by `draw` when it is its turn; a bar never scrolls."""
        flags = imgui.ChildFlags_.always_use_window_padding, BARE if is_bar else 0

        def draw_or_keep() -> None:
            owner = imgui.internal.get_current_window()
            self._present.append(name)
            if self._due is None or self._due == name or _is_in_use(owner):
                self._laid_out[name] = self._frame
            else:
                imgui.internal.set_next_window_refresh_policy(imgui.internal.WindowRefreshFlags_.try_to_avoid_refresh)
            inner = owner.inner_rect
            imgui.set_cursor_screen_pos(inner.min)
            imgui.push_style_var(imgui.StyleVar_.window_padding, owner.window_padding)
            is_shown = imgui.begin_child("laid out in turn", inner.get_size(), *flags)
            imgui.pop_style_var()
            if is_shown:
                imgui.internal.push_override_id(owner.id_)  # widgets are called as they are in the window itself
                draw()
                imgui.pop_id()
            child = imgui.internal.get_current_window()
            if child.skip_refresh:  # whose place among the children Dear ImGui forgets when the window is laid out
                owner.dc.child_windows.push_back(child)
            imgui.end_child()
            owner.dc.cursor_max_pos = owner.dc.cursor_start_pos  # the child scrolls, not what it fills

        return draw_or_keep


def _is_in_use(owner: imgui.internal.Window) -> bool:
    """Return whether something in a window is held or typed in."""
    window = imgui.get_current_context().active_id_window
    while window is not None and window.id_ != owner.id_:
        window = window.parent_window
    return window is not None
