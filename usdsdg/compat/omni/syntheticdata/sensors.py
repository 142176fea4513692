"""`omni.syntheticdata.sensors`: arrays of a viewport, by type of sensor.

A sensor is enabled first; it has an array from the next update of the application on, and an empty one before. Arrays
show the stage at the latest update, and are rendered when they are read. Ids: 0 is nothing; gprims have those of the
annotator instance_id_segmentation; labeled prims count from 1. Only labels of type "class" count.
"""

from collections.abc import Iterable
from typing import Any, Protocol

import numpy as np
from pxr import UsdGeom

from usdsdg.app.app import get_app
from usdsdg.compat.omni.syntheticdata import helpers
from usdsdg.compat.omni.syntheticdata._syntheticdata import SensorType
from usdsdg.compat.omni.syntheticdata.leaf_boxes import leaf_boxes
from usdsdg.compat.omni.syntheticdata.structured import BOX_2D, OCCLUSION, joined
from usdsdg.compat.omni.syntheticdata.synthetic_data import SyntheticData, SyntheticDataException, SyntheticDataStage
from usdsdg.errors import Unsupported
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.poses.transforms import as_array, world_to_local

__all__ = [
    "SyntheticData", "SyntheticDataException", "SyntheticDataStage", "create_or_retrieve_sensor",
    "create_or_retrieve_sensor_async", "disable_sensors", "enable_sensors", "get_bounding_box_2d_loose",
    "get_bounding_box_2d_tight", "get_bounding_box_3d", "get_camera_3d_position", "get_cross_correspondence",
    "get_depth", "get_depth_linear", "get_distance_to_camera", "get_distance_to_image_plane",
    "get_instance_segmentation", "get_motion_vector", "get_normals", "get_occlusion", "get_occlusion_quadrant",
    "get_rgb", "get_semantic_data", "get_semantic_segmentation", "get_sensor_array", "get_synthetic_data",
    "initialize_async", "next_render_simulation_async", "next_sensor_data_async",
]  # fmt: skip


class RenderView(Protocol):
    """What a sensor looks through: a viewport."""

    @property
    def render_product_path(self) -> str: ...

    @property
    def camera_path(self) -> Any: ...


def get_synthetic_data() -> SyntheticData:
    return SyntheticData.Get()


# Enabling


def enable_sensors(viewport: RenderView, sensor_types: Iterable[SensorType]) -> None:
    """Enable sensors of a viewport.

    Raises:
        Unsupported: there is no such sensor here.
        BadPrim: the viewport's camera is not on the stage.
    """
    for sensor in sensor_types:
        SyntheticData.Get().activate_node_template(_render_var(sensor), 0, [viewport.render_product_path])


def disable_sensors(viewport: RenderView, sensor_types: Iterable[SensorType]) -> None:
    for sensor in sensor_types:
        SyntheticData.Get().deactivate_node_template(_render_var(sensor), 0, [viewport.render_product_path])


def create_or_retrieve_sensor(viewport: RenderView, sensor_type: SensorType) -> SensorType:
    """Enable a sensor; return its type."""
    enable_sensors(viewport, [sensor_type])
    return sensor_type


async def create_or_retrieve_sensor_async(viewport: RenderView, sensor_type: SensorType) -> SensorType:
    """Enable a sensor and wait for the next update; return its type."""
    enable_sensors(viewport, [sensor_type])
    await next_sensor_data_async(viewport)
    return sensor_type


async def initialize_async(viewport: RenderView, sensor_types: Iterable[SensorType], timeout: int = 10) -> None:
    """Enable sensors and wait for the next update."""
    enable_sensors(viewport, sensor_types)
    await next_sensor_data_async(viewport)


async def next_sensor_data_async(
    viewport: object = None, waitSimFrame: bool = False, inViewportId: object = None
) -> None:
    """Wait for the next update, which all sensors see."""
    await get_app().next_update_async()


async def next_render_simulation_async(render_product_path: str, num_simulation_frames_offset: int = 0) -> None:
    """Wait for the next update, or for `num_simulation_frames_offset` updates if that is more."""
    for _ in range(max(num_simulation_frames_offset, 1)):
        await get_app().next_update_async()


# Images


def get_sensor_array(
    viewport: RenderView, sensor_type: SensorType, elemType: Any, elemCount: int, is2DArray: bool
) -> np.ndarray:
    """Return the array of a sensor: (H, W) or (H, W, elemCount) if `is2DArray`, else (N,); empty without a frame.

    Raises:
        Unsupported: there is no such sensor here.
    """
    if sensor_type.name == "Camera3dPosition":
        raise Unsupported("sensor Camera3dPosition: use the annotator pointcloud, whose points are in the world")
    array = SyntheticData.Get().read(_render_var(sensor_type), viewport.render_product_path)
    if array is None:
        channels = (elemCount,) if elemCount > 1 else ()
        return np.empty((*((0, 0) if is2DArray else (0,)), *channels), elemType)
    return array.astype(elemType, copy=False)


def get_rgb(viewport: RenderView) -> np.ndarray:
    """Tone-mapped color, uint8 (H, W, 4)."""
    return get_sensor_array(viewport, SensorType.Rgb, np.uint8, 4, True)


def get_depth(viewport: RenderView) -> np.ndarray:
    """The reciprocal of the distance along the optical axis [1/m], float32 (H, W); 0 where nothing is hit."""
    return 1.0 / get_sensor_array(viewport, SensorType.Depth, np.float32, 1, True)


def get_depth_linear(viewport: RenderView) -> np.ndarray:
    """Distance along the optical axis [m], float32 (H, W); +inf where nothing is hit."""
    return get_sensor_array(viewport, SensorType.DepthLinear, np.float32, 1, True)


def get_distance_to_image_plane(viewport: RenderView) -> np.ndarray:
    """Distance along the optical axis [m], float32 (H, W); +inf where nothing is hit."""
    return get_sensor_array(viewport, SensorType.DistanceToImagePlane, np.float32, 1, True)


def get_distance_to_camera(viewport: RenderView) -> np.ndarray:
    """Distance from the camera's center [m], float32 (H, W); +inf where nothing is hit."""
    return get_sensor_array(viewport, SensorType.DistanceToCamera, np.float32, 1, True)


def get_normals(viewport: RenderView) -> np.ndarray:
    """Unit normals in the world, float32 (H, W, 3); 0 where nothing is hit."""
    return get_sensor_array(viewport, SensorType.Normal, np.float32, 4, True)[..., :3]


def get_motion_vector(viewport: RenderView) -> np.ndarray:
    """Motion since the last image [pixels], float32 (H, W, 4), as the annotator motion_vectors."""
    return get_sensor_array(viewport, SensorType.MotionVector, np.float32, 4, True)


def get_cross_correspondence(viewport: RenderView) -> np.ndarray:
    """Displacement to the image of the reference camera, float32 (H, W, 4), as the annotator cross_correspondence."""
    return get_sensor_array(viewport, SensorType.CrossCorrespondence, np.float32, 4, True)


def get_camera_3d_position(viewport: RenderView) -> np.ndarray:
    """Unsupported: the annotator pointcloud has the points, in the world.

    Raises:
        Unsupported: always.
    """
    return get_sensor_array(viewport, SensorType.Camera3dPosition, np.float32, 4, True)


# Segmentation


def get_instance_segmentation(
    viewport: RenderView, parsed: bool = False, return_mapping: bool = False, instance_mappings: Any = None
) -> Any:
    """Return the id of each pixel's gprim, uint32 (H, W); if `parsed`, that of the nearest labeled prim around it.

    With `return_mapping` also the table of `helpers.get_instance_mappings`; pass one as `instance_mappings` to use it.
    """
    image = get_sensor_array(viewport, SensorType.InstanceSegmentation, np.uint32, 1, True)
    return _mapped(image, "uniqueId" if parsed else None, return_mapping, instance_mappings)


def get_semantic_segmentation(
    viewport: RenderView, parsed: bool = False, return_mapping: bool = False, instance_mappings: Any = None
) -> Any:
    """Return the semantic id of each pixel, uint32 (H, W): that of the label of the nearest labeled prim around it.

    Replicator leaves the ids undefined unless `parsed`; here they are the same. The rest as
    `get_instance_segmentation`.
    """
    image = get_sensor_array(viewport, SensorType.SemanticSegmentation, np.uint32, 1, True)
    return _mapped(image, "semanticId", return_mapping, instance_mappings)


def get_semantic_data(instance_mappings: Any = None) -> np.ndarray:
    """Return the labeled prims: structured (N,) of uniqueId, name, semanticLabel, metadata."""
    mappings = helpers.get_instance_mappings() if instance_mappings is None else instance_mappings
    fields = [("uniqueId", np.int32), ("name", "O"), ("semanticLabel", "O"), ("metadata", "O")]
    return np.array([tuple(row[name] for name, _ in fields) for row in mappings], fields)


def _mapped(image: np.ndarray, column: str | None, return_mapping: bool, mappings: Any) -> Any:
    """Replace ids of gprims by a column of the table of labeled prims, and return the table too if asked to."""
    if column or return_mapping:
        mappings = helpers.get_instance_mappings() if mappings is None else mappings
    if column:
        highest = max([int(image.max(initial=0)), *(max(row["instanceIds"]) for row in mappings)])
        table = np.zeros(highest + 1, np.uint32)
        for row in mappings[::-1]:  # inner prims come first, and count
            table[row["instanceIds"]] = row[column]
        image = table[image]
    return (image, mappings) if return_mapping else image


# Boxes and occlusion


def get_bounding_box_2d_tight(viewport: RenderView, instance_mappings: Any = None) -> np.ndarray:
    """Boxes of the visible pixels [pixels, inclusive] of labeled prims, with all that is below them.

    Structured (N,): uniqueId, name, semanticLabel, metadata, instanceIds, semanticId, x_min, y_min, x_max, y_max.
    """
    return _boxes_2d(viewport, SensorType.BoundingBox2DTight, instance_mappings)


def get_bounding_box_2d_loose(viewport: RenderView, instance_mappings: Any = None) -> np.ndarray:
    """As `get_bounding_box_2d_tight`, of the whole prims, whether they are hidden or not."""
    return _boxes_2d(viewport, SensorType.BoundingBox2DLoose, instance_mappings)


def get_bounding_box_3d(
    viewport: RenderView,
    parsed: bool = False,
    return_corners: bool = False,
    camera_frame: bool = False,
    instance_mappings: Any = None,
) -> np.ndarray:
    """Boxes of gprims of labeled prims [stage units], each in its own frame; if `parsed`, of the labeled prims.

    Structured (N,): instanceId and semanticId (uniqueId to semanticId as the 2D boxes if `parsed`), x_min, y_min,
    z_min, x_max, y_max, z_max, transform (4, 4) to the world for row vectors, and with `return_corners` corners (8, 3)
    in the world, x first. With `camera_frame` transforms and corners are in the frame of the viewport's camera. Prims
    out of view are listed too.
    """
    if SyntheticData.Get().read(_render_var(SensorType.BoundingBox3D), viewport.render_product_path) is None:
        return leaf_boxes([])
    mappings = helpers.get_instance_mappings() if instance_mappings is None else instance_mappings
    boxes = leaf_boxes(mappings)
    if return_corners and len(boxes):
        boxes = joined(boxes, np.array([(each,) for each in helpers.get_bbox_3d_corners(boxes)], _CORNERS))
    if parsed and len(boxes):
        boxes = helpers.reduce_bboxes_3d(boxes, mappings)
    if camera_frame and len(boxes):
        _into_camera(boxes, viewport)
    return boxes


_CORNERS = np.dtype([("corners", "<f4", (8, 3))])


def get_occlusion(viewport: RenderView, parsed: bool = False, instance_mappings: Any = None) -> np.ndarray:
    """Return the occluded fraction of labeled prims in view, 0 (visible) to 1: exact, where Replicator averages parts.

    Structured (N,): instanceId (the uniqueId of the labeled prim), semanticId, occlusionRatio; if `parsed`: uniqueId,
    name, semanticLabel, metadata, instanceIds, semanticId, occlusionRatio.
    """
    found = SyntheticData.Get().annotation(_render_var(SensorType.Occlusion), viewport.render_product_path)
    if found is None:
        return np.empty(0, OCCLUSION)
    mappings = helpers.get_instance_mappings() if instance_mappings is None else instance_mappings
    boxes, info = found
    return helpers.occlusion_rows(boxes, info["primPaths"], mappings, parsed=parsed)


def get_occlusion_quadrant(viewport: RenderView, return_bounding_boxes: bool = False) -> np.ndarray:
    """Return which sides of each labeled prim are hidden, from its tight and loose boxes.

    Structured (N,): uniqueId, name, semanticLabel, metadata, instanceIds and occlusion_quadrant: "fully-visible",
    "fully-occluded", or the hidden side or corner, such as "top" or "bottom-left". With `return_bounding_boxes` also
    semanticId and the corners of both boxes, with the suffixes _bbox2d_tight and _bbox2d_loose.
    """
    merged = helpers.merge_sensors(
        bounding_box_2d_tight=get_bounding_box_2d_tight(viewport),
        bounding_box_2d_loose=get_bounding_box_2d_loose(viewport),
    )
    assert merged is not None  # boxes were given
    quadrants = np.array([(_quadrant(row),) for row in merged], [("occlusion_quadrant", "O")])
    kept = list(merged.dtype.names or ()) if return_bounding_boxes else _IDENTITY
    return joined(merged[kept], quadrants)


_IDENTITY = ["uniqueId", "name", "semanticLabel", "metadata", "instanceIds"]


def _quadrant(row: Any) -> str:
    tight, loose = ({side: row[f"{side}_bbox2d_{kind}"] for side in _SIDES} for kind in ("tight", "loose"))
    if tight["x_min"] == -1:
        return "fully-occluded"
    hidden = {name for side, (name, sign) in _SIDES.items() if sign * (tight[side] - loose[side]) > 0}
    vertical = next((name for name in ("top", "bottom") if name in hidden), "")
    horizontal = next((name for name in ("right", "left") if name in hidden), "")
    return "-".join(filter(None, (vertical, horizontal))) or "fully-visible"


_SIDES = {"x_min": ("left", 1), "x_max": ("right", -1), "y_min": ("top", 1), "y_max": ("bottom", -1)}


def _boxes_2d(viewport: RenderView, sensor: SensorType, mappings: Any) -> np.ndarray:
    found = SyntheticData.Get().annotation(_render_var(sensor), viewport.render_product_path)
    if found is None:
        return helpers.identified([], [], BOX_2D.descr)
    mappings = helpers.get_instance_mappings() if mappings is None else mappings
    boxes, info = found
    return helpers.united_boxes(boxes, info["primPaths"], mappings)


def _into_camera(boxes: np.ndarray, viewport: RenderView) -> None:
    """Transform boxes in the world into the frame of the viewport's camera, in place."""
    camera = UsdGeom.Imageable(current_stage().GetPrimAtPath(viewport.camera_path)).GetPrim()
    time = stage_time(current_stage())
    to_camera = as_array(world_to_local(camera, time))
    boxes["transform"] = boxes["transform"] @ to_camera
    if "corners" in (boxes.dtype.names or ()):
        boxes["corners"] = boxes["corners"] @ to_camera[:3, :3] + to_camera[3, :3]


def _render_var(sensor: SensorType) -> str:
    return SyntheticData.convert_sensor_type_to_rendervar(sensor.name)
