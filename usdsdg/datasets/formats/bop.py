"""Reader of BopWriter's scenes."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from usdsdg.datasets import cuboids
from usdsdg.datasets.color_images import read_color
from usdsdg.datasets.cuboids import PinholeCamera
from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import classes_of, record_of
from usdsdg.datasets.seen import Camera, Depth, Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.datasets.truth import Truth
from usdsdg.writers.formats.bop import bop_files as names
from usdsdg.writers.formats.bop.bop_files import MILLIMETERS, NAME
from usdsdg.writers.formats.bop.bop_models import VARIANT, measures
from usdsdg.writers.formats.shapes.opencv_frame import TO_OPENCV

_KINDS = (names.RGB, names.DEPTH, names.MASK, names.MASK_VISIB)
_BOXES, _CLASSES = "bounding_box_3d", "class:*"
_SENSOR = ("fx", "fy", "cx", "cy", "depth_scale")
_TABLES = (names.CAMERAS, names.POSES, names.INFOS)


@dataclass
class Posed:
    """One object of an image."""

    pose: Mapping[str, Any]  # of scene_gt
    info: Mapping[str, Any]  # of scene_gt_info
    whole: np.ndarray | None  # (H, W) bool
    visible: np.ndarray | None


@dataclass
class Scene:
    """The objects of one image."""

    file: str
    objects: list[Posed]
    camera: np.ndarray  # (3, 3), pixels are 0 at the center of the first
    models: Models
    masks: list[str] = field(default_factory=list)  # files


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    by_scene: dict[str, dict[tuple[str, str], str]] = {}
    for file in files:
        path = PurePosixPath(file)
        if len(path.parts) == 4 and path.parts[2] in _KINDS and path.parts[1].isdigit():
            by_scene.setdefault("/".join(path.parts[:2]), {})[path.parts[2], path.stem] = file
    models = Models(folder, files)
    sensors: dict[tuple[float, ...], str] = {}  # with one picture of each
    for root, parts in sorted(by_scene.items()):
        listed = [names.table_of(root, name) for name in _TABLES]
        tables: list[dict[str, Any]] = [table for name in listed if (table := folder.mapping(name, "all")) is not None]
        if len(tables) < len(listed):
            continue
        cameras, poses, infos = tables
        pictures = sorted(stem for kind, stem in parts if kind == names.RGB and stem.isdecimal())
        for (kind, stem), file in parts.items():
            if kind == names.RGB and not stem.isdecimal():
                folder.faults.append(Fault(file, "?", "is not called by the number of a picture"))
        for table, name in zip(tables, listed):
            if sorted(table) != sorted(str(int(stem)) for stem in pictures):
                folder.faults.append(
                    Fault(name, "all", "has an entry for each picture", str(len(pictures)), str(len(table)))
                )
        for stem in pictures:
            number = str(int(stem))
            if all(number in table for table in tables):
                mine = {key: file for key, file in parts.items() if key[1].split("_")[0] == stem}
                values = (cameras[number], poses[number], infos[number])
                seen = folder.parsed(
                    listed[0],
                    f"{root}/{number}",
                    lambda r=root, s=stem, m=mine, v=values: _seen(folder, r, s, m, v, models),
                )
                if seen is not None:
                    sensor = _sensor(seen.extra["scene"].camera, cameras[number]["depth_scale"])
                    sensors.setdefault(sensor, seen.picture)
                    yield seen
    if sensors and folder.has(names.CAMERA):
        _check_sensor(folder, sensors)


def _sensor(matrix: np.ndarray, depth_scale: float) -> tuple[float, ...]:
    """Return what camera.json has of a camera, beside the size of its pictures."""
    return float(matrix[0, 0]), float(matrix[1, 1]), float(matrix[0, 2]), float(matrix[1, 2]), float(depth_scale)


def _check_sensor(folder: Folder, sensors: Mapping[tuple[float, ...], str]) -> None:
    """Note a camera.json that is of no picture."""
    values = folder.mapping(names.CAMERA, "all")
    if values is None:
        return
    found = folder.parsed(names.CAMERA, "all", lambda: tuple(float(values[key]) for key in _SENSOR))
    if found is None:
        return
    if found in sensors:
        size = folder.image_size(sensors[found], "all")
        given = (values.get("width"), values.get("height"))
        if size is not None and given != size:
            folder.faults.append(Fault(names.CAMERA, "all", "width and height", str(size), str(given)))
    else:
        expected = ", ".join(f"{key} {value:g}" for key, value in zip(_SENSOR, next(iter(sorted(sensors)))))
        given = ", ".join(f"{key} {value:g}" for key, value in zip(_SENSOR, found))
        folder.faults.append(Fault(names.CAMERA, "all", "is the camera of a picture", expected, given))


class Models:
    """The models of a dataset."""

    def __init__(self, folder: Folder, files: list[str]) -> None:
        self._folder = folder
        self._files = {
            int(path.stem[4:]): file
            for file in files
            if (path := PurePosixPath(file)).parts[0] == names.MODELS
            and path.suffix == ".ply"
            and path.stem.startswith("obj_")
        }
        self.mesh = lru_cache(maxsize=None)(self._mesh)
        self.measures = lru_cache(maxsize=None)(self._measures)
        self._classes = classes_of(folder, _filter_of(folder, files)) or []
        info = folder.mapping(names.MODELS_INFO, "all") if folder.has(names.MODELS_INFO) else None
        self.info: Mapping[str, Any] = info or {}
        if folder.has(names.MODEL_NAMES):
            self._check_names(folder)

    def _check_names(self, folder: Folder) -> None:
        """Note models without a name, names without a model, and those that are not of their class."""
        file = names.MODEL_NAMES
        found = folder.mapping(file, "all")
        if found is None:
            return
        if sorted(found) != sorted(map(str, self._files)):
            what = "has a name for each model"
            folder.faults.append(Fault(file, "all", what, ", ".join(map(str, self._files)), ", ".join(found)))
        for number in self._files if folder.classes else ():
            name = self.label(number)
            if (given := found.get(str(number), name)) != name:
                folder.faults.append(Fault(file, "all", f"the name of model {number}", name, str(given)))

    def _mesh(self, number: int) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the points (N, 3) [mm] and triangles (T, 3) of a model; None where there is none."""
        file = self._files.get(number)
        return None if file is None else self._folder.binary(file, "all", _mesh)

    def _measures(self, number: int) -> Mapping[str, float]:
        """Return the record of models_info that a model should have."""
        mesh = self.mesh(number)
        return {} if mesh is None else measures(mesh[0])

    def keypoints(self, number: int) -> np.ndarray | None:
        """Return center and corners of the box of a model [mm], (9, 3); None where it is not known."""
        info = self.info.get(str(number))
        if info is None:
            return None
        low = np.array([info[f"min_{axis}"] for axis in "xyz"], np.float64)
        return cuboids.box_keypoints(low, low + [info[f"size_{axis}"] for axis in "xyz"])

    def class_id(self, number: int) -> int | None:
        """Return the id of the class of a model; None where it has none in the table of classes."""
        place = (number - 1) % VARIANT
        return int(self._classes[place]["id"]) if place < len(self._classes) else None

    def label(self, number: int) -> str:
        """Return the name of the class of a model, or its file's where there is no table of classes."""
        place = (number - 1) % VARIANT
        return str(self._classes[place]["name"]) if place < len(self._classes) else f"obj_{number:06d}"


def _filter_of(folder: Folder, files: Sequence[str]) -> str:
    """Return the label filter that the writer of the files had."""
    record = record_of(folder, [file for file in files if PurePosixPath(file).parent.name in _KINDS])
    if record is None or not record.products:
        return _CLASSES
    return Truth(record, record.products[0]).filter_of(_BOXES, _CLASSES)


def _mesh(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    import trimesh

    mesh: Any = trimesh.load(io.BytesIO(data), file_type="ply", process=False)
    return np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.int64)


def _seen(
    folder: Folder,
    root: str,
    stem: str,
    parts: Mapping[tuple[str, str], str],
    values: Any,
    models: Models,
) -> Seen:
    camera, poses, infos = values
    seen = Seen(NAME, stem, root, list(parts.values()))
    record = record_of(folder, seen.files)
    scene = int(PurePosixPath(root).name)
    if record is not None and record.products:
        # Scenes of one stretch of frames are in the order of the render products.
        seen.truth = Truth(record, record.products[scene % len(record.products)])
    seen.picture, seen.labels = parts[names.RGB, stem], names.table_of(root, names.POSES)
    matrix = np.array(camera["cam_K"], np.float64).reshape(3, 3)
    view = np.eye(4)
    unit = seen.truth.camera.meters_per_unit if seen.truth and seen.truth.camera else 1.0
    view[:3, :3] = (TO_OPENCV @ np.array(camera["cam_R_w2c"], np.float64).reshape(3, 3)).T
    view[3, :3] = TO_OPENCV @ np.array(camera["cam_t_w2c"], np.float64) / MILLIMETERS / unit
    center = (matrix[0, 2] + 0.5, matrix[1, 2] + 0.5)
    file = names.table_of(root, names.CAMERAS)
    seen.cameras.append(Camera(file, view, 1e-7, None, float(matrix[0, 0]), center, focal_down=float(matrix[1, 1])))
    kinds = (names.MASK, names.MASK_VISIB)
    named = [{kind: parts.get((kind, f"{stem}_{index:06d}")) for kind in kinds} for index in range(len(poses))]
    for index, pair in enumerate(named):
        for kind in (kind for kind, file in pair.items() if file is None):
            folder.faults.append(Fault(names.mask_of(root, kind, int(stem), index), seen.name, "is missing"))
    listed = [Posed(pose, info, None, None) for pose, info in zip(poses, infos, strict=True)]
    masks = [file or "" for pair in named for file in pair.values()]
    seen.extra["scene"] = Scene(names.table_of(root, names.POSES), listed, matrix, models, masks)
    depth, step = parts.get((names.DEPTH, stem)), float(camera["depth_scale"]) / MILLIMETERS
    seen.later(lambda made: _read_images(folder, made, depth, step, named))
    return seen


def _read_images(
    folder: Folder, seen: Seen, depth: str | None, step: float, named: Sequence[Mapping[str, str | None]]
) -> None:
    read_color(folder, seen, seen.picture)
    if depth is not None and (image := folder.image(depth, seen.name)) is not None:
        meters = np.where(image == 0, np.inf, image.astype(np.float64) * step)
        seen.depths.append(Depth(depth, "plane", meters, step, names.FARTHEST * step))
    scene: Scene = seen.extra["scene"]
    complete = []
    for posed, pair in zip(scene.objects, named, strict=True):
        images = [None if file is None else folder.image(file, seen.name) for file in pair.values()]
        whole, visible = (None if image is None else image > 0 for image in images)
        complete.append(replace(posed, whole=whole, visible=visible))
    seen.extra["scene"] = replace(scene, objects=complete)


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the poses, with the boxes of their models."""
    scene: Scene = seen.extra["scene"]
    return [_object(index, each, scene) for index, each in enumerate(scene.objects)]


def _object(index: int, posed: Posed, scene: Scene) -> SeenObject:
    number, info = int(posed.pose["obj_id"]), posed.info
    made = SeenObject(
        scene.models.label(number),
        visibility=float(info["visib_fract"]),
        mask=lambda read: read.extra["scene"].objects[index].visible,
    )
    made.box, made.loose = _edges(info["bbox_visib"]), _edges(info["bbox_obj"])
    keypoints = scene.models.keypoints(number)
    if keypoints is None:
        return made
    points = keypoints @ np.array(posed.pose["cam_R_m2c"], np.float64).reshape(3, 3).T + posed.pose["cam_t_m2c"]
    made.distance = float(np.linalg.norm(points[0])) / MILLIMETERS
    center = (scene.camera[0, 2] + 0.5, scene.camera[1, 2] + 0.5)
    drawn = cuboids.project_cuboid(points @ TO_OPENCV, PinholeCamera(float(scene.camera[0, 0]), center, np.eye(4)))
    made.cuboid, made.edges, made.axes = drawn.cuboid, drawn.edges, drawn.axes
    return made


def _edges(box: Sequence[float]) -> tuple[float, float, float, float] | None:
    """Return left, top, right and bottom edge; None for that of nothing."""
    x, y, width, height = (float(each) for each in box)
    return None if width < 0 else (x, y, x + width + 1, y + height + 1)
