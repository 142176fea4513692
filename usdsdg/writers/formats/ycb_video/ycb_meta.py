"""What a `-meta.mat` of YCB-Video has: classes, poses and centers of objects, with the camera."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from usdsdg.errors import Unsupported, warn_once
from usdsdg.writers.formats.shapes.camera_projection import camera_matrix
from usdsdg.writers.formats.shapes.opencv_frame import TO_OPENCV, opencv_position, opencv_rotation
from usdsdg.writers.formats.ycb_video.ycb_models import Models
from usdsdg.writers.formats.ycb_video.ycb_pictures import class_of

BOXES, CAMERA, INSTANCES, DEPTH = (
    "bounding_box_3d", "camera_params", "instance_segmentation_fast", "distance_to_image_plane",
)  # fmt: skip


class _Posed(NamedTuple):
    """One visible object in the camera's frame of OpenCV."""

    index: int  # of its class
    instance: int
    rotation: np.ndarray  # (3, 3) for column vectors, model to camera
    position: np.ndarray  # (3,) [m]


def node_meta(poses: Mapping[str, Any], indices: Mapping[str, int]) -> dict[str, np.ndarray]:
    """Return classes, poses and centers of an annotation `pose` as it has them."""
    rows = poses["data"]
    names = [class_of(poses["idToLabels"][str(row["semanticId"])], indices) for row in rows]
    known = np.array([_is_known(name, indices) for name in names], bool)
    count = int(known.sum())
    matrices = rows["prims_to_desired_camera"][known].astype(np.float64)
    return {
        "cls_indexes": np.array([indices[name] for name in names if name in indices], np.uint8),
        "poses": np.moveaxis(matrices[:, :3], 0, -1) if count else np.zeros((1, 1, 0)),
        "center": rows["center_coords_image_space"][known].astype(np.float64),
    }


def exact_meta(
    seen: Mapping[str, Any], indices: Mapping[str, int], models: Models, *, with_map: bool = True
) -> dict[str, np.ndarray]:
    """Return what YCB-Video's own files have: besides, the camera's matrices and where pixels are on the models.

    Poses map models to x right, y down, z ahead, in meters; pixels are 0 at the center of the first.
    with_map: also where pixels are on the models, for which `seen` has the depth.

    Raises:
        Unsupported: the lens is no pinhole.
    """
    camera = seen[CAMERA]
    if camera["cameraModel"] != "pinhole":
        raise Unsupported(
            f"YCBVideoWriter: a camera of the model {camera['cameraModel']!r}; with exact=True there are pinholes only."
        )
    matrix = camera_matrix(camera)
    view = np.asarray(camera["cameraViewTransform"], np.float64).reshape(4, 4)
    meters = float(camera["metersPerSceneUnit"])
    objects = _objects(seen, indices, models, view, meters)
    poses = np.array([np.column_stack([each.rotation, each.position]) for each in objects]).reshape(-1, 3, 4)
    centers = poses[:, :, 3] @ matrix.T
    return {
        "cls_indexes": np.array([each.index for each in objects], np.uint8)[:, None],
        "poses": np.moveaxis(poses, 0, -1),
        "center": centers[:, :2] / centers[:, 2:],
        "intrinsic_matrix": matrix,
        "rotation_translation_matrix": np.column_stack(
            [TO_OPENCV @ view[:3, :3].T, opencv_position(np.zeros(3), view) * meters]
        ),
        **({"vertmap": _model_points(seen, objects, matrix)} if with_map else {}),
    }


def _objects(
    seen: Mapping[str, Any], indices: Mapping[str, int], models: Models, view: np.ndarray, meters: float
) -> list[_Posed]:
    """Return the visible objects whose class has an index."""
    boxes = seen[BOXES]
    visible = set(np.unique(seen[INSTANCES]["data"]).tolist())
    found = []
    for row, path, instance in zip(boxes["data"], boxes["primPaths"], boxes["bboxIds"].tolist(), strict=True):
        name = class_of(boxes["idToLabels"][str(row["semanticId"])], indices)
        if instance in visible and _is_known(name, indices):
            rotation, position = models.place(path, name, row["transform"], meters)
            turned, moved = opencv_rotation(rotation, view), opencv_position(position, view) * meters
            found.append(_Posed(indices[name], instance, turned, moved))
    return found


def _model_points(seen: Mapping[str, Any], objects: list[_Posed], matrix: np.ndarray) -> np.ndarray:
    """Return, float32 (H, W, 3), where each pixel's point is in the frame of its object's model [m]; 0 elsewhere."""
    ids, depth = seen[INSTANCES]["data"], np.asarray(seen[DEPTH]["data"], np.float64)
    points = np.zeros((*ids.shape, 3), np.float32)
    to_ray = np.linalg.inv(matrix)
    for each in objects:
        rows, columns = np.nonzero((ids == each.instance) & np.isfinite(depth))
        rays = np.stack([columns, rows, np.ones_like(rows)], axis=1) @ to_ray.T
        points[rows, columns] = (rays * depth[rows, columns, None] - each.position) @ each.rotation
    return points


def _is_known(name: str, indices: Mapping[str, int]) -> bool:
    if name not in indices:
        known = ", ".join(indices) or "none"
        warn_once(
            f"YCBVideoWriter: the class {name!r} has no index in class_name_to_index_map ({known}), so its objects are "
            "left out of the poses and are 0 in the label pictures."
        )
    return name in indices
