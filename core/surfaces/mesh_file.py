"""Meshes with texture coordinates from files: OBJ with `vt`, glTF with TEXCOORD_0, and what else trimesh reads."""

import io
import json
import logging
import struct
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from core.arrays import Floats, InputError, Ints, Points
from core.files.faults import faults_named, system_faults_named
from core.files.json_file import parse_json
from core.surfaces.surface import MOST, Surface

SUFFIXES = (".obj", ".gltf", ".glb", ".ply", ".off")
LARGEST_BYTES = 400_000_000


class Part(NamedTuple):
    """A mesh of several in a file, see `Surface`."""

    vertices: Floats
    texture: Points
    triangles: Ints


def read_mesh(path: Path) -> Surface:
    """Return the surface in the file `path`, all its parts as one.

    Raises `InputError` that names the file where it holds no surface with texture coordinates.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: not a mesh: its name ends with none of {', '.join(SUFFIXES)}")
    with system_faults_named(path):
        if path.stat().st_size > LARGEST_BYTES:
            raise InputError(f"{path}: larger than {LARGEST_BYTES // 1_000_000} MB")
        parts = _read_parts(path)
    if not parts:
        raise InputError(f"{path}: has no triangles with texture coordinates")
    with faults_named(path):
        return _join(path.stem, parts)


def _read_parts(path: Path) -> list[Part]:
    """Return the parts of a mesh that have texture coordinates, in one space."""
    # Loading it takes longer than all else of a start, and only those who open a mesh need it.
    import trimesh

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    found: list[Part] = []
    kind = path.suffix.lower()[1:]
    try:
        content = path.read_bytes()
        if kind in ("gltf", "glb"):
            content = _without_pictures(content)
        resolver = trimesh.resolvers.FilePathResolver(str(path))
        scene = trimesh.load_scene(
            io.BytesIO(content), file_type=kind, resolver=resolver, process=False, skip_materials=kind == "obj"
        )
        for node in scene.graph.nodes_geometry:
            transform, name = scene.graph[node]
            mesh: Any = scene.geometry[name]
            texture = getattr(getattr(mesh, "visual", None), "uv", None)
            if texture is not None and len(mesh.faces):
                vertices = trimesh.transform_points(np.asarray(mesh.vertices, np.float64), transform)
                # Files count up from the bottom.
                texture = np.asarray(texture, np.float64)[:, :2] * [1, -1] + [0, 1]
                found.append(Part(np.asarray(vertices), texture, np.asarray(mesh.faces, np.int64)))
    except OSError:
        raise
    except Exception as fault:
        raise InputError(f"{path}: not a mesh, or damaged") from fault
    return found


def _without_pictures(content: bytes) -> bytes:
    """Return a glTF file whose parts all have one plain material: trimesh drops texture coordinates without any.

    The pictures that it was painted with are of no use here, and may be missing.
    """
    head, rest = b"", b""
    if content[:4] == b"glTF":
        length = int.from_bytes(content[12:16], "little")
        head, content, rest = content[:8], content[20 : 20 + length], content[20 + length :]
    data = parse_json(content)
    for name in ("textures", "images", "samplers"):
        data.pop(name, None)
    data["materials"] = [{}]
    for mesh in data.get("meshes", []):
        for primitive in mesh["primitives"]:
            primitive["material"] = 0
    text = json.dumps(data).encode()
    if not head:
        return text
    text += b" " * (-len(text) % 4)
    size = 20 + len(text) + len(rest)
    return head + struct.pack("<I", size) + struct.pack("<I4s", len(text), b"JSON") + text + rest


def _join(name: str, parts: list[Part]) -> Surface:
    if sum(len(part.triangles) for part in parts) > MOST:
        raise InputError(f"has more than {MOST} triangles")
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return Surface(
        name,
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.texture for part in parts]),
        np.concatenate([part.triangles + start for part, start in zip(parts, first, strict=False)]),
    )
