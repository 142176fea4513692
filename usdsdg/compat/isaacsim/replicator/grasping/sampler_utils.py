"""`isaacsim.replicator.grasping.sampler_utils`: antipodal grasps of a mesh.

A grasp is a pose of the gripper: two points of the surface, opposite along the normal of one of them and no farther
apart than the gripper opens, lie on its closing axis, and its origin is at a standoff behind the middle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pxr import Gf, UsdGeom

from usdsdg.errors import ArgumentError, BadPrim, counted
from usdsdg.graph.sampling import generator, get_global_seed
from usdsdg.stage.poses.transforms import local_to_world

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]

# The directions that the configuration gives in the gripper's frame.
_AXES = ("gripper_approach_direction", "grasp_align_axis", "orientation_sample_axis")


def transforms_to_poses_wxyz(transforms: Sequence[Array]) -> list[list[float]]:
    """Return [x, y, z, qw, qx, qy, qz] of column-vector 4x4 matrices."""
    return [[*location, quat.GetReal(), *quat.GetImaginary()] for location, quat in zip(*_as_gf(transforms))]


def transforms_to_vec3d_quatd(transforms: Sequence[Array]) -> tuple[list[Gf.Vec3d], list[Gf.Quatd]]:
    """Return translations and rotations of column-vector 4x4 matrices."""
    return _as_gf(transforms)


def usd_mesh_to_trimesh(usd_mesh: UsdGeom.Mesh, apply_scale: bool = True, verbose: bool = False) -> trimesh.Trimesh:
    """Return a mesh with its faces as fans of triangles; with `apply_scale`, scaled as it is in the world.

    Raises:
        BadPrim: (a ValueError) it has no points or faces.
    """
    import trimesh

    points = np.array(usd_mesh.GetPointsAttr().Get() or [], np.float64).reshape(-1, 3)
    counts = np.array(usd_mesh.GetFaceVertexCountsAttr().Get() or [], np.int64)
    indices = np.array(usd_mesh.GetFaceVertexIndicesAttr().Get() or [], np.int64)
    if not len(points) or not len(counts):
        raise BadPrim(f"{usd_mesh.GetPath()} has no points or no faces, so there is nothing to grasp")
    if apply_scale:
        points *= np.array(Gf.Transform(local_to_world(usd_mesh.GetPrim())).GetScale())
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    faces = [
        (indices[start], indices[start + corner], indices[start + corner + 1])
        for start, count in zip(first, counts)
        for corner in range(1, count - 1)
    ]
    triangles = np.array(faces, np.int64)
    if str(usd_mesh.GetOrientationAttr().Get()) == str(UsdGeom.Tokens.leftHanded):
        triangles = triangles[:, ::-1]
    if verbose:
        print(f"{usd_mesh.GetPath()}: {counted(len(counts), 'face')}, {counted(len(triangles), 'triangle')}")
    return trimesh.Trimesh(points, triangles, process=False)


def sample_antipodal(object_mesh: trimesh.Trimesh, **config: Any) -> list[Array]:
    """Return column-vector 4x4 poses of the gripper in the frame of the mesh.

    Args:
        config: num_candidates (100), num_orientations (1) about each grasp axis, gripper_maximum_aperture (0.08),
            gripper_standoff_fingertips (0.1), gripper_approach_direction (0, 0, 1), grasp_align_axis (0, 1, 0) and
            orientation_sample_axis (0, 1, 0) as unit vectors in the gripper's frame, lateral_sigma (0) of the middle
            along the axis, random_seed (None: one from the global seed), verbose. Lengths are stage units.

    Raises:
        ArgumentError: (a ValueError) a number is not positive, or a direction is no unit vector.
    """
    candidates, turns = int(config.get("num_candidates", 100)), int(config.get("num_orientations", 1))
    aperture = float(config.get("gripper_maximum_aperture", 0.08))
    for name, number in (("num_candidates", candidates), ("num_orientations", turns), ("aperture", aperture)):
        if not number > 0:
            raise ArgumentError(f"sample_antipodal: {name} is {number}; expected a positive number")
    approach, align, turn_axis = _axes(config)
    standoff = _translation(-float(config.get("gripper_standoff_fingertips", 0.1)) * approach)

    samples = max(1, candidates // turns)
    draws = _draws(config.get("random_seed"))
    points, faces = _surface_points(object_mesh, samples, draws)
    opposite = _opposite_points(object_mesh, points, -object_mesh.face_normals[faces], aperture)
    grasps = [
        (_middle(point, other, float(config.get("lateral_sigma", 0.0)), draws), other - point)
        for point, other in zip(points, opposite)
        if np.isfinite(other).all()
    ]
    poses = []
    for middle, along in grasps:
        aligned = _translation(middle) @ _aligned(align, along)
        for angle in np.linspace(-np.pi, np.pi, turns, endpoint=False):
            poses.append(aligned @ _rotation(turn_axis, angle) @ standoff)
    if config.get("verbose"):
        print(f"antipodal sampler: {counted(len(poses), 'pose')} from {len(grasps)} of {counted(samples, 'point')}")
    return poses


def generate_grasp_poses(config: Mapping[str, Any]) -> tuple[list[Gf.Vec3d], list[Gf.Quatd]]:
    """Return positions and rotations of `sample_antipodal` for config["mesh_prim"], a UsdGeom.Mesh.

    Raises:
        ArgumentError, BadPrim: (ValueErrors) the configuration or the mesh cannot be sampled.
    """
    mesh = config.get("mesh_prim")
    if not isinstance(mesh, UsdGeom.Mesh):
        raise BadPrim(f"generate_grasp_poses: mesh_prim is {mesh!r}; expected a UsdGeom.Mesh")
    sampled = usd_mesh_to_trimesh(mesh, bool(config.get("apply_scale", True)), bool(config.get("verbose", False)))
    return _as_gf(sample_antipodal(sampled, **{key: each for key, each in config.items() if key != "mesh_prim"}))


def _axes(config: Mapping[str, Any]) -> list[Array]:
    defaults = {"gripper_approach_direction": (0, 0, 1), "grasp_align_axis": (0, 1, 0)}
    found = []
    for name in _AXES:
        axis = np.asarray(config.get(name, defaults.get(name, (0, 1, 0))), np.float64)
        if axis.shape != (3,) or not np.isclose(np.linalg.norm(axis), 1.0):
            raise ArgumentError(f"sample_antipodal: {name} is {axis.tolist()}; expected a unit vector")
        found.append(axis)
    return found


def _draws(seed: int | None) -> np.random.RandomState:
    """Return random numbers as `numpy.random.seed(seed)` starts them; None: of the global seed."""
    if seed is None:
        seed = int(generator(get_global_seed(), "sample_antipodal", 0).integers(2**32))
    return np.random.RandomState(seed)


def _surface_points(mesh: trimesh.Trimesh, count: int, draws: np.random.RandomState) -> tuple[Array, NDArray[np.int64]]:
    """Return points (count, 3) that are uniform on the surface, and the triangle of each.

    With the draws of a seed in the order in which trimesh takes them from NumPy's global generator.
    """
    areas = np.cumsum(mesh.area_faces)
    faces = np.searchsorted(areas, draws.random_sample(count) * areas[-1])
    weights = draws.random_sample((count, 2))
    outside = weights.sum(axis=1) > 1.0
    weights[outside] = 1.0 - weights[outside]
    corners = mesh.triangles[faces]
    edges = corners[:, 1:] - corners[:, :1]
    return corners[:, 0] + np.einsum("ni,nij->nj", weights, edges), faces


def _opposite_points(mesh: trimesh.Trimesh, points: Array, directions: Array, aperture: float) -> Array:
    """Return for each point (N, 3) the farthest hit of its ray within `aperture`; NaN where there is none."""
    distances = np.array([_farthest(mesh.triangles, *ray, aperture) for ray in zip(points, directions)])
    return points + distances[:, None] * directions


def _farthest(triangles: Array, origin: Array, direction: Array, limit: float) -> float:
    """Return the distance of the farthest triangle (T, 3, 3) along a ray up to `limit`, else NaN.

    Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).
    """
    # The ray starts on the surface, which is no hit.
    least = 1e-6 * float(np.ptp(triangles))
    a, b, c = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    cross = np.cross(direction, c)
    determinant = np.einsum("ij,ij->i", b, cross)
    with np.errstate(divide="ignore", invalid="ignore"):
        start = origin - a
        u = np.einsum("ij,ij->i", start, cross) / determinant
        normal = np.cross(start, b)
        v = normal @ direction / determinant
        distance = np.einsum("ij,ij->i", c, normal) / determinant
        hit = (np.abs(determinant) > 1e-14) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    hit &= (distance > least) & (distance <= limit)
    return float(distance[hit].max()) if hit.any() else np.nan


def _middle(point: Array, other: Array, sigma: float, draws: np.random.RandomState) -> Array:
    """Return the middle between two points, or a normal draw about it on the line between them."""
    ratio, spread = 0.5, sigma / float(np.linalg.norm(other - point))
    if spread > 0.0:
        import scipy.stats

        ratio = scipy.stats.truncnorm.rvs(-0.5 / spread, 0.5 / spread, loc=0.5, scale=spread, random_state=draws)
    return point + ratio * (other - point)


def _aligned(axis: Array, along: Array) -> Array:
    """Return the rotation that turns one direction to another; trimesh chooses the rotation about it."""
    import trimesh

    return np.asarray(trimesh.geometry.align_vectors(axis, along / np.linalg.norm(along)))


def _translation(vector: Array) -> Array:
    matrix = np.eye(4)
    matrix[:3, 3] = vector
    return matrix


def _rotation(axis: Array, angle: float) -> Array:
    import trimesh

    return trimesh.transformations.rotation_matrix(angle, axis)


def _as_gf(transforms: Sequence[ArrayLike]) -> tuple[list[Gf.Vec3d], list[Gf.Quatd]]:
    # Gf's matrices multiply row vectors.
    matrices = [Gf.Matrix4d(np.asarray(transform, np.float64).T.tolist()) for transform in transforms]
    return [each.ExtractTranslation() for each in matrices], [each.ExtractRotationQuat() for each in matrices]
