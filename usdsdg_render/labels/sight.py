"""Lines of sight on the host: first hits of rays, and where the surface points of an image are in another one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from usdsdg.parallel import launch_rows
from usdsdg_render.device.camera import camera_array
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.kernels.labels import sight as kernels
from usdsdg_render.labels.parts import DividedGprims
from usdsdg_render.scene.scene import Prototype, Scene

if TYPE_CHECKING:
    from collections.abc import Mapping

    from usdsdg.stage.cameras.camera_view import CameraView

# The AOVs that tell which point of which surface a pixel shows.
POINT_AOVS = ("instance", "triangle", "barycentrics")

_RAYS_PER_BAND = 1024


@dataclass(frozen=True)
class SurfacePoints:
    """The points of surfaces that the pixels of an image show; they stay the same when their surfaces move."""

    keys: tuple[str, ...]  # of the instances
    prototypes: tuple[Prototype, ...]  # of the instances
    instance: np.ndarray  # (H, W) int32, -1 for none
    triangle: np.ndarray  # (H, W) int32
    barycentrics: np.ndarray  # (H, W, 3) float32


def points_of(scene: Scene, aovs: Mapping[str, np.ndarray]) -> SurfacePoints:
    """Return the points that an image of the scene shows, from its AOVs `POINT_AOVS`."""
    prototypes = tuple(scene.prototypes[index] for index in scene.instances.prototype.tolist())
    return SurfacePoints(scene.instances.keys, prototypes, *(aovs[name] for name in POINT_AOVS))


def follow(
    device_scene: DeviceScene,
    scene: Scene,
    points: SurfacePoints,
    view: CameraView,
    *,
    mode: int,
    threads: int | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return where points are in the image of a camera now.

    Pixels (H, W, 2) float32, as column and row from the top left corner, NaN for none; and states (H, W) uint8: not in
    the image, hidden or visible. Points of instances that are gone, or whose mesh has other triangles now, are nowhere.
    """
    shape = points.instance.shape
    now = _now(scene, points)
    instance = now[points.instance] if len(now) else np.full(shape, -1, np.int32)
    device = device_scene.device
    inputs = [wp.array(instance, dtype=wp.int32, device=device)]
    inputs += [wp.array(points.triangle, dtype=wp.int32, device=device)]
    inputs += [wp.array(points.barycentrics, dtype=wp.vec3, device=device)]
    outputs = [wp.empty(shape, dtype=dtype, device=device) for dtype in (wp.vec2, wp.uint8)]
    cameras = camera_array([view], device)
    given = [device_scene.tables, cameras, *inputs, mode]
    launch_rows(kernels.follow_points, shape, given, outputs, device=device, threads=threads)
    return outputs[0].numpy(), outputs[1].numpy()


def first_hits(
    device_scene: DeviceScene,
    rays: Mapping[str, np.ndarray],
    divided: DividedGprims,
    *,
    mode: int,
    threads: int | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance (N,) float32 of the first hit of each ray, inf for none, and its entry (N,) int32, or -1.

    rays: origins, directions (N, 3), and first and last distance (N,).
    """
    device, count = device_scene.device, len(rays["first"])
    kinds: dict[str, Any] = {"origins": wp.vec3, "directions": wp.vec3, "first": wp.float32, "last": wp.float32}
    inputs = [
        wp.array(np.ascontiguousarray(rays[name], np.float32), dtype=dtype, device=device)
        for name, dtype in kinds.items()
    ]
    outputs = [wp.empty(count, dtype=dtype, device=device) for dtype in (wp.float32, wp.int32, wp.int32)]
    launch_rows(
        kernels.trace_rays, (count,), [device_scene.tables, *inputs, mode], outputs, device=device, threads=threads,
        band_rows=_RAYS_PER_BAND,
    )  # fmt: skip
    divided.tell_apart(*outputs[1:])
    return outputs[0].numpy(), outputs[1].numpy()


def _now(scene: Scene, points: SurfacePoints) -> np.ndarray:
    """Return the index now of each instance of the points, and -1 for those that are not there, and for no instance."""
    instances, count = scene.instances, len(points.keys)
    now = np.full(count + 1, -1, np.int32)
    if instances.keys == points.keys:
        now[:count] = np.arange(count)
    else:
        places = {key: index for index, key in enumerate(instances.keys)}
        now[:count] = [places.get(key, -1) for key in points.keys]
    same: dict[tuple[int, int], bool] = {}
    for index, place in enumerate(now[:count].tolist()):
        if place >= 0:
            before, after = points.prototypes[index], scene.prototypes[instances.prototype[place]]
            key = id(before), id(after)
            if key not in same:
                same[key] = before is after or np.array_equal(before.triangles, after.triangles)
            if not same[key]:
                now[index] = -1
    return now
