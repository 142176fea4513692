"""`RigidBodyMaterial`: friction and restitution."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdPhysics, UsdShade

from usdsdg.compat.isaacsim.core.experimental.materials.material import Material
from usdsdg.compat.wrappers import bodies, prim_paths
from usdsdg.compat.wrappers.arrays import as_warp, column, names
from usdsdg.stage.schemas import physx

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values

PrimOrPath = str | Usd.Prim


class PhysicsMaterial(Material):
    """Materials for physics."""

    @classmethod
    def are_of_type(cls, paths: PrimOrPath | Sequence[PrimOrPath]) -> wp.array:
        """Return which prims are materials for physics (N, 1)."""
        return as_warp(np.array([[_is_physics(prim_paths.prim_of(each))] for each in _listed(paths)], bool))

    @staticmethod
    def fetch_instances(paths: PrimOrPath | Sequence[PrimOrPath]) -> list[PhysicsMaterial | None]:
        """Return a wrapper of each material for physics; None for other prims."""
        prims = [prim_paths.prim_of(each) for each in _listed(paths)]
        return [RigidBodyMaterial(str(prim.GetPath())) if _is_physics(prim) else None for prim in prims]


class RigidBodyMaterial(PhysicsMaterial):
    """Friction, restitution and density of colliders."""

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        static_frictions: Values | None = None,
        dynamic_frictions: Values | None = None,
        restitutions: Values | None = None,
        densities: Values | None = None,
    ) -> None:
        """Wrap materials, or define them.

        Raises:
            AssertionError: a prim is no material.
            ValueError: some prims exist and others do not.
        """
        super().__init__(paths)
        for prim in self.prims:
            UsdPhysics.MaterialAPI.Apply(prim)
            physx.PhysxMaterialAPI.Apply(prim)
        if static_frictions is not None or dynamic_frictions is not None:
            self.set_friction_coefficients(static_frictions, dynamic_frictions)
        if restitutions is not None:
            self.set_restitution_coefficients(restitutions)
        if densities is not None:
            self.set_densities(densities)

    def set_friction_coefficients(
        self,
        static_frictions: Values | None = None,
        dynamic_frictions: Values | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Set static or dynamic friction (N, 1).

        Raises:
            AssertionError: neither is given.
        """
        if static_frictions is None and dynamic_frictions is None:
            raise AssertionError("give static_frictions or dynamic_frictions")
        for name, values in (("StaticFriction", static_frictions), ("DynamicFriction", dynamic_frictions)):
            if values is not None:
                self._write(name, values, indices)

    def get_friction_coefficients(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return static and dynamic friction (N, 1)."""
        api = UsdPhysics.MaterialAPI
        return self._read(api.GetStaticFrictionAttr, indices), self._read(api.GetDynamicFrictionAttr, indices)

    def set_restitution_coefficients(self, restitutions: Values, *, indices: Indices = None) -> None:
        self._write("Restitution", restitutions, indices)

    def get_restitution_coefficients(self, *, indices: Indices = None) -> wp.array:
        return self._read(UsdPhysics.MaterialAPI.GetRestitutionAttr, indices)

    def set_densities(self, densities: Values, *, indices: Indices = None) -> None:
        """Set densities (N, 1) [mass units per cubic stage unit]."""
        self._write("Density", densities, indices)

    def get_densities(self, *, indices: Indices = None) -> wp.array:
        """Return densities (N, 1) [mass units per cubic stage unit]."""
        return self._read(UsdPhysics.MaterialAPI.GetDensityAttr, indices)

    def set_combine_modes(
        self,
        frictions: str | Sequence[str] | None = None,
        restitutions: str | Sequence[str] | None = None,
        dampings: str | Sequence[str] | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Author how two materials combine: "average", "min", "multiply" or "max"."""
        prims = self._chosen(indices)
        for name, values in (("Friction", frictions), ("Restitution", restitutions), ("Damping", dampings)):
            if values is not None:
                bodies.write(prims, physx.PhysxMaterialAPI, f"{name}CombineMode", names(values, len(prims)))

    def _write(self, name: str, values: Values, indices: Indices) -> None:
        prims = self._chosen(indices)
        bodies.write(prims, UsdPhysics.MaterialAPI, name, column(values, len(prims)))

    def _read(self, attribute: object, indices: Indices) -> wp.array:
        return self._warp(bodies.read(self._chosen(indices), UsdPhysics.MaterialAPI, attribute, 0.0))  # pyright: ignore[reportArgumentType]


def _is_physics(prim: Usd.Prim) -> bool:
    return bool(prim) and prim.IsA(UsdShade.Material) and prim.HasAPI(UsdPhysics.MaterialAPI)


def _listed(paths: PrimOrPath | Sequence[PrimOrPath]) -> list[PrimOrPath]:
    return list(paths) if isinstance(paths, (list, tuple)) else [paths]  # pyright: ignore[reportReturnType]
