"""Reader of BasicWriter's files."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.formats.basic_arrays import array_of
from usdsdg.datasets.formats.basic_objects import objects
from usdsdg.datasets.formats.basic_own import read_own
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Boxes, Camera, Color, Depth, Ids, Occlusions, Points, Seen, packed
from usdsdg.datasets.truth import text_of

NAME = "BasicWriter"
PICTURES = ("semantic_segmentation", "instance_segmentation", "instance_id_segmentation", "normals")
DEPTHS = ("distance_to_camera", "distance_to_image_plane")
BOXES = ("bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d")
OTHERS = (
    "motion_vectors", "occlusion", "skeleton", r"pointcloud(?:_(?:rgb|normals|semantic|instance))?(?=.*\.npy$)",
    "amodal_instance_segmentation", "visibility", "truncation", "object_coordinates", "keypoints",
    "bounding_box_2d_amodal", "oriented_bounding_box_2d(?:_amodal)?", "dense_correspondence(?:_visibility)?",
)  # fmt: skip

SHOWN = ("rgb", "camera_params", *PICTURES, *DEPTHS, *BOXES)

_KINDS = "|".join((*SHOWN, *OTHERS))
# The prefix is matched lazily: `pointcloud_rgb` is a kind, not a view with the kind `rgb`.
FILE = re.compile(
    rf"^(?:(?P<view>.+?)_)??(?P<kind>{_KINDS})(?:_(?P<table>labels|mapping|semantics_mapping|prim_paths|info))?"
    r"_(?P<number>(?:\d+_)*\d+)\.(?P<ending>png|jpe?g|npy|json)$",
    re.IGNORECASE,
)
_BOXES = {"bounding_box_2d_tight": "tight", "bounding_box_2d_loose": "loose", "bounding_box_3d": "3d"}
_DEPTHS = {"distance_to_camera": "camera", "distance_to_image_plane": "plane"}
_TABLES = {
    "semantic_segmentation": (("labels", "class"),),
    "instance_segmentation": (("mapping", "instance"), ("semantics_mapping", "instance labels")),
    "instance_id_segmentation": (("mapping", "gprim"),),
}
_IMAGES = ("png", "jpg", "jpeg")
_CLOUD = ("rgb", "normals", "semantic", "instance")
# The folders of kinds that are not called as their annotators, by the beginning of the kind.
_FOLDERS = {"pointcloud": "pointcloud", "dense_correspondence": "dense_correspondence", "skeleton": "skeleton_data"}
_DEFAULT_FILTER = "class:*"

SKELETONS = "skeletons"  # in `Seen.extra`

Parts = dict[str, str]  # kind, or kind/table, to file


@dataclass(frozen=True)
class Skeletons:
    """The skeletons of a file, by its keys."""

    file: str
    skeletons: Mapping[str, Any]


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    found: dict[tuple[str, str], Parts] = {}
    for file in files:
        match = FILE.match(Path(file).name)
        if match:
            part = "/".join(filter(None, (match["kind"], match["table"], match["ending"].lower())))
            found.setdefault((view_of(Path(file), match), match["number"]), {})[part] = file
    for (view, number), parts in sorted(found.items()):
        yield _seen(folder, view, number, parts)


def view_of(path: Path, match: re.Match[str]) -> str:
    """Return the render product: the part before the annotator in the file name or in its folders."""
    kind, folders = match["kind"], list(path.parent.parts)
    own = next((folder for first, folder in _FOLDERS.items() if kind.startswith(first)), kind)
    if own in folders:
        # The last one: a product may be called as an annotator is.
        del folders[len(folders) - 1 - folders[::-1].index(own)]
    return "/".join([*folders, *([match["view"]] if match["view"] else [])])


def _seen(folder: Folder, view: str, number: str, parts: Parts) -> Seen:
    seen = Seen(NAME, number, view, list(parts.values()), truth_of(folder, list(parts.values()), view))
    if seen.truth is not None:
        parts = {part: file for part, file in parts.items() if not seen.truth.is_augmented(part.split("/")[0])}
    seen.picture = _image(parts, "rgb") or ""
    seen.undrawn = [kind for part in parts if (kind := part.split("/")[0]) not in SHOWN]
    for kind, short in _BOXES.items():
        _read_boxes(folder, seen, parts, kind, short)
    seen.labels = next((parts[f"{kind}/npy"] for kind in _BOXES if f"{kind}/npy" in parts), "")
    _read_camera(folder, seen, parts)
    seen.later(lambda made: _read_images(folder, made, parts))
    return seen


def _read_images(folder: Folder, seen: Seen, parts: Parts) -> None:
    for kind in ("rgb", "normals"):
        file = _image(parts, kind)
        image = None if file is None else folder.image(file, seen.name)
        if file is not None and image is not None:
            color = Color(file, image, exact=file.lower().endswith(".png"))
            (seen.colors if kind == "rgb" else seen.normals).append(color)
    for kind, tables in _TABLES.items():
        _read_ids(folder, seen, parts, kind, tables)
    _read_arrays(folder, seen, parts)
    _read_skeletons(folder, seen, parts)
    read_own(folder, seen, parts, _DEFAULT_FILTER)
    _read_points(folder, seen, parts)


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
        values = folder.mapping(name, seen.name) if name else None
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
    rows = array_of(folder, seen, file, kind)
    if file is None or rows is None:
        return
    labels_file, paths_file = (parts.get(f"{kind}/{table}/json") for table in ("labels", "prim_paths"))
    if labels_file is None:
        name = Path(file).with_suffix(".json").name.replace(f"{kind}_", f"{kind}_labels_", 1)
        folder.faults.append(Fault(Path(file).with_name(name).as_posix(), seen.name, "is missing"))
        return
    table = folder.mapping(labels_file, seen.name)
    paths = folder.rows(paths_file, seen.name) if paths_file else None
    if paths is not None and (len(paths) != len(rows) or not all(isinstance(each, str) for each in paths)):
        what = "has a prim path for each box"
        folder.faults.append(Fault(paths_file or "", seen.name, what, str(len(rows)), str(len(paths))))
        paths = None
    parsed = folder.parsed(
        labels_file, seen.name, lambda: [_labels(folder, seen, file, table or {}, row) for row in rows]
    )
    if parsed is not None and table is not None:
        names = [_name(each) for each in parsed]
        seen.boxes.append(Boxes(file, short, list(map(text_of, parsed)), paths, rows, _filter(seen, kind), names))


def _labels(folder: Folder, seen: Seen, file: str, table: Mapping[str, Any], row: np.void) -> Any:
    """Return the labels of a row of boxes; "?" where the table does not have its id."""
    number = str(int(row["semanticId"]))
    if number not in table:
        folder.faults.append(Fault(file, seen.name, f"a box has id {number}, which the labels file does not know"))
    return table.get(number, "?")


def _name(labels: Any) -> str:
    """Return the class, or all labels where there is none."""
    if isinstance(labels, Mapping):
        return str(labels.get("class") or ", ".join(map(str, labels.values())))
    return str(labels)


def _read_arrays(folder: Folder, seen: Seen, parts: Parts) -> None:
    for kind, short in _DEPTHS.items():
        file = parts.get(f"{kind}/npy")
        values = array_of(folder, seen, file, kind)
        if file is not None and values is not None:
            seen.depths.append(Depth(file, short, values))
            seen.arrays[kind] = (file, values)
        drawn = parts.get(f"{kind}/png")
        image = None if drawn is None else folder.image(drawn, seen.name)
        if drawn is not None and image is not None and values is not None:
            seen.extra.setdefault("drawn depth", []).append((drawn, image, values))
    file = parts.get("motion_vectors/npy")
    values = array_of(folder, seen, file, "motion_vectors")
    if file is not None and values is not None:
        seen.arrays["motion_vectors"] = (file, values)
    file = parts.get("occlusion/npy")
    rows = array_of(folder, seen, file, "occlusion")
    if file is not None and rows is not None:
        seen.occlusions.append(Occlusions(file, rows, _filter(seen, "occlusion")))


def _read_camera(folder: Folder, seen: Seen, parts: Parts) -> None:
    file = parts.get("camera_params/json")
    values = None if file is None else folder.mapping(file, seen.name)
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
    return Camera(file, view, 1e-9, (width, height), focal, center, values, projection[1, 1] * height / 2)


def _read_skeletons(folder: Folder, seen: Seen, parts: Parts) -> None:
    file = parts.get("skeleton/json")
    values = None if file is None else folder.mapping(file, seen.name)
    if file is not None and values is not None:
        seen.extra[SKELETONS] = Skeletons(file, values)


def _read_points(folder: Folder, seen: Seen, parts: Parts) -> None:
    file = parts.get("pointcloud/npy")
    points = array_of(folder, seen, file, "pointcloud")
    if file is None or points is None:
        return
    others = {}
    for kind in _CLOUD:
        other = parts.get(f"pointcloud_{kind}/npy")
        values = array_of(folder, seen, other, f"pointcloud_{kind}")
        if other is not None and values is not None:
            others[kind] = (other, values)
    whole = bool(seen.truth and seen.truth.parameter("pointcloud", "includeUnlabelled"))
    seen.points.append(Points(file, points, others, _filter(seen, "pointcloud"), whole))


__all__ = [
    "BOXES", "DEPTHS", "FILE", "NAME", "PICTURES", "SHOWN", "SKELETONS", "Skeletons", "objects", "read", "view_of",
]  # fmt: skip
