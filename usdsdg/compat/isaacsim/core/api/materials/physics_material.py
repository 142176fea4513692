"""`PhysicsMaterial`: friction and restitution of colliders."""

from __future__ import annotations

from pxr import Usd, UsdPhysics, UsdShade

from usdsdg.compat import used_stage
from usdsdg.compat.wrappers.prim_paths import prim_of
from usdsdg.stage.schemas import physx


class PhysicsMaterial:
    """One material for physics."""

    def __init__(
        self,
        prim_path: str,
        name: str = "physics_material",
        static_friction: float | None = None,
        dynamic_friction: float | None = None,
        restitution: float | None = None,
    ) -> None:
        """Wrap the material at a path, or define it."""
        prim = prim_of(prim_path) or UsdShade.Material.Define(used_stage.current_stage(), prim_path).GetPrim()
        self._name, self._prim = name, prim
        self._api = UsdPhysics.MaterialAPI.Apply(prim)
        physx.PhysxMaterialAPI.Apply(prim)
        if static_friction is not None:
            self.set_static_friction(static_friction)
        if dynamic_friction is not None:
            self.set_dynamic_friction(dynamic_friction)
        if restitution is not None:
            self.set_restitution(restitution)

    @property
    def name(self) -> str:
        return self._name

    @property
    def prim_path(self) -> str:
        return str(self._prim.GetPath())

    @property
    def prim(self) -> Usd.Prim:
        return self._prim

    @property
    def material(self) -> UsdShade.Material:
        return UsdShade.Material(self._prim)

    def set_static_friction(self, friction: float) -> None:
        self._api.CreateStaticFrictionAttr().Set(float(friction))

    def get_static_friction(self) -> float:
        return self._api.GetStaticFrictionAttr().Get()

    def set_dynamic_friction(self, friction: float) -> None:
        self._api.CreateDynamicFrictionAttr().Set(float(friction))

    def get_dynamic_friction(self) -> float:
        return self._api.GetDynamicFrictionAttr().Get()

    def set_restitution(self, restitution: float) -> None:
        self._api.CreateRestitutionAttr().Set(float(restitution))

    def get_restitution(self) -> float:
        return self._api.GetRestitutionAttr().Get()
