"""Texels of which a photo shows a few only, and lattices that are none of the cloth's."""

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.detection.alignment import FlatPicture, PatchFrames
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, find_lattices, flat_canvas
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import Evidence
from core.overlay.registration.fitting import begun
from core.overlay.search import finding
from core.overlay.search import large_periods as wide
from core.overlay.search.finding import find_cloth
from core.overlay.search.large_periods import find_wide, propose_wide, repeats_within, share_inside
from core.overlay.texel import Texel
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import Scene, make_scene, motif

LARGE = np.array([[62.0, 6.0], [-5.0, 62.0]])


def sett(n: int = 96) -> Texel:
    """Return a texel of crossing stripes of several widths."""
    across, down = (np.full((n, 3), 0.85) for _ in range(2))
    for stripes, first in ((across, 0.05), (down, 0.1)):
        for width, colour in ((0.14, (0.1, 0.1, 0.3)), (0.2, (0.7, 0.2, 0.1)), (0.1, (0.2, 0.4, 0.2))):
            stripes[round(first * n) : round((first + width) * n)] = colour
            first += width + 0.12
    return Texel((across[None] + down[:, None]) / 2)


@pytest.fixture(scope="module")
def tartan() -> Scene:
    return make_scene(sett(), size=(148, 152), basis=np.array([[44.0, 6.0], [-5.0, 44.0]]))


def canvas_of(photo: Floats) -> FlatPicture:
    return flat_canvas(photo, np.ones(photo.shape[:2], bool))


@pytest.fixture(scope="module")
def followed(tartan: Scene) -> tuple[FittedCloth, Fit]:
    """Return the cloth of the tartan as it is found from large texels, of which few are tried."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wide, "TRIALS", 8)
        return run(find_wide(tartan.photo, canvas_of(tartan.photo), np.random.default_rng(0)))


def test_few_large_texels_are_found_by_following_them(tartan: Scene, followed: tuple[FittedCloth, Fit]) -> None:
    steps = np.linalg.solve(tartan.basis, followed[0].basis)
    assert np.abs(steps - np.rint(steps)).max() < 0.15
    assert abs(np.linalg.det(np.rint(steps))) == 1


def test_large_texels_are_looked_for_where_no_lattice_is_found(
    tartan: Scene, followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(*_: object, **__: object) -> Job[list[Lattice]]:
        yield Progress(0.0, "")
        raise NoPatternError

    def found_wide(photo: Floats, *_: object, **__: object) -> Job[tuple[FittedCloth, Fit]]:
        np.testing.assert_array_equal(photo, tartan.photo)
        yield Progress(0.0, "")
        return followed

    monkeypatch.setattr(finding, "find_lattices", none)
    monkeypatch.setattr(finding, "find_wide", found_wide)
    cloth, found = run(find_cloth(tartan.photo, canvas_of(tartan.photo), 0))
    assert found.cells.mean() > 0.9
    assert abs(np.linalg.det(cloth.basis)) == pytest.approx(np.linalg.det(tartan.basis), rel=0.1)


def test_nothing_large_is_found_in_noise_or_in_one_motif() -> None:
    rng = np.random.default_rng(0)
    photo = np.full((220, 240, 3), 0.6) + rng.normal(0, 0.01, (220, 240, 3))
    photo[60:140, 70:150] = sett(80).pixels
    for picture in (photo, rng.random((220, 240, 3))):
        with pytest.raises(NoPatternError):
            run(find_wide(picture, canvas_of(picture), rng))


def test_a_patch_outside_the_region_does_not_speak_for_a_texel() -> None:
    scene = make_scene(sett(), size=(215, 225), basis=LARGE)
    valid = np.ones(scene.photo.shape[:2], bool)
    valid[:, 150:] = False
    share = share_inside(valid, np.array([100.0, 100.0]), 60)
    assert share[-1, 0] == 1
    assert share.min() < 0.1
    proposals = propose_wide(canvas_of(scene.photo).image, valid, np.random.default_rng(0))
    assert proposals
    for proposal in proposals:
        assert proposal.point[0] < 150 - 29


def cloth_of(scene: Scene) -> tuple[FittedCloth, Fit]:
    keys = np.stack(np.meshgrid(np.arange(6), np.arange(5)), -1).reshape(-1, 2)
    frames = PatchFrames(
        24.0 * keys.astype(np.float64) + 20, np.tile(24.0 * np.eye(2), (len(keys), 1, 1)), np.ones(len(keys))
    )
    canvas, lattice = canvas_of(scene.photo), Lattice(keys, frames)
    return run(begun(scene.photo, canvas, lattice, 0, trusted=True))


@pytest.fixture(scope="module")
def small() -> Scene:
    return make_scene(motif(), basis=24.0 * np.eye(2), bend=0.0)


@pytest.mark.parametrize(("share", "tried", "refused"), [(0.9, 0, False), (0.4, 1, False), (0.02, 1, True)])
def test_large_texels_are_looked_for_where_a_lattice_explains_little_and_what_explains_less_is_refused(
    small: Scene, monkeypatch: pytest.MonkeyPatch, share: float, tried: int, refused: bool
) -> None:
    looked: list[Floats] = []

    def none(photo: Floats, *_: object, **__: object) -> None:
        looked.append(photo)
        raise NoPatternError

    monkeypatch.setattr(finding, "find_wide", none)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(1.0, share))
    photo = small.photo[:110, :120]
    job = find_cloth(photo, canvas_of(photo), 0)
    if refused:
        with pytest.raises(NoPatternError):
            run(job)
    else:
        assert run(job)[1].cells.mean() > 0.9
    assert len(looked) == tried


def test_an_exemplar_of_stripes_proposes_nothing() -> None:
    y, x = np.indices((220, 240))
    stripes = 0.5 + 0.3 * np.sin(0.4 * x + 0.17 * y)[..., None] * [1, 0.8, 0.6]
    noisy = stripes + np.random.default_rng(0).normal(0, 0.01, stripes.shape)
    everywhere = np.ones((220, 240), bool)
    assert not propose_wide(flat_canvas(noisy, everywhere).image, everywhere, np.random.default_rng(0))


def test_a_marked_texel_is_enough_where_there_are_few() -> None:
    scene = make_scene(sett(), size=(150, 160), basis=LARGE)
    marked = Proposal(np.array([75.0, 70.0]), scene.basis, 1.0)
    canvas, rng = canvas_of(scene.photo), np.random.default_rng(0)
    assert len(run(find_lattices(canvas, rng, start=marked))[0]) < 9
    one = canvas_of(np.clip(0.6 + rng.normal(0, 0.02, scene.photo.shape), 0, 1))
    with pytest.raises(NoPatternError):
        run(find_lattices(one, rng, start=marked))


def test_a_texel_of_several_repeats_within_and_one_of_its_own_does_not() -> None:
    assert not repeats_within(motif())
    assert not repeats_within(sett())
    rng = np.random.default_rng(0)
    for copies in ((2, 1), (1, 3), (2, 2)):
        several = motif().tiled(*copies)
        assert repeats_within(Texel(several + rng.normal(0, 0.03, several.shape)))


def test_large_texels_that_repeat_within_are_none(small: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    cloth, found = cloth_of(small)
    tried: list[Progress] = []

    def begun_there(*_: object) -> Job[tuple[FittedCloth, Fit]]:
        yield Progress(0.0, "")
        return cloth, found

    def goes_on(_: FittedCloth, begin: Fit, step: Progress) -> Job[Fit]:
        tried.append(step)
        yield step
        return begin

    proposals = [Proposal(np.array([x, 80.0]), 48.0 * np.eye(2), 1.0) for x in (60.0, 65.0, 70.0, 75.0, 80.0)]
    for name, value in (("begun", begun_there), ("goes_on", goes_on), ("repeats_within", lambda _: True)):
        monkeypatch.setattr(wide, name, value)
    monkeypatch.setattr(wide, "propose_wide", lambda *_: proposals)
    monkeypatch.setattr(wide, "weigh", lambda *_: Evidence(1.0, 1.0))
    monkeypatch.setattr(wide, "GOOD", 2.0)
    canvas = canvas_of(small.photo)
    with pytest.raises(NoPatternError):
        run(find_wide(small.photo, canvas, np.random.default_rng(0)))
    assert len(tried) == wide.AGAINST
