"""Poses, animations and timeline settings that `rep.modify` writes."""

import math

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdSkel

import usdsdg as rep
from tests.stage.poses.euler import compose_euler
from usdsdg.errors import BadPrim, GraphError
from usdsdg.graph import evaluate
from usdsdg.modify import poses
from usdsdg.session.stage_context import current_stage, new_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.poses import transforms
from usdsdg.stage.poses.xform_ops import author_pose


def run():
    evaluate.graph().evaluate()


def matrix(stage, path):
    return np.array(transforms.local_to_world(stage.GetPrimAtPath(path)))


def box(stage, path):
    cache = UsdGeom.BBoxCache(0, [UsdGeom.Tokens.default_])
    found = cache.ComputeWorldBound(stage.GetPrimAtPath(path)).ComputeAlignedRange()
    return np.array([found.GetMin(), found.GetMax()])


@pytest.fixture
def cube(stage):
    prim = UsdGeom.Cube.Define(stage, "/World/cube")
    prim.CreateSizeAttr(2.0)
    return str(prim.GetPath())


def test_setting_a_single_axis_keeps_the_others(stage, cube):
    rep.modify.pose(position=(1, 2, 3), rotation=(10, 20, 30), input_prims=cube)
    run()
    rep.modify.pose(position_z=-1, rotation_x=45, rotation_z=rep.distribution.uniform(90, 91), input_prims=cube)
    run()
    prim = stage.GetPrimAtPath(cube)
    assert prim.GetAttribute("xformOp:translate").Get() == (1, 2, -1)
    x, y, z = prim.GetAttribute("xformOp:rotateXYZ").Get()
    assert (x, y) == (45, 20)
    assert 90 <= z < 91


def test_a_single_axis_may_be_given_per_prim(stage):
    cubes = rep.create.cube(count=3, position=(5, 5, 5))
    rep.modify.pose(position_x=[1, 2, 3], input_prims=cubes)
    run()
    assert [matrix(stage, path)[3, :3].tolist() for path in cubes.prims] == [[1, 5, 5], [2, 5, 5], [3, 5, 5]]


def test_a_single_axis_of_a_prim_with_a_matrix_or_an_orient_op(stage):
    rotation = Gf.Rotation(Gf.Vec3d(0, 0, 1), 30)
    xform = UsdGeom.Xform.Define(stage, "/World/matrix")
    xform.AddTransformOp().Set(Gf.Matrix4d(rotation, Gf.Vec3d(1, 2, 3)))
    other = UsdGeom.Xform.Define(stage, "/World/orient")
    other.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    other.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(rotation.GetQuat()))
    both = ["/World/matrix", "/World/orient"]
    rep.modify.pose(position_y=7, rotation_x=90, input_prims=both)
    run()
    expected = compose_euler((1, 7, 3), (90, 0, 30))
    for path in both:
        np.testing.assert_allclose(matrix(stage, path), expected, atol=1e-6)


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "zyx"])
def test_rotation_order_defines_the_order_of_the_axes(stage, cube, order):
    rep.modify.pose(rotation=(20, 40, 60), rotation_order=order, input_prims=cube)
    run()
    rotations = [np.array(Gf.Matrix3d(Gf.Rotation(Gf.Vec3d(*np.eye(3)[i]), a))) for i, a in enumerate((20, 40, 60))]
    first, second, third = (rotations["XYZ".index(axis)] for axis in order.upper())
    np.testing.assert_allclose(matrix(stage, cube)[:3, :3], first @ second @ third, atol=1e-6)


@pytest.mark.parametrize(("size", "scale"), [((10, 5, 2), 2), (3, 3)])
def test_size_is_one_scale_with_which_the_prim_fits(stage, cube, size, scale):
    rep.modify.pose(size=size, rotation=(0, 0, 90), input_prims=cube)
    run()
    np.testing.assert_allclose(np.diff(box(stage, cube), axis=0)[0], (scale,) * 3, atol=1e-6)


def test_size_of_shapes_is_that_of_replicator(stage):
    rep.settings.set_stage_up_axis("Y")
    rep.settings.set_stage_meters_per_unit(0.01)
    cube, torus = rep.create.cube(), rep.create.torus()
    rep.modify.pose(size=(1000, 500, 200), input_prims=cube)
    rep.modify.pose(size=300, input_prims=torus)
    run()
    for item in (cube, torus):
        scale = stage.GetPrimAtPath(item.prims[0]).GetAttribute("xformOp:scale").Get()
        np.testing.assert_allclose(scale, (2, 2, 2), rtol=1e-6)


@pytest.mark.parametrize("rotation", [(0, 0, 0), (0, 0, 30), (45, 20, 10)])
def test_size_and_pivot_do_not_depend_on_the_rotation_before(stage, rotation):
    """The box is along the axes of the prim, whose parts are turned with it."""
    group = UsdGeom.Xform.Define(stage, "/World/Group").GetPrim()
    rep.modify.pose(rotation=rotation, input_prims=group)
    for k, turn in enumerate((0, 30, 70)):
        part = UsdGeom.Cube.Define(stage, f"/World/Group/part_{k}").GetPrim()
        author_pose(part, translate=(3 * k, k, 0), rotate_xyz=(turn, 0, 0))
    run()
    halves = np.array([math.cos(turn) + math.sin(turn) for turn in np.radians([0, 30, 70])])  # along y and z
    top, bottom = max(halves + np.arange(3)), min(np.arange(3) - halves)
    lengths = np.array([8, top - bottom, 2 * max(halves)])
    rep.modify.pose(size=(4, 2, 1), input_prims=group)
    rep.modify.pose(pivot=(0, 0, 1), position=(0, 0, 0), input_prims=group)
    run()
    np.testing.assert_allclose(group.GetAttribute("xformOp:scale").Get(), [min((4, 2, 1) / lengths)] * 3, rtol=1e-6)
    np.testing.assert_allclose(group.GetAttribute("xformOp:translate:pivot").Get()[2], lengths[2] / 2, rtol=1e-6)


@pytest.mark.parametrize("rotation", [(0, 0, 45), (30, 40, 50)])
def test_size_and_pivot_of_one_rotated_gprim_stay_at_each_execution(stage, rotation):
    cube = rep.create.cube(scale=(1, 2, 3), rotation=rotation)
    prim = stage.GetPrimAtPath(cube.prims[0])
    for _ in range(3):
        rep.modify.pose(size=(4, 5, 6), input_prims=cube)
        rep.modify.pose(pivot=(1, 1, 1), position=(0, 0, 0), input_prims=cube)
        run()
        np.testing.assert_allclose(prim.GetAttribute("xformOp:scale").Get(), (4, 4, 4), rtol=1e-6)
        np.testing.assert_allclose(prim.GetAttribute("xformOp:translate:pivot").Get(), (0.5, 0.5, 0.5), rtol=1e-6)


def test_size_is_that_of_the_axes_with_an_extent(stage):
    plane = rep.create.plane(scale=(1, 1, 2))
    rep.modify.pose(size=4, input_prims=plane)
    run()
    assert stage.GetPrimAtPath(plane.prims[0]).GetAttribute("xformOp:scale").Get() == (4, 4, 4)


@pytest.mark.parametrize("rotation", [(0, 0, 0), (0, 0, 45), (90, 0, 0)])
def test_position_and_rotation_refer_to_the_pivot(stage, rotation):
    # The tip of a cone two units high.
    cone = rep.create.cone(position=(1, 2, 3), rotation=rotation, scale=2, pivot=(0, 0, 1))
    tip = matrix(stage, f"{cone.prims[0]}/Cone")
    np.testing.assert_allclose(np.array([0, 0, 0.5, 1]) @ tip, (1, 2, 3, 1), atol=1e-6)


def test_a_pivot_can_be_changed_and_is_kept_by_other_changes(stage, cube):
    for pivot, center in (((0, 0, -1), (0, 0, 1)), ((1, 0, 0), (-1, 0, 0))):
        rep.modify.pose(pivot=pivot, input_prims=cube)
        run()
        np.testing.assert_allclose(matrix(stage, cube)[3, :3], center, atol=1e-6)
    rep.modify.pose(position=(0, 0, 5), rotation=(0, 0, 180), input_prims=cube)
    run()
    np.testing.assert_allclose(matrix(stage, cube)[3, :3], (1, 0, 5), atol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"position": 1, "position_x": 1}, "position or position_x"),
        ({"rotation": 1, "rotation_z": 1}, "rotation or rotation_z"),
        ({"scale": 1, "size": 1}, "scale or size"),
        ({"rotation": 1, "look_at": (0, 0, 0)}, "rotation or look_at"),
        ({"rotation_y": 1, "look_at": (0, 0, 0)}, "rotation or look_at"),
        ({"rotation": 1, "rotation_order": "XXZ"}, "rotation_order='XXZ'; known: XYZ"),
    ],
)
def test_mutually_exclusive_arguments_raise_errors(stage, cube, arguments, message):
    with pytest.raises(ValueError, match=message) as caught:
        rep.modify.pose(**arguments, input_prims=cube)
    assert isinstance(caught.value, GraphError)


def test_size_and_pivot_of_a_prim_without_geometry_raise_errors(stage):
    rep.modify.pose(size=1, input_prims=rep.create.xform())
    with pytest.raises(GraphError, match="has no extent"):
        run()


def view_direction(stage, path):
    return tuple(UsdGeom.Camera(stage.GetPrimAtPath(path)).GetCamera(0).frustum.ComputeViewDirection())


def up_direction(stage, path):
    return np.array(UsdGeom.Camera(stage.GetPrimAtPath(path)).GetCamera(0).frustum.ComputeUpVector())


def test_look_at_several_prims_uses_their_mean_position(stage):
    targets = rep.create.sphere(count=2, position=[(0, 4, 0), (0, 8, 0)])
    cameras = rep.create.camera(count=2, position=[(6, 0, 0), (0, 0, 6)])
    rep.modify.pose(look_at=targets, input_prims=cameras)
    run()
    for path, eye in zip(cameras.prims, ((6, 0, 0), (0, 0, 6))):
        expected = np.subtract((0, 6, 0), eye) / math.sqrt(72)
        np.testing.assert_allclose(view_direction(stage, f"{path}/Camera"), expected, atol=1e-6)


def test_the_up_axis_is_up_in_the_image_even_under_a_rotated_parent(stage):
    parent = UsdGeom.Xform.Define(stage, "/World/arm")
    parent.AddRotateXYZOp().Set(Gf.Vec3f(30, 40, 50))
    parent.AddScaleOp().Set(Gf.Vec3f(2))
    camera = rep.create.camera(parent="/World/arm", position=(1, 0, 0))
    rep.modify.pose(look_at=(9, 9, 9), look_at_up_axis=(1, 0, 0), input_prims=camera)
    run()
    path = f"{camera.prims[0]}/Camera"
    eye = matrix(stage, camera.prims[0])[3, :3]
    forward = (np.array([9, 9, 9]) - eye) / np.linalg.norm(np.array([9, 9, 9]) - eye)
    np.testing.assert_allclose(view_direction(stage, path), forward, atol=1e-6)
    upwards = np.array([1, 0, 0]) - forward[0] * forward
    np.testing.assert_allclose(up_direction(stage, path), upwards / np.linalg.norm(upwards), atol=1e-6)


@pytest.mark.parametrize("axis", ["X", "y", "Z"])
def test_the_up_axis_may_be_a_letter(stage, axis):
    direction = tuple(float(each == axis.upper()) for each in "XYZ")
    poses = []
    for up in (axis, direction):
        looking = rep.create.cube(position=(3, 4, 5), look_at=(0, 0, 0), look_at_up_axis=up)
        later = rep.create.cube(position=(3, 4, 5))
        rep.modify.pose(look_at=(0, 0, 0), look_at_up_axis=up, input_prims=later)
        run()
        poses += [matrix(stage, looking.prims[0]), matrix(stage, later.prims[0])]
    np.testing.assert_allclose(poses, [poses[0]] * 4, atol=1e-6)
    with pytest.raises(GraphError, match="look_at_up_axis is 'up'"):
        rep.create.cube(look_at=(1, 1, 1), look_at_up_axis="up")


@pytest.mark.parametrize("kind", ["item", "prim", "path"])
def test_targets_that_are_drawn_may_be_items_prims_or_paths(stage, kind):
    items = [rep.create.cube(position=place) for place in ((3, 0, 0), (0, 3, 0))]
    forms = {"item": items, "prim": [each.get_output_prims()["prims"][0] for each in items]}
    targets = forms.get(kind, [item.prims[0] for item in items])
    camera = rep.create.camera()
    with rep.trigger.on_frame(), camera:
        rep.modify.pose(look_at=rep.distribution.sequence(targets))
    for axis in (0, 1, 0):
        evaluate.graph().evaluate(preview=True)
        child = stage.GetPrimAtPath(camera.prims[0]).GetChildren()[0].GetPath()
        np.testing.assert_allclose(-matrix(stage, child)[2, :3], np.eye(3)[axis], atol=1e-6)


def anywhere():
    return rep.distribution.uniform((-5, -5, -5), (5, 5, 5))


def looking(target):
    """Make prims of many kinds that are moved and look at what `target` returns of their items and paths."""
    rep.set_global_seed(3)
    arm = UsdGeom.Xform.Define(current_stage(), "/World/arm")
    arm.AddRotateXYZOp().Set(Gf.Vec3f(30, 40, 50))
    arm.AddScaleOp().Set(Gf.Vec3f(2, 3, 2))
    far = UsdGeom.Xform.Define(current_stage(), "/World/arm/far")
    far.SetResetXformStack(True)
    turned = UsdGeom.Cube.Define(current_stage(), "/World/arm/turned")
    turned.AddOrientOp()
    placed = UsdGeom.Cube.Define(current_stage(), "/World/placed")
    placed.AddTransformOp().Set(Gf.Matrix4d(Gf.Rotation((1, 2, 3), 40.0), Gf.Vec3d(1, 2, 3)))
    paths = [str(each.GetPath()) for each in (far, turned, placed)]
    items = [
        rep.create.camera(count=2), rep.create.stereo_camera(stereo_baseline=0.1), rep.create.cube(count=3),
        rep.create.cone(position=(3, 4, 5)), rep.create.light(light_type="sphere", parent="/World/arm"),
        rep.create.camera(parent="/World/arm"),
    ]  # fmt: skip
    with rep.trigger.on_frame():
        moved = [*paths, *(path for item in (*items[:3], *items[4:]) for path in item.prims)]
        options = {} if target == "point" else {"look_at_up_axis": rep.distribution.uniform((1, 1, 1), (2, 2, 2))}
        rep.modify.pose(input_prims=moved, position=anywhere(), look_at=TARGETS[target](items), **options)


TARGETS = {
    "point": lambda items: (0.5, 0.25, 0),
    "points": lambda items: anywhere(),
    "a prim that stays": lambda items: items[3],
    "prims of them": lambda items: items[2],
    "any of two": lambda items: rep.distribution.choice([items[3], items[2]]),
}


@pytest.mark.parametrize("target", TARGETS)
def test_prims_that_look_in_one_batch_do_what_one_does_after_the_other(target, monkeypatch):
    texts = []
    for batch in (poses._pose_all, lambda *_: False):
        monkeypatch.setattr(poses, "_pose_all", batch)
        stage = new_stage()
        looking(target)
        texts.append([])
        for capture in range(3):
            evaluate.graph().evaluate(capture=capture)
            texts[-1].append(stage.GetRootLayer().ExportToString())
    assert texts[0] == texts[1]
    assert len(set(texts[0])) == 3


def test_prims_below_others_that_are_posed_look_from_where_they_are_then(stage):
    arms = rep.create.group([rep.create.xform(name="arm"), rep.create.xform(name="other")])
    cameras = [rep.create.camera(parent=path, position=(1, 0, 0)) for path in arms.prims]
    everything = [*arms.prims, *(path for camera in cameras for path in camera.prims)]
    with rep.trigger.on_frame():
        rep.modify.pose(input_prims=everything, position=anywhere(), look_at=(0, 0, 9))
    for capture in (1, 2):
        evaluate.graph().evaluate(capture=capture)
        for camera in cameras:
            path = f"{camera.prims[0]}/Camera"
            forward = (0, 0, 9) - matrix(stage, path)[3, :3]
            np.testing.assert_allclose(view_direction(stage, path), forward / np.linalg.norm(forward), atol=1e-5)


def test_look_at_works_for_a_target_straight_below(stage):
    camera = rep.create.camera(position=(0, 0, 5), look_at=(0, 0, 0))
    np.testing.assert_allclose(view_direction(stage, f"{camera.prims[0]}/Camera"), (0, 0, -1), atol=1e-6)


@pytest.mark.parametrize("position", [(0, 0), (0.5, -0.25), (-1, 1)])
def test_camera_relative_positions_project_to_the_requested_pixels(stage, position):
    camera = rep.create.camera(position=(3, 2, 1), look_at=(0, 0, 0.5), horizontal_aperture_offset=2.0)
    product = rep.create.render_product(camera, (640, 480))
    parent = UsdGeom.Xform.Define(stage, "/World/shelf")
    parent.AddTranslateOp().Set(Gf.Vec3d(7, 0, 0))
    ball = rep.create.sphere(parent="/World/shelf")
    rep.modify.pose_camera_relative(camera, product, 4.0, *position, input_prims=ball)
    run()
    view = read_camera(stage, product.camera_path, (640, 480))
    point = matrix(stage, ball.prims[0])[None, 3, :3]
    pixels, _ = view.project(point)
    np.testing.assert_allclose(pixels[0], (640 * (1 + position[0]) / 2, 480 * (1 - position[1]) / 2), atol=1e-3)
    assert np.linalg.norm(point - view.local_to_world[3, :3]) == pytest.approx(4.0)


def animated(stage, path, positions):
    """An Xform that is at a position at each time code."""
    xform = UsdGeom.Xform.Define(stage, path)
    op = xform.AddTranslateOp()
    op.Set(Gf.Vec3d(100, 100, 100))
    for time, position in enumerate(positions):
        op.Set(Gf.Vec3d(*position), float(time))
    stage.SetTimeCodesPerSecond(24)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(len(positions) - 1)
    return xform


PATH = [(0, 0.5 * time, 0.1 * time) for time in range(9)]


def steps(count=4):
    """Step through an animation, a time code per frame; yield the time code of each picture."""
    for frame in range(count):
        rep.orchestrator.step(delta_time=1 / 24)
        yield frame


@pytest.mark.parametrize("what", ["pose", "orbit"])
def test_cameras_look_at_where_an_animated_prim_is_in_the_picture(stage, what):
    animated(stage, "/World/target", PATH)
    camera = rep.create.camera()
    with rep.trigger.on_frame(), camera:
        if what == "pose":
            rep.modify.pose(position=(6, 0, 1), look_at="/World/target")
        else:
            rep.modify.pose_orbit(barycentre="/World/target", distance=5, azimuth=30, elevation=20)
    product = rep.create.render_product(camera, (8, 6))
    for time in steps():
        pixels, _ = read_camera(stage, product.camera_path, (8, 6)).project(np.array([PATH[time]], float))
        np.testing.assert_allclose(pixels[0], (4, 3), atol=1e-4)


def test_camera_relative_positions_follow_an_animated_camera_and_parent(stage):
    animated(stage, "/World/shelf", PATH)
    ball = rep.create.sphere(parent="/World/shelf")
    rail = animated(stage, "/World/rail", [(y, z, x) for x, y, z in PATH])
    camera = UsdGeom.Camera.Define(stage, rail.GetPath().AppendChild("camera"))
    product = rep.create.render_product(str(camera.GetPath()), (64, 48))
    with rep.trigger.on_frame():
        rep.modify.pose_camera_relative(str(camera.GetPath()), product, 4.0, 0.5, 0.0, input_prims=ball)
    for time in steps():
        view = read_camera(stage, product.camera_path, (64, 48), time=time)
        point = transforms.local_to_world(stage.GetPrimAtPath(ball.prims[0]), time).ExtractTranslation()
        pixels, _ = view.project(np.array([point]))
        np.testing.assert_allclose(pixels[0], (48, 24), atol=1e-4)


def test_size_and_pivot_are_of_the_box_at_the_time(stage, cube):
    size = UsdGeom.Cube(stage.GetPrimAtPath(cube)).GetSizeAttr()
    size.Set(4.0, 0.0)
    stage.GetPrimAtPath(cube).GetAttribute("extent").Clear()
    rep.modify.pose(size=(2, 2, 2), pivot=(0, 0, 1), input_prims=cube)
    run()
    np.testing.assert_allclose(stage.GetPrimAtPath(cube).GetAttribute("xformOp:scale").Get(), (0.5, 0.5, 0.5))
    np.testing.assert_allclose(stage.GetPrimAtPath(cube).GetAttribute("xformOp:translate:pivot").Get(), (0, 0, 2))


def test_functions_and_immediate_changes_look_at_a_prim_as_it_is_now(stage):
    animated(stage, "/World/target", PATH)
    get_timeline().set_current_time(4 / 24)
    cameras = [rep.create.camera(position=(6, 0, 0), look_at="/World/target").prims[0]]
    cameras.append(str(rep.functional.create.camera(position=(6, 0, 0), look_at="/World/target").GetPath()))
    expected = np.subtract(PATH[4], (6, 0, 0)) / np.linalg.norm(np.subtract(PATH[4], (6, 0, 0)))
    for path in cameras:
        prim = stage.GetPrimAtPath(path)
        eye = path if prim.IsA(UsdGeom.Camera) else f"{path}/Camera"
        np.testing.assert_allclose(view_direction(stage, eye), expected, atol=1e-6)


def test_camera_relative_positions_follow_the_lens_model(stage):
    camera = rep.create.camera(position=(3, 2, 1), look_at=(0, 0, 0.5), projection_type="fisheyePolynomial")
    product = rep.create.render_product(camera, (640, 400))
    ball = rep.create.sphere()
    rep.modify.pose_camera_relative(camera, product, 4.0, 0.4, -0.6, input_prims=ball)
    run()
    view = read_camera(stage, product.camera_path, (640, 400))
    point = matrix(stage, ball.prims[0])[None, 3, :3]
    np.testing.assert_allclose(view.project(point)[0][0], (640 * 0.7, 400 * 0.8), atol=1e-3)
    assert np.linalg.norm(point - view.local_to_world[3, :3]) == pytest.approx(4.0)


def test_camera_relative_positions_outside_the_field_of_view_raise_errors(stage):
    camera = rep.create.camera(projection_type="fisheyePolynomial")
    product = rep.create.render_product(camera, (640, 400))
    rep.modify.pose_camera_relative(camera, product, 4.0, 1.0, 1.0, input_prims=rep.create.sphere())
    with pytest.raises(GraphError, match=r"Camera sees nothing at horizontal_location 1, vertical_location 1"):
        run()


def test_orbits_keep_their_distance_and_look_at_the_center(stage):
    center = rep.create.sphere(position=(1, 2, 3))
    cameras = rep.create.camera(count=20)
    rep.modify.pose_orbit(
        center,
        distance=5.0,
        azimuth=rep.distribution.uniform(-180, 180),
        elevation=rep.distribution.uniform(10, 80),
        input_prims=cameras,
    )
    run()
    positions = np.array([matrix(stage, path)[3, :3] for path in cameras.prims]) - (1, 2, 3)
    np.testing.assert_allclose(np.linalg.norm(positions, axis=1), 5.0, atol=1e-6)
    assert len(np.unique(positions.round(6), axis=0)) == 20
    assert (positions[:, 2] > 0).all()
    for path, position in zip(cameras.prims, positions):
        np.testing.assert_allclose(view_direction(stage, f"{path}/Camera"), -position / 5, atol=1e-5)


@pytest.mark.parametrize(
    ("up", "azimuth", "expected"),
    [("Z", 0, (2, 0, 0)), ("Z", 90, (0, 2, 0)), ("Y", 0, (2, 0, 0)), ("Y", 90, (0, 0, 2))],
)
def test_azimuth_is_the_angle_around_the_up_axis_from_x(stage, cube, up, azimuth, expected):
    UsdGeom.SetStageUpAxis(stage, up)
    rep.modify.pose_orbit((0, 0, 0), 2, azimuth, 0, look_at_barycentre=False, input_prims=cube)
    run()
    np.testing.assert_allclose(matrix(stage, cube)[3, :3], expected, atol=1e-6)
    np.testing.assert_allclose(matrix(stage, cube)[:3, :3], np.eye(3), atol=1e-6)


def test_each_prim_may_have_its_own_orbit_and_image_position(stage):
    balls = rep.create.sphere(count=2)
    rep.modify.pose_orbit([(0, 0, 0), (5, 0, 0)], [1, 2], [0, 90], [90, 0], input_prims=balls)
    run()
    np.testing.assert_allclose([matrix(stage, path)[3, :3] for path in balls.prims], [(0, 0, 1), (5, 2, 0)], atol=1e-6)
    camera = rep.create.camera()
    product = rep.create.render_product(camera, (64, 64))
    rep.modify.pose_camera_relative(camera, product, [1, 2], input_prims=balls)
    run()
    np.testing.assert_allclose(
        [matrix(stage, path)[3, :3] for path in balls.prims], [(-1, 0, 0), (-2, 0, 0)], atol=1e-6
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda cube: rep.modify.pose_orbit((0, 0, 0), "far", 0, 0, input_prims=cube), "distance is 'far'"),
        (lambda cube: rep.modify.pose_orbit((0, 0), 1, 0, 0, input_prims=cube), r"barycentre is \(0, 0\)"),
        (lambda cube: rep.modify.pose(position_x=[1, 2], input_prims=cube), r"position_x is \[1, 2\]; expected one"),
        (lambda cube: rep.modify.pose(look_at="/World/nothing", input_prims=cube), "no prim /World/nothing"),
    ],
)
def test_errors_of_invalid_positions_name_the_script_line(stage, cube, make, message):
    make(cube)
    with pytest.raises(GraphError, match=rf"test_pose\.py:\d+\).*{message}"):
        run()


def test_camera_relative_positions_need_one_camera_and_a_render_product(stage, cube):
    cameras = rep.create.camera(count=2)
    product = rep.create.render_product(cameras.prims[0], (8, 8))
    with pytest.raises(GraphError, match="camera is 2 prims; give one"):
        rep.modify.pose_camera_relative(cameras, product, 1.0, input_prims=cube)
    with pytest.raises(BadPrim, match="/Render/HydraTextures/Nothing"):
        rep.modify.pose_camera_relative(cameras.prims[0], "/Render/HydraTextures/Nothing", 1.0, input_prims=cube)
    with pytest.raises(GraphError, match="render_product /World has no resolution"):
        rep.modify.pose_camera_relative(cameras.prims[0], "/World", 1.0, input_prims=cube)


def test_the_timeline_takes_seconds_and_frames(stage):
    clock = get_timeline()
    clock.reset()
    rep.modify.timeline(8.0, "end_time")
    rep.modify.timeline(60, "Start_Frame")
    rep.modify.frame(90)
    assert (clock.get_start_time(), clock.get_current_time(), clock.get_end_time()) == (1.0, 1.5, 8.0)
    with rep.trigger.on_custom_event("go"):
        rep.modify.time(rep.distribution.uniform(2.0, 3.0))
    assert clock.get_current_time() == 1.5
    rep.utils.send_og_event("go")
    run()
    assert 2.0 <= clock.get_current_time() < 3.0
    clock.reset()


def test_an_unknown_modify_type_raises_an_error(stage):
    with pytest.raises(GraphError, match=r"modify_type='seconds'; known: time, start_time"):
        rep.modify.timeline(1.0, "seconds")


def test_animations_are_bound_to_the_skeleton(stage):
    UsdSkel.Root.Define(stage, "/World/person")
    skeleton = UsdSkel.Skeleton.Define(stage, "/World/person/skeleton")
    clips = [str(UsdSkel.Animation.Define(stage, f"/World/{name}").GetPath()) for name in ("walk", "run", "wave")]
    get_timeline().set_current_time(1.0)
    with rep.trigger.on_custom_event("go"):
        rep.modify.animation(clips, reset_timeline=True, input_prims="/World/person")
    seen = set()
    for _ in range(12):
        rep.utils.send_og_event("go")
        run()
        seen |= {str(path) for path in UsdSkel.BindingAPI(skeleton).GetAnimationSourceRel().GetTargets()}
    assert seen == set(clips)
    assert get_timeline().get_current_time() == 0.0


def test_an_animation_that_is_bound_plays(stage, cube):
    UsdSkel.Animation.Define(stage, "/World/walk")
    skeleton = UsdSkel.Skeleton.Define(stage, "/World/skeleton")
    rep.modify.animation("/World/walk", input_prims=[cube, "/World/skeleton"])
    assert not get_timeline().is_playing()
    run()
    assert get_timeline().is_playing()
    assert UsdSkel.BindingAPI(skeleton).GetAnimationSourceRel().GetTargets() == ["/World/walk"]


def test_animating_prims_without_any_skeleton_raises_an_error(stage, cube):
    UsdSkel.Animation.Define(stage, "/World/walk")
    rep.modify.animation("/World/walk", input_prims=cube)
    with pytest.raises(GraphError, match="/World/cube: there is no Skeleton"):
        run()
    assert not get_timeline().is_playing()


def test_functions_of_scripts_can_be_registered_in_modify(stage, cube):
    def lift(height, input_prims=None):
        return rep.modify.pose(position_z=height, input_prims=input_prims)

    rep.modify.register(lift)
    rep.modify.lift(4, input_prims=cube)
    run()
    assert matrix(stage, cube)[3, 2] == 4
    with pytest.raises(ValueError, match=r"'lift' exists"):
        rep.modify.register(lift, override=False)
    with pytest.raises(ValueError, match=r"'two words' is not a valid name"):
        rep.modify.register(lift, fn_name="two words")
    del rep.modify.lift


def test_a_position_under_a_parent_of_zero_scale_raises_an_error(stage):
    parent = UsdGeom.Xform.Define(stage, "/World/nothing")
    parent.AddScaleOp().Set(Gf.Vec3f(0))
    ball = rep.create.sphere(parent="/World/nothing")
    rep.modify.pose_orbit((0, 0, 0), 1, 0, 0, input_prims=ball)
    with pytest.raises(GraphError, match="an ancestor is scaled to zero"):
        run()
    assert issubclass(BadPrim, ValueError)
