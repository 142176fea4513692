"""Poses of the bodies that time samples move."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg_physics.edits.subtrees import nearly_equal
from usdsdg_physics.scene.records import Scene
from usdsdg_physics.scene.rigid_frames import body_from_prim, rigid_pose


class TimeSamples:
    """Reads the poses of the animated bodies of one scene."""

    def __init__(self, stage: Usd.Stage, scene: Scene, meters_per_unit: float) -> None:
        self._stage, self._scene, self._meters_per_unit = stage, scene, meters_per_unit
        rows = {path: row for row, path in enumerate(scene.bodies)} if scene.animated else {}
        self._rows = {path: rows[path] for path in scene.animated}

    def poses_at(self, time: Usd.TimeCode, poses: np.ndarray) -> np.ndarray:
        """Return poses (N, 7) [m] of all bodies of the scene, with those that time samples move at a time."""
        found, cache = np.array(poses, np.float64), UsdGeom.XformCache(time)
        constant: dict[str, np.ndarray] = {}
        for path, row in self._rows.items():
            matrix = np.array(cache.GetLocalToWorldTransform(self._stage.GetPrimAtPath(path)))
            if not np.isfinite(matrix).all():
                warn_once(
                    f"{path}: its time samples are not finite at {time.GetValue():g}, so it stays where it was before."
                )
                continue
            found[row] = rigid_pose(matrix, self._meters_per_unit)
            constant[path] = body_from_prim(matrix, self._meters_per_unit)
        self._warn_if_rescaled(constant)
        return found

    def _warn_if_rescaled(self, constant: dict[str, np.ndarray]) -> None:
        """Name a body of which the matrix to its frame, constant while a prim is moved and turned, has changed."""
        first = [self._scene.bodies[path].body_from_prim for path in constant]
        if constant and not nearly_equal(list(constant.values()), first):
            path = next(path for path, then in zip(constant, first) if not nearly_equal(constant[path], then))
            warn_once(
                f"{path}: time samples change its scale, which its collider does not follow: it keeps the size that it "
                "had when the simulation began. Move and turn it only, or simulate without it."
            )
