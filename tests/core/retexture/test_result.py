"""What retexturing promises: texture keeps its scale, features lie on their curves, all else stays."""

from itertools import islice

import numpy as np
import pytest

from core.arrays import Bytes, InputError, Pixels, Points
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.progress import Progress, run
from core.retexture.job import Settings, retexture
from core.retexture.result import Retexture
from core.retexture.sampling import Kernel, read
from tests.core.retexture.retexture_scenes import HEIGHT, PERIOD, WIDTH, arched, bent, period, straight, strip, stripes


@pytest.fixture(scope="module")
def found() -> Retexture:
    return run(retexture(stripes(), bent()))


def test_texture_along_the_curve_keeps_its_scale(found: Retexture) -> None:
    target = arched()
    result, plain = found.apply(stripes()), found.deformed(stripes())
    stretch = target.length / WIDTH
    for offset in (-10.0, 10.0):
        assert period(strip(result, target, offset)) == pytest.approx(PERIOD, rel=0.1)
        assert period(strip(plain, target, offset)) > PERIOD * (1 + (stretch - 1) / 2)


def test_the_feature_lies_on_its_curve(found: Retexture) -> None:
    result, target = found.apply(stripes()).astype(int), arched()
    t = target.parameter_at(np.arange(5, target.length - 5, 2.0))
    for side, red in ((-2.0, False), (2.0, True)):
        x, y = np.rint(target.at(t) + side * target.normal(t)).astype(int).T
        assert ((result[y, x, 0] > result[y, x, 2]) == red).mean() > 0.99


def test_outside_the_patches_stands_the_plain_deformation(found: Retexture) -> None:
    result, plain = found.apply(stripes()), found.deformed(stripes())
    kept = found.label == 0
    assert 0.1 < kept.mean() < 0.9
    np.testing.assert_array_equal(result[kept], plain[kept])


def test_unmoved_curves_change_nothing() -> None:
    found = run(retexture(stripes(), [FeatureCurve(arched(), arched())]))
    np.testing.assert_array_equal(found.apply(stripes()), stripes())
    np.testing.assert_array_equal(found.deformed(stripes()), stripes())
    assert found.patches == 0


def test_same_seed_same_bytes(found: Retexture) -> None:
    again = run(retexture(stripes(), bent()))
    np.testing.assert_array_equal(again.place, found.place)
    assert again.apply(stripes()).tobytes() == found.apply(stripes()).tobytes()
    other = run(retexture(stripes(), bent(), Settings(seed=5)))
    assert (other.place != found.place).any()


def test_without_previews_the_result_is_the_same(found: Retexture) -> None:
    steps: list[Progress] = []
    np.testing.assert_array_equal(run(retexture(stripes(), bent(), previews=False), steps.append).place, found.place)
    assert [step.note for step in steps if step.preview is not None] == ["deforming"]


def test_other_layers_take_the_same_coordinates(found: Retexture) -> None:
    x, y = np.meshgrid(np.arange(WIDTH, dtype=np.float32), np.arange(HEIGHT, dtype=np.float32))
    ramp = found.apply(np.dstack([x, y, np.zeros_like(x)]), linear=True, blend=False)
    inner = ((found.place > 4) & (found.place < [WIDTH - 5, HEIGHT - 5])).all(axis=-1)
    assert inner.mean() > 0.5
    np.testing.assert_allclose(ramp[..., :2][inner], found.place[inner], atol=0.05)


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("depth", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("blend", [True, False])
def test_every_kind_of_pixel_carries_over(found: Retexture, channels: int, depth: type, blend: bool) -> None:
    top = 1.0 if depth is np.float32 else float(np.iinfo(depth).max)
    grey: Pixels = np.full((HEIGHT, WIDTH, channels), 0.25 * top).astype(depth)
    grey[..., -1:] = (top if channels in (2, 4) else 0.25 * top) * np.ones(1)
    result = found.apply(grey, linear=depth is np.float32, blend=blend)
    assert result.dtype == depth
    assert result.shape == grey.shape
    np.testing.assert_allclose(result.astype(float), grey.astype(float), atol=0.002 * top)


def test_sixteen_bits_are_not_cut_to_eight(found: Retexture) -> None:
    x = np.broadcast_to(np.linspace(0, 65535, WIDTH), (HEIGHT, WIDTH))
    result = found.apply(np.rint(x[..., None]).astype(np.uint16))
    assert len(np.unique(result % 257)) > 100


def test_the_original_is_resampled_once_and_with_the_best_kernel(found: Retexture) -> None:
    # Faint enough that the kernel's overshoot is nowhere held.
    layer = 0.4 + 0.2 * np.random.default_rng(2).random((HEIGHT, WIDTH, 3)).astype(np.float32)
    want = np.clip(read(layer, found.place, Kernel.LANCZOS, mirror=True), layer.min(), layer.max())
    # Beside seams patches are mixed, and steps between them are evened out.
    off = np.abs(found.apply(layer, linear=True) - want).max(axis=2)
    assert np.median(off[found.label > 0]) < 0.002
    assert np.abs(found.deformed(layer, linear=True) - want).max(axis=2)[found.label == 0].max() < 2e-4


def test_a_layer_of_another_size_is_refused(found: Retexture) -> None:
    with pytest.raises(InputError, match="10x20 pixels does not fit a picture of 220x200"):
        found.apply(np.zeros((20, 10, 3), np.uint8))


def test_a_matte_bounds_what_changes() -> None:
    matte = np.zeros((HEIGHT, WIDTH), np.uint8)
    matte[:, :110] = 255
    found = run(retexture(stripes(), bent(), matte=matte))
    assert (found.label[:, :110] > 0).any()
    assert not found.label[:, 110:].any()


def test_what_is_painted_as_regrown_or_not_is() -> None:
    free = run(retexture(stripes(), bent()))
    wish = np.full((HEIGHT, WIDTH), 127, np.uint8)
    wish[:, :80] = 0
    wish[165:195, 100:140] = 255
    assert (free.label[:, :80] > 0).sum() > 500, "else it shows nothing"
    assert not free.label[165:195, 100:140].any(), "else it shows nothing"
    found = run(retexture(stripes(), bent(), regrow=wish))
    assert not found.label[:, :80].any()
    assert (found.label[167:193, 102:138] > 0).all()
    far = np.s_[:120, 130:]
    assert np.mean((found.label > 0)[far] == (free.label > 0)[far]) > 0.97, "elsewhere it is as it was found"


def test_texture_is_taken_from_the_source_mask_alone() -> None:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[:, 60:160] = 255
    found = run(retexture(stripes(), bent(), source_mask=mask))
    x = found.place[..., 0][found.label > 0]
    assert len(x) > 2000
    assert x.min() > 59
    assert x.max() < 160.5


def test_patches_are_mirrored_only_if_asked() -> None:
    """The Jacobian of the source place is negative where a patch is mirrored."""

    def mirrored(found: Retexture) -> float:
        right, down = np.diff(found.place, axis=1)[:-1], np.diff(found.place, axis=0)[:, :-1]
        area = right[..., 0] * down[..., 1] - right[..., 1] * down[..., 0]
        label = found.label
        inside = (label[:-1, :-1] > 0) & (label[:-1, :-1] == label[1:, :-1]) & (label[:-1, :-1] == label[:-1, 1:])
        return float((area[inside] < 0).mean())

    assert mirrored(run(retexture(stripes(), bent()))) < 0.03
    assert mirrored(run(retexture(stripes(), bent(), Settings(mirrored=True)))) > 0.1


def test_a_passive_curve_follows_the_deformation() -> None:
    job = retexture(stripes(), [*bent(), FeatureCurve(straight(120.0))])
    found = run(job)
    assert found.patches > 0
    plain = next(retexture(stripes(), bent())).preview
    along = next(o for o in found.origins if len(o))
    assert set(along.curve) == {0, 1}
    assert isinstance(plain, Retexture)


def test_crossing_targets_are_retextured_in_pieces() -> None:
    other = FeatureCurve(Curve(np.column_stack([np.full(4, 110.0), np.linspace(20, 130, 4)])), None)
    moved = Curve(np.column_stack([np.full(4, 118.0), np.linspace(15, 140, 4)]))
    found = run(retexture(stripes(), [*bent(), FeatureCurve(other.source, moved)]))
    assert set(np.concatenate([o.curve for o in found.origins])) >= {0, 1, 2, 3}


def test_progress_never_runs_backwards_and_shows_the_coarse_result_early() -> None:
    steps: list[Progress] = []
    final = run(retexture(stripes(), bent()), steps.append)
    fractions = [step.fraction for step in steps]
    assert fractions == sorted(fractions)
    previews = [step.preview for step in steps if step.preview is not None]
    assert len(previews) >= 3
    assert (previews[-1].label > 0).mean() == pytest.approx((final.label > 0).mean(), abs=0.02)
    assert not previews[0].label.any()
    assert all(preview.patches for preview in previews[1:]), "the window would show the plain deformation again"
    coarse = previews[1]
    assert not coarse.final
    assert final.final
    covered = (coarse.label > 0) == (final.label > 0)
    assert covered.mean() > 0.85


def test_a_job_can_be_dropped_at_any_step() -> None:
    job = retexture(stripes(), bent())
    assert len(list(islice(job, 4))) == 4
    job.close()
    with pytest.raises(StopIteration):
        next(job)


CURVE = np.array([[10, 75], [60, 75], [150, 75], [200, 75]], float)
FOLDED = np.array([[10, 75], [200, 75], [10, 77], [200, 77]], float)
LOOP = np.array([[20, 110], [300, 20], [-80, 20], [200, 110]], float)


@pytest.mark.parametrize(
    ("source", "target"),
    [
        (CURVE, CURVE + [0, 400]),
        (CURVE + [0, 400], CURVE),
        (CURVE, CURVE[:1] + np.linspace(0, 1, 4)[:, None]),
    ],
)
def test_curves_that_lead_nowhere_are_refused(source: Points, target: Points) -> None:
    with pytest.raises(InputError, match="curve 1"):
        run(retexture(stripes(), [FeatureCurve(Curve(source), Curve(target))]))


def test_curves_without_a_target_are_refused() -> None:
    with pytest.raises(InputError, match="no curve has a target"):
        run(retexture(stripes(), [FeatureCurve(straight())]))
    with pytest.raises(InputError, match="no curve has a target"):
        run(retexture(stripes(), []))


def test_an_empty_mask_is_refused() -> None:
    empty: Bytes = np.zeros((HEIGHT, WIDTH), np.uint8)
    with pytest.raises(InputError, match="the matte is empty"):
        run(retexture(stripes(), bent(), matte=empty))
    with pytest.raises(InputError, match="the source mask is empty"):
        run(retexture(stripes(), bent(), source_mask=empty))


@pytest.mark.parametrize(
    ("source", "target"),
    [
        pytest.param(CURVE, LOOP, id="a target that crosses itself"),
        pytest.param(CURVE, FOLDED, id="a target folded tightly"),
        pytest.param(CURVE, CURVE[::-1], id="a target run backwards"),
        pytest.param(CURVE, CURVE + [120, 40], id="a target partly outside"),
        pytest.param(CURVE - [90, 0], CURVE, id="a source partly outside"),
        pytest.param(CURVE[[0, 0, 3, 3]], CURVE[[0, 0, 0, 3]] + [0, 9], id="coincident points"),
        pytest.param(np.array([[10, 75], [50, 75], [90, 75], [100, 75], [100, 60], [100, 40], [100, 20]], float),
                     np.array([[10, 90], [50, 90], [90, 90], [120, 90], [120, 60], [120, 40], [120, 20]], float),
                     id="a kink"),
        pytest.param(CURVE, CURVE * [0.2, 1] + [80, 0], id="a target five times shorter"),
    ],
)  # fmt: skip
def test_odd_curves_give_a_sensible_picture(source: Points, target: Points) -> None:
    found = run(retexture(stripes(), [FeatureCurve(Curve(source), Curve(target))]))
    assert np.isfinite(found.place).all()
    result = found.apply(stripes())
    assert result.shape == (HEIGHT, WIDTH, 3)
    # Nothing black or white comes in that the picture does not hold.
    assert result.min() >= stripes().min()
    assert result.std() > 30


def test_two_targets_on_the_same_place() -> None:
    curves = [FeatureCurve(straight(50.0), straight(80.0)), FeatureCurve(straight(90.0), straight(80.0))]
    found = run(retexture(stripes(), curves))
    assert np.isfinite(found.place).all()


def test_a_tiny_picture() -> None:
    line = Curve(np.column_stack([np.linspace(0, 11, 4), np.full(4, 4.0)]))
    moved = Curve(np.column_stack([np.linspace(0, 11, 4), np.full(4, 6.0)]))
    found = run(retexture(stripes()[:10, :12], [FeatureCurve(line, moved)]))
    assert found.apply(stripes()[:10, :12]).shape == (10, 12, 3)
