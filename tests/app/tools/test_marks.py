from app.model.shapes import Bezier, Circle
from app.tools.marks import marks
from core.document.document import Outline
from tests.app.driver import EditorDriver


def roles(drive: EditorDriver) -> set[str]:
    return {shape.role for shape in marks(drive.editor)}


def test_handles_of_other_tools_stay_in_sight() -> None:
    drive = EditorDriver().tool("pins").click(60, 50).tool("curves").click(40, 90).click(100, 90).key("enter")
    drive.editor.edit("Set outline", drive.document.changed(outline=Outline.straight()))
    drive.tool("brush").move(20, 20)
    assert roles(drive) == {"outline", "target", "pin-rest", "brush", "brush-core"}
    assert {"pin-selected"} <= roles(drive.tool("pins"))


def test_overlays_switch_them() -> None:
    drive = EditorDriver().tool("pins").click(60, 50).tool("hand")
    drive.editor.edit("Set outline", drive.document.changed(outline=Outline.straight()))
    shown = marks(drive.editor)
    assert any(isinstance(shape, Circle) for shape in shown)
    assert any(isinstance(shape, Bezier) for shape in shown)
    drive.editor.show(overlays=drive.editor.session.overlays.__class__(handles=False, outline=False))
    assert marks(drive.editor) == []


def test_a_held_hand_hides_nothing() -> None:
    drive = EditorDriver().tool("pins").click(60, 50)
    drive.key("space")
    assert drive.editor.tool.name == "hand"
    assert "pin-selected" in roles(drive)


def test_no_outline_lies_beside_the_edge_that_a_preset_bends() -> None:
    drive = EditorDriver()
    drive.editor.edit("Bend", drive.document.with_warp(preset="arc", bend=90))
    assert "outline" not in roles(drive.tool("pins"))
    assert "outline" in roles(drive.tool("outline"))
