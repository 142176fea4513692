"""Single values of files, and files about all frames, that are damaged: what was done, and the file to be named.

Unlike label faults, a run cannot write them: a disk, a tool or a hand did. Each function edits the files of a folder
that `datasets.make` wrote.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import tarfile
from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image
from scipy.io import loadmat, savemat

from tests.verify.datasets import DATASETS
from tests.verify.label_faults import edit_array, edit_json, edit_rows


class Damage(NamedTuple):
    """A kind of damage."""

    name: str
    dataset: str  # of `datasets.DATASETS`
    file: str  # which is to be named; the first that matches is edited
    inject: Callable[[Path], Any]  # of the file


def found(folder: Path, damage: Damage) -> Path:
    """Return the file that is damaged."""
    return next(iter(sorted(folder.glob(damage.file))))


NAN, INFINITY = float("nan"), float("inf")


def put(*keys: Any, value: Any) -> Callable[[Path], None]:
    """Set a value of a JSON file."""

    def change(values: Any) -> None:
        for key in keys[:-1]:
            values = values[key]
        values[keys[-1]] = value(values[keys[-1]]) if callable(value) else value

    return lambda path: edit_json(path, change)


def rows(name: str, index: int, value: Any) -> Callable[[Path], None]:
    """Set a field of a row of a structured array."""
    return lambda path: edit_rows(path, lambda array: array[name].__setitem__(index, value))


def field(line: int, column: int, value: str) -> Callable[[Path], None]:
    """Set a word of a text."""

    def change(path: Path) -> None:
        lines = [each.split(" ") for each in path.read_text().splitlines()]
        lines[line][column] = value
        path.write_text("".join(" ".join(each) + "\n" for each in lines))

    return change


def mat(change: Callable[[dict], None]) -> Callable[[Path], None]:
    """Change the values of a MATLAB file."""

    def edit(path: Path) -> None:
        values = {name: value for name, value in loadmat(path).items() if not name.startswith("__")}
        change(values)
        savemat(path, values)

    return edit


def member(extension: str, change: Callable[[bytes], bytes | None]) -> Callable[[Path], None]:
    """Change the first member of a shard with an extension; None leaves it out."""

    def edit(path: Path) -> None:
        with tarfile.open(path) as tar:
            members = [(each, file.read()) for each in tar if (file := tar.extractfile(each)) is not None]
        place = next(index for index, (each, _) in enumerate(members) if each.name.endswith(extension))
        changed = change(members[place][1])
        members[place : place + 1] = [] if changed is None else [(members[place][0], changed)]
        with tarfile.open(path, "w", format=tarfile.USTAR_FORMAT) as tar:
            for each, data in members:
                each.size = len(data)
                tar.addfile(each, io.BytesIO(data))

    return edit


def sample(**values: Any) -> Callable[[Path], None]:
    """Set values of the first sample of a shard."""
    return member(".json", lambda data: json.dumps(json.loads(data) | values).encode())


def text(old: str, new: str) -> Callable[[Path], None]:
    """Replace the first occurrence of a text."""

    def edit(path: Path) -> None:
        before = path.read_text()
        assert old in before
        path.write_text(before.replace(old, new, 1))

    return edit


def flip(place: int) -> Callable[[Path], None]:
    """Flip the lowest bit of a byte."""

    def edit(path: Path) -> None:
        data = bytearray(path.read_bytes())
        data[place] ^= 1
        path.write_bytes(bytes(data))

    return edit


def in_mode(mode: str) -> Callable[[Path], None]:
    """Save a picture in another mode."""

    def edit(path: Path) -> None:
        with Image.open(path) as image:
            changed = image.convert("RGB").quantize(64) if mode == "P" else image.convert(mode)
        changed.save(path)

    return edit


def huge(path: Path) -> None:
    """Write the header of an array that no memory holds."""
    with path.open("wb") as file:
        header = {"descr": "<f4", "fortran_order": False, "shape": (10**13,)}
        np.lib.format.write_array_header_1_0(file, header)


def pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def as_type(dtype: Any) -> Callable[[Path], None]:
    """Save an array, or the rows of one, with another type."""

    def change(array: np.ndarray) -> np.ndarray:
        names = array.dtype.names
        return array.astype(np.dtype([(name, dtype, array.dtype[name].shape) for name in names]) if names else dtype)

    return lambda path: edit_array(path, change)


MAPPING, CAMERA = "instance_segmentation_mapping_0001.json", "camera_params_0001.json"
POSE, SCENE = "000001.json", "train_pbr/000001/scene_camera.json"
INFO, META = "train_pbr/000001/scene_gt_info.json", "**/000001-meta.mat"
LABELS, CALIB = "Left/object_detection/1.txt", "Left/calib/1.txt"
SHARD, RECORD = "train-000000.tar", ".usdsdg/frames/000001.npz"
remove = Path.unlink

# Errors of reading: each ended in a traceback, or not at all.
UNREADABLE = [
    Damage("a flipped bit in a record", "basic", RECORD, flip(60)),
    Damage("256 in a color of a table", "basic", MAPPING, text("255)", "256)")),
    Damage("a negative color in a table", "basic", MAPPING, text("255)", "-255)")),
    Damage("an infinite color in a table", "basic", MAPPING, text("255)", "1e999)")),
    Damage("boxes without dimensions", "basic", "bounding_box_2d_tight_0001.npy", lambda p: np.save(p, np.float32(3))),
    Damage("an array larger than the memory", "basic", "distance_to_camera_0001.npy", huge),
    Damage("JSON nested too deeply", "basic", CAMERA, lambda path: path.write_text("[" * 200_000)),
    Damage(
        "an infinite id in the table of classes",
        "coco_polygons",
        ".usdsdg/classes.json",
        text('"id": 2', '"id": 1e999'),
    ),
    Damage("a table of classes that is a list", "basic", ".usdsdg/classes.json", lambda path: path.write_text("[]")),
    Damage("a picture without a number", "bop", "train_pbr/000000/rgb/a.png", lambda path: None),
    Damage("an infinite count of pixels", "bop", INFO, put("0", 0, "px_count_all", value=INFINITY)),
    Damage("gray segments", "cosmos", "clip_0000/segmentation/segmentation_0001.png", in_mode("L")),
    Damage("segments with a palette", "cosmos", "clip_0000/segmentation/segmentation_0001.png", in_mode("P")),
    Damage("gray shaded segments", "cosmos", "clip_0000/shaded_seg/shaded_seg_0001.png", in_mode("L")),
    Damage("an infinite frame of a sample", "webdataset", SHARD, sample(frame=INFINITY)),
    Damage("an infinite width of a sample", "webdataset", SHARD, sample(width=INFINITY)),
    Damage("the picture of a sample is gone", "webdataset", SHARD, member("000000.png", lambda data: None)),
    Damage("a pipe for a shard", "webdataset", SHARD, pipe),
]

# NaN, and values that were in no comparison.
VALUES = [
    Damage("NaN in a camera's matrix", "basic", CAMERA, put("cameraViewTransform", 3, value=NAN)),
    Damage("a camera's matrix of NaN", "basic", CAMERA, put("cameraViewTransform", value=[NAN] * 16)),
    Damage("null in a camera's matrix", "basic", CAMERA, put("cameraViewTransform", 10, value=None)),
    Damage("nested lists for a number", "basic", CAMERA, put("cameraFocalLength", value=[[[50.0]]])),
    Damage(
        "a focal length is gone", "basic", CAMERA, lambda p: edit_json(p, lambda v: v.__delitem__("cameraFocalLength"))
    ),
    Damage(
        "another focal length down in a projection",
        "basic",
        CAMERA,
        put("cameraProjection", 5, value=lambda v: v * 1.1),
    ),
    Damage("NaN in the rotation of BOP's camera", "bop", SCENE, put("0", "cam_R_w2c", 0, value=NAN)),
    Damage("NaN in the translation of BOP's camera", "bop", SCENE, put("0", "cam_t_w2c", 0, value=NAN)),
    Damage("another focal length down in BOP", "bop", SCENE, put("0", "cam_K", 4, value=lambda v: v * 1.02)),
    Damage("a slanted camera matrix in BOP", "bop", SCENE, put("0", "cam_K", 1, value=3.0)),
    Damage("NaN for a visible fraction in BOP", "bop", INFO, put("0", 0, "visib_fract", value=NAN)),
    Damage(
        "another focal length down in poses",
        "pose",
        POSE,
        put("camera_data", "intrinsics", "fy", value=lambda v: v * 1.3),
    ),
    Damage("NaN in a pose's camera", "pose", POSE, put("camera_data", "camera_view_matrix", 0, 0, value=NAN)),
    Damage("NaN for an offset of the aperture", "pose", POSE, put("camera_data", "aperture_offset", 0, value=NAN)),
    Damage(
        "NaN in projected keypoints", "pose", POSE, put("objects", 0, "cuboid_keypoints_projected", 0, 0, value=NAN)
    ),
    Damage("NaN for a truncated fraction", "pose", POSE, put("objects", 0, "truncation_ratio", value=NAN)),
    Damage("NaN in keypoints of DOPE", "dope", POSE, put("objects", 0, "projected_cuboid", 0, 0, value=NAN)),
    Damage(
        "NaN in keypoints of CenterPose", "centerpose", POSE, put("objects", 0, "projected_cuboid", 0, 0, value=NAN)
    ),
    Damage(
        "NaN in keypoints of DOPEWriter", "dope_exact", POSE, put("objects", 0, "projected_cuboid", 0, 0, value=NAN)
    ),
    Damage("NaN in a quaternion of DOPEWriter", "dope_exact", POSE, put("objects", 0, "quaternion_wxyz", 0, value=NAN)),
    Damage("NaN for alpha in KITTI", "kitti", LABELS, field(0, 3, "nan")),
    Damage("NaN for rotation_y in KITTI", "kitti", LABELS, field(0, 14, "nan")),
    Damage("a moved scanner in KITTI", "kitti", CALIB, field(6, 1, "nan")),
    Damage(
        "a crowd in COCO", "coco_plain", "annotations/instances_train.json", put("annotations", 0, "iscrowd", value=1)
    ),
    Damage("NaN for a crowd in COCO", "coco", "coco_annotations_*.json", put("annotations", 0, "iscrowd", value=NAN)),
    Damage(
        "NaN in YCB-Video's camera",
        "ycb_exact",
        META,
        mat(lambda v: v["rotation_translation_matrix"].__setitem__((0, 0), NAN)),
    ),
    Damage(
        "YCB-Video's camera is gone", "ycb_exact", META, mat(lambda v: v.__delitem__("rotation_translation_matrix"))
    ),
    Damage("text for YCB-Video's camera", "ycb_exact", META, mat(lambda v: v.update(rotation_translation_matrix="x"))),
    Damage("an unknown class without a ratio", "basic", "occlusion_0001.npy", rows("semanticId", 0, 77)),
    Damage("an unknown object without a ratio", "basic", "occlusion_0001.npy", rows("instanceId", 0, 77)),
    Damage("an object twice, without a ratio", "basic", "occlusion_0001.npy", rows("instanceId", 0, 2)),
    Damage("boxes of 64 bits", "basic", "bounding_box_2d_tight_0001.npy", as_type("<f8")),
    Damage("depth of 64 bits", "basic", "distance_to_camera_0001.npy", as_type("<f8")),
    Damage("depth with bytes in the other order", "basic", "distance_to_image_plane_0001.npy", as_type(">f4")),
    Damage(
        "NaN in normals of points", "basic", "pointcloud_normals_0001.npy", lambda p: edit_array(p, lambda a: a * NAN)
    ),
    Damage("a sample of no view", "webdataset", SHARD, sample(view=None)),
    Damage("the ids of a sample are gone", "webdataset", SHARD, member(".instances.png", lambda data: None)),
]

# Files about all frames.
TABLES = [
    Damage("camera.json is gone", "bop", "camera.json", remove),
    Damage("camera.json is empty", "bop", "camera.json", lambda path: path.write_text("{}")),
    Damage("camera.json of another camera", "bop", "camera.json", put("fy", value=lambda v: v * 1.02)),
    Damage("camera.json of a larger picture", "bop", "camera.json", put("width", value=640)),
    Damage("names of models are gone", "bop", "models/names.json", remove),
    Damage("no names of models", "bop", "models/names.json", lambda path: path.write_text("{}")),
    Damage(
        "names of models swapped",
        "bop",
        "models/names.json",
        lambda p: edit_json(p, lambda v: v | {"1": v["2"], "2": v["1"]}),
    ),
    Damage("instances of a part are gone", "coco_plain", "annotations/instances_val.json", remove),
    Damage("segments of a part are gone", "coco_plain", "annotations/panoptic_val.json", remove),
    Damage("instances with Replicator's names are gone", "coco", "coco_annotations_*.json", remove),
    Damage("the table of classes is gone", "basic", ".usdsdg/classes.json", remove),
    Damage("a pipe for segments of a part", "coco_plain", "annotations/panoptic_val.json", pipe),
    Damage("no name of a model", "bop", "models/names.json", put("1", value=None)),
    Damage(
        "an id in the table of classes", "bop", ".usdsdg/classes.json", put("tables", 0, "classes", 0, "id", value=3)
    ),
    Damage("a filter in the table of classes", "pose", ".usdsdg/classes.json", put("tables", 0, "filter", value="x:*")),
    Damage(
        "a color in the table of classes",
        "pose",
        ".usdsdg/classes.json",
        put("tables", 0, "classes", 0, "color", 0, value=256),
    ),
    Damage(
        "a record of another frame",
        "pose",
        RECORD,
        lambda path: shutil.copy(path.with_name("000000.npz"), path),
    ),
    Damage("labels of the task are gone", "cvat", "labels.json", remove),
    Damage("the description is gone", "yolo", "data.yaml", remove),
    Damage("the index of shards is gone", "webdataset", "index.json", remove),
    Damage("a class of the index that no object has", "webdataset", "index.json", put("classes", -1, value="x")),
]


def _table(change: Callable[[Any, Any], Any], path: Path) -> None:
    parquet = import_module("pyarrow.parquet")
    parquet.write_table(change(import_module("pyarrow"), parquet.read_table(path)), path)


def _null(name: str) -> Callable[[Any, Any], Any]:
    def change(arrow: Any, table: Any) -> Any:
        place = table.schema.names.index(name)
        return table.set_column(place, table.schema.field(name), arrow.nulls(len(table), table.schema.field(name).type))

    return change


PARQUET = "data/train-00000.parquet"
if "parquet" in DATASETS:
    UNREADABLE.append(Damage("a pipe for a table", "parquet", PARQUET, pipe))
    VALUES += [
        Damage(name, "parquet", PARQUET, partial(_table, change))
        for name, change in {
            "pictures are no column": lambda _, table: table.drop(["image"]),
            "no pictures in a column": _null("image"),
            "ids are no column": lambda _, table: table.drop(["instances"]),
            "no ids in a column": _null("instances"),
            "no view in a column": _null("view"),
        }.items()
    ]
    TABLES.append(
        Damage(
            "the first row is gone",
            "parquet",
            "data",
            lambda folder: _table(lambda _, t: t.slice(1), folder / "train-00000.parquet"),
        )
    )

ALL = [*UNREADABLE, *VALUES, *TABLES]
