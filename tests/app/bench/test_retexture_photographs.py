"""`weft bench --only retexture-photographs DIR`: figures and sheets of pictures with curves."""

import json
from pathlib import Path

import pytest

from app.bench.retexture_photographs import half_of, measure, summarise
from app.cli import main
from core.arrays import InputError
from core.imaging.image import Image
from core.imaging.images import load, save
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, bent, data_of, stripes


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    save(Image(stripes()), tmp_path / "rug.png")
    text = json.dumps(data_of(bent()))
    for name in ("rug", "rug_again"):
        (tmp_path / f"{name}.curves.json").write_text(text, encoding="utf-8")
    return tmp_path


def test_every_file_of_curves_is_judged_and_shown(folder: Path) -> None:
    sheets = folder / "sheets"
    records = measure(folder, sheets)
    assert [record["name"] for record in records] == ["rug", "rug_again"]
    assert {record["half"] for record in records} == {half_of("rug")}
    assert all(record["regrown"] > 0.1 for record in records)
    assert all(record["holds"] == (record["excess"] <= 0.02) for record in records)
    width, height = load(sheets / "rug.png").size_px
    assert width > 2 * 2 * WIDTH * 0.9
    assert height > 2 * HEIGHT * 0.5
    both = summarise(records)[-1]
    assert (both["half"], both["of"]) == ("both", 2)


def test_the_command_prints_both_lists(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["bench", "--json", "--only", "retexture-photographs", str(folder), "--sheets", str(folder / "seen")])
    found = json.loads(capsys.readouterr().out)
    assert [record["name"] for record in found["retexture-photographs"]] == ["rug", "rug_again"]
    assert [record["half"] for record in found["retexture-photographs_by_half"]] == [0, 1, "both"]
    assert (folder / "seen" / "rug_again.png").exists()


def test_halves_do_not_depend_on_other_pictures() -> None:
    assert {half_of(name) for name in ("rug", "fox", "cat", "tail", "hair")} == {0, 1}
    assert [half_of(name) for name in ("rug", "tail")] == [1, 0]


def test_a_folder_without_curves_or_pictures_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no curves"):
        measure(tmp_path)
    (tmp_path / "rug.curves.json").write_text(json.dumps(data_of(bent())), encoding="utf-8")
    with pytest.raises(InputError, match="no picture beside it"):
        measure(tmp_path)
