"""The behavior that randomizes where prims are."""

from __future__ import annotations

import logging
from typing import ClassVar

from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.compat.isaacsim.replicator.behavior.base_behavior import INTERVAL, Variable, variable
from usdsdg.compat.isaacsim.replicator.behavior.prims_behavior import INCLUDE_CHILDREN, SEED, RandomBehavior
from usdsdg.compat.isaacsim.replicator.behavior.utils.scene_utils import get_world_location

_T = Sdf.ValueTypeNames
_log = logging.getLogger("usdsdg.script")


class LocationRandomizer(RandomBehavior):
    """Adds a random offset to the translation of each prim, from where it was or from another prim.

    Offsets are written as local translations, also those from the world position of the other prim.
    """

    BEHAVIOR_NS: ClassVar[str] = "locationRandomizer"
    VARIABLES_TO_EXPOSE: ClassVar[list[Variable]] = [
        variable("range:minPosition", _T.Vector3d, Gf.Vec3d(-1.0), "Smallest offset."),
        variable("range:maxPosition", _T.Vector3d, Gf.Vec3d(1.0), "Largest offset."),
        variable("frame:useRelativeFrame", _T.Bool, True, "Keep the offset that the prim had from its origin."),
        variable("frame:targetPrimPath", _T.String, "", "Path of a prim that is the origin; empty for none."),
        INCLUDE_CHILDREN,
        INTERVAL,
        SEED,
    ]

    def on_init(self) -> None:
        self._before: dict[Usd.Prim, Gf.Vec3d] = {}
        self._from_target: dict[Usd.Prim, Gf.Vec3d] = {}
        super().on_init()

    def _read_variables(self) -> None:
        self._min_position = self._get_exposed_variable("range:minPosition")
        self._max_position = self._get_exposed_variable("range:maxPosition")
        self._relative = self._get_exposed_variable("frame:useRelativeFrame")

    def _begin(self) -> None:
        self._target = self._prim_at(self._get_exposed_variable("frame:targetPrimPath"))
        super()._begin()

    def _remember(self, prim: Usd.Prim) -> None:
        self._before[prim] = _location(prim)
        if self._target:
            self._from_target[prim] = self._before[prim] - get_world_location(self._target)

    def _restore(self, prim: Usd.Prim) -> None:
        if (location := self._before.pop(prim, None)) is not None:
            _set_location(prim, location)

    def _apply_behavior(self) -> None:
        for prim in self._valid_prims:
            offset = Gf.Vec3d(*(self._rng.uniform(a, b) for a, b in zip(self._min_position, self._max_position)))
            _set_location(prim, self._origin(prim) + offset)

    def _origin(self, prim: Usd.Prim) -> Gf.Vec3d:
        if self._target:
            at = get_world_location(self._target)
            return at + self._from_target[prim] if self._relative else at
        return self._before[prim] if self._relative else Gf.Vec3d(0.0)


def _location_op(prim: Usd.Prim) -> UsdGeom.XformOp | None:
    names = ("xformOp:translate", "xformOp:transform")
    return next((op for op in UsdGeom.Xformable(prim).GetOrderedXformOps() if op.GetOpName() in names), None)


def _location(prim: Usd.Prim) -> Gf.Vec3d:
    """Return the translation of a prim's first translating op; a prim without one gets a translation of zero."""
    op = _location_op(prim)
    if op is None:
        UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(0.0))
        return Gf.Vec3d(0.0)
    value = op.Get()
    return value.ExtractTranslation() if isinstance(value, Gf.Matrix4d) else Gf.Vec3d(value or Gf.Vec3d(0.0))


def _set_location(prim: Usd.Prim, location: Gf.Vec3d) -> None:
    op = _location_op(prim)
    if op is None:
        _log.warning("%s has no translation to set", prim.GetPath())
    elif op.GetOpType() == UsdGeom.XformOp.TypeTransform:
        op.Set(Gf.Matrix4d(op.Get()).SetTranslateOnly(location))
    else:
        op.Set(location if op.GetPrecision() == UsdGeom.XformOp.PrecisionDouble else Gf.Vec3f(location))
