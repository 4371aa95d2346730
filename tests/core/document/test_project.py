import json
import zipfile
from dataclasses import is_dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.arrays import InputError
from core.document.document import CurvePair, Document, Outline, Pin, RetextureSettings, WarpSettings
from core.document.feature import Feature
from core.document.overlay_settings import Cloth, LatticeVertices, Laying, Search
from core.document.project import load_project, save_project
from core.document.ring import Ring
from core.imaging.images import Attribute, Image, load, save
from core.rasters.raster import Raster

numbers = st.floats(-1e6, 1e6)
places = st.tuples(numbers, numbers)
samples = st.one_of(st.just(np.uint8), st.just(np.uint16), st.just(np.float32))


@st.composite
def images(draw: st.DrawFn) -> Image:
    kind: Any = draw(samples)
    shape = draw(st.tuples(st.integers(1, 40), st.integers(1, 40), st.integers(1, 4)))
    random = np.random.default_rng(draw(st.integers(0, 9999)))
    pixels = random.random(shape) if kind is np.float32 else random.integers(0, np.iinfo(kind).max, shape)
    metadata = draw(
        st.sampled_from([(), (Attribute("Make", "string", "Håkan"), Attribute("Exif:FNumber", "float", 2.8))])
    )
    icc = draw(st.none() | st.binary(min_size=1, max_size=200))
    return Image(pixels.astype(kind), linear=kind is np.float32, icc=icc, metadata=metadata)


def points(count: int) -> st.SearchStrategy[Any]:
    return arrays(np.float64, (count, 2), elements=numbers)


warps = st.builds(
    WarpSettings,
    preset=st.none() | st.sampled_from(["arc", "twist"]),
    bend=numbers,
    vertical_axis=st.booleans(),
    values=st.dictionaries(st.text(max_size=8), numbers, max_size=3).map(MappingProxyType),
    aspect=places,
    keep=st.sampled_from(["similarity", "rigid", "none"]),
    method=st.sampled_from(["exact", "per-quad"]),
    cell_px=st.none() | st.floats(1, 50),
    straight=st.booleans(),
)
retextures = st.builds(
    RetextureSettings,
    along_px=st.none() | st.integers(1, 99),
    reach=st.none() | st.floats(0.01, 1),
    variety=numbers,
    mirrored=st.booleans(),
    seed=st.integers(0, 99),
)
curves = st.builds(
    lambda k, draw, closed, corners: CurvePair(draw[: 3 * k + 1], draw[3 * k + 1 : 6 * k + 2], closed, corners=corners),
    st.integers(1, 2),
    points(14),
    st.booleans(),
    st.frozensets(st.integers(0, 3)),
)


searches = st.builds(
    Search,
    texel=st.none() | st.tuples(places, places),
    lattice=st.none() | st.builds(LatticeVertices, points(5), points(5)),
    seed=st.integers(0, 9),
)
cloths = st.builds(
    Cloth,
    search=st.none() | searches,
    texture=st.none() | images(),
    texture_name=st.text(max_size=8),
    laying=st.builds(
        Laying, size=numbers, offset=places, mirror=st.booleans(), tile=st.booleans(), upright=st.booleans()
    ),
)

named_features = st.builds(
    Feature,
    st.integers(1, 255),
    st.text(max_size=9),
    st.booleans(),
    keep=st.sampled_from([None, "similarity", "rigid"]),
    upright=st.booleans(),
    least=st.none() | st.floats(0, 0.9),
    most=st.none() | st.floats(0.9, 9),
    weight=st.floats(0, 1),
)


rings = st.builds(Ring, st.floats(-720, 720), st.floats(0.05, 20))


@st.composite
def documents(draw: st.DrawFn) -> Document:
    start = Document.of(draw(images()))
    width, height = start.size_px
    return start.changed(
        cloth=draw(cloths).changed(region=draw(st.none() | st.just(Raster.filled(width, height, 255)))),
        mask=Raster.from_array(draw(arrays(np.uint8, (height, width)))),
        warp=draw(warps),
        outline=draw(st.none() | points(12).map(Outline)),
        pins=draw(st.lists(st.builds(Pin, places, places, st.none() | rings), max_size=3).map(tuple)),
        curves=draw(st.lists(curves, max_size=2).map(tuple)),
        retexture=draw(retextures),
        feature_curves=draw(st.lists(curves, max_size=2).map(tuple)),
        matte=draw(st.none() | arrays(np.uint8, (height, width)).map(Raster.from_array)),
        source_mask=draw(st.none() | arrays(np.uint8, (height, width)).map(Raster.from_array)),
        numbers=draw(st.none() | arrays(np.uint8, (height, width)).map(Raster.from_array)),
        features=draw(st.lists(named_features, max_size=2).map(tuple)),
        mode=draw(st.sampled_from(["warp", "retexture", "overlay"])),
    )


def same(a: Any, b: Any) -> bool:
    """Compare documents part by part and bit by bit."""
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, Raster):
        return same(a.array, b.array)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if is_dataclass(a):
        return all(same(getattr(a, name), getattr(b, name)) for name in a.__dataclass_fields__)
    return bool(a == b)


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(documents())
def test_what_is_saved_is_what_is_opened(tmp_path: Path, document: Document) -> None:
    save_project(document, tmp_path / "project.weft")
    assert same(load_project(tmp_path / "project.weft"), document)


def test_depth_profile_and_metadata_of_a_picture_survive(tmp_path: Path) -> None:
    picture = Image(
        np.arange(60, dtype=np.uint16).reshape(4, 5, 3) * 1000,
        metadata=(Attribute("Artist", "string", "A. Painter"), Attribute("Exif:FNumber", "float", 2.8)),
    )
    save(picture, tmp_path / "picture.png")
    opened = load(tmp_path / "picture.png")
    save_project(Document.of(opened), tmp_path / "project.weft")
    again = load_project(tmp_path / "project.weft").image
    assert again.metadata == opened.metadata
    assert again.pixels.dtype == np.uint16
    assert np.array_equal(again.pixels, picture.pixels)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    document = Document.of(Image(np.full((6, 8, 3), 9, np.uint8))).changed(pins=(Pin((0.5, 0.5), (0.6, 0.5)),))
    save_project(document, tmp_path / "project.weft")
    return tmp_path / "project.weft"


def rewritten(path: Path, **changes: object) -> None:
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    data = json.loads(files["weft.json"]) | changes
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, json.dumps(data) if name == "weft.json" else content)


def test_a_texture_leans_as_it_did_in_projects_that_do_not_say_how(tmp_path: Path) -> None:
    document = Document.of(Image(np.full((6, 8, 3), 9, np.uint8)))
    assert document.cloth.laying.upright
    path = tmp_path / "project.weft"
    save_project(document, path)
    with zipfile.ZipFile(path) as archive:
        data = json.loads(archive.read("weft.json"))
    del data["document"]["cloth"]["laying"]["upright"]
    rewritten(path, document=data["document"])
    assert not load_project(path).cloth.laying.upright


def test_features_in_projects_that_do_not_say_how_are_kept_as_all_are(project: Path) -> None:
    document = load_project(project).changed(features=(Feature(1, "Sun"), Feature(2, kept=False)))
    save_project(document, project)
    with zipfile.ZipFile(project) as archive:
        data = json.loads(archive.read("weft.json"))["document"]
    old = [{name: feature[name] for name in ("number", "name", "kept")} for feature in data["features"]]
    rewritten(project, document=data | {"features": old})
    assert load_project(project).features == document.features


def test_a_fault_while_saving_keeps_the_good_file(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good = project.read_bytes()

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(zipfile.ZipFile, "writestr", full)
    with pytest.raises(InputError, match=r"project\.weft: no space left"):
        save_project(load_project(project), project)
    assert project.read_bytes() == good
    assert [file.name for file in project.parent.iterdir()] == ["project.weft"]


def test_no_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.weft: no such file"):
        load_project(tmp_path / "none.weft")


def test_a_project_of_before_retexture_mode_opens(project: Path) -> None:
    with zipfile.ZipFile(project) as archive:
        document = json.loads(archive.read("weft.json"))["document"]
    for name in ("retexture", "feature_curves", "matte", "source_mask", "mode"):
        del document[name]
    rewritten(project, document=document)
    again = load_project(project)
    assert again.feature_curves == ()
    assert again.matte is None
    assert again.mode == "warp"
