"""Rotations that make cameras, lights and other prims look at a point.

`look_at_rotations` is the computation, for whole batches; `look_at_quaternions`, `author_look_at` and `author_look_ats`
apply it to prims. `look_at_matrix` is the plain camera matrix, which refuses a view along the up direction.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pxr import Gf, Usd, UsdGeom

from usdsdg.errors import DegenerateFrame
from usdsdg.stage.cameras.stereo_pairs import stereo_pair
from usdsdg.stage.poses.pose_batch import Rotations, author_poses
from usdsdg.stage.poses.rotations import decompose, euler_xyz_from_quat, matrix_from_quat, quat_from_matrix
from usdsdg.stage.poses.transforms import (
    as_array,
    local_matrices,
    parent_in,
    parents_to_world,
    up_axis,
    up_vector,
)
from usdsdg.stage.poses.xform_ops import Vector, author_pose

# Sine of the angle between view and up below which the two count as parallel.
_PARALLEL = 1e-9
# Sine below which the cross product of the two has lost so many digits that it is not square to the view.
_CLOSE = 1e-4


def look_at_rotations(
    eyes: ArrayLike, targets: ArrayLike, up: ArrayLike, *, stage_up_axis: str = "Z"
) -> NDArray[np.float64]:
    """Return rotation matrices (N, 3, 3), row vectors, that point -Z at the targets with +Y upwards.

    `eyes` and `targets` are (N, 3) points of one space and `up` is one direction of it, or one per eye. For a view
    along `up` the roll is undefined: as in Replicator the eye then counts as moved slightly along +X (Z-up stages) or
    +Z (Y-up stages), so that a camera above its target shows -X (Z-up) or -Z (Y-up) at the top of the image.

    Raises:
        DegenerateFrame: an eye is at its target, or `up` is the zero vector.
    """
    eyes, targets = np.broadcast_arrays(np.asarray(eyes, np.float64), np.asarray(targets, np.float64))
    ups = np.broadcast_to(np.asarray(up, np.float64), eyes.shape)
    back = eyes - targets
    distance, height = np.linalg.norm(back, axis=-1), np.linalg.norm(ups, axis=-1)
    if not np.all(height > 0):
        raise DegenerateFrame("look_at_up_axis is the zero vector; give a direction such as (0, 0, 1)")
    same = ~(distance > 1e-12 * np.maximum(1.0, np.abs(eyes).max(-1)))
    if same.any():
        raise DegenerateFrame(
            f"a prim at {tuple(eyes[same][0].tolist())} cannot look at its own position; move it or the target"
        )
    back, ups = back / distance[..., None], ups / height[..., None]
    right = np.cross(ups, back)
    for offset in _offsets(stage_up_axis):
        parallel = np.linalg.norm(right, axis=-1) < _PARALLEL
        right[parallel] = np.cross(ups[parallel], offset)
    right = _unit_square_to(back, right)
    return np.stack([right, np.cross(back, right), back], -2)


def _unit_square_to(back: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """Return cross products (N, 3) with unit vectors `back`, normalized, and exactly square to these if short."""
    length = np.linalg.norm(right, axis=-1, keepdims=True)
    unit = right / length
    if (close := length[:, 0] < _CLOSE).any():
        unit[close] -= np.sum(unit[close] * back[close], -1, keepdims=True) * back[close]
        unit[close] /= np.linalg.norm(unit[close], axis=-1, keepdims=True)
    return unit


def look_at_matrix(eye: Vector, target: Vector, *, up: Vector = (0.0, 0.0, 1.0)) -> Gf.Matrix4d:
    """Return the camera-to-world matrix [stage units] of a USD camera (looks along -Z, +Y up) at `eye`.

    Raises:
        DegenerateFrame: eye and target coincide, or the view direction is parallel to `up`.
    """
    eye, target, up = (np.asarray(tuple(vector), np.float64) for vector in (eye, target, up))
    back = eye - target
    distance, height = np.linalg.norm(back), np.linalg.norm(up)
    if not distance > 1e-12 * max(1.0, float(np.abs(eye).max())):
        raise DegenerateFrame(f"a camera at {tuple(eye)} cannot look at its own position; move the eye or the target")
    right = np.cross(up, back) / (height * distance) if height > 0 else np.zeros(3)
    if not np.linalg.norm(right) > _PARALLEL:
        raise DegenerateFrame(
            f"a camera at {tuple(eye)} looking at {tuple(target)} looks along its up direction {tuple(up)}; "
            "choose another up or move the eye sideways"
        )
    back /= distance
    (right,) = _unit_square_to(back[None], right[None])
    matrix = np.eye(4)
    matrix[:3, :3] = right, np.cross(back, right), back
    matrix[3, :3] = eye
    return Gf.Matrix4d(matrix.tolist())


def look_at_quaternions(
    prims: Sequence[Usd.Prim],
    positions: NDArray[np.float64] | None,
    targets: ArrayLike,
    up: ArrayLike,
    time: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> NDArray[np.float64]:
    """Return quaternions (N, 4) xyzw, in the parents' spaces, that point -Z of each prim (or its camera) at a target.

    Args:
        positions: (N, 3) of the prims in their parents' spaces; None for those that they have.
        targets: (N, 3) points of the world.
        up: direction of the world, or one per prim.
        time: at which the parents, and positions that are not given, are read.

    Raises:
        DegenerateFrame: a prim is at its target, or `up` is the zero vector.
    """
    to_world = parents_to_world(prims, time)
    where = local_matrices(prims, time)[:, 3, :3] if positions is None else positions
    eyes = np.einsum("ni,nij->nj", np.c_[where, np.ones(len(prims))], to_world)[:, :3]
    rotations = look_at_rotations(eyes, targets, up, stage_up_axis=up_axis(prims[0].GetStage()))
    for row, prim in enumerate(prims):
        # The camera made by rep.create.camera is rotated against the Xform that carries it.
        made_here = prim.HasAttribute("replicatorXform") or prim.HasAttribute("replicatorCameraXform")
        if made_here and (camera := _camera_in_object(prim)) is not None:
            camera_pose = decompose(as_array(camera)[None])
            rotations[row] = matrix_from_quat(camera_pose.rotation)[0].T @ rotations[row]
    parents = matrix_from_quat(decompose(to_world).rotation)
    return quat_from_matrix(rotations @ parents.transpose(0, 2, 1))


def author_look_at(
    prim: Usd.Prim,
    point: Vector,
    up: Vector | None = None,
    time: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> None:
    """Rotate a prim in place so that its camera child (or its own -Z) looks at a point of the world.

    Args:
        up: direction of the world that is up in the image; None for the stage's up axis.
        time: at which the position of the prim, and what is above it, are read.

    Raises:
        BadPrim: the prim has no transform.
        DegenerateFrame: the prim is at `point`, or `up` is the zero vector.
    """
    upwards = up_vector(prim.GetStage()) if up is None else tuple(up)
    (angles,) = _look_at_angles([prim], [tuple(point)], upwards, time)
    author_pose(prim, rotate_xyz=Gf.Vec3d(*angles.tolist()))


def author_look_ats(prims: Sequence[Usd.Prim], points: ArrayLike, up: ArrayLike, time: Usd.TimeCode) -> None:
    """Do what `author_look_at` does for each of N prims of one stage, none of which is below another one.

    Args:
        points: (N, 3) of the world.
        up: direction of the world, or one per prim.
    """
    author_poses(prims, rotate=Rotations(degrees=_look_at_angles(prims, points, up, time)))


def _look_at_angles(
    prims: Sequence[Usd.Prim], points: ArrayLike, up: ArrayLike, time: Usd.TimeCode
) -> NDArray[np.float64]:
    """Return the angles (N, 3) about x, y, z [degrees] with which prims look at points, for their own rotations.

    They differ from `look_at_quaternions` in the last bits, because whole matrices are inverted and not rotations;
    saved datasets depend on both.
    """
    cache = UsdGeom.XformCache(time)
    eyes = [cache.GetLocalToWorldTransform(prim).ExtractTranslation() for prim in prims]
    turns = look_at_rotations(
        [tuple(eye) for eye in eyes], points, up, stage_up_axis=up_axis(prims[0].GetStage())
    ).reshape(-1, 9)
    matrices = []
    for prim, eye, turn in zip(prims, eyes, turns.tolist(), strict=True):
        to_world = Gf.Matrix4d(Gf.Matrix3d(*turn), eye)
        # The child camera of a Replicator camera object is rotated against the object; undo that rotation.
        if (camera := _camera_in_object(prim)) is not None:
            to_world = camera.GetInverse() * to_world
        matrices.append(as_array(to_world * parent_in(cache, prim).GetInverse()))
    return euler_xyz_from_quat(decompose(np.stack(matrices)).rotation)


def _camera_in_object(prim: Usd.Prim) -> Gf.Matrix4d | None:
    """Return the pose in `prim` of the camera that is its child, or of the left one of a stereo pair, if any."""
    camera = next((child for child in prim.GetChildren() if child.IsA(UsdGeom.Camera)), None)
    if camera is not None:
        return UsdGeom.Xformable(camera).GetLocalTransformation()
    if not (pair := stereo_pair(prim)):
        return None
    camera = prim.GetStage().GetPrimAtPath(pair[0])
    inner, outer = (UsdGeom.Xformable(each).GetLocalTransformation() for each in (camera, camera.GetParent()))
    return inner * outer


def _offsets(stage_up_axis: str) -> NDArray[np.float64]:
    """Return the directions in which to move an eye that looks along `up`; the second for an `up` along the first."""
    x, z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    return np.array([z, x] if stage_up_axis == "Y" else [x, z])
