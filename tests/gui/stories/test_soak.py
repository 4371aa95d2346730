"""A hand without a plan at the real window, for a minute or so; `make soak` goes on for as long as it is told."""

import subprocess
import sys

import pytest

DEEDS = 900


@pytest.mark.gui
@pytest.mark.slow
@pytest.mark.parametrize("seed", [0])
def test_the_window_takes_whatever_a_hand_without_a_plan_does(seed: int) -> None:
    command = [sys.executable, "-m", "tests.fuzz.soak", "--deeds", str(DEEDS), "--seed", str(seed)]
    outcome = subprocess.run(command, capture_output=True, text=True, check=False)
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    assert " deeds " in outcome.stdout
