"""Surfaces check what they are made of; shapes by name, and meshes from files."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from core.arrays import Floats, InputError
from core.surfaces.mesh_file import read_mesh
from core.surfaces.shapes import SHAPES, make_shape
from core.surfaces.surface import Surface

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
FLAT = np.column_stack([SQUARE, np.zeros(4)])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize("name", list(SHAPES))
def test_shapes_show_the_whole_picture_and_their_number_counts(name: str) -> None:
    shape, low = make_shape(name), make_shape(name, SHAPES[name].least)
    assert shape.name == name
    np.testing.assert_allclose([shape.texture.min(), shape.texture.max()], [0, 1], atol=1e-12)
    assert np.abs(shape.vertices - low.vertices).max() > 0.05


def test_a_sphere_is_round_and_a_cube_has_six_faces_of_one_size() -> None:
    np.testing.assert_allclose(np.linalg.norm(make_shape("sphere").vertices, axis=1), 1, atol=1e-12)
    cube = make_shape("cube", 1.0).vertices
    np.testing.assert_allclose(np.abs(cube).max(axis=1), 0.5, atol=1e-12)
    for axis in range(3):
        for side in (-0.5, 0.5):
            assert (np.abs(cube[:, axis] - side) < 1e-9).sum() >= len(cube) // 6


@pytest.mark.parametrize(("name", "number"), [("ball", None), ("sphere", 0.01), ("torus", np.nan)])
def test_other_shapes_are_refused(name: str, number: float | None) -> None:
    with pytest.raises(InputError, match="surface"):
        make_shape(name, number)


@pytest.mark.parametrize(
    ("vertices", "texture", "triangles", "says"),
    [
        (FLAT[:3], SQUARE, HALVES, "texture coordinates"),
        (FLAT, SQUARE, HALVES + 2, "not there"),
        (FLAT, SQUARE, HALVES[:0], "triangles"),
        (FLAT, SQUARE, HALVES + 0.5, "not there"),
        (FLAT * np.nan, SQUARE, HALVES, "finite"),
        (FLAT, SQUARE * [1, 0], HALVES, "cover nothing"),
    ],
)
def test_arrays_that_make_no_surface_are_refused(
    vertices: Floats, texture: Floats, triangles: Floats, says: str
) -> None:
    with pytest.raises(InputError, match=says):
        Surface("s", vertices, texture, np.asarray(triangles))


def test_a_surface_without_area_has_no_chart() -> None:
    with pytest.raises(InputError, match="no area"):
        _ = Surface("s", FLAT * 0, SQUARE, HALVES).chart


def test_texture_beyond_the_picture_is_that_of_its_tile() -> None:
    there = Surface("s", FLAT, SQUARE + [3, -2], HALVES)
    np.testing.assert_allclose(there.corners, Surface("s", FLAT, SQUARE, HALVES).corners)


def write_obj(path: Path, surface: Surface) -> None:
    """Write a surface as an OBJ file, whose texture coordinates count up from the bottom."""
    lines = ["v {} {} {}".format(*vertex) for vertex in surface.vertices]
    lines += [f"vt {x} {1 - y}" for x, y in surface.texture]
    lines += ["f {0}/{0} {1}/{1} {2}/{2}".format(*(corner + 1)) for corner in surface.triangles]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def test_an_obj_file_is_the_surface_that_was_written(tmp_path: Path) -> None:
    given = make_shape("cone")
    write_obj(tmp_path / "cone.obj", given)
    found = read_mesh(tmp_path / "cone.obj")
    assert found.name == "cone"
    np.testing.assert_allclose(found.vertices[found.triangles], given.vertices[given.triangles], atol=1e-6)
    np.testing.assert_allclose(found.corners, given.corners, atol=1e-6)


def write_glb(path: Path, surface: Surface, turn: list[float]) -> None:
    """Write a surface as a binary glTF file, turned by a quaternion x, y, z, w."""
    arrays = [
        surface.vertices.astype("<f4"),
        surface.texture.astype("<f4"),
        surface.triangles.astype("<u4").ravel(),
    ]
    content = b"".join(array.tobytes() for array in arrays)
    starts = np.cumsum([0, *(array.nbytes for array in arrays)]).tolist()
    kinds = [(5126, "VEC3"), (5126, "VEC2"), (5125, "SCALAR")]
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "rotation": turn}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}]}],
        "buffers": [{"byteLength": len(content)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": array.nbytes}
            for start, array in zip(starts, arrays, strict=False)
        ],
        "accessors": [
            {"bufferView": i, "componentType": kind, "count": len(array), "type": shape}
            for i, (array, (kind, shape)) in enumerate(zip(arrays, kinds, strict=True))
        ],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(content), b"BIN\0") + content
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def test_a_gltf_file_is_the_surface_that_was_written(tmp_path: Path) -> None:
    given = make_shape("torus")
    write_glb(tmp_path / "torus.glb", given, [0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)])
    found = read_mesh(tmp_path / "torus.glb")
    # A quarter turn around y: x goes to -z, and z to x.
    expected = given.vertices[:, [2, 1, 0]] * [1, 1, -1]
    np.testing.assert_allclose(found.vertices[found.triangles], expected[given.triangles], atol=1e-5)
    np.testing.assert_allclose(found.corners, given.corners, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("none.obj", None),
        ("text.txt", b"v 0 0 0"),
        ("empty.obj", b""),
        ("damaged.glb", b"glTF\x02\x00\x00\x00 and no more"),
        ("bare.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("far.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/7 9/3\n"),
        ("flat.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0.5 0\nf 1/1 2/2 3/3\n"),
    ],
)
def test_files_that_hold_no_surface_are_refused_by_name(tmp_path: Path, name: str, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=name):
        read_mesh(tmp_path / name)
