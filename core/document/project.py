"""Projects: a document in a `.weft` file, a zip of `weft.json`, pictures and arrays.

Pictures and masks are PNG, float pictures TIFF, large arrays `.npy`; metadata and colour profile stand beside the
picture, so that they come back bit by bit. A file appears whole or not at all.
"""

import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from core.arrays import InputError, readonly
from core.document import overlay as document_overlay
from core.document.animated import check_tracks
from core.document.document import Document
from core.document.plain_data import as_list, decode, encode
from core.files.atomic import atomic_file
from core.files.faults import faults_named, system_faults_named
from core.files.json_file import parse_json
from core.files.litter import scratch_folder
from core.files.members import Members
from core.files.npy_file import read_npy
from core.imaging.images import Attribute, Image, load, save
from core.imaging.picture_bounds import TooLargeError
from core.notices import notice
from core.overlay.storage.layers_file import FOLDER
from core.rasters.raster import Raster

VERSION = 1
SUFFIX = ".weft"
_INLINE_NUMBERS = 4096
"""Arrays of so many numbers at most stand in the JSON itself."""
_FAST_PNG = (Attribute("png:compressionLevel", "int", 3),)


def save_project(document: Document, path: Path, *, is_whole: bool = True) -> None:
    """Write `document` to `path`, whole or not at all; raise `InputError` if it cannot be written.

    What was found of a cloth is written with it, unless it `is_whole` not: that is large, and can be found again.
    """
    with atomic_file(path) as place, zipfile.ZipFile(place, "w", zipfile.ZIP_STORED) as archive:
        parts = _Writer()
        data = {"format": "weft", "version": VERSION, "document": encode(document, parts)}
        text = json.dumps(data, indent=1, ensure_ascii=False)
        # Bytes of a file's name that are not UTF-8 are lone surrogates; \\udc80 is what JSON writes for one, too.
        archive.writestr("weft.json", text.encode("utf-8", "backslashreplace"), zipfile.ZIP_DEFLATED)
        found = document_overlay.files_of(document) if is_whole else {}
        for name, content in (parts.files | found).items():
            archive.writestr(name, content)


def load_project(path: Path) -> Document:
    """Read the document in `path`.

    Raises
    ------
    InputError
        If the file is missing, no project, damaged, or of a newer version than this program knows.
    """
    try:
        with system_faults_named(path):
            archive = zipfile.ZipFile(path)
    except (zipfile.BadZipFile, ValueError, NotImplementedError) as fault:
        raise InputError(f"{path}: not a Weft project, or damaged") from fault
    with archive:
        return _document(path, Members(archive))


def _document(path: Path, members: Members) -> Document:
    """Return the document of an archive that was opened."""
    try:
        data = parse_json(members.read("weft.json"))
    except (InputError, ValueError) as fault:
        raise InputError(f"{path}: not a Weft project, or damaged") from fault
    version = data.get("version") if isinstance(data, dict) else None
    if not isinstance(version, int) or data.get("format") != "weft":
        raise InputError(f"{path}: not a Weft project")
    if not isinstance(data.get("document"), dict):
        raise InputError(f"{path}: damaged project: it has no document")
    if version > VERSION:
        raise InputError(f"{path}: made by a newer Weft (format {version}; this one reads up to {VERSION})")
    with system_faults_named(f"{path}: cannot be unpacked"), faults_named(f"{path}: damaged project"):
        document: Document = decode(Document, _up_to_date(data["document"]), _Reader(members))
        check_tracks(document)
        if document.surface is not None:
            document.surface.chart.size_px(document.size_px)
    for name in ("mask", "numbers", *document.retexture_masks):
        mask = getattr(document, name)
        if mask is not None and (mask.width_px, mask.height_px) != document.size_px:
            raise InputError(f"{path}: damaged project: the {name} has another size than the picture")
    cloth = document.cloth
    for name, raster in (("region of cloth", cloth.region), ("protection", cloth.protected), ("cover", cloth.covered)):
        if raster is not None and (raster.width_px, raster.height_px) != document.size_px:
            raise InputError(f"{path}: damaged project: the {name} has another size than the picture")
    _take_found(path, document, members)
    return document


def _take_found(path: Path, document: Document, members: Members) -> None:
    """Take what was found of the document's cloth, where that was written."""
    if f"{FOLDER}uv.npy" in members:
        try:
            document_overlay.take_files(document, members.read)
        except InputError as fault:
            notice(f"{path.name}: what was found of the cloth is damaged, and is looked for anew: {fault}")


def _up_to_date(document: Any) -> object:
    """Return a document's data with what older programs did not write, as it was with them."""
    laying = document["cloth"].get("laying") if isinstance(document.get("cloth"), dict) else None
    if isinstance(laying, dict):
        laying.setdefault("upright", False)
    return document


class _Writer:
    """Turns pictures, masks and large arrays into files of the zip."""

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}

    def put(self, value: object, name: str) -> object | None:
        """Keep pictures, masks and arrays."""
        if isinstance(value, Image):
            return self._put_image(value, name)
        if isinstance(value, Raster):
            self.files[f"{name}.png"] = _encode(Image(value.array[..., None]))
            return {"file": f"{name}.png"}
        if isinstance(value, np.ndarray):
            if value.size <= _INLINE_NUMBERS:
                return as_list(value)
            buffer = io.BytesIO()
            np.save(buffer, value, allow_pickle=False)
            self.files[f"{name}.npy"] = buffer.getvalue()
            return {"file": f"{name}.npy"}
        return None

    def _put_image(self, image: Image, name: str) -> object:
        file = f"{name}{_suffix(image)}"
        self.files[file] = _cache(image)
        data: dict[str, Any] = {"file": file, "linear": image.linear}
        if image.icc is not None:
            data["profile"] = f"{name}.icc"
            self.files[data["profile"]] = image.icc
        data["metadata"] = [entry for a in image.metadata if (entry := _as_data(a)) is not None]
        return data


class _Reader:
    """Turns files of the zip into pictures, masks and arrays."""

    def __init__(self, members: Members) -> None:
        self._members = members

    def take(self, kind: type, data: object, name: str) -> object | None:
        """Return a picture, a mask or an array."""
        if kind is Image:
            return self._image(data, name)
        if kind is Raster:
            pixels = _decode(self._file(data, name), ".png", name).pixels
            if pixels.dtype != np.uint8 or pixels.shape[2] != 1:
                raise InputError(f"{name}: is not an 8-bit grey picture")
            return Raster.from_array(pixels[..., 0])
        if kind is np.ndarray:
            return self._array(data, name)
        return None

    def _image(self, data: Any, name: str) -> Image:
        pixels = _decode(self._file(data, name), Path(str(data["file"])).suffix, name)
        profile = data.get("profile")
        try:
            metadata = tuple(Attribute(a, kind, _freeze(value)) for a, kind, value in data.get("metadata", ()))
        except (TypeError, ValueError):
            raise InputError(f"{name}: has damaged metadata") from None
        icc = None if profile is None else self._file({"file": profile}, name)
        return replace(pixels, linear=bool(data.get("linear")), icc=icc, metadata=metadata)

    def _array(self, data: object, name: str) -> np.ndarray[Any, Any]:
        if isinstance(data, list):
            try:
                return readonly(np.array(data, np.float64))
            except (TypeError, ValueError):
                raise InputError(f"{name}: is not a list of numbers") from None
        return readonly(read_npy(self._file(data, name), name))

    def _file(self, data: object, name: str) -> bytes:
        file = data.get("file") if isinstance(data, dict) else None
        if not isinstance(file, str) or file not in self._members:
            raise InputError(f"{name}: its file is missing")
        with faults_named(name):
            return self._members.read(file)


def _suffix(image: Image) -> str:
    return ".tif" if image.pixels.dtype == np.float32 else ".png"


_kept: WeakKeyDictionary[Image, bytes] = WeakKeyDictionary()


def _cache(image: Image) -> bytes:
    """Return the file of a picture's pixels; a document's picture is packed once, however often it is saved."""
    if image not in _kept:
        _kept[image] = _encode(image)
    return _kept[image]


def _encode(image: Image) -> bytes:
    """Return the pixels, and nothing else of `image`, as a PNG or TIFF file."""
    with scratch_folder() as folder:
        place = folder / f"picture{_suffix(image)}"
        metadata = _FAST_PNG if place.suffix == ".png" else ()
        save(replace(image, icc=None, metadata=metadata), place)
        return place.read_bytes()


def _decode(content: bytes, suffix: str, name: str) -> Image:
    """Return the picture in a file's bytes."""
    if suffix not in (".png", ".tif", ".tiff", ".exr"):
        raise InputError(f"{name}: holds a damaged picture")
    with scratch_folder() as folder:
        place = folder / f"picture{suffix}"
        place.write_bytes(content)
        try:
            return load(place)
        except TooLargeError as fault:
            raise InputError(str(fault).replace(str(place), name)) from None
        except InputError:
            raise InputError(f"{name}: holds a damaged picture") from None


def _as_data(entry: Attribute) -> list[Any] | None:
    """Return an entry of metadata as JSON data; None, and a notice, for what JSON has no form for."""
    value = entry.value.tolist() if isinstance(entry.value, np.ndarray | np.generic) else entry.value
    data = [entry.name, entry.kind, list(value) if isinstance(value, tuple) else value]
    try:
        json.dumps(data)
    except (TypeError, ValueError, RecursionError):
        notice(f"saved without metadata that a project cannot hold: {entry.name}")
        return None
    return data


def _freeze(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
