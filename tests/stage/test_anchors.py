"""Names in place of the folders of assets: the same on every machine, and found again on each."""

import os
from pathlib import Path

import pytest

from usdsdg.errors import AssetError
from usdsdg.stage import assets
from usdsdg.stage.assets import anchors
from usdsdg.stage.assets.cache_folder import cache_folder


@pytest.fixture(autouse=True)
def machine(tmp_path, monkeypatch):
    """A root, a cache, a home and a working folder of one's own; nothing was named from there yet."""
    for name in ("root", "cache", "home", "work"):
        (tmp_path / name).mkdir()
    monkeypatch.setenv("USDSDG_ASSETS_ROOT", str(tmp_path / "root"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path / "work")
    monkeypatch.setattr(anchors, "_named_from", {})
    return tmp_path


def test_folders_of_assets_get_names_wherever_they_are_in_a_text(machine):
    root, cache = machine / "root", machine / "cache/usdsdg"
    text = f'a = @{root}/Isaac/a.usd@ b = "{cache}/meshes/b.usdc" c = [\'{root}/Isaac/c@2.usd\'] d = "{root}"'
    named = """a = @<assets>/Isaac/a.usd@ b = "<cache>/meshes/b.usdc" c = ['<assets>/Isaac/c@2.usd'] d = "<assets>\""""
    assert anchors.portable(text) == named


def test_a_folder_that_is_a_part_of_a_longer_name_stays(machine):
    for path in (f"{machine}/roots/a.usd", f"/mnt{machine}/root/a.usd", f"{machine}/root-2/a.usd"):
        assert anchors.portable(f"@{path}@") == f"@{path}@"


def test_a_file_named_by_its_absolute_path_keeps_it(machine):
    (machine / "work/a.usda").touch()
    (machine / "home/a.usda").touch()
    for place in ("work", "home"):
        assert anchors.portable(assets.locate(machine / place / "a.usda")) == str(machine / place / "a.usda")


@pytest.mark.parametrize(("given", "named"), [("parts/a.usda", "<here>/parts/a.usda"), ("~/a.usda", "<home>/a.usda")])
def test_a_file_is_portable_by_the_folder_that_it_was_named_from(machine, given, named):
    for place in ("work/parts", "home"):
        (machine / place).mkdir(exist_ok=True)
        (machine / place / "a.usda").touch()
    file = assets.locate(given)
    assert anchors.portable(file) == named
    assert anchors.candidates(named, ["/elsewhere"])[0] == file


def test_the_innermost_folder_counts(machine, monkeypatch):
    monkeypatch.chdir(machine)
    (machine / "root/a.usda").touch()
    assert anchors.portable(assets.locate("root/a.usda")) == "<assets>/a.usda"


def test_a_root_that_is_a_link_is_found_by_both_names(machine, monkeypatch):
    os.symlink(machine / "root", machine / "link")
    monkeypatch.setenv("USDSDG_ASSETS_ROOT", str(machine / "link"))
    assert anchors.portable(f"@{machine}/link/a.usd@ @{machine}/root/a.usd@") == "@<assets>/a.usd@ @<assets>/a.usd@"


def test_without_a_root_no_demo_assets_are_made_for_a_text_without_any(machine, monkeypatch):
    monkeypatch.delenv("USDSDG_ASSETS_ROOT")
    monkeypatch.setattr(anchors.root, "assets_root", lambda **_: pytest.fail("made"))
    assert anchors.portable("def Cube {}") == "def Cube {}"


def test_values_are_portable_in_lists_and_mappings(machine):
    values = {"a": [f"{machine}/root/x.png", 1], "b": {"c": Path(f"{machine}/root/y.png")}, "d": None}
    assert anchors.portable_value(values) == {"a": ["<assets>/x.png", 1], "b": {"c": "<assets>/y.png"}, "d": None}


def test_a_portable_path_may_be_in_other_folders_too(machine):
    where = anchors.candidates("<here>/a.usd", ["/data"])
    assert where == [f"{machine}/work/a.usd", "/data/a.usd"]
    assert anchors.candidates("<assets>/a.usdz[0/b.png]", ()) == [f"{machine}/root/a.usdz[0/b.png]"]


def test_a_user_without_a_home_has_no_cache_folder(machine, monkeypatch):
    def no_home():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", no_home)
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert anchors.portable(f"{machine}/root/Isaac/a.usd") == "<assets>/Isaac/a.usd"
    assert anchors.candidates("<cache>/meshes/b.usdc", []) == []
    with pytest.raises(AssetError, match="export XDG_CACHE_HOME"):
        cache_folder()
