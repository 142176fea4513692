"""Xform ops that functional.modify.pose and its parts write, evaluated by UsdGeom."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.functional.poses import local, ops, value, world
from tests.stage.poses.euler import compose_euler
from usdsdg.errors import BadPrim, DegenerateFrame, GraphError, Unsupported
from usdsdg.functional import create, create_batch, modify


@pytest.fixture
def cube(stage):
    return create.cube(parent="/World")


@pytest.fixture
def cubes(stage):
    return create_batch.cube(count=3, parent="/World")


def test_one_value_for_all_prims(cubes):
    modify.pose(cubes, position_value=(1, 2, 3), rotation_value=(10, 20, 30), scale_value=(2, 3, 4))
    for cube in cubes:
        np.testing.assert_allclose(local(cube), compose_euler((1, 2, 3), (10, 20, 30), (2, 3, 4)), atol=1e-12)


@pytest.mark.parametrize("kind", [np.array, np.ndarray.tolist, lambda rows: [tuple(row) for row in rows.tolist()]])
def test_one_value_per_prim(cubes, kind):
    positions, degrees, scales = np.random.default_rng(0).uniform(1, 9, (3, 3, 3))
    modify.pose(cubes, kind(positions), kind(degrees), scale_value=kind(scales))
    for row, cube in enumerate(cubes):
        expected = compose_euler(positions[row], degrees[row], scales[row])
        np.testing.assert_allclose(local(cube), expected, atol=1e-12)


def test_parts_that_are_not_given_are_unchanged(cube):
    modify.pose(cube, (1, 2, 3), (10, 20, 30), scale_value=2.0)
    modify.position(cube, (4, 5, 6))
    np.testing.assert_allclose(local(cube), compose_euler((4, 5, 6), (10, 20, 30), (2, 2, 2)), atol=1e-12)
    modify.scale(cube, (1, 2, 1))
    modify.rotation(cube, (0, 0, 90))
    np.testing.assert_allclose(local(cube), compose_euler((4, 5, 6), (0, 0, 90), (1, 2, 1)), atol=1e-12)


def test_three_numbers_scale_three_prims_unless_they_are_a_tuple(cubes):
    modify.scale(cubes, np.array([1.0, 2.0, 3.0]))
    assert [value(cube, "xformOp:scale").tolist() for cube in cubes] == [[1, 1, 1], [2, 2, 2], [3, 3, 3]]
    modify.scale(cubes, (1.0, 2.0, 3.0))
    assert [value(cube, "xformOp:scale").tolist() for cube in cubes] == [[1, 2, 3]] * 3


def test_existing_xform_ops_are_used(stage):
    xform = UsdGeom.Xform.Define(stage, "/World/a")
    xform.AddTranslateOp(UsdGeom.XformOp.PrecisionFloat)
    xform.AddRotateZYXOp()
    modify.pose(xform.GetPrim(), (1, 2, 3), (10, 20, 30), scale_value=2)
    assert ops(xform.GetPrim()) == ["xformOp:translate", "xformOp:rotateZYX", "xformOp:scale"]
    np.testing.assert_allclose(local(xform.GetPrim()), compose_euler((1, 2, 3), (10, 20, 30), (2, 2, 2)), atol=1e-6)


def test_all_kinds_of_ops_in_one_call(stage):
    plain = stage.DefinePrim("/World/plain", "Xform")
    made = create.xform(parent="/World")
    euler = UsdGeom.Xform.Define(stage, "/World/euler")
    euler.AddTranslateOp()
    euler.AddRotateXYZOp()
    euler.AddScaleOp()
    matrix = UsdGeom.Xform.Define(stage, "/World/matrix")
    matrix.AddTransformOp()
    pivoted = UsdGeom.Xform.Define(stage, "/World/pivoted")
    UsdGeom.XformCommonAPI(pivoted).SetPivot((0, 0, 0))
    prims = [plain, made, euler.GetPrim(), matrix.GetPrim(), pivoted.GetPrim()]
    for shift in (0.0, 1.0):
        rows = np.arange(15.0).reshape(5, 3) + shift
        modify.pose(prims, rows, rows * 10, scale_value=rows + 1)
        for row, prim in zip(rows, prims):
            np.testing.assert_allclose(local(prim), compose_euler(row, row * 10, row + 1), atol=1e-4)
    assert ops(matrix.GetPrim()) == ["xformOp:transform"]


def test_angles_are_written_unchanged_to_a_rotate_op(stage):
    xform = UsdGeom.Xform.Define(stage, "/World/a")
    xform.AddRotateXYZOp()
    modify.rotation(xform.GetPrim(), (370, -20, 0))
    assert value(xform.GetPrim(), "xformOp:rotateXYZ").tolist() == [370, -20, 0]


@pytest.mark.parametrize(
    "rotation",
    [
        (0, 0, np.sqrt(0.5), np.sqrt(0.5)),
        np.array([0, 0, np.sqrt(0.5), np.sqrt(0.5)]),
        Gf.Rotation((0, 0, 1), 90),
        Gf.Quatf(np.sqrt(0.5), 0, 0, np.sqrt(0.5)),
        [Gf.Quatd(np.sqrt(0.5), 0, 0, np.sqrt(0.5))],
    ],
    ids=["tuple xyzw", "array xyzw", "Gf.Rotation", "Gf.Quatf", "list of Gf.Quatd"],
)
def test_quaternions_and_rotations(cube, rotation):
    modify.rotation(cube, rotation)
    np.testing.assert_allclose(local(cube), compose_euler(degrees=(0, 0, 90)), atol=1e-6)


def test_the_rotation_order_defines_the_axis_of_each_angle(cube):
    modify.rotation(cube, (10, 20, 30), "ZYX")
    turned = Gf.Rotation((0, 0, 1), 10) * Gf.Rotation((0, 1, 0), 20) * Gf.Rotation((1, 0, 0), 30)
    np.testing.assert_allclose(local(cube)[:3, :3], np.array(Gf.Matrix3d(turned)), atol=1e-12)


@pytest.mark.parametrize("position", [(2, 3, 4), (0, 0, 0.5)])
def test_look_at_points_minus_z_at_the_target_and_keeps_up(stage, position):
    camera = create.camera(parent="/World", position=position)
    modify.look_at(camera, (0, 1, 0), look_at_up_axis=(0, 0, 1))
    matrix = world(camera)
    toward = np.array([0, 1, 0]) - position
    np.testing.assert_allclose(-matrix[2, :3], toward / np.linalg.norm(toward), atol=1e-12)
    assert matrix[1, 2] > 0
    assert matrix[0, 2] == pytest.approx(0)


def test_look_at_below_a_rotated_and_translated_parent(stage):
    parent = create.xform(name="rig", position=(5, 0, 0), rotation=(30, 40, 50), scale=2)
    camera = create.camera(parent=parent, position=(1, 1, 1))
    target = create.sphere(position=(-3, 2, 1))
    modify.pose(camera, position_value=(0, 2, 0), look_at_value=target, look_at_up_axis=None)
    matrix = world(camera)
    toward = world(target)[3, :3] - matrix[3, :3]
    np.testing.assert_allclose(-matrix[2, :3] / 2, toward / np.linalg.norm(toward), atol=1e-12)


def test_each_prim_may_have_its_own_target(stage):
    targets = create_batch.sphere(count=2, parent="/World", position=[(9, 0, 0), (0, 9, 0)])
    lights = create_batch.rect_light(count=2, parent="/World", position=[(0, 0, 1), (0, 0, 2)])
    modify.look_at(lights, [targets[0], "/World/Sphere_01"])
    for light, target in zip(lights, targets):
        toward = world(target)[3, :3] - world(light)[3, :3]
        np.testing.assert_allclose(-world(light)[2, :3], toward / np.linalg.norm(toward), atol=1e-12)


def test_looking_straight_down_has_minus_x_up(stage):
    camera = create.camera(position=(0, 0, 5), look_at=(0, 0, 0))
    np.testing.assert_allclose(world(camera)[:3, :3], [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-12)


def test_looking_straight_down_has_minus_z_up_on_a_y_up_stage(y_up_stage):
    camera = create.camera(position=(0, 5, 0), look_at=(0, 0, 0))
    np.testing.assert_allclose(world(camera)[1, :3], [0, 0, -1], atol=1e-12)


def test_look_at_of_a_camera_object_points_its_camera_at_the_target(stage):
    import usdsdg as rep

    item = rep.create.camera(position=(3, 0, 0))
    modify.look_at(item, (0, 0, 0), look_at_up_axis=(0, 0, 1))
    camera = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Camera))
    np.testing.assert_allclose(-world(camera)[2, :3], [-1, 0, 0], atol=1e-6)


def test_relative_to_poses_in_the_space_of_another_prim(stage):
    rig = create.xform(name="rig", position=(1, 0, 0), rotation=(0, 0, 90))
    other = create.xform(name="other", position=(0, 7, 0))
    cube = create.cube(parent=other)
    modify.pose(cube, position_value=(2, 0, 0), rotation_value=(0, 0, 10), relative_to=rig)
    np.testing.assert_allclose(world(cube), compose_euler((1, 2, 0), (0, 0, 100)), atol=1e-12)
    modify.position(cube, (3, 0, 0), relative_to="/rig")
    np.testing.assert_allclose(world(cube), compose_euler((1, 3, 0), (0, 0, 100)), atol=1e-12)


def test_a_pivot_is_placed_at_the_position(cube):
    modify.pose(cube, position_value=(1, 2, 3), rotation_value=(0, 90, 0), scale_value=(1, 1, 4), pivot=(0, 0, -1))
    np.testing.assert_allclose((np.array([0, 0, -0.5, 1]) @ local(cube))[:3], (1, 2, 3), atol=1e-6)


def test_rotation_alone_keeps_the_position_of_the_pivot(cube):
    modify.position(cube, (1, 2, 3))
    corner = np.array([0.5, 0.5, 0.5, 1])
    before = corner @ local(cube)
    for _ in range(3):
        modify.rotation(cube, (0, 0, 45), pivot=(1, 1, 1))
        modify.scale(cube, 1.0)
    np.testing.assert_allclose(corner @ local(cube), before, atol=1e-6)


def test_each_instance_of_a_point_instancer_takes_one_value(stage):
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
    instancer.CreateProtoIndicesAttr([0, 0])
    modify.pose(instancer.GetPrim(), [(1, 2, 3), (4, 5, 6)], (0, 0, 90), scale_value=[1, 2])
    np.testing.assert_array_equal(instancer.GetPositionsAttr().Get(), [(1, 2, 3), (4, 5, 6)])
    np.testing.assert_array_equal(instancer.GetScalesAttr().Get(), [(1, 1, 1), (2, 2, 2)])
    turned = instancer.GetOrientationsAttr().Get()[1]
    assert turned.GetReal() == pytest.approx(np.sqrt(0.5), abs=1e-3)
    assert turned.GetImaginary()[2] == pytest.approx(np.sqrt(0.5), abs=1e-3)
    with pytest.raises(Unsupported, match="look_at"):
        modify.look_at(instancer.GetPrim(), (0, 0, 0))


def test_a_list_for_prims_and_point_instancers_has_a_value_for_each_prim_and_instance(stage):
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
    instancer.CreateProtoIndicesAttr([0, 0])
    shapes = [UsdGeom.Cube.Define(stage, f"/World/shape_{side}").GetPrim() for side in "ab"]
    points, sizes = np.arange(12.0).reshape(4, 3), np.array([[1, 1, 1], [2, 2, 2], [3, 3, 3], [4, 4, 4]])
    modify.pose([shapes[0], instancer.GetPrim(), shapes[1]], points, (0, 0, 90), scale_value=sizes)
    np.testing.assert_array_equal(instancer.GetPositionsAttr().Get(), points[1:3])
    np.testing.assert_array_equal(instancer.GetScalesAttr().Get(), sizes[1:3])
    for shape, row in zip(shapes, (0, 3)):
        np.testing.assert_allclose(local(shape), compose_euler(points[row], (0, 0, 90), sizes[row]), atol=1e-6)


def test_prims_that_became_point_instancers_take_values_for_instances(stage):
    prims = [UsdGeom.Xform.Define(stage, f"/World/{side}").GetPrim() for side in "ab"]
    modify.pose(prims, (1, 1, 1))
    prims[1].SetTypeName("PointInstancer")
    UsdGeom.PointInstancer(prims[1]).CreateProtoIndicesAttr([0, 0])
    points = np.arange(9.0).reshape(3, 3)
    modify.pose(prims, points)
    np.testing.assert_array_equal(UsdGeom.PointInstancer(prims[1]).GetPositionsAttr().Get(), points[1:])
    np.testing.assert_allclose(local(prims[0]), compose_euler(points[0], (0, 0, 0), (1, 1, 1)))


def test_xform_ops_that_a_script_removes_or_reorders_are_detected(cubes):
    modify.pose(cubes, (1, 1, 1), (0, 0, 0), scale_value=1)
    UsdGeom.Xformable(cubes[0]).SetXformOpOrder([])
    cubes[1].RemoveProperty("xformOp:scale")
    modify.pose(cubes, (2, 2, 2), (0, 0, 90), scale_value=3)
    for cube in cubes:
        np.testing.assert_allclose(local(cube), compose_euler((2, 2, 2), (0, 0, 90), (3, 3, 3)), atol=1e-6)


def test_poses_are_authored_in_the_edit_target(stage, cubes):
    modify.position(cubes, (1, 0, 0))
    over = Sdf.Layer.CreateAnonymous()
    stage.GetSessionLayer().subLayerPaths.append(over.identifier)
    with Usd.EditContext(stage, over):
        modify.position(cubes, (2, 0, 0))
    assert world(cubes[0])[3, 0] == 2
    assert stage.GetRootLayer().GetAttributeAtPath("/World/Cube.xformOp:translate").default == Gf.Vec3d(1, 0, 0)
    modify.position(cubes, (3, 0, 0))
    assert stage.GetRootLayer().GetAttributeAtPath("/World/Cube.xformOp:translate").default == Gf.Vec3d(3, 0, 0)


def test_only_what_is_written_is_added_to_the_layer(stage, tmp_path):
    made = Usd.Stage.CreateNew(str(tmp_path / "thing.usda"))
    thing = UsdGeom.Xform.Define(made, "/Thing")
    thing.AddTranslateOp().Set((1, 1, 1))
    thing.AddRotateXYZOp().Set((0, 0, 5))
    made.SetDefaultPrim(thing.GetPrim())
    made.Save()
    things = create_batch.reference(str(tmp_path / "thing.usda"), count=2)
    for _ in range(2):
        modify.position(things, (1, 2, 3))
        own = stage.GetRootLayer().GetPrimAtPath("/Ref").attributes
        assert [spec.name for spec in own] == ["xformOp:translate"]
    modify.rotation(things, [(0, 0, 7), (0, 0, 8)])
    modify.position(things, (4, 5, 6))
    for thing, angle in zip(things, (7, 8)):
        np.testing.assert_allclose(local(thing), compose_euler((4, 5, 6), (0, 0, angle)), atol=1e-6)


def test_poses_of_prims_of_two_stages_are_authored_in_their_own_layers(stage, cube):
    other = Usd.Stage.CreateInMemory()
    twin = UsdGeom.Cube.Define(other, "/World/Cube").GetPrim()
    for x in (1, 2):
        modify.position([cube, twin], [(x, 0, 0), (0, x, 0)])
        assert world(cube)[3, :3].tolist() == [x, 0, 0]
        assert world(twin)[3, :3].tolist() == [0, x, 0]


def test_posing_inside_a_variant(stage):
    shelf = stage.DefinePrim("/World/shelf", "Xform")
    variants = shelf.GetVariantSets().AddVariantSet("place")
    variants.AddVariant("a")
    variants.SetVariantSelection("a")
    with variants.GetVariantEditContext():
        modify.position(shelf, (1, 2, 3))
        modify.position(shelf, (4, 5, 6))
    assert world(shelf)[3, :3].tolist() == [4, 5, 6]
    variants.SetVariantSelection("")
    assert world(shelf)[3, :3].tolist() == [0, 0, 0]


def test_posing_a_thousand_prims_reports_each_change_once(stage):
    from usdsdg.stage.change_tracker import ChangeTracker

    cubes = create_batch.xform(count=1000, parent="/World")
    modify.pose(cubes, np.ones((1000, 3)), np.ones((1000, 3)), scale_value=np.ones((1000, 3)))
    tracker = ChangeTracker(stage)
    modify.pose(cubes, np.zeros((1000, 3)), np.zeros((1000, 3)), scale_value=np.full((1000, 3), 2.0))
    changes = tracker.take()
    assert not changes.resynced
    assert len(changes.changed) == 1000


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"position_value": (1, 2)}, "position is .1, 2.; expected three numbers"),
        ({"position_value": "up"}, "position is 'up'"),
        ({"position_value": (1, 2, float("nan"))}, "position is"),
        ({"rotation_value": (1, 2, 3, 4, 5)}, "quaternion"),
        ({"rotation_value": (1, 2, 3), "look_at_value": (0, 0, 1)}, "exclude each other"),
        ({"rotation_value": (1, 2, 3), "rotation_order": "XXZ"}, "rotation order is 'XXZ'"),
        ({"scale_value": [(1, 1, 1), (2, 2, 2)]}, "scale is"),
        ({"look_at_value": ["/World/Cube", "/World/Cube_01"]}, "look_at has 2 targets for 3 prims"),
    ],
)
def test_invalid_values_raise_errors(cubes, arguments, says):
    with pytest.raises(GraphError, match=says):
        modify.pose(cubes, **arguments)
    assert all((local(cube) == np.eye(4)).all() for cube in cubes)


def test_a_distribution_as_a_value_raises_an_error(cube):
    import usdsdg as rep

    with pytest.raises(GraphError, match="position is a distribution, but functional calls act at once"):
        modify.position(cube, rep.distribution.uniform((0, 0, 0), (1, 1, 1)))


def test_invalid_prims_raise_errors(stage, cube):
    material = stage.DefinePrim("/World/material", "Material")
    with pytest.raises(BadPrim, match="/World/material"):
        modify.position([cube, material], (1, 2, 3))
    with pytest.raises(BadPrim, match="no prim /World/nothing"):
        modify.position("/World/nothing", (1, 2, 3))
    stage.RemovePrim(cube.GetPath())
    with pytest.raises(BadPrim, match="does not exist any more"):
        modify.position(cube, (1, 2, 3))
    with pytest.raises(TypeError, match="expected a prim"):
        modify.position(3, (1, 2, 3))


def test_degenerate_frames_raise_errors(stage, cube):
    with pytest.raises(DegenerateFrame, match="own position"):
        modify.look_at(cube, (0, 0, 0))
    with pytest.raises(DegenerateFrame, match="zero vector"):
        modify.look_at(cube, (1, 0, 0), (0, 0, 0))
    flat = create.xform(name="flat", scale=(1, 1, 0))
    inside = create.cube(parent=flat)
    with pytest.raises(DegenerateFrame, match="/flat/Cube cannot be placed"):
        modify.position(inside, (1, 2, 3), relative_to=cube)
    with pytest.raises(BadPrim, match="/Xform has no extent"):
        modify.rotation(create.xform(), (0, 0, 90), pivot=(0, 0, 1))
