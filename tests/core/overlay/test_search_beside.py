"""Searches of which other processes do a part come to the same."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from core.arrays import Floats
from core.imaging.image import Image
from core.linalg import jobs_beside
from core.linalg.jobs_beside import PlannedJob, ProcessPool, use_all_processors
from core.overlay import cloth_search
from core.overlay.cloth_search import Known, find
from core.overlay.decomposition import Decomposition, decompose, decompose_whole_cloth
from core.overlay.filters import shrinking
from core.overlay.found_cloth import FoundCloth, explain_each
from core.overlay.search.large_periods import NOTE
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import make_scene, motif

SCENE = make_scene(motif(), noise=0.01)
HALF = np.ones(SCENE.photo.shape[:2], bool)
HALF[:, :55] = False
GROUND = np.random.default_rng(0).random((260, 280, 3)) * 0.1 + [0.1, 0.25, 0.5]


def on_ground() -> Image:
    """Return the scene on plain ground, 8 bits a sample."""
    photo = GROUND.copy()
    height, width = SCENE.photo.shape[:2]
    photo[40 : 40 + height, 40 : 40 + width] = SCENE.photo
    return Image(np.rint(255 * np.clip(photo, 0, 1)).astype(np.uint8))


@pytest.fixture
def done_beside(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the names of the jobs that another process has done, on a machine with two processors."""
    done: list[str] = []
    run_in_turn = PlannedJob._run

    def note(job: PlannedJob[Any]) -> None:
        run_in_turn(job)
        if job._is_wanted:
            done.append(getattr(job._make, "__name__", "follow"))

    monkeypatch.setattr(PlannedJob, "_run", note)
    monkeypatch.setattr(jobs_beside, "count_processors", lambda: 2)
    return done


def find_doubtful(photo: Floats, known: Known) -> Job[list[FoundCloth]]:
    yield Progress(0.0, NOTE)
    return [replace(found, is_sure=False, is_clear=False) for found in (yield from find(photo, known))]


def assert_alike(search: Callable[[], Job[Decomposition]]) -> None:
    alone = run(search())
    fractions: list[float] = []
    with use_all_processors():
        together = run(search(), lambda step: fractions.append(step.fraction))
    assert fractions == sorted(fractions)
    assert alone.covered.any()
    for name in ("uv", "shading", "detail", "reconstruction", "coverage", "basis"):
        assert np.array_equal(getattr(alone, name), getattr(together, name), equal_nan=True), name
    assert alone.explained == together.explained


def note_explained(monkeypatch: pytest.MonkeyPatch, done_beside: list[str]) -> list[list[str]]:
    """Return what another process had done each time that finds were explained in a search."""
    before: list[list[str]] = []

    def explain_and_note(finds: list[FoundCloth], pool: ProcessPool) -> Job[None]:
        yield from explain_each(finds, pool)
        if pool.is_beside:
            assert all("explained" in vars(found) for found in finds)
            before.append(list(done_beside))

    monkeypatch.setattr(cloth_search, "explain_each", explain_and_note)
    return before


def test_the_whole_cloth_of_a_photo_that_is_shrunk(monkeypatch: pytest.MonkeyPatch, done_beside: list[str]) -> None:
    monkeypatch.setattr(shrinking, "WORKING_PX", 200)
    assert_alike(lambda: decompose_whole_cloth(on_ground()))
    assert done_beside[:2] == ["find_if_any", "explain"]


def test_what_speaks_for_each_find(done_beside: list[str]) -> None:
    (found,) = run(find(SCENE.photo, Known(HALF)))
    finds = [found, replace(found), replace(found)]
    with use_all_processors(), ProcessPool() as pool:
        run(explain_each(finds, pool))
    explained = [vars(find)["explained"] for find in finds]
    assert explained == [replace(found).explained] * 3
    # What is told at every pixel takes memory: that of the best, here the first of equals, is kept.
    assert ["model" in vars(find) for find in finds] == [True, False, False]
    assert all(np.array_equal(find.model.uv, found.model.uv, equal_nan=True) for find in finds)
    assert done_beside[0] == "explain"


def test_a_region_in_which_the_first_find_leaves_doubts(
    monkeypatch: pytest.MonkeyPatch, done_beside: list[str]
) -> None:
    explained = note_explained(monkeypatch, done_beside)
    monkeypatch.setattr(cloth_search, "find", find_doubtful)
    assert_alike(lambda: decompose(SCENE.photo, region=HALF))
    # What speaks for the first find is told while another process looks again.
    assert explained == [[]]
    assert "find_again" in done_beside


def test_the_whole_cloth_where_finds_leave_doubts(monkeypatch: pytest.MonkeyPatch, done_beside: list[str]) -> None:
    explained = note_explained(monkeypatch, done_beside)
    monkeypatch.setattr(cloth_search, "find", find_doubtful)
    monkeypatch.setattr(cloth_search, "lies_on", lambda *_: False)
    assert_alike(lambda: decompose_whole_cloth(on_ground()))
    # What speaks for what keypoints tell is told while another process looks at patches.
    assert explained == [["find_if_any"]]
    assert "find_alike" in done_beside
