"""Say what this machine has of what Weft needs, in lines that can be passed on with a report."""

import argparse
import locale
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import metadata
from pathlib import Path

import platformdirs

from app.bench import machine
from app.ui.fault_reports import reports_folder
from core.arrays import WeftError
from core.files.atomic import check_outputs, write_text
from core.imaging.picture_bounds import memory_bytes

PACKAGES = (
    "numpy",
    "scipy",
    "cvxopt",
    "opencv-contrib-python-headless",
    "OpenImageIO",
    "PyMaxflow",
    "scikit-learn",
    "moderngl",
    "imgui-bundle",
    "glfw",
    "av",
)
OPTIONAL = {"distributed": "weft batch --cluster: pip install 'weft[cluster]'"}
_LAST_FAULTS = 3


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="write the lines to a file, to attach it")


def run(arguments: argparse.Namespace) -> None:
    """Look, and print or write what was seen; raise `WeftError` where something that Weft needs is missing."""
    check_outputs([arguments.output])
    missing: list[str] = []
    text = "".join(f"{line}\n" for line in examine(missing))
    if arguments.output is not None:
        write_text(arguments.output, text)
    else:
        sys.stdout.write(text)
    if missing:
        raise WeftError(f"missing: {', '.join(missing)}")


def examine(missing: list[str]) -> Iterator[str]:
    """Yield the lines; what Weft cannot do without goes to `missing`."""
    yield f"Weft {_version('weft') or 'not installed'}, {sys.executable}"
    yield machine.describe()
    memory = memory_bytes()
    yield f"system: {platform.platform()}, memory {'unknown' if memory is None else f'{memory / 2**30:.0f} GiB'}"
    yield f"text: {locale.getpreferredencoding(False)}, file names {sys.getfilesystemencoding()}"
    for name in PACKAGES:
        found = _version(name)
        if found is None:
            missing.append(name)
        yield f"{name}: {found or 'MISSING'}"
    for name, use in OPTIONAL.items():
        yield f"{name}: {_version(name) or f'not installed; for {use}'}"
    yield from _asked("OpenGL without a window", _graphics, missing)
    yield from _asked("display", _display, None)
    yield from _asked("formats", _formats, missing)
    yield f"settings: {platformdirs.user_config_path('weft')}"
    yield from _faults()


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _asked(name: str, ask: Callable[[], Iterator[str]], missing: list[str] | None) -> Iterator[str]:
    """Yield what `ask` says, or why it cannot."""
    try:
        yield from ask()
    except Exception as fault:  # noqa: BLE001  whatever is wrong with the machine is what is to be said
        if missing is not None:
            missing.append(name)
        yield f"{name}: MISSING: {' '.join(str(fault).split())}"


def _graphics() -> Iterator[str]:
    """Say which GPU and driver draw, and in which limits."""
    from app.render import gpu

    info = gpu.standalone().info
    yield f"GPU: {info['GL_RENDERER']}, {info['GL_VENDOR']}"
    yield f"driver: OpenGL {info['GL_VERSION']}, textures up to {info['GL_MAX_TEXTURE_SIZE']}"


def _display() -> Iterator[str]:
    """Say what the window would open on."""
    names = [f"{name}={os.environ[name]}" for name in ("DISPLAY", "WAYLAND_DISPLAY") if os.environ.get(name)]
    if not names and sys.platform.startswith("linux"):
        yield "display: none (the window needs one; all commands but the editor work without)"
        return
    yield from _monitors(" ".join(names))


def _monitors(names: str) -> Iterator[str]:
    """Say which monitors there are, in a process of their own: a window system that is broken can end it."""
    program = (
        "import glfw; glfw.init() or exit('GLFW cannot open it')\n"
        "for m in glfw.get_monitors():\n"
        "    mode = glfw.get_video_mode(m)\n"
        "    print(glfw.get_monitor_name(m).decode(errors='replace') if isinstance(glfw.get_monitor_name(m), bytes)"
        " else glfw.get_monitor_name(m), f'{mode.size.width}x{mode.size.height}', 'scale',"
        " *('%g' % s for s in glfw.get_monitor_content_scale(m)))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=20, check=False)
    if done.returncode:
        yield f"display: {names}: MISSING: {(done.stderr.strip().splitlines() or ['cannot be opened'])[-1]}"
    for line in done.stdout.splitlines():
        yield f"display: {names} {line}".replace("  ", " ")


def _formats() -> Iterator[str]:
    """Say which pictures and videos can be written."""
    import av
    import OpenImageIO

    yield f"pictures: {OpenImageIO.get_string_attribute('format_list')}"
    encoders = [name for name in ("prores_ks", "libx264", "ffv1") if name in av.codecs_available]
    yield f"videos: FFmpeg {av.ffmpeg_version_info}, {', '.join(encoders)}"


def _faults() -> Iterator[str]:
    """Say where reports of the program's faults lie, and quote the first lines of the last ones."""
    folder = reports_folder()
    files = sorted(folder.glob("weft-fault-*.txt"))[-_LAST_FAULTS:] if folder.is_dir() else []
    yield f"faults: {folder}, {len(files) or 'none'}{' shown' if files else ''}"
    for file in files:
        lines = file.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        yield f"  {file.name}: {lines[1] if len(lines) > 1 else ''}; {lines[-1] if lines else ''}"
