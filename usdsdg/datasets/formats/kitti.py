"""Reader of KittiWriter's folders."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath

import numpy as np

from usdsdg.datasets import cuboids
from usdsdg.datasets.cuboids import PinholeCamera
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Camera, Color, Depth, Seen
from usdsdg.datasets.seen_object import SeenObject

NAME = "KittiWriter"
LOOKED_FOR = "KittiWriter's object_detection/0.txt or label_02/0.txt"
_DONT_CARE = "DontCare"
_KINDS = {
    "rgb": "rgb", "image_02": "rgb", "object_detection": "labels", "label_02": "labels", "semantic": "ids",
    "semantic_segmentation": "colors", "semantic_rgb": "colors", "instance_segmentation": "instances",
    "instance": "instances", "instance_rgb": "instance colors", "depth": "depth", "calib": "calib",
}  # fmt: skip
_ENDINGS = {"labels": ".txt", "calib": ".txt"}
_STEPS = 256  # of a depth image per meter


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    for file in files:
        path = PurePosixPath(file)
        kind = _KINDS.get(path.parent.name)
        if kind and path.stem.isdigit() and path.suffix == _ENDINGS.get(kind, ".png") and len(path.parts) > 2:
            found.setdefault((path.parent.parent.as_posix(), path.stem), {})[kind] = file
    roots = {root for (root, _), parts in found.items() if "labels" in parts or "ids" in parts}
    for (root, number), parts in sorted(found.items(), key=lambda each: (each[0][0], int(each[0][1]))):
        if root in roots:
            yield _seen(folder, root, number, parts)


def _seen(folder: Folder, root: str, number: str, parts: dict[str, str]) -> Seen:
    seen = Seen(NAME, number, root, list(parts.values()), truth_of(folder, list(parts.values()), root))
    seen.extra["metadata"] = folder.json("metadata.txt", "all") if folder.has("metadata.txt") else {}
    seen.picture, seen.labels = parts.get("rgb", ""), parts.get("labels", "")
    if "labels" in parts and (text := folder.text(parts["labels"], seen.name)) is not None:
        seen.lines.append((parts["labels"], [line.split(" ") for line in text.splitlines()]))
    if "calib" in parts and (text := folder.text(parts["calib"], seen.name)) is not None:
        camera = folder.parsed(parts["calib"], seen.name, lambda: _camera(parts["calib"], text))
        if camera is not None:
            seen.cameras.append(camera)
    seen.later(lambda made: _read_images(folder, made, parts))
    return seen


def _read_images(folder: Folder, seen: Seen, parts: dict[str, str]) -> None:
    for kind in ("ids", "colors", "instances", "instance colors"):
        if kind in parts and (image := folder.image(parts[kind], seen.name)) is not None:
            seen.extra[kind] = (parts[kind], image)
    if "rgb" in parts and (image := folder.image(parts["rgb"], seen.name)) is not None:
        seen.colors.append(Color(parts["rgb"], image))
    if "depth" in parts and (image := folder.image(parts["depth"], seen.name)) is not None:
        meters = np.where(image == 0, np.inf, image.astype(np.float64) / _STEPS)
        seen.depths.append(Depth(parts["depth"], "plane", meters, 1 / _STEPS, 0xFFFF / _STEPS))


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the lines, with cuboids where there is a calibration. What is nowhere has -1 or -1000."""
    camera = seen.cameras[0] if seen.cameras else None
    return [_object(fields, camera) for _, lines in seen.lines for fields in lines if fields[0] != _DONT_CARE]


def _object(fields: list[str], camera: Camera | None) -> SeenObject:
    numbers = np.array(fields[1:], np.float64)
    left, top, right, bottom = numbers[3:7].tolist()
    made = SeenObject(fields[0], box=(left, top, right + 1.0, bottom + 1.0), truncation=float(numbers[0]))
    (height, width, length), bottom_center, turn = numbers[7:10], numbers[10:13], numbers[13]
    if bottom_center[2] <= 0 or min(height, width, length) <= 0:
        return made
    # Sides along the length, downwards and across, from the center of the bottom; then x right, y up, -z ahead.
    corners = (cuboids.unit_keypoints() - np.array([0.0, 0.5, 0.0])) * (length, height, width)
    cos, sin = np.cos(turn), np.sin(turn)
    points = corners @ np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]]) + bottom_center
    made.distance = float(np.linalg.norm(points[0]))
    if camera is not None and camera.focal and camera.center:
        pinhole = PinholeCamera(camera.focal, camera.center, np.eye(4))
        drawn = cuboids.project_cuboid(points * (1.0, -1.0, -1.0), pinhole)
        made.cuboid, made.edges, made.axes = drawn.cuboid, drawn.edges, drawn.axes
    return made


def _camera(file: str, text: str) -> Camera:
    """Return the camera of a calibration; its pixels are 0 at the center of the first one. The pose is not there."""
    rows = dict(line.split(": ", 1) for line in text.splitlines())
    matrix = np.array(rows["P2"].split(), np.float64).reshape(3, 4)
    if any(rows[f"P{index}"] != rows["P2"] for index in (0, 1, 3)):
        raise ValueError("P0 to P3 differ, and there is one camera")
    if matrix[1, 1] != matrix[0, 0] or matrix[2].tolist() != [0, 0, 1, 0] or matrix[:2, 3].any() or matrix[0, 1]:
        raise ValueError("P2 is no projection with square pixels")
    scanner = np.array(rows["Tr_velo_to_cam"].split(), np.float64).reshape(3, 4)
    if (scanner != [[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]]).any():
        raise ValueError("Tr_velo_to_cam does not turn x ahead, y left, z up to the camera's axes")
    if (np.array(rows["R0_rect"].split(), np.float64) != np.eye(3).ravel()).any():
        raise ValueError("R0_rect turns")
    focal, center = matrix[0, 0], (matrix[0, 2] + 0.5, matrix[1, 2] + 0.5)
    return Camera(file, np.full((4, 4), np.nan), 1e-5, None, focal, center, {"matrix": matrix.tolist()})
