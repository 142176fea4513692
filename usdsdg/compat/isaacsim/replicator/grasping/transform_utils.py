"""`isaacsim.replicator.grasping.transform_utils`: poses of prims and of grasps."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Gf, Usd

from usdsdg.compat.isaacsim.replicator.prim_poses import (
    set_location,
    set_orientation,
    set_rotation,
    set_scale,
    set_transform_attributes,
    set_transform_matrix,
)
from usdsdg.stage.poses.transforms import local_to_world

__all__ = [
    "get_prim_world_pose", "set_location", "set_orientation", "set_rotation", "set_scale", "set_transform_attributes",
    "set_transform_matrix", "transform_local_pose_to_world", "transform_local_poses_to_world",
]  # fmt: skip

Pose = tuple[Gf.Vec3d, Gf.Quatd]


def get_prim_world_pose(prim: Usd.Prim) -> Pose:
    """Return position [stage units] and rotation of a prim in the world, without its scale."""
    matrix = local_to_world(prim).RemoveScaleShear()
    return matrix.ExtractTranslation(), matrix.ExtractRotationQuat()


def transform_local_pose_to_world(pose: Pose, prim: Usd.Prim) -> Pose:
    """Return a pose that is relative to a prim, without the prim's scale, in the world."""
    matrix = local_to_world(prim).RemoveScaleShear()
    return matrix.Transform(pose[0]), matrix.ExtractRotationQuat() * pose[1]


def transform_local_poses_to_world(poses: Sequence[Pose], prim: Usd.Prim) -> list[Pose]:
    """Return poses that are relative to a prim, without the prim's scale, in the world."""
    return [transform_local_pose_to_world(pose, prim) for pose in poses]
