"""Long edges near moved curves: structure is found, and strokes of a texture that follows the curve are not."""

import cv2
import numpy as np

from core.arrays import Singles
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.progress import run
from core.retexture.job import Settings, retexture
from core.retexture.synthesis.long_edges import find_long_edges
from core.retexture.synthesis.patches import PatchShape

HEIGHT, WIDTH = 200, 300
PATCH = PatchShape()
REACH = 50.0


def arch(rise: float, y: float = 150.0) -> Curve:
    """Return an arch through the picture, from its left to its right."""
    return Curve(np.array([[20.0, y], [110.0, y - rise], [190.0, y - rise], [280.0, y]]))


RISING = FeatureCurve(arch(30.0), arch(70.0))


def ground() -> Singles:
    """Return grey above the arch and brown below it, both with a little grain."""
    picture = np.full((HEIGHT, WIDTH, 3), 0.6, np.float32)
    line = np.rint(arch(30.0).at(arch(30.0).parameters(step=1.0))).astype(np.int32)
    around = np.concatenate([[[0, 150]], line, [[WIDTH - 1, 150], [WIDTH - 1, HEIGHT - 1], [0, HEIGHT - 1]]])
    cv2.fillPoly(picture, [around.astype(np.int32)], (0.35, 0.25, 0.15))
    grain = np.random.default_rng(0).normal(0, 0.01, picture.shape)
    return np.asarray(np.clip(picture + grain, 0, 1), np.float32)


def fence() -> Singles:
    """Return the ground with white palings behind the arch."""
    picture = ground()
    for x in range(40, WIDTH - 20, 30):
        cv2.rectangle(picture, (x, 40), (x + 12, 125), (1.0, 1.0, 1.0), -1)
    return picture


def fur() -> Singles:
    """Return the ground with long dark hairs that stand on the arch."""
    picture, curve = ground(), arch(30.0)
    for t in np.linspace(0.03, 0.97, 40):
        foot, normal = curve.at(t), curve.normal(t)
        tip = foot - 48 * normal
        cv2.line(picture, tuple(map(int, foot)), tuple(map(int, tip)), (0.2, 0.2, 0.2), 3, cv2.LINE_AA)
    return picture


def test_palings_are_found_each_once() -> None:
    found = find_long_edges(fence(), [RISING], PATCH, REACH).curves
    # Each paling has two sides closer together than a patch's half width, or is found by both; none in between.
    columns = np.array([line.points[:, 0].mean() for line in found])
    palings = np.arange(40, WIDTH - 20, 30)
    assert all((np.abs(columns - x - 6) < 8).any() for x in palings)
    assert all((np.abs(palings + 6 - x) < 8).any() for x in columns)


def test_each_leads_along_its_paling() -> None:
    for line in find_long_edges(fence(), [RISING], PATCH, REACH).curves:
        assert np.ptp(line.points[:, 0]) < 2
        assert np.ptp(line.points[:, 1]) > 60


def test_hairs_that_stand_on_the_curve_are_texture() -> None:
    assert find_long_edges(fur(), [RISING], PATCH, REACH).curves == ()


def test_palings_make_their_side_structured_and_hairs_do_not() -> None:
    assert len(find_long_edges(fence(), [RISING], PATCH, REACH).structured) == 1
    assert not find_long_edges(fur(), [RISING], PATCH, REACH).structured


def test_an_edge_ends_before_it_meets_a_drawn_curve() -> None:
    picture = ground()
    for x in range(40, WIDTH - 20, 30):
        cv2.rectangle(picture, (x, 40), (x + 12, 175), (1.0, 1.0, 1.0), -1)
    found = find_long_edges(picture, [RISING], PATCH, REACH).curves
    assert len(found) > 3
    places = np.concatenate([line.at(line.parameters(step=1.0)) for line in found])
    assert RISING.source.nearest(places)[1].min() > PATCH.rib - 2
    assert RISING.source.nearest(places)[1].min() < 2 * PATCH.rib


def test_the_edge_that_was_drawn_is_none() -> None:
    assert find_long_edges(ground(), [RISING], PATCH, REACH).curves == ()


def test_edges_far_from_curves_are_left_out() -> None:
    picture = ground()
    picture[:4, :, :] = 0
    cv2.line(picture, (20, 15), (280, 15), (0.0, 0.0, 0.0), 4)
    assert find_long_edges(picture, [RISING], PATCH, REACH).curves == ()


def test_a_bent_edge_is_one_chain() -> None:
    picture = ground()
    angles = np.linspace(0.6, 2.4, 200)
    ring = np.stack([150 + 70 * np.cos(angles), 150 - 70 * np.sin(angles)], axis=-1)
    cv2.polylines(picture, [np.rint(ring).astype(np.int32)], isClosed=False, color=(0.0, 0.0, 0.0), thickness=12)
    curve = FeatureCurve(
        Curve(np.array([[20.0, 170.0], [110.0, 170.0], [190.0, 170.0], [280.0, 170.0]])), arch(20.0, 170.0)
    )
    found = find_long_edges(picture, [curve], PATCH, 90.0).curves
    assert max(line.length for line in found) > 90


def test_a_picture_smaller_than_a_patch_has_none() -> None:
    tiny = FeatureCurve(
        Curve(np.array([[1.0, 5.0], [3.0, 5.0], [5.0, 5.0], [8.0, 5.0]])),
        Curve(np.array([[1.0, 5.0], [3.0, 3.0], [5.0, 3.0], [8.0, 5.0]])),
    )
    assert find_long_edges(np.zeros((10, 10, 3), np.float32), [tiny], PATCH, REACH).curves == ()


def test_palings_stay_straight_where_they_would_be_bent() -> None:
    pixels = np.rint(fence() * 255).astype(np.uint8)
    with_edges, without = (
        run(retexture(pixels, [RISING], Settings(long_edges=kept), previews=False)) for kept in (True, False)
    )

    def worst_slant(place: Singles) -> float:
        """Return by how much columns of palings lead sideways in the source, on average, per row."""
        part = place[60:80, 100:200, 0]
        return float(np.abs(np.diff(part, axis=0)).mean())

    assert worst_slant(with_edges.place) < 0.7 * worst_slant(without.place)


def test_hair_that_lies_everywhere_beside_a_straight_curve_is_texture() -> None:
    hair = np.random.default_rng(0).normal(0, 1, (HEIGHT, WIDTH)).astype(np.float32)
    smeared = cv2.filter2D(hair, -1, np.eye(15, dtype=np.float32)[::-1] / 15)
    picture = np.repeat(np.clip(0.55 + 0.5 * smeared, 0, 1)[..., None], 3, axis=2)
    across = Curve(np.array([[10.0, 100.0], [100.0, 100.0], [200.0, 100.0], [290.0, 100.0]]))
    assert len(find_long_edges(picture, [FeatureCurve(across, arch(40.0, 100.0))], PATCH, REACH).curves) == 0
