"""The real window, under a display of its own where there is none, driven by Dear ImGui's test engine."""

import os
import shutil
import subprocess
import time
from collections.abc import Iterator

import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.tools.all import TOOLS
from core.progress import Job, Progress
from tests.app.driver import document


@pytest.fixture(scope="session", autouse=True)
def display() -> Iterator[None]:
    """Start Xvfb where there is no display."""
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        yield
        return
    if shutil.which("Xvfb") is None:
        pytest.skip("neither a display nor Xvfb")
    reading, writing = os.pipe()
    command = ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1600x1000x24", "-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(command, pass_fds=[writing], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        os.environ["DISPLAY"] = f":{pipe.readline().strip()}"
    yield
    del os.environ["DISPLAY"]
    server.terminate()
    server.wait()


def endless(*_: object) -> Job[None]:
    """Work until cancelled."""
    fraction = 0.0
    while True:
        fraction += (1 - fraction) / 100
        time.sleep(0.002)
        yield Progress(fraction, "weaving")


@pytest.fixture
def editor() -> Iterator[Editor]:
    """Make an editor on a small picture; its exports never end."""
    jobs = Jobs()
    yield Editor(document(600, 400, cell_px=20.0), TOOLS, jobs=jobs, exporter=endless)
    jobs.close()


@pytest.fixture
def io() -> Iterator[imgui.IO]:
    """Make Dear ImGui without a window."""
    before = imgui.get_current_context()
    context = imgui.create_context()
    imgui.set_current_context(context)
    io = imgui.get_io()
    io.display_size, io.delta_time = imgui.ImVec2(2000, 100), 0.1
    io.backend_flags |= int(imgui.BackendFlags_.renderer_has_textures)
    yield io
    imgui.destroy_context(context)
    if before is not None:
        imgui.set_current_context(before)
