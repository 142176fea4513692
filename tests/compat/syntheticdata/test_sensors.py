"""The sensors of the viewport: a car of two parts with a labeled wheel, seen from above, partly behind a plate."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from usdsdg.app.app import get_app
from usdsdg.compat.omni.kit.viewport.utility import get_active_viewport
from usdsdg.compat.omni.syntheticdata import helpers, sensors, visualize
from usdsdg.compat.omni.syntheticdata._syntheticdata import SensorType
from usdsdg.compat.omni.syntheticdata.synthetic_data import SyntheticData
from usdsdg.compat.omni.syntheticdata.tests.utils import add_semantics
from usdsdg.errors import Unsupported


def box(stage, path, center, size):
    cube = UsdGeom.Cube.Define(stage, path)
    cube.CreateSizeAttr(1.0)
    cube.AddTranslateOp().Set(Gf.Vec3d(*center))
    cube.AddScaleOp().Set(Gf.Vec3f(*size))
    return cube.GetPrim()


@pytest.fixture
def viewport(stage):
    """One pixel is 0.1 m on the ground: column 50 + 10 x, row 50 - 10 y."""
    car = stage.DefinePrim("/World/Car", "Xform")
    add_semantics(car, "Car")
    add_semantics(car, "red", "color")
    box(stage, "/World/Car/body", (0, 0, 0), (2, 1, 0.002))
    wheel = box(stage, "/World/Car/wheel", (2, 0, 0), (1, 1, 0.002))
    add_semantics(wheel, "wheel")
    box(stage, "/World/plate", (-0.75, 0, 1), (0.5, 2, 0.002))  # above the left quarter of the body
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTranslateOp().Set((0, 0, 1000))
    camera.CreateHorizontalApertureAttr(10.0)
    camera.CreateFocalLengthAttr(1000.0)
    camera.CreateClippingRangeAttr((1, 10000))
    view = get_active_viewport()
    view.set_active_camera("/World/Camera")
    view.resolution = (100, 100)
    sensors.enable_sensors(view, [SensorType.DistanceToImagePlane, SensorType.InstanceSegmentation])
    sensors.enable_sensors(view, [SensorType.SemanticSegmentation, SensorType.BoundingBox2DTight])
    sensors.enable_sensors(view, [SensorType.BoundingBox2DLoose, SensorType.BoundingBox3D, SensorType.Occlusion])
    return view


@pytest.fixture
def updated(viewport):
    get_app().update()
    return viewport


def corners(row):
    return [int(row[name]) for name in ("x_min", "y_min", "x_max", "y_max")]


def test_sensors_are_empty_before_the_first_update(viewport):
    assert sensors.get_distance_to_image_plane(viewport).shape == (0, 0)
    assert len(sensors.get_bounding_box_2d_tight(viewport)) == 0


def test_a_sensor_that_is_not_enabled_is_empty(updated):
    assert sensors.get_rgb(updated).shape == (0, 0, 4)


def test_distances_are_in_meters(updated):
    depth = sensors.get_distance_to_image_plane(updated)
    assert depth.dtype == np.float32
    assert depth[50, 55] == pytest.approx(999.999, abs=1e-3)
    assert depth[5, 5] == np.inf


def test_gprims_and_labeled_prims_are_segmented(updated):
    leaves, mappings = sensors.get_instance_segmentation(updated, return_mapping=True)
    assert len(set(leaves.ravel().tolist()) - {0}) == 3
    by_name = {row["name"]: row for row in mappings}
    assert leaves[50, 55] in by_name["/World/Car"]["instanceIds"]
    assert leaves[50, 70] in by_name["/World/Car/wheel"]["instanceIds"]
    parsed = sensors.get_instance_segmentation(updated, parsed=True)
    assert parsed[50, 55] == by_name["/World/Car"]["uniqueId"]
    assert parsed[50, 70] == by_name["/World/Car/wheel"]["uniqueId"]
    assert parsed[50, 42] == 0  # the plate has no label
    semantic = sensors.get_semantic_segmentation(updated, parsed=True)
    assert semantic[50, 70] == by_name["/World/Car/wheel"]["semanticId"] != semantic[50, 55]


def test_mappings_keep_the_case_of_labels_and_include_inner_prims(updated):
    rows = {row["name"]: row for row in helpers.get_instance_mappings()}
    assert rows["/World/Car"]["semanticLabel"] == "Car"
    assert rows["/World/Car"]["metadata"] == [("color", "red")]
    assert set(rows["/World/Car/wheel"]["instanceIds"]) < set(rows["/World/Car"]["instanceIds"])
    assert list(sensors.get_semantic_data()["semanticLabel"]) == ["wheel", "Car"]


def test_2d_boxes_include_the_prims_inside(updated):
    tight = {row["name"]: row for row in sensors.get_bounding_box_2d_tight(updated)}
    assert corners(tight["/World/Car/wheel"]) == [65, 45, 74, 54]
    assert corners(tight["/World/Car"]) == [45, 45, 74, 54]  # without what the plate hides
    loose = {row["name"]: row for row in sensors.get_bounding_box_2d_loose(updated)}
    assert corners(loose["/World/Car"]) == [40, 45, 74, 54]


def test_3d_boxes_are_in_the_frame_of_the_labeled_prim(updated):
    parsed = {row["name"]: row for row in sensors.get_bounding_box_3d(updated, parsed=True, return_corners=True)}
    car = parsed["/World/Car"]
    assert [car[name] for name in ("x_min", "y_min", "x_max", "y_max")] == pytest.approx([-1, -0.5, 2.5, 0.5])
    assert car["corners"][0] == pytest.approx([-1, -0.5, -0.001], abs=1e-6)
    assert car["corners"][7] == pytest.approx([2.5, 0.5, 0.001], abs=1e-6)
    leaves = sensors.get_bounding_box_3d(updated)
    assert leaves.dtype.names[:3] == ("instanceId", "semanticId", "x_min")
    assert len(leaves) == 2
    assert leaves["x_max"] == pytest.approx([0.5, 0.5])  # in each gprim's own frame


def test_boxes_can_be_in_the_frame_of_the_camera(updated):
    in_camera = sensors.get_bounding_box_3d(updated, parsed=True, return_corners=True, camera_frame=True)
    assert in_camera["corners"][..., 2] == pytest.approx(-1000, abs=1e-2)


def test_occlusion_is_the_hidden_fraction(updated):
    rows = {row["name"]: row["occlusionRatio"] for row in sensors.get_occlusion(updated, parsed=True)}
    assert rows == {"/World/Car": pytest.approx(0.25), "/World/Car/wheel": pytest.approx(0.0)}
    assert sensors.get_occlusion(updated).dtype.names == ("instanceId", "semanticId", "occlusionRatio")


def test_the_hidden_side_is_named(updated):
    rows = {row["name"]: row["occlusion_quadrant"] for row in sensors.get_occlusion_quadrant(updated)}
    assert rows == {"/World/Car": "left", "/World/Car/wheel": "fully-visible"}


def test_points_are_projected_as_the_image_shows_them(updated):
    (point,) = helpers.world_to_image(np.array([[2.0, 1.0, 0.0]]), updated)
    assert point[:2] == pytest.approx([0.7, 0.4])


def test_offsets_of_the_aperture_move_points_as_gf_has_it(viewport, stage):
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    camera.CreateHorizontalApertureOffsetAttr(2.5)
    camera.CreateVerticalApertureOffsetAttr(-1.5)
    camera.CreateVerticalApertureAttr(5.0)
    viewport.resolution = (100, 50)
    points = np.array([[2.0, 1.0, 0.0], [-3.0, 0.5, 30.0]])
    frustum = camera.GetCamera().frustum
    to_clip = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()
    expected = [to_clip.Transform(Gf.Vec3d(*each)) for each in points]
    params = helpers.get_view_params(viewport)
    pixels = helpers.world_to_image(points, viewport)[:, :2]
    assert pixels == pytest.approx(np.array([((x + 1) / 2, (1 - y) / 2) for x, y, _ in expected]), abs=1e-6)
    origin, directions = helpers.image_to_world(pixels * (100, 50), params)
    along = points - origin
    assert directions == pytest.approx(along / np.linalg.norm(along, axis=1, keepdims=True), abs=1e-9)


def test_images_of_sensors_are_colors(updated):
    assert visualize.get_distance(updated).shape == (100, 100, 4)
    assert (visualize.get_instance_segmentation(updated, mode="parsed")[5, 5] == (0, 0, 0, 255)).all()


def test_a_template_without_counterpart_is_refused_by_name(viewport):
    with pytest.raises(Unsupported, match="IsaacSimulationGate"):
        SyntheticData.Get().activate_node_template("IsaacSimulationGate", 0, [viewport.render_product_path])
    with pytest.raises(Unsupported, match="Camera3dPosition"):
        sensors.get_camera_3d_position(viewport)


def test_arrays_can_be_read_as_bytes(updated):
    product = updated.render_product_path
    got = SyntheticData.Get().get_node_attributes(
        "DistanceToImagePlaneSDExportRawArray", ["outputs:data", "outputs:width"], product
    )
    assert got["outputs:width"] == 100
    raw = got["outputs:data"].view(np.float32).reshape(100, 100)
    assert (raw == sensors.get_distance_to_image_plane(updated)).all()


def test_the_default_label_filter_applies_to_annotators_without_one(updated):
    import usdsdg as rep

    SyntheticData.Get().set_instance_mapping_semantic_filter("color:*")
    annotator = rep.annotators.get("semantic_segmentation")
    annotator.attach(updated.render_product_path)
    rep.orchestrator.step()
    assert {"color": "red"} in annotator.get_data()["info"]["idToLabels"].values()
    assert SyntheticData.Get().get_instance_mapping_semantic_filter() == "color:*"
