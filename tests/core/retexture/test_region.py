"""Which texture is regrown, and which the deformation may as well stretch."""

import numpy as np

from core.arrays import Bools, Singles
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.retexture.deformation.diffusion import distortion
from core.retexture.job import deform
from core.retexture.region import CLEAR, CONTRAST, SEEN, contrast
from core.retexture.synthesis.long_edges import LongEdges, Side
from core.retexture.synthesis.patches import PatchShape
from core.retexture.synthesis.scene import RetextureScene, prepare
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, arched, straight

SHAPE = (HEIGHT, WIDTH)
REACH = 70.0
STRONG, FAINT = 1.0, 0.14
"""Of noise that shows any stretch, and of noise that shows a great one."""


def noise(strength: float) -> Singles:
    grain = np.random.default_rng(0).random((*SHAPE, 3)).astype(np.float32)
    return np.asarray(0.5 + np.float32(strength) * (grain - 0.5), np.float32)


def scene_of(
    target: Curve, strength: float, y: float = 100.0, patch: PatchShape | None = None
) -> tuple[RetextureScene, Singles, Singles]:
    """Return the scene of a straight line moved to `target`, the strain (H, W), and the distance from it (H, W)."""
    curves = [FeatureCurve(straight(y), target)]
    plain = deform(SHAPE, curves, None)
    scene = prepare(curves, plain, noise(strength), patch or PatchShape(), REACH, None)
    strain = plain.grid.at_pixels(distortion(plain.grid, plain.field)[..., None])[..., 0]
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    places = np.column_stack([columns.ravel(), rows.ravel()]).astype(float)
    return scene, strain, scene.way.target.distance(places).reshape(SHAPE).astype(np.float32)


def regrown(scene: RetextureScene, where: Bools) -> float:
    return float(scene.area.must[where].mean())


def test_the_noise_is_what_it_says() -> None:
    assert contrast(noise(STRONG)).min() > 2 * CLEAR
    faint = contrast(noise(FAINT))
    assert CONTRAST < faint.min() < faint.max() < CLEAR


def test_faint_texture_is_regrown_where_it_is_stretched_much_strong_texture_sooner() -> None:
    target = arched(70, 135)
    faint, strain, distance = scene_of(target, FAINT)
    strong, *_ = scene_of(target, STRONG)
    near = (distance > 30) & (distance < 0.8 * REACH)
    limit = SEEN / contrast(noise(FAINT)).mean()
    mild, great = near & (strain > 0.12) & (strain < 0.5 * limit), near & (strain > 1.3 * limit)
    assert mild.sum() > 300
    assert great.sum() > 300
    assert regrown(faint, mild) < 0.2
    assert regrown(faint, great) > 0.9
    assert regrown(strong, mild) > 0.9


def test_faint_texture_is_not_fetched_from_elsewhere_where_its_source_lies_outside_the_picture() -> None:
    target = straight(150)
    faint, strain, distance = scene_of(target, FAINT, y=182)
    strong, *_ = scene_of(target, STRONG, y=182)
    rows = np.mgrid[:HEIGHT, :WIDTH][0]
    outside = (rows > 170) & (strain > 0.7) & (distance > 20)
    assert outside.sum() > 300
    assert regrown(faint, outside) < 0.1
    assert regrown(strong, outside) > 0.9


def test_the_edge_is_regrown_however_small_patches_are() -> None:
    target = arched(70, 135)
    scene, strain, distance = scene_of(target, 0.0, patch=PatchShape(8, 4, 6, 3))
    beside = (distance < 4) & (strain > 0.15)
    assert beside.sum() > 300
    assert regrown(scene, beside) > 0.9


def test_on_a_side_with_structure_the_deformation_stands_unless_it_stretches_much() -> None:
    curves = [FeatureCurve(straight(100.0), arched(50))]
    plain = deform(SHAPE, curves, None)
    free, held = (
        prepare(curves, plain, noise(STRONG), PatchShape(), REACH, None, LongEdges(structured=sides))
        for sides in (frozenset[Side](), frozenset({(0, True)}))
    )
    strain = plain.grid.at_pixels(distortion(plain.grid, plain.field)[..., None])[..., 0]
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    feet = free.way.target.feet(np.column_stack([columns.ravel(), rows.ravel()]).astype(float))
    side = (feet.offset > 0).reshape(SHAPE)
    mild, strong = side & free.area.must & (strain < 0.4), side & free.area.must & (strain > 0.55)
    assert mild.sum() > 500
    assert strong.sum() > 50
    assert regrown(held, mild) < 0.2
    assert regrown(held, strong) > 0.8
    assert regrown(held, ~side & free.area.must) > 0.95
