"""The points that the camera sees, with colour, normal and ids."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.colors import FIRST_LABELLED, UNLABELLED
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.segmentation import unique_labels
from usdsdg.errors import Unsupported
from usdsdg.stage.cameras import LINEAR_PROJECTIONS


@define("DistanceToImagePlaneSDIsaacConvertDepthToPointCloud", aovs=["distance_to_image_plane"], dtype=np.float32)
def depth_to_pointcloud(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """One point per pixel, row by row: float32 (H * W, 3) in the camera's optical frame [m]: x right, y down, z ahead.

    All three are +inf where nothing is hit.

    Raises:
        Unsupported: the lens is not linear.
    """
    camera, depth = frame.camera, frame.aov("distance_to_image_plane").astype(np.float64)
    if camera.projection_type not in LINEAR_PROJECTIONS:
        raise Unsupported(f"{camera.prim_path}: points of depths need a linear lens, not {camera.projection_type!r}.")
    rows, columns = np.mgrid[: camera.height, : camera.width] + 0.5
    seen = np.isfinite(depth)
    # Pixels are rays through the pinhole, or parallel ones with `fx` pixels per stage unit.
    spread = np.where(seen, depth, 0) if camera.projection_type == "pinhole" else camera.meters_per_unit
    points = np.full((*depth.shape, 3), np.inf, np.float32)
    points[seen, 0] = ((columns - camera.cx) / camera.fx * spread)[seen]
    points[seen, 1] = ((rows - camera.cy) / camera.fy * spread)[seen]
    points[seen, 2] = depth[seen]
    return Annotation(points.reshape(-1, 3))


@define(
    "pointcloud",
    aovs=["position", "normals", "instance"],
    needs_picture=True,
    params={**LABEL_PARAMS, "includeUnlabelled": False},
    dtype=np.float32,
)
def pointcloud(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """One point per pixel that shows something, row by row: float32 (N, 3) in the world [stage units].

    info: pointRgb uint8 and pointNormals float32 (N * 4 each, flat), pointSemantic and pointInstance uint32 (N).
    includeUnlabelled: keep points of gprims without a selected label too.
    """
    predicate = predicate_of(params)
    members, instance = frame.members(predicate), frame.aov("instance")
    kept = instance >= 0 if params["includeUnlabelled"] else members >= 0
    member = members[kept]
    _, id_of_member = unique_labels(frame.selection(predicate).labels)
    normals = np.ones((len(member), 4), np.float32)
    normals[:, :3] = frame.aov("normals")[kept]
    info = {
        "pointRgb": frame.aov("LdrColor")[kept].reshape(-1),
        "pointNormals": normals.reshape(-1),
        # Member -1, an unlabelled point, looks up the appended entry.
        "pointSemantic": np.append(id_of_member + FIRST_LABELLED, UNLABELLED)[member].astype(np.uint32),
        "pointInstance": np.where(member >= 0, member + FIRST_LABELLED, UNLABELLED).astype(np.uint32),
    }
    return Annotation(frame.aov("position")[kept].astype(np.float32), info)
