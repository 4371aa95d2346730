"""Which solver is found: the GPU's on hardware, on a software driver only where it is asked for."""

from types import SimpleNamespace

import pytest

from app.render.solver.choice import GpuSolver


def driver(monkeypatch: pytest.MonkeyPatch, name: str, version: int) -> None:
    context = SimpleNamespace(version_code=version, info={"GL_RENDERER": name})
    monkeypatch.setattr("app.render.gpu.standalone", lambda: context)


@pytest.mark.parametrize(
    ("name", "version", "preferred", "found"),
    [
        ("NVIDIA GeForce RTX 3060", 460, "auto", True),
        ("NVIDIA GeForce RTX 3060", 460, "processor", False),
        ("Apple M1", 410, "auto", False),
        ("Apple M1", 410, "gpu", False),
        ("llvmpipe (LLVM 15.0.6, 256 bits)", 450, "auto", False),
        ("llvmpipe (LLVM 15.0.6, 256 bits)", 450, "gpu", True),
        ("NVIDIA GeForce RTX 3060", 460, "nonsense", False),
    ],
)
def test_the_gpu_solves_where_it_is_one(
    monkeypatch: pytest.MonkeyPatch, name: str, version: int, preferred: str, found: bool
) -> None:
    driver(monkeypatch, name, version)
    assert (GpuSolver().find(preferred) is not None) == found
