import gc
import math
import os
import zipfile

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdUtils

import usdsdg as rep
from usdsdg.errors import (
    AssetNotFound,
    AssetUnreadable,
    BadValue,
    OutputNotWritable,
    StageError,
    Unsupported,
    UsdsdgWarning,
)
from usdsdg.session import stage_context
from usdsdg.session.render_products import HydraTexture, products
from usdsdg.stage.assets import anchors
from usdsdg.stage.schemas import physx

POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 17497\n"

pytestmark = pytest.mark.usefixtures("stage")


def test_a_new_stage_has_the_units_and_axis_of_isaac_sim():
    stage = stage_context.new_stage()
    assert stage_context.current_stage() == stage
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetTimeCodesPerSecond() == 60.0
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert stage.GetDefaultPrim().GetTypeName() == "Xform"


def test_only_the_current_stage_is_found_by_id():
    stage = stage_context.current_stage()
    identifier = stage_context.stage_id()
    assert stage_context.stage_by_id(identifier) == stage
    assert stage_context.stage_id() == identifier
    assert UsdUtils.StageCache.Get().Find(Usd.StageCache.Id.FromLongInt(identifier)) == stage
    stage_context.new_stage()
    assert stage_context.stage_id() != identifier
    with pytest.raises(StageError, match=str(identifier)):
        stage_context.stage_by_id(identifier)


def test_listeners_are_called_for_each_new_stage_until_they_unsubscribe(tmp_path):
    heard = []
    unsubscribe = stage_context.on_new_stage(heard.append)
    stage = stage_context.new_stage()
    stage_context.set_stage(stage)
    stage.GetRootLayer().Export(str(tmp_path / "a.usda"))
    opened = stage_context.open_stage(tmp_path / "a.usda")
    assert heard == [stage, opened]
    unsubscribe()
    unsubscribe()
    stage_context.new_stage()
    assert len(heard) == 2


def test_open_reads_the_file_again_and_drops_unsaved_edits(tmp_path):
    stage_context.current_stage().GetRootLayer().Export(str(tmp_path / "a.usda"))
    first = stage_context.open_stage(str(tmp_path / "a.usda"))
    first.DefinePrim("/World/edit")
    second = stage_context.open_stage(str(tmp_path / "a.usda"))
    assert second.GetDefaultPrim()
    assert not second.GetPrimAtPath("/World/edit")


def test_opening_a_missing_file_is_an_error():
    before = stage_context.current_stage()
    with pytest.raises(AssetNotFound, match=r"nothing\.usd"):
        stage_context.open_stage("/nowhere/nothing.usd")
    assert stage_context.current_stage() == before


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("a.usda", b"#usda 1.0\ndef Xform {", "a.usda:2"),
        ("a.usdc", b"PXR-USDC", "a.usdc"),
        ("a.png", b"x", "a.png"),
        ("a.usd", b"", "a.usd cannot be opened as a stage: it is empty$"),
        ("a.usd", b"PXR-USDC", "a.usd cannot be opened as a stage: it is cut off$"),
        (
            "a.usd",
            b"hello",
            "a.usd cannot be opened as a stage: it is no USD file, which begins with #usda or PXR-USDC$",
        ),
        ("a.usd", POINTER, "a.usd cannot be opened as a stage: it only points to a file in Git LFS; .*pull$"),
        (
            "a.usda",
            POINTER,
            "a.usda cannot be opened as a stage: it only points to a file in Git LFS; .*pull$",
        ),
        ("a.usdz", b"PK", "a.usdz is damaged: File is not a zip file"),
    ],
)
def test_opening_a_damaged_file_reports_the_reason_of_usd(tmp_path, name, content, why):
    (tmp_path / name).write_bytes(content)
    before = stage_context.current_stage()
    with pytest.raises(AssetUnreadable, match=why):
        stage_context.open_stage(tmp_path / name)
    assert stage_context.current_stage() == before


@pytest.mark.parametrize(
    ("files", "why"),
    [
        ([], "it is a package without files$"),
        (["a.txt", "b.usda"], "it is a package of which the first file, a.txt, is no USD file$"),
        (["b.usd"], "b.usd in it is no layer: it is no USD file, which begins with #usda or PXR-USDC$"),
    ],
)
def test_a_whole_package_without_a_layer_is_told_as_such(tmp_path, files, why):
    with zipfile.ZipFile(tmp_path / "a.usdz", "w") as package:
        for name in files:
            package.writestr(name, "hello")
    with pytest.raises(AssetUnreadable, match=f"a.usdz cannot be opened as a stage: {why}"):
        stage_context.open_stage(tmp_path / "a.usdz")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("timeCodesPerSecond", 0.0),
        ("timeCodesPerSecond", -24.0),
        ("timeCodesPerSecond", math.nan),
        ("startTimeCode", math.nan),
        ("endTimeCode", math.inf),
    ],
)
def test_a_stage_with_invalid_time_codes_is_an_error(tmp_path, name, value):
    stage = Usd.Stage.CreateNew(str(tmp_path / "a.usda"))
    stage.SetMetadata(name, value)
    stage.Save()
    before = stage_context.current_stage()
    with pytest.raises(BadValue, match=f"a.usda: .*{name}.* Author"):
        stage_context.open_stage(tmp_path / "a.usda")
    assert stage_context.current_stage() == before


def test_opening_a_folder_is_an_error(tmp_path):
    (tmp_path / "a.usd").mkdir()
    with pytest.raises(AssetUnreadable, match=r"a\.usd cannot be opened as a stage: it is a folder"):
        stage_context.open_stage(tmp_path / "a.usd")


@pytest.mark.parametrize("extension", [".usd", ".usda", ".usdc"])
def test_save_and_open_give_the_same_stage(tmp_path, extension):
    stage = stage_context.current_stage()
    cube = UsdGeom.Cube.Define(stage, "/World/cube")
    cube.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    physx.PhysxRigidBodyAPI.Apply(cube.GetPrim()).CreateAngularDampingAttr(0.5)
    path = stage_context.save_stage(tmp_path / f"saved{extension}")
    assert path == tmp_path / f"saved{extension}"
    opened = stage_context.open_stage(path)
    assert UsdGeom.GetStageUpAxis(opened) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(opened) == 1.0
    assert opened.GetTimeCodesPerSecond() == 60.0
    assert opened.GetDefaultPrim().GetPath() == "/World"
    again = opened.GetPrimAtPath("/World/cube")
    assert again.GetAttribute("xformOp:translate").Get() == Gf.Vec3d(1, 2, 3)
    assert again.GetAppliedSchemas() == ["PhysxRigidBodyAPI"]
    assert os.listdir(tmp_path) == [path.name]


def test_session_and_sublayers_are_merged_strongest_first(tmp_path):
    stage = stage_context.current_stage()
    below = Sdf.Layer.CreateNew(str(tmp_path / "below.usda"))
    stage.GetRootLayer().subLayerPaths.append(below.identifier)
    with Usd.EditContext(stage, below):
        UsdGeom.Cube.Define(stage, "/World/cube").GetSizeAttr().Set(1.0)
        UsdGeom.Sphere.Define(stage, "/World/ball").GetRadiusAttr().Set(4.0)
    stage.GetPrimAtPath("/World/cube").GetAttribute("size").Set(2.0)
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        stage.GetPrimAtPath("/World/cube").GetAttribute("size").Set(3.0)
        stage.DefinePrim("/Render/Product", "RenderProduct")
    layer = Sdf.Layer.FindOrOpen(str(stage_context.save_stage(tmp_path / "saved.usda")))
    assert not layer.subLayerPaths
    saved = Usd.Stage.Open(layer)
    assert saved.GetAttributeAtPath("/World/cube.size").Get() == 3.0
    assert saved.GetAttributeAtPath("/World/ball.radius").Get() == 4.0
    assert saved.GetPrimAtPath("/Render/Product").GetTypeName() == "RenderProduct"
    assert saved.GetPrimAtPath("/World").GetTypeName() == "Xform"


def test_references_still_resolve_from_the_new_location(tmp_path):
    assets_folder, out = tmp_path / "assets", tmp_path / "out"
    assets_folder.mkdir()
    asset = Usd.Stage.CreateNew(str(assets_folder / "mug.usda"))
    asset.SetDefaultPrim(UsdGeom.Cube.Define(asset, "/Mug").GetPrim())
    asset.Save()
    (assets_folder / "wood.png").write_bytes(b"x")
    scene = Sdf.Layer.CreateNew(str(assets_folder / "scene.usda"))
    scene.Save()

    stage = stage_context.open_stage(assets_folder / "scene.usda")
    for name, path in {
        "relative": "./mug.usda",
        "search": "mug.usda",
        "absolute": str(assets_folder / "mug.usda"),
    }.items():
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(path)
    texture = stage.GetPrimAtPath("/World/relative").CreateAttribute("texture", Sdf.ValueTypeNames.Asset)
    texture.Set("./wood.png")
    mdl = stage.GetPrimAtPath("/World/relative").CreateAttribute("mdl", Sdf.ValueTypeNames.Asset)
    mdl.Set("OmniPBR.mdl")
    udim = stage.GetPrimAtPath("/World/relative").CreateAttribute("udim", Sdf.ValueTypeNames.Asset)
    udim.Set("./skin.<UDIM>.png")

    saved = Usd.Stage.Open(str(stage_context.save_stage(out / "deep" / "scene.usda")))
    for name in ("relative", "search", "absolute"):
        assert saved.GetPrimAtPath(f"/World/{name}").GetTypeName() == "Cube"
    prim = saved.GetPrimAtPath("/World/relative")
    assert prim.GetAttribute("texture").Get().resolvedPath == str(assets_folder / "wood.png")
    assert prim.GetAttribute("mdl").Get().path == "OmniPBR.mdl"
    assert prim.GetAttribute("udim").Get().path == str(assets_folder / "skin.<UDIM>.png")


def test_paths_beside_the_saved_file_stay_relative_so_that_the_folder_can_move(tmp_path):
    folder = tmp_path / "project"
    (folder / "props").mkdir(parents=True)
    asset = Usd.Stage.CreateNew(str(folder / "props" / "mug.usda"))
    asset.SetDefaultPrim(UsdGeom.Cube.Define(asset, "/Mug").GetPrim())
    asset.Save()
    Sdf.Layer.CreateNew(str(folder / "props" / "scene.usda")).Save()
    stage = stage_context.open_stage(folder / "props" / "scene.usda")
    stage.DefinePrim("/World/mug").GetReferences().AddReference("./mug.usda")
    stage_context.save_stage(folder / "saved.usda")
    folder.rename(tmp_path / "moved")
    moved = Usd.Stage.Open(str(tmp_path / "moved" / "saved.usda"))
    assert moved.GetPrimAtPath("/World/mug").GetTypeName() == "Cube"


def test_references_to_layers_in_memory_are_warned_about(tmp_path):
    layer = Sdf.Layer.CreateAnonymous()
    stage_context.current_stage().DefinePrim("/World/a").GetReferences().AddReference(layer.identifier, "/x")
    with pytest.warns(UsdsdgWarning, match="in memory only"):
        stage_context.save_stage(tmp_path / "saved.usda")


def test_the_opened_file_can_be_overwritten(tmp_path):
    stage_context.current_stage().GetRootLayer().Export(str(tmp_path / "a.usdc"))
    stage = stage_context.open_stage(tmp_path / "a.usdc")
    stage.DefinePrim("/World/new")
    stage_context.save_stage(tmp_path / "a.usdc")
    assert stage_context.open_stage(tmp_path / "a.usdc").GetPrimAtPath("/World/new")


def test_saving_to_a_folder_that_cannot_be_written_is_an_error(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(OutputNotWritable, match=r"saved\.usda: (File exists|Not a directory)\."):
        stage_context.save_stage(tmp_path / "file" / "saved.usda")
    (tmp_path / "folder.usda").mkdir()
    with pytest.raises(OutputNotWritable, match=r"folder\.usda: a folder of that name is in the way"):
        stage_context.save_stage(tmp_path / "folder.usda")
    assert sorted(os.listdir(tmp_path)) == ["file", "folder.usda"]


@pytest.mark.parametrize("name", ["scene.obj", "scene", "scene.usdz"])
def test_saving_with_another_extension_is_an_error(tmp_path, name):
    with pytest.raises(Unsupported, match=r"\.usd, \.usda, \.usdc"):
        stage_context.save_stage(tmp_path / name)
    assert os.listdir(tmp_path) == []


def test_a_file_that_has_changed_is_read_again(tmp_path):
    part, whole = tmp_path / "part.usda", tmp_path / "whole.usda"
    for name in ("One", "Two"):
        part.write_text(
            f'#usda 1.0\n(\n    defaultPrim = "{name}"\n)\ndef Xform "{name}" {{\n    def Cube "{name}" {{}}\n}}\n'
        )
        whole.write_text(f'#usda 1.0\ndef Xform "{name}" (references = @./part.usda@) {{\n}}\n')
        stage = stage_context.open_stage(whole)
        assert [str(prim.GetPath()) for prim in stage.Traverse()] == [f"/{name}", f"/{name}/{name}"]


def test_an_asset_that_was_written_again_is_read_again_on_the_next_stage(tmp_path):
    file = tmp_path / "part.usda"
    for number, kind in enumerate(("Cube", "Sphere")):
        file.write_text(f'#usda 1.0\n(\n    defaultPrim = "P"\n)\ndef {kind} "P" {{}}\n')
        os.utime(file, (number, number))
        assert rep.functional.create.reference(usd_path=str(file)).GetTypeName() == kind
        stage_context.new_stage()


def test_a_folder_that_files_were_named_from_is_forgotten_with_the_stage_once_it_was_left(tmp_path, monkeypatch):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "part.usda").write_text('#usda 1.0\n(\n    defaultPrim = "P"\n)\ndef Cube "P" {}\n')
    named = {name: f"@{tmp_path / name / 'part.usda'}@" for name in ("one", "two")}
    monkeypatch.chdir(tmp_path / "one")
    rep.functional.create.reference(usd_path="part.usda")
    monkeypatch.chdir(tmp_path / "two")
    assert anchors.portable(named["one"]) == "@<here>/part.usda@"
    stage_context.new_stage()
    assert anchors.portable(named["one"]) == named["one"]
    stage_context.open_stage("part.usda")
    assert anchors.portable(named["two"]) == "@<here>/part.usda@"
    stage_context.new_stage()  # for which files may have been looked up before, as by jobs
    assert anchors.portable(named["two"]) == "@<here>/part.usda@"


def test_a_stage_is_saved_while_the_owner_of_a_product_is_collected(tmp_path, monkeypatch):
    class Owner:
        def __init__(self, product):
            self.me, self.product = self, product

        def __del__(self):
            self.product.destroy()

    kept = rep.create.render_product(rep.create.camera(), (8, 8))
    Owner(rep.create.render_product(rep.create.camera(), (8, 8)))
    monkeypatch.setattr(HydraTexture, "camera_path", property(lambda product: gc.collect() and product.path))
    stage_context.save_stage(tmp_path / "a.usda")
    assert products() == [kept]
