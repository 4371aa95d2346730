"""The panel of Overlay mode: finding the pattern, the texture and how it lies, what is shown, what can be saved."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from imgui_bundle import ImVec2, imgui

from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.ui.widgets import theme
from app.ui.widgets.action_buttons import action_button, action_buttons
from app.ui.widgets.controls import (
    at_least,
    check,
    colors,
    faint,
    fault,
    plain_button,
    primary_button,
    section,
    segments,
    shorten,
    tip,
)
from app.ui.widgets.sliders import Held, slider
from app.ui.widgets.theme import em
from core.document.overlay_settings import Cloth, Laying
from core.files.text import legible

DEFAULTS = Laying()


@dataclass(frozen=True)
class OverlayRow:
    """A slider for a number of `Laying`."""

    name: str
    field: Literal["size", "stretch", "rotate_deg", "detail", "shading"]
    low: float
    high: float
    hint: str
    digits: int = 0
    factor: float = 1.0
    """What is shown over what is stored: 100 for per cent."""
    logarithmic: bool = False


PLACE = (
    OverlayRow("Size", "size", 0.1, 60, "Width of one copy, in repeats of the old pattern", 2, logarithmic=True),
    OverlayRow(
        "Stretch", "stretch", 25, 400, "Height of a copy, per cent of an undistorted one", 0, 100, logarithmic=True
    ),
    OverlayRow("Rotation", "rotate_deg", -180, 180, "Clockwise, in the plane of the cloth, in degrees", 1),
)
BLEND = (
    OverlayRow(
        "Detail", "detail", 0, 200, "How much of the photo's fine detail goes over the texture, per cent", 0, 100
    ),
    OverlayRow("Shading", "shading", 0, 200, "How strong the folds' light and shade are, per cent", 0, 100),
)
ADVICE_PAINTED = "Paint more of the cloth, or less (B), and look again, or mark one repeat of it (I)."
ADVICE_UNPAINTED = (
    "Take what stands out as the whole cloth, paint it (B), "
    "drag a rectangle around it (R) or mark one repeat of it (I)."
)
UNSOUGHT = "The whole picture is searched, or what the brush (B) or a rectangle (R) marks as cloth."
STOPPED = "The search was stopped. Go on with it, or find the pattern anew."
FOUND = "{} repeat{} found on {:.0f} % of the picture. {}"
MORE = "For more, take the whole cloth, paint the region and find anew, or paint the cover (B)."
EARLIER = "That was before the last change."
STATES = (UNSOUGHT, STOPPED, f"{FOUND} {MORE}", f"A fault that is said in a line.\n{ADVICE_UNPAINTED}")
"""What can be said of the search: its place on the panel has room for any of them."""
NO_TEXTURE = "The old pattern is shown. Choose a picture, or drop a file on the window."
WHEREABOUTS = ("Drag it on the cloth (T).", "Waits for the pattern.", "Find the pattern.")
TEXTURES = (NO_TEXTURE, *(f"Name\n8192 × 8192 px. {text}" for text in WHEREABOUTS))
VIEWS = ("result", "photo", "pattern", "mesh", "shading", "detail", "reconstruction", "residual")


class OverlayPanel:
    """Sliders and choices over `Document.cloth`."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._editor = editor
        self._table = table

    def draw(self) -> None:
        """Draw the panel."""
        if section("Old pattern"):
            self._draw_search()
        if section("New texture"):
            self._draw_texture()
        if section("Light and detail"):
            self._draw_rows(BLEND)
        if section("Show"):
            self._draw_views()
        if section("Save", opened=False):
            self._draw_saving()

    @property
    def _cloth(self) -> Cloth:
        return self._editor.document.cloth

    def _draw_search(self) -> None:
        """Draw what finds the pattern, how far that is, and what came of it; every row has its place all the time."""
        work = self._editor.overlay
        width = (imgui.get_content_region_avail().x - em(0.3)) / 2
        if work.is_running:
            if plain_button("Cancel", width / em(1)):
                work.cancel()
            tip("Stop looking for the pattern", "Ctrl+.")
        else:
            if primary_button("Find pattern", width / em(1)):
                self._table.run("overlay.find", self._editor)
            tip("Find what repeats on the cloth, in the painted region or everywhere", "Ctrl+R")
        imgui.same_line(0, em(0.3))
        forget = self._table.by_name["overlay.forget"]
        action_button(self._editor, forget, text="Forget", width=width, height=em(2.0))
        with at_least(*STATES):
            if work.under_way is not None:
                imgui.progress_bar(work.under_way.progress.fraction, ImVec2(-1, em(0.5)), "")
            if work.fault is not None:
                fault(work.fault)
            faint(self._state())
        more = "overlay.go_on" if work.is_stopped and work.fault is None else "overlay.whole"
        action_buttons(self._editor, [self._table.by_name[name] for name in (more, "overlay.clear_region")])
        held = slider("Seed", self._cloth.seed, 0, 99, default=0, hint="Another number, another search")
        self._take("Seed", held, lambda new: self._cloth.changed(seed=round(new)))

    def _state(self) -> str:
        """Return in words what was found, or what to do."""
        work, layers = self._editor.overlay, self._editor.overlay.layers
        if work.under_way is not None:
            note = work.under_way.progress.note
            return f"{note.capitalize()} …" if note else "Waiting …"
        if work.fault is not None:
            return ADVICE_UNPAINTED if self._table.by_name["overlay.whole"].enabled(self._editor) else ADVICE_PAINTED
        if work.is_stopped and layers is None:
            return STOPPED
        if layers is None or self._cloth.search is None:
            return UNSOUGHT
        repeats, more = layers.repeats, MORE if work.is_final else EARLIER
        return FOUND.format(repeats, "" if repeats == 1 else "s", 100 * layers.covered_share, more)

    def _draw_texture(self) -> None:
        """Draw the choice of a texture and how it lies."""
        image = self._cloth.texture
        with at_least(*TEXTURES):
            if image is None:
                faint(NO_TEXTURE)
            else:
                name = legible(self._cloth.texture_name) or "Texture"
                imgui.text(shorten(name, imgui.get_content_region_avail().x))
                tip(name)
                faint(f"{image.width_px} × {image.height_px} px. {self._whereabouts()}")
        action_buttons(self._editor, [self._table.by_name[name] for name in ("overlay.texture", "overlay.old_pattern")])
        imgui.begin_disabled(self._cloth.texture is None)
        self._draw_rows(PLACE)
        self._draw_offset()
        laying = self._cloth.laying
        tile = segments(
            "tile", (("repeat", "Repeat", "Copies side by side"), ("once", "Once", "One copy")), _kind(laying)
        )
        if tile is not None:
            self._edit("Repeat texture" if tile == "repeat" else "Texture once", tile=tile == "repeat")
        mirrored = check("Mirror every second copy", laying.mirror, "Any picture then joins without an edge")
        if mirrored is not None:
            self._edit("Mirror texture", mirror=mirrored)
        leaning = check("Lean as the old repeats do", not laying.upright, "A saved tile then fits in its old place")
        if leaning is not None:
            self._edit("Lean texture" if leaning else "Texture upright", upright=not leaning)
        imgui.end_disabled()

    def _whereabouts(self) -> str:
        """Return in words what can be done with the new texture."""
        drag, wait, find = WHEREABOUTS
        if self._editor.overlay.layers is not None:
            return drag
        return wait if self._editor.overlay.is_running else find

    def _draw_offset(self) -> None:
        across, down = self._cloth.laying.offset
        hint = "By how much of a copy the texture is moved, per cent"
        held = slider("Across", 100 * across, -100, 100, default=0, digits=1, hint=hint)
        self._take("Move texture", held, lambda new: self._cloth.with_laying(offset=(new / 100, down)))
        held = slider("Down", 100 * down, -100, 100, default=0, digits=1, hint=hint)
        self._take("Move texture", held, lambda new: self._cloth.with_laying(offset=(across, new / 100)))

    def _draw_rows(self, rows: tuple[OverlayRow, ...]) -> None:
        for row in rows:
            value, default = (row.factor * self._number(laying, row) for laying in (self._cloth.laying, DEFAULTS))
            held = slider(
                row.name,
                value,
                row.low,
                row.high,
                default=default,
                digits=row.digits,
                logarithmic=row.logarithmic,
                hint=row.hint,
            )
            self._take(row.name, held, lambda new, row=row: self._cloth.with_laying(**{row.field: new / row.factor}))  # type: ignore[misc]

    def _number(self, laying: Laying, row: OverlayRow) -> float:
        """Return a number of `laying`; a size that is not chosen is the one that suits the cloth."""
        number = getattr(laying, row.field)
        layers = self._editor.overlay.layers
        if number is None:
            return 1.0 if layers is None else layers.usual_size
        return float(number)

    def _draw_views(self) -> None:
        """Draw a button for everything that can be looked at, two a line."""
        width = (imgui.get_content_region_avail().x - em(0.3)) / 2
        for number, name in enumerate(VIEWS):
            action = self._table.by_name[f"shown.{name}"]
            on = action.checked is not None and action.checked(self._editor)
            imgui.begin_disabled(not action.enabled(self._editor))
            with colors(
                button=theme.ACCENT if on else theme.BUTTON,
                button_hovered=theme.ACCENT if on else theme.BUTTON_HOVERED,
                text=theme.ON_ACCENT if on else theme.TEXT,
            ):
                if imgui.button(f"{action.label}##shown", ImVec2(width, 0)):
                    action.run(self._editor)
            imgui.end_disabled()
            tip(action.tooltip, action.chord)
            if number % 2 == 0:
                imgui.same_line(0, em(0.3))

    def _draw_saving(self) -> None:
        for name in ("file.export", "overlay.save_texel"):
            action_button(self._editor, self._table.by_name[name])
        shown = self._table.by_name.get(f"overlay.export_{self._editor.session.shown}")
        if shown is not None:
            action_button(self._editor, shown, text=f"Export {shown.label.lower()}")
        else:
            imgui.begin_disabled()
            imgui.button("Export part…", ImVec2(imgui.get_content_region_avail().x, 0))
            imgui.end_disabled()
            tip("Show a part to export it")

    def _take(self, name: str, held: Held, changes: Callable[[float], Cloth]) -> None:
        """Show what a slider says while it is held, and make it an undo entry when it is let go."""
        if held.value is not None:
            self._editor.slide(name, self._editor.document.changed(cloth=changes(held.value)))
        if held.done:
            self._editor.finish()

    def _edit(self, name: str, **changes: object) -> None:
        self._editor.edit(name, self._editor.document.changed(cloth=self._cloth.with_laying(**changes)))


def _kind(laying: Laying) -> str:
    return "repeat" if laying.tile else "once"
