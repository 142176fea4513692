"""Kinds of label faults, and how each is put into a dataset that has none.

Each function edits the files of a folder that `datasets.make` wrote; frame 1 or all frames, as the fault would.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image
from scipy.io import loadmat, savemat

from usdsdg.datasets.formats.coco import decoded
from usdsdg.writers.formats.shapes import run_length


class Kind(NamedTuple):
    """A kind of fault."""

    name: str
    dataset: str  # of `datasets.DATASETS`
    inject: Callable[[Path], None]


KINDS: list[Kind] = []
FRAME, OTHER = "0001", "0000"
MID_RUN = 2


def kind(name: str, dataset: str) -> Callable[[Callable[[Path], None]], Callable[[Path], None]]:
    """Add the decorated function to the table."""

    def add(inject: Callable[[Path], None]) -> Callable[[Path], None]:
        KINDS.append(Kind(name, dataset, inject))
        return inject

    return add


def edit_image(path: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    Image.fromarray(np.ascontiguousarray(change(np.array(Image.open(path))))).save(path)


def edit_array(path: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    np.save(path, change(np.load(path)))


def edit_json(path: Path, change: Callable[[Any], Any]) -> None:
    values = json.loads(path.read_text())
    changed = change(values)
    path.write_text(json.dumps(values if changed is None else changed))


def edit_text(folder: Path, pattern: str, change: Callable[[str], str]) -> None:
    """Change texts of files."""
    for path in folder.glob(pattern):
        path.write_text(change(path.read_text()))


def edit_rows(path: Path, change: Callable[[np.ndarray], None]) -> None:
    """Change the rows of a structured array in place."""
    rows = np.load(path)
    change(rows)
    np.save(path, rows)


def stale(folder: Path, pattern: str) -> None:
    """Write the files of the frame before instead of a frame's own."""
    found = sorted(folder.glob(pattern.format(FRAME)))
    assert found, pattern
    for path in found:
        shutil.copy(path.with_name(path.name.replace(FRAME, OTHER)), path)


def shift(image: np.ndarray) -> np.ndarray:
    return np.roll(image, 1, axis=1)


# Color


@kind("color image one pixel to the right", "basic")
def _(folder: Path) -> None:
    edit_image(folder / f"rgb_{FRAME}.png", shift)


@kind("BGR for RGB", "basic")
def _(folder: Path) -> None:
    edit_image(folder / f"rgb_{FRAME}.png", lambda image: image[..., [2, 1, 0, 3]])


@kind("image flipped left to right", "kitti")
def _(folder: Path) -> None:
    edit_image(folder / "Left/rgb/1.png", lambda image: image[:, ::-1])


@kind("stale color image, with loss", "basic_ids")
def _(folder: Path) -> None:
    stale(folder, "Replicator/rgb/rgb_{}.jpg")


@kind("stale normals", "basic")
def _(folder: Path) -> None:
    stale(folder, "normals_{}.png")


# Classes


@kind("semantic mask one pixel to the right", "basic")
def _(folder: Path) -> None:
    edit_image(folder / f"semantic_segmentation_{FRAME}.png", shift)


@kind("two classes swapped", "basic")
def _(folder: Path) -> None:
    def swap(table: dict) -> None:
        first, second = [key for key, own in table.items() if own["class"].islower()][:2]
        table[first], table[second] = table[second], table[first]

    for path in folder.glob("semantic_segmentation_labels_*.json"):
        edit_json(path, swap)


def _recolor(folder: Path, frames: Callable[[int], bool], color: tuple[int, int, int, int]) -> None:
    """Give the class mug another color, in the image and in its table."""
    for path in sorted(folder.glob("semantic_segmentation_labels_*.json")):
        number = path.stem[-4:]
        table = json.loads(path.read_text())
        old = next((key for key, own in table.items() if own["class"] == "mug"), None)
        if old is None or not frames(int(number)):
            continue
        table[str(color)] = table.pop(old)
        path.write_text(json.dumps(table))
        was = [int(part) for part in old[1:-1].split(",")]

        def repaint(image: np.ndarray, was: list[int] = was) -> np.ndarray:
            image[(image == was).all(axis=2)] = color
            return image

        edit_image(folder / f"semantic_segmentation_{number}.png", repaint)


@kind("color of a class changed in mid run", "basic")
def _(folder: Path) -> None:
    _recolor(folder, lambda number: number >= MID_RUN, (17, 34, 51, 255))


@kind("black color for a class", "basic")
def _(folder: Path) -> None:
    _recolor(folder, lambda number: True, (0, 0, 0, 254))


@kind("id of a class changed in mid run", "basic_ids")
def _(folder: Path) -> None:
    where = folder / "Replicator/semantic_segmentation"
    for path in sorted(where.glob("semantic_segmentation_labels_*.json"))[MID_RUN:]:
        table = json.loads(path.read_text())
        old = next((key for key, own in table.items() if own["class"] == "mug"), None)
        if old is None:
            continue
        table["77"] = table.pop(old)
        path.write_text(json.dumps(table))
        image = where / path.name.replace("_labels", "").replace("json", "png")
        edit_image(image, lambda ids, old=old: np.where(ids == int(old), ids.dtype.type(77), ids))


@kind("class missing in the table", "basic")
def _(folder: Path) -> None:
    def drop(table: dict) -> None:
        del table[next(key for key, own in table.items() if own["class"].islower())]

    edit_json(folder / f"semantic_segmentation_labels_{FRAME}.json", drop)


@kind("labels in another case", "basic")
def _(folder: Path) -> None:
    for path in folder.glob("bounding_box_2d_tight_labels_*.json"):
        edit_json(path, lambda table: {key: {"class": own["class"].upper()} for key, own in table.items()})


# Instances


@kind("dropped instance in a mask", "basic")
def _(folder: Path) -> None:
    def paint(image: np.ndarray) -> np.ndarray:
        table = json.loads((folder / f"instance_segmentation_mapping_{FRAME}.json").read_text())
        for key, path in table.items():
            color = [int(part) for part in key[1:-1].split(",")]
            if path.startswith("/") and (image == color).all(axis=2).any():
                image[(image == color).all(axis=2)] = 0
                return image
        raise AssertionError

    edit_image(folder / f"instance_segmentation_{FRAME}.png", paint)


@kind("two instances in one", "basic_ids")
def _(folder: Path) -> None:
    def merge(ids: np.ndarray) -> np.ndarray:
        present = np.unique(ids[ids > 1])
        return np.where(ids == present[1], present[0], ids).astype(ids.dtype)

    edit_image(folder / f"Replicator/instance_segmentation/instance_segmentation_{FRAME}.png", merge)


@kind("prim paths of instances swapped", "basic")
def _(folder: Path) -> None:
    def swap(table: dict) -> None:
        first, second = [key for key, path in table.items() if path.startswith("/")][:2]
        table[first], table[second] = table[second], table[first]

    edit_json(folder / f"instance_segmentation_mapping_{FRAME}.json", swap)


@kind("stale instances", "basic")
def _(folder: Path) -> None:
    stale(folder, "instance_segmentation*_{}.*")


@kind("ids of gprims upside down", "basic")
def _(folder: Path) -> None:
    edit_image(folder / f"instance_id_segmentation_{FRAME}.png", lambda image: image[::-1])


# Boxes


@kind("box exclusive instead of inclusive", "basic")
def _(folder: Path) -> None:
    def widen(rows: np.ndarray) -> None:
        rows["x_max"] += 1
        rows["y_max"] += 1

    for path in folder.glob("bounding_box_2d_tight_[0-9]*.npy"):
        edit_rows(path, widen)


@kind("box with x for y", "basic_ids")
def _(folder: Path) -> None:
    def turn(rows: np.ndarray) -> None:
        for end in ("min", "max"):
            rows[f"x_{end}"], rows[f"y_{end}"] = rows[f"y_{end}"].copy(), rows[f"x_{end}"].copy()

    edit_rows(folder / f"Replicator/bounding_box_2d_loose/bounding_box_2d_loose_{FRAME}.npy", turn)


@kind("doubled instance among the boxes", "basic")
def _(folder: Path) -> None:
    edit_array(folder / f"bounding_box_2d_tight_{FRAME}.npy", lambda rows: rows[[0, *range(len(rows))]])
    edit_json(folder / f"bounding_box_2d_tight_prim_paths_{FRAME}.json", lambda paths: [paths[0], *paths])


@kind("loose boxes of what is visible", "basic")
def _(folder: Path) -> None:
    for table in ("", "labels_", "prim_paths_"):
        ending = "json" if table else "npy"
        shutil.copy(
            folder / f"bounding_box_2d_tight_{table}{FRAME}.{ending}",
            folder / f"bounding_box_2d_loose_{table}{FRAME}.{ending}",
        )


@kind("occlusion truncated to whole numbers", "basic")
def _(folder: Path) -> None:
    def cut(rows: np.ndarray) -> None:
        rows["occlusionRatio"] = np.floor(rows["occlusionRatio"])

    for path in folder.glob("*_[0-9]*.npy"):
        if path.name.startswith(("bounding", "occlusion")):
            edit_rows(path, cut)


@kind("visibility for occlusion", "basic_ids")
def _(folder: Path) -> None:
    def invert(rows: np.ndarray) -> None:
        rows["occlusionRatio"] = 1 - rows["occlusionRatio"]

    for path in folder.glob("Replicator/occlusion/*.npy"):
        edit_rows(path, invert)


@kind("transposed transform of 3D boxes", "basic")
def _(folder: Path) -> None:
    def transpose(rows: np.ndarray) -> None:
        rows["transform"] = rows["transform"].swapaxes(1, 2).copy()

    for path in folder.glob("bounding_box_3d_[0-9]*.npy"):
        edit_rows(path, transpose)


@kind("3D boxes in centimeters", "basic_ids")
def _(folder: Path) -> None:
    def scale(rows: np.ndarray) -> None:
        for side in ("x_min", "y_min", "z_min", "x_max", "y_max", "z_max"):
            rows[side] *= 100

    for path in folder.glob("Replicator/bounding_box_3d/*.npy"):
        edit_rows(path, scale)


@kind("stale 3D boxes", "basic")
def _(folder: Path) -> None:
    stale(folder, "bounding_box_3d*_{}.*")


# Depth, camera, points


@kind("depth along the axis for depth along the ray", "basic")
def _(folder: Path) -> None:
    for path in folder.glob("distance_to_image_plane_*.npy"):
        shutil.copy(path, path.with_name(path.name.replace("image_plane", "camera")))


@kind("millimeters for meters", "basic_ids")
def _(folder: Path) -> None:
    for path in folder.glob("Replicator*/distance_to_*/*.npy"):
        edit_array(path, lambda depth: depth * 1000)


@kind("wrong camera", "basic_ids")
def _(folder: Path) -> None:
    for path in folder.glob("Replicator_01/camera_params/*.json"):
        shutil.copy(folder / "Replicator/camera_params" / path.name, path)


@kind("transposed camera matrix", "basic")
def _(folder: Path) -> None:
    def transpose(values: dict) -> None:
        values["cameraViewTransform"] = np.array(values["cameraViewTransform"]).reshape(4, 4).T.ravel().tolist()

    for path in folder.glob("camera_params_*.json"):
        edit_json(path, transpose)


@kind("stale motion vectors", "basic")
def _(folder: Path) -> None:
    stale(folder, "motion_vectors_{}.npy")


@kind("points in the camera's frame", "basic")
def _(folder: Path) -> None:
    values = json.loads((folder / f"camera_params_{FRAME}.json").read_text())
    view = np.array(values["cameraViewTransform"]).reshape(4, 4)
    edit_array(
        folder / f"pointcloud_{FRAME}.npy", lambda points: (points @ view[:3, :3] + view[3, :3]).astype(np.float32)
    )


@kind("frame numbers off by one", "basic")
def _(folder: Path) -> None:
    for path in sorted(folder.glob("*_000[0-9].*"), reverse=True):
        number = path.stem[-4:]
        path.rename(path.with_name(path.name.replace(number, f"{int(number) + 1:04d}")))


# COCO


def _coco(folder: Path, change: Callable[[dict], None]) -> None:
    (path,) = folder.glob("coco_annotations_*.json")
    edit_json(path, change)


@kind("row-major run lengths", "coco")
def _(folder: Path) -> None:
    def rows(values: dict) -> None:
        for each in values["annotations"]:
            mask = decoded(each["segmentation"]["counts"], tuple(each["segmentation"]["size"]))
            lengths = run_length.runs_of_ids(mask.reshape(mask.shape[::-1]).astype(int))
            each["segmentation"]["counts"] = run_length.encoded(lengths[1])

    _coco(folder, rows)


@kind("missing category", "coco")
def _(folder: Path) -> None:
    def drop(values: dict) -> None:
        values["categories"] = [each for each in values["categories"] if each["name"] != "never"]

    _coco(folder, drop)


@kind("categories swapped", "coco")
def _(folder: Path) -> None:
    def swap(values: dict) -> None:
        for each in values["annotations"]:
            each["category_id"] = {11: 12, 12: 11}.get(each["category_id"], each["category_id"])

    _coco(folder, swap)


@kind("width and height swapped", "coco")
def _(folder: Path) -> None:
    def swap(values: dict) -> None:
        for each in values["images"]:
            each["width"], each["height"] = each["height"], each["width"]

    _coco(folder, swap)


@kind("annotation dropped", "coco")
def _(folder: Path) -> None:
    _coco(folder, lambda values: values["annotations"].pop(2) and None)


@kind("annotations of the image before", "coco")
def _(folder: Path) -> None:
    def move(values: dict) -> None:
        for each in values["annotations"]:
            each["image_id"] = max(each["image_id"] - 1, 0)

    _coco(folder, move)


@kind("box of the last pixel for width and height", "coco")
def _(folder: Path) -> None:
    def narrow(values: dict) -> None:
        for each in values["annotations"]:
            each["bbox"][2] -= 1
            each["bbox"][3] -= 1

    _coco(folder, narrow)


@kind("stale panoptic image", "coco")
def _(folder: Path) -> None:
    stale(folder, "*/panoptic_*.{}.png")


# Poses


def _pose(folder: Path, change: Callable[[dict], None]) -> None:
    for path in folder.glob("*.json"):
        edit_json(path, lambda values: [change(each) for each in values["objects"]] and None)


@kind("wrong order of a quaternion", "pose")
def _(folder: Path) -> None:
    def turn(each: dict) -> None:
        each["quat_wxyz_camera_frame"] = each["quat_wxyz_camera_frame"][1:] + each["quat_wxyz_camera_frame"][:1]

    _pose(folder, turn)


@kind("wrong order of a quaternion in DOPE's files", "dope")
def _(folder: Path) -> None:
    def turn(each: dict) -> None:
        each["quaternion_xyzw"] = each["quaternion_xyzw"][3:] + each["quaternion_xyzw"][:3]

    _pose(folder, turn)


@kind("locations in centimeters", "dope")
def _(folder: Path) -> None:
    _pose(folder, lambda each: each.update(location=[100 * part for part in each["location"]]))


@kind("keypoints in another order", "centerpose")
def _(folder: Path) -> None:
    _pose(
        folder,
        lambda each: each.update(projected_cuboid=[each["projected_cuboid"][0], *each["projected_cuboid"][:0:-1]]),
    )


@kind("stale poses", "pose")
def _(folder: Path) -> None:
    shutil.copy(folder / "000000.json", folder / "000001.json")


# DOPEWriter and YCBVideoWriter


def _dope(folder: Path, change: Callable[[dict], None]) -> None:
    for path in [*folder.glob("0*.json"), *folder.glob("*/0*.json")]:
        edit_json(path, lambda values: [change(each) for each in values["objects"]] and None)


@kind("x y z w for w x y z", "dope_exact")
def _(folder: Path) -> None:
    _dope(folder, lambda each: each.update(quaternion_wxyz=each["quaternion_wxyz"][1:] + each["quaternion_wxyz"][:1]))


@kind("meters for centimeters", "dope_exact")
def _(folder: Path) -> None:
    _dope(folder, lambda each: each.update(location=[part / 100 for part in each["location"]]))


@kind("PoseWriter's order of keypoints", "dope_node")
def _(folder: Path) -> None:
    order = (2, 3, 0, 1, 6, 7, 4, 5, 8)
    _dope(folder, lambda each: each.update(projected_cuboid=[each["projected_cuboid"][index] for index in order]))


@kind("rows of keypoints from the bottom", "dope_node")
def _(folder: Path) -> None:
    _dope(folder, lambda each: each.update(projected_cuboid=[[x, 64 - y] for x, y in each["projected_cuboid"]]))


@kind("poses of the other camera", "dope_node")
def _(folder: Path) -> None:
    first, second = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
    shutil.copy(first / "000001.json", second / "000001.json")


@kind("intrinsics of half the size", "dope_exact")
def _(folder: Path) -> None:
    for path in folder.glob("*.json"):
        edit_json(path, lambda values: values["camera_data"]["intrinsics"].update(cx=24.0, cy=16.0))


VIDEO = "data/YCB_Video/data/0000"


def edit_mat(path: Path, change: Callable[[dict], None]) -> None:
    values = {name: value for name, value in loadmat(path).items() if not name.startswith("__")}
    change(values)
    savemat(path, values)


def _meta(folder: Path, change: Callable[[dict], None]) -> None:
    for path in folder.glob(f"{VIDEO}/**/*-meta.mat"):
        edit_mat(path, change)


@kind("transposed rotations in meta.mat", "ycb_node")
def _(folder: Path) -> None:
    def transpose(values: dict) -> None:
        values["poses"][:, :3] = values["poses"][:, :3].transpose(1, 0, 2).copy()

    _meta(folder, transpose)


@kind("y up and z back in meta.mat", "ycb_exact")
def _(folder: Path) -> None:
    _meta(folder, lambda values: values["poses"].__setitem__(slice(1, 3), -values["poses"][1:3]))


@kind("millimeters in meta.mat", "ycb_exact")
def _(folder: Path) -> None:
    _meta(folder, lambda values: values["poses"].__setitem__((slice(None), 3), values["poses"][:, 3] * 1000))


@kind("classes of poses swapped", "ycb_node")
def _(folder: Path) -> None:
    swapped = np.array([0, 2, 1, 3, 4], np.uint8)
    _meta(folder, lambda values: values.update(cls_indexes=swapped[values["cls_indexes"]]))


@kind("a pose is missing", "ycb_exact")
def _(folder: Path) -> None:
    def drop(values: dict) -> None:
        values.update(
            cls_indexes=values["cls_indexes"][1:], center=values["center"][1:], poses=values["poses"][..., 1:]
        )

    _meta(folder, drop)


@kind("columns for rows in vertmap", "ycb_exact")
def _(folder: Path) -> None:
    _meta(folder, lambda values: values.update(vertmap=values["vertmap"][..., ::-1].copy()))


@kind("intrinsics from the corner of the image", "ycb_exact")
def _(folder: Path) -> None:
    _meta(folder, lambda values: values["intrinsic_matrix"].__setitem__((slice(2), 2), (48.0, 32.0)))


@kind("labels one row lower", "ycb_node")
def _(folder: Path) -> None:
    edit_image(folder / f"{VIDEO}/000001-label.png", lambda image: np.roll(image, 1, axis=0))


@kind("boxes as x, y, width, height", "ycb_node")
def _(folder: Path) -> None:
    path = folder / f"{VIDEO}/000001-box.txt"
    lines = [line.split(" ") for line in path.read_text().splitlines()]
    path.write_text(
        "".join(f"{name} {x} {y} {int(u) - int(x) + 1} {int(v) - int(y) + 1}\n" for name, x, y, u, v in lines)
    )


@kind("stale picture of the inverse depth", "ycb_node")
def _(folder: Path) -> None:
    shutil.copy(folder / f"{VIDEO}/000000-depth.png", folder / f"{VIDEO}/000001-depth.png")


@kind("depth in millimeters", "ycb_exact")
def _(folder: Path) -> None:
    for path in folder.glob(f"{VIDEO}/**/*-depth.png"):
        edit_image(path, lambda depth: (depth // 10).astype(np.uint16))


@kind("a frame that is not there in train.txt", "ycb_node")
def _(folder: Path) -> None:
    with (folder / "data/YCB_Video/train.txt").open("a") as listed:
        listed.write("0000/000099\n")


# YOLO


def _yolo(folder: Path, change: Callable[[list[str]], list[str]]) -> None:
    for path in folder.glob("labels/*/*.txt"):
        lines = [" ".join(change(line.split(" "))) for line in path.read_text().splitlines()]
        path.write_text("".join(f"{line}\n" for line in lines))


@kind("classes counted from 1", "yolo")
def _(folder: Path) -> None:
    _yolo(folder, lambda fields: [str(int(fields[0]) + 1), *fields[1:]])


@kind("corner for center", "yolo")
def _(folder: Path) -> None:
    def move(fields: list[str]) -> list[str]:
        x, y, width, height = map(float, fields[1:])
        return [fields[0], f"{x - width / 2:.6f}", f"{y - height / 2:.6f}", *fields[3:]]

    _yolo(folder, move)


@kind("names of classes in another order", "yolo")
def _(folder: Path) -> None:
    path = folder / "data.yaml"
    path.write_text(
        path.read_text().replace(": mug\n", ": -\n").replace(": can\n", ": mug\n").replace(": -\n", ": can\n")
    )


@kind("outlines with y before x", "outlines")
def _(folder: Path) -> None:
    def swap(fields: list[str]) -> list[str]:
        pairs = [fields[index : index + 2][::-1] for index in range(1, len(fields), 2)]
        return [fields[0], *(each for pair in pairs for each in pair)]

    _yolo(folder, swap)


@kind("oriented boxes turned the other way", "obb")
def _(folder: Path) -> None:
    def mirror(fields: list[str]) -> list[str]:
        corners = np.array(fields[1:], float).reshape(4, 2) * (96, 64)
        corners[:, 0] = 2 * corners[:, 0].mean() - corners[:, 0]
        return [fields[0], *(f"{value:.6f}" for value in (corners / (96, 64)).ravel())]

    _yolo(folder, mirror)


@kind("keypoints without their visibility", "keypoints")
def _(folder: Path) -> None:
    _yolo(folder, lambda fields: fields[:5] + [each for n, each in enumerate(fields[5:]) if n % 3 != 2])


@kind("keypoints outside of the picture", "keypoints")
def _(folder: Path) -> None:
    _yolo(folder, lambda fields: [*fields[:5], *(["1.2", "0.5", "2"] * (len(fields[5:]) // 3))])


# BOP


def _bop(folder: Path, table: str, change: Callable[[dict], None]) -> None:
    for path in folder.glob(f"train_pbr/*/{table}.json"):
        edit_json(path, lambda values: [change(each) for entries in values.values() for each in entries] and None)


@kind("meters for millimeters in poses", "bop")
def _(folder: Path) -> None:
    _bop(folder, "scene_gt", lambda each: each.update(cam_t_m2c=[part / 1000 for part in each["cam_t_m2c"]]))


@kind("transposed rotations", "bop")
def _(folder: Path) -> None:
    _bop(
        folder,
        "scene_gt",
        lambda each: each.update(cam_R_m2c=np.array(each["cam_R_m2c"]).reshape(3, 3).T.ravel().tolist()),
    )


@kind("amodal masks of what is visible", "bop")
def _(folder: Path) -> None:
    for path in folder.glob("train_pbr/*/mask_visib/*.png"):
        shutil.copy(path, path.parent.with_name("mask") / path.name)


@kind("depth in steps of a millimeter", "bop")
def _(folder: Path) -> None:
    for path in folder.glob("train_pbr/*/scene_camera.json"):
        edit_json(path, lambda values: [each.update(depth_scale=1.0) for each in values.values()] and None)


@kind("models measured in meters", "bop")
def _(folder: Path) -> None:
    edit_json(
        folder / "models/models_info.json",
        lambda values: [each.update(diameter=each["diameter"] / 1000) for each in values.values()] and None,
    )


@kind("boxes of what is visible for whole objects", "bop")
def _(folder: Path) -> None:
    _bop(folder, "scene_gt_info", lambda each: each.update(bbox_obj=each["bbox_visib"]))


@kind("numbers of two classes' models swapped", "bop")
def _(folder: Path) -> None:
    _bop(folder, "scene_gt", lambda each: each.update(obj_id={2: 3, 3: 2}.get(each["obj_id"], each["obj_id"])))


@kind("visible pixels in parts of those in the picture", "bop")
def _(folder: Path) -> None:
    def part(each: dict) -> None:
        each["visib_fract"] = each["px_count_visib"] / max(each["px_count_valid"], 1)
        each["px_count_all"] = each["px_count_visib"]

    _bop(folder, "scene_gt_info", part)


# Clips and drawings


@kind("stale gray depth of a clip", "cosmos")
def _(folder: Path) -> None:
    stale(folder, "clip_0000/depth/depth_{}.png")


@kind("color of a segment changed in a clip", "cosmos")
def _(folder: Path) -> None:
    def repaint(image: np.ndarray) -> np.ndarray:
        image[: image.shape[0] // 2, :, 0] //= 2
        return image

    edit_image(folder / f"clip_0000/segmentation/segmentation_{FRAME}.png", repaint)


@kind("stale edges of a clip", "cosmos")
def _(folder: Path) -> None:
    stale(folder, "clip_0000/edges/edges_{}.png")


@kind("drawn boxes one pixel lower", "drawn")
def _(folder: Path) -> None:
    for path in folder.glob(f"*/bounding_box_2d_*_{FRAME}.png"):
        edit_image(path, lambda image: np.roll(image, 1, axis=0))
