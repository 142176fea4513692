import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.annotators.kinds.test_skeleton import add_character
from tests.annotators.ray_caster import known, make_frame, new_stage, place
from tests.annotators.scenes import mask_of
from tests.dataset_files import data_names
from usdsdg import annotators, functional, writers
from usdsdg.annotators.colors import colors_of_ids
from usdsdg.errors import ConfigError, WriterError
from usdsdg.inspect.dataset import read_dataset
from usdsdg.session.stage_context import set_stage

PRODUCT = "/Render/HydraTextures/rp1"
ALL = [
    "rgb",
    "bounding_box_2d_tight",
    "bounding_box_2d_loose",
    "semantic_segmentation",
    "instance_id_segmentation",
    "instance_segmentation",
    "distance_to_camera",
    "distance_to_image_plane",
    "bounding_box_3d",
    "occlusion",
    "normals",
    "motion_vectors",
    "camera_params",
    "pointcloud",
]


def write(folder, frames, payload=None, count=1, **options):
    writer = writers.get("BasicWriter")
    writer.initialize(output_dir=str(folder), **options)
    frames = frames if isinstance(frames, dict) else {PRODUCT: frames}
    writer.attach(known(*frames))
    for _ in range(count):
        writer.receive(annotators.build_payload(writer, frames, **(payload or {})))
    writer.backend.wait_until_done()
    return writer


def files(folder):
    return data_names(folder)


def image(folder, name):
    return np.array(Image.open(Path(folder) / name))


def read(folder, name):
    return json.loads((Path(folder) / name).read_text())


@pytest.fixture(scope="module")
def everything(frame, tmp_path_factory):
    folder = tmp_path_factory.mktemp("all")
    write(folder, frame, colorize_depth=True, **dict.fromkeys(ALL, True))
    return folder


def test_every_file_of_every_annotator(everything):
    assert files(everything) == sorted(
        [
            "metadata.txt",
            "rgb_0000.png",
            "normals_0000.png",
            "distance_to_camera_0000.npy",
            "distance_to_camera_0000.png",
            "distance_to_image_plane_0000.npy",
            "distance_to_image_plane_0000.png",
            "motion_vectors_0000.npy",
            "occlusion_0000.npy",
            "semantic_segmentation_0000.png",
            "semantic_segmentation_labels_0000.json",
            "instance_id_segmentation_0000.png",
            "instance_id_segmentation_mapping_0000.json",
            "instance_segmentation_0000.png",
            "instance_segmentation_mapping_0000.json",
            "instance_segmentation_semantics_mapping_0000.json",
            *(
                f"bounding_box_{kind}_{part}"
                for kind in ("2d_tight", "2d_loose", "3d")
                for part in ("0000.npy", "labels_0000.json", "prim_paths_0000.json")
            ),
            "camera_params_0000.json",
            *(f"pointcloud_{part}0000.npy" for part in ("", "rgb_", "normals_", "semantic_", "instance_")),
        ]
    )


def test_arrays_and_pictures_come_back(everything, frame):
    np.testing.assert_array_equal(image(everything, "rgb_0000.png"), frame.aovs["LdrColor"])
    depth = np.load(everything / "distance_to_camera_0000.npy")
    np.testing.assert_array_equal(depth, frame.aovs["distance_to_camera"])
    assert depth.dtype == np.float32
    assert np.load(everything / "motion_vectors_0000.npy").shape == (48, 64, 4)
    normals = image(everything, "normals_0000.png")[..., :3] / 255 * 2 - 1
    # 8 bits over a range of 2, truncated
    assert np.abs(normals - frame.aovs["normals"]).max() <= 2 / 255 + 1e-6


def test_masks_boxes_and_depth_of_one_frame_agree(everything, frame):
    segmentation = image(everything, "instance_segmentation_0000.png")
    color_of = {path: color for color, path in read(everything, "instance_segmentation_mapping_0000.json").items()}
    boxes = np.load(everything / "bounding_box_2d_tight_0000.npy")
    paths = read(everything, "bounding_box_2d_tight_prim_paths_0000.json")
    labels = read(everything, "bounding_box_2d_tight_labels_0000.json")
    depth = np.load(everything / "distance_to_camera_0000.npy")
    assert len(paths) == len(boxes) == 3
    for path, box in zip(paths, boxes):
        mask = (segmentation == json.loads(color_of[path].replace("(", "[").replace(")", "]"))).all(axis=-1)
        np.testing.assert_array_equal(mask, mask_of(frame, path))
        y, x = np.nonzero(mask)
        assert [box[k] for k in ("x_min", "y_min", "x_max", "y_max")] == [x.min(), y.min(), x.max(), y.max()]
        assert np.isfinite(depth[mask]).all()
        assert labels[str(box["semanticId"])]["class"] in path.lower()


def test_segmentation_tables_are_keyed_by_color(everything, frame):
    table = read(everything, "semantic_segmentation_labels_0000.json")
    assert list(table)[:2] == ["(0, 0, 0, 0)", "(0, 0, 0, 255)"]
    assert table["(0, 0, 0, 255)"] == {"class": "UNLABELLED"}
    assert table[str(tuple(colors_of_ids(np.array([2]))[0].tolist()))] == {"class": "apple"}
    assert image(everything, "semantic_segmentation_0000.png").shape == (48, 64, 4)


def test_plain_ids_are_gray_and_keyed_by_number(frame, tmp_path):
    write(tmp_path, frame, semantic_segmentation=True, colorize_semantic_segmentation=False)
    ids = image(tmp_path, "semantic_segmentation_0000.png")
    assert ids.shape == (48, 64)
    assert (ids[mask_of(frame, "/World/Apple1")] == 2).all()
    assert read(tmp_path, "semantic_segmentation_labels_0000.json")["2"] == {"class": "apple"}


def test_camera_params_are_flat_lists(everything):
    params = read(everything, "camera_params_0000.json")
    assert len(params["cameraViewTransform"]) == len(params["cameraProjection"]) == 16
    assert params["renderProductResolution"] == [64, 48]


def test_colorized_depth_goes_from_white_to_black_over_the_distances_of_the_frame(everything, frame):
    for name in ("distance_to_camera", "distance_to_image_plane"):
        depth, gray = frame.aovs[name], image(everything, f"{name}_0000.png")
        seen = np.isfinite(depth)
        near, far = depth[seen].min(), depth[seen].max()
        assert set(gray[depth == near]) == {255}
        assert set(gray[depth == far]) == {0}
        assert (gray[~seen] == 0).all()
        # Equal ratios of distances are equal steps of gray.
        expected = 255 * np.log(far / depth[seen]) / np.log(far / near)
        assert np.abs(gray[seen] - expected).max() <= 1  # truncated, in float32


def test_the_payload_names_annotators_as_replicator_does(frame, tmp_path):
    """Scripts read `writer.get_data()["annotators"]["instance_segmentation_fast"][product]["idToSemantics"]`."""
    writer = write(tmp_path, frame, colorize_instance_segmentation=False, **dict.fromkeys(ALL, True))
    fast = {name: name + "_fast" for name in ALL if name.startswith(("bounding_box", "instance"))}
    names = {fast.get(name, name) for name in ALL}
    payload = writer.get_data()["annotators"]
    assert set(payload) == names | {"camera", "resolution"}
    assert set(writer.get_annotators()) == names
    (seen,) = payload["instance_segmentation_fast"].values()
    assert {"class": "apple"} in seen["idToSemantics"].values()
    assert all(isinstance(key, int) for key in seen["idToLabels"])
    (boxes,) = payload["bounding_box_2d_tight_fast"].values()
    assert list(boxes["idToLabels"]) == list(range(len(boxes["idToLabels"])))


def test_subclasses_write_with_replicators_methods_and_attributes(frame, tmp_path):
    # As isaacsim.replicator.agent's IRABasicWriter; names and first values of omni.replicator.core 1.12.27. There the
    # sequence is 0 until BasicWriter's own `write` has set it, so that numbers have a digit more.
    class ByCamera(writers.BasicWriter):
        def __init__(self, **options):
            super().__init__(**options)
            self.data_structure = "renderProduct"

        def write(self, data):
            for seen in data["renderProducts"].values():
                for name in ("rgb", "distance_to_camera", "normals", "semantic_segmentation", "camera_params"):
                    getattr(self, f"_write_{name}")(seen[name], f"cam/{name}/")
                self._write_bounding_box_data(seen["bounding_box_2d_tight_fast"], "2d_tight", "cam/boxes/")
                path = f"cam/own_{self._sequence_id}{self._frame_id:0{self._frame_padding}}.json"
                self._backend.schedule(functional.write_json, data={"dir": self._output_dir}, path=path)
            self._frame_id += 1

    asked = ["rgb", "distance_to_camera", "normals", "semantic_segmentation", "camera_params", "bounding_box_2d_tight"]
    writer = ByCamera(output_dir=str(tmp_path), colorize_depth=True, frame_padding=3, **dict.fromkeys(asked, True))
    assert (writer._image_output_format, writer.colorize_depth, writer.use_common_output_dir) == ("png", True, False)
    assert writer.colorize_semantic_segmentation
    writer.attach(known(PRODUCT))
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    writer.backend.wait_until_done()
    assert [name for name in files(tmp_path) if name.startswith("cam/")] == [
        "cam/boxes/bounding_box_2d_tight_0000.npy", "cam/boxes/bounding_box_2d_tight_labels_0000.json",
        "cam/boxes/bounding_box_2d_tight_prim_paths_0000.json", "cam/camera_params/camera_params_0000.json",
        "cam/distance_to_camera/distance_to_camera_0000.npy", "cam/distance_to_camera/distance_to_camera_0000.png",
        "cam/normals/normals_0000.png", "cam/own_0000.json", "cam/rgb/rgb_0000.png",
        "cam/semantic_segmentation/semantic_segmentation_0000.png",
        "cam/semantic_segmentation/semantic_segmentation_labels_0000.json",
    ]  # fmt: skip
    assert read(tmp_path, "cam/own_0000.json") == {"dir": str(tmp_path)}


def test_only_what_is_asked_for_is_read_and_written(frame, tmp_path):
    writer = write(tmp_path, frame, rgb=True, count=2, frame_padding=6)
    assert files(tmp_path) == ["metadata.txt", "rgb_000000.png", "rgb_000001.png"]
    assert list(writer.get_annotators()) == ["rgb"]


def test_several_products_get_folders(frame, tmp_path):
    two = {f"/Render/HydraTextures/{n}": dataclasses.replace(frame, memo={}) for n in ("left", "right")}
    write(tmp_path / "own", two, rgb=True, bounding_box_3d=True)
    assert [f for f in files(tmp_path / "own") if "rgb" in f] == ["left/rgb/rgb_0000.png", "right/rgb/rgb_0000.png"]
    assert "left/bounding_box_3d/bounding_box_3d_labels_0000.json" in files(tmp_path / "own")
    write(tmp_path / "common", two, rgb=True, use_common_output_dir=True)
    assert files(tmp_path / "common") == ["metadata.txt", "rgb/left_rgb_0000.png", "rgb/right_rgb_0000.png"]


def test_a_product_that_is_switched_off_for_a_frame_does_not_move_the_others_files(frame, tmp_path):
    two = {f"/Render/HydraTextures/{n}": dataclasses.replace(frame, memo={}) for n in ("left", "right")}
    writer = writers.get("BasicWriter", init_params={"output_dir": str(tmp_path), "rgb": True})
    writer.attach(known(*two))
    left = {"/Render/HydraTextures/left": frame}
    for seen in (two, left, two):
        writer.receive(annotators.build_payload(writer, seen))
    writer.backend.wait_until_done()
    assert files(tmp_path) == [
        "left/rgb/rgb_0000.png", "left/rgb/rgb_0001.png", "left/rgb/rgb_0002.png", "metadata.txt",
        "right/rgb/rgb_0000.png", "right/rgb/rgb_0002.png",
    ]  # fmt: skip


def test_an_on_time_trigger_numbers_its_sequence(frame, tmp_path):
    write(tmp_path, frame, payload={"trigger_outputs": {"on_time": 3}}, rgb=True)
    assert "rgb_3_0000.png" in files(tmp_path)


def test_frames_are_counted_from_zero_again_in_each_sequence(frame, tmp_path):
    writer = writers.get("BasicWriter", init_params={"output_dir": str(tmp_path), "rgb": True})
    writer.attach(PRODUCT)
    for counts in ({"on_time": 1}, {"on_time": 1}, {"on_time": 2}, {"on_time": 2, "slow_on_time": 1}):
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}) | {"trigger_outputs": counts})
    writer.receive_skipped({"trigger_outputs": {"on_time": 3}})
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}) | {"trigger_outputs": {"on_time": 3}})
    writer.backend.wait_until_done()
    pictures = [name for name in files(tmp_path) if name.endswith(".png")]
    assert pictures == [
        "rgb_1_0000.png", "rgb_1_0001.png", "rgb_1_2_0000.png", "rgb_2_0000.png", "rgb_3_0001.png",
    ]  # fmt: skip


def test_the_filter_decides_what_counts(frame, tmp_path):
    write(tmp_path, frame, bounding_box_2d_tight=True, semantic_filter_predicate="class:pear")
    assert read(tmp_path, "bounding_box_2d_tight_prim_paths_0000.json") == ["/World/Pear"]


def test_annotators_that_users_add_are_written_too(frame, tmp_path):
    writer = writers.get("BasicWriter", init_params={"output_dir": str(tmp_path), "rgb": True})
    writer.add_annotator("HdrColor")
    writer.add_annotator("ReferenceTime")
    writer.augment_annotator("rgb", lambda data_in: 255 - data_in)
    writer.attach(PRODUCT)
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    writer.backend.wait_until_done()
    assert np.load(tmp_path / "HdrColor_0000.npy").dtype == np.float16
    assert read(tmp_path, "ReferenceTime_0000.json")["referenceTimeDenominator"] == 60
    np.testing.assert_array_equal(image(tmp_path, "rgb_0000.png"), 255 - frame.aovs["LdrColor"])


def test_jpegs_of_color_and_png_of_labels(frame, tmp_path):
    write(tmp_path, frame, rgb=True, semantic_segmentation=True, image_output_format="jpeg")
    assert {"rgb_0000.jpeg", "semantic_segmentation_0000.png"} <= set(files(tmp_path))


def test_what_describes_a_file_is_written_after_it(frame):
    class Diary(writers.BaseBackend):
        def __init__(self):
            self.paths = []

        def write_blob(self, path, data):
            self.paths.append(path)

    writer = writers.get("BasicWriter")
    writer.initialize(backend=Diary(), **dict.fromkeys(ALL, True))
    writer.attach(PRODUCT)
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    writer.backend.wait_until_done()
    is_json = [path.endswith("json") for path in writer.backend.paths if not path.startswith(("metadata.txt", "."))]
    assert is_json == sorted(is_json)
    assert any(is_json)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"semantic_types": ["class"], "semantic_filter_predicate": "class:*"}, WriterError, "exclude"),
        ({"rbg": True}, WriterError, "'rbg'. Did you mean 'rgb'"),
        ({"rgb": "false"}, WriterError, "rgb is 'false'; expected true or false"),
        ({"semantic_types": [1]}, WriterError, "expected a list of text"),
        ({"rgb": True, "occlusion": True, "semantic_filter_predicate": "class:"}, ConfigError, "class:"),
    ],
)
def test_wrong_options_are_refused(tmp_path, options, error, message):
    with pytest.raises(error, match=message):
        writers.get("BasicWriter", init_params={"output_dir": str(tmp_path), **options})


def test_skeletons_are_written_with_the_names_of_replicators_files(tmp_path):
    stage = set_stage(new_stage())
    place(add_character(stage), translate=(-1, 0.5, 0))
    write(tmp_path, make_frame(stage, (40, 30)), skeleton_data=True)
    assert files(tmp_path) == ["metadata.txt", "skeleton_0000.json"]
    (told,) = read(tmp_path, "skeleton_0000.json").items()
    assert told[0] == "skeleton_0"
    assert set(told[1]) == {
        "skel_name", "skel_path", "asset_path", "animation_variant", "skeleton_parents", "rest_global_translations",
        "rest_local_translations", "rest_local_rotations", "global_translations", "local_rotations", "translations_2d",
        "skeleton_joints", "joint_occlusions", "occlusion_types", "in_view",
    }  # fmt: skip
    np.testing.assert_allclose(told[1]["global_translations"], [[-1, 0.5, 0], [0, 0.5, 0], [1, 0.5, 0]], atol=1e-6)
    write(tmp_path / "none", make_frame(set_stage(new_stage()), (8, 6)), skeleton_data=True)
    assert read(tmp_path / "none", "skeleton_0000.json") == {}


OWN = {
    "amodal_instance_segmentation": ["_info_0000.json"],
    "visibility": ["_0000.npy", "_info_0000.json"],
    "truncation": ["_0000.npy"],
    "bounding_box_2d_amodal": ["_0000.npy", "_labels_0000.json", "_prim_paths_0000.json"],
    "oriented_bounding_box_2d": ["_0000.npy", "_labels_0000.json", "_prim_paths_0000.json"],
    "oriented_bounding_box_2d_amodal": ["_0000.npy", "_labels_0000.json", "_prim_paths_0000.json"],
    "object_coordinates": ["_0000.npy", "_0000.png", "_info_0000.json"],
    "keypoints": ["_0000.npy", "_info_0000.json"],
    "dense_correspondence": ["_0000.npy", "_info_0000.json", "_visibility_0000.png"],
}


def test_files_of_our_own_annotators(frame, tmp_path):
    write(tmp_path, frame, rgb=True, **dict.fromkeys(OWN, True))
    names = [name + end for name, ends in OWN.items() for end in ends]
    assert files(tmp_path) == sorted(["metadata.txt", "rgb_0000.png", *names])
    coordinates = np.load(tmp_path / "object_coordinates_0000.npy")
    assert coordinates.shape == (48, 64, 4)
    assert np.abs(image(tmp_path, "object_coordinates_0000.png") / 255 - coordinates).max() <= 0.5 / 255 + 1e-6
    masks = read(tmp_path, "amodal_instance_segmentation_info_0000.json")
    areas = [sum(mask["counts"][1::2]) for mask in masks["masks"]]
    assert areas == np.load(tmp_path / "visibility_0000.npy")["amodalPixels"].tolist()
    assert read(tmp_path, "keypoints_info_0000.json") == {"keypointNames": [], "primPaths": []}
    found = read_dataset(tmp_path)
    assert not found.problems


def test_a_payload_in_the_legacy_layout_that_a_script_builds_is_written_too(frame, tmp_path):
    asked = ("rgb", "bounding_box_2d_tight", "camera_params")
    own = write(tmp_path / "own", frame, **dict.fromkeys(asked, True))
    payload = annotators.build_payload(own, {PRODUCT: frame})["annotators"]
    seen = {name.removesuffix("_fast"): each["rp1"] for name, each in payload.items() if "rp1" in each}
    boxes = dict(seen["bounding_box_2d_tight"])
    built = writers.BasicWriter(output_dir=str(tmp_path / "built"))
    built.write(
        {
            "trigger_outputs": {},
            "rgb": seen["rgb"]["data"],
            "bounding_box_2d_tight": {"data": boxes.pop("data"), "info": boxes},
            "camera_params": seen["camera_params"],
        }
    )
    built.backend.wait_until_done()
    names = set(files(tmp_path / "own")) - {"metadata.txt"}  # which attached writers put before their first payload
    assert len(names) == 5
    assert set(files(tmp_path / "built")) == names
    for name in names:
        assert (tmp_path / "built" / name).read_bytes() == (tmp_path / "own" / name).read_bytes()
