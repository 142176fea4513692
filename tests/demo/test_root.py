"""The cache folder of the demo assets: built once and atomically, also by several processes at the same time."""

from __future__ import annotations

import pytest

from usdsdg.demo import build, root
from usdsdg.errors import AssetError, UsdsdgWarning
from usdsdg.stage.assets.cache_folder import _checked


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "usdsdg"


def test_the_folder_is_built_once(cache, monkeypatch):
    built = []

    def quick(folder):
        built.append(folder)
        (folder / "Isaac").mkdir()

    monkeypatch.setattr(build, "build", quick)
    first, second = root(), root()
    assert first == second
    assert len(built) == 1
    assert [entry.name for entry in cache.iterdir()] == [first.rsplit("/", 1)[1]]
    assert (cache / first / "Isaac").is_dir()


@pytest.mark.parametrize("damage", ["cut", "empty", "flipped", "removed", "no folder", "no checksums"])
def test_what_is_damaged_in_the_folder_is_built_again(damage, cache, monkeypatch):
    def quick(folder):
        (folder / "Isaac/Props").mkdir(parents=True)
        (folder / "Isaac/Props/box.usd").write_bytes(b"PXR-USDC of a box")
        (folder / "Isaac/other.usd").write_bytes(b"PXR-USDC of another")

    monkeypatch.setattr(build, "build", quick)
    folder = build.Path(root())
    box, others = folder / "Isaac/Props/box.usd", (folder / "Isaac/other.usd").stat()
    (folder / "Isaac/own.usda").write_text("of the user")
    match damage:
        case "cut":
            box.write_bytes(box.read_bytes()[:9])
        case "empty":
            box.write_bytes(b"")
        case "flipped":
            box.write_bytes(b"PXR-USDC of a bOx")
        case "removed":
            box.unlink()
        case "no folder":
            box.unlink()
            box.parent.rmdir()
        case "no checksums":
            (folder / ".checksums.json").write_bytes(b"{")
    _checked.clear()  # as in another process
    with pytest.warns(UsdsdgWarning, match="were damaged or missing"):
        assert root() == str(folder)
    assert box.read_bytes() == b"PXR-USDC of a box"
    assert (folder / "Isaac/other.usd").stat().st_ino == others.st_ino  # others may have it open
    assert (folder / "Isaac/own.usda").is_file()
    assert [entry.name for entry in cache.iterdir()] == [folder.name]
    _checked.clear()
    monkeypatch.setattr(build, "build", None)
    assert root() == str(folder)


def test_a_failed_build_leaves_nothing(cache, monkeypatch):
    def broken(folder):
        (folder / "half").mkdir()
        raise RuntimeError("out of luck")

    monkeypatch.setattr(build, "build", broken)
    with pytest.raises(RuntimeError, match="out of luck"):
        root()
    assert list(cache.iterdir()) == []


def test_of_two_processes_that_build_the_first_to_finish_wins(cache, monkeypatch):
    def slow(folder):
        (folder / "mine").mkdir()
        (folder.parent / f"demo-{build._release()}-{build.EDITION}" / "theirs").mkdir(parents=True)

    monkeypatch.setattr(build, "build", slow)
    folder = build.Path(root())
    assert [entry.name for entry in folder.iterdir()] == ["theirs"]
    assert list(cache.iterdir()) == [folder]


def test_a_cache_folder_that_cannot_be_written_is_an_error_that_names_it(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    with pytest.raises(AssetError, match=r"demo assets cannot be written to .*XDG_CACHE_HOME"):
        root()
