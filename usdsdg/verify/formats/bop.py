"""Reader of BopWriter's scenes."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from usdsdg.verify.faults import Fault
from usdsdg.verify.folder import Folder
from usdsdg.verify.formats.matching import record_of
from usdsdg.verify.seen import Camera, Color, Depth, Seen
from usdsdg.verify.truth import Truth

NAME = "BopWriter"
MILLIMETERS = 1000.0  # per meter
# To USD's camera axes, from x right, y down, z ahead.
TO_USD = np.diag((1.0, -1.0, -1.0))
_KINDS = ("rgb", "depth", "mask", "mask_visib")
_TABLES = ("scene_camera", "scene_gt", "scene_gt_info")


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
    models: Mapping[int, np.ndarray]  # points (N, 3) of each model [mm], by id
    masks: list[str] = field(default_factory=list)  # files


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    by_scene: dict[str, dict[tuple[str, str], str]] = {}
    for file in files:
        path = PurePosixPath(file)
        if len(path.parts) == 4 and path.parts[2] in _KINDS and path.parts[1].isdigit():
            by_scene.setdefault("/".join(path.parts[:2]), {})[path.parts[2], path.stem] = file
    models = _models(folder, files) if by_scene else {}
    for root, parts in sorted(by_scene.items()):
        names = [f"{root}/{name}.json" for name in _TABLES]
        tables: list[dict[str, Any]] = [table for name in names if (table := folder.json(name, "all")) is not None]
        if len(tables) < len(names):
            continue
        cameras, poses, infos = tables
        pictures = sorted(stem for kind, stem in parts if kind == "rgb")
        for table, name in zip(tables, names):
            if sorted(table, key=int) != [str(int(stem)) for stem in pictures]:
                folder.faults.append(
                    Fault(name, "all", "has an entry for each picture", str(len(pictures)), str(len(table)))
                )
        for stem in pictures:
            number = str(int(stem))
            if all(number in table for table in tables):
                mine = {key: file for key, file in parts.items() if key[1].split("_")[0] == stem}
                values = (cameras[number], poses[number], infos[number])
                seen = folder.parsed(
                    names[0],
                    f"{root}/{number}",
                    lambda r=root, s=stem, m=mine, v=values: _seen(folder, r, s, m, v, models),
                )
                if seen is not None:
                    yield seen


def _models(folder: Folder, files: list[str]) -> dict[int, np.ndarray]:
    """Return the points of each model [mm]."""
    found = {}
    for file in files:
        path = PurePosixPath(file)
        if path.parts[0] == "models" and path.suffix == ".ply" and path.stem.startswith("obj_"):
            points = folder.binary(file, "all", _points)
            if points is not None:
                found[int(path.stem[4:])] = points
    return found


def _points(data: bytes) -> np.ndarray:
    import trimesh

    mesh: Any = trimesh.load(io.BytesIO(data), file_type="ply", process=False)
    return np.array(mesh.vertices, np.float64)


def _seen(
    folder: Folder,
    root: str,
    stem: str,
    parts: Mapping[tuple[str, str], str],
    values: Any,
    models: Mapping[int, np.ndarray],
) -> Seen:
    camera, poses, infos = values
    seen = Seen(NAME, stem, root, list(parts.values()))
    record = record_of(folder, seen.files)
    scene = int(PurePosixPath(root).name)
    if record is not None and scene < len(record.products):
        seen.truth = Truth(record, record.products[scene])
    if (image := folder.image(parts["rgb", stem], seen.name)) is not None:
        seen.colors.append(Color(parts["rgb", stem], image, exact=parts["rgb", stem].endswith(".png")))
    step = float(camera["depth_scale"]) / MILLIMETERS
    if ("depth", stem) in parts and (image := folder.image(parts["depth", stem], seen.name)) is not None:
        meters = np.where(image == 0, np.inf, image.astype(np.float64) * step)
        seen.depths.append(Depth(parts["depth", stem], "plane", meters, step, 0xFFFF * step))
    matrix = np.array(camera["cam_K"], np.float64).reshape(3, 3)
    view = np.eye(4)
    unit = seen.truth.camera.meters_per_unit if seen.truth and seen.truth.camera else 1.0
    view[:3, :3] = (TO_USD @ np.array(camera["cam_R_w2c"], np.float64).reshape(3, 3)).T
    view[3, :3] = TO_USD @ np.array(camera["cam_t_w2c"], np.float64) / MILLIMETERS / unit
    center = (matrix[0, 2] + 0.5, matrix[1, 2] + 0.5)
    seen.cameras.append(Camera(f"{root}/scene_camera.json", view, 1e-7, None, float(matrix[0, 0]), center))
    objects, masks = [], []
    for index, (pose, info) in enumerate(zip(poses, infos, strict=True)):
        pair = []
        for kind in ("mask", "mask_visib"):
            file = parts.get((kind, f"{stem}_{index:06d}"))
            image = None if file is None else folder.image(file, seen.name)
            if file is None:
                folder.faults.append(Fault(f"{root}/{kind}/{stem}_{index:06d}.png", seen.name, "is missing"))
            pair.append(None if image is None else image > 0)
            masks.append(file or "")
        objects.append(Posed(pose, info, *pair))
    seen.extra["scene"] = Scene(f"{root}/scene_gt.json", objects, matrix, models, masks)
    return seen
