"""`CameraView`: images of several cameras in tiles and as a batch agree with those of each."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.sensors.camera import Camera, CameraView
from usdsdg.errors import ArgumentError, Unsupported


@pytest.fixture
def view(stage):
    """Three cameras above the ground at heights 1, 2 and 3, which look straight down."""
    plane = UsdGeom.Mesh.Define(stage, "/World/ground")
    plane.CreatePointsAttr([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)])
    plane.CreateFaceVertexCountsAttr([4])
    plane.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    for number in range(3):
        camera = UsdGeom.Camera.Define(stage, f"/World/Env_{number}/Camera")
        camera.CreateClippingRangeAttr(Gf.Vec2f(0.1, 100))
        camera.AddTranslateOp().Set(Gf.Vec3d(number, 0, number + 1))
    return CameraView("/World/Env_.*/Camera", camera_resolution=(6, 4), output_annotators=["depth", "normals"])


def test_nothing_is_there_before_the_first_update(view):
    assert view.get_depth_tiled().size == 0


def test_tiles_are_row_by_row(view):
    get_app().update()
    assert view.tiled_resolution == (12, 8)
    tiled = view.get_depth_tiled()
    assert tiled.shape == (8, 12, 1)
    assert [tiled[2, 3, 0], tiled[2, 9, 0], tiled[6, 3, 0]] == pytest.approx([1, 2, 3])
    assert np.isinf(tiled[6, 9, 0])


def test_batches_have_one_image_per_camera(view):
    get_app().update()
    batch, info = view.get_data("depth")
    assert batch.shape == (3, 4, 6, 1)
    assert batch.numpy()[:, 2, 3, 0] == pytest.approx([1, 2, 3])
    normals, _ = view.get_data("normals")
    assert normals.numpy()[0, 2, 3] == pytest.approx([0, 0, 1, 1])
    assert info == {}


def test_arrays_that_are_given_are_filled(view):
    import warp as wp

    get_app().update()
    out = np.zeros((8, 12, 1), np.float32)
    assert view.get_depth_tiled(out=out) is out
    assert out[2, 3, 0] == pytest.approx(1)
    batch = wp.zeros((3, 4, 6, 1), dtype=wp.float32)
    assert view.get_data("depth", out=batch)[0] is batch
    assert batch.numpy()[2, 2, 3, 0] == pytest.approx(3)


def test_a_torch_tensor_needs_torch(view):
    get_app().update()
    try:
        import torch
    except ImportError:
        with pytest.raises(Unsupported, match="torch is not installed"):
            view.get_depth()
    else:
        assert isinstance(view.get_depth(), torch.Tensor)


def test_outputs_must_be_known_and_asked_for(view):
    with pytest.raises(ArgumentError, match="not asked for"):
        view.get_data("rgb")
    with pytest.raises(ArgumentError, match="distance_to_camera"):
        view.get_data("depth_linear")


def test_poses_are_read_as_they_were_set(view):
    orientations = np.array([[1.0, 0, 0, 0], [0.8, 0.6, 0, 0], [0.6, 0, 0.8, 0]])
    view.set_world_poses(np.eye(3), orientations)
    positions, back = view.get_world_poses()
    assert positions == pytest.approx(np.eye(3), abs=1e-6)
    assert np.abs((back * orientations).sum(axis=1)) == pytest.approx(1, abs=1e-6)


def test_an_unrotated_camera_looks_as_that_of_the_single_class(view):
    view.set_world_poses(orientations=[[1.0, 0, 0, 0]])
    single = Camera("/World/Single", position=(0, 0, 0))
    assert view.get_world_poses(camera_axes="usd")[1][0] == pytest.approx(single.get_world_pose("usd")[1], abs=1e-6)


def test_lens_values_are_lists(view):
    view.set_focal_lengths([2.4], indices=[1])
    assert view.get_focal_lengths(indices=[1]) == pytest.approx([2.4])
    assert view.get_horizontal_apertures() == pytest.approx([20.955] * 3)
    assert view.get_projection_types() == ["pinhole"] * 3
    view.set_shutter_properties([(0.1, 0.2)] * 3)
    assert view.get_shutter_properties()[0] == pytest.approx((0.1, 0.2))
    with pytest.raises(ArgumentError, match="2 values"):
        view.set_focal_lengths([1.0, 2.0])


def test_the_resolution_can_change(view):
    view.set_resolutions((10, 10))
    get_app().update()
    assert view.get_data("depth")[0].shape == (3, 10, 10, 1)
