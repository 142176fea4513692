"""Reader of BasicWriter's files."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.inspect.read_basic import FILE, view_of
from usdsdg.verify.folder import Folder
from usdsdg.verify.formats.matching import truth_of
from usdsdg.verify.seen import Boxes, Camera, Color, Depth, Ids, Occlusions, Points, Seen, packed
from usdsdg.verify.truth import text_of

NAME = "BasicWriter"
_BOXES = {"bounding_box_2d_tight": "tight", "bounding_box_2d_loose": "loose", "bounding_box_3d": "3d"}
_DEPTHS = {"distance_to_camera": "camera", "distance_to_image_plane": "plane"}
_TABLES = {
    "semantic_segmentation": (("labels", "class"),),
    "instance_segmentation": (("mapping", "instance"), ("semantics_mapping", "instance labels")),
    "instance_id_segmentation": (("mapping", "gprim"),),
}
_IMAGES = ("png", "jpg", "jpeg")
_CLOUD = ("rgb", "normals", "semantic", "instance")
_DEFAULT_FILTER = "class:*"

Parts = dict[str, str]  # kind, or kind/table, to file


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    found: dict[tuple[str, str], Parts] = {}
    for file in files:
        match = FILE.match(Path(file).name)
        if match:
            part = "/".join(filter(None, (match["kind"], match["table"], match["ending"].lower())))
            found.setdefault((view_of(Path(file), match), match["number"]), {})[part] = file
    for (view, number), parts in sorted(found.items()):
        if set(parts) != {"skeleton/json"}:
            yield _seen(folder, view, number, parts)


def _seen(folder: Folder, view: str, number: str, parts: Parts) -> Seen:
    seen = Seen(NAME, number, view, list(parts.values()), truth_of(folder, list(parts.values()), view))
    if seen.truth is not None:
        parts = {part: file for part, file in parts.items() if not seen.truth.is_augmented(part.split("/")[0])}
    for kind in ("rgb", "normals"):
        file = _image(parts, kind)
        image = None if file is None else folder.image(file, seen.name)
        if file is not None and image is not None:
            color = Color(file, image, exact=file.lower().endswith(".png"))
            (seen.colors if kind == "rgb" else seen.normals).append(color)
    for kind, tables in _TABLES.items():
        _read_ids(folder, seen, parts, kind, tables)
    for kind, short in _BOXES.items():
        _read_boxes(folder, seen, parts, kind, short)
    _read_arrays(folder, seen, parts)
    _read_camera(folder, seen, parts)
    _read_points(folder, seen, parts)
    return seen


def _image(parts: Parts, kind: str) -> str | None:
    return next((parts[f"{kind}/{ending}"] for ending in _IMAGES if f"{kind}/{ending}" in parts), None)


def _filter(seen: Seen, kind: str) -> str:
    return seen.truth.filter_of(kind, _DEFAULT_FILTER) if seen.truth else _DEFAULT_FILTER


def _read_ids(folder: Folder, seen: Seen, parts: Parts, kind: str, tables: tuple[tuple[str, str], ...]) -> None:
    file = parts.get(f"{kind}/png")
    image = None if file is None else folder.image(file, seen.name)
    if file is None or image is None:
        return
    colored = image.ndim == 3
    keys = packed(image) if colored else image.astype(np.int64)
    chosen = bool(seen.truth and seen.truth.parameter(kind, "mapping"))
    for table, meaning in tables:
        name = parts.get(f"{kind}/{table}/json", "")
        values = folder.json(name, seen.name) if name else None
        parsed = None if values is None else folder.parsed(name, seen.name, lambda v=values: _meanings(v, colored))
        known = parsed or (None, {})
        seen.ids.append(
            Ids(file, meaning, keys, known[0], name, colored, _filter(seen, kind), chosen, known[1])
        )  # fmt: skip


def _meanings(table: Mapping[str, Any], colored: bool) -> tuple[dict[int, str], dict[int, str]]:
    """Return what the keys of a table mean, and how they are written."""
    meanings, written = {}, {}
    for key, meaning in table.items():
        color = ast.literal_eval(key) if colored else int(key)
        number = int(packed(np.array([[color]], np.uint8))[0, 0]) if colored else color
        meanings[number], written[number] = text_of(meaning), key
    return meanings, written


def _read_boxes(folder: Folder, seen: Seen, parts: Parts, kind: str, short: str) -> None:
    file = parts.get(f"{kind}/npy")
    rows = None if file is None else folder.array(file, seen.name)
    if file is None or rows is None:
        return
    labels_file, paths_file = (parts.get(f"{kind}/{table}/json") for table in ("labels", "prim_paths"))
    table = folder.json(labels_file, seen.name) if labels_file else {}
    paths = folder.json(paths_file, seen.name) if paths_file else None
    names = folder.parsed(
        labels_file or file, seen.name, lambda: [text_of((table or {})[str(int(row["semanticId"]))]) for row in rows]
    )
    if names is not None:
        seen.boxes.append(Boxes(file, short, names, paths, rows, _filter(seen, kind)))


def _read_arrays(folder: Folder, seen: Seen, parts: Parts) -> None:
    for kind, short in _DEPTHS.items():
        file = parts.get(f"{kind}/npy")
        values = None if file is None else folder.array(file, seen.name)
        if file is not None and values is not None:
            seen.depths.append(Depth(file, short, values))
            seen.arrays[kind] = (file, values)
        drawn = parts.get(f"{kind}/png")
        image = None if drawn is None else folder.image(drawn, seen.name)
        if drawn is not None and image is not None and values is not None:
            seen.extra.setdefault("drawn depth", []).append((drawn, image, values))
    file = parts.get("motion_vectors/npy")
    values = None if file is None else folder.array(file, seen.name)
    if file is not None and values is not None:
        seen.arrays["motion_vectors"] = (file, values)
    file = parts.get("occlusion/npy")
    rows = None if file is None else folder.array(file, seen.name)
    if file is not None and rows is not None:
        seen.occlusions.append(Occlusions(file, rows, _filter(seen, "occlusion")))


def _read_camera(folder: Folder, seen: Seen, parts: Parts) -> None:
    file = parts.get("camera_params/json")
    values = None if file is None else folder.json(file, seen.name)
    if file is None or values is None:
        return
    camera = folder.parsed(file, seen.name, lambda: _camera(file, values))
    if camera is not None:
        seen.cameras.append(camera)


def _camera(file: str, values: Mapping[str, Any]) -> Camera:
    width, height = (int(size) for size in values["renderProductResolution"])
    view = np.array(values["cameraViewTransform"], np.float64).reshape(4, 4)
    projection = np.array(values["cameraProjection"], np.float64).reshape(4, 4)
    focal = projection[0, 0] * width / 2
    center = ((1 - projection[2, 0]) * width / 2, (1 + projection[2, 1]) * height / 2)
    if values["cameraModel"] == "orthographic":
        center = ((1 + projection[3, 0]) * width / 2, (1 - projection[3, 1]) * height / 2)
    return Camera(file, view, 1e-9, (width, height), focal, center, values)


def _read_points(folder: Folder, seen: Seen, parts: Parts) -> None:
    file = parts.get("pointcloud/npy")
    points = None if file is None else folder.array(file, seen.name)
    if file is None or points is None:
        return
    others = {}
    for kind in _CLOUD:
        other = parts.get(f"pointcloud_{kind}/npy")
        values = None if other is None else folder.array(other, seen.name)
        if other is not None and values is not None:
            others[kind] = (other, values)
    whole = bool(seen.truth and seen.truth.parameter("pointcloud", "includeUnlabelled"))
    seen.points.append(Points(file, points, others, _filter(seen, "pointcloud"), whole))
