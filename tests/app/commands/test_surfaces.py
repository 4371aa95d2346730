"""`weft warp --surface`: the texture of a surface in space, and what it looks like on it."""

from pathlib import Path

import numpy as np
import pytest

from core.imaging.images import load
from core.surfaces.shapes import make_shape
from tests.app.commands.warp_scene import HEIGHT, WIDTH, photograph, refused, weft
from tests.core.surfaces.test_surface import write_obj

pytestmark = pytest.mark.gpu


def test_without_features_the_texture_is_the_picture(folder: Path) -> None:
    assert weft("photo.png", "--surface", "cylinder", "-o", "out.png") == 0
    assert np.abs(load("out.png").pixels.astype(int) - photograph()).max() <= 2


def test_a_feature_is_drawn_into_the_texture_as_the_surface_wants_it(folder: Path) -> None:
    words = ("photo.png", "--mask", "mask.png", "--surface", "cylinder", "--proportion", "0.5", "-o", "out.png")
    assert weft(*words, "--map", "map.npz", "--report", "report.json") == 0
    found = load("out.png").pixels
    assert found.shape[:2] == (HEIGHT, WIDTH)
    assert found.shape[2] == 3  # filled to its edge
    assert np.abs(found.astype(int) - photograph()).max() > 30
    with np.load("map.npz") as arrays:
        moved = arrays["warped"]
    np.testing.assert_allclose(moved[0, :, 1], -0.5, atol=1e-6)
    np.testing.assert_allclose(moved[:, -1, 0], WIDTH - 0.5, atol=1e-6)


def test_a_view_shows_the_surface_from_where_the_camera_is(folder: Path) -> None:
    views = []
    for orbit in ("0,0", "0,80"):
        words = ("photo.png", "--surface", "cone", "-o", "out.png", "--view", "view.png", "--orbit", orbit)
        assert weft(*words) == 0
        views.append(load("view.png").pixels)
    side, above = (view[..., 3] > 127 for view in views)
    assert views[0].shape[2] == 4
    # From its side a cone is a triangle, from above nearly a disc.
    filled = [shape.sum() / np.prod(np.ptp(np.argwhere(shape), axis=0) + 1) for shape in (side, above)]
    assert filled[0] == pytest.approx(0.5, abs=0.1)
    assert filled[1] == pytest.approx(np.pi / 4, abs=0.1)


def test_a_mesh_from_a_file_is_a_surface_like_one_by_name(folder: Path) -> None:
    write_obj(Path("mug.obj"), make_shape("cylinder"))
    for name in ("cylinder", "mug.obj"):
        assert weft("photo.png", "--mask", "mask.png", "--surface", name, "-o", f"{name[:3]}.png") == 0
    difference = load("cyl.png").pixels.astype(int) - load("mug.png").pixels
    assert np.abs(difference).max() <= 2


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--surface", "ball"], "ball: neither a file nor one of plane"),
        (["--surface", "none.obj"], "none.obj: no such file"),
        (["--surface", "photo.png"], "photo.png: not a mesh"),
        (["--surface", "sphere", "--proportion", "99"], "99 is not 0.2 to 5"),
        (["--proportion", "2"], "--proportion"),
        (["--surface", "torus", "--size", "10x10"], "--size"),
        (["--surface", "torus", "--frame", "warp"], "--frame"),
        (["--view", "view.png"], "--view"),
        (["--surface", "cone", "--view", "view.tx"], "view.tx"),
    ],
)
def test_what_makes_no_sense_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], says: str
) -> None:
    assert says in refused(capsys, "photo.png", *words)
