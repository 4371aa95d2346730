import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.arrays import InputError, Points
from core.curves import Curve
from core.factor import Factor
from core.grid import Grid
from core.mapping import free_plate
from core.mapping.editing import Editing, Frame, edit_grid
from core.mapping.frames import Complexes, as_complex, as_positions
from core.mapping.handles import Handles
from core.mapping.held_plate import HeldPlate

GRID = Grid(120, 90, cell_px=3)
PLACES = np.array([[30.2, 40.7], [80.0, 20.0], [70.5, 61.3], [71.9, 60.1]])
EDITINGS: dict[Frame, Editing] = {"held": Editing(GRID), "free": Editing(GRID, frame="free")}
FRAMES: list[Frame] = ["held", "free"]


def at(places: Points, z: Points) -> Points:
    nodes, weights = GRID.weights_at(places)
    return np.asarray((z.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1))


def similar(points: Points, alpha: complex, shift: complex) -> Points:
    return as_positions(as_complex(points) * alpha + shift)


@pytest.mark.parametrize("frame", FRAMES)
def test_handles_reach_their_targets(frame: Frame) -> None:
    to = PLACES + np.random.default_rng(0).normal(0, 5, PLACES.shape)
    EDITINGS[frame].hold(PLACES)
    assert np.abs(at(PLACES, EDITINGS[frame].solve(to)) - to).max() < 1e-9


@pytest.mark.parametrize("frame", FRAMES)
def test_no_edit_is_the_identity(frame: Frame) -> None:
    EDITINGS[frame].hold(PLACES)
    assert np.abs(EDITINGS[frame].solve(PLACES) - GRID.nodes).max() < 1e-9


@settings(max_examples=25)
@given(st.floats(0.3, 3), st.floats(-3, 3), st.floats(-100, 100), st.integers(2, 4))
def test_a_similar_edit_gives_that_similarity(scale: float, angle: float, shift: float, count: int) -> None:
    alpha, t = scale * np.exp(1j * angle), shift * (1 + 0.3j)
    for frame, editing in EDITINGS.items():
        editing.hold(PLACES[:count])
        wanted = similar(GRID.nodes, alpha, t)
        found = editing.solve(similar(PLACES[:count], alpha, t), base=None if frame == "free" else wanted)
        assert np.abs(found - wanted).max() < 1e-7


def test_one_handle_on_a_free_picture_moves_it_whole() -> None:
    editing = EDITINGS["free"]
    editing.hold(PLACES[:1])
    assert np.abs(editing.solve(PLACES[:1] + [7, -4]) - GRID.nodes - [7, -4]).max() < 1e-9


def test_the_held_frame_stays_where_the_base_has_it() -> None:
    base = GRID.nodes * np.array([2.0, 1.5])
    editing = EDITINGS["held"]
    editing.hold(PLACES)
    assert np.array_equal(editing.solve(PLACES + 9, base)[GRID.outline], base[GRID.outline])


def test_a_handle_added_later_gives_the_same_as_all_at_once() -> None:
    late = Editing(GRID)
    late.hold(PLACES[[1, 3]])
    late.hold(PLACES)
    to = PLACES + [[5, 1], [0, 3], [2, 2], [2.5, 2]]
    EDITINGS["held"].hold(PLACES)
    assert np.abs(late.solve(to) - EDITINGS["held"].solve(to)).max() < 1e-9


def test_columns_that_are_kept_give_what_a_solve_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    to = PLACES + np.random.default_rng(1).normal(0, 5, PLACES.shape)
    kept, solved = Editing(GRID, frame="free"), Editing(GRID, frame="free")
    for count in (2, 4, 3):
        kept.hold(PLACES[:count])
        monkeypatch.setattr(free_plate, "_KEPT_AT_MOST", 3 * GRID.size)
        solved.hold(PLACES[:count])
        monkeypatch.undo()
        assert np.abs(kept.solve(to[:count]) - solved.solve(to[:count])).max() < 1e-6


def test_a_dragged_handle_costs_no_substitution(monkeypatch: pytest.MonkeyPatch) -> None:
    editing = Editing(GRID, frame="free")
    editing.hold(PLACES)

    def refuse(*_: object) -> None:
        raise AssertionError("a substitution")

    monkeypatch.setattr(Factor, "solve", refuse)
    assert np.abs(at(PLACES, editing.solve(PLACES + [3.0, 1.0])) - PLACES - [3.0, 1.0]).max() < 1e-9


@pytest.mark.parametrize("frame", ["held", "free"])
def test_handles_declared_afresh_leave_the_same_bits_and_are_not_answered_twice(
    frame: Frame, monkeypatch: pytest.MonkeyPatch
) -> None:
    used, new = Editing(GRID, frame=frame), Editing(GRID, frame=frame)
    used.hold(PLACES[::-1])
    for editing in (used, new):
        editing.hold(PLACES, afresh=True)
    assert np.array_equal(used.solve(PLACES * 1.1), new.solve(PLACES * 1.1))
    monkeypatch.setattr(type(new._plate), "hold", None)
    new.hold(PLACES, afresh=True)


@pytest.mark.parametrize("size", [(120, 90), (24, 300), (90, 9), (9, 9), (6, 200)])
def test_a_held_frame_bends_as_little_as_the_handles_allow(size: tuple[int, int]) -> None:
    """The answer has the gradient of E at nodes that no handle holds, within the outline: zero."""
    grid = Grid(*size, cell_px=3)
    places = np.array([[0.4, 0.5], [0.7, 0.3], [0.71, 0.33]]) * size
    handles = Handles(places, places + [[4.0, 1.0], [-2.0, 3.0], [-2.5, 3.0]])
    d = as_complex(edit_grid(grid, handles) - grid.nodes)
    unit = np.sqrt(np.prod(grid.cell))
    width, height = grid.cell / unit

    def sides(z: Complexes) -> Complexes:
        padded = np.pad(z, 1)
        x = (2 * z - padded[1:-1, :-2] - padded[1:-1, 2:]) / width**2
        return np.asarray(x + (2 * z - padded[:-2, 1:-1] - padded[2:, 1:-1]) / height**2)

    inner = d[1:-1, 1:-1]
    length = 0.1 * np.hypot(*grid.shape)
    forces = np.zeros(grid.shape, np.complex128)
    forces[1:-1, 1:-1] = sides(inner) + length**2 * sides(sides(inner))
    at_handles = np.zeros(grid.size, bool)
    at_handles[grid.weights_at(handles.points(grid)[0])[0]] = True
    loose = ~at_handles.reshape(grid.shape)
    assert np.abs(forces).max() > 0.01
    assert np.abs(forces[loose]).max() < 1e-9 * np.abs(forces).max()


@pytest.mark.parametrize("frame", FRAMES)
def test_handles_that_are_let_go_leave_the_base(frame: Frame, capfd: pytest.CaptureFixture[str]) -> None:
    editing = Editing(GRID, frame=frame)
    editing.hold(PLACES)
    editing.hold(PLACES[:0])
    assert np.array_equal(editing.solve(PLACES[:0]), GRID.nodes)
    assert capfd.readouterr() == ("", "")


def test_responses_are_what_the_answers_have_at_the_places() -> None:
    grid = Grid(300, 170, cell_px=7)
    places = np.random.default_rng(3).uniform(8, 160, (9, 2))
    plate = HeldPlate(grid, cell=(1.02, 0.98), rounded=5.0)
    plate.hold(places[[2, 5]])
    S = plate.hold(places)
    nodes, weights = grid.weights_at(places)
    for force, row in zip(np.eye(9, dtype=np.complex128), S, strict=True):
        assert np.abs((plate.answer(force)[nodes] * weights).sum(axis=1) - row).max() < 1e-12 * S.max()


def test_an_inner_curve_reaches_its_target() -> None:
    source = Curve(np.array([[20.0, 30], [50, 10], [80, 50], [100, 40]]))
    target = Curve(np.array([[20.0, 35], [50, 25], [80, 60], [100, 42]]))
    z = edit_grid(GRID, Handles(np.empty((0, 2)), np.empty((0, 2)), [(source, target)]))
    t = np.linspace(0, 1, 200)
    assert np.hypot(*(at(source.at(t), z) - target.at(t)).T).max() < 0.15


@pytest.mark.parametrize("place", [[-50.0, 40.0], [60.0, 500.0], [-0.5, 40.0], [0.0, 0.0]])
def test_a_pin_outside_pulls_on_the_nearest_place_inside(place: list[float]) -> None:
    pin = np.array([place])
    z = edit_grid(GRID, Handles(pin, pin + 2))
    inside = np.clip(pin, [2.5, 2.5], [116.5, 86.5])
    assert np.abs(at(inside, z) - inside - 2).max() < 1e-9
    assert np.array_equal(z[GRID.outline], GRID.nodes[GRID.outline])


def test_a_curve_that_leaves_the_picture_is_held_once_where_it_does(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("handles on one spot")

    monkeypatch.setattr(np.linalg, "pinv", refuse)
    source = Curve(np.array([[-60.0, 30], [-20, 31], [60, 40], [110, 40]]))
    target = Curve(source.points + [[0, 9], [0, 9], [0, 9], [0, 3]])
    z = edit_grid(GRID, Handles(np.empty((0, 2)), np.empty((0, 2)), [(source, target)]))
    t = np.linspace(0, 1, 200)
    inside = (source.at(t)[:, 0] > 12) & (source.at(t)[:, 0] < 100)
    assert np.hypot(*(at(source.at(t), z) - target.at(t)).T)[inside].max() < 0.3


def test_two_pins_on_one_spot_that_agree_are_one() -> None:
    twice, once = PLACES[[0, 0, 1]], PLACES[:2]
    assert np.allclose(edit_grid(GRID, Handles(twice, twice + 3)), edit_grid(GRID, Handles(once, once + 3)))


def test_two_pins_on_one_spot_that_disagree_are_refused() -> None:
    with pytest.raises(InputError, match=r"pins\[0\] and pins\[2\]"):
        Handles(PLACES[[0, 1, 0]], PLACES[[0, 1, 0]] + [[0, 0], [0, 0], [9, 9]]).points(GRID)


def test_handles_that_do_not_pair_up_are_refused() -> None:
    with pytest.raises(InputError, match="2 places"):
        Handles(PLACES[:2], PLACES[:1])
    line = np.array([[0.0, 0], [1, 1], [2, 2], [3, 3]])
    twice = np.concatenate([line, line[1:] + 3])
    with pytest.raises(InputError, match=r"curves\[0\]"):
        Handles(PLACES[:0], PLACES[:0], [(Curve(line), Curve(twice))])


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (2, 2), (3, 3)])
def test_tiny_pictures_take_pins(size: tuple[int, int]) -> None:
    for frame in FRAMES:
        z = edit_grid(Grid(*size), Handles(np.zeros((1, 2)), np.full((1, 2), 0.1)), frame=frame)
        assert np.isfinite(z).all()
