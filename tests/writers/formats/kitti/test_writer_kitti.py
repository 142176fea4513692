"""KittiWriter: boxes against corners that USD gives, after the formulas of KITTI's development kit."""

import dataclasses
import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.annotators.ray_caster import add_cube, add_sphere, known, make_frame, new_stage
from tests.annotators.scenes import add_camera, mask_of, street
from tests.dataset_files import data_names
from usdsdg import annotators, writers
from usdsdg.errors import AssetUnreadable, Unsupported, UsdsdgWarning, WriterError, forget_warnings
from usdsdg.session.stage_context import set_stage
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.writers.formats.kitti.kitti_classes import KittiClasses
from usdsdg.writers.formats.kitti.kitti_images import depth_image, instance_image

PRODUCT = "/Render/HydraTextures/rp1"
EVERY = ["calib", "depth", "instance_segmentation", "object_detection", "rgb", "semantic", "semantic_segmentation"]


def write(folder, frames, **options):
    """Write `frames` (one, or {path: frame} each time) and return the folder."""
    writer = writers.get("KittiWriter", init_params={"output_dir": str(folder), "bbox_height_threshold": 0, **options})
    sets = [f if isinstance(f, dict) else {PRODUCT: f} for f in (frames if isinstance(frames, list) else [frames])]
    writer.attach(known(*sets[0]))
    for each in sets:
        writer.receive(annotators.build_payload(writer, each))
    writer.detach()
    writer.backend.wait_until_done()
    return Path(folder)


def lines(path):
    """Each object of a label file: its name, and its numbers."""
    rows = [line.split(" ") for line in path.read_text().splitlines()]
    assert all(len(row) == 15 for row in rows)
    return [(row[0], np.array(row[1:], float)) for row in rows]


def picture(path):
    with Image.open(path) as image:
        return np.asarray(image)


# What the readme and the MATLAB code of KITTI's object development kit say.


def corners_of(numbers) -> np.ndarray:
    """(8, 3) corners in the camera's frame of the numbers of a line."""
    height, width, length, x, y, z, turn = numbers[7:]
    corners = np.array(list(itertools.product((-length / 2, length / 2), (0, -height), (-width / 2, width / 2))))
    c, s = math.cos(turn), math.sin(turn)
    return corners @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T + [x, y, z]


def projected(corners, calibration: Path) -> np.ndarray:
    """(N, 2) pixels, counted from the middle of the first."""
    rows = dict(line.split(": ") for line in calibration.read_text().splitlines())
    matrix = np.array(rows["P2"].split(), float).reshape(3, 4)
    points = np.c_[corners, np.ones(len(corners))] @ matrix.T
    return points[:, :2] / points[:, 2:]


# What USD says.


def usd_corners(stage, path, camera) -> np.ndarray:
    """(8, 3) corners of the prim's own box in KITTI's camera frame [m]."""
    cache = UsdGeom.XformCache()
    prim = stage.GetPrimAtPath(path)
    box = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_]).ComputeUntransformedBound(prim).GetBox()
    to_camera = cache.GetLocalToWorldTransform(prim) * cache.GetLocalToWorldTransform(camera).GetInverse()
    points = np.array([to_camera.Transform(box.GetCorner(index)) for index in range(8)])
    return points * [1, -1, -1] * UsdGeom.GetStageMetersPerUnit(stage)


def assert_same_points(ours, theirs, tolerance):
    distances = np.linalg.norm(ours[:, None] - theirs[None], axis=2)
    assert distances.min(axis=0).max() < tolerance
    assert distances.min(axis=1).max() < tolerance


def level_scene(sizes, yaw, heading, offset, *, up="Z", unit=1.0):
    """A stage with a box (sizes along its x, its y and upwards [m]) in front of a level camera."""
    stage = new_stage()
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    ahead, aside, above = offset
    c, s = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    where = np.array([ahead * c - aside * s, ahead * s + aside * c, above]) / unit
    x, y, z = np.array(sizes) / unit
    eye, target = (0.0, 0.0, 0.0), (c, s, 0.0)
    if up == "Y":  # the same, turned about x
        where, target = where[[0, 2, 1]] * [1, 1, -1], (c, 0.0, -s)
        pose = {"translate": where, "rotate": (0, yaw, 0), "scale": (x, z, y)}
    else:
        pose = {"translate": where, "rotate": (0, 0, yaw), "scale": (x, y, z)}
    add_cube(stage, "/World/Car", "car", **pose)
    camera = UsdGeom.Camera.Define(stage, "/World/Level")
    camera.CreateFocalLengthAttr(18.0)
    camera.CreateHorizontalApertureAttr(20.955)
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01, 1e6))
    upwards = (0, 1, 0) if up == "Y" else (0, 0, 1)
    UsdGeom.Xformable(camera).AddTransformOp().Set(look_at_matrix(eye, target, up=upwards))
    return set_stage(stage), camera.GetPrim()


# In these pictures the smallest and farthest box is more than a pixel wide and high.
@given(
    sizes=st.tuples(*[st.floats(0.6, 3)] * 3),
    yaw=st.floats(-180, 180),
    heading=st.floats(-180, 180),
    offset=st.tuples(st.floats(6, 20), st.floats(-2, 2), st.floats(-1.5, 1.5)),
    world=st.sampled_from([("Z", 1.0), ("Z", 0.01), ("Y", 0.01)]),
)
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_an_upright_box_before_a_level_camera_comes_back(sizes, yaw, heading, offset, world, tmp_path):
    stage, camera = level_scene(sizes, yaw, heading, offset, up=world[0], unit=world[1])
    folder = write(tmp_path, make_frame(stage, (64, 48), camera="/World/Level"))
    ((name, numbers),) = lines(folder / "Level" / "object_detection" / "0.txt")
    theirs = usd_corners(stage, "/World/Car", camera)
    assert name == "class:car"
    # Six digits each of sizes, places up to 22 m away and the angle, of a box up to 3 m wide; bounds are float32.
    assert_same_points(corners_of(numbers), theirs, tolerance=3e-4)
    # Its length lies along the prim's x axis, whichever way round.
    assert numbers[9] == pytest.approx(sizes[0], rel=1e-5)
    assert numbers[7] == pytest.approx(sizes[2], rel=1e-5)
    # The projection is the one that the picture was made with.
    focal = 18.0 / 20.955 * 64
    pixels = theirs[:, :2] / theirs[:, 2:] * focal + [31.5, 23.5]
    np.testing.assert_allclose(projected(theirs, folder / "Level" / "calib" / "0.txt"), pixels, atol=1e-4)


@pytest.mark.parametrize(("yaw", "turn"), [(0, -90), (90, 180), (180, 90), (-90, 0)])
def test_rotation_y_and_alpha_of_known_directions(yaw, turn, tmp_path):
    """Seen along +x from the origin: the camera's x is -y of the world, its z is x."""
    stage, _ = level_scene((2, 1, 1), yaw, 0, (10, -2, 0))
    folder = write(tmp_path, make_frame(stage, (64, 48), camera="/World/Level"))
    ((_, numbers),) = lines(folder / "Level" / "object_detection" / "0.txt")
    rotation, alpha, location = numbers[13], numbers[2], numbers[10:13]
    assert math.cos(rotation - math.radians(turn)) == pytest.approx(1, abs=1e-4)
    # Two meters to the right of the axis, ten ahead, its bottom half a meter below.
    np.testing.assert_allclose(location, [2, 0.5, 10], atol=1e-9)
    assert math.cos(alpha - (rotation - math.atan2(2, 10))) == pytest.approx(1, abs=1e-4)
    assert -3.15 < alpha < 3.15
    assert -3.15 < rotation < 3.15


@pytest.mark.parametrize("scale", [1.0, 0.05, 0.005])
def test_small_objects_are_described_as_exactly_as_large_ones(scale, tmp_path):
    stage, _ = level_scene([2 * scale, 1 * scale, 0.7 * scale], 25, 0, [8 * scale, -1 * scale, 0])
    folder = write(tmp_path, make_frame(stage, (64, 48), camera="/World/Level"))
    ((_, numbers),) = lines(folder / "Level" / "object_detection" / "0.txt")
    np.testing.assert_allclose(numbers[7:10], np.multiply([0.7, 1, 2], scale), rtol=1e-5)
    np.testing.assert_allclose(numbers[10:13], np.multiply([1, 0.35, 8], scale), rtol=1e-5)


def test_the_box_surrounds_what_is_seen(tmp_path):
    stage, _ = level_scene((2, 1, 1.5), 30, 20, (8, 0.5, -0.3))
    frame = make_frame(stage, (320, 240), camera="/World/Level")
    folder = write(tmp_path, frame)
    ((_, numbers),) = lines(folder / "Level" / "object_detection" / "0.txt")
    pixels = projected(corners_of(numbers), folder / "Level" / "calib" / "0.txt")
    rows, columns = np.nonzero(mask_of(frame, "/World/Car"))
    assert numbers[3:7].tolist() == [columns.min(), rows.min(), columns.max(), rows.max()]
    # A pixel of rounding, and the part of a pixel that its middle is away from the outline.
    np.testing.assert_allclose([*pixels.min(axis=0), *pixels.max(axis=0)], numbers[3:7], atol=1.5)


def test_a_leaning_box_keeps_its_size_and_middle(tmp_path):
    stage = set_stage(new_stage())
    add_cube(stage, "/World/Car", "car", translate=(1, 2, 0.5), rotate=(10, 15, 40), scale=(2, 1, 0.5))
    add_camera(stage, "/World/Eye", (9, 5, 4), (0, 0, 0))
    folder = write(tmp_path, make_frame(stage, (64, 48), camera="/World/Eye"))
    ((_, numbers),) = lines(folder / "Eye" / "object_detection" / "0.txt")
    theirs = usd_corners(stage, "/World/Car", stage.GetPrimAtPath("/World/Eye"))
    np.testing.assert_allclose(numbers[7:10], [0.5, 1, 2], atol=0.005)
    np.testing.assert_allclose(corners_of(numbers).mean(axis=0), theirs.mean(axis=0), atol=0.01)


# The rest of a line.


@pytest.fixture
def street_frame():
    return make_frame(set_stage(street()), (128, 96), filters=["class:*"])


def test_names_of_files(street_frame, tmp_path):
    write(tmp_path / "plain", [street_frame, street_frame], colorize_instance_segmentation=True)
    names = data_names(tmp_path / "plain")
    kinds = sorted([*EVERY, "instance_rgb"])
    text = {"calib", "object_detection"}
    expected = [f"Camera/{kind}/{n}.{'txt' if kind in text else 'png'}" for kind in kinds for n in (0, 1)]
    assert names == sorted([*expected, "metadata.txt"])
    write(tmp_path / "kitti", street_frame, use_kitti_dir_names=True)
    assert sorted(path.name for path in (tmp_path / "kitti" / "Camera").iterdir()) == [
        "calib", "depth", "image_02", "instance", "label_02", "semantic", "semantic_rgb",
    ]  # fmt: skip


def test_occlusion_truncation_and_names(tmp_path):
    stage = set_stage(street())
    add_sphere(stage, "/World/Cut", "Half seen", translate=(4.35, 0, 0), radius=0.8)
    folder = write(tmp_path, make_frame(stage, (128, 96)), omit_semantic_type=True)
    told = lines(folder / "Camera" / "object_detection" / "0.txt")
    assert [name for name, _ in told] == ["apple", "apple", "pear", "half_seen"]
    assert [int(numbers[1]) for _, numbers in told] == [0, 2, 0, 0]
    truncated = [numbers[0] for _, numbers in told]
    assert truncated[:3] == [0, 0, 0]
    assert 0.3 < truncated[3] < 0.7
    strict = write(tmp_path / "strict", make_frame(stage, (128, 96)), partly_occluded_threshold=0.01)
    assert [int(numbers[1]) for _, numbers in lines(strict / "Camera/object_detection/0.txt")] == [0, 1, 0, 0]


def test_low_objects_are_left_out(street_frame, tmp_path):
    rows = np.nonzero(mask_of(street_frame, "/World/Apple1"))[0]
    height = int(rows.max() + 1 - rows.min())
    for threshold, count in ((height, 1), (height + 1, 0)):
        folder = write(
            tmp_path / str(threshold), street_frame, bbox_height_threshold=threshold, omit_semantic_type=True
        )
        told = lines(folder / "Camera/object_detection/0.txt")
        left = street_frame.aovs["instance"].shape[1] / 2
        assert sum(name == "apple" and numbers[5] < left for name, numbers in told) == count


# Pictures.


def test_classes_instances_and_depth(street_frame, tmp_path):
    folder = write(tmp_path, street_frame, mapping_dict={"apple": [1, 2, 3, 255], "class:pear": 9}) / "Camera"
    ids = json.loads((tmp_path / "metadata.txt").read_text())["semantic_ids"]
    assert ids == {"class:unlabelled": 0, "class:apple": 1, "class:pear": 9, "class:background": 3}
    semantic, colors = picture(folder / "semantic/0.png"), picture(folder / "semantic_segmentation/0.png")
    instances, depth = picture(folder / "instance_segmentation/0.png"), picture(folder / "depth/0.png")
    assert (semantic.dtype, instances.dtype, depth.dtype) == (np.uint8, np.uint16, np.uint16)
    for path, number, instance in (
        ("/World/Apple1", 1, 1 * 256 + 1), ("/World/Apple2", 1, 1 * 256 + 2), ("/World/Pear", 9, 9 * 256 + 1),
        ("/World/Ground", 0, 0),
    ):  # fmt: skip
        mask = mask_of(street_frame, path)
        assert set(semantic[mask]) == {number}
        assert set(instances[mask]) == {instance}
    assert (colors[mask_of(street_frame, "/World/Apple1")] == [1, 2, 3, 255]).all()
    sky = street_frame.aovs["instance"] < 0
    assert set(semantic[sky]) == {3}
    assert set(instances[sky]) == {3 * 256}
    distance = street_frame.aovs["distance_to_image_plane"]
    assert (depth[sky] == 0).all()
    np.testing.assert_allclose(depth[~sky] / 256, distance[~sky], atol=1 / 512 + 1e-9)


def test_255_objects_of_a_class_have_numbers():
    objects = {number: {"class": "car"} for number in range(2, 259)}  # one more than there are, and another
    instances = {
        "data": np.arange(260, dtype=np.uint32)[None],
        "idToSemantics": {0: {"class": "background"}, 1: {"class": "unlabelled"}, **objects, 259: {"class": "bus"}},
    }
    with pytest.warns(UsdsdgWarning, match="more than 255 objects of a class"):
        numbers = instance_image(instances, KittiClasses({"car": 7, "bus": 9}))[0]
    assert numbers[2:259].tolist() == [7 * 256 + number for number in range(1, 256)] + [7 * 256, 7 * 256]
    assert numbers[259] == 9 * 256 + 1


@pytest.mark.parametrize("beyond", [256.1, -0.5, -1e30])
def test_depth_beyond_sixteen_bits_is_none_with_a_warning(beyond):
    forget_warnings()
    depth = np.array([[0.5, 255.99, beyond, np.inf, np.nan]], np.float32)
    with pytest.warns(UsdsdgWarning, match="256 m or more ahead, or behind the camera"):
        assert depth_image(depth).tolist() == [[128, 65533, 0, 0, 0]]


def test_depth_without_a_hit_needs_no_warning(recwarn):
    forget_warnings()
    assert depth_image(np.array([[0.0, -0.0, np.inf, np.nan]], np.float32)).tolist() == [[0, 0, 0, 0]]
    assert not recwarn


def test_the_classes_of_cityscapes_are_the_default(tmp_path):
    stage = set_stage(new_stage())
    add_cube(stage, "/World/Car", "Car")
    folder = write(tmp_path, make_frame(stage, (16, 12))) / "Camera"
    # Their numbers in Cityscapes: 26 is car, 23 the sky.
    assert set(picture(folder / "semantic/0.png").ravel()) == {23, 26}
    assert picture(folder / "semantic_segmentation/0.png")[6, 8].tolist() == [0, 0, 142, 255]


def test_nothing_to_see(tmp_path):
    folder = write(tmp_path, make_frame(set_stage(new_stage()), (16, 12)))
    assert (folder / "Camera/object_detection/0.txt").read_bytes() == b""
    assert sorted(path.name for path in (folder / "Camera").iterdir()) == EVERY


def test_several_products_get_folders(street_frame, tmp_path):
    two = {f"/Render/HydraTextures/{name}": dataclasses.replace(street_frame, memo={}) for name in ("left", "right")}
    folder = write(tmp_path, two)
    assert sorted(str(path.relative_to(folder)) for path in folder.rglob("rgb/*")) == [
        "left/Camera/rgb/0.png", "right/Camera/rgb/0.png",
    ]  # fmt: skip


def test_which_labels_count(tmp_path):
    stage = set_stage(new_stage())
    add_labels(add_cube(stage, "/World/Wheel"), {"part": ["rear wheel"], "class": ["car"]})
    frame = make_frame(stage, (16, 12), filters=["class:*", "part:*", "part:*;class:*"])
    for number, (options, name) in enumerate(
        [
            ({}, "class:car"),
            ({"semantic_types": ["part"]}, "part:rear_wheel"),
            ({"semantic_types": ["part"], "omit_semantic_type": True}, "rear_wheel"),
            ({"semantic_filter_predicate": "part:*;class:*", "omit_semantic_type": True}, "car"),
        ]
    ):
        folder = write(tmp_path / str(number), frame, **options)
        ((told, _),) = lines(folder / "Camera/object_detection/0.txt")
        assert told == name


def test_a_mapping_of_a_file(street_frame, tmp_path):
    (tmp_path / "map.json").write_text('{"pear": [9, 8, 7, 6]}')
    folder = write(tmp_path / "out", street_frame, mapping_path=str(tmp_path / "map.json"))
    colors = picture(folder / "Camera/semantic_segmentation/0.png")
    assert (colors[mask_of(street_frame, "/World/Pear")] == [9, 8, 7, 6]).all()
    assert (colors[mask_of(street_frame, "/World/Apple1")] == 0).all()


def test_a_fisheye_has_no_calibration(tmp_path):
    forget_warnings()
    stage = set_stage(new_stage())
    add_cube(stage, "/World/Car", "car")
    stage.GetPrimAtPath("/World/Camera").CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set(
        "fisheyePolynomial"
    )
    with pytest.warns(UsdsdgWarning, match="no calib for a lens of model 'fisheyePolynomial'"):
        folder = write(tmp_path, make_frame(stage, (16, 12)))
    assert not (folder / "Camera/calib").exists()
    assert len(lines(folder / "Camera/object_detection/0.txt")) == 1


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"mapping_path": "a.json", "mapping_dict": {"a": 1}}, WriterError, "exclude each other"),
        ({"semantic_types": ["class"], "semantic_filter_predicate": "class:*"}, WriterError, "exclude each other"),
        ({"mapping_path": "nowhere.json"}, AssetUnreadable, "nowhere.json cannot be read"),
        ({"mapping_dict": {"car": [1, 2, 3]}}, WriterError, "'class:car' is mapped to"),
        ({"mapping_dict": {"car": [1, 2, 3, 300]}}, WriterError, "'class:car' is mapped to"),
        ({"mapping_dict": {"car": 256}}, WriterError, "'class:car' is mapped to 256"),
        ({"mapping_dict": {"car": -1}}, WriterError, "'class:car' is mapped to -1"),
        ({"bbox_height_threshold": -1}, WriterError, "expected 0 or more"),
        ({"renderproduct_idxs": [(0,)]}, Unsupported, "attach the writer"),
    ],
)
def test_wrong_options_are_refused(options, error, message, tmp_path):
    with pytest.raises(error, match=message):
        writers.get("KittiWriter", init_params={"output_dir": str(tmp_path), **options})
