"""What the editor loads before its first frame, and what after it."""

import subprocess
import sys

RETEXTURE = """
import sys, numpy as np, app.commands.retexture
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.progress import run
from core.retexture.job import retexture

bend = [Curve(np.array([[10.0, 50], [40, y], [70, y], [110, 50]])) for y in (50, 30)]
picture = np.random.default_rng(0).integers(0, 255, (100, 120, 3), np.uint8)
run(retexture(picture, [FeatureCurve(*bend)])).apply(picture)
assert "scipy" not in sys.modules
"""
SAMPLE = """
import sys
from app.cli import parse
from app.marking.feature_list import rows_of
from app.model.jobs import Jobs
from tests.app.driver import Later

_, options = parse([])
from app.commands.edit import editor_on, warp_sample

beside = Jobs(live=Later(), long=Later(), beside=Later())
assert len(rows_of(editor_on(warp_sample(), None, beside))) > 1
"""
LOADING = """
import gc
from app.window.loading import loading

with loading():
    assert not gc.isenabled()
    with loading():
        kept = [[] for _ in range(5000)]
    assert not gc.isenabled()
assert gc.isenabled()
assert gc.get_freeze_count() > len(kept)
"""
LATER = "import sys; from app.window.late_imports import LOADED_LATER, load_rest; later = set(LOADED_LATER)"


def run(code: str) -> None:
    """Run `code` in a Python of its own, which has imported nothing else."""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_the_editor_starts_without_the_solvers_of_its_tools() -> None:
    started = "import app.commands.edit, imgui_bundle, app.window.shell"
    run(f"{started}; {LATER}; assert not later & set(sys.modules), later & set(sys.modules)")


def test_the_features_of_the_sample_are_listed_without_them() -> None:
    run(f"{SAMPLE}{LATER}; assert not later & set(sys.modules), later & set(sys.modules)")


def test_nobody_looks_for_garbage_while_modules_load() -> None:
    run(LOADING)


def test_the_tools_find_everything_loaded() -> None:
    run(f"{LATER}; load_rest(); assert later <= set(sys.modules), later - set(sys.modules)")


def test_a_picture_is_retextured_without_waiting_for_scipy() -> None:
    run(RETEXTURE)
