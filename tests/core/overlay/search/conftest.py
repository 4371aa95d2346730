"""A print of which a photo shows few texels."""

import pytest

from core.overlay.registration.cloth import Fit, FittedCloth
from tests.core.overlay.overlay_scenes import Scene, make_scene
from tests.core.overlay.prints import PRINT, find_likeliest, painted, print_of_blots


@pytest.fixture(scope="module")
def printed() -> Scene:
    return make_scene(print_of_blots(0), size=(300, 280), basis=PRINT, bend=4.0)


@pytest.fixture(scope="module")
def followed(printed: Scene) -> tuple[FittedCloth, Fit]:
    cloth, found, _ = find_likeliest(printed.photo, painted(printed.photo))
    return cloth, found
