"""Straight lines as rods in the plate that handles bend: how straight they stay, and what they cost no one."""

import cv2
import numpy as np
import pytest

from core.arrays import Floats, Points
from core.grid import Grid, find_features
from core.mapping.features.straight_lines import Lines
from core.mapping.handles.dirichlet_plate import HeldPlate
from core.mapping.handles.handles import Handles
from core.mapping.handles.plate import Frame, HandleField, make_plate
from core.mapping.handles.probes import Probes
from core.mapping.handles.rods import Rods, RodSystem, Slides
from core.mapping.handles.turned import Base
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.options import MappingOptions
from core.mapping.result import Warped
from core.mapping.warper import Warper
from core.progress import run
from core.warps.presets import make_warp

SIZE = 300, 200
GRID = Grid(*SIZE, cell_px=4)
HORIZON, INSIDE = np.array([[[-0.5, 60.0], [299.5, 64.0]]]), np.array([[[40.0, 60.0], [260.0, 66.0]]])
UP = np.array([[150.0, 50.0]]), np.array([[0.0, -25.0]])
TWO = np.array([[150.0, 61.9], [60.0, 130.0]]), np.array([[20.0, -25.0], [0.0, 20.0]])
MOVES = {"up": UP, "two": TWO}


def places(z: Points, at: Points) -> Points:
    nodes, weights = GRID.weights_at(at)
    return np.asarray((z.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1))


def bend(z: Points, ends: Points) -> float:
    """Return how far the furthest point of the lines is from the straight line that fits each best, in pixels."""
    worst = 0.0
    for start, end in ends:
        there = places(z, start + (end - start) * np.linspace(0, 1, 60)[:, None])
        there -= there.mean(axis=0)
        worst = max(worst, float(np.abs(there @ np.linalg.svd(there, full_matrices=False)[2][1]).max()))
    return worst


def dragged(
    lines: Points | None,
    move: tuple[Points, Points],
    *,
    features: bool = False,
    frame: Frame = "held",
    live: bool = False,
    plain: Points = GRID.nodes,
) -> Warped:
    """Return the answer to pins that are moved, after some frames or at rest, in which they are met."""
    mask = np.zeros(SIZE[::-1], np.uint8)
    if features:
        cv2.circle(mask, (80, 110), 34, 255, -1)
        cv2.circle(mask, (200, 120), 40, 255, -1)
    warper = Warper(GRID)
    warper.use(find_features(GRID, mask), MappingOptions(lines=None if lines is None else Lines(lines), frame=frame))
    at, by = move
    handles = Handles(at, places(plain, at) + by)
    found = [warper.frame(plain, handles) for _ in range(4)][-1] if live else run(warper.settle(plain, handles))
    assert np.abs(places(found.warped, at) - handles.pins_to).max() < 0.1
    return found


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("features", [False, True])
@pytest.mark.parametrize("live", [False, True])
@pytest.mark.parametrize("ends", [HORIZON, INSIDE], ids=["across", "inside"])
def test_a_line_stays_straight_where_pins_lift_it(ends: Points, live: bool, features: bool, move: str) -> None:
    before, found = (dragged(lines, MOVES[move], features=features, live=live) for lines in (None, ends))
    assert bend(before.warped, ends) > 10
    # Two pins draw features that lie beside the line apart from it, and those never yield.
    assert bend(found.warped, ends) < (0.45 if features and move == "two" else 0.25) * bend(before.warped, ends)
    assert live or not found.folded.any()
    assert found.outline_moved_px == 0
    assert max((feature.residual for feature in found.features), default=0) < 1e-9


@pytest.mark.parametrize("features", [False, True])
def test_where_the_frame_is_free_lines_stay_straight(features: bool) -> None:
    at = np.array([[150.0, 61.9], [60.0, 130.0], [240.0, 120.0]])
    move = at, np.array([[0.0, -25.0], [0.0, 10.0], [0.0, 10.0]])
    before, found = (dragged(lines, move, features=features, frame="free").warped for lines in (None, np.array(INSIDE)))
    assert bend(found, INSIDE) < (0.65 if features else 0.3) * bend(before, INSIDE)


def test_a_held_frame_slides_with_a_line_that_ends_on_it_and_stays_a_rectangle() -> None:
    found = dragged(HORIZON, UP).warped
    for side, axis in ((found[:, 0], 1), (found[:, -1], 1), (found[0], 0), (found[-1], 0)):
        assert np.diff(side[:, axis]).min() > 0
        assert np.ptp(side[:, 1 - axis]) < 1e-9
    assert (places(found, HORIZON[0]) - HORIZON[0])[:, 1].max() < -10


def test_a_pin_on_the_frame_holds_its_place_where_a_line_ends() -> None:
    at = np.array([[-0.5, 60.0], [150.0, 50.0]])
    found = dragged(HORIZON, (at, np.array([[0.0, 0.0], [0.0, -25.0]]))).warped
    assert bend(found, HORIZON) < 0.5 * bend(dragged(None, UP).warped, HORIZON)


@pytest.mark.parametrize("live", [False, True])
def test_a_frame_that_glides_goes_on_gliding_with_lines_under_a_pin(live: bool) -> None:
    narrow = GRID.nodes * [0.6, 1.0]
    before, found = (dragged(lines, UP, features=True, live=live, plain=narrow).warped for lines in (None, HORIZON))
    assert bend(found, HORIZON) < 0.25 * bend(before, HORIZON)


def test_where_w_bends_the_frame_only_inner_lines_move() -> None:
    arch = make_warp("arch", *SIZE, bend=20)(GRID.nodes)
    found = dragged(HORIZON, UP, plain=arch).warped
    assert np.array_equal(found[GRID.outline], arch[GRID.outline])


def test_the_plate_with_rods_is_at_its_least_energy() -> None:
    """Forces on points and rods balance: no motion that points allow lowers plate and bends together."""
    rng = np.random.default_rng(0)
    rods = Rods.of(GRID, Lines(INSIDE), 3.0)
    points = np.array([[90.0, 50.0], [160.0, 120.0]])
    field = HandleField(GRID, make_plate(GRID, "held"), Probes.of_points(points), rods=rods)
    turned = field.still(Base.of(as_complex(GRID.nodes)), slides=True)
    asked = np.array([3.0 - 20j, 4.0 + 9j])
    d = field.displace(asked, turned)
    assert field.at_points(d) == pytest.approx(asked, abs=1e-9)

    def energy(z: Complexes) -> float:
        bends = rods.bends(rods.read(GRID, z.ravel()), turned.normals)
        return plate_energy(z) + float((bends**2 / rods.softness).sum())

    def plate_energy(z: Complexes) -> float:
        plate = field._plate
        assert isinstance(plate, HeldPlate)
        grid = plate._grid
        parts = np.stack([z.real, z.imag])[:, 1:-1, 1:-1]
        waves = grid.x.sums(grid.y.sums(parts, axis=-2), axis=-1)[:, 1:-1, 1:-1]
        L = grid.y.eigenvalues[:, None] / grid.cell[1] ** 2 + grid.x.eigenvalues / grid.cell[0] ** 2
        return float(((L + L**2 / plate._shifts[1]) * waves**2).sum())

    bare = HandleField(GRID, make_plate(GRID, "held"), Probes.of_points(points))
    assert energy(bare.displace(asked)) > energy(d)
    for _ in range(3):
        wish = np.where(GRID.outline, 0, rng.normal(size=GRID.shape) + 1j * rng.normal(size=GRID.shape))
        other = wish - bare.displace(bare.at_points(wish))  # moves no point
        assert energy(d + 1e-3 * other) > energy(d)
    way = bare.displace(asked) - d
    assert energy(d + 1e-3 * way) > energy(d) < energy(d - 1e-3 * way)


def test_motions_of_bodies_leave_no_force_on_them() -> None:
    rng = np.random.default_rng(1)
    n, k, u = 6, 4, 2
    full = rng.normal(size=(n + k, n + k))
    S = full @ full.T + np.eye(n + k)
    rods = Rods.of(GRID, Lines(INSIDE), 10.0)
    rods = Rods(rods.at, rods.M, rods.owner[:k], rods.softness[:k], rods.first, rods.last, rods.ends, rods.fixed)
    inverse = np.linalg.inv(S[:n, :n])
    system = RodSystem(rods, inverse, S[:n, n:], S[n:, n:])
    Q = rng.normal(size=(n, u)) + 1j * rng.normal(size=(n, u))
    g, normals = rng.normal(size=n) + 1j * rng.normal(size=n), np.exp(1j * rng.normal(size=k))
    bends: Floats = rng.normal(size=k)
    none = np.zeros((GRID.size, 0), np.complex128)
    stays = Slides(none, np.zeros((0, 0)), none[:n], none[:k])
    found = system.find(g, Q, stays, normals, bends)
    pushes = found.forces
    on_points = inverse @ (g + Q @ found.motions - S[:n, n:] @ pushes)
    assert (Q.conj().T @ on_points).real == pytest.approx(np.zeros(u), abs=1e-9)
    now = bends + (np.conj(normals) * (S[n:, :n] @ on_points + S[n:, n:] @ pushes)).real
    assert now == pytest.approx(-rods.softness * (np.conj(normals) * pushes).real, abs=1e-9)
