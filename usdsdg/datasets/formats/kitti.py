"""Reader of KittiWriter's folders."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath

import numpy as np

from usdsdg.datasets import cuboids
from usdsdg.datasets.color_images import read_color
from usdsdg.datasets.cuboids import PinholeCamera
from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import record_of, truth_of
from usdsdg.datasets.seen import Camera, Depth, Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.writers.formats.kitti import files as names
from usdsdg.writers.formats.kitti.files import NAME

_DONT_CARE = "DontCare"
# Images that only this format has, by their kind: how they are called among what is special to an image.
_IMAGES = {
    names.CLASSES: "ids",
    names.CLASS_COLORS: "colors",
    names.INSTANCES: "instances",
    names.INSTANCE_COLORS: "instance colors",
}
_STEPS = 256  # of a depth image per meter


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    for file in files:
        path = PurePosixPath(file)
        kind = names.kind_of(path.parent.name, path.suffix)
        if kind and path.stem.isdigit() and len(path.parts) > 2:
            found.setdefault((path.parent.parent.as_posix(), path.stem), {})[kind] = file
    roots = {root for (root, _), parts in found.items() if names.LABELS in parts or names.CLASSES in parts}
    images = [each for each in sorted(found.items(), key=_by_number) if each[0][0] in roots]
    lists = _lists(folder, files, {number for (_, number), parts in images if _is_plain(parts)})
    for (root, number), parts in images:
        seen = _seen(folder, root, number, parts)
        if _is_plain(parts):
            seen.extra["parts"] = [file for file, listed in lists.items() if number in listed]
        yield seen


def _by_number(image: tuple[tuple[str, str], dict[str, str]]) -> tuple[str, int]:
    (root, number), _ = image
    return root, int(number)


def _is_plain(parts: dict[str, str]) -> bool:
    """Return whether the files of an image are in KITTI's own layout."""
    return any(
        parts.get(kind, "").split("/")[-2:-1] == [names.PLAIN.folders[kind]] for kind in (names.RGB, names.LABELS)
    )


def _lists(folder: Folder, files: list[str], numbers: set[str]) -> dict[str, list[str]]:
    """Return the pictures of each list of KITTI's own layout."""
    where = [file for file in files if file.startswith(f"{names.IMAGE_SETS}/")] if numbers else []
    lists = {file: (folder.text(file, "all") or "").split() for file in where}
    for file, listed in lists.items():
        if unknown := sorted(set(listed) - numbers):
            folder.faults.append(Fault(file, "all", "lists pictures that are not there", "", ", ".join(unknown[:8])))
    return lists


def _seen(folder: Folder, root: str, number: str, parts: dict[str, str]) -> Seen:
    mine = list(parts.values())
    view = _product(folder, mine, number) if _is_plain(parts) else root
    seen = Seen(NAME, number, view, mine, truth_of(folder, mine, view))
    seen.extra["metadata"] = folder.mapping("metadata.txt", "all") if folder.has("metadata.txt") else {}
    seen.picture, seen.labels = parts.get(names.RGB, ""), parts.get(names.LABELS, "")
    if seen.labels and (text := folder.text(seen.labels, seen.name)) is not None:
        seen.lines.append((seen.labels, [line.split(" ") for line in text.splitlines()]))
    calib = parts.get(names.CALIBRATION, "")
    if calib and (text := folder.text(calib, seen.name)) is not None:
        camera = folder.parsed(calib, seen.name, lambda: _camera(calib, text))
        if camera is not None:
            seen.cameras.append(camera)
    seen.later(lambda made: _read_images(folder, made, parts))
    return seen


def _product(folder: Folder, files: list[str], number: str) -> str:
    """Return the render product of an image in KITTI's own layout, where those of a frame have numbers in a row."""
    record = record_of(folder, files)
    if record is None or len(record.products) < 2:
        return ""
    stems = {PurePosixPath(file).stem for file in record.files if file.startswith(f"{names.TRAINING}/")}
    return record.products[sorted(stems).index(number)].name


def _read_images(folder: Folder, seen: Seen, parts: dict[str, str]) -> None:
    for kind, name in _IMAGES.items():
        if kind in parts and (image := folder.image(parts[kind], seen.name)) is not None:
            seen.extra[name] = (parts[kind], image)
    if seen.picture:
        read_color(folder, seen, seen.picture)
    depth = parts.get(names.DEPTH, "")
    if depth and (image := folder.image(depth, seen.name)) is not None:
        meters = np.where(image == 0, np.inf, image.astype(np.float64) / _STEPS)
        seen.depths.append(Depth(depth, "plane", meters, 1 / _STEPS, 0xFFFF / _STEPS))


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
    is_square = np.isclose(matrix[1, 1], matrix[0, 0], rtol=1e-9, atol=0.0)  # the last digit may differ
    if not is_square or matrix[2].tolist() != [0, 0, 1, 0] or matrix[:2, 3].any() or matrix[0, 1]:
        raise ValueError("P2 is no projection with square pixels")
    scanner = np.array(rows["Tr_velo_to_cam"].split(), np.float64).reshape(3, 4)
    if (scanner != [[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]]).any():
        raise ValueError("Tr_velo_to_cam does not turn x ahead, y left, z up to the camera's axes")
    if (np.array(rows["R0_rect"].split(), np.float64) != np.eye(3).ravel()).any():
        raise ValueError("R0_rect turns")
    if (np.array(rows["Tr_imu_to_velo"].split(), np.float64) != np.eye(3, 4).ravel()).any():
        raise ValueError("Tr_imu_to_velo moves")
    focal, center = matrix[0, 0], (matrix[0, 2] + 0.5, matrix[1, 2] + 0.5)
    return Camera(file, None, 1e-5, None, focal, center, {"matrix": matrix.tolist()})
