"""Switch colliders on and off, and move those that are static."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.corrections.overlaps.depenetration import Depenetration
from usdsdg_physics.model.build import COLLIDES, DISABLED
from usdsdg_physics.scene.records import Scene
from usdsdg_physics.world.static_motion import StaticMotion

if TYPE_CHECKING:
    import newton


class Colliders:
    """The colliders of a world, by the index of their shape."""

    def __init__(
        self, scene: Scene, model: newton.Model, shape_index: Mapping[str, int], depenetration: Depenetration
    ) -> None:
        self._model, self._depenetration = model, depenetration
        self.motion = StaticMotion(scene, shape_index)
        self._triggers = {shape_index[each.path] for each in scene.colliders.values() if each.trigger}

    def enable(self, enabled: Mapping[int, bool]) -> None:
        """Switch colliders on or off; triggers are never solid."""
        if not enabled:
            return
        # The broad phase reads the collision group at every step, the shape's flags only when it is built.
        groups = self._model.shape_collision_group.numpy().copy()
        self._depenetration.activate([index for index, on in enabled.items() if on and groups[index] == DISABLED])
        self._depenetration.deactivate([index for index, on in enabled.items() if not on])
        for index, on in enabled.items():
            groups[index] = COLLIDES if on and index not in self._triggers else DISABLED
        self._model.shape_collision_group.assign(groups)

    def set_poses(self, poses: Mapping[int, Sequence[float]]) -> None:
        """Move static colliders (7 numbers, world)."""
        if not poses:
            return
        transforms = self._model.shape_transform.numpy().reshape(-1, 7).copy()
        for index, pose in poses.items():
            self.motion.note(index, transforms[index], np.asarray(pose))
            transforms[index] = pose
        self._model.shape_transform.assign(transforms)
        enabled = self._model.shape_collision_group.numpy() == COLLIDES
        self._depenetration.activate([index for index in poses if enabled[index]])
