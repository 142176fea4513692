"""Poses of objects as Isaac Sim's nodes Dope and Pose give them to DOPEWriter and YCBVideoWriter, with their numbers.

Both rotate the camera's axes by `cameraRotation`: Euler angles [degrees] of the rendering camera in the camera frame of
the poses. (180, 0, 0) is x right, y down, z ahead. They apply the same rotation to clip space, so that pixels count
from the bottom without it, and follow only a pinhole: the writers' option `exact` has numbers without such surprises.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.boxes import NO_TABLES, bounding_box_2d_tight, bounding_box_3d, bounding_box_3d_360
from usdsdg.annotators.kinds.camera import read_params
from usdsdg.stage.poses.rotations import decompose, matrix_from_euler

Params = Mapping[str, Any]

DOPE = np.dtype(
    [
        ("semanticId", "<u4"),
        ("visibility", "<f4"),
        ("location", "<f4", (3,)),
        ("rotation", "<f4", (4,)),
        ("projected_cuboid", "<f4", (9, 2)),
    ]
)
POSE = np.dtype(
    [
        ("semanticId", "<u4"),
        ("prims_to_desired_camera", "<f4", (4, 4)),
        ("center_coords_image_space", "<f4", (2,)),
    ]
)
# x right, y down, z ahead.
OPENCV_ROTATION = (180.0, 0.0, 0.0)
# The order of DOPE's cuboid: the far face (z max) from x max and y min around, then the near one.
_CORNERS = ((1, 0, 1), (0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 0, 0), (0, 0, 0), (0, 1, 0), (1, 1, 0))
_CENTIMETERS = 100.0  # per unit of a stage in meters
_NEEDS: Mapping[str, Any] = {"aovs": ["instance"], "needs_amodal_masks": True, "needs_poses": True}


@define(
    "dope",
    dtype=DOPE,
    info=NO_TABLES,
    params={**LABEL_PARAMS, "cameraRotation": OPENCV_ROTATION, "width": 0, "height": 0},
    **_NEEDS,
)
def dope(frame: Frame, params: Params) -> Annotation:
    """Poses of the labeled prims in view for DOPE, as DOPEWriter reads them.

    Structured (N,): semanticId uint32, visibility float32, location float32 (3,) [hundredths of stage units: cm where
    they are meters] of the prim's origin and rotation float32 (4,) w x y z in the turned camera, projected_cuboid
    float32 (9, 2) [pixels] of the box and then the prim's origin; info and label parameters as bounding_box_3d.
    cameraRotation turns the camera; width, height are those of the picture [pixels], 0 for its own.
    """
    boxes = bounding_box_3d(frame, params)
    assert boxes.data is not None
    view, turn = frame.camera.world_to_camera, _turn(params)
    rows = np.zeros(len(boxes.data), DOPE)
    rows["semanticId"], rows["visibility"] = boxes.data["semanticId"], 1.0 - boxes.data["occlusionRatio"]
    to_world = boxes.data["transform"].astype(np.float64)
    posed = decompose(to_world @ view @ turn)
    rows["location"], rows["rotation"] = posed.translate * _CENTIMETERS, posed.rotation[:, [3, 0, 1, 2]]
    points = np.concatenate([_corners(boxes.data) @ to_world, to_world[:, 3:]], axis=1)
    rows["projected_cuboid"] = _pixels(frame, points, turn, (params["width"], params["height"]))
    return Annotation(rows, boxes.info)


@define(
    "pose",
    dtype=POSE,
    info=NO_TABLES,
    params={
        **LABEL_PARAMS,
        "cameraRotation": OPENCV_ROTATION,
        "imageWidth": 0,
        "imageHeight": 0,
        "getCenters": True,
        "includeOccludedPrims": False,
    },
    **_NEEDS,
)
def pose(frame: Frame, params: Params) -> Annotation:
    """Poses of the visible labeled prims, as YCBVideoWriter reads them.

    Structured (N,): semanticId uint32, prims_to_desired_camera float32 (4, 4) for column vectors [stage units] from the
    prim to the turned camera, with the columns of local-to-world normalized, center_coords_image_space float32 (2,)
    [pixels] of the prim's origin; info and label parameters as bounding_box_3d. cameraRotation turns the camera;
    imageWidth, imageHeight are those of the picture [pixels], 0 for its own. includeOccludedPrims lists all prims.
    getCenters is accepted: there always are centers.
    """
    boxes = bounding_box_3d_360(frame, params)
    assert boxes.data is not None
    tight = bounding_box_2d_tight(frame, params)
    listed = np.isin(boxes.info["bboxIds"], tight.info["bboxIds"]) | bool(params["includeOccludedPrims"])
    found = boxes.data[listed]
    rows = np.zeros(len(found), POSE)
    rows["semanticId"] = found["semanticId"]
    to_world, turn = found["transform"].astype(np.float64), _turn(params)
    # By column, as the node does, although the rows are the axes; right only for scales that are the same along all.
    lengths = np.linalg.norm(to_world[:, :3, :3], axis=1, keepdims=True)
    to_world[:, :3, :3] /= np.where(lengths > 0, lengths, 1.0)
    rows["prims_to_desired_camera"] = (to_world @ frame.camera.world_to_camera @ turn).swapaxes(1, 2)
    size = params["imageWidth"], params["imageHeight"]
    rows["center_coords_image_space"] = _pixels(frame, to_world[:, 3:], turn, size)[:, 0]
    return Annotation(
        rows,
        {
            "idToLabels": boxes.info["idToLabels"],
            "bboxIds": boxes.info["bboxIds"][listed],
            "primPaths": [path for path, own in zip(boxes.info["primPaths"], listed) if own],
        },
    )


def _turn(params: Params) -> np.ndarray:
    """Return the rotation (4, 4), for row vectors, from the rendering camera to the camera frame of the poses."""
    turn = np.eye(4)
    turn[:3, :3] = matrix_from_euler(np.asarray(params["cameraRotation"], np.float64))
    return turn


def _corners(boxes: np.ndarray) -> np.ndarray:
    """Return the corners (N, 8, 4) of boxes in their prims' frames, in DOPE's order, with a 1 as the last."""
    ends = np.array([[boxes[f"{axis}_{end}"] for axis in "xyz"] for end in ("min", "max")], np.float64)  # (2, 3, N)
    corners = np.stack([[ends[side, axis] for axis, side in enumerate(sides)] for sides in _CORNERS])  # (8, 3, N)
    return np.concatenate([corners, np.ones_like(corners[:, :1])], axis=1).transpose(2, 0, 1)


def _pixels(frame: Frame, points: np.ndarray, turn: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Project points (N, K, 4) of the world to pixels (N, K, 2): clip space is turned, and rows count upwards."""
    parameters = read_params(frame.camera)
    clip = points @ frame.camera.world_to_camera @ parameters["cameraProjection"].reshape(4, 4) @ turn
    with np.errstate(divide="ignore", invalid="ignore"):
        across = 0.5 * (clip[..., :2] / clip[..., 3:] + 1.0)
    return across * (size[0] or frame.view.width, size[1] or frame.view.height)
