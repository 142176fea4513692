"""Tessellate UsdGeom's analytic gprims: triangles whose vertices lie on the analytic surface.

Shapes are tessellated once per type and parameters; sizes are parameters, scale belongs to the instance matrix.
"""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg_render.usd.authored_values import as_floats
from usdsdg_render.usd.prim_kinds import SHAPE_PARAMETERS

SEGMENTS = 64  # around the axis
RINGS = 32  # from pole to pole
LARGEST = 1e15  # [stage units]; products of larger sizes overflow float32


class Surface(NamedTuple):
    """Triangles with faceVarying normals and UVs, as in `scene.Prototype`."""

    points: np.ndarray  # (V, 3) float32
    triangles: np.ndarray  # (T, 3) int32
    normals: np.ndarray  # (T, 3, 3) float32
    uvs: np.ndarray  # (T, 3, 2) float32


class Ring(NamedTuple):
    """One circle of a surface of revolution about z; a point where the radius is 0."""

    radius: float
    z: float
    normal: tuple[float, float]  # (outward, along z)
    v: float


ShapeKey = tuple[str, str, tuple[float, ...]]


def shape_key(prim: Usd.Prim, time: Usd.TimeCode) -> ShapeKey | None:
    """Return (type, axis, sizes), which determine the triangles; None (with a warning) if there is no surface."""
    kind = str(prim.GetTypeName())
    values = []
    for name, fallback in SHAPE_PARAMETERS[kind].items():
        value = prim.GetAttribute(name).Get(time)
        values.append(fallback if value is None else (as_floats(value, 1) or (math.nan,))[0])
    axis_attribute = prim.GetAttribute("axis")
    axis = str(axis_attribute.Get() or "Z") if axis_attribute else "Z"
    if not _has_surface(kind, values) or axis not in ("X", "Y", "Z"):
        names = ", ".join(f"{name} = {value}" for name, value in zip(SHAPE_PARAMETERS[kind], values))
        errors.warn_once(
            f"{prim.GetPath()}: a {kind} with {names}, axis = {axis} has no surface and is not drawn. "
            f"Author positive sizes up to {LARGEST:.0e}, and X, Y or Z as the axis."
        )
        return None
    return kind, axis, tuple(values)


def _has_surface(kind: str, values: list[float]) -> bool:
    if not all(0.0 <= value <= LARGEST for value in values):  # also False for NaN
        return False
    if kind == "Capsule":  # a capsule without height is a sphere
        return values[0] > 0.0
    if kind in ("Capsule_1", "Cylinder_1"):  # one end may be a point
        return max(values[:2]) > 0.0 and (kind == "Capsule_1" or values[2] > 0.0)
    return all(value > 0.0 for value in values)


def tessellate(key: ShapeKey) -> Surface:
    """Tessellate the shape of a key."""
    kind, axis, values = key
    if kind == "Plane":
        return _plane(axis, *values)
    surface = _BUILDERS[kind](*values)
    shift = {"Z": 0, "X": 1, "Y": 2}[axis]  # a cyclic permutation of x, y, z is a rotation and keeps the winding
    if not shift:
        return surface
    return surface._replace(
        points=np.roll(surface.points, shift, axis=-1), normals=np.roll(surface.normals, shift, axis=-1)
    )


def _cube(size: float) -> Surface:
    half = size / 2.0
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32)
    # Vertices of each face, counter-clockwise seen from outside, from the lower left as seen with z up.
    faces = np.array([[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6], [2, 3, 1, 0]], np.int32)
    normals = np.array([[0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 1], [0, 0, -1]], np.float32)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    halves = np.array([[0, 1, 2], [0, 2, 3]])
    return Surface(
        points=signs * np.float32(half),
        triangles=faces[:, halves].reshape(-1, 3).astype(np.int32),
        normals=np.broadcast_to(normals[:, None, None, :], (6, 2, 3, 3)).reshape(-1, 3, 3).copy(),
        uvs=np.broadcast_to(square[halves], (6, 2, 3, 2)).reshape(-1, 3, 2).copy(),
    )


def _plane(axis: str, width: float, length: float) -> Surface:
    """Tessellate a plane. UsdGeomPlane defines the axes of width and length; the normal is +axis."""
    along_width, along_length, normal = {"X": (2, 1, 0), "Y": (0, 2, 1), "Z": (0, 1, 2)}[axis]
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    points = np.zeros((4, 3), np.float32)
    points[:, along_width] = (square[:, 0] - 0.5) * width
    points[:, along_length] = (square[:, 1] - 0.5) * length
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    if axis != "Z":  # (width, length, axis) is a left-handed frame there
        triangles = triangles[:, ::-1].copy()
    normals = np.zeros((2, 3, 3), np.float32)
    normals[..., normal] = 1.0
    return Surface(points, triangles, normals, square[triangles])


def _sphere(radius: float) -> Surface:
    return _revolve([_cap_rings(radius, 0.0, -math.pi / 2, math.pi / 2, RINGS, 0.0, 1.0)])


def _cylinder(radius: float, height: float) -> Surface:
    return _frustum(radius, radius, height)


def _cone(radius: float, height: float) -> Surface:
    return _frustum(radius, 0.0, height)


def _frustum(bottom: float, top: float, height: float) -> Surface:
    low, high = -height / 2, height / 2
    slant = math.hypot(height, bottom - top)
    normal = (height / slant, (bottom - top) / slant)
    profiles = [[Ring(bottom, low, normal, 0.0), Ring(top, high, normal, 1.0)]]
    if bottom > 0.0:
        profiles.insert(0, [Ring(0.0, low, (0.0, -1.0), 0.0), Ring(bottom, low, (0.0, -1.0), 1.0)])
    if top > 0.0:
        profiles.append([Ring(top, high, (0.0, 1.0), 1.0), Ring(0.0, high, (0.0, 1.0), 0.0)])
    return _revolve(profiles)


def _capsule(radius: float, height: float) -> Surface:
    return _tapered_capsule(radius, radius, height)


def _tapered_capsule(bottom: float, top: float, height: float) -> Surface:
    """Tessellate a frustum between two radii with a spherical cap tangent to it at each end.

    UsdGeomCapsule_1 computes its extent that way: the sphere of a cap is larger than the ring where it joins.
    """
    if height == 0.0:
        return _sphere(max(bottom, top))
    slope = (bottom - top) / height
    tangent, widening = math.atan(slope), math.hypot(1.0, slope)
    # (center, radius) of the spheres
    low, high = (-height / 2 - bottom * slope, bottom * widening), (height / 2 - top * slope, top * widening)
    arcs = low[1] * (tangent + math.pi / 2), height * widening, high[1] * (math.pi / 2 - tangent)
    v_low, v_high = arcs[0] / sum(arcs), (arcs[0] + arcs[1]) / sum(arcs)
    half = RINGS // 2
    lower = _cap_rings(low[1], low[0], -math.pi / 2, tangent, half, 0.0, v_low)
    upper = _cap_rings(high[1], high[0], tangent, math.pi / 2, half, v_high, 1.0)
    return _revolve([lower + upper])


def _cap_rings(
    radius: float, center: float, start: float, end: float, count: int, v_start: float, v_end: float
) -> list[Ring]:
    """Rings of a sphere at latitudes `start` to `end` [radians]; exactly a point at the poles."""
    if radius == 0.0:
        return [Ring(0.0, center, (math.cos(start), math.sin(start)), v_start)]
    rings = []
    for k in range(count + 1):
        fraction = k / count
        latitude = start + (end - start) * fraction
        normal = (math.cos(latitude), math.sin(latitude))
        if abs(abs(latitude) - math.pi / 2) < 1e-9:
            normal = (0.0, math.copysign(1.0, latitude))
        rings.append(
            Ring(radius * normal[0], center + radius * normal[1], normal, v_start + (v_end - v_start) * fraction)
        )
    return rings


def _revolve(profiles: list[list[Ring]]) -> Surface:
    """Revolve profiles about z, bottom to top. Rings that coincide between profiles share their points."""
    points: list[np.ndarray] = []
    first_of: dict[tuple[float, float], int] = {}
    bands = []
    for profile in profiles:
        for ring in profile:
            if (ring.radius, ring.z) not in first_of:
                first_of[ring.radius, ring.z] = sum(len(block) for block in points)
                points.append(_circle(ring))
        bands += [_band(a, b, first_of[a.radius, a.z], first_of[b.radius, b.z]) for a, b in pairwise(profile)]
    return Surface(
        np.concatenate(points).astype(np.float32),
        np.concatenate([band[0] for band in bands]).astype(np.int32),
        np.concatenate([band[1] for band in bands]).astype(np.float32),
        np.concatenate([band[2] for band in bands]).astype(np.float32),
    )


def _angles() -> np.ndarray:
    return np.arange(SEGMENTS) * (2.0 * math.pi / SEGMENTS)


def _circle(ring: Ring) -> np.ndarray:
    if ring.radius == 0.0:
        return np.array([[0.0, 0.0, ring.z]])
    angle = _angles()
    z = np.full(SEGMENTS, ring.z)
    return np.stack([ring.radius * np.cos(angle), ring.radius * np.sin(angle), z], axis=-1)


def _band(lower: Ring, upper: Ring, lower_first: int, upper_first: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles between two rings with their faceVarying normals and UVs."""
    here = np.arange(SEGMENTS)
    after = (here + 1) % SEGMENTS
    # Vertices of the quads: lower here, lower after, upper after, upper here.
    point = np.stack([lower_first + here, lower_first + after, upper_first + after, upper_first + here], axis=-1)
    column = np.stack([here, here + 1.0, here + 1.0, here * 1.0], axis=-1)
    if lower.radius == 0.0:
        point[:, :2] = lower_first
        column[:, :2] = here[:, None] + 0.5
    if upper.radius == 0.0:
        point[:, 2:] = upper_first
        column[:, 2:] = here[:, None] + 0.5
    ring_normal = np.array([lower.normal, lower.normal, upper.normal, upper.normal])
    ring_v = np.array([lower.v, lower.v, upper.v, upper.v])
    angle = column * (2.0 * math.pi / SEGMENTS)
    outward = np.broadcast_to(ring_normal[:, 0], angle.shape)
    along = np.broadcast_to(ring_normal[:, 1], angle.shape)
    normal = np.stack([outward * np.cos(angle), outward * np.sin(angle), along], axis=-1)
    if lower.z == upper.z:  # a flat end: planar projection along the axis
        spread = np.array([lower.radius, lower.radius, upper.radius, upper.radius]) / max(lower.radius, upper.radius)
        side = 0.5 * spread * lower.normal[1]
        uv = np.stack([0.5 + side * np.cos(angle), 0.5 + 0.5 * spread * np.sin(angle)], axis=-1)
    else:
        uv = np.stack([column / SEGMENTS, np.broadcast_to(ring_v, column.shape)], axis=-1)
    halves = [[0, 1, 2], [0, 2, 3]]
    if lower.radius == 0.0:
        halves = [[0, 2, 3]]
    elif upper.radius == 0.0:
        halves = [[0, 1, 2]]
    triangles = np.array(halves)
    return (
        point[:, triangles].reshape(-1, 3),
        normal[:, triangles].reshape(-1, 3, 3),
        uv[:, triangles].reshape(-1, 3, 2),
    )


_BUILDERS: dict[str, Callable[..., Surface]] = {
    "Cube": _cube,
    "Sphere": _sphere,
    "Cylinder": _cylinder,
    "Cylinder_1": _frustum,
    "Cone": _cone,
    "Capsule": _capsule,
    "Capsule_1": _tapered_capsule,
}
