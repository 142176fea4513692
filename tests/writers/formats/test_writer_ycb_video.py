"""YCBVideoWriter: files and names, and the numbers of Isaac Sim and of the dataset."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Usd, UsdGeom
from scipy.io import loadmat
from scipy.spatial.transform import Rotation

import usdsdg as rep
from tests.annotators.ray_caster import known, make_frame
from tests.annotators.scenes import street
from tests.dataset_files import data_names
from usdsdg import annotators, writers
from usdsdg.errors import Unsupported, UsdsdgWarning, WriterError, forget_warnings
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.writers.formats.ycb_video.ycb_pictures import depth_steps

PRODUCT = "/Render/HydraTextures/rp1"
VIDEO = "data/YCB_Video/data/0000"
EVERYTHING = dict.fromkeys(
    ["rgb", "bounding_box_2d_tight", "semantic_segmentation", "distance_to_image_plane", "pose"], True
)
CLASSES = {"Apple": 7, "pear": 3, "secret": 4, "far": 5}


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (64, 48))


def write(folder, *frames, **options):
    writer = writers.get("YCBVideoWriter")
    given = {"num_frames": len(frames), "class_name_to_index_map": CLASSES, **EVERYTHING, **options}
    writer.initialize(output_dir=str(folder), **given)
    writer.attach(known(PRODUCT))
    for each in frames:
        writer.receive(annotators.build_payload(writer, {PRODUCT: each}))
    writer.on_final_frame()
    writer.backend.wait_until_done()
    return writer


def image(folder, name):
    return np.array(Image.open(Path(folder) / VIDEO / name))


def test_files_have_isaac_sims_names(frame, tmp_path):
    write(tmp_path, frame, frame)
    endings = ("box.txt", "color.png", "depth.png", "label.png", "meta.mat")
    names = [f"{VIDEO}/00000{number}-{ending}" for number in range(2) for ending in endings]
    assert data_names(tmp_path) == [*names, "data/YCB_Video/train.txt", "metadata.txt"]
    assert (tmp_path / "data/YCB_Video/train.txt").read_text() == "0000/000000\n0000/000001\n"


def test_the_list_names_the_frames_that_there_are_in_the_end(frame, tmp_path):
    write(tmp_path, frame, num_frames=9)
    assert (tmp_path / "data/YCB_Video/train.txt").read_text() == "0000/000000\n"


def test_labels_are_the_indices_of_classes(frame, tmp_path):
    write(tmp_path, frame)
    found = image(tmp_path, "000000-label.png")
    expected = np.zeros(frame.shape, np.uint8)
    for path, index in {"/World/Apple1": 7, "/World/Apple2": 7, "/World/Pear": 3}.items():
        expected[frame.aovs["instance"] == frame.gprims.index(path)] = index
    np.testing.assert_array_equal(found, expected)
    assert found.dtype == np.uint8


def test_labels_in_a_format_that_changes_them_are_told(frame, tmp_path):
    with pytest.warns(UsdsdgWarning, match="'jpg' changes the classes of `-label` pictures"):
        write(tmp_path / "lossy", frame, image_output_format="jpg")
    color = dict.fromkeys(EVERYTHING, False) | {"rgb": True}
    with warnings.catch_warnings(record=True) as told:
        write(tmp_path / "exact", frame, image_output_format="jpg", exact=True, pose=False)
        write(tmp_path / "color", frame, image_output_format="jpg", **color)
    assert not [each for each in told if "changes the classes" in str(each.message)]
    assert {path.suffix for path in (tmp_path / "exact" / VIDEO).glob("*-label.*")} == {".png"}


def test_boxes_are_inclusive(frame, tmp_path):
    write(tmp_path, frame)
    lines = (tmp_path / VIDEO / "000000-box.txt").read_text().splitlines()
    assert [line.split()[0] for line in lines] == ["apple", "apple", "pear"]
    rows, columns = np.nonzero(frame.aovs["instance"] == frame.gprims.index("/World/Pear"))
    assert lines[2] == f"pear {columns.min()} {rows.min()} {columns.max()} {rows.max()}"


def test_names_in_boxes_have_no_blanks_and_are_told(tmp_path):
    stage = street()
    add_labels(stage.GetPrimAtPath("/World/Pear"), {"class": ["a big\n pear"]}, mode="replace")
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="is called 'a_big_pear' in boxes"):
        write(tmp_path, make_frame(stage, (64, 48)))
    lines = (tmp_path / VIDEO / "000000-box.txt").read_text().splitlines()
    assert [len(line.split(" ")) for line in lines] == [5, 5, 5]


def test_depth_is_a_picture_of_the_inverse(frame, tmp_path):
    write(tmp_path, frame)
    depth = frame.aovs["distance_to_image_plane"].astype(float)
    inverse = np.array([[1e-5 if np.isinf(d) else 1 / (100 * d) for d in row] for row in depth])
    levels = (inverse - inverse.min()) / (inverse.max() - inverse.min()) * 255
    assert np.abs(image(tmp_path, "000000-depth.png") - np.floor(levels)).max() <= 1


def test_meta_has_the_numbers_of_the_annotator(frame, tmp_path):
    intrinsics = np.array([[10.0, 0, 3], [0, 11, 4], [0, 0, 1]])
    write(tmp_path, frame, intrinsic_matrix=intrinsics, factor_depth=5000)
    meta = loadmat(tmp_path / VIDEO / "000000-meta.mat")
    rows = annotators.get("pose", {"semanticTypes": ["class"]}).compute(frame).data
    assert meta["cls_indexes"].tolist() == [[7, 7, 3]]
    assert meta["poses"].shape == (3, 4, 3)
    for index, row in enumerate(rows):
        np.testing.assert_array_equal(meta["poses"][..., index], row["prims_to_desired_camera"][:3])
        np.testing.assert_array_equal(meta["center"][index], row["center_coords_image_space"])
    np.testing.assert_array_equal(meta["intrinsic_matrix"], intrinsics)
    assert meta["factor_depth"].tolist() == [[5000]]


def test_the_same_frame_gives_the_same_bytes(frame, tmp_path):
    metas = []
    for name in ("a", "b"):
        write(tmp_path / name, frame)
        metas.append((tmp_path / name / VIDEO / "000000-meta.mat").read_bytes())
    assert metas[0] == metas[1]
    assert metas[0].startswith(b"MATLAB 5.0 MAT-file, ")


def test_a_class_without_an_index_is_left_out_with_a_warning(frame, tmp_path):
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="the class 'pear' has no index"):
        write(tmp_path, frame, class_name_to_index_map={"apple": 1})
    assert loadmat(tmp_path / VIDEO / "000000-meta.mat")["cls_indexes"].tolist() == [[1, 1]]
    assert set(np.unique(image(tmp_path, "000000-label.png"))) == {0, 1}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"class_name_to_index_map": {"pear": 300}}, "'pear': 300; expected 1 to 255"),
        ({"factor_depth": 70000}, "factor_depth is 70000"),
        ({"intrinsic_matrix": np.eye(4)}, r"shape \(4, 4\)"),
        ({"intrinsic_matrix": np.diag([500, np.nan, 1])}, "expected finite numbers"),
    ],
)
def test_values_that_do_not_fit_are_errors(frame, tmp_path, options, message):
    with pytest.raises(WriterError, match=message):
        write(tmp_path, frame, **options)


# Exact numbers, of a scene that is rendered


@pytest.fixture
def rendered(stage, tmp_path):
    """Two stretched things on a stage in centimeters, written with exact=True."""
    UsdGeom.SetStageMetersPerUnit(current_stage(), 0.01)
    for index, (name, kind) in enumerate((("mug", UsdGeom.Cube), ("can", UsdGeom.Cylinder))):
        body = kind.Define(stage, f"/World/{name}")
        add_labels(body.GetPrim(), {"class": [name]})
        body.AddTranslateOp().Set(Gf.Vec3d(120 * index - 60, 10, 30 * index))
        body.AddRotateXYZOp().Set(Gf.Vec3f(20, 30 + 40 * index, 10))
        body.AddScaleOp().Set(Gf.Vec3f(40, 25, 50))
    eye = rep.create.camera(position=(150, -350, 220), look_at=(0, 0, 0), focal_length=30, clipping_range=(1, 1e5))
    writer = rep.writers.get("YCBVideoWriter")
    writer.initialize(
        output_dir=str(tmp_path), num_frames=1, class_name_to_index_map={"mug": 1, "can": 2}, exact=True, **EVERYTHING
    )
    writer.attach(rep.create.render_product(eye, (80, 60)))
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    return tmp_path


def test_exact_depth_is_in_steps_of_the_factor(rendered):
    depth, meta = image(rendered, "000000-depth.png"), loadmat(rendered / VIDEO / "000000-meta.mat")
    assert depth.dtype == np.uint16
    near = depth[depth > 0] / meta["factor_depth"][0, 0]
    assert 3 < near.min() < near.max() < 6  # meters, on a stage in centimeters


def test_the_map_of_model_points_is_what_poses_and_intrinsics_take_to_each_pixel(rendered):
    meta, label = loadmat(rendered / VIDEO / "000000-meta.mat"), image(rendered, "000000-label.png")
    depth = image(rendered, "000000-depth.png") / meta["factor_depth"][0, 0]
    assert meta["vertmap"].dtype == np.float32
    for index, own in enumerate(meta["cls_indexes"].ravel()):
        rows, columns = np.nonzero(label == own)
        assert len(rows) > 50
        rotation, position = meta["poses"][:, :3, index], meta["poses"][:, 3, index]
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
        assert np.linalg.det(rotation) > 0
        points = meta["vertmap"][rows, columns] @ rotation.T + position
        pixels = points @ meta["intrinsic_matrix"].T
        np.testing.assert_allclose(pixels[:, :2] / pixels[:, 2:], np.stack([columns, rows], 1), atol=1e-3)
        np.testing.assert_allclose(points[:, 2], depth[rows, columns], atol=1e-4)
    assert not meta["vertmap"][label == 0].any()


def test_model_points_are_on_the_models_that_are_written(rendered):
    meta, label = loadmat(rendered / VIDEO / "000000-meta.mat"), image(rendered, "000000-label.png")
    for name, own in (("mug", 1), ("can", 2)):
        points = np.loadtxt(rendered / f"data/models/{name}/points.xyz")
        np.testing.assert_allclose(points.max(axis=0), (0.4, 0.25, 0.5), atol=2e-3)  # meters
        seen = meta["vertmap"][label == own]
        assert (np.abs(seen) <= np.abs(points).max(axis=0) + 1e-3).all()


def test_center_and_camera_of_the_world(rendered):
    meta = loadmat(rendered / VIDEO / "000000-meta.mat")
    turn, moved = meta["rotation_translation_matrix"][:, :3], meta["rotation_translation_matrix"][:, 3]
    world = turn.T @ (meta["poses"][:, 3, 0] - moved)
    np.testing.assert_allclose(world, (-0.6, 0.1, 0), atol=1e-6)
    pixel = meta["intrinsic_matrix"] @ meta["poses"][:, 3, 0]
    np.testing.assert_allclose(meta["center"][0], pixel[:2] / pixel[2])
    assert Rotation.from_matrix(turn).as_matrix() == pytest.approx(turn)


def test_a_lens_is_refused_with_exact(stage, tmp_path):
    rep.create.cube(semantics=[("class", "cube")])
    eye = rep.create.camera(position=(4, 0, 2), look_at=(0, 0, 0), projection_type="fisheyePolynomial")
    writer = rep.writers.get("YCBVideoWriter")
    writer.initialize(output_dir=str(tmp_path), num_frames=1, pose=True, exact=True)
    writer.attach(rep.create.render_product(eye, (32, 24)))
    with pytest.raises(Unsupported, match="pinholes only"):
        rep.orchestrator.step()


def test_a_shape_that_changes_during_the_run_is_told(stage, tmp_path):
    forget_warnings()
    mug = rep.functional.create.cube(scale=0.2, semantics={"class": "mug"})
    camera = rep.functional.create.camera(position=(0, -3, 0), look_at=(0, 0, 0))
    writer = writers.get("YCBVideoWriter")
    writer.initialize(
        output_dir=str(tmp_path), num_frames=2, class_name_to_index_map={"mug": 1}, exact=True, **EVERYTHING
    )
    writer.attach(rep.create.render_product(camera, (32, 24)))
    rep.orchestrator.step()
    mesh = next(UsdGeom.Mesh(each) for each in Usd.PrimRange(mug) if each.IsA(UsdGeom.Mesh))
    mesh.GetPointsAttr().Set([point * 1.5 for point in mesh.GetPointsAttr().Get()])
    with pytest.warns(UsdsdgWarning, match="differs in shape or scale from the first object of the class 'mug'"):
        rep.orchestrator.step()


def test_a_depth_behind_the_camera_is_none():
    meters = np.array([[0.5, -0.5, np.inf]], np.float32)
    assert depth_steps(meters, 1000).tolist() == [[500, 0, 0]]


def test_vertices_of_a_mesh_are_saved_in_the_frame_of_another_prim_in_meters(stage, tmp_path):
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    part = UsdGeom.Xform.Define(stage, "/World/Part")
    part.AddTranslateOp().Set(Gf.Vec3d(5, 6, 7))
    mesh = UsdGeom.Mesh.Define(stage, "/World/Part/Mesh")
    mesh.AddScaleOp().Set(Gf.Vec3f(2, 2, 2))
    mesh.CreatePointsAttr([(0, 0, 0), (10, 20, 30)])
    writers.YCBVideoWriter.save_mesh_vertices(mesh.GetPrim(), part.GetPrim(), "_03_box", str(tmp_path))
    found = (tmp_path / "data/models/_03_box/points.xyz").read_text()
    assert found == "0.000000 0.000000 0.000000\n0.200000 0.400000 0.600000\n"


def test_setup_writer_takes_the_configuration_of_isaac_sims_script(frame, tmp_path):
    config = {"CLASS_NAME_TO_INDEX": CLASSES, "F_X": 9.0, "F_Y": 8.0, "C_X": 7.0, "C_Y": 6.0}
    config |= {"WIDTH": 64, "HEIGHT": 48, "CAMERA_ROTATION": [180, 0, 0]}
    try:
        writers.YCBVideoWriter.register_pose_annotator(config_data=config)
        writer = writers.YCBVideoWriter.setup_writer(config, {"output_folder": str(tmp_path), "train_size": 2})
        writer.attach(known(PRODUCT))
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
        writer.backend.wait_until_done()
        assert writer.is_last_frame_valid()
        meta = loadmat(tmp_path / VIDEO / "000000-meta.mat")
        assert meta["intrinsic_matrix"].tolist() == [[9, 0, 7], [0, 8, 6], [0, 0, 1]]
    finally:
        annotators.unregister_annotator("pose")


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("own", [("apple,ripe", 9), ("ripe", 9)])
def test_an_object_of_several_classes_is_of_one_class_in_all_files(tmp_path, exact, own):
    stage = street()
    add_labels(stage.GetPrimAtPath("/World/Pear"), {"class": ["apple", "ripe"]}, mode="replace")
    own_name, own_index = own
    indices = {**CLASSES, own_name: own_index}
    frame = make_frame(stage, (64, 48))
    write(tmp_path, frame, class_name_to_index_map=indices, exact=exact)
    pixels = image(tmp_path, "000000-label.png")[frame.aovs["instance"] == frame.gprims.index("/World/Pear")]
    (index,) = set(pixels.tolist())
    name = {each: kind for kind, each in indices.items()}[index].lower()
    assert name == (own_name if "," in own_name else "apple")
    meta = loadmat(tmp_path / VIDEO / "000000-meta.mat")
    assert sorted(set(meta["cls_indexes"].ravel().tolist())) == sorted({7, index})
    lines = (tmp_path / VIDEO / "000000-box.txt").read_text().splitlines()
    assert {line.split()[0] for line in lines} == {"apple", name}
