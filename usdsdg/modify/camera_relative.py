"""Poses in a camera's image and around a point. Mirrors `rep.modify.pose_camera_relative` and `pose_orbit`."""

from typing import Any

import numpy as np

from usdsdg.arguments.prims import prim_at
from usdsdg.distribution import draw
from usdsdg.errors import ArgumentError
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem, plain, prim_paths
from usdsdg.modify.numbers import draw_numbers
from usdsdg.modify.poses import is_paths, point_of
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.poses import transforms
from usdsdg.stage.poses.look_at import author_look_at
from usdsdg.stage.poses.xform_ops import author_world_position


def pose_camera_relative(
    camera: Any, render_product: Any, distance: Any, horizontal_location: Any = 0, vertical_location: Any = 0,
    input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Move prims to where they appear at a chosen position of a camera's image.

    Args:
        camera: item, prim or path of a camera, or of the object that holds it.
        render_product: whose resolution the picture has.
        distance: from the camera's center to the prim's origin [stage units].
        horizontal_location: -1 (left edge) to 1 (right edge) of the picture.
        vertical_location: -1 (bottom edge) to 1 (top edge).

    Raises:
        ArgumentError: `camera` is not one camera, or `render_product` has no resolution.
        GraphError: at execution, the position lies outside of what the camera's lens sees.
    """
    cameras = prim_paths(camera)
    if len(cameras) != 1:
        raise ArgumentError(f"modify.pose_camera_relative: camera is {len(cameras)} prims; give one")
    product = str(getattr(render_product, "path", render_product))
    _view(cameras[0], product)
    return act(
        "OgnCameraRelativePosition", input_prims, attribute="position", cameraPrim=cameras[0], renderProduct=product,
        distance=distance, horizontalLocation=horizontal_location, verticalLocation=vertical_location,
    )  # fmt: skip


def _view(camera: str, product: str) -> CameraView:
    resolution = prim_at(product).GetAttribute("resolution").Get()
    if resolution is None:
        raise ArgumentError(f"modify.pose_camera_relative: render_product {product} has no resolution")
    return read_camera(current_stage(), camera, (resolution[0], resolution[1]))


@action("OgnCameraRelativePosition")
def _write_camera_relative(node: Node, execution: int) -> None:
    view = _view(node.inputs["cameraPrim"], node.inputs["renderProduct"])
    roles = ("horizontalLocation", "verticalLocation", "distance")
    x, y, distance = (draw_numbers(role, node, execution) for role in roles)
    # Pixels are centered on the optical axis only where the lens has no shift.
    columns, rows = view.width * (1 + x) / 2, view.height * (1 - y) / 2
    origins, directions = view.rays(np.stack([columns, rows], axis=1))
    unseen = np.flatnonzero(~np.isfinite(directions).all(axis=1))
    if len(unseen):
        raise ArgumentError(
            f"modify.pose_camera_relative: {view.prim_path} sees nothing at horizontal_location {x[unseen[0]]:g}, "
            f"vertical_location {y[unseen[0]]:g}: its lens, {view.projection_type}, ends before that"
        )
    points = (origins + directions * distance[:, None]) @ view.local_to_world[:3, :3] + view.local_to_world[3, :3]
    for path, point in zip(node.prims, points):
        author_world_position(prim_at(path), point)


def pose_orbit(
    barycentre: Any, distance: Any, azimuth: Any, elevation: Any, look_at_barycentre: bool = True,
    input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Place prims on a sphere around a point, usually cameras around what they look at.

    Args:
        barycentre: a point of the world, or prims whose middle it is.
        distance: radius of the sphere [stage units].
        azimuth: angle around the stage's up axis [degrees], counter-clockwise seen from above; 0 is +X of a Z-up stage
            and +Z of a Y-up stage.
        elevation: angle above the horizon [degrees].
        look_at_barycentre: turn the prims towards the center.
    """
    values = dict(barycentre=plain(barycentre), distance=distance, azimuth=azimuth, elevation=elevation)
    return act(
        "OgnOrbitPose", input_prims, attribute="position,rotation" if look_at_barycentre else "position",
        lookAtBarycentre=bool(look_at_barycentre), **values,
    )  # fmt: skip


@action("OgnOrbitPose")
def _write_orbit(node: Node, execution: int) -> None:
    distance, azimuth, elevation = (
        draw_numbers(role, node, execution) for role in ("distance", "azimuth", "elevation")
    )
    around, above = np.radians(azimuth), np.radians(elevation)
    forward, left, up = np.cos(above) * np.cos(around), np.cos(above) * np.sin(around), np.sin(above)
    z_up = transforms.up_axis(current_stage()) == "Z"
    directions = np.stack([forward, left, up] if z_up else [left, up, forward], axis=1)
    given = node.inputs["barycentre"]
    centers = [given] * len(node.prims) if is_paths(given) else draw(given, node, execution, "barycentre")
    for path, direction, radius, center in zip(node.prims, directions, distance, centers):
        prim, middle = prim_at(path), np.array(point_of("barycentre", center))
        author_world_position(prim, middle + radius * direction)
        if node.inputs["lookAtBarycentre"]:
            author_look_at(prim, middle)
