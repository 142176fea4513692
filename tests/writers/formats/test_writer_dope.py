"""DOPEWriter: files, names and numbers, and what DOPE's own cuboid makes of the exact ones."""

import json
from pathlib import Path

import numpy as np
import pytest
from pxr import UsdGeom
from scipy.spatial.transform import Rotation

from tests.annotators.ray_caster import add_cube, known, make_frame, new_stage
from tests.annotators.scenes import add_camera, street
from tests.dataset_files import data_names
from usdsdg import annotators, writers
from usdsdg.errors import UsdsdgWarning, WriterError, forget_warnings
from usdsdg.session import render_products

PRODUCT, OTHER = "/Render/HydraTextures/rp1", "/Render/HydraTextures/rp2"
CLASSES = {"_03_cracker_box": 1}


def scene(*, unit: float = 1.0):
    stage = new_stage()
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    pose = {"translate": (0.4 / unit, 0, 0.3 / unit), "rotate": (20, 30, 40)}
    add_cube(stage, "/World/Box", "_03_cracker_box", size=1 / unit, **pose, scale=(1.5, 0.5, 1))
    return make_frame(stage, (64, 48), camera=add_camera(stage, "/World/Eye", np.array([2, -6, 8]) / unit, (0, 0, 0)))


@pytest.fixture(autouse=True)
def as_registered():
    yield
    if "dope" in annotators.named_annotators.registered_annotators:
        annotators.unregister_annotator("dope")


def write(folder, *frames, **options):
    writer = writers.get("DOPEWriter")
    writer.initialize(output_dir=str(folder), class_name_to_index_map=CLASSES, **options)
    sets = [each if isinstance(each, dict) else {PRODUCT: each} for each in frames]
    writer.attach(known(*sets[0]))
    for each in sets:
        writer.receive(annotators.build_payload(writer, each))
    writer.on_final_frame()
    writer.backend.wait_until_done()
    return writer


def read(folder, name="000000.json"):
    return json.loads((Path(folder) / name).read_text())


def test_a_frame_is_an_image_and_a_json_with_isaac_sims_keys(tmp_path):
    write(tmp_path, scene())
    assert data_names(tmp_path) == ["000000.json", "000000.png", "metadata.txt"]
    values = read(tmp_path)
    assert values["camera_data"] == {}
    (box,) = values["objects"]
    assert list(box) == ["class", "visibility", "location", "quaternion_wxyz", "projected_cuboid"]
    assert box["class"] == "003_cracker_box"
    assert np.shape(box["projected_cuboid"]) == (9, 2)


def test_frames_without_a_visible_object_are_left_out_and_not_counted(tmp_path):
    nothing = make_frame(new_stage(), (64, 48))
    writer = write(tmp_path, nothing, scene(), nothing)
    assert not writer.is_last_frame_valid()
    assert data_names(tmp_path) == ["000000.json", "000000.png", "metadata.txt"]


def test_a_run_without_objects_gives_a_warning(tmp_path):
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="DOPEWriter wrote none of 2 frames"):
        write(tmp_path, *[make_frame(new_stage(), (64, 48))] * 2)


def test_render_products_have_folders(tmp_path):
    write(tmp_path, {PRODUCT: scene(), OTHER: make_frame(new_stage(), (64, 48))})
    files = [f"{product}/{file}" for product in ("rp1", "rp2") for file in ("000000.json", "rgb/000000.png")]
    assert data_names(tmp_path) == ["metadata.txt", *files]
    assert read(tmp_path / "rp2")["objects"] == []


def test_exact_files_of_a_render_product_lie_together_where_dopes_training_finds_them(tmp_path):
    write(tmp_path, {PRODUCT: scene(), OTHER: scene()}, exact=True)
    files = [f"{product}/000000.{ending}" for product in ("rp1", "rp2") for ending in ("json", "png")]
    assert data_names(tmp_path) == ["metadata.txt", *files]


def test_numbers_are_those_of_the_annotator(tmp_path):
    frame = scene()
    writers.DOPEWriter.register_pose_annotator({"WIDTH": 640, "HEIGHT": 480, "CAMERA_ROTATION": [0, 0, 90]})
    write(tmp_path, frame)
    params = {"semanticTypes": ["class"], "width": 640, "height": 480, "cameraRotation": (0.0, 0.0, 90.0)}
    row = annotators.get("dope", params).compute(frame).data[0]
    (box,) = read(tmp_path)["objects"]
    assert box["location"] == row["location"].astype(float).tolist()
    assert box["quaternion_wxyz"] == row["rotation"].astype(float).tolist()
    assert box["projected_cuboid"] == row["projected_cuboid"].astype(float).tolist()


@pytest.mark.parametrize("unit", [1.0, 0.01])
def test_exact_poses_and_intrinsics_project_dopes_cuboid_to_the_keypoints(tmp_path, unit):
    """Centimeters whatever the unit of the stage."""
    write(tmp_path, scene(unit=unit), exact=True)
    values = read(tmp_path)
    (box,) = values["objects"]
    size = np.array([150, 50, 100])  # cm
    # DOPE's vertices: front is +z, top is -y; around from the top right, and the center at last.
    vertices = [(x, y, z) for z in (1, -1) for x, y in ((1, -1), (-1, -1), (-1, 1), (1, 1))] + [(0, 0, 0)]
    turn = Rotation.from_quat(np.roll(box["quaternion_wxyz"], -1))
    points = turn.apply(np.array(vertices) * size / 2) + box["location"]
    k = values["camera_data"]["intrinsics"]
    pixels = np.stack([k["fx"] * points[:, 0], k["fy"] * points[:, 1]], 1) / points[:, 2:] + (k["cx"], k["cy"])
    np.testing.assert_allclose(pixels, box["projected_cuboid"], atol=1e-3)
    assert values["camera_data"]["width"] == 64


@pytest.mark.parametrize(
    ("scale", "above", "named"),
    [((1, -1, 1), (1, 1, 1), "mirrored"), ((1, 1, 1), (1, 2, 1), "sheared"), ((-1, -2, 1), (3, 3, 3), None)],
)
def test_poses_that_no_quaternion_has_are_told(scale, above, named, tmp_path, recwarn):
    stage = new_stage()
    group = UsdGeom.Xform.Define(stage, "/World/Group")
    group.AddScaleOp().Set(above)
    add_cube(stage, "/World/Group/Box", "_03_cracker_box", rotate=(20, 30, 40), scale=scale)
    seen = make_frame(stage, (64, 48), camera=add_camera(stage, "/World/Eye", (2, -6, 8), (0, 0, 0)))
    forget_warnings()
    write(tmp_path, seen, exact=True)
    pose_writer = writers.get("PoseWriter", init_params={"output_dir": str(tmp_path / "pose")})
    pose_writer.attach(known(PRODUCT))
    pose_writer.receive(annotators.build_payload(pose_writer, {PRODUCT: seen}))
    pose_writer.backend.wait_until_done()
    told = [str(each.message) for each in recwarn if "by its transform" in str(each.message)]
    expected = [f"{name}: /World/Group/Box is {named} by its transform" for name in ("DOPEWriter", "PoseWriter")]
    assert [text.split(",")[0] for text in told] == (expected if named else [])


def test_keypoints_behind_the_camera_are_not_mirrored_with_exact(tmp_path):
    stage = new_stage()
    add_cube(stage, "/World/Wall", "wall", translate=(-2, 0, 0), scale=(0.5, 30, 3))
    frame = make_frame(stage, (64, 48), camera=add_camera(stage, "/World/Eye", (0, -8, 0), (0, 0, 0)))
    for name, exact in (("node", False), ("exact", True)):
        write(tmp_path / name, frame, exact=exact)
    mirrored = np.array(read(tmp_path / "node")["objects"][0]["projected_cuboid"])[:8, 0]
    kept = np.array(read(tmp_path / "exact")["objects"][0]["projected_cuboid"])[:8, 0]
    assert (kept < 32).all()
    assert (mirrored > 32).any()


def test_setup_writer_takes_the_configuration_of_isaac_sims_script(tmp_path):
    config = {"CLASS_NAME_TO_INDEX": CLASSES}
    places = {"output_folder": str(tmp_path), "use_s3": False, "bucket_name": None, "endpoint_url": None}
    writer = writers.DOPEWriter.setup_writer(config_data=config, writer_config=places)
    writer.attach(known(PRODUCT))
    writer.receive(annotators.build_payload(writer, {PRODUCT: scene()}))
    writer.backend.wait_until_done()
    assert writer.is_last_frame_valid()
    assert (tmp_path / "000000.json").exists()


def test_several_classes_and_hidden_objects_are_listed(tmp_path):
    write(tmp_path, make_frame(street(), (64, 48)))
    listed = {each["class"]: each["visibility"] for each in read(tmp_path)["objects"]}
    assert listed["secret"] == 0
    assert listed["apple"] > 0


def test_a_bad_bucket_name_is_an_error(tmp_path):
    with pytest.raises(WriterError, match="3 to 63 letters"):
        write(tmp_path, scene(), use_s3=True, bucket_name="ab")
    render_products.reset()
