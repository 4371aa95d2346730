"""What a fault of the program looks like to those who are to mend it: a text that the artist can pass on."""

import platform
import time
import traceback
from pathlib import Path

import platformdirs

from app.editor.editor import Editor
from core.files.atomic import write_text
from core.files.faults import make_folder

LAST_STEPS = 10
"""So many labels of the history stand in a report."""


def reports_folder() -> Path:
    """Return the folder of the user's reports."""
    return Path(platformdirs.user_state_path("weft")) / "faults"


def report_of(part: str, error: BaseException, editor: Editor) -> str:
    """Return what is known of a fault that came up in `part` of the window: program, steps before it, traceback."""
    from importlib import metadata  # not before the first frame

    try:
        program = metadata.version("weft")
    except metadata.PackageNotFoundError:
        program = "unknown"
    width, height = editor.document.size_px
    steps = editor.history.labels[: editor.history.index + 1][-LAST_STEPS:]
    return "\n".join(
        [
            f"Weft {program}, Python {platform.python_version()}, {platform.platform()}",
            f"In: {part}; mode {editor.session.mode}, {editor.state}, picture {width} x {height}",
            f"Last steps: {', '.join(steps)}",
            "",
            "".join(traceback.format_exception(error)),
        ]
    )


def write_report(text: str, folder: Path) -> Path:
    """Write a report into `folder` and return its file; raise `InputError` where that cannot be done."""
    make_folder(folder)
    file = folder / time.strftime("weft-fault-%Y%m%d-%H%M%S.txt")
    write_text(file, text)
    return file


def place_of(error: BaseException) -> str:
    """Return the line of code that raised `error`, to tell one fault from another."""
    last = traceback.extract_tb(error.__traceback__)[-1:]
    where = f"{last[0].filename}:{last[0].lineno}" if last else ""
    return f"{type(error).__name__} {where}"
