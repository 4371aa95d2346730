"""`weft bench --only retargeting DIR`: pictures in other sizes, beside what other operators made of them."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.bench.retargeting import GAP_PX, HEIGHT_PX, measure
from app.cli import main
from core.arrays import InputError
from core.imaging.image import Image
from core.imaging.images import load, save
from tests.core.selection.test_importance import two_discs


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Make a folder with a picture of two discs, 500 x 300, and what two operators made of it."""
    image, _ = two_discs()
    save(image, tmp_path / "discs.png")
    pixels = np.array(image.pixels)
    save(Image(pixels[:, 60:435]), tmp_path / "discs_0.75_cr.png")
    save(Image(np.asarray(cv2.resize(pixels, (375, 300)), np.uint8)), tmp_path / "discs_0.75_sc.png")
    return tmp_path


def test_a_picture_is_shown_beside_what_others_made_of_it(folder: Path) -> None:
    (record,) = measure(folder, folder / "seen")
    assert (record["name"], record["size"], record["others"]) == ("discs", [375, 300], 2)
    assert (record["features"], record["folds"]) == (2, 0)
    assert record["residual"] < 1e-6
    pixels = np.asarray(load(folder / "seen" / "discs_0.75.png").pixels)
    widths = [round(width * HEIGHT_PX / 300) for width in (500, 375, 375, 375, 375)]
    assert pixels.shape[1] == sum(widths) + 4 * GAP_PX
    left = widths[0] + widths[1] + 2 * GAP_PX
    weft = pixels[-HEIGHT_PX:, left : left + widths[2]].astype(int)
    count, _, stats, _ = cv2.connectedComponentsWithStats((weft[..., 0] - weft[..., 2] > 60).astype(np.uint8))
    assert count == 3
    assert np.allclose(stats[1:, cv2.CC_STAT_WIDTH] / stats[1:, cv2.CC_STAT_HEIGHT], 1, atol=0.05)


def test_without_others_the_longer_side_is_made_shorter_and_a_mask_says_what_to_keep(tmp_path: Path) -> None:
    image, discs = two_discs()
    save(Image(np.rot90(image.pixels).copy()), tmp_path / "tall.png")
    save(Image(np.where(np.rot90(discs), 255, 0).astype(np.uint8)[..., None]), tmp_path / "tall_mask.png")
    records = measure(tmp_path)
    assert [record["size"] for record in records] == [[300, 375], [300, 250]]
    assert records[0]["kept"] == pytest.approx(discs.mean(), abs=0.001)


def test_the_command_prints_the_list(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--json", "--only", "retargeting", str(folder)]) == 0
    assert [record["name"] for record in json.loads(capsys.readouterr().out)["retargeting"]] == ["discs"]


def test_a_folder_without_pictures_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InputError, match="holds no pictures"):
        measure(tmp_path)
    assert main(["bench", "--only", "retargeting", str(tmp_path / "none")]) == 2
    assert "needs a folder of pictures" in capsys.readouterr().err
