"""Keypoints that scripts set on prims: where they are in the picture, and which are visible. Beyond Replicator."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.colors import BACKGROUND, UNLABELLED
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.scene_queries import NOT_IN_PICTURE, OCCLUDED, VISIBLE
from usdsdg.errors import AnnotatorError
from usdsdg.stage.cameras.camera_view import CameraView

Params = Mapping[str, Any]

KEYPOINT = np.dtype(
    [
        ("instanceId", "<u4"),
        ("semanticId", "<u4"),
        ("keypointId", "<u4"),
        ("x", "<f4"),
        ("y", "<f4"),
        ("distance", "<f4"),
        ("visibility", "u1"),
        ("hiddenBy", "<u4"),
        ("position", "<f4", (3,)),
    ]
)


_NO_NAMES: Mapping[str, Any] = {"keypointNames": [], "primPaths": []}  # info before the first frame
NAME = "keypoints"
PRIMS = "keypoint prims"  # what a frame's memo calls them


@define(NAME, aovs=["instance"], params={**LABEL_PARAMS, "tolerance": 0.005}, dtype=KEYPOINT, info=_NO_NAMES)
def keypoints(frame: Frame, params: Params) -> Annotation:
    """Keypoints that `functional.modify.keypoints` has set on prims, in the picture.

    Structured (N,): instanceId and semanticId uint32, those of the segmentations, of the labeled prim that the keypoint
    belongs to (1: none); keypointId uint32; x, y float32, column and row from the top left corner [pixels], NaN where
    the lens does not see it; distance float32 from the camera [m]; visibility uint8: 0 not in the picture, 1 occluded,
    2 visible; hiddenBy uint32: the id of the instance that occludes it, the object's own if that does, 0 for none;
    position float32 (3,) in the world [stage units]. info: keypointNames by keypointId, primPaths in the order of the
    rows. Hidden prims are left out.

    tolerance: distance [m] by which a surface must be before a keypoint to occlude it, so that points on a surface or
        slightly inside are visible.
    """
    predicate, tolerance = predicate_of(params), params["tolerance"]
    if isinstance(tolerance, bool) or not isinstance(tolerance, (int, float)) or tolerance < 0:
        raise AnnotatorError(f"keypoints: tolerance is {tolerance!r}; expected a distance of 0 m or more")
    prims = frame.derive(PRIMS, frame.labeled_prims.read_keypoints)
    names = sorted({name for prim in prims for name in prim.keypoints})
    info = {"keypointNames": names, "primPaths": [prim.name for prim in prims for _ in prim.keypoints]}
    rows = np.zeros(len(info["primPaths"]), KEYPOINT)
    if len(rows):
        counts = [len(prim.keypoints) for prim in prims]
        instance_ids, class_ids = _ids(frame, predicate, [prim.ancestors for prim in prims])
        rows["instanceId"], rows["semanticId"] = np.repeat(instance_ids, counts), np.repeat(class_ids, counts)
        rows["keypointId"] = [names.index(name) for prim in prims for name in prim.keypoints]
        _fill_sight(frame, predicate, rows, np.concatenate([prim.positions for prim in prims]), tolerance)
    return Annotation(rows, info)


def _fill_sight(frame: Frame, predicate: str | None, rows: np.ndarray, points: np.ndarray, tolerance: float) -> None:
    """Fill in where the points (N, 3) of the world are in the picture, and what occludes them."""
    camera, selection = frame.camera, frame.selection(predicate)
    rows["position"] = points
    pixels, depths = camera.project(points)
    rows["x"], rows["y"] = pixels.T
    origins, along, near, distances = _lines(camera, pixels, points)
    rows["distance"] = (distances - _start(camera)) * camera.meters_per_unit
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= 0) & (pixels < (camera.width, camera.height))).all(axis=1)
    depths = depths if _is_flat(camera) else distances
    inside &= (depths > camera.clipping_range[0]) & (depths < camera.clipping_range[1])
    before = np.maximum(distances - tolerance / camera.meters_per_unit, near)
    _, hit = frame.queries.first_hits(origins, along, near, np.where(inside, before, near))
    id_of_gprim = np.append(selection.ids, UNLABELLED)[selection.member_of_gprim]
    rows["hiddenBy"] = np.where(inside, np.append(id_of_gprim, BACKGROUND)[hit], BACKGROUND)
    rows["visibility"] = np.where(inside, np.where(hit >= 0, OCCLUDED, VISIBLE), NOT_IN_PICTURE)


def _lines(camera: CameraView, pixels: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the lines of sight to points of pixels: origins and unit directions (N, 3) in the world, and the distances
    (N,) to the near plane and to the points.

    They begin at the camera, or at a near plane behind it.
    """
    rotation, position = camera.local_to_world[:3, :3], camera.local_to_world[3, :3]
    origins = camera.rays(np.nan_to_num(pixels))[0] @ rotation + position + _start(camera) * rotation[2]
    lines = points - origins
    distances = np.linalg.norm(lines, axis=1)
    along = lines / np.maximum(distances, 1e-300)[:, None]
    near = np.full(len(points), max(camera.clipping_range[0], 0.0))
    if _is_flat(camera):
        near /= np.maximum(along @ -rotation[2], 1e-6)
    return origins, along, near, distances


def _start(camera: CameraView) -> float:
    """Return how far behind the camera its near plane is, as that of an orthographic camera may be [stage units]."""
    return max(-camera.clipping_range[0], 0.0)


def _is_flat(camera: CameraView) -> bool:
    """Return whether clipping distances count along the axis of the camera, and not along the line of sight."""
    return camera.lens is None or camera.lens.is_flat


def _ids(frame: Frame, predicate: str | None, ancestors: list[tuple[str, ...]]) -> tuple[list[int], list[int]]:
    """Return instance and class id of the nearest selected prim among each prim's ancestors; UNLABELLED if none is."""
    selection = frame.selection(predicate)
    members = {frame.labeled_prims.prim_paths[row]: member for member, row in enumerate(selection.rows.tolist())}
    found = [next((members[name] for name in names if name in members), None) for names in ancestors]
    instance_ids = [UNLABELLED if member is None else int(selection.ids[member]) for member in found]
    return instance_ids, [UNLABELLED if member is None else int(selection.class_ids[member]) for member in found]
