from pathlib import Path

import pytest
from pxr import Usd

from usdsdg.errors import AssetError, AssetNotFound, Unsupported
from usdsdg.stage import assets
from usdsdg.stage.assets import root as root_module

MUG = "Isaac/Props/YCB/mug.usd"


@pytest.fixture
def root(tmp_path, monkeypatch):
    """An assets root with a mug and a sky, not configured yet."""
    monkeypatch.delenv(assets.ROOT_VARIABLE, raising=False)
    folder = tmp_path / "assets"
    for name in (MUG, "Isaac/Props/YCB/bottle.usd", "NVIDIA/Assets/Skies/Indoor/lounge.hdr"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("#usda 1.0\n")
    before = root_module._root, root_module._fallback
    assets.set_assets_root(None)
    assets.set_fallback_root(None)
    yield folder
    root_module._root, root_module._fallback = before


@pytest.fixture
def configured(root):
    assets.set_assets_root(root)
    return root


def test_the_root_is_the_one_set_else_the_environments(root, tmp_path, monkeypatch):
    monkeypatch.setenv(assets.ROOT_VARIABLE, str(root))
    assert assets.assets_root() == str(root)
    assets.set_assets_root(tmp_path)
    assert assets.assets_root() == str(tmp_path)
    assets.set_assets_root(None)
    assert assets.assets_root() == str(root)


def test_without_a_root_the_stand_ins_are_used_and_announced(root):
    made, announced = [], []
    assets.set_fallback_root(lambda: made.append(1) or root, lambda: announced.append(1))
    assert not made
    assert assets.assets_root(announce=False) == str(root)
    assert not announced
    assert assets.assets_root() == str(root)
    assert announced
    assert assets.resolve("/" + MUG) == str(root / MUG)


def test_without_any_root_there_is_an_error_that_says_how_to_set_it(root):
    with pytest.raises(AssetNotFound, match=assets.ROOT_VARIABLE):
        assets.assets_root()
    with pytest.raises(AssetNotFound):
        assets.resolve("/" + MUG)


def test_a_root_that_is_no_folder_is_an_error(root, tmp_path):
    assets.set_assets_root(tmp_path / "gone")
    with pytest.raises(AssetNotFound, match="gone is not a folder"):
        assets.assets_root()


@pytest.mark.parametrize(
    "url",
    [
        "/" + MUG,
        MUG,
        "omniverse://localhost/NVIDIA/Assets/Isaac/4.2/" + MUG,
        "https://omniverse-content-production.s3-us-west-2.amazonaws.com/Assets/Isaac/4.2/" + MUG,
        "https://example.com/Isaac/Props/YCB/mug.usd?version=2",
    ],
)
def test_urls_are_looked_up_under_the_root(configured, url):
    assert assets.resolve(url) == str(configured / MUG)


def test_absolute_and_file_urls_are_themselves(configured, tmp_path):
    file = tmp_path / "my scene.usda"
    file.write_text("#usda 1.0\n")
    assert assets.resolve(str(file)) == str(file)
    assert assets.resolve(file) == str(file)
    assert assets.resolve(f"file://{str(file).replace(' ', '%20')}") == str(file)
    assert assets.resolve(str(configured) + "/" + MUG) == str(configured / MUG)


def test_relative_paths_mean_the_working_folder_first(configured, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mug.usd").write_text("#usda 1.0\n")
    assert assets.resolve("mug.usd") == str(tmp_path / "mug.usd")


def test_a_path_with_a_drive_means_the_folder_that_python_finds_too(configured, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AssetError):
        assets.locate("C:/textures/oak.png")
    Path("C:/textures").mkdir(parents=True)
    Path("C:/textures/oak.png").touch()
    assert assets.locate("C:/textures/oak.png") == str(tmp_path / "C:" / "textures" / "oak.png")


def test_what_is_not_on_this_machine_is_none(configured):
    assert assets.locate_or_none(f"/{MUG}") == assets.locate(f"/{MUG}")
    for asset in ("/Isaac/Props/none.usd", "omniverse://server/none.usd", "ftp://server/none.usd", "D:/none.usd", ""):
        with pytest.raises((AssetError, Unsupported)):
            assets.locate(asset)
        assert assets.locate_or_none(asset) is None


def test_a_misspelled_relative_path_is_compared_with_the_working_folder_too(configured, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.usda").touch()
    with pytest.raises(
        AssetNotFound, match=rf"{tmp_path} has no scen\.usda \(did you mean scene\.usda\?\); {configured}"
    ):
        assets.resolve("scen.usda")


def test_a_misspelled_relative_path_does_not_make_the_stand_ins(tmp_path, monkeypatch):
    assets.set_fallback_root(lambda: pytest.fail("stand-ins hold nothing but Isaac and NVIDIA"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.usda").touch()
    with pytest.raises(AssetNotFound, match=rf"{tmp_path} has no scen\.usda \(did you mean scene\.usda\?\)"):
        assets.resolve("scen.usda")


def test_a_file_inside_a_package_needs_its_package(configured, tmp_path):
    (tmp_path / "pack.usdz").write_text("")
    inside = f"{tmp_path}/pack.usdz[textures/a.png]"
    assert assets.resolve(inside) == inside
    with pytest.raises(AssetNotFound):
        assets.resolve(f"{tmp_path}/gone.usdz[textures/a.png]")


def test_a_missing_asset_names_url_root_and_near_misses(configured):
    with pytest.raises(AssetNotFound) as failure:
        assets.resolve("/Isaac/Props/YCB/mugs.usd")
    message = str(failure.value)
    assert "/Isaac/Props/YCB/mugs.usd" in message
    assert str(configured) in message
    assert "did you mean mug.usd" in message
    with pytest.raises(AssetNotFound, match="did you mean Props"):
        assets.resolve("/Isaac/Prop/YCB/mug.usd")
    with pytest.raises(AssetNotFound, match="it has Isaac, NVIDIA"):
        assets.resolve("Qqqqqqqq/x.usd")


def test_a_missing_absolute_path_is_not_sought_elsewhere(configured, tmp_path):
    with pytest.raises(AssetNotFound, match=r"scene\.usd"):
        assets.resolve(str(tmp_path / "scene.usd"))
    (tmp_path / "scenes.usd").touch()
    with pytest.raises(AssetNotFound, match=r"did you mean scenes\.usd"):
        assets.resolve(str(tmp_path / "scene.usd"))
    with pytest.raises(AssetNotFound) as failure:
        assets.resolve("/qqqqqqqq/scene.usd")
    # The root of the disk is no list of assets.
    assert "/ has no qqqqqqqq. Of absolute paths" in str(failure.value)
    with pytest.raises(AssetNotFound, match="empty"):
        assets.resolve("")


def test_remote_files_that_are_not_mirrored_come_with_a_remedy(configured):
    with pytest.raises(AssetError, match=r"Omniverse server.*Copy it under"):
        assets.resolve("omniverse://localhost/Isaac/Props/gone.usd")
    with pytest.raises(Unsupported, match=r"remote.*Copy it under"):
        assets.resolve("https://example.com/scene.usd")


def test_broken_references_are_found_at_the_prims_that_need_them(tmp_path):
    (tmp_path / "damaged.usda").write_text("#usda 1.0\ndef Xform {")
    (tmp_path / "empty.usda").write_text("#usda 1.0\n")
    (tmp_path / "asset.usda").write_text(
        """#usda 1.0
        ( defaultPrim = "A" )
        def Xform "A" {
            def "gone" (references = @./gone.usd@) {}
            def "damaged" (payload = @./damaged.usda@) {}
            def "empty" (references = @./empty.usda@</Nothing>) {}
            def "unused" (
                active = false
                references = @./gone_too.usda@
            ) {}
        }"""
    )
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/World/a").GetReferences().AddReference(str(tmp_path / "asset.usda"))
    stage.GetRootLayer().subLayerPaths.append(str(tmp_path / "layer.usda"))

    found = {missing.where: missing for missing in assets.missing_dependencies(stage)}
    layer = stage.GetRootLayer().identifier
    assert set(found) == {"/World/a/gone", "/World/a/damaged", "/World/a/empty", layer}
    assert found["/World/a/gone"].asset_path == str(tmp_path / "gone.usd")
    assert found["/World/a/damaged"].asset_path == str(tmp_path / "damaged.usda")
    assert "damaged.usda:2" in found["/World/a/damaged"].why
    assert found["/World/a/empty"].asset_path == f"{tmp_path}/empty.usda</Nothing>"
    assert found[layer].asset_path == str(tmp_path / "layer.usda")


def test_a_valid_stage_has_no_missing_dependencies(configured):
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/World/a").GetReferences().AddReference(str(configured / MUG), "/x")
    # The reference resolves; that its prim does not exist is the one thing to report.
    assert [missing.where for missing in assets.missing_dependencies(stage)] == ["/World/a"]
    stage.GetPrimAtPath("/World/a").GetReferences().ClearReferences()
    assert assets.missing_dependencies(stage) == []
