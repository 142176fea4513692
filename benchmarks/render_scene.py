"""The renderer's benchmark scene: 337 generated objects in a region of 5 x 5 x 3 m.

187 instances of 15 bumpy meshes (2 000 to 20 000 triangles, 256² textures) and 150 small boxes and spheres, under an
HDR sky with hot spots, a distant light and three sphere lights. Two cameras look at one object, from 0.75 m and 2.5 m.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.render.scenes import cube, light, material, prototype, scene_of, sphere_light, view_from
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg_render.scene.scene import Dome, Prototype, Scene, Texture
from usdsdg_render.scene.structs import LIGHT_DISTANT

REGION = np.array([5.0, 5.0, 3.0])
MESHES, MESH_INSTANCES, SMALL = 15, 187, 150


def bumpy(rng: np.random.Generator, triangles: int, name: str) -> Prototype:
    """Return a closed wavy surface: an ellipsoid or a torus, with smooth normals and UVs."""
    rows = max(8, int(np.sqrt(triangles / 4)))
    columns = triangles // (2 * rows)
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    around, up = 2 * np.pi * u, v
    waves = rng.integers(2, 9, 3)
    bump = 1 + 0.06 * np.sin(waves[0] * around) * np.sin(waves[1] * np.pi * up) + 0.04 * np.sin(9 * waves[2] * up)
    if rng.random() < 0.5:
        squash = rng.uniform(0.1, 0.3, 3)
        latitude = (up - 0.5) * np.pi
        points = np.stack([np.cos(latitude) * np.cos(around), np.cos(latitude) * np.sin(around), np.sin(latitude)], -1)
        points *= squash * bump[..., None]
    else:
        ring, tube = rng.uniform(0.15, 0.3), rng.uniform(0.04, 0.12) * bump
        wide = ring + tube * np.cos(2 * np.pi * up)
        points = np.stack([wide * np.cos(around), wide * np.sin(around), tube * np.sin(2 * np.pi * up)], -1)
    return _grid_mesh(points, np.stack([u, v], -1) * 2, name)


def _grid_mesh(points: np.ndarray, uv: np.ndarray, name: str) -> Prototype:
    columns, rows = points.shape[0] - 1, points.shape[1] - 1
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    a = (i * (rows + 1) + j).ravel()
    b = a + rows + 1
    triangles = np.concatenate([np.stack([a, b, b + 1], -1), np.stack([a, b + 1, a + 1], -1)])
    points = points.reshape(-1, 3).astype(np.float32)
    corners = points[triangles]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    kept = np.linalg.norm(facing, axis=1) > 1e-10
    triangles, facing = triangles[kept], facing[kept]
    normals = np.zeros_like(points)
    for k in range(3):
        np.add.at(normals, triangles[:, k], facing)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return prototype(points, triangles, normals=normals[triangles], uvs=uv.reshape(-1, 2)[triangles], name=name)


def ball(name: str = "/ball") -> Prototype:
    """Return a unit sphere of 32 segments."""
    u, v = np.meshgrid(np.linspace(0, 1, 33), np.linspace(0, 1, 17), indexing="ij")
    a, b = 2 * np.pi * u, np.pi * (v - 0.5)
    points = np.stack([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)], -1)
    return _grid_mesh(points, np.stack([u, v], -1), name)


def box(name: str = "/box") -> Prototype:
    """Return the cube [-1, 1]^3 with flat normals."""
    square = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], np.float32)
    return replace(cube(name=name), uvs=np.tile(square, (6, 1, 1)))


def rotation(rng: np.random.Generator) -> np.ndarray:
    """Return a uniformly random rotation matrix."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def sky(height: int = 512) -> Dome:
    """Return a blue gradient with three suns [nits]."""
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(2 * height) + 0.5) / (2 * height), indexing="ij")
    d = np.stack(
        [np.sin(np.pi * v) * np.cos(2 * np.pi * u), np.sin(np.pi * v) * np.sin(2 * np.pi * u), np.cos(np.pi * v)], -1
    )
    radiance = np.array([0.25, 0.28, 0.33]) + np.maximum(d[..., 2:], 0) * np.array([0.3, 0.45, 0.8])
    for toward, color, sharpness in (
        ((1, 0.3, 0.5), (60, 50, 35), 300.0),
        ((-0.6, 0.7, 0.4), (25, 28, 40), 120.0),
        ((0.2, -0.9, 0.3), (400, 390, 350), 4000.0),
    ):
        axis = np.array(toward) / np.linalg.norm(toward)
        radiance = radiance + np.exp(sharpness * (d @ axis - 1))[..., None] * np.array(color)
    return Dome((radiance * 1000).astype(np.float32), np.eye(3, dtype=np.float32))


def _materials(rng: np.random.Generator, count: int) -> np.ndarray:
    rows = np.tile(material(), count)
    rows["base_color"] = rng.uniform(0.05, 0.95, (count, 3))
    rows["roughness"] = rng.uniform(0.15, 0.9, count)
    rows["metallic"] = rng.random(count) < 0.2
    rows["base_color_texture"][:MESHES] = np.arange(MESHES)
    rows["base_color"][:MESHES] = 1.0
    rows["metallic"][MESHES:] = 0.0
    return rows


def _textures(rng: np.random.Generator) -> list[Texture]:
    out = []
    y, x = np.mgrid[0:256, 0:256] // 32
    for k in range(MESHES):
        checks = ((x + y) % 2)[..., None] * 0.7 + 0.3 * rng.random((256, 256, 1))
        a, b = rng.uniform(0.1, 0.95, (2, 3))
        texels = np.full((256, 256, 4), 255, np.uint8)
        texels[..., :3] = (a * checks + b * (1 - checks)) * 255
        out.append(Texture(f"checks_{k}", texels, True, 0, 0))
    return out


def _lights(rng: np.random.Generator) -> list[np.ndarray]:
    positions, radii = rng.uniform(-REGION / 2, REGION / 2, (3, 3)), rng.uniform(0.02, 0.15, 3)
    radiances = rng.uniform(0.2, 1, (3, 3)) * 40000
    sun = light(LIGHT_DISTANT, radiance=(1000, 950, 850), cos_angle=1.0, visible=0)
    return [sun, *map(sphere_light, radiances, positions, radii)]


def build(seed: int = 0) -> Scene:
    """The scene, the same for the same seed."""
    rng = np.random.default_rng(seed)
    sizes = rng.permutation(np.geomspace(2000, 20000, MESHES).astype(int))
    prototypes = [bumpy(rng, n, f"/mesh_{k}") for k, n in enumerate(sizes)] + [ball(), box()]
    materials, textures, lights = _materials(rng, MESHES + SMALL), _textures(rng), _lights(rng)
    # (prototype, material) of every object: meshes share theirs, small things have one each.
    kinds = [(k % MESHES, k % MESHES) for k in range(MESH_INSTANCES)]
    kinds += [(MESHES + k % 2, MESHES + k) for k in range(SMALL)]
    scales = [*rng.uniform(0.35, 1.35, MESH_INSTANCES), *rng.uniform(0.015, 0.15, SMALL)]
    placed = []
    for (which, slot), scale in zip(kinds, scales, strict=True):
        matrix = np.eye(4)
        matrix[:3, :3] = rotation(rng) * scale
        matrix[3, :3] = rng.uniform(-REGION / 2, REGION / 2)
        placed.append((prototypes[which], matrix, slot))
    return scene_of(placed, materials=[materials], textures=textures, lights=lights, dome=sky())


def views(scene: Scene, size: tuple[int, int] = (640, 480)) -> list[CameraView]:
    """A close view of object 0 and a wider one of object 1."""
    centers = scene.instances.local_to_world[:, 3, :3]
    rng = np.random.default_rng(1)
    out = []
    for k, distance in enumerate((0.75, 2.5)):
        # Of some directions choose the one whose eye is farthest from every object.
        backs = rng.normal(size=(32, 3))
        backs /= np.linalg.norm(backs, axis=1, keepdims=True)
        eyes = centers[k] + distance * backs
        best = np.argmax(np.linalg.norm(eyes[:, None] - centers, axis=2).min(1))
        out.append(_view(k, eyes[best], centers[k], size))
    return out


def many_views(scene: Scene, count: int, size: tuple[int, int] = (640, 480)) -> list[CameraView]:
    """Return `count` different cameras: each looks at an object from 0.5 to 2 m in any direction."""
    centers = scene.instances.local_to_world[:, 3, :3]
    rng = np.random.default_rng(2)
    backs = rng.normal(size=(count, 3))
    backs *= rng.uniform(0.5, 2.0, (count, 1)) / np.linalg.norm(backs, axis=1, keepdims=True)
    targets = centers[np.arange(count) % len(centers)] + rng.uniform(-0.15, 0.15, (count, 3))
    return [_view(k, targets[k] + backs[k], targets[k], size) for k in range(count)]


def _view(k: int, eye: np.ndarray, target: np.ndarray, size: tuple[int, int]) -> CameraView:
    view = view_from(eye, target, size=size, focal_length=24.0, horizontal_aperture=20.955, clipping_range=(0.01, 1e5))
    return replace(view, prim_path=f"/World/camera_{k}")
