"""A lock that is somebody's as long as they live."""

from pathlib import Path

from core.files.ownership import claim, is_claimed


def test_a_lock_is_held_once_and_can_be_taken_again(tmp_path: Path) -> None:
    path = tmp_path / "a.lock"
    assert not is_claimed(path)
    first = claim(path)
    assert first is not None
    assert is_claimed(path)
    assert claim(path) is None
    first.release()
    assert not is_claimed(path)
    assert claim(path) is not None


def test_a_removed_lock_is_nobodys(tmp_path: Path) -> None:
    path = tmp_path / "a.lock"
    first = claim(path)
    assert first is not None
    first.release(remove=True)
    assert not path.exists()
    second = claim(path)
    assert second is not None
    assert is_claimed(path)


def test_a_lock_goes_with_the_object(tmp_path: Path) -> None:
    held = claim(tmp_path / "a.lock")
    assert held is not None
    del held
    assert not is_claimed(tmp_path / "a.lock")
