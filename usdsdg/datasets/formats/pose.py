"""Reader of PoseWriter's files, in its three formats."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from usdsdg.datasets import cuboids
from usdsdg.datasets.attempt import UNREADABLE, attempt
from usdsdg.datasets.cuboids import KEYPOINTS, PinholeCamera
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import record_of
from usdsdg.datasets.seen import Camera, Color, Posed, Poses, Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.datasets.truth import Truth
from usdsdg.record.frame_record import FrameRecord, ProductRecord

NAME = "PoseWriter"
# Per format the keys of the keypoints in the camera's frame and in the image.
_POINTS = {
    "default": ("cuboid_keypoints_camera_frame", "cuboid_keypoints_projected"),
    "centerpose": ("keypoints_3d", "projected_cuboid"),
}
# `location` of an object is used if it projects to within this many pixels of the cuboid's center.
_NEAR_ENOUGH = 2.5
FILE = re.compile(r"^(?P<number>\d+)(?P<overlay>_overlay)?\.(?P<kind>png|jpe?g|json)$", re.IGNORECASE)
BOXES = "bounding_box_3d_fast"
_ROUNDED = 1e-5
_KEYS = {"camera_data", "keypoint_order", "objects"}


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    for file in files:
        match = FILE.match(PurePosixPath(file).name)
        if match:
            kind = "json" if match["kind"].lower() == "json" else "picture"
            found.setdefault((view_of(Path(file)), match["number"]), {})["overlay" if match["overlay"] else kind] = file
    tables: dict[str, list[str]] = {}
    for (view, _), parts in sorted(found.items()):
        if "json" in parts:
            tables.setdefault(view, []).append(parts["json"])
    views = {view for view, files in tables.items() if _is_mine(folder, files)}
    for (view, number), parts in sorted(found.items()):
        if view in views:
            yield _seen(folder, view, number, parts)


def _is_mine(folder: Folder, tables: list[str]) -> bool:
    """Return whether JSON files are of PoseWriter: writers of users may number theirs like this, too.

    One file with a key of PoseWriter's is enough. Where none can be read, the names are all that tells.
    """
    readable = 0
    for file in tables:
        values = attempt([], file, "?", UNREADABLE, lambda file=file: json.loads((folder.path / file).read_bytes()))
        readable += values is not None
        if isinstance(values, dict) and not _KEYS.isdisjoint(values):
            return True
    return not readable


def view_of(path: Path) -> str:
    return path.parent.as_posix() if path.parent.parts else ""


def _seen(folder: Folder, view: str, number: str, parts: dict[str, str]) -> Seen:
    seen = Seen(NAME, number, view, list(parts.values()))
    record = record_of(folder, seen.files)
    if record is not None:
        product = _product(record, view, seen.files)
        seen.truth = None if product is None else Truth(record, product)
    seen.picture, seen.labels = parts.get("picture", ""), parts.get("json", "")
    if seen.picture:
        seen.later(lambda made: _read_image(folder, made))
    values = folder.mapping(parts["json"], seen.name) if "json" in parts else None
    if values is not None:
        folder.parsed(parts["json"], seen.name, lambda: _read_objects(seen, parts["json"], values))
    return seen


def _read_image(folder: Folder, seen: Seen) -> None:
    if (image := folder.image(seen.picture, seen.name)) is not None:
        seen.colors.append(Color(seen.picture, image, exact=seen.picture.lower().endswith(".png")))
        seen.size = (image.shape[1], image.shape[0])


def _product(record: FrameRecord, view: str, files: list[str]) -> ProductRecord | None:
    """Return the product that an image shows: by its folder, else by its place among those with objects."""
    named = next((each for each in record.products if each.name == view.split("/")[-1]), None)
    if named is not None or len(record.products) == 1:
        return named or record.products[0]
    stems = list(dict.fromkeys(Path(file).stem for file in record.files if file.endswith(".json")))
    drawn = list(record.products)
    if len(stems) < len(drawn):
        threshold = float(record.parameters.get("visibility_threshold") or 0.0)
        drawn = [each for each in drawn if expected(Truth(record, each), threshold)]
    place = next((stems.index(Path(file).stem) for file in files if Path(file).stem in stems), None)
    return drawn[place] if place is not None and place < len(drawn) else None


def expected(truth: Truth, threshold: float) -> list[Any]:
    """Return the things that PoseWriter lists: those of which a larger fraction is visible."""
    things = truth.things(truth.filter_of(BOXES, "class:*"))
    return [each for each in things if each.occlusion is not None and 1.0 - np.float32(each.occlusion) > threshold]


def _read_objects(seen: Seen, file: str, values: Mapping[str, Any]) -> None:
    parameters = seen.truth.record.parameters if seen.truth else {}
    order, camera = list(values["keypoint_order"]), values["camera_data"]
    kind = "dope" if order[0] != "Center" else "default" if "resolution" in camera else "centerpose"
    listed = [
        Posed(each["prim_path"], str(each.get("label", each.get("class"))), float(each["visibility"]), each)
        for each in values["objects"]
    ]
    exact = bool(parameters.get("exact_camera_frame"))
    seen.variant = kind
    seen.poses.append(Poses(file, listed, order, kind, exact, float(parameters.get("visibility_threshold") or 0.0)))
    intrinsics = camera["intrinsics"]
    size = camera.get("resolution") or ([camera["width"], camera["height"]] if "width" in camera else None)
    seen.cameras.append(
        Camera(
            file, np.array(camera["camera_view_matrix"], np.float64), _ROUNDED,
            None if size is None else (int(size[0]), int(size[1])), float(intrinsics["fx"]),
            (float(intrinsics["cx"]), float(intrinsics["cy"])), camera, float(intrinsics["fy"]),
        )
    )  # fmt: skip


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects with their cuboids, whose boxes are the loose ones."""
    return [_object(each, poses, seen.cameras[0]) for poses in seen.poses for each in poses.objects]


def _object(posed: Posed, poses: Poses, from_file: Camera) -> SeenObject:
    values, file = posed.values, from_file.values
    camera = _camera(file)
    order = [poses.order.index(name) for name in KEYPOINTS]
    seen = SeenObject(
        label=posed.label,
        prim_path=posed.path,
        visibility=posed.visibility,
        truncation=_number(values.get("truncation_ratio")),
    )
    keys = _POINTS.get(poses.format)
    if keys is not None:
        points, pixels = (np.array(values[key], dtype=float)[order] for key in keys)
        made = cuboids.project_cuboid(points, camera)
        if not _is_pinhole(points, pixels, camera):
            made = cuboids.ProjectedCuboid(pixels, None, cuboids.axes_of(pixels))
        seen.cuboid, seen.edges, seen.axes = made.cuboid, made.edges, made.axes
        seen.distance = float(np.linalg.norm(points[0])) * float(file.get("meters_per_scene_unit", 1.0))
    else:
        seen.cuboid = np.array(values["projected_cuboid"], dtype=float)[order]
        seen.axes = cuboids.axes_of(seen.cuboid)
        seen.distance = _distance(np.array(values["location"], dtype=float), seen.cuboid[0], camera)
    drawn = seen.cuboid if seen.cuboid is not None else seen.edges
    if drawn is not None and len(drawn):
        seen.loose = cuboids.bounds(drawn.reshape(-1, 2), _size(file))
    return seen


def _is_pinhole(points: np.ndarray, pixels: np.ndarray, camera: PinholeCamera) -> bool:
    """Return whether the file's intrinsics project keypoints to their pixels: for a fisheye, whose files have the
    intrinsics of a pinhole, they do not.
    """
    ahead = points[:, 2] < -cuboids.NEAR
    return bool(np.abs(camera.project(points[ahead]) - pixels[ahead]).max(initial=0.0) <= _NEAR_ENOUGH)


def _camera(camera: Mapping[str, Any]) -> PinholeCamera:
    intrinsics = camera["intrinsics"]
    return PinholeCamera(
        float(intrinsics["fx"]),
        (float(intrinsics["cx"]), float(intrinsics["cy"])),
        np.array(camera["camera_view_matrix"], dtype=float),
    )


def _size(camera: Mapping[str, Any]) -> tuple[int, int] | None:
    if "resolution" in camera:
        return (int(camera["resolution"][0]), int(camera["resolution"][1]))
    if "width" in camera:
        return (int(camera["width"]), int(camera["height"]))
    # The principal point is the image center unless the aperture has an offset.
    return (round(2 * camera["intrinsics"]["cx"]), round(2 * camera["intrinsics"]["cy"]))


def _number(value: Any) -> float | None:
    return None if value is None else float(value)


def _distance(location: np.ndarray, middle: np.ndarray, camera: PinholeCamera) -> float | None:
    """Return the distance [m] if a DOPE file's `location` is in the camera's frame, else None."""
    if location[2] > -cuboids.NEAR or np.abs(camera.project(location) - middle).max() > _NEAR_ENOUGH:
        return None
    return float(np.linalg.norm(location))
