"""The panel of features: a row for each, with its colour, picture and name; below it what refines the mask."""

from collections.abc import Sequence

from imgui_bundle import ImVec2, imgui

from app.actions.selecting import REFINED, set_selecting
from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.marking.feature_list import Listed, feature_list, merge, remove, rows_of
from app.ui.panels.keeping import Keeping
from app.ui.widgets import theme
from app.ui.widgets.action_buttons import action_buttons
from app.ui.widgets.controls import disabled, faint, icon_button, label, shorten, tip
from app.ui.widgets.picture_texture import PictureTexture
from app.ui.widgets.sliders import slider
from app.ui.widgets.theme import color, em
from core.rasters.raster import Box

ROW_EM, PICTURE_EM, MOST_NAME = 2.2, 2.6, 80
LEAST_ROWS, MOST_ROWS = 2.5, 200
"""Rows that are in sight at least: half a one tells that there are more."""


class FeaturesPanel:
    """A press on a row chooses a feature, with Shift beside others; under the pointer it lights up in the picture."""

    def __init__(self, editor: Editor, table: ActionTable, picture: PictureTexture) -> None:
        self._editor = editor
        self._table = table
        self._picture = picture
        self._keeping = Keeping(editor)
        self._naming: int | None = None
        """The feature whose name is being typed."""
        self._focuses = False
        self._below_list = 0.0
        """How high the settings of what is chosen were in the last frame, in screen pixels."""

    def draw(self) -> None:
        """Draw colour and strength of the mask, the list, and what can be done with it."""
        editor = self._editor
        rows = rows_of(editor)
        there = frozenset(row.id for row in rows)
        if not editor.session.features <= there:
            editor.show(features=editor.session.features & there)
        self._draw_part()
        if rows:
            self._draw_list(rows)
        else:
            faint("No features yet. Paint one (B), select one (R), or take them from the picture's transparency.")
            editor.show(lit=None)
        top = imgui.get_cursor_pos_y()
        self._keeping.draw([row.said for row in rows if row.id in editor.session.features])
        self._below_list = imgui.get_cursor_pos_y() - top
        self._draw_deeds()
        self._draw_refining()
        self._draw_look()

    def _draw_list(self, rows: Sequence[Listed]) -> None:
        """Draw the list, which scrolls where the settings of what is chosen in it would not be in sight below it."""
        editor, row_height = self._editor, em(ROW_EM) + imgui.get_style().item_spacing.y
        room = imgui.get_content_region_avail().y - self._below_list - row_height / 2
        height = min((len(rows) + (len(rows) > MOST_ROWS)) * row_height, max(room, LEAST_ROWS * row_height))
        lit = None
        if imgui.begin_child("list", ImVec2(0, height)):
            for row in rows[:MOST_ROWS]:
                if self._draw_row(row):
                    lit = row.id
            if len(rows) > MOST_ROWS:
                faint(f"… and {len(rows) - MOST_ROWS} more")
        imgui.end_child()
        if lit != editor.session.lit:
            editor.show(lit=lit)

    def _draw_part(self) -> None:
        """Draw which feature is painted next."""
        label("Painting", "Which feature what is painted or selected next is of")
        actions = [self._table.by_name[f"features.{part}"] for part in ("joined", "new", "chosen")]
        for action in actions:
            on = action.checked is not None and action.checked(self._editor)
            hint = f"{action.label}\n{action.tooltip}"
            with disabled(not action.enabled(self._editor)):
                if icon_button(action.name, action.icon, on=on, hint=hint, key=action.chord, size_em=1.7):
                    action.run(self._editor)
            imgui.same_line(0, em(0.2))
        imgui.new_line()

    def _draw_row(self, row: Listed) -> bool:
        """Draw a row; return whether the pointer is on it."""
        editor, chosen = self._editor, self._editor.session.features
        imgui.push_id(f"feature {row.id}")
        top, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
        flags = imgui.SelectableFlags_.allow_overlap
        if imgui.selectable("##row", row.id in chosen, flags, ImVec2(room, em(ROW_EM)))[0]:
            editor.show(features=chosen ^ {row.id} if imgui.get_io().key_shift else frozenset({row.id}))
        hovered = imgui.is_item_hovered(imgui.HoveredFlags_.allow_when_overlapped_by_item)
        if hovered and imgui.is_mouse_double_clicked(0):
            self._naming, self._focuses = row.id, True
        tip("Double-click to name it; with Shift, choose several")
        end = imgui.get_cursor_screen_pos()
        sheet, code = (
            imgui.get_window_draw_list(),
            theme.feature_code(feature_list(editor).color(row.id), kept=row.said.kept),
        )
        sheet.add_rect_filled(top, ImVec2(top.x + em(0.35), top.y + em(ROW_EM)), color(code), em(0.15))
        self._draw_picture(sheet, ImVec2(top.x + em(0.6), top.y), row.box)
        left, middle = top.x + em(PICTURE_EM + 1.0), top.y + (em(ROW_EM) - imgui.get_frame_height()) / 2
        imgui.set_cursor_screen_pos(ImVec2(left, middle))
        self._draw_name(row, room - em(PICTURE_EM + 1.0 + 2 * 1.9))
        imgui.set_cursor_screen_pos(ImVec2(top.x + room - em(2 * 1.75), middle))
        kept = row.said.kept
        hint = "It keeps its shape: press to let it be warped" if kept else "It is warped: press to keep its shape"
        if icon_button("keep", "lock" if kept else "lock-open", quiet=True, on=kept, hint=hint, size_em=1.7):
            merge(editor, "Give up feature" if kept else "Keep feature", frozenset({row.id}), kept=not kept)
        imgui.same_line(0, em(0.1))
        if icon_button("remove", "xmark", quiet=True, hint="Take it out of the mask", size_em=1.7):
            remove(editor, frozenset({row.id}))
        imgui.set_cursor_screen_pos(ImVec2(end.x, end.y - imgui.get_style().item_spacing.y))
        imgui.dummy(ImVec2(0, 0))
        imgui.pop_id()
        return hovered

    def _draw_name(self, row: Listed, width: float) -> None:
        """Draw the name of a row, `width` screen pixels wide, or the field to type another one into."""
        if self._naming != row.id:
            imgui.align_text_to_frame_padding()
            imgui.text(shorten(row.name, width))
            return
        if self._focuses:
            imgui.set_keyboard_focus_here()
            self._focuses = False
        imgui.set_next_item_width(width)
        _, name = imgui.input_text("##name", row.name, imgui.InputTextFlags_.auto_select_all)
        if imgui.is_item_deactivated():
            self._naming = None
        if imgui.is_item_deactivated_after_edit() and name.strip():
            merge(self._editor, "Name feature", frozenset({row.id}), name=name.strip()[:MOST_NAME])

    def _draw_picture(self, sheet: imgui.ImDrawList, place: ImVec2, box: Box) -> None:
        """Draw what of the picture lies in a box, as large as fits."""
        image = self._editor.document.image
        texture = self._picture.of(image)
        if texture is None:
            return
        width, height = max(box[2] - box[0], 1), max(box[3] - box[1], 1)
        scale = min(em(PICTURE_EM) / width, em(ROW_EM) / height)
        left = place.x + (em(PICTURE_EM) - width * scale) / 2
        top = place.y + (em(ROW_EM) - height * scale) / 2
        sheet.add_image(
            imgui.ImTextureRef(texture.texture),
            ImVec2(left, top),
            ImVec2(left + width * scale, top + height * scale),
            ImVec2(box[0] / image.width_px, box[1] / image.height_px),
            ImVec2(box[2] / image.width_px, box[3] / image.height_px),
        )

    def _draw_deeds(self) -> None:
        """Draw what can be done with the chosen features."""
        action_buttons(self._editor, [self._table.by_name[name] for name in ("features.merge", "tool.split")])

    def _draw_refining(self) -> None:
        """Draw the amount and the buttons that refine the mask."""
        hint = "By how much the mask is grown, shrunk, smoothed and feathered, in pixels of the picture"
        held = slider(
            "Refine by",
            self._editor.session.selecting.refine_px,
            0.5,
            100,
            default=4.0,
            digits=1,
            logarithmic=True,
            hint=hint,
        )
        if held.value is not None:
            set_selecting(self._editor, refine_px=held.value)
        for number, name in enumerate(REFINED):
            action = self._table.by_name[name]
            if number:
                imgui.same_line(0, em(0.2))
            imgui.begin_disabled(not action.enabled(self._editor))
            if icon_button(name, action.icon, hint=f"{action.label}\n{action.tooltip}", size_em=1.9):
                action.try_run(self._editor)
            imgui.end_disabled()

    def _draw_look(self) -> None:
        """Draw in which colour and how strongly the mask is laid over the picture."""
        preferences = self._editor.preferences
        label("Mask colour", "Of what is painted, where features have no colours of their own")
        tone = theme.rgb(preferences.mask_color)
        flags = imgui.ColorEditFlags_.no_inputs | imgui.ColorEditFlags_.no_label
        changed, picked = imgui.color_edit3("##mask colour", [tone.x, tone.y, tone.z], flags)
        if changed:
            code = sum(round(channel * 255) << shift for channel, shift in zip(picked, (16, 8, 0), strict=True))
            self._editor.prefer(preferences.changed(mask_color=code, feature_colors=False))
        imgui.same_line(0, em(0.6))
        switched, by_feature = imgui.checkbox("By feature", preferences.feature_colors)
        tip("Each feature is shown in the colour of its row")
        if switched:
            self._editor.prefer(preferences.changed(feature_colors=by_feature))
        held = slider(
            "Strength",
            100 * preferences.mask_opacity,
            5,
            100,
            default=40,
            hint="How much the mask covers the picture, per cent",
        )
        if held.value is not None:
            self._editor.prefer(preferences.changed(mask_opacity=held.value / 100), keep=held.done)
        elif held.done:
            self._editor.prefer(preferences)
