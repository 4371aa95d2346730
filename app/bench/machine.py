"""What the timings were taken on."""

import platform
from importlib import metadata
from pathlib import Path

from core.linalg.jobs_beside import count_processors

PACKAGES = ("numpy", "scipy", "cvxopt", "opencv-contrib-python-headless", "moderngl")


def describe() -> str:
    """Return processor, cores, system and the versions that matter, in one line."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in PACKAGES)
    python, cores = platform.python_version(), count_processors()
    return f"{_processor()}, {cores} cores, {platform.system()}, Python {python}, {versions}"


def _processor() -> str:
    """Return the processor's name as the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
