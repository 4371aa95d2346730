"""The look: colours, spacing and fonts. Every length is in ems, so that all of it follows the display's scale."""

from functools import cache, lru_cache

from imgui_bundle import ImVec2, ImVec4, hello_imgui, icons_fontawesome_6, imgui

TEXT_PX = 15.0
SMALL_PX = 12.5
TITLE_PX = 26.0


@lru_cache(maxsize=512)
def rgb(code: int, alpha: float = 1.0) -> ImVec4:
    """Return the colour 0xRRGGBB with `alpha`."""
    return ImVec4((code >> 16 & 255) / 255, (code >> 8 & 255) / 255, (code & 255) / 255, alpha)


DESK = 0x17181A
"""Behind the picture."""
PANEL = 0x222428
RAISED = 0x2B2E33
SUNKEN = 0x191A1D
BUTTON = 0x33373D
BUTTON_HOVERED = 0x3E434A
LINE = 0x121315
EDGE = 0x3A3E45
TEXT = 0xE3E5E8
FAINT = 0x9BA1A9
DISABLED = 0x7C828A
ACCENT = 0xF0A63C
"""Saffron: what is chosen, held or on."""
ACCENT_BRIGHT = 0xFFBD5C
ON_ACCENT = 0x1E1609
TARGET = 0x5CC8E8
"""Where things go, beside where they are."""
FAULT = 0xF26D63
MASK = 0xF53B57
"""Over what keeps its shape."""
FOLD = 0xFF1FC7
GOOD = 0x6FC78E
GIVEN_UP = 0x8A9099
"""Over a feature that does not keep its shape."""
FEATURES = (
    *(0xF53B57, 0x3BA7F5, 0x59C94B, 0xF5A623, 0xA86BF0, 0x21C6B5),
    *(0xF06BB8, 0xC9C12B, 0x5A78F0, 0xF0763B, 0x2FB7D6, 0x9ED13B),
)
"""Over features."""


def feature_code(color: int, *, kept: bool = True) -> int:
    """Return a colour of features, 0xRRGGBB, by its number from 1."""
    return FEATURES[color - 1] if kept else GIVEN_UP


@lru_cache(maxsize=512)
def color(code: int, alpha: float = 1.0) -> int:
    """Return the packed colour that draw lists take."""
    return imgui.color_convert_float4_to_u32(rgb(code, alpha))


def em(count: float) -> float:
    """Return `count` ems in screen pixels."""
    return hello_imgui.em_size(count)


def unit() -> float:
    """Return how many pixels of the window one is that the artist's text size and the display make larger."""
    return em(1.0) / TEXT_PX


def ems(x: float, y: float) -> ImVec2:
    """Return a size of (x, y) ems in screen pixels."""
    return hello_imgui.em_to_vec2(x, y)


@cache
def icon(name: str) -> str:
    """Return the Font Awesome 6 glyph called `name`, "paintbrush" or "arrow-pointer"; what has none stands as it is."""
    code = f"ICON_FA_{name.upper().replace('-', '_')}"
    glyph: str = getattr(icons_fontawesome_6, code, name)
    return glyph


def load_fonts() -> None:
    """Load Roboto with the icons merged in."""
    hello_imgui.load_font_ttf_with_font_awesome_icons("fonts/Roboto/Roboto-Regular.ttf", TEXT_PX)


def apply_style(scale: float = 1.0) -> None:
    """Set Dear ImGui's style at a scale; Hello ImGui scales what it begins with to the display."""
    style = imgui.get_style()
    _set_shapes(style)
    style.scale_all_sizes(scale)
    for name, (code, alpha) in _COLORS.items():
        style.set_color_(int(getattr(imgui.Col_, name)), rgb(code, alpha))


def _set_shapes(style: imgui.Style) -> None:
    """Set paddings, roundings and borders, in pixels of a display at scale 1."""
    style.window_padding = ImVec2(12, 10)
    style.frame_padding = ImVec2(8, 4)
    style.item_spacing = ImVec2(8, 6)
    style.item_inner_spacing = ImVec2(6, 4)
    style.cell_padding = ImVec2(6, 3)
    style.indent_spacing = 16
    style.scrollbar_size = 11
    style.grab_min_size = 10
    style.window_border_size = 0
    style.child_border_size = 0
    style.popup_border_size = 1
    style.frame_border_size = 0
    style.tab_border_size = 0
    style.window_rounding = 6
    style.child_rounding = 4
    style.popup_rounding = 6
    style.frame_rounding = 4
    style.scrollbar_rounding = 6
    style.grab_rounding = 4
    style.tab_rounding = 4
    style.tab_bar_border_size = 0
    style.tab_bar_overline_size = 2
    style.docking_separator_size = 2
    style.separator_text_border_size = 1
    style.window_menu_button_position = imgui.Dir.none
    style.window_title_align = ImVec2(0.5, 0.5)
    style.hover_stationary_delay = 0.12
    style.hover_delay_short = 0.12
    style.hover_delay_normal = 0.4
    style.disabled_alpha = 0.45


_COLORS: dict[str, tuple[int, float]] = {
    "text": (TEXT, 1),
    "text_disabled": (DISABLED, 1),
    "text_selected_bg": (ACCENT, 0.35),
    "text_link": (TARGET, 1),
    "input_text_cursor": (ACCENT, 1),
    "window_bg": (PANEL, 0),
    "child_bg": (PANEL, 0),
    "popup_bg": (RAISED, 0.99),
    "border": (EDGE, 1),
    "border_shadow": (LINE, 0),
    "frame_bg": (SUNKEN, 1),
    "frame_bg_hovered": (SUNKEN, 0.7),
    "frame_bg_active": (SUNKEN, 1),
    "title_bg": (LINE, 1),
    "title_bg_active": (LINE, 1),
    "title_bg_collapsed": (LINE, 1),
    "menu_bar_bg": (PANEL, 0),
    "scrollbar_bg": (PANEL, 0),
    "scrollbar_grab": (BUTTON, 1),
    "scrollbar_grab_hovered": (BUTTON_HOVERED, 1),
    "scrollbar_grab_active": (FAINT, 1),
    "check_mark": (ACCENT, 1),
    "slider_grab": (FAINT, 1),
    "slider_grab_active": (ACCENT, 1),
    "button": (BUTTON, 1),
    "button_hovered": (BUTTON_HOVERED, 1),
    "button_active": (EDGE, 1),
    "header": (BUTTON, 0.8),
    "header_hovered": (BUTTON_HOVERED, 0.8),
    "header_active": (BUTTON_HOVERED, 1),
    "separator": (LINE, 1),
    "separator_hovered": (ACCENT, 0.6),
    "separator_active": (ACCENT, 1),
    "resize_grip": (EDGE, 0),
    "resize_grip_hovered": (ACCENT, 0.5),
    "resize_grip_active": (ACCENT, 0.9),
    "tab": (LINE, 1),
    "tab_hovered": (BUTTON_HOVERED, 1),
    "tab_selected": (PANEL, 1),
    "tab_selected_overline": (ACCENT, 1),
    "tab_dimmed": (LINE, 1),
    "tab_dimmed_selected": (PANEL, 1),
    "tab_dimmed_selected_overline": (EDGE, 1),
    "docking_preview": (ACCENT, 0.4),
    "docking_empty_bg": (DESK, 0),
    "plot_histogram": (ACCENT, 1),
    "table_header_bg": (SUNKEN, 1),
    "table_border_strong": (LINE, 1),
    "table_border_light": (LINE, 0.6),
    "table_row_bg": (PANEL, 0),
    "table_row_bg_alt": (RAISED, 0.5),
    "drag_drop_target": (ACCENT, 1),
    "nav_cursor": (ACCENT, 0.8),
    "modal_window_dim_bg": (LINE, 0.6),
}
