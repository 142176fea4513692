"""Rays against hand-made scenes: by the renderer, and by brute force over all triangles in float64."""

from __future__ import annotations

import numpy as np
import warp as wp

from tests.render.bvh.trace_rays import trace_rays
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.scene.scene import Scene
from usdsdg_render.scene.structs import Hit


def trace(scene: Scene | DeviceScene, origins, directions, *, reach=1e30, any_hit=False) -> np.ndarray:
    """One record (t, u, v, instance, triangle) per ray."""
    if isinstance(scene, Scene):
        on_device = DeviceScene("cpu")
        on_device.sync(scene)
    else:
        on_device = scene
    origins, directions = np.broadcast_arrays(np.atleast_2d(origins), np.atleast_2d(directions))
    count = len(origins)
    hits = wp.zeros(count, dtype=Hit, device="cpu")
    inputs = [
        wp.array(np.ascontiguousarray(each, np.float32), dtype=wp.vec3, device="cpu") for each in (origins, directions)
    ]
    reaches = wp.array(np.broadcast_to(np.float32(reach), count).copy(), dtype=wp.float32, device="cpu")
    wp.launch(
        trace_rays,
        dim=count,
        inputs=[on_device.tables, int(any_hit), 0, *inputs, reaches],
        outputs=[hits],
        device="cpu",
    )
    return hits.numpy()


def world_triangles(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """All triangles in the world, (T, 3, 3) float64, and the instance of each."""
    corners, owners = [], []
    for k, (which, matrix) in enumerate(zip(scene.instances.prototype, scene.instances.local_to_world, strict=True)):
        prototype = scene.prototypes[which]
        points = prototype.points.astype(np.float64) @ matrix[:3, :3] + matrix[3, :3]
        corners.append(points[prototype.triangles])
        owners.append(np.full(len(prototype.triangles), k))
    return np.concatenate(corners), np.concatenate(owners)


def brute_force(triangles: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return per ray the smallest t > 0 (inf for none), and a margin: the smallest distance of any barycentric weight
    from zero among nearby triangles."""
    best = np.full(len(origins), np.inf)
    doubt = np.full(len(origins), np.inf)
    edge_1, edge_2 = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    for k, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        across = np.cross(direction, edge_2)
        det = (edge_1 * across).sum(1)
        with np.errstate(divide="ignore", invalid="ignore"):
            to_origin = origin - triangles[:, 0]
            u = (to_origin * across).sum(1) / det
            other = np.cross(to_origin, edge_1)
            v = other @ direction / det
            t = (other * edge_2).sum(1) / det
            inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (det != 0)
            near_edge = np.minimum(np.minimum(np.abs(u), np.abs(v)), np.abs(1 - u - v))
            near_edge[(u < -1e-3) | (v < -1e-3) | (u + v > 1.001) | (t < 0) | (det == 0)] = np.inf
        if inside.any():
            best[k] = t[inside].min()
        doubt[k] = np.nan_to_num(near_edge, nan=np.inf).min()
    return best, doubt
