"""Every setting at either end of its range: what is drawn over the picture is there, and the tools act."""

import numpy as np
import pytest

from app.tools.all import TOOLS
from app.tools.marks import marks
from app.tools.outline import ring_on_screen
from core.document.document import Outline
from core.warps.presets import BEND, HORIZONTAL, PRESETS, VERTICAL, Parameter
from tests.app.driver import EditorDriver, document

WARP_TOOLS = [tool.name for tool in TOOLS.values() if "warp" in tool.modes]


def ends() -> list[tuple[str, str, float]]:
    """Return every preset with each of its parameters at either end."""
    return [
        (preset, parameter.name, value)
        for preset, row in PRESETS.items()
        for parameter in (BEND, HORIZONTAL, VERTICAL, *row.settings)
        for value in _values(parameter)
    ]


def _values(parameter: Parameter) -> tuple[float, float]:
    return parameter.low, parameter.high


def with_setting(drive: EditorDriver, preset: str, name: str, value: float) -> None:
    warp = (
        {"bend": value}
        if name == "bend"
        else {name: value}
        if name in ("horizontal", "vertical")
        else {"values": {name: value}}
    )
    drive.editor.edit("Setting", drive.document.with_warp(**{"preset": preset, "values": {}} | warp))
    drive.frame()


@pytest.mark.parametrize(("preset", "name", "value"), ends())
def test_tools_stay_usable_at_the_end_of_a_slider(preset: str, name: str, value: float) -> None:
    drive = EditorDriver(document(60, 40, cell_px=10.0))
    with_setting(drive, preset, name, value)
    for tool in WARP_TOOLS:
        drive.tool(tool)
        marks(drive.editor)
        drive.move(30, 20)
        marks(drive.editor)
        drive.drag((0, 0), (8, 6), (12, 9)).key("escape")
        marks(drive.editor)
    assert np.isfinite(drive.editor.answer.warped).all()


def test_an_outline_without_a_map_is_that_of_the_picture_on_the_screen() -> None:
    drive = EditorDriver(document(60, 40, cell_px=10.0)).tool("outline")
    with_setting(drive, "perspective", "top-left-x", 40.0)
    good = ring_on_screen(drive.editor)
    with_setting(drive, "perspective", "top-left-x", 100.0)
    assert drive.editor.fault is not None
    np.testing.assert_array_equal(ring_on_screen(drive.editor), good)


def test_a_document_that_never_had_a_map_has_a_straight_outline() -> None:
    bad = document(60, 40, cell_px=10.0).with_warp(preset="perspective", values={"top-left-x": 100.0})
    drive = EditorDriver(bad).tool("outline")
    straight = Outline.straight().ring * (60, 40) - 0.5
    np.testing.assert_allclose(ring_on_screen(drive.editor)[:-1], straight)
