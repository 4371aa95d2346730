"""The export dialog: where to, how large, in which format. The export itself is a job; the status bar follows it."""

from dataclasses import replace
from pathlib import Path
from typing import Literal, cast

from imgui_bundle import ImVec2, imgui

from app.files.typed_paths import file_to_write, is_file, is_folder
from app.model.requests import ExportPicture
from app.ui.dialogs.file_browser import FileBrowser
from app.ui.dialogs.modal import is_confirmed, within
from app.ui.widgets import theme
from app.ui.widgets.controls import (
    colors,
    faint,
    label,
    move_right,
    plain_button,
    primary_button,
    segments,
    shorten,
    tip,
)
from app.ui.widgets.sliders import slider
from app.ui.widgets.theme import em
from core.arrays import InputError, Points
from core.canvas import Canvas, Framing
from core.files.text import begin_sentence, legible

Bits = Literal[8, 16, 32]

FORMATS: dict[str, tuple[str, tuple[Bits, ...], bool]] = {
    "png": ("PNG", (8, 16), False),
    "tif": ("TIFF", (8, 16, 32), False),
    "exr": ("EXR", (32,), False),
    "jpg": ("JPEG", (8,), True),
    "webp": ("WebP", (8,), True),
    "jxl": ("JPEG XL", (8, 16, 32), True),
}
"""By suffix: name, depths, and whether it has a quality."""

FRAMES = (
    ("warp", "All of the warp", "As large as the warped picture reaches"),
    ("picture", "The picture's frame", "What has moved out of the frame is cut off"),
)
MOST_PX = 32768


ALIASES = {"jpeg": "jpg", "tiff": "tif"}


def format_of(path: Path) -> str | None:
    """Return the key of `FORMATS` that a path ends in; None where it ends in something else."""
    suffix = path.suffix.lower().lstrip(".")
    suffix = ALIASES.get(suffix, suffix)
    return suffix if suffix in FORMATS else None


def with_ending(path: Path, chosen: str) -> Path:
    """Return `path` with the ending of a format in the place of another's, or behind a name that has none."""
    if not path.name:  # such as "/"
        return path
    return path.with_suffix(f".{chosen}") if format_of(path) else path.with_name(f"{path.name}.{chosen}")


def _size_around(warped: Points) -> tuple[int, int]:
    """Return the size that holds all of a warped grid; at least something where it is out of bounds."""
    try:
        return Canvas.around(warped).size
    except InputError:
        return 1, 1


class ExportDialog:
    """Choose how and where to export."""

    title = "Export picture"

    def __init__(self, request: ExportPicture, warped: Points) -> None:
        self._request = request
        self._sizes_px = {"picture": request.options.size_px, "warp": _size_around(warped)}
        self.options = request.options
        self._has_frame = request.document.mode == "warp" and request.document.surface is None
        """Whether there is a frame to choose: a surface's texture has the picture's."""
        if self._has_frame:
            self.options = replace(self.options, frame="warp", size_px=self._sizes_px["warp"])
        self._folder = request.options.path.parent
        """What a typed name is in."""
        self._format = format_of(request.options.path) or "png"
        self._browser: FileBrowser | None = None
        self._asked_overwrite: Path | None = None
        self._typed: str | None = None
        """What stands in the field of the file; None while that is not typed but chosen."""
        self._types_name = False
        """Whether the name is being typed in this frame."""
        self.fault = ""
        """Why no file can be written as it is typed."""

    def draw(self) -> bool:
        """Draw the dialog; return whether it stays open."""
        if self._browser is not None:
            self._draw_browser(self._browser)
            return True
        imgui.dummy(ImVec2(within(34), 0))
        self._draw_place()
        self._draw_format()
        if self._has_frame:
            self._draw_frame()
        self._draw_size()
        imgui.dummy(ImVec2(0, em(0.4)))
        return self._draw_answers()

    def _draw_browser(self, browser: FileBrowser) -> None:
        answer = browser.draw()
        if isinstance(answer, Path):
            self._folder = answer.parent
            self.write_to(answer.name)
            self._typed, self._asked_overwrite = None, answer
        if answer is not True:
            self._browser = None

    def _draw_place(self) -> None:
        path = self.options.path
        label("File", "Where the picture is written")
        imgui.set_next_item_width(imgui.get_content_region_avail().x - em(6.6) - imgui.get_style().item_spacing.x)
        shown = self._typed
        if shown is None:
            shown = legible(str(path.relative_to(self._folder) if path.is_relative_to(self._folder) else path))
        name = imgui.input_text("##file", shown)[1]
        self._types_name = imgui.is_item_active() or imgui.is_item_deactivated()
        tip(legible(str(self.path)))
        if name != shown:
            self.write_to(name)
        imgui.same_line()
        if imgui.button("Browse …", ImVec2(em(6.6), 0)):
            self._browser = FileBrowser((*FORMATS, *ALIASES), self.path.parent, name=self.path.name)
        label("Folder")
        faint(shorten(legible(str(self.path.parent)), imgui.get_content_region_avail().x, keeps_end=True))
        tip(legible(str(self.path.parent)))

    @property
    def _is_entered(self) -> bool:
        """Whether Enter was pressed to export, rather than to end the typing of a number."""
        return is_confirmed() and (self._types_name or not imgui.get_io().want_text_input)

    @property
    def path(self) -> Path:
        """The file that is written."""
        path = self.options.path
        return path if format_of(path) else with_ending(path, self._format)

    def write_to(self, name: str) -> None:
        """Take a name, in the folder or with one of its own; its ending says which format.

        A name that no file can have stays in its field, and `fault` says what is wrong with it.
        """
        self._typed, self.fault = name, ""
        try:
            path = file_to_write(self._folder, name)
        except InputError as fault:
            self.fault = begin_sentence(str(fault))
            return
        found = format_of(path)
        if found and found != self._format:
            self._format, self.options = found, replace(self.options, bits=None)
        self.options = replace(self.options, path=path)

    def choose_format(self, chosen: str) -> None:
        """Take a format, and give the file its ending."""
        self._typed, self.fault = None, ""
        self.options = replace(self.options, path=with_ending(self.path, chosen), bits=None)
        self._format = chosen

    def _draw_format(self) -> None:
        label("Format")
        if chosen := segments("format", [(key, row[0], "") for key, row in FORMATS.items()], self._format):
            self.choose_format(chosen)
        options = self.options
        _, depths, lossy = FORMATS[self._format]
        if len(depths) > 1:
            label("Depth", "Bits of a sample")
            names = {8: "8 bit", 16: "16 bit", 32: "Float"}
            choices = [("", "As the source", ""), *((str(bits), names[bits], "") for bits in depths)]
            if (bits := segments("depth", choices, str(options.bits or ""))) is not None:
                known: dict[str, Bits] = {str(depth): depth for depth in depths}
                self.options = replace(options, bits=known.get(bits))
        if lossy:
            held = slider("Quality", options.quality, 1, 100, default=92, hint="Higher is better and larger")
            if held.value is not None:
                self.options = replace(options, quality=round(held.value))

    def _draw_frame(self) -> None:
        label("Frame", "What the file shows")
        frame = segments("frame", FRAMES, self.options.frame)
        if frame is not None and frame != self.options.frame:
            scale = self.options.size_px[0] / self._full_px[0]
            self.options = replace(self.options, frame=cast("Framing", frame))
            self._scale(scale)

    def _draw_size(self) -> None:
        width, height = self.options.size_px
        label("Size", "Width and height in pixels; the proportions stay")
        imgui.set_next_item_width(em(5.5))
        new_width = imgui.input_int("##width", width, 0)[1]
        imgui.same_line()
        imgui.text("×")
        imgui.same_line()
        imgui.set_next_item_width(em(5.5))
        new_height = imgui.input_int("##height", height, 0)[1]
        if new_width != width:
            self._scale(new_width / self._full_px[0])
        elif new_height != height:
            self._scale(new_height / self._full_px[1])
        for percent in (50, 100, 200):
            imgui.same_line(0, em(0.6) if percent == 50 else em(0.3))
            if imgui.get_content_region_avail().x < em(3.6):
                imgui.new_line()
            if imgui.button(f"{percent} %", ImVec2(em(3.6), 0)):
                self._scale(percent / 100)
            tip("{} × {} pixels".format(*self._scaled(percent / 100)))

    def _scaled(self, scale: float) -> tuple[int, int]:
        """Return `scale` times the size of the result in the chosen frame."""
        width, height = (min(max(round(side * scale), 1), MOST_PX) for side in self._full_px)
        return width, height

    def _scale(self, scale: float) -> None:
        self.options = replace(self.options, size_px=self._scaled(scale))

    @property
    def _full_px(self) -> tuple[int, int]:
        """Size of the result at 100 % in the chosen frame."""
        return self._sizes_px[self.options.frame]

    def _draw_answers(self) -> bool:
        path = self.path
        replaces = is_file(path) and self._asked_overwrite != path
        top = imgui.get_cursor_pos_y()
        imgui.set_cursor_pos_y(top + (em(2.0) - imgui.get_font_size()) / 2)
        imgui.push_text_wrap_pos(imgui.get_window_width() - em(16))
        fault = self.fault or ("" if is_folder(path.parent) else f"{path.parent}: no such folder")
        if fault:
            with colors(text=theme.FAULT):
                imgui.text_wrapped(legible(fault))
        elif replaces:
            faint(f"{legible(path.name)} exists and will be replaced.")
        else:
            faint(f"{self.options.size_px[0] * self.options.size_px[1] / 1e6:.1f} megapixels")
        imgui.pop_text_wrap_pos()
        move_right(7, 7)
        imgui.set_cursor_pos_y(top)
        if plain_button("Cancel", 7) or imgui.is_key_pressed(imgui.Key.escape):
            return False
        imgui.same_line()
        imgui.set_cursor_pos_y(top)
        imgui.begin_disabled(bool(fault))
        pressed = primary_button("Replace" if replaces else "Export", 7)
        pressed = pressed or (self._is_entered and not fault and not replaces)
        imgui.end_disabled()
        if pressed:
            self._request.then(replace(self.options, path=path))
        return not pressed
