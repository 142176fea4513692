"""`isaacsim.core.utils`, also as `omni.isaac.core.utils`."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.core.prims import XFormPrim
from usdsdg.compat.isaacsim.core.rendering_manager import ViewportManager
from usdsdg.compat.isaacsim.core.utils import (
    bounds,
    mesh,
    prims,
    render_product,
    rotations,
    semantics,
    string,
    transformations,
    viewports,
    xforms,
)
from usdsdg.compat.isaacsim.core.utils import stage as stage_utils
from usdsdg.compat.omni.usd import get_context
from usdsdg.errors import BadPrim, BadValue, Unsupported


@pytest.mark.parametrize("extrinsic", [True, False])
@pytest.mark.parametrize("degrees", [(10, 20, 30), (-170, 80, 5), (0, 0, 180), (30, 90, 0), (30, -90, 0)])
def test_rotations_agree_with_pxr_and_undo_each_other(degrees, extrinsic):
    parts = [Gf.Rotation(Gf.Vec3d(*axis), angle) for axis, angle in zip(np.eye(3).tolist(), degrees, strict=True)]
    expected = parts[0] * parts[1] * parts[2] if extrinsic else parts[2] * parts[1] * parts[0]
    matrix = rotations.euler_to_rot_matrix(degrees, degrees=True, extrinsic=extrinsic)
    np.testing.assert_allclose(matrix @ (1, 2, 3), expected.TransformDir(Gf.Vec3d(1, 2, 3)), atol=1e-12)
    quat = rotations.euler_angles_to_quat(degrees, degrees=True, extrinsic=extrinsic)
    np.testing.assert_allclose(rotations.quat_to_rot_matrix(quat), matrix, atol=1e-12)
    again = rotations.quat_to_euler_angles(quat, degrees=True, extrinsic=extrinsic)
    np.testing.assert_allclose(again, degrees, atol=1e-6)
    gf = rotations.gf_rotation_to_np_array(expected)
    np.testing.assert_allclose(gf * np.sign(gf[0]), quat * np.sign(quat[0]), atol=1e-9)


def test_looking_at_a_point_turns_plus_z_to_it():
    quat = rotations.lookat_to_quatf(Gf.Vec3f(0, 0, 0), Gf.Vec3f(5, 0, 0), Gf.Vec3f(0, 0, 1))
    assert Gf.IsClose(Gf.Rotation(Gf.Quatd(quat)).TransformDir(Gf.Vec3d(0, 0, 1)), Gf.Vec3d(1, 0, 0), 1e-6)
    assert Gf.IsClose(Gf.Rotation(Gf.Quatd(quat)).TransformDir(Gf.Vec3d(0, 1, 0)), Gf.Vec3d(0, 0, 1), 1e-6)
    assert rotations.lookat_to_quatf(Gf.Vec3f(1), Gf.Vec3f(1), Gf.Vec3f(0, 0, 1)) == Gf.Quatf(1)


def test_matrices_and_poses_undo_each_other():
    matrix = transformations.tf_matrix_from_pose((1, 2, 3), (0.5, 0.5, 0.5, 0.5))
    np.testing.assert_allclose(matrix @ (1, 0, 0, 1), (1, 3, 3, 1), atol=1e-12)
    place, turn = transformations.pose_from_tf_matrix(matrix)
    np.testing.assert_allclose(np.hstack([place, turn]), (1, 2, 3, 0.5, 0.5, 0.5, 0.5), atol=1e-12)
    several = transformations.tf_matrices_from_poses(np.ones((2, 3)), np.tile((1.0, 0, 0, 0), (2, 1)))
    assert (several.shape, several.dtype) == ((2, 4, 4), np.float32)
    normalized = transformations.get_transform_with_normalized_rotation(np.diag((2.0, 3.0, 0.0, 1.0)))
    assert np.diag(normalized).tolist() == [1, 1, 0, 1]


def test_prims_are_created_placed_labeled_and_removed(stage):
    made = prims.create_prim(
        "/World/group/lamp", "SphereLight", position=(1, 2, 3), orientation=(0.5, 0.5, 0.5, 0.5), scale=(2, 2, 2),
        semantic_label="lamp", attributes={"inputs:intensity": 500},
    )  # fmt: skip
    assert made.GetAttribute("inputs:intensity").Get() == 500
    place, turn = xforms.get_world_pose("/World/group/lamp")
    np.testing.assert_allclose(np.hstack([place, turn]), (1, 2, 3, 0.5, 0.5, 0.5, 0.5), atol=1e-6)
    assert semantics.get_labels(made) == {"class": ["lamp"]}
    with pytest.raises(ValueError, match="already"):
        prims.create_prim("/World/group/lamp")
    with pytest.warns(UserWarning, match="no attribute 'color'"):
        prims.create_prim("/World/x", attributes={"color": 1})
    prims.delete_prim("/World/group")
    assert not prims.is_prim_path_valid("/World/group/lamp")


def test_a_referenced_prim_is_turned_off_where_it_cannot_be_removed(stage, tmp_path):
    part = Usd.Stage.CreateNew(str(tmp_path / "part.usda"))
    part.SetDefaultPrim(part.DefinePrim("/part"))
    part.DefinePrim("/part/screw", "Cube")
    part.Save()
    stage_utils.add_reference_to_stage(str(tmp_path / "part.usda"), "/World/part")
    assert prims.is_prim_ancestral("/World/part/screw")
    prims.delete_prim("/World/part/screw")
    assert not stage.GetPrimAtPath("/World/part/screw").IsActive()


def test_prims_are_found_by_path(stage):
    for path in ("/World/a_0", "/World/a_1/b", "/World/c"):
        stage.DefinePrim(path, "Cube")
    UsdPhysics.RigidBodyAPI.Apply(stage.GetPrimAtPath("/World/c"))
    assert prims.find_matching_prim_paths("/World/a_.*") == ["/World/a_0", "/World/a_1"]
    assert prims.find_matching_prim_paths("/World/*", "") == ["/World/a_0", "/World/a_1", "/World/c"]
    assert prims.find_matching_prim_paths("/World/*", "rigid_body") == ["/World/c"]
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath("/World/a_1"))
    assert prims.find_matching_prim_paths("/World/.*", prim_type="articulation") == ["/World/a_1"]
    with pytest.raises(ValueError, match="prim_type is 'Xform'; expected 'rigid_body' or 'articulation'"):
        prims.find_matching_prim_paths("/World/*", prim_type="Xform")
    below = prims.get_all_matching_child_prims("/World", lambda path: path.endswith(("b", "c")))
    assert [prims.get_prim_path(each) for each in below] == ["/World/c", "/World/a_1/b"]
    assert prims.get_first_matching_parent_prim("/World/a_1/b", lambda path: "a_" in path).GetName() == "a_1"
    assert prims.get_prim_object_type("/World/c") == "rigid_body"
    assert prims.get_prim_object_type("/World/a_0") == "xform"
    prims.set_prim_no_delete(stage.GetPrimAtPath("/World/c"), True)
    assert prims.is_prim_no_delete("/World/c")


def test_attributes_are_read_as_lists_and_set_from_arrays(stage):
    cube = UsdGeom.Cube.Define(stage, "/World/cube")
    cube.AddTranslateOp()
    cube.AddOrientOp().Set(Gf.Quatf(0.5, 0.5, 0.5, 0.5))
    prims.set_prim_attribute_value("/World/cube", "xformOp:translate", np.array([1, 2, 3]))
    assert prims.get_prim_attribute_value("/World/cube", "xformOp:translate") == [1, 2, 3]
    assert prims.get_prim_attribute_value("/World/cube", "xformOp:orient") == [0.5] * 4
    prims.set_prim_property("/World/cube", "size", 3)
    assert prims.get_prim_property("/World/cube", "size") == 3.0
    with pytest.raises(BadValue):
        prims.set_prim_attribute_value("/World/cube", "size", "wide")


def test_bounds_take_the_cache_first(stage):
    UsdGeom.Cube.Define(stage, "/World/cube").AddTranslateOp().Set((1, 0, 0))
    cache = bounds.create_bbox_cache()
    np.testing.assert_allclose(bounds.compute_aabb(cache, "/World/cube"), (0, -1, -1, 2, 1, 1))
    np.testing.assert_allclose(bounds.compute_combined_aabb(cache, ["/World/cube"]), (0, -1, -1, 2, 1, 1))
    assert bounds.compute_obb_corners(cache, "/World/cube").shape == (8, 3)
    tri = UsdGeom.Mesh.Define(stage, "/World/tri")
    tri.CreatePointsAttr([(0, 0, 0), (2, 0, 0), (0, 2, 0)])
    bounds.recompute_extents(tri, include_children=True)
    assert tri.GetExtentAttr().Get()[1] == (2, 2, 0)
    with pytest.raises(BadPrim, match="Xform"):
        bounds.recompute_extents(stage.GetPrimAtPath("/World"))


def test_points_of_a_mesh_in_another_space(stage):
    tri = UsdGeom.Mesh.Define(stage, "/World/tri")
    tri.CreatePointsAttr([(0, 0, 0), (1, 0, 0)])
    tri.AddTranslateOp().Set((0, 0, 5))
    other = UsdGeom.Xform.Define(stage, "/World/other")
    other.AddTranslateOp().Set((1, 0, 0))
    found = mesh.get_mesh_vertices_relative_to(tri, other.GetPrim())
    np.testing.assert_allclose(found, [(-1, 0, 5), (0, 0, 5)])


def test_labels_are_counted_checked_and_upgraded(stage):
    for name in ("mug_01", "plate", "bare"):
        UsdGeom.Mesh.Define(stage, f"/World/{name}")
    semantics.add_labels(stage.GetPrimAtPath("/World/mug_01"), ["mug"])
    semantics.add_labels(stage.GetPrimAtPath("/World/plate"), ["bowl"])
    assert semantics.check_missing_labels() == ["/World/bare"]
    assert semantics.check_incorrect_labels(validate_against_prim_path=True) == [["/World/plate", "bowl"]]
    assert semantics.count_labels_in_scene() == {"missing_labels": 1, "mug": 1, "bowl": 1}
    assert semantics.count_semantics_in_scene("/World/bare") == {"missing_semantics": 1}
    assert semantics.upgrade_prim_semantics_to_labels(stage.GetPrimAtPath("/World"), include_descendants=True) == 2
    assert semantics.count_labels_in_scene() == {"missing_labels": 1, "mug": 1, "bowl": 1}
    semantics.remove_labels(stage.GetPrimAtPath("/World"), include_descendants=True)
    assert semantics.count_labels_in_scene() == {"missing_labels": 3}


@pytest.mark.parametrize(
    ("pattern", "numbers"),
    [("[1-3]", [1, 2, 3]), (".*", [0, 1, 2, 3, 10]), ("*", [0, 1, 2, 3, 10]), ("?", [0, 1, 2, 3]), ("1*", [1, 10])],
)
def test_wildcards_in_paths_stand_for_parts_of_names(stage, pattern, numbers):
    for number in (0, 1, 2, 3, 10):
        stage.DefinePrim(f"/World/env_{number}/cube", "Cube")
    expected = [f"/World/env_{number}/cube" for number in numbers]
    assert prims.find_matching_prim_paths(f"/World/env_{pattern}/cube") == expected
    assert XFormPrim(f"/World/env_{pattern}/cube", reset_xform_properties=False).prim_paths == expected


def test_the_root_of_an_articulation_is_found_below_a_prim(stage):
    for number in (0, 1):
        torso = stage.DefinePrim(f"/World/env_{number}/ant/torso", "Cube")
        UsdPhysics.ArticulationRootAPI.Apply(torso)
    for given, found in (
        ("/World/env_0/ant/torso", "/World/env_0/ant/torso"),
        ("/World/env_0/ant", "/World/env_0/ant/torso"),
        ("/World/env_.*/ant", "/World/env_.*/ant/torso"),
        ("/World/none", "/World/none"),
    ):
        assert prims.get_articulation_root_api_prim_path(given) == found


def test_upgraded_labels_may_be_changed_as_others(stage):
    cube = stage.GetPrimAtPath(rep.create.cube(semantics=[("class", "box"), ("kind", "red")]).prims[0])
    assert semantics.upgrade_prim_semantics_to_labels(cube) == 2
    assert list(cube.GetAttribute("semantics:labels:class").Get()) == ["box"]
    assert not [schema for schema in cube.GetAppliedSchemas() if schema.startswith("SemanticsAPI:")]
    assert semantics.get_labels(cube) == {"class": ["box"], "kind": ["red"]}
    semantics.add_labels(cube, ["crate"], overwrite=False)
    semantics.remove_labels(cube, "kind")
    assert semantics.get_labels(cube) == {"class": ["box", "crate"]}


def test_one_type_of_labels_is_removed_and_the_others_stay(stage):
    cube = stage.DefinePrim("/World/a", "Cube")
    semantics.add_labels(cube, ["x"])
    semantics.add_labels(cube, ["y"], instance_name="kind")
    semantics.add_labels(cube, ["z"], instance_name="kind", overwrite=False)
    assert semantics.get_labels(cube)["kind"] == ["y", "z"]
    semantics.remove_labels(cube, "kind")
    assert semantics.get_labels(cube) == {"class": ["x"]}


def test_stages_are_cleared_and_have_free_paths(stage):
    stage.DefinePrim("/World/a", "Cube")
    stage.DefinePrim("/World/b", "Cube")
    stage_utils.clear_stage(lambda path: path.endswith("a"))
    assert [prim.GetName() for prim in stage_utils.traverse_stage()] == ["World", "b"]
    assert stage_utils.get_next_free_path("b", "/World") == "/World/b_01"
    stage_utils.clear_stage()
    assert list(stage_utils.traverse_stage()) == []


def test_names_are_made_unique():
    taken = {"a", "a_1"}
    assert string.find_unique_string_name("a", lambda name: name not in taken) == "a_2"
    assert string.find_root_prim_path_from_regex("/World/env_*/robot") == ("/World", 2)


def test_a_viewport_camera_is_aimed(stage):
    viewports.set_camera_view(eye=(4, 0, 3), target=(0, 0, 3))
    camera = stage.GetPrimAtPath("/OmniverseKit_Persp")
    to_world = UsdGeom.XformCache().GetLocalToWorldTransform(camera)
    assert Gf.IsClose(to_world.Transform(Gf.Vec3d(0, 0, -4)), Gf.Vec3d(0, 0, 3), 1e-6)
    with pytest.raises(BadPrim, match="no camera"):
        viewports.set_camera_view((0, 0, 0), (1, 0, 0), "/World/none")
    with pytest.raises(Unsupported, match="render product"):
        viewports.create_viewport_for_camera("v", "/OmniverseKit_Persp")


def axes_of_image(stage, path):
    """Return the directions of the world to the right and at the top of a camera's image, and the one it looks in."""
    rows = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath(path)))[:3, :3]
    return np.round(rows * [[1], [1], [-1]], 4).tolist()


@pytest.mark.parametrize("op", ["AddRotateXYZOp", "AddOrientOp"])
def test_cameras_that_look_along_the_up_axis_show_what_they_show_in_isaac_sim(stage, op):
    camera = UsdGeom.Camera.Define(stage, "/World/camera")
    camera.AddTranslateOp()
    getattr(camera, op)()
    # The function of older releases has the camera's own axes in both cases, which are turned about Y to look up.
    viewports.set_camera_view(np.array([5, 5, 10]), np.array([5, 5, 0]), "/World/camera")
    assert axes_of_image(stage, "/World/camera") == [[1, 0, 0], [0, 1, 0], [0, 0, -1]]
    viewports.set_camera_view(np.array([5, 5, 0]), np.array([5, 5, 10]), "/World/camera")
    assert axes_of_image(stage, "/World/camera") == [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]
    # That of newer ones moves the target a little along +X, so that this is ahead.
    ViewportManager.set_camera_view("/World/camera", eye=(5, 5, 10), target=(5, 5, 0))
    assert axes_of_image(stage, "/World/camera") == [[0, -1, 0], [1, 0, 0], [0, 0, -1]]
    ViewportManager.set_camera_view("/World/camera", eye=(5, 5, 0), target=(5, 5, 10))
    assert axes_of_image(stage, "/World/camera") == [[0, -1, 0], [-1, 0, 0], [0, 0, 1]]
    # Beside the axis it is the axis that is up.
    ViewportManager.set_camera_view("/World/camera", eye=(0, -5, 0), target=(0, 0, 0))
    assert axes_of_image(stage, "/World/camera") == [[1, 0, 0], [0, 0, 1], [0, 1, 0]]


def test_ops_are_replaced(stage):
    cube = UsdGeom.Cube.Define(stage, "/World/cube")
    cube.AddTranslateOp().Set((1, 2, 3))
    cube.AddRotateXOp().Set(90)
    before = np.array(cube.ComputeLocalToWorldTransform(0))
    xforms.reset_xform_ops(cube.GetPrim())
    assert [op.GetOpName() for op in cube.GetOrderedXformOps()][1] == "xformOp:orient"
    np.testing.assert_allclose(np.array(cube.ComputeLocalToWorldTransform(0)), before, atol=1e-6)
    xforms.clear_xform_ops(cube.GetPrim())
    assert xforms.get_local_pose("/World/cube")[0].tolist() == [0, 0, 0]


def test_render_products_are_read_and_changed_by_path(stage):
    first, second = (rep.functional.create.camera(name=name) for name in ("first", "second"))
    product, path = render_product.create_hydra_texture((64, 48), str(first.GetPath()))
    assert product.path == path
    assert render_product.get_resolution(path) == (64, 48)
    assert render_product.get_camera_prim_path(path) == first.GetPath()
    render_product.set_camera_prim_path(path, str(second.GetPath()))
    render_product.set_resolution(path, (32, 16))
    assert (product.camera_path, product.resolution) == (str(second.GetPath()), (32, 16))
    with pytest.raises(BadPrim, match="not a camera"):
        render_product.set_camera_prim_path(path, "/none")
    with pytest.raises(BadPrim, match="there is no render product"):
        render_product.get_resolution("/Render/none")
    with pytest.raises(Unsupported, match=r"rep\.annotators\.get"):
        render_product.add_aov(path, "LdrColor")


def test_an_older_script_uses_another_stage_for_a_while(stage):
    """The id of a stage in memory tells whether it is the one of the application, as scripts for Isaac Lab ask."""
    other = stage_utils.create_new_stage_in_memory()
    mine = stage_utils.get_current_stage_id()
    with stage_utils.use_stage(other):
        prims.create_prim("/there", "Cube")
        assert prims.is_prim_path_valid("/there")
        assert stage_utils.get_current_stage_id() != mine
        assert [str(each.GetPath()) for each in stage_utils.traverse_stage()] == ["/there"]
    assert stage_utils.get_current_stage_id() == mine
    assert other.GetPrimAtPath("/there").GetTypeName() == "Cube"
    assert not prims.is_prim_path_valid("/there")


def test_a_stage_that_a_script_has_filled_in_memory_becomes_the_current_one(stage):
    """As scripts for Isaac Lab do: by its id, after it was used."""
    other, told = stage_utils.create_new_stage_in_memory(), []
    with stage_utils.use_stage(other):
        prims.create_prim("/there", "Cube")
        assert stage_utils.get_current_stage(fabric=True).HasPrimAtPath("/there")
        get_context().attach_stage_with_callback(
            stage_utils.get_current_stage_id(), lambda done, error: told.append((done, error))
        )
    assert told == [(True, "")]
    assert get_context().get_stage() == other
    assert stage_utils.get_current_stage() == other
    assert prims.is_prim_path_valid("/there")
    third = Usd.Stage.CreateInMemory()
    assert get_app().run_until_complete(get_context().attach_stage_async(third)) == (True, "")
    assert get_context().get_stage() == third
