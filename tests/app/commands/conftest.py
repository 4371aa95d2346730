"""What several commands are tried on."""

from pathlib import Path

import pytest

from app.cli import main
from core.imaging.images import Image, save
from tests.app.commands.warp_scene import disc, photograph
from tests.core.overlay.overlay_scenes import make_scene, motif, stored


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    save(Image(photograph()), "photo.png")
    save(Image(disc()[..., None]), "mask.png")
    return tmp_path


@pytest.fixture(scope="session")
def photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("photo") / "photo.png"
    save(stored(make_scene(motif()).photo), path)
    return path


@pytest.fixture(scope="session")
def parts(photo: Path) -> Path:
    place = photo.parent / "parts"
    assert main(["decompose", str(photo), "-o", str(place)]) == 0
    return place
