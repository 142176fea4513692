"""Read the collision shapes of gprims: primitives, convex hulls and triangle meshes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from pxr import Usd

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import value, warn_if_varying
from usdsdg_physics.parse.shapes.convex_decomposition import Splitting
from usdsdg_physics.parse.shapes.convex_hulls import MAX_HULL_VERTICES, MIN_THICKNESS, HullCache, is_flat
from usdsdg_physics.scene.records import Shape, ShapeKind, Solid
from usdsdg_physics.scene.rigid_frames import rotation_quat, split_scale
from usdsdg_physics.scene.volume_integrals import VolumeIntegrals, of_primitive

# Rotations of +Z onto the axis of a gprim (row vectors, determinant one).
_Z_TO_AXIS = {
    "X": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], np.float64),
    "Y": np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], np.float64),
    "Z": np.eye(3),
}
# Approximations that keep hollows: of solids they become convex parts, of other colliders but the first the triangles.
_HOLLOW_APPROXIMATIONS = ("convexDecomposition", "sdf", "meshSimplification")
# Those that become the hull of points that are all at one place.
_BOUNDS = ("boundingCube", "boundingSphere")
# Relative difference of scales up to which they are called uniform.
_UNIFORM = 1e-3

# Attributes of gprims that have no surface unless they are positive.
_LENGTHS = ("size", "radius", "radiusTop", "radiusBottom", "height")

_Reader = Callable[[Usd.Prim, np.ndarray, HullCache, bool], Shape | None]


def read_shapes(
    prim: Usd.Prim, frame_from_prim: ArrayLike, hulls: HullCache, *, owned: bool, solid: bool
) -> list[Shape]:
    """Return the collision shapes of a gprim: one, or the convex parts of a mesh; none, with a warning, of other types.

    Args:
        frame_from_prim: row-vector 4x4 from the prim's space [stage units] to the body's or the world's frame [m].
        owned: whether a rigid body owns it, so that it may be no unbounded plane.
        solid: whether a mesh becomes its hull or convex parts, where it would keep its triangles.
    """
    matrix = np.asarray(frame_from_prim, np.float64)
    kind = str(prim.GetTypeName())
    if kind == "Mesh":
        return _mesh(prim, matrix, hulls, solid)
    shape = _primitive(prim, kind, matrix, hulls, owned)
    return [shape] if shape is not None else []


def half_thickness(shape: Shape) -> float:
    """Return half the least of a shape's lengths along its axes [m]; infinity of a surface, which has no inside."""
    if shape.kind in ("plane", "mesh"):
        return np.inf
    if shape.kind in ("sphere", "capsule"):
        return shape.size[0]
    if shape.solid is not None:
        return float((np.ptp(shape.solid.vertices, axis=0) * np.abs(shape.size)).min()) / 2.0
    return min(length for length in shape.size if length > 0.0)


def _primitive(prim: Usd.Prim, kind: str, matrix: np.ndarray, hulls: HullCache, owned: bool) -> Shape | None:
    reader = _PRIMITIVES.get(kind)
    if reader is None:
        warn_once(
            f"{prim.GetPath()} is a {kind or 'prim without a type'} with CollisionAPI, which has no collision shape "
            "here and is ignored. Put the API on a Mesh, Cube, Sphere, Capsule, Cylinder, Cone or Plane."
        )
        return None
    warn_if_varying(prim, *_LENGTHS)
    for name in _LENGTHS:
        length = value(prim, name, None)
        if length is not None and not 0.0 < length < np.inf and kind != "Plane":
            warn_once(f"{prim.GetPath()}: {name} is {length:g}, so it does not collide. Set a positive number.")
            return None
    return reader(prim, matrix, hulls, owned)


def _cube(prim: Usd.Prim, matrix: np.ndarray, hulls: HullCache, owned: bool) -> Shape | None:
    half = float(value(prim, "size", 2.0)) / 2.0
    corners = half * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
    parts = split_scale(matrix)
    if parts is None:
        return _hull(prim, corners, matrix, hulls)
    scale, rotation, position = parts
    return _shape("box", np.abs(scale) * half, rotation, position)


def _sphere(prim: Usd.Prim, matrix: np.ndarray, hulls: HullCache, owned: bool) -> Shape | None:
    radius = float(value(prim, "radius", 1.0))
    parts = split_scale(matrix)
    if parts is not None and _uniform(np.abs(parts[0])):
        scale, rotation, position = parts
        return _shape("sphere", (np.abs(scale).mean() * radius, 0.0, 0.0), rotation, position)
    return _hull(prim, radius * _sphere_points(), matrix, hulls, of_primitive("sphere", (radius, 0.0, 0.0)))


def _axial(kind: ShapeKind, radius_default: float) -> _Reader:
    """Return the reader of a capsule, cylinder or cone."""

    def read(prim: Usd.Prim, matrix: np.ndarray, hulls: HullCache, owned: bool) -> Shape | None:
        radius = float(value(prim, "radius", radius_default))
        half = float(value(prim, "height", 1.0 if kind == "capsule" else 2.0)) / 2.0
        frame_from_z = _frame_from_z(prim, matrix)
        parts = split_scale(frame_from_z)
        if parts is not None:
            scale, rotation, position = parts
            size = np.abs(scale)
            circular = _uniform(size) if kind == "capsule" else _uniform(size[:2])
            if circular:
                return _shape(kind, (size[:2].mean() * radius, size[2] * half, 0.0), rotation, position)
        integrals = of_primitive(kind, (radius, half, 0.0))
        return _hull(prim, _primitive_points(kind, radius, radius, half), frame_from_z, hulls, integrals)

    return read


def _tapered(kind: ShapeKind) -> _Reader:
    """Return the reader of Cylinder_1 or Capsule_1, which have a radius at either end."""

    def read(prim: Usd.Prim, matrix: np.ndarray, hulls: HullCache, owned: bool) -> Shape | None:
        default = 0.5 if kind == "capsule" else 1.0
        bottom, top = (float(value(prim, f"radius{end}", default)) for end in ("Bottom", "Top"))
        half = float(value(prim, "height", 1.0 if kind == "capsule" else 2.0)) / 2.0
        return _hull(prim, _primitive_points(kind, bottom, top, half), _frame_from_z(prim, matrix), hulls)

    return read


def _frame_from_z(prim: Usd.Prim, frame_from_prim: np.ndarray) -> np.ndarray:
    """Return the matrix that takes a shape along +Z to the axis of a gprim, and then into the frame."""
    z_to_axis = np.eye(4)
    z_to_axis[:3, :3] = _Z_TO_AXIS[str(value(prim, "axis", "Z"))]
    return z_to_axis @ frame_from_prim


def _plane(prim: Usd.Prim, matrix: np.ndarray, hulls: HullCache, owned: bool) -> Shape | None:
    if owned:
        warn_once(
            f"{prim.GetPath()} is a Plane under a rigid body; planes are unbounded and only collide as static "
            "colliders, so it is ignored. Use a thin Cube."
        )
        return None
    parts = split_scale(_frame_from_z(prim, matrix))
    if parts is None:
        warn_once(f"{prim.GetPath()} is a sheared or flattened Plane and is ignored as a collider; remove the shear.")
        return None
    scale, rotation, position = parts
    if scale[0] < 0:  # a mirrored plane keeps its normal
        rotation = np.array([-rotation[0], rotation[1], rotation[2]])
        rotation[0] = np.cross(rotation[1], rotation[2])
    return _shape("plane", (0.0, 0.0, 0.0), rotation, position)


def _mesh(prim: Usd.Prim, matrix: np.ndarray, hulls: HullCache, solid: bool) -> list[Shape]:
    mesh = hulls.triangles.read(prim)
    points, triangles = mesh.points, mesh.triangles
    warn_if_varying(prim, "points")
    if not len(points):
        warn_once(f"{prim.GetPath()} has CollisionAPI but no points, or only holes, so it does not collide.")
        return []
    approximation = str(value(prim, "physics:approximation", "none"))
    if approximation == "boundingCube" and np.ptp(points, axis=0).any():
        shape = _bounding_box(prim, points, matrix, hulls)
    elif approximation == "boundingSphere" and np.ptp(points, axis=0).any():
        shape = _bounding_sphere(points, matrix)
    elif approximation == "convexDecomposition" or (solid and approximation in _HOLLOW_APPROXIMATIONS):
        if not len(triangles) or not is_flat(points):
            return _parts(prim, points, triangles, matrix, hulls, approximation)
        shape = _flat(prim, points, triangles, matrix, hulls, solid)
    elif approximation not in (*_HOLLOW_APPROXIMATIONS, *_BOUNDS, "none", "convexHull"):
        warn_once(f"{prim.GetPath()}: unknown collision approximation {approximation!r}; a convex hull is used.")
        shape = _hull(prim, points, matrix, hulls, points_key=mesh.points_key)
    elif approximation not in ("convexHull", *_BOUNDS) and not solid and len(triangles):
        shape = _solid_shape("mesh", prim, points, triangles, matrix, hulls)
    else:
        shape = _hull(prim, points, matrix, hulls, points_key=mesh.points_key)
        if approximation == "none" and solid and len(triangles) and shape is not None:
            hulls.note_filled(points, triangles, str(prim.GetPath()))
    return [shape] if shape is not None else []


def _flat(
    prim: Usd.Prim, points: np.ndarray, triangles: np.ndarray, matrix: np.ndarray, hulls: HullCache, solid: bool
) -> Shape | None:
    """Return the triangles of a flat mesh, which have no thickness, or its hull, which names the one that it gets.

    Convex parts would be a hundredth of its size thick.
    """
    if solid:
        return _hull(prim, points, matrix, hulls)
    return _solid_shape("mesh", prim, points, triangles, matrix, hulls)


def _parts(
    prim: Usd.Prim,
    points: np.ndarray,
    triangles: np.ndarray,
    matrix: np.ndarray,
    hulls: HullCache,
    approximation: str,
) -> list[Shape]:
    """Return the convex parts of a mesh, its hull where it cannot be split."""
    if approximation != "convexDecomposition":
        warn_once(
            f"{prim.GetPath()}: the collision approximation {approximation!r} of a rigid body becomes convex parts, up "
            "to a few percent of its size beside its surface. Use 'convexDecomposition' to choose how many.",
            key=f"convex parts instead of {approximation}",
        )
    splitting = Splitting(
        max_parts=int(value(prim, "physxConvexDecompositionCollision:maxConvexHulls", 32)),
        max_vertices=int(value(prim, "physxConvexDecompositionCollision:hullVertexLimit", MAX_HULL_VERTICES)),
        error=float(value(prim, "physxConvexDecompositionCollision:errorPercentage", 10.0)),
    )
    solids = hulls.parts(points, triangles, splitting, prim_path=str(prim.GetPath())) if len(triangles) else []
    parts = split_scale(matrix)
    if not solids or parts is None or abs(np.linalg.det(matrix[:3, :3])) < 1e-30:
        shape = _hull(prim, points, matrix, hulls)
        return [shape] if shape is not None else []
    scale, rotation, position = parts
    return [_shape("hull", scale, rotation, position, solid) for solid in solids]


def _bounding_box(prim: Usd.Prim, points: np.ndarray, matrix: np.ndarray, hulls: HullCache) -> Shape | None:
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    parts = split_scale(matrix)
    if parts is None:
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        return _hull(prim, corners, matrix, hulls)
    scale, rotation, _ = parts
    half = (high - low) / 2.0 * np.abs(scale)
    if (half < MIN_THICKNESS * half.max()).any():
        half = np.maximum(half, MIN_THICKNESS * half.max())
        warn_once(
            f"{prim.GetPath()} is flat, so its bounding box has no volume; the collider is made 0.1% of its size "
            "thick. Model it with a thickness to choose another."
        )
    middle = np.append((low + high) / 2.0, 1.0) @ matrix
    return _shape("box", half, rotation, middle[:3])


def _bounding_sphere(points: np.ndarray, matrix: np.ndarray) -> Shape:
    placed = points.astype(np.float64) @ matrix[:3, :3] + matrix[3, :3]
    middle = (placed.min(axis=0) + placed.max(axis=0)) / 2.0
    radius = float(np.linalg.norm(placed - middle, axis=1).max())
    return _shape("sphere", (radius, 0.0, 0.0), np.eye(3), middle)


def _hull(
    prim: Usd.Prim,
    points: np.ndarray,
    matrix: np.ndarray,
    hulls: HullCache,
    integrals: VolumeIntegrals | None = None,
    *,
    points_key: bytes | None = None,
) -> Shape | None:
    """Return the hull of points; with `integrals` it has the mass of the round shape that it stands for.

    `points_key` is of `MeshTriangles`.
    """
    return _solid_shape("hull", prim, points, None, matrix, hulls, integrals, points_key=points_key)


def _solid_shape(
    kind: ShapeKind,
    prim: Usd.Prim,
    points: np.ndarray,
    triangles: np.ndarray | None,
    matrix: np.ndarray,
    hulls: HullCache,
    integrals: VolumeIntegrals | None = None,
    *,
    points_key: bytes | None = None,
) -> Shape | None:
    """Return a hull or mesh whose solid all prims with these points share; shear is baked into its points."""
    if abs(np.linalg.det(matrix[:3, :3])) < 1e-30:
        warn_once(f"{prim.GetPath()} has a scale of zero and does not collide; give it a scale above zero.")
        return None
    parts = split_scale(matrix)
    if parts is None:
        points, points_key = points.astype(np.float64) @ matrix[:3, :3], None
        if triangles is not None and np.linalg.det(matrix[:3, :3]) < 0:
            triangles = triangles[:, ::-1]
        integrals = integrals.mapped(matrix[:3, :3]) if integrals else None
        parts = np.ones(3), np.eye(3), matrix[3, :3]
    scale, rotation, position = parts
    try:
        path = str(prim.GetPath())
        if triangles is None:
            solid = hulls.hull(points, prim_path=path, key=points_key)
        else:
            solid = hulls.mesh(points, triangles)
    except ValueError as reason:
        warn_once(f"{prim.GetPath()} does not collide: {reason}. Repair its points.")
        return None
    if integrals is not None:
        solid = replace(solid, key=f"{solid.key} round", **integrals._asdict())
    return _shape(kind, scale, rotation, position, solid)


def _shape(
    kind: ShapeKind, size: ArrayLike, rotation: np.ndarray, position: ArrayLike, solid: Solid | None = None
) -> Shape:
    x, y, z = (float(v) for v in np.asarray(size))
    px, py, pz = (float(v) for v in np.asarray(position))
    return Shape(kind, (x, y, z), (px, py, pz), rotation_quat(rotation), solid)


def _uniform(scale: np.ndarray) -> bool:
    return bool(scale.max() - scale.min() <= _UNIFORM * scale.max())


def _sphere_points() -> np.ndarray:
    """Return 62 points on the unit sphere, poles included: fewer than a hull may have."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, 7)[1:-1]
    longitude = np.arange(12) * np.pi / 6
    rings = [
        np.stack([np.cos(a) * np.cos(longitude), np.cos(a) * np.sin(longitude), np.full(12, np.sin(a))], 1)
        for a in latitude
    ]
    return np.concatenate([*rings, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])


def _primitive_points(kind: ShapeKind, bottom: float, top: float, half: float) -> np.ndarray:
    """Return points along Z whose hull is the solid; a capsule's caps are half spheres."""
    if kind == "capsule":
        ball = _sphere_points()
        lower = ball[ball[:, 2] <= 1e-9] * bottom - (0.0, 0.0, half)
        upper = ball[ball[:, 2] >= -1e-9] * top + (0.0, 0.0, half)
        return np.concatenate([lower, upper])
    angle = np.arange(30) * np.pi / 15
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(30)], 1)
    lower = ring * bottom - (0.0, 0.0, half)
    if kind == "cone":
        return np.concatenate([lower, [[0.0, 0.0, half]]])
    return np.concatenate([lower, ring * top + (0.0, 0.0, half)])


_PRIMITIVES = {
    "Cube": _cube,
    "Sphere": _sphere,
    "Capsule": _axial("capsule", 0.5),
    "Cylinder": _axial("cylinder", 1.0),
    "Cone": _axial("cone", 1.0),
    "Capsule_1": _tapered("capsule"),
    "Cylinder_1": _tapered("cylinder"),
    "Plane": _plane,
}
