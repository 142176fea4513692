"""References to files of other units or another up axis."""

import warnings

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.stage import assets


@pytest.fixture(autouse=True)
def _alone():
    forget_warnings()


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    return stage


def asset(folder, *, meters=0.01, up="Z", kind="Cube", name="a.usda"):
    stage = Usd.Stage.CreateNew(str(folder / name))
    stage.SetDefaultPrim(stage.DefinePrim("/Asset", "Xform"))
    stage.DefinePrim("/Asset/part", kind)
    if meters is not None:
        UsdGeom.SetStageMetersPerUnit(stage, meters)
    if up is not None:
        UsdGeom.SetStageUpAxis(stage, up)
    stage.Save()
    return str(folder / name)


def refer(stage, file, path="/World/a"):
    prim = stage.DefinePrim(path, "Xform")
    prim.GetReferences().AddReference(file)
    return UsdGeom.Xformable(prim)


def named(stage):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assets.name_other_metrics(stage)
    assert all(each.category is UsdsdgWarning for each in told)
    return [str(each.message) for each in told]


def test_a_file_of_other_units_is_named_once_with_the_scale(stage, tmp_path):
    file = asset(tmp_path)
    for path in ("/World/a", "/World/b"):
        refer(stage, file, path)
    [text] = named(stage)
    assert text.startswith("/World/a refers to a.usda, which has units of 0.01 m, where the stage has units of 1 m.")
    assert "it is 100 times as large as it says. Scale the prim by 0.01, or" in text


@pytest.mark.parametrize(("up", "degrees"), [("Y", 90), ("Z", -90)])
def test_the_rotation_that_is_named_lets_the_asset_stand(stage, tmp_path, up, degrees):
    UsdGeom.SetStageUpAxis(stage, "Z" if up == "Y" else "Y")
    prim = refer(stage, asset(tmp_path, meters=1.0, up=up))
    [text] = named(stage)
    assert f"which has {up} up" in text
    assert f"Rotate the prim by {degrees} degrees about X" in text
    forget_warnings()
    prim.AddRotateXOp().Set(degrees)
    assert named(stage) == []
    axis, stage_axis = np.eye(3)["XYZ".index(up)], np.eye(3)["XYZ".index(UsdGeom.GetStageUpAxis(stage))]
    moved = prim.GetLocalTransformation().TransformDir(Gf.Vec3d(*axis.tolist()))
    assert list(moved) == pytest.approx(stage_axis.tolist(), abs=1e-9)


@pytest.mark.parametrize("scale", [0.01, 0.02, 0.004])
@pytest.mark.parametrize("above", [False, True])
def test_a_scale_that_makes_up_for_units_is_not_named(stage, tmp_path, scale, above):
    prim = refer(stage, asset(tmp_path))
    scaled = UsdGeom.Xform.Define(stage, "/World") if above else prim
    scaled.AddScaleOp().Set(Gf.Vec3f(scale))
    assert named(stage) == []


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_other_scales_do_not_make_up_for_units(stage, tmp_path, scale):
    refer(stage, asset(tmp_path)).AddScaleOp().Set(Gf.Vec3f(scale))
    assert len(named(stage)) == 1


def test_what_says_nothing_or_draws_nothing_is_not_named(stage, tmp_path):
    refer(stage, asset(tmp_path, meters=None, up=None, name="silent.usda"), "/World/a")
    refer(stage, asset(tmp_path, kind="Material", name="looks.usda"), "/World/b")
    refer(stage, asset(tmp_path, meters=1.0, name="same.usda"), "/World/c")
    assert named(stage) == []


def test_stages_that_say_nothing_have_no_units_to_differ_from(tmp_path):
    stage = Usd.Stage.CreateInMemory()
    refer(stage, asset(tmp_path))
    assert named(stage) == []


def test_payloads_and_sublayers_count_and_assets_of_assets_do_not(stage, tmp_path):
    inner = asset(tmp_path, name="inner.usda")
    outer = Usd.Stage.CreateNew(str(tmp_path / "outer.usda"))
    UsdGeom.SetStageMetersPerUnit(outer, 1.0)
    outer.SetDefaultPrim(outer.DefinePrim("/Outer", "Xform"))
    refer(outer, inner, "/Outer/inner")
    outer.Save()
    refer(stage, str(tmp_path / "outer.usda"))
    assert named(stage) == []
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage.GetRootLayer().subLayerPaths.append(layer.identifier)
    with Usd.EditContext(stage, layer):
        stage.DefinePrim("/World/b", "Xform").GetPayloads().AddPayload(inner)
    [text] = named(stage)
    assert text.startswith("/World/b refers to inner.usda")
