"""`Camera`: poses, lens, projection and images of one camera."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.sensors.camera import Camera, get_all_camera_objects
from usdsdg.errors import ArgumentError
from usdsdg.session.render_products import products
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.semantics.labels import add_labels


@pytest.fixture
def cube(stage):
    """A labeled unit cube at (3, 0, 0)."""
    cube = UsdGeom.Cube.Define(stage, "/World/cube")
    cube.CreateSizeAttr(1.0)
    cube.AddTranslateOp().Set(Gf.Vec3d(3, 0, 0))
    add_labels(cube.GetPrim(), {"class": ["cube"]})
    return cube


@pytest.fixture
def camera(cube):
    """At the origin, looking along +X with +Z up, 40 x 20 pixels."""
    camera = Camera("/World/Camera", resolution=(40, 20), position=(0, 0, 0))
    camera.set_clipping_range(0.1, 100.0)
    camera.initialize()
    return camera


# Poses


def test_the_default_orientation_looks_along_x_with_z_up(camera, stage):
    to_world = np.array(UsdGeom.Xformable(stage.GetPrimAtPath("/World/Camera")).ComputeLocalToWorldTransform(0))
    assert -to_world[2, :3] == pytest.approx([1, 0, 0], abs=1e-6)
    assert to_world[1, :3] == pytest.approx([0, 0, 1], abs=1e-6)


@pytest.mark.parametrize("axes", ["world", "ros", "usd"])
def test_poses_are_read_as_they_were_set(camera, axes):
    quaternion = np.array([0.5, 0.1, -0.3, 0.2]) / np.linalg.norm([0.5, 0.1, -0.3, 0.2])
    camera.set_world_pose((1, 2, 3), quaternion, camera_axes=axes)
    position, orientation = camera.get_world_pose(camera_axes=axes)
    assert position == pytest.approx([1, 2, 3])
    assert abs(orientation @ quaternion) == pytest.approx(1, abs=1e-6)
    camera.set_local_pose((0, 0, 1), quaternion, camera_axes=axes)
    translation, orientation = camera.get_local_pose(camera_axes=axes)
    assert translation == pytest.approx([0, 0, 1])
    assert abs(orientation @ quaternion) == pytest.approx(1, abs=1e-6)


def test_a_prim_that_is_no_camera_is_refused(cube):
    with pytest.raises(ArgumentError, match="Cube, not a camera"):
        Camera("/World/cube")


# Images


def test_there_are_no_images_before_the_first_update(camera):
    assert camera.get_rgb() is None
    assert camera.get_pointcloud().size == 0


def test_images_show_the_latest_update(camera, cube):
    camera.add_distance_to_image_plane_to_frame()
    get_app().update()
    assert camera.get_rgba().shape == (20, 40, 4)
    assert camera.get_rgb().shape == (20, 40, 3)
    assert camera.get_depth()[10, 20] == pytest.approx(2.5)
    UsdGeom.XformCommonAPI(cube).SetTranslate((5, 0, 0))
    get_app().update()
    assert camera.get_depth()[10, 20] == pytest.approx(4.5)


def test_the_frame_has_the_data_of_all_annotators_and_the_time(camera):
    camera.add_semantic_segmentation_to_frame()
    camera.add_bounding_box_2d_tight_to_frame()
    get_timeline().play()
    for _ in range(6):
        get_app().update()
    frame = camera.get_current_frame()
    assert set(frame) == {
        "rendering_time", "rendering_frame", "rgb", "rgba", "semantic_segmentation", "bounding_box_2d_tight",
    }  # fmt: skip
    assert frame["rgba"] is frame["rgb"]
    assert frame["rgba"].shape == (20, 40, 4)
    assert frame["rendering_time"] == pytest.approx(0.1, abs=1e-6)
    assert frame["bounding_box_2d_tight"]["info"]["idToLabels"] == {0: {"class": "cube"}}
    camera.remove_bounding_box_2d_tight_from_frame()
    assert "bounding_box_2d_tight" not in camera.get_current_frame()
    camera.remove_rgb_from_frame()
    assert not {"rgb", "rgba"} & set(camera.get_current_frame())


def test_before_anything_is_rendered_the_image_of_a_frame_is_black(camera):
    frame = camera.get_current_frame()
    assert frame["rgb"] is None
    assert frame["rgba"].shape == (20, 40, 4)
    assert not frame["rgba"].any()


def test_a_paused_camera_keeps_its_frame(camera):
    get_timeline().play()
    get_app().update()
    first = camera.get_current_frame(clone=True)["rendering_time"]
    camera.pause()
    get_app().update()
    assert camera.is_paused()
    assert camera.get_current_frame()["rendering_time"] == first
    camera.resume()
    assert camera.get_current_frame()["rendering_time"] > first


def test_frames_change_at_the_frequency(cube):
    camera = Camera("/World/Camera", frequency=20, resolution=(8, 8), position=(0, 0, 0))
    camera.initialize()
    assert camera.get_dt() == pytest.approx(0.05)
    get_timeline().play()
    times = []
    for _ in range(9):
        get_app().update()
        times.append(round(60 * camera.get_current_frame()["rendering_time"]))
    assert times == [0, 0, 0, 4, 4, 4, 7, 7, 7]


def test_a_frequency_that_does_not_divide_the_rate_is_refused(cube):
    with pytest.raises(ArgumentError, match="60 per second"):
        Camera("/World/Camera", frequency=25)
    with pytest.raises(ArgumentError, match="not both"):
        Camera("/World/Camera", frequency=20, dt=0.05)


def test_annotators_need_initialize(cube):
    with pytest.raises(RuntimeError, match="initialize"):
        Camera("/World/Camera").attach_annotator("rgb")


def test_the_render_product_lives_as_long_as_the_camera(camera):
    assert [product.path for product in products()] == [camera.get_render_product_path()]
    camera.destroy()
    assert products() == []
    camera.initialize()
    assert camera.get_render_product_path() == "/Render/HydraTextures/Camera"


def test_the_resolution_can_change(camera):
    camera.add_distance_to_image_plane_to_frame()
    get_app().update()
    camera.set_resolution((30, 30))
    get_app().update()
    assert camera.get_depth().shape == (30, 30)
    assert camera.get_aspect_ratio() == 1.0
    assert camera.get_vertical_aperture() == pytest.approx(camera.get_horizontal_aperture())


# Projection


def test_projection_agrees_with_the_images(camera, stage):
    camera.set_world_pose((-1, 0.5, 0.3), (0.98, 0.05, 0.1, 0.15))
    points = np.array([[3.0, 0.2, 0.1], [2.0, -0.3, 0.5]])
    expected, depths = read_camera(stage, "/World/Camera", (40, 20)).project(points)
    pixels = camera.get_image_coords_from_world_points(points)
    assert pixels == pytest.approx(expected, abs=1e-3)
    assert camera.get_world_points_from_image_coords(pixels, depths) == pytest.approx(points, abs=1e-4)
    in_camera = camera.get_camera_points_from_image_coords(pixels, depths)
    assert in_camera[:, 2] == pytest.approx(depths, abs=1e-5)


def test_intrinsics_are_in_pixels(camera):
    camera.set_focal_length(2.0)
    camera.set_horizontal_aperture(1.0)
    assert camera.get_intrinsics_matrix() == pytest.approx(np.array([[80, 0, 20], [0, 80, 10], [0, 0, 1.0]]))
    assert camera.get_horizontal_fov() == pytest.approx(2 * np.arctan(0.25))


@pytest.mark.parametrize("with_annotator", [False, True])
def test_point_clouds_lie_on_the_cube(camera, with_annotator):
    if with_annotator:
        camera.add_pointcloud_to_frame()
    camera.add_distance_to_image_plane_to_frame()
    get_app().update()
    points = camera.get_pointcloud()
    points = points[np.isfinite(points).all(axis=1)]
    assert len(points) > 10
    assert points[:, 0] == pytest.approx(2.5, abs=1e-4)
    in_camera = camera.get_pointcloud(world_frame=False)
    in_camera = in_camera[np.isfinite(in_camera).all(axis=1)]
    assert in_camera[:, 2] == pytest.approx(2.5, abs=1e-4)


def _odd_pinhole(camera):
    camera.prim.GetAttribute("horizontalApertureOffset").Set(3.0)
    camera.prim.GetAttribute("verticalApertureOffset").Set(-2.0)
    camera.set_vertical_aperture(3.0, maintain_square_pixels=False)  # pixels are square all the same


def _distorted(camera):
    camera.set_opencv_pinhole_properties(cx=18, cy=11, fx=42, fy=38, pinhole=[0.05, 0.01, 0.002, -0.001] + [0.0] * 8)


@pytest.mark.parametrize("world_frame", [True, False])
@pytest.mark.parametrize("unit", [1.0, 0.01])
@pytest.mark.parametrize("lens", [lambda *_: None, _odd_pinhole, _distorted])
def test_point_clouds_of_moving_cameras_below_scaled_prims_lie_on_the_cube(stage, lens, unit, world_frame):
    """The face of the cube at x = 2.5 m, from a rig that is scaled, and moves to its place in time."""
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    cube = UsdGeom.Cube.Define(stage, "/World/cube")
    cube.CreateSizeAttr(4 / unit)
    cube.AddTranslateOp().Set(Gf.Vec3d(4.5, 0, 0) / unit)
    rig = UsdGeom.Xform.Define(stage, "/World/Rig")
    move = rig.AddTranslateOp()
    move.Set(Gf.Vec3d(-50, 0, 0) / unit, 0)
    move.Set(Gf.Vec3d(0.5, 0.2, 0.1) / unit, 60)
    rig.AddScaleOp().Set(Gf.Vec3f(0.4, 0.4, 0.4))
    camera = Camera("/World/Rig/Camera", resolution=(40, 20), translation=(0, 0, 0))
    camera.set_clipping_range(0.1 / unit, 100.0 / unit)
    lens(camera)
    camera.initialize()
    camera.add_distance_to_image_plane_to_frame()
    get_timeline().set_current_time(60 / stage.GetTimeCodesPerSecond())
    get_app().update()
    points = camera.get_pointcloud(world_frame=world_frame)
    points = points[np.isfinite(points).all(axis=1)]
    assert len(points) > 700
    if world_frame:
        assert points[:, 0] == pytest.approx(2.5 / unit, rel=1e-4)
    else:
        assert points[:, 2] == pytest.approx(2.0, rel=1e-4)
    # Its corners are where the picture's first and last pixels look, by the camera's own projection.
    pixels, _ = read_camera(stage, "/World/Rig/Camera", (40, 20), time=Usd.TimeCode(60)).project(
        points if world_frame else points[:, [2, 0, 1]] * (1, -1, -1) / unit + np.array([0.5, 0.2, 0.1]) / unit
    )
    assert pixels.min(axis=0) == pytest.approx([0.5, 0.5], abs=1e-2)
    assert pixels.max(axis=0) == pytest.approx([39.5, 19.5], abs=1e-2)


# Lens


def test_lengths_are_in_stage_units(camera, stage):
    camera.set_focal_length(2.4)
    assert stage.GetPrimAtPath("/World/Camera").GetAttribute("focalLength").Get() == pytest.approx(24)
    camera.set_vertical_aperture(1.0)
    assert camera.get_horizontal_aperture() == pytest.approx(2.0)
    camera.set_shutter_properties(0.1, 0.2)
    assert camera.get_shutter_properties() == pytest.approx((0.1, 0.2))


def test_distortion_is_set_and_read(camera, stage):
    camera.set_opencv_pinhole_properties(cx=20, cy=10, fx=30, fy=30, pinhole=[0.1, 0.2] + [0.0] * 10)
    values = camera.get_opencv_pinhole_properties()
    assert values[:4] == pytest.approx((20, 10, 30, 30))
    assert values[4][:2] == pytest.approx([0.1, 0.2])
    assert read_camera(stage, "/World/Camera", (40, 20)).projection_type == "pinholeOpenCV"
    camera.set_lens_distortion_model("pinhole")
    assert camera.get_lens_distortion_model() == "pinhole"


def test_a_fisheye_has_no_intrinsics(camera):
    camera.set_ftheta_properties(nominal_height=20, nominal_width=40, optical_center=(20, 10), max_fov=180)
    with pytest.raises(ArgumentError, match="pinhole"):
        camera.get_intrinsics_matrix()
    camera.set_projection_type("pinhole")
    assert camera.get_intrinsics_matrix().shape == (3, 3)
    camera.set_projection_type("fisheyePolynomial")  # the older attribute
    with pytest.raises(ArgumentError, match="pinhole"):
        camera.get_intrinsics_matrix()


def test_all_cameras_are_found_by_name(camera):
    Camera("/World/Group/Other")
    assert [each.name for each in get_all_camera_objects("/World/Group")] == ["Other"]
