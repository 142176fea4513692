"""Poses written into every kind of xform op stack; UsdGeom computes what they mean."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import BadPrim, DegenerateFrame
from usdsdg.stage.poses import transforms
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.poses.xform_ops import author_pose, gf_quat

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
TRANSLATE, DEGREES, SCALE = (1.0, -2.0, 3.0), (20.0, -35.0, 50.0), (2.0, 3.0, 0.5)


@pytest.fixture
def stage():
    return Usd.Stage.CreateInMemory()


@pytest.fixture
def xform(stage):
    return UsdGeom.Xform.Define(stage, "/World/a")


def rotation(degrees):
    return np.array(
        Gf.Matrix3d(
            Gf.Rotation(Gf.Vec3d.XAxis(), degrees[0])
            * Gf.Rotation(Gf.Vec3d.YAxis(), degrees[1])
            * Gf.Rotation(Gf.Vec3d.ZAxis(), degrees[2])
        )
    )


def expected(translate=(0, 0, 0), degrees=(0, 0, 0), scale=(1, 1, 1)):
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(scale) @ rotation(degrees)
    matrix[3, :3] = translate
    return matrix


def local(xform):
    return np.array(xform.GetLocalTransformation())


def order_of(xform):
    return list(xform.GetXformOpOrderAttr().Get())


# Floats of rotateXYZ have about seven digits, of half ops about three.
def assert_pose(xform, matrix, atol=1e-5):
    np.testing.assert_allclose(local(xform), matrix, atol=atol)


def test_a_bare_prim_gets_translate_rotate_scale(xform):
    author_pose(xform.GetPrim(), translate=TRANSLATE, rotate_xyz=DEGREES, scale=SCALE)
    assert order_of(xform) == ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]
    assert_pose(xform, expected(TRANSLATE, DEGREES, SCALE))


def test_ops_come_in_canonical_order_whatever_is_set_first(xform):
    prim = xform.GetPrim()
    author_pose(prim, scale=SCALE)
    author_pose(prim, translate=TRANSLATE)
    author_pose(prim, rotate_xyz=DEGREES)
    assert order_of(xform) == ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]
    assert_pose(xform, expected(TRANSLATE, DEGREES, SCALE))


def test_parts_that_are_not_given_stay(xform):
    prim = xform.GetPrim()
    author_pose(prim, translate=TRANSLATE, rotate_xyz=DEGREES, scale=SCALE)
    author_pose(prim, rotate_xyz=(0, 0, 0))
    assert_pose(xform, expected(TRANSLATE, (0, 0, 0), SCALE))


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("given", ["rotate_xyz", "orient"])
def test_rotation_is_written_in_the_order_of_the_existing_op(xform, order, given):
    xform.AddTranslateOp()
    getattr(xform, f"AddRotate{order}Op")()
    quat = Gf.Matrix3d(*rotation(DEGREES).ravel()).ExtractRotation().GetQuat()
    value = DEGREES if given == "rotate_xyz" else quat
    author_pose(xform.GetPrim(), translate=TRANSLATE, **{given: value})
    assert order_of(xform) == ["xformOp:translate", f"xformOp:rotate{order}"]
    assert_pose(xform, expected(TRANSLATE, DEGREES))


@pytest.mark.parametrize(
    ("precision", "kind", "atol"),
    [
        (UsdGeom.XformOp.PrecisionDouble, Gf.Quatd, 1e-12),
        (UsdGeom.XformOp.PrecisionFloat, Gf.Quatf, 1e-6),
        (UsdGeom.XformOp.PrecisionHalf, Gf.Quath, 5e-3),
    ],
)
@pytest.mark.parametrize("given", ["rotate_xyz", "orient"])
def test_orient_keeps_its_precision(xform, precision, kind, atol, given):
    op = xform.AddOrientOp(precision)
    quat = Gf.Matrix3d(*rotation(DEGREES).ravel()).ExtractRotation().GetQuat()
    author_pose(xform.GetPrim(), **{given: DEGREES if given == "rotate_xyz" else quat})
    assert type(op.Get()) is kind
    assert_pose(xform, expected(degrees=DEGREES), atol)


@pytest.mark.parametrize("precision", ["Double", "Float", "Half"])
def test_vector_ops_keep_their_precision(xform, precision):
    value = getattr(UsdGeom.XformOp, f"Precision{precision}")
    ops = [xform.AddTranslateOp(value), xform.AddRotateXYZOp(value), xform.AddScaleOp(value)]
    author_pose(xform.GetPrim(), translate=TRANSLATE, rotate_xyz=DEGREES, scale=SCALE)
    assert {type(op.Get()) for op in ops} == {getattr(Gf, f"Vec3{precision[0].lower()}")}
    assert_pose(xform, expected(TRANSLATE, DEGREES, SCALE))


def test_orient_on_a_bare_prim_adds_orient(xform):
    author_pose(xform.GetPrim(), scale=SCALE, orient=Gf.Quatf(0, 1, 0, 0))
    assert order_of(xform) == ["xformOp:orient", "xformOp:scale"]
    assert_pose(xform, expected(degrees=(180, 0, 0), scale=SCALE))


@pytest.mark.parametrize("order", ORDERS)
def test_three_single_axis_ops_are_an_euler_order(xform, order):
    xform.AddTranslateOp()
    for axis in reversed(order):
        getattr(xform, f"AddRotate{axis}Op")()
    before = order_of(xform)
    author_pose(xform.GetPrim(), rotate_xyz=DEGREES)
    assert order_of(xform) == before
    assert_pose(xform, expected(degrees=DEGREES))


@pytest.mark.parametrize("axes", ["Z", "XX", "ZX", "XYX"])
def test_other_single_axis_ops_give_way_to_rotate_xyz(xform, axes):
    xform.AddTranslateOp()
    for index, axis in enumerate(axes):
        getattr(xform, f"AddRotate{axis}Op")(opSuffix=f"s{index}").Set(30.0)
    xform.AddScaleOp().Set(Gf.Vec3f(SCALE))
    author_pose(xform.GetPrim(), rotate_xyz=DEGREES)
    assert order_of(xform) == ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]
    assert_pose(xform, expected(degrees=DEGREES, scale=SCALE))


def test_parts_of_a_matrix_op_are_exchanged_in_it(xform):
    xform.AddTransformOp().Set(Gf.Matrix4d(*expected((7, 8, 9), (5, 6, 7), SCALE).ravel()))
    prim = xform.GetPrim()
    author_pose(prim, translate=TRANSLATE)
    assert_pose(xform, expected(TRANSLATE, (5, 6, 7), SCALE), 1e-9)
    author_pose(prim, rotate_xyz=DEGREES)
    assert_pose(xform, expected(TRANSLATE, DEGREES, SCALE), 1e-9)
    author_pose(prim, scale=(1, 1, 1))
    assert_pose(xform, expected(TRANSLATE, DEGREES), 1e-9)
    assert order_of(xform) == ["xformOp:transform"]


def test_pivots_stay(xform):
    pivot = Gf.Vec3f(1, 0, 0)
    xform.AddTranslateOp(opSuffix="pivot").Set(pivot)
    xform.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
    author_pose(xform.GetPrim(), translate=TRANSLATE, rotate_xyz=(0, 0, 90), scale=(2, 2, 2))
    assert order_of(xform) == [
        "xformOp:translate",
        "xformOp:translate:pivot",
        "xformOp:rotateXYZ",
        "xformOp:scale",
        "!invert!xformOp:translate:pivot",
    ]
    # The pivot point is where the rotation and scale leave it: moved by the translation only.
    moved = xform.GetLocalTransformation().Transform(Gf.Vec3d(pivot))
    np.testing.assert_allclose(moved, np.add(TRANSLATE, pivot), atol=1e-6)


def test_reset_xform_stack_stays(xform):
    xform.AddTranslateOp()
    xform.SetResetXformStack(True)
    author_pose(xform.GetPrim(), translate=TRANSLATE, rotate_xyz=DEGREES, scale=SCALE)
    assert order_of(xform)[0] == "!resetXformStack!"
    assert xform.GetResetXformStack()
    assert_pose(xform, expected(TRANSLATE, DEGREES, SCALE))


def test_an_op_left_out_of_the_order_is_used_again(xform):
    """A script may clear the order and leave the attributes; adding the op must not fail on them."""
    xform.AddTranslateOp().Set(Gf.Vec3d(5, 5, 5))
    xform.AddScaleOp(UsdGeom.XformOp.PrecisionDouble)
    xform.ClearXformOpOrder()
    author_pose(xform.GetPrim(), scale=SCALE, translate=TRANSLATE)
    assert_pose(xform, expected(TRANSLATE, scale=SCALE))


def test_angles_beyond_a_turn_are_kept_as_given(xform):
    author_pose(xform.GetPrim(), rotate_xyz=(370.0, 0.0, -400.0))
    assert xform.GetPrim().GetAttribute("xformOp:rotateXYZ").Get() == Gf.Vec3f(370, 0, -400)


def test_both_forms_of_rotation_are_refused(xform):
    with pytest.raises(ValueError, match="either"):
        author_pose(xform.GetPrim(), rotate_xyz=DEGREES, orient=Gf.Quatf(1))


def test_a_prim_without_transform_is_refused(stage):
    with pytest.raises(BadPrim, match="/Looks: Scope has no transform"):
        author_pose(stage.DefinePrim("/Looks", "Scope"), translate=TRANSLATE)
    with pytest.raises(BadPrim, match="does not exist"):
        author_pose(stage.GetPrimAtPath("/nothing"), translate=TRANSLATE)


def test_a_prim_inside_an_instance_is_refused(stage):
    UsdGeom.Cube.Define(stage, "/proto/cube")
    instance = stage.DefinePrim("/instance", "Xform")
    instance.GetReferences().AddInternalReference("/proto")
    instance.SetInstanceable(True)
    with pytest.raises(BadPrim, match="/instance/cube: it lies inside an instance"):
        author_pose(stage.GetPrimAtPath("/instance/cube"), translate=TRANSLATE)


def test_local_to_world_and_back(stage):
    parent = UsdGeom.Xform.Define(stage, "/p")
    author_pose(parent.GetPrim(), translate=(1, 2, 3), rotate_xyz=(0, 0, 90))
    child = UsdGeom.Cube.Define(stage, "/p/c").GetPrim()
    author_pose(child, translate=(1, 0, 0))
    matrix = transforms.as_array(transforms.local_to_world(child))
    np.testing.assert_allclose(matrix[3, :3], (1, 3, 3), atol=1e-6)
    back = transforms.as_array(transforms.world_to_local(child))
    np.testing.assert_allclose(matrix @ back, np.eye(4), atol=1e-9)
    author_pose(child, scale=(0, 1, 1))
    with pytest.raises(DegenerateFrame, match="/p/c"):
        transforms.world_to_local(child)


def test_local_to_world_at_a_time(xform):
    op = xform.AddTranslateOp()
    op.Set(Gf.Vec3d(0, 0, 0), 0)
    op.Set(Gf.Vec3d(10, 0, 0), 10)
    assert transforms.local_to_world(xform.GetPrim(), Usd.TimeCode(5))[3][0] == 5


@pytest.mark.parametrize(
    ("eye", "target"), [((3, 4, 5), (0, 0, 0)), ((0, -2, 0), (1, 5, 2)), ((1e4, 0, 1), (1e4, 1, 1))]
)
def test_look_at_puts_the_target_on_the_optical_axis(eye, target):
    matrix = look_at_matrix(eye, target, up=(0, 0, 1))
    in_camera = matrix.GetInverse().Transform(Gf.Vec3d(*target))
    distance = np.linalg.norm(np.subtract(eye, target))
    np.testing.assert_allclose(in_camera, (0, 0, -distance), atol=1e-9)
    axes = np.array(matrix)[:3, :3]
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) > 0
    # +X is level and +Y leans up.
    assert abs(axes[0] @ (0, 0, 1)) < 1e-12
    assert axes[1] @ (0, 0, 1) > 0


def test_look_at_is_that_of_gf():
    view = Gf.Matrix4d().SetLookAt(Gf.Vec3d(3, 4, 5), Gf.Vec3d(1, 0, -1), Gf.Vec3d(0, 1, 0))
    ours = look_at_matrix(Gf.Vec3d(3, 4, 5), Gf.Vec3f(1, 0, -1), up=(0, 2, 0))
    assert Gf.IsClose(ours, view.GetInverse(), 1e-9)


@pytest.mark.parametrize(
    ("eye", "target", "up"),
    [
        ((1, 2, 3), (1, 2, 3), (0, 0, 1)),
        ((0, 0, 5), (0, 0, 0), (0, 0, 1)),
        ((1, 0, 0), (0, 0, 0), (0, 0, 0)),
        ((float("nan"), 0, 0), (0, 0, 0), (0, 0, 1)),
    ],
)
def test_look_at_without_a_frame(eye, target, up):
    with pytest.raises(DegenerateFrame):
        look_at_matrix(eye, target, up=up)


def test_units_and_up_axis(stage):
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, "Y")
    assert transforms.meters_per_unit(stage) == 0.01
    assert transforms.up_axis(stage) == "Y"


def test_gf_quat_orders_its_components():
    assert gf_quat([1, 2, 3, 4]) == Gf.Quatd(4, 1, 2, 3)


def test_authoring_goes_to_the_edit_target(stage, xform):
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        author_pose(xform.GetPrim(), translate=TRANSLATE)
    path = Sdf.Path("/World/a.xformOp:translate")
    assert stage.GetSessionLayer().GetAttributeAtPath(path)
    assert not stage.GetRootLayer().GetAttributeAtPath(path)


def test_the_product_of_ops_is_the_local_matrix(xform):
    xform.AddTranslateOp().Set(TRANSLATE)
    xform.AddRotateZYXOp().Set(DEGREES)
    xform.AddScaleOp().Set(SCALE)
    product = transforms.product_of_ops(op.GetOpTransform(Usd.TimeCode.Default()) for op in xform.GetOrderedXformOps())
    assert product == xform.GetLocalTransformation()
    assert transforms.product_of_ops([]) == Gf.Matrix4d(1)
