"""What the editor loads before its first frame, and what after it."""

import subprocess
import sys

LATER = "import sys; from app.shell import LOADED_LATER, load_rest; later = set(LOADED_LATER)"


def run(code: str) -> None:
    """Run `code` in a Python of its own, which has imported nothing else."""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_the_editor_starts_without_the_solvers_of_its_tools() -> None:
    run(f"import app.commands.edit; {LATER}; assert not later & set(sys.modules), later & set(sys.modules)")


def test_the_tools_find_everything_loaded() -> None:
    run(f"{LATER}; load_rest(); assert later <= set(sys.modules), later - set(sys.modules)")
