import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from PIL import Image
from scipy.spatial.transform import Rotation

from tests.annotators.ray_caster import add_cube, known, make_frame, new_stage
from tests.annotators.scenes import add_camera, crowds, mask_of, street
from tests.dataset_files import data_names
from usdsdg import annotators, writers
from usdsdg.errors import OutputNotWritable, Unsupported, UsdsdgWarning, WriterError, forget_warnings

PRODUCT = "/Render/HydraTextures/rp1"


def write(folder, frames, **options):
    """Write `frames` (one, or {path: frame} each time) and return the writer."""
    writer = writers.get("PoseWriter")
    writer.initialize(output_dir=str(folder), **options)
    sets = [f if isinstance(f, dict) else {PRODUCT: f} for f in (frames if isinstance(frames, list) else [frames])]
    writer.attach(known(*sets[0]))
    for each in sets:
        writer.receive(annotators.build_payload(writer, each))
    writer.backend.wait_until_done()
    return writer


def read(folder, name="000000.json"):
    return json.loads((Path(folder) / name).read_text())


def files(folder):
    return data_names(folder)


# A scene whose file is known: three cubes seen from (-4, -4, 8). Facts of a published file of Isaac Sim 6.


@pytest.fixture(scope="module")
def three_cubes():
    stage = new_stage()
    add_cube(stage, "/World/Cube1", "cube")
    add_cube(stage, "/World/Cube2", "cube_rotated", translate=(-1, -1, 0), rotate=(0, 0, 45))
    add_cube(stage, "/World/Cube3", "cube_scaled", translate=(1, 1, 0), rotate=(75, 65, 0), scale=(1.5, 0.5, 1))
    add_camera(stage, "/World/Camera2", (-4, -4, 8), (0, 0, 0), near=1.0)
    return make_frame(stage, (512, 512), camera="/World/Camera2")


@pytest.fixture(scope="module")
def three_cubes_json(three_cubes, tmp_path_factory):
    folder = tmp_path_factory.mktemp("cubes")
    write(folder, three_cubes)
    return read(folder)


def test_camera_data_of_the_known_scene(three_cubes_json):
    camera = three_cubes_json["camera_data"]
    assert list(camera) == [
        "aperture",
        "aperture_offset",
        "focal_length",
        "resolution",
        "meters_per_scene_unit",
        "intrinsics",
        "camera_view_matrix",
        "camera_projection_matrix",
    ]
    assert camera["aperture"] == pytest.approx([20.954999923706055, 15.290800094604492])
    assert camera["resolution"] == [512, 512]
    intrinsics = {"fx": 586.3994294792998, "fy": 586.3994294792998, "cx": 256.0, "cy": 256.0}
    assert camera["intrinsics"] == pytest.approx(intrinsics)
    view = [[0.70711, 0.57735, -0.40825, 0], [-0.70711, 0.57735, -0.40825, 0], [0, 0.57735, 0.8165, 0]]
    np.testing.assert_allclose(camera["camera_view_matrix"], [*view, [0, 0, -9.79796, 1]], atol=1e-5)
    projection = [[2.29062, 0, 0, 0], [0, 2.29062, 0, 0], [0, 0, 0, -1], [0, 0, 1, 0]]
    np.testing.assert_allclose(camera["camera_projection_matrix"], projection, atol=2e-3)


KNOWN = {
    "cube": {
        "visibility": 0.906,
        "location_camera_frame": [0, 0, -9.797958971132712],
        "quat_wxyz_camera_frame": [0.8804762407915179, -0.27984813737974173, 0.11591689390753808, 0.36470520028312564],
        "size": [1, 1, 1],
        "cuboid_keypoints_projected": [
            [256, 256], [256, 308], [256, 275], [215, 273], [212, 238], [297, 273], [300, 238], [256, 240], [256, 204],
        ],
    },
    "cube_rotated": {
        "visibility": 1.0,
        # Not where the cube is: the matrices are multiplied in the order that Replicator multiplies them.
        "location_camera_frame": [-1, -1, -9.797958971132712],
        "quat_wxyz_world_frame": [0.9238795325112867, 0, 0, 0.3826834323650898],
        "size": [1, 1, 1],
        "cuboid_keypoints_projected": [
            [256, 331], [288, 375], [291, 346], [224, 375], [221, 346], [286, 319], [289, 286], [226, 319], [223, 286],
        ],
    },
    "cube_scaled": {
        "visibility": 0.927,
        "location_camera_frame": [-1.2983043802273047, 10.464101496467297, -1.0717169293974516],
        "quat_wxyz_camera_frame": [0.8026927065102448, 0.4581865859317811, 0.3571663785670376, 0.13483934666388836],
        "size": [1.5, 0.5, 1],
        "cuboid_keypoints_projected": [
            [256, 192], [212, 179], [262, 198], [225, 154], [275, 172], [240, 210], [285, 227], [251, 187], [296, 204],
        ],
    },
}  # fmt: skip


@pytest.mark.parametrize("label", KNOWN)
def test_objects_of_the_known_scene(three_cubes_json, label):
    (seen,) = (o for o in three_cubes_json["objects"] if o["label"] == label)
    for key, value in KNOWN[label].items():
        got, wanted = np.array(seen[key]), np.array(value)
        if key.startswith("quat") and got @ wanted < 0:
            got = -got  # the same rotation
        np.testing.assert_allclose(got, wanted, atol=2e-6, err_msg=key)
    assert seen["truncation_ratio"] == 0


def test_keys_of_an_object_in_order(three_cubes_json):
    assert list(three_cubes_json) == ["camera_data", "keypoint_order", "objects"]
    assert three_cubes_json["keypoint_order"] == ["Center", "LDB", "LDF", "LUB", "LUF", "RDB", "RDF", "RUB", "RUF"]
    assert list(three_cubes_json["objects"][0]) == [
        "label",
        "prim_path",
        "visibility",
        "local_to_world_transform",
        "location_world_frame",
        "rotation_matrix_world_frame",
        "quat_wxyz_world_frame",
        "location_camera_frame",
        "rotation_matrix_camera_frame",
        "quat_wxyz_camera_frame",
        "size",
        "cuboid_keypoints_world_frame",
        "cuboid_keypoints_camera_frame",
        "cuboid_keypoints_projected",
        "truncation_ratio",
    ]


def test_dope_format(three_cubes, tmp_path, three_cubes_json):
    write(tmp_path, three_cubes, format="dope")
    data = read(tmp_path)
    assert data["keypoint_order"] == ["LUF", "RUF", "RDF", "LDF", "LUB", "RUB", "RDB", "LDB", "Center"]
    assert list(data["camera_data"]) == ["intrinsics", "camera_view_matrix", "camera_projection_matrix"]
    keys = ["class", "prim_path", "visibility", "location", "quaternion_xyzw", "projected_cuboid", "truncation_ratio"]
    for dope, plain in zip(data["objects"], three_cubes_json["objects"]):
        assert list(dope) == keys
        by_name = dict(zip(three_cubes_json["keypoint_order"], plain["cuboid_keypoints_projected"]))
        assert dope["projected_cuboid"] == [by_name[name] for name in data["keypoint_order"]]
        assert dope["location"] == plain["location_camera_frame"]
        w, *xyz = plain["quat_wxyz_camera_frame"]
        assert dope["quaternion_xyzw"] == [*xyz, w]


def test_centerpose_format(three_cubes, tmp_path, three_cubes_json):
    write(tmp_path, three_cubes, format="CenterPose")
    data = read(tmp_path)
    assert data["keypoint_order"] == three_cubes_json["keypoint_order"]
    assert (data["camera_data"]["width"], data["camera_data"]["height"]) == (512, 512)
    for seen, plain in zip(data["objects"], three_cubes_json["objects"]):
        assert list(seen) == [
            "label",
            "prim_path",
            "visibility",
            "location",
            "quaternion_xyzw",
            "scale",
            "keypoints_3d",
            "projected_cuboid",
            "truncation_ratio",
        ]
        assert seen["scale"] == plain["size"]
        assert seen["keypoints_3d"] == plain["cuboid_keypoints_camera_frame"]


def test_the_exact_camera_frame_is_where_the_keypoints_are(three_cubes, tmp_path):
    write(tmp_path, three_cubes, exact_camera_frame=True)
    for seen in read(tmp_path)["objects"]:
        np.testing.assert_allclose(seen["location_camera_frame"], seen["cuboid_keypoints_camera_frame"][0], atol=1e-6)


@pytest.mark.parametrize("format", [None, "dope", "centerpose"])
def test_an_exact_pose_and_the_intrinsics_give_the_keypoints(three_cubes, tmp_path, format):
    """With nothing of usdsdg: a quaternion, a translation and a pinhole, for cubes of known size."""
    sizes = {"cube": (1, 1, 1), "cube_rotated": (1, 1, 1), "cube_scaled": (1.5, 0.5, 1)}
    write(tmp_path, three_cubes, format=format, exact_camera_frame=True)
    data = read(tmp_path)
    lens = data["camera_data"]["intrinsics"]
    signs = {"L": -1, "R": 1, "D": -1, "U": 1, "B": -1, "F": 1}
    corners = np.array(
        [[0] * 3 if name == "Center" else [signs[s] / 2 for s in name] for name in data["keypoint_order"]]
    )
    assert len(data["objects"]) == 3
    for seen in data["objects"]:
        w, *xyz = seen["quat_wxyz_camera_frame"] if format is None else np.roll(seen["quaternion_xyzw"], 1)
        location = seen["location_camera_frame" if format is None else "location"]
        points = Rotation.from_quat([*xyz, w]).apply(corners * sizes[seen.get("label") or seen["class"]]) + location
        columns = lens["cx"] + lens["fx"] * points[:, 0] / -points[:, 2]
        rows = lens["cy"] - lens["fy"] * points[:, 1] / -points[:, 2]
        written = np.array(seen["cuboid_keypoints_projected" if format is None else "projected_cuboid"])
        # Written pixels are whole numbers.
        assert np.abs(np.stack([columns, rows], axis=1) - written).max() <= 0.5 + 1e-3


def test_intrinsics_that_do_not_describe_the_picture_are_announced(tmp_path):
    stage = street()
    stage.GetPrimAtPath("/World/Camera").GetAttribute("projection").Set("orthographic")
    stage.GetPrimAtPath("/World/Camera").GetAttribute("horizontalAperture").Set(60.0)
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match=r"fx and fy .* 'orthographic'"):
        write(tmp_path, make_frame(stage, (96, 72)), skip_empty_frames=False)


def test_the_picture_is_the_frames(three_cubes, tmp_path):
    write(tmp_path, three_cubes)
    assert files(tmp_path) == ["000000.json", "000000.png", "metadata.txt"]
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "000000.png")), three_cubes.aovs["LdrColor"])
    metadata = json.loads((tmp_path / "metadata.txt").read_text())
    assert list(metadata) == ["name", "version", "replicator_global_seed:"]
    assert (metadata["name"], metadata["version"]) == ("PoseWriter", "0.2.0")


# What is written when


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (96, 72))


@pytest.fixture(scope="module")
def empty():
    return make_frame(new_stage(), (96, 72))


def test_hidden_and_outside_objects_are_left_out(frame, tmp_path):
    write(tmp_path, frame)
    assert [o["prim_path"] for o in read(tmp_path)["objects"]] == ["/World/Apple1", "/World/Apple2", "/World/Pear"]


def test_the_threshold_drops_less_visible_objects(frame, tmp_path):
    write(tmp_path, frame, visibility_threshold=0.95)
    assert [o["prim_path"] for o in read(tmp_path)["objects"]] == ["/World/Apple1", "/World/Pear"]


def test_empty_frames_are_skipped_and_take_no_number(frame, empty, tmp_path):
    writer = write(tmp_path, [empty, frame, empty, frame])
    assert files(tmp_path) == ["000000.json", "000000.png", "000001.json", "000001.png", "metadata.txt"]
    assert writer.get_current_frame_id() == 2


def test_it_says_so_where_all_frames_were_empty(frame, empty, tmp_path, recwarn):
    forget_warnings()
    write(tmp_path / "one", [empty, frame]).on_final_frame()
    assert not [warning for warning in recwarn if "PoseWriter wrote none" in str(warning.message)]
    writer = write(tmp_path / "none", [empty, empty])
    with pytest.warns(UsdsdgWarning, match="PoseWriter wrote none of 2 images.*skip_empty_frames=False"):
        writer.on_final_frame()


def test_empty_frames_are_written_when_asked_for(empty, tmp_path):
    write(tmp_path, empty, skip_empty_frames=False, write_debug_images=True, frame_padding=3)
    assert read(tmp_path, "000.json")["objects"] == []
    assert files(tmp_path) == ["000.json", "000.png", "000_overlay.png", "metadata.txt"]


def test_products_share_a_folder_with_numbers_or_numbers_with_folders(frame, empty, tmp_path):
    both = {"/Render/a": frame, "/Render/b": frame}
    write(tmp_path / "flat", [both, both])
    assert [f for f in files(tmp_path / "flat") if f.endswith("json")] == [f"{i:06d}.json" for i in range(4)]
    one_empty = {"/Render/a": frame, "/Render/b": empty}
    write(tmp_path / "deep", [one_empty, both], use_subfolders=True)
    assert [f for f in files(tmp_path / "deep") if f.endswith("json")] == [
        "a/000000.json",
        "a/000001.json",
        "b/000001.json",
    ]


def test_a_jpeg_when_asked_for(frame, tmp_path):
    write(tmp_path, frame, image_output_format="jpg")
    assert Image.open(tmp_path / "000000.jpg").format == "JPEG"


def test_only_classes_are_posed_and_parts_belong_to_them(tmp_path):
    from usdsdg.stage.semantics.labels import add_labels

    stage = new_stage()
    add_labels(add_cube(stage, "/World/Car", "car"), {"color": ["red"]})
    add_labels(add_cube(stage, "/World/Car/Wheel", translate=(1, 0, 0)), {"part": ["wheel"]})
    write(tmp_path, make_frame(stage, filters=["class:*"]))
    (car,) = read(tmp_path)["objects"]
    assert (car["label"], car["prim_path"]) == ("car", "/World/Car")
    np.testing.assert_allclose(car["size"], [2, 1, 1])


# Geometry


def projected_rectangle(seen):
    points = np.array(seen["cuboid_keypoints_projected"])
    return points.min(axis=0), points.max(axis=0)


@given(stage=crowds())
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_the_projected_cuboid_encloses_the_mask(stage, tmp_path_factory):
    folder = tmp_path_factory.mktemp("crowd")
    frame = make_frame(stage, (64, 48))
    write(folder, frame, skip_empty_frames=False)
    for seen in read(folder)["objects"]:
        v, u = np.nonzero(mask_of(frame, seen["prim_path"]))
        low, high = projected_rectangle(seen)
        # Masks hold pixel centers; keypoints are rounded to whole pixels.
        assert (np.array([u.min() + 0.5, v.min() + 0.5]) >= low - 1).all()
        assert (np.array([u.max() + 0.5, v.max() + 0.5]) <= high + 1).all()


@given(stage=crowds())
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_keypoints_in_all_frames_are_one_box(stage, tmp_path_factory):
    folder = tmp_path_factory.mktemp("crowd")
    frame = make_frame(stage, (64, 48))
    write(folder, frame, skip_empty_frames=False)
    for seen in read(folder)["objects"]:
        world = np.array(seen["cuboid_keypoints_world_frame"])
        pixels, _ = frame.camera.project(world)
        # transform and bounds are float32: about 1e-6 of a few meters, seen by a lens of 73 pixels
        assert np.abs(pixels - np.array(seen["cuboid_keypoints_projected"])).max() <= 0.5 + 1e-3
        edges = np.linalg.norm(world[[5, 3, 2]] - world[1], axis=1)
        np.testing.assert_allclose(edges, seen["size"], rtol=1e-4, atol=1e-6)


def test_truncation_is_the_share_of_the_rectangle_outside(tmp_path):
    stage = new_stage()
    # Its near face, 9.5 m away, has its middle on the left border of the picture.
    edge = 9.5 * 0.5 * 20.955 / 24.0
    add_cube(stage, "/World/Cube", "cube", translate=(-edge, 0, 0))
    write(tmp_path, make_frame(stage, (100, 100)))
    (seen,) = read(tmp_path)["objects"]
    low, high = projected_rectangle(seen)
    assert seen["truncation_ratio"] == pytest.approx(1 - high[0] / (high[0] - low[0]))
    # A little less than half, because the far face reaches further into the picture.
    assert 0.3 < seen["truncation_ratio"] < 0.5


@pytest.fixture(scope="module")
def around_the_camera():
    """A long slanted box that the camera stands beside: one end is far in front, the other behind."""
    stage = new_stage()
    add_cube(stage, "/World/Beam", "beam", translate=(0.9, 0.1, 8), rotate=(5, -15, 0), scale=(0.5, 0.5, 8))
    return make_frame(stage, (128, 96))


def test_a_box_that_reaches_behind_the_camera_is_not_mirrored(around_the_camera, tmp_path):
    assert around_the_camera.visible_pixels(None)[0] > 0
    write(tmp_path, around_the_camera)
    data = read(tmp_path)
    (seen,) = data["objects"]
    for name, pixel, point in zip(
        data["keypoint_order"], seen["cuboid_keypoints_projected"], seen["cuboid_keypoints_camera_frame"]
    ):
        assert (pixel[0] - 64) * point[0] >= 0, name
        assert (48 - pixel[1]) * point[1] >= 0, name
    _, u = np.nonzero(mask_of(around_the_camera, "/World/Beam"))
    low, high = projected_rectangle(seen)
    assert low[0] - 1 <= u.min() + 0.5
    assert u.max() + 0.5 <= high[0] + 1
    assert 0.5 < seen["truncation_ratio"] < 1


def test_truncation_of_a_box_around_the_camera_counts_what_is_in_front(around_the_camera, tmp_path):
    write(tmp_path, around_the_camera)
    (seen,) = read(tmp_path)["objects"]
    # Points all over the box's edges, those beyond the near plane projected one by one.
    corners = list(zip(read(tmp_path)["keypoint_order"], np.array(seen["cuboid_keypoints_world_frame"])))[1:]
    t = np.linspace(0, 1, 20001)[:, None]
    pairs = [(a, b) for m, a in corners for n, b in corners if sum(x != y for x, y in zip(m, n)) == 1]
    edges = [a + t * (b - a) for a, b in pairs]
    pixels, depth = around_the_camera.camera.project(np.concatenate(edges))
    pixels = pixels[depth >= 0.1]
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    inside = np.prod(np.clip(high, 0, (128, 96)) - np.clip(low, 0, (128, 96)))
    # The nearest sample is up to 8 m / 20000 beyond the plane at 0.1 m.
    assert seen["truncation_ratio"] == pytest.approx(1 - inside / np.prod(high - low), abs=0.01)


def test_what_has_no_visibility_is_left_out(frame, tmp_path):
    writer = writers.get("PoseWriter", init_params={"output_dir": str(tmp_path)})
    writer.attach(PRODUCT)
    payload = annotators.build_payload(writer, {PRODUCT: frame})
    seen = payload["renderProducts"]["rp1"]
    boxes = dict(seen["bounding_box_3d_fast"])
    boxes["data"] = boxes["data"].copy()
    boxes["data"]["occlusionRatio"][:] = np.nan
    writer.receive({"renderProducts": {"rp1": {**seen, "bounding_box_3d_fast": boxes}}})
    writer.backend.wait_until_done()
    assert files(tmp_path) == ["metadata.txt"]


def test_a_shifted_aperture_moves_the_principal_point(tmp_path):
    stage = street()
    camera = stage.GetPrimAtPath("/World/Camera")
    camera.GetAttribute("horizontalApertureOffset").Set(2.0)
    camera.GetAttribute("verticalApertureOffset").Set(-1.0)
    frame = make_frame(stage, (96, 72))
    write(tmp_path, frame, skip_empty_frames=False)
    intrinsics = read(tmp_path)["camera_data"]["intrinsics"]
    assert intrinsics["cx"] == pytest.approx(frame.camera.cx)
    assert intrinsics["cy"] == pytest.approx(frame.camera.cy)
    assert abs(intrinsics["cx"] - 48) > 5


# The overlay


def test_the_overlay_changes_the_picture_only_near_boxes_and_in_the_corner(frame, tmp_path):
    write(tmp_path, frame, write_debug_images=True)
    overlay = np.array(Image.open(tmp_path / "000000_overlay.png")).astype(int)
    plain = np.array(Image.open(tmp_path / "000000.png")).astype(int)
    changed = (overlay != plain).any(axis=-1)
    assert changed.any()
    allowed = np.zeros_like(changed)
    allowed[-12:, :12] = True  # the world's axes
    for seen in read(tmp_path)["objects"]:
        low, high = projected_rectangle(seen)
        allowed[max(low[1] - 6, 0) : high[1] + 7, max(low[0] - 6, 0) : high[0] + 7] = True
    assert not (changed & ~allowed).any()
    assert changed[-12:, :12].any()


def test_the_overlay_draws_keypoints_in_their_colors(three_cubes, tmp_path):
    write(tmp_path, three_cubes, write_debug_images=True)
    overlay = np.array(Image.open(tmp_path / "000000_overlay.png"))
    (seen,) = (o for o in read(tmp_path)["objects"] if o["label"] == "cube_rotated")
    colors = [(255, 255, 255), (255, 0, 0), (0, 128, 0), (0, 0, 255), (255, 255, 0)]
    for (u, v), color in zip(seen["cuboid_keypoints_projected"][:5], colors, strict=True):
        assert tuple(overlay[v, u, :3]) == color


def test_the_overlay_of_a_box_around_the_camera_stays_on_its_side(around_the_camera, tmp_path):
    write(tmp_path, around_the_camera, write_debug_images=True)
    overlay = np.array(Image.open(tmp_path / "000000_overlay.png")).astype(int)
    plain = np.array(Image.open(tmp_path / "000000.png")).astype(int)
    changed = (overlay != plain).any(axis=-1)
    # The beam is wholly right of the axis; mirrored edges would cross the left half (the corner holds the axes).
    assert not changed[:80, :58].any()
    assert changed[:80, 70:].any()


def test_the_overlay_draws_edges_where_their_points_are(around_the_camera, tmp_path):
    """An edge that ends behind the camera is cut in the scene, not bent in the picture."""
    write(tmp_path, around_the_camera, write_debug_images=True)
    overlay = np.array(Image.open(tmp_path / "000000_overlay.png")).astype(int)
    plain = np.array(Image.open(tmp_path / "000000.png")).astype(int)
    changed = (overlay != plain).any(axis=-1)
    (seen,) = read(tmp_path)["objects"]
    corners = dict(zip(read(tmp_path)["keypoint_order"], np.array(seen["cuboid_keypoints_world_frame"])))
    for side in ("LD", "LU", "RD", "RU"):
        far, near = corners[f"{side}B"], corners[f"{side}F"]
        assert far[2] < 10 < near[2]
        pixels, depth = around_the_camera.camera.project(far + np.linspace(0, 1, 500)[:, None] * (near - far))
        u, v = pixels[(depth > 0.1)].T
        shown = (u >= 0) & (u < 128) & (v >= 0) & (v < 96)
        assert shown.sum() > 10
        assert changed[v[shown].astype(int), u[shown].astype(int)].all()


# Bad input


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"format": "dopey"}, WriterError, "'dopey' does not exist"),
        ({"image_output_format": "bmp"}, WriterError, "'png'"),
        ({"image_output_format": "exr"}, Unsupported, "exr"),
        ({"use_s3": True}, WriterError, "use_s3 needs a bucket; give s3_bucket"),
        ({"backend": "disk"}, WriterError, "BaseBackend"),
    ],
)
def test_wrong_options_are_refused(tmp_path, options, error, message):
    with pytest.raises(error, match=message):
        writers.get("PoseWriter", init_params={"output_dir": str(tmp_path), **options})


def test_somewhere_to_write_is_needed():
    with pytest.raises(WriterError, match="output_dir"):
        writers.get("PoseWriter", init_params={})


def test_an_unwritable_folder_is_refused_before_the_first_frame(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputNotWritable, match="file/out"):
        writers.get("PoseWriter", init_params={"output_dir": str(tmp_path / "file/out")})


def test_a_backend_and_a_folder_both_get_everything(frame, tmp_path):
    write(tmp_path / "a", frame, backend=writers.DiskBackend(tmp_path / "b"))
    assert files(tmp_path / "a") == files(tmp_path / "b") == ["000000.json", "000000.png", "metadata.txt"]


def test_no_json_without_its_picture(frame, tmp_path, monkeypatch):
    def full(path, data):
        raise OutputNotWritable(f"{path} cannot be written: the disk is full.")

    writer = writers.get("PoseWriter", init_params={"output_dir": str(tmp_path)})
    writer.attach(PRODUCT)
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    writer.backend.wait_until_done()
    real = writers.DiskBackend.write_blob
    monkeypatch.setattr(
        writers.DiskBackend, "write_blob", lambda self, p, d: full(p, d) if p.endswith("png") else real(self, p, d)
    )
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    with pytest.raises(OutputNotWritable, match=r"000001\.png"):
        writer.backend.wait_until_done()
    assert files(tmp_path) == ["000000.json", "000000.png", "metadata.txt"]
