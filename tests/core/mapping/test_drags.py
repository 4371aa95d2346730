"""A drag, frame by frame: what is worked out beside its frames, and what is recycled from one to the next."""

import threading
from typing import Any

import numpy as np
import pytest

from core.arrays import Floats, Points
from core.curves.bezier import Curve
from core.grid import find_features
from core.linalg.multifrontal import GridFactor
from core.linalg.reduced_basis import ReducedBasis
from core.mapping.features.recycled import Recycled
from core.mapping.features.straight_lines import Lines
from core.mapping.handles import solver
from core.mapping.handles.handles import Handles
from core.mapping.handles.plate import Frame, HandleField
from core.mapping.handles.solver import HandleSolver
from core.mapping.handles.turned import Base
from core.mapping.jacobians import Complexes
from core.mapping.options import MappingOptions
from core.mapping.tolerances import LITTLE, SEEN_PX
from core.mapping.warper import Warper
from core.progress import run
from tests.core.mapping.test_live import GRID, bent, three_discs


def test_a_drag_takes_its_rotation_beside_the_frames_and_another_w_takes_it_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    at, features = np.array([[60.0, 120.0], [200.0, 180.0]]), find_features(GRID, three_discs())
    one, other = GRID.nodes, bent("arc", 20)
    frames = [(plain, at + [[8.0 * step, 20], [0, 0]]) for step, plain in enumerate((one, one, one, one, other, other))]

    def drag() -> list[Points]:
        live = Warper(GRID)
        live.use(features, MappingOptions())
        found = []
        for plain, to in frames:
            found.append(live.frame(plain, Handles(at, to)).warped)
            live.look_ahead()
        return found

    on_this = []
    turn = HandleField.turn

    def watched(self: HandleField, *arguments: Any, **named: Any) -> Any:
        on_this.append(threading.current_thread() is threading.main_thread())
        return turn(self, *arguments, **named)

    monkeypatch.setattr(HandleField, "turn", watched)
    found = drag()
    # The first frame, that of the first one that goes on from it, and the same under another W.
    assert sum(on_this) == 4
    monkeypatch.setattr(solver, "_BESIDE", _Never())
    np.testing.assert_allclose(found, drag(), atol=LITTLE * SEEN_PX)  # nothing is learnt beside either


@pytest.mark.parametrize("frame", ["held", "free"])
@pytest.mark.parametrize("kind", ["pins", "pins and a line", "curve"])
def test_a_drag_solves_for_what_is_new_alone_and_shows_what_solving_for_all_does(
    frame: Frame, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    at, features = np.array([[60.0, 120.0], [200.0, 40.0]]), find_features(GRID, three_discs())
    straight = Lines(np.array([[[120.0, 20.0], [180.0, 100.0]]])) if kind == "pins and a line" else None
    options = MappingOptions(frame=frame, lines=straight)
    solved: list[int] = []

    def drag() -> list[Points]:
        live = Warper(GRID)
        live.use(features, options)
        found = []
        for angle in np.linspace(0.1, np.pi, 40):
            by = np.array([24 * np.sin(angle), 16 * (1 - np.cos(angle))])
            solved.append(0)
            found.append(
                live.frame(GRID.nodes, curved(by) if kind == "curve" else Handles(at, at + [by, [0, 0]])).warped
            )
            live.look_ahead()
        return found

    backward = GridFactor.backward

    def counted(self: GridFactor, y: Floats) -> Floats:
        if threading.current_thread() is threading.main_thread():
            solved[-1] += 1
        return backward(self, y)

    monkeypatch.setattr(GridFactor, "backward", counted)
    found = drag()
    assert sum(solved[20:]) < 5
    monkeypatch.setattr(ReducedBasis, "answer", lambda self, x: self._evaluate(x))
    np.testing.assert_allclose(found, drag(), atol=LITTLE * SEEN_PX)
    assert sum(solved[-20:]) >= 20


@pytest.mark.parametrize("kind", ["pins", "curve"])
def test_what_a_drag_goes_on_to_ask_for_is_learnt_before_it_does(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    live, waited = started(monkeypatch)
    for step in range(24):
        waited.append(0)
        live.frame(GRID.nodes, dragged(kind, np.array([3.0 * step + 1, 0.1 * step**2])))
        live.look_ahead()
        end_beside(live)
    assert sum(waited[:4]) > 0
    assert sum(waited[4:]) == 0


def test_nothing_is_imagined_where_the_next_frame_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    live, _ = started(monkeypatch)
    imagined: list[bool] = []
    imagine, turn = HandleSolver._imagine, HandleField.turn

    def noted(self: HandleSolver, asked: Complexes) -> None:
        imagined.append(self._is_awaited)
        imagine(self, asked)

    def slow(self: HandleField, *arguments: Any, **named: Any) -> Any:
        handles = live._last.handles
        while threading.current_thread() is not threading.main_thread() and not is_over.wait(0.001):
            if handles is not None and handles._is_awaited:
                break
        return turn(self, *arguments, **named)

    monkeypatch.setattr(HandleSolver, "_imagine", noted)
    monkeypatch.setattr(HandleField, "turn", slow)
    is_over = threading.Event()
    try:
        for step in range(6):
            live.frame(GRID.nodes, dragged("pins", np.array([8.0 * step, 0.0])))
            live.look_ahead()
        assert not imagined
    finally:
        is_over.set()
    end_beside(live)
    assert imagined == [False]


@pytest.mark.parametrize("by", [5.0, 0.0])
def test_what_a_drag_begins_with_is_got_ready_at_rest(by: float, monkeypatch: pytest.MonkeyPatch) -> None:
    live, _ = started(monkeypatch)
    on_this: list[str] = []

    def note(kind: type, name: str) -> None:
        before = getattr(kind, name)

        def noted(*arguments: Any, **named: Any) -> Any:
            if threading.current_thread() is threading.main_thread():
                on_this.append(name)
            return before(*arguments, **named)

        monkeypatch.setattr(kind, name, noted)

    live.frame(GRID.nodes, dragged("pins", np.array([by, 0.0])))
    settled = run(_used(Warper(GRID)).settle(GRID.nodes)).reference
    assert settled is not None
    live.look_ahead()
    live._last.wait()
    live.learn(GRID.nodes, settled)
    live.look_ahead()
    end_beside(live)
    live.look_ahead()
    note(Recycled, "_begin")
    note(HandleField, "turn")
    note(Base, "of")
    live.frame(GRID.nodes, dragged("pins", np.array([by + 1, 0.0])))
    assert on_this == ([] if by else ["turn"])  # nothing had turned yet


def started(monkeypatch: pytest.MonkeyPatch) -> tuple[Warper, list[int]]:
    """Return a drag that is about to begin, and how often each of its frames waits for something to be solved."""
    live, waited = _used(Warper(GRID)), [0]
    take = ReducedBasis._take

    def counted(self: ReducedBasis) -> None:
        waited[-1] += threading.current_thread() is threading.main_thread()
        take(self)

    monkeypatch.setattr(ReducedBasis, "_take", counted)
    return live, waited


def _used(live: Warper) -> Warper:
    live.use(find_features(GRID, three_discs()), MappingOptions())
    return live


def dragged(kind: str, by: Floats) -> Handles:
    """Return two pins, one of them displaced, or a curve."""
    at = np.array([[60.0, 120.0], [200.0, 40.0]])
    return curved(by) if kind == "curve" else Handles(at, at + [by, [0, 0]])


def end_beside(live: Warper) -> None:
    """Return when nothing is worked out beside the frames any more, though none of them waits for it."""
    handles = live._last.handles
    if handles is not None and handles._beside is not None:
        handles._beside.result()


def curved(by: Floats, *, source: Floats | None = None) -> Handles:
    """Return a curve between the features whose middle is displaced; many points of it are held."""
    corners = np.array([[20.0, 120.0], [80.0, 110.0], [140.0, 125.0], [200.0, 115.0]])
    middle = np.array([[0.0], [1.0], [1.0], [0.0]])
    start = corners if source is None else corners + middle * source
    return Handles(np.empty((0, 2)), np.empty((0, 2)), [(Curve(start), Curve(start + middle * by))])


def test_handles_at_other_places_in_every_frame_prepare_nothing_for_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(self: ReducedBasis, x: Complexes) -> Complexes:
        raise AssertionError("nothing is asked for again")

    monkeypatch.setattr(ReducedBasis, "answer", never)
    live = Warper(GRID)
    live.use(find_features(GRID, three_discs()), MappingOptions())
    for x in range(5):
        live.frame(GRID.nodes, curved(np.array([0.0, 10.0]), source=np.array([float(x), 0.0])))
        live.look_ahead()


def test_the_factor_is_left_to_what_is_learnt_beside_until_that_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    live, mask, handles = Warper(GRID), three_discs(), Handles(np.array([[60.0, 120]]), np.array([[70.0, 120]]))
    live.use(find_features(GRID, mask), MappingOptions())
    live.frame(GRID.nodes, handles)
    done: list[str] = []

    def note(kind: type, name: str) -> None:
        before = getattr(kind, name)

        def noted(*arguments: Any) -> Any:
            done.append(name)
            return before(*arguments)

        monkeypatch.setattr(kind, name, noted)

    note(solver.HandleSolver, "wait")
    for name in ("factorise", "forward", "forward_again", "backward"):
        note(GridFactor, name)
    mask[100:110, 100:110] = 255
    for act in (
        lambda: live.folds(bent("arc", 10)),
        lambda: live.frame(bent("arc", 20), handles),
        lambda: run(live.settle(bent("arc", 30), handles)),
        lambda: live.frame(bent("arc", 30), handles),
        lambda: live.use(find_features(GRID, mask), MappingOptions()),
    ):
        done.clear()
        act()
        assert done[0] == "wait"
        assert len(set(done)) > 1


class _Never:
    """An executor that does nothing."""

    def submit(self, *_: Any, **__: Any) -> None: ...
