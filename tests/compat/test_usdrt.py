"""`usdrt`: poses and prims in the names of Fabric's API."""

import pytest
from pxr import Gf, Usd, UsdGeom

from usdsdg.compat import usdrt
from usdsdg.compat.isaacsim.core.experimental.utils import backend as backend_utils
from usdsdg.compat.isaacsim.core.experimental.utils import stage as stage_utils
from usdsdg.compat.omni.usd import get_context


@pytest.fixture
def cube(stage):
    """A turned and moved cube below a parent that is scaled and moved."""
    UsdGeom.XformCommonAPI(UsdGeom.Xform.Define(stage, "/World/parent")).SetScale((2, 2, 2))
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath("/World/parent")).SetTranslate((1, 2, 3))
    cube = UsdGeom.Cube.Define(stage, "/World/parent/cube")
    UsdGeom.XformCommonAPI(cube).SetTranslate((1, 0, 0))
    UsdGeom.XformCommonAPI(cube).SetRotate((0, 0, 90))
    attached = usdrt.Usd.Stage.Attach(get_context().get_stage_id())
    return usdrt.Rt.Xformable(attached.GetPrimAtPath(usdrt.Sdf.Path("/World/parent/cube")))


def usd_world(cube):
    return UsdGeom.Xformable(cube.GetPrim()).ComputeLocalToWorldTransform(Usd.TimeCode.Default())


def test_poses_are_those_of_usd(cube):
    assert cube.GetWorldPositionAttr().Get() == Gf.Vec3d(3, 2, 3)
    turned = Gf.Rotation(cube.GetWorldOrientationAttr().Get()).TransformDir(Gf.Vec3d(1, 0, 0))
    assert Gf.IsClose(turned, Gf.Vec3d(0, 1, 0), 1e-6)
    assert cube.GetWorldScaleAttr().Get(usdrt.Usd.TimeCode.Default()) == Gf.Vec3f(2, 2, 2)
    assert Gf.IsClose(cube.GetFabricHierarchyWorldMatrixAttr().Get(), usd_world(cube), 1e-12)
    local = UsdGeom.Xformable(cube.GetPrim()).GetLocalTransformation(Usd.TimeCode.Default())
    assert cube.GetLocalMatrixAttr().Get() == local


def test_a_part_of_a_pose_that_is_set_leaves_the_others(cube):
    before = usd_world(cube)
    cube.CreateWorldPositionAttr(Gf.Vec3d(5, 6, 7))
    assert Gf.IsClose(usd_world(cube).ExtractTranslation(), Gf.Vec3d(5, 6, 7), 1e-9)
    assert Gf.IsClose(usd_world(cube).ExtractRotationMatrix(), before.ExtractRotationMatrix(), 1e-9)
    assert cube.GetWorldOrientationAttr().Set(Gf.Quatf(1, 0, 0, 0))
    cube.GetWorldScaleAttr().Set(Gf.Vec3f(1, 2, 3))
    expected = Gf.Matrix4d().SetScale(Gf.Vec3d(1, 2, 3)).SetTranslateOnly(Gf.Vec3d(5, 6, 7))
    assert Gf.IsClose(usd_world(cube), expected, 1e-6)


def test_matrices_that_are_set_are_read_again(cube):
    matrix = Gf.Matrix4d().SetTransform(Gf.Rotation(Gf.Vec3d(1, 2, 3), 40), Gf.Vec3d(4, 5, 6))
    cube.GetFabricHierarchyWorldMatrixAttr().Set(matrix)
    assert Gf.IsClose(usd_world(cube), matrix, 1e-6)
    cube.CreateLocalMatrixAttr(matrix)
    assert Gf.IsClose(UsdGeom.Xformable(cube.GetPrim()).GetLocalTransformation(), matrix, 1e-6)


def test_poses_are_those_of_the_time_of_the_timeline(stage, timeline_at):
    moving = UsdGeom.Xform.Define(stage, "/World/moving")
    move = moving.AddTranslateOp()
    for code in (0, 60):
        move.Set((code, 0, 0), code)
    timeline_at(0.5)
    assert usdrt.Rt.Xformable(moving).GetWorldPositionAttr().Get() == Gf.Vec3d(30, 0, 0)


@pytest.fixture
def timeline_at():
    from usdsdg.session.timeline import get_timeline

    return get_timeline().set_current_time


def test_stages_of_backends_are_stages_of_usdrt(stage):
    stage.DefinePrim("/World/cube", "Cube")
    assert isinstance(stage_utils.get_current_stage(backend="usdrt"), usdrt.Usd.Stage)
    other = Usd.Stage.CreateInMemory()
    with backend_utils.use_backend("fabric"), stage_utils.use_stage(other):
        attached = stage_utils.get_current_stage()
        assert isinstance(attached, usdrt.Usd.Stage)
        assert not attached.HasPrimAtPath("/World/cube")
    attached = stage_utils.get_current_stage(backend="fabric")
    assert attached.GetPrimsWithTypeAndAppliedAPIName("Cube", []) == ["/World/cube"]
    assert usdrt.UsdGeom.Cube(attached.GetPrimAtPath("/World/cube")).GetSizeAttr().Get() == 2.0
    with pytest.raises(ValueError, match="no backend 'tensor' for stages"):
        stage_utils.get_current_stage(backend="tensor")
