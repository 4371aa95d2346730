"""Golden pictures: what the software driver drew when somebody looked at it and found it right."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.render import gpu
from core.arrays import Bytes

FOLDER = Path(__file__).parent.parent / "goldens"
TOLERANCE = 2
"""Levels of 255 by which versions of the driver may differ."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate-goldens", action="store_true", help="keep what is drawn now as the golden pictures")


@pytest.fixture
def golden(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[[str, Bytes], None]:
    """Return a function that compares pixels, (h, w, 3 or 4), with the golden picture of a name."""
    if "llvmpipe" not in gpu.standalone().info["GL_RENDERER"]:
        pytest.skip("golden pictures are those of the software driver")

    def compare(name: str, pixels: Bytes) -> None:
        path = FOLDER / f"{name}.png"
        swapped = np.ascontiguousarray(pixels[..., [2, 1, 0, 3][: pixels.shape[2]]])
        if request.config.getoption("--regenerate-goldens"):
            cv2.imwrite(str(path), swapped)
            return
        expected = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        assert expected is not None, f"{path}: make it with --regenerate-goldens, and look at it"
        cv2.imwrite(str(tmp_path / f"{name}.png"), swapped)
        assert expected.shape == swapped.shape
        difference = np.abs(expected.astype(int) - swapped)
        assert difference.max() <= TOLERANCE, f"{tmp_path / name}.png differs by up to {difference.max()}"

    return compare
