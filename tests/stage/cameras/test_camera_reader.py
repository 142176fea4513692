"""Cameras are read again after changes that concern them, and only then."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from usdsdg.errors import BadPrim
from usdsdg.stage.cameras.camera_reader import CameraReader
from usdsdg.stage.cameras.camera_view import read_camera

SIZE = (64, 48)
NOW = Usd.TimeCode.Default()


@pytest.fixture
def stage() -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/Rig").AddTranslateOp().Set((1, 2, 3))
    UsdGeom.Camera.Define(stage, "/Rig/Eye").GetFocalLengthAttr().Set(24.0)
    UsdGeom.Cube.Define(stage, "/Rig/Box").AddTranslateOp().Set((0, 0, 0))
    return stage


def focal_length(stage):
    stage.GetPrimAtPath("/Rig/Eye").GetAttribute("focalLength").Set(35.0)


def pose_above(stage):
    stage.GetPrimAtPath("/Rig").GetAttribute("xformOp:translate").Set((4, 5, 6))


def new_op(stage):
    UsdGeom.Xformable(stage.GetPrimAtPath("/Rig/Eye")).AddRotateXOp().Set(30.0)


def units(stage):
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)


def removed_op(stage):
    UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).ClearXformOpOrder()


def own_attribute(stage):
    stage.GetPrimAtPath("/Rig/Eye").CreateAttribute("exposure:time", Sdf.ValueTypeNames.Float).Set(0.5)


@pytest.mark.parametrize("edit", [focal_length, pose_above, new_op, units, removed_op, own_attribute])
def test_what_concerns_a_camera_is_read(stage, edit):
    reader = CameraReader(stage)
    before = reader.read("/Rig/Eye", SIZE, time=NOW)
    edit(stage)
    view, fresh = reader.read("/Rig/Eye", SIZE, time=NOW), read_camera(stage, "/Rig/Eye", SIZE)
    assert view is not before
    for name in ("focal_length", "meters_per_unit", "clipping_range", "attributes"):
        assert getattr(view, name) == getattr(fresh, name), name
    np.testing.assert_array_equal(view.local_to_world, fresh.local_to_world)


def test_what_concerns_others_is_not(stage):
    reader = CameraReader(stage)
    before = reader.read("/Rig/Eye", SIZE, time=NOW)
    stage.GetPrimAtPath("/Rig/Box").GetAttribute("xformOp:translate").Set((9, 9, 9))
    assert reader.read("/Rig/Eye", SIZE, time=NOW) is before
    assert reader.read("/Rig/Eye", (32, 24), time=NOW).width == 32
    assert reader.read("/Rig/Eye", SIZE, time=NOW) is before


def test_an_animated_camera_is_read_at_each_time(stage):
    attribute = stage.GetPrimAtPath("/Rig").GetAttribute("xformOp:translate")
    attribute.Set(Gf.Vec3d(0, 0, 0), 0)
    attribute.Set(Gf.Vec3d(10, 0, 0), 10)
    reader = CameraReader(stage)
    seen = [reader.read("/Rig/Eye", SIZE, time=Usd.TimeCode(time)).local_to_world[3, 0] for time in (0, 5, 10, 5)]
    assert seen == [0, 5, 10, 5]


def test_a_second_camera_below_a_prim_makes_it_ambiguous(stage):
    reader = CameraReader(stage)
    assert reader.read("/Rig", SIZE, time=NOW).prim_path == "/Rig/Eye"
    UsdGeom.Camera.Define(stage, "/Rig/Other")
    with pytest.raises(BadPrim, match="/Rig/Other"):
        reader.read("/Rig", SIZE, time=NOW)
    stage.RemovePrim("/Rig/Eye")
    assert reader.read("/Rig", SIZE, time=NOW).prim_path == "/Rig/Other"


def shows(stage, path):
    product = UsdRender.Product(stage.GetPrimAtPath(path))
    camera = product.GetCameraRel().GetForwardedTargets()[0]
    stays = all(target.IsPrimPath() for target in product.GetCameraRel().GetTargets())
    return (str(camera), tuple(product.GetResolutionAttr().Get())), stays


def other_camera(stage):
    stage.GetPrimAtPath("/Product").GetRelationship("camera").SetTargets(["/Rig/Second"])


def other_size(stage):
    stage.GetPrimAtPath("/Product").GetAttribute("resolution").Set(Gf.Vec2i(32, 24))


def other_product(stage):
    stage.RemovePrim("/Product")
    product = UsdRender.Product.Define(stage, "/Product")
    product.CreateCameraRel().SetTargets(["/Rig/Second"])
    product.CreateResolutionAttr().Set(Gf.Vec2i(32, 24))


def led_on(stage):
    stage.GetPrimAtPath("/Product").GetRelationship("camera").SetTargets(["/Rig.chosen"])
    stage.GetPrimAtPath("/Rig").CreateRelationship("chosen").SetTargets(["/Rig/Second"])


def led_elsewhere(stage):
    stage.GetPrimAtPath("/Rig").GetRelationship("chosen").SetTargets(["/Rig/Eye"])


def test_what_a_product_shows_is_read_where_it_changes(stage):
    UsdGeom.Camera.Define(stage, "/Rig/Second").GetFocalLengthAttr().Set(12.0)
    product = UsdRender.Product.Define(stage, "/Product")
    product.CreateCameraRel().SetTargets(["/Rig/Eye"])
    product.CreateResolutionAttr().Set(Gf.Vec2i(*SIZE))
    reader, calls = CameraReader(stage), []

    def view():
        return reader.read_product("/Product", lambda: calls.append(1) or shows(stage, "/Product"), time=NOW)

    def frames(count):
        for number in range(count):  # in which other things move
            stage.GetPrimAtPath("/Rig/Box").GetAttribute("xformOp:translate").Set((number + 1, 0, 0))
            seen = view()
        return seen

    first = frames(4)
    assert (first.prim_path, len(calls)) == ("/Rig/Eye", 1)
    for edit in (other_size, other_camera, pose_above, other_product, led_on, led_elsewhere, focal_length):
        edit(stage)
        for _ in range(3):
            (camera, size), _ = shows(stage, "/Product")
            seen, fresh = frames(1), read_camera(stage, camera, size)
            assert (seen.prim_path, seen.width, seen.height) == (fresh.prim_path, *size), edit.__name__
            assert seen.focal_length == fresh.focal_length, edit.__name__
            np.testing.assert_array_equal(seen.local_to_world, fresh.local_to_world)


@pytest.mark.parametrize("attribute", ["focalLength", "xformOp:translate"])
@pytest.mark.parametrize("depth", [1, 2])
def test_a_camera_in_an_instance_is_read_where_its_asset_is_edited(stage, attribute, depth):
    """Notices name the camera of the asset and the one in the instances' prototype, not the instance's own."""
    source, path = "/Rig", "/Eye"
    for level in range(depth):
        instance = stage.DefinePrim(f"/Level_{level}/Copy", "Xform")
        instance.GetReferences().AddInternalReference(source)
        instance.SetInstanceable(True)
        source, path = f"/Level_{level}", f"/Copy{path}"
    path = f"{source}{path}"
    UsdGeom.Camera(stage.GetPrimAtPath("/Rig/Eye")).AddTranslateOp().Set((0, 0, 0))
    reader = CameraReader(stage)
    before = reader.read(path, SIZE, time=NOW)
    stage.GetPrimAtPath("/Rig/Eye").GetAttribute(attribute).Set(30.0 if attribute == "focalLength" else (0, 0, 7))
    view, fresh = reader.read(path, SIZE, time=NOW), read_camera(stage, path, SIZE)
    assert view is not before
    assert view.focal_length == fresh.focal_length
    np.testing.assert_array_equal(view.local_to_world, fresh.local_to_world)
    assert reader.read(path, SIZE, time=NOW) is view
