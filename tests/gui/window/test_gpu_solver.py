"""A drag on a large grid, answered by the GPU in the real window."""

import numpy as np
import pytest

import app.live.warp
from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.render.solver.choice import GpuSolver
from app.render.solver.grid_multigrid import GridMultigrid, NodeLoad
from app.state.preferences import Preferences
from app.tools.all import TOOLS
from core.arrays import Bools
from core.document.map_solver import MapSolver
from core.linalg.cubic_convolution import Complexes
from core.linalg.grid_solver import Onto
from core.progress import run
from core.rasters.raster import Raster
from tests.app.driver import document
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


def test_a_pin_is_dragged_on_the_gpu_and_settles_on_the_processor(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app.live.warp, "INLINE_NODES", 0)
    place, answers = GridMultigrid.place, []

    def counted(solver: GridMultigrid, y: NodeLoad, onto: Onto) -> tuple[Complexes, Bools]:
        answers.append(solver)
        return place(solver, y, onto)

    monkeypatch.setattr(GridMultigrid, "place", counted)
    mask = np.zeros((400, 600), np.uint8)
    mask[100:200, 150:300] = mask[250:330, 380:460] = 255
    start = document(600, 400, cell_px=12.0).changed(mask=Raster.from_array(mask)).with_warp(preset="arc", bend=20)
    jobs = Jobs()
    editor = Editor(start, TOOLS, jobs=jobs, grid_solver=GpuSolver().find, preferences=Preferences(solver="gpu"))

    def script(window: WindowDriver) -> None:
        editor.choose_tool("pins")
        window.click(300, 200).click(500, 300).wait_until(lambda: editor.live.is_settled)
        count = len(answers)
        window.press(300, 200).move(320, 210).move(330, 215)
        window.wait_until(lambda: (editor.map.document is editor.document and jobs.is_idle) or editor.live.is_settled)
        assert len(answers) > count
        window.release().wait_until(lambda: editor.live.is_settled)

    drive(editor, script)
    solver = MapSolver()
    assert np.array_equal(editor.map.warped, run(solver.settle(editor.document)).warped)
    jobs.close()
