"""Scenes built without a stage, for tests of the renderer: prototypes, materials, lights, cameras."""

from __future__ import annotations

import numpy as np

from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg_render.scene.scene import (
    LIGHT,
    MATERIAL,
    NO_EMISSION_PROFILE,
    NO_LINKS,
    NO_TEXTURE,
    Dome,
    Instances,
    Prototype,
    Scene,
)
from usdsdg_render.scene.structs import LIGHT_DISTANT, LIGHT_SPHERE


def prototype(points, triangles, *, normals=None, uvs=None, slots=None, name="/mesh") -> Prototype:
    """A prototype from (V, 3) points and (T, 3) triangles; flat normals and zero UVs unless given per corner."""
    points = np.ascontiguousarray(points, np.float32)
    triangles = np.ascontiguousarray(triangles, np.int32)
    count = len(triangles)
    if normals is None:
        corners = points[triangles].astype(np.float64)
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-30)
        normals = np.repeat(flat[:, None], 3, 1)
    return Prototype(
        name=name,
        points=points,
        triangles=triangles,
        normals=np.ascontiguousarray(normals, np.float32),
        uvs=np.zeros((count, 3, 2), np.float32) if uvs is None else np.ascontiguousarray(uvs, np.float32),
        triangle_slots=np.zeros(count, np.int32) if slots is None else np.asarray(slots, np.int32),
        triangle_faces=np.arange(count, dtype=np.int32),
    )


def square(*, name="/square") -> Prototype:
    """The square [-1, 1]^2 in the plane z = 0, seen from +z; u grows with x and v with y."""
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    uvs = (points[:, :2] + 1) / 2
    return prototype(points, triangles, uvs=uvs[triangles], name=name)


def cube(*, name="/cube") -> Prototype:
    """The closed cube [-1, 1]^3."""
    points = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32)
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    triangles = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    return prototype(points, triangles, name=name)


def sphere(*, rings: int = 32, smooth: bool = True, name="/sphere") -> Prototype:
    """A closed unit sphere, poles on z."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = np.arange(2 * rings) * np.pi / rings
    ring = np.stack([np.cos(phi), np.sin(phi)], -1)
    body = np.concatenate([np.column_stack([np.sin(t) * ring, np.full(2 * rings, np.cos(t))]) for t in theta])
    points = np.concatenate([[[0, 0, 1]], body, [[0, 0, -1]]]).astype(np.float32)
    n, last = 2 * rings, len(points) - 1
    i = np.arange(n)
    j = (i + 1) % n
    caps = [np.column_stack([0 * i, 1 + i, 1 + j]), np.column_stack([0 * i + last, last - n + j, last - n + i])]
    sides = []
    for r in range(rings - 2):
        a, b = 1 + r * n, 1 + (r + 1) * n
        sides += [np.column_stack([a + i, b + i, b + j]), np.column_stack([a + i, b + j, a + j])]
    triangles = np.concatenate([*caps, *sides])
    normals = points[triangles] if smooth else None
    return prototype(points, triangles, normals=normals, name=name)


def material(**values) -> np.ndarray:
    """One row of MATERIAL: by default rough white plastic without textures."""
    row = np.zeros(1, MATERIAL)
    for name in MATERIAL.names or ():
        if name.endswith("_texture"):
            row[name] = NO_TEXTURE
    defaults = dict(base_color=1.0, roughness=1.0, specular=0.04, opacity=1.0, ior=1.5, normal_scale=1.0, coat_f0=0.04)
    for name, value in {**defaults, **values}.items():
        row[name] = value
    return row


def light(kind: int, **values) -> np.ndarray:
    """One row of LIGHT: by default white, of radiance 1, visible, with the world axes."""
    row = np.zeros(1, LIGHT)
    row["kind"] = kind
    row["x_axis"], row["y_axis"], row["z_axis"] = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    row["emission_profile"], row["links"] = NO_EMISSION_PROFILE, NO_LINKS
    defaults = dict(radiance=1.0, radius=1.0, aspect=1.0, width=1.0, height=1.0, power=1.0, shaping_cos=-1.0, visible=1)
    for name, value in {**defaults, "diffuse": 1.0, "specular": 1.0, **values}.items():
        row[name] = value
    return row


def distant_light(irradiance: float = 1.0, direction=(0.0, 0.0, -1.0)) -> np.ndarray:
    """A delta light that shines along `direction`: `irradiance` lux on a surface that faces it."""
    z = -np.asarray(direction, float) / np.linalg.norm(direction)
    return light(LIGHT_DISTANT, radiance=irradiance, cos_angle=1.0, z_axis=z)


def sphere_light(radiance: float, position, radius: float, **values) -> np.ndarray:
    return light(LIGHT_SPHERE, radiance=radiance, position=position, radius=radius, **values)


def white_dome(radiance: float = 1.0) -> Dome:
    return Dome(np.full((4, 8, 3), radiance, np.float32), np.eye(3, dtype=np.float32))


def moved(translation=(0, 0, 0), *, scale=1.0, rotation=None) -> np.ndarray:
    """Row-vector local-to-world matrix: scale, then the 3x3 rotation (columns = axes), then translation."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(np.broadcast_to(np.asarray(scale, float), 3))
    if rotation is not None:
        matrix[:3, :3] = matrix[:3, :3] @ np.asarray(rotation).T
    matrix[3, :3] = translation
    return matrix


def scene_of(placed, *, materials=None, textures=(), lights=(), dome=None) -> Scene:
    """A scene of (prototype, local_to_world, first material row) triples; prototypes are shared by identity."""
    scene = Scene()
    scene.materials = np.concatenate(materials) if materials else material()
    scene.textures = list(textures)
    scene.lights = np.concatenate(lights) if len(lights) else np.zeros(0, LIGHT)
    scene.dome = dome
    rows, slots = [], []
    for each, matrix, first in placed:
        if not any(each is known for known in scene.prototypes):
            scene.prototypes.append(each)
        index = next(k for k, known in enumerate(scene.prototypes) if known is each)
        rows.append((index, matrix, len(slots)))
        slots += range(first, first + int(each.triangle_slots.max(initial=0)) + 1)
    scene.material_slots = np.array(slots, np.int32)
    scene.instances = Instances(
        paths=tuple(f"/World/object_{k}" for k in range(len(rows))),
        prototype=np.array([r[0] for r in rows], np.int32),
        local_to_world=np.array([r[1] for r in rows], float).reshape(-1, 4, 4),
        slot_offset=np.array([r[2] for r in rows], np.int32),
        casts_shadow=np.ones(len(rows), np.int32),
    )
    scene.touch(*scene.versions)
    return scene


def view_from(eye, target=(0.0, 0.0, 0.0), *, size=(32, 24), up=(0.0, 0.0, 1.0), **values) -> CameraView:
    """A 50 mm-like camera (horizontal field of view 45 degrees unless `focal_length` says otherwise) in meters."""
    eye, target = np.asarray(eye, float), np.asarray(target, float)
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross(up, back)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = right, np.cross(back, right), back
    matrix[3, :3] = eye
    defaults = dict(focal_length=10.0 / np.tan(np.radians(22.5)), horizontal_aperture=20.0)
    defaults["clipping_range"] = (0.001, 10000.0)
    return CameraView("/World/Camera", size[0], size[1], matrix, **{**defaults, **values})
