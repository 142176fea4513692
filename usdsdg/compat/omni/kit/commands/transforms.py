"""Commands that place prims."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.compat.omni.kit.commands.registry import command
from usdsdg.errors import BadPrim
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.poses.rotations import decompose, euler_from_matrix, matrix_from_euler
from usdsdg.stage.poses.transforms import as_array, inverse_of_parent
from usdsdg.stage.poses.xform_ops import author_pose, gf_quat

AnyPath = str | Sdf.Path


@command("TransformPrim")
def transform_prim(
    path: AnyPath,
    new_transform_matrix: Gf.Matrix4d,
    time_code: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> None:
    """Set the local matrix of a prim in the ops that it has; a shear, which ops cannot hold, is left out."""
    _set_local_matrix(_prim("TransformPrim", path), Gf.Matrix4d(new_transform_matrix))


@command("TransformPrimSRT")
def transform_prim_srt(
    path: AnyPath,
    new_translation: Sequence[float] | None = None,
    new_rotation_euler: Sequence[float] | None = None,
    new_rotation_order: Sequence[int] | None = None,
    new_scale: Sequence[float] | None = None,
    time_code: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> None:
    """Set position, rotation [degrees] and scale of a prim, those that are given.

    Args:
        new_rotation_order: The axes in the order in which they turn, (0, 1, 2) for x first.
    """
    prim = _prim("TransformPrimSRT", path)
    euler = None
    if new_rotation_euler is not None:
        order = "".join("XYZ"[axis] for axis in (new_rotation_order or (0, 1, 2)))
        euler = euler_from_matrix(matrix_from_euler(np.asarray(tuple(new_rotation_euler), float), order))
    author_pose(prim, translate=new_translation, rotate_xyz=euler, scale=new_scale)


@command("TransformPrims")
def transform_prims(
    prims_to_transform: Sequence[Sequence[Any]],
    time_code: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> None:
    """Set the local matrices of prims, given as (path, new matrix, ...)."""
    for path, matrix, *_ in prims_to_transform:
        transform_prim(path, matrix, time_code)


@command("TransformPrimsSRT")
def transform_prims_srt(
    prims_to_transform: Sequence[Sequence[Any]],
    time_code: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> None:
    """Set the poses of prims, given as (path, translation, rotation [degrees], order of its axes, scale, ...)."""
    for path, translation, rotation, order, scale, *_ in prims_to_transform:
        transform_prim_srt(path, translation, rotation, order, scale, time_code)


@command("IsaacSimTeleportPrim")
def teleport_prim(
    prim_path: AnyPath,
    translation: Sequence[float] | None = (0.0, 0.0, 0.0),
    rotation: Sequence[float] | None = (0.0, 0.0, 0.0, 1.0),
) -> None:
    """Set the local position and rotation, a quaternion (x, y, z, w), of a prim; where one is None, neither is set."""
    if translation is None or rotation is None:
        return
    x, y, z, w = (float(each) for each in rotation)
    orient = Gf.Quatd(w, Gf.Vec3d(x, y, z))
    author_pose(_prim("IsaacSimTeleportPrim", prim_path), translate=translation, orient=orient)


@command("IsaacSimScalePrim")
def scale_prim(prim_path: AnyPath, scale: Sequence[float] | None = (1.0, 1.0, 1.0)) -> None:
    """Set the scale of a prim, unless it is None."""
    if scale is not None:
        author_pose(_prim("IsaacSimScalePrim", prim_path), scale=scale)


def set_world_matrix(prim: Usd.Prim, matrix: Gf.Matrix4d) -> None:
    """Place a prim in the world, in the ops that it has.

    Raises:
        DegenerateFrame: an ancestor is scaled to zero.
    """
    _set_local_matrix(prim, matrix * inverse_of_parent(prim))


def _set_local_matrix(prim: Usd.Prim, matrix: Gf.Matrix4d) -> None:
    pose = decompose(as_array(matrix))
    author_pose(prim, translate=pose.translate, orient=gf_quat(pose.rotation), scale=pose.scale)


def _prim(caller: str, path: AnyPath) -> Usd.Prim:
    prim = current_stage().GetPrimAtPath(str(path))
    if not prim or not prim.IsA(UsdGeom.Xformable):
        raise BadPrim(f"{caller}: {path} is {'not on the stage' if not prim else 'a prim without a transform'}")
    return prim
