"""`isaacsim.storage.native`: paths, files below folders, and what USD files refer to."""

import asyncio
import os

import pytest
from pxr import Sdf, Usd, UsdGeom

from usdsdg.compat.isaacsim.storage import native


@pytest.fixture
def folder(tmp_path):
    """Return a folder with scene.usda, which references robots/arm/arm.usda with a texture, and one that is missing."""
    (tmp_path / "robots" / "arm").mkdir(parents=True)
    arm = Usd.Stage.CreateNew(str(tmp_path / "robots/arm/arm.usda"))
    prim = UsdGeom.Xform.Define(arm, "/Arm").GetPrim()
    prim.CreateAttribute("look", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath("./skin.png"))
    arm.SetDefaultPrim(prim)
    arm.Save()
    scene = Usd.Stage.CreateNew(str(tmp_path / "scene.usda"))
    scene.DefinePrim("/World/arm").GetReferences().AddReference("./robots/arm/arm.usda")
    scene.DefinePrim("/World/gone").GetReferences().AddReference("./gone.usda")
    scene.Save()
    for name in ("notes.txt", "robots/arm/skin.png", "robots/spare.usd"):
        (tmp_path / name).touch()
    (tmp_path / "robots/.thumbs").mkdir()
    (tmp_path / "robots/.thumbs/arm.usd").touch()
    return tmp_path


def names(paths, folder):
    return {os.path.relpath(path, folder).replace(os.sep, "/") for path in paths}


def found(folder, **options):
    return names(asyncio.run(native.find_filtered_files_async(str(folder), **options)), folder)


def test_usd_files_are_found_by_depth_and_pattern(folder):
    every = {"scene.usda", "robots/spare.usd", "robots/arm/arm.usda", "robots/.thumbs/arm.usd"}
    assert found(folder) == every
    assert found(folder, max_depth=0) == {"scene.usda"}
    assert found(folder, max_depth=1) == {"scene.usda", "robots/spare.usd"}
    assert found(folder, filepath_excludes=[".thumbs"]) == every - {"robots/.thumbs/arm.usd"}
    assert found(folder, filter_patterns=["spare", r"arm\.usda$"]) == {"robots/spare.usd", "robots/arm/arm.usda"}
    assert found(folder, filter_patterns=["arm", r"usda$"], match_all=True) == {"robots/arm/arm.usda"}


def test_a_pattern_or_a_folder_that_is_wrong_is_named(folder):
    with pytest.warns(UserWarning, match=r"'\[arm' is no regular expression"):
        assert found(folder, filter_patterns=["[arm"]) == set()
    with pytest.warns(UserWarning, match="neither a file nor a folder at .*nowhere"):
        assert found(folder / "nowhere") == set()


def test_files_of_any_kind_are_found_by_name(folder):
    pictures = native.find_files_recursive([str(folder)], lambda name: name.endswith(".png"))
    assert names(pictures, folder) == {"robots/arm/skin.png"}
    assert len(native.find_files_recursive([str(folder)])) == 6


def test_references_are_those_that_are_written(folder):
    scene = str(folder / "scene.usda")
    before = (folder / "scene.usda").read_bytes(), (folder / "robots/arm/arm.usda").read_bytes()
    assert native.get_stage_references(scene) == ["./gone.usda", "./robots/arm/arm.usda", "./skin.png"]
    layers = native.get_stage_references(scene, resolve_relatives=False)
    assert names(layers, folder) == {"scene.usda", "robots/arm/arm.usda"}
    assert not Sdf.Layer.FindOrOpen(scene).dirty
    assert before == ((folder / "scene.usda").read_bytes(), (folder / "robots/arm/arm.usda").read_bytes())


def test_missing_references_are_found_through_layers(folder):
    stage = Usd.Stage.Open(str(folder / "robots/arm/arm.usda"))
    prim = stage.DefinePrim("/Near")
    prim.GetReferences().AddReference("./arm.usda")
    assert not native.prim_has_missing_references(prim)
    prim.GetReferences().AddReference("../../scene.usda")  # which references one that is missing
    assert native.prim_has_missing_references(prim)


def test_references_of_a_folder_are_told_by_file(folder):
    inside = folder / "robots/arm"
    arm = Usd.Stage.Open(str(inside / "arm.usda"))
    arm.DefinePrim("/Arm/spare").GetReferences().AddReference(str(folder / "notes.usda"))
    Usd.Stage.CreateNew(str(folder / "notes.usda")).Save()
    arm.Save()
    file, outside = str(inside / "arm.usda"), str(folder / "notes.usda")
    assert asyncio.run(native.find_external_references(str(inside))) == {file: [outside]}
    assert asyncio.run(native.find_absolute_paths_in_usds(str(inside))) == {file: [outside]}
    (folder / "robots/spare.usd").unlink()
    (folder / "robots/.thumbs/arm.usd").unlink()
    counts = asyncio.run(native.count_asset_references(str(folder)))
    assert {os.path.relpath(path, folder): count for path, count in counts.items()} == {
        "scene.usda": 1, os.path.join("robots", "arm", "arm.usda"): 2, "notes.usda": 3, "notes.txt": 0,
        os.path.join("robots", "arm", "skin.png"): 2,
    }  # fmt: skip


def test_assets_are_resolved_below_the_root(folder, monkeypatch):
    monkeypatch.setenv("USDSDG_ASSETS_ROOT", str(folder))
    assert native.resolve_asset_path("/robots/spare.usd") == f"{folder}/robots/spare.usd"
    assert native.resolve_asset_path(str(folder / "scene.usda")) == str(folder / "scene.usda")
    assert native.resolve_asset_path("/robots/none.usd") is None
    assert asyncio.run(native.path_exists(str(folder)))
    assert not asyncio.run(native.path_exists("/robots/none.usd"))


@pytest.mark.parametrize("server", ["omniverse://server", "https://server", "file://server"])
def test_urls_are_joined_and_parted(server):
    assert native.path_join(f"{server}/a/b/", "./c.usd") == f"{server}/a/b/c.usd"
    assert native.path_join(f"{server}/a/b", "../../c\\d.usd") == f"{server}/c/d.usd"
    assert native.path_dirname(f"{server}/a/c.usd") == f"{server}/a/"
    assert native.path_relative(f"{server}/a/b/c.usd", f"{server}/a/d/") == "../b/c.usd"
    assert native.is_absolute_path(server)
    assert not native.is_local_path(server)
    with pytest.raises(ValueError, match="not on the same server"):
        native.path_relative(f"{server}/a", "omniverse://other/a")


def test_local_paths_are_those_of_the_system(tmp_path):
    assert native.path_join(str(tmp_path), "a.usd") == str(tmp_path / "a.usd")
    assert native.path_dirname(str(tmp_path / "a.usd")) == f"{tmp_path}{os.sep}"
    assert native.path_relative(str(tmp_path / "b" / "a.usd"), str(tmp_path)) == os.path.join("b", "a.usd")
    assert native.is_absolute_path(str(tmp_path))
    assert native.is_local_path("")
    assert not native.is_absolute_path("a")
    assert native.is_mdl_file("a.mdl")
    assert native.is_valid_usd_file("a.usdz", [])
    assert not native.is_mdl_file("a.usd")
