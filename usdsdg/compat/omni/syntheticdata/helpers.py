"""`omni.syntheticdata.helpers`: the table of labeled prims, boxes of labeled prims, and projection of points."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from usdsdg.compat.omni.syntheticdata.instance_mappings import instance_mappings
from usdsdg.compat.omni.syntheticdata.structured import BOX_3D, CORNER_NAMES, MAPPING, OCCLUSION, PRIM_FIELDS, joined
from usdsdg.errors import Unsupported
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.poses.transforms import as_array, local_to_world

__all__ = [
    "get_bbox_3d_corners", "get_instance_mappings", "get_projection_matrix", "get_view_params", "get_view_proj_mat",
    "image_to_world", "merge_sensors", "project_pinhole", "reduce_bboxes_3d", "world_to_image",
]  # fmt: skip

_CORNERS = np.array([[x, y, z, 1.0] for z in (0, 1) for y in (0, 1) for x in (0, 1)])


class View(Protocol):
    """A viewport: a camera and a resolution."""

    @property
    def camera_path(self) -> Any: ...

    @property
    def resolution(self) -> Sequence[int]: ...


# The labeled prims


def get_instance_mappings() -> np.ndarray:
    """Return the prims with a label of type "class" that have gprims; inner ones before those that they are in.

    Structured (N,): uniqueId int32 from 1, name (the path), semanticId int32 (equal for equal labels), semanticLabel,
    instanceIds (ids of all gprims below), metadata ((type, label) of other labels).
    """
    return np.array(
        [(row.unique_id, row.path, row.semantic_id, row.label, row.instance_ids, row.metadata)
         for row in instance_mappings()],
        MAPPING,
    )  # fmt: skip


def identified(
    mappings: Iterable[Mapping[str, Any]], values: Iterable[Sequence[Any]], fields: Sequence[Any]
) -> np.ndarray:
    """Return rows of labeled prims with further `fields`: structured (N,), `PRIM_FIELDS` first."""
    names = [name for name, _ in PRIM_FIELDS]
    rows = [(*(row[name] for name in names), *own) for row, own in zip(mappings, values, strict=True)]
    return np.array(rows, [*PRIM_FIELDS, *fields])


# Boxes


def get_bbox_3d_corners(extents: Any) -> np.ndarray:
    """Return the corners in the world (N, 8, 3) of boxes with fields x_min to z_max and transform; x first, then y."""
    low, high = (np.stack([extents[name] for name in CORNER_NAMES[k : k + 3]], axis=-1)[:, None] for k in (0, 3))
    points = low + (high - low) * _CORNERS[None, :, :3]
    matrices = np.asarray(extents["transform"])
    return points @ matrices[:, :3, :3] + matrices[:, 3:, :3]


def reduce_bboxes_3d(bboxes: np.ndarray, instance_mappings: np.ndarray) -> np.ndarray:
    """Return the boxes of labeled prims, in their frames, around the boxes of the gprims below: structured (N,).

    The fields are uniqueId, name, semanticLabel, metadata, instanceIds, and those of `bboxes` but instanceId.
    """
    time = stage_time(current_stage())
    corners = get_bbox_3d_corners(bboxes)
    kept, rows = [], []
    for mapping in instance_mappings:
        inside = np.isin(bboxes["instanceId"], mapping["instanceIds"])
        if not inside.any():
            continue
        prim = current_stage().GetPrimAtPath(mapping["name"].split("[", 1)[0])
        to_world = as_array(local_to_world(prim, time))
        to_local = np.linalg.inv(to_world)
        points = corners[inside].reshape(-1, 3) @ to_local[:3, :3] + to_local[3, :3]
        kept.append(mapping)
        rows.append((mapping["semanticId"], *points.min(axis=0), *points.max(axis=0), to_world))
    boxes = identified(kept, rows, BOX_3D.descr[1:])
    if "corners" in (bboxes.dtype.names or ()):
        own = np.array([(each,) for each in get_bbox_3d_corners(boxes)] if rows else [], [("corners", "<f4", (8, 3))])
        boxes = joined(boxes, own)
    return boxes


def united_boxes(boxes: np.ndarray, paths: Sequence[str], mappings: np.ndarray) -> np.ndarray:
    """Return the 2D boxes of labeled prims, each around those of `boxes` that belong to it or to a prim below it."""
    kept, rows = [], []
    for mapping in mappings:
        inside = boxes[[_is_below(path, mapping["name"]) for path in paths]] if len(boxes) else boxes
        if len(inside):
            kept.append(mapping)
            lows, highs = ([inside[f"{axis}_{end}"] for axis in "xy"] for end in ("min", "max"))
            rows.append((mapping["semanticId"], *map(np.min, lows), *map(np.max, highs)))
    fields = [("semanticId", "<u4"), *((name, "<i4") for name in ("x_min", "y_min", "x_max", "y_max"))]
    return identified(kept, rows, fields)


def occlusion_rows(found: np.ndarray, paths: Sequence[str], mappings: np.ndarray, *, parsed: bool) -> np.ndarray:
    """Return the occlusion of the labeled prims at `paths`, in the order of `mappings`."""
    ratio_of = dict(zip(paths, found["occlusionRatio"], strict=True))
    kept = [row for row in mappings if row["name"] in ratio_of]
    if parsed:
        values = [(row["semanticId"], ratio_of[row["name"]]) for row in kept]
        return identified(kept, values, OCCLUSION.descr[1:])
    return np.array([(row["uniqueId"], row["semanticId"], ratio_of[row["name"]]) for row in kept], OCCLUSION)


def merge_sensors(
    bounding_box_2d_tight: np.ndarray | None = None,
    bounding_box_2d_loose: np.ndarray | None = None,
    bounding_box_3d: np.ndarray | None = None,
    occlusion_quadrants: np.ndarray | None = None,
) -> np.ndarray | None:
    """Return one row per labeled prim with the fields of all that is given; None if nothing is.

    Corners get the suffixes _bbox2d_tight, _bbox2d_loose and _bbox3d, and are -1 where a prim has no such box.
    """
    given = [
        (bounding_box_2d_tight, "_bbox2d_tight"), (bounding_box_2d_loose, "_bbox2d_loose"),
        (bounding_box_3d, "_bbox3d"), (occlusion_quadrants, "_occ"),
    ]  # fmt: skip
    tables = [(table, suffix) for table, suffix in given if table is not None]
    if not tables:
        return None
    shared = [*(name for name, _ in PRIM_FIELDS), "semanticId"]
    rows: dict[int, dict[str, Any]] = {}
    fields: dict[str, Any] = {}
    for table, suffix in tables:
        own = {name: name + suffix if name in CORNER_NAMES else name for name in table.dtype.names or ()}
        fields |= {new: table.dtype[name] for name, new in own.items()}
        for row in table:
            rows.setdefault(int(row["uniqueId"]), {}).update({new: row[name] for name, new in own.items()})
    names = [*(name for name in shared if name in fields), *(name for name in fields if name not in shared)]
    merged = [tuple(_value(rows[key], name, fields[name]) for name in names) for key in sorted(rows)]
    return np.array(merged, [(name, fields[name]) for name in names])


def _value(row: Mapping[str, Any], name: str, dtype: np.dtype) -> Any:
    """Return a field of a merged row; -1, or an empty text, where it is missing."""
    if name in row:
        return row[name]
    return "" if dtype.kind == "O" else np.full(dtype.shape, -1, dtype.base)


def _is_below(path: str, root: str) -> bool:
    return path == root or path.startswith((f"{root}/", f"{root}["))


# Projection


def get_view_params(viewport: View) -> dict[str, Any]:
    """Return the camera of a viewport: view_to_world and world_to_view (4, 4) for row vectors, width, height,
    aspect_ratio, clipping_range [stage units], horizontal_aperture and focal_length [tenths of stage units],
    projection_type; and, beyond Replicator, optical_center, which offsets of the aperture move, as fractions of the
    width and the height.
    """
    stage = current_stage()
    width, height = viewport.resolution
    view = read_camera(stage, str(viewport.camera_path), (width, height), time=stage_time(stage))
    return {
        "view_to_world": view.local_to_world, "world_to_view": view.world_to_camera,
        "projection_type": view.projection_type, "ftheta": None, "width": width, "height": height,
        "aspect_ratio": width / height, "clipping_range": view.clipping_range,
        "horizontal_aperture": view.horizontal_aperture, "focal_length": view.focal_length,
        "optical_center": (view.cx / width, view.cy / height),
    }  # fmt: skip


def get_projection_matrix(fov: float, aspect_ratio: float, z_near: float, z_far: float) -> np.ndarray:
    """Return the (4, 4) matrix, for row vectors, from the camera to clip space; depth is 0 at the near plane.

    fov: horizontal [radians]. x and y are negated together with w, which is the camera's z.
    """
    across, range_ = -1.0 / math.tan(fov / 2), z_far - z_near
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = across, -across * aspect_ratio
    matrix[2, 2], matrix[2, 3], matrix[3, 2] = z_far / range_, 1.0, z_near * z_far / range_
    return matrix


def get_view_proj_mat(view_params: Mapping[str, Any]) -> np.ndarray:
    """Return the (4, 4) matrix, for row vectors, from the world to clip space."""
    fov = 2 * math.atan(view_params["horizontal_aperture"] / (2 * view_params["focal_length"]))
    near, far = view_params["clipping_range"]
    return np.asarray(view_params["world_to_view"]) @ get_projection_matrix(fov, view_params["aspect_ratio"], near, far)


def project_pinhole(points: Any, view_params: Mapping[str, Any]) -> np.ndarray:
    """Project points of the world (N, 3) to (N, 3): fractions of the image's width and height from the top left, and
    the depth of clip space.
    """
    homogeneous = np.insert(np.asarray(points, np.float64), 3, 1.0, axis=1)
    clip = homogeneous @ get_view_proj_mat(view_params)
    clip = clip[:, :3] / clip[:, 3:]
    return np.concatenate([clip[:, :2] / 2 + _optical_center(view_params), clip[:, 2:]], axis=1)


def world_to_image(points: Any, viewport: View, view_params: Mapping[str, Any] | None = None) -> np.ndarray:
    """As `project_pinhole`, through the camera of a viewport.

    Raises:
        Unsupported: the camera is not a pinhole.
    """
    view_params = get_view_params(viewport) if view_params is None else view_params
    _check_pinhole("world_to_image", viewport.camera_path, view_params)
    return project_pinhole(points, view_params)


def image_to_world(image_coordinates: Any, view_params: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return the place of the camera (3,) and the directions (N, 3), of length 1, in which it sees points of its image.

    image_coordinates: (N, 2) [pixels], from the top left.

    Raises:
        Unsupported: the camera is not a pinhole.
    """
    _check_pinhole("image_to_world", "the camera", view_params)
    across = view_params["horizontal_aperture"] / (2 * view_params["focal_length"])
    size = np.array([view_params["width"], view_params["height"]], np.float64)
    from_center = np.asarray(image_coordinates, np.float64) / size - _optical_center(view_params)
    screen = 2 * from_center * (across, -across / view_params["aspect_ratio"])
    to_world = np.asarray(view_params["view_to_world"], np.float64)
    directions = np.insert(screen, 2, -1.0, axis=1) @ to_world[:3, :3]
    return to_world[3, :3], directions / np.linalg.norm(directions, axis=1, keepdims=True)


def _optical_center(view_params: Mapping[str, Any]) -> np.ndarray:
    """Return it as fractions of width and height; the middle for parameters that a script has made without it."""
    return np.array(view_params.get("optical_center", (0.5, 0.5)))


def _check_pinhole(name: str, camera: object, view_params: Mapping[str, Any]) -> None:
    if view_params["projection_type"] not in ("pinhole", None):
        raise Unsupported(
            f"helpers.{name}: {camera} has the projection {view_params['projection_type']!r}; "
            "the annotator camera_params has what a projection needs"
        )
