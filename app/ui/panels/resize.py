"""The page of the Warp panel that gives the result another size: numbers, ratios, and what is to keep its shape."""

from imgui_bundle import ImVec2, imgui

from app.editor.editor import Editor
from app.marking.resizing import is_proposal, propose_kept, resize, set_resizing, with_proposal, with_ratio
from app.model.session import Unit
from app.ui.panels.straight_lines import draw_straight
from app.ui.widgets.controls import check, disabled, faint, label, section, segments, toggle_button
from app.ui.widgets.key_button import key_button
from app.ui.widgets.sliders import number_box, slider
from app.ui.widgets.theme import em

RATIOS = (
    ("1:1", 1.0),
    ("4:5", 0.8),
    ("5:4", 1.25),
    ("2:3", 2 / 3),
    ("3:2", 1.5),
    ("9:16", 9 / 16),
    ("16:9", 16 / 9),
    ("2:1", 2.0),
)
COLUMNS = 4
MM_PER_INCH = 25.4
UNITS: tuple[tuple[Unit, str, str], ...] = (
    ("px", "px", "Pixels"),
    ("%", "%", "Per cent of the picture"),
    ("mm", "mm", "Millimetres in print"),
    ("in", "in", "Inches in print"),
)


class ResizePanel:
    """Draws the page."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor

    def draw(self) -> None:
        """Draw size, ratios and what is kept."""
        if section("Size"):
            self._draw_size()
        if section("Ratio"):
            self._draw_ratios()
        if section("Keep"):
            self._draw_keeping()

    def _per_unit(self, axis: int) -> float:
        """Return how many pixels of the result one of the unit is, across or down."""
        settings = self._editor.session.resizing
        per = {"px": 1.0, "%": self._editor.document.size_px[axis] / 100, "mm": settings.dpi / MM_PER_INCH}
        return per.get(settings.unit, settings.dpi)

    def _draw_size(self) -> None:
        editor, settings = self._editor, self._editor.session.resizing
        label("Unit")
        unit = segments("unit", UNITS, settings.unit)
        if unit is not None:
            set_resizing(editor, unit=unit)
        size = editor.document.canvas_px
        for axis, name in enumerate(("Width", "Height")):
            label(name, "Of the result")
            per = self._per_unit(axis)
            typed = number_box(size[axis] / per, 0.01, 1e6, 0 if settings.unit == "px" else 1, name=name, width_em=6.0)
            if typed.value is not None:
                self._take(axis, typed.value * per)
            imgui.same_line(0, em(0.4))
            imgui.text(settings.unit)
        locked = check("Keep the ratio", settings.locked, "Width and height change together; with Shift while dragging")
        if locked is not None:
            set_resizing(editor, locked=locked)
        if settings.unit in ("mm", "in"):
            label("Resolution", "Pixels per inch in print")
            dpi = number_box(settings.dpi, 10, 2400, 0, name="dpi", width_em=6.0)
            if dpi.value is not None:
                set_resizing(editor, dpi=dpi.value)
        key_button(editor, "size", is_low=True)
        faint(f"{size[0]} × {size[1]} pixels, from {editor.document.size_px[0]} × {editor.document.size_px[1]}")

    def _take(self, axis: int, side: float) -> None:
        """Give one side another length in pixels, and the other as well where the ratio is kept."""
        size = [float(length) for length in self._editor.document.canvas_px]
        factor = side / size[axis]
        size = [length * factor for length in size] if self._editor.session.resizing.locked else size
        size[axis] = side
        resize(self._editor, (size[0], size[1]))

    def _draw_ratios(self) -> None:
        """Draw a button for each ratio; the result is as large as fits into the picture."""
        editor, gap, (across, down) = self._editor, em(0.3), self._editor.document.canvas_px
        width = (imgui.get_content_region_avail().x - gap * (COLUMNS - 1)) / COLUMNS
        for number, (name, ratio) in enumerate(RATIOS):
            if number % COLUMNS:
                imgui.same_line(0, gap)
            # The result has whole pixels.
            if toggle_button(name, width, on=abs(across - ratio * down) <= max(1.0, ratio)):
                resize(editor, with_ratio(editor.document.size_px, ratio))
        with disabled((across, down) == editor.document.size_px):
            if imgui.button("As the picture", ImVec2(imgui.get_content_region_avail().x, 0)):
                resize(editor, editor.document.size_px)

    def _draw_keeping(self) -> None:
        """Draw what is proposed to keep, and how much of it."""
        editor, settings = self._editor, self._editor.session.resizing
        hint = "Where nothing is painted, what stands out of its ground is marked; it can be painted on like any mask"
        proposes = check("Propose what to keep", settings.proposes, hint)
        if proposes is not None:
            set_resizing(editor, proposes=proposes)
        document = editor.document
        mine = not document.mask.is_empty and not is_proposal(document)
        imgui.begin_disabled(mine)
        held = slider("How much", 100 * settings.share, 1, 80, default=25, hint="Share of the picture, per cent")
        if held.value is not None:
            set_resizing(editor, share=held.value / 100)
            if is_proposal(document):
                editor.slide("How much to keep", with_proposal(document, held.value / 100))
        if held.done:
            editor.finish()
            if is_proposal(editor.document):
                propose_kept(editor)
        if imgui.button("Propose now", ImVec2(imgui.get_content_region_avail().x, 0)):
            propose_kept(editor)
        imgui.end_disabled()
        draw_straight(editor)
        if mine:
            faint("You have painted yourself what is kept. Clear the mask to have something proposed.")
