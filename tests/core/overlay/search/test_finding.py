"""Several finds, of which the best is kept, and where large texels are looked for."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, find_lattices
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import Evidence
from core.overlay.search import finding
from core.overlay.search.finding import Find, complete_likely, find_cloth, find_print
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import Scene, make_scene, motif
from tests.core.overlay.prints import LARGE, canvas_of, painted, sett


def test_large_texels_are_looked_for_where_no_lattice_is_found(
    printed: Scene, followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(*_: object, **__: object) -> Job[list[Lattice]]:
        yield Progress(0.0, "")
        raise NoPatternError

    def found_large(photo: Floats, *_: object, **__: object) -> Job[list[tuple[FittedCloth, Fit, Evidence]]]:
        np.testing.assert_array_equal(photo, printed.photo)
        yield Progress(0.0, "")
        return [(*followed, Evidence(-1.0, -0.1))]

    monkeypatch.setattr(finding, "find_lattices", none)
    monkeypatch.setattr(finding, "find_large", found_large)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(-1.0, -0.1))
    (found,) = run(find_cloth(printed.photo, painted(printed.photo), 0))
    assert found.followed.cells.mean() > 0.9
    assert abs(np.linalg.det(found.cloth.basis)) == pytest.approx(np.linalg.det(printed.basis), rel=0.1)
    with pytest.raises(NoPatternError):
        run(find_cloth(printed.photo, painted(printed.photo), 0, with_large=False))


def leave(cloth: FittedCloth, found: Fit, *_: object) -> Job[tuple[FittedCloth, Fit]]:
    yield Progress(0.0, "")
    return cloth, found


def test_the_best_of_what_lattices_tell_is_kept_beside_all_that_keypoints_tell(
    followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(finding, "complete", leave)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(1.0, 0.3))
    lattices = [Find(*followed, Evidence(explained, 0.3)) for explained in (1.0, 3.0, 2.0)]
    # Of few texels one may foretell less of another than colours that have nothing to do with it would.
    told = [Find(*followed, Evidence(-9.0, share), repeats=True) for share in (-0.1, -1.5)]
    ends = run(complete_likely([*told, *lattices], 0))
    assert [(end.repeats, end.explained) for end in ends] == [(False, 1.0), (True, 1.0), (True, 1.0)]


@pytest.mark.parametrize("is_left", [True, False])
def test_the_likeliest_find_is_completed_or_the_next_where_nothing_is_left_of_it(
    followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch, *, is_left: bool
) -> None:
    seen: list[int] = []

    def complete(cloth: FittedCloth, found: Fit, *_: object) -> Job[tuple[FittedCloth, Fit]]:
        seen.append(len(found.pieces))
        if len(seen) == 1 and not is_left:
            raise NoPatternError
        return (yield from leave(cloth, found))

    monkeypatch.setattr(finding, "complete", complete)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(2.0, 0.3))
    cloth, fit = followed
    # A find of k pieces is the k-th likeliest.
    finds = [Find(cloth, replace(fit, pieces=fit.pieces[:1] * k), Evidence(9.0 - k, 0.3)) for k in (3, 1, 2)]
    (end,) = run(complete_likely(finds, 0))
    assert seen == ([1] if is_left else [1, 2])
    assert (end.explained, len(end.followed.pieces)) == (2.0, seen[-1])


@pytest.mark.parametrize(
    ("share", "repeats", "is_credible"),
    [(0.1, False, True), (0.01, False, False), (-0.9, True, True), (-1.1, True, False)],
)
def test_what_colours_that_have_nothing_to_do_with_it_would_foretell_as_well_is_none(
    followed: tuple[FittedCloth, Fit], share: float, *, repeats: bool, is_credible: bool
) -> None:
    assert Find(*followed, Evidence(1.0, share), repeats=repeats).is_credible == is_credible


@pytest.mark.parametrize(("share", "is_whole", "is_sure"), [(0.7, True, True), (0.7, False, False), (0.3, True, False)])
def test_a_clear_find_is_sure_where_it_covers_nearly_all_that_may_be_cloth(
    followed: tuple[FittedCloth, Fit], share: float, *, is_whole: bool, is_sure: bool
) -> None:
    cloth, fit = followed
    cells = fit.pieces[0].cells.copy()
    cells[len(cells) if is_whole else len(cells) // 2 :] = False
    fit = replace(fit, pieces=(replace(fit.pieces[0], cells=cells),))
    assert Find(cloth, fit, Evidence(1.0, share)).is_sure == is_sure


@pytest.mark.parametrize(("share", "kept"), [(-1.0, 9.0), (0.3, 2.0)])
def test_a_find_that_completing_makes_incredible_stays_as_it_was(
    followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch, share: float, kept: float
) -> None:
    monkeypatch.setattr(finding, "complete", leave)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(2.0, share))
    assert run(complete_likely([Find(*followed, Evidence(9.0, 0.4))], 0))[0].explained == kept


@pytest.mark.parametrize(("least", "is_found"), [(4.0, True), (20.0, False)])
def test_a_print_has_to_show_enough_texels_where_nobody_said_that_there_is_cloth(
    printed: Scene, least: float, is_found: bool
) -> None:
    with nullcontext() if is_found else pytest.raises(NoPatternError):
        found, *_ = run(find_print(printed.photo, painted(printed.photo), 0, least=least))
        assert found.repeats


def test_a_print_of_which_completing_leaves_too_few_texels_is_none(
    followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    def large(*_: object, **__: object) -> Job[list[tuple[FittedCloth, Fit, Evidence]]]:
        yield Progress(0.0, "")
        return [(*followed, Evidence(-1.0, -0.5))]

    whole = Find(*followed, Evidence(-1.0, -0.5), repeats=True)
    monkeypatch.setattr(finding, "find_large", large)
    monkeypatch.setattr(finding, "complete", leave)
    photo = followed[0].photo
    assert run(find_print(photo, canvas_of(photo), 0, least=0.9 * whole.texels))[0].texels == whole.texels
    with pytest.raises(NoPatternError):
        run(find_print(photo, canvas_of(photo), 0, least=whole.texels))


@pytest.mark.parametrize("is_left", [True, False])
def test_what_patches_tell_is_refused_where_completing_leaves_nothing(
    followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch, *, is_left: bool
) -> None:
    def large(*_: object, **known: object) -> Job[list[tuple[FittedCloth, Fit, Evidence]]]:
        assert known == {"alike": "patches", "least": None, "texel_px": 120}
        yield Progress(0.0, "")
        return [(*followed, Evidence(-1.0, -0.5))]

    def lose(*_: object) -> Job[tuple[FittedCloth, Fit]]:
        yield Progress(0.0, "")
        raise NoPatternError

    monkeypatch.setattr(finding, "find_large", large)
    monkeypatch.setattr(finding, "complete", leave if is_left else lose)
    photo = followed[0].photo
    with nullcontext() if is_left else pytest.raises(NoPatternError):
        assert run(find_print(photo, painted(photo), 0, alike="patches", texel_px=120))[0].repeats


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

    monkeypatch.setattr(finding, "find_large", none)
    monkeypatch.setattr(finding, "agreement", lambda *_: 0.0)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(1.0, share))
    photo = small.photo[:110, :120]
    job = find_cloth(photo, canvas_of(photo), 0)
    if refused:
        with pytest.raises(NoPatternError):
            run(job)
    else:
        assert run(job)[0].followed.cells.mean() > 0.9
    assert len(looked) == tried


def test_a_marked_texel_is_enough_where_there_are_few() -> None:
    scene = make_scene(sett(), size=(150, 160), basis=LARGE)
    marked = Proposal(np.array([75.0, 70.0]), scene.basis, 1.0)
    canvas, rng = canvas_of(scene.photo), np.random.default_rng(0)
    assert len(run(find_lattices(canvas, rng, start=marked))[0]) < 9
    one = canvas_of(np.clip(0.6 + rng.normal(0, 0.02, scene.photo.shape), 0, 1))
    with pytest.raises(NoPatternError):
        run(find_lattices(one, rng, start=marked))
