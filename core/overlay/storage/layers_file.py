"""What was found of a photo, as arrays of a project: opened again it is shown without a search.

The detail is not stored: it is what the photo has beside Wp T(Wg), and is computed anew to the bit.
"""

import io
from collections.abc import Callable, Mapping

import numpy as np

from core.arrays import Floats, InputError, Pixels, Singles
from core.files.npy_file import read_npy
from core.overlay.composition import difference, finite
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.filters.texture_filter import filter_large
from core.overlay.texel import Texel

FOLDER = "layers/"
NAMES = ("uv", "shading", "coverage", "texel", "basis", "keys", "points", "bases", "scores", "explained")
"""Arrays of the layers, and the lattice's."""


def pack(arrays: Mapping[str, Pixels]) -> dict[str, bytes]:
    """Return the files of arrays, by their place in a project."""
    files: dict[str, bytes] = {}
    for name in NAMES:
        buffer = io.BytesIO()
        np.save(buffer, arrays[name], allow_pickle=False)
        files[f"{FOLDER}{name}.npy"] = buffer.getvalue()
    return files


def unpacked(read: Callable[[str], bytes], shape: tuple[int, int]) -> dict[str, Pixels]:
    """Return the arrays of a picture of `shape` (H, W); raise `InputError` where they are missing or do not fit."""
    arrays = {name: read_npy(read(f"{FOLDER}{name}.npy"), name) for name in NAMES}
    count = len(arrays["keys"])
    wanted: dict[str, tuple[tuple[int, ...], ...]] = {
        "uv": ((*shape, 2),),
        "shading": (shape, (*shape, 3)),
        "coverage": (shape,),
        "basis": ((2, 2),),
        "keys": ((count, 2),),
        "points": ((count, 2),),
        "bases": ((count, 2, 2),),
        "scores": ((count,),),
        "explained": ((),),
    }
    texel = arrays["texel"]
    if texel.ndim != 3 or texel.shape[2] != 3 or texel.dtype != np.uint8 or not texel.size:
        raise InputError("texel: is no 8-bit picture")
    for name, shapes in wanted.items():
        if arrays[name].shape not in shapes or arrays[name].dtype.kind not in "fi":
            raise InputError(f"{name}: is not of this picture")
    covered = finite(arrays["uv"])
    if not covered.any() or not all(np.isfinite(arrays[name][covered]).all() for name in ("shading", "coverage")):
        raise InputError("layers: are not finite on the cloth")
    return arrays


def lattice_of(arrays: Mapping[str, Pixels]) -> Lattice:
    """Return the lattice of unpacked arrays."""
    points, bases, scores = (np.asarray(arrays[name], np.float64) for name in ("points", "bases", "scores"))
    return Lattice(np.asarray(arrays["keys"], np.int64), PatchFrames(points, bases, scores))


def detail_of(photo: Floats | Singles, uv: Singles, shading: Singles, texel: Texel) -> Singles:
    """Return HF = I - Wp T(Wg) (H, W, 3), NaN outside the cloth."""
    light = shading if shading.ndim == 3 else shading[..., None]
    return difference(photo, filter_large(texel.pixels, uv) * np.nan_to_num(light), finite(uv))
