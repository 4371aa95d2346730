"""Put Weft among the programs of a Linux desktop: menu entry, icon, and .weft files that open with it.

What is written lies in the user's own folders (the XDG data folder), and goes with --remove.
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

import platformdirs

from core.arrays import InputError
from core.files.atomic import AtomicFiles
from core.files.faults import make_folder

_ENTRY = """\
[Desktop Entry]
Type=Application
Name=Weft
GenericName=Picture warper
Comment=Bend a picture and keep its features
Exec={program} %f
Icon=weft
Terminal=false
Categories=Graphics;2DGraphics;RasterGraphics;
MimeType=application/x-weft;image/png;image/jpeg;image/tiff;image/webp;image/x-exr;image/jxl;
"""
_TYPE = """\
<?xml version="1.0" encoding="UTF-8"?>
<mime-info xmlns="http://www.freedesktop.org/standards/shared-mime-info">
  <mime-type type="application/x-weft">
    <comment>Weft project</comment>
    <sub-class-of type="application/zip"/>
    <icon name="weft"/>
    <glob pattern="*.weft"/>
  </mime-type>
</mime-info>
"""
_RENEW = (("update-mime-database", "mime"), ("update-desktop-database", "applications"))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--remove", action="store_true", help="take it away again")


def run(arguments: argparse.Namespace) -> None:
    """Write the files, or remove them, and have the desktop look again."""
    if not sys.platform.startswith("linux"):
        raise InputError("desktop: is for desktops on Linux")
    data = Path(platformdirs.user_data_path())
    files = contents(Path(sys.argv[0]))
    if arguments.remove:
        for name in files:
            (data / name).unlink(missing_ok=True)
    else:
        _write(data, files)
    for program, folder in _RENEW:
        if shutil.which(program) is not None and (data / folder).is_dir():
            subprocess.run([program, str(data / folder)], capture_output=True, check=False)
    sys.stdout.write("".join(f"{data / name}\n" for name in files))


def contents(called: Path) -> dict[str, bytes]:
    """Return the files by their places in the data folder; `called` is how the program was."""
    found = shutil.which(str(called)) if called.name == "weft" else shutil.which("weft")
    program = Path(found).absolute() if found else Path(sys.executable).with_name("weft")
    quoted = str(program).replace("\\", "\\\\").replace('"', '\\"')
    return {
        "applications/weft.desktop": _ENTRY.format(program=f'"{quoted}"' if " " in quoted else quoted).encode(),
        "mime/packages/weft.xml": _TYPE.encode(),
        "icons/hicolor/scalable/apps/weft.svg": icon().encode(),
    }


def icon() -> str:
    """Return the emblem as SVG: three weft threads through three warp threads."""
    warp = "".join(f'<path d="M{x} 26V230"/>' for x in (64, 128, 192))
    weft = "".join(
        f'<path stroke="{colour}" d="M26 {y}q25 {bend} 51 0t51 0 51 0 51 0"/>'
        for y, bend, colour in ((64, 16, "#5b9cf5"), (128, -16, "#f5a742"), (192, 16, "#5b9cf5"))
    )
    over = "".join(f'<path d="M{x} {y - 26}v52"/>' for y in (64, 128, 192) for x in _raised(y))
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 256 256">'
        '<rect width="256" height="256" rx="46" fill="#26282c"/>'
        f'<g fill="none" stroke-width="28" stroke-linecap="round"><g stroke="#8a9099">{warp}</g>{weft}'
        f'<g stroke="#8a9099" stroke-linecap="butt">{over}</g></g></svg>\n'
    )


def _raised(row_px: int) -> tuple[int, ...]:
    """Return where the warp threads lie over the weft in a row: every other one."""
    return (128,) if row_px != 128 else (64, 192)


def _write(data: Path, files: dict[str, bytes]) -> None:
    with AtomicFiles() as together:
        for name, content in files.items():
            path = data / name
            make_folder(path.parent)
            with together.place(path) as place:
                place.write_bytes(content)
