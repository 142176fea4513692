"""Poses of prims as rows of numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import prim_at
from usdsdg.stage.poses.rotations import euler_from_matrix, matrix_from_euler, matrix_from_quat, quat_from_matrix
from usdsdg.stage.poses.world_poses import author_world_pose, world_poses

Array = NDArray[np.float64]


def prims_at(paths: Sequence[str]) -> list[Usd.Prim]:
    """Return the prims at paths of the current stage."""
    return [prim_at(current_stage(), path) for path in paths]


def positions(prims: Sequence[Usd.Prim]) -> Array:
    """Return positions (N, 3) in the world [stage units]."""
    return world_poses(prims)[0]


def set_positions(prims: Sequence[Usd.Prim], values: Array) -> None:
    """Move prims in the world; rotations stay."""
    for prim, at, quat in zip(prims, values, world_poses(prims)[1], strict=True):
        author_world_pose(prim, at, quat)


def orientations(prims: Sequence[Usd.Prim]) -> Array:
    """Return angles (N, 3) about the world's x, y and z [rad], applied in this order."""
    return np.radians(euler_from_matrix(matrix_from_quat(world_poses(prims)[1]), "XYZ"))


def set_orientations(prims: Sequence[Usd.Prim], values: Array) -> None:
    """Rotate prims in the world as `orientations` says; positions stay."""
    quats = quat_from_matrix(matrix_from_euler(np.degrees(values), "XYZ"))
    for prim, at, quat in zip(prims, world_poses(prims)[0], quats, strict=True):
        author_world_pose(prim, at, quat)
