"""Poses that are given in the space of other prims."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from usdsdg.stage.poses.pose_batch import Rotations
from usdsdg.stage.poses.rotations import decompose
from usdsdg.stage.poses.transforms import as_array, inverses_of_parents, local_to_world

Array = NDArray[np.float64]


def relative_to_parents(
    prims: Sequence[Usd.Prim],
    frames: Sequence[Usd.Prim],
    translate: Array | None,
    rotate: Rotations | None,
    scale: Array | None,
) -> tuple[Array | None, Rotations | None, Array | None]:
    """Convert poses from the spaces of `frames`, one per prim, to those of the prims' parents; None stays None.

    Raises:
        DegenerateFrame: an ancestor of a prim is scaled to zero.
    """
    poses = np.tile(np.eye(4), (len(prims), 1, 1))
    if rotate is not None:
        poses[:, :3, :3] = rotate.matrices()
    if scale is not None:
        poses[:, :3, :3] = scale[:, :, None] * poses[:, :3, :3]
    if translate is not None:
        poses[:, 3, :3] = translate
    to_world = np.stack([as_array(local_to_world(frame)) for frame in frames])
    pose = decompose(poses @ to_world @ inverses_of_parents(prims))
    return (
        None if translate is None else pose.translate,
        None if rotate is None else Rotations(quats=pose.rotation),
        None if scale is None else pose.scale,
    )
