"""The cache folder of the demo assets: built once and atomically, also by several processes at the same time."""

from __future__ import annotations

import pytest

from usdsdg.demo import build, root
from usdsdg.errors import AssetError


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
