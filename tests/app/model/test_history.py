import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.model.history import History
from core.document.document import Document
from core.imaging.images import Image
from core.rasters.raster import Raster


def document(side: int = 8) -> Document:
    return Document.of(Image(np.zeros((side, side, 3), np.uint8)))


def test_a_group_is_one_entry() -> None:
    start = document()
    history = History(start)
    with history.group("Bend"):
        for bend in (1, 2, 3):
            history.document = start.with_warp(bend=bend)
    assert history.labels == ("Open", "Bend")
    history.undo()
    assert history.document is start
    history.redo()
    assert history.document.warp.bend == 3


def test_edits_join_the_one_before_until_something_else_happens() -> None:
    start = document()
    history = History(start)

    def nudge(bend: float) -> None:
        with history.group("Nudge", joins=True):
            history.document = history.document.with_warp(bend=bend)

    for bend in (1, 2, 3):
        nudge(bend)
    assert len(history.labels) == 2
    history.undo()
    assert history.document is start
    history.redo()
    nudge(4)
    assert len(history.labels) == 3
    history.mark_saved(history.document)
    nudge(5)
    assert len(history.labels) == 4
    history.undo()
    assert history.is_saved


def test_a_group_that_changes_nothing_is_none() -> None:
    history = History(document())
    with history.group("Nothing"):
        history.document = history.document.with_warp(bend=0.0)
    assert history.labels == ("Open",)


def test_a_group_left_by_an_exception_leaves_no_trace() -> None:
    start = document()
    history = History(start)

    def edit_and_fail() -> None:
        with history.group("Outer"):
            history.document = start.with_warp(bend=1)
            raise KeyError

    with pytest.raises(KeyError):
        edit_and_fail()
    assert history.document is start
    assert history.labels == ("Open",)


def test_an_edit_after_undo_cuts_what_was_undone() -> None:
    history = History(document())
    for bend in (1, 2):
        with history.group(f"Bend {bend}"):
            history.document = history.document.with_warp(bend=bend)
    history.undo()
    with history.group("Other"):
        history.document = history.document.with_warp(bend=9)
    assert history.labels == ("Open", "Bend 1", "Other")
    assert history.redo_label is None


def test_the_saved_document_is_found_again_by_undo() -> None:
    history = History(document())
    with history.group("Bend"):
        history.document = history.document.with_warp(bend=5)
    assert not history.is_saved
    history.mark_saved(history.document)
    history.undo()
    assert not history.is_saved
    history.redo()
    assert history.is_saved


def test_the_budget_counts_only_what_history_alone_holds() -> None:
    history = History(document(512), budget_bytes=3 * 512 * 512)
    for value in range(1, 9):
        with history.group(f"Fill {value}"):
            mask = Raster.from_array(np.random.default_rng(value).integers(0, 255, (512, 512)).astype(np.uint8))
            history.document = history.document.changed(mask=mask)
    assert history.labels == tuple(f"Fill {n}" for n in (5, 6, 7, 8))
    for _ in range(10):
        history.undo()
    assert history.undo_label is None
    assert history.redo_label == "Fill 6"


@given(st.lists(st.one_of(st.floats(-100, 100), st.sampled_from(["undo", "redo"])), max_size=40))
def test_undo_to_the_start_and_redo_to_the_end_give_the_same_documents(steps: list[float | str]) -> None:
    start = document()
    history = History(start)
    for step in steps:
        if step == "undo":
            history.undo()
        elif step == "redo":
            history.redo()
        else:
            with history.group("Bend"):
                history.document = history.document.with_warp(bend=step)
    end, index = history.document, history.index
    history.go_to(0)
    assert history.document is start
    history.go_to(index)
    assert history.document is end
