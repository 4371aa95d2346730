"""The panel of Retexture mode: what is shown, the edited curve, the masks, and how texture is regrown."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, cast

from imgui_bundle import imgui

from app.actions.retexture import show_look
from app.actions.table import ActionTable
from app.editor.curve_kinds import FEATURE
from app.editor.editor import Editor
from app.model.session import Look
from app.ui.widgets.action_buttons import action_button, action_buttons
from app.ui.widgets.controls import (
    at_least,
    check,
    faint,
    fault,
    label,
    plain_button,
    primary_button,
    section,
    segments,
    tip,
)
from app.ui.widgets.sliders import Held, slider
from app.ui.widgets.theme import em
from core.document.document import RetextureSettings
from core.document.retexture import moves, usual_sides
from core.retexture.job import LEAST_REACH_PX, REACH

DEFAULTS = RetextureSettings()
LOOKS = (
    ("original", "Original", "The picture as it was (1)"),
    ("deformed", "Deformed", "The picture stretched along with the curves (2)"),
    ("retextured", "Retextured", "The picture with its texture regrown (3)"),
)
BEGIN = "Draw along an edge with the pen (C) or trace it (T), then drag the curve to where it is to go."
NOTHING_FITS = "No patch fits where the masks allow it, so the picture is only stretched."
ONLY_STEERS = "Passive curves only steer. Draw another curve and drag it, or switch Passive off."


@dataclass(frozen=True)
class RetextureRow:
    """A slider for a whole number of pixels of `RetextureSettings`."""

    name: str
    step: str
    """What a change of it is called in the history."""
    field: Literal["along_px", "across_px", "search_along_px", "search_across_px"]
    low: float
    high: float
    hint: str


PATCH = (
    RetextureRow(
        "Length",
        "Length of patches",
        "along_px",
        9,
        121,
        "Length of a patch along the curve, in pixels: some repeats of the texture",
    ),
    RetextureRow("Width", "Width of patches", "across_px", 5, 81, "Width of a patch across the curve, in pixels"),
)
SEARCH = (
    RetextureRow(
        "Along",
        "Search along the curve",
        "search_along_px",
        1,
        61,
        "How far along the curve patches are looked for, in pixels",
    ),
    RetextureRow(
        "Across",
        "Search across the curve",
        "search_across_px",
        1,
        31,
        "How far across the curve patches are looked for, in pixels",
    ),
)


class RetexturePanel:
    """Sliders and choices over `Document.retexture`, and what belongs to the edited curve."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._editor = editor
        self._table = table

    def draw(self) -> None:
        """Draw the panel."""
        self._draw_result()
        if section("Curve"):
            self._draw_curve()
        if section("Patches"):
            self._draw_patches()
        if section("Reach"):
            self._draw_reach()
        if section("Masks"):
            self._draw_masks()

    @property
    def _settings(self) -> RetextureSettings:
        return self._editor.document.retexture

    def _draw_result(self) -> None:
        """Draw what is shown and what starts the work."""
        editor, session = self._editor, self._editor.session
        look = segments("look", LOOKS, session.look)
        if look is not None:
            show_look(editor, cast("Look", look))
        with_curves = moves(editor.document)
        if editor.regrowth.is_running:
            if plain_button("Cancel", 8):
                editor.regrowth.cancel()
        else:
            imgui.begin_disabled(not with_curves)
            if primary_button("Retexture", 8):
                self._table.run("retexture.start", editor)
            imgui.end_disabled()
            tip("Regrow the texture along the moved curves", "Ctrl+R")
        imgui.same_line()
        imgui.set_cursor_pos_y(imgui.get_cursor_pos_y() + (em(2.0) - imgui.get_frame_height()) / 2)
        switched = check("By itself", session.auto_retexture, "Regrow the texture as soon as a curve is let go")
        if switched is not None:
            editor.show(auto_retexture=switched)
        with at_least(BEGIN, NOTHING_FITS, ONLY_STEERS):
            if self._is_at_fault:
                fault(self.state)
            else:
                faint(self.state)

    @property
    def _is_at_fault(self) -> bool:
        """Whether the present curves have no result."""
        return bool(self._editor.document.feature_curves) and self._editor.regrowth.fault is not None

    @property
    def state(self) -> str:
        """How far the result is, in words, and what is to be done next."""
        editor, work = self._editor, self._editor.regrowth
        if not editor.document.feature_curves:
            return BEGIN
        if self._is_at_fault and work.fault is not None:
            return work.fault
        if all(pair.passive for pair in editor.document.feature_curves):
            return ONLY_STEERS
        if not moves(editor.document):
            return "Drag a curve: the texture goes with it."
        if work.is_final and work.stage is not None and not work.stage.has_patches:
            return NOTHING_FITS
        if work.is_final and work.stage is not None:
            return f"The texture is regrown, in {work.stage.found.seconds['total']:.1f} s."
        if work.is_running and work.ticket is not None:
            note = work.ticket.progress.note
            return f"{note.capitalize()} …" if note else "Working …"
        return "Stretched; the texture is not regrown yet."

    def _draw_curve(self) -> None:
        editor, number = self._editor, FEATURE.number(self._editor)
        count = len(editor.document.feature_curves)
        faint("Click a curve to edit it." if number is None else f"Curve {number + 1} of {count}")
        for name in ("feature.passive", "feature.closed"):
            self._draw_switch(name)
            imgui.same_line(0, em(1.2))
        imgui.new_line()
        self._draw_switch("feature.snaps")
        for name in ("feature.put_back", "feature.snap", "feature.simplify", "feature.select_all"):
            action_button(editor, self._table.by_name[name])

    def _draw_switch(self, name: str) -> None:
        """Draw an action that is on or off as a box to check."""
        action = self._table.by_name[name]
        imgui.begin_disabled(not action.enabled(self._editor))
        on = action.checked is not None and action.checked(self._editor)
        if check(action.label, on, action.tooltip) is not None:
            action.run(self._editor)
        imgui.end_disabled()

    def _draw_patches(self) -> None:
        for row in PATCH:
            self._slide(row)
        faint("They are looked for so far around:")
        for row in SEARCH:
            self._slide(row)
        hint = "How much it costs to show a place of the picture again: more avoids repetition"
        held = slider("Variety", self._settings.variety, 0, 2, default=DEFAULTS.variety, digits=2, hint=hint)
        self._take("Variety", held, lambda new: {"variety": new})
        label("Mirror", "Whether patches may be turned over across the curve's normal")
        mirrored = check("allowed", self._settings.mirrored, "For textures without a direction along the curve")
        if mirrored is not None:
            self._edit("Mirrored patches", mirrored=mirrored)
        held = slider("Seed", self._settings.seed, 0, 99, default=0, hint="Another number, another choice of patches")
        self._take("Seed", held, lambda new: {"seed": round(new)})

    def _draw_reach(self) -> None:
        longer = max(self._editor.document.size_px)
        usual = max(REACH, LEAST_REACH_PX / longer)
        hint = "How far from a curve texture is regrown, per cent of the picture's longer side"
        self._share("Texture", "reach", usual, hint)
        hint = "How far from a curve the picture moves at all, per cent of its longer side"
        self._share("Motion", "move_within", 0.1, hint)
        self._draw_switch("retexture.edges")

    def _share(self, name: str, field: Literal["reach", "move_within"], usual: float, hint: str) -> None:
        """Draw a switch between the automatic value and one's own, and a slider over that."""
        value: float | None = getattr(self._settings, field)
        label(name, hint)
        automatic = "Automatic" if field == "reach" else "To the edge"
        switched = check(f"{automatic}##{field}", value is None, hint)
        if switched is not None:
            self._edit(f"{name} reach", **{field: None if switched else round(usual, 3)})
        imgui.begin_disabled(value is None)
        default = 100 * round(usual, 3)
        own = default if value is None else 100 * value
        held = slider(f"{name} reach", own, 1, 60, default=default, digits=1, hint=hint)
        imgui.end_disabled()
        self._take(f"{name} reach", held, lambda percent: {field: percent / 100})

    def _draw_masks(self) -> None:
        faint("Paint with the brush (B). Nothing painted means everywhere.")
        for name in ("regrow", "matte", "source_mask"):
            actions = [self._table.by_name[f"retexture.{verb}_{name}"] for verb in ("paint", "clear")]
            action_buttons(self._editor, actions)

    def _slide(self, row: RetextureRow) -> None:
        usual = usual_sides(self._editor.document.size_px)[row.field]
        value = getattr(self._settings, row.field) or usual
        held = slider(row.name, value, row.low, row.high, default=usual, hint=row.hint)

        def changes(new: float) -> dict[str, object]:
            # A patch has a middle: its sides are odd.
            side = 2 * (round(new) // 2) + 1
            return {row.field: None if side == usual else side}

        self._take(row.step, held, changes)

    def _take(self, name: str, held: Held, changes: Callable[[float], dict[str, object]]) -> None:
        """Show what a slider says while it is held, and make it an undo entry when it is let go."""
        if held.value is not None:
            self._editor.slide(name, self._editor.document.with_retexture(**changes(held.value)))
        if held.done:
            self._editor.finish()

    def _edit(self, name: str, **changes: object) -> None:
        self._editor.edit(name, self._editor.document.with_retexture(**changes))
