"""Objects of BasicWriter's boxes: those of one prim are one object."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets import cuboids
from usdsdg.datasets.cuboids import CurvedCamera, PinholeCamera
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.errors import AssetError, Unsupported
from usdsdg.stage.cameras.lenses import LENS_MODELS
from usdsdg.writers.formats.shapes.camera_projection import lens_of

# Camera, meters per unit and image size.
Located = tuple[PinholeCamera | CurvedCamera, float, tuple[int, int]]


def objects(seen: Seen) -> list[SeenObject]:
    """Return objects by prim path, merged from all kinds of boxes."""
    merged: dict[str, SeenObject] = {}
    for boxes in seen.boxes:
        camera = _camera_of(seen) if boxes.kind == "3d" else None
        for index, (name, row) in enumerate(zip(boxes.names, boxes.rows, strict=True)):
            known = boxes.paths is not None and index < len(boxes.paths)
            path = str(boxes.paths[index]) if known and boxes.paths is not None else f"{boxes.kind}[{index}]"
            _add_box(merged.setdefault(path, SeenObject(name, path)), boxes.kind, row, camera)
    return list(merged.values())


def _add_box(seen: SeenObject, kind: str, row: np.void, camera: Located | None) -> None:
    occlusion = float(row["occlusionRatio"])
    # -1 means unknown, nan out of view.
    if 0.0 <= occlusion <= 1.0:
        seen.visibility = 1.0 - occlusion
    if kind == "3d":
        if camera is not None:
            _add_cuboid(seen, row, *camera)
        return
    # Pixel bounds are inclusive.
    box = (float(row["x_min"]), float(row["y_min"]), float(row["x_max"]) + 1.0, float(row["y_max"]) + 1.0)
    if kind == "tight":
        seen.box = box
    else:
        seen.loose = box


def _add_cuboid(
    seen: SeenObject, row: np.void, camera: PinholeCamera | CurvedCamera, meters: float, size: tuple[int, int]
) -> None:
    low, high = (np.array([row[f"{axis}_{end}"] for axis in "xyz"], float) for end in ("min", "max"))
    local = cuboids.box_keypoints(low, high)
    transform = np.asarray(row["transform"], dtype=float)
    points = camera.to_camera(local @ transform[:3, :3] + transform[3, :3])
    made = cuboids.project_cuboid(points, camera)
    seen.cuboid, seen.edges, seen.axes = made.cuboid, made.edges, made.axes
    seen.distance = float(np.linalg.norm(points[0])) * meters
    drawn = seen.cuboid if seen.cuboid is not None else seen.edges
    if seen.loose is None and seen.box is None and drawn is not None and len(drawn):
        seen.loose = cuboids.bounds(drawn.reshape(-1, 2), size)


def _camera_of(seen: Seen) -> Located | None:
    """Return camera, meters per unit and image size; None if 3D boxes cannot be drawn."""
    if not seen.cameras:
        seen.notes.append("Boxes in space are not drawn where camera_params is missing: write it along with them.")
        return None
    values = seen.cameras[0].values
    model = str(values.get("cameraModel", "pinhole"))
    width, height = (int(part) for part in values["renderProductResolution"])
    view = np.reshape(np.array(values["cameraViewTransform"], float), (4, 4))
    meters = float(values.get("metersPerSceneUnit", 1.0))
    if model in LENS_MODELS:
        try:
            lens = lens_of(values)
        except (AssetError, Unsupported) as problem:
            seen.notes.append(f"Boxes in space are not drawn where the texture of the lens is not there: {problem}")
            return None
        if lens is not None:
            return CurvedCamera(lens, view), meters, (width, height)
    if model != "pinhole":
        seen.notes.append(f"Boxes in space are not drawn for the camera model {model}.")
        return None
    projection = np.reshape(np.array(values["cameraProjection"], float), (4, 4))
    center = ((1.0 - projection[2, 0]) * width / 2.0, (1.0 + projection[2, 1]) * height / 2.0)
    focal = width * float(values["cameraFocalLength"]) / float(values["cameraAperture"][0])
    return PinholeCamera(focal, center, view), meters, (width, height)
