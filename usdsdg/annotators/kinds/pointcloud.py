"""Point clouds of the visible surface, with color, normals and ids."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define, predicate_of
from usdsdg.annotators.colors import UNLABELLED
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.pixels import look_ups
from usdsdg.annotators.pixels.unprojection import unproject
from usdsdg.stage.cameras.pixels import pixel_centers


@define(
    "DistanceToImagePlaneSDIsaacConvertDepthToPointCloud",
    aovs=["distance_to_image_plane", "distance_to_camera"],
    dtype=np.float32,
)
def depth_to_pointcloud(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """One point per pixel, row by row: float32 (H * W, 3) in the camera's optical frame [m]: x right, y down, z ahead.

    All three are +inf where nothing is hit. A fisheye sees points with z < 0.
    """
    camera = frame.camera
    if camera.lens is None:
        return Annotation(unproject(camera, frame.image("distance_to_image_plane")))
    depth = frame.aov("distance_to_image_plane")
    seen = np.isfinite(depth)
    rows, columns = np.nonzero(seen)
    origins, directions = camera.rays(pixel_centers(columns, rows))
    # For rays perpendicular to the optical axis, depth does not determine the distance.
    along = frame.aov("distance_to_camera")[seen].astype(np.float64)
    points = np.full((*depth.shape, 3), np.inf, np.float32)
    points[seen] = (origins * camera.meters_per_unit + along[:, None] * directions) * (1.0, -1.0, -1.0)
    return Annotation(points.reshape(-1, 3))


@define(
    "pointcloud",
    aovs=["position", "normals", "instance"],
    needs_path_tracing=True,
    params={**LABEL_PARAMS, "includeUnlabelled": False},
    dtype=np.float32,
    info={
        "pointRgb": np.zeros((0, 4), np.uint8),
        "pointNormals": np.zeros((0, 4), np.float32),
        "pointSemantic": np.zeros(0, np.uint32),
        "pointInstance": np.zeros(0, np.uint32),
    },
)
def pointcloud(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """One point per pixel with a labeled hit, row by row: float32 (N, 3) in the world [stage units].

    info: pointRgb uint8 and pointNormals float32 (N, 4 each), pointSemantic and pointInstance uint32 (N).
    includeUnlabelled: also keep points of gprims without a selected label.
    """
    predicate = predicate_of(params)
    selection = frame.selection(predicate)
    # Unlabeled gprims are member -1, and look up the appended id; the last entry is that of pixels without a hit.
    members = np.append(selection.member_of_gprim, -1)
    is_kept = np.ones(len(members), bool) if params["includeUnlabelled"] else members >= 0
    is_kept[-1] = False
    tables = {"classes": selection.class_ids, "ids": selection.ids}
    points, normals, colors, classes, ids = look_ups.gather_points(
        frame.image("instance"), is_kept,
        {name: np.append(values, UNLABELLED)[members] for name, values in tables.items()},
        {name: frame.image(name) for name in ("position", "normals", "LdrColor")},
    )  # fmt: skip
    info = {"pointRgb": colors, "pointNormals": normals, "pointSemantic": classes, "pointInstance": ids}
    return Annotation(points, info)
