"""The tables of `weft bench --only photographs DIR`."""

import json
from pathlib import Path

import numpy as np
import pytest

from app.bench import photographs, search_stages
from app.cli import main
from core.imaging.images import load, save
from core.overlay.cloth_search import Known, find
from core.overlay.laying.compositing import encode
from core.overlay.registration import fitting
from core.progress import run
from tests.core.overlay.overlay_scenes import make_scene, motif, stored


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    scene = make_scene(motif(), size=(130, 150))
    save(stored(scene.photo), tmp_path / "bees.png")
    save(stored(np.ones((130, 150, 1))), tmp_path / "bees_mask.png")
    save(stored(np.random.default_rng(0).random((60, 70, 3))), tmp_path / "noise.png")
    save(stored(np.random.default_rng(1).random((60, 70, 3))), tmp_path / "refuse_noise.png")
    save(stored(np.full((60, 70, 3), 0.5)), tmp_path / "plain_wall.png")
    save(stored(np.full((9, 9, 3), 0.2)), tmp_path / "new_grey.png")
    return tmp_path


def test_photographs_are_judged_by_halves(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--json", "--only", "photographs", str(folder)]) == 0
    printed = json.loads(capsys.readouterr().out)
    tasks = [(record["name"], record["task"], record["outcome"]) for record in printed["photographs"]]
    assert tasks == [
        ("bees", "painted", "found"),
        ("bees", "whole_cloth", "found"),
        ("noise", "painted", "refused"),
        ("refuse_noise", "refused", "refused"),
    ]
    first = printed["photographs"][0]
    assert first["covers"] > 0.9
    assert first["likeness"] > 0.9
    assert 0 < first["remains"] < 0.05
    halves = [[row[task] for task in ("painted", "whole_cloth", "refused")] for row in printed["photographs_by_half"]]
    assert halves == [[1.0, 1.0, 1.0], [0.0, None, None], [0.5, 1.0, 1.0]]


def test_a_fault_is_counted_and_the_rest_goes_on(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ValueError("broken")

    monkeypatch.setattr(photographs, "lay_over", broken)
    records = photographs.measure(folder)
    assert [record["outcome"] for record in records] == ["fault", "fault", "refused", "refused"]
    assert [row["faults"] for row in photographs.summarise(records)] == [2, 0, 2]


@pytest.mark.parametrize("words", [["photographs"], ["photographs", "nowhere"], ["mappings"]])
def test_what_cannot_be_measured_is_named(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--only", *words]) == 2
    assert f"weft: error: --only {words[0]}" in capsys.readouterr().err


def test_a_folder_without_photographs_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--only", "photographs", str(tmp_path)]) == 2
    assert f"{tmp_path}: holds no photographs" in capsys.readouterr().err


def test_what_a_stage_is_worth_is_what_leaving_it_out_changes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--json", "--only", "photographs", str(folder), "--without", "light_folds"]) == 0
    printed = json.loads(capsys.readouterr().out)
    both = printed["photographs_by_stage"]
    assert [(record["name"], record["without"]) for record in both] == [("bees", "light_folds"), ("bees", "nothing")]
    whole, less = printed["photographs_without"]
    assert whole["explains"] == both[1]["explains"] > 0.9
    assert less["explains"] == pytest.approx(both[0]["explains"] - both[1]["explains"]) != 0


def test_a_stage_that_there_is_not_is_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--only", "photographs", str(folder), "--without", "magic"]) == 2
    assert "weft: error: --without magic: not one of each, alike_keypoints" in capsys.readouterr().err


def test_stages_are_left_out_by_turns(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--without", "true_period", "find_large", "fill_gaps"]
    assert main(["bench", "--json", "--only", "photographs", str(folder), *words]) == 0
    printed = json.loads(capsys.readouterr().out)
    records = {record["without"]: record for record in printed["photographs_by_stage"]}
    assert list(records) == ["true_period", "find_large", "fill_gaps", "nothing"]
    unreached, whole = records["find_large"], records["nothing"]
    assert whole["holds"]
    assert {**unreached, "without": "nothing"} == whole
    rows = {row["without"]: row for row in printed["photographs_without"]}
    assert rows["nothing"]["explains"] == whole["explains"]
    assert rows["true_period"]["explains"] == records["true_period"]["explains"] - whole["explains"]


def test_a_stage_that_is_left_out_is_not_run_and_stands_again_later(folder: Path) -> None:
    own = fitting.true_period
    image = load(folder / "bees.png")
    for name, seen in (("alike_keypoints", "with_more_pieces"), ("true_period", "alike_keypoints")):
        stage = search_stages.SEARCH_STAGES[name]
        with search_stages.watched() as reached, search_stages.replaced(name, stage.instead):
            run(find(encode(image), Known()))
        assert name not in reached
        assert seen in reached
    assert fitting.true_period is own
