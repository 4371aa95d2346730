"""A folder of parts is that of one run."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.arrays import InputError
from core.imaging.images import save
from core.overlay.storage.folder import read
from tests.core.pictures import picture

HEIGHT, WIDTH = 18, 24


def make(folder: Path, **runs: int) -> Path:
    """Write parts whose arrays say that they come from the given runs."""
    folder.mkdir()
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    parts: dict[str, dict[str, Any]] = {
        "texture_coords": {"uv": np.stack([x / 5, y / 5], axis=-1)},
        "shading": {"shading": np.ones((HEIGHT, WIDTH), np.float32)},
        "detail": {"detail": np.zeros((HEIGHT, WIDTH, 3), np.float32)},
    }
    for name, values in parts.items():
        if name in runs:
            values["run"] = np.uint32(runs[name])
        np.savez(folder / f"{name}.npz", allow_pickle=False, **values)
    save(picture(height=HEIGHT, width=WIDTH), folder / "source.png")
    save(picture(), folder / "texel.png")
    (folder / "report.json").write_text(json.dumps({"image": [HEIGHT, WIDTH]}))
    return folder


def test_parts_of_one_run_are_read(tmp_path: Path) -> None:
    assert read(make(tmp_path / "a", texture_coords=5, shading=5, detail=5)).uv.shape == (HEIGHT, WIDTH, 2)
    assert read(make(tmp_path / "b")).uv.shape == (HEIGHT, WIDTH, 2)
    assert read(make(tmp_path / "c", detail=5)).uv.shape == (HEIGHT, WIDTH, 2)


def test_parts_of_different_runs_are_refused(tmp_path: Path) -> None:
    folder = make(tmp_path / "a", texture_coords=5, shading=5, detail=6)
    with pytest.raises(InputError, match=r"mixed: detail\.npz and shading\.npz come from different decompositions"):
        read(folder)
