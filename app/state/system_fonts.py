"""Fonts of the system by what they can write: asked of fontconfig, or among those that systems come with."""

import os
import subprocess
import sys
from pathlib import Path

READABLE = frozenset({".ttf", ".otf", ".ttc"})
USUAL = (
    *("msyh.ttc", "malgun.ttf", "YuGothM.ttc", "segoeui.ttf", "seguisym.ttf", "LeelawUI.ttf", "Nirmala.ttc"),
    *("Hiragino Sans GB.ttc", "AppleSDGothicNeo.ttc", "Arial Unicode.ttf"),
    *("NotoSansCJK-Regular.ttc", "DroidSansFallbackFull.ttf", "wqy-microhei.ttc", "DejaVuSans.ttf"),
)
"""Files of Windows, macOS and Linux that together write most of the world's scripts."""
ANSWERS_S = 10.0
"""How long fontconfig may take, which the first time reads all fonts."""


def find_fonts(code: int) -> list[tuple[Path, int]]:
    """Return files of fonts that may have a character, the likely ones first, each with its number in the file."""
    found = _ask_fontconfig(code)
    return _usual() if found is None else found


def _ask_fontconfig(code: int) -> list[tuple[Path, int]] | None:
    """Return the font that fontconfig has for a character, if any; None where there is no fontconfig."""
    command = ["fc-match", "-f", "%{file}\t%{index}\t%{charset}", f"sans:charset={code:x}"]
    try:
        done = subprocess.run(command, capture_output=True, check=True, timeout=ANSWERS_S)
    except (OSError, subprocess.SubprocessError):
        return None
    file, _, rest = os.fsdecode(done.stdout).partition("\t")
    index, _, charset = rest.partition("\t")
    has_it = any(_holds(span, code) for span in charset.split())
    return [(Path(file), int(index) & 0xFFFF)] if has_it and Path(file).suffix.lower() in READABLE else []


def _holds(span: str, code: int) -> bool:
    """Return whether "4e00-9fa5" or "20ac" holds a character."""
    first, _, last = span.partition("-")
    return int(first, 16) <= code <= int(last or first, 16)


def _usual() -> list[tuple[Path, int]]:
    """Return those of the usual files that are on this machine."""
    if sys.platform == "win32":
        folders = [Path(os.environ.get("WINDIR", r"C:\Windows")) / "Fonts"]
    elif sys.platform == "darwin":
        folders = [Path("/System/Library/Fonts"), Path("/Library/Fonts")]
    else:
        folders = [Path("/usr/share/fonts"), Path("/usr/local/share/fonts"), Path.home() / ".local/share/fonts"]
    there = {path.name: path for folder in folders for path in folder.rglob("*") if path.name in USUAL}
    return [(there[name], 0) for name in USUAL if name in there]
