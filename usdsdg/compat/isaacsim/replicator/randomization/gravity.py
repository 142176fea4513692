"""The gravity of the PhysicsScene as a row of numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, UsdPhysics

from usdsdg.session.stage_context import current_stage
from usdsdg.stage.physics import scenes
from usdsdg.stage.poses.transforms import meters_per_unit, up_axis

Array = NDArray[np.float64]


class SceneGravity:
    """Gravity [stage units/s²], as one row."""

    paths: tuple[str, ...] = ("the PhysicsScene",)

    def read(self, attribute: str) -> Array:
        """Return the gravity (1, 3); where it is not authored, the earth's."""
        stage = current_stage()
        prim = scenes.physics_scene(stage)
        scene = UsdPhysics.Scene(prim) if prim else None
        direction = np.array(scene.GetGravityDirectionAttr().Get() if scene else (0, 0, 0), np.float64)
        magnitude = float(scene.GetGravityMagnitudeAttr().Get() if scene else -np.inf)
        if not direction.any():
            direction = -np.eye(3)["XYZ".index(up_axis(stage))]
        if not np.isfinite(magnitude) or magnitude < 0.0:
            magnitude = scenes.EARTH_GRAVITY / meters_per_unit(stage)
        return (direction / np.linalg.norm(direction) * magnitude)[None]

    def write(self, attribute: str, rows: Sequence[int], values: Array) -> None:
        """Set the gravity; there is one, so the first of several values (n, 3) counts."""
        scene = UsdPhysics.Scene(scenes.needed_physics_scene(current_stage()))
        magnitude = float(np.linalg.norm(values[0]))
        if magnitude > 0.0:
            scene.CreateGravityDirectionAttr().Set(Gf.Vec3f(*(values[0] / magnitude).tolist()))
        scene.CreateGravityMagnitudeAttr().Set(magnitude)
