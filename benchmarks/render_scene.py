"""The renderer's benchmark scene: 337 objects in a 5 x 5 x 3 m region, made by code.

187 instances of 15 bumpy meshes (2 000 to 20 000 triangles, 256² textures) and 150 small boxes and balls, under an HDR
sky with hot spots, a distant light and three sphere lights. Two cameras look at one object, from 0.75 m and 2.5 m.
"""

from __future__ import annotations

import numpy as np

from usdsdg.stage.cameras import CameraView
from usdsdg_render.scene import (
    LIGHT,
    LIGHT_DISTANT,
    LIGHT_SPHERE,
    MATERIAL,
    NO_TEXTURE,
    Dome,
    Instances,
    Prototype,
    Scene,
    Texture,
)

REGION = np.array([5.0, 5.0, 3.0])
MESHES, MESH_INSTANCES, SMALL = 15, 187, 150


def bumpy(rng: np.random.Generator, triangles: int, name: str) -> Prototype:
    """A closed wavy surface: a squashed ball or a torus, with smooth normals and UVs."""
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
    return Prototype(
        name,
        points,
        triangles.astype(np.int32),
        normals[triangles],
        uv.reshape(-1, 2).astype(np.float32)[triangles],
        np.zeros(len(triangles), np.int32),
        np.arange(len(triangles), dtype=np.int32),
    )


def ball(name: str = "/ball") -> Prototype:
    """A unit ball of 32 segments."""
    u, v = np.meshgrid(np.linspace(0, 1, 33), np.linspace(0, 1, 17), indexing="ij")
    a, b = 2 * np.pi * u, np.pi * (v - 0.5)
    points = np.stack([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)], -1)
    return _grid_mesh(points, np.stack([u, v], -1), name)


def box(name: str = "/box") -> Prototype:
    """The cube [-1, 1]^3, flat."""
    points = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32)
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    triangles = np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])], np.int32)
    corners = points[triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    square = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], np.float32)
    return Prototype(
        name,
        points,
        triangles,
        np.repeat(flat[:, None], 3, 1).astype(np.float32),
        np.tile(square, (6, 1, 1)),
        np.zeros(12, np.int32),
        np.arange(12, dtype=np.int32),
    )


def rotation(rng: np.random.Generator) -> np.ndarray:
    """A uniformly random rotation matrix."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def sky(height: int = 512) -> Dome:
    """A blue gradient with three suns [nits]."""
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
    rows = np.zeros(count, MATERIAL)
    for name in MATERIAL.names or ():
        if name.endswith("_texture"):
            rows[name] = NO_TEXTURE
    rows["base_color"] = rng.uniform(0.05, 0.95, (count, 3))
    rows["roughness"] = rng.uniform(0.15, 0.9, count)
    rows["metallic"] = rng.random(count) < 0.2
    rows["specular"], rows["opacity"], rows["normal_scale"], rows["uv_scale"] = 0.04, 1.0, 1.0, 1.0
    rows["base_texture"][:MESHES] = np.arange(MESHES)
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


def _lights(rng: np.random.Generator) -> np.ndarray:
    rows = np.zeros(4, LIGHT)
    rows["kind"][0], rows["kind"][1:] = LIGHT_DISTANT, LIGHT_SPHERE
    rows["x_axis"], rows["y_axis"], rows["z_axis"] = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    rows["radiance"][0], rows["cos_angle"][0] = (1000, 950, 850), 1.0
    rows["position"][1:] = rng.uniform(-REGION / 2, REGION / 2, (3, 3))
    rows["radius"][1:] = rng.uniform(0.02, 0.15, 3)
    rows["radiance"][1:] = rng.uniform(0.2, 1, (3, 3)) * 40000
    rows["power"] = rows["diffuse"] = rows["specular"] = 1.0
    rows["shaping_cos"], rows["visible"] = -1.0, 1
    rows["visible"][0] = 0
    return rows


def build(seed: int = 0) -> Scene:
    """The scene, the same for the same seed."""
    rng = np.random.default_rng(seed)
    sizes = rng.permutation(np.geomspace(2000, 20000, MESHES).astype(int))
    scene = Scene()
    scene.prototypes = [bumpy(rng, n, f"/mesh_{k}") for k, n in enumerate(sizes)] + [ball(), box()]
    scene.materials = _materials(rng, MESHES + SMALL)
    scene.textures = _textures(rng)
    scene.lights = _lights(rng)
    scene.dome = sky()
    scene.material_slots = np.arange(MESHES + SMALL, dtype=np.int32)
    count = MESH_INSTANCES + SMALL
    prototype = np.concatenate([np.arange(MESH_INSTANCES) % MESHES, MESHES + np.arange(SMALL) % 2]).astype(np.int32)
    slots = np.concatenate([np.arange(MESH_INSTANCES) % MESHES, MESHES + np.arange(SMALL)]).astype(np.int32)
    scale = np.concatenate([rng.uniform(0.35, 1.35, MESH_INSTANCES), rng.uniform(0.015, 0.15, SMALL)])
    matrices = np.tile(np.eye(4), (count, 1, 1))
    for k in range(count):
        matrices[k, :3, :3] = rotation(rng) * scale[k]
        matrices[k, 3, :3] = rng.uniform(-REGION / 2, REGION / 2)
    scene.instances = Instances(
        tuple(f"/World/object_{k}" for k in range(count)), prototype, matrices, slots, np.ones(count, np.int32)
    )
    scene.touch(*scene.versions)
    return scene


def views(scene: Scene, size: tuple[int, int] = (640, 480)) -> list[CameraView]:
    """A close view of object 0 and a wider one of object 1."""
    centers = scene.instances.local_to_world[:, 3, :3]
    rng = np.random.default_rng(1)
    out = []
    for k, distance in enumerate((0.75, 2.5)):
        # Of some directions the one whose eye is farthest from every object.
        backs = rng.normal(size=(32, 3))
        backs /= np.linalg.norm(backs, axis=1, keepdims=True)
        eyes = centers[k] + distance * backs
        best = np.argmax(np.linalg.norm(eyes[:, None] - centers, axis=2).min(1))
        z = backs[best]
        x = np.cross((0, 0, 1), z)
        x /= np.linalg.norm(x)
        matrix = np.eye(4)
        matrix[:3, :3] = x, np.cross(z, x), z
        matrix[3, :3] = eyes[best]
        out.append(CameraView(f"/World/camera_{k}", *size, matrix, 24.0, 20.955, clipping_range=(0.01, 1e5)))
    return out
