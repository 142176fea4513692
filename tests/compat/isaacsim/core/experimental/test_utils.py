"""`isaacsim.core.experimental.utils`."""

from __future__ import annotations

import math
import threading

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

import usdsdg as rep
from usdsdg.compat.isaacsim.core.experimental.prims import XformPrim
from usdsdg.compat.isaacsim.core.experimental.utils import app as app_utils
from usdsdg.compat.isaacsim.core.experimental.utils import backend, bounds, ops, prim, semantics, transform, xform
from usdsdg.compat.isaacsim.core.experimental.utils import stage as stage_utils
from usdsdg.compat.omni.usd import get_context
from usdsdg.errors import AssetNotFound, BadPrim, Unsupported
from usdsdg.session import stage_context

ANGLES = [(10.0, 20.0, 30.0), (-170.0, 80.0, 5.0), (0.0, 0.0, 180.0), (45.0, -60.0, 120.0)]


def rotation(degrees, *, extrinsic):
    """Return pxr's rotation: about x, then y, then z of fixed axes, or the reverse."""
    parts = [Gf.Rotation(Gf.Vec3d(*axis), angle) for axis, angle in zip(np.eye(3).tolist(), degrees, strict=True)]
    return parts[0] * parts[1] * parts[2] if extrinsic else parts[2] * parts[1] * parts[0]


@pytest.mark.parametrize("extrinsic", [True, False])
@pytest.mark.parametrize("degrees", ANGLES)
def test_euler_angles_turn_points_as_pxr_does(degrees, extrinsic):
    expected = rotation(degrees, extrinsic=extrinsic)
    matrix = transform.euler_angles_to_rotation_matrix(degrees, degrees=True, extrinsic=extrinsic).numpy()
    for point in np.eye(3):
        np.testing.assert_allclose(matrix @ point, expected.TransformDir(Gf.Vec3d(*point.tolist())), atol=1e-12)
    quat = transform.euler_angles_to_quaternion(np.radians(degrees), extrinsic=extrinsic).numpy()
    turned = Gf.Rotation(Gf.Quatd(*quat.tolist())).TransformDir(Gf.Vec3d(1, 2, 3))
    np.testing.assert_allclose(turned, expected.TransformDir(Gf.Vec3d(1, 2, 3)), atol=1e-12)


@pytest.mark.parametrize("extrinsic", [True, False])
@pytest.mark.parametrize("degrees", [*ANGLES, (30.0, 90.0, 0.0), (30.0, -90.0, 20.0)])
def test_quaternions_give_angles_of_the_same_rotation(degrees, extrinsic):
    quat = transform.euler_angles_to_quaternion(degrees, degrees=True, extrinsic=extrinsic)
    again = transform.quaternion_to_euler_angles(quat, degrees=True, extrinsic=extrinsic).numpy()
    before, after = (
        transform.euler_angles_to_rotation_matrix(each, degrees=True, extrinsic=extrinsic).numpy()
        for each in (degrees, again)
    )
    np.testing.assert_allclose(after, before, atol=1e-6)


def test_results_have_the_type_and_shape_of_what_is_given():
    assert transform.euler_angles_to_quaternion([0, 0, 1]).numpy().dtype == np.float32
    assert transform.euler_angles_to_quaternion([0.0, 0, 1]).numpy().dtype == np.float64
    assert transform.euler_angles_to_quaternion(np.zeros((2, 5, 3), np.float32)).shape == (2, 5, 4)
    with pytest.raises(ValueError, match=r"\(4,\)"):
        transform.quaternion_to_rotation_matrix([1, 0, 0])


def test_quaternions_multiply_as_pxrs():
    first, second = Gf.Quatd(0.5, 0.5, -0.5, 0.5), Gf.Quatd(0.8, 0.6, 0.0, 0.0)
    given = [np.array([each.GetReal(), *each.GetImaginary()]) for each in (first, second, first * second)]
    np.testing.assert_allclose(transform.quaternion_multiplication(given[0], given[1]).numpy(), given[2], atol=1e-12)
    inverse = transform.quaternion_conjugate(given[0]).numpy()
    np.testing.assert_allclose(transform.quaternion_multiplication(given[0], inverse).numpy(), (1, 0, 0, 0), atol=1e-12)


def test_looking_at_a_point_turns_minus_z_to_it():
    quat = transform.look_at_quaternion([1.0, 2.0, 3.0], [4.0, 2.0, 3.0]).numpy()
    turned = Gf.Rotation(Gf.Quatd(*quat.tolist()))
    assert Gf.IsClose(turned.TransformDir((0, 0, -1)), Gf.Vec3d(1, 0, 0), 1e-6)
    assert Gf.IsClose(turned.TransformDir((0, 1, 0)), Gf.Vec3d(0, 0, 1), 1e-6)
    down = transform.look_at_quaternion([0.0, 0.0, 5.0], [0.0, 0.0, 0.0]).numpy()
    assert Gf.IsClose(Gf.Rotation(Gf.Quatd(*down.tolist())).TransformDir((0, 1, 0)), Gf.Vec3d(0, 1, 0), 1e-6)
    matrix = transform.look_at_matrix((1, 2, 3), (4, 2, 3))
    assert Gf.IsClose(matrix.Transform((0, 0, -3)), Gf.Vec3d(4, 2, 3), 1e-9)


def test_relative_transforms_are_for_column_vectors(stage):
    for path, move in (("/World/a", (1, 2, 3)), ("/World/b", (0, 0, 1))):
        UsdGeom.Xform.Define(stage, path).AddTranslateOp().Set(move)
    np.testing.assert_allclose(xform.get_relative_transform("/World/a", "/World/b")[:, 3], (1, 2, 2, 1))
    np.testing.assert_allclose(xform.get_world_pose("/World/a")[0].numpy(), (1, 2, 3))
    xform.set_world_pose("/World/a", position=(7, 8, 9))
    np.testing.assert_allclose(xform.get_local_pose("/World/a")[0].numpy(), (7, 8, 9))


def test_bounds_of_a_turned_box(stage):
    box = UsdGeom.Cube.Define(stage, "/World/box")
    box.AddTranslateOp().Set((1, 2, 3))
    box.AddRotateZOp().Set(45)
    box.AddScaleOp().Set((1, 2, 3))
    far = UsdGeom.Sphere.Define(stage, "/World/far")
    far.AddTranslateOp().Set((10, 0, 0))
    reach = 3 * math.sqrt(0.5)
    np.testing.assert_allclose(
        bounds.compute_aabb("/World/box"), [1 - reach, 2 - reach, 0, 1 + reach, 2 + reach, 6], atol=1e-6
    )
    both = bounds.compute_combined_aabb([box.GetPrim(), "/World/far"])
    np.testing.assert_allclose(both, [1 - reach, -1, -1, 11, 2 + reach, 6], atol=1e-6)
    center, axes, half = bounds.compute_obb("/World/box")
    np.testing.assert_allclose(center, (1, 2, 3), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(axes, axis=1), (1, 2, 3), atol=1e-6)
    np.testing.assert_allclose(half, (1, 1, 1))
    to_world = UsdGeom.XformCache().GetLocalToWorldTransform(box.GetPrim())
    expected = [to_world.Transform(Gf.Vec3d(x, y, z)) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    np.testing.assert_allclose(bounds.compute_obb_corners("/World/box"), expected, atol=1e-6)
    with pytest.raises(BadPrim, match="/World/none"):
        bounds.compute_aabb("/World/none")
    with pytest.raises(ValueError, match="no prims"):
        bounds.compute_combined_aabb([])


def test_labels_are_added_removed_and_their_taxonomies_kept(stage):
    stage.DefinePrim("/World/a/b", "Cube")
    semantics.add_labels("/World/a", labels=["x", "y"])
    semantics.add_labels("/World/a", labels="z", taxonomy="kind")
    semantics.add_labels("/World/a/b", labels="x")
    assert semantics.get_labels("/World/a") == {"class": ["x", "y"], "kind": ["z"]}
    assert semantics.get_labels("/World/a", include_descendants=True)["class"] == ["x", "y", "x"]
    semantics.remove_labels("/World/a", labels="x", include_descendants=True)
    assert semantics.get_labels("/World/a/b") == {"class": []}
    semantics.remove_all_labels("/World/a")
    assert semantics.get_labels("/World/a") == {"class": [], "kind": []}
    semantics.remove_all_labels("/World/a", remove_taxonomies=True, include_descendants=True)
    assert semantics.get_labels("/World/a", include_descendants=True) == {}


def test_labels_in_the_old_schema_become_labels_in_the_new_one(stage):
    from usdsdg.stage.schemas.semantics_schema import SemanticsAPI

    cube = stage.DefinePrim("/World/a", "Cube")
    old = SemanticsAPI.Apply(cube, "Semantics_x")
    old.CreateSemanticTypeAttr().Set("class")
    old.CreateSemanticDataAttr().Set("mug")
    assert semantics.upgrade_prim_semantics_to_labels("/World", include_descendants=True) == ["/World/a"]
    assert cube.GetAppliedSchemas() == ["SemanticsLabelsAPI:class"]
    assert semantics.get_labels(cube) == {"class": ["mug"]}


def test_stages_are_opened_referenced_and_measured(stage, tmp_path):
    part = Usd.Stage.CreateNew(str(tmp_path / "part.usda"))
    root = part.DefinePrim("/part", "Xform")
    part.SetDefaultPrim(root)
    root.GetVariantSets().AddVariantSet("color").AddVariant("red")
    part.Save()
    made = stage_utils.add_reference_to_stage(str(tmp_path / "part.usda"), "/World/p", variants=[("color", "red")])
    assert prim.get_prim_variants(made) == [("color", "red")]
    with pytest.raises(ValueError, match="'blue'"):
        prim.set_prim_variants(made, variants=[("color", "blue")])
    with pytest.raises(AssetNotFound):
        stage_utils.add_reference_to_stage(str(tmp_path / "none.usda"), "/World/q")
    stage_utils.set_stage_units(meters_per_unit=0.01, kilograms_per_unit=2.0)
    assert stage_utils.get_stage_units() == (0.01, 2.0)
    stage_utils.set_stage_time_code(start_time_code=1, end_time_code=9)
    assert stage_utils.get_stage_time_code()[:2] == (1, 9)
    assert stage_utils.save_stage(str(tmp_path / "all.usda"))
    opened, again = stage_utils.open_stage(str(tmp_path / "all.usda"))
    assert opened
    assert again == stage_context.current_stage() == stage_utils.get_current_stage()
    with pytest.raises(ValueError, match="not the name of a USD file"):
        stage_utils.open_stage(str(tmp_path / "all.txt"))
    lit = stage_utils.create_new_stage(template="sunlight")
    assert [prim.GetTypeName() for prim in lit.Traverse() if prim.HasAttribute("inputs:intensity")] == ["DistantLight"]
    assert not stage_utils.create_new_stage(template="empty").GetPrimAtPath("/Environment")
    with pytest.raises(Unsupported, match="gridroom"):
        stage_utils.create_new_stage(template="gridroom")


def test_prims_are_defined_moved_and_removed(stage):
    made = stage_utils.define_prim("/World/a", "Cube")
    assert stage_utils.define_prim("/World/a", "Cube") == made
    with pytest.raises(RuntimeError, match="a Cube already"):
        stage_utils.define_prim("/World/a")
    with pytest.raises(ValueError, match="absolute"):
        stage_utils.define_prim("World/b")
    stage_utils.define_prim("/World/group")
    assert stage_utils.move_prim("/World/a", "/World/group") == (True, "/World/group/a")
    assert stage.GetPrimAtPath("/World/group/a").IsA(UsdGeom.Cube)
    assert stage_utils.delete_prim("/World/group")
    assert not stage.GetPrimAtPath("/World/group/a")
    with pytest.raises(BadPrim):
        stage_utils.delete_prim("/World/group")
    assert stage_utils.generate_next_free_path("/World/b") == "/World/b"
    assert "World (Xform)" in stage_utils.generate_stage_representation()


def test_another_stage_is_used_inside_a_block(stage):
    other = Usd.Stage.CreateInMemory()
    with stage_utils.use_stage(other):
        stage_utils.define_prim("/there")
        other.DefinePrim("/mine", "Xform")
        XformPrim("/mine", positions=[1.0, 2.0, 3.0], reset_xform_op_properties=True)
        assert stage_utils.is_stage_set()
        assert stage_utils.get_current_stage() == other
        with stage_utils.use_stage(stage):
            assert not stage_utils.get_current_stage().GetPrimAtPath("/there")
        assert stage_utils.get_current_stage() == other
    assert not stage_utils.is_stage_set()
    assert other.GetPrimAtPath("/there")
    assert Gf.Vec3d(1, 2, 3) == UsdGeom.Xformable(other.GetPrimAtPath("/mine")).GetLocalTransformation()[3][:3]
    assert not stage.GetPrimAtPath("/there")
    assert not stage.GetPrimAtPath("/mine")


def test_only_isaac_sims_wrappers_and_only_those_of_the_thread_use_another_stage(stage):
    """`omni.usd` and Replicator stay with the stage of the application."""
    other, seen = Usd.Stage.CreateInMemory(), []
    with stage_utils.use_stage(other):
        thread = threading.Thread(target=lambda: seen.append(stage_utils.get_current_stage()))
        thread.start()
        thread.join()
        assert get_context().get_stage() == stage
        cube = rep.create.cube()
    assert seen == [stage]
    assert cube.get_output_prims()["prims"][0].GetStage() == stage
    with pytest.raises(AssertionError, match="not str"), stage_utils.use_stage("/World"):
        pass


def test_another_stage_is_saved(stage, tmp_path):
    other = Usd.Stage.CreateInMemory()
    with stage_utils.use_stage(other):
        stage_utils.define_prim("/there")
        stage_utils.save_stage(str(tmp_path / "other.usda"))
    saved = Usd.Stage.Open(str(tmp_path / "other.usda"))
    assert [str(each.GetPath()) for each in saved.Traverse()] == ["/there"]


def test_prims_are_found_by_predicate_and_path(stage):
    for path in ("/World/a", "/World/a/b", "/World/a/b/c"):
        stage.DefinePrim(path, "Cube")
    UsdPhysics.CollisionAPI.Apply(stage.GetPrimAtPath("/World/a/b"))
    is_cube = lambda each, _: each.IsA(UsdGeom.Cube)  # noqa: E731
    found = prim.get_all_matching_child_prims("/World", predicate=is_cube, max_depth=2)
    assert [each.GetName() for each in found] == ["a", "b"]
    assert prim.get_first_matching_child_prim("/World", predicate=is_cube).GetPath() == "/World/a"
    above = prim.get_first_matching_parent_prim("/World/a/b/c", predicate=lambda _, path: path.endswith("a"))
    assert above.GetPath() == "/World/a"
    assert prim.find_matching_prim_paths("/World/a/.*", traverse=True) == ["/World/a/b", "/World/a/b/c"]
    assert prim.has_api("/World/a/b", [UsdPhysics.CollisionAPI, "PhysicsMassAPI"], test="any")
    assert not prim.has_api("/World/a/b", [UsdPhysics.CollisionAPI, "PhysicsMassAPI"])
    with pytest.raises(ValueError, match="no test"):
        prim.has_api("/World/a", "x", test="some")
    assert not prim.is_prim_non_root_articulation_link("/World/a/b")


def test_attributes_are_created_once(stage):
    stage.DefinePrim("/World/a", "Xform")
    prim.create_prim_attribute("/World/a", name="mine", type_name="float").Set(2.5)
    assert prim.get_prim_attribute_value("/World/a", "mine") == 2.5
    assert "mine" in prim.get_prim_attribute_names("/World/a")
    with pytest.raises(ValueError, match="as float and not int"):
        prim.create_prim_attribute("/World/a", name="mine", type_name=Sdf.ValueTypeNames.Int)
    with pytest.raises(RuntimeError, match="exists already"):
        prim.create_prim_attribute("/World/a", name="mine", type_name="float", exist_ok=False)


def test_arrays_are_placed_and_broadcast():
    placed = ops.place([[1.0, 2.0]])
    assert ops.place(placed) is placed
    assert ops.broadcast_to(3.0, shape=(2, 2)).numpy().tolist() == [[3, 3], [3, 3]]
    assert ops.resolve_indices(None, count=3).numpy().tolist() == [0, 1, 2]
    with pytest.raises(ValueError, match="count"):
        ops.resolve_indices(None)


def test_backends_are_named_inside_a_block():
    assert backend.get_current_backend(["usd"]) == "usd"
    with backend.use_backend("fabric", raise_on_unsupported=True):
        assert backend.get_current_backend(["usd", "fabric"]) == "fabric"
        with pytest.raises(RuntimeError, match="fabric"):
            backend.get_current_backend(["usd"])
    assert not backend.is_backend_set()


def test_the_app_updates_and_the_timeline_plays(stage):
    numbers = []
    app_utils.update_app(steps=5, callback=lambda number, steps: numbers.append(number) or number < 3)
    assert numbers == [1, 2, 3]
    app_utils.play()
    assert app_utils.is_playing()
    app_utils.pause()
    assert app_utils.is_paused()
    app_utils.stop()
    assert app_utils.is_stopped()
