"""What a format cannot say of a scene is no fault of its dataset."""

import json
import warnings

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Thing
from usdsdg.errors import UsdsdgWarning
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.keypoints import set_keypoints
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.verify.checks.formats.yolo import oriented
from usdsdg.verify.checks.points import are_elsewhere
from usdsdg.verify.checks.rectangles import least_rectangles, problem_of
from usdsdg.verify.verify import verify
from usdsdg.writers.formats.yolo.oriented import fitted


def write(folder, writer_name, eye, **options):
    rep.create.light(light_type="dome")
    writer = rep.writers.get(writer_name)
    writer.initialize(output_dir=str(folder), **options)
    writer.attach(rep.create.render_product(eye, (64, 48)))
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    return [str(each) for each in verify(folder).faults]


@pytest.mark.parametrize(
    ("writer_name", "options", "picture"),
    [
        ("KittiWriter", {}, "depth/0.png"),
        ("BopWriter", {"depth_scale": 4.0}, "depth/000000.png"),
    ],
)
def test_depths_below_half_a_step_are_none(stage, tmp_path, writer_name, options, picture):
    """A wall 1 mm before the camera, and a hole in it with another one behind."""
    UsdGeom.SetStageMetersPerUnit(current_stage(), 0.001)
    for name, corner, depth in (("left", -5, -1), ("right", 5, -40)):
        wall = UsdGeom.Cube.Define(current_stage(), f"/World/{name}")
        add_labels(wall.GetPrim(), {"class": [name]})
        wall.CreateSizeAttr(1.0)
        wall.AddTranslateOp().Set(Gf.Vec3d(corner * -depth, 0, depth - 0.5))
        wall.AddScaleOp().Set(Gf.Vec3f(-10 * depth, -10 * depth, 1))
    eye = UsdGeom.Camera.Define(current_stage(), "/Camera")
    eye.CreateClippingRangeAttr(Gf.Vec2f(0.1, 1e4))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UsdsdgWarning)
        assert write(tmp_path, writer_name, "/Camera", **options) == []
    (written,) = tmp_path.rglob(picture)
    pixels = np.array(Image.open(written))
    assert set(np.unique(pixels[:, :31])) == {0}
    assert set(np.unique(pixels[:, 33:])) == {10}
    pixels[:, 33:] = 0
    Image.fromarray(pixels).save(written)
    assert any("depth differs" in str(each) for each in verify(tmp_path).faults)


@pytest.mark.parametrize(("above", "named"), [((1, 2, 1), "sheared"), ((1, 1, -1), "mirrored")])
def test_objects_without_a_quaternion_which_dopes_writer_names(stage, tmp_path, above, named):
    UsdGeom.Xform.Define(current_stage(), "/World/Above").AddScaleOp().Set(Gf.Vec3f(*above))
    box = UsdGeom.Cube.Define(current_stage(), "/World/Above/Box")
    add_labels(box.GetPrim(), {"class": ["box"]})
    box.CreateSizeAttr(1.0)
    box.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 35))
    eye = rep.create.camera(position=(1, -9, 2), look_at=(0, 0, 0))
    with pytest.warns(UsdsdgWarning, match=f"/World/Above/Box is {named}"):
        assert write(tmp_path, "DOPEWriter", eye, class_name_to_index_map={}, exact=True) == []


def test_objects_beyond_kittis_255_of_a_class_have_no_number(stage, tmp_path):
    for index in range(18 * 15):
        box = UsdGeom.Cube.Define(current_stage(), f"/World/Box{index}")
        add_labels(box.GetPrim(), {"class": ["car"]})
        box.CreateSizeAttr(0.9)
        box.AddTranslateOp().Set(Gf.Vec3d(index % 18 - 8.5, index // 18 - 7, 0))
    eye = UsdGeom.Camera.Define(current_stage(), "/Camera")
    eye.AddTranslateOp().Set(Gf.Vec3d(0, 0, 50))
    with pytest.warns(UsdsdgWarning, match="more than 255 objects of a class"):
        assert write(tmp_path, "KittiWriter", "/Camera", bbox_height_threshold=1) == []
    (written,) = tmp_path.rglob("instance_segmentation/0.png")
    pixels = np.array(Image.open(written))
    assert len(np.unique(pixels % 256)) == 256
    pixels[pixels % 256 == 7] -= 7
    Image.fromarray(pixels).save(written)
    assert any("has a number" in str(each) for each in verify(tmp_path).faults)


@pytest.mark.parametrize(
    "style", [{"outline": None}, {"outline": 5}, {"outline": [1, 2, 3]}, {"width": 0, "fill": "red"}]
)
def test_styles_of_pillow_are_drawn_as_they_were(stage, tmp_path, style):
    rep.create.cube(semantics=[("class", "box")])
    eye = rep.create.camera(position=(1, -9, 2), look_at=(0, 0, 0))
    solids = {name: value for name, value in style.items() if name != "outline"}
    options = {"bounding_box_2d_tight_params": style, "bounding_box_3d_params": solids}
    drawn = {"bounding_box_2d_tight": True, "bounding_box_3d": True}
    assert write(tmp_path, "DataVisualizationWriter", eye, **drawn, **options) == []


def test_the_last_digit_of_focal_lengths_is_no_fault(stage, tmp_path):
    eye = UsdGeom.Camera.Define(stage, "/Camera")
    eye.CreateFocalLengthAttr(17.661026)
    eye.CreateHorizontalApertureAttr(20.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UsdsdgWarning)
        assert write(tmp_path, "KittiWriter", "/Camera", plain_names=True) == []
    (calibration,) = tmp_path.rglob("calib/*.txt")
    row = calibration.read_text().splitlines()[2].split()[1:]
    assert row[0] != row[5]
    focal = float(row[0])
    assert float(row[5]) == pytest.approx(focal, rel=1e-12)
    calibration.write_text(calibration.read_text().replace(row[5], f"{1.001 * focal:.12e}"))
    assert any("square pixels" in str(each) for each in verify(tmp_path).faults)


def test_classes_of_one_name_are_one_category_of_coco(stage, tmp_path):
    for name, kind, x in (("a", "class", -1), ("b", "coco", 1)):
        prim = UsdGeom.Cube.Define(stage, f"/World/{name}").GetPrim()
        UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(1.5 * x, 0, -8))
        add_labels(prim, {kind: ["car"]})
    UsdGeom.Camera.Define(stage, "/Camera")
    assert write(tmp_path, "CocoWriter", "/Camera", plain_names=True, panoptic=True) == []
    data = json.loads((tmp_path / "annotations/instances_train.json").read_text())
    (category,) = data["categories"]
    assert category["name"] == "car"
    assert [each["category_id"] for each in data["annotations"]] == [category["id"]] * 2
    segments = json.loads((tmp_path / "annotations/panoptic_train.json").read_text())["annotations"][0]["segments_info"]
    assert [each["category_id"] for each in segments] == [category["id"]] * 2


def test_a_line_that_is_drawn_beside_the_border_is_not_missing(stage, tmp_path):
    """The edge of a box leaves the picture by the right border; its line is up to a pixel to the right of it."""
    box = UsdGeom.Cube.Define(stage, "/World/Box")
    add_labels(box.GetPrim(), {"class": ["box"]})
    box.CreateSizeAttr(1.0)
    box.AddTranslateOp().Set(Gf.Vec3d(8.34 + 18.5, 0, -20))
    box.AddRotateZOp().Set(-float(np.degrees(np.arctan(1 / 14))))
    box.AddScaleOp().Set(Gf.Vec3f(8, 90, 1))
    eye = UsdGeom.Camera.Define(stage, "/Camera")
    eye.CreateProjectionAttr("orthographic")
    eye.CreateHorizontalApertureAttr(640.0)  # tenths of a unit, so that a pixel is a unit
    assert write(tmp_path, "DataVisualizationWriter", "/Camera", bounding_box_3d=True) == []
    (written,) = tmp_path.rglob("bounding_box_3d*.png")
    pixels = np.array(Image.open(written))
    Image.fromarray(np.roll(pixels, -5, axis=1)).save(written)
    assert any("edges of 3D boxes" in str(each) for each in verify(tmp_path).faults)


def test_models_of_bop_have_what_opacity_hides(stage, tmp_path):
    root = UsdGeom.Xform.Define(stage, "/World/Tree").GetPrim()
    add_labels(root, {"class": ["tree"]})
    for name, x in (("Trunk", -1), ("Leaf", 1)):
        part = UsdGeom.Cube.Define(stage, f"/World/Tree/{name}")
        part.CreateSizeAttr(1.0)
        part.AddTranslateOp().Set(Gf.Vec3d(x, 0, -8))
    clear = UsdShade.Material.Define(stage, "/World/Clear")
    shader = UsdShade.Shader.Define(stage, "/World/Clear/Shader")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(0.25)
    shader.CreateInput("opacityThreshold", Sdf.ValueTypeNames.Float).Set(0.5)
    clear.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(part.GetPrim()).Bind(clear)
    eye = UsdGeom.Camera.Define(stage, "/Camera")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UsdsdgWarning)
        assert write(tmp_path, "BopWriter", eye.GetPath().pathString, depth_scale=1.0) == []


def test_points_of_surfaces_that_are_seen_edge_on_may_be_off_along_the_sight(stage):
    UsdGeom.Camera.Define(stage, "/Camera")
    camera = read_camera(stage, "/Camera", (64, 48))
    expected = np.array([[0.0, 0.0, -10.0], [1.0, 2.0, -9.0]])
    for factor, is_elsewhere in ((1.0, False), (1.001, False), (1.01, True)):
        assert are_elsewhere(factor * expected, expected, camera) is is_elsewhere
    assert are_elsewhere(expected + np.array([0.01, 0, 0]), expected, camera)
    assert are_elsewhere(np.nan * expected, expected, camera)


def test_depths_of_rays_across_the_axis_are_rounded_as_distances(stage, tmp_path):
    """The two columns of a panorama look to the left and to the right."""
    wall = UsdGeom.Sphere.Define(stage, "/World/Wall")
    wall.CreateRadiusAttr(7.3)
    wall.AddTranslateOp().Set(Gf.Vec3d(1.1, 0.4, 0.3))
    eye = UsdGeom.Camera.Define(stage, "/Camera")
    eye.GetPrim().CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyeSpherical")
    eye.AddRotateXYZOp().Set(Gf.Vec3f(31, 52, 17))
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path), distance_to_camera=True, distance_to_image_plane=True)
    writer.attach(rep.create.render_product("/Camera", (2, 49)))
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    assert verify(tmp_path).faults == []
    file = tmp_path / "distance_to_image_plane_0000.npy"
    np.save(file, np.load(file) + np.float32(0.01))
    assert any("optical axis" in str(each) for each in verify(tmp_path).faults)


def test_sizes_of_points_that_quaternions_of_16_bits_turn_are_those_of_their_axes(stage, tmp_path):
    """The axes are perpendicular up to the rounding of 16 bits, so that there are several ways to their lengths."""
    points = UsdGeom.PointInstancer.Define(stage, "/World/Points")
    box = UsdGeom.Cube.Define(stage, "/World/Points/Box")
    add_labels(box.GetPrim(), {"class": ["box"]})
    points.CreatePrototypesRel().SetTargets([box.GetPath()])
    points.CreateProtoIndicesAttr([0])
    points.CreatePositionsAttr([Gf.Vec3f(0, 0, 0)])
    points.CreateOrientationsAttr([Gf.Quath(-0.208535726, -0.521503123, 0.469095912, 0.681539704)])
    eye = UsdGeom.Camera.Define(stage, "/Camera")
    eye.AddTranslateOp().Set(Gf.Vec3d(0, 0, 9))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UsdsdgWarning)
        assert write(tmp_path, "PoseWriter", "/Camera") == []


def test_of_two_least_rectangles_either_is_an_oriented_box():
    pixels = np.array([[0, 0, 1], [0, 0, 1], [1, 1, 0]], bool)
    upright, turned = sorted(least_rectangles(pixels), key=lambda each: np.ptp(each[:, 0]))
    assert np.ptp(upright, axis=0).tolist() == pytest.approx([3, 3])
    assert np.ptp(turned, axis=0).tolist() == pytest.approx([4.5, 4.5])
    for corners in (upright, turned):
        assert problem_of(corners, pixels) == ""
        assert problem_of(corners * 1.2, pixels) != ""
    assert problem_of(upright * 0.5, pixels) == "does not hold its pixels"
    seen, thing = (
        Seen("YoloWriter", "0", "", []),
        Thing("/World/A", "", {}, 2, 2, 5, None, 5, None, *np.zeros((2, 2, 3))),
    )
    corners = fitted(turned, (3, 3))
    assert list(oriented(seen, "0.txt", thing, corners, pixels, upright)) != []
    assert list(oriented(seen, "0.txt", thing, corners, pixels, turned)) == []


def test_parts_of_an_object_may_have_keypoints_of_one_name(stage, tmp_path):
    """YOLO has one of them: of these two that of the left wheel, since the other one is not in the picture."""
    car = UsdGeom.Xform.Define(stage, "/World/Car")
    add_labels(car.GetPrim(), {"class": ["car"]})
    for name, x in (("Left", 0), ("Right", 9)):
        wheel = UsdGeom.Sphere.Define(stage, f"/World/Car/{name}")
        wheel.AddTranslateOp().Set(Gf.Vec3d(x, 0, -9))
        set_keypoints(wheel.GetPrim(), {"hub": (0, 0, 1)})
    UsdGeom.Camera.Define(stage, "/Camera")
    assert write(tmp_path, "YoloWriter", "/Camera", task="pose") == []
    (file,) = tmp_path.rglob("labels/*/*.txt")
    assert file.read_text().split()[5:] == ["0.5", "0.5", "2"]


def test_edges_of_a_box_around_a_panorama_are_drawn_whole(stage, tmp_path):
    """An edge sweeps over half of the picture near a pole, and pieces of it across the picture's seam are left out."""
    box = UsdGeom.Cube.Define(stage, "/World/Box")
    add_labels(box.GetPrim(), {"class": ["box"]})
    box.AddTranslateOp().Set(Gf.Vec3d(-0.4, 0.3, 0.6))
    box.AddRotateXYZOp().Set(Gf.Vec3f(-10, 64, -166))
    box.AddScaleOp().Set(Gf.Vec3f(0.4, 0.6, 2))
    eye = UsdGeom.Camera.Define(stage, "/Camera")
    eye.GetPrim().CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyeSpherical")
    eye.CreateClippingRangeAttr(Gf.Vec2f(0.01, 100))
    assert write(tmp_path, "DataVisualizationWriter", "/Camera", bounding_box_3d=True) == []
