"""What helps to see what the warp does: the picture as it was over the result, and the legend of a heat map."""

import numpy as np
from imgui_bundle import ImVec2, imgui

from app.editor.editor import Editor
from app.model.spaces import screen_from_canvas
from app.render.scene import MarkColours
from app.ui.canvas.input import Area
from app.ui.widgets import theme
from app.ui.widgets.picture_texture import PictureTexture
from app.ui.widgets.theme import color, em, rgb

ONION = 0.5
"""How strongly the picture as it was lies over the result."""
WIDTH_EM, HEIGHT_EM, STEPS = 11.0, 0.7, 32
LEGENDS = {
    "scale": ("Lengths", ("½", "1", "2 ×")),
    "angle": ("Right angles off by", ("0°", "", "45°")),
    "area": ("Areas", ("¼", "1", "4 ×")),
}
"""By heat map, what it shows and what its left, middle and right stand for."""


def draw_onion(sheet: imgui.ImDrawList, editor: Editor, picture: PictureTexture, area: Area) -> None:
    """Lay the picture as it was over the result."""
    texture = picture.of(editor.document.image)
    if texture is None:
        return
    corners = np.array([[-0.5, -0.5], np.subtract(editor.document.size_px, 0.5)])
    low, high = (area.in_window(*place) for place in screen_from_canvas(editor.session.view, corners).tolist())
    tint = imgui.color_convert_float4_to_u32(rgb(0xFFFFFF, ONION))
    places = ImVec2(*low), ImVec2(*high)
    sheet.add_image(imgui.ImTextureRef(texture.texture), *places, ImVec2(0, 0), ImVec2(1, 1), tint)


def draw_legend(sheet: imgui.ImDrawList, heat: str, area: Area) -> None:
    """Draw what the colours of a heat map mean, in the lower left corner of the canvas."""
    title, marks = LEGENDS[heat]
    pad, line = em(0.6), imgui.get_font_size()
    left, bottom = area.x + em(1.0), area.y + area.height - em(1.0)
    high = 2 * pad + 2 * line + em(HEIGHT_EM + 0.6)
    sheet.add_rect_filled(
        (left, bottom - high), (left + em(WIDTH_EM) + 2 * pad, bottom), color(theme.LINE, 0.8), em(0.3)
    )
    x, y = left + pad, bottom - high + pad
    sheet.add_text(ImVec2(x, y), color(theme.TEXT), title)
    y += line + em(0.3)
    palette, step = MarkColours(), em(WIDTH_EM) / STEPS
    for number in range(STEPS):
        share = (number + 0.5) / STEPS
        value = share if heat == "angle" else 2 * share - 1
        red, green, blue, _ = palette.grown if value > 0 else palette.shrunk
        tone = imgui.color_convert_float4_to_u32(imgui.ImVec4(red, green, blue, abs(value)))
        sheet.add_rect_filled((x + number * step, y), (x + (number + 1) * step, y + em(HEIGHT_EM)), tone)
    y += em(HEIGHT_EM + 0.3)
    for text, share in zip(marks, (0.0, 0.5, 1.0), strict=True):
        width = imgui.calc_text_size(text).x
        sheet.add_text(ImVec2(x + share * (em(WIDTH_EM) - width), y), color(theme.TEXT), text)
