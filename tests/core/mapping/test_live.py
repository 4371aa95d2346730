"""What the live answer owes to the one at rest: the same features, and nodes in the same cells."""

import threading
from typing import Any

import cv2
import numpy as np
import pytest

from core.arrays import Bytes, Floats, Points
from core.curves.bezier import Curve
from core.grid import Grid, find_features
from core.linalg.multifrontal import GridFactor
from core.linalg.reduced_basis import ReducedBasis
from core.mapping.features.feature_mapping import FeatureMapping, Keep
from core.mapping.features.recycled import Recycled
from core.mapping.features.straight_lines import Lines
from core.mapping.handles import solver
from core.mapping.handles.curved_frame import cuts_of, fit_cuts
from core.mapping.handles.handles import Handles
from core.mapping.handles.plate import Frame, HandleField
from core.mapping.handles.solver import HandleSolver
from core.mapping.handles.turned import Base
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.options import MappingOptions
from core.mapping.tolerances import LITTLE, SEEN_PX
from core.mapping.warper import Warper
from core.mapping.warping import warp_grid
from core.progress import run
from core.warps.presets import make_warp

WIDTH, HEIGHT, CELL = 320, 240, 4
GRID = Grid(WIDTH, HEIGHT, cell_px=CELL)
KEEPS: list[Keep] = ["similarity", "rigid"]


def three_discs() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    for x, y, radius in ((80, 70, 30), (230, 80, 35), (160, 180, 40)):
        cv2.circle(mask, (x, y), radius, 255, -1)
    return mask


def cut_by_the_edge() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.circle(mask, (160, HEIGHT), 70, 255, -1)
    cv2.circle(mask, (30, 0), 30, 255, -1)
    return mask


def bent(preset: str, bend: float) -> Points:
    return make_warp(preset, WIDTH, HEIGHT, bend=bend)(GRID.nodes)


def cells_apart(a: Points, b: Points) -> Floats:
    return np.asarray(np.hypot(*np.moveaxis(a - b, -1, 0)) / CELL)


@pytest.mark.parametrize("keep", KEEPS)
@pytest.mark.parametrize(("preset", "bend"), [("swirl", 20), ("arc", 30), ("flag", 30), ("bulge", 40), ("squeeze", 30)])
def test_live_and_at_rest_are_the_same_where_nothing_folds(preset: str, bend: float, keep: Keep) -> None:
    live, plain = Warper(GRID), bent(preset, bend)
    live.use(find_features(GRID, three_discs()), MappingOptions(keep=keep))
    shown = live.frame(plain)
    assert not shown.folded.any()
    assert np.array_equal(shown.warped, run(live.settle(plain)).warped)


@pytest.mark.parametrize(("preset", "bend"), [("arc", 60), ("arc", 80), ("inflate", 60), ("inflate", 80)])
def test_features_at_the_edge_do_not_jump_when_all_rests(preset: str, bend: float) -> None:
    features, plain = find_features(GRID, cut_by_the_edge()), bent(preset, bend)
    live = Warper(GRID)
    live.use(features, MappingOptions())
    rest = warp_grid(GRID, features, plain).warped
    assert cells_apart(live.frame(plain).warped, rest).max() < 0.1


@pytest.mark.parametrize(("preset", "bend"), [("arc", 5), ("arc", 60), ("swirl", 30)])
def test_a_frame_costs_one_substitution_back(preset: str, bend: float, monkeypatch: pytest.MonkeyPatch) -> None:
    live = Warper(GRID)
    live.use(find_features(GRID, cut_by_the_edge()), MappingOptions())
    live.frame(bent(preset, bend / 2))
    backward, calls = GridFactor.backward, []

    def counted(factor: GridFactor, y: Floats) -> Floats:
        calls.append(y)
        return backward(factor, y)

    monkeypatch.setattr(GridFactor, "backward", counted)
    assert live.frame(bent(preset, bend)).seconds["solve"] > 0
    assert len(calls) == 1


@pytest.mark.parametrize("keep", KEEPS)
def test_a_stroke_beside_other_features_shows_what_stays_when_all_rests(keep: Keep) -> None:
    mask, plain = three_discs(), bent("swirl", 25)
    live, options = Warper(GRID), MappingOptions(keep=keep)
    live.use(find_features(GRID, mask), options)
    live.frame(plain)
    for angle in np.linspace(-1, 2, 12):
        cv2.circle(mask, (round(80 + 28 * np.cos(angle)), round(70 + 28 * np.sin(angle))), 12, 255, -1)
        live.use(find_features(GRID, mask), options)
        shown = live.frame(plain)
        whole = FeatureMapping(GRID, find_features(GRID, mask), keep=keep).solve(plain)
        assert cells_apart(shown.warped, whole).max() < 0.5
        assert max(feature.residual for feature in shown.features) < 1e-10


def test_a_stroke_that_makes_joins_and_removes_features_shows_all_of_them() -> None:
    mask, plain = three_discs(), bent("arc", 25)
    live = Warper(GRID)
    dabs = [((160, 40), 10, 255), ((140, 60), 20, 255), ((110, 65), 20, 255), ((230, 80), 60, 0), ((40, 200), 15, 255)]
    for place, radius, value in dabs:
        live.use(find_features(GRID, mask), MappingOptions())
        live.frame(plain)
        cv2.circle(mask, place, radius, value, -1)
        features = find_features(GRID, mask)
        live.use(features, MappingOptions())
        shown = live.frame(plain)
        assert [feature.id for feature in shown.features] == list(features.ids)
        assert max(feature.residual for feature in shown.features) < 1e-10
        assert cells_apart(shown.warped, FeatureMapping(GRID, features).solve(plain)).max() < 1


def test_features_that_a_stroke_leaves_alone_find_their_place_in_turn() -> None:
    before, after = three_discs(), three_discs()
    cv2.circle(after, (95, 80), 40, 255, -1)
    plain, live = bent("swirl", 40), Warper(GRID)
    live.use(find_features(GRID, before), MappingOptions())
    live.frame(plain)
    apart = []
    for frame in range(13):
        mask = after.copy()
        mask[40, 80] = 0 if frame % 2 else 255
        mask[110:116, 60:70] = 255 if frame % 2 else 0
        features = find_features(GRID, mask)
        live.use(features, MappingOptions())
        apart.append(cells_apart(live.frame(plain).warped, FeatureMapping(GRID, features).solve(plain)).max())
    assert apart[0] > 0.5
    assert apart[-1] < 0.1 * apart[0]


def test_all_features_are_placed_when_one_goes_or_two_come() -> None:
    grid = Grid(WIDTH, HEIGHT, cell_px=2)
    live, plain = Warper(grid), make_warp("swirl", WIDTH, HEIGHT, bend=40)(grid.nodes)
    fewer = np.where(np.arange(HEIGHT)[:, None] > 130, 0, three_discs()).astype(np.uint8)
    for mask in (three_discs(), fewer, np.zeros_like(fewer), fewer):
        features = find_features(grid, mask)
        live.use(features, MappingOptions())
        assert np.array_equal(live.frame(plain).warped, FeatureMapping(grid, features).solve(plain))


def test_another_w_places_all_features_at_once() -> None:
    live = Warper(GRID)
    mask = three_discs()
    for bend in (10, 40):
        plain = bent("swirl", bend)
        live.use(find_features(GRID, mask), MappingOptions())
        shown = live.frame(plain)
        assert np.array_equal(shown.warped, FeatureMapping(GRID, find_features(GRID, mask)).solve(plain))
        cv2.circle(mask, (80, 70), 36, 255, -1)


def test_features_held_where_the_best_mapping_has_them_leave_it_as_it_is() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, three_discs()))
    w = as_complex(bent("swirl", 30))
    best = mapping.place(w)
    for moving in ([True, False, False], [False, True, True], [False, False, False]):
        found = mapping.follow(mapping.pose(w, best.alpha, best.t, moving=np.array(moving)))
        assert np.abs(found.z - best.z).max() < 1e-8


@pytest.mark.parametrize(
    ("preset", "bend", "keep"), [("arc", 60, "similarity"), ("inflate", 80, "similarity"), ("inflate", 80, "rigid")]
)
def test_features_that_a_curved_frame_cuts_have_room_between_its_nodes(preset: str, bend: float, keep: Keep) -> None:
    mapping, w = FeatureMapping(GRID, find_features(GRID, cut_by_the_edge()), keep=keep), as_complex(bent(preset, bend))
    cuts, before = cuts_of(mapping), mapping.place(w)
    alpha, t = fit_cuts(cuts, w, before.alpha, before.t)

    def least_room(alpha: Complexes, t: Complexes) -> float:
        """Return the least share of its room that a corner between a cut feature and the frame has."""
        seen = [(w.ravel()[cut.outside] - t[cut.number]) / alpha[cut.number] - cut.a for cut in cuts]
        areas = [(np.conj(cut.b - cut.a) * q).imag / cut.room for cut, q in zip(cuts, seen, strict=True)]
        return float(np.concatenate(areas).min())

    assert len(cuts) == 2
    assert least_room(before.alpha, before.t) < 0
    assert least_room(alpha, t) > 0.999


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
