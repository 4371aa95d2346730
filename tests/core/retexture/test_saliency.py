"""What a picture shows once along a curve stays whole; what recurs along it is regrown."""

import numpy as np
import pytest

from core.arrays import Bools, Points, Singles
from core.curves.feature_curves import FeatureCurve
from core.progress import run
from core.retexture import job, saliency
from core.retexture.deformation.coordinates import SpineCurves
from core.retexture.job import Settings, retexture
from core.retexture.result import plain_place
from core.retexture.synthesis.patches import PatchShape
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, arched, straight

REACH_PX, SAMPLE_PX = 80.0, 3.6
X, Y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
THING = np.hypot(X - 70, Y - 135) < 9
MAST = np.abs(X - 150 - 0.2 * (Y - 100)) < 5
FAINT = 0.08
GENTLE = FeatureCurve(straight(), arched(24, 105))


def noise() -> Singles:
    return np.random.default_rng(1).normal(0.5, 0.1, (HEIGHT, WIDTH, 3)).astype(np.float32)


def marked(picture: Singles) -> Bools:
    """Return where (H / 2, W / 2) landmarks along a straight curve are found."""
    places = np.column_stack([X[::2, ::2].ravel(), Y[::2, ::2].ravel()]).astype(float)
    found = saliency.find_landmarks(picture, SpineCurves([straight()]), places, reach_px=REACH_PX, sample_px=SAMPLE_PX)
    return found.reshape(X[::2, ::2].shape)


def test_texture_is_no_landmark_nor_what_runs_along_the_curve_and_wavers() -> None:
    picture = noise()
    picture[Y > 120] -= 0.2
    picture[np.abs(Y - 80 - np.where(np.abs(X - 110) < 9, 3.6, 0)) < 3] += 0.3
    assert not marked(picture).any()


def test_a_thing_is_a_landmark_even_if_it_has_a_twin() -> None:
    picture = noise()
    # So many samples further on that it is among the places compared with.
    twin = np.hypot(X - 70 - 16 * (WIDTH - 1) / 60, Y - 135) < 9
    picture[THING | twin] += 0.4
    found = marked(picture)
    for thing in (THING, twin):
        assert found[thing[::2, ::2]].all()
    assert found.mean() < 0.07


def test_what_recurs_along_the_curve_is_texture() -> None:
    picture = noise()
    picture[np.hypot((X - 10) % 24 - 12, Y - 135) < 9] += 0.4
    assert not marked(picture).any()


def test_a_faint_line_across_the_curve_is_a_landmark_but_a_short_one_is_none() -> None:
    picture = noise()
    picture[MAST] += FAINT
    found = marked(picture)
    middle = MAST[::2, ::2] & (np.abs(Y[::2, ::2] - 100) < 60)
    assert found[middle].mean() > 0.9
    assert not found[:, :60].any()
    short = noise()
    short[MAST & (Y > 100) & (Y < 130)] += FAINT
    assert not marked(short).any()


def shown(picture: Singles, curve: FeatureCurve, origin: Points) -> tuple[Bools, Singles]:
    """Return whether what the deformation has from near `origin` is shown as it has it, and by how far it is not."""
    found = run(retexture(picture, [curve], Settings(PatchShape(), reach_px=60.0)))
    plain = plain_place(found.grid, found.field, (slice(0, HEIGHT), slice(0, WIDTH)))
    there = np.hypot(*np.moveaxis(plain - origin, -1, 0)) < 9
    assert there.any()
    return found.label[there] == 0, np.linalg.norm(found.place - plain, axis=-1)[there]


def test_the_deformation_stands_where_it_shows_a_landmark(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job, "retract", lambda *_: None)
    picture = noise()
    picture[THING] += 0.4
    stands, gap = shown(picture, GENTLE, np.array([70.0, 135.0]))
    assert stands.mean() > 0.95
    assert gap.max() < 1
    assert not shown(noise(), GENTLE, np.array([70.0, 135.0]))[0].any()


def test_a_landmark_is_regrown_where_it_would_be_stretched_much() -> None:
    picture = noise()
    picture[np.hypot(X - 110, Y - 118) < 9] += 0.4
    steep = FeatureCurve(straight(), arched(130, 150))
    assert not shown(picture, steep, np.array([110.0, 118.0]))[0].any()
