"""Ray queries on the benchmark scene compared with Embree: the same rays, on one thread, and how many hits differ.

    python -m benchmarks.render_rays [--rounds 5] [--quick]

Camera rays go through all pixel centers of both views. At their hits start bounded shadow rays to the sphere
lights, and rays in cosine-distributed directions, which look for the closest surface (diffuse) or for any (sky).
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np
import warp as wp

from benchmarks import peers, render_scene, report
from benchmarks.embree_scene import EmbreeScene
from benchmarks.scene_meshes import FlatMesh, flattened
from benchmarks.timing import in_turns
from tests.render.bvh.trace_rays import trace_rays
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.scene.scene import Scene
from usdsdg_render.scene.structs import LIGHT_SPHERE, Hit

FAR = np.float32(1e30)
# Offset of secondary rays from the surface, and of the ends of shadow rays from the light [m].
RAY_EPSILON, LIGHT_EPSILON = 1e-4, 1e-3


class Rays(NamedTuple):
    """The rays of a query; arrays are contiguous float32."""

    origins: np.ndarray  # (N, 3)
    directions: np.ndarray  # (N, 3), unit
    max_distance: np.ndarray  # (N,)
    any_hit: bool
    at_least: float  # times Embree's rate


class WideTrees:
    """Our ray queries, on rays that are already on the device."""

    def __init__(self, scene: Scene) -> None:
        self._scene = DeviceScene("cpu")
        self._scene.sync(scene)

    def bind(self, rays: Rays):
        """Return a function that traces the rays and returns their hits."""
        inputs = [wp.array(each, dtype=wp.vec3, device="cpu") for each in rays[:2]]
        inputs.append(wp.array(rays.max_distance, dtype=wp.float32, device="cpu"))
        hits = wp.zeros(len(rays.max_distance), dtype=Hit, device="cpu")

        def trace(_round: int) -> np.ndarray:
            arguments = [self._scene.tables, int(rays.any_hit), 0, *inputs]
            wp.launch(trace_rays, dim=len(rays.max_distance), inputs=arguments, outputs=[hits], device="cpu")
            return hits.numpy()

        return trace


def camera_rays(scene: Scene, size: tuple[int, int]) -> Rays:
    """Return rays through all pixel centers of both views, row by row."""
    origins, directions = [], []
    for view in render_scene.views(scene, size):
        x, y = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
        d = np.stack([(x - view.cx) / view.fx, (view.cy - y) / view.fy, np.full_like(x, -1)], -1).reshape(-1, 3)
        directions.append(d @ view.local_to_world[:3, :3])
        origins.append(np.broadcast_to(view.local_to_world[3, :3], d.shape))
    return rays_of(np.concatenate(origins), np.concatenate(directions), at_least=0.95)


def rays_of(origins, directions, *, max_distance=None, any_hit: bool = False, at_least: float) -> Rays:
    """Return rays in the layout that both sides take."""
    directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    max_distance = np.full(len(origins), FAR) if max_distance is None else max_distance
    arrays = (np.ascontiguousarray(each, np.float32) for each in (origins, directions, max_distance))
    return Rays(*arrays, any_hit, at_least)


def secondary_rays(scene: Scene, mesh: FlatMesh, first: Rays, hits: np.ndarray) -> dict[str, Rays]:
    """Return the rays that a path tracer would trace next from the hits of camera rays."""
    rng = np.random.default_rng(0)
    hit = hits["instance"] >= 0
    corners = mesh.points[mesh.triangles[mesh.first[hits["instance"][hit]] + hits["triangle"][hit]]].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals *= -np.sign(np.sum(normals * first.directions[hit], axis=1, keepdims=True))
    points = first.origins[hit] + first.directions[hit] * hits["t"][hit][:, None] + RAY_EPSILON * normals

    lights = scene.lights[scene.lights["kind"] == LIGHT_SPHERE]
    light = lights[rng.integers(len(lights), size=len(points))]
    to_light = light["position"] + light["radius"][:, None] * on_sphere(rng, len(points)) - points
    scattered = normals + on_sphere(rng, len(points))
    max_distance = np.linalg.norm(to_light, axis=1) - LIGHT_EPSILON
    return {
        "any: shadow to a light": rays_of(points, to_light, max_distance=max_distance, any_hit=True, at_least=0.9),
        "any: sky": rays_of(points, scattered, any_hit=True, at_least=0.9),
        "closest: diffuse": rays_of(points, scattered, at_least=0.95),
    }


def on_sphere(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return (count, 3) uniform directions."""
    directions = rng.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def differing(rays: Rays, ours: np.ndarray, theirs: np.ndarray, mesh: FlatMesh) -> float:
    """Return the fraction of rays that hit another triangle, or hit something in one of both only."""
    if rays.any_hit:
        return float(np.mean((ours["instance"] >= 0) != (theirs >= 0)))
    ours_flat = np.where(ours["instance"] >= 0, mesh.first[ours["instance"]] + ours["triangle"], -1)
    return float(np.mean(ours_flat != theirs))


def compare(name: str, rays: Rays, trees: WideTrees, embree: EmbreeScene | None, mesh: FlatMesh, rounds: int) -> None:
    """Print a row: millions of rays per CPU second of both."""
    contenders = {"ours": trees.bind(rays)}
    if embree is not None:
        query = embree.occluded if rays.any_hit else embree.closest
        contenders["embree"] = lambda _round: query(*rays[:3])
    timings = in_turns(contenders, rounds=rounds)
    rate = {key: len(rays.max_distance) / each.cpu / 1e6 for key, each in timings.items()}
    ours = f"{rate['ours']:.2f} Mrays/CPU-s"
    if embree is None:
        report.row(name, ours, peers.NO_PEER)
        return
    differs = differing(rays, timings["ours"].results[-1], timings["embree"].results[-1], mesh)
    ratio, target = rate["ours"] / rate["embree"], f"at least {rays.at_least}x"
    report.row(name, ours, f"Embree {rate['embree']:.2f}", ratio=ratio, target=target)
    print(f"    {len(rays.max_distance)} rays, {differs:.3%} hit something else")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--quick", action="store_true", help="images of 160x120")
    options = parser.parse_args()
    report.begin()
    scene = render_scene.build()
    mesh = flattened(scene)
    print(f"{len(scene.instances)} objects, {len(mesh.triangles)} triangles flattened")
    trees = WideTrees(scene)
    embree = EmbreeScene(mesh) if peers.installed("embreex") else None
    first = camera_rays(scene, (160, 120) if options.quick else (640, 480))
    sets = {"closest: camera": first, **secondary_rays(scene, mesh, first, trees.bind(first)(0))}
    for name, rays in sets.items():
        compare(name, rays, trees, embree, mesh, options.rounds)


if __name__ == "__main__":
    main()
