"""Random streams of events over all tools and actions: nothing may break, and everything can be taken back."""

from hypothesis import example, given, settings
from hypothesis import strategies as st

from app.actions.table import ActionTable
from app.model.events import Event, Finish, Key, KeyUp, Modifiers, Move, Press, Release, Wheel
from app.model.session import Brush
from app.tools.all import TOOLS
from core.document.document import Document
from tests.app.driver import EditorDriver, document

TABLE = ActionTable(TOOLS)
LEFT_OUT = ("file.", "help.", "edit.history", "edit.undo", "edit.redo")
ACTIONS = [action.name for action in TABLE.actions if not action.name.startswith(LEFT_OUT)]

positions = st.tuples(st.integers(-20, 140).map(float), st.integers(-20, 110).map(float))
modifiers = st.builds(Modifiers, shift=st.booleans(), ctrl=st.booleans(), alt=st.booleans())
buttons = st.sampled_from(["left", "left", "left", "middle", "right"])
names = st.sampled_from(["[", "]", "x", "delete", "backspace", "enter", "left", "up", "space", "a"])
events: st.SearchStrategy[Event | str] = st.one_of(
    st.builds(Press, positions, buttons, modifiers, st.sampled_from([1, 1, 2])),
    st.builds(Move, positions, modifiers),
    st.builds(Move, positions, modifiers),
    st.builds(Release, positions, modifiers),
    st.builds(Wheel, positions, st.sampled_from([-1.0, 1.0])),
    st.builds(Key, names, modifiers),
    st.just(KeyUp("space")),
    st.just(Finish()),
    st.sampled_from(["undo", "redo", *(f"tool.{name}" for name in TOOLS), *(f"tool.{name}" for name in TOOLS)]),
    st.sampled_from(ACTIONS),
)


@st.composite
def gestures(draw: st.DrawFn) -> list[Event | str]:
    """Draw a press, some moves and mostly a release, as a hand makes them."""
    place, mods = (
        draw(positions),
        draw(st.sampled_from([Modifiers()] * 4 + [Modifiers(shift=True), Modifiers(alt=True)])),
    )
    moves = [Move(to) for to in draw(st.lists(positions, max_size=3))]
    end = [Release(moves[-1].pos if moves else place)] if draw(st.integers(0, 9)) else []
    return [Move(place), Press(place, "left", mods), *moves, *end]


streams = st.lists(st.one_of(events.map(lambda event: [event]), gestures(), gestures()), max_size=40).map(
    lambda parts: [event for part in parts for event in part]
)
START: Document = document(120, 90, cell_px=15.0)
AT = (0.0, 0.0)
CUT_OUT = Press(AT, "left", Modifiers(alt=True))
PICKED_TWICE: list[Event | str] = ["tool.colour-range", Move(AT), CUT_OUT, Release(AT), Press(AT, "left")]
"""The second range of colours is found beside, and comes after the end."""


def begun() -> EditorDriver:
    drive = EditorDriver(START)
    drive.editor.show(brush=Brush(diameter_px=20.0))
    return drive


def play(drive: EditorDriver, stream: list[Event | str]) -> None:
    for event in stream:
        if event == "undo":
            drive.editor.undo()
        elif event == "redo":
            drive.editor.redo()
        elif isinstance(event, str):
            TABLE.run(event, drive.editor)
        else:
            drive.editor.handle(event)
        drive.frame()
        drive.editor.tool.overlay(drive.editor)


@settings(max_examples=60)
@given(streams)
@example(PICKED_TWICE)
def test_undo_to_the_start_and_redo_to_the_end(stream: list[Event | str]) -> None:
    drive = begun()
    play(drive, stream)
    drive.editor.finish()
    while not drive.editor.jobs.is_idle:
        drive.frame()  # what was selected last comes as an entry of its own
    end, count = drive.document, drive.editor.history.index
    for _ in range(count):
        drive.undo()
    assert drive.document is START
    assert drive.editor.history.is_saved
    for _ in range(count):
        drive.redo()
    assert drive.document is end


@settings(max_examples=60)
@given(streams)
def test_escape_anywhere_leaves_no_trace(stream: list[Event | str]) -> None:
    drive = begun()
    play(drive, stream)
    entries, index = drive.editor.history.labels, drive.editor.history.index
    drive.editor.cancel()
    assert (drive.editor.history.labels, drive.editor.history.index) == (entries, index)
    before = drive.document
    drive.editor.go_to(index)
    assert drive.document is before
    assert not drive.editor.is_busy
    assert drive.editor.session.band is None
    assert drive.editor.session.draft is None


@settings(max_examples=25)
@given(streams)
def test_at_rest_there_is_a_final_answer_or_a_reason(stream: list[Event | str]) -> None:
    drive = begun()
    faults: list[Exception] = []
    drive.editor.take_fault = faults.append
    play(drive, stream)
    drive.editor.choose_mode("warp")
    drive.frame().rest()
    assert drive.editor.live.is_settled
    assert drive.editor.live.fault is not None or drive.editor.answer.document is drive.document
    # A search may say that it found nothing; a fault of the program itself may not happen.
    assert faults == []
