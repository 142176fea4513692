"""The behavior that randomizes how prims are rotated."""

from __future__ import annotations

from typing import ClassVar

from pxr import Gf, Sdf, Usd

from usdsdg.compat.isaacsim.replicator.behavior.base_behavior import INTERVAL, Variable, variable
from usdsdg.compat.isaacsim.replicator.behavior.prims_behavior import INCLUDE_CHILDREN, SEED, RandomBehavior
from usdsdg.compat.isaacsim.replicator.behavior.utils.scene_utils import (
    Rotation,
    get_rotation_op_and_value,
    set_rotation_op_and_value,
    set_rotation_with_ops,
)

_T = Sdf.ValueTypeNames


class RotationRandomizer(RandomBehavior):
    """Draws the local rotation of each prim: angles about x, then y, then z."""

    BEHAVIOR_NS: ClassVar[str] = "rotationRandomizer"
    VARIABLES_TO_EXPOSE: ClassVar[list[Variable]] = [
        variable("range:minRotation", _T.Vector3d, Gf.Vec3d(0.0), "Smallest angles about x, y and z [degrees]."),
        variable("range:maxRotation", _T.Vector3d, Gf.Vec3d(360.0), "Largest angles about x, y and z [degrees]."),
        INCLUDE_CHILDREN,
        INTERVAL,
        SEED,
    ]

    def on_init(self) -> None:
        self._before: dict[Usd.Prim, tuple[str, Rotation]] = {}
        super().on_init()

    def _read_variables(self) -> None:
        self._min_rotation = self._get_exposed_variable("range:minRotation")
        self._max_rotation = self._get_exposed_variable("range:maxRotation")

    def _remember(self, prim: Usd.Prim) -> None:
        self._before[prim] = get_rotation_op_and_value(prim)

    def _restore(self, prim: Usd.Prim) -> None:
        if before := self._before.pop(prim, None):
            set_rotation_op_and_value(prim, *before)

    def _apply_behavior(self) -> None:
        for prim in self._valid_prims:
            rotation = Gf.Rotation().SetIdentity()
            for axis in range(3):
                angle = self._rng.uniform(self._min_rotation[axis], self._max_rotation[axis])
                rotation *= Gf.Rotation(Gf.Vec3d.Axis(axis), angle)
            set_rotation_with_ops(prim, rotation)
