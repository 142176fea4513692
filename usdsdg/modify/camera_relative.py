"""Positions in image coordinates and on an orbit: `rep.modify.pose_camera_relative` and `pose_orbit`."""

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
from usdsdg.session.timeline import picture_time
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.cameras.stereo_pairs import stereo_pair
from usdsdg.stage.poses import transforms
from usdsdg.stage.poses.look_at import author_look_at
from usdsdg.stage.poses.xform_ops import author_world_position


def pose_camera_relative(
    camera: Any, render_product: Any, distance: Any, horizontal_location: Any = 0, vertical_location: Any = 0,
    input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Move prims to given image coordinates and a given distance from a camera.

    Args:
        camera: item, prim or path of a camera, or of the object that contains it; of a stereo pair it is the left one.
        render_product: gives the resolution of the image; the first one of a list.
        distance: from the camera's center to the prim's origin [stage units].
        horizontal_location: -1 (left edge) to 1 (right edge) of the image.
        vertical_location: -1 (bottom edge) to 1 (top edge).

    Raises:
        ArgumentError: `camera` is not exactly one prim, or `render_product` has no resolution.
        GraphError: at execution, the position lies outside the lens's field of view.
    """
    cameras = prim_paths(camera)
    if len(cameras) != 1:
        raise ArgumentError(f"modify.pose_camera_relative: camera is {len(cameras)} prims; give one")
    pair = stereo_pair(prim_at(cameras[0]))
    cameras = pair[:1] or cameras
    shown = render_product[0] if isinstance(render_product, (list, tuple)) and render_product else render_product
    product = str(getattr(shown, "path", shown))
    _view(cameras[0], product)
    return act(
        "OgnCameraRelativePosition", input_prims, attribute="position", cameraPrim=cameras[0], renderProduct=product,
        distance=distance, horizontalLocation=horizontal_location, verticalLocation=vertical_location,
    )  # fmt: skip


def _view(camera: str, product: str) -> CameraView:
    resolution = prim_at(product).GetAttribute("resolution").Get()
    if resolution is None:
        raise ArgumentError(f"modify.pose_camera_relative: render_product {product} has no resolution")
    stage = current_stage()
    return read_camera(stage, camera, (resolution[0], resolution[1]), time=picture_time(stage))


@action("OgnCameraRelativePosition")
def _write_camera_relative(node: Node, execution: int) -> None:
    view = _view(node.inputs["cameraPrim"], node.inputs["renderProduct"])
    roles = ("horizontalLocation", "verticalLocation", "distance")
    x, y, distance = (draw_numbers(role, node, execution) for role in roles)
    # The image center is on the optical axis only if the aperture has no offset.
    columns, rows = view.width * (1 + x) / 2, view.height * (1 - y) / 2
    origins, directions = view.rays(np.stack([columns, rows], axis=1))
    outside = np.flatnonzero(~np.isfinite(directions).all(axis=1))
    if len(outside):
        raise ArgumentError(
            f"modify.pose_camera_relative: {view.prim_path} sees nothing at horizontal_location {x[outside[0]]:g}, "
            f"vertical_location {y[outside[0]]:g}: this is outside the field of view of its lens, "
            f"{view.projection_type}"
        )
    points = (origins + directions * distance[:, None]) @ view.local_to_world[:3, :3] + view.local_to_world[3, :3]
    for path, point in zip(node.prims, points):
        author_world_position(prim_at(path), point, picture_time(current_stage()))


def pose_orbit(
    barycentre: Any, distance: Any, azimuth: Any, elevation: Any, look_at_barycentre: bool = True,
    input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Place prims, usually cameras, on a sphere around a point.

    Args:
        barycentre: a point of the world, or prims, of whose origins it is the mean.
        distance: radius of the sphere [stage units].
        azimuth: angle around the stage's up axis [degrees], from +X at 0 to +Y at 90 of a Z-up stage, and from +X to +Z
            of a Y-up stage.
        elevation: angle above the horizon [degrees].
        look_at_barycentre: rotate the prims to face the center.
    """
    values = dict(barycentre=plain(barycentre), distance=distance, azimuth=azimuth, elevation=elevation)
    return act(
        "OgnOrbitPose", input_prims, attribute="position,rotation" if look_at_barycentre else "position",
        lookAtBarycentre=bool(look_at_barycentre), **values,
    )  # fmt: skip


def orbit_directions(azimuth: np.ndarray, elevation: np.ndarray) -> np.ndarray:
    """Return unit vectors (..., 3) in the world of angles on an orbit [degrees]."""
    theta, phi = np.radians(azimuth), np.radians(elevation)
    first, second, up = np.cos(phi) * np.cos(theta), np.cos(phi) * np.sin(theta), np.sin(phi)
    # As in Replicator, which exchanges Y and Z: the angle goes from X to Z where Y is up.
    z_up = transforms.up_axis(current_stage()) == "Z"
    return np.stack([first, second, up] if z_up else [first, up, second], axis=-1)


@action("OgnOrbitPose")
def _write_orbit(node: Node, execution: int) -> None:
    distance, azimuth, elevation = (
        draw_numbers(role, node, execution) for role in ("distance", "azimuth", "elevation")
    )
    directions = orbit_directions(azimuth, elevation)
    given = node.inputs["barycentre"]
    targets = [given] * len(node.prims) if is_paths(given) else draw(given, node, execution, "barycentre")
    for path, direction, radius, target in zip(node.prims, directions, distance, targets):
        prim, center = prim_at(path), np.array(point_of("barycentre", target))
        author_world_position(prim, center + radius * direction, picture_time(current_stage()))
        if node.inputs["lookAtBarycentre"]:
            author_look_at(prim, center, time=picture_time(current_stage()))
