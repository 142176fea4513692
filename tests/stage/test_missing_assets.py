"""What becomes of missing assets, and where maps find those of other machines."""

from pathlib import Path

import click
import pytest
from pxr import Sdf, Usd, UsdGeom

from usdsdg.errors import AssetError, AssetNotFound, ConfigError, UsdsdgWarning, forget_warnings, outside_line
from usdsdg.stage import assets
from usdsdg.stage.semantics.labels import get_labels
from usdsdg.utils import get_usd_files


@pytest.fixture(autouse=True)
def _alone(tmp_path, monkeypatch):
    """No assets root, a cache of its own, and nothing of the maps and choices of a test outlives it."""
    monkeypatch.delenv(assets.ROOT_VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("usdsdg.stage.assets.root._root", str(tmp_path))
    forget_warnings()
    yield
    assets.set_maps(())
    assets.set_on_missing(assets.OnMissing.RAISE)
    assets.set_units(lambda: 1.0)


def on_disk(folder, name: str) -> str:
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text('#usda 1.0\n( defaultPrim = "A" )\ndef Cube "A" {}\n')
    return str(folder / name)


def test_no_script_line_is_told_where_a_command_opens_a_stage():
    assert click.Context(click.Command("run")).invoke(outside_line) == ""
    assert outside_line().startswith("test_missing_assets.py:")


def test_references_that_were_written_on_windows_open(tmp_path):
    on_disk(tmp_path, "parts/a.usda")
    scene = tmp_path / "scene.usda"
    scene.write_text(
        '#usda 1.0\ndef "P" ( references = @.\\parts\\a.usda@ ) {}\ndef "Q" ( payload = @parts\\a.usda@ ) {}\n'
    )
    stage = Usd.Stage.Open(str(scene))
    assets.check_missing(stage)
    assert [stage.GetPrimAtPath(path).GetTypeName() for path in ("/P", "/Q")] == ["Cube", "Cube"]


def test_a_file_that_does_not_open_is_named_once_however_many_refer_to_it(tmp_path, recwarn):
    prims = "".join(f'def "P{k}" ( references = @./gone.usd@ ) {{}}\n' for k in range(3))
    (tmp_path / "scene.usda").write_text(f"#usda 1.0\n{prims}")
    assets.check_missing(Usd.Stage.Open(str(tmp_path / "scene.usda")))
    [told] = [str(each.message) for each in recwarn if "cannot be opened" in str(each.message)]
    assert told.startswith(f"/P0 and 2 others refer to {tmp_path / 'gone.usd'}, which cannot be opened: ")


def test_what_lets_usd_read_material_x_is_told(tmp_path):
    (tmp_path / "wood.mtlx").write_text('<?xml version="1.0"?>\n<materialx version="1.38"/>\n')
    scene = tmp_path / "scene.usda"
    scene.write_text('#usda 1.0\ndef "Looks" ( references = @./wood.mtlx@</MaterialX/Materials> ) {}\n')
    with pytest.warns(UsdsdgWarning, match=r"/Looks refers to .*wood.mtlx.*, which .* plugin .* usdcat --flatten"):
        assets.check_missing(Usd.Stage.Open(str(scene)))


@pytest.mark.parametrize(
    ("prefix", "url"),
    [
        ("omniverse://localhost/Projects", "omniverse://localhost/Projects/a b.usd"),
        ("omniverse://localhost/Projects/", "OMNIVERSE://LocalHost/Projects/a%20b.usd"),
        ("omniverse://localhost/Projects", "omniverse:/localhost/Projects/a b.usd"),
        ("https://host/assets", "https://host/assets/a%20b.usd?version=3"),
        ("s3://bucket", "s3://bucket/a b.usd"),
        ("C:/assets", "C:\\assets\\a b.usd"),
        ("c:\\assets", "C:/assets/a b.usd"),
        ("C:", "C:\\a b.usd"),
        ("d:", "D:/a b.usd"),
        ("/home/someone/assets", "/home/someone/assets/a b.usd"),
        ("~/no_such_folder", "~/no_such_folder/a b.usd"),
    ],
)
def test_a_map_finds_what_is_below_its_prefix(tmp_path, prefix, url):
    file = on_disk(tmp_path / "mine", "a b.usd")
    assets.set_maps([assets.PathMap.parse(f"{prefix}={tmp_path / 'mine'}")])
    assert assets.resolve(url) == file


def test_a_prefix_ends_at_a_folder(tmp_path):
    on_disk(tmp_path / "mine", "a.usd")
    assets.set_maps([assets.PathMap.parse(f"omniverse://host/Pro={tmp_path / 'mine'}")])
    with pytest.raises(AssetError, match="omniverse"):
        assets.resolve("omniverse://host/Projects/a.usd")


def test_the_longest_prefix_comes_first_and_shorter_ones_follow(tmp_path):
    short, long = on_disk(tmp_path / "short", "b/a.usd"), on_disk(tmp_path / "long", "a.usd")
    only_short = on_disk(tmp_path / "short", "b/c.usd")
    assets.set_maps(
        [assets.PathMap("s3://x", str(tmp_path / "short")), assets.PathMap("s3://x/b", str(tmp_path / "long"))]
    )
    assert assets.resolve("s3://x/b/a.usd") == long != short
    assert assets.resolve("s3://x/b/c.usd") == only_short


@pytest.mark.parametrize("text", ["omniverse://host", "=folder", "a=", "a=/no/such/folder"])
def test_a_map_that_cannot_work_is_an_error(text):
    with pytest.raises(ConfigError):
        assets.PathMap.parse(text)


def test_missing_assets_are_listed_together_with_where_they_were_looked_for(tmp_path):
    assets.set_maps([assets.PathMap("s3://x", str(tmp_path))])
    assets.set_on_missing(assets.OnMissing.ERROR)
    stage = Usd.Stage.CreateInMemory()
    for name, url in (("one", "s3://x/gone.usd"), ("two", "omniverse://host/gone.usd")):
        stage.DefinePrim(f"/{name}").GetReferences().AddReference(assets.resolve(url))
    # As a layer brings it, not as a script adds it.
    Sdf.CreatePrimInLayer(stage.GetRootLayer(), "/three").referenceList.Prepend(Sdf.Reference("/no/such/file.usd"))
    assert all(prim.IsValid() and not prim.GetChildren() for prim in stage.Traverse())
    with pytest.raises(assets.MissingAssets) as failure:
        assets.check_missing(stage)
    message = str(failure.value)
    assert message.startswith("3 assets are missing:")
    assert f"s3://x/gone.usd (test_missing_assets.py:{_line_of('AddReference(assets.resolve')})" in message
    assert f"{tmp_path} has no gone.usd" in message
    assert "omniverse://host/gone.usd" in message
    assert "/three refers to it" in message
    assert "--map PREFIX=FOLDER" in message


def _line_of(text: str) -> int:
    lines = Path(__file__).read_text(encoding="utf-8").splitlines()
    return next(number for number, line in enumerate(lines, start=1) if text in line)


def test_what_a_found_asset_refers_to_in_vain_is_a_warning(tmp_path):
    assets.set_on_missing(assets.OnMissing.ERROR)
    (tmp_path / "a.usda").write_text(
        '#usda 1.0\n( defaultPrim = "A" )\ndef "A" {\ndef "B" ( references = @./gone.usd@ ) {}\n}'
    )
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/a").GetReferences().AddReference(str(tmp_path / "a.usda"))
    with pytest.warns(UsdsdgWarning, match=r"/a/B refers to .*gone\.usd"):
        assets.check_missing(stage)


@pytest.mark.parametrize("name", ["pointer.usd", "pointer.usda"])
def test_references_to_pointers_of_git_lfs_are_told_as_such(tmp_path, name):
    assets.set_on_missing(assets.OnMissing.SKIP)
    (tmp_path / name).write_text("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 17497\n")
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/a").GetReferences().AddReference(str(tmp_path / name))
    with pytest.warns(UsdsdgWarning, match=f"/a refers to .*{name}, which cannot be opened: it only points to a"):
        assets.check_missing(stage)


@pytest.mark.parametrize("units", [1.0, 0.01])
def test_a_stand_in_is_a_labeled_box_of_half_a_meter_with_a_material(units):
    assets.set_on_missing(assets.OnMissing.STAND_IN)
    assets.set_units(lambda: units)
    with pytest.warns(UsdsdgWarning, match=r"a stand-in replaces s3://x/3-cup\.usd"):
        file = assets.resolve("s3://x/3-cup.usd")
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, units)
    prim = stage.DefinePrim("/a")
    prim.GetReferences().AddReference(file)
    assert {kind: list(labels) for kind, labels in get_labels(prim).items()} == {"class": ["3-cup"]}
    box = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"]).ComputeWorldBound(prim).ComputeAlignedRange()
    assert tuple(box.GetSize()) == pytest.approx([0.5 / units] * 3)
    assert stage.GetPrimAtPath("/a/Plain/Shader")
    assets.check_missing(stage)
    # Outward faces: the signed volume by the divergence theorem is that of the box.
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/a/Box"))
    points, indices = mesh.GetPointsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
    corners = [[points[i] for i in indices[4 * face : 4 * face + 4]] for face in range(6)]
    volume = sum(a * (b ^ c) + a * (c ^ d) for a, b, c, d in corners) / 6
    assert volume == pytest.approx((0.5 / units) ** 3)


def test_skipped_assets_are_empty_prims_with_one_warning(recwarn):
    assets.set_on_missing(assets.OnMissing.SKIP)
    stage = Usd.Stage.CreateInMemory()
    for name in ("a", "b"):
        stage.DefinePrim(f"/{name}").GetReferences().AddReference(assets.resolve("s3://x/gone.usd"))
    assets.check_missing(stage)
    assert len([each for each in recwarn if "is left out" in str(each.message)]) == 1
    assert [str(prim.GetPath()) for prim in stage.Traverse()] == ["/a", "/b"]


def test_a_missing_picture_is_gray_and_a_missing_folder_an_error():
    from usdsdg_render.images.image_files import read

    assets.set_on_missing(assets.OnMissing.SKIP)
    with pytest.warns(UsdsdgWarning):
        image = read(assets.resolve("s3://x/sky.hdr"))
    assert image.texels.shape == (2, 2, 4)
    assert (image.texels[..., :3] == 128).all()
    with pytest.raises(AssetNotFound):
        assets.resolve("/Isaac/Props/Gone")


@pytest.mark.parametrize("folder", ["omniverse://host/Parts/Gears/", "/Isaac/Props/Gears", "C:\\parts\\Gears"])
def test_one_labeled_box_stands_in_for_the_files_of_a_missing_folder(folder):
    assets.set_on_missing(assets.OnMissing.STAND_IN)
    with pytest.warns(UsdsdgWarning, match=r"a stand-in replaces .*Gears.*, which is missing"):
        (file,) = get_usd_files(folder, recursive=True, path_filter="small_.*")
    stage = Usd.Stage.Open(file)
    assert {kind: list(labels) for kind, labels in get_labels(stage.GetDefaultPrim()).items()} == {"class": ["Gears"]}
    assets.raise_missing()


def test_a_folder_that_is_left_out_has_one_empty_asset():
    assets.set_on_missing(assets.OnMissing.SKIP)
    with pytest.warns(UsdsdgWarning, match="Gears is left out"):
        (file,) = get_usd_files("omniverse://host/Parts/Gears")
    stage = Usd.Stage.Open(file)
    assert [str(prim.GetPath()) for prim in stage.Traverse()] == ["/Gears"]


def test_a_missing_folder_is_listed_where_missing_assets_are_errors():
    assets.set_on_missing(assets.OnMissing.ERROR)
    with pytest.raises(AssetError, match="Omniverse server"):
        get_usd_files("omniverse://host/Parts/Gears")
    with pytest.raises(assets.MissingAssets, match="omniverse://host/Parts/Gears"):
        assets.raise_missing()


def test_a_missing_material_is_a_plain_one():
    assets.set_on_missing(assets.OnMissing.SKIP)
    with pytest.warns(UsdsdgWarning, match="Wood"):
        file = assets.resolve("s3://x/Wood-1.mdl")
    assert file.endswith("/Wood_1.mdl")
    assert "export material Wood_1(*) = OmniPBR();" in Path(file).read_text()


def test_layers_of_a_stage_are_pointed_to_the_mapped_files(tmp_path):
    on_disk(tmp_path / "mine", "cube.usda")
    (tmp_path / "mine" / "room.usda").write_text(
        '#usda 1.0\n( defaultPrim = "R" )\ndef "R" {\ndef "C" ( references = @omniverse://host/P/cube.usda@ ) {}\n}'
    )
    scene = tmp_path / "scene.usda"
    scene.write_text('#usda 1.0\ndef "S" ( payload = @omniverse://host/P/room.usda@ ) {}')
    before = scene.read_text()
    assets.set_maps([assets.PathMap("omniverse://host/P", str(tmp_path / "mine"))])
    stage = Usd.Stage.Open(str(scene))
    assert not stage.GetPrimAtPath("/S/C")
    assets.redirect(stage)
    assert stage.GetPrimAtPath("/S/C").GetTypeName() == "Cube"
    assert scene.read_text() == before


def test_references_that_come_back_to_themselves_are_named_once(tmp_path, recwarn):
    (tmp_path / "c.usda").write_text('#usda 1.0\n( defaultPrim = "A" )\ndef "A" ( payload = @d.usda@</A> ) {}')
    (tmp_path / "d.usda").write_text('#usda 1.0\ndef "A" ( references = @c.usda@ ) {}')
    (tmp_path / "s.usda").write_text("#usda 1.0\n( subLayers = [@scene.usda@] )")
    (tmp_path / "scene.usda").write_text(
        '#usda 1.0\n( subLayers = [@s.usda@] )\ndef "W" {\ndef "B" ( references = </W/C> ) {}\n'
        'def "C" ( references = </W/B> ) {}\n}\ndef "F" ( references = @c.usda@ ) {}'
    )
    assets.check_missing(Usd.Stage.Open(str(tmp_path / "scene.usda")))
    texts = sorted(str(each.message) for each in recwarn if each.category is UsdsdgWarning)
    assert len(texts) == 3
    assert all("\n" not in text and text.endswith("Remove one of them.") for text in texts)
    file, within = sorted(text for text in texts if "refers to comes back" in text)
    assert file.startswith("/F: ")
    assert "c.usda</A> -> " in file
    assert within.startswith("/W/B: what it refers to comes back to itself (/W/B -> /W/C -> /W/B)")
    [layers] = set(texts) - {file, within}
    assert {"s.usda", "scene.usda"} == {Path(name).name for name in layers.partition(" are ")[0].split(" and ")}


def test_selected_variants_that_do_not_exist_are_named(recwarn):
    stage = Usd.Stage.CreateInMemory()
    for name, selected in (("Wrong", "gren"), ("Right", "green"), ("None", "")):
        colors = stage.DefinePrim(f"/{name}").GetVariantSets().AddVariantSet("color")
        colors.AddVariant("red")
        colors.AddVariant("green")
        colors.SetVariantSelection(selected)
    assets.check_missing(stage)
    [text] = [str(each.message) for each in recwarn if each.category is UsdsdgWarning]
    assert text.startswith(
        "/Wrong: its variant set color has no variant 'gren', so nothing of the set is there. Select"
    )


def test_variants_selected_after_a_check_are_looked_at_again(recwarn):
    stage = Usd.Stage.CreateInMemory()
    colors = stage.DefinePrim("/Chair").GetVariantSets().AddVariantSet("color")
    colors.AddVariant("red")
    colors.SetVariantSelection("red")
    assets.check_missing(stage)
    for selected in ("blue", "red", "grey"):
        colors.SetVariantSelection(selected)
        assets.check_missing(stage)
    texts = [str(each.message) for each in recwarn if each.category is UsdsdgWarning]
    assert [text.split("'")[1] for text in texts] == ["blue", "grey"]
