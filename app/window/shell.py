"""The window: GL context, frame loop, file drops. Nothing outside its folder knows GLFW.

A frame is drawn when there is a reason: input, a job's result (`wake`), or something on the screen that is to change
by itself. Between frames the loop sleeps in GLFW.
"""

import math
import os
import sys
import threading
import warnings
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import glfw
import platformdirs
from imgui_bundle import glfw_utils, hello_imgui, imgui

from app.editor.editor import Editor
from app.files import document_io
from app.model.events import Modifiers
from app.render import gpu
from app.render.programs import programs_of
from app.render.renderer import Renderer
from app.render.scene import CanvasScene
from app.render.surface_view import SurfaceViews
from app.ui.canvas.scene import Motion, scene_of
from app.ui.widgets import theme
from app.ui.widgets.emblem import emblem
from app.ui.workspace import Workspace
from app.window import context_loss
from app.window.frame_rhythm import FrameRhythm
from app.window.full_screen import FullScreen
from app.window.interruptions import interruptions
from app.window.late_imports import load_rest
from core import tracing
from core.arrays import WeftError
from core.imaging.hushed import hush

ICON_PX = 64
NO_OPENGL = (
    "no window: it needs OpenGL 3.3, and this display offers less; "
    "newer graphics drivers help, or LIBGL_ALWAYS_SOFTWARE=1, which draws without them"
)
LEAST_PX = (640, 400)
"""The window cannot be made smaller than this."""
MODIFIERS = range(glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SUPER + 1)
LAYOUT_FRAMES = 3
"""So many frames at the start lay out the panels; the picture is drawn once its place is known."""
DRAWING_S = 0.011
"""What drawing the picture may take of a frame; the panels, the map and the window's own work take as much again."""
SWITCH_S = 0.0005
"""How long a job may keep the interpreter to itself while the window waits for it."""
DOUBLE_CLICK_S = 0.45
"""Two clicks make a double click up to so far apart; a slow machine needs a frame between them."""


def wake() -> None:
    """Make the loop draw a frame; may be called from any thread."""
    glfw.post_empty_event()


def has_display() -> bool:
    """Return whether a window can be opened."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", glfw.GLFWError)
        return bool(glfw.init())


def show(editor: Editor, *, welcomes: bool = False) -> None:
    """Show the editor in a window until it is closed; in a new one where the driver loses the first one's context.

    Raises what `Shell.run` does.
    """
    shell = Shell(editor, welcomes=welcomes)
    try:
        while not shell.run():
            if editor.recovery is not None:
                editor.recovery.hurry()
            editor.notify("The graphics driver was reset; the window is open again, and nothing is lost")
            shell = Shell(editor)
    finally:
        editor.jobs.close()


def _set_hints() -> None:
    """Let the next window have colours only: clearing what nothing is drawn with takes its time too."""
    glfw.init()
    context_loss.ask_to_be_told()
    glfw.window_hint(glfw.DEPTH_BITS, 0)
    glfw.window_hint(glfw.STENCIL_BITS, 0)


def _settings_folder() -> Path | None:
    """Return the folder of the user's settings, made at need; None where it cannot be made."""
    try:
        return Path(platformdirs.user_config_dir("weft", ensure_exists=True))
    except OSError:
        return None


class Shell:
    """The editor in a window."""

    def __init__(
        self, editor: Editor, *, keeps_settings: bool = True, welcomes: bool = False, draws: bool = True
    ) -> None:
        gpu.let_go()
        _set_hints()
        self.editor = editor
        self.workspace = Workspace(editor, welcomes=welcomes, wake=wake)
        self.params = self._params(keeps_settings=keeps_settings)
        self._draws = draws
        """Whether the picture is drawn at all: to see what a frame takes without it, the draw calls can be left out."""
        self.frames = 0
        """How many frames were drawn."""
        self._rhythm = FrameRhythm(LAYOUT_FRAMES)
        self.title = ""
        """What the window is called: the document, with a star while it is not saved."""
        self._motion = Motion()
        self._scene: CanvasScene | None = None
        """What was drawn last."""
        self._is_lost = False
        self._frame = ExitStack()  # holds the span of the frame that is being drawn

    @property
    def is_drawn(self) -> bool:
        """Whether the canvas shows the last frame's scene at its best, or as well as it is to while something moves."""
        refines = self._renderer.is_refining or self.workspace.space_panel.is_refining
        return not refines and self._motion.wait_s is None

    def run(self) -> bool:
        """Show the window until it is closed, and return True, or until its OpenGL context is lost, and return False.

        Raises `KeyboardInterrupt` when a signal ended it, and `WeftError` where the display has not the OpenGL that a
        window needs.
        """
        render = hello_imgui.manual_render
        try:
            with hush():  # GLFW says to the terminal what the message says
                render.setup_from_runner_params(self.params)
        except Exception as fault:
            raise WeftError(NO_OPENGL) from fault
        switch_before = sys.getswitchinterval()
        sys.setswitchinterval(SWITCH_S)
        try:
            with interruptions(wake) as interrupted:
                while not (self.params.app_shall_exit or interrupted.is_set() or self._is_lost):
                    self._wait()
                    render.render()
        finally:
            sys.setswitchinterval(switch_before)
            render.tear_down()
        if interrupted.is_set():
            raise KeyboardInterrupt
        return not self._is_lost

    def _params(self, *, keeps_settings: bool) -> hello_imgui.RunnerParams:
        params = hello_imgui.RunnerParams()
        window = params.app_window_params
        window.window_title = "Weft"
        window.window_geometry.size = (1440, 900)
        window.restore_previous_geometry = keeps_settings
        params.renderer_backend_options.open_gl_options.anti_aliasing_samples = 0
        params.fps_idling.enable_idling = False
        folder = _settings_folder() if keeps_settings else None
        params.ini_disable = folder is None
        if folder is not None:
            params.ini_folder_type = hello_imgui.IniFolderType.absolute_path
            params.ini_filename = str(folder / "window.ini")
            params.ini_filename_use_app_window_title = False
        calls = params.callbacks
        calls.default_icon_font = hello_imgui.DefaultIconFont.font_awesome6
        calls.load_additional_fonts = theme.load_fonts
        calls.pre_new_frame = self.workspace.fonts.join
        calls.post_init_add_platform_backend_callbacks = self._listen
        calls.post_init = self._attach
        calls.post_new_frame = self._begin_frame
        calls.before_imgui_render = self.workspace.end_frame
        calls.custom_background = self._draw_picture
        calls.after_swap = self._end_frame
        calls.confirm_exit = self.may_close
        calls.before_exit = self._detach
        self.workspace.set_up(params)
        return params

    def _listen(self) -> None:
        """Hear of the window's events before Dear ImGui does, which chains to what is set here."""
        self._window = glfw_utils.glfw_window_hello_imgui()
        self.workspace.toggle_full_screen = FullScreen(self._window).toggle
        glfw.set_window_size_limits(self._window, *LEAST_PX, glfw.DONT_CARE, glfw.DONT_CARE)
        for listen in (
            glfw.set_mouse_button_callback,
            glfw.set_scroll_callback,
            glfw.set_char_callback,
            glfw.set_window_focus_callback,
            glfw.set_cursor_enter_callback,
        ):
            listen(self._window, self._stir)
        glfw.set_cursor_pos_callback(self._window, self._hear_pointer)
        glfw.set_key_callback(self._window, self._hear_key)
        icon = emblem(ICON_PX)
        glfw.set_window_icon(self._window, 1, [(ICON_PX, ICON_PX, icon.tolist())])  # type: ignore[list-item]  # or rows of pixels
        glfw.set_drop_callback(self._window, self._drop)  # type: ignore[arg-type]  # the wrapper hands over a list

    def _hear_pointer(self, window: object, x: float, y: float) -> None:
        self.workspace.canvas.hear_pointer(x, y)
        self._stir()

    def _hear_key(self, window: object, key: int, code: int, action: int, mods: int) -> None:
        if action == glfw.PRESS and key not in MODIFIERS:
            ctrl = bool(mods & (glfw.MOD_CONTROL | glfw.MOD_SUPER))
            self.workspace.canvas.hear_key(
                Modifiers(shift=bool(mods & glfw.MOD_SHIFT), ctrl=ctrl, alt=bool(mods & glfw.MOD_ALT))
            )
        self._stir()

    def _stir(self, *_: object) -> None:
        """Draw a few frames, since something was done to the window."""
        self._rhythm.stir()

    def _attach(self) -> None:
        """Take the GL context, once it is there."""
        imgui.get_io().mouse_double_click_time = DOUBLE_CLICK_S
        self._context = gpu.attach()
        self._reset_status = context_loss.reset_status()
        programs_of(self._context).draws = self._draws
        frame_s = DRAWING_S if self._draws else math.inf
        self._renderer = Renderer(self._context, frame_s=frame_s)
        self.workspace.thumbnails.attach(self._context, self._renderer)
        self.workspace.picture.attach(self._context)
        self.workspace.space_panel.attach(
            SurfaceViews(self._context, self._renderer.sources, frame_s, lambda: self._renderer.is_refining)
        )

    def _detach(self) -> None:
        """Free what is on the GPU while the context is there."""
        self.workspace.thumbnails.close()
        self.workspace.picture.close()
        self.workspace.space_panel.close()
        self._renderer.release()

    def _begin_frame(self) -> None:
        self.frames += 1
        self._frame.enter_context(tracing.span("frame"))
        self._show_title()
        self.workspace.begin_frame()
        if self.editor.is_closing:
            self.params.app_shall_exit = True

    def _draw_picture(self) -> None:
        """Draw the picture behind the panels."""
        panel, io, area = theme.rgb(theme.PANEL), imgui.get_io(), self.workspace.canvas.area
        if self._draws:
            self._context.screen.clear(panel.x, panel.y, panel.z)
        ratio = io.display_framebuffer_scale.y
        below = io.display_size.y - area.y - area.height
        left, bottom, width, height = (round(side * ratio) for side in (area.x, below, area.width, area.height))
        place = left, bottom, width, height
        with tracing.span("canvas"):
            self._draw_behind(ratio, place)
        self.editor.live.look_ahead()

    def _draw_behind(self, ratio: float, place: gpu.Rectangle) -> None:
        """Draw the present picture, or the last one where that fails."""
        barrier = self.workspace.barrier
        if not barrier.run("draw the picture", lambda: self._draw_scene(ratio, place)) and self._scene is not None:
            scene = replace(self._scene, view=self.editor.session.view)
            barrier.run("draw the picture as it was", lambda: self._renderer.draw(scene, place))

    def _draw_scene(self, ratio: float, place: tuple[int, int, int, int]) -> bool:
        """Draw the present picture and keep what was drawn, for frames in which that fails; return True."""
        self._motion.update(self.editor)
        if self.frames > LAYOUT_FRAMES:
            scene = scene_of(self.editor, ratio * self.editor.session.view.unit, self._motion)
            self._renderer.draw(scene, place)
            self._scene = scene
        return True

    def _end_frame(self) -> None:
        self._frame.close()
        self._is_lost = self._reset_status() != context_loss.NO_ERROR
        if self.frames == LAYOUT_FRAMES + 1:
            threading.Thread(target=load_rest, name="imports", daemon=True).start()

    def _show_title(self) -> None:
        star = "" if self.editor.history.is_saved else "*"
        title = f"{star}{self.editor.name} – Weft"
        if title != self.title:
            self.title = title
            glfw.set_window_title(self._window, title)

    def _drop(self, window: object, paths: list[str]) -> None:
        """Open the first of the files dropped on the window."""
        self.workspace.drop([Path(path) for path in paths])

    def may_close(self) -> bool:
        """Return whether the window may close now; otherwise ask first."""
        self.workspace.barrier.run("close the window", lambda: document_io.quit_editor(self.editor))
        return self.editor.is_closing

    def _wait(self) -> None:
        """Sleep until there is a reason to draw."""
        refines = [0.0] if self._renderer.is_refining or self.workspace.space_panel.is_refining else []
        self._rhythm.wait([self.workspace.wait_s, self._motion.wait_s, *refines])
