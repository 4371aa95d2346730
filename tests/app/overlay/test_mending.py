"""Stories of a lattice that is mended by hand: no search is run for it, and what was put right stays."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.model.jobs import InlineExecutor, Jobs
from app.tools.cloth.lattice import free_key, on_screen, vertices
from app.tools.cloth.lattice_edit import is_held
from core.arrays import Ints, Points
from core.document import overlay_layers
from core.document.document import Document
from core.document.overlay import get_found
from core.document.overlay_layers import OverlayLayers
from core.document.overlay_settings import LatticeVertices, Mending, Search
from core.document.project import load_project, save_project
from core.overlay import decomposition
from core.progress import Job, Progress
from tests.app.driver import EditorDriver, Later
from tests.app.overlay.driver import OverlayDriver, cloth_on_a_table


@pytest.fixture
def mender(drive: OverlayDriver, monkeypatch: pytest.MonkeyPatch) -> OverlayDriver:
    """Return a driver with the lattice in hand, whose pattern is found and must not be looked for again."""
    monkeypatch.setattr(decomposition, "decompose", never)
    drive.tool("lattice")
    return drive


def never(*_: object, **__: object) -> Job[None]:
    pytest.fail("a search was begun")
    yield Progress(0.0)


def lattice_of(drive: OverlayDriver) -> LatticeVertices:
    lattice = vertices(drive.editor)
    assert lattice is not None
    return lattice


def layers_of(drive: OverlayDriver) -> OverlayLayers:
    layers = drive.editor.overlay.layers
    assert layers is not None
    assert drive.editor.overlay.is_final
    return layers


def mending_of(drive: OverlayDriver) -> Mending:
    search = drive.cloth.search
    assert search is not None
    assert search.mending is not None
    return search.mending


def places_of(drive: OverlayDriver) -> Points:
    return on_screen(drive.editor, lattice_of(drive))


def row_at(drive: OverlayDriver, x: float, y: float) -> int:
    return int(np.argmin(np.hypot(*(places_of(drive) - (x, y)).T)))


def drag_vertex(drive: OverlayDriver, row: int, dx: float, dy: float) -> Ints:
    """Drag a vertex and return its coordinates."""
    x, y = places_of(drive)[row].tolist()
    key: Ints = np.rint(lattice_of(drive).keys[row]).astype(np.int64)
    drive.drag((x, y), (x + 5, y), (x + dx, y + dy)).frame()
    return key


def row_of(drive: OverlayDriver, key: Ints) -> int:
    return int(np.flatnonzero((np.rint(lattice_of(drive).keys) == key).all(1))[0])


def place_of(drive: OverlayDriver, key: Ints) -> Points:
    return np.asarray(places_of(drive)[row_of(drive, key)])


def test_moved_vertex_lies_where_it_was_dragged_and_pulls_its_neighbours_softly(mender: OverlayDriver) -> None:
    row, start, before = row_at(mender, 75, 65), places_of(mender), layers_of(mender)
    key = drag_vertex(mender, row, 4, 3)
    after = layers_of(mender)
    assert after is not before
    assert mender.labels == ("Move lattice vertex",)
    moves = np.linalg.norm(places_of(mender) - start, axis=1)
    np.testing.assert_allclose(place_of(mender, key), start[row] + (4, 3), atol=1e-6)
    away = np.linalg.norm(start - start[row], axis=1)
    step = float(np.sqrt(before.lattice.texel_area))
    beside, far = (away > 0) & (away < 1.3 * step), away > 3.2 * step
    assert (moves[beside] > 0.5).all()
    assert (moves[beside] < 4.5).all()
    assert far.any()
    assert moves[far].max() < 1e-6
    x, y = np.rint(start[row] + (4, 3)).astype(int)
    u, v = np.rint(start[row]).astype(int)
    np.testing.assert_allclose(after.uv[y, x], before.uv[v, u], atol=0.1)
    np.testing.assert_array_equal(after.covered, before.covered)
    mender.undo()
    assert mender.editor.overlay.layers is before


def test_what_was_moved_or_removed_stays_so_in_every_later_step(mender: OverlayDriver) -> None:
    first, start = row_at(mender, 75, 65), places_of(mender)
    key = drag_vertex(mender, first, 4, 3)
    gone = row_at(mender, 30, 30)
    gone_key = np.rint(lattice_of(mender).keys[gone]).astype(int)
    mender.move(*places_of(mender)[gone].tolist()).key("delete").frame()
    for beside in (key + np.array([1, 0]), key + np.array([0, 1])):
        drag_vertex(mender, row_of(mender, beside), -3, 4)
        np.testing.assert_allclose(place_of(mender, key), start[first] + (4, 3), atol=1e-6)
        assert not (np.rint(lattice_of(mender).keys) == gone_key).all(1).any()
    x, y = np.rint(start[gone]).astype(int)
    assert not layers_of(mender).covered[y, x]
    assert layers_of(mender).coverage[y, x] == 0


def test_locked_vertex_does_not_follow_until_it_is_unlocked(mender: OverlayDriver) -> None:
    row = row_at(mender, 75, 65)
    beside = int(np.argsort(np.linalg.norm(places_of(mender) - places_of(mender)[row], axis=1))[1])
    key = np.rint(lattice_of(mender).keys[beside]).astype(int)
    start = place_of(mender, key)
    mender.move(*start.tolist()).key("x").frame()
    assert mender.labels == ("Lock lattice vertices",)
    assert is_held(mender.editor, lattice_of(mender)).sum() == 1
    drag_vertex(mender, row, 4, 3)
    np.testing.assert_allclose(place_of(mender, key), start, atol=1e-6)
    mender.move(*start.tolist()).key("x").frame()
    assert np.linalg.norm(place_of(mender, key) - start) > 0.5


def test_vertices_in_a_rectangle_are_moved_and_removed_together(mender: OverlayDriver) -> None:
    start = places_of(mender)
    spots = np.stack(np.meshgrid(np.arange(20, 60), np.arange(20, 60)), -1).reshape(-1, 2)
    left, top = spots[np.linalg.norm(spots[:, None] - start, axis=-1).min(1).argmax()].tolist()
    inside = ((start >= (left, top)) & (start <= (left + 60, top + 60))).all(1)
    mender.drag((left, top), (left + 20, top + 20), (left + 60, top + 60), shift=True)
    assert mender.editor.session.selected_vertices == frozenset(np.flatnonzero(inside).tolist())
    assert inside.sum() > 3
    drag_vertex(mender, int(np.flatnonzero(inside)[0]), 3, -2)
    np.testing.assert_allclose(places_of(mender)[inside], start[inside] + (3, -2), atol=1e-6)
    mender.key("delete").frame()
    assert len(lattice_of(mender).keys) == (~inside).sum()
    assert mender.labels == ("Move lattice vertices", "Remove lattice vertices")


def test_nothing_follows_beyond_a_seam(mender: OverlayDriver) -> None:
    row, start = row_at(mender, 75, 65), places_of(mender)
    x = float(start[row, 0]) + 8
    mender.drag((x, 0), (x, 60), (x, 129), ctrl=True).frame()
    assert mender.labels == ("Draw seam",)
    before = layers_of(mender)
    drag_vertex(mender, row, 2, 3)
    moves = np.linalg.norm(places_of(mender) - start, axis=1)
    assert moves[start[:, 0] > x + 2].max() < 1e-6
    assert (moves[(start[:, 0] < x - 2) & (np.linalg.norm(start - start[row], axis=1) < 28)] > 0.3).all()
    right = np.s_[:, round(x) + 3 :]
    np.testing.assert_array_equal(layers_of(mender).uv[right], before.uv[right])


def test_removed_vertex_has_its_place_again(mender: OverlayDriver) -> None:
    row, before = row_at(mender, 75, 65), layers_of(mender)
    lattice = lattice_of(mender)
    x, y = places_of(mender)[row].tolist()
    assert free_key(mender.editor, lattice, (x + 1, y)) is None
    mender.move(x, y).key("delete").frame()
    assert layers_of(mender).covered.sum() < before.covered.sum()
    np.testing.assert_array_equal(free_key(mender.editor, lattice_of(mender), (x + 1, y)), lattice.keys[row])
    mender.click(x, y).frame()
    assert mender.labels == ("Remove lattice vertex", "Add lattice vertex")
    inside = np.hypot(*(np.stack(np.meshgrid(np.arange(150), np.arange(130)), -1) - (x, y)).transpose(2, 0, 1)) < 8
    assert layers_of(mender).covered[inside].all()
    np.testing.assert_allclose(layers_of(mender).uv[inside], before.uv[inside], atol=0.05)


def test_vertex_is_added_where_the_cloth_was_not_covered(mender: OverlayDriver) -> None:
    """Where nothing was found beside the lattice, the new texel goes on as the nearest one."""
    row, before = row_at(mender, 75, 65), layers_of(mender)
    x, y = places_of(mender)[row].tolist()
    mender.move(x, y).key("delete").frame()
    assert not layers_of(mender).covered[round(y), round(x)]
    mender.drag((x, y), (x + 5, y), (x + 2, y + 1)).frame()
    uv = layers_of(mender).uv
    np.testing.assert_allclose(uv[round(y + 1), round(x + 2)], before.uv[round(y), round(x)], atol=0.1)


def test_mended_project_shows_its_result_without_a_search_and_goes_on(mender: OverlayDriver, tmp_path: Path) -> None:
    row, start = row_at(mender, 75, 65), places_of(mender)
    key = drag_vertex(mender, row, 4, 3)
    save_project(mender.document, tmp_path / "a.weft")
    again = OverlayDriver(load_project(tmp_path / "a.weft"))
    again.tool("lattice")
    np.testing.assert_allclose(layers_of(again).uv, layers_of(mender).uv, atol=1e-6)
    drag_vertex(again, row_of(again, key + np.array([1, 0])), -3, 4)
    np.testing.assert_allclose(place_of(again, key), start[row] + (4, 3), atol=1e-4)
    gap = np.abs(layers_of(again).uv - layers_of(mender).uv)
    assert np.nanmax(gap) > 0.05
    assert isinstance(again.document, Document)


def test_vertex_is_added_only_where_the_lattice_goes_on(mender: OverlayDriver) -> None:
    lattice = vertices(mender.editor)
    assert lattice is not None
    places = on_screen(mender.editor, lattice)
    row = int(np.argmin(np.hypot(*(places - (75, 65)).T)))
    beside = next(n for n, key in enumerate(lattice.keys) if np.array_equal(key, lattice.keys[row] + [1, 0]))
    missing = LatticeVertices(np.delete(lattice.keys, row, axis=0), np.delete(lattice.places, row, axis=0))
    key = free_key(mender.editor, missing, tuple(places[row]))
    np.testing.assert_array_equal(key, lattice.keys[row])
    assert free_key(mender.editor, missing, tuple((places[row] + places[beside]) / 2)) is None


@pytest.mark.parametrize("name", ["Whole cloth", "Find pattern"])
def test_what_was_mended_stays_so_when_the_pattern_is_found_again(name: str) -> None:
    drive = OverlayDriver(Document.of(cloth_on_a_table()[0]))
    drive.tool("region").drag((48, 43), (80, 80), (125, 150))
    drive.run("overlay.find").tool("lattice")
    first = layers_of(drive)
    gone = places_of(drive)[row_at(drive, 60, 130)]
    drive.click(*gone.tolist(), alt=True).frame()
    moved = row_at(drive, 85, 95)
    goal = places_of(drive)[moved] + (3, 2)
    drag_vertex(drive, moved, 3, 2)
    drive.drag((50, 40), (50, 80), (50, 155), ctrl=True).frame()
    seam = mending_of(drive).seams[0]
    mended = layers_of(drive)
    if name == "Find pattern":
        drive.run("overlay.clear_region")
    drive.run("overlay.whole" if name == "Whole cloth" else "overlay.find").tool("lattice").frame()
    assert drive.labels[-1] == name
    np.testing.assert_array_equal(mending_of(drive).seams, [seam])
    assert layers_of(drive).covered.sum() > 1.5 * first.covered.sum()
    away = np.linalg.norm(places_of(drive)[:, None] - [goal, gone], axis=2).min(axis=0)
    assert away[0] < 0.05, "it lies where the hand put it"
    assert away[1] > 0.5 * np.sqrt(layers_of(drive).lattice.texel_area), "it was removed"
    assert is_held(drive.editor, lattice_of(drive)).sum() == 1
    drag_vertex(drive, row_at(drive, 85, 125), 2, 0)
    assert np.linalg.norm(places_of(drive) - goal, axis=1).min() < 0.05, "whatever is moved beside it"
    drive.undo().undo()
    assert layers_of(drive) is mended
    for _ in drive.labels[2:-2]:
        drive.undo()
    assert layers_of(drive) is first, "nothing is found again for undo"


def test_the_lattice_of_another_search_is_not_mended_while_one_is_under_way(found: Document) -> None:
    later = Later()
    drive = EditorDriver(found, jobs=Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    drive.tool("lattice").frame()
    assert vertices(drive.editor) is not None
    drive.editor.edit("Find pattern", drive.document.with_cloth(search=Search(seed=5)))
    drive.frame()
    assert drive.editor.overlay.is_running
    assert vertices(drive.editor) is None
    before = drive.labels
    drive.drag((60, 60), (64, 60), (70, 70))
    assert drive.labels == before


def test_moved_cloth_shows_where_it_lies_before_its_light_and_detail_are_told(
    found: Document, monkeypatch: pytest.MonkeyPatch
) -> None:
    later, shown = Later(), list[OverlayLayers | None]()
    drive = EditorDriver(found, jobs=Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    drive.tool("lattice").frame()
    overlay, in_full = drive.editor.overlay, overlay_layers._with_detail
    before = overlay.layers

    def watch(*arguments: Any) -> OverlayLayers:
        drive.frame()
        shown.append(overlay.layers)
        return in_full(*arguments)

    monkeypatch.setattr(overlay_layers, "_with_detail", watch)
    lattice = vertices(drive.editor)
    assert lattice is not None
    x, y = on_screen(drive.editor, lattice)[len(lattice.keys) // 2].tolist()
    drive.drag((x, y), (x + 5, y), (x + 4, y + 3)).frame()
    later.run()
    drive.frame()
    [rough], final = shown, overlay.layers
    assert before is not None
    assert rough is not None
    assert final is not None
    np.testing.assert_array_equal(rough.uv, final.uv)
    np.testing.assert_array_equal(rough.lattice.frames.points, final.lattice.frames.points)
    assert rough.bare_detail is before.bare_detail
    assert not np.array_equal(final.bare_detail, before.bare_detail, equal_nan=True)


@pytest.mark.parametrize("is_new", [False, True])
def test_cloth_that_has_no_light_yet_is_not_shown(found: Document, is_new: bool) -> None:
    layers, search = get_found(found), found.cloth.search
    assert layers is not None
    assert search is not None
    lattice = overlay_layers.vertices_of(found, layers)
    key, place = lattice.keys.max(0) + 1, lattice.places.max(0)
    more = LatticeVertices(np.vstack([lattice.keys, key]), np.vstack([lattice.places, place]))
    mending = Mending(search, more if is_new else lattice, key[None])
    previews = [step.preview for step in overlay_layers.mend_layers(found, layers, mending)]
    assert any(previews) == (not is_new)
