"""The arrays of BasicWriter's .npy files: their types and dimensions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.seen import Seen


def _rows(*fields: tuple) -> tuple[np.dtype, int]:
    return np.dtype(list(fields)), 1


_RATIO = ("occlusionRatio", "<f4")
_SOLID = [(f"{axis}_{end}", "<f4") for end in ("min", "max") for axis in "xyz"]
_IDS = [("instanceId", "<u4"), ("semanticId", "<u4")]
_CORNERS = [(name, "<i4") for name in ("x_min", "y_min", "x_max", "y_max")]
_BOX = [("semanticId", "<u4"), *_CORNERS, _RATIO]
_TURNED = [("semanticId", "<u4"), *((name, "<f4") for name in ("x", "y", "width", "height", "angle"))]
_TURNED += [("corners", "<f4", (4, 2)), _RATIO]
# By kind: the type, and the number of dimensions.
FORMS: Mapping[str, tuple[np.dtype, int]] = {
    "bounding_box_2d_tight": _rows(*_BOX),
    "bounding_box_2d_loose": _rows(*_BOX),
    "bounding_box_3d": _rows(("semanticId", "<u4"), *_SOLID, ("transform", "<f4", (4, 4)), _RATIO),
    "bounding_box_2d_amodal": _rows(*_BOX, ("truncationRatio", "<f4")),
    "oriented_bounding_box_2d": _rows(*_TURNED),
    "oriented_bounding_box_2d_amodal": _rows(*_TURNED),
    "visibility": _rows(*_IDS, ("visiblePixels", "<u4"), ("amodalPixels", "<u4"), *_CORNERS, ("visibleRatio", "<f4")),
    "truncation": _rows(*_IDS, ("truncationRatio", "<f4")),
    "keypoints": _rows(
        *_IDS,
        ("keypointId", "<u4"),
        ("x", "<f4"),
        ("y", "<f4"),
        ("distance", "<f4"),
        ("visibility", "u1"),
        ("hiddenBy", "<u4"),
        ("position", "<f4", (3,)),
    ),
    "object_coordinates": (np.dtype("<f4"), 3),
    "dense_correspondence": (np.dtype("<f4"), 3),
    "occlusion": _rows(("instanceId", "<u4"), ("semanticId", "<u4"), _RATIO),
    "distance_to_camera": (np.dtype("<f4"), 2),
    "distance_to_image_plane": (np.dtype("<f4"), 2),
    "motion_vectors": (np.dtype("<f4"), 3),
    "pointcloud": (np.dtype("<f4"), 2),
    "pointcloud_rgb": (np.dtype("u1"), 2),
    "pointcloud_normals": (np.dtype("<f4"), 2),
    "pointcloud_semantic": (np.dtype("<u4"), 1),
    "pointcloud_instance": (np.dtype("<u4"), 1),
}


def array_of(folder: Folder, seen: Seen, file: str | None, kind: str) -> np.ndarray | None:
    """Return the array of a file; None where there is none, and a fault where it is none of its kind.

    The exact type is asked of recorded frames only: who writes such files without usdsdg may have another one.
    """
    values = None if file is None else folder.array(file, seen.name)
    if file is None or values is None:
        return None
    dtype, dimensions = FORMS[kind]
    is_alike = values.dtype.names == dtype.names and (dtype.names is not None or values.dtype.kind in "biuf")
    if values.ndim == dimensions and is_alike and (seen.truth is None or values.dtype == dtype):
        return values
    expected, found = (
        f"{_type(each)}, {count} dimensions" for each, count in ((dtype, dimensions), (values.dtype, values.ndim))
    )
    folder.faults.append(Fault(file, seen.name, "is an array of another type", expected, found))
    return None


def _type(dtype: np.dtype) -> str:
    """Return a type as text, such as "<f4" or "semanticId <u4, x_min <i4"."""
    if dtype.names is None:
        return dtype.str
    return ", ".join(f"{name} {dtype[name].base.str}" for name in dtype.names)
