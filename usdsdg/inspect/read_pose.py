"""Reader of PoseWriter's folders: NNNNNN.png with NNNNNN.json, in its three formats."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.datasets import cuboids
from usdsdg.datasets.cuboids import KEYPOINTS, PinholeCamera
from usdsdg.datasets.formats.pose import FILE, view_of
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.inspect.listing import UNREADABLE, read_json
from usdsdg.inspect.records import Dataset, Frame, Problem

LOOKED_FOR = "PoseWriter's NNNNNN.png with NNNNNN.json"

# Per format the keys of the keypoints in the camera's frame and in the image.
_POINTS = {
    "default": ("cuboid_keypoints_camera_frame", "cuboid_keypoints_projected"),
    "centerpose": ("keypoints_3d", "projected_cuboid"),
}
# `location` of an object is used if it projects to within this many pixels of the cuboid's center.
_NEAR_ENOUGH = 2.5
DOPE_NOTE = (
    "The files of this format tell no usable distance: `location` follows Replicator's order of matrices, so it does "
    "not project to the objects."
)


def read(dataset: Dataset, files: list[Path]) -> list[Path]:
    """Add PoseWriter's frames among `files` to the dataset; return their files."""
    found: dict[tuple[str, str], dict[str, Path]] = {}
    for path in files:
        match = FILE.match(path.name)
        if match:
            kind = "json" if match["kind"].lower() == "json" else "picture"
            name = "overlay" if match["overlay"] else kind
            found.setdefault((view_of(path), match["number"]), {})[name] = path
    views = {view for (view, _), parts in found.items() if "json" in parts}
    mine = {key: parts for key, parts in found.items() if key[0] in views}
    formats = set()
    for (view, number), parts in sorted(mine.items()):
        formats.add(_read_frame(dataset, view, number, parts))
    for name in sorted(name for name in formats if name):
        dataset.writers.append(f"PoseWriter, {name} format")
    _check_distances(dataset)
    return [path for parts in mine.values() for path in parts.values()]


def _read_frame(dataset: Dataset, view: str, number: str, parts: dict[str, Path]) -> str | None:
    """Add one frame; return the name of its format."""
    frame = Frame(view, number, parts.get("picture"))
    dataset.frames.append(frame)
    if "picture" not in parts:
        where = parts.get("json") or parts["overlay"]
        dataset.problems.append(Problem("labels without picture", f"{where}: there is no picture {number}", frame.name))
    if "json" not in parts:
        where = parts.get("picture") or parts["overlay"]
        dataset.problems.append(Problem("picture without labels", f"{where}: there is no {number}.json", frame.name))
        return None
    values = read_json(dataset, parts["json"], frame.name)
    if values is None:
        return None
    try:
        frame.objects = [_object(each, values) for each in values["objects"]]
        frame.labeled = True
        return _format(values)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        said = f"key {error} is missing" if isinstance(error, KeyError) else str(error)
        dataset.problems.append(Problem(UNREADABLE, f"{parts['json']}: not as PoseWriter writes: {said}", frame.name))
        return None


def _format(values: Mapping[str, Any]) -> str:
    order = values["keypoint_order"]
    if order and order[0] != "Center":
        return "dope"
    return "default" if "resolution" in values["camera_data"] else "centerpose"


def _object(values: Mapping[str, Any], file: Mapping[str, Any]) -> SeenObject:
    camera = _camera(file["camera_data"])
    order = [file["keypoint_order"].index(name) for name in KEYPOINTS]
    seen = SeenObject(
        label=str(values.get("label", values.get("class"))),
        prim_path=str(values.get("prim_path", "")),
        visibility=_number(values.get("visibility")),
        truncation=_number(values.get("truncation_ratio")),
    )
    keys = _POINTS.get(_format(file))
    if keys is not None:
        points, pixels = (np.array(values[key], dtype=float)[order] for key in keys)
        made = cuboids.project_cuboid(points, camera)
        if not _is_pinhole(points, pixels, camera):
            made = cuboids.ProjectedCuboid(pixels, None, cuboids.axes_of(pixels))
        seen.cuboid, seen.edges, seen.axes = made.cuboid, made.edges, made.axes
        seen.distance = float(np.linalg.norm(points[0])) * float(file["camera_data"].get("meters_per_scene_unit", 1.0))
    else:
        seen.cuboid = np.array(values["projected_cuboid"], dtype=float)[order]
        seen.axes = cuboids.axes_of(seen.cuboid)
        seen.distance = _distance(np.array(values["location"], dtype=float), seen.cuboid[0], camera)
    drawn = seen.cuboid if seen.cuboid is not None else seen.edges
    if drawn is not None and len(drawn):
        seen.loose = cuboids.bounds(drawn.reshape(-1, 2), _size(file["camera_data"]))
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


def _check_distances(dataset: Dataset) -> None:
    """Discard distances if only a few locations match, which is by chance, and add a note."""
    objects = [seen for frame in dataset.frames for seen in frame.objects if seen.cuboid is not None]
    known = [seen for seen in objects if seen.distance is not None]
    if known and len(known) > 0.8 * len(objects):
        return
    if objects:
        dataset.notes.append(DOPE_NOTE)
    for seen in known:
        seen.distance = None
