"""What is regrown is given back to the plain deformation wherever it costs more, and never else."""

import numpy as np
import pytest

from core.arrays import Bools, Singles
from core.progress import run
from core.retexture.job import Settings, retexture
from core.retexture.retract import retract
from core.retexture.sampling import Kernel, read
from core.retexture.stretch import stretch_cost, structure
from core.retexture.synthesis.graph_cut import DEFORMED, GROWN, GrownPicture
from core.retexture.synthesis.patches import PatchShape
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, bent, stripes

SIZE = 60, 80
BOX = slice(10, 50), slice(10, 70)
CHOSEN = Settings(PatchShape(), reach_px=60.0)


def identity() -> Singles:
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    return np.stack([x, y], axis=-1).astype(np.float32)


def scaled(x: float, y: float) -> Singles:
    """Return places `x` and `y` times as far from the middle as the pixels that show them."""
    middle = np.array([40, 30], np.float32)
    return np.asarray(middle + (identity() - middle) * np.array([x, y], np.float32))


def waves() -> Singles:
    """Return a picture whose brightness changes to the right alone."""
    wave = 0.5 + 0.4 * np.sin(np.mgrid[: SIZE[0], : SIZE[1]][1] / 2.0)
    return np.asarray(np.repeat(wave[..., None], 3, axis=-1), np.float32)


def given_back(regrown: Singles, plain: Singles, usable: Bools | None = None) -> GrownPicture:
    """Return a canvas that shows waves `regrown` in a box, after it was retracted to the `plain` places."""
    nothing = np.zeros(SIZE, bool)
    canvas = GrownPicture(np.zeros((*SIZE, 3), np.float32), plain.copy(), must=nothing, may=~nothing)
    canvas.label[BOX], canvas.place[BOX] = 1, regrown[BOX]
    canvas.state[BOX] = GROWN
    canvas.colour = read(waves(), canvas.place, Kernel.CUBIC)
    canvas._count(regrown[BOX].reshape(-1, 2), 1)
    retract(canvas, waves(), plain, usable)
    return canvas


def cost(x: float, y: float) -> float:
    return float(stretch_cost(structure(waves()), scaled(x, y), np.zeros(SIZE, np.int64))[25:35, 30:50].mean())


def test_only_what_changes_along_a_stretch_costs_and_pressing_as_much_as_magnifying() -> None:
    assert cost(1, 1) == pytest.approx(0, abs=1e-4)
    assert cost(0.5, 1) > 0.1
    assert cost(1, 0.5) < 1e-3 * cost(0.5, 1)
    assert cost(2, 1) == pytest.approx(cost(0.5, 1), rel=0.3)


def test_steps_across_seams_are_no_stretch() -> None:
    place, label = identity(), np.zeros(SIZE, np.int64)
    place[:, 40:] += 20
    label[:, 40:] = 1
    assert stretch_cost(structure(waves()), place, label).max() == pytest.approx(0, abs=1e-6)
    assert stretch_cost(structure(waves()), place, 0 * label).max() > 0.1


def test_what_is_stretched_more_than_by_the_deformation_is_given_back() -> None:
    canvas = given_back(scaled(0.5, 1), identity())
    assert not canvas.label.any()
    np.testing.assert_array_equal(canvas.place, identity())
    np.testing.assert_allclose(canvas.colour[BOX], waves()[BOX], atol=1e-3)
    assert (canvas.state == DEFORMED).all()
    np.testing.assert_allclose(canvas.uses, 0, atol=1e-5)


def test_what_is_stretched_less_stays() -> None:
    canvas = given_back(identity(), scaled(0.5, 1))
    inner = slice(14, 46), slice(14, 66)
    assert (canvas.label[inner] == 1).all()
    np.testing.assert_array_equal(canvas.place[inner], identity()[inner])


def test_what_may_not_be_shown_is_not_shown_again() -> None:
    usable = np.ones(SIZE, bool)
    usable[20:30, 20:30] = False
    canvas = given_back(scaled(0.5, 1), identity(), usable)
    assert (canvas.label[~usable] == 1).all()
    assert not canvas.label[:, 50:].any()


def test_what_comes_from_outside_the_picture_is_not_shown_again() -> None:
    found = given_back(scaled(0.5, 1), identity() + np.array([30, 0], np.float32))
    assert (found.label[10:50, 50:70] == 1).all()
    assert not found.label[:, :30].any()


def test_the_result_costs_no_more_than_all_regrown_or_all_deformed(monkeypatch: pytest.MonkeyPatch) -> None:
    known: list[float] = []
    merge = GrownPicture.merge

    def watched(canvas, cover, label, colour, place, usable, data=None):  # type: ignore[no-untyped-def]
        shown = canvas.seams.sum()
        taken = merge(canvas, cover, label, colour, place, usable, data)
        if data is not None:
            regrown = canvas.label.reshape(-1)[cover.pixel] > 0
            known.extend([shown + data[0].sum(), data[1].sum()])
            known.append(canvas.seams.sum() + np.where(regrown, data[0], data[1]).sum())
        return taken

    monkeypatch.setattr(GrownPicture, "merge", watched)
    found = run(retexture(stripes(), bent(), CHOSEN, previews=False))
    regrown, plain, shown = known
    assert shown < 0.9 * min(regrown, plain)
    assert (found.label > 0).any()


def test_a_picture_that_shows_no_stretch_is_left_to_the_deformation() -> None:
    grey = np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
    assert not run(retexture(grey, bent(), CHOSEN, previews=False)).label.any()
