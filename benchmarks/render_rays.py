"""How fast rays are: camera rays, shadow rays and diffuse bounces of the benchmark scene.

`python -m benchmarks.render_rays`: millions of rays per second of CPU time, on one thread. Where `embreex` is installed
the same rays go through Embree as well.
"""

from __future__ import annotations

import importlib.util
import time

import numpy as np
import warp as wp

from benchmarks import render_scene
from usdsdg_render.device import DeviceScene
from usdsdg_render.kernels.rays import trace_rays
from usdsdg_render.kernels.types import Hit
from usdsdg_render.scene import Scene

REPEATS = 3


def ours(device_scene: DeviceScene, rays: tuple[np.ndarray, np.ndarray, np.ndarray], any_hit: bool) -> tuple:
    """Hits, and millions of rays per CPU second (the best of some repeats)."""
    origins, directions, reach = rays
    inputs = [wp.array(each, dtype=wp.vec3, device="cpu") for each in (origins, directions)]
    hits = wp.zeros(len(reach), dtype=Hit, device="cpu")
    best = np.inf
    for _ in range(REPEATS):
        start = time.process_time()
        wp.launch(
            trace_rays,
            dim=len(reach),
            inputs=[device_scene.tables, int(any_hit), 0, *inputs, wp.array(reach, dtype=wp.float32, device="cpu")],
            outputs=[hits],
            device="cpu",
        )
        best = min(best, time.process_time() - start)
    return hits.numpy(), len(reach) / best / 1e6


def embree(scene: Scene, rays: tuple[np.ndarray, np.ndarray, np.ndarray], any_hit: bool) -> float:
    """Millions of rays per CPU second through Embree over the flattened scene."""
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    target = rtcore_scene.EmbreeScene()
    for which, matrix in zip(scene.instances.prototype, scene.instances.local_to_world, strict=True):
        prototype = scene.prototypes[which]
        points = (prototype.points @ matrix[:3, :3] + matrix[3, :3]).astype(np.float32)
        TriangleMesh(target, points[prototype.triangles])
    query = "OCCLUDED" if any_hit else "INTERSECT"
    best = np.inf
    for _ in range(REPEATS + 1):
        start = time.process_time()
        target.run(rays[0], rays[1], dists=rays[2], query=query)
        best = min(best, time.process_time() - start)
    return len(rays[2]) / best / 1e6


def camera_rays(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Through all pixel centres of both views."""
    origins, directions = [], []
    for view in render_scene.views(scene):
        x, y = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
        d = np.stack([(x - view.cx) / view.fx, (view.cy - y) / view.fy, np.full_like(x, -1)], -1).reshape(-1, 3)
        d = d @ view.local_to_world[:3, :3]
        directions.append(d / np.linalg.norm(d, axis=1, keepdims=True))
        origins.append(np.broadcast_to(view.local_to_world[3, :3], d.shape))
    count = sum(len(each) for each in directions)
    return (
        np.concatenate(origins).astype(np.float32),
        np.concatenate(directions).astype(np.float32),
        np.full(count, 1e30, np.float32),
    )


def main() -> None:
    scene = render_scene.build()
    device_scene = DeviceScene("cpu")
    device_scene.sync(scene)
    first = camera_rays(scene)
    hits, _ = ours(device_scene, first, False)
    hit = hits["instance"] >= 0
    points = first[0][hit] + first[1][hit] * (hits["t"][hit] * (1 - 1e-4))[:, None]
    to_light = scene.lights["position"][1] - points
    distance = np.linalg.norm(to_light, axis=1)
    # Some direction on the near side of the surface stands for a diffuse bounce.
    scattered = np.random.default_rng(0).normal(size=points.shape)
    scattered /= np.linalg.norm(scattered, axis=1, keepdims=True)
    scattered -= first[1][hit]
    scattered /= np.linalg.norm(scattered, axis=1, keepdims=True)
    sets = {
        "camera": (first, False),
        "shadow": ((points, (to_light / distance[:, None]).astype(np.float32), distance.astype(np.float32)), True),
        "bounce": ((points, scattered.astype(np.float32), np.full(len(points), 1e30, np.float32)), False),
    }
    for name, (rays, any_hit) in sets.items():
        line = f"{name}: {len(rays[2])} rays, {ours(device_scene, rays, any_hit)[1]:.2f} Mrays/CPU-s"
        if importlib.util.find_spec("embreex"):
            line += f", Embree {embree(scene, rays, any_hit):.2f}"
        print(line)


if __name__ == "__main__":
    main()
