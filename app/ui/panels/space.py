"""The page of the Warp panel that lays the picture on a surface in space, and the panel that shows it there."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.files.surface_files import choose_shape
from app.model.orbit import Orbit
from app.render.surface_view import Laid, SurfaceViews
from app.ui.widgets import theme
from app.ui.widgets.action_buttons import action_button
from app.ui.widgets.controls import faint, section, segments
from app.ui.widgets.sliders import slider
from app.ui.widgets.theme import em
from core.surfaces.shapes import SHAPES
from core.surfaces.surface import Surface

DEGREES_PER_EM = 12.0
"""How far the camera goes around for a drag so long."""
MOST_TILT_DEG = 89.0
ZOOMS = 0.5, 8.0
ZOOM_STEP = 1.15
COLUMNS = 3
VIEWS = ("Plain", "Features kept")
TITLE_EM = 1.6
"""Height of a view's title."""
ABOUT = (
    "The canvas shows the surface laid flat with its angles kept. What is painted keeps its shape there, "
    "and so it does on the surface. Export writes the texture."
)


class SpacePanel:
    """Draws the page, and the panel with the surface once by plain texture mapping and once with features kept."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._editor, self._table = editor, table
        self._views: SurfaceViews | None = None
        self._number: float | None = None
        """What the slider says while it is held."""
        self._turning: Orbit | None = None
        """Where the camera was when the drag that turns it began."""
        self.is_refining = False
        """Whether another frame makes what the panel shows better."""

    def attach(self, views: SurfaceViews) -> None:
        """Begin to draw, in the context of the window."""
        self._views = views

    def close(self) -> None:
        """Free what is on the GPU."""
        if self._views is not None:
            self._views.release()
        self._views = None

    def draw(self) -> None:
        """Draw the choice of a surface, and its number."""
        editor, surface = self._editor, self._editor.document.surface
        # A mesh has no number, and may be called as a shape is.
        shape = surface.name if surface is not None and surface.number is not None else ""
        if section("Surface"):
            for row in range(0, len(SHAPES), COLUMNS):
                names = tuple(SHAPES)[row : row + COLUMNS]
                choices = tuple((name, name.capitalize(), f"Lay the picture on a {name}") for name in names)
                chosen = segments(f"shapes{row}", choices, shape)
                if chosen is not None:
                    choose_shape(editor, chosen)
            for name in ("surface.open", "surface.remove", "surface.export_view"):
                action_button(editor, self._table.by_name[name])
        if surface is not None:
            self._draw_number(surface)
            faint(ABOUT if shape else f"On the mesh {surface.name}. {ABOUT}")

    def _draw_number(self, surface: Surface) -> None:
        shape = SHAPES.get(surface.name)
        if shape is None or surface.number is None:
            return
        shown = surface.number if self._number is None else self._number
        bounds, hint = (shape.least, shape.most), shape.number.capitalize()
        held = slider("Proportion", shown, *bounds, default=shape.usual, digits=2, logarithmic=bounds[0] > 0, hint=hint)
        if held.value is not None:
            self._number = held.value
        if held.done and self._number is not None:
            choose_shape(self._editor, surface.name, self._number)
            self._number = None

    def draw_views(self) -> None:
        """Draw both views, beside or below one another by the room; a drag turns them, the wheel brings them nearer.

        What takes its time, one does after the other and after the canvas, each in frames of its own, but for drafts
        in a drag.
        """
        answer, surface = self._editor.map, self._editor.document.surface
        self.is_refining = False
        if surface is None or self._views is None or answer.document.surface is not surface:
            return
        room, gap, high = imgui.get_content_region_avail(), em(0.4), em(TITLE_EM)
        beside, below = min((room.x - gap) / 2, room.y - high), min(room.x, (room.y - gap) / 2 - high)
        side = max(beside, below, em(4))
        step = ImVec2(side + gap, 0) if beside > below else ImVec2(0, high + side + gap)
        start, waits = imgui.get_cursor_pos(), self._views.gets_better()
        for number, (title, moved) in enumerate(zip(VIEWS, (answer.plain, answer.warped), strict=True)):
            imgui.set_cursor_pos(ImVec2(start.x + number * step.x, start.y + number * step.y))
            imgui.begin_group()
            faint(title)
            waits |= self._draw_view(
                title, Laid(surface, answer.rest, moved, answer.document.canvas_px), side, waits=waits
            )
            imgui.end_group()

    def _draw_view(self, title: str, laid: Laid, side: float, *, waits: bool) -> bool:
        """Draw a view; return whether that took its time."""
        assert self._views is not None
        editor, pixels = self._editor, round(side * imgui.get_io().display_framebuffer_scale.x)
        desk = theme.rgb(theme.SUNKEN)
        view = self._views.view(title, (pixels, pixels))
        texture = view.draw(
            laid,
            self._views.source(editor.document.image),
            editor.session.orbit,
            (desk.x, desk.y, desk.z, 1.0),
            draft=editor.is_busy,
            frame_s=self._views.frame_s,
            waits=waits,
        )
        self.is_refining |= view.is_refining
        at = imgui.get_cursor_screen_pos()
        imgui.invisible_button(title, ImVec2(side, side))
        picture = imgui.ImTextureRef(texture.glo)
        imgui.get_window_draw_list().add_image(
            picture, at, ImVec2(at.x + side, at.y + side), ImVec2(0, 1), ImVec2(1, 0)
        )
        self._turn()
        return view.has_drawn

    def _turn(self) -> None:
        """Move the camera by what the pointer does on the view that was drawn last."""
        editor, io = self._editor, imgui.get_io()
        if imgui.is_item_activated():
            self._turning = editor.session.orbit
        if imgui.is_item_active() and self._turning is not None:
            by = imgui.get_mouse_drag_delta(0, 0.0)
            tilt = self._turning.tilt_deg + by.y / em(1) * DEGREES_PER_EM
            orbit = replace(
                editor.session.orbit,
                turn_deg=(self._turning.turn_deg - by.x / em(1) * DEGREES_PER_EM + 180) % 360 - 180,
                tilt_deg=min(max(tilt, -MOST_TILT_DEG), MOST_TILT_DEG),
            )
            editor.show(orbit=orbit)
        if imgui.is_item_deactivated():
            self._turning = None
        if imgui.is_item_hovered():
            if io.mouse_wheel:
                zoom = min(max(editor.session.orbit.zoom * ZOOM_STEP**io.mouse_wheel, ZOOMS[0]), ZOOMS[1])
                editor.show(orbit=replace(editor.session.orbit, zoom=zoom))
            if imgui.is_mouse_double_clicked(0):
                editor.show(orbit=Orbit())
                self._turning = None
