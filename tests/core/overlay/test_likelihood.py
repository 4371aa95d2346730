"""Finished finds are compared by how well they explain a photo: a region can only help."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from core.arrays import Bools, Floats, InputError, Singles
from core.imaging.image import Image
from core.overlay import cloth_search, decomposition
from core.overlay.cloth_search import Known, find, follow
from core.overlay.decomposition import Decomposition, decompose, decompose_whole_cloth
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.seeding import NoPatternError
from core.overlay.filters import shrinking
from core.overlay.filters.smoothing import gaussian
from core.overlay.found_cloth import FoundCloth
from core.overlay.likelihood import count_explained
from core.overlay.registration import fine_mesh
from core.overlay.search.finding import Find, find_cloth
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import make_scene, motif

SCENE = make_scene(motif(), noise=0.01)
SIZE = SCENE.photo.shape[:2]
EVERYWHERE = np.ones(SIZE, bool)
HALF = EVERYWHERE.copy()
HALF[:, :55] = False
MODEL = (motif()(SCENE.uv) * SCENE.shading[..., None]).astype(np.float32)


def explained(model: Singles, inside: Bools = EVERYWHERE) -> float:
    return count_explained(SCENE.photo, model.astype(np.float32), inside)


def test_the_better_model_and_the_larger_cloth_explain_more_and_light_alone_is_worth_nothing() -> None:
    assert explained(MODEL) > 1.5 * explained(gaussian(MODEL, 2.0)) > 0
    assert explained(MODEL) > 1.5 * explained(MODEL, HALF) > 0
    assert abs(explained(gaussian(MODEL, 25.0))) < 0.05 * explained(MODEL)
    assert abs(explained(1.1 * MODEL) / explained(MODEL) - 1) < 0.3
    assert explained(np.roll(MODEL, 11, axis=1)) < 0


def test_how_the_cloth_stands_out_from_what_is_beside_it_explains_nothing() -> None:
    photo = np.where(HALF[..., None], SCENE.photo, 1.0)
    flat = np.broadcast_to(SCENE.photo[HALF].mean(0), MODEL.shape).astype(np.float32)
    assert abs(count_explained(photo, flat, HALF)) < 0.05 * count_explained(photo, MODEL, HALF)


def find_wrongly(photo: Floats, known: Known) -> Job[list[FoundCloth]]:
    """Return what is found: in a region, with doubts, and coordinates off by a part of a texel that changes."""
    finds = yield from find(photo, known)
    if known.region is None:
        return finds
    found = finds[0]
    return [replace(bent(found, 0.4, 9.0), is_sure=False)]


def bent(found: FoundCloth, texels: float, turns: float) -> FoundCloth:
    """Return a find whose coordinates are off by up to so many texels, in waves of so many radians a texel."""
    moved = [replace(piece, uv=piece.uv + texels * np.sin(turns * piece.uv[..., ::-1])) for piece in found.fit.pieces]
    return replace(found, fit=replace(found.fit, pieces=tuple(moved)))


def find_none(photo: Floats, known: Known) -> Job[list[FoundCloth]]:
    """Return what is found without a region."""
    if known.region is None:
        return (yield from find(photo, known))
    raise NoPatternError


@pytest.mark.parametrize("instead", [find_wrongly, find_none])
def test_where_the_search_in_a_region_fails_the_find_without_it_is_kept(
    monkeypatch: pytest.MonkeyPatch, instead: Any
) -> None:
    usual: Decomposition = run(decompose(SCENE.photo, region=HALF))
    monkeypatch.setattr(cloth_search, "find", instead)
    found = run(decompose(SCENE.photo, region=HALF))
    assert not found.covered[~HALF].any()
    assert found.explained > 0.97 * usual.explained > 0


@pytest.mark.parametrize("is_right_first", [True, False])
def test_of_several_finds_that_is_kept_which_explains_most_once_it_is_split(
    monkeypatch: pytest.MonkeyPatch, *, is_right_first: bool
) -> None:
    def find_both(photo: Floats, known: Known) -> Job[list[FoundCloth]]:
        (right,) = yield from find(photo, known)
        both = [right, bent(right, 0.1, 1.0)]
        return both if is_right_first else both[::-1]

    def find_no_more(*_: Any, **__: Any) -> Job[FoundCloth]:
        yield Progress(0.0)
        raise InputError("")

    (right,) = run(find(SCENE.photo, Known(HALF)))
    explained = decomposition.split(right).explained
    assert right.explained == explained
    monkeypatch.setattr(cloth_search, "find", find_both)
    assert run(decompose(SCENE.photo, region=HALF)).explained == explained
    monkeypatch.setattr(decomposition, "follow", find_no_more)
    image = Image(np.rint(255 * SCENE.photo).astype(np.uint8))
    assert run(decompose_whole_cloth(image, region=HALF)).explained > 0.97 * explained


@pytest.mark.parametrize("is_clear", [True, False])
@pytest.mark.parametrize("is_better", [True, False])
def test_a_find_in_a_region_that_leaves_doubts_is_followed_once_more_and_the_better_one_kept(
    monkeypatch: pytest.MonkeyPatch, *, is_clear: bool, is_better: bool
) -> None:
    def find_doubtful(photo: Floats, known: Known) -> Job[list[FoundCloth]]:
        (found,) = yield from find(photo, known)
        return [replace(bent(found, 0.1, 1.0) if is_better else found, is_sure=True, is_clear=is_clear)]

    def follow_badly(*asked: Any) -> Job[FoundCloth]:
        return bent((yield from follow(*asked)), 0.1, 1.0)

    def find_no_more(*_: Any) -> Job[list[FoundCloth]]:
        yield Progress(0.0)
        raise NoPatternError

    # A mesh of smaller cells mends so little: what is told is which of the finds is kept.
    monkeypatch.setattr(fine_mesh, "SIDES_PX", (SIZE[1], SIZE[1]))
    (right,) = run(find(SCENE.photo, Known(HALF)))
    monkeypatch.setattr(cloth_search, "find", find_doubtful)
    monkeypatch.setattr(cloth_search, "find_again", find_no_more)
    if not is_better:
        monkeypatch.setattr(cloth_search, "follow", follow_badly)
    explained = run(decompose(SCENE.photo, region=HALF)).explained
    assert (explained > 0.97 * right.explained) == (not (is_clear and is_better))


@pytest.mark.parametrize(
    ("is_sure", "is_alike", "ways"),
    [(True, True, ["region"]), (False, True, ["region", "patches"]), (False, False, ["region", "patches", "all"])],
)
def test_where_the_find_in_a_region_leaves_doubts_alike_patches_are_asked_and_if_they_tell_nothing_all_of_the_photo(
    monkeypatch: pytest.MonkeyPatch, *, is_sure: bool, is_alike: bool, ways: list[str]
) -> None:
    searched: list[str] = []

    def find_in(photo: Floats, known: Known) -> Job[list[FoundCloth]]:
        searched.append("all" if known.region is None else "region")
        (found,) = yield from find(photo, known)
        assert found.is_sure
        return [replace(found, is_sure=is_sure)]

    def find_by_patches(
        photo: Floats, canvas: FlatPicture, seed: int, *, alike: str, texel_px: float
    ) -> Job[list[Find]]:
        assert (alike, texel_px) == ("patches", 20)
        assert np.array_equal(canvas.valid[..., 0] > 0, HALF)
        searched.append("patches")
        if not is_alike:
            raise NoPatternError
        return (yield from find_cloth(photo, canvas, seed))

    for name, other in (("find", find_in), ("find_print", find_by_patches)):
        monkeypatch.setattr(cloth_search, name, other)
    assert run(decompose(SCENE.photo, region=HALF, texel_px=20)).covered.any()
    assert searched == ways


@pytest.mark.parametrize("places", [["keypoints"], ["keypoints", "patches"]])
def test_what_nobody_painted_is_looked_for_on_the_object_that_stands_out_too(
    monkeypatch: pytest.MonkeyPatch, places: list[str]
) -> None:
    searched: list[str] = []

    def find_none(_photo: Floats, known: Known) -> Job[list[FoundCloth]]:
        assert known.region is None
        searched.append("photo")
        yield Progress(0.0, "")
        raise NoPatternError

    def find_print_on(
        photo: Floats, canvas: FlatPicture, seed: int, *, alike: str, least: float, texel_px: float
    ) -> Job[list[Find]]:
        assert (least, texel_px) == (cloth_search.LEAST_UNTOLD, 20)
        assert (canvas.valid == 0).any()
        searched.append(alike)
        if alike != places[-1]:
            raise NoPatternError
        return (yield from find_cloth(photo, canvas, seed))

    for name, other in (("find", find_none), ("find_print", find_print_on)):
        monkeypatch.setattr(cloth_search, name, other)
    cloth = np.pad(EVERYWHERE, 50)
    photo = np.where(cloth[..., None], np.pad(SCENE.photo, ((50, 50), (50, 50), (0, 0))), [0.1, 0.25, 0.5])
    covered = run(decompose(photo, texel_px=20)).covered
    assert (covered & cloth).sum() > 0.9 * cloth.sum() > 10 * (covered & ~cloth).sum()
    assert searched == ["photo", *places]


@pytest.mark.parametrize(("is_clear", "ways"), [(True, ["photo"]), (False, ["photo", "object"])])
def test_what_leaves_doubts_where_nothing_is_painted_is_looked_for_on_what_stands_out_too(
    monkeypatch: pytest.MonkeyPatch, *, is_clear: bool, ways: list[str]
) -> None:
    searched: list[str] = []

    def find_in(photo: Floats, known: Known) -> Job[list[FoundCloth]]:
        assert known.region is None
        searched.append("photo")
        (found,) = yield from find(photo, known)
        assert found.is_clear
        return [replace(found, is_clear=is_clear)]

    def find_on_object(_photo: Floats, _known: Known) -> Job[list[FoundCloth]]:
        searched.append("object")
        yield Progress(0.0)
        raise NoPatternError

    monkeypatch.setattr(cloth_search, "find", find_in)
    monkeypatch.setattr(cloth_search, "find_on_object", find_on_object)
    assert run(decompose(SCENE.photo)).covered.any()
    assert searched == ways


@pytest.mark.parametrize(
    ("region", "is_on_it", "is_clear", "is_sure", "ways"),
    [
        (None, True, True, True, ["photo"]),
        (None, True, False, True, ["photo", "object"]),
        (None, False, True, True, ["photo", "object"]),
        (None, False, True, False, ["photo", "object", "patches"]),
        (HALF, False, True, True, ["region"]),
    ],
)
def test_the_whole_cloth_is_looked_for_on_what_stands_out_unless_a_find_lies_there_without_doubt(
    monkeypatch: pytest.MonkeyPatch,
    region: Bools | None,
    *,
    is_on_it: bool,
    is_clear: bool,
    is_sure: bool,
    ways: list[str],
) -> None:
    (found,) = run(find(SCENE.photo, Known()))
    inside = EVERYWHERE if is_on_it else ~found.covered
    searched: list[str] = []

    def find_on(way: str) -> Job[list[FoundCloth]]:
        searched.append(way)
        yield Progress(0.0)
        return [replace(found, is_sure=is_sure, is_clear=is_clear)]

    def find_in(_photo: Floats, known: Known) -> Job[list[FoundCloth]]:
        way = "region" if known.region is HALF else "photo" if known.region is None else "object"
        assert known.may_be_large == (way != "photo")
        return (yield from find_on(way))

    def cut_out(_photo: Floats) -> Job[Bools]:
        yield Progress(0.0)
        return inside

    monkeypatch.setattr(cloth_search, "find", find_in)
    monkeypatch.setattr(cloth_search, "find_object", cut_out)
    monkeypatch.setattr(cloth_search, "find_alike", lambda _photo, _known: find_on("patches"))
    finds = run(cloth_search.find_whole(SCENE.photo, Known(region)))
    assert searched == ways
    # What is found beside it does not count then.
    counts = region is not None or is_on_it
    assert len(finds) == len(ways[0 if counts else 1 :])
    # What was found already is not looked for again, but what stands out is.
    searched.clear()
    first = replace(found, is_sure=is_sure, is_clear=is_clear)
    again = run(cloth_search.find_whole(SCENE.photo, Known(region), [first]))
    assert searched == ways[1:]
    assert (again[0] is first) == counts
    assert len(again) == len(finds)


@pytest.mark.parametrize("is_told", [True, False])
def test_where_cloth_ends_on_what_stands_out_is_a_guess(monkeypatch: pytest.MonkeyPatch, *, is_told: bool) -> None:
    def cut_out(_photo: Floats) -> Job[Bools]:
        yield Progress(0.0)
        return HALF

    def find_no_more(*_: Any, **__: Any) -> Job[FoundCloth]:
        yield Progress(0.0)
        raise InputError("")

    monkeypatch.setattr(cloth_search, "find_object", cut_out)
    monkeypatch.setattr(decomposition, "follow", find_no_more)
    image = Image(np.rint(255 * SCENE.photo).astype(np.uint8))
    found = run(decompose_whole_cloth(image, region=HALF if is_told else None, finds=None if is_told else [])).found
    assert found is not None
    assert not found.cloth.valid[~HALF].any()
    assert found.valid[~HALF].all() != is_told
    assert found.is_told == is_told


def test_where_nothing_stands_out_large_texels_are_looked_for_in_all_of_the_photo(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def find_in(photo: Floats, known: Known) -> Job[list[FoundCloth]]:
        assert known.may_be_large
        return (yield from find(photo, known))

    def cut_out(_photo: Floats) -> Job[Bools]:
        yield Progress(0.0)
        raise NoPatternError

    monkeypatch.setattr(cloth_search, "find", find_in)
    monkeypatch.setattr(cloth_search, "find_object", cut_out)
    assert len(run(cloth_search.find_whole(SCENE.photo, Known()))) == 1


def test_of_a_large_photo_finds_are_compared_at_the_size_that_is_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cloth_search, "find", find_wrongly)
    monkeypatch.setattr(shrinking, "WORKING_PX", 200)
    small = make_scene(motif(), size=(100, 110))
    large, right = (np.repeat(np.repeat(plane, 3, 0), 3, 1) for plane in (small.photo, HALF[:100, :110]))
    found = run(decompose(large, region=right))
    assert found.covered.shape == right.shape
    assert found.covered[:, 180:].mean() > 0.9
