import cv2
import numpy as np
import pytest

from core.imaging.images import Image
from core.progress import run
from core.selection.importance import importance, propose, propose_objects


def two_discs() -> tuple[Image, np.ndarray]:
    """Return a noisy ground with a ramp of light, two discs on it, and where those are."""
    noise = np.random.default_rng(2).normal(0, 6, (300, 500, 3))
    ground = np.stack([np.tile(np.linspace(60, 110, 500), (300, 1))] * 3, axis=2) + (0, 20, 50)
    inside = np.zeros((300, 500), np.uint8)
    cv2.circle(inside, (150, 150), 60, (1,), -1)
    cv2.circle(inside, (390, 120), 45, (1,), -1)
    pixels = np.where(inside[..., None] > 0, (210, 150, 60), ground) + noise
    return Image(np.clip(pixels, 0, 255).astype(np.uint8)), inside > 0


def test_what_differs_from_the_ground_is_proposed() -> None:
    image, inside = two_discs()
    mask = propose(run(importance(image)), float(inside.mean()), image.size_px) > 127
    assert (mask & inside).sum() / (mask | inside).sum() > 0.85
    assert cv2.connectedComponents(mask.astype(np.uint8))[0] == 3


def test_what_runs_along_the_border_is_ground_whatever_its_colour() -> None:
    image, inside = two_discs()
    pixels = image.pixels.copy()
    pixels[240:] = np.random.default_rng(3).normal((70, 190, 60), 5, (60, 500, 3)).astype(np.uint8)
    mask = propose(run(importance(Image(pixels))), float(inside.mean()), image.size_px) > 127
    assert mask[inside].mean() > 0.85
    assert mask[245:].mean() < 0.05


def test_the_share_is_kept_to_and_more_of_it_holds_the_less() -> None:
    image, _ = two_discs()
    found = run(importance(image))
    masks = [propose(found, share, image.size_px) > 127 for share in (0.0, 0.1, 0.3, 1.0)]
    assert [mask.mean() for mask in masks] == pytest.approx([0.0, 0.1, 0.3, 1.0], abs=0.04)
    assert (masks[1] & ~masks[2]).mean() < 0.005


@pytest.mark.parametrize("size", [(1, 1), (1, 400), (400, 1), (3, 7), (64, 64)])
def test_any_picture_has_a_proposal(size: tuple[int, int]) -> None:
    image = Image(np.full((size[1], size[0], 3), 90, np.uint8))
    found = run(importance(image))
    assert np.isfinite(found).all()
    assert propose(found, 0.25, image.size_px).shape == (size[1], size[0])


def test_whole_objects_are_proposed_where_a_smaller_share_is_asked_for() -> None:
    image, inside = two_discs()
    found = run(importance(image))
    rough = propose(found, 0.8 * float(inside.mean()), image.size_px) > 127
    mask = run(propose_objects(image, found, 0.8 * float(inside.mean()))) > 127
    assert rough[inside].mean() < 0.9
    assert mask[inside].mean() > 0.97
    assert mask[~inside].mean() < 0.01


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_where_nothing_stands_out_what_is_most_important_is_proposed(share: float) -> None:
    image = Image(np.full((64, 64, 3), 90, np.uint8))
    found = run(importance(image))
    assert (run(propose_objects(image, found, share)) == propose(found, share, image.size_px)).all()
