"""All that the window shows, frame by frame: menus, toolbar, canvas, panels, dialogs."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import cast

from imgui_bundle import ImVec2, hello_imgui, imgui

from app.actions import dropped
from app.actions.keys import Keys
from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.model.requests import Panel
from app.ui.barrier import FaultBarrier
from app.ui.canvas.canvas import CanvasWidget
from app.ui.canvas.input import Area, awaits_more
from app.ui.canvas.welcome import Welcome
from app.ui.canvas.whole_view import WholeView
from app.ui.dialogs.fault import FaultMessage
from app.ui.dialogs.palette import CommandPalette
from app.ui.dialogs.requested import Dialogs
from app.ui.dialogs.sheets import Sheet, Sheets
from app.ui.dialogs.tour_card import TourCard
from app.ui.docking import SIDE, add_bar, arrange_tabs, back_panels, find_central_area, find_column, find_front
from app.ui.menus import MenuBar
from app.ui.options_bar import HEIGHT_EM, OptionsBar
from app.ui.panels.features import FeaturesPanel
from app.ui.panels.handles import HandlesPanel
from app.ui.panels.history import HistoryPanel
from app.ui.panels.overlay import OverlayPanel
from app.ui.panels.preset_list import PresetList
from app.ui.panels.retexture import RetexturePanel
from app.ui.panels.space import SpacePanel
from app.ui.panels.thumbnails import Thumbnails
from app.ui.panels.timeline import TimelinePanel
from app.ui.panels.warp import WarpPanel
from app.ui.round_robin import RoundRobin
from app.ui.status_bar import StatusBar
from app.ui.toolbar import WIDTH_EM, draw_toolbar
from app.ui.widgets import theme
from app.ui.widgets.fallback_fonts import FallbackFonts
from app.ui.widgets.picture_texture import PictureTexture
from app.ui.widgets.theme import em
from app.ui.widgets.toasts import Toasts
from core import tracing
from core.document.document import Mode

LOWER_SIDE, BELOW, BEFORE = "LowerSide", "Below", "Before"
PANELS_EM, PANELS_SHARE = 19.0, 0.45
"""Least width of the panels, and how much of the window they take at most for it."""
FITTING_FRAMES = 4
"""How many frames Dear ImGui takes to lay out the panels."""
PANELS: dict[Mode, str] = {"warp": "Warp", "retexture": "Retexture", "overlay": "Overlay"}
"""Names of the panels by mode."""


class Workspace:
    """The parts of the window and the order in which a frame calls them."""

    def __init__(self, editor: Editor, *, welcomes: bool = False, wake: Callable[[], None] = lambda: None) -> None:
        self.editor = editor
        self.fonts = FallbackFonts(wake)
        self.toggle_full_screen: Callable[[], None] = lambda: None
        """Gives the window the whole screen, or takes it back; whoever has the window puts it here."""
        self.wait_s: float | None = None
        """Seconds until the window wants a frame without an event; None for never."""
        self.barrier = FaultBarrier(editor)
        """Where faults end."""
        self.round_robin = RoundRobin(editor)
        self.table = table = ActionTable(editor.tools)
        self.picture = PictureTexture()
        self.canvas = CanvasWidget(editor, table, self.picture)
        self.menus = MenuBar(editor, table)
        self.options_bar = OptionsBar(editor, table)
        self.status_bar = StatusBar(editor)
        self.thumbnails = Thumbnails(editor)
        self.space_panel = SpacePanel(editor, table)
        self.warp_panel = WarpPanel(editor, PresetList(self.thumbnails.of), self.space_panel)
        self.retexture_panel = RetexturePanel(editor, table)
        self.overlay_panel = OverlayPanel(editor, table)
        self.features_panel = FeaturesPanel(editor, table, self.picture)
        self.handles_panel = HandlesPanel(editor)
        self.history_panel = HistoryPanel(editor)
        self.timeline_panel = TimelinePanel(editor, table)
        self.dialogs = Dialogs(editor, self.show_panel, self.thumbnails.of_file)
        self.palette = CommandPalette(editor, table.actions)
        self.sheets = Sheets(editor, table)
        self.toasts = Toasts(editor)
        self.fault_message = FaultMessage(editor, self.barrier)
        self.tour = TourCard(editor)
        self.welcome = Welcome(editor, self.tour, shown=welcomes)
        self._whole_view = WholeView(editor)
        self._shown_picture: object = None
        self._fits_left = 0
        self._panels: frozenset[str] | None = None
        """Those that are shown; None before the first frame."""
        self._front: str | None = None
        """Which of the lower ones was in front when there were last several."""
        self._tabs_left = 0
        """Frames until the tabs of panels that have come are there."""
        self._scale = 1.0
        self._keys: tuple[str, Keys] = ("weft", ())
        self._room: tuple[float, float] | None = None
        """Width of the window and size of text when the panels were last given their width."""
        self._panels_em = self._given_px = 0.0
        """How wide the panels are to be where there is room, in ems, and how wide they last were made."""

    def set_up(self, params: hello_imgui.RunnerParams) -> None:
        """Put the parts into Hello ImGui's layout."""
        window = params.imgui_window_params
        window.default_imgui_window_type = hello_imgui.DefaultImGuiWindowType.provide_full_screen_dock_space
        window.show_menu_bar = True
        window.show_menu_app = window.show_menu_view = False
        window.show_status_bar = True
        window.show_status_fps = False
        window.remember_theme = False
        window.remember_status_bar_settings = False
        calls = params.callbacks
        calls.setup_imgui_style = theme.apply_style
        inside = self.barrier.drawing
        calls.show_menus = inside("draw the menus", self.menus.draw)
        status = inside("draw the status bar", self.status_bar.draw)
        calls.show_status = self.round_robin.drawing("draw the status bar", status, is_bar=True)
        bars = (
            ("left", "toolbar", lambda: draw_toolbar(self.editor, self.table), WIDTH_EM),
            ("top", "options", self.options_bar.draw, HEIGHT_EM),
        )
        for side, name, draw, size_em in bars:
            part = f"draw the {name}"
            add_bar(calls, side, self.round_robin.drawing(part, inside(part, draw), is_bar=True), size_em)
        self._dock(params.docking_params)

    def _dock(self, docking: hello_imgui.DockingParams) -> None:
        """Lay out the panels at the right."""
        docking.main_dock_space_node_flags = (
            imgui.DockNodeFlags_.passthru_central_node | imgui.DockNodeFlags_.no_docking_over_central_node
        )
        right, down = imgui.Dir.right, imgui.Dir.down
        docking.docking_splits = [
            hello_imgui.DockingSplit("MainDockSpace", SIDE, right, 0.235),
            hello_imgui.DockingSplit(SIDE, LOWER_SIDE, down, 0.42),
            hello_imgui.DockingSplit("MainDockSpace", BELOW, down, 0.25),
            hello_imgui.DockingSplit("MainDockSpace", BEFORE, imgui.Dir.left, 0.3),
        ]
        panels = (
            ("Warp", SIDE, self.warp_panel.draw),
            ("Retexture", SIDE, self.retexture_panel.draw),
            ("Overlay", SIDE, self.overlay_panel.draw),
            ("Handles", LOWER_SIDE, self.handles_panel.draw),
            ("Features", LOWER_SIDE, self.features_panel.draw),
            ("History", LOWER_SIDE, self.history_panel.draw),
            ("Timeline", BELOW, self.timeline_panel.draw),
        )
        windows = [
            hello_imgui.DockableWindow(
                name, side, self.round_robin.drawing(name, self.barrier.drawing(f"draw the panel {name}", draw))
            )
            for name, side, draw in panels
        ]
        # The views show the map, so they have no turn: each frame draws them.
        views = self.barrier.drawing("draw the panel In space", self.space_panel.draw_views)
        docking.dockable_windows = [*windows, hello_imgui.DockableWindow("In space", BEFORE, views)]
        for panel in docking.dockable_windows:
            panel.can_be_closed = False
            if panel.label == "In space":
                panel.imgui_window_flags = imgui.WindowFlags_.no_scrollbar | imgui.WindowFlags_.no_scroll_with_mouse
            panel.is_visible = panel.label not in ("Retexture", "Overlay", "Timeline", "In space")

    def show_panel(self, panel: Panel) -> None:
        """Show one of the window's own panels."""
        if panel == "palette":
            self.palette.open()
        elif panel == "history":
            hello_imgui.get_runner_params().docking_params.focus_dockable_window("History")
        elif panel == "full-screen":
            self.toggle_full_screen()
        elif panel in ("tour-warp", "tour-retexture", "tour-overlay"):
            self.tour.begin(cast("Mode", panel.removeprefix("tour-")))
        elif panel == "layout":
            hello_imgui.get_runner_params().docking_params.layout_reset = True
        else:
            self.sheets.shown = cast("Sheet", panel)

    def drop(self, paths: Sequence[Path]) -> None:
        """Take the first of the files dropped on the window."""
        if paths:
            self.barrier.run("take a dropped file", lambda: dropped.take(self.editor, paths[0]))

    def begin_frame(self) -> None:
        """Take the input and let the editor act on it."""
        self.barrier.frame += 1
        self.barrier.run("lay out the window", self._lay_out)
        self.barrier.run("do what mouse and keys asked for", self.canvas.take_input)
        with tracing.span("update"):
            self.barrier.run("bring the picture up to date", self.editor.update)
        self.barrier.run("choose the panels", self._show_mode)
        self.barrier.run("show the picture whole", self._fit_new_picture)
        self.barrier.run("draw the small pictures", self.thumbnails.begin_frame)
        self.barrier.run("choose whose turn it is", self.round_robin.begin_frame)

    def _lay_out(self) -> None:
        """Give the panels and the canvas their places."""
        self._take_scale()
        self._widen_panels()
        self.canvas.lay_out(find_central_area(), is_whole=self._whole_view.is_whole)

    def _take_scale(self) -> None:
        """Draw text and controls at the size that the artist prefers, and take the keys that are wished for."""
        keys = self.editor.preferences.key_preset, self.editor.preferences.keys
        if self._keys != keys:
            self._keys = keys
            self.table.set_keys(*keys)
        if self._scale != self.editor.preferences.scale:
            self._scale = self.editor.preferences.scale
            theme.apply_style(hello_imgui.dpi_window_size_factor() * self._scale)
            imgui.get_style().font_scale_main = self._scale

    def _widen_panels(self) -> None:
        """Keep the panels as wide as their controls need, in a window that is wide enough for it."""
        room, column = (imgui.get_io().display_size.x, em(1)), find_column()
        if column is None:
            return
        if abs(column.size_ref.x - self._given_px) >= 1:  # the artist has, or the first layout
            self._panels_em = column.size_ref.x / (em(1) if self._room is None else self._room[1])
            self._given_px = column.size_ref.x
        if room == self._room:
            return
        self._room = room
        self._given_px = min(max(em(self._panels_em), em(PANELS_EM)), room[0] * PANELS_SHARE)
        imgui.internal.dock_builder_set_node_size(column.id_, ImVec2(self._given_px, column.size_ref.y))

    def _show_mode(self) -> None:
        """Show the panels of the mode."""
        session = self.editor.session
        in_warp = session.mode == "warp"
        shown = {name: mode == session.mode for mode, name in PANELS.items()}
        shown |= {"Handles": in_warp, "Features": in_warp, "History": True, "Timeline": in_warp and session.timeline}
        shown["In space"] = in_warp and self.editor.document.surface is not None
        self.space_panel.is_refining &= shown["In space"] and session.panels
        for panel in hello_imgui.get_runner_params().docking_params.dockable_windows:
            panel.is_visible = shown[panel.label] and session.panels
        self._keep_tabs(frozenset(name for name in shown if shown[name] and session.panels))
        back_panels()

    def _keep_tabs(self, panels: frozenset[str]) -> None:
        """Let panels that come back have their places among the tabs, and the one in front that was."""
        if panels != self._panels:
            self._tabs_left = FITTING_FRAMES
            self._panels, self._front = panels, find_front("History") or self._front
        elif self._tabs_left:
            self._tabs_left -= 1
            if not self._tabs_left:
                arrange_tabs("History", self._front)

    def end_frame(self) -> None:
        """Draw what belongs to this frame's map."""
        area, draw = self.canvas.area, self.barrier.draw
        draw("draw what lies over the picture", self.canvas.draw)
        draw("draw the welcome", lambda: self.welcome.draw(area))
        draw("lead the tour", lambda: self._lead_tour(area))
        draw("draw the palette", self.palette.draw, failed=_close_popups)
        draw("draw the sheet", self.sheets.draw, failed=self._close_sheet)
        dialog = draw("draw the dialog", self.dialogs.draw, failed=self._close_dialog)
        if not self.round_robin.keeps_any:
            draw("look for fonts", self.fonts.look)
        draw("draw the message of a fault", lambda: self.fault_message.draw(area))
        waits = [dialog, draw("draw the messages", lambda: self.toasts.draw(area)), self.editor.wait_s]
        waits.append(None if self.thumbnails.is_complete else 0.0)
        waits.append(0.0 if self._tabs_left or awaits_more() else None)
        self.wait_s = min((wait for wait in waits if wait is not None), default=None)

    def _lead_tour(self, area: Area) -> None:
        self.tour.update(self.dialogs.title)
        self.tour.draw(area)

    def _close_sheet(self) -> None:
        self.sheets.shown = None
        _close_popups()

    def _close_dialog(self) -> None:
        self.dialogs.close()
        _close_popups()

    def _fit_new_picture(self) -> None:
        """Show a picture whole when it is opened; again while the panels still come to their places."""
        if self.editor.history is not self._shown_picture:
            self._shown_picture, self._fits_left = self.editor.history, FITTING_FRAMES
        if self._fits_left > 0:
            self._fits_left -= 1
            self.table.run("view.fit", self.editor)
        self._whole_view.update()


def _close_popups() -> None:
    """Close whatever lies over the window, for nothing draws it any more."""
    if imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level):
        imgui.internal.close_popup_to_level(0, True)
